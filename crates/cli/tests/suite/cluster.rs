//! Sweeps computed in shards by many processes and merged: the result equals the result of one process, even if shards
//! fail or repeat.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::common::{SWEEP, gfmd, json, numbers};
use gfmd_files::{Journal, Reader};

/// Eight runs, fewer than some numbers of shards.
fn few() -> String {
    SWEEP.replace("realisations = 2", "realisations = 2\nnested = false\nequal_area = false")
}

/// Creates a folder with the configuration and the whole result of one process.
fn folder(config: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sweep.toml"), config).unwrap();
    let words = ["--out", "whole.h5", "--json"];
    let report = json(folder.path(), &[&SWEEP_WORDS[..], &words].concat());
    std::fs::write(folder.path().join("whole.json"), report.to_string()).unwrap();
    folder
}

const SWEEP_WORDS: [&str; 6] = ["kappa-sweep", "--config", "sweep.toml", "-q", "--threads", "1"];

fn words<'a>(rest: &[&'a str]) -> Vec<&'a str> {
    [&SWEEP_WORDS[..], &["--out", "s.h5"], rest].concat()
}

fn shard(folder: &Path, shard: &str) -> Output {
    gfmd(folder, &words(&["--resume", "--shard", shard]))
}

fn start(folder: &Path, shard: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gfmd"));
    command.current_dir(folder).args(words(&["--resume", "--shard", shard]));
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}", message(output));
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Returns the names of the files of the sharded sweep.
fn files(folder: &Path) -> Vec<String> {
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut all: Vec<String> = all.filter(|name| name.starts_with("s.h5")).collect();
    all.sort();
    all
}

/// Merges the shards, compares every number of file, table and plots with one process, and removes the result.
fn merge_and_compare(folder: &Path, what: &str) {
    let output = gfmd(folder, &words(&["--merge", "--json"]));
    assert!(output.status.success(), "{what}: {}", message(&output));
    compare(folder, what);
    let mut found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut whole: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("whole.json")).unwrap()).unwrap();
    for report in [&mut found, &mut whole] {
        let report = report.as_object_mut().unwrap();
        for volatile in ["out", "plots", "seconds", "peak_bytes"] {
            assert!(report.remove(volatile).is_some(), "{volatile}");
        }
    }
    assert_eq!(found, whole, "{what}");
    for figure in ["extrapolation", "area", "map"] {
        let [found, whole] =
            ["s", "whole"].map(|stem| std::fs::read(folder.join(format!("{stem}-{figure}.svg"))).unwrap());
        assert!(found == whole, "{what}: {figure}");
    }
    std::fs::remove_file(folder.join("s.h5")).unwrap();
}

/// Compares the merged file with the file of one process; nothing else is left.
fn compare(folder: &Path, what: &str) {
    assert!(numbers(&folder.join("s.h5")) == numbers(&folder.join("whole.h5")), "{what}");
    let [found, whole] = ["s.h5", "whole.h5"].map(|name| Reader::open(folder.join(name)).unwrap());
    for attribute in ["config", "version", "warnings"] {
        assert_eq!(found.text("/", attribute).unwrap(), whole.text("/", attribute).unwrap(), "{what}");
    }
    assert_eq!(files(folder), ["s.h5"], "{what}");
}

#[test]
fn merged_equals_whole_for_any_number_of_shards() {
    let folder = folder(&few());
    for count in [1, 2, 5, 31] {
        // All at once: each writes to its own journal, under its own lock.
        let children: Vec<Child> = (0..count).map(|index| start(folder.path(), &format!("{index}/{count}"))).collect();
        children.into_iter().for_each(|child| succeeded(&child.wait_with_output().unwrap()));
        assert_eq!(files(folder.path()).len(), count, "each shard leaves a journal, also without runs");
        merge_and_compare(folder.path(), &format!("{count} shards"));
    }
}

