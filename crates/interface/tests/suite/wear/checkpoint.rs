//! Saved and restored states continue bit for bit; states built from their fields are equal.

use gfmd_contact::{Boundary, Drive, Equilibrium as _, Fields as _, Load, MemoryCheckpoint, Resumable as _};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::QuasistaticState;

use super::on;
use crate::{material, rough};

#[test]
fn a_restored_state_goes_on_bit_for_bit() {
    let grid = Grid::new([12, 10], [1.0, 0.9]).unwrap();
    for (boundary, load) in [
        (Boundary::Periodic, Load::MeanPressure(0.02)),
        (Boundary::Free, Load::MeanPressure(0.02)),
        (Boundary::Periodic, Load::Approach(0.02)),
    ] {
        let contact = on(boundary, &Body::half_space(material(0.3)), &grid, &rough(&grid, 8), 0.2);
        let drives = [0.2, 0.5, 3.0].map(|distance| Drive::from(load).after(distance));
        let first = contact.press(drives[0]).solve().unwrap();
        let mut second = contact.press(drives[1]).starting_from(Some(&first)).solve().unwrap();
        let third = contact.press(drives[2]).starting_from(Some(&second)).solve().unwrap();
        let mut checkpoint = MemoryCheckpoint::default();
        contact.keep(&mut second, &mut checkpoint);
        checkpoint.rewind();
        let again = contact.restore(drives[1], &mut checkpoint).unwrap();
        let numbers = |state: &QuasistaticState| {
            [
                state.elastic_energy(),
                state.losses.total(),
                state.work_imbalance,
                state.wear_volume_and_depth().unwrap().0,
                state.worst(),
            ]
        };
        assert_eq!((again.gap(), numbers(&again)), (second.gap(), numbers(&second)));
        let other = contact.press(drives[2]).starting_from(Some(&again)).solve().unwrap();
        assert_eq!((other.pressure(), other.wear_depth()), (third.pressure(), third.wear_depth()));
        assert_eq!(numbers(&other), numbers(&third));
        let made = contact.certify(&[&third.pressure(), third.wear_depth().unwrap()], drives[2]).unwrap();
        assert_eq!((made.gap(), made.wear_volume_and_depth()), (third.gap(), third.wear_volume_and_depth()));
    }
}
