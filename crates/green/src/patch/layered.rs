//! Contribution of layers to the compliance of a patch. It is the integral over all wavenumbers of the difference from
//! the half-space compliance, times a Bessel function, or a cosine for a profile (theory.md, section 3.1).

use std::f64::consts::{PI, TAU};

use gfmd_field::Grid;
use rayon::prelude::*;

use crate::{Base, Blocks, Body, Condition, GreenError, Height};

/// Contribution of layers to the displacement by a point or line force, tabulated as functions of the distance.
///
/// The integrands decay as e^(−2 q h) for q above 1/h, with the height h of the thinnest top layer, and the functions
/// are smooth over distances of 2 h. Piecewise Gauss quadrature and Chebyshev interpolation are exact to about 1e-13 of
/// the largest value.
struct Radial<const M: usize> {
    /// Length of a piece of the table.
    piece: f64,
    /// Chebyshev coefficients on each piece.
    pieces: Vec<[[f64; M]; ORDER]>,
    sides: [f64; 2],
    /// Quadrature over a cell, along each side of length 1.
    nodes: Vec<[f64; 2]>,
}

/// Contribution of layers to the displacement caused by a uniform pressure on a cell: 1/(2π) ∫ (q G_zz(q) − 2/E*) J₀(q
/// r) dq integrated over the cell, or on a line, 1/π ∫ (G_zz(q) − 2/(E* q)) cos(q x) dq.
pub(super) struct Correction {
    table: Radial<1>,
    /// Far-field part for a line.
    far: Option<Far>,
}

/// Part of the line correction that grows with the distance, like the displacement of a half-space: with the difference
/// D of q G_zz(q) between long and short waves, 1/π ∫ D e^(−a q) cos(q x)/q dq = −D/(2 π) ln((x² + a²)/Lx²).
struct Far {
    /// D/(2 π).
    factor: f64,
    /// a.
    depth: f64,
    /// Lx.
    length: f64,
}

/// Contribution of layers to the [matrix](super::PatchMatrix) of a half-space, except zz.
pub(super) struct MatrixCorrection(Radial<3>);

/// Number of coefficients of a piece, and of nodes of an interval of the quadrature over q.
const ORDER: usize = 16;

/// Largest distance on the patch divided by the height of the top layer. The effort grows with its square.
const FARTHEST: f64 = 200.0;

/// Largest side of a cell divided by the height of the top layer.
const WIDEST: f64 = 4.0;

/// Value of q h above which e^(−2 q h) (q h)² is a rounding error.
const LAST: f64 = 24.0;

/// Number of halvings of the first interval of q, for a stiff layer on a soft body.
const HALVINGS: i32 = 40;

impl Correction {
    /// Returns the correction of `compliance` for a body with layers; `None` for one or two half-spaces.
    ///
    /// # Errors
    /// Returns an error for a plate, which has no support, and for layers too thin for the patch or its cells.
    pub(super) fn of(body: &Body, grid: &Grid, compliance: fn(&Body, f64) -> f64) -> Result<Option<Self>, GreenError> {
        let Some(layers) = Layers::of(body)? else { return Ok(None) };
        let half_space = 2.0 / body.contact_modulus();
        let more = |q: f64| q * compliance(body, q) - half_space;
        if !grid.is_line() {
            let table = Radial::of(&layers, grid, |q| [more(q) / TAU], |x| [libm::j0(x)])?;
            return Ok(Some(Self { table, far: None }));
        }
        let difference = long_waves(body) - half_space;
        let depth = 2.0 * layers.thinnest;
        let density = |q: f64| [(more(q) - difference * (-depth * q).exp()) / (PI * q)];
        let table = Radial::of(&layers, grid, density, |x| [x.cos()])?;
        let far = Far { factor: difference / TAU, depth, length: grid.lengths()[0] };
        Ok(Some(Self { table, far: Some(far) }))
    }

