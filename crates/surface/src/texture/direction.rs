use std::f64::consts::TAU;

use gfmd_field::Grid;

use crate::PowerSpectrum;

/// Largest texture aspect ratio Str for which a surface has a direction.
const ISOTROPIC: f64 = 0.5;

/// Number of rays over half a turn.
const RAYS: usize = 180;

/// Direction of the texture. Angles are in degrees from the x axis, positive towards y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Direction of the wave vectors with the most power, from 0 to 180, in steps of one degree. The lay is normal to
    /// it. `None` if Str may be above 0.5, or for a profile.
    pub wave: Option<f64>,
    /// Direction of the largest mean square slope, above −90 to 90: what a contact feels. `None` if all directions are
    /// equal to rounding, or for a profile.
    pub steepest: Option<f64>,
    /// Anisotropy of the mean square slopes: their largest minus their smallest value over all directions, divided by
    /// the sum of both. 0 if all directions are equal, 1 if all waves are parallel, (r² − 1)/(r² + 1) for a spectrum
    /// with the aspect ratio r; `None` for a flat surface or a profile.
    pub anisotropy: Option<f64>,
    /// Ssw: wavelength of the wave with the largest amplitude, length; `None` for a flat surface.
    pub ssw: Option<f64>,
}

impl Direction {
    /// Computes the direction from the spectrum, and from an upper bound of Str of the autocorrelation, if known
    /// ([`CorrelationLengths::largest_aspect`](super::CorrelationLengths::largest_aspect)).
    ///
    /// Std of ISO 25178-2, 4.3, is the largest ∫ |h̃|² f df over rays of frequencies f, from the inverse of the shorter
    /// side to the lower Nyquist frequency. |h̃|² is bilinear between the modes: sums of modes over sectors would
    /// prefer the axes, on which more modes lie.
    pub fn of(spectrum: &PowerSpectrum, str: Option<f64>) -> Self {
        let grid = spectrum.grid();
        let mut largest: Option<(f64, f64)> = None;
        let [mut xx, mut yy, mut xy] = [0.0; 3];
        for (mode, power) in grid.modes().zip(spectrum.power()).filter(|(mode, _)| !mode.is_uniform()) {
            if *power > largest.map_or(0.0, |(power, _)| power) {
                largest = Some((*power, TAU / mode.wavenumber()));
            }
            // The derivative of a wave at the Nyquist number of its axis is zero at the points.
            let [x, y] = [0, 1].map(|axis| if mode.nyquist[axis] { 0.0 } else { mode.wavevector[axis] });
            let own = mode.weight * power;
            (xx, yy, xy) = (xx + own * x * x, yy + own * y * y, xy + own * x * y);
        }
        let flat = spectrum.cut_offs().is_none();
        let is_surface = !grid.is_line() && !flat;
        let anisotropy = (xx - yy).hypot(2.0 * xy);
        Self {
            wave: str.filter(|str| is_surface && *str <= ISOTROPIC).map(|_| ray(spectrum)),
            steepest: (is_surface && anisotropy > 1e-12 * (xx + yy))
                .then(|| (0.5 * (2.0 * xy).atan2(xx - yy)).to_degrees()),
            anisotropy: is_surface.then(|| anisotropy / (xx + yy)),
            ssw: largest.filter(|_| !flat).map(|(_, wavelength)| wavelength),
        }
    }

    /// Returns Std of ISO 25178-2: the direction of the lay, normal to the wave vectors, from 0 to 180.
    pub fn lay(&self) -> Option<f64> {
        self.wave.map(|wave| (wave + 90.0) % 180.0)
    }
}

/// Returns the angle of the ray with the largest integral of the power, in degrees.
fn ray(spectrum: &PowerSpectrum) -> f64 {
    let grid = spectrum.grid();
    let (lengths, spacing) = (grid.lengths(), grid.spacing());
    let [shorter, longer] = [lengths[0].min(lengths[1]), lengths[0].max(lengths[1])];
    let nyquist = 0.5 / spacing[0].max(spacing[1]);
    let step = 0.5 / longer;
    let count = ((nyquist - 1.0 / shorter) / step).max(0.0) as usize;
    let along = |angle: usize| -> f64 {
        let (y, x) = (angle as f64 * 180.0 / RAYS as f64).to_radians().sin_cos();
        let at = |k: usize| {
            let frequency = 1.0 / shorter + k as f64 * step;
            frequency * between(spectrum, grid, [frequency * x * lengths[0], frequency * y * lengths[1]])
        };
        (0..=count).map(at).sum()
    };
    let mut best = (0, f64::NEG_INFINITY);
    for angle in 0..RAYS {
        let own = along(angle);
        if own > best.1 {
            best = (angle, own);
        }
    }
    best.0 as f64 * 180.0 / RAYS as f64
}

/// Returns |h̃|², bilinear between the modes at these numbers of waves along the sides.
fn between(spectrum: &PowerSpectrum, grid: &Grid, number: [f64; 2]) -> f64 {
    let [x, y] = number.map(f64::floor);
    let [u, v] = [number[0] - x, number[1] - y];
    let at = |a: f64, b: f64| {
        let number = [(x + a) as i64, (y + b) as i64];
        let held = grid.index_of(number).or_else(|| grid.index_of(number.map(|number| -number)));
        held.map_or(0.0, |index| spectrum.power()[index])
    };
    (1.0 - u) * ((1.0 - v) * at(0.0, 0.0) + v * at(0.0, 1.0)) + u * ((1.0 - v) * at(1.0, 0.0) + v * at(1.0, 1.0))
}
