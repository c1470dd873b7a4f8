//! Transposes of the relations of a step, for derivatives along a path (theory.md, section 7.9).

use std::ops::{Add, Mul};

use num_complex::Complex64;

use crate::branch::Branch;
use crate::step::{Decay, stiffening};

/// Derivatives of a number with respect to the lengths of a [`Memory`](crate::Memory): to the indentation d, and to the
/// elongation x of the spring of each branch.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryDerivatives(pub(crate) Lengths);

/// One value for each length of a memory.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Lengths {
    /// Point by point: of d, then of x of each branch.
    Points(Vec<Vec<f64>>),
    /// Spectra of the derivatives at the points.
    Waves(Vec<Vec<Complex64>>),
}

impl MemoryDerivatives {
    /// Adds the derivatives of another number with respect to the same memory; false if they belong to another body.
    pub fn add(&mut self, other: &Self) -> bool {
        match (&mut self.0, &other.0) {
            (Lengths::Points(own), Lengths::Points(other)) => add(own, other),
            (Lengths::Waves(own), Lengths::Waves(other)) => add(own, other),
            _ => false,
        }
    }
}

fn add<T: Copy + Add<Output = T>>(own: &mut [Vec<T>], other: &[Vec<T>]) -> bool {
    let are_alike = own.len() == other.len() && own.iter().zip(other).all(|(own, other)| own.len() == other.len());
    if are_alike {
        for (own, other) in own.iter_mut().zip(other) {
            own.iter_mut().zip(other).for_each(|(own, other)| *own = *own + *other);
        }
    }
    are_alike
}

/// Coefficients of a step for all branches, of all points together or of each wave.
pub(crate) struct Decays {
    all: Vec<Decay>,
    count: usize,
    is_common: bool,
}

impl Decays {
    /// Returns the coefficients common to all points.
    pub(crate) fn common(branches: &[Branch], duration: f64) -> Self {
        let all: Vec<Decay> = branches.iter().map(|branch| Decay::new(*branch, duration)).collect();
        Self { count: all.len(), all, is_common: true }
    }

    /// Returns the coefficients of waves with `count` branches each, wave by wave.
    pub(crate) fn of_waves(branches: impl Iterator<Item = Branch>, count: usize, duration: f64) -> Self {
        Self { all: branches.map(|branch| Decay::new(branch, duration)).collect(), count, is_common: false }
    }

    /// Returns the coefficients of point or wave `i`.
    fn at(&self, i: usize) -> &[Decay] {
        if self.is_common { &self.all } else { &self.all[i * self.count..][..self.count] }
    }

    /// Transposes the end of a step, x' = e x + γ (d' − d): from the derivatives with respect to d' and x', computes
    /// the derivatives with respect to d', and to d and x at the start.
    pub(crate) fn end<T>(&self, of: &[Vec<T>]) -> (Vec<T>, Vec<Vec<T>>)
    where
        T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>,
    {
        let (mut by_indentation, mut start) = (of[0].clone(), of.to_vec());
        for i in 0..by_indentation.len() {
            let mut moved = T::default();
            for (branch, decay) in self.at(i).iter().enumerate() {
                let by_elongation = of[1 + branch][i];
                moved = moved + by_elongation * decay.taken;
                start[1 + branch][i] = by_elongation * decay.left;
            }
            by_indentation[i] = by_indentation[i] + moved;
            start[0][i] = moved * -1.0;
        }
        (by_indentation, start)
    }

