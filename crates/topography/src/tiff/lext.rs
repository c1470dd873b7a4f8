//! Olympus LEXT (`.lext`): confocal microscopes of Olympus, Evident.
//!
//! The page described as `HEIGHT` has 16-bit counts; the description of the first page has the size of a pixel and the
//! height of a count in pm, and a page of the camera's details has factors in millionths. The page `INVALID` marks
//! points that were not measured.

use roxmltree::Document;

use super::{DESCRIPTION, Page, first_page, image::Image, pages};
use crate::bytes::{clip, factor, positive};
use crate::file::File;
use crate::format::{Channel, Contents, FirstLine, Format, Map, size};
use crate::zipped::xml;

pub(crate) const FORMAT: Format = Format {
    name: "Olympus LEXT",
    sniff: |file| first_page(file, |page| page.text(DESCRIPTION).is_ok_and(|text| text.contains("TiffTagDescData"))),
    open,
    first_line: FirstLine::Top,
};

/// Tag of the camera's details, and its tag with the factors.
const CAMERA: u16 = 34665;
const FACTORS: u16 = 0xa40b;

fn open(file: &File) -> Result<Contents<'_>, String> {
    let pages = pages(file.bytes()?)?;
    let description = pages[0].text(DESCRIPTION)?;
    let description = xml("TiffTagDescData", &description)?;
    let factors = pages[0].page(CAMERA)?.map(|page| page.text(FACTORS)).transpose()?.unwrap_or_default();
    let factors = if factors.is_empty() { None } else { Some(xml("ExifTagDescData", &factors)?) };
    let mut notes = Vec::new();
    if factors.is_none() {
        notes.push("the file has no factors of calibration; they are taken as 1".to_owned());
    }
    // Picometres times millionths, in micrometres.
    let mut scales = [0.0; 3];
    for (scale, axis) in scales.iter_mut().zip(["X", "Y", "Z"]) {
        let key = format!("HeightDataPerPixel{axis}");
        let found =
            number(&description, &key)?.ok_or_else(|| format!("the description has no {key}; it must have it"))?;
        let factor = match &factors {
            Some(factors) => number(factors, &format!("MakerCalibrationValue{axis}"))?.unwrap_or(1e6),
            None => 1e6,
        };
        *scale = found * factor / 1e12;
    }
    let units = ["X", "Y", "Z"].map(|axis| number(&description, &format!("HeightDataUnit{axis}")));
    if units.iter().any(|unit| *unit != units[0]) {
        return Err("the units of x, y and z differ; they must be the same".into());
    }
    let spacing = [positive("the spacing along x", scales[0])?, positive("the spacing along y", scales[1])?];
    let scale = factor("the height of a count", scales[2])?;
    let named = |name: &str| pages.iter().find(|page| page.text(DESCRIPTION).is_ok_and(|text| text == name));
    let heights = Image::of(named("HEIGHT").ok_or("the file has no page HEIGHT; it must have it")?)?;
    heights.sample()?;
    let invalid = named("INVALID").map(|page| mask(page, heights.points)).transpose()?;
    let (unit, points) = (Some("µm".to_owned()), heights.points);
    let lengths = Some(size(points, spacing));
    let map = Map { lengths, length_unit: unit.clone(), height_unit: unit.clone(), notes, ..Map::default() };
    let read = move || {
        let mut heights = heights.read(|found| scale * found)?;
        if let Some(invalid) = invalid {
            invalid.bits(|point| heights[point] = f64::NAN)?;
        }
        Ok(Map { heights, ..map })
    };
    Ok(Channel { name: "HEIGHT".into(), unit, points, read: Box::new(read) }.into())
}

/// Returns the image of points that were not measured.
fn mask<'a>(page: &Page<'a>, points: [usize; 2]) -> Result<Image<'a>, String> {
    let image = Image::of(page)?;
    if image.points != points || image.bits != 1 {
        let ([nx, ny], bits) = (image.points, image.bits);
        return Err(format!(
            "the page INVALID has {nx} by {ny} points of {bits} bits; it must have as many as HEIGHT, of 1 bit"
        ));
    }
    Ok(image)
}

/// Returns the number of the first element with a name.
fn number(document: &Document, name: &str) -> Result<Option<f64>, String> {
    let element = document.descendants().find(|node| node.tag_name().name() == name);
    let Some(text) = element.and_then(|node| node.text()).map(str::trim).filter(|text| !text.is_empty()) else {
        return Ok(None);
    };
    text.parse().map(Some).map_err(|_| format!("{name} is {:?}; it must be a number", clip(text)))
}
