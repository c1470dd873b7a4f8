use std::ops::ControlFlow;
use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_relax::{Progress, Visit, Watch};
use gfmd_response::unit_of;

use crate::{Drive, Load, Refusal, RigidSurface};

/// Units in which a contact is solved, in the units of its input.
///
/// Solvers form squares and products of their variables, which overflow or vanish for the largest and smallest numbers.
/// Moduli, lengths along the surface and heights far from 1 are therefore measured in units of their own size. All
/// units are powers of two, so that no digit is lost. In ordinary units they are 1, and nothing is converted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    modulus: f64,
    lateral: f64,
    normal: f64,
}

/// Least magnitude of a mean pressure. Pressures of a billionth of it still have all digits.
const LEAST: f64 = 1e-290;

impl Default for Units {
    fn default() -> Self {
        Self::ONE
    }
}

impl Units {
    /// Units of the input.
    pub const ONE: Self = Self { modulus: 1.0, lateral: 1.0, normal: 1.0 };

    /// Computes the units of a contact of `body` with `surface`.
    ///
    /// # Errors
    /// A unit of stress, E* h_rms divided by the cell length, out of the range of full precision.
    pub fn of(body: &Body, surface: &RigidSurface) -> Result<Self, Refusal> {
        let modulus = body.contact_modulus();
        let units = Self { modulus: unit_of(modulus), ..Self::of_surface(surface) };
        let stress = modulus * (surface.rms_height() / longest(surface.grid()));
        if units != Self::ONE && stress != 0.0 && !(LEAST..=1.0 / LEAST).contains(&stress) {
            return Err(Refusal::Unit { found: stress });
        }
        Ok(units)
    }

    /// Computes the units of length of a surface alone.
    pub(crate) fn of_surface(surface: &RigidSurface) -> Self {
        Self { normal: unit_of(surface.rms_height()), ..Self::of_grid(surface.grid()) }
    }

    /// Computes the unit of length along the surface alone.
    pub(crate) fn of_grid(grid: &Grid) -> Self {
        Self { lateral: unit_of(longest(grid)), ..Self::ONE }
    }

    /// Returns the unit of gradients.
    pub(crate) fn gradient(&self) -> f64 {
        self.normal / self.lateral
    }

    /// Returns true if nothing is converted.
    pub fn are_one(&self) -> bool {
        *self == Self::ONE
    }

    /// Returns the unit of moduli.
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// Returns the unit of lengths along the surface.
    pub(crate) fn lateral(&self) -> f64 {
        self.lateral
    }

    /// Returns the unit of heights, gaps and displacements.
    pub fn length(&self) -> f64 {
        self.normal
    }

    /// Returns the unit of pressures and tractions.
    pub fn stress(&self) -> f64 {
        self.modulus * self.gradient()
    }

    /// Returns the unit of stiffnesses.
    pub fn stiffness(&self) -> f64 {
        self.modulus / self.lateral
    }

    /// Returns the unit of energies per area.
    pub fn energy(&self) -> f64 {
        self.stress() * self.normal
    }

    /// Converts the body to these units.
    pub fn body(&self, body: &Body) -> Body {
        if self.are_one() { body.clone() } else { body.in_units(self.modulus, self.lateral) }
    }

    /// Converts the grid to these units.
    pub fn grid(&self, grid: &Grid) -> Grid {
        grid.in_units(self.lateral)
    }

    /// Converts a rigid surface to these units.
    pub fn surface(&self, surface: &Arc<RigidSurface>) -> Arc<RigidSurface> {
        if self.are_one() { Arc::clone(surface) } else { surface.in_units(self).into() }
    }

    /// Converts the drive to these units.
    pub fn drive(&self, drive: Drive) -> Drive {
        let load = match drive.load {
            Load::MeanPressure(mean) => Load::MeanPressure(mean / self.stress()),
            Load::Approach(approach) => Load::Approach(approach / self.normal),
        };
        Drive { load, lateral: drive.lateral.map(|u| u / self.normal), ..drive }
    }

    /// Returns the watcher of a search in these units. It shows `watch` energies and displacements in the input units.
    pub fn shown<'a>(&self, watch: &'a mut dyn Watch) -> impl Watch + use<'a> {
        ScaledWatch { watch, units: *self, u: Vec::new() }
    }

    /// Checks that a mean pressure, in the units of the input, has all its digits.
    ///
    /// # Errors
    /// A pressure other than zero that is too small, or infinite.
    pub fn check_pressure(mean: f64) -> Result<(), Refusal> {
        let good = mean == 0.0 || mean.is_nan() || (LEAST..=1.0 / LEAST).contains(&mean.abs());
        if good { Ok(()) } else { Err(Refusal::UnitOutOfRange { what: "mean pressure", found: mean }) }
    }
}

/// Watcher that converts to the units of the input.
struct ScaledWatch<'a> {
    watch: &'a mut dyn Watch,
    units: Units,
    u: Vec<f64>,
}

impl Watch for ScaledWatch<'_> {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self.watch.see(now)
    }

    fn layer(&mut self, energy: f64, u: &[f64]) {
        if self.units.are_one() {
            return self.watch.layer(energy, u);
        }
        self.u.clear();
        self.u.extend(u.iter().map(|u| u * self.units.length()));
        self.watch.layer(energy * self.units.energy(), &self.u);
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        self.watch.checkpoint(variables);
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        self.watch.recall()
    }
}

/// Returns the longer side of the cell; the side of a profile.
fn longest(grid: &Grid) -> f64 {
    let sides = if grid.is_line() { 1 } else { 2 };
    grid.lengths()[..sides].iter().copied().fold(0.0, f64::max)
}