    /// Transposes the beginning of a step, H = Σ c (γ d − e x)/m: adds the effect of the derivatives with respect to H.
    pub(crate) fn begin<T>(&self, by_residual: &[T], of: &mut [Vec<T>])
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        for (i, by_residual) in by_residual.iter().enumerate() {
            let decays = self.at(i);
            let stiffening = stiffening(decays.iter().copied());
            for (branch, decay) in decays.iter().enumerate() {
                let share = *by_residual * (decay.weight / stiffening);
                of[0][i] = of[0][i] + share * decay.taken;
                of[1 + branch][i] = of[1 + branch][i] + share * -decay.left;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use gfmd_contact::Boundary;
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_vector::dot;

    use super::*;
    use crate::{Medium, Memory, Prony, Relaxes, Relaxing};

    fn field(grid: &Grid, seed: f64) -> Vec<f64> {
        (0..grid.len()).map(|i| (1.7 * i as f64 + seed).sin() + 0.3 * (0.9 * i as f64 * seed).cos()).collect()
    }

    /// Returns bodies whose waves relax alike, and one whose waves have branches of their own.
    fn media(grid: &Grid) -> [Relaxing; 2] {
        let slab = Body::slab(Material::from_young(1.3, 0.3).unwrap(), 0.4).unwrap();
        let prony = Prony::from_fractions(&[(0.3, 0.2), (2.0, 0.4)]).unwrap();
        [Relaxes::Both, Relaxes::Shear]
            .map(|relaxes| Relaxing::new(&slab, grid, Boundary::Periodic, 1, &prony, relaxes).unwrap())
    }

    /// Returns the memory after two steps with the given indentations, which is a general one.
    fn memory_after(medium: &Relaxing, grid: &Grid, seed: f64) -> Memory {
        let mut memory = medium.rest();
        for (step, duration) in [0.2, 0.9].into_iter().enumerate() {
            let affine = medium.begin(&memory, duration).unwrap();
            let pressure = field(grid, seed + 5.0 + step as f64);
            memory = medium.end(&memory, &affine, field(grid, seed + step as f64), &pressure).unwrap().0;
        }
        memory
    }

    /// Returns the product of derivatives with a memory, at the points.
    fn product(medium: &Relaxing, grid: &Grid, of: &MemoryDerivatives, memory: &Memory) -> f64 {
        let lengths = memory.normal(grid, &grid.whole()).unwrap();
        let fields = match &of.0 {
            Lengths::Points(of) => of.clone(),
            Lengths::Waves(of) => of.iter().map(|spectrum| medium.inverse(spectrum)).collect(),
        };
        assert_eq!(fields.len(), lengths.len());
        fields.iter().zip(&lengths).map(|(by, x)| dot(by, x)).sum()
    }

    #[test]
    fn a_step_and_its_transpose_have_the_same_products() {
        let grid = Grid::new([6, 5], [1.0, 0.8]).unwrap();
        for medium in media(&grid) {
            for duration in [0.0, 0.3, 40.0] {
                let (start, of) = (memory_after(&medium, &grid, 0.4), memory_after(&medium, &grid, 7.1));
                // The derivatives are any numbers; an energy has some.
                let of = medium.energy_derivatives(&of, 3.0).unwrap();
                let affine = medium.begin(&start, duration).unwrap();
                let indentation = field(&grid, 2.2);
                let (end, _) = medium.end(&start, &affine, indentation.clone(), &field(&grid, 1.0)).unwrap();
                let (by_indentation, mut by_start) = medium.end_transposed(&of, duration).unwrap();
                let forward = product(&medium, &grid, &of, &end);
                let back = dot(&by_indentation, &indentation) + product(&medium, &grid, &by_start, &start);
                assert!((forward - back).abs() <= 1e-12 * forward.abs(), "{duration}: {forward} {back}");
                let by_residual = field(&grid, 9.9);
                let before = product(&medium, &grid, &by_start, &start);
                medium.begin_transposed(&by_residual, duration, &mut by_start).unwrap();
                let forward = dot(&by_residual, &affine.residual_indentation);
                let back = product(&medium, &grid, &by_start, &start) - before;
                assert!((forward - back).abs() <= 1e-12 * (forward.abs() + before.abs()), "{forward} {back}");
            }
        }
    }

    #[test]
    fn the_derivatives_of_the_energy_are_twice_the_energy() {
        let grid = Grid::new([6, 5], [1.0, 0.8]).unwrap();
        let body = Body::slab(Material::from_young(1.3, 0.3).unwrap(), 0.4).unwrap();
        // Indentations that the stresses of the memory belong to.
        for medium in media(&grid) {
            let mut memory = medium.rest();
            let mut stored = 0.0;
            for (step, duration) in [0.2, 0.9].into_iter().enumerate() {
                let affine = medium.begin(&memory, duration).unwrap();
                let pressure = field(&grid, 5.0 + step as f64);
                let mut response = gfmd_response::NormalResponse::new(grid, &body);
                if let crate::Stiffening::Waves(factors) = &affine.stiffening {
                    response = response.stiffened(factors);
                }
                let response = std::sync::Arc::new(response);
                let mut transforms = gfmd_response::NormalTransforms::of(&response);
                let mut indentation = vec![0.0; grid.len()];
                transforms.convolve(response.compliance(), &pressure, &mut indentation);
                let level = response.uniform_compliance() * gfmd_vector::total(&pressure) / grid.len() as f64;
                let depths = indentation.iter().zip(&affine.residual_indentation);
                let indentation = depths.map(|(d, depth)| d + depth + level).collect();
                let (next, energies) = medium.end(&memory, &affine, indentation, &pressure).unwrap();
                (memory, stored) = (next, energies.stored);
            }
            let of = medium.energy_derivatives(&memory, 1.0).unwrap();
            let found = product(&medium, &grid, &of, &memory);
            assert!((found - 2.0 * stored).abs() <= 1e-12 * found, "{found} {stored}");
        }
    }

    #[test]
    fn derivatives_of_another_body_are_refused() {
        let grid = Grid::new([6, 5], [1.0, 0.8]).unwrap();
        let [points, waves] = media(&grid);
        let [of_points, of_waves] =
            [&points, &waves].map(|medium| medium.energy_derivatives(&medium.rest(), 1.0).unwrap());
        assert!(points.energy_derivatives(&waves.rest(), 1.0).is_err());
        assert!(points.end_transposed(&of_waves, 1.0).is_err() && waves.end_transposed(&of_points, 1.0).is_err());
        assert!(points.begin_transposed(&[1.0; 3], 1.0, &mut of_points.clone()).is_err());
        assert!(!of_points.clone().add(&of_waves));
        let longer = Grid::new([8, 5], [1.0, 0.8]).unwrap();
        let [longer, _] = media(&longer);
        assert!(longer.end_transposed(&of_points, 1.0).is_err());
    }
}
