//! Rigid surface of a contact: read from a file ([`scan`]), or generated.

pub mod preparation;
pub mod scan;

use clap::Args;
use gfmd_contact::Boundary;
use gfmd_field::{Grid, Share};
use gfmd_files::{Archive, Checksum, Dimension, Reader, Variable, contiguous, split_dataset};
use gfmd_surface::{
    Fill, Interpolation, Moments, Periodisation, Statistics, SurfaceError, composite, composite_inside, finer,
    finer_inside,
};
use gfmd_unit::{Units, canonical, digits, is_length};
use ndarray::{ArcArray2, Array2, ArrayRef2};
use serde::{Deserialize, Deserializer, Serialize};

use crate::failure::Failure;
use crate::memory::{self, Processes};
use crate::session::Session;
use crate::{processes, rows};
use gfmd_problem::options::GeneratorArgs;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::sides;
use gfmd_problem::options::values::{up_to, within};
use gfmd_problem::options::{named, named_if, parse_choice};
use gfmd_problem::{SIZES, check_size, key, setting, words};

use gfmd_problem::options::{Kinds, Options};
pub use preparation::Detrend;
use preparation::{PreparationArgs, Preparing};
use scan::{PeriodicScan, Scan};

/// Flags that name or describe a surface.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Surface")]
pub struct SourceArgs {
    /// Heights, peaks towards the body: a file from an instrument or program (docs/formats.md), or FILE.h5:/dataset
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = [
            "n", "shape", "hurst", "eps_t_inv", "eps_f_inv", "eps_c_inv", "rms_gradient", "rms_height", "seed", "dim",
            "method", "roll_off", "roll_off_shape", "amplitudes", "aspect", "lay",
            "marginal"
        ]
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    pub surface: Option<ArrayOption>,
    /// Channel of the file, by name or by number from 0 (surface --list shows them); default: the first, or only one
    #[arg(long, value_name = "NAME|NUMBER", requires = "surface")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Read the grey values of an 8-bit image as heights; required for such images, since most are mere pictures
    #[arg(long, requires = "surface")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub image_heights: bool,
    /// How to fill undefined points of a file (required if there are any)
    #[arg(long, value_parser = parse_choice::<Fill>(), requires = "surface")]
    #[serde(with = "named_if", skip_serializing_if = "Option::is_none")]
    pub fill: Option<Fill>,
    /// Unit of all lengths, such as um. Heights and sizes without a unit are in this unit; others are converted to it
    #[arg(long, value_name = "UNIT", value_parser = length_unit)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Unit of stresses given without one [default: Pa if a stress has a unit or lengths are in m]
    #[arg(long, value_name = "UNIT", value_parser = stress_unit)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    /// Cell size, L or Lx,Ly; default: the size in the file, or 1
    #[arg(
        long,
        alias = "length",
        value_delimiter = ',',
        num_args = 1..=2,
        value_name = "L[,LY]",
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "up_to::<2, _, _>")]
    #[option(kinds = Kinds::LENGTH)]
    pub size: Vec<f64>,
    /// Refinement factor per side for the points of a file: Fourier interpolation of the periodic surface, or a cubic
    /// spline with --boundary free. A generated surface takes --n instead
    #[arg(
        long,
        value_name = "TIMES",
        requires = "surface",
        value_parser = clap::value_parser!(u64).range(1..=LARGEST_REFINE)
    )]
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "times")]
    pub refine: Option<u64>,
    /// Interpolation between the heights of the file.
    #[arg(skip)]
    #[serde(skip)]
    pub interpolation: Interpolation,
    /// Factor by which each side has more points than the grid that was asked for ([`finer`](Self::finer)).
    #[arg(skip)]
    #[serde(skip)]
    pub finer: Option<u64>,
    /// Trend to subtract from the heights of a file: none, the least-squares plane, the mean slope, so that opposite
    /// edges meet on average, or a least-squares polynomial of degree 2 (quadratic), 3 (cubic) or D
    #[arg(
        long,
        default_value_t = Detrend::None,
        value_name = "none|plane|slope|quadratic|cubic|polynomial:D"
    )]
    pub detrend: Detrend,
    /// How to make the heights of a file periodic
    #[arg(long, value_parser = parse_choice::<Periodisation>(), default_value_t = Periodisation::AsIs)]
    #[serde(with = "named")]
    pub periodise: Periodisation,
    /// Change the sign of the heights of a file whose peaks point away from the body
    #[arg(long)]
    pub flip: bool,
    /// Second rough surface, on the body: a file as for --surface, prepared by the same flags, with the same x and y,
    /// and peaks towards the first surface
    #[arg(long, value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    pub second_surface: Option<ArrayOption>,
    /// Lateral displacement of the second surface, X or X,Y, length: fractions of a grid step by Fourier interpolation;
    /// with --boundary free whole steps only, keeping the overlap
    #[arg(
        long,
        value_delimiter = ',',
        num_args = 1..=2,
        value_name = "X[,Y]",
        requires = "second_surface",
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "up_to::<2, _, _>")]
    #[option(kinds = Kinds::LENGTH)]
    pub shift: Vec<f64>,
    /// The preparation of a scan.
    #[command(flatten)]
    #[serde(flatten)]
    pub preparation: PreparationArgs,
    /// The generator.
    #[command(flatten)]
    #[serde(flatten)]
    pub generator: GeneratorArgs,
}

