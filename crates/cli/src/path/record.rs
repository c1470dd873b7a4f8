//! The numbers of one step.

use gfmd_contact::{Fields as _, Residual};
use gfmd_interface::{FrictionResidual, Loss, Reading, Step};
use gfmd_measure::{Scales, Summary};
use gfmd_problem::Rest;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::load::{NO_LEVEL, Undefined, WITHOUT_LEVEL};

/// One step of a path.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`SCALARS` has the meanings, once for code and files")]
pub struct StepRecord {
    pub mean_pressure: f64,
    pub p_star: f64,
    pub displacement: f64,
    pub lateral: [f64; 2],
    pub mean_shear: [f64; 2],
    pub area_fraction: f64,
    pub stick_fraction: Option<f64>,
    pub mean_gap: f64,
    pub elastic_energy: f64,
    pub interface_energy: Option<f64>,
    /// With a hardness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plastic_fraction: Option<f64>,
    /// With a hardness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plastic_volume: Option<f64>,
    pub dissipated: Option<f64>,
    pub dissipated_error: Option<f64>,
    pub passed_instability: Option<bool>,
    pub lowest_curvature: f64,
    pub extra_solves: u64,
    /// With friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub increments: Option<u64>,
    pub iterations: u64,
    pub transform_pairs: u64,
    pub converged: bool,
    pub residual: ResidualRecord,
    pub seconds: f64,
    /// The reasons why columns have no value.
    #[serde(default, skip_serializing_if = "Undefined::is_empty")]
    pub undefined: Undefined,
}

impl StepRecord {
    /// The record without the numbers that depend on the level of the displacement, which a surface without one does not have.
    pub(super) fn without_level(mut self) -> Self {
        (self.displacement, self.elastic_energy) = (f64::NAN, f64::NAN);
        WITHOUT_LEVEL.iter().for_each(|name| self.undefined.insert(name, NO_LEVEL));
        self
    }

    /// The record as TOML, which holds every number to the last bit, and NaN.
    pub(super) fn to_toml(&self) -> Result<String, Failure> {
        let table = toml::Table::try_from(self);
        table.map(|table| table.to_string()).map_err(|error| Failure::Computation(error.to_string()))
    }

    /// The numbers of a state, in units of `scales`, and of the step that led to it; the caller adds the time.
    pub(super) fn of(state: &Rest, scales: &Scales, reading: &Reading, step: &Step, tolerance: f64) -> Self {
        let summary = state.summary_in(scales);
        let new = |residual| Self::new(&summary, reading, step, residual, tolerance);
        if let Some(law) = state.law() {
            let gfmd_interface::Residual { equilibrium, penetration, wall_tension, load, .. } = law.residual;
            return Self {
                // Where no point touches the wall, rounding errors of the traction would count in the summary.
                area_fraction: law.contact_fraction,
                interface_energy: Some(law.interface_energy).filter(|energy| !energy.is_nan()),
                lowest_curvature: law.lowest_curvature,
                ..new(ResidualRecord::Law { equilibrium, penetration, wall_tension, load })
            };
        }
        if let Some(friction) = state.friction() {
            let FrictionResidual { complementarity, penetration, load, friction: shear, excess } = friction.residual;
            return Self {
                stick_fraction: Some(friction.stick_fraction),
                increments: Some(step.increments),
                ..new(ResidualRecord::Friction { complementarity, penetration, load, friction: shear, excess })
            };
        }
        let on_path = state.on_path();
        let solution = on_path.map(|state| &state.solution);
        let plastic = solution.and_then(|solution| solution.plastic.as_ref());
        let nothing =
            Residual { complementarity: f64::NAN, penetration: f64::NAN, negative_pressure: f64::NAN, load: f64::NAN };
        let Residual { complementarity, penetration, negative_pressure, load } =
            solution.map_or(nothing, |solution| solution.residual);
        let saturation = plastic.map(|plastic| plastic.saturation);
        Self {
            plastic_fraction: plastic.and(on_path).map(|state| state.fraction),
            plastic_volume: plastic.and(on_path).map(|state| state.volume),
            ..new(ResidualRecord::Wall { complementarity, penetration, negative_pressure, load, saturation })
        }
    }

