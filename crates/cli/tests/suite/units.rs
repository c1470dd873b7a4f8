//! Quantities with units, from end to end.

use std::path::Path;

use crate::common::{gfmd, json, numbers};
use gfmd_files::Reader;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_input::units::{Word, of_words};
use gfmd_problem::options::given::ArrayOption;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().map(|word| word.trim_matches('\'')).collect()
}

fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    assert_eq!(output.status.code(), Some(2), "{flags}");
    String::from_utf8(output.stderr).unwrap()
}

fn warned(report: &Value) -> Vec<&str> {
    let all = report["warnings"].as_array().unwrap().iter();
    all.filter(|warning| warning["code"] == "units").map(|warning| warning["text"].as_str().unwrap()).collect()
}

/// Creates a folder with a map of 24 x 24 points without a unit.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 24.0).cos();
    let heights = Array2::from_shape_fn((24, 24), |(i, j)| 0.01 * (wave(i) * wave(j) + 0.3 * wave(3 * i + j)));
    ndarray_npy::write_npy(folder.path().join("h.npy"), &heights).unwrap();
    ndarray_npy::write_npy(folder.path().join("hard.npy"), &Array2::from_elem((24, 24), 2e9)).unwrap();
    folder
}

/// Runs a command with bare numbers and with units. Their files must have the same numbers. Returns both reports.
fn same(folder: &Path, bare: &str, with_units: &str) -> [Value; 2] {
    let reports = [(bare, "bare.h5"), (with_units, "units.h5")]
        .map(|(flags, out)| json(folder, &words(&format!("{flags} --json -q --out {out}"))));
    let [bare, with_units] = ["bare.h5", "units.h5"].map(|name| numbers(&folder.join(name)));
    assert!(bare.len() > 20, "{:?}", bare.keys());
    assert_eq!(bare, with_units);
    reports
}

#[test]
fn a_quantity_is_the_number_of_the_problem_bit_for_bit() {
    let folder = folder();
    let surface = "contact --surface h.npy --size 10 --unit um --poisson 0.33";
    let reports = same(
        folder.path(),
        &format!("{surface} --young 70e9 --pressure 1e6:1e9:3"),
        &format!("{surface} --young=70GPa --pressure 1MPa:1GPa:3"),
    );
    for report in reports {
        assert_eq!(report["loads"][0]["mean_pressure"], 1e6);
        assert_eq!(report["loads"][2]["mean_pressure"], 1e9);
    }
    same(
        folder.path(),
        &format!(
            "{surface} --young 3e9 --height 2 --layer 1e9,0.3,5 --base half-space --base-young 2e8 --base-poisson 0.4 \
             --approach 0.003"
        ),
        &format!(
            "{surface} --young 3GPa --height 2um --layer 1GPa,0.3,5e3nm --base half-space --base-young 0.2GPa \
             --base-poisson 0.4 --approach 3nm"
        ),
    );
    same(
        folder.path(),
        &format!("{surface} --young 3e9 --boundary free --hardness 4e8 --pressure 2e7"),
        &format!("{surface} --young 3GPa --boundary free --hardness 400N/mm^2 --pressure 200bar"),
    );
    // An energy per area is a stress times a length: 0.05 J/m² are 5e4 Pa µm.
    let law = |law: &str| format!("{surface} --e-star 1e8 --law exponential --param {law} --coarse");
    let reports = same(
        folder.path(),
        &format!("{} --approach 0.001", law("gamma=5e4,range=0.5")),
        &format!("{} --approach 1nm", law("gamma=50mJ/m^2,range=500nm")),
    );
    assert_eq!(reports.map(|report| report["adhesion"]["work"].as_f64()), [Some(5e4); 2]);
    // Lengths in another unit than the file, and stresses in another unit than Pa.
    same(
        folder.path(),
        "contact --surface h.npy --size 10 --unit um --young 70 --stress-unit GPa --pressure 0.01",
        "contact --surface h.npy --size 1e4nm --unit um --young 70GPa --stress-unit GPa --pressure 10MPa",
    );
}

