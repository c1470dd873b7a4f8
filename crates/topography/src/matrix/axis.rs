//! Lattices of coordinates, which may be rounded to the digits written.

/// Largest distance of a coordinate from its lattice point that counts as rounding, in spacings.
const OFF: f64 = 0.05;

/// Largest deviation from even spacing that counts as arithmetic error, in spacings.
const EVEN: f64 = 1e-6;

/// Range of the share of steps longer than one unit of the last digit that indicates rounding; gaps hardly give it.
const MIXED: [f64; 2] = [0.2, 0.8];

/// Smallest number of coordinates for which rounding can be distinguished from gaps.
const TOLD: usize = 8;

/// Largest ratio of lattice points to coordinates written as whole numbers.
const GAPS: f64 = 1.3;

/// Smallest spacing, in units of the last digit, that rounding does not hide.
const COARSE: f64 = 3.5;

/// Largest step, relative to the largest of all, that is rounding between points of one column.
const ALIKE: f64 = 0.1;

/// Largest ratio of lattice points to the points of a profile.
const SPARSEST: f64 = 1.5;

/// Evenly spaced coordinates.
#[derive(Debug, PartialEq)]
pub(super) struct Axis {
    first: f64,
    pub(super) step: f64,
    pub(super) count: usize,
    /// Coordinates as written and half the range of spacings that they allow, if they are rounded.
    rounded: Option<(Vec<f64>, f64)>,
}

impl Axis {
    /// Finds the lattice of coordinates, each with any number of occurrences. `digits` are the smallest and largest
    /// unit of the last digit written. Returns `None` if there is no lattice.
    ///
    /// # Errors
    /// Coordinates that may be rounded, or may have gaps.
    pub(super) fn of(coordinates: &[f64], digits: [f64; 2]) -> Result<Option<Self>, String> {
        let [smallest, _] = digits;
        let places = distinct(coordinates);
        if let Some(axis) = Self::even(&places) {
            return Ok(Some(axis));
        }
        let whole = smallest >= 1.0;
        if let Some((axis, digit)) = Self::fitted(&places, digits) {
            let long = longer(&places, digit);
            let is_rounded = axis.step >= 2.0 * digit
                || long == 1.0
                || places.len() >= TOLD && (MIXED[0]..=MIXED[1]).contains(&long);
            match (is_rounded, whole) {
                (true, _) => return Ok(Some(axis)),
                (false, true) => {}
                (false, false) => return Err(unclear(smallest)),
            }
        }
        let Some(axis) = Self::on_lattice(coordinates, ALIKE, coordinates.len() as f64) else { return Ok(None) };
        let most = if whole { GAPS } else { 1.0 };
        let is_coarse = axis.step < COARSE * smallest && axis.count as f64 > most * places.len() as f64;
        if is_coarse { Err(unclear(smallest)) } else { Ok(Some(axis)) }
    }

    /// Finds the lattice of rising coordinates, each once, where points may be missing; `None` if there is none.
    ///
    /// # Errors
    /// Coordinates that may be rounded, or may have gaps.
    pub(super) fn rising(places: &[f64], digits: [f64; 2]) -> Result<Option<Self>, String> {
        let ([digit, _], points) = (digits, places.len() as f64);
        if !places.windows(2).all(|pair| pair[1] > pair[0]) {
            return Ok(None);
        }
        if let Some(axis) = Self::even(places) {
            return Ok(Some(axis));
        }
        let whole = digit >= 1.0;
        let lattice = Self::on_lattice(places, 0.0, 2.0 * points);
        let gaps = lattice.as_ref().filter(|axis| axis.count > places.len());
        let is_coarse = |axis: &Self| axis.step < COARSE * digit;
        let few = |axis: &Self| axis.count as f64 <= if whole { GAPS * points } else { points };
        match (Self::fitted(places, digits), gaps) {
            (Some((axis, _)), None) => Ok(Some(axis)),
            (Some((axis, unit)), Some(gaps)) if is_coarse(gaps) => {
                let long = longer(places, unit);
                match axis.step >= 2.0 * unit || long == 1.0 || places.len() >= TOLD && long >= MIXED[0] {
                    true => Ok(Some(axis)),
                    false if few(gaps) => Ok(lattice),
                    false => Err(unclear(digit)),
                }
            }
            (None, Some(gaps)) if is_coarse(gaps) && !few(gaps) => Err(unclear(digit)),
            _ => Ok(lattice.filter(|axis| axis.count as f64 <= SPARSEST * points)),
        }
    }

    /// Returns true if each coordinate is the next point of a lattice, rising or falling, within the digits written.
    pub(super) fn is_progression(coordinates: &[f64], digits: [f64; 2]) -> bool {
        let next = |axis: Option<Self>| axis.is_some_and(|axis| axis.count == coordinates.len());
        let even = |places: &[f64]| {
            places.windows(2).all(|pair| pair[1] > pair[0])
                && (next(Self::even(places))
                    || Self::fitted(places, digits)
                        .is_some_and(|(axis, digit)| axis.step >= 3.0 * digit || places.len() >= TOLD))
        };
        even(coordinates) || even(&coordinates.iter().rev().copied().collect::<Vec<_>>())
    }

