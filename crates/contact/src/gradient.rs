//! Derivatives of a number of a contact with respect to heights, load and modulus, from one linear problem on the
//! points in contact (theory.md, section 7.9).

use gfmd_relax::{Ceiling, Upper};
use gfmd_response::NormalTransforms;
use gfmd_vector::{contiguous, dot, for_each, total};
use ndarray::{Array2, Array3, ArrayRef2};

use crate::compliance::Compliance;
use crate::springs;
use crate::{Contact, Effort, Load, RigidSurface, Solution};

/// Derivatives of a number L with respect to the fields of a contact, ∂L/∂p and ∂L/∂g at each point `[x, y]`, and with
/// respect to its numbers. Omitted fields have zero derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cotangents {
    /// Derivative with respect to the pressure at each point.
    pub pressure: Option<Array2<f64>>,
    /// Derivative with respect to the gap at each point.
    pub gap: Option<Array2<f64>>,
    /// Derivative with respect to the approach.
    pub approach: f64,
    /// Derivative with respect to the mean pressure.
    pub mean_pressure: f64,
    /// Derivative with respect to the mean gap.
    pub mean_gap: f64,
    /// Derivative with respect to the elastic energy per area.
    pub elastic_energy: f64,
    /// Derivative with respect to the depth pressed in at each point, of a contact with a hardness.
    pub plastic_depth: Option<Array2<f64>>,
    /// Derivative with respect to the shear traction `[component, x, y]`, of surfaces that shear each other.
    pub shear: Option<Array3<f64>>,
    /// Derivative with respect to the mean shear traction along x and y, of surfaces that shear each other.
    pub mean_shear: [f64; 2],
}

/// Derivatives of a number L with respect to the input of a contact, at fixed points in contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// Derivative with respect to the height of each point, peaks towards the body.
    pub heights: Array2<f64>,
    /// Derivative with respect to the prescribed mean pressure or approach.
    pub load: f64,
    /// Derivative with respect to E*, with all moduli of the body and the stiffness of springs in proportion, at the
    /// same mean pressure, approach, and hardness.
    pub modulus: f64,
    /// Derivative with respect to the hardness of each point; `None` without a hardness.
    pub hardness: Option<Array2<f64>>,
    /// Relative error of the linear problem, from its residual with fresh transforms.
    pub error: f64,
    /// Effort of the linear problem.
    pub effort: Effort,
}

/// Derivatives of a number L with respect to the input of a contact, with the clearance of each point in the place of
/// the heights.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceGradient {
    /// Derivative with respect to the clearance of each point, at a fixed zero of the approach.
    pub clearance: Array2<f64>,
    /// Derivative with respect to the prescribed mean pressure or approach.
    pub load: f64,
    /// Derivative with respect to E*, with all moduli of the body in proportion to it.
    pub modulus: f64,
    /// Derivative with respect to the hardness of each point; `None` without a hardness.
    pub hardness: Option<Array2<f64>>,
    /// Relative error of the linear problem, from its residual with fresh transforms.
    pub error: f64,
    /// Effort of the linear problem.
    pub effort: Effort,
}

impl ClearanceGradient {
    /// Adds the derivatives of another number of the same contact, with their effort. The error is kept.
    pub fn add(&mut self, other: &Self) {
        self.clearance += &other.clearance;
        self.load += other.load;
        self.modulus += other.modulus;
        if let (Some(sum), Some(by)) = (&mut self.hardness, &other.hardness) {
            *sum += by;
        }
        self.effort.iterations += other.effort.iterations;
        self.effort.transform_pairs += other.effort.transform_pairs;
    }

    /// Converts the clearance to the heights of a `surface`, with an approach measured from its highest point.
    pub fn by_heights(self, surface: &RigidSurface) -> Gradient {
        let Self { clearance, load, modulus, hardness, error, effort } = self;
        Gradient { heights: surface.by_heights(&clearance), load, modulus, hardness, error, effort }
    }
}

impl RigidSurface {
    /// Returns the derivatives with respect to the height of each point, peaks towards the body, from the derivatives
    /// with respect to its clearance: an approach is measured from the highest point.
    pub fn by_heights(&self, by_clearance: &ArrayRef2<f64>) -> Array2<f64> {
        let mut heights = by_clearance.mapv(|by| -by);
        let points = self.clearance().iter().enumerate();
        let lowest = points.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(place, _)| place);
        let columns = heights.ncols();
        heights[[lowest / columns, lowest % columns]] += total(&contiguous(by_clearance));
        heights
    }
}

