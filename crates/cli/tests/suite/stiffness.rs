//! Stiffness of the states along paths, from end to end: compared with `contact`, and with small changes of the
//! approach.

use std::path::Path;

use approx::assert_relative_eq;
use gfmd_files::Reader;
use serde_json::Value;

use crate::common::{gfmd, json};

fn steps(folder: &Path, flags: &str) -> Vec<Value> {
    let words: Vec<&str> = flags.split_whitespace().collect();
    json(folder, &words)["steps"].as_array().unwrap().clone()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} in {value}"))
}

/// Returns the change of the mean pressure divided by the change of the approach.
fn quotient([from, to]: [&Value; 2]) -> f64 {
    let change = |key: &str| number(to, key) - number(from, key);
    change("mean_pressure") / change("approach")
}

const ROUGH: &str = "--n 16 --hurst 0.8 --eps-f-inv 4 --seed 3";
const EXACT: &str = "--tolerance 1e-11 --stiffness-tolerance 1e-9 --energy-solves 0 --json";

#[test]
fn a_hard_wall_on_a_path_is_as_stiff_as_under_a_load() {
    let folder = tempfile::tempdir().unwrap();
    let exact = "--tolerance 1e-11 --stiffness-tolerance 1e-9 --json";
    for body in ["", " --height 0.3 --poisson 0.3", " --boundary free"] {
        let command = format!("contact {ROUGH} --p-star 0.02,0.1,0.4 {exact}{body}");
        let contact = json(folder.path(), &command.split_whitespace().collect::<Vec<_>>());
        let along = steps(folder.path(), &format!("path {ROUGH} --p-star 0.02,0.1,0.4 --steps 1 {EXACT}{body}"));
        for (load, step) in contact["loads"].as_array().unwrap().iter().zip(&along) {
            assert_relative_eq!(number(step, "stiffness"), number(load, "stiffness"), max_relative = 1e-8);
            assert!(number(step, "stiffness_error") <= 1e-9);
        }
    }
}

/// The step is so small that no point enters or leaves the contact. A body that relaxes moves at once.
#[test]
fn on_every_path_it_is_the_change_of_the_mean_pressure_by_the_approach() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--law exponential --param gamma=1e-4,range=4e-3";
    let prony = "--prony 1:0.4 --time 0.3,0";
    for parts in [
        String::new(),
        law.into(),
        "--hardness 0.05".into(),
        prony.into(),
        format!("{prony} --relaxes shear --poisson 0.3"),
        format!("{law} --hardness 0.05"),
        format!("{law} {prony}"),
        format!("{law} --hardness 0.05 {prony}"),
        format!("--coefficient 0.5 --distance 0.1,0 {law}"),
        "--boundary free --hardness 0.05 --prony 1:0.4 --time 0.3,0".into(),
        "--friction 20 --poisson 0.1".into(),
        format!("--friction 20 --poisson 0.1 --hardness 0.05 {prony}"),
        format!("--friction 20 --poisson 0.1 --base bonded --height 0.4 {law}"),
        format!("--friction 20 --poisson 0.1 --boundary free {law}"),
        "--law npc --param phi_n=1e-3,phi_t=1e-3,delta_n=0.03,delta_t=0.03 --lateral 1e-3,1e-3".into(),
    ] {
        let along = steps(folder.path(), &format!("path {ROUGH} --approach 0.006,0.0060001 --steps 1 {EXACT} {parts}"));
        // A law has a curvature.
        let mean = 0.5 * (number(&along[0], "stiffness") + number(&along[1], "stiffness"));
        assert_relative_eq!(mean, quotient([&along[0], &along[1]]), max_relative = 1e-5);
    }
}

#[test]
fn a_slab_between_two_walls_is_as_stiff_under_a_load_as_on_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let slab = format!("{ROUGH} --height 0.3 --poisson 0.3 --lower-seed 2 --approach 0.006,0.0060001");
    for parts in ["", "--hardness 0.05", "--components held", "--young 1e30"] {
        let command = format!("contact {slab} {parts} --tolerance 1e-11 --stiffness-tolerance 1e-9 --json");
        let contact = json(folder.path(), &command.split_whitespace().collect::<Vec<_>>());
        let loads: Vec<&Value> = contact["loads"].as_array().unwrap().iter().collect();
        let found = number(loads[0], "stiffness");
        let along = steps(folder.path(), &format!("path {slab} {parts} --steps 1 {EXACT}"));
        assert_relative_eq!(found, number(&along[0], "stiffness"), max_relative = 1e-8);
        if parts != "--hardness 0.05" {
            assert_relative_eq!(found, quotient([loads[0], loads[1]]), max_relative = 1e-5);
        }
    }
}

