//! Extreme and impossible input for every flag of every command: each case ends within its time and memory, with finite
//! numbers of a converged state, or with one line that names the cause.
//!
//! The default run takes every thirteenth case. `GFMD_EXTREME=all cargo test -p gfmd-cli --test suite extreme:: --
//! --nocapture` takes all cases and prints their number.

#![expect(clippy::print_stdout, reason = "the count of cases")]

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::common::gfmd;
use serde_json::Value;

/// Limits of time and address space of a case. A debug build on a busy machine is slow.
const SECONDS: u64 = 60;
const ADDRESSES_KIB: u64 = 12 << 20;

const NUMBERS: [&str; 29] = [
    "0",
    "-0",
    "5e-324",
    "1e-320",
    "1e-300",
    "1e-200",
    "1e-150",
    "1e-100",
    "1e-30",
    "1e-12",
    "0.3",
    "0.4999999",
    "0.5",
    "1",
    "-1e-9",
    "-0.99",
    "-1",
    "1e12",
    "1e30",
    "1e100",
    "1e150",
    "1e200",
    "1e300",
    "1.7e308",
    "inf",
    "-inf",
    "nan",
    "1e400",
    "2147483648",
];

const COUNTS: [&str; 13] = [
    "0",
    "1",
    "2",
    "3",
    "7",
    "-1",
    "1.5",
    "nan",
    "2147483648",
    "4294967296",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
];

const LISTS: [&str; 10] = ["", ",", "0.1,", "nan", "0.1,nan", "1,1", "0.01,0.01", "0.02,0.01", "1e100,1e-100", "1,2,3"];

/// Command that succeeds, and the flags with values to replace or add: numbers, counts and lists. `@NAME` is a
/// parameter of the law.
struct Base {
    line: &'static str,
    numbers: &'static str,
    counts: &'static str,
    lists: &'static str,
}