/// The heights that were read for their unit are the heights of the surface: without their file, they cannot be read
/// again.
#[test]
fn a_scan_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let scan = folder.path().join("scan.txt");
    let rows: Vec<String> = (0..8).map(|i| (0..8).map(|j| ((3 * i + j) % 5).to_string() + " ").collect()).collect();
    std::fs::write(
        &scan,
        "# Channel: Height\n# Width: 8 um\n# Height: 8 um\n# Value units: nm\n".to_owned() + &rows.join("\n"),
    )
    .unwrap();
    let name = scan.to_str().unwrap();
    let given = vec![Word::value("surface", "--surface=", name), Word::value("pressure", "--pressure=", "1MPa")];
    let (plain, map, _) = of_words("contact", given, gfmd_cli::kinds::kinds()).unwrap();
    assert_eq!(plain[1].text(), "--pressure=1000000.0");
    std::fs::remove_file(&scan).unwrap();
    let source = SourceArgs { surface: Some(ArrayOption::File(name.into())), ..SourceArgs::default() };
    let session = Session::silent().with_map(map);
    let surface = source.surface(&session).unwrap();
    assert_eq!((surface.grid.points(), surface.unit()), ([8, 8], "nm"));
    assert!(source.surface(&session).is_err(), "the heights are not kept");
}

#[test]
fn waypoints_of_a_path_have_units_and_its_file_is_checked_and_continued() {
    let folder = folder();
    let surface = "path --surface h.npy --size 10 --unit um --steps 3";
    same(
        folder.path(),
        &format!("{surface} --young 1e9 --friction 0.3 --pressure 1e7 --lateral 0,0.002"),
        &format!("{surface} --young 1GPa --friction 0.3 --pressure 10MPa --lateral 0,2nm"),
    );
    same(
        folder.path(),
        &format!("{surface} --young 1e9 --shear-strength 2e6 --pressure 1e7 --lateral 0,0.002,-0.001"),
        &format!("{surface} --young 1GPa --shear-strength 2MPa --pressure 10MPa --lateral 0,2nm,-1nm"),
    );
    let run = format!(
        "{surface} --young 1GPa --law morse --param gamma=0.05J/m^2 --param range=0.4um \
         --approach=-100nm,20nm,-50nm"
    );
    let whole = json(folder.path(), &words(&format!("{run} --json -q --out loop.h5")));
    assert_eq!((&whole["unit"], &whole["stress_unit"]), (&"µm".into(), &"Pa".into()));
    let file = Reader::open(folder.path().join("loop.h5")).unwrap();
    let config = file.text("/", "config").unwrap();
    for line in ["young = 1000000000.0", "stress_unit = \"Pa\"", "unit = \"µm\"", "approach = [-0.1, 0.02, -0.05]"] {
        assert!(config.contains(line), "{line}: {config}");
    }
    for (variable, unit) in [
        ("/fields/pressure", "Pa"),
        ("/fields/gap", "µm"),
        ("/path/mean_pressure", "Pa"),
        ("/path/dissipated", "Pa*µm"),
        ("/path/area_fraction", "1"),
    ] {
        assert_eq!(file.text(variable, "units").unwrap(), unit);
    }
    for flags in ["check loop.h5 --json", "check loop.h5 --rerun --json"] {
        assert_eq!(json(folder.path(), &words(flags))["differences"], serde_json::json!([]), "{flags}");
    }
    // A resumed run may give the same numbers in other units.
    let again = run.replace("gamma=0.05J/m^2", "gamma=5e4").replace("--young 1GPa", "--young 1e9 --stress-unit Pa");
    let resumed = json(folder.path(), &words(&format!("{again} --json -q --out loop.h5 --resume")));
    assert_eq!(whole["steps"][4]["mean_pressure"], resumed["steps"][4]["mean_pressure"]);
}

