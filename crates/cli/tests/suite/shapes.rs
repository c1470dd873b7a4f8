//! `--shape` from end to end: classical contacts against their closed forms, files that `check` accepts, bad input.

use std::f64::consts::PI;
use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use serde_json::Value;

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &format!("{flags} --json -q").split_whitespace().collect::<Vec<_>>())
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

/// Checks that a number is near a closed form; `allowed` is the grid error with some room.
fn near(what: &str, found: f64, expected: f64, allowed: f64) {
    assert!((found / expected - 1.0).abs() < allowed, "{what}: {found} is not {expected}");
}

/// Returns the contact radius in a patch of this side, with the staircase of the rim taken out.
fn radius(load: &Value, side: f64) -> f64 {
    (number(load, "area_fraction_corrected") * side * side / PI).sqrt()
}

#[test]
fn a_sphere_has_the_radius_and_the_approach_of_hertz() {
    let folder = tempfile::tempdir().unwrap();
    let ball = "contact --size 0.2mm --n 64 --young 70GPa --poisson 0.3 --boundary free --force 1N";
    // m and Pa; lengths of the result are mm.
    let e_star = 70e9_f64 / 0.91;
    let a = (0.75 * 10e-3 / e_star).cbrt() * 1e3;
    for shape in ["sphere:R=10mm", "paraboloid:R=10mm"] {
        let report = run(folder.path(), &format!("{ball} --shape {shape}"));
        let load = &report["loads"][0];
        near("radius", radius(load, 0.2), a, 0.015);
        near("approach", number(load, "approach"), a * a / 10.0, 5e-3);
        near("largest pressure", number(load, "max_pressure"), 1.5 / (PI * (a * 1e-3).powi(2)), 0.01);
        assert_eq!(report["unit"], "mm");
    }
}

#[test]
fn a_cone_has_the_force_and_the_radius_of_sneddon() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --shape cone:slope=0.1 --n 64 --e-star 1 --boundary free --approach 0.04";
    let load = &run(folder.path(), flags)["loads"][0];
    near("force", number(load, "force"), 2.0 * 0.04_f64.powi(2) / (PI * 0.1), 0.02);
    near("radius", radius(load, 1.0), 2.0 * 0.04 / (PI * 0.1), 0.02);
}

#[test]
fn a_flat_punch_has_the_force_of_boussinesq() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --shape flat-punch:a=0.25,depth=0.002 --n 64 --e-star 1 --boundary free --approach 0.001";
    let load = &run(folder.path(), flags)["loads"][0];
    near("force", number(load, "force"), 2.0 * 0.25 * 0.001, 0.03);
}

#[test]
fn a_wave_has_the_width_of_westergaard() {
    let folder = tempfile::tempdir().unwrap();
    // Full contact at p = π E* A/λ; below it p/p_full = sin²(π a/λ) for strips of width 2 a.
    let full: f64 = PI * 0.01;
    for (dim, width) in [("--dim 2 --n 512", 0.5), ("--n 512,2 --size 1,0.00390625", 0.25)] {
        let pressure = full * (0.5 * PI * width).sin().powi(2);
        let flags = format!("contact --shape wave:A=0.01 {dim} --e-star 1 --pressure {pressure}");
        let load = &run(folder.path(), &flags)["loads"][0];
        // A point more or less.
        near("width", number(load, "area_fraction"), width, 0.01);
    }
}

#[test]
fn a_cylinder_has_the_width_of_hertz() {
    let folder = tempfile::tempdir().unwrap();
    // Half of the width √(4 P R/(π E*)) under a force per length P = p L.
    // a = 0.05.
    let pressure = 0.05_f64.powi(2) * PI / 4.0;
    for shape in ["cylinder:R=1", "paraboloid:R=1"] {
        let flags = format!("contact --shape {shape} --dim 2 --n 512 --e-star 1 --boundary free --pressure {pressure}");
        let load = &run(folder.path(), &flags)["loads"][0];
        // A point more or less.
        near("half width", 0.5 * number(load, "area_fraction"), 0.05, 0.02);
    }
}

