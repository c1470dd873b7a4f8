//! Arrays of NumPy (`.npy`): one array `[x, y]` or `[x]`, without sizes and units.

use crate::npy::{self, Header};

use super::file::File;
use super::format::{Channel, Contents, Format, Map};
use super::{shaped, two_dimensional};

pub(super) const FORMAT: Format = Format { name: "NumPy", sniff: |file| file.starts_with(npy::MAGIC), open };

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    let points = two_dimensional(&Header::parse(bytes)?.shape)?;
    let read = move || {
        let heights = shaped(points, npy::parse(bytes)?.into_iter().collect())?;
        Ok(Map { heights, ..Map::default() })
    };
    Ok(Channel { name: String::new(), unit: None, points, read: Box::new(read) }.into())
}
