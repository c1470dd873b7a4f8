//! Two rough surfaces in contact, from end to end.

use std::path::Path;

use crate::common::{gfmd, json, numbers};
use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_surface::{SelfAffine, composite, composite_inside};
use ndarray::Array2;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn rough(seed: u64) -> (Array2<f64>, Grid) {
    let grid = Grid::square(32, 1.0).unwrap();
    let spectrum = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 1.0,
        shortest_wavelength: 0.125,
        ..SelfAffine::with_rms_gradient(0.1)
    };
    (spectrum.heights(&grid, seed).unwrap(), grid)
}

/// Creates a folder with two surfaces.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("a.npy", 1), ("b.npy", 2)] {
        ndarray_npy::write_npy(folder.path().join(name), &rough(seed).0).unwrap();
    }
    folder
}

fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    assert_eq!(output.status.code(), Some(2), "{flags}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn two_surfaces_touch_as_their_composite_does() {
    let folder = folder();
    let ((a, grid), (b, _)) = (rough(1), rough(2));
    let sum = composite(&a, &b, &grid, [0.25, -0.01]).unwrap();
    ndarray_npy::write_npy(folder.path().join("sum.npy"), &sum).unwrap();
    let load = "--pressure 0.003,0.01 --json";
    let pair = format!("contact --surface a.npy --second-surface b.npy --shift 0.25,-0.01 {load} --out pair.h5");
    let pair = json(folder.path(), &words(&pair));
    let one = json(folder.path(), &words(&format!("contact --surface sum.npy {load} --out one.h5")));
    assert_eq!(pair["loads"][1]["area_fraction"], one["loads"][1]["area_fraction"]);
    assert_eq!((&pair["second_surface"], &pair["shift"]), (&"b.npy".into(), &serde_json::json!([0.25, -0.01])));
    assert_eq!(pair["second_scan"]["n"], serde_json::json!([32, 32]));
    assert!(one.get("second_surface").is_none() && one.get("shift").is_none());
    let [pair, one] = ["pair.h5", "one.h5"].map(|name| numbers(&folder.path().join(name)));
    assert_eq!(pair, one);

    let file = Reader::open(folder.path().join("pair.h5")).unwrap();
    assert_eq!(file.text("/surface", "second_file").unwrap(), "b.npy");
    assert_eq!(file.number("/surface", "shift_y").unwrap(), -0.01);
    let config = file.text("/", "config").unwrap();
    assert!(config.contains("second_surface = \"b.npy\"") && config.contains("shift = [0.25, -0.01]"), "{config}");
}

#[test]
fn a_result_is_checked_and_repeated_without_its_surfaces() {
    let folder = folder();
    let run = "contact --surface a.npy --second-surface b.npy --shift=-0.3 --boundary periodic --p-star 0.05 \
               --out c.h5 --json";
    json(folder.path(), &words(run));
    let report = json(folder.path(), &words("check c.h5 --rerun --json"));
    assert_eq!((&report["differing"], &report["second_input"]["state"]), (&0.into(), &"unchanged".into()));
    // With a second surface, the generated one is taken from the file, too.
    json(folder.path(), &words("path --n 32 --second-surface b.npy --p-star 0.02,0.05 --steps 2 --out p.h5 --json"));
    std::fs::remove_file(folder.path().join("a.npy")).unwrap();
    std::fs::write(folder.path().join("b.npy"), b"another").unwrap();
    let path = gfmd(folder.path(), &words("check p.h5 --rerun --json"));
    let report: serde_json::Value = serde_json::from_slice(&path.stdout).unwrap();
    assert_eq!((path.status.code(), &report["second_input"]["state"]), (Some(1), &"changed".into()));
    assert_eq!(report["differing"], 1, "{report}");
    std::fs::remove_file(folder.path().join("b.npy")).unwrap();
    for name in ["c.h5", "p.h5"] {
        let report = json(folder.path(), &["check", name, "--rerun", "--json"]);
        assert_eq!((&report["differing"], &report["second_input"]["state"]), (&0.into(), &"missing".into()), "{name}");
    }
}

#[test]
fn surfaces_that_do_not_repeat_keep_the_part_in_common() {
    let folder = folder();
    let ((a, grid), (b, _)) = (rough(1), rough(2));
    let run = "contact --surface a.npy --second-surface b.npy --shift 0.25,-0.125 --boundary free --p-star 0.05 \
               --out c.h5 --json";
    let report = json(folder.path(), &words(run));
    assert_eq!((&report["n"], &report["size"]), (&serde_json::json!([24, 28]), &serde_json::json!([0.75, 0.875])));
    let (part, _) = composite_inside(&a, &b, &grid, [0.25, -0.125]).unwrap();
    let file = Reader::open(folder.path().join("c.h5")).unwrap();
    assert_eq!(file.values::<f64>("/surface/height").unwrap(), part.iter().copied().collect::<Vec<_>>());
    assert_eq!(json(folder.path(), &words("check c.h5 --rerun --json"))["differing"], 0);
}

#[test]
fn surfaces_that_do_not_fit_are_refused_by_name() {
    let folder = folder();
    ndarray_npy::write_npy(folder.path().join("small.npy"), &Array2::<f64>::zeros((16, 32))).unwrap();
    for (name, unit) in [("um.txt", "µm"), ("mm.txt", "mm")] {
        let rows: Vec<String> = (0..4).map(|j| format!("{j} 1 2 {}", 3 * j)).collect();
        let header = format!("# Width: 10 {unit}\n# Height: 10 {unit}\n# Value units: {unit}\n");
        std::fs::write(folder.path().join(name), header + &rows.join("\n")).unwrap();
    }
    for (flags, reported) in [
        ("--surface a.npy --second-surface small.npy", "--second-surface: small.npy has 16 x 32 points on 1 x 1"),
        ("--surface a.npy --shift 0.1", "--second-surface"),
        ("--surface a.npy --second-surface b.npy --shift nan", "--shift: the shift is [NaN, 0.0]"),
        (
            "--surface a.npy --second-surface b.npy --shift 0.01 --boundary free",
            "--shift: the shift is [0.32, 0.0] grid steps",
        ),
        ("--surface a.npy --second-surface b.npy --shift 0.97 --boundary free", "--shift: the shift is"),
        ("--surface a.npy --second-surface none.npy", "none.npy"),
        ("--surface um.txt --second-surface mm.txt", "--second-surface: the unit of mm.txt is mm; it must be µm"),
    ] {
        let message = refused(folder.path(), &format!("contact {flags} --p-star 0.05"));
        assert!(message.contains(reported), "{flags}: {message}");
    }
    assert!(refused(folder.path(), "kappa-sweep --second-surface b.npy").contains("--second-surface"));
}
