//! Free boundaries with laws, friction and layers from end to end: flags in, numbers out, recorded, checked, resumed,
//! refused.

use std::path::Path;

use crate::common::{gfmd, json};
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &words(flags))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

const SURFACE: &str = "--n 24 --eps-f-inv 4 --boundary free";

/// Runs a command, checks its file, and repeats it from its file.
fn is_sound(folder: &Path, flags: &str) -> Value {
    let report = run(folder, &format!("{flags} --out f.h5 --json"));
    for check in ["check f.h5 --json", "check f.h5 --rerun --json"] {
        assert_eq!(run(folder, check)["differing"], 0, "{flags}");
    }
    assert!(gfmd(folder, &words("report f.h5 --out f.html")).status.success());
    report
}

#[test]
fn attraction_and_layers_on_a_patch_are_recorded_and_recomputed() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--law exponential --param gamma=1e-4,range=4e-3";
    for flags in [
        format!("contact {SURFACE} {law} --p-star 0.05,0.01 --statistics"),
        format!("contact {SURFACE} {law} --approach 0.005,-0.001"),
        format!("contact {SURFACE} {law} --p-star 0.02 --height 0.2 --base sliding"),
        format!(
            "contact {SURFACE} --p-star 0.02,0.1 --height 0.2 --layer 3,0.4,0.1 --base half-space --base-young 2 \
             --base-poisson 0.2"
        ),
        format!("contact {SURFACE} --approach 0.01 --height 0.2 --second-body 3,0.4,0.3 --hardness 0.1"),
    ] {
        let report = is_sound(folder.path(), &flags);
        for load in report["loads"].as_array().unwrap() {
            assert_eq!(report["boundary"], "free");
            assert_eq!(number(&load["force"]), number(&load["mean_pressure"]));
            assert!(load["converged"] == true, "{flags}");
        }
    }
}

#[test]
fn contacts_at_the_edge_of_a_patch_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A cap of radius 3 on a patch of 16 x 16 points and side 1.
    let at = |k: usize| (k as f64 + 0.5) / 16.0 - 0.5;
    let cap = ndarray::Array2::from_shape_fn((16, 16), |(i, j)| -(at(i).powi(2) + at(j).powi(2)) / 6.0);
    ndarray_npy::write_npy(folder.join("cap.npy"), &cap).unwrap();
    let told = |report: &Value| -> Vec<String> {
        let all = report["warnings"].as_array().unwrap().iter();
        all.filter(|found| found["code"] == "patch-edge").map(|found| found["text"].as_str().unwrap().into()).collect()
    };
    // Counts the pressed points at the edge for the last load.
    let pressed = |file: &str| {
        let reader = gfmd_files::Reader::open(folder.join(file)).unwrap();
        let shape = reader.shape("/fields/pressure").unwrap();
        let values: Vec<f64> = reader.values("/fields/pressure").unwrap();
        let last = &values[values.len() - shape[1] * shape[2]..];
        let is_edge = |k: usize| [k / 16, k % 16].iter().any(|place| [0, 15].contains(place));
        last.iter().enumerate().filter(|(k, p)| **p > 0.0 && is_edge(*k)).count()
    };
    for command in ["contact", "path"] {
        let flags = format!("{command} --surface cap.npy --boundary free --out {command}.h5 --json --approach");
        assert!(told(&run(folder, &format!("{flags} 0.001,0.06"))).is_empty());
        let report = run(folder, &format!("{flags} 0.001,0.11,0.2"));
        let (found, count) = (told(&report), pressed(&format!("{command}.h5")));
        assert!(found.len() == 1 && count == 60, "{found:?} {count}");
        let name = if command == "contact" { "load 1" } else { "step" };
        assert!(found[0].starts_with(name) && found[0].contains("of its 60 points"), "{found:?}");
        let one = run(folder, &format!("{flags} 0.11"));
        let count = pressed(&format!("{command}.h5"));
        assert!(count > 0 && (command == "path" || told(&one)[0].contains(&format!("at {count} of its 60"))), "{one}");
    }
    assert!(told(&run(folder, "contact --surface cap.npy --approach 0.02 --json")).is_empty());
    // Nothing flows through a gap that is closed everywhere, despite rounding.
    for command in ["contact", "path"] {
        let report = run(folder, &format!("{command} --surface cap.npy --boundary free --approach 0.2 --flow --json"));
        let of = report.get("loads").unwrap_or(&report["steps"]).as_array().unwrap().last().unwrap();
        assert_eq!((&of["area_fraction"], &of["mean_gap"]), (&1.0.into(), &0.0.into()));
        let reasons = of["undefined"].to_string();
        assert!(reasons.contains("the gap is closed everywhere") && !reasons.contains("the mean gap is"), "{reasons}");
    }
    let line = run(folder, "contact --dim 2 --n 32 --eps-f-inv 4 --boundary free --p-star 3 --json");
    assert!(told(&line)[0].contains("at 2 of its 2 points"), "{line}");
    // Attractive laws have no contact at the edge where the surfaces do not touch.
    let law = "--law exponential --param gamma=1e-4,range=4e-3 --approach 0.001 --json";
    assert!(told(&run(folder, &format!("contact --surface cap.npy --boundary free {law}"))).is_empty());
}

