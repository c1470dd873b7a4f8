//! What a sweep computes, as TOML and as presets.

use gfmd_contact::Solver;
use gfmd_fit::{Exponent, Model};
use gfmd_green::{Body, Height, Material};
use gfmd_surface::Discretisation;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// A sweep. Every field has a default: those of the preset `default`.
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
    pub height: HeightConfig,
}

/// A number, or `"inf"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum HeightConfig {
    /// A slab.
    Slab(f64),
    /// `"inf"`: a half-space.
    Named(String),
}

/// The discretisations: inverses of eps_t, eps_f, eps_c.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointsConfig {
    /// How the lists combine.
    pub design: Design,
    /// Longest wavelengths per cell.
    pub eps_t_inv: Vec<f64>,
    /// Longest over shortest wavelength.
    pub eps_f_inv: Vec<f64>,
    /// Grid points per shortest wavelength.
    pub eps_c_inv: Vec<f64>,
    /// The middle of a star: eps_t_inv, eps_f_inv, eps_c_inv.
    pub centre: [f64; 3],
    /// Leaves out points with more grid points along one axis than this; 0 for no limit.
    pub largest_n: usize,
}

/// How the lists of the three axes combine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// Every combination.
    Grid,
    /// One axis at a time, the others at the centre.
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
    /// Surfaces per point, where eps_t_inv is that of the centre (of a grid: its first one).
    pub realisations: u64,
    /// Whether points of larger cells get fewer surfaces, and points of smaller cells more, so that all sample the same
    /// area and are equally certain; between 4 and 4 times `realisations`.
    pub equal_area: bool,
    /// First seed. Points that differ only in eps_c share their seeds, so their surfaces; all others are independent.
    pub seed: u64,
}

/// The contact solver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverConfig {
    /// The method.
    #[serde(with = "crate::solver::by_name")]
    pub method: Solver,
    /// Largest residual of a converged state.
    pub tol: f64,
    /// Iterations after which a load is given up.
    pub max_iter: u64,
}

/// The extrapolation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitConfig {
    /// The load of the result that is printed large; all loads are fitted.
    pub p_star: f64,
    /// Exponent of the term in eps_t. A cell is a finite sample of roughness: its bias, like its variance, falls with the
    /// area, so 2 for surfaces and 1 for profiles.
    pub alpha_t: AlphaConfig,
    /// Exponent of the term in eps_f.
    pub alpha_f: AlphaConfig,
    /// Exponent of the term in eps_c. Area counted in points errs by the perimeter times part of a spacing: 1.
    pub alpha_c: AlphaConfig,
    /// Bootstrap resamples.
    pub resamples: usize,
}

/// A number, `"free"`, or `"none"` for no such term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AlphaConfig {
    /// Held at this value.
    Fixed(f64),
    /// `"free"` or `"none"`.
    Named(String),
}

impl Default for SurfaceConfig {
    fn default() -> Self {
        Self { dim: 3, hurst: vec![0.8], rms_gradient: 0.1 }
    }
}

impl Default for BodyConfig {
    fn default() -> Self {
        Self { young: 1.0, poisson: 0.0, height: HeightConfig::Named("inf".into()) }
    }
}

impl Default for PointsConfig {
    fn default() -> Self {
        Self {
            design: Design::Star,
            eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
            eps_f_inv: vec![8.0, 16.0, 32.0, 64.0, 128.0],
            eps_c_inv: vec![4.0, 8.0, 16.0, 32.0],
            centre: [2.0, 32.0, 8.0],
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
        Self { realisations: 16, equal_area: true, seed: 1 }
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
            alpha_t: AlphaConfig::Fixed(2.0),
            alpha_f: AlphaConfig::Fixed(1.0),
            alpha_c: AlphaConfig::Fixed(1.0),
            resamples: 2000,
        }
    }
}

