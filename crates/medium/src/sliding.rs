use std::sync::Arc;

use gfmd_contact::{Boundary, Budget, Contact, Load, Refusal, Solution, SolveError, Solved, SteadyContact, Watch};
use gfmd_field::{Grid, Mode, Transform};
use gfmd_green::{Blocks, Body, Height};
use gfmd_vector::{contiguous, reduce};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::bulk::bulk;
use crate::spectrum::{Modes, Spectrum, stiffness};
use crate::{Prony, Relaxes, Velocity};

/// A rigid rough surface sliding steadily over a body, with a hard wall or a hardness, and with or without friction of
/// the interface (theory.md, section 7.8).
///
/// All fields move with the surface, so that a wave q deforms the body at the frequency −q·v and its stiffness is
/// complex. The compliance is positive definite but not symmetric, and the contact under any load is unique. With
/// [friction](Self::with_friction) all points slide: the shear is proportional to the pressure, and lifts the surface.
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
    /// Friction of the interface, if it has one.
    rubbing: Option<Arc<Rubbing>>,
}

/// Friction of the interface.
#[derive(Debug)]
struct Rubbing {
    coefficient: f64,
    body: Body,
    /// Relaxation of the shear modulus of a half-space with a constant bulk modulus; `None` if all moduli relax alike.
    shear_alone: Option<Prony>,
}

/// Steady state of sliding.
#[derive(Clone, Debug)]
pub struct SlidingState {
    /// Pressure, displacement, gap and residuals.
    pub solution: Solution,
    /// Power lost in the body, per area, in stress × velocity.
    pub dissipated_power: f64,
    /// Coefficient of friction: the lateral force divided by the load, `friction_interface` + `friction_hysteresis`.
    pub friction: f64,
    /// Coefficient of friction of the interface: mean shear divided by mean pressure.
    pub friction_interface: f64,
    /// Friction from the pressure on the slopes of the deformed body, −⟨p v·∇d⟩ divided by velocity and mean pressure.
    /// Without friction of the interface it is `dissipated_power` divided by both.
    pub friction_hysteresis: f64,
    /// Friction from the pressure on the surface slopes, and of the interface. Its difference from `friction` is a grid
    /// error.
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
    /// A coefficient of friction that is negative or not finite.
    #[error("the coefficient of friction is {0}; it must be at least 0 and finite")]
    Coefficient(f64),
    /// Friction on a body with another coupling of shear and pressure at each frequency.
    #[error(
        "the shear modulus alone relaxes; on a body that is no half-space, both moduli must relax with friction, \
         since the lift by the shear is not known"
    )]
    Lift,
    /// Friction on a body that relaxes below an elastic second one.
    #[error("one body of a pair relaxes; the second body must be left out with friction, since both lift differently")]
    PairLift,
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
    /// Effect of the shear on each wave; empty without friction.
    shear: Vec<Shear>,
}

/// Effect of the shear on a wave, relative to its normal compliance.
#[derive(Clone, Copy)]
struct Shear {
    /// −iμκ q̂·e.
    lift: Complex64,
    /// μ² G_ee: compliance along the velocity times the square of the coefficient.
    lateral: Complex64,
}

impl Moving {
    /// Returns the compliance of a wave times its long-term stiffness, with the lift by the shear.
    fn compliance(&self, index: usize) -> Complex64 {
        self.lifted(index) / self.modulus[index]
    }

    /// Returns the displacement of a wave divided by what its pressure alone causes.
    fn lifted(&self, index: usize) -> Complex64 {
        self.shear.get(index).map_or(Complex64::ONE, |shear| 1.0 + shear.lift)
    }

    /// Returns the modulus of each wave with the lift by the shear.
    fn lifting(&self) -> Vec<Complex64> {
        if self.shear.is_empty() {
            return self.modulus.clone();
        }
        self.modulus.iter().enumerate().map(|(index, modulus)| modulus / self.lifted(index)).collect()
    }
}

impl SlidingContact {
    /// Creates the sliding contact of `body`, relaxing by a Prony series. `contact` has its long-term moduli.
    ///
    /// # Errors
    /// Returns an error for free boundaries, or a body with unknown relaxation in shear alone.
    pub fn new(contact: Contact, body: &Body, prony: &Prony, relaxes: Relaxes) -> Result<Self, SlidingError> {
        let spectrum = Spectrum::new(body, &Modes::all(contact.surface().grid()), false, prony, relaxes)?;
        Self::of(contact, body, spectrum)
    }

