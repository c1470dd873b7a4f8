//! File of the fields, written plane by plane.

use std::path::PathBuf;

use gfmd_field::Grid;
use gfmd_files::vti::{Image, Lattice};
use gfmd_files::{Archive, Dimension, Output, PointArray, Provenance, Variable, axes};
use gfmd_problem::{key, words};

use super::quantity::{AXES, AXES_OF_A_LINE, Fields, Quantity, TENSOR, TENSOR_OF_A_LINE};
use super::rows::Rows;
use super::{Level, Plane, Side};
use gfmd_input::failure::Failure;
use gfmd_unit::Units;

/// Positions of the values.
pub(super) struct Planes<'a> {
    /// Mean traction on the surface, by component.
    pub(super) mean_traction: &'a [f64],
    pub(super) grid: &'a Grid,
    pub(super) rows: &'a Rows,
    pub(super) below: &'a [Plane],
    /// True if the depths are evenly spaced, from the surface downwards.
    pub(super) even: bool,
    /// Height of a slab.
    pub(super) height: Option<f64>,
    pub(super) units: &'a Units,
}

/// File of fields during writing: HDF5 by depth, or VTK image data by height.
pub(super) struct Volume<'a> {
    sink: Sink<'a>,
    arrays: Vec<(Quantity, &'static [usize])>,
    points: Vec<usize>,
    buffer: Vec<f64>,
}

enum Sink<'a> {
    Archive(Archive<'a>),
    Image { image: Box<Image<'a>>, top: usize },
}

impl<'a> Volume<'a> {
    pub(super) fn create(
        output: &'a Output,
        planes: &Planes,
        quantities: &[Quantity],
        provenance: &Provenance,
        origin: Option<&(String, String)>,
    ) -> Result<Self, Failure> {
        let extension = output.path().extension().map(|extension| extension.to_ascii_lowercase());
        let sink = match extension.as_ref().and_then(|extension| extension.to_str()) {
            Some("vti") => image(output, planes, quantities)?,
            _ if output.in_memory().is_some() => archive(output, planes, quantities, provenance, origin)?,
            Some("h5" | "hdf5") => archive(output, planes, quantities, provenance, origin)?,
            _ => return Err(Failure::value(key("out"), output.path().display(), "NAME.h5 or NAME.vti")),
        };
        let components = |quantity| match sink {
            Sink::Archive(_) => archive_components(quantity, planes.grid.is_line()),
            Sink::Image { .. } => image_components(quantity),
        };
        let arrays = quantities.iter().map(|&quantity| (quantity, components(quantity))).collect();
        Ok(Self { sink, arrays, points: planes.rows.points.clone(), buffer: Vec::new() })
    }

    /// Writes quantity number `array` at depth number `level`.
    pub(super) fn write(&mut self, array: usize, level: usize, fields: &Fields) -> Result<(), Failure> {
        let (quantity, components) = self.arrays[array];
        fields.values(quantity, components, &self.points, &mut self.buffer);
        match &mut self.sink {
            Sink::Archive(archive) => archive.write_slab(&path(quantity), level, &self.buffer)?,
            Sink::Image { image, top } => image.write_plane(array, *top - level, &self.buffer)?,
        }
        Ok(())
    }

    /// Completes the file; an archive also has the numbers at each depth.
    pub(super) fn finish(self, planes: &Planes, levels: &[Level]) -> Result<PathBuf, Failure> {
        Ok(match self.sink {
            Sink::Archive(mut archive) => {
                let depth = planes.depth();
                for (name, kind, long_name, number) in Level::NUMBERS {
                    let variable = Variable { dimensions: &[&depth], units: &planes.units.name(kind), long_name };
                    let values: Vec<f64> = levels.iter().map(number).collect();
                    archive.write(&format!("/fields/{name}"), &variable, &values)?;
                }
                archive.finish()?
            }
            Sink::Image { image, .. } => image.finish()?,
        })
    }
}

impl Planes<'_> {
    fn depth(&self) -> Dimension {
        let depths = self.below.iter().map(|plane| plane.depth).collect();
        Dimension::values("depth", depths, &self.units.name("length"), "depth below the surface")
    }
}

fn path(quantity: Quantity) -> String {
    format!("/fields/{}", quantity.name())
}

pub(super) fn archive_components(quantity: Quantity, line: bool) -> &'static [usize] {
    match (quantity, line) {
        (Quantity::Displacement, false) => &[0, 1, 2],
        (Quantity::Displacement, true) => &AXES_OF_A_LINE,
        (Quantity::Strain | Quantity::Stress, false) => &[0, 1, 2, 3, 4, 5],
        (Quantity::Strain | Quantity::Stress, true) => &TENSOR_OF_A_LINE,
        (Quantity::VonMises | Quantity::EnergyDensity, _) => &[0],
    }
}

