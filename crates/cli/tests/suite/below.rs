//! Bodies with a surface level that has no stiffness: every stress has the mean of the surface, for every kind of
//! result; and numbers that depend on the level.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use gfmd_record::reason_for;
use ndarray::{Array2, Array3};
use serde_json::Value;

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &flags.split_whitespace().collect::<Vec<_>>())
}

/// Returns the error line of a command that must be refused.
fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &flags.split_whitespace().collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(2), "{flags}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

const SURFACE: &str = "--n 16 --eps-f-inv 4 --seed 3";
const BODY: &str = "--young 1 --poisson 0.3";

/// Returns the traction [xz, yz, zz] (a line: [xz, zz]) on the surface of a result, as stored; missing components are
/// 0.
fn tractions(file: &Reader) -> Vec<Vec<f64>> {
    if file.contains("/fields/traction") {
        let traction: Vec<f64> = file.values("/fields/traction").unwrap();
        let components = *file.shape("/fields/traction").unwrap().last().unwrap();
        return (0..components).map(|c| traction.iter().skip(c).step_by(components).copied().collect()).collect();
    }
    let shape = file.shape("/fields/pressure").unwrap();
    let pressure: Vec<f64> = file.slab("/fields/pressure", shape[0] - 1).unwrap();
    let shear = |name: &str| -> Vec<f64> {
        let path = format!("/fields/{name}");
        if file.contains(&path) { file.slab(&path, shape[0] - 1).unwrap() } else { vec![0.0; pressure.len()] }
    };
    let normal = pressure.iter().map(|p| -p).collect();
    if shape[2] == 1 { vec![shear("shear_x"), normal] } else { vec![shear("shear_x"), shear("shear_y"), normal] }
}

