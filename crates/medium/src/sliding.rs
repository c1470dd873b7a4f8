use std::sync::Arc;

use gfmd_contact::{
    Boundary, Budget, Contact, Effort, Equilibrium as _, Load, Refusal, Residual, RigidSurface, Solution, SolveError,
    Solved, Solver, Watch, judge,
};
use gfmd_field::{Grid, Transform, Workspace};
use gfmd_green::Body;
use gfmd_relax::{Anderson, Ending, Why};
use gfmd_vector::{contiguous, for_each, lower, reduce};
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

/// Number of images mixed in a step.
const DEPTH: usize = 8;
/// Tolerance of the first inner contact, and upper limit for the later ones.
const FIRST_INNER_TOLERANCE: f64 = 1e-3;
/// Tolerance of an inner contact divided by the last certified residual, at least this fraction of the tolerance.
const INNER_TOLERANCE_FACTOR: f64 = 0.1;
/// Number of steps within which the residual must halve.
const STEPS_TO_HALVE: u32 = 200;

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
    /// The solver of elastic contacts solves the contact with the storage moduli; the contribution of the loss moduli
    /// to the gap follows from the last pressure, iteratively. This converges for every material, by the sine of the
    /// largest loss angle per step; mixing the last images accelerates it.
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
        budget.check().map_err(Refusal::from)?;
        self.contact.check(load.into())?;
        self.contact.check_resolution(load.into(), budget.tolerance)?;
        let moving = self.at(velocity);
        let mut search = Search::new(self, &moving, *budget);
        let (state, ending) = search.run(load, start, watch)?;
        let state = self.with_friction(velocity, &moving, state);
        judge(state, ending, budget.tolerance)
    }

    /// Computes the steady state of a `pressure` under `load` at `velocity`, with residuals from fresh transforms.
    ///
    /// # Errors
    /// Returns an error if the shape of the pressure differs from the grid.
    pub fn certify(&self, velocity: &Velocity, pressure: &Array2<f64>, load: Load) -> Result<SlidingState, Refusal> {
        let (moving, solution) = (self.at(velocity), self.contact.certify(pressure, load)?);
        let certified = Search::new(self, &moving, Budget::default()).certify(solution, load);
        Ok(self.with_friction(velocity, &moving, certified))
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

/// Search for a steady state.
struct Search<'a> {
    sliding: &'a SlidingContact,
    budget: Budget,
    /// Contact of the undeformed surface with the storage moduli.
    storing: Contact,
    /// √A of each mode, with A = 1/Re S.
    root: Vec<f64>,
    /// (G − A)/√A of each mode.
    rest: Vec<Complex64>,
    /// G of each mode.
    compliance: Vec<Complex64>,
    workspace: Workspace,
    spectrum: Vec<Complex64>,
    effort: Effort,
}

impl<'a> Search<'a> {
    fn new(sliding: &'a SlidingContact, moving: &Moving, budget: Budget) -> Self {
        let stored: Vec<f64> = moving.modulus.iter().map(|modulus| modulus.re).collect();
        let each = || moving.modulus.iter().zip(&*sliding.stiffness);
        let root: Vec<f64> = each().map(|(modulus, stiffness)| (1.0 / (stiffness * modulus.re)).sqrt()).collect();
        let compliance: Vec<Complex64> = each().map(|(modulus, stiffness)| 1.0 / modulus / *stiffness).collect();
        let rest = compliance.iter().zip(&root).map(|(g, root)| match *root {
            0.0 => Complex64::ZERO,
            root => (g - root * root) / root,
        });
        Self {
            storing: sliding.contact.stiffened(&stored),
            rest: rest.collect(),
            root,
            compliance,
            workspace: sliding.transform.workspace(),
            spectrum: vec![Complex64::ZERO; sliding.grid().spectrum_len()],
            effort: Effort::default(),
            sliding,
            budget,
        }
    }

    /// Computes F⁻¹\[k F\[field\]\].
    fn convolve<K: Copy + Into<Complex64>>(
        (transform, workspace, spectrum): (&Transform, &mut Workspace, &mut [Complex64]),
        kernel: &[K],
        field: &[f64],
    ) -> Vec<f64> {
        const FITS: &str = "every field has the size of the grid";
        let mut out = vec![0.0; field.len()];
        transform.forward(field, spectrum, workspace).expect(FITS);
        spectrum.iter_mut().zip(kernel).for_each(|(mode, k)| *mode *= (*k).into());
        transform.inverse(spectrum, &mut out, workspace).expect(FITS);
        out
    }

