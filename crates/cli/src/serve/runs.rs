//! Contacts that the page has started. Each runs on its own pool of threads; two run at once, and the others wait in
//! their order.

use std::collections::{BTreeSet, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use gfmd_files::Reader;
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_record::{ARRAYS, Printed, Table, columns_of, lines};
use gfmd_unit::Units;
use ndarray::ArrayView2;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::form::{Answers, Pressed, words};
use super::map::{Map, Part};
use super::repeat;
use super::scans::Scan;
use crate::contact::{self, Report};
use crate::line::parsed;
use crate::report::write_page;

/// Number of contacts that run at once. More share the processor without ending earlier, and need more memory.
const AT_ONCE: usize = 2;

/// Largest number of contacts that wait.
const MOST_WAITING: usize = 64;

/// Stack of each thread of a run in bytes, as in the program.
const STACK: usize = 8 << 20;

/// Starts threads that no other request uses.
///
/// # Errors
/// Returns an error if they cannot be started.
pub(super) fn pool(threads: usize) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
    pool.map_err(|error| Failure::computation(format!("threads: {error}")))
}

/// Phase of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Phase {
    /// Another run must end first.
    Waiting,
    /// The contact is computed.
    Running,
    /// All loads are there.
    Done,
    /// The user stopped it, or the server ended.
    Stopped,
    /// It failed; loads that were finished are there.
    Failed,
}

/// Table of a result: its heads, then a row for each load.
#[derive(Clone, Debug, Serialize)]
struct Sheet {
    title: &'static str,
    columns: Vec<Vec<String>>,
}

impl Sheet {
    fn of(title: &'static str, columns: Vec<Printed>) -> Self {
        Self { title, columns: columns.into_iter().map(|column| column.cells).collect() }
    }
}

/// Result of a run.
#[derive(Clone, Debug, Default, Serialize)]
struct Found {
    /// Problem in words, as the terminal shows it.
    head: String,
    sheets: Vec<Sheet>,
    /// Meaning of signs, and reasons for numbers without a value.
    lines: Vec<String>,
    warnings: Vec<String>,
    loads: usize,
    fields: Vec<Field>,
    #[serde(skip)]
    units: Units,
    #[serde(skip)]
    size: [f64; 2],
    /// Names of the result file and its page, if they were written.
    file: Option<String>,
    page: Option<String>,
}

/// Field of a result.
#[derive(Clone, Debug, Serialize)]
struct Field {
    name: String,
    meaning: String,
    /// True if each load has its own.
    by_load: bool,
}

/// Run as the page sees it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct State {
    run: usize,
    name: String,
    phase: Phase,
    message: Option<String>,
    found: Option<Found>,
}

/// A contact that the page has started.
pub(super) struct Run {
    /// Result file.
    pub(super) file: PathBuf,
    /// Words of the command.
    line: Vec<String>,
    command: String,
    python: Result<String, String>,
    session: Session,
    state: Mutex<State>,
}

impl Run {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the file of the page about the result.
    pub(super) fn page(&self) -> PathBuf {
        self.file.with_extension("html")
    }

    /// Describes the run.
    pub(super) fn about(&self) -> serde_json::Value {
        let reading = self.session.meter().read();
        serde_json::json!({
            "state": *self.state(), "progress": reading, "command": self.command,
            "python": self.python.as_ref().ok(), "no_python": self.python.as_ref().err(),
        })
    }

    /// Asks the run to stop.
    pub(super) fn stop(&self) {
        self.session.interrupt();
        let mut state = self.state();
        if state.phase == Phase::Waiting {
            (state.phase, state.message) = (Phase::Stopped, Some("stopped before it began".into()));
        }
    }

    /// Computes the contact.
    fn compute(&self, args: &contact::Args, threads: usize) {
        let ended = catch_unwind(AssertUnwindSafe(|| pool(threads)?.install(|| self.solve(args))));
        let ended = ended.unwrap_or_else(|_| Err(Failure::computation("the run ended by a fault of the program")));
        let (found, failure) = match ended {
            Ok((found, failure)) => (Some(found), failure),
            Err(failure) => (None, Some(failure)),
        };
        let mut state = self.state();
        state.found = found;
        state.phase = match &failure {
            None => Phase::Done,
            Some(Failure::Interrupted(_)) => Phase::Stopped,
            Some(_) => Phase::Failed,
        };
        state.message = failure.map(|failure| failure.to_string());
    }

    fn solve(&self, args: &contact::Args) -> Result<(Found, Option<Failure>), Failure> {
        let Outcome { report, failure } = contact::run(args, &self.session)?;
        let mut found = Found::of(&report, &self.session)?;
        if report.out.is_some() {
            found.read(&self.file)?;
            found.file = name_of(&self.file);
            // A page that cannot be written does not take the result away.
            match write_page(&self.file, &self.page(), &self.session) {
                Ok(_) => found.page = name_of(&self.page()),
                Err(error) => found.warnings.push(error.to_string()),
            }
        }
        Ok((found, failure))
    }

