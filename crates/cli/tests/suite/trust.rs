//! Untrusted results: `check` and `report` write only the requested files, open only inputs, and verify everything
//! stated in docs/trust.md.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{STUDY, SWEEP, gfmd, long};
use gfmd_check::result::ResultKind;
use gfmd_check::result::trust::{Coverage, Row, page, row_of};
use gfmd_files::{Attribute, Reader};
use hdf5::types::VarLenUnicode;
use hdf5::{File, Location};
use ndarray::{Array2, ArrayD};

/// Longest duration of a command here.
const MAX_COMMAND_TIME: Duration = Duration::from_secs(120);

/// Run with its status, stderr and stdout.
struct Ran {
    status: Option<i32>,
    stderr: String,
    stdout: String,
}

/// Runs the program, which must end by itself and without a panic.
fn run(folder: &Path, arguments: &[&str]) -> Ran {
    let emulator = std::env::var("GFMD_EMULATOR").unwrap_or_default();
    let mut words: Vec<&str> = emulator.split_whitespace().chain([env!("CARGO_BIN_EXE_gfmd")]).collect();
    let mut command = Command::new(words.remove(0));
    command.args(words).current_dir(folder).args(arguments).stdin(Stdio::null());
    let [out, err] = ["stdout", "stderr"].map(|name| tempfile::Builder::new().prefix(name).tempfile().unwrap());
    let mut child =
        command.stdout(out.reopen().unwrap()).stderr(err.reopen().unwrap()).spawn().expect("the program starts");
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > MAX_COMMAND_TIME {
            child.kill().unwrap();
            panic!("{arguments:?} did not end");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let [stdout, stderr] = [out, err].map(|file| String::from_utf8_lossy(&std::fs::read(file).unwrap()).into_owned());
    assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
    assert!(matches!(status.code(), Some(0..=2)), "{arguments:?}: {status} {stderr}");
    if status.code() == Some(2) {
        assert_eq!(stderr.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{arguments:?}: {stderr}");
        assert_eq!(stderr.trim_end().lines().count(), 1, "{arguments:?}: {stderr}");
    }
    Ran { status: status.code(), stderr, stdout }
}

/// Returns the names of the differences of a check.
fn differences(ran: &Ran) -> Vec<String> {
    let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap_or_default();
    let all = report["differences"].as_array().cloned().unwrap_or_default();
    all.iter().filter_map(|one| one["name"].as_str().map(Into::into)).collect()
}

fn make(folder: &Path, name: &str, words: &str) -> PathBuf {
    let mut arguments: Vec<&str> = words.split_whitespace().collect();
    arguments.extend(["--out", name, "-q"]);
    let output = gfmd(folder, &arguments);
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    folder.join(name)
}

/// Changes a copy of a file, writes the matching checksum, and puts the copy in its place.
fn forge(path: &Path, change: impl FnOnce(&File)) {
    // A process started by another test may hold the lock of an open file; a copy has no lock.
    let edit = |change: &dyn Fn(&File)| {
        let [changing, fresh] = ["changing", "fresh"].map(|name| path.with_extension(name));
        std::fs::copy(path, &changing).unwrap();
        let open = File::open_rw(&changing).unwrap();
        change(&open);
        open.close().unwrap();
        std::fs::copy(&changing, &fresh).unwrap();
        std::fs::rename(&fresh, path).unwrap();
        std::fs::remove_file(&changing).unwrap();
    };
    let change = std::cell::RefCell::new(Some(change));
    edit(&|file| change.take().expect("it is called once")(file));
    if let Ok(sum) = Reader::open(path).and_then(|reader| reader.content_sha256()) {
        edit(&|file| set_text(file, "content_sha256", &sum));
    }
}

fn set_text(at: &Location, name: &str, text: &str) {
    let text: VarLenUnicode = text.parse().unwrap();
    let attribute = at.attr(name).or_else(|_| at.new_attr::<VarLenUnicode>().create(name)).unwrap();
    attribute.write_scalar(&text).unwrap();
}

fn set_values(file: &File, path: &str, values: Vec<f64>) {
    let variable = file.dataset(path).unwrap();
    let values = ArrayD::from_shape_vec(variable.shape(), values).unwrap();
    if values.ndim() == 0 { variable.write_scalar(&values[[]]) } else { variable.write(&values) }.unwrap();
}

/// Changes the configuration of a file.
fn configure(path: &Path, change: impl FnOnce(&mut toml::Table)) {
    let text = Reader::open(path).unwrap().text("/", "config").unwrap();
    let mut table: toml::Table = text.parse().unwrap();
    change(&mut table);
    forge(path, |file| set_text(file, "config", &table.to_string()));
}

/// Returns every file of a folder with its bytes; special files without.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let about = std::fs::symlink_metadata(&path).unwrap();
        if about.is_dir() {
            all.extend(snapshot(&path));
        }
        let bytes = if about.is_file() { std::fs::read(&path).unwrap() } else { Vec::new() };
        all.insert(path, bytes);
    }
    all
}

