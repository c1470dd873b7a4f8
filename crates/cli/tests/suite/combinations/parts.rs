//! Random combinations of the parts of a path: body, boundary, law, friction, shear strength, hardness, relaxation,
//! wear, loads or approaches, lateral displacements in two directions, times and distances, each drawn independently of
//! the others; bodies that yield, alone; and plates between two surfaces.

mod between;
mod fields;
mod limits;
mod memory;
mod yielding;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use gfmd_files::Reader;
use serde_json::Value;

use super::draw::{Body, Control, Dice, Law, body, short, waves, write};
use super::elastic::{Base, Plane};
use super::found::{Found, number};
use super::{End, PATHS_ONCE_WRONG, Problem, reason};
use crate::common::{gfmd, numbers};
use yielding::Yielding;

/// Wear of the surfaces.
#[derive(Clone, Debug)]
pub(crate) struct Wear {
    pub(crate) coefficient: f64,
    pub(crate) by_slip: bool,
}

/// Relaxation of the body.
#[derive(Clone, Debug)]
pub(crate) struct Relaxation {
    /// Relaxation times and fractions of the instantaneous modulus.
    pub(crate) branches: Vec<[f64; 2]>,
    pub(crate) of_shear: bool,
    pub(crate) instantaneous: bool,
}

/// Path of a contact made of parts.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) index: u64,
    pub(crate) plane: Plane,
    pub(crate) is_line: bool,
    pub(crate) heights: Vec<f64>,
    /// Flags of the surface and the body.
    surface: String,
    body_text: String,
    pub(crate) body: Body,
    pub(crate) is_free: bool,
    pub(crate) law: Option<Law>,
    pub(crate) friction: Option<f64>,
    pub(crate) shear_strength: Option<f64>,
    pub(crate) of_net: bool,
    pub(crate) hardness: Option<Vec<f64>>,
    hardness_text: String,
    pub(crate) relaxation: Option<Relaxation>,
    pub(crate) wear: Option<Wear>,
    yielding: Option<Yielding>,
    /// Heights of the surface below the body.
    pub(crate) lower: Option<Vec<f64>>,
    pub(crate) control: Control,
    pub(crate) loads: Vec<f64>,
    pub(crate) lateral: Vec<f64>,
    pub(crate) lateral_y: Vec<f64>,
    pub(crate) direction: f64,
    pub(crate) times: Vec<f64>,
    pub(crate) distances: Vec<f64>,
    pub(crate) steps: usize,
    /// Further solves per step; `None` for the default.
    pub(crate) energy_solves: Option<u32>,
    pub(crate) tolerance: f64,
}

/// Returns the drive of a step: load, lateral displacements along and across the direction, time, distance.
pub(crate) type Drive = [f64; 5];

