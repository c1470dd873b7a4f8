//! Printed report of a path.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use gfmd_measure::GridLimit;
use gfmd_problem::Facts;
use gfmd_record::{Record, Sheet, Table, columns_of, lines, table_of, with_limit};
use gfmd_unit::{DisplayUnit, Units};
use serde::Serialize;

use crate::measuring::legends;
use crate::session::{list_files, print_note, print_sheet};
use gfmd_input::hardness::GivenHardness;
use gfmd_input::memory::peak_bytes;
use gfmd_report::path::{leg_number, work_imbalance};
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::{Head, Places};

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    /// Features that decide which numbers the steps have.
    #[serde(skip)]
    pub facts: Facts,
    /// Unit vector of the lateral displacement; the table and the plots show lateral numbers along it.
    pub direction: [f64; 2],
    /// Wear coefficient, 1/stress: depth lost per distance divided by the pressure. `None` without wear, as is
    /// `wear_volume`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficient: Option<f64>,
    pub steps: Vec<Record>,
    /// Stiffness and friction of each leg with lateral motion.
    pub sliding: Vec<Sliding>,
    /// Energy lost along the path, per area; `None` if the tractions have no energy.
    pub dissipated: Option<f64>,
    /// Sum of the errors of the steps; `None` if one is unknown.
    pub dissipated_error: Option<f64>,
    /// Sum of the imbalances of the steps, without a first step that loads the surfaces at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work_imbalance: Option<f64>,
    /// Mean depth lost at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wear_volume: Option<f64>,
    /// Its estimated error, unknown if no path with half as many increments was followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wear_volume_error: Option<Option<f64>>,
    pub extra_solves: u64,
    pub lowest_mean_pressure: f64,
    /// With a finer grid: `X_limit`, `X_limit_error`, `X_grid_error` of the lost energy and the lowest mean pressure,
    /// if known.
    #[serde(flatten)]
    pub limits: BTreeMap<String, f64>,
    /// Step at which the surfaces parted under their load, the last one.
    pub parted_at: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// Stiffness and friction measured on one leg.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sliding {
    /// Number of the leg, from 1.
    pub leg: usize,
    /// Shear divided by lateral displacement in the first step of the leg, stress/length.
    pub tangential_stiffness: f64,
    /// Largest magnitude of mean shear divided by mean pressure of any step. If the leg is long enough to slide
    /// everywhere, this is the coefficient of static friction.
    pub friction_coefficient: f64,
}

impl Report {
    /// Collects the results of the steps, whose legs end at the `places` of the waypoints.
    pub(super) fn new(head: Head, direction: [f64; 2], steps: Vec<Record>, places: &Places) -> Self {
        let sum = |name: &str| steps.iter().filter_map(|step| step.value(name)).reduce(|a, b| a + b);
        let mut report = Self {
            head,
            facts: Facts::default(),
            direction,
            coefficient: None,
            sliding: Vec::new(),
            dissipated: sum("dissipated"),
            dissipated_error: error_of_losses(&steps),
            work_imbalance: work_imbalance(|name| steps.iter().map(|step| step.number(name)).collect()),
            wear_volume: steps.last().and_then(|step| step.value("wear_volume")),
            wear_volume_error: steps
                .last()
                .filter(|step| step.has("wear_volume"))
                .map(|step| step.value("wear_volume_error")),
            extra_solves: steps.iter().map(|step| step.number("extra_solves") as u64).sum(),
            lowest_mean_pressure: lowest(&steps, "mean_pressure"),
            limits: BTreeMap::new(),
            parted_at: None,
            not_converged: None,
            peak_bytes: peak_bytes(),
            out: None,
            plots: Vec::new(),
            steps,
        };
        report.sliding = report.sliding(places);
        let pull = lowest(&report.steps, "mean_pressure_limit");
        report.limit("lowest_mean_pressure", [report.lowest_mean_pressure, pull], 0.0);
        let lost = report.steps.iter().filter(|step| step.value("dissipated").is_some());
        let fine = lost.map(|step| step.number("dissipated_limit")).sum();
        let least = report.dissipated_error.unwrap_or(0.0);
        report.limit("dissipated", [report.dissipated.unwrap_or(f64::NAN), fine], least);
        report
    }

    /// Adds the limit of a number from its values on both grids, if known, with an error of at least `least`.
    fn limit(&mut self, name: &str, [value, fine]: [f64; 2], least: f64) {
        let found = GridLimit::of_two_grids(value, fine);
        if found.half_width.is_finite() {
            let found = GridLimit { half_width: found.half_width.max(least), ..found };
            let all = [("limit", fine), ("limit_error", found.half_width), ("grid_error", found.error_of(value))];
            self.limits.extend(all.map(|(end, number)| (format!("{name}_{end}"), number)));
        }
    }

