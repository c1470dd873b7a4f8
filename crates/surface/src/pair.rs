use std::f64::consts::TAU;

use gfmd_field::{Grid, Mode, Transform};
use ndarray::{Array2, ArrayRef2, s};
use num_complex::Complex64;

use crate::SurfaceError;
use crate::statistics::checked;

/// Rounding tolerance of a shift that counts as whole, in grid steps: the rounding error of a decimal number.
const WHOLE: f64 = 1e-9;

/// Returns the composite of two periodic surfaces that face each other: `first` plus `second` moved by `shift` (length
/// along x and y).
///
/// Both heights are given at the same points of one plane, each with its peaks towards the other surface. The gap
/// between the undeformed surfaces then equals the gap between the composite and a plane. A shift of whole grid steps
/// moves the heights from point to point. A remaining fraction of a step moves their trigonometric interpolation.
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite; a shift that is not finite or across a profile.
pub fn composite(
    first: &ArrayRef2<f64>,
    second: &ArrayRef2<f64>,
    grid: &Grid,
    shift: [f64; 2],
) -> Result<Array2<f64>, SurfaceError> {
    checked(first, grid)?;
    checked(second, grid)?;
    let steps = steps(grid, shift)?;
    let whole = steps.map(f64::round);
    let [nx, ny] = grid.points();
    let from = |index: usize, points: usize, whole: f64| {
        let moved = whole.rem_euclid(points as f64) as usize;
        (index + points - moved) % points
    };
    let moved = Array2::from_shape_fn((nx, ny), |(i, j)| second[[from(i, nx, whole[0]), from(j, ny, whole[1])]]);
    let rest = [steps[0] - whole[0], steps[1] - whole[1]];
    let moved = if rest == [0.0, 0.0] { moved } else { interpolated(&moved, grid, rest)? };
    Ok(moved + first)
}

/// Returns the composite of two surfaces that do not repeat, on their overlap, and its grid. The shift must be in whole
/// grid steps.
///
/// # Errors
/// Heights that do not have the shape of the grid or are not finite; a shift that is not finite, goes across a profile,
/// has a fraction of a step, or leaves fewer than 2 common points along an axis.
pub fn composite_inside(
    first: &ArrayRef2<f64>,
    second: &ArrayRef2<f64>,
    grid: &Grid,
    shift: [f64; 2],
) -> Result<(Array2<f64>, Grid), SurfaceError> {
    checked(first, grid)?;
    checked(second, grid)?;
    let steps = steps(grid, shift)?;
    if steps.iter().any(|step| step.fract() != 0.0) {
        return Err(SurfaceError::PartOfStep { found: steps });
    }
    let points = grid.points();
    let common = |axis: usize| points[axis] as f64 - steps[axis].abs();
    let least = |axis: usize| if points[axis] == 1 { 1.0 } else { 2.0 };
    if (0..2).any(|axis| common(axis) < least(axis)) {
        return Err(SurfaceError::Apart { found: shift, lengths: grid.lengths() });
    }
    let [nx, ny] = [0, 1].map(|axis| common(axis) as usize);
    let [from_x, from_y] = steps.map(|step| step.max(0.0) as usize);
    let [back_x, back_y] = steps.map(|step| (-step).max(0.0) as usize);
    let here = first.slice(s![from_x..from_x + nx, from_y..from_y + ny]);
    let there = second.slice(s![back_x..back_x + nx, back_y..back_y + ny]);
    let [a, b] = grid.spacing();
    Ok((&here + &there, Grid::new([nx, ny], [nx as f64 * a, ny as f64 * b])?))
}

/// Returns the shift in grid steps, rounded if it is whole up to rounding errors.
fn steps(grid: &Grid, shift: [f64; 2]) -> Result<[f64; 2], SurfaceError> {
    let spacing = grid.spacing();
    let steps = [0, 1].map(|axis| shift[axis] / spacing[axis]);
    if !steps.iter().all(|step| step.is_finite()) || (grid.is_line() && shift[1] != 0.0) {
        return Err(SurfaceError::Shift { found: shift });
    }
    Ok(steps.map(|step| if (step - step.round()).abs() < WHOLE { step.round() } else { step }))
}

/// Returns the periodic heights moved by a non-integer number of steps.
pub(crate) fn interpolated(
    heights: &ArrayRef2<f64>,
    grid: &Grid,
    steps: [f64; 2],
) -> Result<Array2<f64>, SurfaceError> {
    let transform = Transform::new(*grid);
    let mut workspace = transform.workspace();
    let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
    let mut field = checked(heights, grid)?.into_owned();
    transform.forward(&field, &mut spectrum, &mut workspace)?;
    for (value, mode) in spectrum.iter_mut().zip(grid.modes()) {
        *value *= phase(&mode, grid, steps);
    }
    transform.inverse(&spectrum, &mut field, &mut workspace)?;
    let [nx, ny] = grid.points();
    let found = [field.len(), 1];
    Array2::from_shape_vec((nx, ny), field).map_err(|_| SurfaceError::Shape { found, expected: [nx, ny] })
}

/// Returns the factor of a wave moved by `steps`. A wave at the Nyquist number is the mean of its two directions.
fn phase(mode: &Mode, grid: &Grid, steps: [f64; 2]) -> Complex64 {
    let points = grid.points();
    [0, 1]
        .map(|axis| {
            let (number, points) = (mode.number[axis], points[axis] as f64);
            let turn = TAU * number as f64 * steps[axis] / points;
            if 2.0 * number.unsigned_abs() as f64 == points { turn.cos().into() } else { Complex64::cis(-turn) }
        })
        .into_iter()
        .product()
}