/// Sweeps with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// Seconds: shows that everything works, not a result
    Smoke,
    /// A few minutes on two cores: H = 0.8, a believable kappa
    Default,
    /// The source's study: H = 0, slab as high as the cell, up to 8192 x 8192 points
    Thesis,
    /// In the spirit of Prodanov, Dapp and Mueser (2014): H = 0, 0.3, 0.8, eps_c_inv up to 8
    Prodanov,
    /// Profiles in plane strain
    Line,
}

impl Preset {
    /// The sweep.
    pub fn config(self) -> Config {
        let base = Config::default();
        match self {
            Self::Default => base,
            Self::Smoke => Config {
                points: PointsConfig {
                    eps_t_inv: vec![1.0, 2.0],
                    eps_f_inv: vec![8.0, 16.0],
                    eps_c_inv: vec![4.0, 8.0, 16.0],
                    centre: [2.0, 16.0, 4.0],
                    ..base.points
                },
                statistics: StatisticsConfig { realisations: 4, ..base.statistics },
                fit: FitConfig { resamples: 500, ..base.fit },
                ..base
            },
            Self::Thesis => Config {
                surface: SurfaceConfig { hurst: vec![0.0], rms_gradient: 0.01, ..base.surface },
                body: BodyConfig { poisson: 0.33, height: HeightConfig::Slab(1.0), ..base.body },
                points: PointsConfig {
                    design: Design::Grid,
                    eps_t_inv: vec![2.0],
                    eps_f_inv: vec![128.0, 256.0, 512.0],
                    eps_c_inv: vec![2.0, 4.0, 8.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.001, 0.00325, 0.0055, 0.00775, 0.01] },
                statistics: StatisticsConfig { realisations: 4, ..base.statistics },
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
                statistics: StatisticsConfig { realisations: 8, ..base.statistics },
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
                statistics: StatisticsConfig { realisations: 32, ..base.statistics },
                fit: FitConfig { p_star: 0.02, alpha_t: AlphaConfig::Fixed(1.0), ..base.fit },
                ..base
            },
        }
    }
}

