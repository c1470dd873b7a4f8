//! Body loaded on a patch of its surface only: displacement caused by a uniform pressure on one cell of a grid
//! (theory.md, section 3.1).

mod layered;

use std::f64::consts::PI;

use gfmd_field::Grid;

use crate::{Body, Conductor, GreenError};
use layered::{Correction, MatrixCorrection};

/// Returns the frictionless compliance of a surface patch, in length/stress: the downward displacement at the centre of
/// a cell caused by a uniform unit pressure on the cell `[i, j]` cells away; zero far away. The half-space is in closed
/// form (Love 1929). The contribution of layers is a quadrature of their compliance over all wavenumbers, accurate to
/// about 1e-12 of the entry `[0, 0]`.
///
/// On a line, the cells are infinitely long strips. Without a [level](has_level) far away, the displacement is relative
/// to points at a distance of one patch length from a much narrower strip.
///
/// # Errors
/// Returns an error for a plate, which has no support, and for layers thinner than 1/200 of the patch or 1/4 of a cell.
pub fn patch_compliance(body: &Body, grid: &Grid) -> Result<impl Fn([usize; 2]) -> f64 + Sync + use<>, GreenError> {
    patch_of(body, grid, Body::normal_compliance)
}

/// Returns the resistance of a surface patch, in length: the potential at the centre of a cell caused by a uniform
/// current density of 1 on the cell `[i, j]` cells away; see [`patch_compliance`]. The potential is zero far away and
/// on the electrode.
///
/// # Errors
/// Returns an error for an electrode at a depth of less than 1/200 of the patch or 1/4 of a cell.
pub fn patch_resistance(
    conductor: &Conductor,
    grid: &Grid,
) -> Result<impl Fn([usize; 2]) -> f64 + Sync + use<>, GreenError> {
    patch_of(conductor.body(), grid, Body::transverse_compliance)
}

/// Returns the patch function of a body with the compliance G(q), with q G → 2/E* for short waves.
fn patch_of(
    body: &Body,
    grid: &Grid,
    compliance: fn(&Body, f64) -> f64,
) -> Result<impl Fn([usize; 2]) -> f64 + Sync + use<>, GreenError> {
    let correction = Correction::of(body, grid, compliance)?;
    let modulus = body.contact_modulus();
    let (sides, length, is_line) = (grid.spacing(), grid.lengths()[0], grid.is_line());
    Ok(move |[i, j]: [usize; 2]| {
        let at = [i as f64 * sides[0], j as f64 * sides[1]];
        let integral = if is_line { -2.0 * strip(at[0], sides[0], length) } else { rectangle(at, sides) };
        integral / (PI * modulus) + correction.as_ref().map_or(0.0, |correction| correction.integral(at))
    })
}

/// Returns true if the displacement caused by a pressure on a patch vanishes far away: on a surface, and on a profile
/// if a base holds the body. For a profile on a half-space, it grows as the logarithm of the distance, and its level
/// is a choice ([`patch_compliance`]).
pub fn has_level(body: &Body, grid: &Grid) -> bool {
    !grid.is_line() || body.normal_compliance(0.0).is_finite()
}

