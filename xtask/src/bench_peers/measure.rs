//! Measurement of one case: all contestants solve it and are judged, between two measurements of the yardstick.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

use super::Args;
use super::contestant::{Contestant, Place, Problem};
use super::judge::{Verdict, judge};
use super::process::ProgramFailure;
use super::python::{Environment, Yardstick};
use super::report::{Case, Entry, LEFT_OUT, Timing};
use super::solve::Solve;
use super::table::{in_words, median};
use super::tolerance::{MARGIN, loosest};

/// Largest grid with repeated solves, in points along a side.
const REPEATED: usize = 1024;

/// Total time in seconds, and largest number, of repeats of short solves.
const WORTHWHILE: f64 = 2.0;
const OFTEN: usize = 9;

/// Time in seconds above which a solve of a peer in the search for its tolerance also counts as a timing.
const LENGTHY: f64 = 20.0;

/// Factor by which a peer that finished within the limit before may exceed it.
const INDULGENCE: f64 = 5.0;

/// Approximate exponent of the time of a peer as a function of the points along a side.
const GROWTH: f64 = 3.0;

/// Result of a peer on a smaller grid.
#[derive(Clone, Copy)]
struct Known {
    points: usize,
    tolerance: f64,
    seconds: f64,
}

/// Key of surface and load without the grid: the bits of Hurst exponent and reduced pressure.
type LoadKey = [u64; 2];

pub(super) struct Bench<'a> {
    args: &'a Args,
    threads: Vec<usize>,
    environment: &'a Environment,
    session: &'a Session,
    contestants: Vec<Contestant>,
    known: HashMap<(String, LoadKey), Known>,
    /// Cases of an interrupted run.
    resumed: Vec<Case>,
}

/// Contestant that takes part in a case.
struct Starter {
    contestant: Contestant,
    /// Tolerance given to the solver.
    tolerance: f64,
    /// A solve on the first number of threads that need not be repeated.
    first: Option<Solve>,
    /// Iterations and transform pairs of this program, which must be equal in all solves.
    cost: Option<(Option<u64>, Option<f64>)>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(
        args: &'a Args,
        threads: Vec<usize>,
        environment: &'a Environment,
        session: &'a Session,
        resumed: Vec<Case>,
    ) -> Self {
        Self { args, threads, environment, session, contestants: args.contestants(), known: HashMap::new(), resumed }
    }

    /// Returns the case of an interrupted run. The tolerances of its peers become the first ones on larger grids.
    pub(super) fn finished(&mut self, problem: &Problem) -> Option<Case> {
        let case = self.resumed.iter().find(|case| case.is_of(problem, &self.threads))?.clone();
        for entry in case.timings.first().into_iter().flat_map(|timing| &timing.entries) {
            let known = Known { points: case.n, tolerance: entry.tolerance, seconds: entry.seconds };
            self.known.insert((entry.name.clone(), [case.hurst.to_bits(), case.p_star.to_bits()]), known);
        }
        Some(case)
    }

    fn most_threads(&self) -> usize {
        self.threads.iter().copied().max().unwrap_or(1)
    }

    /// Measures one problem. Peers that fail are left out, with a note.
    pub(super) fn case(&mut self, problem: &Problem, notes: &mut Vec<String>) -> Result<Case, Failure> {
        let name = format!("{0} x {0}, H = {1}, p* = {2}", problem.points, problem.hurst, problem.p_star);
        tracing::info!("{name}");
        let mut starters = Vec::new();
        for contestant in self.contestants.clone() {
            match &contestant {
                Contestant::Own(_) => starters.push(self.own(contestant, problem)?),
                Contestant::Peer(_) => match self.peer(&contestant, problem) {
                    Ok(starter) => starters.push(starter),
                    Err(ProgramFailure::Interrupted) => return Err(ProgramFailure::Interrupted.failure(&name)),
                    Err(ended) => {
                        let note = format!("{contestant}{LEFT_OUT}{name}: {}", ended.in_words());
                        tracing::warn!("{note}");
                        notes.push(note);
                    }
                },
            }
        }
        self.compare(problem, &name, starters)
    }