/// At every depth, σ_xz and σ_zz have the mean of the surface. At the surface, σ_zz is the pressure at each point, so
/// that open points bear none.
#[test]
fn the_mean_traction_of_every_result_is_borne_at_every_depth() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let base = Array3::from_shape_fn((16, 16, 3), |(i, j, c)| 0.004 * ((i + 3 * j + c) as f64 * 0.7).sin() + 0.001);
    ndarray_npy::write_npy(folder.join("base.npy"), &base).unwrap();
    let contact = |flags: &str| format!("contact {SURFACE} {BODY} --p-star 0.05,0.3 {flags}");
    let path = |flags: &str| format!("path {SURFACE} {BODY} --p-star 0.3 --steps 2 {flags}");
    for (made, depths) in [
        (contact(""), "0,0.3,1"),
        (format!("contact --dim 2 --n 64 --eps-f-inv 16 {BODY} --p-star 0.05,0.3"), "0,0.3,1"),
        (contact("--components held"), "0,0.3,1"),
        (contact("--components all"), "0,0.3,1"),
        (contact("--hardness 0.06"), "0,0.3,1"),
        (contact("--law exponential --param gamma=1e-4,range=4e-3"), "0,0.3,1"),
        (contact("--finite-slope --rms-gradient 0.2"), "0,0.3,1"),
        (contact("--finite-slope --rms-gradient 0.2 --height 0.3"), "0,0.1,0.3"),
        (contact("--second-body 3,0.2"), "0,0.3,1"),
        (contact("--second-body 3,0.2,0.2"), "0,0.3,1"),
        (contact("--height 0.3 --second-body 3,0.2"), "0,0.1,0.3"),
        (contact("--height 0.1 --base half-space --base-young 5 --base-poisson 0.2"), "0,0.1,1"),
        (contact("--height 0.3"), "0,0.1,0.3"),
        (format!("contact {SURFACE} --young 1 --poisson 0.5 --height 0.3 --p-star 0.2"), "0,0.1,0.3"),
        (
            format!("contact {SURFACE} --young 1 --poisson 0.5 --height 0.3 --p-star 0.2 --base-displacement base.npy"),
            "0,0.1,0.3",
        ),
        (contact("--height 0.3 --base-displacement base.npy"), "0,0.1,0.3"),
        (contact("--height 0.3 --base-displacement base.npy --components all"), "0,0.1,0.3"),
        (path("--friction 0.3 --lateral 0.003 --height 0.3 --base-displacement base.npy"), "0,0.1,0.3"),
        (path("--friction 0.3 --lateral 0.003"), "0,0.3,1"),
        (path("--friction 0.3 --lateral 0.003 --height 0.3"), "0,0.1,0.3"),
        (
            format!(
                "path {SURFACE} --young 1 --poisson 0.5 --p-star 0.1 --steps 2 --shear-strength 0.05 --lateral 0.003"
            ),
            "0,0.3,1",
        ),
        (path("--hardness 0.06"), "0,0.3,1"),
        (path("--prony 1:0.8 --time 0,2"), "0,0.3,1"),
        (path("--prony 0.1:0.5,3:0.4 --moduli instantaneous --time 0,0.5 --height 0.3"), "0,0.1,0.3"),
        (path("--prony 1:0.8 --time 0,0 --height 0.1 --base half-space --base-young 5 --base-poisson 0.2"), "0,0.1,1"),
        (path("--prony 1:0.8 --time 0,1 --law exponential --param gamma=1e-4,range=4e-3"), "0,0.3,1"),
        (format!("path --dim 2 --n 64 --eps-f-inv 16 {BODY} --p-star 0.3 --time 1 --prony 1:0.8"), "0,0.3,1"),
        (format!("slide {SURFACE} {BODY} --p-star 0.3 --prony 1:0.8 --velocity 0.1,1"), "0,0.3,1"),
        (format!("slide {SURFACE} {BODY} --p-star 0.3 --prony 1:0.8 --velocity 1 --height 0.3"), "0,0.1,0.3"),
        (format!("wear {SURFACE} {BODY} --p-star 0.3 --coefficient 1 --distance 0,0.01 --steps 2"), "0,0.3,1"),
        (
            format!("wear {SURFACE} {BODY} --p-star 0.3 --coefficient 1 --distance 0.01 --steps 2 --height 0.3"),
            "0,0.1,0.3",
        ),
        ("punch --n 16 --height inf".into(), "0,0.3,1"),
        ("punch --n 16 --height inf --contact frictionless".into(), "0,0.3,1"),
        ("punch --n 16 --height inf --shift 0.002,0".into(), "0,0.3,1"),
        ("punch --n 16 --poisson 0.5 --height 0.5".into(), "0,0.1,0.5"),
        ("punch --dim 2 --n 32 --height inf --shift 0.002".into(), "0,0.3,1"),
    ] {
        run(folder, &format!("{made} --out source.h5 --json"));
        let report = run(folder, &format!("body --surface source.h5 --depths {depths} --out below.h5 --json"));
        let [source, below] = ["source.h5", "below.h5"].map(|name| Reader::open(folder.join(name)).unwrap());
        let surface = tractions(&source);
        let components = *below.shape("/fields/stress").unwrap().last().unwrap();
        // Rows xx, yy, zz, yz, xz, xy; for a line xx, zz, xz.
        let (zz, xz) = if components == 4 { (2, 3) } else { (2, 4) };
        let mut shear = mean(&surface[0]);
        if source.contains("/loads/mean_shear_x") {
            shear = source.values::<f64>("/loads/mean_shear_x").unwrap()[1];
            assert!(shear != 0.0);
        }
        let normal = &surface[surface.len() - 1];
        let stress: Vec<f64> = below.values("/fields/stress").unwrap();
        let planes = below.shape("/fields/stress").unwrap()[0];
        // An interface between two layers has two planes.
        assert!(planes >= 3);
        let scale = largest(normal);
        for plane in stress.chunks_exact(stress.len() / planes) {
            let of = |k: usize| plane.iter().skip(k).step_by(components).copied().collect::<Vec<f64>>();
            let [found_zz, found_xz] = [zz, xz].map(|k| mean(&of(k)));
            assert!((found_zz - mean(normal)).abs() < 1e-12 * scale, "{made}: {found_zz} {}", mean(normal));
            assert!((found_xz - shear).abs() < 1e-12 * scale, "{made}: {found_xz} {shear}");
        }
        let top: Vec<f64> = stress.iter().skip(zz).step_by(components).take(normal.len()).copied().collect();
        // Tractions of a path, a law and a punch match the displacement up to the tolerance of their search.
        let is_searched = ["law", "punch"].iter().any(|word| made.contains(word));
        let bound = if is_searched { 1e-6 } else { 1e-11 };
        for (found, wanted) in top.iter().zip(normal) {
            assert!((found - wanted).abs() < bound * scale, "{made}: {found} {wanted}");
        }
        let stated: Vec<f64> = below.values("/fields/mean_traction").unwrap();
        assert!(
            (stated[stated.len() - 1] - mean(normal)).abs() < 1e-12 * scale
                && (stated[0] - shear).abs() < 1e-12 * scale
        );
        assert_eq!(report["mean_traction"], serde_json::json!(stated));
        let check = run(folder, "check below.h5 --json");
        assert_eq!(check["differing"], 0, "{made}: {check}");
    }
}

