//! Adverse conditions: outputs named like inputs, pipes instead of files, a stderr that cannot be written, a file size
//! limit, untrusted files.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use gfmd_problem::MemoryNeed;

use crate::common::gfmd;

const SURFACE: &str = "surface --n 16 --eps-f-inv 4 -q --out";

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn done(folder: &Path, line: &str) {
    let output = gfmd(folder, &words(line));
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

fn sh(folder: &Path, script: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_gfmd");
    let mut command = Command::new("bash");
    command.arg("-c").arg(script).env("GFMD", program).current_dir(folder).stdin(Stdio::null());
    command.output().expect("bash starts")
}

/// Runs a line that must be refused because of the output `flag`; nothing in the folder changes.
fn keeps(folder: &Path, line: &str, flag: &str, input: &str) {
    let contents = || {
        let mut all: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .map(|path| (path.clone(), fs::read(&path).unwrap()))
            .collect();
        all.sort();
        all
    };
    let before = contents();
    let output = gfmd(folder, &words(line));
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {text}");
    assert!(text.contains(flag), "{text}");
    assert!(text.contains("another file than the input"), "{text}");
    assert!(text.contains(input), "{text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    assert!(contents() == before, "{line}");
}

#[test]
fn no_output_replaces_an_input() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    done(folder.path(), &format!("{SURFACE} s.npy"));
    done(folder.path(), &format!("{SURFACE} s.h5"));
    done(folder.path(), "contact --surface s.npy --p-star 0.05 -q --out result.h5");
    fs::write(at("law.csv"), "0,1\n0.01,0.5\n0.02,0.1\n0.03,0\n").unwrap();
    fs::write(at("g.csv"), "1,2\n10,0.2\n100,0.02\n1000,0.002\n").unwrap();
    fs::write(at("sweep.toml"), crate::common::SWEEP).unwrap();
    fs::hard_link(at("s.npy"), at("hard.npy")).unwrap();
    symlink(at("s.npy"), at("soft.npy")).unwrap();
    fs::copy(at("s.npy"), at("r.h5.part")).unwrap();
    for (line, flag, input) in [
        ("contact --surface s.npy --p-star 0.05 --out s.npy", "--out", "--surface"),
        ("contact --surface=s.npy --p-star 0.05 --out=./s.npy", "--out", "--surface"),
        ("contact --surface s.npy --p-star 0.05 --out hard.npy", "--out", "--surface"),
        ("contact --surface s.npy --p-star 0.05 --out soft.npy", "--out", "--surface"),
        ("contact --surface soft.npy --p-star 0.05 --vtk hard.npy", "--vtk", "--surface"),
        ("contact --surface s.h5:/surface/height --p-star 0.05 --out s.h5", "--out", "--surface"),
        ("contact --surface r.h5.part --p-star 0.05 --out r.h5", "--out", "--surface"),
        ("contact --n 16 --eps-f-inv 4 --second-surface s.npy --p-star 0.05 --out s.npy", "--out", "--second-surface"),
        ("contact --n 16 --eps-f-inv 4 --hardness s.npy --p-star 0.05 --out s.npy", "--out", "--hardness"),
        ("contact --n 16 --height 1 --lower-surface s.npy --p-star 0.05 --out s.npy", "--out", "--lower-surface"),
        ("contact --n 16 --height 1 --base-displacement s.npy --p-star 0.05 --out s.npy", "--out", "--base"),
        ("contact --n 16 --law table --law-table law.csv --p-star 0.05 --out law.csv", "--out", "--law-table"),
        ("contact --n 16 --compliance g.csv --young 1 --p-star 0.05 --out g.csv", "--out", "--compliance"),
        ("path --surface s.npy --p-star 0.05 --steps 1 --out s.npy", "--out", "--surface"),
        ("wear --surface s.npy --p-star 0.05 --coefficient 1 --distance 1 --steps 1 --out s.npy", "--out", "--surface"),
        ("slide --surface s.npy --p-star 0.05 --prony 1:0.5 --velocity 1 --out s.npy", "--out", "--surface"),
        ("surface --surface s.npy --out s.npy", "--out", "--surface"),
        ("surface --surface s.npy --report s.npy", "--report", "--surface"),
        ("body --surface result.h5 --depths 0.1 --out result.h5", "--out", "--surface"),
        ("punch --n 16 --mask s.npy --out s.npy", "--out", "--mask"),
        ("kappa-sweep --config sweep.toml --out sweep.toml", "--out", "--config"),
        ("report result.h5 --out result.h5", "--out", "input"),
    ] {
        keeps(folder.path(), line, flag, input);
    }
}

#[test]
fn an_output_has_the_permissions_of_the_file_that_it_replaces() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("c.h5");
    let line = "contact --n 16 --eps-f-inv 4 --p-star 0.05 -q --out c.h5";
    for mode in [0o600, 0o640, 0o664] {
        fs::write(&out, "old").unwrap();
        fs::set_permissions(&out, fs::Permissions::from_mode(mode)).unwrap();
        done(folder.path(), line);
        assert_eq!(fs::metadata(&out).unwrap().permissions().mode() & 0o777, mode);
    }
    fs::set_permissions(&out, fs::Permissions::from_mode(0o444)).unwrap();
    let before = fs::read(&out).unwrap();
    let output = gfmd(folder.path(), &words(line));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2), "{text}");
    assert!(text.contains("--out"), "{text}");
    assert!(text.contains("it is read-only"), "{text}");
    assert_eq!(fs::read(&out).unwrap(), before);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// The test ends: a pipe without a writer is not opened.
