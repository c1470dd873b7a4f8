//! One contact of either kind, with a hard wall alone or with a law, behind one type that Python can hold.

use std::sync::Arc;
use std::time::Instant;

use gfmd_cli::contact::Unknown;
use gfmd_cli::failure::Failure;
use gfmd_cli::load::{LoadRecord, Recorded, Stiff as _};
use gfmd_contact::{
    Boundary, Budget, Contact, Equilibrium, Fields, FullContact, FullSolution, Hardness, Load, Refusal, Solution,
    SolveError, Solver, Watch,
};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Interface, Kept, State};
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::{Array2, ArrayRef2, ArrayView2};

/// A contact, and the method.
pub(crate) struct Loads {
    contact: Kindred,
    solver: Solver,
}

enum Kindred {
    Wall(Contact),
    Full(FullContact),
    Law(Interface),
}

/// A load at rest, or as far as it came.
pub(crate) struct Rest {
    pub(crate) record: LoadRecord,
    reached: Reached,
}

/// The state that the next load starts from.
enum Reached {
    Wall(Box<Solution>),
    Full(Box<FullSolution>),
    /// A state with a law, and the pressure that follows from its traction.
    Law(Box<State>, Array2<f64>),
}

impl Rest {
    fn of<S: Recorded>(
        state: S,
        reached: impl FnOnce(S) -> Reached,
        scales: &Scales,
        tolerance: f64,
        seconds: f64,
    ) -> Self {
        Self { record: LoadRecord::measure(&state, scales, tolerance, seconds), reached: reached(state) }
    }

    /// The plastic depth of a contact with a hardness.
    pub(crate) fn plastic_depth(&self) -> Option<ArrayView2<'_, f64>> {
        match &self.reached {
            Reached::Wall(solution) => solution.plastic.as_ref().map(|plastic| plastic.depth.view()),
            Reached::Full(_) | Reached::Law(..) => None,
        }
    }

    /// The lateral displacement, if it was unknown.
    pub(crate) fn lateral(&self) -> &[Array2<f64>] {
        if let Reached::Full(solution) = &self.reached { &solution.lateral } else { &[] }
    }

    /// Pressure, displacement, gap.
    pub(crate) fn fields(&self) -> [ArrayView2<'_, f64>; 3] {
        match &self.reached {
            Reached::Wall(solution) => [solution.pressure.view(), solution.displacement_z(), solution.gap()],
            Reached::Full(solution) => [solution.normal.pressure.view(), solution.displacement_z(), solution.gap()],
            Reached::Law(state, pressure) => [pressure.view(), state.displacement_z(), state.gap()],
        }
    }
}

fn wall(solution: Solution) -> Reached {
    Reached::Wall(Box::new(solution))
}

fn full(solution: FullSolution) -> Reached {
    Reached::Full(Box::new(solution))
}

fn with_pressure(state: State) -> Reached {
    let pressure = state.pressure().into_owned();
    Reached::Law(Box::new(state), pressure)
}

