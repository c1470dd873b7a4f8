//! BCR (`.bcr`, `.bcrf`): an exchange format of Image Metrology (SPIP), also written by MountainsMap.
//!
//! A header of lines `key = value`, as Latin-1 or UTF-16, in a field of `headersize` characters; then 16-bit integers
//! (`bcrstm`), times `bit2nm`, or 32-bit floats (`bcrf`), line by line from the top. Undefined points have the integer
//! 32767 or a height above 1.7e38.

use super::bytes::{Bytes, Grid, Order, Sample, clip, count, factor, lines, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details};
use super::unit::Sides;

pub(crate) const FORMAT: Format = Format { name: "BCR", sniff, open, first_line: FirstLine::Top };

/// Byte order mark of little-endian UTF-16.
const UTF_16: &[u8] = &[0xff, 0xfe];

/// Number of characters of a header without `headersize`, and largest number.
const HEADER: usize = 2048;
const MOST_HEADER: usize = 1 << 20;

/// Integer of an undefined point, and height above which a point is undefined.
const VOID: f64 = 32767.0;
const HIGHEST: f64 = 1.7e38;

/// First characters of the header.
const KEY: &str = "fileformat";

fn sniff(file: &File) -> bool {
    let start = decode(&file.head()[..file.head().len().min(256)]);
    let value = start.strip_prefix(KEY).and_then(|rest| rest.trim_start().strip_prefix('='));
    value.is_some_and(|value| value.trim_start().starts_with("bcr"))
}

/// Returns true if the header has 16-bit characters, with a mark or without one.
fn is_wide(bytes: &[u8]) -> bool {
    bytes.starts_with(UTF_16) || bytes.starts_with(b"f\0i\0")
}

/// Decodes UTF-16, else Latin-1.
fn decode(bytes: &[u8]) -> String {
    if !is_wide(bytes) {
        return text(bytes);
    }
    let units = bytes.strip_prefix(UTF_16).unwrap_or(bytes).chunks_exact(2);
    let units = units.map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    char::decode_utf16(units).map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// Entries of the header.
struct Header(Vec<(String, String)>);

impl Header {
    /// Reads a text header.
    fn of(text: &str) -> Self {
        let entries = lines(text).map(str::trim).filter(|line| !line.starts_with('%'));
        let entries = entries.filter_map(|line| line.split_once('='));
        Self(entries.take(256).map(|(key, value)| (key.trim().to_lowercase(), value.trim().to_owned())).collect())
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(found, _)| found == key).map(|(_, value)| value.as_str()).filter(|value| !value.is_empty())
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<Option<T>, String> {
        let parse = |value: &str| value.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(value)));
        self.get(key).map(parse).transpose()
    }

    fn needed<T: std::str::FromStr>(&self, key: &str) -> Result<T, String> {
        self.number(key)?.ok_or_else(|| format!("the header has no {key}; it must have it"))
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let width = if is_wide(all) { 2 } else { 1 };
    // The size of the header stands in it.
    let first = Header::of(&decode(&all[..all.len().min(width * HEADER)]));
    let characters: usize = first.number("headersize")?.unwrap_or(HEADER);
    if characters > MOST_HEADER {
        return Err(format!("headersize is {characters}; it must be at most {MOST_HEADER}"));
    }
    let mut bytes = Bytes::new(all, Order::Little);
    let header = Header::of(&decode(bytes.take(width * characters)?));
    let kind = header.get(KEY).unwrap_or_default().to_owned();
    let is_integer = match kind.as_str() {
        "bcrstm" | "bcrstm_unicode" => true,
        "bcrf" | "bcrf_unicode" => false,
        _ => return Err(format!("{KEY} is {:?}; it must be bcrstm or bcrf", clip(&kind))),
    };
    let points =
        [count("xpixels", header.needed::<usize>("xpixels")?)?, count("ypixels", header.needed::<usize>("ypixels")?)?];
    let unit = |key: &str| Some(header.get(key).unwrap_or("nm").to_owned());
    let length = |axis: char| positive("the length", header.needed(&format!("{axis}length"))?);
    let along_y = if points[1] == 1 { None } else { Some((length('y')?, unit("yunit"))) };
    let mut sides = Sides::of((length('x')?, unit("xunit")), along_y)?;
    sides.notes.push("xlength and ylength are taken as n spacings; MountainsMap writes n - 1 of them".into());
    let order = match header.number("intelmode")?.unwrap_or(1) {
        0 => Order::Big,
        1 => Order::Little,
        other => return Err(format!("intelmode is {other}; it must be 0 or 1")),
    };
    let scale = if is_integer { factor("bit2nm", header.needed("bit2nm")?)? } else { 1.0 };
    let map = Map {
        lengths: Some(sides.lengths),
        length_unit: sides.unit,
        height_unit: unit("zunit"),
        details: details([("date", header.get("starttime").unwrap_or_default().to_owned())]),
        notes: sides.notes,
        ..Map::default()
    };
    let grid = Grid::lines(points, if is_integer { Sample::I16 } else { Sample::F32 }, order);
    let data = bytes.take(bytes.left())?;
    let is_void = move |found: f64| if is_integer { found == VOID } else { found > HIGHEST };
    let height = move |found| if is_void(found) { f64::NAN } else { scale * found };
    Channel::of_grid("", grid, data, map, height).map(Into::into)
}