const BASES: &[Base] = &[
    Base {
        line: "contact --n 8 --eps-f-inv 2 --p-star 0.05",
        numbers: "--size --young --poisson --e-star --height --tolerance --hurst --eps-t-inv --eps-f-inv \
                  --rms-gradient --rms-height --roll-off --p-star --pressure --approach",
        counts: "--n --max-iterations --threads --seed --dim",
        lists: "--p-star --pressure --approach --size --n",
    },
    Base {
        line: "contact --n 8 --eps-f-inv 2 --height 0.3 --approach 0.01",
        numbers: "--size --young --poisson --height --rms-gradient --approach",
        counts: "",
        lists: "--approach",
    },
    Base {
        line: "contact --n 8 --eps-f-inv 2 --law exponential --param gamma=1e-4,range=0.01 --p-star 0.05",
        numbers: "--size --young --poisson --height --rms-gradient --p-star --pressure --approach @gamma @range",
        counts: "--max-iterations",
        lists: "--p-star --approach",
    },
    Base {
        line: "path --n 8 --eps-f-inv 2 --law morse --param gamma=1e-4,range=0.01 --approach=-0.005,0.005 \
               --steps 1 --max-iterations 3000",
        numbers: "--size --young --height --tolerance --energy-tolerance --approach --pressure --lateral --direction \
                  @gamma @range",
        counts: "--steps --max-iterations --energy-solves --n",
        lists: "--approach --lateral",
    },
    Base {
        line: "path --n 6 --eps-f-inv 1 --eps-t-inv 1 --p-star 0.05 --friction 0.3 --lateral 0,0.002 --steps 1",
        numbers: "--size --young --poisson --height --friction --p-star --approach --lateral --tolerance \
                  --rms-gradient",
        counts: "--steps",
        lists: "--p-star --lateral",
    },
    Base {
        line: "path --n 6 --eps-f-inv 1 --eps-t-inv 1 --p-star 0.05 --shear-strength 0.01 --lateral 0,0.002 --steps 1",
        numbers: "--young --shear-strength --lateral",
        counts: "",
        lists: "",
    },
    Base {
        line: "punch --n 8",
        numbers: "--size --height --young --poisson --punch-fraction --depth --tolerance",
        counts: "--n --refine --max-iterations --dim",
        lists: "",
    },
    Base {
        line: "punch --n 8 --contact frictionless --height inf --dim 2",
        numbers: "--size --young --poisson --depth",
        counts: "",
        lists: "",
    },
    Base {
        line: "surface --n 16 --eps-f-inv 4",
        numbers: "--size --hurst --eps-t-inv --eps-f-inv --rms-gradient --rms-height --roll-off --fit-range",
        counts: "--n --seed --dim --threads",
        lists: "--size --n --fit-range",
    },
    Base {
        line: "surface --n 16 --method rmd",
        numbers: "--size --hurst --rms-gradient --rms-height",
        counts: "--n",
        lists: "",
    },
    Base {
        line: "green --qx 3 --qy 4 --height 0.3 --poisson 0.3 --z 0.1",
        numbers: "--qx --qy --height --young --poisson --z --depth",
        counts: "--dim",
        lists: "",
    },
    Base {
        line: "green --qx 3 --height 0.3 --base half-space --base-young 10 --base-poisson 0.2 --depth 0.1",
        numbers: "--qx --height --young --poisson --depth --base-young --base-poisson",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law npc --param phi_n=1,phi_t=1,delta_n=0.1,delta_t=0.1 --normal 0.1 --tangential 0.1",
        numbers: "--normal --tangential @phi_n @phi_t @delta_n @delta_t",
        counts: "",
        lists: "--normal",
    },
    Base {
        line: "law --law xu-needleman --param phi_n=1,phi_t=1,delta_n=0.1,delta_t=0.1,r=0.1 --normal 0.1 \
               --tangential 0.1",
        numbers: "--normal --tangential @phi_n @phi_t @delta_n @delta_t @r",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law bsg --param phi_n=1,phi_t=1,delta_n=0.1,delta_t=0.1 --normal 0.1 --tangential 0.1",
        numbers: "--normal --tangential @phi_n @delta_t",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law c3d --param phi_n=1,phi_t=1,delta_n=0.1,delta_t=0.1 --normal 0.1 --tangential 0.1",
        numbers: "--normal --tangential @phi_t @delta_n",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law npb --param phi_n=1,phi_t=1,delta_n=0.1,delta_t=0.1 --normal 0.1 --tangential 0.1",
        numbers: "--normal --tangential @phi_n @delta_n",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law morse --param gamma=1,range=0.1 --normal 0.1",
        numbers: "--normal @gamma @range",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law exponential --param gamma=1,range=0.1 --normal 0.1",
        numbers: "--normal @gamma @range",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law harmonic-cosine --param gamma=1,curvature=0.1 --normal 0.1",
        numbers: "--normal @gamma @curvature",
        counts: "",
        lists: "",
    },
    Base {
        line: "law --law dugdale --param gamma=1,range=0.1 --normal 0.1",
        numbers: "--normal @gamma @range",
        counts: "",
        lists: "",
    },
    Base {
        line: "body --surface contact.h5 --levels 3 --deepest 0.2",
        numbers: "--size --young --poisson --e-star --height --deepest --depths",
        counts: "--levels --load",
        lists: "--depths --size",
    },
    Base {
        line: "body --surface punch.h5 --levels 3",
        numbers: "--size --young --poisson --height --deepest --depths",
        counts: "--levels",
        lists: "",
    },
];

/// Mutually exclusive flags: a new one replaces the others.
const EXCLUSIVE: [&[&str]; 4] = [
    &["--p-star", "--pressure", "--approach"],
    &["--depth", "--z"],
    &["--depths", "--levels", "--deepest"],
    &["--rms-gradient", "--rms-height"],
];

