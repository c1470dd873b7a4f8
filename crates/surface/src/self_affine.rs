use gfmd_field::{Grid, Mode};

use crate::SurfaceError;
use crate::error::positive;
use crate::names::named;

/// Relative tolerance in squared wavenumber for a mode at the edge of the ring. It lies far above the rounding error of
/// |q|² and far below the distance between rings of integer wave numbers.
const ON_THE_RING: f64 = 1e-12;

/// Spectrum of a self-affine surface or profile (theory.md, section 9): a power law in a ring, isotropic unless the
/// surface has a direction.
///
/// Modes with shortest ≤ 2π/|q| ≤ longest, both ends included, carry ⟨|h̃|²⟩ ∝ q^{−2(1+H)} on a surface and ∝
/// q^{−(1+2H)} on a profile, unless there is a roll-off; all other modes are zero. A line grid makes a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfAffine {
    /// Hurst exponent H, from 0 to 1.
    pub hurst: f64,
    /// Longest wavelength λ_l, length: at most the (longer) side of the cell.
    pub longest_wavelength: f64,
    /// Shortest wavelength λ_s, length: at least two grid spacings.
    pub shortest_wavelength: f64,
    /// Roll-off of the power law at long wavelengths; `None` if the power law extends to the longest wavelength.
    pub roll_off: Option<RollOff>,
    /// Size of the scaled heights.
    pub normalisation: Normalisation,
    /// Sum that determines the scaling factor.
    pub scaling: Scaling,
    /// Distribution of mode amplitudes.
    pub amplitudes: Amplitudes,
    /// Preferred direction of a surface; `None` if the spectrum is isotropic.
    pub anisotropy: Option<Anisotropy>,
}

/// Preferred direction of a surface: the isotropic spectrum of stretched wave vectors, C(√r q∥, q⊥/√r). Waves along the
/// lay are longer by √r, waves across it are shorter by √r, and Str of ISO 25178 is 1/r on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// Ratio r of the correlation lengths along and across the lay, at least 1.
    pub aspect: f64,
    /// Direction of the lay from the x axis, positive towards y, in degrees.
    pub lay: f64,
}

impl Anisotropy {
    /// Returns the factor √r on wavelengths along the lay.
    pub fn stretch(&self) -> f64 {
        self.aspect.sqrt()
    }

    /// Returns the matrix that turns wave vectors into stretched ones, along and across the lay.
    fn matrix(&self) -> [[f64; 2]; 2] {
        // Right angles are exact, so that a lay along an axis keeps the symmetry of the cell.
        let (sin, cos) = match self.lay.rem_euclid(180.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            lay => lay.to_radians().sin_cos(),
        };
        let stretch = self.stretch();
        [[cos * stretch, sin * stretch], [-sin / stretch, cos / stretch]]
    }
}

/// Roll-off: the spectrum from the roll-off wavelength λ_r = 2π/q_r up to the longest wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollOff {
    /// Roll-off wavelength λ_r, length: between the shortest and the longest wavelength.
    pub wavelength: f64,
    /// Form of the crossover.
    pub shape: RollOffShape,
}

/// Form of the crossover from the power law to the flat part of a spectrum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RollOffShape {
    /// C(q) = C(q_r) for q < q_r: a plateau with a kink at q_r.
    #[default]
    Plateau,
    /// C(q) ∝ (1 + (q/q_r)²)^{−(1+H)} at all q (−(½+H) for a profile): a smooth crossover around q_r.
    Smooth,
}

named! { RollOffShape, "roll-off shape":
    Plateau = "plateau", "constant beyond the roll-off wavelength";
    Smooth = "smooth", "(1 + (q/q_r)²)^-(1+H)";
}

/// Size to which a common factor scales all heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normalisation {
    /// Root-mean-square of the full gradient |∇h|, spectral: ḡ² = Σ q²|h̃|². Dimensionless.
    RmsGradient(f64),
    /// Root-mean-square height: h_rms² = Σ |h̃|². Length.
    RmsHeight(f64),
}

