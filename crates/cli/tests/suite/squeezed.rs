//! A slab between two surfaces from end to end: flags in, numbers out, recorded, read back, resumed, refused.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &words(flags))
}

const SLAB: &str = "contact --n 32 --eps-f-inv 4 --height 0.1 --poisson 0.3";

#[test]
fn both_faces_are_recorded_recomputed_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let flags = "--layer 2,0.4,0.05 --lower-seed 2 --p-star 0.02,0.1 --plots s --out s.h5 --json";
    let report = run(folder, &format!("{SLAB} {flags}"));
    assert!(report["lower"]["surface"].as_str().unwrap().contains("seed 2"), "{}", report["lower"]);
    assert!((report["lower"]["rms_gradient"].as_f64().unwrap() - 0.1).abs() < 1e-12);
    for load in report["loads"].as_array().unwrap() {
        let number = |value: &Value| value.as_f64().unwrap();
        let lower = &load["lower"];
        assert!((number(&lower["mean_pressure"]) / number(&load["mean_pressure"]) - 1.0).abs() < 1e-12);
        assert!(number(&lower["area_fraction"]) > 0.01 && number(&lower["approach"]) < number(&load["approach"]));
        for key in ["complementarity", "penetration", "negative_pressure", "load"] {
            let (larger, own) = (number(&load["residual"][key]), number(&lower["residual"][key]));
            assert!(own <= larger && larger <= 1e-8, "{key}");
        }
        assert!(load["stiffness"].as_f64().is_some_and(|found| found > 0.0) && load["converged"] == true);
    }
    let file = Reader::open(folder.join("s.h5")).unwrap();
    assert_eq!(file.shape("/fields/lower_gap").unwrap(), [2, 32, 32]);
    let [u, v]: [Vec<f64>; 2] =
        ["displacement_z", "lower_displacement_z"].map(|name| file.slab(&format!("/fields/{name}"), 1).unwrap());
    let mean = |field: &[f64]| field.iter().sum::<f64>() / field.len() as f64;
    assert!(mean(&v) > 0.0 && (mean(&u) + mean(&v)).abs() < 1e-9 * mean(&v), "{} {}", mean(&u), mean(&v));
    let heights: Vec<f64> = file.values("/lower/height").unwrap();
    let gap: Vec<f64> = file.slab("/fields/lower_gap", 1).unwrap();
    let approach = file.values::<f64>("/loads/lower_approach").unwrap()[1];
    let highest = heights.iter().copied().fold(f64::MIN, f64::max);
    // The lower face rises by u_z, and the lower surface by its part of the approach.
    let worst = (0..gap.len()).map(|k| (gap[k] - (highest - heights[k] + v[k] - approach)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst}");
    for name in ["s-map.svg", "s-lower-map.svg", "s-lower-map.png", "s-area.svg"] {
        assert!(folder.join(name).exists(), "{name}");
    }
    assert_eq!(run(folder, "check s.h5 --json")["differing"], 0);
    assert_eq!(run(folder, "check s.h5 --rerun --json")["differing"], 0);
    assert!(gfmd(folder, &words("report s.h5 --out page.html")).status.success());
    let inside = gfmd(folder, &words("body --surface s.h5 --depths 0.01"));
    assert_eq!(inside.status.code(), Some(2));
    let text = String::from_utf8_lossy(&inside.stderr).into_owned();
    assert!(text.contains("two surfaces"), "{text}");
}

