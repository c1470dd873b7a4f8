//! Stiffness of a contact with finite slopes: conjugate gradients for the pressure of a small motion of the rigid
//! surface, during which the points in contact slide along it (theory.md, section 7.4).

use gfmd_relax::{Ceiling, Upper, Why};
use gfmd_response::{FullTransforms, NormalTransforms};
use gfmd_vector::{contiguous, for_each};

use super::{SteepContact, SteepSolution};
use crate::{Effort, Stiffness, Units};

/// Largest number of iterations, of rounds from fresh transforms, and of iterations for one lateral displacement.
const ITERATIONS: u64 = 2000;
const ROUNDS: usize = 5;
const LATERAL_ITERATIONS: usize = 200;

/// Residual at which a round ends, and precisions of lateral displacements at its start and in its steps, relative to
/// the square root of the tolerance.
const OF_ROUND: f64 = 0.5;
const OF_START: f64 = 0.1;
const OF_STEP: f64 = 0.03;

/// Relative rounding error of the pressure of points at the hardness.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl SteepContact {
    /// Computes the stiffness in the state `solution`, d(mean pressure)/d(approach) in stress/length, to the relative
    /// error `tolerance`. The points in contact stay in contact and slide along the rigid surface, which does not move
    /// sideways; points at the hardness keep their pressure.
    ///
    /// # Errors
    /// Returns the stiffness reached, if its error exceeds the tolerance, and the reason.
    pub fn stiffness(&self, solution: &SteepSolution, tolerance: f64) -> Result<Stiffness, (Stiffness, Why)> {
        let mut tangent = Tangent::new(self, solution);
        if tangent.count == 0.0 {
            return Ok(Stiffness { value: 0.0, error: 0.0, effort: Effort::default() });
        }
        tangent.solve(tolerance)
    }
}

/// Equilibrium linearised at a state: with the slopes ∇c and the second derivatives of the clearance at the displaced
/// points, a change q of the pressure and a displacement u change the traction by m q + W u, where m = (∇c, −1) and W
/// is the pressure times the second derivatives.
struct Tangent<'a> {
    contact: &'a SteepContact,
    transforms: FullTransforms,
    normal: NormalTransforms,
    /// 1 at the points in contact below the hardness, and their number over all processes.
    free: Vec<f64>,
    count: f64,
    /// ∇c, component by component.
    slopes: Vec<f64>,
    /// W: xx, yy and xy of each point.
    turning: Vec<[f64; 3]>,
    /// Bound of the stiffness of body and W.
    stiffest: f64,
    /// Traction and displacement under the last pressure.
    traction: Vec<f64>,
    displacement: Vec<f64>,
    /// Lowest curvature found relative to the body without W.
    lowest: f64,
    iterations: u64,
}

/// Work of a pressure, with the error of its lateral displacement.
struct Work {
    /// ⟨q, m·u⟩, corrected to second order in the error.
    value: f64,
    /// Bound of the energy of this error.
    error: f64,
}

impl<'a> Tangent<'a> {
    fn new(contact: &'a SteepContact, solution: &SteepSolution) -> Self {
        let (share, [_, ny]) = (contact.share(), contact.surface.grid().points());
        let pressure = contiguous(&solution.normal.pressure);
        let lateral: Vec<_> = solution.lateral.iter().map(|u| contiguous(u)).collect();
        let (points, axes, first) = (pressure.len(), lateral.len(), share.own().start);
        let upper =
            contact.hardness.as_ref().and_then(|hardness| hardness.in_units(&contact.surface, &Units::ONE).ok());
        let ceiling = upper.as_ref().map_or(Ceiling::All(f64::INFINITY), Upper::ceiling);
        let mut free = vec![0.0; points];
        let (mut slopes, mut turning) = (vec![0.0; axes * points], vec![[0.0; 3]; points]);
        let mut steepest = 0.0_f64;
        for (i, p) in pressure.iter().enumerate().filter(|(_, p)| **p > 0.0) {
            free[i] = f64::from(u8::from(*p < (1.0 - ROUNDING) * ceiling.at(i)));
            let (point, offset) =
                ([(first + i) / ny, (first + i) % ny], [0, 1].map(|c| lateral.get(c).map_or(0.0, |u| u[i])));
            let (_, along) = contact.clearance.near(point, offset);
            along.iter().take(axes).enumerate().for_each(|(c, slope)| slopes[c * points + i] = *slope);
            turning[i] = contact.clearance.curvatures_near(point, offset).map(|curvature| p * curvature);
            let [xx, yy, xy] = turning[i];
            steepest = steepest.max(xx.hypot(yy).hypot(std::f64::consts::SQRT_2 * xy));
        }
        let steepest = share.each(steepest).into_iter().fold(0.0, f64::max);
        let [_, stiffest] = contact.full.stiffness_range();
        Self {
            transforms: FullTransforms::of(&contact.full),
            normal: NormalTransforms::of(&contact.normal),
            count: share.total_of(&free),
            free,
            slopes,
            turning,
            stiffest: stiffest + steepest,
            traction: vec![0.0; (axes + 1) * points],
            displacement: vec![0.0; (axes + 1) * points],
            lowest: 1.0,
            iterations: 0,
            contact,
        }
    }

