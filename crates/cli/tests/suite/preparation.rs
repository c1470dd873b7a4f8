//! Preparation of scans from end to end: values, order, record, refusals.

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;

/// Creates a folder with a scan of 64 x 48 points on 32 um x 24 um: waves, tilt, offsets of rows, two spikes, one scar.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "# Width: 32 µm\n# Height: 24 µm\n# Value units: nm\n".to_owned();
    for j in 0..48 {
        for i in 0..64 {
            let (x, y) = (f64::from(i), f64::from(j));
            let fine = f64::from((7 * i * i + 13 * j * j + 5 * i * j) % 17) / 17.0;
            let row = f64::from((5 * j) % 7);
            let spike = if (i, j) == (20, 30) || (i, j) == (50, 11) { 400.0 } else { 0.0 };
            let scar = if (8..40).contains(&i) && j == 20 { 60.0 } else { 0.0 };
            let height =
                30.0 * (0.2 * x).sin() * (0.15 * y).cos() + fine + 2.0 * x - y + 0.01 * x * y + row + spike + scar;
            write!(text, "{height:.6} ").unwrap();
        }
        text.push('\n');
    }
    std::fs::write(folder.path().join("scan.txt"), text).unwrap();
    folder
}

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn refusal(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    assert_eq!(output.status.code(), Some(2), "{flags}");
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

#[test]
fn all_steps_act_in_one_order_and_are_recorded() {
    let folder = folder();
    let flags = "surface --surface scan.txt --filter s:2um,l:20um --fill harmonic --detrend polynomial:4 \
                 --level rows:median --descar --despike 5,5 --exclude 1um:2um,1um:2um --invalid above:500nm \
                 --invalid 30um:,20um: --crop :30um,2um: --out h.h5 --json";
    let found = json(folder.path(), &words(flags));
    let steps = found["scan"]["preparation"].as_array().unwrap();
    let names: Vec<&str> = steps.iter().map(|step| step["step"].as_str().unwrap()).collect();
    let order = ["invalid", "crop", "despike", "descar", "level", "detrend", "fill", "filter", "filter"];
    assert_eq!(names, order);
    for pair in steps.windows(2) {
        assert_eq!(pair[0]["rms_gradient_after"], pair[1]["rms_gradient_before"]);
    }
    assert_eq!((&steps[1]["n"], &steps[1]["origin"]), (&vec![60, 44].into(), &vec![0.0, 2000.0].into()));
    assert_eq!(steps[2]["window"], 5);
    assert!(steps[3]["points"].as_u64().unwrap() >= 30);
    assert_eq!((&steps[5]["trend"], &steps[7]["s"]), (&"polynomial:4".into(), &2000.0.into()));
    assert_eq!((&steps[8]["l"], &steps[8]["edges"]), (&20000.0.into(), &"regression".into()));
    assert_eq!(found["scan"]["resolves"], serde_json::json!([20000.0, 2000.0]));
    let shortest = found["scan"]["band"]["equivalent_shortest"].as_f64().unwrap();
    assert!((shortest / 2000.0 - 1.4575).abs() < 1e-3);
    let (first, last) = (&steps[0]["rms_gradient_before"], &steps[8]["rms_gradient_after"]);
    assert!(last.as_f64().unwrap() < 0.5 * first.as_f64().unwrap(), "{first} {last}");
    let reader = Reader::open(folder.path().join("h.h5")).unwrap();
    assert_eq!(reader.shape("/surface/height").unwrap(), [60, 44]);
    let kept: serde_json::Value = serde_json::from_str(&reader.text("/surface", "preparation").unwrap()).unwrap();
    assert_eq!(&kept, &found["scan"]["preparation"]);
    assert_eq!(reader.number("/surface", "nesting_index_s").unwrap(), 2000.0);
    let shifts: Vec<f64> = reader.values("/surface/preparation/shifts").unwrap();
    assert_eq!(shifts.len(), 44);
    assert!(shifts.iter().sum::<f64>().abs() < 1e-9 * shifts.iter().map(|shift| shift.abs()).sum::<f64>());
    // The order of the flags does not matter.
    let turned = "surface --surface scan.txt --crop :30um,2um: --invalid 30um:,20um: --invalid above:500nm --exclude \
                  1um:2um,1um:2um --despike 5,5 --descar --level rows:median --detrend polynomial:4 --fill harmonic \
                  --filter l:20um,s:2um --json";
    let again = json(folder.path(), &words(turned));
    assert_eq!(again["rms_gradient"], found["rms_gradient"]);
}

#[test]
fn a_contact_of_a_prepared_scan_is_solved_checked_and_repeated() {
    let folder = folder();
    let flags = "--surface scan.txt --despike --level columns:mean --detrend cubic --fill nearest --resample 32 \
                 --filter s:4um,edges=reflect --periodise mirror --young 1GPa --pressure 1MPa --json --out c.h5";
    let found = json(folder.path(), &words(&format!("contact {flags}")));
    assert_eq!(found["n"], serde_json::json!([64, 48]));
    let steps: Vec<_> = found["scan"]["preparation"].as_array().unwrap().iter().map(|s| s["step"].clone()).collect();
    assert_eq!(steps, ["despike", "level", "detrend", "fill", "resample", "filter"]);
    for command in ["check c.h5", "check c.h5 --rerun"] {
        let output = gfmd(folder.path(), &words(command));
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let path = "--surface scan.txt --despike --fill nearest --filter s:4um,kind=robust --young 1GPa --pressure \
                1MPa,2MPa --steps 1 --json --out p.h5";
    json(folder.path(), &words(&format!("path {path}")));
    assert!(gfmd(folder.path(), &words("check p.h5")).status.success());
}

#[test]
fn a_filter_of_a_generated_surface_takes_power_as_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let plain = "surface --n 128 --hurst 0.8 --eps-f-inv 32 --json";
    let whole = json(folder.path(), &words(plain));
    let found = json(folder.path(), &words(&format!("{plain} --filter s:0.0625")));
    let ratio = found["rms_gradient"].as_f64().unwrap() / whole["rms_gradient"].as_f64().unwrap();
    // 4 times the shortest wavelength, without the waves longer than half of the cell.
    assert!((0.58..0.6).contains(&ratio), "{ratio}");
    let source = found["source"].as_str().unwrap();
    assert!(source.contains("S filter 0.0625 (gaussian, ISO 16610-61)"), "{source}");
    let solve = "contact --n 64 --p-star 0.05 --filter s:0.1,l:0.6 --out c.h5 --json";
    json(folder.path(), &words(solve));
    assert!(gfmd(folder.path(), &words("check c.h5")).status.success());
    let profile = json(folder.path(), &words("surface --n 256 --dim 2 --filter s:0.1,kind=spline --json"));
    assert!(profile["source"].as_str().unwrap().contains("ISO 16610-22"));
}

#[test]
fn what_cannot_be_prepared_is_refused_in_one_line() {
    let folder = folder();
    for (flags, text) in [
        ("--crop 5um:4um", "5um to 4um is no range"),
        (
            "--crop 0:40um",
            "--crop: the crop along x is 0:40um = 40000; it must be START:END with 0 <= START < END <= 32000",
        ),
        ("--crop 1:2:3", "is no number"),
        ("--crop 0:1um,0:1um,0:1um", "it must be X0:X1,Y0:Y1"),
        ("--crop 3kg:4kg", "is no unit"),
        ("--invalid below:1m", "every point"),
        ("--invalid missing.npy", "missing.npy"),
        ("--invalid 40um:50um,:", "the box must lie in the scan"),
        ("--exclude above:1m --detrend plane", "it has no point of the scan"),
        ("--exclude 0:,0: --detrend plane", "do not determine all terms"),
        ("--exclude 0:4um, --detrend slope", "slope"),
        ("--exclude 0:4um,", "left out without --level or --detrend"),
        ("--despike 0", "the threshold of spikes is 0; it must be positive and finite"),
        ("--despike 5,4", "the window of spikes is 4; it must be an odd number of points from 3 to 99"),
        ("--despike 0.1,3", "stand out; at most a tenth may"),
        ("--despike", "points are undefined after its preparation, 34 spikes taken out: --fill harmonic"),
        ("--descar 0.1,0.2,16,4", "HIGH,LOW with HIGH >= LOW > 0"),
        ("--descar 1,2", "it must be HIGH,LOW,LENGTH,WIDTH"),
        ("--level rows", "it must be rows or columns"),
        ("--level rows:polynomial:9", "the degree is \"9\"; it must be 0 to 8"),
        ("--detrend polynomial:9", "the degree is \"9\"; it must be 0 to 8"),
        ("--detrend bow", "it must be none, plane, slope, quadratic, cubic or polynomial:D"),
        ("--filter 2um", "is no part of a filter"),
        (
            "--filter s:0.9um",
            "--filter: the nesting index is 0.9um = 900; it must be between 1000, two spacings, and 24000",
        ),
        ("--filter l:30um", "--filter: the nesting index is 30um = 30000"),
        ("--filter s:4um,l:3um", "s must be smaller"),
        ("--filter s:4um,s:5um", "is given twice"),
        ("--filter s:nan", "must be finite"),
        ("--filter s:4um,kind=median", "it must be gaussian, robust or spline"),
        ("--filter s:4um,kind=spline", "the spline is that of a surface; it must be a profile"),
        ("--filter s:4um,kind=robust,edges=periodic", "regression, which can leave points out"),
        ("--filter kind=robust", "it has no nesting index"),
        ("--resample 65", "the number of points along a side is 65; it must be 2 to 64; --refine"),
        ("--resample 8 --resample-spacing 4um", "cannot be used with"),
        ("--resample-spacing 0", "--resample-spacing is 0; it must be positive and finite"),
    ] {
        let message = refusal(folder.path(), &format!("surface --surface scan.txt {flags}"));
        assert!(message.contains(text), "{flags}: {message}");
    }
    for option in ["--crop 0:1", "--level rows:mean", "--despike", "--invalid below:0", "--resample 8"] {
        let message = refusal(folder.path(), &format!("contact --n 32 --p-star 0.1 {option}"));
        assert!(message.contains("it must be left out without --surface"), "{option}: {message}");
    }
    let message = refusal(folder.path(), "surface --n 64 --filter s:2um");
    assert!(message.contains("--unit"), "{message}");
}
