//! Statistics of a rough surface.

use std::borrow::Cow;

use gfmd_surface::{
    Areal, Core, CorrelationLengths, Direction, Features, HurstFit, Moments, ProfileNumbers, Statistics, SurfaceError,
    Volumes,
};

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
    /// True for a profile.
    pub line: bool,
    /// True if correlation lengths, direction, hills and dales are computed.
    pub detailed: bool,
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
    /// Parameters of a profile; `None` without a section length.
    pub profile: Option<&'a ProfileNumbers>,
    /// Detailed numbers; `None` without [`SurfaceFacts::detailed`].
    pub detail: Option<&'a SurfaceDetail>,
}

/// Numbers of a surface that take longer to compute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDetail {
    /// Correlation lengths.
    pub lengths: CorrelationLengths,
    /// Direction of the texture.
    pub direction: Direction,
    /// Hills and dales; `None` for a profile and a flat surface.
    pub features: Option<Features>,
}

impl Subject for Surface {
    type Facts = SurfaceFacts;
    type Context<'a> = SurfaceContext<'a>;
    const COLUMNS: &'static [Column] = COLUMNS;
    const KEY: &'static str = "rms_height";
}

type Column = crate::Column<Surface>;

const FLAT: &str = "the surface is flat";
const SHORT: &str = "the autocorrelation does not fall to 0.2 within half of the cell";
const SHORT_SOMEWHERE: &str = "in a direction the autocorrelation does not fall to 0.2 within half of the cell";
const NO_LAY: &str = "the surface has no direction: Str is, or may be, above 0.5";
const EQUAL: &str = "the mean square slopes of all directions are equal";
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

fn detailed(facts: &SurfaceFacts) -> bool {
    facts.detailed
}

fn directed(facts: &SurfaceFacts) -> bool {
    facts.detailed && !facts.line
}

fn line(facts: &SurfaceFacts) -> bool {
    facts.line
}

/// Returns a parameter of the bearing curve.
fn of_core(at: &SurfaceContext, of: fn(&Core) -> f64) -> Cell {
    cell(at.areal.core.as_ref().map(of), FLAT)
}

/// Returns a volume or height difference of the bearing curve.
fn of_volumes(at: &SurfaceContext, of: fn(&Volumes) -> f64) -> Cell {
    cell(at.areal.volumes.as_ref().map(of), FLAT)
}

/// Returns a correlation length or aspect ratio.
fn of_lengths(at: &SurfaceContext, of: fn(&CorrelationLengths) -> Option<f64>, reason: &'static str) -> Cell {
    let flat = at.cut_offs.is_none();
    cell(at.detail.and_then(|detail| of(&detail.lengths)), if flat { FLAT } else { reason })
}

/// Returns a number of the direction of the texture.
fn of_direction(at: &SurfaceContext, of: fn(&Direction) -> Option<f64>, reason: &'static str) -> Cell {
    let flat = at.cut_offs.is_none();
    cell(at.detail.and_then(|detail| of(&detail.direction)), if flat { FLAT } else { reason })
}

/// Returns a number of hills and dales.
fn of_features(at: &SurfaceContext, of: fn(&Features) -> Option<f64>) -> Cell {
    match at.detail.and_then(|detail| detail.features.as_ref()) {
        Some(features) => cell(of(features), "no hill or dale remains that the number needs"),
        None => Cell::undefined(FLAT),
    }
}