    /// Minimises the work of a pressure with mean 1 at the free points, which is N divided by the stiffness.
    fn solve(&mut self, tolerance: f64) -> Result<Stiffness, (Stiffness, Why)> {
        let (contact, n) = (self.contact, self.contact.share().total() as f64);
        let precision = tolerance.sqrt();
        let mut pressure: Vec<f64> = self.free.iter().map(|free| free * n / self.count).collect();
        let mut residual = vec![0.0; pressure.len()];
        let (mut preconditioned, mut direction) = (residual.clone(), residual.clone());
        let (mut last, mut rounds) = (f64::INFINITY, 0);
        loop {
            let Work { value, error } = self.work(&pressure, OF_START * precision);
            self.along(&mut residual);
            // The excess over the least work is at most the square of the sum of two norms of errors.
            let excess = (self.stiffest * contact.product(&residual, &residual)).sqrt() + error.sqrt();
            let effort =
                Effort { iterations: self.iterations, transform_pairs: self.transforms.pairs() + self.normal.pairs() };
            let found = Stiffness { value: n / value, error: (excess * excess + error) / value.abs(), effort };
            match () {
                () if found.error <= tolerance => return Ok(found),
                () if found.error.is_nan() || self.lowest <= 0.0 => return Err((found, Why::NoDescent)),
                () if self.iterations >= ITERATIONS => return Err((found, Why::Iterations)),
                () if rounds == ROUNDS || found.error > 0.5 * last => return Err((found, Why::Rounding)),
                () => (last, rounds) = (found.error, rounds + 1),
            }
            let enough = (OF_ROUND * precision).powi(2) * value;
            let mut slope = 0.0;
            while self.iterations < ITERATIONS && self.stiffest * contact.product(&residual, &residual) > enough {
                let next = self.precondition(&residual, &mut preconditioned);
                let turn = if slope > 0.0 { next / slope } else { 0.0 };
                slope = next;
                for_each([&mut direction[..]], &|start, [direction]| {
                    direction.iter_mut().zip(&preconditioned[start..]).for_each(|(d, z)| *d = z + turn * *d);
                });
                self.work(&direction, OF_STEP * precision);
                self.along(&mut preconditioned);
                let step = -slope / contact.product(&direction, &preconditioned);
                // Rounding errors may leave no descent.
                if !(step < 0.0 && step.is_finite()) {
                    break;
                }
                add_times(&mut pressure, step, &direction);
                add_times(&mut residual, step, &preconditioned);
                self.iterations += 1;
            }
        }
    }

