//! `body` from end to end: a displaced surface in, fields inside out.

use std::path::{Path, PathBuf};

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::{Array2, Array3};

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn punch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/reference/punch3d_sticking_zm1_nu033").join(name)
}

#[test]
fn a_slice_below_the_punch_is_that_of_the_independent_solution() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(punch("discrete_strict_u_n128.npy"), folder.path().join("u.npy")).unwrap();
    let flags = "body --surface u.npy --size 1.27 --young 70 --poisson 0.33 --height 1.27 --levels 9 --slice y=0.636 \
                 --out slice.h5 --plots punch --json";
    let report = json(folder.path(), &words(flags));
    assert_eq!((&report["slice"], report["levels"].as_array().unwrap().len()), (&"y=0.635".into(), 9));
    assert_eq!(report["levels"][8]["max_displacement"], 0.0);
    assert_eq!(report["plots"].as_array().unwrap().len(), 20);
    assert!(folder.path().join("punch-mises.svg").exists() && folder.path().join("punch-sxz.png").exists());

    let file = Reader::open(folder.path().join("slice.h5")).unwrap();
    assert_eq!(file.shape("/fields/displacement").unwrap(), [9, 128, 3]);
    assert_eq!(file.shape("/fields/von_mises").unwrap(), [9, 128]);
    assert_eq!(file.texts("/fields/tensor").unwrap(), ["xx", "yy", "zz", "yz", "xz", "xy"]);
    assert!(file.text("/", "config").unwrap().contains("height = 1.27"));
    let z: Vec<f64> = file.values("/fields/z").unwrap();
    assert_eq!((z[0], z[8]), (1.27, 0.0));
    for (name, tolerance) in [("displacement", 1e-8 * 0.005), ("stress", 2e-7 * 3.0)] {
        let short = if name == "stress" { "stress" } else { "u" };
        let expected: Array3<f64> =
            ndarray_npy::read_npy(punch(&format!("discrete_strict_slice_{short}_coarse.npy"))).unwrap();
        let found: Vec<f64> = file.values(&format!("/fields/{name}")).unwrap();
        let width = expected.dim().2;
        for ((i, k, c), expected) in expected.indexed_iter().filter(|((_, k, _), _)| *k < 8) {
            let found = found[((8 - k) * 128 + 2 * i) * width + c];
            assert!((found - expected).abs() < tolerance, "{name} {i} {k} {c}: {found} {expected}");
        }
    }
}

#[test]
fn a_contact_says_its_body_and_its_pressure_is_met_again() {
    let folder = tempfile::tempdir().unwrap();
    let contact =
        "contact --n 32 --eps-f-inv 8 --p-star 0.05,0.2 --height 0.3 --young 2 --poisson 0.4 --out c.h5 --json";
    json(folder.path(), &words(contact));
    let report = json(folder.path(), &words("body --surface c.h5 --load 0 --depths 0,0.1,0.3 --out b.h5 --json"));
    let (contact, body) = (Reader::open(folder.path().join("c.h5")), Reader::open(folder.path().join("b.h5")));
    let (contact, body) = (contact.unwrap(), body.unwrap());
    let pressure: Vec<f64> = contact.slab("/fields/pressure", 0).unwrap();
    let stress: Vec<f64> = body.slab("/fields/stress", 0).unwrap();
    // The scalar response keeps G_zz(|q|) along Nyquist directions, unlike three components, see theory.md.
    let largest = pressure.iter().fold(0.0, |largest: f64, p| largest.max(*p));
    let error = pressure.iter().zip(stress.chunks_exact(6)).map(|(p, stress)| (p + stress[2]).abs());
    assert!(error.fold(0.0, f64::max) < 0.02 * largest);
    let mean: f64 = stress.chunks_exact(6).map(|stress| stress[2]).sum::<f64>() / 1024.0;
    assert!((mean + pressure.iter().sum::<f64>() / 1024.0).abs() < 1e-12 * largest);
    // The default is the last load, which has a higher pressure.
    let last = json(
        folder.path(),
        &words("body --surface c.h5 --depths 0 --quantities displacement,displacement --out u.h5 --json"),
    );
    let depth = |report: &serde_json::Value| report["levels"][0]["max_displacement"].as_f64().unwrap();
    assert!(depth(&last) > depth(&report));
    assert!(last["levels"][0]["max_von_mises"].is_null());
}

