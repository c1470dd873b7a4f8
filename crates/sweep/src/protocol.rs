//! Extrapolation of one axis at a time: power laws about a reference cell (Prodanov, Dapp and Müser 2014; the source
//! thesis, section 5.1; theory.md, section 11.1).
//!
//! kappa along an axis is fitted by limit + C eps^alpha; the corrections C eps^alpha of all axes are subtracted from
//! kappa of the reference cell. Intervals come from a jackknife over the surfaces with Student's t, which accounts for
//! the common scatter of cells with common surfaces. They do not contain the misfit of the form: with three points and
//! a free exponent every curve fits.

use std::collections::BTreeMap;

use gfmd_fit::{Axis, Datum, Exponent, Model, Settings, Weighting, fit, student_975};

use crate::{Analysis, Area, Key, Plan, SweepError};

/// Number with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Value.
    pub value: f64,
    /// Interval of 95 %; `None` if there are too few surfaces, or if a fit without one of them fails.
    pub ci95: Option<[f64; 2]>,
}

/// Power law along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// kappa at eps = 0.
    pub limit: Estimated,
    /// Coefficient C.
    pub coefficient: Estimated,
    /// Exponent alpha.
    pub exponent: Estimated,
}

/// kappa along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Axis that varies.
    pub axis: Axis,
    /// Cell 1/eps (t, f, c); the entry of the axis itself has no meaning.
    pub cell: [f64; 3],
    /// 1/eps along the axis, ascending.
    pub inverse: Vec<f64>,
    /// kappa at these levels.
    pub kappa: Vec<Estimated>,
    /// Power law through all levels; `None` if there is none.
    pub curve: Option<Curve>,
    /// kappa of the finest level predicted from the others, if they determine a power law.
    pub predicted: Option<Estimated>,
}

/// Extrapolation about one reference cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Protocol {
    /// Hurst exponent.
    pub hurst: f64,
    /// Reduced pressure of the result; a slope belongs to all loads.
    pub p_star: f64,
    /// Reference cell 1/eps (t, f, c).
    pub reference: [f64; 3],
    /// kappa of the reference cell.
    pub kappa_sim: Estimated,
    /// kappa along the axes that have a term and several levels.
    pub arms: Vec<Arm>,
    /// kappa_sim less the corrections of all arms.
    pub kappa_tfc: Estimated,
}

/// kappa of cells by surface; entry k of every cell is the k-th realisation.
struct Cells<'a> {
    cells: Vec<([f64; 3], &'a Datum)>,
    model: Model,
    surfaces: usize,
}

/// Returns the protocols of a plan: one for each Hurst exponent, load and reference, with raw areas.
pub(crate) fn protocols(plan: &Plan, data: &BTreeMap<Key, Datum>) -> Result<Vec<Protocol>, SweepError> {
    let config = &plan.config;
    let mut all = Vec::new();
    for &hurst in config.surface.hurst.iter().filter(|_| !config.fit.references.is_empty()) {
        for load in config.fitted_loads() {
            let cells = Cells::new(plan, data, hurst, load);
            for &reference in &config.fit.references {
                let missing =
                    || crate::config::refusal("fit.references", &reference, "cells of the points of the sweep");
                let p_star = config.loads.p_star[load];
                all.push(cells.protocol(hurst, p_star, reference).ok_or_else(missing)?);
            }
        }
    }
    Ok(all)
}

impl Analysis {
    /// Returns kappa along all lines of three or more cells on an axis, at one load, raw area; for figures.
    pub fn arms(&self, plan: &Plan, hurst: f64, load: usize) -> Vec<Arm> {
        let cells = Cells::new(plan, &self.data, hurst, load);
        let mut arms: Vec<Arm> = Vec::new();
        for axis in Axis::ALL {
            for (cell, _) in &cells.cells {
                let is_known = |other: &Arm| other.axis == axis && on_line(other.cell, *cell, axis);
                if !arms.iter().any(is_known) && cells.line(axis, *cell).len() > 2 {
                    arms.push(cells.arm(axis, *cell));
                }
            }
        }
        arms
    }
}

/// Returns true if two cells differ along `axis` at most.
fn on_line(a: [f64; 3], b: [f64; 3], axis: Axis) -> bool {
    (0..3).all(|k| k == axis as usize || a[k] == b[k])
}

impl<'a> Cells<'a> {
    fn new(plan: &Plan, data: &'a BTreeMap<Key, Datum>, hurst: f64, load: usize) -> Self {
        let of = |key: &Key| {
            let at = plan.points[key.point].discretisation;
            [at.eps_t_inv, at.eps_f_inv, at.eps_c_inv]
        };
        let wanted = |key: &Key| key.load == load && key.area == Area::Raw && plan.points[key.point].hurst == hurst;
        let cells: Vec<_> = data.iter().filter(|(key, _)| wanted(key)).map(|(key, datum)| (of(key), datum)).collect();
        let surfaces = cells.iter().map(|(_, datum)| datum.kappa.len()).min().unwrap_or(0);
        Self { cells, model: plan.config.model(hurst), surfaces }
    }

