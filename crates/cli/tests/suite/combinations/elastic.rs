//! Independent elasticity: layered bodies wave by wave, by four functions per layer and the conditions between them;
//! patches on a half-space by Love's formula; dense linear algebra. Nothing here is shared with the program.

use std::f64::consts::PI;

/// Point grid in a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub(crate) n: [usize; 2],
    pub(crate) length: [f64; 2],
}

/// Complex number.
pub(crate) type Complex = [f64; 2];

impl Plane {
    pub(crate) fn len(&self) -> usize {
        self.n[0] * self.n[1]
    }

    pub(crate) fn spacing(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.length[axis] / self.n[axis] as f64)
    }

    /// Returns the integer wave numbers of the mode at a place; Nyquist wave numbers are positive.
    pub(crate) fn mode(&self, place: usize) -> [i64; 2] {
        let at = [place / self.n[1], place % self.n[1]];
        [0, 1].map(
            |axis| if 2 * at[axis] > self.n[axis] { at[axis] as i64 - self.n[axis] as i64 } else { at[axis] as i64 },
        )
    }

    /// Returns the wave vector of a mode. An axis of one point has no waves.
    pub(crate) fn wave(&self, place: usize) -> [f64; 2] {
        let mode = self.mode(place);
        [0, 1].map(|axis| 2.0 * PI * mode[axis] as f64 / self.length[axis])
    }

    /// Returns true along each axis with the shortest wave of an even number of points, which has no sine.
    pub(crate) fn is_shortest(&self, place: usize) -> [bool; 2] {
        let mode = self.mode(place);
        [0, 1].map(|axis| self.n[axis] > 1 && 2 * mode[axis] == self.n[axis] as i64)
    }

    /// Returns the sum over r of f(r) exp(-i q r), divided by the number of points, by direct sums along y, then x.
    pub(crate) fn transform(&self, field: &[f64]) -> Vec<Complex> {
        let complex: Vec<Complex> = field.iter().map(|value| [*value / self.len() as f64, 0.0]).collect();
        self.sums(&complex, -1.0)
    }

    /// Returns the real part of the sum over q of f(q) exp(i q r).
    pub(crate) fn inverse(&self, modes: &[Complex]) -> Vec<f64> {
        self.sums(modes, 1.0).into_iter().map(|value| value[0]).collect()
    }

    fn sums(&self, from: &[Complex], sign: f64) -> Vec<Complex> {
        let [nx, ny] = self.n;
        let mut half = vec![[0.0; 2]; nx * ny];
        let along = |n: usize| -> Vec<Complex> {
            (0..n).map(|k| 2.0 * PI * k as f64 / n as f64).map(|angle| [angle.cos(), sign * angle.sin()]).collect()
        };
        let (x, y) = (along(nx), along(ny));
        for i in 0..nx {
            for k in 0..ny {
                let mut sum = [0.0; 2];
                for j in 0..ny {
                    let ([a, b], [c, s]) = (from[i * ny + j], y[j * k % ny]);
                    sum[0] += a * c - b * s;
                    sum[1] += a * s + b * c;
                }
                half[i * ny + k] = sum;
            }
        }
        let mut whole = vec![[0.0; 2]; nx * ny];
        for l in 0..nx {
            for k in 0..ny {
                let mut sum = [0.0; 2];
                for i in 0..nx {
                    let ([a, b], [c, s]) = (half[i * ny + k], x[i * l % nx]);
                    sum[0] += a * c - b * s;
                    sum[1] += a * s + b * c;
                }
                whole[l * ny + k] = sum;
            }
        }
        whole
    }
}

/// Isotropic layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layer {
    pub(crate) young: f64,
    pub(crate) poisson: f64,
    pub(crate) height: f64,
}

impl Layer {
    pub(crate) fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Returns E/(1 - nu^2).
    pub(crate) fn contact_modulus(&self) -> f64 {
        self.young / (1.0 - self.poisson * self.poisson)
    }

    /// Returns the strain of a laterally confined layer per stress.
    pub(crate) fn confined(&self) -> f64 {
        (1.0 + self.poisson) * (1.0 - 2.0 * self.poisson) / (self.young * (1.0 - self.poisson))
    }
}

/// Support of the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Base {
    Bonded,
    Sliding,
    Free,
    /// Young's modulus and Poisson's ratio.
    HalfSpace(f64, f64),
}

/// Layers from the top down, on a base. A half-space alone has no layers.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    pub(crate) layers: Vec<Layer>,
    pub(crate) base: Base,
}

