//! Contacts solved by the program, as printed.

use clap::Parser;
use gfmd_cli::contact;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
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
    let words = std::iter::once("contact").chain(flags.split_whitespace());
    let command = Command::try_parse_from(words).map_err(|error| Failure::refused(error.to_string()))?;
    let run = || contact::run(&command.contact, &Session::silent());
    let outcome = tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), run)?;
    if let Some(failure) = outcome.failure {
        return Err(failure);
    }
    serde_json::to_value(&outcome.report).map_err(|error| Failure::computation(error.to_string()))
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
