//! Statistics of a rough surface.

use std::borrow::Cow;

use gfmd_surface::{Areal, HurstFit, Moments, Statistics, SurfaceError};

use crate::Cell;
use crate::column::Subject;

/// Rough surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Surface;

/// Features of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceFacts {
    /// True if the surface ends at its edges: moments then come from differences inside.
    pub free: bool,
}

/// Input from which the statistics of a surface are printed.
#[derive(Clone, Debug)]
pub struct SurfaceContext<'a> {
    /// Height, gradient and curvature.
    pub statistics: &'a Statistics,
    /// Moments: spectral ones, or by differences inside.
    pub moments: Moments,
    /// Height parameters of ISO 25178.
    pub areal: &'a Areal,
    /// Fit of the Hurst exponent, or the reason why there is none.
    pub fit: &'a Result<HurstFit, SurfaceError>,
    /// Range of wavelengths of the fit, longest first, length.
    pub fit_range: [f64; 2],
    /// Longest and shortest wavelengths with power, length; `None` if the surface is flat.
    pub cut_offs: Option<[f64; 2]>,
}

impl Subject for Surface {
    type Facts = SurfaceFacts;
    type Context<'a> = SurfaceContext<'a>;
    const COLUMNS: &'static [Column] = COLUMNS;
    const KEY: &'static str = "rms_height";
}

type Column = crate::Column<Surface>;

const FLAT: &str = "the surface is flat";
const FEW: &str = "an axis has fewer than three points";

fn any(_: &SurfaceFacts) -> bool {
    true
}

fn free(facts: &SurfaceFacts) -> bool {
    facts.free
}

fn cell(value: Option<f64>, reason: impl Into<Cow<'static, str>>) -> Cell {
    value.ok_or(reason).into()
}

/// A number with the fourth moment, which differences inside need three points along each axis for.
fn of_curvature(at: &SurfaceContext, of: impl Fn(&Moments) -> Option<f64>) -> Cell {
    let reason = if at.moments.rms_curvature().is_nan() { FEW } else { FLAT };
    cell(of(&at.moments).filter(|value| !value.is_nan()), reason)
}

/// Returns a number with the fourth moment of differences inside.
fn inside(at: &SurfaceContext, of: impl Fn(&Moments) -> Option<f64>) -> Cell {
    let reason = if at.statistics.mean_square_laplacian_inside.is_none() { FEW } else { FLAT };
    cell(of(&at.statistics.moments_inside()).filter(|value| !value.is_nan()), reason)
}

fn of_fit(at: &SurfaceContext, of: fn(&HurstFit) -> f64) -> Cell {
    match at.fit {
        Ok(fit) => of(fit).into(),
        Err(error) => Cell::undefined(error.to_string()),
    }
}

fn seam(at: &SurfaceContext, axis: usize) -> Cell {
    cell(at.statistics.seam.ratio()[axis], "neighbouring points along this axis have equal heights")
}