/// Reasons why a contact has no derivative.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GradientError {
    /// The number depends on a field that the contact does not have.
    #[error("the derivative by the {name} is given; it must be left out, since the contact has none")]
    Absent {
        /// Name of the field.
        name: &'static str,
    },
    /// Several processes share the contact.
    #[error("several processes share the contact; one process must have it")]
    Shared,
    /// A field differs in shape from the contact.
    #[error(
        "the shape of the derivative by the {name} is {found:?}; it must be {expected:?}, the shape of the contact"
    )]
    Shape {
        /// Name of the field.
        name: &'static str,
        /// Shape of the field.
        found: Vec<usize>,
        /// Shape of the contact.
        expected: Vec<usize>,
    },
    /// A derivative is not finite.
    #[error("the derivative by the {name} has {found}; it must be finite")]
    Number {
        /// Name of the field or number.
        name: &'static str,
        /// Value of the derivative.
        found: f64,
    },
    /// The interface has lateral displacements.
    #[error(
        "all components of displacement are unknown; u_z alone must be, since other derivatives are not implemented"
    )]
    Components,
    /// The state of the interface is not a minimum of the energy.
    #[error(
        "the state is at the edge of stability or beyond (curvature {lowest:.1e}); it must be stable, since a small \
         change makes it jump"
    )]
    Unstable {
        /// Lowest curvature found, divided by the curvature of the preconditioner.
        lowest: f64,
    },
    /// The load does not determine the pressure.
    #[error("{0}")]
    Undetermined(&'static str),
    /// The linear problem was not solved.
    #[error(
        "the relative error of the derivative is {error:.1e} after {iterations} iterations; it must be at most 1e-8"
    )]
    Inexact {
        /// Relative error reached.
        error: f64,
        /// Number of iterations.
        iterations: u64,
    },
}

/// Relative difference to the hardness below which a pressure is the hardness up to rounding errors.
const ROUNDING_OF_HARDNESS: f64 = 8.0 * f64::EPSILON;

/// Smallest residual at which the iterations end, relative to the residual at the start.
const TOLERANCE: f64 = 1e-11;

/// Largest error of a result.
const ERROR: f64 = 1e-8;

/// Residual at the start, relative to the residual without the projection, below which errors count relative to this
/// part of it; and residual at which the iterations end in any case.
const LEAST: f64 = 1e-6;
const ROUNDING: f64 = 1e-15;

/// Largest number of iterations; 20 to 40 are usual.
const ITERATIONS: u64 = 2000;

/// Stiffness of a uniform displacement per point in contact, relative to the largest stiffness, below which it is a
/// rounding error.
const ROUNDING_OF_STIFFNESS: f64 = 1e-8;

impl Contact {
    /// Computes the derivatives of a number in the state `solution` under a `load` of the prescribed kind, from the
    /// derivatives `of` the number. The points in contact and those at the hardness are kept, as they are for almost
    /// all heights and loads.
    ///
    /// # Errors
    /// A contact of several processes, without elastic contact under a mean pressure, or in full contact under an
    /// approach that does not determine its pressure; derivatives that differ in shape, are not finite, or belong to
    /// fields that the contact does not have; a linear problem that was not solved.
    pub fn gradient(&self, solution: &Solution, load: Load, of: &Cotangents) -> Result<Gradient, GradientError> {
        let Solution { pressure, displacement, .. } = solution;
        let found = self.gradient_by_clearance((pressure, displacement), load, of, TOLERANCE)?;
        Ok(found.by_heights(&self.scaled))
    }

