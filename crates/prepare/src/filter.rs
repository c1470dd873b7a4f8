//! Filters that smooth heights with a nesting index: the wavelength at which half of the amplitude stays.

mod kernels;
mod regression;
mod robust;
mod spectral;
mod spline;

use ndarray::Array2;

use crate::PrepareError;
use crate::error::value;

/// Weights of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// Gaussian filter of ISO 16610-21 (profiles) and 16610-61 (areal); transmission 2^{−(L/λ)²}, nesting index L.
    Gaussian,
    /// Robust Gaussian regression of ISO 16610-31 and 16610-71: points far from the smooth surface get less weight.
    Robust,
    /// Spline of ISO 16610-22, for profiles. A tension of 1 keeps straight lines; 0.625242 is closest to the Gaussian.
    Spline {
        /// Tension, 0 to 1.
        tension: f64,
    },
}

/// Surroundings of a surface in a filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// The surface repeats.
    Periodic,
    /// Mirror images about lines half a spacing outside the last points. Equal to a periodic filter of the mirrored
    /// surface; a tilt flattens at the edges.
    Reflect,
    /// Nothing is known outside: at every point a polynomial with the least squared distance from the defined points,
    /// weighted by the kernel (ISO 16610-28).
    Regression,
}

/// Way to smooth heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// Weights.
    pub kernel: Kernel,
    /// Surroundings.
    pub edges: Edges,
    /// Degree of the polynomial of a regression, 0 to 2: 0 is the normalised kernel, 1 keeps planes, 2 paraboloids with
    /// the transmission (1 + t/λ²) e^{−t/λ²}.
    pub degree: usize,
}

impl Default for Filter {
    /// Gaussian regression of degree 1.
    fn default() -> Self {
        Self { kernel: Kernel::Gaussian, edges: Edges::Regression, degree: 1 }
    }
}

/// Smoothed heights.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// Long waves of the heights, at undefined points too; NaN where defined points have below 10⁻⁶ of the weights.
    pub heights: Array2<f64>,
    /// Passes of a robust filter; 1 for all others.
    pub passes: usize,
    /// Number of points that a robust filter gives no weight.
    pub rejected: usize,
    /// Number of points that a robust filter would reject, in places where it would reject most points.
    pub guarded: usize,
    /// False if a robust filter still changed after its last pass.
    pub is_settled: bool,
}

impl Smoothed {
    fn of(heights: Array2<f64>) -> Self {
        Self { heights, passes: 1, rejected: 0, guarded: 0, is_settled: true }
    }
}

/// Returns the heights after an S filter with nesting index `index`, in units of the `spacing` along x and y. The rest,
/// `heights - smoothed`, are the heights after an L filter.
///
/// # Errors
/// An index below 2 spacings or above the shorter side; a degree above 2; edges or a degree that the kernel does not
/// have; undefined points with edges other than regression; a spline of a surface.
pub fn smooth(heights: &Array2<f64>, spacing: [f64; 2], index: f64, filter: Filter) -> Result<Smoothed, PrepareError> {
    let Filter { kernel, edges, degree } = filter;
    let (nx, ny) = heights.dim();
    let sides = if ny == 1 { 1 } else { 2 };
    let least = 2.0 * spacing[..sides].iter().copied().fold(0.0, f64::max);
    let side = [nx, ny].into_iter().zip(spacing).take(sides).map(|(n, step)| n as f64 * step);
    let most = side.fold(f64::INFINITY, f64::min);
    if !(least..=most).contains(&index) {
        return Err(value("nesting index", index, format!("between {least}, two spacings, and {most}, the side")));
    }
    if degree > 2 {
        return Err(value("degree of the filter", degree, "0, 1 or 2"));
    }
    let combination = |found, allowed| Err(PrepareError::Combination { found, allowed });
    let is_complete = !heights.iter().any(|height| height.is_nan());
    if edges != Edges::Regression && !is_complete {
        return combination("the filter has undefined points", "regression edges, or all points defined");
    }
    match (kernel, edges) {
        (Kernel::Gaussian, Edges::Periodic | Edges::Reflect) if degree == 2 => {
            combination("the filter has degree 2 without regression", "degree 0 or 1, or regression edges")
        }
        (Kernel::Gaussian, Edges::Periodic) => Ok(Smoothed::of(spectral::periodic(heights, spacing, index))),
        (Kernel::Gaussian, Edges::Reflect) => Ok(Smoothed::of(spectral::reflected(heights, spacing, index))),
        (Kernel::Gaussian, Edges::Regression) => {
            Ok(Smoothed::of(regression::regressed(heights, None, spacing, index, degree)))
        }
        (Kernel::Robust, Edges::Regression) => Ok(robust::smooth(heights, spacing, index, degree)),
        (Kernel::Robust, _) => combination("the robust filter has edges", "regression, which can leave points out"),
        (Kernel::Spline { .. }, _) if ny > 1 => combination("the spline is that of a surface", "a profile"),
        (Kernel::Spline { .. }, Edges::Reflect) => {
            combination("the spline has reflected edges", "regression or periodic")
        }
        (Kernel::Spline { tension }, _) if !(0.0..=1.0).contains(&tension) => {
            Err(value("tension of the spline", tension, "between 0 and 1"))
        }
        (Kernel::Spline { tension }, Edges::Periodic) => {
            Ok(Smoothed::of(spectral::closed_spline(heights, spacing[0], index, tension)))
        }
        (Kernel::Spline { tension }, Edges::Regression) => {
            Ok(Smoothed::of(spline::open(heights, spacing[0], index, tension)))
        }
    }
}

/// Returns the wavelengths of the sharp cut-off that leaves the same rms gradient, and the same rms curvature, of an
/// unlimited self-affine surface of this Hurst exponent as a Gaussian S filter, divided by its nesting index.
///
/// From ∫ q^{1−2H} e^{−2 ln2 (L q/2π)²} dq: √(2 ln 2) Γ(2−H)^{−1/(2−2H)} and √(2 ln 2) Γ(3−H)^{−1/(4−2H)}.
pub fn equivalent_cut_off(hurst: f64) -> [f64; 2] {
    let scale = (2.0 * std::f64::consts::LN_2).sqrt();
    let order = |n: f64| scale * libm::tgamma(n - hurst).powf(-1.0 / (2.0 * (n - 1.0) - 2.0 * hurst));
    [order(2.0), order(3.0)]
}

/// Returns the robust filter after a number of passes, with or without its guard.
#[cfg(test)]
pub(crate) fn robust_passes(
    heights: &Array2<f64>,
    (spacing, index, degree): ([f64; 2], f64, usize),
    most: usize,
    is_guarded: bool,
) -> Smoothed {
    robust::passes(heights, spacing, index, degree, &robust::Rule { most, settled: -1.0, is_guarded })
}
