//! The relaxation of a free surface that is displaced at one point, for several dampings, compared with the theory of
//! its modes (theory.md, sections 6.1 and 6.2).

use std::f64::consts::TAU;
use std::fmt;
use std::ops::ControlFlow;

use gfmd_field::{Grid, Mode};
use gfmd_green::{Body, stiffness_range};
use gfmd_relax::{Damping, Harmonic, Landscape, Method, Motion, RelaxError, Verlet};
use gfmd_response::{Components, FullResponse, Hermitian};
use serde::Serialize;

/// The factor by which the slowest run shrinks is e to the power of this number; its rate is then accurate to a few per
/// cent.
const DECAY: f64 = 70.0;

/// The largest number of steps that is chosen without `--steps`: histories are kept in memory.
pub(super) const MOST_STEPS: f64 = 1e6;

/// The smallest time step over the stability limit. The dampings of much smaller ones cannot be told apart.
const LEAST_DT: f64 = 1e-9;

/// The smallest number of steps: a rate is measured from two windows of several steps.
pub(super) const FEWEST_STEPS: u32 = 40;

/// The best single damping of the band.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Optimal {
    /// Time step.
    pub dt: f64,
    /// η, in 1/time².
    pub eta: f64,
    /// Factor per step of the slowest error in the long run.
    pub rate: f64,
}

/// The relaxation with one damping. A rate is the factor per step by which an amplitude shrinks in the long run.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// η over the critical one.
    pub factor: f64,
    /// η, in 1/time².
    pub eta: f64,
    /// The regime of the slowest mode.
    pub regime: Regime,
    /// The fraction of modes that oscillate.
    pub oscillating: f64,
    /// Predicted rate of the slowest mode: the largest eigenvalue of its update matrix, in magnitude.
    pub predicted_rate: f64,
    /// Measured rate of the slowest mode.
    pub mode_rate: f64,
    /// Measured rate of the point that was pushed.
    pub point_rate: f64,
    /// Predicted steps until the slowest mode stays below 1e-8 of its start.
    pub steps_to_1e8: Option<u32>,
    /// Amplitude of the slowest mode over its start, step by step.
    #[serde(skip)]
    pub mode: Vec<f64>,
    /// Predicted amplitude of the slowest mode over its start, step by step.
    #[serde(skip)]
    pub predicted: Vec<f64>,
    /// Displacement of the point that was pushed over its start, in the component in which the slowest mode moves most.
    #[serde(skip)]
    pub point: Vec<f64>,
}

/// The regimes of a damped mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// Oscillation.
    UnderDamped,
    /// The fastest decay without oscillation.
    Critical,
    /// A slower decay without oscillation.
    OverDamped,
}

impl Regime {
    fn of(motion: Motion) -> Self {
        match motion {
            Motion::UnderDamped { .. } => Self::UnderDamped,
            Motion::Critical { .. } => Self::Critical,
            Motion::OverDamped { .. } => Self::OverDamped,
        }
    }
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::UnderDamped => "under-damped",
            Self::Critical => "critical",
            Self::OverDamped => "over-damped",
        })
    }
}

/// The surface and its dampings.
pub(super) struct Experiment {
    pub(super) response: FullResponse,
    /// Time step at unit mass per area.
    pub(super) dt: f64,
    pub(super) steps: u32,
    /// Stiffness of the slowest mode.
    pub(super) softest: f64,
    pub(super) slowest_mode: Mode,
    /// The ratio to critical damping, and the method, for each run.
    pub(super) verlets: Vec<(f64, Verlet)>,
    /// The shape of the slowest mode on the surface.
    pattern: Vec<f64>,
    /// Index of the pushed entry that is watched.
    watched: usize,
}

/// Reasons why an experiment cannot be prepared.
#[derive(Debug)]
pub(super) enum Unusable {
    /// A grid of a single point.
    Points,
    /// The time step over the stability limit.
    TimeStep(f64),
    Factor {
        found: f64,
        /// A damping so small that rounding removes it.
        least: f64,
        largest: f64,
    },
    /// The number of steps that the rates need is above [`MOST_STEPS`].
    Steps(f64),
    Method(RelaxError),
}

