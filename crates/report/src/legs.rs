//! Legs of a path, and panels along its length.

use gfmd_plot::{Axis, Mark, Panel, Point, Series};

/// Returns the indices of the steps with fields in a file. If legs have times or distances, these are the last steps of
/// the legs.
pub(crate) fn waypoints(table: &toml::Table, computed: usize, steps_of_leg: usize) -> Vec<usize> {
    let list = |name: &str| table.get(name).and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let lengths = ["time", "distance"].map(list);
    if lengths.iter().all(|list| list.is_empty()) {
        return (0..computed).step_by(steps_of_leg).collect();
    }
    let levels = ["pressure", "p_star", "force", "approach", "lateral", "lateral_y"].map(list);
    let legs = levels.into_iter().chain(lengths).map(<[toml::Value]>::len).fold(0, usize::max);
    let is_zero = |list: &[toml::Value], leg: usize| match list.get(leg.min(list.len().saturating_sub(1))) {
        None => true,
        Some(length) => length.as_float() == Some(0.0) || length.as_integer() == Some(0),
    };
    let ends = (0..legs).scan(0, |made, leg| {
        *made += if lengths.iter().all(|list| is_zero(list, leg)) { 1 } else { steps_of_leg };
        Some(*made - 1)
    });
    ends.take_while(|end| *end < computed).collect()
}

/// Returns true if the positive lengths span more than two decades.
pub(crate) fn is_long(lengths: &[f64]) -> bool {
    let positive = lengths.iter().copied().filter(|length| *length > 0.0);
    let [first, last] = positive.fold([f64::INFINITY, 0.0], |[first, last], x| [x.min(first), x.max(last)]);
    last > 100.0 * first
}

/// Returns panels of labelled columns against the length of a path. The axis is logarithmic, without a state at its
/// start, if it spans more than two decades. A constant number has no panel.
pub(crate) fn along(name: &str, columns: Vec<(Vec<(f64, f64)>, String)>) -> Vec<Panel> {
    let lengths: Vec<f64> = columns.iter().flat_map(|(points, _)| points).map(|(length, _)| *length).collect();
    let is_long = is_long(&lengths);
    let panel = |(points, label): (Vec<(f64, f64)>, String)| {
        let shown = points.into_iter().filter(|(length, _)| !is_long || *length > 0.0).map(|(x, y)| Point::new(x, y));
        Panel {
            x: if is_long { Axis::log(name) } else { Axis::linear(name) },
            y: Axis::linear(&label),
            series: vec![Series { mark: Mark::JoinedPoints, ..Series::points("", 0, shown.collect()) }],
            ..Panel::default()
        }
    };
    let varies = |(points, _): &(Vec<(f64, f64)>, String)| {
        let values = || points.iter().map(|(_, value)| *value).filter(|value| value.is_finite());
        let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        high - low > 1e-6 * high.abs().max(low.abs())
    };
    columns.into_iter().filter(varies).map(panel).collect()
}

/// Returns a path of points, leg by leg between its `waypoints`: joined points where the `drive`, one number per point,
/// rises or is held, hollow points and a broken line where it falls.
pub(crate) fn legs(points: &[(f64, f64)], drive: &[f64], waypoints: &[usize]) -> Vec<Series> {
    let last = points.len().saturating_sub(1);
    let inside = waypoints.iter().copied().filter(|place| (1..last).contains(place));
    let bounds: Vec<usize> = [0].into_iter().chain(inside).chain([last]).collect();
    let leg = |(hue, bounds): (usize, &[usize])| {
        let [start, end] = [bounds[0], bounds[1]];
        let points = points.get(start..=end).unwrap_or_default();
        let falls = drive.get(start).zip(drive.get(end)).is_some_and(|(first, last)| last < first);
        let is_held = drive.get(start..=end).is_some_and(|drive| drive.iter().all(|value| *value == drive[0]));
        let rises = if is_held && end > start { "held" } else { "rising" };
        let points: Vec<Point> = points.iter().map(|(x, y)| Point::new(*x, *y)).collect();
        let series = |label: &str, mark| Series { mark, ..Series::points(label, hue, points.clone()) };
        match falls {
            false => vec![series(&format!("leg {}, {rises}", hue + 1), Mark::JoinedPoints)],
            true => {
                vec![series("", Mark::Dashes), series(&format!("leg {}, falling", hue + 1), Mark::HollowPoints)]
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
        let labels: Vec<String> = legs(&points, &drive, &[0, 2]).into_iter().map(|series| series.label).collect();
        assert_eq!(labels, ["leg 1, rising", "", "leg 2, falling"]);
        // A path that ended within its second leg, and one without a step.
        assert_eq!(legs(&points[..3], &drive[..3], &[0, 1, 2]).len(), 2);
        assert!(legs(&[], &[], &[]).iter().all(|series| series.points.is_empty()));
    }

    #[test]
    fn a_leg_without_length_is_one_step() {
        let table: toml::Table =
            "pressure = [0.1]\nlateral = [0.0, 1.0, 2.0]\ntime = [0.0, 1.0, 0.0]\ndistance = [0, 0, 3]"
                .parse()
                .unwrap();
        assert_eq!(waypoints(&table, 100, 4), [0, 4, 8]);
        let table: toml::Table = "pressure = [0.1]\nlateral = [0.0, 1.0, 2.0]\ntime = [1.0]".parse().unwrap();
        assert_eq!(waypoints(&table, 9, 4), [3, 7]);
        assert_eq!(waypoints(&toml::Table::new(), 9, 4), [0, 4, 8]);
    }
}
