//! Fit of the limit, the terms and their intervals from data and settings.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::datum::{levels, same_level};
use crate::projection::{Means, Minimum, Search, Shape, is_interior, log_node};
use crate::richardson::triples;
use crate::rows::Rows;
use crate::uncertainty::{Errors, Quantity};
use crate::{
    Axis, Datum, DatumReport, Edge, EdgeTerm, Exponent, Fit, FitError, Model, ProfilePoint, Settings, Term, Warning,
    Weighting,
};

/// Number of fits after which the factor of the measured edge, which affects the scatter, no longer changes.
const EDGE_FITS: usize = 4;

/// Fits the model to the data.
///
/// Equal data and settings give bitwise identical results for any number of threads.
///
/// # Errors
/// Invalid data or settings; data that do not determine the model.
pub fn fit(data: &[Datum], settings: &Settings) -> Result<Fit, FitError> {
    check(data, settings)?;
    let mut warnings = Vec::new();
    let (shapes, held) = shapes(data, &settings.model, &mut warnings);
    let edge = edge_column(data, &settings.model, &mut warnings);
    let parameters = parameters(&shapes, edge);
    if parameters > data.len() {
        return Err(FitError::TooFewData { parameters, data: data.len() });
    }
    let (rows, minimum) = minimise(data, settings, &shapes, edge)?;
    let means = &rows.means;
    let degrees_of_freedom = data.len() - parameters;
    let errors = Errors::new(&rows, &shapes, &minimum, settings, degrees_of_freedom)?;
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
                    profile: profile(means, &shapes, k, &minimum),
                }
            })
            .collect(),
        edge: edge.map(|_| {
            let coarse = (means.edges.len() > 1).then(|| errors.estimate(Quantity::Edge(1)));
            EdgeTerm { factor: errors.estimate(Quantity::Edge(0)), coarse, share: errors.share_of_edge() }
        }),
        parameters: minimum.parameters,
        chi_squared: minimum.sum_of_squares,
        noise_known: rows.noise_known,
        degrees_of_freedom,
        data: datum_reports(data, settings, &rows, &shapes, &minimum),
        richardson: Axis::ALL.iter().flat_map(|&axis| triples(data, axis)).collect(),
        uncertainty: errors.source,
        bootstrap: errors.bootstrap,
        warnings,
    };
    Ok(fit.with_warnings(data, rows.single))
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
    if let Some(Edge { factor, standard_error, coarse }) = settings.model.edge {
        if !(factor.is_finite() && standard_error > 0.0 && coarse >= 0.0 && coarse.is_finite()) {
            return Err(FitError::BadEdge { factor, standard_error, coarse });
        }
        if settings.model.c.is_some() {
            return Err(FitError::TwoContinuumTerms);
        }
        if let Some(datum) = data.iter().position(|datum| !datum.edge.keys().eq(datum.kappa.keys())) {
            return Err(FitError::NoEdge { datum });
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

/// Returns the terms that the levels determine, and the axes with too few levels for the free exponent.
fn shapes(data: &[Datum], model: &Model, warnings: &mut Vec<Warning>) -> (Vec<Shape>, Vec<Axis>) {
    let (mut shapes, mut held) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let levels = levels(data, axis);
        let Some(exponent) = model.of(axis) else {
            if levels.len() > 1 && !(axis == Axis::Continuum && model.edge.is_some()) {
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
        shapes.push(Shape { axis: axis as usize, min, max, times: None });
    }
    let fractal = shapes.iter().position(|shape| shape.axis == Axis::Fractal as usize);
    for shape in shapes.iter_mut().filter(|shape| model.crossed && shape.axis == Axis::Thermodynamic as usize) {
        shape.times = fractal;
    }
    (shapes, held)
}

/// Returns the number of parameters that the data must determine, except an edge factor with an expected value.
fn parameters(shapes: &[Shape], edge: Option<Edge>) -> usize {
    let free = shapes.iter().filter(|shape| shape.is_free()).count();
    1 + shapes.len() + free + usize::from(edge.is_some_and(|edge| !edge.is_known()))
}

/// Returns the measured edge if the levels of eps_c determine its factor or it is expected.
fn edge_column(data: &[Datum], model: &Model, warnings: &mut Vec<Warning>) -> Option<Edge> {
    let levels = levels(data, Axis::Continuum);
    let edge = model.edge?;
    if levels.len() == 1 && !edge.is_known() {
        warnings.push(Warning::SingleLevel { axis: Axis::Continuum, eps: levels[0] });
        return None;
    }
    Some(edge)
}

/// Returns the rows and the least sum of squares.
fn minimise(
    data: &[Datum],
    settings: &Settings,
    shapes: &[Shape],
    edge: Option<Edge>,
) -> Result<(Rows, Minimum), FitError> {
    let fit = |factors: [f64; 2], guess: Option<&Minimum>| -> Result<(Rows, Minimum), FitError> {
        let rows = Rows::new(data, settings, edge, factors);
        let search = if guess.is_some() { Search::Near } else { Search::Thorough };
        let minimum = rows.means.minimise(shapes, search, guess.map(|minimum| &minimum.parameters));
        Ok((rows, minimum.map_err(|_| FitError::Dependent)?))
    };
    let mut found = fit([edge.map_or(0.0, |edge| edge.factor), 0.0], None)?;
    for _ in 1..(if edge.is_some() { EDGE_FITS } else { 1 }) {
        found = fit(found.1.parameters.edge, Some(&found.1))?;
    }
    Ok(found)
}

/// Computes chi^2 and kappa_TFC against the exponent of term `k`, with all other parameters refitted.
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

fn datum_reports(
    data: &[Datum],
    settings: &Settings,
    rows: &Rows,
    shapes: &[Shape],
    minimum: &Minimum,
) -> Vec<DatumReport> {
    let edge = settings.model.edge.filter(|_| !rows.means.edges.is_empty());
    let without = |left_out: usize| {
        let rest: Vec<Datum> =
            data.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, datum)| datum.clone()).collect();
        if parameters(shapes, edge) > rest.len() {
            return None;
        }
        let means = Rows::new(&rest, settings, edge, minimum.parameters.edge).means;
        Some(means.minimise(shapes, Search::Near, Some(&minimum.parameters)).ok()?.parameters.kappa_tfc)
    };
    (0..data.len())
        .into_par_iter()
        .map(|i| DatumReport {
            mean: data[i].mean(),
            standard_error: data[i].standard_error(),
            weight: rows.means.root_weight[i] * rows.means.root_weight[i],
            fitted: minimum.parameters.predict(data[i].all_eps())
                + minimum.parameters.excess(data[i].eps_c, data[i].mean_edge()),
            kappa_tfc_without: without(i),
        })
        .collect()
}