    /// Returns a field of a load, or the heights, as a map or a part of it.
    ///
    /// # Errors
    /// Returns an error for another field or load, and for a file that cannot be read.
    pub(super) fn map(&self, field: &str, load: usize, part: Option<Part>) -> Result<Vec<u8>, Failure> {
        let (units, size, loads, known) = {
            let state = self.state();
            let found = state.found.as_ref().ok_or_else(|| Failure::refused("the run has no result"))?;
            let known = found.fields.iter().find(|known| known.name == field).cloned();
            (found.units.clone(), found.size, found.loads, known)
        };
        let known = known.ok_or_else(|| Failure::refused("the result has no such field"))?;
        if load >= loads {
            return Err(Failure::value("the load", load, format!("below {loads}")));
        }
        let reader = Reader::open(&self.file).map_err(|error| Failure::refused(error.to_string()))?;
        let failed = |error: gfmd_files::FileError| Failure::refused(error.to_string());
        let path = if known.by_load { format!("/fields/{field}") } else { HEIGHTS.into() };
        let shape = reader.shape(&path).map_err(failed)?;
        let values = if known.by_load { reader.slab(&path, load) } else { reader.values(&path) }.map_err(failed)?;
        let shape = if known.by_load { &shape[1..] } else { &shape[..] };
        let points = [shape.first().copied().unwrap_or(0), shape.get(1).copied().unwrap_or(1)];
        let values: ArrayView2<'_, f64> = ArrayView2::from_shape(points, &values)
            .map_err(|error| Failure::computation(format!("{path}: {error}")))?;
        let kind = ARRAYS.iter().find(|array| array.name == field).map_or("length", |array| array.unit);
        Ok(Map { values, size, kind, meaning: &known.meaning }.bytes(&units, part))
    }
}

/// Heights in a result file.
const HEIGHTS: &str = "/surface/height";

fn name_of(path: &Path) -> Option<String> {
    path.file_name().map(|name| name.to_string_lossy().into_owned())
}

impl Found {
    fn of(report: &Report, session: &Session) -> Result<Self, Failure> {
        let units = report.head.units();
        let sheets = [
            ("Loads", &[Table::State][..]),
            ("Lower face", &[Table::LowerFace]),
            ("Patches and conductance", &[Table::Patches]),
            ("Flow", &[Table::Flow]),
        ];
        let sheets = sheets.map(|(title, tables)| Sheet::of(title, columns_of(&report.loads, tables, &units)));
        let whole: serde_json::Value =
            serde_json::from_str(&session.json(report)?).map_err(|error| Failure::computation(error.to_string()))?;
        let warnings = whole["warnings"].as_array().into_iter().flatten();
        Ok(Self {
            head: report.head.to_string(),
            sheets: sheets.into_iter().filter(|sheet| !sheet.columns.is_empty()).collect(),
            lines: lines(&report.loads, ["load", "loads"], |_| true),
            warnings: warnings.filter_map(|warning| warning["text"].as_str()).map(str::to_owned).collect(),
            loads: report.loads.len(),
            size: report.head.size,
            units,
            ..Self::default()
        })
    }

    /// Lists the fields of the result file.
    fn read(&mut self, file: &Path) -> Result<(), Failure> {
        let reader = Reader::open(file).map_err(|error| Failure::refused(error.to_string()))?;
        let meaning = |path: &str| reader.text(path, "long_name").unwrap_or_default();
        let stored = reader.names("/fields");
        let known = ARRAYS.iter().map(|array| array.name).filter(|name| stored.iter().any(|stored| stored == name));
        let mut seen: Vec<&str> = Vec::new();
        for name in known {
            if !seen.contains(&name) {
                seen.push(name);
            }
        }
        self.fields = seen
            .into_iter()
            .map(|name| Field { meaning: meaning(&format!("/fields/{name}")), name: name.into(), by_load: true })
            .chain([Field { name: "height".into(), meaning: meaning(HEIGHTS), by_load: false }])
            .collect();
        Ok(())
    }
}

/// The runs, by their numbers, and their queue.
pub(super) struct Runs {
    threads: usize,
    /// Result files of all runs, also of those that have not written them.
    names: Mutex<BTreeSet<PathBuf>>,
    queue: Mutex<Queue>,
    /// Tells that a run has ended.
    freed: Condvar,
}

#[derive(Default)]
struct Queue {
    all: Vec<Arc<Run>>,
    waiting: VecDeque<(Arc<Run>, Box<contact::Args>)>,
    running: usize,
    /// True if the server ends.
    closed: bool,
}

impl Queue {
    /// Returns an error if no other run may wait.
    fn check_open(&self) -> Result<(), Failure> {
        if self.closed {
            return Err(Failure::refused("the server ends"));
        }
        let count = self.waiting.len();
        if count >= MOST_WAITING {
            return Err(Failure::value("the number of waiting runs", count, format!("below {MOST_WAITING}")));
        }
        Ok(())
    }
}

/// Returns the contact that a line of words asks for, and its session.
fn contact_of(line: &[String]) -> Result<(Box<contact::Args>, Session), Failure> {
    let (Pressed::Contact(args), session) = parsed(line)? else {
        return Err(Failure::refused("the words name another command"));
    };
    Ok((args, session))
}

