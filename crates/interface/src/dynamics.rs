//! Damped dynamics: slow, but it needs no energy, only the force. The time step follows from the stiffest mode of the body
//! and the stiffness of the law (theory.md, section 8).

use std::ops::ControlFlow;

use gfmd_relax::{Bounds, Fire, Landscape, Method as _, Outcome, Stop, relax};
use gfmd_vector::{for_each, sum};

use crate::certify::certify;
use crate::elastic::{Transforms, mean};
use crate::newton::{End, Ended};
use crate::problem::{Frame, Interface, Progress, Settings, Watch};
use crate::{Drive, State};

/// Runs with a time step shortened each time the motion blows up or goes uphill for ever.
const ATTEMPTS: u32 = 8;

pub(crate) fn relax_to_rest(
    interface: &Interface,
    drive: Drive,
    settings: &Settings,
    start: Option<&State>,
    watch: Watch,
) -> Ended {
    let frame = interface.frame(drive);
    let mut position = interface.starting_position(drive, start);
    let [softest, stiffest] = interface.elastic.stiffness_range();
    let points = interface.clearance.len();
    let lowest = (0..points).map(|i| frame.separation(interface, &position, i).0).fold(0.0, f64::min);
    let z = position.len() - points;
    let bounds = interface.law.has_wall().then(|| {
        let mut upper = vec![f64::INFINITY; position.len()];
        upper[z..].iter_mut().zip(&interface.clearance).for_each(|(upper, c)| *upper = c - frame.approach);
        upper
    });
    let scale = softest * interface.length_scale();
    let mut motion = Motion { interface, frame, transforms: interface.elastic.transforms(), bounds, scale };
    motion.hold_means(&mut position);
    let mut stiffness = stiffest + interface.law.stiffness_bound(lowest);
    let (mut iterations, mut end) = (0, End::GaveUp("the motion does not settle"));
    let mut target = settings.tolerance;
    'attempts: for _ in 0..ATTEMPTS {
        let method = Fire::v2(Fire::largest_dt(stiffness));
        // A state of the wrong length cannot be: the position was made for this motion.
        let Ok(mut state) = method.start(&mut motion, position.clone()) else { break };
        loop {
            let left = settings.max_iterations.saturating_sub(iterations);
            let stop = Stop { residual: target, settled: 20, max_steps: left };
            let mut observe = |now: &gfmd_relax::Status, _: &_| -> std::io::Result<ControlFlow<()>> {
                Ok(watch(&Progress { iteration: iterations + now.step, residual: now.residual }))
            };
            let outcome = relax(&mut motion, &method, &mut state, &stop, &mut observe);
            match outcome {
                Ok(Outcome::Converged(now)) => {
                    let worst = certify(interface, drive, &state.u).residual.worst();
                    if worst <= settings.tolerance {
                        (position, end) = (state.u, End::Converged);
                        iterations += state.step;
                        break 'attempts;
                    }
                    target = now.residual * (0.5 * settings.tolerance / worst).clamp(1e-3, 0.5);
                }
                Ok(Outcome::Interrupted(_)) => {
                    (position, end) = (state.u, End::Interrupted);
                    iterations += state.step;
                    break 'attempts;
                }
                Err(_) if state.step >= left => {
                    (position, end) = (state.u, End::GaveUp("the step limit"));
                    iterations += state.step;
                    break 'attempts;
                }
                Err(_) => {
                    iterations += state.step;
                    stiffness *= 4.0;
                    break;
                }
            }
        }
    }
    Ended {
        position,
        iterations,
        transform_pairs: motion.transforms.pairs,
        passed_instability: false,
        lowest_curvature: f64::NAN,
        end,
    }
}

struct Motion<'a> {
    interface: &'a Interface<'a>,
    frame: Frame,
    transforms: Transforms<'a>,
    bounds: Option<Vec<f64>>,
    /// The force that counts as one.
    scale: f64,
}

impl Motion<'_> {
    fn hold_means(&self, field: &mut [f64]) {
        let points = self.interface.clearance.len();
        for (field, _) in field.chunks_exact_mut(points).zip(&self.frame.held).filter(|(_, held)| **held) {
            let mean = mean(field);
            for_each([field], &|_, [field]| field.iter_mut().for_each(|f| *f -= mean));
        }
    }
}

impl Landscape for Motion<'_> {
    fn len(&self) -> usize {
        self.frame.held.len() * self.interface.clearance.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let Self { interface, frame, transforms, .. } = self;
        let points = interface.clearance.len();
        let z = frame.held.len() - 1;
        transforms.stiffness(u, &frame.uniform_stiffness, force);
        let elastic = 0.5 * gfmd_vector::dot(u, force);
        for (c, force) in force.chunks_exact_mut(points).enumerate() {
            let (axis, push) = if c == z { (2, frame.push) } else { (c, 0.0) };
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for (k, f) in force.iter_mut().enumerate() {
                    let (normal, sliding) = frame.separation(interface, u, start + k);
                    *f = interface.law.traction(normal, sliding)[axis] + push - *f;
                }
            };
            for_each([force], &net);
        }
        let law = sum(points, &|range| {
            range.map(|i| interface.law.opening_energy(frame.separation(interface, u, i).0)).sum()
        });
        let work: f64 = frame.push * sum(points, &|range| u[z * points..][range].iter().sum());
        self.hold_means(force);
        // Of a law without a potential no more than a measure of how far things have gone.
        elastic + law - work
    }

    fn bounds(&self) -> Bounds<'_> {
        self.bounds.as_deref().map_or(Bounds::Free, Bounds::Upper)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.scale, self.interface.length_scale())
    }
}