#[test]
fn a_merge_makes_good_for_shards_that_are_missing_killed_torn_or_overlap() {
    let folder = folder(SWEEP);
    let path = folder.path();
    for whole in ["0/5", "4/5", "1/3"] {
        succeeded(&shard(path, whole));
    }
    // Shard 1 is killed after its first run, shard 2 in the middle of a line, shard 3 never begins.
    let journal = |index: usize| path.join(format!("s.h5.shard-{index}-of-5.journal"));
    let mut child = start(path, "1/5");
    while std::fs::read(journal(1)).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count()) < 4
        && child.try_wait().unwrap().is_none()
    {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    succeeded(&shard(path, "2/5"));
    let whole = std::fs::read(journal(2)).unwrap();
    std::fs::write(journal(2), &whole[..whole.len() - 77]).unwrap();
    let torn = std::fs::read(journal(2)).unwrap();

    let plan = json(path, &words(&["--dry-run", "--merge", "--json"]));
    let missing = plan["runs"].as_u64().unwrap();
    assert!(missing > 0 && plan["seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(std::fs::read(journal(2)).unwrap(), torn, "a plan changes nothing");
    let journals: Vec<String> = files(path).into_iter().filter(|name| name.ends_with(".journal")).collect();
    assert_eq!(journals.len(), 5);

    let loud: Vec<&str> = words(&["--merge"]).into_iter().filter(|word| *word != "-q").collect();
    let output = gfmd(path, &loud);
    succeeded(&output);
    assert!(
        message(&output).contains(&format!("runs are in 5 journals; {missing} are computed now")),
        "{}",
        message(&output)
    );
    compare(path, "overlapping shards");
    // Once more, as a scheduler may do: the file has all runs, so that nothing is computed.
    let output = gfmd(path, &loud);
    assert!(message(&output).contains("0 are computed now"), "{}", message(&output));
    compare(path, "merged again");
}

#[test]
fn a_torn_shard_is_continued() {
    let folder = folder(&few());
    let path = folder.path();
    succeeded(&shard(path, "1/2"));
    let journal = path.join("s.h5.shard-1-of-2.journal");
    let whole = std::fs::read(&journal).unwrap();
    std::fs::write(&journal, &whole[..whole.len() - 40]).unwrap();
    let again = gfmd(path, &words(&["--shard", "1/2"]));
    assert_eq!(again.status.code(), Some(2));
    assert!(message(&again).contains("shard-1-of-2.journal") && message(&again).contains("--resume"));
    let report = json(path, &words(&["--resume", "--shard", "1/2", "--json"]));
    assert_eq!((&report["shard"], &report["runs"], &report["all_runs"]), (&"1/2".into(), &4.into(), &8.into()));
    assert_eq!(report["journal"], "s.h5.shard-1-of-2.journal");
    assert_eq!(std::fs::read(&journal).unwrap(), whole, "the same record, to the last byte");
    merge_and_compare(path, "shard 0 of 2 is missing");
}

#[test]
fn journals_of_another_sweep_are_refused_by_name() {
    let folder = folder(&few());
    let path = folder.path();
    succeeded(&shard(path, "0/2"));
    let good = path.join("s.h5.shard-0-of-2.journal");
    let kept = std::fs::read(&good).unwrap();
    std::fs::write(path.join("sweep.toml"), few().replace("p_star = 0.05", "p_star = 0.02")).unwrap();
    let refuse = |name: &str, words: &[&str]| {
        let output = gfmd(path, words);
        assert!(output.status.code() == Some(2) && message(&output).contains(name), "{}", message(&output));
        assert!(message(&output).contains("another configuration") && !path.join("s.h5").exists());
        assert_eq!(std::fs::read(&good).unwrap(), kept);
    };
    refuse("s.h5.shard-0-of-2.journal", &words(&["--merge"]));
    refuse("s.h5.shard-0-of-2.journal", &words(&["--resume", "--shard", "0/2"]));
    std::fs::write(path.join("sweep.toml"), few()).unwrap();
    Journal::open(&path.join("s.h5.shard-5-of-7.journal"), b"{\"version\":\"0\",\"config\":\"\"}").unwrap();
    refuse("s.h5.shard-5-of-7.journal", &words(&["--merge"]));
    std::fs::remove_file(path.join("s.h5.shard-5-of-7.journal")).unwrap();
    std::fs::write(path.join("s.h5.shard-1-of-2.journal.old"), "a note").unwrap();
    std::fs::write(path.join("s.h5.shard-2-of-2.journal"), "no shard").unwrap();
    succeeded(&gfmd(path, &words(&["--merge"])));
    assert_eq!(files(path), ["s.h5", "s.h5.shard-1-of-2.journal.old", "s.h5.shard-2-of-2.journal"]);
}

#[test]
fn a_shard_that_is_being_computed_is_neither_started_nor_merged() {
    let folder = folder(&few());
    let path = folder.path();
    succeeded(&shard(path, "0/2"));
    succeeded(&shard(path, "1/2"));
    let before = files(path);
    let claim = gfmd_files::Output::claim(path.join("s.h5.shard-1-of-2")).unwrap();
    for output in [shard(path, "1/2"), gfmd(path, &words(&["--merge"]))] {
        assert_eq!(output.status.code(), Some(2));
        let text = message(&output);
        assert!(text.contains("s.h5.shard-1-of-2 is being written by another process"), "{text}");
    }
    drop(claim);
    assert_eq!(files(path), before);
    merge_and_compare(path, "after a refusal");
}

#[test]
fn an_interrupted_shard_ends_with_130_and_names_its_journal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("sweep.toml"), SWEEP.replace("realisations = 2", "realisations = 4000")).unwrap();
    for signal in ["INT", "TERM"] {
        let child = start(path, "1/3");
        let journal = path.join("s.h5.shard-1-of-3.journal");
        let before = journal.metadata().map_or(0, |metadata| metadata.len());
        while journal.metadata().map_or(0, |metadata| metadata.len()) < before + 20_000 {
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", message(&output));
        assert!(message(&output).contains("s.h5.shard-1-of-3.journal, --resume continues"), "{}", message(&output));
        assert_eq!(files(path), ["s.h5.shard-1-of-3.journal"]);
    }
}

#[test]
fn a_merge_that_is_killed_loses_nothing() {
    if Command::new("strace").arg("-V").output().is_err() {
        return; // as the crash tests
    }
    let folder = folder(&few());
    let path = folder.path();
    let keep = path.join("keep");
    std::fs::create_dir(&keep).unwrap();
    succeeded(&shard(path, "0/3"));
    succeeded(&shard(path, "2/3"));
    for name in files(path) {
        std::fs::rename(path.join(&name), keep.join(&name)).unwrap();
    }
    let (mut call, mut killed) = (1, 0);
    loop {
        for entry in std::fs::read_dir(&keep).unwrap() {
            let from = entry.unwrap().path();
            std::fs::copy(&from, path.join(from.file_name().unwrap())).unwrap();
        }
        let calls = "write,pwrite64,writev,fsync,ftruncate,rename,unlink";
        let mut command = Command::new("strace");
        command.current_dir(path).args([
            "-f",
            "-o",
            "/dev/null",
            "-e",
            &format!("inject={calls}:signal=KILL:when={call}"),
        ]);
        let output = command.arg(env!("CARGO_BIN_EXE_gfmd")).args(words(&["--merge"])).output().unwrap();
        let done = output.status.success();
        killed += usize::from(!done);
        merge_and_compare(path, &format!("killed at call {call}"));
        if done {
            break;
        }
        call += 1 + call / 2;
    }
    assert!(killed > 5, "hardly anything was killed: {killed}");
}

/// A merge needs memory for the computed runs only, not for the runs already found.
#[test]
fn memory_counts_for_runs_that_are_computed_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("sweep.toml"), few()).unwrap();
    succeeded(&shard(path, "0/1"));
    let small = std::fs::read_to_string(path.join("s.h5.shard-0-of-1.journal")).unwrap();
    let records: Vec<serde_json::Value> = small
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .filter(|v: &serde_json::Value| v["run"].is_u64())
        .collect();
    assert_eq!(records.len(), 8);
    std::fs::remove_file(path.join("s.h5.shard-0-of-1.journal")).unwrap();

    // The same sweep with a grid of 4 TiB.
    std::fs::write(path.join("sweep.toml"), few().replace("eps_f_inv = [4, 8]", "eps_f_inv = [4, 8, 65536]")).unwrap();
    for words in [words(&[]), words(&["--merge"]), words(&["--resume", "--shard", "0/1"])] {
        let refused = gfmd(path, &words);
        assert!(
            refused.status.code() == Some(2) && message(&refused).contains("GiB are available"),
            "{}",
            message(&refused)
        );
    }
    assert!(files(path).is_empty(), "{:?}", files(path));
    let plan = json(path, &words(&["--dry-run", "--shard", "0/10", "--json"]));
    assert!(plan["memory_bytes"].as_u64().unwrap() > 1 << 40 && plan["runs"] == 1);

    let shown = gfmd(path, &["kappa-sweep", "--config", "sweep.toml", "--show-config"]);
    succeeded(&shown);
    let config = serde_json::to_string(std::str::from_utf8(&shown.stdout).unwrap()).unwrap();
    let head = format!("{{\"version\":\"{}\",\"config\":{config}}}", env!("CARGO_PKG_VERSION"));
    let journal = Journal::open(&path.join("s.h5.shard-0-of-2.journal"), head.as_bytes()).unwrap();
    for run in 0..10 {
        let loads = &records[run.min(7)]["loads"];
        journal.append(&[serde_json::json!({ "run": run, "loads": loads }).to_string()]).unwrap();
    }
    drop(journal);
    succeeded(&gfmd(path, &words(&["--merge"])));
    assert_eq!(files(path), ["s.h5"]);
}