/// The fields inside meet the displacement of the surface that the contact found, and of the base that moves it.
#[test]
fn a_base_that_moves_is_met_by_the_fields_below_every_surface() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let base = Array3::from_shape_fn((16, 16, 3), |(i, j, c)| 0.004 * ((i + 3 * j + c) as f64 * 0.7).sin() + 0.001);
    ndarray_npy::write_npy(folder.join("base.npy"), &base).unwrap();
    let moved =
        format!("{SURFACE} {BODY} --p-star 0.1 --height 0.3 --base-displacement base.npy --out source.h5 --json");
    for (command, lateral) in [
        ("contact", None),
        ("contact --components all", Some(["displacement_x", "displacement_y"])),
        ("contact --components all --solver verlet", Some(["displacement_x", "displacement_y"])),
        ("contact --components held", Some(["none"; 2])),
        ("path --steps 2 --friction 0.3 --lateral 0.002", None),
    ] {
        run(folder, &format!("{command} {moved}"));
        run(folder, "body --surface source.h5 --depths 0,0.3 --out below.h5 --json");
        let [source, below] = ["source.h5", "below.h5"].map(|name| Reader::open(folder.join(name)).unwrap());
        let inside: Vec<f64> = below.values("/fields/displacement").unwrap();
        let at = |plane: usize, c: usize| -> Vec<f64> {
            inside[plane * 3 * 256..][..3 * 256].iter().skip(c).step_by(3).copied().collect()
        };
        let last = source.shape("/fields/pressure").unwrap()[0] - 1;
        let stored = |name: &str| -> Vec<f64> {
            if name == "none" { vec![0.0; 256] } else { source.slab(&format!("/fields/{name}"), last).unwrap() }
        };
        let mut surface = vec![(2, stored("displacement_z"))];
        surface.extend(lateral.into_iter().flatten().enumerate().map(|(c, name)| (c, stored(name))));
        // The shortest waves of all components depend on the solver.
        let bound = if command.contains("all") { 1e-2 } else { 1e-6 };
        for (c, wanted) in surface {
            for (found, wanted) in at(0, c).iter().zip(&wanted) {
                assert!((found - wanted).abs() < bound * 0.005, "{command}, {c}: {found} {wanted}");
            }
        }
        for c in 0..3 {
            for (i, found) in at(1, c).iter().enumerate() {
                let wanted = base[[i / 16, i % 16, c]];
                assert!((found - wanted).abs() < 1e-12, "{command}, {c} of the base: {found} {wanted}");
            }
        }
        assert_eq!(run(folder, "check source.h5 --rerun --json")["differing"], 0, "{command}");
        assert_eq!(run(folder, "check below.h5 --json")["differing"], 0, "{command}");
    }
}

