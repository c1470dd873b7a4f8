//! Contacts with a history on random bodies: relaxing bodies along a path and sliding, heat, wear. Every further
//! command reads each result: the stress below it, its page, its check.

use std::path::Path;

use gfmd_files::Reader;
use serde_json::Value;

use super::draw::{Case, Components, Dice};
use super::elastic::Base;
use super::found::{Found, number};
use super::numbers::{largest, mean};
use super::outlets;
use super::{End, Problem, reason};
use crate::common::gfmd;

/// Kinds of histories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Relaxing,
    Sliding,
    Heat,
    Wear,
}

/// Contact with a history.
#[derive(Debug)]
pub(crate) struct History {
    pub(crate) case: Case,
    pub(crate) kind: Kind,
    /// True if only the shear modulus relaxes.
    pub(crate) is_of_shear: bool,
    /// True if the interface of a sliding surface has friction.
    pub(crate) rubs: bool,
    pub(crate) words: Vec<String>,
}

/// Flags of surface, body, law and load shared by all commands.
const SHARED: [&str; 20] = [
    "--n",
    "--dim",
    "--eps-t-inv",
    "--eps-f-inv",
    "--hurst",
    "--seed",
    "--rms-gradient",
    "--size",
    "--surface",
    "--second-surface",
    "--young",
    "--poisson",
    "--height",
    "--layer",
    "--base",
    "--base-young",
    "--base-poisson",
    "--second-body",
    "--boundary",
    "--tolerance",
];

/// Flags of loads and laws.
const LOADS: [&str; 3] = ["--pressure", "--p-star", "--approach"];
const LAWS: [&str; 3] = ["--law", "--param", "--law-table"];

impl History {
    /// Draws the history `index` and writes its input into `folder`; `None` for a problem of another kind.
    pub(crate) fn draw(index: u64, folder: &Path) -> Option<Self> {
        let mut case = Case::draw(index, folder);
        let others = case.is_steep || case.has_lower || case.moved.is_some() || case.hardness.is_some();
        if others || case.components != Components::Normal || case.friction.or(case.shear_strength).is_some() {
            return None;
        }
        let dice = &mut Dice::new(index + 0x5eed);
        let kind = dice.of(&[Kind::Relaxing, Kind::Relaxing, Kind::Sliding, Kind::Heat, Kind::Wear]);
        let command = match kind {
            Kind::Relaxing => "path",
            Kind::Sliding | Kind::Heat => "slide",
            Kind::Wear => "wear",
        };
        let mut words = vec![command.to_owned()];
        let slides = matches!(kind, Kind::Sliding | Kind::Heat);
        case.is_free &= !slides;
        let mut keeps = false;
        for word in &case.words[1..] {
            if word.starts_with("--") {
                let flag = word.split('=').next().unwrap_or_default();
                let is_law = kind == Kind::Relaxing && LAWS.contains(&flag);
                keeps = SHARED.contains(&flag) && !(slides && flag == "--boundary")
                    || LOADS.contains(&flag)
                    || flag == "--shift"
                    || is_law;
            }
            if keeps {
                words.push(word.clone());
            }
        }
        let prony = |dice: &mut Dice| {
            let branches = dice.count(1, 3);
            let all = (0..branches).map(|_| format!("{:.3e}:{:.3}", dice.scale(0.01, 10.0), dice.between(0.05, 0.3)));
            all.collect::<Vec<_>>().join(",")
        };
        let is_of_shear = matches!(kind, Kind::Relaxing | Kind::Sliding) && dice.chance(0.2);
        let text = match kind {
            Kind::Relaxing => {
                let times: Vec<String> = case.loads.iter().map(|_| dice.of(&["0", "0.1", "1", "30"]).into()).collect();
                format!("--prony {} --time {} --steps {}", prony(dice), times.join(","), dice.count(1, 2))
            }
            Kind::Sliding => format!("--prony {} --velocity {:.3}", prony(dice), dice.scale(0.01, 10.0)),
            Kind::Heat => format!("--heat 1,0.01 --friction 0.3 --velocity {:.3}", dice.scale(0.01, 10.0)),
            Kind::Wear => {
                let distances: Vec<String> = (0..case.loads.len()).map(|k| format!("{:.2}", 0.01 * k as f64)).collect();
                let coefficient = dice.scale(0.01, 1.0);
                format!(
                    "--coefficient {coefficient:.3} --distance {} --steps {}",
                    distances.join(","),
                    dice.count(1, 3)
                )
            }
        };
        words.extend(text.split_whitespace().map(str::to_owned));
        if is_of_shear {
            words.extend(["--relaxes", "shear"].map(str::to_owned));
        }
        if matches!(kind, Kind::Relaxing | Kind::Sliding) && dice.chance(0.3) {
            words.extend(["--moduli", "instantaneous"].map(str::to_owned));
        }
        let rubs = kind == Kind::Sliding && dice.chance(0.5);
        if rubs {
            words.push(format!("--friction={:.3}", dice.between(0.0, 1.0)));
        }
        Some(Self { case, kind, is_of_shear, rubs, words })
    }
}