#[test]
fn a_hardness_limits_both_faces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let hard = Array2::from_shape_fn((32, 32), |(i, j)| if (i + j) % 5 == 0 { 0.05 } else { 0.15 });
    ndarray_npy::write_npy(folder.join("hard.npy"), &hard).unwrap();
    for (name, hardness, held) in [("n", "0.1", ""), ("f", "hard.npy", ""), ("h", "0.1", "--components held")] {
        let flags = format!("--lower-seed 2 --hardness {hardness} {held} --p-star 0.05,0.4 --plots {name}");
        let report = run(folder, &format!("{SLAB} {flags} --out {name}.h5 --json"));
        let file = Reader::open(folder.join(format!("{name}.h5"))).unwrap();
        for (index, load) in report["loads"].as_array().unwrap().iter().enumerate() {
            let number = |value: &Value| value.as_f64().unwrap();
            let lower = &load["lower"];
            let worst = number(&load["residual"]["saturation"]);
            assert!(number(&lower["residual"]["saturation"]) <= worst && worst <= 1e-8);
            for (face, of) in [("", load), ("lower_", lower)] {
                let field = |name: &str| file.slab::<f64>(&format!("/fields/{face}{name}"), index).unwrap();
                let (pressure, depth, gap) = (field("pressure"), field("plastic_depth"), field("gap"));
                let most = |k: usize| if hardness == "0.1" { 0.1 } else { hard[[k / 32, k % 32]] };
                let full = (0..1024).filter(|k| pressure[*k] >= most(*k) * (1.0 - 1e-12)).count();
                assert!((number(&of["plastic_fraction"]) * 1024.0 - full as f64).abs() < 1e-9 && full > 0, "{face}");
                let volume = depth.iter().sum::<f64>() / 1024.0;
                assert!((number(&of["plastic_volume"]) - volume).abs() < 1e-12 * volume, "{face}");
                assert!(
                    (0..1024).all(|k| pressure[k] <= most(k) * (1.0 + 1e-12) && (depth[k] == 0.0 || gap[k] == 0.0))
                );
            }
        }
        for face in ["", "lower-"] {
            assert!(folder.join(format!("{name}-{face}section.svg")).exists());
        }
        assert_eq!(run(folder, &format!("check {name}.h5 --rerun --json"))["differing"], 0, "{name}");
        assert!(gfmd(folder, &words(&format!("report {name}.h5 --out {name}.html"))).status.success());
        let table = gfmd(folder, &words(&format!("{SLAB} {}", flags.replace(&format!("--plots {name}"), ""))));
        let text = String::from_utf8(table.stdout).unwrap();
        let below = text.split("lower face").nth(1).unwrap();
        assert!(below.contains("plastic"), "{text}");
    }
}

#[test]
fn a_surface_from_a_file_is_that_surface() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [first, second] = [1, 2].map(|seed| {
        let name = format!("h{seed}.h5");
        let made = gfmd(folder, &words(&format!("surface --n 32 --eps-f-inv 4 --seed {seed} --out {name}")));
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        format!("{name}:/surface/height")
    });
    let generated = run(folder, &format!("{SLAB} --lower-seed 2 --approach 0.02 --json"));
    for flags in [
        format!("{SLAB} --lower-surface {second}"),
        format!("contact --height 0.1 --poisson 0.3 --size 1 --surface {first} --lower-surface {second}"),
    ] {
        let read = run(folder, &format!("{flags} --approach 0.02 --out f.h5 --json"));
        for (key, face) in [("mean_pressure", ""), ("area_fraction", "lower")] {
            let of = |report: &Value| {
                let load = &report["loads"][0];
                (if face.is_empty() { &load[key] } else { &load[face][key] }).as_f64().unwrap()
            };
            assert!((of(&read) / of(&generated) - 1.0).abs() < 1e-9, "{key}");
        }
        assert_eq!(run(folder, "check f.h5 --rerun --json")["differing"], 0);
        assert_eq!(Reader::open(folder.join("f.h5")).unwrap().text("/lower", "file").unwrap(), "h2.h5");
        std::fs::remove_file(folder.join("f.h5")).unwrap();
    }
}

