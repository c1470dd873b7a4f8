//! Options that prepare a scan, and the record of what they did.

mod regions;
mod values;

use clap::{ArgAction, Args};
use gfmd_field::Grid;
use gfmd_prepare::{
    Cropped, Edges, Filter, Kernel, Levelled, PrepareError, Resampled, Scars, Smoothed, Spikes, crop, descar, despike,
    equivalent_cut_off, level_columns, level_rows, remove_polynomial, resample, smooth,
};
use gfmd_problem::options::quantities::text_in_units;
use gfmd_problem::options::{Kinds, Options};
use gfmd_problem::{key, words};
use gfmd_surface::{Fill, Trend, remove_from_defined};
use gfmd_unit::Units;
use ndarray::{Array2, Zip};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::failure::Failure;
use crate::memory;
pub use regions::Region;
pub use values::{Bands, Box2, Detrend, Level, Rows, ScarRule, SpikeRule};

/// Options of the preparation of a scan, in the order in which they act.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Preparation")]
pub struct PreparationArgs {
    /// Part of the scan to keep, lengths from its corner: points with X0 <= x < X1 and Y0 <= y < Y1. An omitted end is
    /// the end of the scan
    #[arg(long, value_name = "X0:X1[,Y0:Y1]", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTHS_AMONG_WORDS)]
    pub crop: Option<Box2>,
    /// Points to make undefined: a box, in lengths from the corner of the scan in its file; all heights below or above
    /// a value; or the nonzero points of a height map. Repeatable
    #[arg(
        long,
        value_name = "X0:X1,Y0:Y1|below:Z|above:Z|FILE",
        action = ArgAction::Append,
        allow_hyphen_values = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LENGTHS_AMONG_WORDS)]
    pub invalid: Vec<Region>,
    /// Points to leave out of the fits of --level and --detrend, given as for --invalid; they keep their heights.
    /// Repeatable
    #[arg(
        long,
        value_name = "X0:X1,Y0:Y1|below:Z|above:Z|FILE",
        action = ArgAction::Append,
        allow_hyphen_values = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LENGTHS_AMONG_WORDS)]
    pub exclude: Vec<Region>,
    /// Remove spikes: points further than K robust standard deviations from the median of WINDOW x WINDOW points around
    /// them [without a value: 5,5]
    #[arg(long, value_name = "K[,WINDOW]", num_args = 0..=1, default_missing_value = "5,5")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub despike: Option<SpikeRule>,
    /// Remove line defects along x: runs of at least LENGTH points, up to WIDTH rows wide, above or below the adjacent
    /// rows by LOW, and somewhere by HIGH, in units of the rms row difference [without a value: 0.666,0.25,16,4]
    #[arg(
        long,
        value_name = "HIGH,LOW,LENGTH,WIDTH",
        num_args = 0..=1,
        default_missing_value = "0.666,0.25,16,4"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub descar: Option<ScarRule>,
    /// Level the rows (lines along x) or the columns of a scan by mean, median, median difference between neighbours,
    /// or a polynomial of degree D in each
    #[arg(long, value_name = "rows|columns:mean|median|difference|polynomial:D")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<Level>,
    /// Points of a coarser grid: S filter of four new spacings, then interpolation
    #[arg(long, value_delimiter = ',', num_args = 1..=2, value_name = "N[,NY]", conflicts_with = "resample_spacing")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub resample: Vec<usize>,
    /// Spacing of a coarser grid, length
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTH)]
    pub resample_spacing: Option<f64>,
    /// Filters by nesting index, length: s removes waves shorter than its index, l longer ones. kind=gaussian (ISO
    /// 16610-61), robust (16610-71) or spline (16610-22, profiles); edges=regression, reflect or periodic; degree=0, 1
    /// or 2 of the regression
    #[arg(long, value_name = "s:L,l:L[,kind=..][,edges=..][,degree=..]")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTHS_AMONG_WORDS)]
    pub filter: Option<Bands>,
}

impl PreparationArgs {
    /// Returns the first option that only a scan can have, if one is given.
    pub(super) fn of_scans(&self) -> Option<&'static str> {
        let given = [
            ("crop", self.crop.is_some()),
            ("invalid", !self.invalid.is_empty()),
            ("exclude", !self.exclude.is_empty()),
            ("despike", self.despike.is_some()),
            ("descar", self.descar.is_some()),
            ("level", self.level.is_some()),
            ("resample", !self.resample.is_empty()),
            ("resample_spacing", self.resample_spacing.is_some()),
        ];
        given.into_iter().find_map(|(option, is_given)| is_given.then_some(option))
    }
}

