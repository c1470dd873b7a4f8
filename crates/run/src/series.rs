//! States of one contact, each found from the previous one: loads of `contact`, steps of `path`.

mod file;
mod finer;
mod head;
mod layout;
mod prepared;
mod pressed;
mod slopes;
mod stiffness;
mod watching;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

use gfmd_contact::{Drive, Fields as _, Refusal, SolveError, Visit};
use gfmd_files::{Output, contiguous};
use gfmd_interface::{Path, Step};
use gfmd_problem::{AnyState, Posed, Sequence, Words};
use gfmd_record::{Record, RecordError, StateContext};

use crate::convergence::NotConverged;
use crate::progress::Progress;
use crate::resume::{FinishedStep, OwnRows, UnfinishedRun};
use crate::trace::Tracer;
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::processes::texts;
use gfmd_input::session::Session;

pub use file::{Chosen, StateFile};
pub use file::{Field, fields};
pub use finer::{Finer, at_same_place, beside, on_finer_grids, resolved, sources};
pub use head::is_normal;
pub use head::{Head, Lower};
pub use layout::SeriesLayout;
pub use prepared::{Asked, Prepared, check_drive, unit_of_load};
pub use pressed::ContactArgs;
pub use slopes::Slopes;
pub use stiffness::StiffnessArgs;
pub use watching::Watching;

/// Series of states.
pub struct Series<'a> {
    /// Input.
    pub prepared: &'a Prepared,
    /// Run that the series is part of.
    pub session: &'a Session,
    /// Drive of each state.
    pub drives: &'a [Drive],
    /// Largest residual of a state at rest.
    pub tolerance: f64,
    /// States that have fields in the file.
    pub places: Places,
    /// Fields of these states in the file.
    pub chosen: Chosen,
    /// True if the file is written right after the last state, which need not be kept.
    pub ends_with_file: bool,
}

/// Choice of the states of a series that have fields in its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Places {
    /// All states.
    All,
    /// States with these numbers, in ascending order.
    At(Vec<usize>),
}

impl Places {
    /// Returns the place of a state in the file, if it has one.
    pub fn of(&self, index: usize) -> Option<usize> {
        match self {
            Self::All => Some(index),
            Self::At(indices) => indices.binary_search(&index).ok(),
        }
    }

    /// Returns the number of states with a place, of `states` in total.
    pub fn count(&self, states: usize) -> usize {
        match self {
            Self::All => states,
            Self::At(indices) => indices.len(),
        }
    }
}

/// Receiver of the states of a series in a command.
pub trait StateHandler {
    /// Returns a recorder for the next search, if requested.
    fn tracer(&self) -> Result<Option<Tracer>, Failure> {
        Ok(None)
    }

    /// Takes the finished record of a search.
    fn traced(&mut self, _tracer: Tracer) {}

    /// Returns the failure for a refused first part.
    fn refused(&self, refusal: Refusal) -> Failure {
        refusal.into()
    }