#[test]
fn a_file_has_the_fields_that_were_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (fields, names) in [
        ("lower_pressure,pressure", &["lower_pressure", "pressure"][..]),
        ("lower_gap", &["lower_gap"]),
        ("displacement_z,lower_displacement_z", &["displacement_z", "lower_displacement_z"]),
    ] {
        run(folder, &format!("{SLAB} --lower-seed 3 --p-star 0.01,0.05 --fields {fields} --out f.h5 --json"));
        let file = Reader::open(folder.join("f.h5")).unwrap();
        let is_field = |name: &String| file.shape(&format!("/fields/{name}")).unwrap().len() == 3;
        assert!(file.names("/fields").into_iter().filter(is_field).eq(names.iter().copied()), "{fields}");
        drop(file);
        let check = gfmd(folder, &words("check f.h5"));
        let text = String::from_utf8_lossy(&check.stderr).into_owned();
        assert!(
            check.status.success() && text.contains("has no /fields/") != fields.contains("lower_pressure"),
            "{text}"
        );
        assert_eq!(run(folder, "check f.h5 --rerun --json")["differing"], 0, "{fields}");
    }
}

/// Loads with a law at both faces, and paths with a law, a hardness, or a wall alone, are recorded, recomputed and
/// continued.
#[test]
fn a_law_acts_at_both_faces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law = "--law exponential --param gamma=2e-5,range=2e-3";
    let slab = SLAB.strip_prefix("contact ").unwrap();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    for (name, flags) in [
        ("a", format!("contact {slab} {law} --p-star 0.02,0.1 --plots a")),
        ("b", format!("contact {slab} {law} --components held --hardness 0.2 --approach 0.01,0.02")),
        ("c", format!("contact {slab} --law morse --param gamma=2e-5,range=4e-3 --p-star 0.05")),
        ("d", format!("path {slab} {law} --approach 0.015,0.02,0.015 --steps 2")),
        ("e", format!("path {slab} {law} --hardness 0.1 --p-star 0.05,0.3,0.05 --steps 2")),
        ("f", format!("path {slab} --hardness 0.1 --p-star 0.05,0.3,0.05 --steps 2")),
        ("g", format!("path {slab} --p-star 0.05,0.1 --steps 2 --plots g")),
    ] {
        let report = run(folder, &format!("{flags} --lower-seed 2 --out {name}.h5 --json"));
        let states = report.get("loads").or_else(|| report.get("steps")).and_then(Value::as_array).unwrap();
        for state in states {
            assert_eq!(state["converged"], true, "{flags}");
            let lower = &state["lower"];
            let apart = number(&lower["mean_pressure"]) - number(&state["mean_pressure"]);
            assert!(apart.abs() < 1e-9 * number(&lower["max_pressure"]), "{flags}: {apart}");
            assert!(number(&lower["area_fraction"]) > 0.0 && number(&lower["approach"]) < number(&state["approach"]));
            assert!(number(&state["stiffness"]) > 0.0, "{flags}: {}", state["stiffness"]);
            assert!(lower.get("residual").is_none());
        }
        assert_eq!(run(folder, &format!("check {name}.h5 --json"))["differing"], 0, "{flags}");
        assert!(gfmd(folder, &words(&format!("report {name}.h5 --out {name}.html"))).status.success());
    }
    let file = Reader::open(folder.join("e.h5")).unwrap();
    let depth: Vec<f64> = file.values("/fields/lower_plastic_depth").unwrap();
    assert!(depth.iter().any(|depth| *depth > 0.0));
    assert_eq!(run(folder, "check e.h5 --rerun --json")["differing"], 0);
    // A wall alone on a path is the wall under loads.
    let path = run(folder, &format!("path {slab} --p-star 0.1 --steps 1 --lower-seed 2 --json"));
    let loads = run(folder, &format!("contact {slab} --p-star 0.1 --lower-seed 2 --json"));
    for key in ["approach", "mean_gap", "area_fraction", "elastic_energy"] {
        let (found, wanted) = (number(&path["steps"][0][key]), number(&loads["loads"][0][key]));
        assert!((found / wanted - 1.0).abs() < 1e-6, "{key}: {found} {wanted}");
    }
}

