//! The program: parses the command line, runs the command, prints its report, and maps failures to exit codes.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write};
use std::process::ExitCode;
use std::sync::Arc;

use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Subcommand};
use gfmd_files::legible;
use gfmd_mpi::World;
use gfmd_problem::{Sequence, Written, key, rules_of, rules_of_sliding, words};
use gfmd_vector::Ranks as _;
use serde::Serialize;

use crate::kinds::kinds;
use crate::line::{Line, one_line, plain_words};
use crate::session::wrapped;
use crate::{
    body, check, completions, contact, estimate, green, inputs, kappa_sweep, law, materials, path, processes, prony,
    punch, report, serve, session, slide, study, surface, theory,
};
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::processes::agree;
use gfmd_input::session::Session;
use gfmd_input::units::of_table;
use gfmd_problem::options::flags::of_keys;
use gfmd_problem::options::given::Arrays;

/// The commands of `gfmd`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Press a rough surface against an elastic body at one or more loads
    Contact(Box<contact::Args>),
    /// Extrapolate kappa to the thermodynamic, fractal and continuum limit, with uncertainty
    KappaSweep(Box<kappa_sweep::Args>),
    /// Compute the contacts of all combinations of surfaces, seeds, bodies and loads into one file
    Study(Box<study::Args>),
    /// Press a flat rigid punch into an elastic body: all displacement components, sticking or frictionless
    Punch(Box<punch::Args>),
    /// Compute displacement, strain and stress below a surface from its displacement
    Body(Box<body::Args>),
    /// Generate or measure a rough surface
    Surface(Box<surface::Args>),
    /// Evaluate stiffness, compliance and transfer matrices for one wave vector
    Green(Box<green::Args>),
    /// Follow a contact along a path: loading and unloading, adhesion, friction, wear
    #[command(visible_alias = "wear")]
    Path(Box<path::Args>),
    /// Slide a rough surface steadily over a body: hysteretic friction and flash temperature against velocity
    Slide(Box<slide::Args>),
    /// Evaluate a contact law: tractions, Jacobian, energy
    Law(Box<law::Args>),
    /// Fit a Prony series to measured storage and loss moduli, for path and slide
    Prony(Box<prony::Args>),
    /// Evaluate theories of rough contact for a surface and a body, without solving a contact
    Theory(Box<theory::Args>),
    /// Estimate area, gap, stiffness and pressures of a contact from the surface spectrum, with errors
    Estimate(Box<estimate::Args>),
    /// Recompute the numbers of a result file from its inputs and compare them
    Check(Box<check::Args>),
    /// Write an HTML page about a result: the answer, figures, certificates, cost, and how to repeat it
    Report(Box<report::Args>),
    /// Serve a page in the browser: upload a scan, prepare it, press it, view maps of the result
    Serve(Box<serve::Args>),
    /// List the materials of --material and the fluids of --fluid with their values and sources
    Materials(materials::Args),
    /// Print a shell completion script for commands and flags
    Completions(completions::Args),
}

/// Parses the command line of the program called `name`, runs the command, and returns the exit status.
pub fn start<C: Subcommand + Sync>(
    name: &'static str,
    run: impl FnOnce(&C, &Session) -> Result<(), Failure> + Send,
) -> ExitCode {
    tune_allocator();
    fail_beyond_a_limit_of_files();
    ExitCode::from(status(name, std::env::args_os(), run))
}

/// Returns the exit status of the program `name` with these `words`, starting with the program.
pub fn status<C: Subcommand + Sync>(
    name: &'static str,
    words: impl IntoIterator<Item = OsString>,
    run: impl FnOnce(&C, &Session) -> Result<(), Failure> + Send,
) -> u8 {
    let words: Vec<OsString> = words.into_iter().collect();
    match processes::join(&words) {
        Ok(world) => together(name, &words, run, world.as_ref()),
        Err(failure) => {
            // No process has joined another, so each prints the reason; there may be no first one.
            let _ = writeln!(io::stderr(), "error: {failure}");
            failure.status()
        }
    }
}

