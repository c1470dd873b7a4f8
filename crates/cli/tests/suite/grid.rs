//! Grid error of the numbers, from end to end.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_field::Grid;
use gfmd_record::reason_for;
use gfmd_surface::SelfAffine;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    assert_eq!(output.status.code(), Some(2), "{flags}");
    String::from_utf8(output.stderr).unwrap()
}

/// Returns a number, its limit and the error of the limit.
fn limit(load: &Value, name: &str) -> [f64; 3] {
    ["", "_limit", "_limit_error"].map(|end| load[format!("{name}{end}")].as_f64().unwrap_or(f64::NAN))
}

const NAMES: [&str; 6] =
    ["area_fraction", "mean_gap", "approach", "elastic_energy", "stiffness", "mean_pressure_in_contact"];

/// Checks that the numbers of a load on two grids agree within their errors.
fn agree(problem: &str, [coarse, fine]: [&Value; 2], names: &[&str], factor: f64) {
    for name in names {
        let ([_, a, of_a], [_, b, of_b]) = (limit(coarse, name), limit(fine, name));
        assert!((a - b).abs() <= factor * (of_a + of_b), "{problem}: {name} {a} ± {of_a} and {b} ± {of_b}");
    }
}

#[test]
fn a_finer_grid_tells_the_error_of_all_bodies_interactions_and_boundaries() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (problem, names) in [
        ("", &NAMES[..]),
        ("--height 0.2 --poisson 0.3", &NAMES),
        ("--height 0.1 --base sliding --poisson 0.4", &NAMES),
        ("--components held --poisson 0.2", &NAMES),
        ("--hardness 0.1", &NAMES),
        ("--law exponential --param gamma=1e-6 --param range=4e-3", &["mean_gap", "area_fraction", "approach"]),
    ] {
        let run = |n: usize, how: &str| {
            let flags = format!(
                "contact --n {n} --eps-f-inv 6 --pressure 0.01 --seed 5 {problem} --grid-error {how} --json -q"
            );
            json(path, &words(&flags))
        };
        let (plain, refined, fine) = (run(48, "none"), run(48, "refine"), run(192, "refine"));
        // The numbers themselves belong to the requested grid.
        assert_eq!(plain["loads"][0]["area_fraction"], refined["loads"][0]["area_fraction"], "{problem}");
        assert!(plain["loads"][0].get("area_fraction_limit").is_none() && plain.get("grid_error").is_none());
        let reported = &refined["grid_error"];
        assert_eq!((&reported["mode"], &reported["assumes"]), (&"refine".into(), &"band-limited".into()), "{problem}");
        assert_eq!(
            (&reported["n"], &reported["orders"]["area_fraction"]),
            (&serde_json::json!([96, 96]), &1.6.into()),
            "{problem}"
        );
        agree(problem, [&refined["loads"][0], &fine["loads"][0]], names, 1.5);
        let [area, of_limit, error] = limit(&refined["loads"][0], "area_fraction");
        // With a law the error is 2.5 times the difference between both grids.
        let most = if problem.contains("law") { 0.2 } else { 0.1 };
        assert!(error < most * of_limit && error > 0.0, "{problem}: {area} {of_limit} {error}");
    }
}

