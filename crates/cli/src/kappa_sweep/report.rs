//! The result and the plan of a sweep, as JSON and as a table.

use std::fmt;
use std::path::PathBuf;

use gfmd_fit::{Axis, Datum};
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, PERSSON_KAPPA};
use gfmd_problem::MemoryNeed;
use gfmd_surface::Discretisation;
use gfmd_sweep::{Alternative, Analysis, Area, Extrapolation, Key, Plan, Point, Shard};
use serde::Serialize;

use super::calibration::seconds_per_pair;
use super::protocol::ProtocolReport;
use super::{CONTACT_BYTES, PROGRAM_BYTES};
use crate::session::list_files;
use gfmd_input::failure::Failure;

/// The result of a sweep, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub points: Vec<PointReport>,
    pub fit: FitReport,
    pub fits: Vec<FitReport>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub protocol: Vec<ProtocolReport>,
    pub theory: TheoryReport,
    pub out: PathBuf,
    pub plots: Vec<PathBuf>,
    pub seconds: f64,
    pub peak_bytes: u64,
}

/// The surfaces of one point of a sweep, and their grid.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    pub dim: u8,
    pub hurst: f64,
    pub eps_t_inv: f64,
    pub eps_f_inv: f64,
    pub eps_c_inv: f64,
    pub n: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct PointReport {
    #[serde(flatten)]
    pub cell: Cell,
    pub p_star: f64,
    pub realisations: usize,
    pub kappa: f64,
    pub kappa_sem: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa_corrected: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa_corrected_sem: Option<f64>,
    /// The part of kappa that the grid adds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<f64>,
    /// kappa with the long waves composed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa_composed: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa_composed_sem: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
pub struct FitReport {
    pub hurst: f64,
    pub p_star: f64,
    pub area: Area,
    pub kappa_tfc: f64,
    pub kappa_tfc_standard_error: Option<f64>,
    pub ci95: Option<[f64; 2]>,
    pub systematic: f64,
    pub total_ci95: Option<[f64; 2]>,
    pub alternatives: Vec<Alternative>,
    pub composed: bool,
    pub uncertainty: String,
    pub terms: Vec<TermReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<EdgeReport>,
    pub chi_squared: f64,
    pub degrees_of_freedom: usize,
    pub checks: Vec<Check>,
    pub warnings: Vec<String>,
}

/// The limit and the exponent from three levels of one axis at a constant ratio alone, as a check of the fixed
/// exponent.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Check {
    pub axis: char,
    pub eps_inv: [f64; 3],
    pub kappa: Option<f64>,
    pub exponent: Option<f64>,
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, eps_inv: [coarse, middle, fine], kappa, exponent } = self;
        let levels = format!("1/eps_{axis} = {coarse}, {middle}, {fine}");
        match (kappa, exponent) {
            (Some(kappa), Some(exponent)) => {
                write!(f, "{levels} alone give alpha_{axis} = {exponent:.2}, limit {kappa:.4}")
            }
            _ => write!(f, "{levels} alone do not determine a limit"),
        }
    }
}

#[derive(Clone, Debug, Serialize)]
pub struct TermReport {
    pub axis: char,
    pub coefficient: f64,
    pub coefficient_ci95: Option<[f64; 2]>,
    pub exponent: f64,
    pub exponent_ci95: Option<[f64; 2]>,
    pub exponent_fitted: bool,
    pub levels: usize,
}

/// The continuum error as a multiple of the edge that is estimated from each contact.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EdgeReport {
    pub factor: f64,
    pub factor_ci95: Option<[f64; 2]>,
    /// f' of the factor at four points on the shortest wave, f + f'.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarse: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coarse_ci95: Option<[f64; 2]>,
    /// Part of the standard error of kappa_TFC that comes from the standard error of the factor.
    pub share: Option<f64>,
}

/// Limits of comparison theories at vanishing load, for surfaces.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TheoryReport {
    pub persson: f64,
    pub bush_gibson_thomas: f64,
}

