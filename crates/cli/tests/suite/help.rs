//! Help of the program, with the name used to call it.

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
        "green",
        "path",
        "slide",
        "study",
        "law",
        "prony",
        "theory",
        "estimate",
        "report",
        "completions",
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

/// The scripts know all commands and a flag of one of them; bash reads its own script without an error.
#[test]
fn shells_complete_commands_and_flags() {
    for shell in ["bash", "zsh", "fish"] {
        let script = help(&["completions", shell]);
        for word in ["kappa-sweep", "surface", "p-star", "rms-gradient"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("gfmd.bash");
    let ask = "\nCOMP_WORDS=(gfmd surface --rep) COMP_CWORD=2\n_gfmd gfmd --rep surface\necho \"${COMPREPLY[@]}\"\n";
    std::fs::write(&script, help(&["completions", "bash"]) + ask).unwrap();
    let output = std::process::Command::new("bash").arg(&script).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "--report", "{output:?}");
    let refused = gfmd(Path::new("."), &["completions", "tcsh"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// Flags are listed in groups, and the terms that they use are explained.
#[test]
fn flags_have_groups_and_terms() {
    let text = help(&["contact", "--help"]);
    for group in
        ["Surface", "Generated surface", "Body", "Base", "Lower surface", "Load", "Solver", "Interface law", "Options"]
    {
        assert!(text.contains(&format!("\n{group}:\n")), "{group}: {text}");
    }
    assert!(
        text.contains("reduced pressure p/(E* g)")
            && text.contains("eps_f    shortest wavelength divided by the longest")
    );
    assert!(text.find("\nLoad:\n").is_some_and(|load| text[load..].trim_start().contains("--p-star")));
    // A flag is listed in its own group, independent of the flags before it.
    for (command, group, flag) in [
        ("contact", "Output", "--plots"),
        ("contact", "Contact", "--finite-slope"),
        ("contact", "Measurements", "--flow"),
        ("path", "Accuracy", "--energy-tolerance"),
        ("surface", "Measurements", "--boundary"),
        ("surface", "Output", "--report"),
        ("punch", "Punch", "--mask"),
        ("body", "Places", "--slice"),
    ] {
        let text = help(&[command, "-h"]);
        let part = text.split(&format!("\n{group}:\n")).nth(1).and_then(|rest| rest.split("\n\n").next());
        assert!(part.is_some_and(|part| part.contains(flag)), "{command} {group} {flag}: {text}");
    }
    for command in ["path", "slide"] {
        assert!(help(&[command, "-h"]).contains("reduced pressure p/(E* g)"), "{command}");
    }
    assert!(help(&["kappa-sweep", "-h"]).contains("TFC      thermodynamic, fractal and continuum limit"));
    assert!(!help(&["law", "-h"]).contains("Terms:"));
}

/// The pages of the laws name commands that an installed user has.
#[test]
fn pages_of_laws_name_the_installed_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/laws");
    for page in std::fs::read_dir(folder).unwrap() {
        let text = std::fs::read_to_string(page.unwrap().path()).unwrap();
        for line in text.lines().filter(|line| line.contains("cargo xtask")) {
            assert!(line.contains("from a clone of the repository"), "{line}");
        }
    }
}
