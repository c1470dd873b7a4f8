//! Statistics and conductance of the steps of a path, from end to end: the numbers of `contact` in the same state, at
//! waypoints and steps, resumed, checked.

use std::path::Path;

use crate::common::{gfmd, json, numbers};
use approx::assert_relative_eq;
use gfmd_files::Reader;
use gfmd_record::reason_for;
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

/// Measurements of all cases.
const MEASURED: &str = "--statistics --conductivity 3,0.5";

/// Problems that `contact` and `path` solve alike.
const SAME: [&str; 8] = [
    "--p-star 0.05",
    "--p-star 0.05 --flow --conductor-height 0.2",
    "--height 0.05 --poisson 0.3 --p-star 0.02",
    "--p-star 0.1 --hardness 0.1",
    "--p-star 0.05 --law exponential --param gamma=1e-5,range=1e-3",
    "--p-star 0.05 --law morse --param gamma=1e-4,range=1e-2",
    "--boundary free --p-star 0.03",
    "--height 0.1 --poisson 0.3 --lower-seed 2 --p-star 0.03",
];

/// A single step from rest leads to the state of `contact`, whose points touch, conduct and carry the same pressures:
/// counts are equal, numbers equal within the tolerance of both searches.
#[test]
fn a_step_has_the_measurements_of_the_contact() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shape = format!("--n 32 --eps-f-inv 8 --seed 3 --tolerance 1e-9 {MEASURED}");
    let profile = format!("--dim 2 --n 64 --eps-f-inv 16 --seed 3 --tolerance 1e-9 {MEASURED}");
    let cases = SAME.iter().map(|flags| format!("{shape} {flags}"));
    for flags in cases.chain([format!("{profile} --p-star 0.05")]) {
        let load = run(folder, &format!("contact {flags} --out c.h5 --json"))["loads"][0].clone();
        let step = run(folder, &format!("path {flags} --out p.h5 --json"))["steps"][0].clone();
        assert!(number(&load["patches"]["count"]) > 1.0, "{flags}: {load}");
        assert_eq!(load["patches"], step["patches"], "{flags}");
        for name in ["conductance", "contact_conductance"] {
            assert_relative_eq!(number(&load[name]), number(&step[name]), max_relative = 1e-5);
            assert!(number(&step[name]) > 0.0, "{flags}: {step}");
        }
        let [contact, path] = ["c.h5", "p.h5"].map(|name| Reader::open(folder.join(name)).unwrap());
        for group in ["/patches", "/distributions", "/spectra"] {
            for name in contact.names(group).iter().filter(|name| *name != "load") {
                let of = |file: &Reader| file.values::<f64>(&format!("{group}/{name}")).unwrap();
                let (expected, found) = (of(&contact), of(&path));
                assert_eq!(expected.len(), found.len(), "{flags}: {group}/{name}");
                let scale = expected.iter().filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()));
                // Points at the edge of a bin may change it.
                let within = if group == "/distributions" { 0.2 } else { 1e-5 };
                for (a, b) in expected.iter().zip(&found) {
                    let same = (a - b).abs() <= within * scale || a.is_nan() && b.is_nan();
                    assert!(same, "{flags}: {group}/{name}: {a} {b}");
                }
            }
        }
        assert_eq!(path.values::<f64>("/patches/waypoint").unwrap(), contact.values::<f64>("/patches/load").unwrap());
        drop((contact, path));
        assert_eq!(run(folder, "check p.h5 --json")["differing"], 0, "{flags}");
    }
}

/// Paths with all histories.
const HISTORIES: [(&str, &str); 10] = [
    ("elastic", "--p-star 0.02,0.08,0.02"),
    ("friction", "--p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.001"),
    (
        "friction and a law",
        "--p-star 0.05 --friction 0.3 --lateral 0,0.001 --law exponential --param gamma=1e-5,range=1e-3",
    ),
    ("wear", "--p-star 0.05 --coefficient 1 --distance 0,0.01"),
    ("prony", "--p-star 0.02,0.05 --prony 1:0.5 --time 0.1,2"),
    ("law", "--approach=-0.004,0.004,-0.007 --law exponential --param gamma=2e-4,range=1.2e-3"),
    ("law and hardness", "--p-star 0.05,0.02 --hardness 0.1 --law exponential --param gamma=1e-5,range=1e-3"),
    ("metal", "--p-star 0.05,0.01 --poisson 0.3 --yield-stress 0.02 --hardening 0.02"),
    ("patch", "--boundary free --p-star 0.02,0.05 --conductor-height 0.6"),
    ("two faces", "--height 0.1 --poisson 0.3 --lower-seed 2 --p-star 0.02,0.05"),
];

