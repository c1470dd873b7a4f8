//! Run of the program: common flags of all commands, interruption, and the machine.

use std::borrow::Cow;
use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_contact::{Contact, Progress, Refusal};
use gfmd_field::{Grid, Share};
use gfmd_files::legible::line;
use gfmd_files::{Memory, Output, Provenance, Topography, Warning, Warnings};
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::{MemoryNeed, Spelling, Words, Written, key};
use gfmd_vector::Ranks;
use ndarray::ArrayRef2;
use serde::Serialize;

use crate::failure::Failure;
use crate::memory::{self, Processes};
use crate::processes;

/// Commit that the program was built from; `unknown` if it is not known.
pub const GIT_COMMIT: &str = env!("GFMD_GIT_COMMIT");

/// Number of the journal format; a journal of another format cannot be continued.
const JOURNAL: u32 = 5;

/// Run of the program.
#[derive(Clone)]
pub struct Session {
    /// True if neither progress nor notes are shown.
    pub quiet: bool,
    /// True if reports are JSON, not tables.
    pub json: bool,
    /// True if tables have all their columns, whatever their width.
    pub wide: bool,
    interrupted: Arc<AtomicBool>,
    warnings: Warnings,
    /// Place of results that are kept in memory.
    memory: Option<Memory>,
    /// Processes that run the command together.
    ranks: Option<Arc<dyn Ranks>>,
    /// Number of these processes on this machine.
    here: usize,
    /// True if the process belongs to a caller that also holds other things in memory.
    is_embedded: bool,
    /// Spelling of options in texts for the user.
    spelling: Spelling,
    /// Command line that files record; `None` for the command line of the process.
    command: Option<String>,
    /// Progress of the run, for a caller that shows it.
    meter: Meter,
    /// Height map that was read before the flags were parsed.
    map: Arc<Mutex<Option<NamedMap>>>,
    /// Quantities of the options as they were written.
    written: Written,
}

/// Height map in a file, with the names of file and channel as given.
pub struct NamedMap {
    /// File.
    pub file: String,
    /// Channel; `None` for the default one.
    pub channel: Option<String>,
    /// Heights.
    pub topography: Topography,
}

/// Progress of a run, shared with a caller that shows it.
#[derive(Clone, Default)]
pub struct Meter {
    reading: Arc<Mutex<Reading>>,
    listener: Option<Listener>,
}

/// Function that is told of each new state of a run.
type Listener = Arc<dyn Fn(&Reading) + Send + Sync>;

/// State of a [`Meter`].
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reading {
    /// Pieces of the work, such as loads.
    pub pieces: String,
    /// Number of finished pieces.
    pub done: usize,
    /// Number of all pieces.
    pub count: usize,
    /// Finished share of the work, 0 to 1.
    pub share: f64,
    /// Note on the state of the work.
    pub note: String,
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pieces, done, count, note, .. } = self;
        write!(f, "{done} of {count} {pieces}{}{note}", if note.is_empty() { "" } else { ", " })
    }
}

impl Meter {
    /// Returns the state of the run.
    pub fn read(&self) -> Reading {
        self.reading.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Shows another state of the run, with a note in one line.
    pub fn show(&self, reading: Reading) {
        let reading = Reading { note: line(&reading.note), ..reading };
        if let Some(listener) = &self.listener {
            listener(&reading);
        }
        *self.reading.lock().unwrap_or_else(PoisonError::into_inner) = reading;
    }
}

impl Session {
    /// Creates a session of one process that prints nothing.
    pub fn silent() -> Self {
        let interrupted = Arc::new(AtomicBool::new(false));
        Self {
            quiet: true,
            json: true,
            wide: true,
            interrupted,
            warnings: Warnings::default(),
            memory: None,
            ranks: None,
            here: 1,
            is_embedded: false,
            spelling: Spelling::Flag,
            command: None,
            meter: Meter::default(),
            map: Arc::default(),
            written: Written::default(),
        }
    }

    /// Creates a session of the same processes that prints nothing.
    #[must_use]
    pub fn silenced(&self) -> Self {
        match &self.ranks {
            Some(ranks) => Self::silent().together(Arc::clone(ranks), self.here),
            None => Self::silent(),
        }
    }

    /// Creates a session that prints nothing, in the process of a caller that also holds other things in memory.
    pub fn embedded() -> Self {
        Self { is_embedded: true, spelling: Spelling::Argument, ..Self::silent() }
    }