    /// Returns the axis of rising coordinates that are evenly spaced up to arithmetic errors.
    fn even(places: &[f64]) -> Option<Self> {
        let (first, last) = (*places.first()?, *places.last()?);
        if !(last - first).is_finite() || last <= first {
            return None;
        }
        let step = (last - first) / (places.len() - 1) as f64;
        let most = EVEN * step + 4.0 * f64::EPSILON * first.abs().max(last.abs());
        let is_even = |(index, place): (usize, &f64)| (place - first - index as f64 * step).abs() <= most;
        let axis = Self { first, step, count: places.len(), rounded: None };
        places.iter().enumerate().all(is_even).then_some(axis)
    }

    /// Returns the axis of rising coordinates rounded to the smallest or else the largest unit, and this unit.
    fn fitted(places: &[f64], digits: [f64; 2]) -> Option<(Self, f64)> {
        digits.into_iter().find_map(|digit| Self::fitted_to(places, digit).map(|axis| (axis, digit)))
    }

    /// Returns the middle of all axes that give the rising coordinates when rounded to the last digit.
    fn fitted_to(places: &[f64], digit: f64) -> Option<Self> {
        let (first, last) = (*places.first()?, *places.last()?);
        let steps = places.len().checked_sub(1).filter(|steps| *steps > 0)? as f64;
        if !(last - first).is_finite() || last <= first || !(digit > 0.0 && digit.is_finite()) {
            return None;
        }
        // Range of the first points that the coordinates imply for a spacing.
        let range = |step: f64| {
            places.iter().enumerate().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (index, place)| {
                let found = place - index as f64 * step;
                [low.min(found), high.max(found)]
            })
        };
        let width = |step: f64| {
            let [low, high] = range(step);
            high - low
        };
        let most = digit * (1.0 + 1e-9) + 8.0 * f64::EPSILON * first.abs().max(last.abs());
        let [mut low, mut high] = [-1.0, 1.0].map(|sign| (last - first + sign * most) / steps);
        let ends = [low, high];
        // The width is a convex function of the spacing.
        for _ in 0..SEARCHES {
            let [left, right] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if width(left) <= most {
                (low, high) = (left, left);
            } else if width(right) <= most {
                (low, high) = (right, right);
            } else if width(left) < width(right) {
                high = right;
            } else {
                low = left;
            }
        }
        let inside = f64::midpoint(low, high);
        let fits = width(inside) <= most;
        if !fits {
            return None;
        }
        let [low, high] = ends.map(|end| {
            let [mut inside, mut outside] = [inside, end];
            for _ in 0..SEARCHES {
                let middle = f64::midpoint(inside, outside);
                if width(middle) <= most { inside = middle } else { outside = middle }
            }
            inside
        });
        let step = f64::midpoint(low, high);
        let [lowest, highest] = range(step);
        let first = f64::midpoint(lowest, highest);
        (step > 0.0).then(|| Self {
            first,
            step,
            count: places.len(),
            rounded: Some((places.to_vec(), 0.5 * (high - low))),
        })
    }

    /// Finds the lattice of at most `most` intervals of coordinates with gaps, where coordinates may be off by a part
    /// of the spacing. Steps below a share `alike` of the largest are rounding between points of one column.
    fn on_lattice(coordinates: &[f64], alike: f64, most: f64) -> Option<Self> {
        let mut sorted = coordinates.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (first, last) = (*sorted.first()?, *sorted.last()?);
        if !(last - first).is_finite() || last <= first {
            return None;
        }
        let steps = || sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let largest = steps().fold(0.0, f64::max);
        let smallest = steps().filter(|step| *step > alike * largest).fold(f64::INFINITY, f64::min);
        let single = || steps().filter(|step| *step > alike * largest && *step < 1.5 * smallest);
        let mean = single().sum::<f64>() / single().count() as f64;
        let intervals = ((last - first) / mean).round();
        if intervals > most {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from zero to the number of coordinates"
        )]
        let axis = Self { first, step: (last - first) / intervals, count: intervals as usize + 1, rounded: None };
        let off = |x: f64| (x - first) / axis.step - ((x - first) / axis.step).round();
        sorted.iter().all(|&x| off(x).abs() <= OFF).then_some(axis)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a coordinate of the axis, which begins at the first"
    )]
    pub(super) fn index(&self, coordinate: f64) -> usize {
        match &self.rounded {
            Some((places, _)) => places.partition_point(|place| *place < coordinate).min(self.count - 1),
            None => (((coordinate - self.first) / self.step).round() as usize).min(self.count - 1),
        }
    }

    /// Returns the length: the spacing times the number of points.
    pub(super) fn length(&self) -> f64 {
        self.step * self.count as f64
    }

    /// Returns a note on a spacing that follows from rounded coordinates.
    pub(super) fn note(&self, name: &str) -> Option<String> {
        let (_, half) = self.rounded.as_ref()?;
        Some(format!(
            "the coordinates {name} are rounded; a spacing of {:.6e}, within {:.1e}, agrees with their digits \
             (a given size is exact)",
            self.step, half
        ))
    }
}

