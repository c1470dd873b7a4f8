//! The file of a study that is complete.

use std::path::Path;

use gfmd_check::study::Cube;
use gfmd_files::Reader;
use gfmd_input::failure::Failure;
use gfmd_input::session::GIT_COMMIT;

use super::Report;

/// Reads the report of the study in a file. Nothing is solved.
///
/// # Errors
/// Returns an error if the file is not the result of a study.
pub fn report_of(reader: &Reader) -> Result<Report, Failure> {
    let cube = Cube::read(reader)?;
    let seconds = reader.number("/", "seconds").unwrap_or(f64::NAN);
    Ok(Report::new(&cube, reader.path().to_path_buf(), seconds, 0))
}

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
