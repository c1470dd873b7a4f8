//! Downhill by Newton steps within a trust region, on the points that the wall does not hold.
//!
//! The energy ½⟨w, K w⟩ + Σ Φ(Δ(w)) − push Σ w_z is minimised over w_z ≤ bound. A step solves (K + J) d = f on the free
//! points by conjugate gradients that stop at the edge of the region or where the curvature turns negative (Steihaug 1983),
//! preconditioned by the compliance, softened where the law is stiff. It is then bent along the wall and shortened until
//! the energy falls: no step climbs, so a jump ends in a stable state further down.

use gfmd_vector::{add, dot, for_each, pass, reduce};

use crate::certify::higher;
use crate::elastic::Transforms;
use crate::problem::{Frame, Interface, Progress, Settings, Watch};
use crate::{Drive, State};

pub(crate) struct Ended {
    pub(crate) position: Vec<f64>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: u64,
    pub(crate) passed_instability: bool,
    pub(crate) lowest_curvature: f64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Converged,
    Interrupted,
    /// Pulled apart without anything that could hold.
    Detached,
    GaveUp(&'static str),
}

/// The solver goes on until its residual is this part of the tolerance.
const SHARE_OF_TOLERANCE: f64 = 0.1;
/// The first step off a saddle, in rms heights, and how often it is doubled.
const FIRST_SHIFT: f64 = 1e-9;
const DOUBLINGS: u32 = 36;
/// How far a search that only looks for negative curvature reduces its noise.
const PROBE: f64 = 1e-3;
/// Conjugate gradients of one step.
const INNER: usize = 200;
/// The first region, in lengths of a preconditioned step downhill.
const FIRST_RADIUS: f64 = 1.0;
/// How often a step is halved.
const HALVINGS: u32 = 14;
/// A step must gain this share of what the slope promises (Armijo).
const SHARE: f64 = 1e-4;
/// Energies are known to this part of their terms.
const ROUNDING: f64 = 1e-14;

pub(crate) fn descend(
    interface: &Interface,
    drive: Drive,
    settings: &Settings,
    start: Option<&State>,
    watch: Watch,
) -> Ended {
    let mut descent = Descent::new(interface, drive, start);
    let mut iterations = 0;
    let end = loop {
        let residual = descent.release();
        if watch(&Progress { iteration: iterations, residual }).is_break() {
            break End::Interrupted;
        }
        if descent.is_apart() {
            break End::Detached;
        }
        let at_rest = residual <= SHARE_OF_TOLERANCE * settings.tolerance;
        if at_rest && !(descent.is_unstable() && descent.leave()) {
            break End::Converged;
        }
        if iterations == settings.max_iterations {
            break End::GaveUp("the iteration limit");
        }
        iterations += 1;
        if at_rest {
            continue;
        }
        descent.seek((SHARE_OF_TOLERANCE * settings.tolerance / residual).max(residual.sqrt().min(0.1)));
        if !descent.advance() && !descent.slide_downhill() {
            break if residual <= settings.tolerance {
                End::Converged
            } else {
                End::GaveUp("no step lowers the energy")
            };
        }
    };
    Ended {
        iterations,
        transform_pairs: descent.transforms.pairs,
        passed_instability: descent.negative && start.is_some(),
        lowest_curvature: descent.lowest,
        position: descent.position,
        end,
    }
}

struct Descent<'a> {
    interface: &'a Interface<'a>,
    frame: Frame,
    transforms: Transforms<'a>,
    points: usize,
    /// The wall, as a bound of w_z.
    bound: Option<Vec<f64>>,
    /// Compliance of the uniform mode in the preconditioner.
    uniform: Vec<f64>,
    /// w and K w.
    position: Vec<f64>,
    elastic: Vec<f64>,
    trial: Vec<f64>,
    trial_elastic: Vec<f64>,
    law: Reaction,
    /// T − K w + push: what moves a free point.
    force: Vec<f64>,
    /// How much a point counts in the preconditioner; 0 where the wall holds it.
    weight: Vec<f64>,
    direction: Vec<f64>,
    left: Vec<f64>,
    conjugate: Vec<f64>,
    image: Vec<f64>,
    preconditioned: Vec<f64>,
    radius: f64,
    /// Length of `direction` in the metric of the preconditioner.
    length: f64,
    negative: bool,
    lowest: f64,
    pulled: bool,
    stiffness_range: [f64; 2],
}