impl Loads {
    pub(crate) fn new(
        (grid, body, boundary): (Grid, &Body, Boundary),
        heights: &ArrayRef2<f64>,
        (kind, law, hardness): (Kind, &Arc<dyn Law>, Option<&Hardness>),
        unknown: Unknown,
        solver: Solver,
    ) -> Result<Self, Refusal> {
        let (contact, allowed) = if unknown == Unknown::All {
            let contact = FullContact::on(FullResponse::new(grid, body), heights)?;
            let allowed = contact.solvers();
            (Kindred::Full(contact), allowed)
        } else if kind == Kind::HardWall {
            let contact = match boundary {
                Boundary::Periodic => Contact::on(unknown.response(grid, body), heights)?,
                Boundary::Free => Contact::bounded(boundary, body, &grid, heights)?,
            };
            let contact = match hardness {
                Some(hardness) => contact.with_hardness(hardness.clone())?,
                None => contact,
            };
            let allowed = contact.solvers();
            (Kindred::Wall(contact), allowed)
        } else {
            let interface = match boundary {
                Boundary::Periodic => Interface::on(NormalResponse::new(grid, body), heights, Arc::clone(law))?,
                Boundary::Free => Interface::bounded(boundary, body, &grid, heights, Arc::clone(law))?,
            };
            if let Some(trapping) = interface.trapping() {
                tracing::warn!("{trapping}");
            }
            let allowed = interface.solvers();
            (Kindred::Law(interface), allowed)
        };
        if !allowed.contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed });
        }
        Ok(Self { contact, solver })
    }

    /// Brings one load to rest. With a failure, the state is as far as it came; without a state, the load was refused.
    pub(crate) fn solve(
        &self,
        load: Load,
        budget: &Budget,
        scales: &Scales,
        last: Option<&Rest>,
        watch: &mut dyn Watch,
    ) -> Result<(Rest, Option<Failure>), Failure> {
        let started = Instant::now();
        let last = last.map(|rest| &rest.reached);
        match &self.contact {
            Kindred::Wall(contact) => {
                let start = if let Some(Reached::Wall(start)) = last { Some(&**start) } else { None };
                let (state, failure) = self.press(contact, load, budget, start, watch)?;
                let stiffness = failure.is_none().then(|| contact.stiffness_of(&state)).transpose();
                let stiffness = stiffness.map(Option::flatten).unwrap_or_else(|(reached, why)| {
                    tracing::warn!("{why}");
                    Some(reached)
                });
                let seconds = started.elapsed().as_secs_f64();
                let mut rest = Rest::of(state, wall, scales, budget.tolerance, seconds);
                rest.record = rest.record.stiff(stiffness);
                rest.record = rest.record.bounded(contact.boundary(), contact.surface().grid());
                Ok((rest, failure))
            }
            Kindred::Full(contact) => {
                let start = if let Some(Reached::Full(start)) = last { Some(&**start) } else { None };
                let (state, failure) = self.press(contact, load, budget, start, watch)?;
                let seconds = started.elapsed().as_secs_f64();
                Ok((Rest::of(state, full, scales, budget.tolerance, seconds), failure))
            }
            Kindred::Law(interface) => {
                let start = if let Some(Reached::Law(start, _)) = last { Some(&**start) } else { None };
                let (state, failure) = self.press(interface, load, budget, start, watch)?;
                let seconds = started.elapsed().as_secs_f64();
                let mut rest = Rest::of(state, with_pressure, scales, budget.tolerance, seconds);
                rest.record = rest.record.bounded(interface.boundary(), interface.surface().grid());
                Ok((rest, failure))
            }
        }
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
            Err(SolveError::Refused(error @ (Refusal::Approach { .. } | Refusal::NoApproach))) => {
                Err(Failure::input("approach", error))
            }
            Err(SolveError::Refused(error)) => Err(Failure::Input(error.to_string())),
            Err(error) => {
                let text = error.to_string();
                match error.into_state() {
                    Some(state) => Ok((state, Some(Failure::Computation(text)))),
                    None => Err(Failure::Input(text)),
                }
            }
        }
    }

    /// The state with these fields, as a file keeps them, to start from.
    pub(crate) fn recalled(&self, kept: Kept<'_>, scales: &Scales) -> Result<Rest, Failure> {
        let refuse = |error: Refusal| Failure::input("start", error);
        match &self.contact {
            Kindred::Wall(contact) => {
                let solution = contact.certify(kept.pressure, Load::Approach(kept.approach)).map_err(refuse)?;
                Ok(Rest::of(solution, wall, scales, f64::INFINITY, 0.0))
            }
            Kindred::Full(contact) => {
                let mean = kept.pressure.mean().unwrap_or(f64::NAN);
                let solution = contact.certify(kept.pressure, Load::MeanPressure(mean)).map_err(refuse)?;
                Ok(Rest::of(solution, full, scales, f64::INFINITY, 0.0))
            }
            Kindred::Law(interface) => {
                let state = interface.recall(kept).map_err(refuse)?;
                Ok(Rest::of(state, with_pressure, scales, f64::INFINITY, 0.0))
            }
        }
    }
}
