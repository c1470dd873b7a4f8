use gfmd_field::{Grid, Share};
use gfmd_green::{Base, Body, Ground, Height, Material};

use crate::division::Division;
use crate::{Hardening, PlasticityError};

/// Cells below the surface in which plastic strain is constant in depth, counted from the surface down. Only the
/// material in cells can yield; below them the body is elastic, without an error of discretisation.
///
/// A cell lives on a grid that is coarser than the surface by its coarsening, a power of two. Strains of waves that
/// this grid does not have decay above the cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Thickness that grows with depth, from the surface to the bottom of the lowest layer that yields, or to half of
    /// the cell length in a half-space. Cells end at the interfaces of layers.
    Graded {
        /// Thickness of the first cell, in spacings of the grid; at most, since cells are fitted to the layers.
        thickness: f64,
        /// Thickness of a cell divided by the thickness of the cell above, from 1 to 2.
        growth: f64,
        /// Depth of a cell divided by the largest spacing of its grid; 0 for no coarsening.
        coarsening: f64,
    },
    /// Cells of equal thickness on the grid of the surface.
    Uniform {
        /// Number of cells.
        count: usize,
        /// Depth of the bottom of the last one, in length.
        depth: f64,
    },
    /// Cells one by one.
    List {
        /// Thicknesses, in length.
        thicknesses: Vec<f64>,
        /// Coarsenings; empty for none.
        coarsenings: Vec<usize>,
    },
}

impl Default for Cells {
    /// Returns graded cells from half a spacing, growing by 1.12, with a spacing of at most a third of the depth.
    fn default() -> Self {
        Self::Graded { thickness: 0.5, growth: 1.12, coarsening: 3.0 }
    }
}

/// Cell of a body: all that its strains depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Thickness, in length.
    pub thickness: f64,
    /// Depth of its bottom below the surface, in length.
    pub depth: f64,
    /// Spacing of its grid divided by the spacing of the surface.
    pub coarsening: usize,
    pub(crate) shear_modulus: f64,
    /// C11 = 2μ (1 − ν)/(1 − 2ν).
    pub(crate) p_wave_modulus: f64,
    /// Hardening, if the material yields.
    pub(crate) hardening: Option<Hardening>,
}

/// Part of a body below its cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Below {
    Body(Body),
    Ground(Ground),
}

/// Cells of a body on a grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mesh {
    pub(crate) grid: Grid,
    pub(crate) cells: Vec<Cell>,
    pub(crate) below: Below,
    /// True if the lowest cell lies in a half-space.
    pub(crate) reaches_half_space: bool,
    /// True if the layer of the lowest cell goes on below it, where it cannot yield.
    pub(crate) is_cut: bool,
    /// True if the cells were made to fit the body, and not given.
    pub(crate) is_fitted: bool,
    /// Points of this process.
    pub(crate) division: Division,
}

/// Largest Poisson's ratio of a material with cells: their strains lock as it approaches 1/2.
const POISSON: f64 = 0.495;

/// Least number of points along a side of the grid of a cell in a list, and in graded cells.
const LEAST_POINTS: usize = 4;
const LEAST_POINTS_OF_GRADED: usize = 16;

/// Largest relative difference between depths that count as equal.
const ROUNDING_OF_DEPTH: f64 = 1e-9;

/// Layer of a body, from the surface down.
struct Layer {
    material: Material,
    top: f64,
    bottom: f64,
}

fn layers(body: &Body) -> Vec<Layer> {
    let (mut found, mut top, mut next) = (Vec::new(), 0.0, Some(body));
    while let Some(body) = next {
        let height = match body.height() {
            Height::Finite(height) => height,
            Height::Infinite => f64::INFINITY,
        };
        found.push(Layer { material: *body.material(), top, bottom: top + height });
        top += height;
        next = match (body.height(), body.base()) {
            (Height::Finite(_), Base::Elastic(below)) => Some(below),
            _ => None,
        };
    }
    found
}

/// Returns what is left of a body below a depth, which is at most its height.
fn below(body: &Body, depth: f64) -> Result<Below, PlasticityError> {
    let Height::Finite(height) = body.height() else { return Ok(Below::Body(body.clone())) };
    if depth < height * (1.0 - ROUNDING_OF_DEPTH) {
        let rest = Body::slab(*body.material(), height - depth).and_then(|slab| slab.on(body.base().clone()));
        return Ok(Below::Body(rest.map_err(gfmd_contact::Refusal::from)?));
    }
    match body.base() {
        Base::Rigid(ground) => Ok(Below::Ground(*ground)),
        Base::Elastic(lower) => below(lower, (depth - height).max(0.0)),
    }
}

