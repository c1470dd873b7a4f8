//! The stiffness of a contact whose points of contact stay: conjugate gradients for the pressure of a uniform displacement
//! of these points (theory.md, section 7.3).

use gfmd_relax::Why;
use gfmd_vector::{dot, for_each, reduce};

use crate::dual::Dual;
use crate::{Contact, Effort, Fields as _, Load, Solution};

/// The stiffness of a contact, d(mean pressure)/d(approach) with the points in contact kept. Points at the hardness keep their
/// pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// In stress/length. Infinite in full contact with a body whose mean level is fixed (periodic half-space, incompressible
    /// slab); NaN for a profile with free boundaries, whose displacement is known up to a constant.
    pub value: f64,
    /// The relative error of `value`, from the residual of the linear problem with fresh transforms: ⟨r, M r⟩ / ⟨q, G q⟩ with
    /// M the preconditioner, which is at least about the inverse of G on the contact.
    pub error: f64,
    /// Effort of the solve.
    pub effort: Effort,
}

/// The relative error at which the iterations end.
const TOLERANCE: f64 = 1e-10;

/// Largest number of iterations. Some 6 are usual.
const ITERATIONS: u64 = 2000;

/// The residual of points that are not in contact, so large that the preconditioner does not take them for points about to
/// enter it.
const APART: f64 = 1e100;

impl Contact {
    /// The stiffness in the state `solution`.
    ///
    /// # Errors
    /// The stiffness reached, if its error exceeds 1e-9, and the reason why the iterations ended.
    pub fn stiffness(&self, solution: &Solution) -> Result<Stiffness, (Stiffness, Why)> {
        let hardness = self.hardness().unwrap_or(f64::INFINITY);
        let touching: Vec<f64> =
            solution.pressure().iter().map(|p| f64::from(u8::from(*p > 0.0 && *p < hardness))).collect();
        let count = touching.iter().sum::<f64>();
        let exact = |value| Ok(Stiffness { value, error: 0.0, effort: Effort::default() });
        let is_full = count == touching.len() as f64;
        if self.free.is_some() && self.surface().grid().is_line() {
            return Ok(Stiffness { value: f64::NAN, error: f64::NAN, effort: Effort::default() });
        } else if count == 0.0 {
            return exact(0.0);
        } else if is_full && self.free.is_none() {
            return exact(self.units().stiffness() / self.uniform_compliance());
        }
        let mut unit = Unit::new(self, &touching, count);
        if !unit.dual.keeps_constants() {
            unit.keep_sums();
        }
        let ended = unit.solve();
        let n = touching.len() as f64;
        // ⟨q, G q⟩ of the pressure q with mean 1 is N times the displacement, whose lowest value is the one sought.
        let [work, excess] = unit.certify();
        let compliance = work / n + self.uniform_compliance();
        let stiffness = Stiffness {
            value: self.units().stiffness() / compliance,
            error: excess / n / compliance,
            effort: Effort { iterations: unit.iterations, transform_pairs: unit.dual.pairs() },
        };
        match ended {
            _ if stiffness.error <= 10.0 * TOLERANCE => Ok(stiffness),
            Ok(()) => Err((stiffness, Why::Certificate)),
            Err(why) => Err((stiffness, why)),
        }
    }
}

/// The pressure with mean 1 that displaces all points in contact by the same amount.
struct Unit<'a> {
    dual: Dual<'a>,
    /// 1 in contact, else 0.
    touching: &'a [f64],
    pressure: Vec<f64>,
    /// G q on the contact, with any constant added.
    residual: Vec<f64>,
    image: Vec<f64>,
    /// M 1 over its sum, if this does not vanish.
    constant: Option<Vec<f64>>,
    iterations: u64,
}

impl<'a> Unit<'a> {
    /// Starts from a uniform pressure on the contact.
    fn new(contact: &'a Contact, touching: &'a [f64], count: f64) -> Self {
        let n = touching.len();
        let pressure = touching.iter().map(|touches| touches * n as f64 / count).collect();
        let dual = Dual::new(contact, Load::MeanPressure(1.0));
        Self { dual, touching, pressure, residual: vec![0.0; n], image: vec![0.0; n], constant: None, iterations: 0 }
    }

