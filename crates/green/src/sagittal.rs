//! Sagittal part of a matrix as a real 2 × 2 matrix: with u_z = −i w and σ_zz = −i τ, [[a, i b], [i c, d]] becomes [[a,
//! b], [−c, d]]. A Hermitian matrix becomes a symmetric one.

use crate::Blocks;

pub(crate) type Real2 = [[f64; 2]; 2];

/// Returns the real form of the sagittal part.
pub(crate) fn real(blocks: &Blocks) -> Real2 {
    let [lz, zl] = blocks.coupling;
    [[blocks.longitudinal, lz], [-zl, blocks.normal]]
}

/// Returns the blocks with this real form of the sagittal part.
pub(crate) fn blocks(sagittal: Real2, transverse: f64) -> Blocks {
    let [[longitudinal, lz], [zl, normal]] = sagittal;
    Blocks { longitudinal, normal, transverse, coupling: [lz, -zl] }
}

/// Returns the blocks with this real form of a matrix that is Hermitian up to rounding.
pub(crate) fn hermitian(sagittal: Real2, transverse: f64) -> Blocks {
    Blocks::hermitian(sagittal[0][0], 0.5 * (sagittal[0][1] + sagittal[1][0]), sagittal[1][1], transverse)
}

pub(crate) fn product(a: &Blocks, b: &Blocks) -> Blocks {
    blocks(times(real(a), real(b)), a.transverse * b.transverse)
}

pub(crate) fn times(a: Real2, b: Real2) -> Real2 {
    a.map(|row| [0, 1].map(|column| row[0] * b[0][column] + row[1] * b[1][column]))
}

pub(crate) fn add(a: Real2, b: Real2) -> Real2 {
    [0, 1].map(|row| [0, 1].map(|column| a[row][column] + b[row][column]))
}

pub(crate) fn scaled(a: Real2, factor: f64) -> Real2 {
    a.map(|row| row.map(|entry| entry * factor))
}

pub(crate) fn transposed(a: Real2) -> Real2 {
    [[a[0][0], a[1][0]], [a[0][1], a[1][1]]]
}

pub(crate) fn inverse(a: Real2) -> Real2 {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1] / determinant, -a[0][1] / determinant], [-a[1][0] / determinant, a[0][0] / determinant]]
}
