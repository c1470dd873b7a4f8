//! Configuration of a sweep.

mod body;
mod check;

use gfmd_contact::{Budget, Solver};
use gfmd_fit::{Edge, Exponent, Model};
use gfmd_green::{BaseKind, Body, Height};
use gfmd_measure::LongWaves;
use gfmd_problem::options::text;
use gfmd_surface::{Discretisation, Marginal};
use serde::{Deserialize, Serialize};

use crate::SweepError;
use crate::words::{base, height, solver};

pub(crate) use check::refusal;

/// Configuration of a sweep. The default of every field is its value in the preset `default`.
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
    /// Rough surfaces.
    pub surface: SurfaceConfig,
    /// Elastic body.
    pub body: BodyConfig,
    /// Discretisations.
    pub points: PointsConfig,
    /// Loads, ascending.
    pub loads: LoadsConfig,
    /// Realisations.
    pub statistics: StatisticsConfig,
    /// Contact solver.
    pub solver: SolverConfig,
    /// Extrapolation.
    pub fit: FitConfig,
}

/// Rough surfaces: self-affine, Gaussian.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SurfaceConfig {
    /// 3 for surfaces of three-dimensional bodies, 2 for profiles in plane strain.
    pub dim: u8,
    /// Hurst exponents, each with its own fit.
    pub hurst: Vec<f64>,
    /// Spectral rms gradient of every realisation.
    pub rms_gradient: f64,
    /// Method to generate heights.
    pub method: Method,
    /// Wavelength of the roll-off divided by the longest one: waves between the two have equal power. 1 for none.
    pub roll_off: f64,
    /// Correlation length along the lay divided by the correlation length across it; 1 for isotropic surfaces. Waves
    /// along the lay are longer by its square root than eps_t says, waves across it shorter than eps_f says.
    #[serde(skip_serializing_if = "is_one")]
    pub aspect: f64,
    /// Direction of the lay from the x axis, degrees.
    #[serde(skip_serializing_if = "is_zero")]
    pub lay: f64,
    /// Distribution of the heights; normal if left out.
    #[serde(with = "text", skip_serializing_if = "Option::is_none")]
    pub marginal: Option<Marginal>,
}

/// Methods to generate heights (theory.md, section 9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// From the power spectrum.
    #[default]
    Psd,
    /// Successive random addition on a lattice, restricted to waves between the cut-offs. The cell is cut out of a
    /// larger lattice, so its opposite edges do not match.
    Sra,
    /// Random midpoint displacement, restricted in the same way.
    Rmd,
    /// Exponent printed in the thesis, eq. 5.5, h ~ 1/q^(2(1+H)): a surface with the Hurst exponent 1 + 2H, which is at
    /// most 1 for H = 0 only.
    Printed,
}

/// Elastic body under a cell of length 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyConfig {
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Height of the slab, or of the top layer, divided by the cell length, or `"inf"`.
    #[serde(with = "height")]
    pub height: Height,
    /// Support of the lowest layer: `"bonded"`, `"sliding"`, `"free"` or `"half-space"`.
    #[serde(with = "base", skip_serializing_if = "is_bonded")]
    pub base: BaseKind,
    /// Young's modulus of the half-space below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_young: Option<f64>,
    /// Poisson's ratio of the half-space below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_poisson: Option<f64>,
    /// Layers below the top one, from the top down: Young's modulus, Poisson's ratio, height divided by cell length.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<[f64; 3]>,
    /// Body of the rough surface: Young's modulus, Poisson's ratio and, for a slab, the height divided by the cell
    /// length. Empty if the surface is rigid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub second_body: Vec<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_bonded(base: &BaseKind) -> bool {
    *base == BaseKind::Bonded
}

/// Discretisations: inverses of eps_t, eps_f, eps_c.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointsConfig {
    /// Combination of the lists.
    pub design: Design,
    /// Longest wavelengths per cell.
    pub eps_t_inv: Vec<f64>,
    /// Longest wavelength divided by shortest wavelength.
    pub eps_f_inv: Vec<f64>,
    /// Grid points per shortest wavelength.
    pub eps_c_inv: Vec<f64>,
    /// Centre of a star or of ladders: eps_t_inv, eps_f_inv, eps_c_inv.
    pub centre: [f64; 3],
    /// Largest number of grid points along one axis; larger grids are left out. 0 means no limit.
    pub largest_n: usize,
}

