use crate::PlasticityError;

/// Yield stress of a material and its hardening: von Mises, associated flow, isotropic hardening R(κ) as a line or a
/// curve of points, and linear kinematic hardening with the back stress (2/3) C ε^p.
///
/// κ is the equivalent plastic strain, the integral of √(2/3) |dε^p|. In uniaxial stress R is the true yield stress,
/// and the back stress is C times the plastic strain. The tangent modulus of a bar is E (H + C)/(E + H + C).
///
/// ```
/// use gfmd_plasticity::Hardening;
///
/// let steel = Hardening::new(500e6)?.isotropic(2e9)?;
/// assert_eq!(steel.resistance(0.01), 520e6);
/// assert!(Hardening::new(-1.0).is_err());
/// # Ok::<(), gfmd_plasticity::PlasticityError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Hardening {
    /// Equivalent plastic strain and yield stress, from (0, Y).
    points: Vec<[f64; 2]>,
    /// Slope dR/dκ beyond the last point.
    beyond: f64,
    kinematic: f64,
}

/// Plastic flow of a point during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flow {
    /// Plastic strain at the end of the step.
    pub(crate) strain: [f64; 5],
    /// Equivalent plastic strain at the end of the step.
    pub(crate) equivalent: f64,
    /// Direction of the stress, with |n| = 1.
    pub(crate) direction: [f64; 5],
    /// Change of 2μ times the plastic strain per change of 2μ times the strain, along n and across it; both in [0, 1).
    pub(crate) tangent: [f64; 2],
}

/// Deviatoric strain or stress of a point, in the orthonormal basis of the crate.
pub(crate) fn norm(a: &[f64; 5]) -> f64 {
    a.iter().map(|a| a * a).sum::<f64>().sqrt()
}

impl Hardening {
    /// Creates an ideally plastic material with this yield stress.
    ///
    /// # Errors
    /// Returns an error if the yield stress is not positive and finite.
    pub fn new(yield_stress: f64) -> Result<Self, PlasticityError> {
        if yield_stress.is_finite() && yield_stress > 0.0 {
            Ok(Self { points: vec![[0.0, yield_stress]], beyond: 0.0, kinematic: 0.0 })
        } else {
            Err(PlasticityError::YieldStress { found: yield_stress })
        }
    }

    /// Creates a material from points (κ, R) of its hardening curve: equivalent plastic strain, from zero, and true
    /// yield stress. Between points the curve is straight, beyond the last one it is constant.
    ///
    /// # Errors
    /// Returns an error for fewer than two points, a first strain other than zero, strains that do not increase,
    /// stresses that decrease, and a yield stress that is not positive and finite.
    pub fn from_curve(points: &[[f64; 2]]) -> Result<Self, PlasticityError> {
        let [[start, yield_stress], _, ..] = points else {
            return Err(PlasticityError::CurvePoints { found: points.len() });
        };
        let virgin = Self::new(*yield_stress)?;
        if *start != 0.0 {
            return Err(PlasticityError::CurveStart { found: *start });
        }
        for (index, pair) in points.windows(2).enumerate() {
            let ([before, lower], [found, stress]) = (pair[0], pair[1]);
            if !(found.is_finite() && found > before) {
                return Err(PlasticityError::CurveStrain { index: index + 1, found, before });
            }
            if !(stress.is_finite() && stress >= lower) {
                return Err(PlasticityError::CurveStress { index: index + 1, found: stress, before: lower });
            }
        }
        Ok(Self { points: points.to_vec(), ..virgin })
    }

    /// Returns the material with a linear isotropic hardening dR/dκ (stress) beyond its last point: beyond the yield
    /// stress, unless it has a curve.
    ///
    /// # Errors
    /// Returns an error if the modulus is negative or not finite.
    pub fn isotropic(self, modulus: f64) -> Result<Self, PlasticityError> {
        Ok(Self { beyond: modulus_of("isotropic", modulus)?, ..self })
    }

    /// Returns the material with a linear kinematic hardening C (stress).
    ///
    /// # Errors
    /// Returns an error if the modulus is negative or not finite.
    pub fn kinematic(self, modulus: f64) -> Result<Self, PlasticityError> {
        Ok(Self { kinematic: modulus_of("kinematic", modulus)?, ..self })
    }

    /// Returns the material with another yield stress; the hardening R(κ) − R(0) and C remain.
    ///
    /// # Errors
    /// Returns an error if the yield stress is not positive and finite.
    pub fn with_yield_stress(mut self, yield_stress: f64) -> Result<Self, PlasticityError> {
        let shift = Self::new(yield_stress)?.yield_stress() - self.yield_stress();
        self.points.iter_mut().for_each(|[_, stress]| *stress += shift);
        self.points[0][1] = yield_stress;
        Ok(self)
    }