/// Returns the line with the value of a flag, or of the parameter `@NAME`, replaced or added.
fn with(line: &str, flag: &str, value: &str) -> Vec<String> {
    if let Some(name) = flag.strip_prefix('@') {
        let parameter = |text: &str| match text.split_once('=') {
            Some((found, _)) if found == name => format!("{name}={value}"),
            _ => text.to_owned(),
        };
        let word = |word: &str| {
            if word.starts_with('-') {
                word.to_owned()
            } else {
                word.split(',').map(parameter).collect::<Vec<_>>().join(",")
            }
        };
        return line.split_whitespace().map(word).collect();
    }
    let group = EXCLUSIVE.into_iter().find(|group| group.contains(&flag)).unwrap_or(&[]);
    // --levels needs --deepest.
    let removed = |word: &str| {
        word == flag
            || group.contains(&word)
                && !(flag == "--levels" && word == "--deepest")
                && !(flag == "--deepest" && word == "--levels")
    };
    let mut words: Vec<String> = Vec::new();
    let mut skip = false;
    for word in line.split_whitespace() {
        let name = word.split('=').next().unwrap_or(word);
        if removed(name) {
            skip = !word.contains('=');
        } else if !std::mem::take(&mut skip) {
            words.push(word.to_owned());
        }
    }
    words.push(format!("{flag}={value}"));
    words
}

fn cases() -> Vec<Vec<String>> {
    let mut cases = Vec::new();
    for base in BASES {
        for (flags, values) in [(base.numbers, &NUMBERS[..]), (base.counts, &COUNTS[..]), (base.lists, &LISTS[..])] {
            for flag in flags.split_whitespace() {
                cases.extend(values.iter().map(|value| with(base.line, flag, value)));
            }
        }
    }
    cases
}

/// Runs the program with limits of time and memory; the status is `None` after a timeout or a signal.
fn limited(folder: &Path, words: &[String]) -> (Option<i32>, String, String) {
    let script = format!("ulimit -v {ADDRESSES_KIB}; ulimit -c 0; exec \"$0\" \"$@\"");
    let mut child = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_gfmd")])
        .args(words)
        .args(["--json", "-q"])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the shell starts");
    let (mut stdout, mut stderr) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read = |mut from: Box<dyn Read + Send>| {
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            from.read_to_end(&mut bytes).map(|_| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
        })
    };
    let _ = (&mut stdout, &mut stderr);
    let (stdout, stderr) = (read(Box::new(stdout)), read(Box::new(stderr)));
    let start = Instant::now();
    let status = loop {
        match child.try_wait().expect("the process can be waited for") {
            Some(status) => break status.code(),
            None if start.elapsed() > Duration::from_secs(SECONDS) => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
            None => std::thread::sleep(Duration::from_millis(3)),
        }
    };
    (status, stdout.join().unwrap(), stderr.join().unwrap())
}

/// Returns the complaint about a case that ended badly, if any.
fn complaint(words: &[String], status: Option<i32>, stdout: &str, stderr: &str) -> Option<String> {
    let status = match status {
        Some(status) => status,
        None => return Some("did not end, or was killed".into()),
    };
    if status == 0 {
        return match serde_json::from_str(stdout) {
            Ok(report) => of_report(words, &report),
            Err(error) => Some(format!("no JSON: {error}")),
        };
    }
    let lines: Vec<&str> = stderr.trim_end().lines().collect();
    if ![1, 2].contains(&status) || lines.len() != 1 || !lines[0].starts_with("error") || lines[0].contains("panicked")
    {
        return Some(format!("status {status}, {} lines", lines.len()));
    }
    if lines[0].len() > 700 {
        return Some("a long message".into());
    }
    let named =
        words.iter().filter_map(|word| word.split('=').next()).filter(|word| word.contains('-') || word.contains('.'));
    let named: Vec<&str> = named.collect();
    if status == 2 && !named.iter().any(|name| lines[0].contains(*name)) && !lines[0].contains("--") {
        return Some("no flag is named".into());
    }
    let honest = [
        "did not converge",
        "the search cannot start",
        "is not finite",
        "must be finite",
        "part under a mean pressure",
    ];
    if status == 1 && !honest.iter().any(|words| lines[0].contains(words)) {
        return Some("an unexpected failure".into());
    }
    None
}