/// Sum that determines the scaling factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Sum of the realisation: every surface has exactly the given size.
    EachRealisation,
    /// Expected sum: the mean square over many seeds has the given size, and individual surfaces fluctuate about it.
    Ensemble,
}

/// Distribution of mode amplitudes. Phases are uniform and do not depend on this choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Amplitudes {
    /// Normally distributed real and imaginary parts: a Gaussian random surface.
    #[default]
    Gaussian,
    /// Every |h̃| equal to its expected root-mean-square: random phases only, a spectrum without noise.
    Fixed,
}

named! { Amplitudes, "kind of amplitudes":
    Gaussian = "gaussian", "normally distributed real and imaginary parts";
    Fixed = "fixed", "the expected values, with random phases";
}

impl SelfAffine {
    /// Returns a spectrum with Gaussian amplitudes and without roll-off, every realisation scaled to the spectral
    /// `rms_gradient`.
    ///
    /// The Hurst exponent and the two wavelengths have no defaults. They are NaN here, which every use of the spectrum
    /// refuses, and must be set in a struct literal:
    ///
    /// ```
    /// use gfmd_field::Grid;
    /// use gfmd_surface::{SelfAffine, SurfaceError};
    ///
    /// let rough = SelfAffine {
    ///     hurst: 0.8,
    ///     longest_wavelength: 0.5,
    ///     shortest_wavelength: 1.0 / 16.0,
    ///     ..SelfAffine::with_rms_gradient(0.1)
    /// };
    /// let grid = Grid::square(64, 1.0)?;
    /// assert_eq!(rough.heights(&grid, 1)?.dim(), (64, 64));
    /// let forgotten = SelfAffine { hurst: f64::NAN, ..rough };
    /// assert!(matches!(forgotten.heights(&grid, 1), Err(SurfaceError::Hurst(_))));
    /// # Ok::<(), SurfaceError>(())
    /// ```
    pub fn with_rms_gradient(rms_gradient: f64) -> Self {
        Self {
            hurst: f64::NAN,
            longest_wavelength: f64::NAN,
            shortest_wavelength: f64::NAN,
            roll_off: None,
            normalisation: Normalisation::RmsGradient(rms_gradient),
            scaling: Scaling::EachRealisation,
            amplitudes: Amplitudes::Gaussian,
            anisotropy: None,
        }
    }

    /// Checks the spectrum on one grid.
    pub(crate) fn on(&self, grid: &Grid) -> Result<Band, SurfaceError> {
        let Self { hurst, longest_wavelength: longest, shortest_wavelength: shortest, .. } = *self;
        if !(0.0..=1.0).contains(&hurst) {
            return Err(SurfaceError::Hurst(hurst));
        }
        if !(shortest > 0.0 && shortest <= longest * (1.0 + ON_THE_RING) && longest.is_finite()) {
            return Err(SurfaceError::Wavelengths { shortest, longest });
        }
        match self.normalisation {
            Normalisation::RmsGradient(found) => positive("rms gradient", found)?,
            Normalisation::RmsHeight(found) => positive("rms height", found)?,
        };
        let ([nx, ny], lengths, spacing) = (grid.points(), grid.lengths(), grid.spacing());
        if nx == 1 && ny > 1 {
            return Err(SurfaceError::ProfileAxis([nx, ny]));
        }
        let [length, allowed] = if grid.is_line() {
            [lengths[0], 2.0 * spacing[0]]
        } else {
            [lengths[0].max(lengths[1]), 2.0 * spacing[0].max(spacing[1])]
        };
        let stretch = match self.anisotropy {
            None => 1.0,
            Some(anisotropy) => {
                if !(anisotropy.aspect >= 1.0 && anisotropy.aspect.is_finite() && anisotropy.lay.is_finite()) {
                    return Err(SurfaceError::Anisotropy { aspect: anisotropy.aspect, lay: anisotropy.lay });
                }
                if grid.is_line() {
                    return Err(SurfaceError::DirectionOfProfile);
                }
                anisotropy.stretch()
            }
        };
        if longest * stretch > length * (1.0 + ON_THE_RING) {
            return Err(SurfaceError::LongerThanCell { longest: longest * stretch, length });
        }
        if shortest / stretch < allowed * (1.0 - ON_THE_RING) {
            return Err(SurfaceError::BeyondNyquist { shortest: shortest / stretch, allowed });
        }
        let (floor, smooth) = match self.roll_off {
            None => (0.0, None),
            Some(RollOff { wavelength, shape: RollOffShape::Plateau }) => (self.between(wavelength)?, None),
            Some(RollOff { wavelength, shape: RollOffShape::Smooth }) => (0.0, Some(self.between(wavelength)?)),
        };
        let exponent = if grid.is_line() { 0.5 + hurst } else { 1.0 + hurst };
        let ring =
            Ring { matrix: self.anisotropy.map(|anisotropy| anisotropy.matrix()), ..Ring::new(shortest, longest) };
        Ok(Band { ring, lengths, exponent, floor, smooth })
    }

