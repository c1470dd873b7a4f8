/// Distribution of values between zero and the largest, in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Centres of the bins.
    pub middles: Vec<f64>,
    /// Number of values in a bin, divided by the number of all values and by the bin width. The sum of densities times
    /// the width is the fraction of values counted.
    pub densities: Vec<f64>,
}

impl Distribution {
    /// Computes the distribution of the positive `values` over `bins` bins, as fractions of `all` values. Without
    /// positive values all densities are zero.
    pub fn of(values: impl Iterator<Item = f64> + Clone, all: usize, bins: usize) -> Self {
        let positive = values.filter(|value| *value > 0.0);
        let largest = positive.clone().fold(0.0, f64::max);
        let width = if largest > 0.0 { largest / bins as f64 } else { 1.0 };
        let mut counts = vec![0_u64; bins];
        for value in positive {
            counts[((value / width) as usize).min(bins - 1)] += 1;
        }
        let densities = counts.into_iter().map(|count| count as f64 / (all as f64 * width)).collect();
        Self { middles: (0..bins).map(|bin| (bin as f64 + 0.5) * width).collect(), densities }
    }

    /// Returns the width of a bin.
    pub fn width(&self) -> f64 {
        2.0 * self.middles.first().copied().unwrap_or(0.5)
    }
}

/// Returns geometric centres and densities of bins of equal width on a logarithmic scale, from the lowest: `bins` per
/// decade over the given number of decades up to the largest value. A density is the number of `values` in a bin
/// divided by `all` and by the bin width. Smaller values are not counted; without positive values there are no bins.
pub fn density_over_decades(
    values: impl Iterator<Item = f64> + Clone,
    all: usize,
    decades: usize,
    bins: usize,
) -> Vec<[f64; 2]> {
    let largest = values.clone().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Vec::new();
    }
    let mut counts = vec![0_u64; decades * bins];
    let below = |value: f64| (largest / value).log10() * bins as f64;
    for value in values.filter(|value| *value > 0.0) {
        if let Some(count) = counts.get_mut(below(value).max(0.0) as usize) {
            *count += 1;
        }
    }
    let at = |bin: f64| largest * 10_f64.powf(-bin / bins as f64);
    let density = |(bin, count): (usize, u64)| {
        let bin = bin as f64;
        [at(bin + 0.5), count as f64 / (all as f64 * (at(bin) - at(bin + 1.0)))]
    };
    counts.into_iter().enumerate().rev().map(density).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_over_decades_have_the_density_of_a_power() {
        // x = u² with a uniform u has the density 1/(2√x).
        let n = 1_000_000;
        let values = (0..n).map(|i| ((i as f64 + 0.5) / n as f64).powi(2));
        let found = density_over_decades(values, n, 4, 5);
        assert_eq!(found.len(), 20);
        assert!(found.is_sorted_by(|a, b| a[0] < b[0]));
        for [x, density] in found {
            // The mean over a bin is below the density at its geometric centre by (ln 10/5)²/32.
            assert!((density * 2.0 * x.sqrt() - 1.0).abs() < 0.01, "{x} {density}");
        }
        let found = density_over_decades([0.0, 100.0, 10.5, 1e-9, -1.0].into_iter(), 4, 2, 1);
        assert_eq!(found.len(), 2);
        assert!((found[1][1] - 0.5 / 90.0).abs() < 1e-15 && found[0][1] == 0.0);
        assert!(density_over_decades([0.0, -1.0].into_iter(), 2, 2, 1).is_empty());
    }

    #[test]
    fn shares_add_up_and_the_largest_value_has_a_bin() {
        let values = [0.0, 1.0, 3.0, 4.0, -2.0];
        let found = Distribution::of(values.into_iter(), 5, 4);
        assert_eq!(found.middles, [0.5, 1.5, 2.5, 3.5]);
        assert_eq!(found.densities, [0.0, 0.2, 0.0, 0.4]);
        assert!((found.densities.iter().sum::<f64>() * found.width() - 0.6).abs() < 1e-15);
        let none = Distribution::of([0.0].into_iter(), 1, 3);
        assert_eq!(none.densities, [0.0; 3]);
    }
}
