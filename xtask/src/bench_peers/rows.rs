//! `bench-rows`: time and memory of typical runs, divided by time and memory of the solution alone.
//!
//! The two sides of a ratio are measured in turns, so that other work on the machine affects both.

mod measure;

use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use gfmd_input::failure::Failure;
use gfmd_input::session::{GIT_COMMIT, Session, machine};
use serde::Serialize;

use super::table::{Table, in_words, median, write_beside};
use crate::results::filled;
use measure::Trial;

/// Name of the tables in docs/benchmarks.md.
pub(super) const PLACE: &str = "rows";

/// Flags of `bench-rows`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd bench-rows --quick
  gfmd bench-rows --python venv/bin/python --tamaas --write-docs
  gfmd bench-rows --n 512 --large 1024 --repeats 1 --json")]
pub struct Args {
    /// Points along a side for the process, the stiffness and the ramp
    #[arg(long, default_value_t = 1024)]
    pub n: usize,
    /// Points along a side for the flow, the threads and the memory, which is also measured at twice as many
    #[arg(long, default_value_t = 2048)]
    pub large: usize,
    /// Hurst exponent of the surfaces
    #[arg(long, default_value_t = 0.0)]
    pub hurst: f64,
    /// Number of repetitions
    #[arg(long, default_value_t = 3, value_name = "K")]
    pub repeats: usize,
    /// Number of contacts of 128 x 128 points from Python; a third as many of 256 x 256
    #[arg(long, default_value_t = 1000, value_name = "COUNT")]
    pub many: usize,
    /// A smoke run: 128 and 256 points, one repetition, 12 contacts from Python
    #[arg(long, conflicts_with_all = ["n", "large", "repeats", "many"])]
    pub quick: bool,
    /// Python with gfmd installed, built for release
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    pub python: PathBuf,
    /// Solve by Tamaas, too, which is installed as by bench-peers
    #[arg(long)]
    pub tamaas: bool,
    /// Command that starts several processes, with its own flags
    #[arg(long, default_value = "mpirun", value_name = "COMMAND")]
    pub mpirun: String,
    /// File for the results
    #[arg(long, default_value = "data/benchmarks/rows.json", value_name = "FILE.json")]
    pub data: PathBuf,
    /// Write the results to --data, and their tables into this page [default: docs/benchmarks.md]
    #[arg(long, value_name = "FILE.md")]
    pub write_docs: Option<Option<PathBuf>>,
}

impl Args {
    /// Returns the arguments with the values of `--quick` filled in.
    fn resolved(&self) -> Result<Self, Failure> {
        let mut args = self.clone();
        if self.quick {
            (args.n, args.large, args.repeats, args.many) = (128, 256, 1, 12);
        }
        for (flag, value, least) in
            [("--n", args.n, 32), ("--large", args.large, 32), ("--repeats", args.repeats, 1), ("--many", args.many, 3)]
        {
            if value < least {
                return Err(Failure::value(flag, value, format!("at least {least}")));
            }
        }
        Ok(args)
    }
}

/// Result of the command.
#[derive(Clone, Debug, Serialize)]
pub struct Rows {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Version of this program.
    pub version: String,
    /// Commit of this program.
    pub commit: String,
    /// Hurst exponent of the surfaces.
    pub hurst: f64,
    /// Number of repetitions.
    pub repeats: usize,
    /// Ratios that were measured.
    pub rows: Vec<Row>,
}

/// Measured ratio.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Description of the two sides of the ratio.
    pub what: String,
    /// Value that the ratio should reach, if there is one.
    pub bar: Option<f64>,
    /// True if the ratio should be at least the bar, false if at most.
    pub at_least: bool,
    /// Measurements; none if the row could not be measured.
    pub cases: Vec<Case>,
    /// Reason why there are no measurements.
    pub left_out: Option<String>,
}

/// Measurements of one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Case {
    /// Size and load.
    pub of: String,
    /// Threads.
    pub threads: usize,
    /// Numerator of the ratio in each repetition: seconds, or bytes.
    pub found: Vec<f64>,
    /// Denominator in the same repetitions: seconds, or the bytes of a field.
    pub over: Vec<f64>,
}