    /// Computes the displacement under a `pressure` at the free points, with lateral displacements to `precision`
    /// relative to the square root of the work, and the traction.
    fn work(&mut self, pressure: &[f64], precision: f64) -> Work {
        let (contact, points, axes) = (self.contact, pressure.len(), self.slopes.len() / pressure.len());
        let z = axes * points;
        let Self { transforms, traction, displacement, slopes, .. } = self;
        for (traction, slopes) in traction.chunks_exact_mut(points).zip(slopes.chunks_exact(points)) {
            traction.iter_mut().zip(slopes).zip(pressure).for_each(|((t, slope), q)| *t = slope * q);
        }
        traction[z..].iter_mut().zip(pressure).for_each(|(t, q)| *t = -q);
        let own = traction.clone();
        transforms.compliance(traction, displacement);
        let scale = contact.product(&own, &self.displacement);
        // The traction by the lateral displacement, from conjugate gradients with the compliance as preconditioner.
        let mut turned = vec![0.0; z];
        let mut residual = self.turn(&self.displacement[..z]);
        let (mut direction, mut moved) = (residual.clone(), vec![0.0; z]);
        self.transforms.lateral_compliance(&direction, &mut moved);
        let mut image = moved.clone();
        let mut square = contact.product(&residual, &image);
        let enough = precision * precision * scale;
        for _ in 0..LATERAL_ITERATIONS {
            if square.is_nan() || square <= enough {
                break;
            }
            let bent = self.turn(&moved);
            let whole = contact.product(&direction, &moved);
            let curvature = whole - contact.product(&bent, &moved);
            self.lowest = self.lowest.min(curvature / whole);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let step = square / curvature;
            add_times(&mut turned, step, &direction);
            add_times(&mut residual, -step, &direction);
            add_times(&mut residual, step, &bent);
            self.transforms.lateral_compliance(&residual, &mut image);
            let next = contact.product(&residual, &image);
            let turn = next / square;
            for (conjugate, new) in [(&mut direction, &residual), (&mut moved, &image)] {
                for_each([&mut conjugate[..]], &|start, [conjugate]| {
                    conjugate.iter_mut().zip(&new[start..]).for_each(|(p, new)| *p = new + turn * *p);
                });
            }
            square = next;
        }
        add_times(&mut self.traction[..z], 1.0, &turned);
        self.transforms.compliance(&self.traction, &mut self.displacement);
        let mut left = self.turn(&self.displacement[..z]);
        add_times(&mut left, -1.0, &turned);
        let value = contact.product(&own, &self.displacement) + contact.product(&left, &self.displacement[..z]);
        Work { value, error: square.max(0.0) / self.lowest }
    }

    /// Returns W u of a lateral displacement u.
    fn turn(&self, lateral: &[f64]) -> Vec<f64> {
        let points = self.free.len();
        let mut out = vec![0.0; lateral.len()];
        match lateral.len() / points {
            1 => out.iter_mut().zip(lateral).zip(&self.turning).for_each(|((t, u), [xx, ..])| *t = xx * u),
            _ => {
                let (x, y) = out.split_at_mut(points);
                let (ux, uy) = lateral.split_at(points);
                for_each([x, y], &|start, [x, y]| {
                    let of = ux[start..].iter().zip(&uy[start..]).zip(&self.turning[start..]);
                    for ((x, y), ((ux, uy), [xx, yy, xy])) in x.iter_mut().zip(y).zip(of) {
                        (*x, *y) = (xx * ux + xy * uy, xy * ux + yy * uy);
                    }
                });
            }
        }
        out
    }

    /// Computes m·u of the last displacement at the free points, without its mean.
    fn along(&self, out: &mut [f64]) {
        let points = out.len();
        let z = self.slopes.len();
        for_each([&mut *out], &|start, [out]| {
            for (k, out) in out.iter_mut().enumerate() {
                let i = start + k;
                let sideways = (i..z).step_by(points).map(|at| self.slopes[at] * self.displacement[at]);
                *out = self.free[i] * (sideways.sum::<f64>() - self.displacement[z + i]);
            }
        });
        self.remove_mean(out);
    }

    /// Removes the mean over the free points from a field that vanishes elsewhere.
    fn remove_mean(&self, field: &mut [f64]) {
        let mean = self.contact.share().total_of(field) / self.count;
        for_each([field], &|start, [field]| {
            field.iter_mut().zip(&self.free[start..]).for_each(|(x, free)| *x -= mean * free);
        });
    }

    /// Computes the normal stiffness times the residual at the free points, without its mean. Returns the product with
    /// the residual.
    fn precondition(&mut self, residual: &[f64], out: &mut [f64]) -> f64 {
        self.normal.convolve(self.contact.normal.stiffness(), residual, out);
        for_each([&mut *out], &|start, [out]| {
            out.iter_mut().zip(&self.free[start..]).for_each(|(z, free)| *z *= free);
        });
        self.remove_mean(out);
        self.contact.product(residual, out)
    }
}

/// Adds a multiple of a vector.
fn add_times(sum: &mut [f64], factor: f64, by: &[f64]) {
    for_each([sum], &|start, [sum]| sum.iter_mut().zip(&by[start..]).for_each(|(sum, by)| *sum += factor * by));
}
