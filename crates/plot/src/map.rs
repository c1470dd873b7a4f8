//! Colour maps of fields on a plane, with axes in physical units and a colour bar.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::axis::{Ticks, padded};
use super::chart::COLUMN;
use super::colour::{INK, PALE, Rgb, diverging, hex, hue, mix, sequential};
use super::drawing::{Drawing, INDEXED, Picture};
use super::frame::{EDGE, Frame, GAP, LABEL, TICK, draw_axes, left_margin};
use super::text::{Anchor, Text, number};
use super::{Axis, PlotError, Scale};

/// Largest number of pixels; with more points, each pixel is a block of points.
const PIXELS: usize = 1 << 20;

/// Largest number of pixels along one side.
const LONGEST: usize = 1 << 13;

/// Number of colours of a scale: with the colour of a class, as many as a picture with one byte per pixel can have.
const LEVELS: usize = INDEXED - 1;

/// Maximum number of decades of a logarithmic scale, unless its range is given.
const DECADES: i32 = 8;

/// Width of the colour bar in points.
const BAR: f64 = 9.0;

/// Map of values on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<'a> {
    /// Values, row-major `[x, y]`.
    pub values: &'a [f64],
    /// Number of points along x and y.
    pub shape: [usize; 2],
    /// Length along x and y.
    pub size: [f64; 2],
    /// Coordinates of the lower left corner.
    pub origin: [f64; 2],
    /// Label of the x axis.
    pub x: String,
    /// Label of the y axis.
    pub y: String,
    /// Label of the colour bar.
    pub label: String,
    /// Spacing of the colours. If logarithmic, all values above the threshold of `below` must be positive.
    pub scale: Scale,
    /// Colours of the scale.
    pub colours: Colours,
    /// Class of values with a single colour.
    pub below: Option<Below>,
    /// Range of the colour scale; from the values if absent. Values beyond an end have its colour, and the bar has a
    /// triangle there.
    pub range: Option<[f64; 2]>,
    /// True if the map has a colour bar; false if colours only distinguish values.
    pub bar: bool,
    /// Width of the figure in points.
    pub width: f64,
}

/// Class of values up to a threshold that share one colour, such as "no contact".
#[derive(Clone, Debug, PartialEq)]
pub struct Below {
    /// Largest value of the class.
    pub threshold: f64,
    /// Name beside the colour bar.
    pub label: String,
    /// Index of its colour, as in [`Series`](super::Series); pale grey if absent.
    pub hue: Option<usize>,
}

impl Below {
    /// Creates a pale class.
    pub fn pale(threshold: f64, label: &str) -> Self {
        Self { threshold, label: label.into(), hue: None }
    }

    fn colour(&self) -> Rgb {
        self.hue.map_or(PALE, hue)
    }
}

/// Colours of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colours {
    /// From dark to light.
    #[default]
    Sequential,
    /// Red below the middle of the range, white in it, blue above: for values of two signs, with a range about zero.
    Diverging,
}

impl Colours {
    fn at(self, fraction: f64) -> Rgb {
        match self {
            Self::Sequential => sequential(fraction),
            Self::Diverging => diverging(fraction),
        }
    }
}

impl<'a> Map<'a> {
    /// Creates a map of `values` on a cell of `size`, one column wide, with all values coloured.
    pub fn new(values: &'a [f64], shape: [usize; 2], size: [f64; 2], label: &str) -> Self {
        let (x, y, label) = ("*x*".into(), "*y*".into(), label.into());
        let (scale, colours) = (Scale::default(), Colours::default());
        let (origin, below, range, bar) = ([0.0; 2], None, None, true);
        Self { values, shape, size, origin, x, y, label, scale, colours, below, range, bar, width: COLUMN }
    }

    fn is_coloured(&self, value: f64) -> bool {
        self.below.as_ref().is_none_or(|below| value > below.threshold)
    }
}

impl Map<'_> {
    /// Returns the figure as SVG text, with the field as an embedded PNG image.
    pub fn svg(&self) -> Result<String, PlotError> {
        draw(self)?.svg()
    }

    /// Returns the figure as an `svg` element for an HTML page. Its ids begin with `name`, which must be unique in the
    /// page; `title` is the alternative text.
    pub fn element(&self, name: &str, title: &str) -> Result<String, PlotError> {
        draw(self)?.element(name, title)
    }

    /// Returns the figure as PNG bytes.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        draw(self)?.png()
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        draw(self)?.save(stem)
    }
}

