//! Relaxation of a free slab that is displaced at one point, with several dampings (theory.md, section 6.1).

use std::f64::consts::TAU;

use gfmd_field::{Grid, Mode};
use gfmd_green::{Body, stiffness_range};
use gfmd_relax::{Damping, Harmonic, Landscape, Method, RelaxError, Verlet};
use gfmd_response::{Components, FullResponse, Hermitian};

/// Time step divided by its stability limit without damping.
const TIME_STEP: f64 = 0.25;

/// Free surface with its slowest mode.
pub(super) struct FreeSlab {
    response: FullResponse,
    /// Time step at unit mass per area.
    dt: f64,
    /// Stiffness of the slowest mode.
    softest: f64,
    /// Shape of the slowest mode on the surface.
    pattern: Vec<f64>,
}

impl FreeSlab {
    /// Creates the surface of a body; `None` on a grid of a single point.
    pub(super) fn new(body: &Body, grid: Grid) -> Option<Self> {
        let range = stiffness_range(body, &grid)?;
        let dt = Damping::time_step(TIME_STEP, range.stiffest).ok()?;
        let pattern = pattern(body, &grid, &range.softest_mode);
        Some(Self { response: FullResponse::new(grid, body), dt, softest: range.softest, pattern })
    }

    /// Returns a damping of `factor` times the critical damping of the slowest mode.
    ///
    /// # Errors
    /// A factor that is not positive, or too large for the time step.
    fn damping(&self, factor: f64) -> Result<Damping, RelaxError> {
        let [_, stiffest] = self.response.stiffness_range();
        Damping::times_critical(factor, self.softest, stiffest, self.dt)
    }

    /// Returns the amplitude of the slowest mode relative to its start, at the start and after each of `steps` steps.
    /// One point is displaced in all components and released from rest.
    ///
    /// # Errors
    /// As [`damping`](Self::damping); a step that is not finite.
    pub(super) fn relax(&self, factor: f64, steps: usize) -> Result<Vec<f64>, RelaxError> {
        let [_, stiffest] = self.response.stiffness_range();
        let verlet = Verlet::new(self.damping(factor)?, stiffest)?;
        let (stiffness, mut workspace) = (self.response.stiffness(), self.response.workspace());
        let mut free = Harmonic::new(self.pattern.len(), |u: &[f64], force: &mut [f64]| {
            stiffness.apply(u, force, &mut workspace).expect("u and force have the length of the problem");
        });
        let points = self.response.grid().len();
        let mut push = vec![0.0; free.len()];
        for (axis, component) in push.chunks_exact_mut(points).enumerate() {
            component[0] = 1.0;
            // The mean normal displacement of an incompressible slab is zero.
            if self.response.uniform_compliance()[self.response.components().axes()[axis]] == 0.0 {
                component.iter_mut().for_each(|u| *u -= 1.0 / points as f64);
            }
        }
        let mut state = verlet.start(&mut free, push)?;
        let amplitude = |u: &[f64]| self.pattern.iter().zip(u).map(|(pattern, u)| pattern * u).sum::<f64>();
        let start = amplitude(&state.u);
        let mut amplitudes = vec![1.0];
        for _ in 0..steps {
            verlet.step(&mut free, &mut state)?;
            amplitudes.push(amplitude(&state.u) / start);
        }
        Ok(amplitudes)
    }
}

/// Returns the real field of the softest eigenvector of `mode`.
fn pattern(body: &Body, grid: &Grid, mode: &Mode) -> Vec<f64> {
    let components = Components::of(grid);
    let matrix = if mode.is_uniform() {
        let [lateral, normal] = body.level_compliance().map(f64::recip);
        Hermitian { xx: lateral, yy: lateral, zz: normal, xy: 0.0, xz: 0.0, yz: 0.0 }
    } else {
        Hermitian::of(&body.stiffness_of(mode))
    };
    let moves = |vector: &[f64; 3]| components == Components::Space || vector[1].abs() < 0.5;
    let modes = matrix.modes();
    let softest = modes.iter().map(|(_, vector)| vector).find(|vector| moves(vector)).unwrap_or(&modes[0].1);
    let [nx, ny] = grid.points();
    let mut pattern = Vec::with_capacity(components.len() * grid.len());
    for &axis in components.axes() {
        for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
            let turns = mode.number[0] as f64 * i as f64 / nx as f64 + mode.number[1] as f64 * j as f64 / ny as f64;
            // The component along z is imaginary, unless the mode is its own conjugate.
            let wave = if axis == 2 && !mode.is_self_conjugate() { -(TAU * turns).sin() } else { (TAU * turns).cos() };
            pattern.push(softest[axis] * wave);
        }
    }
    pattern
}

#[cfg(test)]
mod tests {
    use gfmd_green::Material;

    use super::*;

    /// Slabs in space and in plane strain. The slowest mode of the last one is not uniform.
    #[test]
    fn the_slowest_mode_relaxes_as_predicted() {
        let slab = |nu, height| Body::slab(Material::from_young(1.0, nu).unwrap(), height).unwrap();
        for (points, body) in [
            ([8, 8], slab(0.33, 1.0)),
            ([7, 7], slab(-0.5, 0.3)),
            ([33, 1], slab(0.5, 0.2)),
            ([16, 1], slab(-0.9, 0.1)),
        ] {
            let free = FreeSlab::new(&body, Grid::new(points, [1.0; 2]).unwrap()).unwrap();
            for factor in [0.2, 0.5, 1.0, 2.0] {
                let damping = free.damping(factor).unwrap();
                for (step, found) in free.relax(factor, 400).unwrap().into_iter().enumerate() {
                    let expected = damping.amplitude(free.softest, step as u32);
                    assert!((found - expected).abs() < 1e-9, "{points:?}, {factor}, {step}: {found} {expected}");
                }
            }
        }
    }
}
