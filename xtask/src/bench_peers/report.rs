//! Report of the measurements as JSON, as text tables, and as a page of the documentation.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};

use gfmd_input::failure::Failure;
use serde::{Deserialize, Serialize};

use super::TamaasFftw;
use super::contestant::Problem;
use super::judge::{AGREEMENT, Verdict};
use super::kept;
use super::table::{Table, in_words, median, write_beside};
use super::{adhesion, rows, yielding};

/// Result of `bench-peers`.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Commit of this program.
    pub commit: String,
    /// Versions of all programs and packages.
    pub versions: BTreeMap<String, String>,
    /// FFTW of the yardstick.
    pub fftw: String,
    /// FFTW used by Tamaas.
    pub tamaas_fftw: TamaasFftw,
    /// Names of the contestants; the first is the reference of the comparisons.
    pub contestants: Vec<String>,
    /// Boundary of the surfaces.
    pub boundary: &'static str,
    /// Bound on the certified residuals.
    pub tolerance: f64,
    /// Seed of the surfaces.
    pub seed: u64,
    /// One case per load and surface.
    pub cases: Vec<Case>,
    /// Notes for readers of the results.
    pub notes: Vec<String>,
    /// File of this report.
    pub kept: PathBuf,
}

/// Measurements of one load on one surface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// Points along a side.
    pub n: usize,
    /// Hurst exponent.
    pub hurst: f64,
    /// Reduced pressure.
    pub p_star: f64,
    /// Mean pressure in units of E*.
    pub mean_pressure: f64,
    /// Timings, one per number of threads.
    pub timings: Vec<Timing>,
}

/// Timings of all contestants at one number of threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Timing {
    /// Number of threads allowed.
    pub threads: usize,
    /// Wall time of one pair of transforms by FFTW on this number of threads.
    pub yardstick_seconds: f64,
    /// Processor time of the yardstick divided by the product of its wall time and threads. A value below 1 on one
    /// thread means that other processes were running.
    pub processor_share: f64,
    /// One entry per contestant.
    pub entries: Vec<Entry>,
}

/// Measurements of one contestant.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the contestant.
    pub name: String,
    /// Number of threads used; 1 if the contestant cannot use more.
    pub threads: usize,
    /// Wall time of the solve, set-up excluded: the median of `all_seconds`.
    pub seconds: f64,
    /// Times of all repeats.
    pub all_seconds: Vec<f64>,
    /// `seconds` in pairs of the yardstick.
    pub cost: f64,
    /// `seconds` divided by `seconds` of the first contestant.
    pub slower: f64,
    /// Iterations of the solver.
    pub iterations: Option<u64>,
    /// Transform pairs that the contestant computed.
    pub transform_pairs: Option<f64>,
    /// Largest resident memory of the process.
    pub peak_bytes: u64,
    /// `peak_bytes` minus the memory of the program with all packages loaded and without a surface.
    pub own_bytes: u64,
    /// Tolerance given to the solver, in the measure of the solver.
    pub tolerance: f64,
    /// Verdict on the final pressure.
    pub verdict: Verdict,
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {:.4} s, {:.0} pairs, x {:.1}", self.name, self.seconds, self.cost, self.slower)?;
        write!(f, ", certified {:.1e}, pressure differs by {:.1e}", self.verdict.worst(), self.verdict.differs.pressure)
    }
}

impl Case {
    /// Returns true if the case belongs to `problem` on these numbers of threads.
    pub(super) fn is_of(&self, problem: &Problem, threads: &[usize]) -> bool {
        (self.n, self.hurst, self.p_star) == (problem.points, problem.hurst, problem.p_star)
            && self.timings.iter().map(|timing| timing.threads).eq(threads.iter().copied())
    }
}

/// Figure of the page.
const FIGURE: &str = "images/benchmarks.svg";

/// Results of an interrupted run.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Interrupted {
    pub(super) cases: Vec<Case>,
    pub(super) notes: Vec<String>,
}

/// Share of a processor for the yardstick below which the page has a warning.
const BUSY: f64 = 0.9;

