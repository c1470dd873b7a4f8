//! Heights and slopes of the highest points of a surface.

use ndarray::ArrayView2;

/// Number of classes of heights.
const CLASSES: usize = 4096;

/// Heights and mean square slopes of the highest points of a rough surface, by their area fraction.
#[derive(Clone, Debug, PartialEq)]
pub struct Summits {
    /// Lowest height of each class from the top down, relative to the mean, length.
    level: Vec<f64>,
    /// Area fraction above each level.
    fraction: Vec<f64>,
    /// Mean square slope above each level, divided by the mean square slope of the surface.
    slope: Vec<f64>,
    rms_height: f64,
    kurtosis: f64,
}

impl Summits {
    /// Takes the heights `[x, y]` of a periodic surface, length, and the grid spacings, length. `None` for a flat
    /// surface and heights that are not finite.
    pub fn of(heights: ArrayView2<'_, f64>, spacing: [f64; 2]) -> Option<Self> {
        let (nx, ny) = heights.dim();
        let count = (nx * ny) as f64;
        let mean = heights.sum() / count;
        let (low, high) = heights.iter().fold((f64::INFINITY, -f64::INFINITY), |(l, h), z| (l.min(*z), h.max(*z)));
        let width = (high - low) / CLASSES as f64;
        let is_rough = width > 0.0 && width.is_finite() && mean.is_finite();
        if !is_rough {
            return None;
        }
        let mut classes = vec![[0.0_f64; 2]; CLASSES];
        let ([mut square, mut fourth], mut tensor) = ([0.0; 2], [0.0; 3]);
        for x in 0..nx {
            let [before, row, after] = [(x + nx - 1) % nx, x, (x + 1) % nx].map(|x| heights.row(x));
            for y in 0..ny {
                let here = row[y];
                let step = |other: f64, spacing: f64| ((other - here) / spacing).powi(2);
                let along_x = step(before[y], spacing[0]) + step(after[y], spacing[0]);
                let along_y = step(row[(y + ny - 1) % ny], spacing[1]) + step(row[(y + 1) % ny], spacing[1]);
                let class = (((high - here) / width) as usize).min(CLASSES - 1);
                classes[class][0] += 1.0;
                classes[class][1] += 0.5 * (along_x + along_y);
                square += (here - mean).powi(2);
                let [slope_x, slope_y] = [(after[y] - here) / spacing[0], (row[(y + 1) % ny] - here) / spacing[1]];
                tensor[0] += slope_x * slope_x;
                tensor[1] += slope_y * slope_y;
                tensor[2] += slope_x * slope_y;
                fourth += (slope_x * slope_x + slope_y * slope_y).powi(2);
            }
        }
        let total: f64 = classes.iter().map(|[_, slope]| slope).sum();
        let [mut points, mut slopes] = [0.0; 2];
        let [mut level, mut fraction, mut slope] = [const { Vec::new() }; 3];
        for (index, [number, sum]) in classes.into_iter().enumerate().filter(|(_, [number, _])| *number > 0.0) {
            points += number;
            slopes += sum;
            level.push(high - (index + 1) as f64 * width - mean);
            fraction.push(points / count);
            slope.push(slopes / points / (total / count));
        }
        let [along_x, along_y, mixed] = tensor;
        let trace = along_x + along_y;
        let gaussian = 2.0 + ((along_x - along_y).powi(2) + 4.0 * mixed * mixed) / (trace * trace);
        let kurtosis = fourth * count / (trace * trace) / gaussian;
        Some(Self { level, fraction, slope, rms_height: (square / count).sqrt(), kurtosis })
    }

    /// Returns the rms height, length.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    /// Returns the mean fourth power of the slope divided by the value of Gaussian slopes with the same mean squares,
    /// (2 + A²) ⟨|∇h|²⟩² with the anisotropy A of the mean square slopes: 1 for Gaussian slopes, more where flat and
    /// steep parts alternate.
    pub fn slope_kurtosis(&self) -> f64 {
        self.kurtosis
    }

    /// Returns the mean square slope of the highest points, with this area fraction, divided by the mean square slope
    /// of all.
    pub fn slope(&self, fraction: f64) -> f64 {
        self.at(&self.slope, fraction)
    }

    /// Returns the height that this area fraction exceeds, relative to the mean, length.
    pub fn height(&self, fraction: f64) -> f64 {
        self.at(&self.level, fraction)
    }

    /// Interpolates values of the levels between area fractions.
    fn at(&self, values: &[f64], fraction: f64) -> f64 {
        let next = self.fraction.partition_point(|known| *known < fraction);
        if next == 0 || next == self.fraction.len() {
            return values[next.min(values.len() - 1)];
        }
        let [from, to] = [self.fraction[next - 1], self.fraction[next]];
        let part = (fraction - from) / (to - from);
        (1.0 - part) * values[next - 1] + part * values[next]
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    /// A wave along x: slopes and heights of its top are known.
    #[test]
    fn the_top_of_a_wave_is_flat() {
        let n = 4000;
        let wave = Array2::from_shape_fn((n, 2), |(x, _)| (std::f64::consts::TAU * x as f64 / n as f64).cos());
        let summits = Summits::of(wave.view(), [1.0 / n as f64, 0.3]).unwrap();
        assert!((summits.rms_height() - 0.5_f64.sqrt()).abs() < 1e-6);
        // ⟨sin⁴⟩/⟨sin²⟩² = 3/2, of 3 of Gaussian slopes along one line.
        assert!((summits.slope_kurtosis() - 0.5).abs() < 1e-5, "{}", summits.slope_kurtosis());
        for fraction in [0.02_f64, 0.1, 0.5, 0.9, 1.0] {
            // Points within the phase π f of the crest; the mean of sin² there.
            let phase = std::f64::consts::PI * fraction;
            let slope = 1.0 - (2.0 * phase).sin() / (2.0 * phase);
            assert!((summits.slope(fraction) - slope).abs() < 2e-3, "{fraction}: {}", summits.slope(fraction));
            assert!((summits.height(fraction) - phase.cos()).abs() < 2e-3, "{fraction}");
        }
    }

    #[test]
    fn flat_and_undefined_heights_have_none() {
        for height in [0.0, f64::NAN, f64::INFINITY] {
            assert!(Summits::of(Array2::from_elem((4, 4), height).view(), [1.0; 2]).is_none());
        }
        let mut heights = Array2::zeros((4, 4));
        heights[[1, 2]] = f64::NAN;
        assert!(Summits::of(heights.view(), [1.0; 2]).is_none());
    }
}
