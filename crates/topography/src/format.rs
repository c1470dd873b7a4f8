//! Interface of format readers: recognition of files, their channels, and the heights of a channel.

use ndarray::{Array2, Axis};

use super::bytes::Grid;
use super::file::File;
use super::unit;

/// Format of height maps.
pub(crate) struct Format {
    /// Name in messages and output.
    pub name: &'static str,
    /// Returns true if the content of a file has this format. Text formats come last and accept all other files.
    pub sniff: fn(&File) -> bool,
    /// Lists the channels that are height maps, without decoding them.
    pub open: for<'a> fn(&'a File) -> Result<Contents<'a>, String>,
    /// Side of the picture with the line j = 0 of a decoded map.
    pub first_line: FirstLine,
}

/// Side of the picture shown by the instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FirstLine {
    Top,
    Bottom,
}

impl Format {
    /// Flips a decoded map so that y points up in the picture.
    pub(crate) fn upright(&self, map: &mut Map) {
        if self.first_line == FirstLine::Top {
            map.heights.invert_axis(Axis(1));
        }
    }
}

/// Channels of a file that are height maps, in file order; at least one.
pub(crate) struct Contents<'a> {
    pub channels: Vec<Channel<'a>>,
    /// Channel read if none is named; `None` if one must be named.
    pub default: Option<usize>,
    /// Other names of channels, with the channel numbers.
    pub aliases: Vec<(usize, String)>,
    /// Warnings about the file.
    pub warnings: Vec<String>,
}

impl<'a> From<Vec<Channel<'a>>> for Contents<'a> {
    /// Makes the first channel the default.
    fn from(channels: Vec<Channel<'a>>) -> Self {
        Self { channels, default: Some(0), aliases: Vec::new(), warnings: Vec::new() }
    }
}

impl<'a> From<Channel<'a>> for Contents<'a> {
    fn from(channel: Channel<'a>) -> Self {
        vec![channel].into()
    }
}

/// Height map in a file, not yet decoded.
pub(crate) struct Channel<'a> {
    /// Name in the file; empty if it has none.
    pub name: String,
    /// Unit of the heights.
    pub unit: Option<String>,
    /// Number of points along x and y, 1 along y for a profile.
    pub points: [usize; 2],
    /// Decodes the heights. The reader has checked that the file holds their bytes before memory is allocated.
    pub read: Box<dyn FnOnce() -> Result<Map, String> + 'a>,
}

impl<'a> Channel<'a> {
    /// Creates a channel of the numbers of a grid at the start of `data`, each converted by `height`. `map` has all but
    /// the heights.
    ///
    /// # Errors
    /// Data that are shorter than the grid.
    pub(crate) fn of_grid(
        name: impl Into<String>,
        grid: Grid,
        data: impl AsRef<[u8]> + 'a,
        map: Map,
        height: impl Fn(f64) -> f64 + 'a,
    ) -> Result<Self, String> {
        let (needed, found, [nx, ny]) = (grid.bytes()?, data.as_ref().len(), grid.points);
        if needed > found {
            return Err(format!("the heights of {nx} by {ny} points have {found} bytes; they must have {needed}"));
        }
        let unit = map.height_unit.clone();
        let read = move || Ok(Map { heights: grid.read(data.as_ref(), height)?, ..map });
        Ok(Self { name: name.into(), unit, points: grid.points, read: Box::new(read) })
    }
}

/// Returns the size of a field of points at this spacing, 1 along y for a profile.
pub(crate) fn size(points: [usize; 2], spacing: [f64; 2]) -> [f64; 2] {
    let [nx, ny] = points;
    [spacing[0] * nx as f64, if ny == 1 { 1.0 } else { spacing[1] * ny as f64 }]
}

/// Returns the details that are not empty.
pub(crate) fn details<const N: usize>(entries: [(&str, String); N]) -> Vec<(String, String)> {
    let filled = entries.into_iter().filter(|(_, value)| !value.is_empty());
    filled.map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Returns the first of the channels `among` in a unit of length, else the first without a unit, else the first.
pub(crate) fn first_height(channels: &[Channel], among: &[usize]) -> Option<usize> {
    let first = |has: &dyn Fn(Option<&str>) -> bool| among.iter().find(|k| has(channels[**k].unit.as_deref())).copied();
    let length = first(&|unit| unit.is_some_and(unit::is_length));
    length.or_else(|| first(&|unit| unit.is_none())).or_else(|| among.first().copied())
}

/// Decoded channel, in the units of the file.
#[derive(Debug, Default)]
pub(crate) struct Map {
    /// Heights `[x, y]` in `height_unit`; not finite where undefined.
    pub heights: Array2<f64>,
    /// Size of the scanned field along x and y in `length_unit`, n times the spacing; 1 along y for a profile.
    pub lengths: Option<[f64; 2]>,
    pub length_unit: Option<String>,
    pub height_unit: Option<String>,
    /// Details of the instrument and measurement: key and value.
    pub details: Vec<(String, String)>,
    /// Notes of the reader.
    pub notes: Vec<String>,
    /// Warnings about the data of the channel.
    pub warnings: Vec<String>,
}