    /// Computes √A p for a pressure.
    fn image(&mut self, pressure: &[f64]) -> Vec<f64> {
        self.effort.transform_pairs += 1.0;
        Self::convolve((&self.sliding.transform, &mut self.workspace, &mut self.spectrum), &self.root, pressure)
    }

    /// Computes the certified state of a pressure from fresh transforms.
    fn certify(&mut self, mut solution: Solution, load: Load) -> Solution {
        self.effort.transform_pairs += 1.0;
        let memory = (&*self.sliding.transform, &mut self.workspace, &mut self.spectrum[..]);
        let pressure = contiguous(&solution.pressure).into_owned();
        let indentation = Self::convolve(memory, &self.compliance, &pressure);
        let surface = self.sliding.contact.surface();
        let clearance = surface.clearance();
        let [sum, touching, room] = reduce(
            pressure.len(),
            &|range| {
                range.fold([0.0; 3], |[sum, touching, room], i| match pressure[i] > 0.0 {
                    true => [sum + pressure[i], touching + 1.0, room + (clearance[i] + indentation[i])],
                    false => [sum + pressure[i], touching, room],
                })
            },
            &gfmd_vector::add,
        );
        let approach = match load {
            Load::Approach(approach) => approach,
            Load::MeanPressure(_) => room / touching,
        };
        let mut gap = vec![0.0; pressure.len()];
        for_each([&mut gap[..]], &|start, [gap]| {
            for (k, gap) in gap.iter_mut().enumerate() {
                *gap = clearance[start + k] + indentation[start + k] - approach;
            }
        });
        let (closed, lowest) = reduce(
            gap.len(),
            &|range| {
                range.fold((0.0, f64::INFINITY), |(sum, least), i| (sum + pressure[i] * gap[i], lower(least, gap[i])))
            },
            &|a, b| (a.0 + b.0, lower(a.1, b.1)),
        );
        let [shallow, deep] = reduce(
            gap.len(),
            &|range| {
                let each = indentation[range].iter();
                each.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], d| [least.min(*d), most.max(*d)])
            },
            &|a, b| [a[0].min(b[0]), a[1].max(b[1])],
        );
        let scale = RigidSurface::finer_scale(surface.length_scale(load), deep - shallow);
        let mean = sum / pressure.len() as f64;
        solution.residual = Residual {
            complementarity: match load {
                Load::Approach(approach) if sum == 0.0 => f64::from(approach > 0.0),
                _ if sum == 0.0 => 0.0,
                _ => (closed / (sum * scale)).abs(),
            },
            penetration: if lowest >= 0.0 { 0.0 } else { -lowest / scale },
            negative_pressure: 0.0,
            load: match load {
                Load::MeanPressure(asked) => (mean - asked).abs() / asked,
                Load::Approach(_) => 0.0,
            },
        };
        let field = |values: Vec<f64>| {
            let shape = surface.grid().points();
            Array2::from_shape_vec(shape, values).expect("every field has the size of the grid")
        };
        (solution.mean_pressure, solution.approach) = (mean, approach);
        solution.gap = field(gap);
        solution.displacement = field(indentation.into_iter().map(|d| -d).collect());
        solution
    }

    /// Solves the contact with the storage moduli; the loss moduli of `x` add to the gap.
    fn inner(
        &mut self,
        x: &[f64],
        (load, tolerance): (Load, f64),
        start: Option<&Solution>,
        watch: &mut dyn Watch,
    ) -> Result<(Solution, bool), Refusal> {
        self.effort.transform_pairs += 1.0;
        let added = Self::convolve((&self.sliding.transform, &mut self.workspace, &mut self.spectrum), &self.rest, x);
        let surface = self.sliding.contact.surface();
        let least = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, surface.clearance()[i] + added[i]))
        };
        let touch = reduce(added.len(), &least, &lower);
        let points = surface.grid().points();
        let depth = Array2::from_shape_vec(points, added.iter().map(|added| added - touch).collect());
        let contact = self.storing.with_indentation(&depth.expect("every field has the size of the grid"))?;
        let none = || Array2::zeros(points);
        let load = match load {
            Load::Approach(approach) if approach <= touch => {
                return Ok((contact.certify(&none(), Load::Approach(approach - touch))?, false));
            }
            Load::Approach(approach) => Load::Approach(approach - touch),
            load => load,
        };
        let left = self.budget.max_iterations.saturating_sub(self.effort.iterations).max(1);
        let budget = Budget { tolerance, max_iterations: left };
        let start = start.filter(|start| start.mean_pressure > 0.0);
        let (solution, is_interrupted) = match contact.equilibrate(load.into(), Solver::Auto, &budget, start, watch) {
            Ok(solution) => (solution, false),
            Err(SolveError::Refused(refusal)) => return Err(refusal),
            Err(SolveError::Interrupted { state }) => (*state, true),
            // The certificate of the complete problem decides.
            Err(SolveError::NotConverged { state, .. } | SolveError::Detached { state, .. }) => (*state, false),
        };
        self.effort.iterations += solution.effort.iterations;
        self.effort.transform_pairs += solution.effort.transform_pairs;
        Ok((solution, is_interrupted))
    }

    fn run(
        &mut self,
        load: Load,
        start: Option<&SlidingState>,
        watch: &mut dyn Watch,
    ) -> Result<(Solution, Ending), Refusal> {
        let tolerance = self.budget.tolerance;
        let mut x = match start {
            Some(start) => self.image(&contiguous(&start.solution.pressure)),
            None => vec![0.0; self.sliding.grid().len()],
        };
        let mut warm = start.map(|start| start.solution.clone());
        let mut mixing = Anderson::new(DEPTH);
        // An elastic contact needs a single solve.
        let is_elastic = self.rest.iter().all(|rest| *rest == Complex64::ZERO);
        let mut inner =
            if is_elastic { INNER_TOLERANCE_FACTOR * tolerance } else { FIRST_INNER_TOLERANCE.max(tolerance) };
        let mut best: Option<Solution> = None;
        // Image with the smallest difference from its argument so far, and this difference.
        let mut safe: Option<(Vec<f64>, f64)> = None;
        let (mut halved, mut since) = (f64::INFINITY, 0);
        loop {
            let (solution, is_interrupted) = self.inner(&x, (load, inner), warm.as_ref(), watch)?;
            let image = self.image(&contiguous(&solution.pressure));
            let certified = self.certify(solution, load);
            let (worst, effort) = (certified.residual.worst(), self.effort);
            warm = Some(certified.clone());
            if best.as_ref().is_none_or(|best| worst < best.residual.worst()) {
                best = Some(certified);
            }
            let mut reached = best.clone().ok_or(Refusal::OtherKind)?;
            reached.effort = effort;
            if is_interrupted {
                return Ok((reached, Ending::Interrupted));
            }
            if reached.residual.worst() <= tolerance {
                return Ok((reached, Ending::Converged));
            }
            if self.effort.iterations >= self.budget.max_iterations {
                return Ok((reached, Ending::GaveUp(Why::Iterations)));
            }
            since += 1;
            if worst <= 0.5 * halved {
                (halved, since) = (worst, 0);
            } else if since > STEPS_TO_HALVE {
                return Ok((reached, Ending::GaveUp(Why::Certificate)));
            }
            inner = (INNER_TOLERANCE_FACTOR * worst)
                .clamp(INNER_TOLERANCE_FACTOR * tolerance, FIRST_INNER_TOLERANCE.max(tolerance));
            let apart: f64 = gfmd_vector::sum(x.len(), &|range| range.map(|i| (image[i] - x[i]).powi(2)).sum());
            match &safe {
                // The mixed step is worse than the last image; restart from that image with a plain step.
                Some((image, least)) if apart > *least => {
                    x.copy_from_slice(image);
                    mixing = Anderson::new(DEPTH);
                    safe = None;
                }
                _ => {
                    mixing.advance(&mut x, &image);
                    safe = Some((image, apart));
                }
            }
        }
    }
}

impl Solved for SlidingState {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.solution
    }
}
