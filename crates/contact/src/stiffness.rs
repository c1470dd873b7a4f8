//! Stiffness of a contact with fixed points in contact: conjugate gradients for the pressure of a uniform displacement
//! of these points (theory.md, section 7.3).

mod few;

use few::Few;
use gfmd_relax::{Ceiling, Preconditioned as _, Why};
use gfmd_vector::{Share, contiguous, for_each};
use ndarray::ArrayRef2;

use crate::dual::Dual;
use crate::pull_push::Known;
use crate::{Contact, Effort, Load, Solution};

/// Stiffness of a contact, d(mean pressure)/d(approach), at fixed points in contact. Points at the hardness keep their
/// pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Value in stress/length. Infinite in full contact with a body with a fixed mean level (periodic half-space,
    /// incompressible slab); NaN for a profile with free boundaries on a half-space, where the displacement is known up
    /// to a constant.
    pub value: f64,
    /// Largest relative error of `value`, from the residual r of the linear problem with fresh transforms. The
    /// compliance of the pressure found exceeds the exact one by a fraction of ⟨r, M r⟩; the preconditioner M bounds
    /// this fraction on both sides, and `value` takes the middle (theory.md, section 7.3).
    pub error: f64,
    /// Effort of the solve.
    pub effort: Effort,
}

impl Stiffness {
    /// Usual tolerance of a stiffness: five digits are certain.
    pub const TOLERANCE: f64 = 5e-6;
}

/// Least excess of the compliance divided by ⟨r, M r⟩ and by the shortest step of the conjugate gradients so far, which
/// is a quotient of the inverse of G and M itself. Chosen; measured: 0.95 to 1.1 (the same surfaces, p* to 0.6).
const OF_STEPS: f64 = 0.75;

/// Largest number of iterations; some 6 are usual.
const ITERATIONS: u64 = 2000;

/// Stiffness of a uniform displacement per point in contact, relative to the largest stiffness, above which it is more
/// than a rounding error of single precision.
const ROUNDING_OF_STIFFNESS: f64 = 1e-4;

/// Residual of points out of contact, so large that the preconditioner does not take them for points about to enter it.
const APART: f32 = 1e30;

impl Contact {
    /// Computes the stiffness in the state `solution` to the relative error `tolerance`; 1e-9 can be reached.
    ///
    /// # Errors
    /// The stiffness reached, if its error exceeds the tolerance, and the reason why the iterations ended.
    pub fn stiffness(&self, solution: &Solution, tolerance: f64) -> Result<Stiffness, (Stiffness, Why)> {
        self.stiffness_of_pressure(&solution.pressure, tolerance)
    }

    /// Computes the stiffness of the points in contact under this `pressure`, stress, as
    /// [`stiffness`](Self::stiffness).
    ///
    /// # Errors
    /// Returns an error as [`stiffness`](Self::stiffness).
    pub fn stiffness_of_pressure(
        &self,
        pressure: &ArrayRef2<f64>,
        tolerance: f64,
    ) -> Result<Stiffness, (Stiffness, Why)> {
        let upper = self.upper().times(self.units().stress());
        self.stiffness_of_points(&contiguous(pressure), upper.ceiling(), tolerance)
    }

