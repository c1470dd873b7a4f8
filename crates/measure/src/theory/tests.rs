use super::*;
use approx::assert_relative_eq;

#[test]
fn the_pressures_of_persson_add_up_to_the_area_and_the_load() {
    for p_star in [0.01, 0.2, 2.0] {
        let step = 1e-3;
        let density = |k: i32| persson_pressure(f64::from(k) * step, p_star, 0.25);
        let (mut area, mut load) = (0.0, 0.0);
        for k in 1..10_000 {
            area += density(k) * step;
            load += density(k) * step * f64::from(k) * step;
        }
        assert_relative_eq!(area, persson_area(p_star), max_relative = 1e-5);
        assert_relative_eq!(load, p_star, max_relative = 1e-5);
    }
}

#[test]
fn constants_are_the_square_roots_they_claim() {
    assert_relative_eq!(PERSSON_KAPPA, (8.0 / PI).sqrt(), max_relative = 1e-15);
    assert_relative_eq!(BUSH_GIBSON_THOMAS_KAPPA, (2.0 * PI).sqrt(), max_relative = 1e-15);
}

#[test]
fn westergaard_pressure_carries_the_load_and_ends_at_the_edge() {
    let wave = Westergaard { modulus: 2.0, amplitude: 0.03, period: 1.5 };
    for f in [0.05, 0.4, 0.9] {
        let mean = f * wave.full_contact_pressure();
        let n = 200_000;
        let x = |i: usize| (i as f64 + 0.5) / n as f64 * wave.period;
        let load = (0..n).map(|i| wave.pressure(mean, x(i))).sum::<f64>() / n as f64;
        assert_relative_eq!(load, mean, max_relative = 1e-6);
        let touching = (0..n).filter(|i| wave.pressure(mean, x(*i)) > 0.0).count() as f64 / n as f64;
        assert_relative_eq!(touching, wave.area(mean), epsilon = 2.0 / n as f64);
    }
}

#[test]
fn hertz_contacts_carry_their_load() {
    // ∫ p₀ √(1 − r²/a²) over the contact.
    let point = hertz_point(3.0, 2.0, 0.1);
    assert_relative_eq!(2.0 / 3.0 * PI * point.radius.powi(2) * point.peak_pressure, 0.1, max_relative = 1e-14);
    let (half_width, peak) = hertz_line(3.0, 2.0, 0.1);
    assert_relative_eq!(0.5 * PI * half_width * peak, 0.1, max_relative = 1e-14);
}

#[test]
fn an_adhesive_sphere_goes_from_jkr_to_dmt_as_its_range_grows() {
    let sphere = AdhesiveSphere { modulus: 1.3, curvature_radius: 2.5, work: 1e-3 };
    let reduced = |lambda: f64| sphere.maugis_pull_off(lambda) / sphere.force_unit();
    assert_relative_eq!(sphere.jkr_pull_off() / sphere.force_unit(), -1.5);
    assert_relative_eq!(reduced(20.0), -1.5, max_relative = 2e-3);
    // Derjaguin, Muller and Toporov: −2 π w R.
    assert_relative_eq!(reduced(1e-3), -2.0, max_relative = 2e-3);
    let least = (1..4000).map(|i| sphere.maugis(1.0, 1.0 + 1e-3 * f64::from(i)).force).fold(0.0, f64::min);
    assert_relative_eq!(sphere.maugis_pull_off(1.0), least, max_relative = 1e-6);
}

#[test]
fn an_adhesive_sphere_of_jkr_obeys_their_force() {
    // a³ − √(6 a³), and the approach a² − (2/3) √(6 a), in Maugis' units.
    let sphere = AdhesiveSphere { modulus: 0.7, curvature_radius: 1.5, work: 2e-3 };
    let contact = sphere.maugis(200.0, 1.000_02);
    let a = contact.radius / sphere.radius_unit();
    assert_relative_eq!(contact.force / sphere.force_unit(), a.powi(3) - (6.0 * a.powi(3)).sqrt(), max_relative = 1e-3);
    let approach = contact.approach * sphere.curvature_radius / sphere.radius_unit().powi(2);
    assert_relative_eq!(approach, a * a - 2.0 / 3.0 * (6.0 * a).sqrt(), max_relative = 1e-3);
}