/// Returns the exit status of the program; with several processes they form the `world`.
fn together<C: Subcommand + Sync>(
    name: &'static str,
    words: &[OsString],
    run: impl FnOnce(&C, &Session) -> Result<(), Failure> + Send,
    world: Option<&Arc<World>>,
) -> u8 {
    if let Some(word) = words.iter().find(|word| word.to_str().is_none()) {
        let word = word.to_string_lossy();
        let _ = writeln!(io::stderr(), "error: the argument {word} is not UTF-8; it must be, since results record it");
        return 2;
    }
    let command = named(Line::<C>::command(), name);
    let words: Vec<String> = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let plain = match study::words_of_study(&command, &words) {
        Ok(None) => plain_words(&command, &words),
        Ok(Some(_)) if world.is_some() => Err(Failure::refused(words![
            "several of ",
            key("seed"),
            " or ",
            key("surface"),
            " are given to several processes; they must be members of a study, whose shards run apart (gfmd study)"
        ])),
        Ok(Some((study, written))) => Ok((study, None, written)),
        Err(failure) => Err(failure),
    };
    let plain = match world {
        Some(world) => agree(&**world, plain),
        None => plain,
    };
    let (words, map, written) = match plain {
        Ok(plain) => plain,
        Err(failure) => return processes::end(world, failure.status(), Some(&failure)),
    };
    let parsed = command.try_get_matches_from(words);
    let line = match parsed.and_then(|mut matches| Line::<C>::from_arg_matches_mut(&mut matches)) {
        Ok(line) => line,
        Err(error) => {
            let is_first = world.is_none_or(|world| world.rank() == 0);
            return processes::end(world, if is_first { refuse(&error, &written) } else { status_of(&error) }, None);
        }
    };
    let session = session::start(line.common, world).map(|session| session.with_map(map).with_written(written));
    let session = match world {
        Some(world) => agree(&**world, session),
        None => session,
    };
    // Run on a thread of the pool, so that vector sums need not enter it each time.
    let failure = session.and_then(|session| rayon::scope(|_| run(&line.command, &session))).err();
    processes::end(world, failure.as_ref().map_or(0, Failure::status), failure.as_ref())
}

/// Makes a write beyond the file size limit (`ulimit -f`) fail as on a full disk, instead of a signal that ends the
/// process silently.
fn fail_beyond_a_limit_of_files() {
    #[cfg(unix)]
    #[allow(unsafe_code, reason = "there is no other interface to signals without a handler")]
    // SAFETY: no handler is installed, and no other thread runs yet.
    unsafe {
        nix::libc::signal(nix::libc::SIGXFSZ, nix::libc::SIG_IGN);
    }
}

/// Keeps freed memory in the process, for all its threads, on Linux with glibc. Each solve allocates and frees fields
/// of equal size. Returning them to the system each time costs a tenth of the computing time on one thread, and more on
/// two; one arena per thread takes half a field more.
pub fn tune_allocator() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[allow(unsafe_code, reason = "the allocator has no other interface")]
    // SAFETY: the allocator takes its lock, and the settings accept any value.
    unsafe {
        use nix::libc::{M_ARENA_MAX, M_MMAP_MAX, M_TRIM_THRESHOLD, mallopt};
        mallopt(M_ARENA_MAX, 1);
        mallopt(M_MMAP_MAX, 0);
        mallopt(M_TRIM_THRESHOLD, -1);
    }
}

/// Terms of flags, by the key of the flag or the name of the command with help that explains them.
const TERMS: [(&str, &str); 6] = [
    ("p_star", "  p*       reduced pressure p/(E* g): mean pressure p, contact modulus E*, rms gradient g"),
    ("e_star", "  E*       contact modulus E/(1 - nu^2)"),
    ("eps_t_inv", "  eps_t    longest wavelength divided by the cell length"),
    ("eps_f_inv", "  eps_f    shortest wavelength divided by the longest"),
    ("eps_c_inv", "  eps_c    grid spacing divided by the shortest wavelength"),
    (
        "kappa-sweep",
        "  p*       reduced pressure p/(E* g): mean pressure p, contact modulus E*, rms gradient g\n  \
         kappa    contact area fraction divided by p*\n  \
         TFC      thermodynamic, fractal and continuum limit: eps_t, eps_f and eps_c to 0\n  \
         eps_t    longest wavelength divided by the cell length\n  \
         eps_f    shortest wavelength divided by the longest\n  \
         eps_c    grid spacing divided by the shortest wavelength",
    ),
];

/// Puts the name of the called program into its help; the examples are written for `gfmd`.
fn named(command: clap::Command, name: &'static str) -> clap::Command {
    let examples = |command: clap::Command| match command.get_after_help() {
        Some(text) => {
            let text = text.to_string().replace("\n  gfmd ", &format!("\n  {name} "));
            let known = |term: &&(&str, &str)| {
                command.get_name() == term.0 || command.get_arguments().any(|arg| arg.get_id() == term.0)
            };
            let terms: String = TERMS.iter().filter(known).map(|(_, meaning)| format!("{meaning}\n")).collect();
            let text = if terms.is_empty() { text } else { format!("Terms:\n{terms}\n{text}") };
            let rules = match command.get_name() {
                "contact" => rules_of(Sequence::Loads),
                "path" => rules_of(Sequence::Path),
                "slide" => rules_of_sliding(),
                _ => Vec::new(),
            };
            let rules = rules.iter().map(|(with, others)| format!("\n  with {with}: {}", others.join(", ")));
            let rules = rules.collect::<String>();
            let together = if rules.is_empty() { rules } else { format!("\n\nRefused combinations:{rules}") };
            command.after_long_help(format!("{text}{together}")).after_help(text)
        }
        None => command,
    };
    command.name(name).bin_name(name).mut_subcommands(examples)
}

