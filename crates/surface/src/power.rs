use std::f64::consts::TAU;

use gfmd_field::{Grid, Share, Transform};
use ndarray::ArrayRef2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::moments::{Moments, Sums, own_modes};
use crate::self_affine::Ring;
use crate::statistics::checked;
use crate::{Dimension, SurfaceError};

/// Relative tolerance to detect a wave half-way between two rings or at the end of the last one, far above the rounding
/// error of |q|.
const ON_THE_EDGE: f64 = 1e-12;

/// Fraction of h_rms² above which |h̃|² counts as power. It lies above the rounding error of heights stored in single
/// precision (3·10⁻¹⁶/N per mode of N) and below the shortest waves of any spectrum with λ_l/λ_s < 10⁴.
const CARRIES_POWER: f64 = 1e-17;

/// Largest magnitude of the exponent s of C ∝ q^{−s} in the search.
const STEEPEST: f64 = 64.0;

/// Largest number of steps of the search: bisection needs 45, Newton's method about 6.
const MOST_STEPS: usize = 100;

/// Power |h̃(q)|² of every mode of a surface.
pub struct PowerSpectrum {
    grid: Grid,
    /// |h̃|², laid out as [`Grid::modes`].
    power: Vec<f64>,
    moments: Moments,
}

/// Power spectral density of the modes in one ring of wavenumbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadialBin {
    /// Mean |q| of the modes in the ring, rad/length.
    pub wavenumber: f64,
    /// Mean of C2D = (Lx Ly/4π²)|h̃|² in length⁴, or of C1D = (L/2π)|h̃|² in length³ for a profile.
    pub density: f64,
    /// Number of modes of the full spectrum in the ring: ±q count as two.
    pub modes: f64,
}

/// Power law fitted to a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HurstFit {
    /// Hurst exponent H in C2D ∝ q^{−2(1+H)} or C1D ∝ q^{−(1+2H)}, not restricted to \[0, 1\].
    pub hurst: f64,
    /// Standard error of H for independent Gaussian modes: 1/(2 √Σ(ln q − ⟨ln q⟩)²), summed over pairs ±q.
    pub standard_error: f64,
    /// Number of pairs ±q in the fit.
    pub pairs: usize,
    /// Longest and shortest wavelengths of the fit range, length.
    pub range: [f64; 2],
}

impl PowerSpectrum {
    /// Computes the spectrum of `heights`, shape `[nx, ny]`, as one period. The mean height does not enter the moments.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid) -> Result<Self, SurfaceError> {
        let (nx, ny) = heights.dim();
        let (power, moments) = power_over(&checked(heights, grid)?, grid, &Share::whole(nx, ny))?;
        Ok(Self { grid: *grid, power, moments })
    }

    /// Returns the power |h̃(q)|² in length², laid out as [`Grid::modes`].
    pub fn power(&self) -> &[f64] {
        &self.power
    }

    /// Returns the grid of the heights.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the moments over all q ≠ 0.
    pub fn moments(&self) -> Moments {
        self.moments
    }

    /// Returns the radially averaged power spectral density in rings of width q₀ = 2π/min(Lx, Ly) centred on the
    /// multiples of q₀, up to the smaller Nyquist wavenumber. Beyond it the corners of the spectrum cut the rings. A
    /// wave half-way between two multiples, up to rounding of its wavenumber, is in the ring of the larger one. For a
    /// profile every mode is a ring.
    pub fn radial(&self) -> Vec<RadialBin> {
        let [lengths, points] = [self.grid.lengths(), self.grid.points().map(|n| n as f64)];
        let along = if self.grid.is_line() { 1 } else { 2 };
        let cell = lengths[..along].iter().copied().fold(f64::INFINITY, f64::min);
        let nyquist = (0..along).map(|axis| 0.5 * points[axis] / lengths[axis]).fold(f64::INFINITY, f64::min);
        let rings = (nyquist * cell * (1.0 + ON_THE_EDGE)).floor() as usize;
        let mut bins = vec![[0.0; 3]; rings + 1];
        for (mode, power) in self.grid.modes().zip(&self.power) {
            let ring = (mode.wavenumber() * cell / TAU * (1.0 + ON_THE_EDGE)).round() as usize;
            if let Some(bin) = bins.get_mut(ring).filter(|_| !mode.is_uniform()) {
                bin[0] += mode.weight;
                bin[1] += mode.weight * mode.wavenumber();
                bin[2] += mode.weight * power;
            }
        }
        let per_mode: f64 = lengths[..along].iter().map(|length| length / TAU).product();
        bins.into_iter()
            .filter(|bin| bin[0] > 0.0)
            .map(|[modes, q, power]| RadialBin { wavenumber: q / modes, density: per_mode * power / modes, modes })
            .collect()
    }

    /// Returns the mean of (h(x) − ⟨h⟩)(h(x+d) − ⟨h⟩) over all points of the period at every distance d, laid out as
    /// the heights; length².
    ///
    /// # Errors
    /// Never fails for a spectrum of heights.
    pub fn correlation(&self) -> Result<Vec<f64>, SurfaceError> {
        let mut power = self.power.clone();
        // The mean height does not contribute.
        power[0] = 0.0;
        // The transform of the power is its convolution with a point source at the origin.
        let transform = Transform::new(self.grid);
        let (mut unit, mut correlation) = (vec![0.0; self.grid.len()], vec![0.0; self.grid.len()]);
        unit[0] = self.grid.len() as f64;
        transform.convolve(&power, &unit, &mut correlation, &mut transform.workspace())?;
        Ok(correlation)
    }

    /// Returns the longest and shortest wavelengths of modes that carry power, the cut-offs of the heights, in length.
    /// `None` for a flat surface. A mode carries power if |h̃|² > 10⁻¹⁷ h_rms²; in a non-periodic scan all modes do.
    pub fn cut_offs(&self) -> Option<[f64; 2]> {
        let floor = CARRIES_POWER * self.moments.mean_square_height;
        let mut ends: Option<[f64; 2]> = None;
        for (mode, power) in self.grid.modes().zip(&self.power) {
            if *power > floor && !mode.is_uniform() {
                let q = mode.wavenumber();
                let [least, most] = ends.unwrap_or([q, q]);
                ends = Some([least.min(q), most.max(q)]);
            }
        }
        ends.map(|ends| ends.map(|q| TAU / q))
    }

    /// Fits the Hurst exponent to the modes with wavelengths from `longest` to `shortest`, both included.
    ///
    /// The fit maximises the likelihood of independent Gaussian modes, with |h̃|² distributed exponentially about c
    /// q^{−s}, over c and s (Whittle's estimate). Unlike a straight line in a logarithmic plot, it has no bias from the
    /// logarithm of noise or from bins. Windows and mirrors correlate the modes, so that the standard error is too
    /// small for them.
    ///
    /// # Errors
    /// Wavelengths out of order; fewer than two different wavenumbers with power in the range.
    pub fn fit_hurst(&self, longest: f64, shortest: f64) -> Result<HurstFit, SurfaceError> {
        if !(shortest > 0.0 && shortest <= longest && longest.is_finite()) {
            return Err(SurfaceError::Wavelengths { shortest, longest });
        }
        let (ring, lengths) = (Ring::new(shortest, longest), self.grid.lengths());
        let samples: Vec<Sample> = self
            .grid
            .modes()
            .zip(&self.power)
            .filter(|(_, power)| **power > 0.0)
            .filter_map(|(mode, power)| {
                let square = ring.position(&mode, lengths)?;
                Some(Sample { log_q: 0.5 * square.ln(), power: *power, weight: mode.weight })
            })
            .collect();
        let total: f64 = samples.iter().map(|sample| sample.weight).sum();
        let mean = samples.iter().map(|sample| sample.weight * sample.log_q).sum::<f64>() / total;
        let spread: f64 = samples.iter().map(|sample| sample.weight * (sample.log_q - mean).powi(2)).sum();
        if samples.len() < 2 || spread <= 1e-12 * total {
            return Err(SurfaceError::Fit { shortest, longest, found: samples.len().min(1) });
        }
        let exponent = likeliest_exponent(&samples, mean);
        let hurst = match Dimension::of(&self.grid) {
            Dimension::Profile => 0.5 * (exponent - 1.0),
            Dimension::Surface => 0.5 * exponent - 1.0,
        };
        let pairs = (0.5 * total).round() as usize;
        Ok(HurstFit { hurst, standard_error: 0.5 / (0.5 * spread).sqrt(), pairs, range: [longest, shortest] })
    }
}