    /// Returns the settings of a solve with a time limit of `patience` times the limit of the user.
    fn place(&self, patience: f64) -> Place<'a> {
        let limit = Duration::from_secs_f64(patience * self.args.patience());
        Place { environment: self.environment, session: self.session, limit }
    }

    fn file(&self, contestant: &Contestant, threads: usize) -> PathBuf {
        contestant.pressure_file(self.environment.scratch(), threads)
    }

    /// Solves with this program and writes its pressure, once for all numbers of threads.
    fn own(&self, contestant: Contestant, problem: &Problem) -> Result<Starter, Failure> {
        let threads = self.most_threads();
        let file = self.file(&contestant, threads);
        let solve = contestant.solve(problem, self.args.tolerance, threads, Some(&file), self.place(1.0));
        let solve = solve.and_then(Solve::converged).map_err(|ended| ended.failure(&contestant.to_string()))?;
        let cost = Some((solve.iterations, solve.transform_pairs));
        Ok(Starter { contestant, tolerance: self.args.tolerance, first: None, cost })
    }

    /// Finds the loosest tolerance for which the result of a peer is certified.
    fn peer(&mut self, contestant: &Contestant, problem: &Problem) -> Result<Starter, ProgramFailure> {
        let key = (contestant.to_string(), [problem.hurst.to_bits(), problem.p_star.to_bits()]);
        let known = self.known.get(&key).copied();
        if let Some(known) = known {
            let expected = known.seconds * (problem.points as f64 / known.points as f64).powf(GROWTH);
            if expected > self.args.patience() {
                return Err(ProgramFailure::TooLong(Duration::from_secs_f64(self.args.patience())));
            }
        }
        let threads = if contestant.is_threaded(self.environment) { self.threads[0] } else { 1 };
        let file = self.file(contestant, threads);
        let reference = &self.contestants[0];
        let fields = BTreeMap::from([
            (reference.to_string(), self.file(reference, threads)),
            (contestant.to_string(), file.clone()),
        ]);
        let mut last = f64::NAN;
        let found = loosest(
            MARGIN * self.args.tolerance,
            known.map_or(self.args.tolerance, |known| known.tolerance),
            |tolerance| {
                let solve = contestant.solve(problem, tolerance, threads, Some(&file), self.place(1.0))?.converged()?;
                let verdicts = judge(problem, &fields, &reference.to_string(), self.environment, self.session)?;
                let residual = verdicts.get(&contestant.to_string()).map_or(f64::NAN, Verdict::worst);
                tracing::debug!(
                    "{contestant}: asked for {tolerance:.2e}, certified {residual:.2e}, {:.3} s",
                    solve.seconds
                );
                last = tolerance;
                Ok((residual, solve))
            },
        )?;
        let Some(found) = found else {
            return Err(ProgramFailure::Failed(format!(
                "it does not reach a certified residual of {:e}",
                self.args.tolerance
            )));
        };
        let seconds = found.solve.seconds;
        self.known.insert(key, Known { points: problem.points, tolerance: found.tolerance, seconds });
        let is_final = found.tolerance == last && self.repeats(problem) == 1 && seconds > LENGTHY;
        let first = is_final.then_some(found.solve);
        Ok(Starter { contestant: *contestant, tolerance: found.tolerance, first, cost: None })
    }

    fn repeats(&self, problem: &Problem) -> usize {
        if problem.points <= REPEATED { self.args.repeats } else { 1 }
    }

    fn is_lacking(&self, problem: &Problem, done: &[Solve]) -> bool {
        let seconds: f64 = done.iter().map(|solve| solve.seconds).sum();
        done.len() < self.repeats(problem) || (done.len() < OFTEN && seconds < WORTHWHILE)
    }

    /// Times all contestants in turns, so that other load on the machine affects all, and judges their results.
    fn compare(&self, problem: &Problem, name: &str, starters: Vec<Starter>) -> Result<Case, Failure> {
        let before = self.environment.yardstick(problem.points, &self.threads, self.session)?;
        let mut solves: Vec<BTreeMap<usize, Vec<Solve>>> = vec![BTreeMap::new(); starters.len()];
        for (starter, solves) in starters.iter().zip(&mut solves) {
            if let Some(first) = &starter.first {
                solves.insert(self.used(&starter.contestant, self.threads[0]), vec![first.clone()]);
            }
        }
        let mut lacking = true;
        while lacking {
            lacking = false;
            for (starter, solves) in starters.iter().zip(&mut solves) {
                let mut used: Vec<usize> = self.threads.iter().map(|t| self.used(&starter.contestant, *t)).collect();
                used.dedup();
                for threads in used {
                    let done = solves.entry(threads).or_default();
                    if self.is_lacking(problem, done) {
                        done.push(self.time(starter, problem, threads)?);
                        lacking = true;
                    }
                }
            }
        }
        let after = self.environment.yardstick(problem.points, &self.threads, self.session)?;
        let mut timings = Vec::new();
        for &threads in &self.threads {
            let (yardstick_seconds, processor_share) = yardstick(&before, &after, threads);
            let verdicts = self.verdicts(problem, name, &starters, threads)?;
            let mut entries: Vec<Entry> = Vec::new();
            for (starter, solves) in starters.iter().zip(&solves) {
                let used = self.used(&starter.contestant, threads);
                let Some(solves) = solves.get(&used) else { continue };
                let label = starter.contestant.to_string();
                let Some(verdict) = verdicts.get(&label) else { continue };
                let all_seconds: Vec<f64> = solves.iter().map(|solve| solve.seconds).collect();
                let seconds = median(&all_seconds);
                let ours = entries.first().map_or(seconds, |entry| entry.seconds);
                let last = &solves[solves.len() - 1];
                let entry = Entry {
                    name: label,
                    threads: used,
                    seconds,
                    all_seconds,
                    cost: seconds / yardstick_seconds,
                    slower: seconds / ours,
                    iterations: last.iterations,
                    transform_pairs: last.transform_pairs,
                    peak_bytes: last.peak_bytes,
                    own_bytes: last.peak_bytes.saturating_sub(last.baseline_bytes),
                    tolerance: starter.tolerance,
                    verdict: verdict.clone(),
                };
                tracing::info!("{}: {entry}", in_words(threads));
                entries.push(entry);
            }
            timings.push(Timing { threads, yardstick_seconds, processor_share, entries });
        }
        let Problem { points, hurst, p_star, mean_pressure, .. } = *problem;
        Ok(Case { n: points, hurst, p_star, mean_pressure, timings })
    }

    /// Returns the number of threads that a contestant uses if it may use `threads`.
    fn used(&self, contestant: &Contestant, threads: usize) -> usize {
        if contestant.is_threaded(self.environment) { threads } else { 1 }
    }

    fn time(&self, starter: &Starter, problem: &Problem, threads: usize) -> Result<Solve, Failure> {
        let contestant = &starter.contestant;
        let file = matches!(contestant, Contestant::Peer(_)).then(|| self.file(contestant, threads));
        let solve = contestant.solve(problem, starter.tolerance, threads, file.as_deref(), self.place(INDULGENCE));
        let solve = solve.and_then(Solve::converged).map_err(|ended| ended.failure(&contestant.to_string()))?;
        match starter.cost {
            Some(cost) if cost != (solve.iterations, solve.transform_pairs) => Err(Failure::computation(format!(
                "{contestant} on {threads} threads took {:?} iterations and {:?} pairs; they must be {:?} and {:?} as \
                 before",
                solve.iterations, solve.transform_pairs, cost.0, cost.1
            ))),
            _ => Ok(solve),
        }
    }

    /// Judges all contestants.
    ///
    /// # Errors
    /// A result that is not certified or does not agree with the first contestant.
    fn verdicts(
        &self,
        problem: &Problem,
        name: &str,
        starters: &[Starter],
        threads: usize,
    ) -> Result<BTreeMap<String, Verdict>, Failure> {
        let named = |starter: &Starter| {
            let contestant = &starter.contestant;
            (contestant.to_string(), self.file(contestant, self.used(contestant, threads)))
        };
        let fields = starters.iter().map(named).collect();
        let reference = self.contestants[0].to_string();
        let verdicts = judge(problem, &fields, &reference, self.environment, self.session);
        let verdicts = verdicts.map_err(|ended| ended.failure("the verdict"))?;
        for starter in starters {
            let contestant = starter.contestant.to_string();
            if !verdicts.contains_key(&contestant) {
                return Err(Failure::computation(format!("{contestant} at {name}: its pressure is no number")));
            }
        }
        for (contestant, verdict) in &verdicts {
            if let Some(objection) = verdict.objection(self.args.tolerance, problem.points) {
                let text = format!("{contestant} at {name}, {threads} threads, against {reference}: {objection}");
                return Err(Failure::computation(text));
            }
        }
        Ok(verdicts)
    }
}

/// Returns the median time of one pair over both measurements, and the smallest share of the processor.
fn yardstick(before: &[Yardstick], after: &[Yardstick], threads: usize) -> (f64, f64) {
    let looks = || before.iter().chain(after).filter(|look| look.threads == threads);
    let seconds: Vec<f64> = looks().flat_map(|look| look.seconds.iter().copied()).collect();
    (median(&seconds), looks().map(|look| look.share).fold(f64::INFINITY, f64::min))
}
