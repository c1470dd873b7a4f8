//! Figures of a surface.

use std::f64::consts::TAU;

use gfmd_plot::{Axis, Below, Chart, Colours, Level, Map, Mark, Panel, Scale, Series};
use gfmd_surface::{Density, RadialBin, Texture};
use gfmd_unit::{DisplayUnit, Units};

use super::{Subject, unit_of};
use crate::figures::{largest, length, short, sides};

/// Largest number of points of a line; longer profiles are thinned to their lowest and highest values.
const MOST_POINTS: usize = 4000;

/// Smallest ratio of the full range to the range without outliers at which the colours of a map leave outliers out.
const FAR: f64 = 2.0;

/// Smallest density shown in a distribution, relative to the highest one.
const LOWEST_DENSITY: f64 = 1e-5;

impl Subject<'_> {
    /// Passes the map of the heights to `take`; `None` for a profile.
    pub fn map<R>(&self, take: impl FnOnce(&Map) -> R) -> Option<R> {
        if self.grid.is_line() {
            return None;
        }
        let values: Vec<f64> = self.heights.iter().copied().collect();
        let (side, height) = (sides(self.grid, self.unit()), length(self.unit(), largest(&values)));
        let values: Vec<f64> = values.iter().map(|value| value * height.factor).collect();
        let cell = self.grid.lengths().map(|length| length * side.factor);
        let mut map = Map::new(&values, self.grid.points(), cell, &format!("height *h* / {}", height.name));
        map.x = format!("*x* / {}", side.name);
        map.y = format!("*y* / {}", side.name);
        map.range = without_outliers(&values);
        Some(take(&map))
    }

    /// Passes the map of the heights with the course lines between hills to `take`; `None` without these lines.
    pub fn hills<R>(&self, take: impl FnOnce(&Map) -> R) -> Option<R> {
        let lines = self.course_lines?;
        self.map(|map| {
            let [lowest, highest] = map
                .values
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
            let below = lowest - (highest - lowest);
            let marked = map.values.iter().zip(lines).map(|(value, is_line)| if *is_line { below } else { *value });
            let marked: Vec<f64> = marked.collect();
            let below = Some(Below::pale(below, "between hills"));
            take(&Map { values: &marked, below, range: map.range.or(Some([lowest, highest])), ..map.clone() })
        })
    }

    /// Returns the heights along the row of points through the middle.
    pub fn profile(&self) -> Chart {
        let row = self.grid.points()[1] / 2;
        let spacing = self.grid.spacing();
        let column = self.heights.column(row);
        let step = (2 * column.len()).div_ceil(MOST_POINTS).max(1);
        let line = column.iter().copied().enumerate().collect::<Vec<_>>();
        let ends = |part: &[(usize, f64)]| -> Vec<(usize, f64)> {
            let lowest = part.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
            let highest = part.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
            let mut both: Vec<_> = lowest.into_iter().chain(highest).collect();
            both.sort_by_key(|(index, _)| *index);
            both.dedup();
            both
        };
        let side = sides(self.grid, self.unit());
        let read = length(self.unit(), column.iter().fold(0.0, |largest: f64, height| largest.max(height.abs())));
        let points = line.chunks(step).flat_map(ends);
        let points = points.map(|(i, height)| (i as f64 * spacing[0] * side.factor, height * read.factor));
        let place = short(row as f64 * spacing[1] * side.factor);
        let title = if self.grid.is_line() { String::new() } else { format!("*y* = {place} {}", side.name) };
        Chart::new(vec![Panel {
            title,
            x: Axis::linear(&format!("*x* / {}", side.name)),
            y: Axis::linear(&format!("height *h* / {}", read.name)),
            series: vec![Series::line("", 0, points)],
            ..Panel::default()
        }])
    }

    /// Returns the radially averaged spectrum with the wavelengths that the points resolve and the fitted power law;
    /// `None` if no mode has power.
    pub fn spectrum(&self) -> Option<Chart> {
        let with_power = self.spectrum.iter().filter(|bin| bin.density > 0.0);
        let highest = with_power.clone().map(|bin| bin.density).fold(0.0, f64::max);
        // Do not show the rounding of a spectrum with a cut-off.
        let shown = with_power.filter(|bin| bin.density > 1e-16 * highest);
        let lowest = shown.clone().map(|bin| bin.density).fold(f64::INFINITY, f64::min);
        if highest <= 0.0 {
            return None;
        }
        let side = sides(self.grid, self.unit());
        let height = length(self.unit(), largest(&self.heights.iter().copied().collect::<Vec<_>>()));
        let is_line = self.grid.is_line();
        // Heights have another unit than distances.
        let power = if is_line { 1 } else { 2 };
        let (along, over) = (1.0 / side.factor, height.factor.powi(2) * side.factor.powi(power));
        let scaled = |(q, density): (f64, f64)| (q * along, density * over);
        let label = match self.window {
            None => "spectrum".into(),
            Some(window) => format!("spectrum, {window} window"),
        };
        let points = shown.map(|bin| scaled((bin.wavenumber, bin.density)));
        let mut series = vec![Series::line(&label, 0, points)];
        let at = |wavelength: f64| [lowest, highest].map(|density| scaled((TAU / wavelength, density)));
        if let Some([longest, shortest]) = self.resolved {
            let [long, small] = [longest, shortest].map(|wavelength| short(wavelength * side.factor));
            let band = if self.is_filtered { "filters" } else { "resolved" };
            let words = format!("{band}: {long} to {small} {}", side.name);
            series.push(Series { mark: Mark::Dashes, ..Series::line(&words, 1, at(longest)) });
            series.push(Series { mark: Mark::Dashes, ..Series::line("", 1, at(shortest)) });
        }
        if let Some(line) = self.hurst.and_then(|(hurst, range)| power_law(is_line, self.spectrum, range, hurst)) {
            let label = line.label;
            let points = line.points.iter().map(|point| scaled((point.x, point.y)));
            series.push(Series { mark: Mark::Dashes, ..Series::line(&label, 3, points) });
        }
        let (name, raised) = if is_line { ("*C*^{1D}", "") } else { ("*C*^{2D}", "^2") };
        let unit = match height.name == side.name {
            true => format!("{}^{}", side.name, 2 + power),
            false => format!("({}^2 {}{raised})", height.name, side.name),
        };
        Some(Chart::new(vec![Panel {
            x: Axis::log(&format!("wavenumber *q* / (rad/{})", side.name)),
            y: Axis::log(&format!("{name} / {unit}")),
            series,
            ..Panel::default()
        }]))
    }

    /// Returns the autocorrelation against distance: radial mean, along x and along y; `None` for a flat surface.
    pub fn autocorrelation(&self, texture: &Texture) -> Option<Chart> {
        let found = &texture.autocorrelation;
        if found.mean_square() <= 0.0 {
            return None;
        }
        let side = sides(self.grid, self.unit());
        let line = |label: &str, hue: usize, values: Vec<[f64; 2]>| {
            let points = values.into_iter().map(|[d, a]| (d * side.factor, found.relative(a)));
            Series::line(label, hue, points.collect::<Vec<_>>())
        };
        let series = if self.grid.is_line() {
            vec![line("", 0, found.along(0))]
        } else {
            vec![
                line("radial mean", 0, found.radial()),
                Series { mark: Mark::Dashes, ..line("along *x*", 1, found.along(0)) },
                Series { mark: Mark::Dashes, ..line("along *y*", 2, found.along(1)) },
            ]
        };
        Some(Chart::new(vec![Panel {
            x: Axis::linear(&format!("distance *d* / {}", side.name)),
            y: Axis::linear("autocorrelation *f*"),
            levels: vec![Level::line(0.0, ""), Level::line(0.2, "0.2")],
            series,
            ..Panel::default()
        }]))
    }

    /// Passes the map of the autocorrelation to `take`; `None` for a profile and for a flat surface.
    pub fn correlation_map<R>(&self, texture: &Texture, take: impl FnOnce(&Map) -> R) -> Option<R> {
        let found = &texture.autocorrelation;
        if self.grid.is_line() || found.mean_square() <= 0.0 {
            return None;
        }
        let differences = found.map();
        let shape: [usize; 2] = differences.dim().into();
        let values: Vec<f64> = differences.iter().map(|a| found.relative(*a)).collect();
        let (side, spacing) = (sides(self.grid, self.unit()), self.grid.spacing());
        let cell = [0, 1].map(|axis| shape[axis] as f64 * spacing[axis] * side.factor);
        let mut map = Map::new(&values, shape, cell, "autocorrelation *f*");
        map.origin = cell.map(|length| -0.5 * length);
        map.x = format!("*d*_x / {}", side.name);
        map.y = format!("*d*_y / {}", side.name);
        map.colours = Colours::Diverging;
        map.range = Some([-1.0, 1.0]);
        Some(take(&map))
    }

    /// Returns the distributions of height, slope and curvature; `None` for a flat surface.
    pub fn distributions(&self, texture: &Texture) -> Option<Chart> {
        let found = &texture.distributions;
        let slopes = [("along *x*", &found.slope_x), ("along *y*", &found.slope_y)];
        let slopes = slopes.iter().filter_map(|(label, density)| Some((*label, density.as_ref()?)));
        let slopes: Vec<(&str, &Density)> =
            if self.grid.is_line() { slopes.map(|(_, density)| ("", density)).collect() } else { slopes.collect() };
        let panels = [
            self.density("height above the mean", 1, found.height.iter().map(|density| ("", density)).collect()),
            self.density("slope", 0, slopes),
            self.density("curvature", -1, found.curvature.iter().map(|density| ("", density)).collect()),
        ];
        let panels: Vec<Panel> = panels.into_iter().flatten().collect();
        (!panels.is_empty()).then(|| Chart { share_y: false, ..Chart::new(panels) })
    }

    fn density(&self, label: &str, power: i32, parts: Vec<(&str, &Density)>) -> Option<Panel> {
        let highest = parts.iter().map(|(_, part)| part.deviation).fold(0.0, f64::max);
        let read = self.read(power, highest);
        let peak = parts.iter().flat_map(|(_, part)| &part.densities).copied().fold(0.0, f64::max) / read.factor;
        let shown = move |(_, density): &(f64, f64)| *density > LOWEST_DENSITY * peak;
        let curve = |part: &Density, densities: &[f64]| -> Vec<(f64, f64)> {
            let pairs = part.middles.iter().zip(densities);
            pairs.map(|(at, density)| (at * read.factor, density / read.factor)).filter(shown).collect()
        };
        let mut series = Vec::new();
        for (hue, (label, part)) in parts.iter().enumerate() {
            series.push(Series::line(label, hue, curve(part, &part.densities)));
            let gaussian = if hue == 0 { "Gaussian" } else { "" };
            let line = Series::line(gaussian, hue, curve(part, &part.gaussian()));
            series.push(Series { mark: Mark::Dashes, ..line });
        }
        let (x, y) = match read.name.as_str() {
            "" => (label.into(), "density".into()),
            // The density has the inverse unit.
            name => (
                format!("{label} / {}", read.divisor()),
                format!("density / {}", name.strip_prefix("1/").map_or(format!("(1/{name})"), str::to_owned)),
            ),
        };
        (!series.is_empty()).then(|| Panel { x: Axis::linear(&x), y: Axis::log(&y), series, ..Panel::default() })
    }

    /// Returns rms slope and rms curvature against distance; `None` without a value above zero.
    pub fn scales(&self, texture: &Texture) -> [Option<Chart>; 2] {
        let side = sides(self.grid, self.unit());
        let chart = |name: &str, power: i32, along: &[Vec<[f64; 2]>; 2]| {
            let above =
                |values: &[[f64; 2]]| values.iter().copied().filter(|[_, value]| *value > 0.0).collect::<Vec<_>>();
            let along = [above(&along[0]), above(&along[1])];
            let highest = along.iter().flatten().map(|[_, value]| *value).fold(0.0, f64::max);
            let read = self.read(power, highest);
            let line = |label: &str, hue: usize, values: &[[f64; 2]]| {
                let label = if self.grid.is_line() { "" } else { label };
                Series::line(label, hue, values.iter().map(|[d, value]| (d * side.factor, value * read.factor)))
            };
            let series = vec![
                Series { mark: Mark::JoinedPoints, ..line("along *x*", 0, &along[0]) },
                Series { mark: Mark::JoinedPoints, ..line("along *y*", 1, &along[1]) },
            ];
            let label = if read.name.is_empty() { name.into() } else { format!("{name} / {}", read.divisor()) };
            (highest > 0.0).then(|| {
                Chart::new(vec![Panel {
                    x: Axis::log(&format!("distance / {}", side.name)),
                    y: Axis { scale: Scale::Log, ..Axis::linear(&label) },
                    series: series.into_iter().filter(|series| !series.points.is_empty()).collect(),
                    ..Panel::default()
                }])
            })
        };
        [chart("rms slope", 0, &texture.scales.slope), chart("rms curvature", -1, &texture.scales.curvature)]
    }

    /// Returns the bearing curve with its core; `None` for a flat surface.
    pub fn bearing(&self, texture: &Texture) -> Option<Chart> {
        let found = &texture.bearing;
        let core = found.core?;
        let read = length(self.unit(), largest(&found.height));
        let curve = found.ratio.iter().zip(&found.height).map(|(ratio, height)| (100.0 * ratio, height * read.factor));
        // The line spans ratios from 0 to 100 %; its ends have the heights of the curve at the two ratios of the core.
        let top = core.top * read.factor;
        let line = [(0.0, top), (100.0, top - core.sk * read.factor)];
        let label = format!("core, *S*_k = {} {}", short(core.sk * read.factor), read.name);
        Some(Chart::new(vec![Panel {
            x: Axis::linear("material ratio / %").over([0.0, 100.0]),
            y: Axis::linear(&format!("height above the mean / {}", read.name)),
            series: vec![Series::line("", 0, curve), Series { mark: Mark::Dashes, ..Series::line(&label, 1, line) }],
            ..Panel::default()
        }]))
    }

    /// Returns the readable unit for a power of length up to `highest`.
    fn read(&self, power: i32, highest: f64) -> DisplayUnit {
        let known = Units::new(self.unit, None).shown(&unit_of("length", power), highest);
        let name = if power == 0 { String::new() } else { unit_of(self.unit(), power) };
        known.filter(|_| power != 0).unwrap_or(DisplayUnit { factor: 1.0, name })
    }
}

