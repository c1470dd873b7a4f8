//! The configuration of a sweep, and presets by name.

use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::str::FromStr;

use gfmd_contact::{Budget, Contact, Solver};
use gfmd_fit::{Exponent, Model};
use gfmd_green::{Body, GreenError, Height, Material};
use gfmd_surface::Discretisation;
use serde::{Deserialize, Serialize};

use crate::SweepError;
use crate::words::{height, solver};

/// The configuration of a sweep. The default of every field is its value in the preset `default`.
///
/// ```
/// use gfmd_sweep::{Alpha, Config};
///
/// let text = "
/// surface.hurst = [0.5, 0.8]
/// fit.alpha_t = \"free\"
/// ";
/// let config: Config = toml::from_str(text)?;
/// assert_eq!(config.surface.hurst, [0.5, 0.8]);
/// assert_eq!(config.fit.alpha_t, Alpha::Free);
/// assert_eq!(config.statistics.realisations, 8);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// The rough surfaces.
    pub surface: SurfaceConfig,
    /// The elastic body.
    pub body: BodyConfig,
    /// The discretisations.
    pub points: PointsConfig,
    /// The loads, ascending.
    pub loads: LoadsConfig,
    /// The realisations.
    pub statistics: StatisticsConfig,
    /// The contact solver.
    pub solver: SolverConfig,
    /// The extrapolation.
    pub fit: FitConfig,
}

/// The rough surfaces: self-affine, Gaussian, without roll-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SurfaceConfig {
    /// 3 for surfaces of three-dimensional bodies, 2 for profiles in plane strain.
    pub dim: u8,
    /// Hurst exponents, each with its own fit.
    pub hurst: Vec<f64>,
    /// Spectral rms gradient of every realisation.
    pub rms_gradient: f64,
}

/// The elastic body under a cell of length 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyConfig {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Height of the slab over the cell length, or `"inf"`.
    #[serde(with = "height")]
    pub height: Height,
}

/// The discretisations: inverses of eps_t, eps_f, eps_c.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointsConfig {
    /// The way in which the lists are combined.
    pub design: Design,
    /// Longest wavelengths per cell.
    pub eps_t_inv: Vec<f64>,
    /// Longest over shortest wavelength.
    pub eps_f_inv: Vec<f64>,
    /// Grid points per shortest wavelength.
    pub eps_c_inv: Vec<f64>,
    /// The middle of a star: eps_t_inv, eps_f_inv, eps_c_inv.
    pub centre: [f64; 3],
    /// The largest number of grid points along one axis; larger grids are left out. 0 means no limit.
    pub largest_n: usize,
}

/// The ways to combine the lists of the three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// All combinations.
    Grid,
    /// One axis at a time, the other two at the centre.
    Star,
}

/// The loads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadsConfig {
    /// Reduced pressures p/(E* g), ascending: each starts from the one before.
    pub p_star: Vec<f64>,
}

/// The realisations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StatisticsConfig {
    /// Number of surfaces at points with the eps_t_inv of the centre (for the design `grid`: the first eps_t_inv); if
    /// `nested`, at the largest grid.
    pub realisations: u64,
    /// If true, smaller grids get more surfaces, in inverse proportion to their number of points and at most 64 times
    /// `realisations`, so that about equal time goes into each point: points of one eps_t have their surfaces in common, and
    /// the many surfaces of coarse points improve the finer points ([`gfmd_fit`]).
    pub nested: bool,
    /// Without `nested`: if true, points of larger cells get fewer surfaces and points of smaller cells more, so that each
    /// point samples about equal area and has about equal statistical error; between 4 and 4 times `realisations`.
    pub equal_area: bool,
    /// First seed. Points of one eps_t have their seeds, and thus their random modes, in common; points of another eps_t have
    /// independent surfaces.
    pub seed: u64,
}

/// The contact solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverConfig {
    /// The method.
    #[serde(with = "solver")]
    pub method: Solver,
    /// Largest residual of a converged state.
    pub tol: f64,
    /// Largest number of iterations for one load.
    pub max_iter: u64,
}

