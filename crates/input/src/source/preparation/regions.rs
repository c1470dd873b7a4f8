//! Named points of a scan.

use std::fmt;
use std::str::FromStr;

use gfmd_field::Grid;
use gfmd_files::Topography;
use gfmd_problem::key;
use ndarray::Array2;

use super::values::{Box2, as_text, number};
use crate::failure::Failure;

/// Points of a scan.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// A box.
    Box(Box2),
    /// Heights below one.
    Below(f64),
    /// Heights above one.
    Above(f64),
    /// Points of a height map that are not 0.
    File(String),
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(height) = text.strip_prefix("below:") {
            return number(height).map(Self::Below);
        }
        if let Some(height) = text.strip_prefix("above:") {
            return number(height).map(Self::Above);
        }
        let begins = |c: char| c.is_ascii_digit() || matches!(c, '.' | ':' | '-' | '+');
        match text.contains(':') && text.starts_with(begins) {
            true => text.parse().map(Self::Box),
            false if text.is_empty() => Err("it must be X0:X1,Y0:Y1, below:Z, above:Z or a file".into()),
            false => Ok(Self::File(text.into())),
        }
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Box(part) => part.fmt(f),
            Self::Below(height) => write!(f, "below:{height:?}"),
            Self::Above(height) => write!(f, "above:{height:?}"),
            Self::File(name) => f.write_str(name),
        }
    }
}

as_text!(Region);

/// Returns the points of a scan that lie in one of the regions.
///
/// # Errors
/// Returns an error for a box outside the scan, a file that cannot be read or has other points, and regions without a
/// point.
pub(super) fn points(
    option: &'static str,
    regions: &[Region],
    heights: &Array2<f64>,
    grid: &Grid,
) -> Result<Array2<bool>, Failure> {
    let mut all = Array2::from_elem(heights.dim(), false);
    for region in regions {
        let refuse = |reason: String| Failure::input(key(option), format!("{region}: {reason}"));
        let found = match region {
            Region::Below(limit) => heights.mapv(|height| height < *limit),
            Region::Above(limit) => heights.mapv(|height| height > *limit),
            Region::Box(part) => {
                let (ranges, spacing, lengths) = (part.ranges(grid.lengths()), grid.spacing(), grid.lengths());
                let sides = if grid.is_line() { 1 } else { 2 };
                for axis in 0..sides {
                    let range = &ranges[axis];
                    if !(range.start < range.end && range.end > 0.0 && range.start < lengths[axis]) {
                        let allowed = format!("the box must lie in the scan, which is {:?} long", lengths[axis]);
                        return Err(refuse(allowed));
                    }
                }
                let is_in = |axis: usize, index: usize| {
                    let tolerance = 1e-9 * lengths[axis];
                    let place = index as f64 * spacing[axis] + tolerance;
                    axis >= sides || (ranges[axis].start <= place && place < ranges[axis].end)
                };
                Array2::from_shape_fn(heights.dim(), |(i, j)| is_in(0, i) && is_in(1, j))
            }
            Region::File(name) => {
                let map = Topography::read(name, None).map_err(|error| refuse(error.to_string()))?;
                if map.heights.dim() != heights.dim() {
                    let ([nx, ny], [mx, my]): ([usize; 2], [usize; 2]) =
                        (heights.dim().into(), map.heights.dim().into());
                    return Err(refuse(format!(
                        "it has {mx} x {my} points; it must have those of the scan, {nx} x {ny}"
                    )));
                }
                map.heights.mapv(|value| value != 0.0)
            }
        };
        if !found.iter().any(|is_in| *is_in) {
            return Err(refuse("it has no point of the scan".into()));
        }
        all.zip_mut_with(&found, |all, found| *all |= found);
    }
    Ok(all)
}