impl Moments {
    /// Computes the moments of distributed heights: each process passes the rows of its `share`, row by row. All
    /// processes get the moments of the whole surface.
    ///
    /// # Errors
    /// A number of heights that differs from the rows of this process.
    pub fn distributed(heights: &[f64], grid: &Grid, share: &Share) -> Result<Self, SurfaceError> {
        power_over(heights, grid, share).map(|(_, moments)| moments)
    }
}

/// Returns the power of the modes of this process and the moments of all modes for distributed heights: each process
/// passes the rows of its `share`.
pub(crate) fn power_over(heights: &[f64], grid: &Grid, share: &Share) -> Result<(Vec<f64>, Moments), SurfaceError> {
    let transform = Transform::distributed(*grid, share);
    let own = own_modes(grid, transform.lanes());
    let mut spectrum = vec![Complex64::ZERO; own.len()];
    transform.forward(heights, &mut spectrum, &mut transform.workspace())?;
    let power: Vec<f64> = spectrum.par_iter().map(Complex64::norm_sqr).collect();
    let sums = Sums::of_power(grid, share, &own, &power);
    Ok((power, Sums::moments(&sums, grid, 1.0)))
}

/// Mode of a fit.
struct Sample {
    log_q: f64,
    power: f64,
    weight: f64,
}

/// Returns the exponent s at which ⟨ln q⟩ weighted by |h̃|² q^s equals the plain ⟨ln q⟩. The difference rises with s,
/// since its slope is a variance. Solved by Newton's method, safeguarded by bisection.
fn likeliest_exponent(samples: &[Sample], mean: f64) -> f64 {
    let (mut low, mut high) = (-STEEPEST, STEEPEST);
    let mut exponent = 3.0;
    for _ in 0..MOST_STEPS {
        let scale = samples.iter().map(|x| exponent * x.log_q).fold(f64::NEG_INFINITY, f64::max);
        let mut sums = [0.0; 3];
        for sample in samples {
            let weight = sample.weight * sample.power * (exponent * sample.log_q - scale).exp();
            let log_q = sample.log_q - mean;
            sums = [sums[0] + weight, sums[1] + weight * log_q, sums[2] + weight * log_q * log_q];
        }
        let excess = sums[1] / sums[0];
        let slope = sums[2] / sums[0] - excess * excess;
        if excess > 0.0 {
            high = exponent
        } else {
            low = exponent
        }
        let newton = exponent - excess / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - exponent).abs() <= 1e-13 * STEEPEST {
            return next;
        }
        exponent = next;
    }
    exponent
}