#[test]
fn check_makes_the_shape_again() {
    let folder = tempfile::tempdir().unwrap();
    let lines = [
        "contact --shape sphere:R=10mm --size 0.2mm --n 16 --young 70GPa --boundary free --force 1N --out c.h5",
        "contact --shape sphere:R=2 --n 16 --hurst 0.8 --rms-height 1e-4 --eps-f-inv 4 --p-star 0.1 --out c.h5",
        "contact --shape cone:slope=0.1 --n 16 --boundary free --p-star 0.1 --grid-error refine --out c.h5",
        "path --shape wave:A=0.01 --n 16 --p-star 0.1,0.2 --steps 2 --out c.h5",
        "contact --shape ellipsoid:a=1,b=2,c=1 --n 16 --p-star 0.1 --out c.h5",
    ];
    for line in lines {
        run(folder.path(), line);
        let output = gfmd(folder.path(), &["check", "c.h5"]);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stdout));
        let config = Reader::open(folder.path().join("c.h5")).unwrap().text("/", "config").unwrap();
        assert!(config.contains("shape = \""), "{config}");
    }
    // A smooth shape has no spectrum, a rough one has.
    let about = |flags: &str| run(folder.path(), &format!("surface --shape sphere:R=2 --n 32 {flags}"));
    let [smooth, rough] = [about(""), about("--rms-height 0.005 --eps-f-inv 4 --seed 3")];
    assert_eq!(smooth["source"], "smooth surface, sphere:R=2.0");
    let words = "sphere:R=2.0 with roughness of a generated surface, method psd, Hurst exponent 0.8, seed 3";
    assert_eq!(rough["source"], words);
    assert!(number(&rough, "rms_curvature_inside") > 2.0 * number(&smooth, "rms_curvature_inside"));
    near("curvature", number(&smooth, "rms_curvature_inside"), 0.5, 0.1);
}

#[test]
fn a_table_with_a_shape_continues() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --shape sphere:R=2 --n 16 --p-star 0.1,0.2 --resume --out c.h5";
    let [first, again] = [run(folder.path(), flags), run(folder.path(), flags)];
    assert_eq!(first["loads"][1]["approach"], again["loads"][1]["approach"]);
}

#[test]
fn unusable_shapes_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let contact = |flags: &str, words: &[&str]| {
        let flags = format!("contact --n 16 --p-star 0.1 {flags}");
        let output = gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{flags}: {text}");
        for word in words {
            assert!(text.contains(word), "{flags}: no {word:?} in {text}");
        }
    };
    contact("--shape torus:R=1", &["--shape", "\"torus\"", "sphere, paraboloid"]);
    contact("--shape sphere:radius=1", &["--shape", "\"radius=1\"", "a key of R"]);
    contact("--shape sphere", &["--shape", "sphere has no R"]);
    contact("--shape sphere:R=-1", &["--shape", "-1", "positive"]);
    contact("--shape sphere:R=0.01", &["--shape", "R of sphere is 0.01", "0.0625, the grid spacing"]);
    contact("--shape sphere:R=2mm", &["--shape", "2mm", "--unit"]);
    contact("--shape sphere:R=2mm --size 1", &["--shape", "2mm", "--unit"]);
    contact("--shape sphere:R=2N --size 1mm --e-star 1", &["--shape", "2N", "length"]);
    contact("--shape cone:slope=1mm --size 1mm --e-star 1", &["--shape", "1mm"]);
    contact("--shape wave:A=0.1,Lx=0.3", &["--shape", "Lx of wave is 0.3", "side 1 of the periodic cell"]);
    contact("--shape sphere:R=1 --dim 2", &["--shape", "sphere", "cylinder"]);
    contact("--shape sphere:R=1 --eps-f-inv 4", &["--eps-f-inv", "--shape sphere", "--hurst"]);
    contact("--shape sphere:R=1 --seed 2", &["--seed", "--shape sphere", "--hurst"]);
    contact("--shape sphere:R=1 --lower-seed 2 --height 1", &["--lower-seed", "--shape"]);
    let output = gfmd(folder.path(), &["contact", "--surface", "h.npy", "--shape", "sphere:R=1", "--p-star", "0.1"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && text.contains("--surface") && text.contains("--shape"), "{text}");
    let output = gfmd(folder.path(), &["kappa-sweep", "--shape", "sphere:R=1"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && text.contains("--shape"), "{text}");
    // A wave need not fit into a patch.
    run(folder.path(), "contact --n 16 --p-star 0.1 --shape wave:A=0.01,Lx=0.3 --boundary free");
}
