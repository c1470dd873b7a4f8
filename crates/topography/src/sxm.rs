//! Nanonis SXM (`.sxm`): controllers of SPECS for tunnelling and force microscopes.
//!
//! Tags `:NAME:` with lines of values, up to the bytes 1A 04; then big-endian 32-bit floats, in the order of the table
//! `DATA_INFO`, the forward image of a channel before its backward image. The numbers are heights in m; the calibration
//! of the table is not applied. A scan downwards begins with the top line, and lines of backward images with their
//! right end. Points that were not reached are NaN.

use super::bytes::{Bytes, Grid, MOST_CHANNELS, Order, Sample, clip, count, find, lines, positive, text};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, details};
use super::unit::is_length;

pub(crate) const FORMAT: Format = Format { name: "Nanonis SXM", sniff, open, first_line: FirstLine::Bottom };

const END: &[u8] = b":SCANIT_END:";
const DATA: &[u8] = b"\x1a\x04";

/// Names of channels with heights; others in a unit of length are amplitudes.
const HEIGHTS: [&str; 3] = ["z", "topography", "height"];

fn sniff(file: &File) -> bool {
    file.starts_with(b":NANONIS_VERSION:")
}

/// Lines of the values of each tag.
struct Tags<'a>(Vec<(&'a str, Vec<&'a str>)>);

impl<'a> Tags<'a> {
    fn of(text: &'a str) -> Self {
        let mut tags: Vec<(&str, Vec<&str>)> = Vec::new();
        for line in lines(text) {
            match (line.trim().strip_prefix(':').and_then(|line| line.strip_suffix(':')), tags.last_mut()) {
                (Some(name), _) => tags.push((name, Vec::new())),
                (None, Some((_, values))) => values.push(line),
                (None, None) => {}
            }
        }
        Self(tags)
    }

    fn lines(&self, name: &str) -> &[&'a str] {
        self.0.iter().find(|(tag, _)| *tag == name).map_or(&[], |(_, values)| values)
    }

    /// Returns the first line of values.
    fn line(&self, name: &str) -> &'a str {
        self.lines(name).iter().map(|line| line.trim()).find(|line| !line.is_empty()).unwrap_or_default()
    }

    fn pair<T: std::str::FromStr + Copy>(&self, name: &str) -> Result<[T; 2], String> {
        let line = self.line(name);
        let numbers: Vec<T> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [x, y] => Ok([x, y]),
            _ => Err(format!("{name} is {:?}; it must be two numbers", clip(line))),
        }
    }
}

/// Row of the table of channels.
struct Row<'a> {
    name: &'a str,
    unit: &'a str,
    directions: &'static [&'static str],
}

