use std::f64::consts::{SQRT_2, TAU};

use gfmd_field::{Grid, Mode, Share, Transform};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::moments::{MODES_PER_TASK, Moments, Sums, first_task, own_modes, resolved};
use crate::random::{keyed, uniform_pair};
use crate::{Amplitudes, Normalisation, Scaling, SelfAffine, SurfaceError};

impl SelfAffine {
    /// Generates the heights (length) of realisation `seed` of this spectrum on `grid`, shape `[nx, ny]`, mean zero.
    ///
    /// The random numbers belong to the integer wave numbers (m, n) of the cell and not to the grid, so that a finer
    /// grid of the same cell samples the same surface. (At λ_s = 2a exactly, the modes at the Nyquist number are real
    /// and are drawn differently from the same modes of a finer grid.)
    ///
    /// # Errors
    /// A parameter out of range; a cell or grid that cannot hold the wavelengths; a ring without modes.
    pub fn heights(&self, grid: &Grid, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        let [nx, ny] = grid.points();
        self.heights_over(grid, seed, &Share::whole(nx, ny))
    }

    /// Generates the rows of [`heights`](Self::heights) in the `share` of this process. Each process draws its own
    /// modes. The heights are bitwise identical for any number of processes.
    ///
    /// # Errors
    /// The same errors as [`heights`](Self::heights), on all processes.
    pub fn heights_over(&self, grid: &Grid, seed: u64, share: &Share) -> Result<Array2<f64>, SurfaceError> {
        let transform = Transform::distributed(*grid, share);
        let spectrum = self.spectrum_over(grid, seed, &transform, share)?;
        let [_, ny] = grid.points();
        let mut heights = vec![0.0; share.own().len()];
        transform.inverse(&spectrum, &mut heights, &mut transform.workspace())?;
        let (found, expected) = ([heights.len(), 1], [heights.len() / ny, ny]);
        Array2::from_shape_vec(expected, heights).map_err(|_| SurfaceError::Shape { found, expected })
    }

    /// Returns the coefficients h̃(q) of the realisation `seed`, laid out as [`Grid::modes`] (theory.md, section 9).
    ///
    /// One mode of each pair ±q is drawn, the one with n > 0, or n = 0 and m > 0. Each has its own generator: `pcg64`
    /// (XSL-RR 128/64), default stream 0x0a02bdbf7bb3c0a7ac28fa16a64abf96, initial state hi·2⁶⁴ + lo with
    ///
    /// ```text
    /// lo = mix(mix(mix(seed) xor m) xor n), hi = mix(lo); m, n as 64-bit two's complement
    /// mix(x): z = x + 0x9e3779b97f4a7c15, z = (z xor z >> 30) 0xbf58476d1ce4e5b9,
    ///         z = (z xor z >> 27) 0x94d049bb133111eb, z xor z >> 31   (SplitMix64, modulo 2⁶⁴)
    /// ```
    ///
    /// The first two words, shifted right by 11 bits, are k₁ and k₂; U₁ = (k₁ + 1)/2⁵³ in (0, 1], U₂ = k₂/2⁵³. Then h̃
    /// = A √(−ln U₁) e^{2πi U₂}, or A √(−2 ln U₁) cos(2πU₂) if q and −q are the same mode, and h̃(−q) = h̃(q)*. NumPy's
    /// `PCG64` with this state gives the same heights (`data/reference/surface_heights.json`).
    ///
    /// # Errors
    /// As for [`SelfAffine::heights`].
    pub fn spectrum(&self, grid: &Grid, seed: u64) -> Result<Vec<Complex64>, SurfaceError> {
        let [nx, ny] = grid.points();
        self.spectrum_over(grid, seed, &Transform::new(*grid), &Share::whole(nx, ny))
    }