/// Displacement and stress of a wave: u_x = ux sin(q x), u_z = uz cos(q x), sxx, szz with the cosine, sxz with the
/// sine.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wave {
    pub(crate) ux: f64,
    pub(crate) uz: f64,
    pub(crate) sxx: f64,
    pub(crate) szz: f64,
    pub(crate) sxz: f64,
}

impl Wave {
    fn plus(&mut self, factor: f64, other: Self) {
        self.ux += factor * other.ux;
        self.uz += factor * other.uz;
        self.sxx += factor * other.sxx;
        self.szz += factor * other.szz;
        self.sxz += factor * other.sxz;
    }
}

/// Returns the gradient of a harmonic function and its Papkovich-Neuber solution, both with exp(s q z).
fn solutions(layer: &Layer, q: f64, s: f64, z: f64) -> [Wave; 2] {
    let (nu, two_mu, decay) = (layer.poisson, 2.0 * layer.shear_modulus(), (s * q * z).exp());
    let gradient = Wave {
        ux: -decay,
        uz: s * decay,
        sxx: -two_mu * q * decay,
        szz: two_mu * q * decay,
        sxz: -two_mu * s * q * decay,
    };
    let potential = Wave {
        ux: q * z * decay,
        uz: (3.0 - 4.0 * nu - s * q * z) * decay,
        sxx: two_mu * (2.0 * nu * s * q + q * q * z) * decay,
        szz: two_mu * (2.0 * (1.0 - nu) * s * q - q * q * z) * decay,
        sxz: two_mu * (s * q * q * z - (1.0 - 2.0 * nu) * q) * decay,
    };
    [gradient, potential]
}

/// State of the surface of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Top {
    /// Pressure 1 and no shear.
    Pressed,
    /// Pressure 1 and no lateral displacement.
    Held,
    /// Shear 1 along the wave and no pressure.
    Sheared,
    /// No traction; the base moves by 1 along z, or its lateral wave by 1.
    BaseUp,
    BaseAlong,
    /// No traction on the upper face, pressure 1 or shear stress 1 on the lower one (of a free base).
    PressedBelow,
    ShearedBelow,
    /// Pressure 1 on the upper or the lower face, and no lateral displacement of both.
    HeldBetween,
    HeldBetweenBelow,
}

/// Solution of one wave.
pub(crate) struct Solved<'a> {
    stack: &'a Stack,
    q: f64,
    coefficients: Vec<f64>,
}

impl Stack {
    pub(crate) fn half_space(young: f64, poisson: f64) -> Self {
        Self { layers: Vec::new(), base: Base::HalfSpace(young, poisson) }
    }

    pub(crate) fn height(&self) -> f64 {
        self.layers.iter().map(|layer| layer.height).sum()
    }

    /// Returns the layers and the half-space, if any, each with the heights of its upper and lower face below z = 0.
    fn parts(&self) -> Vec<(Layer, f64, Option<f64>)> {
        let mut top = 0.0;
        let mut parts = Vec::new();
        for layer in &self.layers {
            parts.push((*layer, top, Some(top - layer.height)));
            top -= layer.height;
        }
        if let Base::HalfSpace(young, poisson) = self.base {
            parts.push((Layer { young, poisson, height: f64::INFINITY }, top, None));
        }
        parts
    }

    /// Returns the functions of a part at the height z: four for a layer, two for a half-space.
    fn functions(&(layer, top, bottom): &(Layer, f64, Option<f64>), q: f64, z: f64) -> Vec<Wave> {
        let mut all = solutions(&layer, q, 1.0, z - top).to_vec();
        if let Some(bottom) = bottom {
            all.extend(solutions(&layer, q, -1.0, z - bottom));
        }
        all
    }

