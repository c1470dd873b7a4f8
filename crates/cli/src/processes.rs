//! One command on several processes started by an MPI launcher: printing, and the common end.

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::processes::texts;
use gfmd_mpi::{Launcher, World, start};
use gfmd_vector::Ranks as _;

/// The commands shared by several processes. Other commands run separately on each process, such as the shards of a
/// sweep.
const TOGETHER: [&str; 3] = ["contact", "path", "wear"];

/// Joins the other processes started by a launcher with these `words`, if there are any.
///
/// # Errors
/// Returns an error if there is no MPI library, if it belongs to another launcher, or if processes have other words.
pub(crate) fn join(words: &[OsString]) -> Result<Option<Arc<World>>, Failure> {
    // Only flags and the number of threads precede the command.
    let is_command = |word: &&OsString| word.to_str().is_some_and(|word| word.starts_with(char::is_alphabetic));
    if words.iter().skip(1).find(is_command).is_none_or(|word| TOGETHER.iter().all(|name| word != name)) {
        return Ok(None);
    }
    let joined: Result<Option<(World, Vec<String>)>, Failure> = watched(TIME_TO_REPORT, report_waiting, || {
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
        let failure = Failure::refused(found);
        let status = end(Some(&world), failure.status(), Some(&failure));
        std::process::exit(status.into());
    }
    Ok(Some(world))
}

/// Time after which a process reports that it waits for others to join.
const TIME_TO_REPORT: Duration = Duration::from_secs(10);

/// Runs `work`, and calls `tell` on another thread if it takes longer than `patience`.
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

/// Reports on stderr that this process waits for others, since one that has ended or runs another command never joins.
/// The first process reports, and the second, in case the first one is missing.
fn report_waiting() {
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

/// Returns the number of processes that the launcher reports for this machine, or 1.
pub(crate) fn on_this_machine() -> usize {
    Launcher::found().map_or(1, |launcher| launcher.local)
}

/// Ends this process in a command with this exit status, after the first process has printed the reason of a failure.
/// Returns the status.
///
/// All processes fail alike, or [agree](gfmd_input::processes::agree) on a failure, except the first one, which writes:
/// if it fails alone, e.g. on a full disk, it ends the others. They wait for it.
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
            // The sender is dropped with the watching thread.
            (result, receiver.iter().count())
        };
        assert_eq!(reported(Duration::from_millis(20), Duration::from_millis(400)), (7, 1));
        assert_eq!(reported(Duration::from_secs(600), Duration::ZERO), (7, 0));
    }
}