/// Returns the complaint about a report: numbers that are not finite, states that did not converge, empty contacts.
fn of_report(words: &[String], report: &Value) -> Option<String> {
    if let Some(key) = gfmd_input::json::undefined(report) {
        return Some(format!("{key} is null"));
    }
    let states = ["loads", "steps"].into_iter().filter_map(|key| report[key].as_array()).flatten();
    let with_law = words.iter().any(|word| word == "--law");
    for state in states {
        if state["converged"] != true {
            return Some("not converged, with status 0".into());
        }
        if !with_law && state["area_fraction"].as_f64().is_none_or(|area| area <= 0.0) {
            return Some("no contact".into());
        }
        let p_star = state["p_star"].as_f64().unwrap_or(f64::NAN);
        let kappa = state.get("kappa").and_then(Value::as_f64);
        if let (Some(kappa), false) = (kappa, with_law)
            && (kappa * p_star - state["area_fraction"].as_f64().unwrap()).abs() > 1e-12
        {
            return Some("kappa p* is not the area".into());
        }
        if state.get("pressure_moment_2").and_then(Value::as_f64).is_some_and(|square| square == 0.0) && !with_law {
            return Some("the square of a pressure is zero".into());
        }
    }
    None
}

#[test]
fn every_case_ends_well() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for line in ["contact --n 8 --eps-f-inv 2 --p-star 0.05 --out contact.h5", "punch --n 8 --out punch.h5"] {
        assert!(gfmd(folder, &line.split_whitespace().collect::<Vec<_>>()).status.success());
    }
    let names =
        || -> BTreeSet<_> { std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect() };
    let before = names();
    let all = std::env::var_os("GFMD_EXTREME").is_some();
    let cases: Vec<_> =
        cases().into_iter().enumerate().filter(|(k, _)| all || k % 13 == 3).map(|(_, case)| case).collect();
    let (next, bad) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let counts: [AtomicUsize; 3] = Default::default();
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(words) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let (status, stdout, stderr) = limited(folder, words);
                    if let Some(count) = status.and_then(|status| counts.get(status as usize)) {
                        count.fetch_add(1, Ordering::Relaxed);
                    }
                    if all && status == Some(1) {
                        println!("{}: {}", words.join(" "), stderr.trim_end());
                    }
                    if let Some(complaint) = complaint(words, status, &stdout, &stderr) {
                        bad.lock().unwrap().push(format!("{}: {complaint}: {}", words.join(" "), stderr.trim_end()));
                    }
                }
            });
        }
    });
    let bad = bad.into_inner().unwrap();
    let [solved, failed, refused] = counts.map(AtomicUsize::into_inner);
    println!(
        "{} cases: {solved} solved, {refused} refused, {failed} not converged or not finite, {} bad",
        cases.len(),
        bad.len()
    );
    assert!(bad.is_empty(), "{} of {} cases end badly:\n{}", bad.len(), cases.len(), bad.join("\n"));
    assert_eq!(names(), before, "no case leaves a file");
}

