//! Files compressed by gzip: the file inside is read by its contents.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "gzip", sniff, open, first_line: FirstLine::Bottom };

/// Largest ratio of compression, and the number of bytes that any file may have.
const MOST_RATIO: u64 = 64;
const SMALL: u64 = 1 << 20;

fn sniff(file: &File) -> bool {
    file.starts_with(b"\x1f\x8b")
}

/// Decompresses the file inside, which must be no archive.
fn inside(file: &File) -> Result<File, String> {
    let all = file.bytes()?;
    let most = (all.len() as u64).saturating_mul(MOST_RATIO).max(SMALL);
    let damaged = |error: std::io::Error| format!("the archive of gzip is damaged: {error}");
    // The length is counted first, so that nothing is stored of a file that is too long.
    let length = std::io::copy(&mut MultiGzDecoder::new(all).take(most + 1), &mut std::io::sink()).map_err(damaged)?;
    if length > most {
        return Err(format!("the file inside has more than {most} bytes; unpack it and give the file inside"));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or_default());
    MultiGzDecoder::new(all).take(length).read_to_end(&mut bytes).map_err(damaged)?;
    if bytes.starts_with(b"\x1f\x8b") || bytes.starts_with(b"PK") {
        return Err("the file inside is an archive; unpack it and give the file inside".into());
    }
    Ok(File::from_bytes(bytes).with_image_heights(file.check_image_heights().is_ok()))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let inner = inside(file)?;
    let (format, contents) = super::open(&inner)?;
    let note = format!("the file inside has the format {}", format.name);
    let outer = |(number, channel): (usize, Channel)| {
        let note = note.clone();
        let read = Box::new(move || read(file, number, note));
        Channel { name: channel.name, unit: channel.unit, points: channel.points, read }
    };
    let channels = contents.channels.into_iter().enumerate().map(outer).collect();
    Ok(Contents { channels, default: contents.default, aliases: contents.aliases, warnings: contents.warnings })
}

/// Reads a channel of the file inside.
fn read(file: &File, number: usize, note: String) -> Result<Map, String> {
    let inner = inside(file)?;
    let (format, contents) = super::open(&inner)?;
    let Some(channel) = contents.channels.into_iter().nth(number) else {
        return Err(format!("the file inside has no channel {number}"));
    };
    let mut map = (channel.read)()?;
    format.upright(&mut map);
    map.notes.insert(0, note);
    Ok(map)
}
