//! `check`: result files recomputed, run again, changed, damaged; warnings and failed criteria as data.

use std::path::Path;

use crate::common::{SWEEP, gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

/// Writes a surface with opposite edges that do not match.
fn write_inputs(folder: &Path) {
    let ramp = Array2::from_shape_fn((24, 24), |(i, j)| {
        0.002 * i as f64 + 0.01 * (0.9 * i as f64).sin() * (0.7 * j as f64).cos()
    });
    ndarray_npy::write_npy(folder.join("h.npy"), &ramp).unwrap();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
}

/// Files by name, with the command that makes them and a variable with changes that the recomputation must notice.
const FILES: [(&str, &str, &str); 14] = [
    ("punch.h5", "punch --n 24 --contact sticking", "/fields/displacement"),
    ("line.h5", "punch --n 24 --dim 2 --contact frictionless --height inf", "/punch/mean_pressure"),
    ("wall.h5", "contact --n 48 --eps-f-inv 8 --p-star 0.02,0.1 --height 0.4 --poisson 0.3", "/fields/pressure"),
    ("scan.h5", "contact --surface h.npy --size 2 --approach 0.003,0.006 --detrend plane --flip", "/loads/kappa"),
    (
        "law.h5",
        "contact --n 48 --eps-f-inv 8 --law exponential --param gamma=1e-4,range=3e-3 --p-star 0.05,-0.001",
        "/fields/gap",
    ),
    (
        "loop.h5",
        "path --n 48 --eps-f-inv 6 --law exponential --param gamma=1e-4,range=4e-3 --approach=0.004,-0.002 \
         --steps 4",
        "/path/elastic_energy",
    ),
    (
        "slip.h5",
        "path --n 24 --eps-f-inv 6 --p-star 0.05 --friction 0.3 --lateral 0,0.001 --steps 3",
        "/fields/shear_x",
    ),
    ("sweep.h5", "kappa-sweep --config sweep.toml", "/fit/kappa_tfc"),
    ("below.h5", "body --surface punch.h5 --levels 5", "/fields/von_mises"),
    ("patch.h5", "contact --surface h.npy --size 2 --boundary free --p-star 0.02,0.1", "/loads/force"),
    (
        "steep.h5",
        "contact --n 32 --eps-f-inv 4 --rms-gradient 0.25 --poisson 0.3 --finite-slope --p-star 0.02,0.1",
        "/loads/mean_shear_x",
    ),
    (
        "all.h5",
        "contact --n 24 --eps-f-inv 4 --height 0.4 --poisson 0.3 --p-star 0.05,0.2 --components all --solver fire",
        "/fields/displacement_x",
    ),
    ("held.h5", "contact --n 48 --eps-f-inv 8 --poisson 0.3 --p-star 0.05 --components held", "/loads/stiffness"),
    ("hard.h5", "contact --n 48 --eps-f-inv 8 --hardness 0.1 --p-star 0.05,0.5", "/fields/plastic_depth"),
];

fn make(folder: &Path, (name, words, _): (&str, &str, &str)) {
    let mut arguments: Vec<&str> = words.split_whitespace().collect();
    arguments.extend(["--out", name, "-q"]);
    let output = gfmd(folder, &arguments);
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the report of a check, and its exit status.
fn check(folder: &Path, arguments: &[&str]) -> (Value, Option<i32>) {
    let words = [&["check"], arguments, &["--json", "-q"]].concat();
    let output = gfmd(folder, &words);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!message.contains("panicked"), "{arguments:?}: {message}");
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| Value::String(message.into()));
    (report, output.status.code())
}

#[test]
fn results_are_recomputed_and_run_again_number_for_number() {
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    for file in FILES {
        make(folder.path(), file);
        for arguments in [&[file.0][..], &[file.0, "--rerun"]] {
            let (report, status) = check(folder.path(), arguments);
            assert_eq!(status, Some(0), "{arguments:?}: {report}");
            assert_eq!(report["differing"], 0);
            assert_eq!(report["intact"], true);
            assert!(report["compared"].as_u64().unwrap() > 20, "{report}");
        }
    }
    let (report, _) = check(folder.path(), &["sweep.h5", "--rerun", "--sample", "3"]);
    let whole = check(folder.path(), &["sweep.h5", "--rerun"]).0;
    assert!(report["compared"].as_u64() < whole["compared"].as_u64());
    assert_eq!(check(folder.path(), &["scan.h5"]).0["input"]["state"], "unchanged");
}

