//! Path of drives, followed step by step and kept.

use std::borrow::Cow;
use std::time::Duration;

use gfmd_contact::{Budget, Drive, Refusal, SolveError, Visit};
use gfmd_files::Output;
use gfmd_flow::Wanted;
use gfmd_interface::{Path, Quasistatic as _, Refinement, Step};
use gfmd_problem::{AnyState, Posed};
use gfmd_record::{NOT_SOLVED, OnFinerGrid, Record, StateContext};

use super::report::Report;
use super::strain;
use crate::measuring::{Conducting, Findings, Gathered, MeasureArgs, Touching, recalled};
use crate::progress::Progress;
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_report::figures::SceneFields;
use gfmd_run::resume::{OwnRows, ResumeArgs, UnfinishedRun};
use gfmd_run::series::{
    Asked, Chosen, Places, Prepared, Series, SeriesOutcome, SolvedState, StateFile, StateHandler, StiffnessArgs,
    at_same_place, beside, on_finer_grids, resolved, run_with_journal,
};

/// Input of a path, checked before the first solve.
pub(super) struct PathInput {
    pub(super) prepared: Prepared,
    pub(super) conducting: Conducting,
    pub(super) drives: Vec<Drive>,
    pub(super) places: Places,
    /// Output at the process that writes.
    pub(super) output: Option<Output>,
    /// True if there is an output, maybe of another process.
    pub(super) is_written: bool,
}

/// Settings for following a path.
pub(super) struct PathSettings<'a> {
    pub(super) asked: Asked<'a>,
    pub(super) measure: &'a MeasureArgs,
    /// Flag of its loads or approaches.
    pub(super) option: &'static str,
    pub(super) stiffness: StiffnessArgs,
    pub(super) resume: ResumeArgs,
    /// Time between two copies of a running step, if any are made.
    pub(super) checkpoint: Option<Duration>,
    pub(super) refinement: Refinement,
    /// Configuration stored in the file.
    pub(super) config: String,
}

/// Path after it was followed as far as possible.
pub(super) struct Followed<'a> {
    pub(super) contact: &'a Posed,
    /// Path at its last state.
    pub(super) path: Path<'a, Posed>,
    pub(super) outcome: SeriesOutcome,
    /// File without its scalars. An interrupted run with a kept state has none.
    pub(super) file: Option<StateFile<'a>>,
    /// Measurements at the waypoints.
    pub(super) gathered: Gathered,
    /// Fields of the step with the largest contact.
    pub(super) widest: Option<SceneFields>,
    /// Steps that further increments would change.
    pub(super) unsettled: Vec<(usize, Step)>,
}

impl PathInput {
    /// Follows the path and passes it to `end`, which makes the report.
    pub(super) fn run(
        &self,
        settings: &PathSettings,
        session: &Session,
        end: impl FnOnce(Followed) -> Result<Outcome<Report>, Failure>,
    ) -> Result<Outcome<Report>, Failure> {
        let Self { prepared, drives, output, is_written, .. } = self;
        let (budget, option) = (settings.asked.budget, settings.option);
        let contact = prepared.pose_with_warnings(&settings.asked, session)?;
        prepared.check_drives(&contact, drives, option, budget.tolerance)?;
        prepared.warn_about_drives(drives, option, session);
        let kept = if *is_written && !session.is_in_memory() {
            let place = (output.as_ref(), &prepared.surface.share);
            let identity = prepared.identity(&settings.config, session);
            Some(UnfinishedRun::open(place, identity, drives.len(), settings.resume, settings.checkpoint)?)
        } else {
            None
        };
        run_with_journal(
            kept,
            |kept| end(self.follow(&contact, settings, kept, session)?),
            |report| report.out.as_ref(),
        )
    }

