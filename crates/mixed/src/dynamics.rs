//! Damped dynamics for the free displacement: the surface layer moves under the given traction and its elastic force
//! −K u, with the held points fixed (theory.md, section 6).
//!
//! If the mean displacement of a component is zero at any load, the mean of its free points is constant. The mean of
//! their forces is therefore subtracted; it is the mean traction, which the stiffness does not determine.

use std::ops::Range;

use gfmd_relax::{
    Bounds, Budget, Damping, Ending, Factors, Fire, Landscape, Method, ModeDamped, RelaxError, Verlet, Watch, Why,
    damped_by_parts, relax_until,
};
use gfmd_vector::{add, for_each, pass, reduce, sum};

use crate::Prescribed;
use crate::surface::Surface;

/// Number of steps and the reason why they ended.
type Run = Result<(u64, Ending), RelaxError>;

/// Relaxes with the optimal damping and time step for the range of stiffnesses.
pub(crate) fn verlet(surface: &mut Surface, budget: &Budget, watch: &mut dyn Watch) -> Run {
    let [softest, stiffest] = surface.problem.response.stiffness_range();
    run(surface, || Verlet::optimal(softest, stiffest), budget, watch)
}

/// Relaxes with a time step relative to its stability limit 2/√k_max and a damping relative to a critical one.
pub(crate) fn damped(
    surface: &mut Surface,
    time_step: f64,
    damping: Factors,
    budget: &Budget,
    watch: &mut dyn Watch,
) -> Run {
    let response = &surface.problem.response;
    let [softest, stiffest] = response.stiffness_range();
    let dt = Damping::time_step(time_step, stiffest)?;
    match damping {
        Factors::Softest(factor) => {
            let damping = Damping::times_critical(factor, softest, stiffest, dt)?;
            run(surface, || Verlet::new(damping, stiffest), budget, watch)
        }
        Factors::Components(factors) => {
            let axes = response.components().axes();
            let of_components = |numbers: [f64; 3]| axes.iter().map(|axis| numbers[*axis]).collect::<Vec<_>>();
            let stiffnesses = of_components(response.uniform_stiffness());
            let method = damped_by_parts(&of_components(factors), &stiffnesses, stiffest, dt)?;
            run(surface, || Ok(method), budget, watch)
        }
    }
}

/// Relaxes with critical damping of every mode of the free surface.
///
/// Held points do not make the relaxation unstable: for a motion v, b = ⟨v, B v⟩ and k = τ ⟨v, K v⟩ satisfy
/// k < 2 (1 + b), since they do for each mode.
pub(crate) fn verlet_modes(
    surface: &mut Surface,
    time_step: Option<f64>,
    budget: &Budget,
    watch: &mut dyn Watch,
) -> Run {
    let response = std::sync::Arc::clone(&surface.problem.response);
    let [softest, stiffest] = response.stiffness_range();
    let uniform = response.uniform_stiffness();
    if let Some(&axis) = response.components().axes().iter().find(|axis| uniform[**axis].is_infinite()) {
        let (name, found) = ("the stiffness of a uniform displacement", uniform[axis]);
        return Err(RelaxError::Parameter { name, found, allowed: "finite, as of a compressible slab" });
    }
    let dt = match time_step {
        Some(time_step) => Damping::time_step(time_step, stiffest)?,
        None => Damping::optimal(softest, stiffest).tau.sqrt(),
    };
    let retained = response.stiffness().map(|_, matrix| matrix.function(|k| Damping::critical(k, dt).beta));
    let method = ModeDamped::critical(dt * dt, retained.in_place());
    let (steps, ending) = run(surface, || Ok(method), budget, watch)?;
    *surface.transforms.counter() += steps * response.components().len() as u64;
    Ok((steps, ending))
}

/// Relaxes by the fast inertial relaxation engine (FIRE) of 2006.
pub(crate) fn fire(surface: &mut Surface, budget: &Budget, watch: &mut dyn Watch) -> Run {
    let [_, stiffest] = surface.problem.response.stiffness_range();
    run(surface, || Ok(Fire::bitzek(Fire::largest_dt(stiffest))), budget, watch)
}

/// Relaxes until the displacement that follows from the force on the held points meets the tolerance. Small forces on
/// the free points alone do not suffice.
fn run<M: Method>(
    surface: &mut Surface,
    method: impl FnOnce() -> Result<M, RelaxError>,
    budget: &Budget,
    watch: &mut dyn Watch,
) -> Run {
    if surface.scale == 0.0 {
        return Ok((0, Ending::Converged));
    }
    let method = method()?;
    let mut layer = Layer::new(surface);
    let start = layer.start();
    let mut state = method.start(&mut layer, start)?;
    let ending = relax_until(
        &mut layer,
        &method,
        &mut state,
        budget,
        &mut |layer, state| {
            layer.take_traction(&state.force);
            layer.surface.residual()
        },
        watch,
    )?;
    if ending == Ending::Converged {
        return Ok((state.step, ending));
    }
    layer.take_traction(&state.force);
    let is_good = matches!(ending, Ending::GaveUp(Why::Iterations)) && layer.surface.residual() <= budget.tolerance;
    Ok((state.step, if is_good { Ending::Converged } else { ending }))
}

