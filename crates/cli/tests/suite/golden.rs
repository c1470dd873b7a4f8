//! Numbers printed and written by the commands, compared with recorded numbers in `tests/golden`.
//!
//! On the processor family that recorded them, every number must have the same bits. Elsewhere, with other rounding of
//! the vector instructions, they must agree to a tolerance. After a change that is meant to alter numbers, record them
//! again with `GFMD_GOLDEN=write cargo test -p gfmd-cli --test suite golden::`, and give the reason in CHANGELOG.md.
//!
//! `GFMD_EMULATOR="qemu-x86_64 -cpu Nehalem" cargo test -p gfmd-cli --test suite golden:: -- --nocapture` runs the
//! program on an emulated processor without AVX and prints the largest deviation of each case.

#![expect(clippy::print_stdout, reason = "the deviations without vector units")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::common::{gfmd, long};
use gfmd_files::Reader;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Value, json as value};

/// Largest deviation on another kind of processor, relative to the largest number of the same array. Searches end at
/// residuals of 1e-8.
const TOLERANCE: f64 = 1e-6;

/// Numbers up to this size are rounding errors of larger ones.
const LARGEST_ROUNDING_ERROR: f64 = 1e-15;

/// Keys of numbers that differ between identical runs: time, memory, threads.
const VOLATILE: [&str; 3] = ["seconds", "peak_bytes", "threads"];

/// Keys of step counts and residuals, which repeat on one kind of processor only.
const EFFORT: [&str; 8] =
    ["iterations", "transform_pairs", "residual", "lowest_curvature", "residual_", "steps_to_1e8", "error", "seed"];

const SWEEP: &str = "
[points]
design = 'star'
eps_t_inv = [1.0, 2.0]
eps_f_inv = [4.0, 8.0]
eps_c_inv = [4.0, 8.0]
centre = [2.0, 4.0, 4.0]
[loads]
p_star = [0.02, 0.05]
[statistics]
realisations = 4
[fit]
p_star = 0.05
resamples = 200
";

/// Array of numbers.
#[derive(Clone, Debug, PartialEq)]
struct Numbers {
    values: Vec<f64>,
}

impl Numbers {
    /// Returns the FNV-1a hash of the bits.
    fn digest(&self) -> String {
        let bytes = self.values.iter().flat_map(|value| value.to_bits().to_le_bytes());
        let hash =
            bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
        format!("{hash:016x}")
    }

    /// Returns numbers that depend smoothly on the values: count, sum, root mean square and first moment of the finite
    /// ones.
    fn summary(&self) -> [f64; 4] {
        let finite: Vec<f64> = self.values.iter().copied().filter(|value| value.is_finite()).collect();
        let count = finite.len() as f64;
        let mean = |f: &dyn Fn(usize, f64) -> f64| {
            finite.iter().enumerate().map(|(i, value)| f(i, *value)).sum::<f64>() / count.max(1.0)
        };
        let root_mean_square = mean(&|_, value| value * value).sqrt();
        [count, mean(&|_, value| value), root_mean_square, mean(&|i, value| value * i as f64 / count)]
    }
}

/// Collects every number of a report by its place.
fn of_json(place: &str, report: &Value, numbers: &mut BTreeMap<String, Numbers>) {
    let one = |number: f64| Numbers { values: vec![number] };
    match report {
        Value::Number(number) => drop(numbers.insert(place.into(), one(number.as_f64().unwrap()))),
        Value::Bool(flag) => drop(numbers.insert(place.into(), one(f64::from(u8::from(*flag))))),
        Value::Null => drop(numbers.insert(place.into(), one(f64::NAN))),
        Value::String(_) => {}
        Value::Array(entries) if !entries.is_empty() && entries.iter().all(|entry| entry.is_number()) => {
            let values = entries.iter().filter_map(Value::as_f64).collect();
            numbers.insert(place.into(), Numbers { values });
        }
        Value::Array(entries) => {
            entries.iter().enumerate().for_each(|(i, entry)| of_json(&format!("{place}/{i}"), entry, numbers));
        }
        Value::Object(entries) => {
            for (name, entry) in entries.iter().filter(|(name, _)| !VOLATILE.contains(&name.as_str())) {
                of_json(&format!("{place}/{name}"), entry, numbers);
            }
        }
    }
}

/// Collects the keys below a place of a report, in order; the entries of an array share their keys.
struct Keys<'a> {
    place: String,
    keys: &'a mut Vec<String>,
}