/// Returns the files of a folder that were made, changed or removed since `before`.
fn changed(before: &BTreeMap<PathBuf, Vec<u8>>, folder: &Path) -> Vec<PathBuf> {
    let after = snapshot(folder);
    let all = before.keys().chain(after.keys().filter(|path| !before.contains_key(*path)));
    all.filter(|path| before.get(*path) != after.get(*path)).cloned().collect()
}

/// Files of every kind with flags in their configuration, by name.
const FLAGGED: [(&str, &str); 4] = [
    ("contact.h5", "contact --n 16 --eps-f-inv 4 --p-star 0.05"),
    ("path.h5", "path --n 16 --eps-f-inv 4 --p-star 0.02,0.05 --steps 2"),
    ("punch.h5", "punch --n 16"),
    ("body.h5", "body --surface punch.h5 --levels 3"),
];

#[test]
fn a_configuration_of_a_stranger_writes_nothing_and_opens_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, words) in [FLAGGED[2], FLAGGED[0], FLAGGED[1], FLAGGED[3]] {
        make(folder, name, words);
    }
    for name in
        ["victim.h5", "victim.vti", "victim.svg", "victim-map.svg", "victim-map.png", "victim-u_z.svg", "victim-ux.svg"]
    {
        std::fs::write(folder.join(name), "precious").unwrap();
    }
    assert!(Command::new("mkfifo").arg(folder.join("fifo")).status().unwrap().success());
    // Value of a key, and the allowed statuses: 0 if it changes nothing, 1 or 2 if it may.
    let cases: &[(&str, &str, &[i32])] = &[
        ("plots", "\"victim\"", &[0]),
        ("out", "\"victim.h5\"", &[0]),
        ("vtk", "\"victim.vti\"", &[0]),
        ("compare", "\"/dev/zero\"", &[0]),
        ("resume", "true", &[0]),
        ("checkpoint", "1e-9", &[0]),
        ("evil", "1", &[2]),
        ("threads", "9", &[2]),
        ("json", "true", &[2]),
        ("\"--plots\"", "\"victim\"", &[2]),
        ("\"young=1 --plots\"", "\"victim\"", &[2]),
        ("young", "\"--plots=victim\"", &[2]),
        ("young", "\"1\\n--plots=victim\"", &[2]),
        ("young", "[1.0, 2.0]", &[2]),
        ("young", "{ plots = \"victim\" }", &[2]),
        ("young", "true", &[2]),
        ("young", "nan", &[2]),
        ("size", "[[1.0]]", &[2]),
        ("solver", "\"auto --plots=victim\"", &[2]),
        ("solver", "\"\\u001b[2J\"", &[2]),
        ("tolerance", "\"--out=victim.h5\"", &[2]),
        ("surface", "\"../../etc/passwd\"", &[0, 1, 2]),
        ("surface", "\"/dev/zero\"", &[0, 1, 2]),
        ("surface", "\"fifo\"", &[0, 1, 2]),
        ("surface", "\"victim.h5:/x\"", &[0, 1, 2]),
        ("second_surface", "\"fifo\"", &[0, 1, 2]),
        ("hardness", "\"/dev/zero\"", &[2]),
        ("hardness", "\"fifo\"", &[2]),
        ("base_displacement", "\"/dev/zero\"", &[2]),
        ("lower_surface", "\"fifo\"", &[2]),
        ("mask", "\"/dev/zero\"", &[0, 1, 2]),
        ("traction", "\"fifo\"", &[0, 1, 2]),
        ("p_star", "[\"1:2:10000\"]", &[2]),
        ("n", "[9223372036854775807]", &[0, 1, 2]),
        ("steps", "4000000000", &[0, 1, 2]),
        ("refine", "8", &[0, 1, 2]),
    ];
    let (mut ran, mut left_out) = (0, 0);
    for (number, (name, _)) in FLAGGED.into_iter().enumerate() {
        let honest = std::fs::read(folder.join(name)).unwrap();
        for (index, (key, value, allowed)) in cases.iter().enumerate() {
            // The largest grids of a punch take long and are computed correctly. The short test has all cases for a
            // contact, and each of them for one more kind.
            let is_long = (*key == "refine" || *key == "traction") && name == "punch.h5";
            if is_long || !long() && number > 0 && index % 3 != number - 1 {
                left_out += 1;
                continue;
            }
            let line: toml::Table = format!("{key} = {value}").parse().unwrap();
            configure(&folder.join(name), |table| table.extend(line));
            let before = snapshot(folder);
            for arguments in [&["check", name, "--json"][..], &["check", name, "--rerun", "--json"]] {
                let ended = run(folder, arguments);
                let status = ended.status.unwrap();
                // A key unknown to this kind is refused even if another kind has it.
                assert!(
                    allowed.contains(&status) || status == 2 && *allowed != [0],
                    "{name} {key} = {value}: {status} {}",
                    ended.stderr
                );
                assert!(changed(&before, folder).is_empty(), "{name} {key} = {value}: {:?}", changed(&before, folder));
                assert!(!ended.stderr.contains('\u{1b}'), "{}", ended.stderr);
                ran += 1;
            }
            if ["contact.h5", "path.h5"].contains(&name) {
                let page = tempfile::tempdir().unwrap();
                let page = page.path().join("page.html");
                run(folder, &["report", name, "--out", page.to_str().unwrap()]);
                assert!(changed(&before, folder).is_empty(), "report of {name}: {:?}", changed(&before, folder));
                let text = std::fs::read_to_string(&page).unwrap_or_default();
                assert!(!text.contains(">--plots="), "the page of {name} with {key} = {value} repeats the flag");
            }
            std::fs::write(folder.join(name), &honest).unwrap();
        }
    }
    assert_eq!(ran, 2 * (4 * cases.len() - left_out));
    assert!(if long() { left_out == 2 } else { ran > 3 * cases.len() }, "{ran}");
    // A field stored in the result replaces the file named by a key beside a generated surface.
    make(folder, "squeezed.h5", "contact --n 16 --height 0.5 --lower-seed 2 --p-star 0.02");
    configure(&folder.join("squeezed.h5"), |table| {
        table.remove("lower_seed");
        table.insert("lower_surface".into(), "fifo".into());
    });
    for arguments in [&["check", "squeezed.h5"][..], &["check", "squeezed.h5", "--rerun"]] {
        let ended = run(folder, arguments);
        assert_eq!(ended.status, Some(0), "{}", ended.stderr);
    }
}