#[test]
fn between_the_points_of_a_scan_two_interpolations_tell_what_is_not_known() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = 1_u64;
    let rough = ndarray::Array2::from_shape_fn((64, 64), |(i, j)| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise = (random >> 11) as f64 / (1_u64 << 53) as f64;
        0.05 * (0.2 * i as f64).sin() * (0.2 * j as f64).cos() + 0.02 * noise
    });
    ndarray_npy::write_npy(folder.path().join("scan.npy"), &rough).unwrap();
    let scan = "contact --surface scan.npy --size 1 --p-star 0.05 --json -q";
    let one = json(folder.path(), &words(scan));
    assert_eq!(one["grid_error"]["assumes"], "nothing rougher than the pixels");
    let reason = reason_for(&one["loads"][0], "area_fraction_limit").unwrap();
    assert!(reason.contains("what lies between the points decides"), "{reason}");
    assert!(one["loads"][0]["stiffness_limit"].is_number(), "what hardly depends on it has a limit");
    let two = json(folder.path(), &words(&format!("{scan} --grid-error refine")));
    let [_, limit, error] = limit(&two["loads"][0], "area_fraction");
    // White noise: a quarter of the area lies between both interpolations.
    assert!(error > 0.05 * limit, "{limit} {error}");
    let patch = json(folder.path(), &words(&format!("{scan} --grid-error refine --boundary free")));
    let [_, _, error] = self::limit(&patch["loads"][0], "area_fraction");
    assert!(error > 0.0, "{error}");
    let reported = refused(folder.path(), &format!("{scan} --accuracy 1%"));
    assert!(reported.contains("the heights between the points are unknown"), "{reported}");
}

#[test]
fn the_grid_is_made_finer_until_all_numbers_are_as_exact_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let flags = "contact --n 48 --eps-f-inv 6 --p-star 0.05,0.2 --statistics --accuracy 2% --json -q --out a.h5";
    let found = json(path, &words(flags));
    let grids = found["accuracy"]["grids"].as_array().unwrap();
    assert!(grids.len() > 1 && grids[0]["n"] == serde_json::json!([48, 48]), "{grids:?}");
    assert_eq!(grids.last().unwrap()["n"], found["n"]);
    assert!(grids.last().unwrap()["error"].as_f64().unwrap() <= 0.02, "{grids:?}");
    for load in found["loads"].as_array().unwrap() {
        for name in NAMES {
            let [_, limit, error] = limit(load, name);
            assert!(error <= 0.02 * limit, "{name}: {limit} {error}");
        }
    }
    // The file holds the last grid, as its configuration states.
    for again in ["check a.h5", "check a.h5 --rerun"] {
        assert!(gfmd(path, &words(again)).status.success(), "{again}");
    }
    // A scan with resolved waves is interpolated by waves.
    let grid = Grid::square(48, 1.0).unwrap();
    let waves = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 0.1,
        ..SelfAffine::with_rms_gradient(0.1)
    };
    let smooth = waves.heights(&grid, 3).unwrap();
    ndarray_npy::write_npy(path.join("smooth.npy"), &smooth).unwrap();
    let flags = "contact --surface smooth.npy --size 1 --p-star 0.1 --accuracy 0.02 --json -q --out s.h5";
    let found = json(path, &words(flags));
    assert!(found["n"][0].as_u64().unwrap() > 48 && found["accuracy"]["grids"].as_array().unwrap().len() > 1);
    assert!(gfmd(path, &words("check s.h5 --rerun")).status.success());
}

/// Writes heights as a function of the place in the cell, at points offset from its corner by this part of a step.
fn write(path: &Path, n: usize, offset: f64, height: impl Fn(f64, f64) -> f64) {
    let at = |i: usize| (i as f64 + offset) / n as f64;
    let heights = ndarray::Array2::from_shape_fn((n, n), |(i, j)| height(at(i), at(j)));
    ndarray_npy::write_npy(path, &heights).unwrap();
}