    /// Creates the sliding contact of the elastic `body` of `contact`: static at any velocity, without friction.
    ///
    /// # Errors
    /// Returns an error for free boundaries.
    pub fn elastic(contact: Contact, body: &Body) -> Result<Self, SlidingError> {
        Self::of(contact, body, Spectrum::Common(Vec::new()))
    }

    fn of(contact: Contact, body: &Body, spectrum: Spectrum) -> Result<Self, SlidingError> {
        if contact.boundary() == Boundary::Free {
            return Err(SlidingError::Free);
        }
        let grid = *contact.surface().grid();
        let stiffness = stiffness(body, &Modes::all(&grid), Body::normal_stiffness);
        let transform = Transform::new(grid);
        let mut heights = vec![Complex64::ZERO; grid.spectrum_len()];
        let below: Vec<f64> = contact.surface().clearance().iter().map(|clearance| -clearance).collect();
        transform.forward(&below, &mut heights, &mut transform.workspace()).map_err(Refusal::from)?;
        heights[0] = Complex64::ZERO;
        let (spectrum, stiffness) = (spectrum.into(), stiffness.into());
        let (heights, transform) = (heights.into(), transform.into());
        Ok(Self { contact, spectrum, stiffness, heights, transform, rubbing: None })
    }

    /// Adds Coulomb friction with this `coefficient` between the surfaces, which slide at all points. `body` is the
    /// body of the contact, and relaxes by `prony` if it relaxes.
    ///
    /// # Errors
    /// Returns an error for a coefficient that is negative or not finite, and for a compressible body that relaxes in
    /// shear alone and is no half-space.
    pub fn with_friction(
        self,
        body: &Body,
        coefficient: f64,
        relaxation: Option<(&Prony, Relaxes)>,
    ) -> Result<Self, SlidingError> {
        if !(coefficient >= 0.0 && coefficient.is_finite()) {
            return Err(SlidingError::Coefficient(coefficient));
        }
        let shear_alone = match (relaxation, body.height()) {
            (Some(_), _) if body.second().is_some() => return Err(SlidingError::PairLift),
            (None | Some((_, Relaxes::Both)), _) => None,
            _ if body.material().poisson() == 0.5 => None,
            (Some((prony, Relaxes::Shear)), Height::Infinite) => Some(prony.clone()),
            _ => return Err(SlidingError::Lift),
        };
        Ok(Self { rubbing: Some(Arc::new(Rubbing { coefficient, body: body.clone(), shear_alone })), ..self })
    }

    /// Checks that a state exists at a velocity: no wave is lifted by the shear as much as the loss in the body allows.
    ///
    /// # Errors
    /// Returns an error that names the angle by which the pressure of a wave leads its displacement.
    pub fn check(&self, velocity: &Velocity) -> Result<(), Refusal> {
        SteadyContact::new(&self.contact, self.at(velocity).lifting()).map(|_| ())
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
        let shear = |rubbing: &Arc<Rubbing>| {
            (0..grid.spectrum_len())
                .into_par_iter()
                .map(|index| rubbing.shear(&grid.mode_at(index), velocity))
                .collect()
        };
        Moving { modulus, rate, shear: self.rubbing.as_ref().map_or_else(Vec::new, shear) }
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
        let steady = SteadyContact::new(&self.contact, moving.lifting())?;
        let solved = steady.equilibrate(load, budget, start.map(|start| &start.solution), watch);
        let measured = |solution| self.measured(velocity, &moving, solution);
        solved.map(measured).map_err(|error| error.map(measured))
    }

    /// Computes the steady state of a `pressure` under `load` at `velocity`, with residuals from fresh transforms.
    ///
    /// # Errors
    /// Returns an error if the shape of the pressure differs from the grid.
    pub fn certify(&self, velocity: &Velocity, pressure: &Array2<f64>, load: Load) -> Result<SlidingState, Refusal> {
        let moving = self.at(velocity);
        let solution = SteadyContact::new(&self.contact, moving.lifting())?.certify(pressure, load)?;
        Ok(self.measured(velocity, &moving, solution))
    }

    /// Computes the spectrum of a field.
    fn spectrum_of(&self, field: &Array2<f64>) -> Vec<Complex64> {
        let mut spectrum = vec![Complex64::ZERO; self.grid().spectrum_len()];
        let fits = self.transform.forward(&contiguous(field), &mut spectrum, &mut self.transform.workspace());
        fits.expect("the field has the size of the grid");
        spectrum
    }

