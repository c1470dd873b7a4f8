//! Scans that the page has sent.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_files::Topography;
use gfmd_files::legible::line;
use gfmd_input::failure::Failure;
use gfmd_unit::Units;
use ndarray::Array2;
use serde::Serialize;
use serde_json::{Value, json};

use super::form::{Answers, Pressed, words};
use super::map::{Map, Part};
use crate::line::parsed;
use crate::surface;
use crate::surface::Listing;

/// Largest number of letters of a name.
const LONGEST: usize = 80;

/// Largest number of files with one name.
const MOST_ALIKE: usize = 10_000;

/// Scan in the folder of results.
pub(super) struct Scan {
    pub(super) path: PathBuf,
    /// Channel that was prepared last; `None` for the default one.
    channel: Mutex<Option<String>>,
    /// Heights as prepared last, in the unit of their lengths.
    prepared: Mutex<Option<Prepared>>,
}

/// Heights after their preparation.
struct Prepared {
    heights: Array2<f64>,
    size: [f64; 2],
    unit: Option<String>,
}

/// The scans, by their numbers.
#[derive(Default)]
pub(super) struct Scans(Mutex<Vec<Arc<Scan>>>);

impl Scans {
    /// Adds a scan and returns its number.
    pub(super) fn add(&self, path: PathBuf) -> (usize, Arc<Scan>) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let scan = Arc::new(Scan { path, channel: Mutex::default(), prepared: Mutex::default() });
        all.push(Arc::clone(&scan));
        (all.len() - 1, scan)
    }

    /// Returns the scan of a number.
    pub(super) fn get(&self, number: usize) -> Option<Arc<Scan>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(number).cloned()
    }
}

/// Returns the name under which a file is stored: the last part of the name that the browser gave, with letters,
/// digits, `.`, `-` and `_` alone.
pub(super) fn plain_name(given: &str) -> String {
    let last = given.rsplit(['/', '\\']).next().unwrap_or_default();
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_') { c } else { '-' };
    let name: String = last.chars().map(plain).collect();
    let name = name.trim_start_matches(['.', '-']).trim_end_matches('.');
    let name = if name.is_empty() { "scan" } else { name };
    // The end tells the format to people.
    name[name.len().saturating_sub(LONGEST)..].trim_start_matches(['.', '-']).to_owned()
}

/// Reason why a file was not stored.
pub(super) enum NotStored {
    /// More bytes than allowed.
    TooLarge,
    /// An error of the folder or the connection.
    Failed(io::Error),
}

impl From<io::Error> for NotStored {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

/// Stores at most `limit` bytes in a new file of the folder; a name that is taken gets a number.
pub(super) fn store(folder: &Path, given: &str, bytes: &mut dyn Read, limit: u64) -> Result<PathBuf, NotStored> {
    let name = plain_name(given);
    let (stem, end) = name.rsplit_once('.').map_or((&*name, String::new()), |(stem, end)| (stem, format!(".{end}")));
    for count in 1..MOST_ALIKE {
        let name = if count == 1 { name.clone() } else { format!("{stem}-{count}{end}") };
        let path = folder.join(name);
        // A new file: neither an older one nor a link is opened.
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error.into()),
            Ok(file) => {
                let stored = fill(file, bytes, limit);
                if stored.is_err() {
                    let _ = std::fs::remove_file(&path);
                }
                return stored.map(|()| path);
            }
        }
    }
    Err(io::Error::other(format!("the folder has {MOST_ALIKE} files named {name}")).into())
}

fn fill(mut file: File, bytes: &mut dyn Read, limit: u64) -> Result<(), NotStored> {
    if io::copy(&mut bytes.take(limit + 1), &mut file)? > limit {
        return Err(NotStored::TooLarge);
    }
    file.flush()?;
    Ok(file.sync_all()?)
}

/// Number of a surface as the page shows it.
#[derive(Serialize)]
struct Shown {
    name: &'static str,
    text: String,
    meaning: &'static str,
}

impl Scan {
    /// Returns the file as a word of a command line.
    pub(super) fn word(&self) -> String {
        self.path.to_string_lossy().into_owned()
    }

