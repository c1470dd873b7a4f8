//! Random combinations: body x boundary x interaction x components x hardness x slopes x load x lower surface x
//! outlets. The program solves small problems as for a user, and every resulting number is compared with an independent
//! implementation of its definition: plain loops, direct Fourier sums, layered bodies wave by wave, Gaussian
//! elimination (docs/reliability.md, "Random combinations").
//!
//! `GFMD_COMBINATIONS=20000 cargo test --release -p gfmd-cli --test suite combinations:: -- --nocapture` sets the
//! number of cases and prints counts; `GFMD_COMBINATION=N` runs only case N and keeps its folder, and
//! `GFMD_HISTORY=N` does so for a history, `GFMD_PARTS=N` for the parts of a path.

#![expect(clippy::print_stdout, reason = "the counts of cases")]

mod contact;
mod draw;
mod elastic;
mod found;
mod histories;
mod numbers;
mod outlets;
mod parts;
mod path;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::common::gfmd;
use draw::Case;
use found::Found;
use gfmd_files::Reader;
use histories::History;
use parts::Parts;
use serde_json::Value;

/// Number of cases in the default run.
const CASES: u64 = 120;

/// Number of histories drawn in the default run, before histories of other kinds are left out.
const HISTORIES: u64 = 20;

/// Number of paths with random parts in the default run.
const PATHS: u64 = 20;

/// Cases of longer runs that exposed a wrong program or definition; the default run includes them.
const ONCE_WRONG: [u64; 16] =
    [2035, 2116, 3319, 3609, 3801, 3926, 4075, 7036, 10375, 11128, 11906, 12359, 14683, 15879, 17026, 19643];

/// Paths of longer runs that exposed a wrong program; the default run includes them.
const PATHS_ONCE_WRONG: [u64; 12] = [78, 123, 130, 142, 169, 172, 183, 246, 261, 333, 351, 1235];

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    Solved,
    Refused,
    Failed,
}

/// Returns the first word of a refusal, which names the flag.
fn reason(reported: &str) -> String {
    let reported = reported.trim_start_matches("error: ");
    reported.split([':', ' ', ',']).next().unwrap_or_default().to_owned()
}

/// Returns the words of a case with lengths in micrometres and stresses in pascals, each number with its unit: the same
/// problem, bit for bit.
fn with_units(words: &[String]) -> Vec<String> {
    let number = |text: &str, unit: &str| match text.parse::<f64>() {
        Ok(value) if value.is_finite() => format!("{text}{unit}"),
        _ => text.to_owned(),
    };
    let entry = |flag: &str, place: usize, text: &str| -> String {
        if let ("--param", Some((name, value))) = (flag, text.split_once('=')) {
            let unit = match name {
                "gamma" | "phi_n" | "phi_t" => " µJ/m^2",
                "range" | "delta_n" | "delta_t" => "um",
                "curvature" => "Pa/um",
                _ => "",
            };
            return format!("{name}={}", number(value, unit));
        }
        if let ("--law-table", Some((gap, traction))) = (flag, text.split_once(':')) {
            return format!("{}:{}", number(gap, "um"), number(traction, "Pa"));
        }
        let unit = match flag {
            "--young" | "--e-star" | "--base-young" | "--pressure" | "--shear-strength" | "--hardness" => "Pa",
            "--height" | "--size" | "--shift" | "--rms-height" | "--approach" | "--lateral" | "--conductor-height" => {
                "um"
            }
            "--layer" | "--second-body" => ["Pa", "", "um"][place],
            _ => "",
        };
        match text.split(':').collect::<Vec<_>>()[..] {
            [first, last, count] => format!("{}:{}:{count}", number(first, unit), number(last, unit)),
            _ => number(text, unit),
        }
    };
    let entries = |flag: &str, value: &str| {
        value.split(',').enumerate().map(|(place, text)| entry(flag, place, text)).collect::<Vec<_>>().join(",")
    };
    let mut found = Vec::new();
    let mut flag = "";
    for word in words {
        match word.split_once('=').filter(|_| word.starts_with("--")) {
            Some((name, value)) => found.push(format!("{name}={}", entries(name, value))),
            None if word.starts_with("--") => found.push(word.clone()),
            None => found.push(entries(flag, word)),
        }
        flag = if word.starts_with("--") { word } else { "" };
    }
    if !words.iter().any(|word| word.starts_with("--young") || word.starts_with("--e-star")) {
        found.extend(["--young", "1Pa"].map(String::from));
    }
    found.extend(["--unit", "um"].map(String::from));
    found
}

