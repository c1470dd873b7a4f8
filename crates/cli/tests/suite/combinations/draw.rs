//! Random problems. The index of a case seeds all its random numbers.

use std::fmt::Write as _;
use std::path::Path;

use ndarray::{Array1, Array2, ArrayD, IxDyn};

use super::elastic::{Base, Layer, Plane, Stack};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number in [0, 1).
    pub(crate) fn number(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    /// Returns a number between two positive bounds with a uniformly distributed logarithm.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.number())
    }

    pub(crate) fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.number() * (high - low + 1) as f64) as usize
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.number() < probability
    }

    pub(crate) fn of<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.count(0, from.len() - 1)]
    }
}

/// Keeps six digits, so that the command and the reference have the same number.
pub(crate) fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap()
}

#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) first: Stack,
    pub(crate) second: Option<Stack>,
}

impl Body {
    /// Returns the uppermost material.
    pub(crate) fn top(&self) -> Layer {
        uppermost(&self.first)
    }

    /// Returns E* of both bodies together.
    pub(crate) fn contact_modulus(&self) -> f64 {
        let others = self.second.as_ref().map_or(0.0, |second| 1.0 / uppermost(second).contact_modulus());
        1.0 / (1.0 / self.top().contact_modulus() + others)
    }

    pub(crate) fn compliance(&self, q: f64, held: bool) -> f64 {
        self.first.compliance(q, held) + self.second.as_ref().map_or(0.0, |second| second.compliance(q, held))
    }

    /// Returns the limit of q times the compliance for long waves.
    pub(crate) fn lowest(&self) -> f64 {
        let of = |stack: &Stack| match stack.base {
            Base::HalfSpace(young, poisson) => 2.0 * (1.0 - poisson * poisson) / young,
            _ => 0.0,
        };
        of(&self.first) + self.second.as_ref().map_or(0.0, of)
    }

    pub(crate) fn is_half_space(&self) -> bool {
        self.first.layers.is_empty() && self.second.as_ref().is_none_or(|second| second.layers.is_empty())
    }
}

fn uppermost(stack: &Stack) -> Layer {
    match (stack.layers.first(), stack.base) {
        (Some(layer), _) => *layer,
        (None, Base::HalfSpace(young, poisson)) => Layer { young, poisson, height: f64::INFINITY },
        _ => unreachable!("a body has a layer or is a half-space"),
    }
}

#[derive(Clone, Debug)]
pub(crate) enum Law {
    Exponential {
        gamma: f64,
        range: f64,
    },
    Dugdale {
        gamma: f64,
        range: f64,
    },
    Morse {
        gamma: f64,
        range: f64,
    },
    HarmonicCosine {
        gamma: f64,
        curvature: f64,
    },
    /// Tractions at equal steps of the gap, from zero gap with a wall, otherwise from one step before it.
    Table {
        first: f64,
        step: f64,
        tractions: [f64; 5],
    },
    /// One of the five cohesive laws, without sliding.
    Cohesive {
        name: &'static str,
        work: f64,
        range: f64,
    },
}

impl Law {
    /// Returns the tension at a gap, without the wall.
    pub(crate) fn tension(&self, g: f64) -> f64 {
        match *self {
            Self::Exponential { gamma, range } => gamma / range * (-g / range).exp(),
            Self::Dugdale { gamma, range } => {
                if g <= range {
                    gamma / range
                } else {
                    0.0
                }
            }
            Self::Morse { gamma, range } => 2.0 * gamma / range * ((-g / range).exp() - (-2.0 * g / range).exp()),
            Self::HarmonicCosine { gamma, curvature } => {
                let w = (2.0 * curvature / gamma).sqrt();
                match g {
                    g if g < 0.0 => curvature * g,
                    g if g < std::f64::consts::PI / w => 0.5 * gamma * w * (w * g).sin(),
                    _ => 0.0,
                }
            }
            Self::Table { first, step, tractions } => hermite(first, step, tractions, g),
            Self::Cohesive { work, range, .. } => work / range * (g / range) * (-g / range).exp(),
        }
    }

