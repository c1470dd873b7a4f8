//! Killed runs: by SIGKILL at random moments and at every writing system call, by Ctrl-C, by SIGTERM, on a full disk,
//! without their folder, twice at once. No finished part is lost, every file opens or is absent, and a resumed run
//! equals the uninterrupted run number for number.
//!
//! The default is a short version that takes a third of the commands per test. The long version kills every command
//! `GFMD_CRASH` times at random moments, and smaller commands once at each of their system calls:
//!
//! ```text
//! GFMD_CRASH=500 cargo test -p gfmd-cli --test suite crash:: -- --nocapture --test-threads 1
//! ```
//!
//! `GFMD_CRASH_CASES=path,loop` chooses some of the commands.
#![cfg(unix)]
#![expect(clippy::print_stdout, reason = "the counts of the runs are the result")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{STUDY, gfmd, numbers, sweep};

/// Commands that write a file. The first word is a name for messages.
const COMMANDS: [&str; 14] = [
    "sweep kappa-sweep --config sweep.toml",
    "contact contact --n 128 --eps-f-inv 16 --p-star 0.01,0.02,0.05,0.1,0.2,0.4 --checkpoint 0.001",
    "squeezed contact --n 64 --eps-f-inv 8 --height 0.05 --lower-seed 2 --p-star 0.02,0.05,0.2 --checkpoint 0.001",
    "relaxation contact --n 64 --eps-f-inv 16 --p-star 0.02 --solver verlet --checkpoint 0.001",
    "law contact --n 32 --eps-f-inv 8 --law exponential --param gamma=1e-4,range=3e-3 --p-star 0.05,0.02,0,0.01 \
     --checkpoint 0.001 --grid-error refine",
    "path path --n 32 --eps-f-inv 8 --p-star 0.05 --friction 0.3 --lateral 0,0.001,-0.001 --steps 6",
    "loop path --n 64 --dim 2 --law exponential --param gamma=2e-4,range=4e-3 --approach=0.002,0.006,-0.002 \
     --steps 5 --grid-error refine",
    "body body --surface whole-punch.h5 --levels 24",
    "punch punch --n 32",
    "creep path --n 64 --height 0.3 --relaxes shear --prony 0.1:0.3,10:0.4 --p-star 0.05 --time 0,1e-2:1e2:12 \
     --steps 1",
    "wear wear --n 64 --eps-f-inv 8 --boundary free --p-star 0.05 --coefficient 1 --distance 0,1e-2:1:12 --steps 1",
    "yield path --n 32 --eps-f-inv 8 --poisson 0.3 --yield-stress 0.01 --p-star 0.02,0.06,0.01 --steps 3 \
     --checkpoint 0.001",
    "study study study.toml",
    "slide slide --n 64 --prony 0.1:0.5 --heat 1,0.01,0.2,0.1 --friction 0.3 --p-star 0.02,0.1 --velocity 0.01:100:6",
];

/// Smaller commands, killed at every system call.
const SMALL: [&str; 14] = [
    "sweep kappa-sweep --config small.toml",
    "contact contact --n 32 --eps-f-inv 4 --p-star 0.02,0.05,0.2 --checkpoint 0.0001",
    "squeezed contact --n 24 --eps-f-inv 4 --height 0.1 --lower-seed 2 --p-star 0.02,0.2 --checkpoint 0.0001",
    "relaxation contact --n 24 --eps-f-inv 4 --p-star 0.05 --solver fire --checkpoint 0.0001",
    "law contact --n 24 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=4e-3 --p-star 0.05,0 \
     --checkpoint 0.0001 --grid-error refine",
    "path path --n 16 --eps-f-inv 4 --p-star 0.05 --friction 0.3 --lateral 0,0.001,-0.001 --steps 2",
    "loop path --n 32 --dim 2 --eps-f-inv 4 --law exponential --param gamma=2e-4,range=4e-3 --approach=0.002,0.006 \
     --steps 3 --grid-error refine",
    "body body --surface whole-punch.h5 --levels 3",
    "punch punch --n 16",
    "creep path --n 16 --eps-f-inv 4 --prony 0.1:0.3,10:0.4 --p-star 0.05 --time 0,1,100 --steps 1",
    "wear wear --n 16 --eps-f-inv 4 --p-star 0.05 --coefficient 1 --distance 0,0.1,1 --steps 2",
    "yield path --n 16 --eps-f-inv 4 --poisson 0.3 --yield-stress 0.01 --p-star 0.02,0.06 --steps 2 \
     --checkpoint 0.0001",
    "study study study.toml",
    "slide slide --n 16 --eps-f-inv 4 --prony 0.1:0.5 --heat 1,0.01,0.2,0.1 --friction 0.3 --p-star 0.05 \
     --velocity 0.1,1 --grid-error refine",
];