/// An existing path that is not a regular file is refused as `--out` because of its kind, and kept.
#[cfg(unix)]
#[test]
fn special_files_are_not_replaced() {
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(Command::new("mkfifo").arg(at("pipe.h5")).status().unwrap().success());
    let _socket = UnixListener::bind(at("socket.h5")).unwrap();
    std::fs::create_dir(at("folder.h5")).unwrap();
    symlink(at("nowhere"), at("dangling.h5")).unwrap();
    symlink(at("pipe.h5"), at("link.h5")).unwrap();
    // Creating a device needs special rights; the real /dev/null is left alone.
    let device = Command::new("mknod").arg(at("device.h5")).args(["c", "1", "3"]).stderr(Stdio::null()).status();
    let mut targets = vec![
        ("pipe", "a pipe"),
        ("socket", "a socket"),
        ("folder", "a folder"),
        ("dangling", "link"),
        ("link", "a pipe"),
    ];
    if device.is_ok_and(|status| status.success()) {
        targets.push(("device", "a device"));
    }
    let before = names(folder.path());
    let commands = [
        "contact --n 8 --eps-f-inv 2 --p-star 0.05",
        "path --n 8 --eps-f-inv 2 --law exponential --param gamma=1e-4,range=0.01 --approach 0.002 --steps 1",
        "punch --n 8",
        "surface --n 8 --eps-f-inv 2",
        "kappa-sweep --preset smoke",
    ];
    for command in commands {
        for (name, kind) in &targets {
            let words: Vec<String> =
                format!("{command} --out {name}.h5").split_whitespace().map(str::to_owned).collect();
            let (status, _, stderr) = limited(folder.path(), &words);
            assert_eq!(status, Some(2), "{words:?}: {stderr}");
            assert!(stderr.starts_with("error: --out") && stderr.contains(kind), "{words:?}: {stderr}");
        }
    }
    assert_eq!(names(folder.path()), before);
    use std::os::unix::fs::FileTypeExt;
    assert!(std::fs::symlink_metadata(at("pipe.h5")).unwrap().file_type().is_fifo());
    assert!(std::fs::symlink_metadata(at("dangling.h5")).unwrap().is_symlink());
}

#[cfg(unix)]
fn names(folder: &Path) -> BTreeSet<std::ffi::OsString> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect()
}

/// Inputs must be regular files, also inputs named in a result: a pipe without a writer and an endless device are
/// refused at once.
#[cfg(unix)]
#[test]
fn inputs_that_are_no_regular_files_are_refused() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let rough = ndarray::Array2::from_shape_fn((8, 8), |(i, j)| ((5 * i + 3 * j) % 7) as f64 * 1e-3);
    ndarray_npy::write_npy(at("h.npy"), &rough).unwrap();
    let made = limited(folder.path(), &words("contact --surface h.npy --size 1 --p-star 0.05 --out c.h5"));
    assert_eq!(made.0, Some(0), "{}", made.2);
    for name in ["pipe", "pipe.npy", "pipe.h5"] {
        assert!(Command::new("mkfifo").arg(at(name)).status().unwrap().success());
    }
    for name in ["zero", "zero.npy", "zero.h5"] {
        symlink("/dev/zero", at(name)).unwrap();
    }
    let refused = |line: &str, kind: &str| {
        let (status, stdout, stderr) = limited(folder.path(), &words(line));
        assert_eq!((status, stdout.as_str()), (Some(2), ""), "{line}: {stderr}");
        assert!(stderr.contains(&format!("it is {kind}; it must be a regular file")), "{line}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{line}: {stderr}");
    };
    let lines = [
        "contact --surface X --p-star 0.05",
        "contact --surface X.npy --p-star 0.05",
        "contact --surface h.npy --second-surface X --p-star 0.05",
        "contact --surface h.npy --size 1 --p-star 0.05 --hardness X.npy",
        "contact --surface h.npy --size 1 --p-star 0.05 --height 1 --base-displacement X.npy",
        "contact --surface X.h5:/heights --p-star 0.05",
        "surface --surface X",
        "surface --surface X --list",
        "kappa-sweep --config X",
        "kappa-sweep --preset smoke --runs-of X --out s.h5",
        "punch --n 8 --mask X.npy",
        "punch --n 8 --compare X.npy",
        "punch --n 8 --compare X.h5",
        "body --surface X.npy --depths 0",
        "body --surface X.h5 --depths 0",
        "report X.h5 --out page.html",
        "check X.h5",
    ];
    for line in lines {
        refused(&line.replace('X', "pipe"), "a pipe");
        refused(&line.replace('X', "zero"), "a device");
    }
    // The input named in a result has been replaced.
    for (kind, replace) in [("a pipe", "pipe"), ("a device", "/dev/zero")] {
        std::fs::remove_file(at("h.npy")).unwrap();
        symlink(if kind == "a pipe" { at(replace) } else { replace.into() }, at("h.npy")).unwrap();
        refused("check c.h5", kind);
        refused("check c.h5 --rerun", kind);
    }
    // A configuration of 1.5 GiB in a sparse file.
    std::fs::File::create(at("large.toml")).unwrap().set_len(3 << 29).unwrap();
    let (status, _, stderr) = limited(folder.path(), &words("kappa-sweep --config large.toml"));
    assert_eq!(status, Some(2), "{stderr}");
    assert!(stderr.contains("it has 1610612736 bytes; it must have at most 1048576"), "{stderr}");
}