    /// Returns the energy at a gap, zero far away; `None` for a law that has no potential when it slides.
    pub(crate) fn energy(&self, g: f64) -> Option<f64> {
        Some(match *self {
            Self::Exponential { gamma, range } => -gamma * (-g / range).exp(),
            Self::Dugdale { gamma, range } => -gamma * (1.0 - g / range).max(0.0),
            Self::Morse { gamma, range } => gamma * ((-2.0 * g / range).exp() - 2.0 * (-g / range).exp()),
            Self::HarmonicCosine { gamma, curvature } => {
                let w = (2.0 * curvature / gamma).sqrt();
                match g {
                    g if g < 0.0 => -gamma + 0.5 * curvature * g * g,
                    g if g < std::f64::consts::PI / w => -0.5 * gamma * (1.0 + (w * g).cos()),
                    _ => 0.0,
                }
            }
            Self::Table { first, step, tractions } => {
                // Simpson's rule is exact for cubics.
                let last = first + 4.0 * step;
                let inner = (0..5).map(|k| first + f64::from(k) * step).filter(|end| *end > g && *end < last);
                let ends: Vec<f64> = [g].into_iter().chain(inner).chain([last]).filter(|end| *end <= last).collect();
                let of = |g: f64| hermite(first, step, tractions, g);
                let piece = |pair: &[f64]| {
                    (pair[1] - pair[0]) / 6.0 * (of(pair[0]) + 4.0 * of(0.5 * (pair[0] + pair[1])) + of(pair[1]))
                };
                -ends.windows(2).map(piece).sum::<f64>()
            }
            Self::Cohesive { .. } => return None,
        })
    }

    pub(crate) fn has_wall(&self) -> bool {
        match *self {
            Self::Exponential { .. } | Self::Dugdale { .. } => true,
            Self::Table { first, .. } => first == 0.0,
            _ => false,
        }
    }

    /// Returns the gap at which the traction jumps, if any.
    pub(crate) fn jump(&self) -> Option<f64> {
        if let Self::Dugdale { range, .. } = self { Some(*range) } else { None }
    }

    pub(crate) fn words(&self) -> String {
        match self {
            Self::Exponential { gamma, range } => format!("--law exponential --param gamma={gamma},range={range}"),
            Self::Dugdale { gamma, range } => format!("--law dugdale --param gamma={gamma},range={range}"),
            Self::Morse { gamma, range } => format!("--law morse --param gamma={gamma},range={range}"),
            Self::HarmonicCosine { gamma, curvature } => {
                format!("--law harmonic-cosine --param gamma={gamma},curvature={curvature}")
            }
            Self::Table { first, step, tractions } => {
                let row = |(k, traction): (i32, &f64)| format!("{}:{traction}", first + f64::from(k) * step);
                let rows: Vec<String> = (0..).zip(tractions).map(row).collect();
                format!("--law table --law-table={}", rows.join(","))
            }
            Self::Cohesive { name, work, range } => {
                format!("--law {name} --param phi_n={work},phi_t={work},delta_n={range},delta_t={range}")
            }
        }
    }
}

