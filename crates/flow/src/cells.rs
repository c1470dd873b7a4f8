//! The cells of a grid with their faces, and the equations of those through which something flows.

use gfmd_field::Grid;
use gfmd_measure::{Patches, Surroundings};
use ndarray::ArrayView2;
use rayon::prelude::*;

use crate::graph::Graph;

/// The number of a cell that takes no part.
const CLOSED: u32 = u32::MAX;

/// A face of a cell.
struct Face {
    /// The cell on the other side; none at the edge of a field that ends.
    beside: Option<usize>,
    /// Conductance: flow over the difference of the potential.
    conductance: f64,
    /// Distance from the cell's point to that on the other side, or to the edge.
    distance: f64,
}

/// What flows with a potential.
pub(crate) struct Balance {
    /// Mean flux along x and y.
    pub(crate) flux: [f64; 2],
    /// Power per area, which is the conductivity along the axis.
    pub(crate) power: f64,
    /// What is missing in the balance of a cell over the mean flow through a face, the deviation of the flow through a section from their
    /// mean, and of the power from the flux: the largest of all, relative.
    pub(crate) residual: f64,
}

/// The deviation of the potential from its mean gradient at a cell, as the sum of a number and a small one.
#[derive(Clone, Copy, Default)]
pub(crate) struct Potential([f64; 2]);

impl Potential {
    pub(crate) fn add(&mut self, correction: f64) {
        let Self([high, low]) = *self;
        let low = low + correction;
        let sum = high + low;
        *self = Self([sum, low - (sum - high)]);
    }

    /// The difference to another potential, and `drop`.
    fn over(self, Self([high, low]): Self, drop: f64) -> f64 {
        ((self.0[0] - high) + drop) + (self.0[1] - low)
    }
}

/// Cells with conductivities under a unit mean gradient along one axis.
pub(crate) struct Cells<'a> {
    grid: Grid,
    conductivity: &'a [f64],
    surroundings: Surroundings,
    /// The axis of the gradient.
    axis: usize,
    /// The number of each cell that belongs to a patch through which something flows.
    numbers: Vec<u32>,
    /// These cells.
    open: Vec<u32>,
}

