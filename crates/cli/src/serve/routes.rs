//! Addresses of the server below its token.

use std::io::Read as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;

use gfmd_input::failure::Failure;
use gfmd_input::materials::materials;
use oxhttp::model::header::{CONTENT_LENGTH, CONTENT_TYPE};
use oxhttp::model::{Body, Method, Request, Response, StatusCode};
use rayon::ThreadPool;
use serde::Deserialize;
use serde_json::{Value, json};

use super::answer::{bytes, file, json as as_json, part, refusal};
use super::form::{Answers, entries};
use super::guard::Guard;
use super::map::Part;
use super::runs::{Runs, pool};
use super::scans::{NotStored, Scan, Scans, store};

/// Parts of the page.
const PARTS: [(&str, &str, &str); 4] = [
    ("", "text/html; charset=utf-8", include_str!("page.html")),
    ("page.css", "text/css; charset=utf-8", include_str!("page.css")),
    ("map.js", "text/javascript; charset=utf-8", include_str!("map.js")),
    ("page.js", "text/javascript; charset=utf-8", include_str!("page.js")),
];

/// Largest size of the answers of a form in bytes.
const MOST_ANSWERS: u64 = 1 << 20;

/// State of the server.
pub(super) struct Desk {
    folder: PathBuf,
    /// Largest size of an upload in bytes.
    limit: u64,
    scans: Scans,
    pub(super) runs: Arc<Runs>,
    /// Threads that prepare scans and draw maps. The threads of the program are not free: one of them waits for Ctrl-C.
    pool: ThreadPool,
}

/// Refusal with its status.
type Refusal = (StatusCode, String);

fn bad(failure: &Failure) -> Refusal {
    (StatusCode::BAD_REQUEST, failure.to_string())
}

fn nothing() -> Refusal {
    (StatusCode::NOT_FOUND, "nothing has this address".into())
}

/// A scan and answers of the form.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Posted {
    scan: usize,
    #[serde(default)]
    options: Answers,
}

/// Answers a request. A fault of the program ends the request and not the server.
pub(super) fn answer(request: &mut Request<Body>, guard: &Guard, desk: &Desk) -> Response<Body> {
    let path = match guard.admit(request) {
        Ok(path) => path,
        Err((status, reason)) => return refusal(status, reason),
    };
    let answered = catch_unwind(AssertUnwindSafe(|| desk.answer(request, &path)));
    match answered {
        Ok(Ok(response)) => response,
        Ok(Err((status, message))) => refusal(status, &message),
        Err(_) => refusal(StatusCode::INTERNAL_SERVER_ERROR, "the request ended by a fault of the program"),
    }
}

impl Desk {
    /// Creates a server for results in a folder, with uploads of at most `limit` bytes.
    ///
    /// # Errors
    /// Returns an error if threads cannot be started.
    pub(super) fn new(folder: PathBuf, limit: u64, threads: usize) -> Result<Self, Failure> {
        let (scans, runs, pool) = (Scans::default(), Arc::new(Runs::new(threads)), pool(threads)?);
        Ok(Self { folder, limit, scans, runs, pool })
    }

    fn answer(&self, request: &mut Request<Body>, path: &str) -> Result<Response<Body>, Refusal> {
        let words: Vec<&str> = path.split('/').collect();
        if request.method() == Method::POST {
            return match words[..] {
                ["upload"] => self.upload(request),
                ["prepare"] => {
                    let Posted { scan, options } = posted(request)?;
                    let scan = self.scan(scan)?;
                    let told = self.pool.install(|| scan.prepare(&options));
                    Ok(as_json(&told.map_err(|failure| (StatusCode::BAD_REQUEST, scan.told(&failure)))?))
                }
                ["run"] => {
                    let Posted { scan, options } = posted(request)?;
                    let scan = self.scan(scan)?;
                    let started = self.pool.install(|| self.runs.start(&scan, &options, &self.folder));
                    let run = started.map_err(|failure| (StatusCode::BAD_REQUEST, scan.told(&failure)))?;
                    Ok(as_json(&json!({ "run": run })))
                }
                ["stop", run] => {
                    self.run(run)?.stop();
                    Ok(as_json(&json!({})))
                }
                ["resume", run] => {
                    let run = number(run)?;
                    self.runs.get(run).ok_or_else(nothing)?;
                    self.pool.install(|| self.runs.resume(run)).map_err(|failure| bad(&failure))?;
                    Ok(as_json(&json!({})))
                }
                _ => Err(nothing()),
            };
        }
        if let Some((_, kind, text)) = PARTS.iter().find(|(name, ..)| *name == path) {
            return Ok(part(kind, text));
        }
        let (words, part) = with_part(&words)?;
        match words[..] {
            ["form"] => Ok(as_json(&json!({
                "options": entries(), "materials": materials(), "folder": self.folder, "limit": self.limit,
                "version": env!("CARGO_PKG_VERSION"),
            }))),
            ["runs"] => Ok(as_json(&self.runs.all().iter().map(|run| run.about()).collect::<Vec<Value>>())),
            ["run", run] => Ok(as_json(&self.run(run)?.about())),
            ["scan", scan] => {
                let scan = self.scan(number(scan)?)?;
                let about = self
                    .pool
                    .install(|| scan.about())
                    .map_err(|failure| (StatusCode::BAD_REQUEST, scan.told(&failure)))?;
                Ok(as_json(&about))
            }
            ["map", "raw", scan] => {
                let scan = self.scan(number(scan)?)?;
                self.pool.install(|| scan.raw(part)).map(bytes).map_err(|failure| bad(&failure))
            }
            ["map", "prepared", scan] => {
                let scan = self.scan(number(scan)?)?;
                self.pool.install(|| scan.prepared(part)).map(bytes).ok_or_else(nothing)
            }
            ["map", "run", run, field, load] => {
                let (run, load) = (self.run(run)?, number(load)?);
                self.pool.install(|| run.map(field, load, part)).map(bytes).map_err(|failure| bad(&failure))
            }
            ["file", run, "result"] => Ok(file(&self.run(run)?.file, false)),
            ["file", run, "page"] => Ok(file(&self.run(run)?.page(), true)),
            _ => Err(nothing()),
        }
    }

