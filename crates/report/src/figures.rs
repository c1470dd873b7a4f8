//! Figure parts shared by several commands.

mod scene;

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_files::{FileError, Output};
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, persson_area};
use gfmd_plot::{Axis, Below, Chart, Map, Mark, Panel, Series, TWO_COLUMNS};
use gfmd_unit::{DisplayUnit, Units};
use ndarray::Array2;

use gfmd_input::failure::Failure;

pub use scene::{Face, FigureKind, Scene, SceneFields, rough};

/// Parses a prefix of figures. Its folder must exist and be writable.
///
/// # Errors
/// Returns an error if no file can be made in the folder, or if a figure name would be too long for the file system.
pub fn parse_prefix(text: &str) -> Result<PathBuf, String> {
    let prefix = PathBuf::from(text);
    let folder = gfmd_files::folder(&prefix);
    if !folder.is_dir() {
        return Err(format!("there is no folder {}", folder.display()));
    }
    check_names(&prefix)?;
    match Output::claim(named(&prefix, "map.svg")) {
        Err(error @ FileError::Io { .. }) => Err(error.to_string()),
        _ => Ok(prefix),
    }
}

/// Checks that figures with this prefix can be written, so that long work does not fail because of their names.
///
/// # Errors
/// Returns an error if a name is too long for the file system.
pub fn check_names(prefix: &Path) -> Result<(), String> {
    let longest = named(prefix, &format!("{LONGEST_NAME}.svg"));
    let name = |path: &Path| path.file_name().unwrap_or_default().len();
    match std::fs::symlink_metadata(&longest) {
        Err(error) if error.kind() == std::io::ErrorKind::InvalidFilename => Err(format!(
            "the name has {} bytes, and {} with -{LONGEST_NAME}.svg, the longest name of a figure, which is too long \
             here; it must be shorter",
            name(prefix),
            name(&longest)
        )),
        _ => Ok(()),
    }
}

/// Longest name of a figure after its prefix.
const LONGEST_NAME: &str = "correlation-map";

/// Returns the path `PREFIX-what`.
pub fn named(stem: &Path, what: &str) -> PathBuf {
    debug_assert!(what.trim_end_matches(".svg").len() <= LONGEST_NAME.len(), "{what} is longer than {LONGEST_NAME}");
    let mut name = stem.file_name().unwrap_or_default().to_os_string();
    name.push(format!("-{what}"));
    stem.with_file_name(name)
}

/// Returns a chart of the contact area against the reduced pressure. Both axes are logarithmic: points without contact,
/// or with a negative extrapolated area, are left out.
pub fn area_chart(mut series: Vec<Series>) -> Chart {
    series.iter_mut().for_each(|series| series.points.retain(|point| point.x > 0.0 && point.y > 0.0));
    Chart::new(vec![Panel {
        x: Axis::log("reduced pressure *p*\\* = *p*/(*E*\\**g*)"),
        y: Axis::log("contact area fraction *a*_r"),
        series,
        ..Panel::default()
    }])
}

/// Name of the straight line a_r = √(2π) p*, the limit of the theory of Bush, Gibson and Thomas at vanishing load.
const BUSH_GIBSON_THOMAS_LIMIT: &str = "Bush–Gibson–Thomas, low load";

/// Returns the area of Persson's theory, and the straight line of Bush, Gibson and Thomas for areas below one half.
pub fn theories(lowest: f64, highest: f64) -> [Series; 2] {
    let pressures = |to: f64| (0..=80).map(move |i| lowest * (to / lowest).powf(f64::from(i) / 80.0));
    let persson = pressures(highest).map(|p| (p, persson_area(p)));
    let linear_to = highest.min(0.5 / BUSH_GIBSON_THOMAS_KAPPA).max(lowest);
    let bush = pressures(linear_to).map(|p| (p, BUSH_GIBSON_THOMAS_KAPPA * p));
    [
        Series::line("Persson", 5, persson),
        Series { mark: Mark::Dashes, ..Series::line(BUSH_GIBSON_THOMAS_LIMIT, 6, bush) },
    ]
}

/// Returns a colour range symmetric about zero for a difference; `None` if nothing differs. The largest 2 % of the
/// magnitudes are left out if they are much larger than the others, as at singular edges.
pub fn about_zero(differences: &[f64]) -> Option<[f64; 2]> {
    let mut sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let (most, largest) = (*sizes.get(sizes.len().saturating_sub(1) * 98 / 100)?, *sizes.last()?);
    let end = if most > 0.0 && largest > 1.5 * most { most } else { largest };
    (end > 0.0).then_some([-end, end])
}

/// Largest number of values drawn along a line; longer profiles are thinned.
const MOST_POINTS: usize = 4000;

