//! Transpose of the shear of an increment: one linear problem of the sticking points and of the directions across the
//! slip, with both sets kept (theory.md, section 7.9).

use gfmd_vector::dot;

use super::{AT_LIMIT, ShearStep, lengths, limits_of};
use crate::quasistatic::normal::NormalState;
use crate::quasistatic::parts::LimitingPressure;

/// Residual at which the iterations end, relative to the largest residual at the start of a solve so far.
const TOLERANCE: f64 = 1e-11;
/// Largest number of iterations.
const ITERATIONS: u64 = 5000;

/// Response of the shear of a point to small changes of its slip and its limit.
#[derive(Clone, Copy)]
enum Motion {
    /// There is no shear.
    Free,
    /// The slip stays zero.
    Sticks,
    /// The shear stays at the limit along `direction`; the slip across it is −`compliance` times the shear across it.
    Slips { direction: [f64; 2], compliance: f64 },
}

/// Derivatives of a number with respect to fields that the shear of an increment changes. Tractions are divided by the
/// common stiffening of the step.
pub(in crate::quasistatic) struct ByShear<'a> {
    /// With respect to the shear traction.
    pub(in crate::quasistatic) traction: &'a [f64],
    /// With respect to the lateral displacement at the end.
    pub(in crate::quasistatic) displacement: &'a [f64],
    /// With respect to the slip.
    pub(in crate::quasistatic) slip: &'a [f64],
    /// With respect to the displacement along z caused by the shear.
    pub(in crate::quasistatic) lift: &'a [f64],
}

/// Derivatives of a number with respect to what determines the shear of an increment. Tractions are divided by the
/// common stiffening of the step.
pub(in crate::quasistatic) struct ShearGradient {
    /// With respect to the pressure at each point.
    pub(in crate::quasistatic) pressure: Vec<f64>,
    /// With respect to the lateral displacement of the elastic surface without slip.
    pub(in crate::quasistatic) stuck: Vec<f64>,
    /// With respect to the lateral residual indentation of the body.
    pub(in crate::quasistatic) base: Vec<f64>,
    /// With respect to the logarithm of the moduli.
    pub(in crate::quasistatic) modulus: f64,
    /// With respect to the friction coefficient and the shear strength.
    pub(in crate::quasistatic) limit: [f64; 2],
    /// Error of the linear problem, from its residual with fresh transforms, relative to the largest problem so far.
    pub(in crate::quasistatic) error: f64,
}

impl ShearGradient {
    /// Adds the derivatives of another number.
    pub(in crate::quasistatic) fn add(&mut self, other: &Self) {
        let fields = [(&mut self.pressure, &other.pressure), (&mut self.stuck, &other.stuck)];
        for (sum, by) in fields.into_iter().chain([(&mut self.base, &other.base)]) {
            sum.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        }
        self.modulus += other.modulus;
        self.limit = gfmd_vector::add(self.limit, other.limit);
        self.error = self.error.max(other.error);
    }
}

/// Linear problem of small changes of the shear of a solved increment.
pub(in crate::quasistatic) struct ShearAdjoint {
    step: ShearStep,
    motions: Vec<Motion>,
    /// Pressure that sets the limit at each point; 0 where no pressure does.
    limiting: Vec<f64>,
    /// Displacement caused by pressure and shear together.
    elastic: Vec<f64>,
    /// Stiffness of a wave of middle length.
    stiffness: f64,
    /// Square of the largest residual at the start of a solve so far.
    largest: f64,
    /// Number of iterations so far.
    pub(in crate::quasistatic) iterations: u64,
}

impl ShearStep {
    /// Places the step at a shear `traction`, not divided, and the slip of an increment that was solved.
    pub(in crate::quasistatic) fn place(&mut self, traction: &[f64], slip: &[f64]) {
        let (points, factor) = (self.points(), self.factor);
        self.traction.iter_mut().zip(traction).for_each(|(shear, t)| *shear = t / factor);
        self.transforms.compliance(&self.traction, &mut self.displacement);
        self.lift.copy_from_slice(&self.displacement[self.stuck.len()..]);
        if !self.slipped.is_empty() {
            self.slipped = lengths(slip, points).collect();
        }
    }