/// Traction and curvature of the law at every point: T_n and J_nn, or all components and the six entries of J.
struct Reaction {
    traction: Vec<f64>,
    curvature: Vec<f64>,
}

impl<'a> Descent<'a> {
    fn new(interface: &'a Interface<'a>, drive: Drive, start: Option<&State>) -> Self {
        let frame = interface.frame(drive);
        let points = interface.clearance.len();
        let components = interface.elastic.components();
        let size = components * points;
        let bound: Option<Vec<f64>> =
            interface.law.has_wall().then(|| interface.clearance.iter().map(|c| c - frame.approach).collect());
        let position = interface.starting_position(drive, start);
        let stiffness_range = interface.elastic.stiffness_range();
        let uniform =
            frame.uniform_stiffness.iter().map(|k| 1.0 / if *k > 0.0 { *k } else { stiffness_range[0] }).collect();
        let fields = if components == 1 { [1, 1] } else { [3, 6] };
        let mut descent = Self {
            interface,
            transforms: interface.elastic.transforms(),
            points,
            bound,
            uniform,
            position: vec![0.0; size],
            elastic: vec![0.0; size],
            trial: position,
            trial_elastic: vec![0.0; size],
            law: Reaction { traction: vec![0.0; fields[0] * points], curvature: vec![0.0; fields[1] * points] },
            force: vec![0.0; size],
            weight: vec![0.0; size],
            direction: vec![0.0; size],
            left: vec![0.0; size],
            conjugate: vec![0.0; size],
            image: vec![0.0; size],
            preconditioned: vec![0.0; size],
            radius: f64::INFINITY,
            length: 0.0,
            negative: false,
            lowest: f64::NAN,
            pulled: frame.push < 0.0,
            stiffness_range,
            frame,
        };
        descent.bend();
        descent.transforms.stiffness(&descent.trial, &descent.frame.uniform_stiffness, &mut descent.trial_elastic);
        descent.accept();
        descent
    }

    fn components(&self) -> usize {
        self.position.len() / self.points
    }

    fn z(&self) -> usize {
        (self.components() - 1) * self.points
    }

    /// Brings the trial back to where it may be: under the wall, with the means that are held. Clipping lowers the mean,
    /// so what is free rises to make up for it.
    fn bend(&mut self) {
        let Self { trial, bound, frame, points, .. } = self;
        let z = frame.held.len() - 1;
        for (c, field) in trial.chunks_exact_mut(*points).enumerate() {
            let bound = bound.as_ref().filter(|_| c == z);
            if let Some(bound) = bound {
                for_each([field], &|start, [w]| w.iter_mut().zip(&bound[start..]).for_each(|(w, b)| *w = w.min(*b)));
            }
            if !frame.held[c] {
                continue;
            }
            // Whoever rises may meet the wall in turn; a handful of rounds settle it.
            for _ in 0..50 {
                let [total, free] = reduce(
                    *points,
                    &|range| {
                        range.fold([0.0; 2], |sums, i| {
                            add(sums, [field[i], f64::from(bound.is_none_or(|b| field[i] < b[i]))])
                        })
                    },
                    &add,
                );
                let size = total.abs() / *points as f64;
                if free == 0.0 || size <= f64::EPSILON * self.interface.length_scale() {
                    break;
                }
                let shift = -total / free;
                let lift = |start: usize, [w]: [&mut [f64]; 1]| {
                    for (i, w) in w.iter_mut().enumerate() {
                        match bound.map(|b| b[start + i]) {
                            Some(b) if *w < b => *w = (*w + shift).min(b),
                            Some(_) => {}
                            None => *w += shift,
                        }
                    }
                };
                for_each([field], &lift);
            }
        }
    }

