//! Surfaces of a sweep, by the configured method.

use gfmd_field::Transform;
use gfmd_surface::{Anisotropy, Displaced, PowerSpectrum, RealSpace, RollOff, RollOffShape, SelfAffine, SurfaceError};
use ndarray::{Array2, s};

use crate::config::{Method, SurfaceConfig};
use crate::plan::Point;

impl SurfaceConfig {
    /// Generates the heights of realisation `seed` of a point, on a cell of length 1, scaled to the rms gradient.
    pub(crate) fn heights(&self, point: &Point, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        let of_spectrum = |hurst: f64| {
            let spectrum = self.spectrum(point, hurst);
            match &self.marginal {
                Some(marginal) => marginal.heights(&spectrum, &point.grid, seed),
                None => spectrum.heights(&point.grid, seed),
            }
        };
        let displaced = match self.method {
            Method::Psd => return of_spectrum(point.hurst),
            Method::Printed => return of_spectrum(1.0 + 2.0 * point.hurst),
            Method::Sra => Displaced::AllPoints,
            Method::Rmd => Displaced::Midpoints,
        };
        let made = self.subdivided(point, displaced, seed)?;
        let gradient = PowerSpectrum::of(&made, &point.grid)?.moments().rms_gradient();
        Ok(made * (self.rms_gradient / gradient))
    }

    fn spectrum(&self, point: &Point, hurst: f64) -> SelfAffine {
        let wavelength = self.roll_off * point.discretisation.longest_wavelength(1.0);
        let roll_off = (self.roll_off < 1.0).then_some(RollOff { wavelength, shape: RollOffShape::Plateau });
        let anisotropy = (self.aspect > 1.0).then_some(Anisotropy { aspect: self.aspect, lay: self.lay });
        let family = SelfAffine { hurst, roll_off, anisotropy, ..SelfAffine::with_rms_gradient(self.rms_gradient) };
        point.discretisation.self_affine(1.0, family)
    }

