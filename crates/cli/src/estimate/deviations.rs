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
    /// Groups of surfaces, first the group whose errors count where several contain a surface.
    pub groups: Vec<Group>,
    /// Area fraction at which contacts percolate, and the deviation that 95 % of the surfaces do not exceed.
    pub percolation: [f64; 2],
}

/// Measured surfaces of one kind, with the ranges that they span.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Group {
    /// Words for the surfaces.
    pub name: String,
    /// By the name of a number, the relative deviation that 95 % of the contacts at each reduced pressure do not
    /// exceed.
    pub error: BTreeMap<String, Vec<f64>>,
    /// Number of contacts at each reduced pressure.
    pub contacts: usize,
    /// Least and largest Hurst exponent of the equivalent bands.
    pub hurst: [f64; 2],
    /// Least and largest ratio of the wavelengths of the equivalent bands.
    pub eps_f_inv: [f64; 2],
    /// Least and largest skewness Ssk of the heights.
    pub ssk: [f64; 2],
    /// Least and largest kurtosis Sku of the heights.
    pub sku: [f64; 2],
    /// Least and largest anisotropy of the mean square slopes.
    pub anisotropy: [f64; 2],
    /// Least and largest kurtosis of the slopes, relative to Gaussian ones.
    pub slope_kurtosis: [f64; 2],
}

impl Group {
    /// Returns the ranges, each with the words that name its quantity.
    fn ranges(&self) -> [(&'static str, [f64; 2]); 6] {
        [
            ("the spectrum has the Hurst exponent", self.hurst),
            ("the spectrum has the ratio of wavelengths", self.eps_f_inv),
            ("the heights have the skewness", self.ssk),
            ("the heights have the kurtosis", self.sku),
            ("the slopes have the anisotropy", [0.0, self.anisotropy[1]]),
            (
                "the slopes have the kurtosis, relative to Gaussian ones,",
                [self.slope_kurtosis[0].min(RANDOM), self.slope_kurtosis[1]],
            ),
        ]
    }
}

/// Least relative kurtosis of the slopes of random surfaces; a smooth shape has less.
const RANDOM: f64 = 0.9;

/// Returns true if a value is in a range.
fn is_within(value: f64, [least, most]: [f64; 2]) -> bool {
    value >= least - ROUNDING * least.abs() && value <= most + ROUNDING * most.abs()
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

    /// Returns the errors for surfaces with this band, and with the numbers of [`shape`](super::shape).
    ///
    /// # Errors
    /// Returns the reason why there are none.
    pub fn like(&self, band: EquivalentBand, [ssk, sku, anisotropy, slopes]: [f64; 4]) -> Result<Errors<'_>, String> {
        let values = [band.hurst, band.eps_f_inv, ssk, sku, anisotropy, slopes];
        let contains =
            |group: &&Group| group.ranges().into_iter().zip(values).all(|((_, range), value)| is_within(value, range));
        if let Some(group) = self.groups.iter().find(contains) {
            return Ok(Errors { p_star: &self.p_star, group });
        }
        let beyond = (0..values.len()).find_map(|which| {
            let ranges = self.groups.iter().map(|group| group.ranges()[which]);
            let (name, [least, most]) = ranges.reduce(|(name, [a, b]), (_, [c, d])| (name, [a.min(c), b.max(d)]))?;
            let value = values[which];
            (!is_within(value, [least, most]))
                .then(|| format!("{name} {value:.2}, and the errors are known from {least:.2} to {most:.2}"))
        });
        Err(beyond.unwrap_or_else(|| {
            format!(
                "no measured surfaces have at once the Hurst exponent {:.2}, the ratio of wavelengths {:.1}, the \
                 skewness {ssk:.2}, the kurtosis {sku:.2}, the anisotropy {anisotropy:.2} and the relative kurtosis of \
                 slopes {slopes:.2}",
                band.hurst, band.eps_f_inv
            )
        }))
    }
}

/// Errors of the estimates for surfaces of one group.
#[derive(Clone, Copy, Debug)]
pub struct Errors<'a> {
    p_star: &'a [f64],
    /// Group.
    pub group: &'a Group,
}

