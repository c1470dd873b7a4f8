//! `green`: stiffness, compliance and transfer matrices of one wave vector.

use std::fmt::{self, Display};

use gfmd_green::{Body, Complex64, GreenError, Height, Section};
use gfmd_problem::{key, setting, words};
use gfmd_response::unit_of;
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;
use gfmd_problem::options::values::within;
use gfmd_problem::options::{BodyArgs, OtherArgs, height, parse_height};
use gfmd_problem::options::{Kinds, Options};

/// Flags of `green`.
#[derive(clap::Args, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd green --qx 3 --qy 4 --height 0.3 --young 1 --poisson 0.33
  gfmd green --dim 2 --qx 2 --height inf --poisson 0.5 --depth 0.1 --json
  gfmd green --qx 1 --height 0.5 --base half-space --base-young 10 --base-poisson 0.2 --z 0.25
  gfmd green --qx 5 --height 0.05 --layer 3,0.3,0.1 --base free --depth 0.12")]
pub struct Args {
    /// 3: components x, y, z; 2: plane strain, components x, z
    #[arg(
        long,
        default_value_t = 3,
        value_parser = clap::value_parser!(u8).range(2..=3),
        value_name = "2|3",
        help_heading = "Wave"
    )]
    #[serde(deserialize_with = "within::<2, 3, _, _>")]
    dim: u8,
    /// Wave vector component qx, rad/length; fields vary as exp(+i q r)
    #[arg(long, value_name = "QX", allow_negative_numbers = true, help_heading = "Wave")]
    #[option(kinds = Kinds::WAVENUMBER, default = f64::NAN)]
    qx: f64,
    /// Wave vector component qy, rad/length; 0 in 2-D
    #[arg(long, default_value_t = 0.0, value_name = "QY", allow_negative_numbers = true, help_heading = "Wave")]
    #[option(kinds = Kinds::WAVENUMBER)]
    qy: f64,
    /// Height of the slab, or inf for a half-space
    #[arg(
        long,
        default_value_t = Height::Infinite,
        value_name = "ZM",
        value_parser = parse_height,
        allow_negative_numbers = true,
        help_heading = "Body"
    )]
    #[serde(with = "height")]
    #[option(kinds = Kinds::LENGTH)]
    height: Height,
    /// Young's modulus, stress
    #[arg(long, default_value_t = 1.0, value_name = "E", allow_negative_numbers = true, help_heading = "Body")]
    #[option(kinds = Kinds::STRESS)]
    young: f64,
    /// Poisson's ratio, above -1 and at most 0.5
    #[arg(long, default_value_t = 0.0, value_name = "NU", allow_negative_numbers = true, help_heading = "Body")]
    poisson: f64,
    #[command(flatten)]
    #[serde(flatten)]
    others: OtherArgs,
    /// Also compute displacement and stress at this height above the base of the slab
    #[arg(long, value_name = "Z", allow_negative_numbers = true, conflicts_with = "depth", help_heading = "Places")]
    #[option(kinds = Kinds::LENGTH)]
    z: Option<f64>,
    /// Also compute displacement and stress at this depth below the surface
    #[arg(long, value_name = "D", allow_negative_numbers = true, help_heading = "Places")]
    #[option(kinds = Kinds::LENGTH)]
    depth: Option<f64>,
}

/// Matrix in JSON: rows of pairs [re, im].
type Rows = Vec<Vec<[f64; 2]>>;

/// Printed result. Infinite entries (at q = 0 of a free or an incompressible body) are `null` in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Components: x, y, z, or x, z in 2-D.
    pub components: Vec<&'static str>,
    /// Wave vector (qx, qy) in rad/length.
    pub q: [f64; 2],
    /// Stiffness K, traction = K u, in stress/length.
    pub stiffness: Rows,
    /// Compliance G = K⁻¹, in length/stress.
    pub compliance: Rows,
    /// Frictionless normal compliance G_zz, in length/stress.
    pub normal_compliance: f64,
    /// Frictionless normal stiffness 1/G_zz, in stress/length.
    pub normal_stiffness: f64,
    /// Transfer matrices to the place given by `--z` or `--depth`.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub inside: Option<Inside>,
}

