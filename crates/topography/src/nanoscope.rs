//! Nanoscope (`.spm`, `.000`, `.001`, ...): force microscopes of Digital Instruments, Veeco and Bruker.
//!
//! A header of lines `\Key: value` in sections `\*Section`, then 16-bit or 32-bit integers, line by line from the
//! bottom of the image. The height of an integer is `integer * hard value / 2^bits * sensitivity`; the line `\@2:Z
//! scale` of the image gives the hard value and names the sensitivity, which is in another section. Since version 9.2
//! the integers have 32 bits whatever the bytes per pixel, which then only scale them. Channels without a length per
//! volt (deflection, phase, ...) are not heights and are not listed. Versions up to 4.2, which have no `\@2:Z scale`,
//! are refused.

use std::rc::Rc;

use super::bytes::{self, Grid, Layout, MOST_CHANNELS, Order, Sample};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::unit::{self, Conversion};

pub(crate) const FORMAT: Format = Format { name: "Nanoscope", sniff, open, first_line: FirstLine::Top };

/// First version, as a hexadecimal number, with integers that always have 32 bits.
const VERSION_32_BITS: u32 = 0x0920_0000;

/// Largest number of lines of a header; instruments write some thousands.
const MOST_LINES: usize = 20_000;

/// Largest number of bytes of a header value that are read.
const LONGEST_VALUE: usize = 1000;

const SCANNER: [&str; 2] = ["scanner list", "microscope list"];
const SCAN: [&str; 4] = ["ciao scan list", "afm list", "stm list", "nc afm list"];
const IMAGE: [&str; 5] = ["ciao image list", "afm image list", "stm image list", "ncafm image list", "image list"];

fn sniff(file: &File) -> bool {
    ["\\*File list", "\\*EC File list", "?*File list", "?*EC File list"]
        .iter()
        .any(|start| file.head().get(..start.len()).is_some_and(|head| head.eq_ignore_ascii_case(start.as_bytes())))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let bytes = file.bytes()?;
    if bytes.starts_with(b"?") {
        return Err("the heights are stored as text; they must be stored as binary numbers".into());
    }
    let sections = sections(bytes)?;
    let header = Header::new(&sections)?;
    let (mut channels, mut others, mut aliases) = (vec![], vec![], vec![]);
    for section in sections.iter().filter(|section| IMAGE.contains(&section.name.as_str())) {
        if is_empty(section) {
            others.push(format!("{} without points", name(section)));
            continue;
        }
        let image = Image::new(section, &header)?;
        match image.height(&header)? {
            Some(height) => {
                let shown = shown_name(section).filter(|shown| !shown.eq_ignore_ascii_case(&image.name));
                aliases.extend(shown.map(|shown| (channels.len(), shown)));
                channels.push(image.channel(height, &header, bytes)?);
            }
            None => others.push(image.name),
        }
        if channels.len() + others.len() > MOST_CHANNELS {
            return Err(format!("the file has more than {MOST_CHANNELS} images; it must have fewer"));
        }
    }
    if channels.is_empty() {
        let found = if others.is_empty() { "no image".to_owned() } else { format!("only {}", others.join(", ")) };
        return Err(format!("the file has {found}; it must have an image with a length per volt"));
    }
    Ok(Contents { aliases, ..channels.into() })
}

/// Returns true for an image that was not recorded.
fn is_empty(section: &Section) -> bool {
    let first = |key: &str| section.get(key)?.split_whitespace().next()?.parse::<usize>().ok();
    first("samps/line") == Some(0) || first("number of lines") == Some(0)
}

/// Section of the header: its name and its lines as key and value, with the name in lower case.
struct Section<'a> {
    name: String,
    lines: Vec<(&'a [u8], &'a [u8])>,
}

impl Section<'_> {
    /// Returns the value of the last line with this key.
    fn get(&self, key: &str) -> Option<String> {
        let found = self.lines.iter().rev().find(|(name, _)| name.eq_ignore_ascii_case(key.as_bytes()));
        found.map(|(_, value)| bytes::text(&value[..value.len().min(LONGEST_VALUE)]))
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, String> {
        let text =
            self.get(key).ok_or_else(|| format!("section {:?} has no line {key:?}; it must have one", self.name))?;
        text.parse().map_err(|_| format!("{key:?} is {text:?}; it must be a number"))
    }
}