/// Returns the range of the values without a thousandth at either end; `None` unless the full range is much wider.
fn without_outliers(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    let beyond = values.len() / 1000;
    let (least, most) = (beyond, values.len() - 1 - beyond);
    let low = *sorted.select_nth_unstable_by(least, f64::total_cmp).1;
    let high = *sorted.select_nth_unstable_by(most, f64::total_cmp).1;
    let whole = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &value| [a.min(value), b.max(value)]);
    (high > low && whole[1] - whole[0] > FAR * (high - low)).then_some([low, high])
}

/// Returns the power law of a Hurst exponent through the mean logarithm of the density in the range of the fit.
fn power_law(is_line: bool, spectrum: &[RadialBin], [longest, shortest]: [f64; 2], hurst: f64) -> Option<Series> {
    let exponent = if is_line { 1.0 + 2.0 * hurst } else { 2.0 + 2.0 * hurst };
    let [from, to] = [TAU / longest, TAU / shortest];
    let inside = |bin: &&RadialBin| bin.density > 0.0 && (from..=to).contains(&bin.wavenumber);
    let (count, sum) = spectrum
        .iter()
        .filter(inside)
        .map(|bin| bin.density.ln() + exponent * bin.wavenumber.ln())
        .fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
    if count == 0 {
        return None;
    }
    let factor = (sum / count as f64).exp();
    let line = [from, to].map(|q| (q, factor * q.powf(-exponent)));
    Some(Series::line(&format!("*H* = {hurst:.2}"), 3, line))
}