/// The contact edges of equal waves cut the links of the grid at the same places, and the edges of stripes at one
/// place.
#[test]
fn contacts_that_are_alike_have_wider_errors_and_stripes_none() {
    let folder = tempfile::tempdir().unwrap();
    let (path, tau) = (folder.path(), std::f64::consts::TAU);
    let egg = |n: usize, offset: f64| {
        write(&path.join("egg.npy"), n, offset, |x, y| 0.01 * (tau * 2.0 * x).cos() * (tau * 2.0 * y).cos());
        json(path, &words("contact --surface egg.npy --size 1 --pressure 0.002,0.006 --json -q"))
    };
    let exact = egg(256, 0.0);
    let names =
        ["area_fraction", "mean_gap", "approach", "elastic_energy", "stiffness", "pressure_moment_2", "max_pressure"];
    for offset in [0.0, 0.3, 0.5] {
        let coarse = egg(36, offset);
        for load in [0, 1] {
            agree("egg box", [&coarse["loads"][load], &exact["loads"][load]], &names, 1.0);
        }
        let reason = reason_for(&coarse["loads"][0], "boundary_links_limit").unwrap();
        assert!(reason.contains("the surface has 2.0 waves"), "{reason}");
    }
    write(&path.join("wave.npy"), 32, 0.0, |x, _| 0.01 * (tau * x).cos());
    for how in ["estimate", "refine"] {
        let flags = format!("contact --surface wave.npy --size 1 --pressure 0.005 --grid-error {how} --json -q");
        let load = json(path, &words(&flags))["loads"][0].take();
        let reason = reason_for(&load, "area_fraction_limit").unwrap();
        assert!(reason.contains("slopes that differ by a factor of at most 2"), "{reason}");
    }
    let reported = refused(path, "contact --surface wave.npy --size 1 --pressure 0.005 --accuracy 1%");
    assert!(reported.contains("the surface has 1.0 waves"), "{reported}");
}

/// Hertz (1882): a sphere of radius R on a half-space with E* = 1, contact radius a.
#[test]
fn the_closed_form_of_a_sphere_is_within_the_errors_of_a_patch() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let press = |n: usize, offset: f64, force: f64| {
        write(&path.join("sphere.npy"), n, offset, |x, y| -0.5 * ((x - 0.5).powi(2) + (y - 0.5).powi(2)));
        let flags = "contact --surface sphere.npy --size 1 --boundary free --young 1 --poisson 0 --json -q";
        json(path, &words(&format!("{flags} --pressure {force}")))["loads"][0].take()
    };
    let a: f64 = 0.2;
    let (force, most) = (4.0 * a.powi(3) / 3.0, 2.0 * a / std::f64::consts::PI);
    let area = std::f64::consts::PI * a * a;
    let exact = [
        ("area_fraction", area),
        ("mean_pressure_in_contact", force / area),
        ("max_pressure", most),
        ("elastic_energy", 0.4 * force * a * a),
        ("stiffness", 2.0 * a),
        ("pressure_moment_2", 0.5 * area * most * most),
    ];
    for (n, offset) in [(32, 0.0), (32, 0.3), (64, 0.5), (96, 0.2)] {
        let load = press(n, offset, force);
        for (name, exact) in exact {
            let [value, of_limit, error] = limit(&load, name);
            assert!((of_limit - exact).abs() <= error, "{n} {offset} {name}: {of_limit} ± {error}, {exact}");
            let bound = load[format!("{name}_grid_error")].as_f64().unwrap();
            assert!((value - exact).abs() <= bound && bound < 0.2 * exact, "{n} {offset} {name}: {value} ± {bound}");
        }
        let reason = reason_for(&load, "approach_limit").unwrap();
        assert!(reason.contains("not measured with free boundaries"), "{reason}");
    }
    let load = press(32, 0.5, 4.0 * 0.6_f64.powi(3) / 3.0);
    let reason = reason_for(&load, "area_fraction_limit").unwrap();
    assert!(reason.contains("contacts reach the rim"), "{reason}");
}