#[test]
fn a_plan_tells_what_a_shard_takes() {
    let folder = tempfile::tempdir().unwrap();
    let plan = |words: &[&str]| json(folder.path(), &[&["kappa-sweep", "--dry-run", "--json"], words].concat());
    let whole = plan(&[]);
    let shards: Vec<_> = (0..5).map(|index| plan(&["--shard", &format!("{index}/5")])).collect();
    assert_eq!(
        shards.iter().map(|shard| shard["runs"].as_u64().unwrap()).sum::<u64>(),
        whole["runs"].as_u64().unwrap()
    );
    for (index, shard) in shards.iter().enumerate() {
        assert_eq!(shard["shard"], format!("{index}/5"));
        assert!(shard["seconds"].as_f64().unwrap() > 0.0 && shard["memory_bytes"].as_u64().unwrap() > 50 << 20);
    }
    let text = gfmd(folder.path(), &["kappa-sweep", "--dry-run", "--shard", "1/5"]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("shard 1/5: "));
    for bad in ["5/5", "0", "1/0", "a/b"] {
        let refused = gfmd(folder.path(), &["kappa-sweep", "--shard", bad]);
        assert!(
            refused.status.code() == Some(2) && message(&refused).contains("K from 0 to M - 1"),
            "{}",
            message(&refused)
        );
    }
    for bad in [
        &["--shard", "0/2", "--merge"][..],
        &["--merge", "--runs-of", "x.h5"],
        &["--shard", "0/2", "--runs-of", "x.h5"],
    ] {
        assert_eq!(gfmd(folder.path(), &[&["kappa-sweep"], bad].concat()).status.code(), Some(2));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
