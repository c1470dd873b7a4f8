//! Relations that hold for every law at generic separations, and properties of each law.

use approx::assert_relative_eq;
use gfmd_law::{
    BoschSchreursGeers, CoupledExponential, Dugdale, Exponential, Friction, HardWall, HarmonicCosine, Law, LawError,
    LawKind, Limit, MixedMode, Morse, Npb, Npc, Opening, Rate, Separation, XuNeedleman,
};
use proptest::prelude::*;

const UNEQUAL: Separation =
    Separation { normal_work: 1.3, tangential_work: 0.9, normal_length: 0.2, tangential_length: 0.35 };
const EQUAL: Separation = Separation { tangential_work: 1.3, ..UNEQUAL };

fn xu_needleman(q: f64, r: f64) -> XuNeedleman {
    XuNeedleman::new(Separation { tangential_work: 1.3 * q, ..UNEQUAL }, r).unwrap()
}

fn cohesive() -> Vec<Box<dyn Law>> {
    let mut laws: Vec<Box<dyn Law>> = vec![
        Box::new(xu_needleman(1.0, 0.5)),
        Box::new(xu_needleman(0.7, 0.2)),
        Box::new(xu_needleman(1.5, 0.0)),
        Box::new(xu_needleman(0.5, 0.5)),
        Box::new(xu_needleman(0.5, 0.8)),
    ];
    for separation in [UNEQUAL, EQUAL] {
        laws.push(Box::new(BoschSchreursGeers::new(separation).unwrap()));
        laws.push(Box::new(CoupledExponential::new(separation).unwrap()));
        laws.push(Box::new(Npb::new(separation).unwrap()));
        laws.push(Box::new(Npc::new(separation).unwrap()));
    }
    laws
}

fn normal() -> Vec<Box<dyn Law>> {
    vec![
        Box::new(HardWall),
        Box::new(Morse::new(1.3, 0.2).unwrap()),
        Box::new(Exponential::new(1.3, 0.2).unwrap()),
        Box::new(HarmonicCosine::new(1.3, 40.0).unwrap()),
        Box::new(Dugdale::new(1.3, 0.2).unwrap()),
    ]
}

fn all() -> impl Iterator<Item = Box<dyn Law>> {
    cohesive().into_iter().chain(normal())
}

/// Returns true if all laws are differentiable at this separation: not at contact, nor at the end of a finite range.
fn is_smooth(normal: f64) -> bool {
    let cutoff = HarmonicCosine::new(1.3, 40.0).unwrap().cutoff();
    [0.0, 0.2, cutoff].iter().all(|kink| (normal - kink).abs() > 1e-3)
}

