//! Laws from tables.

use approx::assert_relative_eq;
use gfmd_law::{Exponential, InUnits, Law, LawError, LawKind, Morse, Tabulated};

/// Samples `law` in `n` + 1 rows from the gap `first` to 27 ranges beyond, denser at small gaps; the last traction is
/// set to 0.
fn sampled(law: &dyn Law, range: f64, first: f64, n: u32) -> Tabulated {
    let mut rows: Vec<[f64; 2]> = (0..=n)
        .map(|k| f64::from(k) / f64::from(n))
        .map(|x| first + range * (25.0 * x * x * x + 2.0 * x))
        .map(|gap| [gap, law.opening(gap).traction])
        .collect();
    rows[n as usize][1] = 0.0;
    Tabulated::new(&rows).unwrap()
}

/// Returns the largest errors of energy, traction × range and slope × range² between the gaps `low` and `high`.
fn errors(law: &dyn Law, found: &Tabulated, [low, high]: [f64; 2], range: f64) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for k in 0..=997 {
        let gap = low + (high - low) * f64::from(k) / 997.0;
        let (a, b) = (law.opening(gap), found.opening(gap));
        for (worst, error) in worst.iter_mut().zip([
            a.energy - b.energy,
            (a.traction - b.traction) * range,
            (a.slope - b.slope) * range * range,
        ]) {
            *worst = worst.max(error.abs());
        }
    }
    worst
}

#[test]
fn a_table_of_a_law_is_that_law_to_the_order_of_the_interpolation() {
    let (gamma, range) = (2.0, 0.3);
    let exponential = Exponential::new(gamma, range).unwrap();
    let morse = Morse::new(gamma, range).unwrap();
    // The order is 3 away from the largest traction, where the slope of the curve is zero, and 2 beside it.
    let laws: [(&dyn Law, f64, [f64; 2], f64); 3] =
        [(&exponential, 0.0, [0.0, 3.0], 2.7), (&morse, -0.3, [-0.29, 0.1], 2.5), (&morse, -0.3, [0.1, 1.0], 1.7)];
    for (law, first, span, order) in laws {
        let [coarse, fine] = [100, 800].map(|n| errors(law, &sampled(law, range, first, n), span, range));
        for (k, order) in [order, order, order - 1.0].into_iter().enumerate() {
            let found = (coarse[k] / fine[k]).log2() / 3.0;
            assert!(found > order, "{law:?} {k}: {found}, {coarse:?} {fine:?}");
        }
        assert!(fine[0] < 1e-5 * gamma && fine[1] < 1e-4 * gamma, "{law:?}: {fine:?}");
    }
    let table = sampled(&exponential, range, 0.0, 400);
    assert!(table.has_wall() && !sampled(&morse, range, -0.3, 400).has_wall());
    assert_relative_eq!(table.work(), gamma, max_relative = 1e-5);
    assert_relative_eq!(table.steepness(), exponential.steepness(), max_relative = 1e-3);
    let table = sampled(&morse, range, -0.3, 400);
    assert_relative_eq!(table.work(), gamma, max_relative = 1e-4);
    assert_relative_eq!(table.steepness(), morse.steepness(), max_relative = 1e-2);
    assert_relative_eq!(table.stiffness_bound(-0.3), morse.stiffness_bound(-0.3), max_relative = 1e-2);
}