/// Returns a parameter of a profile.
fn of_profile(at: &SurfaceContext, of: fn(&ProfileNumbers) -> Option<f64>) -> Cell {
    match at.profile {
        Some(profile) => cell(of(profile), "the profile is flat or has fewer than two equal crossings"),
        None => Cell::undefined("the profile has no L filter, whose index is the section length"),
    }
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
    Column::new("peak_to_valley", "length", &[(any, "highest minus lowest height: Sz of ISO 25178")], |at| {
        at.statistics.peak_to_valley().into()
    }),
    Column::new("sa", "length", &[(any, "Sa of ISO 25178: mean distance from the mean height")], |at| {
        at.areal.sa.into()
    }),
    Column::new("sp", "length", &[(any, "Sp of ISO 25178: highest height above the mean")], |at| at.areal.sp.into()),
    Column::new("sv", "length", &[(any, "Sv of ISO 25178: depth of the lowest height below the mean")], |at| {
        at.areal.sv.into()
    }),
    Column::new("ssk", "1", &[(any, "Ssk of ISO 25178: skewness")], |at| cell(at.areal.ssk, FLAT)),
    Column::new("sku", "1", &[(any, "Sku of ISO 25178: kurtosis, 3 of a Gaussian surface")], |at| {
        cell(at.areal.sku, FLAT)
    }),
    Column::new("sdr", "1", &[(any, "Sdr of ISO 25178: developed area divided by projected area, minus 1")], |at| {
        at.areal.sdr.into()
    }),
    Column::new("sk", "length", &[(any, "Sk of ISO 25178: core height of the bearing curve")], |at| {
        of_core(at, |core| core.sk)
    }),
    Column::new("spk", "length", &[(any, "Spk of ISO 25178: reduced peak height above the core")], |at| {
        of_core(at, |core| core.spk)
    }),
    Column::new("svk", "length", &[(any, "Svk of ISO 25178: reduced valley depth below the core")], |at| {
        of_core(at, |core| core.svk)
    }),
    Column::new("smr1", "1", &[(any, "Smr1 of ISO 25178: material ratio between peaks and core")], |at| {
        of_core(at, |core| core.smr1)
    }),
    Column::new("smr2", "1", &[(any, "Smr2 of ISO 25178: material ratio between core and valleys")], |at| {
        of_core(at, |core| core.smr2)
    }),
    Column::new("spkx", "length", &[(any, "Spkx of ISO 25178: highest peak above the core")], |at| {
        of_core(at, |core| core.spkx)
    }),
    Column::new("svkx", "length", &[(any, "Svkx of ISO 25178: deepest valley below the core")], |at| {
        of_core(at, |core| core.svkx)
    }),
    Column::new(
        "vmp",
        "length",
        &[(any, "Vmp of ISO 25178: peak material volume per area, above the material ratio 10 %")],
        |at| of_volumes(at, |volumes| volumes.vmp),
    ),
    Column::new(
        "vmc",
        "length",
        &[(any, "Vmc of ISO 25178: core material volume per area, between 10 and 80 %")],
        |at| of_volumes(at, |volumes| volumes.vmc),
    ),
    Column::new("vvc", "length", &[(any, "Vvc of ISO 25178: core void volume per area, between 10 and 80 %")], |at| {
        of_volumes(at, |volumes| volumes.vvc)
    }),
    Column::new("vvv", "length", &[(any, "Vvv of ISO 25178: valley void volume per area, below 80 %")], |at| {
        of_volumes(at, |volumes| volumes.vvv)
    }),
    Column::new(
        "sxp",
        "length",
        &[(any, "Sxp of ISO 25178: height at the material ratio 2.5 % minus the height at 50 %")],
        |at| of_volumes(at, |volumes| volumes.sxp),
    ),
    Column::new(
        "sdc",
        "length",
        &[(any, "Sdc of ISO 25178: height at the material ratio 10 % minus the height at 80 %")],
        |at| of_volumes(at, |volumes| volumes.sdc),
    ),
    Column::new(
        "rms_gradient",
        "1",
        &[
            (free, "rms of the full gradient, from differences inside, like curvature and moments"),
            (any, "rms of the full gradient, from the spectrum"),
        ],
        |at| at.moments.rms_gradient().into(),
    ),
    Column::new("rms_gradient_central", "1", &[(any, "rms gradient from central differences")], |at| {
        at.statistics.rms_gradient_central.into()
    }),
    Column::new("rms_gradient_forward", "1", &[(any, "rms gradient from forward differences")], |at| {
        at.statistics.rms_gradient_forward.into()
    }),
    Column::new(
        "rms_gradient_inside",
        "1",
        &[(any, "rms gradient from forward differences, excluding the periodic seam")],
        |at| at.statistics.rms_gradient_inside.into(),
    ),
    Column::new("rms_curvature", "1/length", &[(any, "rms of the mean curvature (h'' of a profile)")], |at| {
        of_curvature(at, |moments| Some(moments.rms_curvature()))
    }),
    Column::new(
        "rms_curvature_inside",
        "1/length",
        &[(any, "rms of the mean curvature from second differences, excluding the periodic seam")],
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
        &[(any, "fourth profile moment from second differences, excluding the periodic seam")],
        |at| inside(at, |moments| Some(moments.profile()[2])),
    ),
    Column::new("nayak", "1", &[(any, "Nayak's parameter m0 m4/m2^2")], |at| of_curvature(at, Moments::nayak)),
    Column::new(
        "nayak_inside",
        "1",
        &[(any, "Nayak's parameter from differences, excluding the periodic seam")],
        |at| inside(at, Moments::nayak),
    ),
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
    Column::new(
        "seam_x",
        "1",
        &[(any, "rms step along x across the periodic seam divided by the rms step inside")],
        |at| seam(at, 0),
    )
    .at("seam.0"),
    Column::new(
        "seam_y",
        "1",
        &[(any, "rms step along y across the periodic seam divided by the rms step inside")],
        |at| seam(at, 1),
    )
    .at("seam.1"),
    Column::new(
        "sal",
        "length",
        &[(any, "Sal of ISO 25178: shortest distance at which the autocorrelation is 0.2")],
        |at| of_lengths(at, |lengths| lengths.sal, SHORT),
    )
    .with(detailed),
    Column::new(
        "str",
        "1",
        &[(any, "Str of ISO 25178: shortest divided by longest distance at which the autocorrelation is 0.2")],
        |at| of_lengths(at, CorrelationLengths::aspect, SHORT_SOMEWHERE),
    )
    .with(directed),
    Column::new(
        "ssw",
        "length",
        &[(any, "Ssw of ISO 25178: wavelength of the wave with the largest amplitude")],
        |at| of_direction(at, |direction| direction.ssw, FLAT),
    )
    .with(detailed),
    Column::new(
        "std",
        "degree",
        &[(any, "Std of ISO 25178: direction of the waves with the most power, from the x axis")],
        |at| of_direction(at, |direction| direction.wave, NO_LAY),
    )
    .with(directed),
    Column::new("lay", "degree", &[(any, "direction of the lay from the x axis, normal to Std")], |at| {
        of_direction(at, Direction::lay, NO_LAY)
    })
    .with(directed),
    Column::new("steepest", "degree", &[(any, "direction of the largest mean square slope, from the x axis")], |at| {
        of_direction(at, |direction| direction.steepest, EQUAL)
    })
    .with(directed),
    Column::new("hills", "1", &[(any, "number of hills after Wolf pruning")], |at| {
        of_features(at, |features| Some(features.hills.count as f64))
    })
    .with(directed)
    .count(),
    Column::new("dales", "1", &[(any, "number of dales after Wolf pruning")], |at| {
        of_features(at, |features| Some(features.dales.count as f64))
    })
    .with(directed)
    .count(),
    Column::new("spd", "1/length^2", &[(any, "Spd of ISO 25178: peaks per area")], |at| {
        of_features(at, |features| Some(features.hills.density))
    })
    .with(directed),
    Column::new("svd", "1/length^2", &[(any, "Svd of ISO 25178: pits per area")], |at| {
        of_features(at, |features| Some(features.dales.density))
    })
    .with(directed),
    Column::new("spc", "1/length", &[(any, "Spc of ISO 25178: mean curvature of the peaks")], |at| {
        of_features(at, |features| features.hills.curvature)
    })
    .with(directed),
    Column::new("svc", "1/length", &[(any, "Svc of ISO 25178: mean curvature of the pits")], |at| {
        of_features(at, |features| features.dales.curvature)
    })
    .with(directed),
    Column::new(
        "s5p",
        "length",
        &[(any, "S5p of ISO 25178: mean height of the five highest peaks above the mean")],
        |at| of_features(at, |features| features.hills.five),
    )
    .with(directed),
    Column::new(
        "s5v",
        "length",
        &[(any, "S5v of ISO 25178: mean depth of the five deepest pits below the mean")],
        |at| of_features(at, |features| features.dales.five),
    )
    .with(directed),
    Column::new("s10z", "length", &[(any, "S10z of ISO 25178: S5p plus S5v")], |at| of_features(at, Features::s10z))
        .with(directed),
    Column::new("mean_hill_area", "length^2", &[(any, "mean hill area")], |at| {
        of_features(at, |features| features.hills.area)
    })
    .with(directed),
    Column::new("mean_dale_area", "length^2", &[(any, "mean dale area")], |at| {
        of_features(at, |features| features.dales.area)
    })
    .with(directed),
    Column::new("sections", "1", &[(any, "number of whole sections of the profile")], |at| {
        of_profile(at, |profile| Some(profile.sections as f64))
    })
    .with(line)
    .count(),
    Column::new("ra", "length", &[(any, "Ra of ISO 21920: mean distance from the mean line")], |at| {
        of_profile(at, |profile| Some(profile.ra))
    })
    .with(line),
    Column::new("rq", "length", &[(any, "Rq of ISO 21920: root-mean-square distance from the mean line")], |at| {
        of_profile(at, |profile| Some(profile.rq))
    })
    .with(line),
    Column::new("rsk", "1", &[(any, "Rsk of ISO 21920: skewness")], |at| of_profile(at, |profile| profile.rsk))
        .with(line),
    Column::new("rku", "1", &[(any, "Rku of ISO 21920: kurtosis")], |at| of_profile(at, |profile| profile.rku))
        .with(line),
    Column::new("rt", "length", &[(any, "Rt of ISO 21920: highest minus lowest height")], |at| {
        of_profile(at, |profile| Some(profile.rt))
    })
    .with(line),
    Column::new(
        "rp",
        "length",
        &[(any, "Rp of ISO 21920: highest height of a section, mean over the sections")],
        |at| of_profile(at, |profile| Some(profile.rp)),
    )
    .with(line),
    Column::new(
        "rv",
        "length",
        &[(any, "Rv of ISO 21920: depth of the lowest height of a section, mean over the sections")],
        |at| of_profile(at, |profile| Some(profile.rv)),
    )
    .with(line),
    Column::new(
        "rz",
        "length",
        &[(any, "Rz of ISO 21920: highest minus lowest height of a section, mean over the sections")],
        |at| of_profile(at, |profile| Some(profile.rz)),
    )
    .with(line),
    Column::new(
        "rzx",
        "length",
        &[(any, "Rzx of ISO 21920: largest difference between highest and lowest height of a section")],
        |at| of_profile(at, |profile| Some(profile.rzx)),
    )
    .with(line),
    Column::new("rdq", "1", &[(any, "Rdq of ISO 21920: root-mean-square slope from forward differences")], |at| {
        of_profile(at, |profile| Some(profile.rdq))
    })
    .with(line),
    Column::new("rsm", "length", &[(any, "Rsm of ISO 21920: mean width of the profile elements")], |at| {
        of_profile(at, |profile| profile.rsm)
    })
    .with(line),
    Column::new("rk", "length", &[(any, "Rk of ISO 21920: core height of the bearing curve")], |at| {
        of_profile(at, |profile| profile.core.map(|core| core.sk))
    })
    .with(line),
    Column::new("rpk", "length", &[(any, "Rpk of ISO 21920: reduced peak height above the core")], |at| {
        of_profile(at, |profile| profile.core.map(|core| core.spk))
    })
    .with(line),
    Column::new("rvk", "length", &[(any, "Rvk of ISO 21920: reduced valley depth below the core")], |at| {
        of_profile(at, |profile| profile.core.map(|core| core.svk))
    })
    .with(line),
    Column::new("rmr1", "1", &[(any, "Rmr1 of ISO 21920: material ratio between peaks and core")], |at| {
        of_profile(at, |profile| profile.core.map(|core| core.smr1))
    })
    .with(line),
    Column::new("rmr2", "1", &[(any, "Rmr2 of ISO 21920: material ratio between core and valleys")], |at| {
        of_profile(at, |profile| profile.core.map(|core| core.smr2))
    })
    .with(line),
];
