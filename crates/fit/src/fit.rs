//! The fit: limit, terms and their intervals from data and settings.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::datum::{levels, same_level};
use crate::projection::{Means, Minimum, Search, Shape, is_interior, log_node};
use crate::resample::Strata;
use crate::richardson::triples;
use crate::uncertainty::{Errors, Quantity};
use crate::{
    Axis, Datum, DatumReport, Exponent, Fit, FitError, Model, ProfilePoint, Settings, Term, Warning, Weighting,
};

/// Fits the model to the data.
///
/// Equal data and settings give equal bits for any number of threads.
///
/// # Errors
/// Invalid data or settings; data that do not determine the model.
pub fn fit(data: &[Datum], settings: &Settings) -> Result<Fit, FitError> {
    check(data, settings)?;
    let mut warnings = Vec::new();
    let (shapes, held) = shapes(data, &settings.model, &mut warnings);
    let parameters = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
    if parameters > data.len() {
        return Err(FitError::TooFewData { parameters, data: data.len() });
    }
    let (means, noise_known) = weighted(data, settings.weighting);
    let minimum = means.minimise(&shapes, Search::Thorough, None).map_err(|_| FitError::Dependent)?;
    let degrees_of_freedom = data.len() - parameters;

    let strata = Strata::new(data, settings.paired);
    let errors = Errors::new(&means, &shapes, &minimum, &strata, settings, degrees_of_freedom)?;
    let fit = Fit {
        kappa_tfc: errors.estimate(Quantity::Limit),
        terms: shapes
            .iter()
            .enumerate()
            .map(|(k, shape)| {
                let axis = Axis::ALL[shape.axis];
                Term {
                    axis,
                    levels: levels(data, axis).len(),
                    coefficient: errors.estimate(Quantity::Coefficient(k)),
                    exponent: errors.estimate(Quantity::Exponent(k)),
                    free: shape.is_free(),
                    held: held.contains(&axis),
                    at_bound: shape.is_free() && !is_interior(shape, minimum.parameters.exponents[shape.axis]),
                    profile: profile(&means, &shapes, k, &minimum),
                }
            })
            .collect(),
        parameters: minimum.parameters,
        chi_squared: minimum.sum_of_squares,
        noise_known,
        degrees_of_freedom,
        data: datum_reports(data, &means, &shapes, &minimum),
        richardson: Axis::ALL.iter().flat_map(|&axis| triples(data, axis)).collect(),
        uncertainty: errors.source,
        bootstrap: errors.bootstrap,
        warnings,
    };
    Ok(fit.with_warnings(data, strata.single()))
}

fn check(data: &[Datum], settings: &Settings) -> Result<(), FitError> {
    if data.is_empty() {
        return Err(FitError::NoData);
    }
    for (index, datum) in data.iter().enumerate() {
        if datum.kappa.is_empty() {
            return Err(FitError::NoRealisations { datum: index });
        }
        if let Some((&seed, &found)) = datum.kappa.iter().find(|(_, kappa)| !kappa.is_finite()) {
            return Err(FitError::BadKappa { datum: index, seed, found });
        }
        for axis in Axis::ALL {
            let found = datum.eps(axis);
            if !(found > 0.0 && found.is_finite()) {
                return Err(FitError::BadEps { datum: index, axis, found });
            }
        }
        let same = |other: &Datum| Axis::ALL.iter().all(|&axis| same_level(other.eps(axis), datum.eps(axis)));
        if let Some(first) = data[..index].iter().position(same) {
            return Err(FitError::SameDatum { first, second: index });
        }
    }
    for axis in Axis::ALL {
        let (min, max) = match settings.model.of(axis) {
            None => continue,
            Some(Exponent::Fixed(alpha)) => (alpha, alpha),
            Some(Exponent::Free { min, max }) => (min, max),
        };
        if !(min > 0.0 && min <= max && max <= 16.0) {
            return Err(FitError::BadExponent { axis, min, max });
        }
    }
    match settings.weighting {
        Weighting::Shrunk { prior: found } if !(found >= 0.0 && found.is_finite()) => Err(FitError::BadPrior { found }),
        _ => Ok(()),
    }
}

