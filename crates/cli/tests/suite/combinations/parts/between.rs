//! Plates between two surfaces, drawn with dice of their own, so that other paths stay as they are.

use std::fmt::Write as _;
use std::path::Path;

use super::super::draw::{Body, Dice, material, short, waves, write};
use super::super::elastic::{Base, Layer, Stack};
use super::super::numbers::deviation;
use super::Parts;

impl Parts {
    /// Lays the body of some paths on a second surface.
    pub(super) fn lay_on_surface(&mut self, folder: &Path) {
        let dice = &mut Dice::new(self.index + 0x5a11d);
        let is_wild = dice.chance(0.05);
        if !dice.chance(0.12) || self.yielding.is_some() && !is_wild {
            return;
        }
        if !(is_wild && dice.chance(0.5)) {
            (self.friction, self.shear_strength, self.of_net, self.is_free) = (None, None, false, false);
            (self.lateral, self.lateral_y, self.direction) = (Vec::new(), Vec::new(), 0.0);
            self.wear = self.wear.take().filter(|wear| !wear.by_slip);
            self.relaxation = self.relaxation.take().filter(|of| !of.of_shear);
            if self.relaxation.is_none() {
                self.times = Vec::new();
            }
            let Layer { young, poisson, .. } = self.body.top();
            let mut layers = Vec::new();
            self.body_text = format!("--young {young} --poisson {poisson}");
            for layer in 0..dice.of(&[1, 1, 1, 2, 3]) {
                let height = short(dice.scale(0.15, 1.0));
                if layer == 0 {
                    let _ = write!(self.body_text, " --height {height}");
                    layers.push(Layer { young, poisson, height });
                } else {
                    let (young, poisson) = material(dice);
                    let _ = write!(self.body_text, " --layer {young},{poisson},{height}");
                    layers.push(Layer { young, poisson, height });
                }
            }
            self.body = Body { first: Stack { layers, base: Base::Bonded }, second: None };
        }
        let amplitude = dice.scale(0.3, 2.0) * deviation(&self.heights);
        let heights = if dice.chance(0.1) { vec![0.0; self.plane.len()] } else { waves(dice, self.plane, amplitude) };
        write(folder, &format!("l{}.npy", self.index), self.plane, self.is_line, &heights);
        self.lower = Some(heights);
    }
}
