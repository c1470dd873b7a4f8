//! Invalid input is refused with its name.

use gfmd_contact::{Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_medium::Relaxes;

use super::{follow, one, relaxing};
use crate::{legs, material, rough};

#[test]
fn times_that_run_backwards_are_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let contact = relaxing(&Body::half_space(material(0.3)), &grid, &rough(&grid, 1), &one(), Relaxes::Both);
    let load = Drive::from(Load::MeanPressure(0.01));
    let refused = |drive: Drive, start| contact.press(drive).starting_from(start).solve().unwrap_err().to_string();
    assert_eq!(refused(load.at(-1.0), None), "the time is -1; it must be at least 0, the time of the state before");
    assert_eq!(refused(load.at(f64::NAN), None), "the time is NaN; it must be finite");
    let state = contact.press(load.at(2.0)).solve().unwrap();
    assert_eq!(
        refused(load.at(1.0), Some(&state)),
        "the time is 1; it must be at least 2, the time of the state before"
    );
}

#[test]
fn surfaces_that_part_are_a_state_and_touch_again() {
    let grid = Grid::square(12, 1.0).unwrap();
    let body = Body::slab(material(0.3), 0.4).unwrap();
    let contact = relaxing(&body, &grid, &rough(&grid, 2), &one(), Relaxes::Both);
    let path = legs(&[0.03, 0.004, 0.004], &[3.0, 0.05, 50.0], 2, Load::Approach);
    let states = follow(&contact, &path, 1e-10);
    let nodes: Vec<u64> = states.iter().map(|state| state.summary().contact_nodes).collect();
    assert!(nodes[3] == 0, "{nodes:?}");
    assert!(states[3].worst() == 0.0, "{nodes:?}");
    assert!(nodes[5] > 0, "{nodes:?}");
    let apart = follow(&contact, &[(Load::Approach(-0.01), 1.0)], 1e-10);
    assert_eq!((apart[0].summary().contact_nodes, apart[0].elastic_energy()), (0, 0.0));
}