    /// Returns the mean of a cell over its surfaces, without one of them.
    fn mean(&self, datum: &Datum, without: Option<usize>) -> f64 {
        let kept = datum.kappa.values().take(self.surfaces).enumerate().filter(|(k, _)| Some(*k) != without);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), (_, kappa)| (sum + kappa, count + 1.0));
        sum / count
    }

    /// Returns a number that follows from the means, with its jackknife interval.
    fn estimate(&self, number: impl Fn(Option<usize>) -> Option<f64>) -> Option<Estimated> {
        let value = number(None)?;
        let count = self.surfaces as f64;
        let without: Option<Vec<f64>> = (0..self.surfaces).map(|k| number(Some(k))).collect();
        let ci95 = without.filter(|all| all.len() > 1).map(|all| {
            let mean = all.iter().sum::<f64>() / count;
            let variance = (count - 1.0) / count * all.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>();
            let half = student_975(count - 1.0) * variance.sqrt();
            [value - half, value + half]
        });
        Some(Estimated { value, ci95 })
    }

    /// Returns the cells of the line through `cell` along `axis`, coarse first.
    fn line(&self, axis: Axis, cell: [f64; 3]) -> Vec<([f64; 3], &'a Datum)> {
        let mut line: Vec<_> = self.cells.iter().copied().filter(|(other, _)| on_line(*other, cell, axis)).collect();
        line.sort_by(|a, b| a.0[axis as usize].total_cmp(&b.0[axis as usize]));
        line
    }

    /// Returns limit, coefficient and exponent of the power law through cells; `None` if they do not determine it.
    fn law(&self, axis: Axis, line: &[([f64; 3], &Datum)], without: Option<usize>) -> Option<[f64; 3]> {
        let exponent = [self.model.t, self.model.f, self.model.c][axis as usize]?;
        let least = if matches!(exponent, Exponent::Free { .. }) { 3 } else { 2 };
        if line.len() < least {
            return None;
        }
        // Each mean is a datum of its own, since the jackknife treats the surfaces.
        let data: Vec<Datum> = (line.iter().enumerate())
            .map(|(k, (cell, datum))| {
                Datum::new(cell.map(f64::recip), BTreeMap::from([(k as u64, self.mean(datum, without))]))
            })
            .collect();
        let mut model = Model { t: None, f: None, c: None, crossed: false, edge: None };
        *[&mut model.t, &mut model.f, &mut model.c][axis as usize] = Some(exponent);
        let settings = Settings { model, resamples: 0, weighting: Weighting::Equal, ..Settings::default() };
        let fitted = fit(&data, &settings).ok()?;
        let term = fitted.term(axis)?;
        let alpha = term.exponent.value;
        // At a bound there is no power law through the points.
        let is_inside = match exponent {
            Exponent::Free { min, max } => alpha > min * 1.000_001 && alpha < max * 0.999_999,
            Exponent::Fixed(_) => true,
        };
        is_inside.then_some([fitted.kappa_tfc.value, term.coefficient.value, alpha])
    }

    fn arm(&self, axis: Axis, cell: [f64; 3]) -> Arm {
        let line = self.line(axis, cell);
        let part = |k: usize| self.estimate(|without| Some(self.law(axis, &line, without)?[k]));
        let curve = match [0, 1, 2].map(part) {
            [Some(limit), Some(coefficient), Some(exponent)] => Some(Curve { limit, coefficient, exponent }),
            _ => None,
        };
        let predicted = line.split_last().and_then(|((finest, _), coarse)| {
            self.estimate(|without| {
                let [limit, coefficient, exponent] = self.law(axis, coarse, without)?;
                Some(limit + coefficient * finest[axis as usize].powf(-exponent))
            })
        });
        let kappa = |(_, datum): &(_, &Datum)| self.estimate(|without| Some(self.mean(datum, without)));
        Arm {
            axis,
            cell,
            inverse: line.iter().map(|(cell, _)| cell[axis as usize]).collect(),
            kappa: line.iter().filter_map(kappa).collect(),
            curve,
            predicted,
        }
    }

    /// Returns the protocol about `reference`; `None` if the sweep does not have this cell.
    fn protocol(&self, hurst: f64, p_star: f64, reference: [f64; 3]) -> Option<Protocol> {
        let (_, datum) = self.cells.iter().find(|(cell, _)| *cell == reference)?;
        let kappa_sim = self.estimate(|without| Some(self.mean(datum, without)))?;
        let arms: Vec<Arm> = (Axis::ALL.into_iter())
            .filter(|axis| [self.model.t, self.model.f, self.model.c][*axis as usize].is_some())
            .map(|axis| self.arm(axis, reference))
            .filter(|arm| arm.inverse.len() > 1)
            .collect();
        let lines: Vec<_> = arms.iter().map(|arm| (arm.axis, self.line(arm.axis, reference))).collect();
        let kappa_tfc = self.estimate(|without| {
            lines.iter().try_fold(self.mean(datum, without), |kappa, (axis, line)| {
                let [_, coefficient, exponent] = self.law(*axis, line, without)?;
                Some(kappa - coefficient * reference[*axis as usize].powf(-exponent))
            })
        });
        let kappa_tfc = kappa_tfc.unwrap_or(Estimated { value: f64::NAN, ci95: None });
        Some(Protocol { hurst, p_star, reference, kappa_sim, arms, kappa_tfc })
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    const FREE: Model = Model { t: None, f: Some(Exponent::FREE), c: Some(Exponent::FREE), crossed: false, edge: None };

    /// Returns data of a star about (2, 256, 4) and (2, 256, 8), with `kappa` at eps for each surface.
    fn data(surfaces: u64, kappa: impl Fn([f64; 3], u64) -> f64) -> Vec<([f64; 3], Datum)> {
        let mut cells = vec![];
        for f in [128.0, 256.0, 512.0] {
            cells.extend([2.0, 4.0, 8.0, 16.0].map(|c| [2.0, f, c]));
        }
        let datum = |cell: [f64; 3]| {
            let eps = cell.map(f64::recip);
            Datum::new(eps, (0..surfaces).map(|k| (k + 1, kappa(eps, k))).collect())
        };
        cells.into_iter().map(|cell| (cell, datum(cell))).collect()
    }

    fn cells(data: &[([f64; 3], Datum)], model: Model) -> Cells<'_> {
        let surfaces = data[0].1.kappa.len();
        Cells { cells: data.iter().map(|(cell, datum)| (*cell, datum)).collect(), model, surfaces }
    }

    #[test]
    fn the_power_laws_of_the_source_are_recovered_from_its_cells() {
        let law =
            |eps: [f64; 3], k: u64| 2.0 + 10.24 * eps[1] + 2.640_09 * eps[2].powf(0.991_761) + 0.01 * (k as f64 - 1.0);
        let data = data(3, law);
        for reference in [[2.0, 256.0, 4.0], [2.0, 256.0, 8.0]] {
            let protocol = cells(&data, FREE).protocol(0.0, 0.01, reference).unwrap();
            let [f, c] = &protocol.arms[..] else { panic!("two arms") };
            let [f, c] = [f, c].map(|arm| arm.curve.unwrap());
            assert_relative_eq!(f.coefficient.value, 10.24, max_relative = 1e-4);
            assert_relative_eq!(f.exponent.value, 1.0, max_relative = 1e-4);
            assert_relative_eq!(c.coefficient.value, 2.640_09, max_relative = 1e-4);
            assert_relative_eq!(c.exponent.value, 0.991_761, max_relative = 1e-4);
            assert_relative_eq!(protocol.kappa_tfc.value, 2.0, max_relative = 1e-4);
            // The surfaces differ by a constant, which is all scatter of kappa_TFC and no scatter of C.
            let half = |e: Estimated| e.ci95.map(|[low, high]| 0.5 * (high - low)).unwrap();
            let expected = student_975(2.0) * 0.01 / 3.0_f64.sqrt();
            assert_relative_eq!(half(protocol.kappa_sim), expected, max_relative = 1e-9);
            assert_relative_eq!(half(protocol.kappa_tfc), expected, max_relative = 1e-3);
            assert!(half(c.coefficient) < 1e-4);
            // 1/eps_c = 16 is predicted by 2, 4 and 8.
            let predicted = protocol.arms[1].predicted.unwrap().value;
            assert_relative_eq!(predicted, protocol.arms[1].kappa[3].value, max_relative = 1e-6);
        }
    }

    #[test]
    fn without_a_power_law_there_is_no_number() {
        // Differences grow: no exponent above zero.
        let data = data(2, |eps, _| 2.0 - eps[2].ln().abs().powi(3));
        let protocol = cells(&data, FREE).protocol(0.0, 0.01, [2.0, 256.0, 4.0]).unwrap();
        assert!(protocol.arms.iter().any(|arm| arm.curve.is_none()));
        assert!(protocol.kappa_tfc.value.is_nan() && protocol.kappa_tfc.ci95.is_none());
        assert!(cells(&data, FREE).protocol(0.0, 0.01, [1.0, 256.0, 4.0]).is_none(), "no such cell");
    }

    #[test]
    fn an_exponent_that_is_held_needs_two_levels_and_one_surface_has_no_interval() {
        let data = data(1, |eps, _| 1.5 + 3.0 * eps[2]);
        let model = Model { t: None, f: None, c: Some(Exponent::Fixed(1.0)), crossed: false, edge: None };
        let protocol = cells(&data, model).protocol(0.0, 0.01, [2.0, 512.0, 4.0]).unwrap();
        assert_eq!(protocol.arms.len(), 1);
        assert_relative_eq!(protocol.kappa_tfc.value, 1.5, max_relative = 1e-10);
        assert!(protocol.kappa_tfc.ci95.is_none());
    }
}