/// Compliance of a patch for all components, in length/stress: the displacement u at the centre of a cell caused by a
/// uniform unit traction on another cell (Boussinesq and Cerruti; Johnson 1985, section 3.6); zero far away.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "entries of the matrix G in u = G t, with +z out of the body")]
pub struct PatchMatrix {
    pub xx: f64,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

/// Returns the [matrix](PatchMatrix) of a patch, for the displacement `[i, j]` cells away from the loaded cell, i and j
/// ≥ 0. xy is odd in i and in j, xz in i, yz in j; the others are even. Half-spaces are in closed form, and layers are
/// included by quadrature, as in [`patch_compliance`].
///
/// # Errors
/// Returns an error for a line, which has an undetermined constant in the lateral displacement; for a plate or a body
/// that slides on its base; and for layers thinner than 1/200 of the patch or 1/4 of a cell.
pub fn patch_matrix(body: &Body, grid: &Grid) -> Result<impl Fn([usize; 2]) -> PatchMatrix + Sync + use<>, GreenError> {
    if grid.is_line() {
        return Err(GreenError::LineShear);
    }
    let correction = MatrixCorrection::of(body, grid)?;
    let normal = patch_compliance(body, grid)?;
    let sides = grid.spacing();
    let bodies = [Some(body), body.second()].into_iter().flatten().map(Body::material);
    let sum = |of: &dyn Fn(&crate::Material) -> f64| bodies.clone().map(of).sum::<f64>();
    let direct = sum(&|material| (1.0 - material.poisson()) / (2.0 * PI * material.shear_modulus()));
    let poisson = sum(&|material| material.poisson() / (2.0 * PI * material.shear_modulus()));
    // A second body is upside down.
    let signs = [1.0, -1.0].into_iter();
    let coupled: f64 = (bodies.clone().zip(signs))
        .map(|(material, sign)| sign * (1.0 - 2.0 * material.poisson()) / (4.0 * PI * material.shear_modulus()))
        .sum();
    Ok(move |[i, j]: [usize; 2]| {
        let at = [i as f64 * sides[0], j as f64 * sides[1]];
        let turned = |[x, y]: [f64; 2]| [y, x];
        let [along, other] = [along_x(at, sides), along_x(turned(at), turned(sides))];
        let [xx, yy, xy, xz, yz] = correction.as_ref().map_or([0.0; 5], |correction| correction.integral(at));
        PatchMatrix {
            xx: direct * (along + other) + poisson * along + xx,
            yy: direct * (along + other) + poisson * other + yy,
            zz: normal([i, j]),
            xy: if i == 0 || j == 0 { 0.0 } else { poisson * across(at, sides) + xy },
            xz: if i == 0 { 0.0 } else { coupled * aside(at, sides) + xz },
            yz: if j == 0 { 0.0 } else { coupled * aside(turned(at), turned(sides)) + yz },
        }
    })
}

/// Distance in cells beyond which integrals are computed by quadrature, since differences of the primitive at the
/// corners would lose digits; and distance beyond which few points suffice. The methods agree to 1e-12 of the integral.
const FAR: [f64; 2] = [8.0, 64.0];

/// Nodes and weights of Gauss quadrature on −1/2 to 1/2.
const FIVE: [[f64; 2]; 5] = [
    [-0.453_089_922_969_332, 0.118_463_442_528_094_54],
    [-0.269_234_655_052_841_55, 0.239_314_335_249_683_23],
    [0.0, 0.284_444_444_444_444_44],
    [0.269_234_655_052_841_55, 0.239_314_335_249_683_23],
    [0.453_089_922_969_332, 0.118_463_442_528_094_54],
];
const THREE: [[f64; 2]; 3] = [
    [-0.387_298_334_620_741_7, 0.277_777_777_777_777_8],
    [0.0, 4.0 / 9.0],
    [0.387_298_334_620_741_7, 0.277_777_777_777_777_8],
];

/// Returns ∫∫ f dA over a rectangle with these sides, centred at `at`; ∂²`primitive`/∂x∂y = f.
fn integral(at: [f64; 2], sides: [f64; 2], f: impl Fn(f64, f64) -> f64, primitive: impl Fn(f64, f64) -> f64) -> f64 {
    let [x, y] = at;
    let [a, b] = sides;
    let cells = x.hypot(y) / a.max(b);
    let by = |nodes: &[[f64; 2]]| {
        let along = |u: f64| -> f64 { nodes.iter().map(|[t, w]| w * f(u, y + t * b)).sum() };
        a * b * nodes.iter().map(|[t, w]| w * along(x + t * a)).sum::<f64>()
    };
    if cells > FAR[1] {
        return by(&THREE);
    }
    if cells > FAR[0] {
        return by(&FIVE);
    }
    // The coordinates of corners are never zero.
    let [left, right, below, above] = [x - 0.5 * a, x + 0.5 * a, y - 0.5 * b, y + 0.5 * b];
    primitive(right, above) - primitive(left, above) - primitive(right, below) + primitive(left, below)
}

/// Returns ∫∫ dA/r over a rectangle with these sides, for the distance r from the point `at` relative to its centre.
fn rectangle(at: [f64; 2], sides: [f64; 2]) -> f64 {
    let primitive = |x: f64, y: f64| x * (y / x.abs()).asinh() + y * (x / y.abs()).asinh();
    integral(at, sides, |x, y| 1.0 / x.hypot(y), primitive)
}

/// Returns ∫∫ x²/r³ dA.
fn along_x(at: [f64; 2], sides: [f64; 2]) -> f64 {
    integral(at, sides, |x, y| x * x / x.hypot(y).powi(3), |x, y| y * (x / y.abs()).asinh())
}

/// Returns ∫∫ x y/r³ dA.
fn across(at: [f64; 2], sides: [f64; 2]) -> f64 {
    integral(at, sides, |x, y| x * y / x.hypot(y).powi(3), |x, y| -x.hypot(y))
}

/// Returns ∫∫ x/r² dA.
fn aside(at: [f64; 2], sides: [f64; 2]) -> f64 {
    let primitive = |x: f64, y: f64| y * x.hypot(y).ln() + x * (y / x).atan();
    integral(at, sides, |x, y| x / (x * x + y * y), primitive)
}

/// Returns ∫ ln(|x + s|/length) ds over −width/2 to width/2.
fn strip(x: f64, width: f64, length: f64) -> f64 {
    let by =
        |nodes: &[[f64; 2]]| width * nodes.iter().map(|[t, w]| w * ((x + t * width).abs() / length).ln()).sum::<f64>();
    if x > FAR[1] * width {
        return by(&THREE);
    }
    if x > FAR[0] * width {
        return by(&FIVE);
    }
    let primitive = |x: f64| x * ((x.abs() / length).ln() - 1.0);
    primitive(x + 0.5 * width) - primitive(x - 0.5 * width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;

    #[test]
    fn quadrature_and_closed_form_agree_where_they_meet() {
        for sides in [[1.0, 1.0], [1.0, 0.25], [0.1, 1.0]] {
            for edge in FAR {
                for angle in [0.0_f64, 0.3, 0.9, 1.5] {
                    let at = |cells: f64| [cells * angle.cos(), cells * angle.sin()];
                    let [near, far] = [edge * (1.0 - 1e-13), edge * (1.0 + 1e-13)].map(|r| rectangle(at(r), sides));
                    assert!((near / far - 1.0).abs() < 1e-12, "{sides:?} {edge} {angle}: {near} {far}");
                }
            }
        }
        for edge in FAR {
            let [near, far] = [edge * (1.0 - 1e-13), edge * (1.0 + 1e-13)].map(|x| strip(x, 1.0, 1000.0));
            assert!((near / far - 1.0).abs() < 1e-12, "{near} {far}");
        }
    }

    #[test]
    fn cells_add_up_to_a_larger_rectangle() {
        // Love's corner and centre of a square: the integral over a square from its centre is 4 a asinh 1.
        assert!((rectangle([0.0; 2], [2.0; 2]) - 8.0 * 1.0_f64.asinh()).abs() < 1e-14);
        let whole = rectangle([300.0, 40.0], [9.0, 3.0]);
        let parts: f64 = (0..27)
            .map(|k| rectangle([300.0 + f64::from(k % 9) - 4.0, 40.0 + f64::from(k / 9) - 1.0], [1.0, 1.0]))
            .sum();
        assert!((whole / parts - 1.0).abs() < 1e-13, "{whole} {parts}");
        let parts: f64 = (0..9).map(|k| strip(30.0 + f64::from(k) - 4.0, 1.0, 100.0)).sum();
        assert!((strip(30.0, 9.0, 100.0) / parts - 1.0).abs() < 1e-13);
    }

    /// Compares the primitives with quadrature, and the sum of x²/r³ and y²/r³ with 1/r.
    #[test]
    fn tangential_integrals_are_those_of_their_functions() {
        for sides in [[1.0, 1.0], [1.0, 0.3], [0.4, 1.0]] {
            for at in [[1.0, 1.0], [2.0, 0.0], [0.0, 3.0], [3.0, 2.0]] {
                let at = [at[0] * sides[0], at[1] * sides[1]];
                // Gauss quadrature on 20 x 20 parts of the rectangle.
                let fine = |f: &dyn Fn(f64, f64) -> f64| {
                    let mut sum = 0.0;
                    for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
                        let part = |k: i32, side: f64| side * ((f64::from(k) + 0.5) / 20.0 - 0.5);
                        for ([s, v], [t, w]) in FIVE.iter().flat_map(|a| FIVE.iter().map(move |b| (a, b))) {
                            let x = at[0] + part(i, sides[0]) + s * sides[0] / 20.0;
                            let y = at[1] + part(j, sides[1]) + t * sides[1] / 20.0;
                            sum += v * w * f(x, y);
                        }
                    }
                    sum * sides[0] * sides[1] / 400.0
                };
                let r = |x: f64, y: f64| x.hypot(y);
                for (found, wanted) in [
                    (along_x(at, sides), fine(&|x, y| x * x / r(x, y).powi(3))),
                    (across(at, sides), fine(&|x, y| x * y / r(x, y).powi(3))),
                    (aside(at, sides), fine(&|x, y| x / r(x, y).powi(2))),
                ] {
                    assert!((found - wanted).abs() < 1e-11, "{sides:?} {at:?}: {found} {wanted}");
                }
            }
        }
        let turned = along_x([0.3, 0.7], [1.0, 0.5]) + along_x([0.7, 0.3], [0.5, 1.0]);
        assert!((turned - rectangle([0.3, 0.7], [1.0, 0.5])).abs() < 1e-14);
    }

    #[test]
    fn a_cell_below_its_own_pressure_sinks_as_love_says() {
        let material = Material::from_contact_modulus(2.0, 0.3).unwrap();
        let grid = Grid::square(4, 1.0).unwrap();
        let compliance = patch_compliance(&Body::half_space(material), &grid).unwrap();
        assert!((compliance([0, 0]) - 4.0 * 0.25 * 1.0_f64.asinh() / (2.0 * PI)).abs() < 1e-15);
        assert_eq!(compliance([1, 3]), compliance([3, 1]));
    }
}
