//! Number of surfaces at each point for a target error of the result.

use std::collections::BTreeMap;

use gfmd_fit::{Axis, Datum, Exponent, Settings, fit};

use crate::analysis::settings;
use crate::{Analysis, Area, Extrapolation, Plan};

/// Largest growth of a point's number of surfaces in one round, since the scatter is estimated from the existing
/// surfaces.
const LARGEST_GROWTH: u64 = 4;

/// Rounds aim at this fraction of the target, so that the scatter of the estimates does not cause many more rounds.
const AIM: f64 = 0.95;

/// Statistical error of the result of a sweep, relative to kappa_TFC, and the surfaces that lower it.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPrecision {
    /// Half of the 95 % interval divided by kappa_TFC at the load of the result, the largest of all Hurst exponents.
    pub relative: f64,
    /// Number of surfaces of each point for the next round, none smaller than the current one. They equal the current
    /// numbers if the target is met, or if no number of surfaces can meet it.
    pub surfaces: Vec<u64>,
}

impl SweepPrecision {
    /// Returns the error of an analysis of a plan, and the surfaces that reduce it to `target` with the least work;
    /// `None` if a fit has no interval.
    ///
    /// The contribution of a point to the variance of kappa_TFC is its increase with half of the surfaces; it is
    /// inversely proportional to their number m. The least work for a sum of contributions W/m is at m ∝ √(W/work of a
    /// surface).
    pub fn new(plan: &Plan, analysis: &Analysis, target: f64) -> Option<Self> {
        let mut relative = 0.0_f64;
        let mut surfaces: Vec<u64> = (0..plan.points.len()).map(|point| plan.runs_of(point).len() as u64).collect();
        let is_result = |e: &&Extrapolation| e.p_star == plan.config.fit.p_star && e.area == Area::Raw;
        for result in analysis.extrapolations.iter().filter(is_result) {
            let [low, high] = result.fit.kappa_tfc.ci95?;
            let found = 0.5 * (high - low) / result.fit.kappa_tfc.value.abs();
            relative = relative.max(found);
            if found > target {
                let wanted = (AIM * target / found).powi(2);
                grow(plan, result, wanted, &mut surfaces)?;
            }
        }
        Some(Self { relative, surfaces })
    }
}

/// Increases the surfaces of the points of one Hurst exponent so that the variance falls to the fraction `wanted`.
fn grow(plan: &Plan, result: &Extrapolation, wanted: f64, surfaces: &mut [u64]) -> Option<()> {
    let mut settings = Settings { resamples: 0, ..settings(&plan.config, result.hurst, result.area) };
    if let (true, Some(term)) = (result.composed, result.fit.term(Axis::Fractal).filter(|term| !term.free)) {
        settings.model.f = Some(Exponent::Fixed(term.exponent.value));
    }
    let variance = |data: &[Datum]| Some(fit(data, &settings).ok()?.kappa_tfc.standard_error?.powi(2));
    let whole = variance(&result.data)?;
    // Point, contribution to the variance times the number of surfaces, work of a surface.
    let mut shares: Vec<(usize, f64, f64)> = Vec::new();
    for (index, datum) in result.data.iter().enumerate() {
        let is_here = |point: &usize| {
            let at = plan.points[*point].discretisation;
            let eps = [at.eps_t_inv, at.eps_f_inv, at.eps_c_inv].map(f64::recip);
            plan.points[*point].hurst == result.hurst && eps == datum.all_eps()
        };
        let point = (0..plan.points.len()).find(is_here)?;
        let count = datum.kappa.len();
        if count < 4 {
            continue;
        }
        let mut fewer = result.data.clone();
        fewer[index] = half(datum);
        let contribution = (variance(&fewer)? - whole).max(0.0);
        shares.push((point, contribution * count as f64, plan.work(&plan.points[point])));
    }
    let now = |point: usize, surfaces: &[u64]| surfaces[point] as f64;
    let of_shares: f64 = shares.iter().map(|(point, share, _)| share / now(*point, surfaces)).sum();
    // The part that no single point contributes is assumed constant.
    let rest = (whole - of_shares).max(0.0);
    let number = |scale: f64, (point, share, work): &(usize, f64, f64)| {
        let least = now(*point, surfaces);
        (scale * (share / work).sqrt()).clamp(least, least * LARGEST_GROWTH as f64)
    };
    let left = |scale: f64| rest + shares.iter().map(|share| share.1 / number(scale, share)).sum::<f64>();
    let [mut low, mut high] = [-60.0_f64, 60.0];
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if left(middle.exp()) > wanted * whole { low = middle } else { high = middle }
    }
    let numbers: Vec<(usize, f64)> = shares.iter().map(|share| (share.0, number(high.exp(), share))).collect();
    for (point, number) in numbers {
        surfaces[point] = number.ceil() as u64;
    }
    Some(())
}

/// Returns the datum with the first half of its surfaces.
fn half(datum: &Datum) -> Datum {
    let first = |values: &BTreeMap<u64, f64>| -> BTreeMap<u64, f64> {
        values.iter().take(datum.kappa.len() / 2).map(|(seed, value)| (*seed, *value)).collect()
    };
    Datum { edge: first(&datum.edge), ..Datum::new(datum.all_eps(), first(&datum.kappa)) }
}