#[test]
fn below_a_punch_the_fields_are_those_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    json(folder.path(), &words("punch --n 32 --height 0.8 --poisson 0.4 --out p.h5 --json"));
    json(folder.path(), &words("body --surface p.h5 --depths 0,0.8 --out b.h5 --json"));
    let (punch, body) = (Reader::open(folder.path().join("p.h5")), Reader::open(folder.path().join("b.h5")));
    let (punch, body) = (punch.unwrap(), body.unwrap());
    let displacement: Vec<f64> = punch.values("/fields/displacement").unwrap();
    let traction: Vec<f64> = punch.values("/fields/traction").unwrap();
    let [top, bottom] = [0, 1].map(|level| body.slab::<f64>("/fields/displacement", level).unwrap());
    assert!(top.iter().zip(&displacement).all(|(found, u)| (found - u).abs() < 1e-14 * 0.005));
    assert!(bottom.iter().all(|u| *u == 0.0));
    let stress: Vec<f64> = body.slab("/fields/stress", 0).unwrap();
    let largest = traction.iter().fold(0.0, |largest: f64, t| largest.max(t.abs()));
    for (stress, traction) in stress.chunks_exact(6).zip(traction.chunks_exact(3)) {
        for (stress, traction) in [stress[4], stress[3], stress[2]].into_iter().zip(traction) {
            assert!((stress - traction).abs() < 1e-6 * largest, "{stress} {traction}");
        }
    }
}

#[test]
fn a_line_and_a_half_space_have_their_own_shapes_and_threads_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let profile = Array2::from_shape_fn((64, 2), |(i, c)| 0.01 * ((i + 7 * c) as f64 * 0.3).sin());
    ndarray_npy::write_npy(folder.path().join("line.npy"), &profile).unwrap();
    let run = |rest: &str| {
        let flags = format!(
            "body --surface line.npy --young 1 --poisson 0.5 --height inf --levels 5 --deepest 0.2 {rest} --json"
        );
        json(folder.path(), &words(&flags))
    };
    let one = run("--out line.h5 --threads 1");
    let three = run("--out line.vti --threads 3");
    assert_eq!(one["levels"], three["levels"]);
    let file = Reader::open(folder.path().join("line.h5")).unwrap();
    assert_eq!(file.shape("/fields/strain").unwrap(), [5, 64, 4]);
    assert_eq!(file.texts("/fields/component").unwrap(), ["x", "z"]);
    assert!(!file.contains("/fields/z"));
    let image = std::fs::read(folder.path().join("line.vti")).unwrap();
    assert!(String::from_utf8_lossy(&image[..400]).contains("WholeExtent=\"0 63 0 0 0 4\" Origin=\"0e0 0e0 -2e-1\""));
}

