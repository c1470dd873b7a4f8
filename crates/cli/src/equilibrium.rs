//! One load of a rigid surface on an elastic body, by the solver that fits what acts between them: a hard wall alone, or a
//! law that reaches across the gap.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use gfmd_contact::{
    Budget, Contact, Equilibrium, Fields, Load, Progress, Refusal, Solution, SolveError, Solver, Watch,
};
use gfmd_interface::{Interface, State};
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use gfmd_response::NormalResponse;
use ndarray::{Array2, ArrayRef2};

use crate::failure::Failure;
use crate::load::LoadRecord;

/// A contact that is to be brought to rest, and the method.
pub struct Problem {
    contact: Kindred,
    solver: Solver,
}

enum Kindred {
    /// With a hard wall.
    Wall(Contact),
    /// With a law that reaches across the gap.
    Law(Interface),
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

impl Rest {
    fn of<S: Fields>(record: LoadRecord, state: S, reached: fn(S) -> Reached) -> Self {
        Self {
            record,
            pressure: state.pressure().into_owned(),
            displacement: state.displacement_z().to_owned(),
            gap: state.gap().to_owned(),
            state: reached(state),
        }
    }
}

impl Problem {
    /// A hard wall alone has solvers of its own, faster than those for a law.
    ///
    /// # Errors
    /// Heights that make no contact; a solver that cannot be used with the law.
    pub fn new(
        response: &Arc<NormalResponse>,
        heights: &ArrayRef2<f64>,
        kind: Kind,
        law: &Arc<dyn Law>,
        solver: Solver,
        name: &str,
    ) -> Result<Self, Failure> {
        let refuse = |error: Refusal| Failure::input(name, error);
        let response = Arc::clone(response);
        let contact = if kind == Kind::HardWall {
            Kindred::Wall(Contact::on(response, heights).map_err(refuse)?)
        } else {
            Kindred::Law(Interface::on(response, heights, Arc::clone(law)).map_err(refuse)?)
        };
        let allowed = match &contact {
            Kindred::Wall(contact) => contact.solvers(),
            Kindred::Law(interface) => interface.solvers(),
        };
        if !allowed.contains(&solver) {
            return Err(Failure::input("--solver", Refusal::Solver { found: solver, allowed }));
        }
        if let Kindred::Law(interface) = &contact
            && let Some(trapping) = interface.trapping()
        {
            tracing::warn!("{trapping}");
        }
        Ok(Self { contact, solver })
    }

    /// Root mean square of the heights about their mean.
    pub fn rms_height(&self) -> f64 {
        match &self.contact {
            Kindred::Wall(contact) => contact.surface().rms_height(),
            Kindred::Law(interface) => interface.surface().rms_height(),
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
        scales: &Scales,
        last: Option<&Rest>,
        watch: &mut dyn FnMut(u64, f64) -> ControlFlow<()>,
    ) -> Result<(Rest, Option<Failure>), Failure> {
        let started = Instant::now();
        let last = last.map(|rest| &rest.state);
        let mut watch = |now: &Progress| watch(now.iteration, now.residual);
        Ok(match &self.contact {
            Kindred::Wall(contact) => {
                let start = if let Some(Reached::Wall(start)) = last { Some(start) } else { None };
                let (solution, failure) = self.press(contact, load, budget, start, &mut watch)?;
                let Scales { contact_modulus, rms_gradient } = *scales;
                let seconds = started.elapsed().as_secs_f64();
                let record = LoadRecord::measure(&solution, contact_modulus, rms_gradient, budget.tolerance, seconds);
                (Rest::of(record, solution, Reached::Wall), failure)
            }
            Kindred::Law(interface) => {
                let start = if let Some(Reached::Law(start)) = last { Some(start) } else { None };
                let (state, failure) = self.press(interface, load, budget, start, &mut watch)?;
                let record = LoadRecord::of_state(&state, scales, budget.tolerance, started.elapsed().as_secs_f64());
                (Rest::of(record, state, Reached::Law), failure)
            }
        })
    }

    fn press<E: Equilibrium>(
        &self,
        contact: &E,
        load: Load,
        budget: &Budget,
        start: Option<&E::State>,
        watch: &mut dyn Watch,
    ) -> Result<(E::State, Option<Failure>), Failure> {
        match contact.equilibrate(load.into(), self.solver, budget, start, watch) {
            Ok(state) => Ok((state, None)),
            Err(SolveError::Interrupted { state }) => Ok((*state, Some(Failure::Interrupted("interrupted".into())))),
            Err(SolveError::Refused(error @ Refusal::Approach { .. })) => Err(Failure::input("--displacement", error)),
            Err(SolveError::Refused(error @ Refusal::NoDynamics)) => Err(Failure::input("--solver", error)),
            Err(SolveError::Refused(error @ Refusal::Tolerance(_))) => Err(Failure::input("--tol", error)),
            Err(error) => {
                let failure = Failure::Computation(error.to_string());
                match error.into_state() {
                    Some(state) => Ok((state, Some(failure))),
                    None => Err(failure),
                }
            }
        }
    }
}
