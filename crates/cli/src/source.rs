//! The rigid surface of a contact: read from a file ([`crate::scan`]), or generated.

use std::path::Path;
use std::sync::OnceLock;

use clap::{Args, ValueEnum};
use gfmd_contact::Boundary;
use gfmd_field::Grid;
use gfmd_files::{Archive, Checksum, Dimension, Variable, contiguous, split_dataset};
use gfmd_surface::{Fill, Periodisation, Statistics};
use ndarray::Array2;
use serde::Serialize;

use crate::choice::{by_name, by_name_if, parse_choice};
use crate::elastic::sides;
use crate::failure::{Failure, SIZES, check_size};
use crate::generator::GeneratorArgs;
use crate::scan::{Prepared, Scan};
use crate::session::Session;

/// Flags that name or describe a surface.
#[derive(Args, Clone, Debug, Serialize)]
pub struct SourceArgs {
    /// Heights, peaks towards the body: a file of an instrument or program (docs/formats.md), or FILE.h5:/dataset
    #[arg(long, value_name = "FILE", conflicts_with_all = ["n", "hurst", "eps_t_inv", "eps_f_inv", "eps_c_inv", "rms_gradient", "rms_height", "seed", "dim",
        "method", "roll_off", "roll_off_shape", "amplitudes"])]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<String>,
    /// Channel of the file, by its name or its number from 0 (surface --list shows them); default: the first, or only one
    #[arg(long, value_name = "NAME|NUMBER", requires = "surface")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Way to give heights to undefined points of a file, which are refused without it
    #[arg(long, value_parser = parse_choice::<Fill>(), requires = "surface")]
    #[serde(serialize_with = "by_name_if", skip_serializing_if = "Option::is_none")]
    pub fill: Option<Fill>,
    /// Cell size, L or Lx,Ly; default: that of the file, or 1
    #[arg(long, value_delimiter = ',', num_args = 1..=2, value_name = "L[,LY]", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub length: Vec<f64>,
    /// Trend to subtract from the heights of a file
    #[arg(long, value_enum, default_value_t = Detrend::None)]
    pub detrend: Detrend,
    /// Method to make the heights of a file periodic
    #[arg(long, value_parser = parse_choice::<Periodisation>(), default_value = "as-is")]
    #[serde(serialize_with = "by_name")]
    pub periodise: Periodisation,
    /// Change the sign of the heights of a file, if its peaks point away from the body
    #[arg(long)]
    pub flip: bool,
    /// The generator.
    #[command(flatten)]
    #[serde(flatten)]
    pub generator: GeneratorArgs,
}

/// The trends that can be subtracted from measured heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Detrend {
    /// Nothing
    None,
    /// The least-squares plane
    Plane,
    /// The plane of the mean slope; without it opposite edges fit together on average
    Slope,
    /// The least-squares paraboloid
    Quadratic,
}

/// Heights ready for a contact.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Heights `[x, y]`, peaks towards the body.
    pub heights: Array2<f64>,
    /// The grid of the heights on the cell.
    pub grid: Grid,
    /// Unit of heights and lengths, if known.
    pub unit: Option<String>,
    /// Statistics of the heights.
    pub statistics: Statistics,
    /// The surroundings of the surface.
    pub boundary: Boundary,
    /// The origin of the heights and the operations on them.
    pub description: String,
    /// What the file says, if the heights come from one.
    pub scan: Option<Scan>,
    /// The file that the heights were read from, and its SHA-256.
    pub origin: Option<(String, String)>,
}

impl Surface {
    /// The rms gradient: the spectral one, or that of the differences inside if the surface does not repeat.
    pub fn rms_gradient(&self) -> f64 {
        match self.boundary {
            Boundary::Periodic => self.statistics.moments.rms_gradient(),
            Boundary::Free => self.statistics.rms_gradient_inside,
        }
    }

    /// The largest slope, by differences between neighbours inside.
    pub fn max_slope(&self) -> f64 {
        self.statistics.max_slope
    }

    /// The unit of heights and lengths; `length` if it is unknown.
    pub fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("length")
    }

    /// The SHA-256 of the heights, row by row.
    pub fn checksum(&self) -> String {
        Checksum::of_numbers(self.heights.iter().copied())
    }

    /// Writes the group `/surface` of a file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, archive: &mut Archive, axes: [&Dimension; 2]) -> Result<(), Failure> {
        self.write_as(archive, "/surface", "height of the rigid surface, peaks towards the elastic body", axes)
    }

    /// Writes the surface as a group of a file; the heights have the name `long_name`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn write_as(
        &self,
        archive: &mut Archive,
        group: &str,
        long_name: &str,
        axes: [&Dimension; 2],
    ) -> Result<(), Failure> {
        let height = Variable { dimensions: &axes, units: self.unit(), long_name };
        archive.write(&format!("{group}/height"), &height, &contiguous(&self.heights))?;
        archive.attribute(group, "description", self.description.as_str())?;
        archive.attribute(group, "rms_gradient", self.rms_gradient())?;
        archive.attribute(group, "boundary", self.boundary.name())?;
        archive.attribute(group, "height_sha256", self.checksum())?;
        let [length_x, length_y] = self.grid.lengths();
        archive.attribute(group, "length_x", length_x)?;
        archive.attribute(group, "length_y", length_y)?;
        if let Some((file, checksum)) = &self.origin {
            archive.attribute(group, "file", file.as_str())?;
            archive.attribute(group, "file_sha256", checksum.as_str())?;
        }
        self.scan.iter().try_for_each(|scan| scan.write(archive, group))
    }
}

