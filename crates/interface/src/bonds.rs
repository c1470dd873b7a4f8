//! Bonds of the points of a state to the wall.

use ndarray::ArrayRef2;

use crate::frame::Frame;
use crate::kinks::Kinks;
use crate::newton::Bond;
use crate::{Interface, State};

/// Bonds of all points of a frame to the wall.
pub(crate) struct Bonds {
    /// Pressure of the wall.
    held: Vec<f64>,
    /// True where the gap is closed.
    closed: Vec<bool>,
    kinks: Option<Kinks>,
}

impl Bonds {
    /// Reads the bonds from a state.
    pub(crate) fn new(interface: &Interface, frame: &Frame, state: &State) -> Self {
        let (stress, placed) = (interface.units.stress(), |field: &ArrayRef2<f64>, unit: f64, outside: f64| {
            frame.placed(field.iter().map(|value| value / unit), outside)
        });
        let gap = placed(&state.gap, 1.0, f64::INFINITY);
        Self {
            held: placed(&state.wall_pressure, stress, 0.0),
            closed: gap.into_iter().map(|gap| gap <= 0.0).collect(),
            kinks: interface.kinks(frame),
        }
    }

    /// Returns the bond of point `i`.
    pub(crate) fn of(&self, i: usize) -> Bond {
        let is_pressed = self.kinks.as_ref().is_some_and(|kinks| self.closed[i] && kinks.is_at_most(i, self.held[i]));
        match self.held[i] > 0.0 || is_pressed {
            false => Bond::Free,
            true if is_pressed => Bond::Pressed,
            true if self.spring(i) > 0.0 => Bond::Spring(self.spring(i)),
            true => Bond::Held,
        }
    }

    /// Returns the compliance of the spring of point `i`.
    pub(crate) fn spring(&self, i: usize) -> f64 {
        self.kinks.as_ref().map_or(0.0, |kinks| kinks.spring(i))
    }
}