/// Commands that keep finished parts.
const RESUMABLE: [&str; 12] =
    ["sweep", "study", "contact", "squeezed", "relaxation", "law", "path", "loop", "creep", "wear", "yield", "slide"];

struct Case {
    name: &'static str,
    words: Vec<&'static str>,
    expected: BTreeMap<String, Vec<u64>>,
    /// Duration of the whole run.
    takes: Duration,
}

impl Case {
    /// Returns the words of a run that may continue an earlier one.
    fn run(&self, out: &str) -> Vec<String> {
        let mut words: Vec<String> = self.words.iter().map(ToString::to_string).collect();
        words.extend(["--out".into(), out.into()]);
        if RESUMABLE.contains(&self.name) {
            words.push("--resume".into());
        }
        words
    }

    fn start(&self, folder: &Path, out: &str) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gfmd"));
        command.current_dir(folder).args(self.run(out)).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// Checks that the output, if it exists, is whole and equal to the uninterrupted run; returns true if it exists.
    fn check(&self, path: &Path, what: &str) -> bool {
        path.exists() && {
            assert!(numbers(path) == self.expected, "{}, {what}: {} has other numbers", self.name, path.display());
            true
        }
    }

    /// Continues to the end; no kept part is computed again, and only the output is left.
    fn finish(&self, folder: &Path, out: &str, what: &str) {
        let kept = kept(folder, out, self.name);
        let words = self.run(out);
        let output = gfmd(folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{}, {what}: {message}", self.name);
        assert!(self.check(&folder.join(out), what), "{}, {what}: no output", self.name);
        let taken = message.lines().find_map(|line| {
            let (_, rest) = line.split_once("taken over: ")?;
            rest.split_whitespace().next()?.parse::<usize>().ok()
        });
        assert_eq!(taken.unwrap_or(0), kept, "{}, {what}: finished parts are lost\n{message}", self.name);
        for name in [".part", ".lock", ".journal", ".state", ".checkpoint", ".state.part", ".checkpoint.part"] {
            assert!(!folder.join(format!("{out}{name}")).exists(), "{}, {what}: {out}{name} is left", self.name);
        }
        std::fs::remove_file(folder.join(out)).unwrap();
    }
}

/// Returns the number of parts kept beside an output: the whole records of the journal after its head, for a contact or
/// a path only the records that belong to the state.
fn kept(folder: &Path, out: &str, name: &str) -> usize {
    let count = |bytes: &[u8]| {
        let (mut rest, mut records) = (bytes, 0_usize);
        while let Some(length) = rest.get(..16).and_then(|digits| std::str::from_utf8(digits).ok()) {
            let length = usize::from_str_radix(length, 16).unwrap();
            let Some(after) = rest.get(91 + length + 1..) else { break };
            (rest, records) = (after, records + 1);
        }
        records.saturating_sub(1)
    };
    let records = std::fs::read(folder.join(format!("{out}.journal"))).map_or(0, |bytes| count(&bytes));
    if ["sweep", "study"].contains(&name) {
        return records;
    }
    // The number of parts follows the checksum of the head.
    let state = std::fs::read(folder.join(format!("{out}.state"))).ok();
    state.map_or(0, |bytes| u64::from_le_bytes(bytes[64..72].try_into().unwrap()) as usize)
}

/// Makes the reference runs of all commands in a folder with their inputs. The short version takes every third command,
/// starting from `turn`, so that three tests cover all commands.
fn cases(folder: &Path, turn: usize) -> Vec<Case> {
    let step = if long().is_some() { 1 } else { 3 };
    all_of(COMMANDS.into_iter().skip(turn % step).step_by(step), folder)
}

fn all_of(commands: impl IntoIterator<Item = &'static str>, folder: &Path) -> Vec<Case> {
    std::fs::write(folder.join("sweep.toml"), sweep(3, 50)).unwrap();
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let small = sweep(2, 50).replace("eps_t_inv = [1.0, 2.0]", "eps_t_inv = [1.0]");
    std::fs::write(folder.join("small.toml"), small.replace("centre = [2, 4, 4]", "centre = [1, 4, 4]")).unwrap();
    let punch = gfmd(folder, &["punch", "--n", "32", "--out", "whole-punch.h5", "-q"]);
    assert!(punch.status.success());
    let case = |line: &'static str| {
        let (name, words) = line.split_once(' ').unwrap();
        let words: Vec<&str> = words.split_whitespace().collect();
        let mut arguments = words.clone();
        arguments.extend(["--out", "whole.h5"]);
        let started = Instant::now();
        let output = gfmd(folder, &arguments);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let takes = started.elapsed();
        let expected = numbers(&folder.join("whole.h5"));
        assert!(expected.values().map(Vec::len).sum::<usize>() > 50, "{name}");
        std::fs::remove_file(folder.join("whole.h5")).unwrap();
        Case { name, words, expected, takes }
    };
    let only = std::env::var("GFMD_CRASH_CASES").ok();
    let chosen = |line: &&str| only.as_ref().is_none_or(|only| only.split(',').any(|name| line.starts_with(name)));
    commands.into_iter().filter(chosen).map(case).collect()
}