impl Problem for History {
    fn words(&self) -> String {
        self.words.join(" ")
    }

    fn kinds(&self) -> Vec<&'static str> {
        let kind = match self.kind {
            Kind::Relaxing if self.case.law.is_some() => "relaxing with a law",
            Kind::Relaxing => "relaxing",
            Kind::Sliding => "sliding",
            Kind::Heat => "heat",
            Kind::Wear => "wear",
        };
        let all = [
            (true, kind),
            (self.is_of_shear, "relaxing shear"),
            (self.rubs, "sliding with friction"),
            (self.case.is_line, "profile"),
            (self.case.is_free, "free boundaries"),
            (!self.case.body.is_half_space(), "layers"),
        ];
        all.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).collect()
    }

    fn run(&self, folder: &Path, found: &mut Found) -> (End, String) {
        run(self, folder, found)
    }
}

/// Runs a history and every further command on its file.
fn run(history: &History, folder: &Path, found: &mut Found) -> (End, String) {
    let History { case, kind, words, .. } = history;
    let out = format!("out{}.h5", case.index);
    let program = |words: &[&str]| {
        let output = gfmd(folder, words);
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), reported)
    };
    let bare: Vec<&str> = words.iter().map(String::as_str).collect();
    let whole = [&bare[..], &["--json", "-q", "--threads", "1", "--out", &out]].concat();
    let (status, text, reported) = program(&whole);
    match status {
        Some(0) => {}
        Some(2) => {
            let one = reported.trim_end().lines().count() == 1 && reported.contains("--");
            found.must(one && text.is_empty(), || format!("a refusal: {reported}"));
            return (End::Refused, reason(&reported));
        }
        Some(1) => {
            let says = ["converge", "search", "part", "separate", "touch", "clearance"]
                .iter()
                .any(|word| reported.contains(word));
            found.must(says && !reported.contains("panicked"), || format!("an unexpected failure: {reported}"));
            return (End::Failed, reported);
        }
        status => {
            found.complain(format!("status {status:?}: {reported}"));
            return (End::Failed, String::new());
        }
    }
    let report: Value = serde_json::from_str(&text).unwrap();
    let file = Reader::open(folder.join(&out)).unwrap();
    let records =
        report[if matches!(kind, Kind::Sliding | Kind::Heat) { "states" } else { "steps" }].as_array().unwrap();
    states(found, history, records, &file);
    for (further, rest) in [("check", &["--json", "-q"][..]), ("check", &["--rerun", "--json", "-q"])] {
        let (status, text, reported) = program(&[&[further, &out][..], rest].concat());
        let checked = serde_json::from_str::<Value>(&text).unwrap_or_default();
        found.must(status == Some(0) && checked["differing"] == 0, || {
            format!("{further} {rest:?}: status {status:?}, {}{reported}", checked["differences"])
        });
    }
    let page = format!("{out}.html");
    let (status, _, reported) = program(&["report", &out, "-q", "--out", &page]);
    found.must(status == Some(0), || format!("report: status {status:?}: {reported}"));
    below(found, history, folder, &out);
    (End::Solved, String::new())
}