impl Experiment {
    /// Prepares the relaxation of the surface of a body with each of the dampings `factors`; `dt` is the time step over
    /// the stability limit without damping. Without `steps` the number of steps suffices for the asymptotic rates.
    pub(super) fn new(body: &Body, grid: Grid, dt: f64, factors: &[f64], steps: Option<u32>) -> Result<Self, Unusable> {
        let range = stiffness_range(body, &grid).ok_or(Unusable::Points)?;
        if !((LEAST_DT..1.0).contains(&dt)) {
            return Err(Unusable::TimeStep(dt));
        }
        let dt = dt * 2.0 / range.stiffest.sqrt();
        let critical = Damping::critical(range.softest, dt).eta();
        // theory.md, section 6.1: τ k_max < 2 (1 + β).
        let largest = (2.0 - 0.5 * range.stiffest * dt * dt) / (critical * dt * dt);
        let least = f64::EPSILON / (critical * dt * dt);
        if let Some(&found) = factors.iter().find(|factor| !(**factor >= least && **factor < largest)) {
            return Err(Unusable::Factor { found, least, largest });
        }
        let verlet = |&factor: &f64| {
            let damping = Damping { beta: 1.0 - factor * critical * dt * dt, tau: dt * dt };
            Verlet::new(damping, range.stiffest).map(|verlet| (factor, verlet))
        };
        let verlets = factors.iter().map(verlet).collect::<Result<Vec<_>, _>>().map_err(Unusable::Method)?;
        let slowest = verlets.iter().map(|(_, v)| v.damping.spectral_radius(range.softest)).fold(0.0, f64::max);
        let enough = (DECAY / -slowest.ln()).ceil().max(f64::from(FEWEST_STEPS));
        let steps = match steps {
            Some(steps) => steps,
            None if enough <= MOST_STEPS => enough as u32,
            None => return Err(Unusable::Steps(enough)),
        };
        let (pattern, component) = pattern(body, &grid, &range.softest_mode);
        Ok(Self {
            response: FullResponse::new(grid, body),
            dt,
            steps,
            softest: range.softest,
            slowest_mode: range.softest_mode,
            verlets,
            pattern,
            watched: component * grid.len(),
        })
    }

    /// The η that damps the slowest mode critically.
    pub(super) fn critical_eta(&self) -> f64 {
        Damping::critical(self.softest, self.dt).eta()
    }

    /// The best single damping, with its own time step.
    pub(super) fn optimal(&self) -> Optimal {
        let [_, stiffest] = self.response.stiffness_range();
        let optimal = Damping::optimal(self.softest, stiffest);
        Optimal { dt: optimal.tau.sqrt(), eta: optimal.eta(), rate: optimal.spectral_radius(self.softest) }
    }

    /// Releases the displaced surface. `watch` is called before every step and may stop the run, which then returns
    /// `None`.
    pub(super) fn relax(
        &self,
        (factor, verlet): &(f64, Verlet),
        watch: &mut dyn FnMut(u32) -> ControlFlow<()>,
    ) -> Result<Option<Run>, RelaxError> {
        let (stiffness, mut workspace) = (self.response.stiffness(), self.response.workspace());
        let mut free = Harmonic::new(self.pattern.len(), |u: &[f64], force: &mut [f64]| {
            stiffness.apply(u, force, &mut workspace).expect("u and force have the length of the problem");
        });
        let points = self.response.grid().len();
        let mut push = vec![0.0; free.len()];
        for (axis, component) in push.chunks_exact_mut(points).enumerate() {
            component[0] = 1.0;
            // The mean normal displacement of an incompressible slab is zero.
            if self.response.uniform_compliance()[self.response.components().axes()[axis]] == 0.0 {
                component.iter_mut().for_each(|u| *u -= 1.0 / points as f64);
            }
        }
        let mut state = verlet.start(&mut free, push)?;
        let start = gfmd_vector::dot(&self.pattern, &state.u);
        let (mut mode, mut point) = (Vec::new(), Vec::new());
        for step in 0..=self.steps {
            mode.push(gfmd_vector::dot(&self.pattern, &state.u) / start);
            point.push(state.u[self.watched]);
            if watch(step).is_break() {
                return Ok(None);
            }
            verlet.step(&mut free, &mut state)?;
        }
        let damping = verlet.damping;
        Ok(Some(Run {
            factor: *factor,
            eta: damping.eta(),
            regime: Regime::of(damping.motion(self.softest)),
            oscillating: self.oscillating(&damping),
            predicted_rate: damping.spectral_radius(self.softest),
            mode_rate: rate(&mode),
            point_rate: rate(&point),
            steps_to_1e8: damping.steps_to(self.softest, 1e-8),
            predicted: (0..=self.steps).map(|step| damping.amplitude(self.softest, step)).collect(),
            mode,
            point,
        }))
    }

