//! Figures of one state of a contact: maps of the pressure, of the traction with both signs and of the gap, and a
//! section through both surfaces with the pressure below it.

use std::path::{Path, PathBuf};

use gfmd_contact::{Fields, Hardness};
use gfmd_field::Grid;
use gfmd_files::contiguous;
use gfmd_plot::{Axis, Below, Chart, Colours, Level, Mark, Panel, Scale, Series, Side};
use ndarray::Array2;

use super::{Drawn, MOST_POINTS, field, largest, length, named, short, sides};
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_unit::{DisplayUnit, Units};

/// Fields of a state for its figures, row by row, in the units of the input.
#[derive(Clone, Debug, Default)]
pub struct SceneFields {
    /// Normal pressure; attraction is negative.
    pub pressure: Vec<f64>,
    /// Repulsive part of the pressure; its points are in contact.
    pub repulsion: Vec<f64>,
    /// Distance between the surfaces; empty if unknown.
    pub gap: Vec<f64>,
    /// Height of the elastic surface above the undeformed one; empty if unknown.
    pub level: Vec<f64>,
}

impl SceneFields {
    /// Returns the fields of a state. The displacement `lift` of a moving base is added to the level of the surface,
    /// and a plastic `depth` is subtracted.
    pub fn of(state: &(impl Fields + ?Sized), lift: Option<&Array2<f64>>, depth: Option<&Array2<f64>>) -> Self {
        let mut level = contiguous(&state.displacement_z()).into_owned();
        let mut add = |field: Option<&Array2<f64>>, sign: f64| {
            let values = field.into_iter().flatten();
            level.iter_mut().zip(values).for_each(|(level, value)| *level += sign * value);
        };
        add(lift, 1.0);
        add(depth, -1.0);
        Self {
            pressure: contiguous(&state.pressure()).into_owned(),
            repulsion: contiguous(&state.repulsion()).into_owned(),
            gap: contiguous(&state.gap()).into_owned(),
            level,
        }
    }

    /// Returns zero fields with `points` points.
    pub fn zeros(points: usize) -> Self {
        let zeros = || vec![0.0; points];
        Self { pressure: zeros(), repulsion: zeros(), gap: zeros(), level: zeros() }
    }

    /// Returns the fields, for checkpoints.
    pub fn fields_mut(&mut self) -> [&mut [f64]; 4] {
        [&mut self.pressure, &mut self.repulsion, &mut self.gap, &mut self.level].map(Vec::as_mut_slice)
    }

    /// Returns the fields of the contact with a lower surface, with a plastic `depth`, in the frame of that surface.
    pub fn below(state: &dyn Fields, depth: Option<&Array2<f64>>) -> Self {
        let mut shown = Self::of(state, None, depth);
        shown.level.iter_mut().for_each(|level| *level = -*level);
        shown
    }
}

/// Face of the body in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Upper face, against the rigid surface above.
    Upper,
    /// Lower face of a slab, against the surface below it.
    Lower,
}

/// State of a contact for its figures.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// Fields of the state.
    pub shown: &'a SceneFields,
    /// Grid of the fields.
    pub grid: &'a Grid,
    /// Unit of lengths.
    pub unit: &'a str,
    /// Unit of stresses, if known.
    pub stress: Option<&'a str>,
    /// E*, the unit of pressures.
    pub modulus: f64,
    /// Hardness, if the contact has one.
    pub hardness: Option<&'a Hardness>,
    /// Name of the rough surface.
    pub rigid: &'static str,
    /// Face of the body to show.
    pub face: Face,
}

/// Quantity shown in a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureKind {
    /// Normal pressure.
    Pressure,
    /// Repulsion and attraction, with two colours.
    Traction,
    /// Distance between the surfaces.
    Gap,
    /// Section through both surfaces.
    Section,
}

impl FigureKind {
    /// Returns the suffix of its file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "map",
            Self::Traction => "traction",
            Self::Gap => "gap",
            Self::Section => "section",
        }
    }
}

/// Returns the name of a rough surface in a section.
pub fn rough(is_composite: bool) -> &'static str {
    if is_composite { "composite of both surfaces" } else { "rigid surface" }
}

/// Index of the contact colour.
const CONTACT: usize = 1;

/// Part of the deformation that the contact residuals leave; smaller heights and gaps are rounding.
const RESIDUAL_DEFORMATION: f64 = 1e-8;

impl<'a> Scene<'a> {
    /// Returns the upper face of a contact with this surface.
    pub fn upper(surface: &'a Surface, shown: &'a SceneFields, modulus: f64, hardness: Option<&'a Hardness>) -> Self {
        let rigid = rough(surface.second.is_some());
        let (unit, stress) = (surface.unit(), surface.stress());
        Self { shown, grid: &surface.grid, unit, stress, modulus, hardness, rigid, face: Face::Upper }
    }
}