/// A relaxing body has, initially and after a long time, the stresses of the elastic bodies with its instantaneous and
/// its long-term modulus. Numbers that depend on earlier loads are left out with a reason.
#[test]
fn a_body_that_relaxes_has_the_stress_of_its_pressure() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (height, depths) in [("inf", "0,0.02,1"), ("0.3", "0,0.02,0.3")] {
        let body = |young: f64| format!("path {SURFACE} --young {young} --poisson 0.3 --height {height} --steps 1");
        run(folder, &format!("{} --pressure 0.011 --prony 1:0.8 --time 0,1e9 --out relaxed.h5 --json", body(1.0)));
        let below = |source: &str, load: usize| {
            run(folder, &format!("body --surface {source} --load {load} --depths {depths} --out below.h5 --json"))
        };
        for (load, young) in [(0, 5.0), (1, 1.0)] {
            run(folder, &format!("{} --pressure 0.011 --out elastic.h5 --json", body(young)));
            let fields = || {
                let file = Reader::open(folder.join("below.h5")).unwrap();
                ["/fields/stress", "/fields/von_mises"].map(|name| file.values::<f64>(name).unwrap())
            };
            let expected = (below("elastic.h5", 0), fields()).1;
            let (report, found) = (below("relaxed.h5", load), fields());
            for (found, expected) in found.iter().zip(&expected) {
                let scale = largest(expected);
                let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-5 * scale, "{height} {load}: {apart} of {scale}");
            }
            assert_eq!(report["warnings"][0]["code"], "relaxes", "{report}");
            for level in report["levels"].as_array().unwrap() {
                assert!(level["max_von_mises"].as_f64().unwrap() > 0.0);
                assert!(level["max_displacement"].is_null() && level["mean_energy_density"].is_null(), "{level}");
            }
            let file = Reader::open(folder.join("below.h5")).unwrap();
            for name in ["displacement", "strain", "energy_density"] {
                assert!(!file.contains(&format!("/fields/{name}")), "{name}");
            }
            let check = run(folder, "check below.h5 --rerun --json");
            assert_eq!(check["differing"], 0, "{check}");
        }
    }
    let body = "body --surface relaxed.h5 --depths 0,0.02";
    for (flags, named) in [
        ("--quantities displacement", "--quantities: displacement is not available"),
        ("--quantities stress,energy-density", "--quantities: energy-density is not available"),
        ("--slice y=0 --draw uz", "--draw: uz is not available"),
    ] {
        let text = refused(folder, &format!("{body} {flags}"));
        assert!(text.contains(named) && text.contains("stress and von-mises"), "{flags}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}

/// Where the stress below a contact is unknown, one line says so.
#[test]
fn the_stress_below_a_contact_without_its_traction_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let slide = format!("slide {SURFACE} {BODY} --p-star 0.3 --velocity 1");
    for (made, named) in [
        (format!("{slide} --heat 1,0.01 --friction 0.3"), "the friction of this contact causes a shear traction"),
        (
            format!("{slide} --prony 1:0.8 --heat 1,0.01 --friction 0.3"),
            "the friction of this contact causes a shear traction",
        ),
        (
            format!("path {SURFACE} {BODY} --p-star 0.3 --prony 1:0.8 --relaxes shear --time 1 --steps 1"),
            "the shear modulus of this contact relaxes",
        ),
        (format!("{slide} --prony 1:0.8 --relaxes shear"), "the shear modulus of this contact relaxes"),
    ] {
        run(folder, &format!("{made} --out source.h5 --json"));
        let text = refused(folder, "body --surface source.h5 --depths 0,0.3");
        assert!(text.contains(named) && text.lines().count() == 1, "{made}: {text}");
    }
}

/// Below a deep plane of a half-space, the mean strain energy and the mean von Mises stress equal the values of a
/// laterally confined column, which a high slab approaches.
#[test]
fn a_half_space_is_the_limit_of_high_slabs_also_in_the_mean() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let levels = |height: &str| {
        run(folder, &format!("contact {SURFACE} {BODY} --p-star 1 --height {height} --out c.h5 --json"));
        run(folder, "body --surface c.h5 --depths 0,0.3,2 --json")["levels"].clone()
    };
    let (endless, high) = (levels("inf"), levels("6"));
    for (endless, high) in endless.as_array().unwrap().iter().zip(high.as_array().unwrap()) {
        for key in ["max_von_mises", "mean_energy_density"] {
            let [endless, high] = [endless, high].map(|level| level[key].as_f64().unwrap());
            assert!((endless / high - 1.0).abs() < 1e-6, "{key}: {endless} {high}");
        }
    }
    let pressure = Reader::open(folder.join("c.h5")).unwrap().values::<f64>("/loads/mean_pressure").unwrap()[0];
    // (1 - 2 nu)/(1 - nu) p, and (1 + nu)(1 - 2 nu)/(1 - nu) p^2/(2 E).
    let deep = &endless[2];
    for (key, wanted) in
        [("max_von_mises", 0.4 / 0.7 * pressure), ("mean_energy_density", 1.3 * 0.4 / 0.7 * 0.5 * pressure * pressure)]
    {
        assert!((deep[key].as_f64().unwrap() / wanted - 1.0).abs() < 1e-3, "{key}: {deep} {wanted}");
    }
}