    /// Solves the conditions at the surface, between the layers and at the base for the wave number q > 0.
    pub(crate) fn solve(&self, q: f64, top: Top) -> Solved<'_> {
        let parts = self.parts();
        let size: usize = parts.iter().map(|part| if part.2.is_some() { 4 } else { 2 }).sum();
        let (mut rows, mut right) = (Vec::new(), Vec::new());
        let mut condition = |terms: &[(usize, Vec<f64>)], value: f64| {
            let mut row = vec![0.0; size];
            for (from, values) in terms {
                values.iter().enumerate().for_each(|(k, value)| row[from + k] += value);
            }
            // Scale rows of stresses and of displacements to the same size.
            let largest = row.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            rows.push(row.into_iter().map(|value| value / largest).collect::<Vec<f64>>());
            right.push(value / largest);
        };
        let of = |waves: &[Wave], which: fn(&Wave) -> f64| waves.iter().map(which).collect::<Vec<f64>>();
        let uppermost = Self::functions(&parts[0], q, 0.0);
        let pressure = if matches!(top, Top::Pressed | Top::Held | Top::HeldBetween) { -1.0 } else { 0.0 };
        condition(&[(0, of(&uppermost, |w| w.szz))], pressure);
        let is_between = matches!(top, Top::HeldBetween | Top::HeldBetweenBelow);
        let lateral: fn(&Wave) -> f64 = if is_between || top == Top::Held { |w| w.ux } else { |w| w.sxz };
        condition(&[(0, of(&uppermost, lateral))], f64::from(u8::from(top == Top::Sheared)));
        let mut first = 0;
        for (k, part) in parts.iter().enumerate() {
            let Some(bottom) = part.2 else { continue };
            let here = Self::functions(part, q, bottom);
            if let Some(below) = parts.get(k + 1) {
                let there = Self::functions(below, q, bottom);
                for which in [|w: &Wave| w.ux, |w: &Wave| w.uz, |w: &Wave| w.szz, |w: &Wave| w.sxz] {
                    let minus = of(&there, which).into_iter().map(|value| -value).collect();
                    condition(&[(first, of(&here, which)), (first + 4, minus)], 0.0);
                }
            } else {
                let (up, along) = (f64::from(u8::from(top == Top::BaseUp)), f64::from(u8::from(top == Top::BaseAlong)));
                let is_pressed = matches!(top, Top::PressedBelow | Top::HeldBetweenBelow);
                let below = if is_pressed { -1.0 } else { 0.0 };
                match self.base {
                    Base::Bonded => {
                        condition(&[(first, of(&here, |w| w.uz))], up);
                        condition(&[(first, of(&here, |w| w.ux))], along);
                    }
                    Base::Sliding => {
                        condition(&[(first, of(&here, |w| w.uz))], up);
                        condition(&[(first, of(&here, |w| w.sxz))], 0.0);
                    }
                    _ => {
                        condition(&[(first, of(&here, |w| w.szz))], below);
                        let shear = f64::from(u8::from(top == Top::ShearedBelow));
                        let lateral: fn(&Wave) -> f64 = if is_between { |w| w.ux } else { |w| w.sxz };
                        condition(&[(first, of(&here, lateral))], shear);
                    }
                }
            }
            first += 4;
        }
        Solved { stack: self, q, coefficients: solve(rows, right) }
    }

    /// Returns the displacement into the body per pressure of a wave; for the uniform one, of the confined layers.
    pub(crate) fn compliance(&self, q: f64, held: bool) -> f64 {
        if q == 0.0 {
            return self.layers.iter().map(|layer| layer.height * layer.confined()).sum();
        }
        -self.solve(q, if held { Top::Held } else { Top::Pressed }).at(0.0, false).uz
    }

    /// Returns the lateral displacement per shear across the wave, from the stiffness below, layer by layer.
    pub(crate) fn across(&self, q: f64) -> f64 {
        if q == 0.0 {
            return self.layers.iter().map(|layer| layer.height / layer.shear_modulus()).sum();
        }
        let below = match self.base {
            Base::Bonded => f64::INFINITY,
            Base::Sliding | Base::Free => 0.0,
            Base::HalfSpace(young, poisson) => q * young / (2.0 * (1.0 + poisson)),
        };
        let raised = |below: f64, layer: &Layer| {
            let (own, t) = (q * layer.shear_modulus(), (q * layer.height).tanh());
            if below.is_infinite() { own / t } else { own * (below + own * t) / (own + below * t) }
        };
        1.0 / self.layers.iter().rev().fold(below, raised)
    }

    /// Returns the compliance for tractions along x, y, z (outward) on the surface of a periodic cell, for the mode at
    /// a place. `[row][column]` is the complex displacement `row` per traction `column`.
    pub(crate) fn all_components(&self, plane: Plane, place: usize) -> [[Complex; 3]; 3] {
        let [x, y] = plane.wave(place);
        let q = x.hypot(y);
        let mut matrix = [[[0.0; 2]; 3]; 3];
        if q == 0.0 {
            let across = self.across(0.0);
            matrix[0][0][0] = across;
            matrix[1][1][0] = across;
            matrix[2][2][0] = self.compliance(0.0, false);
            return matrix;
        }
        let (pressed, sheared) =
            (self.solve(q, Top::Pressed).at(0.0, false), self.solve(q, Top::Sheared).at(0.0, false));
        let (along, across) = (sheared.ux, self.across(q));
        let n = [x / q, y / q];
        for row in [0, 1] {
            for column in [0, 1] {
                let same = f64::from(u8::from(row == column));
                let product = n[row] * n[column];
                matrix[row][column][0] = product * along + (same - product) * across;
            }
            // u_x = ux sin(q x) for a pressure cos(q x): -i; a traction along z is minus a pressure. uz cos for a shear
            // sin: +i.
            matrix[row][2][1] = n[row] * pressed.ux;
            matrix[2][row][1] = n[row] * sheared.uz;
        }
        matrix[2][2][0] = -pressed.uz;
        matrix
    }
}

