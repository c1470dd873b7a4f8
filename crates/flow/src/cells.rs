//! Cells of a grid with their faces, and the equations of the open cells, through which something flows.

use gfmd_field::Grid;
use gfmd_measure::{Boundary, Patches};
use ndarray::ArrayView2;
use rayon::prelude::*;

use crate::PART;
use crate::numbering::{CLOSED, Numbering};

/// Face of a cell.
struct Face {
    /// Number of the cell on the other side; `None` at the edge of a non-periodic field.
    beside: Option<u32>,
    /// Conductance: flow divided by potential difference.
    conductance: f64,
    /// Distance from the point of the cell to the point on the other side, or to the edge.
    distance: f64,
}

/// Neighbours of a cell.
pub(crate) struct Links {
    /// Numbers of the neighbours, with the conductances of the faces.
    beside: [(u32, f64); 4],
    count: usize,
    /// Conductance to the edges of the field.
    pub(crate) outside: f64,
}

impl Links {
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.beside[..self.count].iter().map(|(number, conductance)| (*number as usize, *conductance))
    }
}

/// Flow caused by a potential.
#[derive(Clone, Debug, Default)]
pub(crate) struct Balance {
    /// Power per area, equal to the conductivity along the axis.
    pub(crate) power: f64,
    /// Largest of three relative deviations: the flow missing in a cell, divided by the mean flow through a face; the
    /// flow through a section from the mean flow; the flux from the power.
    pub(crate) residual: f64,
    /// Flow into each cell, zero in balance.
    pub(crate) missing: Vec<f64>,
}

/// Flow in a part of the cells.
struct Sums {
    flux: [f64; 2],
    power: f64,
    /// Flows through sections, from the first section that a cell of the part touches.
    sections: Vec<f64>,
    first: usize,
    missing: Vec<f64>,
}

/// Deviation of the potential from its mean gradient at a cell, as the sum of a number and a small correction.
#[derive(Clone, Copy, Default)]
pub(crate) struct Potential([f64; 2]);

impl Potential {
    pub(crate) fn add(&mut self, correction: f64) {
        let Self([high, low]) = *self;
        let low = low + correction;
        let sum = high + low;
        *self = Self([sum, low - (sum - high)]);
    }