/// Splits the header into its sections.
fn sections(bytes: &[u8]) -> Result<Vec<Section<'_>>, String> {
    let mut sections: Vec<Section> = vec![];
    for line in bytes.split(|&byte| byte == b'\n').take(MOST_LINES) {
        let line = line.trim_ascii();
        let Some(content) = line.strip_prefix(b"\\") else {
            if line.is_empty() {
                break;
            }
            return Err("a line of the header does not start with a backslash; each line must".into());
        };
        if let Some(name) = content.strip_prefix(b"*") {
            let name = bytes::text(&name[..name.len().min(LONGEST_VALUE)]).to_lowercase();
            if name == "file list end" {
                break;
            }
            sections.push(Section { name, lines: vec![] });
        } else if let Some(section) = sections.last_mut() {
            let colon = content.windows(2).position(|pair| pair == b": ");
            let (key, value) = colon.map_or((content, &[][..]), |at| (&content[..at], &content[at + 2..]));
            section.lines.push((key, value));
        }
    }
    Ok(sections)
}

/// Sections that apply to all images.
struct Header<'a> {
    scanner: Vec<&'a Section<'a>>,
    scan: Vec<&'a Section<'a>>,
    version: u32,
    /// Number of points of a line and number of lines of the whole scan.
    points: Option<[usize; 2]>,
    /// Size along the fast and slow axes and its unit, in files that store the slow axis separately.
    sizes: Option<([f64; 2], String)>,
    details: Rc<[(String, String)]>,
}

/// Returns the value of a key in the last of the sections that has it.
fn find(sections: &[&Section], key: &str) -> Option<String> {
    sections.iter().rev().find_map(|section| section.get(key))
}

impl<'a> Header<'a> {
    fn new(sections: &'a [Section<'a>]) -> Result<Self, String> {
        let named = |names: &[&str]| sections.iter().filter(|s| names.contains(&s.name.as_str())).collect::<Vec<_>>();
        let files = named(&["file list", "ec file list"]);
        let (scanner, scan, equipment) = (named(&SCANNER), named(&SCAN), named(&["equipment list"]));
        let mode = find(&sections.iter().collect::<Vec<_>>(), "operating mode").unwrap_or_default();
        let start = find(&files, "start context").unwrap_or_default();
        if mode == "Force" || start == "FOL" {
            return Err("the file holds force curves; it must hold images".into());
        }
        if start.ends_with("VAR") && mode != "Force Volume" {
            return Err("the file holds unevenly spaced profiles; it must hold images".into());
        }
        let count = |key: &str| find(&scan, key)?.parse().ok();
        let sizes = match (find(&scan, "scan size"), find(&scan, "slow axis size")) {
            (Some(fast), Some(slow)) => {
                let ((fast, unit), (slow, slow_unit)) = (quantity(&fast)?, quantity(&slow)?);
                Some(([fast, convert(slow, &slow_unit, &unit)?], unit))
            }
            _ => None,
        };
        let mut details = vec![];
        let mut detail = |name: &str, value: Option<String>| {
            details.extend(value.filter(|value| !value.is_empty()).map(|value| (name.to_owned(), value)));
        };
        let software = find(&files, "version");
        let version = software.as_deref().map_or(Ok(0), |text| {
            let number = u32::from_str_radix(text.trim_start_matches("0x"), 16);
            number.map_err(|_| format!("the version is {text:?}; it must be a hexadecimal number"))
        })?;
        detail("instrument", find(&equipment, "microscope").or_else(|| find(&equipment, "description")));
        detail("scanner", find(&scanner, "serial number").or_else(|| find(&scan, "serial number")));
        detail("software", software);
        detail("date", find(&files, "date"));
        detail("operating mode", Some(mode));
        Ok(Self {
            version,
            points: count("samps/line").zip(count("lines")).map(|(x, y)| [x, y]),
            scanner,
            scan,
            sizes,
            details: details.into(),
        })
    }
}

/// Image: position and meaning of its integers.
struct Image<'a> {
    section: &'a Section<'a>,
    name: String,
    grid: Grid,
    start: usize,
    sizes: [f64; 2],
    unit: String,
    bytes_per_pixel: i32,
}

