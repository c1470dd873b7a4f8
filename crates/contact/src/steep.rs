//! Contact with finite slopes: the kinematics of the surfaces is exact, and the body linearly elastic (theory.md,
//! section 7.4).

mod stiffness;

use std::sync::Arc;

use gfmd_field::{Grid, ShapeError, Share, Spline};
use gfmd_green::Body;
use gfmd_measure::Scales;
use gfmd_relax::{Anderson, Budget, Divergence, Ending, Progress, Variables as _, Visit, Watch, Why, worst};
use gfmd_response::{FullResponse, FullTransforms, NormalResponse};
use gfmd_vector::{contiguous, for_each, with_contiguous};
use ndarray::{Array2, ArrayRef2};

use crate::solution::{Conditions, field};
use crate::{
    Contact, Drive, Effort, Equilibrium, Fields as _, Hardness, Heights, Load, Refusal, Resumable, RigidSurface,
    Solution, SolveError, Solved, Solver, Units, judge,
};

/// Rigid rough surface above an elastic one, without friction or adhesion, with slopes that are not small. A point x of
/// the body meets the height at x + u_x, and the traction −p n acts along the normal (−∇h, 1) of the rigid surface,
/// which is fixed laterally. p is the normal force per area of the undeformed surface. Between the points the heights
/// follow a [`Spline`].
///
/// The body stays linearly elastic: terms of the order of the strain relative to one, which depend on its material, are
/// neglected.
#[derive(Clone, Debug)]
pub struct SteepContact {
    normal: Arc<NormalResponse>,
    full: Arc<FullResponse>,
    surface: Arc<RigidSurface>,
    clearance: Spline,
    hardness: Option<Hardness>,
}

/// Equilibrated contact with finite slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct SteepSolution {
    /// Pressure, gap, u_z, residuals and effort. The gap is vertical, at the displaced points.
    pub normal: Solution,
    /// u_x and u_y, or u_x on a line, in length.
    pub lateral: Vec<Array2<f64>>,
    /// Mean traction of the rigid surface on the body along x and y, in stress. It holds the rigid surface in its
    /// place.
    pub mean_shear: [f64; 2],
    /// Last change of u_x and u_y as they are made consistent with the pressure, divided by the length scale of the
    /// other residuals.
    pub lateral_residual: f64,
    scales: Scales,
    elastic_energy: f64,
}

/// Largest number of steps that make the lateral displacement consistent with a pressure.
const STEPS: usize = 200;

impl SteepSolution {
    /// Computes the contact area projected onto the plane of the rigid surface, divided by the area of the cell. Points
    /// in contact have moved, and the area between them has changed.
    ///
    /// # Errors
    /// A lateral displacement that differs in size from the grid.
    pub fn projected_area(&self) -> Result<f64, ShapeError> {
        let (grid, share) = (self.normal.grid(), self.normal.share());
        let splines = self.lateral.iter().map(|u| Spline::distributed(grid, share, &contiguous(u)));
        let splines = splines.collect::<Result<Vec<Spline>, ShapeError>>()?;
        let stretched = |point: [usize; 2]| {
            let slopes = |axis: usize| splines.get(axis).map_or([0.0; 2], |u| u.near(point, [0.0; 2]).1);
            let ([xx, xy], [yx, yy]) = (slopes(0), slopes(1));
            (1.0 + xx) * (1.0 + yy) - xy * yx
        };
        let (pressure, first, [_, ny]) = (contiguous(&self.normal.pressure), share.own().start, grid.points());
        let of = |k: usize| if pressure[k] > 0.0 { stretched([(first + k) / ny, (first + k) % ny]) } else { 0.0 };
        Ok(share.sum(&|range| range.map(of).sum()) / grid.len() as f64)
    }
}

/// Number of previous steps used by each step.
const DEPTH: usize = 4;

/// Precision of the lateral displacement, relative to the length scale, divided by the residual so far.
const PRECISION: f64 = 0.01;

/// Changes of the lateral displacement relative to the length scale: below `ROUNDING_OF_CHANGE`, rounding errors
/// may keep it from settling; above `UNSETTLED_CHANGE`, it does not settle.
const ROUNDING_OF_CHANGE: f64 = 1e-12;
const UNSETTLED_CHANGE: f64 = 1e3;