    /// Makes a record with the numbers that all states have, by the sums that `contact` prints; all other numbers are NaN or `None`.
    fn new(summary: &Summary, reading: &Reading, step: &Step, residual: ResidualRecord, tolerance: f64) -> Self {
        Self {
            mean_pressure: summary.mean_pressure,
            p_star: summary.p_star,
            displacement: reading.approach,
            lateral: reading.lateral,
            mean_shear: reading.mean_shear,
            area_fraction: summary.area_fraction,
            stick_fraction: None,
            mean_gap: summary.mean_gap,
            elastic_energy: summary.elastic_energy,
            interface_energy: None,
            plastic_fraction: None,
            plastic_volume: None,
            dissipated: step.dissipated,
            dissipated_error: step.dissipated_error,
            passed_instability: step.jumped,
            lowest_curvature: f64::NAN,
            extra_solves: step.extra_solves,
            increments: None,
            iterations: step.effort.iterations,
            transform_pairs: step.effort.transform_pairs as u64,
            converged: residual.worst() <= tolerance,
            residual,
            seconds: f64::NAN,
            undefined: undefined(reading, step),
        }
    }
}

/// The reasons why numbers of a step are not known.
fn undefined(reading: &Reading, step: &Step) -> Undefined {
    let mut undefined = Undefined::default();
    if step.jumped.is_none() {
        let reason = match reading.loss {
            Loss::Balance(_) => "--energy-solves did not suffice to tell a jump from a smooth change",
            Loss::Known(_) => "energy is lost by slip or plastic flow, which no balance tells from jumps",
            Loss::Unknown => "the tractions have no energy, whose loss would tell a jump",
        };
        undefined.insert("passed_instability", reason);
    }
    if step.change.is_some_and(f64::is_nan) {
        undefined.insert("dissipated_error", "--energy-solves did not suffice to halve the increment");
    }
    undefined
}

/// The residuals of a step, recomputed from its final fields.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub enum ResidualRecord {
    Law {
        equilibrium: f64,
        penetration: f64,
        wall_tension: f64,
        load: f64,
    },
    Friction {
        complementarity: f64,
        penetration: f64,
        load: f64,
        friction: f64,
        excess: f64,
    },
    Wall {
        complementarity: f64,
        penetration: f64,
        negative_pressure: f64,
        load: f64,
        /// With a hardness.
        #[serde(skip_serializing_if = "Option::is_none")]
        saturation: Option<f64>,
    },
}

impl ResidualRecord {
    /// The largest of the residuals.
    pub fn worst(&self) -> f64 {
        match *self {
            // The complementarity of a state with a law is left out, since it is never larger than the penetration.
            Self::Law { equilibrium, penetration, wall_tension, load } => {
                gfmd_relax::worst([equilibrium, penetration, wall_tension, load])
            }
            Self::Friction { complementarity, penetration, load, friction, excess } => {
                gfmd_relax::worst([complementarity, penetration, load, friction, excess])
            }
            Self::Wall { complementarity, penetration, negative_pressure, load, saturation } => {
                let saturation = saturation.unwrap_or(0.0);
                gfmd_relax::worst([complementarity, penetration, negative_pressure, load, saturation])
            }
        }
    }
}

/// A number of a step in a file.
pub(super) struct Scalar {
    pub(super) name: &'static str,
    pub(super) units: &'static str,
    pub(super) long_name: &'static str,
    pub(super) value: fn(&StepRecord) -> f64,
}

const fn scalar(
    name: &'static str,
    units: &'static str,
    long_name: &'static str,
    value: fn(&StepRecord) -> f64,
) -> Scalar {
    Scalar { name, units, long_name, value }
}