impl Solved<'_> {
    /// Returns the wave at a depth; `lower` selects the lower layer on an interface.
    pub(crate) fn at(&self, depth: f64, lower: bool) -> Wave {
        let parts = self.stack.parts();
        let last = parts.len() - 1;
        let small = 1e-12 * (1.0 + depth);
        let inside = |part: &(Layer, f64, Option<f64>)| match part.2 {
            Some(bottom) => {
                if lower {
                    -depth > bottom + small
                } else {
                    -depth >= bottom - small
                }
            }
            None => true,
        };
        let k = parts.iter().position(inside).unwrap_or(last);
        let mut wave = Wave::default();
        for (function, coefficient) in
            Stack::functions(&parts[k], self.q, -depth).into_iter().zip(&self.coefficients[4 * k..])
        {
            wave.plus(*coefficient, function);
        }
        wave
    }
}

/// Returns the compliance of all components without the stiffness entries that have a sine along the axes of the
/// shortest waves: these waves have no sine.
pub(crate) fn without_sines(matrix: [[Complex; 3]; 3], shortest: [bool; 2]) -> [[Complex; 3]; 3] {
    if shortest == [false; 2] {
        return matrix;
    }
    // z times i makes the matrix real.
    let real = |row: usize, column: usize| match (row == 2, column == 2) {
        (false, true) => -matrix[row][column][1],
        (true, false) => matrix[row][column][1],
        _ => matrix[row][column][0],
    };
    let inverse = |rows: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let unit = |column: usize| (0..3).map(|row| f64::from(u8::from(row == column))).collect();
        (0..3).map(|column| solve(rows.clone(), unit(column))).collect()
    };
    let mut stiffness = inverse((0..3).map(|row| (0..3).map(|column| real(row, column)).collect()).collect());
    for axis in [0, 1] {
        for other in (0..3).filter(|other| shortest[axis] && *other != axis) {
            stiffness[axis][other] = 0.0;
            stiffness[other][axis] = 0.0;
        }
    }
    let found = inverse(stiffness);
    let mut all = [[[0.0; 2]; 3]; 3];
    for (row, values) in all.iter_mut().enumerate() {
        for (column, value) in values.iter_mut().enumerate() {
            *value = match (row == 2, column == 2) {
                (false, true) => [0.0, -found[row][column]],
                (true, false) => [0.0, found[row][column]],
                _ => [found[row][column], 0.0],
            };
        }
    }
    all
}

/// Solves a dense linear system by Gaussian elimination with row pivots.
pub(crate) fn solve(mut rows: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    for k in 0..size {
        let pivot = (k..size).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        rows.swap(k, pivot);
        right.swap(k, pivot);
        let (above, below) = rows.split_at_mut(k + 1);
        let head = &above[k];
        for (i, row) in below.iter_mut().enumerate() {
            let factor = row[k] / head[k];
            if factor != 0.0 {
                row[k..].iter_mut().zip(&head[k..]).for_each(|(value, above)| *value -= factor * above);
                right[k + 1 + i] -= factor * right[k];
            }
        }
    }
    for k in (0..size).rev() {
        let known: f64 = rows[k][k + 1..].iter().zip(&right[k + 1..]).map(|(a, b)| a * b).sum();
        right[k] = (right[k] - known) / rows[k][k];
    }
    right
}

/// Dense compliance: downward displacement of points by pressures on points.
pub(crate) struct Dense {
    plane: Plane,
    is_free: bool,
    /// By offset: periodic, or by absolute offsets with free boundaries.
    by_offset: Vec<f64>,
}