/// Largest ratio of residuals of successive solves that counts as convergence, and number of solves that may exceed it.
const SLOW: (f64, usize) = (0.9, 8);

/// Displacement under a pressure, with the clearance of the displaced points.
struct Settled {
    /// Tractions t_x, t_y, t_z, component after component.
    traction: Vec<f64>,
    /// u_x, u_y, u_z.
    displacement: Vec<f64>,
    clearance: Vec<f64>,
    /// Last change of a lateral displacement, in length.
    change: f64,
}

impl SteepContact {
    /// Makes the contact of `body` with a rigid profile `heights` on `grid`, in length, with peaks towards the body. A
    /// constant in the heights has no effect.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn new<'a>(body: &Body, grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        Self::distributed(&grid.whole(), body, grid, heights)
    }

    /// Makes the contact as [`new`](Self::new), solved by the processes of a [`share`](Contact::share). Each process
    /// gives and gets only its rows of all fields, and all make the same calls. Since points move sideways, each has
    /// the spline of all heights. Fields and numbers have the bits of a single process.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), on all processes.
    pub fn distributed<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        let surface = RigidSurface::distributed(share, grid, heights)?;
        if surface.rms_height() == 0.0 {
            return Err(Refusal::Flat);
        }
        let clearance = Spline::distributed(grid, share, &surface.clearance().to_vec())?;
        let normal = NormalResponse::distributed(*grid, body, share).into();
        let full = FullResponse::distributed(*grid, body, share).into();
        Ok(Self { normal, full, surface: surface.into(), clearance, hardness: None })
    }

    fn share(&self) -> &Share {
        self.surface.share()
    }

    /// Returns the scalar product of vectors of some components over all processes.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let points = self.surface.clearance().len();
        let of =
            |range: std::ops::Range<usize>| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| a * b).sum::<f64>();
        self.share().reduce_components(a.len().min(b.len()) / points, &of, &|a, b| a + b)
    }

    /// Sets the `hardness`, the largest pressure normal to the surfaces that they can carry, in stress: a number or a
    /// field `[x, y]`.
    ///
    /// # Errors
    /// A hardness that is not positive and finite, or differs in shape from the heights.
    pub fn with_hardness(self, hardness: impl Into<Hardness>) -> Result<Self, Refusal> {
        let hardness = hardness.into();
        hardness.in_units(&self.surface, &Units::ONE)?;
        Ok(Self { hardness: Some(hardness), ..self })
    }

    /// Returns the contact with small slopes on these heights, with the same hardness.
    fn flat(&self, heights: &ArrayRef2<f64>) -> Result<Contact, Refusal> {
        let contact = Contact::with_response(Arc::clone(&self.normal), heights)?;
        match &self.hardness {
            Some(hardness) => contact.with_hardness(hardness.clone()),
            None => Ok(contact),
        }
    }

    /// Returns the rigid surface.
    pub fn surface(&self) -> &RigidSurface {
        &self.surface
    }

    /// Computes the state of `pressure` under `load` with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid.
    pub fn certify(&self, pressure: &ArrayRef2<f64>, load: Load) -> Result<SteepSolution, Refusal> {
        let (found, expected) = (pressure.dim().into(), self.surface.shape());
        if self.share().any(found != expected) {
            return Err(Refusal::Shape { found, expected });
        }
        Ok(self.state(pressure.iter().copied().collect(), load, 0.0)?.0)
    }

    /// Computes the displacement under a pressure. The lateral displacement, which also changes the traction, is found
    /// to `precision` times the length scale, at most `length_scale`, or as exactly as rounding allows.
    fn settle(
        &self,
        pressure: &[f64],
        (length_scale, precision): (f64, f64),
        transforms: &mut FullTransforms,
    ) -> Settled {
        let points = pressure.len();
        let axes = self.full.components().len() - 1;
        let ([_, ny], first) = (self.surface.grid().points(), self.share().own().start);
        let mut traction = vec![0.0; (axes + 1) * points];
        traction[axes * points..].iter_mut().zip(pressure).for_each(|(t, p)| *t = -p);
        let mut displacement = vec![0.0; (axes + 1) * points];
        let mut lateral = vec![0.0; axes * points];
        // Clearance that each point meets, with its slopes.
        let mut met = vec![(0.0, [0.0; 2]); points];
        let (mut change, mut mixing) = (f64::INFINITY, Anderson::new(DEPTH));
        for _ in 0..STEPS {
            for_each(&mut met[..], &|start, met: &mut [_]| {
                for (i, met) in (start..).zip(met) {
                    // A profile does not move along y.
                    let offset = [0, 1].map(|axis| lateral.get(axis * points + i).copied().unwrap_or(0.0));
                    *met = self.clearance.near([(first + i) / ny, (first + i) % ny], offset);
                }
            });
            for (axis, traction) in traction[..axes * points].chunks_exact_mut(points).enumerate() {
                let met = met.iter().zip(pressure);
                traction.iter_mut().zip(met).for_each(|(t, ((_, slopes), p))| *t = p * slopes[axis]);
            }
            transforms.compliance(&traction, &mut displacement);
            let last = change;
            let own = worst(displacement.iter().zip(&lateral).map(|(new, old)| (new - old).abs()));
            let wider = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [low.min(a), high.max(b)];
            let [lowest, highest] = displacement[axes * points..].iter().fold([0.0; 2], |ends, u| wider(ends, [*u; 2]));
            let all = self.share().each([own, lowest, highest]);
            change = worst(all.iter().map(|[change, ..]| *change));
            let ends = all.into_iter().map(|[_, low, high]| [low, high]);
            let [lowest, highest] = ends.fold([0.0; 2], wider);
            let relative = change / RigidSurface::finer_scale(length_scale, highest - lowest);
            let is_rounding = relative <= ROUNDING_OF_CHANGE && change >= 0.5 * last;
            let settles = relative <= UNSETTLED_CHANGE;
            if relative <= precision || is_rounding || !settles {
                break;
            }
            mixing.advance_by(&mut lateral, &displacement[..axes * points], &|a, b| self.product(a, b));
        }
        Settled { traction, displacement, clearance: met.into_iter().map(|(clearance, _)| clearance).collect(), change }
    }

    /// Computes the state of `pressure` under `load`. Also returns the clearance of the displaced points.
    ///
    /// # Errors
    /// A displacement that is not finite.
    fn state(&self, pressure: Vec<f64>, load: Load, precision: f64) -> Result<(SteepSolution, Vec<f64>), Refusal> {
        let points = pressure.len();
        let mut transforms = FullTransforms::of(&self.full);
        let length_scale = self.surface.length_scale(load);
        let Settled { traction, mut displacement, clearance, change } =
            self.settle(&pressure, (length_scale, precision), &mut transforms);
        let normal = displacement.split_off(displacement.len() - points);
        let (share, all) = (self.share(), self.share().total() as f64);
        let work = self.product(&traction, &displacement) + self.product(&traction[displacement.len()..], &normal);
        let elastic_energy = 0.5 * work / all;
        let mean = |axis: usize| share.total_of(&traction[axis * points..][..points]) / all;
        let mean_shear = [0, 1].map(|axis| if axis * points < displacement.len() { mean(axis) } else { 0.0 });
        let lowest = lowest_of(share, &clearance);
        let heights = field(&self.surface, clearance.iter().map(|c| -c).collect()).into_shared();
        let surface = Arc::new(RigidSurface::distributed(share, self.surface.grid(), &heights)?);
        let displaced = match load {
            Load::Approach(approach) => Load::Approach(approach - lowest),
            load => load,
        };
        let modulus = self.full.contact_modulus();
        let hardness =
            self.hardness.as_ref().map(|hardness| hardness.in_units(&self.surface, &Units::ONE)).transpose()?;
        let conditions =
            Conditions { sinking: 0.0, load: displaced, length_scale, extent: 0.0, hardness: hardness.as_ref() };
        let mut solution = Solution::of(&surface, modulus, pressure, normal, conditions);
        solution.approach += lowest;
        solution.effort.transform_pairs = transforms.pairs();
        let lateral = displacement.chunks_exact(points).map(|u| field(&self.surface, u.to_vec())).collect();
        let lateral_residual = change / solution.length_scale;
        let state = SteepSolution {
            normal: solution,
            lateral,
            mean_shear,
            lateral_residual,
            scales: Scales { contact_modulus: modulus, rms_gradient: self.surface.rms_gradient() },
            elastic_energy,
        };
        Ok((state, clearance))
    }
}

