//! Command lines as users first type them: they work, or one line gives the replacement.

use std::path::Path;
use std::process::Command;

use crate::common::{gfmd, json, numbers};
use ndarray::Array2;

/// Creates a folder with a map of 16 x 16 points without a unit, and the same map as a list in micrometres.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 16.0).cos();
    let heights = Array2::from_shape_fn((16, 16), |(i, j)| 0.01 * (wave(i) * wave(j) + 0.3 * wave(3 * i + j)));
    ndarray_npy::write_npy(folder.path().join("scan.npy"), &heights).unwrap();
    folder
}

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

/// Returns the single line of a refusal.
fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{flags}: {text}");
    text
}

/// Runs two command lines and checks that their files have the same numbers.
fn same(folder: &Path, plain: &str, guess: &str) {
    for (flags, out) in [(plain, "plain.h5"), (guess, "guess.h5")] {
        let flags = format!("{flags} --json -q --out {out}");
        let flags = flags.replace("--json -q", if flags.starts_with("surface") { "-q" } else { "--json -q" });
        let output = gfmd(folder, &words(&flags));
        assert!(output.status.success(), "{flags}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(numbers(&folder.join("plain.h5")), numbers(&folder.join("guess.h5")), "{guess}");
}

#[test]
fn a_file_that_stands_alone_is_the_surface() {
    let folder = folder();
    for (command, flags) in [
        ("contact", "--size 1 --p-star 0.05"),
        ("surface", "--size 1"),
        ("path", "--size 1 --p-star 0.05 --steps 1"),
        ("slide", "--size 1 --p-star 0.05 --prony 1:0.5 --velocity 0.1"),
        ("wear", "--size 1 --p-star 0.05 --coefficient 1 --distance 0.1 --steps 1"),
    ] {
        let plain = format!("{command} --surface scan.npy {flags}");
        same(folder.path(), &plain, &format!("{command} scan.npy {flags}"));
        same(folder.path(), &plain, &format!("{command} {flags} scan.npy"));
    }
    std::fs::copy(folder.path().join("scan.npy"), folder.path().join("2um.npy")).unwrap();
    for file in ["2um.npy", "./scan.npy"] {
        let rest = format!("contact --p-star 0.05 --size 1 {file}");
        same(folder.path(), "contact --surface scan.npy --size 1 --p-star 0.05", &rest);
    }
    let of = |flags: &str| json(folder.path(), &words(flags));
    let theory = "--size 1 --p-star 0.05 --json -q";
    assert_eq!(of(&format!("theory --surface scan.npy {theory}")), of(&format!("theory scan.npy {theory}")));
    of("contact scan.npy --size 1 --p-star 0.05 --json -q --out pressed.h5");
    same(folder.path(), "body --surface pressed.h5 --depths 0.1,0.2", "body --depths 0.1,0.2 pressed.h5");
    // After flags of all commands, and after one without a value.
    same(
        folder.path(),
        "contact --surface scan.npy --size 1 --p-star 0.05 --statistics",
        "contact --threads 1 --size 1 --p-star 0.05 --statistics scan.npy",
    );
    let text = refused(folder.path(), "contact scan.npy other.npy --p-star 0.05");
    assert!(text.contains("'other.npy' found; the surface is scan.npy") && text.contains("--lower-surface"), "{text}");
    let text = refused(folder.path(), "punch scan.npy");
    assert!(text.contains("punch reads no surface"), "{text}");
    let text = refused(folder.path(), "kappa-sweep sweep.toml");
    assert!(text.contains("write --config sweep.toml"), "{text}");
    let text = refused(folder.path(), "contact absent.sur --p-star 0.05");
    assert!(text.contains("absent.sur"), "{text}");
}

#[test]
fn values_may_begin_with_minus() {
    let folder = folder();
    let start = "contact --surface scan.npy --unit um --size 100um --young 70GPa";
    same(folder.path(), &format!("{start} --approach=1nm,2nm"), &format!("{start} --approach 1nm,2nm"));
    let pulled = "path --surface scan.npy --unit um --size 100um --young 70GPa --steps 1 --law exponential --coarse \
                  --param gamma=0.05J/m^2,range=50nm";
    for values in ["-10nm,10nm", "-0.01,0.01", "-10nm", "-10nm,-5nm"] {
        let [joined, apart] = ["=", " "].map(|between| format!("{pulled} --approach{between}{values}"));
        same(folder.path(), &joined, &apart);
    }
    same(folder.path(), &format!("{pulled} --approach=-10nm,10nm"), &format!("{pulled} --approach -10 nm,10 nm"));
    let drawn = "path --surface scan.npy --size 1 --p-star 0.05 --friction 0.3 --steps 1 --lateral";
    same(folder.path(), &format!("{drawn}=-0.001,0.001"), &format!("{drawn} -0.001,0.001"));
    // Each command refuses its invalid values with its own reason.
    for (flags, reason) in [
        ("contact --n 16 --p-star -0.1,0.1", "must be positive"),
        ("slide --n 16 --prony 1:0.5 --p-star 0.1 --velocity -1,1", "must be"),
        ("wear --n 16 --p-star 0.1 --coefficient 1 --distance -1,1", "must be"),
        ("theory --n 16 --p-star -1,2", "must be"),
        ("contact --n 16 --size -1,1 --p-star 0.1", "must be"),
    ] {
        let text = refused(folder.path(), flags);
        assert!(text.contains(reason) && !text.contains("unexpected argument"), "{flags}: {text}");
    }
}

#[test]
fn a_number_and_its_unit_may_be_two_words() {
    let folder = folder();
    same(
        folder.path(),
        "contact --surface scan.npy --unit um --size 100um --young 70GPa --height 2um --pressure 1MPa",
        "contact scan.npy --unit um --size 100 um --young 70 GPa --height 2 um --pressure 1 MPa",
    );
    same(
        folder.path(),
        "contact --surface scan.npy --unit um --size 100um --young 70GPa --pressure 1MPa,2MPa,4MPa",
        "contact --unit um --size 100um --young=70 GPa --pressure 1 MPa,2 MPa,4 MPa scan.npy",
    );
    same(
        folder.path(),
        "path --surface scan.npy --unit um --size 100um --young 2GPa --prony 1s:0.5 --pressure 1MPa --time 0,3min \
         --steps 1",
        "path scan.npy --unit um --size 100um --young 2GPa --prony 1s:0.5 --pressure 1 MPa --time 0,3 min --steps 1",
    );
    for (flags, reason) in [
        ("contact scan.npy --unit um --young 70GPa --pressure 1,2 MPa", "as in 1MPa,2MPa"),
        ("contact scan.npy --unit um --young 70GPa --pressure 1 Mpa", "\"Mpa\" is no unit"),
        ("contact scan.npy --unit um --young 70GPa --pressure 1MPa 2MPa", "--pressure 1MPa,2MPa"),
        ("contact scan.npy --p-star 0.1 0.2", "--p-star 0.1,0.2"),
        ("contact scan.npy --unit um --young 70 nm --pressure 1 MPa", "it is a length"),
    ] {
        let text = refused(folder.path(), flags);
        assert!(text.contains(reason), "{flags}: {text}");
    }
}

#[test]
fn former_names_of_options_are_understood() {
    let folder = folder();
    for (former, present) in [
        (
            "contact scan.npy --length=100 um --unit um --young 70GPa --displacement 1 nm,3 nm --tol 1e-9 \
             --max-iter 999",
            "contact scan.npy --size 100um --unit um --young 70GPa --approach 1nm,3nm --tolerance 1e-9 \
             --max-iterations 999",
        ),
        (
            "contact --n 16 --length 1mm --young 2GPa --pressure 1MPa --stiffness-tol 1e-9",
            "contact --n 16 --size 1mm --young 2GPa --pressure 1MPa --stiffness-tolerance 1e-9",
        ),
        (
            "path --n 16 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=0.02 --coarse \
             --displacement -0.001,0.002 --steps 1 --energy-tol 1e-2",
            "path --n 16 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=0.02 --coarse \
             --approach=-0.001,0.002 --steps 1 --energy-tolerance 1e-2",
        ),
    ] {
        same(folder.path(), former, present);
    }
    let text = refused(folder.path(), "contact scan.npy --displacement 1nm 2nm");
    assert!(text.contains("--approach 1nm,2nm") && !text.contains("--displacement"), "{text}");
}

#[test]
fn the_length_of_a_cell_has_the_unit_of_heights_that_are_made() {
    let folder = folder();
    let made = "contact --n 16 --young 70GPa --pressure 10MPa --rms-height 1um --size 1mm";
    same(folder.path(), &format!("{made} --unit mm"), made);
    let report = json(folder.path(), &words(&format!("{made} --json -q")));
    assert_eq!(report["unit"], "mm");
    assert!((report["rms_height"].as_f64().unwrap() - 1e-3).abs() < 1e-15, "{report}");
    // The unit of heights in a file is not guessed.
    let text = refused(folder.path(), "contact scan.npy --young 70GPa --pressure 10MPa --size 1mm");
    assert!(text.contains("--unit"), "{text}");
    let text = refused(folder.path(), "contact --n 16 --young 70GPa --pressure 10MPa --size 1s");
    assert!(text.contains("it must be a length"), "{text}");
}

#[test]
fn other_names_of_options_are_answered_with_theirs() {
    let folder = folder();
    for (flags, reason) in [
        ("contact scan.npy --load=1N", "write --force"),
        ("path scan.npy --weight 1 N", "write --force"),
        ("theory scan.npy --load 1N", "write --force"),
        ("contact scan.npy --prony 1:0.5", "gfmd path --prony"),
        ("contact scan.npy --time 1", "gfmd path --prony"),
        ("contact scan.npy --nu 0.3", "write --poisson"),
        ("contact scan.npy --E 70GPa", "write --young"),
        ("contact scan.npy --lx 1mm", "write --size"),
        ("contact scan.npy --p_star 0.1", "write --p-star"),
        ("contact --n 16 --rms-slope 0.1", "write --rms-gradient"),
        ("contact scan.npy --indentation 1nm", "write --approach"),
        ("contact scan.npy --output a.h5", "write --out"),
        ("contact scan.npy --gamma 0.05", "--law exponential --param gamma="),
        ("contact scan.npy --velocity 1", "an option of gfmd slide"),
        ("contact scan.npy --leak 1", "--flow --viscosity"),
        ("surface scan.npy --p-star 1", "an option of gfmd contact"),
        ("contact scan.npy --p-star 0.1 --law jkr", "exponential with gamma"),
        ("contact scan.npy --p-star 0.1 --law DMT", "exponential with gamma"),
        ("contact scan.npy --p-star 0.1 --law lennard-jones", "table takes gaps"),
    ] {
        let text = refused(folder.path(), flags);
        assert!(text.contains(reason), "{flags}: {text}");
    }
    // An unknown name.
    let text = refused(folder.path(), "contact scan.npy --nonsense 1");
    assert!(text.contains("--nonsense"), "{text}");
}

/// Returns the lines shown on a terminal with this number of columns.
#[cfg(unix)]
fn on_terminal(folder: &Path, columns: u16, flags: &str) -> Vec<String> {
    let script = "import fcntl, os, pty, struct, sys, termios\n\
                  pid, fd = pty.fork()\n\
                  if pid == 0:\n    \
                      fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack('HHHH', 24, int(sys.argv[1]), 0, 0))\n    \
                      os.execv(sys.argv[2], sys.argv[2:])\n\
                  found = b''\n\
                  try:\n    \
                      while part := os.read(fd, 4096):\n        \
                          found += part\n\
                  except OSError:\n    \
                      pass\n\
                  print(found.decode().replace('\\r', ''))\n";
    let columns = columns.to_string();
    let words = [&["-c", script, &columns, env!("CARGO_BIN_EXE_gfmd")], words(flags).as_slice()].concat();
    let output = Command::new("python3").args(words).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[cfg(unix)]
#[test]
fn tables_are_narrower_on_a_narrow_terminal_and_no_wider_on_a_wide_one() {
    let folder = folder();
    for flags in [
        "contact --n 16 --p-star 0.05,0.1 -q",
        "path --n 16 --p-star 0.05,0.1 --steps 1 -q",
        "slide --n 16 --prony 1:0.5 --p-star 0.05 --velocity 0.1 -q",
    ] {
        let head = |lines: &[String]| lines.iter().find(|line| line.contains(" area")).unwrap().clone();
        let whole = head(&on_terminal(folder.path(), 80, &format!("{flags} --wide")));
        assert!(["steps", "pairs", "residual"].iter().all(|word| whole.contains(word)), "{flags}: {whole}");
        let piped = String::from_utf8(gfmd(folder.path(), &words(flags)).stdout).unwrap();
        let usual = head(&piped.lines().map(str::to_owned).collect::<Vec<_>>());
        for columns in [80, 300] {
            assert_eq!(head(&on_terminal(folder.path(), columns, flags)), usual);
        }
        let columns = usual.len() as u16;
        let [exact, narrow] = [columns, columns - 1].map(|columns| head(&on_terminal(folder.path(), columns, flags)));
        assert_eq!(exact, usual);
        assert!(narrow.len() < usual.len() && narrow.contains("area"), "{flags}: {narrow}");
    }
}

#[test]
fn tables_explain_flow_and_conductance_and_have_heads_of_one_meaning() {
    let folder = folder();
    let output = gfmd(folder.path(), &words("contact --n 32 --p-star 0.05 --statistics --flow -q"));
    let text = String::from_utf8(output.stdout).unwrap();
    for word in ["patch spans x", "open along x", "--viscosity 1mPa*s", "--conductivity K1,K2"] {
        assert_eq!(text.matches(word).count(), 1, "{word}: {text}");
    }
    assert!(!text.contains("through x"), "{text}");
    let output = gfmd(folder.path(), &words("path --n 32 --p-star 0.05 --steps 1 --flow -q"));
    assert!(String::from_utf8(output.stdout).unwrap().contains("--viscosity 1mPa*s"));
}