#[test]
fn a_table_in_a_pipe_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(sh(folder.path(), "mkfifo pipe").status.success());
    for (line, flag) in [
        ("contact --n 16 --eps-f-inv 4 --p-star 0.05 --young 1 --compliance pipe", "--compliance"),
        ("contact --n 16 --eps-f-inv 4 --p-star 0.05 --law table --law-table pipe", "--law-table"),
        ("law --law table --law-table pipe --normal 0", "--law-table"),
        ("contact --surface pipe --p-star 0.05", "pipe"),
        ("contact --n 16 --eps-f-inv 4 --p-star 0.05 --hardness pipe", "--hardness"),
        ("kappa-sweep --config pipe --dry-run", "pipe"),
        ("punch --n 16 --mask pipe", "--mask"),
        ("check pipe", "pipe"),
    ] {
        let output = sh(folder.path(), &format!("timeout 20 $GFMD {line}"));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(flag) && text.contains("it is a pipe; it must be a regular file"), "{line}: {text}");
    }
}

/// A run with warnings finishes and keeps its result even if no warning can be written.
#[test]
fn a_stderr_that_cannot_be_written_ends_no_run() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let line = "$GFMD contact --n 16 --eps-f-inv 4 --p-star 0.02,0.05 --json";
    let right = sh(folder.path(), line);
    assert!(right.status.success() && !right.stderr.is_empty(), "the run warns");
    for (name, to) in [("full", "2>/dev/full"), ("closed", "2> >(exec true)"), ("none", "2>&-")] {
        for verbose in ["", "-vv"] {
            let output = sh(folder.path(), &format!("{line} --out {name}.h5 {verbose} {to}"));
            assert_eq!(output.status.code(), Some(0), "{name} {verbose}: {}", String::from_utf8_lossy(&output.stderr));
            assert!(folder.path().join(format!("{name}.h5")).exists(), "{name}");
            assert!(!output.stdout.is_empty());
        }
    }
    // A failure keeps its status.
    for to in ["2>/dev/full", "2>&-"] {
        assert_eq!(sh(folder.path(), &format!("$GFMD contact --n 16 --p-star nan {to}")).status.code(), Some(2));
        assert_eq!(sh(folder.path(), &format!("$GFMD nothing {to}")).status.code(), Some(2));
    }
    // A stdout that cannot be written is a failure, after the file is kept.
    let output = sh(folder.path(), "$GFMD contact --n 16 --p-star 0.05 --out out.h5 -q >/dev/full");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("cannot write the result") && folder.path().join("out.h5").exists(), "{text}");
}

