//! Program `gfmd`.

use std::process::ExitCode;

use gfmd_cli::program::{Command, start};

fn main() -> ExitCode {
    start("gfmd", Command::run)
}