#[test]
fn inputs_are_regular_files_and_those_that_the_result_names_twice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    make(folder, "punch.h5", "punch --n 16");
    make(folder, "body.h5", "body --surface punch.h5 --levels 3");
    ndarray_npy::write_npy(
        folder.join("h.npy"),
        &Array2::from_shape_fn((16, 16), |(i, j)| ((i * j) as f64).sin() * 1e-3),
    )
    .unwrap();
    make(folder, "contact.h5", "contact --surface h.npy --p-star 0.05");
    assert!(Command::new("mkfifo").arg(folder.join("fifo")).status().unwrap().success());
    for special in ["/dev/zero", "fifo", "/", "/dev/stdin\u{1b}[2J\n"] {
        for (name, group) in [("contact.h5", "/surface"), ("body.h5", "/input")] {
            let honest = std::fs::read(folder.join(name)).unwrap();
            forge(&folder.join(name), |file| set_text(&file.group(group).unwrap(), "file", special));
            if name == "body.h5" {
                configure(&folder.join(name), |table| drop(table.insert("surface".into(), special.into())));
            }
            for arguments in [&["check", name][..], &["check", name, "--rerun"]] {
                let ended = run(folder, arguments);
                let is_absent = !Path::new(special).exists() && special != "fifo";
                assert!(ended.status == Some(2) || is_absent, "{special:?}: {} {}", ended.stdout, ended.stderr);
            }
            std::fs::write(folder.join(name), &honest).unwrap();
        }
    }
    // The input of a body is the file with the checksum.
    std::fs::copy(folder.join("punch.h5"), folder.join("other.h5")).unwrap();
    configure(&folder.join("body.h5"), |table| drop(table.insert("surface".into(), "other.h5".into())));
    let ended = run(folder, &["check", "body.h5"]);
    assert_eq!(ended.status, Some(2));
    assert!(ended.stderr.contains("it must be the input \"punch.h5\" of the file"), "{}", ended.stderr);
}

