//! The solution does not depend on the start of the search.

use approx::assert_relative_eq;
use gfmd_contact::{Contact, Equilibrium, Load, Solution};
use gfmd_field::Grid;
use gfmd_measure::{Boundary, contact_area};
use gfmd_surface::{Discretisation, SelfAffine};
use gfmd_tests::unit_half_space;

#[test]
fn a_higher_load_started_from_a_lower_one_is_the_same_contact() {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 16.0, eps_c_inv: 4.0 };
    let grid = Grid::square(numbers.points().unwrap(), 1.0).unwrap();
    let heights = numbers
        .self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) })
        .heights(&grid, 11)
        .unwrap();
    let contact = Contact::new(&unit_half_space(), &grid, &heights).unwrap();
    let solve = |p: f64, start: Option<&Solution>| {
        contact.press(Load::MeanPressure(p)).tolerance(1e-12).starting_from(start).solve().unwrap()
    };
    let low = solve(0.002, None);
    let [warm, cold] = [solve(0.01, Some(&low)), solve(0.01, None)];
    let area = |solution: &Solution| contact_area(solution.pressure.view(), Boundary::Periodic);
    assert_eq!(area(&warm), area(&cold));
    assert_relative_eq!(warm.approach, cold.approach, max_relative = 1e-10);
}
