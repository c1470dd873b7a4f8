//! Named sweeps.

use std::str::FromStr;

use gfmd_green::Height;

use crate::config::refusal;
use crate::{
    Alpha, BodyConfig, Config, Design, FitConfig, LoadsConfig, PointsConfig, StatisticsConfig, SurfaceConfig,
    SweepError,
};

/// Sweeps that have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Test of a few seconds.
    Smoke,
    /// Default of every field; takes less than a minute.
    Default,
    /// Study of the thesis; takes hours.
    Thesis,
    /// Study after Prodanov, Dapp and Müser; takes hours.
    Prodanov,
    /// Profiles in plane strain.
    Line,
}

impl gfmd_problem::options::Choice for Preset {
    fn all() -> &'static [Self] {
        &Self::ALL
    }

    fn name(self) -> &'static str {
        self.name()
    }

    fn meaning(self) -> &'static str {
        self.meaning()
    }
}

impl std::fmt::Display for Preset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 5] = [Self::Smoke, Self::Default, Self::Thesis, Self::Prodanov, Self::Line];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Default => "default",
            Self::Thesis => "thesis",
            Self::Prodanov => "prodanov",
            Self::Line => "line",
        }
    }

    /// Returns the purpose of the sweep in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Smoke => "Test run of a few seconds; its kappa is meaningless",
            Self::Default => "Less than a minute on two cores: H = 0.8, a reliable kappa",
            Self::Thesis => "Study of the thesis: H = 0, slab as high as the cell, up to 8192 x 8192 points",
            Self::Prodanov => "After Prodanov, Dapp and Mueser (2014): H = 0, 0.3, 0.8, eps_c_inv up to 8",
            Self::Line => "Profiles in plane strain",
        }
    }

    /// Returns the configuration.
    pub fn config(self) -> Config {
        let base = Config::default();
        match self {
            Self::Default => base,
            Self::Smoke => Config {
                points: PointsConfig {
                    design: Design::Star,
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
                loads: LoadsConfig { p_star: vec![0.001, 0.00325, 0.0055, 0.00775, 0.01], ..base.loads },
                statistics: StatisticsConfig { realisations: 4, nested: false, ..base.statistics },
                fit: FitConfig { p_star: 0.01, ..base.fit },
                ..base
            },
            Self::Prodanov => Config {
                surface: SurfaceConfig { hurst: vec![0.0, 0.3, 0.8], ..base.surface },
                points: PointsConfig {
                    design: Design::Star,
                    eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
                    eps_f_inv: vec![16.0, 32.0, 64.0, 128.0, 256.0, 512.0],
                    eps_c_inv: vec![2.0, 4.0, 8.0],
                    centre: [2.0, 64.0, 8.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.01, 0.02, 0.05], ..base.loads },
                statistics: StatisticsConfig { nested: false, ..base.statistics },
                ..base
            },
            Self::Line => Config {
                surface: SurfaceConfig { dim: 2, ..base.surface },
                points: PointsConfig {
                    design: Design::Star,
                    eps_t_inv: vec![1.0, 2.0, 4.0, 8.0],
                    eps_f_inv: vec![64.0, 256.0, 1024.0, 4096.0],
                    eps_c_inv: vec![4.0, 8.0, 16.0, 32.0],
                    centre: [4.0, 1024.0, 16.0],
                    ..base.points
                },
                loads: LoadsConfig { p_star: vec![0.02, 0.05, 0.1], ..base.loads },
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
