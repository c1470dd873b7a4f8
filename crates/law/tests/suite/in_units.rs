//! Laws in other units.

use gfmd_law::{InUnits, Law as _, LawKind, Parameter};

/// Converting the units of a law or of its parameters gives the same function.
#[test]
fn units_of_the_law_and_of_its_parameters_agree_to_the_bit() {
    let (stress, length) = (2.0_f64.powi(80), 2.0_f64.powi(-60));
    for kind in LawKind::ALL.into_iter().filter(|kind| *kind != LawKind::Table) {
        let in_unit = |p: &Parameter| match p.units {
            "stress*length" => stress * length,
            "length" => length,
            "stress/length" => stress / length,
            _ => 1.0,
        };
        let values = |scale: bool| -> Vec<(&'static str, f64)> {
            let one =
                |(k, p): (usize, &Parameter)| (p.name, (0.5 + 0.25 * k as f64) * if scale { in_unit(p) } else { 1.0 });
            kind.parameters().iter().enumerate().map(one).collect()
        };
        let plain = kind.with(&values(false)).unwrap();
        let scaled = InUnits::new(kind.with(&values(true)).unwrap().into_shared(), stress, length);
        for (normal, sliding) in [(0.0, 0.0), (0.3, 0.2), (1.7, -0.4), (-0.2, 0.1)] {
            assert_eq!(scaled.response(normal, sliding), plain.response(normal, sliding), "{}", kind.name());
            assert_eq!(scaled.energy(normal, sliding), plain.energy(normal, sliding), "{}", kind.name());
            assert_eq!(scaled.opening_energy(normal), plain.opening_energy(normal), "{}", kind.name());
            assert_eq!(scaled.opening(normal), plain.opening(normal), "{}", kind.name());
            assert_eq!(scaled.stiffness_bound(normal), plain.stiffness_bound(normal), "{}", kind.name());
        }
        assert_eq!((scaled.steepness(), scaled.has_wall()), (plain.steepness(), plain.has_wall()));
        assert_eq!(scaled.mixed_mode(), plain.mixed_mode());
    }
}
