//! Laws of made-up contacts, read back from their texts.

use super::*;

fn units() -> Units {
    Units::new(Some("um"), Some("MPa"))
}

/// A contact with gap 3 exp(−p) µm above 0 MPa, conductance 5 p^0.95 per µm, and its seeds.
fn realisation(pressures: &[f64], factor: f64) -> Realisation {
    let load = |p: &f64| {
        let numbers = [
            ("mean_gap", Given::Value(3.0 * factor * (-p).exp(), Some(0.01))),
            ("area_fraction", Given::Value(0.01 * p, Some(0.001))),
            ("stiffness", Given::Value(2.0 * p, None)),
            ("conductance", Given::Value(5.0 * p.powf(0.95), Some(0.02))),
            ("contact_conductance", Given::Missing("no conductivity is given".to_owned())),
            ("transmissivity_x", Given::Value(1e-3, Some(1e-4))),
        ];
        numbers.map(|(name, given)| (name.to_owned(), given)).into()
    };
    Realisation { pressure: pressures.to_vec(), first_gap: 3.5 * factor, loads: pressures.iter().map(load).collect() }
}

fn conducting(pressures: &[f64]) -> Realisation {
    let mut found = realisation(pressures, 1.0);
    for (load, p) in found.loads.iter_mut().zip(pressures) {
        load.insert("contact_conductance".to_owned(), Given::Value(40.0 * p.powf(0.95), Some(0.4)));
    }
    found
}

fn law(realisations: &[Realisation]) -> ContactLaw {
    ContactLaw::new(realisations, &units()).unwrap()
}

#[test]
fn numbers_are_in_si_units_and_rise_with_the_pressure() {
    let found = law(&[conducting(&[2.0, 0.5, 1.0])]);
    assert_eq!(found.rows.iter().map(|row| row.pressure).collect::<Vec<_>>(), [0.5e6, 1e6, 2e6]);
    let row = &found.rows[1];
    let value = |which: usize| row.numbers[which].unwrap().value;
    for (which, wanted) in [(0, 3e-6 / 1f64.exp()), (1, 0.01), (2, 2e12), (3, 5e6), (4, 40.0), (5, 1e-21)] {
        assert!((value(which) / wanted - 1.0).abs() < 1e-12, "{which}: {} {wanted}", value(which));
    }
    assert!((found.first_gap / 3.5e-6 - 1.0).abs() < 1e-12);
    assert!((row.numbers[0].unwrap().grid_error.unwrap() / 1e-8 - 1.0).abs() < 1e-12);
    assert_eq!((row.numbers[2].unwrap().grid_error, row.numbers[0].unwrap().standard_error), (None, None));
    assert_eq!(found.missing.keys().copied().collect::<Vec<_>>(), ["transmissivity_y"]);
}

#[test]
fn the_power_law_is_found_with_its_interval() {
    let exact = law(&[conducting(&[0.1, 0.3, 1.0, 3.0])]).fit.unwrap();
    assert_eq!(exact.0, "contact_conductance");
    assert!((exact.1.exponent - 0.95).abs() < 1e-12);
    assert!((exact.1.factor / (40.0 / 1e6f64.powf(0.95)) - 1.0).abs() < 1e-10);
    let [low, high] = exact.1.exponent_ci95.unwrap();
    assert!(low <= high && high - low < 1e-6);
    // Two loads have no interval.
    let two = law(&[realisation(&[0.1, 1.0], 1.0)]).fit.unwrap();
    assert_eq!((two.0, two.1.exponent_ci95, two.1.factor_ci95), ("conductance", None, None));
    assert!((two.1.exponent - 0.95).abs() < 1e-12);
    // A straight line with residuals ±δ about ln p = −1, 0, 1: by the textbook formula with t(1) = 12.706.
    let points = [(-1.0_f64, 0.01), (0.0, -0.02), (1.0, 0.01)].map(|(x, d)| (x.exp(), (2.0 + 0.9 * x + d).exp()));
    let scattered = PowerLaw::fit(&points).unwrap();
    let half = 12.706_204_736 * (6e-4_f64 / 2.0).sqrt();
    assert!((scattered.exponent - 0.9).abs() < 1e-12);
    assert!((scattered.exponent_ci95.unwrap()[1] - 0.9 - half).abs() < 1e-6);
    let of_factor = 12.706_204_736 * (6e-4_f64 / 3.0).sqrt();
    assert!((scattered.factor_ci95.unwrap()[1].ln() - 2.0 - of_factor).abs() < 1e-6);
}