/// Combinations of the lists of the three axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// All combinations.
    Grid,
    /// One axis at a time, with the other two at the centre.
    Star,
    /// All combinations of eps_t_inv and eps_f_inv with the eps_c_inv of the centre, up to its largest grid, and all
    /// eps_c_inv at the centre. The term of a finite cell depends on eps_f (theory.md, section 11).
    Ladders,
}

/// Loads of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadsConfig {
    /// Reduced pressures p/(E* g), ascending; each load starts from the one before.
    pub p_star: Vec<f64>,
    /// Quantity that is prescribed at the loads between the first and the last.
    pub control: Control,
}

/// Prescribed quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// Reduced pressure of every load.
    #[default]
    Load,
    /// Approach, in equal steps from its value at the first reduced pressure to its value at the last one. Since the
    /// equilibrium of a contact is unique, this only changes which loads of the same curve are sampled.
    Approach,
}

/// Estimators of kappa from the contact areas at the loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Ratio a_r/p* at each load.
    #[default]
    Ratio,
    /// Slope of the straight line through all loads (least squares, with intercept), for each surface.
    Slope,
}

/// Realisations of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StatisticsConfig {
    /// Number of surfaces at points with the eps_t_inv of the centre (first eps_t_inv for the design `grid`); if
    /// `nested`, at the largest grid.
    pub realisations: u64,
    /// True if smaller grids get more surfaces, in inverse proportion to their number of points and at most 64 times
    /// `realisations`, so that each point takes about equal time. Points of one eps_t share their surfaces, and the
    /// many surfaces of coarse points improve the finer points ([`gfmd_fit`]).
    pub nested: bool,
    /// Without `nested`: true if points of larger cells get fewer surfaces and points of smaller cells more, between 4
    /// and 4 times `realisations`. Each point then samples about equal area and has about equal statistical error.
    pub equal_area: bool,
    /// Target of the relative statistical error of kappa_TFC at the load of the result (half of the 95 % interval, for
    /// each Hurst exponent). Surfaces are added where they lower it most for their work; 0: none are added.
    #[serde(skip_serializing_if = "is_zero")]
    pub target: f64,
    /// Number of surfaces at each point, small grids first and the Hurst exponents of each discretisation in order. 0
    /// leaves a point out; if empty, the numbers follow from the rules above. The result of a sweep with a target has
    /// its final numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<u64>,
    /// First seed. Points of one eps_t share their seeds, and thus their random modes; points of another eps_t have
    /// independent surfaces.
    pub seed: u64,
}

/// Contact solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverConfig {
    /// Solution method.
    #[serde(with = "solver")]
    pub method: Solver,
    /// Largest residual of a converged state.
    pub tolerance: f64,
    /// Largest number of iterations for one load.
    pub max_iterations: u64,
}

/// Extrapolation of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitConfig {
    /// Load of the main result; all loads are fitted.
    pub p_star: f64,
    /// Exponent of the term in eps_t, which multiplies the term in eps_f: C_t eps_t^alpha_t eps_f^alpha_f. A finite
    /// cell differs by the sum over its discrete longest waves: 2 for surfaces, 1 for profiles.
    pub alpha_t: Alpha,
    /// Waves longer than the longest waves of the surfaces, which the fractal limit needs.
    pub long_waves: LongWavesConfig,
    /// Exponent of the term in eps_f: a number, `"free"`, `"none"` or `"self-affine"`. With the long waves composed,
    /// the latter is the exponent of the difference of two closures, between 1 - H and 2 - 2H and at most 1; otherwise
    /// it is 1 - H (theory.md, section 11).
    pub alpha_f: Alpha,
    /// Exponent of the term in eps_c: a number, `"free"`, `"none"` or `"edge"`. The latter subtracts a multiple near
    /// one of the excess estimated from each contact, instead of a power of eps_c. It applies to the raw area; the
    /// remaining error of the corrected area is fitted with the exponent 1.
    pub alpha_c: Alpha,
    /// Estimator of kappa for one surface.
    pub estimator: Estimator,
    /// Reference cells (eps_t_inv, eps_f_inv, eps_c_inv) for extrapolations of one axis at a time
    /// ([`crate::Protocol`]), as in earlier studies. A star has its points about these cells, if there are any.
    pub references: Vec<[f64; 3]>,
    /// Number of bootstrap resamples.
    pub resamples: usize,
}

/// Waves longer than the longest waves of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LongWavesConfig {
    /// Composed with the contacts of the sweep by Persson's theory (`LongWaves` of `gfmd-measure`), where possible: on
    /// surfaces from the power spectrum without roll-off with H up to 0.99, on a half-space, or a slab at least as high
    /// as the cell, with the estimator `ratio` and four or more prescribed loads up to p* = 1 or more, neighbours
    /// within a factor of 3.
    Composed,
    /// Left out: kappa falls with a power of eps_f, which is extrapolated.
    None,
}

