use std::collections::BTreeMap;
use std::convert::Infallible;
use std::process::Command;
use std::time::{Duration, Instant};

use gfmd_contact::{Boundary, Solver};
use gfmd_input::session::Session;
use proptest::prelude::*;

use super::any_load::{AnyLoad, Block, Cell, ContactVariant, LOADS, Row};
use super::contestant::Contestant;
use super::judge::{Difference, Verdict};
use super::process::{ProgramFailure, output};
use super::report::{Case, Entry, Interrupted, LEFT_OUT, Report, Timing};
use super::table::median;
use super::tolerance::{Found, loosest};
use super::{Args, Peer, TamaasFftw};

fn session() -> Session {
    Session::silent()
}

fn search(target: f64, first: f64, residual: impl Fn(f64) -> f64) -> (Option<Found<()>>, usize) {
    let mut solves = 0;
    let found = loosest(target, first, |tolerance| {
        solves += 1;
        Ok::<_, Infallible>((residual(tolerance), ()))
    });
    (found.unwrap(), solves)
}

proptest! {
    #[test]
    fn a_proportional_residual_is_found_in_few_solves(factor in -4.0..4.0_f64, first in -12.0..-4.0_f64) {
        let (target, first) = (1e-8, 10_f64.powf(first));
        let (found, solves) = search(target, first, |t| 10_f64.powf(factor) * t);
        let found = found.unwrap();
        prop_assert!(found.residual <= target && found.residual >= 0.3 * target, "{found:?}");
        prop_assert!(solves <= 5, "{solves}");
    }

    /// Iterations are discrete, so that the residual is a staircase below the tolerance.
    #[test]
    fn a_staircase_is_certified_and_left_at_its_loosest_step(
        step in 0.05..1.5_f64, shift in 0.0..1.0_f64, factor in -2.0..2.0_f64,
    ) {
        let target = 1e-8;
        let residual = |t: f64| {
            let steps = ((t.log10() + factor) / step - shift).floor() + shift;
            10_f64.powf(step * steps)
        };
        let (found, _) = search(target, 1e-8, residual);
        let found = found.unwrap();
        prop_assert!(found.residual <= target);
        prop_assert!(found.residual == residual(found.tolerance));
        // The residual is close to the target, or the next looser step fails.
        prop_assert!(found.residual >= 0.3 * target || residual(1.4 * found.tolerance) > target, "{found:?}");
    }
}

#[test]
fn what_cannot_be_certified_is_not_found() {
    let (found, solves) = search(1e-8, 1e-8, |_| 1e-5);
    assert!(found.is_none() && solves < 20);
    assert!(search(1e-8, 1e-8, |_| f64::NAN).0.is_none());
    let refused: Result<Option<Found<()>>, &str> = loosest(1e-8, 1e-8, |_| Err("broken"));
    assert_eq!(refused.unwrap_err(), "broken");
}

fn verdict(worst: f64, pressure: f64, points: u64) -> Verdict {
    let residual = [("complementarity", 0.1 * worst), ("penetration", worst), ("load", 1e-15)];
    let residual = residual.map(|(name, value)| (name.to_owned(), value)).into();
    let differs = Difference { points, pressure };
    Verdict { residual, area_fraction: 0.1, approach: 2.0, energy: 0.4, differs }
}

#[test]
fn whoever_is_not_certified_or_disagrees_is_objected_to() {
    assert_eq!(verdict(1e-8, 1e-7, 1).objection(1e-8, 512), None);
    assert!(verdict(1.01e-8, 0.0, 0).objection(1e-8, 512).unwrap().contains("certified residual is 1.010e-8"));
    assert!(verdict(f64::NAN, 0.0, 0).objection(1e-8, 512).is_some());
    assert!(verdict(1e-9, 1.1e-6, 0).objection(1e-8, 512).unwrap().contains("pressure differs by 1.100e-6"));
    assert!(verdict(1e-9, f64::NAN, 0).objection(1e-8, 512).is_some());
    assert!(verdict(1e-9, 0.0, 2).objection(1e-8, 512).unwrap().contains("2 of 512 x 512 points; it may differ in 1"));
    // The allowed difference on 2048 x 2048 points is 4 points.
    assert_eq!(verdict(1e-9, 0.0, 4).objection(1e-8, 2048), None);
    assert!(verdict(1e-9, 0.0, 5).objection(1e-8, 2048).is_some());
}