/// The terms that the levels determine, and the axes whose levels do not determine the free exponent.
fn shapes(data: &[Datum], model: &Model, warnings: &mut Vec<Warning>) -> (Vec<Shape>, Vec<Axis>) {
    let (mut shapes, mut held) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let levels = levels(data, axis);
        let Some(exponent) = model.of(axis) else {
            if levels.len() > 1 {
                warnings.push(Warning::TermLeftOut { axis, levels: levels.len() });
            }
            continue;
        };
        let (min, max) = match (exponent, levels.len()) {
            (_, 0 | 1) => {
                warnings.push(Warning::SingleLevel { axis, eps: levels[0] });
                continue;
            }
            (Exponent::Fixed(alpha), _) => (alpha, alpha),
            (Exponent::Free { min, max }, 2) => {
                let alpha = 1.0_f64.clamp(min, max);
                warnings.push(Warning::ExponentHeld { axis, alpha });
                held.push(axis);
                (alpha, alpha)
            }
            (Exponent::Free { min, max }, _) => (min, max),
        };
        shapes.push(Shape { axis: axis as usize, min, max });
    }
    (shapes, held)
}

/// The data with their weights; the flag is true if the weights are inverse variances.
fn weighted(data: &[Datum], weighting: Weighting) -> (Means, bool) {
    let freedom = |datum: &Datum| (datum.kappa.len() - 1) as f64;
    let total: f64 = data.iter().map(freedom).sum();
    let squares: f64 = data.iter().map(|datum| freedom(datum) * datum.variance().unwrap_or(0.0)).sum();
    let pooled = squares / total;
    let known = pooled > 0.0 && weighting != Weighting::Equal;
    let weight = |datum: &Datum| {
        let variance = match weighting {
            Weighting::Shrunk { prior } if freedom(datum) + prior > 0.0 => {
                (prior * pooled + freedom(datum) * datum.variance().unwrap_or(0.0)) / (prior + freedom(datum))
            }
            _ => pooled,
        };
        // A datum whose few realisations agree by chance must not dominate the fit.
        datum.kappa.len() as f64 / variance.max(1e-4 * pooled)
    };
    let means = Means {
        eps: data.iter().map(Datum::all_eps).collect(),
        kappa: data.iter().map(Datum::mean).collect(),
        root_weight: data.iter().map(|datum| if known { weight(datum).sqrt() } else { 1.0 }).collect(),
    };
    (means, known)
}

/// chi^2 and kappa_TFC against the exponent of term `k`, with all other parameters refitted.
fn profile(means: &Means, shapes: &[Shape], k: usize, minimum: &Minimum) -> Vec<ProfilePoint> {
    const NODES: usize = 41;
    let (min, max) = if shapes[k].is_free() { (shapes[k].min, shapes[k].max) } else { (0.25, 4.0) };
    let mut exponents: Vec<f64> = (0..NODES).map(|i| log_node(min, max, i, NODES)).collect();
    exponents.push(minimum.parameters.exponents[shapes[k].axis]);
    exponents.sort_by(f64::total_cmp);
    exponents.dedup();
    exponents
        .into_par_iter()
        .filter_map(|exponent| {
            let mut shapes = shapes.to_vec();
            shapes[k] = Shape { min: exponent, max: exponent, ..shapes[k] };
            let at = means.minimise(&shapes, Search::Near, Some(&minimum.parameters)).ok()?;
            Some(ProfilePoint { exponent, chi_squared: at.sum_of_squares, kappa_tfc: at.parameters.kappa_tfc })
        })
        .collect()
}

fn datum_reports(data: &[Datum], means: &Means, shapes: &[Shape], minimum: &Minimum) -> Vec<DatumReport> {
    let without = |left_out: usize| {
        let mut rest = means.clone();
        rest.eps.remove(left_out);
        rest.kappa.remove(left_out);
        rest.root_weight.remove(left_out);
        let needed = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
        let refit =
            (needed <= rest.kappa.len()).then(|| rest.minimise(shapes, Search::Near, Some(&minimum.parameters)).ok());
        refit.flatten().map(|minimum| minimum.parameters.kappa_tfc)
    };
    (0..data.len())
        .into_par_iter()
        .map(|i| DatumReport {
            mean: means.kappa[i],
            standard_error: data[i].standard_error(),
            weight: means.root_weight[i] * means.root_weight[i],
            fitted: minimum.parameters.predict(means.eps[i]),
            kappa_tfc_without: without(i),
        })
        .collect()
}
