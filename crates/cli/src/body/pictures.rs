//! Maps of a section: values on a row of points, from the deepest level upwards.

use std::path::{Path, PathBuf};

use gfmd_body::Interior;
use gfmd_field::Grid;
use gfmd_plot::Map;

use super::quantity::{Family, Fields, Quantity};
use super::rows::Rows;
use super::{Plane, evenly_spaced};
use crate::failure::Failure;
use crate::figures::named;

/// The maps of one section, filled level by level.
pub(super) struct Pictures {
    rows: Rows,
    levels: usize,
    maps: Vec<(Picture, Vec<f64>)>,
    buffer: Vec<f64>,
}

/// A component of a quantity, with its name in the file and in the figure.
#[derive(Clone, Copy)]
struct Picture {
    quantity: Quantity,
    component: usize,
    name: &'static str,
    label: &'static str,
}

const fn picture(quantity: Quantity, component: usize, name: &'static str, label: &'static str) -> Picture {
    Picture { quantity, component, name, label }
}

const ALONG: [&[Picture]; 2] = [
    &[
        picture(Quantity::Displacement, 0, "ux", "displacement *u*_x"),
        picture(Quantity::Displacement, 2, "uz", "displacement *u*_z"),
        picture(Quantity::Stress, 0, "sxx", "stress *σ*_{xx}"),
        picture(Quantity::Stress, 2, "szz", "stress *σ*_{zz}"),
        picture(Quantity::Stress, 4, "sxz", "stress *σ*_{xz}"),
        picture(Quantity::VonMises, 0, "mises", "von Mises stress"),
        picture(Quantity::EnergyDensity, 0, "energy", "elastic energy density"),
    ],
    &[
        picture(Quantity::Displacement, 1, "uy", "displacement *u*_y"),
        picture(Quantity::Displacement, 2, "uz", "displacement *u*_z"),
        picture(Quantity::Stress, 1, "syy", "stress *σ*_{yy}"),
        picture(Quantity::Stress, 2, "szz", "stress *σ*_{zz}"),
        picture(Quantity::Stress, 3, "syz", "stress *σ*_{yz}"),
        picture(Quantity::VonMises, 0, "mises", "von Mises stress"),
        picture(Quantity::EnergyDensity, 0, "energy", "elastic energy density"),
    ],
];

impl Pictures {
    /// Allocates the maps of the quantities on a row along one axis.
    pub(super) fn new(quantities: &[Quantity], rows: Rows, levels: usize) -> Self {
        let drawn = ALONG[rows.axes[0]].iter().filter(|picture| quantities.contains(&picture.quantity));
        let maps = drawn.map(|picture| (*picture, vec![0.0; rows.points.len() * levels])).collect();
        Self { rows, levels, maps, buffer: Vec::new() }
    }

    /// Takes the values at depth number `level`.
    pub(super) fn take(&mut self, family: Family, level: usize, fields: &Fields) {
        for (picture, map) in self.maps.iter_mut().filter(|(picture, _)| picture.quantity.family() == family) {
            fields.values(picture.quantity, &[picture.component], &self.rows.points, &mut self.buffer);
            for (column, value) in map.chunks_exact_mut(self.levels).zip(&self.buffer) {
                column[self.levels - 1 - level] = *value;
            }
        }
    }

    pub(super) fn draw(&self, prefix: &Path, grid: &Grid, deepest: f64, unit: &str) -> Result<Vec<PathBuf>, Failure> {
        let axis = self.rows.axes[0];
        let (shape, size) = ([self.rows.points.len(), self.levels], [grid.lengths()[axis], deepest]);
        let mut files = Vec::new();
        for (picture, values) in &self.maps {
            let mut map = Map::new(values, shape, size, picture.label);
            map.x = format!("*{}* / {unit}", ["x", "y"][axis]);
            map.y = format!("height above the lowest level / {unit}");
            map.range = central(values);
            files.extend(map.save(&named(prefix, picture.name))?);
        }
        Ok(files)
    }
}

/// Draws some quantities on the section through the middle of a body: `PREFIX-name.svg`, `.png`.
pub fn draw_middle(
    interior: &Interior,
    quantities: &[Quantity],
    (levels, deepest): (usize, f64),
    prefix: &Path,
    unit: &str,
) -> Result<Vec<PathBuf>, Failure> {
    let mut pictures = Pictures::new(quantities, Rows::middle(interior.grid()), levels);
    let mut ws = interior.workspace();
    for (number, depth) in evenly_spaced(levels, deepest).enumerate() {
        for family in [Family::Displacement, Family::Deformation] {
            let fields = Fields::at(interior, family, Plane { depth, side: None }, &mut ws);
            pictures.take(family, number, &fields.map_err(|error| Failure::Computation(error.to_string()))?);
        }
    }
    pictures.draw(prefix, interior.grid(), deepest, unit)
}

/// The range of the values without two per mille at either end, if it is much narrower than the full range: near singular
/// edges a few values are far from all others.
fn central(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |per_mille: usize| sorted[(sorted.len() - 1) * per_mille / 1000];
    let (whole, most) = (at(1000) - at(0), at(998) - at(2));
    (most > 0.0 && whole > 1.5 * most).then(|| [at(2), at(998)])
}
