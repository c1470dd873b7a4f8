//! The whole space of parameters, at random: each problem is solved to its stated accuracy, which is recomputed here from
//! the returned fields by direct Fourier sums, or it is refused by name. No NaN, no panic, no endless search.
//!
//! The default run takes some 1500 cases. `GFMD_SPACE=100000 cargo test -p gfmd-tests --test space -- --nocapture` takes as
//! many as it says and prints their count; `GFMD_SPACE_SEED` is the number of the first.

#![expect(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN must not pass a comparison")]
#![expect(clippy::print_stdout, reason = "the count of cases")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use gfmd_contact::{Contact, Drive, Equilibrium, Fields, Load, Refusal, SolveError, Solver};
use gfmd_field::{Grid, Mode};
use gfmd_green::{Base, Body, Complex64, Height, Material};
use gfmd_interface::{FrictionState, FrictionalContact, Interface, State};
use gfmd_law::{Kind, Law, Limit};
use gfmd_mixed::{Method, MixedError, MixedProblem, Prescribed};
use gfmd_relax::Budget;
use gfmd_response::Components;
use ndarray::{Array2, ArrayView2, Axis};

/// The number of cases without `GFMD_SPACE`.
const CASES: u64 = 1500;

/// The largest number of points: direct sums take its square.
const MOST_POINTS: usize = 640;

/// The longest time of a case on a busy machine, in a debug build.
const LONGEST: Duration = Duration::from_secs(300);

const TOLERANCE: f64 = 1e-7;

