//! States from stored fields.

use gfmd_contact::{Drive, Load, Refusal};
use ndarray::{Array2, ArrayRef2};

use crate::certify::certify;
use crate::{Interface, State};

/// Fields of a state of u_z alone, as stored in a file. They determine the state.
#[derive(Clone, Copy, Debug)]
pub struct StoredFields<'a> {
    /// Pressure −t_z on the elastic surface, `[x, y]`, stress; attraction is negative.
    pub pressure: &'a ArrayRef2<f64>,
    /// Normal displacement of the elastic surface, `[x, y]`, length.
    pub displacement_z: &'a ArrayRef2<f64>,
    /// Distance between the surfaces, `[x, y]`, length.
    pub gap: &'a ArrayRef2<f64>,
    /// Rigid approach beyond first touch, length.
    pub approach: f64,
}

impl Interface {
    /// Returns the state of a position of zero under `drive`, to be filled in.
    pub(crate) fn blank(&self, drive: Drive) -> Result<State, Refusal> {
        let frame = self.frame(self.units.drive(drive))?;
        Ok(certify(self, &frame, &vec![0.0; frame.components() * frame.points()], &[]))
    }

    /// Returns the state with these fields. A search from it takes the same steps, bit for bit, as from the stored
    /// state. Numbers and residuals are recomputed.
    ///
    /// # Errors
    /// Returns an error for an interface in all components, fields that do not match the grid, or values not finite.
    pub fn recall(&self, stored: StoredFields<'_>) -> Result<State, Refusal> {
        let StoredFields { pressure, displacement_z, gap, approach } = stored;
        let [nx, ny] = self.surface.shape();
        let expected = nx * ny;
        let of_other_size = [pressure, displacement_z, gap].map(|field| (field.dim(), field.len()));
        let other = of_other_size.into_iter().find(|(shape, _)| *shape != (nx, ny)).map(|(_, found)| found);
        if let Some(found) = self.share.first(other) {
            return Err(Refusal::Start { found, expected });
        }
        if self.elastic.components() != 1 {
            return Err(Refusal::Start { found: expected, expected: expected * self.elastic.components() });
        }
        let frame = self.frame(Load::MeanPressure(self.mean_of(pressure)).into())?;
        // In the frame of a load, the elastic surface moves instead of the rigid one.
        let inside: Vec<f64> = displacement_z.iter().map(|u| u + approach).collect();
        if let Some(found) = self.share.first(inside.iter().copied().find(|w| !w.is_finite())) {
            return Err(Refusal::NotFinite { what: "displacement of the start", found });
        }
        let kinks = self.kinks(&frame);
        let insets = kinks.as_ref().map_or_else(Vec::new, |kinks| {
            let w = frame.placed(inside.iter().copied(), 0.0);
            kinks.insets(&frame, [pressure, gap], |at, pressure| [pressure, w[at] - kinks.bound(at)])
        });
        let position = frame.position(&self.elastic, inside, pressure);
        let state = certify(self, &frame, &position, &insets);
        if kinks.is_some() {
            let alone = |field: &ArrayRef2<f64>| field.to_owned().insert_axis(ndarray::Axis(0));
            let (displacement, traction) = (alone(displacement_z), -alone(pressure));
            return Ok(State { displacement, traction, gap: gap.to_owned(), approach, ..state });
        }
        // The sum above is rounded. The stored gap determines the points that touch the wall.
        let wall_pressure = Array2::from_shape_fn((nx, ny), |at| self.wall_pressure(pressure[at], gap[at]));
        let alone = |field: &ArrayRef2<f64>| field.to_owned().insert_axis(ndarray::Axis(0));
        let (displacement, traction) = (alone(displacement_z), -alone(pressure));
        let is_pressed = self.share.any(wall_pressure.iter().any(|p| *p > 0.0));
        Ok(State { displacement, traction, gap: gap.to_owned(), wall_pressure, is_pressed, approach, ..state })
    }
    /// Returns the pressure of the wall at a point with this pressure and gap; 0 where it is open.
    pub(crate) fn wall_pressure(&self, pressure: f64, gap: f64) -> f64 {
        let touches = self.law.has_wall() && gap <= 0.0;
        if touches { (self.law.traction(gap, [0.0; 2])[2] + pressure).max(0.0) } else { 0.0 }
    }
}
