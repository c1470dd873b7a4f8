//! `kappa-sweep` from end to end: result, file, interruption.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{gfmd, json, numbers, sweep};
use gfmd_files::{Journal, Reader};

fn write_config(folder: &Path) {
    std::fs::write(folder.join("sweep.toml"), sweep(4, 200)).unwrap();
}

#[test]
fn a_sweep_ends_with_a_result_a_file_and_plots() {
    let folder = tempfile::tempdir().unwrap();
    write_config(folder.path());
    let report = json(folder.path(), &["kappa-sweep", "--config", "sweep.toml", "--out", "s.h5", "--json", "-q"]);
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 8);
    for point in points {
        assert!(point["kappa"].as_f64().unwrap() > 1.0 && point["kappa_sem"].as_f64().unwrap() > 0.0);
    }
    let fit = &report["fit"];
    let [low, high] = [0, 1].map(|i| fit["ci95"][i].as_f64().unwrap());
    let kappa = fit["kappa_tfc"].as_f64().unwrap();
    assert!(low < kappa && kappa < high);
    assert_eq!(fit["p_star"], 0.05);
    assert_eq!(fit["terms"].as_array().unwrap().len(), 3);
    for plot in report["plots"].as_array().unwrap() {
        assert!(folder.path().join(plot.as_str().unwrap()).metadata().unwrap().len() > 1000);
    }
    let file = Reader::open(folder.path().join("s.h5")).unwrap();
    let worst = file.values::<f64>("/runs/residual_penetration").unwrap().into_iter().fold(0.0, f64::max);
    assert!(worst <= 1e-8, "{worst:e}");
    // The configuration in a file describes a sweep with identical numbers.
    std::fs::write(folder.path().join("again.toml"), file.text("/", "config").unwrap()).unwrap();
    json(
        folder.path(),
        &["kappa-sweep", "--config", "again.toml", "--out", "again.h5", "--json", "-q", "--threads", "1"],
    );
    assert_eq!(numbers(&folder.path().join("s.h5")), numbers(&folder.path().join("again.h5")));
}

#[test]
fn a_limit_below_zero_has_no_place_on_logarithmic_axes() {
    let folder = tempfile::tempdir().unwrap();
    let config = "
        points = { eps_t_inv = [1, 2], eps_f_inv = [2, 4], eps_c_inv = [2, 4], centre = [1, 2, 2] }
        loads = { p_star = [0.01, 0.02, 0.05] }
        statistics = { realisations = 2 }
        fit = { resamples = 50 }";
    std::fs::write(folder.path().join("sweep.toml"), config).unwrap();
    let report = json(folder.path(), &["kappa-sweep", "--config", "sweep.toml", "--out", "s.h5", "--json", "-q"]);
    assert!(report["fits"].as_array().unwrap().iter().any(|fit| fit["kappa_tfc"].as_f64().unwrap() < 0.0));
    assert_eq!(report["plots"].as_array().unwrap().len(), 6);
}

#[test]
fn a_sweep_killed_again_and_again_ends_with_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write_config(folder.path());
    let arguments = |out: &'static str| ["kappa-sweep", "--config", "sweep.toml", "--out", out, "-q", "--json"];
    json(folder.path(), &arguments("whole.h5"));

    let journal = folder.path().join("cut.h5.journal");
    // A record is two lines, and the first record is the head.
    let records = || std::fs::read_to_string(&journal).map_or(0, |text| text.matches('\n').count() / 2);
    let whole = |text: &str| {
        let breaks: Vec<usize> = text.match_indices('\n').map(|(place, _)| place + 1).collect();
        breaks.get((breaks.len() / 2 * 2).wrapping_sub(1)).copied().unwrap_or(0)
    };
    let mut resumed = arguments("cut.h5").to_vec();
    resumed.push("--resume");
    // The process is killed before the first run is finished, then each time after a few more.
    for enough in [1, 2, 5, 9] {
        let before = std::fs::read_to_string(&journal).unwrap_or_default();
        let mut child = Command::new(env!("CARGO_BIN_EXE_gfmd"))
            .current_dir(folder.path())
            .args(&resumed)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        while records() < enough && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!folder.path().join("cut.h5").exists(), "killed too late to test anything");
        let mut text = std::fs::read_to_string(&journal).unwrap();
        assert!(text.starts_with(&before[..whole(&before)]), "finished runs were lost");
        // Simulates a kill in the middle of a record, replacing any partial record that the kill may have left.
        text.truncate(whole(&text));
        text.push_str("00000000000001b5 5f3759df");
        std::fs::write(&journal, text).unwrap();
    }
    let refused = gfmd(folder.path(), &arguments("cut.h5"));
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--resume"));

    json(folder.path(), &resumed);
    assert_eq!(numbers(&folder.path().join("whole.h5")), numbers(&folder.path().join("cut.h5")));
    assert!(!journal.exists());
}