/// Checks the numbers of the states by their definition from the fields.
fn states(found: &mut Found, history: &History, records: &[Value], file: &Reader) {
    let case = &history.case;
    let group = match history.kind {
        Kind::Relaxing | Kind::Wear => "/path",
        Kind::Sliding | Kind::Heat => "/states",
    };
    let stored = file.shape("/fields/pressure").unwrap()[0];
    for (name, key) in [("mean_pressure", "mean_pressure"), ("max_pressure", "max_pressure")] {
        let of_file: Vec<f64> = file.values(&format!("{group}/{name}")).unwrap();
        for (record, stored) in records.iter().zip(&of_file) {
            let reported = number(record, key);
            found.must(reported.to_bits() == stored.to_bits(), || format!("{name}: {reported:e} {stored:e}"));
        }
    }
    if !matches!(history.kind, Kind::Sliding | Kind::Heat) {
        let absent = [
            "stick_fraction",
            "interface_energy",
            "dissipated",
            "dissipated_error",
            "lowest_curvature",
            "passed_instability",
        ];
        records.iter().for_each(|record| found.nulls(record, &absent));
    }
    let Some(last) = records.last() else { return };
    let field = |name: &str| file.slab::<f64>(&format!("/fields/{name}"), stored - 1).unwrap();
    let pressure = field("pressure");
    let most = largest(&pressure);
    found.near("mean_pressure", number(last, "mean_pressure"), mean(&pressure), 10.0 * case.tolerance * most);
    if case.law.is_none() || history.kind != Kind::Relaxing {
        found.near("max_pressure", number(last, "max_pressure"), most, 1e-9 * most);
        found.must(pressure.iter().all(|p| *p >= 0.0), || "a pressure below zero".into());
    }
    let gap = field("gap");
    // In full contact with a wall the gap is reported as zero, although the search leaves a gap within its tolerance.
    let reported = number(last, "mean_gap");
    if reported == 0.0 && pressure.iter().all(|p| *p > 0.0) {
        found.near("mean_gap in full contact", mean(&gap), 0.0, case.tolerance * case.plane.length[0]);
    } else {
        found.near("mean_gap", reported, mean(&gap), 1e-6 * largest(&gap));
    }
}

/// Checks the stress below the result, wave by wave, or the reason why there is none.
fn below(found: &mut Found, history: &History, folder: &Path, out: &str) {
    let case = &history.case;
    let fields = format!("{out}.body.h5");
    let words = ["body", "--surface", out, "--depths", "0,0.05,0.2", "--json", "-q", "--out", &fields];
    let output = gfmd(folder, &words);
    let reported = String::from_utf8_lossy(&output.stderr);
    let relaxes = matches!(history.kind, Kind::Relaxing | Kind::Sliding);
    let unknown = case.is_free || history.is_of_shear || history.kind == Kind::Heat || history.rubs;
    match output.status.code() {
        Some(2) => {
            let shallow = case.body.first.height() < 0.2 && !matches!(case.body.first.base, Base::HalfSpace(..));
            found.must(unknown || shallow, || format!("body is refused: {reported}"));
            found.must(reported.trim_end().lines().count() == 1, || format!("body: {reported}"));
        }
        Some(0) => {
            found.must(!unknown, || "body is not refused".into());
            let report: Value = serde_json::from_slice(&output.stdout).unwrap();
            let (result, file) = (Reader::open(folder.join(out)).unwrap(), Reader::open(folder.join(&fields)).unwrap());
            outlets::body(found, case, &result, &file, &report);
            for name in ["displacement", "strain", "energy_density"] {
                let has = file.contains(&format!("/fields/{name}"));
                found.must(has != relaxes, || format!("the {name} below a body that relaxes: {relaxes}, {has}"));
            }
            let checked = gfmd(folder, &["check", &fields, "--rerun", "--json", "-q"]);
            let checked: Value = serde_json::from_slice(&checked.stdout).unwrap_or_default();
            found.must(checked["differing"] == 0, || format!("check of body: {}", checked["differences"]));
        }
        status => found.complain(format!("body: status {status:?}: {reported}")),
    }
}