#[test]
fn a_changed_number_is_named() {
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    for file in FILES {
        make(folder.path(), file);
        let path = folder.path().join(file.0);
        let mut values = Reader::open(&path).unwrap().values::<f64>(file.2).unwrap();
        let largest = (0..values.len()).max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs())).unwrap();
        values[largest] *= 1.0 + 1e-6;
        // A process started by another test may hold the lock of an open file; a copy has no lock.
        let [changing, fresh] = ["changing", "fresh"].map(|name| folder.path().join(name));
        std::fs::copy(&path, &changing).unwrap();
        let open = hdf5::File::open_rw(&changing).unwrap();
        let variable = open.dataset(file.2).unwrap();
        let shape = variable.shape();
        let changed = ndarray::ArrayD::from_shape_vec(shape, values).unwrap();
        if changed.ndim() == 0 { variable.write_scalar(&changed[[]]) } else { variable.write(&changed) }.unwrap();
        drop(variable);
        open.close().unwrap();
        std::fs::copy(&changing, &fresh).unwrap();
        std::fs::rename(&fresh, &path).unwrap();
        std::fs::remove_file(&changing).unwrap();
        let (report, status) = check(folder.path(), &[file.0]);
        assert_eq!(status, Some(1), "{}: {report}", file.0);
        let names: Vec<&str> =
            report["differences"].as_array().unwrap().iter().filter_map(|d| d["name"].as_str()).collect();
        assert!(names.contains(&"content_sha256"), "{}: {names:?}", file.0);
        // The recomputation notices the change without the checksum, in this variable or in one that follows from it.
        assert!(names.iter().any(|name| name.starts_with('/')), "{}: {names:?}", file.0);
        let table = gfmd(folder.path(), &["check", file.0]);
        assert!(String::from_utf8_lossy(&table.stdout).contains("recomputed"));
    }
}

#[test]
fn a_changed_input_is_noticed_and_a_missing_one_is_said() {
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    make(folder.path(), FILES[0]);
    make(folder.path(), FILES[3]);
    make(folder.path(), FILES[8]);
    ndarray_npy::write_npy(folder.path().join("h.npy"), &Array2::<f64>::eye(24)).unwrap();
    let (report, status) = check(folder.path(), &["scan.h5"]);
    assert_eq!((status, &report["input"]["state"]), (Some(1), &Value::from("changed")), "{report}");
    std::fs::remove_file(folder.path().join("h.npy")).unwrap();
    // The surface is stored as used, so that the run can be repeated.
    let (report, status) = check(folder.path(), &["scan.h5", "--rerun"]);
    assert_eq!((status, &report["input"]["state"]), (Some(0), &Value::from("missing")), "{report}");
    std::fs::remove_file(folder.path().join("punch.h5")).unwrap();
    let (report, status) = check(folder.path(), &["below.h5"]);
    assert_eq!(status, Some(0), "{report}");
    assert_eq!(report["warnings"][0]["code"], "input-missing");
}

#[test]
fn a_damaged_file_is_noticed_wherever_the_damage_lies() {
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    make(folder.path(), FILES[2]);
    let path = folder.path().join("wall.h5");
    let good = std::fs::read(&path).unwrap();
    let content = |path: &Path| -> Vec<Vec<u64>> {
        let file = Reader::open(path).unwrap();
        let names = ["/surface/height", "/loads/kappa", "/loads/residual_load", "/fields/pressure", "/fields/gap"];
        let bits = |name: &&str| file.values::<f64>(name).unwrap().into_iter().map(f64::to_bits).collect();
        names.iter().map(bits).collect()
    };
    let expected = content(&path);
    let mut noticed = 0;
    for part in 0..24 {
        let mut bad = good.clone();
        let place = part * good.len() / 24 + 40;
        for byte in &mut bad[place..place + 16] {
            *byte = !*byte;
        }
        std::fs::write(&path, &bad).unwrap();
        let (report, status) = check(folder.path(), &["wall.h5"]);
        assert!(matches!(status, Some(0..=2)), "{place}: {report}");
        // Bytes not used by a variable or an attribute do not matter.
        match status {
            Some(0) => assert_eq!(content(&path), expected),
            _ => noticed += 1,
        }
    }
    assert!(noticed >= 12, "only {noticed} of 24 damages were noticed");
    for length in [0, 100, good.len() / 2, good.len() - 1] {
        std::fs::write(&path, &good[..length]).unwrap();
        let (report, status) = check(folder.path(), &["wall.h5"]);
        assert!(matches!(status, Some(1 | 2)), "{length}: {report}");
    }
    std::fs::write(&path, "a letter").unwrap();
    assert_eq!(check(folder.path(), &["wall.h5"]).1, Some(2));
    let (report, status) = check(folder.path(), &["absent.h5"]);
    assert_eq!(status, Some(2), "{report}");
}