#[test]
fn the_median_is_in_the_middle() {
    assert!(median(&[]).is_nan());
    assert_eq!(median(&[3.0]), 3.0);
    assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
    assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), 2.5);
}

fn entry(name: &str, seconds: f64, slower: f64) -> Entry {
    Entry {
        name: name.into(),
        threads: 1,
        seconds,
        all_seconds: vec![seconds],
        cost: seconds / 1e-3,
        slower,
        iterations: Some(27),
        transform_pairs: None,
        peak_bytes: 50_000_000,
        own_bytes: 10 * 8 * 512 * 512,
        tolerance: 1e-8,
        verdict: verdict(9e-9, 2e-8, 0),
    }
}

fn report() -> Report {
    let case = |n, ratio: f64| {
        let mut entries = vec![entry("gfmd", 0.1, 1.0)];
        if n == 512 {
            entries.push(entry("Tamaas", 0.1 * ratio, ratio));
        }
        let timing =
            |threads| Timing { threads, yardstick_seconds: 1e-3, processor_share: 0.5, entries: entries.clone() };
        Case { n, hurst: 0.8, p_star: 0.05, mean_pressure: 0.005, timings: vec![timing(1), timing(2)] }
    };
    Report {
        date: "2026-01-02".into(),
        machine: "a processor".into(),
        commit: "0123456789abcdef".into(),
        versions: BTreeMap::from([("Tamaas".into(), "2.9.0".into())]),
        fftw: "fftw-3.3.10".into(),
        tamaas_fftw: TamaasFftw::Preloaded,
        contestants: vec!["gfmd".into(), "Tamaas".into()],
        boundary: "periodic",
        tolerance: 1e-8,
        seed: 1,
        cases: vec![case(512, 20.0), case(512, 30.0), case(512, 70.0), case(1024, 1.0)],
        notes: vec!["something to know".into()],
        kept: "kept.json".into(),
    }
}

#[test]
fn the_page_has_a_figure_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    report().write_page(&folder.path().join("page.md")).unwrap();
    let page = std::fs::read_to_string(folder.path().join("page.md")).unwrap();
    let figure = page.lines().find_map(|line| line.strip_prefix("![")?.split_once("](")?.1.strip_suffix(')')).unwrap();
    let figure = std::fs::read_to_string(folder.path().join(figure)).unwrap();
    // Only gfmd has finished the load at the largest size: no load has times at all sizes.
    assert!(figure.contains("gfmd") && !figure.contains("Tamaas") && !figure.contains(BY_SIZE), "{figure}");
    assert!(Report { cases: Vec::new(), ..report() }.figure().is_err());
}

#[test]
fn one_line_explains_all_cases_without_a_result() {
    let note = |p_star: f64| format!("Tamaas{LEFT_OUT}512 x 512, H = 0.8, p* = {p_star}: it takes longer than 60 s");
    let page = Report { notes: vec![note(0.1), note(0.2), "something to know".into()], ..report() }.page("");
    assert!(
        page.contains("\nA dash is a case without a result: Tamaas in 2 cases: it takes longer than 60 s.\n"),
        "{page}"
    );
    assert!(page.contains("> something to know") && !page.contains(LEFT_OUT), "{page}");
    assert!(!report().page("").contains("A dash"));
}

