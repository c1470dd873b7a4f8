//! Olympus OIR (`.oir`, `.poir`): confocal microscopes of Olympus, Evident. Numbers are little-endian.
//!
//! Chunks with their lengths and types: blocks with the properties as XML, and the names of images with the bytes that
//! follow them. The properties name the channel with heights, the size of a pixel and the height of a count; the image
//! with the name of the channel has its counts, the top line first. An archive (`.poir`) has several such files.

use std::borrow::Cow;
use std::rc::Rc;

use roxmltree::Node;

use super::bytes::{Bytes, Grid, MOST_CHANNELS, Order, Sample, clip, count, factor, find, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use super::unit::{Sides, is_length};
use super::zipped::{Zip, xml};

pub(crate) const FORMAT: Format = Format { name: "Olympus OIR", sniff, open, first_line: FirstLine::Top };

const MAGIC: &[u8] = b"OLYMPUSRAWFORMAT";

/// Length of the head of a file.
const HEAD: usize = 96;

/// Types of chunks: a list of blocks, one block, an image, the end.
const BLOCKS: i32 = 0;
const BLOCK: i32 = 1;
const IMAGE: i32 = 3;
const LAST: i32 = -1;

/// Numbers of bytes of the head of a block after its kind, and of the largest properties.
const BLOCK_HEAD: usize = 32;
const MOST_PROPERTIES: usize = 1 << 20;

fn sniff(file: &File) -> bool {
    let is_archive = || file.starts_with(b"PK") && Zip::open(file).is_ok_and(|zip| member(&zip).is_some());
    file.starts_with(MAGIC) || is_archive()
}

/// Returns the name of the first file in an archive.
fn member(zip: &Zip) -> Option<String> {
    zip.names().into_iter().find(|name| name.to_lowercase().ends_with(".oir"))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    if file.starts_with(MAGIC) {
        return channels(Cow::Borrowed(file.bytes()?)).map(Into::into);
    }
    let mut zip = Zip::open(file)?;
    let names: Vec<String> = zip.names().into_iter().filter(|name| name.to_lowercase().ends_with(".oir")).collect();
    let (mut found, mut refused) = (Vec::new(), None);
    for name in names.iter().take(MOST_CHANNELS) {
        match zip.whole(name).and_then(|bytes| channels(Cow::Owned(bytes))) {
            Ok(channels) if names.len() > 1 => {
                found.extend(
                    channels.into_iter().map(|channel| Channel { name: format!("{name}/{}", channel.name), ..channel }),
                );
            }
            Ok(channels) => found.extend(channels),
            // Images of the camera have no heights.
            Err(error) => refused = refused.or(Some(format!("{name}: {error}"))),
        }
    }
    match refused {
        Some(error) if found.is_empty() => Err(error),
        _ => Ok(found.into()),
    }
}

/// Bytes of an image within a file that several channels share.
struct Part<'a> {
    whole: Rc<Cow<'a, [u8]>>,
    range: std::ops::Range<usize>,
}

impl AsRef<[u8]> for Part<'_> {
    fn as_ref(&self) -> &[u8] {
        &self.whole[self.range.clone()]
    }
}

/// Image: its name and the place of its bytes.
type Image = (String, std::ops::Range<usize>);

/// Reads the chunks of a file. Returns the images and the properties.
fn chunks(all: &[u8]) -> Result<(Vec<Image>, String), String> {
    let mut bytes = Bytes::new(all, Order::Little);
    bytes.seek(HEAD)?;
    let (mut images, mut properties) = (Vec::new(), None);
    while bytes.left() >= 8 {
        let (length, kind) = (bytes.i32()?, bytes.i32()?);
        if kind == LAST || length == LAST {
            break;
        }
        let length =
            usize::try_from(length).map_err(|_| format!("a chunk has {length} bytes; it must have 0 or more"))?;
        let mut chunk = Bytes::new(bytes.take(length)?, Order::Little);
        match kind {
            IMAGE if images.len() < MOST_CHANNELS => {
                chunk.skip(8)?;
                let name = chunk.u32()? as usize;
                let name = chunk.text(name)?;
                let length = bytes.u32()? as usize;
                bytes.skip(4)?;
                let start = bytes.at();
                bytes.skip(length)?;
                images.push((name, start..bytes.at()));
            }
            BLOCKS | BLOCK => {
                let found = image_properties(chunk.take(length)?);
                properties = properties.or(found);
            }
            _ => {}
        }
    }
    let properties = properties.ok_or("the file has no properties of an image; it must have them")?;
    Ok((images, properties))
}

/// Returns the properties of the image in blocks, if they have them: a length, and XML.
fn image_properties(blocks: &[u8]) -> Option<String> {
    let at = find(blocks, b"imageProperties")?;
    let start = blocks[..at].windows(2).rposition(|mark| mark == b"<?").or_else(|| at.checked_sub(16))?;
    let length = blocks.get(start.checked_sub(4)?..start)?;
    let length = u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize;
    // A block has its kind and its head before the length.
    let is_inside = start >= 4 + BLOCK_HEAD + 4 && length <= MOST_PROPERTIES;
    blocks.get(start..start.checked_add(length)?).filter(|_| is_inside).map(text)
}

