//! Tests of plates pressed on both faces.

use crate::support::*;
use gfmd_green::{Base, Body, GreenError, Layer, Plate};
use proptest::prelude::*;

proptest! {
    /// The matrix L of both faces, without the lateral displacements, is the inverse of the compliance.
    #[test]
    fn compliance_and_layer_matrix_are_inverse(
        material in material(), height in decades(0.3, 3.0), q in decades(1.0, 10.0),
    ) {
        let plate = Plate::of(&Body::slab(material, height).unwrap()).unwrap();
        let found = plate.compliance(q);
        prop_assert_eq!(found.mixed, 0.0);
        let l = Layer::new(material, height).unwrap();
        let (tt, bb, tb) = (l.top_blocks(q), l.bottom_blocks(q), l.cross_blocks(q));
        // Equal pressures p: t_z = -p above and p below, u_z = -d above and d below; lateral displacements are equal by
        // symmetry. Opposite pressures: u_z = -d on both, and lateral displacements are opposite.
        for (sign, compliance) in [(1.0, found.squeezing), (-1.0, found.bending)] {
            let lateral = tt.longitudinal + sign * tb.longitudinal;
            let normal = tt.normal - sign * tb.normal;
            let coupling = tt.coupling[0] - sign * tb.coupling[0];
            let stiffness = normal - coupling * (coupling / lateral);
            prop_assert!(apart(stiffness * compliance, 1.0, 1.0) < 1e-10, "{} {}", sign, stiffness * compliance);
        }
        prop_assert_eq!(bb.normal, tt.normal);
    }

    /// With no lateral displacement the matrix L of both faces is the inverse of the compliance as it is.
    #[test]
    fn held_faces_have_the_normal_entries_of_the_layer_matrix(
        material in material(), height in decades(0.3, 3.0), q in decades(1.0, 10.0),
    ) {
        let plate = Plate::held_sideways(&Body::slab(material, height).unwrap()).unwrap();
        let found = plate.compliance(q);
        prop_assert_eq!(found.mixed, 0.0);
        let l = Layer::new(material, height).unwrap();
        let (tt, tb) = (l.top_blocks(q), l.cross_blocks(q));
        for (sign, compliance) in [(1.0, found.squeezing), (-1.0, found.bending)] {
            let stiffness = tt.normal - sign * tb.normal;
            prop_assert!(apart(stiffness * compliance, 1.0, 1.0) < 1e-10, "{} {}", sign, stiffness * compliance);
        }
    }

    /// Layers cut in two equal one layer if the faces are held, too, and lie either way round.
    #[test]
    fn held_layers_in_two_parts_are_one_layer(
        a in material(), b in material(), height in decades(0.1, 3.0), part in 0.1..0.9, q in decades(0.5, 20.0),
    ) {
        let whole = Plate::held_sideways(&Body::slab(a, height).unwrap()).unwrap().compliance(q);
        let layers = [(a, part * height), (a, (1.0 - part) * height)];
        let cut = Plate::held_sideways(&Body::stack(&layers, Base::BONDED).unwrap()).unwrap().compliance(q);
        for (cut, whole_of) in [(cut.bending, whole.bending), (cut.squeezing, whole.squeezing), (cut.mixed, 0.0)] {
            prop_assert!(apart(cut, whole_of, whole.bending) < 1e-11, "{} {}", cut, whole_of);
        }
        let plate = Plate::held_sideways(&Body::stack(&[(a, height), (b, 0.5)], Base::SLIDING).unwrap()).unwrap();
        let (up, down) = (plate.compliance(q), plate.turned().compliance(q));
        prop_assert!(apart(up.squeezing, down.squeezing, up.bending) < 1e-11);
        prop_assert!(apart(up.bending, down.bending, up.bending) < 1e-11);
        prop_assert!(apart(up.mixed, -down.mixed, up.bending) < 1e-11);
        prop_assert!(up.squeezing * up.bending > up.mixed * up.mixed);
        // Less compliant than with free lateral displacement.
        let loose = Plate::of(&Body::stack(&[(a, height), (b, 0.5)], Base::SLIDING).unwrap()).unwrap().compliance(q);
        let face = |found: gfmd_green::PlateCompliance| 0.5 * (found.squeezing + found.bending) + found.mixed;
        prop_assert!(face(up) <= face(loose) * (1.0 + 1e-11));
    }

    /// A layer cut in two equals one layer, with errors relative to the bending compliance.
    #[test]
    fn a_layer_in_two_parts_is_one_layer(
        material in material(), height in decades(0.1, 3.0), part in 0.1..0.9, q in decades(0.5, 20.0),
    ) {
        let whole = Plate::of(&Body::slab(material, height).unwrap()).unwrap().compliance(q);
        let layers = [(material, part * height), (material, (1.0 - part) * height)];
        let cut = Plate::of(&Body::stack(&layers, Base::BONDED).unwrap()).unwrap().compliance(q);
        prop_assert!(apart(cut.bending, whole.bending, whole.bending) < 1e-11);
        prop_assert!(apart(cut.squeezing, whole.squeezing, whole.bending) < 1e-11);
        prop_assert!(apart(cut.mixed, 0.0, whole.bending) < 1e-11);
    }

    #[test]
    fn a_plate_upside_down_has_the_other_face_above(
        a in material(), b in material(), h in 0.1..1.0, q in decades(1.0, 30.0),
    ) {
        let body = Body::stack(&[(a, h), (b, 0.5)], Base::SLIDING).unwrap();
        let plate = Plate::of(&body).unwrap();
        let (up, down) = (plate.compliance(q), plate.turned().compliance(q));
        prop_assert!(apart(up.squeezing, down.squeezing, up.bending) < 1e-11);
        prop_assert!(apart(up.bending, down.bending, up.bending) < 1e-11);
        prop_assert!(apart(up.mixed, -down.mixed, up.bending) < 1e-11);
        // Each face alone behaves like a plate with the other face free, and energies are positive.
        let face = |mixed: f64| 0.5 * (up.squeezing + up.bending) + mixed;
        let free = body.on(Base::FREE);
        prop_assert!(free.is_ok() && face(up.mixed) > 0.0 && up.squeezing * up.bending > up.mixed * up.mixed);
    }
}

