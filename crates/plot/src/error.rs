use std::io;
use std::path::PathBuf;

/// Reason why a figure cannot be drawn or saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// There is nothing to draw.
    #[error("nothing to plot: {what}")]
    Empty {
        /// Missing data, in words.
        what: &'static str,
    },
    /// A value is not finite.
    #[error("{place} is {found}; it must be finite")]
    NotFinite {
        /// Value.
        found: f64,
        /// Place in the figure.
        place: String,
    },
    /// A value on a logarithmic axis is not positive.
    #[error("{place} is {found}; it must be above zero on a logarithmic axis")]
    NotPositive {
        /// Value.
        found: f64,
        /// Place in the figure.
        place: String,
    },
    /// The range of an axis is empty or reversed, not positive on a logarithmic axis, or too large or small for ticks.
    #[error(
        "the range of an axis is {:?} to {:?}; it must be increasing, with ends up to 1e307, longer than 1e-304 and \
         than 1e-13 of its ends, and from 1e-304 on if logarithmic",
        range[0],
        range[1]
    )]
    BadRange {
        /// Lower and upper end.
        range: [f64; 2],
    },
    /// The number of values does not match the grid, or the grid is too small.
    #[error(
        "a map of {} x {} points has {found} values; it must have one value per point and at least 2 x 2 points",
        shape[0],
        shape[1]
    )]
    Shape {
        /// Number of values.
        found: usize,
        /// Points along x and y.
        shape: [usize; 2],
    },
    /// The drawing could not be turned into an image.
    #[error("cannot render the figure: {reason}")]
    Render {
        /// Message of the library.
        reason: String,
    },
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}
