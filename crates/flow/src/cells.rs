//! Cells of a grid with their faces, and the equations of the open cells, through which something flows.

use gfmd_field::Grid;
use gfmd_measure::{Boundary, Patches};
use ndarray::ArrayView2;
use rayon::prelude::*;

use crate::PART;
use crate::graph::{Edge, Way};
use crate::numbering::{CLOSED, Numbering};
use crate::potential::Potential;

/// Face of a cell.
pub(crate) struct Face {
    /// Number of the cell on the other side; `None` at the edge of a non-periodic field.
    pub(crate) beside: Option<u32>,
    /// Conductance: flow divided by potential difference.
    pub(crate) conductance: f64,
    /// Distance from the point of the cell to the point on the other side, or to the edge.
    distance: f64,
}

/// Edges of a cell.
pub(crate) struct Links {
    edges: [Edge; 4],
    count: usize,
    /// Conductance to the edge of the field, negative at the near edge.
    pub(crate) outside: f64,
}

impl Links {
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Edge> + '_ {
        self.edges[..self.count].iter()
    }
}

/// Flow in a part of the cells.
struct Sums {
    flux: [f64; 2],
    power: f64,
    /// Flows through sections, from the first section that a cell of the part touches.
    sections: Vec<f64>,
    first: usize,
    /// Largest flow missing in the balance of a cell.
    missing: f64,
}

/// Axes of a gradient and of the reservoirs of a non-periodic field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axes {
    pub(crate) gradient: usize,
    pub(crate) reservoirs: usize,
}

/// Cells with conductivities under a unit mean gradient along one axis.
pub(crate) struct Cells<'a> {
    points: [usize; 2],
    lengths: [f64; 2],
    spacing: [f64; 2],
    conductivity: &'a [f64],
    /// Largest conductivity.
    unit: f64,
    boundary: Boundary,
    axes: Axes,
    /// Numbers of the open cells.
    numbering: &'a Numbering,
    /// Width of a face divided by the distance between cells, along x and along y.
    shape: [f64; 2],
}

impl<'a> Cells<'a> {
    pub(crate) fn new(
        grid: &Grid,
        (conductivity, unit): (&'a [f64], f64),
        boundary: Boundary,
        numbering: &'a Numbering,
        axes: Axes,
    ) -> Self {
        let (points, lengths, spacing) = (grid.points(), grid.lengths(), grid.spacing());
        let shape = [spacing[1] / spacing[0], spacing[0] / spacing[1]];
        Self { points, lengths, spacing, conductivity, unit, boundary, axes, numbering, shape }
    }

    /// Returns the width of a face across the gradient.
    pub(crate) fn width(&self) -> f64 {
        self.spacing[1 - self.axes.gradient]
    }

    pub(crate) fn area(&self) -> f64 {
        self.lengths.iter().product()
    }

    pub(crate) fn axes(&self) -> Axes {
        self.axes
    }

    /// Returns true if the reservoirs do not lie along the gradient.
    pub(crate) fn is_across(&self) -> bool {
        self.boundary == Boundary::Free && self.axes.gradient != self.axes.reservoirs
    }

    pub(crate) fn numbering(&self) -> &Numbering {
        self.numbering
    }

    pub(crate) fn len(&self) -> usize {
        self.numbering.len()
    }

    /// Returns the face of a cell along `axis`, on its far or near side; `None` if nothing passes through it.
    fn face(&self, cell: usize, index: usize, axis: usize, far: bool) -> Option<Face> {
        let (n, stride) = if axis == 0 { (self.points[0], self.points[1]) } else { (self.points[1], 1) };
        let at_edge = if far { index + 1 == n } else { index == 0 };
        let (here, distance) = (self.conductivity[cell], self.spacing[axis]);
        if at_edge && self.boundary == Boundary::Free {
            let face =
                Face { beside: None, conductance: 2.0 * here / self.unit * self.shape[axis], distance: 0.5 * distance };
            return (axis == self.axes.reservoirs).then_some(face);
        }
        let beside = match (far, at_edge) {
            (true, false) => cell + stride,
            (true, true) => cell + stride - n * stride,
            (false, false) => cell - stride,
            (false, true) => cell + n * stride - stride,
        };
        let number = self.numbering.numbers[beside];
        if number == CLOSED || beside == cell {
            return None;
        }
        let conductance = self.mean(here, self.conductivity[beside]) * self.shape[axis];
        Some(Face { beside: Some(number), conductance, distance })
    }

    /// Returns the indices of a cell. Cell numbers have 32 bits, since 32-bit division is faster.
    fn place(&self, cell: u32) -> [usize; 2] {
        let columns = self.points[1] as u32;
        [cell / columns, cell % columns].map(|index| index as usize)
    }

    fn faces(&self, cell: usize) -> impl Iterator<Item = (usize, bool, Face)> + '_ {
        let place = self.place(cell as u32);
        let sides = [(0, false), (0, true), (1, false), (1, true)];
        sides
            .into_iter()
            .filter_map(move |(axis, far)| self.face(cell, place[axis], axis, far).map(|face| (axis, far, face)))
    }