#[test]
fn beyond_the_limit_of_the_size_of_files_a_run_fails_with_words() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, line) in [
        ("a.h5", "wear --n 64 --eps-f-inv 16 --p-star 0.05 --coefficient 1 --distance 0,0.1:2:8 --steps 4 --out a.h5"),
        ("b.vtp", "contact --n 64 --p-star 0.05 --vtk b.vtp"),
        ("c.npy", "surface --n 128 --out c.npy"),
    ] {
        fs::write(at(name), "old").unwrap();
        let output = sh(folder.path(), &format!("ulimit -f 10; $GFMD {line} -q"));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {text}");
        assert!(text.to_lowercase().contains("file too large") && text.trim_end().lines().count() == 1, "{text}");
        assert_eq!(fs::read(at(name)).unwrap(), b"old");
    }
}

/// A launcher's variable is left over: no process has rank 0, and each gives the reason why it ends.
#[test]
fn a_process_of_any_rank_says_why_it_does_not_start() {
    let folder = tempfile::tempdir().unwrap();
    let line = "OMPI_COMM_WORLD_SIZE=4 OMPI_COMM_WORLD_RANK=3 GFMD_MPI=no-such-library.so $GFMD contact --n 16 \
                --p-star 0.05";
    let output = sh(folder.path(), line);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("GFMD_MPI") && text.trim_end().lines().count() == 1, "{text}");
}

/// Changes a result with the HDF5 library. A copy has no lock of another process.
fn edit(path: &Path, change: impl FnOnce(&hdf5::File)) {
    let [changing, fresh] = ["changing", "fresh"].map(|end| path.with_extension(end));
    fs::copy(path, &changing).unwrap();
    let open = hdf5::File::open_rw(&changing).unwrap();
    change(&open);
    open.close().unwrap();
    fs::copy(&changing, &fresh).unwrap();
    fs::rename(&fresh, path).unwrap();
    fs::remove_file(&changing).unwrap();
}

/// Untrusted files with variables larger than their grid, or chunks larger than memory, cost nothing.
#[test]
fn variables_beyond_the_layout_are_refused_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    done(folder.path(), "contact --n 16 --eps-f-inv 4 --p-star 0.05 -q --out honest.h5");
    type Change = fn(&hdf5::File);
    let cases: [(&str, Change); 4] = [
        ("one-chunk", |file| {
            // Zeros compressed to a thousandth, in one chunk.
            file.unlink("/fields/gap").unwrap();
            let zeros = ndarray::Array1::<f64>::zeros(1 << 22);
            file.new_dataset_builder().with_data(&zeros).chunk(1 << 22).deflate(9).create("/fields/gap").unwrap();
        }),
        ("sparse", |file| {
            file.unlink("/fields/gap").unwrap();
            let made = file.new_dataset::<f64>().shape([1, 1 << 20, 1 << 20]).chunk([1, 512, 512]).deflate(9);
            made.create("/fields/gap").unwrap();
        }),
        ("large-chunk", |file| {
            file.unlink("/fields/gap").unwrap();
            let made = file.new_dataset::<f64>().shape((1.., 16.., 16..)).chunk([1, 1 << 14, 1 << 14]).deflate(9);
            made.create("/fields/gap").unwrap();
        }),
        ("another-group", |file| {
            file.create_group("strange").unwrap();
            let zeros = ndarray::Array1::<f64>::zeros(1 << 22);
            file.new_dataset_builder().with_data(&zeros).chunk(1 << 22).deflate(9).create("/strange/zeros").unwrap();
        }),
    ];
    for (name, change) in cases {
        let file = format!("{name}.h5");
        fs::copy(at("honest.h5"), at(&file)).unwrap();
        edit(&at(&file), change);
        for line in [format!("check {file}"), format!("report {file} --out {name}.html")] {
            let output = sh(folder.path(), &format!("ulimit -v 8000000; timeout 20 $GFMD {line}"));
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(matches!(output.status.code(), Some(1 | 2)), "{line}: {:?} {text}", output.status);
            assert_eq!(text.trim_end().lines().count(), 1, "{line}: {text}");
            assert!(!at(&format!("{name}.html")).exists());
        }
    }
}