/// The extrapolation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitConfig {
    /// The load of the main result; all loads are fitted.
    pub p_star: f64,
    /// Exponent of the term in eps_t. The bias of a finite cell falls with its area, as its variance does: 2 for surfaces, 1
    /// for profiles.
    pub alpha_t: Alpha,
    /// Exponent of the term in eps_f: `"self-affine"` for 1 - H (theory.md, section 11), a number, `"free"` or `"none"`.
    pub alpha_f: Alpha,
    /// Exponent of the term in eps_c: `"edge"` for a multiple of the measured perimeter in place of a power of eps_c, a
    /// number, `"free"` or `"none"`. It concerns the raw area; what is left of the error in the corrected area is fitted with
    /// the exponent 1.
    pub alpha_c: Alpha,
    /// Number of bootstrap resamples.
    pub resamples: usize,
}

/// The exponent of one term: a number or a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// An exponent held at this value.
    Fixed(f64),
    /// A fitted exponent.
    Free,
    /// No term along this axis.
    Without,
    /// 1 - H, for eps_f: the ratio of the gradient of the longest waves to that of all waves is eps_f^(1 - H).
    SelfAffine,
    /// A multiple of the measured edge of each contact in place of a power, for eps_c.
    Edge,
}

impl Default for SurfaceConfig {
    fn default() -> Self {
        Self { dim: 3, hurst: vec![0.8], rms_gradient: 0.1 }
    }
}

impl Default for BodyConfig {
    fn default() -> Self {
        Self { young: 1.0, poisson: 0.0, height: Height::Infinite }
    }
}

impl Default for PointsConfig {
    fn default() -> Self {
        Self {
            design: Design::Star,
            eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
            eps_f_inv: vec![8.0, 16.0, 32.0, 64.0, 128.0],
            eps_c_inv: vec![4.0, 8.0, 16.0],
            centre: [4.0, 16.0, 4.0],
            largest_n: 0,
        }
    }
}

impl Default for LoadsConfig {
    fn default() -> Self {
        Self { p_star: vec![0.01, 0.02, 0.05] }
    }
}

impl Default for StatisticsConfig {
    fn default() -> Self {
        Self { realisations: 8, nested: true, equal_area: true, seed: 1 }
    }
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self { method: Solver::Auto, tol: 1e-8, max_iter: 10_000 }
    }
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            p_star: 0.02,
            alpha_t: Alpha::Fixed(2.0),
            alpha_f: Alpha::SelfAffine,
            alpha_c: Alpha::Edge,
            resamples: 2000,
        }
    }
}

