//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! A pass splits its vectors in halves down to [`LEAF`] values, works on the leaves in parallel, and merges the results
//! pairwise on the way back. The tree depends on the length alone, so a sum has the same bits for any number of
//! threads, and its rounding error grows with the logarithm of the length. Nothing is allocated.
//!
//! From a thread outside rayon's pool, each pass over more than one leaf hands its work over and waits, which takes
//! about ten microseconds; `rayon::scope` around many passes saves this time.
//!
//! Several processes ([`Ranks`]) may own the rows of one field: a [`Share`] passes over the rows of this process, and
//! its sums have the same bits as with one process.

mod distribute;
mod layout;
mod ranks;
mod serialise;
mod share;
mod split;
mod thread_ranks;

use std::ops::Range;
use std::sync::OnceLock;

pub use distribute::{distribute, lock};
pub use layout::{contiguous, with_contiguous};
use multiversion::multiversion;
pub use ranks::{Alone, Messages, Pending, Ranks};
pub use serialise::{Serialise, Word};
pub use share::{Share, TooManyRanks};
pub use split::{Parts, Rows, Split};
pub use thread_ranks::ThreadRanks;

/// Returns the value of a cell, computed by threads of the pool at the first call.
///
/// The value is computed outside the cell: a thread that waits for parts of the value may start a task that needs the
/// same cell, and would wait for itself in [`OnceLock::get_or_init`]. Simultaneous tasks may each compute the value;
/// all get the first one.
pub fn once<T>(cell: &OnceLock<T>, make: impl FnOnce() -> T) -> &T {
    if let Some(made) = cell.get() {
        return made;
    }
    let made = make();
    cell.get_or_init(|| made)
}

/// Number of values in one leaf of the tree: several vectors of this length fit the first-level cache, and the work on
/// them outweighs the cost of handing it to a thread.
pub const LEAF: usize = 2048;

