//! What several processes can share.

use gfmd_contact::{Boundary, Contact, Solver};
use gfmd_law::Kind;

use super::{Args, Unknown};
use crate::failure::Failure;
use crate::session::Session;

impl Args {
    /// The flags of one of several processes, of which the first writes and draws.
    ///
    /// # Errors
    /// A flag of what several processes cannot share.
    pub(super) fn shared(&self, session: &Session) -> Result<Self, Failure> {
        self.check_shared()?;
        let own = self.clone();
        Ok(if session.is_first() { own } else { Self { out: None, plots: None, ..own } })
    }

    fn check_shared(&self) -> Result<(), Failure> {
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
}