/// Displacement and stress inside the body per displacement of the surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inside {
    /// Displacement per displacement of the surface.
    pub displacement_transfer: Rows,
    /// Stress per displacement of the surface, in stress/length.
    pub stress_transfer: Rows,
    /// Names of the rows of `stress_transfer`.
    pub stress_components: Vec<&'static str>,
}

/// Evaluates the flags.
///
/// # Errors
/// Returns an error if a flag is out of range.
pub fn run(args: &Args) -> Result<Report, Failure> {
    for (option, value) in [("qx", args.qx), ("qy", args.qy)] {
        if !value.is_finite() {
            return Err(Failure::value(key(option), value, "finite"));
        }
    }
    if args.dim == 2 && args.qy != 0.0 {
        return Err(Failure::value(key("qy"), args.qy, words!["0 with ", setting("dim", 2)]));
    }
    let given = body(args)?;
    section(args, &given)?;
    // Determinants are products of several stiffnesses. Compute them in units of the modulus and the wavelength, powers
    // of two that change no digit.
    let largest = args.qx.abs().max(args.qy.abs());
    let (stress, length) = (unit_of(args.young), 1.0 / unit_of(largest));
    let stiffness_unit = stress / length;
    let body = given.in_units(stress, length);
    let at = |place: Option<f64>| place.map(|place| place / length);
    let section = section(&Args { z: at(args.z), depth: at(args.depth), ..args.clone() }, &body)?;
    let q = [args.qx * length, args.qy * length];
    let normal_compliance = body.normal_compliance(q[0].hypot(q[1])) / stiffness_unit;
    let times = |rows: Rows, unit: f64| -> Rows {
        rows.into_iter().map(|row| row.into_iter().map(|entry| entry.map(|part| part * unit)).collect()).collect()
    };
    let (components, stiffness, compliance) = if args.dim == 2 {
        (vec!["x", "z"], rows(&body.plane_stiffness(q[0])), rows(&body.plane_compliance(q[0])))
    } else {
        (vec!["x", "y", "z"], rows(&body.stiffness(q)), rows(&body.compliance(q)))
    };
    let inside = section.map(|section| {
        if args.dim == 2 {
            Inside {
                displacement_transfer: rows(&section.plane_displacement_transfer(q[0])),
                stress_transfer: times(rows(&section.plane_stress_transfer(q[0])), stiffness_unit),
                stress_components: vec!["xx", "zz", "xz"],
            }
        } else {
            Inside {
                displacement_transfer: rows(&section.displacement_transfer(q)),
                stress_transfer: times(rows(&section.stress_transfer(q)), stiffness_unit),
                stress_components: vec!["xx", "yy", "zz", "yz", "xz", "xy"],
            }
        }
    });
    let (stiffness, compliance) = (times(stiffness, stiffness_unit), times(compliance, 1.0 / stiffness_unit));
    let normal_stiffness = normal_compliance.recip();
    let q = [args.qx, args.qy];
    let report = Report { components, q, stiffness, compliance, normal_compliance, normal_stiffness, inside };
    match report.unrepresentable() {
        Some((what, found)) if q != [0.0; 2] => {
            let [qx, qy, young] = [args.qx, args.qy, args.young].map(|value| format!("{value:e}"));
            let other = words![key("qy"), format!(" {qy} and "), key("young"), format!(" {young}")];
            let why = format!(
                "; every number of the result must be finite, and the {what} has an entry {found}: choose other units"
            );
            Err(Failure::refused(words![key("qx"), format!(" is {qx}, "), other, why]))
        }
        _ => Ok(report),
    }
}