/// Hertz (1882): a cylinder of radius R on a half-space with E* = 1 has the load π a²/(4 R) per length, at the half
/// width a of its contact. Its ends are counted on both grids, which often count alike.
#[test]
fn the_closed_form_of_a_cylinder_is_within_the_errors_of_a_profile() {
    let folder = tempfile::tempdir().unwrap();
    let widths: Vec<f64> = (0..64).map(|i| 0.05 + 0.003 * f64::from(i)).collect();
    let load = |a: &f64| std::f64::consts::PI * a * a / 80.0;
    let loads: Vec<String> = widths.iter().map(|a| load(a).to_string()).collect();
    for n in [64, 250] {
        let flags = format!(
            "contact --shape cylinder:R=20 --dim 2 --n {n} --boundary free --young 1 --poisson 0 --pressure {} \
             --grid-error refine --json -q",
            loads.join(",")
        );
        let report = json(folder.path(), &words(&flags));
        for name in ["area_fraction", "mean_pressure_in_contact"] {
            let (mut outside, mut widest) = (0, 0.0_f64);
            for (a, found) in widths.iter().zip(report["loads"].as_array().unwrap()) {
                let exact = if name == "area_fraction" { 2.0 * a } else { load(a) / (2.0 * a) };
                let [value, of_limit, error] = limit(found, name);
                let bound = found[format!("{name}_grid_error")].as_f64().unwrap();
                outside += usize::from((of_limit - exact).abs() > error || (value - exact).abs() > bound);
                widest = widest.max(error / exact);
            }
            let finest = 0.5 / f64::from(n) / 0.1;
            assert!(outside <= 3 && widest < 8.0 * finest, "{n}, {name}: {outside} outside, {widest}");
        }
    }
}

/// Sneddon (1965): a flat punch of radius a = 1/4, and a cone of slope 0.1 with the contact radius a, on a half-space
/// with E* = 1. Formulas of random surfaces do not know edges; two grids do.
#[test]
fn the_closed_forms_of_shapes_with_edges_are_within_the_errors_by_two_grids() {
    let folder = tempfile::tempdir().unwrap();
    let solved = |shape: &str, forces: &[f64], how: &str| {
        let forces: Vec<String> = forces.iter().map(ToString::to_string).collect();
        let flags = format!(
            "contact --shape {shape} --n 64 --boundary free --young 1 --poisson 0 --pressure {} --grid-error {how} \
             --json -q",
            forces.join(",")
        );
        json(folder.path(), &words(&flags))["loads"].as_array().unwrap().clone()
    };
    let pi = std::f64::consts::PI;
    let force = 5e-4;
    let punch = [
        ("area_fraction", pi / 16.0),
        ("approach", 2.0 * force),
        ("stiffness", 0.5),
        ("elastic_energy", force * force),
        ("mean_pressure_in_contact", 16.0 * force / pi),
    ];
    let radii: Vec<f64> = (0..16).map(|i| 0.08 + 0.01 * f64::from(i)).collect();
    let forces: Vec<f64> = radii.iter().map(|a| 0.05 * pi * a * a).collect();
    let cone = |a: f64| [("area_fraction", pi * a * a), ("approach", 0.05 * pi * a), ("stiffness", 2.0 * a)];
    let outside = |load: &Value, (name, exact): (&str, f64)| {
        let [value, of_limit, error] = limit(load, name);
        let bound = load[format!("{name}_grid_error")].as_f64().unwrap();
        usize::from((of_limit - exact).abs() > error || (value - exact).abs() > bound)
    };
    let load = &solved("flat-punch:a=0.25,depth=0.02", &[force], "refine")[0];
    assert_eq!(punch.map(|known| outside(load, known)), [0; 5]);
    let loads = solved("cone:slope=0.1", &forces, "refine");
    let found = loads.iter().zip(&radii).map(|(load, a)| cone(*a).map(|known| outside(load, known)));
    let found = found.fold([0; 3], |sum: [usize; 3], one| std::array::from_fn(|i| sum[i] + one[i]));
    assert!(found.iter().sum::<usize>() <= 2, "of 16 each: {found:?}");
    assert!(reason_for(load, "max_pressure_limit").unwrap().contains("has edges"));
    let load = &solved("flat-punch:a=0.25,depth=0.02", &[force], "estimate")[0];
    for (name, _) in punch {
        let reason = reason_for(load, &format!("{name}_limit")).unwrap();
        assert!(reason.contains("waves shorter than four points"), "{name}: {reason}");
    }
}