impl<'a> Cells<'a> {
    pub(crate) fn new(
        grid: &Grid,
        conductivity: &'a [f64],
        surroundings: Surroundings,
        patches: &Patches,
        axis: usize,
    ) -> Self {
        let mut numbers = vec![CLOSED; conductivity.len()];
        let mut open = Vec::new();
        for (cell, label) in patches.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
            if patches.patches[*label as usize - 1].percolates[axis] {
                numbers[cell] = open.len() as u32;
                open.push(cell as u32);
            }
        }
        Self { grid: *grid, conductivity, surroundings, axis, numbers, open }
    }

    /// The width of a face across the gradient.
    pub(crate) fn width(&self) -> f64 {
        self.grid.spacing()[1 - self.axis]
    }

    pub(crate) fn area(&self) -> f64 {
        self.grid.lengths().iter().product()
    }

    pub(crate) fn axis(&self) -> usize {
        self.axis
    }

    pub(crate) fn len(&self) -> usize {
        self.open.len()
    }

    /// The face of `cell` along `axis`, on its far side or on its near one; none if nothing passes.
    fn face(&self, cell: usize, axis: usize, far: bool) -> Option<Face> {
        let (points, spacing) = (self.grid.points(), self.grid.spacing());
        let (n, stride) = if axis == 0 { (points[0], points[1]) } else { (points[1], 1) };
        let index = cell / stride % n;
        let at_edge = if far { index + 1 == n } else { index == 0 };
        let width = spacing[1 - axis];
        let here = self.conductivity[cell];
        if at_edge && self.surroundings == Surroundings::Ends {
            // The reservoirs lie at the edges along the gradient.
            let distance = 0.5 * spacing[axis];
            let face = Face { beside: None, conductance: here * width / distance, distance };
            return (axis == self.axis).then_some(face);
        }
        let beside = match (far, at_edge) {
            (true, false) => cell + stride,
            (true, true) => cell + stride - n * stride,
            (false, false) => cell - stride,
            (false, true) => cell + n * stride - stride,
        };
        let there = self.conductivity[beside];
        if self.numbers[beside] == CLOSED || beside == cell {
            return None;
        }
        let distance = spacing[axis];
        Some(Face { beside: Some(beside), conductance: mean(here, there) * width / distance, distance })
    }

    fn faces(&self, cell: usize) -> impl Iterator<Item = (usize, bool, Face)> + '_ {
        let sides = [(0, false), (0, true), (1, false), (1, true)];
        sides.into_iter().filter_map(move |(axis, far)| self.face(cell, axis, far).map(|face| (axis, far, face)))
    }

    /// The graph of the cells: what flows out of each is A p less the [source](Self::source).
    pub(crate) fn graph(&self) -> Graph {
        Graph::new(self.len(), |number, row| {
            let mut outside = 0.0;
            for (_, _, face) in self.faces(self.open[number] as usize) {
                match face.beside {
                    Some(beside) => row.push((self.numbers[beside], face.conductance)),
                    None => outside += face.conductance,
                }
            }
            outside
        })
    }

    /// What flows out of a cell through one of its faces.
    fn out(&self, potential: &[Potential], number: usize, (axis, far, face): &(usize, bool, Face)) -> f64 {
        let beside = face.beside.map_or(Potential::default(), |beside| potential[self.numbers[beside] as usize]);
        let drop = if *axis == self.axis { if *far { face.distance } else { -face.distance } } else { 0.0 };
        face.conductance * potential[number].over(beside, drop)
    }

    /// What flows into each cell, if all is not in balance.
    pub(crate) fn missing(&self, potential: &[Potential]) -> Vec<f64> {
        let of = |(number, cell): (usize, &u32)| {
            -self.faces(*cell as usize).map(|part| self.out(potential, number, &part)).sum::<f64>()
        };
        self.open.par_iter().enumerate().map(of).collect()
    }

    /// True if the other cells are the same, but for the gradient.
    pub(crate) fn has_equations_of(&self, other: &Self) -> bool {
        self.surroundings == Surroundings::Repeats && self.open == other.open
    }

    /// What flows with a potential, from each cell's faces anew.
    pub(crate) fn balance(&self, potential: &[Potential]) -> Balance {
        let (lengths, points) = (self.grid.lengths(), self.grid.points());
        let stride = if self.axis == 0 { points[1] } else { 1 };
        let (mut flux, mut power) = ([0.0; 2], 0.0);
        let mut sections = vec![0.0; points[self.axis] + 1];
        let mut missing = 0.0;
        for (number, cell) in self.open.iter().enumerate() {
            let index = *cell as usize / stride % points[self.axis];
            let mut sum = 0.0;
            for part in self.faces(*cell as usize) {
                let out = self.out(potential, number, &part);
                let (axis, far, face) = part;
                sum += out;
                // Each inner face belongs to two cells, each with half of the way.
                let share = if face.beside.is_some() { 0.5 } else { 1.0 };
                flux[axis] += share * face.distance * if far { out } else { -out };
                power += share * out * out / face.conductance;
                match (axis == self.axis, far, face.beside) {
                    (true, true, _) => sections[index + 1] += out,
                    (true, false, None) => sections[0] -= out,
                    _ => {}
                }
            }
            missing = larger(missing, sum.abs());
        }
        if self.surroundings == Surroundings::Repeats {
            sections[0] = sections[points[self.axis]];
        }
        let area = lengths[0] * lengths[1];
        let (flux, power) = (flux.map(|flux| flux / area), power / area);
        let through = flux[self.axis] * lengths[1 - self.axis];
        let of_power = (flux[self.axis] / power - 1.0).abs();
        let of_sections = sections.iter().map(|section| (section / through - 1.0).abs());
        let residual = of_sections.fold(larger(missing / (flux[self.axis] * self.width()).abs(), of_power), larger);
        Balance { flux, power, residual }
    }

    /// The magnitude of the flux at every cell: flow per width, averaged over opposite faces.
    pub(crate) fn flux(&self, potential: &[Potential]) -> Vec<f64> {
        let spacing = self.grid.spacing();
        let mut magnitudes = vec![0.0; self.numbers.len()];
        for (number, cell) in self.open.iter().enumerate() {
            let mut flux = [0.0; 2];
            for part in self.faces(*cell as usize) {
                let out = self.out(potential, number, &part) / spacing[1 - part.0];
                flux[part.0] += 0.5 * if part.1 { out } else { -out };
            }
            magnitudes[*cell as usize] = flux[0].hypot(flux[1]);
        }
        magnitudes
    }

    /// The potential less its mean gradient at every cell, zero where nothing flows.
    pub(crate) fn spread(&self, potential: &[Potential]) -> Vec<f64> {
        let of = |number: &u32| potential.get(*number as usize).map_or(0.0, |Potential([high, low])| high + low);
        self.numbers.iter().map(of).collect()
    }
}

/// The larger of two numbers, NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// The harmonic mean, which is that of two layers in series.
fn mean(a: f64, b: f64) -> f64 {
    let least = a.min(b);
    if least > 0.0 { 2.0 * least / (1.0 + least / a.max(b)) } else { 0.0 }
}

/// The patches of cells that conduct.
pub(crate) fn conducting(conductivity: ArrayView2<f64>, surroundings: Surroundings) -> Patches {
    Patches::of(conductivity.mapv(|k| k > 0.0).view(), surroundings)
}