/// Returns how often each command is killed; `None` for the short version.
fn long() -> Option<usize> {
    std::env::var("GFMD_CRASH").ok().map(|count| count.parse().expect("GFMD_CRASH is a number"))
}

/// Random numbers from a seed that is printed if a test fails.
struct Random(u64);

impl Random {
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn signal(child: &Child, name: &str) {
    // The process may have ended.
    let _ = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).stderr(Stdio::null()).status();
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn killed_at_random_moments() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(2026);
    for case in cases(folder.path(), 0) {
        let kills = long().unwrap_or(2);
        let (mut killed, mut resumed, mut parts, mut done) = (0, 0, 0, 0);
        // On a machine with changing load, the first kills may come too late.
        while done < kills || (killed == 0 && done < 50) {
            // A run is killed one to four times before it may end.
            for _ in 0..1 + (4.0 * random.share()) as usize {
                let mut child = case.start(folder.path(), "k.h5");
                std::thread::sleep(case.takes.mul_f64(1.1 * random.share()));
                signal(&child, "KILL");
                let status = child.wait().unwrap();
                done += 1;
                killed += usize::from(status.code().is_none());
                if case.check(&folder.path().join("k.h5"), "killed") {
                    break;
                }
                parts += kept(folder.path(), "k.h5", case.name);
            }
            if folder.path().join("k.h5").exists() {
                std::fs::remove_file(folder.path().join("k.h5")).unwrap();
                // A kill after the file is renamed leaves the kept parts of a run that has ended.
                for name in [".journal", ".state", ".checkpoint", ".lock", ".part"] {
                    let _ = std::fs::remove_file(folder.path().join(format!("k.h5{name}")));
                }
            } else {
                case.finish(folder.path(), "k.h5", "killed");
                resumed += 1;
            }
        }
        println!(
            "{}: SIGKILL at {done} random moments, {killed} before the end, {parts} kept parts found, {resumed} \
             resumed",
            case.name
        );
        assert!(killed > 0, "{}: killed too late to test anything", case.name);
    }
}

