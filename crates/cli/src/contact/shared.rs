//! The fields of files, which of several processes the first one reads.

use gfmd_contact::Hardness;
use gfmd_green::Body;

use super::Args;
use crate::base::MovedBase;
use crate::failure::Failure;
use crate::hardness;
use crate::session::Session;
use crate::source::Surface;

impl Args {
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
