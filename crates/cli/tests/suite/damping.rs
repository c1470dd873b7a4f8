//! `damping` from end to end: flags in, JSON, HDF5 and figures out.

use crate::common::{gfmd, json};
use gfmd_files::Reader;

#[test]
fn histories_and_rates_are_the_same_in_json_and_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "damping --n 8 --factors 0.5,1,2 --steps 600 --out d.h5 --plots d --json --quiet";
    let report = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    assert_eq!(report["n"], serde_json::json!([8, 8]));
    assert_eq!(report["components"], 3);
    assert_eq!(report["runs"][1]["regime"], "critical");
    for plot in report["plots"].as_array().unwrap() {
        assert!(folder.path().join(plot.as_str().unwrap()).metadata().unwrap().len() > 1000, "{plot}");
    }
    let file = Reader::open(folder.path().join("d.h5")).unwrap();
    for key in ["eta", "predicted_rate", "mode_rate", "point_rate"] {
        let stored: Vec<f64> = file.values(&format!("/runs/{key}")).unwrap();
        let runs = report["runs"].as_array().unwrap().iter().map(|run| run[key].as_f64().unwrap());
        assert!(runs.eq(stored), "{key}");
    }
    let history = |name: &str| file.values::<f64>(&format!("/history/{name}")).unwrap();
    let (mode, predicted) = (history("mode"), history("predicted"));
    assert_eq!((mode.len(), mode[0], history("point")[601]), (3 * 601, 1.0, 1.0));
    assert!(mode.iter().zip(predicted).all(|(a, b)| (a - b).abs() < 1e-9));
}

#[test]
fn unusable_input_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = gfmd(folder.path(), &["damping", "--factors", "1,0", "--out", "d.h5"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: --factors is 0; it must be"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