/// Returns the first element below a node with a local name.
fn below<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.descendants().find(|node| node.tag_name().name() == name)
}

/// Returns the text of the element at a path of local names.
fn at<'a>(node: Node<'a, '_>, path: &[&str]) -> Option<&'a str> {
    path.iter().try_fold(node, |node, name| below(node, name))?.text().map(str::trim)
}

/// Returns the number at a path of local names, or else `default`.
fn number(node: Node, path: &[&str], default: Option<f64>) -> Result<f64, String> {
    let name = path.join("/");
    match (at(node, path), default) {
        (Some(text), _) => text.parse().map_err(|_| format!("{name} is {:?}; it must be a number", clip(text))),
        (None, Some(default)) => Ok(default),
        (None, None) => Err(format!("the properties have no {name}; they must have it")),
    }
}

/// Lists the channels with heights.
fn channels(all: Cow<'_, [u8]>) -> Result<Vec<Channel<'_>>, String> {
    if !all.starts_with(MAGIC) {
        return Err("the file does not begin with OLYMPUSRAWFORMAT; it must".into());
    }
    let (images, properties) = chunks(&all)?;
    let all = Rc::new(all);
    let document = xml("imageProperties", &properties)?;
    let root = document.root_element();
    let info = below(root, "imageInfo").ok_or("the properties have no imageInfo; they must have it")?;
    let whole = |name: &str| count(name, at(info, &[name]).and_then(|text| text.parse::<usize>().ok()).unwrap_or(0));
    let points = [whole("width")?, whole("height")?];
    let mut found = Vec::new();
    let is_kind = |node: &Node, kind: &str| at(*node, &["imageDefinition", "imageType"]) == Some(kind);
    let is_channel = |node: &Node| node.tag_name().name() == "channel" && node.attribute("id").is_some();
    let has_marks = info.descendants().filter(is_channel).any(|node| is_kind(&node, "INVALID"));
    let heights = info.descendants().filter(is_channel).filter(|node| is_kind(node, "HEIGHT"));
    for node in heights.take(MOST_CHANNELS) {
        let id = node.attribute("id").unwrap_or_default();
        let image = images.iter().find(|(name, _)| name.contains(id) && !id.is_empty());
        let (_, range) = image.ok_or_else(|| format!("the file has no image of the channel {}", clip(id)))?;
        let sample = match at(node, &["imageDefinition", "depth"]) {
            Some("1") => Sample::U8,
            Some("2") => Sample::U16,
            other => {
                return Err(format!("a count has {:?} bytes; it must have 1 or 2", clip(other.unwrap_or_default())));
            }
        };
        let (mut map, scale) = scaled(root, node, points)?;
        if has_marks {
            map.notes.push("the channel INVALID is not applied, as no other program does".into());
        }
        let grid = Grid::lines(points, sample, Order::Little);
        let data = Part { whole: Rc::clone(&all), range: range.clone() };
        found.push(Channel::of_grid("HEIGHT", grid, data, map, move |count| scale * count)?);
    }
    match found.is_empty() {
        true => Err("the file has no channel of the type HEIGHT; it must have one".into()),
        false => Ok(found),
    }
}

/// Returns a map without its heights, and the height of a count.
fn scaled(root: Node, channel: Node, points: [usize; 2]) -> Result<(Map, f64), String> {
    let calibration = below(root, "pixelCalibration");
    let axis = |axis: &str| -> Result<(f64, String), String> {
        let step = number(channel, &["length", axis], None)?;
        let correction = calibration.map_or(Ok(1.0), |node| number(node, &[axis], Some(1.0)))?;
        let unit = at(channel, &["pixelUnit", axis]).unwrap_or_default().to_owned();
        if !is_length(&unit) {
            return Err(format!("the unit of {axis} is {:?}; it must be a unit of length", clip(&unit)));
        }
        Ok((step * correction, unit))
    };
    let [(x, x_unit), (y, y_unit), (z, z_unit)] = [axis("x")?, axis("y")?, axis("z")?];
    let spacing = [positive("the spacing along x", x)?, positive("the spacing along y", y)?];
    let scale = factor("the height of a count", z)?;
    let lengths = size(points, spacing);
    let sides = Sides::of((lengths[0], Some(x_unit)), Some((lengths[1], Some(y_unit))).filter(|_| points[1] > 1))?;
    let details = at(root, &["creationDateTime"]).map(|date| ("date".to_owned(), date.to_owned()));
    let map = Map {
        lengths: Some(sides.lengths),
        length_unit: sides.unit,
        height_unit: Some(z_unit),
        details: details.into_iter().collect(),
        notes: sides.notes,
        ..Map::default()
    };
    Ok((map, scale))
}
