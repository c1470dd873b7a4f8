//! The fit itself: checks, weights, the least sum of squares, and what is said of it.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::design::{levels, same_level};
use crate::projection::{Data, Minimum, Search, Shape, is_interior, log_node};
use crate::resample::Strata;
use crate::richardson;
use crate::uncertainty::{Errors, Quantity};
use crate::{Axis, Cell, CellReport, Exponent, Fit, FitError, Model, ProfilePoint, Settings, Term, Warning, Weighting};

/// Fits the model to the cells.
///
/// The same data and settings give the same bits for any number of threads.
pub fn fit(cells: &[Cell], settings: &Settings) -> Result<Fit, FitError> {
    check(cells, settings)?;
    let mut warnings = Vec::new();
    let (shapes, held) = shapes(cells, &settings.model, &mut warnings);
    let parameters = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
    if parameters > cells.len() {
        return Err(FitError::TooFewCells { parameters, cells: cells.len() });
    }
    let (data, noise_known) = weighted(cells, settings.weighting);
    let minimum = data.minimise(&shapes, Search::Thorough, None).map_err(|_| FitError::Dependent)?;
    let degrees_of_freedom = cells.len() - parameters;

    let strata = Strata::new(cells, settings.paired);
    let errors = Errors::new(&data, &shapes, &minimum, &strata, settings, degrees_of_freedom)?;
    let fit = Fit {
        kappa_tfc: errors.estimate(Quantity::Limit),
        terms: shapes
            .iter()
            .enumerate()
            .map(|(k, shape)| {
                let axis = Axis::ALL[shape.axis];
                Term {
                    axis,
                    levels: levels(cells, axis).len(),
                    coefficient: errors.estimate(Quantity::Coefficient(k)),
                    exponent: errors.estimate(Quantity::Exponent(k)),
                    free: shape.is_free(),
                    held: held.contains(&axis),
                    at_bound: shape.is_free() && !is_interior(shape, minimum.parameters.exponents[shape.axis]),
                    profile: profile(&data, &shapes, k, &minimum),
                }
            })
            .collect(),
        parameters: minimum.parameters,
        chi_squared: minimum.sum_of_squares,
        noise_known,
        degrees_of_freedom,
        cells: cell_reports(cells, &data, &shapes, &minimum),
        richardson: Axis::ALL.iter().flat_map(|&axis| richardson::triples(cells, axis)).collect(),
        uncertainty: errors.source,
        bootstrap: errors.bootstrap,
        warnings,
    };
    Ok(fit.with_warnings(cells, strata.single()))
}

fn check(cells: &[Cell], settings: &Settings) -> Result<(), FitError> {
    if cells.is_empty() {
        return Err(FitError::NoCells);
    }
    for (index, cell) in cells.iter().enumerate() {
        if cell.kappa.is_empty() {
            return Err(FitError::NoRealisations { cell: index });
        }
        if let Some((&seed, &found)) = cell.kappa.iter().find(|(_, kappa)| !kappa.is_finite()) {
            return Err(FitError::BadKappa { cell: index, seed, found });
        }
        for axis in Axis::ALL {
            let found = cell.eps(axis);
            if !(found > 0.0 && found.is_finite()) {
                return Err(FitError::BadEps { cell: index, axis, found });
            }
        }
        let same = |other: &Cell| Axis::ALL.iter().all(|&axis| same_level(other.eps(axis), cell.eps(axis)));
        if let Some(first) = cells[..index].iter().position(same) {
            return Err(FitError::SameCell { first, second: index });
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

/// The terms that the levels allow, and the axes whose free exponent they leave undetermined.
fn shapes(cells: &[Cell], model: &Model, warnings: &mut Vec<Warning>) -> (Vec<Shape>, Vec<Axis>) {
    let (mut shapes, mut held) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let levels = levels(cells, axis);
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

/// The data with their weights; the flag says whether the weights are inverse variances.
fn weighted(cells: &[Cell], weighting: Weighting) -> (Data, bool) {
    let freedom = |cell: &Cell| (cell.kappa.len() - 1) as f64;
    let total: f64 = cells.iter().map(freedom).sum();
    let squares: f64 = cells.iter().map(|cell| freedom(cell) * cell.variance().unwrap_or(0.0)).sum();
    let pooled = squares / total;
    let known = pooled > 0.0 && weighting != Weighting::Equal;
    let weight = |cell: &Cell| {
        let variance = match weighting {
            Weighting::Shrunk { prior } if freedom(cell) + prior > 0.0 => {
                (prior * pooled + freedom(cell) * cell.variance().unwrap_or(0.0)) / (prior + freedom(cell))
            }
            _ => pooled,
        };
        // A cell whose few realisations happen to agree must not outweigh all others.
        cell.kappa.len() as f64 / variance.max(1e-4 * pooled)
    };
    let data = Data {
        eps: cells.iter().map(Cell::all_eps).collect(),
        kappa: cells.iter().map(Cell::mean).collect(),
        root_weight: cells.iter().map(|cell| if known { weight(cell).sqrt() } else { 1.0 }).collect(),
    };
    (data, known)
}

/// chi^2 and kappa_TFC against the exponent of term `k`, everything else refitted.
fn profile(data: &Data, shapes: &[Shape], k: usize, minimum: &Minimum) -> Vec<ProfilePoint> {
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
            let at = data.minimise(&shapes, Search::Near, Some(&minimum.parameters)).ok()?;
            Some(ProfilePoint { exponent, chi_squared: at.sum_of_squares, kappa_tfc: at.parameters.kappa_tfc })
        })
        .collect()
}

fn cell_reports(cells: &[Cell], data: &Data, shapes: &[Shape], minimum: &Minimum) -> Vec<CellReport> {
    let without = |left_out: usize| {
        let mut rest = data.clone();
        rest.eps.remove(left_out);
        rest.kappa.remove(left_out);
        rest.root_weight.remove(left_out);
        let needed = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
        let refit =
            (needed <= rest.kappa.len()).then(|| rest.minimise(shapes, Search::Near, Some(&minimum.parameters)).ok());
        refit.flatten().map(|minimum| minimum.parameters.kappa_tfc)
    };
    (0..cells.len())
        .into_par_iter()
        .map(|i| CellReport {
            mean: data.kappa[i],
            standard_error: cells[i].variance().map(|variance| (variance / cells[i].kappa.len() as f64).sqrt()),
            weight: data.root_weight[i] * data.root_weight[i],
            fitted: minimum.parameters.predict(data.eps[i]),
            kappa_tfc_without: without(i),
        })
        .collect()
}
