//! Unusable input: exit status 2 (1 if the disk refuses), one line that names the cause, nothing written.

use std::path::Path;

use crate::common::gfmd;
use ndarray::{Array2, Array3};

/// Runs the program and checks its status, that stderr is one line with all `words`, that stdout is empty and that no
/// file appeared.
fn refused(folder: &Path, arguments: &str, status: i32, words: &[&str]) {
    let before = std::fs::read_dir(folder).unwrap().count();
    let output = gfmd(folder, &arguments.split_whitespace().collect::<Vec<_>>());
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments}: {text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{arguments}: {text}");
    for word in words {
        assert!(text.contains(word), "{arguments}: no {word:?} in {text}");
    }
    assert!(output.stdout.is_empty(), "{arguments}");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), before, "{arguments} wrote something");
}

#[test]
fn flags_out_of_range() {
    let folder = tempfile::tempdir().unwrap();
    let contact = |rest: &str, words: &[&str]| refused(folder.path(), &format!("contact --n 16 {rest}"), 2, words);
    let small = "--eps-f-inv 4 --p-star 0.1";
    contact(&format!("{small} --poisson 0.6"), &["--poisson", "0.6", "0.5"]);
    contact(&format!("{small} --poisson -1"), &["--poisson", "-1"]);
    contact(&format!("{small} --young 0"), &["--young", "0"]);
    contact(&format!("{small} --e-star -2"), &["--e-star", "-2"]);
    contact(&format!("{small} --height -0.5"), &["--height", "-0.5"]);
    contact(&format!("{small} --height tall"), &["--height", "tall", "inf"]);
    contact(&format!("{small} --size 0"), &["--size", "0"]);
    contact(&format!("{small} --tolerance 0"), &["--tolerance", "0"]);
    contact(&format!("{small} --hurst 1.5"), &["--hurst", "1.5"]);
    contact(&format!("{small} --rms-gradient 0"), &["--rms-gradient", "0"]);
    contact(&format!("{small} --solver newton"), &["--solver", "newton", "cg"]);
    contact(&format!("{small} --law glue"), &["--law", "glue", "hard-wall"]);
    contact(&format!("{small} --out no/such/folder/c.h5"), &["--out", "no/such/folder"]);
    contact("--eps-f-inv 4", &["--pressure", "--p-star", "--approach"]);
    contact(&format!("{small} --components both"), &["--components", "both", "held"]);
    for (more, words) in [
        ("all --dim 2 --boundary free", ["--dim", "--components all"]),
        ("held --boundary free", ["held", "--boundary free"]),
        ("held --second-body 1,0.3", ["held", "--second-body"]),
        ("all --out x.h5 --fields displacement_x,plastic_depth", ["--fields", "plastic_depth"]),
        ("all --solver verlet-critical --damping 1,1,1", ["--damping", "compressible slab"]),
    ] {
        contact(&format!("{small} --components {more}"), &words);
    }
    contact(&format!("{small} --fields gap"), &["--out"]);
    for of_scans in ["--flip", "--detrend plane", "--periodise mirror", "--exclude above:0", "--level rows:median"] {
        let option = of_scans.split_once(' ').map_or(of_scans, |(option, _)| option);
        contact(&format!("{small} {of_scans}"), &[option, "left out without --surface"]);
    }
    let written = format!("{small} --out x.h5 --fields");
    contact(&format!("{written} displacement_x"), &["--fields", "displacement_x", "--components all"]);
    contact(&format!("{written} displacement_y --dim 2 --components all"), &["--fields", "displacement_y"]);
    contact(&format!("{small} --dt 0.5"), &["--dt", "verlet-critical"]);
    contact(&format!("{small} --solver fire --dt 0.5"), &["--dt", "verlet-critical"]);
    contact(&format!("{small} --solver verlet-critical --dt 1.5"), &["--dt", "below 1"]);
    contact(&format!("{small} --solver verlet-modes --damping 2"), &["--damping", "verlet-critical"]);
    contact(&format!("{small} --solver verlet-critical --damping 1,1"), &["--damping", "three"]);
    contact(&format!("{small} --solver verlet-critical --damping 1,1,1"), &["--damping", "--components all"]);
    contact(&format!("{small} --solver verlet-critical --damping 1e4"), &["--damping", "stability"]);
    contact(&format!("{small},0.2 --history"), &["--history", "2 loads"]);
    contact(&format!("{small} --history --resume --out c.h5"), &["--history", "--resume"]);
    contact(&format!("{small} --history-point 0,0,z"), &["--history", "required"]);
    contact(&format!("{small} --history --history-mode 1,0,x"), &["--history-mode", "a component that moves: z"]);
    contact("--eps-f-inv 4 --pressure 0", &["--pressure", "0", "positive"]);
    contact("--eps-f-inv 4 --pressure 0.1,-0.1", &["--pressure", "-0.1"]);
    contact("--eps-f-inv 4 --p-star nan", &["--p-star", "NaN"]);
    contact("--eps-f-inv 4 --approach -1", &["--approach", "-1"]);
    contact("--eps-f-inv 4 --pressure 1 --p-star 1", &["--pressure", "--p-star"]);
    contact("--eps-f-inv 64 --p-star 0.1", &["--n", "16", "wavelength"]);
    refused(folder.path(), "contact --n 3000000 --p-star 0.1", 2, &["3000000", "GiB"]);
    // The number of bytes for 2³¹ points a side exceeds 64 bits.
    for line in ["contact --p-star 0.1", "path --approach 0.1", "surface", "punch"] {
        refused(folder.path(), &format!("{line} --n 2147483648"), 2, &["2147483648"]);
    }
    refused(folder.path(), "contact --n 16 --eps-f-inv 4 --approach 1e9", 2, &["--approach", "1000000000"]);
    refused(folder.path(), "green --qx 1 --poisson 0.6", 2, &["--poisson", "0.6"]);
    refused(folder.path(), "green --qx 1 --height 0", 2, &["--height", "0"]);
    refused(folder.path(), "surface --n 1", 2, &["--n"]);
    refused(folder.path(), "press --n 16", 2, &["press"]);
}