    /// Returns the square (λ_s/λ_r)² if the roll-off wavelength lies between the cut-offs.
    fn between(&self, found: f64) -> Result<f64, SurfaceError> {
        let Self { shortest_wavelength: shortest, longest_wavelength: longest, .. } = *self;
        if found >= shortest * (1.0 - ON_THE_RING) && found <= longest * (1.0 + ON_THE_RING) {
            Ok((shortest / found).powi(2))
        } else {
            Err(SurfaceError::RollOff { found, shortest, longest })
        }
    }
}

/// Modes with wavelengths from `shortest` to `longest`, both included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    shortest: f64,
    least: f64,
    /// Matrix that turns wave vectors into stretched ones.
    matrix: Option<[[f64; 2]; 2]>,
}

impl Ring {
    pub(crate) fn new(shortest: f64, longest: f64) -> Self {
        Self { shortest, least: (shortest / longest).powi(2) * (1.0 - ON_THE_RING), matrix: None }
    }

    /// Returns the square (|q|/q_s)² if the mode is in the ring. It is computed from the wave numbers, so that it
    /// depends on the cell and not on the grid.
    pub(crate) fn position(&self, mode: &Mode, lengths: [f64; 2]) -> Option<f64> {
        let own = [0, 1].map(|axis| mode.number[axis] as f64 * self.shortest / lengths[axis]);
        let [x, y] = self.matrix.map_or(own, |matrix| matrix.map(|row| row[0] * own[0] + row[1] * own[1]));
        let square = x * x + y * y;
        (square >= self.least && square <= 1.0 + ON_THE_RING && !mode.is_uniform()).then_some(square)
    }
}

/// Checked spectrum on a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    ring: Ring,
    lengths: [f64; 2],
    /// Exponent in C(q) ∝ (q²)^{−exponent}.
    exponent: f64,
    /// Square (q_r/q_s)² of a plateau, or zero.
    floor: f64,
    /// Square (q_r/q_s)² of a smooth roll-off.
    smooth: Option<f64>,
}

impl Band {
    /// Returns the expected |h̃|² of `mode` up to a common factor, or `None` outside the ring.
    ///
    /// A Nyquist mode that is not its own conjugate has |q| > q_s. It is excluded, since its mirror image is not on the
    /// grid; only the tolerance in an extremely elongated cell could include it.
    pub(crate) fn power(&self, mode: &Mode) -> Option<f64> {
        if mode.nyquist.contains(&true) && !mode.is_self_conjugate() {
            return None;
        }
        let square = self.ring.position(mode, self.lengths)?;
        Some(match self.smooth {
            Some(corner) => (corner + square).powf(-self.exponent),
            None => square.max(self.floor).powf(-self.exponent),
        })
    }
}
