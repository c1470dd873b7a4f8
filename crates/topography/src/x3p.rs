//! X3P of ISO 25178-72: a zip archive of `main.xml`, binary heights, and the validity of points.
//!
//! Heights and spacings are in metres; the size is the number of points times the increment. Heights are increment
//! times number plus offset. Whole numbers are signed (`I` 16 bits, `L` 32 bits), as in the openGPS library of the
//! format's authors. They must have an increment, and so must both axes, while floats without an increment are heights
//! in metres. Validity has one bit per point, the lowest bit of a byte first. The first row of the file is at j = 0;
//! its y axis points up.
//!
//! Wrong MD5 checksums of `main.xml` (in `md5checksum.hex`) and of the binary entries (in `main.xml`) give warnings.
//!
//! Names of entries may differ from those in `main.xml` in case and slashes, and all may be in one folder. Instead of a
//! binary entry, `main.xml` itself may list the heights: one number per point, none for an undefined point.

use std::io::{BufRead, BufReader, Read};

use roxmltree::Node;

use ndarray::Array2;

use super::bytes::{Grid, Layout, Order, Sample, clip, count, positive};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::zipped::{MOST_TEXT, Zip, plain, xml};

pub(crate) const FORMAT: Format = Format { name: "X3P", sniff, open, first_line: FirstLine::Bottom };

/// Entry that describes the others.
const MAIN: &str = "main.xml";

/// Entry with the MD5 checksum of the description, as written by `md5sum`.
const SUM: &str = "md5checksum.hex";

/// Number of characters of an MD5 checksum.
const SUM_DIGITS: usize = 32;

/// Element of heights in the description.
const LIST: &str = "DataList";

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

fn sniff(file: &File) -> bool {
    file.starts_with(b"PK") && Zip::open(file).is_ok_and(|zip| !mains(&zip).is_empty())
}

/// Returns the entries named `main.xml` in the outermost folder that has one.
fn mains(zip: &Zip) -> Vec<String> {
    let depth = |name: &str| plain(name).matches('/').count();
    let mut found = zip.names();
    found.retain(|name| plain(name).rsplit('/').next() == Some(MAIN));
    let least = found.iter().map(|name| depth(name)).min();
    found.retain(|name| Some(depth(name)) == least);
    found
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut zip = Zip::open(file)?;
    let main = match &mains(&zip)[..] {
        [main] => main.clone(),
        several => return Err(format!("the archive has {}; it must have one {MAIN}", several.join(", "))),
    };
    let mut kept = Vec::new();
    let mut sum = md5::Context::new();
    pieces(&mut zip, &main, |piece, in_list| {
        sum.consume(piece);
        if !in_list {
            kept.extend_from_slice(piece);
        }
        match kept.len() as u64 > MOST_TEXT {
            true => Err(format!("the entry {main} has more than {MOST_TEXT} bytes beside its heights")),
            false => Ok(()),
        }
    })?;
    let warnings = doubt(&mut zip, &main, sum).into_iter().collect();
    let text = String::from_utf8(kept).map_err(|_| format!("the entry {main} is not text in UTF-8"))?;
    let document = xml(&main, &text)?;
    let header = Header::parse(document.root_element(), main)?;
    let points = header.grid.points;
    let read = Box::new(move || header.read(file));
    let channel = Channel { name: String::new(), unit: Some("m".into()), points, read };
    Ok(Contents { warnings, ..channel.into() })
}

/// Returns a warning if the archive has another checksum of its description.
fn doubt(zip: &mut Zip, main: &str, sum: md5::Context) -> Option<String> {
    let name = zip.meant(&beside(main, SUM))?;
    let text = zip.text(&name).unwrap_or_default();
    let expected = text.split_whitespace().next().unwrap_or_default();
    let is_sum = expected.len() == SUM_DIGITS && expected.bytes().all(|byte| byte.is_ascii_hexdigit());
    match is_sum {
        true => different(main, &name, expected, sum),
        false => Some(format!("{name} begins with {:?}; it must be the MD5 checksum of {main}", clip(expected))),
    }
}

/// Returns a warning if the checksum of the entry `name` differs from the one in another entry.
fn different(name: &str, of: &str, expected: &str, sum: md5::Context) -> Option<String> {
    let found = format!("{:x}", sum.finalize());
    (!expected.eq_ignore_ascii_case(&found)).then(|| {
        let expected = clip(expected);
        format!("the MD5 checksum of {name} is {found}, but {of} has {expected}; one of them was changed")
    })
}

/// Returns the path of an entry in the folder of the description.
fn beside(main: &str, name: &str) -> String {
    let folder = main.rsplit_once(['/', '\\']).map_or("", |(folder, _)| folder);
    format!("{folder}/{name}")
}

/// Calls `each` for the pieces of an XML entry that end with `<`; the flag is true inside the list of heights.
fn pieces(zip: &mut Zip, main: &str, mut each: impl FnMut(&[u8], bool) -> Result<(), String>) -> Result<(), String> {
    let mut stream = BufReader::new(zip.stream(main)?.0);
    let (mut piece, mut in_list) = (Vec::new(), false);
    loop {
        piece.clear();
        let read = stream.by_ref().take(MOST_TEXT).read_until(b'<', &mut piece);
        if read.map_err(|error| format!("the entry {main}: {error}"))? == 0 {
            return Ok(());
        }
        in_list &= !is_tag(&piece, &format!("/{LIST}"));
        each(&piece, in_list)?;
        in_list |= is_tag(&piece, LIST);
    }
}