impl<'de> DeserializeSeed<'de> for Keys<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Keys<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(name) = map.next_key::<String>()? {
            let place = format!("{}/{name}", self.place);
            if !self.keys.contains(&place) {
                self.keys.push(place.clone());
            }
            // Reasons are texts, not keys.
            let below = name != "undefined";
            let mut reasons = Vec::new();
            let keys = if below { &mut *self.keys } else { &mut reasons };
            map.next_value_seed(Keys { place, keys })?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        while entries.next_element_seed(Keys { place: self.place.clone(), keys: &mut *self.keys })?.is_some() {}
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }
}

/// Returns the keys of a report in their order.
fn keys(text: &str) -> Vec<String> {
    let mut keys = Vec::new();
    let mut deserializer = serde_json::Deserializer::from_str(text);
    Keys { place: String::new(), keys: &mut keys }.deserialize(&mut deserializer).unwrap();
    keys
}

/// Collects every number of a file by its path.
fn of_file(path: &Path, group: &str, numbers: &mut BTreeMap<String, Numbers>) {
    let reader = Reader::open(path).unwrap();
    for name in reader.names(if group.is_empty() { "/" } else { group }) {
        let member = format!("{group}/{name}");
        if !reader.contains(&member) {
            of_file(path, &member, numbers);
        } else if !VOLATILE.contains(&name.as_str())
            && let Ok(values) = reader.values::<f64>(&member)
        {
            numbers.insert(member, Numbers { values });
        }
    }
}

fn recorded(case: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden").join(case).with_extension("json")
}

/// Returns the properties of the processor that decide the last bit: transforms and elementary functions choose among
/// its instructions.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    let vectors = format!("avx {}, fma {}", is_x86_feature_detected!("avx2"), is_x86_feature_detected!("fma"));
    #[cfg(not(target_arch = "x86_64"))]
    let vectors = "default";
    format!("{}, {}, {vectors}", std::env::consts::ARCH, std::env::consts::OS)
}

/// Output of a command: every number of its report and its files, and the keys of its report.
struct Said {
    numbers: BTreeMap<String, Numbers>,
    keys: Vec<String>,
}

/// Runs the command in `folder`.
fn said(folder: &Path, arguments: &str) -> Said {
    let mut all: Vec<&str> = arguments.split_whitespace().collect();
    all.extend(["--json", "-q"]);
    let output = gfmd(folder, &all);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    let report = String::from_utf8(output.stdout).unwrap();
    let mut numbers = BTreeMap::new();
    of_json("", &serde_json::from_str(&report).unwrap(), &mut numbers);
    if let Some(out) =
        all.iter().position(|argument| *argument == "--out").map(|i| all[i + 1]).filter(|out| out.ends_with(".h5"))
    {
        of_file(&folder.join(out), "", &mut numbers);
    }
    Said { numbers, keys: keys(&report) }
}

/// Runs the command in `folder` and compares its report and its files with the record.
fn check(folder: &Path, case: &str, arguments: &str) {
    let Said { numbers, keys } = said(folder, arguments);
    assert!(numbers.len() > 3, "{case}: hardly any numbers");
    if std::env::var_os("GFMD_GOLDEN").is_some_and(|what| what == "write") {
        let entries: BTreeMap<&String, Value> = (numbers.iter())
            .map(|(place, array)| (place, value!([array.values.len(), array.digest(), array.summary()])))
            .collect();
        let text = value!({ "keys": keys.join(" "), "numbers": entries, "processor": processor() });
        let text = serde_json::to_string(&text).unwrap();
        std::fs::write(recorded(case), text.replace("],\"/", "],\n\"/") + "\n").unwrap();
        return;
    }
    let text = std::fs::read_to_string(recorded(case)).unwrap();
    let golden: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(keys.join("\n"), golden["keys"].as_str().unwrap().replace(' ', "\n"), "{case}: the keys have changed");
    let emulated = std::env::var_os("GFMD_EMULATOR").is_some();
    let exact = golden["processor"] == processor() && !emulated;
    let mut largest = (0.0, String::new());
    let golden = golden["numbers"].as_object().unwrap();
    let names = |all: Vec<&String>| all.into_iter().cloned().collect::<Vec<_>>();
    assert_eq!(names(numbers.keys().collect()), names(golden.keys().collect()), "{case}: the names have changed");
    for (place, array) in &numbers {
        let [length, digest, summary] = [0, 1, 2].map(|i| &golden[place][i]);
        assert_eq!(array.values.len() as u64, length.as_u64().unwrap(), "{case}: length of {place}");
        if exact {
            assert_eq!(
                array.digest(),
                digest.as_str().unwrap(),
                "{case}: bits of {place}: {:?} {summary}",
                array.summary()
            );
        } else if !EFFORT.iter().any(|effort| place.contains(effort)) {
            let expected: Vec<f64> = summary.as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).collect();
            // A number that is zero up to rounding has no relative deviation.
            let scale = expected[2].max(LARGEST_ROUNDING_ERROR / TOLERANCE);
            let apart = array.summary().iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if apart > largest.0 * scale {
                largest = (apart / scale, place.clone());
            }
            assert!(apart <= TOLERANCE * scale, "{case}: {place} is {:?}, recorded {expected:?}", array.summary());
        }
    }
    if emulated {
        println!("{case}: {:.1e} at {}", largest.0, largest.1);
    }
}

