//! Legs of a path, and panels along its length.

use gfmd_plot::{Axis, Mark, Panel, Point, Scale, Series};

/// Returns the indices of the steps with fields in a file. If legs have times or distances, these are the last steps of
/// the legs.
pub(crate) fn waypoints(table: &toml::Table, computed: usize) -> Vec<usize> {
    let list = |name: &str| table.get(name).and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let steps = table.get("steps").map_or(&[][..], |given| match given {
        toml::Value::Array(list) => list,
        one => std::slice::from_ref(one),
    });
    let steps = |leg: usize| {
        let of_leg = steps.get(leg.min(steps.len().saturating_sub(1))).and_then(toml::Value::as_integer);
        of_leg.unwrap_or(1).max(1) as usize
    };
    let lengths = ["time", "distance"].map(list);
    if lengths.iter().all(|list| list.is_empty()) {
        let starts = (0..).scan(0, |made, leg| {
            *made += steps(leg);
            Some(*made - steps(leg))
        });
        return starts.take_while(|start| *start < computed).collect();
    }
    let levels = ["pressure", "p_star", "force", "approach", "lateral", "lateral_y"].map(list);
    let legs = levels.into_iter().chain(lengths).map(<[toml::Value]>::len).fold(0, usize::max);
    let is_zero = |list: &[toml::Value], leg: usize| match list.get(leg.min(list.len().saturating_sub(1))) {
        None => true,
        Some(length) => length.as_float() == Some(0.0) || length.as_integer() == Some(0),
    };
    let ends = (0..legs).scan(0, |made, leg| {
        *made += if lengths.iter().all(|list| is_zero(list, leg)) { 1 } else { steps(leg) };
        Some(*made - 1)
    });
    ends.take_while(|end| *end < computed).collect()
}

/// Part of an axis that a leg takes at least, divided by its part of the steps, so that the axis shows it.
const SHOWN: f64 = 0.02;

/// Steps of a path on the abscissa of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Abscissa {
    /// Axis.
    pub(crate) axis: Axis,
    /// Values of the steps.
    pub(crate) values: Vec<f64>,
}

impl Abscissa {
    /// Places steps at the length of the path so far, on a logarithmic axis if it spans more than two decades. The
    /// number of the step takes the place of a length that would hide one of the legs, which end at the `waypoints`.
    pub(crate) fn of_lengths(name: &str, lengths: Vec<f64>, waypoints: &[usize]) -> Self {
        let positive = lengths.iter().copied().filter(|length| *length > 0.0);
        let [first, last] = positive.fold([f64::INFINITY, 0.0], |[first, last], x| [x.min(first), x.max(last)]);
        let is_long = last > 100.0 * first;
        let place = |length: f64| if is_long { length.ln() } else { length };
        let whole = place(last) - place(if is_long { first } else { 0.0 });
        let is_hidden = |leg: &[usize]| {
            let [Some(start), Some(end)] = [lengths.get(leg[0]), lengths.get(leg[1])] else { return false };
            let part_of_steps = (leg[1] - leg[0]) as f64 / lengths.len() as f64;
            end > start && place(*end) - place(*start) < SHOWN * part_of_steps * whole
        };
        match waypoints.windows(2).any(is_hidden) {
            true => Self::of_steps(lengths.len()),
            false => Self { axis: if is_long { Axis::log(name) } else { Axis::linear(name) }, values: lengths },
        }
    }

    /// Places steps at their numbers.
    pub(crate) fn of_steps(count: usize) -> Self {
        Self { axis: Axis::linear("step"), values: (0..count).map(|step| step as f64).collect() }
    }

    /// Returns the points of numbers of the steps, without a state at the start of a logarithmic axis.
    pub(crate) fn points(&self, numbers: &[f64]) -> Vec<Point> {
        let has_place = |x: &f64| self.axis.scale != Scale::Log || *x > 0.0;
        let pairs = self.values.iter().zip(numbers).filter(|(x, _)| has_place(x));
        pairs.map(|(x, y)| Point::new(*x, *y)).collect()
    }
}

/// Returns panels of labelled columns against an abscissa. A constant number has no panel.
pub(crate) fn along(abscissa: &Abscissa, columns: Vec<(Vec<f64>, String)>) -> Vec<Panel> {
    let panel = |(numbers, label): (Vec<f64>, String)| Panel {
        x: abscissa.axis.clone(),
        y: Axis::linear(&label),
        series: vec![Series { mark: Mark::JoinedPoints, ..Series::points("", 0, abscissa.points(&numbers)) }],
        ..Panel::default()
    };
    let varies = |(numbers, _): &(Vec<f64>, String)| {
        let values = || numbers.iter().copied().filter(|value| value.is_finite());
        let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        high - low > 1e-6 * high.abs().max(low.abs())
    };
    columns.into_iter().filter(varies).map(panel).collect()
}

/// Returns the number of the leg that ends at the step `end`. A leg with a time or a distance ends at its waypoint, the
/// first one too; other legs are between waypoints.
pub fn leg_number(end: usize, waypoints: &[usize], has_lengths: bool) -> usize {
    waypoints.partition_point(|waypoint| *waypoint < end) + usize::from(has_lengths)
}

