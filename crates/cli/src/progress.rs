//! Progress on stderr: a bar on a terminal, a plain line every few seconds elsewhere, nothing when quiet.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use gfmd_input::session::{Meter, Reading, Session};
use indicatif::{ProgressBar, ProgressStyle};

/// Time before the first plain line.
const TIME_TO_FIRST_LINE: Duration = Duration::from_secs(1);

/// Time between two plain lines.
const PAUSE: Duration = Duration::from_secs(5);

/// Progress through pieces of work. The size of a piece is its expected cost, so that the estimate of the time left is
/// right when pieces differ.
pub struct Progress {
    bar: Option<ProgressBar>,
    plain: Option<Mutex<Plain>>,
    work: Mutex<Work>,
    what: String,
    meter: Meter,
}

/// Number and size of the finished pieces, and of all.
#[derive(Clone, Copy)]
struct Work {
    done: usize,
    count: usize,
    size: f64,
    total: f64,
}

struct Plain {
    started: Instant,
    shown: Instant,
}

impl Progress {
    /// Creates the progress of `count` pieces of size 1, such as loads, in a session, whose meter shows it, too.
    pub fn new(session: &Session, what: &str, count: usize) -> Self {
        Self::of_sizes(session, what, count, count as f64)
    }

    /// Creates the progress of pieces of different sizes.
    pub fn of_sizes(session: &Session, what: &str, count: usize, total: f64) -> Self {
        let quiet = session.quiet;
        let terminal = std::io::stderr().is_terminal();
        let bar = (terminal && !quiet).then(|| {
            let bar = ProgressBar::new(SCALE);
            let template = "{percent:>3}% [{bar:20}] {elapsed} < {eta}, {wide_msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        });
        let now = Instant::now();
        let plain =
            (!terminal && !quiet).then(|| Mutex::new(Plain { started: now, shown: now + TIME_TO_FIRST_LINE - PAUSE }));
        let work = Mutex::new(Work { done: 0, count, size: 0.0, total });
        let progress = Self { bar, plain, work, what: what.into(), meter: session.meter().clone() };
        progress.advance(0.0, "");
        progress
    }

    /// Sets the number and the total size of the pieces after more have been added.
    pub fn extend(&self, count: usize, total: f64) {
        let mut work = self.work.lock().unwrap_or_else(PoisonError::into_inner);
        *work = Work { count, total, ..*work };
    }

    /// Counts a finished piece, unless its size is zero; `note` describes the state of the work.
    pub fn advance(&self, piece: f64, note: &str) {
        let reading = {
            let mut work = self.work.lock().unwrap_or_else(PoisonError::into_inner);
            work.done += usize::from(piece > 0.0);
            work.size += piece;
            let Work { done, count, size, total } = *work;
            let share = (size / total).min(1.0);
            let reading = Reading { pieces: self.what.clone(), done, count, share, note: note.to_owned() };
            self.meter.show(reading.clone());
            reading
        };
        let share = reading.share;
        if let Some(bar) = &self.bar {
            bar.set_message(reading.to_string());
            bar.set_position((share * SCALE as f64).round() as u64);
        }
        let Some(plain) = &self.plain else { return };
        let Ok(mut plain) = plain.lock() else { return };
        if plain.shown.elapsed() >= PAUSE {
            plain.shown = Instant::now();
            let elapsed = plain.started.elapsed().as_secs_f64();
            let left = match share {
                0.0 => String::new(),
                _ => format!(", about {:.0} s left", elapsed * (1.0 - share) / share),
            };
            tracing::info!("{reading}, {elapsed:.0} s{left}");
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl gfmd_run::progress::Progress for Progress {
    fn advance(&self, piece: f64, note: &str) {
        self.advance(piece, note);
    }
}

const SCALE: u64 = 1_000_000;
