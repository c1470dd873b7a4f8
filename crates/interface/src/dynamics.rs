//! Damped dynamics: slow, but it needs no energy, only the force. The time step follows from the stiffest mode of the body
//! and the stiffness of the law (theory.md, section 8).

use std::ops::ControlFlow;

use gfmd_relax::{Bounds, Fire, Landscape, Method as _, Outcome, Stop, relax};
use gfmd_vector::{for_each, sum};

use crate::certify::certify;
use crate::elastic::Transforms;
use crate::ended::{End, Ended};
use crate::frame::Frame;
use crate::numbers::mean;
use crate::{Interface, Progress, Settings, State, Watch};

/// Runs with a time step shortened each time the motion blows up or goes uphill for ever.
const ATTEMPTS: u32 = 8;

pub(crate) fn relax_to_rest(
    interface: &Interface,
    frame: &Frame,
    settings: &Settings,
    start: Option<&State>,
    watch: Watch,
) -> Ended {
    let mut position = frame.starting_position(start);
    let [softest, stiffest] = interface.elastic.stiffness_range();
    let lowest = (0..frame.points()).map(|i| frame.separation(&position, i).0).fold(0.0, f64::min);
    let bounds = interface.law.has_wall().then(|| {
        let open = frame.z() * frame.points();
        std::iter::repeat_n(f64::INFINITY, open).chain(frame.wall()).collect()
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
                    let worst = certify(interface, frame, &state.u).residual.worst();
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
    frame: &'a Frame<'a>,
    transforms: Transforms<'a>,
    bounds: Option<Vec<f64>>,
    /// The force that counts as one.
    scale: f64,
}

impl Motion<'_> {
    fn hold_means(&self, field: &mut [f64]) {
        let points = self.frame.points();
        for (field, _) in field.chunks_exact_mut(points).zip(&self.frame.held).filter(|(_, held)| **held) {
            let mean = mean(field);
            for_each([field], &|_, [field]| field.iter_mut().for_each(|f| *f -= mean));
        }
    }
}

impl Landscape for Motion<'_> {
    fn len(&self) -> usize {
        self.frame.components() * self.frame.points()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let Self { interface, frame, transforms, .. } = self;
        let (points, z) = (frame.points(), frame.z());
        transforms.stiffness(u, &frame.uniform_stiffness, force);
        let elastic = 0.5 * gfmd_vector::dot(u, force);
        for (c, force) in force.chunks_exact_mut(points).enumerate() {
            let (axis, push) = (if c == z { 2 } else { c }, frame.push_on(c));
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for (k, f) in force.iter_mut().enumerate() {
                    let (normal, sliding) = frame.separation(u, start + k);
                    *f = interface.law.traction(normal, sliding)[axis] + push - *f;
                }
            };
            for_each([force], &net);
        }
        let law = sum(points, &|range| range.map(|i| interface.law.opening_energy(frame.separation(u, i).0)).sum());
        let work: f64 = frame.push * sum(points, &|range| u[z * points..][range].iter().sum());
        self.hold_means(force);
        // Without a potential of the law this is not an energy, only a monitor for divergence.
        elastic + law - work
    }

    fn bounds(&self) -> Bounds<'_> {
        self.bounds.as_deref().map_or(Bounds::Free, Bounds::Upper)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.scale, self.interface.length_scale())
    }
}
