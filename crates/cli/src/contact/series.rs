//! The loads of one contact, solved in turn, each from the state of the one before.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gfmd_contact::{Equilibrium as _, Fields as _, Refusal, Resumable as _, SolveError, Stiffness};
use gfmd_files::contiguous;
use gfmd_measure::Scales;
use gfmd_problem::{NoStiffness, Posed, Rest};
use gfmd_record::{At, NOT_SOLVED, Record};
use ndarray::{Array2, ArrayView2};

use super::file::ContactFile;
use super::report::Report;
use super::statistics::{Findings, Gathered, Measured};
use super::watching::Watching;
use super::whole::Whole;
use super::{Args, Prepared, figures, file};
use crate::convergence::{History, NotConverged};
use crate::failure::{Failure, reached};
use crate::figures::{Face, Scene, Shown, rough};
use crate::progress::Progress;
use crate::resume::{Kept, Part};
use crate::session::Session;
use crate::trace::Tracer;

/// The loads of one contact.
pub(super) struct Series<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) contact: &'a Posed,
    pub(super) args: &'a Args,
    /// Heights with the lift of a base that moves.
    pub(super) heights: &'a Array2<f64>,
    pub(super) session: &'a Session,
}

impl Series<'_> {
    /// Solves the loads that are not kept, and writes the file. Returns the failure of the last load. An interrupted run
    /// whose state is kept has no file.
    pub(super) fn solve(
        &self,
        report: &mut Report,
        mut kept: Option<&mut Kept>,
        config: String,
    ) -> Result<Option<Failure>, Failure> {
        let Self {
            prepared: Prepared { facts, surface, base, lower, hardness, controls, output, .. },
            contact,
            args,
            heights,
            session,
        } = *self;
        let budget = args.solver.budget();
        let provenance = session.provenance(config);
        let chosen = args.fields.clone().unwrap_or_default();
        let create = || {
            let loads = controls.len();
            ContactFile::create(output.as_ref(), &provenance, surface, loads, *facts, chosen.clone())
        };
        // All processes take part in writing; if the first one fails, all end.
        let mut file = args.out.as_ref().map(|_| session.agree(create())).transpose()?;
        if let (Some(file), Some(base)) = (&mut file, base) {
            session.agree(file.write_base(base, surface))?;
        }
        if let (Some(file), Some(lower)) = (&mut file, lower) {
            file.write_lower(lower)?;
        }
        if let Some(file) = &mut file {
            session.agree(file.write_hardness(hardness.as_ref(), surface))?;
        }
        let lift = base.as_ref().map(|base| &base.lift);
        let progress = Progress::new(&session.common, "loads", controls.len() as f64);
        let scales = Scales { contact_modulus: report.e_star, rms_gradient: report.rms_gradient };
        let mut gathered = Gathered::default();
        let mut last = match (&mut kept, &mut file) {
            (Some(kept), Some(file)) => self.recall(report, kept, file, &mut gathered, &progress)?,
            _ => None,
        };
        if last.is_none() {
            last = self.prepared.after_longer_ranges(args, heights, session)?;
        }
        let mut failure = None;
        for (index, load) in controls.iter().enumerate().skip(report.loads.len()) {
            let started = Instant::now();
            let mut watch = Watching {
                index,
                progress: &progress,
                session,
                history: History::default(),
                tracer: args.trace.tracer(&surface.grid, args.axes(surface))?,
                kept: kept.as_deref_mut(),
                closing: false,
                failed: None,
            };
            let press = contact.press(*load).solver(args.solver.solver).budget(budget).starting_from(last.as_ref());
            let solved = press.watch(&mut watch).solve();
            let Watching { history, tracer, failed, .. } = watch;
            failed.map_or(Ok(()), Err)?;
            report.history = tracer.map(Tracer::trace);
            if let (Err(SolveError::Refused(Refusal::Search(error))), true) = (&solved, args.dynamics.is_given()) {
                return Err(Failure::input("--dt, --damping", error));
            }
            let why = if let Err(SolveError::NotConverged { why, .. }) = &solved { Some(*why) } else { None };
            let (mut state, stopped) = match reached(solved) {
                // Numbers that this load alone makes too large; the loads before it stay.
                Err(refused) if index > 0 => {
                    failure = Some(Failure::Computation(refused.to_string()).at(&format!("load {index}")));
                    break;
                }
                other => other?,
            };
            let stiffness = self.stiffness(index, &state, stopped.is_some()).map_err(Into::into);
            let at = At { stiffness, ..At::in_scales(facts, &state, &scales, &surface.grid, budget.tolerance) };
            let warn = |code, text: String| session.warn(code, format!("load {index}: {text}"));
            let findings = {
                let repulsion = state.repulsion();
                Findings::of((args, self.prepared), [repulsion.view(), state.gap()], &at, warn)
            };
            let findings = findings.map_err(|failure| failure.at(&format!("load {index}")))?;
            let seconds = started.elapsed().as_secs_f64();
            let record = Record::of(&At { seconds, measured: findings.borrowed(), ..at });
            progress.advance(1.0, &told(&record));
            check_range(index, &record)?;
            report.loads.push(record.clone());
            gathered.loads.extend(findings.arrays);
            gathered.flow = findings.flow.or(gathered.flow.take());
            if let Some(why) = why {
                let unmet = NotConverged::new(index, &state, budget.tolerance, &why, history);
                unmet.tell("load");
                report.not_converged = Some(unmet);
            }
            if let Some(file) = &mut file {
                session.agree(file.write(index, &state, lift))?;
            }
            if let Some(stopped) = stopped {
                failure = Some(stopped.at(&format!("load {index}")));
                last = Some(state);
                break;
            }
            // The file of a series that is complete follows at once.
            let is_last = index + 1 == controls.len() && !args.flow_threshold;
            if let (Some(kept), false) = (&mut kept, is_last) {
                let fields = chosen.fields(facts, &state, lift);
                let fields = fields.iter().map(|field| contiguous(field)).collect();
                kept.add(&Part { text: line(&record)?, fields });
                kept.keep_state(|visitor| contact.keep(&mut state, visitor))?;
            }
            last = Some(state);
        }
        if failure.is_none() && args.flow_threshold {
            report.flow_threshold = Some(self.threshold(&scales, &progress)?);
        }
        progress.finish();
        if matches!(failure, Some(Failure::Interrupted(_))) && kept.is_some() {
            return Ok(failure);
        }
        report.warn_of_slopes(&self.prepared.facts, session);
        if let Some(file) = file {
            report.out = session.agree(self.finish(file, report, &gathered))?;
        }
        if let (None, Some(state), true) = (&failure, &last, args.plots.is_some() || args.vtk.is_some()) {
            let shown = Shown::of(state, lift, state.plastic_depth());
            let fields = if args.vtk.is_some() { file::fields(facts, state, lift) } else { Vec::new() };
            let whole = Whole::of(self.prepared, shown, fields);
            session.agree(whole.map_or(Ok(()), |whole| self.show(state, &whole, &gathered, report)))?;
        }
        Ok(failure)
    }

    /// Writes what was measured of all loads, and gives the file its name.
    fn finish(&self, mut file: ContactFile, report: &Report, gathered: &Gathered) -> Result<Option<PathBuf>, Failure> {
        let surface = &self.prepared.surface;
        file.write_statistics(surface, &gathered.loads)?;
        if let Some(found) = &report.flow_threshold {
            file.write_threshold(surface.unit(), found)?;
        }
        if let Some(history) = &report.history {
            file.write_history(history, surface.unit())?;
        }
        file.finish(&report.loads, self.prepared.controls.len(), report.not_converged.as_ref())
    }

    /// Writes the last load as a file of VTK and draws it, as far as this is asked for.
    fn show(&self, state: &Rest, whole: &Whole, gathered: &Gathered, report: &mut Report) -> Result<(), Failure> {
        if let Some(vtk) = &self.prepared.vtk {
            report.vtk = Some(vtk.write(&whole.surface, &whole.shown, &whole.fields, state.lateral())?);
        }
        if let Some(prefix) = &self.args.plots {
            report.plots = self.draw(prefix, report, state, whole, gathered)?;
        }
        Ok(())
    }

    /// Draws the last load, and what was measured of all.
    fn draw(
        &self,
        prefix: &Path,
        report: &Report,
        state: &Rest,
        Whole { surface, hardness, shown, .. }: &Whole,
        gathered: &Gathered,
    ) -> Result<Vec<PathBuf>, Failure> {
        let variance = self.prepared.pressure_variance(surface, self.args.components);
        let upper = Scene {
            shown,
            grid: &surface.grid,
            unit: surface.unit(),
            modulus: report.e_star,
            hardness: hardness.as_deref(),
            rigid: rough(surface.second.is_some()),
            face: Face::Upper,
        };
        let below = state.lower().map(Shown::below);
        let lower = below.as_ref().map(|shown| Scene { shown, face: Face::Lower, ..upper });
        let scenes: Vec<Scene> = [upper].into_iter().chain(lower).collect();
        let mut files = figures::draw(prefix, report, &scenes, variance)?;
        files.extend(figures::measured(prefix, report, surface, &state.repulsion().view(), gathered, variance)?);
        Ok(files)
    }

    /// The stiffness of a load that converged.
    fn stiffness(&self, index: usize, state: &Rest, stopped: bool) -> Result<Stiffness, &'static str> {
        if stopped {
            return Err(NOT_SOLVED);
        }
        match self.contact.stiffness(state) {
            Ok(stiffness) => Ok(stiffness),
            Err(NoStiffness::Undefined(reason)) => Err(reason),
            Err(NoStiffness::Inexact(reached, why)) => {
                self.session.warn("stiffness", format!("load {index}: {why}"));
                Ok(reached)
            }
        }
    }

    /// Takes over the loads that are kept; returns the state of the last one.
    fn recall(
        &self,
        report: &mut Report,
        kept: &mut Kept,
        file: &mut ContactFile,
        gathered: &mut Gathered,
        progress: &Progress,
    ) -> Result<Option<Rest>, Failure> {
        let shape = self.prepared.surface.grid.points();
        let places = self.args.fields.clone().unwrap_or_default().contact_and_gap(&self.prepared.facts);
        for index in 0..kept.finished() {
            let Part { text, fields } = kept.part(index)?;
            let record = Record::from_line(&self.prepared.facts, &text);
            report.loads.push(record.map_err(|error| kept.unusable(index, error.to_string()))?);
            let measured = places.filter(|_| self.args.statistics);
            if let Some([repulsion, gap]) = measured.and_then(|[p, g]| Some([fields.get(p)?, fields.get(g)?])) {
                let field = |values| ArrayView2::from_shape(shape, values);
                let unusable = |error: ndarray::ShapeError| kept.unusable(index, error.to_string());
                let (repulsion, gap) = (field(repulsion).map_err(unusable)?, field(gap).map_err(unusable)?);
                let repulsion = repulsion.mapv(|p| p.max(0.0));
                gathered.loads.push(Measured::of(&self.prepared.surface, repulsion.view(), gap)?.0);
            }
            file.write_values(index, &fields)?;
            progress.advance(1.0, "kept");
        }
        let Some(index) = kept.finished().checked_sub(1) else { return Ok(None) };
        let load = self.prepared.controls[index];
        kept.state().map(|mut stored| stored.restore(|visitor| self.contact.restore(load.into(), visitor))).transpose()
    }
}

/// A record as a line of progress.
fn told(record: &Record) -> String {
    format!("p* {:.3e}, area {:.4}", record.number("p_star"), record.number("area_fraction"))
}

/// A record as a line of a journal.
pub(super) fn line(record: &Record) -> Result<String, Failure> {
    record.to_line().map_err(|error| Failure::Computation(error.to_string()))
}

/// Refuses units in which a number of load `index` that converged is not finite.
fn check_range(index: usize, record: &Record) -> Result<(), Failure> {
    match record.overflow() {
        Some((name, found)) if record.is("converged") => Err(Failure::Computation(format!(
            "load {index}: {name} is {found}; it must be finite, which other units of stress or length make it"
        ))),
        _ => Ok(()),
    }
}
