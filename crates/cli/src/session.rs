//! One run of the program: the flags that all commands have in common, interruption, and the machine.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use gfmd_contact::{Contact, Refusal};
use gfmd_field::{Grid, Share};
use gfmd_files::legible::line;
use gfmd_files::{Memory, Output, Provenance, Warning, Warnings};
use gfmd_mpi::World;
use gfmd_vector::Ranks;
use serde::Serialize;
use tracing::level_filters::LevelFilter;

use crate::failure::Failure;
use crate::memory::Processes;
use crate::processes;

/// The commit that the program was built from, `unknown` if it is not known.
pub const GIT_COMMIT: &str = env!("GFMD_GIT_COMMIT");

/// Flags of every command.
#[derive(Args, Clone, Copy, Debug)]
pub struct Common {
    /// Print exactly one JSON object on stdout instead of a table
    #[arg(long, global = true)]
    pub json: bool,
    /// Number of threads; 0 takes all cores. Results do not depend on it
    #[arg(long, global = true, default_value_t = 0, value_name = "N")]
    pub threads: usize,
    /// Print errors only: no progress, no notes
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print details on stderr; give it twice for still more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// The largest number of threads on a machine with fewer cores. Each has a stack and workspaces of its own.
const MOST_THREADS: usize = 256;

/// The stack of each in bytes, as large as that of a process: commands run on one of them.
const STACK: usize = 8 << 20;

/// The number of the format of journals: another one cannot be continued.
const JOURNAL: u32 = 2;

/// A run of the program.
#[derive(Clone)]
pub struct Session {
    /// The flags of every command.
    pub common: Common,
    interrupted: Arc<AtomicBool>,
    warnings: Warnings,
    /// The place of results that are kept in memory.
    memory: Option<Memory>,
    /// The processes that run the command together.
    ranks: Option<Arc<dyn Ranks>>,
}

impl Session {
    /// Sets up threads, log and the handler of Ctrl-C, once for the process, which is one of a `world` of several or alone. Only
    /// the first one prints.
    ///
    /// # Errors
    /// More threads than the system can start.
    pub fn start(mut common: Common, world: Option<&Arc<World>>) -> Result<Self, Failure> {
        let is_first = world.is_none_or(|world| world.rank() == 0);
        common.quiet |= !is_first;
        let most = MOST_THREADS.max(2 * std::thread::available_parallelism().map_or(1, usize::from));
        if common.threads > most {
            return Err(Failure::value("--threads", common.threads, format!("at most {most}, or 0 for all cores")));
        }
        rayon::ThreadPoolBuilder::new()
            .num_threads(common.threads)
            .stack_size(STACK)
            .build_global()
            .map_err(|error| Failure::input("--threads", error))?;
        let level = match (common.quiet, common.verbose) {
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
            .with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr()))
            .init();
        let ranks = world.map(|world| Arc::clone(world) as Arc<dyn Ranks>);
        if let Some(world) = world {
            let threads = rayon::current_num_threads();
            tracing::info!("{} processes, threads of each: {threads}; {}", world.size(), world.version());
        }
        let session = Self { ranks, ..Self::silent(common) };
        let flag = Arc::clone(&session.interrupted);
        // The second Ctrl-C ends the process at once.
        let handler = move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        ctrlc::set_handler(handler).map_err(|error| Failure::Computation(format!("cannot catch Ctrl-C: {error}")))?;
        Ok(session)
    }

    /// A session without global effects, for callers of the commands as a library.
    pub fn silent(common: Common) -> Self {
        let interrupted = Arc::new(AtomicBool::new(false));
        Self { common, interrupted, warnings: Warnings::default(), memory: None, ranks: None }
    }

    /// The processes that run this command together, if there is more than one.
    pub fn ranks(&self) -> Option<&Arc<dyn Ranks>> {
        self.ranks.as_ref()
    }

    /// The processes that run this command together, on this machine as far as their launcher tells.
    pub(crate) fn processes(&self) -> Processes {
        let Some(ranks) = &self.ranks else { return Processes::ALONE };
        Processes { here: processes::on_this_machine().min(ranks.size()), all: ranks.size() }
    }

    /// The rows of a grid that this process has, all of them if it is alone.
    ///
    /// # Errors
    /// More processes than can share the rows.
    pub(crate) fn share(&self, grid: &Grid) -> Result<Share, Refusal> {
        match &self.ranks {
            Some(ranks) => Contact::share(Arc::clone(ranks), grid),
            None => Ok(grid.whole()),
        }
    }

    /// The largest of the numbers of all processes.
    pub(crate) fn largest(&self, own: u64) -> u64 {
        let Some(ranks) = &self.ranks else { return own };
        let mut all = vec![0; ranks.size()];
        ranks.gather(&[own], &mut all, &vec![1; ranks.size()]);
        all.into_iter().max().unwrap_or(own)
    }