impl Dense {
    /// Returns the compliance of a periodic cell, from the compliance of each wave number.
    pub(crate) fn periodic(plane: Plane, mut compliance: impl FnMut(f64) -> f64) -> Self {
        let mut known: Vec<(i64, f64)> = Vec::new();
        let modes: Vec<Complex> = (0..plane.len())
            .map(|place| {
                let [x, y] = plane.wave(place);
                let q = x.hypot(y);
                let key = (q * 1e9) as i64;
                let found = known.iter().find(|(of, _)| *of == key).map(|(_, value)| *value);
                let value = found.unwrap_or_else(|| {
                    let value = compliance(q);
                    known.push((key, value));
                    value
                });
                [value / plane.len() as f64, 0.0]
            })
            .collect();
        Self { plane, is_free: false, by_offset: plane.inverse(&modes) }
    }

    /// Returns the compliance of a periodic cell, from the displacement downwards by a pressure of one on one point.
    pub(crate) fn of_displacement(plane: Plane, by_offset: Vec<f64>) -> Self {
        Self { plane, is_free: false, by_offset }
    }

    /// Returns the compliance of a patch on an unbounded body, from the displacement at an offset by a uniform pressure
    /// on one cell.
    pub(crate) fn free(plane: Plane, of_cell: impl Fn([f64; 2]) -> f64) -> Self {
        let [dx, dy] = plane.spacing();
        let offset = |place: usize| [(place / plane.n[1]) as f64 * dx, (place % plane.n[1]) as f64 * dy];
        Self { plane, is_free: true, by_offset: (0..plane.len()).map(|place| of_cell(offset(place))).collect() }
    }

    pub(crate) fn entry(&self, a: usize, b: usize) -> f64 {
        let [nx, ny] = self.plane.n;
        let [ax, ay, bx, by] = [a / ny, a % ny, b / ny, b % ny];
        match self.is_free {
            true => self.by_offset[ax.abs_diff(bx) * ny + ay.abs_diff(by)],
            false => self.by_offset[(nx + ax - bx) % nx * ny + (ny + ay - by) % ny],
        }
    }

    /// Returns the displacement into the body.
    pub(crate) fn displace(&self, pressure: &[f64]) -> Vec<f64> {
        let loaded: Vec<(usize, f64)> = pressure.iter().copied().enumerate().filter(|(_, p)| *p != 0.0).collect();
        (0..pressure.len()).map(|a| loaded.iter().map(|(b, p)| self.entry(a, *b) * p).sum()).collect()
    }

    /// Returns the mean over all points of the pressure on `points` that displaces all of them by one; infinite if this
    /// has no solution.
    pub(crate) fn stiffness(&self, points: &[usize]) -> f64 {
        if points.is_empty() {
            return 0.0;
        }
        let mean = self.by_offset.iter().sum::<f64>().abs();
        let largest = self.by_offset[0].abs() * self.plane.len() as f64;
        if !self.is_free && points.len() == self.plane.len() && mean < 1e-12 * largest {
            return f64::INFINITY;
        }
        let rows = points.iter().map(|a| points.iter().map(|b| self.entry(*a, *b)).collect()).collect();
        solve(rows, vec![1.0; points.len()]).iter().sum::<f64>() / self.plane.len() as f64
    }
}

/// Returns Love's displacement at an offset by a unit pressure on a cell of a half-space of modulus E*; for a line, on
/// a strip, with zero displacement at an offset of the cell length.
pub(crate) fn love(plane: Plane, e_star: f64) -> impl Fn([f64; 2]) -> f64 {
    let ([dx, dy], is_line) = (plane.spacing(), plane.n[1] == 1);
    let length = plane.length[0];
    move |[x, y]| {
        if is_line {
            let primitive = |s: f64| s * (s.abs() / length).ln() - s;
            return -2.0 / (PI * e_star) * (primitive(x + 0.5 * dx) - primitive(x - 0.5 * dx));
        }
        let corner = |x: f64, y: f64| x * (y / x.abs()).asinh() + y * (x / y.abs()).asinh();
        let ([right, left], [back, front]) = ([x + 0.5 * dx, x - 0.5 * dx], [y + 0.5 * dy, y - 0.5 * dy]);
        (corner(right, back) - corner(left, back) - corner(right, front) + corner(left, front)) / (PI * e_star)
    }
}

