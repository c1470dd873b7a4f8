//! What several processes can share.

use gfmd_contact::{Boundary, Contact, Hardness, Solver};
use gfmd_green::Body;
use gfmd_law::Kind;

use super::{Args, Unknown};
use crate::base::MovedBase;
use crate::failure::Failure;
use crate::hardness;
use crate::session::Session;
use crate::source::Surface;

impl Args {
    /// Checks that several processes can share what the flags ask for.
    ///
    /// # Errors
    /// A flag of what they cannot share.
    pub(super) fn check_shared(&self) -> Result<(), Failure> {
        let not_shared = [
            ("--law", self.law.law != Kind::HardWall),
            ("--boundary free", self.boundary == Boundary::Free),
            ("--components all", self.components == Unknown::All),
            ("--finite-slope", self.finite_slope),
            ("--lower-surface, --lower-seed", self.lower.flag().is_some()),
            ("--statistics", self.statistics),
            ("--flow", self.flow),
            ("--flow-threshold", self.flow_threshold),
            ("--history", self.trace.is_wanted()),
            ("--resume", self.resume.resume),
        ];
        if let Some((flag, _)) = not_shared.into_iter().find(|(_, is_given)| *is_given) {
            let found = format!(
                "{flag}: several processes do not share this; it must be absent, or the program run by one process"
            );
            return Err(Failure::Input(found));
        }
        let solver = self.solver.solver;
        if Contact::FREE_SOLVERS.contains(&solver) {
            return Ok(());
        }
        let names: Vec<&str> = Contact::FREE_SOLVERS.iter().copied().map(Solver::name).collect();
        Err(Failure::value("--solver", solver, format!("one of {} with several processes", names.join(", "))))
    }

    /// The base that moves and the hardness, of the rows of this process. Of several processes the first one reads the files.
    pub(super) fn read_fields(
        &self,
        body: &Body,
        surface: &Surface,
        session: &Session,
    ) -> Result<(Option<MovedBase>, Option<Hardness>), Failure> {
        let Surface { grid, share, unit, .. } = surface;
        let read = || {
            let base = self.base.read(body, grid, unit.as_deref())?;
            Ok((base, self.hardness.as_ref().map(|hardness| hardness.read(grid)).transpose()?))
        };
        if share.is_whole() {
            return read();
        }
        let (base, hardness) = session.agree(if session.is_first() { read() } else { Ok((None, None)) })?;
        let base = self.base.is_given().then(|| MovedBase::handed_out(base, grid, share));
        let hardness = self.hardness.is_some().then(|| hardness::handed_out(hardness, grid, share));
        Ok((base, hardness))
    }
}