/// The numbers of every step follow from points in contact; arrays of the waypoints from the fields there.
#[test]
fn paths_with_histories_are_measured_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, flags) in HISTORIES {
        let words = format!("path --n 24 --eps-f-inv 6 --steps 2 {flags} {MEASURED} --flow --out p.h5");
        let report = run(folder, &format!("{words} --json"));
        let steps = report["steps"].as_array().unwrap();
        assert!(steps.iter().all(|step| step["patches"]["count"].is_u64()), "{name}");
        let file = Reader::open(folder.join("p.h5")).unwrap();
        let field = if flags.contains("--law") { "/fields/repulsion" } else { "/fields/pressure" };
        let [areas, of] = ["area", "waypoint"].map(|name| file.values::<f64>(&format!("/patches/{name}")).unwrap());
        let waypoints = file.shape("/fields/pressure").unwrap()[0];
        for place in 0..waypoints {
            let pressure: Vec<f64> = file.slab(field, place).unwrap();
            let touching = pressure.iter().filter(|p| **p > 0.0).count() as f64 / pressure.len() as f64;
            let found: f64 = areas.iter().zip(&of).filter(|(_, at)| **at == place as f64).map(|(area, _)| area).sum();
            assert_relative_eq!(touching, found, max_relative = 1e-12);
            let spectrum: usize = if flags.contains("free") { 0 } else { waypoints };
            assert_eq!(file.shape("/spectra/pressure").map_or(0, |shape| shape[0]), spectrum, "{name}");
        }
        drop(file);
        let checked = run(folder, "check p.h5 --json");
        assert_eq!(checked["differing"], 0, "{name}: {checked}");
        // Conductors meet where points touch, unless all do or none does.
        for step in steps {
            let area = number(&step["area_fraction"]);
            let conductance = number(&step["conductance"]);
            assert!(
                if area > 0.0 { conductance > 0.0 } else { conductance == 0.0 },
                "{name}: {conductance} of {area}, {:?}",
                reason_for(step, "conductance")
            );
        }
        let text = gfmd(folder, &words.split_whitespace().collect::<Vec<_>>());
        let text = String::from_utf8(text.stdout).unwrap();
        for head in ["patches", "largest", "contact conductance: per area through the contacts"] {
            assert!(text.contains(head), "{name}: {head}: {text}");
        }
    }
}

/// A path that is killed somewhere and resumed has the bits of one run, whatever the threads.
#[test]
fn a_resumed_path_has_the_measurements_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let flags = "path --n 32 --eps-f-inv 8 --p-star 0.02,0.1,0.02,0.05 --steps 3 --statistics -q \
                 --law exponential --param gamma=1e-5,range=1e-3";
    let whole = killed_and_whole(folder, flags);
    assert!(whole.contains_key("/patches/waypoint") && whole.contains_key("/fields/repulsion"));
    assert_eq!(run(folder, "check whole.h5 --rerun --json")["differing"], 0);
}

/// The warnings on loads that finished before a kill are in the file of the resumed run.
#[test]
fn a_resumed_contact_has_the_warnings_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --n 32 --eps-f-inv 8 --p-star 1e-3:0.3:24 --grid-error refine -q";
    let whole = killed_and_whole(folder.path(), flags);
    let warnings: String = whole["warnings"].iter().map(|byte| char::from(*byte as u8)).collect();
    assert!(warnings.starts_with("grid: load 0: contacts are"), "{warnings}");
}

