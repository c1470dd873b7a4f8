//! Tests of refused input, and of states without a certificate.

use gfmd_contact::{Contact, Equilibrium, Load, Refusal, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::Array2;

#[test]
fn a_pressure_that_is_not_a_number_has_a_residual_that_is_none() {
    let grid = Grid::square(8, 1.0).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let heights = Array2::from_shape_fn((8, 8), |(i, j)| ((3 * i + 5 * j) % 8) as f64);
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    for load in [Load::Approach(0.5), Load::MeanPressure(0.5)] {
        let mut pressure = Array2::from_elem((8, 8), 0.5);
        pressure[[2, 1]] = f64::NAN;
        assert!(contact.certify(&pressure, load).unwrap().residual.worst().is_nan(), "{load:?}");
        assert!(
            contact.certify(&Array2::from_elem((8, 8), f64::NAN), load).unwrap().residual.worst().is_nan(),
            "{load:?}"
        );
    }
}

#[test]
fn each_unusable_input_has_its_own_refusal() {
    let grid = Grid::square(8, 1.0).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let heights = Array2::from_shape_fn((8, 8), |(i, j)| ((3 * i + 5 * j) % 8) as f64);
    assert!(matches!(Contact::new(&body, &grid, &Array2::zeros((8, 8))), Err(Refusal::Flat)));
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    let refusal = |load: Load, solver: Solver, tolerance: f64| match contact
        .press(load)
        .solver(solver)
        .tolerance(tolerance)
        .solve()
    {
        Err(SolveError::Refused(refusal)) => refusal,
        other => panic!("{load:?} {solver} {tolerance}: {other:?}"),
    };
    let load = Load::MeanPressure(0.1);
    assert!(matches!(refusal(load, Solver::Auto, f64::NAN), Refusal::Tolerance(_)));
    assert!(matches!(refusal(Load::MeanPressure(f64::NAN), Solver::Auto, 1e-8), Refusal::MeanPressure { .. }));
    assert!(matches!(refusal(Load::Approach(0.0), Solver::Auto, 1e-8), Refusal::Approach { .. }));
    assert!(matches!(refusal(Load::Approach(4.0), Solver::Auto, 1e-8), Refusal::Approach { limit: Some(_), .. }));
    assert!(matches!(refusal(load, Solver::Newton, 1e-8), Refusal::Solver { found: Solver::Newton, .. }));
    // No time step is valid for such a soft mode: the error is in the parameters of the method, not in the start.
    assert!(matches!(refusal(Load::MeanPressure(1e-60), Solver::Verlet, 1e-8), Refusal::Search(_)));
    assert!(matches!(refusal(Load::MeanPressure(5e-324), Solver::Verlet, 1e-8), Refusal::UnitOutOfRange { .. }));
    let coarse = Grid::square(4, 1.0).unwrap();
    let small = Contact::new(&body, &coarse, &heights.slice(ndarray::s![..4, ..4])).unwrap();
    let start = small.press(load).solve().unwrap();
    let other = contact.press(load).starting_from(Some(&start)).solve();
    assert!(matches!(other, Err(SolveError::Refused(Refusal::Start { found: 16, expected: 64 }))));
}
