//! FRT MicroProf (`.frt`): profilometers of FRT. Numbers are little-endian.
//!
//! A number of blocks, each with its number, its length (32 bits in version 1.00, 64 in 1.01) and its content: the
//! number of points and their bits, the size in m, the height of a count in m, and the counts line by line from the
//! bottom; or several images with their kinds and points. Undefined points have the count 1.

use super::bytes::{Bytes, Grid, MOST_CHANNELS, Order, Sample, clip, count, factor, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "FRT MicroProf", sniff, open, first_line: FirstLine::Bottom };

const MAGIC: &[u8] = b"FRTM_GLIDERV";

/// Numbers of the blocks that are read.
const POINTS: u16 = 0x66;
const SIZE: u16 = 0x67;
const SCALE: u16 = 0x6c;
const HEIGHTS: u16 = 0x0b;
const IMAGES: u16 = 0x7d;

/// Bit of the kind of an image with heights.
const TOPOGRAPHY: u32 = 4;

/// Count of an undefined point.
const UNDEFINED: f64 = 1.0;

fn sniff(file: &File) -> bool {
    file.starts_with(MAGIC)
}

/// Blocks of a file.
struct Blocks<'a>(Vec<(u16, &'a [u8])>);

impl<'a> Blocks<'a> {
    fn read(all: &'a [u8]) -> Result<Self, String> {
        let mut bytes = Bytes::new(all, Order::Little);
        bytes.skip(MAGIC.len())?;
        let version = bytes.take(4)?;
        if !matches!(version, b"1.00" | b"1.01") {
            return Err(format!("the version is {:?}; it must be 1.00 or 1.01", clip(&text(version))));
        }
        let blocks = bytes.u16()?;
        let mut found = Vec::new();
        for _ in 0..blocks {
            let number = bytes.u16()?;
            let length = if version == b"1.00" { u64::from(bytes.u32()?) } else { bytes.u64()? };
            let content = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
            if [POINTS, SIZE, SCALE, HEIGHTS, IMAGES].contains(&number)
                && !found.iter().any(|(other, _)| *other == number)
            {
                found.push((number, content));
            }
        }
        Ok(Self(found))
    }

    fn get(&self, number: u16) -> Option<Bytes<'a>> {
        let found = self.0.iter().find(|(other, _)| *other == number);
        found.map(|(_, content)| Bytes::new(content, Order::Little))
    }

    fn needed(&self, number: u16, what: &str) -> Result<Bytes<'a>, String> {
        self.get(number).ok_or_else(|| format!("the file has no block {number:#x}, {what}; it must have it"))
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let blocks = Blocks::read(file.bytes()?)?;
    let mut sizes = blocks.needed(SIZE, "the size")?;
    let lengths = [positive("the length along x", sizes.f64()?)?, positive("the length along y", sizes.f64()?)?];
    let mut scales = blocks.needed(SCALE, "the height of a count")?;
    scales.skip(4)?;
    let scale = factor("the height of a count", scales.f64()?)?;
    let channel = |name: &str, grid: Grid, data| {
        let metre = Some("m".to_owned());
        let lengths = Some([lengths[0], if grid.points[1] == 1 { 1.0 } else { lengths[1] }]);
        let map = Map { lengths, length_unit: metre.clone(), height_unit: metre, ..Map::default() };
        let height = move |found| if found == UNDEFINED { f64::NAN } else { scale * found };
        Channel::of_grid(name, grid, data, map, height)
    };
    if let Some(mut data) = blocks.get(HEIGHTS) {
        let grid = head(&mut blocks.needed(POINTS, "the number of points")?)?;
        return channel("", grid, data.take(data.left())?).map(Into::into);
    }
    let mut images = blocks.needed(IMAGES, "the heights")?;
    images.skip(8)?;
    let (mut channels, mut others) = (Vec::new(), Vec::new());
    while images.left() > 0 {
        let kind = images.u32()?;
        let grid = head(&mut images)?;
        let data = images.take(grid.bytes()?)?;
        if kind & TOPOGRAPHY != 0 && channels.len() < MOST_CHANNELS {
            channels.push(channel("Topography", grid, data)?);
        } else if others.len() < 10 {
            others.push(format!("{kind:#x}"));
        }
    }
    match channels.is_empty() {
        true => Err(format!("the images have the kinds {}; one must be a topography, 0x4", others.join(", "))),
        false => Ok(channels.into()),
    }
}

/// Reads the number of points and their bits.
fn head(bytes: &mut Bytes) -> Result<Grid, String> {
    let points = [count("the number of columns", bytes.u32()?)?, count("the number of lines", bytes.u32()?)?];
    let sample = match bytes.u32()? {
        16 => Sample::U16,
        32 => Sample::I32,
        bits => return Err(format!("a count has {bits} bits; it must have 16 or 32")),
    };
    Ok(Grid::lines(points, sample, Order::Little))
}
