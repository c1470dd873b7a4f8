//! The help of the program, with the name by which it was called.

use std::path::Path;

use crate::common::gfmd;

fn help(arguments: &[&str]) -> String {
    let output = gfmd(Path::new("."), arguments);
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_command_has_examples_under_the_name_of_the_program() {
    let all = help(&["--help"]);
    assert!(all.contains("Usage: gfmd "), "{all}");
    for command in [
        "contact",
        "kappa-sweep",
        "punch",
        "body",
        "surface",
        "damping",
        "green",
        "path",
        "slide",
        "law",
        "theory",
        "report",
    ] {
        assert!(all.contains(&format!("\n  {command} ")), "{command}: {all}");
        let text = help(&[command, "--help"]);
        assert!(text.contains(&format!("Usage: gfmd {command} ")), "{text}");
        assert!(text.contains(&format!("\n  gfmd {command}")) && !text.contains("xtask"), "{text}");
    }
}

#[test]
fn choices_are_explained() {
    let text = help(&["surface", "--help"]);
    for row in ["- plateau:", "- gaussian:", "- mirror:", "[default: as-is]"] {
        assert!(text.contains(row), "{row}: {text}");
    }
}