#[test]
fn no_line_crosses_what_was_left_out() {
    let report = report();
    let case = |p_star, has_all: bool| {
        let mut case = Case { p_star, ..report.cases[0].clone() };
        if !has_all {
            case.timings[0].entries.pop();
        }
        case
    };
    let lines = |finished: [bool; 5]| {
        let cases = finished.iter().zip(1..).map(|(has_all, p)| case(f64::from(p), *has_all)).collect();
        Report { cases, ..report.clone() }.figure().unwrap().matches("stroke-linejoin").count()
    };
    assert_eq!(lines([true; 5]), 2);
    assert_eq!(lines([true, true, false, true, true]), 3);
    // A single point has no line.
    assert_eq!(lines([true, true, true, false, true]), 2);
}

/// Title of the panel of times against the size.
const BY_SIZE: &str = "loads that all finished, median";

#[test]
fn times_against_the_size_are_those_of_loads_that_all_finished() {
    let report = report();
    let finished = |n| Case { n, p_star: 0.001, ..report.cases[0].clone() };
    let cases = [report.cases.clone(), vec![finished(512), finished(1024)]].concat();
    let figure = Report { cases, ..report.clone() }.figure().unwrap();
    assert!(figure.contains("Tamaas") && figure.contains(BY_SIZE), "{figure}");
    let cases = [report.cases.clone(), vec![finished(512)]].concat();
    assert!(!Report { cases, ..report }.figure().unwrap().contains(BY_SIZE));
}

#[test]
fn the_page_has_every_number_in_its_place() {
    let page = report().page("");
    assert!(page.contains("2026-01-02. a processor. Commit 0123456789ab. Tamaas 2.9.0. FFTW: fftw-3.3.10."), "{page}");
    assert!(page.contains("20.0 / 30.0 / 70.0"), "{page}");
    assert!(page.contains("the yardstick got 50 % of a processor") && page.contains("> something to know"));
    assert!(page.contains("at most 1e-8") && !page.contains('{'));
    assert!(page.contains("residual is 9.0e-9; pressures differ by at most 2e-8 (rms, relative)"), "{page}");
    let cells =
        |line: &str| -> Vec<String> { line.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect() };
    let rows: Vec<Vec<String>> = page.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    assert!(rows.contains(&["1024", "0.8", "0.05", "1.000", "100", "-"].map(str::to_owned).to_vec()));
    assert!(rows.contains(&["512", "2", "10.0 (50)", "10.0 (50)"].map(str::to_owned).to_vec()), "{page}");
    assert!(rows.contains(&["1024", "0.8", "0.05", "27 / ?", "-"].map(str::to_owned).to_vec()));
    // All lines of a table have the same number of columns.
    for lines in page.split("## ") {
        let mut widths: Vec<usize> =
            lines.lines().filter(|l| l.starts_with('|')).map(|l| l.matches('|').count()).collect();
        widths.dedup();
        assert!(widths.len() <= 1, "{lines}");
    }
    assert!(report().to_string().contains("note: something to know"));
}

#[test]
fn flags_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut Args), flag: &str| {
        let mut args = args(&[]);
        change(&mut args);
        let text = args.check().unwrap_err().to_string();
        assert!(text.starts_with(flag), "{text}");
    };
    args(&[]).check().unwrap();
    refused(|args| args.sizes.push(31), "--sizes contains 31; each must be at least 32");
    refused(|args| args.sizes.clear(), "--sizes");
    refused(|args| args.p_star = vec![0.0], "--p-star");
    refused(|args| args.tolerance = f64::NAN, "--tolerance");
    refused(|args| args.repeats = 0, "--repeats");
    refused(|args| args.thread_counts = vec![0], "--thread-counts");
    refused(|args| args.patience = Some(-1.0), "--patience");
    refused(|args| args.patience = Some(1e30), "--patience");
    refused(|args| args.solvers.clear(), "--solvers");
    let quick = args(&["--quick"]);
    assert_eq!((quick.sizes, quick.p_star), (vec![128, 256], vec![0.05]));
    let any = args(&["--any-load", "--write-docs"]);
    assert_eq!((any.sizes.clone(), any.patience()), (vec![256], 60.0));
    assert_eq!(any.page().unwrap().to_str(), Some("docs/any-load.md"));
    assert_eq!(args(&["--write-docs"]).page().unwrap().to_str(), Some("docs/benchmarks.md"));
    let creep = args(&["--creep", "--write-docs"]);
    assert_eq!((creep.page().unwrap().to_str(), creep.sizes.clone()), (Some("docs/creep-peers.md"), vec![256]));
    assert!(args(&["--boundary", "free"]).peers.contains(&Peer::Hertzian));
}

