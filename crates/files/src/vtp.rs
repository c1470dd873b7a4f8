//! VTK polygons (`.vtp`) for ParaView and similar programs: a surface as quadrilaterals between its points, or a line,
//! with values at the points.

use std::io::{self, Write};
use std::path::PathBuf;

use crate::vtk::{FOOTER, Header, PointArray};
use crate::{FileError, Output};

/// Surface as points in rows along x: point `[i, j]` has the number `j nx + i`.
#[derive(Clone, Copy)]
pub struct Sheet<'a> {
    /// Number of points along x and y, 1 along y for a line.
    pub points: [usize; 2],
    /// Position of point `[i, j]`.
    pub position: &'a dyn Fn(usize, usize) -> [f64; 3],
}

/// Quantity with its values `[x, y]`, row-major.
pub type Values<'a> = (PointArray<'a>, &'a [f64]);

/// Writes the surface with values at its points.
///
/// # Errors
/// A file that cannot be written.
///
/// # Panics
/// If the number of values of an array does not match the points.
pub fn write(output: &Output, sheet: &Sheet, arrays: &[Values]) -> Result<PathBuf, FileError> {
    let [nx, ny] = sheet.points;
    assert!(arrays.iter().all(|(_, values)| values.len() == nx * ny), "a value for each point");
    let cells = cells(sheet.points);
    let (header, bytes) = header(sheet.points, &cells, arrays);
    output.write(|file| {
        file.write_all(header.as_bytes())?;
        let mut lengths = bytes.iter();
        let mut length =
            |file: &mut dyn Write| file.write_all(&lengths.next().expect("a length for each array").to_le_bytes());
        for (_, values) in arrays {
            length(file)?;
            in_order(sheet.points, |i, j| file.write_all(&values[i * ny + j].to_le_bytes()))?;
        }
        length(file)?;
        in_order(sheet.points, |i, j| {
            (sheet.position)(i, j).into_iter().try_for_each(|value| file.write_all(&value.to_le_bytes()))
        })?;
        length(file)?;
        match cells {
            Cells::Line => (0..nx as i64).try_for_each(|point| file.write_all(&point.to_le_bytes()))?,
            Cells::Quadrilaterals(_) => in_order([nx - 1, ny - 1], |i, j| {
                let corner = j * nx + i;
                let corners = [corner, corner + 1, corner + nx + 1, corner + nx];
                corners.into_iter().try_for_each(|point| file.write_all(&(point as i64).to_le_bytes()))
            })?,
        }
        length(file)?;
        let (count, corners) = cells.size(nx);
        (1..=count).try_for_each(|cell| file.write_all(&((cell * corners) as i64).to_le_bytes()))?;
        file.write_all(FOOTER.as_bytes())
    })?;
    Ok(output.path().to_path_buf())
}

/// Cells between the points.
enum Cells {
    /// One line through all points.
    Line,
    /// Quadrilaterals, with their number.
    Quadrilaterals(usize),
}

fn cells([nx, ny]: [usize; 2]) -> Cells {
    if ny == 1 { Cells::Line } else { Cells::Quadrilaterals(nx.saturating_sub(1) * (ny - 1)) }
}

impl Cells {
    /// Returns the number of cells and the number of points per cell.
    fn size(&self, nx: usize) -> (usize, usize) {
        match self {
            Self::Line => (1, nx),
            Self::Quadrilaterals(count) => (*count, 4),
        }
    }
}

/// Visits points with x fastest.
fn in_order([nx, ny]: [usize; 2], mut visit: impl FnMut(usize, usize) -> io::Result<()>) -> io::Result<()> {
    (0..ny).try_for_each(|j| (0..nx).try_for_each(|i| visit(i, j)))
}