#[test]
fn hard_wall() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    check(folder, "surface", "surface --n 64 --hurst 0.7 --seed 3 --out h.h5");
    check(folder, "surface-sra", "surface --n 64 --hurst 0.6 --method sra --seed 2 --out sra.h5");
    check(folder, "surface-rmd", "surface --n 64 --hurst 0.6 --method rmd --seed 2 --out rmd.h5");
    check(folder, "contact", "contact --n 128 --hurst 0.8 --p-star 0.01,0.05,0.2 --out c.h5");
    check(folder, "contact-slab", "contact --n 64 --height 0.2 --poisson 0.45 --approach 0.005,0.01 --out slab.h5");
    check(folder, "contact-approach", "contact --n 64 --approach 0.01 --solver verlet --tolerance 1e-5");
    check(folder, "contact-line", "contact --n 512 --dim 2 --p-star 0.05 --out line.h5");
    check(
        folder,
        "contact-file",
        "contact --surface h.h5:/surface/height --detrend slope --periodise mirror --flip --e-star 3 --p-star 0.03",
    );
    for solver in [
        "cg",
        "projected-cg",
        "preconditioned-cg",
        "verlet",
        "verlet-critical",
        "verlet-modes",
        "fire",
        "fire2",
        "augmented-lagrangian",
    ] {
        check(
            folder,
            &format!("solver-{solver}"),
            &format!("contact --n 32 --eps-f-inv 8 --eps-t-inv 1 --p-star 0.1 --tolerance 1e-6 --solver {solver}"),
        );
    }
    let all = "contact --n 24 --eps-f-inv 4 --height 0.4 --poisson 0.3 --p-star 0.05 --tolerance 1e-6 --components all";
    check(
        folder,
        "contact-all",
        &format!("{all} --solver verlet-critical --dt 0.5 --damping 1.5 --history --out a.h5"),
    );
    check(folder, "contact-held", "contact --n 32 --eps-f-inv 8 --poisson 0.3 --p-star 0.05 --components held");
    check(folder, "body", "body --surface c.h5 --levels 5 --deepest 0.2 --slice y=0.5 --out b.h5");
}

#[test]
fn laws() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let morse = "contact --n 32 --eps-f-inv 8 --eps-t-inv 1 --law morse --param gamma=1e-4,range=0.01 --p-star 0.05 \
                 --tolerance 1e-6";
    check(
        folder,
        "contact-exponential",
        "contact --n 64 --law exponential --param gamma=1e-5 --param range=4e-4 --p-star 0.02,0.01,0 --out e.h5",
    );
    check(folder, "contact-morse", &format!("{morse} --solver fire"));
    check(folder, "contact-morse-fire2", &format!("{morse} --solver fire2"));
    check(
        folder,
        "path-adhesive",
        "path --n 64 --law exponential --param gamma=1e-5,range=1e-3 --approach=-0.002,0.006,-0.004 --steps 4 \
         --out p.h5",
    );
    check(
        folder,
        "path-friction",
        "path --n 32 --p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.002 --steps 3 --out f.h5",
    );
    check(
        folder,
        "path-mixed-mode",
        "path --n 64 --dim 2 --law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002 --approach 0.002 \
         --lateral 0,0.01 --steps 3",
    );
    check(
        folder,
        "law",
        "law --law bsg --param phi_n=1,phi_t=2,delta_n=0.1,delta_t=0.2 --normal=-0.1,0,0.1,0.8 \
         --tangential 0,0.1,0.2,0.3",
    );
}