/// A displacement array does not determine the mean traction of a half-space: it is given, or 0 with a warning.
#[test]
fn the_mean_traction_below_an_array_is_given_or_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let profile = Array2::from_shape_fn((32, 2), |(i, c)| 0.01 * ((i + 7 * c) as f64 * 0.3).sin());
    ndarray_npy::write_npy(folder.join("line.npy"), &profile).unwrap();
    let body = |rest: &str| format!("body --surface line.npy {BODY} --depths 0,0.5 {rest} --json");
    let silent = run(folder, &body("--height inf"));
    assert_eq!(silent["warnings"][0]["code"], "mean-traction", "{silent}");
    assert_eq!(silent["mean_traction"], serde_json::json!([0.0, 0.0]));
    let given = run(folder, &body("--height inf --mean-traction=0.02,-0.1 --out given.h5"));
    assert!(given["warnings"].as_array().is_none_or(Vec::is_empty), "{given}");
    let stress: Vec<f64> = Reader::open(folder.join("given.h5")).unwrap().slab("/fields/stress", 1).unwrap();
    let of = |k: usize| mean(&stress.iter().skip(k).step_by(4).copied().collect::<Vec<f64>>());
    assert!((of(2) + 0.1).abs() < 1e-12 && (of(3) - 0.02).abs() < 1e-12, "{} {}", of(2), of(3));
    assert_eq!(run(folder, "check given.h5 --json")["differing"], 0);
    for (flags, named) in [
        ("--height inf --mean-traction=0.1", "--mean-traction is [0.1]; it must be 2 numbers, x and z"),
        ("--height 0.6 --mean-traction=0,5", "--mean-traction: the mean traction along x is 0"),
        ("--height inf --mean-traction=nan,0", "--mean-traction"),
    ] {
        let text = refused(folder, &body(flags));
        assert!(text.contains(named) && text.lines().count() == 1, "{flags}: {text}");
    }
    run(folder, &format!("contact {SURFACE} {BODY} --p-star 0.1 --out c.h5 --json"));
    let text = refused(folder, "body --surface c.h5 --depths 0 --mean-traction=0,0,-0.1");
    assert!(text.contains("--mean-traction") && text.contains("left out"), "{text}");
}