/// Statistics, in the order in which they are printed.
const COLUMNS: &[Column] = &[
    Column::new("mean", "length", &[(any, "mean height")], |at| at.statistics.mean.into()),
    Column::new("rms_height", "length", &[(any, "root-mean-square height about the mean: Sq of ISO 25178")], |at| {
        at.statistics.moments.rms_height().into()
    }),
    Column::new("lowest", "length", &[(any, "lowest height")], |at| at.statistics.lowest.into()),
    Column::new("highest", "length", &[(any, "highest height")], |at| at.statistics.highest.into()),
    Column::new("peak_to_valley", "length", &[(any, "highest less lowest height: Sz of ISO 25178")], |at| {
        at.statistics.peak_to_valley().into()
    }),
    Column::new("sa", "length", &[(any, "Sa of ISO 25178: mean distance from the mean height")], |at| {
        at.areal.sa.into()
    }),
    Column::new("sp", "length", &[(any, "Sp of ISO 25178: highest height above the mean")], |at| at.areal.sp.into()),
    Column::new("sv", "length", &[(any, "Sv of ISO 25178: depth of the lowest one below the mean")], |at| {
        at.areal.sv.into()
    }),
    Column::new("ssk", "1", &[(any, "Ssk of ISO 25178: skewness")], |at| cell(at.areal.ssk, FLAT)),
    Column::new("sku", "1", &[(any, "Sku of ISO 25178: kurtosis, 3 of a Gaussian surface")], |at| {
        cell(at.areal.sku, FLAT)
    }),
    Column::new("sdr", "1", &[(any, "Sdr of ISO 25178: developed area over that of the plane, less 1")], |at| {
        at.areal.sdr.into()
    }),
    Column::new(
        "rms_gradient",
        "1",
        &[
            (free, "rms of the full gradient, by differences inside, as curvature and moments"),
            (any, "rms of the full gradient, spectral"),
        ],
        |at| at.moments.rms_gradient().into(),
    ),
    Column::new("rms_gradient_central", "1", &[(any, "rms gradient by central differences")], |at| {
        at.statistics.rms_gradient_central.into()
    }),
    Column::new("rms_gradient_forward", "1", &[(any, "rms gradient by forward differences")], |at| {
        at.statistics.rms_gradient_forward.into()
    }),
    Column::new(
        "rms_gradient_inside",
        "1",
        &[(any, "rms gradient by forward differences, without the periodic seam")],
        |at| at.statistics.rms_gradient_inside.into(),
    ),
    Column::new("rms_curvature", "1/length", &[(any, "rms of the mean curvature (h'' of a profile)")], |at| {
        of_curvature(at, |moments| Some(moments.rms_curvature()))
    }),
    Column::new(
        "rms_curvature_inside",
        "1/length",
        &[(any, "rms of the mean curvature by second differences, without the periodic seam")],
        |at| inside(at, |moments| Some(moments.rms_curvature())),
    ),
    Column::new("rms_laplacian", "1/length", &[(any, "rms of the Laplacian")], |at| {
        of_curvature(at, |moments| Some(moments.rms_laplacian()))
    }),
    Column::new("m0", "length^2", &[(any, "zeroth profile moment")], |at| at.moments.profile()[0].into()),
    Column::new("m2", "1", &[(any, "second profile moment")], |at| at.moments.profile()[1].into()),
    Column::new("m4", "1/length^2", &[(any, "fourth profile moment")], |at| {
        of_curvature(at, |moments| Some(moments.profile()[2]))
    }),
    Column::new(
        "m4_inside",
        "1/length^2",
        &[(any, "fourth profile moment by second differences, without the periodic seam")],
        |at| inside(at, |moments| Some(moments.profile()[2])),
    ),
    Column::new("nayak", "1", &[(any, "Nayak's parameter m0 m4/m2^2")], |at| of_curvature(at, Moments::nayak)),
    Column::new("nayak_inside", "1", &[(any, "Nayak's parameter by differences, without the periodic seam")], |at| {
        inside(at, Moments::nayak)
    }),
    Column::new("hurst", "1", &[(any, "fitted Hurst exponent")], |at| of_fit(at, |fit| fit.hurst)),
    Column::new("hurst_error", "1", &[(any, "standard error of the fitted Hurst exponent")], |at| {
        of_fit(at, |fit| fit.standard_error)
    }),
    Column::new("hurst_range_longest", "length", &[(any, "longest wavelength of the fit")], |at| {
        at.fit_range[0].into()
    })
    .at("hurst_range.0"),
    Column::new("hurst_range_shortest", "length", &[(any, "shortest wavelength of the fit")], |at| {
        at.fit_range[1].into()
    })
    .at("hurst_range.1"),
    Column::new("longest_wavelength", "length", &[(any, "longest wavelength with power")], |at| {
        cell(at.cut_offs.map(|[longest, _]| longest), FLAT)
    }),
    Column::new("shortest_wavelength", "length", &[(any, "shortest wavelength with power")], |at| {
        cell(at.cut_offs.map(|[_, shortest]| shortest), FLAT)
    }),
    Column::new("seam_x", "1", &[(any, "rms step along x across the periodic seam over those inside")], |at| {
        seam(at, 0)
    })
    .at("seam.0"),
    Column::new("seam_y", "1", &[(any, "rms step along y across the periodic seam over those inside")], |at| {
        seam(at, 1)
    })
    .at("seam.1"),
];