    /// Computes the stiffness of the points with a `pressure`, on the own rows, between zero and the `hardness`.
    pub(crate) fn stiffness_of_points(
        &self,
        pressure: &[f64],
        hardness: Ceiling,
        tolerance: f64,
    ) -> Result<Stiffness, (Stiffness, Why)> {
        let n = self.share.total();
        let touches = |(i, p): (usize, &f64)| (*p > 0.0) & (*p < hardness.at(i));
        let own = pressure.iter().enumerate().filter(|point| touches(*point)).count();
        let count: usize = self.share.each(own).into_iter().sum();
        let exact = |value| Ok(Stiffness { value, error: 0.0, effort: Effort::default() });
        if !self.has_level() {
            return Ok(Stiffness { value: f64::NAN, error: f64::NAN, effort: Effort::default() });
        } else if count == 0 {
            return exact(0.0);
        } else if count == n && self.free.is_none() && self.springs.is_none() {
            return exact(self.units().stiffness() / self.uniform_compliance());
        }
        let mut few = Few::of(self, pressure);
        let certified = few.as_mut().and_then(|few| few.solve(tolerance));
        let mut effort = few.map_or(Effort::default(), |few| few.effort());
        let (ended, sums, range) = match certified {
            Some(sums) => (Ok(()), sums, few::RANGE),
            None => {
                let mut unit = Unit::new(self, pressure, hardness, count);
                if !unit.dual.keeps_constants() {
                    unit.keep_sums(self.stiffness_range()[1]);
                }
                let found = unit.solve(tolerance);
                effort.add(unit.effort());
                found
            }
        };
        // ⟨q, G q⟩ of the pressure q with mean 1 is N times the displacement; its lowest value is the one sought.
        let [work, slope] = sums.map(|sum| sum / n as f64);
        let [middle, half] = middle_of(range);
        let compliance = work - middle * slope + self.uniform_compliance();
        let stiffness =
            Stiffness { value: self.units().stiffness() / compliance, error: half * slope.abs() / compliance, effort };
        match ended {
            _ if stiffness.error <= tolerance => Ok(stiffness),
            Ok(()) => Err((stiffness, Why::Certificate)),
            Err(why) => Err((stiffness, why)),
        }
    }
}

/// Returns the middle of a range, and half of its width.
fn middle_of([least, most]: [f64; 2]) -> [f64; 2] {
    [0.5 * (most + least), 0.5 * (most - least)]
}

/// Pressure with mean 1 that displaces all points in contact by the same amount. It has single precision: the stiffness
/// error is quadratic in the pressure error. Displacements are in the [unit](Preconditioned::unit) of the compliance.
struct Unit<'a> {
    dual: Dual<'a>,
    /// Rows of this process, for all fields.
    share: Share,
    /// Pressure of the contact, and hardness: points between zero and the hardness are in contact.
    contact: &'a [f64],
    hardness: Ceiling<'a>,
    /// Number of points in contact.
    count: f64,
    /// Pressure minus its mean over the contact.
    variation: Vec<f32>,
    /// G q on the contact, up to a constant.
    residual: Vec<f32>,
    /// Image of the last step, or the preconditioned residual; empty while fresh transforms need the memory.
    image: Vec<f32>,
    /// M 1 divided by its sum, unless the sum is a rounding error.
    constant: Option<Vec<f32>>,
    iterations: u64,
    /// Shortest step so far, zero before the first.
    shortest: f64,
}

impl<'a> Unit<'a> {
    /// Starts from a uniform pressure on the contact.
    fn new(contact: &'a Contact, pressure: &'a [f64], hardness: Ceiling<'a>, count: usize) -> Self {
        let n = pressure.len();
        Self {
            dual: Dual::new(contact, Load::MeanPressure(1.0)),
            share: contact.share.clone(),
            contact: pressure,
            hardness,
            count: count as f64,
            variation: vec![0.0; n],
            residual: vec![0.0; n],
            image: Vec::new(),
            constant: None,
            iterations: 0,
            shortest: 0.0,
        }
    }

    /// Makes preconditioned residuals have no sum, and constants no effect: M − M 1 1ᵀ M/(1ᵀ M 1). On a half-space M
    /// has this property; on layers displacements, even constant ones, are not continued to distant points. If few
    /// points or none are apart, constants are continued to all of them: M 1 vanishes except for rounding errors of the
    /// `stiffest` wave and would be no direction. Then means are subtracted instead of multiples of M 1, which bounds
    /// the error no less.
    fn keep_sums(&mut self, stiffest: f64) {
        self.residual.fill(1.0);
        self.press(0.0);
        let sum = self.share.total_of(&self.image);
        let rounding = ROUNDING_OF_STIFFNESS * stiffest * self.dual.unit() * self.count;
        self.constant = (sum > rounding).then(|| self.image.iter().map(|z| (f64::from(*z) / sum) as f32).collect());
    }

    fn effort(&self) -> Effort {
        Effort { iterations: self.iterations, transform_pairs: self.dual.pairs() }
    }