#[test]
fn an_adhesive_wave_without_work_is_that_of_westergaard() {
    let wave = Westergaard { modulus: 2.0, amplitude: 0.03, period: 1.5 };
    for f in [0.1, 0.5, 0.9] {
        let mean = f * wave.full_contact_pressure();
        assert_relative_eq!(wave.adhesive_pressure(0.0, wave.area(mean)), mean, max_relative = 1e-14);
        assert!(wave.adhesive_pressure(1e-3, wave.area(mean)) < mean);
    }
}

#[test]
fn johnson_low_load_is_two_hertz_contacts_in_the_cell() {
    let (modulus, amplitude, period, f) = (1.3, 0.02, 0.7, 1e-4);
    let radius = period * period / (4.0 * PI * PI * amplitude);
    let force = f * johnson_full_contact_pressure(modulus, amplitude, period) * period * period / 2.0;
    let contact = hertz_point(modulus, radius, force).radius;
    let area = 2.0 * PI * contact * contact / (period * period);
    assert_relative_eq!(johnson_area_at_low_load(f), area, max_relative = 1e-12);
}

/// Compares `persson_halfspace`, Hertz and Westergaard with the tables of an independent program.
#[test]
fn closed_forms_are_those_of_the_tables() {
    let tables: serde_json::Value =
        serde_json::from_str(include_str!("../../../../data/reference/theory_curves.json")).unwrap();
    let rows = |name: &str| -> Vec<Vec<f64>> { serde_json::from_value(tables[name].clone()).unwrap() };
    for row in rows("persson_halfspace") {
        assert_relative_eq!(persson_area(row[0]), row[1], max_relative = 1e-14);
    }
    for row in rows("hertz_line") {
        let (half_width, peak) = hertz_line(row[0], row[1], row[2]);
        assert_relative_eq!(half_width, row[3], max_relative = 1e-14);
        assert_relative_eq!(peak, row[4], max_relative = 1e-14);
    }
    for row in rows("hertz_point") {
        let found = hertz_point(row[0], row[1], row[2]);
        for (found, expected) in [found.radius, found.approach, found.peak_pressure].into_iter().zip(&row[3..]) {
            assert_relative_eq!(found, *expected, max_relative = 1e-14);
        }
    }
    let wave = Westergaard { modulus: 1.3, amplitude: 0.02, period: 0.7 };
    let unit = wave.full_contact_pressure();
    for row in rows("westergaard") {
        let mean = row[0] * unit;
        assert_relative_eq!(wave.area(mean), row[1], max_relative = 1e-13);
        assert_relative_eq!(wave.mean_gap(mean) / wave.amplitude, row[2], max_relative = 1e-12);
        assert_relative_eq!(wave.pressure(mean, 0.0) / unit, row[3], max_relative = 1e-13);
    }
}

#[test]
fn asperities_are_those_of_an_independent_quadrature() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("../../../../data/reference/asperity_theories.json")).unwrap();
    let cases = reference["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let [m0, m2, m4, separation] = ["m0", "m2", "m4", "separation"].map(|name| case[name].as_f64().unwrap());
        let asperities = Asperities::new([m0, m2, m4]).unwrap();
        for (theory, name) in [
            (AsperityTheory::BushGibsonThomas, "bush_gibson_thomas"),
            (AsperityTheory::GreenwoodWilliamson, "greenwood_williamson"),
        ] {
            let found = asperities.at_separation(theory, separation);
            assert_relative_eq!(found.area_fraction, case[name][0].as_f64().unwrap(), max_relative = 1e-5);
            assert_relative_eq!(found.relative_pressure, case[name][1].as_f64().unwrap(), max_relative = 1e-5);
            let again = asperities.at_pressure(theory, found.relative_pressure).unwrap();
            assert_relative_eq!(again.separation, separation, max_relative = 1e-9);
        }
    }
}

