//! The contact problem in terms of the surface displacement, equilibrated by damped dynamics: the surface layer moves
//! under its own elastic force −K u and stops at the rigid wall, u ≤ clearance − approach (theory.md, section 6).
//!
//! Under a prescribed mean pressure p̄ the rigid surface stays at first touch and the body is pushed against it: the
//! uniform mode costs no energy and feels the force p̄, so that at rest the wall carries exactly p̄. Under a prescribed
//! approach the wall is in its place and the uniform mode has the stiffness of the slab; where the body has none to
//! give (half-space, incompressible slab) the load that gives the asked approach is searched for.

use std::borrow::Cow;
use std::ops::ControlFlow;

use gfmd_relax::{Bounds, Fire, Landscape, Method, Outcome, RelaxError, State, Stop, Verlet, relax};
use gfmd_response::NormalResponse;
use gfmd_vector::{add, pass};

use crate::problem::{End, Ended, Transforms};
use crate::{Contact, ContactError, Control, Progress, Settings, Solver, Watch};

/// Time step of the original method over its stability limit 2/√k_max.
const SOURCE_TIME_STEP: f64 = 0.25;

/// A rough contact is about as stiff as its mean pressure over this many rms heights (Akarapu, Sharp and Robbins 2011;
/// Campañá, Persson and Müser 2011 find 0.4 to 0.5). Only sets the damping of the rigid motion, so only the speed.
const STIFFNESS_LENGTH: f64 = 0.45;

/// Steps that the set of touching points must have kept still (theory.md, section 6.6).
const SETTLED: u64 = 20;

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
        let fits = "every field of a contact problem has the size of its grid";
        self.response.transform().convolve(&self.stiffness, u, force, &mut self.transforms.workspace).expect(fits);
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
            Control::MeanPressure(mean) => (Cow::from(response.stiffness()), Cow::from(&contact.clearance), mean, mean),
            Control::Approach(approach) => {
                let mut stiffness = response.stiffness().to_vec();
                stiffness[0] = 1.0 / response.uniform_compliance();
                let wall: Vec<f64> = contact.clearance.iter().map(|c| c - approach).collect();
                (Cow::from(stiffness), Cow::from(wall), 0.0, softest * contact.rms_height)
            }
        };
        let transforms = Transforms::new(response);
        Self { response, stiffness, wall, push, force_scale, length_scale: contact.rms_height, transforms }
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
        let fits = "every field of a contact problem has the size of its grid";
        let response = self.response;
        response
            .transform()
            .convolve(response.compliance(), pressure, &mut u, &mut self.transforms.workspace)
            .expect(fits);
        let sums = gfmd_vector::reduce(
            u.len(),
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let touching = f64::from(pressure[i] > 0.0);
                    add(sums, [pressure[i], touching, touching * (contact.clearance[i] + u[i])])
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

    /// The force on the wall, free of what is left on the free points.
    fn pressure<Memory>(&self, state: &State<Memory>) -> Vec<f64> {
        let touching = |i: usize| state.u[i] >= self.wall[i];
        let mut pressure: Vec<f64> =
            state.force.iter().enumerate().map(|(i, f)| if touching(i) { f.max(0.0) } else { 0.0 }).collect();
        let sum = gfmd_vector::sum(pressure.len(), &|range| pressure[range].iter().sum());
        if self.push > 0.0 && sum > 0.0 {
            let factor = self.push * pressure.len() as f64 / sum;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        pressure
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
            let method = Fire::bitzek(1.9 / stiffest.sqrt());
            run(contact, control, settings, layer, &method, start, spent, watch)
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
fn run<M: Method>(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    mut layer: Layer,
    method: &M,
    start: Option<Vec<f64>>,
    spent: &mut Spent,
    watch: Watch,
) -> Result<(Vec<f64>, End), ContactError> {
    let u = match start {
        Some(pressure) => layer.displacement(contact, &pressure),
        None => vec![0.0; contact.clearance.len()],
    };
    let unusable = |error: RelaxError| ContactError::Start { reason: error.to_string() };
    let mut state = method.start(&mut layer, u).map_err(unusable)?;
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
        match relax(&mut layer, method, &mut state, &stop, &mut observe) {
            Ok(Outcome::Converged(now)) => {
                let certified = contact.certify(layer.pressure(&state), control)?;
                layer.transforms.singles += 2;
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
    let pressure = layer.pressure(&state);
    spent.iterations += state.step;
    spent.singles += layer.transforms.singles;
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
        if excess.abs() <= 0.1 * settings.tolerance * contact.rms_height {
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
