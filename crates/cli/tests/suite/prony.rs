//! `prony` from end to end.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use crate::common::{gfmd, json};
use serde_json::Value;

const THREE: [(f64, f64); 3] = [(0.01, 500.0), (1.0, 60.0), (100.0, 8.0)];

/// Returns the moduli of a series with the long-term modulus 3 at an angular frequency.
fn three(omega: f64) -> [f64; 2] {
    let of = |(time, modulus): (f64, f64)| {
        let x = omega * time;
        [modulus * x * x / (1.0 + x * x), modulus * x / (1.0 + x * x)]
    };
    THREE.into_iter().map(of).fold([3.0, 0.0], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
}

/// Returns `count` angular frequencies from 10^low to 10^high.
fn frequencies(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| 10_f64.powf(low + (high - low) * f64::from(i) / f64::from(count - 1)))
}

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &flags.split_whitespace().chain(["--json", "-q"]).collect::<Vec<_>>())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Writes a table of the known series at angular frequencies 10^low to 10^high.
fn write(folder: &Path, heads: &str, low: f64, high: f64) {
    let mut text = format!("{heads}\n");
    for omega in frequencies(low, high, 41) {
        let [storage, loss] = three(omega);
        writeln!(text, "{:e},{storage:e},{loss:e}", omega / TAU).unwrap();
    }
    std::fs::write(folder.join("dma.csv"), text).unwrap();
}

#[test]
fn a_table_gives_the_options_of_a_body() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "frequency (Hz), storage (MPa), loss (MPa)", -2.0, 2.0);
    let report = run(folder.path(), "prony --dma dma.csv --plots dma");
    assert_eq!(report["stress_unit"], "MPa");
    let branches = report["branches"].as_array().unwrap();
    assert_eq!(branches.len(), 3);
    for (branch, (time, modulus)) in branches.iter().zip(THREE) {
        assert!((number(&branch["time"]) / time - 1.0).abs() < 1e-6, "{branch}");
        assert!((number(&branch["modulus"]) / modulus - 1.0).abs() < 1e-6, "{branch}");
        assert!((number(&branch["fraction"]) * 571.0 / modulus - 1.0).abs() < 1e-6, "{branch}");
        assert!(number(&branch["modulus_error"]) < 1e-6 * modulus);
    }
    assert!((number(&report["young_long_term"]) / 3.0 - 1.0).abs() < 1e-6);
    assert!((number(&report["young_instantaneous"]) / 571.0 - 1.0).abs() < 1e-6);
    assert!(number(&report["storage_misfit"]).max(number(&report["loss_misfit"])) < 1e-6);
    for name in ["dma-moduli.svg", "dma-moduli.png", "dma-branches.svg", "dma-branches.png"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    // The line works as it is.
    let options = report["options"].as_str().unwrap();
    assert!(options.starts_with("--prony 0.01:0.875656") && options.ends_with(" --moduli long-term --young 3MPa"));
    let slide = "slide --n 16 --eps-f-inv 4 --size 1 --unit mm --poisson 0.5 --p-star 0.05 --velocity 0.1,10";
    let sliding = run(folder.path(), &format!("{slide} {options}"));
    let megapascal = number(&sliding["young_long_term"]) / 3.0;
    assert!((number(&sliding["young_instantaneous"]) / (571.0 * megapascal) - 1.0).abs() < 1e-6, "{sliding}");
    // The whole table as it is printed.
    let text = gfmd(folder.path(), &["prony", "--dma", "dma.csv", "-q"]).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains(options) && text.contains("dma.csv: 41 points, 0.001592 Hz to 15.92 Hz"), "{text}");
    // Without a unit, a number without one.
    write(folder.path(), "frequency,storage,loss", -2.0, 2.0);
    let bare = run(folder.path(), "prony --dma dma.csv --branches 3");
    assert!(bare["options"].as_str().unwrap().ends_with("--young 3"), "{bare}");
    let named = run(folder.path(), "prony --dma dma.csv --times 100,1,0.01 --stress-unit kPa");
    assert!(named["options"].as_str().unwrap().ends_with("--young 3kPa"), "{named}");
}

/// The page about time shows this table of the example, which is made with the moduli 2 MPa and 2000 MPa.
#[test]
fn the_example_of_the_documentation_gives_its_numbers() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let flags = ["prony", "--dma", "data/examples/dma.csv", "--wlf", "8.86,101.6,20"];
    let output = gfmd(&root, &[&flags[..], &["-q"]].concat());
    let text = String::from_utf8(output.stdout).unwrap();
    let page = std::fs::read_to_string(root.join("docs/time.md")).unwrap();
    let block = page.split("```text\ndata/examples/dma.csv").nth(1).unwrap().split("```").next().unwrap();
    for line in block.lines().skip(1).filter(|line| !line.starts_with("...")) {
        let part = line.split(",...").next().unwrap();
        assert!(text.contains(part), "{part}\n{text}");
    }
    let report = json(&root, &[&flags[..], &["--json", "-q"]].concat());
    assert!((number(&report["young_long_term"]) / 2.0 - 1.0).abs() < 0.03, "{report}");
    assert!((number(&report["young_instantaneous"]) / 2000.0 - 1.0).abs() < 0.01, "{report}");
    assert!(report["warnings"].as_array().unwrap().is_empty(), "{report}");
}

