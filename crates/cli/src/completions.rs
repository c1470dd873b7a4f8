//! `completions`: shell script that completes the commands and flags of the program.

use clap::Args as ClapArgs;
use clap_complete::{Shell, generate};

/// Flags of `completions`.
#[derive(ClapArgs, Clone, Copy, Debug)]
#[command(after_help = "Examples:
  gfmd completions bash > ~/.local/share/bash-completion/completions/gfmd
  gfmd completions zsh > ~/.zfunc/_gfmd
  gfmd completions fish > ~/.config/fish/completions/gfmd.fish")]
pub struct Args {
    /// Shell to generate the script for
    #[arg(value_enum)]
    shell: Shell,
}

/// Returns the script for a program with this command line.
pub fn run(args: &Args, mut line: clap::Command) -> String {
    let (name, mut script) = (line.get_name().to_owned(), Vec::new());
    generate(args.shell, &mut line, name, &mut script);
    String::from_utf8_lossy(&script).into_owned()
}
