//! `verify` from end to end, and docs/validation.md against it.

mod common;

use std::path::Path;

use common::{gfmd, json};
use ndarray::Array3;

#[test]
fn all_checks_pass_and_the_document_lists_them() {
    let folder = tempfile::tempdir().unwrap();
    let report = json(folder.path(), &["verify", "--write-docs", ".", "--json"]);
    let checks: Vec<_> =
        report["topics"].as_array().unwrap().iter().flat_map(|t| t["checks"].as_array().unwrap()).collect();
    assert_eq!((checks.len() as u64, &report["failed"]), (report["checks"].as_u64().unwrap(), &0.into()));
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/validation.md");
    let [committed, fresh] =
        [committed, folder.path().join("validation.md")].map(|path| std::fs::read_to_string(path).unwrap());
    for check in checks {
        assert!(check["passed"] == true && (check["at_most"].is_f64() || check["at_least"].is_f64()), "{check}");
        let row = format!("| {} | {} |", check["name"].as_str().unwrap(), check["source"].as_str().unwrap());
        assert!(committed.contains(&row) && fresh.contains(&row), "no {row}: run cargo xtask verify --write-docs");
    }
    // Every figure that the document shows is there.
    let figures = fresh.split("](images/").skip(1).map(|rest| rest.split(')').next().unwrap());
    assert!(figures.clone().count() >= 10);
    for figure in figures {
        assert!(folder.path().join("images").join(figure).exists() && committed.contains(figure), "{figure}");
    }
}

#[test]
fn a_check_that_fails_is_named_and_a_file_that_is_missing_too() {
    let folder = tempfile::tempdir().unwrap();
    let output = gfmd(folder.path(), &["verify", "--reference", ".", "-q"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && text.contains("continuum_u_n64.npy"), "{text}");
    let output = gfmd(folder.path(), &["verify", "--write-docs", "no/folder", "-q"]);
    assert!(output.status.code() == Some(2) && output.stdout.is_empty());

    let punch = folder.path().join("punch3d_sticking_zm1_nu033");
    std::fs::create_dir(&punch).unwrap();
    for (name, shape) in [
        ("continuum_u_n64", (64, 64, 3)),
        ("continuum_u_n128", (128, 128, 3)),
        ("continuum_slice_u", (128, 65, 3)),
        ("continuum_slice_stress", (128, 65, 6)),
    ] {
        let field = Array3::<f64>::from_elem(shape, if name == "continuum_slice_u" { 1.0 } else { 0.0 });
        ndarray_npy::write_npy(punch.join(format!("{name}.npy")), &field).unwrap();
    }
    let output = gfmd(folder.path(), &["verify", "--reference", ".", "-q"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && text.contains("displacement below"), "{text}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("FAILED"));
}
