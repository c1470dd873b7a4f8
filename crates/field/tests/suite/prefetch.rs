//! The cache hint, the only `unsafe` code in the crate, included from its source: Miri runs this file alone.

#[path = "../../src/prefetch.rs"]
mod source;

use source::prefetch;

#[test]
fn a_prefetch_leaves_the_values_as_they_are() {
    for length in [0, 1, 7, 8, 9, 1000] {
        let values: Vec<f64> = (0..length).map(f64::from).collect();
        prefetch(&values);
        assert!(values.iter().zip(0..).all(|(value, index)| *value == f64::from(index)));
    }
    prefetch(&[[0_u8; 200]; 3]);
}
