//! Tests that `cargo xtask` runs every command of `gfmd`, with its own name in the help.

use std::process::Command;

#[test]
fn commands_of_the_program_are_here_under_the_name_that_was_called() {
    let help = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().expect("the program starts");
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let all = help(&["--help"]);
    for command in ["contact", "kappa-sweep", "green", "verify", "bench-peers", "bench-rows"] {
        assert!(all.contains(&format!("\n  {command} ")), "{command}: {all}");
        let text = help(&[command, "--help"]);
        assert!(text.contains(&format!("Usage: cargo xtask {command} ")), "{text}");
        assert!(text.contains(&format!("\n  cargo xtask {command}")) && !text.contains("\n  gfmd "), "{text}");
    }
}
