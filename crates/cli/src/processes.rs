//! One command on several processes that a launcher of MPI has started: who prints, and how all of them end.

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use gfmd_mpi::{Launcher, World, start};
use gfmd_run::failure::Failure;
use gfmd_run::processes::texts;
use gfmd_vector::Ranks as _;

/// The command that several processes run together. Others run as often as they are started, such as the shards of a
/// sweep.
const TOGETHER: &str = "contact";

/// Joins the other processes that a launcher has started for these `words`, if there are any.
///
/// # Errors
/// No MPI library, or that of another launcher; processes with other words.
pub(crate) fn join(words: &[OsString]) -> Result<Option<Arc<World>>, Failure> {
    // Before it stand flags only, and the number of threads.
    let is_command = |word: &&OsString| word.to_str().is_some_and(|word| word.starts_with(char::is_alphabetic));
    if words.iter().skip(1).find(is_command).is_none_or(|word| word != TOGETHER) {
        return Ok(None);
    }
    let joined: Result<Option<(World, Vec<String>)>, Failure> = watched(PATIENCE, tell_of_waiting, || {
        let Some(world) = start().map_err(|error| Failure::input("GFMD_MPI", error))? else { return Ok(None) };
        let text: Vec<String> = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        let all = texts(&world, &text.join(" "));
        Ok(Some((world, all)))
    });
    let Some((world, all)) = joined? else { return Ok(None) };
    let world = Arc::new(world);
    if let Some(other) = all.iter().position(|other| *other != all[0]) {
        let found = format!(
            "process 0 was started with \"{}\", process {other} with \"{}\"; all must have the same arguments, or \
             GFMD_MPI=none to run alone",
            all[0], all[other]
        );
        let failure = Failure::Input(found);
        let status = end(Some(&world), failure.status(), Some(&failure));
        std::process::exit(status.into());
    }
    Ok(Some(world))
}

/// The time after which a process says that it waits for others to join.
const PATIENCE: Duration = Duration::from_secs(10);

/// Does `work`, and calls `tell` on another thread if it takes longer than `patience`.
fn watched<T>(patience: Duration, tell: impl FnOnce() + Send + 'static, work: impl FnOnce() -> T) -> T {
    let (over, waiting) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        if waiting.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
            tell();
        }
    });
    let result = work();
    drop(over);
    result
}

/// Says on stderr that this process waits for others, of which one may never come: one that runs another command, or
/// has ended. The first process says so, and the second, if it is the first one that does not come.
fn tell_of_waiting() {
    if let Some(launcher) = Launcher::found().filter(|launcher| launcher.rank < 2) {
        let _ = writeln!(io::stderr(), "{}", waiting(&launcher));
    }
}

fn waiting(Launcher { name, rank, size, .. }: &Launcher) -> String {
    format!(
        "process {rank} of {size} that {name} has started waits for the others to join; all {size} must run this \
         program with the same arguments, or GFMD_MPI=none lets each run alone"
    )
}

/// The number of processes that the launcher has started on this machine, as far as it tells.
pub(crate) fn on_this_machine() -> usize {
    Launcher::found().map_or(1, |launcher| launcher.local)
}

/// Ends the part of this process in a command with this exit status, after the first one has printed the reason of a
/// failure. Returns the status.
///
/// All processes fail alike, or [agree](gfmd_run::processes::agree) on it, but for the first one, which writes: if the
/// others go on, as when a disk is full, it ends them. They wait for it.
pub(crate) fn end(world: Option<&Arc<World>>, status: u8, failure: Option<&Failure>) -> u8 {
    if world.is_none_or(|world| world.rank() == 0)
        && let Some(failure) = failure
    {
        let _ = writeln!(io::stderr(), "error: {failure}");
    }
    let Some(world) = world else { return status };
    if status == 0 || world.rank() > 0 {
        world.meet();
    } else if !world.is_met() {
        world.abort(status);
    }
    world.end();
    status
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_waits_for_others_says_so() {
        let reported = |patience, work: Duration| {
            let (sender, receiver) = mpsc::channel();
            let result = watched(
                patience,
                move || sender.send(()).unwrap(),
                || {
                    std::thread::sleep(work);
                    7
                },
            );
            // The sender is dropped with the thread that watches.
            (result, receiver.iter().count())
        };
        assert_eq!(reported(Duration::from_millis(20), Duration::from_millis(400)), (7, 1));
        assert_eq!(reported(Duration::from_secs(600), Duration::ZERO), (7, 0));
    }
}