    /// Computes the derivatives as [`gradient`](Self::gradient), with the clearance in the place of the heights, in the
    /// state with this pressure and displacement u_z, from a linear problem solved to a relative residual of
    /// `tolerance`, at least 1e-11. Springs below the surface have a share in the derivative by the modulus if the
    /// displacement contains them.
    ///
    /// # Errors
    /// As [`gradient`](Self::gradient).
    pub fn gradient_by_clearance(
        &self,
        (pressure, displacement): (&ArrayRef2<f64>, &ArrayRef2<f64>),
        load: Load,
        of: &Cotangents,
        tolerance: f64,
    ) -> Result<ClearanceGradient, GradientError> {
        let grid = *self.response.grid();
        let (shape, n) = (grid.points(), grid.len());
        if self.share.own().len() != n {
            return Err(GradientError::Shared);
        }
        of.check(shape, self.hardness.is_some(), 0)?;
        // All values below are in the units of the solve.
        let units = self.units();
        let (stress, length, energy) = (units.stress(), units.length(), units.energy());
        let in_units = |field: &ArrayRef2<f64>, unit: f64| -> Vec<f64> { field.iter().map(|x| x / unit).collect() };
        let pressure = in_units(pressure, stress);
        let sunk = in_units(displacement, -length);
        let upper = self.hardness.as_ref().map_or(Ceiling::All(f64::INFINITY), Upper::ceiling);
        let is_plastic = |i: usize| pressure[i] >= (1.0 - ROUNDING_OF_HARDNESS) * upper.at(i);
        // Points of the linear problem, where the pressure can change.
        let inside: Vec<f64> =
            pressure.iter().enumerate().map(|(i, p)| f64::from(u8::from(*p > 0.0 && !is_plastic(i)))).collect();
        let count = total(&inside);
        let approach = of.approach * length;
        let is_driven = matches!(load, Load::Approach(_));
        if count == 0.0 && !is_driven {
            return Err(GradientError::Undetermined(
                "no point is in elastic contact; there must be some under a mean pressure",
            ));
        }
        if count == n as f64 && is_driven && self.has_fixed_mean() {
            let reason = "all points are in contact, of a body whose mean level is fixed; the approach does not \
                          determine the pressure";
            return Err(GradientError::Undetermined(reason));
        }
        let at = |field: &Option<Array2<f64>>, i: usize| {
            field.as_ref().map_or(0.0, |field| field[[i / shape[1], i % shape[1]]])
        };
        // ∂L/∂g out of contact, where the gaps change; at the hardness, the depth pressed in changes instead.
        let open = |(i, inside): (usize, &f64)| match () {
            () if *inside > 0.0 => 0.0,
            () if is_plastic(i) => -length * at(&of.plastic_depth, i),
            () => length * (at(&of.gap, i) + of.mean_gap / n as f64),
        };
        let gap: Vec<f64> = inside.iter().enumerate().map(open).collect();
        let opened = total(&gap);
        let mut problem = Problem::new(self, &inside, is_driven);
        // ∂L/∂p in contact, with the effect of the pressure on all other numbers.
        let mut source = vec![0.0; n];
        problem.displace(&gap, &mut source);
        for (i, source) in source.iter_mut().enumerate() {
            let of_mean = if is_driven { of.mean_pressure * stress } else { 0.0 };
            let of_energy = of.elastic_energy * energy * sunk[i];
            *source += at(&of.pressure, i) * stress + (of_mean + of_energy) / n as f64;
        }
        let by_pressure = self.hardness.as_ref().map(|_| source.clone());
        source.iter_mut().zip(&inside).for_each(|(source, inside)| *source *= inside);
        let sum = if is_driven { None } else { Some(opened - approach) };
        let Adjoint { pressure: adjoint, level, error } = problem.solve(&source, sum, tolerance.max(TOLERANCE));
        // ∂L/∂p less the share of the adjoint, where the pressure is the hardness.
        let hardness = by_pressure.map(|mut by_pressure| {
            let mut image = vec![0.0; n];
            problem.displace(&adjoint, &mut image);
            for (i, (by, image)) in by_pressure.iter_mut().zip(&image).enumerate() {
                *by = if is_plastic(i) { (*by - image - level) / stress } else { 0.0 };
            }
            Array2::from_shape_fn(shape, |(i, j)| by_pressure[i * shape[1] + j])
        });
        let effort = Effort { iterations: problem.iterations, transform_pairs: problem.pairs() };
        if error.is_nan() || error > ERROR.max(2.0 * tolerance) {
            return Err(GradientError::Inexact { error, iterations: problem.iterations });
        }
        let by_approach = total(&adjoint) - opened;
        let by_load =
            if is_driven { by_approach / length + of.approach } else { level * n as f64 / stress + of.mean_pressure };
        let stored = 0.5 * dot(&pressure, &sunk) / n as f64;
        let by_modulus = dot(&adjoint, &sunk) - dot(&gap, &sunk) - of.elastic_energy * energy * stored;
        let by_clearance = |i: usize| (gap[i] - adjoint[i]) / length;
        Ok(ClearanceGradient {
            clearance: Array2::from_shape_fn(shape, |(i, j)| by_clearance(i * shape[1] + j)),
            load: by_load,
            modulus: by_modulus / (self.response.contact_modulus() * units.modulus()),
            hardness,
            error,
            effort,
        })
    }
}