#[test]
fn a_path_on_a_finer_grid_tells_the_error_of_the_pull_off_and_of_each_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let law = "--law exponential --param gamma=1e-6 --param range=4e-3";
    let pull = |n: usize, how: &str| {
        let flags = "--approach=-0.003,0.002,-0.008 --steps 12 --energy-solves 0 --seed 3 --json -q";
        json(path, &words(&format!("path --n {n} --eps-f-inv 4 {law} {flags} --grid-error {how} --out {how}{n}.h5")))
    };
    let (one, two, exact) = (pull(24, "estimate"), pull(24, "refine"), pull(96, "none"));
    assert_eq!(one["lowest_mean_pressure"], two["lowest_mean_pressure"], "the numbers are those of the grid asked for");
    assert!(one.get("lowest_mean_pressure_limit").is_none() && exact["steps"][0].get("area_fraction_limit").is_none());
    let reason = reason_for(&one["steps"][0], "mean_pressure_limit").unwrap();
    assert!(reason.contains("not with a law"), "{reason}");
    let lowest = limit(&two, "lowest_mean_pressure");
    let found = exact["lowest_mean_pressure"].as_f64().unwrap();
    assert!(found < 0.0, "{lowest:?} {found}");
    assert!((lowest[1] - found).abs() <= lowest[2], "{lowest:?} {found}");
    assert!(lowest[2] < 0.5 * found.abs(), "{lowest:?} {found}");
    // The approach counts from the top of the surface, which lies above the points.
    let step = &two["steps"][12];
    let [approach, top, _] = limit(step, "approach");
    assert!(top > approach && top - approach < 1e-3, "{approach} {top}");
    for again in ["check refine24.h5", "check refine24.h5 --rerun", "check estimate24.h5", "report refine24.h5"] {
        assert!(gfmd(path, &words(again)).status.success(), "{again}");
    }
    // Steps of a wall under loads are contacts: they have the same limits.
    let flags = "--n 48 --eps-f-inv 6 --seed 5 --json -q --p-star";
    let steps = json(path, &words(&format!("path {flags} 0.02,0.1 --steps 1")));
    let loads = json(path, &words(&format!("contact {flags} 0.02,0.1")));
    for (step, load) in [0, 1].map(|k| (&steps["steps"][k], &loads["loads"][k])) {
        for name in ["area_fraction", "mean_gap", "approach", "elastic_energy"] {
            let ([_, a, of_a], [_, b, of_b]) = (limit(step, name), limit(load, name));
            assert!(
                (a - b).abs() < 1e-6 * b && (of_a - of_b).abs() < 1e-3 * of_b,
                "{name}: {a} ± {of_a}, {b} ± {of_b}"
            );
        }
    }
}

#[test]
fn what_cannot_be_made_finer_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let contact = "contact --n 32 --p-star 0.05";
    for (flags, wanted) in [
        (format!("{contact} --accuracy 2"), "a relative error from 1e-6 to 0.5"),
        (format!("{contact} --accuracy 1% --grid-error refine"), "cannot be used with"),
        (format!("{contact} --accuracy 1% --law morse --param gamma=1e-5,range=0.01"), "not with a law"),
        (format!("{contact} --accuracy 1% --method rmd"), "--accuracy"),
        ("contact --n 32 --approach 0.001 --accuracy 1%".into(), "the approach counts from the highest point"),
        (format!("{contact} --grid-error refine --method rmd"), "--method is rmd"),
        (format!("{contact} --refine 2"), "--surface"),
        (format!("{contact} --boundary free --accuracy 1%"), "the rim of a patch moves with the grid"),
    ] {
        let reported = refused(folder.path(), &flags);
        assert!(reported.contains(wanted), "{flags}: {reported}");
    }
}

