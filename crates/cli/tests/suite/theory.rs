//! `theory` from end to end.

use crate::common::{gfmd, json};

#[test]
fn theories_are_those_of_the_surface_and_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let run = |more: &str| {
        let flags = format!("theory --n 128 --hurst 0.8 --p-star 0.02,0.4 --json --quiet {more}");
        json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>())
    };
    let report = run("--wavelength 100,0.25,1e-6 --plots t");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // V = (E* g/2)², a_r = erf(√2 p*): 0.0319 at p* = 0.02.
    assert!((number(&report["full_contact_deviation"]) / (0.5 * number(&report["rms_gradient"])) - 1.0).abs() < 1e-5);
    let load = &report["loads"][0];
    assert!((number(&load["persson"]["area_fraction"]) - 0.031_906_6).abs() < 1e-6, "{load}");
    let seen: Vec<f64> =
        load["persson"]["at_wavelength"].as_array().unwrap().iter().map(|at| number(&at["area_fraction"])).collect();
    assert!(seen[0] == 1.0, "{seen:?}");
    assert!(seen[0] > seen[1], "{seen:?}");
    assert!(seen[1] > seen[2], "{seen:?}");
    assert_eq!(seen[2], number(&load["persson"]["area_fraction"]));
    for theory in ["bush_gibson_thomas", "greenwood_williamson", "self_affine"] {
        let kappa = number(&load[theory]["area_fraction"]) / 0.02;
        assert!((0.8..2.5).contains(&kappa), "{theory}: {kappa}");
    }
    assert!(number(&load["persson"]["mean_gap"]) > number(&report["loads"][1]["persson"]["mean_gap"]));
    assert_eq!(report["plots"].as_array().unwrap().len(), 6);
    for plot in report["plots"].as_array().unwrap() {
        assert!(folder.path().join(plot.as_str().unwrap()).metadata().unwrap().len() > 1000, "{plot}");
    }
    // A thin slab is stiffer; theories of half-spaces have no number there.
    let slab = run("--height 0.02 --poisson 0.45");
    assert!(number(&slab["full_contact_deviation"]) > number(&report["full_contact_deviation"]));
    assert!(slab["loads"][0]["bush_gibson_thomas"].is_null() && slab["loads"][0]["self_affine"].is_null());
}

/// Waves of exactly the given length are seen and shorter ones are not, independent of the last digit of the length.
#[test]
fn a_wave_of_exactly_the_length_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let seen = |lengths: [f64; 3], flags: &str| {
        let [a, b, c] = lengths;
        let line = format!("theory --n 128 --p-star 0.02 --json --quiet --wavelength {a:?},{b:?},{c:?} {flags}");
        let report = json(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
        let areas = report["loads"][0]["persson"]["at_wavelength"].as_array().unwrap();
        areas.iter().map(|at| at["area_fraction"].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    for length in [0.5, 0.25, 0.1, 0.05] {
        let areas = seen([length * (1.0 + 1e-9), length, length * (1.0 - 1e-9)], "--dim 2");
        assert!(areas[0] > areas[1] && areas[1] == areas[2], "{length}: {areas:?}");
    }
    // Cut-offs of the generator at 0.1 and 0.25, in exact numbers: the wave there is part of the surface.
    for (flags, longest, shortest) in [
        ("--eps-t-inv 10 --eps-f-inv 3", 0.1, 1.0 / 30.0),
        ("--eps-t-inv 4 --eps-f-inv 2.5", 0.25, 0.1),
        ("--eps-t-inv 1 --eps-f-inv 10", 1.0, 0.1),
        ("--eps-t-inv 4 --eps-f-inv 2.5 --roll-off 0.25", 0.25, 0.1),
        ("--eps-t-inv 4 --eps-f-inv 2.5 --roll-off 0.1", 0.25, 0.1),
        ("--eps-t-inv 10 --eps-f-inv 3 --roll-off 0.1", 0.1, 1.0 / 30.0),
        ("--eps-t-inv 10 --eps-f-inv 3 --roll-off 0.1 --roll-off-shape smooth", 0.1, 1.0 / 30.0),
    ] {
        for dim in ["--dim 2", "--dim 3"] {
            let flags = format!("{flags} {dim}");
            let first = seen([longest * (1.0 + 1e-9), longest, shortest * 0.5], &flags);
            assert!(first[0] == 1.0 && first[1] < 1.0, "{flags}: {first:?}");
            let last = seen([shortest * (1.0 + 1e-9), shortest, shortest * 0.5], &flags);
            assert!(last[0] > last[1] && last[1] == last[2], "{flags}: {last:?}");
        }
    }
}

/// Theories end with their assumptions and give the reason; the formula for endless spectra has no roll-off.
#[test]
fn theories_beyond_their_range_have_no_number_and_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| {
        let flags = format!("theory --n 64 --json --quiet {flags}");
        json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>())
    };
    let report = run("--p-star 0.02,0.1,1,1.1,1.3,3,1e35");
    let reason = |load: &serde_json::Value, name: &str| {
        let all = load["undefined"].as_object().into_iter().flatten();
        all.filter(|(_, names)| names.as_array().unwrap().iter().any(|other| other == name)).count()
    };
    for load in report["loads"].as_array().unwrap() {
        let p_star = load["p_star"].as_f64().unwrap();
        for (name, most) in [("bush_gibson_thomas", 0.5), ("greenwood_williamson", 0.5), ("self_affine", 1.0)] {
            let area = load[name]["area_fraction"].as_f64();
            assert!(area.is_none_or(|area| area <= most), "{name}: {load}");
            assert_eq!(usize::from(area.is_none()), reason(load, name), "{name}: {load}");
            assert!(area.is_some() || (p_star > 0.1 && name != "self_affine"), "{name}: {load}");
        }
        let counted = load["self_affine"]["counted"].as_f64();
        assert!(counted.is_none_or(|area| area <= 1.0 && p_star <= 1.2), "{load}");
        assert_eq!(usize::from(counted.is_none()), reason(load, "self_affine.counted"), "{load}");
        assert!(counted.is_some() || p_star > 0.1, "{load}");
    }
    let load = &report["loads"][5];
    assert!(["bush_gibson_thomas", "greenwood_williamson"].iter().all(|name| load[name].is_null()), "{load}");
    for shape in ["plateau", "smooth"] {
        let report = run(&format!("--p-star 0.1 --eps-t-inv 1 --roll-off 0.25 --roll-off-shape {shape}"));
        let load = &report["loads"][0];
        assert!(load["self_affine"].is_null() && reason(load, "self_affine") == 1, "{load}");
    }
}

