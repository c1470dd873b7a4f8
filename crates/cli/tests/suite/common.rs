//! Runs the program as a user would.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use gfmd_files::Reader;

/// Returns true for the long tests (`.ci/long`).
pub(crate) fn long() -> bool {
    std::env::var_os("GFMD_LONG").is_some()
}

/// Sweep that takes seconds.
pub(crate) const SWEEP: &str = "
[points]
design = 'star'
eps_t_inv = [1.0, 2.0]
eps_f_inv = [4, 8]
eps_c_inv = [4, 8]
centre = [2, 4, 4]
[loads]
p_star = [0.02, 0.05]
[statistics]
realisations = 2
[fit]
p_star = 0.05
alpha_c = 1
resamples = 20
";

/// Study of twelve members under two loads.
pub(crate) const STUDY: &str = r#"
command = "contact"
[contact]
n = 16
eps_f_inv = 4
p_star = [0.02, 0.1]
[study]
surface = [{ name = "smooth", hurst = 0.9 }, { name = "rough", hurst = 0.3 }]
seed = "1:3"
body = [{ name = "soft", young = 1.0 }, { name = "thin", height = 0.1, poisson = 0.3 }]
"#;

/// Returns this sweep with other numbers of surfaces and refits.
pub(crate) fn sweep(realisations: usize, resamples: usize) -> String {
    SWEEP
        .replace("realisations = 2", &format!("realisations = {realisations}"))
        .replace("resamples = 20", &format!("resamples = {resamples}"))
}

/// Runs the program with `arguments` in `folder`, under the emulator in `GFMD_EMULATOR`, if any.
pub(crate) fn gfmd(folder: &Path, arguments: &[&str]) -> Output {
    let emulator = std::env::var("GFMD_EMULATOR").unwrap_or_default();
    let mut words: Vec<&str> = emulator.split_whitespace().chain([env!("CARGO_BIN_EXE_gfmd")]).collect();
    Command::new(words.remove(0)).args(words).current_dir(folder).args(arguments).output().expect("the program starts")
}

/// Returns the JSON of the program; panics if the program fails.
pub(crate) fn json(folder: &Path, arguments: &[&str]) -> serde_json::Value {
    let output = gfmd(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}"))
}

/// Returns every number of a file except the seconds, which differ between identical runs, and its warnings.
pub(crate) fn numbers(path: &Path) -> BTreeMap<String, Vec<u64>> {
    let mut all = BTreeMap::new();
    if path.extension().is_some_and(|extension| extension == "vti") {
        let bytes = std::fs::read(path).unwrap();
        all.insert("bytes".into(), bytes.into_iter().map(u64::from).collect());
        return all;
    }
    fn group(file: &Reader, path: &str, all: &mut BTreeMap<String, Vec<u64>>) {
        for name in file.names(if path.is_empty() { "/" } else { path }) {
            let member = format!("{path}/{name}");
            if !file.contains(&member) {
                group(file, &member, all);
            } else if name != "seconds" {
                let values = match file.values::<f64>(&member) {
                    Ok(values) => values.into_iter().map(f64::to_bits).collect(),
                    Err(_) => file.texts(&member).unwrap().concat().bytes().map(u64::from).collect(),
                };
                all.insert(member, values);
            }
        }
    }
    let file = Reader::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    group(&file, "", &mut all);
    if let Ok(warnings) = file.text("/", "warnings") {
        all.insert("warnings".into(), warnings.bytes().map(u64::from).collect());
    }
    all
}