/// Names too long for a file beside the output are refused before anything is computed.
#[cfg(unix)]
#[test]
fn names_that_are_too_long_for_the_files_beside_them_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let before = names(folder.path());
    for length in [200, 239, 240, 245, 247, 248, 250, 251, 255, 256] {
        let out = format!("{}.h5", "n".repeat(length - 3));
        for command in ["contact --n 8 --eps-f-inv 2 --p-star 0.05,0.06", "kappa-sweep --preset smoke --shard 1/2"] {
            // Beside OUT: .checkpoint.part; .shard-1-of-2.journal.
            let longest = if command.starts_with("contact") { 16 } else { 21 };
            if length + longest <= 255 && command.starts_with("kappa") {
                continue;
            }
            let words: Vec<String> = format!("{command} --out {out}").split_whitespace().map(str::to_owned).collect();
            let (status, _, stderr) = limited(folder.path(), &words);
            let expected = if length + longest <= 255 { 0 } else { 2 };
            assert_eq!(status, Some(expected), "{length}, {command}: {stderr}");
            if expected == 2 {
                assert!(stderr.starts_with("error: --out") && stderr.lines().count() == 1, "{length}: {stderr}");
                assert_eq!(names(folder.path()), before, "{length}: something was written");
            } else {
                std::fs::remove_file(folder.path().join(&out)).unwrap();
            }
        }
    }
}

/// Names too long for a figure are refused before anything is computed.
#[cfg(unix)]
#[test]
fn prefixes_that_are_too_long_for_the_names_of_figures_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let before = names(folder.path());
    let run = |words: &str| {
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        limited(folder.path(), &words)
    };
    let refused = |flag: &str, words: &str| {
        let (status, _, stderr) = run(words);
        assert_eq!(status, Some(2), "{words}: {stderr}");
        assert!(stderr.contains(flag) && stderr.contains("the longest name of a figure"), "{words}: {stderr}");
        assert_eq!(names(folder.path()), before, "{words}: something was written");
    };
    // The longest suffix is -correlation-map.svg.
    for length in [236, 245, 255, 256] {
        let prefix = "n".repeat(length);
        for command in ["contact --n 8 --eps-f-inv 2 --p-star 0.05", "surface --n 8 --eps-f-inv 2", "punch --n 8"] {
            refused("--plots", &format!("{command} --plots {prefix}"));
        }
    }
    // The figures of a sweep are named after its file, and the file itself may have this name.
    refused("--out", &format!("kappa-sweep --preset smoke --out {}.h5", "n".repeat(236)));
    let (status, _, stderr) = run(&format!("contact --n 8 --eps-f-inv 2 --p-star 0.05 --plots {}", "n".repeat(235)));
    assert_eq!(status, Some(0), "{stderr}");
    assert!(names(folder.path()).len() > before.len());
}

