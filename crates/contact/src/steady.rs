//! Contacts with a complex stiffness of each wave, as on a body under a surface that slides steadily.

mod contraction;
mod krylov;
mod newton;

use std::sync::Arc;

use gfmd_relax::{Budget, Ending, Watch, Why};
use ndarray::{Array2, ArrayRef2};
use num_complex::Complex64;

use self::contraction::Contraction;
use self::newton::Newton;
use crate::{Boundary, Contact, Effort, Equilibrium as _, Load, Refusal, Solution, SolveError, Solver, Units, judge};

/// Tolerance of the contact from which a search starts.
const START: f64 = 1e-2;

/// Contact with a complex stiffness of each wave, whose pressure leads its displacement: the body under a surface that
/// slides steadily. The compliance is positive definite but not symmetric, and the pressure is unique (theory.md,
/// section 7.8). Clones share the data.
#[derive(Clone, Debug)]
pub struct SteadyContact {
    /// Contact with the real stiffness.
    contact: Contact,
    /// Complex stiffness of each mode divided by its stiffness in `contact`.
    modulus: Arc<[Complex64]>,
}

impl SteadyContact {
    /// Makes the contact of a body with waves that are stiffer by `modulus` than in `contact`, laid out as the
    /// [modes](gfmd_field::Grid::modes) of the grid. The uniform mode, the first, is static: its factor is not used.
    ///
    /// # Errors
    /// Free boundaries, springs, several processes; a wave whose pressure leads its displacement by 90 degrees or more.
    pub fn new(contact: &Contact, modulus: Vec<Complex64>) -> Result<Self, Refusal> {
        if contact.boundary() == Boundary::Free || contact.springs.is_some() || !contact.share.is_whole() {
            return Err(Refusal::OtherKind);
        }
        let expected = contact.surface().grid().spectrum_len();
        if modulus.len() != expected {
            return Err(Refusal::Start { found: modulus.len(), expected });
        }
        let angle = |modulus: &Complex64| modulus.arg().abs().to_degrees();
        match modulus[1..].iter().find(|modulus| modulus.re <= 0.0 || !modulus.is_finite()) {
            Some(wrong) => Err(Refusal::Lead { found: angle(wrong) }),
            None => Ok(Self { contact: contact.clone(), modulus: modulus.into() }),
        }
    }

    /// Returns the contact with the real stiffness.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// Computes the state of `pressure` under `load` with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid.
    pub fn certify(&self, pressure: &ArrayRef2<f64>, load: Load) -> Result<Solution, Refusal> {
        self.contact.check_size(pressure.view())?;
        let stress = self.contact.units().stress();
        let load = self.contact.units().drive(load.into()).load;
        let pressure = pressure.iter().map(|p| p / stress).collect();
        let solution = Newton::new(self, load, pressure).certified();
        Ok(self.contact.given_units(solution))
    }

    /// Brings the surfaces to rest under `load`, from the pressure of `start` if there is one.
    ///
    /// The search is a semismooth Newton method. If its residual does not halve in some steps, contacts with the real
    /// part of the stiffness are solved one after the other, which converges for every material.
    ///
    /// # Errors
    /// An invalid load; other errors have the state reached.
    pub fn equilibrate(
        &self,
        load: Load,
        budget: &Budget,
        start: Option<&Solution>,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError<Solution>> {
        budget.check()?;
        let contact = &self.contact;
        if self.modulus[1..].iter().all(|modulus| *modulus == Complex64::ONE) {
            return contact.equilibrate(load.into(), Solver::Auto, budget, start, watch);
        }
        contact.check(load.into())?;
        contact.check_resolution(load.into(), budget.tolerance)?;
        let start = start.filter(|start| start.mean_pressure > 0.0);
        if let Some(start) = start {
            contact.check_start(start.pressure.view())?;
        }
        let (start, before) = match start {
            Some(start) => (start.pressure.clone(), Effort::default()),
            None => self.rough_start(load, budget)?,
        };
        let start = start.iter().map(|p| p / contact.units().stress()).collect();
        let scaled = contact.units().drive(load.into()).load;
        let (mut solution, mut ending) = Newton::new(self, scaled, start).run(budget, watch);
        solution = contact.given_units(solution);
        solution.effort.add(before);
        let left =
            Budget { max_iterations: budget.max_iterations.saturating_sub(solution.effort.iterations), ..*budget };
        if matches!(ending, Ending::GaveUp(Why::Certificate)) && left.max_iterations > 0 {
            let before = solution.effort;
            let reached;
            (reached, ending) = Contraction::new(self, left).run(load, solution, watch)?;
            solution = reached;
            solution.effort.add(before);
        }
        Units::check_pressure(solution.mean_pressure)?;
        judge(solution, ending, budget.tolerance)
    }

    /// Returns a pressure to start from, the contact with the real part of the stiffness to [`START`], and its effort.
    fn rough_start(&self, load: Load, budget: &Budget) -> Result<(Array2<f64>, Effort), Refusal> {
        let budget = Budget { tolerance: START.max(budget.tolerance), ..*budget };
        match self.storing().equilibrate(load.into(), Solver::Auto, &budget, None, &mut ()) {
            Ok(state) => Ok((state.pressure, state.effort)),
            Err(SolveError::Refused(refusal)) => Err(refusal),
            // Any pressure is a start.
            Err(error) => Ok(error.into_state().map_or_else(Default::default, |state| (state.pressure, state.effort))),
        }
    }

    /// Returns the contact with the real part of the stiffness.
    fn storing(&self) -> Contact {
        let real = self.modulus.iter().enumerate().map(|(index, m)| if index == 0 { 1.0 } else { m.re });
        self.contact.stiffened(&real.collect::<Vec<_>>())
    }

    /// Returns the complex compliance of each mode, in the units of `contact`; of the uniform mode zero.
    fn compliance(&self) -> Vec<Complex64> {
        let table = self.contact.response.compliance().iter().zip(&*self.modulus);
        // The table has no uniform mode, which is identified by its index, the first.
        let waves = table.enumerate().map(|(index, (g, modulus))| match index {
            0 => Complex64::ZERO,
            _ => *g / modulus,
        });
        waves.collect()
    }
}
