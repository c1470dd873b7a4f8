//! Constants of the search: meaning, origin, and in brackets the effect of halving and of doubling the constant. The
//! first pair is the mean change in transform pairs of the default solver (example `pairs` of `gfmd-contact`, 256²,
//! geometric mean over the cases), the second in iterations with two fields (`squeezed`, 128²). Measured by
//! `tests/sensitivity`.

/// Interval of iterations at which the direction is the gradient. Projected gradients converge for any steps between.
/// Chosen (no effect; +15.9 %, -7.2 %).
pub(super) const PLAIN: u64 = 25;

/// Downhill fraction above which a step that brings variables to zero is kept. Derived: with one half, the function has
/// not increased (0 %, +9.9 %; +44.6 %, +11.5 %).
pub(super) const DOWNHILL: f64 = 0.5;

/// Largest change factor of the length from one step to the next. Chosen (no effect; -3.4 %, -1.3 %).
pub(super) const CHANGE: f64 = 10.0;

/// Largest number of halvings of a step until it begins downhill. Derived: 2⁻³⁰ of a step is a rounding error in single
/// precision (no effect; 0 %, -1.2 %).
pub(super) const HALVINGS: usize = 30;

/// Residual factor at which the gradient is recomputed. Derived: the rounding errors of a step are about 1e-7 of it,
/// and a solution takes ten to thirty steps (0 %, +0.5 %; no effect).
pub(super) const REFRESH: f64 = 1e-4;

/// Number of iterations without progress after which the gradient is also recomputed, if the residual is below
/// [`REFRESH`]. After a warm start, rounding errors can keep the residual above that factor. Chosen: a refresh then
/// costs at most a fiftieth of the pairs (no effect).
pub(super) const STALLED: u64 = 25;

/// Remaining fraction of a step below which the gradient is recomputed after a step back: the rounding errors of the
/// whole step are too large for the rest. Derived like [`REFRESH`] (no effect).
pub(super) const CANCELLED: f64 = 1e-4;

/// Factor that shortens a step if it is so long that rounding errors prevent μ from preserving the mean. Chosen (no
/// effect).
pub(super) const SHORTER: f64 = 1e-3;

/// Relative accuracy of the mean in the search for μ. Chosen: rescaling then makes the mean exact (-0.5 %, 0 %; no
/// effect).
pub(super) const MEAN: f64 = 1e-2;

/// Relative accuracy of the mean with an upper bound, which rescaling might violate. Derived from rounding, like the
/// next two; no effect on the number of iterations.
pub(super) const BOUNDED_MEAN: f64 = 1e-13;

/// Relative accuracy of the means of two fields along a path; rescaling then makes them exact.
pub(super) const PAIR_MEAN: f64 = 1e-14;

/// Largest number of steps in the search for μ of two fields; at worst, they halve a bracket.
pub(super) const SHIFTS: usize = 200;

/// Relative excess of a start over its upper bounds that is a rounding error.
pub(super) const ROUNDING_OF_START: f64 = 1e-12;
