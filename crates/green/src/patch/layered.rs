//! What layers add to the compliance of a patch of a half-space: c(r) = 1/(2π) ∫ (q G(q) − 2/E*) J₀(q r) dq.

use std::f64::consts::{PI, TAU};

use gfmd_field::Grid;
use rayon::prelude::*;

use crate::{Base, Body, GreenError, Height};

/// The mean over a cell of what layers add to the displacement by a point force, tabulated by distance.
///
/// The integrand vanishes as e^(−2 q h) beyond the inverse of the thinnest top layer's height h, and c is smooth over distances
/// of 2 h. Quadrature and interpolation are those of Gauss and of Chebyshev on pieces, exact to about 1e-13 of c(0).
pub(super) struct Correction {
    /// Length of a piece of the table.
    piece: f64,
    /// Chebyshev coefficients of c on each piece.
    pieces: Vec<[f64; ORDER]>,
    sides: [f64; 2],
    /// Quadrature over a cell, along each side of length 1.
    nodes: Vec<[f64; 2]>,
}

/// Number of coefficients of a piece, and of nodes of an interval of the quadrature over q.
const ORDER: usize = 16;

/// The largest distance on the patch over the height of the top layer. The effort grows with the square.
const FARTHEST: f64 = 200.0;

/// The largest side of a cell over the height of the top layer.
const WIDEST: f64 = 4.0;

/// q h beyond which e^(−2 q h) (q h)² is a rounding error.
const LAST: f64 = 24.0;

/// Number of times that the first interval of q is halved, for a stiff layer on a soft body.
const HALVINGS: i32 = 40;

impl Correction {
    /// The correction for a body with layers, on distances up to half of the periodic `cell` in which the patch lies; `None` for
    /// a half-space, or two of them.
    ///
    /// # Errors
    /// A plate, which nothing holds; a line; layers that are too thin for the patch or for its cells.
    pub(super) fn of(body: &Body, grid: &Grid) -> Result<Option<Self>, GreenError> {
        let bodies = [Some(body), body.second()].into_iter().flatten();
        let mut thicknesses = Vec::new();
        for body in bodies {
            thicknesses.extend(thickness(body)?);
        }
        let Some(thinnest) = thicknesses.iter().map(|[top, _]| *top).reduce(f64::min) else { return Ok(None) };
        if grid.is_line() {
            return Err(GreenError::FreeProfile(thinnest));
        }
        let all = thicknesses.iter().map(|[_, all]| *all).fold(0.0, f64::max);
        let sides = grid.spacing();
        let farthest = grid.padded()?.lengths();
        let farthest = 0.5 * farthest[0].hypot(farthest[1]) + sides[0].hypot(sides[1]);
        let widest = sides[0].max(sides[1]) / thinnest;
        let least = (farthest / FARTHEST).max(thinnest * widest / WIDEST);
        if thinnest < least {
            return Err(GreenError::ThinLayer { found: thinnest, least });
        }
        let spectrum = Spectrum::of(body, thinnest, all, farthest);
        let count = (farthest / thinnest).ceil().max(1.0) as usize;
        let piece = farthest / count as f64;
        let pieces =
            (0..count).into_par_iter().map(|k| chebyshev(k as f64 * piece, piece, &|r| spectrum.at(r))).collect();
        let nodes = legendre(match widest {
            ..=0.25 => 5,
            ..=1.0 => 8,
            _ => 16,
        });
        Ok(Some(Self { piece, pieces, sides, nodes }))
    }

    /// ∫∫ c dA over a cell whose centre lies at `at` relative to the point.
    pub(super) fn integral(&self, at: [f64; 2]) -> f64 {
        let Self { sides: [a, b], nodes, .. } = self;
        let along = |x: f64| -> f64 { nodes.iter().map(|[t, w]| w * self.at(x.hypot(at[1] + t * b))).sum() };
        a * b * nodes.iter().map(|[t, w]| w * along(at[0] + t * a)).sum::<f64>()
    }

    /// c(r), by Clenshaw's recurrence.
    fn at(&self, r: f64) -> f64 {
        let index = ((r / self.piece) as usize).min(self.pieces.len() - 1);
        let x = 2.0 * (r / self.piece - index as f64) - 1.0;
        let step = |[now, last]: [f64; 2], c: &f64| [2.0 * x * now - last + c, now];
        let [first, rest @ ..] = &self.pieces[index];
        let [now, last] = rest.iter().rev().fold([0.0; 2], step);
        x * now - last + first
    }
}

/// The heights of the top layer and of all layers of a body; `None` for a half-space.
fn thickness(body: &Body) -> Result<Option<[f64; 2]>, GreenError> {
    let Height::Finite(height) = body.height() else { return Ok(None) };
    match body.base() {
        Base::Bonded | Base::Sliding => Ok(Some([height; 2])),
        Base::Free => Err(GreenError::FreePlate),
        Base::Elastic(below) => Ok(Some([height, height + thickness(below)?.map_or(0.0, |[_, all]| all)])),
    }
}

/// The integrand of c at the nodes of its quadrature, without the Bessel function.
struct Spectrum {
    /// q, and the weight times (q G(q) − 2/E*)/2π.
    terms: Vec<[f64; 2]>,
}

impl Spectrum {
    fn of(body: &Body, thinnest: f64, all: f64, farthest: f64) -> Self {
        let half_space = 2.0 / body.contact_modulus();
        let last = LAST / thinnest;
        // An interval is short beside the waves of the Bessel function and the changes of the layers.
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
        let of = |[q, weight]: [f64; 2]| [q, weight * (q * body.normal_compliance(q) - half_space) / TAU];
        Self { terms: terms.into_par_iter().map(of).collect() }
    }

    fn at(&self, r: f64) -> f64 {
        self.terms.iter().map(|[q, term]| term * libm::j0(q * r)).sum()
    }
}

/// The Chebyshev coefficients of `f` on the interval from `start` of this `length`.
fn chebyshev(start: f64, length: f64, f: &dyn Fn(f64) -> f64) -> [f64; ORDER] {
    let angle = |k: usize| PI * (k as f64 + 0.5) / ORDER as f64;
    let values: [f64; ORDER] = std::array::from_fn(|k| f(start + 0.5 * length * (1.0 + angle(k).cos())));
    std::array::from_fn(|m| {
        let sum: f64 = values.iter().enumerate().map(|(k, value)| value * (m as f64 * angle(k)).cos()).sum();
        sum * if m == 0 { 1.0 } else { 2.0 } / ORDER as f64
    })
}

/// Nodes and weights of Gauss's quadrature on −1/2 to 1/2: the zeros of Legendre's polynomial, by Newton's method.
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
    use crate::{Material, patch_compliance};

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

    /// A uniform pressure compresses a slab by its height over the P-wave modulus.
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

    /// Far away, a coated body is its base.
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
        assert_eq!(refused(&slab(0.1).on(Base::Free).unwrap()), Some(GreenError::FreePlate));
        assert!(matches!(refused(&slab(1e-3)), Some(GreenError::ThinLayer { .. })));
        let line = Grid::line(32, 1.0).unwrap();
        assert_eq!(patch_compliance(&slab(0.1), &line).err(), Some(GreenError::FreeProfile(0.1)));
        let below = Body::half_space(material(1.0, 0.3)).against(slab(0.1).on(Base::Free).unwrap());
        assert_eq!(refused(&below), Some(GreenError::FreePlate));
    }
}