#[test]
fn contestants_solve_the_contacts_that_they_have() {
    use Boundary::{Free, Periodic};
    let suits = |contestant: Contestant| {
        [(Periodic, None), (Free, None), (Periodic, Some(0.1))]
            .map(|(boundary, hardness)| contestant.suits(boundary, hardness))
    };
    assert_eq!(suits(Contestant::Own(Solver::Auto)), [true; 3]);
    assert_eq!(suits(Contestant::Own(Solver::PolonskyKeer)), [true, true, false]);
    assert_eq!(suits(Contestant::Peer(Peer::ContactMechanics)), [true; 3]);
    assert_eq!(suits(Contestant::Peer(Peer::Aspher)), [true, true, false]);
    assert_eq!(suits(Contestant::Peer(Peer::Hertzian)), [false, true, false]);
    assert_eq!(suits(Contestant::Peer(Peer::NoRestart)), [true, false, false]);
}

/// Returns a table with contestants that are certified, wrong, failed by their own report, and without a pressure.
fn any_load() -> AnyLoad {
    let good = Cell {
        tolerance: 1e-8,
        seconds: Some(0.5),
        iterations: Some(12),
        transform_pairs: Some(26.0),
        verdict: Some(verdict(4e-9, 0.0, 0)),
        certified: true,
        said: None,
    };
    let counted = Cell { transform_pairs: None, ..good.clone() };
    let wrong = Cell { verdict: Some(verdict(0.7, 0.23, 900)), certified: false, ..good.clone() };
    let said = Some("no convergence to 1e-8: stagnated".to_owned());
    let close = Cell { verdict: Some(verdict(2e-8, 1e-7, 0)), certified: false, said, ..good.clone() };
    let late = Cell { said: Some("it takes longer than 60 s".into()), ..Cell::default() };
    let row = |p_star, cells: [&Cell; 3]| Row { p_star, contact: Some(0.25), cells: cells.map(Cell::clone).into() };
    let kind = ContactVariant { name: "free", boundary: Boundary::Free, hardness: None };
    let hard = ContactVariant { name: "hardness", boundary: Boundary::Periodic, hardness: Some(0.1) };
    let names = ["gfmd", "A", "B"].map(str::to_owned).to_vec();
    let between = row(0.1, [&good, &good, &good]);
    let rows = vec![row(0.01, [&good, &counted, &wrong]), between, row(1.0, [&good, &close, &late])];
    let hard_row = Row { cells: vec![good.clone(), good.clone()], ..row(0.1, [&late; 3]) };
    AnyLoad {
        date: "2026-01-02".into(),
        machine: "a processor".into(),
        commit: "0123456789abcdef".into(),
        versions: BTreeMap::from([("A".into(), "2.9.0".into())]),
        points: 256,
        tolerance: 1e-8,
        seed: 1,
        patience: 60.0,
        timed: true,
        blocks: vec![
            Block { kind, hurst: 0.8, contestants: names.clone(), rows },
            Block { kind: hard, hurst: 0.0, contestants: names[..2].into(), rows: vec![hard_row] },
        ],
        notes: vec!["something to know".into()],
        kept: "kept.json".into(),
    }
}