    /// Formats a number on an infinitely fine grid with its certain digits; `None` without a limit.
    fn on_fine_grid(&self, name: &str, kind: &str) -> Option<String> {
        let of = |end: &str| self.limits.get(&format!("{name}_{end}")).copied();
        let (limit, error) = of("limit").zip(of("limit_error"))?;
        let read = self.head.units().shown(kind, limit.abs().max(error));
        let (factor, unit) =
            read.map_or((1.0, String::new()), |DisplayUnit { factor, name }| (factor, format!(" {name}")));
        let text = with_limit(limit * factor, limit * factor, error * factor);
        Some(format!("{} {text}{unit}", name.replace('_', " ")))
    }

    /// Returns the component of a vector along the lateral displacement.
    pub fn along(&self, [x, y]: [f64; 2]) -> f64 {
        x * self.direction[0] + y * self.direction[1]
    }

    /// Returns true if the rigid surface moves sideways.
    pub fn moves_sideways(&self) -> bool {
        self.steps.iter().any(|step| step.vector("lateral") != self.steps[0].vector("lateral"))
    }

    /// Returns the stiffness and the friction of each leg with lateral motion, from the first state on.
    fn sliding(&self, places: &Places) -> Vec<Sliding> {
        let last = self.steps.len().saturating_sub(1);
        let waypoints: Vec<usize> = (0..=last).filter(|step| places.of(*step).is_some()).collect();
        let inside = waypoints.iter().copied().filter(|step| (1..last).contains(step));
        let bounds: Vec<usize> = [0].into_iter().chain(inside).chain((last > 0).then_some(last)).collect();
        let has_lengths =
            ["time", "distance"].iter().any(|name| self.steps.first().is_some_and(|step| step.value(name).is_some()));
        let leg = |bounds: &[usize]| {
            let leg = &self.steps[bounds[0]..=bounds[1]];
            let [moved, sheared] =
                ["lateral", "mean_shear"].map(|name| self.along(leg[1].vector(name)) - self.along(leg[0].vector(name)));
            let coefficient =
                |step: &Record| (self.along(step.vector("mean_shear")) / step.number("mean_pressure")).abs();
            (moved != 0.0).then(|| Sliding {
                leg: leg_number(bounds[1], &waypoints, has_lengths),
                tangential_stiffness: sheared / moved,
                friction_coefficient: leg[1..].iter().map(coefficient).fold(0.0, f64::max),
            })
        };
        bounds.windows(2).filter_map(leg).collect()
    }
}

/// Returns the lowest number of a column; NaN if one has no value.
fn lowest(steps: &[Record], name: &str) -> f64 {
    let numbers = || steps.iter().map(|step| step.number(name));
    if numbers().any(f64::is_nan) { f64::NAN } else { numbers().fold(f64::INFINITY, f64::min) }
}

/// Returns the sum of the errors of all losses; `None` if one is unknown.
fn error_of_losses(steps: &[Record]) -> Option<f64> {
    let mut lost = steps.iter().filter(|step| step.value("dissipated").is_some()).peekable();
    lost.peek()?;
    lost.map(|step| step.value("dissipated_error")).sum()
}

/// Returns the number of the step on a line of a table, blanks on the line of heads.
fn number(line: usize) -> String {
    format!("{:>5}", line.checked_sub(1).map_or_else(String::new, |step| step.to_string()))
}

/// Prints the table of the steps, one line per step.
fn print_steps(f: &mut fmt::Formatter<'_>, steps: &[Record], units: &Units) -> fmt::Result {
    let remark = |line: usize| {
        let Some(step) = line.checked_sub(1) else { return String::new() };
        let jumped = if steps[step].is("passed_instability") { "  jump" } else { "" };
        format!("{jumped}{}", if steps[step].is("converged") { "" } else { "  NOT CONVERGED" })
    };
    let sheet = |width| table_of(steps, &[Table::State, Table::Energy], units, width);
    print_sheet(f, sheet, steps.len(), number, remark)?;
    let jumped = steps.iter().any(|step| step.is("passed_instability"));
    if jumped { writeln!(f, "jump: the step passed an instability") } else { Ok(()) }
}

