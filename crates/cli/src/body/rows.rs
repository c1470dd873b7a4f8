//! Points of a plane to keep: all, or one row.

use std::fmt;
use std::str::FromStr;

use gfmd_field::Grid;
use gfmd_problem::key;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::quantity::AXES;
use gfmd_input::failure::Failure;

/// Plane across an axis (0 is x, 1 is y, 2 is z) and its position: x or y of a row of points, or the height z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    axis: usize,
    position: f64,
}

impl Slice {
    /// Returns the axis normal to the plane.
    pub(super) fn axis(self) -> usize {
        self.axis
    }

    /// Returns the height of a plane z = const.
    pub(super) fn height(self) -> Option<f64> {
        (self.axis == 2).then_some(self.position)
    }
}

impl FromStr for Slice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(name, position)| {
            let axis = AXES.iter().position(|axis| *axis == name)?;
            Some(Self { axis, position: position.parse().ok()? })
        });
        parts.ok_or_else(|| "it must be x=POSITION, y=POSITION or z=HEIGHT".into())
    }
}

impl fmt::Display for Slice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={:?}", AXES[self.axis], self.position)
    }
}

impl<'de> Deserialize<'de> for Slice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

impl Serialize for Slice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Points of a plane, and the axes along which they lie.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    /// Row with the position of its points, or plane; `None` for all points or a line.
    pub(super) slice: Option<Slice>,
    /// Axes along which the points lie: 0 is x, 1 is y.
    pub(super) axes: Vec<usize>,
    /// Indices of the points in a field.
    pub(super) points: Vec<usize>,
}

impl Rows {
    /// Selects the row nearest to `slice`, or all points.
    pub(super) fn new(slice: Option<Slice>, grid: &Grid) -> Result<Self, Failure> {
        let all = |slice| {
            let axes = if grid.is_line() { vec![0] } else { vec![0, 1] };
            Self { slice, axes, points: (0..grid.len()).collect() }
        };
        let Some(slice) = slice else { return Ok(all(None)) };
        if slice.height().is_some() {
            return Ok(all(Some(slice)));
        }
        let (name, length) = (AXES[slice.axis], grid.lengths()[slice.axis]);
        if grid.is_line() {
            return Err(Failure::value(key("slice"), slice, "left out for a line"));
        }
        if !(0.0..length).contains(&slice.position) {
            return Err(Failure::contradicts(
                key("slice"),
                slice,
                format!("{name} must be at least 0 and below {length}"),
            ));
        }
        let count = grid.points()[slice.axis];
        let index = (slice.position / grid.spacing()[slice.axis]).round() as usize % count;
        Ok(Self::row(slice.axis, index, grid))
    }

    /// Returns the middle row along x.
    pub(super) fn middle(grid: &Grid) -> Self {
        Self::row(1, grid.points()[1] / 2, grid)
    }

    fn row(axis: usize, index: usize, grid: &Grid) -> Self {
        let ([nx, ny], position) = (grid.points(), index as f64 * grid.spacing()[axis]);
        let points = match axis {
            0 => (0..ny).map(|j| index * ny + j).collect(),
            _ => (0..nx).map(|i| i * ny + index).collect(),
        };
        Self { slice: Some(Slice { axis, position }), axes: vec![1 - axis], points }
    }

    /// Returns the row on which `--slice` lies, if it selects one.
    pub(super) fn selected(&self) -> Option<Slice> {
        self.slice.filter(|slice| slice.height().is_none())
    }

    /// Returns true if the points are a plane of constant height.
    pub(super) fn is_level(&self) -> bool {
        self.slice.is_some_and(|slice| slice.height().is_some())
    }

    /// Returns the number of points kept along x and y.
    pub(super) fn shape(&self, grid: &Grid) -> [usize; 2] {
        [0, 1].map(|axis| if self.axes.contains(&axis) { grid.points()[axis] } else { 1 })
    }

    /// Returns the position of the first point along x and y.
    pub(super) fn origin(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.slice.filter(|slice| slice.axis == axis).map_or(0.0, |slice| slice.position))
    }
}