#[test]
fn surfaces_that_cannot_be_used() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, heights: &Array2<f64>| ndarray_npy::write_npy(folder.path().join(name), heights).unwrap();
    let wave = Array2::from_shape_fn((8, 8), |(i, j)| (i as f64).sin() * (j as f64).cos());
    let mut hole = wave.clone();
    hole[[3, 5]] = f64::NAN;
    save("hole.npy", &hole);
    save("flat.npy", &Array2::zeros((8, 8)));
    save("wave.npy", &wave);
    ndarray_npy::write_npy(folder.path().join("cube.npy"), &Array3::<f64>::zeros((2, 2, 2))).unwrap();
    std::fs::write(folder.path().join("words.txt"), "these are\nno heights\n").unwrap();
    std::fs::write(folder.path().join("ragged.txt"), "1 2 3\n4 5\n").unwrap();
    std::fs::write(folder.path().join("one.txt"), "5\n").unwrap();
    std::fs::write(folder.path().join("broken.npy"), "not an array").unwrap();
    std::fs::write(folder.path().join("broken.h5"), "not a file").unwrap();
    let press = |file: &str, words: &[&str]| {
        refused(folder.path(), &format!("contact --surface {file} --p-star 0.1"), 2, words);
    };
    press("hole.npy", &["hole.npy", "3", "5"]);
    press("flat.npy", &["flat.npy"]);
    press("cube.npy", &["cube.npy"]);
    press("words.txt", &["words.txt"]);
    press("one.txt", &["one.txt", "1 x 1 points; it must have at least 2"]);
    refused(folder.path(), "surface --surface one.txt", 2, &["one.txt", "1 x 1 points; it must have at least 2"]);
    press("ragged.txt", &["ragged.txt"]);
    press("broken.npy", &["broken.npy"]);
    press("broken.h5:/height", &["broken.h5"]);
    press("missing.npy", &["missing.npy"]);
    press("wave.npy --hurst 0.5", &["--surface", "--hurst"]);
}

