//! Figures of the course of a path.

use gfmd_plot::{Axis, Mark, Panel, Series};
use gfmd_unit::Units;

use crate::figures::{largest, length};
use crate::legs::{Abscissa, along, legs};
use crate::page::sentence;
use crate::wear::against;

/// Reduced pressure as a label.
const REDUCED: &str = "*p*/(*E*\\* *g*)";

/// End of a caption against steps, where a length of the path would do otherwise.
const STEPS: &str = " (an axis of time or length would hide a short leg)";

/// End of a caption of legs through equilibria.
const LEGS: &str = " (leg by leg; each point is an equilibrium)";

/// Largest number of panels side by side.
const MOST_PANELS: usize = 4;

/// Columns of the energy lost by one cause, and the names of the causes.
pub(super) const CAUSES: [(&str, &str); 5] = [
    ("lost_relaxation", "relaxation"),
    ("lost_friction", "friction"),
    ("lost_wear", "wear"),
    ("lost_plastic", "plastic flow"),
    ("lost_jumps", "jumps"),
];

/// Numbers of a path for its figures.
pub struct Course<'a> {
    /// Returns the column of this name; NaN for numbers without a value.
    pub column: &'a dyn Fn(&str) -> Vec<f64>,
    /// Direction of the lateral displacements, a unit vector.
    pub direction: [f64; 2],
    /// Steps at the waypoints, in ascending order.
    pub waypoints: Vec<usize>,
    /// True if the body relaxes.
    pub relaxes: bool,
    /// Contact modulus, stress.
    pub modulus: f64,
    /// Unit of the reduced pressure, modulus times rms gradient.
    pub unit_pressure: f64,
    /// Unit of lengths.
    pub unit: &'a str,
    /// Units of the numbers.
    pub units: &'a Units,
}

/// Panels about one part of a path.
pub struct Drawing {
    /// Short name, the end of file names.
    pub name: &'static str,
    /// Title, with the alternative text of a figure.
    pub title: &'static str,
    /// Panels, at least one, each with a sentence about it.
    pub panels: Vec<(Panel, String)>,
}

impl Drawing {
    /// Creates a drawing, with captions made from the labels of the axes; `end` is the end of each caption.
    fn new(name: &'static str, title: &'static str, end: &str, panels: Vec<Panel>) -> Self {
        let caption = |panel: &Panel| {
            let x = match word(&panel.x.label) {
                word @ ("time" | "approach" | "pressure") => word.to_owned(),
                "distance" => "the sliding distance".into(),
                "lateral path" => "the length of the lateral path".into(),
                other => format!("the {other}"),
            };
            sentence(&format!("{} against {x}{end}.", word(&panel.y.label)))
        };
        let panels = panels.into_iter().map(|panel| (caption(&panel), panel));
        Self { name, title, panels: panels.map(|(caption, panel)| (panel, caption)).collect() }
    }
}

/// Returns the name of a quantity in the label of an axis.
fn word(label: &str) -> &str {
    if label == REDUCED { "pressure" } else { label.split(" / ").next().unwrap_or(label) }
}

/// Returns true if the numbers differ; false for numbers without a value.
fn varies(values: &[f64]) -> bool {
    values.iter().any(|value| value.is_finite() && *value != values[0])
}

/// Returns true if there is a number.
fn has_value(values: &[f64]) -> bool {
    values.iter().any(|value| value.is_finite())
}

