use std::io;
use std::path::PathBuf;

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// Nothing to draw.
    #[error("nothing to plot: {what}")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// A value that is not a number.
    #[error("cannot plot {found} in {place}; finite numbers are allowed")]
    NotFinite {
        /// What was found.
        found: f64,
        /// Where.
        place: String,
    },
    /// A value at or below zero on a logarithmic axis.
    #[error("cannot plot {found} in {place} on a logarithmic axis; numbers above zero are allowed")]
    NotPositive {
        /// What was found.
        found: f64,
        /// Where.
        place: String,
    },
    /// An axis from and to the same place, or backwards.
    #[error("an axis from {} to {} asked; the second end must be above the first", range[0], range[1])]
    BadRange {
        /// What was found.
        range: [f64; 2],
    },
    /// A field that does not fill its grid.
    #[error("{found} values for a map of {} x {}; at least 2 x 2 are needed, one value each", shape[0], shape[1])]
    Shape {
        /// Number of values.
        found: usize,
        /// Points along x and y.
        shape: [usize; 2],
    },
    /// The drawing could not be turned into an image.
    #[error("cannot render the figure: {reason}")]
    Render {
        /// In the words of the library.
        reason: String,
    },
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}
