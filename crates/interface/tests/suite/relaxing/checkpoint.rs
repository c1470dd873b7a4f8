//! States that are saved and restored continue bit for bit.

use gfmd_contact::{Drive, Equilibrium as _, Fields as _, Load, MemoryCheckpoint, Resumable as _};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_medium::Relaxes;

use super::{relaxing, three};
use crate::{material, rough};

#[test]
fn a_restored_state_goes_on_bit_for_bit() {
    let grid = Grid::new([12, 10], [1.0, 0.9]).unwrap();
    let heights = rough(&grid, 8);
    let slab = Body::slab(material(0.3), 0.4).unwrap();
    for (body, relaxes) in [(Body::half_space(material(0.3)), Relaxes::Both), (slab, Relaxes::Shear)] {
        let contact = relaxing(&body, &grid, &heights, &three(), relaxes);
        let drives = [0.2, 0.5, 3.0].map(|time| Drive::from(Load::MeanPressure(0.02 + 0.001 * time)).at(time));
        let first = contact.press(drives[0]).solve().unwrap();
        let mut second = contact.press(drives[1]).starting_from(Some(&first)).solve().unwrap();
        let third = contact.press(drives[2]).starting_from(Some(&second)).solve().unwrap();
        let mut checkpoint = MemoryCheckpoint::default();
        contact.keep(&mut second, &mut checkpoint);
        checkpoint.rewind();
        let again = contact.restore(drives[1], &mut checkpoint).unwrap();
        assert_eq!(again.pressure(), second.pressure());
        let other = contact.press(drives[2]).starting_from(Some(&again)).solve().unwrap();
        assert_eq!(other.pressure(), third.pressure());
        assert_eq!(other.gap(), third.gap());
        assert_eq!([other.elastic_energy(), other.losses.total()], [third.elastic_energy(), third.losses.total()]);
        assert_eq!(other.memory(), third.memory());
    }
}