#[test]
fn the_traction_is_the_slope_of_the_energy_and_goes_on_beyond_the_table() {
    let rows = [[-0.2, -3.0], [0.0, 0.0], [0.1, 1.0], [0.3, 0.4], [0.5, 0.0]];
    let law = Tabulated::new(&rows).unwrap();
    for gap in [-0.7, -0.2, -0.05, 0.0, 0.05, 0.1, 0.27, 0.45, 0.6] {
        let step = 1e-6;
        let of = |gap: f64| law.opening(gap);
        assert_relative_eq!(
            (of(gap + step).energy - of(gap - step).energy) / (2.0 * step),
            of(gap).traction,
            epsilon = 2e-4
        );
        assert_eq!(law.response(gap, 0.7).traction, [of(gap).traction, 0.0]);
        assert_eq!(law.energy(gap, 0.3), Some(law.opening_energy(gap)));
        assert_eq!(law.opening_energy(gap), of(gap).energy);
    }
    // The repulsion grows along its tangent.
    let [a, b, c] = [-0.2, -1.2, -2.2].map(|gap| law.opening(gap).traction);
    assert!(a == -3.0 && b < -8.0);
    assert_relative_eq!(b - a, c - b, max_relative = 1e-12);
    assert_eq!(law.opening(0.5), law.opening(9.0));
    assert_eq!((law.opening(0.6).energy, law.opening(0.6).traction), (0.0, 0.0));
    assert_relative_eq!(law.work(), -law.opening_energy(0.0), max_relative = 1e-12);
    assert!(law.mixed_mode().is_none());
    let (stress, length) = (2.0_f64.powi(80), 2.0_f64.powi(-60));
    let large = rows.map(|[gap, traction]| [gap * length, traction * stress]);
    let scaled = InUnits::new(Tabulated::new(&large).unwrap().into_shared(), stress, length);
    for gap in [-0.4, 0.05, 0.2, 1.0] {
        assert_eq!(scaled.opening(gap), law.opening(gap));
        assert_eq!(scaled.stiffness_bound(gap), law.stiffness_bound(gap));
    }
    assert_eq!([scaled.steepness(), f64::from(u8::from(scaled.has_wall()))], [law.steepness(), 0.0]);
}

#[test]
fn tables_that_are_no_law_are_refused_by_what_is_wrong() {
    let refused = |rows: &[[f64; 2]]| Tabulated::new(rows).unwrap_err().to_string();
    for (rows, words) in [
        (&[[0.0, 1.0], [1.0, 0.5], [2.0, 0.0]][..], "the table: 3 rows; there must be at least 4"),
        (
            &[[0.0, 1.0], [1.0, 0.5], [1.0, 0.2], [2.0, 0.0]],
            "row 3 begins with 1; it must begin with a number above that of row 2, 1",
        ),
        (&[[0.0, 1.0], [1.0, f64::NAN], [1.5, 0.2], [2.0, 0.0]], "row 2 has NaN; it must have finite numbers"),
        (
            &[[0.1, 1.0], [1.0, 0.5], [1.5, 0.2], [2.0, 0.0]],
            "the smallest gap is 1e-1; it must be 0, where a hard wall stands",
        ),
        (&[[-3.0, -1.0], [-2.0, 0.5], [-1.5, 0.2], [-1.0, 0.0]], "the largest gap is -1e0; it must be positive"),
        (&[[0.0, 1.0], [1.0, 0.5], [1.5, 0.2], [2.0, 0.1]], "the traction at the largest gap is 1e-1; it must be 0"),
        (
            &[[-1.0, 1.0], [1.0, 0.5], [1.5, 0.2], [2.0, 0.0]],
            "the traction at the smallest gap is 1e0; it must be negative",
        ),
        (&[[-1.0, -1.0], [-0.5, -2.0], [1.5, 0.2], [2.0, 0.0]], "the slope at the smallest gap is "),
        (&[[0.0, 0.0], [1.0, 0.0], [1.5, 0.0], [2.0, 0.0]], "the tractions are 0; it must be other than 0 somewhere"),
        (&[[0.0, 1e300], [1e200, 1e300], [2e200, 1e300], [3e200, 0.0]], "slope or integral"),
    ] {
        let found = refused(rows);
        assert!(found.contains(words), "{found}");
    }
    assert_eq!(LawKind::Table.with(&[] as &[(&str, f64)]).unwrap_err(), LawError::NoTable);
    assert!(LawKind::Table.with(&[("gamma", 1.0)]).unwrap_err().to_string().contains("the law table has no parameter"));
}