/// Heights on the way from a file to a contact.
pub(super) struct Preparing<'a> {
    pub(super) heights: Array2<f64>,
    pub(super) grid: Grid,
    pub(super) unit: Option<&'a str>,
    /// Steps so far, for the record.
    pub(super) steps: Vec<Map<String, Value>>,
    /// Notes for a reader.
    pub(super) notes: Vec<String>,
    /// Doubts, which become warnings.
    pub(super) warnings: Vec<String>,
    /// Steps in words, each after a comma.
    pub(super) words: String,
    /// Height taken from each row, or column, by levelling; empty without levelling by a shift.
    pub(super) shifts: Vec<f64>,
    /// Points left out of fits.
    excluded: Option<Array2<bool>>,
}

impl<'a> Preparing<'a> {
    pub(super) fn new(heights: Array2<f64>, grid: Grid, unit: Option<&'a str>) -> Self {
        let (steps, notes, warnings) = (Vec::new(), Vec::new(), Vec::new());
        let (words, shifts) = (String::new(), Vec::new());
        Self { heights, grid, unit, steps, notes, warnings, words, shifts, excluded: None }
    }

    /// Returns the rms gradient by differences between defined neighbours.
    pub(super) fn rms_gradient(&self) -> f64 {
        rms_gradient(&self.heights, &self.grid)
    }

    fn undefined(&self) -> usize {
        self.heights.iter().filter(|height| height.is_nan()).count()
    }

    /// Formats a length in a readable unit.
    fn length(&self, length: f64) -> String {
        Units::new(self.unit, None).words(length, "length")
    }

    fn sides(&self) -> usize {
        if self.grid.is_line() { 1 } else { 2 }
    }

    /// Puts heights in place of the present ones, and records the step with what it changed.
    fn replace(&mut self, step: &str, with: Value, heights: Array2<f64>, words: &str) {
        self.replace_on(self.grid, step, with, heights, words);
    }

    /// Replaces like [`replace`](Self::replace), with heights on another grid.
    fn replace_on(&mut self, grid: Grid, step: &str, with: Value, heights: Array2<f64>, words: &str) {
        let (before, undefined) = (self.rms_gradient(), self.undefined());
        let (mut squares, mut least, mut most, mut count) = (0.0, f64::INFINITY, f64::NEG_INFINITY, 0_usize);
        if heights.dim() == self.heights.dim() {
            Zip::from(&self.heights).and(&heights).for_each(|old, new| {
                let removed = old - new;
                if !removed.is_nan() {
                    squares += removed * removed;
                    (least, most, count) = (least.min(removed), most.max(removed), count + 1);
                }
            });
        }
        (self.heights, self.grid) = (heights, grid);
        let mut record = Map::from_iter([("step".to_owned(), Value::from(step))]);
        if let Value::Object(with) = with {
            record.extend(with);
        }
        if most > least {
            record.insert("rms_removed".into(), (squares / count as f64).sqrt().into());
            record.insert("peak_to_valley_removed".into(), (most - least).into());
        }
        if self.undefined() != undefined {
            record.insert("undefined_before".into(), undefined.into());
            record.insert("undefined_after".into(), self.undefined().into());
        }
        let after = self.rms_gradient();
        record.insert("rms_gradient_before".into(), before.into());
        record.insert("rms_gradient_after".into(), after.into());
        self.steps.push(record);
        self.words += &format!(", {words}");
        let change = 100.0 * (before / after - 1.0);
        let of_load = match change.is_finite() && change.abs() >= 0.05 {
            true => {
                let way = if change > 0.0 { "rises" } else { "falls" };
                format!("; p* {way} by {:.1} % at the same pressure", change.abs())
            }
            false => String::new(),
        };
        self.notes.push(format!("{words}: rms gradient {before:.4} -> {after:.4}{of_load}"));
    }