#[test]
fn warnings_stand_in_json_and_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    let codes = |words: &str| -> Vec<String> {
        let arguments: Vec<&str> = words.split_whitespace().chain(["--out", "w.h5", "--json", "-q"]).collect();
        let report = json(folder.path(), &arguments);
        let warnings = report["warnings"].as_array().unwrap().clone();
        let stored = Reader::open(folder.path().join("w.h5")).unwrap().text("/", "warnings").unwrap();
        let lines: Vec<String> = warnings
            .iter()
            .map(|warning| format!("{}: {}", warning["code"].as_str().unwrap(), warning["text"].as_str().unwrap()))
            .collect();
        assert_eq!(stored.lines().collect::<Vec<_>>(), lines, "{words}");
        warnings.iter().map(|warning| warning["code"].as_str().unwrap().into()).collect()
    };
    assert_eq!(codes("contact --surface h.npy --p-star 0.05"), ["rough-seam", "large-slope"]);
    assert_eq!(codes("surface --surface h.npy"), ["rough-seam"]);
    assert!(codes("surface --surface h.npy --boundary free").is_empty(), "a patch has no seam");
    assert!(codes("contact --n 32 --eps-f-inv 4 --p-star 0.2").is_empty());
    assert_eq!(codes("contact --n 32 --eps-f-inv 8 --p-star 0.05"), ["grid"]);
    assert_eq!(codes("punch --n 16 --depth 0.2"), ["large-strain", "large-strain"]);
    // The approach is given, or follows from the pressure; the rough surfaces are lower than the slab.
    for slab in ["--height 0.05", "--height 0.05 --lower-seed 3", "--height 0.02 --layer 1,0.3,0.03"] {
        for load in ["--approach 0.1", "--pressure 0.3"] {
            let words = format!("contact --n 32 --eps-f-inv 4 {slab} {load}");
            assert_eq!(codes(&words), ["large-strain"], "{words}");
        }
        let gentle = codes(&format!("contact --n 32 --eps-f-inv 4 {slab} --approach 0.004"));
        assert!(!gentle.contains(&"large-strain".into()), "{slab}: {gentle:?}");
    }
    let slab = "--n 16 --eps-f-inv 4 --height 0.05";
    for command in [
        "path --approach 0.002,0.1 --steps 2",
        "wear --approach 0.1 --coefficient 1e-6 --distance 0,1",
        "slide --approach 0.1 --velocity 1 --prony 1:0.5",
    ] {
        assert_eq!(codes(&format!("{command} {slab}")), ["large-strain"], "{command}");
    }
    let law = "--law exponential --param gamma=1e-4,range=1e-5 --coarse";
    assert_eq!(codes(&format!("contact --n 16 --eps-f-inv 4 {law} --p-star 0.05")), ["lattice-trapping", "grid"]);
    assert_eq!(codes(&format!("path --n 16 --eps-f-inv 4 {law} --approach 0.01")), ["lattice-trapping"]);
    let sweep = codes("kappa-sweep --config sweep.toml");
    assert!(sweep.iter().any(|code| code == "few-realisations"), "{sweep:?}");
}

#[test]
fn a_search_without_convergence_names_the_criterion_its_history_and_what_to_try() {
    let folder = tempfile::tempdir().unwrap();
    for (words, part) in [
        ("contact --n 32 --eps-f-inv 8 --p-star 0.02,0.05 --solver verlet --max-iterations 60 --tolerance 1e-9", 0),
        ("path --n 32 --eps-f-inv 8 --p-star 0.05 --friction 0.3 --lateral 0,0.01 --steps 2 --max-iterations 3", 0),
        ("punch --n 24 --solver verlet --max-iterations 20", 0),
    ] {
        let arguments: Vec<&str> = words.split_whitespace().chain(["--out", "n.h5", "--json"]).collect();
        let output = gfmd(folder.path(), &arguments);
        let reported = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{reported}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let unmet = &report["not_converged"];
        assert_eq!(unmet["part"], part, "{unmet}");
        let criterion = &unmet["criteria"][0];
        assert!(criterion["value"].as_f64().unwrap() > criterion["allowed"].as_f64().unwrap());
        let history = unmet["history"]["residual"].as_array().unwrap();
        assert!(history.len() > 1 && history.len() == unmet["history"]["iteration"].as_array().unwrap().len());
        assert!(unmet["advice"].as_str().unwrap().contains("--"), "{unmet}");
        assert!(
            reported.contains(criterion["name"].as_str().unwrap()) && reported.contains("must be at most"),
            "{reported}"
        );
        assert!(reported.contains('█') && reported.contains("iterations"), "{reported}");
        let file = Reader::open(folder.path().join("n.h5")).unwrap();
        let stored: Vec<f64> = file.values("/not_converged/residual").unwrap();
        assert_eq!(stored, history.iter().map(|value| value.as_f64().unwrap()).collect::<Vec<_>>());
        assert!(file.text("/not_converged", "criteria").unwrap().contains(" above "));
        let (report, status) = check(folder.path(), &["n.h5"]);
        assert_eq!(status, Some(0), "an unfinished result is what it says: {report}");
    }
}

#[test]
fn a_step_whose_numbers_overflow_leaves_those_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--law morse --param gamma=1e-4,range=0.01";
    let words = format!("path --n 8 --eps-f-inv 2 {law} --steps 1 --approach=0.001,1000 --json --out p.h5");
    let output = gfmd(folder.path(), &words.split(' ').collect::<Vec<_>>());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && message.contains("error: step 1: the traction of the law"), "{message}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["steps"].as_array().unwrap().len(), 1, "{report}");
    let (checked, status) = check(folder.path(), &["p.h5"]);
    assert_eq!(status, Some(0), "{checked}");
}
