//! Tests of `reproduce`, and of docs/source against it.

use std::path::Path;
use std::process::{Command, Output};

fn xtask(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).current_dir(folder).args(arguments).output().expect("the program starts")
}

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

#[test]
fn a_figure_is_drawn_as_it_is_committed() {
    let folder = tempfile::tempdir().unwrap();
    let reference = root().join("data/reference");
    let arguments = ["reproduce", "--figure", "3.5,4.9", "--out", "figures", "--json", "--reference"];
    let output = xtask(folder.path(), &[&arguments[..], &[reference.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["figures"], serde_json::json!(["3.5", "4.9"]));
    for name in ["figure-3.5.svg", "figure-3.5-level.svg", "figure-4.9.svg"] {
        let fresh = std::fs::read_to_string(folder.path().join("figures").join(name)).unwrap();
        let committed = std::fs::read_to_string(root().join("docs/source").join(name)).unwrap();
        // Colours may differ by rounding on another processor; axes and words do not.
        let words = |svg: &str| svg.matches("<text").count();
        assert_eq!((words(&fresh), fresh.len() / 1000), (words(&committed), committed.len() / 1000), "{name}");
    }
    assert!(!folder.path().join("figures/README.md").exists(), "a part of the figures has no page");
    let output = xtask(folder.path(), &["reproduce", "--figure", "5.1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("4.1a, 4.1b, 4.3"));
}

#[test]
fn the_page_has_every_figure_and_all_pictures_are_small() {
    let folder = root().join("docs/source");
    let page = std::fs::read_to_string(folder.join("README.md")).unwrap();
    for number in ["3.3", "3.4", "3.5", "3.6", "3.7", "3.8", "3.10", "3.11", "4.1a", "4.1b"]
        .into_iter()
        .chain(["4.3", "4.4", "4.5", "4.6", "4.7", "4.8", "4.9", "4.10", "4.11"])
    {
        assert!(page.contains(&format!("\n## Figure {number}\n")), "{number}");
    }
    let pictures: Vec<&str> = page.split("](figure-").skip(1).map(|rest| rest.split(')').next().unwrap()).collect();
    assert!(pictures.len() >= 25);
    let sizes = pictures.iter().map(|name| std::fs::metadata(folder.join(format!("figure-{name}"))).unwrap().len());
    let sizes: Vec<u64> = sizes.collect();
    assert!(sizes.iter().all(|size| *size < 60_000) && sizes.iter().sum::<u64>() < 2_000_000, "{sizes:?}");
    assert!(!page.contains("NaN"));
}