impl Scene<'_> {
    /// Draws the figures: `PREFIX-map` etc., or `PREFIX-lower-map` etc. for a lower face.
    pub fn draw(&self, prefix: &Path) -> Result<Vec<PathBuf>, Failure> {
        let mut files = Vec::new();
        self.figures(|kind, drawn| {
            let face = if self.face == Face::Upper { "" } else { "lower-" };
            files.extend(drawn.save(&named(prefix, &format!("{face}{}", kind.name())))?);
            Ok::<_, Failure>(())
        })?;
        Ok(files)
    }

    /// Passes the figures to `take`, one by one: the pressure; with an attraction, the traction of both signs; the gap,
    /// if known and open somewhere; the section, if the displacement is known as well. A profile has no maps, only
    /// pressure and section.
    pub fn figures<E>(&self, mut take: impl FnMut(FigureKind, &Drawn) -> Result<(), E>) -> Result<(), E> {
        let SceneFields { pressure, gap, level, .. } = self.shown;
        let is_line = self.grid.is_line();
        let Pressures { over, label, .. } = self.pressures();
        let in_units = |p: &f64| p / over;
        {
            let values: Vec<f64> = pressure.iter().map(in_units).map(|p| p.max(0.0)).collect();
            take(FigureKind::Pressure, &super::pressure(self.grid, &values, &label, self.unit))?;
        }
        if let (Some(end), false) = (largest_of_two_signs(pressure), is_line) {
            let values: Vec<f64> = pressure.iter().map(in_units).collect();
            take(FigureKind::Traction, &self.traction(&values, in_units(&end), &label))?;
        }
        let mut values: Vec<f64> = self.distances().collect();
        // A gap that is closed everywhere has no map.
        if !(gap.is_empty() || is_line) && largest(&values) > RESIDUAL_DEFORMATION * self.deformation() {
            let read = length(self.unit, largest(&values));
            values.iter_mut().for_each(|gap| *gap *= read.factor);
            take(FigureKind::Gap, &self.gap(&values, &read.name))?;
        }
        if gap.is_empty() || level.is_empty() {
            return Ok(());
        }
        self.section().map_or(Ok(()), |chart| take(FigureKind::Section, &Drawn::Chart(chart)))
    }

    /// Returns the map of the pressure from −`end` to `end`, with repulsion in one colour and attraction in another.
    fn traction<'v>(&self, values: &'v [f64], end: f64, label: &str) -> Drawn<'v> {
        let mut drawn = field(self.grid, values, &format!("{label}, attraction negative"), self.unit);
        if let Drawn::Map(map) = &mut drawn {
            (map.colours, map.range) = (Colours::Diverging, Some([-end, end]));
        }
        drawn
    }

    /// Returns true if pressures are shown divided by E* because their unit is not known.
    pub fn is_divided(&self) -> bool {
        self.readable().is_none()
    }

    fn readable(&self) -> Option<DisplayUnit> {
        Units::new(Some(self.unit), self.stress).shown("stress", largest(&self.shown.pressure))
    }

    /// Returns how pressures are drawn: in a readable unit if their unit is known, otherwise divided by E*.
    fn pressures(&self) -> Pressures {
        match self.readable() {
            Some(DisplayUnit { factor, name }) => Pressures {
                over: 1.0 / factor,
                label: format!("pressure *p* / {name}"),
                short: format!("*p* / {name}"),
            },
            None => Pressures { over: self.modulus, label: "pressure *p*/*E*\\*".into(), short: "*p*/*E*\\*".into() },
        }
    }

    /// Estimates the deformation from the largest pressure and the longest wave.
    fn deformation(&self) -> f64 {
        let [lx, ly] = self.grid.lengths();
        let side = if self.grid.is_line() { lx } else { lx.max(ly) };
        largest(&self.shown.pressure) * side / self.modulus
    }

    /// Returns the distances between the surfaces; zero in contact and where residuals make the gap negative.
    fn distances(&self) -> impl Iterator<Item = f64> {
        let both = self.shown.gap.iter().zip(&self.shown.repulsion);
        both.map(|(gap, repulsion)| if *repulsion > 0.0 { 0.0 } else { gap.max(0.0) })
    }

    /// Returns the map of the gap on a logarithmic scale, with a separate colour for contact.
    fn gap<'v>(&self, distances: &'v [f64], name: &str) -> Drawn<'v> {
        let mut drawn = field(self.grid, distances, &format!("gap / {name}"), self.unit);
        if let Drawn::Map(map) = &mut drawn {
            map.scale = Scale::Log;
            map.below = Some(Below { hue: Some(CONTACT), ..Below::pale(0.0, "contact") });
        }
        drawn
    }

    /// Returns the section along x through the largest pressure: both surfaces with the points in contact marked, and
    /// the pressure below them.
    fn section(&self) -> Option<Chart> {
        let Self { shown, grid, unit, .. } = self;
        let ([nx, ny], [dx, dy]) = (grid.points(), grid.spacing());
        let strongest = shown.pressure.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map(|(index, _)| index);
        let row = strongest? % ny;
        let points = self.chosen(row);
        let x = |point: usize| (point / ny) as f64 * dx;
        let line = |of: &dyn Fn(usize) -> f64| points.iter().map(|&point| (x(point), of(point))).collect::<Vec<_>>();
        let sign = if self.face == Face::Upper { 1.0 } else { -1.0 };
        let level = |point: usize| shown.level[point];
        let [above, below] =
            if self.face == Face::Upper { [Side::Top, Side::Bottom] } else { [Side::Bottom, Side::Top] };
        let filled =
            |label: &str, hue, side, pairs| Series { mark: Mark::Filled(side), ..Series::line(label, hue, pairs) };
        let mut heights = vec![
            filled(self.rigid, 6, above, line(&|point| level(point) + sign * shown.gap[point])),
            filled("elastic body", 5, below, line(&level)),
        ];
        heights.extend(self.contacts(&points));
        let side = sides(grid, unit);
        let extent = heights.iter().flat_map(|series| &series.points).map(|point| point.y.abs()).fold(0.0, f64::max);
        let floor = RESIDUAL_DEFORMATION * self.deformation();
        if extent <= floor {
            heights.iter_mut().flat_map(|series| &mut series.points).for_each(|point| point.y = 0.0);
        }
        let height = length(unit, if extent <= floor { self.deformation() } else { extent });
        let flat = self.deformation() * height.factor;
        let y = Axis::linear(&format!("height *z* / {}", height.name));
        let axis = || Axis::linear(&format!("*x* / {}", side.name)).over([0.0, (nx - 1) as f64 * dx * side.factor]);
        let known = if *unit == "length" { String::new() } else { format!(" {}", side.name) };
        let place = short(row as f64 * dy * side.factor);
        let title = format!("row *y* = {place}{known}, through the largest pressure");
        let upper = Panel {
            title: if grid.is_line() { String::new() } else { title },
            x: axis(),
            y: if extent <= floor && flat > 0.0 { y.over([-flat, flat]) } else { y },
            series: scaled(heights, [side.factor, height.factor]),
            ..Panel::default()
        };
        let Pressures { over, short, .. } = self.pressures();
        let pressures = line(&|point| shown.pressure[point] / over);
        let lower = self.signed(&pressures, &points, over);
        let series = scaled(lower.series, [side.factor, 1.0]);
        let lower = Panel { x: axis(), y: Axis::linear(&short), series, ..lower };
        Some(Chart::stacked(vec![upper, lower]))
    }

    /// Returns the elastic surface in contact along a row as runs of points, each from half a step before its first
    /// point to half a step after its last.
    fn contacts(&self, points: &[usize]) -> Vec<Series> {
        let (SceneFields { repulsion, level, .. }, ny, dx) =
            (self.shown, self.grid.points()[1], self.grid.spacing()[0]);
        let at = |place: usize| ((points[place] / ny) as f64 * dx, level[points[place]]);
        let middle = |(x, y): (f64, f64), (other, height): (f64, f64)| (0.5 * (x + other), 0.5 * (y + height));
        let mut runs = Vec::new();
        let mut begin = 0;
        for run in points.chunk_by(|a, b| (repulsion[*a] > 0.0) == (repulsion[*b] > 0.0)) {
            let (first, last) = (begin, begin + run.len() - 1);
            begin += run.len();
            if repulsion[points[first]] > 0.0 {
                let before = first.checked_sub(1).map(|place| middle(at(place), at(first)));
                let behind = (begin < points.len()).then(|| middle(at(last), at(begin)));
                let pairs = before.into_iter().chain((first..=last).map(at)).chain(behind);
                runs.push(Series { mark: Mark::Bold, ..Series::line("contact", CONTACT, pairs) });
            }
        }
        runs
    }

    /// Returns the points of a row. A long row keeps one of several neighbours, the one nearest to the other surface.
    fn chosen(&self, row: usize) -> Vec<usize> {
        let Self { shown, grid, .. } = self;
        let [nx, ny] = grid.points();
        let all: Vec<usize> = (0..nx).map(|i| i * ny + row).collect();
        let nearest = |a: &&usize, b: &&usize| {
            let [a, b] = [**a, **b];
            shown.repulsion[b].total_cmp(&shown.repulsion[a]).then(shown.gap[a].total_cmp(&shown.gap[b]))
        };
        all.chunks(nx.div_ceil(MOST_POINTS)).filter_map(|part| part.iter().min_by(nearest).copied()).collect()
    }

    /// Returns the pressures along a row, repulsion and attraction in separate colours, with the hardness.
    fn signed(&self, pressures: &[(f64, f64)], points: &[usize], over: f64) -> Panel {
        let part = |label: &str, hue, keep: fn(f64) -> f64| {
            let pairs = pressures.iter().map(|(x, p)| (*x, keep(*p)));
            Series { mark: Mark::Filled(Side::Zero), ..Series::line(label, hue, pairs) }
        };
        let mut panel = Panel::default();
        if largest_of_two_signs(&self.shown.pressure).is_some() {
            panel.series.push(part("repulsion", 0, |p| p.max(0.0)));
            panel.series.push(part("attraction", 3, |p| p.min(0.0)));
        } else {
            panel.series.push(part("", 0, |p| p));
        }
        match self.hardness {
            Some(Hardness::Uniform(hardness)) => panel.levels.push(Level::line(hardness / over, "hardness")),
            Some(Hardness::Field(field)) => {
                let ny = self.grid.points()[1];
                let at = |point: usize| field[[point / ny, point % ny]] / over;
                let pairs = pressures.iter().zip(points).map(|((x, _), point)| (*x, at(*point)));
                panel.series.push(Series { mark: Mark::Dashes, ..Series::line("hardness", 6, pairs) });
            }
            None => {}
        }
        panel
    }
}

