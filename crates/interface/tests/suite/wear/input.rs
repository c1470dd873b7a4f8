//! Invalid input is refused by name.

use gfmd_contact::{Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, QuasistaticContact, Wear};
use ndarray::Array2;

use super::{by_distance, wearing};
use crate::{material, rough};

#[test]
fn coefficients_out_of_range_are_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let (body, heights) = (Body::half_space(material(0.3)), rough(&grid, 1));
    let refused = |wear: Option<Wear>| {
        let parts = Parts { wear, ..Parts::new(&body, &grid, &heights) };
        QuasistaticContact::new(&parts).unwrap_err().to_string()
    };
    for found in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = format!("the wear coefficient is {found}; it must be positive and finite");
        assert_eq!(refused(by_distance(found)), message);
        assert_eq!(refused(Some(Wear { by_distance: 0.0, by_slip: found })), message);
    }
    let reported = refused(Some(Wear { by_distance: 0.1, by_slip: 0.1 }));
    assert_eq!(reported, "the surfaces wear by their slip; there must be friction, without which slip is not known");
}

#[test]
fn distances_and_loads_are_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let contact = wearing(&Body::half_space(material(0.3)), &grid, &rough(&grid, 1), 0.1);
    let load = Drive::from(Load::MeanPressure(0.01));
    let refused = |drive: Drive, start| contact.press(drive).starting_from(start).solve().unwrap_err().to_string();
    assert_eq!(
        refused(load.after(-1.0), None),
        "the distance is -1; it must be at least 0, the distance of the state before"
    );
    assert_eq!(refused(load.after(f64::NAN), None), "the distance is NaN; it must be finite");
    let state = contact.press(load.after(2.0)).solve().unwrap();
    let back = refused(load.after(1.0), Some(&state));
    assert_eq!(back, "the distance is 1; it must be at least 2, the distance of the state before");
    assert_eq!(
        refused(Load::MeanPressure(-0.1).into(), None),
        "the mean pressure is -0.1; it must be positive and finite"
    );
    let deep = contact.surface().mean_clearance();
    // At distance 0 wear makes no room.
    assert!(refused(Load::Approach(deep).into(), None).contains("less than the mean clearance"));
    let other = Array2::zeros((4, 4));
    assert!(contact.certify(&[&other, &other], load).is_err());
}
