//! Division of vectors into stretches.

/// One or several vectors of equal length that are cut at the same places: slices, shared or mutable, and arrays and
/// tuples of them. `()` stands for no vector, of any length.
pub trait Split: Send + Sized {
    /// Returns the number of values.
    fn length(&self) -> usize;

    /// Returns true if all vectors have this `length`.
    fn fits(&self, length: usize) -> bool {
        self.length() == length
    }

    /// Cuts at `middle`, which is at most the length.
    fn split(self, middle: usize) -> (Self, Self);

    /// Iterates over stretches of `length` values; the last one may be shorter.
    fn parts(self, length: usize) -> Parts<Self> {
        Parts { rest: Some(self), length }
    }
}

impl<T: Send> Split for &mut [T] {
    fn length(&self) -> usize {
        self.len()
    }

    fn split(self, middle: usize) -> (Self, Self) {
        self.split_at_mut(middle)
    }
}

impl<T: Sync> Split for &[T] {
    fn length(&self) -> usize {
        self.len()
    }

    fn split(self, middle: usize) -> (Self, Self) {
        self.split_at(middle)
    }
}

impl Split for () {
    fn length(&self) -> usize {
        usize::MAX
    }

    fn fits(&self, _: usize) -> bool {
        true
    }

    fn split(self, _: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<V: Split, const M: usize> Split for [V; M] {
    fn length(&self) -> usize {
        self.first().map_or(0, V::length)
    }

    fn fits(&self, length: usize) -> bool {
        self.iter().all(|vector| vector.fits(length))
    }

    fn split(self, middle: usize) -> (Self, Self) {
        let mut right = [const { None }; M];
        let mut rest = right.iter_mut();
        let left = self.map(|vector| {
            let (left, right) = vector.split(middle);
            if let Some(rest) = rest.next() {
                *rest = Some(right);
            }
            left
        });
        (left, right.map(|vector| vector.expect("every vector has a right part")))
    }
}

/// Vector of rows with a fixed number of columns; its length is the number of rows.
pub struct Rows<V>(pub V, pub usize);

impl<V: Split> Split for Rows<V> {
    fn length(&self) -> usize {
        self.0.length() / self.1
    }

    fn fits(&self, rows: usize) -> bool {
        self.0.fits(rows * self.1)
    }

    fn split(self, middle: usize) -> (Self, Self) {
        let Self(vector, columns) = self;
        let (above, below) = vector.split(middle * columns);
        (Self(above, columns), Self(below, columns))
    }
}

macro_rules! tuples {
    ($($vector:ident $place:tt),*) => {
        impl<$($vector: Split),*> Split for ($($vector,)*) {
            fn length(&self) -> usize {
                usize::MAX$(.min(self.$place.length()))*
            }

            fn fits(&self, length: usize) -> bool {
                true $(&& self.$place.fits(length))*
            }

            fn split(self, middle: usize) -> (Self, Self) {
                let both = ($(self.$place.split(middle),)*);
                (($(both.$place.0,)*), ($(both.$place.1,)*))
            }
        }
    };
}

tuples!(A 0, B 1);
tuples!(A 0, B 1, C 2);
tuples!(A 0, B 1, C 2, D 3);
tuples!(A 0, B 1, C 2, D 3, E 4);

/// Iterator returned by [`Split::parts`].
pub struct Parts<V> {
    rest: Option<V>,
    length: usize,
}

impl<V: Split> Iterator for Parts<V> {
    type Item = V;

    fn next(&mut self) -> Option<V> {
        let rest = self.rest.take()?;
        if rest.length() <= self.length {
            return (rest.length() > 0).then_some(rest);
        }
        let (part, rest) = rest.split(self.length);
        self.rest = Some(rest);
        Some(part)
    }
}