impl Config {
    /// Reads a file; what it leaves out is as in the preset `default`.
    ///
    /// # Errors
    /// A file that cannot be read, is not TOML, or has an unknown or mistyped field.
    pub fn read(path: &std::path::Path) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::input(&path.display().to_string(), reason);
        let text = std::fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
        toml::from_str(&text).map_err(|error: toml::de::Error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            refuse(format!("line {line}: {}", error.message().replace('\n', ", ")))
        })
    }

    /// The configuration as TOML: what a file records so that the run can be repeated from it.
    ///
    /// # Errors
    /// Never for values that can be read back.
    pub fn to_toml(&self) -> Result<String, Failure> {
        toml::to_string(self).map_err(|error| Failure::Computation(error.to_string()))
    }

    /// Refuses what no sweep can do, field by field.
    ///
    /// # Errors
    /// The first bad field, what it holds, what it may hold.
    pub fn check(&self) -> Result<(), Failure> {
        let bad = |field: &str, allowed: &str, found: &dyn std::fmt::Debug| {
            Err(Failure::input(field, format!("{allowed} is allowed, found {found:?}")))
        };
        if ![2, 3].contains(&self.surface.dim) {
            return bad("surface.dim", "2 or 3", &self.surface.dim);
        }
        if self.surface.hurst.is_empty() || !self.surface.hurst.iter().all(|h| (0.0..=1.0).contains(h)) {
            return bad("surface.hurst", "a list of numbers from 0 to 1", &self.surface.hurst);
        }
        if !(self.surface.rms_gradient > 0.0 && self.surface.rms_gradient.is_finite()) {
            return bad("surface.rms_gradient", "a positive number", &self.surface.rms_gradient);
        }
        let loads = &self.loads.p_star;
        let ascending = loads.windows(2).all(|pair| pair[0] < pair[1]);
        if loads.is_empty() || !ascending || !loads.iter().all(|p| *p > 0.0 && p.is_finite()) {
            return bad("loads.p_star", "an ascending list of positive numbers", loads);
        }
        if !loads.contains(&self.fit.p_star) {
            return bad("fit.p_star", "one of loads.p_star", &self.fit.p_star);
        }
        if !(1..=1_000_000).contains(&self.statistics.realisations) {
            return bad("statistics.realisations", "1 to 1000000", &self.statistics.realisations);
        }
        if !(1e-15..=0.1).contains(&self.solver.tol) {
            return bad("solver.tol", "1e-15 to 0.1", &self.solver.tol);
        }
        self.body()?;
        self.model()?;
        Ok(())
    }

    /// Number of realisations at a point.
    pub fn realisations(&self, at: &Discretisation) -> u64 {
        let StatisticsConfig { realisations, equal_area, .. } = self.statistics;
        let reference = match self.points.design {
            Design::Star => self.points.centre[0],
            Design::Grid => self.points.eps_t_inv.first().copied().unwrap_or(1.0),
        };
        if !equal_area || at.eps_t_inv == reference {
            return realisations;
        }
        let sides = if self.surface.dim == 2 { 1 } else { 2 };
        let wanted = realisations as f64 * (reference / at.eps_t_inv).powi(sides);
        (wanted.round() as u64).clamp(realisations.min(4), 4 * realisations)
    }

    /// The elastic body.
    ///
    /// # Errors
    /// A modulus, Poisson's ratio or height out of its range.
    pub fn body(&self) -> Result<Body, Failure> {
        let height = match &self.body.height {
            HeightConfig::Slab(height) => Height::Finite(*height),
            HeightConfig::Named(name) if name == "inf" => Height::Infinite,
            HeightConfig::Named(name) => {
                return Err(Failure::input("body.height", format!("a number or \"inf\" is allowed, found {name:?}")));
            }
        };
        let material = Material::from_young(self.body.young, self.body.poisson);
        material.and_then(|material| Body::new(material, height)).map_err(|error| Failure::input("body", error))
    }

    /// The model of the fit.
    ///
    /// # Errors
    /// An exponent that is neither a number, `"free"` nor `"none"`.
    pub fn model(&self) -> Result<Model, Failure> {
        let exponent = |field: &str, alpha: &AlphaConfig| match alpha {
            AlphaConfig::Fixed(alpha) => Ok(Some(Exponent::Fixed(*alpha))),
            AlphaConfig::Named(name) if name == "free" => Ok(Some(Exponent::FREE)),
            AlphaConfig::Named(name) if name == "none" => Ok(None),
            AlphaConfig::Named(name) => {
                Err(Failure::input(field, format!("a number, \"free\" or \"none\" is allowed, found {name:?}")))
            }
        };
        Ok(Model {
            t: exponent("fit.alpha_t", &self.fit.alpha_t)?,
            f: exponent("fit.alpha_f", &self.fit.alpha_f)?,
            c: exponent("fit.alpha_c", &self.fit.alpha_c)?,
        })
    }

    /// The discretisations, each once, small ones first.
    ///
    /// # Errors
    /// A combination that is no grid; none at all.
    pub fn discretisations(&self) -> Result<Vec<(Discretisation, usize)>, Failure> {
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
        let mut cells: Vec<(Discretisation, usize)> = Vec::new();
        for [eps_t_inv, eps_f_inv, eps_c_inv] in all {
            let cell = Discretisation { eps_t_inv, eps_f_inv, eps_c_inv };
            let n = cell.points().map_err(|error| Failure::input("points", error))?;
            if (*largest_n == 0 || n <= *largest_n) && !cells.iter().any(|(other, _)| *other == cell) {
                cells.push((cell, n));
            }
        }
        if cells.is_empty() {
            return Err(Failure::input("points", "no discretisation is left to compute"));
        }
        cells.sort_by_key(|(_, n)| *n);
        Ok(cells)
    }
}
