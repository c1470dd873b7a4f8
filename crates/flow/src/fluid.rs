/// Fluid that a pressure drop drives through the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Viscosity, stress times time.
    pub viscosity: f64,
    /// Pressure drop over the length of the cell along the flow, stress.
    pub pressure_drop: f64,
}

impl Fluid {
    /// Returns the volume per time through a cell of `lengths` along `axis` (0: x, 1: y), by Poiseuille's law for the
    /// mean gap times the `conductivity` relative to a uniform gap (theory.md, section 9.1).
    pub fn leak(&self, axis: usize, conductivity: f64, mean_gap: f64, lengths: [f64; 2]) -> f64 {
        let width_over_length = lengths[1 - axis] / lengths[axis];
        conductivity * mean_gap.powi(3) / 12.0 * width_over_length * self.pressure_drop / self.viscosity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Water between plates 10 µm apart, 2 mm wide and 5 mm long, under 1 bar: b h³ Δp / (12 η L).
    #[test]
    fn a_uniform_gap_leaks_as_poiseuille_says() {
        let water = Fluid { viscosity: 1e-3, pressure_drop: 1e5 };
        let lengths = [5e-3, 2e-3];
        let along = water.leak(0, 1.0, 1e-5, lengths);
        assert!((along / (2e-3 * 1e-15 * 1e5 / (12.0 * 1e-3 * 5e-3)) - 1.0).abs() < 1e-12);
        assert!((water.leak(1, 1.0, 1e-5, lengths) / along - 6.25).abs() < 1e-12);
        assert!(water.leak(0, 0.0, 1e-5, lengths) == 0.0);
    }
}