impl<'a> Row<'a> {
    fn read(tags: &Tags<'a>) -> Result<Vec<Self>, String> {
        let mut table = tags.lines("DATA_INFO").iter().map(|line| line.trim()).filter(|line| !line.is_empty());
        let titles: Vec<&str> = table.next().unwrap_or_default().split('\t').map(str::trim).collect();
        let column = |title: &str| {
            let found = titles.iter().position(|name| *name == title);
            found.ok_or_else(|| format!("the table DATA_INFO has no column {title}; it must have it"))
        };
        let columns = [column("Name")?, column("Unit")?, column("Direction")?];
        let row = |line: &'a str| {
            let cells: Vec<&str> = line.split('\t').map(str::trim).collect();
            let [name, unit, direction] = columns.map(|column| cells.get(column).copied().unwrap_or_default());
            let directions: &[&str] = match direction {
                "both" => &["forward", "backward"],
                "forward" => &["forward"],
                "backward" => &["backward"],
                other => {
                    return Err(format!(
                        "the direction of {} is {:?}; it must be both or one",
                        clip(name),
                        clip(other)
                    ));
                }
            };
            Ok(Self { name, unit, directions })
        };
        table.take(MOST_CHANNELS).map(row).collect()
    }

    fn is_height(&self) -> bool {
        is_length(self.unit) && HEIGHTS.contains(&self.name.to_lowercase().as_str())
    }
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let all = file.bytes()?;
    let end = find(all, END).ok_or("the header has no tag SCANIT_END; it must end with one")?;
    let start = find(&all[end..], DATA).ok_or("the header is not followed by the bytes 1A 04; it must be")?;
    let mut bytes = Bytes::new(all, Order::Big);
    bytes.seek(end + start + DATA.len())?;
    let head = text(&all[..end]);
    let tags = Tags::of(&head);
    let kind = tags.line("SCANIT_TYPE");
    if !kind.starts_with("FLOAT") {
        return Err(format!("SCANIT_TYPE is {:?}; it must be FLOAT", clip(kind)));
    }
    let mut notes = Vec::new();
    let mut points: [usize; 2] = tags.pair("SCAN_PIXELS")?;
    if tags.line("NANONIS_VERSION") == "1" {
        points.reverse();
        notes.push(
            "the numbers of pixels of version 1 are taken as lines and columns, which only Gwyddion does".to_owned(),
        );
    }
    let points = [count("the number of columns", points[0])?, count("the number of lines", points[1])?];
    let range: [f64; 2] = tags.pair("SCAN_RANGE")?;
    let lengths = [positive("SCAN_RANGE", range[0])?, positive("SCAN_RANGE", range[1])?];
    let is_down = match tags.line("SCAN_DIR") {
        "down" => true,
        "up" => false,
        other => return Err(format!("SCAN_DIR is {:?}; it must be up or down", clip(other))),
    };
    let mut rows = Row::read(&tags)?;
    let grid = Grid::lines(points, Sample::F32, Order::Big);
    let (size, images) = (grid.bytes()?, rows.iter().map(|row| row.directions.len()).sum::<usize>());
    if bytes.left() == size.saturating_mul(rows.len()) && images > rows.len() {
        rows.iter_mut().for_each(|row| row.directions = &row.directions[..1]);
        notes.push("each channel has one image, although the header says forward and backward".into());
    }
    let metre = Some("m".to_owned());
    let date = format!("{} {}", tags.line("REC_DATE"), tags.line("REC_TIME"));
    let details = details([("date", date.trim().to_owned()), ("comment", tags.line("COMMENT").to_owned())]);
    let mut channels = Vec::new();
    for row in &rows {
        for direction in row.directions {
            let data = bytes.take(size)?;
            if !row.is_height() {
                continue;
            }
            let lengths = Some([lengths[0], if points[1] == 1 { 1.0 } else { lengths[1] }]);
            let (length_unit, height_unit) = (metre.clone(), Some(row.unit.to_owned()));
            let map = Map {
                lengths,
                length_unit,
                height_unit,
                details: details.clone(),
                notes: notes.clone(),
                ..Map::default()
            };
            let grid = Grid { backwards: [*direction == "backward", is_down], ..grid };
            channels.push(channel(format!("{} {direction}", row.name), grid, data, map));
        }
    }
    if channels.is_empty() {
        let names: Vec<String> = rows.iter().take(20).map(|row| format!("{} in {}", row.name, row.unit)).collect();
        return Err(format!("the channels are {}; one must be Z in a unit of length", names.join(", ")));
    }
    Ok(channels.into())
}

/// Creates a channel that says so if all heights are equal.
fn channel<'a>(name: String, grid: Grid, data: &'a [u8], map: Map) -> Channel<'a> {
    let unit = map.height_unit.clone();
    let read = move || {
        let mut map = Map { heights: grid.read(data, |height| height)?, ..map };
        let mut defined = map.heights.iter().filter(|height| height.is_finite());
        if let Some(first) = defined.next()
            && defined.all(|height| height == first)
        {
            map.notes.push(format!("all heights are {first} m: the scan was at constant height"));
        }
        Ok(map)
    };
    Channel { name, unit, points: grid.points, read: Box::new(read) }
}