impl Course<'_> {
    fn column(&self, name: &str) -> Vec<f64> {
        (self.column)(name)
    }

    /// Returns the components of a vector along the motion: in the direction of the lateral displacements, or at a
    /// right angle to it if the surface moves in that direction only.
    fn along(&self, name: &str) -> Vec<f64> {
        let [x, y] = self.direction;
        let onto = |name: &str, [x, y]: [f64; 2]| -> Vec<f64> {
            let [along_x, along_y] = ["x", "y"].map(|axis| self.column(&format!("{name}_{axis}")));
            along_x.iter().zip(along_y).map(|(a, b)| a * x + b * y).collect()
        };
        let moves = |direction| varies(&onto("lateral", direction));
        onto(name, if !moves([x, y]) && moves([-y, x]) { [-y, x] } else { [x, y] })
    }

    /// Returns the length of the lateral path so far.
    fn travelled(&self) -> Vec<f64> {
        let [x, y] = ["lateral_x", "lateral_y"].map(|name| self.column(name));
        let mut sum = 0.0;
        let steps = (0..x.len()).map(|step| {
            if let Some(before) = step.checked_sub(1) {
                sum += (x[step] - x[before]).hypot(y[step] - y[before]);
            }
            sum
        });
        steps.collect()
    }

    /// Returns the drawings of all parts that the path has.
    pub fn drawings(&self) -> Vec<Drawing> {
        let sideways = varies(&self.along("lateral"));
        let by_distance = varies(&self.column("distance"));
        let wears = self.column("wear_volume").last().is_some_and(|volume| *volume > 0.0);
        let mut drawings = Vec::new();
        if self.relaxes {
            drawings.extend(self.in_time());
        }
        if sideways {
            drawings.push(self.shear_loop());
        }
        if !(self.relaxes || sideways || by_distance) {
            drawings.push(self.load_and_area());
        }
        if wears && (by_distance || sideways) {
            drawings.push(self.wear(by_distance));
        }
        drawings.extend(self.losses(by_distance, sideways));
        drawings.retain(|drawing| !drawing.panels.is_empty());
        drawings
    }

    /// Returns panels of contact area, reduced pressure, approach, and with friction shear and sticking area, against
    /// time. A constant number has no panel.
    fn in_time(&self) -> Vec<Drawing> {
        let approach = self.column("approach");
        let finite: Vec<f64> = approach.iter().copied().filter(|value| value.is_finite()).collect();
        let read = length(self.unit, largest(&finite));
        let scaled = |values: Vec<f64>, factor: f64| values.into_iter().map(|value| value * factor).collect();
        let mut columns = vec![
            ("contact area", self.column("area_fraction"), "contact area".to_owned()),
            ("pressure", self.column("p_star"), REDUCED.to_owned()),
            ("approach", scaled(approach, read.factor), format!("approach / {}", read.name)),
        ];
        let stick = self.column("stick_fraction");
        if has_value(&stick) {
            let shear = scaled(self.along("mean_shear"), 1.0 / self.unit_pressure);
            columns.push(("shear", shear, "shear / (*E*\\* *g*)".to_owned()));
            columns.push(("sticking area", stick, "sticking area".to_owned()));
        }
        let (abscissa, end) = self.abscissa(false, false);
        let panels = columns.into_iter().map(|(word, values, label)| (word, along(&abscissa, vec![(values, label)])));
        let panels: Vec<(&str, Vec<Panel>)> = panels.filter(|(_, panels)| !panels.is_empty()).collect();
        let drawing = |name, title, panels: Vec<(&str, Vec<Panel>)>| {
            Drawing::new(name, title, end, panels.into_iter().flat_map(|(_, panels)| panels).collect())
        };
        if panels.len() <= MOST_PANELS {
            return vec![drawing("path", "the path", panels)];
        }
        let of_shear = |(word, _): &(&str, Vec<Panel>)| ["shear", "sticking area"].contains(word);
        let (shear, others): (Vec<_>, Vec<_>) = panels.into_iter().partition(of_shear);
        vec![drawing("path", "the path", others), drawing("time", "shear in time", shear)]
    }

    /// Returns a panel with the legs of the path, whose directions are the signs of the `drive`.
    fn panel(&self, x: &str, y: &str, points: [&[f64]; 2], drive: &[f64]) -> Panel {
        let points: Vec<(f64, f64)> = points[0].iter().copied().zip(points[1].iter().copied()).collect();
        let has_lengths = ["time", "distance"].iter().any(|name| has_value(&self.column(name)));
        let series = legs(&points, drive, (&self.waypoints, has_lengths));
        Panel { x: Axis::linear(x), y: Axis::linear(y), series, ..Panel::default() }
    }

    /// Returns panels of shear and sticking or contact area against the lateral displacement.
    fn shear_loop(&self) -> Drawing {
        let lateral = self.along("lateral");
        let read = length(self.unit, largest(&lateral));
        let lateral: Vec<f64> = lateral.iter().map(|value| value * read.factor).collect();
        let shear: Vec<f64> = self.along("mean_shear").iter().map(|shear| shear / self.unit_pressure).collect();
        let stick = self.column("stick_fraction");
        let (label, share) =
            if has_value(&stick) { ("sticking area", stick) } else { ("contact area", self.column("area_fraction")) };
        let x = format!("lateral displacement / {}", read.name);
        let panels = vec![
            self.panel(&x, "shear / (*E*\\* *g*)", [&lateral, &shear], &lateral),
            self.panel(&x, label, [&lateral, &share], &lateral),
        ];
        let (name, title) = if self.relaxes { ("shear", "the shear loop") } else { ("path", "the path") };
        let end = if self.relaxes { " (leg by leg)" } else { LEGS };
        Drawing::new(name, title, end, panels)
    }

    /// Returns panels of reduced pressure against approach, if it is known, and contact area against pressure.
    fn load_and_area(&self) -> Drawing {
        let [approach, p_star, area] = ["approach", "p_star", "area_fraction"].map(|name| self.column(name));
        if !has_value(&approach) {
            let panels = vec![self.panel(REDUCED, "contact area", [&p_star, &area], &p_star)];
            return Drawing::new("path", "the path", LEGS, panels);
        }
        let read = length(self.unit, largest(&approach));
        let scaled: Vec<f64> = approach.iter().map(|value| value * read.factor).collect();
        let x = format!("approach / {}", read.name);
        let panels = vec![
            self.panel(&x, REDUCED, [&scaled, &p_star], &approach),
            self.panel(REDUCED, "contact area", [&p_star, &area], &approach),
        ];
        Drawing::new("path", "the path", LEGS, panels)
    }

    /// Returns panels of mean depth lost, contact area and largest pressure against the sliding distance, or the length
    /// of the lateral path.
    fn wear(&self, by_distance: bool) -> Drawing {
        let (abscissa, end) = self.length(by_distance);
        let panels = against(&abscissa, self.column, self.modulus, self.unit);
        let title = if by_distance { "wear against distance" } else { "wear against the lateral path" };
        Drawing::new("wear", title, end, panels)
    }

    /// Returns a panel of the energy lost so far by each cause, and their sum; `None` unless there are several causes.
    fn losses(&self, by_distance: bool, sideways: bool) -> Option<Drawing> {
        let so_far = |values: Vec<f64>| -> Vec<f64> {
            let add = |sum: &mut f64, value: f64| {
                *sum += if value.is_finite() { value } else { 0.0 };
                Some(*sum)
            };
            values.into_iter().scan(0.0, add).collect()
        };
        let columns = CAUSES.iter().enumerate().map(|(hue, (column, cause))| (hue, *cause, self.column(column)));
        let causes: Vec<(usize, &str, Vec<f64>)> = columns.filter(|(.., values)| has_value(values)).collect();
        if causes.len() < 2 {
            return None;
        }
        let causes = causes.into_iter().map(|(hue, cause, values)| (hue, cause, so_far(values)));
        let causes: Vec<_> = causes.filter(|(.., values)| largest(values) > 0.0).collect();
        let all = so_far(self.column("dissipated"));
        let most = causes.iter().map(|(.., values)| largest(values)).fold(largest(&all), f64::max);
        let shown = self.units.shown("stress*length", most);
        let (factor, y) = shown.map_or((1.0, "energy lost / (stress length)".into()), |unit| {
            (unit.factor, format!("energy lost / ({})", unit.name))
        });
        let (abscissa, end) = self.abscissa(by_distance, sideways);
        let points = |energies: &[f64]| {
            let energies: Vec<f64> = energies.iter().map(|energy| energy * factor).collect();
            abscissa.points(&energies)
        };
        let mut series: Vec<Series> = Vec::new();
        if causes.len() > 1 {
            series.push(Series { mark: Mark::Dashes, ..Series::points("all", 6, points(&all)) });
        }
        series.extend(causes.iter().map(|(hue, cause, energies)| Series {
            mark: Mark::JoinedPoints,
            ..Series::points(cause, *hue, points(energies))
        }));
        let against = match word(&abscissa.axis.label) {
            "time" => "time".to_owned(),
            other => format!("the {other}{end}"),
        };
        let caption = match &causes[..] {
            [] => return None,
            [(_, cause, _)] => format!("Energy lost so far per area, all of it by {cause}, against {against}."),
            _ => format!("Energy lost so far per area, by cause and in all, against {against}."),
        };
        let panel = Panel { x: abscissa.axis, y: Axis::linear(&y), series, ..Panel::default() };
        Some(Drawing { name: "losses", title: "energy lost by cause", panels: vec![(panel, caption)] })
    }

    /// Returns the abscissa of numbers along the path, and the end of a caption.
    fn abscissa(&self, by_distance: bool, sideways: bool) -> (Abscissa, &'static str) {
        match () {
            () if self.relaxes => {
                let unit = Units::new(Some(self.unit), None).shown("time", 1.0);
                self.placed(&unit.map_or("time".into(), |unit| format!("time / {unit}")), self.column("time"))
            }
            () if sideways || by_distance => self.length(!sideways),
            () => (Abscissa::of_steps(self.column("mean_pressure").len()), ""),
        }
    }

    /// Returns the sliding distance, or the length of the lateral path, as an abscissa, and the end of a caption.
    fn length(&self, by_distance: bool) -> (Abscissa, &'static str) {
        let (name, lengths) = match by_distance {
            true => ("distance", self.column("distance")),
            false => ("lateral path", self.travelled()),
        };
        let read = length(self.unit, largest(&lengths));
        let lengths = lengths.into_iter().map(|length| length * read.factor).collect();
        self.placed(&format!("{name} / {}", read.name), lengths)
    }

    /// Returns an abscissa of lengths, or of steps if it would hide a leg, and the end of a caption.
    fn placed(&self, name: &str, lengths: Vec<f64>) -> (Abscissa, &'static str) {
        let abscissa = Abscissa::of_lengths(name, lengths, &self.waypoints);
        let end = if abscissa.axis.label == name { "" } else { STEPS };
        (abscissa, end)
    }
}