impl Cells {
    /// Returns the cells in a body below a surface on `grid`, from the surface down. `hardening` has one entry per
    /// layer of the body, from the top, `None` for a layer that does not yield.
    ///
    /// # Errors
    /// The errors of [`YieldingContact::new`](crate::YieldingContact::new), except for the heights.
    pub fn in_body(
        &self,
        body: &Body,
        grid: &Grid,
        hardening: &[Option<Hardening>],
    ) -> Result<Vec<Cell>, PlasticityError> {
        Ok(self.mesh(body, grid, hardening)?.cells)
    }

    /// Makes the cells of a body with one hardening per layer, from the top; `None` for a layer that does not yield.
    pub(crate) fn mesh(
        &self,
        body: &Body,
        grid: &Grid,
        hardening: &[Option<Hardening>],
    ) -> Result<Mesh, PlasticityError> {
        if body.tabulated_wavenumbers().is_some() {
            return Err(PlasticityError::Tabulated);
        }
        let body = body.alone();
        let layers = layers(&body);
        if hardening.len() != layers.len() {
            return Err(PlasticityError::Layers { found: hardening.len(), layers: layers.len() });
        }
        let Some(lowest) = hardening.iter().rposition(Option::is_some) else {
            return Err(PlasticityError::NothingYields);
        };
        for (layer, hardening) in layers.iter().zip(hardening) {
            let limit = 0.1 * layer.material.young();
            if let Some(found) = hardening.as_ref().map(Hardening::yield_stress).filter(|found| *found >= limit) {
                return Err(PlasticityError::YieldStrain { found, limit });
            }
        }
        let thicknesses = self.thicknesses(grid, &layers[..=lowest])?;
        let coarsenings = self.coarsenings(grid, &thicknesses)?;
        let mut cells: Vec<Cell> = Vec::new();
        let mut place = 0;
        for (thickness, coarsening) in thicknesses.into_iter().zip(coarsenings) {
            let top = cells.last().map_or(0.0, |cell| cell.depth);
            if place + 1 < layers.len() && top >= layers[place].bottom * (1.0 - ROUNDING_OF_DEPTH) {
                place += 1;
            }
            let Layer { material, bottom: interface, .. } = &layers[place];
            let depth = top + thickness;
            let over = depth > interface * (1.0 + ROUNDING_OF_DEPTH);
            if over && place + 1 == layers.len() {
                return Err(PlasticityError::BelowBody { found: depth, height: *interface });
            } else if over {
                return Err(PlasticityError::AcrossInterface { top, bottom: depth, interface: *interface });
            }
            let found = material.poisson();
            let Some(p_wave_modulus) = material.p_wave_modulus().filter(|_| found <= POISSON) else {
                return Err(PlasticityError::Poisson { found, limit: POISSON });
            };
            cells.push(Cell {
                thickness,
                depth,
                coarsening,
                shear_modulus: material.shear_modulus(),
                p_wave_modulus,
                hardening: hardening[place].clone(),
            });
        }
        let depth = cells.last().ok_or(PlasticityError::NoCells)?.depth;
        if cells.iter().all(|cell| cell.hardening.is_none()) {
            return Err(PlasticityError::NothingYields);
        }
        let reaches_half_space = layers[place].bottom.is_infinite();
        let is_cut = depth < layers[place].bottom * (1.0 - ROUNDING_OF_DEPTH);
        let is_fitted = matches!(self, Self::Graded { .. });
        let (below, division) = (below(&body, depth)?, Division::new(&grid.whole(), grid, &cells));
        Ok(Mesh { grid: *grid, cells, below, reaches_half_space, is_cut, is_fitted, division })
    }

    fn thicknesses(&self, grid: &Grid, layers: &[Layer]) -> Result<Vec<f64>, PlasticityError> {
        let found = match self {
            Self::List { thicknesses, .. } => thicknesses.clone(),
            Self::Uniform { count, depth } => vec![depth / *count as f64; *count],
            Self::Graded { thickness, growth, coarsening } => {
                let wrong = !(thickness.is_finite() && *thickness > 0.0);
                if wrong {
                    return Err(PlasticityError::Thickness { index: 0, found: *thickness });
                }
                if !(1.0..=2.0).contains(growth) {
                    return Err(PlasticityError::Growth { found: *growth });
                }
                if *coarsening != 0.0 && !(coarsening.is_finite() && *coarsening >= 1.0) {
                    return Err(PlasticityError::CoarseningDepth { found: *coarsening });
                }
                let sides = sides(grid);
                let half = 0.5 * sides.iter().map(|side| side.length).fold(0.0, f64::max);
                let mut next = thickness * sides.iter().map(|side| side.spacing()).fold(f64::INFINITY, f64::min);
                let mut all = Vec::new();
                for layer in layers {
                    let bottom = if layer.bottom.is_finite() { layer.bottom } else { half };
                    next = grade(bottom - layer.top, next, *growth, &mut all);
                }
                all
            }
        };
        match found.iter().position(|thickness| !(thickness.is_finite() && *thickness > 0.0)) {
            Some(index) => Err(PlasticityError::Thickness { index, found: found[index] }),
            None if found.is_empty() => Err(PlasticityError::NoCells),
            None => Ok(found),
        }
    }