    /// The trial becomes the position.
    fn accept(&mut self) {
        std::mem::swap(&mut self.position, &mut self.trial);
        std::mem::swap(&mut self.elastic, &mut self.trial_elastic);
        let Self { interface, frame, position, elastic, law, force, points, .. } = self;
        let (interface, n) = (*interface, *points);
        if position.len() == n {
            let respond = |start: usize, [traction, curvature]: [&mut [f64]; 2]| {
                for (k, (t, j)) in traction.iter_mut().zip(curvature).enumerate() {
                    let i = start + k;
                    let response = interface.law.response(interface.clearance[i] - frame.approach - position[i], 0.0);
                    (*t, *j) = (response.traction[0], response.jacobian[0][0]);
                }
            };
            for_each([&mut law.traction, &mut law.curvature], &respond);
        } else {
            let [tx, ty, tz] = split(&mut law.traction, n);
            let [xx, xy, yy, xz, yz, zz] = split(&mut law.curvature, n);
            let respond = |start: usize, fields: [&mut [f64]; 9]| {
                for k in 0..fields[0].len() {
                    let (normal, sliding) = frame.separation(interface, position, start + k);
                    let [x, y, n] = interface.law.traction(normal, sliding);
                    let j = interface.law.jacobian(normal, sliding);
                    let values = [x, y, n, j.tt[0][0], j.tt[0][1], j.tt[1][1], j.nt[0], j.nt[1], j.nn];
                    // Not an iterator: one value for each of nine fields.
                    for (c, value) in values.into_iter().enumerate() {
                        fields[c][k] = value;
                    }
                }
            };
            for_each([tx, ty, tz, xx, xy, yy, xz, yz, zz], &respond);
        }
        let z = position.len() / n - 1;
        for (c, force) in force.chunks_exact_mut(n).enumerate() {
            let traction = &law.traction[axis(c, z) * n..][..n];
            let elastic = &elastic[c * n..][..n];
            let push = if c == z { frame.push } else { 0.0 };
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for ((f, t), k) in force.iter_mut().zip(&traction[start..]).zip(&elastic[start..]) {
                    *f = t - k + push;
                }
            };
            for_each([force], &net);
        }
    }

    /// Finds the points that the wall holds, takes the mean off the force where a mean is held, and returns the residual.
    fn release(&mut self) -> f64 {
        let n = self.points;
        let z = self.components() - 1;
        let [softest, stiffest] = self.stiffness_range;
        let reference = (softest * stiffest).sqrt();
        let (mut unbalanced, mut largest) = (0.0_f64, softest * self.interface.rms_height);
        for c in 0..=z {
            let range = c * n..(c + 1) * n;
            let force = &mut self.force[range.clone()];
            let position = &self.position[range.clone()];
            let traction = &self.law.traction[axis(c, z) * n..][..n];
            // The diagonal of J: xx, yy, zz.
            let diagonal = match (z, axis(c, z)) {
                (0, _) => 0,
                (_, 0) => 0,
                (_, 1) => 2,
                _ => 5,
            };
            let curvature = &self.law.curvature[diagonal * n..][..n];
            let bound = self.bound.as_ref().filter(|_| c == z);
            let at_bound = |i: usize| bound.is_some_and(|b| position[i] >= b[i]);
            let mut multiplier = 0.0;
            if self.frame.held[c] {
                let [total, count] = reduce(
                    n,
                    &|range| range.filter(|i| !at_bound(*i)).fold([0.0; 2], |sums, i| add(sums, [force[i], 1.0])),
                    &add,
                );
                multiplier = if count > 0.0 { total / count } else { 0.0 };
            }
            let weigh = |start: usize, [force, weight]: [&mut [f64]; 2]| {
                let mut worst = [0.0_f64; 2];
                for (k, (f, weight)) in force.iter_mut().zip(weight).enumerate() {
                    let i = start + k;
                    *f -= multiplier;
                    let held = at_bound(i) && *f > 0.0;
                    *weight = if held { 0.0 } else { (1.0 + curvature[i].max(0.0) / reference).sqrt().recip() };
                    let free = if held { 0.0 } else { f.abs() };
                    worst = higher(worst, [free, (traction[i] - *f).abs()]);
                }
                worst
            };
            let [free, stress] = pass([force, &mut self.weight[range]], &weigh, &higher);
            unbalanced = higher([unbalanced, 0.0], [free, 0.0])[0];
            largest = higher([largest, 0.0], [stress, 0.0])[0];
        }
        unbalanced / largest.max(f64::MIN_POSITIVE)
    }

    /// Whether a pulled surface has nothing left that holds it.
    fn is_apart(&self) -> bool {
        let z = self.z();
        let traction = &self.law.traction[self.law.traction.len() - self.points..];
        let apart = |i: usize| self.weight[z + i] > 0.0 && traction[i].abs() < 1e-3 * self.frame.push.abs();
        self.pulled && reduce(self.points, &|mut range| range.all(apart), &|a, b| a && b)
    }

    /// The direction of the next step, and its length.
    fn seek(&mut self, forcing: f64) {
        self.left.copy_from_slice(&self.force);
        self.search(forcing, Some(self.radius));
    }

    /// Whether a state at rest is a saddle: a force in all directions, noise, shows a negative curvature that the force
    /// at rest, or a symmetry, may hide. The direction is then one of escape.
    fn is_unstable(&mut self) -> bool {
        if self.interface.law.stiffness_bound(f64::NEG_INFINITY) == 0.0 {
            // Nothing but the wall: the energy is convex.
            self.lowest = 1.0;
            return false;
        }
        let noise = |start: usize, [left]: [&mut [f64]; 1]| {
            for (k, left) in left.iter_mut().enumerate() {
                // The golden ratio leaves no two points alike and prefers no wave.
                *left = (0.618_033_988_749_895 * (start + k + 1) as f64 * ((start + k) % 7 + 1) as f64).fract() - 0.5;
            }
        };
        for_each([&mut self.left], &noise);
        self.search(PROBE, None);
        self.lowest <= 0.0
    }

    /// Steps off a saddle along the direction, just far enough that the energy falls by more than rounding.
    fn leave(&mut self) -> bool {
        let longest = gfmd_vector::reduce(
            self.direction.len(),
            &|range| self.direction[range].iter().fold(0.0, |longest: f64, d| longest.max(d.abs())),
            &f64::max,
        );
        let downhill = if dot(&self.direction, &self.force) < 0.0 { -1.0 } else { 1.0 };
        let mut share = downhill * FIRST_SHIFT * self.interface.length_scale() / longest;
        for _ in 0..DOUBLINGS {
            let Change { energy, size, .. } = self.try_step(share);
            if energy < -10.0 * ROUNDING * size {
                self.accept();
                // The steps before say nothing about what lies ahead.
                self.radius = f64::INFINITY;
                return true;
            }
            share *= 2.0;
        }
        false
    }

    /// (K + J) `direction` = `left`, as far as the region goes; without one, until a negative curvature shows, whose
    /// direction is then the result.
    fn search(&mut self, forcing: f64, radius: Option<f64>) {
        project(&mut self.left, &self.weight, &self.frame.held, self.points);
        self.direction.fill(0.0);
        self.precondition();
        self.conjugate.copy_from_slice(&self.preconditioned);
        let mut product = dot(&self.left, &self.preconditioned);
        let aim = forcing * forcing * product;
        let radius = radius.map(|radius| if radius.is_finite() { radius } else { FIRST_RADIUS * product.sqrt() });
        self.radius = radius.unwrap_or(self.radius);
        let square = radius.unwrap_or(f64::INFINITY).powi(2);
        // ⟨d, M d⟩, ⟨d, M p⟩, ⟨p, M p⟩ with M the inverse of the preconditioner.
        let (mut dd, mut dp, mut pp) = (0.0, 0.0, product);
        self.lowest = f64::INFINITY;
        for _ in 0..INNER {
            if product <= aim || product.is_nan() {
                break;
            }
            self.curve();
            let curvature = dot(&self.conjugate, &self.image);
            self.lowest = self.lowest.min(curvature / pp);
            let step = product / curvature;
            let edge = dd + 2.0 * step * dp + step * step * pp >= square;
            if curvature <= 0.0 || edge {
                self.negative |= curvature <= 0.0;
                if radius.is_none() {
                    self.direction.copy_from_slice(&self.conjugate);
                    return;
                }
                let to_edge = ((dp * dp + pp * (square - dd)).max(0.0).sqrt() - dp) / pp;
                axpy(&mut self.direction, to_edge, &self.conjugate);
                dd = square;
                break;
            }
            axpy(&mut self.direction, step, &self.conjugate);
            axpy(&mut self.left, -step, &self.image);
            project(&mut self.left, &self.weight, &self.frame.held, self.points);
            dd += 2.0 * step * dp + step * step * pp;
            self.precondition();
            let next = dot(&self.left, &self.preconditioned);
            let turn = next / product;
            product = next;
            let add_turned = |start: usize, [p]: [&mut [f64]; 1]| {
                p.iter_mut().zip(&self.preconditioned[start..]).for_each(|(p, z)| *p = z + turn * *p);
            };
            for_each([&mut self.conjugate], &add_turned);
            dp = turn * (dp + step * pp);
            pp = product + turn * turn * pp;
        }
        self.length = dd.sqrt();
    }

    /// `preconditioned` ← the compliance applied to `left`, softened where the law is stiff, kept off the wall.
    fn precondition(&mut self) {
        let Self { transforms, left, preconditioned, weight, image, uniform, frame, points, .. } = self;
        multiply(image, left, weight);
        transforms.compliance(image, uniform, preconditioned);
        let weigh = |start: usize, [z]: [&mut [f64]; 1]| z.iter_mut().zip(&weight[start..]).for_each(|(z, w)| *z *= w);
        for_each([preconditioned], &weigh);
        project(preconditioned, weight, &frame.held, *points);
    }

    /// `image` ← (K + J) `conjugate`.
    fn curve(&mut self) {
        let Self { transforms, conjugate, image, law, frame, points, .. } = self;
        let n = *points;
        transforms.stiffness(conjugate, &frame.uniform_stiffness, image);
        let j = &law.curvature;
        let p = &*conjugate;
        match image.len() / n {
            1 => for_each([image], &|start, [out]| {
                for ((out, p), j) in out.iter_mut().zip(&p[start..]).zip(&j[start..]) {
                    *out += p * j;
                }
            }),
            2 => for_each(split(image, n), &|start, [x, z]| {
                for (k, (x, z)) in x.iter_mut().zip(z).enumerate() {
                    let i = start + k;
                    let (px, pz) = (p[i], p[n + i]);
                    *x += j[i] * px + j[3 * n + i] * pz;
                    *z += j[3 * n + i] * px + j[5 * n + i] * pz;
                }
            }),
            _ => for_each(split(image, n), &|start, [x, y, z]| {
                for (k, ((x, y), z)) in x.iter_mut().zip(y).zip(z).enumerate() {
                    let i = start + k;
                    let (px, py, pz) = (p[i], p[n + i], p[2 * n + i]);
                    *x += j[i] * px + j[n + i] * py + j[3 * n + i] * pz;
                    *y += j[n + i] * px + j[2 * n + i] * py + j[4 * n + i] * pz;
                    *z += j[3 * n + i] * px + j[4 * n + i] * py + j[5 * n + i] * pz;
                }
            }),
        }
    }

    /// Goes along the direction, bent at the wall, as far as the energy falls.
    fn advance(&mut self) -> bool {
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            if self.try_step(share).falls() {
                self.radius = if share == 1.0 { self.radius.max(2.0 * self.length) } else { share * self.length };
                self.accept();
                return true;
            }
            share *= 0.5;
        }
        self.radius = share * self.length;
        false
    }

    /// The plain gradient, which lowers the energy if it is followed a little, wall or not.
    fn slide_downhill(&mut self) -> bool {
        self.direction.copy_from_slice(&self.force);
        project(&mut self.direction, &self.weight, &self.frame.held, self.points);
        let mut share = 1.0 / self.stiffness_range[1];
        for _ in 0..2 * HALVINGS {
            if self.try_step(share).falls() {
                self.accept();
                return true;
            }
            share *= 0.25;
        }
        false
    }

    /// Puts the trial at `share` of the direction.
    fn try_step(&mut self, share: f64) -> Change {
        let along = |start: usize, [trial]: [&mut [f64]; 1]| {
            let from = self.position[start..].iter().zip(&self.direction[start..]);
            trial.iter_mut().zip(from).for_each(|(trial, (w, d))| *trial = w + share * d);
        };
        for_each([&mut self.trial], &along);
        self.bend();
        self.transforms.stiffness(&self.trial, &self.frame.uniform_stiffness, &mut self.trial_elastic);
        let Self { interface, frame, position, elastic, trial, trial_elastic, force, points, .. } = self;
        let n = *points;
        let [change, slope, size] = reduce(
            position.len(),
            &|range| {
                range.fold([0.0; 3], |sums, k| {
                    let s = trial[k] - position[k];
                    let push = if k / n == frame.held.len() - 1 { frame.push } else { 0.0 };
                    let work = s * (0.5 * (elastic[k] + trial_elastic[k]) - push);
                    add(sums, [work, s * force[k], work.abs()])
                })
            },
            &add,
        );
        let [law, law_size] = reduce(
            n,
            &|range| {
                range.fold([0.0; 2], |sums, i| {
                    let before = interface.energy(frame.separation(interface, position, i));
                    let after = interface.energy(frame.separation(interface, trial, i));
                    add(sums, [after - before, before.abs()])
                })
            },
            &add,
        );
        Change { energy: change + law, promised: slope, size: size + law_size }
    }
}

