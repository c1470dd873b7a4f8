//! The runs in the file of a merged sweep.

use std::path::Path;

use gfmd_files::Reader;
use gfmd_sweep::Plan;

use super::{Finished, check};
use gfmd_input::session::GIT_COMMIT;

/// The runs of the output itself, if it is the whole result of this sweep by this program: a merge that was killed
/// after the file was written, and that is started again, has nothing to compute.
pub(super) fn stored(out: &Path, config: &str, plan: &Plan) -> Option<Finished> {
    let reader = Reader::open(out).ok()?;
    let same = |name: &str, value: &str| reader.text("/", name).is_ok_and(|text| text == value);
    let ours = same("config", config) && same("version", env!("CARGO_PKG_VERSION")) && same("git_commit", GIT_COMMIT);
    drop(reader);
    if !ours {
        return None;
    }
    Some(check::earlier(out, plan).ok()?.into_iter().enumerate().collect())
}