/// Largest refinement factor along a side of a file's grid.
const LARGEST_REFINE: u64 = 64;

/// Parses the name of a unit of length.
///
/// # Errors
/// Returns an error for any other name.
pub fn length_unit(text: &str) -> Result<String, String> {
    match is_length(text) {
        true => Ok(canonical(text).to_owned()),
        false => Err("it must be a unit of length, such as m, mm, um, nm, pm, in".into()),
    }
}

/// Parses the name of a unit of stress.
///
/// # Errors
/// Returns an error for any other name.
pub fn stress_unit(text: &str) -> Result<String, String> {
    match Units::is_stress(text) {
        true => Ok(text.to_owned()),
        false => Err("it must be a unit of stress, such as Pa, MPa, GPa, N/mm^2".into()),
    }
}

fn times<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    within::<1, LARGEST_REFINE, _, _>(deserializer).map(Some)
}

/// Builds the grid of a generated surface, if it fits into the memory of this machine.
///
/// # Errors
/// Returns an error if the numbers do not make a grid, or if the points do not fit into memory.
pub fn grid_of(generator: &GeneratorArgs, length: &[f64]) -> Result<Grid, Failure> {
    generated_grid(generator, length, Processes::ALONE)
}

/// Builds the grid like [`grid_of`], for several processes that share the points.
fn generated_grid(generator: &GeneratorArgs, length: &[f64], processes: Processes) -> Result<Grid, Failure> {
    memory::fits_shared(memory::SURFACE, key("n"), generator.points()?, processes)?;
    // Other impossible lengths are refused with the grid.
    let given = length.iter().filter(|length| length.is_finite() && **length > 0.0);
    given.into_iter().try_for_each(|length| check_size("size", *length))?;
    Ok(generator.grid(length)?)
}

/// Heights ready for a contact.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Heights `[x, y]`, peaks towards the body, rows of this process.
    pub heights: ArcArray2<f64>,
    /// Grid of the heights on the cell.
    pub grid: Grid,
    /// Rows of this process; all rows if it is alone.
    pub share: Share,
    /// Unit of heights and lengths, if known.
    pub unit: Option<String>,
    /// Unit of stresses, if one is named.
    pub stress_unit: Option<String>,
    /// Statistics of the heights.
    pub statistics: Statistics,
    /// Surroundings of the surface.
    pub boundary: Boundary,
    /// Origin of the heights, and the operations on them.
    pub description: String,
    /// Data of the file, if the heights come from one. With several processes, only the first one has it, and the
    /// fields that follow.
    pub scan: Option<Scan>,
    /// File of the heights, and its SHA-256.
    pub origin: Option<(String, String)>,
    /// Second surface, contained in these heights.
    pub second: Option<Second>,
    /// True if the heights contain a shape, known between the points by its closed form.
    pub has_shape: bool,
    /// True if the heights are a shape alone, without roughness.
    pub is_shape_alone: bool,
}

/// Second of two rough surfaces in contact.
#[derive(Clone, Debug, Serialize)]
pub struct Second {
    /// File of the surface.
    pub second_surface: String,
    /// Displacement along x and y, length.
    pub shift: [f64; 2],
    /// Record of the file.
    pub second_scan: Scan,
    /// SHA-256 of the file.
    #[serde(skip)]
    checksum: String,
}

