//! Parses, dispatches, prints, and maps failures to exit codes.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "this is where results and errors are printed")]

use std::fmt::Display;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use gfmd_xtask::failure::Failure;
use gfmd_xtask::session::{Common, Session};
use gfmd_xtask::{bench_peers, body, contact, damping, green, json, kappa_sweep, law, path, punch, surface, verify};
use serde::Serialize;

/// Contact mechanics of rough surfaces by Green's function molecular dynamics
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

#[derive(Subcommand)]
enum Command {
    /// Press a rough surface on an elastic body, at one or more loads
    Contact(Box<contact::Args>),
    /// The main job: kappa in the thermodynamic, fractal and continuum limit, with its uncertainty
    KappaSweep(Box<kappa_sweep::Args>),
    /// Press a flat rigid punch on an elastic body: all components, sticking or frictionless
    Punch(Box<punch::Args>),
    /// Displacement, strain and stress below a surface, from its displacement
    Body(Box<body::Args>),
    /// Make a rough surface, or measure one
    Surface(Box<surface::Args>),
    /// Time other programs on the same contacts, to the same certified residual
    BenchPeers(Box<bench_peers::Args>),
    /// Compare what the program computes with references, closed forms and identities
    Verify(Box<verify::Args>),
    /// What damping does to the relaxation of a surface, predicted and measured
    Damping(Box<damping::Args>),
    /// Look up stiffness, compliance and transfer matrices of one wave vector
    Green(Box<green::Args>),
    /// Follow a contact along a path: loading and unloading, adhesion, friction
    Path(Box<path::Args>),
    /// Evaluate a contact law: tractions, Jacobian, energy
    Law(Box<law::Args>),
}

fn main() -> ExitCode {
    keep_freed_memory();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let outcome = Session::start(cli.common).and_then(|session| dispatch(&cli.command, &session));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit_code()
        }
    }
}

/// One solve after the other takes and frees the same fields. Handed back to the system each time, and asked for again page
/// by page, they cost a tenth of the time on one thread, and more of two. Other systems keep their ways.
fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: there is no other thread yet, and both are settings that any value suits.
    unsafe {
        use nix::libc::{M_MMAP_MAX, M_TRIM_THRESHOLD, mallopt};
        mallopt(M_MMAP_MAX, 0);
        mallopt(M_TRIM_THRESHOLD, -1);
    }
}

fn dispatch(command: &Command, session: &Session) -> Result<(), Failure> {
    let as_json = session.common.json;
    match command {
        Command::Contact(args) => {
            let contact::Outcome { report, failure } = contact::run(args, session)?;
            print(&report, as_json)?;
            failure.map_or(Ok(()), Err)
        }
        Command::KappaSweep(args) => match kappa_sweep::run(args, session)? {
            kappa_sweep::Outcome::Done(report) => print(&*report, as_json),
            kappa_sweep::Outcome::Planned(plan) => print(&plan, as_json),
            kappa_sweep::Outcome::Config(text) => write(&text),
        },
        Command::BenchPeers(args) => print(&bench_peers::run(args, session)?, as_json),
        Command::Punch(args) => {
            let punch::Outcome { report, failure } = punch::run(args, session)?;
            print(&report, as_json)?;
            failure.map_or(Ok(()), Err)
        }
        Command::Body(args) => print(&body::run(args, session)?, as_json),
        Command::Surface(args) => print(&surface::run(args, session)?, as_json),
        Command::Verify(args) => {
            let verify::Outcome { report, failure } = verify::run(args, session)?;
            print(&report, as_json)?;
            failure.map_or(Ok(()), Err)
        }
        Command::Damping(args) => print(&damping::run(args, session)?, as_json),
        Command::Green(args) => print(&green::run(args)?, as_json),
        Command::Path(args) => {
            let path::Outcome { report, failure } = path::run(args, session)?;
            print(&report, as_json)?;
            failure.map_or(Ok(()), Err)
        }
        Command::Law(args) => print(&law::run(args)?, as_json),
    }
}

fn print(report: &(impl Display + Serialize), as_json: bool) -> Result<(), Failure> {
    if as_json {
        let text = json::to_string(report).map_err(|error| Failure::Computation(error.to_string()))?;
        return write(&(text + "\n"));
    }
    write(&report.to_string())
}

fn write(text: &str) -> Result<(), Failure> {
    use std::io::Write;
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush());
    written.map_err(|error| Failure::Computation(format!("cannot write the result: {error}")))
}

/// Help and version are results; everything else that clap says is one line of unusable input.
fn refuse(error: &clap::Error) -> ExitCode {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            print!("{}", error.render());
            ExitCode::SUCCESS
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            eprint!("{}", error.render());
            ExitCode::from(2)
        }
        _ => {
            let text = error.render().to_string();
            let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage")).collect();
            eprintln!("{}", lines.into_iter().filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" "));
            ExitCode::from(2)
        }
    }
}
