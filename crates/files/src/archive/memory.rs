use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hdf5::H5Type;
use ndarray::ArrayD;

/// The variables of a result in memory instead of a file: numbers as `f64`, without coordinates, texts and attributes.
#[derive(Clone, Debug, Default)]
pub struct Memory(Arc<Mutex<BTreeMap<String, ArrayD<f64>>>>);

/// A number that an [`Archive`](super::Archive) writes.
pub trait Value: H5Type + Copy + Default + Sync {
    /// The number as `f64`.
    fn real(self) -> f64;
}

macro_rules! values {
    ($($number:ty)+) => {$(
        impl Value for $number {
            fn real(self) -> f64 {
                self as f64
            }
        }
    )+};
}

values! { f32 f64 u8 u32 u64 i64 }

impl Memory {
    /// Removes the variables and returns them by path.
    pub fn take(&self) -> BTreeMap<String, ArrayD<f64>> {
        std::mem::take(&mut *self.variables())
    }

    /// Stores a variable with all its values.
    pub(super) fn put<T: Value>(&self, path: &str, shape: &[usize], values: &[T]) {
        let mut values = values.iter().copied().map(T::real);
        self.variables().insert(path.into(), ArrayD::from_shape_simple_fn(shape, || values.next().unwrap_or(f64::NAN)));
    }

    /// The shape of a variable; empty if there is none.
    pub(super) fn shape(&self, path: &str) -> Vec<usize> {
        self.variables().get(path).map_or_else(Vec::new, |values| values.shape().to_vec())
    }

    /// Writes values into a variable from index `start`, row-major; `None` beyond its end.
    pub(super) fn write(&self, path: &str, start: usize, values: &[f64]) -> Option<()> {
        let mut variables = self.variables();
        let all = variables.get_mut(path)?.as_slice_mut()?;
        all.get_mut(start..start.checked_add(values.len())?)?.copy_from_slice(values);
        Some(())
    }

    fn variables(&self) -> MutexGuard<'_, BTreeMap<String, ArrayD<f64>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
