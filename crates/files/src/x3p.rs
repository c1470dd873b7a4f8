//! Writing of X3P files: heights in double precision in metres.

use std::fmt::Write as _;
use std::io::{self, Write};

use ndarray::ArrayRef2;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::{FileError, Output};
use gfmd_topography::unit::{Conversion, is_length};

/// Height map to be written as X3P.
#[derive(Clone, Copy, Debug)]
pub struct X3p<'a> {
    /// Heights `[x, y]`; NaN where undefined.
    pub heights: &'a ArrayRef2<f64>,
    /// Size along x and y, n times the spacing.
    pub lengths: [f64; 2],
    /// Unit of heights and lengths.
    pub unit: Option<&'a str>,
    /// Date of the file.
    pub date: &'a str,
    /// Program and version that made the heights.
    pub creator: &'a str,
    /// Origin of the heights.
    pub comment: &'a str,
}

impl X3p<'_> {
    /// Writes the file, always in metres, and returns a description of the conversion.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, output: &Output) -> Result<Option<String>, FileError> {
        let known = self.unit.filter(|unit| is_length(unit));
        let conversion = known.and_then(|unit| Conversion::between(unit, "m").ok().flatten());
        let note = match (&conversion, known) {
            (Some(conversion), _) => Some(format!("heights and lengths converted {conversion}")),
            (None, None) => Some("the unit is unknown; the numbers were written as metres".into()),
            (None, Some(_)) => None,
        };
        let metres = |value: f64| conversion.as_ref().map_or(value, |conversion| conversion.apply(value));
        output.write(|file| {
            let mut zip = ZipWriter::new(file);
            let large = self.heights.len() > 1 << 28;
            let options = SimpleFileOptions::default().large_file(large);
            let (nx, ny) = self.heights.dim();
            zip.start_file("bindata/data.bin", options)?;
            let mut sum = md5::Context::new();
            let mut row = Vec::with_capacity(8 * nx);
            for j in 0..ny {
                row.clear();
                row.extend(self.heights.column(j).iter().flat_map(|&height| metres(height).to_le_bytes()));
                sum.consume(&row);
                zip.write_all(&row)?;
            }
            let data = Checked { name: "bindata/data.bin", sum: format!("{:X}", sum.finalize()) };
            let valid = match self.heights.iter().any(|height| height.is_nan()) {
                false => None,
                true => {
                    let mut bits = vec![0_u8; (nx * ny).div_ceil(8)];
                    for ((i, j), height) in self.heights.indexed_iter() {
                        let point = j * nx + i;
                        bits[point / 8] |= u8::from(!height.is_nan()) << (point % 8);
                    }
                    zip.start_file("bindata/valid.bin", options)?;
                    zip.write_all(&bits)?;
                    Some(Checked { name: "bindata/valid.bin", sum: format!("{:X}", md5::compute(&bits)) })
                }
            };
            let document = self.document(metres, &data, valid.as_ref(), note.as_deref());
            zip.start_file("main.xml", options)?;
            zip.write_all(document.as_bytes())?;
            zip.start_file("md5checksum.hex", options)?;
            writeln!(zip, "{:x} *main.xml", md5::compute(&document))?;
            zip.finish().map(|_| ()).map_err(io::Error::other)
        })?;
        Ok(note)
    }

    fn document(
        &self,
        metres: impl Fn(f64) -> f64,
        data: &Checked,
        valid: Option<&Checked>,
        note: Option<&str>,
    ) -> String {
        let (nx, ny) = self.heights.dim();
        let increment = |axis: usize, points: usize| spacing(metres(self.lengths[axis]), points);
        let (dx, dy) = (increment(0, nx), if ny == 1 { 1.0 } else { increment(1, ny) });
        let kind = if ny == 1 { "PRF" } else { "SUR" };
        let axis = |name: &str, increment: f64| {
            format!(
                "      <C{name}><AxisType>I</AxisType><DataType>D</DataType><Increment>{increment:e}</Increment>\
                 <Offset>0</Offset></C{name}>\n"
            )
        };
        let mut comment = self.comment.to_owned();
        if let Some(note) = note {
            let _ = write!(comment, "; {note}");
        }
        let link = |Checked { name, sum }: &Checked, link: &str, checksum: &str| {
            format!("      <{link}>{name}</{link}>\n      <{checksum}>{sum}</{checksum}>\n")
        };
        let links = link(data, "PointDataLink", "MD5ChecksumPointData")
            + &valid.map_or_else(String::new, |valid| link(valid, "ValidPointsLink", "MD5ChecksumValidPoints"));
        let [date, creator, comment] = [self.date, self.creator, &comment].map(escaped);
        format!(
            r#"<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>{kind}</FeatureType>
    <Axes>
{x}{y}      <CZ><AxisType>A</AxisType><DataType>D</DataType></CZ>
    </Axes>
  </Record1>
  <Record2>
    <Date>{date}</Date>
    <Creator>{creator}</Creator>
    <Instrument>
      <Manufacturer>not available</Manufacturer><Model>{creator}</Model>
      <Serial>not available</Serial><Version>not available</Version>
    </Instrument>
    <CalibrationDate>{date}</CalibrationDate>
    <ProbingSystem><Type>Software</Type><Identification>{creator}</Identification></ProbingSystem>
    <Comment>{comment}</Comment>
  </Record2>
  <Record3>
    <MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
    <DataLink>
{links}    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#,
            x = axis("X", dx),
            y = axis("Y", dy),
        )
    }
}

/// Entry of the archive with its MD5 checksum.
struct Checked {
    name: &'static str,
    sum: String,
}

/// Returns a spacing that, times the number of points, is exactly the length, or else the nearest one.
fn spacing(length: f64, points: usize) -> f64 {
    let count = points as f64;
    let nearest = length / count;
    let close = [nearest, nearest.next_up(), nearest.next_down()];
    close.into_iter().find(|spacing| spacing * count == length).unwrap_or(nearest)
}

/// Escapes the characters that XML reserves, and drops control characters except line breaks.
fn escaped(text: &str) -> String {
    let kept = text.chars().filter(|character| !character.is_control() || *character == '\n');
    kept.fold(String::new(), |mut escaped, character| {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            character => escaped.push(character),
        }
        escaped
    })
}
