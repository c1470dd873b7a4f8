//! The printed report of steady sliding, and its figure.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use gfmd_contact::Fields as _;
use gfmd_measure::Scales;
use gfmd_report::figures::named;
use gfmd_report::slide::{Sliding, chart};
use gfmd_run::failure::Failure;
use gfmd_run::series::Head;
use gfmd_viscoelastic::{SlidingState, Velocity};
use serde::Serialize;

use crate::session::list_files;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    /// Unit vector of the velocity.
    pub direction: [f64; 2],
    /// Every load at every velocity, loads outer.
    pub states: Vec<State>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// A steady state, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct State {
    pub velocity: f64,
    pub mean_pressure: f64,
    pub p_star: f64,
    pub displacement: f64,
    pub area_fraction: f64,
    pub mean_gap: f64,
    pub max_pressure: f64,
    pub friction: f64,
    pub friction_slope: f64,
    pub dissipated_power: f64,
    pub persson: Persson,
    pub iterations: u64,
    pub transform_pairs: f64,
    pub converged: bool,
    pub residual: BTreeMap<&'static str, f64>,
    pub seconds: f64,
}

/// Persson's theory, as printed.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Persson {
    /// Coefficient of friction.
    pub friction: f64,
    /// Contact area over the whole area.
    pub area_fraction: f64,
}

impl State {
    pub(super) fn new(
        velocity: &Velocity,
        state: &SlidingState,
        gfmd_viscoelastic::Persson { friction, area_fraction }: gfmd_viscoelastic::Persson,
        (scales, tolerance): (&Scales, f64),
        seconds: f64,
    ) -> Self {
        let summary = state.summary_in(scales);
        let effort = state.effort();
        Self {
            velocity: velocity.speed(),
            mean_pressure: state.solution.mean_pressure,
            p_star: summary.p_star,
            displacement: state.solution.approach,
            area_fraction: summary.area_fraction,
            mean_gap: summary.mean_gap,
            max_pressure: summary.max_pressure,
            friction: state.friction,
            friction_slope: state.friction_slope,
            dissipated_power: state.dissipated_power,
            persson: Persson { friction, area_fraction },
            iterations: effort.iterations,
            transform_pairs: effort.transform_pairs,
            converged: state.worst() <= tolerance,
            residual: state.residuals().into_iter().collect(),
            seconds,
        }
    }
}

impl State {
    /// The largest residual; NaN if one is NaN.
    pub(super) fn worst(&self) -> f64 {
        let larger = |worst: f64, residual: &f64| match residual.is_nan() || worst.is_nan() {
            true => f64::NAN,
            false => worst.max(*residual),
        };
        self.residual.values().fold(0.0, larger)
    }
}

impl Report {
    /// Draws friction and area against the velocity, one curve for each load, of so many `velocities`.
    pub(super) fn draw(&self, prefix: &Path, velocities: usize) -> Result<Vec<PathBuf>, Failure> {
        let state = |state: &State| Sliding {
            velocity: state.velocity,
            p_star: state.p_star,
            friction: [state.friction, state.persson.friction],
            area: [state.area_fraction, state.persson.area_fraction],
        };
        let states: Vec<Sliding> = self.states.iter().map(state).collect();
        let chart = chart(&states, velocities);
        Ok(chart.save(&named(prefix, "friction"))?.into())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        writeln!(
            f,
            "{:>11} {:>11} {:>10} {:>11} {:>9} {:>11} {:>11} {:>11} {:>6} {:>6} {:>9}",
            "velocity",
            "pressure",
            "p*",
            "approach",
            "area",
            "friction",
            "by slopes",
            "Persson",
            "steps",
            "pairs",
            "residual"
        )?;
        for state in &self.states {
            let worst = state.worst();
            writeln!(
                f,
                "{:>11.4e} {:>11.4e} {:>10.4e} {:>11.4e} {:>9.6} {:>11.4e} {:>11.4e} {:>11.4e} {:>6} {:>6} {:>9.1e}{}",
                state.velocity,
                state.mean_pressure,
                state.p_star,
                state.displacement,
                state.area_fraction,
                state.friction,
                state.friction_slope,
                state.persson.friction,
                state.iterations,
                state.transform_pairs,
                worst,
                if state.converged { "" } else { "  NOT CONVERGED" }
            )?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