#[test]
fn punches_that_cannot_be_pressed() {
    let folder = tempfile::tempdir().unwrap();
    let punch = |rest: &str, words: &[&str]| refused(folder.path(), &format!("punch --n 16 {rest}"), 2, words);
    punch("--punch-fraction 1.5", &["--punch-fraction", "1.5", "above 0 and below 1"]);
    punch("--punch-fraction 1", &["--punch-fraction", "is 1; it must be"]);
    punch("--punch-fraction -0.25", &["--punch-fraction", "-0.25"]);
    refused(folder.path(), "punch --n 15 --punch-fraction 0.05", 2, &["--punch-fraction", "no point of 15", "0.05"]);
    refused(folder.path(), "punch --n 1", 2, &["--n", "at least 2"]);
    refused(folder.path(), "punch --n 1000000000", 2, &["1000000000", "GiB"]);
    // The message names the flag that requests the grid.
    refused(folder.path(), "punch --n 2000000 --refine 2", 2, &["--n:", "2000000 x 2000000", "GiB"]);
    refused(folder.path(), "punch --n 1024 --refine 8", 2, &["--refine:", "131072 x 131072", "GiB"]);
    punch("--depth 0", &["--depth", "positive", "0"]);
    punch("--depth -0.005", &["--depth", "-0.005"]);
    punch("--depth nan", &["--depth", "NaN"]);
    punch("--size 0", &["--size", "0"]);
    punch("--height 0", &["--height", "0"]);
    punch("--young -70", &["--young", "-70"]);
    punch("--poisson 0.51", &["--poisson", "0.51", "0.5"]);
    punch("--dim 4", &["--dim", "4"]);
    punch("--refine 0", &["--refine", "0"]);
    punch("--tolerance 1", &["--tolerance", "1e-15"]);
    punch("--solver newton", &["--solver", "newton", "fire"]);
    punch("--contact glued", &["--contact", "glued", "sticking"]);
    punch("--nodes some", &["--nodes", "some", "inclusive"]);
    punch("--out no/such/folder/p.h5", &["--out", "no/such/folder"]);
}

#[test]
fn references_of_a_punch_that_cannot_be_compared() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, shape: [usize; 3], value: f64| {
        ndarray_npy::write_npy(folder.path().join(name), &Array3::from_elem(shape, value)).unwrap();
    };
    save("other.npy", [12, 12, 3], 0.0);
    save("oblong.npy", [16, 8, 3], 0.0);
    save("plane.npy", [16, 16, 2], 0.0);
    save("hole.npy", [16, 16, 3], f64::NAN);
    ndarray_npy::write_npy(folder.path().join("flat.npy"), &Array2::<f64>::zeros((16, 16))).unwrap();
    std::fs::write(folder.path().join("broken.npy"), "not an array").unwrap();
    std::fs::write(folder.path().join("broken.h5"), "not a file").unwrap();
    let punch = |flags: &str, words: &[&str]| {
        refused(folder.path(), &format!("punch --n 16 --compare {flags}"), 2, &[&["--compare"], words].concat());
    };
    punch("missing.npy", &["missing.npy", "No such file"]);
    punch("missing.h5", &["missing.h5", "No such file"]);
    punch("missing.txt", &["missing.txt", ".npy"]);
    punch("broken.npy", &["broken.npy"]);
    punch("broken.h5", &["broken.h5"]);
    punch("other.npy", &["other.npy", "[12, 12, 3]", "divisor", "16"]);
    punch("oblong.npy", &["[16, 8, 3]", "[m, m, 3]"]);
    punch("plane.npy", &["[16, 16, 2]", "[m, m, 3]"]);
    punch("flat.npy", &["[16, 16]"]);
    punch("flat.npy --dim 2", &["[16, 16]", "[m, 2]"]);
    punch("hole.npy", &["hole.npy", "NaN"]);
}

