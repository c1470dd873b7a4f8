//! Random problem, and the response of its surface by direct Fourier sums.

use std::f64::consts::TAU;

use gfmd_contact::Load;
use gfmd_field::{Grid, Mode};
use gfmd_green::{Base, Body, Complex64, Height, Material};
use ndarray::{Array2, ArrayView2};

/// Largest number of points: direct sums take its square.
const MOST_POINTS: usize = 640;

/// Generator SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Returns a number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    pub(crate) fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Returns a power of ten with an exponent between these bounds.
    pub(crate) fn decade(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(low + (high - low) * self.unit())
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// Body, grid and heights, with the units of stress and of heights.
pub(crate) struct Case {
    pub(crate) body: Body,
    pub(crate) grid: Grid,
    /// Body and grid in units of the modulus and of the cell, for reference values, and these units.
    pub(crate) plain: (Body, Grid),
    pub(crate) units: [f64; 2],
    pub(crate) heights: Array2<f64>,
    /// Unit of stress, E* h_rms / side.
    pub(crate) stress: f64,
    /// Rms height.
    pub(crate) length: f64,
}

impl Case {
    pub(crate) fn random(random: &mut Random) -> Option<Self> {
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
                    0 => Base::SLIDING,
                    1 => Base::FREE,
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
        // For a flat surface the law sets the length scale.
        let length = if length > 0.0 { length } else { 1e-3 * cell };
        let lengths = if ny == 1 { [1.0, 1.0] } else { lengths.map(|side| side / cell) };
        let plain = (body.in_units(modulus, cell), Grid::new([nx, ny], lengths).unwrap());
        Some(Self { stress: modulus * (length / side), length, body, grid, plain, units: [modulus, cell], heights })
    }

    pub(crate) fn clearance(&self) -> Array2<f64> {
        let highest = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.heights.mapv(|h| highest - h)
    }

    /// Returns the unit of loads: the softest stiffness of a wave times the rms height.
    pub(crate) fn load_unit(&self) -> f64 {
        let softest = |modes: &mut dyn Iterator<Item = Mode>| {
            let waves = modes.filter(|mode| !mode.is_uniform());
            waves.map(|mode| self.plain.0.normal_stiffness(mode.wavenumber())).fold(f64::INFINITY, f64::min)
        };
        let found = softest(&mut self.plain.1.modes()) * self.units[0] * (self.length / self.units[1]);
        if found.is_finite() && found > 0.0 { found } else { self.stress }
    }

    pub(crate) fn load(&self, random: &mut Random, tension: bool) -> Load {
        let sign = if tension && random.chance(0.3) { -1.0 } else { 1.0 };
        if random.chance(0.6) {
            Load::MeanPressure(sign * self.load_unit() * random.decade(-12.0, 4.0))
        } else {
            Load::Approach(sign * self.length * random.decade(-12.0, 2.0))
        }
    }

    /// Returns the response of the surface to fields of all components, with the `kernel` of each mode, by direct sums.
    /// Components are x, y, z. All are multiplied by `unit` in between, so that no square is too large or too small.
    pub(crate) fn direct(
        &self,
        fields: &[Vec<f64>; 3],
        kernel: impl Fn(&Mode) -> [[Complex64; 3]; 3],
    ) -> [Vec<f64>; 3] {
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

    /// Returns the rounding error of the displacement by tractions up to `largest`, if all are in the softest wave.
    pub(crate) fn rounding(&self, largest: f64, compliance: impl Fn(&Mode) -> f64) -> f64 {
        let waves = self.plain.1.modes().filter(|mode| !mode.is_uniform());
        let softest = waves.map(|mode| compliance(&mode)).filter(|c| c.is_finite()).fold(0.0, f64::max);
        32.0 * f64::EPSILON * softest * self.units[1] / self.units[0] * largest
    }

    /// Returns the compliance of the mean displacement, lateral and normal: of all slabs in series, relative to the
    /// mean level of the support (theory.md, section 4.1).
    pub(crate) fn mean_compliance(&self) -> [f64; 2] {
        let mut sum = [0.0; 2];
        let mut body = &self.plain.0;
        while let Height::Finite(height) = body.height() {
            sum[0] += height / body.material().shear_modulus();
            sum[1] += body.material().p_wave_modulus().map_or(0.0, |modulus| height / modulus);
            let Base::Elastic(below) = body.base() else { break };
            body = below;
        }
        sum.map(|compliance| self.units[1] / self.units[0] * compliance)
    }

    /// Returns u_z of a normal traction.
    pub(crate) fn normal_displacement(&self, traction: ArrayView2<f64>) -> Vec<f64> {
        let fields = [vec![0.0; traction.len()], vec![0.0; traction.len()], traction.iter().copied().collect()];
        let zero = Complex64::ZERO;
        let [_, _, normal] = self.direct(&fields, |mode| {
            let wave = || self.units[1] / self.units[0] * self.plain.0.normal_compliance(mode.wavenumber());
            let entry = Complex64::from(if mode.is_uniform() { self.mean_compliance()[1] } else { wave() });
            [[zero; 3], [zero; 3], [zero, zero, entry]]
        });
        normal
    }
}