    /// Returns ∫∫ c dA over a cell centred at `at` relative to the point; on a line, ∫ c dx.
    pub(super) fn integral(&self, at: [f64; 2]) -> f64 {
        let Some(Far { factor, depth, length }) = self.far else {
            let [integral] = self.table.integral(at, |_, c| c);
            return integral;
        };
        let far = |x: f64| -factor * ((x * x + depth * depth) / (length * length)).ln();
        let Radial { sides: [side, _], nodes, .. } = &self.table;
        let value = |x: f64| self.table.at(x.abs())[0] + far(x);
        side * nodes.iter().map(|[t, w]| w * value(at[0] + t * side)).sum::<f64>()
    }
}

/// Returns the long-wave limit of q G_zz(q), given by the half-spaces below all layers; 0 for bodies held by a base.
fn long_waves(body: &Body) -> f64 {
    let first = match (body.height(), body.base()) {
        (Height::Infinite, _) => 2.0 / Body::half_space(*body.material()).contact_modulus(),
        (Height::Finite(_), Base::Elastic(below)) => long_waves(below),
        (Height::Finite(_), _) => 0.0,
    };
    first + body.second().map_or(0.0, long_waves)
}

impl MatrixCorrection {
    /// Returns the correction for a body with layers; `None` for one or two half-spaces.
    ///
    /// # Errors
    /// Returns an error for a plate or a body on a sliding base, and for layers too thin for the patch or its cells.
    pub(super) fn of(body: &Body, grid: &Grid) -> Result<Option<Self>, GreenError> {
        let Some(layers) = Layers::of(body)? else { return Ok(None) };
        let bodies = || [Some(body), body.second()].into_iter().flatten();
        bodies().try_for_each(check_lateral_support)?;
        // Each compliance block is a constant divided by q.
        let mut half_spaces = bodies().map(|body| Body::half_space(*body.material()));
        let Some(first) = half_spaces.next() else { return Ok(None) };
        let half_space = half_spaces.next().map_or(first.clone(), |second| first.against(second));
        let parts = |Blocks { longitudinal, transverse, coupling, .. }: Blocks| {
            [0.5 * (longitudinal + transverse), -coupling[0], 0.5 * (longitudinal - transverse)]
        };
        let without = parts(half_space.compliance_blocks(1.0));
        let density = |q: f64| {
            let found = parts(body.compliance_blocks(q));
            std::array::from_fn(|k| (q * found[k] - without[k]) / TAU)
        };
        Ok(Some(Self(Radial::of(&layers, grid, density, bessel)?)))
    }

    /// Returns the entries xx, yy, xy, xz, yz: integrals over a cell centred at `at` relative to the point.
    pub(super) fn integral(&self, at: [f64; 2]) -> [f64; 5] {
        self.0.integral(at, |[x, y], [mean, coupled, split]| {
            let r = x.hypot(y);
            let [c, s] = if r > 0.0 { [x / r, y / r] } else { [1.0, 0.0] };
            let [twice_c, twice_s] = [c * c - s * s, 2.0 * c * s];
            [mean - split * twice_c, mean + split * twice_c, -split * twice_s, coupled * c, coupled * s]
        })
    }
}

/// Returns the Bessel functions J₀, J₁, J₂.
fn bessel(x: f64) -> [f64; 3] {
    let [zeroth, first] = [libm::j0(x), libm::j1(x)];
    // The recurrence loses digits near zero.
    [zeroth, first, if x < 2.0 { libm::jn(2, x) } else { 2.0 / x * first - zeroth }]
}

impl<const M: usize> Radial<M> {
    /// Tabulates the integrals of `density(q)` times `wave(q r)` over q, entry by entry, for all distances in the
    /// periodic cell that contains the patch.
    fn of(
        layers: &Layers,
        grid: &Grid,
        density: impl Fn(f64) -> [f64; M] + Sync,
        wave: fn(f64) -> [f64; M],
    ) -> Result<Self, GreenError> {
        let Layers { thinnest, all } = *layers;
        let sides = grid.spacing();
        let [farthest, widest] = if grid.is_line() {
            [0.5 * grid.padded()?.lengths()[0] + sides[0], sides[0]]
        } else {
            let [lx, ly] = grid.padded()?.lengths();
            [0.5 * lx.hypot(ly) + sides[0].hypot(sides[1]), sides[0].max(sides[1])]
        };
        let widest = widest / thinnest;
        let least = (farthest / FARTHEST).max(thinnest * widest / WIDEST);
        if thinnest < least {
            return Err(GreenError::ThinLayer { found: thinnest, least });
        }
        let spectrum = Spectrum::of(density, thinnest, all, farthest);
        let count = (farthest / thinnest).ceil().max(1.0) as usize;
        let piece = farthest / count as f64;
        let on_piece = |k: usize| chebyshev(k as f64 * piece, piece, &|r| spectrum.at(r, wave));
        let pieces = (0..count).into_par_iter().map(on_piece).collect();
        let nodes = legendre(match widest {
            ..=0.25 => 5,
            ..=1.0 => 8,
            _ => 16,
        });
        Ok(Self { piece, pieces, sides, nodes })
    }

