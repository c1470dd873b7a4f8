//! Last load as a VTK file: the surface with its fields as point data.

use std::path::{Path, PathBuf};

use gfmd_files::vti::{Image, Lattice};
use gfmd_files::vtp::{Sheet, write};
use gfmd_files::{Output, PointArray, contiguous};
use gfmd_problem::key;
use ndarray::Array2;

use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_report::figures::SceneFields;
use gfmd_run::series::Field;

/// VTK file to write.
pub(super) struct VtkFile {
    output: Output,
    kind: VtkKind,
}

/// Kinds of files.
enum VtkKind {
    /// Points of the undeformed surface.
    Image,
    /// Deformed surface.
    Polygons,
}

const OPTION: &str = "vtk";

impl VtkFile {
    /// Claims the path.
    ///
    /// # Errors
    /// Returns an error if the extension is not `.vti` or `.vtp`, or if the path cannot be written.
    pub(super) fn claim(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
        let kind = match extension.as_ref().and_then(|extension| extension.to_str()) {
            Some("vti") => VtkKind::Image,
            Some("vtp") => VtkKind::Polygons,
            _ => return Err(Failure::value(key(OPTION), path.display(), "NAME.vti or NAME.vtp")),
        };
        let output = Output::claim(path).map_err(|error| Failure::input(key(OPTION), error))?;
        Ok(Self { output, kind })
    }

    /// Writes a state with its `fields`, the heights of the rigid surface, and 1 for the points in contact. Polygons
    /// have their points on the deformed surface, moved by `lateral`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub(super) fn write(
        &self,
        surface: &Surface,
        shown: &SceneFields,
        fields: &[Field],
        lateral: &[Array2<f64>],
    ) -> Result<PathBuf, Failure> {
        let (unit, known) = (surface.unit(), surface.units());
        let named: Vec<String> = fields.iter().map(|field| known.name(field.units)).collect();
        let scalar = |name, units| PointArray { name, components: &[], units };
        let contact: Vec<f64> = shown.repulsion.iter().map(|p| f64::from(u8::from(*p > 0.0))).collect();
        let mut arrays: Vec<_> = (fields.iter().zip(&named))
            .map(|(Field { name, values, .. }, units)| (scalar(name, units), contiguous(values)))
            .collect();
        arrays.push((scalar("height", unit), contiguous(&surface.heights)));
        arrays.push((scalar("contact", "1"), contact.into()));
        let ([nx, ny], [dx, dy]) = (surface.grid.points(), surface.grid.spacing());
        match self.kind {
            VtkKind::Image => {
                let lattice = Lattice { points: [nx, ny, 1], origin: [0.0; 3], spacing: [dx, dy, dx] };
                let declared: Vec<PointArray> = arrays.iter().map(|(array, _)| *array).collect();
                let mut image = Image::create(&self.output, lattice, &declared)?;
                for (index, (_, values)) in arrays.iter().enumerate() {
                    image.write_plane(index, 0, values)?;
                }
                Ok(image.finish()?)
            }
            VtkKind::Polygons => {
                let moved = |axis: usize, i, j| lateral.get(axis).map_or(0.0, |u| u[[i, j]]);
                let position = |i: usize, j: usize| {
                    [i as f64 * dx + moved(0, i, j), j as f64 * dy + moved(1, i, j), shown.level[i * ny + j]]
                };
                let values: Vec<_> = arrays.iter().map(|(array, values)| (*array, &**values)).collect();
                Ok(write(&self.output, &Sheet { points: [nx, ny], position: &position }, &values)?)
            }
        }
    }
}