/// Runs a command once, and again with a kill after its first finished parts, which must change nothing. Returns the
/// numbers.
fn killed_and_whole(folder: &Path, flags: &str) -> std::collections::BTreeMap<String, Vec<u64>> {
    run(folder, &format!("{flags} --out whole.h5 --json"));
    let whole = numbers(&folder.join("whole.h5"));
    let again = format!("{flags} --threads 1 --resume --out again.h5");
    let state = folder.join("again.h5.state");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_gfmd"));
    let mut killed = command.current_dir(folder).args(words(&again)).spawn().unwrap();
    while !state.exists() && killed.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(gfmd(folder, &words(&again)).status.success());
    assert_eq!(numbers(&folder.join("again.h5")), whole);
    whole
}

/// A path draws the patches of the step with the largest contact.
#[test]
fn a_path_draws_its_patches() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 32 --eps-f-inv 8 --p-star 0.02,0.1,0.05 --steps 1 --plots p -q --json";
    let drawn = |more: &str| {
        let report = run(folder.path(), &format!("{flags} {more}"));
        let plots: Vec<String> =
            report["plots"].as_array().unwrap().iter().map(|p| p.as_str().unwrap().into()).collect();
        plots.iter().any(|plot| plot == "p-patches.png")
    };
    assert!(!drawn("") && drawn("--statistics --flow"));
}

/// Returns the names that a check finds after the values of a variable are changed by a part.
fn found_after(folder: &Path, flags: &str, variable: &str) -> String {
    run(folder, &format!("{flags} --out p.h5 --json"));
    let file = hdf5::File::open_rw(folder.join("p.h5")).unwrap();
    let changed = file.dataset(variable).unwrap();
    let values: Vec<f64> = changed.read_raw().unwrap();
    changed.write_raw(&values.iter().map(|value| 1.01 * value).collect::<Vec<_>>()).unwrap();
    drop((changed, file));
    let output = gfmd(folder, &["check", "p.h5", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{flags}: {variable}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    report["differences"].as_array().unwrap().iter().map(|found| format!("{} ", found["name"])).collect()
}

#[test]
fn a_changed_measurement_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let elastic = "path --n 24 --eps-f-inv 6 --steps 1 --p-star 0.02,0.08 --statistics --conductivity 3,0.5";
    let relaxing = format!("{elastic} --prony 1:0.5 --time 0.1,2");
    for flags in [elastic, &relaxing] {
        let counted = ["/path/converged"];
        let measured = ["/path/largest_patch_fraction", "/path/contact_conductance", "/patches/force"];
        for variable in counted.into_iter().chain(measured) {
            assert!(found_after(folder, flags, variable).contains(variable), "{flags}: {variable}");
        }
    }
    let law = "path --n 24 --eps-f-inv 6 --p-star 0.05 --statistics --law exponential --param gamma=1e-5,range=1e-3";
    assert!(found_after(folder, law, "/fields/repulsion").contains("/fields/repulsion"));
}

/// A base that moves and a surface held sideways lead a single step to the state of `contact`, and their paths through
/// histories are checked; a body that relaxes for long is the body of its long-term modulus.
#[test]
fn paths_over_a_moved_base_and_held_sideways_are_those_of_the_contact() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let wave = ndarray::Array2::from_shape_fn((24, 24), |(i, j)| {
        1e-3 * ((std::f64::consts::TAU * i as f64 / 24.0).cos() + (std::f64::consts::TAU * j as f64 / 12.0).sin())
    });
    ndarray_npy::write_npy(folder.join("base.npy"), &wave).unwrap();
    let shape = "--n 24 --eps-f-inv 6 --seed 3 --tolerance 1e-9 --poisson 0.2";
    let moved = "--height 0.1 --base-displacement base.npy";
    let pulled = "--height 0.1 --base free --base-traction base.npy";
    let law = "--law exponential --param gamma=1e-5,range=1e-3";
    let load = "--p-star 0.05";
    for flags in [
        format!("{moved} {load}"),
        format!("{moved} --approach 0.008"),
        format!("{moved} {load} --hardness 0.1"),
        format!("{moved} {load} {law}"),
        format!("{pulled} {load}"),
        format!("--components held {load}"),
        format!("--components held --height 0.1 {load} --hardness 0.1"),
        format!("--components held {load} {law}"),
        format!("--components held --height 0.1 --lower-seed 2 {load}"),
    ] {
        let contact = run(folder, &format!("contact {shape} {flags} --out c.h5 --json"))["loads"][0].clone();
        let step = run(folder, &format!("path {shape} {flags} --out p.h5 --json"))["steps"][0].clone();
        for name in ["mean_pressure", "approach", "area_fraction", "mean_gap", "elastic_energy"] {
            assert_relative_eq!(number(&contact[name]), number(&step[name]), max_relative = 1e-6);
        }
        let fields = ["c.h5", "p.h5"].map(|file| {
            let file = Reader::open(folder.join(file)).unwrap();
            ["pressure", "displacement_z", "gap"].map(|name| file.values::<f64>(&format!("/fields/{name}")).unwrap())
        });
        for (a, b) in fields[0].iter().zip(&fields[1]) {
            let scale = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * scale), "{flags}");
        }
        assert_eq!(run(folder, "check p.h5 --json")["differing"], 0, "{flags}");
    }
    for flags in [
        format!("{moved} {load} --friction 0.3 --lateral 0,0.001"),
        format!("{moved} {load} --friction 0.3 --lateral 0,0.001 {law}"),
        format!("{moved} {load} --coefficient 1 --distance 0,0.01"),
        format!("{moved} {load} --grid-error refine"),
        format!("--components held {load} --coefficient 1 --distance 0,0.01"),
        format!("--components held --p-star 0.05,0.01 {law} --hardness 0.2"),
        format!("--components held {load} --grid-error refine"),
    ] {
        run(folder, &format!("path {shape} {flags} --steps 2 --out p.h5 --json"));
        assert_eq!(run(folder, "check p.h5 --json")["differing"], 0, "{flags}");
    }
    // Half of the instantaneous modulus relaxes, alike for both moduli.
    let relaxed = "--moduli instantaneous --prony 1:0.5 --time 0,1e7 --pressure 0.002 --steps 1";
    for flags in [moved, "--components held", "--components held --height 0.1 --lower-seed 2"] {
        let steps = run(folder, &format!("path {shape} {flags} {relaxed} --out p.h5 --json"))["steps"].clone();
        assert_eq!(run(folder, "check p.h5 --json")["differing"], 0, "{flags}");
        for (step, young) in [(&steps[0], 1.0), (&steps[1], 0.5)] {
            let words = format!("contact {shape} {flags} --pressure 0.002 --young {young} --json");
            let contact = run(folder, &words)["loads"][0].clone();
            for name in ["approach", "area_fraction", "mean_gap"] {
                assert_relative_eq!(number(&contact[name]), number(&step[name]), max_relative = 1e-5);
            }
        }
    }
}

