//! Keyence ZON (`.zon`): profilometers of Keyence, VR series. Numbers are little-endian.
//!
//! A picture, then a zip archive with members of fixed names: the calibration as XML, in m, the heights as counts, and
//! marks of points that were not measured. Lines are padded, the top line first. In files that begin with `KPK1` each
//! member is a frame of Zstandard.

use std::io::Read;

use ruzstd::decoding::StreamingDecoder;

use super::bytes::{Bytes, Order, Sample, clip, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::zipped::{MOST_TEXT, Zip, xml};

pub(crate) const FORMAT: Format = Format { name: "Keyence ZON", sniff, open, first_line: FirstLine::Top };

/// Names of members.
const CALIBRATION: &str = "686613b8-27b5-4a29-8ffc-438c2780873e";
const HEIGHTS: &str = "4cdb0c75-5706-48cc-a9a1-adf395d609ae";
const MARKS: &str = "9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916";

/// Bits of the mark of a point that was not measured, and of other marks.
const MISSING: u8 = 0b11;

fn sniff(file: &File) -> bool {
    file.starts_with(b"KPK0") || file.starts_with(b"KPK1")
}

/// Largest ratio of compression of a frame, and the number of bytes that any frame may have.
const MOST_RATIO: u64 = 64;
const SMALL: u64 = 1 << 20;

/// Largest part of a frame that the decoder keeps, in bytes: what a decoder must be able to keep (RFC 8878, section
/// 3.1.1.1.2).
const WINDOW: u64 = 8 << 20;

/// Decompresses a frame of Zstandard, and no more than a frame of its length may have.
fn decompress(name: &str, frame: &[u8]) -> Result<Vec<u8>, String> {
    let most = (frame.len() as u64).saturating_mul(MOST_RATIO).max(SMALL);
    let damaged = |reason: String| format!("the frame of Zstandard {name} is damaged: {reason}");
    let decoder = StreamingDecoder::new_with_max_window_size(frame, WINDOW);
    let mut bytes = Vec::new();
    let decoder = decoder.map_err(|error| damaged(error.to_string()))?;
    decoder.take(most + 1).read_to_end(&mut bytes).map_err(|error| damaged(error.to_string()))?;
    if bytes.len() as u64 > most {
        return Err(format!("the frame of Zstandard {name} has more than {most} bytes; it must have fewer"));
    }
    Ok(bytes)
}

/// Reads a member of the archive, which is compressed by Zstandard if `is_frame`.
fn member(zip: &mut Zip, name: &str, is_frame: bool) -> Result<Vec<u8>, String> {
    let bytes = zip.whole(name)?;
    if is_frame { decompress(name, &bytes) } else { Ok(bytes) }
}

/// Numbers of a member.
struct Array {
    points: [usize; 2],
    /// Bytes of a number and of a line.
    lengths: [usize; 2],
    all: Vec<u8>,
}

impl Array {
    /// Reads the head of a member and checks its length.
    fn read(all: Vec<u8>, sample: Sample) -> Result<Self, String> {
        let mut bytes = Bytes::new(&all, Order::Little);
        let points = [count("the number of columns", bytes.i32()?)?, count("the number of lines", bytes.i32()?)?];
        let lengths = [count("the bytes of a number", bytes.i32()?)?, count("the bytes of a line", bytes.i32()?)?];
        let row = points[0].saturating_mul(sample.size());
        if lengths[0] != sample.size() || lengths[1] < row {
            return Err(format!(
                "the numbers have {} bytes and a line of {} points {}; they must have {} and at least {row}",
                lengths[0],
                points[0],
                lengths[1],
                sample.size()
            ));
        }
        let needed = lengths[1].saturating_mul(points[1]);
        if bytes.left() < needed {
            let found = bytes.left();
            return Err(format!("{} by {} points have {found} bytes; they must have {needed}", points[0], points[1]));
        }
        Ok(Self { points, lengths, all })
    }

    /// Returns the place and the bytes of each number.
    fn numbers(&self) -> impl Iterator<Item = ([usize; 2], &[u8])> {
        let [[nx, ny], [size, row]] = [self.points, self.lengths];
        let rows = self.all[16..].chunks_exact(row).take(ny).enumerate();
        rows.flat_map(move |(y, row)| {
            row.chunks_exact(size).take(nx).enumerate().map(move |(x, number)| ([x, y], number))
        })
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let is_frame = file.starts_with(b"KPK1");
    let mut zip = Zip::open(file)?;
    let text = member(&mut zip, CALIBRATION, is_frame)?;
    if text.len() as u64 > MOST_TEXT {
        return Err(format!("the calibration has {} bytes; it must have at most {MOST_TEXT}", text.len()));
    }
    let text = String::from_utf8(text).map_err(|_| "the calibration is not text in UTF-8")?;
    let document = xml("Calibration", text.trim_start_matches('\u{feff}'))?;
    let number = |group: &str, name: &str| {
        let mut groups = document.descendants().filter(|node| node.tag_name().name() == group);
        let found = groups.find_map(|node| node.children().find(|child| child.tag_name().name() == name)?.text());
        let text = found.ok_or_else(|| format!("the calibration has no {name}; it must have it"))?.trim();
        text.parse::<f64>().map_err(|_| format!("{name} is {:?}; it must be a number", clip(text)))
    };
    let spacing = positive("MeterPerPixel", number("XYCalibration", "MeterPerPixel")?)?;
    let scale = factor("MeterPerUnit", number("ZCalibration", "MeterPerUnit")?)?;
    let heights = Array::read(member(&mut zip, HEIGHTS, is_frame)?, Sample::I32)?;
    let marks = match zip.meant(MARKS) {
        Some(name) => Some(Array::read(member(&mut zip, &name, is_frame)?, Sample::U8)?),
        None => None,
    };
    let [nx, ny] = heights.points;
    if let Some(marks) = marks.as_ref().filter(|marks| marks.points != heights.points) {
        let [mx, my] = marks.points;
        return Err(format!("there are {mx} by {my} marks for {nx} by {ny} heights; there must be as many"));
    }
    let metre = Some("m".to_owned());
    let lengths = Some(size([nx, ny], [spacing; 2]));
    let mut map = Map { lengths, length_unit: metre.clone(), height_unit: metre.clone(), ..Map::default() };
    let read = move || {
        map.heights = ndarray::Array2::zeros((nx, ny));
        for (point, number) in heights.numbers() {
            map.heights[point] = scale * Sample::I32.decode(number, Order::Little);
        }
        let mut others = 0;
        for (point, mark) in marks.iter().flat_map(Array::numbers) {
            if mark[0] & MISSING != 0 {
                map.heights[point] = f64::NAN;
            } else if mark[0] != 0 {
                others += 1;
            }
        }
        if others > 0 {
            map.notes
                .push(format!("{others} points with other marks keep their heights; some programs leave them out"));
        }
        Ok(map)
    };
    Ok(Channel { name: String::new(), unit: metre, points: [nx, ny], read: Box::new(read) }.into())
}