/// Returns true if a piece begins with the tag of an element of this name, with any prefix.
fn is_tag(piece: &[u8], name: &str) -> bool {
    let Some(tag) = piece.iter().position(|byte| *byte == b'>').map(|end| piece[..end].trim_ascii_end()) else {
        return false;
    };
    let (slash, tag) = match tag.strip_prefix(b"/") {
        Some(tag) => ("/", tag),
        None => ("", tag),
    };
    let local = tag.iter().rposition(|byte| *byte == b':').map_or(tag, |colon| &tag[colon + 1..]);
    name.strip_prefix(slash).is_some_and(|name| name.as_bytes() == local)
}

struct Header {
    grid: Grid,
    spacing: [f64; 2],
    /// Increment and offset of the heights.
    scale: [f64; 2],
    /// Entry that describes the others.
    main: String,
    /// Entry of heights; `None` if the description lists them.
    heights: Option<Entry>,
    validity: Option<Entry>,
    details: Vec<(String, String)>,
}

/// Entry of the archive with its MD5 checksum.
struct Entry {
    name: String,
    checksum: Option<String>,
}

impl Header {
    fn parse(root: Node, main: String) -> Result<Self, String> {
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
        // Without an increment the spacing is unknown; incremental axes must have one.
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
        let heights = link("PointDataLink", "MD5ChecksumPointData").filter(|entry| !entry.name.is_empty());
        if heights.is_some() == at(root, &format!("Record3/{LIST}")).is_some() {
            return Err(format!(
                "main.xml must have either Record3/DataLink/PointDataLink, which names a file of heights, or \
                 Record3/{LIST}, which has them"
            ));
        }
        Ok(Self {
            grid: Grid { points, sample, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] },
            spacing,
            scale: [number("Record1/Axes/CZ/Increment", 1.0)?, number("Record1/Axes/CZ/Offset", 0.0)?],
            heights,
            main,
            validity: link("ValidPointsLink", "MD5ChecksumValidPoints").filter(|entry| !entry.name.is_empty()),
            details: details.collect(),
        })
    }

    fn read(self, file: &File) -> Result<Map, String> {
        let Self { grid, spacing, scale: [increment, offset], main, heights: link, validity, details } = self;
        let [nx, ny] = grid.points;
        let mut zip = Zip::open(file)?;
        let mut warnings = Vec::new();
        let named = |zip: &Zip, name: &str| {
            let beside = zip.meant(&beside(&main, name));
            beside
                .or_else(|| zip.meant(name))
                .ok_or_else(|| format!("the archive has no entry {name}; {main} names it"))
        };
        let height = |z: f64| z * increment + offset;
        let mut heights = match &link {
            Some(entry) => {
                let name = named(&zip, &entry.name)?;
                let (stream, compressed) = zip.stream(&name)?;
                let mut stream = Summed { stream, sum: md5::Context::new() };
                let heights = grid.inflate(compressed, &mut stream, height)?;
                warnings.extend(entry.doubt(stream.sum));
                heights
            }
            None => listed(&mut zip, &main, grid.points)?.mapv_into(height),
        };
        if let Some(entry) = validity {
            let name = named(&zip, &entry.name)?;
            let bits = zip.read(&name, (nx * ny).div_ceil(8) as u64)?;
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
            warnings.extend(entry.doubt(sum));
        }
        let metre = || Some("m".to_owned());
        let lengths = [nx as f64 * spacing[0], ny as f64 * spacing[1]];
        let lengths = Some(lengths);
        Ok(Map { heights, lengths, length_unit: metre(), height_unit: metre(), details, warnings, ..Map::default() })
    }
}

impl Entry {
    /// Returns a warning if the checksum is wrong.
    fn doubt(&self, sum: md5::Context) -> Option<String> {
        different(&self.name, MAIN, self.checksum.as_deref().filter(|expected| !expected.is_empty())?, sum)
    }
}

/// Reads the heights `[x, y]` in the list of the description, with a `Datum` for each point, empty if undefined.
fn listed(zip: &mut Zip, main: &str, [nx, ny]: [usize; 2]) -> Result<Array2<f64>, String> {
    // A Datum has at least eight characters, and deflate expands a byte to at most 1032.
    let most = zip.stream(main)?.1.saturating_mul(129);
    if nx.saturating_mul(ny) > most {
        return Err(format!("the grid has {nx} by {ny} points; {main} lists at most {most} of them"));
    }
    let mut heights = Vec::with_capacity(nx * ny);
    pieces(zip, main, |piece, in_list| {
        let datum = |piece: &[u8]| is_tag(piece, "Datum") || is_tag(piece, "Datum/") || is_tag(piece, "Datum /");
        if !in_list || !datum(piece) {
            return Ok(());
        }
        let end = piece.iter().position(|byte| *byte == b'>').unwrap_or(piece.len() - 1);
        let text = String::from_utf8_lossy(&piece[end + 1..]);
        let text = text.trim_end_matches('<').trim();
        let number = if text.is_empty() { Ok(f64::NAN) } else { text.parse() };
        let number =
            number.map_err(|_| format!("a Datum of {main} is {:?}; it must be a number or empty", clip(text)))?;
        if heights.len() == nx * ny {
            return Err(format!("{main} lists more than {nx} by {ny} heights; it must list so many"));
        }
        heights.push(number);
        Ok(())
    })?;
    let count = heights.len();
    let heights = Array2::from_shape_vec((ny, nx), heights);
    let heights = heights.map_err(|_| format!("{main} lists {count} heights; it must list {nx} by {ny}"))?;
    Ok(heights.reversed_axes())
}

/// Stream with a checksum of the bytes read.
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

/// Returns the element at a path of names below `root`.
fn at<'a, 'input>(root: Node<'a, 'input>, path: &str) -> Option<Node<'a, 'input>> {
    path.split('/').try_fold(root, |node, name| node.children().find(|child| child.has_tag_name(name)))
}
