//! Tests of relations at the surface of every body.

use crate::support::*;
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Ground, Material};
use num_complex::Complex64;
use proptest::prelude::*;

proptest! {
    #[test]
    fn stiffness_is_hermitian_and_positive_definite(body in body(), q in decades(1e-8, 1e6)) {
        let k = body.stiffness_blocks(q);
        prop_assert_eq!(k.coupling[0], -k.coupling[1]);
        prop_assert!(k.longitudinal > 0.0 && k.normal > 0.0 && k.transverse > 0.0, "{:?}", k);
        // A thin incompressible slab on a sliding base is nearly singular; its compliance is tested instead.
        prop_assert!(k.coupling[0] * (k.coupling[0] / k.longitudinal) <= k.normal * (1.0 + 1e-15), "{:?}", k);
        let g = body.compliance_blocks(q);
        prop_assert!(g.longitudinal > 0.0 && g.normal > 0.0 && g.transverse > 0.0, "{:?}", g);
        prop_assert_eq!(g.coupling[0], -g.coupling[1]);
        for entry in [k.longitudinal, k.normal, k.transverse, k.coupling[0]] {
            prop_assert!(entry.is_finite());
        }
    }

    #[test]
    fn compliance_is_the_inverse(body in body(), q in decades(1e-6, 1e6)) {
        let (k, g) = (body.plane_stiffness(q), body.plane_compliance(q));
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let terms = (0..2).map(|j| k[row][j] * g[j][column]);
            // Largest possible terms, since both matrices are positive definite.
            let sizes = (0..2).map(|j| {
                (k[row][row].re.sqrt() * k[j][j].re.sqrt()) * (g[j][j].re.sqrt() * g[column][column].re.sqrt())
            });
            let (error, size) = (terms.sum::<Complex64>() - f64::from(u8::from(row == column)), sizes.sum::<f64>());
            prop_assert!(error.norm() <= 1e-13 * size, "{row} {column}: {error} of {size:e}");
        }
        let transverse = body.stiffness_blocks(q).transverse * body.compliance_blocks(q).transverse;
        prop_assert!(apart(transverse, 1.0, 1.0) < 1e-14);
    }

    #[test]
    fn both_matrices_have_the_same_axes(body in body(), q in wavevector(decades(0.3, 30.0))) {
        let one = product(&body.stiffness(q), &body.compliance(q));
        let identity = std::array::from_fn(|i| std::array::from_fn(|j| Complex64::from(f64::from(u8::from(i == j)))));
        let size = largest(&body.stiffness(q)) * largest(&body.compliance(q));
        prop_assert!(matrices_apart(&identity, &one) < 1e-13 * size.max(1.0));
    }

    #[test]
    fn scalars_are_entries_of_the_matrices(body in body(), q in decades(1e-6, 1e6)) {
        let (k, g) = (body.stiffness_blocks(q), body.compliance_blocks(q));
        prop_assert!(apart(body.normal_compliance(q), g.normal, g.normal) < 1e-14);
        prop_assert!(apart(body.normal_stiffness(q) * g.normal, 1.0, 1.0) < 1e-14);
        prop_assert_eq!(body.restricted_normal_stiffness(q), k.normal);
        // Without shear traction, u_long = G_long,z t_z and u_z = G_zz t_z: the ratio is −i ρ.
        let ratio = g.coupling[0] / g.normal;
        let scale = (g.longitudinal / g.normal).sqrt();
        prop_assert!(apart(ratio, -body.lateral_ratio(q), scale) < 1e-13);
    }

    #[test]
    fn waves_either_way_are_conjugate(body in body(), q in wavevector(decades(1e-3, 1e3))) {
        let back = q.map(|component| -component);
        let conjugate = body.stiffness(q).map(|row| row.map(|entry| entry.conj()));
        prop_assert_eq!(body.stiffness(back), conjugate);
        let opposite = body.plane_stiffness(q[0].abs()).map(|row| row.map(|e| e.conj()));
        prop_assert_eq!(body.plane_stiffness(-q[0].abs()), opposite);
    }

    #[test]
    fn rotating_the_wave_rotates_the_matrix(
        body in body(), q in wavevector(decades(1e-3, 1e3)), angle in 0.0..std::f64::consts::TAU,
    ) {
        let (c, s) = (angle.cos(), angle.sin());
        let rotation = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]].map(|row| row.map(|e| Complex64::new(e, 0.0)));
        let back = std::array::from_fn(|row| std::array::from_fn(|column| rotation[column][row]));
        let turned = [c * q[0] - s * q[1], s * q[0] + c * q[1]];
        let wanted = product(&product(&rotation, &body.stiffness(q)), &back);
        prop_assert!(matrices_apart(&body.stiffness(turned), &wanted) < 1e-13);
    }

    #[test]
    fn a_wave_along_x_is_plane_strain(
        body in body(), q in decades(1e-3, 1e3), sign in prop_oneof![Just(1.0), Just(-1.0)],
    ) {
        let (space, plane) = (body.stiffness([sign * q, 0.0]), body.plane_stiffness(sign * q));
        prop_assert_eq!([[space[0][0], space[0][2]], [space[2][0], space[2][2]]], plane);
        let (space, plane) = (body.compliance([sign * q, 0.0]), body.plane_compliance(sign * q));
        prop_assert_eq!([[space[0][0], space[0][2]], [space[2][0], space[2][2]]], plane);
    }

    /// The stiffness 1/G_zz exceeds E* q/2 by 4 r h² e^(−2h) (1 + 1/h + …).
    #[test]
    fn a_deep_slab_approaches_the_half_space(material in material(), h in 6.0..12.0f64) {
        let (slab, half_space) = (Body::slab(material, 2.0).unwrap(), Body::half_space(material));
        let q = h / 2.0;
        let excess = slab.normal_stiffness(q) / half_space.normal_stiffness(q) - 1.0;
        let leading = 4.0 * material.r() * h * h * (-2.0 * h).exp();
        prop_assert!((excess / leading - 1.0 - 1.0 / h).abs() < 4.0 / (material.r() * h * h), "{}", excess / leading);
        for far in [40.0, 1e3, 1e6, 1e300] {
            prop_assert!(blocks_apart(&slab.stiffness_blocks(far), &half_space.stiffness_blocks(far)) < 1e-14);
            prop_assert!(blocks_apart(&slab.compliance_blocks(far), &half_space.compliance_blocks(far)) < 1e-14);
        }
    }

    /// Energy minimisation: a body with more constraints is stiffer, and a slab is a constrained half-space.
    #[test]
    fn bodies_are_ordered_by_what_holds_them(material in material(), h in decades(0.05, 10.0), thinner in 0.3..0.99) {
        let slab = Body::slab(material, h).unwrap();
        let on = |base: Base| slab.clone().on(base).unwrap().stiffness_blocks(1.0);
        let bonded = slab.stiffness_blocks(1.0);
        let half_space = Body::half_space(material).stiffness_blocks(1.0);
        prop_assert!(dominates(&Body::slab(material, h * thinner).unwrap().stiffness_blocks(1.0), &bonded));
        prop_assert!(dominates(&bonded, &on(Base::SLIDING)));
        prop_assert!(dominates(&on(Base::SLIDING), &on(Base::FREE)));
        let guided = on(Base::Rigid(Ground::GUIDED));
        prop_assert!(dominates(&bonded, &guided) && dominates(&guided, &on(Base::FREE)));
        prop_assert!(dominates(&bonded, &half_space));
        prop_assert!(dominates(&half_space, &on(Base::FREE)));
        let stiff = Material::from_young(10.0 * material.young(), material.poisson()).unwrap();
        let coated = slab.clone().bonded_to(Body::half_space(stiff)).unwrap().stiffness_blocks(1.0);
        prop_assert!(dominates(&bonded, &coated) && dominates(&coated, &half_space));
    }

    /// The formulas for thin and thick layers agree at q·height = 1.
    #[test]
    fn nothing_jumps_where_the_formulas_change(material in material(), below in material()) {
        let slab = Body::slab(material, 1.0).unwrap();
        let substrate = Base::Elastic(Box::new(Body::half_space(below)));
        for base in GROUNDS.map(Base::Rigid).into_iter().chain([substrate]) {
            let body = slab.clone().on(base).unwrap();
            let (thin, thick) = (1f64.next_down(), 1.0);
            prop_assert!(blocks_apart(&body.stiffness_blocks(thin), &body.stiffness_blocks(thick)) < 1e-13);
            prop_assert!(blocks_apart(&body.compliance_blocks(thin), &body.compliance_blocks(thick)) < 1e-13);
        }
    }

    /// The aliases +q_N and −q_N of a Nyquist mode are one mode; its matrix is their mean.
    #[test]
    fn nyquist_modes_average_their_aliases(body in body(), nx in 1usize..7, ny in 1usize..7, length in 0.2..5.0) {
        let grid = Grid::new([nx, ny], [length, 1.3]).unwrap();
        for mode in grid.modes().filter(|mode| !mode.is_uniform()) {
            let (k, g) = (body.stiffness_of(&mode), body.compliance_of(&mode));
            let mut mean = [[Complex64::ZERO; 3]; 3];
            for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let alias = [0, 1].map(|axis| {
                    if mode.nyquist[axis] { signs[axis] * mode.wavevector[axis] } else { mode.wavevector[axis] }
                });
                for (row, of_alias) in mean.iter_mut().zip(body.stiffness(alias)) {
                    row.iter_mut().zip(of_alias).for_each(|(mean, entry)| *mean += 0.25 * entry);
                }
            }
            prop_assert!(matrices_apart(&k, &mean) < 1e-14);
            let one = product(&k, &g);
            for (i, row) in one.iter().enumerate() {
                let error = row.iter().enumerate().map(|(j, e)| (e - f64::from(u8::from(i == j))).norm());
                prop_assert!(error.fold(0.0, f64::max) < 1e-9 * largest(&k) * largest(&g));
            }
            // A pressure without friction moves the surface sideways by −i ρ u_z along the wave, but not along Nyquist.
            let factors = body.lateral_displacement(&mode);
            let along = body.compliance(mode.wavevector);
            for axis in [0, 1] {
                let wanted = if mode.nyquist[axis] { Complex64::ZERO } else { along[axis][2] / along[2][2] };
                let scale = 1.0 + (along[axis][axis].re / along[2][2].re).sqrt();
                prop_assert!((factors[axis] - wanted).norm() < 1e-12 * scale);
            }
            if mode.is_self_conjugate() {
                prop_assert!(k.iter().flatten().chain(g.iter().flatten()).all(|entry| entry.im == 0.0));
                prop_assert!(body.lateral_displacement(&mode) == [Complex64::ZERO; 2]);
            }
        }
    }
}