#[test]
fn killed_at_every_system_call_that_writes() {
    if Command::new("strace").arg("-V").output().is_err() {
        println!(
            "strace is not installed, so that no run is killed at a system call; the journal's own tests are the same \
             on a double"
        );
        return;
    }
    const CALLS: &str = "write,pwrite64,writev,fsync,ftruncate,rename,unlink";
    let folder = tempfile::tempdir().unwrap();
    let short = ["sweep ", "study ", "contact ", "path ", "body "];
    let is_chosen = |line: &&str| long().is_some() || short.iter().any(|name| line.starts_with(name));
    for case in all_of(SMALL.into_iter().filter(is_chosen), folder.path()) {
        // The short version tries a few calls, at growing distances.
        let (mut call, mut killed, mut parts) = (1_usize, 0, 0);
        loop {
            let mut command = Command::new("strace");
            command.current_dir(folder.path()).args(["-f", "-o", "/dev/null", "-e"]);
            command.arg(format!("inject={CALLS}:signal=KILL:when={call}")).arg(env!("CARGO_BIN_EXE_gfmd"));
            let output = command.args(case.run("k.h5")).args(["--threads", "1"]).output().unwrap();
            if output.status.success() {
                break;
            }
            assert!(output.status.code().is_none_or(|code| code > 128), "{}: {}", case.name, message(&output));
            killed += 1;
            parts += kept(folder.path(), "k.h5", case.name);
            if !case.check(&folder.path().join("k.h5"), "killed at a call") {
                case.finish(folder.path(), "k.h5", &format!("killed at call {call}"));
            } else {
                clear(folder.path());
            }
            call += if long().is_some() { 1 } else { call };
        }
        println!("{}: SIGKILL at {killed} of the system calls that write, {parts} kept parts found", case.name);
        assert!(killed > 2, "{}: hardly anything was killed", case.name);
        clear(folder.path());
    }
}

/// Removes the files of the last run.
fn clear(folder: &Path) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("k.h5")) {
            std::fs::remove_file(path).unwrap();
        }
    }
}

#[test]
fn interrupted_by_ctrl_c_and_terminated() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(7);
    for case in cases(folder.path(), 1) {
        let mut stopped = 0;
        let tries = long().map_or(2, |kills| kills.div_ceil(20));
        for turn in 0..tries {
            let name = ["INT", "TERM"][turn % 2];
            let child = case.start(folder.path(), "k.h5");
            std::thread::sleep(case.takes.mul_f64(random.share()));
            signal(&child, name);
            let output = child.wait_with_output().unwrap();
            match output.status.code() {
                Some(0) => {
                    assert!(case.check(&folder.path().join("k.h5"), name));
                    std::fs::remove_file(folder.path().join("k.h5")).unwrap();
                    continue;
                }
                Some(130) => stopped += 1,
                // Before the handler is installed, the signal ends the process like any other program.
                None => {}
                code => panic!("{}, {name}: exit status {code:?}: {}", case.name, message(&output)),
            }
            assert!(
                !folder.path().join("k.h5").exists() || !RESUMABLE.contains(&case.name),
                "{}, {name}: an unfinished file has the name of a finished one",
                case.name
            );
            clear_unless_resumable(&case, folder.path());
            case.finish(folder.path(), "k.h5", name);
        }
        println!("{}: {tries} signals INT and TERM, {stopped} stops with status 130", case.name);
    }
}

/// Removes the files of a command without parts, which writes its partial result when interrupted.
fn clear_unless_resumable(case: &Case, folder: &Path) {
    if !RESUMABLE.contains(&case.name) {
        clear(folder);
    }
}

#[test]
fn on_a_full_disk() {
    let folder = tempfile::tempdir().unwrap();
    let disk = Disk::new();
    for case in cases(folder.path(), 2) {
        let mut refused = 0;
        let sizes = if long().is_some() { 24 } else { 4 };
        for step in 0..sizes {
            // From nothing to more than the run writes.
            let kilobytes = 4 << (10 * step / sizes);
            let output = match &disk {
                Some(disk) if long().is_some() => disk.run(&case, folder.path(), kilobytes),
                _ => limited(&case, folder.path(), kilobytes),
            };
            let path = folder.path().join("k.h5");
            let text = message(&output);
            assert!(!text.contains("panicked"), "{}, {kilobytes} kB: {text}", case.name);
            if output.status.success() {
                assert!(case.check(&path, "on a small disk"));
            } else {
                refused += 1;
                assert_eq!(output.status.code(), Some(1), "{}, {kilobytes} kB: {text}", case.name);
                assert!(text.lines().last().is_some_and(|line| line.starts_with("error: cannot ")), "{text}");
                // A figure that does not fit leaves a whole result.
                if !case.check(&path, "on a full disk") {
                    case.finish(folder.path(), "k.h5", "after a full disk");
                }
            }
            clear(folder.path());
        }
        println!("{}: {sizes} disks of different size, {refused} too small", case.name);
        assert!(refused > 0, "{}: no disk was full", case.name);
    }
}

