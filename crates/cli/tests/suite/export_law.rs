//! `contact --export-law` from end to end: the numbers of the report, in SI units, in each format.

use std::path::Path;

use serde_json::Value;

use crate::common::{gfmd, json};

const JOINT: &str = "contact --n 64 --eps-f-inv 8 --eps-t-inv 2 --hurst 0.8 --unit um --size 100um --young 70GPa";
const MEASURED: &str = "--pressure 0.1GPa,10MPa,1GPa --statistics --flow --conductivity 16W/(m*K),200W/(m*K)";

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &format!("{flags} --json --quiet").split_whitespace().collect::<Vec<_>>())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Returns the columns of a table by name, without the comments.
fn columns(text: &str) -> Vec<(String, Vec<Option<f64>>)> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
    let heads = lines.next().unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    assert!(rows.iter().all(|row| row.len() == heads.len()), "{text}");
    let column = |index: usize| rows.iter().map(|row| row[index].parse().ok()).collect();
    heads.iter().enumerate().map(|(index, head)| ((*head).to_owned(), column(index))).collect()
}

#[test]
fn the_table_has_the_numbers_of_the_report_in_si_units() {
    let folder = tempfile::tempdir().unwrap();
    let report = run(folder.path(), &format!("{JOINT} {MEASURED} --export-law law.csv"));
    assert_eq!(report["export_law"], "law.csv");
    let text = std::fs::read_to_string(folder.path().join("law.csv")).unwrap();
    let columns = columns(&text);
    let column = |name: &str| &columns.iter().find(|(head, _)| head.starts_with(&format!("{name} ["))).unwrap().1;
    let loads = report["loads"].as_array().unwrap();
    // Sorted by pressure, behind first touch.
    let sorted = [&loads[1], &loads[0], &loads[2]];
    let near = |found: Option<f64>, wanted: f64| (found.unwrap() / wanted - 1.0).abs() < 1e-8;
    assert_eq!(column("pressure")[0], Some(0.0));
    for (index, load) in sorted.into_iter().enumerate() {
        for (name, key, unit) in [
            ("pressure", "mean_pressure", 1.0),
            ("mean_gap", "mean_gap", 1e-6),
            ("mean_gap_grid_error", "mean_gap_grid_error", 1e-6),
            ("area_fraction", "area_fraction", 1.0),
            ("area_fraction_grid_error", "area_fraction_grid_error", 1.0),
            ("stiffness", "stiffness", 1e6),
            ("conductance", "conductance", 1e6),
            // Lengths of the conductance are in um, conductivities in W/(m K).
            ("contact_conductance", "contact_conductance", 1e-6),
        ] {
            let wanted = unit * number(&load[key]);
            assert!(near(column(name)[index + 1], wanted), "{name}: {:?} {wanted}", column(name)[index + 1]);
        }
        let conductance = number(&load["conductance"]) * 1e6 / (1.0 / 16.0 + 1.0 / 200.0);
        assert!(near(column("contact_conductance")[index + 1], conductance), "{load}");
        let gap = 1e-6 * number(&load["mean_gap"]);
        let conductivity = number(&load["flow"]["conductivity"][0][0]);
        let wanted = if load["flow"]["percolates"][0] == true { conductivity * gap.powi(3) / 12.0 } else { 0.0 };
        let found = column("transmissivity_x")[index + 1].unwrap();
        assert!((found - wanted).abs() <= 1e-8 * wanted, "{found} {wanted}");
    }
    // The gap of first touch is the distance from the highest point to the mean plane.
    let approach = 1e-6 * number(&loads[1]["approach"]);
    assert!(near(column("mean_gap")[0], approach + column("mean_gap")[1].unwrap()), "{text}");
    // The power law lies between its points.
    let line = text.lines().find(|line| line.starts_with("# contact_conductance = c pressure^m")).unwrap();
    let exponent: f64 = line.split("m = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((0.8..1.0).contains(&exponent), "{line}");
}

#[test]
fn keywords_and_tables_are_written_by_ending_or_format() {
    let folder = tempfile::tempdir().unwrap();
    let read = |file: &str| std::fs::read_to_string(folder.path().join(file)).unwrap();
    run(folder.path(), &format!("{JOINT} {MEASURED} --export-law law.inp"));
    run(folder.path(), &format!("{JOINT} {MEASURED} --export-law law.txt --export-law-format abaqus"));
    assert_eq!(read("law.inp"), read("law.txt"));
    let text = read("law.inp");
    let behind = |keyword: &str| -> Vec<[f64; 2]> {
        let rows = text.lines().skip_while(|line| !line.starts_with(keyword)).skip(1);
        let numbers =
            |line: &str| line.split(',').map(|number| number.trim().parse::<f64>().unwrap()).collect::<Vec<_>>();
        rows.take_while(|line| !line.starts_with('*')).map(|line| numbers(line).try_into().unwrap()).collect()
    };
    let overclosure = behind("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR");
    assert!(overclosure.len() == 4 && overclosure[0][0] == 0.0, "{text}");
    assert!(overclosure.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]), "{overclosure:?}");
    let conductance = behind("*GAP CONDUCTANCE, PRESSURE");
    assert!(conductance.len() == 4 && conductance[0] == [0.0, 0.0], "{text}");
    assert_eq!(conductance.iter().map(|row| row[1]).collect::<Vec<_>>(), [0.0, 1e7, 1e8, 1e9]);
    run(folder.path(), &format!("{JOINT} --pressure 10MPa,0.1GPa --export-law law.mac"));
    let text = read("law.mac");
    assert!(text.contains("*DIM,GFMD_GAP,TABLE,3,1,1,PRESSURE\nGFMD_GAP(1,0)=0.000000000e0\n"), "{text}");
    assert!(
        text.contains("! no conductance: it was not measured") && text.contains("! GFMD_TCC is left out"),
        "{text}"
    );
}

