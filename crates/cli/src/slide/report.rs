//! The printed report of steady sliding, and its figures.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use gfmd_contact::Fields as _;
use gfmd_files::contiguous;
use gfmd_measure::Scales;
use gfmd_report::figures::{Scene, Shown, named};
use gfmd_report::slide::{Sliding, chart, rises, temperature};
use gfmd_run::failure::Failure;
use gfmd_run::series::Head;
use gfmd_run::source::Surface;
use gfmd_viscoelastic::Velocity;
use serde::{Deserialize, Serialize};

use super::heat::Heat;
use super::reached::Reached;
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
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heat: Option<Heat>,
    pub iterations: u64,
    pub transform_pairs: f64,
    pub converged: bool,
    pub residual: BTreeMap<String, f64>,
    pub seconds: f64,
}

/// Persson's theory, as printed.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Persson {
    /// Coefficient of friction.
    pub friction: f64,
    /// Contact area over the whole area.
    pub area_fraction: f64,
}

impl State {
    pub(super) fn new(
        velocity: &Velocity,
        Reached { state, heated }: &Reached,
        gfmd_viscoelastic::Persson { friction, area_fraction }: gfmd_viscoelastic::Persson,
        (scales, tolerance): (&Scales, f64),
        seconds: f64,
    ) -> Self {
        let summary = state.summary_in(scales);
        let effort = state.effort();
        let [iterations, pairs] =
            heated.as_ref().map_or([0.0; 2], |heated| [heated.iterations as f64, heated.transform_pairs]);
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
            heat: heated.as_ref().map(Heat::from),
            iterations: effort.iterations + iterations as u64,
            transform_pairs: effort.transform_pairs + pairs,
            converged: state.worst() <= tolerance && heated.as_ref().is_none_or(|heated| heated.residual <= tolerance),
            residual: state.residuals().into_iter().map(|(name, residual)| (name.to_owned(), residual)).collect(),
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
    /// Draws the states, of so many `velocities` for each load, against the velocity, and the fields of the last one.
    pub(super) fn draw(
        &self,
        prefix: &Path,
        (velocities, is_viscoelastic): (usize, bool),
        (surface, last): (&Surface, &Reached),
    ) -> Result<Vec<PathBuf>, Failure> {
        let state = |state: &State| Sliding {
            velocity: state.velocity,
            p_star: state.p_star,
            friction: [state.friction, state.persson.friction],
            area: [state.area_fraction, state.persson.area_fraction],
            rise: state.heat.map_or([f64::NAN; 2], |heat| [heat.max_rise, heat.mean_rise]),
        };
        let states: Vec<Sliding> = self.states.iter().map(state).collect();
        let mut files = Vec::new();
        if is_viscoelastic {
            files.extend(chart(&states, velocities, &surface.units()).save(&named(prefix, "friction"))?);
        }
        if let Some(heated) = &last.heated {
            files.extend(rises(&states, velocities, &surface.units()).save(&named(prefix, "rise"))?);
            let values = contiguous(&heated.temperature);
            let map = temperature(&surface.grid, &values, surface.unit(), &surface.units());
            files.extend(map.save(&named(prefix, "temperature"))?);
        }
        let shown = Shown::of(&last.state, None, None);
        files.extend(Scene::upper(surface, &shown, self.head.e_star, None).draw(prefix)?);
        Ok(files)
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
        if self.states.iter().any(|state| state.heat.is_some()) {
            writeln!(
                f,
                "\n{:>11} {:>11} {:>11} {:>11} {:>9}",
                "velocity", "heat", "max rise", "mean rise", "into body"
            )?;
        }
        for (state, heat) in self.states.iter().filter_map(|state| Some((state, state.heat?))) {
            writeln!(
                f,
                "{:>11.4e} {:>11.4e} {:>11.4e} {:>11.4e} {:>9.6}",
                state.velocity, heat.mean_flux, heat.max_rise, heat.mean_rise, heat.fraction
            )?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