#[test]
fn paths_on_a_patch_lose_energy_and_slip() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law =
        format!("path {SURFACE} --law exponential --param gamma=1e-4,range=4e-3 --approach 0,0.006,-0.004 --steps 4");
    let report = is_sound(folder, &law);
    assert_eq!(report["boundary"], "free");
    let lateral = "--p-star 0.05 --lateral 0,0.002,-0.002 --steps 2";
    let report = is_sound(folder, &format!("path {SURFACE} --friction 0.3 {lateral}"));
    assert!(number(&report["dissipated"]) > 0.0, "{}", report["dissipated"]);
    let slab = format!("path {SURFACE} --friction 0.3 {lateral} --height 0.2 --young 1 --poisson 0.3");
    assert!(number(&is_sound(folder, &slab)["dissipated"]) > 0.0);
    // With slip everywhere, the shear is friction times load.
    let report = is_sound(folder, &format!("path {SURFACE} --friction 0.3 --p-star 0.05 --lateral 0,0.2 --steps 4"));
    let last = report["steps"].as_array().unwrap().last().unwrap();
    let ratio = number(&last["mean_shear"][0]) / number(&last["mean_pressure"]);
    assert!((ratio.abs() - 0.3).abs() < 1e-3, "{ratio}");
}

const COHESIVE: &str = "--law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.01,delta_t=0.01";