#[test]
fn the_uniform_wave_compresses_and_long_waves_bend() {
    let material = gfmd_green::Material::from_young(2.0, 0.25).unwrap();
    let plate = Plate::of(&Body::slab(material, 0.4).unwrap()).unwrap();
    let uniform = plate.compliance(0.0);
    let p_wave = 2.0 * 0.75 / (1.25 * 0.5);
    approx::assert_relative_eq!(uniform.squeezing, 0.2 / p_wave, max_relative = 1e-14);
    assert!(uniform.bending.is_infinite() && uniform.mixed == 0.0);
    // The bending stiffness of a plate is E*/12 d^3 q^4; opposite pressures on the two faces add up to twice the load.
    let q = 1e-3;
    let bending = 24.0 / (plate.contact_modulus() * 0.4_f64.powi(3) * q * q * q * q);
    approx::assert_relative_eq!(plate.compliance(q).bending, bending, max_relative = 1e-6);
    approx::assert_relative_eq!(plate.compliance(q).squeezing, 0.2 / plate.contact_modulus(), max_relative = 1e-6);
    // Short waves do not reach the other face.
    let short = plate.compliance(100.0);
    approx::assert_relative_eq!(short.bending, short.squeezing, max_relative = 1e-12);
}

#[test]
fn long_waves_shear_a_plate_that_is_held_sideways() {
    let material = gfmd_green::Material::from_young(2.0, 0.25).unwrap();
    let plate = Plate::held_sideways(&Body::slab(material, 0.4).unwrap()).unwrap();
    let (shear, p_wave) = (2.0 / 2.5, 2.0 * 0.75 / (1.25 * 0.5));
    approx::assert_relative_eq!(plate.compliance(0.0).squeezing, 0.2 / p_wave, max_relative = 1e-14);
    // No lateral strain: uniform compression, and shear by the slope; the load on both faces is twice the pressure.
    let q = 1e-3;
    approx::assert_relative_eq!(plate.compliance(q).squeezing, 0.2 / p_wave, max_relative = 1e-6);
    approx::assert_relative_eq!(plate.compliance(q).bending, 2.0 / (shear * 0.4 * q * q), max_relative = 1e-6);
    // Short waves are half-spaces that are held sideways.
    let held = Body::half_space(material).restricted_normal_stiffness(100.0);
    let short = plate.compliance(100.0);
    approx::assert_relative_eq!(short.bending * held, 1.0, max_relative = 1e-12);
    approx::assert_relative_eq!(short.squeezing * held, 1.0, max_relative = 1e-12);
}

#[test]
fn half_spaces_and_pairs_are_refused() {
    let material = gfmd_green::Material::from_young(1.0, 0.3).unwrap();
    let (slab, half_space) = (Body::slab(material, 1.0).unwrap(), Body::half_space(material));
    for body in [half_space.clone(), slab.clone().bonded_to(half_space.clone()).unwrap(), slab.against(half_space)] {
        assert!(matches!(Plate::of(&body), Err(GreenError::Plate(_))), "{body:?}");
        assert!(matches!(Plate::held_sideways(&body), Err(GreenError::Plate(_))), "{body:?}");
    }
}