    pub(crate) fn faces_of(&self, number: usize) -> impl Iterator<Item = (usize, bool, Face)> + '_ {
        self.faces(self.numbering.open[number] as usize)
    }

    /// Returns the conductances of the far faces along x and y of all cells, zero without an open cell on both sides.
    pub(crate) fn conductances(&self) -> Vec<[f64; 2]> {
        let [rows, columns] = self.points;
        let free = self.boundary == Boundary::Free;
        let open = |cell: usize| if self.numbering.numbers[cell] == CLOSED { 0.0 } else { self.conductivity[cell] };
        let mut found = vec![[0.0; 2]; rows * columns];
        found.par_chunks_mut(columns).enumerate().for_each(|(i, row)| {
            let (here, next) = (i * columns, (i + 1) % rows * columns);
            let has_next = f64::from(u8::from(!free || i + 1 < rows));
            for (j, found) in row.iter_mut().enumerate() {
                let k = open(here + j);
                let has_right = if j + 1 < columns { 1.0 } else { f64::from(u8::from(!free)) };
                let right = if j + 1 < columns { j + 1 } else { 0 };
                *found = [
                    has_next * self.mean(k, open(next + j)) * self.shape[0],
                    has_right * self.mean(k, open(here + right)) * self.shape[1],
                ];
            }
        });
        found
    }

    /// Returns the edges of the cell with this number to open cells.
    pub(crate) fn links(&self, number: usize, conductances: &[[f64; 2]]) -> Links {
        let cell = self.numbering.open[number] as usize;
        let ([i, j], [rows, columns]) = (self.place(cell as u32), self.points);
        let above = if i == 0 { cell + (rows - 1) * columns } else { cell - columns };
        let below = if i + 1 == rows { cell - i * columns } else { cell + columns };
        let left = if j == 0 { cell + columns - 1 } else { cell - 1 };
        let right = if j + 1 == columns { cell - j } else { cell + 1 };
        let none = Edge { end: 0, way: Way::of([0, 0]), weight: 0.0 };
        let mut links = Links { edges: [none; 4], count: 0, outside: 0.0 };
        let around = [
            (above, [-1, 0], conductances[above][0]),
            (below, [1, 0], conductances[cell][0]),
            (left, [0, -1], conductances[left][1]),
            (right, [0, 1], conductances[cell][1]),
        ];
        for (beside, way, weight) in around.into_iter().filter(|(_, _, weight)| *weight > 0.0) {
            links.edges[links.count] = Edge { end: self.numbering.numbers[beside], way: Way::of(way), weight };
            links.count += 1;
        }
        let along = self.axes.reservoirs;
        let index = [i, j][along];
        if self.boundary == Boundary::Free && (index == 0 || index + 1 == self.points[along]) {
            let weight = 2.0 * self.conductivity[cell] / self.unit * self.shape[along];
            links.outside = if index == 0 { -weight } else { weight };
        }
        links
    }

    /// Returns the potential drop from a cell through one of its faces.
    pub(crate) fn fall(&self, own: Potential, beside: Potential, (axis, far, face): &(usize, bool, Face)) -> f64 {
        let drop = if *axis == self.axes.gradient { if *far { face.distance } else { -face.distance } } else { 0.0 };
        own.over(beside, drop)
    }

    /// Returns the drop of the mean gradient along a way.
    pub(crate) fn drop_along(&self, way: Way) -> f64 {
        f64::from(way.cells()[self.axes.gradient]) * self.spacing[self.axes.gradient]
    }

    /// Returns the drop of the mean gradient from a cell at the far edge to the reservoir.
    pub(crate) fn drop_outside(&self) -> f64 {
        if self.is_across() { 0.0 } else { 0.5 * self.spacing[self.axes.gradient] }
    }

    /// Returns the potential drop from a cell with this number through one of its faces.
    fn fall_of(&self, potential: &[Potential], number: usize, part: &(usize, bool, Face)) -> f64 {
        let beside = part.2.beside.map_or(Potential::default(), |beside| potential[beside as usize]);
        self.fall(potential[number], beside, part)
    }

    /// Returns the conductivity of two cells in series, in units of the largest conductivity.
    fn mean(&self, a: f64, b: f64) -> f64 {
        let (less, more) = (a.min(b), a.max(b));
        if less > 0.0 { less / self.unit * (2.0 * (more / (more + less))) } else { 0.0 }
    }

    /// Computes the flow in a part of the cells with the numbers from `start` on.
    fn sums(&self, potential: &[Potential], start: usize, cells: &[u32]) -> Sums {
        let index = |cell: u32| self.place(cell)[self.axes.gradient];
        let (first, last) =
            cells.iter().map(|cell| index(*cell)).fold((usize::MAX, 0), |(a, b), index| (a.min(index), b.max(index)));
        let sections = vec![0.0; last - first + 2];
        let mut sums = Sums { flux: [0.0; 2], power: 0.0, sections, first, missing: 0.0 };
        for (number, cell) in (start..).zip(cells) {
            let index = index(*cell) - first;
            let mut sum = 0.0;
            for part in self.faces(*cell as usize) {
                let fall = self.fall_of(potential, number, &part);
                let (axis, far, face) = part;
                let out = face.conductance * fall;
                sum += out;
                // An inner face belongs to two cells, and each counts half of the distance.
                let share = if face.beside.is_some() { 0.5 } else { 1.0 };
                sums.flux[axis] += share * face.distance * if far { out } else { -out };
                sums.power += share * out * fall;
                match (axis == self.axes.gradient, far, face.beside) {
                    (true, true, _) => sums.sections[index + 1] += out,
                    (true, false, None) => sums.sections[index] -= out,
                    _ => {}
                }
            }
            sums.missing = larger(sums.missing, sum.abs());
        }
        sums
    }

    /// Returns the largest of three relative deviations: the flow missing in a cell, divided by the mean flow through a
    /// face; the flow through a section from the mean flow; the flux from the power.
    pub(crate) fn residual(&self, potential: &[Potential]) -> f64 {
        let Self { lengths, points, .. } = *self;
        let parts = self.numbering.open.par_chunks(PART).enumerate();
        let parts: Vec<Sums> = parts.map(|(part, cells)| self.sums(potential, part * PART, cells)).collect();
        let (mut flux, mut power) = ([0.0; 2], 0.0);
        let mut sections = vec![0.0; points[self.axes.gradient] + 1];
        let mut missing = 0.0;
        for part in parts {
            flux = gfmd_vector::add(flux, part.flux);
            power += part.power;
            sections[part.first..].iter_mut().zip(part.sections).for_each(|(sum, section)| *sum += section);
            missing = larger(missing, part.missing);
        }
        if self.boundary == Boundary::Periodic {
            sections[0] = sections[points[self.axes.gradient]];
        }
        let area = lengths[0] * lengths[1];
        let (flux, power) = (flux.map(|flux| flux / area), power / area);
        let through = flux[self.axes.gradient] * lengths[1 - self.axes.gradient];
        let of_power = (flux[self.axes.gradient] / power - 1.0).abs();
        let of_sections = sections.iter().map(|section| (section / through - 1.0).abs());
        let of_cells = missing / (flux[self.axes.gradient] * self.width()).abs();
        of_sections.fold(larger(of_cells, of_power), larger)
    }

    /// Computes the flux magnitude at every cell: flow per width, averaged over opposite faces; zero in closed cells.
    pub(crate) fn flux(&self, potential: &[Potential]) -> Vec<f64> {
        self.at_every_cell(|cell, number| {
            let mut flux = [0.0; 2];
            for part in self.faces(cell) {
                let out = part.2.conductance * self.fall_of(potential, number, &part);
                flux[part.0] += if part.1 { out } else { -out };
            }
            let mean = |axis: usize| 0.5 * flux[axis] / self.spacing[1 - axis];
            mean(0).hypot(mean(1))
        })
    }

    /// Returns the deviation of the potential from its mean gradient at every cell; zero where nothing flows.
    pub(crate) fn spread(&self, potential: &[Potential]) -> Vec<f64> {
        self.at_every_cell(|_, number| potential[number].value())
    }

    /// Evaluates `value` for every cell from its index and its number; zero where nothing flows.
    fn at_every_cell(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
        let of = |(cell, number): (usize, &u32)| if *number == CLOSED { 0.0 } else { value(cell, *number as usize) };
        self.numbering.numbers.par_iter().enumerate().with_min_len(PART).map(of).collect()
    }
}

/// Returns the larger of two numbers; NaN if either is NaN.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Finds the patches of conducting cells.
pub(crate) fn conducting(conductivity: ArrayView2<f64>, boundary: Boundary) -> Patches {
    Patches::of(conductivity.mapv(|k| k > 0.0).view(), boundary)
}