/// Returns the program with its commands, whose flags are a table of all options: keys, headings, defaults, help.
pub fn command() -> clap::Command {
    named(Line::<Command>::command(), "gfmd")
}

impl Command {
    /// Creates the command `name` from a table with its flags as keys, and the arrays of its options; with the
    /// quantities as they were written.
    ///
    /// # Errors
    /// Returns an error if the command has no table form, a key is unknown to it, or a value has another type.
    pub fn of(name: &str, mut table: toml::Table, arrays: Arrays) -> Result<(Self, Written), Failure> {
        inputs::stay_in(&table)?;
        let written = of_table(name, &mut table, &arrays, kinds())?;
        let command = match name {
            "path" => Self::Path(Box::new(of_keys(table, arrays)?)),
            "slide" => Self::Slide(Box::new(of_keys(table, arrays)?)),
            "punch" => Self::Punch(Box::new(of_keys(table, arrays)?)),
            "body" => Self::Body(Box::new(of_keys(table, arrays)?)),
            "kappa-sweep" => Self::KappaSweep(Box::new(of_keys(table, arrays)?)),
            "study" => Self::Study(Box::new(of_keys(table, arrays)?)),
            "green" => Self::Green(Box::new(of_keys(table, arrays)?)),
            "prony" => Self::Prony(Box::new(of_keys(table, arrays)?)),
            "estimate" => Self::Estimate(Box::new(of_keys(table, arrays)?)),
            _ => {
                let allowed = "path, slide, punch, body, kappa-sweep, study, green, prony or estimate";
                return Err(Failure::value("the command", name, allowed));
            }
        };
        Ok((command, written))
    }

    /// Runs the command.
    ///
    /// # Errors
    /// Returns the reason why the command failed.
    pub fn outcome(&self, session: &Session) -> Result<Outcome<Box<dyn Printable>>, Failure> {
        self.found(session).map_err(|failure| session.as_written(failure))
    }

    fn found(&self, session: &Session) -> Result<Outcome<Box<dyn Printable>>, Failure> {
        fn whole<R: Printable + 'static>(report: R) -> Outcome<Box<dyn Printable>> {
            ended(Outcome { report, failure: None })
        }
        fn ended<R: Printable + 'static>(Outcome { report, failure }: Outcome<R>) -> Outcome<Box<dyn Printable>> {
            Outcome { report: Box::new(report), failure }
        }
        Ok(match self {
            Self::Contact(args) => ended(contact::run(args, session)?),
            Self::KappaSweep(args) => match kappa_sweep::run(args, session)? {
                kappa_sweep::Outcome::Done(report) => whole(*report),
                kappa_sweep::Outcome::Shard(report) => whole(report),
                kappa_sweep::Outcome::Planned(plan) => whole(plan),
                kappa_sweep::Outcome::Config(text) => whole(Plain(text)),
            },
            Self::Study(args) => match study::run(args, session)? {
                study::Outcome::Done(report, failure) => ended(Outcome { report: *report, failure }),
                study::Outcome::Shard(report, failure) => ended(Outcome { report, failure }),
                study::Outcome::Planned(plan) => whole(plan),
            },
            Self::Punch(args) => ended(punch::run(args, session)?),
            Self::Body(args) => whole(body::run(args, session)?),
            Self::Surface(args) => whole(surface::run(args, session)?),
            Self::Green(args) => whole(green::run(args)?),
            Self::Path(args) => ended(path::run(args, session)?),
            Self::Slide(args) => ended(slide::run(args, session)?),
            Self::Law(args) => whole(law::run(args)?),
            Self::Prony(args) => whole(prony::run(args, session)?),
            Self::Theory(args) => whole(theory::run(args, session)?),
            Self::Estimate(args) => whole(estimate::run(args, session)?),
            Self::Check(args) => ended(check::run(args, session)?),
            Self::Report(args) => whole(report::run(args, session)?),
            Self::Serve(args) => {
                serve::run(args, session, |started| print(started, session))?;
                whole(Plain(String::new()))
            }
            Self::Materials(_) => whole(materials::run()),
            Self::Completions(args) => whole(Plain(completions::run(args, command()))),
        })
    }

    /// Runs the command and prints its report, also if the command ended early.
    ///
    /// # Errors
    /// Returns the reason why the command failed.
    pub fn run(&self, session: &Session) -> Result<(), Failure> {
        let Outcome { report, failure } = self.outcome(session)?;
        let printed = report.print(session);
        failure.map_or(printed, Err)
    }
}

