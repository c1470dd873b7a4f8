//! JPK images (`.jpk`, `.jpk-qi-image`): force microscopes of JPK, Bruker.
//!
//! The first page is a small picture with the lengths of the axes in m; each other page is a channel of integers with
//! several scales (slots), one of them the default. A page begins with the bottom line, unless it says that its grid is
//! reflected.

use super::{Page, first_page, image::Image, pages};
use crate::bytes::{clip, factor, positive};
use crate::file::File;
use crate::format::{Channel, Contents, FirstLine, Format, Map, details};
use crate::unit::is_length;

pub(crate) const FORMAT: Format = Format {
    name: "JPK",
    sniff: |file| first_page(file, |page| page.has(NAME) || page.has(LENGTHS[0])),
    open,
    first_line: FirstLine::Bottom,
};

/// Tags of the file and of a channel.
const DATE: u16 = 0x8003;
const LENGTHS: [u16; 2] = [0x8042, 0x8043];
const REFLECTED: u16 = 0x8045;
const NAME: u16 = 0x8050;
const RETRACE: u16 = 0x8051;
const SHOWN: u16 = 0x8052;
const SLOTS: u16 = 0x8080;
const DEFAULT: u16 = 0x8081;

/// First tag of the first slot, number of tags of a slot, and largest number of slots.
const SLOT: u16 = 0x8090;
const TAGS: u16 = 0x30;
const MOST_SLOTS: usize = 256;

fn open(file: &File) -> Result<Contents<'_>, String> {
    let pages = pages(file.bytes()?)?;
    let length = |tag| positive("the length of an axis", pages[0].number(tag)?.unwrap_or(0.0));
    let lengths = [length(LENGTHS[0])?, length(LENGTHS[1])?];
    let date = pages[0].text(DATE)?;
    let (mut channels, mut ranks, mut others) = (Vec::new(), Vec::new(), Vec::new());
    for page in &pages[1..] {
        let name = page.text(NAME)?;
        let is_height = name.to_lowercase().contains("height") || name == "contact-point";
        let slot = if is_height { Slot::default_of(page)? } else { None };
        let Some(slot) = slot.filter(|slot| slot.unit.as_deref().is_some_and(is_length)) else {
            others.push(clip(&name));
            continue;
        };
        let metre = || Some("m".to_owned());
        let map = Map {
            lengths: Some(lengths),
            length_unit: metre(),
            height_unit: slot.unit.clone(),
            details: details([("date", date.clone())]),
            ..Map::default()
        };
        let is_trace = page.whole(RETRACE, 0)? == 0;
        // The height of the trace comes before other heights.
        ranks.push((!is_trace, name != "height"));
        channels.push(channel(page, &name, slot, map, pages[0].whole(REFLECTED, 0)? != 0)?);
    }
    if channels.is_empty() {
        others.truncate(20);
        return Err(format!("the channels are {}; one must be a height in a unit of length", others.join(", ")));
    }
    let default = (0..channels.len()).min_by_key(|number| ranks[*number]);
    Ok(Contents { default, ..channels.into() })
}

/// Creates the channel of a page.
fn channel<'a>(
    page: &Page<'a>,
    name: &str,
    slot: Slot,
    mut map: Map,
    is_file_reflected: bool,
) -> Result<Channel<'a>, String> {
    let image = Image::of(page)?;
    image.sample()?;
    let scale = factor("the multiplier of the heights", slot.multiplier)?;
    let is_reflected = page.whole(REFLECTED, 0)? != 0;
    if is_reflected {
        map.notes.push("the grid is reflected: its first line is taken as the top of the picture".into());
    } else if is_file_reflected {
        map.notes
            .push("the file says that its grid is reflected, the channel does not; the lines are not turned".into());
    }
    let shown = Some(page.text(SHOWN)?).filter(|shown| !shown.is_empty()).unwrap_or_else(|| name.to_owned());
    let name = if page.whole(RETRACE, 0)? == 0 { shown } else { format!("{shown} (retrace)") };
    let (unit, points) = (map.height_unit.clone(), image.points);
    if points[1] == 1 {
        map.lengths = map.lengths.map(|[x, _]| [x, 1.0]);
    }
    let read = move || {
        let mut heights = image.read(|found| scale * found + slot.offset)?;
        if is_reflected {
            heights.invert_axis(ndarray::Axis(1));
        }
        Ok(Map { heights, ..map })
    };
    Ok(Channel { name, unit, points, read: Box::new(read) })
}

/// Scale of a channel: height = multiplier times number + offset.
struct Slot {
    unit: Option<String>,
    multiplier: f64,
    offset: f64,
}

impl Slot {
    /// Reads the default slot of a page, if it has a scale.
    fn default_of(page: &Page) -> Result<Option<Self>, String> {
        let wanted = page.text(DEFAULT)?;
        for number in 0..page.whole(SLOTS, 0)?.min(MOST_SLOTS) {
            let tag = |tag: u16| u16::try_from(number).ok().and_then(|k| k.checked_mul(TAGS)?.checked_add(SLOT + tag));
            let Some(first) = tag(0) else { break };
            if page.text(first)? != wanted {
                continue;
            }
            return match page.text(first + 0x13)?.as_str() {
                "NullScaling" | "" => Ok(None),
                "LinearScaling" => Ok(Some(Self {
                    unit: Some(page.text(first + 0x12)?),
                    multiplier: page.number(first + 0x14)?.unwrap_or(0.0),
                    offset: page.number(first + 0x15)?.unwrap_or(0.0),
                })),
                other => Err(format!("the scale of {} is {:?}; it must be LinearScaling", clip(&wanted), clip(other))),
            };
        }
        Ok(None)
    }
}
