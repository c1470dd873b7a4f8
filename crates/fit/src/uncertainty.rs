//! Intervals from resampled rows, from linear propagation, or from the misfit, as the data permit.

use rayon::prelude::*;

use crate::projection::{Means, Minimum, Nodes, Search, Shape, is_interior};
use crate::rows::{Rows, Spread};
use crate::student::{NORMAL_975, quantile, student_975};
use crate::{Axis, BootstrapReport, Estimate, FitError, Parameters, Settings, Uncertainty};

/// Fitted quantity; terms are numbered in the order of the shapes.
#[derive(Clone, Copy)]
pub(crate) enum Quantity {
    Limit,
    Coefficient(usize),
    Exponent(usize),
    /// Factor f (0) or f' (1) of the measured edge.
    Edge(usize),
}

/// Source of the uncertainties, with the data needed to evaluate them for each quantity.
pub(crate) struct Errors<'a> {
    rows: &'a Rows,
    shapes: &'a [Shape],
    minimum: &'a Minimum,
    sensitivities: Vec<Vec<f64>>,
    degrees_of_freedom: usize,
    /// Factor on standard errors, √(χ²/degrees of freedom) if chi^2 exceeds the scatter; at least one.
    inflation: f64,
    pub(crate) source: Uncertainty,
    pub(crate) bootstrap: Option<BootstrapReport>,
}

impl<'a> Errors<'a> {
    pub(crate) fn new(
        rows: &'a Rows,
        shapes: &'a [Shape],
        minimum: &'a Minimum,
        settings: &Settings,
        degrees_of_freedom: usize,
    ) -> Result<Self, FitError> {
        let means = &rows.means;
        // If parameters depend on each other at the minimum, no estimate has an error.
        let sensitivities = means.sensitivities(shapes, &minimum.parameters).unwrap_or_default();
        let nodes = Nodes::new(means, shapes, Search::Near).map_err(|_| FitError::Dependent)?;
        let bootstrap = (rows.have_scatter() && settings.resamples > 0).then(|| {
            let refits: Vec<Option<Parameters>> = (0..settings.resamples as u64)
                .into_par_iter()
                .map(|index| {
                    let resampled = Means { kappa: rows.draw(settings.seed, index), ..means.clone() };
                    Some(nodes.minimise(&resampled, Some(&minimum.parameters)).ok()?.parameters)
                })
                .collect();
            let samples: Vec<Parameters> = refits.iter().flatten().copied().collect();
            let at_bound = shapes.iter().filter(|shape| shape.is_free()).map(|shape| {
                let stuck = samples.iter().filter(|p| !is_interior(shape, p.exponents[shape.axis])).count();
                (Axis::ALL[shape.axis], stuck)
            });
            BootstrapReport {
                resamples: settings.resamples,
                failed: refits.len() - samples.len(),
                at_bound: at_bound.collect(),
                seed: settings.seed,
                stretch: 1.0,
                samples,
            }
        });
        let source = match &bootstrap {
            Some(report) if report.samples.len() >= 2 => Uncertainty::Realisations,
            _ if rows.have_scatter() => Uncertainty::Propagated,
            _ if degrees_of_freedom > 0 => Uncertainty::Misfit,
            _ => Uncertainty::None,
        };
        let inflation = match (rows.noise_known, degrees_of_freedom) {
            (true, 1..) => (minimum.sum_of_squares / degrees_of_freedom as f64).sqrt().max(1.0),
            _ => 1.0,
        };
        let mut errors =
            Self { rows, shapes, minimum, sensitivities, degrees_of_freedom, inflation, source, bootstrap };
        if let (Some(row), Some(report)) = (errors.sensitivities.first(), &mut errors.bootstrap) {
            report.stretch = rows.spread(row).map_or(1.0, |spread| spread.stretch);
        }
        Ok(errors)
    }

    pub(crate) fn estimate(&self, quantity: Quantity) -> Estimate {
        let value = self.value(&self.minimum.parameters, quantity);
        let given = matches!(quantity, Quantity::Exponent(k) if !self.shapes[k].is_free());
        let Some(row) = self.sensitivity(quantity).filter(|_| !given) else {
            return Estimate { value, standard_error: None, ci95: None };
        };
        let spread = self
            .rows
            .spread(row)
            .map(|spread| Spread { standard_error: spread.standard_error * self.inflation, stretch: spread.stretch });
        let (standard_error, ci95) = match (self.source, spread) {
            (Uncertainty::Realisations, Some(spread)) => {
                (Some(spread.standard_error), self.percentiles(quantity, value, self.inflation * spread.stretch))
            }
            (Uncertainty::Propagated, Some(spread)) => {
                let half = NORMAL_975 * spread.stretch * spread.standard_error;
                (Some(spread.standard_error), Some([value - half, value + half]))
            }
            (Uncertainty::Misfit, _) => {
                let freedom = self.degrees_of_freedom as f64;
                let unit = self.minimum.sum_of_squares / freedom;
                let variance: f64 =
                    row.iter().zip(&self.rows.means.root_weight).map(|(a, w)| (a / w).powi(2) * unit).sum();
                let half = student_975(freedom) * variance.sqrt();
                (Some(variance.sqrt()), Some([value - half, value + half]))
            }
            _ => (None, None),
        };
        Estimate { value, standard_error, ci95 }
    }

    /// Returns the standard error of the limit due to the edge factors: the root of the difference of the squared
    /// standard errors with fitted and with fixed factors.
    pub(crate) fn share_of_edge(&self) -> Option<f64> {
        let held = self.rows.means.without_edges().sensitivities(self.shapes, &self.minimum.parameters).ok()?;
        let without = self.inflation * self.rows.spread(held.first()?)?.standard_error;
        let whole = self.estimate(Quantity::Limit).standard_error?;
        Some((whole * whole - without * without).max(0.0).sqrt())
    }

    /// Returns the stretched percentile interval.
    fn percentiles(&self, quantity: Quantity, value: f64, stretch: f64) -> Option<[f64; 2]> {
        let samples = &self.bootstrap.as_ref()?.samples;
        let mut values: Vec<f64> = samples.iter().map(|p| self.value(p, quantity)).collect();
        values.sort_by(f64::total_cmp);
        let ends = [0.025, 0.975].map(|level| value + stretch * (quantile(&values, level) - value));
        Some(match quantity {
            Quantity::Exponent(k) => ends.map(|end| end.clamp(self.shapes[k].min, self.shapes[k].max)),
            _ => ends,
        })
    }

    fn value(&self, parameters: &Parameters, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Limit => parameters.kappa_tfc,
            Quantity::Coefficient(k) => parameters.coefficients[self.shapes[k].axis],
            Quantity::Exponent(k) => parameters.exponents[self.shapes[k].axis],
            Quantity::Edge(k) => parameters.edge[k],
        }
    }

    /// Returns the row d(quantity)/d(kappa of each row of the fit); `None` for an exponent that is fixed or at a bound.
    fn sensitivity(&self, quantity: Quantity) -> Option<&Vec<f64>> {
        let row = match quantity {
            Quantity::Limit => 0,
            Quantity::Coefficient(k) => 1 + k,
            Quantity::Edge(k) => 1 + self.shapes.len() + k,
            Quantity::Exponent(k) => {
                let interior = |shape: &&Shape| is_interior(shape, self.minimum.parameters.exponents[shape.axis]);
                if !interior(&&self.shapes[k]) {
                    return None;
                }
                1 + self.shapes.len() + self.rows.means.edges.len() + self.shapes[..k].iter().filter(interior).count()
            }
        };
        self.sensitivities.get(row)
    }
}
