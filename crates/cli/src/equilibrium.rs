//! One load of a rigid surface on an elastic body, by the solver that fits what acts between them: a hard wall alone, or a
//! law that reaches across the gap.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use gfmd_contact::{Budget, Contact, Equilibrium, Load, Refusal, Solution, SolveError, Solver};
use gfmd_interface::{Drive, Interface, InterfaceError, Method, State};
use gfmd_law::{Kind, Law};
use gfmd_response::NormalResponse;
use ndarray::{Array2, ArrayView2, Axis};

use crate::failure::Failure;
use crate::load::LoadRecord;

/// What is to be brought to rest.
pub enum Problem<'a> {
    /// A hard wall.
    Wall(Contact, Solver),
    /// A law that reaches across the gap, and the method to solve with it.
    Law(Interface<'a>, Method),
}

/// A load at rest, or as far as it came.
pub struct Rest {
    /// Its scalars.
    pub record: LoadRecord,
    /// Pressure on the elastic surface; attraction is negative.
    pub pressure: Array2<f64>,
    /// u_z.
    pub displacement: Array2<f64>,
    /// Distance between the surfaces.
    pub gap: Array2<f64>,
    /// Where the next load starts.
    state: Reached,
}

enum Reached {
    Wall(Solution),
    Law(State),
}

/// What the scalars of a load are measured with.
#[derive(Clone, Copy, Debug)]
pub struct Measures {
    /// E*.
    pub contact_modulus: f64,
    /// Spectral rms gradient of the whole surface.
    pub rms_gradient: f64,
}

impl<'a> Problem<'a> {
    /// A hard wall alone has solvers of its own, faster than those for a law.
    ///
    /// # Errors
    /// Heights that make no contact; a solver that cannot be used with the law.
    pub fn new(
        response: &'a Arc<NormalResponse>,
        heights: ArrayView2<f64>,
        kind: Kind,
        law: &'a dyn Law,
        solver: Solver,
        name: &str,
    ) -> Result<Self, Failure> {
        if kind == Kind::HardWall {
            let contact = Contact::on(Arc::clone(response), &heights).map_err(|error| Failure::input(name, error))?;
            return Ok(Self::Wall(contact, solver));
        }
        let method = match solver {
            Solver::Auto => Method::Auto,
            Solver::Fire => Method::Dynamics,
            found => {
                let allowed = &[Solver::Auto, Solver::Fire];
                return Err(Failure::input("--solver", Refusal::Solver { found, allowed }));
            }
        };
        let interface = Interface::normal(response, heights, law).map_err(|error| Failure::input(name, error))?;
        if let Some(trapping) = interface.trapping() {
            tracing::warn!("{trapping}");
        }
        Ok(Self::Law(interface, method))
    }

    /// Root mean square of the heights about their mean.
    pub fn rms_height(&self) -> f64 {
        match self {
            Self::Wall(contact, _) => contact.surface().rms_height(),
            Self::Law(interface, _) => interface.rms_height(),
        }
    }

    /// Brings one load to rest, from the last. With a failure, the state is as far as it came.
    ///
    /// # Errors
    /// A load that cannot be posed.
    pub fn solve(
        &self,
        load: Load,
        budget: &Budget,
        measures: &Measures,
        last: Option<&Rest>,
        watch: &mut dyn FnMut(u64, f64) -> ControlFlow<()>,
    ) -> Result<(Rest, Option<Failure>), Failure> {
        let started = Instant::now();
        let Measures { contact_modulus, rms_gradient } = *measures;
        let rms_height = self.rms_height();
        match self {
            Self::Wall(contact, solver) => {
                let start =
                    last.and_then(|rest| if let Reached::Wall(start) = &rest.state { Some(start) } else { None });
                let mut watch = |now: &gfmd_contact::Progress| watch(now.iteration, now.residual);
                let press = contact.press(load).budget(*budget).solver(*solver).starting_from(start);
                let (solution, failure) = judge(press.watch(&mut watch).solve())?;
                let seconds = started.elapsed().as_secs_f64();
                let record = LoadRecord::measure(&solution, contact_modulus, rms_gradient, budget.tolerance, seconds);
                let Solution { pressure, displacement, gap, .. } = solution.clone();
                Ok((Rest { record, pressure, displacement, gap, state: Reached::Wall(solution) }, failure))
            }
            Self::Law(interface, method) => {
                let drive = match load {
                    Load::MeanPressure(pressure) => Drive::mean_pressure(pressure),
                    Load::Approach(approach) => Drive::approach(approach),
                };
                let Budget { tolerance, max_iterations } = *budget;
                let settings = gfmd_interface::Settings { method: *method, tolerance, max_iterations };
                let start =
                    last.and_then(|rest| if let Reached::Law(start) = &rest.state { Some(start) } else { None });
                let mut watch = |now: &gfmd_interface::Progress| watch(now.iteration, now.residual);
                let (state, failure) = judge_law(interface.solve(drive, &settings, start, &mut watch))?;
                let seconds = started.elapsed().as_secs_f64();
                let record =
                    LoadRecord::of_state(&state, contact_modulus, rms_gradient, rms_height, tolerance, seconds);
                let rest = Rest {
                    record,
                    pressure: state.traction.index_axis(Axis(0), 0).mapv(|t| -t),
                    displacement: state.displacement.index_axis(Axis(0), 0).to_owned(),
                    gap: state.gap.clone(),
                    state: Reached::Law(state),
                };
                Ok((rest, failure))
            }
        }
    }
}

fn judge(outcome: Result<Solution, SolveError<Solution>>) -> Result<(Solution, Option<Failure>), Failure> {
    match outcome {
        Ok(solution) => Ok((solution, None)),
        Err(SolveError::Interrupted { state }) => Ok((*state, Some(Failure::Interrupted("interrupted".into())))),
        Err(SolveError::Refused(error @ Refusal::Approach { .. })) => Err(Failure::input("--displacement", error)),
        Err(SolveError::Refused(error @ Refusal::Solver { .. })) => Err(Failure::input("--solver", error)),
        Err(error) => {
            let failure = Failure::Computation(error.to_string());
            match error.into_state() {
                Some(state) => Ok((state, Some(failure))),
                None => Err(failure),
            }
        }
    }
}

fn judge_law(outcome: Result<State, InterfaceError>) -> Result<(State, Option<Failure>), Failure> {
    match outcome {
        Ok(state) => Ok((state, None)),
        Err(InterfaceError::NotConverged { state, asked, reason }) => {
            let text = not_converged(asked, state.iterations, reason, &state.residual);
            Ok((*state, Some(Failure::Computation(text))))
        }
        Err(InterfaceError::Detached { mean_pressure, state }) => {
            let text = format!("the surfaces part under the mean pressure {mean_pressure:e}");
            Ok((*state, Some(Failure::Computation(text))))
        }
        Err(InterfaceError::Interrupted { state }) => Ok((*state, Some(Failure::Interrupted("interrupted".into())))),
        Err(error @ InterfaceError::Approach { .. }) => Err(Failure::input("--displacement", error)),
        Err(error @ InterfaceError::NoDynamics) => Err(Failure::input("--solver", error)),
        Err(error) => Err(Failure::Computation(error.to_string())),
    }
}

fn not_converged(asked: f64, iterations: u64, reason: &str, residual: &dyn std::fmt::Display) -> String {
    format!("did not converge to {asked:e} in {iterations} iterations ({reason}): {residual}")
}