impl Parts {
    /// Draws the path `index` and writes its input into `folder`.
    pub(crate) fn draw(index: u64, folder: &Path) -> Self {
        let dice = &mut Dice::new(index + 0x0be5);
        let is_line = dice.chance(0.2);
        let n = if is_line { [dice.count(12, 40), 1] } else { [dice.count(12, 20), dice.count(12, 20)] };
        let length = [1.0, if is_line { 1.0 } else { n[1] as f64 / n[0] as f64 }];
        let plane = Plane { n, length };
        let gradient = short(dice.scale(0.03, 0.15));
        let heights = waves(dice, plane, 0.1 * gradient);
        write(folder, &format!("h{index}.npy"), plane, is_line, &heights);
        let size = if is_line { String::from("1") } else { format!("1,{}", length[1]) };
        let surface = format!("--surface h{index}.npy --size {size}");
        let is_free = dice.chance(0.3);
        let rubs = dice.chance(0.5);
        // Combinations without a solution are rare.
        let wild = |dice: &mut Dice| dice.chance(0.03);
        let bases: &[usize] = match () {
            () if wild(dice) => &[0, 1, 2, 3],
            () if is_free && rubs => &[0, 0, 3],
            () if is_free => &[0, 0, 1, 3],
            () => &[0, 0, 1, 2, 3],
        };
        let mut body_text = String::new();
        let drawn = body(dice, &mut body_text, false, true, bases);
        let relaxes = dice.chance(0.4) && (drawn.second.is_none() || wild(dice));
        let relaxation = relaxes.then(|| {
            let count = dice.count(1, 3);
            let branches =
                (0..count).map(|_| [short(dice.scale(0.01, 10.0)), short(dice.between(0.05, 0.3))]).collect();
            let of_shear = dice.chance(0.1) && (!rubs && !is_free && drawn.is_half_space() || wild(dice));
            Relaxation { branches, of_shear, instantaneous: dice.chance(0.3) }
        });
        let scale = relaxation.as_ref().filter(|of| !of.instantaneous).map_or(1.0, |of| of.stiffening());
        let modulus = scale * drawn.contact_modulus();
        let unit = gradient * length[0];
        let law = dice.chance(0.4).then(|| {
            let gamma = short(modulus * unit * gradient * dice.scale(0.003, 0.05));
            // Process zone of one to ten grid steps.
            let range = short((gamma / modulus * plane.spacing()[0] * dice.scale(1.3, 12.0)).sqrt());
            match dice.count(0, 11) {
                0..=5 => Law::Exponential { gamma, range },
                6 | 7 => Law::Dugdale { gamma, range },
                8 | 9 => Law::Table {
                    first: 0.0,
                    step: 0.5 * range,
                    tractions: [1.0, 0.8, 0.3, 0.1, 0.0].map(|t| short(t * gamma / range)),
                },
                10 => Law::Morse { gamma, range },
                _ => Law::HarmonicCosine { gamma, curvature: short(gamma / (range * range)) },
            }
        });
        let has_wall = law.as_ref().is_none_or(Law::has_wall);
        let (mut friction, mut shear_strength, mut of_net) = (None, None, false);
        if rubs && (!(is_free && is_line) || wild(dice)) {
            let which = dice.count(0, 5);
            friction = (which < 5).then(|| dice.of(&[0.1, 0.3, 0.6]));
            // The shear strength alone has no solution at some edges beside a wall.
            shear_strength = (which >= 3).then(|| short(modulus * gradient * dice.scale(0.03, 0.3)));
            of_net = law.is_some() && dice.chance(0.3);
        }
        let rubs = friction.is_some() || shear_strength.is_some();
        let mut hardness_text = String::new();
        let hardness = (dice.chance(0.35) && (has_wall || wild(dice))).then(|| {
            let most = short(modulus * gradient * dice.scale(0.2, 2.0));
            if dice.chance(0.6) {
                hardness_text = most.to_string();
                return vec![most; plane.len()];
            }
            let values: Vec<f64> = (0..plane.len()).map(|_| short(most * dice.scale(0.5, 2.0))).collect();
            write(folder, &format!("p{index}.npy"), plane, is_line, &values);
            hardness_text = format!("p{index}.npy");
            values
        });
        let is_unlevelled = is_line && is_free && drawn.lowest() > 0.0;
        let control = match dice.count(0, 9) {
            0..=2 => Control::Pressure,
            3..=5 => Control::PStar,
            _ if is_unlevelled && !wild(dice) => Control::Pressure,
            _ => Control::Approach,
        };
        let count = dice.count(1, 4);
        let softest = hardness.as_ref().map_or(f64::INFINITY, |of| of.iter().sum::<f64>() / of.len() as f64);
        let most = if law.is_some() { 0.5 } else { 1.0 };
        let load = |dice: &mut Dice| {
            let pressure = (dice.scale(0.02, most) * modulus * gradient).min(dice.between(0.3, 0.9) * softest);
            match control {
                Control::Pressure => short(pressure),
                // The reduced pressure refers to the long-term moduli and the gradient of the heights.
                Control::PStar => short(dice.scale(0.02, most).min(0.1 * softest / (modulus * gradient))),
                Control::Approach => short(unit * dice.scale(0.01, 0.2)),
            }
        };
        let loads: Vec<f64> = if dice.chance(0.2) {
            vec![load(dice)]
        } else {
            let mut loads: Vec<f64> = (0..count).map(|_| load(dice)).collect();
            // Surfaces may part at the end.
            if count > 2 && control == Control::Approach && law.is_some() && dice.chance(0.4) {
                loads[count - 1] = short(-unit * dice.scale(0.01, 0.2));
            }
            loads
        };
        let amplitude = unit * dice.scale(0.003, 0.2);
        let sideways = |dice: &mut Dice| -> Vec<f64> {
            (0..count).map(|k| short(if k == 0 { 0.0 } else { amplitude * dice.between(-1.0, 1.0) })).collect()
        };
        let moves = (rubs && dice.chance(0.9)) || wild(dice);
        let lateral = if moves && dice.chance(0.9) { sideways(dice) } else { Vec::new() };
        let crosses = moves && (lateral.is_empty() || dice.chance(0.4)) && (!is_line || wild(dice));
        let lateral_y = if crosses { sideways(dice) } else { Vec::new() };
        let direction = if moves && !is_line && dice.chance(0.4) { dice.of(&[30.0, 45.0, 90.0]) } else { 0.0 };
        let times: Vec<f64> = if relaxation.is_some() != wild(dice) {
            (0..count).map(|_| dice.of(&[0.0, 0.1, 1.0, 30.0])).collect()
        } else {
            Vec::new()
        };
        let mut distances = Vec::new();
        let wear = (dice.chance(0.35) && (has_wall || wild(dice))).then(|| {
            let by_slip = rubs && dice.chance(0.4);
            // Points slip when the surfaces are pressed together, even where their path is short.
            let way = if by_slip { amplitude.max(0.05 * unit) } else { 0.3 };
            if !by_slip {
                distances =
                    (0..count).map(|_| if dice.chance(0.3) { 0.0 } else { short(dice.between(0.1, 1.0)) }).collect();
            }
            let depth = unit * dice.scale(1e-3, 0.05);
            Wear { coefficient: short(depth / (way * 0.2 * modulus * gradient)), by_slip }
        });
        let steps = dice.of(&[1, 1, 1, 2, 3]);
        let energy_solves = dice.of(&[Some(0), Some(0), Some(0), Some(0), Some(0), None, Some(2)]);
        let tolerance = if rubs { dice.of(&[1e-6, 1e-8]) } else { dice.of(&[1e-6, 1e-8, 1e-9]) };
        let mut drawn = Self {
            index,
            plane,
            is_line,
            heights,
            surface,
            body_text,
            body: drawn,
            is_free,
            law,
            friction,
            shear_strength,
            of_net,
            hardness,
            hardness_text,
            relaxation,
            wear,
            yielding: None,
            lower: None,
            control,
            loads,
            lateral,
            lateral_y,
            direction,
            times,
            distances,
            steps,
            energy_solves,
            tolerance,
        };
        if !PATHS_ONCE_WRONG.contains(&index) {
            drawn.yielding = Yielding::draw(&mut drawn);
            drawn.lay_on_surface(folder);
            drawn.unload(unit);
        }
        drawn
    }