    /// Runs conjugate gradients until the error is at most `tolerance`. Also returns ⟨q, G q⟩ and ⟨r, M r⟩ from fresh
    /// transforms in double precision, and the range of the excess divided by ⟨r, M r⟩.
    fn solve(&mut self, tolerance: f64) -> (Result<(), Why>, [f64; 2], [f64; 2]) {
        let mut direction = vec![0.0; self.contact.len()];
        let [mut work, mut slope] = self.begin(&mut direction);
        let (mut last, mut is_fresh) = (f64::INFINITY, false);
        loop {
            let range = [OF_STEPS * self.shortest.clamp(0.0, 1.0), 1.0];
            let enough = tolerance * work / middle_of(range)[1];
            let ended = match slope.abs() <= enough {
                true => Some(Ok(())),
                // A preconditioner that is not positive gives no bound of the error.
                false if slope.is_nan() || slope < 0.0 => Some(Err(Why::NoDescent)),
                false if self.iterations >= ITERATIONS => Some(Err(Why::Iterations)),
                false => None,
            };
            match ended {
                Some(ended) if is_fresh => return (ended, [work, slope], range),
                Some(_) => is_fresh = true,
                None => {
                    self.step(&mut direction, [last, slope]);
                    // If the next slope falls as the last one did, it suffices and is computed from fresh transforms.
                    is_fresh = last.is_finite() && slope * (slope / last) <= enough;
                    last = slope;
                }
            }
            [work, slope] = if is_fresh { self.certify() } else { [work, self.precondition() * self.dual.unit()] };
        }
    }

    /// Sets `pressure` to the uniform pressure. Returns its ⟨q, G q⟩ and ⟨r, M r⟩ from single precision.
    fn begin(&mut self, pressure: &mut [f32]) -> [f64; 2] {
        let (uniform, hardness) = ((self.share.total() as f64 / self.count) as f32, self.hardness);
        for_each((&mut *pressure, self.contact, hardness), &|_, (pressure, contact, hardness)| {
            for (i, (q, p)) in pressure.iter_mut().zip(contact).enumerate() {
                *q = if (*p > 0.0) & (*p < hardness.at(i)) { uniform } else { 0.0 };
            }
        });
        self.displace(pressure);
        std::mem::swap(&mut self.residual, &mut self.image);
        let work = self.share.dot(pressure, &self.residual);
        [work, self.precondition()].map(|sum| sum * self.dual.unit())
    }

    /// Makes a step of conjugate gradients along the `direction` that follows from the preconditioned residual in
    /// `image`; `last` and `slope` are the last and the present ⟨r, M r⟩.
    fn step(&mut self, direction: &mut [f32], [last, slope]: [f64; 2]) {
        let beta = (slope / last) as f32;
        // Rounding errors must not change the sum of the pressure.
        let excess = (self.share.total_of(&self.image) / self.count) as f32;
        let hardness = self.hardness;
        for_each((&mut *direction, &self.image[..], self.contact, hardness), &|_,
                                                                               (
            direction,
            image,
            contact,
            hardness,
        )| {
            for (i, (d, (z, p))) in direction.iter_mut().zip(image.iter().zip(contact)).enumerate() {
                *d = if (*p > 0.0) & (*p < hardness.at(i)) { z - excess + beta * *d } else { 0.0 };
            }
        });
        self.displace(direction);
        let step = slope / self.dual.unit() / self.share.dot(direction, &self.image);
        self.shortest = if self.iterations == 0 { step } else { step.min(self.shortest) };
        let step = step as f32;
        let vectors = (&mut self.variation[..], &mut self.residual[..], &*direction, &self.image[..]);
        for_each(vectors, &|_, (variation, residual, direction, image)| {
            variation.iter_mut().zip(direction).for_each(|(q, d)| *q -= step * d);
            residual.iter_mut().zip(image).for_each(|(r, g)| *r -= step * g);
        });
        self.iterations += 1;
    }