impl Cell {
    /// The heads of the columns that it prints.
    const HEADS: &str = "   H 1/eps_t 1/eps_f 1/eps_c      n";

    fn new(plan: &Plan, point: &Point) -> Self {
        let Discretisation { eps_t_inv, eps_f_inv, eps_c_inv } = point.discretisation;
        Self { dim: plan.config.surface.dim, hurst: point.hurst, eps_t_inv, eps_f_inv, eps_c_inv, n: point.n() }
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hurst, eps_t_inv, eps_f_inv, eps_c_inv, n, .. } = self;
        write!(f, "{hurst:>4} {eps_t_inv:>7} {eps_f_inv:>7} {eps_c_inv:>7} {n:>6}")
    }
}

impl FitReport {
    fn new(extrapolation: &Extrapolation) -> Self {
        let Extrapolation { hurst, p_star, area, fit, .. } = extrapolation;
        let terms = fit.terms.iter().map(|term| TermReport {
            axis: term.axis.letter(),
            coefficient: term.coefficient.value,
            coefficient_ci95: term.coefficient.ci95,
            exponent: term.exponent.value,
            exponent_ci95: term.exponent.ci95,
            exponent_fitted: term.free,
            levels: term.levels,
        });
        Self {
            hurst: *hurst,
            p_star: *p_star,
            area: *area,
            kappa_tfc: fit.kappa_tfc.value,
            kappa_tfc_standard_error: fit.kappa_tfc.standard_error,
            ci95: fit.kappa_tfc.ci95,
            composed: extrapolation.composed,
            systematic: extrapolation.systematic(),
            total_ci95: extrapolation.total_ci95(),
            alternatives: extrapolation.alternatives.clone(),
            uncertainty: fit.uncertainty.to_string(),
            terms: terms.collect(),
            edge: fit.edge.map(|edge| EdgeReport {
                factor: edge.factor.value,
                factor_ci95: edge.factor.ci95,
                coarse: edge.coarse.map(|coarse| coarse.value),
                coarse_ci95: edge.coarse.and_then(|coarse| coarse.ci95),
                share: edge.share,
            }),
            chi_squared: fit.chi_squared,
            degrees_of_freedom: fit.degrees_of_freedom,
            // The levels of eps_c have their surfaces in common. Along eps_t the scatter between surfaces would pass
            // for an exponent.
            checks: (fit.richardson.iter())
                .filter(|three| three.axis != Axis::Thermodynamic)
                .map(|three| Check {
                    axis: three.axis.letter(),
                    eps_inv: three.data.map(|index| 1.0 / extrapolation.data[index].eps(three.axis)),
                    kappa: three.limit.map(|limit| limit.kappa),
                    exponent: three.limit.map(|limit| limit.exponent),
                })
                .collect(),
            warnings: fit.warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

impl Report {
    /// Collects the numbers to be printed.
    pub fn new(
        plan: &Plan,
        analysis: &Analysis,
        (out, plots): (PathBuf, Vec<PathBuf>),
        (seconds, peak_bytes): (f64, u64),
    ) -> Self {
        let points = analysis.data.iter().filter(|(key, _)| key.area == Area::Raw).map(|(key, raw)| {
            let point = &plan.points[key.point];
            let corrected = analysis.data.get(&Key { area: Area::Corrected, ..*key });
            let composed = analysis.composed(key.point, key.load, plan);
            PointReport {
                cell: Cell::new(plan, point),
                p_star: plan.config.loads.p_star[key.load],
                realisations: raw.kappa.len(),
                kappa: raw.mean(),
                kappa_sem: raw.standard_error(),
                kappa_corrected: corrected.map(Datum::mean),
                kappa_corrected_sem: corrected.and_then(Datum::standard_error),
                edge: (!raw.edge.is_empty()).then(|| raw.mean_edge()),
                kappa_composed: composed.as_ref().map(Datum::mean),
                kappa_composed_sem: composed.as_ref().and_then(Datum::standard_error),
            }
        });
        let points = points.collect();
        let fits: Vec<FitReport> = analysis.extrapolations.iter().map(FitReport::new).collect();
        let theory = TheoryReport { persson: PERSSON_KAPPA, bush_gibson_thomas: BUSH_GIBSON_THOMAS_KAPPA };
        let protocol = analysis.protocols.iter().map(ProtocolReport::from).collect();
        Self { points, fit: FitReport::new(analysis.result()), fits, protocol, theory, out, plots, seconds, peak_bytes }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with_error = |value: f64, error: Option<f64>| match error {
            Some(error) => format!("{value:.4} ± {error:.4}"),
            None => format!("{value:.4}"),
        };
        writeln!(f, "{} {:>7} {:>5} {:>15} {:>15}", Cell::HEADS, "p*", "runs", "kappa", "corrected")?;
        for p in &self.points {
            let corrected = p.kappa_corrected.map_or_else(|| "-".into(), |k| with_error(k, p.kappa_corrected_sem));
            let kappa = with_error(p.kappa, p.kappa_sem);
            writeln!(f, "{} {:>7} {:>5} {kappa:>15} {corrected:>15}", p.cell, p.p_star, p.realisations)?;
        }
        for fit in &self.fits {
            let area = if fit.area == Area::Raw { "raw area" } else { "corrected area" };
            writeln!(f, "\nH = {}, p* = {}, {area}: {}", fit.hurst, fit.p_star, Headline(fit))?;
            for term in &fit.terms {
                writeln!(
                    f,
                    "  C_{0} = {1}, alpha_{0} = {2}{3}",
                    term.axis,
                    Interval(term.coefficient, term.coefficient_ci95),
                    Interval(term.exponent, term.exponent_ci95),
                    if term.exponent_fitted { "" } else { " (fixed)" }
                )?;
            }
            if let Some(edge) = fit.edge {
                write!(f, "  edge: {} of the estimate from each contact", Interval(edge.factor, edge.factor_ci95))?;
                match edge.coarse {
                    Some(coarse) => writeln!(f, ", plus {} (4 eps_c)^2", Interval(coarse, edge.coarse_ci95))?,
                    None => writeln!(f)?,
                }
            }
            for other in &fit.alternatives {
                writeln!(f, "  other form: {:.4} {}", other.kappa_tfc, other.form.meaning())?;
            }
            for check in &fit.checks {
                writeln!(f, "  check: {check}")?;
            }
            writeln!(f, "  chi^2 = {:.2} with {} degrees of freedom", fit.chi_squared, fit.degrees_of_freedom)?;
            for warning in &fit.warnings {
                writeln!(f, "  note: {warning}")?;
            }
        }
        self.protocol.iter().try_for_each(|protocol| write!(f, "{protocol}"))?;
        let result = &self.fit;
        writeln!(f, "\nResult: H = {}, p* = {}: {}", result.hurst, result.p_star, Headline(result))?;
        writeln!(f, "95 % interval: {}", result.uncertainty)?;
        if let Some([low, high]) = result.total_ci95 {
            writeln!(
                f,
                "With the error of the form, {:.4} (exponent, levels and closure in quadrature): [{low:.4}, {high:.4}]",
                result.systematic
            )?;
        }
        writeln!(
            f,
            "Theory at vanishing load, surfaces: Persson {:.4}, Bush-Gibson-Thomas {:.4}",
            self.theory.persson, self.theory.bush_gibson_thomas
        )?;
        writeln!(f, "{:.0} s, {:.2} GiB at the peak", self.seconds, self.peak_bytes as f64 / f64::from(1 << 30))?;
        list_files(f, Some(&self.out), &self.plots)
    }
}

struct Interval(f64, Option<[f64; 2]>);

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.1 {
            Some([low, high]) => write!(f, "{:.4} [{low:.4}, {high:.4}]", self.0),
            None => write!(f, "{:.4}", self.0),
        }
    }
}

struct Headline<'a>(&'a FitReport);

