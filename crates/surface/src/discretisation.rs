use crate::{SelfAffine, SurfaceError};

/// Largest number of points along an axis.
const MOST_POINTS: usize = 1 << 31;

/// Largest relative distance of 1/(ε_t ε_f ε_c) from a whole number, well above the rounding error of three factors.
const WHOLE: f64 = 1e-9;

/// Discretisation numbers of a self-affine spectrum in a cell of length L with spacing a (theory.md, section 9): n =
/// L/a = 1/(ε_t ε_f ε_c).
///
/// The numbers are given by their inverses, which need not be integers; the product of these must be an integer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discretisation {
    /// 1/ε_t = L/λ_l ≥ 1: cell length divided by the longest wavelength (thermodynamic limit).
    pub eps_t_inv: f64,
    /// 1/ε_f = λ_l/λ_s ≥ 1: longest divided by shortest wavelength (fractal limit).
    pub eps_f_inv: f64,
    /// 1/ε_c = λ_s/a ≥ 2: grid points per shortest wavelength (continuum limit); 2 is the Nyquist limit.
    pub eps_c_inv: f64,
}

impl Discretisation {
    /// Returns the number of points along one axis, n = 1/(ε_t ε_f ε_c).
    ///
    /// # Errors
    /// A number below its minimum or not finite; a product that is not a whole number or exceeds 2³¹.
    pub fn points(&self) -> Result<usize, SurfaceError> {
        let Self { eps_t_inv, eps_f_inv, eps_c_inv } = *self;
        for (name, found, least) in
            [("1/eps_t", eps_t_inv, 1.0), ("1/eps_f", eps_f_inv, 1.0), ("1/eps_c", eps_c_inv, 2.0)]
        {
            if !(found.is_finite() && found >= least) {
                return Err(SurfaceError::Discretisation { name, found, least });
            }
        }
        let product = eps_t_inv * eps_f_inv * eps_c_inv;
        if (product - product.round()).abs() > WHOLE * product || product > MOST_POINTS as f64 {
            return Err(SurfaceError::PointCount { product, most: MOST_POINTS });
        }
        Ok(product.round() as usize)
    }

    /// Returns the longest wavelength λ_l = ε_t L in a cell of `length` L.
    pub fn longest_wavelength(&self, length: f64) -> f64 {
        length / self.eps_t_inv
    }

    /// Returns the shortest wavelength λ_s = ε_f λ_l in a cell of `length` L.
    pub fn shortest_wavelength(&self, length: f64) -> f64 {
        length / (self.eps_t_inv * self.eps_f_inv)
    }

    /// Returns `spectrum` with the longest and shortest wavelengths set from these numbers in a cell of `length`.
    pub fn self_affine(&self, length: f64, spectrum: SelfAffine) -> SelfAffine {
        let (longest_wavelength, shortest_wavelength) =
            (self.longest_wavelength(length), self.shortest_wavelength(length));
        SelfAffine { longest_wavelength, shortest_wavelength, ..spectrum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inverses(eps_t_inv: f64, eps_f_inv: f64, eps_c_inv: f64) -> Discretisation {
        Discretisation { eps_t_inv, eps_f_inv, eps_c_inv }
    }

    #[test]
    fn points_are_the_product_whatever_the_factors() {
        assert_eq!(inverses(2.0, 256.0, 4.0).points(), Ok(2048));
        assert_eq!(inverses(1.5, 24.0, 3.0).points(), Ok(108));
        assert_eq!(inverses(1.1, 10.0, 3.0).points(), Ok(33));
        assert_eq!(inverses(1.0, 1.0, 2.0).points(), Ok(2));
    }

    #[test]
    fn wavelengths_and_spacing_follow_their_definitions() {
        let (length, numbers) = (3.7, inverses(1.5, 24.0, 3.0));
        let [longest, shortest] = [numbers.longest_wavelength(length), numbers.shortest_wavelength(length)];
        approx::assert_relative_eq!(longest / length, 1.0 / 1.5, max_relative = 1e-15);
        approx::assert_relative_eq!(shortest / longest, 1.0 / 24.0, max_relative = 1e-15);
        approx::assert_relative_eq!(length / 108.0 / shortest, 1.0 / 3.0, max_relative = 1e-15);
    }

    #[test]
    fn numbers_that_make_no_grid_are_refused() {
        let below = |name, found, least| Err(SurfaceError::Discretisation { name, found, least });
        assert_eq!(inverses(0.5, 8.0, 4.0).points(), below("1/eps_t", 0.5, 1.0));
        assert_eq!(inverses(2.0, 0.0, 4.0).points(), below("1/eps_f", 0.0, 1.0));
        assert_eq!(inverses(2.0, 8.0, 1.0).points(), below("1/eps_c", 1.0, 2.0));
        for hole in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(inverses(hole, 8.0, 4.0).points().is_err());
            assert!(inverses(2.0, hole, 4.0).points().is_err());
            assert!(inverses(2.0, 8.0, hole).points().is_err());
        }
        let product = |product| Err(SurfaceError::PointCount { product, most: MOST_POINTS });
        assert_eq!(inverses(1.5, 3.0, 3.0).points(), product(13.5));
        assert_eq!(inverses(1e5, 1e5, 4.0).points(), product(4e10));
    }
}
