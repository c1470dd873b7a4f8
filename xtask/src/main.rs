//! `cargo xtask`: all commands of `gfmd`, and the developer tools.

use std::process::ExitCode;

use clap::Subcommand;
use gfmd_cli::program::{print, start};
use gfmd_xtask::{accuracy, bench_peers, deviations, finite, reproduce, results, verify};

#[derive(Subcommand)]
enum Command {
    #[command(flatten)]
    Gfmd(gfmd_cli::program::Command),
    /// Compare the estimates of the grid error with solutions on grids 8 times finer
    Accuracy(accuracy::Args),
    /// Time this and other programs on common contact problems, to one certified residual
    BenchPeers(Box<bench_peers::Args>),
    /// Time what people run: processes, ramps, stiffness, flow, many contacts; memory; threads and ranks
    BenchRows(Box<bench_peers::RowsArgs>),
    /// Solve one contact for bench-peers
    #[command(hide = true)]
    BenchSolve(bench_peers::SolveArgs),
    /// Measure the deviations of the numbers of estimate from solved contacts
    Deviations(deviations::Args),
    /// Compute mean gap, stiffness, pressure and percolation of self-affine surfaces of finite spectra
    Finite(finite::Args),
    /// Compute and draw the figures of the thesis, chapters 2 to 4, and write docs/source/README.md
    Reproduce(Box<reproduce::Args>),
    /// Draw the figures and write the tables of docs/results.md from data/results
    Results(Box<results::Args>),
    /// Compare results of the program with references, closed forms and identities
    Verify(Box<verify::Args>),
}

fn main() -> ExitCode {
    start("cargo xtask", |command: &Command, session| match command {
        Command::Gfmd(command) => command.run(session),
        Command::Accuracy(args) => print(&accuracy::run(args, session)?, session),
        Command::BenchPeers(args) => print(&bench_peers::run(args, session)?, session),
        Command::BenchRows(args) => print(&bench_peers::rows(args, session)?, session),
        Command::BenchSolve(args) => print(&bench_peers::solve(args)?, session),
        Command::Deviations(args) => print(&deviations::run(args, session)?, session),
        Command::Finite(args) => print(&finite::run(args, session)?, session),
        Command::Reproduce(args) => print(&reproduce::run(args, session)?, session),
        Command::Results(args) => print(&results::run(args)?, session),
        Command::Verify(args) => {
            let outcome = verify::run(args, session)?;
            let printed = print(&outcome.report, session);
            outcome.failure.map_or(printed, Err)
        }
    })
}