/// Returns the highest of the heights of all processes.
pub fn highest(share: &Share, heights: &ArrayRef2<f64>) -> f64 {
    let own = heights.fold(f64::NEG_INFINITY, |highest, height| highest.max(*height));
    share.each(own).into_iter().fold(f64::NEG_INFINITY, f64::max)
}

impl Surface {
    /// Returns true if the heights, or a part of them, were read at points, not made of waves. Only the first one of
    /// several processes knows.
    pub fn is_read(&self) -> bool {
        self.scan.is_some() || self.second.is_some()
    }

    /// Returns the highest point of the grid, length.
    pub fn highest(&self) -> f64 {
        highest(&self.share, &self.heights)
    }

    /// Returns the moments: spectral ones, or from inner differences if the surface is not periodic.
    pub fn moments(&self) -> Moments {
        match self.boundary {
            Boundary::Periodic => self.statistics.moments,
            Boundary::Free => self.statistics.moments_inside(),
        }
    }

    /// Returns the rms gradient: the spectral one, or from inner differences if the surface is not periodic.
    pub fn rms_gradient(&self) -> f64 {
        match self.boundary {
            Boundary::Periodic => self.statistics.moments.rms_gradient(),
            Boundary::Free => self.statistics.rms_gradient_inside,
        }
    }

    /// Returns the largest slope, from differences between inner neighbours.
    pub fn max_slope(&self) -> f64 {
        self.statistics.max_slope
    }

    /// Returns the unit of heights and lengths; `length` if it is unknown.
    pub fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("length")
    }

    /// Returns the unit of stresses, if it is known.
    pub fn stress(&self) -> Option<&str> {
        self.stress_unit.as_deref().or_else(|| (self.unit.as_deref() == Some("m")).then_some(Units::PASCAL))
    }

    /// Returns the units of the problem.
    pub fn units(&self) -> Units {
        Units::new(self.unit.as_deref(), self.stress_unit.as_deref())
    }

    /// Returns the SHA-256 of the heights, row by row; with several processes, only the first one gets it.
    pub fn checksum(&self) -> String {
        rows::checksum(&self.share, &contiguous(&self.heights))
    }

    /// Writes the group `/surface` of a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&self, archive: &mut Archive, axes: [&Dimension; 2]) -> Result<(), Failure> {
        self.write_as(archive, GROUP, LONG_NAME, axes)
    }

    /// Writes the surface as a group of a file; the heights get the name `long_name`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_as(
        &self,
        archive: &mut Archive,
        group: &str,
        long_name: &str,
        axes: [&Dimension; 2],
    ) -> Result<(), Failure> {
        let height = Variable { dimensions: &axes, units: self.unit(), long_name };
        archive.write(&format!("{group}/height"), &height, &contiguous(&self.heights))?;
        self.write_about(archive, group, self.checksum())
    }

    /// Writes like [`write`](Self::write) if several processes have the rows of the heights; only the first one has the
    /// `archive`.
    ///
    /// # Errors
    /// Returns an error, at the first process, if the file cannot be written.
    pub fn write_shared(&self, archive: Option<&mut Archive>, axes: [&Dimension; 2]) -> Result<(), Failure> {
        self.write_shared_as(archive, GROUP, LONG_NAME, axes)
    }

    /// Writes like [`write_as`](Self::write_as) if several processes have the rows of the heights.
    ///
    /// # Errors
    /// Returns an error, at the first process, if the file cannot be written.
    pub fn write_shared_as(
        &self,
        mut archive: Option<&mut Archive>,
        group: &str,
        long_name: &str,
        axes: [&Dimension; 2],
    ) -> Result<(), Failure> {
        let height = Variable { dimensions: &axes, units: self.unit(), long_name };
        let path = format!("{group}/height");
        let defined = archive.as_mut().map_or(Ok(()), |archive| archive.define_rows(&path, &height));
        let mut sum = Checksum::default();
        let see = |values: &[f64]| values.iter().for_each(|height| sum.bytes(&height.to_le_bytes()));
        let written = rows::write(&self.share, self.heights.view(), archive.as_deref_mut(), (&path, None), see);
        defined?;
        written?;
        archive.map_or(Ok(()), |archive| self.write_about(archive, group, sum.text()))
    }

    /// Writes the attributes of a group, with the `checksum` of the heights.
    fn write_about(&self, archive: &mut Archive, group: &str, checksum: String) -> Result<(), Failure> {
        archive.attribute(group, "description", self.description.as_str())?;
        archive.attribute(group, "rms_gradient", self.rms_gradient())?;
        archive.attribute(group, "boundary", self.boundary.name())?;
        archive.attribute(group, "height_sha256", checksum)?;
        let [size_x, size_y] = self.grid.lengths();
        archive.attribute(group, "size_x", size_x)?;
        archive.attribute(group, "size_y", size_y)?;
        if let Some((file, checksum)) = &self.origin {
            archive.attribute(group, "file", file.as_str())?;
            archive.attribute(group, "file_sha256", checksum.as_str())?;
        }
        if let Some(Second { second_surface, shift: [x, y], checksum, .. }) = &self.second {
            archive.attribute(group, "second_file", file_of(second_surface))?;
            archive.attribute(group, "second_file_sha256", checksum.as_str())?;
            archive.attribute(group, "shift_x", *x)?;
            archive.attribute(group, "shift_y", *y)?;
        }
        self.scan.iter().try_for_each(|scan| scan.write(archive, group))
    }

    /// Returns the surface with statistics of its heights plus `lift`, the displacement of the surface by a moved base
    /// alone, rows of this process. The heights stay as they are.
    ///
    /// # Errors
    /// Returns an error if the heights have no statistics.
    pub fn displaced(self, lift: &Array2<f64>) -> Result<Self, SurfaceError> {
        let statistics = Statistics::distributed(&(&self.heights + lift), &self.grid, &self.share)?;
        Ok(Self { statistics, ..self })
    }

    /// Returns the surface with the whole heights at the first process; `None` at the others.
    pub fn gathered(&self) -> Option<Self> {
        let heights = rows::gathered(&self.share, self.heights.view())?;
        let Self { grid, statistics, boundary, has_shape, is_shape_alone, .. } = *self;
        Some(Self {
            heights: heights.into_shared(),
            grid,
            share: grid.whole(),
            unit: self.unit.clone(),
            stress_unit: self.stress_unit.clone(),
            statistics,
            boundary,
            description: self.description.clone(),
            scan: self.scan.clone(),
            origin: self.origin.clone(),
            second: self.second.clone(),
            has_shape,
            is_shape_alone,
        })
    }
}

