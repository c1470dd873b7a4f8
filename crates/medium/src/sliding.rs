use std::sync::Arc;

use gfmd_contact::{Boundary, Budget, Contact, Load, Refusal, Solution, SolveError, Solved, SteadyContact, Watch};
use gfmd_field::{Grid, Transform};
use gfmd_green::Body;
use gfmd_vector::{contiguous, reduce};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::spectrum::{Spectrum, stiffness};
use crate::{Prony, Relaxes, Velocity};

/// A rigid rough surface sliding steadily over a viscoelastic body, with a hard wall and without interfacial friction
/// (theory.md, section 7.8).
///
/// All fields move with the surface, so that a wave q deforms the body at the frequency −q·v and its stiffness is
/// complex. The compliance is positive definite but not symmetric, and the contact under any load is unique.
#[derive(Clone, Debug)]
pub struct SlidingContact {
    /// Contact with the long-term moduli.
    contact: Contact,
    spectrum: Arc<Spectrum>,
    /// Long-term stiffness of each mode, stress/length; infinite for the uniform mode if the mean level does not move.
    stiffness: Arc<Vec<f64>>,
    /// Spectrum of the heights without the uniform mode.
    heights: Arc<Vec<Complex64>>,
    transform: Arc<Transform>,
}

/// Steady state of sliding.
#[derive(Clone, Debug)]
pub struct SlidingState {
    /// Pressure, displacement, gap and residuals.
    pub solution: Solution,
    /// Power lost in the body, per area, in stress × velocity.
    pub dissipated_power: f64,
    /// Coefficient of hysteretic friction: `dissipated_power` divided by velocity and mean pressure.
    pub friction: f64,
    /// Friction from the pressure on the surface slopes. Its difference from `friction` is a grid error.
    pub friction_slope: f64,
}

/// Persson's theory of hysteretic friction for the heights and the body of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Persson {
    /// Friction coefficient.
    pub friction: f64,
    /// Contact area divided by the nominal area.
    pub area_fraction: f64,
}

/// Error: a contact that cannot slide steadily.
#[derive(Debug, thiserror::Error)]
pub enum SlidingError {
    /// Free boundaries: the surface is not periodic.
    #[error("the boundary is free; it must be periodic for steady sliding")]
    Free,
    /// A hardness, which limits the pressure.
    #[error("a hardness is given; it must be left out for steady sliding")]
    Hardness,
    /// A body with unknown relaxation.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Stiffness of all modes at one velocity.
struct Moving {
    /// S(q) divided by the long-term stiffness.
    modulus: Vec<Complex64>,
    /// q·v without Nyquist components.
    rate: Vec<f64>,
}

impl SlidingContact {
    /// Creates the sliding contact of `body`, relaxing by a Prony series. `contact` has its long-term moduli.
    ///
    /// # Errors
    /// Returns an error for free boundaries, a hardness, or a body with unknown relaxation in shear alone.
    pub fn new(contact: Contact, body: &Body, prony: &Prony, relaxes: Relaxes) -> Result<Self, SlidingError> {
        let spectrum = Spectrum::new(body, contact.surface().grid(), false, prony, relaxes)?;
        Self::of(contact, body, spectrum)
    }

    /// Creates the sliding contact of the elastic `body` of `contact`: static at any velocity, without friction.
    ///
    /// # Errors
    /// Returns an error for free boundaries or a hardness.
    pub fn elastic(contact: Contact, body: &Body) -> Result<Self, SlidingError> {
        Self::of(contact, body, Spectrum::Common(Vec::new()))
    }

    fn of(contact: Contact, body: &Body, spectrum: Spectrum) -> Result<Self, SlidingError> {
        if contact.boundary() == Boundary::Free {
            return Err(SlidingError::Free);
        }
        if contact.hardness().is_some() {
            return Err(SlidingError::Hardness);
        }
        let grid = *contact.surface().grid();
        let stiffness = stiffness(body, &grid);
        let transform = Transform::new(grid);
        let mut heights = vec![Complex64::ZERO; grid.spectrum_len()];
        let below: Vec<f64> = contact.surface().clearance().iter().map(|clearance| -clearance).collect();
        transform.forward(&below, &mut heights, &mut transform.workspace()).map_err(Refusal::from)?;
        heights[0] = Complex64::ZERO;
        let (spectrum, stiffness) = (spectrum.into(), stiffness.into());
        Ok(Self { contact, spectrum, stiffness, heights: heights.into(), transform: transform.into() })
    }