/// Evaluates the cubic Hermite interpolant of values at equal steps, with slopes of Fritsch and Butland; zero beyond
/// the last value, the tangent before the first one.
fn hermite(first: f64, step: f64, values: [f64; 5], x: f64) -> f64 {
    let secant = |k: usize| (values[k + 1] - values[k]) / step;
    let edge = |near: f64, next: f64| {
        let slope = 1.5 * near - 0.5 * next;
        match (slope * near > 0.0, near * next < 0.0 && slope.abs() > 3.0 * near.abs()) {
            (false, _) => 0.0,
            (true, true) => 3.0 * near,
            (true, false) => slope,
        }
    };
    let slope = |k: usize| match k {
        0 => edge(secant(0), secant(1)),
        4 => edge(secant(3), secant(2)),
        _ if secant(k - 1) * secant(k) > 0.0 => 2.0 / (1.0 / secant(k - 1) + 1.0 / secant(k)),
        _ => 0.0,
    };
    let t = (x - first) / step;
    if t < 0.0 {
        return values[0] + (x - first) * slope(0);
    }
    if t >= 4.0 {
        return 0.0;
    }
    let k = t as usize;
    let s = t - k as f64;
    let rest = 1.0 - s;
    values[k] * (1.0 + 2.0 * s) * rest * rest
        + step * slope(k) * s * rest * rest
        + values[k + 1] * s * s * (3.0 - 2.0 * s)
        - step * slope(k + 1) * s * s * rest
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Components {
    Normal,
    Held,
    All,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Control {
    Pressure,
    PStar,
    Approach,
}

/// Random problem.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) index: u64,
    pub(crate) is_path: bool,
    pub(crate) plane: Plane,
    pub(crate) is_line: bool,
    /// Gradient requested from the generator.
    pub(crate) asked_gradient: Option<f64>,
    /// Heights of both surfaces, if read from files.
    pub(crate) heights: Option<Vec<f64>>,
    pub(crate) lower: Option<Vec<f64>>,
    pub(crate) body: Body,
    pub(crate) is_free: bool,
    pub(crate) law: Option<Law>,
    /// Hardness of each point.
    pub(crate) hardness: Option<Vec<f64>>,
    pub(crate) components: Components,
    pub(crate) is_steep: bool,
    pub(crate) has_lower: bool,
    /// Displacement of the base, or with `true` the traction on it: components x, y, z of each point.
    pub(crate) moved: Option<(Vec<[f64; 3]>, bool)>,
    pub(crate) control: Control,
    pub(crate) loads: Vec<f64>,
    pub(crate) lateral: Vec<f64>,
    pub(crate) direction: f64,
    pub(crate) friction: Option<f64>,
    pub(crate) shear_strength: Option<f64>,
    pub(crate) statistics: bool,
    pub(crate) flow: bool,
    pub(crate) threshold: bool,
    /// Depth of the electrodes of the conductors.
    pub(crate) conductor_height: Option<f64>,
    /// VTK file.
    pub(crate) vtk: Option<String>,
    /// True if the heights are the sum of two files.
    pub(crate) is_composite: bool,
    pub(crate) solver: &'static str,
    pub(crate) tolerance: f64,
    /// Command without its outlets.
    pub(crate) words: Vec<String>,
    /// Further command to run on the result.
    pub(crate) further: &'static str,
}

const RATIOS: [f64; 7] = [0.0, 0.3, 0.49, 0.5, -0.3, 0.2, 0.4];

pub(crate) fn material(dice: &mut Dice) -> (f64, f64) {
    (short(dice.scale(0.5, 5.0)), dice.of(&RATIOS))
}

pub(crate) fn body(dice: &mut Dice, text: &mut String, needs_layers: bool, tall: bool, bases: &[usize]) -> Body {
    let (young, poisson) = material(dice);
    let _ = write!(text, " --young {young} --poisson {poisson}");
    let second = |dice: &mut Dice, text: &mut String| -> Option<Stack> {
        if needs_layers || !dice.chance(0.1) {
            return None;
        }
        let (young, poisson) = material(dice);
        let height = dice.chance(0.3).then(|| short(dice.between(0.3, 1.0)));
        let _ = write!(text, " --second-body {young},{poisson}{}", height.map_or(String::new(), |h| format!(",{h}")));
        Some(match height {
            Some(height) => Stack { layers: vec![Layer { young, poisson, height }], base: Base::Bonded },
            None => Stack::half_space(young, poisson),
        })
    };
    if !needs_layers && dice.chance(0.5) {
        return Body { first: Stack::half_space(young, poisson), second: second(dice, text) };
    }
    let least = if tall { 0.25 } else { 0.1 };
    let height = short(dice.scale(least, 1.0));
    let _ = write!(text, " --height {height}");
    let mut layers = vec![Layer { young, poisson, height }];
    for _ in 0..dice.of(&[0, 0, 0, 1, 2]) {
        let (young, poisson) = material(dice);
        let height = short(dice.scale(0.1, 0.5));
        let _ = write!(text, " --layer {young},{poisson},{height}");
        layers.push(Layer { young, poisson, height });
    }
    let base = match dice.of(bases) {
        0 => Base::Bonded,
        1 => {
            text.push_str(" --base sliding");
            Base::Sliding
        }
        2 => {
            text.push_str(" --base free");
            Base::Free
        }
        _ => {
            let (young, poisson) = material(dice);
            let _ = write!(text, " --base half-space --base-young {young} --base-poisson {poisson}");
            Base::HalfSpace(young, poisson)
        }
    };
    Body { first: Stack { layers, base }, second: second(dice, text) }
}

/// Returns waves of a few wavelengths with random phases: `[nx, ny]`.
pub(crate) fn waves(dice: &mut Dice, plane: Plane, amplitude: f64) -> Vec<f64> {
    let waves: Vec<[f64; 4]> = (0..5)
        .map(|_| {
            let m = [0, 1]
                .map(|axis| if plane.n[axis] == 1 { 0.0 } else { dice.count(0, (plane.n[axis] / 3).min(3)) as f64 });
            [m[0], m[1], dice.between(0.0, std::f64::consts::TAU), dice.number()]
        })
        .collect();
    (0..plane.len())
        .map(|place| {
            let at = [(place / plane.n[1]) as f64 / plane.n[0] as f64, (place % plane.n[1]) as f64 / plane.n[1] as f64];
            waves
                .iter()
                .map(|[m, n, phase, a]| amplitude * a * (std::f64::consts::TAU * (m * at[0] + n * at[1]) + phase).cos())
                .sum::<f64>()
        })
        .collect()
}

/// Writes a field of points in the format that the program reads.
pub(crate) fn write(folder: &Path, name: &str, plane: Plane, is_line: bool, values: &[f64]) {
    if is_line {
        ndarray_npy::write_npy(folder.join(name), &Array1::from_vec(values.to_vec())).unwrap();
    } else {
        let field = Array2::from_shape_vec((plane.n[0], plane.n[1]), values.to_vec()).unwrap();
        ndarray_npy::write_npy(folder.join(name), &field).unwrap();
    }
}

impl Case {
    /// Returns true if a dynamic solver moves all components.
    pub(crate) fn moves_all(&self) -> bool {
        let is_dynamic = ["verlet", "verlet-critical", "verlet-modes", "fire"].contains(&self.solver);
        let is_wall = self.law.is_none() && self.hardness.is_none() && !self.is_free && !self.is_steep;
        self.components == Components::All && is_dynamic && is_wall && self.control != Control::Approach
    }

    /// Draws the case and writes its input into `folder`.
    pub(crate) fn draw(index: u64, folder: &Path) -> Self {
        let dice = &mut Dice::new(index);
        let is_path = dice.chance(0.3);
        // A tenth of the problems combines options freely; most of these are refused. The others are valid.
        let is_wild = dice.chance(0.12);
        let mut text = String::from(if is_path { "path" } else { "contact" });
        let is_line = dice.chance(0.15);
        let side = |dice: &mut Dice| if dice.chance(0.5) { 2 * dice.count(2, 7) + 1 } else { 2 * dice.count(2, 8) };
        let n = if is_line { [dice.count(8, 40), 1] } else { [side(dice), side(dice)] };
        let n = if is_path && !is_line { n.map(|n| n.min(9)) } else { n };
        let length_x = if dice.chance(0.5) { 1.0 } else { short(dice.between(0.7, 1.6)) };
        let length = match (is_line, dice.chance(0.3)) {
            (true, _) => [length_x, 1.0],
            (_, true) => [length_x, short(length_x * dice.between(0.7, 1.4))],
            _ => [length_x, length_x * n[1] as f64 / n[0] as f64],
        };
        let mut plane = Plane { n, length };
        let is_generated = dice.chance(0.5);
        let gradient = short(dice.scale(0.03, 0.15));
        let (mut asked_gradient, mut given, mut lower) = (None, None, None);
        if is_generated {
            let seed = dice.count(1, 1000);
            let eps_f = 1 + (n[0].min(if is_line { n[0] } else { n[1] }) / 4).saturating_sub(1);
            let hurst = dice.of(&[0.0, 0.3, 0.8, 1.0]);
            let dim = if is_line { " --dim 2" } else { "" };
            let size = if is_line { format!("{}", n[0]) } else { format!("{},{}", n[0], n[1]) };
            let _ = write!(
                text,
                " --n {size}{dim} --eps-t-inv 1 --eps-f-inv {eps_f} --hurst {hurst} --seed {seed} \
                 --rms-gradient {gradient}"
            );
            // With a single length the spacings are equal.
            if !is_line && (length[1] - length_x * n[1] as f64 / n[0] as f64).abs() > 1e-9 {
                let _ = write!(text, " --size {},{}", length[0], length[1]);
            } else {
                let _ = write!(text, " --size {length_x}");
            }
            asked_gradient = Some(gradient);
        } else {
            let heights = waves(dice, plane, 0.1 * gradient);
            write(folder, &format!("h{index}.npy"), plane, is_line, &heights);
            let _ = write!(text, " --surface h{index}.npy");
            if is_line {
                let _ = write!(text, " --size {length_x}");
            } else {
                let _ = write!(text, " --size {},{}", length[0], length[1]);
            }
            given = Some(heights);
        }
        if is_line {
            // A line has unit length across.
            plane.length[1] = 1.0;
        }
        let wild = |dice: &mut Dice, probability: f64| is_wild && dice.chance(probability);
        let is_free = dice.chance(0.3);
        let kind = dice.count(0, 99);
        let has_lower = !is_path && ((!is_free && kind < 7) || wild(dice, 0.2));
        let is_steep = !is_path && ((!is_free && (7..14).contains(&kind)) || wild(dice, 0.2));
        let components = match kind {
            // A patch of a profile has no lateral level.
            14..19 if !(is_path || is_free && is_line) => Components::All,
            19..24 if !is_free => Components::Held,
            _ if wild(dice, 0.3) => dice.of(&[Components::All, Components::Held]),
            _ if has_lower && dice.chance(0.3) => Components::Held,
            _ => Components::Normal,
        };
        let with_friction = is_path && (24..54).contains(&kind);
        let plain = components == Components::Normal && !is_steep && !has_lower && !with_friction;
        // By number: bonded, sliding, a plate, on a half-space.
        let bases: &[usize] = match () {
            () if is_wild => &[0, 1, 2, 3],
            () if has_lower => &[0],
            () if is_free && (with_friction || components == Components::All) => &[0, 0, 3],
            () if is_free => &[0, 0, 1, 3],
            () => &[0, 0, 0, 1, 1, 2, 3, 3],
        };
        let body = body(dice, &mut text, has_lower, is_free, bases);
        if is_free {
            text.push_str(" --boundary free");
        }
        let modulus = body.contact_modulus();
        let between = has_lower && !is_steep && components != Components::All;
        let may_have_law = plain || components != Components::Normal && !has_lower && !is_steep;
        let has_law = (may_have_law && dice.chance(0.3)) || (between && dice.chance(0.4)) || wild(dice, 0.3);
        let size = gradient * length_x;
        let law = has_law.then(|| {
            let gamma = short(modulus * size * gradient * dice.scale(0.01, 0.1));
            // Process zone of one to ten grid steps.
            let range = short((gamma / modulus * plane.spacing()[0] * dice.scale(1.3, 12.0)).sqrt());
            let name = dice.of(&["xu-needleman", "bsg", "npb", "npc", "c3d"]);
            match dice.count(0, 9) {
                0..=2 => Law::Exponential { gamma, range },
                3 => Law::Table {
                    first: 0.0,
                    step: 0.5 * range,
                    tractions: [1.0, 0.8, 0.3, 0.1, 0.0].map(|t| t * gamma / range),
                },
                4 | 5 => Law::Dugdale { gamma, range },
                6 => Law::Morse { gamma, range },
                7 => {
                    let step = 0.75 * range;
                    let tractions = [-1.5, 0.0, 0.5, 0.2, 0.0].map(|t| t * gamma / range);
                    Law::Table { first: -step, step, tractions }
                }
                8 => Law::HarmonicCosine { gamma, curvature: short(gamma / (range * range)) },
                _ => Law::Cohesive { name, work: gamma, range },
            }
        });
        if let Some(law) = &law {
            let _ = write!(text, " {}", law.words());
        }
        let has_hardness = may_have_law && law.is_none() && dice.chance(0.25)
            || wild(dice, 0.2)
            || has_lower && law.is_none() && dice.chance(0.4);
        let hardness = has_hardness.then(|| {
            let most = short(modulus * gradient * dice.scale(0.2, 2.0));
            if dice.chance(0.6) {
                let _ = write!(text, " --hardness {most}");
                return vec![most; plane.len()];
            }
            let values: Vec<f64> = (0..plane.len()).map(|_| short(most * dice.scale(0.5, 2.0))).collect();
            write(folder, &format!("p{index}.npy"), plane, is_line, &values);
            let _ = write!(text, " --hardness p{index}.npy");
            values
        });
        match components {
            Components::All => text.push_str(" --components all"),
            Components::Held => text.push_str(" --components held"),
            Components::Normal => {}
        }
        if is_steep {
            text.push_str(" --finite-slope");
        }
        if has_lower {
            let heights = waves(dice, plane, 0.1 * gradient);
            write(folder, &format!("l{index}.npy"), plane, is_line, &heights);
            lower = Some(heights);
            let _ = write!(text, " --lower-surface l{index}.npy");
        }
        let can_move = !is_free && !matches!(body.first.base, Base::HalfSpace(..)) || is_wild;
        // The shortest waves of a surface held sideways have other averages.
        let is_odd = plane.n.iter().all(|n| n % 2 == 1);
        let may_move = (plain || is_wild || components != Components::Normal && !is_steep && !has_lower && is_odd)
            && !body.first.layers.is_empty()
            && can_move;
        // Random numbers of earlier paths stay.
        let moves = may_move && if is_path { index.is_multiple_of(3) } else { dice.chance(0.4) };
        let moved = moves.then(|| {
            let is_traction = body.first.base == Base::Free;
            let amplitude = if is_traction { 0.05 * modulus * gradient } else { 0.03 * size };
            let wanted = if dice.chance(0.5) { 1 } else { 3 };
            let mut fields = vec![waves(dice, plane, amplitude)];
            if wanted == 3 {
                fields.insert(0, waves(dice, plane, amplitude));
                fields.insert(1, if is_line { vec![0.0; plane.len()] } else { waves(dice, plane, amplitude) });
            }
            if is_traction {
                for field in &mut fields {
                    let mean = field.iter().sum::<f64>() / field.len() as f64;
                    field.iter_mut().for_each(|value| *value -= mean);
                }
            }
            let at = |place: usize| match &fields[..] {
                [z] => [0.0, 0.0, z[place]],
                [x, y, z] => [x[place], y[place], z[place]],
                _ => unreachable!("one or three components"),
            };
            let values: Vec<[f64; 3]> = (0..plane.len()).map(at).collect();
            let name = format!("b{index}.npy");
            if wanted == 1 {
                write(folder, &name, plane, is_line, &fields[0]);
            } else {
                let (shape, flat): (Vec<usize>, Vec<f64>) = if is_line {
                    (vec![n[0], 2], values.iter().flat_map(|[x, _, z]| [*x, *z]).collect())
                } else {
                    (vec![n[0], n[1], 3], values.iter().flatten().copied().collect())
                };
                ndarray_npy::write_npy(folder.join(&name), &ArrayD::from_shape_vec(IxDyn(&shape), flat).unwrap())
                    .unwrap();
            }
            let _ = write!(text, " --base-{} {name}", if is_traction { "traction" } else { "displacement" });
            (values, is_traction)
        });
        let (friction, shear_strength) = match with_friction || (is_path && wild(dice, 0.2)) {
            true if dice.chance(0.7) => (Some(dice.of(&[0.1, 0.3, 0.6])), None),
            true => (None, Some(short(modulus * gradient * dice.scale(0.03, 0.3)))),
            false => (None, None),
        };
        if let Some(friction) = friction {
            let _ = write!(text, " --friction {friction}");
        }
        if let Some(strength) = shear_strength {
            let _ = write!(text, " --shear-strength {strength}");
        }
        // Loads.
        let least_hardness = hardness.as_ref().map_or(f64::INFINITY, |h| h.iter().sum::<f64>() / h.len() as f64);
        let control = match dice.count(0, 9) {
            0..=2 => Control::Pressure,
            3..=5 => Control::PStar,
            _ if is_line && is_free && body.lowest() > 0.0 && !is_wild => Control::Pressure,
            _ => Control::Approach,
        };
        let count = if is_path { dice.count(2, 3) } else { dice.of(&[1, 1, 2, 3]) };
        let most = if law.is_some() { 0.5 } else { 1.2 };
        let loads: Vec<f64> = (0..count)
            .map(|k| {
                let p_star = if k == 0 || is_path { dice.scale(0.02, most) } else { dice.scale(1e-3, most) };
                let pressure = (p_star * modulus * gradient).min(dice.between(0.3, 0.95) * least_hardness);
                match control {
                    Control::Pressure => short(pressure),
                    Control::PStar => short(pressure / (modulus * gradient)),
                    Control::Approach => short(size * dice.scale(0.01, 0.25)),
                }
            })
            .collect();
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let flag = match control {
            Control::Pressure => "--pressure",
            Control::PStar => "--p-star",
            Control::Approach => "--approach",
        };
        let _ = write!(text, " {flag} {}", list(&loads));
        let (mut lateral, mut direction) = (Vec::new(), 0.0);
        if is_path {
            let slides = friction.is_some() || shear_strength.is_some();
            // A patch needs lateral support.
            let is_held = !is_free || !is_line && body.first.base != Base::Sliding;
            let may_slide = is_held && hardness.is_none() && moved.is_none() && components != Components::Held;
            if slides || (may_slide && dice.chance(0.2)) || wild(dice, 0.3) {
                let amplitude = size * dice.scale(0.01, 0.2);
                lateral = loads
                    .iter()
                    .enumerate()
                    .map(|(k, _)| short(if k == 0 { 0.0 } else { amplitude * dice.between(-1.0, 1.0) }))
                    .collect();
                let _ = write!(text, " --lateral={}", list(&lateral));
                if !is_line && dice.chance(0.5) {
                    direction = dice.of(&[30.0, 45.0, 90.0]);
                    let _ = write!(text, " --direction {direction}");
                }
            }
            text.push_str(" --steps 1");
        }
        let hard_wall = law.is_none();
        let statistics = if is_path { index.is_multiple_of(2) } else { dice.chance(0.4) || wild(dice, 0.3) };
        let flow = !is_path && (!is_line && dice.chance(0.3) || wild(dice, 0.2));
        let threshold = !is_path
            && !is_line
            && hard_wall
            && !is_steep
            && hardness.is_none()
            && loads.len() > 1
            && dice.chance(0.15);
        for (flag, given) in [("--statistics", statistics), ("--flow", flow), ("--flow-threshold", threshold)] {
            if given {
                let _ = write!(text, " {flag}");
            }
        }
        let tolerance = dice.of(&[1e-8, 1e-8, 1e-9, 1e-6]);
        let tolerance = if components == Components::All || friction.is_some() || shear_strength.is_some() {
            1e-6
        } else {
            tolerance
        };
        if tolerance != 1e-8 {
            let _ = write!(text, " --tolerance {tolerance:e}");
        }
        let plain_wall = plain && hard_wall && hardness.is_none() && !is_free && !is_path;
        let solver = if is_path {
            "auto"
        } else if plain_wall && dice.chance(0.4) {
            dice.of(&[
                "cg",
                "projected-cg",
                "preconditioned-cg",
                "augmented-lagrangian",
                "verlet",
                "verlet-critical",
                "verlet-modes",
                "fire",
                "fire2",
            ])
        } else if hard_wall && (is_free || hardness.is_some()) && dice.chance(0.3) {
            dice.of(&["preconditioned-cg", "projected-cg", "cg"])
        } else if components == Components::All && hard_wall && hardness.is_none() && !is_free && dice.chance(0.5) {
            dice.of(&["verlet", "verlet-critical", "fire", "preconditioned-cg"])
        } else if law.is_some() && dice.chance(0.2) {
            dice.of(&["newton", "fire", "fire2"])
        } else {
            "auto"
        };
        if solver != "auto" {
            let _ = write!(text, " --solver {solver}");
        }
        if solver.starts_with("verlet") || solver.starts_with("fire") {
            text.push_str(" --max-iterations 20000");
        }
        let conductor_height = (statistics && dice.chance(0.4)).then(|| dice.of(&[0.2, 0.5, 2.0]));
        if let Some(height) = conductor_height {
            let _ = write!(text, " --conductor-height {height}");
        }
        let vtk = (!is_path && dice.chance(0.3)).then(|| format!("out{index}.{}", dice.of(&["vti", "vtp"])));
        // Second surface, moved by whole steps and by parts of them.
        let is_composite = given.is_some() && !is_free && !has_lower && dice.chance(0.3);
        if let (Some(heights), true) = (&mut given, is_composite) {
            let second = waves(dice, plane, 0.05 * gradient);
            write(folder, &format!("second{index}.npy"), plane, is_line, &second);
            let part = dice.of(&[0.0, 0.0, 0.3, -0.45]);
            let steps = [dice.count(0, n[0]), dice.count(0, n[1])].map(|steps| steps as f64 + part);
            let spacing = plane.spacing();
            let shift = [0, 1].map(|axis| if plane.n[axis] == 1 { 0.0 } else { steps[axis] * spacing[axis] });
            let _ = write!(text, " --second-surface second{index}.npy --shift={}", shift[0]);
            if !is_line {
                let _ = write!(text, ",{}", shift[1]);
            }
            let modes: Vec<[f64; 2]> = (plane.transform(&second).into_iter().enumerate())
                .map(|(place, [re, im])| {
                    let [x, y] = plane.wave(place);
                    let (sine, cosine) = (x * shift[0] + y * shift[1]).sin_cos();
                    [re * cosine + im * sine, im * cosine - re * sine]
                })
                .collect();
            heights.iter_mut().zip(plane.inverse(&modes)).for_each(|(h, other)| *h += other);
        }
        let further = dice.of(&["check", "check", "body", "body", "report", "resume", "check --rerun", ""]);
        // A problem that cannot be refined is refused.
        let has_finer = !has_lower && !is_steep && !is_line && moved.is_none() && !threshold;
        let is_asked = has_finer && dice.chance(0.2) || wild(dice, 0.05);
        let grid_error = if is_asked { dice.of(&["refine", "refine", "none"]) } else { "estimate" };
        if grid_error != "estimate" {
            let _ = write!(text, " --grid-error {grid_error}");
        }
        let words = text.split_whitespace().map(str::to_owned).collect();
        Self {
            index,
            is_path,
            plane,
            is_line,
            asked_gradient,
            heights: given,
            lower,
            body,
            is_free,
            law,
            hardness,
            components,
            is_steep,
            has_lower,
            moved,
            control,
            loads,
            lateral,
            direction,
            friction,
            shear_strength,
            statistics,
            flow,
            threshold,
            conductor_height,
            vtk,
            is_composite,
            solver,
            tolerance,
            words,
            further,
        }
    }

    /// Returns the kinds of the case.
    pub(crate) fn kinds(&self) -> Vec<&'static str> {
        let base = match self.body.first.base {
            Base::HalfSpace(..) if self.body.first.layers.is_empty() => "half-space",
            Base::HalfSpace(..) => "layers on a half-space",
            Base::Bonded => "bonded base",
            Base::Sliding => "sliding base",
            Base::Free => "plate",
        };
        let all = [
            (true, if self.is_path { "path" } else { "contact" }),
            (true, base),
            (self.is_line, "profile"),
            (self.is_free, "free boundaries"),
            (self.body.second.is_some(), "second body"),
            (self.law.is_some(), "law"),
            (self.hardness.is_some(), "hardness"),
            (self.friction.is_some() || self.shear_strength.is_some(), "friction"),
            (self.components == Components::All, "all components"),
            (self.components == Components::Held, "held sideways"),
            (self.is_steep, "finite slopes"),
            (self.has_lower, "lower surface"),
            (self.moved.is_some(), "moved base"),
            (self.statistics, "statistics"),
            (self.flow, "flow"),
            (self.threshold, "flow threshold"),
            (self.conductor_height.is_some(), "electrodes"),
            (self.words.iter().any(|word| word == "refine"), "refined grid"),
            (self.vtk.is_some(), "VTK"),
            (self.is_composite, "two surfaces"),
            (self.solver != "auto", "a named solver"),
            (!self.lateral.is_empty(), "lateral path"),
        ];
        all.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).collect()
    }
}
