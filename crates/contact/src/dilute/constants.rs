//! The numbers that were chosen for the search on few points, with their origin. `tests/sensitivity` prints how the number of transform
//! pairs of the default solver changes if they are halved and doubled.

/// The largest part of the points that may be in blocks at the start, so that this takes less time than transforms of the whole surface:
/// on small grids, whose fields fit into caches, and on large ones. Measured times (`cargo run --release -p gfmd-contact --example pairs`).
pub(super) const MOST_AT_START: [f64; 2] = [0.17, 0.2];

/// The number of points of the largest small grid: its fields of single precision take 2 MiB.
pub(super) const SMALL: usize = 1 << 19;

/// The largest part of the points that may be in blocks later: a search that has begun is not given up for a little more time.
pub(super) const MOST: f64 = 0.35;

/// The residual at which all points are checked for the first time, over the overlap; chosen.
pub(super) const FIRST: f64 = 0.03;

/// The part of the deepest penetration down to which the residual falls until all points are checked again: the errors of images, which
/// are 4e-4 (theory.md, section 7.5).
pub(super) const STAGE: f64 = 5e-4;

/// The number of iterations in which it should do so; some 30 are usual.
pub(super) const PATIENCE: u64 = 60;

/// The tolerance, over the finest one, below which a search goes on to the finest one at once; chosen.
pub(super) const AT_ONCE: f64 = 3.0;

/// The gap, over the tolerance, below which a point becomes part of the search; chosen.
pub(super) const NEAR: f64 = 0.5;

/// The part of the deepest penetration below which a gap makes a point part of the search; chosen.
pub(super) const NEARLY: f64 = 0.1;

/// The factor by which the preconditioner exceeds that of the points, which may be smaller than the inverse of the compliance by as much
/// (overestimating is safer, [`Preconditioned::precondition`](gfmd_relax::Preconditioned::precondition)).
pub(super) const SURPLUS: f32 = 1.2;

/// The number of points that overlap a rigid plane at the start, for each that is expected to touch; chosen.
pub(super) const OVERLAPPING: f64 = 3.0;

/// The least number of such points; chosen.
pub(super) const LEAST_OVERLAPPING: f64 = 32.0;

/// The largest part of the points that may overlap: with more, there are hardly so few blocks that transforms of the whole surface take
/// longer. As [`MOST_AT_START`].
pub(super) const MOST_OVERLAPPING: f64 = 0.2;

/// Estimated kappa, for the first guess of the area: with two decades of roughness kappa is 2.25 (H = 0) to 2.03 (H = 0.8).
pub(super) const KAPPA: f64 = 2.0;

/// The number of bins for the clearances below the mean, which is the precision of the overlap alone.
pub(super) const BINS: usize = 4096;
