//! Conductance of the points in contact, measured by `--statistics` for each state.

use std::sync::OnceLock;

use gfmd_contact::Solver;
use gfmd_contact::{Boundary, Conductance, ConductanceError, Conductors};
use gfmd_field::Grid;
use gfmd_green::{Body, Conductor, Height};
use gfmd_problem::{Facts, Unknown, key, words};
use ndarray::{ArrayRef, Ix2};

use super::MeasureArgs;
use gfmd_input::failure::Failure;
use gfmd_run::series::Prepared;

/// Source of the conductance of the states of a contact.
pub(crate) struct Conducting {
    method: ConductanceMethod,
    boundary: Boundary,
    grid: Grid,
    height: Height,
    /// Created on first use.
    conductors: OnceLock<Conductors>,
}

/// Method for the conductance.
enum ConductanceMethod {
    /// From the stiffness of the same points, times this factor: their resistance is proportional to the compliance.
    OfStiffness(f64),
    /// By a separate solve.
    Solved,
    /// Undefined, with the reason.
    Undefined(&'static str),
}

/// Reason why a state that did not converge has no conductance.
const NOT_CONVERGED: &str = "the search did not converge";

/// Reason why full contact has no conductance.
const ALL_TOUCH: &str = "all points touch, so that only the bulk has a resistance";

impl Conducting {
    /// Creates the source of the conductance for these options of a problem that the `solver` solves.
    ///
    /// # Errors
    /// Returns an error if the electrode depth is invalid or given without `--statistics`.
    pub(crate) fn new(args: &MeasureArgs, prepared: &Prepared, solver: Solver) -> Result<Self, Failure> {
        let Prepared { facts, surface, body, .. } = prepared;
        let (height, grid, boundary) = (args.conductor_height, &surface.grid, surface.boundary);
        if let (Height::Finite(height), false) = (height, args.statistics) {
            return Err(Failure::value(
                key("conductor_height"),
                height,
                words!["left out without ", key("statistics")],
            ));
        }
        let refuse = |error: &dyn std::fmt::Display| Failure::input(key("conductor_height"), error);
        Conductor::new(height).map_err(|error| refuse(&error))?;
        let is_endless = |body: &Body| body.height() == Height::Infinite;
        let are_alike = is_elastic_wall(facts)
            && !facts.moves_all_by(solver)
            && body.tabulated_wavenumbers().is_none()
            && [height, body.height()] == [Height::Infinite; 2]
            && body.second().is_none_or(is_endless);
        let method = if facts.finite_slope {
            ConductanceMethod::Undefined("with finite slopes the points in contact have moved sideways")
        } else if boundary == Boundary::Free && grid.is_line() && height == Height::Infinite {
            ConductanceMethod::Undefined(
                "below a profile with free boundaries the potential of half-spaces is known up to a constant; \
                 electrodes (--conductor-height) fix it",
            )
        } else if are_alike {
            ConductanceMethod::OfStiffness(2.0 / body.contact_modulus())
        } else {
            ConductanceMethod::Solved
        };
        let conducting = Self { method, boundary, grid: *grid, height, conductors: OnceLock::new() };
        if let (true, ConductanceMethod::Solved, Boundary::Free, Height::Finite(_)) =
            (args.statistics, &conducting.method, boundary, height)
        {
            // Refuse an electrode that is not deep enough before the first load.
            conducting.conductors().map_err(|error| refuse(&error))?;
        }
        Ok(conducting)
    }

    /// Measures the conductance of the repelled points of a state. `converged` and `stiffness` describe the state.
    /// Returns the conductance, or the reason why there is none, and a warning if it is not exact.
    ///
    /// # Errors
    /// Returns an error if the conductance cannot be computed.
    pub(crate) fn measure(
        &self,
        repulsion: &ArrayRef<f64, Ix2>,
        converged: bool,
        stiffness: Option<f64>,
    ) -> Result<(Result<f64, &'static str>, Option<String>), Failure> {
        let mut warning = None;
        let value = match self.method {
            _ if !converged => return Ok((Err(NOT_CONVERGED), None)),
            ConductanceMethod::Undefined(reason) => return Ok((Err(reason), None)),
            ConductanceMethod::OfStiffness(factor) => stiffness.map_or(f64::NAN, |stiffness| factor * stiffness),
            ConductanceMethod::Solved => {
                let failed = |error: &dyn std::fmt::Display| Failure::computation(format!("the conductance: {error}"));
                let conductors = self.conductors().map_err(|error| failed(&error))?;
                let Conductance { value, .. } = match &conductors.conductance(repulsion) {
                    Ok(found) => *found,
                    Err(inexact @ ConductanceError::Inexact { reached, .. }) => {
                        warning = Some(inexact.to_string());
                        *reached
                    }
                    Err(error) => return Err(failed(error)),
                };
                value
            }
        };
        // Full contact has no stiffness either.
        Ok((if value.is_finite() { Ok(value) } else { Err(ALL_TOUCH) }, warning))
    }

    fn conductors(&self) -> Result<&Conductors, gfmd_contact::Refusal> {
        if let Some(made) = self.conductors.get() {
            return Ok(made);
        }
        let made = Conductors::new(self.boundary, &self.grid, self.height)?;
        Ok(self.conductors.get_or_init(|| made))
    }
}

/// Returns true if the normal stiffness of the contact depends on the body and the points in contact alone.
fn is_elastic_wall(facts: &Facts) -> bool {
    let has_history = facts.yields || facts.relaxes.is_some() || facts.wear.is_some();
    let shears = facts.friction.is_some() || facts.lateral;
    !(facts.has_law() || facts.hardness || has_history || shears) && facts.unknown != Unknown::Held
}
