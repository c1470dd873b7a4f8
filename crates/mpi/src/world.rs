//! Processes started together by a launcher.

use std::time::{Duration, Instant};

use gfmd_vector::{Messages, Pending, Ranks};

use crate::Launcher;
use crate::library::{About, Begun, begin};

/// Environment variable with the file of the library, or `none`.
const VARIABLE: &str = "GFMD_MPI";

/// Largest number of words gathered in one call: counts must be below 2³¹.
const PIECE: usize = 1 << 28;

/// Time that a failed process waits for the others to fail as well.
const TOGETHER: Duration = Duration::from_secs(3);

/// Processes started together by a launcher.
pub struct World {
    begun: Begun,
    rank: usize,
    size: usize,
    version: String,
}

/// Reasons why processes cannot share a contact.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MpiError {
    /// No library was found.
    #[error(
        "{launcher} has started {size} processes, but no MPI library was found ({reason}); GFMD_MPI=FILE names one, \
         and GFMD_MPI=none lets each process run alone"
    )]
    NoLibrary {
        /// Name of the launcher.
        launcher: &'static str,
        /// Number of processes.
        size: usize,
        /// Reason why the first library was not loaded.
        reason: String,
    },
    /// The library belongs to another launcher; each process would run alone.
    #[error(
        "{launcher} has started {size} processes, which the library {version} does not know; it must be the library of \
         the launcher, which GFMD_MPI=FILE names"
    )]
    OtherLibrary {
        /// Name of the launcher.
        launcher: &'static str,
        /// Number of processes started.
        size: usize,
        /// Version text of the library.
        version: String,
    },
}

/// Initialises MPI if a launcher started this process as one of several; otherwise returns `None`. Call it once.
///
/// # Errors
/// No library was found, or only the library of another launcher.
pub fn start() -> Result<Option<World>, MpiError> {
    let Some(launcher) = Launcher::found() else { return Ok(None) };
    let Launcher { name, size, libraries, .. } = launcher;
    let chosen = std::env::var(VARIABLE).ok().filter(|file| !file.is_empty());
    if chosen.as_deref() == Some("none") {
        return Ok(None);
    }
    let files = chosen.as_deref().map_or_else(|| libraries.to_vec(), |file| vec![file]);
    let other = |version| Err(MpiError::OtherLibrary { launcher: name, size, version });
    let mut reason = String::new();
    for file in files {
        match begin(file, |version| launcher.starts(version)) {
            Ok(Ok((begun, about))) if about.size == size => {
                let world = World { begun, rank: about.rank, size, version: about.version };
                return Ok(Some(world));
            }
            Ok(Ok((_, About { version, .. })) | Err(version)) => return other(version),
            Err(error) if reason.is_empty() => reason = error.to_string(),
            Err(_) => {}
        }
    }
    Err(MpiError::NoLibrary { launcher: name, size, reason })
}

/// Calls a method for either kind of library.
macro_rules! of {
    ($world:expr, $functions:ident => $call:expr) => {
        match &$world.begun {
            Begun::Numbers($functions) => $call,
            Begun::Addresses($functions) => $call,
        }
    };
}

impl World {
    /// Returns the version text of the library.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Waits up to three seconds for all processes. Returns true if all arrive, which means that all ended in the same
    /// way. Call it once.
    pub fn is_met(&self) -> bool {
        let begun = Instant::now();
        of!(self, functions => functions.meet(|| {
            std::thread::sleep(Duration::from_millis(1));
            begun.elapsed() < TOGETHER
        }))
    }

    /// Waits for all processes. Processes that have not failed call it once.
    pub fn meet(&self) {
        of!(self, functions => functions.meet(|| {
            std::thread::sleep(Duration::from_millis(1));
            true
        }));
    }

    /// Finalises MPI in this process, after all have met.
    pub fn end(&self) {
        of!(self, functions => functions.finalize());
    }

    /// Aborts all processes with this exit status.
    pub fn abort(&self, status: u8) {
        of!(self, functions => functions.abort(status));
    }
}

impl Ranks for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]) {
        if all.len() <= PIECE {
            return of!(self, functions => functions.gather(own, all, lengths));
        }
        let mut rest = all;
        for (rank, length) in lengths.iter().enumerate() {
            let (part, after) = rest.split_at_mut(*length);
            if rank == self.rank {
                part.copy_from_slice(own);
            }
            part.chunks_mut(PIECE).for_each(|piece| of!(self, functions => functions.broadcast(piece, rank)));
            rest = after;
        }
    }

    fn post(&self, messages: Messages) -> Box<dyn Pending + '_> {
        of!(self, functions => Box::new(functions.post(messages)))
    }
}