/// The ratio of stiffnesses, as of a thin plate that nothing supports, above which a search may end without convergence.
const ILL_CONDITIONED: f64 = 1e8;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number in [0, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// A power of ten with an exponent between these.
    fn decade(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(low + (high - low) * self.unit())
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// A body, a grid and heights; the units of stress and of heights.
struct Case {
    body: Body,
    grid: Grid,
    /// The body and the grid in units of the modulus and of the cell, for reference values, and these units.
    plain: (Body, Grid),
    units: [f64; 2],
    heights: Array2<f64>,
    /// E* h_rms / side.
    stress: f64,
    /// The rms height.
    length: f64,
}

impl Case {
    fn random(random: &mut Random) -> Option<Self> {
        let side = |random: &mut Random| match random.below(4) {
            0 => random.one_of(&[1, 2, 3, 4]),
            1 => random.one_of(&[5, 7, 11, 13, 17, 31, 37, 61]),
            _ => 1 + random.below(64),
        };
        let (nx, ny) = match random.below(4) {
            0 => (side(random), 1),
            1 => (1, side(random)),
            _ => (side(random), side(random)),
        };
        let (nx, ny) = if nx * ny > MOST_POINTS { (nx, 1 + MOST_POINTS / nx / 2) } else { (nx, ny) };
        // Units far from 1 in a third of the cases.
        let far = |random: &mut Random, size: f64| if random.chance(0.33) { random.decade(-size, size) } else { 1.0 };
        let (modulus, cell) = (far(random, 120.0), far(random, 60.0));
        let aspect = if random.chance(0.5) { 1.0 } else { random.decade(-4.0, 4.0) };
        let lengths = if ny == 1 { [cell, 1.0] } else { [cell, cell * aspect] };
        let grid = Grid::new([nx, ny], lengths).unwrap();
        let poisson = |random: &mut Random| match random.below(3) {
            0 => random.one_of(&[-0.99, -0.9, 0.0, 0.3, 0.499, 0.499_999_9, 0.5]),
            _ => -0.99 + 1.49 * random.unit(),
        };
        let material = Material::from_contact_modulus(modulus, poisson(random)).unwrap();
        let height = |random: &mut Random| cell * random.decade(-8.0, 8.0);
        let body = match random.below(3) {
            0 => Body::half_space(material),
            1 => Body::slab(material, height(random)).unwrap(),
            _ => {
                let below = Material::from_young(modulus * random.decade(-3.0, 3.0), poisson(random)).unwrap();
                let below = match random.below(2) {
                    0 => Body::half_space(below),
                    _ => Body::new(below, Height::Finite(height(random))).unwrap(),
                };
                let base = match random.below(3) {
                    0 => Base::Sliding,
                    1 => Base::Free,
                    _ => Base::Elastic(below.into()),
                };
                Body::slab(material, height(random)).unwrap().on(base).unwrap()
            }
        };
        let size = cell * random.decade(-4.0, -1.0);
        let kind = random.below(5);
        let slope = 1.0 + 3.0 * random.unit();
        let heights = Array2::from_shape_simple_fn((nx, ny), || random.unit());
        let heights = Array2::from_shape_fn((nx, ny), |(i, j)| {
            let (x, y) = (TAU * i as f64 / nx as f64, TAU * j as f64 / ny as f64);
            let noise = heights[[i, j]];
            size * match kind {
                0 => noise,
                1 => x.cos() + if ny > 1 { y.cos() } else { 0.0 } + 0.01 * noise,
                2 => f64::from(u8::from(i == 0 && j == 0)),
                3 => (noise * slope).floor(),
                _ => x.cos() * (slope * y).sin() + 0.1 * (3.0 * x).sin() * noise,
            }
        });
        let mean = heights.mean()?;
        let length =
            (heights.iter().map(|h| ((h - mean) / size).powi(2)).sum::<f64>() / (nx * ny) as f64).sqrt() * size;
        let side = if ny == 1 { cell } else { lengths[0].max(lengths[1]) };
        // A law at a flat surface has lengths of its own.
        let length = if length > 0.0 { length } else { 1e-3 * cell };
        let lengths = if ny == 1 { [1.0, 1.0] } else { lengths.map(|side| side / cell) };
        let plain = (body.in_units(modulus, cell), Grid::new([nx, ny], lengths).unwrap());
        Some(Self { stress: modulus * (length / side), length, body, grid, plain, units: [modulus, cell], heights })
    }

    fn clearance(&self) -> Array2<f64> {
        let highest = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.heights.mapv(|h| highest - h)
    }

    /// The softest stiffness of a wave times the rms height, the unit of loads.
    fn load_unit(&self) -> f64 {
        let softest = |modes: &mut dyn Iterator<Item = Mode>| {
            let waves = modes.filter(|mode| !mode.is_uniform());
            waves.map(|mode| self.plain.0.normal_stiffness(mode.wavenumber())).fold(f64::INFINITY, f64::min)
        };
        let found = softest(&mut self.plain.1.modes()) * self.units[0] * (self.length / self.units[1]);
        if found.is_finite() && found > 0.0 { found } else { self.stress }
    }

    fn load(&self, random: &mut Random, tension: bool) -> Load {
        let sign = if tension && random.chance(0.3) { -1.0 } else { 1.0 };
        if random.chance(0.6) {
            Load::MeanPressure(sign * self.load_unit() * random.decade(-12.0, 4.0))
        } else {
            Load::Approach(sign * self.length * random.decade(-12.0, 2.0))
        }
    }

    /// The response of the surface to fields of all components, `kernel` of each mode, by direct sums. Components are x, y,
    /// z; all are multiplied by `unit` in between, so that no square is too large or too small.
    fn direct(&self, fields: &[Vec<f64>; 3], kernel: impl Fn(&Mode) -> [[Complex64; 3]; 3]) -> [Vec<f64>; 3] {
        let [nx, ny] = self.grid.points();
        let roots = |n: usize| -> Vec<Complex64> {
            (0..n).map(|k| Complex64::from_polar(1.0, TAU * k as f64 / n as f64)).collect()
        };
        let (along_x, along_y) = (roots(nx), roots(ny));
        let mut response = [0, 1, 2].map(|_| vec![0.0; nx * ny]);
        for mode in self.plain.1.modes() {
            let step = |number: i64, n: usize| number.rem_euclid(n as i64) as usize;
            let (m, n) = (step(mode.number[0], nx), step(mode.number[1], ny));
            let wave = |i: usize, j: usize| along_x[m * i % nx] * along_y[n * j % ny];
            let mut amplitudes = [Complex64::ZERO; 3];
            for i in 0..nx {
                for j in 0..ny {
                    let wave = wave(i, j).conj();
                    for (amplitude, field) in amplitudes.iter_mut().zip(fields) {
                        *amplitude += wave * field[i * ny + j];
                    }
                }
            }
            let matrix = kernel(&mode);
            for (row, response) in matrix.iter().zip(&mut response) {
                let amplitude: Complex64 =
                    row.iter().zip(&amplitudes).map(|(entry, amplitude)| entry * amplitude).sum();
                let amplitude = amplitude * (mode.weight / (nx * ny) as f64);
                if amplitude != Complex64::ZERO {
                    for (k, value) in response.iter_mut().enumerate() {
                        *value += (amplitude * wave(k / ny, k % ny)).re;
                    }
                }
            }
        }
        response
    }

    /// u_z of a normal traction, without the mean of bodies whose mean level is fixed.
    fn normal_displacement(&self, traction: ArrayView2<f64>) -> Vec<f64> {
        let fields = [vec![0.0; traction.len()], vec![0.0; traction.len()], traction.iter().copied().collect()];
        let zero = Complex64::ZERO;
        let [_, _, normal] = self.direct(&fields, |mode| {
            let q = if mode.is_uniform() { 0.0 } else { mode.wavenumber() };
            let compliance = self.units[1] / self.units[0] * self.plain.0.normal_compliance(q);
            let entry = Complex64::from(if compliance.is_finite() { compliance } else { 0.0 });
            [[zero; 3], [zero; 3], [zero, zero, entry]]
        });
        normal
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, value| if value.is_nan() || value.abs() > most { value.abs() } else { most })
}

/// The outcome of a case, by kind, or a complaint.
type Verdict = Result<&'static str, String>;

/// Judges a refusal of a contact.
fn refused(refusal: &Refusal) -> Verdict {
    let text = refusal.to_string();
    if text.contains("NaN")
        || text.contains('\n')
        || !text.contains("must") && !text.contains("needs") && !text.contains("search")
    {
        return Err(format!("a refusal without reason: {text}"));
    }
    Ok(match refusal {
        Refusal::Flat => "refused: flat",
        Refusal::Approach { .. } => "refused: beyond full contact",
        Refusal::Slight { .. } => "refused: slight",
        Refusal::Rounding { .. } => "refused: rounding",
        Refusal::Digits { .. } | Refusal::Unit { .. } => "refused: units",
        Refusal::Solver { .. } | Refusal::NoEnergy | Refusal::NoDynamics => "refused: solver",
        Refusal::Search(_) => "refused: search",
        Refusal::NotPressed { .. } | Refusal::MeanPressure { .. } => "refused: no pressure",
        _ => return Err(format!("an unexpected refusal: {text}")),
    })
}

/// Checks gap, pressure and load of a state at a hard wall from its pressure and the displacement that follows. Parts of
/// the displacement that cancel leave an error of `cancelled`.
fn wall(
    case: &Case,
    load: Load,
    pressure: ArrayView2<f64>,
    displacement: &[f64],
    gap: ArrayView2<f64>,
    approach: f64,
    cancelled: f64,
) -> Result<(), String> {
    let scale = match load {
        Load::Approach(asked) => case.length.min(1e6 * asked),
        Load::MeanPressure(_) => case.length,
    };
    let rounding =
        1e-13 * (approach.abs() + largest(displacement.iter().copied()) + largest(case.clearance())) + cancelled;
    let room = 2.0 * TOLERANCE * scale + rounding;
    let mean = pressure.mean().unwrap_or(f64::NAN);
    let (mut weighted, mut total) = (0.0, 0.0);
    for (k, ((p, g), c)) in pressure.iter().zip(gap).zip(&case.clearance()).enumerate() {
        let own = c - displacement[k] - approach;
        if !(p.is_finite() && *p >= 0.0) {
            return Err(format!("pressure {p:e}"));
        }
        if !((own - g).abs() <= room) {
            return Err(format!("gap {g:e} instead of {own:e}, {room:e} allowed"));
        }
        if !(own >= -room) {
            return Err(format!("gap {own:e}, {room:e} allowed"));
        }
        weighted += p / mean * own;
        total += p / mean;
    }
    if !(total > 0.0 && (weighted / total).abs() <= room) {
        return Err(format!("complementarity {:e}, {room:e} allowed", weighted / total));
    }
    if let Load::MeanPressure(asked) = load
        && !((mean / asked - 1.0).abs() <= 2.0 * TOLERANCE)
    {
        return Err(format!("mean pressure {mean:e} instead of {asked:e}"));
    }
    Ok(())
}

fn hard_wall(case: &Case, random: &mut Random) -> Verdict {
    let contact = match Contact::new(&case.body, &case.grid, &case.heights) {
        Ok(contact) => contact,
        Err(refusal) => return refused(&refusal),
    };
    let [softest, stiffest] = contact.response().stiffness_range();
    let load = case.load(random, false);
    let solver = if random.chance(0.4) { Solver::Auto } else { random.one_of(&Contact::SOLVERS) };
    let conjugate =
        matches!(solver, Solver::Auto | Solver::PolonskyKeer | Solver::ProjectedCg | Solver::PreconditionedCg);
    let limit = if conjugate { 100_000 } else { 3000 };
    let state = match contact.press(load).solver(solver).tolerance(TOLERANCE).max_iterations(limit).solve() {
        Ok(state) => state,
        Err(SolveError::Refused(refusal)) => {
            return refused(&refusal).map_err(|text| format!("{solver} {load:?}: {text}"));
        }
        Err(SolveError::NotConverged { .. }) if !conjugate => return Ok("wall, dynamics: not converged"),
        Err(SolveError::NotConverged { .. }) if stiffest / softest > ILL_CONDITIONED => {
            return Ok("wall, thin plate: not converged");
        }
        Err(SolveError::NotConverged { .. }) if solver != Solver::Auto => {
            return Ok("wall, conjugate gradients: not converged");
        }
        Err(error) => return Err(format!("{solver} {load:?}: {error}")),
    };
    let traction = state.pressure.mapv(|p| -p);
    let own = case.normal_displacement(traction.view());
    let apart = largest(own.iter().zip(&state.displacement).map(|(a, b)| a - b));
    let size = largest(own.iter().copied());
    // On thin plates long waves cancel, and leave an error that is small compared with the roughness.
    if !(apart <= 1e-11 * size + 0.1 * TOLERANCE * case.length.min(largest([state.approach]).max(1e-6 * case.length))) {
        return Err(format!("{solver} {load:?}: displacement differs by {apart:e} of {size:e}"));
    }
    let checked = wall(case, load, state.pressure.view(), &own, state.gap.view(), state.approach, 0.0);
    checked.map(|()| "wall: solved").map_err(|text| format!("{solver} {load:?}: {text}"))
}

fn law(case: &Case, random: &mut Random) -> Result<Box<dyn Law>, String> {
    let kind = random.one_of(&Kind::ALL);
    let energy = |random: &mut Random| case.stress * case.length * random.decade(-5.0, 1.0);
    let range = |random: &mut Random| case.length * random.decade(-2.0, 1.0);
    let values: Vec<(&str, f64)> = kind
        .parameters()
        .iter()
        .map(|parameter| {
            let value = match parameter.units {
                "stress*length" => energy(random),
                "length" => range(random),
                "stress/length" => energy(random) / range(random).powi(2),
                _ => 0.0,
            };
            (parameter.name, value)
        })
        .collect();
    kind.with(&values).map_err(|error| format!("{}: {error}", kind.name()))
}

/// Checks a state of an interface: its elastic traction from its displacement, the law at its gap, the wall.
fn interface_state(case: &Case, law: &dyn Law, state: &State) -> Result<(), String> {
    let z = state.traction.len_of(Axis(0)) - 1;
    let traction = state.traction.index_axis(Axis(0), z);
    let all = state.traction.iter().chain(&state.displacement).chain(&state.gap).chain(&state.wall_pressure);
    if let Some(bad) = all.copied().find(|value| !value.is_finite()) {
        return Err(format!("a field contains {bad}"));
    }
    // u_z follows from all tractions; without lateral ones from the normal one alone.
    if z == 0 {
        let own = case.normal_displacement(traction);
        let found: Vec<f64> = state.displacement.iter().copied().collect();
        let [own_mean, found_mean] = [&own, &found].map(|u| u.iter().sum::<f64>() / u.len() as f64);
        let apart = largest(own.iter().zip(&found).map(|(a, b)| (a - own_mean) - (b - found_mean)));
        let size = largest(own.iter().map(|u| u - own_mean)) + 1e-3 * case.length + 1e-4 * found_mean.abs();
        // Stiffness and compliance round differently; stiff waves have small displacements.
        let rounding =
            1e-13 * (state.approach.abs() + largest(traction.iter().copied()) / case.load_unit() * case.length);
        if !(apart <= 1e-7 * size + rounding) {
            return Err(format!("displacement differs by {apart:e} of {size:e}, rounding {rounding:e}"));
        }
    }
    let scale = largest(state.traction.iter().copied()).max(case.load_unit());
    for (k, ((t, g), p)) in traction.iter().zip(&state.gap).zip(&state.wall_pressure).enumerate() {
        if law.has_wall() && !(*g >= -2.0 * TOLERANCE * case.length) {
            return Err(format!("gap {g:e} behind a wall"));
        }
        if z == 0 && !(law.has_wall() && *g <= 0.0) {
            let response = law.response(*g, 0.0);
            // The gap is rounded; a law that jumps, as that of Dugdale, has no slope at its range.
            let blur = 1e-13 * (g.abs() + state.approach.abs() + case.length);
            let near = [g - blur, g + blur].map(|g| law.response(g, 0.0).traction[0]);
            let room = 4.0 * TOLERANCE * scale + largest(near.map(|t| t - response.traction[0]));
            if !((response.traction[0] - p - t).abs() <= room) {
                return Err(format!("point {k}: traction {t:e}, law {:e}, {room:e} allowed", response.traction[0]));
            }
        }
    }
    Ok(())
}

fn with_law(case: &Case, random: &mut Random) -> Verdict {
    let law = law(case, random)?.into_shared();
    let make = if random.chance(0.2) { Interface::in_all_components } else { Interface::new };
    let interface = match make(&case.body, &case.grid, &case.heights, std::sync::Arc::clone(&law)) {
        Ok(interface) => interface,
        Err(refusal) => return refused(&refusal),
    };
    let load = case.load(random, true);
    let solver = random.one_of(&[Solver::Auto, Solver::Auto, Solver::Newton, Solver::Fire, Solver::Fire2]);
    let state = match interface.press(load).solver(solver).tolerance(TOLERANCE).max_iterations(3000).solve() {
        Ok(state) => state,
        Err(SolveError::Refused(refusal)) => return refused(&refusal),
        Err(SolveError::Detached { .. }) => return Ok("law: parted"),
        Err(SolveError::NotConverged { state, .. }) => {
            let newton = solver == Solver::Newton || solver == Solver::Auto && interface.has_energy();
            return match state.traction.iter().any(|t| t.is_nan()) {
                true => Err(format!("{law:?} {solver} {load:?}: NaN")),
                false if newton => Ok("law, Newton: not converged"),
                false => Ok("law, dynamics: not converged"),
            };
        }
        Err(error) => return Err(format!("{law:?} {solver} {load:?}: {error}")),
    };
    let checked = interface_state(case, law.as_ref(), &state);
    checked.map(|()| "law: solved").map_err(|text| format!("{law:?} {solver} {load:?}: {text}"))
}

fn with_friction(case: &Case, random: &mut Random) -> Verdict {
    let limit = match random.below(2) {
        0 => Limit::Coulomb(random.decade(-3.0, 0.3)),
        _ => Limit::Tresca(case.stress * random.decade(-3.0, 1.0)),
    };
    let contact = match FrictionalContact::new(&case.body, &case.grid, &case.heights, limit) {
        Ok(contact) => contact,
        Err(refusal) => return refused(&refusal),
    };
    let load = case.load(random, false);
    let lateral = [random.unit() - 0.5, random.unit() - 0.5].map(|x| case.length * x * 0.1);
    let drive = Drive { load, lateral };
    let state = match contact.press(drive).tolerance(TOLERANCE).max_iterations(5000).solve() {
        Ok(state) => state,
        Err(SolveError::Refused(refusal)) => return refused(&refusal),
        Err(SolveError::NotConverged { .. }) => return Ok("friction: not converged"),
        Err(error) => return Err(format!("{limit:?} {drive:?}: {error}")),
    };
    let checked = friction_state(case, limit, load, &state);
    checked.map(|()| "friction: solved").map_err(|text| format!("{limit:?} {drive:?}: {text}"))
}

/// All components of a vector field on the axes x, y, z.
fn on_axes(grid: &Grid, field: &ndarray::Array3<f64>) -> [Vec<f64>; 3] {
    let mut fields = [0, 1, 2].map(|_| vec![0.0; grid.len()]);
    for (component, axis) in field.axis_iter(Axis(0)).zip(Components::of(grid).axes()) {
        fields[*axis] = component.iter().copied().collect();
    }
    fields
}

/// The displacement of all components, by direct sums.
fn displacement(case: &Case, traction: &ndarray::Array3<f64>) -> [Vec<f64>; 3] {
    let line = case.grid.is_line();
    case.direct(&on_axes(&case.grid, traction), |mode| {
        let finite = |z: Complex64| if z.re.is_finite() && z.im.is_finite() { z } else { Complex64::ZERO };
        let unit = case.units[1] / case.units[0];
        let mut matrix = case.plain.0.compliance_of(mode).map(|row| row.map(|entry| finite(entry) * unit));
        if line {
            matrix[1] = [Complex64::ZERO; 3];
        }
        matrix
    })
}

fn friction_state(case: &Case, limit: Limit, load: Load, state: &FrictionState) -> Result<(), String> {
    let z = state.traction.len_of(Axis(0)) - 1;
    let own = displacement(case, &state.traction);
    let pressure = state.pressure().to_owned();
    // Pressure and shear may move the surface of a thin plate far in opposite directions.
    let mut alone = state.traction.clone();
    alone.slice_mut(ndarray::s![..z, .., ..]).fill(0.0);
    let cancelled = 1e-13 * largest(displacement(case, &alone)[2].iter().copied());
    wall(case, load, pressure.view(), &own[2], state.gap.view(), state.approach, cancelled)?;
    let strongest = largest(pressure.iter().map(|p| if *p > 0.0 { limit.at(*p) } else { 0.0 }));
    for (k, p) in pressure.iter().enumerate() {
        let [_, ny] = case.grid.points();
        let shear = (0..z).map(|c| (state.traction[[c, k / ny, k % ny]] / case.stress).powi(2)).sum::<f64>().sqrt()
            * case.stress;
        let allowed = if *p > 0.0 { limit.at(*p) } else { 0.0 };
        if !(shear <= allowed + 2.0 * TOLERANCE * strongest) {
            return Err(format!("shear {shear:e}, limit {allowed:e}"));
        }
    }
    Ok(())
}

fn mixed(case: &Case, random: &mut Random) -> Verdict {
    let share = random.unit();
    let mut points = Array2::from_shape_simple_fn(case.heights.dim(), || random.unit() < share);
    points[[0, 0]] = true;
    let depth = case.length;
    let prescribed = match random.below(2) {
        0 => Prescribed::sticking(&case.grid, points.view(), [0.0, 0.0, -depth]),
        _ => Prescribed::frictionless(&case.grid, points.view(), -depth),
    };
    let posed = prescribed.and_then(|prescribed| MixedProblem::new(&case.body, &case.grid, prescribed));
    let problem = match posed {
        Ok(problem) => problem,
        Err(MixedError::Undetermined { .. } | MixedError::NothingHeld) => return Ok("refused: undetermined"),
        Err(error) => return Err(error.to_string()),
    };
    let budget = Budget { tolerance: TOLERANCE, max_iterations: 20_000 };
    let solution = match problem.solve(Method::ConjugateGradients, &budget, &mut ()) {
        Ok(solution) => solution,
        Err(MixedError::NotConverged { .. }) => return Ok("punch: not converged"),
        Err(error) => return Err(error.to_string()),
    };
    let own = displacement(case, &solution.traction);
    let (held, values, n) = (problem.prescribed().held(), problem.prescribed().values(), case.grid.len());
    for (k, &axis) in Components::of(&case.grid).axes().iter().enumerate() {
        for (i, u) in own[axis].iter().enumerate() {
            let traction = solution.traction.iter().nth(k * n + i).copied().unwrap_or(f64::NAN);
            if held[k * n + i]
                && !((u - values[k * n + i]).abs()
                    <= 2.0 * TOLERANCE * depth + 1e-12 * largest(own[axis].iter().copied()))
            {
                return Err(format!("held at {u:e} instead of {:e}", values[k * n + i]));
            }
            if !held[k * n + i] && traction != 0.0 {
                return Err(format!("traction {traction:e} on a free point"));
            }
        }
    }
    Ok("punch: solved")
}

fn judge(number: u64) -> Verdict {
    let mut random = Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let random = &mut random;
    let kind = random.below(10);
    let Some(case) = Case::random(random) else { return Ok("refused: empty") };
    let verdict = match kind {
        0..5 => hard_wall(&case, random),
        5..7 => with_law(&case, random),
        7 | 8 if case.grid.len() <= 144 => with_friction(&case, random),
        7 | 8 => hard_wall(&case, random),
        _ if case.grid.len() <= 144 => mixed(&case, random),
        _ => hard_wall(&case, random),
    };
    verdict.map_err(|text| {
        let Case { body, grid, length, .. } = &case;
        format!(
            "case {number}: {body:?}, {:?} points, lengths {:?}, h_rms {length:e}: {text}",
            grid.points(),
            grid.lengths()
        )
    })
}

#[test]
fn every_problem_is_solved_to_its_accuracy_or_refused_by_name() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    let cases = number("GFMD_SPACE").unwrap_or(CASES);
    let first = number("GFMD_SPACE_SEED").unwrap_or(1);
    let next = AtomicU64::new(first);
    let (counts, bad) = (Mutex::new(BTreeMap::new()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= first + cases {
                        break;
                    }
                    let start = Instant::now();
                    let verdict = std::panic::catch_unwind(|| judge(number))
                        .unwrap_or_else(|_| Err(format!("case {number}: panic")));
                    let verdict = if start.elapsed() > LONGEST {
                        Err(format!("case {number}: {:?}", start.elapsed()))
                    } else {
                        verdict
                    };
                    match verdict {
                        Ok(kind) => *counts.lock().unwrap().entry(kind).or_insert(0_u64) += 1,
                        Err(text) => bad.lock().unwrap().push(text),
                    }
                }
            });
        }
    });
    let (counts, bad) = (counts.into_inner().unwrap(), bad.into_inner().unwrap());
    println!("{cases} cases, {} bad: {counts:#?}", bad.len());
    assert!(bad.is_empty(), "{} of {cases} cases:\n{}", bad.len(), bad[..bad.len().min(40)].join("\n"));
}
