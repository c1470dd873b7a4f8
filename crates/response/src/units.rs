use gfmd_field::{Grid, Mode};
use gfmd_green::Body;

/// Numbers between the inverse of this number and this number are ordinary; 2¹⁰⁰ is about 10³⁰.
const ORDINARY: f64 = (1_u128 << 100) as f64;

/// Returns the power of two at or below a positive number, so that division by it is exact; 1 if the number is zero,
/// negative, subnormal, infinite or NaN.
pub fn power_of_two(number: f64) -> f64 {
    // The exponent bits alone.
    if number >= f64::MIN_POSITIVE && number.is_finite() {
        f64::from_bits(number.to_bits() & (0x7ff << 52))
    } else {
        1.0
    }
}

/// Returns the unit for numbers of the size of `number`: the power of two at or below it, or 1 for an ordinary number,
/// from 1e-30 to 1e30, for zero, and for a number that is not finite.
pub fn unit_of(number: f64) -> f64 {
    if !number.is_finite() || number == 0.0 || (1.0 / ORDINARY..=ORDINARY).contains(&number) {
        return 1.0;
    }
    // The exponent bits alone; a subnormal number has none.
    f64::from_bits(number.to_bits() & (0x7ff << 52)).max(f64::MIN_POSITIVE)
}

/// Body with stiffnesses in units of their own size, so that determinants, which are products of several stiffnesses,
/// do not overflow.
pub(crate) struct Scaled {
    pub(crate) body: Body,
    length: f64,
    /// Unit of stiffnesses.
    pub(crate) stiffness: f64,
}

impl Scaled {
    pub(crate) fn new(body: &Body, grid: &Grid) -> Self {
        let sides = if grid.is_line() { 1 } else { 2 };
        let length = unit_of(grid.lengths()[..sides].iter().copied().fold(0.0, f64::max));
        let stress = unit_of(body.contact_modulus());
        Self { body: body.in_units(stress, length), length, stiffness: stress / length }
    }

    pub(crate) fn mode(&self, mode: &Mode) -> Mode {
        Mode { wavevector: mode.wavevector.map(|q| q * self.length), ..*mode }
    }

    pub(crate) fn grid(&self, grid: &Grid) -> Grid {
        grid.in_units(self.length)
    }
}
