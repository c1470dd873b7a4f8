//! Tests of bodies from tables of normal compliance.

use std::f64::consts::PI;

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_green::{Body, GreenError, Material, normal_stiffness_range, normal_stiffness_table};

/// Returns `n` rows of a body, in geometric steps.
fn table(body: &Body, n: u32) -> Vec<[f64; 2]> {
    let q = |k: u32| 0.1 * 1e4_f64.powf(f64::from(k) / f64::from(n - 1));
    (0..n).map(q).map(|q| [q, body.normal_compliance(q)]).collect()
}

#[test]
fn a_table_of_a_body_has_its_compliance_to_the_order_of_the_interpolation() {
    let material = Material::from_young(2.0, 0.3).unwrap();
    let modulus = material.contact_modulus();
    let half_space = Body::half_space(material);
    // A power law is a straight line in logarithms.
    let found = Body::tabulated(modulus, &table(&half_space, 4), 0.0).unwrap();
    for q in [0.1, 0.37, 5.0, 123.0, 1000.0] {
        assert_relative_eq!(found.normal_compliance(q), half_space.normal_compliance(q), max_relative = 1e-13);
    }
    assert_eq!((found.normal_compliance(0.0), found.level_compliance()[1]), (f64::INFINITY, 0.0));
    assert_relative_eq!(found.contact_modulus(), modulus, max_relative = 1e-15);
    let slab = Body::slab(material, 0.5).unwrap();
    let errors = [50, 100, 200].map(|n| {
        let found = Body::tabulated(modulus, &table(&slab, n), 1.0).unwrap();
        let error = |q: f64| (found.normal_compliance(q) / slab.normal_compliance(q) - 1.0).abs();
        (0..2000).map(|k| 0.1 * 1e4_f64.powf(f64::from(k) / 1999.0)).map(error).fold(0.0, f64::max)
    });
    assert!(errors[2] < 1e-4, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.3 * pair[0]), "{errors:?}");
}

#[test]
fn units_are_those_of_the_rows_and_other_components_are_not_known() {
    let slab = Body::slab(Material::from_young(2.0, 0.3).unwrap(), 0.5).unwrap();
    let found = Body::tabulated(2.2, &table(&slab, 60), 0.25).unwrap();
    let (stress, length) = (2.0_f64.powi(30), 2.0_f64.powi(-20));
    let scaled = found.in_units(stress, length);
    for q in [0.3, 7.0, 400.0] {
        let wanted = found.normal_compliance(q) * stress / length;
        assert_eq!(scaled.normal_compliance(q * length), wanted);
        assert!(found.compliance_blocks(q).normal.is_nan() && found.stiffness_blocks(q).longitudinal.is_nan());
        assert!(found.restricted_normal_stiffness(q).is_nan() && found.transverse_compliance(q).is_nan());
    }
    assert_eq!(scaled.level_compliance()[1], 0.25 * stress / length);
    let [[low, high], [low_of_scaled, high_of_scaled]] =
        [&found, &scaled].map(|body| body.tabulated_wavenumbers().unwrap());
    assert_relative_eq!(low, 0.1, max_relative = 1e-14);
    assert_relative_eq!(high, 1000.0, max_relative = 1e-14);
    assert_eq!([low_of_scaled, high_of_scaled], [low * length, high * length]);
    assert!(slab.tabulated_wavenumbers().is_none());
}

/// Returns rows [q_x, q_y, G] of a function of wavenumber and angle: `n` wavenumbers, `directions` in half a turn.
fn polar(n: u32, directions: usize, compliance: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
    let q = |k: u32| 0.1 * 1e4_f64.powf(f64::from(k) / f64::from(n - 1));
    let angle = |j: usize| PI * j as f64 / directions as f64;
    let waves = (0..n).flat_map(|k| (0..directions).map(move |j| (q(k), angle(j))));
    waves.map(|(q, angle)| [q * angle.cos(), q * angle.sin(), compliance(q, angle)]).collect()
}

#[test]
fn a_table_by_direction_of_an_isotropic_body_is_that_body() {
    let slab = Body::slab(Material::from_young(2.0, 0.3).unwrap(), 0.5).unwrap();
    let by_wavenumber = Body::tabulated(2.2, &table(&slab, 40), 0.25).unwrap();
    let mut rows = polar(40, 7, |q, _| slab.normal_compliance(q));
    // Rows may be in any order, with −q for q.
    rows.reverse();
    rows.iter_mut().step_by(3).for_each(|[x, y, _]| (*x, *y) = (-*x, -*y));
    let found = Body::tabulated_by_direction(2.2, &rows, 0.25).unwrap();
    assert!(found.is_isotropic() && found.level_compliance()[1] == 0.25);
    for q in [0.1, 0.37, 5.0, 123.0, 999.0] {
        assert_relative_eq!(found.normal_compliance(q), by_wavenumber.normal_compliance(q), max_relative = 1e-12);
        let along = found.normal_compliance_along([0.6 * q, -0.8 * q]);
        assert_relative_eq!(along, by_wavenumber.normal_compliance(q), max_relative = 1e-12);
    }
}