/// Returns the unit of the heights of a group, as the file has it; `None` for any consistent unit.
pub fn stored_unit(reader: &Reader, group: &str) -> Option<String> {
    reader.text(&format!("{group}/height"), "units").ok().filter(|unit| unit != "length")
}

/// Group of the surface in a file.
const GROUP: &str = "/surface";

/// Description of its heights.
const LONG_NAME: &str = "height of the rigid surface, peaks towards the elastic body";

/// Ratio of steps across the periodic seam to inner steps above which a warning is given.
const ROUGH_SEAM: f64 = 2.0;

/// Relative difference up to which the lengths of two cells count as equal; headers have some six digits.
const SAME_LENGTH: f64 = 1e-6;

impl SourceArgs {
    /// Returns the name of the surface in messages: its file, `surface` for an array, `the shape`, or `the
    /// generated surface`.
    pub fn name(&self) -> String {
        match &self.surface {
            Some(ArrayOption::File(file)) => file.clone(),
            Some(_) => "surface".into(),
            None if !self.generator.is_rough() => "the shape".into(),
            None => "the generated surface".into(),
        }
    }

    /// Returns the flags with every default filled in, for the record of a run.
    ///
    /// # Errors
    /// Returns an error if the numbers do not make a grid.
    pub fn resolved(&self) -> Result<Self, Failure> {
        let generator = if self.surface.is_none() { self.generator.resolved()? } else { self.generator.clone() };
        Ok(Self { generator, ..self.clone() })
    }

    /// Reads or generates the surface, and warns if it is doubtful.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or has points without a height, or if flags do not fit.
    pub fn surface(&self, session: &Session) -> Result<Surface, Failure> {
        self.bounded(Boundary::Periodic, session)
    }

