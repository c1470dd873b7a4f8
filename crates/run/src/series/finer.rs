//! Same contact on a finer grid, to find the grid error of its numbers.

use gfmd_contact::{Drive, Load, Refusal, Resumable as _, Visit, Watch};
use gfmd_problem::{AnyState, GridError, Posed, key, words};
use gfmd_record::{OnFinerGrid, StateContext, UNRESOLVED};
use gfmd_surface::Interpolation;

use super::prepared::{Asked, Prepared};
use super::pressed::ContactArgs;
use crate::gas::GivenGas;
use gfmd_input::failure::{Failure, reached};
use gfmd_input::hardness::GivenHardness;
use gfmd_input::session::Session;
use gfmd_input::source::{SourceArgs, Surface};

/// Returns the surface of a problem on a grid with twice as many points along each side: once, or by both
/// interpolations if the heights between the points are unknown. Empty unless `--grid-error refine` is requested.
///
/// # Errors
/// Returns an error if no other grid of the problem is known.
pub fn sources(asked: &Asked, prepared: &Prepared) -> Result<Vec<SourceArgs>, Failure> {
    let how = prepared.facts.grid_error;
    if how != GridError::Refine {
        return Ok(Vec::new());
    }
    if let Some(GivenHardness::Field(_)) = asked.hardness {
        return Err(Failure::value(
            key("grid_error"),
            how,
            words!["none or estimate with a ", key("hardness"), " of each point"],
        ));
    }
    let Surface { share, .. } = &prepared.surface;
    let both = share.any(prepared.surface.is_read()) && prepared.short_waves() > UNRESOLVED;
    let ways = [Interpolation::Waves, Interpolation::Cubic].into_iter().take(1 + usize::from(both));
    ways.map(|how| asked.source.finer(2, how)).collect()
}

/// Poses a problem on finer grids, with the input of each: none, one, or one for each of two interpolations.
///
/// # Errors
/// Returns an error if no other grid of the problem is known, or if the problem does not fit into memory.
pub fn on_finer_grids(
    asked: &Asked,
    prepared: &Prepared,
    session: &Session,
) -> Result<Vec<(Prepared, Posed)>, Failure> {
    let pose = |source: SourceArgs| {
        let Prepared { fluid, conductivity, gas, .. } = *prepared;
        let gas = gas.map(GivenGas::Numbers);
        let asked = Asked { source: &source, once: true, fluid, conductivity, gas, ..asked.clone() };
        let finer = Prepared::new(&asked, prepared.facts, &session.silenced())?;
        let contact = finer.pose(&source, &finer.law)?;
        Ok((finer, contact))
    };
    sources(asked, prepared)?.into_iter().map(pose).collect()
}

/// Returns the drive that leads to the same place on a finer grid, whose highest point lies higher by `rise` (length):
/// an approach counts from the highest point.
pub fn at_same_place(drive: Drive, rise: f64) -> Drive {
    match drive.load {
        Load::Approach(approach) => Drive { load: Load::Approach(approach + rise), ..drive },
        Load::MeanPressure(_) => drive,
    }
}

/// Returns the numbers on a finer grid, or the reason why there are none; the number on the coarse grid stays.
///
/// # Errors
/// Returns an error after an interruption.
pub fn beside(found: Result<OnFinerGrid, Failure>) -> Result<Result<OnFinerGrid, String>, Failure> {
    match found {
        Ok(found) => Ok(Ok(found)),
        Err(failure @ Failure::Interrupted(_)) => Err(failure),
        Err(failure) => Ok(Err(failure.to_string())),
    }
}

/// Contact on a grid with twice as many points along each side, solved load by load.
pub struct Finer {
    args: ContactArgs,
    /// Input.
    pub prepared: Prepared,
    contact: Posed,
    /// Height of its highest point above the highest point of the coarser grid.
    rise: f64,
    last: Option<AnyState>,
}

impl Finer {
    /// Poses the finer contacts of the contact that the options pose ([`on_finer_grids`]).
    ///
    /// # Errors
    /// Fails like [`on_finer_grids`].
    pub fn pose(args: &ContactArgs, prepared: &Prepared, session: &Session) -> Result<Vec<Self>, Failure> {
        let posed = on_finer_grids(&args.asked()?, prepared, session)?.into_iter();
        let with_rise = |(finer, contact): (Prepared, Posed)| {
            let rise = finer.highest() - prepared.highest();
            Self { args: args.clone(), prepared: finer, contact, rise, last: None }
        };
        Ok(posed.map(with_rise).collect())
    }

    /// Returns true if a state was found before.
    pub fn has_started(&self) -> bool {
        self.last.is_some()
    }

    /// Forgets the last state, so that the next search starts from the undeformed surface.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Visits the last state, from which the next search starts.
    pub fn keep(&mut self, visitor: &mut dyn Visit) {
        visitor.flag(&mut self.last.is_some());
        if let Some(state) = &mut self.last {
            self.contact.keep(state, visitor);
        }
    }

    /// Restores the last state, which [`keep`](Self::keep) visited, under a drive of the coarser grid.
    ///
    /// # Errors
    /// Returns an error if the data do not make a state.
    pub fn resume(&mut self, drive: Drive, visitor: &mut dyn Visit) -> Result<(), Refusal> {
        let mut has_state = false;
        visitor.flag(&mut has_state);
        let restore = || self.contact.restore(at_same_place(drive, self.rise), visitor);
        self.last = has_state.then(restore).transpose()?;
        Ok(())
    }

    /// Solves for the state under a drive of the coarser grid, starting from the previous one; returns it with its
    /// surface and its numbers.
    ///
    /// # Errors
    /// Returns an error if the search was interrupted, or did not converge.
    pub fn reach(
        &mut self,
        drive: Drive,
        watch: &mut dyn Watch,
    ) -> Result<(&AnyState, &Surface, StateContext<'_>), Failure> {
        let [nx, ny] = self.prepared.surface.grid.points();
        let drive = at_same_place(drive, self.rise);
        let first = match self.last {
            Some(_) => None,
            None => self.args.after_longer_ranges(&self.prepared, drive, watch)?,
        };
        let start = self.last.as_ref().or(first.as_ref());
        let units = self.prepared.surface.units();
        let (state, failure) =
            reached(self.args.press(&self.contact, drive).starting_from(start).watch(watch).solve(), &units)?;
        match failure {
            Some(failure) => Err(failure.at(format!("the grid of {nx} x {ny} points"))),
            None => {
                let state = self.last.insert(state);
                let at = resolved(&self.prepared, state, self.args.solver.search.tolerance);
                Ok((state, &self.prepared.surface, at.stiff(&self.contact, self.args.stiffness.stiffness_tolerance)))
            }
        }
    }
}

/// Returns the numbers of a state on a finer grid, which resolves all that lies between the points of the coarser one.
pub fn resolved<'a>(finer: &'a Prepared, state: &'a AnyState, tolerance: f64) -> StateContext<'a> {
    StateContext { short_waves: 0.0, ..finer.at(state, tolerance) }
}