    /// Returns the initial yield stress Y = R(0).
    pub fn yield_stress(&self) -> f64 {
        self.points[0][1]
    }

    /// Returns the kinematic hardening modulus C, in stress.
    pub fn kinematic_modulus(&self) -> f64 {
        self.kinematic
    }

    /// Returns R(κ), in stress.
    pub fn resistance(&self, equivalent: f64) -> f64 {
        let (start, slope, _) = self.segment(equivalent);
        start[1] + slope * (equivalent - start[0])
    }

    /// Returns the energy stored by isotropic hardening, the integral of R − Y from 0 to κ, in stress.
    pub fn stored(&self, equivalent: f64) -> f64 {
        let base = self.yield_stress();
        let mut stored = 0.0;
        for (index, [start, stress]) in self.points.iter().enumerate() {
            if *start >= equivalent {
                break;
            }
            let end = self.points.get(index + 1).map_or(equivalent, |next| next[0].min(equivalent));
            let slope = self.slope_after(index);
            stored += (end - start) * (stress - base + 0.5 * slope * (end - start));
        }
        stored
    }

    fn slope_after(&self, index: usize) -> f64 {
        let [start, stress] = self.points[index];
        self.points.get(index + 1).map_or(self.beyond, |[end, next]| (next - stress) / (end - start))
    }

    /// Returns the start of the segment of the curve at κ, its slope, and its end.
    fn segment(&self, equivalent: f64) -> ([f64; 2], f64, f64) {
        let index = self.points.partition_point(|[start, _]| *start <= equivalent).max(1) - 1;
        let end = self.points.get(index + 1).map_or(f64::INFINITY, |next| next[0]);
        (self.points[index], self.slope_after(index), end)
    }

    /// Returns the stress that drives the flow, 2μ (dev ε − ε^p) − (2/3) C ε^p.
    pub(crate) fn driving_stress(&self, shear_modulus: f64, strain: &[f64; 5], plastic: &[f64; 5]) -> [f64; 5] {
        let back = 2.0 / 3.0 * self.kinematic;
        std::array::from_fn(|c| 2.0 * shear_modulus * (strain[c] - plastic[c]) - back * plastic[c])
    }

    /// Returns q − R of a stress that drives the flow, with the equivalent stress q = √(3/2) |ξ|.
    pub(crate) fn overstress(&self, driving: &[f64; 5], equivalent: f64) -> f64 {
        1.5_f64.sqrt() * norm(driving) - self.resistance(equivalent)
    }

    /// Returns the flow of a point from a plastic strain and its κ, by backward Euler; `None` if it does not flow.
    pub(crate) fn flow(&self, shear_modulus: f64, strain: &[f64; 5], before: (&[f64; 5], f64)) -> Option<Flow> {
        let (plastic, start) = before;
        let driving = self.driving_stress(shear_modulus, strain, plastic);
        let size = norm(&driving);
        let trial = 1.5_f64.sqrt() * size;
        let flows = trial > self.resistance(start);
        if !flows {
            return None;
        }
        // q_t − (3μ + C)(κ − κ_n) = R(κ), segment by segment of the curve.
        let elastic = 3.0 * shear_modulus + self.kinematic;
        let mut equivalent = start;
        let slope = loop {
            let (from, slope, end) = self.segment(equivalent);
            let excess = trial - elastic * (equivalent - start) - (from[1] + slope * (equivalent - from[0]));
            let next = equivalent + excess / (elastic + slope);
            if next < end {
                equivalent = next;
                break slope;
            }
            equivalent = end;
        };
        let direction = driving.map(|stress| stress / size);
        let increment = equivalent - start;
        let strain = std::array::from_fn(|c| plastic[c] + 1.5_f64.sqrt() * increment * direction[c]);
        let along = 3.0 * shear_modulus / (elastic + slope);
        Some(Flow { strain, equivalent, direction, tangent: [along, 3.0 * shear_modulus * increment / trial] })
    }

    /// Returns the energy stored by hardening at a plastic strain and its κ, in stress.
    pub(crate) fn stored_energy(&self, strain: &[f64; 5], equivalent: f64) -> f64 {
        self.stored(equivalent) + self.kinematic / 3.0 * strain.iter().map(|e| e * e).sum::<f64>()
    }
}