impl Report {
    /// Writes the report to its file, so that a later failure does not lose it.
    pub(super) fn keep(&self) -> Result<(), Failure> {
        let text = gfmd_input::json::to_string(self).map_err(|error| Failure::computation(error.to_string()))?;
        write_beside(&self.kept, &(text + "\n"))
    }

    /// Returns the cases and notes of an interrupted run with the settings of this one.
    pub(super) fn resumed(&self) -> Result<Interrupted, Failure> {
        kept::read(&self.kept, self, &["date", "cases", "notes", "kept"])
    }

    /// Returns the failure with the name of the file with the finished cases.
    pub(super) fn keep_after(&self, failure: Failure) -> Failure {
        if self.cases.is_empty() {
            return failure;
        }
        let kept = format!("; the {} finished cases are kept in {}", self.cases.len(), self.kept.display());
        failure.with(&kept)
    }

    /// Writes the page of the documentation, and its figure to the folder `images` beside it. The tables of
    /// `bench-rows`, `--adhesion` and `--yielding` stay on the page.
    pub(super) fn write_page(&self, file: &Path) -> Result<(), Failure> {
        let figure = file.with_file_name(FIGURE);
        let unmade = |error| Failure::computation(format!("cannot make the folder of {}: {error}", figure.display()));
        figure.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(unmade)?;
        write_beside(&figure, &self.figure()?)?;
        write_beside(
            file,
            &self.page(
                &[rows::PLACE, adhesion::PLACE, yielding::PLACE].map(|place| rows::section(file, place)).concat(),
            ),
        )
    }

    fn threads(&self) -> Vec<usize> {
        self.cases.first().map_or_else(Vec::new, |case| case.timings.iter().map(|timing| timing.threads).collect())
    }

    /// Returns a table with a row per case on the largest grid and a column per contestant, with the time of a pair if
    /// `with_pair`.
    fn by_case(&self, threads: usize, title: String, with_pair: bool, cell: impl Fn(&Entry) -> String) -> Table {
        let first = ["n", "H", "p*"].map(str::to_owned).into_iter().chain(with_pair.then(|| "pair, ms".to_owned()));
        let head = first.chain(self.contestants.iter().cloned());
        let row = |case: &Case| {
            let timing = case.timings.iter().find(|timing| timing.threads == threads)?;
            let pair = with_pair.then(|| format!("{:.3}", 1e3 * timing.yardstick_seconds));
            let first = [case.n.to_string(), case.hurst.to_string(), case.p_star.to_string()];
            let entry = |name: &String| timing.entries.iter().find(|entry| entry.name == *name);
            let cells = self.contestants.iter().map(|name| entry(name).map_or_else(|| "-".into(), &cell));
            Some(first.into_iter().chain(pair).chain(cells).collect())
        };
        let largest = self.cases.iter().map(|case| case.n).max();
        let cases = self.cases.iter().filter(|case| Some(case.n) == largest);
        Table { title: title + ", largest grid", head: head.collect(), rows: cases.filter_map(row).collect() }
    }

    fn costs(&self, threads: usize) -> Table {
        let title = format!(
            "Cost in pairs of FFTW, {}; in brackets: ratio to the first; seconds are cost times pair",
            in_words(threads)
        );
        self.by_case(threads, title, true, |entry| {
            if entry.name == self.contestants[0] {
                return format!("{:.0}", entry.cost);
            }
            format!("{:.0} ({:.1})", entry.cost, entry.slower)
        })
    }

    fn work(&self, threads: usize) -> Table {
        self.by_case(threads, "Iterations / transform pairs computed".into(), false, |entry| {
            let pairs = entry.transform_pairs.map_or_else(|| "?".into(), |pairs| format!("{pairs:.0}"));
            let iterations = entry.iterations.map_or_else(|| "?".into(), |iterations| iterations.to_string());
            format!("{iterations} / {pairs}")
        })
    }