    fn scan(&self, number: usize) -> Result<Arc<Scan>, Refusal> {
        self.scans.get(number).ok_or_else(nothing)
    }

    fn run(&self, word: &str) -> Result<Arc<super::runs::Run>, Refusal> {
        self.runs.get(number(word)?).ok_or_else(nothing)
    }

    /// Stores a file that a reader understands.
    fn upload(&self, request: &mut Request<Body>) -> Result<Response<Body>, Refusal> {
        must_be(request, "application/octet-stream")?;
        let too_large = || {
            let message =
                format!("the file is too large; it must be at most {} MiB (--upload-limit)", self.limit >> 20);
            (StatusCode::PAYLOAD_TOO_LARGE, message)
        };
        let stated = request.headers().get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
        if stated.is_some_and(|length| length > self.limit) {
            return Err(too_large());
        }
        let name = request.headers().get("x-name").and_then(|name| name.to_str().ok()).unwrap_or_default();
        let name = decoded(name);
        let path = store(&self.folder, &name, request.body_mut(), self.limit).map_err(|error| match error {
            NotStored::TooLarge => too_large(),
            NotStored::Failed(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("cannot store the file: {error}")),
        })?;
        let (number, scan) = self.scans.add(path);
        match self.pool.install(|| scan.about()) {
            Ok(mut about) => {
                about["scan"] = number.into();
                Ok(as_json(&about))
            }
            Err(failure) => {
                // A file that no reader understands is of no use in the folder.
                let _ = std::fs::remove_file(&scan.path);
                Err((StatusCode::UNPROCESSABLE_ENTITY, scan.told(&failure)))
            }
        }
    }
}

/// Refuses a request with another kind of content. A page of another site can send no such kind without being asked.
fn must_be(request: &Request<Body>, kind: &str) -> Result<(), Refusal> {
    let found = request.headers().get(CONTENT_TYPE).and_then(|found| found.to_str().ok()).unwrap_or_default();
    if found.split(';').next().unwrap_or_default().trim() == kind {
        return Ok(());
    }
    Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, format!("the content must be {kind}")))
}

/// Divides the end `part/X/Y/NX/NY` from the address of a map.
fn with_part<'a>(words: &'a [&'a str]) -> Result<(&'a [&'a str], Option<Part>), Refusal> {
    let [map @ .., "part", x, y, nx, ny] = words else { return Ok((words, None)) };
    let part = Part { from: [number(x)?, number(y)?], count: [number(nx)?, number(ny)?] };
    Ok((map, Some(part)))
}

fn number(word: &str) -> Result<usize, Refusal> {
    word.parse().map_err(|_| nothing())
}

/// Returns the answers of the form.
fn posted(request: &mut Request<Body>) -> Result<Posted, Refusal> {
    must_be(request, "application/json")?;
    let mut text = Vec::new();
    let read = request.body_mut().take(MOST_ANSWERS + 1).read_to_end(&mut text);
    if read.is_err() || text.len() as u64 > MOST_ANSWERS {
        return Err((StatusCode::PAYLOAD_TOO_LARGE, "the answers of the form are too large".into()));
    }
    serde_json::from_slice(&text)
        .map_err(|error| (StatusCode::BAD_REQUEST, format!("the answers of the form: {error}")))
}

/// Returns a text with `%20` and the like as letters.
fn decoded(text: &str) -> String {
    let (bytes, mut out, mut at) = (text.as_bytes(), Vec::new(), 0);
    while let Some(&byte) = bytes.get(at) {
        let hex = (byte == b'%').then(|| text.get(at + 1..at + 3)).flatten();
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(decoded) => {
                out.push(decoded);
                at += 3;
            }
            None => {
                out.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}
