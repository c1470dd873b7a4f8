//! The printed report of steady sliding, and its figures.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use gfmd_contact::Fields as _;
use gfmd_files::contiguous;
use gfmd_measure::Scales;
use gfmd_record::{ROUGH, aligned, significant, with_limit};
use gfmd_relax::worst;
use gfmd_report::figures::{Scene, Shown, named};
use gfmd_report::slide::{Sliding, chart, rises, temperature};
use gfmd_run::failure::Failure;
use gfmd_run::series::Head;
use gfmd_run::source::Surface;
use gfmd_unit::Units;
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
        worst(self.residual.values().copied())
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

/// A column of a table: head, kind of quantity (or `count`, `rough`), number. A head that ends in `~` has numbers with
/// an error by the grid that is not known; it is written without the sign.
type Column<T> = (&'static str, &'static str, fn(&T) -> f64);

/// The columns of the states.
const STATES: [Column<State>; 11] = [
    ("velocity", "length/time", |state| state.velocity),
    ("pressure", "stress", |state| state.mean_pressure),
    ("p*", "1", |state| state.p_star),
    ("approach", "length", |state| state.displacement),
    ("area~", "1", |state| state.area_fraction),
    ("friction~", "1", |state| state.friction),
    ("by slopes~", "1", |state| state.friction_slope),
    ("Persson", "1", |state| state.persson.friction),
    ("steps", "count", |state| state.iterations as f64),
    ("pairs", "count", |state| state.transform_pairs),
    ("residual", "rough", State::worst),
];

/// The columns of the flash temperature, of a velocity and its heat.
const HEAT: [Column<(f64, Heat)>; 5] = [
    ("velocity", "length/time", |(velocity, _)| *velocity),
    ("heat", "stress*length/time", |(_, heat)| heat.mean_flux),
    ("max rise~", "temperature", |(_, heat)| heat.max_rise),
    ("mean rise~", "temperature", |(_, heat)| heat.mean_rise),
    ("into body~", "1", |(_, heat)| heat.fraction),
];

/// The lines of a table, in readable units where those of the problem are known.
fn table<T>(rows: &[T], columns: &[Column<T>], units: &Units, width: Option<usize>) -> Vec<String> {
    let column = |(head, kind, of): &Column<T>| {
        let largest = rows.iter().map(of).map(f64::abs).filter(|size| size.is_finite()).fold(0.0, f64::max);
        let unit = units.shown(kind, largest);
        let (head, is_rough) = head.strip_suffix('~').map_or((*head, false), |head| (head, true));
        let cell = |value: f64| match (&unit, *kind) {
            _ if is_rough => with_limit(value * unit.as_ref().map_or(1.0, |unit| unit.factor), f64::NAN, f64::NAN),
            (_, "count") => format!("{value:.0}"),
            (_, "rough") => format!("{value:.1e}"),
            (Some(unit), _) => significant(value * unit.factor),
            (None, _) => format!("{value:.4e}"),
        };
        let head = unit.as_ref().map_or_else(|| head.to_owned(), |unit| format!("{head} / {}", unit.divisor()));
        std::iter::once(head).chain(rows.iter().map(of).map(cell)).collect()
    };
    aligned(columns.iter().map(column).collect(), width)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        let units = self.head.units();
        let mut lines = table(&self.states, &STATES, &units, f.width());
        for (line, state) in lines.iter_mut().skip(1).zip(&self.states) {
            *line += if state.converged { "" } else { "  NOT CONVERGED" };
        }
        let heated: Vec<(f64, Heat)> =
            self.states.iter().filter_map(|state| Some((state.velocity, state.heat?))).collect();
        if !heated.is_empty() {
            lines.push(String::new());
            lines.extend(table(&heated, &HEAT, &units, f.width()));
        }
        lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
        writeln!(f, "{ROUGH}; compare with a grid of half the spacing")?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
