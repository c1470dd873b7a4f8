//! X3P of ISO 25178-72: a zip archive of `main.xml`, binary heights, and the validity of points.
//!
//! Heights and spacings are in metres; the size is the number of points times the increment. Heights are increment
//! times number plus offset; whole numbers have a sign (`I` 16 bits, `L` 32 bits), as in the openGPS library of the
//! format's authors; they must have an increment, and so must both axes, while floats without one are heights in
//! metres. Validity has one bit per point, the lowest bit of a byte first. The first row of the file is at j = 0; its y
//! axis points up.

use std::io::Read;

use roxmltree::Node;

use super::bytes::{Grid, Layout, Order, Sample, clip, count, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::zipped::{Zip, xml};

pub(crate) const FORMAT: Format =
    Format { name: "X3P", sniff: |file| Zip::has(file, &["main.xml"]), open, first_line: FirstLine::Bottom };

/// Parts of the document that describe the measurement.
const DETAILS: [&str; 9] = [
    "Date",
    "Creator",
    "Instrument/Manufacturer",
    "Instrument/Model",
    "Instrument/Serial",
    "Instrument/Version",
    "CalibrationDate",
    "ProbingSystem/Identification",
    "Comment",
];

fn open(file: &File) -> Result<Contents<'_>, String> {
    let text = Zip::open(file)?.text("main.xml")?;
    let document = xml("main.xml", &text)?;
    let header = Header::parse(document.root_element())?;
    let points = header.grid.points;
    let read = Box::new(move || header.read(file));
    Ok(Channel { name: String::new(), unit: Some("m".into()), points, read }.into())
}

struct Header {
    grid: Grid,
    spacing: [f64; 2],
    /// Increment and offset of the heights.
    scale: [f64; 2],
    heights: Entry,
    validity: Option<Entry>,
    details: Vec<(String, String)>,
}

/// An entry of the archive with its MD5 checksum.
struct Entry {
    name: String,
    checksum: Option<String>,
}

