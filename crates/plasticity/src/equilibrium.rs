//! The contact as one that paths, files and the program take.

use gfmd_contact::{
    Budget, Drive, Equilibrium, Loss, Losses, Quasistatic, Reading, Refusal, Resumable, SolveError, Solver, Visit,
    Watch,
};
use gfmd_relax::Variables as _;
use gfmd_vector::with_contiguous;
use ndarray::Array2;

use crate::{PlasticState, YieldingContact};

/// Each state is one step from the state that it starts from, or from first touch of a body that has not yielded. The
/// lateral displacement, the time and the distance of a drive have no effect.
impl Equilibrium for YieldingContact {
    type State = PlasticState;

    fn solvers(&self) -> &'static [Solver] {
        &[Solver::Auto]
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        self.check_load(drive.load)
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        YieldingContact::check_resolution(self, drive.load, tolerance)
    }

    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&PlasticState>,
        watch: &mut dyn Watch,
    ) -> Result<PlasticState, SolveError<PlasticState>> {
        drive.check()?;
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        match start {
            Some(before) => self.step(before, drive.load, budget, watch),
            None => self.step(&self.rest()?, drive.load, budget, watch),
        }
    }
}

/// A state follows from its pressure and its plastic strain, with the numbers of the search that found it.
impl Quasistatic for YieldingContact {
    fn reading(&self, state: &PlasticState) -> Reading {
        let losses = Losses { plastic: state.dissipated, ..Losses::default() };
        let loss =
            Loss::Certified { lost: state.dissipated, imbalance: state.work_imbalance, stored: None, flows: true };
        Reading { losses, loss, ..Reading::of(state) }
    }
}

impl Resumable for YieldingContact {
    fn keep(&self, state: &mut PlasticState, visitor: &mut dyn Visit) {
        let mesh = &self.volume.mesh;
        with_contiguous(&mut state.solution.pressure, |pressure| visitor.rows(&mesh.division.surface, pressure));
        state.plastic.visit(mesh, visitor);
        state.plastic_before.visit(mesh, visitor);
        self.keep_numbers(state, visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<PlasticState, Refusal> {
        self.check(drive)?;
        let mut before = self.rest()?;
        let mesh = &self.volume.mesh;
        let mut pressure = Array2::zeros(mesh.surface_shape());
        with_contiguous(&mut pressure, |pressure| visitor.rows(&mesh.division.surface, pressure));
        let mut plastic = before.plastic.clone();
        plastic.visit(mesh, visitor);
        before.plastic.visit(mesh, visitor);
        let mut state = self.certify(&before, &pressure, &plastic, drive.load)?;
        self.keep_numbers(&mut state, visitor);
        Ok(state)
    }
}

impl YieldingContact {
    /// Visits the numbers that depend on the state before, and the effort of the search.
    fn keep_numbers(&self, state: &mut PlasticState, visitor: &mut dyn Visit) {
        let PlasticState { dissipated, work_imbalance, operators, solution, .. } = state;
        visitor.numbers(&mut [dissipated, work_imbalance]);
        visitor.count(operators);
        solution.effort.visit(visitor);
    }
}