impl Report {
    /// Returns the first invalid number, NaN or infinite, and its matrix. At q = 0 infinite entries are valid.
    fn unrepresentable(&self) -> Option<(&'static str, f64)> {
        let inside = self.inside.as_ref();
        let matrices = [
            ("stiffness", Some(&self.stiffness)),
            ("compliance", Some(&self.compliance)),
            ("displacement transfer", inside.map(|inside| &inside.displacement_transfer)),
            ("stress transfer", inside.map(|inside| &inside.stress_transfer)),
        ];
        let scalars = [("normal compliance", self.normal_compliance), ("normal stiffness", self.normal_stiffness)];
        let entries = matrices.into_iter().filter_map(|(name, matrix)| Some((name, matrix?)));
        let entries = entries.flat_map(|(name, rows)| rows.iter().flatten().flatten().map(move |entry| (name, *entry)));
        entries.chain(scalars).find(|(_, entry)| !entry.is_finite())
    }
}

fn body(args: &Args) -> Result<Body, Failure> {
    let Args { young, poisson, height, others, .. } = args;
    Ok(BodyArgs {
        young: Some(*young),
        poisson: *poisson,
        height: *height,
        others: others.clone(),
        ..BodyArgs::default()
    }
    .body()?)
}

fn section<'a>(args: &Args, body: &'a Body) -> Result<Option<Section<'a>>, Failure> {
    let (option, place, section) = match (args.z, args.depth) {
        (Some(z), _) => ("z", z, body.at_height(z)),
        (None, Some(depth)) => ("depth", depth, body.at_depth(depth)),
        (None, None) => return Ok(None),
    };
    section.map(Some).map_err(|error| match error {
        GreenError::Outside { largest, .. } if largest.is_finite() => {
            Failure::value(key(option), place, format!("between 0 and {largest}"))
        }
        GreenError::Outside { .. } => Failure::value(key(option), place, "at least 0 and finite"),
        GreenError::HalfSpaceHeight(_) => {
            let why = words!["it needs a finite ", key("height"), ", a half-space takes ", key("depth")];
            Failure::contradicts(key(option), place, why)
        }
        other => Failure::refused(other.to_string()),
    })
}

fn rows<const ROWS: usize, const COLUMNS: usize>(matrix: &[[Complex64; COLUMNS]; ROWS]) -> Rows {
    matrix.iter().map(|row| row.iter().map(|entry| [entry.re, entry.im]).collect()).collect()
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write_matrix(
            f,
            "stiffness K (traction = K u), stress/length",
            &self.components,
            &self.components,
            &self.stiffness,
        )?;
        write_matrix(
            f,
            "compliance G (u = G traction), length/stress",
            &self.components,
            &self.components,
            &self.compliance,
        )?;
        writeln!(f, "frictionless normal compliance G_zz   {:.10e} length/stress", self.normal_compliance)?;
        write!(f, "frictionless normal stiffness 1/G_zz  {:.10e} stress/length", self.normal_stiffness)?;
        if let Some(inside) = &self.inside {
            writeln!(f, "\n")?;
            let title = "displacement inside per displacement of the surface";
            write_matrix(f, title, &self.components, &self.components, &inside.displacement_transfer)?;
            let title = "stress inside per displacement of the surface, stress/length";
            write_matrix(f, title, &inside.stress_components, &self.components, &inside.stress_transfer)?;
        }
        Ok(())
    }
}