/// Report of a command.
pub trait Printable {
    /// Prints the report as a table, or as JSON with `--json`.
    ///
    /// # Errors
    /// Returns an error if standard output cannot be written.
    fn print(&self, session: &Session) -> Result<(), Failure>;

    /// Returns the report as one JSON object.
    ///
    /// # Errors
    /// Returns an error of the serialisation.
    fn json(&self, session: &Session) -> Result<String, Failure>;
}

impl<R: Display + Serialize> Printable for R {
    fn print(&self, session: &Session) -> Result<(), Failure> {
        print(self, session)
    }

    fn json(&self, session: &Session) -> Result<String, Failure> {
        session.json(self)
    }
}

/// Text printed verbatim.
struct Plain(String);

impl Printable for Plain {
    fn print(&self, _: &Session) -> Result<(), Failure> {
        write(&self.0)
    }

    fn json(&self, _: &Session) -> Result<String, Failure> {
        gfmd_input::json::to_string(&self.0).map_err(|error| Failure::computation(error.to_string()))
    }
}

/// Prints a report as a table, or as JSON with `--json`.
///
/// # Errors
/// Returns an error if standard output cannot be written or a number of the report is not finite.
pub fn print(report: &(impl Display + Serialize), session: &Session) -> Result<(), Failure> {
    let text = session.json(report)?;
    let numbers: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| Failure::computation(error.to_string()))?;
    if session.is_first() {
        // The width of the format sets the width of the tables.
        let table = || match session.wide {
            true => legible::lines(&report.to_string()),
            false => narrow(&legible::lines(&format!("{report:width$}", width = width())), width()),
        };
        write(&if session.json { text + "\n" } else { table() })?;
    }
    match gfmd_input::json::undefined(&numbers) {
        Some(key) => Err(Failure::computation(format!(
            "{key} is not finite; it must be, and other units of stress or length may make it so"
        ))),
        None => Ok(()),
    }
}

/// Breaks sentences wider than `width`. Lines of tables, which have several spaces between columns, stay, and so do
/// options to copy and longer words.
fn narrow(text: &str, width: usize) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let (indent, words) = line.split_at(line.len() - line.trim_start().len());
        let room = width.saturating_sub(indent.len());
        let is_long = |word: &str| word.chars().count() > room;
        let is_sentence = !words.contains("  ") && !words.starts_with("--") && !words.split(' ').any(is_long);
        if line.chars().count() <= width || !is_sentence {
            out += &format!("{line}\n");
        } else {
            wrapped(words, room).iter().for_each(|line| out += &format!("{indent}{line}\n"));
        }
    }
    out
}

/// Width of tables in characters, unless the terminal is narrower or all columns are asked for.
const WIDTH: usize = 80;

/// Returns the width of tables.
fn width() -> usize {
    let size = io::stdout().is_terminal().then(terminal_size::terminal_size).flatten();
    size.map_or(WIDTH, |(width, _)| WIDTH.min(width.0.into()))
}

fn put(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush())
}

fn write(text: &str) -> Result<(), Failure> {
    put(text).map_err(|error| Failure::computation(format!("cannot write the result: {error}")))
}

/// Returns the exit status of a message of clap.
fn status_of(error: &clap::Error) -> u8 {
    if let ErrorKind::DisplayHelp | ErrorKind::DisplayVersion = error.kind() { 0 } else { 2 }
}

/// Returns where to go with a list of seeds or surfaces, which a single contact does not take.
fn way_out(error: &clap::Error) -> &'static str {
    let of = |kind| error.get(kind).map(ToString::to_string).unwrap_or_default();
    let (flag, value) = (of(ContextKind::InvalidArg), of(ContextKind::InvalidValue));
    let is_repeated = error.kind() == ErrorKind::ArgumentConflict && of(ContextKind::PriorArg) == flag;
    match flag.split_whitespace().next() {
        Some("--seed") if is_repeated || value.contains([':', ',']) => "; gfmd study computes many seeds",
        Some("--surface") if is_repeated => "; gfmd study computes many surfaces",
        _ => "",
    }
}

/// Prints help and version as results, and any other message of clap as one line of unusable input.
fn refuse(error: &clap::Error, written: &Written) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A reader such as `head` may close the pipe early.
            match put(&error.render().to_string()) {
                Err(error) if error.kind() != io::ErrorKind::BrokenPipe => 1,
                _ => 0,
            }
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = write!(io::stderr(), "{}", error.render());
            2
        }
        _ => {
            let _ = writeln!(io::stderr(), "{}{}", written.in_text(&one_line(error)), way_out(error));
            2
        }
    }
}