impl Cotangents {
    /// Checks that the fields have the shape of the contact, that it has a hardness (`is_hard`) and this number of
    /// `lateral` components of shear if the number depends on them, and that all values are finite.
    ///
    /// # Errors
    /// A field that differs in shape or that the contact does not have, a number that is not finite.
    pub fn check(&self, expected: [usize; 2], is_hard: bool, lateral: usize) -> Result<(), GradientError> {
        let shear = [lateral, expected[0], expected[1]];
        let fields = [
            ("pressure", self.pressure.as_ref().map(|field| field.view().into_dyn()), &expected[..], true),
            ("gap", self.gap.as_ref().map(|field| field.view().into_dyn()), &expected[..], true),
            ("plastic depth", self.plastic_depth.as_ref().map(|field| field.view().into_dyn()), &expected[..], is_hard),
            ("shear traction", self.shear.as_ref().map(|field| field.view().into_dyn()), &shear[..], lateral > 0),
        ];
        for (name, field, expected, is_known) in fields {
            let Some(field) = field else { continue };
            if !is_known {
                return Err(GradientError::Absent { name });
            }
            if field.shape() != expected {
                return Err(GradientError::Shape { name, found: field.shape().into(), expected: expected.into() });
            }
            if let Some(&found) = field.iter().find(|value| !value.is_finite()) {
                return Err(GradientError::Number { name, found });
            }
        }
        let [shear_x, shear_y] = self.mean_shear;
        if self.mean_shear.iter().skip(lateral).any(|by| *by != 0.0) {
            return Err(GradientError::Absent { name: "mean shear traction" });
        }
        for (name, found) in [
            ("approach", self.approach),
            ("mean pressure", self.mean_pressure),
            ("mean gap", self.mean_gap),
            ("elastic energy", self.elastic_energy),
            ("mean shear traction", shear_x + shear_y),
        ] {
            if !found.is_finite() {
                return Err(GradientError::Number { name, found });
            }
        }
        Ok(())
    }
}

/// Solution of G y + μ = a on the contact.
struct Adjoint {
    pressure: Vec<f64>,
    level: f64,
    error: f64,
}

/// Linear problem of the points in contact, in double precision, preconditioned by the stiffness of the whole surface.
struct Problem<'a> {
    contact: &'a Contact,
    compliance: Compliance,
    stiffness: NormalTransforms,
    /// 1 for the points in contact, else 0.
    inside: &'a [f64],
    count: f64,
    /// Compliance and stiffness of the uniform mode.
    uniform: [f64; 2],
    /// M 1 and its sum, unless the sum is a rounding error.
    constant: Option<(Vec<f64>, f64)>,
    iterations: u64,
}

impl<'a> Problem<'a> {
    fn new(contact: &'a Contact, inside: &'a [f64], is_driven: bool) -> Self {
        let stiffness = match contact.level_under(Load::Approach(0.0)) {
            Some([_, stiffness]) if is_driven => stiffness,
            _ => 0.0,
        };
        let mut problem = Self {
            contact,
            compliance: Compliance::of(contact),
            stiffness: NormalTransforms::of(&contact.response),
            inside,
            count: total(inside),
            uniform: [contact.uniform_compliance(), stiffness],
            constant: None,
            iterations: 0,
        };
        if !is_driven {
            let mut image = vec![0.0; inside.len()];
            problem.press(inside, &mut image);
            let sum = total(&image);
            let [_, stiffest] = contact.stiffness_range();
            problem.constant = (sum > ROUNDING_OF_STIFFNESS * stiffest * problem.count).then_some((image, sum));
        }
        problem
    }

    fn pairs(&self) -> f64 {
        self.compliance.pairs() + self.stiffness.pairs()
    }

    /// Computes `out` = G `pressure`.
    fn displace(&mut self, pressure: &[f64], out: &mut [f64]) {
        self.compliance.apply(self.contact.response.compliance(), pressure, out);
        let sunk = self.uniform[0] * total(pressure) / pressure.len() as f64;
        for_each([&mut *out], &|_, [out]| out.iter_mut().for_each(|out| *out += sunk));
        if let Some(springs) = &self.contact.springs {
            springs::add(springs, pressure, out);
        }
    }

