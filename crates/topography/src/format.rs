//! The interface of the reader of a format: recognition of its files, their channels, and the heights of a channel.

use ndarray::{Array2, Axis};

use super::file::File;
use super::unit;

/// A format of height maps.
pub(crate) struct Format {
    /// The name in messages and output.
    pub name: &'static str,
    /// Returns true if the contents of a file have this format. Text formats come last and accept all other files.
    pub sniff: fn(&File) -> bool,
    /// Lists the channels that are height maps, without decoding them.
    pub open: for<'a> fn(&'a File) -> Result<Contents<'a>, String>,
    /// The side of the picture with the line j = 0 of a decoded map.
    pub first_line: FirstLine,
}

/// A side of the picture that the instrument shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FirstLine {
    Top,
    Bottom,
}

impl Format {
    /// Turns a decoded map so that its y points up in the picture.
    pub(crate) fn upright(&self, map: &mut Map) {
        if self.first_line == FirstLine::Top {
            map.heights.invert_axis(Axis(1));
        }
    }
}

/// The channels of a file that are height maps, in the order of the file; at least one.
pub(crate) struct Contents<'a> {
    pub channels: Vec<Channel<'a>>,
    /// The channel that is read if none is named; `None` if one must be named.
    pub default: Option<usize>,
    /// Other names of channels, by their numbers.
    pub aliases: Vec<(usize, String)>,
    /// Doubts about the file.
    pub warnings: Vec<String>,
}

impl<'a> From<Vec<Channel<'a>>> for Contents<'a> {
    /// The first channel is the default.
    fn from(channels: Vec<Channel<'a>>) -> Self {
        Self { channels, default: Some(0), aliases: Vec::new(), warnings: Vec::new() }
    }
}

impl<'a> From<Channel<'a>> for Contents<'a> {
    fn from(channel: Channel<'a>) -> Self {
        vec![channel].into()
    }
}

/// A height map in a file, not yet decoded.
pub(crate) struct Channel<'a> {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The unit of the heights.
    pub unit: Option<String>,
    /// The number of points along x and y; a profile has 1 along y.
    pub points: [usize; 2],
    /// Decodes the heights. The reader has checked that the file has the bytes for them before it allocates.
    pub read: Box<dyn FnOnce() -> Result<Map, String> + 'a>,
}

/// The first of the channels with these numbers in a unit of length, else the first one without a unit, else the first.
pub(crate) fn first_height(channels: &[Channel], among: &[usize]) -> Option<usize> {
    let first = |has: &dyn Fn(Option<&str>) -> bool| among.iter().find(|k| has(channels[**k].unit.as_deref())).copied();
    let length = first(&|unit| unit.is_some_and(unit::is_length));
    length.or_else(|| first(&|unit| unit.is_none())).or_else(|| among.first().copied())
}

/// A decoded channel, in the units of the file.
#[derive(Debug, Default)]
pub(crate) struct Map {
    /// Heights `[x, y]` in `height_unit`; not finite where undefined.
    pub heights: Array2<f64>,
    /// Size of the scanned field along x and y in `length_unit`, n times the spacing. The second size of a profile
    /// is 1.
    pub lengths: Option<[f64; 2]>,
    pub length_unit: Option<String>,
    pub height_unit: Option<String>,
    /// Entries of the file about instrument and measurement: key and value.
    pub details: Vec<(String, String)>,
    /// Remarks of the reader.
    pub notes: Vec<String>,
}
