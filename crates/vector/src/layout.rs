use std::borrow::Cow;

use ndarray::{ArrayRef, Dimension};

/// Returns the values of an array row by row: borrowed if they are stored in this order, otherwise copied.
///
/// ```
/// use gfmd_vector::contiguous;
/// use ndarray::array;
///
/// let field = array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
/// assert_eq!(*contiguous(&field), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// assert_eq!(*contiguous(&field.t()), [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
/// ```
pub fn contiguous<T: Clone, D: Dimension>(array: &ArrayRef<T, D>) -> Cow<'_, [T]> {
    array.as_slice().map_or_else(|| array.iter().cloned().collect::<Vec<T>>().into(), Cow::Borrowed)
}

/// Calls `change` with the values of an array row by row and stores the result, for any layout in memory.
pub fn with_contiguous<T: Clone, D: Dimension>(array: &mut ArrayRef<T, D>, change: impl FnOnce(&mut [T])) {
    if let Some(values) = array.as_slice_mut() {
        return change(values);
    }
    let mut values: Vec<T> = array.iter().cloned().collect();
    change(&mut values);
    array.iter_mut().zip(values).for_each(|(old, new)| *old = new);
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, s};

    use super::*;

    #[test]
    fn values_come_row_by_row_from_every_layout() {
        let plain = Array2::from_shape_fn((3, 4), |(i, j)| 4 * i + j);
        let numbers: Vec<usize> = (0..12).collect();
        let mut wide = Array2::zeros((6, 8));
        let turned = plain.t().as_standard_layout().into_owned().reversed_axes();
        assert!(turned.as_slice().is_none());
        wide.slice_mut(s![..;2, ..;2]).assign(&plain);
        for values in [contiguous(&plain), contiguous(&turned), contiguous(&wide.slice(s![..;2, ..;2]))] {
            assert_eq!(*values, numbers);
        }
        assert!(matches!(contiguous(&plain), Cow::Borrowed(_)));
    }

    #[test]
    fn changes_reach_every_layout() {
        let mut plain = Array2::from_shape_fn((3, 4), |(i, j)| 4 * i + j);
        let mut turned = plain.t().as_standard_layout().into_owned().reversed_axes();
        let double = |values: &mut [usize]| values.iter_mut().enumerate().for_each(|(i, x)| *x += i);
        with_contiguous(&mut plain, double);
        with_contiguous(&mut turned, double);
        assert!(plain.indexed_iter().all(|((i, j), x)| *x == 2 * (4 * i + j)));
        assert_eq!(plain, turned);
    }
}
