//! The error of the numbers by the grid, from end to end.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_field::Grid;
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

/// A number, its limit and the error of that.
fn limit(load: &Value, name: &str) -> [f64; 3] {
    ["", "_limit", "_limit_error"].map(|end| load[format!("{name}{end}")].as_f64().unwrap_or(f64::NAN))
}

const NAMES: [&str; 6] =
    ["area_fraction", "mean_gap", "displacement", "elastic_energy", "stiffness", "mean_pressure_in_contact"];

/// The numbers of a load on a grid and on another grid agree within their errors.
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
        ("--law exponential --param gamma=1e-6 --param range=4e-3", &["mean_gap", "area_fraction", "displacement"]),
    ] {
        let run = |n: usize, how: &str| {
            let flags = format!(
                "contact --n {n} --eps-f-inv 6 --pressure 0.01 --seed 5 {problem} --grid-error {how} --json -q"
            );
            json(path, &words(&flags))
        };
        let (plain, refined, fine) = (run(48, "none"), run(48, "refine"), run(192, "refine"));
        // The numbers themselves are those of the grid that is asked for.
        assert_eq!(plain["loads"][0]["area_fraction"], refined["loads"][0]["area_fraction"], "{problem}");
        assert!(plain["loads"][0].get("area_fraction_limit").is_none() && plain.get("grid_error").is_none());
        let told = serde_json::json!({ "mode": "refine", "n": [96, 96], "assumes": "band-limited" });
        assert_eq!(refined["grid_error"], told, "{problem}");
        agree(problem, [&refined["loads"][0], &fine["loads"][0]], names, 1.5);
        let [area, of_limit, error] = limit(&refined["loads"][0], "area_fraction");
        assert!(error < 0.1 * of_limit && error > 0.0, "{problem}: {area} {of_limit} {error}");
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
    let scan = "contact --surface scan.npy --length 1 --p-star 0.05 --json -q";
    let one = json(folder.path(), &words(scan));
    assert_eq!(one["grid_error"]["assumes"], "nothing rougher than the pixels");
    let reason = one["loads"][0]["undefined"]["area_fraction_limit"].as_str().unwrap();
    assert!(reason.contains("what lies between the points decides"), "{reason}");
    assert!(one["loads"][0]["stiffness_limit"].is_number(), "what hardly depends on it has a limit");
    let two = json(folder.path(), &words(&format!("{scan} --grid-error refine")));
    let [_, limit, error] = limit(&two["loads"][0], "area_fraction");
    // White noise: a quarter of the area lies between the two ways.
    assert!(error > 0.05 * limit, "{limit} {error}");
    let told = refused(folder.path(), &format!("{scan} --grid-error refine --boundary free"));
    assert!(told.contains("it must be none or estimate with --boundary free"), "{told}");
    let told = refused(folder.path(), &format!("{scan} --accuracy 1%"));
    assert!(told.contains("what lies between the points is not known"), "{told}");
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
    // The file is that of the last grid, which its configuration asks for.
    for again in ["check a.h5", "check a.h5 --rerun"] {
        assert!(gfmd(path, &words(again)).status.success(), "{again}");
    }
    // A scan whose waves are resolved is interpolated by them.
    let grid = Grid::square(48, 1.0).unwrap();
    let waves = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 0.1,
        ..SelfAffine::with_rms_gradient(0.1)
    };
    let smooth = waves.heights(&grid, 3).unwrap();
    ndarray_npy::write_npy(path.join("smooth.npy"), &smooth).unwrap();
    let flags = "contact --surface smooth.npy --length 1 --p-star 0.1 --accuracy 0.02 --json -q --out s.h5";
    let found = json(path, &words(flags));
    assert!(found["n"][0].as_u64().unwrap() > 48 && found["accuracy"]["grids"].as_array().unwrap().len() > 1);
    assert!(gfmd(path, &words("check s.h5 --rerun")).status.success());
}

/// The edges of a single wave's contact all cut the links of the grid at one place: nothing averages out.
#[test]
fn a_surface_of_few_waves_has_no_error_that_averages_out() {
    let folder = tempfile::tempdir().unwrap();
    let wave =
        ndarray::Array2::from_shape_fn((32, 32), |(i, _)| 0.01 * (std::f64::consts::TAU * i as f64 / 32.0).cos());
    ndarray_npy::write_npy(folder.path().join("wave.npy"), &wave).unwrap();
    for how in ["estimate", "refine"] {
        let flags = format!("contact --surface wave.npy --length 1 --pressure 0.005 --grid-error {how} --json -q");
        let load = json(folder.path(), &words(&flags))["loads"][0].take();
        let reason = load["undefined"]["area_fraction_limit"].as_str().unwrap();
        assert!(reason.contains("the surface has 1.0 waves"), "{reason}");
    }
    let told = refused(folder.path(), "contact --surface wave.npy --length 1 --pressure 0.005 --accuracy 1%");
    assert!(told.contains("the surface has 1.0 waves"), "{told}");
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
        ("contact --n 32 --displacement 0.001 --accuracy 1%".into(), "the approach counts from the highest point"),
        ("contact --n 32 --displacement 0.001 --grid-error refine".into(), "--grid-error is refine"),
        (format!("{contact} --grid-error refine --dim 2"), "--grid-error is refine"),
        (format!("{contact} --grid-error refine --finite-slope"), "--grid-error is refine"),
        (format!("{contact} --grid-error refine --method rmd"), "--method is rmd"),
        (format!("{contact} --refine 2"), "--surface"),
    ] {
        let told = refused(folder.path(), &flags);
        assert!(told.contains(wanted), "{flags}: {told}");
    }
}
