//! Measured surface: the data of its file, and its preparation for a periodic cell.
//!
//! The order is: read, turn over, take out points, crop, find spikes and scars, level, remove the trend of the defined
//! points, fill the undefined ones, reduce the points, filter, make periodic.

use std::fmt;

use gfmd_field::Grid;
use gfmd_files::legible::line;
use gfmd_files::{Archive, Dimension, Reading, Topography, Variable};
use gfmd_problem::{key, setting, words};
use gfmd_surface::{Fill, Periodisation, fill, periodise};
use gfmd_unit::{Conversion, Units};
use ndarray::Array2;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

use super::SourceArgs;
use super::preparation::{Preparing, rms_gradient};
use crate::failure::Failure;
use crate::memory;
use gfmd_problem::options::given::ArrayOption;

/// Data of a file about its heights, and the changes made to them.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Scan {
    pub file: String,
    pub format: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Points and size of the scan itself, before it is made periodic.
    pub n: [usize; 2],
    pub size: [f64; 2],
    pub unit: Option<String>,
    /// Longest and shortest wavelengths that the scan resolves: its (shorter) side and two (larger) spacings.
    pub resolves: [f64; 2],
    pub undefined: usize,
    /// Number of points among which the undefined ones were.
    #[serde(skip)]
    pub points: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fill: Option<&'static str>,
    /// Statistics of the defined points alone, if some points are undefined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub defined: Option<Defined>,
    /// Steps of the preparation in their order, each with its numbers and the rms gradient before and after it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub preparation: Vec<Map<String, Value>>,
    /// Height taken from each row, or column, by levelling, length.
    #[serde(skip)]
    pub shifts: Vec<f64>,
    /// Band that the filters leave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<Map<String, Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conversion: Option<String>,
    #[serde(serialize_with = "as_map", skip_serializing_if = "Vec::is_empty")]
    pub details: Vec<(String, String)>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Doubts about the file, which become warnings of the run.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

/// Statistics of the defined points after the trend is removed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Defined {
    pub mean: f64,
    pub rms_height: f64,
    pub lowest: f64,
    pub highest: f64,
    /// Gradient by differences between defined neighbours.
    pub rms_gradient: f64,
}

/// Scan ready for a periodic cell.
pub struct PeriodicScan {
    /// Heights, `[x, y]`, without holes.
    pub heights: Array2<f64>,
    /// Grid of the cell.
    pub grid: Grid,
    /// File and its preparation in words.
    pub description: String,
    /// Scan as it is stored.
    pub scan: Scan,
    /// SHA-256 of the bytes of the file that were read.
    pub checksum: String,
}

/// Writes pairs as a map in their order; a repeated key gets a number.
fn as_map<S: Serializer>(pairs: &[(String, String)], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(pairs.len()))?;
    for (index, (key, value)) in pairs.iter().enumerate() {
        match pairs[..index].iter().filter(|(before, _)| before == key).count() {
            0 => map.serialize_entry(key, value)?,
            count => map.serialize_entry(&format!("{key} {}", count + 1), value)?,
        }
    }
    map.end()
}

