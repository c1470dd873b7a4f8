use gfmd_contact::{Drive, Load, Refusal};

use crate::{Interface, State};

/// The coordinates in which a drive is solved. Under a prescribed load the rigid surface stays at first touch and the body
/// is pushed up with `push`; the stiffness of its uniform motion is then 0 (theory.md, section 6.5).
#[derive(Clone, Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) drive: Drive,
    /// Stiffness of the uniform mode, component by component; 0 where the mean is held.
    pub(crate) uniform_stiffness: Vec<f64>,
    /// Components whose mean is held at 0, because a uniform traction does not move the body along them.
    pub(crate) held: Vec<bool>,
    /// Mean pressure that pushes the body up, stress.
    pub(crate) push: f64,
    /// Approach of the rigid surface, length.
    pub(crate) approach: f64,
    clearance: &'a [f64],
}

impl Interface {
    /// Returns the frame of a drive.
    ///
    /// # Errors
    /// Numbers that are not finite, or an approach beyond full contact.
    pub(crate) fn frame(&self, drive: Drive) -> Result<Frame<'_>, Refusal> {
        drive.check()?;
        let uniform = self.elastic.uniform_compliance();
        let mut uniform_stiffness: Vec<f64> = uniform.iter().map(|g| if *g > 0.0 { 1.0 / g } else { 0.0 }).collect();
        let mut held: Vec<bool> = uniform.iter().map(|g| *g == 0.0).collect();
        let z = uniform.len() - 1;
        let (push, approach) = match drive.load {
            Load::MeanPressure(mean) => {
                (uniform_stiffness[z], held[z]) = (0.0, false);
                (mean, 0.0)
            }
            Load::Approach(found) => {
                let limit = self.surface.mean_clearance();
                if self.law.has_wall() && held[z] && found >= limit {
                    return Err(Refusal::Approach { found, limit: Some(limit) });
                }
                (0.0, found)
            }
        };
        Ok(Frame { drive, uniform_stiffness, held, push, approach, clearance: self.surface.clearance() })
    }
}

impl Frame<'_> {
    /// Number of points.
    pub(crate) fn points(&self) -> usize {
        self.clearance.len()
    }

    /// Number of components.
    pub(crate) fn components(&self) -> usize {
        self.held.len()
    }

    /// Index of the normal component.
    pub(crate) fn z(&self) -> usize {
        self.held.len() - 1
    }

    /// Traction that pushes component `c`, stress.
    pub(crate) fn push_on(&self, c: usize) -> f64 {
        if c == self.z() { self.push } else { 0.0 }
    }

    /// The separations Δ_n and Δ_t at point `i`.
    pub(crate) fn separation(&self, position: &[f64], i: usize) -> (f64, [f64; 2]) {
        let (points, z) = (self.points(), self.z());
        let along = |c: usize| if c < z { self.drive.lateral[c] - position[c * points + i] } else { 0.0 };
        (self.clearance[i] - self.approach - position[z * points + i], [along(0), along(1)])
    }

    /// The heights of the rigid surface, which are the upper bounds of w_z with a hard wall.
    pub(crate) fn wall(&self) -> impl Iterator<Item = f64> {
        self.clearance.iter().map(|clearance| clearance - self.approach)
    }

    /// The position from which a search begins: `start`, with the points under pressure of the wall placed on it; without
    /// one, the undeformed surface, clipped at the wall.
    pub(crate) fn starting_position(&self, start: Option<&State>) -> Vec<f64> {
        let mut position = vec![0.0; self.components() * self.points()];
        let z = self.z() * self.points();
        let Some(state) = start else {
            position[z..].iter_mut().zip(self.wall()).for_each(|(w, wall)| *w = wall.min(0.0));
            return position;
        };
        position.iter_mut().zip(&state.displacement).for_each(|(w, u)| *w = *u);
        let rise = if let Load::MeanPressure(_) = self.drive.load { state.approach } else { 0.0 };
        for ((w, wall), pressure) in position[z..].iter_mut().zip(self.wall()).zip(&state.wall_pressure) {
            *w = if *pressure > 0.0 { wall } else { *w + rise };
        }
        position
    }
}
