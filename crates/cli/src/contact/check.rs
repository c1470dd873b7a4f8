//! Check of a contact file.

use std::path::PathBuf;

use gfmd_contact::Load;
use gfmd_flow::Wanted;
use gfmd_law::LawKind;
use gfmd_record::{NOT_SOLVED, Record, StateContext, Statistics};

use super::{Args, Loads};
use crate::checking::{Checked, Checking, check_base, check_lower};
use crate::measuring::{Findings, Touching};
use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_check::statistics;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_run::series::Prepared;

impl Checked for Args {
    /// Recomputes every load of a file from its surface, body and pressure or gap: fields, residuals, area, energy.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|args: &Self| args.problem.boundary, comparison)?;
        let mut loads = Loads::new(&args, session)?;
        loads.prepared.take_units(reader);
        let Prepared { facts, lower, .. } = &loads.prepared;
        let others =
            [(args.problem.law.law != LawKind::HardWall, "/fields/gap"), (lower.is_some(), "/fields/lower_pressure")];
        let others = others.into_iter().filter_map(|(needed, field)| needed.then_some(field));
        let mut needed = ["/fields/pressure"].into_iter().chain(others);
        if let (Some(missing), true) = (needed.find(|needed| !reader.contains(needed)), args.fields.is_some()) {
            session.warn(
                "fields-missing",
                format!("the file has no {missing}, from which loads are recomputed; --rerun solves them"),
            );
            return Ok(());
        }
        check_base(reader, loads.prepared.lift(), comparison)?;
        check_lower(reader, lower.as_ref(), comparison);
        let contact = loads.prepared.pose(&args.problem.source, &loads.prepared.law)?;
        let stored = Stored::new(reader, &loads.prepared, &contact, args.problem.solver.search.tolerance)?;
        let (count, asked) = (stored.count(), loads.drives.len());
        if count != asked {
            comparison.differ("/loads/mean_pressure", format!("it has {count} loads; the configuration has {asked}"));
        }
        let (records, measured) = compare(&stored, (&args, &loads), comparison)?;
        let states = (&loads.prepared, asked, args.fields.clone().unwrap_or_default());
        checking.layout_of_states(states, comparison, |mut file| {
            if let (true, Some(archive)) = (facts.statistics, file.archive()) {
                statistics::write(archive, &loads.prepared, &measured)?;
            }
            file.finish(&records, asked, None)
        })
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}

/// Compares all loads with the states computed from their fields, then the statistics. Returns the records and the
/// statistics of the loads.
fn compare(
    stored: &Stored,
    (args, loads): (&Args, &Loads),
    comparison: &mut Comparison,
) -> Result<(Vec<Record>, Vec<Statistics>), Failure> {
    let (mut records, mut measured) = (Vec::new(), Vec::new());
    for (index, drive) in loads.drives.iter().enumerate().take(stored.count()) {
        let Some(state) = stored.state(index, *drive)? else { continue };
        stored.compare_fields(index, &state, comparison)?;
        let at = stored.at(index, &state);
        let stiffness = if at.has_converged() {
            args.problem.stiffness.of(stored.contact, &state, |_| {})
        } else {
            Err(NOT_SOLVED.into())
        };
        let at = StateContext { stiffness, ..at };
        let touching = Touching::with_fields(stored.contact_and_gap(index, Some(&state))?, &at);
        let surface = (&loads.prepared.surface, &loads.conducting);
        let findings = Findings::of(&args.measure, surface, &touching, Wanted::Conductivity, |_, _| {})?;
        let record = Record::of(&StateContext { measured: findings.borrowed(), ..at });
        measured.extend(findings.arrays);
        stored.compare_record(index, (&record, &state), comparison);
        if let Load::Approach(asked) = drive.load {
            comparison.number("/loads/approach", asked, record.number("approach"), 0.0);
        }
        records.push(record);
    }
    statistics::compare(stored.reader, &loads.prepared.facts, &measured, comparison)?;
    Ok((records, measured))
}
