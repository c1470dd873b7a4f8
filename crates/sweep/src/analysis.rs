//! kappa of every point and load, and its extrapolation to the limit.

use std::collections::BTreeMap;

use gfmd_fit::{Axis, Datum, Exponent, Fit, Model, Settings, Warning, fit};
use serde::Serialize;

use crate::composition::Composition;
use crate::{Alpha, Config, Plan, Pressed, Protocol, SweepError};

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

    pub(crate) fn kappa(self, load: &Pressed) -> f64 {
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
    /// True if the data are kappa of surfaces without end: the waves that the surfaces lack are composed with their
    /// contacts. False: kappa as computed, which falls with a power of eps_f.
    pub composed: bool,
    /// The data, in the order of the fit.
    pub data: Vec<Datum>,
    /// The fit.
    pub fit: Fit,
    /// Fits of other forms to the same contacts. Their distance from `fit` is the systematic error of its form.
    pub alternatives: Vec<Alternative>,
}

/// kappa_TFC of another form of the extrapolation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alternative {
    /// The form.
    pub form: Form,
    /// kappa in the thermodynamic, fractal and continuum limit.
    pub kappa_tfc: f64,
}

/// A form of the extrapolation other than that of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// alpha_f fitted, between 1 - H and 2 - 2H with `"self-affine"`, else between its value in the configuration and twice
    /// this value.
    AlphaFFree,
    /// The long waves composed and alpha_f = 1 - H.
    LeadingAlphaF,
    /// Without the largest eps_f.
    WithoutCoarsestEpsF,
    /// Without the largest eps_t.
    WithoutCoarsestEpsT,
    /// The perimeter-corrected area with a term C_c eps_c.
    CorrectedArea,
}

impl Form {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::AlphaFFree => "alpha-f-free",
            Self::LeadingAlphaF => "leading-alpha-f",
            Self::WithoutCoarsestEpsF => "without-coarsest-eps-f",
            Self::WithoutCoarsestEpsT => "without-coarsest-eps-t",
            Self::CorrectedArea => "corrected-area",
        }
    }

    /// The form in words.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::AlphaFFree => "alpha_f fitted",
            Self::LeadingAlphaF => "alpha_f = 1 - H",
            Self::WithoutCoarsestEpsF => "without the largest eps_f",
            Self::WithoutCoarsestEpsT => "without the largest eps_t",
            Self::CorrectedArea => "corrected area, C_c eps_c",
        }
    }
}

impl Extrapolation {
    /// The systematic error of the form: the largest distance of an alternative from the fit.
    pub fn systematic(&self) -> f64 {
        let distances = self.alternatives.iter().map(|other| (other.kappa_tfc - self.fit.kappa_tfc.value).abs());
        distances.fold(0.0, f64::max)
    }

    /// The interval of statistical (95 %) and systematic error together, added in quadrature on each side.
    pub fn total_ci95(&self) -> Option<[f64; 2]> {
        let value = self.fit.kappa_tfc.value;
        let systematic = self.systematic();
        self.fit
            .kappa_tfc
            .ci95
            .map(|[low, high]| [value - (value - low).hypot(systematic), value + (high - value).hypot(systematic)])
    }
}