/// With a moving base, p*, the rms gradient, the rms height and kappa refer to the displaced surface: they equal the
/// numbers of the contact of that surface with the base at rest.
#[test]
fn over_a_base_that_moves_all_numbers_are_of_the_displaced_surface() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let wave = Array2::from_shape_fn((16, 16), |(i, _)| 0.03 * (std::f64::consts::TAU * i as f64 / 16.0).cos());
    ndarray_npy::write_npy(folder.join("base.npy"), &wave).unwrap();
    let body = "--young 1 --poisson 0.3 --height 0.2 --p-star 0.02,0.2";
    let moved = run(folder, &format!("contact {SURFACE} {body} --base-displacement base.npy --out c.h5 --json"));
    let reader = Reader::open(folder.join("c.h5")).unwrap();
    let [height, lift] = ["/surface/height", "/base/lift"].map(|name| reader.values::<f64>(name).unwrap());
    let sum = height.iter().zip(&lift).map(|(h, lift)| h + lift).collect();
    ndarray_npy::write_npy(folder.join("sum.npy"), &Array2::from_shape_vec((16, 16), sum).unwrap()).unwrap();
    let rest = run(folder, &format!("contact --surface sum.npy --size 1 {body} --json"));
    let same = |a: &Value, b: &Value, what: &str| {
        let [a, b] = [a, b].map(|value| value.as_f64().unwrap_or_else(|| panic!("{what} {value}")));
        assert!((a - b).abs() < 1e-7 * b.abs(), "{what}: {a} {b}");
    };
    for key in ["rms_gradient", "rms_height", "max_slope"] {
        same(&moved[key], &rest[key], key);
    }
    for (moved, rest) in moved["loads"].as_array().unwrap().iter().zip(rest["loads"].as_array().unwrap()) {
        for key in ["p_star", "mean_pressure", "kappa", "area_fraction", "max_pressure", "mean_gap"] {
            same(&moved[key], &rest[key], key);
        }
    }
    assert_eq!(run(folder, "check c.h5 --rerun --json")["differing"], 0);
    let text = refused(folder, &format!("contact {SURFACE} {body} --base-displacement base.npy --boundary free"));
    assert!(text.contains("--boundary is free; it must be periodic with --base-displacement"), "{text}");
}

/// Returns the names of the null columns of a load and checks that each has a reason.
fn nulls(load: &Value) -> Vec<String> {
    let all = load.as_object().unwrap().iter();
    let null: Vec<String> = all.filter(|(_, value)| value.is_null()).map(|(key, _)| key.clone()).collect();
    for key in &null {
        assert!(reason_for(load, key).is_some_and(|reason| reason.len() > 10), "{key} of {load}");
    }
    null
}

/// The displacement of a profile on a half-space grows with the logarithm of the distance. It counts from points one
/// length of the profile away: a prescribed approach and a load that gives it are one state, and the energy stored by a
/// path is the work done.
#[test]
fn a_profile_on_a_half_space_has_an_approach_and_an_energy() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = "--dim 2 --n 32 --eps-f-inv 8 --boundary free --young 1 --poisson 0.3 --tolerance 1e-10";
    for action in ["", "--hardness 0.05", "--law morse --param gamma=1e-3,range=0.03"] {
        let load = run(folder, &format!("contact {line} {action} --p-star 0.1 --out c.h5 --json"))["loads"][0].clone();
        assert_eq!(run(folder, "check c.h5 --rerun --json")["differing"], 0, "{action}");
        let number = |load: &Value, key: &str| load[key].as_f64().unwrap_or_else(|| panic!("{key} of {load}"));
        let approach = number(&load, "approach");
        let back = run(folder, &format!("contact {line} {action} --approach {approach} --json"))["loads"][0].clone();
        for key in ["mean_pressure", "elastic_energy", "stiffness"] {
            let [found, wanted] = [&back, &load].map(|load| number(load, key));
            assert!((found - wanted).abs() < 1e-6 * wanted.abs(), "{action}: {key} {found} {wanted}");
        }
        let steps = run(folder, &format!("path {line} {action} --approach {approach} --steps 2 --out p.h5 --json"));
        let last = steps["steps"].as_array().unwrap().last().unwrap();
        let [found, wanted] = [last, &load].map(|load| number(load, "mean_pressure"));
        assert!((found - wanted).abs() < 1e-6 * wanted.abs(), "{action}: {found} {wanted}");
        assert_eq!(run(folder, "check p.h5 --rerun --json")["differing"], 0, "{action}");
    }
    // The work of a body that relaxes is stored or lost; the balance closes with the square of the increment.
    let imbalance = [8, 16].map(|steps| {
        let flags = format!("path {line} --prony 1:0.5 --approach 0.02,0.02 --time 1,3 --steps {steps} --json");
        let path = run(folder, &flags);
        let steps = path["steps"].as_array().unwrap();
        steps.iter().map(|step| step["work_imbalance"].as_f64().unwrap().abs()).sum::<f64>()
            / steps.iter().map(|step| step["dissipated"].as_f64().unwrap()).sum::<f64>()
    });
    assert!(imbalance[1] < 0.4 * imbalance[0] && imbalance[0] < 0.05, "{imbalance:?}");
}