/// The sweeps that have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// A test of a few seconds.
    Smoke,
    /// The default of every field; takes minutes.
    Default,
    /// The study of the thesis; takes hours.
    Thesis,
    /// A study after Prodanov, Dapp and Müser; takes hours.
    Prodanov,
    /// Profiles in plane strain.
    Line,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 5] = [Self::Smoke, Self::Default, Self::Thesis, Self::Prodanov, Self::Line];

    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Default => "default",
            Self::Thesis => "thesis",
            Self::Prodanov => "prodanov",
            Self::Line => "line",
        }
    }

    /// The purpose of the sweep in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Smoke => "Seconds: a test that everything works; its kappa is no result",
            Self::Default => "A few minutes on two cores: H = 0.8, a reliable kappa",
            Self::Thesis => "The study of the thesis: H = 0, slab as high as the cell, up to 8192 x 8192 points",
            Self::Prodanov => "After Prodanov, Dapp and Mueser (2014): H = 0, 0.3, 0.8, eps_c_inv up to 8",
            Self::Line => "Profiles in plane strain",
        }
    }

    /// The configuration.
    pub fn config(self) -> Config {
        let base = Config::default();
        match self {
            Self::Default => base,
            Self::Smoke => Config {
                points: PointsConfig {
                    eps_t_inv: vec![1.0, 2.0],
                    eps_f_inv: vec![4.0, 8.0, 16.0, 32.0],
                    eps_c_inv: vec![4.0, 8.0, 16.0],
                    centre: [2.0, 8.0, 4.0],
                    ..base.points
                },
                statistics: StatisticsConfig { realisations: 4, ..base.statistics },
                fit: FitConfig { resamples: 500, ..base.fit },
                ..base
            },
            Self::Thesis => Config {
                surface: SurfaceConfig { hurst: vec![0.0], rms_gradient: 0.01, ..base.surface },
                body: BodyConfig { poisson: 0.33, height: Height::Finite(1.0), ..base.body },
                points: PointsConfig {
                    design: Design::Grid,
                    eps_t_inv: vec![2.0],
                    eps_f_inv: vec![128.0, 256.0, 512.0],
                    eps_c_inv: vec![2.0, 4.0, 8.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.001, 0.00325, 0.0055, 0.00775, 0.01] },
                statistics: StatisticsConfig { realisations: 4, nested: false, ..base.statistics },
                fit: FitConfig { p_star: 0.01, ..base.fit },
                ..base
            },
            Self::Prodanov => Config {
                surface: SurfaceConfig { hurst: vec![0.0, 0.3, 0.8], ..base.surface },
                points: PointsConfig {
                    eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
                    eps_f_inv: vec![16.0, 32.0, 64.0, 128.0, 256.0, 512.0],
                    eps_c_inv: vec![2.0, 4.0, 8.0],
                    centre: [2.0, 64.0, 8.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.01, 0.02, 0.05] },
                statistics: StatisticsConfig { nested: false, ..base.statistics },
                ..base
            },
            Self::Line => Config {
                surface: SurfaceConfig { dim: 2, ..base.surface },
                points: PointsConfig {
                    eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
                    eps_f_inv: vec![64.0, 256.0, 1024.0, 4096.0],
                    eps_c_inv: vec![4.0, 8.0, 16.0, 32.0],
                    centre: [4.0, 1024.0, 16.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.02, 0.05, 0.1] },
                statistics: StatisticsConfig { realisations: 32, nested: false, ..base.statistics },
                fit: FitConfig { p_star: 0.02, alpha_t: Alpha::Fixed(1.0), alpha_c: Alpha::Fixed(1.0), ..base.fit },
                ..base
            },
        }
    }
}

impl FromStr for Preset {
    type Err = SweepError;

    fn from_str(found: &str) -> Result<Self, SweepError> {
        let names = || Self::ALL.map(Self::name).join(", ");
        let preset = Self::ALL.into_iter().find(|preset| preset.name() == found);
        preset.ok_or_else(|| refusal("preset", &found, format!("one of {}", names())))
    }
}

/// The moduli whose squares are numbers.
const SIZES: RangeInclusive<f64> = 1e-140..=1e140;

/// The heights of a slab, over the length of the cell, whose stiffnesses are computed without loss of digits.
const HEIGHTS: RangeInclusive<f64> = 1e-12..=1e12;

/// The gradients whose squares, times those of a modulus, are numbers.
const GRADIENTS: RangeInclusive<f64> = 1e-100..=1e100;

/// The error of a field whose value is `found`.
pub(crate) fn refusal(field: &'static str, found: &impl Debug, allowed: impl Into<String>) -> SweepError {
    SweepError::Field { field, found: format!("{found:?}"), allowed: allowed.into() }
}