    /// Unloads every third contact with a hard wall completely, at the second waypoint; `unit` is a size of heights.
    fn unload(&mut self, unit: f64) {
        if self.index.is_multiple_of(3) && self.law.is_none() && self.loads.len() > 1 {
            self.loads[1] = if self.control == Control::Approach { short(-0.01 * unit) } else { 0.0 };
        }
    }

    /// Returns the flags of the command.
    pub(crate) fn command(&self) -> Vec<String> {
        let mut text = format!("path {} {}", self.surface, self.body_text);
        if self.is_free {
            text.push_str(" --boundary free");
        }
        if self.lower.is_some() {
            let _ = write!(text, " --lower-surface l{}.npy", self.index);
        }
        if let Some(law) = &self.law {
            let _ = write!(text, " {}", law.words());
        }
        for (flag, value) in [("friction", self.friction), ("shear-strength", self.shear_strength)] {
            if let Some(value) = value {
                let _ = write!(text, " --{flag} {value}");
            }
        }
        if self.of_net {
            text.push_str(" --friction-of net");
        }
        if self.hardness.is_some() {
            let _ = write!(text, " --hardness {}", self.hardness_text);
        }
        if let Some(Relaxation { branches, of_shear, instantaneous }) = &self.relaxation {
            let branches: Vec<String> = branches.iter().map(|[time, fraction]| format!("{time}:{fraction}")).collect();
            let _ = write!(text, " --prony {}", branches.join(","));
            if *of_shear {
                text.push_str(" --relaxes shear");
            }
            if *instantaneous {
                text.push_str(" --moduli instantaneous");
            }
        }
        if let Some(Wear { coefficient, by_slip }) = &self.wear {
            let _ = write!(text, " --coefficient {coefficient}{}", if *by_slip { " --wear-by slip" } else { "" });
        }
        if let Some(yielding) = &self.yielding {
            text.push_str(&yielding.words());
        }
        let flag = match self.control {
            Control::Pressure => "pressure",
            Control::PStar => "p-star",
            Control::Approach => "approach",
        };
        let lists = [
            (flag, &self.loads),
            ("lateral", &self.lateral),
            ("lateral-y", &self.lateral_y),
            ("time", &self.times),
            ("distance", &self.distances),
        ];
        for (flag, values) in lists {
            if !values.is_empty() {
                let values: Vec<String> = values.iter().map(f64::to_string).collect();
                let _ = write!(text, " --{flag}={}", values.join(","));
            }
        }
        if self.direction != 0.0 {
            let _ = write!(text, " --direction {}", self.direction);
        }
        let _ = write!(text, " --steps {} --tolerance {:e}", self.steps, self.tolerance);
        if let Some(solves) = self.energy_solves {
            let _ = write!(text, " --energy-solves {solves}");
        }
        text.split_whitespace().map(str::to_owned).collect()
    }

