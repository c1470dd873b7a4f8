//! The check of a file of fields below a surface.

use std::path::Path;

use gfmd_files::Reader;

use super::Args;
use crate::check::{Configuration, parsed, printable};
use crate::failure::Failure;
use crate::session::Session;
use crate::source::file_of;

/// Computes the fields of a file again, with the output `out`, if the displacement of the surface is at hand.
pub(crate) fn again(reader: &Reader, config: &Configuration, out: &Path, session: &Session) -> Result<bool, Failure> {
    let mut words = config.words(&[]);
    // Waves have no file.
    if let Some(surface) = config.file() {
        let (file, input) = (file_of(surface), reader.text("/input", "file")?);
        // Only the input that has a checksum is opened, as the regular file that it was.
        if file != input {
            let text = format!("surface is {file:?}; it must be the input {input:?} of the file");
            return Err(Failure::input("config of the file", text));
        }
        if !Path::new(file).exists() {
            let text =
                format!("the input {} is not there, so that the fields cannot be computed again", printable(&input));
            session.warn("input-missing", text);
            return Ok(false);
        }
        words.push(format!("--surface={surface}"));
    }
    let args: Args = parsed(&words)?;
    super::run(&Args { out: Some(out.into()), ..args }, session)?;
    Ok(true)
}
