//! Invalid input is refused by name.

use gfmd_contact::{Contact, Drive, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_wear::WearContact;
use ndarray::Array2;

use crate::{material, rough, wearing};

fn elastic() -> Contact {
    let grid = Grid::square(8, 1.0).unwrap();
    Contact::new(&Body::half_space(material(0.3)), &grid, &rough(&grid, 1)).unwrap()
}

#[test]
fn coefficients_and_hardness_are_refused() {
    for found in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let reported = WearContact::new(elastic(), found).unwrap_err().to_string();
        assert_eq!(reported, format!("the wear coefficient is {found}; it must be positive and finite"));
    }
    let hard = elastic().with_hardness(1.0).unwrap();
    let reported = WearContact::new(hard, 1.0).unwrap_err().to_string();
    assert_eq!(reported, "a hardness is given; it must be left out with wear");
}

#[test]
fn distances_and_loads_are_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let contact = wearing(&Body::half_space(material(0.3)), &grid, &rough(&grid, 1), 0.1);
    let load = Drive::from(Load::MeanPressure(0.01));
    let refused = |drive: Drive, start| contact.press(drive).starting_from(start).solve().unwrap_err().to_string();
    assert_eq!(refused(load.after(-1.0), None), "the distance is -1; it must be at least 0, that of the state before");
    assert_eq!(refused(load.after(f64::NAN), None), "the distance is NaN; it must be finite");
    let state = contact.press(load.after(2.0)).solve().unwrap();
    let back = refused(load.after(1.0), Some(&state));
    assert_eq!(back, "the distance is 1; it must be at least 2, that of the state before");
    assert_eq!(
        refused(Load::MeanPressure(-0.1).into(), None),
        "the mean pressure is -0.1; it must be positive and finite"
    );
    assert!(refused(Load::Approach(-0.1).into(), None).starts_with("the approach is -0.1; it must be positive"));
    let deep = contact.contact().surface().mean_clearance();
    // At distance 0 wear makes no room.
    assert!(refused(Load::Approach(deep).into(), None).contains("less than the mean clearance"));
    let other = Array2::zeros((4, 4));
    assert!(contact.certify(&other, &other, load).is_err());
}
