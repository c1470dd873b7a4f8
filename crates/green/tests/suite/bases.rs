//! Tests of layers: two faces, stacks, and the resulting bases.

use crate::support::*;
use gfmd_green::{Base, BaseKind, Body, Ground, Layer, Material};
use num_complex::Complex64;
use proptest::prelude::*;

/// Returns a slab cut in two by a plane at `fraction` of its height.
fn cut(material: Material, height: f64, fraction: f64, base: Base) -> Body {
    let lower = Body::slab(material, height * (1.0 - fraction)).unwrap().on(base).unwrap();
    Body::slab(material, height * fraction).unwrap().bonded_to(lower).unwrap()
}

proptest! {
    #[test]
    fn a_layer_on_its_own_half_space_is_the_half_space(material in material(), h in decades(1e-9, 1e4)) {
        let half_space = Body::half_space(material);
        let coated = Body::slab(material, 0.7).unwrap().bonded_to(half_space.clone()).unwrap();
        let q = h / 0.7;
        prop_assert!(blocks_apart(&coated.stiffness_blocks(q), &half_space.stiffness_blocks(q)) < 2e-14);
        prop_assert!(blocks_apart(&coated.compliance_blocks(q), &half_space.compliance_blocks(q)) < 2e-14);
    }

    #[test]
    fn two_layers_of_one_material_are_one(material in material(), h in decades(1e-6, 1e4), fraction in 0.05..0.95) {
        for base in GROUNDS.map(Base::Rigid) {
            let whole = Body::slab(material, 1.0).unwrap().on(base.clone()).unwrap();
            let halves = cut(material, 1.0, fraction, base.clone());
            let error = blocks_apart(&whole.stiffness_blocks(h), &halves.stiffness_blocks(h));
            prop_assert!(error < 1e-12, "stiffness: {error:e} on {base:?}");
            let error = blocks_apart(&whole.compliance_blocks(h), &halves.compliance_blocks(h));
            prop_assert!(error < 1e-12, "compliance: {error:e} on {base:?}");
        }
    }

    /// A stack of many thin layers; the recursion propagates without division only up to a limit.
    #[test]
    fn a_hundred_thin_layers_are_one_slab(material in material(), h in decades(0.1, 90.0)) {
        for base in GROUNDS.map(Base::Rigid) {
            let whole = Body::slab(material, 1.0).unwrap().on(base.clone()).unwrap();
            let sheet = || Body::slab(material, 0.01).unwrap();
            let lowest = sheet().on(base.clone()).unwrap();
            let stack = (1..100).fold(lowest, |below, _| sheet().bonded_to(below).unwrap());
            let error = blocks_apart(&whole.stiffness_blocks(h), &stack.stiffness_blocks(h));
            prop_assert!(error < 1e-12, "stiffness: {error:e} on {base:?}");
            let error = blocks_apart(&whole.compliance_blocks(h), &stack.compliance_blocks(h));
            prop_assert!(error < 1e-12, "compliance: {error:e} on {base:?}");
            let q = [0.6 * h, -0.8 * h];
            let (a, b) = (whole.at_depth(0.015).unwrap(), stack.at_depth(0.015).unwrap());
            let scale = largest(&a.displacement_transfer(q)).max(1.0);
            prop_assert!(matrices_apart(&a.displacement_transfer(q), &b.displacement_transfer(q)) < 1e-12 * scale);
        }
    }

    /// A squeezed plate equals two slabs sliding on its mid-plane; a bent plate equals two slabs guided by it.
    #[test]
    fn the_modes_of_a_plate_are_those_of_its_halves(material in material(), h in decades(0.1, 1e3)) {
        let (layer, q) = (Layer::new(material, 2.0).unwrap(), h / 2.0);
        let (top, cross) = (layer.top_blocks(q), layer.cross_blocks(q));
        for (ground, sign) in [(Ground::SLIDING, 1.0), (Ground::GUIDED, -1.0)] {
            // L_tt ± L_tb J, J = diag(1, −1) on (long, z).
            let half = Body::slab(material, 1.0).unwrap().on(Base::Rigid(ground)).unwrap().stiffness_blocks(q);
            let scale = (top.longitudinal * top.normal).sqrt();
            let close = |top: f64, cross: f64, half: f64, scale: f64| apart(top + sign * cross, half, scale) < 1e-13;
            prop_assert!(close(top.longitudinal, cross.longitudinal, half.longitudinal, top.longitudinal));
            prop_assert!(close(top.normal, -cross.normal, half.normal, top.normal));
            prop_assert!(close(top.coupling[0], -cross.coupling[0], half.coupling[0], scale));
            prop_assert!(close(top.transverse, cross.transverse, half.transverse, top.transverse));
        }
    }

    #[test]
    fn the_matrix_of_a_layer_is_hermitian_and_turns_with_the_wave(
        material in material(), q in wavevector(decades(0.01, 100.0)),
    ) {
        let layer = Layer::new(material, 0.8).unwrap();
        let matrix = layer.matrix(q);
        for (i, row) in matrix.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                prop_assert_eq!(*entry, matrix[j][i].conj());
            }
        }
        let top: [[Complex64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[i][j]));
        prop_assert_eq!(top, Body::slab(material, 0.8).unwrap().stiffness(q));
        let along = layer.matrix([q[0].abs(), 0.0]);
        let plane = layer.plane_matrix(q[0].abs());
        for (i, row) in [0, 2, 3, 5].into_iter().enumerate() {
            for (j, column) in [0, 2, 3, 5].into_iter().enumerate() {
                prop_assert_eq!(along[row][column], plane[i][j]);
            }
        }
    }

    /// A prescribed base displacement in a layer between half-spaces of the same material: the wave passes unchanged.
    #[test]
    fn a_layer_agrees_with_the_field_of_a_half_space(material in material(), h in decades(0.02, 20.0)) {
        let layer = Layer::new(material, h).unwrap();
        let half_space = Body::half_space(material);
        let below = half_space.at_depth(h).unwrap();
        let bottom = below.plane_displacement_transfer(1.0);
        let traction = below.plane_stress_transfer(1.0);
        let matrix = layer.plane_matrix(1.0);
        let unit = |is_one: bool| Complex64::from(f64::from(u8::from(is_one)));
        let column = |c: usize| [unit(c == 0), unit(c == 1), bottom[0][c], bottom[1][c]];
        let surface = half_space.plane_stiffness(1.0);
        for c in 0..2 {
            let wanted = [surface[0][c], surface[1][c], -traction[2][c], -traction[1][c]];
            for (row, wanted) in matrix.iter().zip(wanted) {
                let terms = || row.iter().zip(column(c)).map(|(l, u)| l * u);
                let size: f64 = terms().map(|term| term.norm()).sum();
                prop_assert!((terms().sum::<Complex64>() - wanted).norm() < 1e-13 * size);
            }
        }
    }
}

