//! Text of a law: CSV, keywords of Abaqus, commands of ANSYS.

use std::fmt::Write as _;

use super::{ContactLaw, GAP, Known, LAW_NUMBERS, LawRow, PowerLaw};

/// Format of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawFormat {
    /// Table with commas, and comments that begin with `#`.
    Csv,
    /// Keywords `*SURFACE BEHAVIOR` and `*GAP CONDUCTANCE`.
    Abaqus,
    /// Tables of APDL over the primary variable PRESSURE.
    Ansys,
}

impl LawFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Abaqus, Self::Ansys];

    /// Returns the name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Abaqus => "abaqus",
            Self::Ansys => "ansys",
        }
    }

    /// Returns the format of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Returns the format of a file with this ending: `csv`, `inp` of Abaqus, `mac` of ANSYS.
    pub fn of_ending(ending: &str) -> Option<Self> {
        match ending.to_ascii_lowercase().as_str() {
            "csv" => Some(Self::Csv),
            "inp" => Some(Self::Abaqus),
            "mac" => Some(Self::Ansys),
            _ => None,
        }
    }

    fn comment(self) -> &'static str {
        match self {
            Self::Csv => "# ",
            Self::Abaqus => "** ",
            Self::Ansys => "! ",
        }
    }
}

/// Place of the contact conductance in the numbers of a row.
const CONTACT_CONDUCTANCE: usize = 4;

/// Formats a number with ten digits, which Abaqus reads.
fn digits(value: f64) -> String {
    format!("{value:.9e}")
}

/// Returns the law as text with a `heading`.
pub(super) fn write(law: &ContactLaw, format: LawFormat, heading: &str) -> String {
    let mut out = String::new();
    let mut lines = vec![
        heading.to_owned(),
        format!("nominal pressure against mean gap; SI units (m, Pa, W); realisations: {}", law.realisations),
    ];
    match &law.fit {
        Ok((name, PowerLaw { factor, factor_ci95, exponent, exponent_ci95 })) => {
            let interval = |ends: &Option<[f64; 2]>| {
                ends.map_or_else(
                    || "no interval from two loads".to_owned(),
                    |[low, high]| format!("95 %: {low:.4e} to {high:.4e}"),
                )
            };
            lines.push(format!(
                "{name} = c pressure^m: c = {factor:.4e} ({}), m = {exponent:.4} ({})",
                interval(factor_ci95),
                interval(exponent_ci95)
            ));
        }
        Err(reason) => lines.push(format!("no power law of the conductance: {reason}")),
    }
    lines.extend(law.missing.iter().map(|(name, reason)| format!("no {name}: {reason}")));
    for line in lines {
        // A line of Abaqus has at most 256 characters.
        let short: String = line.chars().take(240).collect();
        let _ = writeln!(out, "{}{short}", format.comment());
    }
    match format {
        LawFormat::Csv => csv(law, &mut out),
        LawFormat::Abaqus => abaqus(law, &mut out),
        LawFormat::Ansys => ansys(law, &mut out),
    }
    out
}

fn csv(law: &ContactLaw, out: &mut String) {
    let several = law.realisations > 1;
    let mut head = vec!["pressure [Pa]".to_owned()];
    for number in &LAW_NUMBERS {
        head.push(format!("{} [{}]", number.name, number.unit));
        head.push(format!("{}_grid_error [{}]", number.name, number.unit));
        if several {
            head.push(format!("{}_standard_error [{}]", number.name, number.unit));
        }
    }
    let _ = writeln!(out, "{}", head.join(","));
    let cell = |value: Option<f64>| value.map_or_else(String::new, digits);
    let row = |pressure: f64, numbers: &[Option<Known>]| {
        let mut cells = vec![digits(pressure)];
        for known in numbers {
            cells.push(cell(known.map(|known| known.value)));
            cells.push(cell(known.and_then(|known| known.grid_error)));
            if several {
                cells.push(cell(known.and_then(|known| known.standard_error)));
            }
        }
        cells.join(",")
    };
    let _ = writeln!(out, "{}", row(0.0, &touch(law)));
    for LawRow { pressure, numbers } in &law.rows {
        let _ = writeln!(out, "{}", row(*pressure, numbers));
    }
}

/// Returns the numbers at first touch: nothing touches there.
fn touch(law: &ContactLaw) -> [Option<Known>; 7] {
    let known = |value: f64| Some(Known { value, grid_error: None, standard_error: None });
    std::array::from_fn(|which| match LAW_NUMBERS[which].name {
        "mean_gap" => known(law.first_gap),
        "area_fraction" | "stiffness" => known(0.0),
        "conductance" | "contact_conductance" if law.rows.iter().any(|row| row.numbers[which].is_some()) => known(0.0),
        _ => None,
    })
}

/// Returns pairs of pressure and a number, from first touch on; `None` if no load has the number.
fn pairs(law: &ContactLaw, which: usize) -> Option<Vec<(f64, f64)>> {
    let first = touch(law)[which]?;
    let rows = law.rows.iter().filter_map(|row| Some((row.pressure, row.numbers[which]?.value)));
    Some(std::iter::once((0.0, first.value)).chain(rows).collect())
}

fn abaqus(law: &ContactLaw, out: &mut String) {
    out.push_str("** overclosure: minus the mean gap, from mean plane to mean plane\n");
    out.push_str("*SURFACE INTERACTION, NAME=ROUGH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR\n");
    for (pressure, gap) in pairs(law, GAP).into_iter().flatten() {
        let _ = writeln!(out, "{}, {}", digits(pressure), digits(-gap));
    }
    match pairs(law, CONTACT_CONDUCTANCE) {
        Some(pairs) => {
            out.push_str("*GAP CONDUCTANCE, PRESSURE\n");
            for (pressure, conductance) in pairs {
                let _ = writeln!(out, "{}, {}", digits(conductance), digits(pressure));
            }
        }
        None => out.push_str("** *GAP CONDUCTANCE is left out: it needs the conductivities of both bodies\n"),
    }
}

fn ansys(law: &ContactLaw, out: &mut String) {
    out.push_str(
        "! real constant 14 of the contact elements: RMODIF,set,14,%GFMD_TCC%\n\
         ! GFMD_GAP and GFMD_KN are no real constants: for springs and user-defined interactions\n",
    );
    let mut table = |name: &str, meaning: &str, pairs: Option<Vec<(f64, f64)>>| match pairs {
        Some(pairs) => {
            let _ = writeln!(out, "! {meaning}\n*DIM,{name},TABLE,{},1,1,PRESSURE", pairs.len());
            for (index, (pressure, value)) in (1..).zip(pairs) {
                let _ = writeln!(out, "{name}({index},0)={}\n{name}({index},1)={}", digits(pressure), digits(value));
            }
        }
        None => {
            let _ = writeln!(out, "! {name} is left out: it needs the conductivities of both bodies");
        }
    };
    table("GFMD_GAP", "mean gap", pairs(law, GAP));
    table("GFMD_KN", "normal stiffness per area", pairs(law, 2));
    table("GFMD_TCC", "thermal contact conductance", pairs(law, CONTACT_CONDUCTANCE));
}