impl Config {
    /// Checks that every value can be used.
    ///
    /// # Errors
    /// The first field that cannot, its value, and the values allowed.
    pub fn check(&self) -> Result<(), SweepError> {
        let check = |good: bool, field, found: &dyn Debug, allowed: &str| match good {
            true => Ok(()),
            false => Err(refusal(field, &found, allowed)),
        };
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let Self { surface, loads, statistics, solver, fit, .. } = self;
        check([2, 3].contains(&surface.dim), "surface.dim", &surface.dim, "2 or 3")?;
        let hurst = &surface.hurst;
        let good = !hurst.is_empty() && hurst.iter().all(|h| (0.0..=1.0).contains(h)) && all_differ(hurst);
        check(good, "surface.hurst", hurst, "a list of different numbers from 0 to 1")?;
        let p_star = &loads.p_star;
        let ascending = p_star.windows(2).all(|pair| pair[0] < pair[1]);
        let good = !p_star.is_empty() && ascending && p_star.iter().all(|p| positive(*p));
        check(good, "loads.p_star", p_star, "an ascending list of positive numbers")?;
        let realisations = statistics.realisations;
        check((1..=1_000_000).contains(&realisations), "statistics.realisations", &realisations, "from 1 to 1000000")?;
        let tolerances = Budget::TOLERANCES;
        let allowed = format!("between {:e} and {}", tolerances.start(), tolerances.end());
        check(tolerances.contains(&solver.tol), "solver.tol", &solver.tol, &allowed)?;
        let names = Contact::SOLVERS.map(Solver::name).join(", ");
        let method = solver.method;
        check(Contact::SOLVERS.contains(&method), "solver.method", &method.name(), &format!("one of {names}"))?;
        check(solver.max_iter > 0, "solver.max_iter", &solver.max_iter, "1 or more")?;
        check(p_star.contains(&fit.p_star), "fit.p_star", &fit.p_star, &format!("one of loads.p_star, {p_star:?}"))?;
        for (field, alpha, word) in [
            ("fit.alpha_t", fit.alpha_t, None),
            ("fit.alpha_f", fit.alpha_f, Some((Alpha::SelfAffine, "self-affine"))),
            ("fit.alpha_c", fit.alpha_c, Some((Alpha::Edge, "edge"))),
        ] {
            let words = word.map_or_else(String::new, |(_, word)| format!("{word:?}, "));
            let allowed = format!("from 0.01 to 16, {words}\"free\" or \"none\"");
            match alpha {
                Alpha::Fixed(found) => check((0.01..=16.0).contains(&found), field, &found, &allowed)?,
                Alpha::SelfAffine | Alpha::Edge => {
                    check(word.is_some_and(|(own, _)| own == alpha), field, &alpha.word(), &allowed)?;
                }
                Alpha::Free | Alpha::Without => {}
            }
        }
        let allowed = "a number, \"free\" or \"none\" where surface.hurst is above 0.99, whose 1 - H is no exponent";
        let good = fit.alpha_f != Alpha::SelfAffine || hurst.iter().all(|h| 1.0 - h >= 0.01);
        check(good, "fit.alpha_f", &fit.alpha_f.word(), allowed)?;
        let allowed = "a number, \"free\" or \"none\" where surface.dim is 2: line contacts have no perimeter";
        check(fit.alpha_c != Alpha::Edge || surface.dim == 3, "fit.alpha_c", &fit.alpha_c.word(), allowed)?;
        check(fit.resamples <= 1_000_000, "fit.resamples", &fit.resamples, "from 0 to 1000000")?;
        let height = match self.body.height {
            Height::Finite(height) => height,
            Height::Infinite => 1.0,
        };
        self.body()?;
        let (size, sizes) = (SIZES.contains(&self.body.young), "from 1e-140 to 1e140");
        check(size, "body.young", &self.body.young, sizes)?;
        check(HEIGHTS.contains(&height), "body.height", &height, "from 1e-12 to 1e12, or \"inf\"")?;
        check(
            GRADIENTS.contains(&surface.rms_gradient),
            "surface.rms_gradient",
            &surface.rms_gradient,
            "from 1e-100 to 1e100",
        )
    }

    /// Number of realisations at a point of n points along one axis, if the largest grid has `largest`.
    pub(crate) fn realisations(&self, at: &Discretisation, n: usize, largest: usize) -> u64 {
        let StatisticsConfig { realisations, nested, equal_area, .. } = self.statistics;
        let reference = match self.points.design {
            Design::Star => self.points.centre[0],
            Design::Grid => self.points.eps_t_inv.first().copied().unwrap_or(1.0),
        };
        let sides = if self.surface.dim == 2 { 1 } else { 2 };
        if nested {
            let wanted = realisations as f64 * (largest as f64 / n as f64).powi(sides);
            return (wanted.round() as u64).min(64 * realisations);
        }
        if !equal_area || at.eps_t_inv == reference {
            return realisations;
        }
        let wanted = realisations as f64 * (reference / at.eps_t_inv).powi(sides);
        (wanted.round() as u64).clamp(realisations.min(4), 4 * realisations)
    }

