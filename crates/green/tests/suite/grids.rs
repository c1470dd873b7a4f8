//! Tests of tables and ranges over the modes of a grid.

use crate::support::*;
use gfmd_field::{Grid, Mode};
use gfmd_green::{
    Base, Body, Material, Matrix3, normal_stiffness_range, normal_stiffness_table, restricted_normal_stiffness_table,
    stiffness_range,
};
use proptest::prelude::*;

/// Computes the eigenvalues of a stiffness matrix by Jacobi rotations; with u_z = −i w, it is real and symmetric.
fn eigenvalues(m: &Matrix3) -> [f64; 3] {
    let mut a = [
        [m[0][0].re, m[0][1].re, m[0][2].im],
        [m[0][1].re, m[1][1].re, m[1][2].im],
        [m[0][2].im, m[1][2].im, m[2][2].re],
    ];
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(12) {
        let angle = 0.5 * (2.0 * a[p][q]).atan2(a[p][p] - a[q][q]);
        let (s, c) = angle.sin_cos();
        for row in &mut a {
            (row[p], row[q]) = (c * row[p] + s * row[q], c * row[q] - s * row[p]);
        }
        let (up, uq) = (a[p], a[q]);
        a[p] = [0, 1, 2].map(|column| c * up[column] + s * uq[column]);
        a[q] = [0, 1, 2].map(|column| c * uq[column] - s * up[column]);
    }
    [a[0][0], a[1][1], a[2][2]]
}

fn grid() -> impl Strategy<Value = Grid> {
    (1usize..12, 1usize..12, 0.3..3.0, 0.3..3.0).prop_map(|(nx, ny, lx, ly)| Grid::new([nx, ny], [lx, ly]).unwrap())
}

fn extremes(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values
        .filter(|v| v.is_finite() && *v > 1e-12)
        .fold([f64::INFINITY, 0.0], |[low, high], v| [low.min(v), high.max(v)])
}

proptest! {
    #[test]
    fn a_table_holds_every_mode_in_order(body in body(), grid in grid()) {
        let stiffness = normal_stiffness_table(&body, &grid, 8.0);
        let restricted = restricted_normal_stiffness_table(&body, &grid, 9.0);
        prop_assert_eq!(stiffness.len(), grid.spectrum_len());
        for (index, mode) in grid.modes().enumerate() {
            let found = [stiffness[index], restricted[index]];
            let q = mode.wavenumber();
            let wanted = if mode.is_uniform() { [8.0, 9.0] } else {
                [body.normal_stiffness(q), body.restricted_normal_stiffness(q)]
            };
            prop_assert_eq!(found, wanted, "{:?}", mode);
        }
    }

    #[test]
    fn ranges_agree_with_every_single_mode(body in body(), grid in grid()) {
        let [lateral, normal] = body.level_compliance().map(f64::recip);
        let of = |mode: &Mode| if mode.is_uniform() { normal } else { body.normal_stiffness(mode.wavenumber()) };
        let [low, high] = extremes(grid.modes().map(|mode| of(&mode)));
        match normal_stiffness_range(&body, &grid) {
            None => prop_assert_eq!(low, f64::INFINITY),
            Some(range) => {
                prop_assert_eq!([range.softest, range.stiffest], [low, high]);
                prop_assert_eq!([of(&range.softest_mode), of(&range.stiffest_mode)], [low, high]);
            }
        }
        let all = |mode: Mode| {
            let mut matrix = body.stiffness_of(&mode);
            if mode.is_uniform() {
                let held = |stiffness: f64| if stiffness.is_finite() { stiffness } else { 0.0 };
                let normal = if normal.is_finite() { normal } else { lateral };
                for (axis, value) in [lateral, lateral, normal].into_iter().enumerate() {
                    matrix[axis][axis] = held(value).into();
                }
            }
            if grid.is_line() {
                matrix[1][1] = matrix[0][0];
            }
            eigenvalues(&matrix)
        };
        let [low, high] = extremes(grid.modes().flat_map(all));
        if let Some(range) = stiffness_range(&body, &grid) {
            prop_assert!(apart(range.stiffest, high, high) < 1e-12, "{} {high}", range.stiffest);
            prop_assert!(apart(range.softest, low, high) < 1e-11, "{} {low}", range.softest);
        } else {
            prop_assert_eq!(low, f64::INFINITY);
        }
    }
}

#[test]
fn a_half_space_is_stiffest_at_the_corner_of_its_lattice() {
    let material = Material::from_contact_modulus(1.0, 0.33).unwrap();
    let body = Body::half_space(material);
    let grid = Grid::new([16, 12], [1.0, 0.9]).unwrap();
    let corner = std::f64::consts::PI * grid.spacing()[0].recip().hypot(grid.spacing()[1].recip());
    let range = normal_stiffness_range(&body, &grid).unwrap();
    assert!(apart(range.stiffest, 0.5 * corner, corner) < 1e-15);
    assert!(apart(range.softest, std::f64::consts::PI, 1.0) < 1e-15);
    // Two components: at most 2 C44 q, and less at Nyquist modes, which have no coupling.
    let all = stiffness_range(&body, &grid).unwrap();
    assert!(all.stiffest < 2.0 * material.shear_modulus() * corner && all.stiffest > 0.8 * range.stiffest);
}

/// The softest mode of three components is the uniform shear, unless ν is far below zero (theory.md, section 3).
#[test]
fn uniform_shear_is_softest_of_three_components() {
    let grid = Grid::square(16, 4.0).unwrap();
    for poisson in [-0.1, 0.0, 0.33, 0.45, 0.5] {
        let material = Material::from_young(1.0, poisson).unwrap();
        let range = stiffness_range(&Body::slab(material, 1.0).unwrap(), &grid).unwrap();
        assert!(range.softest_mode.is_uniform(), "{poisson}");
        assert_eq!(range.softest, material.shear_modulus());
    }
    let auxetic = Body::slab(Material::from_young(1.0, -0.5).unwrap(), 1.0).unwrap();
    assert!(!stiffness_range(&auxetic, &grid).unwrap().softest_mode.is_uniform());
}

#[test]
fn a_body_that_nothing_holds_has_no_range_on_one_point() {
    let material = Material::from_young(1.0, 0.3).unwrap();
    let point = Grid::square(1, 1.0).unwrap();
    assert_eq!(normal_stiffness_range(&Body::half_space(material), &point), None);
    assert_eq!(stiffness_range(&Body::half_space(material), &point), None);
    // The lower face of a plate is the reference of its uniform shear.
    for base in [Base::BONDED, Base::FREE] {
        let held = stiffness_range(&Body::slab(material, 1.0).unwrap().on(base).unwrap(), &point).unwrap();
        assert_eq!(held.softest, material.shear_modulus());
    }
}

#[test]
fn tables_are_the_same_for_any_number_of_threads() {
    let body = Body::slab(Material::from_young(1.0, 0.4).unwrap(), 0.3).unwrap();
    for grid in [Grid::square(128, 1.0).unwrap(), Grid::line(20_000, 1.0).unwrap()] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (normal_stiffness_table(&body, &grid, 1.0), normal_stiffness_range(&body, &grid)))
        };
        assert_eq!(with(1), with(3));
    }
}
