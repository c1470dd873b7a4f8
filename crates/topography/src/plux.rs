//! Sensofar PLUX (`.plux`): confocal, interference and focus variation microscopes. The container is a zip archive.
//!
//! `index.xml` has the number of points, the size of a pixel in µm (`FOV_X`, `FOV_Y`) and the names of the entries of
//! each layer, 32-bit floats in µm, line by line. Undefined points are NaN.

use std::rc::Rc;

use roxmltree::Node;

use super::bytes::{Grid, Layout, MOST_CHANNELS, Order, Sample, clip, count};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::zipped::{Zip, xml};

pub(crate) const FORMAT: Format = Format { name: "Sensofar PLUX", sniff, open, first_line: FirstLine::Top };

/// Items of `INFO` listed in the details.
const DETAILS: [&str; 6] = ["Device", "Objective", "Technique", "Measurement Type", "Algorithm", "Comment"];

fn sniff(file: &File) -> bool {
    Zip::has(file, &["index.xml"])
        && Zip::open(file).and_then(|mut zip| zip.text("index.xml")).is_ok_and(|index| index.contains("IMAGE_SIZE_X"))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut zip = Zip::open(file)?;
    let index = zip.text("index.xml")?;
    let index = xml("index.xml", &index)?;
    let root = index.root_element();
    let general = child(root, "GENERAL").ok_or("the entry index.xml has no element GENERAL; it must have one")?;
    let points = [
        count("IMAGE_SIZE_X", number::<usize>(general, "IMAGE_SIZE_X")?)?,
        count("IMAGE_SIZE_Y", number::<usize>(general, "IMAGE_SIZE_Y")?)?,
    ];
    let pixel = [number::<f64>(general, "FOV_X")?, number::<f64>(general, "FOV_Y")?];
    let details: Rc<[(String, String)]> = details(root, general).into();
    let grid = Grid { points, sample: Sample::F32, order: Order::Little, layout: Layout::Lines, backwards: [false; 2] };
    let mut channels = vec![];
    for number in 0..MOST_CHANNELS {
        let name = format!("LAYER_{number}");
        let Some(layer) = child(root, &name) else { break };
        let entry =
            text(layer, "FILENAME_Z").ok_or_else(|| format!("{name} has no FILENAME_Z; it must name its data"))?;
        zip.stream(entry)?;
        let (entry, details) = (entry.to_owned(), Rc::clone(&details));
        let read = move || {
            let mut zip = Zip::open(file)?;
            let (stream, compressed) = zip.stream(&entry)?;
            let unit = Some("µm".to_owned());
            let [nx, ny] = points.map(|n| n as f64);
            Ok(Map {
                heights: grid.inflate(compressed, stream, |height| height)?,
                lengths: Some([pixel[0] * nx, if ny == 1.0 { 1.0 } else { pixel[1] * ny }]),
                length_unit: unit.clone(),
                height_unit: unit,
                details: details.to_vec(),
                ..Map::default()
            })
        };
        channels.push(Channel { name, unit: Some("µm".into()), points, read: Box::new(read) });
    }
    if channels.is_empty() {
        return Err("the entry index.xml has no element LAYER_0; it must have a layer".into());
    }
    Ok(channels.into())
}

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// Returns the text of a child, without surrounding blanks.
fn text<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(node, name)?.text().map(str::trim)
}

fn number<T: std::str::FromStr>(node: Node, name: &str) -> Result<T, String> {
    let text = text(node, name).ok_or_else(|| format!("the entry index.xml has no {name}; it must have it"))?;
    text.parse().map_err(|_| format!("{name} is {:?}; it must be a number", clip(text)))
}

fn details(root: Node, general: Node) -> Vec<(String, String)> {
    let mut details = vec![];
    if let Some(date) = text(general, "DATE") {
        details.push(("date".to_owned(), date.to_owned()));
    }
    let items = child(root, "INFO").into_iter().flat_map(|info| info.children());
    for item in items {
        let (Some(name), Some(value)) = (text(item, "NAME"), text(item, "VALUE")) else { continue };
        if DETAILS.contains(&name) && !details.iter().any(|(key, _)| *key == name.to_lowercase()) {
            details.push((name.to_lowercase(), value.to_owned()));
        }
    }
    details
}