/// Sweeps once over `vectors` of equal length, which are slices or tuples and arrays of slices. `leaf(start, parts)`
/// gets one stretch of each vector, beginning at index `start`, and `merge` joins the results of neighbouring stretches
/// in order.
///
/// # Panics
/// If the vectors differ in length.
pub fn pass<V: Split, R: Send>(
    vectors: V,
    leaf: &(impl Fn(usize, V) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    pass_by(LEAF, vectors, leaf, merge)
}

/// Runs a [`pass`] with leaves of at most `size` entries. [`Rows`] are cut between rows.
///
/// # Panics
/// If the vectors differ in length, or `size` is zero.
pub fn pass_by<V: Split, R: Send>(
    size: usize,
    vectors: V,
    leaf: &(impl Fn(usize, V) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    let length = vectors.length();
    assert!(vectors.fits(length), "the vectors of one pass must have equal lengths");
    tree(size, [0, length], vectors, leaf, merge)
}

fn tree<V: Split, R: Send>(
    size: usize,
    [start, length]: [usize; 2],
    vectors: V,
    leaf: &(impl Fn(usize, V) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    let Some(middle) = half(length, size) else { return leaf(start, vectors) };
    let (left, right) = vectors.split(middle);
    let (a, b) = both(
        || tree(size, [start, middle], left, leaf, merge),
        || tree(size, [start + middle, length - middle], right, leaf, merge),
    );
    merge(a, b)
}

/// Calls both functions, on two threads if the pool has several. With a single thread the caller runs both: handing
/// them over takes longer than most passes.
fn both<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_num_threads() == 1 {
        return (a(), b());
    }
    let (mut a, mut b) = (Some(a), Some(b));
    let (mut of_a, mut of_b) = (None, None);
    join(&mut || of_a = a.take().map(|a| a()), &mut || of_b = b.take().map(|b| b()));
    // A panic in either has propagated through the join.
    of_a.zip(of_b).expect("both functions were called")
}

/// Joins two tasks of a pass. Not generic, since rayon's join is long and each pass would compile its own copy.
fn join(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Runs a [`pass`] without a result: `leaf` only changes its stretches.
///
/// # Panics
/// If the vectors differ in length.
pub fn for_each<V: Split>(vectors: V, leaf: &(impl Fn(usize, V) + Sync)) {
    pass(vectors, leaf, &|(), ()| ());
}

/// Runs a [`pass`] over the ranges of `0..length`, without vectors to change.
pub fn reduce<R: Send>(
    length: usize,
    leaf: &(impl Fn(Range<usize>) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    fn split<R: Send>(
        range: Range<usize>,
        leaf: &(impl Fn(Range<usize>) -> R + Sync),
        merge: &(impl Fn(R, R) -> R + Sync),
    ) -> R {
        let Some(middle) = half(range.len(), LEAF) else { return leaf(range) };
        let middle = range.start + middle;
        let (a, b) = both(|| split(range.start..middle, leaf, merge), || split(middle..range.end, leaf, merge));
        merge(a, b)
    }
    split(0..length, leaf, merge)
}

/// Returns the sum over `0..length`; `leaf` returns the sum over its range.
pub fn sum(length: usize, leaf: &(impl Fn(Range<usize>) -> f64 + Sync)) -> f64 {
    reduce(length, leaf, &|a, b| a + b)
}

/// Adds two arrays entry by entry; the usual `merge`.
pub fn add<const K: usize>(a: [f64; K], b: [f64; K]) -> [f64; K] {
    std::array::from_fn(|k| a[k] + b[k])
}

/// Returns the sum of all values, in double precision.
pub fn total<T: Copy + Into<f64> + Sync>(values: &[T]) -> f64 {
    sum(values.len(), &|range| values[range].iter().map(|value| (*value).into()).sum())
}

/// Returns the scalar product Σ a b over the shorter length, in double precision.
pub fn dot<T: Copy + Into<f64> + Sync>(a: &[T], b: &[T]) -> f64 {
    sum(a.len().min(b.len()), &|range| {
        a[range.clone()].iter().zip(&b[range]).map(|(a, b)| (*a).into() * (*b).into()).sum()
    })
}

/// Adds `factor` times `x` to `y`, over the shorter length.
#[multiversion(targets = "simd")]
pub fn add_times(y: &mut [f32], factor: f32, x: &[f32]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

/// Returns the smaller of two numbers; NaN if either is NaN.
#[inline]
#[expect(clippy::eq_op, reason = "NaN alone differs from itself")]
pub fn lower<T: Copy + PartialOrd>(a: T, b: T) -> T {
    if b < a || b != b { b } else { a }
}

/// Returns the lowest value: infinity without values, NaN if any value is NaN. Runs on one thread, and is inlined to
/// use the vector instructions of its caller.
#[inline(always)]
pub fn lowest<T: Copy + PartialOrd + From<f32>>(values: &[T]) -> T {
    let none = T::from(f32::INFINITY);
    let mut lanes = [none; 8];
    let (wide, rest) = values.as_chunks::<8>();
    for values in wide {
        lanes.iter_mut().zip(values).for_each(|(lane, value)| *lane = lower(*lane, *value));
    }
    lanes.iter().chain(rest).fold(none, |lowest, value| lower(lowest, *value))
}

/// Returns the index, a whole number of leaves, at which a stretch is cut; `None` for a stretch of at most one leaf.
fn half(length: usize, leaf: usize) -> Option<usize> {
    (length > leaf).then(|| length.div_ceil(leaf).div_ceil(2) * leaf)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn harmonic(n: usize) -> f64 {
        let x: Vec<f64> = (1..=n).map(|i| 1.0 / i as f64).collect();
        sum(n, &|range| x[range].iter().sum())
    }

    #[test]
    fn same_bits_for_any_thread_count() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| harmonic(1_000_003)).to_bits()
        };
        assert_eq!(on(1), on(2));
        assert_eq!(on(1), on(5));
    }

    #[test]
    fn every_index_is_visited_once_whatever_the_length() {
        for n in [0, 1, LEAF - 1, LEAF, LEAF + 1, 2 * LEAF, 7 * LEAF + 13] {
            let mut visits = vec![0.0; n];
            let mut index = vec![0.0; n];
            let count = pass(
                [&mut visits[..], &mut index[..]],
                &|start, [visits, index]| {
                    for (k, (v, i)) in visits.iter_mut().zip(index.iter_mut()).enumerate() {
                        *v += 1.0;
                        *i = (start + k) as f64;
                    }
                    visits.len()
                },
                &|a, b| a + b,
            );
            assert_eq!(count, n);
            assert!(visits.iter().all(|v| *v == 1.0));
            assert!(index.iter().enumerate().all(|(i, v)| *v == i as f64));
        }
    }

    #[test]
    fn pairwise_sum_is_accurate() {
        // Euler–Maclaurin: H_n = ln n + γ + 1/2n − 1/12n².
        let n = 10_000_000;
        let exact = (n as f64).ln() + 0.577_215_664_901_532_9 + 0.5 / n as f64 - 1.0 / (12.0 * (n as f64).powi(2));
        assert!((harmonic(n) - exact).abs() < 1e-14 * exact, "{} {exact}", harmonic(n));
    }

    #[test]
    fn the_lowest_value_is_nan_if_one_is() {
        let mut values = [3.0_f32; 64];
        values[37] = -2.0;
        assert_eq!(lowest(&values), -2.0);
        values[11] = f32::NAN;
        assert!(lowest(&values).is_nan());
        values[37] = 3.0;
        assert!(lowest(&values).is_nan() && lowest(&values[12..]) == 3.0);
    }
}
