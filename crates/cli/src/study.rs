//! `study`: many contacts in one file, the product of surfaces, seeds and bodies, each under all loads.

mod check;
mod config;
mod cube;
mod file;
mod inputs;
mod lists;
mod member;
mod report;
mod solve;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_check::study::{Cube, FAILED, SOLVED};
use gfmd_files::{Archive, Checksum, Output, target};
use gfmd_problem::key;
use gfmd_problem::options::Options;
use gfmd_problem::options::values::parsed;
use gfmd_run::parts::{self, Finished, Gathered, Journal, Merge, Work, remark};
use gfmd_sweep::{Shard, divide};
use rayon::prelude::*;
use serde::Deserialize;

pub(crate) use check::check;
pub use file::report_of;
pub(crate) use lists::words_of_study;
pub use report::{PlanReport, Report};

use crate::inputs::stay_in;
use crate::kappa_sweep::{Configured, ShardReport};
use crate::progress::Progress;
use config::StudyConfig;
use gfmd_input::failure::Failure;
use gfmd_input::memory::peak_bytes;
use gfmd_input::session::Session;
use member::Member;

/// Flags of `study`.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd study study.toml
  gfmd study study.toml --out scans.h5 --resume
  gfmd study study.toml --dry-run
  gfmd study study.toml --out scans.h5 --resume --shard 3/64
  gfmd study study.toml --out scans.h5 --merge

A study in TOML: the command and its options, and lists whose product is computed (docs/studies.md)
  command = \"contact\"
  [contact]
  n = 128
  p_star = [0.01, 0.03, 0.1]
  [study]
  seed = \"1:10\"
  body = [{ name = \"steel\", young = \"210GPa\" }, { name = \"brass\", young = \"100GPa\" }]")]
pub struct Args {
    /// Study in TOML: a command (contact, path or slide), its options, and lists of surfaces, seeds and bodies
    #[arg(value_name = "STUDY.toml", required = true)]
    pub config: Option<Configured>,
    /// Write the results to this file
    #[arg(long, default_value = "study.h5", value_name = "FILE.h5")]
    #[option(default = "study.h5".into())]
    pub out: PathBuf,
    /// Continue an interrupted or killed study
    #[arg(long)]
    pub resume: bool,
    /// Compute only shard K (from 0) of M, of about equal work, into a journal beside --out, without a result: any
    /// scheduler can start shards (docs/cluster.md)
    #[arg(long, value_name = "K/M", conflicts_with = "merge")]
    #[serde(deserialize_with = "parsed")]
    pub shard: Option<Shard>,
    /// Merge all journals of this study beside --out, compute missing members, and write the result
    #[arg(long)]
    pub merge: bool,
    /// Print the members; compute nothing
    #[arg(long)]
    pub dry_run: bool,
}

/// Output of the command.
pub enum Outcome {
    /// Result of a study, and the failure if members failed.
    Done(Box<Report>, Option<Failure>),
    /// Members of a shard, in its journal.
    Shard(ShardReport, Option<Failure>),
    /// Members of a study that is not computed.
    Planned(PlanReport),
}

/// Largest number of grid points of members that are computed side by side, one on each thread. On larger grids all
/// threads work on one member.
const SIDE_BY_SIDE: u64 = 512 * 512;

/// Ending of the name of a journal.
const JOURNAL: &str = ".journal";

/// Runs the command.
///
/// # Errors
/// Returns an error for an unusable study, if all members are refused, if a file cannot be written, or after an
/// interruption. Finished members are kept in the journal beside the output, which the message names.
pub fn run(args: &Args, session: &Session) -> Result<Outcome, Failure> {
    let Some(configured) = &args.config else { return Err(Failure::missing("config", "it must be a study")) };
    let (name, table) = configured.table()?;
    let config = StudyConfig::read(&name, table)?;
    for input in config.files() {
        let out = args.out.to_string_lossy().into_owned();
        stay_in(&[("out".to_owned(), out.into()), ("surface".to_owned(), input.into())].into_iter().collect())?;
    }
    config.check(&name)?;
    let work =
        Work { name: "study", config: config.text()?, parts: config.members(), refuse: Box::new(Member::refuse) };
    let study = Study { args, session, config, work };
    match args.shard {
        _ if args.dry_run => study.plan(),
        Some(shard) => study.compute_shard(shard),
        None if args.merge => study.merge(),
        None => study.compute(),
    }
}

/// Study that was asked for.
struct Study<'a> {
    args: &'a Args,
    session: &'a Session,
    config: StudyConfig,
    work: Work<Member>,
}

