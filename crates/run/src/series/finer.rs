//! The same contact on a finer grid, from which the error of the numbers by the grid is found.

use gfmd_contact::{Drive, Watch};
use gfmd_problem::{Posed, Rest};
use gfmd_record::At;

use super::prepared::{Asked, Prepared};
use super::pressed::ContactArgs;
use crate::failure::{Failure, reached};
use crate::session::Session;
use crate::source::Surface;

/// A contact on a grid of twice as many points along each side, whose states are found load by load.
pub struct Finer {
    args: ContactArgs,
    /// Its input.
    pub prepared: Prepared,
    contact: Posed,
    last: Option<Rest>,
}

impl Finer {
    /// Poses the finer contacts of the one that the options pose: none, one, or one for each of two interpolations
    /// ([`ContactArgs::finer`]).
    ///
    /// # Errors
    /// A contact of which no other grid is known, or that does not fit into the memory.
    pub fn pose(args: &ContactArgs, prepared: &Prepared) -> Result<Vec<Self>, Failure> {
        let pose = |args: ContactArgs| {
            let asked = Asked { once: true, ..args.asked()? };
            let finer = Prepared::new(&asked, |_| prepared.facts, &Session::silent())?;
            let contact = finer.pose(&args.source, &finer.law)?;
            Ok(Self { prepared: finer, contact, args, last: None })
        };
        args.finer(prepared)?.into_iter().map(pose).collect()
    }

    /// True if a state was found before.
    pub fn has_started(&self) -> bool {
        self.last.is_some()
    }

    /// The state under a drive, which follows on that under the drive before, with its surface and its numbers.
    ///
    /// # Errors
    /// A search that was interrupted, or did not converge.
    pub fn reach(&mut self, drive: Drive, watch: &mut dyn Watch) -> Result<(&Rest, &Surface, At<'_>), Failure> {
        let [nx, ny] = self.prepared.surface.grid.points();
        let first = match self.last {
            Some(_) => None,
            None => self.args.after_longer_ranges(&self.prepared, drive, watch)?,
        };
        let start = self.last.as_ref().or(first.as_ref());
        let (state, failure) =
            reached(self.args.press(&self.contact, drive).starting_from(start).watch(watch).solve())?;
        match failure {
            Some(failure) => Err(failure.at(&format!("the grid of {nx} x {ny} points"))),
            None => {
                let state = self.last.insert(state);
                // Whatever lies between the points, it is resolved here.
                let at = At { short_waves: 0.0, ..self.prepared.at(state, self.args.solver.tol) };
                Ok((state, &self.prepared.surface, at.stiff(&self.contact)))
            }
        }
    }
}