    /// Creates a session that prints nothing, for one of several runs in a process. Files record the words of `command`
    /// as the command line; options are spelled as flags.
    pub fn beside_others(command: String) -> Self {
        Self { spelling: Spelling::Flag, command: Some(command), ..Self::embedded() }
    }

    /// Returns the meter that shows the progress of this run.
    pub fn meter(&self) -> &Meter {
        &self.meter
    }

    /// Returns a session for one of many runs within this one: it prints nothing, has its own warnings and no output in
    /// memory, and is interrupted with this one. Its progress is told to a `listener`.
    #[must_use]
    pub fn within(&self, listener: impl Fn(&Reading) + Send + Sync + 'static) -> Self {
        let (interrupted, is_embedded) = (Arc::clone(&self.interrupted), self.is_embedded);
        let meter = Meter { listener: Some(Arc::new(listener)), ..Meter::default() };
        Self { interrupted, is_embedded, meter, ..Self::silent() }
    }

    /// Returns the warnings of the run.
    pub fn warnings(&self) -> Vec<Warning> {
        self.warnings.list()
    }

    /// Returns the session with a height map that was read already. Only the first process keeps it, which reads alone.
    #[must_use]
    pub fn with_map(self, map: Option<NamedMap>) -> Self {
        Self { map: Arc::new(Mutex::new(map.filter(|_| self.is_first()))), ..self }
    }

    /// Returns the session with the quantities of its options as they were written.
    #[must_use]
    pub fn with_written(self, written: Written) -> Self {
        Self { written, ..self }
    }

    /// Returns a failure with the quantities of the options as they were written.
    pub fn as_written(&self, failure: Failure) -> Failure {
        failure.as_written(&self.written)
    }

    /// Takes the height map of a file and a channel, if it was read already. It is kept for one reader.
    pub fn take_map(&self, file: &ArrayOption, channel: Option<&str>) -> Option<Topography> {
        let mut map = self.map.lock().unwrap_or_else(PoisonError::into_inner);
        let found = map.take_if(|map| file.file() == Some(&map.file) && channel == map.channel.as_deref());
        found.map(|map| map.topography)
    }

    /// Refuses a problem on a grid that needs more memory than available; its `heights` are in memory already. Without
    /// a caller, all memory of the process counts as available, since the allocator keeps it.
    ///
    /// # Errors
    /// Returns an error, at all processes, if more memory is needed than available.
    pub fn fits(&self, need: MemoryNeed, grid: &Grid, heights: &ArrayRef2<f64>) -> Result<(), Failure> {
        let there = if self.is_embedded { 8 * heights.len() as u64 } else { memory::resident(self.processes()) };
        self.agree(memory::fits_with(there, need, "the grid", grid.points(), self.processes()))
    }

    /// Returns the session on several processes, with `here` of them on this machine.
    #[must_use]
    pub fn together(self, ranks: Arc<dyn Ranks>, here: usize) -> Self {
        Self { here: here.min(ranks.size()), ranks: Some(ranks), ..self }
    }

    /// Returns the processes that run this command together, if there are several.
    pub fn ranks(&self) -> Option<&Arc<dyn Ranks>> {
        self.ranks.as_ref()
    }

    /// Returns the numbers of processes that run this command together.
    pub fn processes(&self) -> Processes {
        let Some(ranks) = &self.ranks else { return Processes::ALONE };
        Processes { here: self.here, all: ranks.size() }
    }

    /// Returns the rows of a grid on this process; all rows if it is alone.
    ///
    /// # Errors
    /// Returns an error if there are more processes than can share the rows.
    pub fn share(&self, grid: &Grid) -> Result<Share, Refusal> {
        match &self.ranks {
            Some(ranks) => Contact::share(Arc::clone(ranks), grid),
            None => Ok(grid.whole()),
        }
    }

    /// Returns the largest of the numbers of all processes.
    pub fn largest(&self, own: u64) -> u64 {
        let Some(ranks) = &self.ranks else { return own };
        let mut all = vec![0; ranks.size()];
        ranks.gather(&[own], &mut all, &vec![1; ranks.size()]);
        all.into_iter().max().unwrap_or(own)
    }

    /// Returns true if this process prints, writes and draws: it is alone, or the first one.
    pub fn is_first(&self) -> bool {
        self.ranks.as_ref().is_none_or(|ranks| ranks.rank() == 0)
    }

