use std::ops::Range;

use gfmd_vector::Split;
use ndarray::{ArcArray2, Array2, ArrayRef2, ArrayView2};

/// Heights of a rigid surface `[x, y]`, in length, with peaks towards the body. They come from an array that is copied,
/// or from one that contacts share with their caller.
#[derive(Clone, Copy, Debug)]
pub struct Heights<'a> {
    values: Values<'a>,
    unit: f64,
}

#[derive(Clone, Copy, Debug)]
enum Values<'a> {
    Copied(&'a ArrayRef2<f64>),
    Shared(&'a ArcArray2<f64>),
}

impl<'a> From<&'a ArrayRef2<f64>> for Heights<'a> {
    fn from(heights: &'a ArrayRef2<f64>) -> Self {
        Self { values: Values::Copied(heights), unit: 1.0 }
    }
}

impl<'a> From<&'a Array2<f64>> for Heights<'a> {
    fn from(heights: &'a Array2<f64>) -> Self {
        Self { values: Values::Copied(heights), unit: 1.0 }
    }
}

impl<'a> From<&'a ArrayView2<'_, f64>> for Heights<'a> {
    fn from(heights: &'a ArrayView2<f64>) -> Self {
        Self { values: Values::Copied(heights), unit: 1.0 }
    }
}

/// Heights that are shared, unless they are not in standard order.
impl<'a> From<&'a ArcArray2<f64>> for Heights<'a> {
    fn from(heights: &'a ArcArray2<f64>) -> Self {
        Self { values: Values::Shared(heights), unit: 1.0 }
    }
}

impl Heights<'_> {
    /// Returns the heights in a `unit` of length, a power of two, so that no digit is lost.
    #[must_use]
    pub fn in_unit(self, unit: f64) -> Self {
        Self { unit: self.unit * unit, ..self }
    }

    /// Returns the shape of the array.
    pub(crate) fn shape(&self) -> [usize; 2] {
        match self.values {
            Values::Copied(heights) => heights.dim().into(),
            Values::Shared(heights) => heights.dim().into(),
        }
    }

    /// Returns an array in standard order, and its unit.
    pub(crate) fn shared(&self) -> (ArcArray2<f64>, f64) {
        let copied = |heights: &ArrayRef2<f64>| heights.as_standard_layout().into_owned().into_shared();
        let heights = match self.values {
            Values::Shared(heights) if heights.is_standard_layout() => heights.clone(),
            Values::Shared(heights) => copied(heights),
            Values::Copied(heights) => copied(heights),
        };
        (heights, self.unit)
    }
}

/// Clearance, max h − h ≥ 0, of the points of a surface: the distance of each from the highest one, in length. It is
/// computed from the heights.
#[derive(Clone, Copy, Debug)]
pub struct Clearance<'a> {
    heights: &'a [f64],
    top: f64,
    unit: f64,
    approach: f64,
}

impl<'a> Clearance<'a> {
    /// Returns the distance of the `heights` from a plane at the height `top`.
    pub fn below(top: f64, heights: &'a [f64]) -> Self {
        Self { heights, top, unit: 1.0, approach: 0.0 }
    }

    /// Returns the clearance in a unit of length, a power of two.
    pub(crate) fn in_unit(self, unit: f64) -> Self {
        Self { unit, ..self }
    }

    /// Returns the clearance after the surface moved towards the body.
    pub(crate) fn after(self, approach: f64) -> Self {
        Self { approach, ..self }
    }

    /// Returns the number of points.
    #[allow(clippy::len_without_is_empty, reason = "a surface has points")]
    pub fn len(&self) -> usize {
        self.heights.len()
    }

    /// Returns the clearance of a point.
    #[inline]
    pub fn at(&self, point: usize) -> f64 {
        self.of(self.heights[point])
    }

    #[inline]
    fn of(&self, height: f64) -> f64 {
        (self.top - height) / self.unit - self.approach
    }

    /// Returns the clearance of a range of points.
    #[must_use]
    pub fn part(self, points: Range<usize>) -> Self {
        Self { heights: &self.heights[points], ..self }
    }

    /// Returns the clearance of all points, one after another.
    pub fn iter(self) -> impl ExactSizeIterator<Item = f64> + Clone + 'a {
        self.heights.iter().map(move |height| self.of(*height))
    }

    /// Returns the clearance of all points as a vector.
    pub fn to_vec(self) -> Vec<f64> {
        self.iter().collect()
    }
}

impl Split for Clearance<'_> {
    fn length(&self) -> usize {
        self.len()
    }

    fn split(self, middle: usize) -> (Self, Self) {
        (self.part(0..middle), self.part(middle..self.len()))
    }
}
