//! Errors of the libraries as exceptions of the package.

use std::fmt::Display;

use gfmd_files::legible::line;
use gfmd_run::failure::Failure;
use pyo3::prelude::*;

/// The exception that `gfmd._errors` makes of a message, by the name of its maker there.
fn raised(py: Python<'_>, maker: &str, text: &str) -> PyErr {
    let made = py.import("gfmd._errors").and_then(|errors| errors.call_method1(maker, (text,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Unusable input.
pub(crate) fn refused(py: Python<'_>, error: &dyn Display) -> PyErr {
    raised(py, "refused", &line(&error.to_string()))
}

/// A failure without a state. A problem of which nothing can be computed was unusable input.
pub(crate) fn failed(py: Python<'_>, failure: &Failure) -> PyErr {
    let maker = match failure {
        Failure::Input(_) => "refused",
        Failure::Computation(_) => "failed",
        Failure::Interrupted(_) => "interrupted",
    };
    raised(py, maker, &failure.to_string())
}

/// A search that ended without a state.
pub(crate) fn unreached(py: Python<'_>, failure: &Failure) -> PyErr {
    match failure {
        Failure::Computation(text) => raised(py, "unreached", &line(text)),
        _ => failed(py, failure),
    }
}

/// A panic of a library: a defect, told as an exception.
pub(crate) fn panicked(py: Python<'_>, payload: &(dyn std::any::Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message");
    raised(py, "failed", &format!("defect in gfmd, please report it: {text}"))
}