    /// Generates a surface by subdivision, cropped to the grid and restricted to waves between the cut-offs.
    fn subdivided(&self, point: &Point, displaced: Displaced, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        let (grid, [nx, ny]) = (point.grid, point.grid.points());
        let subdivisions = nx.next_power_of_two().ilog2().max(1);
        let generator = RealSpace { hurst: point.hurst, subdivisions, rms_increment: 1.0, displaced };
        let made = if grid.is_line() { generator.profile(seed)? } else { generator.surface(seed)? };
        let made: Vec<f64> = made.slice(s![..nx, ..ny]).iter().copied().collect();
        let [longest, shortest] =
            [point.discretisation.longest_wavelength(1.0), point.discretisation.shortest_wavelength(1.0)];
        // Rounding must not decide about waves on the cut-off rings.
        let ring = (1.0 - 1e-9) / longest..=(1.0 + 1e-9) / shortest;
        let number = |mode: &gfmd_field::Mode| (mode.number[0] as f64).hypot(mode.number[1] as f64);
        let kernel: Vec<f64> = grid.modes().map(|mode| f64::from(u8::from(ring.contains(&number(&mode))))).collect();
        let transform = Transform::new(grid);
        let mut heights = vec![0.0; grid.len()];
        transform.convolve(&kernel, &made, &mut heights, &mut transform.workspace())?;
        let found = [heights.len(), 1];
        Array2::from_shape_vec((nx, ny), heights).map_err(|_| SurfaceError::Shape { found, expected: [nx, ny] })
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::{Config, Plan};

    fn made(text: &str) -> (Point, Array2<f64>) {
        let config: Config = toml::from_str(text).unwrap();
        let plan = Plan::new(config).unwrap();
        let point = *plan.points.last().unwrap();
        (point, plan.config.surface.heights(&point, 5).unwrap())
    }

    const POINT: &str =
        "\n[points]\ndesign = \"grid\"\neps_t_inv = [2]\neps_f_inv = [8]\neps_c_inv = [4]\n[fit]\nalpha_f = 1.0\n";

    #[test]
    fn every_method_has_the_gradient_and_no_wave_beyond_the_cut_offs() {
        for (method, hurst) in [("psd", 0.5), ("sra", 0.5), ("rmd", 0.8), ("printed", 0.0)] {
            let (point, heights) = made(&format!("[surface]\nhurst = [{hurst}]\nmethod = \"{method}\"{POINT}"));
            let spectrum = PowerSpectrum::of(&heights, &point.grid).unwrap();
            assert_relative_eq!(spectrum.moments().rms_gradient(), 0.1, max_relative = 1e-10);
            // Power outside the ring, from a separate transform.
            let transform = Transform::new(point.grid);
            let mut found = vec![num_complex::Complex64::ZERO; point.grid.spectrum_len()];
            let field: Vec<f64> = heights.iter().copied().collect();
            transform.forward(&field, &mut found, &mut transform.workspace()).unwrap();
            let (mut inside, mut outside) = (0.0, 0.0);
            for (value, mode) in found.iter().zip(point.grid.modes()) {
                let number = (mode.number[0] as f64).hypot(mode.number[1] as f64);
                let sum = if (2.0..=16.0).contains(&number) { &mut inside } else { &mut outside };
                *sum += value.norm_sqr();
            }
            assert!(outside < 1e-20 * inside, "{method}: {outside:e} of {inside:e}");
        }
    }

    #[test]
    fn the_printed_exponent_is_another_hurst_exponent() {
        // h ~ Delta/q^(2(1+H)) instead of q^(1+H): at H = 0 the surface with H = 1.
        let (_, printed) = made(&format!("[surface]\nhurst = [0.0]\nmethod = \"printed\"{POINT}"));
        let (_, one) = made(&format!("[surface]\nhurst = [1.0]{POINT}"));
        assert_eq!(printed, one);
        let (_, zero) = made(&format!("[surface]\nhurst = [0.0]{POINT}"));
        assert_ne!(printed, zero);
    }

    #[test]
    fn a_lay_makes_waves_longer_along_it() {
        let slopes = |text: &str| {
            let (point, heights) = made(&format!("[surface]\nhurst = [0.8]\n{text}{POINT}"));
            let slope = |axis: usize| {
                let [nx, ny] = point.grid.points();
                let ahead = |i: usize, j: usize| {
                    if axis == 0 { heights[[(i + 1) % nx, j]] } else { heights[[i, (j + 1) % ny]] }
                };
                heights.indexed_iter().map(|((i, j), height)| (ahead(i, j) - height).powi(2)).sum::<f64>()
            };
            slope(0) / slope(1)
        };
        // The mean square slopes along and across the lay have the ratio 1/R².
        let ratio = slopes("aspect = 2.0\n") / slopes("");
        assert!((ratio.ln() + 4.0_f64.ln()).abs() < 0.7, "{ratio}");
        let turned = slopes("aspect = 2.0\nlay = 90.0\n") / slopes("");
        assert!((turned.ln() - 4.0_f64.ln()).abs() < 0.7, "{turned}");
    }

    #[test]
    fn a_roll_off_takes_height_from_the_longest_waves() {
        let rms = |roll_off: &str| {
            let (point, heights) = made(&format!("[surface]\nhurst = [0.8]\n{roll_off}{POINT}"));
            PowerSpectrum::of(&heights, &point.grid).unwrap().moments().rms_height()
        };
        assert_eq!(rms(""), rms("roll_off = 1.0"));
        assert!(rms("roll_off = 0.25") < 0.8 * rms(""));
    }

    #[test]
    fn methods_that_do_not_apply_are_refused() {
        let refused = |text: &str, said: &str| {
            let config: Config = toml::from_str(text).unwrap();
            let message = config.check().unwrap_err().to_string();
            assert!(message.starts_with(said), "{message}");
        };
        refused("surface.method = \"printed\"\nfit.alpha_f = 1.0", "surface.hurst is [0.8]; it must be [0.0]");
        refused("surface.method = \"printed\"\nsurface.hurst = [0.0]", "fit.alpha_f is \"self-affine\"; it must be");
        refused("surface.method = \"sra\"\nsurface.roll_off = 0.5", "surface.roll_off is 0.5; it must be 1");
        refused("surface.roll_off = 0.0", "surface.roll_off is 0.0; it must be above 0");
    }
}