    /// Computes the steps that are not kept.
    fn follow<'a>(
        &'a self,
        contact: &'a Posed,
        PathSettings { asked, measure, stiffness, refinement, config, .. }: &PathSettings,
        mut kept: Option<&mut UnfinishedRun>,
        session: &'a Session,
    ) -> Result<Followed<'a>, Failure> {
        let Self { prepared, conducting, drives, places, output, is_written } = self;
        let budget = asked.budget;
        let Budget { tolerance, .. } = budget;
        let mut path = Path::new(contact, budget, *refinement);
        let series = Series {
            prepared,
            session,
            drives,
            tolerance,
            places: places.clone(),
            chosen: Chosen::All,
            ends_with_file: true,
        };
        let mut file = series.file(output.as_ref(), config.clone(), *is_written)?;
        if let Some(file) = &mut file {
            strain::define_waypoints(file, prepared, places.count(drives.len()))?;
        }
        let progress = Progress::new(session, "steps", drives.len());
        let finer = on_finer_grids(asked, prepared, session)?;
        let finer = finer.iter().map(|(finer, contact)| {
            Ok(Beside {
                prepared: finer,
                contact,
                measure,
                conducting: Conducting::new(measure, finer, asked.solver)?,
                path: Path::new(contact, budget, *refinement),
                stiffness: *stiffness,
                rise: finer.highest() - prepared.highest(),
                ended: None,
            })
        });
        let mut log = Log {
            contact,
            drives,
            stiffness: *stiffness,
            finer: finer.collect::<Result<_, Failure>>()?,
            tolerance,
            session,
            prepared,
            measure,
            conducting,
            places,
            gathered: Gathered::default(),
            widest: None,
            unsettled: Vec::new(),
        };
        let kept_files = (file.as_mut(), kept.as_deref_mut());
        let outcome = series.run(&mut path, || Ok(None), kept_files, &progress, &mut log)?;
        progress.finish();
        let Log { gathered, widest, unsettled, .. } = log;
        let is_kept = outcome.is_kept(kept.as_deref());
        if !is_kept {
            prepared.warn_about_strain(outcome.records.iter().map(|step| step.number("approach")), session);
        }
        let (widest, file) = (widest.map(|(_, shown)| shown), file.filter(|_| !is_kept));
        Ok(Followed { contact, path, outcome, file, gathered, widest, unsettled })
    }
}

/// Largest number of bytes of a reason in a kept run; more are read from a damaged one alone.
const LONGEST_REASON: u64 = 1 << 16;

/// Path on a finer grid, beside the requested one.
struct Beside<'a> {
    prepared: &'a Prepared,
    contact: &'a Posed,
    measure: &'a MeasureArgs,
    conducting: Conducting,
    path: Path<'a, Posed>,
    stiffness: StiffnessArgs,
    /// Height of its highest point above the highest of the other grid, added to each approach.
    rise: f64,
    /// Reason why the path ended, once it has.
    ended: Option<String>,
}

impl Beside<'_> {
    /// Visits the last state of the path, or the reason why it ended.
    fn keep(&mut self, visitor: &mut dyn Visit) {
        match &self.ended {
            // No step follows.
            Some(reason) => {
                visitor.count(&mut (reason.len() as u64));
                reason.bytes().for_each(|byte| visitor.count(&mut byte.into()));
            }
            None => {
                visitor.count(&mut 0);
                self.path.keep(visitor);
            }
        }
    }

    /// Restores what [`keep`](Self::keep) visited after the step to a drive of the other grid.
    fn resume(&mut self, drive: Drive, visitor: &mut dyn Visit) -> Result<(), Refusal> {
        let mut length = 0;
        visitor.count(&mut length);
        if length == 0 {
            return self.path.resume(at_same_place(drive, self.rise), visitor);
        }
        let bytes = (0..length.min(LONGEST_REASON)).map(|_| {
            let mut byte = 0;
            visitor.count(&mut byte);
            byte as u8
        });
        self.ended = Some(String::from_utf8_lossy(&bytes.collect::<Vec<_>>()).into_owned());
        Ok(())
    }

    /// Returns the record of the step under a drive of the other grid.
    fn record(&mut self, drive: Drive, tolerance: f64, session: &Session) -> Result<OnFinerGrid, Failure> {
        if let Some(reason) = &self.ended {
            return Err(Failure::computation(reason.clone()));
        }
        let step =
            self.path.step(at_same_place(drive, self.rise), &mut session.stop()).map_err(|error| match error {
                SolveError::Interrupted { .. } => Failure::interrupted("interrupted"),
                error => {
                    let [nx, ny] = self.prepared.surface.grid.points();
                    let reason = format!("the grid of {nx} x {ny} points: {error}");
                    Failure::computation(self.ended.insert(reason).clone())
                }
            })?;
        let state = self.path.state().ok_or_else(|| Failure::computation(NOT_SOLVED))?;
        let reading = self.contact.reading(state);
        let at = resolved(self.prepared, state, tolerance);
        let at = at.stiff(self.contact, self.stiffness.stiffness_tolerance);
        let (surface, touching) = ((&self.prepared.surface, &self.conducting), Touching::of(state, &at));
        let findings = Findings::of(self.measure, surface, &touching, Wanted::Conductivity, |_, _| {})?;
        let (step, measured) = (Some((&step, reading)), findings.borrowed());
        Ok(OnFinerGrid::of(&StateContext { approach: reading.approach, step, measured, ..at }))
    }
}