/// What a trial does to the energy.
struct Change {
    energy: f64,
    /// By which the slope would lower it.
    promised: f64,
    /// Magnitude of the terms that make up `energy`.
    size: f64,
}

impl Change {
    /// Whether the energy falls enough.
    fn falls(&self) -> bool {
        self.promised > 0.0 && self.energy.is_finite() && self.energy <= -SHARE * self.promised + ROUNDING * self.size
    }
}

/// x, y, z of a component, where z is the last.
fn axis(component: usize, z: usize) -> usize {
    if component == z && z > 0 { 2 } else { component }
}

/// A vector of `M` fields, field by field.
fn split<const M: usize>(vector: &mut [f64], points: usize) -> [&mut [f64]; M] {
    let mut fields = vector.chunks_exact_mut(points);
    std::array::from_fn(|_| fields.next().unwrap_or_default())
}

/// 0 where the weight is; a mean of 0 over the rest of a component whose mean is held.
fn project(vector: &mut [f64], weight: &[f64], held: &[bool], points: usize) {
    for (c, (field, held)) in vector.chunks_exact_mut(points).zip(held).enumerate() {
        let weight = &weight[c * points..][..points];
        let mut mean = 0.0;
        if *held {
            let [total, count] = reduce(
                points,
                &|range| range.filter(|i| weight[*i] > 0.0).fold([0.0; 2], |sums, i| add(sums, [field[i], 1.0])),
                &add,
            );
            mean = if count > 0.0 { total / count } else { 0.0 };
        }
        let keep = |start: usize, [field]: [&mut [f64]; 1]| {
            for (v, weight) in field.iter_mut().zip(&weight[start..]) {
                *v = if *weight > 0.0 { *v - mean } else { 0.0 };
            }
        };
        for_each([field], &keep);
    }
}

fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    for_each([y], &|start, [y]| y.iter_mut().zip(&x[start..]).for_each(|(y, x)| *y += a * x));
}

fn multiply(out: &mut [f64], a: &[f64], b: &[f64]) {
    let leaf = |start: usize, [out]: [&mut [f64]; 1]| {
        out.iter_mut().zip(a[start..].iter().zip(&b[start..])).for_each(|(out, (a, b))| *out = a * b);
    };
    for_each([out], &leaf);
}
