//! Images as PNG, with 16 bits of grey, or 8 if the caller says that they are heights.
//!
//! The numbers are heights without a unit, unless Gwyddion wrote the size, the units, and the heights of the smallest
//! and largest number as texts.

use std::io::Cursor;

use ndarray::Array2;
use png::{BitDepth, ColorType, Decoder, Limits, Reader};

use super::bytes::{clip, count, factor, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};

pub(crate) const FORMAT: Format = Format { name: "PNG", sniff, open, first_line: FirstLine::Top };

/// Largest ratio of compression by deflate.
const LARGEST_RATIO: usize = 1032;

/// Memory for texts and lines beside the image.
const MOST_OTHER: usize = 1 << 20;

fn sniff(file: &File) -> bool {
    file.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Opens the image.
fn reader(file: &File) -> Result<Reader<Cursor<&[u8]>>, String> {
    let all = file.bytes()?;
    let limits = Limits { bytes: all.len().saturating_add(MOST_OTHER) };
    let mut decoder = Decoder::new_with_limits(Cursor::new(all), limits);
    decoder.set_ignore_iccp_chunk(true);
    decoder.read_info().map_err(damaged)
}

fn damaged(error: png::DecodingError) -> String {
    format!("the image is damaged: {error}")
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let reader = reader(file)?;
    let info = reader.info();
    match (info.color_type, info.bit_depth) {
        (ColorType::Grayscale, BitDepth::Sixteen) => {}
        (ColorType::Grayscale, BitDepth::Eight) => file.check_image_heights()?,
        (ColorType::Grayscale, depth) => {
            let bits = depth as u8;
            return Err(format!(
                "the image has {bits} bits a pixel, as pictures have; save the heights with 16 bits, or as text"
            ));
        }
        _ => return Err("the image has colours or a palette; heights must be grey, with 16 bits".into()),
    }
    let size = if info.bit_depth == BitDepth::Eight { 1 } else { 2 };
    let largest = if size == 1 { 255.0 } else { 65535.0 };
    let points = [count("the number of columns", info.width)?, count("the number of lines", info.height)?];
    let needed = points[0].saturating_mul(points[1]).saturating_mul(size);
    let most = file.bytes()?.len().saturating_mul(LARGEST_RATIO);
    if needed > most {
        let [nx, ny] = points;
        return Err(format!("{nx} by {ny} points have {needed} bytes; a file of this size holds at most {most}"));
    }
    let text = |key: &str| info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == key);
    let number = |key: &str| {
        let parse = |text: &str| text.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(text)));
        text(key).map(|chunk| parse(chunk.text.trim())).transpose()
    };
    let unit = |key: &str| text(key).map(|chunk| chunk.text.trim().to_owned()).filter(|unit| !unit.is_empty());
    let mut map = Map { length_unit: unit("Gwy::XYUnit"), height_unit: unit("Gwy::ZUnit"), ..Map::default() };
    if let (Some(x), Some(y)) = (number("Gwy::XReal")?, number("Gwy::YReal")?) {
        let y = if points[1] == 1 { 1.0 } else { positive("Gwy::YReal", y)? };
        map.lengths = Some([positive("Gwy::XReal", x)?, y]);
    }
    let mut scale = [1.0, 0.0];
    if let (Some(low), Some(high)) = (number("Gwy::ZMin")?, number("Gwy::ZMax")?) {
        scale = [factor("the range of the heights", (high - low) / largest)?, low];
        map.notes.push(format!("the numbers 0 and {largest} are taken as Gwy::ZMin and Gwy::ZMax"));
    } else if map.lengths.is_some() {
        map.notes.push("the heights have no scale; heights and lengths are given without a unit".into());
        (map.length_unit, map.height_unit) = (None, None);
    }
    let unit = map.height_unit.clone();
    let read = move || Ok(Map { heights: heights(file, points, size, scale)?, ..map });
    Ok(Channel { name: String::new(), unit, points, read: Box::new(read) }.into())
}

/// Decodes the numbers.
fn heights(file: &File, [nx, ny]: [usize; 2], size: usize, [scale, offset]: [f64; 2]) -> Result<Array2<f64>, String> {
    let mut reader = reader(file)?;
    let length = reader.output_buffer_size().filter(|length| *length == size * nx * ny);
    let mut bytes = vec![0; length.ok_or("the image has another number of bytes than its points")?];
    reader.next_frame(&mut bytes).map_err(damaged)?;
    let mut heights = Array2::zeros((nx, ny));
    for (k, number) in bytes.chunks_exact(size).enumerate() {
        let number = number.iter().fold(0, |number, byte| number << 8 | u32::from(*byte));
        heights[[k % nx, k / nx]] = scale * f64::from(number) + offset;
    }
    Ok(heights)
}