/// Runs a case and checks all its output.
fn run(case: &Case, folder: &Path, found: &mut Found) -> (End, String) {
    let out = format!("out{}.h5", case.index);
    let bare: Vec<&str> = case.words.iter().map(String::as_str).collect();
    let with_units = case.index.is_multiple_of(4).then(|| with_units(&case.words));
    let mut words: Vec<&str> = with_units.as_ref().unwrap_or(&case.words).iter().map(String::as_str).collect();
    words.extend(["--json", "-q", "--threads", "1", "--out", &out]);
    if let Some(vtk) = &case.vtk {
        words.extend(["--vtk", vtk]);
    }
    let output = gfmd(folder, &words);
    let (reported, text) = (String::from_utf8_lossy(&output.stderr), String::from_utf8_lossy(&output.stdout));
    let lines: Vec<&str> = reported.trim_end().lines().collect();
    match output.status.code() {
        Some(2) => {
            let names = ["--", ".npy"].iter().any(|name| lines[0].contains(name));
            let one = lines.len() == 1 && lines[0].starts_with("error") && names && lines[0].len() < 700;
            found.must(one && text.is_empty(), || format!("a refusal of {} lines: {reported}", lines.len()));
            found.must(!folder.join(&out).exists(), || "a refused case has a file".into());
            return (End::Refused, reason(&reported));
        }
        Some(1) => {
            let says = lines.last().is_some_and(|line| {
                line.starts_with("error")
                    && ["converge", "search", "part", "finite", "separate", "touch"]
                        .iter()
                        .any(|word| line.contains(word))
            });
            found.must(says && !reported.contains("panicked"), || format!("an unexpected failure: {reported}"));
            return (End::Failed, lines.last().unwrap_or(&"").to_string());
        }
        Some(0) => {}
        status => {
            found.complain(format!("status {status:?}: {reported}"));
            return (End::Failed, String::new());
        }
    }
    let Ok(report) = serde_json::from_str::<Value>(&text) else {
        found.complain(format!("no JSON: {text}"));
        return (End::Solved, String::new());
    };
    let file = Reader::open(folder.join(&out)).unwrap();
    found.must(matches!(file.is_intact(), Ok(Some(true))), || "the file does not have its checksum".into());
    let (key, group) = if case.is_path { ("steps", "/path") } else { ("loads", "/loads") };
    let records = report[key].as_array().unwrap();
    if case.is_path {
        path::check(found, case, folder, &report, &file);
    } else {
        contact::check(found, case, &report, &file);
    }
    outlets::file(found, records, &file, group);
    if let Some(vtk) = &case.vtk {
        outlets::vtk(found, case, &std::fs::read(folder.join(vtk)).unwrap(), &file);
    }
    if case.index.is_multiple_of(3) {
        let mut words = bare;
        words.extend(["--threads", "1", "--wide"]);
        let output = gfmd(folder, &words);
        found.must(output.status.success(), || "the table: another status".into());
        outlets::table(found, &String::from_utf8_lossy(&output.stdout), records, case.is_path);
    }
    if case.threshold {
        outlets::threshold(found, case, folder, &report);
    }
    outlets::further(found, case, folder, (&out, with_units.as_ref().unwrap_or(&case.words)), &report);
    (End::Solved, String::new())
}

#[derive(Default)]
struct Counts {
    ends: BTreeMap<(String, End), usize>,
    refused: BTreeMap<String, usize>,
    undefined: BTreeMap<String, usize>,
    noted: BTreeMap<String, usize>,
    compared: usize,
    bad: Vec<String>,
}

/// Random problem.
trait Problem: Sync {
    /// Returns the command.
    fn words(&self) -> String;

    /// Returns its kinds.
    fn kinds(&self) -> Vec<&'static str>;

    /// Solves the problem and checks all its output; returns its end, with the reason if there is no result.
    fn run(&self, folder: &Path, found: &mut Found) -> (End, String);
}

impl Problem for Case {
    fn words(&self) -> String {
        format!("{} [{}]", self.words.join(" "), self.further)
    }

    fn kinds(&self) -> Vec<&'static str> {
        Self::kinds(self)
    }

    fn run(&self, folder: &Path, found: &mut Found) -> (End, String) {
        run(self, folder, found)
    }
}