/// Text from a file cannot control the terminal in a table, note, warning or error, and errors stay on one line.
#[test]
fn texts_of_files_do_not_steer_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "Z\u{1b}[31m\u{9b}2J\u{202e}\u{200b}\u{7}";
    let steers = |text: &str| text.contains(|c: char| (c.is_control() && c != '\n') || "\u{202e}\u{200b}".contains(c));
    let scan = |unit: &str| {
        format!("# Channel: {hostile}\n# Width: 1 mm\n# Height: 1 mm\n# Value units: {unit}\n1 2 3\n4 5 7\n2 1 9\n")
    };
    std::fs::write(folder.path().join("scan.txt"), scan("mm")).unwrap();
    std::fs::write(folder.path().join("bad.txt"), scan(hostile)).unwrap();
    std::fs::write(folder.path().join("word.txt"), format!("1 2\n3 {hostile}\n")).unwrap();
    std::fs::write(folder.path().join("bad.toml"), format!("[{hostile}]\na = \"\n")).unwrap();
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gfmd"));
        let output = command.args(line.split(' ')).current_dir(folder.path()).output().unwrap();
        let [stdout, stderr] =
            [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("text in UTF-8"));
        assert!(!steers(&stdout) && !steers(&stderr), "{line}: {stdout:?} {stderr:?}");
        (output.status.code(), stdout, stderr)
    };
    for line in [
        "surface --surface scan.txt",
        "surface --surface scan.txt --list",
        "contact --surface scan.txt --e-star 1 --p-star 0.05 --out c.h5",
    ] {
        let (status, stdout, stderr) = run(line);
        assert_eq!(status, Some(0), "{stderr}");
        assert!(line.starts_with("contact") || stdout.contains("Z\u{fffd}[31m"), "{line}: {stdout}");
    }
    run("check c.h5");
    run("report c.h5");
    let lines = [
        "surface --surface bad.txt",
        "surface --surface word.txt",
        "kappa-sweep --config bad.toml",
        "surface --surface scan.txt --channel 9",
    ];
    for line in lines {
        let (status, _, stderr) = run(line);
        assert_eq!((status, stderr.lines().count()), (Some(2), 1), "{line}: {stderr}");
    }
}

/// A reader that closes the pipe early, closed standard streams, and arguments that are not text.
#[cfg(unix)]
#[test]
fn closed_streams_and_bytes_that_are_no_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_gfmd");
    let shell = |script: &str| {
        let output = Command::new("bash").args(["-c", script, program]).current_dir(folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let commands = ["", "contact", "path", "punch", "body", "surface", "green", "law", "kappa-sweep"];
    for command in commands {
        let (status, stderr) = shell(&format!("\"$0\" {command} --help | head -c 0; exit ${{PIPESTATUS[0]}}"));
        assert!(status == Some(0) && stderr.is_empty(), "{command} --help: {status:?} {stderr}");
    }
    for streams in ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"] {
        let (status, stderr) = shell(&format!("\"$0\" green --qx 1 --height inf {streams}"));
        assert!([Some(0), Some(1)].contains(&status) && !stderr.contains("panicked"), "{streams}: {status:?} {stderr}");
        let (status, stderr) = shell(&format!("\"$0\" green --qx nan {streams}"));
        assert!(status == Some(2) && !stderr.contains("panicked"), "{streams}: {status:?} {stderr}");
    }
    let (status, stderr) = shell("\"$0\" green --qx 1 --height inf | head -c 0; exit ${PIPESTATUS[0]}");
    assert!([Some(0), Some(1)].contains(&status) && !stderr.contains("panicked"), "{status:?} {stderr}");
    for flag in ["--out", "--surface", "--plots"] {
        let output = Command::new(program)
            .args(["contact", "--n", "8", "--eps-f-inv", "2", "--p-star", "0.1", flag])
            .arg(OsStr::from_bytes(b"\xff\xfe.h5"))
            .current_dir(folder.path())
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && stderr.contains("is not UTF-8"), "{flag}: {stderr}");
    }
    assert_eq!(names(folder.path()).len(), 0);
}

