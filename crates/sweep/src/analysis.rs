//! kappa of every point and load, and its extrapolation to the limit.

use std::collections::BTreeMap;

use gfmd_fit::{Datum, Exponent, Fit, Settings, fit};
use serde::Serialize;

use crate::{Plan, Pressed, SweepError};

/// The way in which contact area is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Area {
    /// The number of points in contact over the number of all points.
    Raw,
    /// The raw area less the excess of the pixels along the perimeter.
    Corrected,
}

impl Area {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Corrected => "corrected",
        }
    }

    fn kappa(self, load: &Pressed) -> f64 {
        match self {
            Self::Raw => load.summary.kappa,
            Self::Corrected => load.summary.kappa_corrected,
        }
    }
}

/// The place of a datum: index of the point, index of the load, way of counting area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Index of the point in [`Plan::points`].
    pub point: usize,
    /// Index of the load in the configuration.
    pub load: usize,
    /// Way of counting area.
    pub area: Area,
}

/// The extrapolation of one family of surfaces at one load.
#[derive(Clone, Debug)]
pub struct Extrapolation {
    /// Hurst exponent of the surfaces.
    pub hurst: f64,
    /// Reduced pressure.
    pub p_star: f64,
    /// Way of counting area.
    pub area: Area,
    /// The data, in the order of the fit.
    pub data: Vec<Datum>,
    /// The fit.
    pub fit: Fit,
}

/// The results that are derived from all runs.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// kappa by seed. There are data of the corrected area for surfaces only.
    pub data: BTreeMap<Key, Datum>,
    /// The extrapolations, one for each Hurst exponent, load and way of counting. The first one is the result: first Hurst
    /// exponent, load `fit.p_star` of the configuration, raw area.
    pub extrapolations: Vec<Extrapolation>,
}

impl Analysis {
    /// Groups the loads of all runs, as [`crate::run`] returns them, and fits every load of every family.
    ///
    /// # Errors
    /// A model that the points cannot determine.
    pub fn new(plan: &Plan, runs: &[Vec<Pressed>]) -> Result<Self, SweepError> {
        let config = &plan.config;
        // The correction counts the perimeter of patches; none is known for the ends of line contacts.
        let areas = if config.surface.dim == 2 { &[Area::Raw][..] } else { &[Area::Raw, Area::Corrected] };
        let loads = || config.loads.p_star.iter().copied().enumerate();
        let mut data = BTreeMap::new();
        for (point, at) in plan.points.iter().enumerate() {
            for (load, area) in loads().flat_map(|(load, _)| areas.iter().map(move |area| (load, *area))) {
                let kappa = |run: usize| (plan.runs[run].seed, area.kappa(&runs[run][load]));
                let eps = at.discretisation;
                let datum = Datum {
                    eps_t: 1.0 / eps.eps_t_inv,
                    eps_f: 1.0 / eps.eps_f_inv,
                    eps_c: 1.0 / eps.eps_c_inv,
                    kappa: plan.runs_of(point).map(kappa).collect(),
                };
                data.insert(Key { point, load, area }, datum);
            }
        }
        let mut extrapolations = Vec::new();
        for &hurst in &config.surface.hurst {
            for (load, p_star) in loads() {
                for &area in areas {
                    let of_family =
                        |key: &Key| key.load == load && key.area == area && plan.points[key.point].hurst == hurst;
                    let data: Vec<Datum> =
                        data.iter().filter(|(key, _)| of_family(key)).map(|(_, datum)| datum.clone()).collect();
                    let fit = fit(&data, &settings(plan, area)).map_err(SweepError::Fit)?;
                    extrapolations.push(Extrapolation { hurst, p_star, area, data, fit });
                }
            }
        }
        let is_result = |e: &Extrapolation| e.p_star == config.fit.p_star && e.area == Area::Raw;
        if let Some(position) = extrapolations.iter().position(is_result) {
            extrapolations[..=position].rotate_right(1);
        }
        Ok(Self { data, extrapolations })
    }

    /// The result of the sweep.
    pub fn result(&self) -> &Extrapolation {
        &self.extrapolations[0]
    }
}

fn settings(plan: &Plan, area: Area) -> Settings {
    let mut model = plan.config.model();
    // The part of the perimeter term that the correction leaves is too small to fit its exponent.
    if area == Area::Corrected && matches!(model.c, Some(Exponent::Free { .. })) {
        model.c = Some(Exponent::Fixed(1.0));
    }
    Settings { model, resamples: plan.config.fit.resamples, ..Settings::default() }
}