/// Nothing is computed, or what was computed is kept.
#[test]
fn contacts_without_a_law_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let joint = JOINT.strip_prefix("contact ").unwrap();
    for (flags, part) in [
        (format!("{joint} --pressure 1MPa --export-law law.csv"), "given with two or more loads (there is 1)"),
        (
            "--n 16 --p-star 0.1,0.2 --export-law law.csv".into(),
            "given with units, such as --unit um and --young 70GPa",
        ),
        (format!("{joint} --pressure 1MPa,2MPa --export-law law.txt"), "NAME.csv, NAME.inp or NAME.mac"),
        (format!("{joint} --pressure 1MPa,2MPa --export-law law"), "NAME.csv, NAME.inp or NAME.mac"),
        (format!("{joint} --pressure 1MPa,2MPa --export-law law --export-law-format vtk"), "csv, abaqus, ansys"),
        (format!("{joint} --pressure 1MPa,2MPa --export-law-format csv"), "--export-law"),
        (format!("{joint} --dim 2 --pressure 1MPa,2MPa --export-law law.csv"), "left out of a profile"),
        (format!("{joint} --boundary free --pressure 1MPa,2MPa --export-law law.csv"), "left out with --boundary free"),
        (
            format!(
                "{joint} --law exponential --param gamma=1J/m^2,range=1um --pressure 1MPa,2MPa --export-law law.csv"
            ),
            "left out with an attraction",
        ),
        (
            format!("{joint} --height 50um --lower-seed 2 --pressure 1MPa,2MPa --export-law law.csv"),
            "left out between two surfaces",
        ),
        (format!("{joint} --pressure 1MPa,2MPa --export-law no/law.csv"), "no"),
    ] {
        let arguments: Vec<&str> = ["contact"].into_iter().chain(flags.split(' ')).collect();
        let output = gfmd(folder.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{flags}: {message}");
        assert!(message.contains(part) && message.trim_end().lines().count() == 1, "{flags}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    // In full contact the gap does not fall any more: the numbers are printed, and the reason.
    let line = format!("{JOINT} --p-star 5,6 --export-law law.csv --json --quiet");
    let output = gfmd(folder.path(), &line.split(' ').collect::<Vec<_>>());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["loads"].as_array().unwrap().len() == 2 && report["export_law"].is_null());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("it must fall from load to load"), "{message}");
}
