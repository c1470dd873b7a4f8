//! The contact problem in terms of the surface displacement, equilibrated by damped dynamics: the surface layer moves
//! under its own elastic force −K u and stops at the rigid wall, u ≤ clearance − approach (theory.md, section 6).
//!
//! Under a prescribed mean pressure p̄ the rigid surface stays at first touch and the body is pushed against it: the
//! uniform mode costs no energy and feels the force p̄, so that at rest the wall carries exactly p̄. Under a prescribed
//! approach the wall is in its place and the uniform mode has the stiffness of the slab; where the body has none to
//! give (half-space, incompressible slab) the load that gives the asked approach is searched for.
//!
//! With the augmented Lagrangian the wall acts by a force instead of clipping, so that the inertia may follow the
//! stiffness (theory.md, section 6.3).

use std::borrow::Cow;
use std::ops::ControlFlow;

use gfmd_relax::{
    AugmentedLagrangian, Bounds, Fire, Landscape, Method, Nesterov, Outcome, Proximal, RelaxError, State, Stop, Verlet,
    relax,
};
use gfmd_response::NormalResponse;
use gfmd_vector::{add, for_each, pass};

use crate::problem::{End, Ended, Transforms};
use crate::{Contact, ContactError, Control, Progress, Settings, Solver, Watch};

/// Time step of the original method over its stability limit 2/√k_max.
const SOURCE_TIME_STEP: f64 = 0.25;

/// A rough contact is about as stiff as its mean pressure over this many rms heights (Akarapu, Sharp and Robbins 2011;
/// Campañá, Persson and Müser 2011 find 0.4 to 0.5). Only sets the damping of the rigid motion, so only the speed.
pub(crate) const STIFFNESS_LENGTH: f64 = 0.45;

/// Length of a step of the augmented Lagrangian; 2 is the limit.
const RELAXATION: f64 = 1.2;

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
pub(crate) const FITS: &str = "every field of a contact problem has the size of its grid";

/// Steps that the set of touching points must have kept still (theory.md, section 6.6).
pub(crate) const SETTLED: u64 = 20;

pub(crate) fn solve(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    start: Option<Vec<f64>>,
    watch: Watch,
) -> Result<Ended, ContactError> {
    let mut spent = Spent { iterations: 0, singles: 0 };
    let (pressure, end) = match control {
        Control::Approach(approach) if contact.response.uniform_compliance() == 0.0 => {
            search_load(contact, approach, settings, start, &mut spent, watch)?
        }
        _ => equilibrate(contact, control, settings, start, &mut spent, watch)?,
    };
    Ok(Ended { pressure, iterations: spent.iterations, transform_pairs: spent.singles as f64 / 2.0, end })
}

/// Cost of all runs of one solve.
struct Spent {
    iterations: u64,
    singles: u64,
}

/// The elastic surface layer below a rigid wall.
struct Layer<'a> {
    response: &'a NormalResponse,
    stiffness: Cow<'a, [f64]>,
    wall: Cow<'a, [f64]>,
    /// Uniform force per area that pushes the body up.
    push: f64,
    force_scale: f64,
    length_scale: f64,
    transforms: Transforms,
}

impl Landscape for Layer<'_> {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.transforms.singles += 2;
        self.response.transform().convolve(&self.stiffness, u, force, &mut self.transforms.workspace).expect(FITS);
        pass(
            [force],
            &|start, [force]| {
                let mut energy = 0.0;
                for (f, u) in force.iter_mut().zip(&u[start..]) {
                    energy += u * (0.5 * *f - self.push);
                    *f = self.push - *f;
                }
                energy
            },
            &|a, b| a + b,
        )
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.force_scale, self.length_scale)
    }
}

