//! Stiffness of a state along a path.

use std::sync::Arc;

use gfmd_contact::{Fields as _, GradientError, Hardness, Load, Refusal, Stiffness, Units};
use gfmd_medium::Stiffening;
use gfmd_relax::Why;
use gfmd_response::FullResponse;
use ndarray::{Array2, ArrayRef2, Axis, Zip};

use super::normal::Normal;
use super::response::Response;
use super::stuck::Stuck;
use super::{QuasistaticContact, QuasistaticState, Sequence};
use crate::newton::Sides;
use crate::{Interface, State};

/// Relative rounding error of the pressure of points at the hardness.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Reasons why a state along a path has no stiffness, or an inexact one.
#[derive(Debug, thiserror::Error)]
pub enum StiffnessError {
    /// The law shears the surfaces, and the fields do not tell their lateral displacement.
    #[error("not computed from the pressure and the gap alone: the law shears the surfaces")]
    Lateral,
    /// The fields alone do not determine the state.
    #[error("the fields do not determine the state")]
    Fields,
    /// The state is of another kind of contact.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The law gives no stiffness.
    #[error(transparent)]
    Law(#[from] GradientError),
    /// The stiffness reached is less exact than requested.
    #[error("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error)]
    Inexact {
        /// Stiffness reached.
        reached: Stiffness,
        /// Reason why the iterations ended.
        why: Why,
    },
}

impl QuasistaticContact {
    /// Computes the stiffness of `state`, d(mean pressure)/d(approach) in stress/length, to the relative error
    /// `tolerance` ([`Stiffness`]). Of a load it is the stiffness of the [wall](gfmd_contact::Contact::stiffness) or of
    /// the [law](crate::Interface::stiffness). Along a path it is the stiffness of an instant, in which nothing wears
    /// off and a body that relaxes has its instantaneous moduli. Points in contact stay in contact, with friction or a
    /// shear strength without slip, and points at the hardness keep their pressure: where some are, it is the stiffness
    /// under a growing load, and the contact is stiffer when it is unloaded. The surfaces do not move sideways.
    ///
    /// # Errors
    /// Returns the reason why there is no stiffness, or the stiffness reached with a larger error.
    pub fn stiffness(&self, state: &QuasistaticState, tolerance: f64) -> Result<Stiffness, StiffnessError> {
        if self.sequence == Sequence::Loads {
            return self.stiffness_of_load(state, tolerance);
        }
        let fields = (&*state.pressure(), &*state.gap());
        self.stiffness_of(fields, state.law(), tolerance)
    }

    /// Computes the stiffness of the state with these stored fields, as [`stiffness`](Self::stiffness), also where they
    /// do not determine the state: of a body with a memory.
    ///
    /// # Errors
    /// Returns an error as [`stiffness`](Self::stiffness), for fields that do not fit the grid, and under loads.
    pub fn stiffness_of_fields(
        &self,
        pressure: &ArrayRef2<f64>,
        gap: &ArrayRef2<f64>,
        tolerance: f64,
    ) -> Result<Stiffness, StiffnessError> {
        if self.sequence == Sequence::Loads {
            return Err(StiffnessError::Fields);
        }
        self.stiffness_of((pressure, gap), None, tolerance)
    }

