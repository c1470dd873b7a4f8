use std::fmt;
use std::sync::Arc;

use gfmd_field::{Grid, Transform};
use gfmd_relax::{Budget, Ending, Watch, Why};
use gfmd_vector::{add, contiguous, for_each, reduce, total};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::memory::{Memory, higher};
use crate::search::Search;
use crate::{HeatError, Thermal};

/// Heat source that slides steadily over a body (theory.md, section 7.11).
///
/// With a second body, the indenter, in which the source rests, the heat is shared: the surfaces have equal
/// temperatures at every heated point, and equal mean temperatures.
#[derive(Clone)]
pub struct Flash {
    transform: Arc<Transform>,
    /// Temperature of the body divided by its heat flux, for each mode; zero for the uniform mode.
    body: Arc<Vec<Complex64>>,
    /// Temperature of the stationary indenter divided by its heat flux, for each mode.
    indenter: Option<Arc<Vec<f64>>>,
}

/// Temperatures relative to the mean of the surface, and the division of the heat.
#[derive(Clone, Debug)]
pub struct Heated {
    /// Temperature of the surface of the body.
    pub temperature: Array2<f64>,
    /// Heat flux into the body. It may be negative, and it exceeds the generated flux where heat flows from the
    /// indenter into the body.
    pub into_body: Array2<f64>,
    /// Mean generated heat flux over the whole surface.
    pub mean_flux: f64,
    /// Fraction of the heat that flows into the body. NaN if two bodies touch at all points: the mean flux into each
    /// body is then undetermined, and the mean of `into_body` is zero.
    pub fraction: f64,
    /// Largest temperature at the heated points; NaN if there are none.
    pub max_rise: f64,
    /// Mean temperature at the heated points; NaN if there are none.
    pub mean_rise: f64,
    /// Larger of two relative errors: the largest temperature difference between the two bodies at heated points,
    /// divided by `max_rise`; and the largest flux into the body elsewhere, divided by the largest generated flux.
    /// Computed from the final fields; zero with one body.
    pub residual: f64,
    /// Number of iterations.
    pub iterations: u64,
    /// Number of transform pairs of the search.
    pub transform_pairs: f64,
}

impl fmt::Debug for Flash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Flash").field("grid", self.transform.grid()).finish_non_exhaustive()
    }
}

impl Flash {
    /// Creates a source that moves over a `body` at a `velocity` and rests in the `indenter`, if there is one.
    ///
    /// # Errors
    /// Returns an error if the velocity is not finite.
    pub fn new(grid: Grid, velocity: [f64; 2], body: Thermal, indenter: Option<Thermal>) -> Result<Self, HeatError> {
        if velocity.iter().any(|v| !v.is_finite()) {
            return Err(HeatError::Velocity(velocity));
        }
        let rates = velocity.map(|v| v / body.diffusivity());
        let of = |index: usize| {
            let mode = grid.mode_at(index);
            if mode.is_uniform() {
                return Complex64::ZERO;
            }
            // A Nyquist mode takes the mean of the inverse kernel over its aliases.
            let [mut sum, mut count] = [Complex64::ZERO, Complex64::ZERO];
            for [x, y] in mode.aliases() {
                sum += Complex64::new(mode.wavenumber().powi(2), -(x * rates[0] + y * rates[1])).sqrt();
                count += 1.0;
            }
            count / (body.conductivity() * sum)
        };
        let resting = |thermal: Thermal| {
            let of = |index: usize| match grid.mode_at(index) {
                mode if mode.is_uniform() => 0.0,
                mode => 1.0 / (thermal.conductivity() * mode.wavenumber()),
            };
            (0..grid.spectrum_len()).into_par_iter().map(of).collect::<Vec<_>>().into()
        };
        Ok(Self {
            transform: Transform::new(grid).into(),
            body: (0..grid.spectrum_len()).into_par_iter().map(of).collect::<Vec<_>>().into(),
            indenter: indenter.map(resting),
        })
    }

    /// Computes the temperature under a heat `flux` (per area and time), which is zero where the surfaces do not touch.
    ///
    /// # Errors
    /// Returns an error if the flux has a different size than the grid or is negative somewhere, or if the tolerance is
    /// out of range. All other errors contain the state reached.
    pub fn heat(&self, flux: &Array2<f64>, budget: &Budget, watch: &mut dyn Watch) -> Result<Heated, HeatError> {
        budget.check()?;
        let flux = self.checked(flux)?;
        let Some(indenter) = &self.indenter else { return Ok(self.certified(&flux, flux.to_vec(), 0, 0.0)) };
        if flux.iter().all(|q| *q > 0.0) {
            let mut memory = Memory::new(&self.transform);
            memory.field.copy_from_slice(&flux);
            memory.apply(&|i| match self.body[i] + indenter[i] {
                both if both == Complex64::ZERO => both,
                both => indenter[i] / both,
            });
            return judged(self.certified(&flux, memory.field, 1, 1.0), Ending::Converged, budget.tolerance);
        }
        let mut search = Search::new(&self.transform, &self.body, indenter, &flux);
        let (mut target, mut best) = (budget.tolerance * search.largest(), None::<Heated>);
        loop {
            let ending = search.run(target, budget.max_iterations, watch);
            let state = self.certified(&flux, search.at_all_points(), search.iterations, search.transform_pairs);
            let is_better = best.as_ref().is_none_or(|best| state.residual <= 0.5 * best.residual);
            if ending != Ending::Converged || state.residual <= budget.tolerance || !is_better {
                let is_stuck = ending == Ending::Converged && !is_better;
                let ending = if is_stuck { Ending::GaveUp(Why::Rounding) } else { ending };
                return judged(state, ending, budget.tolerance);
            }
            target = 0.5 * budget.tolerance * state.max_rise;
            search.restart();
            best = Some(state);
        }
    }