impl Case {
    /// Returns the median of the ratios of the repetitions.
    pub fn ratio(&self) -> f64 {
        median(&self.found.iter().zip(&self.over).map(|(found, over)| found / over).collect::<Vec<_>>())
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

impl Row {
    /// Returns the ratio of the case that is farthest from the bar.
    pub fn worst(&self) -> Option<f64> {
        let ratios = self.cases.iter().map(Case::ratio);
        ratios.reduce(|a, b| if self.at_least == (a < b) { a } else { b })
    }

    /// Returns true if a ratio reaches the bar; `None` without a bar.
    pub fn is_met_by(&self, ratio: f64) -> Option<bool> {
        self.bar.map(|bar| if self.at_least { ratio >= bar } else { ratio <= bar })
    }
}

/// Runs the command.
///
/// # Errors
/// Invalid input; a solve that fails; a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Rows, Failure> {
    let args = args.resolved()?;
    let trial = Trial::new(&args, session)?;
    let mut rows = Rows {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        version: env!("CARGO_PKG_VERSION").into(),
        commit: GIT_COMMIT.into(),
        hurst: args.hurst,
        repeats: args.repeats,
        rows: Vec::new(),
    };
    rows.add(trial.processes()?);
    rows.add(trial.report()?);
    rows.add(trial.tamaas()?);
    rows.add(trial.ramp()?);
    rows.add(trial.flow()?);
    rows.add(trial.many()?);
    rows.add(trial.memory()?);
    rows.add(trial.threads()?);
    if let Some(page) = &args.write_docs {
        rows.write(&args.data, page.as_deref().unwrap_or(Path::new("docs/benchmarks.md")))?;
    }
    Ok(rows)
}

/// Returns the tables in a place of a page with the markers of the place. The place is empty if there is no such page.
pub(super) fn section(page: &Path, place: &str) -> String {
    let (start, end) = (format!("<!-- results: {place} -->\n"), "<!-- end -->\n");
    let text = std::fs::read_to_string(page).unwrap_or_default();
    let found = text.split_once(&start).and_then(|(_, rest)| Some(rest.split_once(end)?.0));
    format!("{start}{}{end}\n", found.unwrap_or_default())
}

impl Rows {
    fn add(&mut self, rows: Vec<Row>) {
        for row in &rows {
            tracing::info!("{}: {:?}, bar {:?}", row.what, row.worst(), row.bar);
        }
        self.rows.extend(rows);
    }

    fn write(&self, data: &Path, page: &Path) -> Result<(), Failure> {
        let cannot =
            |file: &Path, error: &dyn fmt::Display| Failure::computation(format!("{}: {error}", file.display()));
        let text = std::fs::read_to_string(page).map_err(|error| cannot(page, &error))?;
        let text = filled(&text, PLACE, &self.markdown())?;
        let json = gfmd_input::json::to_string(self).map_err(|error| cannot(data, &error))?;
        data.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(|error| cannot(data, &error))?;
        write_beside(data, &(json + "\n"))?;
        write_beside(page, &text)
    }

    /// Returns the table of all cases, or of those farthest from the aims.
    fn table(&self, all: bool) -> Table {
        let head = ["what", "case", "smallest of each", "median ratio", "aim", "met"];
        let mut rows = Vec::new();
        for row in &self.rows {
            let sign = if row.at_least { "≥" } else { "≤" };
            let bar = row.bar.map_or_else(|| "-".into(), |bar| format!("{sign} {bar}"));
            if let Some(reason) = &row.left_out {
                rows.push([&row.what, reason, "-", "-", &bar, "-"].map(str::to_owned).into());
            }
            let shown = |case: &&Case| all || row.bar.is_none() || row.worst() == Some(case.ratio());
            for case in row.cases.iter().filter(shown) {
                let met = row.is_met_by(case.ratio()).map_or("-", |met| if met { "yes" } else { "no" });
                let sides = [&case.found, &case.over].map(|values| amount(least(values)));
                rows.push(vec![
                    row.what.clone(),
                    format!("{}, {}", case.of, in_words(case.threads)),
                    sides.join(" / "),
                    format!("{:.3}", case.ratio()),
                    bar.clone(),
                    met.into(),
                ]);
            }
        }
        Table { title: "Commands beside the solution alone".into(), head: head.map(str::to_owned).into(), rows }
    }