/// Maps side by side, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps<'a>(pub Vec<Map<'a>>);

impl Maps<'_> {
    /// Returns the figure as SVG text, with the fields as embedded PNG images.
    pub fn svg(&self) -> Result<String, PlotError> {
        self.draw()?.svg()
    }

    /// Returns the figure as PNG bytes.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        self.draw()?.png()
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        self.draw()?.save(stem)
    }

    fn draw(&self) -> Result<Drawing, PlotError> {
        if self.0.is_empty() {
            return Err(PlotError::Empty { what: "the figure has no maps" });
        }
        Ok(Drawing::row(self.0.iter().map(draw).collect::<Result<Vec<_>, _>>()?))
    }
}

pub(super) fn draw(map: &Map) -> Result<Drawing, PlotError> {
    let [nx, ny] = map.shape;
    if nx < 2 || ny < 2 || nx.checked_mul(ny) != Some(map.values.len()) {
        return Err(PlotError::Shape { found: map.values.len(), shape: map.shape });
    }
    if let Some(index) = map.values.iter().position(|value| !value.is_finite()) {
        let place = format!("the map at [{}, {}]", index / ny, index % ny);
        return Err(PlotError::NotFinite { found: map.values[index], place });
    }
    let (range, beyond) = colour_range(map)?;
    let ticks = |range: [f64; 2], labels: f64| Ticks::new(Scale::Linear, range, labels);
    let mut bar_ticks = Ticks::new(map.scale, range, 5.0)?;
    if !map.bar {
        bar_ticks.major.clear();
        bar_ticks.factor.clear();
    }
    let bar_labels = bar_ticks.major.iter().map(|(_, label)| Text::new(label, TICK).width()).fold(0.0, f64::max);
    let below_label = map.below.as_ref().map_or(0.0, |below| Text::new(&below.label, TICK).width());
    let y_label = Axis::linear(&map.y);
    // The height follows from the width, and the final ticks from the height. The margin is computed from preliminary
    // ticks with labels about as wide as the final ones.
    let right = 3.0 * GAP + BAR + (GAP + bar_labels + LABEL + 2.0 * GAP).max(GAP + below_label);
    let [along_x, along_y] = [0, 1].map(|axis| [map.origin[axis], map.origin[axis] + map.size[axis]]);
    let left = EDGE + left_margin(&ticks(along_y, 4.0)?, &y_label);
    let width = (map.width - left - right - EDGE).max(40.0);
    // A flat map is stretched to fit the labels along y, and the bar label beside the coloured part of the bar.
    let beside = Text::new(&map.label, LABEL).width() + swatch(map) + beyond.map(point).iter().sum::<f64>();
    let lowest = Text::new(&map.y, LABEL).width().max(beside).min(width);
    let height = (width * map.size[1] / map.size[0]).clamp(lowest, 3.0 * width);
    let (x, y) = (ticks(along_x, width / 40.0)?, ticks(along_y, height / 40.0)?);
    let top = EDGE + if bar_ticks.factor.is_empty() && y.factor.is_empty() { 0.5 * TICK } else { TICK + 2.0 * GAP };

    let frame = Frame { left, top, width, height, x, y };
    let mut svg = String::new();
    draw_axes(&mut svg, &frame, Some(&Axis::linear(&map.x)), Some(&y_label));
    if map.bar {
        draw_bar(&mut svg, map, &frame, &bar_ticks, beyond);
    }
    draw_beside(&mut svg, map, &frame, &bar_ticks, beyond);
    let picture = paint(map, &bar_ticks, [left, top, width, height]);
    let bottom = top + height + GAP + TICK + GAP + 1.1 * LABEL + EDGE;
    Ok(Drawing { width: map.width, height: bottom, pictures: vec![picture], elements: svg })
}