#[test]
fn parts_that_move_the_surface_otherwise_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ndarray_npy::write_npy(folder.join("base.npy"), &ndarray::Array2::<f64>::zeros((16, 16))).unwrap();
    let moved = "--height 0.1 --base-displacement base.npy";
    let law = "--law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002 --lateral 0.1";
    for (flags, message) in [
        ("--components held --friction 0.3 --lateral 0,1", "friction, or the law, decides the lateral displacement"),
        ("--components held --prony 1:0.5 --time 1 --relaxes shear", "the relaxation of each wave is not known"),
        ("--components held --yield-stress 0.01", "the plastic strain moves the surface sideways"),
        (&format!("--components held {law}"), "friction, or the law, decides the lateral displacement"),
        (&format!("{moved} --yield-stress 0.01"), "the stress by the base, which adds"),
        (&format!("{moved} --prony 1:0.5 --time 1 --relaxes shear"), "moves as the body relaxes"),
        ("--height 0.1 --base free --base-traction base.npy --prony 1:0.5 --time 1", "moves as the body relaxes"),
        ("--conductor-height 0.1", "--conductor-height is 0.1; it must be left out without --statistics"),
        ("--conductivity 1,2", "--conductivity is given; it must be left out without --statistics"),
    ] {
        let output = gfmd(folder, &words(&format!("path --n 16 --p-star 0.05 {flags} --out p.h5")));
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let is_one_line = text.lines().filter(|line| line.contains("error")).count() == 1;
        assert!(output.status.code() == Some(2) && is_one_line && text.contains(message), "{flags}: {text}");
        assert!(!folder.join("p.h5").exists());
    }
}
