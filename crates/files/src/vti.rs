//! VTK image data (`.vti`) for ParaView and similar programs: values on a regular grid, written plane by plane.
//!
//! The values follow the header in binary form. The position of each plane in the file is therefore known in advance,
//! and no plane is kept in memory. x varies fastest; z varies slowest and points upwards. (The crate `vtkio` needs the
//! whole volume in memory, and has not been maintained since 2022.)

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::PathBuf;

use crate::vtk::{FOOTER, Header, LENGTH, PointArray, VALUE};
use crate::{FileError, Output};

/// Regular grid of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Number of points along x, y, z.
    pub points: [usize; 3],
    /// First point.
    pub origin: [f64; 3],
    /// Distance between neighbours along x, y, z.
    pub spacing: [f64; 3],
}

/// Image file being written to `NAME.part`; [`Image::finish`] renames it to the target.
#[derive(Debug)]
pub struct Image<'a> {
    output: &'a Output,
    file: BufWriter<File>,
    lattice: Lattice,
    /// Number of components of each array, and the offset of its values in the file.
    arrays: Vec<(usize, u64)>,
    finished: bool,
}

impl<'a> Image<'a> {
    /// Creates a file without values, which [`Image::write_plane`] then writes.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(output: &'a Output, lattice: Lattice, arrays: &[PointArray]) -> Result<Self, FileError> {
        let (header, bytes) = header(&lattice, arrays);
        let part = output.part();
        let write = || -> io::Result<BufWriter<File>> {
            let mut file = BufWriter::new(File::create(&part)?);
            file.write_all(header.as_bytes())?;
            // Values that are not yet written are zero.
            let mut place = header.len() as u64;
            for &bytes in &bytes {
                file.seek(SeekFrom::Start(place))?;
                file.write_all(&bytes.to_le_bytes())?;
                place += LENGTH + bytes;
            }
            file.seek(SeekFrom::Start(place))?;
            file.write_all(FOOTER.as_bytes())?;
            Ok(file)
        };
        let file = write().map_err(|source| FileError::Io { action: "write", path: part, source })?;
        let mut place = header.len() as u64;
        let places = arrays.iter().zip(bytes).map(|(array, bytes)| {
            let begin = place + LENGTH;
            place = begin + bytes;
            (array.width(), begin)
        });
        Ok(Self { output, file, lattice, arrays: places.collect(), finished: false })
    }

    /// Writes the values `[x, y, component]` of array number `array` on plane `level`, counted upwards.
    ///
    /// # Errors
    /// A file that cannot be written.
    ///
    /// # Panics
    /// If there is no such array or plane, or if the number of values does not match the plane.
    pub fn write_plane(&mut self, array: usize, level: usize, values: &[f64]) -> Result<(), FileError> {
        let ([nx, ny, nz], (width, begin)) = (self.lattice.points, self.arrays[array]);
        assert!(level < nz && values.len() == nx * ny * width, "a plane of the lattice");
        let mut write = || -> io::Result<()> {
            self.file.seek(SeekFrom::Start(begin + (level * values.len() * VALUE) as u64))?;
            for j in 0..ny {
                for i in 0..nx {
                    for value in &values[(i * ny + j) * width..][..width] {
                        self.file.write_all(&value.to_le_bytes())?;
                    }
                }
            }
            Ok(())
        };
        write().map_err(|source| FileError::Io { action: "write", path: self.output.part(), source })
    }

    /// Completes the file, syncs it to the disk, and renames it to the target.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<PathBuf, FileError> {
        let path = self.output.part();
        self.file.flush().map_err(|source| FileError::Io { action: "write", path, source })?;
        self.output.publish()?;
        self.finished = true;
        Ok(self.output.path().to_path_buf())
    }
}

impl Drop for Image<'_> {
    fn drop(&mut self) {
        if !self.finished {
            let _ = std::fs::remove_file(self.output.part());
        }
    }
}

/// Returns the XML header up to the first appended byte, and the length of each array in bytes.
fn header(lattice: &Lattice, arrays: &[PointArray]) -> (String, Vec<u64>) {
    let Lattice { points, origin, spacing } = lattice;
    let extent = points.map(|n| format!("0 {}", n - 1)).join(" ");
    let triple = |values: &[f64; 3]| values.map(|value| format!("{value:e}")).join(" ");
    let (origin, spacing) = (triple(origin), triple(spacing));
    let place = format!(" WholeExtent=\"{extent}\" Origin=\"{origin}\" Spacing=\"{spacing}\"");
    let mut header = Header::new("ImageData", &place);
    header.add(&format!("<Piece Extent=\"{extent}\">"));
    header.point_data(arrays, points.iter().product());
    header.end("ImageData")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(name: &str) -> PointArray<'_> {
        PointArray { name, components: &[], units: "" }
    }

    #[test]
    fn planes_land_where_the_header_says_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("volume.vti")).unwrap();
        let lattice = Lattice { points: [3, 2, 2], origin: [0.0; 3], spacing: [0.5, 0.5, 0.25] };
        let arrays = [scalar("height"), PointArray { components: &["X", "Y"], ..scalar("place") }];
        let mut image = Image::create(&output, lattice, &arrays).unwrap();
        for level in [1, 0] {
            image.write_plane(0, level, &[level as f64; 6]).unwrap();
            let places: Vec<f64> = (0..6).flat_map(|p| [(p / 2) as f64, (p % 2) as f64]).collect();
            image.write_plane(1, level, &places).unwrap();
        }
        let bytes = std::fs::read(image.finish().unwrap()).unwrap();
        let start = bytes.windows(2).position(|pair| pair == b"\n_").unwrap() + 2;
        let number = |index: usize| f64::from_le_bytes(bytes[start + 8 + 8 * index..][..8].try_into().unwrap());
        assert_eq!(u64::from_le_bytes(bytes[start..][..8].try_into().unwrap()), 96);
        assert_eq!([0, 5, 6, 11].map(number), [0.0, 0.0, 1.0, 1.0]);
        // The values after the second length field; x varies fastest.
        assert_eq!([13, 14, 15, 16, 17, 18, 19, 20].map(number), [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 1.0]);
        let text = String::from_utf8_lossy(&bytes[..start]).into_owned();
        assert!(text.contains("WholeExtent=\"0 2 0 1 0 1\"") && text.contains("offset=\"104\""), "{text}");
        assert!(bytes.ends_with(FOOTER.as_bytes()) && bytes.len() == start + 8 + 96 + 8 + 192 + FOOTER.len());
    }

    #[test]
    fn a_file_given_up_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("volume.vti")).unwrap();
        let lattice = Lattice { points: [2, 2, 2], origin: [0.0; 3], spacing: [1.0; 3] };
        drop(Image::create(&output, lattice, &[scalar("u")]).unwrap());
        drop(output);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