/// Each part of a problem once, with its measurements.
#[test]
fn parts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rough = "--n 32 --eps-f-inv 8";
    let law = "--law exponential --param gamma=1e-5,range=1e-3";
    check(folder, "surface-base", &format!("surface {rough} --seed 9 --rms-height 1e-4 --out base.npy"));
    for (case, flags) in [
        ("hardness", "--hardness 0.08 --p-star 0.02,0.3 --statistics"),
        ("free", "--boundary free --p-star 0.02,0.1 --statistics --flow"),
        ("free-law", &format!("--boundary free {law} --p-star 0.02 --statistics")),
        ("finite-slope", "--finite-slope --p-star 0.05 --statistics"),
        ("squeezed", "--height 0.2 --poisson 0.3 --lower-seed 2 --p-star 0.02,0.1"),
        ("squeezed-hardness", "--height 0.2 --poisson 0.3 --lower-seed 2 --hardness 0.08 --p-star 0.02,0.3"),
        ("squeezed-held", "--height 0.2 --poisson 0.3 --lower-seed 2 --components held --p-star 0.02,0.1"),
        ("squeezed-law", &format!("--height 0.2 --poisson 0.3 --lower-seed 2 {law} --p-star 0.02,0.1")),
        ("measured", "--p-star 0.02,0.1 --statistics --flow --flow-threshold"),
        ("moved-base", "--height 0.2 --base-displacement base.npy --p-star 0.05"),
        ("layers", "--height 0.1 --layer 2,0.3,0.2 --base half-space --base-young 5 --base-poisson 0.2 --p-star 0.05"),
        ("second-body", "--second-body 2,0.3 --p-star 0.05"),
        ("conductor", "--height 0.2 --p-star 0.05 --statistics --conductor-height 0.3"),
    ] {
        check(folder, &format!("contact-{case}"), &format!("contact {rough} {flags} --out {case}.h5"));
    }
    for (case, flags) in [
        ("wall", "--p-star 0.01,0.1 --steps 3"),
        ("plastic", "--hardness 0.1 --p-star 0.01,0.3,0.01 --steps 3"),
        ("free", "--boundary free --p-star 0.01,0.1 --steps 2"),
        ("free-law", &format!("--boundary free {law} --p-star 0.01,0.02 --steps 2")),
        (
            "squeezed",
            &format!("--height 0.2 --poisson 0.3 --lower-seed 2 {law} --hardness 0.1 --p-star 0.05,0.3,0.05 --steps 2"),
        ),
        (
            "squeezed-histories",
            "--height 0.2 --lower-seed 2 --prony 0.1:0.3,10:0.4 --coefficient 0.2 --p-star 0.05,0.1,0.1 --time 0,1,9 \
             --distance 0,0,0.4 --steps 2",
        ),
        ("free-friction", "--boundary free --friction 0.3 --p-star 0.05 --lateral 0,0.001 --steps 2"),
        (
            "free-shear",
            "--boundary free --law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.01,delta_t=0.01 --p-star 0.02 \
             --lateral 0,0.004,-0.004 --steps 2",
        ),
    ] {
        check(folder, &format!("path-{case}"), &format!("path {rough} {flags} --out path-{case}.h5"));
    }
}