    /// Describes the largest certified residual and the largest differences from the first contestant.
    fn certificate(&self) -> String {
        let timings = self.cases.iter().flat_map(|case| &case.timings);
        let verdicts: Vec<&Verdict> = timings.flat_map(|timing| &timing.entries).map(|entry| &entry.verdict).collect();
        let worst = |value: fn(&Verdict) -> f64| gfmd_relax::worst(verdicts.iter().map(|verdict| value(verdict)));
        let points = verdicts.iter().map(|verdict| verdict.differs.points).max().unwrap_or(0);
        format!(
            "The largest certified residual is {:.1e}; pressures differ by at most {:.0e} (rms, relative), contacts in \
             at most\n\
             {points} points.",
            worst(Verdict::worst),
            worst(|verdict| verdict.differs.pressure)
        )
    }

    /// Returns a table of the largest memory of each contestant at each size and number of threads.
    fn memory(&self) -> Table {
        let mut rows = Vec::new();
        let mut sizes: Vec<usize> = self.cases.iter().map(|case| case.n).collect();
        sizes.dedup();
        for n in sizes {
            let field = (n * n * 8) as f64;
            for threads in self.threads() {
                let most = |name: &String| {
                    let timings = self.cases.iter().filter(|case| case.n == n).flat_map(|case| &case.timings);
                    let entries = timings.filter(|t| t.threads == threads).flat_map(|t| &t.entries);
                    let largest = entries.filter(|entry| entry.name == *name).max_by_key(|entry| entry.own_bytes);
                    largest.map_or_else(
                        || "-".into(),
                        |entry| format!("{:.1} ({:.0})", entry.own_bytes as f64 / field, entry.peak_bytes as f64 / 1e6),
                    )
                };
                rows.push(
                    [n.to_string(), threads.to_string()].into_iter().chain(self.contestants.iter().map(most)).collect(),
                );
            }
        }
        let head = ["n", "threads"].map(str::to_owned).into_iter().chain(self.contestants.iter().cloned()).collect();
        Table {
            title: "Peak memory in fields of n x n doubles (in brackets: of the whole process, MB)".into(),
            head,
            rows,
        }
    }

    /// Returns a table of the smallest, median and largest time ratios at each size and number of threads.
    fn ratios(&self) -> Table {
        let mut rows = Vec::new();
        let mut sizes: Vec<usize> = self.cases.iter().map(|case| case.n).collect();
        sizes.dedup();
        for n in sizes {
            for threads in self.threads() {
                let spread = |name: &String| {
                    let timings = self.cases.iter().filter(|case| case.n == n).flat_map(|case| &case.timings);
                    let entries = timings.filter(|t| t.threads == threads).flat_map(|t| &t.entries);
                    let mut found: Vec<f64> = entries.filter(|entry| entry.name == *name).map(|e| e.slower).collect();
                    found.sort_unstable_by(f64::total_cmp);
                    match (found.first(), found.last()) {
                        (Some(least), Some(most)) => {
                            format!("{least:.1} / {:.1} / {most:.1}", median(&found))
                        }
                        _ => "-".into(),
                    }
                };
                let first = [n.to_string(), threads.to_string()];
                rows.push(first.into_iter().chain(self.contestants.iter().skip(1).map(spread)).collect());
            }
        }
        let head =
            ["n", "threads"].map(str::to_owned).into_iter().chain(self.contestants.iter().skip(1).cloned()).collect();
        let ours = self.contestants.first().map_or("the first", String::as_str);
        let title = format!("Time divided by the time of {ours}, finished cases: smallest / median / largest");
        Table { title, head, rows }
    }

    fn tables(&self) -> [Table; 4] {
        let first = self.threads().first().copied().unwrap_or(1);
        [self.ratios(), self.costs(first), self.work(first), self.memory()]
    }

    /// Returns a warning if other processes used the processor during the run.
    fn disturbance(&self) -> Option<String> {
        let timings = self.cases.iter().flat_map(|case| &case.timings).filter(|timing| timing.threads == 1);
        let least = timings.map(|timing| timing.processor_share).fold(f64::INFINITY, f64::min);
        (least < BUSY).then(|| {
            format!(
                "The machine was busy with other work: at worst the yardstick got {:.0} % of a processor. Ratios are \
                 more reliable than seconds, and both less reliable than on an idle machine.",
                100.0 * least
            )
        })
    }