    /// The fraction of modes, counted with their weight, that oscillate.
    fn oscillating(&self, damping: &Damping) -> f64 {
        let grid = self.response.grid();
        let line = self.response.components() == Components::Plane;
        let (mut oscillating, mut all) = (0.0, 0.0);
        for (mode, matrix) in grid.modes().zip(self.response.stiffness().matrices()) {
            for (k, [_, y, _]) in matrix.modes() {
                if line && y.abs() > 0.5 {
                    continue;
                }
                all += mode.weight;
                if matches!(damping.motion(k), Motion::UnderDamped { .. }) {
                    oscillating += mode.weight;
                }
            }
        }
        oscillating / all
    }
}

/// The real field of the softest eigenvector of `mode`, and the component in which it is largest.
fn pattern(body: &Body, grid: &Grid, mode: &Mode) -> (Vec<f64>, usize) {
    let components = Components::of(grid);
    let matrix = if mode.is_uniform() {
        let [lateral, normal] = body.level_compliance().map(f64::recip);
        Hermitian { xx: lateral, yy: lateral, zz: normal, xy: 0.0, xz: 0.0, yz: 0.0 }
    } else {
        Hermitian::of(&body.stiffness_of(mode))
    };
    let moves = |vector: &[f64; 3]| components == Components::Space || vector[1].abs() < 0.5;
    let modes = matrix.modes();
    let softest = modes.iter().map(|(_, vector)| vector).find(|vector| moves(vector)).unwrap_or(&modes[0].1);
    let [nx, ny] = grid.points();
    let mut pattern = Vec::with_capacity(components.len() * grid.len());
    for &axis in components.axes() {
        for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
            let turns = mode.number[0] as f64 * i as f64 / nx as f64 + mode.number[1] as f64 * j as f64 / ny as f64;
            // The component along z is imaginary.
            let wave = if axis == 2 { -(TAU * turns).sin() } else { (TAU * turns).cos() };
            let uniform = if axis == 2 && mode.is_self_conjugate() { (TAU * turns).cos() } else { wave };
            pattern.push(softest[axis] * uniform);
        }
    }
    let largest =
        |(_, a): &(usize, &usize), (_, b): &(usize, &usize)| softest[**a].abs().total_cmp(&softest[**b].abs());
    let component = components.axes().iter().enumerate().max_by(largest).map_or(0, |(index, _)| index);
    (pattern, component)
}

/// The factor per step by which an amplitude shrinks in the long run. It compares the largest amplitudes in two
/// windows, each a quarter of the run: at its middle and at its end.
fn rate(history: &[f64]) -> f64 {
    // Smaller amplitudes are left out: there, rounding errors of modes without stiffness would dominate.
    let steps = history.iter().rposition(|x| x.abs() > 1e-30).unwrap_or(0) / 2;
    let window = steps / 2;
    let largest = |end: usize| history[end - window..end].iter().fold(0.0, |m, x| f64::max(m, x.abs()));
    (largest(2 * steps) / largest(steps)).powf(1.0 / steps as f64)
}
