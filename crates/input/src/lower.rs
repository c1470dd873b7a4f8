//! Second rigid surface, below the slab, from flags.

use clap::Args;
use gfmd_files::{Archive, Dimension, Reader};
use gfmd_problem::{Lower, key, words};
use gfmd_surface::Periodisation;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::session::Session;
use crate::source::{Detrend, SourceArgs, Surface};
use gfmd_problem::options::Options;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::{GeneratorArgs, LARGEST_SEED};

/// Flags of a rigid surface below the slab.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Lower surface")]
pub struct LowerArgs {
    /// Rigid surface below the slab, in place of a base: heights as for --surface, on the same points, peaks towards
    /// the slab; prepared by the flags of --surface if that is given
    #[arg(long, value_name = "FILE", conflicts_with = "lower_seed")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    pub lower_surface: Option<ArrayOption>,
    /// Random seed, below 2^63, of a generated surface below the slab with the spectrum of the upper one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower_seed: Option<u64>,
}

/// Words for a slab between two surfaces, in place of the words for its base.
pub const BETWEEN: &str = "between two rigid surfaces";

/// Group in a file.
const GROUP: &str = "/lower";

/// Heights in a file.
const HEIGHT: &str = "/lower/height";

impl LowerArgs {
    /// Keys of these flags in a configuration.
    pub const NAMES: [&'static str; 2] = ["lower_surface", "lower_seed"];

    /// Returns the key of the given option.
    pub fn given(&self) -> Option<&'static str> {
        match (&self.lower_surface, self.lower_seed) {
            (Some(_), _) => Some("lower_surface"),
            (_, Some(_)) => Some("lower_seed"),
            _ => None,
        }
    }

    /// Returns the fact of the given option.
    pub fn fact(&self) -> Option<Lower> {
        match (&self.lower_surface, self.lower_seed) {
            (Some(_), _) => Some(Lower::Surface),
            (_, Some(_)) => Some(Lower::Seed),
            _ => None,
        }
    }

    /// Reads or generates the surface that goes with the `upper` one, as described by `source`.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read, grid or unit differ from the upper surface, or a spectrum is missing.
    pub fn read(&self, source: &SourceArgs, upper: &Surface, session: &Session) -> Result<Option<Surface>, Failure> {
        let lower = if let Some(file) = &self.lower_surface {
            // A generated upper surface on a finer grid needs a finer lower one.
            let refine = source.refine.or(source.finer);
            let plain = SourceArgs { channel: None, surface: Some(file.clone()), refine, ..source.clone() };
            let source = if source.surface.is_some() {
                plain
            } else {
                // As for the generated surface.
                SourceArgs { fill: None, detrend: Detrend::None, periodise: Periodisation::AsIs, flip: false, ..plain }
            };
            source.surface(session)?
        } else if let Some(seed) = self.lower_seed {
            if source.surface.is_some() {
                let (surface, lower) = (key("surface"), key("lower_surface"));
                let allowed = words!["left out with ", surface, "; use ", lower, " for the lower surface"];
                return Err(Failure::value(key("lower_seed"), seed, allowed));
            }
            if source.generator.shape.is_some() {
                let allowed =
                    words!["left out with ", key("shape"), "; use ", key("lower_surface"), " for the lower surface"];
                return Err(Failure::value(key("lower_seed"), seed, allowed));
            }
            let generator = GeneratorArgs { seed, ..source.generator.clone() };
            SourceArgs { generator, ..source.clone() }.surface(session)?
        } else {
            return Ok(None);
        };
        let refuse = |reason: String| Err(Failure::input(key("lower_surface"), reason));
        if lower.grid != upper.grid {
            let words = |surface: &Surface| {
                let ([nx, ny], [x, y]) = (surface.grid.points(), surface.grid.lengths());
                format!("{nx} x {ny} points in a cell {x:?} x {y:?}")
            };
            return refuse(format!("it has {}; it must have {}, as the upper surface", words(&lower), words(upper)));
        }
        if let (Some(found), Some(expected)) = (&lower.unit, &upper.unit)
            && found != expected
        {
            return refuse(format!("its unit is {found}; it must be {expected}, the unit of the upper surface"));
        }
        Ok(Some(lower))
    }
}

/// Writes the group of the lower surface; of several processes, the first one has the `archive`.
///
/// # Errors
/// Returns an error, at the first process, if the file cannot be written.
pub fn write(lower: &Surface, archive: Option<&mut Archive>, axes: [&Dimension; 2]) -> Result<(), Failure> {
    let long_name = "height of the lower rigid surface, peaks towards the elastic body";
    match archive {
        Some(archive) if lower.share.is_whole() => lower.write_as(archive, GROUP, long_name, axes),
        archive if !lower.share.is_whole() => lower.write_shared_as(archive, GROUP, long_name, axes),
        _ => Ok(()),
    }
}

/// Returns true if the file has a lower surface.
pub fn is_stored(reader: &Reader) -> bool {
    reader.contains(HEIGHT)
}

/// Returns the key of the lower surface in a file, and the name to read it from there.
pub fn stored_lower(reader: &Reader) -> Option<(&'static str, String)> {
    is_stored(reader).then(|| ("lower_surface", format!("{}:{HEIGHT}", reader.path().display())))
}
