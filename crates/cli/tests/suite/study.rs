//! `study`: one file of many contacts, whole, in shards, and killed; failing members, bad input, page and check.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::{STUDY, gfmd, json, long, numbers};
use gfmd_files::Reader;

fn folder(study: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    folder
}

fn words<'a>(rest: &[&'a str]) -> Vec<&'a str> {
    [&["study", "study.toml", "-q", "--threads", "1"], rest].concat()
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}", message(output));
}

/// Returns the single line of a refusal.
fn refused(study: &str) -> String {
    let folder = folder(study);
    let output = gfmd(folder.path(), &words(&[]));
    let text = message(&output);
    assert_eq!(output.status.code(), Some(2), "{study}: {text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{study}: nothing is written");
    text
}

/// Compares two results of the same study; nothing else is left of the second one.
fn compare(folder: &Path, what: &str) {
    assert!(numbers(&folder.join("s.h5")) == numbers(&folder.join("whole.h5")), "{what}");
    let [found, whole] = ["s.h5", "whole.h5"].map(|name| Reader::open(folder.join(name)).unwrap());
    for attribute in ["config", "version", "warnings"] {
        assert_eq!(found.text("/", attribute).unwrap(), whole.text("/", attribute).unwrap(), "{what}");
    }
    let left = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(left.filter(|name| name.starts_with("s.h5")).collect::<Vec<_>>(), ["s.h5"], "{what}");
}