/// Returns the header, and the length of each array in bytes: the values, the points, the cells.
fn header([nx, ny]: [usize; 2], cells: &Cells, arrays: &[Values]) -> (String, Vec<u64>) {
    let points = nx * ny;
    let (count, corners) = cells.size(nx);
    let (element, lines, polygons) = match cells {
        Cells::Line => ("Lines", count, 0),
        Cells::Quadrilaterals(_) => ("Polys", 0, count),
    };
    let mut header = Header::new("PolyData", "");
    header.add(&format!(
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"{polygons}\">"
    ));
    header.point_data(&arrays.iter().map(|(array, _)| *array).collect::<Vec<_>>(), points);
    let plain = |name| PointArray { name, components: &[], units: "" };
    header.add("<Points>");
    header.declare("Float64", &PointArray { components: &["X", "Y", "Z"], ..plain("Points") }, points);
    header.add(&format!("</Points>\n<{element}>"));
    header.declare("Int64", &plain("connectivity"), count * corners);
    header.declare("Int64", &plain("offsets"), count);
    header.add(&format!("</{element}>"));
    header.end("PolyData")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(points: [usize; 2]) -> (String, Vec<u8>) {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("surface.vtp")).unwrap();
        let position = |i: usize, j: usize| [i as f64, 10.0 * j as f64, -0.5];
        let values: Vec<f64> = (0..points[0] * points[1]).map(|k| k as f64).collect();
        let array = PointArray { name: "pressure", components: &[], units: "a<b" };
        let path = write(&output, &Sheet { points, position: &position }, &[(array, &values)]).unwrap();
        let bytes = std::fs::read(path).unwrap();
        let start = bytes.windows(2).position(|pair| pair == b"\n_").unwrap() + 2;
        (String::from_utf8_lossy(&bytes[..start]).into_owned(), bytes[start..].to_vec())
    }

    /// Returns the eight-byte words of the array at an offset, after its length.
    fn array(bytes: &[u8], offset: usize) -> Vec<[u8; 8]> {
        let word = |place: usize| -> [u8; 8] { bytes[place..][..8].try_into().unwrap() };
        let length = u64::from_le_bytes(word(offset)) as usize;
        (0..length / 8).map(|k| word(offset + 8 + 8 * k)).collect()
    }

    #[test]
    fn arrays_lie_where_the_header_says() {
        let (header, bytes) = written([3, 2]);
        for expected in [
            "<PointData Scalars=\"pressure\">",
            "NumberOfPoints=\"6\"",
            "NumberOfLines=\"0\"",
            "NumberOfPolys=\"2\"",
            ">a&lt;b</InformationKey>",
            "offset=\"56\"",  // 8 + 6 values
            "offset=\"208\"", // and 8 + 18 coordinates
            "offset=\"280\"", // and 8 + 8 corners
        ] {
            assert!(header.contains(expected), "{expected}: {header}");
        }
        let numbers = |offset| array(&bytes, offset).into_iter().map(f64::from_le_bytes).collect::<Vec<_>>();
        // x varies fastest, and the values are in the order of [i, j].
        assert_eq!(numbers(0), [0.0, 2.0, 4.0, 1.0, 3.0, 5.0]);
        assert_eq!(numbers(56)[3..6], [1.0, 0.0, -0.5]);
        assert_eq!(numbers(56)[15..], [2.0, 10.0, -0.5]);
        let integers = |offset| array(&bytes, offset).into_iter().map(i64::from_le_bytes).collect::<Vec<_>>();
        assert_eq!(integers(208), [0, 1, 4, 3, 1, 2, 5, 4]);
        assert_eq!(integers(280), [4, 8]);
        assert_eq!(&bytes[280 + 8 + 16..], FOOTER.as_bytes());
    }

    #[test]
    fn a_profile_is_one_line() {
        let (header, bytes) = written([4, 1]);
        assert!(header.contains("NumberOfLines=\"1\""));
        assert!(header.contains("<Lines>"));
        assert!(!header.contains("Polys>"));
        let integers = |offset| array(&bytes, offset).into_iter().map(i64::from_le_bytes).collect::<Vec<_>>();
        let points = 8 + 4 * 8;
        let corners = points + 8 + 12 * 8;
        assert_eq!(integers(corners), [0, 1, 2, 3]);
        assert_eq!(integers(corners + 8 + 4 * 8), [4]);
    }
}