/// Exponent of one term: a number or a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Fixed exponent.
    Fixed(f64),
    /// Fitted exponent.
    Free,
    /// No term along this axis.
    Without,
    /// For eps_f: 1 - H, since the gradient of the longest waves divided by the gradient of all waves is eps_f^(1 - H).
    /// If the long waves are composed, an exponent between 1 - H and 2 - 2H, at most 1.
    SelfAffine,
    /// For eps_c: a multiple of the estimated edge of each contact instead of a power.
    Edge,
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

impl Default for SurfaceConfig {
    fn default() -> Self {
        Self {
            dim: 3,
            hurst: vec![0.8],
            rms_gradient: 0.1,
            method: Method::Psd,
            roll_off: 1.0,
            aspect: 1.0,
            lay: 0.0,
            marginal: None,
        }
    }
}

impl Default for BodyConfig {
    fn default() -> Self {
        Self {
            young: 1.0,
            poisson: 0.0,
            height: Height::Infinite,
            base: BaseKind::Bonded,
            base_young: None,
            base_poisson: None,
            layers: Vec::new(),
            second_body: Vec::new(),
        }
    }
}

impl Default for PointsConfig {
    fn default() -> Self {
        Self {
            design: Design::Ladders,
            eps_t_inv: vec![1.0, 2.0],
            eps_f_inv: vec![16.0, 32.0, 64.0, 128.0],
            eps_c_inv: vec![4.0, 8.0],
            centre: [1.0, 32.0, 4.0],
            largest_n: 0,
        }
    }
}

impl Default for LoadsConfig {
    fn default() -> Self {
        Self { p_star: vec![0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.2], control: Control::Load }
    }
}

impl Default for StatisticsConfig {
    fn default() -> Self {
        Self { realisations: 8, nested: true, equal_area: true, target: 0.0, surfaces: Vec::new(), seed: 1 }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self { method: Solver::Auto, tolerance: 1e-8, max_iterations: 10_000 }
    }
}

impl Default for FitConfig {
    fn default() -> Self {
        Self {
            p_star: 0.02,
            alpha_t: Alpha::Fixed(2.0),
            long_waves: LongWavesConfig::Composed,
            alpha_f: Alpha::SelfAffine,
            alpha_c: Alpha::Edge,
            estimator: Estimator::Ratio,
            references: Vec::new(),
            resamples: 2000,
        }
    }
}

/// Factor of the discretisation error of kappa that is estimated from each contact (`Summary::kappa_limit` of
/// `gfmd-measure`): the strip along the edge is 0.86 ± 0.03 (95 %) of the strip of Yastrebov et al. (theory.md, section
/// 9.2). With four points a wave, pairs of grids deviate by another 0.03 (section 11).
const EDGE: Edge = Edge { factor: 1.0, standard_error: 0.0175, coarse: 0.03 };

/// Largest number of discretisations of a sweep, since a configuration may come from an untrusted file.
const MOST_POINTS: usize = 10_000;

