//! Heights that may denote missing points, or are damaged.

use ndarray::Array2;

/// Numbers that programs write for missing points, if far outside all heights.
const KNOWN: [f64; 13] = [
    -999.25,
    -999.0,
    -9999.0,
    -99999.0,
    -999_999.0,
    9999.0,
    99999.0,
    -32768.0,
    32767.0,
    -25400.0,
    65535.0,
    -2_147_483_648.0,
    2_147_483_647.0,
];

/// Size above which a single number far from all others is not a height in any unit.
const HUGE: f64 = 1e10;

/// Relative rounding error of heights of single precision.
const ROUNDING: f64 = 1e-6;

/// Distance from all other heights, relative to their range, at which a known number is doubtful.
const KNOWN_FAR: f64 = 2.0;

/// Distance at which any repeated number is doubtful.
const FAR: f64 = 10.0;

/// Returns a warning with the lowest or highest height if it is far outside all others, and either occurs repeatedly or
/// is used by programs for missing points.
pub(crate) fn warning(heights: &Array2<f64>) -> Option<String> {
    let listed: Vec<String> = doubtful(heights)
        .map(|(height, count)| {
            let height = if height.abs() < HUGE { height.to_string() } else { format!("{height:e}") };
            format!("{height} at {count} point{}", if count == 1 { "" } else { "s" })
        })
        .collect();
    (!listed.is_empty()).then(|| {
        format!(
            "the height is {}, far outside all others; this may denote missing points, which must be nan",
            listed.join(" and ")
        )
    })
}

/// Returns a warning with the number of heights outside the range that the head of a file states, and the furthest of
/// them. Each end of the range is rounded to its `digits`. A range from 0 to 0 is not stated.
pub(crate) fn outside(heights: &Array2<f64>, [low, high]: [f64; 2], digits: [f64; 2]) -> Option<String> {
    if [low, high] == [0.0; 2] {
        return None;
    }
    let slack = ROUNDING * low.abs().max(high.abs());
    let distance = |z: f64| (low - digits[0] - slack - z).max(z - high - digits[1] - slack);
    let found = heights.iter().copied().filter(|z| z.is_finite() && distance(*z) > 0.0);
    let count = found.clone().count();
    let furthest = found.max_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    Some(format!(
        "{count} of {} heights are outside the range in the head, {low} to {high}, the furthest at {furthest}; head or \
         heights are damaged",
        heights.len()
    ))
}

/// Two lowest different heights, or the two highest ones with their signs changed.
struct End {
    extreme: f64,
    next: f64,
    /// Number of points with the extreme height.
    count: usize,
}

impl End {
    fn add(&mut self, height: f64) {
        if height < self.extreme {
            *self = Self { extreme: height, next: self.extreme, count: 1 };
        } else if height == self.extreme {
            self.count += 1;
        } else {
            self.next = self.next.min(height);
        }
    }

    /// Returns the extreme height and its count if it may denote missing points; `sign` is the sign of this end.
    fn doubtful(&self, other: &Self, sign: f64) -> Option<(f64, usize)> {
        let (highest, before) = (-other.extreme, -other.next);
        // Another missing-point number may be at the other end.
        let end = if before > self.next && highest - before > FAR * (before - self.next) { before } else { highest };
        let range = end - self.next;
        let height = sign * self.extreme;
        let is_known = KNOWN.contains(&height) || height.abs() >= HUGE;
        let ranges = if is_known { KNOWN_FAR } else { FAR };
        // Two levels, as of a punch, have no range.
        let is_far = range > 0.0 && self.next - self.extreme > ranges * range;
        (is_far && (self.count > 1 || is_known)).then_some((height, self.count))
    }
}

/// Returns the lowest and the highest height, each with its count, if it may denote missing points.
fn doubtful(heights: &Array2<f64>) -> impl Iterator<Item = (f64, usize)> {
    let none = || End { extreme: f64::INFINITY, next: f64::INFINITY, count: 0 };
    let (mut low, mut high) = (none(), none());
    for height in heights.iter().filter(|height| height.is_finite()) {
        if *height <= low.next {
            low.add(*height);
        }
        if -height <= high.next {
            high.add(-height);
        }
    }
    [low.doubtful(&high, 1.0), high.doubtful(&low, -1.0)].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns heights between -1 and 1, with `number` at some points.
    fn map(number: f64, count: usize) -> Array2<f64> {
        let mut heights = Array2::from_shape_fn((8, 6), |(i, j)| (1.3 * i as f64 + 0.7 * j as f64).sin());
        heights.iter_mut().step_by(7).take(count).for_each(|height| *height = number);
        heights
    }

    #[test]
    fn numbers_for_missing_points_are_named() {
        for number in [-9999.0, -99999.0, -25400.0, 3.402_823e38, -1e10, 1e10, f64::MAX, 32767.0, 1.701_41e38] {
            for count in [1, 3] {
                let text = warning(&map(number, count)).unwrap();
                let points = if count == 1 { "1 point," } else { "3 points," };
                assert!(text.contains(&format!(" at {points} far outside")), "{text}");
                assert!(number.abs() >= HUGE || text.contains(&number.to_string()), "{text}");
            }
        }
        // Any other number must occur repeatedly, as a scaled -32768 does.
        assert!(warning(&map(-327.68e-3 * 100.0, 2)).is_some());
        assert_eq!(warning(&map(-327.68e-3 * 100.0, 1)), None);
        // Both ends.
        let mut both = map(-9999.0, 2);
        both[[7, 5]] = 1e10;
        let text = warning(&both).unwrap();
        assert!(text.contains("-9999 at 2 points and 1e10 at 1 point"), "{text}");
    }

    #[test]
    fn heights_are_no_missing_points() {
        // Ordinary heights, a spike, a flat floor that is not far away, two levels, one level.
        for heights in [
            map(0.5, 3),
            map(-40.0, 1),
            map(-8.0, 9),
            map(0.0, 48),
            Array2::from_shape_fn((4, 4), |(i, _)| f64::from(i > 1)),
        ] {
            assert_eq!(warning(&heights), None);
        }
        assert_eq!(warning(&Array2::from_elem((2, 2), f64::NAN)), None);
        let steps = Array2::from_shape_fn((40, 1), |(i, _)| -9999.0 + 400.0 * i as f64);
        assert_eq!(warning(&steps), None);
    }
}
