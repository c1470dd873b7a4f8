//! Tests of relations inside every body: equilibrium, Hooke's law, the base, energy.

use crate::support::*;
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Condition, Ground, Material, Section, StressMatrix3};
use num_complex::Complex64;
use proptest::prelude::*;

const I: Complex64 = Complex64::I;

/// Returns the z derivative of every entry of a matrix, by a fourth-order difference over 4 `step`.
fn slope<const M: usize>(
    body: &Body,
    depth: f64,
    step: f64,
    matrix: impl Fn(&Section) -> [[Complex64; 3]; M],
) -> [[Complex64; 3]; M] {
    let at = |steps: f64| matrix(&body.at_depth(depth - steps * step).unwrap());
    let (far_up, up, down, far_down) = (at(2.0), at(1.0), at(-1.0), at(-2.0));
    std::array::from_fn(|row| {
        std::array::from_fn(|c| {
            (8.0 * (up[row][c] - down[row][c]) - (far_up[row][c] - far_down[row][c])) / (12.0 * step)
        })
    })
}

/// Points and weights of Gauss quadrature on (−1, 1).
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

fn apply<const M: usize>(matrix: &[[Complex64; 3]; M], u: [Complex64; 3]) -> [Complex64; M] {
    matrix.map(|row| row.iter().zip(u).map(|(entry, u)| entry * u).sum())
}

/// Returns the energy density ½ σ : ε*, from the stresses and the lateral strains.
fn energy_density(section: &Section, q: [f64; 2], surface: [Complex64; 3]) -> f64 {
    let u = apply(&section.displacement_transfer(q), surface);
    let [xx, yy, zz, yz, xz, xy] = apply(&section.stress_transfer(q), surface);
    let (material, shear) = (section.material(), section.material().shear_modulus());
    let (exx, eyy) = (I * q[0] * u[0], I * q[1] * u[1]);
    let ezz = zz * material.p_wave_compliance() - (1.0 - 2.0 * material.s()) * (exx + eyy);
    let pairs =
        [(xx, exx), (yy, eyy), (zz, ezz), (yz, yz / shear), (xz, xz / shear), (xy, I * (q[1] * u[0] + q[0] * u[1]))];
    0.5 * pairs.into_iter().map(|(stress, strain)| (stress * strain.conj()).re).sum::<f64>()
}

/// Returns a slab on the base number `kind`; the last base is a half-space.
fn standing(slab: Body, kind: usize, below: Material) -> Body {
    match GROUNDS.get(kind) {
        Some(ground) => slab.on(Base::Rigid(*ground)).unwrap(),
        None => slab.bonded_to(Body::half_space(below)).unwrap(),
    }
}