impl Study<'_> {
    /// Returns the shard of each member.
    fn divided(&self, count: usize) -> Vec<usize> {
        divide(&(0..self.config.members()).map(|member| self.config.points(member)).collect::<Vec<_>>(), count)
    }

    fn of_shard(&self, shard: Shard) -> Vec<usize> {
        let shards = self.divided(shard.count()).into_iter().enumerate();
        shards.filter(|(_, index)| *index == shard.index()).map(|(member, _)| member).collect()
    }

    /// Lists the members, without those that are finished in journals if they are to be merged.
    fn plan(&self) -> Result<Outcome, Failure> {
        let members = match self.args.shard {
            Some(shard) => self.of_shard(shard),
            None if self.args.merge => {
                let out = target(&self.args.out).map_err(|error| Failure::input(key("out"), error))?;
                self.work.missing(&Gathered::read(&out, &self.work, false)?.finished)
            }
            None => (0..self.config.members()).collect(),
        };
        Ok(Outcome::Planned(PlanReport::new(&self.config, &members, self.args.shard)))
    }

    fn open(&self, output: &Output) -> Result<(Journal, Finished<Member>), Failure> {
        let path = output.beside(JOURNAL);
        let (journal, finished) = Journal::open(&path, &self.work, self.args.resume || self.args.merge)?;
        check_inputs(&finished, &path)?;
        Ok((journal, finished))
    }

    fn compute(self) -> Result<Outcome, Failure> {
        let output = parts::claim(&self.args.out)?;
        self.work.check_finished(&output, self.args.resume, |_| true)?;
        let (journal, finished) = self.open(&output)?;
        let kept = parts::resumes(journal.path());
        self.conclude(&output, journal, finished, kept)
    }

    fn compute_shard(self, shard: Shard) -> Result<Outcome, Failure> {
        let members = self.of_shard(shard);
        let output = parts::claim_shard(&self.args.out, shard)?;
        let (journal, finished) = self.open(&output)?;
        let started = Instant::now();
        let path = journal.path().to_path_buf();
        let computed = self.members(&members, &journal, finished);
        let computed =
            computed.map_err(|failure| failure.with(remark("finished members", &path, parts::resumes(&path))))?;
        let report = ShardReport {
            shard: shard.to_string(),
            runs: members.len(),
            all_runs: self.work.parts,
            journal: path,
            seconds: started.elapsed().as_secs_f64(),
            peak_bytes: peak_bytes(),
        };
        Ok(Outcome::Shard(report, self.failure(&computed)))
    }

    fn merge(self) -> Result<Outcome, Failure> {
        let started = Instant::now();
        let output = parts::claim(&self.args.out)?;
        if !self.has_journals(&output)
            && let Some(cube) = file::stored(output.path(), &self.work.config)
        {
            tracing::info!("{} has all members; 0 are computed now", output.path().display());
            return Ok(self.done(&cube, output.path().to_path_buf(), started));
        }
        let Merge { finished, gathered, .. } = self.work.merge(&output, |count| self.divided(count), || None)?;
        check_inputs(&finished, output.path())?;
        let (journal, _) = self.open(&output)?;
        let outcome = self.conclude(&output, journal, finished, parts::merges(&output))?;
        gathered.remove();
        Ok(outcome)
    }

    /// Returns true if there is a journal of this study beside the output.
    fn has_journals(&self, output: &Output) -> bool {
        output.beside(JOURNAL).exists()
            || Gathered::read(output.path(), &self.work, false).map_or(true, |found| found.journals() > 0)
    }

    /// Computes the members that are not finished, and writes the result; `kept` names the place of the members if that
    /// fails.
    fn conclude(
        &self,
        output: &Output,
        journal: Journal,
        finished: Finished<Member>,
        kept: gfmd_problem::Words,
    ) -> Result<Outcome, Failure> {
        let started = Instant::now();
        let all: Vec<usize> = (0..self.config.members()).collect();
        let remarked = |failure: Failure| failure.with(remark("finished members", journal.path(), kept.clone()));
        let members = self.members(&all, &journal, finished).map_err(remarked)?;
        // Without a single number there is no result, and the study itself is at fault.
        if let Some((_, first)) = members.first_key_value()
            && members.values().all(|member| member.is_refused)
        {
            journal.remove();
            return Err(Failure::refused(format!("every member is refused: {}", first.error)));
        }
        let members: Vec<Member> = members.into_values().collect();
        let cube = cube::cube(&self.config, members);
        let write = || -> Result<PathBuf, Failure> {
            let mut archive = Archive::create(output, &self.session.provenance(self.work.config.clone()))?;
            archive.attribute("/", "seconds", started.elapsed().as_secs_f64())?;
            cube.write(&mut archive)?;
            Ok(archive.finish()?)
        };
        let path = write().map_err(|failure| failure.with(remark("all members", journal.path(), kept.clone())))?;
        journal.remove();
        Ok(self.done(&cube, path, started))
    }

    fn done(&self, cube: &Cube, path: PathBuf, started: Instant) -> Outcome {
        let failed: Vec<usize> = (0..cube.members()).filter(|member| !cube.errors[*member].is_empty()).collect();
        let failure = failed.first().map(|first| {
            let place = self.config.place(*first);
            let (count, all, error) = (failed.len(), cube.members(), &cube.errors[*first]);
            let members = if all == 1 { "member" } else { "members" };
            Failure::computation(format!("{count} of {all} {members} failed, first {place}: {error}"))
        });
        let report = Report::new(cube, path, started.elapsed().as_secs_f64(), peak_bytes());
        Outcome::Done(Box::new(report), failure)
    }

    fn failure(&self, members: &BTreeMap<usize, Member>) -> Option<Failure> {
        let mut failed = members.iter().filter(|(_, member)| !member.error.is_empty());
        let (first, member) = failed.next()?;
        let (count, all, place) = (1 + failed.count(), members.len(), self.config.place(*first));
        Some(Failure::computation(format!("{count} of {all} members failed, first {place}: {}", member.error)))
    }

    /// Computes the members of these numbers that are not finished, and keeps them in the journal. A member whose input
    /// is refused costs nothing and is not kept, so that it can be put right.
    fn members(
        &self,
        members: &[usize],
        journal: &Journal,
        finished: Finished<Member>,
    ) -> Result<BTreeMap<usize, Member>, Failure> {
        let work = |member: usize| self.config.points(member) as f64;
        let total = members.iter().map(|member| work(*member)).sum();
        let progress = Arc::new(Progress::of_sizes(self.session, "members", members.len(), total));
        let finished = Mutex::new(finished);
        // A member is silent, but its progress is a note on the progress of the study.
        let within = |place: &str| {
            let (progress, place) = (Arc::clone(&progress), place.to_owned());
            let shown = tracing::dispatcher::get_default(Clone::clone);
            self.session.within(move |reading| {
                tracing::dispatcher::with_default(&shown, || progress.advance(0.0, &format!("{place}: {reading}")));
            })
        };
        let one = |member: usize| -> Result<(usize, Member), Failure> {
            let place = self.config.place(member);
            let known = finished.lock().unwrap_or_else(std::sync::PoisonError::into_inner).remove(&member);
            let found = match known {
                Some(known) => known,
                None => {
                    if self.session.is_interrupted() {
                        return Err(Failure::interrupted(format!("interrupted before {place}")));
                    }
                    let found = solve::solve(self.config.command, self.config.table(member), &within(&place))
                        .map_err(|failure| failure.at(place.clone()))?;
                    if !found.is_refused {
                        journal.record(member, &found)?;
                    }
                    found
                }
            };
            let status = if found.error.is_empty() { SOLVED } else { FAILED };
            progress.advance(work(member), &format!("{place}: {status}"));
            Ok((member, found))
        };
        let (small, large): (Vec<usize>, Vec<usize>) =
            members.iter().partition(|member| self.config.points(**member) <= SIDE_BY_SIDE);
        let small = small.into_par_iter().map(one).collect::<Result<Vec<_>, Failure>>();
        let all = small.and_then(|mut all| {
            all.extend(large.into_iter().map(one).collect::<Result<Vec<_>, Failure>>()?);
            Ok(all.into_iter().collect())
        });
        progress.finish();
        all
    }
}

/// Refuses finished members whose input files have changed since.
fn check_inputs(finished: &Finished<Member>, journal: &std::path::Path) -> Result<(), Failure> {
    let mut sums: BTreeMap<&str, Option<String>> = BTreeMap::new();
    for (member, found) in finished {
        for (file, sum) in &found.files {
            let now = sums.entry(file).or_insert_with(|| Checksum::of_file(std::path::Path::new(file)).ok());
            if now.as_ref() != Some(sum) {
                let reason = format!(
                    "{file} has changed since member {member} was computed; it must be as it was, or delete the \
                     journals beside the output"
                );
                return Err(Failure::input(journal.display().to_string(), reason));
            }
        }
    }
    Ok(())
}