/// Starts a command, kills it after some time, and returns true if it had not ended.
fn killed(folder: &Path, words: &[&str], after: Duration) -> bool {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gfmd"));
    let mut child =
        command.current_dir(folder).args(words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    std::thread::sleep(after);
    let is_running = child.try_wait().unwrap().is_none();
    child.kill().unwrap();
    child.wait().unwrap();
    is_running
}

#[test]
fn a_study_has_the_numbers_of_single_contacts() {
    let folder = folder(STUDY);
    let path = folder.path();
    let report = json(path, &words(&["--json"]));
    assert_eq!(report["surface"], serde_json::json!(["smooth", "rough"]));
    assert_eq!(report["seed"], serde_json::json!([1, 2, 3]));
    let line =
        "contact --n 16 --eps-f-inv 4 --p-star 0.02,0.1 --hurst 0.3 --seed 2 --height 0.1 --poisson 0.3 --json -q";
    let alone = json(path, &line.split_whitespace().collect::<Vec<_>>());
    // Surface 1, seed 1, body 1.
    let member = (3 + 1) * 2 + 1;
    for name in ["area_fraction", "mean_gap", "approach", "iterations", "kappa"] {
        let all = report["numbers"][name]["values"].as_array().unwrap();
        for load in 0..2 {
            assert_eq!(all[member * 2 + load].as_f64(), alone["loads"][load][name].as_f64(), "{name}");
        }
    }
    // The mean and its error over the seeds.
    let found = report["means"].as_array().unwrap();
    let is_it = |one: &&serde_json::Value| one["surface"] == "rough" && one["body"] == "thin" && one["load"] == 0.02;
    let found = found.iter().find(is_it).unwrap();
    let thin: Vec<f64> = (0..3)
        .map(|seed| report["numbers"]["area_fraction"]["values"][((3 + seed) * 2 + 1) * 2].as_f64().unwrap())
        .collect();
    let mean = thin.iter().sum::<f64>() / 3.0;
    let error = (thin.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 6.0).sqrt();
    let of = |name: &str| found["numbers"]["area_fraction"][name].as_f64().unwrap();
    assert!((of("mean") - mean).abs() < 1e-15 && (of("standard_error") - error).abs() < 1e-15);
    assert_eq!(found["numbers"]["area_fraction"]["count"], 3);

    let reader = Reader::open(path.join("study.h5")).unwrap();
    assert_eq!(reader.shape("/study/area_fraction").unwrap(), [2, 3, 2, 2]);
    assert_eq!(reader.values::<f64>("/study/load").unwrap(), [0.02, 0.1]);
    assert_eq!(reader.values::<f64>("/study/seed").unwrap(), [1.0, 2.0, 3.0]);
    assert_eq!(reader.texts("/study/body").unwrap(), ["soft", "thin"]);
    assert!(reader.texts("/study/status").unwrap().iter().all(|status| status == "solved"));
    assert!(reader.texts("/study/config").unwrap()[member].contains("hurst = 0.3"));
    assert_eq!(reader.text("/study/mean_gap", "units").unwrap(), "length");
    assert!(!reader.text("/study/mean_gap", "long_name").unwrap().is_empty());

    let table = String::from_utf8(gfmd(path, &words(&["--out", "t.h5"])).stdout).unwrap();
    assert!(
        table.contains("2 surfaces x 3 seeds x 2 bodies x 2 loads\n12 members, 0 failed; means over 3 seeds"),
        "{table}"
    );
    assert_eq!(table.lines().filter(|line| line.contains("rough") && line.contains("thin")).count(), 2, "{table}");
}

#[test]
fn shards_and_killed_runs_give_the_file_of_one_run() {
    let folder = folder(STUDY);
    let path = folder.path();
    succeeded(&gfmd(path, &words(&["--out", "whole.h5"])));
    for count in [1, 4, 31] {
        for index in (0..count).rev() {
            succeeded(&gfmd(path, &words(&["--out", "s.h5", "--resume", "--shard", &format!("{index}/{count}")])));
        }
        succeeded(&gfmd(path, &words(&["--out", "s.h5", "--merge"])));
        compare(path, &format!("{count} shards"));
        // Merged once more, there is nothing to compute, and the file stays.
        let before = std::fs::read(path.join("s.h5")).unwrap();
        succeeded(&gfmd(path, &words(&["--out", "s.h5", "--merge"])));
        assert!(std::fs::read(path.join("s.h5")).unwrap() == before);
        std::fs::remove_file(path.join("s.h5")).unwrap();
    }
    // A shard that is missing, and others killed at some time.
    let mut kills = 0;
    for round in 0..8 {
        let shard = format!("{}/4", round % 3);
        let after = Duration::from_millis(3 + 7 * round);
        kills += usize::from(killed(path, &words(&["--out", "s.h5", "--resume", "--shard", &shard]), after));
    }
    assert!(kills > 0);
    let plan = json(path, &words(&["--out", "s.h5", "--merge", "--dry-run", "--json"]));
    assert!(plan["members"].as_array().unwrap().len() >= 3, "{plan}");
    succeeded(&gfmd(path, &words(&["--out", "s.h5", "--merge"])));
    compare(path, "killed shards");
}

/// The study of the thesis' size: 3 surfaces x 10 seeds x 6 loads, killed at random 30 times over four shards.
#[test]
fn thirty_kills_over_four_shards_change_nothing() {
    let (seeds, n, kills) = if long() { (10, 128, 30) } else { (2, 16, 4) };
    let study = format!(
        "command = \"contact\"\n[contact]\nn = {n}\neps_f_inv = 4\np_star = \"0.01:0.3:6\"\n[study]\nseed = \
         \"1:{seeds}\"\nsurface = [{{ name = \"a\", hurst = 0.8 }}, {{ name = \"b\", hurst = 0.5 }}, \
         {{ name = \"c\", hurst = 0.2 }}]\n"
    );
    let folder = folder(&study);
    let path = folder.path();
    let started = std::time::Instant::now();
    succeeded(&gfmd(path, &words(&["--out", "whole.h5"])));
    let whole = started.elapsed();
    let mut random = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut done = 0;
    for _ in 0..20 * kills {
        if done == kills {
            break;
        }
        let shard = format!("{}/4", (next() * 4.0) as usize);
        // A shard takes a fourth of the time.
        let after = whole.mul_f64(0.25 * next());
        done += usize::from(killed(path, &words(&["--out", "s.h5", "--resume", "--shard", &shard]), after));
    }
    // Small shards may all be finished before the last kill.
    assert!(done == kills || done > 0 && !long(), "{done} of {kills} kills");
    for index in 0..4 {
        succeeded(&gfmd(path, &words(&["--out", "s.h5", "--resume", "--shard", &format!("{index}/4")])));
    }
    succeeded(&gfmd(path, &words(&["--out", "s.h5", "--merge"])));
    compare(path, "killed at random");
}

#[test]
fn a_member_that_fails_is_recorded_and_the_others_go_on() {
    // The third surface is no file; the second body allows no search.
    let study = r#"
        command = "contact"
        [contact]
        p_star = [0.02, 0.1]
        [study]
        surface = [{ name = "made", n = 16, eps_f_inv = 4 }, { name = "other", n = 24, eps_f_inv = 4 }, "absent.npy"]
        body = [{ name = "one", young = 1.0 }, { name = "none", max_iterations = 1 }]
    "#;
    let folder = folder(study);
    let path = folder.path();
    let output = gfmd(path, &words(&["--json"]));
    assert_eq!(output.status.code(), Some(1), "{}", message(&output));
    assert!(message(&output).contains("4 of 6 members failed"), "{}", message(&output));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let status: Vec<&str> = report["status"].as_array().unwrap().iter().map(|one| one.as_str().unwrap()).collect();
    assert_eq!(status, ["solved", "failed", "solved", "failed", "failed", "failed"]);
    assert!(report["error"][4].as_str().unwrap().contains("absent.npy"), "{}", report["error"]);
    let area = report["numbers"]["area_fraction"]["values"].as_array().unwrap();
    assert!(area[0].is_number() && area[2].is_null() && area[8].is_null());
    let table = gfmd(path, &["report", "study.h5", "--json"]);
    succeeded(&table);
    let page = std::fs::read_to_string(path.join("study.html")).unwrap();
    assert!(page.contains("Members that failed") && page.contains("absent.npy"));
    // In shards the same file results, and the failures are told.
    std::fs::rename(path.join("study.h5"), path.join("whole.h5")).unwrap();
    for index in 0..2 {
        let shard = format!("{index}/2");
        assert_eq!(gfmd(path, &words(&["--out", "s.h5", "--shard", &shard])).status.code(), Some(1));
    }
    assert_eq!(gfmd(path, &words(&["--out", "s.h5", "--merge"])).status.code(), Some(1));
    compare(path, "shards with failures");
}

#[test]
fn another_configuration_or_input_is_refused_on_resume() {
    let folder = folder(STUDY);
    let path = folder.path();
    succeeded(&gfmd(path, &words(&["--out", "s.h5", "--shard", "0/2"])));
    let again = gfmd(path, &words(&["--out", "s.h5", "--shard", "0/2"]));
    assert!(again.status.code() == Some(2) && message(&again).contains("--resume"), "{}", message(&again));
    std::fs::write(path.join("study.toml"), STUDY.replace("0.1]", "0.2]")).unwrap();
    for rest in [&["--resume", "--shard", "0/2"][..], &["--merge"]] {
        let other = gfmd(path, &words(&[&["--out", "s.h5"], rest].concat()));
        assert!(
            other.status.code() == Some(2) && message(&other).contains("another configuration"),
            "{}",
            message(&other)
        );
    }

    let made = "surface --n 16 --eps-f-inv 4 --out a.npy -q";
    succeeded(&gfmd(path, &made.split_whitespace().collect::<Vec<_>>()));
    let scan = "command = \"contact\"\n[contact]\nsize = 1.0\np_star = 0.05\n[study]\nsurface = [\"a.npy\"]\n\
                body = [{ young = 1.0 }, { young = 2.0 }]\n";
    std::fs::write(path.join("study.toml"), scan).unwrap();
    succeeded(&gfmd(path, &words(&["--out", "t.h5", "--shard", "0/2"])));
    succeeded(&gfmd(path, &made.replace("-q", "--seed 2 -q").split_whitespace().collect::<Vec<_>>()));
    for rest in [&["--resume", "--shard", "0/2"][..], &["--merge"]] {
        let other = gfmd(path, &words(&[&["--out", "t.h5"], rest].concat()));
        assert!(other.status.code() == Some(2) && message(&other).contains("a.npy has changed"), "{}", message(&other));
    }
}

#[test]
fn bad_studies_are_refused_in_one_line() {
    let of = |base: &str, lists: &str| format!("command = \"contact\"\n[contact]\n{base}\n[study]\n{lists}\n");
    let base = "n = 16\np_star = 0.05";
    for (study, words) in [
        ("command = \"punch\"\n".to_owned(), &["\"contact\", \"path\" or \"slide\""][..]),
        ("n = 16\n".into(), &["command"]),
        (format!("{}[other]\n", of(base, "seed = 1")), &["other", "command, contact, study"]),
        (of("n = 16\nhight = 1", "seed = 1"), &["hight", "height"]),
        (of("n = 16\nout = \"x.h5\"", "seed = 1"), &["out", "is no key"]),
        (of(base, "seeds = 1"), &["seeds", "surface, seed, body"]),
        (of(base, "seed = []"), &["seed is empty"]),
        (of(base, "seed = [1, \"0:3\"]"), &["seed has 1 twice"]),
        (of(base, "seed = \"5:3\""), &["5:3", "whole number"]),
        (of(base, "seed = 1.5"), &["1.5", "whole number"]),
        (of(base, "surface = []"), &["surface is empty"]),
        (of(base, "surface = 3"), &["surface is 3", "a list of files"]),
        (of(base, "body = [\"steel\"]"), &["steel", "tables of options"]),
        (of(base, "body = [{ name = \"a\", young = 1 }, { name = \"a\", young = 2 }]"), &["\"a\" twice"]),
        (of(base, "body = [{ name = \"a\", young = 1 }, { name = \"b\", young = 1 }]"), &["is the same contact as"]),
        (of(base, "body = [{ name = \"a\", p_star = 1 }]"), &["p_star", "[contact]"]),
        (of(base, "body = [{ name = \"a\", seed = 1 }]"), &["seed", "is no key"]),
        (of(base, "surface = [{ young = 2 }]\nbody = [{ young = 1 }]"), &["young", "one of them"]),
        (of("n = 16\np_star = 0.05\nseed = 3", "seed = [1, 2]"), &["seed", "one of them"]),
        (of("surface = \"a.npy\"\np_star = 0.05", "seed = [1, 2]"), &["the same contact", "no seed"]),
        (of("n = \"many\"\np_star = 0.05", "seed = 1"), &["n is"]),
        (of("n = 16\np_star = 0.05\npoisson = 0.7", "seed = [1, 2]"), &["every member", "--poisson", "0.7"]),
        (of("n = 16\np_star = 0.05", "body = [{ young = \"210 GPq\" }]"), &["GPq"]),
        (of(base, "seed = \"0:2000000\""), &["0:2000000"]),
        (of(base, "seed = 1 2"), &["line"]),
    ] {
        let text = refused(&study);
        assert!(words.iter().all(|word| text.contains(word)), "{study}: {text}");
    }
    // Lists that a command without studies does not take.
    for (line, way_out) in [
        ("theory --n 16 --p-star 0.1 --seed 1:10", "gfmd study computes many seeds"),
        ("estimate --n 16 --p-star 0.1 --seed 1 --seed 2", "gfmd study computes many seeds"),
        ("theory --surface a.npy --surface b.npy --p-star 0.1", "gfmd study computes many surfaces"),
    ] {
        let output = gfmd(Path::new("."), &line.split_whitespace().collect::<Vec<_>>());
        let text = message(&output);
        assert!(output.status.code() == Some(2) && text.trim_end().ends_with(way_out), "{line}: {text}");
    }
    let folder = folder(STUDY);
    let same = gfmd(folder.path(), &["study", "study.toml", "--out", "study.toml"]);
    assert_eq!(same.status.code(), Some(2), "{}", message(&same));
    let absent = gfmd(folder.path(), &["study", "absent.toml"]);
    assert!(absent.status.code() == Some(2) && message(&absent).contains("absent.toml"), "{}", message(&absent));
}

/// Lists on a command line give the file of the study with the same lists.
#[test]
fn lists_of_seeds_and_surfaces_make_a_study_of_a_command() {
    let folder = folder(
        "command = \"contact\"\n[contact]\nn = 16\nsize = \"50µm\"\nforce = [\"1N\", \"2N\"]\n\
         material = \"steel-s355\"\n[study]\nseed = \"3:5\"",
    );
    let path = folder.path();
    let run = |line: &str| gfmd(path, &line.split_whitespace().collect::<Vec<_>>());
    succeeded(&run("study study.toml -q --out whole.h5"));
    succeeded(&run("contact --n 16 --size 50um --force 1N,2N --material steel-s355 --seed 3,4:5 -q --out s.h5"));
    assert!(numbers(&path.join("s.h5")) == numbers(&path.join("whole.h5")));
    assert_eq!(json(path, &["check", "s.h5", "--rerun", "--json"])["differing"], 0);
    for name in ["a", "b"] {
        let seed = if name == "a" { "1" } else { "2" };
        succeeded(&run(&format!("surface --n 16 --size 1 --seed {seed} --out {name}.npy -q")));
    }
    let both = "--surface a.npy --surface b.npy --size 1";
    for line in [
        format!("path {both} --p-star 0.1,0.05 --steps 1"),
        format!("wear {both} --p-star 0.1 --coefficient 1 --distance 0,0.01 --steps 1"),
        format!("slide {both} --p-star 0.1 --prony 1:0.5 --velocity 0.1,1"),
    ] {
        let made = json(path, &format!("{line} --json -q").split_whitespace().collect::<Vec<_>>());
        assert_eq!(made["surface"], serde_json::json!(["a.npy", "b.npy"]), "{line}");
        assert_eq!(made["status"], serde_json::json!(["solved", "solved"]), "{line}");
    }
    assert!(Reader::open(path.join("study.h5")).is_ok());
    for (line, found) in [
        ("contact --n 16 --p-star 0.1 --seed 1:x", "--seed is \"1:x\"; it must be a whole number"),
        ("contact --n 16 --p-star 0.1 --seed 1,1", "--seed has 1 twice"),
        ("contact --n 16 --p-star 0.1 --seed 1:2 --plots p", "--plots is given; it must be left out with several of"),
        ("contact --n 16 --p-star 0.1 --seed 1:2 --sead 3", "unexpected argument '--sead'"),
        ("contact --n 16 --size 1um --young=-1GPa --p-star 0.1 --seed 1:2", "Young's modulus is -1GPa"),
        ("contact --surface a.npy --size 1 --p-star 0.1 --seed 1:2", "the same contact"),
        ("path --surface a.npy --surface a.npy --size 1 --p-star 0.1", "--surface is a.npy twice; each must differ"),
    ] {
        let output = run(line);
        let text = message(&output);
        assert!(output.status.code() == Some(2) && text.contains(found), "{line}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    }
}

#[test]
fn paths_and_sliding_have_steps_and_velocities() {
    let path_study = r#"
        command = "path"
        [path]
        n = 16
        eps_f_inv = 4
        p_star = [0.02, 0.1, 0.05]
        hardness = 0.2
        steps = 2
        [study]
        seed = [4, 9]
    "#;
    let path_folder = folder(path_study);
    let report = json(path_folder.path(), &words(&["--json"]));
    assert_eq!(report["axes"][0]["name"], "step");
    let reader = Reader::open(path_folder.path().join("study.h5")).unwrap();
    assert_eq!(reader.shape("/study/area_fraction").unwrap(), [1, 2, 1, 5]);
    let slide_study = r#"
        command = "slide"
        [slide]
        n = 16
        eps_f_inv = 4
        prony = [[0.1, 0.5]]
        p_star = [0.05, 0.1]
        velocity = [0.1, 1.0, 10.0]
        [study]
        seed = [4, 9]
    "#;
    let slide_folder = folder(slide_study);
    let path = slide_folder.path();
    let report = json(path, &words(&["--json"]));
    let reader = Reader::open(path.join("study.h5")).unwrap();
    assert_eq!(reader.shape("/study/friction").unwrap(), [1, 2, 1, 2, 3]);
    assert_eq!(reader.values::<f64>("/study/velocity").unwrap(), [0.1, 1.0, 10.0]);
    let line = "slide --n 16 --eps-f-inv 4 --prony 0.1:0.5 --p-star 0.05,0.1 --velocity 0.1,1,10 --seed 9 --json -q";
    let alone = json(path, &line.split_whitespace().collect::<Vec<_>>());
    for state in 0..6 {
        let found = report["numbers"]["friction"]["values"][6 + state].as_f64();
        assert_eq!(found, alone["states"][state]["friction"].as_f64());
    }
    for folder in [path_folder.path(), path] {
        succeeded(&gfmd(folder, &["report", "study.h5"]));
        succeeded(&gfmd(folder, &["check", "study.h5", "--rerun"]));
    }
}

#[test]
fn the_page_has_figures_and_check_computes_members_again() {
    let folder = folder(STUDY);
    let path = folder.path();
    succeeded(&gfmd(path, &words(&[])));
    let report = json(path, &["report", "study.h5", "--json"]);
    assert!(report["kind"] == "study" && report["figures"].as_u64().unwrap() >= 3, "{report}");
    let page = std::fs::read_to_string(path.join("study.html")).unwrap();
    for text in ["Study of many contacts", "12 of 12 members", "smooth", "thin", "study.toml"] {
        assert!(page.contains(text), "{text}");
    }
    let plain = json(path, &["check", "study.h5", "--json"]);
    let again = json(path, &["check", "study.h5", "--rerun", "--sample", "3", "--json"]);
    assert!(again["compared"].as_u64() > plain["compared"].as_u64());
    assert_eq!(again["differing"], 0);
    // No file that a result names is opened.
    let made = "surface --n 16 --eps-f-inv 4 --out a.npy -q";
    succeeded(&gfmd(path, &made.split_whitespace().collect::<Vec<_>>()));
    let scan = "command = \"contact\"\n[contact]\nsize = 1.0\np_star = 0.05\n[study]\nsurface = [\"a.npy\"]\n";
    std::fs::write(path.join("study.toml"), scan).unwrap();
    succeeded(&gfmd(path, &words(&[])));
    succeeded(&gfmd(path, &["check", "study.h5"]));
    let refused = gfmd(path, &["check", "study.h5", "--rerun"]);
    assert!(refused.status.code() == Some(2) && message(&refused).contains("a.npy"), "{}", message(&refused));
}

#[test]
fn the_example_of_the_page_prints_the_table_of_the_page() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/studies.md")).unwrap();
    let block =
        |kind: &str| page.split_once(&format!("```{kind}\n")).unwrap().1.split_once("```").unwrap().0.to_owned();
    let folder = folder(&block("toml"));
    let output = gfmd(folder.path(), &words(&[]));
    succeeded(&output);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), block("text"));
    // An array of jobs begins with this study.
    let cluster = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/cluster.md")).unwrap();
    let study = cluster.split_once("```toml\n").unwrap().1.split_once("```").unwrap().0.to_owned();
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    let plan = json(folder.path(), &words(&["--dry-run", "--shard", "1/4", "--json"]));
    assert_eq!(plan["all_members"], 10);
}

