//! Conductance of a load from end to end, against dense solutions for the contact points in the file.

use std::f64::consts::TAU;
use std::path::Path;

use crate::common::{gfmd, json};
use approx::assert_relative_eq;
use gfmd_files::Reader;
use gfmd_record::reason_for;
use serde_json::Value;

const N: usize = 16;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &words(flags))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Returns the mean current density on a square of side 1 with potential 1 at all `touching` points, by Gaussian
/// elimination. `resistance` is the resistance between two points with these distances along x and y, in points.
fn dense(touching: &[bool], resistance: impl Fn(usize, usize) -> f64) -> f64 {
    let inside: Vec<usize> = (0..N * N).filter(|i| touching[*i]).collect();
    let between = |a: usize, b: usize| resistance((a / N).abs_diff(b / N), (a % N).abs_diff(b % N));
    let of_row = |&a: &usize| inside.iter().map(|b| between(a, *b)).chain([1.0]).collect();
    let mut rows: Vec<Vec<f64>> = inside.iter().map(of_row).collect();
    let m = inside.len();
    for k in 0..m {
        let pivot = (k..m).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        rows.swap(k, pivot);
        let pivot = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(&pivot).skip(k).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut current = vec![0.0; m];
    for k in (0..m).rev() {
        let known: f64 = (k + 1..m).map(|j| rows[k][j] * current[j]).sum();
        current[k] = (rows[k][m] - known) / rows[k][k];
    }
    current.iter().sum::<f64>() / (N * N) as f64
}

/// Returns the periodic resistance of conductors with this kernel, without the uniform mode, summed over all waves.
fn periodic(kernel: impl Fn(f64) -> f64) -> impl Fn(usize, usize) -> f64 {
    move |i, j| {
        let signed = |m: usize| if m > N / 2 { m as f64 - N as f64 } else { m as f64 };
        let waves = (1..N * N).map(|k| [signed(k / N), signed(k % N)]);
        let sum: f64 =
            waves.map(|[x, y]| kernel(TAU * x.hypot(y)) * (TAU * (x * i as f64 + y * j as f64) / N as f64).cos()).sum();
        sum / (N * N) as f64
    }
}

/// Returns the resistance of a half-space around a patch: ∫ dA/(2πr) over a square cell; each edge adds its distance
/// times ∫ ds/r.
fn unbounded(i: usize, j: usize) -> f64 {
    let edges = |k: usize| [(k as f64 - 0.5) / N as f64, (k as f64 + 0.5) / N as f64];
    let ([left, right], [below, above]) = (edges(i), edges(j));
    let edge = |d: f64, [from, to]: [f64; 2]| d * ((to / d.abs()).asinh() - (from / d.abs()).asinh());
    let [x, y] = [[left, right], [below, above]];
    (edge(right, y) - edge(left, y) + edge(above, x) - edge(below, x)) / TAU
}

#[test]
fn it_is_that_of_all_points_in_contact() {
    let folder = tempfile::tempdir().unwrap();
    let endless = |q: f64| 1.0 / q;
    let surface = format!(
        "contact --n {N} --eps-f-inv 4 --statistics --tolerance 1e-10 --stiffness-tolerance 1e-9 --json --out c.h5"
    );
    let law = "--law exponential --param gamma=1e-4,range=4e-3";
    type Kernel<'a> = Box<dyn Fn(usize, usize) -> f64 + 'a>;
    let electrode = |depth: f64| -> Kernel { Box::new(periodic(move |q| (q * depth).tanh() / q)) };
    let cases: [(String, Kernel); 9] = [
        ("--p-star 0.05,0.3".into(), Box::new(periodic(endless))),
        ("--hardness 0.05 --p-star 0.05,0.3".into(), Box::new(periodic(endless))),
        ("--height 0.05 --poisson 0.3 --p-star 0.02,0.3".into(), Box::new(periodic(endless))),
        ("--height 0.05 --poisson 0.3 --p-star 0.02 --conductor-height 0.05".into(), electrode(0.05)),
        ("--components held --p-star 0.1 --conductor-height 0.3".into(), electrode(0.3)),
        (format!("{law} --p-star 0.05,0.2"), Box::new(periodic(endless))),
        ("--law morse --param gamma=1e-4,range=1e-2 --p-star 0.2".into(), Box::new(periodic(endless))),
        ("--boundary free --hardness 0.05 --p-star 0.05,0.3".into(), Box::new(unbounded)),
        (format!("--boundary free {law} --p-star 0.1"), Box::new(unbounded)),
    ];
    for (flags, resistance) in &cases {
        let report = run(folder.path(), &format!("{surface} {flags}"));
        let file = Reader::open(folder.path().join("c.h5")).unwrap();
        let column: Vec<f64> = file.values("/loads/conductance").unwrap();
        for (load, record) in report["loads"].as_array().unwrap().iter().enumerate() {
            let [pressure, gap] =
                ["pressure", "gap"].map(|name| file.slab::<f64>(&format!("/fields/{name}"), load).unwrap());
            // At the wall of the exponential law the largest attraction is γ/ϱ.
            let is_repelled = |i: usize| match flags.contains("exponential") {
                true => gap[i] <= 0.0 && pressure[i] + 1e-4 / 4e-3 > 0.0,
                false => pressure[i] > 0.0,
            };
            let touching: Vec<bool> = (0..N * N).map(is_repelled).collect();
            let count = touching.iter().filter(|touches| **touches).count();
            assert_eq!(count as u64, record["contact_nodes"].as_u64().unwrap(), "{flags}");
            let found = number(&record["conductance"]);
            assert_relative_eq!(found, dense(&touching, resistance), max_relative = 1e-9);
            assert_eq!(found.to_bits(), column[load].to_bits());
        }
        drop(file);
        assert_eq!(run(folder.path(), "check c.h5 --json")["differing"], 0, "{flags}");
    }
    // The last file again from its flags, since the depth of the electrodes is one of them.
    run(folder.path(), &format!("{surface} {}", cases[3].0));
    assert_eq!(run(folder.path(), "check c.h5 --rerun --json")["differing"], 0);
}

#[test]
fn a_conductance_that_does_not_exist_has_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, reason) in [
        ("--n 16 --eps-f-inv 4 --p-star 0.01,5", "all points touch"),
        ("--n 16 --eps-f-inv 4 --p-star 0.01,5 --conductor-height 0.2", "all points touch"),
        ("--n 16 --eps-f-inv 4 --p-star 0.1 --finite-slope", "moved sideways"),
        ("--dim 2 --n 32 --boundary free --p-star 0.1", "known up to a constant"),
    ] {
        let report = run(folder.path(), &format!("contact --statistics --json --out c.h5 {flags}"));
        let record = report["loads"].as_array().unwrap().last().unwrap();
        assert!(record["conductance"].is_null(), "{flags}");
        assert!(reason_for(record, "conductance").unwrap().contains(reason), "{record}");
        let file = Reader::open(folder.path().join("c.h5")).unwrap();
        let last = *file.values::<f64>("/loads/conductance").unwrap().last().unwrap();
        assert!(last.is_nan(), "{flags}: {last}");
        assert!(file.text("/loads/conductance", "undefined").unwrap().contains(reason));
        assert_eq!(run(folder.path(), "check c.h5 --json")["differing"], 0, "{flags}");
    }
    // An electrode gives the profile a level.
    let line = "contact --statistics --json --dim 2 --n 32 --boundary free --p-star 0.1 --conductor-height 0.2";
    let record = &run(folder.path(), line)["loads"][0];
    assert!(number(&record["conductance"]) > 0.0 && reason_for(record, "conductance").is_none());
}

#[test]
fn electrodes_that_cannot_be_had_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, wanted) in [
        ("--conductor-height 0.1", "is 0.1; it must be left out without --statistics"),
        ("--statistics --conductor-height -1", "is -1; it must be positive and finite"),
        ("--statistics --conductor-height nan", "is NaN; it must be positive and finite"),
        ("--statistics --conductor-height 1e-4 --boundary free", "it must be at least"),
    ] {
        let output = gfmd(folder.path(), &words(&format!("contact --n 16 --eps-f-inv 4 --p-star 0.1 {flags}")));
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("--conductor-height") && message.contains(wanted), "{message}");
    }
}
