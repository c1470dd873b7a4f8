//! Derivatives of a scalar result of an interface in u_z with respect to heights, load and modulus, from one linear
//! problem (theory.md, section 7.9).

use gfmd_contact::{ClearanceGradient, Cotangents, Effort, Fields as _, Gradient, GradientError, Load};
use ndarray::{Array2, ArrayRef2};

use crate::bonds::Bonds;
use crate::newton::{Adjoint, Bond, Linear, Sides};
use crate::numbers::{dot, total};
use crate::{Interface, State};

/// Largest accepted error of a result.
const ERROR: f64 = 1e-8;

/// Residual of the linear problem of derivatives, relative to the first one.
pub(crate) const EXACT: f64 = 1e-11;

/// Reason why an approach in full contact has no derivatives.
pub(crate) const FULL: &str = "all points are in contact, of a body whose mean level is fixed; the approach does not \
                               determine the pressure";

impl Interface {
    /// Computes the derivatives of a scalar at the stable `state`, with respect to heights, load and modulus. `of`
    /// holds its derivatives with respect to the state; only the kind of `load` matters. The set of points pressed by
    /// the wall is kept fixed, as it is for almost all heights and loads. The stiffness of springs does not change with
    /// the modulus.
    ///
    /// # Errors
    /// Returns an error for an interface in all components; for derivatives of another shape, not
    /// finite, or of fields that the interface does not have; if the load does not determine the state, or the state
    /// jumps; or if the linear problem was not solved.
    pub fn gradient(&self, state: &State, load: Load, of: &Cotangents) -> Result<Gradient, GradientError> {
        Ok(self.derivatives(state, load, of, EXACT)?.by_heights(&self.surface))
    }