proptest! {
    #[test]
    fn forces_balance_and_hooke_holds(
        material in material(), kind in 0..5_usize, below in material(), q in wavevector(decades(0.1, 10.0)),
        place in 0.05..0.95,
    ) {
        let slab = Body::slab(material, 1.0).unwrap();
        let body = standing(slab, kind, below);
        let step = 0.02 / (4.0 + q[0].hypot(q[1]));
        let section = body.at_depth(place).unwrap();
        let (u, stress) = (section.displacement_transfer(q), section.stress_transfer(q));
        let rise = slope(&body, place, step, |section| section.displacement_transfer(q));
        let change: StressMatrix3 = slope(&body, place, step, |section| section.stress_transfer(q));
        let (qn, shear, s) = (q[0].hypot(q[1]), material.shear_modulus(), material.s());
        let size = qn * largest(&stress) + largest(&change);
        for c in 0..3 {
            let [xx, yy, zz, yz, xz, xy] = stress.map(|row| row[c]);
            let [.., zz_z, yz_z, xz_z, _] = change.map(|row| row[c]);
            for force in [
                I * (q[0] * xx + q[1] * xy) + xz_z,
                I * (q[0] * xy + q[1] * yy) + yz_z,
                I * (q[0] * xz + q[1] * yz) + zz_z,
            ] {
                prop_assert!(force.norm() < 1e-7 * size, "{force} of {size}");
            }
            let [ux, uy, uz] = u.map(|row| row[c]);
            let [ux_z, uy_z, uz_z] = rise.map(|row| row[c]);
            let size = shear * (qn * largest(&u) + largest(&rise)) + largest(&stress);
            let spread = I * (q[0] * ux + q[1] * uy);
            for (name, mismatch) in [
                ("xz", shear * (ux_z + I * q[0] * uz) - xz),
                ("yz", shear * (uy_z + I * q[1] * uz) - yz),
                ("zz", shear * (uz_z + (1.0 - 2.0 * s) * spread) - s * zz),
                ("xx", 2.0 * shear * (I * q[0] * ux - uz_z) + zz - xx),
                ("yy", 2.0 * shear * (I * q[1] * uy - uz_z) + zz - yy),
                ("xy", shear * I * (q[1] * ux + q[0] * uy) - xy),
            ] {
                prop_assert!(mismatch.norm() < 1e-7 * size, "{name}: {mismatch} of {size}");
            }
        }
    }

    #[test]
    fn the_surface_is_met_at_its_own_depth(body in body(), q in wavevector(decades(1e-4, 1e4))) {
        let section = body.at_depth(0.0).unwrap();
        let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|row| row.map(Complex64::from));
        prop_assert!(matrices_apart(&section.displacement_transfer(q), &one) < 1e-11);
        let stress = section.stress_transfer(q);
        let stiffness = body.stiffness(q);
        let traction = [stress[4], stress[3], stress[2]];
        prop_assert!(matrices_apart(&[stiffness[0], stiffness[1], stiffness[2]], &traction) < 1e-11);
    }

    #[test]
    fn each_base_does_what_it_says(material in material(), q in wavevector(decades(1e-3, 1e3))) {
        let slab = Body::slab(material, 1.0).unwrap();
        let zero = [Complex64::ZERO; 3];
        for ground in GROUNDS {
            let body = slab.clone().on(Base::Rigid(ground)).unwrap();
            let section = body.at_height(0.0).unwrap();
            let ([ux, uy, uz], [.., zz, yz, xz, _]) = (section.displacement_transfer(q), section.stress_transfer(q));
            for (component, u, traction) in
                [(ground.lateral, ux, xz), (ground.lateral, uy, yz), (ground.normal, uz, zz)]
            {
                prop_assert!(zero == if component == Condition::Fixed { u } else { traction }, "{ground:?}");
            }
        }
    }

    /// Two halves of one material have the fields of the whole slab above, on and below the cut.
    #[test]
    fn fields_do_not_see_a_cut(
        material in material(), q in wavevector(decades(0.01, 30.0)), fraction in 0.1..0.9, depth in 0.0..1.0,
        kind in 0..4_usize,
    ) {
        let base = Base::Rigid(GROUNDS[kind]);
        let whole = Body::slab(material, 1.0).unwrap().on(base.clone()).unwrap();
        let lower = Body::slab(material, 1.0 - fraction).unwrap().on(base).unwrap();
        let halves = Body::slab(material, fraction).unwrap().bonded_to(lower).unwrap();
        let scale = 1.0 + whole.stiffness_blocks(q[0].hypot(q[1])).normal / material.young();
        for depth in [depth, fraction] {
            let (a, b) = (whole.at_depth(depth).unwrap(), halves.at_depth(depth).unwrap());
            let (ta, tb) = (a.displacement_transfer(q), b.displacement_transfer(q));
            let (sa, sb) = (a.stress_transfer(q), b.stress_transfer(q));
            let difference = ta.iter().flatten().zip(tb.iter().flatten()).map(|(a, b)| (a - b).norm());
            prop_assert!(difference.fold(0.0, f64::max) < 1e-12 * scale.max(largest(&ta)));
            let difference = sa.iter().flatten().zip(sb.iter().flatten()).map(|(a, b)| (a - b).norm());
            prop_assert!(difference.fold(0.0, f64::max) < 1e-12 * scale * material.young().max(largest(&sa)));
        }
    }

    /// Near the surface of a deep slab, the fields equal the half-space fields; far below, they vanish.
    #[test]
    fn a_deep_slab_has_the_fields_of_the_half_space(material in material(), depth in 0.0..5.0, q in 5.0..8.0) {
        let (slab, half_space) = (Body::slab(material, 20.0).unwrap(), Body::half_space(material));
        let (a, b) = (slab.at_depth(depth).unwrap(), half_space.at_depth(depth).unwrap());
        let q = [0.8 * q, 0.6 * q];
        prop_assert!(matrices_apart(&a.displacement_transfer(q), &b.displacement_transfer(q)) < 1e-12);
        prop_assert!(matrices_apart(&a.stress_transfer(q), &b.stress_transfer(q)) < 1e-12);
    }

    #[test]
    fn the_work_at_the_surface_is_the_energy_inside(
        material in material(), below in material(), kind in 0..6_usize, q in wavevector(decades(0.05, 8.0)),
        parts in prop::array::uniform6(-1.0..1.0f64),
    ) {
        let slab = Body::slab(material, 1.0).unwrap();
        let (body, depth) = match kind {
            0..4 => (slab.on(Base::Rigid(GROUNDS[kind])).unwrap(), 1.0),
            4 => (slab.bonded_to(Body::slab(below, 0.5).unwrap()).unwrap(), 1.5),
            _ => (Body::half_space(material), 40.0 / q[0].hypot(q[1])),
        };
        let surface = [0, 1, 2].map(|axis| Complex64::new(parts[2 * axis], parts[2 * axis + 1]));
        // Intervals that end at the boundary of the layers.
        let intervals = if depth > 1.5 { 120 } else { 30 };
        let width = depth / f64::from(intervals);
        let energy: f64 = (0..intervals)
            .flat_map(|interval| GAUSS.map(|(x, weight)| ((f64::from(interval) + 0.5 * (1.0 + x)) * width, weight)))
            .map(|(depth, weight)| 0.5 * width * weight * energy_density(&body.at_depth(depth).unwrap(), q, surface))
            .sum();
        let traction = apply(&body.stiffness(q), surface);
        let work = 0.5 * surface.iter().zip(traction).map(|(u, t)| (u.conj() * t).re).sum::<f64>();
        prop_assert!((energy / work - 1.0).abs() < 1e-9, "{energy} {work}");
    }

    #[test]
    fn a_wave_along_x_is_plane_strain(
        body in body(), depth in 0.0..0.3, q in decades(0.1, 10.0), sign in prop_oneof![Just(1.0), Just(-1.0)],
    ) {
        let section = body.at_depth(depth).unwrap();
        let q = sign * q;
        let (u, stress) = (section.displacement_transfer([q, 0.0]), section.stress_transfer([q, 0.0]));
        let (plane_u, plane_stress) = (section.plane_displacement_transfer(q), section.plane_stress_transfer(q));
        prop_assert_eq!([[u[0][0], u[0][2]], [u[2][0], u[2][2]]], plane_u);
        let rows = [stress[0], stress[2], stress[4]].map(|row| [row[0], row[2]]);
        prop_assert_eq!(rows, plane_stress);
        // Plane strain: σ_yy = ν (σ_xx + σ_zz).
        for c in [0, 2] {
            let wanted = section.material().poisson() * (stress[0][c] + stress[2][c]);
            prop_assert!((stress[1][c] - wanted).norm() < 1e-12 * largest(&stress));
        }
    }

    /// Real fields stay real at Nyquist: the matrix is the mean over the aliases.
    #[test]
    fn nyquist_modes_average_their_aliases(
        material in material(), nx in 1usize..7, ny in 1usize..7, depth in 0.0..0.5,
    ) {
        let body = Body::slab(material, 0.5).unwrap();
        let section = body.at_depth(depth).unwrap();
        for mode in Grid::new([nx, ny], [1.0, 1.3]).unwrap().modes() {
            let (u, stress) = (section.displacement_transfer_of(&mode), section.stress_transfer_of(&mode));
            let continuous = section.continuous_transfer_of(&mode);
            let (mut mean_u, mut mean_stress) = ([[Complex64::ZERO; 3]; 3], [[Complex64::ZERO; 3]; 6]);
            let mut mean_continuous = mean_stress;
            if mode.is_uniform() {
                continue;
            }
            for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let alias = [0, 1].map(|axis| {
                    if mode.nyquist[axis] { signs[axis] * mode.wavevector[axis] } else { mode.wavevector[axis] }
                });
                let add = |mean: &mut [[Complex64; 3]], of_alias: &[[Complex64; 3]]| {
                    mean.iter_mut().flatten().zip(of_alias.iter().flatten()).for_each(|(m, e)| *m += 0.25 * e);
                };
                add(&mut mean_u, &section.displacement_transfer(alias));
                add(&mut mean_stress, &section.stress_transfer(alias));
                add(&mut mean_continuous, &section.continuous_transfer(alias));
            }
            prop_assert!(matrices_apart(&mean_u, &u) < 1e-13);
            prop_assert!(matrices_apart(&mean_stress, &stress) < 1e-13);
            prop_assert!(matrices_apart(&mean_continuous, &continuous) < 1e-13);
        }
    }

    /// A base far below the surface has no effect, whether its formulas are evaluated or skipped.
    #[test]
    fn a_base_out_of_reach_is_not_felt(
        material in material(), kind in 0..5_usize, below in material(), q in decades(22.0, 1e3), depth in 0.0..0.05,
    ) {
        let body = standing(Body::slab(material, 1.0).unwrap(), kind, below);
        let half_space = Body::half_space(material);
        let (section, expected) = (body.at_depth(depth).unwrap(), half_space.at_depth(depth).unwrap());
        let q = [0.6 * q, -0.8 * q];
        prop_assert!(matrices_apart(&section.displacement_transfer(q), &expected.displacement_transfer(q)) < 1e-13);
        prop_assert!(matrices_apart(&section.stress_transfer(q), &expected.stress_transfer(q)) < 1e-13);
    }

    #[test]
    fn nothing_overflows(material in material(), q in decades(1e-8, 1e8), fraction in 0.0..1.0) {
        for base in GROUNDS.map(Base::Rigid) {
            let body = Body::slab(material, 0.01).unwrap().on(base).unwrap();
            for section in [body.at_depth(0.01 * fraction).unwrap(), body.at_height(0.0).unwrap()] {
                let (u, stress) = (section.displacement_transfer([q, q]), section.stress_transfer([q, q]));
                prop_assert!(u.iter().flatten().chain(stress.iter().flatten()).all(|e| e.is_finite()));
            }
        }
        let section_of = Body::half_space(material);
        let section = section_of.at_depth(1e300).unwrap();
        prop_assert!(section.stress_transfer([q, q]).iter().flatten().all(|e| *e == Complex64::ZERO));
    }
}