/// Scale and labels of pressures in figures.
struct Pressures {
    /// Pressure shown as one on an axis.
    over: f64,
    /// Label of a map.
    label: String,
    /// Label of an axis.
    short: String,
}

/// Scales both coordinates of all points.
fn scaled(mut series: Vec<Series>, [x, y]: [f64; 2]) -> Vec<Series> {
    for point in series.iter_mut().flat_map(|series| &mut series.points) {
        (point.x, point.y) = (point.x * x, point.y * y);
    }
    series
}

/// Smallest attraction shown, relative to the largest repulsion; residuals of a hard wall are smaller.
const ATTRACTED: f64 = 1e-6;

/// Returns the end of a symmetric colour scale; `None` without attraction. The scale covers nearly all repulsive
/// values, without the few largest ones at sharp peaks, and at least the strongest attraction.
fn largest_of_two_signs(values: &[f64]) -> Option<f64> {
    let strongest = values.iter().fold(0.0, |strongest: f64, p| strongest.max(-p));
    let mut repulsive: Vec<f64> = values.iter().copied().filter(|p| *p > 0.0).collect();
    repulsive.sort_unstable_by(f64::total_cmp);
    let at = |level: f64| gfmd_measure::quantile(&repulsive, level).unwrap_or(0.0);
    (strongest > ATTRACTED * at(1.0)).then(|| strongest.max(at(0.995)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns fields of 6 x 2 points with the largest pressure in the row y = 1.
    fn shown() -> SceneFields {
        let row =
            |zero: [f64; 6], one: [f64; 6]| zero.into_iter().zip(one).flat_map(|(a, b)| [a, b]).collect::<Vec<f64>>();
        let pressure = row([0.0; 6], [0.0, 2.0, 4.0, 0.0, 0.0, 1.0]);
        SceneFields {
            repulsion: pressure.clone(),
            pressure,
            gap: row([9.0; 6], [0.5, 0.0, 0.0, 0.25, 0.5, 0.0]),
            level: row([7.0; 6], [1.0, 0.0, -1.0, 0.5, 1.0, 0.0]),
        }
    }

    fn scene<'a>(shown: &'a SceneFields, grid: &'a Grid, hardness: Option<&'a Hardness>) -> Scene<'a> {
        Scene { shown, grid, unit: "mm", stress: None, modulus: 2.0, hardness, rigid: rough(false), face: Face::Upper }
    }

    fn heights(series: &Series) -> Vec<f64> {
        series.points.iter().map(|point| point.y).collect()
    }

    #[test]
    fn the_section_has_both_surfaces_the_contact_and_the_pressure() {
        let (shown, grid) = (shown(), Grid::new([6, 2], [6.0, 2.0]).unwrap());
        let hardness = Hardness::Uniform(4.0);
        let chart = scene(&shown, &grid, Some(&hardness)).section().unwrap();
        let [upper, lower] = &chart.panels[..] else { panic!() };
        assert!(upper.title.contains("= 1 mm"), "{}", upper.title);
        assert_eq!(heights(&upper.series[1]), [1.0, 0.0, -1.0, 0.5, 1.0, 0.0]);
        assert_eq!(heights(&upper.series[0]), [1.5, 0.0, -1.0, 0.75, 1.5, 0.0]);
        // Two runs, half a step longer than their points where there are neighbours.
        let runs: Vec<Vec<(f64, f64)>> =
            upper.series[2..].iter().map(|run| run.points.iter().map(|point| (point.x, point.y)).collect()).collect();
        assert_eq!(runs, [vec![(0.5, 0.5), (1.0, 0.0), (2.0, -1.0), (2.5, -0.25)], vec![(4.5, 0.5), (5.0, 0.0)]]);
        assert_eq!(heights(&lower.series[0]), [0.0, 1.0, 2.0, 0.0, 0.0, 0.5]);
        assert_eq!((lower.series.len(), lower.levels.len(), lower.levels[0].range), (1, 1, [2.0, 2.0]));
        // A hardness field is a line along the row.
        let field = Hardness::Field(Array2::from_shape_fn((6, 2), |(i, j)| (4 + i + 10 * j) as f64));
        let chart = scene(&shown, &grid, Some(&field)).section().unwrap();
        assert_eq!(heights(&chart.panels[1].series[1]), [7.0, 7.5, 8.0, 8.5, 9.0, 9.5]);
        // Seen from a lower surface, the rigid one lies below.
        let below = Scene { face: Face::Lower, ..scene(&shown, &grid, None) }.section().unwrap();
        assert_eq!(heights(&below.panels[0].series[0]), [0.5, 0.0, -1.0, 0.25, 0.5, 0.0]);
    }

    #[test]
    fn attraction_is_shown_with_its_sign_and_residuals_are_not() {
        let (mut shown, grid) = (shown(), Grid::new([6, 2], [6.0, 2.0]).unwrap());
        let kinds = |shown: &SceneFields| {
            let mut kinds = Vec::new();
            let all = scene(shown, &grid, None).figures(|kind, drawn| {
                if let (FigureKind::Traction, Drawn::Map(map)) = (kind, drawn) {
                    assert_eq!(map.range, Some([-2.5, 2.5]), "the attraction of 5 is the largest");
                    assert_eq!(map.values.iter().copied().fold(f64::INFINITY, f64::min), -2.5);
                }
                kinds.push(kind.name());
                Ok::<_, ()>(())
            });
            all.unwrap();
            kinds
        };
        assert_eq!(kinds(&shown), ["map", "gap", "section"]);
        shown.pressure[9] = -1e-9;
        assert_eq!(kinds(&shown), ["map", "gap", "section"]);
        shown.pressure[9] = -5.0;
        assert_eq!(kinds(&shown), ["map", "traction", "gap", "section"]);
        let section = scene(&shown, &grid, None).section().unwrap();
        assert_eq!(heights(&section.panels[1].series[1]), [0.0, 0.0, 0.0, 0.0, -2.5, 0.0]);
        // A file may lack these fields.
        shown.level.clear();
        assert_eq!(kinds(&shown), ["map", "traction", "gap"]);
        shown.gap.clear();
        assert_eq!(kinds(&shown), ["map", "traction"]);
    }

    #[test]
    fn the_gap_is_none_in_contact_whatever_its_residual() {
        let (mut shown, grid) = (shown(), Grid::new([6, 2], [6.0, 2.0]).unwrap());
        (shown.gap[3], shown.gap[7]) = (1e-12, -1e-12);
        let distances: Vec<f64> = scene(&shown, &grid, None).distances().collect();
        assert_eq!((distances[3], distances[7], distances[1]), (0.0, 0.0, 0.5));
    }

    #[test]
    fn a_long_row_keeps_its_contacts() {
        let points = 3 * MOST_POINTS;
        let mut shown = SceneFields::zeros(points);
        shown.gap.fill(1.0);
        for place in [100, 101, 7000] {
            (shown.pressure[place], shown.repulsion[place], shown.gap[place]) = (1.0, 1.0, 0.0);
        }
        shown.gap[300] = 0.5;
        let grid = Grid::line(points, 1.0).unwrap();
        let chosen = scene(&shown, &grid, None).chosen(0);
        assert_eq!(chosen.len(), MOST_POINTS);
        assert!([100, 7000, 300].into_iter().all(|place| chosen.contains(&place)));
    }
}