#[test]
fn a_contact_with_units_is_checked_and_its_body_read() {
    let folder = folder();
    let run = "contact --surface h.npy --size 10um --unit um --young 2GPa --poisson 0.4 --height 30um \
               --pressure 5MPa,20MPa --statistics --flow --conductor-height 1mm --hardness hard.npy --grid-error none \
               --out c.h5 --json";
    json(folder.path(), &words(run));
    for flags in ["check c.h5 --json", "check c.h5 --rerun --json"] {
        assert_eq!(json(folder.path(), &words(flags))["differences"], serde_json::json!([]), "{flags}");
    }
    let [bare, with_units] = ["0.5,2", "500nm,2um"]
        .map(|depths| json(folder.path(), &words(&format!("body --surface c.h5 --depths {depths} --json"))));
    assert_eq!(bare["levels"], with_units["levels"]);
    let page = gfmd(folder.path(), &words("report c.h5 --out c.html"));
    assert!(page.status.success(), "{}", String::from_utf8_lossy(&page.stderr));
    let page = std::fs::read_to_string(folder.path().join("c.html")).unwrap();
    assert!(page.contains("MPa") && page.contains("nm"), "units of the page");
}

#[test]
fn a_file_of_another_unit_is_converted_and_one_without_gets_its_unit() {
    let folder = folder();
    json(folder.path(), &words("surface --surface h.npy --size 10 --unit um --out h.x3p --json"));
    let run = |flags: &str| json(folder.path(), &words(&format!("contact {flags} --young 70GPa --p-star 0.05 --json")));
    let [metres, nanometres] = ["--surface h.x3p", "--surface h.x3p --unit nm"].map(run);
    assert_eq!((&metres["unit"], &nanometres["unit"]), (&"m".into(), &"nm".into()));
    let number = |report: &Value, key: &str| report[key].as_f64().unwrap();
    let ratio = number(&nanometres, "rms_height") / number(&metres, "rms_height");
    assert!((ratio / 1e9 - 1.0).abs() < 1e-12, "{ratio}");
    assert_eq!(nanometres["size"][0], 1e4);
    let notes = nanometres["scan"]["notes"].to_string();
    assert!(notes.contains("converted from m to nm, 1 m = 1000000000 nm"), "{notes}");
    // Two files with different units use the requested unit.
    let pair = "--surface h.x3p --second-surface h.npy --unit um --size 10";
    assert_eq!(run(pair)["unit"], "µm");
    let generated = run("--n 32 --unit mm --size 2cm");
    assert_eq!((&generated["unit"], &generated["size"][0]), (&"mm".into(), &20.0.into()));
}

#[test]
fn refusals_name_the_flag_and_what_to_do() {
    let folder = folder();
    for (flags, parts) in [
        ("contact --n 16 --young 70GPa --p-star 0.1", ["--young: \"70GPa\"", "--unit gives them one"]),
        ("contact --surface h.npy --pressure 1MPa", ["--pressure: \"1MPa\"", "--unit gives them one"]),
        ("contact --n 16 --unit um --young 70nm --p-star 0.1", ["--young: \"70nm\"", "it must be a stress"]),
        ("contact --n 16 --unit um --young 70Gpa --p-star 0.1", ["--young: \"70Gpa\"", "is no unit"]),
        ("contact --n 16 --unit um --young 1GPa --p-star 1MPa", ["--p-star", "1MPa"]),
        ("contact --n 16 --unit V --p-star 0.1", ["--unit", "a unit of length"]),
        ("contact --n 16 --unit um --stress-unit um --p-star 0.1", ["--stress-unit", "a unit of stress"]),
        ("contact --n 16 --unit um --p-star 0.1", ["--young is missing; lengths are in µm", "--e-star 1"]),
        ("theory --n 16 --unit um --p-star 0.1", ["--young is missing", "--e-star 1"]),
        ("path --n 16 --unit um --p-star 0.1,0.2", ["--young is missing", "--e-star 1"]),
        ("punch --young 70GPa", ["--young is 70GPa", "the lengths of punch have none"]),
        ("law --law morse --param gamma=1J/m^2 --param range=1 --normal 0", ["--param", "--unit"]),
    ] {
        let error = refused(folder.path(), flags);
        assert!(parts.iter().all(|part| error.contains(part)) && error.lines().count() == 1, "{flags}: {error}");
    }
    // Reduced quantities of a surface with a unit have none.
    json(folder.path(), &words("contact --n 16 --unit um --e-star 1 --p-star 0.1 --json"));
}