impl Config {
    /// Returns the number of realisations at a point with n points along one axis; the largest grid has `largest`.
    pub(crate) fn realisations(&self, at: &Discretisation, n: usize, largest: usize) -> u64 {
        let StatisticsConfig { realisations, nested, equal_area, .. } = self.statistics;
        let reference = match self.points.design {
            Design::Star | Design::Ladders => self.points.centre[0],
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

    /// Builds the elastic body.
    ///
    /// # Errors
    /// Returns an error if a modulus, Poisson's ratio or height is out of range, or if properties cannot be combined.
    pub fn body(&self) -> Result<Body, SweepError> {
        self.body.build()
    }

    /// Returns true if the missing long waves of surfaces with this Hurst exponent are composed.
    pub fn composes(&self, hurst: f64) -> bool {
        let high = self.body.is_high();
        let wanted = self.fit.long_waves == LongWavesConfig::Composed && self.fit.estimator == Estimator::Ratio;
        let SurfaceConfig { dim, method, roll_off, aspect, ref marginal, .. } = self.surface;
        let endless = dim == 3 && method == Method::Psd && roll_off == 1.0 && aspect == 1.0 && marginal.is_none();
        wanted
            && endless
            && self.loads.control == Control::Load
            && hurst <= 0.99
            && high
            && LongWaves::suits(&self.loads.p_star)
    }

    /// Returns the extrapolation model for surfaces with this Hurst exponent.
    pub fn model(&self, hurst: f64) -> Model {
        let FitConfig { alpha_t, alpha_f, alpha_c, .. } = self.fit;
        let [min, max] = self.exponents(hurst);
        let exponent = |alpha: Alpha| match alpha {
            Alpha::Fixed(alpha) => Some(Exponent::Fixed(alpha)),
            Alpha::SelfAffine if self.composes(hurst) => Some(Exponent::Free { min, max }),
            Alpha::SelfAffine => Some(Exponent::Fixed(min)),
            Alpha::Free => Some(Exponent::FREE),
            Alpha::Without | Alpha::Edge => None,
        };
        let edge = (alpha_c == Alpha::Edge).then_some(EDGE);
        Model { t: exponent(alpha_t), f: exponent(alpha_f), c: exponent(alpha_c), crossed: true, edge }
    }

    /// Returns the smallest and the largest exponent of eps_f in kappa of surfaces with this Hurst exponent (theory.md,
    /// section 11).
    pub(crate) fn exponents(&self, hurst: f64) -> [f64; 2] {
        [1.0 - hurst, (2.0 - 2.0 * hurst).min(1.0)]
    }

    /// Returns the discretisations and their points along one axis, without repetition, small grids first.
    ///
    /// # Errors
    /// Returns an error if a combination gives no grid, or if there is no combination at all.
    pub(crate) fn discretisations(&self) -> Result<Vec<(Discretisation, usize)>, SweepError> {
        let PointsConfig { design, eps_t_inv, eps_f_inv, eps_c_inv, centre, largest_n } = &self.points;
        let [t, f, c] = [eps_t_inv, eps_f_inv, eps_c_inv].map(Vec::len);
        let count = match design {
            Design::Grid => t.saturating_mul(f).saturating_mul(c),
            Design::Star => (1 + t + f + c).saturating_mul(self.fit.references.len().max(1)),
            Design::Ladders => t.saturating_mul(f).saturating_add(1 + c),
        };
        if count > MOST_POINTS {
            let allowed = format!("at most {MOST_POINTS} combinations of the three numbers");
            return Err(SweepError::Field { field: "points", found: count.to_string(), allowed });
        }
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
                let centres = if self.fit.references.is_empty() { vec![*centre] } else { self.fit.references.clone() };
                for centre in centres {
                    let [t, f, c] = centre;
                    all.push(centre);
                    all.extend(eps_t_inv.iter().map(|&t| [t, f, c]));
                    all.extend(eps_f_inv.iter().map(|&f| [t, f, c]));
                    all.extend(eps_c_inv.iter().map(|&c| [t, f, c]));
                }
            }
            Design::Ladders => {
                let [centre_t, centre_f, centre_c] = *centre;
                all.push(*centre);
                let most = centre_t * eps_f_inv.iter().copied().fold(centre_f, f64::max);
                for &t in eps_t_inv {
                    let ladder = eps_f_inv.iter().filter(|f| t == centre_t || t * **f <= most);
                    all.extend(ladder.map(|&f| [t, f, centre_c]));
                }
                all.extend(eps_c_inv.iter().map(|&c| [centre_t, centre_f, c]));
            }
        }
        let mut points: Vec<(Discretisation, usize)> = Vec::new();
        for [eps_t_inv, eps_f_inv, eps_c_inv] in all {
            let point = Discretisation { eps_t_inv, eps_f_inv, eps_c_inv };
            let n = point.points().map_err(SweepError::Points)?;
            let stretch = self.surface.aspect.sqrt();
            if eps_t_inv < stretch || eps_c_inv < 2.0 * stretch {
                let found = self.surface.aspect.to_string();
                let allowed = format!("at most {}", eps_t_inv.min(0.5 * eps_c_inv).powi(2));
                let allowed = format!("{allowed} with eps_t_inv = {eps_t_inv} and eps_c_inv = {eps_c_inv}");
                return Err(SweepError::Field { field: "surface.aspect", found, allowed });
            }
            if let Some(marginal) = &self.surface.marginal
                && eps_c_inv <= 2.0 * stretch
            {
                let found = marginal.to_string();
                let allowed = format!("left out with eps_c_inv = {eps_c_inv}: the shortest waves have two points");
                return Err(SweepError::Field { field: "surface.marginal", found, allowed });
            }
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
    /// Returns the tolerance and the iteration limit.
    pub fn budget(&self) -> Budget {
        Budget { tolerance: self.tolerance, max_iterations: self.max_iterations }
    }
}

impl Alpha {
    /// Returns the word for an exponent.
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