/// Creates `/fields/<quantity>[depth, x, y, component]`, and `/fields/z[depth]` for a slab.
fn archive<'a>(
    output: &'a Output,
    planes: &Planes,
    quantities: &[Quantity],
    provenance: &Provenance,
    origin: Option<&(String, String)>,
) -> Result<Sink<'a>, Failure> {
    let (grid, unit) = (planes.grid, &*planes.units.name("length"));
    let mut archive = Archive::create(output, provenance)?;
    if let Some((input, checksum)) = origin {
        archive.attribute("/input", "file", input.as_str())?;
        archive.attribute("/input", "file_sha256", checksum.as_str())?;
    }
    let depths: Vec<f64> = planes.below.iter().map(|plane| plane.depth).collect();
    let depth = planes.depth();
    if planes.below.iter().any(|plane| plane.side.is_some()) {
        let side = |plane: &Plane| plane.side.map_or(0.0, |side| if side == Side::Above { 1.0 } else { -1.0 });
        let long_name = "side of a plane between two layers: 1 in the upper, -1 in the lower one, else 0";
        let variable = Variable { dimensions: &[&depth], units: "1", long_name };
        archive.write("/fields/side", &variable, &planes.below.iter().map(side).collect::<Vec<f64>>())?;
    }
    if let Some(height) = planes.height {
        let z: Vec<f64> = depths.iter().map(|depth| height - depth).collect();
        let variable = Variable { dimensions: &[&depth], units: unit, long_name: "height above the base" };
        archive.write("/fields/z", &variable, &z)?;
    }
    let lateral = axes(grid, unit);
    let labels = |quantity, names: &[&'static str]| -> Vec<&'static str> {
        archive_components(quantity, grid.is_line()).iter().map(|&component| names[component]).collect()
    };
    let vector = Dimension::labels("component", &labels(Quantity::Displacement, &AXES), "component of a vector");
    let long_name = "mean traction on the surface, equal to the mean of these stresses at every depth";
    let variable = Variable { dimensions: &[&vector], units: &planes.units.name("stress"), long_name };
    archive.write("/fields/mean_traction", &variable, planes.mean_traction)?;
    let tensor = Dimension::labels("tensor", &labels(Quantity::Stress, &TENSOR), "component of a symmetric tensor");
    for &quantity in quantities {
        let last = match quantity {
            Quantity::Displacement => Some(&vector),
            Quantity::Strain | Quantity::Stress => Some(&tensor),
            Quantity::VonMises | Quantity::EnergyDensity => None,
        };
        let (units, long_name) = (&*planes.units.name(quantity.kind()), quantity.long_name());
        let mut dimensions = vec![&depth];
        dimensions.extend(planes.rows.axes.iter().map(|&axis| &lateral[axis]));
        dimensions.extend(last);
        archive.define(&path(quantity), &Variable { dimensions: &dimensions, units, long_name })?;
    }
    for (name, points) in ["points_x", "points_y"].into_iter().zip(grid.points()) {
        archive.attribute("/fields", name, points as u64)?;
    }
    if let Some(slice) = planes.rows.selected() {
        archive.attribute("/fields", "slice", slice.to_string())?;
    }
    Ok(Sink::Archive(archive))
}

/// Returns the components of a quantity, for tensors in the order of ParaView.
fn image_components(quantity: Quantity) -> &'static [usize] {
    match quantity {
        Quantity::Displacement => &[0, 1, 2],
        Quantity::Strain | Quantity::Stress => &[0, 1, 2, 5, 3, 4],
        Quantity::VonMises | Quantity::EnergyDensity => &[0],
    }
}

/// Creates image data. z is the height above the base of a slab, or above the surface of a half-space.
fn image<'a>(output: &'a Output, planes: &Planes, quantities: &[Quantity]) -> Result<Sink<'a>, Failure> {
    let [Plane { depth: first, .. }, Plane { depth: second, .. }, ..] = planes.below else {
        return Err(Failure::input(key("out"), "image data needs at least two depths"));
    };
    if !planes.even {
        return Err(Failure::because(
            key("out"),
            words!["image data needs evenly spaced depths: ", key("levels"), " instead of ", key("depths")],
        ));
    }
    let ([nx, ny], [x, y], [dx, dy]) = (planes.rows.shape(planes.grid), planes.rows.origin(), planes.grid.spacing());
    let top = planes.below.len() - 1;
    let lattice = Lattice {
        points: [nx, ny, top + 1],
        origin: [x, y, planes.height.unwrap_or(0.0) - planes.below[top].depth],
        spacing: [dx, dy, second - first],
    };
    let names: Vec<String> = quantities.iter().map(|quantity| planes.units.name(quantity.kind())).collect();
    let arrays: Vec<PointArray> = quantities
        .iter()
        .zip(&names)
        .map(|(quantity, units)| {
            let components: &[&str] = match image_components(*quantity).len() {
                3 => &["X", "Y", "Z"],
                6 => &["XX", "YY", "ZZ", "XY", "YZ", "XZ"],
                _ => &[],
            };
            PointArray { name: quantity.name(), components, units }
        })
        .collect();
    Ok(Sink::Image { image: Box::new(Image::create(output, lattice, &arrays)?), top })
}
