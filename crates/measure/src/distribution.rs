/// A distribution of values between zero and the largest, in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Middles of the bins.
    pub middles: Vec<f64>,
    /// Values in a bin over all values of the field and over the width: the sum of densities times the width is the share of
    /// values that were counted.
    pub densities: Vec<f64>,
}

impl Distribution {
    /// The distribution of the positive `values` over `bins` bins, as shares of `all`. Without positive values all
    /// densities are zero.
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

    /// The width of a bin.
    pub fn width(&self) -> f64 {
        2.0 * self.middles.first().copied().unwrap_or(0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
