use gfmd_relax::{Variables as _, Visit};
use gfmd_vector::with_contiguous;

use crate::{Contact, Drive, Equilibrium, Refusal, Solution};

/// Contact with states that can be saved outside the process and restored bit for bit, so that a series of loads
/// continues where it ended.
pub trait Resumable: Equilibrium {
    /// Visits the data that [`restore`](Self::restore) needs to make a state.
    fn keep(&self, state: &mut Self::State, visitor: &mut dyn Visit);

    /// Makes the state of `drive` from the data that `visitor` reads.
    ///
    /// # Errors
    /// An invalid drive.
    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<Self::State, Refusal>;
}

impl<R: Resumable + ?Sized> Resumable for Box<R> {
    fn keep(&self, state: &mut Self::State, visitor: &mut dyn Visit) {
        (**self).keep(state, visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<Self::State, Refusal> {
        (**self).restore(drive, visitor)
    }
}

/// The state of a hard wall follows from its pressure, except for the lateral traction left by the dynamics.
impl Resumable for Contact {
    fn keep(&self, state: &mut Solution, visitor: &mut dyn Visit) {
        with_contiguous(&mut state.pressure, |pressure| visitor.rows(&self.share, pressure));
        state.lateral.iter_mut().for_each(|lateral| visitor.number(&mut lateral.traction));
        state.effort.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<Solution, Refusal> {
        self.check(drive)?;
        let mut pressure = vec![0.0; self.scaled.clearance().len()];
        visitor.rows(&self.share, &mut pressure);
        let pressure = pressure.into_iter().map(|p| p / self.units().stress()).collect();
        let mut state = self.given_units(self.certified(pressure, self.units().drive(drive).load));
        state.lateral.iter_mut().for_each(|lateral| visitor.number(&mut lateral.traction));
        state.effort.visit(visitor);
        Ok(state)
    }
}