/// A slab that relaxes and wears at both faces, with each part alone and with all of them, is recorded, recomputed and
/// continued.
#[test]
fn both_faces_have_histories() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let slab = SLAB.strip_prefix("contact ").unwrap();
    let (law, prony) = ("--law exponential --param gamma=2e-5,range=2e-3", "--prony 0.1:0.3,10:0.4 --time 0,1,9");
    let wear = "--coefficient 0.2 --distance 0,0.1,0.4";
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    for (name, flags) in [
        ("a", prony.to_owned()),
        ("incompressible", format!("{prony} --poisson 0.5")),
        ("b", wear.to_owned()),
        ("c", format!("{prony} {wear} --hardness 0.2")),
        ("d", format!("{prony} {wear} {law} --plots d")),
    ] {
        let slab = if flags.contains("--poisson") { "--n 32 --eps-f-inv 4 --height 0.1" } else { slab };
        let run_it = format!("path {slab} {flags} --p-star 0.05,0.1,0.1 --steps 2 --lower-seed 2");
        let report = run(folder, &format!("{run_it} --out {name}.h5 --json"));
        let steps = report["steps"].as_array().unwrap();
        for step in steps {
            assert_eq!(step["converged"], true, "{flags}");
            let lower = &step["lower"];
            let apart = number(&lower["mean_pressure"]) - number(&step["mean_pressure"]);
            assert!(apart.abs() < 1e-8 * number(&lower["max_pressure"]), "{flags}: {apart}");
            // Without attraction, an equal mean pressure wears off an equal volume.
            let worn = [step, lower].map(|face| number(&face["wear_volume"]));
            assert_eq!(worn[0].is_nan(), !flags.contains("--coefficient"), "{flags}");
            let is_equal = (worn[0] - worn[1]).abs() <= 1e-8 * worn[0];
            assert!(worn[0].is_nan() || flags.contains("--law") || is_equal, "{flags}: {worn:?}");
            assert!(step.get("max_wear").is_none() || step["max_wear"] != lower["max_wear"] || worn[0] == 0.0);
        }
        if flags.contains("--prony") {
            let file = Reader::open(folder.join(format!("{name}.h5"))).unwrap();
            for (face, sign) in [("", -1.0), ("lower_", 1.0)] {
                let memory: Vec<f64> = file.values(&format!("/history/{face}displacement")).unwrap();
                let last: Vec<f64> = file.slab(&format!("/fields/{face}displacement_z"), 2).unwrap();
                assert!(memory.iter().zip(&last).all(|(d, u)| (d - sign * u).abs() <= 1e-15), "{flags}: {face}");
                assert_eq!(file.shape(&format!("/history/{face}branch")).unwrap()[0], 2);
            }
            // At a constant load the approach grows while the slab relaxes.
            assert!(number(&steps[4]["approach"]) > number(&steps[2]["approach"]), "{flags}");
        }
        assert_eq!(run(folder, &format!("check {name}.h5 --rerun --json"))["differing"], 0, "{flags}");
        assert!(gfmd(folder, &words(&format!("report {name}.h5 --out {name}.html"))).status.success());
    }
}

