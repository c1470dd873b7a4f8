//! Plastic strain, stored where the material has yielded.

use std::sync::Arc;

use gfmd_contact::Refusal;
use gfmd_relax::Visit;
use gfmd_vector::for_each;
use ndarray::{Array2, Array3};

use crate::cells::Mesh;
use crate::volume::COMPONENTS;

/// Plastic strain ε^p and equivalent plastic strain κ of all cells. Only points that have yielded take memory, and
/// copies share it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticStrain {
    pub(crate) cells: Vec<Arc<Yielded>>,
}

/// Points of a cell that have yielded, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Yielded {
    /// Numbers of the points, counted from the first point of this process on the grid of the cell.
    pub(crate) points: Vec<u32>,
    /// Plastic strain, in the orthonormal basis.
    pub(crate) strain: Vec<[f64; COMPONENTS]>,
    /// κ.
    pub(crate) equivalent: Vec<f64>,
}

impl Yielded {
    /// Makes an empty list with room for a number of points.
    pub(crate) fn with_room(points: usize) -> Self {
        Self {
            points: Vec::with_capacity(points),
            strain: Vec::with_capacity(points),
            equivalent: Vec::with_capacity(points),
        }
    }

    pub(crate) fn push(&mut self, point: u32, strain: [f64; COMPONENTS], equivalent: f64) {
        self.points.push(point);
        self.strain.push(strain);
        self.equivalent.push(equivalent);
    }

    pub(crate) fn append(&mut self, mut other: Self) {
        self.points.append(&mut other.points);
        self.strain.append(&mut other.strain);
        self.equivalent.append(&mut other.equivalent);
    }

    /// Returns the plastic strain and κ of a point; zeros if it has not yielded.
    pub(crate) fn at(&self, point: u32) -> ([f64; COMPONENTS], f64) {
        match self.points.binary_search(&point) {
            Ok(place) => (self.strain[place], self.equivalent[place]),
            Err(_) => ([0.0; COMPONENTS], 0.0),
        }
    }
}

/// Writes the `value`s of `count` points into a field. The numbers of the points increase.
pub(crate) fn scatter<T: Send>(
    field: &mut [T],
    count: usize,
    point: &(impl Fn(usize) -> u32 + Sync),
    value: &(impl Fn(usize) -> T + Sync),
) {
    for_each([field], &|start, [part]| {
        let (mut low, mut high) = (0, count);
        while low < high {
            let middle = usize::midpoint(low, high);
            if (point(middle) as usize) < start { low = middle + 1 } else { high = middle }
        }
        let end = start + part.len();
        for k in (low..count).take_while(|k| (point(*k) as usize) < end) {
            part[point(k) as usize - start] = value(k);
        }
    });
}

impl PlasticStrain {
    /// Visits the points that have yielded. Their number in each row is visited first, so that a restored strain has as
    /// many, on any number of processes.
    pub(crate) fn visit(&mut self, mesh: &Mesh, visitor: &mut dyn Visit) {
        for (cell, yielded) in self.cells.iter_mut().enumerate() {
            let Yielded { points, strain, equivalent } = Arc::make_mut(yielded);
            let share = mesh.division.of(cell);
            let (rows, columns, first) = (share.rows().len(), share.columns(), share.own().start);
            let mut counts = vec![0.0; rows];
            points.iter().for_each(|point| counts[*point as usize / columns] += 1.0);
            visitor.rows(&share.of_lengths(rows, 1), &mut counts);
            let count = counts.iter().map(|count| *count as usize).sum();
            let each = share.of_lengths(count, 1);
            let mut numbers: Vec<f64> = points.iter().map(|point| (first + *point as usize) as f64).collect();
            numbers.resize(count, 0.0);
            visitor.rows(&each, &mut numbers);
            *points = numbers.iter().map(|number| (*number as usize).saturating_sub(first) as u32).collect();
            let mut flat: Vec<f64> = strain.iter().flatten().copied().collect();
            flat.resize(COMPONENTS * count, 0.0);
            visitor.rows(&share.of_lengths(count, COMPONENTS), &mut flat);
            *strain = flat.as_chunks().0.to_vec();
            equivalent.resize(count, 0.0);
            visitor.rows(&each, equivalent);
        }
    }

    pub(crate) fn none(cells: usize) -> Self {
        Self { cells: vec![Arc::default(); cells] }
    }