    /// Returns the drives of all steps, and the steps that are waypoints.
    fn drives(&self) -> (Vec<Drive>, Vec<usize>) {
        let lists = [&self.loads, &self.lateral, &self.lateral_y, &self.times, &self.distances];
        let count = lists.iter().map(|list| list.len()).max().unwrap_or(0);
        let at = |waypoint: usize| -> Drive {
            let of =
                |list: &Vec<f64>| if list.len() == 1 { list[0] } else { list.get(waypoint).copied().unwrap_or(0.0) };
            let sum = |list: &Vec<f64>| match list[..] {
                [only] => only * (waypoint + 1) as f64,
                _ => list.iter().take(waypoint + 1).sum(),
            };
            [of(lists[0]), of(lists[1]), of(lists[2]), sum(lists[3]), sum(lists[4])]
        };
        let has_legs = !(self.times.is_empty() && self.distances.is_empty());
        let (mut drives, mut waypoints) = (Vec::new(), Vec::new());
        let mut before = if has_legs { [0.0; 5] } else { at(0) };
        if !has_legs {
            drives.push(before);
            waypoints.push(0);
        }
        for waypoint in usize::from(!has_legs)..count {
            let now = at(waypoint);
            let is_jump = has_legs && now[3..] == before[3..];
            let steps = if is_jump { 1 } else { self.steps };
            for step in 1..=steps {
                let share = step as f64 / steps as f64;
                drives.push(std::array::from_fn(|k| before[k] + share * (now[k] - before[k])));
            }
            waypoints.push(drives.len() - 1);
            before = now;
        }
        (drives, waypoints)
    }

    /// Returns true if a shear does not lift the surface, and a pressure does not move it sideways.
    fn is_uncoupled(&self) -> bool {
        self.body.is_half_space() && self.body.second.is_none() && self.body.top().poisson == 0.5
    }

    /// Returns true if points may slip.
    fn rubs(&self) -> bool {
        self.friction.is_some() || self.shear_strength.is_some()
    }