/// The mean gap grows by the same length with each decade of the load, down to the smallest pressures.
#[test]
fn the_smallest_loads_have_a_mean_gap_and_smaller_ones_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let loads = "theory --n 16 --eps-f-inv 4 --p-star 1e-100,1e-200,1e-300 --json --quiet";
    let report = json(folder.path(), &loads.split(' ').collect::<Vec<_>>());
    let [a, b, c] = [0, 1, 2].map(|load| report["loads"][load]["persson"]["mean_gap"].as_f64().unwrap());
    assert!(a > 0.0 && ((c - b) / (b - a) - 1.0).abs() < 1e-9, "{a} {b} {c}");
    for (flags, part) in [
        ("--p-star 1e-309", "--p-star is"),
        ("--p-star 1e-322", "--p-star is"),
        ("--p-star 5e-324", "--p-star is"),
        ("--p-star 1e-300 --e-star 1e-20", "--p-star is"),
        ("--p-star 1e300 --e-star 1e20", "--p-star is"),
    ] {
        let words = format!("theory --n 16 --eps-f-inv 4 {flags}");
        let output = gfmd(folder.path(), &words.split(' ').collect::<Vec<_>>());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(part), "{flags}: {message}");
    }
}

#[test]
fn unusable_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    ndarray_npy::write_npy(folder.path().join("flat.npy"), &ndarray::Array2::<f64>::zeros((16, 16))).unwrap();
    for (flags, part) in [
        ("--p-star 0.1,0", "--p-star is 0; it must be positive"),
        ("--pressure 0.1,-1", "--pressure is -1; it must be positive"),
        ("--n 16 --dim 2 --force 1", "--force is given; it must be left out of a profile"),
        ("--p-star nan", "--p-star is NaN; it must be positive"),
        ("--wavelength=-1", "--wavelength is -1; it must be positive"),
        ("--surface flat.npy", "flat.npy is flat"),
    ] {
        let mut arguments = vec!["theory"];
        arguments.extend(flags.split(' '));
        let output = gfmd(folder.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{flags}: {message}");
        assert!(
            message.contains(part) && message.lines().filter(|line| line.starts_with("error")).count() == 1,
            "{message}"
        );
    }
}

/// Pressures and forces, with units, are the reduced pressures that they make.
#[test]
fn pressures_and_forces_are_loads_like_reduced_pressures() {
    let folder = tempfile::tempdir().unwrap();
    let run = |loads: &str| {
        let flags = format!("theory --n 64 --unit um --size 100um --young 70GPa {loads} --json --quiet");
        json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>())
    };
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let wanted = run("--p-star 0.05");
    let pressure = number(&wanted["loads"][0]["mean_pressure"]);
    for loads in [format!("--pressure {:?}MPa", 1e-6 * pressure), format!("--force {:?}mN", 1e-5 * pressure)] {
        let found = run(&loads);
        for place in ["/loads/0/p_star", "/loads/0/mean_pressure", "/loads/0/persson/area_fraction"] {
            let [one, other] = [&found, &wanted].map(|report| number(report.pointer(place).unwrap()));
            assert!((one / other - 1.0).abs() < 1e-12, "{loads} {place}");
        }
    }
    assert_eq!(run("")["loads"].as_array().unwrap().len(), 6);
}