    /// Returns ∫∫ `of(place, functions)` dA over a cell centred at `at` relative to the point.
    fn integral<const K: usize>(&self, at: [f64; 2], of: impl Fn([f64; 2], [f64; M]) -> [f64; K]) -> [f64; K] {
        let Self { sides: [a, b], nodes, .. } = self;
        let mut sums = [0.0; K];
        for ([s, v], [t, w]) in nodes.iter().flat_map(|along| nodes.iter().map(move |across| (along, across))) {
            let place = [at[0] + s * a, at[1] + t * b];
            let values = of(place, self.at(place[0].hypot(place[1])));
            (0..K).for_each(|k| sums[k] += v * w * values[k]);
        }
        sums.map(|sum| a * b * sum)
    }

    /// Returns the functions at the distance r, by Clenshaw recurrence.
    fn at(&self, r: f64) -> [f64; M] {
        let index = ((r / self.piece) as usize).min(self.pieces.len() - 1);
        let x = 2.0 * (r / self.piece - index as f64) - 1.0;
        let [first, rest @ ..] = &self.pieces[index];
        std::array::from_fn(|k| {
            let step = |[now, last]: [f64; 2], c: &[f64; M]| [2.0 * x * now - last + c[k], now];
            let [now, last] = rest.iter().rev().fold([0.0; 2], step);
            x * now - last + first[k]
        })
    }
}

/// Checks that the body has lateral support.
fn check_lateral_support(body: &Body) -> Result<(), GreenError> {
    match body.ground() {
        Some(ground) if ground.lateral == Condition::Free => Err(GreenError::FreeSliding),
        _ => Ok(()),
    }
}

/// Layer heights of one body or a pair.
struct Layers {
    /// Smallest height of a top layer.
    thinnest: f64,
    /// Total height of the layers; in a pair, the larger total.
    all: f64,
}

impl Layers {
    /// Returns the heights; `None` for half-spaces.
    ///
    /// # Errors
    /// Returns an error for a plate.
    fn of(body: &Body) -> Result<Option<Self>, GreenError> {
        let bodies = [Some(body), body.second()].into_iter().flatten();
        let layers = bodies.map(thickness).collect::<Result<Vec<_>, _>>()?.into_iter().flatten();
        let more = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Ok(layers.reduce(more).map(|[thinnest, all]| Self { thinnest, all }))
    }
}

/// Returns the heights of the top layer and of all layers of a body; `None` for a half-space.
fn thickness(body: &Body) -> Result<Option<[f64; 2]>, GreenError> {
    let Height::Finite(height) = body.height() else { return Ok(None) };
    match body.base() {
        Base::Rigid(ground) if ground.normal == Condition::Free => Err(GreenError::FreePlate),
        Base::Elastic(below) => Ok(Some([height, height + thickness(below)?.map_or(0.0, |[_, all]| all)])),
        Base::Rigid(_) => Ok(Some([height; 2])),
    }
}

/// Integrands at the quadrature nodes, without the waves.
struct Spectrum<const M: usize> {
    /// q, and the integrands times the weight.
    terms: Vec<(f64, [f64; M])>,
}

