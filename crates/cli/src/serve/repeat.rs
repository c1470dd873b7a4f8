//! Lines that repeat a run: of a shell, and of Python.

use gfmd_report::quoted;

use super::form::Answers;

/// Returns a command line for a shell.
pub(super) fn command_line(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Returns the lines of Python that repeat a contact.
///
/// # Errors
/// Returns the reason why there are none.
pub(super) fn python(_file: &str, _answers: &Answers) -> Result<String, String> {
    Err("later".into())
}