/// Number of contacts in `FORGED`.
const CONTACTS: usize = 5;

/// Files with parts to forge, and their kinds; contacts first.
const FORGED: [(&str, ResultKind, &str); 16] = [
    (
        "wall.h5",
        ResultKind::Contact,
        "contact --n 24 --eps-f-inv 6 --p-star 0.02,0.1 --height 0.4 --poisson 0.3 --statistics --flow",
    ),
    ("one.h5", ResultKind::Contact, "contact --n 16 --eps-f-inv 4 --p-star 0.05 --history"),
    ("scan.h5", ResultKind::Contact, "contact --surface h.npy --size 2 --p-star 0.05 --detrend plane --boundary free"),
    (
        "squeezed.h5",
        ResultKind::Contact,
        "contact --n 24 --eps-f-inv 6 --p-star 0.05 --height 0.4 --poisson 0.3 --lower-seed 2",
    ),
    (
        "law.h5",
        ResultKind::Contact,
        "contact --n 24 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=6e-3 --p-star 0.05,0.02",
    ),
    (
        "loop.h5",
        ResultKind::Path,
        "path --n 24 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=6e-3 --approach=0.004,0.001 \
         --steps 3",
    ),
    (
        "between.h5",
        ResultKind::Path,
        "path --n 16 --eps-f-inv 4 --height 0.3 --lower-seed 2 --prony 0.5:0.4 --coefficient 0.1 --p-star 0.05,0.08 \
         --time 0,1 --distance 0,0.3 --steps 1",
    ),
    ("slip.h5", ResultKind::Path, "path --n 16 --eps-f-inv 4 --p-star 0.05 --friction 0.3 --lateral 0,0.001 --steps 2"),
    (
        "creep.h5",
        ResultKind::Path,
        "path --n 16 --eps-f-inv 4 --prony 0.5:0.4,20:0.3 --p-star 0.05 --time 0,1 --steps 1",
    ),
    ("slide.h5", ResultKind::Slide, "slide --n 16 --eps-f-inv 4 --prony 0.5:0.4,20:0.3 --p-star 0.05 --velocity 0.1,1"),
    (
        "wear.h5",
        ResultKind::Path,
        "wear --n 16 --eps-f-inv 4 --p-star 0.05,0.1 --coefficient 1 --distance 0,0.2 --steps 2",
    ),
    (
        "warm.h5",
        ResultKind::Slide,
        "slide --n 16 --eps-f-inv 4 --heat 1,0.1,0.3,0.2 --friction 0.3 --p-star 0.05 --velocity 1,10",
    ),
    ("punch.h5", ResultKind::Punch, "punch --n 16"),
    ("body.h5", ResultKind::Body, "body --surface press.h5 --levels 3"),
    ("sweep.h5", ResultKind::KappaSweep, "kappa-sweep --config sweep.toml"),
    ("study.h5", ResultKind::Study, "study study.toml"),
];