impl<const M: usize> Spectrum<M> {
    fn of(density: impl Fn(f64) -> [f64; M] + Sync, thinnest: f64, all: f64, farthest: f64) -> Self {
        let last = LAST / thinnest;
        // An interval is short compared with the waves and the variations from the layers.
        let count = (last * (farthest / 4.0).max(all)).ceil();
        let first = last / count;
        let halved = (0..HALVINGS).map(|k| first * 0.5_f64.powi(k + 1));
        let starts = [0.0].into_iter().chain(halved.rev()).chain((1..=count as usize).map(|k| k as f64 * first));
        let starts: Vec<f64> = starts.collect();
        let nodes = legendre(ORDER);
        let terms = starts.windows(2).flat_map(|ends| {
            let [width, middle] = [ends[1] - ends[0], 0.5 * (ends[0] + ends[1])];
            nodes.iter().map(move |[t, w]| [middle + t * width, w * width])
        });
        let terms: Vec<[f64; 2]> = terms.collect();
        let of = |[q, weight]: [f64; 2]| (q, density(q).map(|density| weight * density));
        Self { terms: terms.into_par_iter().map(of).collect() }
    }

    fn at(&self, r: f64, wave: fn(f64) -> [f64; M]) -> [f64; M] {
        self.terms.iter().fold([0.0; M], |sums, (q, term)| {
            let waves = wave(q * r);
            std::array::from_fn(|k| sums[k] + term[k] * waves[k])
        })
    }
}

/// Returns the Chebyshev coefficients of the entries of `f` on the interval of `length` from `start`.
fn chebyshev<const M: usize>(start: f64, length: f64, f: &dyn Fn(f64) -> [f64; M]) -> [[f64; M]; ORDER] {
    let angle = |k: usize| PI * (k as f64 + 0.5) / ORDER as f64;
    let values: [[f64; M]; ORDER] = std::array::from_fn(|k| f(start + 0.5 * length * (1.0 + angle(k).cos())));
    std::array::from_fn(|m| {
        std::array::from_fn(|entry| {
            let terms = values.iter().enumerate().map(|(k, value)| value[entry] * (m as f64 * angle(k)).cos());
            terms.sum::<f64>() * if m == 0 { 1.0 } else { 2.0 } / ORDER as f64
        })
    })
}