    fn markdown(&self) -> String {
        let Self { date, machine, version, commit, hurst, repeats, .. } = self;
        let short = commit.get(..12).unwrap_or(commit);
        let mut text = self.table(false).markdown();
        let _ = write!(
            text,
            "\n{date}. {machine}. gfmd {version}, commit {short}. Surfaces as above, H = {hurst}. Seconds, or MB. \
             Both sides in\nturns, {repeats} times. The median ratio is compared with the aim; the case farthest \
             from it is shown ([all cases](../data/benchmarks/rows.json)).\n`cargo xtask bench-rows --python PYTHON \
             --tamaas --write-docs` makes this table with a PYTHON that has gfmd.\n\n"
        );
        text
    }
}

/// Formats seconds, or megabytes, to four digits.
fn amount(value: f64) -> String {
    if value > 1e5 { format!("{:.0}", value / 1e6) } else { format!("{value:.4}") }
}

impl fmt::Display for Rows {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}; gfmd {}, commit {}\n\n{}", self.machine, self.version, self.commit, self.table(true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(found: &[f64], over: &[f64]) -> Case {
        Case { of: "128 x 128".into(), threads: 1, found: found.into(), over: over.into() }
    }

    fn row(at_least: bool, cases: Vec<Case>) -> Row {
        Row { what: "a over b".into(), bar: Some(2.0), at_least, cases, left_out: None }
    }

    #[test]
    fn the_case_farthest_from_the_bar_is_the_worst() {
        let cases = || vec![case(&[3.0, 2.0, 40.0], &[2.0, 1.0, 40.0]), case(&[5.0], &[2.0])];
        assert_eq!(cases()[0].ratio(), 1.5);
        let (most, least) = (row(false, cases()), row(true, cases()));
        assert_eq!([most.worst(), least.worst()], [Some(2.5), Some(1.5)]);
        assert_eq!([1.5, 2.0, 2.5, f64::NAN].map(|ratio| most.is_met_by(ratio)), [true, true, false, false].map(Some));
        assert_eq!([1.5, 2.0, 2.5, f64::NAN].map(|ratio| least.is_met_by(ratio)), [false, true, true, false].map(Some));
        assert_eq!(row(true, Vec::new()).worst(), None);
        assert_eq!(Row { bar: None, ..least }.is_met_by(1.0), None);
    }

    #[test]
    fn the_tables_keep_their_place_on_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let (data, page) = (folder.path().join("data/rows.json"), folder.path().join("page.md"));
        assert_eq!(section(&page, PLACE), "<!-- results: rows -->\n<!-- end -->\n\n");
        let left_out = Row { left_out: Some("no Python".into()), ..row(false, Vec::new()) };
        let rows = Rows {
            date: "2026-01-02".into(),
            machine: "a processor".into(),
            version: "0.1.0".into(),
            commit: "0123456789abcdef".into(),
            hurst: 0.0,
            repeats: 3,
            rows: vec![row(false, vec![case(&[0.3], &[0.1])]), left_out],
        };
        assert!(rows.write(&data, &page).is_err(), "there is no page");
        std::fs::write(&page, format!("# Title\n{}## Method\n", section(&page, PLACE))).unwrap();
        rows.write(&data, &page).unwrap();
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.contains("0.3000 / 0.1000 |"), "{text}");
        assert!(text.contains("no Python"), "{text}");
        assert!(text.contains("≤ 2 |"), "{text}");
        assert!(text.starts_with("# Title\n") && text.ends_with("## Method\n"));
        assert!(text.contains(&section(&page, PLACE)));
        assert!(std::fs::read_to_string(&data).unwrap().contains("\"at_least\":false"));
    }
}