/// Returns the range of the colour scale, and two flags: values lie below it, values lie above it.
///
/// A field with singular edges has a few extremely large values. Unless the range is given, a linear scale therefore
/// ends at the 99.5 % quantile of the coloured values if the maximum is more than 1.5 times as far from the lower end.
/// It begins at the threshold of the class below, or else in the same way at the minimum or the 0.5 % quantile. A
/// logarithmic scale always begins at the 0.5 % quantile, or [`DECADES`] below the maximum, and ends at the maximum.
fn colour_range(map: &Map) -> Result<([f64; 2], [bool; 2]), PlotError> {
    let mut values: Vec<f64> = map.values.iter().copied().filter(|&value| map.is_coloured(value)).collect();
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &v| (least.min(v), most.max(v)));
    if map.scale == Scale::Log && least <= 0.0 {
        return Err(PlotError::NotPositive { found: least, place: "a value of the map".into() });
    }
    let mut at = |per_mille: usize| {
        let rank = (values.len() - 1) * per_mille / 1000;
        *values.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let range = match (map.range, map.scale, &map.below) {
        (Some(range), ..) => range,
        (None, Scale::Linear, _) if least > most => [0.0, 1.0],
        (None, Scale::Log, _) if least > most => [0.1, 1.0],
        (None, Scale::Log, _) => {
            let low = at(5).max(most * 10_f64.powi(-DECADES));
            if low < most { [low, most] } else { padded(Scale::Log, [most].into_iter()).unwrap_or([0.1, 1.0]) }
        }
        (None, Scale::Linear, below) => {
            let (least_of_all, most_of_all) = (at(5), at(995));
            let far = most_of_all - least > 1.5 * (most_of_all - least_of_all);
            let lowest = if far { least_of_all } else { least };
            let low = below.as_ref().map_or(lowest, |below| below.threshold);
            let high = if most - low > 1.5 * (most_of_all - low) { most_of_all } else { most };
            if high > low { [low, high] } else { padded(Scale::Linear, [low, most].into_iter()).unwrap_or([0.0, 1.0]) }
        }
    };
    if !(range[0].is_finite() && range[1].is_finite() && range[0] < range[1]) {
        return Err(PlotError::BadRange { range });
    }
    Ok((range, [least < range[0], most > range[1]]))
}

/// Returns the number of points along x and y per pixel: one, unless [`PIXELS`] or [`LONGEST`] is exceeded.
fn block([nx, ny]: [usize; 2]) -> [usize; 2] {
    let mut block = [nx, ny].map(|n| n.div_ceil(LONGEST));
    while nx.div_ceil(block[0]) * ny.div_ceil(block[1]) > PIXELS {
        block = block.map(|points| points + 1);
    }
    block
}

/// Paints one pixel per point or block of points: the colour of the mean of its coloured points, to the nearest of
/// [`LEVELS`], mixed with the colour of the others in proportion to their number.
fn paint(map: &Map, ticks: &Ticks, frame: [f64; 4]) -> Picture {
    let [nx, ny] = map.shape;
    let block = block(map.shape);
    let (columns, rows) = (nx.div_ceil(block[0]), ny.div_ceil(block[1]));
    let other = map.below.as_ref().map_or(PALE, Below::colour);
    let levels = (0..LEVELS).map(|level| map.colours.at(level as f64 / (LEVELS - 1) as f64));
    let mut palette: Vec<Rgb> = [other].into_iter().chain(levels).collect();
    let mut pixels = Vec::with_capacity(columns * rows);
    for row in (0..rows).rev() {
        let ys = row * block[1]..((row + 1) * block[1]).min(ny);
        for column in 0..columns {
            let xs = column * block[0]..((column + 1) * block[0]).min(nx);
            let (mut sum, mut coloured) = (0.0, 0);
            for x in xs.clone() {
                for &value in &map.values[x * ny + ys.start..x * ny + ys.end] {
                    if map.is_coloured(value) {
                        sum += ticks.fraction(value);
                        coloured += 1;
                    }
                }
            }
            let points = xs.len() * ys.len();
            let mean = (sum / coloured as f64).clamp(0.0, 1.0);
            let level = 1 + (mean * (LEVELS - 1) as f64).round() as usize;
            pixels.push(if coloured == 0 {
                0
            } else if coloured == points {
                level as u32
            } else {
                palette.push(mix(palette[level], other, coloured as f64 / points as f64));
                palette.len() as u32 - 1
            });
        }
    }
    Picture { frame, columns, rows, palette, pixels }
}

/// Returns the height of the swatch of a class below the bar, including its distance.
fn swatch(map: &Map) -> f64 {
    if map.below.is_some() { 0.8 * BAR + 2.0 * GAP } else { 0.0 }
}

/// Returns the height of the triangle of the bar for values beyond an end.
fn point(beyond: bool) -> f64 {
    if beyond { BAR } else { 0.0 }
}