/// Returns the variables and attributes of a file; variables without an `@`.
fn parts(reader: &Reader) -> Vec<String> {
    fn group(reader: &Reader, path: &str, all: &mut Vec<String>) {
        let at = if path.is_empty() { "/" } else { path };
        all.extend(reader.attributes(at).unwrap().into_iter().map(|(name, _)| format!("{path}@{name}")));
        for name in reader.names(at) {
            let member = format!("{path}/{name}");
            if reader.contains(&member) {
                let attributes = reader.attributes(&member).unwrap();
                all.extend(attributes.into_iter().map(|(name, _)| format!("{member}@{name}")));
                all.push(member);
            } else {
                group(reader, &member, all);
            }
        }
    }
    let mut all = Vec::new();
    group(reader, "", &mut all);
    all
}

/// Forges a part: the largest number of a variable by a thousandth, a text by a letter. Returns false without a number.
fn forge_part(path: &Path, part: &str) -> bool {
    let reader = Reader::open(path).unwrap();
    if let Some((at, name)) = part.split_once('@') {
        let attributes = reader.attributes(if at.is_empty() { "/" } else { at }).unwrap();
        let (_, value) = attributes.into_iter().find(|(other, _)| other == name).unwrap();
        forge(path, |file| {
            let at: Location = match file.dataset(at) {
                Ok(dataset) => (**dataset).clone(),
                Err(_) => (*file.group(if at.is_empty() { "/" } else { at }).unwrap()).clone(),
            };
            match value {
                Attribute::Text(text) => set_text(&at, name, &format!("{text}x")),
                Attribute::Real(x) => {
                    at.attr(name).unwrap().write_scalar(&if x == 0.0 { 1.0 } else { x * 1.001 }).unwrap();
                }
                Attribute::Integer(i) => at.attr(name).unwrap().write_scalar(&(i + 1)).unwrap(),
                Attribute::Natural(i) => at.attr(name).unwrap().write_scalar(&(i + 1)).unwrap(),
            }
        });
        return true;
    }
    let Ok(mut values) = reader.values::<f64>(part) else {
        let mut texts = reader.texts(part).unwrap();
        texts[0].push('x');
        let texts: Vec<VarLenUnicode> = texts.iter().map(|text| text.parse().unwrap()).collect();
        forge(path, |file| file.dataset(part).unwrap().write_raw(&texts).unwrap());
        return true;
    };
    let finite = (0..values.len()).filter(|k| values[*k].is_finite());
    let Some(largest) = finite.max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs())) else { return false };
    let is_whole = values.iter().all(|value| value.fract() == 0.0);
    values[largest] = match values[largest] {
        0.0 => 1.0,
        value if is_whole => value - 1.0,
        value => value * 1.001,
    };
    forge(path, |file| set_values(file, part, values));
    true
}

/// Returns what `check` notices of a part without and with `--rerun`; `None` if the part is not in the table.
fn coverage(kind: ResultKind, reader: &Reader, part: &str) -> Option<(Coverage, Coverage)> {
    let row = row_of(kind, part);
    if reader.is_coordinate(part) && row.is_none_or(|row| row.plain != Coverage::Checksum) {
        return Some((Coverage::Verified, Coverage::Verified));
    }
    row.map(|row| (row.plain, row.rerun))
}

/// Returns the parts of a file to forge: all in a long test, else one of eight of each row of the table, other ones for
/// the next `number`.
fn chosen_parts(kind: ResultKind, reader: &Reader, number: usize) -> Vec<String> {
    let mut rows: Vec<(Option<*const Row>, Vec<String>)> = Vec::new();
    for part in parts(reader) {
        let row = row_of(kind, &part).map(std::ptr::from_ref);
        match rows.iter_mut().find(|(other, _)| *other == row) {
            Some((_, parts)) => parts.push(part),
            None => rows.push((row, vec![part])),
        }
    }
    let step = if long() { 1 } else { 8 };
    let some = |(_, parts): (_, Vec<String>)| {
        let first = number % step.min(parts.len());
        parts.into_iter().skip(first).step_by(step)
    };
    rows.into_iter().flat_map(some).collect()
}

