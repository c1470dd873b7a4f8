//! NumPy archives, `.npz`: several named arrays.

use std::io::Read;

use super::array::grid;
use super::bytes::MOST_CHANNELS;
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::zipped::Zip;
use crate::npy::Header;

pub(crate) const FORMAT: Format =
    Format { name: "NumPy archive", sniff: is_archive, open: open_archive, first_line: FirstLine::Bottom };

/// Largest number of bytes of a header; NumPy writes at most 64 KiB.
const HEADER: u64 = 1 << 16;

fn is_archive(file: &File) -> bool {
    let all_arrays = |names: Vec<String>| !names.is_empty() && names.iter().all(|name| name.ends_with(".npy"));
    file.starts_with(b"PK") && Zip::open(file).is_ok_and(|zip| all_arrays(zip.names()))
}

fn open_archive(file: &File) -> Result<Contents<'_>, String> {
    let mut zip = Zip::open(file)?;
    let mut channels = Vec::new();
    for entry in zip.names().into_iter().take(MOST_CHANNELS) {
        let mut start = Vec::new();
        zip.stream(&entry)?.0.take(HEADER).read_to_end(&mut start).map_err(|error| format!("{entry}: {error}"))?;
        let Ok(header) = Header::parse(&start) else { continue };
        let Ok(grid) = grid(&header) else { continue };
        let name = entry.trim_end_matches(".npy").to_owned();
        let read = move || {
            let mut zip = Zip::open(file)?;
            let (mut stream, compressed) = zip.stream(&entry)?;
            let mut skipped = vec![0; header.data];
            stream.read_exact(&mut skipped).map_err(|error| format!("{entry}: {error}"))?;
            let heights = grid.inflate(compressed, stream, |height| height)?;
            Ok(Map { heights, ..Map::default() })
        };
        channels.push(Channel { name, unit: None, points: grid.points, read: Box::new(read) });
    }
    if channels.is_empty() {
        return Err("the archive has no array of real numbers with 1 or 2 dimensions; it must have one".into());
    }
    Ok(channels.into())
}
