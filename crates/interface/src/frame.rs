use gfmd_contact::{Clearance, Drive, Load, Refusal};
use gfmd_response::Elastic;
use gfmd_vector::Share;
use ndarray::ArrayRef2;

use crate::numbers::{sum, total};
use crate::patch::Patch;
use crate::{Interface, State};

/// Coordinates for the solution of a drive. Under a prescribed load the rigid surface stays at first touch, and `push`
/// moves the body up; the stiffness of its uniform motion is then 0 (theory.md, section 6.5).
#[derive(Clone, Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) drive: Drive,
    /// Stiffness of the uniform mode, per component; 0 where the mean is held. Of a plate, the stiffness against equal
    /// and against opposite means of the two faces; nothing holds the plate as a whole.
    pub(crate) uniform_stiffness: Vec<f64>,
    /// Components with a mean held at 0, because a uniform traction does not move the body along them.
    pub(crate) held: Vec<bool>,
    /// Mean pressure that pushes the body up, stress; for a patch, the mean over its cell.
    pub(crate) push: f64,
    /// Approach of the rigid surface, length.
    pub(crate) approach: f64,
    clearance: Clearance<'a>,
    /// Lateral displacement without traction, component by component; empty if it is zero.
    sideways: &'a [f64],
    patch: Option<&'a Patch>,
    /// Points of this process.
    pub(crate) share: &'a Share,
}

impl Interface {
    /// Returns the frame of a drive.
    ///
    /// # Errors
    /// Returns an error if numbers are not finite or the approach is beyond full contact.
    pub(crate) fn frame(&self, drive: Drive) -> Result<Frame<'_>, Refusal> {
        drive.check()?;
        let uniform = self.elastic.uniform_compliance();
        let mut uniform_stiffness: Vec<f64> = uniform.iter().map(|g| if *g > 0.0 { 1.0 / g } else { 0.0 }).collect();
        let mut held: Vec<bool> = uniform.iter().map(|g| *g == 0.0).collect();
        let z = uniform.len() - 1;
        if self.elastic.faces() == 2 {
            uniform_stiffness.push(0.0);
        }
        let clearance = self.patch.as_ref().map_or_else(|| self.surface.clearance(), Patch::clearance);
        let inside = match self.share.is_whole() {
            true => self.surface.clearance().len() as f64 / clearance.len() as f64,
            false => self.surface.share().total() as f64 / self.share.total() as f64,
        };
        let (push, approach) = match drive.load {
            Load::MeanPressure(mean) => {
                (uniform_stiffness[z], held[z]) = (0.0, false);
                (mean * inside, 0.0)
            }
            Load::Approach(found) => {
                let limit = self.surface.mean_clearance();
                if self.law.has_wall() && !self.gives_way() && held[z] && found >= limit {
                    return Err(Refusal::Approach { found, limit: Some(limit) });
                }
                (0.0, found)
            }
        };
        let (sideways, patch) = (self.sideways.as_deref().unwrap_or_default(), self.patch.as_ref());
        Ok(Frame { drive, uniform_stiffness, held, push, approach, clearance, sideways, patch, share: &self.share })
    }
}