/// Smooth functions of the angle converge faster than any power of the number of directions. For a half-space, G q
/// depends on the angle only, and four wavenumbers suffice.
#[test]
fn a_table_by_direction_converges_exponentially_in_the_directions() {
    let of_angle = |angle: f64| 1.0 / (1.0 + 0.4 * (2.0 * (angle - 0.3)).cos() + 0.1 * (4.0 * angle).sin());
    let errors = [8, 16, 32].map(|directions| {
        let rows = polar(4, directions, |q, angle| 2.0 / q * of_angle(angle));
        let found = Body::tabulated_by_direction(1.0, &rows, 0.0).unwrap();
        assert!(!found.is_isotropic() && found.normal_compliance(1.0).is_nan());
        let error = |k: u32| {
            let (q, angle) = (0.1 + 0.7 * f64::from(k), 0.017 * f64::from(k) - 2.0);
            let along = found.normal_compliance_along([q * angle.cos(), q * angle.sin()]);
            (along * q / 2.0 / of_angle(angle) - 1.0).abs()
        };
        (0..400).map(error).fold(0.0, f64::max)
    });
    assert!(errors[1] < 0.03 * errors[0] && errors[2] < 1e-3 * errors[1], "{errors:?}");
    assert!(errors[2] < 1e-6, "{errors:?}");
}

/// A mode at Nyquist stands for waves of both signs; the stiffness is real and even, so that real fields remain real.
#[test]
fn modes_of_a_grid_have_the_mean_stiffness_of_their_aliases() {
    let rows = polar(4, 8, |q, angle| (2.0 + (2.0 * angle + 0.5).sin()) / q);
    let body = Body::tabulated_by_direction(1.0, &rows, 0.0).unwrap();
    let grid = Grid::new([6, 8], [1.0, 2.0]).unwrap();
    let table = normal_stiffness_table(&body, &grid, 0.0);
    let along = |x: f64, y: f64| 1.0 / body.normal_compliance_along([x, y]);
    for (mode, found) in grid.modes().zip(&table).skip(1) {
        let [x, y] = mode.wavevector;
        let wanted = match mode.nyquist {
            [false, false] => along(x, y),
            _ => 0.5 * (along(x, y) + along(-x, y)),
        };
        assert_relative_eq!(*found, wanted, max_relative = 1e-13);
    }
    let of = |m: i64| table[grid.index_of([m, -4]).unwrap()];
    assert_relative_eq!(of(2), of(-2), max_relative = 1e-14);
    let range = normal_stiffness_range(&body, &grid).unwrap();
    assert_eq!(range.stiffest, table.iter().copied().fold(0.0, f64::max));
    assert_eq!(range.softest, table[1..].iter().copied().fold(f64::INFINITY, f64::min));
}

#[test]
fn unusable_tables_by_direction_are_refused() {
    let good = polar(4, 4, |q, _| 1.0 / q);
    let of = |rows: &[[f64; 3]]| Body::tabulated_by_direction(1.0, rows, 0.0).unwrap_err().to_string();
    assert!(Body::tabulated_by_direction(1.0, &good, 0.0).is_ok());
    assert!(of(&good[..15]).contains("4 rows with the smallest wavenumber, and 15 in all"));
    assert!(of(&polar(4, 3, |q, _| 1.0 / q)).contains("it must have 4 or more directions"));
    assert!(of(&good[..12]).contains("3 rows; there must be at least 4"));
    let changed = |index: usize, row: [f64; 3]| {
        let mut rows = good.clone();
        rows[index] = row;
        of(&rows)
    };
    assert!(changed(2, [0.0, 0.0, 1.0]).contains("row 3 of the table of compliances has the wave vector [0.0, 0.0]"));
    assert!(
        changed(3, [f64::NAN, 0.0, 1.0]).contains("row 4 of the table of compliances has the wave vector [NaN, 0.0]")
    );
    assert!(changed(1, [0.1, 0.0, -1.0]).contains("row 2 of the table of compliances has -1"));
    let moved = changed(1, [0.1 * 0.7, 0.1 * (1.0_f64 - 0.49).sqrt(), 1.0]);
    assert!(moved.contains("row 2"), "{moved}");
    assert!(moved.contains("45.573 degrees"), "{moved}");
    assert!(moved.contains("180/4 degrees"), "{moved}");
    assert!(Body::tabulated_by_direction(1.0, &good, -1.0).is_err());
}

#[test]
fn unusable_tables_are_refused() {
    let good = [[1.0, 2.0], [2.0, 1.0], [4.0, 0.5], [8.0, 0.25]];
    let of = |rows: &[[f64; 2]], uniform: f64| Body::tabulated(1.0, rows, uniform).unwrap_err().to_string();
    assert!(of(&good[..3], 0.0).contains("3 rows; there must be at least 4"));
    assert!(of(&[[0.0, 2.0], good[1], good[2], good[3]], 0.0).contains("row 1 of the table of compliances has 0"));
    assert!(of(&[good[0], [2.0, -1.0], good[2], good[3]], 0.0).contains("row 2 of the table of compliances has -1"));
    assert!(
        of(&[good[0], good[1], [4.0, f64::NAN], good[3]], 0.0).contains("row 3 of the table of compliances has NaN")
    );
    assert!(of(&[good[1], good[0], good[2], good[3]], 0.0).contains("row 2"));
    assert!(of(&good, -1.0).contains("uniform compliance is -1"));
    assert_eq!(Body::tabulated(0.0, &good, 0.0), Err(GreenError::ContactModulus(0.0)));
}