    /// Returns the contact with the long-term moduli, the limit of slow sliding.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    fn at(&self, velocity: &Velocity) -> Moving {
        let grid = self.grid();
        let modulus_of = |index: usize, frequency: f64| match &*self.spectrum {
            Spectrum::Common(branches) => Prony::modulus_of(branches.iter().copied(), frequency),
            Spectrum::Waves(waves) => Prony::modulus_of(waves.of(index), frequency),
        };
        let of = |index: usize| {
            let mode = grid.mode_at(index);
            let ([x, y], [nyquist_x, nyquist_y]) = (mode.wavevector, mode.nyquist);
            // A Nyquist wave has the mean stiffness of its aliases.
            let (mut sum, mut count) = (Complex64::ZERO, 0.0);
            for wave in mode.aliases() {
                sum += modulus_of(index, -velocity.along(wave));
                count += 1.0;
            }
            let without = [if nyquist_x { 0.0 } else { x }, if nyquist_y { 0.0 } else { y }];
            (sum / count, velocity.along(without))
        };
        let (modulus, rate) = (0..grid.spectrum_len()).into_par_iter().map(of).unzip();
        Moving { modulus, rate }
    }

    /// Solves the steady state under `load` at `velocity`; `start` is the state at another load or velocity, if any.
    ///
    /// # Errors
    /// Returns an error for an invalid load; other errors contain the state reached.
    pub fn slide(
        &self,
        velocity: &Velocity,
        load: Load,
        budget: &Budget,
        start: Option<&SlidingState>,
        watch: &mut dyn Watch,
    ) -> Result<SlidingState, SolveError<SlidingState>> {
        let moving = self.at(velocity);
        let steady = SteadyContact::new(&self.contact, moving.modulus.clone())?;
        let solved = steady.equilibrate(load, budget, start.map(|start| &start.solution), watch);
        let with_friction = |solution| self.with_friction(velocity, &moving, solution);
        solved.map(with_friction).map_err(|error| error.map(with_friction))
    }

    /// Computes the steady state of a `pressure` under `load` at `velocity`, with residuals from fresh transforms.
    ///
    /// # Errors
    /// Returns an error if the shape of the pressure differs from the grid.
    pub fn certify(&self, velocity: &Velocity, pressure: &Array2<f64>, load: Load) -> Result<SlidingState, Refusal> {
        let moving = self.at(velocity);
        let solution = SteadyContact::new(&self.contact, moving.modulus.clone())?.certify(pressure, load)?;
        Ok(self.with_friction(velocity, &moving, solution))
    }

    /// Adds the friction to a solution.
    fn with_friction(&self, velocity: &Velocity, moving: &Moving, solution: Solution) -> SlidingState {
        let grid = self.grid();
        let mut pressure = vec![Complex64::ZERO; grid.spectrum_len()];
        let values = contiguous(&solution.pressure);
        let fits = self.transform.forward(&values, &mut pressure, &mut self.transform.workspace());
        fits.expect("the pressure has the size of the grid");
        drop(values);
        let [power, slope] = reduce(
            pressure.len(),
            &|range| {
                range.fold([0.0; 2], |[power, slope], i| {
                    let (p, rate, weight) = (pressure[i], moving.rate[i], grid.mode_at(i).weight);
                    // −⟨p, v·∇d⟩ with d = G p, and −⟨p, v·∇h⟩.
                    let loss = rate * (1.0 / moving.modulus[i]).im / self.stiffness[i];
                    let on_slopes = rate * (p.conj() * self.heights[i]).im;
                    [power + weight * p.norm_sqr() * loss, slope + weight * on_slopes]
                })
            },
            &gfmd_vector::add,
        );
        let moved = velocity.speed() * solution.mean_pressure;
        SlidingState { solution, dissipated_power: power, friction: power / moved, friction_slope: slope / moved }
    }

    /// Evaluates Persson's theory for a velocity and mean pressure, with all height waves (theory.md, section 7.8).
    pub fn persson(&self, velocity: &Velocity, mean_pressure: f64) -> Persson {
        let (grid, moving) = (self.grid(), self.at(velocity));
        let mut waves: Vec<[f64; 3]> = (1..grid.spectrum_len())
            .map(|i| {
                let mode = grid.mode_at(i);
                let (stiffness, power) = (self.stiffness[i] * moving.modulus[i], self.heights[i].norm_sqr());
                let loss = mode.weight * power * moving.rate[i] * -stiffness.im / velocity.speed();
                [mode.wavenumber(), mode.weight * power * stiffness.norm_sqr(), loss]
            })
            .collect();
        waves.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let [mut variance, mut friction, mut from] = [0.0, 0.0, 0.0];
        let mut first = 0;
        while first < waves.len() {
            // Waves of equal length count together.
            let same = waves[first..].iter().take_while(|wave| wave[0] <= waves[first][0] * (1.0 + EQUAL)).count();
            let group = &waves[first..first + same];
            variance += group.iter().map(|wave| wave[1]).sum::<f64>();
            from = if variance > 0.0 { libm::erf(mean_pressure / (2.0 * variance).sqrt()) } else { 1.0 };
            friction += from * group.iter().map(|wave| wave[2]).sum::<f64>();
            first += same;
        }
        Persson { friction: friction / mean_pressure, area_fraction: from }
    }
}

/// Relative difference of wavenumbers caused by rounding.
const EQUAL: f64 = 1e-9;

impl Solved for SlidingState {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.solution
    }
}
