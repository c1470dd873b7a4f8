//! Command lines: their words as the parser reads them, and their commands.

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use gfmd_input::failure::Failure;
use gfmd_input::session::{NamedMap, Session};
use gfmd_input::units::of_words;
use gfmd_problem::Written;

use crate::kinds::kinds;
use crate::session::Common;
use crate::{guess, inputs};

/// Contact mechanics of rough surfaces by Green's function molecular dynamics
#[derive(Parser)]
#[command(version, max_term_width = 110)]
pub(crate) struct Line<C: Subcommand> {
    #[command(subcommand)]
    pub(crate) command: C,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// Returns the commands of `C` with their flags.
pub(crate) fn table<C: Subcommand>() -> clap::Command {
    Line::<C>::command()
}

/// Returns the words of a command line as the parser reads them: with numbers in place of quantities with a unit. Also
/// returns the height map of the surface if it was read for its unit, and the quantities as they were written.
///
/// # Errors
/// Returns an error for words that no option has, outputs that are inputs, and quantities that cannot be used.
pub(crate) fn plain_words(
    command: &clap::Command,
    words: &[String],
) -> Result<(Vec<String>, Option<NamedMap>, Written), Failure> {
    let words = guess::understood(command, words)?;
    inputs::stay(&words)?;
    let sub = words.iter().find_map(|word| command.find_subcommand(word.text()));
    let (words, map, written) = of_words(sub.map_or("", clap::Command::get_name), words, kinds())?;
    Ok((words.into_iter().map(|word| word.text().to_owned()).collect(), map, written))
}

/// Returns the command of a command line, and its session as one of several runs in this process. The `words` start
/// with the program.
///
/// # Errors
/// Returns an error, as the program prints it, if the command line cannot be used.
pub(crate) fn parsed<C: Subcommand>(words: &[String]) -> Result<(C, Session), Failure> {
    let commands = table::<C>();
    let (plain, map, written) = plain_words(&commands, words)?;
    let parsed = commands.try_get_matches_from(plain);
    let line = parsed.and_then(|mut matches| Line::<C>::from_arg_matches_mut(&mut matches));
    let line = line.map_err(|error| Failure::refused(written.in_text(&one_line(&error))))?;
    let session = Session::beside_others(words.join(" ")).with_map(map).with_written(written);
    Ok((line.command, session))
}

/// Returns a message of clap about unusable input as one line.
pub(crate) fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let is_end = |line: &&str| line.starts_with("Usage") || line.starts_with("For more information");
    let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !is_end(line)).collect();
    lines.into_iter().filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}
