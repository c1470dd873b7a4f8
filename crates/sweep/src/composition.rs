//! kappa of infinitely large surfaces, from kappa of the surfaces of a sweep (theory.md, section 11).

use std::collections::BTreeMap;

use gfmd_fit::Datum;
use gfmd_measure::LongWaves;

use crate::{Analysis, Area, Extrapolation, Key, Plan, Point, Pressed, SweepError};

/// Choices of the pressure distribution of the long waves (theory.md, section 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closure {
    /// Persson's shape with the contact area of the infinite surface.
    Area,
    /// Persson's shape with the mean square pressure as well.
    Square,
}

/// Composition with the missing long waves, for the surfaces of each point.
pub(crate) struct Composition {
    points: Vec<Option<LongWaves>>,
}

impl Composition {
    /// Builds the composition from kappa of all points and loads, and from the contacts.
    pub(crate) fn new(
        plan: &Plan,
        data: &BTreeMap<Key, Datum>,
        runs: &[Vec<Pressed>],
        closure: Closure,
    ) -> Result<Self, SweepError> {
        let loads = &plan.config.loads.p_star;
        // Here the edge affects only the width of the pressure distribution; the fit has its own factor.
        let limit = |point: usize, load: usize| {
            let datum = data.get(&Key { point, load, area: Area::Raw });
            datum.map_or(f64::NAN, |datum| datum.mean() - datum.mean_edge())
        };
        let square = |point: usize, load: usize| {
            let runs = &runs[plan.runs_of(point)];
            runs.iter().map(|run| run[load].summary.reduced_square_limit()).sum::<f64>() / runs.len() as f64
        };
        let of_point = |index: usize| {
            let Point { hurst, discretisation, .. } = plan.points[index];
            if !plan.config.composes(hurst) {
                return Ok(None);
            }
            let missing = discretisation.missing_long_waves(hurst).map_err(SweepError::Points)?;
            let kappa: Vec<f64> = (0..loads.len()).map(|load| limit(index, load)).collect();
            let waves = match closure {
                Closure::Area => LongWaves::new(loads, &kappa, missing),
                Closure::Square => {
                    let squares: Vec<f64> = (0..loads.len()).map(|load| square(index, load)).collect();
                    LongWaves::with_moments(loads, &kappa, &squares, missing)
                }
            };
            waves.map(Some).ok_or(SweepError::Composition { hurst, discretisation, kappa })
        };
        Ok(Self { points: (0..plan.points.len()).map(of_point).collect::<Result<_, _>>()? })
    }

    /// Returns the datum with composed kappa and edge of each surface.
    pub(crate) fn compose(&self, data: &BTreeMap<Key, Datum>, key: &Key) -> Option<Datum> {
        let (waves, datum) = (self.points[key.point].as_ref()?, data.get(key)?);
        let at = |load: usize| data.get(&Key { load, ..*key });
        let kappa_at = |load: usize, seed: u64| at(load).and_then(|d| d.kappa.get(&seed)).copied().unwrap_or(f64::NAN);
        let edge_at = |load: usize, seed: u64| at(load).and_then(|d| d.edge.get(&seed)).copied().unwrap_or(f64::NAN);
        let kappa = datum.kappa.keys().map(|&seed| (seed, waves.compose(key.load, |load| kappa_at(load, seed))));
        let edge =
            datum.edge.keys().map(|&seed| (seed, waves.compose_difference(key.load, |load| edge_at(load, seed))));
        Some(Datum { edge: edge.collect(), ..Datum::new(datum.all_eps(), kappa.collect()) })
    }
}

impl Analysis {
    /// Returns kappa of a point with the long waves composed, as in the extrapolations that are `composed`, less what
    /// the grid adds, which is composed, too.
    pub fn composed(&self, point: usize, load: usize, plan: &Plan) -> Option<Datum> {
        let (hurst, p_star) = (plan.points[point].hurst, plan.config.loads.p_star[load]);
        let eps = self.data.get(&Key { point, load, area: Area::Raw })?.all_eps();
        let of = |e: &&Extrapolation| e.composed && e.hurst == hurst && e.p_star == p_star && e.area == Area::Raw;
        let datum = self.extrapolations.iter().find(of)?.data.iter().find(|datum| datum.all_eps() == eps)?;
        let less = |(seed, kappa): (&u64, &f64)| (*seed, kappa - datum.edge.get(seed).unwrap_or(&0.0));
        Some(Datum::new(datum.all_eps(), datum.kappa.iter().map(less).collect()))
    }
}
