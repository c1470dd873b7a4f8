//! Fields that are not numbers are certified by nobody.

use gfmd_contact::{Contact, Load};
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
