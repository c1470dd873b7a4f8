//! Chosen numbers of the search on few points: meaning, origin, and in brackets the change of the transform pairs of
//! the default solver if the number is halved, and if it is doubled. The change is the geometric mean over the cases of
//! the example `pairs` of `gfmd-contact` at 256², measured by `tests/sensitivity`; two fields do not use this search.

/// Largest fraction of points in blocks at the start, so that the search takes less time than transforms of the whole
/// surface: on small grids, with fields that fit into caches, and on large ones. Measured times (commit a988493;
/// `cargo run --release -p gfmd-contact --example pairs` prints them) (+17.9 %, -7.5 %, of pairs).
pub(super) const MAX_BLOCK_FRACTION_AT_START: [f64; 2] = [0.17, 0.2];

/// Number of points of the largest small grid: its fields in single precision take 2 MiB. Measured as
/// [`MAX_BLOCK_FRACTION_AT_START`] (no effect; 256² is below).
pub(super) const SMALL_GRID_POINTS: usize = 1 << 19;

/// Largest fraction of points in blocks later. Chosen, more than at the start (no effect).
pub(super) const MAX_BLOCK_FRACTION: f64 = 0.35;

/// Residual, relative to the overlap, at which all points are checked for the first time. Chosen (0 %, -0.2 %).
pub(super) const FIRST_CHECK_RESIDUAL: f64 = 0.03;

/// Residual, relative to the deepest penetration, at which all points are checked again. Derived from the errors of
/// images, 4e-4 ([`Scattered`](gfmd_response::Scattered)) (0 %, +0.9 %).
pub(super) const NEXT_CHECK_RESIDUAL: f64 = 5e-4;

/// Largest number of iterations between checks of all points. Measured: 8 to 20 are usual (commit 632d18c) (no effect).
pub(super) const MAX_ITERATIONS_BETWEEN_CHECKS: u64 = 60;

/// Tolerance, relative to the finest one, below which a search uses the finest one at once. Chosen (0 %, +0.1 %).
pub(super) const AT_ONCE: f64 = 3.0;

/// Gap, relative to the tolerance, below which a point joins the search. Chosen (no effect).
pub(super) const JOIN_GAP_PER_TOLERANCE: f64 = 0.5;

/// Gap, relative to the deepest penetration, below which a point joins the search. Chosen against a quarter (commit
/// 632d18c) (no effect).
pub(super) const JOIN_GAP_PER_PENETRATION: f64 = 0.1;

/// Factor on the preconditioner of the points. Derived: the quotients of this preconditioner and the inverse of the
/// compliance are 0.8 to 1.7 (measured, commit 632d18c), and overestimating is safer
/// ([`precondition`](gfmd_relax::Preconditioned::precondition)) (+3.2 %, -0.1 %).
pub(super) const PRECONDITIONER_FACTOR: f32 = 1.2;

/// Number of points that overlap a rigid plane at the start, for each point expected to touch. Chosen (-5.2 %,
/// +18.5 %).
pub(super) const OVERLAPPING: f64 = 3.0;

/// Least number of overlapping points. Chosen (0 %, +0.3 %).
pub(super) const LEAST_OVERLAPPING: f64 = 32.0;

/// Largest fraction of overlapping points: with more, there are hardly few enough blocks to save time against
/// transforms of the whole surface. As [`MAX_BLOCK_FRACTION_AT_START`] (no effect).
pub(super) const MOST_OVERLAPPING: f64 = 0.2;

/// Estimated kappa, for the first guess of the area. Measured: 1.8 to 2.3 on self-affine surfaces (docs/results.md)
/// (-5.2 %, +18.5 %).
pub(super) const KAPPA: f64 = 2.0;

/// Number of bins for the clearances below the mean; it affects only the precision of the overlap. Chosen (no effect).
pub(super) const BINS: usize = 4096;