    /// Makes the plastic strain from fields of all points, one per cell.
    pub(crate) fn of_fields(mesh: &Mesh, strain: &[Array3<f64>], equivalent: &[Array2<f64>]) -> Result<Self, Refusal> {
        let count = mesh.cells.len();
        for found in [strain.len(), equivalent.len()] {
            if found != count {
                return Err(Refusal::Basis { found, expected: count });
            }
        }
        let mut cells = Vec::new();
        for ((cell, strain), equivalent) in mesh.cells.iter().zip(strain).zip(equivalent) {
            let points = mesh.division.shape(cells.len(), &cell.grid(&mesh.grid));
            if strain.dim() != (COMPONENTS, points[0], points[1]) || <[usize; 2]>::from(equivalent.dim()) != points {
                return Err(Refusal::Shape { found: equivalent.dim().into(), expected: points });
            }
            let mut yielded = Yielded::default();
            for (number, ((i, j), equivalent)) in equivalent.indexed_iter().enumerate() {
                let strain = std::array::from_fn(|c| strain[[c, i, j]]);
                let known = strain.iter().all(|e: &f64| e.is_finite()) && equivalent.is_finite() && *equivalent >= 0.0;
                if !known {
                    return Err(Refusal::NotFinite { what: "plastic strain", found: *equivalent });
                }
                if *equivalent > 0.0 || strain != [0.0; COMPONENTS] {
                    yielded.push(number as u32, strain, *equivalent);
                }
            }
            cells.push(Arc::new(yielded));
        }
        Ok(Self { cells })
    }

    /// Returns the largest κ of this process.
    pub(crate) fn largest(&self) -> f64 {
        self.cells.iter().flat_map(|cell| &cell.equivalent).fold(0.0, |most, k| k.max(most))
    }

    /// Returns true if a point of this process in the lowest cell has yielded.
    pub(crate) fn yields_in_lowest(&self) -> bool {
        self.cells.last().is_some_and(|cell| cell.equivalent.iter().any(|k| *k > 0.0))
    }

    /// Returns true for each cell in which a point of any process has yielded.
    pub(crate) fn yielded(&self, mesh: &Mesh) -> Vec<bool> {
        mesh.division.any(&self.cells.iter().map(|cell| !cell.points.is_empty()).collect::<Vec<bool>>())
    }

    /// Returns the number of points of this process that have yielded, on the grids of their cells.
    pub fn points(&self) -> usize {
        self.cells.iter().map(|cell| cell.points.len()).sum()
    }

    /// Returns ε^p of a cell, `[component, x, y]` on the grid of the cell. The components are √(3/2) ε_zz,
    /// (ε_xx − ε_yy)/√2, √2 ε_xy, √2 ε_xz and √2 ε_yz.
    pub(crate) fn strain_field(&self, mesh: &Mesh, cell: usize) -> Array3<f64> {
        let [nx, ny] = mesh.division.shape(cell, &mesh.cells[cell].grid(&mesh.grid));
        let mut field = Array3::zeros((COMPONENTS, nx, ny));
        let Yielded { points, strain, .. } = &*self.cells[cell];
        for (point, strain) in points.iter().zip(strain) {
            let [i, j] = [*point as usize / ny, *point as usize % ny];
            strain.iter().enumerate().for_each(|(c, e)| field[[c, i, j]] = *e);
        }
        field
    }

    /// Returns κ of a cell, `[x, y]` on the grid of the cell.
    pub(crate) fn equivalent_field(&self, mesh: &Mesh, cell: usize) -> Array2<f64> {
        let [nx, ny] = mesh.division.shape(cell, &mesh.cells[cell].grid(&mesh.grid));
        let mut field = Array2::zeros((nx, ny));
        let Yielded { points, equivalent, .. } = &*self.cells[cell];
        for (point, equivalent) in points.iter().zip(equivalent) {
            field[[*point as usize / ny, *point as usize % ny]] = *equivalent;
        }
        field
    }

    /// Returns the sum over cells of the thickness times the mean over points of a function of plastic strain and κ,
    /// zero where both are zero. `of(cell, place, strain, κ)` also gets the number of the cell and the place in its
    /// list.
    pub(crate) fn integral(
        &self,
        mesh: &Mesh,
        of: impl Fn(usize, usize, &[f64; COMPONENTS], f64) -> f64 + Sync,
    ) -> f64 {
        let sums = mesh.division.sums(&|number, range| {
            let Yielded { points, strain, equivalent } = &*self.cells[number];
            let place = |limit: usize| points.partition_point(|point| (*point as usize) < limit);
            (place(range.start)..place(range.end)).map(|k| of(number, k, &strain[k], equivalent[k])).sum()
        });
        let cells = mesh.cells.iter().zip(sums);
        cells.map(|(cell, sum)| cell.thickness / cell.grid(&mesh.grid).len() as f64 * sum).sum()
    }
}