impl Runs {
    /// Creates the queue; each run has this number of threads.
    pub(super) fn new(threads: usize) -> Self {
        Self { threads, names: Mutex::default(), queue: Mutex::default(), freed: Condvar::new() }
    }

    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the contact of a scan with these answers, at once or after others.
    ///
    /// # Errors
    /// Returns an error if the options cannot be used, too many contacts wait, or the server ends.
    pub(super) fn start(self: &Arc<Self>, scan: &Scan, answers: &Answers, folder: &Path) -> Result<usize, Failure> {
        let mut line = vec!["gfmd".to_owned(), "contact".to_owned(), format!("--surface={}", scan.word())];
        line.extend(words("contact", answers)?);
        let file = self.free_name(folder, &scan.name());
        line.push(format!("--out={}", file.to_string_lossy()));
        let (args, session) = contact_of(&line)?;
        let mut queue = self.queue();
        queue.check_open()?;
        let run = queue.all.len();
        let name = file.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let state = Mutex::new(State { run, name, phase: Phase::Waiting, message: None, found: None });
        let command = repeat::command_line(&line);
        let python = repeat::python(&scan.word(), &file.to_string_lossy(), answers);
        let started = Arc::new(Run { file, line, command, python, session, state });
        queue.all.push(Arc::clone(&started));
        queue.waiting.push_back((started, args));
        self.advance(&mut queue);
        Ok(run)
    }

    /// Continues a stopped run after its finished loads, at once or after others.
    ///
    /// # Errors
    /// Returns an error for another run, if too many contacts wait, or the server ends.
    pub(super) fn resume(self: &Arc<Self>, run: usize) -> Result<(), Failure> {
        let mut queue = self.queue();
        queue.check_open()?;
        let stopped = queue.all.get_mut(run).filter(|stopped| stopped.state().phase == Phase::Stopped);
        let stopped = stopped.ok_or_else(|| Failure::refused("the run has not stopped"))?;
        let (args, session) = contact_of(&[&stopped.line[..], &["--resume".to_owned()]].concat())?;
        let state = State { phase: Phase::Waiting, message: None, found: None, ..stopped.state().clone() };
        let Run { file, line, command, python, .. } = &**stopped;
        let (file, line, command, python) = (file.clone(), line.clone(), command.clone(), python.clone());
        let resumed = Arc::new(Run { file, line, command, python, session, state: Mutex::new(state) });
        *stopped = Arc::clone(&resumed);
        queue.waiting.push_back((resumed, args));
        self.advance(&mut queue);
        Ok(())
    }

    /// Starts waiting runs while fewer than allowed run.
    fn advance(self: &Arc<Self>, queue: &mut Queue) {
        while queue.running < AT_ONCE && !queue.closed {
            let Some((run, args)) = queue.waiting.pop_front() else { return };
            {
                let mut state = run.state();
                if state.phase != Phase::Waiting {
                    continue;
                }
                state.phase = Phase::Running;
            }
            let (runs, started) = (Arc::clone(self), Arc::clone(&run));
            let work = move || {
                started.compute(&args, runs.threads);
                let mut queue = runs.queue();
                queue.running -= 1;
                runs.advance(&mut queue);
                drop(queue);
                runs.freed.notify_all();
            };
            match std::thread::Builder::new().name("run".into()).spawn(work) {
                Ok(_) => queue.running += 1,
                Err(error) => {
                    let mut state = run.state();
                    (state.phase, state.message) = (Phase::Failed, Some(format!("threads: {error}")));
                }
            }
        }
    }

    /// Returns the run of a number.
    pub(super) fn get(&self, run: usize) -> Option<Arc<Run>> {
        self.queue().all.get(run).cloned()
    }

    /// Returns all runs, the latest first.
    pub(super) fn all(&self) -> Vec<Arc<Run>> {
        self.queue().all.iter().rev().cloned().collect()
    }

    /// Takes a name for a result that neither another run nor a file of the folder has.
    fn free_name(&self, folder: &Path, scan: &str) -> PathBuf {
        let mut names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        let stem = scan.rsplit_once('.').map_or(scan, |(stem, _)| stem);
        let file = |count: u64| folder.join(format!("{stem}-contact-{count}.h5"));
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let there: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        // A stopped run has left a journal, and no result.
        let is_beside = |file: &Path| {
            let stem = format!("{}.", file.file_stem().unwrap_or_default().to_string_lossy());
            there.iter().any(|name| name.starts_with(&stem))
        };
        let is_free = |file: &PathBuf| !names.contains(file) && !is_beside(file);
        let file = (1..).map(file).find(is_free).unwrap_or_else(|| file(0));
        names.insert(file.clone());
        file
    }

    /// Stops all runs and waits for their ends.
    pub(super) fn end(&self) {
        let mut queue = self.queue();
        queue.closed = true;
        queue.all.iter().for_each(|run| run.stop());
        while queue.running > 0 {
            queue = self.freed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }
}
