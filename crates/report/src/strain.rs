//! Figures of plastic strain below a surface.

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_plot::{Below, Map};
use maud::html;
use ndarray::Array2;

use crate::figures::{Drawn, field, largest, length, short, sides};
use crate::page::{Page, StoredSurface};

/// Number of rows of a section.
const ROWS: usize = 160;

/// Depth of a section divided by the depth to which the body has yielded.
const MARGIN: f64 = 1.25;

/// Passes the map of the plastic displacement, or its profile for a line contact, to `take`.
pub fn imprint_of<R>(grid: &Grid, displacement: &[f64], unit: &str, take: impl FnOnce(&Drawn) -> R) -> R {
    let read = length(unit, largest(displacement));
    let scaled: Vec<f64> = displacement.iter().map(|u| u * read.factor).collect();
    take(&field(grid, &scaled, &format!("plastic displacement *u*_z / {}", read.name), unit))
}

/// Passes the section of the equivalent plastic strain through its largest value, along x, to `take`; `None` if nothing
/// has yielded, or if there is a cell without points. The cells have these `depths` of their bottoms and these strains,
/// each on its own grid.
pub fn section_of<R>(
    grid: &Grid,
    depths: &[f64],
    equivalent: &[Array2<f64>],
    unit: &str,
    take: impl FnOnce(&Drawn) -> R,
) -> Option<R> {
    if equivalent.len() != depths.len() || equivalent.iter().any(Array2::is_empty) {
        return None;
    }
    let [nx, ny] = grid.points();
    let of_cell = |strain: &Array2<f64>| strain.iter().copied().fold(0.0, f64::max);
    let peaks: Vec<f64> = equivalent.iter().map(of_cell).collect();
    let lowest = peaks.iter().rposition(|peak| *peak > 0.0)?;
    let highest = (0..peaks.len()).max_by(|a, b| peaks[*a].total_cmp(&peaks[*b]))?;
    let ((_, row), _) = equivalent[highest].indexed_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    // The row on the grid of the surface.
    let row = row * (ny / equivalent[highest].dim().1.max(1));
    let bottom = (MARGIN * depths[lowest]).min(*depths.last()?);
    let strain_at = |depth: f64, i: usize| {
        let cell = depths.partition_point(|end| *end < depth).min(depths.len() - 1);
        let (columns, rows) = equivalent[cell].dim();
        equivalent[cell][[i * columns / nx, row * rows / ny]]
    };
    let row_depth = |k: usize| bottom * (1.0 - (k as f64 + 0.5) / ROWS as f64);
    let values: Vec<f64> =
        (0..nx).flat_map(|i| (0..ROWS).map(move |k| (i, k))).map(|(i, k)| strain_at(row_depth(k), i)).collect();
    let side = sides(grid, unit);
    let [lx, depth] = [grid.lengths()[0], bottom].map(|length| length * side.factor);
    let mut map = Map::new(&values, [nx, ROWS], [lx, depth], "equivalent plastic strain *κ*");
    map.origin = [0.0, -depth];
    map.x = format!("*x* / {}, at *y* = {}", side.name, short(row as f64 * grid.spacing()[1] * side.factor));
    map.y = format!("*z* / {}", side.name);
    map.below = Some(Below::pale(0.0, "elastic"));
    Some(take(&Drawn::Map(map)))
}

/// Adds the plastic displacement at waypoint `index`, and the section of the plastic strain at the end, if the file has
/// them.
pub(crate) fn strained_body(page: &mut Page, reader: &Reader, surface: &StoredSurface, index: usize) {
    let Ok(displacement) = surface.field(reader, "plastic_displacement_z", index) else { return };
    imprint_of(&surface.grid, &displacement, &surface.unit, |drawn| {
        let caption = html! { "Normal displacement by plastic strain: the imprint that remains without load." };
        page.field(drawn, "the imprint", &caption);
    });
    let Ok(depths) = reader.values::<f64>("/cells/depth") else { return };
    let strains = (0..depths.len()).map(|cell| {
        let path = format!("/plastic/equivalent_{cell}");
        let shape = reader.shape(&path).ok().and_then(|shape| <[usize; 2]>::try_from(shape).ok())?;
        Array2::from_shape_vec(shape, reader.values(&path).ok()?).ok()
    });
    let Some(equivalent) = strains.collect::<Option<Vec<_>>>() else { return };
    section_of(&surface.grid, &depths, &equivalent, &surface.unit, |drawn| {
        let caption =
            html! { "Equivalent plastic strain in the plane through its largest value, after the last step." };
        page.field(drawn, "the plastic zone below the surface", &caption);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_goes_through_the_largest_strain_and_needs_points() {
        let grid = Grid::square(4, 1.0).unwrap();
        let mut top = Array2::zeros((4, 4));
        top[[1, 3]] = 0.2;
        // The second cell has a grid of half the points.
        let mut below = Array2::zeros((2, 2));
        below[[0, 1]] = 0.1;
        let cells = [top, below];
        let drawn = section_of(&grid, &[0.1, 0.4], &cells, "length", |drawn| match drawn {
            Drawn::Map(map) => (map.values.to_vec(), map.shape, map.x.clone()),
            Drawn::Chart(_) => panic!("a section is a map"),
        });
        let (values, shape, label) = drawn.unwrap();
        assert_eq!(shape, [4, ROWS]);
        assert!(label.ends_with("0.75"), "{label}");
        // From the bottom up, at the second place along x.
        let column = &values[ROWS..2 * ROWS];
        assert_eq!((column[0], column[ROWS - 1]), (0.1, 0.2));
        assert!(values[3 * ROWS..].iter().all(|strain| *strain == 0.0));
        let none = |cells: &[Array2<f64>]| section_of(&grid, &[0.1], cells, "length", |_| ()).is_none();
        assert!(none(&[Array2::zeros((4, 4))]) && none(&[Array2::zeros((0, 0))]) && none(&[]));
    }
}