impl Errors<'_> {
    /// Returns the relative error of a number at a reduced pressure, the larger one of the neighbouring loads.
    ///
    /// # Errors
    /// Returns the reason if the load is lighter or heavier than all measured ones.
    pub fn of(&self, name: &str, p_star: f64) -> Result<f64, String> {
        let loads = self.p_star;
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
        let errors = self.group.error.get(name).filter(|_| is_inside).ok_or_else(beyond)?;
        found.into_iter().filter_map(|k| errors.get(k).copied()).reduce(f64::max).ok_or_else(beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(name: &str, error: f64, ssk: [f64; 2]) -> Group {
        Group {
            name: name.into(),
            error: [("area_fraction".to_owned(), vec![3.0 * error, error, 2.0 * error])].into(),
            contacts: 8,
            hurst: [0.0, 1.0],
            eps_f_inv: [6.0, 40.0],
            ssk,
            sku: [2.0, 4.0],
            anisotropy: [0.01, 0.3],
            slope_kurtosis: [0.9, 1.2],
        }
    }

    fn deviations() -> Deviations {
        let groups = vec![group("narrow", 0.1, [-0.5, 0.5]), group("wide", 0.2, [0.0, 2.0])];
        Deviations { p_star: vec![0.01, 0.1, 1.0], groups, percolation: [0.41, 0.02] }
    }

    fn band(hurst: f64, eps_f_inv: f64) -> EquivalentBand {
        EquivalentBand { hurst, eps_f_inv }
    }

    #[test]
    fn the_error_is_the_larger_one_of_the_neighbours() {
        let found = deviations();
        let errors = found.like(band(0.5, 10.0), [0.1, 3.0, 0.1, 1.0]).unwrap();
        for (p_star, error) in [(0.01, 0.3), (0.05, 0.3), (0.1, 0.1), (0.11, 0.2), (0.99, 0.2), (1.0, 0.2)] {
            assert!((errors.of("area_fraction", p_star).unwrap() - error).abs() < 1e-12, "{p_star}");
        }
        for p_star in [0.0099, 1.01, f64::NAN] {
            assert!(errors.of("area_fraction", p_star).is_err_and(|reason| reason.contains("0.01 to 1")), "{p_star}");
        }
    }

    #[test]
    fn the_first_group_that_contains_a_surface_has_its_errors() {
        let found = deviations();
        let name = |ssk| found.like(band(0.5, 10.0), [ssk, 3.0, 0.1, 1.0]).map(|errors| errors.group.name.clone());
        assert_eq!([-0.5, 0.2, 0.5].map(name), ["narrow"; 3].map(|name| Ok(name.to_owned())));
        assert_eq!([0.6, 2.0].map(name), ["wide"; 2].map(|name| Ok(name.to_owned())));
        let mut apart = deviations();
        apart.groups[1].sku = [4.0, 9.0];
        let reason = apart.like(band(0.5, 10.0), [1.0, 3.0, 0.1, 1.0]).unwrap_err();
        assert!(reason.contains("at once") && reason.contains("skewness 1.00, the kurtosis 3.00"), "{reason}");
    }

    #[test]
    fn surfaces_beyond_the_measured_ones_have_a_reason() {
        let found = deviations();
        let reason = |hurst, eps_f_inv| found.like(band(hurst, eps_f_inv), [0.0, 3.0, 0.0, 1.0]).err();
        assert_eq!(reason(0.0, 6.0), None);
        assert!(reason(-0.1, 10.0).is_some_and(|reason| reason.contains("Hurst exponent -0.10")));
        assert!(reason(0.5, 50.0).is_some_and(|reason| reason.contains("ratio of wavelengths 50.00")));
        assert!(reason(f64::NAN, 10.0).is_some());
        let of_heights = |heights| found.like(band(0.5, 10.0), heights).err();
        assert!(of_heights([-0.6, 3.0, 0.1, 1.0]).is_some_and(|reason| reason.contains("skewness -0.60")));
        assert!(of_heights([0.0, 9.0, 0.1, 1.0]).is_some_and(|reason| reason.contains("kurtosis 9.00")));
        assert!(of_heights([0.0, 3.0, 0.9, 1.0]).is_some_and(|reason| reason.contains("anisotropy 0.90")));
        assert!(
            of_heights([0.0, 3.0, 0.1, 1.3]).is_some_and(|reason| reason.contains("relative to Gaussian ones, 1.30"))
        );
    }

    #[test]
    fn every_number_has_an_error_at_every_load() {
        let measured = Deviations::measured().unwrap();
        for group in &measured.groups {
            for name in super::super::NAMES {
                let errors = &group.error[name];
                assert_eq!(errors.len(), measured.p_star.len(), "{name}");
                assert!(errors.iter().all(|error| *error > 0.0 && error.is_finite()), "{name}: {errors:?}");
            }
        }
        assert!(measured.p_star.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
