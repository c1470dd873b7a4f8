//! The channels of a file.

use std::fmt;

use gfmd_files::Topography;
use serde::Serialize;

use gfmd_input::failure::Failure;

/// The height maps of a file, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct Listing {
    pub file: String,
    pub format: &'static str,
    pub channels: Vec<Channel>,
}

/// A height map.
#[derive(Clone, Debug, Serialize)]
pub struct Channel {
    pub number: usize,
    pub name: String,
    pub unit: Option<String>,
    pub n: [usize; 2],
    pub default: bool,
}

impl Listing {
    /// Lists the height maps of a file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of(file: &str) -> Result<Self, Failure> {
        let listing = Topography::list(file).map_err(|error| Failure::refused(error.to_string()))?;
        let channel = |(number, channel): (usize, gfmd_files::ListedChannel)| Channel {
            number,
            default: listing.default == Some(number),
            name: channel.name,
            unit: channel.unit,
            n: channel.points,
        };
        let channels = listing.channels.into_iter().enumerate().map(channel).collect();
        Ok(Self { file: file.into(), format: listing.format, channels })
    }
}

impl fmt::Display for Listing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}", self.file, self.format)?;
        for Channel { number, name, unit, n: [nx, ny], default } in &self.channels {
            let unit = unit.as_deref().unwrap_or("-");
            // A channel that is listed without points is not readable; reading it says why.
            let points = if *nx == 0 { "not readable".into() } else { format!("{nx} x {ny}") };
            let default = if *default { "  (default)" } else { "" };
            writeln!(f, "{number:>4}  {name:<32} {unit:<6} {points}{default}")?;
        }
        Ok(())
    }
}