    /// Returns the limit of the shear at a point with a repulsion and a net pressure.
    fn limit(&self, repulsion: f64, pressure: f64) -> f64 {
        if repulsion <= 0.0 {
            return 0.0;
        }
        let by = if self.of_net { pressure.max(0.0) } else { repulsion };
        match (self.friction, self.shear_strength) {
            (Some(mu), Some(strength)) => (mu * by).min(strength),
            (Some(mu), None) => mu * by,
            (None, Some(strength)) => strength,
            _ => 0.0,
        }
    }
}

impl Relaxation {
    /// Returns the instantaneous modulus divided by the long-term modulus.
    fn stiffening(&self) -> f64 {
        1.0 / (1.0 - self.branches.iter().map(|[_, fraction]| fraction).sum::<f64>())
    }
}

impl Problem for Parts {
    fn words(&self) -> String {
        self.command().join(" ")
    }

    fn kinds(&self) -> Vec<&'static str> {
        let all = [
            (self.is_line, "profile"),
            (self.is_free, "free boundaries"),
            (!self.body.is_half_space(), "layers"),
            (self.body.first.base == Base::Free && !self.body.is_half_space(), "plate"),
            (self.body.second.is_some(), "second body"),
            (self.law.as_ref().is_some_and(Law::has_wall), "law with a wall"),
            (self.law.as_ref().is_some_and(|law| !law.has_wall()), "law without a wall"),
            (self.friction.is_some() && self.shear_strength.is_none(), "friction"),
            (self.friction.is_some() && self.shear_strength.is_some(), "friction up to a strength"),
            (self.friction.is_none() && self.shear_strength.is_some(), "shear strength"),
            (self.of_net, "friction of the net pressure"),
            (self.hardness.is_some(), "hardness"),
            (self.relaxation.is_some(), "relaxation"),
            (self.relaxation.as_ref().is_some_and(|of| of.of_shear), "relaxing shear"),
            (self.yielding.is_some(), "yield stress"),
            (self.lower.is_some(), "two surfaces"),
            (self.wear.as_ref().is_some_and(|wear| wear.by_slip), "wear by slip"),
            (self.wear.as_ref().is_some_and(|wear| !wear.by_slip), "wear by distance"),
            (!self.lateral_y.is_empty(), "lateral path in two components"),
            (self.control == Control::Approach, "approaches"),
        ];
        let parts = [
            self.law.is_some(),
            self.rubs(),
            self.hardness.is_some(),
            self.relaxation.is_some(),
            self.wear.is_some(),
            self.yielding.is_some(),
            self.is_free,
            self.lower.is_some(),
        ];
        let names =
            ["no part", "one part", "two parts", "three parts", "four parts", "five parts", "six parts", "all parts"];
        let count = parts.into_iter().filter(|is_given| *is_given).count();
        all.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).chain([names[count]]).collect()
    }

    fn run(&self, folder: &Path, found: &mut Found) -> (End, String) {
        run(self, folder, found)
    }
}