    /// Returns the difference from another potential plus `drop`, where both may nearly cancel.
    fn over(self, Self([high, low]): Self, drop: f64) -> f64 {
        let Self([here, rest]) = self;
        let difference = here - high;
        // The rounding error of the difference (Knuth).
        let part = difference - here;
        let lost = (here - (difference - part)) - (high + part);
        (difference + drop) + ((rest - low) + lost)
    }
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
        conductivity: &'a [f64],
        boundary: Boundary,
        numbering: &'a Numbering,
        axes: Axes,
    ) -> Self {
        let (points, lengths, spacing) = (grid.points(), grid.lengths(), grid.spacing());
        let shape = [spacing[1] / spacing[0], spacing[0] / spacing[1]];
        Self { points, lengths, spacing, conductivity, boundary, axes, numbering, shape }
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
            let face = Face { beside: None, conductance: 2.0 * here * self.shape[axis], distance: 0.5 * distance };
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
        let conductance = mean(here, self.conductivity[beside]) * self.shape[axis];
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

    /// Returns the neighbours of the cell with this number.
    pub(crate) fn links(&self, number: usize) -> Links {
        let mut links = Links { beside: [(0, 0.0); 4], count: 0, outside: 0.0 };
        for (_, _, face) in self.faces(self.numbering.open[number] as usize) {
            match face.beside {
                Some(beside) => {
                    links.beside[links.count] = (beside, face.conductance);
                    links.count += 1;
                }
                None => links.outside += face.conductance,
            }
        }
        links
    }

    /// Returns the potential drop from a cell through one of its faces.
    fn fall(&self, potential: &[Potential], number: usize, (axis, far, face): &(usize, bool, Face)) -> f64 {
        let beside = face.beside.map_or(Potential::default(), |beside| potential[beside as usize]);
        let drop = if *axis == self.axes.gradient { if *far { face.distance } else { -face.distance } } else { 0.0 };
        potential[number].over(beside, drop)
    }

    /// Computes the flow in a part of the cells with the numbers from `start` on.
    fn sums(&self, potential: &[Potential], start: usize, cells: &[u32]) -> Sums {
        let index = |cell: u32| self.place(cell)[self.axes.gradient];
        let (first, last) =
            cells.iter().map(|cell| index(*cell)).fold((usize::MAX, 0), |(a, b), index| (a.min(index), b.max(index)));
        let (sections, missing) = (vec![0.0; last - first + 2], Vec::with_capacity(cells.len()));
        let mut sums = Sums { flux: [0.0; 2], power: 0.0, sections, first, missing };
        for (number, cell) in (start..).zip(cells) {
            let index = index(*cell) - first;
            let mut sum = 0.0;
            for part in self.faces(*cell as usize) {
                let fall = self.fall(potential, number, &part);
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
            sums.missing.push(-sum);
        }
        sums
    }

    /// Computes the flow caused by a potential from the faces of all cells.
    pub(crate) fn balance(&self, potential: &[Potential]) -> Balance {
        let Self { lengths, points, .. } = *self;
        let parts = self.numbering.open.par_chunks(PART).enumerate();
        let parts: Vec<Sums> = parts.map(|(part, cells)| self.sums(potential, part * PART, cells)).collect();
        let (mut flux, mut power) = ([0.0; 2], 0.0);
        let mut sections = vec![0.0; points[self.axes.gradient] + 1];
        let mut missing = Vec::with_capacity(self.len());
        for part in parts {
            flux = gfmd_vector::add(flux, part.flux);
            power += part.power;
            sections[part.first..].iter_mut().zip(part.sections).for_each(|(sum, section)| *sum += section);
            missing.extend(part.missing);
        }
        if self.boundary == Boundary::Periodic {
            sections[0] = sections[points[self.axes.gradient]];
        }
        let area = lengths[0] * lengths[1];
        let (flux, power) = (flux.map(|flux| flux / area), power / area);
        let through = flux[self.axes.gradient] * lengths[1 - self.axes.gradient];
        let of_power = (flux[self.axes.gradient] / power - 1.0).abs();
        let of_sections = sections.iter().map(|section| (section / through - 1.0).abs());
        let of_cells = missing.iter().map(|missing| missing.abs()).fold(0.0, larger);
        let of_cells = of_cells / (flux[self.axes.gradient] * self.width()).abs();
        let residual = of_sections.fold(larger(of_cells, of_power), larger);
        Balance { power, residual, missing }
    }

    /// Returns the power per area of the flow of one gradient along the falls of another, in the same network.
    pub(crate) fn shared(&self, potential: &[Potential], other: &Self, of_other: &[Potential]) -> f64 {
        let open = &self.numbering.open;
        let power = |number: usize| {
            let faces = self.faces(open[number] as usize).map(|part| {
                let share = if part.2.beside.is_some() { 0.5 } else { 1.0 };
                let fall = self.fall(potential, number, &part);
                share * part.2.conductance * fall * other.fall(of_other, number, &part)
            });
            faces.sum::<f64>()
        };
        gfmd_vector::sum(open.len(), &|range| range.map(power).sum()) / self.area()
    }

    /// Computes the flux magnitude at every cell: flow per width, averaged over opposite faces; zero in closed cells.
    pub(crate) fn flux(&self, potential: &[Potential]) -> Vec<f64> {
        self.at_every_cell(|cell, number| {
            let mut flux = [0.0; 2];
            for part in self.faces(cell) {
                let out = part.2.conductance * self.fall(potential, number, &part);
                flux[part.0] += if part.1 { out } else { -out };
            }
            let mean = |axis: usize| 0.5 * flux[axis] / self.spacing[1 - axis];
            mean(0).hypot(mean(1))
        })
    }

    /// Returns the deviation of the potential from its mean gradient at every cell; zero where nothing flows.
    pub(crate) fn spread(&self, potential: &[Potential]) -> Vec<f64> {
        self.at_every_cell(|_, number| {
            let Potential([high, low]) = potential[number];
            high + low
        })
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

/// Returns the harmonic mean, the conductivity of two layers in series.
fn mean(a: f64, b: f64) -> f64 {
    let (less, more) = (a.min(b), a.max(b));
    if less > 0.0 { less * (2.0 * more / (more + less)) } else { 0.0 }
}

/// Finds the patches of conducting cells.
pub(crate) fn conducting(conductivity: ArrayView2<f64>, boundary: Boundary) -> Patches {
    Patches::of(conductivity.mapv(|k| k > 0.0).view(), boundary)
}