/// Leading terms of theory.md, sections 1 and 3, far below the smallest wavenumber of any grid.
#[test]
fn thin_slabs_have_the_stiffness_of_their_series() {
    for h in [1e-8, 1e-6, 1e-4] {
        for poisson in [-0.5, 0.0, 0.3, 0.45] {
            let material = Material::from_young(1.0, poisson).unwrap();
            let (s, shear) = (material.s(), material.shear_modulus());
            let k = Body::slab(material, 1.0).unwrap().stiffness_blocks(h);
            let near = |found: f64, wanted: f64, next: f64| {
                assert!((found / wanted - 1.0).abs() < next + 1e-15, "{found} {wanted} at h = {h}, ν = {poisson}");
            };
            near(k.longitudinal / shear, 1.0 + (3.0 - s) * (1.0 + s) / (12.0 * s) * h * h, h.powi(4) / s.powi(2));
            near(
                k.normal / shear,
                1.0 / s + (1.0 + s) * (3.0 * s - 1.0) / (12.0 * s * s) * h * h,
                h.powi(4) / s.powi(3),
            );
            near(k.coupling[0] / shear, (3.0 * s - 1.0) / (2.0 * s) * h, h * h / s.powi(2));
            near(k.transverse / shear, 1.0 + h * h / 3.0, h.powi(4));
        }
        let material = Material::from_young(3.0, 0.5).unwrap();
        let rubber = Body::slab(material, 1.0).unwrap();
        let [plate, guided] =
            [Ground::NONE, Ground::GUIDED].map(|ground| rubber.clone().on(Base::Rigid(ground)).unwrap());
        assert!(apart(rubber.restricted_normal_stiffness(h) * h * h, 12.0, 12.0) < h * h + 1e-15);
        assert!(apart(rubber.normal_stiffness(h) * h * h, 3.0, 3.0) < 2.0 * h * h + 1e-15);
        assert!(apart(12.0 * plate.normal_stiffness(h), 4.0 * h.powi(4), 4.0 * h.powi(4)) < h * h + 1e-15);
        // It bends about its base: E* h³/3 in place of E* h³/12.
        assert!(apart(3.0 * guided.normal_stiffness(h), 4.0 * h.powi(4), 4.0 * h.powi(4)) < h * h + 1e-15);
    }
}