/// Returns the lowest value of all processes.
fn lowest_of(share: &Share, own: &[f64]) -> f64 {
    let lowest = own.iter().copied().fold(f64::INFINITY, f64::min);
    share.each(lowest).into_iter().fold(f64::INFINITY, f64::min)
}

/// Successive contacts with small slopes, each with the clearance and the displacement left by the last one.
struct Search<'a> {
    contact: &'a SteepContact,
    load: Load,
    budget: &'a Budget,
    effort: Effort,
    /// Rigid surface of the next contact, and solution of the last one.
    heights: Array2<f64>,
    small: Option<Solution>,
    mixing: Anderson,
}

impl Search<'_> {
    /// Solves the contact with small slopes on the present heights to `tolerance`.
    fn solve(&mut self, tolerance: f64, watch: &mut dyn Watch) -> Result<Ending, Refusal> {
        let Self { contact, load, budget, effort, heights, small, .. } = self;
        let flat = contact.flat(heights)?;
        let lowest = lowest_of(contact.share(), &heights.iter().map(|height| -height).collect::<Vec<f64>>());
        let load = match load {
            Load::Approach(approach) => Load::Approach(*approach - lowest),
            load => *load,
        };
        let mut starts = [small.take(), None].into_iter();
        let (solution, ending) = loop {
            let start = starts.next().flatten();
            let before = effort.iterations;
            let mut count = |now: &Progress| watch.see(&Progress { iteration: before + now.iteration, ..*now });
            let left = budget.max_iterations.saturating_sub(before).max(1);
            let press = flat.press(load).tolerance(tolerance).max_iterations(left);
            let (solution, ending) = match press.watch(&mut count).starting_from(start.as_ref()).solve() {
                Ok(solution) => (solution, Ending::Converged),
                Err(SolveError::Refused(refusal)) => return Err(refusal),
                Err(SolveError::Interrupted { state }) => (*state, Ending::Interrupted),
                Err(SolveError::NotConverged { state, why, .. }) => (*state, Ending::GaveUp(why)),
                Err(SolveError::Detached { state, .. }) => (*state, Ending::GaveUp(Why::NoDescent)),
            };
            // Where all points carry the hardness, a search may not leave the points of the last one.
            if start.is_none() || contact.hardness.is_none() || ending != Ending::GaveUp(Why::NoDescent) {
                break (solution, ending);
            }
            effort.add(solution.effort);
        };
        effort.add(solution.effort);
        *small = Some(solution);
        Ok(ending)
    }

    /// Computes the state of the last pressure, and the heights of the next contact, which has the gap of this state at
    /// the same pressure. Returns `None` without a pressure.
    ///
    /// # Errors
    /// A displacement that is not finite.
    fn state(&mut self, precision: f64) -> Result<Option<SteepSolution>, Refusal> {
        let Self { contact, load, effort, heights, small, mixing, .. } = self;
        let Some(small) = small.as_ref() else { return Ok(None) };
        let (mut state, clearance) = contact.state(small.pressure.iter().copied().collect(), *load, precision)?;
        effort.add(state.normal.effort);
        state.normal.effort = *effort;
        let lifted = state.normal.displacement.iter().zip(&small.displacement).zip(clearance);
        let image: Vec<f64> = lifted.map(|((steep, small), clearance)| steep - small - clearance).collect();
        let product = |a: &[f64], b: &[f64]| contact.product(a, b);
        with_contiguous(heights, |heights| mixing.advance_by(heights, &image, &product));
        Ok(Some(state))
    }
}

