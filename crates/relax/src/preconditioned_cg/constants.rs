//! Constants of the search: meaning, origin, and in brackets the change of the transform pairs of
//! the default solver if the number is halved, and if it is doubled: the geometric mean over the cases of the example
//! `pairs` of `gfmd-contact` at 256², then that of the iterations with two fields, of `squeezed` at 128².
//! `tests/sensitivity` measures them.

/// One direction in so many is the gradient: projected gradients converge for any steps in between. Chosen (no effect;
/// +15.9 %, -7.2 %).
pub(super) const PLAIN: u64 = 25;

/// A step that brings variables to zero is kept if at least this fraction of it was downhill. Derived: for one half the
/// function has not increased (0 %, +9.9 %; +44.6 %, +11.5 %).
pub(super) const DOWNHILL: f64 = 0.5;

/// The largest factor by which the length changes from one step to the next. Chosen (no effect; -3.4 %, -1.3 %).
pub(super) const CHANGE: f64 = 10.0;

/// The largest number of times that a step is shortened until it begins downhill. Derived: 2⁻³⁰ of a step is a rounding
/// error in single precision (no effect; 0 %, -1.2 %).
pub(super) const HALVINGS: usize = 30;

/// The gradient is computed anew when the residual has fallen by this factor. Derived: the rounding errors of a step
/// are some 1e-7 of it, and a solution takes ten to thirty steps (0 %, +0.5 %; no effect).
pub(super) const REFRESH: f64 = 1e-4;

/// The gradient is computed anew, too, if a residual below [`REFRESH`] has not fallen in this number of iterations: a
/// warm start may begin so near its end that rounding errors of the gradient keep it above that factor. Chosen: a
/// refresh then costs at most a fiftieth of the pairs (no effect).
pub(super) const STALLED: u64 = 25;

/// After a step back to less than this fraction of the step, the gradient is computed anew: the rounding errors of the
/// whole step are too large for its remaining part. Derived like [`REFRESH`] (no effect).
pub(super) const CANCELLED: f64 = 1e-4;

/// The factor by which a step is shortened if it is so much longer than the variables that μ cannot preserve their mean
/// because of rounding errors. Chosen (no effect).
pub(super) const SHORTER: f64 = 1e-3;

/// Relative accuracy of the mean in the search for μ. Chosen: a factor then makes the mean exact (-0.5 %, 0 %; no
/// effect).
pub(super) const MEAN: f64 = 1e-2;

/// Relative accuracy of the mean with an upper bound, which a factor might exceed. Derived from rounding, as are the
/// next two, which have no effect on the number of iterations.
pub(super) const BOUNDED_MEAN: f64 = 1e-13;

/// Relative accuracy of the means of two fields along a path; scaling then makes them exact.
pub(super) const PAIR_MEAN: f64 = 1e-14;

/// The largest number of steps of the search for μ of two fields, which are halvings of a bracket at worst.
pub(super) const SHIFTS: usize = 200;