    /// Returns the linear problem of the shear at which the step was [placed](Self::place), with the pressure of
    /// `state` and the slip of the increment.
    pub(in crate::quasistatic) fn adjoint(mut self, state: &NormalState, slip: &[f64]) -> ShearAdjoint {
        let (points, lateral) = (self.points(), self.stuck.len());
        let limits = limits_of(&self.shear, self.factor, state);
        let component = |field: &[f64], i: usize| {
            let mut vector = [0.0; 2];
            vector.iter_mut().zip(field.chunks_exact(points)).for_each(|(value, field)| *value = field[i]);
            vector
        };
        let motion = |(i, limit): (usize, &f64)| {
            let shear = component(&self.traction[..lateral], i);
            let size = shear[0].hypot(shear[1]);
            let [x, y] = component(slip, i);
            match () {
                () if *limit <= 0.0 => Motion::Free,
                () if size < limit * (1.0 - AT_LIMIT) => Motion::Sticks,
                () => Motion::Slips { direction: shear.map(|t| t / size), compliance: x.hypot(y) / limit },
            }
        };
        let motions = limits.iter().enumerate().map(motion).collect();
        let (repulsion, pressure) = (state.repulsion(), state.pressure());
        let limiting = |(r, p): (&f64, &f64)| match self.shear.pressure {
            LimitingPressure::Repulsion => r.max(0.0),
            LimitingPressure::Net if *r > 0.0 => p.max(0.0),
            LimitingPressure::Net => 0.0,
        };
        let limiting = repulsion.iter().zip(&pressure).map(limiting).collect();
        let traction = Self::traction(&self.traction[..lateral], state);
        let mut elastic = vec![0.0; traction.len()];
        self.transforms.compliance(&traction, &mut elastic);
        let stiffness = (self.softest * self.stiffest).sqrt();
        ShearAdjoint { step: self, motions, limiting, elastic, stiffness, largest: 0.0, iterations: 0 }
    }
}

impl ShearAdjoint {
    /// Returns the number of transform pairs so far.
    pub(in crate::quasistatic) fn pairs(&self) -> f64 {
        self.step.pairs()
    }

    /// Computes the derivatives of a number from its derivatives `by` the fields of the increment.
    pub(in crate::quasistatic) fn solve(&mut self, by: &ByShear) -> ShearGradient {
        let (lateral, points) = (self.step.stuck.len(), self.limiting.len());
        let moved: Vec<f64> = by.displacement.iter().zip(by.slip).map(|(u, s)| u + s).collect();
        let none = vec![0.0; points];
        let of_moved = self.displaced(&moved, &none);
        let of_lift = self.displaced(&vec![0.0; lateral], by.lift);
        let sum = |k: usize| by.traction[k] + of_moved[k] + of_lift[k];
        let by_traction: Vec<f64> = (0..lateral).map(sum).collect();
        let mut source = by_traction.clone();
        self.project(&mut source);
        let (adjoint, error) = self.conjugate_gradients(&source);
        let image = self.displaced(&adjoint, &none);

        let Self { step, motions, limiting, elastic, .. } = self;
        let (limit, factor) = (step.shear.limit, step.factor);
        let mut pressure: Vec<f64> = (lateral..lateral + points).map(|k| image[k] - of_moved[k]).collect();
        let mut by_limit = [0.0; 2];
        for (i, motion) in motions.iter().enumerate() {
            let Motion::Slips { direction, .. } = motion else { continue };
            let along = |(c, n): (usize, &f64)| n * (by_traction[c * points + i] - image[c * points + i]);
            let by: f64 = direction.iter().take(lateral / points).enumerate().map(along).sum();
            let limiting = factor * limiting[i];
            pressure[i] += by * limit.slope(limiting);
            by_limit.iter_mut().zip(limit.by_parameters(limiting)).for_each(|(sum, of)| *sum += by * of / factor);
        }
        let base: Vec<f64> = adjoint.iter().zip(&moved).map(|(z, v)| z - v).collect();
        let modulus = dot(&base, &elastic[..lateral]) - dot(by.lift, &step.lift);
        let stuck = adjoint.iter().zip(by.slip).map(|(z, s)| z - s).collect();
        ShearGradient { pressure, stuck, base, modulus, limit: by_limit, error }
    }

    /// Returns the displacement, with all components, caused by a traction.
    fn displaced(&mut self, shear: &[f64], normal: &[f64]) -> Vec<f64> {
        let traction = [shear, normal].concat();
        let mut displacement = vec![0.0; traction.len()];
        self.step.transforms.compliance(&traction, &mut displacement);
        displacement
    }