    fn coarsenings(&self, grid: &Grid, thicknesses: &[f64]) -> Result<Vec<usize>, PlasticityError> {
        let cells = thicknesses.len();
        match self {
            Self::List { coarsenings, .. } if !coarsenings.is_empty() => {
                if coarsenings.len() != cells {
                    return Err(PlasticityError::Coarsenings { found: coarsenings.len(), cells });
                }
                let wrong = |found: &usize| {
                    let fits = |side: &Side| *found > 0 && leaves(*found, side.points, LEAST_POINTS);
                    *found != 1 && !(found.is_power_of_two() && sides(grid).iter().all(fits))
                };
                match coarsenings.iter().position(wrong) {
                    Some(index) => Err(PlasticityError::Coarsening {
                        index,
                        found: coarsenings[index],
                        points: grid.points(),
                        least: LEAST_POINTS,
                    }),
                    None => Ok(coarsenings.clone()),
                }
            }
            Self::Graded { coarsening, .. } if *coarsening > 0.0 => {
                let sides = sides(grid);
                let spacing = sides.iter().map(Side::spacing).fold(0.0, f64::max);
                let mut top = 0.0;
                let of_cell = |thickness: &f64| {
                    let mut coarser = 1;
                    while 2.0 * coarser as f64 * spacing * coarsening <= top
                        && sides.iter().all(|side| leaves(2 * coarser, side.points, LEAST_POINTS_OF_GRADED))
                    {
                        coarser *= 2;
                    }
                    top += thickness;
                    coarser
                };
                Ok(thicknesses.iter().map(of_cell).collect())
            }
            _ => Ok(vec![1; cells]),
        }
    }
}

/// Side of the cell with several points.
struct Side {
    points: usize,
    length: f64,
}

impl Side {
    fn spacing(&self) -> f64 {
        self.length / self.points as f64
    }
}

fn sides(grid: &Grid) -> Vec<Side> {
    let all = grid.points().into_iter().zip(grid.lengths()).map(|(points, length)| Side { points, length });
    let several: Vec<Side> = all.filter(|side| side.points > 1).collect();
    if several.is_empty() { vec![Side { points: 1, length: grid.lengths()[0] }] } else { several }
}

/// Returns true if a coarser side has enough points; their number is rounded up.
fn leaves(coarsening: usize, points: usize, least: usize) -> bool {
    points.div_ceil(coarsening) >= least
}

/// Adds cells of a growing thickness that fill an extent. Returns the thickness of the next cell.
fn grade(extent: f64, first: f64, growth: f64, cells: &mut Vec<f64>) -> f64 {
    let enough = |extent: f64| extent.is_finite() && extent > 0.0;
    if !enough(extent) {
        return first;
    }
    let (mut sum, mut next, start) = (0.0, first, cells.len());
    while sum < extent * (1.0 - ROUNDING_OF_DEPTH) {
        cells.push(next);
        sum += next;
        next *= growth;
    }
    let fit = extent / sum;
    cells[start..].iter_mut().for_each(|thickness| *thickness *= fit);
    next
}

impl Cell {
    /// Returns the grid of the cell, below a surface with a grid.
    pub fn grid(&self, surface: &Grid) -> Grid {
        let points = surface.points().map(|points| points.div_ceil(self.coarsening));
        Grid::new(points, surface.lengths()).expect("a grid with fewer points than the surface is a grid")
    }

    /// Returns the number of points of the surface per point of the cell.
    pub(crate) fn share(&self, surface: &Grid) -> f64 {
        surface.len() as f64 / self.grid(surface).len() as f64
    }
}

impl Mesh {
    /// Returns the cells with the points of this process, one of several that make the same calls.
    pub(crate) fn over(self, share: &Share) -> Self {
        Self { division: Division::new(share, &self.grid, &self.cells), ..self }
    }