#[test]
fn at_the_hardness_the_contact_is_stiffer_unloaded() {
    let folder = tempfile::tempdir().unwrap();
    let hard = format!("path {ROUGH} --hardness 0.03 --steps 1 {EXACT} --approach");
    let loaded = steps(folder.path(), &format!("{hard} 0.006,0.0060001"));
    let unloaded = steps(folder.path(), &format!("{hard} 0.006,0.0059999"));
    assert!(number(&loaded[0], "plastic_fraction") > 0.0);
    let found = number(&loaded[0], "stiffness");
    assert_relative_eq!(quotient([&loaded[0], &loaded[1]]), found, max_relative = 1e-5);
    let back = quotient([&unloaded[0], &unloaded[1]]);
    assert!(back > 1.02 * found, "{back} {found}");
    // Below the hardness all points in contact count again.
    assert_relative_eq!(number(&unloaded[1], "stiffness"), back, max_relative = 1e-5);
}

#[test]
fn files_have_it_with_its_reason_and_a_check_finds_it_changed() {
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &str| gfmd(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
    let cases = [
        ("--p-star 0.02,0.2", None),
        ("--p-star 0.02,0.2 --hardness 0.05", None),
        ("--p-star 0.02,0.2 --prony 1:0.4 --time 1,2", None),
        ("--p-star 0.02,0.2 --prony 1:0.4 --time 1,2 --hardness 0.05 --stiffness-tolerance 1e-8", None),
        ("--p-star 0.02,0.01 --law exponential --param gamma=1e-4,range=4e-3 --prony 1:0.4 --time 1,2", None),
        ("--p-star 0.02,0.01 --law exponential --param gamma=1e-4,range=4e-3 --hardness 0.3", None),
        ("--p-star 0.02,0.02 --friction 0.3 --lateral 0,1e-3", None),
        ("--p-star 0.02,0.02 --friction 0.3 --lateral 0,1e-3 --boundary free", None),
        ("--p-star 0.02,0.02 --friction 0.3 --boundary free --law exponential --param gamma=1e-4,range=4e-3", None),
        ("--p-star 0.02,5", Some("full contact")),
    ];
    for (flags, reason) in cases {
        let output = run(&format!("path {ROUGH} --steps 1 {flags} --out p.h5"));
        assert!(output.status.success(), "{flags}: {}", String::from_utf8_lossy(&output.stderr));
        let file = Reader::open(folder.path().join("p.h5")).unwrap();
        let stored: Vec<f64> = file.values("/path/stiffness").unwrap();
        assert_eq!(stored[1].is_nan(), reason.is_some(), "{flags}: {stored:?}");
        let undefined = file.text("/path/stiffness", "undefined").unwrap_or_default();
        assert!(undefined.contains(reason.unwrap_or("")), "{flags}: {undefined}");
        drop(file);
        for command in ["check p.h5", "check p.h5 --rerun"] {
            let output = run(command);
            assert!(output.status.success(), "{flags}: {}", String::from_utf8_lossy(&output.stdout));
        }
        if stored[1].is_nan() {
            continue;
        }
        let file = hdf5::File::open_rw(folder.path().join("p.h5")).unwrap();
        let column = file.dataset("/path/stiffness").unwrap();
        column.write_raw(&stored.iter().map(|value| 1.001 * value).collect::<Vec<_>>()).unwrap();
        drop((column, file));
        let output = run("check p.h5");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(!output.status.success() && text.contains("/path/stiffness"), "{flags}: {text}");
    }
}

#[test]
fn a_tolerance_out_of_range_is_refused_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    for wrong in ["0", "1", "nan", "-1e-6"] {
        let flag = format!("--stiffness-tolerance={wrong}");
        let output = gfmd(folder.path(), &["path", "--n", "16", "--p-star", "0.02", &flag]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("stiffness-tolerance") && text.contains("1e-9 to 0.1"), "{text}");
    }
}