/// Forges parts of files, and compares what `check` notices with the table; more than `least` forged parts must be
/// noticed and unnoticed.
fn parts_are_verified(forged: &[(&str, ResultKind, &str)], least: [usize; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let ramp = Array2::from_shape_fn((24, 24), |(i, j)| {
        0.002 * i as f64 + 0.01 * (0.9 * i as f64).sin() * (0.7 * j as f64).cos()
    });
    ndarray_npy::write_npy(folder.join("h.npy"), &ramp).unwrap();
    make(folder, "press.h5", "punch --n 16");
    let (mut wrong, mut verified, mut unnoticed) = (Vec::new(), 0, 0);
    for (number, (name, kind, words)) in forged.iter().enumerate() {
        let kind = *kind;
        let path = make(folder, name, words);
        let ended = run(folder, &["check", name, "--json", "--rerun"]);
        assert_eq!(ended.status, Some(0), "{name}: {:?} {}", differences(&ended), ended.stderr);
        let honest = std::fs::read(&path).unwrap();
        let reader = Reader::open(&path).unwrap();
        let strange = parts(&reader).into_iter().filter(|part| coverage(kind, &reader, part).is_none());
        wrong.extend(strange.map(|part| format!("{name}: {part} is not in the table")));
        let commands = [&["check", name, "--json"][..], &["check", name, "--json", "--rerun"]];
        let mut together = [Vec::new(), Vec::new()];
        for part in chosen_parts(kind, &reader, number) {
            let Some((plain, rerun)) = coverage(kind, &reader, &part) else { continue };
            if part == "@content_sha256"
                || plain == Coverage::InPart && rerun == Coverage::InPart
                || !forge_part(&path, &part)
            {
                continue;
            }
            // A change noticed without a second run is noticed with one.
            let reruns = plain != Coverage::Verified && kind != ResultKind::KappaSweep;
            let coverage = [plain, if reruns { rerun } else { Coverage::InPart }];
            for ((coverage, words), together) in coverage.iter().zip(commands).zip(&mut together) {
                match coverage {
                    Coverage::Verified if run(folder, words).status == Some(0) => {
                        wrong.push(format!("{words:?} does not notice {part}"));
                    }
                    Coverage::Checksum => together.push(part.clone()),
                    Coverage::Verified | Coverage::InPart => {}
                }
            }
            verified += usize::from(plain == Coverage::Verified);
            std::fs::write(&path, &honest).unwrap();
        }
        // Parts that nothing but the checksum protects are unnoticed all at once.
        for (parts, words) in together.iter().zip(commands) {
            parts.iter().for_each(|part| assert!(forge_part(&path, part)));
            let ended = run(folder, words);
            if ended.status != Some(0) {
                wrong.push(format!("{words:?} notices one of {parts:?}: {:?} {}", differences(&ended), ended.stderr));
            }
            std::fs::write(&path, &honest).unwrap();
        }
        unnoticed += together[0].len();
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let least = if long() { least.map(|count| 3 * count) } else { least };
    assert!(verified > least[0] && unnoticed > least[1], "{verified} {unnoticed}");
}

#[test]
fn every_part_of_a_contact_is_verified_as_the_page_says() {
    parts_are_verified(&FORGED[..CONTACTS], [25, 25]);
}

#[test]
fn every_part_of_another_result_is_verified_as_the_page_says() {
    parts_are_verified(&FORGED[CONTACTS..], [25, 25]);
}

#[test]
fn a_file_of_another_layout_is_not_taken_for_a_result() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = make(folder, "c.h5", "contact --n 16 --eps-f-inv 4 --p-star 0.05 --fields pressure,gap,displacement_z");
    let honest = std::fs::read(&path).unwrap();
    let differ = |words: &str, change: &dyn Fn(&File)| {
        forge(&path, change);
        let ended = run(folder, &["check", "c.h5", "--json"]);
        let found = differences(&ended);
        assert!(
            ended.status == Some(1) && found.iter().any(|name| name == words),
            "{words}: {found:?} {}",
            ended.stderr
        );
        std::fs::write(&path, &honest).unwrap();
    };
    // A result of another version is refused in one sentence, before its parts are looked at.
    forge(&path, |file| {
        file.attr("schema_version").unwrap().write_scalar(&1_i64).unwrap();
        set_text(file, "config", "tol = 1e-8");
        file.unlink("loads/approach").unwrap();
    });
    for words in [&["check", "c.h5"][..], &["report", "c.h5"], &["body", "--surface", "c.h5", "--depths", "0.1"]] {
        let ended = run(folder, words);
        let sentence = "c.h5 has the schema_version 1; this program reads 2";
        assert!(ended.status == Some(2) && ended.stderr.trim_end().ends_with(sentence), "{words:?} {}", ended.stderr);
    }
    std::fs::write(&path, &honest).unwrap();
    differ("@schema_version", &|file| file.delete_attr("schema_version").unwrap());
    differ("/evil", &|file| file.new_dataset::<f64>().shape(3).create("evil").map(drop).unwrap());
    differ("/loads/evil", &|file| file.new_dataset::<f64>().shape(1).create("loads/evil").map(drop).unwrap());
    differ("@evil", &|file| set_text(file, "evil", "x"));
    differ("/loads/kappa@units", &|file| set_text(&file.dataset("loads/kappa").unwrap(), "units", "Pa"));
    differ("/loads/kappa", &|file| file.unlink("loads/kappa").unwrap());
    differ("/loads/iterations", &|file| file.unlink("loads/iterations").unwrap());
    differ("/surface@rms_gradient", &|file| file.group("surface").unwrap().delete_attr("rms_gradient").unwrap());
    differ("/fields/gap", &|file| file.unlink("fields/gap").unwrap());
    // A file without a checksum, or with a group that contains itself, has no valid checksum.
    differ("content_sha256", &|file| file.group("/").unwrap().link_hard("/loads", "/loads/loads").unwrap());
    // External links and raw data are not followed.
    std::fs::copy(&path, folder.join("other.h5")).unwrap();
    differ("/loads/kappa", &|file| {
        file.unlink("loads/kappa").unwrap();
        file.link_external("other.h5", "/loads/kappa", "/loads/kappa").unwrap();
    });
    // Without forge, which writes a checksum.
    let copy = folder.join("d.h5");
    std::fs::copy(&path, &copy).unwrap();
    let open = File::open_rw(&copy).unwrap();
    open.delete_attr("content_sha256").unwrap();
    open.close().unwrap();
    std::fs::copy(&copy, &path).unwrap();
    let ended = run(folder, &["check", "c.h5", "--json"]);
    assert_eq!((ended.status, differences(&ended)), (Some(1), vec!["content_sha256".to_owned()]));
    std::fs::write(&path, &honest).unwrap();
    // Heights that the seed does not produce.
    configure(&path, |table| drop(table.insert("seed".into(), 2.into())));
    let ended = run(folder, &["check", "c.h5", "--json"]);
    assert_eq!(ended.status, Some(1));
    assert_eq!(differences(&ended), ["/surface/height", "/surface@description"]);
}

#[test]
fn the_surface_of_an_array_is_that_of_the_file_in_a_second_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let heights = Array2::from_shape_fn((24, 20), |(i, j)| 0.01 * (0.9 * i as f64).sin() * (0.7 * j as f64).cos());
    ndarray_npy::write_npy(folder.join("h.npy"), &heights).unwrap();
    let path = make(folder, "c.h5", "contact --surface h.npy --size 1.2,1 --p-star 0.05 --height 0.5 --poisson 0.3");
    // Configuration written by gfmd.Contact.save for heights in memory.
    configure(&path, |table| {
        let kept = ["size", "poisson", "young", "height", "p_star", "boundary", "solver", "tolerance", "law"];
        table.retain(|key, _| kept.contains(&key));
    });
    for arguments in [&["check", "c.h5", "--json"][..], &["check", "c.h5", "--rerun", "--json"]] {
        let ended = run(folder, arguments);
        assert_eq!(ended.status, Some(0), "{:?} {}", differences(&ended), ended.stderr);
    }
}