/// Prints a table of the measurements, one line per step, below the `title`, if there is one.
fn print_measured(
    f: &mut fmt::Formatter<'_>,
    (steps, units): (&[Record], &Units),
    table: Table,
    title: &str,
) -> fmt::Result {
    let columns = columns_of(steps, &[table], units);
    if columns.is_empty() {
        return Ok(());
    }
    write!(f, "\n{title}")?;
    print_sheet(f, |width| Sheet::of(columns, width), steps.len(), number, |_| String::new())?;
    legends(table, steps).into_iter().try_for_each(|legend| print_note(f, legend))
}

/// Columns of the table that may lack a value although others of their kind have one.
const TABLE: [&str; 6] =
    ["approach", "elastic_energy", "dissipated", "dissipated_error", "passed_instability", "stiffness"];

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        let read = |value: f64, kind: &str| self.head.read(value, kind, "");
        if let Some(hardness) = &self.head.hardness {
            let hardness = match hardness {
                GivenHardness::Number(number) => read(*number, "stress"),
                GivenHardness::Field(given) => given.to_string(),
            };
            writeln!(f, "hardness {hardness}; plastic: points at the hardness, depth: mean plastic depth so far\n")?;
        }
        if let Some(coefficient) = self.coefficient {
            writeln!(f, "wear coefficient {}; wear: mean depth lost so far\n", read(coefficient, "1/stress"))?;
        }
        print_steps(f, &self.steps, &self.head.units())?;
        if let Some(step) = self.parted_at {
            writeln!(f, "{step:>5}  the surfaces part")?;
        }
        let upper = if self.head.lower.is_some() { "upper face\n" } else { "" };
        for table in [Table::Patches, Table::Flow] {
            print_measured(f, (&self.steps, &self.head.units()), table, upper)?;
        }
        for leg in &self.sliding {
            let stiffness = self.head.units().shown("stress/length", leg.tangential_stiffness);
            writeln!(
                f,
                "leg {}: tangential stiffness {} at first, friction coefficient up to {:.6}",
                leg.leg,
                stiffness.map_or_else(
                    || format!("{:.4e}", leg.tangential_stiffness),
                    |unit| unit.text(leg.tangential_stiffness)
                ),
                leg.friction_coefficient
            )?;
        }
        if let Some(volume) = self.wear_volume {
            let last = |name: &str| self.steps.last().and_then(|step| step.value(name));
            let with_error = |volume: f64, error: Option<f64>| match error {
                Some(error) => format!("{} ± {}", read(volume, "length"), read(error, "length")),
                None => read(volume, "length"),
            };
            write!(f, "\nwear volume {} per area", with_error(volume, self.wear_volume_error.flatten()))?;
            // The numbers of a step belong to the upper face.
            match last("lower_wear_volume") {
                Some(below) => {
                    let below = with_error(below, last("lower_wear_volume_error"));
                    writeln!(f, " at the upper face, {below} at the lower")?;
                }
                None => writeln!(f)?,
            }
        }
        match (self.dissipated, self.dissipated_error) {
            (None, _) => write!(f, "\nno dissipated energy: the tractions have no energy")?,
            (Some(lost), None) => {
                let unit = if self.head.units().shown("stress*length", lost).is_some() { "" } else { " per area" };
                write!(f, "\ndissipated {}{unit}", read(lost, "stress*length"))?;
                if let Some(imbalance) = self.work_imbalance {
                    write!(f, " (imbalance of work and energy {})", read(imbalance, "stress*length"))?;
                }
            }
            (Some(lost), Some(error)) => {
                let digits = |factor: f64| with_limit(lost * factor, lost * factor, error * factor);
                match self.head.units().shown("stress*length", lost.abs().max(error)) {
                    Some(DisplayUnit { factor, name }) => write!(f, "\ndissipated {} {name}", digits(factor))?,
                    None => write!(f, "\ndissipated {} per area", digits(1.0))?,
                }
                let none = if error >= lost.abs() { "none within its error, " } else { "" };
                write!(f, " ({none}{} extra solves)", self.extra_solves)?;
            }
        }
        writeln!(f, ", lowest mean pressure {}", read(self.lowest_mean_pressure, "stress"))?;
        let fine = [("dissipated", "stress*length"), ("lowest_mean_pressure", "stress")];
        let fine: Vec<String> = fine.into_iter().filter_map(|(name, kind)| self.on_fine_grid(name, kind)).collect();
        if !fine.is_empty() {
            writeln!(f, "on an infinitely fine grid: {}", fine.join(", "))?;
        }
        let notes = lines(&self.steps, ["step", "steps"], |column| TABLE.contains(&column));
        notes.iter().try_for_each(|line| print_note(f, line))?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
