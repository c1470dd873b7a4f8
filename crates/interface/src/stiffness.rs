//! Stiffness of a state: the traction by a small motion of the rigid surface (theory.md, sections 7.3 and 7.9).

use gfmd_contact::{ClearanceGradient, Cotangents, Drive, Effort, GradientError, Load, Stiffness};

use crate::bonds::Bonds;
use crate::gradient::{EXACT, FULL};
use crate::newton::{Energy, Linear, Sides};
use crate::numbers::total;
use crate::{Interface, State};

/// Largest residual of the linear problem of a stiffness, whose error is its square times the condition number.
const LOOSEST: f64 = 1e-5;

impl Interface {
    /// Computes the stiffness of the stable `state`, d(mean pressure)/d(approach), with the set of points pressed by
    /// the wall kept, and the pressure of points at the hardness. The attraction counts, and under tension the
    /// stiffness may be negative. In all components the surfaces do not move sideways, and the shear of the law counts.
    /// Infinite in full contact of a body whose mean level is fixed.
    ///
    /// In u_z alone the error is the relative residual of the linear problem, which is solved to a residual of
    /// `tolerance`, but at least to 1e-5 and at most to 1e-11. In all components it estimates the relative error of the
    /// value, and may exceed the tolerance because of rounding errors.
    ///
    /// # Errors
    /// Returns the errors of [`gradient`](Self::gradient), except for an interface in all components.
    pub fn stiffness(&self, state: &State, tolerance: f64) -> Result<Stiffness, GradientError> {
        if self.elastic.components() > 1 {
            return self.stiffness_in_all_components(state, Sides::Law, tolerance);
        }
        let of = Cotangents { mean_pressure: 1.0, ..Cotangents::default() };
        match self.derivatives(state, Load::Approach(state.approach), &of, tolerance.clamp(EXACT, LOOSEST)) {
            Ok(ClearanceGradient { load: value, error, effort, .. }) => Ok(Stiffness { value, error, effort }),
            Err(GradientError::Undetermined(FULL)) => Ok(infinite()),
            Err(error) => Err(error),
        }
    }

    /// Computes the stiffness as [`stiffness`](Self::stiffness) of an interface in all components, with the given
    /// lateral motion of the surfaces.
    ///
    /// # Errors
    /// Returns the errors of [`stiffness`](Self::stiffness).
    pub(crate) fn stiffness_in_all_components(
        &self,
        state: &State,
        sides: Sides,
        tolerance: f64,
    ) -> Result<Stiffness, GradientError> {
        // All values in the units of the solve.
        let length = self.units.length();
        let drive =
            Drive { lateral: state.lateral.map(|u| u / length), ..Load::Approach(state.approach / length).into() };
        let frame = self.frame(drive);
        let frame = frame.map_err(|_| GradientError::Undetermined("the approach does not determine the pressure"))?;
        let (points, inside, share, z) = (frame.points(), frame.inside(), &self.share, frame.z() * frame.points());
        let mut position: Vec<f64> = state.displacement.iter().map(|u| u / length).collect();
        let wall = frame.values_inside(frame.wall().collect());
        let normal = position[frame.z() * inside..].iter_mut().zip(wall).zip(&state.gap);
        normal.for_each(|((w, wall), gap)| *w = wall - gap / length);
        let mut around = vec![0.0; frame.components() * points];
        match &self.patch {
            Some(patch) => patch.place(position, &mut around),
            None => around = position,
        }
        let bonds = Bonds::new(self, &frame, state);
        let mut problem = Linear::at(self, &frame, &around, sides, |i| bonds.of(i));
        drop(around);
        let acts = |(slope, free): (&f64, &f64)| *free == 0.0 || *slope != 0.0;
        if !share.any(problem.slope().iter().zip(&problem.free()[z..]).any(acts)) {
            return Ok(Stiffness { value: 0.0, error: 0.0, effort: Effort::default() });
        }
        let free_along_z = total(share, &problem.free()[z..]);
        if frame.held[frame.z()] && free_along_z == 0.0 {
            return Ok(infinite());
        }
        // The elastic surface follows the rigid one at the points held, and has the least energy elsewhere.
        let mut followed = vec![0.0; z];
        followed.extend(frame.placed(std::iter::repeat_n(1.0, inside), 0.0));
        let Energy { value, error, lowest, effort: (iterations, transform_pairs) } =
            problem.least_energy(&followed, tolerance);
        if lowest <= 0.0 || lowest.is_nan() {
            return Err(GradientError::Unstable { lowest });
        }
        if error.is_nan() {
            return Err(GradientError::Inexact { error, iterations });
        }
        let value = value / frame.all_inside() as f64 * self.units.stress() / length;
        Ok(Stiffness { value, error, effort: Effort { iterations, transform_pairs } })
    }
}

/// Returns the stiffness of full contact with a body whose mean level is fixed.
fn infinite() -> Stiffness {
    Stiffness { value: f64::INFINITY, error: 0.0, effort: Effort::default() }
}