    /// True if this process prints, writes and draws: it is alone, or the first one.
    pub fn is_first(&self) -> bool {
        self.ranks.as_ref().is_none_or(|ranks| ranks.rank() == 0)
    }

    /// The outcome of a step that may fail on some of the processes only, as that of all.
    ///
    /// # Errors
    /// The first failure.
    pub(crate) fn agree<T>(&self, outcome: Result<T, Failure>) -> Result<T, Failure> {
        match &self.ranks {
            Some(ranks) => processes::agree(&**ranks, outcome),
            None => outcome,
        }
    }

    /// The same session, whose results go to memory in place of files: as far as they came, also after an interruption.
    #[must_use]
    pub fn in_memory(self, memory: Memory) -> Self {
        Self { memory: Some(memory), ..self }
    }

    /// The output of a command: a place in memory, or the file that is named, if there is one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn output(&self, named: Option<&PathBuf>) -> Result<Option<Output>, Failure> {
        match &self.memory {
            Some(memory) => Ok(Some(Output::memory(memory))),
            None => named.map(Output::claim).transpose().map_err(|error| Failure::input("--out", error)),
        }
    }

    /// The file that was written; none in memory.
    pub(crate) fn written(&self, out: Option<PathBuf>) -> Option<PathBuf> {
        out.filter(|_| !self.is_in_memory())
    }

    /// True if results go to memory, and nothing is kept to resume from.
    pub(crate) fn is_in_memory(&self) -> bool {
        self.memory.is_some()
    }

    /// Asks the run to stop, as Ctrl-C does.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Ordering::Relaxed);
    }

    /// Returns true if the user asked to stop.
    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Warns the user: on stderr, in the JSON of the report, and in the files of the run. `code` is a short name that does
    /// not change (docs/interface.md).
    pub fn warn(&self, code: &'static str, text: impl fmt::Display) {
        let text = line(&text.to_string());
        tracing::warn!("{text}");
        self.note(code, text);
    }

    /// As [`warn`](Self::warn), for a remark that the printed report itself contains.
    pub fn note(&self, code: &'static str, text: String) {
        self.warnings.add(Warning { code, text: line(&text) });
    }

    /// The report of a command as one JSON object, with the warnings of the run.
    ///
    /// # Errors
    /// An error of the serialisation of the report.
    pub fn json(&self, report: &impl Serialize) -> Result<String, Failure> {
        #[derive(Serialize)]
        struct Remark {
            code: &'static str,
            text: String,
        }
        #[derive(Serialize)]
        struct Whole<'a, R> {
            #[serde(flatten)]
            report: &'a R,
            warnings: Vec<Remark>,
        }
        let remark = |Warning { code, text }| Remark { code, text };
        let whole = Whole { report, warnings: self.warnings.list().into_iter().map(remark).collect() };
        crate::json::to_string(&whole).map_err(|error| Failure::Computation(error.to_string()))
    }

    /// The text that identifies a run by its version, its configuration and the checksum of its heights: another run cannot
    /// continue it.
    pub fn identity(&self, config: &str, heights: &str) -> String {
        let version = env!("CARGO_PKG_VERSION");
        format!("gfmd {version}, journal {JOURNAL}, heights {heights}\n{config}")
    }

    /// The provenance of a file written now; `config` is the resolved configuration.
    pub fn provenance(&self, config: String) -> Provenance {
        Provenance {
            program: "gfmd".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            git_commit: GIT_COMMIT.into(),
            command: std::env::args().collect::<Vec<_>>().join(" "),
            created: jiff::Timestamp::now().to_string(),
            config,
            machine: machine(),
            threads: rayon::current_num_threads(),
            warnings: self.warnings.clone(),
        }
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session")
            .field("common", &self.common)
            .field("is_first", &self.is_first())
            .finish_non_exhaustive()
    }
}

/// Writes the end of a printed report: the files written and drawn, one line each.
pub(crate) fn list_files(f: &mut fmt::Formatter, out: Option<&Path>, plots: &[PathBuf]) -> fmt::Result {
    if let Some(out) = out {
        writeln!(f, "\nwritten: {}", out.display())?;
    }
    plots.iter().try_for_each(|plot| writeln!(f, "drawn:   {}", plot.display()))
}

/// The processor, the number of cores and the operating system in words.
pub fn machine() -> String {
    let about = if cfg!(target_os = "linux") { std::fs::read_to_string("/proc/cpuinfo").ok() } else { None };
    let processor = about.and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.into());
    format!("{processor}, {cores} cores, {}", std::env::consts::OS)
}
