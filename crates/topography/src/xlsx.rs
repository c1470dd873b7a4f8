//! Workbooks of Excel (`.xlsx`): sheets of numbers, and profiles of Mitutoyo.
//!
//! A sheet is read as the text reader reads its rows, with tabs between the cells: a matrix or a list of points, with
//! or without titles. Empty cells between numbers are undefined points. Each sheet that is a height map is a channel. A
//! workbook of Mitutoyo has the positions and heights of a profile in two columns of `DATA`, and the unit of the
//! positions in `Certificate`.

mod sheet;

use super::bytes::{MOST_CHANNELS, clip, positive};
use super::coordinates::evenly_spaced;
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::matrix;
use super::zipped::{Zip, xml};
use sheet::Sheet;

pub(crate) const FORMAT: Format =
    Format { name: "Excel", sniff: |file| Zip::has(file, &[WORKBOOK]), open, first_line: FirstLine::Bottom };

const WORKBOOK: &str = "xl/workbook.xml";
const RELATIONS: &str = "xl/_rels/workbook.xml.rels";
const STRINGS: &str = "xl/sharedStrings.xml";

/// Sheets of a workbook of Mitutoyo, and the cells of the unit of positions and of the date: line and column.
const MITUTOYO: [&str; 2] = ["DATA", "Certificate"];
const UNIT: [u32; 2] = [48, 5];
const DATE: [u32; 2] = [2, 5];

/// Columns of the parameters, positions and heights of Mitutoyo.
const PARAMETERS: u32 = 1;
const POSITIONS: u32 = 5;
const HEIGHTS: u32 = 6;

/// Workbook: the names and members of the sheets, and the texts that they share.
struct Workbook<'a> {
    zip: Zip<'a>,
    sheets: Vec<(String, String)>,
    strings: Vec<String>,
}

impl<'a> Workbook<'a> {
    fn open(file: &'a File) -> Result<Self, String> {
        let mut zip = Zip::open(file)?;
        let [book, relations] = [zip.text(WORKBOOK)?, zip.text(RELATIONS)?];
        let (book, relations) = (xml(WORKBOOK, &book)?, xml(RELATIONS, &relations)?);
        let target = |id: &str| {
            let found = relations.descendants().find(|node| node.attribute("Id") == Some(id))?;
            let target = found.attribute("Target")?;
            Some(target.strip_prefix('/').map_or_else(|| format!("xl/{target}"), str::to_owned))
        };
        let mut sheets = Vec::new();
        for node in book.descendants().filter(|node| node.tag_name().name() == "sheet").take(MOST_CHANNELS) {
            let id = node.attributes().find(|attribute| attribute.name() == "id");
            if let Some(member) = id.and_then(|id| target(id.value())) {
                sheets.push((node.attribute("name").unwrap_or_default().to_owned(), member));
            }
        }
        let strings = match zip.meant(STRINGS) {
            Some(name) => sheet::strings(&decode(zip.whole(&name)?)?),
            None => Vec::new(),
        };
        Ok(Self { zip, sheets, strings })
    }

    /// Calls `found` with the cells of a sheet.
    fn sheet<T>(&mut self, number: usize, found: impl FnOnce(Sheet) -> Result<T, String>) -> Result<T, String> {
        let (_, member) = self.sheets.get(number).ok_or("the workbook has no sheet; it must have one")?;
        let text = decode(self.zip.whole(member)?)?;
        found(Sheet::read(&text, &self.strings)?)
    }

    fn number(&self, name: &str) -> Option<usize> {
        self.sheets.iter().position(|(found, _)| found == name)
    }

    /// Returns the text of a sheet.
    fn text(&mut self, number: usize) -> Result<File, String> {
        self.sheet(number, |sheet| sheet.text()).map(|text| File::from_bytes(text.into_bytes()))
    }
}

fn decode(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|_| "a sheet is not text in UTF-8; it must be".into())
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut book = Workbook::open(file)?;
    if let [Some(data), Some(certificate)] = MITUTOYO.map(|name| book.number(name)) {
        return mitutoyo(&mut book, [data, certificate]).map(Into::into);
    }
    let (mut channels, mut refused, mut warnings) = (Vec::new(), None, Vec::new());
    for number in 0..book.sheets.len() {
        let sheet = book.sheets[number].0.clone();
        let listed = book.text(number).and_then(|text| {
            let contents = (matrix::FORMAT.open)(&text)?;
            warnings.extend(contents.warnings);
            Ok(contents
                .channels
                .into_iter()
                .map(|channel| (channel.name, channel.unit, channel.points))
                .collect::<Vec<_>>())
        });
        match listed {
            Ok(listed) => channels.extend(listed.into_iter().enumerate().map(|(column, (name, unit, points))| {
                let name = if name.is_empty() { sheet.clone() } else { format!("{sheet}/{name}") };
                let read = Box::new(move || {
                    let text = Workbook::open(file)?.text(number)?;
                    let channel = (matrix::FORMAT.open)(&text)?.channels.into_iter().nth(column);
                    (channel.ok_or("the sheet has no such channel")?.read)()
                });
                Channel { name, unit, points, read }
            })),
            Err(error) => {
                if error != sheet::NO_NUMBERS {
                    warnings.push(format!("the sheet {} is left out: {error}", clip(&sheet)));
                }
                refused.get_or_insert(format!("sheet {}: {error}", clip(&sheet)));
            }
        }
    }
    channels.truncate(MOST_CHANNELS);
    match refused {
        Some(error) if channels.is_empty() => Err(error),
        None if channels.is_empty() => Err("the workbook has no sheet; it must have one".into()),
        _ => Ok(Contents { warnings, ..channels.into() }),
    }
}

/// Reads the profile of a workbook of Mitutoyo.
fn mitutoyo(book: &mut Workbook, [data, certificate]: [usize; 2]) -> Result<Channel<'static>, String> {
    let (length_unit, date) = book.sheet(certificate, |sheet| {
        let unit = sheet.get(UNIT).trim_start_matches(|c: char| c.is_ascii_digit() || ".,- ".contains(c)).to_owned();
        Ok((unit, sheet.get(DATE).to_owned()))
    })?;
    let (height_unit, positions, heights) = book.sheet(data, |sheet| {
        let parameter = sheet.cells.iter().find(|cell| cell.column == PARAMETERS && !cell.is_number);
        let unit = parameter.and_then(|cell| cell.text.split_whitespace().last()).unwrap_or_default().to_owned();
        Ok((unit, sheet.column(POSITIONS)?, sheet.column(HEIGHTS)?))
    })?;
    if length_unit.is_empty() || height_unit.is_empty() {
        return Err("cell E48 of Certificate or column A of DATA has no unit; both must have one".into());
    }
    let points = [heights.len(), 1];
    let length = evenly_spaced(&positions, points[0], "in column E", 0.0)?;
    let length = length.ok_or_else(|| {
        let count = positions.len();
        format!("columns E and F of DATA have {count} and {} numbers; they must have as many, at least 2", points[0])
    })?;
    let map = Map {
        heights: super::shaped(points, heights)?,
        lengths: Some([positive("the length", length)?, 1.0]),
        length_unit: Some(length_unit),
        height_unit: Some(height_unit.clone()),
        details: super::format::details([("date", date)]),
        notes: vec!["a workbook of Mitutoyo: the heights have the unit of the first parameter in column A".into()],
        ..Map::default()
    };
    Ok(Channel { name: "DATA".into(), unit: Some(height_unit), points, read: Box::new(move || Ok(map)) })
}

/// Largest number of bytes that texts shared by sheets take.
const MOST_STRINGS: usize = 1 << 20;