/// Formats a number with up to four digits, without an exponent unless it is very small or large.
pub fn short(value: f64) -> String {
    let exponent = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let signed = |text: String| text.replace('-', "−");
    let digits = |value: f64, places: i32| {
        let text = format!("{value:.0$}", places.max(0) as usize);
        if places > 0 { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    };
    match exponent {
        -3..=4 => signed(digits(value, 3 - exponent)),
        _ => signed(format!("{}·10^{{{exponent}}}", digits(value / 10_f64.powi(exponent), 3))),
    }
}

/// Smallest ratio of points along x to points along y at which a map is two columns wide.
const LONG: usize = 4;

/// Figure of a field: a map, or the profile of a line contact.
pub enum Drawn<'a> {
    /// Profile of a line contact.
    Chart(Chart),
    /// Map of a field.
    Map(Map<'a>),
}

impl Drawn<'_> {
    /// Writes the figure as SVG and PNG and returns their names.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn save(&self, stem: &Path) -> Result<Vec<PathBuf>, Failure> {
        Ok(match self {
            Self::Chart(chart) => chart.save(stem)?.to_vec(),
            Self::Map(map) => map.save(stem)?.to_vec(),
        })
    }
}

/// Returns the readable unit for lengths up to `largest`; `length` if the unit is unknown.
pub fn length(unit: &str, largest: f64) -> DisplayUnit {
    let known = Units::new(Some(unit), None).shown("length", largest);
    known.unwrap_or_else(|| DisplayUnit { factor: 1.0, name: unit.into() })
}

/// Returns the readable unit for the sides of a cell.
pub fn sides(grid: &Grid, unit: &str) -> DisplayUnit {
    let [lx, ly] = grid.lengths();
    length(unit, if grid.is_line() { lx } else { lx.max(ly) })
}

/// Returns the largest absolute value.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// Passes the figure of the heights, with their unit, to `take`.
pub fn heights<R>(grid: &Grid, values: &[f64], unit: &str, take: impl FnOnce(&Drawn) -> R) -> R {
    let DisplayUnit { factor, name } = length(unit, largest(values));
    let scaled: Vec<f64> = values.iter().map(|height| height * factor).collect();
    take(&field(grid, &scaled, &format!("height *h* / {name}"), unit))
}

/// Returns the figure of a field on a grid with lengths in `unit`. A long profile is thinned to the largest of several
/// neighbours.
pub fn field<'a>(grid: &Grid, values: &'a [f64], label: &str, unit: &str) -> Drawn<'a> {
    let DisplayUnit { factor, name: unit } = sides(grid, unit);
    let [lx, ly] = grid.lengths().map(|length| length * factor);
    if grid.is_line() {
        let step = values.len().div_ceil(MOST_POINTS);
        let spacing = grid.spacing()[0] * factor;
        let highest = |part: &[f64]| part.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let line = values.chunks(step).enumerate().map(|(i, part)| ((i * step) as f64 * spacing, highest(part)));
        let panel = Panel {
            x: Axis::linear(&format!("*x* / {unit}")),
            y: Axis::linear(label),
            series: vec![Series::line("", 0, line)],
            ..Panel::default()
        };
        return Drawn::Chart(Chart::new(vec![panel]));
    }
    let mut map = Map::new(values, grid.points(), [lx, ly], label);
    map.x = format!("*x* / {unit}");
    map.y = format!("*y* / {unit}");
    let [nx, ny] = grid.points();
    if nx >= LONG * ny {
        map.width = TWO_COLUMNS;
    }
    Drawn::Map(map)
}

/// Returns the figure of the pressure, from values in the unit of the label.
pub fn pressure<'a>(grid: &Grid, values: &'a [f64], label: &str, unit: &str) -> Drawn<'a> {
    let mut drawn = field(grid, values, label, unit);
    if let Drawn::Map(map) = &mut drawn {
        map.below = Some(Below::pale(0.0, "no contact"));
    }
    drawn
}

/// Draws a map of the pressure, or its profile for a line contact.
pub fn draw_pressure(
    stem: &Path,
    grid: &Grid,
    values: &Array2<f64>,
    modulus: f64,
    unit: &str,
) -> Result<Vec<PathBuf>, Failure> {
    let values: Vec<f64> = values.iter().map(|p| p / modulus).collect();
    pressure(grid, &values, "pressure *p*/*E*\\*", unit).save(stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_have_no_needless_digits() {
        let found = [0.0, 0.5078125, -2.5, 12345.6, 1e-4, 1.852e-5, -3.21e7, 0.001].map(short);
        assert_eq!(found, ["0", "0.5078", "−2.5", "12346", "1·10^{−4}", "1.852·10^{−5}", "−3.21·10^{7}", "0.001"]);
    }
}