    /// Returns the common outcome of a step that may fail on some of the processes only.
    ///
    /// # Errors
    /// Returns the first failure.
    pub fn agree<T>(&self, outcome: Result<T, Failure>) -> Result<T, Failure> {
        match &self.ranks {
            Some(ranks) => processes::agree(&**ranks, outcome),
            None => outcome,
        }
    }

    /// Returns the session with results in memory instead of files, as far as they came, also after an interruption.
    #[must_use]
    pub fn in_memory(self, memory: Memory) -> Self {
        Self { memory: Some(memory.limited(memory::available_bytes())), ..self }
    }

    /// Returns the output of a command: a place in memory, or the named file, if there is one.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn output(&self, named: Option<&PathBuf>) -> Result<Option<Output>, Failure> {
        match &self.memory {
            Some(memory) => Ok(Some(Output::memory(memory))),
            None => named.map(Output::claim).transpose().map_err(|error| Failure::input(key("out"), error)),
        }
    }

    /// Returns the written file; `None` in memory.
    pub fn written(&self, out: Option<PathBuf>) -> Option<PathBuf> {
        out.filter(|_| !self.is_in_memory())
    }

    /// Returns true if results go to memory, and nothing is kept to resume from.
    pub fn is_in_memory(&self) -> bool {
        self.memory.is_some()
    }

    /// Asks the run to stop, as Ctrl-C does. Returns true if it was asked before.
    pub fn interrupt(&self) -> bool {
        self.interrupted.swap(true, Ordering::Relaxed)
    }

    /// Returns true if the user asked to stop.
    pub fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Returns a watch that ends a search when the user asks to stop.
    pub fn stop(&self) -> impl FnMut(&Progress) -> ControlFlow<()> + '_ {
        |_| if self.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Warns the user: on stderr, in the JSON of the report, and in the files of the run. `code` is a short name that
    /// does not change (docs/interface.md).
    pub fn warn(&self, code: impl Into<Cow<'static, str>>, text: impl Into<Words>) {
        let text = line(&text.into().spelled(self.spelling()));
        tracing::warn!("{text}");
        self.note(code, text);
    }

    /// Records a warning like [`warn`](Self::warn), for a remark that the printed report contains itself.
    pub fn note(&self, code: impl Into<Cow<'static, str>>, text: String) {
        self.warnings.add(Warning { code: code.into(), text: line(&text) });
    }

    /// Returns the spelling of options in texts for the user.
    pub fn spelling(&self) -> Spelling {
        self.spelling
    }

    /// Returns the report of a command as one JSON object, with the warnings of the run.
    ///
    /// # Errors
    /// Returns an error if the report cannot be serialised.
    pub fn json(&self, report: &impl Serialize) -> Result<String, Failure> {
        #[derive(Serialize)]
        struct Remark {
            code: Cow<'static, str>,
            text: String,
        }
        #[derive(Serialize)]
        struct Whole<'a, R> {
            #[serde(flatten)]
            report: &'a R,
            warnings: Vec<Remark>,
        }
        let remark = |Warning { code, text }| Remark { code, text };
        let whole = Whole { report, warnings: self.warnings.list().into_iter().map(remark).collect() };
        crate::json::to_string(&whole).map_err(|error| Failure::computation(error.to_string()))
    }

    /// Returns the text that identifies a run by its version, its configuration and the checksum of its heights:
    /// another run cannot continue it.
    pub fn identity(&self, config: &str, heights: &str) -> String {
        let version = env!("CARGO_PKG_VERSION");
        format!("gfmd {version}, journal {JOURNAL}, heights {heights}\n{config}")
    }

    /// Returns the provenance of a file written now; `config` is the resolved configuration.
    pub fn provenance(&self, config: String) -> Provenance {
        Provenance {
            program: "gfmd".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            git_commit: GIT_COMMIT.into(),
            command: self.command.clone().unwrap_or_else(|| std::env::args().collect::<Vec<_>>().join(" ")),
            created: jiff::Timestamp::now().to_string(),
            config,
            machine: machine(),
            threads: rayon::current_num_threads(),
            warnings: self.warnings.clone(),
        }
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session")
            .field("quiet", &self.quiet)
            .field("is_first", &self.is_first())
            .finish_non_exhaustive()
    }
}

/// Returns the processor, the number of cores and the operating system in words.
pub fn machine() -> String {
    let about = if cfg!(target_os = "linux") { std::fs::read_to_string("/proc/cpuinfo").ok() } else { None };
    let processor = about.and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.into());
    format!("{processor}, {cores} cores, {}", std::env::consts::OS)
}