    /// Computes the state and its residual from a heat `flux` and its part `into_body`, with fresh transforms.
    ///
    /// # Errors
    /// Returns an error if a field has a different size than the grid, or if the flux is negative somewhere.
    pub fn certify(&self, flux: &Array2<f64>, into_body: &Array2<f64>) -> Result<Heated, HeatError> {
        let (flux, into_body) = (self.checked(flux)?, self.sized(into_body)?);
        Ok(self.certified(&flux, into_body.into_owned(), 0, 0.0))
    }

    fn sized<'a>(&self, field: &'a Array2<f64>) -> Result<std::borrow::Cow<'a, [f64]>, HeatError> {
        let (found, expected) = (field.len(), self.transform.grid().len());
        if found == expected { Ok(contiguous(field)) } else { Err(HeatError::Points { found, expected }) }
    }

    fn checked<'a>(&self, flux: &'a Array2<f64>) -> Result<std::borrow::Cow<'a, [f64]>, HeatError> {
        let flux = self.sized(flux)?;
        match flux.iter().find(|q| !(q.is_finite() && **q >= 0.0)) {
            Some(found) => Err(HeatError::Flux(*found)),
            None => Ok(flux),
        }
    }

    fn certified(&self, flux: &[f64], into_body: Vec<f64>, iterations: u64, transform_pairs: f64) -> Heated {
        let mut memory = Memory::new(&self.transform);
        memory.field.copy_from_slice(&into_body);
        memory.apply(&|i| self.body[i]);
        let temperature = memory.field.clone();
        let other = self.indenter.as_ref().map(|indenter| {
            for_each((&mut memory.field[..], flux, &into_body[..]), &|_, (field, made, taken)| {
                field.iter_mut().zip(made).zip(taken).for_each(|((field, made), taken)| *field = made - taken);
            });
            memory.apply(&|i| indenter[i].into());
            &memory.field
        });
        let heated = |i: usize| flux[i] > 0.0;
        let [count, sum] = reduce(
            flux.len(),
            &|range| range.filter(|i| heated(*i)).fold([0.0; 2], |[count, sum], i| [count + 1.0, sum + temperature[i]]),
            &add,
        );
        let most = |of: &(dyn Fn(usize) -> Option<f64> + Sync)| {
            let least = f64::NEG_INFINITY;
            reduce(flux.len(), &|range| range.filter_map(of).fold(least, higher), &higher)
        };
        let max_rise = if count > 0.0 { most(&|i| heated(i).then_some(temperature[i])) } else { f64::NAN };
        let residual = match other {
            None => 0.0,
            Some(_) if count == 0.0 => most(&|i| Some(into_body[i].abs())),
            Some(other) => {
                let apart = most(&|i| heated(i).then(|| (temperature[i] - other[i]).abs()));
                let elsewhere = most(&|i| (!heated(i)).then(|| into_body[i].abs())).max(0.0);
                higher(apart / max_rise, elsewhere / most(&|i| Some(flux[i])))
            }
        };
        let points = flux.len() as f64;
        let mean_flux = total(flux) / points;
        let fraction = match &self.indenter {
            None => 1.0,
            Some(_) if count == points => f64::NAN,
            Some(_) => total(&into_body) / points / mean_flux,
        };
        let field = |values: Vec<f64>| {
            let shape = self.transform.grid().points();
            Array2::from_shape_vec(shape, values).expect("every field has the size of the grid")
        };
        Heated {
            temperature: field(temperature),
            into_body: field(into_body),
            mean_flux,
            fraction,
            max_rise,
            mean_rise: sum / count,
            residual,
            iterations,
            transform_pairs,
        }
    }
}

fn judged(state: Heated, ending: Ending, tolerance: f64) -> Result<Heated, HeatError> {
    match ending {
        Ending::Interrupted => Err(HeatError::Interrupted { state: state.into() }),
        _ if state.residual <= tolerance => Ok(state),
        Ending::Converged => Err(not(state, tolerance, Why::Certificate)),
        Ending::GaveUp(why) => Err(not(state, tolerance, why)),
    }
}

fn not(state: Heated, tolerance: f64, why: Why) -> HeatError {
    HeatError::NotConverged { residual: state.residual, tolerance, why, state: state.into() }
}