    /// Crops, takes out points, and levels: all steps before the trend. Lengths count from the corner of the file.
    pub(super) fn before_trend(&mut self, args: &PreparationArgs) -> Result<(), Failure> {
        let refuse = |option: &'static str| move |error: PrepareError| Failure::input(key(option), error);
        let grid = self.grid;
        if !args.invalid.is_empty() {
            let invalid = regions::points("invalid", &args.invalid, &self.heights, &grid)?;
            let mut heights = self.heights.clone();
            Zip::from(&mut heights).and(&invalid).for_each(|height, is_invalid| {
                *height = if *is_invalid { f64::NAN } else { *height };
            });
            if heights.iter().all(|height| height.is_nan()) {
                return Err(Failure::value(key("invalid"), "every point", "only some of the points"));
            }
            let count = invalid.iter().filter(|is_invalid| **is_invalid).count();
            let named: Vec<String> = args.invalid.iter().map(ToString::to_string).collect();
            let with = json!({"regions": named, "points": count});
            self.replace("invalid", with, heights, &format!("{count} points taken out by --invalid"));
        }
        if !args.exclude.is_empty() {
            self.excluded = Some(regions::points("exclude", &args.exclude, &self.heights, &grid)?);
        }
        if let Some(part) = &args.crop {
            let ranges = part.ranges(grid.lengths());
            let Cropped { heights, origin } = crop(&self.heights, grid.spacing(), ranges).map_err(refuse("crop"))?;
            let (nx, ny) = heights.dim();
            let spacing = grid.spacing();
            let lengths = if self.sides() == 1 {
                [nx as f64 * spacing[0], grid.lengths()[1]]
            } else {
                [nx as f64 * spacing[0], ny as f64 * spacing[1]]
            };
            if let Some(excluded) = &mut self.excluded {
                let [x, y] = origin;
                *excluded = excluded.slice(ndarray::s![x..x + nx, y..y + ny]).to_owned();
            }
            let corner = [0, 1].map(|axis| origin[axis] as f64 * spacing[axis]);
            let with = json!({"origin": corner, "n": [nx, ny], "size": lengths});
            let grid = Grid::new([nx, ny], lengths).map_err(|error| Failure::input(key("crop"), error))?;
            self.replace_on(grid, "crop", with, heights, &format!("cropped to {nx} x {ny} points"));
            if self.heights.iter().all(|height| height.is_nan()) {
                return Err(Failure::value(key("crop"), part, "a part with defined points"));
            }
        }
        if let Some(SpikeRule(rule @ Spikes { threshold, window })) = args.despike {
            let (heights, count) = despike(&self.heights, rule).map_err(refuse("despike"))?;
            let with = json!({"threshold": threshold, "window": window, "points": count});
            self.replace("despike", with, heights, &format!("{count} spikes taken out"));
        }
        if let Some(ScarRule(rule @ Scars { high, low, length, width })) = args.descar {
            let (heights, count) = descar(&self.heights, rule).map_err(refuse("descar"))?;
            let with = json!({"high": high, "low": low, "length": length, "width": width, "points": count});
            self.replace("descar", with, heights, &format!("{count} points of scars taken out"));
        }
        if let Some(level @ Level { rows, how }) = args.level {
            let along = if rows == Rows::Rows { level_rows } else { level_columns };
            let Levelled { heights, shifts } =
                along(&self.heights, how, self.excluded.as_ref()).map_err(refuse("level"))?;
            self.shifts = shifts;
            let words = format!("levelled by {level}");
            self.replace("level", json!({"how": level.to_string()}), heights, &words);
            let axis = if rows == Rows::Rows { "y" } else { "x" };
            self.notes
                .push(format!("levelling removed waves along {axis} alone: the surface looks more aligned than it is"));
        }
        Ok(())
    }

    /// Removes the trend.
    pub(super) fn trend(&mut self, trend: Detrend, file: &str) -> Result<(), Failure> {
        let refuse = |error: &dyn std::fmt::Display| Failure::input(file, error);
        let fitted = match (trend, &self.excluded) {
            (Detrend::None, _) => return Ok(()),
            (Detrend::Slope, Some(_)) => {
                let allowed = words!["left out with ", key("exclude"), ": the mean slope takes all points"];
                return Err(Failure::value(key("detrend"), "slope", allowed));
            }
            (Detrend::Slope, None) => remove_from_defined(&self.heights, Trend::Slope).map_err(|e| refuse(&e))?,
            (Detrend::Plane, None) => remove_from_defined(&self.heights, Trend::Plane).map_err(|e| refuse(&e))?,
            (Detrend::Quadratic, None) => {
                remove_from_defined(&self.heights, Trend::Quadratic).map_err(|e| refuse(&e))?
            }
            (trend, excluded) => {
                remove_polynomial(&self.heights, trend.degree(), excluded.as_ref()).map_err(|e| refuse(&e))?
            }
        };
        self.replace("detrend", json!({"trend": trend.to_string()}), fitted, trend.words());
        Ok(())
    }