proptest! {
    #[test]
    fn an_opening_has_the_bits_of_its_parts(normal in -0.4..1.2) {
        for law in all() {
            let response = law.response(normal, 0.0);
            let Opening { energy, traction, slope } = law.opening(normal);
            let parts = [law.opening_energy(normal), response.traction[0], response.jacobian[0][0]];
            prop_assert_eq!([energy, traction, slope], parts);
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative_of_the_traction(normal in -0.4..1.2, x in -0.8..0.8, y in -0.8..0.8) {
        prop_assume!(is_smooth(normal));
        let h = 1e-5;
        for law in all() {
            let slope = |d: [f64; 3]| {
                let at = |h: f64| law.traction(normal + h * d[2], [x + h * d[0], y + h * d[1]]);
                let (a, b) = (at(h), at(-h));
                [0, 1, 2].map(|i| (a[i] - b[i]) / (2.0 * h))
            };
            let j = law.jacobian(normal, [x, y]);
            let columns =
                [[j.tt[0][0], j.tt[1][0], j.nt[0]], [j.tt[0][1], j.tt[1][1], j.nt[1]], [j.tn[0], j.tn[1], j.nn]];
            let scale = law.stiffness_bound(-0.4);
            for (direction, column) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().zip(columns) {
                for (found, wanted) in column.into_iter().zip(slope(direction)) {
                    prop_assert!((found - wanted).abs() <= 2e-7 * scale, "{law:?}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn the_traction_is_the_gradient_of_the_energy(normal in -0.4..1.2, x in -0.8..0.8, y in -0.8..0.8) {
        prop_assume!(is_smooth(normal));
        let h = 1e-5;
        for law in all() {
            let energy = |x: f64, y: f64, n: f64| law.energy(n, x.hypot(y));
            let opening = (law.opening_energy(normal + h) - law.opening_energy(normal - h)) / (2.0 * h);
            prop_assert!((opening - law.traction(normal, [0.0; 2])[2]).abs() <= 1e-7 * 50.0, "{law:?}: {opening}");
            if energy(x, y, normal).is_none() {
                continue;
            }
            prop_assert!((law.opening_energy(normal) - energy(0.0, 0.0, normal).unwrap()).abs() < 1e-13);
            let slope = |d: [f64; 3]| {
                let at = |h: f64| energy(x + h * d[0], y + h * d[1], normal + h * d[2]).unwrap();
                (at(h) - at(-h)) / (2.0 * h)
            };
            let traction = law.traction(normal, [x, y]);
            for (i, d) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
                prop_assert!((traction[i] - slope(d)).abs() <= 1e-7 * 50.0, "{law:?}: {traction:?} {}", slope(d));
            }
        }
    }

    #[test]
    fn no_eigenvalue_exceeds_the_bound(lowest in -0.5..0.5_f64, above in 0.0..1.0, sliding in -1.0..1.0) {
        for law in all() {
            let lowest = if law.has_wall() { lowest.max(0.0) } else { lowest };
            let response = law.response(lowest + above, sliding);
            let [[a, b], [c, d]] = response.jacobian;
            // |λ| of a real 2 × 2 matrix: complex pairs have |λ|² = det.
            let (half, det) = (0.5 * (a + d), a * d - b * c);
            let root = half * half - det;
            let largest = if root < 0.0 { det.sqrt() } else { half.abs() + root.sqrt() };
            let bound = law.stiffness_bound(lowest) * (1.0 + 1e-14);
            prop_assert!(largest <= bound && response.secant.abs() <= bound, "{law:?}: {largest} {bound}");
        }
    }

    #[test]
    fn an_isotropic_law_turns_with_the_sliding(normal in -0.3..1.0, sliding in 0.01..1.0, angle in 0.0..6.3) {
        for law in all() {
            let [x, y] = [f64::cos(angle), f64::sin(angle)];
            let [tx, ty, tn] = law.traction(normal, [sliding * x, sliding * y]);
            let [n, t] = law.response(normal, sliding).traction;
            prop_assert!((tx - t * x).abs().max((ty - t * y).abs()) <= 1e-13 * (1.0 + t.abs()));
            prop_assert!((tn - n).abs() <= 1e-13 * (1.0 + n.abs()));
            prop_assert_eq!(law.response(normal, -sliding).traction, [n, -t]);
        }
    }

    #[test]
    fn friction_never_exceeds_its_limit_and_its_derivatives_are_those_of_the_traction(
        x in -1.0..1.0, y in -1.0..1.0, foot in -1.0..1.0, pressure in 0.0..2.0,
    ) {
        for limit in [Limit::Coulomb(0.4), Limit::Tresca(0.3)] {
            let friction = Friction::new(limit, 3.0).unwrap();
            let at = |x: f64, y: f64, p: f64| friction.slide([x, y], [foot, 0.1], p);
            let now = at(x, y, pressure);
            prop_assert!(now.traction[0].hypot(now.traction[1]) <= limit.at(pressure) * (1.0 + 1e-14));
            // The stretch of the spring matches its traction.
            prop_assert!((3.0 * (x - now.foot[0]) - now.traction[0]).abs() < 1e-13);
            let h = 1e-6;
            let steps = [at(x + h, y, pressure), at(x, y + h, pressure), at(x, y, pressure + h)];
            if steps.iter().any(|step| step.sticks != now.sticks) {
                continue;
            }
            for i in 0..2 {
                let wanted = [now.by_slip[i][0], now.by_slip[i][1], now.by_pressure[i]];
                for (step, wanted) in steps.iter().zip(wanted) {
                    prop_assert!(((step.traction[i] - now.traction[i]) / h - wanted).abs() < 1e-4);
                }
            }
        }
    }
}

/// Integrates `f` by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let n = 4000;
    let h = (b - a) / n as f64;
    let weight = |i: usize| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    (0..=n).map(|i| weight(i) * f(a + i as f64 * h)).sum::<f64>() * h / 3.0
}

#[test]
fn works_of_separation_by_quadrature() {
    for q in [0.5, 0.7, 1.0, 1.5] {
        let separation = Separation { tangential_work: 1.3 * q, ..UNEQUAL };
        let laws: [Box<dyn Law>; 5] = [
            Box::new(xu_needleman(q, 0.2)),
            Box::new(BoschSchreursGeers::new(separation).unwrap()),
            Box::new(CoupledExponential::new(separation).unwrap()),
            Box::new(Npb::new(separation).unwrap()),
            Box::new(Npc::new(separation).unwrap()),
        ];
        for law in laws {
            let opening = integral(|n| law.response(n, 0.0).traction[0], 0.0, 10.0);
            assert_relative_eq!(opening, 1.3, max_relative = 1e-9);
            let sliding = integral(|s| law.response(0.0, s).traction[1], 0.0, 15.0);
            assert_relative_eq!(sliding, 1.3 * q, max_relative = 1e-9);
        }
    }
    let cutoff = HarmonicCosine::new(1.3, 40.0).unwrap().cutoff();
    for (law, end) in normal().into_iter().skip(1).zip([8.0, 8.0, cutoff, 0.2]) {
        let opening = integral(|n| law.response(n, 0.0).traction[0], 0.0, end);
        assert_relative_eq!(opening, 1.3, max_relative = 1e-6);
    }
}

#[test]
fn open_then_slide_takes_the_work_of_the_theory_note() {
    let (x, e) = (0.8_f64, (-0.8_f64).exp());
    let work = |law: &dyn Law| {
        integral(|n| law.response(n, 0.0).traction[0], 0.0, 0.2 * x)
            + integral(|s| law.response(0.2 * x, s).traction[1], 0.0, 15.0)
    };
    let opening = 1.3 * (1.0 - (1.0 + x) * e);
    let Separation { tangential_work, .. } = UNEQUAL;
    assert_relative_eq!(
        work(&BoschSchreursGeers::new(UNEQUAL).unwrap()),
        opening + tangential_work * (1.0 + x) * e,
        max_relative = 1e-9
    );
    assert_relative_eq!(
        work(&Npc::new(UNEQUAL).unwrap()),
        opening + tangential_work * (1.0 + x) * e,
        max_relative = 1e-9
    );
    assert_relative_eq!(
        work(&CoupledExponential::new(UNEQUAL).unwrap()),
        opening + tangential_work * e,
        max_relative = 1e-9
    );
}

/// Evaluates the requirements R1 to R6 on a grid of separations.
fn observed(law: &dyn Law) -> MixedMode {
    let at = |x: f64, y: f64| law.response(0.2 * x, 0.35 * y).traction;
    let net =
        |from: f64| (0..60).flat_map(move |i| (1..60).map(move |j| (from + 0.05 * f64::from(i), 0.05 * f64::from(j))));
    let slack = 1e-12;
    let far = (0..40).map(|i| std::f64::consts::FRAC_PI_2 * f64::from(i) / 40.0).all(|angle| {
        // Slightly off pure sliding.
        let [n, t] = at(60.0 * angle.sin() + 0.1, 60.0 * angle.cos());
        n.hypot(t) < 1e-3
    });
    let smooth = |from: f64| {
        net(from).all(|(x, y)| {
            let step = 1e-7;
            [at(x + step, y), at(x, y + step)].iter().all(|t| (t[0] - at(x, y)[0]).hypot(t[1] - at(x, y)[1]) < 1e-3)
        })
    };
    MixedMode {
        independent_works: true, // another test checks it by quadrature
        resists_sliding: net(-3.0).chain(net(0.0)).chain(net(9.0)).all(|(x, y)| at(x, y)[1] >= -slack),
        keeps_repulsion: net(-3.0)
            .filter(|(x, _)| *x < -1e-9)
            .all(|(x, y)| at(x, y)[0] <= at(x, 0.0)[0] + slack && at(x - 0.01, y)[0] <= at(x, y)[0] + slack),
        holds_under_pressure: net(-3.0)
            .filter(|(x, _)| *x < -1e-9)
            .all(|(x, y)| at(x - 0.01, y)[1].abs() >= at(x, y)[1].abs() - slack),
        vanishes: far,
        continuous: smooth(-3.0) && smooth(-1e-8),
    }
}

#[test]
fn each_law_keeps_what_it_promises_and_no_more() {
    for law in cohesive() {
        assert_eq!(law.mixed_mode(), Some(observed(law.as_ref())), "{law:?}");
    }
    let failing = |law: &dyn Law| !law.mixed_mode().unwrap().all();
    assert!(failing(&xu_needleman(1.0, 0.5)) && failing(&BoschSchreursGeers::new(UNEQUAL).unwrap()));
    assert!(!failing(&Npb::new(UNEQUAL).unwrap()) && !failing(&Npc::new(UNEQUAL).unwrap()));
}

#[test]
fn potentials_where_works_are_equal_are_one_law() {
    let (bsg, xn) = (BoschSchreursGeers::new(EQUAL).unwrap(), xu_needleman(1.0, 0.5));
    for (n, s) in [(0.1, 0.2), (0.5, -0.4), (-0.1, 0.3)] {
        assert_relative_eq!(bsg.energy(n, s).unwrap(), xn.energy(n, s).unwrap(), max_relative = 1e-12);
    }
}

#[test]
fn unusable_parameters_are_refused_with_what_is_allowed() {
    let message = |kind: LawKind, given: &[(&str, f64)]| kind.with(given).unwrap_err().to_string();
    assert_eq!(
        message(LawKind::Morse, &[("gamma", 1.0), ("rho", 1.0)]),
        "the law morse has no parameter \"rho\"; it takes gamma (stress*length, positive), range (length, positive)"
    );
    assert_eq!(
        message(LawKind::HardWall, &[("gamma", 1.0)]),
        "the law hard-wall has no parameter \"gamma\"; it takes none"
    );
    assert_eq!(
        message(LawKind::Dugdale, &[("range", 1.0)]),
        "the law dugdale needs the parameter gamma (stress*length, positive)"
    );
    assert_eq!(
        message(LawKind::Morse, &[("gamma", 1.0), ("range", 1.0), ("gamma", 2.0)]),
        "the parameter gamma is given more than once"
    );
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for kind in LawKind::ALL {
            for wrong in kind.parameters().iter().filter(|p| p.default.is_none()) {
                let given: Vec<_> =
                    kind.parameters().iter().map(|p| (p.name, if p.name == wrong.name { bad } else { 0.5 })).collect();
                let text = message(kind, &given);
                assert_eq!(text, format!("{} is {bad}; it must be a positive, finite number", wrong.name));
            }
        }
    }
    let four = [("phi_n", 1.0), ("phi_t", 1.0), ("delta_n", 1.0), ("delta_t", 1.0)];
    let with_r = |r: f64| [&four[..], &[("r", r)]].concat();
    assert_eq!(message(LawKind::XuNeedleman, &with_r(1.0)), "r is 1; it must be a finite number other than 1");
    assert!(LawKind::XuNeedleman.with(&four).is_ok());
    let unknown = "glue".parse::<LawKind>().unwrap_err();
    assert!(unknown.to_string().contains("\"glue\"; it must be one of hard-wall, xu-needleman, bsg, "), "{unknown}");
    for kind in LawKind::ALL {
        assert_eq!(kind.name().parse(), Ok(kind));
    }
    assert!(matches!(Friction::new(Limit::Coulomb(-0.1), 1.0), Err(LawError::Range { name: "mu", .. })));
    assert!(matches!(Friction::new(Limit::Tresca(f64::NAN), 1.0), Err(LawError::Range { name: "tau_c", .. })));
    assert!(Friction::new(Limit::Tresca(1.0), 0.0).is_err());
    assert_eq!(Rate::Root { velocity: 0.1 }.traction(1.0, [0.0; 2]), [0.0; 2]);
}

#[test]
fn the_energy_of_every_law_is_zero_far_away_and_minus_the_work_done_at_a_gap() {
    for law in all() {
        for far in [50.0, 1e9] {
            let found = law.opening_energy(far);
            assert!(found.abs() <= 1e-12, "{law:?}: {found:e} at {far}");
            let found = law.energy(far, 0.2).unwrap_or(0.0);
            assert!(found.abs() <= 1e-12, "{law:?}: {found:e} at {far}, sideways");
        }
        // Work of the attraction from the gap to infinity, by the trapezoidal rule.
        for gap in [0.0, 0.1] {
            let (n, width) = (400_000, 40.0);
            let at = |k: i32| law.traction(gap + width * f64::from(k) / f64::from(n), [0.0; 2])[2];
            let sum: f64 = (1..n).map(at).sum::<f64>() + 0.5 * (at(0) + at(n));
            let work = sum * width / f64::from(n);
            let found = law.opening_energy(gap);
            assert!((found + work).abs() <= 1e-3 * work.abs().max(1e-6), "{law:?}: {found:e} at {gap}, work {work:e}");
        }
    }
}