/// Writes each row on a line: its name, then the real and the imaginary part of each column.
fn write_matrix(f: &mut fmt::Formatter, title: &str, names: &[&str], columns: &[&str], matrix: &Rows) -> fmt::Result {
    writeln!(f, "{title}")?;
    write!(f, "    ")?;
    for column in columns {
        write!(f, "  {column:>37}")?;
    }
    writeln!(f)?;
    for (name, row) in names.iter().zip(matrix) {
        write!(f, "  {name:<2}")?;
        for [re, im] in row {
            write!(f, "  {re:>17.10e} {im:>+17.10e} i")?;
        }
        writeln!(f)?;
    }
    writeln!(f)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    fn evaluate(flags: &str) -> Result<Report, Failure> {
        let flags = std::iter::once("green").chain(flags.split_whitespace());
        let command = Command::try_parse_from(flags).map_err(|error| Failure::refused(error.to_string()))?;
        run(&command.args)
    }

    #[test]
    fn a_slab_in_space_has_the_numbers_of_the_theory_note() {
        let report = evaluate("--qx 1.5 --qy -0.5 --height 0.9 --young 1 --poisson 0.33 --z 0.9").unwrap();
        let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        near(report.stiffness[0][0][0], 1.014_103_833);
        near(report.stiffness[0][1][0], -0.115_465_070_5);
        near(report.stiffness[1][2][1], -0.006_726_841_479);
        near(report.stiffness[2][0][1], -0.020_180_524_44);
        near(report.compliance[2][2][0], report.normal_compliance);
        let inside = report.inside.as_ref().unwrap();
        near(inside.displacement_transfer[1][1][0], 1.0);
        near(inside.stress_transfer[2][2][0], report.stiffness[2][2][0]);
        assert_eq!(inside.stress_transfer.len(), inside.stress_components.len());
        for text in ["1.0141038331e0", "stress inside", "  xy  "] {
            assert!(report.to_string().contains(text), "{report}");
        }
    }

    #[test]
    fn a_plane_has_two_components() {
        let report = evaluate("--dim 2 --qx -2 --poisson 0.25 --depth 0.1").unwrap();
        assert_eq!(report.stiffness.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
        assert_eq!(report.inside.as_ref().unwrap().stress_transfer.len(), 3);
        let space = evaluate("--dim 3 --qx -2 --poisson 0.25 --depth 0.1").unwrap();
        assert_eq!(report.stiffness[0][1], space.stiffness[0][2]);
        let json = serde_json::to_value(&report).unwrap();
        for key in ["stiffness", "compliance", "normal_compliance", "displacement_transfer", "stress_transfer"] {
            assert!(!json[key].is_null(), "{key}");
        }
    }

    #[test]
    fn bases_change_the_answer() {
        let normal = |flags: &str| evaluate(&format!("--qx 1 --height 0.5 {flags}")).unwrap().normal_stiffness;
        let coated = normal("--base half-space --base-young 3 --base-poisson 0.2");
        assert!(normal("") > normal("--base sliding") && normal("--base sliding") > coated);
        assert!(coated > normal("--base free"));
    }

    #[test]
    fn unusable_flags_are_named_with_what_was_found_and_what_is_allowed() {
        for (flags, message) in [
            ("--qx nan", "--qx is NaN; it must be finite"),
            ("--dim 2 --qx 1 --qy 2", "--qy is 2; it must be 0 with --dim 2"),
            ("--qx 1 --young 0", "--young: Young's modulus is 0; it must be positive and finite"),
            ("--qx 1 --poisson 0.6", "--poisson: Poisson's ratio is 0.6; it must be above -1 and at most 0.5"),
            ("--qx 1 --height -1", "--height: the height of the slab is -1; it must be positive and finite"),
            (
                "--qx 1 --height 1 --layer 1,0.7,1",
                "--layer: Poisson's ratio is 0.7; it must be above -1 and at most 0.5",
            ),
            ("--qx 1 --layer 1,0.3,1", "--layer is 1,0.3,1; it must be left out with --height inf: nothing lies below"),
            (
                "--qx 1 --second-body 1,0.3,0",
                "--second-body: the height of the slab is 0; it must be positive and finite",
            ),
            ("--qx 1 --base free", "--base is free; it must be bonded with --height inf: a half-space has no base"),
            ("--qx 1 --height 1 --base half-space", "--base-young is missing; it is needed with --base half-space"),
            ("--qx 1 --base-young 2", "--base-young is 2; it must be left out without --base half-space"),
            ("--qx 1 --height 1 --z 1.5", "--z is 1.5; it must be between 0 and 1"),
            ("--qx 1 --z 0.5", "--z is 0.5; it needs a finite --height, a half-space takes --depth"),
            ("--qx 1 --depth -0.5", "--depth is -0.5; it must be at least 0 and finite"),
        ] {
            assert_eq!(evaluate(flags).unwrap_err().to_string(), message);
        }
        for flags in [
            "",
            "--qx 1 --height 1 --layer 1,2",
            "--qx 1 --second-body 1",
            "--qx one",
            "--qx 1 --dim 4",
            "--qx 1 --height tall",
            "--qx 1 --base loose",
        ] {
            assert!(evaluate(flags).is_err(), "{flags}");
        }
    }
}
