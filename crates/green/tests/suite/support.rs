//! Random bodies, and matrix algebra for the property tests.

use gfmd_green::{Base, Blocks, Body, Ground, Material};
use num_complex::Complex64;
use proptest::prelude::*;

/// Generates Poisson's ratios, with frequent end points and incompressible cases.
pub(crate) fn poisson() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -0.95..0.5, 1 => Just(0.5), 1 => 0.499..0.5, 1 => Just(0.0), 1 => Just(0.25)]
}

pub(crate) fn material() -> impl Strategy<Value = Material> {
    (0.1..10.0, poisson()).prop_map(|(young, poisson)| Material::from_young(young, poisson).unwrap())
}

/// Generates a number with a logarithmically uniform distribution.
pub(crate) fn decades(lowest: f64, highest: f64) -> impl Strategy<Value = f64> {
    (lowest.log10()..highest.log10()).prop_map(|exponent| 10f64.powf(exponent))
}

/// Generates a wave vector with a given length.
pub(crate) fn wavevector(length: impl Strategy<Value = f64>) -> impl Strategy<Value = [f64; 2]> {
    (length, 0.0..std::f64::consts::TAU).prop_map(|(q, angle)| [q * angle.cos(), q * angle.sin()])
}

/// All conditions at the bottom of a slab on rigid ground.
pub(crate) const GROUNDS: [Ground; 4] = [Ground::BONDED, Ground::SLIDING, Ground::NONE, Ground::GUIDED];

/// Generates a slab of a height near 1 on any base, a half-space, a coating or a stack.
pub(crate) fn body() -> impl Strategy<Value = Body> {
    let leaf = (material(), 0.3..2.0, 0..5_usize).prop_map(|(material, height, kind)| match GROUNDS.get(kind) {
        Some(ground) => Body::slab(material, height).unwrap().on(Base::Rigid(*ground)).unwrap(),
        None => Body::half_space(material),
    });
    leaf.prop_recursive(2, 3, 1, |below| {
        (material(), 0.3..2.0, below)
            .prop_map(|(material, height, below)| Body::slab(material, height).unwrap().bonded_to(below).unwrap())
    })
}

/// Returns the difference of `a` and `b` relative to `scale`.
pub(crate) fn apart(a: f64, b: f64, scale: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / scale.abs() }
}

/// Returns the largest difference of two sets of blocks, each entry relative to its diagonal entries.
pub(crate) fn blocks_apart(a: &Blocks, b: &Blocks) -> f64 {
    let mixed = a.longitudinal.abs().sqrt() * a.normal.abs().sqrt();
    [
        apart(a.longitudinal, b.longitudinal, a.longitudinal),
        apart(a.normal, b.normal, a.normal),
        apart(a.transverse, b.transverse, a.transverse),
        apart(a.coupling[0], b.coupling[0], mixed),
        apart(a.coupling[1], b.coupling[1], mixed),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

pub(crate) fn largest<const N: usize, const M: usize>(matrix: &[[Complex64; N]; M]) -> f64 {
    matrix.iter().flatten().map(|entry| entry.norm()).fold(0.0, f64::max)
}

/// Returns the largest difference of two matrices, relative to the largest entry.
pub(crate) fn matrices_apart<const N: usize, const M: usize>(a: &[[Complex64; N]; M], b: &[[Complex64; N]; M]) -> f64 {
    let difference = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).norm());
    difference.fold(0.0, f64::max) / largest(a).max(f64::MIN_POSITIVE)
}

pub(crate) fn product<const N: usize, const K: usize, const M: usize>(
    a: &[[Complex64; K]; N],
    b: &[[Complex64; M]; K],
) -> [[Complex64; M]; N] {
    a.map(|row| std::array::from_fn(|column| (0..K).map(|k| row[k] * b[k][column]).sum()))
}

/// Returns true if `large` − `small` is positive semidefinite up to rounding.
pub(crate) fn dominates(large: &Blocks, small: &Blocks) -> bool {
    let rounding = 1e-13;
    let longitudinal = large.longitudinal - small.longitudinal + rounding * large.longitudinal;
    let normal = large.normal - small.normal + rounding * large.normal;
    let coupling = large.coupling[0] - small.coupling[0];
    let transverse = large.transverse - small.transverse + rounding * large.transverse;
    longitudinal > 0.0 && normal > 0.0 && transverse > 0.0 && coupling * coupling <= longitudinal * normal
}