    /// Returns the file name.
    pub(super) fn name(&self) -> String {
        self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Returns the message of a failure with the name of the file in place of its path.
    pub(super) fn told(&self, failure: &Failure) -> String {
        failure.to_string().replace(&self.word(), &self.name())
    }

    fn read(&self) -> Result<Topography, Failure> {
        let channel = self.channel.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Topography::read(&self.word(), channel.as_deref()).map_err(|error| Failure::refused(error.to_string()))
    }

    /// Describes the file and its channel: points, size, unit, channels, points without a height.
    ///
    /// # Errors
    /// Returns an error if no reader understands the file.
    pub(super) fn about(&self) -> Result<Value, Failure> {
        let listing = Listing::of(&self.word())?;
        let found = self.read()?;
        let units = Units::new(found.unit.as_deref(), None);
        let [nx, ny] = found.heights.dim().into();
        let size = found.lengths.map(|lengths| {
            let sides = if ny == 1 { &lengths[..1] } else { &lengths[..] };
            sides.iter().map(|length| units.words(*length, "length")).collect::<Vec<_>>().join(" x ")
        });
        Ok(json!({
            "name": self.name(), "file": self.word(), "format": found.format, "n": [nx, ny], "size": size,
            "unit": found.unit, "undefined": found.undefined, "channel": found.channel, "channels": listing.channels,
            "notes": found.notes.iter().chain(&found.warnings).map(|text| line(text)).collect::<Vec<_>>(),
        }))
    }

    /// Returns the heights of the file as a map or a part of it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read.
    pub(super) fn raw(&self, part: Option<Part>) -> Result<Vec<u8>, Failure> {
        let found = self.read()?;
        let [nx, ny] = found.heights.dim().into();
        let size = found.lengths.unwrap_or([1.0, ny as f64 / nx as f64]);
        let units = Units::new(found.unit.as_deref(), None);
        let map = Map { values: found.heights.view(), size, kind: "length", meaning: "height in the file" };
        Ok(map.bytes(&units, part))
    }

    /// Prepares the heights as `gfmd surface` does, and returns its numbers.
    ///
    /// # Errors
    /// Returns an error if the options cannot be used on this file.
    pub(super) fn prepare(&self, answers: &Answers) -> Result<Value, Failure> {
        let mut line = vec!["gfmd".to_owned(), "surface".to_owned(), format!("--surface={}", self.word())];
        line.extend(words("surface", answers)?);
        let (command, session) = parsed(&line)?;
        let Pressed::Surface(args) = command else { return Err(Failure::refused("the words name another command")) };
        let (report, heights) = surface::measured(&args, &session)?;
        let channel = answers.get("channel").and_then(Value::as_str).map(str::to_owned);
        *self.channel.lock().unwrap_or_else(PoisonError::into_inner) = channel;
        let shown = report.shown().map(|(name, text, meaning)| Shown { name, text, meaning }).collect::<Vec<_>>();
        let source = report.source.replace(&self.word(), &self.name());
        let whole: Value = serde_json::from_str(&session.json(&report)?).unwrap_or_default();
        let warnings =
            whole["warnings"].as_array().into_iter().flatten().filter_map(|warning| warning["text"].as_str());
        let warnings = warnings.map(|text| text.replace(&self.word(), &self.name())).collect::<Vec<_>>();
        let told = json!({ "numbers": shown, "warnings": warnings, "source": source, "about": self.about()? });
        let (size, unit) = (report.size, report.unit);
        *self.prepared.lock().unwrap_or_else(PoisonError::into_inner) = Some(Prepared { heights, size, unit });
        Ok(told)
    }

    /// Returns the heights as prepared last as a map or a part of it.
    pub(super) fn prepared(&self, part: Option<Part>) -> Option<Vec<u8>> {
        let prepared = self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        let Prepared { heights, size, unit } = prepared.as_ref()?;
        let units = Units::new(unit.as_deref(), None);
        let map = Map { values: heights.view(), size: *size, kind: "length", meaning: "height as prepared" };
        Some(map.bytes(&units, part))
    }
}
