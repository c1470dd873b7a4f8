//! Conversion of library errors to the exceptions of the package.

use std::fmt::Display;

use gfmd_files::legible::line;
use gfmd_input::failure::Failure;
use gfmd_problem::Spelling;
use pyo3::prelude::*;

/// Calls the function `maker` of `gfmd._errors`, which makes an exception from a message.
fn raised(py: Python<'_>, maker: &str, text: &str) -> PyErr {
    let made = py.import("gfmd._errors").and_then(|errors| errors.call_method1(maker, (text,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns the exception for unusable input that a library describes.
pub(crate) fn refused(py: Python<'_>, error: &dyn Display) -> PyErr {
    raised(py, "refused", &line(&error.to_string()))
}

/// Returns the exception for unusable input: the message, the argument, the value found and the allowed values.
pub(crate) fn unusable(py: Python<'_>, failure: impl Into<Failure>) -> PyErr {
    let failure = failure.into();
    let text = spelled(&failure);
    let Failure::Input(input) = failure else { return raised(py, "refused", &text) };
    let argument = input.key().map(gfmd_problem::argument);
    let allowed = input.allowed.as_ref().map(|words| words.spelled(Spelling::Argument));
    let made = py.import("gfmd._errors");
    let made = made.and_then(|errors| errors.call_method1("refused", (text, argument, &input.found, allowed)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns the message of a failure with options spelled as arguments.
pub(crate) fn spelled(failure: &Failure) -> String {
    failure.spelled(Spelling::Argument)
}

/// Returns the exception for a failure without a state. Only [`Failure::Input`] counts as unusable input.
pub(crate) fn failed(py: Python<'_>, failure: Failure) -> PyErr {
    let maker = match failure {
        Failure::Input(_) => return unusable(py, failure),
        Failure::NotConverged(_) => "unreached",
        Failure::Computation(_) => "failed",
        Failure::Interrupted(_) => "interrupted",
    };
    raised(py, maker, &spelled(&failure))
}

/// Returns the exception for a search that ended without a state.
pub(crate) fn unreached(py: Python<'_>, failure: Failure) -> PyErr {
    match failure {
        Failure::Computation(_) => raised(py, "unreached", &spelled(&failure)),
        _ => failed(py, failure),
    }
}

/// Returns the exception for a panic of a library, which is a defect.
pub(crate) fn panicked(py: Python<'_>, payload: &(dyn std::any::Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    raised(py, "failed", &format!("defect in gfmd, please report it: {text}"))
}
