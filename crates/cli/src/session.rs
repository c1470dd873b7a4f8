//! Flags of every command, start of a run, and end of its printed report.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_mpi::World;
use gfmd_problem::key;
use gfmd_record::Sheet;
use gfmd_vector::Ranks;
use tracing::level_filters::LevelFilter;

use crate::processes;

/// Flags of every command.
#[derive(Args, Clone, Copy, Debug)]
pub struct Common {
    /// Print exactly one JSON object on stdout instead of a table
    #[arg(long, global = true)]
    pub json: bool,
    /// Print all table columns; by default the most important ones that fit in 80 characters
    #[arg(long, global = true)]
    pub wide: bool,
    /// Number of threads; 0 uses all cores. Results do not depend on it
    #[arg(long, global = true, default_value_t = 0, value_name = "N")]
    pub threads: usize,
    /// Print errors only: no progress, no notes
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print details on stderr; repeat for more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Largest number of threads on a machine with few cores. Each thread has its own stack and workspaces.
const MOST_THREADS: usize = 256;

/// Stack of each thread in bytes, as large as the stack of a process: commands run on one of the threads.
const STACK: usize = 8 << 20;

/// Sets up threads, log and the handler of Ctrl-C, once per process. The process is alone or one of a `world` of
/// several; only the first one prints.
///
/// # Errors
/// Returns an error if there are more threads than allowed or than the system can start.
pub fn start(common: Common, world: Option<&Arc<World>>) -> Result<Session, Failure> {
    let is_first = world.is_none_or(|world| world.rank() == 0);
    let quiet = common.quiet || !is_first;
    let most = MOST_THREADS.max(2 * std::thread::available_parallelism().map_or(1, usize::from));
    if common.threads > most {
        return Err(Failure::value(key("threads"), common.threads, format!("at most {most}, or 0 for all cores")));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(common.threads)
        .stack_size(STACK)
        .build_global()
        .map_err(|error| Failure::input(key("threads"), error))?;
    let level = match (quiet, common.verbose) {
        _ if !is_first => LevelFilter::OFF,
        (true, _) => LevelFilter::ERROR,
        (_, 0) => LevelFilter::INFO,
        (_, 1) => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_max_level(level)
        .with_target(false)
        .without_time()
        // A log that cannot be written, e.g. on a full disk, ends no run.
        .log_internal_errors(false)
        .with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr()))
        .init();
    if let Some(world) = world {
        let threads = rayon::current_num_threads();
        tracing::info!("{} processes, threads of each: {threads}; {}", world.size(), world.version());
    }
    let mut session = Session::silent();
    (session.quiet, session.json, session.wide) = (quiet, common.json, common.wide);
    let session = match world {
        Some(world) => session.together(Arc::clone(world) as Arc<dyn Ranks>, processes::on_this_machine()),
        None => session,
    };
    let asked = session.clone();
    // A second Ctrl-C ends the process at once.
    let handler = move || {
        if asked.interrupt() {
            std::process::exit(130);
        }
    };
    ctrlc::set_handler(handler).map_err(|error| Failure::computation(format!("cannot catch Ctrl-C: {error}")))?;
    Ok(session)
}

/// Prints a table whose lines have a `margin` before them and a `remark` behind them, both by the number of the line, 0
/// for the heads; then the columns that were left out.
pub fn print_sheet(
    f: &mut fmt::Formatter,
    sheet: impl FnOnce(Option<usize>) -> Sheet,
    rows: usize,
    margin: impl Fn(usize) -> String,
    remark: impl Fn(usize) -> String,
) -> fmt::Result {
    let length = |of: &dyn Fn(usize) -> String| (0..=rows).map(|line| of(line).chars().count()).max().unwrap_or(0);
    let around = length(&margin) + length(&remark);
    let sheet = sheet(f.width().map(|width| width.saturating_sub(around)));
    for (index, line) in sheet.lines.iter().enumerate() {
        writeln!(f, "{}{line}{}", margin(index), remark(index))?;
    }
    sheet.footnote().map_or(Ok(()), |footnote| print_note(f, &footnote))
}

/// Prints a note below a table in lines no longer than the table may be.
pub fn print_note(f: &mut fmt::Formatter, note: &str) -> fmt::Result {
    wrapped(note, f.width().unwrap_or(usize::MAX)).iter().try_for_each(|line| writeln!(f, "{line}"))
}

/// Breaks a text into lines of at most `width` characters, between words.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= width) {
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Writes the end of a printed report: the files written and drawn, one per line.
pub fn list_files(f: &mut fmt::Formatter, out: Option<&Path>, plots: &[PathBuf]) -> fmt::Result {
    if let Some(out) = out {
        writeln!(f, "\nwritten: {}", out.display())?;
    }
    plots.iter().try_for_each(|plot| writeln!(f, "drawn:   {}", plot.display()))
}
