//! The file of a study that is complete.

use std::path::Path;

use gfmd_check::study::Cube;
use gfmd_files::Reader;
use gfmd_input::session::GIT_COMMIT;

/// Returns the result in a file, if it is the whole result of this configuration by this program: a merge that is
/// started again has nothing to compute.
pub(super) fn stored(out: &Path, config: &str) -> Option<Cube> {
    let reader = Reader::open(out).ok()?;
    let same = |name: &str, value: &str| reader.text("/", name).is_ok_and(|text| text == value);
    let ours = same("config", config) && same("version", env!("CARGO_PKG_VERSION")) && same("git_commit", GIT_COMMIT);
    if !ours || reader.is_intact().ok()? != Some(true) {
        return None;
    }
    Cube::read(&reader).ok()
}