/// The shear of a law rises with the lateral displacement, changes its sign with it, and loses no energy.
#[test]
fn laws_that_shear_move_a_patch_sideways() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let surface = "--n 16 --eps-f-inv 4 --boundary free --poisson 0.3 --young 1";
    let sideways = "--lateral 0,0.004,-0.004 --steps 2";
    for flags in [
        format!("path {surface} {COHESIVE} --p-star 0.02 {sideways} --flow"),
        format!("path {surface} {COHESIVE} --approach 0.002 {sideways} --lateral-y 0,0.002,0.004 --direction 30"),
        format!("path {surface} {COHESIVE} --approach 0.002 {sideways} --height 0.3 --layer 2,0.2,0.2"),
        format!("path {surface} {COHESIVE} --p-star 0.02 {sideways} --second-body 2,0.2"),
    ] {
        let report = is_sound(folder, &flags);
        assert_eq!(report["boundary"], "free");
        let steps = report["steps"].as_array().unwrap();
        let shear = |step: usize, axis: usize| number(&steps[step]["mean_shear"][axis]);
        let energy = number(&steps[2]["elastic_energy"]);
        for (place, step) in steps.iter().enumerate() {
            assert!(step["converged"] == true && number(&step["stiffness"]) > 0.0, "{flags}: {step}");
            assert!(place == 0 || step["passed_instability"] == false, "{flags}: {step}");
            assert!(number(&step["dissipated"]).abs() < 1e-3 * energy, "{flags}: {step}");
        }
        assert!(shear(1, 0) > 0.0 && shear(2, 0) > shear(1, 0) && shear(4, 0) < 0.0, "{flags}");
    }
    // Without shear the path is the path without lateral displacement.
    let law = "--law exponential --param gamma=1e-4,range=1e-2 --p-star 0.02";
    for (law, exact) in [(law, 1e-6), ("--p-star 0.05", 1e-6)] {
        let steps = |lateral: &str| {
            let report = run(folder, &format!("path {surface} {law} {lateral} --steps 1 --json"));
            report["steps"].as_array().unwrap().last().unwrap().clone()
        };
        let (moved, still) = (steps("--lateral 0,0.004"), steps(""));
        for name in ["mean_pressure", "approach", "area_fraction", "mean_gap", "elastic_energy"] {
            let [found, wanted] = [&moved, &still].map(|step| number(&step[name]));
            assert!((found / wanted - 1.0).abs() < exact, "{law} {name}: {found} {wanted}");
        }
        assert!(moved["passed_instability"] == false, "{moved}");
    }
    // A law without energy comes to rest by dynamics, and tells no loss.
    let law = "--law npb --param phi_n=1e-4,phi_t=8e-5,delta_n=0.01,delta_t=0.01";
    let report = is_sound(folder, &format!("path {surface} {law} --approach 0.002 --lateral 0,0.004 --steps 1"));
    let last = &report["steps"][1];
    assert!(number(&last["mean_shear"][0]) > 0.0 && last["dissipated"].is_null(), "{last}");
}

/// A tall slab is a half-space, and a law without work is a hard wall.
#[test]
fn limits_meet() {
    let folder = tempfile::tempdir().unwrap();
    let area = |flags: &str| {
        let report = run(folder.path(), &format!("contact {SURFACE} --p-star 0.1 {flags} --json"));
        ["area_fraction", "mean_gap"].map(|key| number(&report["loads"][0][key]))
    };
    let wall = area("");
    for flags in ["--height 500", "--law exponential --param gamma=1e-12,range=1e-3"] {
        let found = area(flags);
        assert!(found[0] == wall[0] && (found[1] / wall[1] - 1.0).abs() < 1e-3, "{flags}: {found:?} {wall:?}");
    }
}

#[test]
fn what_a_patch_cannot_have_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--law exponential --param gamma=1e-4,range=4e-3";
    for (flags, reported) in [
        (
            "contact --height 0.2 --base free",
            "--base is free; it must be bonded, sliding or half-space with --boundary free (nothing holds the plate",
        ),
        ("contact --dim 2 --height 1e-3", "--boundary free: the height of the top layer is 0.001"),
        (
            "contact --height 1e-4",
            "--boundary free: the height of the top layer is 0.0001; with free boundaries it must be at least",
        ),
        (
            "path --friction 0.3 --height 0.2 --base sliding",
            "--base is sliding; it must be bonded or half-space with --boundary free and friction, --lateral",
        ),
        (
            "path --dim 2 --friction 0.3",
            "--dim is 2; it must be 3 with --boundary free and friction, --lateral or --components all (the lateral",
        ),
        ("path --dim 2 --lateral 0,0.1", "--dim is 2; it must be 3 with --boundary free and friction, --lateral"),
        ("path --height 0.2 --base sliding --lateral 0,0.1", "--base is sliding; it must be bonded or half-space with"),
        ("path --height 0.2 --base free --lateral 0,0.1", "--base is free; it must be bonded, sliding or half-space"),
        ("path --lateral 0,0.1 --coefficient 0.1 --distance 1", "it must be left out with --lateral, unless there is"),
    ] {
        let output = gfmd(folder.path(), &words(&format!("{flags} {SURFACE} --p-star 0.1")));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(reported), "{flags}: {message}");
    }
    let output = gfmd(folder.path(), &words(&format!("contact {SURFACE} --dim 2 {law} --approach 0.01")));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