fn modulus_of(what: &'static str, found: f64) -> Result<f64, PlasticityError> {
    if found.is_finite() && found >= 0.0 { Ok(found) } else { Err(PlasticityError::Modulus { what, found }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Hardening {
        Hardening::from_curve(&[[0.0, 0.03], [0.005, 0.036], [0.02, 0.045], [0.1, 0.05]]).unwrap()
    }

    #[test]
    fn uniaxial_cycles_have_their_closed_form() {
        // Uniaxial strain: the deviatoric strain is √(2/3) ε along one direction, q = 2μ |ε − (3/2) ε^p_zz|.
        let shear = 0.4;
        for (isotropic, kinematic) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.05, 0.02)] {
            let material = Hardening::new(0.02).unwrap().isotropic(isotropic).unwrap().kinematic(kinematic).unwrap();
            let (mut state, mut equivalent) = ([0.0; 5], 0.0);
            let (mut plastic, mut hardened) = (0.0_f64, 0.0_f64);
            for strain in [0.01, 0.05, 0.2, 0.1, -0.3, 0.4, 0.39] {
                let strain: f64 = strain;
                let given = [(2.0_f64 / 3.0).sqrt() * strain, 0.0, 0.0, 0.0, 0.0];
                if let Some(flow) = material.flow(shear, &given, (&state, equivalent)) {
                    (state, equivalent) = (flow.strain, flow.equivalent);
                }
                let trial = 2.0 * shear * strain - (3.0 * shear + kinematic) * plastic;
                let over = trial.abs() - 0.02 - isotropic * hardened;
                if over > 0.0 {
                    let increment = over / (3.0 * shear + kinematic + isotropic);
                    plastic += increment * trial.signum();
                    hardened += increment;
                }
                assert!((equivalent - hardened).abs() < 2e-16 + 4e-16 * hardened, "{equivalent} {hardened}");
                assert!((state[0] - 1.5_f64.sqrt() * plastic).abs() < 1e-15, "{} {plastic}", state[0]);
            }
        }
    }

    #[test]
    fn flow_ends_on_the_curve_and_its_tangent_is_the_slope_of_the_map() {
        let material = curve().kinematic(0.02).unwrap();
        let (before, shear) = ([0.001, -0.002, 0.0005, 0.0, 0.001], 0.4);
        for size in [0.05, 0.08, 0.2] {
            let strain = [0.7, -0.4, 0.3, 0.2, -0.5].map(|e: f64| e * size);
            let flow = material.flow(shear, &strain, (&before, 0.003)).unwrap();
            let driving = material.driving_stress(shear, &strain, &flow.strain);
            assert!(material.overstress(&driving, flow.equivalent).abs() < 1e-16);
            let push = [0.3, 0.1, -0.6, 0.4, 0.2];
            let step = 1e-6;
            let at = |sign: f64| {
                let moved = std::array::from_fn(|c| strain[c] + sign * step * push[c]);
                material.flow(shear, &moved, (&before, 0.003)).unwrap().strain
            };
            let (above, below) = (at(1.0), at(-1.0));
            let along: f64 = flow.direction.iter().zip(push).map(|(n, e)| n * e).sum();
            let [first, second] = flow.tangent;
            for c in 0..5 {
                let slope = (above[c] - below[c]) / (2.0 * step);
                let expected = (first - second) * along * flow.direction[c] + second * push[c];
                assert!((slope - expected).abs() < 1e-8, "{slope} {expected}");
            }
        }
    }

    #[test]
    fn the_stored_energy_is_the_integral_of_the_curve() {
        let material = curve().isotropic(0.01).unwrap();
        for end in [0.002, 0.01, 0.1, 0.5] {
            let n = 100_000;
            let at = |k: i32| material.resistance(end * (f64::from(k) + 0.5) / f64::from(n)) - 0.03;
            let sum: f64 = (0..n).map(at).sum::<f64>() * end / f64::from(n);
            approx::assert_relative_eq!(material.stored(end), sum, max_relative = 1e-8);
        }
        assert_eq!(material.with_yield_stress(0.04).unwrap().resistance(0.005), 0.046);
    }

    #[test]
    fn unusable_hardening_is_refused_with_what_was_found() {
        for yield_stress in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Hardening::new(yield_stress), Err(PlasticityError::YieldStress { .. })));
        }
        let steel = || Hardening::new(1.0).unwrap();
        assert!(steel().isotropic(-1.0).unwrap_err().to_string().starts_with("the isotropic hardening is -1"));
        assert!(steel().kinematic(f64::NAN).unwrap_err().to_string().starts_with("the kinematic hardening is NaN"));
        let message = |points: &[[f64; 2]]| Hardening::from_curve(points).unwrap_err().to_string();
        assert_eq!(message(&[[0.0, 1.0]]), "the hardening curve has 1 points; it must have at least 2");
        assert!(message(&[[0.1, 1.0], [0.2, 2.0]]).contains("is 0.1; it must be 0"));
        assert!(message(&[[0.0, 1.0], [0.0, 2.0]]).contains("must exceed 0"));
        assert!(message(&[[0.0, 1.0], [0.1, 0.9]]).contains("must be at least 1"));
    }
}
