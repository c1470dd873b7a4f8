//! GeoTIFF: sizes, units and missing points of an image of the ground.

use super::Page;
use crate::bytes::{Sample, clip, factor, positive};
use crate::zipped::xml;

/// Tags of GeoTIFF and of GDAL.
const SPACING: u16 = 33550;
const TURNED: u16 = 34264;
const KEYS: u16 = 34735;
const METADATA: u16 = 42112;
const MISSING: u16 = 42113;

/// Keys: kind of coordinates, projection, and units along the ground and upwards.
const MODEL: f64 = 1024.0;
const PROJECTION: f64 = 3072.0;
const UNIT: f64 = 3076.0;
const VERTICAL_UNIT: f64 = 4099.0;

/// Length of a foot in m.
const FOOT: f64 = 0.3048;

/// Kind of coordinates that are degrees.
const DEGREES: f64 = 2.0;

/// Image of the ground: height = scale times number + offset.
pub(super) struct Ground {
    /// Spacing in m.
    pub(super) spacing: [f64; 2],
    /// True if the first line is the southern one.
    pub(super) begins_south: bool,
    pub(super) height_unit: String,
    pub(super) scale: f64,
    pub(super) offset: f64,
    pub(super) missing: Option<f64>,
    pub(super) warnings: Vec<String>,
}

/// Returns true if a page has tags of GeoTIFF.
pub(super) fn is_ground(page: &Page) -> bool {
    page.has(SPACING) || page.has(TURNED)
}

impl Ground {
    /// Reads the tags of a page.
    ///
    /// # Errors
    /// Coordinates in degrees, a turned image, an unknown unit.
    pub(super) fn of(page: &Page, sample: Sample) -> Result<Self, String> {
        let ([x, y], begins_south) = steps(page)?;
        let spacing = [positive("the spacing along x", x)?, positive("the spacing along y", y)?];
        let quads: Vec<f64> = page.numbers(KEYS)?.take(4096).collect();
        let key = |key: f64| quads.chunks_exact(4).find(|quad| quad[0] == key && quad[1] == 0.0).map(|quad| quad[3]);
        if key(MODEL) == Some(DEGREES) {
            return Err(
                "the coordinates are degrees, which are no lengths; write it in projected coordinates (gdalwarp)"
                    .into(),
            );
        }
        let mut warnings = Vec::new();
        let metres = match key(UNIT) {
            Some(code) => metres(code)?,
            None => {
                let projection = key(PROJECTION).map_or_else(|| "none".to_owned(), |code| code.to_string());
                warnings.push(format!(
                    "the file names no unit along the ground, only the projection {projection}; m is assumed"
                ));
                1.0
            }
        };
        let (scale, offset, named) = metadata(page)?;
        let (height_unit, factor) = match (named.as_deref(), key(VERTICAL_UNIT)) {
            (Some("m" | "metre" | "meter"), _) => ("m", 1.0),
            (Some("ft" | "foot"), _) => ("m", FOOT),
            (Some(unit), _) => (unit, 1.0),
            (None, Some(code)) => ("m", self::metres(code)?),
            (None, None) => {
                warnings.push("the file names no unit of the heights; the unit along the ground is assumed".into());
                ("m", metres)
            }
        };
        let height_unit = height_unit.to_owned();
        let missing = page.text(MISSING)?;
        let missing = match missing.as_str() {
            "" => None,
            text => Some(text.parse::<f64>().map_err(|_| format!("the number of missing points is {:?}", clip(text)))?),
        };
        #[expect(clippy::cast_possible_truncation, reason = "the numbers have single precision")]
        let missing = missing.map(|number| if sample == Sample::F32 { f64::from(number as f32) } else { number });
        let [spacing, [scale, offset]] = [spacing.map(|step| step * metres), [scale * factor, offset * factor]];
        Ok(Self { spacing, begins_south, height_unit, scale, offset, missing, warnings })
    }

    /// Returns the height of a number.
    pub(super) fn height(&self, number: f64) -> f64 {
        if self.missing == Some(number) { f64::NAN } else { self.scale * number + self.offset }
    }
}

/// Returns the steps along x and y from one point to the next, and true if y rises from line to line.
fn steps(page: &Page) -> Result<([f64; 2], bool), String> {
    if page.has(TURNED) {
        // Rows of the matrix from columns and lines to coordinates.
        let matrix: Vec<f64> = page.numbers(TURNED)?.take(8).collect();
        return match matrix[..] {
            [x, 0.0, _, _, 0.0, y, ..] => Ok(([x, y.abs()], y > 0.0)),
            _ => Err("the image is turned against the coordinates; write it again without a turn (gdalwarp)".into()),
        };
    }
    let numbers: Vec<f64> = page.numbers(SPACING)?.take(2).collect();
    let [x, y] = numbers[..] else { return Err("the tag 33550 has one number; it must have two".into()) };
    Ok(([x, y], false))
}

/// Returns the length in m of the unit with a number of EPSG.
fn metres(code: f64) -> Result<f64, String> {
    match code {
        9001.0 => Ok(1.0),
        9002.0 => Ok(FOOT),
        9003.0 => Ok(1200.0 / 3937.0),
        other => Err(format!("the unit has the number {other} of EPSG; it must be 9001 (m), 9002 or 9003 (feet)")),
    }
}

/// Reads scale, offset and unit of the heights from the text of GDAL.
fn metadata(page: &Page) -> Result<(f64, f64, Option<String>), String> {
    let text = page.text(METADATA)?;
    if text.is_empty() {
        return Ok((1.0, 0.0, None));
    }
    let document = xml("GDAL_METADATA", &text)?;
    let item = |role: &str| {
        let is_role =
            |node: &roxmltree::Node| node.attribute("role").is_some_and(|found| found.eq_ignore_ascii_case(role));
        let items = document.descendants().filter(|node| node.tag_name().name() == "Item").filter(is_role);
        items.filter(|node| node.attribute("sample").unwrap_or("0") == "0").find_map(|node| node.text()).map(str::trim)
    };
    let number = |role: &str, default: f64| {
        let parse =
            |text: &str| text.parse::<f64>().map_err(|_| format!("{role} is {:?}; it must be a number", clip(text)));
        item(role).map_or(Ok(default), parse)
    };
    let unit = item("unittype").map(str::to_owned);
    Ok((factor("the scale", number("scale", 1.0)?)?, number("offset", 0.0)?, unit))
}