/// Runs with a file size limit that makes a write fail as on a full disk.
fn limited(case: &Case, folder: &Path, kilobytes: usize) -> Output {
    let mut command = Command::new("sh");
    command.current_dir(folder).arg("-c");
    command.arg(format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", 2 * kilobytes));
    command.arg(env!("CARGO_BIN_EXE_gfmd")).args(case.run("k.h5")).output().unwrap()
}

/// Small file system in memory, where this process may mount one.
struct Disk(PathBuf);

impl Disk {
    fn new() -> Option<Self> {
        let place = std::env::temp_dir().join(format!("gfmd-crash-{}", std::process::id()));
        std::fs::create_dir_all(&place).ok()?;
        let disk = Self(place);
        let mounted = disk.mount(64);
        if mounted {
            disk.unmount();
            return Some(disk);
        }
        println!("no file system can be mounted here; the size of every file is limited instead");
        None
    }

    fn mount(&self, kilobytes: usize) -> bool {
        let size = format!("size={kilobytes}k");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(&self.0).output();
        mount.is_ok_and(|output| output.status.success())
    }

    fn unmount(&self) {
        let _ = Command::new("umount").arg(&self.0).output();
    }

    /// Runs on a disk of this size, and copies the files left there back to `folder`.
    fn run(&self, case: &Case, folder: &Path, kilobytes: usize) -> Output {
        assert!(self.mount(kilobytes));
        let out = self.0.join("k.h5");
        let words = case.run(&out.display().to_string());
        let output = gfmd(folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
        for entry in std::fs::read_dir(&self.0).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
        self.unmount();
        output
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}

#[test]
fn without_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(11);
    for case in cases(folder.path(), 0) {
        let (mut failed, tries) = (0, long().map_or(2, |kills| kills.div_ceil(50)));
        for _ in 0..tries {
            let gone = folder.path().join("gone");
            std::fs::create_dir(&gone).unwrap();
            let child = case.start(folder.path(), "gone/k.h5");
            std::thread::sleep(case.takes.mul_f64(0.8 * random.share()));
            let _ = std::fs::remove_dir_all(&gone);
            let output = child.wait_with_output().unwrap();
            let text = message(&output);
            assert!(!text.contains("panicked") && output.status.code().is_some(), "{}: {text}", case.name);
            if !output.status.success() {
                failed += 1;
                assert!(text.lines().last().is_some_and(|line| line.starts_with("error: ")), "{text}");
            }
            let _ = std::fs::remove_dir_all(&gone);
        }
        println!("{}: {tries} folders removed, {failed} runs failed with a message", case.name);
    }
}

#[test]
fn twice_at_once() {
    let folder = tempfile::tempdir().unwrap();
    for case in cases(folder.path(), 1) {
        let (mut busy, rounds) = (0, long().map_or(2, |kills| kills.div_ceil(20)));
        for _ in 0..rounds {
            let pair = [case.start(folder.path(), "k.h5"), case.start(folder.path(), "k.h5")];
            for output in pair.map(|child| child.wait_with_output().unwrap()) {
                match output.status.code() {
                    Some(0) => {}
                    Some(2) if message(&output).contains("is being written by another process") => busy += 1,
                    code => panic!("{}: exit status {code:?}: {}", case.name, message(&output)),
                }
            }
            assert!(case.check(&folder.path().join("k.h5"), "twice at once"), "{}: no output", case.name);
            clear(folder.path());
        }
        println!("{}: {rounds} pairs at once, {busy} runs refused", case.name);
    }
}
