//! One contact of either kind, with a hard wall alone or with a law, behind one type that Python can hold.

use std::sync::Arc;
use std::time::Instant;

use gfmd_cli::contact::Unknown;
use gfmd_cli::failure::Failure;
use gfmd_cli::load::{LoadRecord, NoStiffness, Recorded, Stiff, UNSOLVED};
use gfmd_contact::{
    Boundary, Budget, Contact, Equilibrium, Fields, FullContact, FullSolution, Hardness, Load, Refusal, Solution,
    SolveError, Solver, SqueezedContact, SqueezedSolution, SteepContact, SteepSolution, Stiffness, Watch,
};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Interface, Kept, State};
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use ndarray::{Array2, ArrayRef2, ArrayView2};

/// A contact, and the method.
pub(crate) struct Loads {
    contact: Kindred,
    body: Body,
    solver: Solver,
}

enum Kindred {
    Wall(Contact),
    Full(FullContact),
    Steep(SteepContact),
    Squeezed(SqueezedContact),
    Law(Interface),
}

/// What a contact has beside its surface and its body.
pub(crate) struct Setting<'a> {
    pub(crate) boundary: Boundary,
    pub(crate) kind: Kind,
    pub(crate) law: &'a Arc<dyn Law>,
    pub(crate) hardness: Option<&'a Hardness>,
    pub(crate) unknown: Unknown,
    pub(crate) finite_slope: bool,
    /// Heights of a rigid surface below the slab.
    pub(crate) lower: Option<&'a ArrayRef2<f64>>,
    pub(crate) solver: Solver,
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
    Steep(Box<SteepSolution>),
    /// A state between two surfaces, and u_z of the lower face.
    Squeezed(Box<SqueezedSolution>, Array2<f64>),
    /// A state with a law, the pressure that follows from its traction, and the pressure of the wall if there is one.
    Law(Box<State>, Array2<f64>, Array2<f64>),
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
            _ => None,
        }
    }

    /// Pressure, displacement, gap of the lower face of a slab between two surfaces.
    pub(crate) fn lower(&self) -> Option<[ArrayView2<'_, f64>; 3]> {
        let Reached::Squeezed(solution, displacement) = &self.reached else { return None };
        Some([solution.lower.pressure.view(), displacement.view(), solution.lower.gap.view()])
    }

    /// The repulsive pressure of a contact with a law.
    pub(crate) fn repulsion(&self) -> Option<ArrayView2<'_, f64>> {
        if let Reached::Law(_, _, repulsion) = &self.reached { Some(repulsion.view()) } else { None }
    }

    /// The lateral displacement, if it was unknown.
    pub(crate) fn lateral(&self) -> &[Array2<f64>] {
        match &self.reached {
            Reached::Full(solution) => &solution.lateral,
            Reached::Steep(solution) => &solution.lateral,
            _ => &[],
        }
    }

    /// Pressure, displacement, gap.
    pub(crate) fn fields(&self) -> [ArrayView2<'_, f64>; 3] {
        match &self.reached {
            Reached::Wall(solution) => [solution.pressure.view(), solution.displacement_z(), solution.gap()],
            Reached::Full(solution) => [solution.normal.pressure.view(), solution.displacement_z(), solution.gap()],
            Reached::Steep(solution) => [solution.normal.pressure.view(), solution.displacement_z(), solution.gap()],
            Reached::Squeezed(solution, _) => {
                [solution.upper.pressure.view(), solution.displacement_z(), solution.gap()]
            }
            Reached::Law(state, pressure, _) => [pressure.view(), state.displacement_z(), state.gap()],
        }
    }
}

fn wall(solution: Solution) -> Reached {
    Reached::Wall(Box::new(solution))
}

fn full(solution: FullSolution) -> Reached {
    Reached::Full(Box::new(solution))
}

fn steep(solution: SteepSolution) -> Reached {
    Reached::Steep(Box::new(solution))
}

fn squeezed(solution: SqueezedSolution) -> Reached {
    let displacement = solution.lower_displacement_z();
    Reached::Squeezed(Box::new(solution), displacement)
}

fn with_law(state: State) -> Reached {
    let [pressure, repulsion] = [state.pressure(), state.repulsion()].map(|field| field.into_owned());
    Reached::Law(Box::new(state), pressure, repulsion)
}

/// The stiffness of a load, which `stopped` before it was solved, or the reason why it has none.
fn stiffness<E: Stiff>(contact: &E, state: &E::State, stopped: bool) -> Result<Stiffness, &'static str> {
    if stopped {
        return Err(UNSOLVED);
    }
    contact.stiffness_of(state).or_else(|error| match error {
        NoStiffness::Undefined(reason) => Err(reason),
        NoStiffness::Inexact(reached, why) => {
            tracing::warn!("{why}");
            Ok(reached)
        }
    })
}

