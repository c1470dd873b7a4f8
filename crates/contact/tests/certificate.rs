//! Fields that are not numbers are certified by nobody.

use gfmd_contact::{Contact, Control};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::NormalResponse;
use ndarray::Array2;

#[test]
fn a_pressure_that_is_not_a_number_has_a_residual_that_is_none() {
    let grid = Grid::square(8, 1.0).unwrap();
    let response = NormalResponse::new(grid, &Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap()));
    let heights = Array2::from_shape_fn((8, 8), |(i, j)| ((3 * i + 5 * j) % 8) as f64);
    let contact = Contact::new(&response, heights.view()).unwrap();
    for control in [Control::Approach(0.5), Control::MeanPressure(0.5)] {
        let mut pressure = vec![0.5; 64];
        pressure[17] = f64::NAN;
        assert!(contact.certify(pressure, control).unwrap().residual.worst().is_nan(), "{control:?}");
        assert!(contact.certify(vec![f64::NAN; 64], control).unwrap().residual.worst().is_nan(), "{control:?}");
    }
}