#[test]
fn seeds_that_no_configuration_holds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for words in [
        "contact --n 16 --p-star 0.05 --seed",
        "contact --n 16 --p-star 0.05 --height 0.1 --lower-seed",
        "path --n 16 --p-star 0.05 --seed",
        "surface --n 16 --seed",
        "theory --n 16 --p-star 0.05 --seed",
    ] {
        for seed in ["9223372036854775808", "18446744073709551615"] {
            let arguments: Vec<&str> = words.split_whitespace().chain([seed]).collect();
            let output = gfmd(folder, &arguments);
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{words} {seed}: {message}");
            let flag = words.rsplit(' ').next().unwrap();
            assert!(message.contains(flag) && message.contains("9223372036854775807"), "{message}");
        }
    }
    make(folder, "c.h5", "contact --n 16 --eps-f-inv 4 --p-star 0.05 --seed 9223372036854775807");
    assert_eq!(run(folder, &["check", "c.h5", "--rerun"]).status, Some(0));
}

#[test]
fn a_page_of_numbers_of_any_size_is_made_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    std::fs::write(folder.join("study.toml"), STUDY).unwrap();
    let extremes = [
        [1e308, -1e308],
        [f64::NAN; 2],
        [f64::INFINITY, f64::NEG_INFINITY],
        [5e-324, -5e-324],
        [0.0; 2],
        [1.0, 1.0 + f64::EPSILON],
        [-1.0; 2],
        [1e300, 1e-300],
    ];
    let fill = |file: &File, path: &str, [a, b]: [f64; 2]| {
        let length: usize = file.dataset(path).unwrap().shape().iter().product();
        set_values(file, path, (0..length).map(|k| if k % 2 == 0 { a } else { b }).collect());
    };
    let mut pages = 0;
    let step = if long() { 1 } else { 3 };
    for (number, (name, words)) in [
        ("contact.h5", "contact --n 16 --eps-f-inv 4 --p-star 0.02,0.05,0.1 --height 0.4 --poisson 0.3 --statistics"),
        ("path.h5", "path --n 16 --eps-f-inv 4 --p-star 0.02,0.05 --friction 0.3 --lateral 0,0.001 --steps 2"),
        ("sweep.h5", "kappa-sweep --config sweep.toml"),
        ("study.h5", "study study.toml"),
    ]
    .into_iter()
    .enumerate()
    {
        let path = make(folder, name, words);
        let honest = std::fs::read(&path).unwrap();
        let reader = Reader::open(&path).unwrap();
        let is_filled = |part: &String| !part.contains('@') && reader.values::<f64>(part).is_ok();
        let variables: Vec<String> = parts(&reader).into_iter().filter(is_filled).collect();
        let mut report = |change: &dyn Fn(&File), what: &str| {
            forge(&path, change);
            let ended = run(folder, &["report", name, "--out", "page.html", "--json"]);
            assert!(ended.status == Some(0) || !ended.stderr.is_empty(), "{name} {what}");
            pages += u32::from(ended.status == Some(0));
            std::fs::write(&path, &honest).unwrap();
        };
        // Each variable takes the next of the extremes.
        for (index, variable) in variables.iter().enumerate().step_by(step) {
            report(&|file| fill(file, variable, extremes[index % extremes.len()]), variable);
        }
        let some = |groups: &[&str]| -> Vec<&String> {
            variables.iter().filter(|path| groups.iter().any(|group| path.starts_with(group))).collect()
        };
        let sets = [
            ("all", some(&["/"])),
            ("scalars", some(&["/loads", "/path", "/runs"])),
            ("fields", some(&["/fields", "/example"])),
        ];
        // The short test has a third of the extremes for each set, other ones for the next file.
        for (index, extreme) in extremes.into_iter().enumerate() {
            for (set, (what, filled)) in sets.iter().enumerate() {
                if (index + set + number) % step == 0 {
                    report(&|file| filled.iter().for_each(|variable| fill(file, variable, extreme)), what);
                }
            }
        }
    }
    assert!(pages > 50, "{pages}");
}

#[test]
fn the_page_of_the_docs_is_that_of_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/trust.md");
    if std::env::var("GFMD_DOCS").is_ok_and(|word| word == "write") {
        std::fs::write(&path, page()).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == page(), "docs/trust.md is not that of the table; write it with GFMD_DOCS=write");
}
