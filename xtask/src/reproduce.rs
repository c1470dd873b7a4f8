//! `reproduce`: computes and draws the figures of the thesis, chapters 2 to 4, with the public commands, and writes
//! docs/source/README.md.

mod catalogue;
mod dampings;
mod free_slab;
mod page;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args as ClapArgs;
use gfmd_cli::progress::Progress;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use serde::Serialize;
use serde_json::Value;

use catalogue::{FIGURES, Figure, PREPARATION, Work};

/// Flags of `reproduce`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd reproduce
  gfmd reproduce --figure 3.4,4.3 --out figures")]
pub struct Args {
    /// Figures to draw, by their numbers in the thesis; default: all, and the page about them
    #[arg(long, value_delimiter = ',', value_name = "F1,F2,..")]
    figure: Vec<String>,
    /// Write README.md and the figures in this folder
    #[arg(long, default_value = "docs/source", value_name = "FOLDER")]
    out: PathBuf,
    /// Read the solutions of finite elements from this folder
    #[arg(long, default_value = "data/reference", value_name = "FOLDER")]
    reference: PathBuf,
}

/// Result of the command.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub figures: Vec<&'static str>,
    pub written: Vec<PathBuf>,
}

/// Working folder of the commands, and their output by command text.
struct Runs {
    program: PathBuf,
    folder: tempfile::TempDir,
    reference: PathBuf,
    reports: BTreeMap<String, Value>,
}

impl Runs {
    /// Runs `gfmd COMMAND --json` once and returns its output. A search stopped by `--max-iterations` has printed
    /// its state.
    fn run(&mut self, command: &str) -> Result<&Value, Failure> {
        if !self.reports.contains_key(command) {
            let failed = |reason: String| Failure::computation(format!("gfmd {command}: {reason}"));
            let words = command.split_whitespace().map(|word| match word.strip_prefix("data/reference/") {
                Some(name) => self.reference.join(name).into_os_string(),
                None => word.into(),
            });
            let output = Command::new(&self.program)
                .args(words)
                .args(["--json", "--quiet"])
                .current_dir(self.folder.path())
                .output()
                .map_err(|error| failed(error.to_string()))?;
            let stopped = command.contains("--max-iterations") && output.status.code() == Some(1);
            if !(output.status.success() || stopped) {
                return Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()));
            }
            let report = serde_json::from_slice(&output.stdout).map_err(|error| failed(error.to_string()))?;
            self.reports.insert(command.to_owned(), report);
        }
        Ok(&self.reports[command])
    }
}

/// Runs the command.
///
/// # Errors
/// A number that is not a figure; a folder that cannot be written; a command that fails.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let numbers: Vec<&str> = FIGURES.iter().map(|figure| figure.number).collect();
    if let Some(found) = args.figure.iter().find(|number| !numbers.contains(&number.as_str())) {
        return Err(Failure::value("--figure", found, format!("one of {}", numbers.join(", "))));
    }
    let input = |path: &Path, error: std::io::Error| Failure::input(path.display().to_string(), error);
    std::fs::create_dir_all(&args.out).map_err(|error| input(&args.out, error))?;
    let reference = args.reference.canonicalize().map_err(|error| input(&args.reference, error))?;
    let failed = |error: std::io::Error| Failure::computation(error.to_string());
    let program = std::env::current_exe().map_err(failed)?;
    let folder = tempfile::tempdir().map_err(failed)?;
    let mut runs = Runs { program, folder, reference, reports: BTreeMap::new() };
    let wanted = |figure: &&Figure| args.figure.is_empty() || args.figure.iter().any(|number| number == figure.number);
    let chosen: Vec<&Figure> = FIGURES.iter().filter(wanted).collect();
    let progress = Progress::new(session, "figures", chosen.len());
    let mut written = Vec::new();
    for figure in &chosen {
        if session.is_interrupted() {
            return Err(Failure::interrupted(format!("interrupted at figure {}", figure.number)));
        }
        written.extend(draw(figure, &mut runs, &args.out)?);
        progress.advance(1.0, figure.number);
    }
    progress.finish();
    if args.figure.is_empty() {
        let page = args.out.join("README.md");
        let text = page::text(&mut runs)?;
        gfmd_files::replace(&page, |file| std::io::Write::write_all(file, text.as_bytes()))?;
        written.push(page);
    }
    Ok(Report { figures: chosen.iter().map(|figure| figure.number).collect(), written })
}

/// Runs the commands of a figure and copies its pictures.
fn draw(figure: &Figure, runs: &mut Runs, out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    let mut keep = |name: String, picture: &[u8]| {
        let path = out.join(name);
        gfmd_files::replace(&path, |file| std::io::Write::write_all(file, picture))?;
        written.push(path);
        Ok::<(), Failure>(())
    };
    match figure.work {
        Work::Commands(pictures) => {
            for command in PREPARATION.iter().filter(|_| figure.is_below_the_punch()) {
                runs.run(command)?;
            }
            for picture in pictures {
                runs.run(picture.command)?;
                let path = runs.folder.path().join(format!("{}.svg", picture.file));
                let svg = std::fs::read(&path);
                let svg = svg.map_err(|error| Failure::computation(format!("{}: {error}", path.display())))?;
                keep(figure.file(picture.suffix), &svg)?;
            }
        }
        Work::Dampings => {
            for (suffix, svg) in dampings::draw(figure.number, runs)? {
                keep(figure.file(suffix), svg.as_bytes())?;
            }
        }
    }
    Ok(written)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "figures {}", self.figures.join(", "))?;
        self.written.iter().try_for_each(|path| writeln!(f, "written: {}", path.display()))
    }
}