/// Runs the problems returned by `draw` for all seeds below the number of cases, or only the case named by `alone`. All
/// must be right, and some of each kind must be solved. Returns the number of compared numbers.
fn survey<P: Problem>(
    alone: &str,
    default: u64,
    once_wrong: &[u64],
    draw: impl Fn(u64, &Path) -> Option<P> + Sync,
) -> usize {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().expect("a number of cases"));
    let name = alone;
    let alone = number(name);
    let cases = number("GFMD_COMBINATIONS").unwrap_or(default);
    let started = Instant::now();
    let drawn: Vec<u64> = match alone {
        Some(alone) => vec![alone],
        None => (0..cases).chain(once_wrong.iter().copied().filter(|index| *index >= cases)).collect(),
    };
    let next = AtomicUsize::new(0);
    let counts = Mutex::new(Counts::default());
    let threads = std::thread::available_parallelism().map_or(2, usize::from).max(2);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(index) = drawn.get(next.fetch_add(1, Ordering::Relaxed)).copied() {
                    let folder = tempfile::tempdir().unwrap();
                    let Some(problem) = draw(index, folder.path()) else { continue };
                    let mut found = Found::default();
                    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                        problem.run(folder.path(), &mut found)
                    }));
                    let (ended, why) = outcome.unwrap_or_else(|_| {
                        found.complain("the test panicked".into());
                        (End::Failed, String::new())
                    });
                    let words = problem.words();
                    if alone.is_some() {
                        println!("{words}\n{ended:?} {why}, in {}", folder.keep().display());
                    }
                    let mut counts = counts.lock().unwrap();
                    counts.compared += found.compared;
                    for kind in problem.kinds().into_iter().chain(["all"]) {
                        *counts.ends.entry((kind.into(), ended)).or_default() += 1;
                    }
                    if ended == End::Refused {
                        *counts.refused.entry(why).or_default() += 1;
                    }
                    for (reason, count) in found.undefined {
                        *counts.undefined.entry(reason).or_default() += count;
                    }
                    for (event, count) in found.noted {
                        *counts.noted.entry(event).or_default() += count;
                    }
                    if !found.complaints.is_empty() {
                        let all = found.complaints.len();
                        let shown: Vec<String> = found.complaints.into_iter().take(4).collect();
                        counts.bad.push(format!("{name}={index}: gfmd {words}\n    {all}: {}", shown.join("\n    ")));
                    }
                }
            });
        }
    });
    let Counts { ends, refused, undefined, noted, compared, bad } = counts.into_inner().unwrap();
    let of = |kind: &str, end: End| ends.get(&(kind.to_owned(), end)).copied().unwrap_or(0);
    let taken = [End::Solved, End::Refused, End::Failed].map(|end| of("all", end)).iter().sum::<usize>();
    println!("{taken} cases in {:.0} s, {compared} comparisons, {} bad", started.elapsed().as_secs_f64(), bad.len());
    let mut kinds: Vec<&String> = ends.keys().map(|(kind, _)| kind).collect();
    kinds.dedup();
    for kind in kinds {
        println!(
            "{kind:>24}: {} solved, {} refused, {} not converged",
            of(kind, End::Solved),
            of(kind, End::Refused),
            of(kind, End::Failed)
        );
    }
    println!("refused by: {refused:?}\nnull for a reason: {undefined:#?}\ncounted: {noted:#?}");
    assert!(bad.is_empty(), "{} of {taken} cases are bad:\n{}", bad.len(), bad.join("\n"));
    if alone.is_none() && cases >= default {
        assert!(of("all", End::Solved) * 2 > taken, "most problems can be solved");
        for (kind, _) in ends.keys() {
            assert!(of(kind, End::Solved) > 0, "{kind}: nothing solved");
        }
    }
    compared
}

#[test]
fn every_number_of_a_random_combination_is_its_definition() {
    let compared = survey("GFMD_COMBINATION", CASES, &ONCE_WRONG, |index, folder| Some(Case::draw(index, folder)));
    assert!(compared > 0);
}

#[test]
fn every_command_reads_the_result_of_a_random_history() {
    let compared = survey("GFMD_HISTORY", HISTORIES, &[], History::draw);
    assert!(compared > 0);
}

#[test]
fn every_part_of_a_random_path_keeps_its_law() {
    let compared = survey("GFMD_PARTS", PATHS, &PATHS_ONCE_WRONG, |index, folder| Some(Parts::draw(index, folder)));
    assert!(compared > 0);
}