#[test]
fn waves_need_no_file_and_every_component_is_drawn_on_every_slice() {
    let folder = tempfile::tempdir().unwrap();
    let body = "--young 2 --poisson 0.33 --height 1";
    let wave = format!("body --wave 1,1,z,0.5 --wave 1,-1,z,0.5 --n 16 {body}");
    let run = |rest: &str| json(folder.path(), &words(&format!("{wave} {rest} --json")));
    let row = run("--levels 5 --slice x=0.0625 --draw uy,exx,exz,sxy --plots row --out row.h5");
    let names = row["plots"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(names[..2], ["row-uy.svg", "row-uy.png"]);
    assert_eq!(names.len(), 8);
    assert_eq!(row["surface"], "waves 1,1,z,0.5 + 1,-1,z,0.5");
    let level = run("--slice z=0.75 --plots level --out level.h5");
    assert_eq!((level["slice"].as_str(), level["plots"].as_array().unwrap().len()), (Some("z=0.75"), 34));
    let [row, level] = ["row.h5", "level.h5"].map(|name| Reader::open(folder.path().join(name)).unwrap());
    assert_eq!(row.shape("/fields/strain").unwrap(), [5, 16, 6]);
    assert_eq!(level.shape("/fields/strain").unwrap(), [1, 16, 16, 6]);
    // Both hold the row x = 1/16 at the height 3/4.
    let (row, level): (Vec<f64>, Vec<f64>) =
        (row.values("/fields/strain").unwrap(), level.values("/fields/strain").unwrap());
    assert_eq!(row[96..192], level[96..192]);
    // At the surface the wave is cos 2 pi x cos 2 pi y, and the strains along it vanish.
    run("--depths 0 --out top.h5");
    let top = Reader::open(folder.path().join("top.h5")).unwrap();
    let (u, strain): (Vec<f64>, Vec<f64>) =
        (top.values("/fields/displacement").unwrap(), top.values("/fields/strain").unwrap());
    let cos = |i: usize| (std::f64::consts::TAU * i as f64 / 16.0).cos();
    for (point, (u, strain)) in u.chunks_exact(3).zip(strain.chunks_exact(6)).enumerate() {
        assert!((u[2] - cos(point / 16) * cos(point % 16)).abs() < 1e-14 && u[0].abs().max(u[1].abs()) < 1e-14);
        assert!([strain[0], strain[1], strain[5]].into_iter().all(|strain| strain.abs() < 1e-13));
    }
    let check = json(folder.path(), &words("check row.h5 --json"));
    assert_eq!((&check["differing"], &check["input"]), (&0.into(), &serde_json::Value::Null));
}

#[test]
fn a_wave_along_x_is_that_of_a_line_and_a_comparison_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let body = "--young 1 --poisson 0.33 --height 1 --levels 9 --quantities displacement,stress";
    let run = |flags: &str| json(folder.path(), &words(&format!("body --wave 1,0,z,1 {body} {flags} --json")));
    run("--n 32,1 --out line.h5");
    // The file of the line as a displacement array on the plane, with y added.
    let line = Reader::open(folder.path().join("line.h5")).unwrap().values::<f64>("/fields/displacement").unwrap();
    let plane =
        Array3::from_shape_fn((9, 32, 3), |(k, i, c)| if c == 1 { 0.0 } else { line[(k * 32 + i) * 2 + c / 2] });
    ndarray_npy::write_npy(folder.path().join("plane.npy"), &plane).unwrap();
    let report = run("--n 16 --slice y=0.5 --compare plane.npy --plots both");
    let comparison = &report["comparison"];
    assert_eq!(comparison["compared_points"], serde_json::json!([16, 9]));
    let components = comparison["components"].as_array().unwrap();
    assert_eq!(components.iter().map(|c| c["name"].as_str().unwrap()).collect::<Vec<_>>(), ["ux", "uz"]);
    assert!(components.iter().all(|c| c["largest_difference"].as_f64().unwrap() < 1e-14), "{comparison}");
    assert!((components[1]["largest_reference"].as_f64().unwrap() - 1.0).abs() < 1e-14);
    let svg = std::fs::read_to_string(folder.path().join("both-uz.svg")).unwrap();
    assert_eq!(svg.matches("<image").count(), 3);
    // Another run, with more levels, fewer points and twice the wave height.
    let other =
        "body --wave 1,0,z,2 --n 8 --young 1 --poisson 0.33 --height 1 --levels 17 --slice y=0.5 --out other.h5";
    json(folder.path(), &words(&format!("{other} --json")));
    let report = run("--n 16 --slice y=0.5 --compare other.h5 --draw uz,sxz");
    let uz = &report["comparison"]["components"][0];
    assert_eq!(report["comparison"]["compared_points"], serde_json::json!([8, 9]));
    assert!((uz["largest_difference"].as_f64().unwrap() - 1.0).abs() < 1e-14, "{uz}");
    let shorter = format!("body --wave 1,0,z,1 --n 8 {body} --slice y=0.25 --compare other.h5");
    let output = gfmd(folder.path(), &words(&shorter));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the slice y=0.5; it must have the slice y=0.25"));
}