    /// Makes the record of a state.
    fn record(&mut self, solved: SolvedState<'_>) -> Result<Record, Failure>;

    /// Returns what the file has of a state with a place in it beside its fields.
    fn further(&self, _state: &AnyState) -> Vec<OwnRows> {
        Vec::new()
    }

    /// Writes a piece of what [`further`](Self::further) returned: values of the field `number` from value `start` on.
    fn write_further(
        &self,
        _file: &mut StateFile,
        (_place, _number): (usize, usize),
        _start: usize,
        _values: &[f64],
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Takes over the fields of a kept part.
    fn recall(&mut self, _fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        Ok(())
    }

    /// Visits data that continues from part to part beside the state.
    fn keep(&mut self, _visitor: &mut dyn Visit) {}

    /// Restores what [`keep`](Self::keep) visited after the part `last`.
    ///
    /// # Errors
    /// Returns an error if the data do not make a state.
    fn resume(&mut self, _last: usize, _visitor: &mut dyn Visit) -> Result<(), Refusal> {
        Ok(())
    }
}

/// State that was reached.
pub struct SolvedState<'a> {
    /// Number of its part.
    pub index: usize,
    /// State.
    pub state: &'a AnyState,
    /// Step that led to the state.
    pub step: &'a Step,
    /// Numbers so far: without stiffness, measurements, step and time.
    pub at: StateContext<'a>,
    /// Start of the search.
    pub started: Instant,
    /// True if the search ended before the state was at rest.
    pub is_cut: bool,
}

/// Code of the warning of a contact that reaches the edge of its patch.
const PATCH_EDGE: &str = "patch-edge";

/// End of a series.
#[derive(Default)]
pub struct SeriesOutcome {
    /// Records of the parts so far.
    pub records: Vec<Record>,
    /// Failure of the last part.
    pub failure: Option<Failure>,
    /// Search that did not converge.
    pub not_converged: Option<NotConverged>,
    /// Step of a path at which the surfaces parted under their load.
    pub parted_at: Option<usize>,
}

impl SeriesOutcome {
    /// Returns true if the run can continue later from what is kept, and has no file yet.
    pub fn is_kept(&self, kept: Option<&UnfinishedRun>) -> bool {
        matches!(self.failure, Some(Failure::Interrupted(_))) && kept.is_some()
    }
}

impl Series<'_> {
    /// Creates the file of the series on all processes; `None` if it is not wanted.
    pub fn file<'a>(
        &self,
        output: Option<&'a Output>,
        config: String,
        is_wanted: bool,
    ) -> Result<Option<StateFile<'a>>, Failure> {
        let create = || {
            let (states, provenance) = (self.places.count(self.drives.len()), self.session.provenance(config));
            StateFile::of(output, &provenance, self.prepared, states, (self.chosen.clone(), self.session))
        };
        is_wanted.then(create).transpose()
    }

    /// Computes the parts that are not kept, one after the other, until one fails.
    pub fn run(
        &self,
        path: &mut Path<'_, Posed>,
        first: impl FnOnce() -> Result<Option<AnyState>, Failure>,
        (file, mut kept): (Option<&mut StateFile>, Option<&mut UnfinishedRun>),
        progress: &dyn Progress,
        handler: &mut dyn StateHandler,
    ) -> Result<SeriesOutcome, Failure> {
        let Self { prepared, session, drives, tolerance, .. } = *self;
        let (facts, base) = (&prepared.facts, prepared.base.as_ref());
        let part = SeriesLayout::of(facts).name;
        let (mut file, mut outcome, mut is_edge_warned) = (file, SeriesOutcome::default(), false);
        if let (Some(kept), Some(file)) = (&mut kept, &mut file) {
            outcome.records = self.recall(kept, file, path, progress, handler)?;
            is_edge_warned = session.warnings().iter().any(|warning| warning.code == PATCH_EDGE);
        }
        if outcome.records.is_empty() {
            path.start_from(first()?);
        }
        for (index, drive) in drives.iter().enumerate().skip(outcome.records.len()) {
            let (started, warned) = (Instant::now(), session.warnings().len());
            // Only a part with a single solve can continue in its middle.
            let is_single = facts.sequence == Sequence::Loads || facts.yields && path.solves_once();
            let copies = if is_single { kept.as_deref_mut() } else { None };
            let place = format!("{part} {index}");
            let mut watch = Watching::new(place.clone(), progress, session).with(handler.tracer()?, copies);
            let reached = path.step(*drive, &mut watch);
            let Watching { history, tracer, failed, .. } = watch;
            failed.map_or(Ok(()), Err)?;
            if let Some(tracer) = tracer {
                handler.traced(tracer);
            }
            let mut why = None;
            let (step, cut, stopped) = match reached {
                Ok(step) => (step, None, None),
                Err(SolveError::Refused(refusal)) if index == 0 => return Err(handler.refused(refusal)),
                // Numbers of this part alone are too large; earlier parts stay.
                Err(SolveError::Refused(refusal)) => {
                    outcome.failure = Some(Failure::computation(refusal.to_string()).at(&place));
                    break;
                }
                Err(SolveError::Detached { .. }) if facts.sequence == Sequence::Path => {
                    outcome.parted_at = Some(index);
                    break;
                }
                Err(SolveError::Interrupted { state }) => {
                    (Step::default(), Some(state), Some(Failure::interrupted("interrupted")))
                }
                Err(error) => {
                    let text = error.words(|stress| prepared.surface.units().words(stress, "stress"));
                    if let SolveError::NotConverged { why: found, .. } = &error {
                        why = Some(*found);
                    }
                    (Step::default(), error.into_state().map(Box::new), Some(Failure::computation(text)))
                }
            };
            let Some(state) = cut.as_deref().or(path.state()) else { break };
            let effort = if stopped.is_some() { state.effort() } else { step.effort };
            let step = Step { effort, ..step };
            let at = prepared.at(state, tolerance);
            if let (false, Some(warning)) = (is_edge_warned || stopped.is_some(), prepared.edge_warning(state)) {
                session.warn(PATCH_EDGE, format!("{place}: {warning}"));
                is_edge_warned = true;
            }
            let record =
                handler.record(SolvedState { index, state, step: &step, at, started, is_cut: stopped.is_some() })?;
            let record = self.shared(record)?;
            progress.advance(1.0, &progress_line(&record));
            check_range(&place, &record)?;
            if let Some(why) = why {
                let unmet = NotConverged::new(index, state, tolerance, &why, history, session.spelling());
                unmet.tell(part);
                outcome.not_converged = Some(unmet);
            }
            let place_in_file = self.places.of(index);
            let further = if place_in_file.is_some() { handler.further(state) } else { Vec::new() };
            if let (Some(file), Some(place)) = (&mut file, place_in_file) {
                session.agree(file.write(place, state, base))?;
                let mut written = Ok(());
                for (number, rows) in further.iter().enumerate() {
                    rows.to_first(|start, values| {
                        if written.is_ok() {
                            written = handler.write_further(file, (place, number), start, values);
                        }
                    });
                }
                session.agree(written)?;
            }
            if let (Some(kept), None, false) = (&mut kept, &stopped, index + 1 == drives.len() && self.ends_with_file) {
                let fields = if place_in_file.is_some() { self.chosen.fields(facts, state, base) } else { Vec::new() };
                let mut text = record.to_line().map_err(|error| Failure::computation(error.to_string()))?;
                text.extend(session.warnings()[warned..].iter().map(|warning| format!("\n{warning}")));
                let fields = fields.iter().map(|field| contiguous(field)).collect();
                kept.add(&FinishedStep { text, fields }, &further)?;
                kept.keep_state(|visitor| {
                    path.keep(visitor);
                    handler.keep(visitor);
                })?;
            }
            outcome.records.push(record);
            if let Some(stopped) = stopped {
                outcome.failure = Some(stopped.at(&place));
                break;
            }
        }
        Ok(outcome)
    }

    /// Returns the record of the first process, which alone measures whole fields, on all processes.
    fn shared(&self, record: Record) -> Result<Record, Failure> {
        let facts = &self.prepared.facts;
        let Some(ranks) = self.session.ranks().filter(|_| facts.statistics || facts.flow) else { return Ok(record) };
        let unusable = |error: RecordError| Failure::computation(error.to_string());
        let text = self.session.agree(record.to_line().map_err(unusable))?;
        Record::from_line(facts, &texts(&**ranks, &text).swap_remove(0)).map_err(unusable)
    }

    /// Takes over the kept parts, and continues the path from the last one.
    fn recall(
        &self,
        kept: &mut UnfinishedRun,
        file: &mut StateFile,
        path: &mut Path<'_, Posed>,
        progress: &dyn Progress,
        handler: &mut dyn StateHandler,
    ) -> Result<Vec<Record>, Failure> {
        let mut records = Vec::new();
        for index in 0..kept.finished() {
            let text = kept.text(index)?;
            let mut lines = text.lines();
            let record = Record::from_line(&self.prepared.facts, lines.next().unwrap_or_default());
            records.push(record.map_err(|error| kept.unusable(index, error.to_string()))?);
            for (code, text) in lines.filter_map(|warning| warning.split_once(": ")) {
                self.session.warn(code.to_owned(), text);
            }
            let place = self.places.of(index);
            if let (Some(place), false) = (place, self.prepared.surface.share.is_whole()) {
                let count = self.chosen.count(&self.prepared.facts);
                let written = kept.pieces(index, |field, start, values| match field.checked_sub(count) {
                    Some(number) => handler.write_further(file, (place, number), start, values),
                    None => file.write_piece((place, field), start, values),
                });
                self.session.agree(written)?;
                if self.prepared.facts.statistics {
                    // The first process measures the whole fields again.
                    let fields = if self.session.is_first() { kept.part(index)?.fields } else { Vec::new() };
                    let recalled = if self.session.is_first() { handler.recall(&fields) } else { Ok(()) };
                    self.session.agree(recalled)?;
                }
            } else if let Some(place) = place {
                let FinishedStep { fields, .. } = kept.part(index)?;
                handler.recall(&fields).map_err(|failure| match failure {
                    Failure::Input(reason) => kept.unusable(index, reason),
                    other => other,
                })?;
                file.write_values(place, &fields)?;
                let further = fields.get(self.chosen.count(&self.prepared.facts)..).unwrap_or_default();
                for (number, values) in further.iter().enumerate() {
                    handler.write_further(file, (place, number), 0, values)?;
                }
            }
            progress.advance(1.0, "kept");
        }
        let (Some(mut stored), Some(last)) = (kept.state(), kept.finished().checked_sub(1)) else {
            return Ok(records);
        };
        stored.restore(|visitor| {
            path.resume(self.drives[last], visitor)?;
            handler.resume(last, visitor)
        })?;
        Ok(records)
    }
}