#[test]
fn the_uniform_mode_is_a_stack_of_springs() {
    let material = Material::from_young(2.6, 0.3).unwrap();
    let (shear, normal) = (material.shear_modulus(), material.p_wave_modulus().unwrap());
    let diagonal = |body: &Body| {
        let k = body.stiffness([0.0, 0.0]);
        assert!((0..3).all(|i| (0..3).all(|j| i == j || k[i][j] == Complex64::ZERO)));
        [0, 1, 2].map(|axis| k[axis][axis].re)
    };
    let close = |found: [f64; 3], wanted: [f64; 3]| {
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!(apart(found, wanted, wanted) < 1e-15, "{found} {wanted}");
        }
    };
    let slab = Body::slab(material, 0.5).unwrap();
    close(diagonal(&slab), [shear / 0.5, shear / 0.5, normal / 0.5]);
    close(diagonal(&slab.clone().on(Base::SLIDING).unwrap()), [0.0, 0.0, normal / 0.5]);
    close(diagonal(&slab.clone().on(Base::FREE).unwrap()), [0.0; 3]);
    close(diagonal(&slab.clone().on(Base::Rigid(Ground::GUIDED)).unwrap()), [shear / 0.5, shear / 0.5, 0.0]);
    close(diagonal(&Body::half_space(material)), [0.0; 3]);
    close(diagonal(&slab.clone().bonded_to(slab.clone()).unwrap()), [shear, shear, normal]);
    close(diagonal(&slab.clone().bonded_to(Body::half_space(material)).unwrap()), [0.0; 3]);
    assert_eq!(Body::half_space(material).normal_compliance(0.0), f64::INFINITY);
    assert_eq!((slab.lateral_ratio(0.0), Body::half_space(material).lateral_ratio(0.0)), (0.0, 0.0));
    let rubber = Body::slab(Material::from_young(1.0, 0.5).unwrap(), 0.5).unwrap();
    assert_eq!((rubber.normal_compliance(0.0), rubber.normal_stiffness(0.0)), (0.0, f64::INFINITY));
    for body in [&slab, &rubber, &Body::half_space(material)] {
        for m in [body.plane_stiffness(0.0), body.plane_compliance(0.0)] {
            assert_eq!((m[0][1], m[1][0]), (Complex64::ZERO, Complex64::ZERO));
        }
        assert_eq!(body.plane_stiffness(0.0)[1][1].re, body.normal_stiffness(0.0));
        assert_eq!(body.plane_compliance(0.0)[1][1].re, body.normal_compliance(0.0));
    }
    // A long wave is not the uniform mode: an incompressible slab can only be squeezed sideways.
    assert!(rubber.normal_compliance(1e-8) > 0.0);
}