    /// Makes preconditioned residuals have no sum, and constants no effect: M − M 1 1ᵀ M/(1ᵀ M 1). Of a half-space M has this
    /// property; of layers displacements are not continued to distant points, not even constant ones.
    fn keep_sums(&mut self) {
        let touching = self.touching;
        for_each([&mut self.residual], &|start, [residual]| {
            for (r, touches) in residual.iter_mut().zip(&touching[start..]) {
                *r = if *touches > 0.0 { 1.0 } else { APART };
            }
        });
        self.dual.press(touching, &self.residual, 0.0, &mut self.image);
        let image = &self.image;
        let sum = gfmd_vector::sum(image.len(), &|range| image[range].iter().sum());
        self.constant = Some(image.iter().map(|z| z / sum).collect());
    }

    fn solve(&mut self) -> Result<(), Why> {
        let n = self.touching.len();
        let mut direction = vec![0.0; n];
        let mut slope = f64::INFINITY;
        let work = self.refresh();
        loop {
            let last = std::mem::replace(&mut slope, self.precondition());
            if slope <= TOLERANCE * work {
                return Ok(());
            } else if slope.is_nan() {
                return Err(Why::NoDescent);
            } else if self.iterations >= ITERATIONS {
                return Err(Why::Iterations);
            }
            let beta = slope / last;
            let image = &self.image;
            for_each([&mut direction], &|start, [direction]| {
                direction.iter_mut().zip(&image[start..]).for_each(|(d, z)| *d = z + beta * *d);
            });
            self.dual.displace(&direction, &mut self.image);
            let step = slope / dot(&direction, &self.image);
            let (image, touching) = (&self.image, self.touching);
            for_each([&mut self.pressure, &mut self.residual], &|start, [pressure, residual]| {
                let along = direction[start..].iter().zip(&image[start..]).zip(&touching[start..]);
                for ((q, r), ((d, g), touches)) in pressure.iter_mut().zip(residual).zip(along) {
                    *q -= step * d;
                    *r -= step * g * touches;
                }
            });
            self.iterations += 1;
        }
    }

    /// Computes the residual from the pressure; returns ⟨q, G q⟩.
    fn refresh(&mut self) -> f64 {
        self.dual.displace(&self.pressure, &mut self.residual);
        let work = dot(&self.pressure, &self.residual);
        let touching = self.touching;
        for_each([&mut self.residual], &|start, [residual]| {
            for (r, touches) in residual.iter_mut().zip(&touching[start..]) {
                *r = if *touches > 0.0 { *r } else { APART };
            }
        });
        work
    }

    /// `image` ← M r; returns ⟨r, M r⟩.
    fn precondition(&mut self) -> f64 {
        let Self { touching, residual, .. } = &*self;
        let [sum, count] = reduce(
            touching.len(),
            &|range| {
                let inside =
                    residual[range.clone()].iter().zip(&touching[range]).filter(|(_, touches)| **touches > 0.0);
                inside.fold([0.0; 2], |sums, (r, _)| gfmd_vector::add(sums, [*r, 1.0]))
            },
            &gfmd_vector::add,
        );
        let level = sum / count;
        self.dual.press(self.touching, &self.residual, level, &mut self.image);
        if let Some(constant) = &self.constant {
            let image = &self.image;
            let sum = gfmd_vector::sum(image.len(), &|range| image[range].iter().sum());
            for_each([&mut self.image], &|start, [image]| {
                image.iter_mut().zip(&constant[start..]).for_each(|(z, c)| *z -= sum * c);
            });
        }
        let (residual, image) = (&self.residual, &self.image);
        gfmd_vector::sum(residual.len(), &|range| {
            let pairs = residual[range.clone()].iter().zip(&image[range]).filter(|(_, z)| **z != 0.0);
            pairs.map(|(r, z)| (r - level) * z).sum()
        })
    }

    /// ⟨q, G q⟩ and ⟨r, M r⟩, from fresh transforms.
    fn certify(&mut self) -> [f64; 2] {
        let work = self.refresh();
        [work, self.precondition()]
    }
}