    /// Computes the derivatives by the clearance, from a linear problem solved to a relative residual of `tolerance`;
    /// points at the hardness keep their pressure.
    pub(crate) fn derivatives(
        &self,
        state: &State,
        load: Load,
        of: &Cotangents,
        tolerance: f64,
    ) -> Result<ClearanceGradient, GradientError> {
        let (shape, share): ([usize; 2], _) = (self.surface.shape(), &self.share);
        of.check(shape, self.hardness.is_some(), 0)?;
        // All values in the units of the solve.
        let (stress, length, energy) = (self.units.stress(), self.units.length(), self.units.energy());
        let is_driven = matches!(load, Load::Approach(_));
        let drive = if is_driven {
            Load::Approach(state.approach / length)
        } else {
            Load::MeanPressure(state.mean_pressure / stress)
        };
        let frame = self.frame(drive.into());
        let frame = frame.map_err(|_| GradientError::Undetermined("the approach does not determine the pressure"))?;
        if frame.components() != 1 {
            return Err(GradientError::Components);
        }
        let (points, inside, all) = (frame.points(), frame.inside(), frame.all_inside() as f64);
        let in_cell = |values: Vec<f64>| match &self.patch {
            Some(patch) => {
                let mut field = vec![0.0; points];
                patch.place(values, &mut field);
                field
            }
            None => values,
        };
        let scaled = |field: &ArrayRef2<f64>, unit: f64| -> Vec<f64> { field.iter().map(|x| x / unit).collect() };
        let wall = frame.values_inside(frame.wall().collect());
        let position = wall.iter().zip(&state.gap).map(|(wall, gap)| wall - gap / length).collect();
        let bonds = Bonds::new(self, &frame, state);
        let bond = |i: usize| bonds.of(i);
        let mut problem = Linear::at(self, &frame, &in_cell(position), Sides::Law, bond);
        let acts = |(slope, free): (&f64, &f64)| *free == 0.0 || *slope != 0.0;
        if !is_driven && !share.any(problem.slope().iter().zip(problem.free()).any(acts)) {
            return Err(GradientError::Undetermined(
                "no point is in contact; there must be some under a mean pressure",
            ));
        }
        if frame.held[0] && total(share, problem.free()) == 0.0 {
            return Err(GradientError::Undetermined(FULL));
        }
        let pressure = in_cell(scaled(&state.pressure(), stress));
        let sunk = in_cell(state.displacement.iter().map(|u| -u / length).collect());
        // ∂L/∂p at fixed gaps, with the terms of the mean pressure and of the energy, which changes by −u dp.
        let of_mean = if is_driven { of.mean_pressure * stress / all } else { 0.0 };
        let of_energy = of.elastic_energy * energy;
        let by_pressure = of.pressure.as_ref().map_or_else(|| vec![0.0; inside], |field| scaled(field, 1.0 / stress));
        let mut by_pressure = in_cell(by_pressure.iter().map(|by| by + of_mean).collect());
        by_pressure.iter_mut().zip(&sunk).for_each(|(by, sunk)| *by += of_energy * sunk / all);
        let by_gap = of.gap.as_ref().map_or_else(|| vec![0.0; inside], |field| scaled(field, 1.0 / length));
        let of_mean_gap = of.mean_gap * length / all;
        let mut by_gap = in_cell(by_gap.iter().map(|by| by + of_mean_gap).collect());
        let by_depth = of.plastic_depth.as_ref().map_or_else(|| vec![0.0; inside], |field| scaled(field, 1.0 / length));
        let by_depth = in_cell(by_depth);
        // The gap stays closed while a spring is shortened, and where the surfaces are pressed into each other.
        by_gap.iter_mut().enumerate().for_each(|(i, by)| match bond(i) {
            Bond::Spring(_) => *by = 0.0,
            Bond::Pressed => *by = -by_depth[i],
            Bond::Free | Bond::Held => {}
        });
        // In the frame of a load, the approach is the mean position plus the mean displacement caused by the load.
        let by_approach = if is_driven { 0.0 } else { of.approach * length };
        let level = by_approach / frame.all_points() as f64;
        let of_position = problem.elastic(&by_pressure);
        let source: Vec<f64> = of_position.iter().zip(&by_gap).map(|(k, gap)| level - k - gap).collect();
        let Adjoint { values, level: mean, error, lowest, effort: (iterations, transform_pairs) } =
            problem.solve(&source, -total(share, &by_pressure), tolerance);
        if lowest <= 0.0 || lowest.is_nan() {
            return Err(GradientError::Unstable { lowest });
        }
        if error.is_nan() || error > ERROR.max(2.0 * tolerance) {
            return Err(GradientError::Inexact { error, iterations });
        }
        let whole: Vec<f64> = by_pressure.iter().zip(&values).map(|(by, v)| by + v).collect();
        let elastic = problem.elastic(&whole);
        let by_clearance = (0..points).map(|i| match problem.free()[i] > 0.0 {
            true => problem.slope()[i] * values[i] + by_gap[i],
            false => level - elastic[i] - mean,
        });
        let by_clearance = frame.values_inside(by_clearance.collect());
        let moved = total(frame.share_inside(), &by_clearance);
        let part = all / frame.all_points() as f64;
        let sinks = self.elastic.uniform_compliance()[0] * part;
        let by_load = match is_driven {
            true => of.approach - moved / length,
            false => of.mean_pressure + (total(share, &whole) * part + by_approach * sinks) / stress,
        };
        let mean_pressure = state.mean_pressure / stress;
        let of_load =
            if is_driven { 0.0 } else { total(share, &whole) * frame.push + by_approach * sinks * mean_pressure };
        let stored = 0.5 * dot(share, &pressure, &sunk) / all;
        let by_modulus = dot(share, &whole, &pressure) - of_load - of_energy * stored;
        // A larger hardness presses the elastic surface away, and shortens the spring of the point.
        let hardness = self.hardness.as_ref().map(|_| {
            let by = |i: usize| if bond(i) == Bond::Pressed { -values[i] - bonds.spring(i) * by_depth[i] } else { 0.0 };
            let by = frame.values_inside((0..points).map(by).collect());
            Array2::from_shape_fn(shape, |(i, j)| by[i * shape[1] + j] / stress)
        });
        let clearance = Array2::from_shape_fn(shape, |(i, j)| by_clearance[i * shape[1] + j] / length);
        let (modulus, effort) = (by_modulus / self.contact_modulus, Effort { iterations, transform_pairs });
        Ok(ClearanceGradient { clearance, load: by_load, modulus, hardness, error, effort })
    }
}