    /// Adds the friction to a solution.
    fn measured(&self, velocity: &Velocity, moving: &Moving, solution: Solution) -> SlidingState {
        let grid = self.grid();
        let pressure = self.spectrum_of(&solution.pressure);
        // Where the pressure is the hardness, the rough surface is flattened by the plastic depth.
        let depth = solution.plastic.as_ref().map(|plastic| self.spectrum_of(&plastic.depth));
        let height = |i: usize| self.heights[i] - depth.as_ref().map_or(Complex64::ZERO, |depth| depth[i]);
        let [power, slope, lost] = reduce(
            pressure.len(),
            &|range| {
                range.fold([0.0; 3], |[power, slope, lost], i| {
                    let (p, rate, weight) = (pressure[i], moving.rate[i], grid.mode_at(i).weight);
                    // −⟨p, v·∇d⟩ with d = G p, and −⟨p, v·∇h⟩; −⟨t, v·∇u⟩ has no part of the coupling.
                    let loss = rate * moving.compliance(i).im / self.stiffness[i];
                    let lateral = moving.shear.get(i).map_or(Complex64::ONE, |shear| 1.0 + shear.lateral);
                    let in_body = rate * (lateral / moving.modulus[i]).im / self.stiffness[i];
                    let on_slopes = rate * (p.conj() * height(i)).im;
                    let square = weight * p.norm_sqr();
                    [power + square * loss, slope + weight * on_slopes, lost + square * in_body]
                })
            },
            &gfmd_vector::add,
        );
        let moved = velocity.speed() * solution.mean_pressure;
        let (hysteresis, slope) = (power / moved, slope / moved);
        let state = SlidingState {
            solution,
            dissipated_power: power,
            friction: hysteresis,
            friction_interface: 0.0,
            friction_hysteresis: hysteresis,
            friction_slope: slope,
        };
        let Some(rubbing) = &self.rubbing else { return state };
        SlidingState {
            dissipated_power: lost,
            friction: rubbing.coefficient + hysteresis,
            friction_interface: rubbing.coefficient,
            friction_slope: rubbing.coefficient + slope,
            ..state
        }
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

impl Rubbing {
    /// Returns the effect of the shear on a wave at a velocity (theory.md, section 7.8).
    fn shear(&self, mode: &Mode, velocity: &Velocity) -> Shear {
        if mode.is_uniform() {
            return Shear { lift: Complex64::ZERO, lateral: Complex64::ZERO };
        }
        let along = velocity.direction();
        let [x, y] = [0, 1].map(|axis| mode.wavevector[axis] / mode.wavenumber() * along[axis]);
        // Odd parts of a Nyquist wave cancel between its aliases.
        let odd = [x, y].into_iter().zip(mode.nyquist).map(|(part, is_nyquist)| if is_nyquist { 0.0 } else { part });
        let mixed = if mode.nyquist.contains(&true) { 0.0 } else { 2.0 * x * y };
        let parallel = x * x + y * y + mixed;
        let [coupling, longitudinal, transverse] = self.ratios(mode, velocity);
        Shear {
            lift: Complex64::new(0.0, -self.coefficient * odd.sum::<f64>()) * coupling,
            lateral: self.coefficient.powi(2) * (parallel * longitudinal + (1.0 - parallel) * transverse),
        }
    }

    /// Returns the coupling of shear and pressure, and the compliances along and across a wave, divided by its normal
    /// compliance.
    fn ratios(&self, mode: &Mode, velocity: &Velocity) -> [Complex64; 3] {
        let Some(prony) = &self.shear_alone else {
            let Blocks { longitudinal, normal, transverse, coupling } = self.body.compliance_blocks(mode.wavenumber());
            return [coupling[1] / normal, longitudinal / normal, transverse / normal].map(Complex64::from);
        };
        let aliases: Vec<Complex64> = mode.aliases().map(|wave| prony.modulus(-velocity.along(wave))).collect();
        let shear = aliases.iter().sum::<Complex64>() / aliases.len() as f64;
        // (1 − 2ν)/(2 (1 − ν)), 1, and 1/(1 − ν) with a constant bulk modulus.
        let both = 3.0 * bulk(self.body.material()) + 4.0 * shear;
        [3.0 * shear / both, Complex64::ONE, 2.0 * (both - 3.0 * shear) / both]
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