proptest! {
    /// Two equal bodies face to face are twice as soft under pressure, and uncoupled. The order affects only the
    /// coupling.
    #[test]
    fn a_pair_is_the_sum_of_both(first in body(), second in body(), q in decades(1e-3, 1e3)) {
        let pair = first.clone().against(second.clone());
        let (a, b, g) = (first.compliance_blocks(q), second.compliance_blocks(q), pair.compliance_blocks(q));
        prop_assert_eq!(g.normal, a.normal + b.normal);
        prop_assert_eq!(g.coupling[0], a.coupling[0] - b.coupling[0]);
        prop_assert!(apart(pair.normal_compliance(q), g.normal, g.normal) < 1e-11);
        let (k, compliance) = (pair.stiffness([0.6 * q, 0.8 * q]), pair.compliance([0.6 * q, 0.8 * q]));
        for (i, row) in k.iter().enumerate() {
            for j in 0..3 {
                let terms = || row.iter().zip(&compliance).map(|(k, g)| k * g[j]);
                let (entry, size) = (terms().sum::<Complex64>(), terms().map(|term| term.norm()).sum::<f64>());
                let wanted = f64::from(u8::from(i == j));
                prop_assert!((entry - wanted).norm() < 1e-10 * size.max(1.0), "{entry}");
            }
        }
        let twin = first.clone().against(first.clone());
        prop_assert_eq!(twin.compliance_blocks(q).coupling[0], 0.0);
        let modulus = first.contact_modulus();
        prop_assert!(apart(twin.contact_modulus(), 0.5 * modulus, 1.0) < 1e-15 * modulus);
        prop_assert_eq!(pair.alone(), first);
        prop_assert_eq!(pair.second(), Some(&second));
    }
}