/// A refused number has the unit in which it was written, not the unit of the problem.
#[test]
fn refusals_show_quantities_as_they_were_written() {
    let folder = folder();
    let of_surface = "--n 16 --unit um --size 100um";
    for (flags, part) in [
        ("contact SURFACE --young 1GPa --force=-5N", "--force is -5N; it must be positive and finite"),
        ("contact SURFACE --young 1GPa --pressure=1MPa,-1kPa", "--pressure is -1kPa; it must be positive"),
        ("contact SURFACE --young 1GPa --approach '-5 nm'", "--approach is -5 nm; it must be positive"),
        ("contact SURFACE --young=-1GPa --p-star 0.1", "--young: Young's modulus is -1GPa; it must be positive"),
        ("contact SURFACE --young 1GPa --p-star 0.1 --hardness=-2GPa", "--hardness is -2GPa; it must be positive"),
        ("contact --n 16 --size=-1mm --young 1GPa --p-star 0.1", "the cell lengths are [-1mm, -1mm]; they must be"),
        ("contact --shape sphere:R=-2mm --n 16 --size 1mm --young 1GPa --p-star 1", "R of sphere is -2mm; it must be"),
        ("theory SURFACE --young 1GPa --force=-5N", "--force is -5N; it must be positive"),
        (
            "slide SURFACE --young 1GPa --prony 1s:0.5 --p-star 0.1 --velocity=-1mm/s",
            "--velocity is -1mm/s; it must be",
        ),
        ("path SURFACE --young 1GPa --prony=-1ms:0.5 --p-star 0.1 --time 0", "a relaxation time is -1ms; it must be"),
        // Bounds are in the unit of the problem, and so is the number beside them.
        ("surface SURFACE --filter s:-2000nm", "the nesting index is -2000nm = -2; it must be between 12.5"),
    ] {
        let flags = flags.replace("SURFACE", of_surface);
        let words: Vec<&str> = flags.split('\'').enumerate().flat_map(|(index, part)| quoted(index, part)).collect();
        let output = gfmd(folder.path(), &words);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(part) && error.lines().count() == 1, "{flags}: {error}");
        assert_eq!(output.status.code(), Some(2), "{flags}");
    }
}

/// Returns the words of every other part of a command line, and the parts between as they are.
fn quoted(index: usize, part: &str) -> Vec<&str> {
    if index % 2 == 1 { vec![part] } else { part.split_whitespace().collect() }
}

#[test]
fn units_that_are_mixed_up_are_told() {
    let folder = folder();
    let run =
        |flags: &str| json(folder.path(), &words(&format!("contact --surface h.npy --size 10 {flags} --json -q")));
    let says = |flags: &str, expected: &[&str]| {
        let report = run(flags);
        let found = warned(&report);
        assert_eq!(found.len(), expected.len(), "{flags}: {found:?}");
        found.iter().zip(expected).for_each(|(text, part)| assert!(text.contains(part), "{flags}: {text}"));
    };
    says("--unit m --young 70 --p-star 0.1", &["the contact modulus is 7.000e1 Pa"]);
    says("--unit m --young 70e9 --pressure 1e8", &[]);
    says("--unit um --young 70 --pressure 1MPa", &["the contact modulus", "--pressure is"]);
    says("--young 70 --pressure 1e6", &["far beyond full contact (some 2): pressure and modulus may be in different"]);
    // Both have their unit: no other is guessed.
    for known in ["--unit um --young 1MPa --pressure 100MPa", "--unit m --young 1e6 --pressure 1e8"] {
        says(known, &["Pa, far beyond full contact (some 2): a stress without a unit is in Pa"]);
    }
    says("--unit um --young 70 --pressure 0.1", &[]);
    says("--young 1 --pressure 0.01", &[]);
    let law = |gamma: &str| {
        format!("--unit um --young 1e8 --law exponential --param gamma={gamma},range=0.3 --p-star 0.1 --coarse")
    };
    says(&law("0.05"), &["the work of adhesion is 5.0e-8 J/m^2"]);
    says(&law("1e-8J/m^2"), &["one without a unit is in Pa*µm; --param gamma=0.05J/m^2 has its own"]);
    says(&law("0.05J/m^2"), &[]);
}