#[test]
fn the_page_of_all_loads_shows_what_fails() {
    let table = any_load();
    let page = table.page();
    for words in [
        "| 26, 4e-9, 0.500 | 12 it., 4e-9, 0.500 | ✗ 7e-1, 23 % off |",
        "✗ 2e-8 |",
        "✗ too long |",
        "3/3 |",
        "1/3 |",
        "hardness 0.1 E\\*, H = 0",
        "> something to know",
        "## Effort, certificate, seconds: free boundaries, H = 0.8",
    ] {
        assert!(page.contains(words), "{words}\n{page}");
    }
    let text = table.to_string();
    for words in [
        "A, free boundaries, H = 0.8: p\\* = 1: residual 2e-8, pressure 1.0e-5 % off (no convergence to 1e-8: \
         stagnated)",
        "B, free boundaries, H = 0.8: p\\* = 0.01: residual 7e-1, pressure 23 % off; p\\* = 1: no result (it takes \
         longer than 60 s)",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    assert!(!text.contains("\ngfmd, "), "what is certified is not told as a failure");
    let page = AnyLoad { timed: false, ..table }.page();
    assert!(page.contains("| 26, 4e-9 | 12 it., 4e-9 |") && !page.contains("certificate, seconds"), "{page}");
    for lines in page.split("## ") {
        let mut widths: Vec<usize> =
            lines.lines().filter(|l| l.starts_with('|')).map(|l| l.matches('|').count()).collect();
        widths.dedup();
        assert!(widths.len() <= 1, "{lines}");
    }
    assert!(LOADS.is_sorted());
}

#[test]
fn an_interrupted_run_is_continued_under_its_own_settings() {
    let folder = tempfile::tempdir().unwrap();
    let kept = Report { kept: folder.path().join("kept.json"), ..report() };
    assert!(kept.resumed().unwrap_err().to_string().contains("kept.json"), "there is no run yet");
    kept.keep().unwrap();
    let now = Report { date: "2026-01-03".into(), cases: Vec::new(), notes: Vec::new(), ..kept.clone() };
    let Interrupted { cases, notes } = now.resumed().unwrap();
    assert_eq!(serde_json::to_value(&cases).unwrap(), serde_json::to_value(&kept.cases).unwrap());
    assert_eq!(notes, kept.notes);
    let refused = Report { commit: "another".into(), ..now }.resumed().unwrap_err().to_string();
    assert!(refused.contains("its commit is \"0123456789abcdef\"; it must be \"another\""), "{refused}");
}

fn args(flags: &[&str]) -> Args {
    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }
    <Line as clap::Parser>::parse_from(["bench-peers"].iter().chain(flags)).args.resolved()
}

#[test]
fn default_flags_are_an_empty_command_line() {
    let (built, parsed) = (Args::default().resolved(), args(&[]));
    assert_eq!(serde_json::to_value(built).unwrap(), serde_json::to_value(parsed).unwrap());
}

#[test]
fn every_package_is_pinned() {
    let requirements = include_str!("../../peers/requirements.txt");
    assert!(requirements.lines().all(|line| line.split_once("==").is_some_and(|(_, version)| !version.is_empty())));
    assert!(requirements.contains("Tamaas==") && requirements.contains("ContactMechanics=="));
}

#[cfg(unix)]
#[test]
fn programs_are_read_stopped_and_quoted() {
    let shell = |line: &str, limit| output(Command::new("sh").args(["-c", line]), limit, &session());
    let long = Duration::from_secs(20);
    assert_eq!(shell("echo result; echo noise >&2", long).unwrap(), "result\n");
    let said = shell("echo reason >&2; exit 3", long).unwrap_err().in_words();
    assert!(said.contains("exit status: 3") && said.ends_with("reason"), "{said}");
    let started = Instant::now();
    assert!(matches!(shell("exec sleep 20", Duration::from_millis(50)), Err(ProgramFailure::TooLong(_))));
    assert!(started.elapsed() < Duration::from_secs(10));
    let missing = output(&mut Command::new("no-such-program-here"), long, &session()).unwrap_err().in_words();
    assert!(missing.contains("cannot start no-such-program-here"), "{missing}");
}
