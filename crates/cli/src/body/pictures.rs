//! Values on a section as maps and for a comparison: a row of points from the deepest level upwards, or one level.

use std::path::{Path, PathBuf};

use gfmd_body::Interior;
use gfmd_field::Grid;
use gfmd_plot::{Map, Maps, Mark, Series};

use super::component::Component;
use super::quantity::{Family, Fields, Quantity};
use super::rows::Rows;
use super::{Plane, evenly_spaced};
use gfmd_input::failure::Failure;
use gfmd_report::figures::{Drawn, about_zero, field, named};
use gfmd_unit::Units;

/// Values on one section, filled level by level.
pub(super) struct Pictures {
    pub(super) rows: Rows,
    levels: usize,
    maps: Vec<(Component, Vec<f64>)>,
    buffer: Vec<f64>,
}

/// Component of the reference and its difference from ours, as drawn.
pub(super) struct Compared {
    pub(super) component: Component,
    pub(super) shape: [usize; 2],
    pub(super) reference: Vec<f64>,
    pub(super) common: [usize; 2],
    /// Our values minus the reference, on the common points.
    pub(super) difference: Vec<f64>,
}

/// Position of the values of a section.
pub(super) struct Place<'a> {
    pub(super) grid: &'a Grid,
    pub(super) deepest: f64,
    pub(super) unit: &'a str,
    pub(super) units: &'a Units,
}

impl Place<'_> {
    /// Returns the label of a component, with its unit if known.
    fn label(&self, component: Component) -> String {
        let kind = component.quantity.kind();
        let unit = self.units.name(kind);
        if unit == kind { component.label.into() } else { format!("{} / {unit}", component.label) }
    }
}

impl Pictures {
    /// Allocates the values of the components on a row along one axis, or on one level.
    pub(super) fn new(components: &[Component], rows: Rows, levels: usize) -> Self {
        let maps = components.iter().map(|component| (*component, vec![0.0; rows.points.len() * levels])).collect();
        Self { rows, levels, maps, buffer: Vec::new() }
    }

    /// Returns the number of points of a map along its two axes.
    pub(super) fn shape(&self, grid: &Grid) -> [usize; 2] {
        if self.rows.is_level() { grid.points() } else { [self.rows.points.len(), self.levels] }
    }

    /// Returns the components with their values, row-major in the order of [`shape`](Self::shape).
    pub(super) fn values(&self) -> impl Iterator<Item = (Component, &[f64])> {
        self.maps.iter().map(|(component, values)| (*component, &values[..]))
    }

    /// Returns true if a component of this family is wanted.
    pub(super) fn wants(&self, family: Family) -> bool {
        self.maps.iter().any(|(component, _)| component.quantity.family() == family)
    }

    /// Stores the values at depth number `level`.
    pub(super) fn take(&mut self, family: Family, level: usize, fields: &Fields) {
        for (component, map) in self.maps.iter_mut().filter(|(component, _)| component.quantity.family() == family) {
            fields.values(component.quantity, &[component.index], &self.rows.points, &mut self.buffer);
            for (column, value) in map.chunks_exact_mut(self.levels).zip(&self.buffer) {
                column[self.levels - 1 - level] = *value;
            }
        }
    }

    /// Draws every component as `PREFIX-name.svg`, `.png`; for `compared` components also the reference and the
    /// difference.
    pub(super) fn draw(&self, prefix: &Path, place: &Place, compared: &[Compared]) -> Result<Vec<PathBuf>, Failure> {
        let shape = self.shape(place.grid);
        let mut files = Vec::new();
        for (component, values) in self.values() {
            let (stem, label) = (named(prefix, component.name), place.label(component));
            let Some(compared) = compared.iter().find(|compared| compared.component == component) else {
                let drawn = self.drawn(values, shape, &label, central(values), place);
                files.extend(drawn.save(&stem)?);
                continue;
            };
            let both = [values, &compared.reference].concat();
            let range = central(&both).or_else(|| whole(&both));
            let ours = self.drawn(values, shape, &label, range, place);
            let labels = ["reference", "less the reference"].map(|what| format!("{label}, {what}"));
            let theirs = self.drawn(&compared.reference, compared.shape, &labels[0], range, place);
            let less = &compared.difference;
            let difference = self.drawn(less, compared.common, &labels[1], about_zero(less), place);
            files.extend(match (ours, theirs, difference) {
                (Drawn::Map(ours), Drawn::Map(theirs), Drawn::Map(difference)) => {
                    Maps(vec![ours, theirs, difference]).save(&stem)?.to_vec()
                }
                (Drawn::Chart(mut ours), Drawn::Chart(theirs), _) => {
                    let reference = theirs.panels.into_iter().flat_map(|panel| panel.series);
                    let dashed = |series| Series { mark: Mark::Dashes, hue: 1, label: "reference".into(), ..series };
                    ours.panels[0].series.extend(reference.map(dashed));
                    ours.save(&stem)?.to_vec()
                }
                (ours, ..) => ours.save(&stem)?,
            });
        }
        Ok(files)
    }

    fn drawn<'v>(
        &self,
        values: &'v [f64],
        shape: [usize; 2],
        label: &str,
        range: Option<[f64; 2]>,
        place: &Place,
    ) -> Drawn<'v> {
        let Place { grid, deepest, unit, .. } = place;
        if self.rows.is_level() {
            let drawn = Grid::new(shape, grid.lengths()).map(|grid| field(&grid, values, label, unit));
            if let Ok(mut drawn) = drawn {
                if let Drawn::Map(map) = &mut drawn {
                    map.range = range;
                }
                return drawn;
            }
        }
        let axis = self.rows.axes[0];
        let mut map = Map::new(values, shape, [grid.lengths()[axis], *deepest], label);
        map.x = format!("*{}* / {unit}", ["x", "y"][axis]);
        map.y = format!("height above the lowest level / {unit}");
        map.range = range;
        Drawn::Map(map)
    }
}

/// Draws `quantities` on the section through the middle of a body: `PREFIX-name.svg`, `.png`.
pub fn draw_middle(
    interior: &Interior,
    quantities: &[Quantity],
    (levels, deepest): (usize, f64),
    prefix: &Path,
    unit: &str,
) -> Result<Vec<PathBuf>, Failure> {
    let components = Component::in_plane(quantities, None);
    let mut pictures = Pictures::new(&components, Rows::middle(interior.grid()), levels);
    let mut ws = interior.workspace();
    for (number, depth) in evenly_spaced(levels, deepest).enumerate() {
        for family in [Family::Displacement, Family::Deformation] {
            let fields = Fields::at(interior, family, Plane { depth, side: None }, &mut ws);
            pictures.take(family, number, &fields.map_err(|error| Failure::computation(error.to_string()))?);
        }
    }
    pictures.draw(prefix, &Place { grid: interior.grid(), deepest, unit, units: &Units::default() }, &[])
}

/// Returns the range of the values without two per mille at either end, if it is much narrower than the full range:
/// near singular edges a few values are far from all others.
fn central(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |per_mille: usize| sorted[(sorted.len() - 1) * per_mille / 1000];
    let (whole, most) = (at(1000) - at(0), at(998) - at(2));
    (most > 0.0 && whole > 1.5 * most).then(|| [at(2), at(998)])
}

/// Returns the range of all values, unless they are equal.
fn whole(values: &[f64]) -> Option<[f64; 2]> {
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (v.min(least), v.max(most)));
    (most > least).then_some([least, most])
}