#[test]
fn what_does_not_go_together_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ndarray_npy::write_npy(folder.join("other.npy"), &Array2::<f64>::zeros((16, 16))).unwrap();
    ndarray_npy::write_npy(folder.join("flat.npy"), &Array2::<f64>::zeros((32, 32))).unwrap();
    let slab = format!("{SLAB} --p-star 0.1");
    let with = format!("{slab} --lower-seed 2");
    for (flags, named) in [
        ("contact --n 32 --eps-f-inv 4 --p-star 0.1 --lower-seed 2".to_owned(), ["--height", "--lower-seed"]),
        (format!("{with} --base sliding"), ["--base", "sliding"]),
        (format!("{with} --second-body 1,0.3"), ["--second-body", "--lower-seed"]),
        (format!("{with} --law exponential --param gamma=1e-5,range=1e-3 --solver fire2"), ["--solver", "newton"]),
        (format!("{} --friction 0.3", with.replace("contact", "path")), ["--friction", "--lower-seed"]),
        (
            format!("{} --prony 1:0.5 --time 1 --relaxes shear", with.replace("contact", "path")),
            ["--lower-seed", "--relaxes"],
        ),
        (format!("{with} --hardness 1e-3"), ["0.001", "hardness"]),
        (format!("{with} --components all"), ["--components", "--lower-seed"]),
        (format!("{with} --finite-slope"), ["--finite-slope", "--lower-seed"]),
        (format!("{with} --boundary free"), ["--boundary", "periodic"]),
        (format!("{with} --base-displacement flat.npy"), ["--base-displacement", "--lower-seed"]),
        (format!("{with} --solver verlet"), ["--solver", "preconditioned-cg"]),
        (format!("{with} --lower-surface flat.npy"), ["--lower-surface", "--lower-seed"]),
        (format!("{slab} --lower-surface other.npy"), ["--lower-surface", "16 x 16"]),
        (format!("{slab} --lower-surface missing.npy"), ["missing.npy", ""]),
        (format!("{slab} --out x.h5 --fields lower_gap"), ["--fields", "--lower-surface"]),
        (
            "contact --surface flat.npy --height 0.1 --pressure 0.1 --lower-surface flat.npy".to_owned(),
            ["flat.npy", "equal"],
        ),
        (
            "contact --surface flat.npy --height 0.1 --pressure 0.1 --lower-seed 2".to_owned(),
            ["--lower-seed", "--surface"],
        ),
    ] {
        let output = gfmd(folder, &words(&flags));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
        assert!(named.iter().all(|word| text.contains(word)), "{flags}: {text}");
        assert!(output.stdout.is_empty(), "{flags}");
    }
    // A flat surface below is a base.
    let report = run(folder, &format!("{slab} --lower-surface flat.npy --json"));
    assert_eq!(report["lower"]["rms_height"], 0.0);
}

/// Between equal surfaces, both halves of a slab are one slab of half the height on a base that slides.
#[test]
fn patches_and_flow_of_the_upper_face_are_those_of_half_the_slab() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "surface --n 32 --eps-f-inv 4 --out h.h5 --json");
    let measured = "--statistics --flow --flow-threshold --p-star 0.05,0.6 --tolerance 1e-10 --surface h.h5 --json";
    let whole = run(folder, &format!("contact --height 0.2 --lower-surface h.h5 {measured} --out whole.h5"));
    let half = run(folder, &format!("contact --height 0.1 --base sliding {measured}"));
    let number = |value: &Value| value.as_f64().unwrap();
    for load in 0..2 {
        let [a, b] = [&whole, &half].map(|report| &report["loads"][load]);
        for name in ["count", "largest_fraction", "percolates"] {
            assert_eq!(a["patches"][name], b["patches"][name], "{name}");
        }
        let [a, b] = [a, b].map(|load| number(&load["conductance"]));
        assert!((a / b - 1.0).abs() < 1e-6, "{a} and {b}");
    }
    for axis in [0, 1] {
        let [a, b] = [&whole, &half].map(|report| number(&report["flow_threshold"][axis]["p_star"][0]));
        assert!((a / b - 1.0).abs() < 1e-3, "{a} and {b}");
    }
    let [a, b] = [&whole, &half].map(|report| number(&report["loads"][0]["flow"]["conductivity"][0][0]));
    assert!((a / b - 1.0).abs() < 1e-4 && a > 0.0, "{a} and {b}");
    assert_eq!(run(folder, "check whole.h5 --json")["differing"], 0);
    let along = "path --surface h.h5 --height 0.2 --lower-surface h.h5 --p-star 0.05 --steps 1 --flow --json";
    let on_path = number(&run(folder, along)["steps"][0]["flow"]["conductivity"][0][0]);
    assert!((on_path / a - 1.0).abs() < 1e-4, "{on_path} and {a}");
}
