//! Figures and ParaView files of contacts and paths, from flags to files.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use serde_json::Value;

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &format!("{flags} --json").split_whitespace().collect::<Vec<_>>())
}

/// Returns the names of the figures of a prefix; each must exist in both formats.
fn figures(folder: &Path, report: &Value, prefix: &str) -> Vec<String> {
    let plots: Vec<&str> = report["plots"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(plots.iter().all(|plot| folder.join(plot).metadata().unwrap().len() > 1000), "{plots:?}");
    let names = plots.iter().filter_map(|plot| plot.strip_prefix(prefix)?.strip_prefix('-')?.strip_suffix(".svg"));
    let names: Vec<String> = names.map(Into::into).collect();
    assert_eq!(2 * names.len(), plots.len(), "{plots:?}");
    names
}

#[test]
fn each_kind_of_contact_has_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law = "--eps-f-inv 8 --law exponential --param gamma=2e-5,range=1.2e-3";
    let cases = [
        ("contact --n 32 --p-star 0.05", vec!["map", "gap", "section"]),
        ("contact --n 32 --p-star 0.02,0.05 --hardness 0.05", vec!["map", "gap", "section", "area"]),
        ("contact --n 64 --dim 2 --p-star 0.05", vec!["map", "section"]),
        ("contact --n 32 --p-star 0.05 --boundary free", vec!["map", "gap", "section"]),
        (&format!("contact --n 64 {law} --pressure 0.005"), vec!["map", "traction", "gap", "section"]),
        (
            "contact --n 32 --height 0.3 --poisson 0.3 --lower-seed 2 --p-star 0.05",
            vec!["map", "gap", "section", "lower-map", "lower-gap", "lower-section"],
        ),
        ("path --n 32 --p-star 0.01,0.2,0.01 --steps 2 --hardness 0.1", vec!["map", "gap", "section", "path"]),
        (&format!("path --n 64 {law} --pressure 0.005 --steps 2"), vec!["map", "traction", "gap", "section", "path"]),
    ];
    for (flags, expected) in cases {
        let report = run(folder, &format!("{flags} --plots p"));
        assert_eq!(figures(folder, &report, "p"), expected, "{flags}");
        let section = std::fs::read_to_string(folder.join("p-section.svg")).unwrap();
        for word in ["rigid surface", "elastic body", "contact"] {
            assert!(section.contains(word), "{flags}: {word}");
        }
        assert_eq!(section.contains("attraction"), flags.contains("--law"), "{flags}");
        assert_eq!(section.contains(">hardness<"), flags.contains("--hardness"), "{flags}");
    }
}

#[test]
fn the_page_has_the_figures_of_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law = "--eps-f-inv 8 --law exponential --param gamma=2e-5,range=1.2e-3";
    for (flags, expected) in [
        ("contact --n 32 --p-star 0.05 --hardness 0.1", &["gap", "section through both surfaces"][..]),
        (
            &format!("contact --n 64 {law} --pressure 0.005"),
            &["repulsion and attraction", "gap", "section through both surfaces"],
        ),
        ("contact --n 32 --p-star 0.05 --fields pressure", &[]),
        (
            &format!("path --n 64 {law} --pressure 0.005 --steps 2"),
            &["repulsion and attraction", "gap", "section through both surfaces"],
        ),
        (
            "contact --n 32 --height 0.3 --poisson 0.3 --lower-seed 2 --p-star 0.05",
            &[
                "gap",
                "section through both surfaces",
                "gap on the lower face",
                "section through both surfaces on the lower face",
            ],
        ),
    ] {
        run(folder, &format!("{flags} --out r.h5"));
        let report = run(folder, "report r.h5");
        let mut remarks = report["remarks"].as_array().unwrap().iter();
        assert!(remarks.all(|remark| remark.as_str().unwrap().starts_with("grid: ")), "{flags}: {report}");
        let page = std::fs::read_to_string(folder.join("r.html")).unwrap();
        for title in [
            "repulsion and attraction",
            "gap",
            "section through both surfaces",
            "gap on the lower face",
            "section through both surfaces on the lower face",
        ] {
            assert_eq!(
                page.contains(&format!("<title>{title}</title>")),
                expected.contains(&title),
                "{flags}: {title}"
            );
        }
    }
}

