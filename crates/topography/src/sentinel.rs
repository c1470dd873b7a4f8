//! Heights that may denote missing points, or are damaged.

use ndarray::Array2;

use crate::unit::Conversion;

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

/// Relative rounding error of computed heights.
const ROUNDING_OF_SUMS: f64 = 1e-14;

/// Relative rounding error of heights of single precision.
const ROUNDING: f64 = 1e-6;

/// Distance from all other heights, relative to their range, at which a known number is doubtful.
const KNOWN_FAR: f64 = 2.0;

/// Distance at which any repeated number is doubtful.
const FAR: f64 = 10.0;

/// Largest height in metres: larger ones are neither on a specimen nor on the Earth.
const HIGHEST: f64 = 1e4;

/// Largest height in any unit.
const LARGEST: f64 = 1e30;

/// Distance from the median, relative to all nearer heights and to the central range, at which heights are doubtful.
const ISOLATED: f64 = 500.0;

/// Largest number of heights from which the central range is estimated, to some 5 %, and the smallest.
const MOST_SAMPLES: usize = 1 << 12;
const FEWEST_SAMPLES: usize = 16;

/// Returns a warning about heights that may denote missing points or are damaged: numbers for missing points, heights
/// that are larger than any, and heights far outside all others. `unit` is the unit of the heights.
pub(crate) fn warning(heights: &Array2<f64>, unit: Option<&str>) -> Option<String> {
    match (marks(heights), impossible(heights, unit)) {
        (Some((text, marked)), Some((_, count))) if marked >= count => Some(text),
        (_, Some((text, _))) | (Some((text, _)), None) => Some(text),
        (None, None) => isolated(heights),
    }
}

/// Returns a warning with the number of heights that are larger than any, and this number.
fn impossible(heights: &Array2<f64>, unit: Option<&str>) -> Option<(String, usize)> {
    let factor = |unit| Conversion::between(unit, "m").ok().map(|found| found.map_or(1.0, |found| found.apply(1.0)));
    let metres = unit.and_then(factor);
    let limit = metres.map_or(LARGEST, |metres| LARGEST.min(HIGHEST / metres));
    let found = heights.iter().copied().filter(|z| z.is_finite() && z.abs() > limit);
    let count = found.clone().count();
    let furthest = found.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let limit = if metres.is_some() { format!("{HIGHEST} m") } else { format!("{LARGEST:e}") };
    let text = format!(
        "{count} of {} heights are larger than {limit}, up to {furthest:e}; they may be damaged or denote missing \
         points, which must be nan",
        heights.len()
    );
    Some((text, count))
}

/// Returns a warning with the heights that are far outside all others. The central nine tenths of the heights set the
/// scale.
fn isolated(heights: &Array2<f64>) -> Option<String> {
    let finite = || heights.iter().copied().filter(|z| z.is_finite());
    // An odd step meets all columns of a grid.
    let step = finite().count().div_ceil(MOST_SAMPLES) | 1;
    let mut samples: Vec<f64> = finite().step_by(step).collect();
    let count = samples.len();
    let cut = (count / 20).max(2);
    if count < FEWEST_SAMPLES {
        return None;
    }
    let [low, median, high] =
        [cut, count / 2, count - 1 - cut].map(|place| *samples.select_nth_unstable_by(place, f64::total_cmp).1);
    let range = high - low;
    let distance = |z: f64| (z - median).abs();
    // A flat surface has no scale.
    if range <= ROUNDING_OF_SUMS * low.abs().max(high.abs()) || finite().all(|z| distance(z) <= ISOLATED * range) {
        return None;
    }
    // Nearest and furthest distance for each binary exponent.
    let mut octaves = vec![[f64::INFINITY, 0.0]; 1 << 11];
    for distance in finite().map(distance) {
        let [near, far] = &mut octaves[(distance.to_bits() >> 52) as usize];
        (*near, *far) = (near.min(distance), far.max(distance));
    }
    let mut reach = range;
    let start = octaves.into_iter().find_map(|[near, far]| {
        let is_isolated = near < f64::INFINITY && near > ISOLATED * reach;
        reach = reach.max(far);
        is_isolated.then_some(near)
    })?;
    let ends = |is_far: bool| {
        finite()
            .filter(|z| (distance(*z) >= start) == is_far)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    };
    let ([low, high], [first, last]) = (ends(false), ends(true));
    let found = finite().filter(|z| distance(*z) >= start).count();
    let found = if found == 1 {
        format!("1 height, {first:e}, is")
    } else {
        format!("{found} heights, {first:e} to {last:e}, are")
    };
    Some(format!(
        "{found} far outside all others, {low:e} to {high:e}; they may be damaged or denote missing points, which must \
         be nan"
    ))
}