/// The limits from two grids contain the numbers of a grid eight times finer, where one grid has no formula.
#[test]
fn profiles_steep_surfaces_and_two_faces_have_limits_from_two_grids() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, n) in [
        ("--dim 2 --eps-f-inv 8 --hurst 0.8", 64),
        ("--finite-slope --rms-gradient 0.1 --eps-t-inv 2 --eps-f-inv 4 --hurst 0.8", 32),
        ("--lower-seed 7 --height 0.3 --eps-t-inv 2 --eps-f-inv 4 --hurst 0.8", 32),
    ] {
        let of = |n: u32, more: &str| {
            let flags = format!("contact --n {n} {flags} --p-star 0.1 --json {more}");
            json(folder.path(), &words(&flags))["loads"][0].clone()
        };
        let (two, exact) = (of(n, "--grid-error refine"), of(8 * n, ""));
        for name in ["mean_gap", "elastic_energy"] {
            let [value, limit, error] = limit(&two, name);
            let exact = exact[name].as_f64().unwrap();
            assert!((limit - exact).abs() <= error && error < 0.1 * value, "{flags} {name}: {limit} {error} {exact}");
        }
    }
}

/// Points of a patch are the centres of equal cells on both grids: a sphere keeps its place and its force.
#[test]
fn a_patch_has_limits_from_two_grids() {
    let folder = tempfile::tempdir().unwrap();
    let written = |n: usize| {
        let sphere = |i: usize| -0.5 * ((i as f64 + 0.5) / n as f64 - 0.47).powi(2);
        let heights = ndarray::Array2::from_shape_fn((n, n), |(i, j)| sphere(i) + sphere(j));
        ndarray_npy::write_npy(folder.path().join(format!("{n}.npy")), &heights).unwrap();
    };
    [32, 256].into_iter().for_each(written);
    let of = |n: usize, more: &str| {
        let flags = format!("contact --surface {n}.npy --size 1 --boundary free --young 1 --poisson 0 --json {more}");
        json(folder.path(), &words(&flags))["loads"][0].clone()
    };
    let (two, exact) = (of(32, "--pressure 0.005 --grid-error refine"), of(256, "--pressure 0.005"));
    for name in ["approach", "mean_gap", "elastic_energy", "max_pressure", "area_fraction"] {
        let [value, limit, error] = limit(&two, name);
        let exact = exact[name].as_f64().unwrap();
        assert!((limit - exact).abs() <= error && error < 0.2 * value, "{name}: {limit} {error} {exact}");
    }
    // The same approach leads to the same place on both grids.
    let two = of(32, "--approach 0.02 --grid-error refine");
    let [value, limit, error] = limit(&two, "mean_pressure");
    assert!((value - limit).abs() < 0.05 * value && error < 0.1 * value, "{value} {limit} {error}");
}

/// A prescribed number has no limit. The pressure at an approach has a limit with a valid error: the top of the surface
/// lies above the highest point of its grid.
#[test]
fn at_a_prescribed_approach_the_pressure_has_the_grid_error() {
    let folder = tempfile::tempdir().unwrap();
    let load = |n: u32| {
        let n = n.to_string();
        let flags = ["contact", "--n", &n, "--eps-f-inv", "8", "--approach", "0.006", "--json"];
        json(folder.path(), &flags)["loads"][0].clone()
    };
    let number = |load: &Value, key: &str| load[key].as_f64().unwrap_or_else(|| panic!("{key} of {load}"));
    let fine = number(&load(512), "mean_pressure_limit");
    for n in [64, 128] {
        let load = load(n);
        assert!(load.get("approach_limit").is_none(), "{load}");
        let [value, limit, error] =
            ["mean_pressure", "mean_pressure_limit", "mean_pressure_limit_error"].map(|key| number(&load, key));
        assert!((limit - fine).abs() < error && (value - fine).abs() > 10.0 * error, "{n}: {value} {limit} {error}");
    }
    let output = gfmd(folder.path(), &["contact", "--n", "64", "--eps-f-inv", "8", "--approach", "0.006"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains(" 6.0000e-3 "));
}

/// Two half-spaces deform like one with their contact modulus, and have the same grid errors.
#[test]
fn a_pair_of_half_spaces_has_the_grid_error_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let load = |body: &str| {
        let flags = format!("contact --n 64 --eps-f-inv 8 --p-star 0.05 --statistics --json {body}");
        json(folder.path(), &flags.split(' ').collect::<Vec<_>>())["loads"][0].clone()
    };
    let (pair, one) = (load("--young 1 --poisson 0 --second-body 1,0"), load("--e-star 0.5"));
    for (key, value) in one.as_object().unwrap().iter().filter(|(key, _)| key.contains("_limit")) {
        let [found, expected] = [&pair[key], value].map(Value::as_f64);
        match (found, expected) {
            (Some(found), Some(expected)) => {
                assert!((found / expected - 1.0).abs() < 1e-6, "{key}: {found} {expected}")
            }
            _ => assert_eq!(found, expected, "{key}"),
        }
    }
    assert!(pair["area_fraction_limit"].is_number());
}

