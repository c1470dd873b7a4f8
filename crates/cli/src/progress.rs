//! Progress on stderr: a bar on a terminal, a plain line every few seconds elsewhere, nothing when quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use gfmd_input::session::{Meter, Session};
use indicatif::{ProgressBar, ProgressStyle};

/// Time before the first plain line.
const TIME_TO_FIRST_LINE: Duration = Duration::from_secs(1);

/// Time between two plain lines.
const PAUSE: Duration = Duration::from_secs(5);

/// Progress through work of known total size. The size of a piece is its expected cost, so that the estimate of the
/// time left is right when pieces differ.
pub struct Progress {
    bar: Option<ProgressBar>,
    plain: Option<Mutex<Plain>>,
    total: Mutex<f64>,
    done: Mutex<f64>,
    what: String,
    meter: Meter,
}

struct Plain {
    what: String,
    started: Instant,
    shown: Instant,
    done: f64,
}

impl Progress {
    /// Creates the progress of `what` in a session, whose meter shows it, too; `total` has the unit of the pieces.
    pub fn new(session: &Session, what: &str, total: f64) -> Self {
        let quiet = session.quiet;
        let terminal = std::io::stderr().is_terminal();
        let bar = (terminal && !quiet).then(|| {
            let bar = ProgressBar::new(SCALE);
            let template = "{prefix} [{wide_bar}] {percent}% {msg} {elapsed} < {eta}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_prefix(what.to_owned());
            bar
        });
        let now = Instant::now();
        let plain = (!terminal && !quiet).then(|| {
            Mutex::new(Plain { what: what.into(), started: now, shown: now + TIME_TO_FIRST_LINE - PAUSE, done: 0.0 })
        });
        let meter = session.meter().clone();
        meter.show(what, 0.0, "");
        Self { bar, plain, total: Mutex::new(total), done: Mutex::new(0.0), what: what.into(), meter }
    }

    /// Sets the total size of the work after more has been added.
    pub fn extend(&self, total: f64) {
        if let Ok(mut known) = self.total.lock() {
            if let Some(bar) = &self.bar {
                bar.set_position((bar.position() as f64 * *known / total) as u64);
            }
            *known = total;
        }
    }

    /// Counts a finished piece; `note` describes the state of the work.
    pub fn advance(&self, piece: f64, note: &str) {
        let total = self.total.lock().map_or(f64::INFINITY, |total| *total);
        if let Ok(mut done) = self.done.lock() {
            *done += piece;
            self.meter.show(&self.what, (*done / total).min(1.0), note);
        }
        if let Some(bar) = &self.bar {
            bar.set_message(note.to_owned());
            bar.inc((piece / total * SCALE as f64).round() as u64);
        }
        let Some(plain) = &self.plain else { return };
        let Ok(mut plain) = plain.lock() else { return };
        plain.done += piece;
        if plain.shown.elapsed() >= PAUSE {
            plain.shown = Instant::now();
            let part = (plain.done / total).min(1.0);
            let elapsed = plain.started.elapsed().as_secs_f64();
            let left = match part {
                0.0 => String::new(),
                _ => format!(", about {:.0} s left", elapsed * (1.0 - part) / part),
            };
            tracing::info!("{}: {:.0} %, {note}, {elapsed:.0} s{left}", plain.what, 100.0 * part);
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