impl<'a> Layer<'a> {
    fn new(contact: &'a Contact, control: Control) -> Self {
        let response = contact.response;
        let [softest, _] = response.stiffness_range();
        let (stiffness, wall, push, force_scale) = match control {
            Control::MeanPressure(mean) => {
                (Cow::from(response.stiffness()), Cow::from(&contact.wall.clearance), mean, mean)
            }
            Control::Approach(approach) => {
                let mut stiffness = response.stiffness().to_vec();
                stiffness[0] = 1.0 / response.uniform_compliance();
                let wall: Vec<f64> = contact.wall.clearance.iter().map(|c| c - approach).collect();
                (Cow::from(stiffness), Cow::from(wall), 0.0, softest * contact.wall.rms_height)
            }
        };
        let transforms = Transforms::new(response);
        Self { response, stiffness, wall, push, force_scale, length_scale: contact.wall.rms_height, transforms }
    }

    /// Stiffness of the softest motion and of the stiffest.
    fn band(&self) -> [f64; 2] {
        let [softest, stiffest] = self.response.stiffness_range();
        let rigid =
            if self.push > 0.0 { self.push / (STIFFNESS_LENGTH * self.length_scale) } else { self.stiffness[0] };
        [softest.min(rigid), stiffest.max(rigid)]
    }

    /// Where the surface is under `pressure`.
    fn displacement(&mut self, contact: &Contact, pressure: &[f64]) -> Vec<f64> {
        let mut u = vec![0.0; pressure.len()];
        self.transforms.singles += 2;
        let response = self.response;
        response
            .transform()
            .convolve(response.compliance(), pressure, &mut u, &mut self.transforms.workspace)
            .expect(FITS);
        let sums = gfmd_vector::reduce(
            u.len(),
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let touching = f64::from(pressure[i] > 0.0);
                    add(sums, [pressure[i], touching, touching * (contact.wall.clearance[i] + u[i])])
                })
            },
            &add,
        );
        // The rigid surface does not move under a prescribed load, the body does.
        let rise =
            if self.push > 0.0 { sums[2] / sums[1] } else { -response.uniform_compliance() * sums[0] / u.len() as f64 };
        u.iter_mut().for_each(|u| *u = rise - *u);
        u
    }

    /// Scaled so that the wall carries the prescribed load.
    fn carry(&self, mut pressure: Vec<f64>) -> Vec<f64> {
        let sum = gfmd_vector::sum(pressure.len(), &|range| pressure[range].iter().sum());
        if self.push > 0.0 && sum > 0.0 {
            let factor = self.push * pressure.len() as f64 / sum;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        pressure
    }
}

/// What a run needs to know of the layer, however the wall holds it.
trait Pressed<'a>: Landscape {
    fn layer(&mut self) -> &mut Layer<'a>;

    /// Where to start from, with a surface at `u` that exerts `pressure`.
    fn begin(&self, u: Vec<f64>, pressure: Option<&[f64]>) -> Vec<f64>;

    /// On the wall, free of what is left on the free points.
    fn pressure(&self, u: &[f64], force: &[f64]) -> Vec<f64>;
}

impl<'a> Pressed<'a> for Layer<'a> {
    fn layer(&mut self) -> &mut Layer<'a> {
        self
    }

    fn begin(&self, u: Vec<f64>, _: Option<&[f64]>) -> Vec<f64> {
        u
    }

    fn pressure(&self, u: &[f64], force: &[f64]) -> Vec<f64> {
        let touching = |i: usize| u[i] >= self.wall[i];
        self.carry((force.iter().enumerate()).map(|(i, f)| if touching(i) { f.max(0.0) } else { 0.0 }).collect())
    }
}

/// The layer together with springs of one stiffness ϱ at every point. The geometric mean of the softest and the stiffest
/// mode treats both alike: (k + ϱ)/k of the one is (k + ϱ)/ϱ of the other.
struct Sprung<'a> {
    layer: Layer<'a>,
    penalty: f64,
    /// 1/(k + ϱ).
    mobility: Vec<f64>,
    /// b + ϱ anchor.
    pull: Vec<f64>,
}