    /// The elastic body.
    ///
    /// # Errors
    /// A modulus, Poisson's ratio or height out of its range.
    pub fn body(&self) -> Result<Body, SweepError> {
        let BodyConfig { young, poisson, height } = self.body;
        let body = Material::from_young(young, poisson).and_then(|material| Body::new(material, height));
        body.map_err(|source| {
            let field = match source {
                GreenError::Young(_) => "body.young",
                GreenError::Poisson(_) => "body.poisson",
                _ => "body.height",
            };
            SweepError::Body { field, source }
        })
    }

    /// The model of the extrapolation for surfaces of a Hurst exponent.
    pub fn model(&self, hurst: f64) -> Model {
        let FitConfig { alpha_t, alpha_f, alpha_c, .. } = self.fit;
        let exponent = |alpha: Alpha| alpha.exponent(hurst);
        Model { t: exponent(alpha_t), f: exponent(alpha_f), c: exponent(alpha_c), edge: alpha_c == Alpha::Edge }
    }

    /// The discretisations with their number of points along one axis, without repetition, small grids first.
    ///
    /// # Errors
    /// A combination that is no grid; no combination at all.
    pub(crate) fn discretisations(&self) -> Result<Vec<(Discretisation, usize)>, SweepError> {
        let PointsConfig { design, eps_t_inv, eps_f_inv, eps_c_inv, centre, largest_n } = &self.points;
        let mut all: Vec<[f64; 3]> = Vec::new();
        match design {
            Design::Grid => {
                for &t in eps_t_inv {
                    for &f in eps_f_inv {
                        all.extend(eps_c_inv.iter().map(|&c| [t, f, c]));
                    }
                }
            }
            Design::Star => {
                let [t, f, c] = *centre;
                all.push(*centre);
                all.extend(eps_t_inv.iter().map(|&t| [t, f, c]));
                all.extend(eps_f_inv.iter().map(|&f| [t, f, c]));
                all.extend(eps_c_inv.iter().map(|&c| [t, f, c]));
            }
        }
        let mut points: Vec<(Discretisation, usize)> = Vec::new();
        for [eps_t_inv, eps_f_inv, eps_c_inv] in all {
            let point = Discretisation { eps_t_inv, eps_f_inv, eps_c_inv };
            let n = point.points().map_err(SweepError::Points)?;
            if (*largest_n == 0 || n <= *largest_n) && !points.iter().any(|(other, _)| *other == point) {
                points.push((point, n));
            }
        }
        if points.is_empty() {
            let allowed = "at least one grid of no more than points.largest_n points along one axis".into();
            return Err(SweepError::Field { field: "points", found: "empty".into(), allowed });
        }
        points.sort_by_key(|(_, n)| *n);
        Ok(points)
    }
}

impl SolverConfig {
    /// Tolerance and iterations.
    pub fn budget(&self) -> Budget {
        Budget { tolerance: self.tol, max_iterations: self.max_iter }
    }
}

impl Alpha {
    fn exponent(self, hurst: f64) -> Option<Exponent> {
        match self {
            Self::Fixed(alpha) => Some(Exponent::Fixed(alpha)),
            Self::SelfAffine => Some(Exponent::Fixed(1.0 - hurst)),
            Self::Free => Some(Exponent::FREE),
            Self::Without | Self::Edge => None,
        }
    }

    /// The word of an exponent that is not a number.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Fixed(_) => "a number",
            Self::Free => "free",
            Self::Without => "none",
            Self::SelfAffine => "self-affine",
            Self::Edge => "edge",
        }
    }
}

fn all_differ(numbers: &[f64]) -> bool {
    numbers.iter().enumerate().all(|(i, number)| !numbers[..i].contains(number))
}