impl SourceArgs {
    /// Reads the file, or takes the array, and prepares its heights. If neither a file nor a flag gives a size, it has
    /// the size of `cell`. A file that was `read` is not read again.
    pub fn prepare(
        &self,
        given: &ArrayOption,
        cell: Option<[f64; 2]>,
        read: Option<Topography>,
    ) -> Result<PeriodicScan, Failure> {
        let topography = match (given, read) {
            (_, Some(topography)) => Ok(topography),
            (ArrayOption::File(name), None) => {
                let (channel, image_heights) = (self.channel.as_deref(), self.image_heights);
                Topography::read_as(name, Reading { channel, image_heights })
            }
            (ArrayOption::Array(array), None) => Topography::of_array("surface", &array.view()),
            (ArrayOption::Load(_), None) => return Err(Failure::refused("surface is a contact; it must be an array")),
        };
        let topography = topography.map_err(|error| Failure::refused(error.to_string()))?;
        let name = given.to_string();
        let file = name.as_str();
        let incomplete = topography.check_complete().err().map(|error| error.to_string());
        let mut heights = topography.heights;
        let [nx, ny] = heights.dim().into();
        if nx < 2 {
            let reason = format!("{file}: the grid is {nx} x {ny} points; it must have at least 2 along x");
            return Err(Failure::refused(reason));
        }
        memory::fits(memory::SURFACE, file, [nx, ny])?;
        let mut notes = topography.notes;
        let mut size = topography.lengths;
        let conversion = match (&topography.unit, &self.unit) {
            (Some(from), Some(to)) => Conversion::between(from, to),
            _ => Ok(None),
        };
        if let Some(conversion) = conversion.map_err(|error| Failure::input(key("unit"), format!("{file}: {error}")))? {
            heights.mapv_inplace(|height| conversion.apply(height));
            size = size.map(|lengths| lengths.map(|length| conversion.apply(length)));
            notes.push(format!("heights and size converted {conversion}"));
        }
        let unit = self.unit.clone().or(topography.unit);
        let lengths = match (&self.size[..], size.or(cell)) {
            ([], Some(lengths)) => lengths,
            ([], None) => {
                notes.push("the file has no size; the cell is taken to be 1 long (it may be given)".into());
                [1.0, if ny == 1 { 1.0 } else { ny as f64 / nx as f64 }]
            }
            // A single length is the length along x; both spacings are equal.
            ([x], _) => [*x, if ny == 1 { 1.0 } else { x * ny as f64 / nx as f64 }],
            ([x, y, ..], _) => [*x, *y],
        };
        if let (false, Some([x, y])) = (self.size.is_empty(), size) {
            notes.push(format!("the given size replaces the one in the file, {x:?} by {y:?}"));
        }
        if unit.is_none() {
            notes.push("the file has no unit".into());
        }
        let grid = Grid::new([nx, ny], lengths).map_err(|error| Failure::input(key("size"), error))?;
        let mut description = topography.source;
        if self.flip {
            heights.mapv_inplace(|h| -h);
            description += ", turned over";
        }
        let mut preparing = Preparing::new(heights, grid, unit.as_deref());
        preparing.before_trend(&self.preparation)?;
        preparing.trend(self.detrend, file)?;
        let points = preparing.heights.len();
        let undefined = preparing.heights.iter().filter(|height| height.is_nan()).count();
        if undefined > 0 && self.fill.is_none() {
            let (refused, way_out) = match (incomplete, preparing.steps.is_empty()) {
                (Some(incomplete), true) => {
                    (incomplete, "gfmd.read_heights of Python reads them as NaN, to cut".into())
                }
                _ => {
                    let text = format!("{file}: {undefined} points are undefined after its preparation");
                    (text + &preparing.words, words![key("crop"), " cuts"])
                }
            };
            return Err(Failure::refused(words![
                refused,
                ": ",
                setting("fill", "harmonic"),
                " or ",
                setting("fill", "nearest"),
                " gives them heights, and ",
                way_out,
                " the good part out",
            ]));
        }
        let used = self.fill.filter(|_| undefined > 0);
        let mut defined = None;
        if let Some(how) = used {
            defined = Some(Defined::of(&preparing.heights, &preparing.grid));
            let filled = fill(&preparing.heights, preparing.grid.spacing(), how);
            preparing.filled(filled.map_err(|error| Failure::input(file, error))?, how, undefined);
        }
        preparing.after_fill(&self.preparation, false)?;
        let Preparing { heights, grid, steps, words, notes: made, warnings, shifts, .. } = preparing;
        description += &words;
        notes.extend(made);
        let [nx, ny] = grid.points();
        if self.periodise == Periodisation::Mirror {
            description += ", mirrored to a periodic cell of twice the size";
        }
        let scan = Scan {
            file: file.into(),
            format: topography.format,
            channel: topography.channel,
            n: [nx, ny],
            size: grid.lengths(),
            unit,
            resolves: self.band_left(&grid),
            undefined,
            points,
            fill: used.map(Fill::name),
            defined,
            preparation: steps,
            shifts,
            band: self.preparation.filter.as_ref().map(|bands| bands.record()),
            conversion: topography.conversion,
            details: topography.details,
            notes,
            warnings: topography.warnings.into_iter().chain(warnings).collect(),
        };
        let (heights, grid) =
            periodise(&heights, &grid, self.periodise).map_err(|error| Failure::input(file, error))?;
        Ok(PeriodicScan { heights, grid, description, scan, checksum: topography.sha256 })
    }
}

impl SourceArgs {
    /// Returns the longest and shortest wavelengths that the grid and the filters leave.
    fn band_left(&self, grid: &Grid) -> [f64; 2] {
        let sides = if grid.is_line() { 1 } else { 2 };
        let (lengths, spacing) = (grid.lengths(), grid.spacing());
        let longest = lengths[..sides].iter().copied().fold(f64::INFINITY, f64::min);
        let shortest = 2.0 * spacing[..sides].iter().copied().fold(0.0, f64::max);
        let (short, long) = self.preparation.filter.map_or((None, None), |bands| (bands.short, bands.long));
        [long.map_or(longest, |long| long.min(longest)), short.map_or(shortest, |short| short.max(shortest))]
    }
}

