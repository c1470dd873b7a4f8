//! A half-space whose surface is loaded on a patch only: the displacement by a uniform pressure on one cell of a grid
//! (theory.md, section 3.1).

use std::f64::consts::PI;

use gfmd_field::Grid;

use crate::{Body, GreenError, Height};

/// The frictionless compliance of a patch of surface, in length/stress: the displacement, downwards, at the centre of a cell
/// by a uniform unit pressure on the cell that lies `[i, j]` cells away, and zero far away (Love 1929).
///
/// On a line the cells are strips without end, and the displacement is known up to a constant: it is zero at one length of
/// the patch from the centre of a strip that is far shorter.
///
/// # Errors
/// A body other than a half-space, or two of them.
pub fn patch_compliance(body: &Body, grid: &Grid) -> Result<impl Fn([usize; 2]) -> f64 + Sync + use<>, GreenError> {
    if let Some(Height::Finite(height)) =
        [Some(body), body.second()].into_iter().flatten().map(Body::height).find(|height| *height != Height::Infinite)
    {
        return Err(GreenError::FreeBoundary(height));
    }
    let modulus = body.contact_modulus();
    let (sides, length, is_line) = (grid.spacing(), grid.lengths()[0], grid.is_line());
    Ok(move |[i, j]: [usize; 2]| {
        let at = [i as f64 * sides[0], j as f64 * sides[1]];
        let integral = if is_line { -2.0 * strip(at[0], sides[0], length) } else { rectangle(at, sides) };
        integral / (PI * modulus)
    })
}

/// The distance in cells beyond which integrals are taken by quadrature, since differences of the primitive at the corners
/// would lose digits; and that beyond which few points are sufficient. They agree to 1e-12 of the integral.
const FAR: [f64; 2] = [8.0, 64.0];

/// Nodes and weights of Gauss's quadrature on −1/2 to 1/2.
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

/// ∫∫ dA/r over a rectangle with these sides, for the distance r from the point `at` relative to its centre.
fn rectangle(at: [f64; 2], sides: [f64; 2]) -> f64 {
    let [x, y] = at;
    let [a, b] = sides;
    let cells = x.hypot(y) / a.max(b);
    let by = |nodes: &[[f64; 2]]| {
        let along = |u: f64| -> f64 { nodes.iter().map(|[t, w]| w / u.hypot(y + t * b)).sum() };
        a * b * nodes.iter().map(|[t, w]| w * along(x + t * a)).sum::<f64>()
    };
    if cells > FAR[1] {
        return by(&THREE);
    }
    if cells > FAR[0] {
        return by(&FIVE);
    }
    // The corners never lie beside the point.
    let primitive = |x: f64, y: f64| x * (y / x.abs()).asinh() + y * (x / y.abs()).asinh();
    let [left, right, below, above] = [x - 0.5 * a, x + 0.5 * a, y - 0.5 * b, y + 0.5 * b];
    primitive(right, above) - primitive(left, above) - primitive(right, below) + primitive(left, below)
}

/// ∫ ln(|x + s|/length) ds over −width/2 to width/2.
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

    #[test]
    fn only_a_half_space_has_one() {
        let material = Material::from_contact_modulus(2.0, 0.3).unwrap();
        let grid = Grid::square(4, 1.0).unwrap();
        let slab = Body::slab(material, 0.5).unwrap();
        assert_eq!(patch_compliance(&slab, &grid).err(), Some(GreenError::FreeBoundary(0.5)));
        let compliance = patch_compliance(&Body::half_space(material), &grid).unwrap();
        assert!((compliance([0, 0]) - 4.0 * 0.25 * 1.0_f64.asinh() / (2.0 * PI)).abs() < 1e-15);
        assert_eq!(compliance([1, 3]), compliance([3, 1]));
    }
}