#[test]
fn realisations_have_a_mean_and_a_standard_error() {
    let found = law(&[1.0, 1.1, 1.3].map(|factor| realisation(&[0.5, 1.0], factor)));
    let gap = found.rows[0].numbers[0].unwrap();
    let one = 3e-6 * (-0.5f64).exp();
    assert!((gap.value / one - 3.4 / 3.0).abs() < 1e-12);
    // Deviations −0.1333, −0.0333, 0.1667: variance 0.02333.
    assert!((gap.standard_error.unwrap() / one - (0.07_f64 / 3.0 / 3.0).sqrt()).abs() < 1e-12);
    assert_eq!(found.realisations, 3);
    let text = found.text(LawFormat::Csv, "seeds");
    assert!(text.contains("mean_gap_standard_error [m]") && text.contains("realisations: 3"), "{text}");
}

#[test]
fn contacts_without_a_law_have_a_reason() {
    let refused = |given: &[Realisation], units: &Units| ContactLaw::new(given, units).unwrap_err().to_string();
    let good = realisation(&[0.5, 1.0], 1.0);
    for (length, stress) in [(None, None), (Some("um"), None), (None, Some("Pa"))] {
        assert!(refused(std::slice::from_ref(&good), &Units::new(length, stress)).contains("no unit"));
    }
    assert!(refused(&[realisation(&[0.5], 1.0)], &units()).contains("1 load"));
    assert!(refused(&[], &units()).contains("0 load"));
    assert!(refused(&[good.clone(), realisation(&[0.5, 1.1], 1.0)], &units()).contains("realisation 1 has other"));
    assert!(refused(&[good.clone(), realisation(&[0.5], 1.0)], &units()).contains("realisation 1 has other"));
    assert!(refused(&[realisation(&[-0.5, 1.0], 1.0)], &units()).contains("must be positive"));
    for pressures in [[0.5, 0.5], [f64::NAN, 1.0]] {
        ContactLaw::new(&[realisation(&pressures, 1.0)], &units()).unwrap_err();
    }
    // In full contact the gap no longer falls.
    let mut full = realisation(&[0.5, 1.0, 2.0], 1.0);
    for load in &mut full.loads[1..] {
        load.insert("mean_gap".to_owned(), Given::Value(0.0, None));
    }
    assert!(refused(&[full], &units()).contains("must fall"));
    let mut unknown = realisation(&[0.5, 1.0], 1.0);
    unknown.loads[1].insert("mean_gap".to_owned(), Given::Missing("it was lost".to_owned()));
    assert!(refused(&[unknown], &units()).contains("must fall"));
}

/// Reads the rows of numbers behind a line that begins with `keyword`, up to the next keyword or comment.
fn rows_behind(text: &str, keyword: &str) -> Vec<[f64; 2]> {
    let behind = text.lines().skip_while(|line| !line.starts_with(keyword)).skip(1);
    let rows = behind.take_while(|line| !line.starts_with('*'));
    rows.map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.trim().parse().unwrap()).collect();
        <[f64; 2]>::try_from(numbers).unwrap()
    })
    .collect()
}