/// Returns a warning with the lowest or highest height if it is far outside all others, and either occurs repeatedly or
/// is used by programs for missing points, and the number of such heights.
fn marks(heights: &Array2<f64>) -> Option<(String, usize)> {
    let mut all = 0;
    let listed: Vec<String> = doubtful(heights)
        .map(|(height, count)| {
            all += count;
            let height = if height.abs() < HUGE { height.to_string() } else { format!("{height:e}") };
            format!("{height} at {count} point{}", if count == 1 { "" } else { "s" })
        })
        .collect();
    (!listed.is_empty()).then(|| {
        let text = format!(
            "the height is {}, far outside all others; this may denote missing points, which must be nan",
            listed.join(" and ")
        );
        (text, all)
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

    fn warning(heights: &Array2<f64>) -> Option<String> {
        super::warning(heights, None)
    }

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

    /// Returns 60 x 50 rough heights of size `scale`.
    fn rough(scale: f64) -> Array2<f64> {
        let sum = |a: f64, b: f64| (1.3 * a + 0.2 * b).sin() + (0.7 * b - 0.1 * a).cos() + (2.9 * a * b).sin();
        Array2::from_shape_fn((60, 50), |(i, j)| scale * sum(i as f64, j as f64))
    }

    #[test]
    fn heights_far_outside_all_others_are_counted() {
        for scale in [1e-8, 1.0, 35.0] {
            for far in [1e5, -1e5, -2e8, 1e8] {
                for count in [1, 7, 100] {
                    let mut heights = rough(scale);
                    let step = heights.len() / count;
                    heights.iter_mut().step_by(step).take(count).enumerate().for_each(|(k, height)| {
                        *height = scale * far * (1.0 + 0.01 * k as f64);
                    });
                    let text = warning(&heights).unwrap();
                    let start = if count == 1 { "1 height, ".to_owned() } else { format!("{count} heights, ") };
                    assert!(text.starts_with(&start) && text.contains(" far outside all others, "), "{text}");
                }
            }
        }
    }

    #[test]
    fn pits_and_steps_of_a_rough_surface_are_no_damage() {
        assert_eq!(warning(&rough(1e-8)), None);
        let with = |fraction: usize, height: &dyn Fn(usize) -> f64| {
            let mut heights = rough(1.0);
            heights.iter_mut().take(3000 / fraction).enumerate().for_each(|(k, z)| *z += height(k));
            heights
        };
        // Pits of 100 interquartile ranges, a step of a tenth of the surface, a pit with walls, a spike on a plane.
        for heights in [
            with(50, &|_| -200.0),
            with(3000, &|_| -200.0),
            with(9, &|_| 1e6),
            with(30, &|k| -1e6 * 2_f64.powi(-(k as i32) / 4)),
            Array2::from_shape_fn((60, 50), |(i, j)| f64::from((i, j) == (3, 4))),
            Array2::from_shape_fn((60, 50), |(i, j)| (-0.3 * (i * i + j * j) as f64).exp()),
        ] {
            assert_eq!(warning(&heights), None);
        }
    }

    #[test]
    fn no_height_is_larger_than_a_mountain() {
        let heights = rough(1.0 / 3.0);
        for (unit, factor, says) in [
            (Some("m"), 4e4, "10000 m"),
            (Some("nm"), 4e13, "10000 m"),
            (None, 4e30, "1e30"),
            (Some("px"), 4e30, "1e30"),
        ] {
            let text = super::warning(&(&heights * factor), unit).unwrap();
            assert!(text.contains(&format!(" of 3000 heights are larger than {says}, up to ")), "{text}");
            assert_eq!(super::warning(&(&heights * (factor / 4.0)), unit), None);
        }
    }
}