/// Surface as a layer of moving points.
struct Layer<'s, 'p> {
    surface: &'s mut Surface<'p>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// Number of free points of each component with zero mean at any load; `None` for the other components.
    floating: Vec<Option<f64>>,
}

impl<'s, 'p> Layer<'s, 'p> {
    fn new(surface: &'s mut Surface<'p>) -> Self {
        let problem = surface.problem;
        let prescribed = &problem.prescribed;
        let bound = |open: f64| {
            let entries = prescribed.held.iter().zip(&prescribed.values);
            entries.map(|(held, value)| if *held { *value } else { open }).collect()
        };
        let free = |held: &[bool]| held.iter().filter(|held| !**held).count() as f64;
        let by_component = prescribed.held.chunks_exact(problem.response.grid().len()).enumerate();
        let floating = by_component.map(|(c, held)| problem.floats(c).then(|| free(held))).collect();
        Self { surface, lower: bound(f64::NEG_INFINITY), upper: bound(f64::INFINITY), floating }
    }

    fn points(&self) -> usize {
        self.surface.problem.response.grid().len()
    }

    /// Returns the displacement at the start: constant on the free points, with the required mean of each component.
    fn start(&self) -> Vec<f64> {
        let Prescribed { held, values, .. } = &self.surface.problem.prescribed;
        let mut u = vec![0.0; self.len()];
        for ((c, u), free) in u.chunks_exact_mut(self.points()).enumerate().zip(&self.floating) {
            let Some(free) = free else { continue };
            let from = c * u.len();
            let of_held = |i: usize| if held[from + i] { values[from + i] } else { 0.0 };
            u.fill(-sum(u.len(), &|range| range.map(of_held).sum()) / free);
        }
        u
    }

    /// Takes the traction that keeps the held points in place and computes its displacement.
    fn take_traction(&mut self, force: &[f64]) {
        let held = &self.surface.problem.prescribed.held;
        for_each([&mut self.surface.traction[..]], &|start, [traction]| {
            for ((t, held), f) in traction.iter_mut().zip(&held[start..]).zip(&force[start..]) {
                if *held {
                    *t = -f;
                }
            }
        });
        self.surface.certify();
    }
}

impl Landscape for Layer<'_, '_> {
    fn len(&self) -> usize {
        self.lower.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.surface.transforms.stiffness(u, force);
        let Prescribed { held, values, .. } = &self.surface.problem.prescribed;
        let points = self.points();
        let mut energy = 0.0;
        for ((c, force), free) in force.chunks_exact_mut(points).enumerate().zip(&self.floating) {
            let [stored, pull] = pass(
                [&mut *force],
                &|start, [force]| {
                    let from = c * points + start;
                    let known = held[from..].iter().zip(&values[from..]);
                    let mut sums = [0.0; 2];
                    for ((f, u), (held, value)) in force.iter_mut().zip(&u[from..]).zip(known) {
                        let free = f64::from(u8::from(!held));
                        let given = free * value;
                        let elastic = std::mem::replace(f, given - *f);
                        sums = add(sums, [u * (0.5 * elastic - given), free * *f]);
                    }
                    sums
                },
                &add,
            );
            energy += stored;
            if let Some(free) = free {
                let mean = pull / free;
                for_each([force], &|_, [force]| force.iter_mut().for_each(|f| *f -= mean));
            }
        }
        energy
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Between { lower: &self.lower, upper: &self.upper }
    }

    /// Returns the largest force on a free point, divided by the largest traction.
    fn residual(&self, _: &[f64], force: &[f64]) -> f64 {
        let prescribed = &self.surface.problem.prescribed;
        let leaf = |range: Range<usize>| {
            range.fold([0.0; 2], |[free, scale], i| match (prescribed.held[i], force[i].abs()) {
                (true, f) => [free, larger(scale, f)],
                (false, f) => [larger(free, f), larger(scale, prescribed.values[i].abs())],
            })
        };
        let merge = |a: [f64; 2], b: [f64; 2]| [larger(a[0], b[0]), larger(a[1], b[1])];
        let [free, scale] = reduce(force.len(), &leaf, &merge);
        if free == 0.0 { 0.0 } else { free / scale }
    }
}

/// Returns the larger number; NaN if either is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}
