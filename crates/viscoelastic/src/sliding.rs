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

/// A rigid rough surface that slides steadily over a viscoelastic body, with a hard wall and without friction of the
/// interface (theory.md, section 7.8).
///
/// All fields move with the surface, and a wave q of them deforms the body at the frequency −q·v: its stiffness is
/// complex. The compliance is then positive definite, but not symmetric, and the contact under any load is unique.
#[derive(Clone, Debug)]
pub struct SlidingContact {
    /// The contact with the long-term moduli.
    contact: Contact,
    spectrum: Arc<Spectrum>,
    /// The long-term stiffness of each mode, stress/length; infinite for a uniform one that the body does not have.
    stiffness: Arc<Vec<f64>>,
    /// The spectrum of the heights, less the uniform mode.
    heights: Arc<Vec<Complex64>>,
    transform: Arc<Transform>,
}

/// A steady state of sliding.
#[derive(Clone, Debug)]
pub struct SlidingState {
    /// Pressure, displacement, gap and residuals.
    pub solution: Solution,
    /// Power lost in the body, per area, in stress × velocity.
    pub dissipated_power: f64,
    /// Coefficient of friction by hysteresis: `dissipated_power` over velocity and mean pressure.
    pub friction: f64,
    /// Friction by the pressure on the slopes of the surface. The difference from `friction` is an error of the grid.
    pub friction_slope: f64,
}

/// Persson's theory of the friction by hysteresis, for the heights and the body of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Persson {
    /// Coefficient of friction.
    pub friction: f64,
    /// Contact area over the whole area.
    pub area_fraction: f64,
}

/// Error: a contact that does not slide steadily.
#[derive(Debug, thiserror::Error)]
pub enum SlidingError {
    /// A patch that does not repeat.
    #[error("the boundary is free; it must be periodic for steady sliding")]
    Free,
    /// A largest pressure.
    #[error("a hardness is given; it must be left out for steady sliding")]
    Hardness,
    /// A body whose relaxation is not known.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// The number of images that a step mixes.
const DEPTH: usize = 8;
/// The tolerance of the first inner contact, and the largest of all.
const FIRST: f64 = 1e-3;
/// The tolerance of an inner contact over the last certified residual, and the least over the tolerance.
const INNER: f64 = 0.1;
/// The number of steps in which the residual must have halved.
const PATIENCE: u32 = 200;

/// The stiffnesses of all modes at one velocity.
struct Moving {
    /// S(q) over the long-term stiffness.
    modulus: Vec<Complex64>,
    /// q·v, without components at Nyquist.
    rate: Vec<f64>,
}

impl SlidingContact {
    /// The sliding contact of a `body`, whose long-term moduli are those of `contact`, and which relaxes by a Prony
    /// series.
    ///
    /// # Errors
    /// Free boundaries, a hardness; a body for which the relaxation of the shear modulus alone is not known.
    pub fn new(contact: Contact, body: &Body, prony: &Prony, relaxes: Relaxes) -> Result<Self, SlidingError> {
        let spectrum = Spectrum::new(body, contact.surface().grid(), false, prony, relaxes)?;
        Self::of(contact, body, spectrum)
    }

    /// The sliding contact of an elastic `body`, that of `contact`: a static contact at any velocity, without friction.
    ///
    /// # Errors
    /// Free boundaries, a hardness.
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

    /// The contact with the long-term moduli, that of very slow sliding.
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

    /// The steady state under a `load` at a `velocity`, from that at another load or velocity, if there is one.
    ///
    /// The contact is solved with the storage moduli by the solver of elastic contacts, and what the loss moduli add to
    /// the gap is taken from the last pressure, again and again. This converges for every material, by the sine of the
    /// largest loss angle in each step; mixing the last images makes it faster.
    ///
    /// # Errors
    /// An invalid load; else an error that contains the state reached.
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

    /// The steady state of a `pressure` under a `load` at a `velocity`, with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure of another shape than the grid.
    pub fn certify(&self, velocity: &Velocity, pressure: &Array2<f64>, load: Load) -> Result<SlidingState, Refusal> {
        let (moving, solution) = (self.at(velocity), self.contact.certify(pressure, load)?);
        let certified = Search::new(self, &moving, Budget::default()).certify(solution, load);
        Ok(self.with_friction(velocity, &moving, certified))
    }

    /// The state of a solution, with its friction.
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

    /// Persson's theory at a `velocity` and a mean pressure, with all waves of the heights (theory.md, section 7.8).
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
            // Waves of one length count together.
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

/// The relative difference of wavenumbers that rounding makes.
const EQUAL: f64 = 1e-9;

/// A search for a steady state.
struct Search<'a> {
    sliding: &'a SlidingContact,
    budget: Budget,
    /// The contact with the storage moduli, of the undeformed surface.
    storing: Contact,
    /// √A of each mode, with A = 1/Re S.
    root: Vec<f64>,
    /// (G − A)/√A.
    rest: Vec<Complex64>,
    /// G.
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

    /// F⁻¹\[k F\[field\]\].
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

    /// √A p of a pressure.
    fn image(&mut self, pressure: &[f64]) -> Vec<f64> {
        self.effort.transform_pairs += 1.0;
        Self::convolve((&self.sliding.transform, &mut self.workspace, &mut self.spectrum), &self.root, pressure)
    }

    /// The certified state of a pressure, from fresh transforms.
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

    /// The contact with the storage moduli and what the loss moduli of `x` add to the gap.
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
        let contact = self.storing.indented(&depth.expect("every field has the size of the grid"))?;
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
            // The certificate of the whole decides.
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
        // An elastic contact is solved at once.
        let is_elastic = self.rest.iter().all(|rest| *rest == Complex64::ZERO);
        let mut inner = if is_elastic { INNER * tolerance } else { FIRST.max(tolerance) };
        let mut best: Option<Solution> = None;
        // The image with the least residual so far, and this residual.
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
            } else if since > PATIENCE {
                return Ok((reached, Ending::GaveUp(Why::Certificate)));
            }
            inner = (INNER * worst).clamp(INNER * tolerance, FIRST.max(tolerance));
            let apart: f64 = gfmd_vector::sum(x.len(), &|range| range.map(|i| (image[i] - x[i]).powi(2)).sum());
            match &safe {
                // A mixture that is worse than the last image: the plain step from there is not.
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
