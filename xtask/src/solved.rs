//! Contacts solved by the program, as printed.

use clap::Parser;
use gfmd_cli::contact;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_record::COLUMNS;
use serde_json::Value;

#[derive(Parser)]
struct Command {
    #[command(flatten)]
    contact: contact::Args,
}

/// Returns the report of `contact` with these flags.
///
/// # Errors
/// Flags that do not parse; a load that was not solved.
pub fn contact(flags: &str) -> Result<Value, Failure> {
    report(&parsed(flags)?)
}

fn parsed(flags: &str) -> Result<Command, Failure> {
    let words = std::iter::once("contact").chain(flags.split_whitespace());
    Command::try_parse_from(words).map_err(|error| Failure::refused(error.to_string()))
}

fn report(command: &Command) -> Result<Value, Failure> {
    let run = || contact::run(&command.contact, &Session::silent());
    let outcome = tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), run)?;
    if let Some(failure) = outcome.failure {
        return Err(failure);
    }
    serde_json::to_value(&outcome.report).map_err(|error| Failure::computation(error.to_string()))
}

/// Returns the report of `contact` on a surface with these other flags.
///
/// # Errors
/// Flags that do not parse; a load that was not solved.
pub fn contact_of(source: SourceArgs, flags: &str) -> Result<Value, Failure> {
    let mut command = parsed(flags)?;
    command.contact.problem.source = source;
    report(&command)
}

/// Returns the loads of a report.
pub fn loads(report: &Value) -> &[Value] {
    report["loads"].as_array().map_or(&[], Vec::as_slice)
}

/// Returns a quantity of a load; `None` if it has no value.
pub fn number(load: &Value, name: &str) -> Option<f64> {
    let column = COLUMNS.iter().find(|column| column.name == name)?;
    load.pointer(&format!("/{}", column.json.replace('.', "/")))?.as_f64()
}
