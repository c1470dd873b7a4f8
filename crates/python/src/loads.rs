//! Contacts of any kind and their states, as Python holds them.

use std::time::Instant;

use gfmd_contact::{Budget, Equilibrium as _, Fields as _, Load, Refusal, SolveError, Solver, Watch};
use gfmd_interface::Kept;
use gfmd_measure::Scales;
use gfmd_problem::{Facts, Given, NoStiffness, Posed, pose};
use gfmd_record::{At, NOT_SOLVED, Record};
use gfmd_run::failure::Failure;
use ndarray::{Array2, ArrayRef2, ArrayView2};

/// A contact, and the method.
pub(crate) struct Loads {
    contact: Posed,
    facts: Facts,
    solver: Solver,
}

/// A load at rest, or as far as it came.
pub(crate) struct Rest {
    /// The numbers of a load that was solved; none of one that was recalled.
    pub(crate) record: Option<Record>,
    state: gfmd_problem::Rest,
    /// The pressure that follows from a traction, and that of the wall.
    of_traction: Option<[Array2<f64>; 2]>,
    /// u_z of the lower face of a slab between two surfaces.
    lower_displacement: Option<Array2<f64>>,
}

impl Rest {
    fn of(state: gfmd_problem::Rest, record: Option<Record>) -> Self {
        let of_traction = state.law().map(|law| [law.pressure(), law.repulsion()].map(|field| field.into_owned()));
        let lower_displacement = state.lower().map(|lower| -&lower.displacement);
        Self { record, state, of_traction, lower_displacement }
    }

    /// The plastic depth of a contact with a hardness.
    pub(crate) fn plastic_depth(&self) -> Option<ArrayView2<'_, f64>> {
        self.state.plastic_depth().map(|depth| depth.view())
    }

    /// Pressure, displacement, gap of the lower face of a slab between two surfaces.
    pub(crate) fn lower(&self) -> Option<[ArrayView2<'_, f64>; 3]> {
        let (lower, displacement) = self.state.lower().zip(self.lower_displacement.as_ref())?;
        Some([lower.pressure.view(), displacement.view(), lower.gap.view()])
    }

    /// The repulsive pressure of a contact with a law.
    pub(crate) fn repulsion(&self) -> Option<ArrayView2<'_, f64>> {
        self.of_traction.as_ref().map(|[_, repulsion]| repulsion.view())
    }

    /// The lateral displacement, if it was unknown.
    pub(crate) fn lateral(&self) -> &[Array2<f64>] {
        self.state.lateral()
    }

    /// Pressure, displacement, gap. A state has its pressure, or a traction from which it follows.
    pub(crate) fn fields(&self) -> Option<[ArrayView2<'_, f64>; 3]> {
        let of_traction = self.of_traction.as_ref().map(|[pressure, _]| pressure);
        let pressure = self.state.wall().map(|wall| &wall.pressure).or(of_traction)?;
        Some([pressure.view(), self.state.displacement_z(), self.state.gap()])
    }
}

impl Loads {
    pub(crate) fn new(given: &Given<'_>, solver: Solver) -> Result<Self, Refusal> {
        let contact = pose(given)?;
        let allowed = contact.solvers();
        if !allowed.contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed });
        }
        Ok(Self { contact, facts: given.facts, solver })
    }

    /// The remark that single points jump on this grid, if the law is too steep for it.
    pub(crate) fn trapping(&self) -> Option<String> {
        self.contact.trapping().map(|told| told.to_string())
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
        let start = last.map(|rest| &rest.state);
        let (state, failure) = match self.contact.equilibrate(load.into(), self.solver, budget, start, watch) {
            Ok(state) => (state, None),
            Err(SolveError::Interrupted { state }) => (*state, Some(Failure::Interrupted("interrupted".into()))),
            Err(SolveError::Refused(error @ (Refusal::Approach { .. } | Refusal::NoApproach))) => {
                return Err(Failure::input("approach", error));
            }
            Err(SolveError::Refused(error @ Refusal::OtherKind)) => return Err(Failure::input("start", error)),
            Err(SolveError::Refused(error)) => return Err(Failure::Input(error.to_string())),
            Err(error) => {
                let text = error.to_string();
                match error.into_state() {
                    Some(state) => (state, Some(Failure::Computation(text))),
                    None => return Err(Failure::Input(text)),
                }
            }
        };
        let stiffness = if failure.is_some() { Err(NOT_SOLVED) } else { self.stiffness(&state) };
        let stiffness = stiffness.map_err(Into::into);
        let at = At::in_scales(&self.facts, &state, scales, self.contact.surface().grid(), budget.tolerance);
        let record = Record::of(&At { stiffness, seconds: started.elapsed().as_secs_f64(), ..at });
        Ok((Rest::of(state, Some(record)), failure))
    }

    /// The stiffness of a load, or the reason why it has none.
    fn stiffness(&self, state: &gfmd_problem::Rest) -> Result<gfmd_contact::Stiffness, &'static str> {
        self.contact.stiffness(state).or_else(|error| match error {
            NoStiffness::Undefined(reason) => Err(reason),
            NoStiffness::Inexact(reached, why) => {
                tracing::warn!("{why}");
                Ok(reached)
            }
        })
    }

    /// The state with these fields, as a file keeps them, and the pressure on the lower face if there is one, to start from.
    pub(crate) fn recalled(&self, kept: Kept<'_>, lower: Option<&ArrayRef2<f64>>) -> Result<Rest, Failure> {
        let state = self.contact.recall(kept, lower).map_err(|error| Failure::input("start", error))?;
        Ok(Rest::of(state, None))
    }
}