/// κ of Bush, Gibson and Thomas at vanishing load is √(2π), with ḡ² = 2 m2. The broader the spectrum, the slower it is
/// approached.
#[test]
fn bush_gibson_and_thomas_have_their_limit() {
    for (nayak, reached) in [(1.6, 0.98), (5.0, 0.9), (100.0, 0.7)] {
        let asperities = Asperities::new([nayak, 1.0, 1.0]).unwrap();
        let kappa = |pressure: f64| {
            let found = asperities.at_pressure(AsperityTheory::BushGibsonThomas, pressure).unwrap();
            2_f64.sqrt() * found.area_fraction / found.relative_pressure
        };
        let kappas = [1e-2, 1e-5, 1e-10, 1e-20].map(kappa);
        assert!(kappas.windows(2).all(|pair| pair[0] < pair[1]), "{kappas:?}");
        assert!(
            kappas[3] < BUSH_GIBSON_THOMAS_KAPPA && kappas[3] > reached * BUSH_GIBSON_THOMAS_KAPPA,
            "{nayak}: {kappas:?}"
        );
    }
}

#[test]
fn surfaces_that_cannot_be_have_no_asperities() {
    let bad = [[1.0, 1.0, 1.4], [0.0, 1.0, 1.0], [1.0, f64::NAN, 1.0], [1.0, -1.0, 5.0], [1.0, 1.0, f64::INFINITY]];
    assert!(bad.into_iter().all(|moments| Asperities::new(moments).is_none()));
    let good = Asperities::new([1.0, 1.0, 1.5]).unwrap();
    assert!(good.at_pressure(AsperityTheory::BushGibsonThomas, 1e-3).is_some());
    for pressure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(good.at_pressure(AsperityTheory::BushGibsonThomas, pressure).is_none());
    }
}

/// Returns a half-space below a continuous self-affine spectrum of three decades.
fn self_affine(hurst: f64, modulus: f64, count: u32) -> Persson {
    let step = 1000_f64.ln() / f64::from(count);
    let wave = |k: u32| {
        let wavenumber = 2.0 * (step * (f64::from(k) + 0.5)).exp();
        (wavenumber, 1e-4 * step * wavenumber.powf(-2.0 * hurst))
    };
    Persson::new((0..count).map(wave), |q| 0.5 * modulus * q).unwrap()
}

#[test]
fn persson_of_a_half_space_is_the_error_function_of_the_reduced_pressure() {
    let theory = self_affine(0.8, 3.0, 400);
    // V = (E* g/2)².
    let unit = 2.0 * theory.variance(f64::INFINITY).sqrt();
    for p_star in [1e-3, 0.1, 1.0] {
        assert_relative_eq!(theory.area(p_star * unit, f64::INFINITY), persson_area(p_star), max_relative = 1e-12);
    }
    // The area at a low magnification is larger, and it is the whole surface without waves.
    let areas = [0.1, 10.0, 100.0, 1e4].map(|largest| theory.area(0.05 * unit, largest));
    assert!(areas[0] == 1.0 && areas.windows(2).all(|pair| pair[0] > pair[1]), "{areas:?}");
}

#[test]
fn the_distribution_of_pressure_has_the_area_and_the_mean() {
    let theory = self_affine(0.3, 1.0, 100);
    let deviation = theory.variance(f64::INFINITY).sqrt();
    for mean in [0.1 * deviation, deviation, 4.0 * deviation] {
        let [mut area, mut load] = [0.0; 2];
        for (pressure, weight) in quadrature::gauss_legendre(200, [0.0, mean + 12.0 * deviation]) {
            let density = theory.pressure_density(mean, f64::INFINITY, pressure);
            area += weight * density;
            load += weight * density * pressure;
        }
        assert_relative_eq!(area, theory.area(mean, f64::INFINITY), max_relative = 1e-9);
        assert_relative_eq!(load, mean, max_relative = 1e-9);
    }
}