/// Returns the values of an array of a VTK file, at the offset named in its header.
fn array(bytes: &[u8], name: &str) -> Vec<f64> {
    let start = bytes.windows(2).position(|pair| pair == b"\n_").unwrap() + 2;
    let header = String::from_utf8_lossy(&bytes[..start]);
    let declared = header.split(&format!("Name=\"{name}\"")).nth(1).unwrap_or_else(|| panic!("{name}: {header}"));
    let offset: usize = declared.split("offset=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    let word = |place: usize| -> [u8; 8] { bytes[start + place..][..8].try_into().unwrap() };
    let length = u64::from_le_bytes(word(offset)) as usize;
    (0..length / 8).map(|k| f64::from_le_bytes(word(offset + 8 + 8 * k))).collect()
}

#[test]
fn the_surface_of_the_last_load_goes_to_a_file_of_vtk() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (nx, ny) = (32, 32);
    for (flags, names) in [
        ("--p-star 0.02,0.1", &["pressure", "displacement_z", "gap"][..]),
        ("--p-star 0.02,0.1 --hardness 0.1", &["pressure", "displacement_z", "gap", "plastic_depth"]),
        (
            "--p-star 0.05 --height 0.1 --poisson 0.3 --lower-seed 2",
            &["pressure", "gap", "lower_pressure", "lower_gap"],
        ),
        ("--p-star 0.05 --finite-slope", &["pressure", "gap", "displacement_x", "displacement_y"]),
    ] {
        let mut seen = Vec::new();
        for ending in ["vti", "vtp"] {
            let flags = format!("contact --n 32 --size 2 {flags} --out c.h5 --vtk c.{ending}");
            let report = run(folder, &flags);
            assert_eq!(report["vtk"], format!("c.{ending}"));
            let file = Reader::open(folder.join("c.h5")).unwrap();
            let last = report["loads"].as_array().unwrap().len() - 1;
            let bytes = std::fs::read(folder.join(format!("c.{ending}"))).unwrap();
            let stored = |path: &str| -> Vec<f64> {
                if path.starts_with("/surface") { file.values(path).unwrap() } else { file.slab(path, last).unwrap() }
            };
            // x varies fastest there, y in HDF5.
            let turned =
                |values: &[f64]| -> Vec<f64> { (0..nx * ny).map(|k| values[(k % nx) * ny + k / nx]).collect() };
            for name in names {
                assert_eq!(array(&bytes, name), turned(&stored(&format!("/fields/{name}"))), "{flags} {name}");
            }
            assert_eq!(array(&bytes, "height"), turned(&stored("/surface/height")), "{flags}");
            let contact = array(&bytes, "contact");
            assert_eq!(contact, array(&bytes, "pressure").iter().map(|p| f64::from(*p > 0.0)).collect::<Vec<_>>());
            let area = report["loads"][last]["area_fraction"].as_f64().unwrap();
            assert!((contact.iter().sum::<f64>() / (nx * ny) as f64 - area).abs() < 1e-12);
            if ending == "vtp" {
                let depth =
                    if names.contains(&"plastic_depth") { array(&bytes, "plastic_depth") } else { vec![0.0; nx * ny] };
                let level: Vec<f64> =
                    array(&bytes, "displacement_z").iter().zip(&depth).map(|(u, depth)| u - depth).collect();
                let points = array(&bytes, "Points");
                assert!(points.chunks_exact(3).zip(&level).all(|(point, level)| point[2] == *level));
                let moved = |axis: usize, name: &str, place: usize| {
                    let lateral = if names.contains(&name) { array(&bytes, name)[place] } else { 0.0 };
                    let undisplaced = if axis == 0 { place % nx } else { place / nx } as f64 * 2.0 / 32.0;
                    (points[3 * place + axis] - undisplaced - lateral).abs()
                };
                assert!(moved(0, "displacement_x", 37) < 1e-15 && moved(1, "displacement_y", 37) < 1e-15);
            }
            seen.push(array(&bytes, "pressure"));
        }
        assert_eq!(seen[0], seen[1]);
    }
    // A profile is a line; its rows have one point.
    run(folder, "contact --n 16 --dim 2 --p-star 0.05 --vtk line.vtp");
    assert_eq!(array(&std::fs::read(folder.join("line.vtp")).unwrap(), "Points").len(), 48);
}

#[test]
fn a_file_of_vtk_needs_an_ending_and_a_place() {
    let folder = tempfile::tempdir().unwrap();
    for (path, words) in
        [("c.vtk", [".vti", ".vtp"]), ("c", ["--vtk", "NAME.vti"]), ("no/c.vti", ["--vtk", "no/c.vti"])]
    {
        let output = gfmd(folder.path(), &["contact", "--n", "16", "--p-star", "0.05", "--vtk", path]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