/// The finer grid finds its own threshold of the flow; the thresholds on both grids give the limit and its error.
#[test]
fn a_finer_grid_tells_the_error_of_the_threshold_of_a_flow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = |n: usize, more: &str| {
        let flags = format!(
            "contact --n {n} --eps-f-inv 8 --hurst 0.8 --seed 4 --p-star 0.05,1.2 --flow-threshold --json -q {more}"
        );
        json(path, &words(&flags))["flow_threshold"].clone()
    };
    let refined = run(32, "--grid-error refine --out c.h5");
    let [plain, fine] = [32, 64].map(|n| run(n, "--grid-error none"));
    let file = gfmd_files::Reader::open(path.join("c.h5")).unwrap();
    for axis in 0..2 {
        for name in ["p_star", "mean_pressure", "area_fraction", "area_fraction_corrected", "mean_gap", "approach"] {
            let sides = |of: &Value| [0, 1].map(|side| of[axis][name][side].as_f64().unwrap());
            assert_eq!(refined[axis][name], plain[axis][name], "{name}");
            assert!(plain[axis].get(format!("{name}_limit")).is_none());
            let ([a, b], [c, d]) = (sides(&plain), sides(&fine));
            let (coarse, fine) = (0.5 * (a + b), 0.5 * (c + d));
            let number = |end: &str| refined[axis][format!("{name}_{end}")].as_f64().unwrap();
            let [limit, error, grid_error] = ["limit", "limit_error", "grid_error"].map(number);
            if name != "approach" {
                approx::assert_relative_eq!(limit, fine, max_relative = 1e-6);
                let expected = 2.5 * (fine - coarse).abs() + 0.5 * (d - c).abs();
                approx::assert_relative_eq!(error, expected, max_relative = 1e-4);
            }
            // An approach counts from the top of the surface, above the highest points of both grids.
            assert!((limit - fine).abs() <= 0.05 * fine && error >= 0.5 * (d - c).abs(), "{name}");
            approx::assert_relative_eq!(grid_error, (coarse - limit).abs() + error, max_relative = 1e-12);
            for (end, number) in [("limit", limit), ("limit_error", error), ("grid_error", grid_error)] {
                let stored = file.values::<f64>(&format!("/flow_threshold/{name}_{end}")).unwrap();
                assert_eq!((stored.len(), stored[axis]), (2, number), "{name}_{end}");
            }
        }
    }
    drop(file);
    for flags in ["check c.h5", "check c.h5 --rerun"] {
        let output = gfmd(path, &words(flags));
        assert!(output.status.success(), "{flags}: {}", String::from_utf8_lossy(&output.stdout));
    }
    // The gap stays open: no threshold on either grid, and a warning.
    let flags = "contact --n 32 --eps-f-inv 8 --p-star 0.01,0.02 --flow-threshold --grid-error refine --json -q";
    let open = json(path, &words(flags));
    assert!(open["flow_threshold"][0].is_null());
    let warnings = open["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning["code"] == "flow-threshold"));
}