/// dU/dū = −p̄, with U the elastic energy of the theory; the gap at vanishing pressure grows as its logarithm.
#[test]
fn the_mean_gap_does_the_work_of_the_pressure() {
    let theory = self_affine(0.8, 1.0, 3000);
    let energy = |mean: f64| -> f64 {
        let mut longer = 0.0;
        let mut sum = 0.0;
        // Three decades in 3000 steps, which are wider than the shells.
        for k in 0..3000_u32 {
            let step = 1000_f64.ln() / 3000.0;
            let q = 2.0 * (step * (f64::from(k) + 0.5)).exp();
            let (square, stiffness) = (1e-4 * step * q.powf(-1.6), 0.5 * q);
            let variance = stiffness * stiffness * square;
            // The waves of a step are added in fifty parts.
            for part in 0..50 {
                let met = longer + (f64::from(part) + 0.5) / 50.0 * variance;
                let area = libm::erf(mean / (2.0 * met).sqrt());
                sum += 0.5 * stiffness * square / 50.0 * (0.45 * area + 0.55 * area.powi(3));
            }
            longer += variance;
        }
        sum
    };
    let deviation = theory.variance(f64::INFINITY).sqrt();
    for mean in [0.01 * deviation, 0.1 * deviation, deviation] {
        let [low, high] = [mean * (1.0 - 1e-3), mean * (1.0 + 1e-3)];
        let work = (energy(high) - energy(low)) / (theory.mean_gap(low, 0.45) - theory.mean_gap(high, 0.45));
        assert_relative_eq!(work, mean, max_relative = 1e-4);
    }
    let gaps = [1e-3, 1e-4, 1e-5, 1e-6].map(|part: f64| theory.mean_gap(part * deviation, 0.45));
    assert_relative_eq!(gaps[2] - gaps[1], gaps[3] - gaps[2], max_relative = 1e-3);
    assert_eq!(theory.mean_gap(20.0 * deviation, 0.45), 0.0);
}

/// The elastic energy of waves of equal stiffness does not depend on their number. The mean gap is an integral over the
/// variance, here by Simpson's rule on 4000 intervals of its root and on 400 of the logarithm of the pressure.
#[test]
fn the_mean_gap_of_waves_of_one_stiffness_is_an_integral_over_their_variance() {
    const GAMMA: f64 = 0.45;
    let simpson = |count: usize, [low, high]: [f64; 2], f: &dyn Fn(f64) -> f64| -> f64 {
        let step = (high - low) / count as f64;
        let weight = |i: usize| if i == 0 || i == count { 1.0 } else { [2.0, 4.0][i % 2] };
        (0..=count).map(|i| weight(i) * f(low + step * i as f64)).sum::<f64>() * step / 3.0
    };
    // J(s) = ∫ from s (2/√π) e^(-x²) [γ + 3 (1 − γ) erf(x)²] dx/x, so that ū = ½ k ⟨h²⟩ mean over V of
    // J(p/√(2V))/√(2V).
    let integrand = |log: f64| {
        let (x, area) = (log.exp(), libm::erf(log.exp()));
        2.0 / std::f64::consts::PI.sqrt() * (-x * x).exp() * (GAMMA + 3.0 * (1.0 - GAMMA) * area * area)
    };
    let tail = |s: f64| if s < 7.0 { simpson(400, [s.ln(), 7_f64.ln()], &integrand) } else { 0.0 };
    for (stiffness, square, pressure) in [(2.0, 1e-4, 1e-4), (2.0, 1e-4, 0.01), (0.5, 0.04, 0.2)] {
        let variance: f64 = stiffness * stiffness * square;
        // V = r², from r = 0, where there is no separation at a positive pressure.
        let mean_over_variance = simpson(4000, [1e-9, variance.sqrt()], &|r| {
            let unit = 2_f64.sqrt() * r;
            2.0 * r * tail(pressure / unit) / unit
        }) / variance;
        let wanted = 0.5 * stiffness * square * mean_over_variance;
        for count in [1, 2, 7, 100] {
            let wave = |k: u32| (1.1_f64.powi(k as i32), square / f64::from(count));
            let theory = Persson::new((0..count).map(wave), |_| stiffness).unwrap();
            assert_relative_eq!(theory.mean_gap(pressure, GAMMA), wanted, max_relative = 1e-5);
        }
    }
}

