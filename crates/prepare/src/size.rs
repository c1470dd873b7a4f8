//! Part of a scan, and other numbers of points.

use std::ops::Range;

use ndarray::{Array2, s};

use crate::error::value;
use crate::rows::median;
use crate::{Edges, Filter, PrepareError, smooth};

/// Part of a scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Cropped {
    /// Heights of the part.
    pub heights: Array2<f64>,
    /// Index of its first point along x and y.
    pub origin: [usize; 2],
}

/// Relative tolerance of a position.
const SAME_PLACE: f64 = 1e-9;

/// Returns the points with positions in the ranges along x and y, `start <= index * spacing < end`. The range along y
/// of a profile does not matter.
///
/// # Errors
/// A range that is empty, reversed, outside of the scan, or has fewer than 2 points.
pub fn crop(heights: &Array2<f64>, spacing: [f64; 2], ranges: [Range<f64>; 2]) -> Result<Cropped, PrepareError> {
    let (nx, ny) = heights.dim();
    let (points, mut parts) = ([nx, ny], [0..nx, 0..ny]);
    for axis in 0..if ny == 1 { 1 } else { 2 } {
        let (what, Range { start, end }) = (["crop along x", "crop along y"][axis], &ranges[axis]);
        let side = points[axis] as f64 * spacing[axis];
        let allowed = || format!("START:END with 0 <= START < END <= {side}");
        let tolerance = SAME_PLACE * side;
        let is_inside = *start >= -tolerance && *end <= side + tolerance && start < end;
        if !is_inside {
            return Err(value(what, format!("{start}:{end}"), allowed()));
        }
        let index = |place: f64| ((place - tolerance) / spacing[axis]).ceil().max(0.0) as usize;
        parts[axis] = index(*start)..index(*end).min(points[axis]);
        if parts[axis].len() < 2 {
            return Err(value(what, format!("{start}:{end}"), "a range with at least 2 points"));
        }
    }
    let [x, y] = parts;
    let origin = [x.start, y.start];
    Ok(Cropped { heights: heights.slice(s![x, y]).to_owned(), origin })
}

/// Heights on another grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    /// Heights.
    pub heights: Array2<f64>,
    /// Nesting index of the S filter before, length.
    pub index: f64,
}

/// Nesting index of the S filter before points are taken out, in new spacings.
const SPACINGS_OF_INDEX: f64 = 4.0;

/// Returns the heights on `points` equal cells, at most as many as before: a Gaussian S filter with a nesting index of
/// four new spacings, then bilinear values at the centres of the cells, or, where the surface repeats
/// ([`Edges::Periodic`] of the filter), at the new points from the first one on. Points beside undefined ones are
/// undefined.
///
/// # Errors
/// More points than before, or fewer than 2 along a side; the errors of [`smooth`].
pub fn resample(
    heights: &Array2<f64>,
    spacing: [f64; 2],
    points: [usize; 2],
    filter: Filter,
) -> Result<Resampled, PrepareError> {
    let (nx, ny) = heights.dim();
    let is_line = ny == 1;
    let (now, new) = ([nx, ny], [points[0], if is_line { 1 } else { points[1] }]);
    for axis in 0..if is_line { 1 } else { 2 } {
        if !(2..=now[axis]).contains(&new[axis]) {
            let allowed = format!("2 to {}; --refine gives a surface more points", now[axis]);
            return Err(value("number of points along a side", new[axis], allowed));
        }
    }
    let sides = if is_line { 1 } else { 2 };
    let step = (0..sides).map(|axis| spacing[axis] * now[axis] as f64 / new[axis] as f64).fold(0.0, f64::max);
    let index = SPACINGS_OF_INDEX * step;
    let mut smoothed = smooth(heights, spacing, index, filter)?.heights;
    smoothed.zip_mut_with(heights, |smooth, height| *smooth = if height.is_nan() { f64::NAN } else { *smooth });
    let is_periodic = filter.edges == Edges::Periodic;
    let places = |now: usize, new: usize| -> Vec<(usize, usize, f64)> {
        let place = |i: usize| {
            let ratio = now as f64 / new as f64;
            let x = if is_periodic { i as f64 * ratio } else { (i as f64 + 0.5) * ratio - 0.5 };
            let first = x.floor();
            let last = if is_periodic { (first as usize + 1) % now } else { (first as usize + 1).min(now - 1) };
            (first as usize, last, x - first)
        };
        (0..new).map(place).collect()
    };
    let (x, y) = (places(nx, new[0]), places(ny, new[1]));
    let part = |weight: f64, height: f64| if weight == 0.0 { 0.0 } else { weight * height };
    let at = |(i, j): (usize, usize)| {
        let ((x0, x1, u), (y0, y1, v)) = (x[i], y[j]);
        part((1.0 - u) * (1.0 - v), smoothed[[x0, y0]])
            + part(u * (1.0 - v), smoothed[[x1, y0]])
            + part((1.0 - u) * v, smoothed[[x0, y1]])
            + part(u * v, smoothed[[x1, y1]])
    };
    Ok(Resampled { heights: Array2::from_shape_fn((new[0], new[1]), at), index })
}

/// Largest gap of a profile in median spacings.
const LARGEST_GAP: f64 = 10.0;

/// Returns a profile of `points` heights at even spacing from heights at uneven places, by straight lines between them,
/// and the spacing. `None` takes the number that follows from the largest spacing.
///
/// # Errors
/// Fewer than 2 places, equal places, numbers that are not finite, a gap larger than 10 median spacings.
pub fn even(places: &[f64], heights: &[f64], points: Option<usize>) -> Result<(Vec<f64>, f64), PrepareError> {
    const WHAT: &str = "an uneven profile";
    let mut pairs: Vec<(f64, f64)> = places.iter().copied().zip(heights.iter().copied()).collect();
    if pairs.len() < 2 || places.len() != heights.len() {
        return Err(PrepareError::TooFewPoints {
            what: WHAT,
            needed: "2 places with heights".into(),
            found: pairs.len(),
        });
    }
    if let Some((x, z)) = pairs.iter().find(|(x, z)| !x.is_finite() || !z.is_finite()) {
        return Err(value("place and height of a profile", format!("{x}, {z}"), "finite"));
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let steps: Vec<f64> = pairs.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    if let Some(twice) = steps.iter().position(|step| *step == 0.0) {
        return Err(value("place of a profile", pairs[twice].0, "given once"));
    }
    let largest = steps.iter().copied().fold(0.0, f64::max);
    let usual = median(&mut steps.clone());
    if largest > LARGEST_GAP * usual {
        return Err(value(
            "largest spacing of the profile",
            largest,
            format!("at most {}, ten median spacings", LARGEST_GAP * usual),
        ));
    }
    let (first, last) = (pairs[0].0, pairs[pairs.len() - 1].0);
    let points = points.unwrap_or(((last - first) / largest).floor() as usize + 1);
    if points < 2 {
        return Err(value("number of points of the profile", points, "at least 2"));
    }
    let spacing = (last - first) / (points - 1) as f64;
    let mut interval = 0;
    let at = |i: usize| {
        let x = if i + 1 == points { last } else { first + i as f64 * spacing };
        while interval + 2 < pairs.len() && pairs[interval + 1].0 < x {
            interval += 1;
        }
        let ((x0, z0), (x1, z1)) = (pairs[interval], pairs[interval + 1]);
        z0 + (z1 - z0) * ((x - x0) / (x1 - x0))
    };
    Ok(((0..points).map(at).collect(), spacing))
}