    /// Returns the page with the tables that it keeps.
    pub(super) fn page(&self, kept: &str) -> String {
        let Self { date, machine, commit, fftw, seed, tolerance, boundary, .. } = self;
        let versions: Vec<String> = self.versions.iter().map(|(name, version)| format!("{name} {version}")).collect();
        let (versions, short) = (versions.join(", "), commit.get(..12).unwrap_or(commit));
        let programs = self.contestants.join(", ");
        let plans = match self.tamaas_fftw {
            TamaasFftw::Preloaded => "with this FFTW preloaded, since the FFTW of its package has no vector code",
            TamaasFftw::Tuned => "with this FFTW preloaded and measured plans, which its users do not have",
            TamaasFftw::Own => "with the FFTW of its package, which has no vector code",
        };
        let mut page = format!(
            "<!-- Written by `cargo xtask bench-peers --write-docs`; change xtask/src/bench_peers/report.rs instead. \
             -->\n\
             # Against other programs\n\n\
             Time, memory and iterations of {programs}, for the same contacts to the same certified residual.\n\
             [Any load](any-load.md): loads that each program reaches; [solvers](solvers.md): cost of gfmd.\n\n\
             {date}. {machine}. Commit {short}. {versions}. FFTW: {fftw}.\n\n\
             Half-space, hard wall, {boundary} boundaries, E\\* = 1, self-affine surfaces with rms gradient 0.1, \
             1/ε_t = 2, 1/ε_c = 4 ([glossary](glossary.md)), seed {seed}. Tamaas ran {plans}.\n\n"
        );
        let (unfinished, notes): (Vec<_>, Vec<_>) = self.notes.iter().partition(|note| note.contains(LEFT_OUT));
        for note in self.disturbance().iter().chain(notes) {
            let _ = writeln!(page, "> {note}\n");
        }
        page += &dashes(&unfinished);
        let first = in_words(self.threads().first().copied().unwrap_or(1));
        let _ =
            writeln!(page, "![seconds on {first} against load and size]({FIGURE})\n\nTime of a solution on {first}.\n");
        for table in self.tables() {
            let _ = writeln!(page, "{}", table.markdown());
        }
        let _ = write!(
            page,
            "{}\n\n{kept}{}",
            self.certificate(),
            include_str!("method.md")
                .replace("{tolerance}", &format!("{tolerance:e}"))
                .replace("{agreement}", &format!("{AGREEMENT:e}"))
        );
        page
    }
}

/// Words of a note between a program and a case that it did not finish; a colon and the reason follow.
pub(super) const LEFT_OUT: &str = " is left out at ";

/// Returns the line that explains the dashes of the tables: how many cases a program did not finish, and why. Empty if
/// all programs finished all cases.
fn dashes(unfinished: &[&String]) -> String {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for note in unfinished {
        let (program, rest) = note.split_once(LEFT_OUT).unwrap_or((note, ""));
        let reason = rest.split_once(": ").map_or("", |(_, reason)| reason);
        *counts.entry((program, reason)).or_default() += 1;
    }
    let line = |((program, reason), count): (&(&str, &str), &usize)| {
        format!("{program} in {count} case{}: {reason}", if *count == 1 { "" } else { "s" })
    };
    let lines: Vec<String> = counts.iter().map(line).collect();
    match lines.is_empty() {
        true => String::new(),
        false => format!("A dash is a case without a result: {}.\n\n", lines.join("; ")),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}; FFTW: {}; all results certified to {:e}\n", self.machine, self.fftw, self.tolerance)?;
        for table in self.tables() {
            writeln!(f, "{table}")?;
        }
        writeln!(f, "{}", self.certificate())?;
        for note in self.disturbance().iter().chain(&self.notes) {
            writeln!(f, "note: {note}")?;
        }
        writeln!(f, "kept: {}", self.kept.display())
    }
}