/// Returns a path of points, leg by leg between its `waypoints`: joined points where the `drive`, one number per point,
/// rises or is held, hollow points and a broken line where it falls.
pub(crate) fn legs(points: &[(f64, f64)], drive: &[f64], (waypoints, has_lengths): (&[usize], bool)) -> Vec<Series> {
    let last = points.len().saturating_sub(1);
    let inside = waypoints.iter().copied().filter(|place| (1..last).contains(place));
    let bounds: Vec<usize> = [0].into_iter().chain(inside).chain([last]).collect();
    let leg = |(hue, bounds): (usize, &[usize])| {
        let [start, end] = [bounds[0], bounds[1]];
        let points = points.get(start..=end).unwrap_or_default();
        let falls = drive.get(start).zip(drive.get(end)).is_some_and(|(first, last)| last < first);
        let is_held = drive.get(start..=end).is_some_and(|drive| drive.iter().all(|value| *value == drive[0]));
        let number = leg_number(end, waypoints, has_lengths);
        let rises = if is_held && end > start { "held" } else { "rising" };
        let points: Vec<Point> = points.iter().map(|(x, y)| Point::new(*x, *y)).collect();
        let series = |label: &str, mark| Series { mark, ..Series::points(label, hue, points.clone()) };
        match falls {
            false => vec![series(&format!("leg {number}, {rises}"), Mark::JoinedPoints)],
            true => {
                vec![series("", Mark::Dashes), series(&format!("leg {number}, falling"), Mark::HollowPoints)]
            }
        }
    };
    bounds.windows(2).enumerate().flat_map(leg).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Attraction grows while the surfaces approach: the abscissa falls, the drive rises.
    #[test]
    fn directions_are_those_of_the_drive() {
        let (points, drive) = ([(0.0, 0.0), (-1.0, 1.0), (-2.0, 0.5), (0.0, 0.0)], [0.0, 1.0, 2.0, -1.0]);
        let labels: Vec<String> =
            legs(&points, &drive, (&[0, 2], false)).into_iter().map(|series| series.label).collect();
        assert_eq!(labels, ["leg 1, rising", "", "leg 2, falling"]);
        // Legs with a time: the first one is a jump, or ends at the step 2.
        let labels = |waypoints| legs(&points, &drive, (waypoints, true)).remove(0).label;
        assert_eq!([labels(&[0, 2]), labels(&[2, 3])], ["leg 2, rising", "leg 1, rising"]);
        // A path that ended within its second leg, and one without a step.
        assert_eq!(legs(&points[..3], &drive[..3], (&[0, 1, 2], false)).len(), 2);
        assert!(legs(&[], &[], (&[], false)).iter().all(|series| series.points.is_empty()));
    }

    /// A day of rest, then ten seconds: neither a linear nor a logarithmic axis of time shows the seconds.
    #[test]
    fn an_axis_that_hides_a_leg_counts_steps() {
        let of = |lengths: &[f64], waypoints: &[usize]| Abscissa::of_lengths("time", lengths.to_vec(), waypoints).axis;
        let day = 86400.0;
        assert_eq!(of(&[0.0, day / 2.0, day, day + 5.0, day + 10.0], &[0, 2, 4]), Axis::linear("step"));
        assert_eq!(of(&[1.0, 1e3, day, day + 5.0, day + 10.0], &[2, 4]), Axis::linear("step"));
        // Loaded for a second, then left for a day: a logarithmic axis shows both.
        assert_eq!(of(&[0.0, 0.5, 1.0, day / 2.0, day], &[0, 2, 4]), Axis::log("time"));
        // A jump takes no time, and equal legs hide none of them, however many they are.
        assert_eq!(of(&[0.0, 1.0, 1.0, 2.0], &[0, 1, 2, 3]), Axis::linear("time"));
        let many: Vec<f64> = (1..10_000).map(f64::from).collect();
        assert_eq!(of(&many, &(0..many.len()).collect::<Vec<_>>()), Axis::log("time"));
        // A path that ended early.
        assert_eq!(of(&[1.0, 2.0], &[0, 1, 2]), Axis::linear("time"));
    }

    #[test]
    fn legs_end_at_waypoints_and_one_without_length_is_one_step() {
        let of = |steps: &str, lengths: &str, computed| {
            let text = format!("pressure = [0.1]\nlateral = [0.0, 1.0, 2.0]\nsteps = {steps}\n{lengths}");
            waypoints(&text.parse().unwrap(), computed)
        };
        let jump = "time = [0.0, 1.0, 0.0]\ndistance = [0, 0, 3]";
        assert_eq!(of("4", jump, 100), [0, 4, 8]);
        assert_eq!(of("[9, 4, 2]", jump, 100), [0, 4, 6]);
        assert_eq!(of("4", "time = [1.0]", 9), [3, 7]);
        assert_eq!(of("[4, 1, 5]", "time = [1.0]", 9), [3, 4]);
        assert_eq!(of("4", "", 9), [0, 4, 8]);
        assert_eq!(of("[4, 5]", "", 9), [0, 4]);
        assert_eq!(waypoints(&toml::Table::new(), 3), [0, 1, 2]);
    }
}
