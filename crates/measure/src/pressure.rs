use std::fmt;
use std::ops::Range;

use gfmd_vector::{Share, add, contiguous};
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
    /// Moments ⟨p^k⟩ over the whole surface for k = 2, 3, 4.
    pub moments: [f64; 3],
    /// Quantiles at [`QUANTILE_LEVELS`] over the points in contact; 0 without contact.
    pub quantiles_in_contact: [f64; 5],
}

/// Levels of [`PressureStatistics::quantiles_in_contact`].
pub const QUANTILE_LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// Computes the statistics of a pressure field.
pub fn pressure_statistics(pressure: ArrayView2<f64>) -> PressureStatistics {
    let (rows, columns) = pressure.dim();
    let (share, pressure) = (Share::whole(rows, columns), &*contiguous(&pressure));
    let n = pressure.len().max(1) as f64;
    let contact = InContact::of(&share, pressure);
    // Positive floats sort in the order of their bits, and integers are sorted faster.
    let mut bits: Vec<u64> = pressure.iter().filter(|p| **p > 0.0).map(|p| p.to_bits()).collect();
    bits.sort_unstable();
    let sorted: Vec<f64> = bits.into_iter().map(f64::from_bits).collect();
    PressureStatistics {
        mean: share.total_of(pressure) / n,
        max: contact.max,
        mean_in_contact: contact.mean(),
        deviation_in_contact: contact.deviation(),
        moments: [1, 2, 3].map(|k| contact.powers[k] / n),
        quantiles_in_contact: QUANTILE_LEVELS.map(|level| quantile(&sorted, level).unwrap_or(0.0)),
    }
}

/// Pressures above zero; each process holds its own rows. Sums are bitwise equal for any number of threads and
/// processes.
pub(crate) struct InContact<'a> {
    share: &'a Share,
    pressure: &'a [f64],
    count: u64,
    /// Sums Σ p^k for k = 1, 2, 3, 4.
    pub(crate) powers: [f64; 4],
    /// Largest pressure; 0 without contact.
    pub(crate) max: f64,
}

impl<'a> InContact<'a> {
    pub(crate) fn of(share: &'a Share, pressure: &'a [f64]) -> Self {
        let of_range = |range: Range<usize>| {
            let mut found = (0, [0.0; 4], 0.0);
            for p in pressure[range].iter().copied().filter(|p| *p > 0.0) {
                let square = p * p;
                found = (found.0 + 1, add(found.1, [p, square, square * p, square * square]), f64::max(found.2, p));
            }
            found
        };
        let (count, powers, max) = share.reduce(&of_range, &|a, b| (a.0 + b.0, add(a.1, b.1), f64::max(a.2, b.2)));
        Self { share, pressure, count, powers, max }
    }

    /// Returns the mean; 0 without contact.
    pub(crate) fn mean(&self) -> f64 {
        self.powers[0] / self.counted()
    }

    /// Returns the standard deviation; 0 without contact.
    pub(crate) fn deviation(&self) -> f64 {
        let mean = self.mean();
        let squares = self.share.sum(&|range| {
            self.pressure[range].iter().filter(|p| **p > 0.0).fold(0.0, |sum, p| sum + (p - mean).powi(2))
        });
        (squares / self.counted()).sqrt()
    }

    fn counted(&self) -> f64 {
        self.count.max(1) as f64
    }
}

/// Error for two fields of one surface with different shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapesDiffer {
    /// Shape of the pressure, `[x, y]`.
    pub pressure: [usize; 2],
    /// Shape of the other field.
    pub other: [usize; 2],
}

impl fmt::Display for ShapesDiffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the displacement has the shape {:?}; it must be {:?}, the shape of the pressure",
            self.other, self.pressure
        )
    }
}

impl std::error::Error for ShapesDiffer {}

/// Returns the elastic energy per area, ⟨−p u_z⟩/2, in stress times length; `displacement` is u_z, negative downwards
/// (theory.md, section 0).
///
/// # Errors
/// A displacement that does not have the shape of the pressure.
pub fn elastic_energy_density(pressure: ArrayView2<f64>, displacement: ArrayView2<f64>) -> Result<f64, ShapesDiffer> {
    let (shape, other) = (pressure.dim(), displacement.dim());
    if shape != other {
        return Err(ShapesDiffer { pressure: shape.into(), other: other.into() });
    }
    let share = Share::whole(shape.0, shape.1);
    Ok(elastic_energy_over(&share, &contiguous(&pressure), &contiguous(&displacement)))
}

/// Returns the elastic energy per area of distributed fields, each process passing its rows; NaN on all processes if
/// the fields of one have different sizes.
pub(crate) fn elastic_energy_over(share: &Share, pressure: &[f64], displacement: &[f64]) -> f64 {
    let alike = pressure.len() == displacement.len();
    let work = |range: Range<usize>| match displacement.get(range.clone()) {
        Some(displacement) if alike => pressure[range].iter().zip(displacement).fold(0.0, |sum, (p, u)| sum - p * u),
        _ => f64::NAN,
    };
    0.5 * share.sum(&work) / share.total().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn statistics_of_a_known_distribution() {
        // Values 1, 2, …, 101 in contact, and as many zeros.
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
        assert_eq!(elastic_energy_density(p.view(), u.view()), Ok(0.75));
    }

    #[test]
    fn a_displacement_of_another_shape_has_no_energy() {
        let p = Array2::from_elem((2, 3), 1.0);
        for other in [[3, 2], [2, 2], [2, 4], [0, 0]] {
            let u = Array2::from_elem(other, -1.0);
            assert_eq!(elastic_energy_density(p.view(), u.view()), Err(ShapesDiffer { pressure: [2, 3], other }));
        }
    }
}