impl Loads {
    pub(crate) fn new(
        (grid, body): (Grid, &Body),
        heights: &ArrayRef2<f64>,
        setting: &Setting<'_>,
    ) -> Result<Self, Refusal> {
        let Setting { boundary, kind, law, hardness, unknown, finite_slope, lower, solver } = *setting;
        let contact = if let Some(lower) = lower {
            Kindred::Squeezed(SqueezedContact::new(body, &grid, heights, lower)?)
        } else if finite_slope {
            Kindred::Steep(SteepContact::new(body, &grid, heights)?)
        } else if unknown == Unknown::All {
            Kindred::Full(FullContact::new(body, &grid, heights)?)
        } else if kind == Kind::HardWall {
            let contact = unknown.wall(boundary, &grid.whole(), body, &grid, heights)?;
            Kindred::Wall(match hardness {
                Some(hardness) => contact.with_hardness(hardness.clone())?,
                None => contact,
            })
        } else {
            Kindred::Law(Interface::bounded(boundary, body, &grid, heights, Arc::clone(law))?)
        };
        let allowed = match &contact {
            Kindred::Wall(contact) => contact.solvers(),
            Kindred::Full(contact) => contact.solvers(),
            Kindred::Steep(contact) => contact.solvers(),
            Kindred::Squeezed(contact) => contact.solvers(),
            Kindred::Law(interface) => interface.solvers(),
        };
        if !allowed.contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed });
        }
        Ok(Self { contact, body: body.clone(), solver })
    }

    /// The remark that single points jump on this grid, if the law is too steep for it.
    pub(crate) fn trapping(&self) -> Option<String> {
        if let Kindred::Law(interface) = &self.contact {
            interface.trapping().map(|told| told.to_string())
        } else {
            None
        }
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
                let stiffness = stiffness(contact, &state, failure.is_some());
                let seconds = started.elapsed().as_secs_f64();
                let mut rest = Rest::of(state, wall, scales, budget.tolerance, seconds);
                rest.record = rest.record.stiff(stiffness);
                rest.record = rest.record.bounded(contact.boundary(), contact.surface().grid(), &self.body);
                Ok((rest, failure))
            }
            Kindred::Full(contact) => {
                let start = if let Some(Reached::Full(start)) = last { Some(&**start) } else { None };
                self.rested((contact, full), load, (budget, scales), start, watch)
            }
            Kindred::Steep(contact) => {
                let start = if let Some(Reached::Steep(start)) = last { Some(&**start) } else { None };
                self.rested((contact, steep), load, (budget, scales), start, watch)
            }
            Kindred::Squeezed(contact) => {
                let start = if let Some(Reached::Squeezed(start, _)) = last { Some(&**start) } else { None };
                self.rested((contact, squeezed), load, (budget, scales), start, watch)
            }
            Kindred::Law(interface) => {
                let start = if let Some(Reached::Law(start, ..)) = last { Some(&**start) } else { None };
                let (mut rest, failure) = self.rested((interface, with_law), load, (budget, scales), start, watch)?;
                rest.record = rest.record.bounded(interface.boundary(), interface.surface().grid(), &self.body);
                Ok((rest, failure))
            }
        }
    }

    /// As [`solve`](Self::solve), of a contact on the whole cell.
    fn rested<E: Stiff<State: Recorded>>(
        &self,
        (contact, kept): (&E, impl FnOnce(E::State) -> Reached),
        load: Load,
        (budget, scales): (&Budget, &Scales),
        start: Option<&E::State>,
        watch: &mut dyn Watch,
    ) -> Result<(Rest, Option<Failure>), Failure> {
        let started = Instant::now();
        let (state, failure) = self.press(contact, load, budget, start, watch)?;
        let stiffness = stiffness(contact, &state, failure.is_some());
        let mut rest = Rest::of(state, kept, scales, budget.tolerance, started.elapsed().as_secs_f64());
        rest.record = rest.record.stiff(stiffness);
        Ok((rest, failure))
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

    /// The state with these fields, as a file keeps them, and the pressure on the lower face if there is one, to start from.
    pub(crate) fn recalled(
        &self,
        kept: Kept<'_>,
        lower: Option<&ArrayRef2<f64>>,
        scales: &Scales,
    ) -> Result<Rest, Failure> {
        let refuse = |error: Refusal| Failure::input("start", error);
        // Without a level of the displacement the approach has no value; the fields of the state have one of their own.
        let of_fields = |clearance: &[f64]| {
            let fields = kept.gap.iter().zip(kept.displacement_z);
            let sum: f64 = clearance.iter().zip(fields).map(|(clearance, (gap, u))| clearance - gap - u).sum();
            if kept.approach.is_nan() { sum / clearance.len() as f64 } else { kept.approach }
        };
        match &self.contact {
            Kindred::Wall(contact) => {
                let kept = Kept { approach: of_fields(contact.surface().clearance()), ..kept };
                let solution = contact.certify(kept.pressure, Load::Approach(kept.approach)).map_err(refuse)?;
                Ok(Rest::of(solution, wall, scales, f64::INFINITY, 0.0))
            }
            Kindred::Full(contact) => {
                let mean = kept.pressure.mean().unwrap_or(f64::NAN);
                let solution = contact.certify(kept.pressure, Load::MeanPressure(mean)).map_err(refuse)?;
                Ok(Rest::of(solution, full, scales, f64::INFINITY, 0.0))
            }
            Kindred::Steep(contact) => {
                let solution = contact.certify(kept.pressure, Load::Approach(kept.approach)).map_err(refuse)?;
                Ok(Rest::of(solution, steep, scales, f64::INFINITY, 0.0))
            }
            Kindred::Squeezed(contact) => {
                let lower = lower.ok_or_else(|| Failure::Input("start has no lower_pressure".into()))?;
                let load = Load::Approach(kept.approach);
                let solution = contact.certify([kept.pressure, lower], load).map_err(refuse)?;
                Ok(Rest::of(solution, squeezed, scales, f64::INFINITY, 0.0))
            }
            Kindred::Law(interface) => {
                let kept = Kept { approach: of_fields(interface.surface().clearance()), ..kept };
                let state = interface.recall(kept).map_err(refuse)?;
                Ok(Rest::of(state, with_law, scales, f64::INFINITY, 0.0))
            }
        }
    }
}
