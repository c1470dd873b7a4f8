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

/// Runs a command twice, checks its file, and drives it again from its file.
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
        format!("contact {SURFACE} {law} --displacement 0.005,-0.001"),
        format!("contact {SURFACE} {law} --p-star 0.02 --height 0.2 --base sliding"),
        format!(
            "contact {SURFACE} --p-star 0.02,0.1 --height 0.2 --layer 3,0.4,0.1 --base half-space --base-young 2 \
             --base-poisson 0.2"
        ),
        format!("contact {SURFACE} --displacement 0.01 --height 0.2 --second-body 3,0.4,0.3 --hardness 0.1"),
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
fn paths_on_a_patch_lose_energy_and_slip() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law = format!(
        "path {SURFACE} --law exponential --param gamma=1e-4,range=4e-3 --displacement 0,0.006,-0.004 --steps 4"
    );
    let report = is_sound(folder, &law);
    assert_eq!(report["boundary"], "free");
    let lateral = "--p-star 0.05 --lateral 0,0.002,-0.002 --steps 2";
    let report = is_sound(folder, &format!("path {SURFACE} --friction 0.3 {lateral}"));
    assert!(number(&report["dissipated"]) > 0.0, "{}", report["dissipated"]);
    let slab = format!("path {SURFACE} --friction 0.3 {lateral} --height 0.2 --young 1 --poisson 0.3");
    assert!(number(&is_sound(folder, &slab)["dissipated"]) > 0.0);
    // Within slip everywhere, shear is friction times load.
    let report = is_sound(folder, &format!("path {SURFACE} --friction 0.3 --p-star 0.05 --lateral 0,0.2 --steps 4"));
    let last = report["steps"].as_array().unwrap().last().unwrap();
    let ratio = number(&last["mean_shear"][0]) / number(&last["mean_pressure"]);
    assert!((ratio.abs() - 0.3).abs() < 1e-3, "{ratio}");
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
            "--base is sliding; it must be bonded or half-space with friction and --boundary free",
        ),
        ("path --dim 2 --friction 0.3", "--dim is 2; it must be 3 with friction and --boundary free"),
        (
            "path --law exponential --param gamma=1e-4,range=4e-3 --lateral 0,0.1",
            "--boundary is free; it must be periodic with --lateral",
        ),
    ] {
        let output = gfmd(folder.path(), &words(&format!("{flags} {SURFACE} --p-star 0.1")));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(reported), "{flags}: {message}");
    }
    let output = gfmd(folder.path(), &words(&format!("contact {SURFACE} --dim 2 {law} --displacement 0.01")));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2)
            && message.contains("--displacement is given; it must be left out with a profile on a half-space"),
        "{message}"
    );
}