    /// Reads or generates like [`surface`](Self::surface), with a boundary condition.
    ///
    /// # Errors
    /// Fails like `surface`; also for a mirrored surface that is not periodic.
    pub fn bounded(&self, boundary: Boundary, session: &Session) -> Result<Surface, Failure> {
        // The parser accepts these flags beside a flag of the generator.
        let of_files = [
            ("channel", self.channel.is_some()),
            ("image_heights", self.image_heights),
            ("fill", self.fill.is_some()),
            ("refine", self.refine.is_some() && self.second_surface.is_none()),
        ];
        if let (None, Some((option, _))) = (&self.surface, of_files.into_iter().find(|(_, given)| *given)) {
            return Err(Failure::value(key(option), "given", words!["left out without ", key("surface")]));
        }
        let is_made = self.surface.is_none() && self.second_surface.is_none();
        let of_scans = [
            ("detrend", self.detrend != Detrend::None),
            ("periodise", self.periodise != Periodisation::AsIs),
            ("flip", self.flip),
        ];
        let given = of_scans.into_iter().find_map(|(option, given)| given.then_some(option));
        if let (true, Some(option)) = (is_made, given.or_else(|| self.preparation.of_scans())) {
            return Err(Failure::value(key(option), "given", words!["left out without ", key("surface")]));
        }
        let is_fitted = self.preparation.level.is_some() || self.detrend != Detrend::None;
        if !(self.preparation.exclude.is_empty() || is_fitted) {
            let fits = words![key("level"), " or ", key("detrend")];
            return Err(Failure::value(key("exclude"), "given", words!["left out without ", fits]));
        }
        if boundary == Boundary::Free && self.periodise != Periodisation::AsIs {
            return Err(Failure::value(
                key("periodise"),
                self.periodise.name(),
                words!["as-is with ", setting("boundary", "free")],
            ));
        }
        let LoadedHeights { heights, grid, share, mut description, scan, origin, second } =
            self.made(boundary, session)?;
        for scan in scan.iter().chain(second.as_ref().map(|second| &second.second_scan)) {
            for text in &scan.warnings {
                session.warn("doubtful-file", format!("{}: {text}", scan.file));
            }
        }
        let name = self.name();
        self.check_sizes(&grid, &heights, &share)?;
        let statistics =
            Statistics::distributed(&heights, &grid, &share).map_err(|error| Failure::input(&name, error))?;
        if (scan.is_some() || second.is_some()) && boundary == Boundary::Periodic {
            let ratio = statistics.seam.ratio().into_iter().flatten().fold(0.0, f64::max);
            description += &format!("; steps across the periodic seam are {ratio:.2} times those inside");
            if ratio > ROUGH_SEAM {
                let text = format!(
                    "{name}: steps across the periodic seam are {ratio:.1} times those inside; they count as \
                     roughness (rms gradient {}, without the seam {}). --detrend slope or --periodise mirror \
                     helps",
                    digits(statistics.moments.rms_gradient()),
                    digits(statistics.rms_gradient_inside)
                );
                session.warn("rough-seam", text);
            }
        }
        let scans = scan.iter().chain(second.as_ref().map(|second| &second.second_scan));
        let unit = scans.into_iter().find_map(|scan| scan.unit.clone()).or_else(|| self.unit.clone());
        let stress_unit = self.stress_unit.clone();
        let has_shape = self.surface.is_none() && self.generator.shape.is_some() && self.preparation.filter.is_none();
        let is_shape_alone = has_shape && !self.generator.is_rough();
        Ok(Surface {
            heights: heights.into_shared(),
            grid,
            share,
            unit,
            stress_unit,
            statistics,
            boundary,
            description,
            scan,
            origin,
            second,
            has_shape,
            is_shape_alone,
        })
    }

    /// Makes the heights of the rows of this process. With several processes, each makes its own if the generator can;
    /// otherwise the first one makes or reads all heights, and distributes them.
    fn made(&self, boundary: Boundary, session: &Session) -> Result<LoadedHeights, Failure> {
        let Some(ranks) = session.ranks() else { return self.whole(boundary, session) };
        let shared = |grid: &Grid| session.share(grid).map_err(|error| Failure::input(self.name(), error));
        let is_filtered = self.preparation.filter.is_some();
        // Points of a finer patch lie between the points where waves begin.
        let is_centred = boundary == Boundary::Free && self.finer.is_some();
        let is_made = self.surface.is_none() && self.second_surface.is_none() && self.generator.is_shared();
        if is_made && !is_filtered && !is_centred {
            // Another machine may have less memory.
            let grid = session.agree(generated_grid(&self.generator, &self.size, session.processes()))?;
            self.generator.check_shape(&grid, boundary == Boundary::Periodic)?;
            let share = shared(&grid)?;
            return Ok(LoadedHeights::generated(
                self.generator.heights_shared(&grid, &share)?,
                grid,
                share,
                &self.generator,
            ));
        }
        let made = if session.is_first() { self.whole(boundary, session).map(Some) } else { Ok(None) };
        let mut made = session.agree(made)?;
        let words = made.as_ref().map_or([0; 4], |made| {
            let ([nx, ny], [x, y]) = (made.grid.points(), made.grid.lengths());
            [nx as u64, ny as u64, x.to_bits(), y.to_bits()]
        });
        let [nx, ny, x, y] = processes::of_first(&**ranks, words);
        let (points, lengths) = ([nx as usize, ny as usize], [f64::from_bits(x), f64::from_bits(y)]);
        let grid = Grid::new(points, lengths).map_err(|error| Failure::input(key("size"), error))?;
        let share = shared(&grid)?;
        let heights = rows::handed_out(&share, made.as_ref().map(|made| &made.heights), points[1]);
        if let Some(made) = &mut made {
            // Frees the whole heights before the work on the own rows.
            made.heights = Array2::zeros([0, 0]);
        }
        Ok(match made {
            Some(made) => LoadedHeights { heights, share, ..made },
            None => LoadedHeights::generated(heights, grid, share, &self.generator),
        })
    }