#[test]
fn unusable_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    ndarray_npy::write_npy(folder.path().join("u.npy"), &Array3::<f64>::zeros((4, 4, 3))).unwrap();
    ndarray_npy::write_npy(folder.path().join("flat.npy"), &Array2::<f64>::zeros((4, 4))).unwrap();
    ndarray_npy::write_npy(folder.path().join("empty.npy"), &Array3::<f64>::zeros((0, 4, 3))).unwrap();
    json(folder.path(), &words("contact --n 16 --eps-f-inv 4 --p-star 0.1 --out c.h5 --json"));
    let slab = "--young 1 --poisson 0.3 --height 0.5";
    for (flags, named) in [
        (format!("--surface none.npy {slab} --depths 0"), vec!["none.npy"]),
        (format!("--surface flat.npy {slab} --depths 0"), vec!["flat.npy", "[4, 4]", "[n, 2]"]),
        ("--surface u.npy --depths 0".into(), vec!["--young", "needed"]),
        (format!("--surface u.npy {slab} --load 1 --depths 0"), vec!["--load", "u.npy"]),
        (format!("--surface u.npy {slab} --depths 0,0.6"), vec!["--depths", "0.5", "0.6"]),
        (format!("--surface u.npy {slab} --levels 1"), vec!["--levels", "2", "1"]),
        (format!("--surface u.npy {slab} --levels 3 --deepest 1"), vec!["--deepest", "0.5", "1"]),
        (format!("--surface u.npy {slab} --levels 3 --slice w=1"), vec!["--slice", "y=", "w=1"]),
        (format!("--surface u.npy {slab} --levels 3 --slice z=0.1"), vec!["--slice", "--levels"]),
        (format!("--surface u.npy {slab} --slice z=0.6"), vec!["--slice", "0.5"]),
        (format!("--surface u.npy {slab} --slice z=0 --wave 1,1,z,1"), vec!["--surface", "--wave"]),
        (format!("--surface u.npy {slab} --slice z=0 --n 8"), vec!["--n", "--surface"]),
        (format!("--surface u.npy {slab} --levels 3 --draw ux,rx"), vec!["--draw", "rx"]),
        (format!("--surface u.npy {slab} --levels 3 --compare flat.npy"), vec!["--compare", "flat.npy", "[4, 4]", "9"]),
        (format!("--surface u.npy {slab} --levels 3 --compare c.h5"), vec!["--compare", "c.h5", "no result of body"]),
        (format!("--wave 1,1,z {slab} --depths 0"), vec!["--wave", "M,N,COMPONENT"]),
        (format!("--wave 4,0,z,1 --n 8 {slab} --depths 0"), vec!["--wave", "4,0,z,1.0", "below 4"]),
        (format!("--wave 1,0,y,1 --n 8,1 {slab} --depths 0"), vec!["--wave", "line"]),
        (format!("--wave 1,0,z,1 --n 8,1 {slab} --levels 3 --draw uy"), vec!["--draw", "uy"]),
        (format!("--wave 1,0,z,1 --n 1 {slab} --depths 0"), vec!["--n", "[1, 1]"]),
        ("--wave 1,0,z,1 --depths 0".into(), vec!["--young"]),
        (format!("--surface u.npy {slab} --levels 3 --slice y=1"), vec!["--slice", "1"]),
        (format!("--surface u.npy {slab} --depths 0,0.1 --out u.vti"), vec!["--out", "--levels"]),
        (format!("--surface u.npy {slab} --levels 3 --out u.txt"), vec!["--out", ".vti"]),
        (format!("--surface u.npy {slab}"), vec!["--depths", "--levels"]),
        (format!("--surface u.npy {slab} --depths 0,0.1 --deepest 0.2"), vec!["--depths", "--deepest"]),
        (format!("--surface u.npy {slab} --depths 0,0.1,0.3 --plots p"), vec!["--depths", "--plots"]),
        (format!("--surface u.npy {slab} --levels 3 --plots no/p"), vec!["--plots", "no folder no"]),
        (format!("--surface empty.npy {slab} --depths 0"), vec!["empty.npy", "[0, 4]"]),
        ("--surface c.h5 --levels 4".into(), vec!["--deepest", "half-space"]),
        ("--surface c.h5 --load 1 --depths 0".into(), vec!["--load", "1"]),
        ("--surface c.h5:/fields/nothing --depths 0".into(), vec!["nothing", "displacement_z"]),
    ] {
        let before = std::fs::read_dir(folder.path()).unwrap().count();
        let output = gfmd(folder.path(), &words(&format!("body {flags}")));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), text.trim_end().lines().count()), (Some(2), 1), "{flags}: {text}");
        assert!(named.iter().all(|word| text.contains(word)), "{flags}: {text}");
        assert!(output.stdout.is_empty() && std::fs::read_dir(folder.path()).unwrap().count() == before, "{flags}");
    }
}