fn draw_bar(svg: &mut String, map: &Map, frame: &Frame, ticks: &Ticks, beyond: [bool; 2]) {
    let ink = hex(INK);
    let left = frame.left + frame.width + 3.0 * GAP;
    // Leaves space below for the swatch of the class, and for the triangles of values beyond the range.
    let points = beyond.map(point);
    let (top, bottom) = (frame.top + points[1], frame.top + frame.height - swatch(map) - points[0]);
    let stops: String = (0..=32)
        .map(|i| {
            let fraction = f64::from(i) / 32.0;
            format!(
                r#"<stop offset="{}" stop-color="{}"/>"#,
                number(fraction * 100.0) + "%",
                hex(map.colours.at(fraction))
            )
        })
        .collect();
    let _ = writeln!(svg, r#"<linearGradient id="bar" x1="0" y1="1" x2="0" y2="0">{stops}</linearGradient>"#);
    let [l, t, w, h] = [left, top, BAR, bottom - top].map(number);
    let _ = writeln!(svg, r#"<rect x="{l}" y="{t}" width="{w}" height="{h}" fill="url(#bar)"/>"#);
    let triangle = |svg: &mut String, y: f64, by: f64, colour: Rgb| {
        let [x, y, half, by] = [left, y, 0.5 * BAR, by].map(number);
        let _ = writeln!(svg, r#"<path d="M{x} {y}l{half} {by}L{} {y}Z" fill="{}"/>"#, number(left + BAR), hex(colour));
    };
    if beyond[1] {
        triangle(svg, top, -points[1], map.colours.at(1.0));
    }
    if beyond[0] {
        triangle(svg, bottom, points[0], map.colours.at(0.0));
    }
    let mut outline = format!("M{} {}", number(left), number(bottom));
    if beyond[0] {
        let _ = write!(outline, "L{} {}", number(left + 0.5 * BAR), number(bottom + points[0]));
    }
    let _ = write!(outline, "L{} {}V{}", number(left + BAR), number(bottom), number(top));
    if beyond[1] {
        let _ = write!(outline, "L{} {}", number(left + 0.5 * BAR), number(top - points[1]));
    }
    let _ = write!(outline, "L{} {}Z", number(left), number(top));
    let right = left + BAR;
    for (value, label) in &ticks.major {
        let y = bottom - ticks.fraction(*value) * (bottom - top);
        let _ = write!(outline, "M{} {}h-2.4", number(right), number(y));
        Text::new(label, TICK).write(svg, right + GAP, y + 0.35 * TICK, Anchor::Start, 0.0, &ink);
    }
    let _ =
        writeln!(svg, r#"<path d="{outline}" stroke="{ink}" stroke-width="0.6" stroke-linejoin="round" fill="none"/>"#);
    if !ticks.factor.is_empty() {
        Text::new(&ticks.factor, TICK).write(svg, left, frame.top - GAP - 1.0, Anchor::Start, 0.0, &ink);
    }
}

/// Draws the label of the map and the swatch of its class.
fn draw_beside(svg: &mut String, map: &Map, frame: &Frame, ticks: &Ticks, beyond: [bool; 2]) {
    let ink = hex(INK);
    let left = frame.left + frame.width + 3.0 * GAP;
    let [below, above] = beyond.map(point);
    let middle = frame.top + 0.5 * (frame.height + above - below - swatch(map));
    let widest = ticks.major.iter().map(|(_, label)| Text::new(label, TICK).width()).fold(0.0, f64::max);
    let beside = if map.bar { left + BAR + 2.0 * GAP + widest } else { left };
    Text::new(&map.label, LABEL).write(svg, beside + 0.8 * LABEL, middle, Anchor::Middle, -90.0, &ink);
    if let Some(below) = &map.below {
        let [x, y, side] = [left, frame.top + frame.height - 0.8 * BAR, 0.8 * BAR].map(number);
        let colour = hex(below.colour());
        let _ = writeln!(
            svg,
            r#"<rect x="{x}" y="{y}" width="{side}" height="{side}" fill="{colour}" stroke="{ink}" stroke-width=".6"/>"#
        );
        let baseline = frame.top + frame.height - 0.4 * BAR + 0.35 * TICK;
        Text::new(&below.label, TICK).write(svg, left + 0.8 * BAR + GAP, baseline, Anchor::Start, 0.0, &ink);
    }
}