/// Returns the Gauss-Legendre nodes and weights on [-1, 1], by Newton's method.
pub(crate) fn gauss(count: usize) -> Vec<[f64; 2]> {
    let legendre = |x: f64| {
        let (mut before, mut now) = (1.0, x);
        for k in 2..=count {
            (before, now) = (now, ((2 * k - 1) as f64 * x * now - (k - 1) as f64 * before) / k as f64);
        }
        [now, count as f64 * (x * now - before) / (x * x - 1.0)]
    };
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (count as f64 + 0.5)).cos();
        for _ in 0..100 {
            let [value, slope] = legendre(x);
            x -= value / slope;
        }
        let [_, slope] = legendre(x);
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

/// Returns J0 as the mean of cos(x sin t); the trapezoidal rule converges faster than any power.
fn bessel(x: f64) -> f64 {
    let steps = 12 + (0.55 * x.abs()) as usize;
    (0..steps).map(|k| (x * (PI * (k as f64 + 0.5) / (2.0 * steps as f64)).sin()).cos()).sum::<f64>() / steps as f64
}

/// Returns the displacement by a unit pressure on a cell of layered bodies. For short waves their compliance tends to a
/// half-space of modulus E*. The smallest height of the uppermost layers and the sum of all heights set the steps of
/// the quadrature; `lowest` is the limit of q times the compliance of long waves.
pub(crate) fn layered(
    plane: Plane,
    e_star: f64,
    [least, sum]: [f64; 2],
    lowest: f64,
    compliance: impl Fn(f64) -> f64,
) -> impl Fn([f64; 2]) -> f64 {
    let (nodes, is_line) = (gauss(12), plane.n[1] == 1);
    let reach = 1.05 * plane.length[0].hypot(if is_line { 0.0 } else { plane.length[1] });
    let step = (1.5 / sum).min(3.0 / reach);
    let most = 20.0 / least;
    // The first piece is halved, since stiff layers on soft bodies have features at small wave numbers.
    let mut ends: Vec<f64> = (0..4).map(|k| step / 2_f64.powi(4 - k)).collect();
    ends.insert(0, 0.0);
    ends.extend((1..=(most / step).ceil() as usize).map(|k| k as f64 * step));
    let far = lowest - 2.0 / e_star;
    let mut samples: Vec<[f64; 2]> = Vec::new();
    for ends in ends.windows(2) {
        for [x, weight] in &nodes {
            let q = 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * x;
            let bracket = q * compliance(q) - 2.0 / e_star;
            let rest =
                if is_line { (bracket - far * (-2.0 * q * least).exp()) / (PI * q) } else { bracket / (2.0 * PI) };
            samples.push([q, 0.5 * (ends[1] - ends[0]) * weight * rest]);
        }
    }
    let exact = |r: f64| -> f64 {
        let integral = |wave: fn(f64) -> f64| samples.iter().map(|[q, value]| value * wave(q * r)).sum::<f64>();
        match is_line {
            true => {
                integral(f64::cos) - far / (2.0 * PI) * ((r * r + 4.0 * least * least) / plane.length[0].powi(2)).ln()
            }
            false => integral(bessel),
        }
    };
    // An even function of r on [-reach, reach] at Chebyshev nodes. The image of a source below the layer lies at twice
    // its height.
    let count = 2 * 64.max((6.0 * reach / least) as usize);
    let table: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let r = reach * (PI * (k as f64 + 0.5) / count as f64).cos();
            [r, if k < count / 2 { exact(r.abs()) } else { f64::NAN }]
        })
        .collect();
    let table: Vec<[f64; 2]> =
        (0..count).map(|k| [table[k][0], if k < count / 2 { table[k][1] } else { table[count - 1 - k][1] }]).collect();
    let between = move |r: f64| {
        let (mut above, mut below) = (0.0, 0.0);
        for (k, [at, value]) in table.iter().enumerate() {
            if (r - at).abs() < 1e-14 {
                return *value;
            }
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let weight = sign * (PI * (k as f64 + 0.5) / count as f64).sin() / (r - at);
            above += weight * value;
            below += weight;
        }
        above / below
    };
    let (half_space, [dx, dy]) = (love(plane, e_star), plane.spacing());
    let across = dx.max(if is_line { 0.0 } else { dy });
    let inner = gauss(8.max((3.0 * across / least) as usize).min(64));
    move |[x, y]| {
        let mut mean = 0.0;
        for [s, weight] in &inner {
            if is_line {
                mean += 0.5 * weight * between(x + 0.5 * dx * s);
                continue;
            }
            for [t, other] in &inner {
                mean += 0.25 * weight * other * between((x + 0.5 * dx * s).hypot(y + 0.5 * dy * t));
            }
        }
        half_space([x, y]) + mean * dx * if is_line { 1.0 } else { dy }
    }
}