impl Frame<'_> {
    /// Returns the number of points of this process.
    pub(crate) fn points(&self) -> usize {
        self.clearance.len()
    }

    /// Returns the number of points below the rigid surface: all points, or the points of the patch.
    pub(crate) fn inside(&self) -> usize {
        self.patch.map_or(self.points(), Patch::len)
    }

    /// Returns the number of points of all processes.
    pub(crate) fn all_points(&self) -> usize {
        if self.share.is_whole() { self.points() } else { self.share.total() }
    }

    /// Returns the number of points below the rigid surface of all processes.
    pub(crate) fn all_inside(&self) -> usize {
        if self.share.is_whole() { self.inside() } else { self.share_inside().total() }
    }

    /// Returns the points below the rigid surface of this process.
    pub(crate) fn share_inside(&self) -> &Share {
        self.patch.map_or(self.share, Patch::share)
    }

    /// Returns the field of given values at the inside points, with the value `outside` elsewhere.
    pub(crate) fn placed(&self, inside: impl Iterator<Item = f64>, outside: f64) -> Vec<f64> {
        let Some(patch) = self.patch else { return inside.collect() };
        let mut field = vec![outside; self.points()];
        patch.place(inside, &mut field);
        field
    }

    /// Returns the sum of a function of the points over the inside points.
    pub(crate) fn sum_inside(&self, of: impl Fn(usize) -> f64 + Sync) -> f64 {
        match self.patch {
            Some(patch) => total(patch.share(), &patch.values(of)),
            None => sum(self.share, self.points(), &|range| range.map(&of).sum()),
        }
    }

    /// Returns the values at the inside points, field by field.
    pub(crate) fn values_inside(&self, fields: Vec<f64>) -> Vec<f64> {
        match self.patch {
            Some(patch) => patch.inside(&fields),
            None => fields,
        }
    }

    /// Returns the mean over the inside points of a field that is zero elsewhere.
    pub(crate) fn mean(&self, field: &[f64]) -> f64 {
        total(self.share, field) / self.all_inside() as f64
    }

    /// Returns the mean of values at the inside points.
    pub(crate) fn mean_inside(&self, values: &[f64]) -> f64 {
        total(self.share_inside(), values) / self.all_inside() as f64
    }

    /// Returns the number of components.
    pub(crate) fn components(&self) -> usize {
        self.held.len()
    }

    /// Returns the index of the normal component.
    pub(crate) fn z(&self) -> usize {
        self.held.len() - 1
    }

    /// Returns the traction that pushes component `c`, stress.
    pub(crate) fn push_on(&self, c: usize) -> f64 {
        if c == self.z() { self.push } else { 0.0 }
    }

    /// Returns the separations Δ_n and Δ_t at point `i`.
    pub(crate) fn separation(&self, position: &[f64], i: usize) -> (f64, [f64; 2]) {
        let (points, z) = (self.points(), self.z());
        let displaced = |at: usize| position[at] + self.sideways.get(at).copied().unwrap_or(0.0);
        let along = |c: usize| if c < z { self.drive.lateral[c] - displaced(c * points + i) } else { 0.0 };
        (self.clearance.at(i) - self.approach - position[z * points + i], [along(0), along(1)])
    }

    /// Returns the heights of the rigid surface; for a hard wall, they are the upper bounds of w_z.
    pub(crate) fn wall(&self) -> impl Iterator<Item = f64> {
        self.clearance.iter().map(|clearance| clearance - self.approach)
    }

    /// Returns the position in u_z alone with the given values `inside`; outside a patch it follows from the pressure
    /// on the patch.
    pub(crate) fn position(&self, elastic: &Elastic, inside: Vec<f64>, pressure: &ArrayRef2<f64>) -> Vec<f64> {
        self.position_of(elastic, inside, pressure.iter().map(|p| -p))
    }

    /// Returns the position with the given values `inside`, field by field; outside a patch it follows from the
    /// `traction` on the patch, field by field.
    fn position_of(&self, elastic: &Elastic, inside: Vec<f64>, traction: impl Iterator<Item = f64>) -> Vec<f64> {
        let Some(patch) = self.patch else { return inside };
        let mut around = vec![0.0; self.components() * self.points()];
        patch.place(traction, &mut around);
        let mut position = vec![0.0; around.len()];
        elastic.transforms().compliance(&around, &elastic.uniform_compliance(), &mut position);
        if let Load::MeanPressure(_) = self.drive.load {
            // In the frame of a load the body moves as a whole.
            let (normal, inside) = (&mut position[self.z() * self.points()..], &inside[self.z() * patch.len()..]);
            let sum = |values: &[f64]| total(patch.share(), values);
            let rise = (sum(inside) - sum(&patch.inside(normal))) / self.all_inside() as f64;
            normal.iter_mut().for_each(|w| *w += rise);
        }
        patch.place(inside, &mut position);
        position
    }

    /// Returns the starting position of a search: `start`, with points under wall pressure placed on the wall; without
    /// it, the undeformed surface, clipped at the wall.
    pub(crate) fn starting_position(&self, elastic: &Elastic, start: Option<&State>) -> Vec<f64> {
        let z = self.z() * self.points();
        let Some(state) = start else {
            let mut position = vec![0.0; self.components() * self.points()];
            position[z..].iter_mut().zip(self.wall()).for_each(|(w, wall)| *w = wall.min(0.0));
            return position;
        };
        let mut position: Vec<f64> = state.displacement.iter().copied().collect();
        if let Load::MeanPressure(_) = self.drive.load {
            position[self.z() * self.inside()..].iter_mut().for_each(|w| *w += state.approach);
        }
        let mut position = self.position_of(elastic, position, state.traction.iter().copied());
        let pressures = self.placed(state.wall_pressure.iter().copied(), 0.0);
        for (at, _) in pressures.iter().enumerate().filter(|(_, pressure)| **pressure > 0.0) {
            position[z + at] = self.clearance.at(at) - self.approach;
        }
        position
    }
}