/// Every missing stiffness has a reason.
#[test]
fn every_stiffness_without_a_value_has_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (flags, reason) = ("--p-star 9", "full contact");
    let load = run(folder, &format!("contact {SURFACE} {flags} --out c.h5 --json"))["loads"][0].clone();
    let found = nulls(&load);
    assert!(found.contains(&"stiffness".to_owned()) && found.contains(&"stiffness_error".to_owned()), "{found:?}");
    assert!(reason_for(&load, "stiffness").unwrap().contains(reason), "{load}");
    let reader = Reader::open(folder.join("c.h5")).unwrap();
    assert!(reader.values::<f64>("/loads/stiffness").unwrap()[0].is_nan());
    assert!(reader.text("/loads/stiffness", "undefined").unwrap().contains(reason));
    assert_eq!(run(folder, "check c.h5 --rerun --json")["differing"], 0);
    let load = run(folder, &format!("contact {SURFACE} --p-star 0.1 --json"))["loads"][0].clone();
    let of_the_grid = |name: &String| name.contains("_limit") || name.ends_with("_grid_error");
    assert!(nulls(&load).iter().all(of_the_grid) && load["stiffness"].is_number());
}

/// The program and its check solve the same contact in units of its own size: every number agrees to the last bit.
#[test]
fn the_check_poses_the_contact_of_the_program_in_any_unit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let reduced = |flags: &str, young: f64, length: f64| -> Vec<f64> {
        let flags = format!("contact {SURFACE} --young {young:e} --size {length:e} {flags} --out c.h5 --json");
        let load = run(folder, &flags)["loads"][0].clone();
        let check = run(folder, "check c.h5 --json");
        assert_eq!((&check["differing"], &check["rounded"]), (&0.into(), &0.into()), "{flags}: {check}");
        let of = |key: &str, unit: f64| load[key].as_f64().unwrap_or(f64::NAN) / unit;
        [
            of("area_fraction", 1.0),
            of("mean_pressure", young),
            of("max_pressure", young),
            of("mean_gap", length),
            of("approach", length),
            of("elastic_energy", young * length),
        ]
        .into()
    };
    for flags in [
        "--p-star 0.05",
        "--p-star 0.05 --components held",
        "--p-star 0.05 --components all",
        "--p-star 0.05 --finite-slope",
    ] {
        let wanted = reduced(flags, 1.0, 1.0);
        // Units within the range of the program: E* times the rms gradient is 1e-140 to 1e140.
        for (young, length) in [(1e-130, 1.0), (1e130, 1.0), (1e-60, 1e-60), (1e60, 1e60)] {
            for (found, wanted) in reduced(flags, young, length).iter().zip(&wanted) {
                assert!((found / wanted - 1.0).abs() < 1e-6, "{flags} {young:e} {length:e}: {found} {wanted}");
            }
        }
        for young in ["1e-200", "1e200"] {
            let text = refused(folder, &format!("contact {SURFACE} --young {young} {flags}"));
            assert!(text.contains(&format!("--young is {young}; it must be between 1e-140 and 1e140")), "{text}");
        }
    }
}