/// The results that are derived from all runs.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// kappa by seed. There are data of the corrected area for surfaces only.
    pub data: BTreeMap<Key, Datum>,
    /// The extrapolations, one for each Hurst exponent, load and way of counting. The first one is the result: first Hurst
    /// exponent, load `fit.p_star` of the configuration, raw area.
    pub extrapolations: Vec<Extrapolation>,
    /// Extrapolations of one axis at a time about the reference cells, if the configuration has any.
    pub protocols: Vec<Protocol>,
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
        let loads = || config.fitted_loads().into_iter().map(|load| (load, config.loads.p_star[load]));
        let mut data = BTreeMap::new();
        for (point, at) in plan.points.iter().enumerate() {
            for (load, area) in loads().flat_map(|(load, _)| areas.iter().map(move |area| (load, *area))) {
                let at = at.discretisation;
                let eps = [at.eps_t_inv, at.eps_f_inv, at.eps_c_inv].map(f64::recip);
                let of_runs = |value: &dyn Fn(&[Pressed]) -> f64| {
                    plan.runs_of(point).map(|run| (plan.runs[run].seed, value(&runs[run]))).collect()
                };
                let kappa = |area: Area, loads: &[Pressed]| config.fit.estimator.kappa(loads, load, area);
                let edge = match areas.len() {
                    1 => BTreeMap::new(),
                    _ => of_runs(&|loads| kappa(Area::Raw, loads) - kappa(Area::Corrected, loads)),
                };
                let datum = Datum { edge, ..Datum::new(eps, of_runs(&|loads| kappa(area, loads))) };
                data.insert(Key { point, load, area }, datum);
            }
        }
        let composition = Composition::new(plan, &data)?;
        let mut extrapolations = Vec::new();
        for &hurst in &config.surface.hurst {
            let composed = config.composes(hurst);
            for (load, p_star) in loads() {
                let of = |area: Area| -> Vec<Datum> {
                    let wanted =
                        |key: &Key| key.load == load && key.area == area && plan.points[key.point].hurst == hurst;
                    let wanted = data.iter().filter(|(key, _)| wanted(key));
                    match composed {
                        true => wanted.filter_map(|(key, _)| composition.compose(&data, key)).collect(),
                        false => wanted.map(|(_, datum)| datum.clone()).collect(),
                    }
                };
                let fits: Vec<(Area, Vec<Datum>, Fit)> = areas
                    .iter()
                    .map(|&area| {
                        let data = of(area);
                        let mut fit = fit(&data, &settings(config, hurst, area)).map_err(SweepError::Fit)?;
                        if !composed && config.surface.dim == 3 && fit.term(Axis::Fractal).is_some() {
                            fit.warnings.push(Warning::PowerOfEpsF);
                        }
                        Ok((area, data, fit))
                    })
                    .collect::<Result<_, SweepError>>()?;
                let corrected = fits.iter().find(|(area, ..)| *area == Area::Corrected);
                let corrected = corrected.map(|(_, _, fit)| fit.kappa_tfc.value);
                for (area, data, fit) in fits {
                    let mut alternatives = alternatives(&data, &settings(config, hurst, area), range(config, hurst));
                    if let (Area::Raw, Some(kappa_tfc)) = (area, corrected) {
                        alternatives.push(Alternative { form: Form::CorrectedArea, kappa_tfc });
                    }
                    extrapolations.push(Extrapolation { hurst, p_star, area, composed, data, fit, alternatives });
                }
            }
        }
        let is_result = |e: &Extrapolation| e.p_star == config.fit.p_star && e.area == Area::Raw;
        if let Some(position) = extrapolations.iter().position(is_result) {
            extrapolations[..=position].rotate_right(1);
        }
        let protocols = crate::protocol::protocols(plan, &data)?;
        Ok(Self { data, extrapolations, protocols })
    }

    /// The result of the sweep.
    pub fn result(&self) -> &Extrapolation {
        &self.extrapolations[0]
    }
}

/// The settings of the fit of one family of surfaces.
pub(crate) fn settings(config: &Config, hurst: f64, area: Area) -> Settings {
    let mut model = config.model(hurst);
    // The part of the perimeter term that the correction leaves is too small to fit its exponent.
    if area == Area::Corrected && (model.edge || matches!(model.c, Some(Exponent::Free { .. }))) {
        (model.c, model.edge) = (Some(Exponent::Fixed(1.0)), false);
    }
    Settings { model, resamples: config.fit.resamples, ..Settings::default() }
}

/// The exponents between which that of composed data lies, 1 - H and 2 - 2H; `None` if the configuration gives another one.
fn range(config: &Config, hurst: f64) -> Option<[f64; 2]> {
    let own = config.composes(hurst) && config.fit.alpha_f == Alpha::SelfAffine;
    own.then_some([1.0 - hurst, 2.0 - 2.0 * hurst])
}

/// Fits of the forms that the data determine.
fn alternatives(data: &[Datum], settings: &Settings, range: Option<[f64; 2]>) -> Vec<Alternative> {
    let without = |axis: Axis| -> Vec<Datum> {
        let coarsest = data.iter().map(|datum| datum.eps(axis)).fold(0.0, f64::max);
        data.iter().filter(|datum| datum.eps(axis) < coarsest).cloned().collect()
    };
    let varies = |data: &[Datum], axis: Axis| data.iter().any(|datum| datum.eps(axis) != data[0].eps(axis));
    let mut forms: Vec<(Form, Vec<Datum>, Model)> = Vec::new();
    if let Some(Exponent::Fixed(alpha)) = settings.model.f {
        let [min, max] = range.unwrap_or([alpha, 2.0 * alpha]);
        let model = |f: Exponent| Model { f: Some(f), ..settings.model };
        forms.push((Form::AlphaFFree, data.to_vec(), model(Exponent::Free { min, max })));
        if let Some([leading, _]) = range.filter(|[leading, _]| *leading < alpha) {
            forms.push((Form::LeadingAlphaF, data.to_vec(), model(Exponent::Fixed(leading))));
        }
    }
    for (form, axis) in [(Form::WithoutCoarsestEpsF, Axis::Fractal), (Form::WithoutCoarsestEpsT, Axis::Thermodynamic)] {
        let rest = without(axis);
        // A fit whose other terms are lost with the level is another quantity.
        let keeps = |other: Axis| other == axis || varies(&rest, other) || !varies(data, other);
        if varies(data, axis) && Axis::ALL.into_iter().all(keeps) {
            forms.push((form, rest, settings.model));
        }
    }
    let fitted = forms.into_iter().filter_map(|(form, data, model)| {
        let fit = fit(&data, &Settings { model, resamples: 0, ..*settings }).ok()?;
        Some(Alternative { form, kappa_tfc: fit.kappa_tfc.value })
    });
    fitted.collect()
}
