//! Resampling of realisations: groups of data with common realisations, means of a draw, and the resulting spread.

use std::collections::{BTreeMap, BTreeSet};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::Datum;

/// The 97.5 % quantile of the standard normal distribution.
pub(crate) const NORMAL_975: f64 = 1.959_963_984_540_054;

/// The 97.5 % quantile of Student's t, whose degrees of freedom (at least one) need not be whole.
pub(crate) fn student_975(freedom: f64) -> f64 {
    if freedom > 100.0 {
        // Fisher's expansion about the normal quantile is accurate to 2e-6 here; `statrs` does not terminate for large
        // degrees of freedom.
        let z = NORMAL_975;
        let cube = z * z * z;
        return z
            + (cube + z) / (4.0 * freedom)
            + (5.0 * cube * z * z + 16.0 * cube + 3.0 * z) / (96.0 * freedom * freedom);
    }
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Data with common seeds, and these seeds. Strata are independent of each other.
#[derive(Clone, Debug)]
struct Stratum {
    seeds: Vec<u64>,
    data: Vec<usize>,
}

/// The strata of the data: groups connected by common seeds.
#[derive(Clone, Debug)]
pub(crate) struct Strata<'a> {
    data: &'a [Datum],
    strata: Vec<Stratum>,
}

/// The variance of a linear combination of the means of the data, and its accuracy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub(crate) standard_error: f64,
    /// Factor on the deviations of the bootstrap: Student's t over the normal quantile, with the degrees of freedom of
    /// Welch and Satterthwaite, times (n / (n - 1))^(1/2), since resampling n values gives too small a variance.
    pub(crate) stretch: f64,
}

impl<'a> Strata<'a> {
    /// Groups the data. If `paired` is false, every datum is a stratum, as if all data had different surfaces.
    pub(crate) fn new(data: &'a [Datum], paired: bool) -> Self {
        let mut strata: Vec<(BTreeSet<u64>, Vec<usize>)> = Vec::new();
        for (index, datum) in data.iter().enumerate() {
            let mut seeds: BTreeSet<u64> = datum.kappa.keys().copied().collect();
            let mut members = vec![index];
            if paired {
                let (joined, apart): (Vec<_>, Vec<_>) = strata.into_iter().partition(|(s, _)| !s.is_disjoint(&seeds));
                strata = apart;
                for (other, data) in joined {
                    seeds.extend(other);
                    members.extend(data);
                }
                members.sort_unstable();
            }
            strata.push((seeds, members));
        }
        strata.sort_by(|a, b| a.1.cmp(&b.1));
        let strata =
            strata.into_iter().map(|(seeds, data)| Stratum { seeds: seeds.into_iter().collect(), data }).collect();
        Self { data, strata }
    }

    /// The number of strata with a single realisation, whose scatter cannot be resampled.
    pub(crate) fn single(&self) -> usize {
        self.strata.iter().filter(|stratum| stratum.seeds.len() < 2).count()
    }

    /// True if some stratum has at least two realisations.
    pub(crate) fn can_resample(&self) -> bool {
        self.single() < self.strata.len()
    }

    /// The means of the data over one draw of realisations with replacement; `None` if a datum has none in the draw.
    /// The draw depends only on `seed` and `index`.
    pub(crate) fn draw(&self, seed: u64, index: u64) -> Option<Vec<f64>> {
        let mut rng = Pcg64::seed_from_u64(seed.wrapping_add(index.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let mut means = vec![0.0; self.data.len()];
        for stratum in &self.strata {
            let drawn: Vec<u64> =
                (0..stratum.seeds.len()).map(|_| stratum.seeds[rng.random_range(0..stratum.seeds.len())]).collect();
            for &datum in &stratum.data {
                let values: Vec<f64> =
                    drawn.iter().filter_map(|seed| self.data[datum].kappa.get(seed).copied()).collect();
                if values.is_empty() {
                    return None;
                }
                means[datum] = values.iter().sum::<f64>() / values.len() as f64;
            }
        }
        Some(means)
    }

    /// The spread of sum_i a_i kappa_i over realisations, from the scatter of the contributions of single seeds.
    pub(crate) fn spread(&self, combination: &[f64]) -> Option<Spread> {
        let (mut variance, mut of_resampling, mut satterthwaite) = (0.0, 0.0, 0.0);
        for stratum in self.strata.iter().filter(|stratum| stratum.seeds.len() > 1) {
            let seeds = stratum.seeds.len() as f64;
            let mut contributions: BTreeMap<u64, f64> = stratum.seeds.iter().map(|&seed| (seed, 0.0)).collect();
            for &datum in &stratum.data {
                let values = &self.data[datum].kappa;
                let mean = self.data[datum].mean();
                for (seed, value) in values {
                    *contributions.entry(*seed).or_default() +=
                        combination[datum] * (value - mean) * seeds / values.len() as f64;
                }
            }
            let part = contributions.values().map(|z| z * z).sum::<f64>() / (seeds * (seeds - 1.0));
            variance += part;
            of_resampling += part * (seeds - 1.0) / seeds;
            satterthwaite += part * part / (seeds - 1.0);
        }
        if variance <= 0.0 {
            return self.can_resample().then_some(Spread { standard_error: 0.0, stretch: 1.0 });
        }
        let freedom = variance * variance / satterthwaite;
        let stretch = student_975(freedom) / NORMAL_975 * (variance / of_resampling).sqrt();
        Some(Spread { standard_error: variance.sqrt(), stretch })
    }
}

/// The `level` quantile of sorted values, linear between neighbours.
pub(crate) fn quantile(sorted: &[f64], level: f64) -> f64 {
    let position = level * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        let tabulated = [(1.0, 12.706_205), (2.0, 4.302_653), (3.0, 3.182_446), (10.0, 2.228_139), (30.0, 2.042_272)];
        for (freedom, value) in tabulated {
            approx::assert_relative_eq!(student_975(freedom), value, max_relative = 1e-6);
        }
        approx::assert_relative_eq!(student_975(200.0), 1.971_896, max_relative = 1e-6);
        approx::assert_relative_eq!(student_975(100.000_1), student_975(99.999_9), max_relative = 2e-6);
        approx::assert_relative_eq!(student_975(1e9), NORMAL_975, max_relative = 1e-6);
        assert!(student_975(2.5) < student_975(2.0) && student_975(2.5) > student_975(3.0));
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|level| quantile(&[1.0, 2.0, 4.0], level)), [1.0, 1.5, 2.0, 4.0]);
    }
}