    /// Takes the heights with all points filled.
    pub(super) fn filled(&mut self, heights: Array2<f64>, how: Fill, undefined: usize) {
        let way = match how {
            Fill::Harmonic => "harmonically",
            Fill::Nearest => "with the nearest heights",
        };
        let words = format!("{undefined} undefined points filled {way}");
        self.replace("fill", json!({"how": how.name()}), heights, &words);
    }

    /// Reduces the number of points, then filters. `is_periodic` is true if the surface repeats.
    pub(super) fn after_fill(&mut self, args: &PreparationArgs, is_periodic: bool) -> Result<(), Failure> {
        self.reduce(args)?;
        let Some(bands) = &args.filter else { return Ok(()) };
        let filter = bands.filter(is_periodic);
        let refuse = |error: PrepareError| Failure::input(key("filter"), error);
        let need = if filter.kernel == Kernel::Robust { memory::ROBUST_FILTER } else { memory::FILTER };
        memory::fits(need, key("filter"), self.grid.points())?;
        let spacing = self.grid.spacing();
        let coarsest = spacing[..self.sides()].iter().copied().fold(0.0, f64::max);
        let side = self.grid.lengths()[..self.sides()].iter().copied().fold(f64::INFINITY, f64::min);
        for (name, index) in bands.indices() {
            let Smoothed { heights: long, passes, rejected, guarded, is_settled } =
                smooth(&self.heights, spacing, index, filter).map_err(refuse)?;
            let heights = if name == "s" { long } else { &self.heights - &long };
            if heights.iter().any(|height| height.is_nan()) {
                return Err(Failure::value(key("filter"), bands, "an index with defined points around every point"));
            }
            let shown = self.length(index);
            let mut with = json!({
                "kind": bands.kind(), (name): index, "edges": bands.edges_name(is_periodic), "degree": filter.degree,
            });
            if filter.kernel == Kernel::Robust
                && let Value::Object(with) = &mut with
            {
                with.extend([
                    ("passes".to_owned(), passes.into()),
                    ("rejected".to_owned(), rejected.into()),
                    ("guarded".to_owned(), guarded.into()),
                ]);
                if !is_settled {
                    self.warnings.push(format!("the robust filter of {shown} still changes after {passes} passes"));
                }
            }
            let kind = bands.kind();
            let words = format!("{} filter {shown} ({kind}, {})", name.to_uppercase(), bands.standard(self.sides()));
            self.replace("filter", with, heights, &words);
            if filter.edges == Edges::Regression && index < 4.0 * coarsest {
                self.warnings.push(format!(
                    "the nesting index {shown} is below 4 grid spacings: the sampled filter differs from the standard's"
                ));
            }
            if index > 0.5 * side {
                self.warnings.push(format!("the nesting index {shown} is above half of the side of the surface"));
            }
            if name == "s" && index < 5.0 * coarsest {
                self.notes
                    .push("for a contact an S filter of 5 grid spacings or more resolves its shortest waves".into());
            }
        }
        Ok(())
    }

    fn reduce(&mut self, args: &PreparationArgs) -> Result<(), Failure> {
        let [nx, ny] = self.grid.points();
        let lengths = self.grid.lengths();
        let (option, points) = match (&args.resample[..], args.resample_spacing) {
            ([], None) => return Ok(()),
            ([], Some(step)) => {
                let count = |axis: usize| (lengths[axis] / step).round().max(0.0) as usize;
                if !(step > 0.0 && step.is_finite()) {
                    return Err(Failure::value(key("resample_spacing"), step, words!["positive and finite"]));
                }
                ("resample_spacing", [count(0), if self.sides() == 1 { 1 } else { count(1) }])
            }
            ([n], _) if self.sides() == 1 => ("resample", [*n, 1]),
            ([n], _) => ("resample", [*n, ((ny * n) as f64 / nx as f64).round() as usize]),
            ([n, other, ..], _) => ("resample", [*n, *other]),
        };
        let filter = Filter::default();
        let spacing = self.grid.spacing();
        let Resampled { heights, index } =
            resample(&self.heights, spacing, points, filter).map_err(|error| Failure::input(key(option), error))?;
        let (nx, ny) = heights.dim();
        let grid = Grid::new([nx, ny], lengths).map_err(|error| Failure::input(key(option), error))?;
        let words = format!("{nx} x {ny} points after an S filter of {}", self.length(index));
        self.replace_on(grid, "resample", json!({"n": [nx, ny], "s": index}), heights, &words);
        Ok(())
    }
}