impl Header {
    fn parse(root: Node) -> Result<Self, String> {
        let text = |path: &str| at(root, path).and_then(|node| node.text()).map(|text| text.trim().to_owned());
        let needed = |path: &str| text(path).ok_or_else(|| format!("main.xml has no {path}; it must have one"));
        let number = |path: &str, default: f64| match text(path) {
            None => Ok(default),
            Some(found) => {
                found.parse::<f64>().map_err(|_| format!("{path} is {:?}; it must be a number", clip(&found)))
            }
        };
        let is = |path: &str, allowed: &[&str]| {
            let found = needed(path)?;
            match allowed.contains(&found.as_str()) {
                true => Ok(found),
                false => Err(format!("{path} is {:?}; it must be {}", clip(&found), allowed.join(" or "))),
            }
        };
        is("Record1/FeatureType", &["SUR", "PRF"])?;
        is("Record1/Axes/CX/AxisType", &["I"])?;
        if at(root, "Record1/Axes/CY/AxisType").is_some() {
            is("Record1/Axes/CY/AxisType", &["I"])?;
        }
        is("Record1/Axes/CZ/AxisType", &["A"])?;
        let sample = match is("Record1/Axes/CZ/DataType", &["I", "L", "F", "D"])?.as_str() {
            "I" => Sample::I16,
            "L" => Sample::I32,
            "F" => Sample::F32,
            _ => Sample::F64,
        };
        let size = |axis: &str| {
            let path = format!("Record3/MatrixDimension/{axis}");
            let found = needed(&path)?;
            let value =
                found.parse::<u64>().map_err(|_| format!("{path} is {:?}; it must be a number", clip(&found)))?;
            count(&path, value)
        };
        let points = [size("SizeX")?, size("SizeY")?];
        if size("SizeZ")? != 1 {
            return Err(format!("SizeZ is {}; it must be 1, a height map", size("SizeZ")?));
        }
        // Without an increment the spacing is unknown; the axes are incremental ones, which must have it.
        let spacing = |axis: &str| {
            let path = format!("Record1/Axes/{axis}/Increment");
            needed(&path)?;
            number(&path, f64::NAN).and_then(|value| positive(&path, value))
        };
        let spacing = [spacing("CX")?, if points[1] == 1 { 1.0 } else { spacing("CY")? }];
        if matches!(sample, Sample::I16 | Sample::I32) {
            needed("Record1/Axes/CZ/Increment")?;
        }
        let details = DETAILS.iter().filter_map(|path| {
            let value = text(&format!("Record2/{path}")).filter(|value| !value.is_empty())?;
            Some((path.rsplit('/').next().unwrap_or(path).to_owned(), value))
        });
        let link = |name: &str, checksum: &str| {
            let name = text(&format!("Record3/DataLink/{name}"))?;
            Some(Entry { name, checksum: text(&format!("Record3/DataLink/{checksum}")) })
        };
        Ok(Self {
            grid: Grid { points, sample, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] },
            spacing,
            scale: [number("Record1/Axes/CZ/Increment", 1.0)?, number("Record1/Axes/CZ/Offset", 0.0)?],
            heights: link("PointDataLink", "MD5ChecksumPointData")
                .ok_or("main.xml names no binary file of heights (Record3/DataLink/PointDataLink); it must name one")?,
            validity: link("ValidPointsLink", "MD5ChecksumValidPoints").filter(|entry| !entry.name.is_empty()),
            details: details.collect(),
        })
    }

    fn read(self, file: &File) -> Result<Map, String> {
        let Self { grid, spacing, scale: [increment, offset], heights: entry, validity, details } = self;
        let [nx, ny] = grid.points;
        let mut zip = Zip::open(file)?;
        let mut notes = Vec::new();
        let (mut heights, sum) = {
            let (stream, compressed) = zip.stream(&entry.name)?;
            let mut stream = Summed { stream, sum: md5::Context::new() };
            let heights = grid.inflate(compressed, &mut stream, |z| z * increment + offset)?;
            (heights, stream.sum)
        };
        entry.compare(sum, &mut notes);
        if let Some(entry) = validity {
            let bits = zip.read(&entry.name, (nx * ny).div_ceil(8) as u64)?;
            if bits.len() < (nx * ny).div_ceil(8) {
                return Err(format!(
                    "{} has {} bytes; it must have {}, one bit per point",
                    entry.name,
                    bits.len(),
                    (nx * ny).div_ceil(8)
                ));
            }
            for ((i, j), height) in heights.indexed_iter_mut() {
                let point = j * nx + i;
                if bits[point / 8] >> (point % 8) & 1 == 0 {
                    *height = f64::NAN;
                }
            }
            let mut sum = md5::Context::new();
            sum.consume(&bits);
            entry.compare(sum, &mut notes);
        }
        let metre = || Some("m".to_owned());
        let lengths = [nx as f64 * spacing[0], ny as f64 * spacing[1]];
        Ok(Map { heights, lengths: Some(lengths), length_unit: metre(), height_unit: metre(), details, notes })
    }
}

impl Entry {
    /// Notes a wrong checksum. The checksum of the archive was right, so that the heights are as written.
    fn compare(&self, sum: md5::Context, notes: &mut Vec<String>) {
        let found = format!("{:x}", sum.finalize());
        if let Some(expected) = self.checksum.as_ref().filter(|expected| !expected.eq_ignore_ascii_case(&found)) {
            notes.push(format!("the MD5 checksum of {} is {found}, but main.xml has {}", self.name, clip(expected)));
        }
    }
}

/// A stream with the checksum of what was read.
struct Summed<R> {
    stream: R,
    sum: md5::Context,
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.stream.read(buffer)?;
        self.sum.consume(&buffer[..count]);
        Ok(count)
    }
}

/// The element at a path of names below `root`.
fn at<'a, 'input>(root: Node<'a, 'input>, path: &str) -> Option<Node<'a, 'input>> {
    path.split('/').try_fold(root, |node, name| node.children().find(|child| child.has_tag_name(name)))
}