/// Contacts with a memory, tabulated bodies and laws, and theories without a solution.
#[test]
fn histories_tables_and_theories() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let rough = "--n 32 --eps-f-inv 8";
    let prony = "--prony 0.1:0.3,10:0.4";
    let law = "--law exponential --param gamma=1e-4,range=4e-3";
    for (case, flags) in [
        ("path-relaxing", format!("path {rough} {prony} --p-star 0.05,0.02 --time 1,2 --steps 2 --out r.h5")),
        (
            "path-relaxing-shear",
            format!(
                "path {rough} {prony} --relaxes shear --poisson 0.3 --height 0.3 --p-star 0.05,0.02 --time 1,2 \
                 --steps 2 --out s.h5"
            ),
        ),
        (
            "path-yielding",
            format!("path {rough} --poisson 0.3 --yield-stress 0.01 --p-star 0.02,0.06,0.01 --steps 2 --out y.h5"),
        ),
        ("path-relaxing-law", format!("path {rough} {prony} {law} --approach 0.005,-0.005 --time 1,0 --out l.h5")),
        ("slide", format!("slide {rough} {prony} --p-star 0.05 --velocity 0.1,1 --out v.h5")),
        (
            "slide-heat",
            format!(
                "slide {rough} --poisson 0.5 --e-star 1 --p-star 0.05 --velocity 1 --heat 1,0.01 --friction 0.3 \
                 --out h.h5"
            ),
        ),
        ("wear", format!("wear {rough} --p-star 0.05 --coefficient 1 --distance 0,0.01 --steps 2 --flow --out w.h5")),
        (
            "contact-law-table",
            format!(
                "contact {rough} --law table --law-table 0:0.01,1e-3:0.008,2e-3:0.003,3e-3:0 --p-star 0.05 --out t.h5"
            ),
        ),
        (
            "contact-compliance",
            format!("contact {rough} --compliance 1:2,10:0.2,100:0.02,1000:0.002 --e-star 1 --p-star 0.05 --out c.h5"),
        ),
        ("theory", format!("theory {rough} --p-star 0.01,0.1")),
        ("estimate", format!("estimate {rough} --p-star 0.01,0.1 --hardness 0.1")),
        ("body-relaxing", "body --surface r.h5 --depths 0,0.1 --out b.h5".into()),
    ] {
        check(folder, case, &flags);
    }
}

#[test]
fn sweep_punch_and_elasticity() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    check(folder, "kappa-sweep", "kappa-sweep --config sweep.toml --out k.h5");
    check(folder, "punch", "punch --n 32 --nodes inclusive --refine 2 --out p.h5");
    check(
        folder,
        "punch-line",
        "punch --dim 2 --n 64 --contact frictionless --height inf --solver verlet --tolerance 1e-6",
    );
    check(folder, "green", "green --qx 3 --qy 4 --height 0.3 --poisson 0.45 --z 0.1");
    check(folder, "body-punch", "body --surface p.h5 --depths 0.1,0.3 --out b.h5");
}

/// One thread and three (in the long tests also two and eight) give the same bits, on grids large enough to be divided
/// among them.
#[test]
fn threads_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    for case in [
        "surface --n 512 --hurst 0.7 --out h.h5",
        "surface --n 256 --hurst 0.6 --method sra --out h.h5",
        "contact --n 256 --p-star 0.02,0.1 --out c.h5",
        "contact --n 192,250 --height 0.3 --poisson 0.4 --approach 0.01 --solver cg --out c.h5",
        "contact --n 50000 --dim 2 --eps-f-inv 512 --p-star 0.05 --out c.h5",
        "contact --n 128 --p-star 0.1 --tolerance 1e-4 --solver verlet --out c.h5",
        "contact --n 128 --p-star 0.1 --tolerance 1e-4 --solver augmented-lagrangian --out c.h5",
        "contact --n 96 --p-star 0.2 --tolerance 1e-3 --components all --solver verlet-modes --history --out c.h5",
        "contact --n 128 --p-star 0.1 --tolerance 1e-3 --solver verlet-modes --out c.h5",
        "contact --n 128 --law exponential --param gamma=1e-5,range=4e-4 --p-star 0.02 --out c.h5",
        "path --n 128 --law morse --param gamma=1e-4,range=0.01 --approach=-0.002,0.004 --steps 1 --tolerance 1e-6 \
         --out p.h5",
        "path --n 64 --p-star 0.05 --friction 0.3 --lateral 0,0.002 --steps 1 --tolerance 1e-6 --out f.h5",
        "punch --n 128 --out u.h5",
        "body --surface u.h5 --levels 3 --out b.h5",
        "kappa-sweep --config sweep.toml --out k.h5",
    ] {
        let bits = |threads: usize| {
            let numbers = said(folder, &format!("{case} --threads {threads}")).numbers;
            assert!(numbers.len() > 3, "{case}: hardly any numbers");
            let of = |numbers: Numbers| numbers.values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            numbers.into_iter().map(|(place, numbers)| (place, of(numbers))).collect::<BTreeMap<_, _>>()
        };
        let alone = bits(1);
        for &threads in if long() { &[2, 3, 8][..] } else { &[3] } {
            let found = bits(threads);
            let differs = alone.keys().chain(found.keys()).find(|place| alone.get(*place) != found.get(*place));
            assert_eq!(differs, None, "{threads} threads change: {case}");
        }
    }
}