/// Heights in memory after one step.
pub struct PreparedHeights {
    /// Heights, with NaN at undefined points.
    pub heights: Array2<f64>,
    /// Grid of the heights.
    pub grid: Grid,
    /// Step in words.
    pub words: String,
    /// Record of the step: a JSON object with the list `preparation`.
    pub record: String,
    /// Doubts about the result.
    pub warnings: Vec<String>,
}

/// Applies one option of the preparation, with its `text`, to heights in memory. Quantities in the text are converted
/// to `unit`; `excluded` points are left out of fits; `is_periodic` is true if the surface repeats.
///
/// # Errors
/// Returns an error for a text that is no value of the option, and for heights that the step cannot prepare.
pub fn prepare_heights(
    (heights, grid, unit): (Array2<f64>, Grid, Option<&str>),
    (option, text): (&'static str, &str),
    excluded: Option<Array2<bool>>,
    is_periodic: bool,
) -> Result<PreparedHeights, Failure> {
    let kinds = Kinds::LENGTHS_AMONG_WORDS;
    let converted = text_in_units((option, kinds), text, &Units::new(unit, None)).map_err(Failure::from)?;
    let text = converted.as_deref().unwrap_or(text);
    let mut args = PreparationArgs::default();
    let mut trend = Detrend::None;
    let unusable = |error: String| Failure::input(key(option), error);
    match option {
        "crop" => args.crop = Some(text.parse().map_err(unusable)?),
        "invalid" => args.invalid = vec![text.parse().map_err(unusable)?],
        "despike" => args.despike = Some(text.parse().map_err(unusable)?),
        "descar" => args.descar = Some(text.parse().map_err(unusable)?),
        "level" => args.level = Some(text.parse().map_err(unusable)?),
        "filter" => args.filter = Some(text.parse().map_err(unusable)?),
        "resample" => {
            let points = text.split(',').map(str::parse).collect::<Result<_, _>>();
            args.resample = points.map_err(|_| unusable(format!("{text:?} is no number of points")))?;
        }
        "resample_spacing" => args.resample_spacing = Some(values::number(text).map_err(unusable)?),
        _ => trend = text.parse().map_err(unusable)?,
    }
    let mut preparing = Preparing { excluded, ..Preparing::new(heights, grid, unit) };
    preparing.before_trend(&args)?;
    preparing.trend(trend, "detrend")?;
    preparing.after_fill(&args, is_periodic)?;
    let Preparing { heights, grid, steps, words, warnings, .. } = preparing;
    let record = json!({"preparation": steps}).to_string();
    let words = words.trim_start_matches(", ").to_owned();
    Ok(PreparedHeights { heights, grid, words, record, warnings })
}

impl Bands {
    /// Returns the band that is left, for the record: its nesting indices, and the wavelength of the sharp cut-off that
    /// leaves the same rms gradient of a self-affine surface with Hurst exponent 0.8.
    pub(super) fn record(&self) -> Map<String, Value> {
        let mut band: Map<String, Value> =
            self.indices().map(|(name, index)| (name.to_owned(), Value::from(index))).collect();
        if let Some(short) = self.short {
            band.insert("equivalent_shortest".into(), (short * equivalent_cut_off(USUAL_HURST)[0]).into());
        }
        band
    }
}

/// Hurst exponent of most measured surfaces.
const USUAL_HURST: f64 = 0.8;

/// Returns the rms gradient by differences between defined neighbours.
pub(super) fn rms_gradient(heights: &Array2<f64>, grid: &Grid) -> f64 {
    let square = |step: [usize; 2], spacing: f64| {
        let steps = heights.indexed_iter().filter_map(|((i, j), here)| {
            let step = heights.get([i + step[0], j + step[1]])? - here;
            (!step.is_nan()).then_some((step / spacing).powi(2))
        });
        let (count, sum) = steps.fold((0_usize, 0.0), |(count, sum), square| (count + 1, sum + square));
        if count > 0 { sum / count as f64 } else { 0.0 }
    };
    let spacing = grid.spacing();
    (square([1, 0], spacing[0]) + square([0, 1], spacing[1])).sqrt()
}
