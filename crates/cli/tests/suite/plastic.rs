//! A hardness field, and plastic depth along a path, from end to end.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

/// Creates a folder with the hardness of 24 x 24 points, in stripes.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let grains = Array2::from_shape_fn((24, 24), |(i, j)| [0.2, 0.02, 0.08][(i / 5 + j / 7) % 3]);
    ndarray_npy::write_npy(folder.path().join("grains.npy"), &grains).unwrap();
    ndarray_npy::write_npy(folder.path().join("small.npy"), &Array2::<f64>::ones((24, 23))).unwrap();
    ndarray_npy::write_npy(folder.path().join("zero.npy"), &Array2::<f64>::zeros((24, 24))).unwrap();
    folder
}

fn differing(folder: &Path, file: &str) -> Value {
    json(folder, &["check", file, "--rerun", "--json"])["differing"].clone()
}

#[test]
fn a_field_of_the_hardness_bounds_the_pressure_and_stays_with_the_result() {
    let folder = folder();
    for boundary in ["periodic", "free"] {
        let run = format!(
            "contact --n 24 --eps-f-inv 6 --boundary {boundary} --hardness grains.npy --p-star 0.1,0.4 \
             --out {boundary}.h5 --json"
        );
        let report = json(folder.path(), &words(&run));
        assert_eq!(report["hardness"], "grains.npy");
        assert!(report["loads"][1]["plastic_fraction"].as_f64().unwrap() > 0.1, "{boundary}");
        let file = Reader::open(folder.path().join(format!("{boundary}.h5"))).unwrap();
        let hardness: Vec<f64> = file.values("/surface/hardness").unwrap();
        let pressure: Vec<f64> = file.slab("/fields/pressure", 1).unwrap();
        assert!(pressure.iter().zip(&hardness).all(|(p, h)| p <= h));
        let full = pressure.iter().zip(&hardness).filter(|(p, h)| p == h).count() as f64 / 576.0;
        assert_eq!(report["loads"][1]["plastic_fraction"], full);
    }
    // A uniform hardness field gives the same numbers as the single number.
    ndarray_npy::write_npy(folder.path().join("one.npy"), &Array2::from_elem((24, 24), 0.05)).unwrap();
    let [one, field] = ["0.05", "one.npy"].map(|hardness| {
        let run = format!("contact --n 24 --eps-f-inv 6 --hardness {hardness} --p-star 0.3 --tolerance 1e-12 --json");
        json(folder.path(), &words(&run))["loads"][0]["plastic_volume"].as_f64().unwrap()
    });
    approx::assert_relative_eq!(one, field, max_relative = 1e-8);
    std::fs::remove_file(folder.path().join("grains.npy")).unwrap();
    for boundary in ["periodic", "free"] {
        assert_eq!(differing(folder.path(), &format!("{boundary}.h5")), 0, "{boundary}");
    }
}

#[test]
fn a_path_keeps_its_plastic_depth_and_is_checked() {
    let folder = folder();
    for (name, flags) in [
        ("number", "--hardness 0.05"),
        ("field", "--hardness grains.npy"),
        ("patch", "--hardness grains.npy --boundary free"),
        ("elastic", "--boundary free"),
    ] {
        let run = format!(
            "path --n 24 --eps-f-inv 6 {flags} --p-star 0.05,0.4,0.02,0.4 --steps 2 --tolerance 1e-10 --out {name}.h5 \
             --json"
        );
        let report = json(folder.path(), &words(&run));
        let steps = report["steps"].as_array().unwrap();
        let number = |step: usize, key: &str| steps[step][key].as_f64().unwrap();
        approx::assert_relative_eq!(number(2, "approach"), number(6, "approach"), max_relative = 1e-8);
        assert_eq!(number(2, "area_fraction"), number(6, "area_fraction"), "{name}");
        let file = Reader::open(folder.path().join(format!("{name}.h5"))).unwrap();
        if name == "elastic" {
            assert_eq!((&report["boundary"], &report["dissipated"]), (&"free".into(), &0.0.into()));
            assert!(steps[2].get("plastic_volume").is_none() && !file.contains("/fields/plastic_depth"));
        } else {
            assert!(number(2, "dissipated") > 0.0 && number(4, "dissipated") < 1e-9 * number(2, "dissipated"));
            assert!(number(4, "area_fraction") < number(2, "area_fraction"));
            approx::assert_relative_eq!(number(4, "plastic_volume"), number(2, "plastic_volume"), max_relative = 1e-9);
            let depth: Vec<f64> = file.slab("/fields/plastic_depth", 2).unwrap();
            let mean = depth.iter().sum::<f64>() / 576.0;
            approx::assert_relative_eq!(mean, number(4, "plastic_volume"), max_relative = 1e-12);
            let stored: Vec<f64> = file.values("/path/plastic_volume").unwrap();
            assert_eq!(stored[4].to_bits(), number(4, "plastic_volume").to_bits());
        }
    }
    std::fs::remove_file(folder.path().join("grains.npy")).unwrap();
    for name in ["number", "field", "patch", "elastic"] {
        assert_eq!(differing(folder.path(), &format!("{name}.h5")), 0, "{name}");
    }
}