    /// Returns the coefficients of the lanes of this process, given by the plans of `transform`.
    fn spectrum_over(
        &self,
        grid: &Grid,
        seed: u64,
        transform: &Transform,
        share: &Share,
    ) -> Result<Vec<Complex64>, SurfaceError> {
        let band = self.on(grid)?;
        // Amplitude of a mode and the square that enters the scaling; `None` outside the ring.
        let drawn = |mode: &Mode| {
            let power = band.power(mode)?;
            let value = self.draw(mode, power, seed);
            Some((value, self.weighed(value.norm_sqr(), power)))
        };
        let own = own_modes(grid, transform.lanes());
        let mut spectrum = vec![Complex64::ZERO; own.len()];
        let first = first_task(&own);
        let (head, rest) = spectrum.split_at_mut(first - own.start);
        for (value, mode) in head.iter_mut().zip(modes_from(grid, own.start)) {
            *value = drawn(&mode).map_or(Complex64::ZERO, |(value, _)| value);
        }
        let resolved = resolved(grid);
        let sums = rest.par_chunks_mut(MODES_PER_TASK).enumerate().map(|(task, chunk)| {
            let mut sums = Sums::default();
            let start = first + task * MODES_PER_TASK;
            for (value, mode) in chunk.iter_mut().zip(modes_from(grid, start)) {
                if let Some((amplitude, square)) = drawn(&mode) {
                    *value = amplitude;
                    sums.add(&mode, square, resolved);
                }
            }
            // The last task extends into the modes of the next process, which any process can draw.
            for mode in modes_from(grid, start + chunk.len()).take(MODES_PER_TASK - chunk.len()) {
                if let Some((_, square)) = drawn(&mode) {
                    sums.add(&mode, square, resolved);
                }
            }
            sums
        });
        let sums = Sums::of_all(share, sums.collect());
        let factor = self.factor(&Sums::moments(&sums, grid, 1.0))?;
        spectrum.par_iter_mut().for_each(|value| *value *= factor);
        Ok(spectrum)
    }

    /// Returns the moments of the spectrum averaged over all seeds, with `Scaling::Ensemble` or `Amplitudes::Fixed`.
    /// They are discrete sums over the ring, not integrals.
    ///
    /// # Errors
    /// As for [`SelfAffine::heights`].
    pub fn expected_moments(&self, grid: &Grid) -> Result<Moments, SurfaceError> {
        let (band, resolved) = (self.on(grid)?, resolved(grid));
        let sums: Vec<Sums> = (0..grid.spectrum_len().div_ceil(MODES_PER_TASK))
            .into_par_iter()
            .map(|task| {
                let mut sums = Sums::default();
                for mode in modes_from(grid, task * MODES_PER_TASK).take(MODES_PER_TASK) {
                    if let Some(power) = band.power(&mode) {
                        sums.add(&mode, power, resolved);
                    }
                }
                sums
            })
            .collect();
        let factor = self.factor(&Sums::moments(&sums, grid, 1.0))?;
        Ok(Sums::moments(&sums, grid, factor * factor))
    }

    /// Draws the amplitude of the mode with the expected square `power`.
    fn draw(&self, mode: &Mode, power: f64, seed: u64) -> Complex64 {
        let [m, n] = mode.number;
        let mirrored = n < 0 || n == 0 && m < 0;
        let [u1, u2] = uniform_pair(&mut keyed(seed, if mirrored { [-m, -n] } else { [m, n] }));
        let size = match self.amplitudes {
            Amplitudes::Gaussian => (-u1.ln() * power).sqrt(),
            Amplitudes::Fixed => power.sqrt(),
        };
        let (sin, cos) = (TAU * u2).sin_cos();
        if mode.is_self_conjugate() {
            return match self.amplitudes {
                Amplitudes::Gaussian => Complex64::from(SQRT_2 * size * cos),
                Amplitudes::Fixed => Complex64::from(size.copysign(cos)),
            };
        }
        Complex64::new(size * cos, if mirrored { -size * sin } else { size * sin })
    }

    /// Returns the square that enters the scaling: the drawn or the expected one.
    fn weighed(&self, drawn: f64, expected: f64) -> f64 {
        match self.scaling {
            Scaling::EachRealisation => drawn,
            Scaling::Ensemble => expected,
        }
    }

    /// Returns the factor that scales the amplitudes to the given size.
    fn factor(&self, unscaled: &Moments) -> Result<f64, SurfaceError> {
        if unscaled.mean_square_height <= 0.0 {
            let Self { shortest_wavelength: shortest, longest_wavelength: longest, .. } = *self;
            return Err(SurfaceError::NoModes { shortest, longest });
        }
        Ok(match self.normalisation {
            Normalisation::RmsGradient(target) => target / unscaled.rms_gradient(),
            Normalisation::RmsHeight(target) => target / unscaled.rms_height(),
        })
    }
}

/// Iterates over the modes of the half spectrum from storage index `first` on.
fn modes_from(grid: &Grid, first: usize) -> impl Iterator<Item = Mode> + '_ {
    (first..grid.spectrum_len()).map(|index| grid.mode_at(index))
}