/// Empty groups are not part of a result, although nothing in them counts.
#[test]
fn a_result_with_empty_groups_is_not_intact() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), "contact --n 16 --eps-f-inv 4 --p-star 0.05 -q --out c.h5");
    done(folder.path(), "body --surface c.h5 --depths 0.1 -q --out b.h5");
    // The first file is the input of the second.
    for name in ["b.h5", "c.h5"] {
        done(folder.path(), &format!("check {name}"));
        edit(&folder.path().join(name), |file| {
            (0..20).for_each(|number| drop(file.create_group(&format!("g{number}")).unwrap()));
        });
        let output = gfmd(folder.path(), &["check", name]);
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stderr).contains("content_sha256"));
    }
}

/// Numbers that no run can use are refused with the name of their flag.
#[test]
fn messages_name_the_flag_that_is_to_blame() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("g.csv"), "1,2\n10,0.2\n5,0.02\n").unwrap();
    let rough = "--n 16 --eps-f-inv 4 --p-star 0.05";
    for (line, words) in [
        (format!("wear {rough} --coefficient 1 --distance 1e12 --steps 2"), "--distance is 1e12; it must be at most"),
        (format!("contact {rough} --size 5e-324"), "--size is 5e-324; it must be between 1e-140 and 1e140"),
        ("surface --n 16 --eps-f-inv 4 --size 1e-200".into(), "--size is 1e-200; it must be between"),
        ("body --n 2147483648 --young 1 --wave 1,0,z,1 --depths 0.1".into(), "--n: "),
        ("kappa-sweep --target 2 --dry-run".into(), "--target is 2; it must be from 1e-5 to 1"),
        (
            format!("slide {rough} --heat 1,0.1,0.3,0.2 --friction 1e300 --velocity 1"),
            "--friction is 1e300; it must be at least 0 and at most 1e140",
        ),
        ("punch --n 16 --shift 1e300".into(), "--shift is 1e300; it must be from -1e140 to 1e140"),
        ("punch --n 16 --shift=0,-1e300".into(), "--shift is -1e300"),
        (
            format!("contact {rough} --young 1 --compliance g.csv"),
            "row 3 begins with 5; it must begin with a number above that of row 2, 10",
        ),
    ] {
        let output = gfmd(folder.path(), &self::words(&line));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && text.contains(words), "{line}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    }
}

/// The memory check counts at least the peak of a run with the flow, in fields, from two sizes.
#[test]
fn the_memory_of_a_flow_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    for (line, counted) in [
        ("contact --p-star 0.05 --eps-f-inv 16", MemoryNeed::FLOW),
        ("contact --p-star 0.02,0.1 --eps-f-inv 16 --grid-error none --out c.h5", MemoryNeed::FLOW),
        ("path --p-star 0.02,0.05 --eps-f-inv 16 --steps 1 --grid-error none", MemoryNeed::FLOW_ON_PATH),
    ] {
        let peak = |n: u64| {
            let output = sh(folder.path(), &format!("$GFMD {line} --n {n} --flow --json -q --threads 1"));
            let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            report["peak_bytes"].as_f64().unwrap()
        };
        let fields = (peak(512) - peak(256)) / (8.0 * (512.0 * 512.0 - 256.0 * 256.0));
        assert!(fields > 13.0 && fields <= counted.0 as f64, "{line}: {fields} fields, {counted:?}");
    }
    // Memory for 13 fields, enough for a run without the flow.
    for line in ["contact --p-star 0.05", "path --p-star 0.05 --steps 1"] {
        let script = format!("ulimit -v 5000000; timeout 100 $GFMD {line} --n 4096 --eps-f-inv 16 --flow");
        let output = sh(folder.path(), &script);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && text.contains("4096 x 4096 points"), "{line}: {text}");
    }
}