#[test]
fn lengths_have_the_unit_of_the_size() {
    let study = "command = 'contact'\n[study]\nseed = [1, 2]\n[contact]\nn = [16]\nsize = '10 um'\neps_f_inv = 4\n\
                 rms_height = '50 nm'\nyoung = '1 GPa'\npoisson = 0.3\npressure = ['1 MPa', '5 MPa']\n";
    let folder = folder(study);
    succeeded(&gfmd(folder.path(), &words(&["--out", "s.h5"])));
    let reader = Reader::open(folder.path().join("s.h5")).unwrap();
    assert_eq!(reader.text("/study/mean_gap", "units").unwrap(), "um");
    let list = "size = '10 um'\n";
    assert!(study.contains(list));
    std::fs::write(folder.path().join("study.toml"), study.replace(list, "size = ['10 um', '10 um']\n")).unwrap();
    succeeded(&gfmd(folder.path(), &words(&["--out", "t.h5"])));
    let again = Reader::open(folder.path().join("t.h5")).unwrap();
    let gaps = |reader: &Reader| reader.values::<f64>("/study/mean_gap").unwrap();
    assert_eq!(gaps(&reader), gaps(&again));
}

/// A run that continues none replaces a finished result only if both have one configuration.
#[test]
fn resume_keeps_the_finished_result_of_another_configuration() {
    let folder = folder(STUDY);
    let path = folder.path();
    let contact = "contact --n 16 --eps-f-inv 4 --p-star 0.05 --out c.h5 --resume";
    let slide = "slide --n 16 --eps-f-inv 4 --p-star 0.05 --prony 1:0.3 --velocity 1 --out l.h5 --resume";
    let curve = "path --n 16 --eps-f-inv 4 --p-star 0.05 --steps 1 --out p.h5 --resume";
    for (line, file) in [(contact, "c.h5"), (slide, "l.h5"), (curve, "p.h5")] {
        let first: Vec<&str> = line.split_whitespace().collect();
        succeeded(&gfmd(path, &first));
        succeeded(&gfmd(path, &first));
        let kept = std::fs::read(path.join(file)).unwrap();
        let other = line.replace("0.05", "0.06");
        let output = gfmd(path, &other.split_whitespace().collect::<Vec<_>>());
        assert!(output.status.code() == Some(2), "{line}");
        assert!(message(&output).contains("the finished result of another configuration"), "{}", message(&output));
        assert_eq!(std::fs::read(path.join(file)).unwrap(), kept, "{line}");
        let replacing = other.replace(" --resume", "");
        succeeded(&gfmd(path, &replacing.split_whitespace().collect::<Vec<_>>()));
    }
    succeeded(&gfmd(path, &words(&["--out", "s.h5", "--resume"])));
    std::fs::write(path.join("study.toml"), STUDY.replace("0.1]", "0.2]")).unwrap();
    let output = gfmd(path, &words(&["--out", "s.h5", "--resume"]));
    assert!(message(&output).contains("the finished result of another configuration"), "{}", message(&output));
    succeeded(&gfmd(path, &words(&["--out", "s.h5"])));
}