impl<'a> Sprung<'a> {
    fn new(layer: Layer<'a>) -> Self {
        let [softest, stiffest] = layer.response.stiffness_range();
        let penalty = (softest * stiffest).sqrt();
        let mobility = layer.stiffness.iter().map(|k| 1.0 / (k + penalty)).collect();
        let pull = vec![0.0; layer.len()];
        Self { layer, penalty, mobility, pull }
    }
}

impl Proximal for Sprung<'_> {
    fn len(&self) -> usize {
        self.layer.len()
    }

    fn bounds(&self) -> Bounds<'_> {
        self.layer.bounds()
    }

    fn penalty(&self) -> f64 {
        self.penalty
    }

    fn settle(&mut self, anchor: &[f64], u: &mut [f64]) {
        let Self { layer, penalty, mobility, pull } = self;
        let leaf = |start: usize, [pull]: [&mut [f64]; 1]| {
            pull.iter_mut().zip(&anchor[start..]).for_each(|(pull, anchor)| *pull = layer.push + *penalty * anchor);
        };
        for_each([pull], &leaf);
        layer.transforms.singles += 2;
        layer.response.transform().convolve(mobility, pull, u, &mut layer.transforms.workspace).expect(FITS);
    }

    fn residual(&self, mismatch: &[f64]) -> f64 {
        let largest = |range: std::ops::Range<usize>| mismatch[range].iter().fold(0, |m, x| x.abs().to_bits().max(m));
        // Bit patterns of positive numbers are ordered as the numbers are, and NaN comes last.
        f64::from_bits(gfmd_vector::reduce(mismatch.len(), &largest, &u64::max)) / self.layer.length_scale
    }
}

impl<'a> Pressed<'a> for AugmentedLagrangian<Sprung<'a>> {
    fn layer(&mut self) -> &mut Layer<'a> {
        &mut self.problem_mut().layer
    }

    /// The reaction λ makes the coordinate λ/ϱ larger than the displacement.
    fn begin(&self, mut u: Vec<f64>, pressure: Option<&[f64]>) -> Vec<f64> {
        let Sprung { layer, penalty, .. } = self.problem();
        match pressure {
            Some(pressure) => u.iter_mut().zip(pressure).for_each(|(u, p)| *u += p / penalty),
            None => u.iter_mut().for_each(|u| *u += layer.push / penalty),
        }
        u
    }

    fn pressure(&self, v: &[f64], _: &[f64]) -> Vec<f64> {
        self.problem().layer.carry(self.reaction(v))
    }
}

fn equilibrate(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    start: Option<Vec<f64>>,
    spent: &mut Spent,
    watch: Watch,
) -> Result<(Vec<f64>, End), ContactError> {
    let layer = Layer::new(contact, control);
    let [softest, stiffest] = layer.band();
    let unusable = |error: RelaxError| ContactError::Start { reason: error.to_string() };
    match settings.solver {
        Solver::Fire => {
            let method = Fire::bitzek(Fire::largest_dt(stiffest));
            run(contact, control, settings, layer, &method, start, spent, watch)
        }
        Solver::Fire2 => {
            let method = Fire::v2(Fire::largest_dt(stiffest));
            run(contact, control, settings, layer, &method, start, spent, watch)
        }
        Solver::AugmentedLagrangian => {
            let problem = AugmentedLagrangian::new(Sprung::new(layer));
            let method = Nesterov { tau: RELAXATION };
            run(contact, control, settings, problem, &method, start, spent, watch)
        }
        Solver::VerletCritical => {
            let dt = SOURCE_TIME_STEP * 2.0 / stiffest.sqrt();
            let method = Verlet::critical(softest, stiffest, dt).map_err(unusable)?;
            run(contact, control, settings, layer, &method, start, spent, watch)
        }
        _ => {
            let method = Verlet::optimal(softest, stiffest).map_err(unusable)?;
            run(contact, control, settings, layer, &method, start, spent, watch)
        }
    }
}

