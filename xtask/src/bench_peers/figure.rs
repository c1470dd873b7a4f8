//! Figure of the page: time against the load for each Hurst exponent, and against the number of points.

use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};

use super::report::{Case, Report};
use super::table::median;

impl Report {
    /// Draws the seconds of every contestant on the first number of threads, as SVG. Loads are from the largest grid. A
    /// point of a size is the median over the loads that all contestants finished at all sizes.
    pub(super) fn figure(&self) -> Result<String, Failure> {
        let largest = self.cases.iter().map(|case| case.n).max().unwrap_or(0);
        let hursts = distinct(self.cases.iter().map(|case| case.hurst));
        let by_load = |hurst: &f64| {
            let title = format!("*H* = {hurst}, *n* = {largest}");
            let place = |case: &Case| (case.n == largest && case.hurst == *hurst).then_some(case.p_star);
            self.panel(title, Axis::log("*p*\\*"), place)
        };
        let mut panels: Vec<Panel> = hursts.iter().map(by_load).collect();
        let is_finished = |case: &Case| {
            let entries = case.timings.first().map_or(&[][..], |timing| &timing.entries[..]);
            self.contestants.iter().all(|name| entries.iter().any(|entry| entry.name == *name))
        };
        let sizes = distinct(self.cases.iter().map(|case| case.n as f64)).len();
        let common = |case: &Case| {
            let load = |case: &Case| (case.hurst, case.p_star);
            let finished = self.cases.iter().filter(|other| load(other) == load(case) && is_finished(other));
            (finished.count() == sizes).then_some(case.n as f64)
        };
        if sizes > 1 && self.cases.iter().any(|case| common(case).is_some()) {
            panels.push(self.panel("loads that all finished, median".into(), Axis::log("*n*"), common));
        }
        Ok(Chart::new(panels).svg()?)
    }

    /// Draws the seconds against the `place` of a case.
    fn panel(&self, title: String, x: Axis, place: impl Fn(&Case) -> Option<f64>) -> Panel {
        let places = distinct(self.cases.iter().filter_map(&place));
        let series = |(hue, name): (usize, &String)| {
            let at = |x: &f64| {
                let cases = self.cases.iter().filter(|case| place(case) == Some(*x));
                let entries = cases.filter_map(|case| case.timings.first()).flat_map(|timing| &timing.entries);
                let seconds: Vec<f64> =
                    entries.filter(|entry| entry.name == *name).map(|entry| entry.seconds).collect();
                (!seconds.is_empty()).then(|| Point::new(*x, median(&seconds)))
            };
            let found: Vec<Option<Point>> = places.iter().map(at).collect();
            let joined = |run: &[Option<Point>]| Series {
                mark: Mark::JoinedPoints,
                ..Series::points(name, hue, run.iter().flatten().copied().collect())
            };
            // Lines do not bridge missing cases.
            let runs = found.split(Option::is_none).filter(|run| !run.is_empty());
            runs.map(joined).collect::<Vec<_>>()
        };
        let series = self.contestants.iter().enumerate().flat_map(series).collect();
        Panel { title, x, y: Axis::log("time, s"), series, ..Panel::default() }
    }
}

/// Returns the distinct values in ascending order.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