/// The scalars of a file.
pub(super) fn scalars(is_plastic: bool, has_friction: bool) -> impl Iterator<Item = &'static Scalar> {
    let plastic = PLASTIC.iter().filter(move |_| is_plastic);
    SCALARS.iter().chain(plastic).chain(FRICTION.iter().filter(move |_| has_friction))
}

/// The scalars of a path with friction.
const FRICTION: &[Scalar] =
    &[scalar("increments", "1", "equal increments in which the step was made until they changed nothing", |r| {
        r.increments.map_or(f64::NAN, |increments| increments as f64)
    })];

/// The scalars of a path with a hardness.
const PLASTIC: &[Scalar] = &[
    scalar("plastic_fraction", "1", "points whose pressure is the hardness, to its accuracy, over all points", |r| {
        r.plastic_fraction.unwrap_or(f64::NAN)
    }),
    scalar("plastic_volume", "length", "mean plastic depth so far", |r| r.plastic_volume.unwrap_or(f64::NAN)),
];

const SCALARS: &[Scalar] = &[
    scalar("mean_pressure", "stress", "mean pressure over the whole surface; negative if it is pulled", |r| {
        r.mean_pressure
    }),
    scalar("p_star", "1", "reduced pressure p/(E* g)", |r| r.p_star),
    scalar("displacement", "length", "rigid approach beyond first touch", |r| r.displacement),
    scalar("lateral_x", "length", "lateral displacement of the rigid surface along x", |r| r.lateral[0]),
    scalar("lateral_y", "length", "lateral displacement of the rigid surface along y", |r| r.lateral[1]),
    scalar("mean_shear_x", "stress", "mean shear traction on the elastic surface along x", |r| r.mean_shear[0]),
    scalar("mean_shear_y", "stress", "mean shear traction on the elastic surface along y", |r| r.mean_shear[1]),
    scalar("area_fraction", "1", "points that are repelled over all points", |r| r.area_fraction),
    scalar(
        "stick_fraction",
        "1",
        "points in contact whose shear is below its limit, over all points; NaN without friction",
        |r| r.stick_fraction.unwrap_or(f64::NAN),
    ),
    scalar("mean_gap", "length", "mean distance between the surfaces", |r| r.mean_gap),
    scalar("elastic_energy", "stress*length", "elastic energy per area of the surface", |r| r.elastic_energy),
    scalar("interface_energy", "stress*length", "energy of the law per area of the surface; NaN if it has none", |r| {
        r.interface_energy.unwrap_or(f64::NAN)
    }),
    scalar("dissipated", "stress*length", "energy lost in this step, per area; NaN if the law has no energy", |r| {
        r.dissipated.unwrap_or(f64::NAN)
    }),
    scalar(
        "dissipated_error",
        "stress*length",
        "estimated error of dissipated; NaN if dissipated does not depend on the division of the step, or is unknown",
        |r| r.dissipated_error.unwrap_or(f64::NAN),
    ),
    scalar(
        "passed_instability",
        "1",
        "1 if more energy was lost in a jump of this step than its error; NaN if no energy tells",
        |r| r.passed_instability.map_or(f64::NAN, |passed| f64::from(u8::from(passed))),
    ),
    scalar(
        "lowest_curvature",
        "1",
        "lowest curvature met in the last search for a step, over the elastic curvature",
        |r| r.lowest_curvature,
    ),
    scalar("extra_solves", "1", "further solves to find the energy lost in the step", |r| r.extra_solves as f64),
    scalar("iterations", "1", "steps of the solver, extra solves included", |r| r.iterations as f64),
    scalar(
        "transform_pairs",
        "1",
        "forward and inverse transforms of one component, in pairs, extra solves included",
        |r| r.transform_pairs as f64,
    ),
    scalar("converged", "1", "1 if all residuals are at most the tolerance", |r| f64::from(u8::from(r.converged))),
    scalar("residual", "1", "largest residual, from the final fields", |r| r.residual.worst()),
];