/// Number of steps of a search by halves or thirds.
const SEARCHES: usize = 60;

/// Returns the reason for refusing coordinates whose last digit has the unit `digit`.
fn unclear(digit: f64) -> String {
    format!(
        "they are written to {digit:e} only, and may be rounded or have gaps; more digits must be written, or all \
         points, or a matrix"
    )
}

/// Returns the share of the steps of rising coordinates that are longer than one unit of the last digit.
fn longer(places: &[f64], digit: f64) -> f64 {
    let is_long = |pair: &&[f64]| ((pair[1] - pair[0]) / digit).round() > 1.5;
    places.windows(2).filter(is_long).count() as f64 / (places.len() - 1) as f64
}

/// Returns the distinct coordinates, rising.
fn distinct(coordinates: &[f64]) -> Vec<f64> {
    let mut sorted = coordinates.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    sorted
}

/// Returns the number of distinct coordinates.
pub(super) fn count(coordinates: &[f64]) -> usize {
    distinct(coordinates).len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(step: f64, points: impl IntoIterator<Item = u32>, digit: f64) -> Vec<f64> {
        points.into_iter().map(|k| (f64::from(k) * step / digit).round() * digit).collect()
    }

    #[test]
    fn rounded_coordinates_have_the_spacing_that_their_digits_allow() {
        for (step, count) in [(0.15625, 12), (0.15625, 200), (0.1 / 3.0 * 4.0, 9), (0.7312, 30), (33.333_333, 8)] {
            let found = Axis::of(&rounded(step, 0..count, 0.1), [0.1; 2]).unwrap().unwrap();
            let allowed = found.rounded.as_ref().unwrap().1;
            assert_eq!(found.count, count as usize);
            assert!((found.step - step).abs() <= allowed * (1.0 + 1e-6), "{step} {found:?}");
            // The digits leave a range of spacings that shrinks with the number of points.
            assert!(allowed < 0.1 / f64::from(count - 1), "{step} {allowed}");
            let found = Axis::rising(&rounded(step, 0..count, 0.1), [0.1; 2]).unwrap().unwrap();
            assert_eq!(found.index(found.rounded.as_ref().unwrap().0[3]), 3);
        }
        // Not rounded: the spacing follows from the ends, to the bit.
        let exact = Axis::of(&[0.0, 0.5, 1.5, 1.0, 0.5], [0.1; 2]).unwrap().unwrap();
        assert_eq!((exact.step, exact.count, exact.rounded), (0.5, 4, None));
    }

    #[test]
    fn gaps_are_no_rounding() {
        // A column is missing, in a lattice with several digits and in one with whole numbers.
        let gap = |step: f64, digit| Axis::of(&rounded(step, (0..12).filter(|k| *k != 5), digit), [digit; 2]);
        assert_eq!(gap(0.5, 0.1).unwrap().unwrap().count, 12);
        assert_eq!(gap(1.0, 1.0).unwrap().unwrap().count, 12);
        // With one digit, and rounded: either is possible.
        assert!(gap(0.1, 0.1).unwrap_err().starts_with("they are written to 1e-1 only"));
        let twice = |k: u32| [k, k];
        assert!(Axis::of(&rounded(0.15625, (0..12).filter(|k| *k != 5).flat_map(twice), 0.1), [0.1; 2]).is_err());
        let profile = |step: f64, digits| Axis::rising(&rounded(step, (0..12).filter(|k| *k != 5), 0.01), digits);
        assert_eq!(profile(0.5, [0.1; 2]).unwrap().unwrap().count, 12);
        assert_eq!(profile(0.5, [0.1, 1.0]).unwrap().unwrap().count, 12);
        assert_eq!(profile(1.0, [1.0; 2]).unwrap().unwrap().count, 12);
        assert!(profile(0.1, [0.1; 2]).is_err() && profile(0.1, [0.1, 1.0]).is_err());
        // More than a third is missing, or the places are uneven.
        assert_eq!(Axis::rising(&[0.0, 0.5, 1.0, 2.0, 3.5], [0.01; 2]), Ok(None));
        assert_eq!(Axis::rising(&[0.0, 0.11, 0.43, 0.51, 1.0], [0.01; 2]), Ok(None));
        assert_eq!(Axis::of(&[0.0, 0.11, 0.43, 0.51, 1.0], [0.01; 2]), Ok(None));
    }
}
