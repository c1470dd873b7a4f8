//! Searches that did not converge: unmet criteria, history of the residual, and advice.

use std::fmt;

use gfmd_contact::{Fields, Why};
use gfmd_files::{Archive, Dimension, Reader, Variable};
use gfmd_problem::{Spelling, Words, key, setting, words};
use serde::Serialize;

use gfmd_input::failure::Failure;

/// Largest number of samples of a history; if there are more, every second one is left out.
const MOST_SAMPLES: usize = 64;

/// Residual against iterations of one search, in equally spaced samples and the last one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct History {
    iteration: Vec<u64>,
    residual: Vec<f64>,
    #[serde(skip)]
    every: u64,
    #[serde(skip)]
    last: Option<(u64, f64)>,
}

impl Default for History {
    fn default() -> Self {
        Self { iteration: Vec::new(), residual: Vec::new(), every: 1, last: None }
    }
}

impl History {
    /// Returns iteration and residual of each sample.
    pub fn samples(&self) -> impl Iterator<Item = (u64, f64)> {
        self.iteration.iter().copied().zip(self.residual.iter().copied())
    }

    /// Adds an iteration; a search that begins anew has a new history.
    pub fn see(&mut self, iteration: u64, residual: f64) {
        if self.last.is_some_and(|(last, _)| iteration < last) {
            *self = Self::default();
        }
        self.last = Some((iteration, residual));
        if !iteration.is_multiple_of(self.every) {
            return;
        }
        // A search that takes no iteration reports the same one again and again.
        if let (true, Some(last)) = (self.iteration.last() == Some(&iteration), self.residual.last_mut()) {
            *last = residual;
            return;
        }
        self.iteration.push(iteration);
        self.residual.push(residual);
        if self.iteration.len() > MOST_SAMPLES {
            self.every = self.every.saturating_mul(2);
            let keep: Vec<bool> = self.iteration.iter().map(|iteration| iteration.is_multiple_of(self.every)).collect();
            let mut kept = keep.iter();
            self.iteration.retain(|_| *kept.next().unwrap_or(&true));
            let mut kept = keep.iter();
            self.residual.retain(|_| *kept.next().unwrap_or(&true));
        }
    }

    /// Adds the last iteration if it is not a sample.
    fn closed(mut self) -> Self {
        if let Some((iteration, residual)) = self.last.filter(|(last, _)| self.iteration.last() != Some(last)) {
            self.iteration.push(iteration);
            self.residual.push(residual);
        }
        self
    }

    /// Predicts the number of iterations at which the residual falls to `aim`, at its rate over the last half; `None`
    /// if it does not fall.
    fn forecast(&self, aim: f64) -> Option<f64> {
        let end = self.residual.len().checked_sub(1)?;
        let middle = end / 2;
        // A residual that goes up and down has fallen if its minimum has.
        let least = |part: &[f64]| part.iter().copied().fold(f64::INFINITY, f64::min);
        let [before, after] = [least(&self.residual[..=middle]), least(&self.residual[middle..])];
        let [fall, left] = [before / after, self.residual[end] / aim].map(f64::ln);
        let steps = (self.iteration[end] - self.iteration[middle]) as f64;
        // A fall by less than a tenth over this half is no progress.
        (fall > 0.1 && left > 0.0)
            .then(|| self.iteration[end] as f64 + steps * left / fall)
            .filter(|total| *total < 1e9)
    }
}

impl fmt::Display for History {
    /// Writes a line of bars with the logarithm of the residual as their height.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let heights: Vec<f64> = self.residual.iter().map(|residual| residual.max(f64::MIN_POSITIVE).log10()).collect();
        let finite = || heights.iter().copied().filter(|height| height.is_finite());
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        for height in &heights {
            let share = if high > low { (height - low) / (high - low) } else { 0.0 };
            let bar = if height.is_finite() { BARS[(share * 7.0).round().clamp(0.0, 7.0) as usize] } else { '?' };
            write!(f, "{bar}")?;
        }
        Ok(())
    }
}

/// Unmet criterion of convergence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Criterion {
    /// Name of the residual, as in `residual` of the report.
    pub name: String,
    /// Residual.
    pub value: f64,
    /// Largest allowed value.
    pub allowed: f64,
}

impl fmt::Display for Criterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:e} above {:e}", self.name, self.value, self.allowed)
    }
}

