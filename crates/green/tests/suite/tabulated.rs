//! Bodies from tables of their normal compliance.

use approx::assert_relative_eq;
use gfmd_green::{Body, GreenError, Material};

/// `n` rows of a body, in geometric steps.
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
