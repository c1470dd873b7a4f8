//! Deviations of the estimates from solved contacts, as measured (`cargo xtask deviations`).

use std::collections::BTreeMap;
use std::sync::LazyLock;

use gfmd_measure::theory::EquivalentBand;
use serde::{Deserialize, Serialize};

/// Measured deviations of the estimates.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Deviations {
    /// Reduced pressures of the contacts, ascending.
    pub p_star: Vec<f64>,
    /// By the name of a number, the relative deviation that 95 % of the contacts at each reduced pressure do not
    /// exceed.
    pub error: BTreeMap<String, Vec<f64>>,
    /// Number of contacts at each reduced pressure.
    pub contacts: usize,
    /// Least and largest Hurst exponent of the equivalent bands.
    pub hurst: [f64; 2],
    /// Least and largest ratio of the wavelengths of the equivalent bands.
    pub eps_f_inv: [f64; 2],
    /// Least and largest skewness Ssk of the heights, of either sign.
    pub ssk: [f64; 2],
    /// Least and largest kurtosis Sku of the heights.
    pub sku: [f64; 2],
    /// Least and largest anisotropy of the mean square slopes.
    pub anisotropy: [f64; 2],
    /// Area fraction at which contacts percolate, and the deviation that 95 % of the surfaces do not exceed.
    pub percolation: [f64; 2],
}

static MEASURED: LazyLock<Option<Deviations>> =
    LazyLock::new(|| serde_json::from_str(include_str!("../../../../data/results/estimate.json")).ok());

/// Relative margin of a range, for rounding.
const ROUNDING: f64 = 1e-9;

impl Deviations {
    /// Returns the measured deviations.
    pub fn measured() -> Option<&'static Self> {
        MEASURED.as_ref()
    }

    /// Returns the reason why there is no estimate for surfaces with this band, skewness, kurtosis and anisotropy;
    /// `None` if there is one.
    pub fn beyond(&self, band: EquivalentBand, [ssk, sku, anisotropy]: [f64; 3]) -> Option<String> {
        let outside = |name: &str, value: f64, [least, most]: [f64; 2]| {
            let is_known = value >= least - ROUNDING * least.abs() && value <= most + ROUNDING * most.abs();
            (!is_known).then(|| format!("{name} {value:.2}, and the errors are known from {least:.2} to {most:.2}"))
        };
        outside("the spectrum has the Hurst exponent", band.hurst, self.hurst)
            .or_else(|| outside("the spectrum has the ratio of wavelengths", band.eps_f_inv, self.eps_f_inv))
            .or_else(|| outside("the heights have the skewness", ssk, self.ssk))
            .or_else(|| outside("the heights have the kurtosis", sku, self.sku))
            .or_else(|| outside("the slopes have the anisotropy", anisotropy, [0.0, self.anisotropy[1]]))
    }

    /// Returns the relative error of a number at a reduced pressure, the larger one of the neighbouring loads.
    ///
    /// # Errors
    /// Returns the reason if the load is lighter or heavier than all measured ones.
    pub fn error(&self, name: &str, p_star: f64) -> Result<f64, String> {
        let loads = &self.p_star;
        let beyond = || {
            let [least, most] = [loads.first(), loads.last()].map(|load| load.copied().unwrap_or(f64::NAN));
            format!("the errors are known from p* = {least} to {most}")
        };
        let near = |k: &usize| {
            let below = if *k == 0 { 1.0 - ROUNDING } else { loads[k - 1] / loads[*k] };
            let above = loads.get(k + 1).map_or(1.0 + ROUNDING, |next| next / loads[*k]);
            let ratio = p_star / loads[*k];
            ratio > below * (1.0 + ROUNDING) && ratio < above * (1.0 - ROUNDING) || (ratio - 1.0).abs() <= ROUNDING
        };
        let found: Vec<usize> = (0..loads.len()).filter(near).collect();
        let is_inside = loads.first().is_some_and(|least| p_star >= least * (1.0 - ROUNDING))
            && loads.last().is_some_and(|most| p_star <= most * (1.0 + ROUNDING));
        let errors = self.error.get(name).filter(|_| is_inside).ok_or_else(beyond)?;
        found.into_iter().filter_map(|k| errors.get(k).copied()).reduce(f64::max).ok_or_else(beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deviations() -> Deviations {
        Deviations {
            p_star: vec![0.01, 0.1, 1.0],
            error: [("area_fraction".to_owned(), vec![0.3, 0.1, 0.2])].into(),
            contacts: 8,
            hurst: [0.0, 1.0],
            eps_f_inv: [6.0, 40.0],
            ssk: [-0.5, 0.5],
            sku: [2.0, 4.0],
            anisotropy: [0.01, 0.3],
            percolation: [0.41, 0.02],
        }
    }

    #[test]
    fn the_error_is_the_larger_one_of_the_neighbours() {
        let found = deviations();
        for (p_star, error) in [(0.01, 0.3), (0.05, 0.3), (0.1, 0.1), (0.11, 0.2), (0.99, 0.2), (1.0, 0.2)] {
            assert_eq!(found.error("area_fraction", p_star), Ok(error), "{p_star}");
        }
        for p_star in [0.0099, 1.01, f64::NAN] {
            assert!(found.error("area_fraction", p_star).is_err_and(|reason| reason.contains("0.01 to 1")), "{p_star}");
        }
    }

    #[test]
    fn bands_beyond_the_measured_ones_have_a_reason() {
        let found = deviations();
        let reason = |hurst, eps_f_inv| found.beyond(EquivalentBand { hurst, eps_f_inv }, [0.0, 3.0, 0.0]);
        assert_eq!(reason(0.0, 6.0), None);
        assert!(reason(-0.1, 10.0).is_some_and(|reason| reason.contains("Hurst exponent -0.10")));
        assert!(reason(0.5, 50.0).is_some_and(|reason| reason.contains("ratio of wavelengths 50.00")));
        assert!(reason(f64::NAN, 10.0).is_some());
        let of_heights = |heights| found.beyond(EquivalentBand { hurst: 0.5, eps_f_inv: 10.0 }, heights);
        assert!(of_heights([-0.6, 3.0, 0.1]).is_some_and(|reason| reason.contains("skewness -0.60")));
        assert!(of_heights([0.0, 9.0, 0.1]).is_some_and(|reason| reason.contains("kurtosis 9.00")));
        assert!(of_heights([0.0, 3.0, 0.9]).is_some_and(|reason| reason.contains("anisotropy 0.90")));
    }

    #[test]
    fn every_number_has_an_error_at_every_load() {
        let measured = Deviations::measured().unwrap();
        for name in super::super::NAMES {
            let errors = &measured.error[name];
            assert_eq!(errors.len(), measured.p_star.len(), "{name}");
            assert!(errors.iter().all(|error| *error > 0.0 && error.is_finite()), "{name}: {errors:?}");
        }
        assert!(measured.p_star.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
