//! All processes that a launcher has started together.

use std::time::{Duration, Instant};

use gfmd_vector::{Letters, Pending, Ranks};

use crate::Launcher;
use crate::library::{About, Begun, begin};

/// The file of the library, or `none`.
const VARIABLE: &str = "GFMD_MPI";

/// The largest number of words that are gathered in one call: counts are below 2³¹.
const PIECE: usize = 1 << 28;

/// How long a process that has failed waits for the others to fail, too.
const TOGETHER: Duration = Duration::from_secs(3);

/// All processes that a launcher has started together.
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
        "{launcher} has started {size} processes, but no MPI library was found ({reason}); GFMD_MPI=FILE names one, and \
         GFMD_MPI=none lets each process run alone"
    )]
    NoLibrary {
        /// The launcher.
        launcher: &'static str,
        /// The number of processes.
        size: usize,
        /// The last reason.
        reason: String,
    },
    /// A library that the launcher does not start: each process would be alone.
    #[error(
        "{launcher} has started {size} processes, which the library {version} does not know; it must be the library of the \
         launcher, which GFMD_MPI=FILE names"
    )]
    OtherLibrary {
        /// The launcher.
        launcher: &'static str,
        /// The number of its processes.
        size: usize,
        /// The library.
        version: String,
    },
}

/// Begins, if a launcher has started this process as one of several. Called once.
///
/// # Errors
/// No library, or that of another launcher.
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

/// Calls a function of either kind of library.
macro_rules! of {
    ($world:expr, $functions:ident => $call:expr) => {
        match &$world.begun {
            Begun::Numbers($functions) => $call,
            Begun::Addresses($functions) => $call,
        }
    };
}

impl World {
    /// The words of the library about itself.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// True if all processes arrive here within three seconds: they have ended alike. Called once.
    pub fn is_met(&self) -> bool {
        let begun = Instant::now();
        of!(self, functions => functions.meet(|| {
            std::thread::sleep(Duration::from_millis(1));
            begun.elapsed() < TOGETHER
        }))
    }

    /// Waits for all processes. Called once, by those that have not failed.
    pub fn meet(&self) {
        of!(self, functions => functions.meet(|| {
            std::thread::sleep(Duration::from_millis(1));
            true
        }));
    }

    /// Ends this process's part, after all have met.
    pub fn end(&self) {
        of!(self, functions => functions.finalize());
    }

    /// Ends all processes with this status.
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

    fn post(&self, letters: Letters) -> Box<dyn Pending + '_> {
        of!(self, functions => Box::new(functions.post(letters)))
    }
}