    /// Returns the shape of the fields of this process on the surface.
    pub(crate) fn surface_shape(&self) -> [usize; 2] {
        let ([nx, ny], share) = (self.grid.points(), &self.division.surface);
        if share.is_whole() { [nx, ny] } else { [share.rows().len(), ny] }
    }

    /// Returns the number of cells on the full grid with the same number of points.
    pub(crate) fn equivalent_cells(&self) -> f64 {
        self.cells.iter().map(|cell| 1.0 / cell.share(&self.grid)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(cells: &Cells, points: usize) -> Result<Mesh, PlasticityError> {
        let body = Body::half_space(Material::from_young(1.0, 0.3).unwrap());
        cells.mesh(&body, &Grid::square(points, 1.0).unwrap(), &[Some(Hardening::new(0.01).unwrap())])
    }

    #[test]
    fn graded_cells_cost_about_ten_layers_of_the_full_grid_for_any_size() {
        for (points, count) in [(64, 20), (256, 31), (1024, 43), (2048, 49)] {
            let mesh = mesh(&Cells::default(), points).unwrap();
            assert_eq!(mesh.cells.len(), count);
            approx::assert_relative_eq!(mesh.cells[count - 1].depth, 0.5, max_relative = 1e-12);
            assert!((9.0..12.5).contains(&mesh.equivalent_cells()), "{points}: {}", mesh.equivalent_cells());
        }
    }

    #[test]
    fn unusable_cells_are_refused_with_what_was_found() {
        let list = |thicknesses: &[f64], coarsenings: &[usize]| {
            let cells = Cells::List { thicknesses: thicknesses.to_vec(), coarsenings: coarsenings.to_vec() };
            mesh(&cells, 32).map(|_| ()).unwrap_err().to_string()
        };
        assert_eq!(list(&[], &[]), "there are no cells; there must be at least one");
        assert_eq!(list(&[0.1, -0.1], &[]), "the thickness of cell 1 is -0.1; it must be positive and finite");
        assert_eq!(list(&[0.1], &[1, 2]), "there are 2 coarsenings; there must be 1, one per cell");
        assert!(list(&[0.1], &[3]).starts_with("the coarsening of cell 0 is 3; it must be a power of two"));
        assert!(list(&[0.1], &[16]).ends_with("leaves at least 4 of [32, 32] points"));
        let graded = |thickness, growth, coarsening| {
            mesh(&Cells::Graded { thickness, growth, coarsening }, 32).map(|_| ()).unwrap_err().to_string()
        };
        assert_eq!(graded(0.5, 0.9, 3.0), "the growth of the cells is 0.9; it must be between 1 and 2");
        assert!(graded(f64::NAN, 1.1, 3.0).contains("NaN"));
        assert!(graded(0.5, 1.1, 0.5).contains("0.5"));
    }

    #[test]
    fn cells_end_at_interfaces_and_within_the_body() {
        let material = |young| Material::from_young(young, 0.3).unwrap();
        let grid = Grid::square(16, 1.0).unwrap();
        let body = Body::slab(material(1.0), 0.1).unwrap();
        let body = body.bonded_to(Body::slab(material(2.0), 0.2).unwrap()).unwrap();
        let steel = Some(Hardening::new(0.01).unwrap());
        let list = |thicknesses: &[f64]| {
            let cells = Cells::List { thicknesses: thicknesses.to_vec(), coarsenings: Vec::new() };
            cells.mesh(&body, &grid, &[steel.clone(), steel.clone()])
        };
        let across = list(&[0.08, 0.04]).unwrap_err().to_string();
        assert!(across.ends_with("it must end at the interface at 0.1"), "{across}");
        assert!(matches!(list(&[0.1, 0.3]), Err(PlasticityError::BelowBody { .. })));
        let whole = list(&[0.1, 0.2]).unwrap();
        assert_eq!(whole.below, Below::Ground(Ground::BONDED));
        assert_eq!(whole.cells.iter().map(|cell| cell.shear_modulus * 2.6).collect::<Vec<_>>(), [1.0, 2.0]);
        let graded = Cells::default().mesh(&body, &grid, &[steel.clone(), None]).unwrap();
        approx::assert_relative_eq!(graded.cells.last().unwrap().depth, 0.1, max_relative = 1e-12);
        assert!(matches!(Cells::default().mesh(&body, &grid, &[None, None]), Err(PlasticityError::NothingYields)));
        let one = Cells::default().mesh(&body, &grid, &[steel]);
        assert!(matches!(one, Err(PlasticityError::Layers { found: 1, layers: 2 })));
    }
}
