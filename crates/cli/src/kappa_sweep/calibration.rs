//! The speed of this machine, for the expected time of a sweep.

use std::time::Instant;

use gfmd_field::{Grid, Transform};

use gfmd_input::failure::Failure;

const MILLION: f64 = 1_048_576.0;

/// Measures the seconds that a transform pair of a million points takes on this machine.
///
/// # Errors
/// None on a machine that can transform 256 x 256 points.
pub(super) fn seconds_per_pair() -> Result<f64, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::computation(error.to_string());
    let grid = Grid::square(256, 1.0).map_err(|error| failed(&error))?;
    let transform = Transform::new(grid);
    let mut workspace = transform.workspace();
    let (kernel, field, mut out) = (vec![1.0; grid.spectrum_len()], vec![1.0; grid.len()], vec![0.0; grid.len()]);
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let started = Instant::now();
        transform.convolve(&kernel, &field, &mut out, &mut workspace).map_err(|error| failed(&error))?;
        best = best.min(started.elapsed().as_secs_f64());
    }
    let size = grid.len() as f64;
    Ok(best * MILLION / size * MILLION.log2() / size.log2())
}