/// Part of a run that did not converge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NotConverged {
    /// Number of the load, step or grid, from 0.
    pub part: usize,
    /// Reason why the search ended.
    pub why: String,
    /// Unmet criteria.
    pub criteria: Vec<Criterion>,
    /// Residual seen by the search.
    pub history: History,
    /// Advice in words.
    pub advice: String,
}

impl NotConverged {
    /// Reports a state that does not meet `tolerance`; `spelling` is of the options in the advice.
    pub fn new(
        part: usize,
        state: &impl Fields,
        tolerance: f64,
        why: &Why,
        history: History,
        spelling: Spelling,
    ) -> Self {
        Self::of(part, state.residuals(), tolerance, why, history, spelling)
    }

    /// Reports like [`new`](Self::new), from named residuals.
    pub fn of(
        part: usize,
        residuals: Vec<(&'static str, f64)>,
        allowed: f64,
        why: &Why,
        history: History,
        spelling: Spelling,
    ) -> Self {
        let history = history.closed();
        let unmet = residuals.into_iter().filter(|(_, value)| value.is_nan() || *value > allowed);
        Self {
            part,
            why: why.to_string(),
            criteria: unmet.map(|(name, value)| Criterion { name: name.into(), value, allowed }).collect(),
            advice: advice(why, &history, allowed).spelled(spelling),
            history,
        }
    }

    /// Prints the unmet criteria, the history and the advice on stderr.
    pub fn tell(&self, what: &str) {
        let Self { part, why, criteria, history, advice } = self;
        for Criterion { name, value, allowed } in criteria {
            tracing::info!("{what} {part}: {name} is {value:.1e}; it must be at most {allowed:.1e} ({why})");
        }
        if let [first, .., last] = history.residual[..] {
            let iterations = history.iteration.last().copied().unwrap_or(0);
            tracing::info!(
                "{what} {part}: residual {history} from {first:.1e} to {last:.1e} in {iterations} iterations"
            );
        }
        tracing::info!("{what} {part}: {advice}");
    }

    /// Writes the group `/not_converged` of a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&self, archive: &mut Archive) -> Result<(), Failure> {
        let sample = Dimension::index("sample", self.history.iteration.len(), "sample of the history");
        let iteration = Variable { dimensions: &[&sample], units: "1", long_name: "solver iterations" };
        archive.write("/not_converged/iteration", &iteration, &self.history.iteration)?;
        let residual = Variable { dimensions: &[&sample], units: "1", long_name: "residual seen by the solver" };
        archive.write("/not_converged/residual", &residual, &self.history.residual)?;
        archive.attribute("/not_converged", "part", self.part as u64)?;
        archive.attribute("/not_converged", "why", self.why.as_str())?;
        archive.attribute("/not_converged", "advice", self.advice.as_str())?;
        let criteria: Vec<String> = self.criteria.iter().map(|criterion| format!("{criterion}\n")).collect();
        archive.attribute("/not_converged", "criteria", criteria.concat())?;
        Ok(())
    }

    /// Reads the group `/not_converged` of a file; `None` if it has none. A missing number is 0 or absent.
    pub fn read(reader: &Reader) -> Option<Self> {
        let group = "/not_converged";
        let why = reader.text(group, "why").ok()?;
        let text = |name| reader.text(group, name).unwrap_or_default();
        let samples = |name| reader.values::<f64>(&format!("{group}/{name}")).unwrap_or_default();
        let criterion = |line: &str| {
            let (name, numbers) = line.rsplit_once(": ")?;
            let (value, allowed) = numbers.split_once(" above ")?;
            Some(Criterion { name: name.into(), value: value.parse().ok()?, allowed: allowed.parse().ok()? })
        };
        let iteration = samples("iteration").into_iter().map(|iteration| iteration as u64).collect();
        Some(Self {
            part: reader.number(group, "part").unwrap_or(0.0) as usize,
            why,
            criteria: text("criteria").lines().filter_map(criterion).collect(),
            history: History { iteration, residual: samples("residual"), ..History::default() },
            advice: text("advice"),
        })
    }
}

