//! Variables of states, to save them outside the process and restore them bit for bit.

use gfmd_contact::{Drive, Equilibrium, Refusal, Resumable, Variables, Visit};
use gfmd_vector::{Share, with_contiguous};
use ndarray::Array;

use crate::{Interface, State};

fn visit_field<D: ndarray::Dimension>(share: &Share, field: &mut Array<f64, D>, visitor: &mut dyn Visit) {
    let own = share.own().len();
    with_contiguous(field, |values| values.chunks_exact_mut(own).for_each(|rows| visitor.rows(share, rows)));
}

impl Variables for State {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { displacement, traction, gap, wall_pressure, pressed_in, residual, effort, surface, .. } = self;
        let share = surface.share();
        visit_field(share, displacement, visitor);
        visit_field(share, traction, visitor);
        visit_field(share, gap, visitor);
        visit_field(share, wall_pressure, visitor);
        // Both are present with a hardness alone.
        if let Some(depth) = pressed_in {
            visit_field(share, depth, visitor);
        }
        let crate::Residual { complementarity, equilibrium, penetration, wall_tension, load, saturation } = residual;
        visitor.numbers(&mut [complementarity, equilibrium, penetration, wall_tension, load]);
        if let Some(saturation) = saturation {
            visitor.numbers(&mut [saturation]);
        }
        effort.visit(visitor);
        let Self { mean_pressure, mean_shear: [shear_x, shear_y], approach, lateral: [x, y], .. } = self;
        visitor.numbers(&mut [mean_pressure, shear_x, shear_y, approach, x, y]);
        let Self { elastic_energy, interface_energy, contact_fraction, lowest_curvature, noise, .. } = self;
        visitor.numbers(&mut [elastic_energy, interface_energy, contact_fraction, lowest_curvature, noise]);
        visitor.flag(&mut self.is_pressed);
        visitor.flag(&mut self.passed_instability);
    }
}

impl Resumable for Interface {
    fn keep(&self, state: &mut State, visitor: &mut dyn Visit) {
        state.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<State, Refusal> {
        self.check(drive)?;
        let mut state = self.blank(drive)?;
        state.visit(visitor);
        Ok(state)
    }
}
