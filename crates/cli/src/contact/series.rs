//! The loads of one contact, solved in turn, each from the state of the one before.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gfmd_contact::{Equilibrium as _, Fields as _, Refusal, Resumable as _, SolveError, Stiffness};
use gfmd_files::contiguous;
use gfmd_flow::{Flow, FlowError};
use gfmd_measure::Scales;
use gfmd_problem::{NoStiffness, Posed, Rest};
use ndarray::{Array2, ArrayView2};

use super::file::{Chosen, ContactFile};
use super::report::Report;
use super::statistics::{Measured, not_calibrated, through};
use super::watching::Watching;
use super::whole::Whole;
use super::{Args, Prepared, figures, file};
use crate::convergence::{History, NotConverged};
use crate::failure::{Failure, reached};
use crate::figures::{Face, Scene, Shown, rough};
use crate::load::{LoadRecord, UNSOLVED};
use crate::progress::Progress;
use crate::resume::{Kept, Part};
use crate::session::Session;
use crate::trace::Tracer;

/// The results of the loads of one contact beside their scalars.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) loads: Vec<Measured>,
    /// The state of the last load.
    pub(super) flow: Option<Flow>,
}

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
            prepared: Prepared { surface, body, base, lower, hardness, conducting, controls, output, .. },
            contact,
            args,
            heights,
            session,
        } = *self;
        let budget = args.solver.budget();
        let provenance = session.provenance(config);
        let recording = args.recording(surface);
        let chosen = args.fields.clone().unwrap_or(Chosen::ALL);
        let create = || {
            let loads = controls.len();
            ContactFile::create(output.as_ref(), &provenance, surface, loads, recording, chosen.clone())
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
            let record = LoadRecord::measure(&state, &scales, budget.tolerance, started.elapsed().as_secs_f64());
            let stiffness = self.stiffness(index, &state, stopped.is_some());
            let mut record = record.bounded(surface.boundary, &surface.grid, body).stiff(stiffness);
            if args.statistics
                && let Some(warning) = conducting.measure(&state.repulsion(), &mut record)?
            {
                session.warn("conductance", format!("load {index}: {warning}"));
            }
            record.seconds = started.elapsed().as_secs_f64();
            self.gather(index, &state.repulsion().view(), &state.gap(), &mut record, &mut gathered, true)?;
            progress.advance(1.0, &format!("p* {:.3e}, area {:.4}", record.p_star, record.area_fraction));
            record.check(index)?;
            report.loads.push(record.clone());
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
                let fields = chosen.fields(recording, &state, lift);
                let fields = fields.iter().map(|field| contiguous(field)).collect();
                kept.add(&Part { text: record.to_toml()?, fields });
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
            let fields = if args.vtk.is_some() { file::fields(recording, state, lift) } else { Vec::new() };
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
            return Err(UNSOLVED);
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

    /// Measures what `--statistics` asks for and, of a load that is not kept, computes the flow.
    fn gather(
        &self,
        index: usize,
        repulsion: &ArrayView2<f64>,
        gap: &ArrayView2<f64>,
        record: &mut LoadRecord,
        gathered: &mut Gathered,
        is_new: bool,
    ) -> Result<(), Failure> {
        let Self { prepared: Prepared { surface, .. }, args, session, .. } = *self;
        if args.statistics || (args.flow && is_new) {
            // In contact are the points that are repelled.
            let repulsion = repulsion.mapv(|p| p.max(0.0));
            if args.statistics {
                gathered.loads.push(Measured::of(surface, repulsion.view(), *gap, record)?);
            }
            if args.flow && is_new {
                let found = match through(surface, repulsion.view(), *gap, record.mean_gap) {
                    Err(FlowError::NotConverged { state, .. }) => {
                        session
                            .warn("flow", format!("load {index}: the residual of the flow is {:.1e}", state.residual));
                        *state
                    }
                    found => {
                        found.map_err(|error| Failure::Computation(error.to_string()).at(&format!("load {index}")))?
                    }
                };
                let not_calibrated = not_calibrated(args, surface);
                record.set_flow(&found, surface.grid.len(), not_calibrated.as_deref());
                gathered.flow = Some(found);
            }
        }
        Ok(())
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
        let recording = self.args.recording(&self.prepared.surface);
        let places = self.args.fields.as_ref().unwrap_or(&Chosen::ALL).contact_and_gap(recording);
        for index in 0..kept.finished() {
            let Part { text, fields } = kept.part(index)?;
            let mut record: LoadRecord =
                toml::from_str(&text).map_err(|error| kept.unusable(index, error.message()))?;
            if let Some([repulsion, gap]) = places.and_then(|[p, g]| Some([fields.get(p)?, fields.get(g)?])) {
                let field = |values| ArrayView2::from_shape(shape, values);
                let unusable = |error: ndarray::ShapeError| kept.unusable(index, error.to_string());
                let (repulsion, gap) = (field(repulsion).map_err(unusable)?, field(gap).map_err(unusable)?);
                self.gather(index, &repulsion, &gap, &mut record, gathered, false)?;
            }
            report.loads.push(record);
            file.write_values(index, &fields)?;
            progress.advance(1.0, "kept");
        }
        let Some(index) = kept.finished().checked_sub(1) else { return Ok(None) };
        let load = self.prepared.controls[index];
        kept.state().map(|mut stored| stored.restore(|visitor| self.contact.restore(load.into(), visitor))).transpose()
    }
}
