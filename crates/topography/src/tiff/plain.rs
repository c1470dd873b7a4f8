//! Images as TIFF, with the size of a pixel from ImageJ, OME or GeoTIFF.
//!
//! Numbers of a plain image are heights without a unit, and the image has no size: the resolution of a plain TIFF is
//! the size of a print. ImageJ and OME give the size of a pixel and its unit, but mostly no unit of the numbers.

use super::geo::{Ground, is_ground};
use super::image::Image;
use super::{DESCRIPTION, Page, RESOLUTION, order, pages};
use crate::bytes::{clip, factor, lines, positive};
use crate::file::File;
use crate::format::{Channel, Contents, FirstLine, Format, Map, size};
use crate::unit::{Sides, canonical, is_length};
use crate::zipped::xml;

pub(crate) const FORMAT: Format =
    Format { name: "TIFF", sniff: |file| order(file.head()).is_some(), open, first_line: FirstLine::Top };

/// Tag with the kind of a page; small copies and masks have one of these bits.
const KIND: u16 = 254;
const COPY_OR_MASK: usize = 0b101;
const NAME: u16 = 285;

fn open(file: &File) -> Result<Contents<'_>, String> {
    let pages = pages(file.bytes()?)?;
    let description = pages[0].text(DESCRIPTION)?;
    let (mut channels, mut refused, mut warnings) = (Vec::new(), None, Vec::new());
    for page in &pages {
        if page.whole(KIND, 0)? & COPY_OR_MASK != 0 {
            continue;
        }
        match channel(file, page, &description, &mut warnings) {
            Ok(channel) => channels.push(channel),
            Err(error) => {
                refused.get_or_insert(error);
            }
        }
    }
    match (channels.is_empty(), refused) {
        (true, Some(error)) => Err(error),
        (true, None) => Err("the file has no image but small copies and masks; it must have one".into()),
        (false, _) => {
            warnings.dedup();
            warnings.truncate(8);
            Ok(Contents { warnings, ..channels.into() })
        }
    }
}

/// Size of a pixel, and scale of the heights.
#[derive(Default)]
struct Pixel {
    lengths: Option<[f64; 2]>,
    unit: Option<String>,
    height_unit: Option<String>,
    /// Scale and offset.
    scale: Option<[f64; 2]>,
}

fn channel<'a>(
    file: &File,
    page: &Page<'a>,
    description: &str,
    warnings: &mut Vec<String>,
) -> Result<Channel<'a>, String> {
    let image = Image::of(page)?;
    let (sample, points) = (image.sample()?, image.points);
    if sample.size() == 1 {
        file.check_image_heights()?;
    }
    let name = page.text(NAME)?;
    if is_ground(page) {
        let ground = Ground::of(page, sample)?;
        warnings.extend(ground.warnings.iter().cloned());
        let (length_unit, height_unit) = (Some("m".to_owned()), Some(ground.height_unit.clone()));
        let map = Map {
            lengths: Some(size(points, ground.spacing)),
            length_unit,
            height_unit: height_unit.clone(),
            ..Map::default()
        };
        let read = Box::new(move || {
            let mut heights = image.read(|number| ground.height(number))?;
            if ground.begins_south {
                heights.invert_axis(ndarray::Axis(1));
            }
            Ok(Map { heights, ..map })
        });
        return Ok(Channel { name, unit: height_unit, points, read });
    }
    let mut pixel = match () {
        () if description.starts_with("ImageJ=") => Pixel::of_imagej(page, description, points)?,
        () if description.contains("<OME") => Pixel::of_ome(description, points)?,
        () => Pixel::default(),
    };
    if let (Some(unit), None) = (&pixel.unit, &pixel.height_unit) {
        warnings.push(format!("the lengths are in {unit}, and the heights have no unit; both are given without one"));
        pixel.unit = None;
    }
    let [scale, offset] = pixel.scale.unwrap_or([1.0, 0.0]);
    let unit = pixel.height_unit.clone();
    let map = Map { lengths: pixel.lengths, length_unit: pixel.unit, height_unit: unit.clone(), ..Map::default() };
    let read = Box::new(move || Ok(Map { heights: image.read(|number| scale * number + offset)?, ..map }));
    Ok(Channel { name, unit, points, read })
}

impl Pixel {
    /// Reads the entries of ImageJ: the unit of the resolution, and a scale of the numbers.
    fn of_imagej(page: &Page, description: &str, points: [usize; 2]) -> Result<Self, String> {
        let get = |key: &str| {
            lines(description)
                .find_map(|line| line.split_once('=').filter(|(found, _)| *found == key))
                .map(|(_, value)| value.trim())
        };
        let unit_of = |key: &str| {
            let unit = get(key)?.replace("\\u00B5", "µ");
            let unit = if unit.starts_with("micron") { "µm".to_owned() } else { unit };
            Some(canonical(&unit).to_owned()).filter(|unit| is_length(unit))
        };
        let mut pixel = Self::default();
        if let Some(unit) = unit_of("unit") {
            let spacing =
                |tag| positive("the resolution", page.number(tag)?.unwrap_or(0.0)).map(|resolution| 1.0 / resolution);
            pixel.lengths = Some(size(points, [spacing(RESOLUTION[0])?, spacing(RESOLUTION[1])?]));
            pixel.unit = Some(unit);
        }
        let number = |key| get(key).and_then(|value| value.parse::<f64>().ok());
        if let (Some(unit), Some(offset), Some(scale)) = (unit_of("vunit"), number("c0"), number("c1")) {
            // Function 0 is a straight line.
            if number("cf").is_some_and(|function| function != 0.0) {
                return Err("ImageJ calibrates the numbers by a curve; it must be a straight line (cf=0)".into());
            }
            pixel.scale = Some([factor("c1", scale)?, offset]);
            pixel.height_unit = Some(unit);
        }
        Ok(pixel)
    }

    /// Reads the size of a pixel in the text of OME.
    fn of_ome(description: &str, points: [usize; 2]) -> Result<Self, String> {
        let document = xml("OME", description)?;
        let Some(pixels) = document.descendants().find(|node| node.tag_name().name() == "Pixels") else {
            return Ok(Self::default());
        };
        let side = |axis: char| {
            let key = format!("PhysicalSize{axis}");
            let Some(text) = pixels.attribute(key.as_str()) else { return Ok(None) };
            let spacing = text.parse().map_err(|_| format!("{key} is {:?}; it must be a number", clip(text)))?;
            let unit = pixels.attribute(format!("{key}Unit").as_str()).unwrap_or("µm").to_owned();
            positive(&key, spacing).map(|spacing| Some((spacing, Some(unit))))
        };
        let (Some(x), Some(y)) = (side('X')?, side('Y')?) else { return Ok(Self::default()) };
        let Some(unit) = x.1.as_deref().filter(|unit| is_length(unit)) else { return Ok(Self::default()) };
        let unit = canonical(unit).to_owned();
        let sides = Sides::of((x.0, Some(unit.clone())), Some(y))?;
        Ok(Self { lengths: Some(size(points, sides.lengths)), unit: Some(unit), ..Self::default() })
    }
}