/// The ratio of the steps across the periodic seam to those inside above which a warning is given.
const ROUGH_SEAM: f64 = 2.0;

impl SourceArgs {
    /// The keys of these flags in a configuration.
    pub(crate) fn names() -> Vec<&'static str> {
        // The names live as long as the program; there are a few, and they are made once.
        static NAMES: OnceLock<Vec<String>> = OnceLock::new();
        let names = NAMES.get_or_init(|| {
            let command = Self::augment_args(clap::Command::new("surface"));
            command.get_arguments().map(|argument| argument.get_id().to_string()).collect()
        });
        names.iter().map(String::as_str).collect()
    }

    /// The name of the surface in messages: its file, or `the generated surface`.
    pub fn name(&self) -> String {
        self.surface.clone().unwrap_or_else(|| "the generated surface".into())
    }

    /// Returns the flags with every default filled in, for the record of a run.
    ///
    /// # Errors
    /// Numbers that make no grid.
    pub fn resolved(&self) -> Result<Self, Failure> {
        let generator = if self.surface.is_none() { self.generator.resolved()? } else { self.generator.clone() };
        Ok(Self { generator, ..self.clone() })
    }

    /// Reads or generates the surface; a doubtful one is warned of.
    ///
    /// # Errors
    /// A file that cannot be read or has points without a height; flags that do not fit.
    pub fn surface(&self, session: &Session) -> Result<Surface, Failure> {
        self.bounded(Boundary::Periodic, session)
    }

    /// As [`surface`](Self::surface), with its surroundings.
    ///
    /// # Errors
    /// As `surface`; and a mirrored surface that does not repeat.
    pub fn bounded(&self, boundary: Boundary, session: &Session) -> Result<Surface, Failure> {
        if boundary == Boundary::Free && self.periodise != Periodisation::AsIs {
            return Err(Failure::value("--periodise", self.periodise.name(), "as-is with --boundary free"));
        }
        let (heights, grid, mut description, scan) = match &self.surface {
            Some(file) => {
                let Prepared { heights, grid, description, scan } = self.prepare(file)?;
                (heights, grid, description, Some(scan))
            }
            None => {
                let grid = self.generator.grid(&self.length)?;
                (self.generator.heights(&grid)?, grid, self.generator.to_string(), None)
            }
        };
        let name = self.name();
        self.check_sizes(&grid, &heights)?;
        let statistics = Statistics::of(&heights, &grid).map_err(|error| Failure::input(&name, error))?;
        if self.surface.is_some() && boundary == Boundary::Periodic {
            let ratio = statistics.seam.ratio().into_iter().flatten().fold(0.0, f64::max);
            description += &format!("; steps across the periodic seam are {ratio:.2} times those inside");
            if ratio > ROUGH_SEAM {
                let text = format!(
                    "{name}: steps across the periodic seam are {ratio:.1} times those inside; they count as \
                     roughness (rms gradient {:.4}, without the seam {:.4}). --detrend slope or --periodise mirror helps",
                    statistics.moments.rms_gradient(),
                    statistics.rms_gradient_inside
                );
                session.warn("rough-seam", text);
            }
        }
        let unit = scan.as_ref().and_then(|scan| scan.unit.clone());
        let origin = self.surface.as_deref().map(origin).transpose()?;
        Ok(Surface { heights, grid, unit, statistics, boundary, description, scan, origin })
    }

    /// Checks that squares of the lengths are numbers, for the statistics and the units of the results.
    fn check_sizes(&self, grid: &Grid, heights: &Array2<f64>) -> Result<(), Failure> {
        sides(grid).into_iter().try_for_each(|side| check_size("--length", side))?;
        let largest = heights.iter().fold(0.0, |largest: f64, height| largest.max(height.abs()));
        let all_equal = heights.iter().all(|height| *height == heights[[0, 0]]);
        if all_equal || !largest.is_finite() {
            return Ok(()); // judged by what uses the heights
        }
        let flag = match (&self.surface, self.generator.rms_height) {
            (Some(file), _) => file,
            (None, Some(_)) => "--rms-height",
            (None, None) => "--rms-gradient",
        };
        if SIZES.contains(&largest) {
            return Ok(());
        }
        let reason = format!("the largest height is {largest:e}; it must be between 1e-140 and 1e140");
        Err(Failure::input(flag, reason + ", which another unit of length makes it"))
    }
}

/// The file of a surface, without the name of a dataset in it, and its checksum.
pub(crate) fn origin(surface: &str) -> Result<(String, String), Failure> {
    let file = split_dataset(surface).map_or(surface, |(file, _)| file);
    let checksum = Checksum::of_file(Path::new(file)).map_err(|error| Failure::Input(error.to_string()))?;
    Ok((file.into(), checksum))
}