#[test]
fn sweeps_that_cannot_be_computed() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = |toml: &str, words: &[&str]| {
        std::fs::write(folder.path().join("sweep.toml"), toml).unwrap();
        refused(folder.path(), "kappa-sweep --config sweep.toml --dry-run", 2, words);
    };
    sweep("[surface]\nhurst = [1.5]", &["surface.hurst", "1.5"]);
    sweep("[surface]\ndim = 4", &["surface.dim", "4"]);
    sweep("[surface]\nroughness = 1", &["sweep.toml", "line 2", "roughness"]);
    sweep("[surface\n", &["sweep.toml", "line 1"]);
    sweep("[body]\npoisson = 0.6", &["body", "0.6"]);
    sweep("[body]\nheight = -1.0", &["body", "-1"]);
    sweep("[body]\nheight = \"high\"", &["body.height", "high"]);
    sweep("[loads]\np_star = [0.02, 0.01]", &["loads.p_star"]);
    sweep("[loads]\np_star = [-0.02]", &["loads.p_star"]);
    sweep("[fit]\np_star = 0.3", &["fit.p_star", "0.3"]);
    sweep("[fit]\nresamples = 2", &["fit.resamples", "from 20"]);
    sweep("[fit]\nalpha_c = \"loose\"", &["fit.alpha_c", "loose"]);
    sweep("[points]\neps_c_inv = [1.0]", &["points", "eps_c", "1"]);
    sweep("[points]\neps_f_inv = [1048576.0]", &["GiB"]);
    sweep("[statistics]\nrealisations = 0", &["statistics.realisations", "0"]);
    refused(folder.path(), "kappa-sweep --config missing.toml", 2, &["missing.toml"]);
    refused(folder.path(), "kappa-sweep --preset huge", 2, &["--preset", "huge", "smoke"]);
    refused(folder.path(), "kappa-sweep --preset smoke --out no/folder/s.h5", 2, &["--out", "no/folder"]);
}

#[test]
fn not_converged_is_an_error_that_keeps_what_was_reached() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --n 64 --eps-f-inv 16 --p-star 0.1,0.2 --max-iterations 3 --json --out c.h5";
    let output = gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("did not converge") && text.contains("c.h5"), "{text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let load = &report["loads"][0];
    assert_eq!(load["converged"], false);
    assert!(load["residual"]["complementarity"].as_f64().unwrap() > 1e-8);
    let file = gfmd_files::Reader::open(folder.path().join("c.h5")).unwrap();
    assert_eq!(file.values::<f64>("/loads/converged").unwrap()[0], 0.0);
    assert!(file.values::<f64>("/loads/kappa").unwrap()[1].is_nan());
}

/// Figures that cannot be written cost no result: it is printed, and the status is 1.
#[test]
fn results_are_printed_without_their_figures() {
    let folder = tempfile::tempdir().unwrap();
    for figure in ["map", "friction", "u_x"] {
        std::fs::create_dir(folder.path().join(format!("taken-{figure}.svg"))).unwrap();
    }
    for (command, key) in [
        ("contact --n 16 --p-star 0.1", "loads"),
        ("path --n 16 --p-star 0.1 --steps 1", "steps"),
        ("slide --n 16 --p-star 0.1 --prony 1:0.3 --velocity 1", "states"),
        ("punch --n 32", "mean_pressure"),
    ] {
        let line = format!("{command} --plots taken --json");
        let output = gfmd(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
        let (printed, said) = (output.stdout.as_slice(), String::from_utf8_lossy(&output.stderr));
        assert_eq!(output.status.code(), Some(1), "{command}: {said}");
        assert!(said.contains("taken-"), "{command}: {said}");
        let printed: serde_json::Value = serde_json::from_slice(printed).unwrap();
        assert!(!printed[key].is_null(), "{command}: {printed}");
    }
}