/// Runs a command with further words; returns its status, output and messages.
fn program(folder: &Path, words: &[String], further: &[&str]) -> (Option<i32>, String, String) {
    let words: Vec<&str> = words.iter().map(String::as_str).chain(further.iter().copied()).collect();
    let output = gfmd(folder, &words);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Returns a message without its numbers.
fn kind_of(message: &str) -> String {
    let last = message.trim_end().lines().last().unwrap_or_default();
    last.chars()
        .map(|c| if c.is_ascii_digit() { '#' } else { c })
        .collect::<String>()
        .replace("##", "#")
        .replace("##", "#")
}

/// Returns the steps of a report without their seconds.
fn steps_of(report: &Value) -> Value {
    let mut steps = report["steps"].clone();
    for step in steps.as_array_mut().into_iter().flatten() {
        step.as_object_mut().unwrap().remove("seconds");
    }
    steps
}

/// Solves the path and checks all its output.
fn run(parts: &Parts, folder: &Path, found: &mut Found) -> (End, String) {
    let words = parts.command();
    let out = format!("out{}.h5", parts.index);
    let started = Instant::now();
    let kept: &[&str] = if parts.yielding.is_some() { &["--kept-strain", "waypoints"] } else { &[] };
    let words: Vec<String> = words.into_iter().chain(kept.iter().map(ToString::to_string)).collect();
    let (status, text, reported) = program(folder, &words, &["--json", "-q", "--threads", "1", "--out", &out]);
    let took = started.elapsed();
    match status {
        Some(0) => {}
        Some(2) => {
            let one = reported.trim_end().lines().count() == 1
                && reported.starts_with("error")
                && ["--", ".npy"].iter().any(|name| reported.contains(name));
            found.must(one && text.is_empty(), || format!("a refusal: {reported}"));
            found.must(!folder.join(&out).exists(), || "a refused case has a file".into());
            return (End::Refused, reason(&reported));
        }
        Some(1) => {
            let last = reported.trim_end().lines().last().unwrap_or_default();
            let says = last.starts_with("error")
                && ["converge", "search", "part", "separate", "touch", "clearance", "lowest cell yields"]
                    .iter()
                    .any(|word| last.contains(word));
            found.must(says && !reported.contains("panicked"), || format!("an unexpected failure: {reported}"));
            found.note(format!("failed: {} (GFMD_PARTS={})", kind_of(&reported), parts.index));
            return (End::Failed, reported);
        }
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
    check(parts, &report, &file, found);
    drop(file);
    if parts.index.is_multiple_of(3) {
        let (status, text, _) = program(folder, &parts.command(), &["--json", "-q", "--threads", "2"]);
        let again = serde_json::from_str::<Value>(&text).unwrap_or_default();
        found.must(status == Some(0) && steps_of(&again) == steps_of(&report), || "two threads have other bits".into());
    }
    let checks: &[&[&str]] = if parts.index.is_multiple_of(10) { &[&[], &["--rerun"]] } else { &[&[]] };
    for rest in checks {
        let words = ["check".to_owned(), out.clone()];
        let (status, text, reported) = program(folder, &words, &[&["--json", "-q"][..], *rest].concat());
        let checked = serde_json::from_str::<Value>(&text).unwrap_or_default();
        found.must(status == Some(0) && checked["differing"] == 0, || {
            format!("check {rest:?}: status {status:?}, {}{reported}", checked["differences"])
        });
    }
    let page = format!("{out}.html");
    let (status, _, reported) = program(folder, &["report".to_owned(), out.clone()], &["-q", "--out", &page]);
    found.must(status == Some(0), || format!("report: status {status:?}: {reported}"));
    if parts.index.is_multiple_of(10) {
        killed(parts, folder, (&words, &out), took, found);
    }
    if parts.index.is_multiple_of(4) {
        limits::check(parts, folder, found);
    }
    (End::Solved, String::new())
}

/// Kills the run at some moment, continues it, and compares the file with the file `out` of the uninterrupted run.
fn killed(parts: &Parts, folder: &Path, (words, out): (&[String], &str), took: Duration, found: &mut Found) {
    let again = format!("again{}.h5", parts.index);
    let mut command = Command::new(env!("CARGO_BIN_EXE_gfmd"));
    command.current_dir(folder).args(words).args(["-q", "--threads", "1", "--resume", "--out", &again]);
    let mut run = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let share = Dice::new(parts.index + 0xdead).between(0.2, 0.95);
    std::thread::sleep(took.mul_f64(share));
    run.kill().unwrap();
    run.wait().unwrap();
    found.note(format!("killed {}", if folder.join(&again).exists() { "after the end" } else { "before the end" }));
    let (status, _, reported) = program(folder, words, &["-q", "--threads", "1", "--resume", "--out", &again]);
    found.must(status == Some(0), || format!("--resume after a kill: status {status:?}: {reported}"));
    let same = status == Some(0) && numbers(&folder.join(&again)) == numbers(&folder.join(out));
    found.must(same, || "a killed and resumed run has other numbers".into());
}

/// Checks the steps of a report, and the fields of the waypoints.
fn check(parts: &Parts, report: &Value, file: &Reader, found: &mut Found) {
    let (drives, waypoints) = parts.drives();
    let steps = report["steps"].as_array().unwrap();
    let parted = report["parted_at"].as_u64().map(|at| at as usize);
    if let Some(at) = parted {
        found.note("parted".into());
        found.must(at + 1 >= steps.len(), || format!("{} steps after the parting at {at}", steps.len()));
    } else {
        found.must(steps.len() == drives.len(), || format!("{} steps of {}", steps.len(), drives.len()));
    }
    let end = parted.unwrap_or(steps.len()).min(steps.len()).min(drives.len());
    for k in 0..end {
        let first = found.complaints.len();
        drive(parts, &steps[k], drives[k], found);
        energies(parts, &steps[..=k], found);
        found.complaints[first..].iter_mut().for_each(|text| *text = format!("step {k}: {text}"));
    }
    let places: Vec<usize> = waypoints.into_iter().filter(|step| *step < end).collect();
    fields::check(parts, steps, &drives, &places, file, found);
    yielding::check(parts, steps, &places, file, found);
    sums(report, &steps[..end], found);
}

/// Checks the drive of a step.
fn drive(parts: &Parts, step: &Value, [load, along, across, time, distance]: Drive, found: &mut Found) {
    found.must(step["converged"] == true, || "not converged, with status 0".into());
    found.nulls(
        step,
        &[
            "stick_fraction",
            "interface_energy",
            "dissipated",
            "dissipated_error",
            "lowest_curvature",
            "passed_instability",
        ],
    );
    if parts.control == Control::Approach {
        found.near("approach", number(step, "approach"), load, 1e-9 * load.abs());
    }
    let (sine, cosine) = if parts.direction == 0.0 { (0.0, 1.0) } else { parts.direction.to_radians().sin_cos() };
    let expected = [along * cosine - across * sine, along * sine + across * cosine];
    for (axis, expected) in expected.into_iter().enumerate() {
        if let Some(reported) = step["lateral"][axis].as_f64() {
            found.near("lateral", reported, expected, 1e-9 * along.hypot(across) + 1e-300);
        }
    }
    for (key, expected) in [("time", time), ("distance", distance)] {
        if step.get(key).is_some() {
            found.near(key, number(step, key), expected, 1e-9 * expected);
        }
    }
}

/// Names of the losses by cause.
const LOSSES: [&str; 5] = ["lost_relaxation", "lost_friction", "lost_wear", "lost_plastic", "lost_jumps"];

/// Returns the energy of a step that its springs, its law and its hardening store.
fn stored(step: &Value) -> f64 {
    let interface = number(step, "interface_energy");
    let hardening = step["hardening_energy"].as_f64().unwrap_or(0.0);
    number(step, "elastic_energy") + if interface.is_nan() { 0.0 } else { interface } + hardening
}

/// Returns the work between two steps by the trapezoidal rule, its largest error for monotonic forces, and the sum of
/// the magnitudes of its parts.
fn work(before: Option<&Value>, step: &Value) -> [f64; 3] {
    let pairs = |of: Option<&Value>| {
        let Some(of) = of else { return [[0.0; 2]; 3] };
        let axis = |key: &str, axis: usize| of[key][axis].as_f64().unwrap_or(0.0);
        [
            [number(of, "mean_pressure"), number(of, "approach")],
            [axis("mean_shear", 0), axis("lateral", 0)],
            [axis("mean_shear", 1), axis("lateral", 1)],
        ]
    };
    let mut sums = [0.0; 3];
    for ([p, x], [q, y]) in pairs(before).into_iter().zip(pairs(Some(step))) {
        sums[0] += 0.5 * (p + q) * (y - x);
        sums[1] += 0.5 * ((q - p) * (y - x)).abs();
        sums[2] += (p.abs() + q.abs()) * (x.abs() + y.abs());
    }
    sums
}

/// Checks the losses and the balance of energy of the last of these steps.
fn energies(parts: &Parts, steps: &[Value], found: &mut Found) {
    let (Some(step), before) = (steps.last(), steps.iter().rev().nth(1)) else { return };
    let lost: BTreeMap<&str, f64> =
        LOSSES.into_iter().filter(|key| step.get(key).is_some()).map(|key| (key, number(step, key))).collect();
    let dissipated = number(step, "dissipated");
    let start = before.map_or(0.0, stored);
    let [work, spread, magnitude] = work(before, step);
    let scale = stored(step).abs() + start.abs() + number(step, "elastic_energy").abs() + magnitude;
    let losses = || lost.values().map(|value| value.abs()).filter(|value| value.is_finite()).sum();
    let scale = if scale.is_finite() { scale } else { losses() };
    let error_of = |key: &str| Some(number(step, key)).filter(|error| error.is_finite()).unwrap_or(0.0);
    let error = error_of("dissipated_error");
    for (key, value) in &lost {
        // Where a law pulls at a point that wears, the surfaces do work on each other, which counts as a negative loss.
        if !(*key == "lost_wear" && parts.law.is_some()) && value.is_finite() {
            // The loss in jumps is what the balance leaves, with the error of the work.
            let error = error + if *key == "lost_jumps" { error_of("work_imbalance") } else { 0.0 };
            found.must(*value >= -parts.tolerance * scale - error, || format!("{key} is {value:e}, of {scale:e}"));
        }
    }
    if !lost.is_empty() && dissipated.is_finite() {
        let sum: f64 = lost.values().sum();
        let size: f64 = lost.values().map(|value| value.abs()).sum();
        found.near("the sum of the losses", sum, dissipated, 1e-12 * size.max(dissipated.abs()));
    }
    if parts.energy_solves != Some(0) || step.get("work_imbalance").is_none() {
        return;
    }
    let imbalance = number(step, "work_imbalance");
    let missing = work - (stored(step) - start) - dissipated;
    let jumps = lost.get("lost_jumps").copied().unwrap_or(0.0);
    let same = |key: &str| {
        let of = |step: Option<&Value>| step.map_or(0.0, |step| number(step, key));
        step.get(key).is_none() || of(Some(step)) == of(before)
    };
    let is_at_once = same("time") && same("distance");
    let flows = parts.rubs() || parts.hardness.is_some() || parts.yielding.is_some();
    let floor = 1e-9 * scale;
    if parts.law.is_some() && parts.relaxation.is_some() && before.is_none() {
        // A law pulls from the first touch on, so that a step of some duration begins with a jump.
        return;
    }
    let expected = match () {
        // The path on which surfaces with a law came together is unknown.
        () if parts.law.is_some() && before.is_none() => 0.0,
        () if jumps != 0.0 || (parts.law.is_some() && is_at_once && !flows) => {
            // A jump is the loss that closes the balance.
            let none = jumps == 0.0 && dissipated == 0.0;
            found.must(none || missing.abs() <= floor, || format!("a jump leaves {missing:e} of {scale:e}"));
            if imbalance.is_nan() || none {
                return;
            }
            spread
        }
        () if is_at_once && !flows => {
            // Nothing is lost at once, and the balance of an elastic contact is not measured.
            found.must(dissipated.abs() <= floor, || format!("{dissipated:e} is lost at once"));
            0.0
        }
        () => missing.abs(),
    };
    found.near("work_imbalance", imbalance, expected, floor);
}

/// Checks the sums over all steps.
fn sums(report: &Value, steps: &[Value], found: &mut Found) {
    let lost: Vec<f64> = steps.iter().map(|step| number(step, "dissipated")).filter(|lost| lost.is_finite()).collect();
    if !lost.is_empty() && report["parted_at"].is_null() {
        let size: f64 = lost.iter().map(|lost| lost.abs()).sum();
        found.near("dissipated of the path", number(report, "dissipated"), lost.iter().sum(), 1e-12 * size);
    }
}