/// Formats a record as a line of progress.
fn progress_line(record: &Record) -> String {
    format!("p* {:.3e}, area {:.4}", record.number("p_star"), record.number("area_fraction"))
}

/// Refuses units in which a number of a converged part is not finite.
fn check_range(place: &str, record: &Record) -> Result<(), Failure> {
    match record.overflow() {
        Some((name, found)) if record.is("converged") => Err(Failure::computation(format!(
            "{place}: {name} is {found}; it must be finite, which other units of stress or length make it"
        ))),
        _ => Ok(()),
    }
}

/// Runs a command that keeps its parts beside its output. After an interruption or an error, the kept parts are flushed
/// and named in the message. After the end of a run, only its output remains, as returned by `out`.
pub fn run_with_journal<R>(
    mut kept: Option<UnfinishedRun>,
    run: impl FnOnce(Option<&mut UnfinishedRun>) -> Result<Outcome<R>, Failure>,
    out: impl FnOnce(&R) -> Option<&PathBuf>,
) -> Result<Outcome<R>, Failure> {
    let outcome = run(kept.as_mut());
    if let (Err(_) | Ok(Outcome { failure: Some(Failure::Interrupted(_)), .. }), Some(kept)) = (&outcome, &mut kept) {
        // The failure itself is reported; a full disk keeps what it has.
        let _ = kept.flush();
    }
    let remark = kept.as_ref().map_or_else(Words::default, UnfinishedRun::remark);
    let Outcome { report, failure } = outcome.map_err(|failure| failure.with(remark.clone()))?;
    let written = out(&report).map_or_else(String::new, |out| format!("; kept in {}", out.display()));
    let failure = match (failure, kept) {
        (Some(interrupted @ Failure::Interrupted(_)), Some(_)) => Some(interrupted.with(remark)),
        (failure, kept) => {
            kept.into_iter().for_each(UnfinishedRun::remove);
            failure.map(|failure| failure.with(&written))
        }
    };
    Ok(Outcome { report, failure })
}