/// Runs until the residuals of the pressure on the wall are at the tolerance, not only those of the layer.
#[expect(clippy::too_many_arguments, reason = "one caller, which has them all at hand")]
fn run<'a, M: Method>(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    mut surface: impl Pressed<'a>,
    method: &M,
    start: Option<Vec<f64>>,
    spent: &mut Spent,
    watch: Watch,
) -> Result<(Vec<f64>, End), ContactError> {
    let u = match &start {
        Some(pressure) => surface.layer().displacement(contact, pressure),
        None => vec![0.0; contact.wall.clearance.len()],
    };
    let unusable = |error: RelaxError| ContactError::Start { reason: error.to_string() };
    let u = surface.begin(u, start.as_deref());
    let mut state = method.start(&mut surface, u).map_err(unusable)?;
    let before = spent.iterations;
    let mut observe = |now: &gfmd_relax::Progress, _: &State<M::Memory>| -> std::io::Result<ControlFlow<()>> {
        Ok(watch(&Progress { iteration: before + now.step, residual: now.residual }))
    };
    let mut stop = Stop {
        residual: settings.tolerance,
        settled: SETTLED,
        max_steps: settings.max_iterations.saturating_sub(before),
    };
    let end = loop {
        match relax(&mut surface, method, &mut state, &stop, &mut observe) {
            Ok(Outcome::Converged(now)) => {
                let certified = contact.certify(surface.pressure(&state.u, &state.force), control)?;
                surface.layer().transforms.singles += 2;
                let worst = certified.residual.worst();
                if worst <= settings.tolerance {
                    break End::Converged;
                }
                stop.residual = now.residual * (0.5 * settings.tolerance / worst).clamp(1e-3, 0.5);
            }
            Ok(Outcome::Interrupted(_)) => break End::Interrupted,
            Err(error) => break End::GaveUp(error.to_string()),
        }
    };
    let pressure = surface.pressure(&state.u, &state.force);
    spent.iterations += state.step;
    spent.singles += surface.layer().transforms.singles;
    Ok((pressure, end))
}

/// False position (Illinois) on the load, each run started from the last, until the approach is the asked one.
fn search_load(
    contact: &Contact,
    approach: f64,
    settings: &Settings,
    start: Option<Vec<f64>>,
    spent: &mut Spent,
    watch: Watch,
) -> Result<(Vec<f64>, End), ContactError> {
    let [softest, _] = contact.response.stiffness_range();
    let mut load = match &start {
        Some(pressure) => pressure.iter().sum::<f64>() / pressure.len() as f64,
        None => 0.1 * softest * approach,
    };
    let mut pressure = start;
    // Loads with their excess of approach: one that is too small, one that is too large.
    let mut bracket: [Option<(f64, f64)>; 2] = [None, None];
    loop {
        let control = Control::MeanPressure(load);
        let (found, end) = equilibrate(contact, control, settings, pressure.take(), spent, watch)?;
        if !matches!(end, End::Converged) {
            return Ok((found, end));
        }
        let excess = contact.certify(found.clone(), control)?.approach - approach;
        spent.singles += 2;
        if excess.abs() <= 0.1 * settings.tolerance * contact.wall.rms_height {
            return Ok((found, end));
        }
        let side = usize::from(excess > 0.0);
        let again = bracket[side].is_some();
        bracket[side] = Some((load, excess));
        load = match &mut bracket {
            [Some(below), Some(above)] => {
                if again {
                    let other = if side == 0 { above } else { below };
                    other.1 *= 0.5;
                }
                let [Some(below), Some(above)] = bracket else { return Ok((found, end)) };
                (below.0 * above.1 - above.0 * below.1) / (above.1 - below.1)
            }
            [Some(_), None] => 2.0 * load,
            _ => 0.5 * load,
        };
        pressure = Some(found);
    }
}