    /// Computes the stiffness from the pressure, the gap, and the state beside a `law`, whose wall follows by default
    /// from the other two.
    fn stiffness_of(
        &self,
        (pressure, gap): (&ArrayRef2<f64>, &ArrayRef2<f64>),
        law: Option<&State>,
        tolerance: f64,
    ) -> Result<Stiffness, StiffnessError> {
        let shape = self.normal.surface().shape();
        let wrong = [pressure, gap].into_iter().find(|field| <[usize; 2]>::from(field.dim()) != shape);
        if let Some(found) = self.share().first(wrong.map(|field| field.len())) {
            return Err(Refusal::Start { found, expected: self.points() }.into());
        }
        let (length, stress) = (self.units.length(), self.units.stress());
        let (pressure, gap) = (pressure.mapv(|p| p / stress), gap.mapv(|gap| gap / length));
        let stiffening = match &self.medium {
            Some(medium) => medium.begin(&medium.rest(), 0.0)?.stiffening,
            None => Stiffening::All(1.0),
        };
        let of_law = |interface: &Interface| match law {
            Some(state) => state.wall_pressure.mapv(|p| p / stress),
            None => Zip::from(&pressure).and(&gap).map_collect(|p, gap| interface.wall_pressure(*p, *gap)),
        };
        if let Some(response) = &self.response {
            let Stiffening::All(factor) = stiffening else { return Err(Refusal::OtherKind.into()) };
            let (interface, wall_pressure, gap) = match (&self.normal, response) {
                (Normal::Law(interface), Response::Periodic(response)) => {
                    (interface.in_components_of(response), of_law(interface), gap)
                }
                (Normal::Law(interface), Response::Free(response)) => {
                    let cell = response.cell(self.share()).map_err(Refusal::from)?;
                    (interface.in_components_of_cell(cell), of_law(interface), gap)
                }
                (Normal::Wall(_), Response::Periodic(response)) => {
                    let closed = Zip::from(&pressure).and(&gap).map_collect(|p, gap| if *p > 0.0 { 0.0 } else { *gap });
                    (self.wall_in_all_components(response)?, pressure, closed)
                }
                (Normal::Wall(_), Response::Free(_)) => {
                    return self.stiffness_of_stuck(response, pressure, factor, tolerance);
                }
            };
            let interface = interface.weakened(factor);
            let blank = interface.blank(Load::MeanPressure(0.0).into())?;
            let state = State { gap, wall_pressure, approach: 0.0, ..blank };
            let state = state.times(1.0, 1.0 / factor);
            let found = interface.stiffness_in_all_components(&state, Sides::Stick, tolerance)?;
            return judged(self.given_stiffness(found, factor), tolerance);
        }
        match &self.normal {
            Normal::Law(interface) => {
                let wall_pressure = of_law(interface);
                // The stiffness depends on the gap, whatever the heights are to which the surfaces are worn.
                let blank = interface.blank(Load::MeanPressure(0.0).into())?;
                let (displacement, lateral) = match law {
                    Some(state) => (state.displacement.mapv(|u| u / length), state.lateral.map(|u| u / length)),
                    None if self.all_components => return Err(StiffnessError::Lateral),
                    None => (blank.displacement, blank.lateral),
                };
                let mut traction = blank.traction;
                let z = traction.len_of(Axis(0)) - 1;
                traction.index_axis_mut(Axis(0), z).assign(&-pressure);
                let state = State { displacement, lateral, traction, gap, wall_pressure, approach: 0.0, ..blank };
                let interface = match &self.sideways[..] {
                    [] => interface.clone(),
                    base => interface.displaced_sideways(base)?,
                };
                let (factor, interface) = match &stiffening {
                    Stiffening::All(1.0) => (1.0, interface),
                    Stiffening::All(factor) => (*factor, interface.weakened(*factor)),
                    Stiffening::Waves(factors) => (1.0, interface.stiffened(factors)?),
                };
                let found = interface.stiffness(&state.times(1.0, 1.0 / factor), tolerance)?;
                let found = self.given_stiffness(found, factor);
                if self.all_components { judged(found, tolerance) } else { Ok(found) }
            }
            Normal::Wall(contact) => {
                let pressure = self.with_hardness_exact(pressure);
                // If all waves stiffen alike, the points that touch and those at the hardness tell all.
                let (factor, found) = match &stiffening {
                    Stiffening::All(factor) => (*factor, contact.stiffness_of_pressure(&pressure, tolerance)),
                    Stiffening::Waves(factors) => {
                        (1.0, contact.stiffened(factors).stiffness_of_pressure(&pressure, tolerance))
                    }
                };
                found.map(|found| self.given_stiffness(found, factor)).map_err(|(reached, why)| {
                    StiffnessError::Inexact { reached: self.given_stiffness(reached, factor), why }
                })
            }
        }
    }

    /// Computes the stiffness of a patch with a hard wall whose points in contact stick.
    fn stiffness_of_stuck(
        &self,
        response: &Response,
        pressure: Array2<f64>,
        factor: f64,
        tolerance: f64,
    ) -> Result<Stiffness, StiffnessError> {
        let (pressure, lateral) = (self.with_hardness_exact(pressure), response.components().normal());
        let touches = pressure.iter().map(|p| f64::from(*p > 0.0));
        let mut held: Vec<f64> = std::iter::repeat_n(touches, lateral).flatten().collect();
        let open = pressure.indexed_iter().map(|(at, p)| *p > 0.0 && self.hardness_at(at).is_none_or(|most| *p < most));
        held.extend(open.map(f64::from));
        let found = Stuck { response, share: self.share(), held }.stiffness(tolerance);
        let given = |found| self.given_stiffness(found, factor);
        found.map(given).map_err(|(reached, why)| StiffnessError::Inexact { reached: given(reached), why })
    }

    /// Returns the hardness of a point, if there is one.
    fn hardness_at(&self, at: (usize, usize)) -> Option<f64> {
        Some(match self.hardness.as_ref()? {
            Hardness::Uniform(hardness) => *hardness,
            Hardness::Field(field) => field[at],
        })
    }

    /// Returns the hard wall as an interface in the components of `response`.
    fn wall_in_all_components(&self, response: &Arc<FullResponse>) -> Result<Interface, Refusal> {
        let wall = Interface::at_wall(Arc::clone(response), Arc::clone(&self.scaled));
        let hardness = self.hardness.clone().map(|hardness| hardness.in_units(&self.scaled, &Units::ONE));
        Ok(Interface { hardness: hardness.transpose()?, ..wall })
    }

    /// Returns the pressure with exactly the hardness at the points that have it up to rounding.
    fn with_hardness_exact(&self, mut pressure: Array2<f64>) -> Array2<f64> {
        for (at, p) in pressure.indexed_iter_mut() {
            if let Some(hardness) = self.hardness_at(at).filter(|hardness| *p >= (1.0 - ROUNDING) * hardness) {
                *p = hardness;
            }
        }
        pressure
    }

    /// Returns a stiffness in the units of the input, of a body that is stiffer by `factor`.
    fn given_stiffness(&self, found: Stiffness, factor: f64) -> Stiffness {
        Stiffness { value: factor * found.value * self.units.stress() / self.units.length(), ..found }
    }
}

/// Returns the stiffness found, or an error if it is less exact than the tolerance.
fn judged(found: Stiffness, tolerance: f64) -> Result<Stiffness, StiffnessError> {
    if found.error <= tolerance {
        Ok(found)
    } else {
        Err(StiffnessError::Inexact { reached: found, why: Why::Rounding })
    }
}