impl<'a> Image<'a> {
    fn new(section: &'a Section<'a>, header: &Header) -> Result<Self, String> {
        let mut points: [usize; 2] = [section.number("samps/line")?, section.number("number of lines")?];
        let (mut sizes, mut unit) = scan_size(&section.get("scan size").unwrap_or_default())?;
        if let Some((both, its_unit)) = &header.sizes {
            (sizes, unit) = (*both, its_unit.clone());
        }
        let length: usize = section.number("data length")?;
        let bytes_per_pixel = section.get("bytes/pixel").map_or(Ok(2), |_| section.number::<i32>("bytes/pixel"))?;
        let mut sample = match bytes_per_pixel {
            2 => Sample::I16,
            4 => Sample::I32,
            other => return Err(format!("a pixel has {other} bytes; it must have 2 or 4")),
        };
        let bytes = |[nx, ny]: [usize; 2], size: usize| nx.saturating_mul(ny).saturating_mul(size);
        if header.version >= VERSION_32_BITS && length >= bytes(points, 4) {
            sample = Sample::I32;
        }
        // Some images give a wrong number of points; the number of the whole scan is correct if it fits the data.
        let (own, size) = (bytes(points, sample.size()), sample.size());
        let whole = header.points.filter(|&whole| {
            length != own && (length == bytes(whole, size) || (own > length && length >= bytes(whole, size)))
        });
        if let Some(whole) = whole {
            if header.sizes.is_none() {
                sizes = [0, 1].map(|axis| sizes[axis] * (whole[axis] as f64 / points[axis] as f64));
            }
            points = whole;
        } else if let (Some(_), true, Some([_, lines])) = (&header.sizes, is_stretched(section), header.points) {
            // The scan was stopped early, but the size is given for the whole scan.
            if points[1] < lines {
                sizes[1] *= points[1] as f64 / lines as f64;
            }
        }
        if bytes(points, size) > length {
            let [nx, ny] = points;
            return Err(format!("the image of {nx} by {ny} points has {length} bytes; it must have {size} for each"));
        }
        Ok(Self {
            section,
            name: name(section),
            grid: Grid { points, sample, order: Order::Little, layout: Layout::Lines, backwards: [false, true] },
            start: section.number("data offset")?,
            sizes,
            unit,
            bytes_per_pixel,
        })
    }

    /// Returns the height of one unit of the integers and its unit of length; `None` if the image is not a height.
    fn height(&self, header: &Header) -> Result<Option<(f64, String)>, String> {
        let Some(scale) = self.section.get("@4:z scale").or_else(|| self.section.get("@2:z scale")) else {
            return Err("the image has no line \"@2:Z scale\"; it must have one, as in versions after 4.2".into());
        };
        let scale = Value::parse(&scale)?;
        let Some(key) = scale.soft else { return Ok(None) };
        let key = format!("@{key}");
        let Some(sensitivity) = find(&header.scanner, &key).or_else(|| find(&header.scan, &key)) else {
            return Ok(None);
        };
        let (sensitivity, units) = quantity(Value::parse(&sensitivity)?.rest)?;
        let Some((length, per)) = units.split_once('/') else { return Ok(None) };
        let length = angstrom(length.trim());
        if !unit::is_length(&length) {
            return Ok(None);
        }
        let (hard, hard_unit) = quantity(scale.rest)?;
        let (Some(from), Some(to)) = (volts(&hard_unit), volts(per.trim())) else {
            if hard_unit == per.trim() {
                return Ok(Some((hard / 256_f64.powi(self.bytes_per_pixel) * sensitivity, length)));
            }
            return Err(format!("the Z scale is in {hard_unit:?}, its sensitivity per {per:?}; they must agree"));
        };
        let factor = if from == to { 1.0 } else { 10_f64.powi(from - to) };
        Ok(Some((hard / 256_f64.powi(self.bytes_per_pixel) * factor * sensitivity, length)))
    }

    fn channel<'b>(
        self,
        (scale, height_unit): (f64, String),
        header: &Header,
        bytes: &'b [u8],
    ) -> Result<Channel<'b>, String> {
        let data = bytes.get(self.start..).unwrap_or_default();
        let needed = self.grid.bytes()?;
        if data.len() < needed {
            return Err(format!("the image {} has {} bytes; it must have {needed}", self.name, data.len()));
        }
        let (grid, details) = (self.grid, header.details.clone());
        let (lengths, length_unit) = (self.sizes, self.unit);
        let unit = height_unit.clone();
        let read = move || {
            Ok(Map {
                heights: grid.read(data, |integer| scale * integer)?,
                lengths: Some(if grid.points[1] == 1 { [lengths[0], 1.0] } else { lengths }),
                length_unit: Some(length_unit),
                height_unit: Some(height_unit),
                details: details.to_vec(),
                ..Map::default()
            })
        };
        Ok(Channel { name: self.name, unit: Some(unit), points: grid.points, read: Box::new(read) })
    }
}