#[test]
fn spectra_that_cannot_be_have_no_theory() {
    let half_space = |q: f64| 0.5 * q;
    assert!(Persson::new([], half_space).is_none());
    assert!(Persson::new([(1.0, 0.0)], half_space).is_none());
    assert!(Persson::new([(1.0, 1.0), (2.0, f64::NAN)], half_space).is_none());
    assert!(Persson::new([(1.0, -1.0)], half_space).is_none());
    assert!(Persson::new([(0.0, 1.0)], half_space).is_none());
    assert!(Persson::new([(1.0, 1.0)], |_| 0.0).is_none());
    assert!(Persson::new([(1.0, 1.0), (1.0001, 2.0), (3.0, 0.0)], half_space).is_some());
}

/// 2π divided by the wavelength 1/n and the wavenumber 2πn differ in the last digit for some n. A wave of exactly that
/// length must always count.
#[test]
fn a_cut_at_a_wavelength_includes_the_waves_of_that_length() {
    let tau = std::f64::consts::TAU;
    let theory = Persson::new((1..=200).map(|n| (tau * f64::from(n), 1.0)), |_| 1.0).unwrap();
    for n in 1..=200 {
        let wavelength = 1.0 / f64::from(n);
        assert_eq!(theory.variance(tau / wavelength), f64::from(n), "wavelength 1/{n}");
        assert_eq!(theory.variance(tau / (1.001 * wavelength)), f64::from(n - 1), "wavelength 1.001/{n}");
    }
}

#[test]
fn a_wave_next_to_others_is_seen_from_its_own_length_on() {
    let tau = std::f64::consts::TAU;
    // Waves along an axis, and (n, 1), (n, 2), (n, 3), which are shorter by less than the width of a shell.
    for n in [4, 10, 50, 400] {
        let numbers = (0..4).map(|m: u32| f64::from(n * n + m * m).sqrt());
        let theory = Persson::new(numbers.clone().map(|number| (tau * number, 1.0)), |_| 1.0).unwrap();
        for (index, number) in numbers.enumerate() {
            assert_eq!(theory.variance(tau / (1.0 / number)), (index + 1) as f64, "({n}, {index})");
            assert_eq!(theory.variance(tau * number * (1.0 - 1e-9)), index as f64, "below ({n}, {index})");
        }
    }
}

/// Limits of a far surface, k/(Y + M), of a long jump, and a plain sum of the same integral at a moderate distance.
#[test]
fn the_gas_between_gaussian_heights_has_its_limits() {
    let of = |jump: f64, mean_gap: f64| gaussian_gap_conductance(&GapGas { conductivity: 0.026, jump }, 0.5, mean_gap);
    assert!((of(0.1, 500.0) / (0.026 / 500.1) - 1.0).abs() < 2e-6);
    let above = 0.5 * libm::erfc(-3.0 / std::f64::consts::SQRT_2);
    assert!((of(1e6, 1.5) / (0.026 / 1e6 * above) - 1.0).abs() < 2e-6);
    for [jump, mean_gap] in [[0.2, 1.5], [0.01, 1.0], [3.0, 0.0]] {
        let steps = 2_000_000;
        let width = (mean_gap + 4.5) / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|step| (f64::from(step) + 0.5) * width)
            .map(|g| (-2.0 * (g - mean_gap).powi(2)).exp() / (g + jump))
            .sum();
        let wanted = 0.026 * sum * width / (0.5 * std::f64::consts::TAU.sqrt());
        assert!((of(jump, mean_gap) / wanted - 1.0).abs() < 1e-8, "{jump} {mean_gap}");
    }
}