#[test]
fn people_read_prefixes_and_programs_consistent_units() {
    let folder = folder();
    let flags = "contact --surface h.npy --size 10 --unit um --young 70GPa --pressure 5MPa,200MPa";
    let output = gfmd(folder.path(), &words(&format!("{flags} --wide")));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["cell 10 µm x 10 µm", "E* = 70 GPa", "pressure / MPa", "mean gap / nm", "stiffness / (GPa/µm)"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let report = json(folder.path(), &words(&format!("{flags} --json")));
    assert_eq!((&report["e_star"], &report["loads"][0]["mean_pressure"]), (&70e9.into(), &5e6.into()));
    // Without a unit nothing is scaled.
    let output = gfmd(folder.path(), &words("contact --surface h.npy --size 10 --young 70e9 --pressure 5e6"));
    assert!(String::from_utf8(output.stdout).unwrap().contains("  5.0000e6"));
}

/// A force is the mean pressure times the area of the cell, or of the patch, for every command and in every unit.
#[test]
fn a_force_is_the_mean_pressure_on_the_whole_surface() {
    let folder = folder();
    let folder = folder.path();
    let scan = "--surface h.npy --size 50um,40um --unit um --young 70GPa --poisson 0.3";
    let states = |command: &str, flags: &str| {
        let report = json(folder, &words(&format!("{command} {scan} {flags} --json")));
        let list = ["loads", "steps", "states"].into_iter().find_map(|key| report.get(key)).unwrap();
        list.as_array().unwrap().iter().map(|state| state["mean_pressure"].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    let law = "--law exponential --param gamma=50mJ/m^2,range=5nm --coarse";
    for (command, flags, force, pressure) in [
        ("contact", String::new(), "20mN,0.1N", "10MPa,50MPa"),
        ("contact", "--boundary free".to_owned(), "20000uN", "10MPa"),
        ("contact", law.to_owned(), "20mN,-1uN", "10MPa,-500Pa"),
        ("path", "--friction 0.3 --lateral 0,10nm --steps 1".to_owned(), "20mN", "10MPa"),
        ("wear", "--coefficient 1e-12/Pa --distance 1um --steps 1".to_owned(), "20mN", "10MPa"),
        ("slide", "--prony 1:0.5 --velocity 1um/s".to_owned(), "20mN", "10MPa"),
    ] {
        let [by_force, by_pressure] = [("force", force), ("pressure", pressure)]
            .map(|(key, load)| states(command, &format!("{flags} --{key}={load}")));
        assert_eq!(by_force.len(), by_pressure.len(), "{command} {flags}");
        for (found, wanted) in by_force.iter().zip(&by_pressure) {
            approx::assert_relative_eq!(found, wanted, max_relative = 1e-9);
        }
    }
    let run = format!("contact {scan} --force 20mN --out f.h5 --json");
    assert_eq!(json(folder, &words(&run))["loads"][0]["converged"], true);
    assert_eq!(json(folder, &["check", "f.h5", "--rerun", "--json"])["differing"], 0);
    // Without a unit it is a stress times the square of a length.
    let bare = json(folder, &words("contact --n 32 --size 2,3 --eps-f-inv 4 --force 0.06 --json"));
    approx::assert_relative_eq!(bare["loads"][0]["mean_pressure"].as_f64().unwrap(), 0.01, max_relative = 1e-9);
    for (flags, reason) in [
        ("contact --n 16 --force 1N", "--unit"),
        ("contact --n 64 --dim 2 --force 0.01", "a force per length"),
        ("contact --n 16 --force 0", "--force is 0; it must be positive"),
        ("contact --n 16 --force 1 --pressure 1", "--force"),
        ("contact --surface h.npy --size 50um --unit um --force 1MPa", "a force"),
    ] {
        let text = refused(folder, flags);
        assert!(text.contains(reason), "{flags}: {text}");
    }
}

/// Leak and contact conductance in SI and in the units of the surface, along a path too, and what they need.
#[test]
fn leaks_and_conductances_are_volumes_per_time_and_watts_per_area_and_kelvin() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let surface = "--n 48,36 --size 4,3 --eps-f-inv 4 --young 10MPa --p-star 0.05";
    let fluid = "--flow --viscosity 1mPa*s --pressure-drop 1bar";
    let measured = format!("--statistics --conductivity 50W/(m*K),0.2W/(m*K) {fluid}");
    let run = |flags: &str| crate::common::json(folder, &flags.split_whitespace().collect::<Vec<_>>());
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let small = run(&format!("contact {surface} --unit um {measured} --out um.h5 --json"))["loads"][0].clone();
    let [k1, k2]: [f64; 2] = [50.0, 0.2];
    let conductance = number(&small["conductance"]) * 1e6 / (1.0 / k1 + 1.0 / k2);
    // Pa µm/(s K) are 1e-6 W/(m² K).
    assert!((number(&small["contact_conductance"]) * 1e-6 / conductance - 1.0).abs() < 1e-12);
    assert!(number(&small["contact_conductance_limit"]) > 0.0);
    let gap = number(&small["mean_gap"]) * 1e-6;
    for (axis, ratio) in [3.0 / 4.0, 4.0 / 3.0].into_iter().enumerate() {
        let expected = number(&small["flow"]["conductivity"][axis][axis]) * gap.powi(3) / 12.0 * 1e5 / 1e-3 * ratio;
        let found = number(&small["leak"][axis]) * 1e-18;
        assert!(found > 0.0 && (found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        let [limit, error] = ["leak_limit", "leak_limit_error"].map(|name| number(&small[name][axis]) * 1e-18);
        assert!(limit > found && error > 0.0 && error < 0.5 * limit, "{limit} {error}");
    }
    let large = run(&format!("contact {surface} --unit mm {measured} --json"))["loads"][0].clone();
    for name in ["leak", "contact_conductance"] {
        let [of_um, of_mm] = [&small, &large].map(|load| if name == "leak" { &load[name][0] } else { &load[name] });
        // Lengths, and the units of the numbers, are a thousand times as large.
        let expected = if name == "leak" { 1.0 } else { 1e-6 };
        assert!((number(of_mm) / number(of_um) / expected - 1.0).abs() < 1e-9, "{name}");
    }
    assert_eq!(run("check um.h5 --json")["differing"], 0);
    let path = format!("path {surface} --unit um {fluid} --steps 1 --out path.h5 --json");
    let step = run(&path)["steps"][0].clone();
    assert!((number(&step["leak"][0]) / number(&small["leak"][0]) - 1.0).abs() < 1e-4);
    assert_eq!(run("check path.h5 --json")["differing"], 0);
    for (flags, message) in [
        ("contact --n 16 --p-star 0.1 --viscosity 1", "--viscosity is given; it must be left out without --flow"),
        ("path --n 16 --p-star 0.1 --pressure-drop 1", "--pressure-drop is given; it must be left out without --flow"),
        ("contact --n 16 --p-star 0.1 --flow --viscosity 1", "--pressure-drop is missing; it is needed with --visc"),
        ("contact --n 16 --p-star 0.1 --flow --viscosity 1Pa --pressure-drop 1", "it must be a viscosity"),
        ("contact --n 16 --p-star 0.1 --flow --viscosity 0 --pressure-drop 1", "--viscosity is 0; it must be positive"),
        ("contact --n 16 --p-star 0.1 --conductivity 1,2", "--conductivity is given; it must be left out without"),
        ("contact --n 16 --p-star 0.1 --statistics --conductivity 1", "two numbers, of both conductors"),
        ("contact --n 16 --p-star 0.1 --statistics --conductivity 1,-2", "it must be positive and finite"),
    ] {
        let output = crate::common::gfmd(folder, &flags.split_whitespace().collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(message), "{flags}: {text}");
    }
}