    /// Computes `out` = a − G `pressure` in contact, 0 elsewhere.
    fn residual(&mut self, source: &[f64], pressure: &[f64], out: &mut [f64]) {
        self.displace(pressure, out);
        for_each((out, source, self.inside), &|_, (out, source, inside): (&mut [f64], &[f64], &[f64])| {
            out.iter_mut()
                .zip(source.iter().zip(inside))
                .for_each(|(out, (source, inside))| *out = inside * (source - *out));
        });
    }

    /// Computes `out` = K `residual` in contact, 0 elsewhere.
    fn press(&mut self, residual: &[f64], out: &mut [f64]) {
        self.stiffness.convolve(self.contact.response.stiffness(), residual, out);
        let level = self.uniform[1] * total(residual) / residual.len() as f64;
        for_each((out, self.inside), &|_, (out, inside): (&mut [f64], &[f64])| {
            out.iter_mut().zip(inside).for_each(|(out, inside)| *out = inside * (*out + level));
        });
    }

    /// Computes `out` = M `residual`; `out` has no sum if the sum of the pressure is prescribed (`keeps_sum`).
    fn precondition(&mut self, residual: &[f64], keeps_sum: bool, out: &mut [f64]) {
        self.press(residual, out);
        if !keeps_sum {
            return;
        }
        if let Some((constant, sum)) = &self.constant {
            let factor = total(out) / sum;
            out.iter_mut().zip(constant).for_each(|(out, constant)| *out -= factor * constant);
        }
        let mean = total(out) / self.count;
        out.iter_mut().zip(self.inside).for_each(|(out, inside)| *out -= mean * inside);
    }

    /// Solves G y + μ = a on the contact for the given `sum` of y; without a `sum`, solves G y = a.
    fn solve(&mut self, source: &[f64], sum: Option<f64>, tolerance: f64) -> Adjoint {
        let n = source.len();
        let start = sum.map_or(0.0, |sum| sum / self.count);
        let mut pressure: Vec<f64> = self.inside.iter().map(|inside| start * inside).collect();
        if self.count == 0.0 {
            return Adjoint { pressure, level: 0.0, error: 0.0 };
        }
        let (mut residual, mut image, mut direction) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        self.residual(source, &pressure, &mut residual);
        // A source whose projection is a rounding error has no residual of its own to reduce.
        let whole = if sum.is_some() {
            self.press(source, &mut image);
            dot(source, &image)
        } else {
            0.0
        };
        let (mut first, mut last) = (0.0, f64::INFINITY);
        loop {
            self.precondition(&residual, sum.is_some(), &mut image);
            let slope = dot(&residual, &image);
            if self.iterations == 0 {
                first = slope.max(LEAST * LEAST * whole);
            }
            let least = (tolerance * tolerance * first).max(ROUNDING * ROUNDING * whole);
            let goes_on = slope > least && self.iterations < ITERATIONS;
            if !goes_on {
                break;
            }
            let beta = slope / last;
            for_each((&mut direction[..], &image[..]), &|_, (direction, image): (&mut [f64], &[f64])| {
                direction.iter_mut().zip(image).for_each(|(d, z)| *d = z + beta * *d);
            });
            self.displace(&direction, &mut image);
            let step = slope / dot(&direction, &image);
            let vectors = (&mut pressure[..], &mut residual[..], &direction[..], &image[..], self.inside);
            type Parts<'a> = (&'a mut [f64], &'a mut [f64], &'a [f64], &'a [f64], &'a [f64]);
            for_each(vectors, &|_, (pressure, residual, direction, image, inside): Parts| {
                pressure.iter_mut().zip(direction).for_each(|(y, d)| *y += step * d);
                residual.iter_mut().zip(image.iter().zip(inside)).for_each(|(r, (g, inside))| *r -= step * inside * g);
            });
            last = slope;
            self.iterations += 1;
        }
        self.residual(source, &pressure, &mut residual);
        let level = if sum.is_some() { total(&residual) / self.count } else { 0.0 };
        self.precondition(&residual, sum.is_some(), &mut image);
        let left = dot(&residual, &image).abs();
        let error = if left == 0.0 { 0.0 } else { (left / first).sqrt() };
        Adjoint { pressure, level, error }
    }
}