#[test]
fn a_damaged_record_of_a_journal_is_named_and_the_journal_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    write_config(folder.path());
    let journal = folder.path().join("s.h5.journal");
    let config = gfmd(folder.path(), &["kappa-sweep", "--config", "sweep.toml", "--show-config"]).stdout;
    let config = serde_json::to_string(&String::from_utf8(config).unwrap()).unwrap();
    let head = format!("{{\"version\":\"{}\",\"config\":{config}}}", env!("CARGO_PKG_VERSION"));
    let resume = ["kappa-sweep", "--config", "sweep.toml", "--out", "s.h5", "--resume", "-q"];
    let refuse = |words: &str| {
        let before = std::fs::read(&journal).unwrap();
        let output = gfmd(folder.path(), &resume);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("s.h5.journal") && message.contains(words), "{message}");
        assert_eq!(std::fs::read(&journal).unwrap(), before);
    };
    let records = Journal::open(&journal, head.as_bytes()).unwrap();
    records.append(&["{\"run\":0,\"loads\":[]}", "{\"run\":1,\"loads\":[null,null]}"]).unwrap();
    refuse("record 2: the run has 0 loads");
    let mut bytes = std::fs::read(&journal).unwrap();
    let middle = bytes.windows(7).position(|bytes| bytes == b"\"run\":0").unwrap();
    bytes[middle] ^= 1;
    std::fs::write(&journal, &bytes).unwrap();
    refuse("record 2: the record is damaged");
    std::fs::remove_file(&journal).unwrap();
    Journal::open(&journal, b"{\"version\":\"0\",\"config\":\"\"}").unwrap();
    refuse("another configuration");
    std::fs::write(&journal, "a letter\n").unwrap();
    refuse("not a journal");
}

#[test]
fn a_dry_run_says_what_every_point_takes() {
    let folder = tempfile::tempdir().unwrap();
    for preset in ["smoke", "default", "thesis", "prodanov", "line"] {
        let plan = json(folder.path(), &["kappa-sweep", "--preset", preset, "--dry-run", "--json"]);
        for point in plan["points"].as_array().unwrap() {
            assert!(point["n"].as_u64().unwrap() > 1 && point["memory_bytes"].as_u64().unwrap() > 0);
            assert!(point["seconds"].as_f64().unwrap() > 0.0);
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_sweep_with_a_target_ends_there_resumed_or_not_and_can_be_checked() {
    let folder = tempfile::tempdir().unwrap();
    write_config(folder.path());
    let half_width = |report: &serde_json::Value| {
        let [low, high] = [0, 1].map(|i| report["fit"]["ci95"][i].as_f64().unwrap());
        0.5 * (high - low) / report["fit"]["kappa_tfc"].as_f64().unwrap()
    };
    let sweep = |more: &str| -> Vec<String> {
        let flags = format!("kappa-sweep --config sweep.toml --json -q {more}");
        flags.split_whitespace().map(str::to_owned).collect()
    };
    let run = |more: &str| {
        let flags = sweep(more);
        json(folder.path(), &flags.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let first = half_width(&run("--out first.h5"));
    let target = format!("--target {}", 0.7 * first);
    assert!(half_width(&run(&format!("{target} --out a.h5"))) <= 0.7 * first);
    // Killed at some point, and continued.
    let flags = sweep(&format!("{target} --out b.h5"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_gfmd"))
        .args(&flags)
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    let _ = child.kill();
    child.wait().unwrap();
    run(&format!("{target} --out b.h5 --resume"));
    assert_eq!(numbers(&folder.path().join("a.h5")), numbers(&folder.path().join("b.h5")));
    let config = Reader::open(folder.path().join("a.h5")).unwrap().text("/", "config").unwrap();
    assert!(config.contains("surfaces = ["), "{config}");
    let check = gfmd(folder.path(), &["check", "a.h5", "--rerun", "--sample", "3"]);
    assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stdout));
    for (more, part) in [("--shard 0/2", "--shard"), ("--merge", "--merge"), ("--target 3", "--target")] {
        let more = if part == "--target" { more.to_owned() } else { format!("{target} {more}") };
        let flags = sweep(&more);
        let output = gfmd(folder.path(), &flags.iter().map(String::as_str).collect::<Vec<_>>());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(part), "{message}");
    }
}