#[test]
fn temperatures_are_shifted_to_one_curve() {
    let folder = tempfile::tempdir().unwrap();
    // Two temperatures below each other, each with two decades of frequency: log a_T = −2 at 40, 0 at 20.
    let shift = |temperature: f64| -4.0 * (temperature - 20.0) / (20.0 + temperature - 20.0);
    let mut heads = "temperature (C),frequency (rad/s),storage (MPa),loss (MPa)\n".to_owned();
    let mut shifted = "frequency (rad/s),storage (MPa),loss (MPa),log_a_t\n".to_owned();
    for temperature in [20.0, 40.0] {
        for omega in frequencies(0.0, 2.0, 21) {
            let [storage, loss] = three(omega * 10_f64.powf(shift(temperature)));
            writeln!(heads, "{temperature},{omega:e},{storage:e},{loss:e}").unwrap();
            writeln!(shifted, "{omega:e},{storage:e},{loss:e},{}", shift(temperature)).unwrap();
        }
    }
    std::fs::write(folder.path().join("dma.csv"), heads).unwrap();
    std::fs::write(folder.path().join("shifted.csv"), shifted).unwrap();
    let report = run(folder.path(), "prony --dma dma.csv --wlf 4,20,20");
    assert_eq!(report["reference_temperature"], 20.0);
    for (branch, (time, modulus)) in report["branches"].as_array().unwrap().iter().zip(THREE) {
        assert!((number(&branch["time"]) / time - 1.0).abs() < 1e-6, "{report}");
        assert!((number(&branch["modulus"]) / modulus - 1.0).abs() < 1e-6, "{report}");
    }
    let same = run(folder.path(), "prony --dma shifted.csv");
    assert!((number(&same["young_long_term"]) / number(&report["young_long_term"]) - 1.0).abs() < 1e-9);
    // A wrong shift does not collapse.
    let wrong = run(folder.path(), "prony --dma dma.csv --wlf 8,20,20");
    assert!(number(&wrong["loss_misfit"]) > 0.05, "{wrong}");
}

#[test]
fn moduli_beyond_the_data_are_called_extrapolated() {
    let folder = tempfile::tempdir().unwrap();
    let codes = |flags: &str| -> Vec<String> {
        let report = run(folder.path(), &format!("prony --dma dma.csv {flags}"));
        let all = report["warnings"].as_array().unwrap();
        assert!(all.iter().all(|warning| warning["code"] == "extrapolated"), "{report}");
        all.iter().map(|warning| warning["text"].as_str().unwrap().to_owned()).collect()
    };
    write(folder.path(), "frequency,storage (MPa),loss", -4.0, 5.0);
    assert!(codes("").is_empty());
    write(folder.path(), "frequency,storage (MPa),loss", -2.0, 1.0);
    let found = codes("");
    assert!(found.len() == 2 && found[0].contains("the long-term modulus") && found[0].contains("--long-term"));
    assert!(found[1].contains("still rises at the highest frequency, 1.592 Hz"), "{found:?}");
    assert_eq!(codes("--long-term 3").len(), 1);
}

#[test]
fn what_gives_no_series_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, flags: &str, words: &str| {
        std::fs::write(folder.path().join("t.csv"), text).unwrap();
        let line = format!("prony --dma t.csv {flags}");
        let output = gfmd(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text:?} {flags}: {error}");
        assert!(error.trim().lines().count() == 1 && error.contains(words), "{text:?} {flags}: {error}");
    };
    let good = "1,2,0.5\n10,3,0.5\n";
    refused("1,2,3\n2,-1,3\n", "", "--dma: t.csv: line 2 has the storage -1; it must be a positive, finite number");
    refused("frequency,loss\n1,2\n", "", "line 1 has no column storage");
    refused("f (rpm),storage,loss\n1,2,3\n", "", "line 1 has the unit \"rpm\" of the frequency");
    refused("1,2,3\n1,2,3\n", "", "line 2 has the frequency 1, as line 1 has");
    refused(good, "--branches 3", "--branches: there are 2 points for 3 relaxation times");
    refused(good, "--branches 0", "--branches: there are 0 relaxation times; there must be 1 to 60");
    refused(good, "--times 1,-1", "--times: a relaxation time is -1");
    refused(good, "--times 1 --branches 1", "cannot be used with");
    refused(good, "--long-term 2.5", "--long-term: the long-term modulus is 2.5; it must be positive and below");
    refused(good, "--wlf 17,51", "--wlf is 2 numbers; it must be three numbers, C1, C2 and T0");
    refused(good, "--wlf 17,0,20", "--wlf: C2 is 0; it must be positive and finite");
    refused(good, "--wlf 17,51,20", "--dma: t.csv has no column temperature; it must have one with --wlf");
    refused(good, "--stress-unit nm", "--stress-unit");
    let two = "frequency,storage,loss,temperature\n1,2,0.5,20\n1,3,0.5,-40\n";
    refused(two, "", "--wlf is missing; the temperature of t.csv, line 3, differs from line 2");
    refused(two, "--wlf 17,51,20", "line 3: the temperature is -40; it must be above T0 - C2 = -31");
    refused("frequency,storage,loss,log_a_t\n1,2,0.5,0\n1,3,0.5,400\n", "", "line 3 has log_a_t 400; the shifted");
    refused("frequency,storage,loss,log_a_t\n1,2,0.5,0\n", "--wlf 17,51,20", "left out with a table that has a column");
    refused("0.001,0.001,1\n1,500,500\n1000,1000,1\n", "", "the best fit has no long-term modulus");
    refused("", "", "it has no row");
    std::fs::remove_file(folder.path().join("t.csv")).unwrap();
    let output = gfmd(folder.path(), &["prony", "--dma", "none.csv"]);
    assert_eq!(output.status.code(), Some(2));
}