/// Invalid fields of a sweep are refused by name before the first contact.
#[test]
fn sweeps_out_of_range_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let lists = ["[]", "[0.0]", "[-1.0]", "[nan]", "[inf]", "[1e300]", "[5e-324]", "[0.5, nan]"];
    let numbers = ["nan", "inf", "-inf", "-1.0", "1e300", "1e-300", "5e-324"];
    let counts = ["-1", "1.5", "9223372036854775808", "18446744073709551616"];
    let mut fields: Vec<(&str, &str)> = Vec::new();
    let mut all =
        |name: &'static str, values: &[&'static str]| fields.extend(values.iter().map(|value| (name, *value)));
    all("surface.hurst", &["[]", "[-1.0]", "[nan]", "[inf]", "[1e300]", "[0.5, nan]", "[0.5, 0.5]", "[0.0, -0.0]"]);
    all("surface.rms_gradient", &numbers);
    all("surface.rms_gradient", &["0.0"]);
    all("body.young", &["0.0", "nan", "inf", "-1.0", "1e300", "1e-300", "5e-324"]);
    all("body.poisson", &["nan", "inf", "-inf", "-1.0", "0.51", "1e300"]);
    all("body.height", &["0.0", "nan", "-1.0", "1e300", "1e-300", "5e-324", "\"high\""]);
    ["points.eps_t_inv", "points.eps_f_inv", "points.eps_c_inv", "loads.p_star"]
        .into_iter()
        .for_each(|name| all(name, &lists));
    all("loads.p_star", &["[0.02, 0.02]", "[0.02, 0.01]", "[0.02, 1e30]"]);
    ["fit.alpha_t", "fit.alpha_f", "fit.alpha_c"]
        .into_iter()
        .for_each(|name| all(name, &["0", "0.0", "-0.0", "-1", "17.0"]));
    ["fit.alpha_t", "fit.alpha_f", "fit.alpha_c"].into_iter().for_each(|name| all(name, &numbers));
    ["fit.resamples", "statistics.realisations", "statistics.seed", "solver.max_iterations", "points.largest_n"]
        .into_iter()
        .for_each(|name| all(name, &counts));
    all("fit.resamples", &["9223372036854775807", "2147483648"]);
    all("statistics.realisations", &["0", "9223372036854775807", "2147483648"]);
    all("solver.max_iterations", &["0"]);
    all("solver.tolerance", &numbers);
    all("solver.tolerance", &["0.0", "1.0"]);
    all("fit.p_star", &numbers);
    let small = "
[points]
design = \"grid\"
eps_t_inv = [1.0, 2.0]
eps_f_inv = [2.0, 4.0]
eps_c_inv = [2.0, 4.0]
centre = [2.0, 2.0, 2.0]
[loads]
p_star = [0.05]
[statistics]
realisations = 2
[fit]
p_star = 0.05
resamples = 20
";
    for (field, value) in fields {
        let mut config: toml::Table = toml::from_str(small).unwrap();
        let (table, key) = field.split_once('.').unwrap();
        let Ok(value_of) = toml::from_str::<toml::Table>(&format!("x = {value}")) else {
            // TOML has no such number: the message of its parser names the line.
            std::fs::write(folder.path().join("s.toml"), format!("{small}\n[solver]\nx = {value}")).unwrap();
            let (status, _, stderr) = limited(folder.path(), &["kappa-sweep", "--config", "s.toml"].map(str::to_owned));
            assert!(status == Some(2) && stderr.contains("s.toml, line"), "{field} = {value}: {stderr}");
            continue;
        };
        let entry = config.entry(table).or_insert_with(|| toml::Table::new().into());
        entry.as_table_mut().unwrap().insert(key.into(), value_of["x"].clone());
        std::fs::write(folder.path().join("s.toml"), toml::to_string(&config).unwrap()).unwrap();
        let (status, _, stderr) = limited(folder.path(), &["kappa-sweep", "--config", "s.toml"].map(str::to_owned));
        let named = stderr.contains(field) || stderr.contains(table) || stderr.contains("p* =");
        assert!(status == Some(2), "{field} = {value}: {status:?} {stderr}");
        assert!(stderr.trim_end().lines().count() == 1, "{field} = {value}: {status:?} {stderr}");
        assert!(named, "{field} = {value}: {status:?} {stderr}");
        assert!(stderr.len() < 500, "{field} = {value}: {stderr}");
    }
}