/// Computes nodes and weights of Gauss quadrature on −1/2 to 1/2, from Legendre zeros by Newton's method.
fn legendre(count: usize) -> Vec<[f64; 2]> {
    let n = count as f64;
    // P_n and its slope.
    let polynomial = |x: f64| {
        let [mut now, mut last] = [1.0, 0.0];
        for k in 0..count {
            let k = k as f64;
            [now, last] = [((2.0 * k + 1.0) * x * now - k * last) / (k + 1.0), now];
        }
        [now, n * (x * now - last) / (x * x - 1.0)]
    };
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        for _ in 0..10 {
            let [value, slope] = polynomial(x);
            x -= value / slope;
        }
        let [_, slope] = polynomial(x);
        [0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, PatchMatrix, patch_compliance, patch_matrix};

    fn material(modulus: f64, poisson: f64) -> Material {
        Material::from_contact_modulus(modulus, poisson).unwrap()
    }

    #[test]
    fn quadrature_is_exact_for_polynomials_and_interpolation_for_smooth_functions() {
        for count in [1, 2, 5, 8, 16] {
            let nodes = legendre(count);
            for power in (0..2 * count as i32).step_by(2) {
                let sum: f64 = nodes.iter().map(|[t, w]| w * t.powi(power)).sum();
                let exact = 0.5_f64.powi(power) / f64::from(power + 1);
                assert!((sum / exact - 1.0).abs() < 1e-13, "{count} {power}: {sum} {exact}");
            }
        }
    }

    /// A uniform pressure compresses a slab by height divided by P-wave modulus.
    #[test]
    fn cells_of_a_slab_add_up_to_its_uniform_compression() {
        for (poisson, height) in [(0.0, 0.05), (0.3, 0.02), (0.45, 0.03)] {
            let body = Body::slab(material(1.3, poisson), height).unwrap();
            let grid = Grid::new([48, 40], [1.0, 0.9]).unwrap();
            let compliance = patch_compliance(&body, &grid).unwrap();
            let sum: f64 = (-47..48_isize)
                .flat_map(|i| (-39..40_isize).map(move |j| [i.unsigned_abs(), j.unsigned_abs()]))
                .map(compliance)
                .sum();
            let [_, uniform] = body.level_compliance();
            assert!((sum / uniform - 1.0).abs() < 1e-9, "{poisson} {height}: {sum} {uniform}");
        }
    }

    #[test]
    fn a_layer_of_the_material_of_its_base_and_a_very_high_slab_are_half_spaces() {
        let grid = Grid::new([20, 24], [1.0, 0.7]).unwrap();
        let wanted = patch_compliance(&Body::half_space(material(0.8, 0.2)), &grid).unwrap();
        let layer = Body::slab(material(0.8, 0.2), 0.06).unwrap();
        let coated = patch_compliance(&layer.bonded_to(Body::half_space(material(0.8, 0.2))).unwrap(), &grid).unwrap();
        let high = patch_compliance(&Body::slab(material(0.8, 0.2), 4000.0).unwrap(), &grid).unwrap();
        for cell in [[0, 0], [0, 1], [3, 2], [19, 0], [19, 23]] {
            assert!((coated(cell) / wanted(cell) - 1.0).abs() < 1e-11, "{cell:?}");
            assert!((high(cell) / wanted(cell) - 1.0).abs() < 2e-3, "{cell:?}");
        }
    }

    #[test]
    fn strips_of_a_slab_add_up_to_its_uniform_compression() {
        for (poisson, height) in [(0.0, 0.05), (0.3, 0.02), (0.45, 0.03)] {
            let body = Body::slab(material(1.3, poisson), height).unwrap();
            let compliance = patch_compliance(&body, &Grid::line(48, 1.0).unwrap()).unwrap();
            let sum = compliance([0, 0]) + 2.0 * (1..48).map(|i| compliance([i, 0])).sum::<f64>();
            let [_, uniform] = body.level_compliance();
            assert!((sum / uniform - 1.0).abs() < 1e-9, "{poisson} {height}: {sum} {uniform}");
        }
    }

    #[test]
    fn strips_on_a_layer_of_the_material_of_its_base_are_those_of_a_half_space() {
        let grid = Grid::line(40, 1.0).unwrap();
        let half_space = || Body::half_space(material(0.8, 0.2));
        let other = || Body::half_space(material(3.0, 0.4));
        let layer = || Body::slab(material(0.8, 0.2), 0.06).unwrap().bonded_to(half_space()).unwrap();
        let pairs = [(layer(), half_space()), (layer().against(other()), half_space().against(other()))];
        for (layer, half_space) in pairs {
            let [found, wanted] = [layer, half_space].map(|body| patch_compliance(&body, &grid).unwrap());
            for cell in [0, 1, 3, 20, 39] {
                let [found, wanted] = [found([cell, 0]), wanted([cell, 0])];
                assert!((found - wanted).abs() < 1e-12 * wanted.abs().max(0.1), "{cell}: {found} {wanted}");
            }
        }
    }

    /// Far away, the displacement changes as on the bare base.
    #[test]
    fn far_from_a_line_of_force_a_coating_does_not_matter() {
        let grid = Grid::line(64, 64.0).unwrap();
        let base = Body::half_space(material(1.0, 0.3));
        for ratio in [0.05, 20.0] {
            let coated = Body::slab(material(ratio, 0.4), 0.7).unwrap().bonded_to(base.clone()).unwrap();
            let [found, wanted] = [&coated, &base].map(|body| patch_compliance(body, &grid).unwrap());
            let off = |i: usize| (found([i, 0]) - wanted([i, 0])).abs() / (wanted([31, 0]) - wanted([63, 0]));
            assert!(off(63) < 0.02 && off(63) < 0.5 * off(31), "{ratio}: {} {}", off(31), off(63));
        }
    }

    /// The sum over all cells is the response to a uniform traction; odd entries cancel.
    #[test]
    fn cells_of_a_slab_add_up_to_its_uniform_shear() {
        for (poisson, height) in [(0.0, 0.05), (0.3, 0.02), (0.45, 0.03)] {
            let body = Body::slab(material(1.3, poisson), height).unwrap();
            let matrix = patch_matrix(&body, &Grid::new([48, 40], [1.0, 0.9]).unwrap()).unwrap();
            let cells = (-47..48_isize).flat_map(|i| (-39..40_isize).map(move |j| [i, j].map(isize::unsigned_abs)));
            let entries = cells.map(matrix).map(|PatchMatrix { xx, yy, zz, .. }| [xx, yy, zz]);
            let sums = entries.fold([0.0; 3], |sums, one| std::array::from_fn(|k| sums[k] + one[k]));
            let [lateral, normal] = body.level_compliance();
            for (sum, uniform) in sums.into_iter().zip([lateral, lateral, normal]) {
                assert!((sum / uniform - 1.0).abs() < 1e-9, "{poisson} {height}: {sums:?} {uniform}");
            }
        }
    }

    #[test]
    fn the_matrix_of_a_layer_of_the_material_of_its_base_is_that_of_a_half_space() {
        let grid = Grid::new([20, 24], [1.0, 0.7]).unwrap();
        let (own, other) = (material(0.8, 0.2), material(2.0, 0.4));
        let entries = |matrix: PatchMatrix| {
            let PatchMatrix { xx, yy, zz, xy, xz, yz } = matrix;
            [xx, yy, zz, xy, xz, yz]
        };
        let layer = || Body::slab(own, 0.06).unwrap().bonded_to(Body::half_space(own)).unwrap();
        for (found, wanted) in [
            (layer(), Body::half_space(own)),
            (layer().against(Body::half_space(other)), Body::half_space(own).against(Body::half_space(other))),
            (Body::half_space(other).against(layer()), Body::half_space(other).against(Body::half_space(own))),
        ] {
            let [found, wanted] = [found, wanted].map(|body| patch_matrix(&body, &grid).unwrap());
            let largest = wanted([0, 0]).xx;
            for cell in [[0, 0], [0, 1], [3, 2], [19, 0], [19, 23]] {
                for (found, wanted) in entries(found(cell)).into_iter().zip(entries(wanted(cell))) {
                    assert!((found - wanted).abs() < 1e-11 * largest, "{cell:?}: {found} {wanted}");
                }
            }
        }
    }

    /// Far away, a coated body behaves like its base.
    #[test]
    fn far_from_the_force_a_coating_does_not_matter() {
        for ratio in [0.05, 20.0] {
            let grid = Grid::square(64, 64.0).unwrap();
            let base = Body::half_space(material(1.0, 0.3));
            let coated = Body::slab(material(ratio, 0.4), 0.7).unwrap().bonded_to(base.clone()).unwrap();
            let [found, wanted] = [&coated, &base].map(|body| patch_compliance(body, &grid).unwrap());
            let [near, far] = [[31, 31], [63, 63]].map(|cell| (found(cell) / wanted(cell) - 1.0).abs());
            assert!(far < 0.01 && far < 0.6 * near, "{ratio}: {near} {far}");
        }
    }

    #[test]
    fn what_cannot_be_had_is_refused() {
        let grid = Grid::square(32, 1.0).unwrap();
        let refused = |body: &Body| patch_compliance(body, &grid).err();
        let slab = |height: f64| Body::slab(material(1.0, 0.3), height).unwrap();
        assert_eq!(refused(&slab(0.1).on(Base::FREE).unwrap()), Some(GreenError::FreePlate));
        assert!(matches!(refused(&slab(1e-3)), Some(GreenError::ThinLayer { .. })));
        let line = Grid::line(32, 1.0).unwrap();
        assert!(matches!(patch_compliance(&slab(1e-3), &line).err(), Some(GreenError::ThinLayer { .. })));
        let sheared = |body: &Body| patch_matrix(body, &grid).err();
        let slides = slab(0.1).on(Base::SLIDING).unwrap();
        assert_eq!(sheared(&slides), Some(GreenError::FreeSliding));
        assert_eq!(sheared(&slab(0.2).bonded_to(slides).unwrap()), Some(GreenError::FreeSliding));
        assert_eq!(sheared(&slab(0.1).on(Base::FREE).unwrap()), Some(GreenError::FreePlate));
        assert!(matches!(sheared(&slab(1e-3)), Some(GreenError::ThinLayer { .. })));
        let below = Body::half_space(material(1.0, 0.3)).against(slab(0.1).on(Base::FREE).unwrap());
        assert_eq!(refused(&below), Some(GreenError::FreePlate));
    }
}