/// Returns the reason why a search ends when the contact of a displaced surface is refused for too large slopes.
fn why(refusal: &Refusal) -> Why {
    match refusal {
        Refusal::Height { .. } | Refusal::RmsHeight { .. } | Refusal::UnitOutOfRange { .. } => {
            Why::Diverged(Divergence::NotFinite)
        }
        _ => Why::Displaced,
    }
}

impl Equilibrium for SteepContact {
    type State = SteepSolution;

    fn solvers(&self) -> &'static [Solver] {
        &[Solver::Auto]
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        match drive.load {
            Load::MeanPressure(found) if found > 0.0 => match &self.hardness {
                Some(hardness) => hardness.check_mean_over(&self.surface, found),
                None => Ok(()),
            },
            Load::MeanPressure(found) => Err(Refusal::MeanPressure { found }),
            Load::Approach(found) if found > 0.0 => Ok(()),
            Load::Approach(found) => Err(Refusal::Approach { found, limit: None }),
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let [softest, _] = self.normal.stiffness_range();
        self.surface.check_resolution(drive.load, softest, tolerance)
    }

    /// Solves contacts with small slopes, one after the other, until one agrees with its own displacement. The search
    /// converges for moderate slopes, by about a factor of the slope from one contact to the next.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&SteepSolution>,
        watch: &mut dyn Watch,
    ) -> Result<SteepSolution, SolveError<SteepSolution>> {
        budget.check()?;
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        let heights = field(&self.surface, self.surface.clearance().iter().map(|c| -c).collect());
        let small = match start {
            Some(start) => {
                let flat = self.flat(&heights)?;
                Some(flat.certify(&start.normal.pressure, drive.load)?)
            }
            None => None,
        };
        let (effort, mixing) = (Effort::default(), Anderson::new(DEPTH));
        let mut search = Search { contact: self, load: drive.load, budget, effort, heights, small, mixing };
        let mut state = search.state(1e-3)?;
        let (mut residual, mut slow) = (1.0_f64, 0);
        loop {
            let tolerance = (0.1 * residual).min(1e-3).max(0.3 * budget.tolerance);
            let solved = search.solve(tolerance, watch);
            let next = solved.and_then(|ending| Ok((ending, search.state(PRECISION * residual)?)));
            let (ending, mut reached) = match (next, state) {
                (Ok((ending, Some(reached))), _) => (ending, reached),
                (Ok((_, None)), _) => return Err(Refusal::StartApart.into()),
                (Err(refusal), Some(state)) => return judge(state, Ending::GaveUp(why(&refusal)), budget.tolerance),
                (Err(refusal), None) => return Err(refusal.into()),
            };
            let ending = match ending {
                Ending::Converged if reached.worst() <= budget.tolerance => Some(Ending::Converged),
                Ending::Converged if reached.worst().is_nan() => {
                    Some(Ending::GaveUp(Why::Diverged(Divergence::NotFinite)))
                }
                Ending::Converged if slow == SLOW.1 => Some(Ending::GaveUp(Why::Circles)),
                Ending::Converged => {
                    let now = Progress { iteration: search.effort.iterations, residual: reached.worst() };
                    self.share().any(watch.see(&now).is_break()).then_some(Ending::Interrupted)
                }
                ending => Some(ending),
            };
            if let Some(ending) = ending {
                let pressure = reached.normal.pressure.iter().copied().collect();
                reached = match self.state(pressure, drive.load, 0.0) {
                    Ok((certified, _)) => certified,
                    Err(refusal) => return judge(reached, Ending::GaveUp(why(&refusal)), budget.tolerance),
                };
                search.effort.add(reached.normal.effort);
                reached.normal.effort = search.effort;
                if ending != Ending::Converged || reached.worst() <= budget.tolerance {
                    return judge(reached, ending, budget.tolerance);
                }
            }
            let now = reached.worst();
            slow += usize::from(now > SLOW.0 * residual);
            residual = residual.min(now);
            state = Some(reached);
        }
    }
}

/// The state follows from its pressure.
impl Resumable for SteepContact {
    fn keep(&self, state: &mut SteepSolution, visitor: &mut dyn Visit) {
        with_contiguous(&mut state.normal.pressure, |pressure| visitor.rows(self.share(), pressure));
        state.normal.effort.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<SteepSolution, Refusal> {
        self.check(drive)?;
        let mut pressure = vec![0.0; self.surface.clearance().len()];
        visitor.rows(self.share(), &mut pressure);
        let (mut state, _) = self.state(pressure, drive.load, 0.0)?;
        state.normal.effort.visit(visitor);
        Ok(state)
    }
}

impl Solved for SteepSolution {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.normal
    }

    fn further_residual(&self) -> Option<(&'static str, f64)> {
        Some(("lateral_displacement", self.lateral_residual))
    }

    fn stored_energy(&self) -> Option<f64> {
        Some(self.elastic_energy)
    }

    fn reduced_by(&self) -> Option<Scales> {
        Some(self.scales)
    }
}