impl fmt::Display for Headline<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "kappa_TFC = {}", Interval(self.0.kappa_tfc, self.0.ci95))
    }
}

/// The work of a shard, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct ShardReport {
    pub shard: String,
    pub runs: usize,
    pub all_runs: usize,
    pub journal: PathBuf,
    pub seconds: f64,
    pub peak_bytes: u64,
}

impl fmt::Display for ShardReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { shard, runs, all_runs, journal, seconds, peak_bytes } = self;
        writeln!(f, "shard {shard}: {runs} of {all_runs} runs are in {}; --merge makes the result", journal.display())?;
        writeln!(f, "{seconds:.0} s, {:.2} GiB at the peak", *peak_bytes as f64 / f64::from(1 << 30))
    }
}

/// The output of `--dry-run`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct PlanReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<String>,
    pub points: Vec<PlannedPoint>,
    pub loads: Vec<f64>,
    pub runs: usize,
    pub threads: usize,
    pub seconds: f64,
    pub memory_bytes: u64,
}

#[derive(Clone, Debug, Serialize)]
pub struct PlannedPoint {
    #[serde(flatten)]
    pub cell: Cell,
    pub realisations: usize,
    pub memory_bytes: u64,
    pub seconds: f64,
}

impl PlanReport {
    /// Estimates memory and time of these runs of a plan on this machine.
    ///
    /// # Errors
    /// None on a machine that can transform a small grid.
    pub fn new(plan: &Plan, runs: &[usize], shard: Option<Shard>) -> Result<Self, Failure> {
        let pair = seconds_per_pair()?;
        let threads = rayon::current_num_threads();
        let mut points: Vec<PlannedPoint> = Vec::new();
        for runs in runs.chunk_by(|a, b| plan.runs[*a].point == plan.runs[*b].point) {
            let point = &plan.points[plan.runs[runs[0]].point];
            let side_by_side = if point.is_small() { threads.min(runs.len()) } else { 1 };
            points.push(PlannedPoint {
                cell: Cell::new(plan, point),
                realisations: runs.len(),
                memory_bytes: MemoryNeed::HARD_WALL.bytes(point.grid.points()).saturating_mul(side_by_side as u64),
                seconds: plan.work(point) * pair * runs.len() as f64,
            });
        }
        let contacts = (runs.len() * plan.config.loads.p_star.len()) as u64;
        let largest = points.iter().map(|point| point.memory_bytes).max().unwrap_or(0);
        Ok(Self {
            shard: shard.map(|shard| shard.to_string()),
            loads: plan.config.loads.p_star.clone(),
            runs: runs.len(),
            threads,
            // The sum of no numbers is -0.
            seconds: points.iter().fold(0.0, |sum, point| sum + point.seconds),
            memory_bytes: largest.saturating_add(contacts.saturating_mul(CONTACT_BYTES)).saturating_add(PROGRAM_BYTES),
            points,
        })
    }
}

impl fmt::Display for PlanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        writeln!(f, "{} {:>5} {:>11} {:>9}", Cell::HEADS, "runs", "memory/MiB", "time/s")?;
        for p in &self.points {
            let memory = mebibytes(p.memory_bytes);
            writeln!(f, "{} {:>5} {memory:>11.1} {:>9.1}", p.cell, p.realisations, p.seconds)?;
        }
        writeln!(
            f,
            "\n{}{} runs with {} loads each, about {:.0} s here on {} thread{}, at most {:.0} MiB",
            self.shard.as_ref().map(|shard| format!("shard {shard}: ")).unwrap_or_default(),
            self.runs,
            self.loads.len(),
            self.seconds,
            self.threads,
            if self.threads == 1 { "" } else { "s" },
            mebibytes(self.memory_bytes)
        )
    }
}