    /// Makes all heights.
    fn whole(&self, boundary: Boundary, session: &Session) -> Result<LoadedHeights, Failure> {
        let (mut heights, mut grid, mut description, scan, origin) = match &self.surface {
            Some(given) => {
                let PeriodicScan { heights, grid, description, scan, checksum } =
                    self.prepare(given, None, session.take_map(given, self.channel.as_deref()))?;
                let origin = given.file().map(|file| (file_of(file).into(), checksum));
                (heights, grid, description, Some(scan), origin)
            }
            None => {
                let grid = grid_of(&self.generator, &self.size)?;
                self.generator.check_shape(&grid, boundary == Boundary::Periodic)?;
                let heights = match (boundary, self.finer) {
                    (Boundary::Free, Some(times)) => self.generator.heights_centred(&grid, times as usize)?,
                    _ => self.generator.heights(&grid)?,
                };
                let is_periodic = boundary == Boundary::Periodic && self.generator.is_periodic();
                let mut preparing = Preparing::new(heights, grid, self.unit.as_deref());
                preparing.after_fill(&self.preparation, is_periodic)?;
                let Preparing { heights, words, warnings, .. } = preparing;
                warnings.into_iter().for_each(|text| session.warn("filter", text));
                (heights, grid, self.generator.to_string() + &words, None, None)
            }
        };
        let second = match &self.second_surface {
            Some(file) => {
                let (second, there) = self.second(file, &grid, scan.as_ref())?;
                let made = composed(&heights, &there, &grid, (second.shift, boundary));
                (heights, grid) = made.map_err(|error| Failure::input(key("shift"), error))?;
                description += &format!("; against {file}, moved by {:?}", second.shift);
                Some(second)
            }
            None => None,
        };
        if let Some(times) = self.refine.filter(|times| *times > 1) {
            let [nx, ny] = grid.points().map(|points| points.saturating_mul(times as usize));
            memory::fits(memory::SURFACE, key("refine"), [nx, if grid.is_line() { 1 } else { ny }])?;
            let found = match boundary {
                Boundary::Periodic => finer(&heights, &grid, times as usize, self.interpolation),
                Boundary::Free => finer_inside(&heights, &grid, times as usize, self.interpolation),
            };
            (heights, grid) = found.map_err(|error| Failure::input(key("refine"), error))?;
            description += &format!("; {times} times as many points along each side");
        }
        Ok(LoadedHeights { heights, grid, share: grid.whole(), description, scan, origin, second })
    }

    /// Returns this source with `times` as many points along each side, interpolated by `how` between the points of a
    /// file. A generated surface is the same one on a finer grid. On both grids the points of a patch are the centres
    /// of equal cells.
    ///
    /// # Errors
    /// Returns an error if nothing is known between the points of the surface.
    pub fn finer(&self, times: u64, how: Interpolation) -> Result<Self, Failure> {
        let mut finer = Self { finer: Some(times.saturating_mul(self.finer.unwrap_or(1))), ..self.resolved()? };
        if self.surface.is_some() || self.second_surface.is_some() {
            finer.refine = Some(times.saturating_mul(self.refine.unwrap_or(1)));
            finer.interpolation = how;
        } else if self.generator.has_finer_grids() {
            finer.generator.n.iter_mut().for_each(|n| *n = n.saturating_mul(times as usize));
        } else {
            let method = format!("{:?}", self.generator.method).to_lowercase();
            return Err(Failure::value(key("method"), method, "psd for a finer grid of the same surface"));
        }
        Ok(finer)
    }