/// State handler of a path: its records, its widest contact, its unsettled steps.
struct Log<'a> {
    contact: &'a Posed,
    drives: &'a [Drive],
    stiffness: StiffnessArgs,
    /// Paths on finer grids, beside the requested one.
    finer: Vec<Beside<'a>>,
    tolerance: f64,
    session: &'a Session,
    prepared: &'a Prepared,
    measure: &'a MeasureArgs,
    conducting: &'a Conducting,
    /// Waypoints.
    places: &'a Places,
    /// Measurements at the waypoints so far.
    gathered: Gathered,
    /// Largest contact area, and its fields; the last of several, as on the page.
    widest: Option<(f64, SceneFields)>,
    /// Steps that further increments would change.
    unsettled: Vec<(usize, Step)>,
}

impl StateHandler for Log<'_> {
    fn record(&mut self, solved: SolvedState<'_>) -> Result<Record, Failure> {
        let SolvedState { index, state, step, at, started, is_cut } = solved;
        let warn = |code, text: String| self.session.warn(code, format!("step {index}: {text}"));
        let stiffness = if is_cut {
            Err(NOT_SOLVED.into())
        } else {
            self.stiffness.of(self.contact, state, |text| warn("stiffness", text))
        };
        let at = StateContext { stiffness, ..at };
        let (surface, touching) = ((&self.prepared.surface, self.conducting), Touching::of(state, &at));
        let findings = Findings::of(self.measure, surface, &touching, Wanted::Conductivity, warn);
        let findings = self.session.agree(findings.map_err(|failure| failure.at(format!("step {index}"))))?;
        let measured = findings.borrowed();
        let (seconds, reading) = (started.elapsed().as_secs_f64(), self.contact.reading(state));
        let finer = self.finer.iter_mut().map(|finer| match is_cut {
            true => Ok(Err(NOT_SOLVED.to_owned())),
            false => beside(finer.record(self.drives[index], self.tolerance, self.session)),
        });
        let finer = finer.collect::<Result<_, Failure>>()?;
        let at = StateContext { approach: reading.approach, step: Some((step, reading)), finer, measured, ..at };
        let at = StateContext { seconds, ..at };
        let record = Record::of(&at);
        if step.is_unsettled {
            self.unsettled.push((index, *step));
        }
        let area = record.number("area_fraction");
        if self.widest.as_ref().is_none_or(|(most, _)| area >= *most) {
            self.widest = Some((area, SceneFields::of(state, self.prepared.lift(), state.plastic_depth())));
        }
        if self.places.of(index).is_some() {
            self.gathered.states.extend(findings.arrays);
        }
        Ok(record)
    }

    fn recall(&mut self, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        self.gathered.states.extend(recalled(self.prepared, &Chosen::All, fields)?);
        Ok(())
    }

    fn further(&self, state: &AnyState) -> Vec<OwnRows> {
        strain::at_waypoint(self.prepared, state)
    }

    fn write_further(
        &self,
        file: &mut StateFile,
        place: (usize, usize),
        start: usize,
        values: &[f64],
    ) -> Result<(), Failure> {
        strain::write_waypoint(file, self.prepared, place, (start, values))
    }

    fn keep(&mut self, visitor: &mut dyn Visit) {
        self.visit_widest(visitor);
        self.visit_unsettled(visitor);
        self.finer.iter_mut().for_each(|finer| finer.keep(visitor));
    }

    fn resume(&mut self, last: usize, visitor: &mut dyn Visit) -> Result<(), Refusal> {
        self.widest = Some((f64::NAN, SceneFields::zeros(self.prepared.surface.heights.len())));
        self.visit_widest(visitor);
        self.visit_unsettled(visitor);
        let drive = self.drives[last];
        self.finer.iter_mut().try_for_each(|finer| finer.resume(drive, visitor))
    }
}

impl Log<'_> {
    /// Visits what the warning says of the steps that further increments would change.
    fn visit_unsettled(&mut self, visitor: &mut dyn Visit) {
        let mut count = self.unsettled.len() as u64;
        visitor.count(&mut count);
        self.unsettled.resize(self.drives.len().min(count as usize), (0, Step::default()));
        for (index, step) in &mut self.unsettled {
            let (mut place, mut increments) = (*index as u64, step.increments);
            let mut change = step.change.unwrap_or(f64::NAN);
            visitor.count(&mut place);
            visitor.count(&mut increments);
            visitor.number(&mut change);
            let change = (!change.is_nan()).then_some(change);
            *step = Step { is_unsettled: true, increments, change, ..*step };
            *index = place as usize;
        }
    }

    /// Visits the largest contact area and its fields; before the first step there are none.
    fn visit_widest(&mut self, visitor: &mut dyn Visit) {
        if let Some((area, shown)) = &mut self.widest {
            let share = &self.prepared.surface.share;
            visitor.number(area);
            shown.fields_mut().into_iter().for_each(|field| visitor.rows(share, field));
        }
    }
}