#[test]
fn the_uniform_mode_shears_and_squeezes_evenly() {
    let material = Material::from_young(2.6, 0.3).unwrap();
    let soft = Material::from_young(1.3, 0.3).unwrap();
    let slab = Body::slab(material, 2.0).unwrap();
    let diagonal = |body: &Body, depth: f64| {
        let t = body.at_depth(depth).unwrap().displacement_transfer([0.0, 0.0]);
        [t[0][0].re, t[1][1].re, t[2][2].re]
    };
    assert_eq!(diagonal(&slab, 0.5), [0.75; 3]);
    assert_eq!(diagonal(&slab, 2.0), [0.0; 3]);
    assert_eq!(diagonal(&slab.clone().on(Base::SLIDING).unwrap(), 0.5), [1.0, 1.0, 0.75]);
    assert_eq!(diagonal(&slab.clone().on(Base::FREE).unwrap(), 0.5), [1.0; 3]);
    assert_eq!(diagonal(&slab.clone().on(Base::Rigid(Ground::GUIDED)).unwrap(), 0.5), [0.75, 0.75, 1.0]);
    assert_eq!(diagonal(&Body::half_space(material), 0.5), [1.0; 3]);
    // The lower layer is half as stiff and half as high: each takes half.
    let stack = slab.clone().bonded_to(Body::slab(soft, 1.0).unwrap()).unwrap();
    for (depth, wanted) in [(1.0, 0.75), (2.0, 0.5), (2.5, 0.25), (3.0, 0.0)] {
        for found in diagonal(&stack, depth) {
            assert!((found - wanted).abs() < 1e-15, "{found} at {depth}");
        }
    }
    let stress = slab.at_depth(0.5).unwrap().stress_transfer([0.0, 0.0]);
    let normal = material.p_wave_modulus().unwrap() / 2.0;
    let wanted = [normal * 0.3 / 0.7, normal * 0.3 / 0.7, normal];
    for (row, wanted) in stress.iter().zip(wanted) {
        assert!((row[2].re / wanted - 1.0).abs() < 1e-14, "{stress:?}");
    }
    assert!((stress[4][0].re - 0.5).abs() < 1e-15 && (stress[3][1].re - 0.5).abs() < 1e-15);

    let rubber = Body::slab(Material::from_young(1.0, 0.5).unwrap(), 2.0).unwrap();
    assert_eq!(diagonal(&rubber, 0.5), [0.75; 3]);
    let stack = rubber.clone().bonded_to(Body::slab(Material::from_young(3.0, 0.5).unwrap(), 1.0).unwrap()).unwrap();
    assert_eq!([diagonal(&stack, 0.0)[2], diagonal(&stack, 1.5)[2], diagonal(&stack, 2.25)[2]], [1.0, 0.5, 0.25]);
    let stress = rubber.at_depth(0.5).unwrap().stress_transfer([0.0, 0.0]);
    assert!([0, 1, 2].iter().all(|&row| stress[row][2].re == f64::INFINITY));
    let [xx, zz, xz] = rubber.at_depth(0.5).unwrap().plane_stress_transfer(0.0);
    assert!(xx[1].re == f64::INFINITY && zz[1].re == f64::INFINITY);
    assert_eq!((xx[0], zz[0], xz[1]), (Complex64::ZERO, Complex64::ZERO, Complex64::ZERO));
}