    /// Computes `image` = G `pressure`.
    fn displace(&mut self, pressure: &[f32]) {
        let Self { dual, image, .. } = self;
        image.resize(pressure.len(), 0.0);
        let mut none = vec![(); pressure.len() / dual.stretch()];
        dual.image(pressure, |pressure: &[f32], row| row.copy_from_slice(pressure));
        dual.collect(&mut image[..], |row, image: &mut [f32]| image.copy_from_slice(row), &mut none);
    }

    /// Computes `image` = M (`residual` − `level`), from the residual of the points in contact.
    fn press(&mut self, level: f32) {
        let Self { dual, contact, hardness, residual, image, .. } = self;
        image.resize(contact.len(), 0.0);
        for_each((&mut residual[..], *contact, *hardness), &|_, (residual, contact, hardness)| {
            for (i, (r, p)) in residual.iter_mut().zip(contact).enumerate() {
                *r = if *p >= hardness.at(i) {
                    -APART
                } else if *p > 0.0 {
                    *r
                } else {
                    APART
                };
            }
        });
        dual.press(Known { x: contact, gradient: residual, level, upper: *hardness }, image);
    }

    /// Computes M r. Returns ⟨r, M r⟩.
    fn precondition(&mut self) -> f64 {
        let Self { share, contact, hardness, residual, .. } = &*self;
        let sum = share.sum(&|range| {
            let touching = range.filter(|i| (contact[*i] > 0.0) & (contact[*i] < hardness.at(*i)));
            touching.map(|i| f64::from(residual[i])).sum()
        });
        let level = sum / self.count;
        self.press(level as f32);
        if let Some(constant) = &self.constant {
            let sum = self.share.total_of(&self.image) as f32;
            for_each((&mut self.image[..], &constant[..]), &|_, (image, constant)| {
                image.iter_mut().zip(constant).for_each(|(z, c)| *z -= sum * c);
            });
        }
        let (residual, image) = (&self.residual, &self.image);
        self.share.sum(&|range| {
            let pairs = residual[range.clone()].iter().zip(&image[range]).filter(|(_, z)| **z != 0.0);
            pairs.map(|(r, z)| (f64::from(*r) - level) * f64::from(*z)).sum()
        })
    }

    /// Computes the residual from the pressure in double precision. Returns ⟨q, G q⟩.
    fn refresh(&mut self) -> f64 {
        self.image = Vec::new();
        let Self { dual, share, contact, hardness, count, variation, residual, .. } = self;
        let (n, unit) = (share.total() as f64, dual.unit());
        // Rounding errors have changed the sum.
        let mean = 1.0 + share.total_of(variation) / n;
        let pressure = |p: f64, variation: f32, hardness: f64| {
            if (p > 0.0) & (p < hardness) { (n / *count + f64::from(variation)) / mean } else { 0.0 }
        };
        let source = |(contact, variation, hardness): (&[f64], &[f32], Ceiling), row: &mut [f64]| {
            let all = row.iter_mut().zip(contact.iter().zip(variation)).enumerate();
            all.for_each(|(i, (q, (p, v)))| *q = pressure(*p, *v, hardness.at(i)));
        };
        let mut works = vec![0.0; contact.len() / dual.stretch()];
        type Parts<'a> = (&'a [f64], &'a [f32], &'a mut [f32], Ceiling<'a>);
        let sink = |row: &mut [f64], (contact, variation, residual, hardness): Parts| {
            residual.iter_mut().zip(&*row).for_each(|(r, u)| *r = (u / unit) as f32);
            let all = row.iter().zip(contact.iter().zip(variation)).enumerate();
            all.map(|(i, (u, (p, v)))| u * pressure(*p, *v, hardness.at(i))).sum::<f64>()
        };
        let output = (*contact, &variation[..], &mut residual[..], *hardness);
        dual.displace(((*contact, &variation[..], *hardness), source), (output, sink), &mut works);
        let lengths: Vec<usize> = share.all_rows().iter().map(|rows| rows.len()).collect();
        share.collect(&works, &lengths).iter().sum()
    }

    /// Returns ⟨q, G q⟩ and ⟨r, M r⟩, from fresh transforms in double precision.
    fn certify(&mut self) -> [f64; 2] {
        let work = self.refresh();
        [work, self.precondition() * self.dual.unit()]
    }
}
