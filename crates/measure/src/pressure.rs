use ndarray::ArrayView2;

use crate::quantile;

/// Statistics of the pressure, in units of stress.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureStatistics {
    /// Mean over the whole surface.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// Mean over the points in contact; 0 without contact.
    pub mean_in_contact: f64,
    /// Standard deviation over the points in contact.
    pub deviation_in_contact: f64,
    /// ⟨p^k⟩ over the whole surface for k = 2, 3, 4.
    pub moments: [f64; 3],
    /// The quantiles at [`QUANTILE_LEVELS`] over the points in contact; 0 without contact.
    pub quantiles_in_contact: [f64; 5],
}

/// The levels of [`PressureStatistics::quantiles_in_contact`].
pub const QUANTILE_LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// The statistics of a pressure field.
pub fn pressure_statistics(pressure: ArrayView2<f64>) -> PressureStatistics {
    let n = pressure.len().max(1) as f64;
    let contact = InContact::of(pressure);
    let mean_in_contact = contact.mean();
    PressureStatistics {
        mean: pressure.iter().sum::<f64>() / n,
        max: contact.max(),
        mean_in_contact,
        deviation_in_contact: contact.deviation(mean_in_contact),
        moments: [2, 3, 4].map(|k| contact.power(k) / n),
        quantiles_in_contact: QUANTILE_LEVELS.map(|level| quantile(&contact.sorted, level).unwrap_or(0.0)),
    }
}

/// The pressures above zero.
pub(crate) struct InContact {
    sorted: Vec<f64>,
}

impl InContact {
    pub(crate) fn of(pressure: ArrayView2<f64>) -> Self {
        // Positive numbers have the order of their bits, and integers are sorted faster.
        let mut bits: Vec<u64> = pressure.iter().filter(|p| **p > 0.0).map(|p| p.to_bits()).collect();
        bits.sort_unstable();
        Self { sorted: bits.into_iter().map(f64::from_bits).collect() }
    }

    pub(crate) fn max(&self) -> f64 {
        self.sorted.last().copied().unwrap_or(0.0)
    }

    /// Σ p^k.
    pub(crate) fn power(&self, k: i32) -> f64 {
        self.sorted.iter().map(|p| p.powi(k)).sum()
    }

    /// The mean; 0 without contact.
    pub(crate) fn mean(&self) -> f64 {
        self.power(1) / self.count()
    }

    /// The standard deviation from `mean`.
    pub(crate) fn deviation(&self, mean: f64) -> f64 {
        (self.sorted.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / self.count()).sqrt()
    }

    fn count(&self) -> f64 {
        self.sorted.len().max(1) as f64
    }
}

/// The elastic energy per area, ⟨−p u_z⟩/2, in stress times length; `displacement` is u_z, negative downwards
/// (theory.md, section 0).
pub fn elastic_energy_density(pressure: ArrayView2<f64>, displacement: ArrayView2<f64>) -> f64 {
    let work: f64 = pressure.iter().zip(displacement).map(|(p, u)| -p * u).sum();
    0.5 * work / pressure.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn statistics_of_a_known_distribution() {
        // 1, 2, …, 101 on contact, as many zeros beside.
        let p = Array2::from_shape_fn((2, 101), |(i, j)| if i == 0 { (j + 1) as f64 } else { 0.0 });
        let s = pressure_statistics(p.view());
        assert_eq!((s.max, s.mean_in_contact, s.mean), (101.0, 51.0, 25.5));
        assert_eq!(s.quantiles_in_contact, [6.0, 26.0, 51.0, 76.0, 96.0]);
        approx::assert_relative_eq!(s.deviation_in_contact, 850f64.sqrt(), max_relative = 1e-14);
        approx::assert_relative_eq!(s.moments[0], 348_551.0 / 202.0, max_relative = 1e-14);
    }

    #[test]
    fn no_contact_is_all_zero() {
        let s = pressure_statistics(Array2::zeros((3, 3)).view());
        assert_eq!((s.max, s.mean, s.quantiles_in_contact), (0.0, 0.0, [0.0; 5]));
    }

    #[test]
    fn pressing_down_stores_energy() {
        let (p, u) = (Array2::from_elem((2, 2), 3.0), Array2::from_elem((2, 2), -0.5));
        assert_eq!(elastic_energy_density(p.view(), u.view()), 0.75);
    }
}