impl Defined {
    /// Computes the statistics of the heights that are not NaN; there is at least one.
    fn of(heights: &Array2<f64>, grid: &Grid) -> Self {
        let defined = || heights.iter().filter(|height| !height.is_nan());
        let count = defined().count() as f64;
        let mean = defined().sum::<f64>() / count;
        Self {
            mean,
            rms_height: (defined().map(|height| (height - mean).powi(2)).sum::<f64>() / count).sqrt(),
            lowest: defined().copied().fold(f64::INFINITY, f64::min),
            highest: defined().copied().fold(f64::NEG_INFINITY, f64::max),
            rms_gradient: rms_gradient(heights, grid),
        }
    }
}

impl Scan {
    /// Writes the record as attributes of a group.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&self, archive: &mut Archive, group: &str) -> Result<(), Failure> {
        let lines = |pairs: &[(String, String)]| -> String {
            pairs.iter().map(|(key, value)| format!("{key} = {value}\n")).collect()
        };
        let texts = [
            ("format", Some(self.format.to_owned())),
            ("channel", self.channel.clone()),
            ("fill", self.fill.map(str::to_owned)),
            ("conversion", self.conversion.clone()),
            ("details", Some(lines(&self.details)).filter(|text| !text.is_empty())),
            ("notes", Some(self.notes.join("\n")).filter(|text| !text.is_empty())),
        ];
        for (name, text) in texts {
            if let Some(text) = text {
                archive.attribute(group, name, text.replace('\0', " ").as_str())?;
            }
        }
        if !self.preparation.is_empty() {
            let text =
                serde_json::to_string(&self.preparation).map_err(|error| Failure::computation(error.to_string()))?;
            archive.attribute(group, "preparation", text.as_str())?;
        }
        if !self.shifts.is_empty() {
            let line = Dimension::index("scan_line", self.shifts.len(), "row or column of the cropped scan");
            let variable = Variable {
                dimensions: &[&line],
                units: self.unit.as_deref().unwrap_or("length"),
                long_name: "height subtracted from each row or column by levelling",
            };
            archive.write(&format!("{group}/preparation/shifts"), &variable, &self.shifts)?;
        }
        for (name, attribute) in [("s", "nesting_index_s"), ("l", "nesting_index_l")] {
            if let Some(index) = self.band.as_ref().and_then(|band| band.get(name)?.as_f64()) {
                archive.attribute(group, attribute, index)?;
            }
        }
        archive.attribute(group, "undefined_points", self.undefined as f64)?;
        archive.attribute(group, "longest_resolved_wavelength", self.resolves[0])?;
        archive.attribute(group, "shortest_resolved_wavelength", self.resolves[1])?;
        Ok(())
    }
}

/// Number of details in a printed report.
const LISTED: usize = 8;

/// Longest value of a detail that a printed report shows whole.
const WIDEST: usize = 100;

impl fmt::Display for Scan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [longest, shortest] = self.resolves;
        let unit = self.unit.as_deref().unwrap_or("length");
        let known = Units::new(Some(unit), None);
        let read = |value: f64| known.shown("length", value).map(|shown| shown.text(value));
        match (read(longest), read(shortest)) {
            (Some(longest), Some(shortest)) => {
                writeln!(f, "format: {}; it resolves wavelengths from {longest} to {shortest}", self.format)?;
            }
            _ => writeln!(
                f,
                "format: {}; it resolves wavelengths from {longest:.4e} to {shortest:.4e} {unit}",
                self.format
            )?,
        }
        match (self.undefined, self.fill) {
            (0, _) => {}
            (count, fill) => writeln!(
                f,
                "undefined points: {count} of {} ({:.2} %), fill {}",
                self.points,
                100.0 * count as f64 / self.points as f64,
                fill.unwrap_or("none")
            )?,
        }
        if let Some(Defined { mean, rms_height, lowest, highest, rms_gradient }) = self.defined {
            writeln!(
                f,
                "defined points alone: mean {mean:.6e}, rms height {rms_height:.6e}, lowest {lowest:.6e}, highest \
                 {highest:.6e} {unit}, rms gradient by differences {rms_gradient:.6e}"
            )?;
        }
        if let Some(conversion) = &self.conversion {
            writeln!(f, "{conversion}")?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        for (key, value) in self.details.iter().take(LISTED) {
            let (key, line) = (line(key), line(value));
            let shown: String = line.chars().take(WIDEST).collect();
            writeln!(f, "{key}: {shown}{}", if line.chars().count() > WIDEST { " ..." } else { "" })?;
        }
        match self.details.len() {
            0..=LISTED => Ok(()),
            count => writeln!(f, "({} more details with --json)", count - LISTED),
        }
    }
}