/// Returns advice for a search that ended because of `why`.
fn advice(why: &Why, history: &History, tolerance: f64) -> Words {
    // A search that sees no residual above the tolerance gains nothing from more iterations.
    let is_blind = *why == Why::Iterations && history.residual.last().is_some_and(|last| *last <= tolerance);
    let looser = setting("tolerance", format!("{:.0e}", 10.0 * tolerance));
    match why {
        _ if is_blind => advice(&Why::Certificate, history, tolerance),
        Why::Iterations => match history.forecast(tolerance) {
            Some(needed) => words![
                format!("at its rate over the last half of the search it needs about {needed:.0} iterations; try "),
                setting("max_iterations", format!("{:.0}", 1.5 * needed)),
            ],
            None => {
                let reached = history.residual.iter().copied().fold(tolerance, f64::min).max(tolerance);
                let above = format!(" above {reached:.0e}");
                words![
                    "the residual has stopped falling; try another ",
                    key("solver"),
                    ", smaller steps of the load, or a ",
                    key("tolerance"),
                    above,
                ]
            }
        },
        Why::Rounding | Why::Certificate => {
            words!["this precision does not hold the tolerance here; try ", looser]
        }
        Why::Direction | Why::NoDescent => {
            words!["rounding may keep the residual up; try ", looser, ", or another ", key("solver")]
        }
        Why::Circles | Why::Displaced => "try smaller steps of the load".into(),
        Why::LowestCell => words!["try ", key("cells"), " that reach deeper, or a lower load"],
        Why::Uphill { .. } | Why::Unsettled => words!["try another ", key("solver"), ", or smaller steps of the load"],
        _ => words![
            "try another ",
            key("solver"),
            ", smaller steps of the load, and check the units of lengths and stresses",
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(residuals: impl Iterator<Item = f64>) -> History {
        let mut history = History::default();
        residuals.enumerate().for_each(|(i, residual)| history.see(i as u64, residual));
        history.closed()
    }

    #[test]
    fn an_iteration_that_is_seen_again_has_its_last_residual() {
        let mut history = History::default();
        for k in 0..100_000 {
            history.see(0, f64::from(k));
        }
        history.see(1, 0.5);
        assert_eq!(
            (&history.iteration[..], &history.residual[..], history.every),
            (&[0, 1][..], &[99_999.0, 0.5][..], 1)
        );
    }

    #[test]
    fn a_history_keeps_equal_distances_and_the_end() {
        let long = history((0..10_001).map(|i| 0.999_f64.powi(i)));
        assert!(long.iteration.len() <= MOST_SAMPLES + 1 && long.iteration.len() > MOST_SAMPLES / 2);
        assert_eq!(long.iteration.len(), long.residual.len());
        assert_eq!((long.iteration[0], *long.iteration.last().unwrap()), (0, 10_000));
        let steps: Vec<u64> = long.iteration.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps[..steps.len() - 1].iter().all(|step| *step == steps[0]));
        let mut two = History::default();
        (0..9).for_each(|i| two.see(i, 1.0));
        (0..3).for_each(|i| two.see(i, 2.0));
        assert_eq!(two.closed().residual, [2.0; 3], "a new search begins");
    }

    #[test]
    fn the_forecast_is_right_for_a_steady_fall_and_absent_without_one() {
        let falling = history((0..200).map(|i| 0.9_f64.powi(i)));
        let needed = falling.forecast(1e-12).unwrap();
        assert!((needed - 1e-12_f64.ln() / 0.9_f64.ln()).abs() < 2.0, "{needed}");
        assert!(history((0..200).map(|_| 0.1)).forecast(1e-12).is_none());
        assert!(history(std::iter::empty()).forecast(1e-12).is_none());
        assert!(history((0..200).map(|_| f64::NAN)).forecast(1e-12).is_none());
        let noise = |i: i32| 1e-7 * (1.0 + 0.3 * f64::from(i).sin());
        assert!(history((0..200).map(noise)).forecast(1e-12).is_none());
        assert!(history((0..200).map(|i| noise(i) * 1.01_f64.powi(i))).forecast(1e-12).is_none());
        assert!(history((0..200).map(|i| noise(i) * 0.9_f64.powi(i))).forecast(1e-30).is_some());
        let seen = NotConverged::of(0, vec![("load", 1.0)], 1e-2, &Why::Iterations, falling, Spelling::Flag);
        assert!(!seen.advice.contains("--max-iter"), "{}", seen.advice);
        let short = history((0..20).map(|i| 0.9_f64.powi(i)));
        let reported =
            NotConverged::of(0, vec![("load", 1e-3), ("gap", f64::NAN)], 1e-2, &Why::Iterations, short, Spelling::Flag);
        assert_eq!(reported.criteria.len(), 1, "NaN passes no comparison");
        assert_eq!(reported.criteria[0].name, "gap");
        assert!(reported.advice.contains("--max-iterations"), "{}", reported.advice);
        assert_eq!(reported.history.to_string().chars().next(), Some('█'));
        assert_eq!(reported.history.to_string().chars().last(), Some('▁'));
    }
}