    /// Reads the second surface, which must have the cell and the points of the first.
    fn second(&self, file: &ArrayOption, grid: &Grid, first: Option<&Scan>) -> Result<(Second, Array2<f64>), Failure> {
        const OPTION: &str = "second_surface";
        let cell = first.map_or(grid.lengths(), |scan| scan.size);
        let PeriodicScan { heights, grid: there, scan, checksum, .. } = self.prepare(file, Some(cell), None)?;
        let close = |(a, b): (f64, f64)| (a - b).abs() <= SAME_LENGTH * b;
        let sides = if grid.is_line() { 1 } else { 2 };
        if there.points() != grid.points() || !there.lengths().into_iter().zip(grid.lengths()).take(sides).all(close) {
            let size = |grid: &Grid| {
                let ([nx, ny], [x, y]) = (grid.points(), grid.lengths());
                format!("{nx} x {ny} points on {x} x {y}")
            };
            return Err(Failure::input(
                key(OPTION),
                format!("{file} has {}; it must have {}", size(&there), size(grid)),
            ));
        }
        if let (Some(found), Some(allowed)) = (&scan.unit, first.and_then(|first| first.unit.as_ref()))
            && found != allowed
        {
            return Err(Failure::input(key(OPTION), format!("the unit of {file} is {found}; it must be {allowed}")));
        }
        let shift = [0, 1].map(|axis| self.shift.get(axis).copied().unwrap_or(0.0));
        Ok((Second { second_surface: file.to_string(), shift, second_scan: scan, checksum }, heights))
    }

    /// Checks that squares of the lengths are finite numbers, for the statistics and the units of the results.
    fn check_sizes(&self, grid: &Grid, heights: &Array2<f64>, share: &Share) -> Result<(), Failure> {
        sides(grid).into_iter().try_for_each(|side| check_size("size", side))?;
        let largest = heights.iter().fold(0.0, |largest: f64, height| largest.max(height.abs()));
        let largest = share.each(largest).into_iter().fold(0.0, f64::max);
        let first = share.first(heights.first().copied());
        let all_equal = !share.any(heights.iter().any(|height| Some(*height) != first));
        if all_equal || !largest.is_finite() {
            return Ok(()); // checked where the heights are used
        }
        let name = match (&self.surface, &self.generator) {
            (Some(_), _) => self.name().into(),
            (None, GeneratorArgs { shape: Some(_), .. }) => key("shape"),
            (None, GeneratorArgs { rms_height: Some(_), .. }) => key("rms_height"),
            (None, _) => key("rms_gradient"),
        };
        if SIZES.contains(&largest) {
            return Ok(());
        }
        let reason = format!("the largest height is {largest:e}; it must be between 1e-140 and 1e140");
        Err(Failure::input(name, reason + "; choose another unit of length"))
    }
}

/// Heights of the rows of this process, with their origin.
struct LoadedHeights {
    heights: Array2<f64>,
    grid: Grid,
    share: Share,
    description: String,
    scan: Option<Scan>,
    origin: Option<(String, String)>,
    second: Option<Second>,
}

impl LoadedHeights {
    fn generated(heights: Array2<f64>, grid: Grid, share: Share, generator: &GeneratorArgs) -> Self {
        let (scan, origin, second) = (None, None, None);
        Self { heights, grid, share, description: generator.to_string(), scan, origin, second }
    }
}

/// Returns the composite of two surfaces, the second one shifted by `shift`, and its grid.
///
/// # Errors
/// Returns an error if the surfaces have different grids, or if the shift is impossible.
pub fn composed(
    first: &Array2<f64>,
    second: &Array2<f64>,
    grid: &Grid,
    (shift, boundary): ([f64; 2], Boundary),
) -> Result<(Array2<f64>, Grid), SurfaceError> {
    match boundary {
        Boundary::Periodic => composite(first, second, grid, shift).map(|heights| (heights, *grid)),
        Boundary::Free => composite_inside(first, second, grid, shift),
    }
}

/// Returns the name of a file without a dataset in it.
pub fn file_of(surface: &str) -> &str {
    split_dataset(surface).map_or(surface, |(file, _)| file)
}