/// Value such as `V [Sens. Zsens] (0.006713867 V/LSB) 2.910461 V`.
struct Value<'a> {
    /// Name of the soft scale, in square brackets.
    soft: Option<&'a str>,
    /// Text after the brackets and the parentheses; the name of an image includes its quotation marks.
    rest: &'a str,
}

impl<'a> Value<'a> {
    fn parse(text: &'a str) -> Result<Self, String> {
        let fail =
            || format!("a value of the header is {text:?}; it must have the form V [scale] (number unit) number unit");
        let mut characters = text.trim().chars();
        characters.next().ok_or_else(fail)?;
        let mut rest = characters.as_str().trim();
        let mut soft = None;
        if let Some(inside) = rest.strip_prefix('[') {
            let (name, after) = inside.split_once(']').ok_or_else(fail)?;
            soft = Some(name.trim()).filter(|name| !name.is_empty());
            rest = after.trim();
        }
        if rest.starts_with('(') {
            // The unit in parentheses can contain parentheses: log(Pa).
            let mut level = 0_usize;
            let close = rest.bytes().position(|byte| {
                match byte {
                    b'(' => level += 1,
                    b')' => level -= 1,
                    _ => (),
                }
                level == 0
            });
            rest = rest[close.ok_or_else(fail)? + 1..].trim();
        }
        Ok(Self { soft, rest })
    }
}

/// Returns the value with the names of the channel.
fn image_data(section: &Section) -> Option<String> {
    ["@2:image data", "@3:image data", "@4:image data"].into_iter().find_map(|key| section.get(key))
}

/// Returns the name shown by the instrument software, in quotation marks in the file.
fn shown_name(section: &Section) -> Option<String> {
    let value = image_data(section)?;
    let shown = Value::parse(&value).ok()?.rest.trim_matches('"').trim().to_owned();
    Some(shown).filter(|shown| !shown.is_empty())
}

/// Returns the name of the channel: in brackets, or else in quotation marks.
fn name(section: &Section) -> String {
    match &image_data(section) {
        Some(value) => match Value::parse(value) {
            Ok(Value { soft: Some(name), .. }) => name.to_owned(),
            Ok(Value { rest, .. }) => rest.trim_matches('"').to_owned(),
            Err(_) => String::new(),
        },
        None => section.get("image data").unwrap_or_default(),
    }
}

/// Splits `2.910461 V` into number and unit.
fn quantity(text: &str) -> Result<(f64, String), String> {
    let text = text.trim();
    let (number, unit) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let value =
        number.parse().map_err(|_| format!("a value of the header is {text:?}; it must be a number and a unit"))?;
    Ok((value, angstrom(unit.trim())))
}

/// Reads a scan size: one number for a square or two, and the unit.
fn scan_size(text: &str) -> Result<([f64; 2], String), String> {
    let mut words = text.split_whitespace();
    let mut next = || words.next().unwrap_or_default();
    let first = next();
    let x =
        first.parse().map_err(|_| format!("the scan size is {text:?}; it must be one or two numbers and a unit"))?;
    let second = next();
    Ok(match second.parse() {
        Ok(y) => ([x, y], angstrom(next())),
        Err(_) => ([x, x], angstrom(second)),
    })
}

/// Returns the unit, with the letter A, which means ångström here, replaced by Å.
fn angstrom(unit: &str) -> String {
    if unit == "A" { "Å".into() } else { unit.into() }
}

fn convert(value: f64, from: &str, to: &str) -> Result<f64, String> {
    Ok(Conversion::between(from, to)?.map_or(value, |conversion| conversion.apply(value)))
}

/// Returns the power of ten of a unit of voltage.
fn volts(unit: &str) -> Option<i32> {
    let prefix = unit.strip_suffix('V')?;
    [("", 0), ("k", 3), ("M", 6), ("G", 9), ("m", -3), ("µ", -6), ("u", -6), ("n", -9), ("p", -12), ("f", -15)]
        .into_iter()
        .find_map(|(name, power)| (name == prefix).then_some(power))
}

/// Returns true if the image has an aspect ratio other than 1.
fn is_stretched(section: &Section) -> bool {
    let ratio = section.get("aspect ratio").and_then(|text| text.split(':').next()?.trim().parse::<f64>().ok());
    ratio.is_some_and(|ratio| ratio > 0.0 && ratio != 1.0)
}