#[test]
fn the_keywords_of_abaqus_have_the_rows() {
    let found = law(&[conducting(&[0.5, 1.0, 2.0])]);
    let text = found.text(LawFormat::Abaqus, "a joint\nof two lines");
    assert!(text.lines().all(|line| line.chars().count() <= 256), "{text}");
    let pressures = rows_behind(&text, "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR");
    assert_eq!(pressures.len(), 4);
    assert_eq!(pressures[0][0], 0.0);
    assert!(pressures.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]), "{pressures:?}");
    for (row, read) in found.rows.iter().zip(&pressures[1..]) {
        assert!((read[0] / row.pressure - 1.0).abs() < 1e-9);
        assert!((-read[1] / row.numbers[0].unwrap().value - 1.0).abs() < 1e-9);
    }
    let conductances = rows_behind(&text, "*GAP CONDUCTANCE, PRESSURE");
    assert_eq!(conductances[0], [0.0, 0.0]);
    for (row, read) in found.rows.iter().zip(&conductances[1..]) {
        assert!((read[0] / row.numbers[4].unwrap().value - 1.0).abs() < 1e-9 && read[1] == row.pressure);
    }
    // Without conductivities there is no block.
    let text = law(&[realisation(&[0.5, 1.0], 1.0)]).text(LawFormat::Abaqus, "");
    assert!(!text.lines().any(|line| line.starts_with("*GAP")) && text.contains("no conductivity is given"), "{text}");
}

#[test]
fn the_tables_of_ansys_have_the_rows() {
    let found = law(&[conducting(&[0.5, 1.0, 2.0])]);
    let text = found.text(LawFormat::Ansys, "a joint");
    for (name, which, first) in [("GFMD_GAP", 0, 3.5e-6), ("GFMD_KN", 2, 0.0), ("GFMD_TCC", 4, 0.0)] {
        assert!(text.contains(&format!("*DIM,{name},TABLE,4,1,1,PRESSURE\n")), "{text}");
        let entry = |row: usize, column: usize| -> f64 {
            let head = format!("{name}({row},{column})=");
            text.lines().find_map(|line| line.strip_prefix(&head)).unwrap().parse().unwrap()
        };
        assert!(entry(1, 0) == 0.0 && (entry(1, 1) - first).abs() <= 1e-9 * first, "{name}");
        for (index, row) in found.rows.iter().enumerate() {
            assert_eq!(entry(index + 2, 0), row.pressure);
            assert!((entry(index + 2, 1) / row.numbers[which].unwrap().value - 1.0).abs() < 1e-9, "{name}");
        }
    }
}

#[test]
fn the_table_of_csv_has_every_number_with_its_error() {
    let found = law(&[conducting(&[0.5, 1.0])]);
    let text = found.text(LawFormat::Csv, "a joint");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() == 3 && rows.iter().all(|row| row.len() == head.len()), "{text}");
    let column = |name: &str| head.iter().position(|head| *head == name).unwrap();
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().ok();
    assert_eq!(number(0, "pressure [Pa]"), Some(0.0));
    for (row, wanted) in found.rows.iter().enumerate() {
        for (which, of) in LAW_NUMBERS.iter().enumerate() {
            let [value, error] =
                ["", "_grid_error"].map(|end| number(row + 1, &format!("{}{end} [{}]", of.name, of.unit)));
            let near = |read: Option<f64>, wanted: Option<f64>| match (read, wanted) {
                (Some(read), Some(wanted)) => (read / wanted - 1.0).abs() < 1e-9,
                (read, wanted) => read == wanted,
            };
            assert!(near(value, wanted.numbers[which].map(|known| known.value)), "{}", of.name);
            assert!(near(error, wanted.numbers[which].and_then(|known| known.grid_error)), "{}", of.name);
        }
    }
    assert!(text.contains("# no transmissivity_y: it was not measured"), "{text}");
}

#[test]
fn formats_follow_from_endings_and_names() {
    for (ending, format) in [("csv", "csv"), ("INP", "abaqus"), ("mac", "ansys")] {
        assert_eq!(LawFormat::of_ending(ending).map(LawFormat::name), Some(format));
    }
    assert_eq!(LawFormat::of_ending("txt"), None);
    assert!(LawFormat::ALL.iter().all(|format| LawFormat::named(format.name()) == Some(*format)));
}