#[test]
fn layers_between_planes_add_up() {
    let material = |poisson| Material::from_young(1.0, poisson).unwrap();
    let layers = [(material(0.3), 0.2), (material(0.5), 0.1), (material(0.1), 0.4)];
    let stack = Body::stack(&layers, Base::FREE).unwrap();
    assert_eq!(stack.interfaces(), [0.2, 0.2 + 0.1]);
    assert_eq!(stack.total_height(), 0.2 + 0.1 + 0.4);
    assert!(stack.at_depth(stack.total_height()).is_ok());
    let [lateral, normal] = stack.level_compliance();
    let sum = |of: fn(&Material) -> f64| layers.iter().map(|(m, h)| h * of(m)).sum::<f64>();
    assert!(apart(lateral, sum(|m| 1.0 / m.shear_modulus()), lateral) < 1e-15);
    assert!(apart(normal, sum(Material::p_wave_compliance), normal) < 1e-15);
    let section = stack.at_depth(0.2).unwrap();
    assert_eq!((section.material(), section.clone().from_below().material()), (&layers[0].0, &layers[1].0));
    let inside = stack.at_depth(0.25).unwrap();
    assert_eq!((inside.material(), inside.clone().from_below().material()), (&layers[1].0, &layers[1].0));
    assert_eq!(Body::half_space(material(0.3)).level_compliance(), [0.0; 2]);
    for kind in BaseKind::ALL {
        assert_eq!(kind.name().parse(), Ok(kind));
        assert_eq!(kind.with(None).is_ok(), kind != BaseKind::HalfSpace);
        assert_eq!(kind.with(Some(material(0.3))).is_ok(), kind == BaseKind::HalfSpace);
    }
    assert_eq!(
        "loose".parse::<BaseKind>().unwrap_err().to_string(),
        "the base is loose; it must be one of bonded, sliding, free, half-space"
    );
    assert!(Body::stack(&[], Base::FREE).is_err());
    let pair = stack.clone().against(stack.clone());
    assert!(Body::slab(material(0.3), 1.0).unwrap().bonded_to(pair).is_err());
}

#[test]
fn rigid_translations_of_a_layer_cost_nothing() {
    let layer = Layer::new(Material::from_young(1.0, 0.3).unwrap(), 0.5).unwrap();
    let matrix = layer.matrix([0.0, 0.0]);
    for (axis, row) in matrix.iter().enumerate() {
        assert!(row[axis].re > 0.0);
        assert_eq!(row.iter().sum::<Complex64>(), Complex64::ZERO);
    }
}

#[test]
fn what_cannot_be_is_refused_with_what_was_found() {
    let material = Material::from_young(1.0, 0.3).unwrap();
    for height in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = Body::slab(material, height).unwrap_err().to_string();
        assert_eq!(message, format!("the height of the slab is {height}; it must be positive and finite"));
        assert_eq!(Layer::new(material, height).unwrap_err().to_string(), message);
    }
    let message = Body::half_space(material).on(Base::FREE).unwrap_err().to_string();
    assert_eq!(message, "the body is a half-space; a base needs a slab of finite height");

    let slab = Body::slab(material, 2.0).unwrap();
    for height in [-0.1, 2.1, f64::NAN] {
        let message = slab.at_height(height).unwrap_err().to_string();
        assert_eq!(message, format!("the height above the base is {height}; it must be between 0 and 2"));
        let message = slab.at_depth(height).unwrap_err().to_string();
        assert_eq!(message, format!("the depth below the surface is {height}; it must be between 0 and 2"));
    }
    let message = Body::half_space(material).at_height(1.0).unwrap_err().to_string();
    assert!(message.starts_with("the height above the base is 1, but a half-space has no base"), "{message}");
    assert!(Body::half_space(material).at_depth(f64::INFINITY).is_err());
    let stack = slab.clone().bonded_to(slab).unwrap();
    assert!(stack.at_depth(3.9).is_ok() && stack.at_depth(4.1).is_err());
}
