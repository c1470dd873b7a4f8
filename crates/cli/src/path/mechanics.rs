//! The two kinds of problem behind one face.

use gfmd_interface::{Drive, FrictionState, FrictionalContact, Interface, InterfaceError, Settings, State};
use ndarray::{Array2, ArrayView2, Axis};

use super::{ResidualRecord, StepRecord};
use crate::failure::Failure;

/// A problem with its last state.
pub(super) enum Mechanics<'a> {
    Law(Interface<'a>, Option<State>),
    Friction(FrictionalContact<'a>, Option<FrictionState>),
}

/// How a step ended.
pub(super) enum End {
    Rest,
    Parted,
    Failed(Failure),
}

impl Mechanics<'_> {
    pub(super) fn check(&self, drive: Drive) -> Result<(), Failure> {
        let checked = match self {
            Self::Law(interface, _) => interface.check(drive),
            Self::Friction(contact, _) => contact.check(drive),
        };
        checked.map_err(|error| Failure::input("--displacement", error))
    }

    pub(super) fn step(
        &mut self,
        drive: Drive,
        settings: &Settings,
        watch: gfmd_interface::Watch,
    ) -> Result<End, Failure> {
        let interrupted = || End::Failed(Failure::Interrupted("interrupted".into()));
        let error = match self {
            Self::Law(interface, state) => match interface.solve(drive, settings, state.as_ref(), watch) {
                Ok(next) => {
                    *state = Some(next);
                    return Ok(End::Rest);
                }
                Err(error) => error,
            },
            Self::Friction(contact, state) => match contact.solve(drive, settings, state.as_ref(), watch) {
                Ok(next) => {
                    *state = Some(next);
                    return Ok(End::Rest);
                }
                Err(error) => error,
            },
        };
        let text = error.to_string();
        match (error, self) {
            (InterfaceError::Detached { state: next, .. }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(End::Parted)
            }
            (InterfaceError::NotConverged { state: next, .. }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(End::Failed(Failure::Computation(text)))
            }
            (InterfaceError::FrictionNotConverged { state: next, .. }, Self::Friction(_, state)) => {
                *state = Some(*next);
                Ok(End::Failed(Failure::Computation(text)))
            }
            (InterfaceError::Interrupted { state: next }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(interrupted())
            }
            (InterfaceError::FrictionInterrupted { state: next }, Self::Friction(_, state)) => {
                *state = Some(*next);
                Ok(interrupted())
            }
            _ => Err(Failure::Computation(text)),
        }
    }

    /// The scalars of the last state; `before` is the step that led to it.
    pub(super) fn record(&self, before: Option<&StepRecord>, tolerance: f64) -> Option<StepRecord> {
        Some(match self {
            Self::Law(_, state) => {
                let state = state.as_ref()?;
                let gfmd_interface::Residual { equilibrium, penetration, wall_tension, load } = state.residual;
                // Work of the rigid surface, by trapezoids, less what is stored.
                let dissipated = before.map_or(0.0, |before| {
                    let pushed =
                        0.5 * (before.mean_pressure + state.mean_pressure) * (state.approach - before.displacement);
                    let dragged: f64 = (0..2)
                        .map(|c| {
                            0.5 * (before.mean_shear[c] + state.mean_shear[c]) * (state.lateral[c] - before.lateral[c])
                        })
                        .sum();
                    let stored =
                        state.elastic_energy + state.interface_energy - before.elastic_energy - before.interface_energy;
                    pushed + dragged - stored
                });
                StepRecord {
                    mean_pressure: state.mean_pressure,
                    p_star: f64::NAN,
                    displacement: state.approach,
                    lateral: state.lateral,
                    mean_shear: state.mean_shear,
                    area_fraction: state.contact_fraction,
                    stick_fraction: f64::NAN,
                    mean_gap: state.gap.mean().unwrap_or(f64::NAN),
                    elastic_energy: state.elastic_energy,
                    interface_energy: state.interface_energy,
                    dissipated,
                    passed_instability: state.passed_instability,
                    lowest_curvature: state.lowest_curvature,
                    iterations: state.iterations,
                    transform_pairs: state.transform_pairs,
                    converged: state.residual.worst() <= tolerance,
                    residual: ResidualRecord::Law { equilibrium, penetration, wall_tension, load },
                    seconds: f64::NAN,
                }
            }
            Self::Friction(_, state) => {
                let state = state.as_ref()?;
                let gfmd_interface::FrictionResidual { complementarity, penetration, load, friction, excess } =
                    state.residual;
                StepRecord {
                    mean_pressure: state.mean_pressure,
                    p_star: f64::NAN,
                    displacement: state.approach,
                    lateral: state.lateral,
                    mean_shear: state.mean_shear,
                    area_fraction: state.contact_fraction,
                    stick_fraction: state.stick_fraction,
                    mean_gap: state.gap.mean().unwrap_or(f64::NAN),
                    elastic_energy: state.elastic_energy,
                    interface_energy: f64::NAN,
                    dissipated: state.dissipated,
                    passed_instability: false,
                    lowest_curvature: f64::NAN,
                    iterations: state.iterations,
                    transform_pairs: state.transform_pairs,
                    converged: state.residual.worst() <= tolerance,
                    residual: ResidualRecord::Friction { complementarity, penetration, load, friction, excess },
                    seconds: f64::NAN,
                }
            }
        })
    }

    /// Tractions on the elastic surface, component by component, and the gap.
    pub(super) fn fields(&self) -> Option<(Vec<ArrayView2<'_, f64>>, ArrayView2<'_, f64>)> {
        let (traction, gap) = match self {
            Self::Law(_, state) => state.as_ref().map(|state| (&state.traction, &state.gap))?,
            Self::Friction(_, state) => state.as_ref().map(|state| (&state.traction, &state.gap))?,
        };
        Some((traction.axis_iter(Axis(0)).collect(), gap.view()))
    }

    pub(super) fn pressure(&self) -> Array2<f64> {
        self.fields().and_then(|(tractions, _)| tractions.last().map(|t| t.mapv(|t| -t))).unwrap_or_default()
    }
}
