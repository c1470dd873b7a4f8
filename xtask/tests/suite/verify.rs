//! Tests of `verify`, and of docs/validation.md against its output.

use std::path::Path;
use std::process::{Command, Output};

/// Runs `cargo xtask` with `arguments` in `folder`.
fn xtask(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).current_dir(folder).args(arguments).output().expect("the program starts")
}

/// Returns the document with the words for which ″ stands in its tables.
fn whole(document: &str) -> String {
    let mut source = "";
    let mut text = String::new();
    for line in document.lines() {
        if let Some((name, rest)) = line.split_once(" | ″ |") {
            text += &format!("{name} | {source} |{rest}\n");
        } else {
            source = line.split(" | ").nth(1).unwrap_or(source);
            text += &format!("{line}\n");
        }
    }
    text
}

#[test]
fn all_checks_pass_and_the_document_lists_them() {
    let folder = tempfile::tempdir().unwrap();
    let output = xtask(folder.path(), &["verify", "--write-docs", ".", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let checks: Vec<_> =
        report["topics"].as_array().unwrap().iter().flat_map(|t| t["checks"].as_array().unwrap()).collect();
    assert_eq!((checks.len() as u64, &report["failed"]), (report["checks"].as_u64().unwrap(), &0.into()));
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/validation.md");
    let [committed, fresh] =
        [committed, folder.path().join("validation.md")].map(|path| whole(&std::fs::read_to_string(path).unwrap()));
    for check in checks {
        assert!(check["passed"] == true && (check["at_most"].is_f64() || check["at_least"].is_f64()), "{check}");
        let row = format!("| {} | {} |", check["name"].as_str().unwrap(), check["source"].as_str().unwrap());
        assert!(committed.contains(&row) && fresh.contains(&row), "no {row}: run cargo xtask verify --write-docs");
    }
    // All figures of the document exist.
    let figures = fresh.split("](images/").skip(1).map(|rest| rest.split(')').next().unwrap());
    assert!(figures.clone().count() >= 10);
    for figure in figures {
        assert!(folder.path().join("images").join(figure).exists() && committed.contains(figure), "{figure}");
    }
}

#[test]
fn a_check_that_fails_is_named_and_a_file_that_is_missing_too() {
    let folder = tempfile::tempdir().unwrap();
    let failed = |arguments: &[&str], status: i32| {
        let output = xtask(folder.path(), arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{text}");
        (text, String::from_utf8_lossy(&output.stdout).into_owned())
    };
    assert!(failed(&["verify", "--write-docs", "no/folder", "-q"], 2).0.contains("no/folder"));
    let (text, table) = failed(&["verify", "--reference", ".", "--topic", "kernels", "-q"], 2);
    assert!(text.contains("slab_kernel_2d.json") && table.is_empty(), "{text}");

    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/reference"), folder.path());
    let name = folder.path().join("critical_damping.json");
    let other = std::fs::read_to_string(&name).unwrap().replacen("0.7,", "0.71,", 1);
    std::fs::write(name, other).unwrap();
    let (text, table) = failed(&["verify", "--reference", ".", "--topic", "damping", "-q"], 1);
    assert!(text.contains("2 of ") && text.contains("critical damping"), "{text}");
    assert!(table.contains("FAILED") && table.contains("2 failed"), "{table}");
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to)
        } else {
            std::fs::write(to, std::fs::read(entry.path()).unwrap()).unwrap()
        }
    }
}
