//! Work without the interpreter lock: it runs in a thread pool, while the calling thread waits for signals.

use std::collections::HashMap;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use gfmd_input::session::Reading;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::failure::{panicked, refused};

/// Time between two checks for signals.
const PAUSE: Duration = Duration::from_millis(50);

/// Largest number of threads of a pool.
const MOST_THREADS: usize = 4096;

/// State shared by the work and the waiting thread.
#[derive(Default)]
pub(crate) struct Shared {
    stop: AtomicBool,
    iteration: AtomicU64,
    residual: AtomicU64,
    reading: Mutex<Reading>,
}

impl Shared {
    /// Reports the progress of a search and returns whether to continue.
    pub(crate) fn see(&self, iteration: u64, residual: f64) -> ControlFlow<()> {
        self.iteration.store(iteration, Ordering::Relaxed);
        self.residual.store(residual.to_bits(), Ordering::Relaxed);
        self.go_on()
    }

    /// Reports the progress of a command and returns whether to continue.
    pub(crate) fn show(&self, reading: Reading) -> ControlFlow<()> {
        *self.reading.lock().unwrap_or_else(PoisonError::into_inner) = reading;
        self.go_on()
    }

    fn go_on(&self) -> ControlFlow<()> {
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Process ID, and the pools of the process that are not in exclusive use, by number of threads.
type Pools = (u32, HashMap<usize, Vec<Arc<ThreadPool>>>);

/// Pools of this process. A forked process has none of the threads of its parent and makes its own pools.
static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Returns a pool for one piece of work. Pools of several threads are shared; each pool of one thread is exclusive, so
/// that work from several Python threads runs in parallel.
fn pool(threads: usize) -> Result<Arc<ThreadPool>, String> {
    if threads > MOST_THREADS {
        return Err(format!("threads is {threads}; it must be between 0 (all cores) and {MOST_THREADS}"));
    }
    let mut guard = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if guard.as_ref().is_some_and(|(owner, _)| *owner != process) {
        // Dropping the pools of the parent would wake threads that do not exist.
        std::mem::forget(guard.take());
    }
    let (_, pools) = guard.get_or_insert_with(|| (process, HashMap::new()));
    let free = pools.entry(threads).or_default();
    if let Some(pool) = if threads == 1 { free.pop() } else { free.first().cloned() } {
        return Ok(pool);
    }
    let made = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| format!("threads: {error}"))?;
    let made = Arc::new(made);
    if threads != 1 {
        free.push(Arc::clone(&made));
    }
    Ok(made)
}

/// Returns a single-thread pool for reuse.
fn give_back(threads: usize, pool: Arc<ThreadPool>) {
    let mut guard = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    match guard.as_mut() {
        Some((owner, pools)) if threads == 1 && *owner == std::process::id() => {
            pools.entry(threads).or_default().push(pool);
        }
        _ => {}
    }
}

/// Runs `work` in `threads` threads (0: all cores) without the interpreter lock. Several times a second, signals are
/// handled and `tick(note, done, count)` is called, with the numbers of finished and all pieces of a command, 0 of a
/// search. An exception of either asks the work to stop, and is returned beside the result.
///
/// # Errors
/// Returns an error if the threads cannot be started or the work panics.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    threads: usize,
    tick: Option<&Py<PyAny>>,
    work: impl FnOnce(&Shared) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let pool = pool(threads).map_err(|error| refused(py, &error))?;
    let notes = Notes::default();
    let listener = notes.listener();
    let (result, raised) = py.detach(|| {
        std::thread::scope(|scope| {
            let shared = Arc::new(Shared::default());
            let (done, wait) = channel::<()>();
            let worker = {
                let (shared, pool) = (Arc::clone(&shared), &pool);
                scope.spawn(move || {
                    let result = pool.install(|| tracing::subscriber::with_default(listener, || work(&shared)));
                    drop(done);
                    result
                })
            };
            let mut raised = None;
            while wait.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none() {
                    raised = Python::attach(|py| look(py, tick, &shared)).err();
                    shared.stop.store(raised.is_some(), Ordering::Relaxed);
                }
            }
            (worker.join(), raised)
        })
    });
    give_back(threads, pool);
    notes.warn(py)?;
    match result {
        Ok(value) => Ok((value, raised)),
        Err(payload) => Err(panicked(py, &*payload)),
    }
}

/// Warnings of the libraries during a computation.
#[derive(Clone, Default)]
struct Notes(Arc<Mutex<Vec<u8>>>);

impl Notes {
    fn listener(&self) -> impl tracing::Subscriber + Send + Sync + 'static {
        let notes = self.clone();
        let listener =
            tracing_subscriber::fmt().with_max_level(tracing::Level::WARN).with_writer(move || notes.clone());
        listener.without_time().with_target(false).with_level(false).with_ansi(false).finish()
    }

    /// Issues the notes as Python warnings, which a user may have turned into exceptions.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let text = std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner));
        if text.is_empty() {
            return Ok(());
        }
        py.import("gfmd._errors")?.call_method1("warned", (String::from_utf8_lossy(&text),)).map(|_| ())
    }
}

impl Write for Notes {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(text);
        Ok(text.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn look(py: Python<'_>, tick: Option<&Py<PyAny>>, shared: &Shared) -> PyResult<()> {
    py.check_signals()?;
    let Some(tick) = tick else { return Ok(()) };
    let iteration = shared.iteration.load(Ordering::Relaxed);
    let Reading { note, done, count, .. } = match iteration {
        0 => shared.reading.lock().unwrap_or_else(PoisonError::into_inner).clone(),
        _ => {
            let residual = f64::from_bits(shared.residual.load(Ordering::Relaxed));
            Reading { note: format!("iteration {iteration}, residual {residual:.1e}"), ..Reading::default() }
        }
    };
    tick.call1(py, (note, done, count)).map(|_| ())
}

/// Runs short work like [`run`]; an exception replaces the result.
pub(crate) fn quick<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    match run(py, 0, None, |_| work())? {
        (value, None) => Ok(value),
        (_, Some(raised)) => Err(raised),
    }
}