#[test]
fn a_changed_depth_is_found() {
    let folder = folder();
    let run = "path --n 24 --eps-f-inv 6 --hardness 0.05 --p-star 0.05,0.4,0.02 --steps 2 --out p.h5";
    assert!(gfmd(folder.path(), &words(run)).status.success());
    let file = hdf5::File::open_rw(folder.path().join("p.h5")).unwrap();
    let depth = file.dataset("/fields/plastic_depth").unwrap();
    let values: Vec<f64> = depth.read_raw().unwrap();
    depth.write_raw(&values.iter().map(|value| 1.001 * value).collect::<Vec<_>>()).unwrap();
    drop((depth, file));
    let output = gfmd(folder.path(), &["check", "p.h5", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let names: Vec<&str> =
        report["differences"].as_array().unwrap().iter().map(|found| found["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"/path/plastic_volume") && names.contains(&"/fields/gap"), "{names:?}");
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let folder = folder();
    for (flags, reported) in [
        ("contact --hardness small.npy", "--hardness: small.npy: the shape is [24, 23]; it must be [24, 24]"),
        ("contact --hardness zero.npy", "--hardness: zero.npy: a value is 0; all values must be positive and finite"),
        ("contact --hardness none.npy", "--hardness: none.npy"),
        ("contact --hardness=-0.1", "--hardness is -0.1; it must be positive and finite"),
        ("path --hardness=-0.1", "--hardness is -0.1; it must be positive and finite"),
        ("path --hardness 0.1 --law morse --param gamma=1e-4,range=1e-2", "left out with a --law without a wall"),
        ("path --hardness 0.1 --lateral 0,0.1", "left out with --lateral"),
        (
            "path --boundary free --hardness 0.1 --lateral 0,0.1",
            "--hardness is given; it must be left out with --lateral",
        ),
        ("path --boundary free --height 1e-3", "--boundary free: the height of the top layer is 0.001"),
        ("path --hardness 0.001", "--p-star, step 0: the mean pressure"),
    ] {
        let output = gfmd(folder.path(), &words(&format!("{flags} --n 24 --eps-f-inv 6 --p-star 0.1")));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && message.contains(reported), "{flags}: {message}");
    }
}

#[test]
fn below_a_weak_law_a_closed_contact_carries_its_hardness() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 32 --dim 2 --eps-f-inv 4 --hardness 0.05 --approach 0.05 --energy-solves 0 --json";
    let wall = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let flags = format!("{flags} --law exponential --param gamma=1e-12,range=0.002");
    let law = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    // Deeper than the mean clearance the whole surface yields, and only the hardness tells the mean pressure.
    for report in [wall, law] {
        let pressure = report["steps"][0]["mean_pressure"].as_f64().unwrap();
        assert!((pressure - 0.05).abs() < 1e-8, "{pressure}");
        assert_eq!(report["steps"][0]["plastic_fraction"], 1.0);
    }
}
