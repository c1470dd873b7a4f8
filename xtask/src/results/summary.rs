//! Summaries of sweeps: the output of `kappa-sweep --json`.

use std::path::{Path, PathBuf};

use gfmd_input::failure::Failure;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::accuracy::Report;

/// Folder of the summaries.
pub(super) struct Summaries {
    folder: PathBuf,
}

/// Summary of one sweep.
#[derive(Debug, Deserialize)]
pub(super) struct Summary {
    pub(super) points: Vec<Point>,
    pub(super) fits: Vec<Fit>,
    #[serde(default)]
    pub(super) protocol: Vec<Protocol>,
}

/// kappa of a cell at a load.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Point {
    pub(super) hurst: f64,
    pub(super) eps_t_inv: f64,
    pub(super) eps_f_inv: f64,
    pub(super) eps_c_inv: f64,
    pub(super) n: u64,
    pub(super) p_star: f64,
    pub(super) kappa: f64,
    pub(super) kappa_sem: Option<f64>,
    pub(super) kappa_corrected: Option<f64>,
    pub(super) kappa_corrected_sem: Option<f64>,
    pub(super) edge: Option<f64>,
}

/// Joint fit.
#[derive(Debug, Deserialize)]
pub(super) struct Fit {
    pub(super) hurst: f64,
    pub(super) p_star: f64,
    pub(super) area: String,
    pub(super) kappa_tfc: f64,
    pub(super) kappa_tfc_standard_error: Option<f64>,
    pub(super) ci95: Option<[f64; 2]>,
    pub(super) systematic: f64,
    pub(super) total_ci95: Option<[f64; 2]>,
    #[serde(default)]
    pub(super) alternatives: Vec<Alternative>,
    pub(super) terms: Vec<Term>,
    pub(super) edge: Option<Edge>,
    pub(super) chi_squared: f64,
    pub(super) degrees_of_freedom: usize,
}

/// Edge of the grid in a fit.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Edge {
    pub(super) factor: f64,
    pub(super) share: Option<f64>,
}

/// kappa_TFC of another form of the fit.
#[derive(Debug, Deserialize)]
pub(super) struct Alternative {
    pub(super) form: String,
    pub(super) kappa_tfc: f64,
}

#[derive(Debug, Deserialize)]
pub(super) struct Term {
    pub(super) axis: String,
    pub(super) exponent: f64,
}

/// Fits along one axis at a time about a reference cell.
#[derive(Debug, Deserialize)]
pub(super) struct Protocol {
    pub(super) reference: [f64; 3],
    pub(super) kappa_sim: Number,
    pub(super) kappa_tfc: Option<Number>,
    pub(super) arms: Vec<Arm>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Arm {
    pub(super) axis: String,
    pub(super) eps_inv: Vec<f64>,
    pub(super) kappa: Vec<Number>,
    pub(super) limit: Option<Number>,
    pub(super) coefficient: Option<Number>,
    pub(super) exponent: Option<Number>,
    pub(super) predicted: Option<Number>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) ci95: Option<[f64; 2]>,
}

impl Summaries {
    pub(super) fn new(folder: &Path) -> Self {
        Self { folder: folder.into() }
    }

    /// Reads the summary `NAME.json` of a sweep.
    pub(super) fn read(&self, name: &str) -> Result<Summary, Failure> {
        self.parsed(name)
    }

    /// Reads the summary of `accuracy`.
    pub(super) fn accuracy(&self) -> Result<Report, Failure> {
        self.parsed("accuracy")
    }

    /// Reads the summary of `finite`.
    pub(super) fn finite(&self) -> Result<crate::finite::Report, Failure> {
        self.parsed("finite")
    }

    fn parsed<T: DeserializeOwned>(&self, name: &str) -> Result<T, Failure> {
        let path = self.folder.join(format!("{name}.json"));
        let refuse = |error: &dyn std::fmt::Display| Failure::input(path.display().to_string(), error);
        let text = std::fs::read_to_string(&path).map_err(|error| refuse(&error))?;
        serde_json::from_str(&text).map_err(|error| refuse(&error))
    }
}

impl Summary {
    /// Returns the only cell of a sweep at one discretisation and load.
    pub(super) fn cell(&self) -> Result<&Point, Failure> {
        self.points.first().ok_or_else(|| Failure::refused("a summary has no points; it must have one"))
    }
}

impl Protocol {
    pub(super) fn arm(&self, axis: &str) -> Option<&Arm> {
        self.arms.iter().find(|arm| arm.axis == axis)
    }
}

impl Point {
    /// Formats kappa with its standard error in units of the last digit.
    pub(super) fn shown(&self) -> String {
        match self.kappa_sem {
            Some(error) => format!("{:.3}({:.0})", self.kappa, 1e3 * error),
            None => format!("{:.3}", self.kappa),
        }
    }
}

impl Point {
    /// Formats kappa of the perimeter-corrected area with its standard error in units of the last digit.
    pub(super) fn shown_corrected(&self) -> String {
        match (self.kappa_corrected, self.kappa_corrected_sem) {
            (Some(kappa), Some(error)) => format!("{kappa:.3}({:.0})", 1e3 * error),
            (Some(kappa), None) => format!("{kappa:.3}"),
            (None, _) => "–".into(),
        }
    }
}

impl Number {
    /// Formats the value and its interval.
    pub(super) fn shown(&self) -> String {
        match self.ci95 {
            Some([low, high]) => format!("{:.2} [{low:.2}, {high:.2}]", self.value),
            None => format!("{:.2}", self.value),
        }
    }
}

/// Formats a value that may be missing.
pub(super) fn or_none(number: Option<&Number>) -> String {
    number.map_or_else(|| "none".into(), Number::shown)
}