    /// Projects a lateral field on the directions in which the shear can change at a given limit.
    fn project(&self, field: &mut [f64]) {
        let points = self.motions.len();
        let (x, y) = field.split_at_mut(points);
        for (i, motion) in self.motions.iter().enumerate() {
            match (motion, y.get_mut(i)) {
                (Motion::Sticks, _) => {}
                (Motion::Slips { direction: [n_x, n_y], .. }, Some(y)) => {
                    let across = n_x * *y - n_y * x[i];
                    (x[i], *y) = (-n_y * across, n_x * across);
                }
                (Motion::Free | Motion::Slips { .. }, y) => {
                    x[i] = 0.0;
                    y.into_iter().for_each(|y| *y = 0.0);
                }
            }
        }
    }

    /// Multiplies a lateral field by a number at each point that slips, a function of its compliance.
    fn scale(&self, field: &mut [f64], of: impl Fn(f64) -> f64) {
        for field in field.chunks_exact_mut(self.motions.len()) {
            for (value, motion) in field.iter_mut().zip(&self.motions) {
                if let Motion::Slips { compliance, .. } = motion {
                    *value *= of(*compliance);
                }
            }
        }
    }

    /// Computes `out` = (P G P + D) `shear`, with the projection P and the compliances D of the points that slip.
    fn apply(&mut self, shear: &[f64], out: &mut [f64]) {
        self.step.transforms.lateral_compliance(shear, out);
        self.project(out);
        let points = self.motions.len();
        for (out, shear) in out.chunks_exact_mut(points).zip(shear.chunks_exact(points)) {
            for ((out, shear), motion) in out.iter_mut().zip(shear).zip(&self.motions) {
                if let Motion::Slips { compliance, .. } = motion {
                    *out += compliance * shear;
                }
            }
        }
    }

    /// Computes `out`, an approximation of (P G P + D)⁻¹ `residual`: the stiffness of the surface where the points
    /// hardly slip, the inverse of their compliance where it is large.
    fn precondition(&mut self, residual: &[f64], out: &mut [f64]) {
        let k = self.stiffness;
        let mut own = residual.to_vec();
        self.scale(&mut own, |compliance| (1.0 + k * compliance).sqrt().recip());
        if !self.step.transforms.lateral_stiffness(&own, out) {
            out.iter_mut().zip(&own).for_each(|(out, own)| *out = k * own);
        }
        self.project(out);
        self.scale(out, |compliance| (1.0 + k * compliance).sqrt().recip());
        let points = self.motions.len();
        for (out, residual) in out.chunks_exact_mut(points).zip(residual.chunks_exact(points)) {
            for ((out, residual), motion) in out.iter_mut().zip(residual).zip(&self.motions) {
                if let Motion::Slips { compliance, .. } = motion {
                    *out += k * (k * compliance / (1.0 + k * compliance).powi(2)) * residual;
                }
            }
        }
    }

    /// Solves (P G P + D) z = `source`; also returns the error relative to the largest source so far.
    fn conjugate_gradients(&mut self, source: &[f64]) -> (Vec<f64>, f64) {
        let n = source.len();
        let (mut z, mut residual) = (vec![0.0; n], source.to_vec());
        let (mut image, mut direction) = (vec![0.0; n], vec![0.0; n]);
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            self.precondition(&residual, &mut image);
            let slope = dot(&residual, &image);
            if last == f64::INFINITY {
                self.largest = self.largest.max(slope);
            }
            let goes_on = slope > TOLERANCE * TOLERANCE * self.largest;
            if !goes_on {
                break;
            }
            let beta = slope / last;
            direction.iter_mut().zip(&image).for_each(|(d, z)| *d = z + beta * *d);
            self.apply(&direction, &mut image);
            let step = slope / dot(&direction, &image);
            z.iter_mut().zip(&direction).for_each(|(z, d)| *z += step * d);
            residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= step * image);
            last = slope;
            self.iterations += 1;
        }
        self.apply(&z, &mut image);
        residual.iter_mut().zip(source).zip(&image).for_each(|((r, source), image)| *r = source - image);
        self.precondition(&residual, &mut image);
        let left = dot(&residual, &image).abs();
        (z, if left == 0.0 { 0.0 } else { (left / self.largest).sqrt() })
    }
}
