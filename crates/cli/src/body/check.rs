//! The check of a file of fields below a surface.

use std::path::Path;

use gfmd_files::Reader;

use super::Args;
use crate::check::{parsed, words};
use crate::failure::Failure;
use crate::session::Session;

/// Computes the fields of a file again, with the output `out`, if the displacement of the surface is at hand.
pub(crate) fn again(reader: &Reader, config: &str, out: &Path, session: &Session) -> Result<bool, Failure> {
    let input = reader.text("/input", "file").ok();
    // Waves have no file.
    if let Some(input) = input.filter(|input| !Path::new(input).exists()) {
        let text = format!("the input {input} is not there, so that the fields cannot be computed again");
        session.warn("input-missing", text);
        return Ok(false);
    }
    let mut words = words(config, &[])?;
    words.push(format!("--out={}", out.display()));
    super::run(&parsed::<Args>(&words)?, session)?;
    Ok(true)
}
