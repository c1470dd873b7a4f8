//! Numbers where two features meet: free boundaries and links, laws with a wall and patches, soft laws and flow, flow
//! and grid.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use gfmd_record::reason_for;
use serde_json::Value;

fn number(load: &Value, name: &str) -> f64 {
    load[name].as_f64().unwrap_or_else(|| panic!("{name} of {load}"))
}

/// Counts the pairs of neighbours with exactly one in contact: within the field, and across the seam.
fn links(touches: &[bool], [nx, ny]: [usize; 2]) -> [u64; 2] {
    let mut found = [0, 0];
    for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
        for (k, l, crosses) in [((i + 1) % nx, j, i + 1 == nx), (i, (j + 1) % ny, j + 1 == ny)] {
            found[usize::from(crosses)] += u64::from(touches[i * ny + j] != touches[k * ny + l]);
        }
    }
    found
}

/// Recounts the points and links of the only load of a file from a field, and compares them with all reported numbers.
/// Returns them.
fn recounted(folder: &Path, file: &str, load: &Value, field: &str, is_periodic: bool) -> (f64, f64) {
    let file = Reader::open(folder.join(file)).unwrap();
    let shape = file.shape(field).unwrap();
    let touches: Vec<bool> = file.values::<f64>(field).unwrap().iter().map(|p| *p > 0.0).collect();
    let points = touches.len() as f64;
    let nodes = touches.iter().filter(|touches| **touches).count() as f64;
    let [inside, seam] = links(&touches, [shape[1], shape[2]]);
    let links = (inside + if is_periodic { seam } else { 0 }) as f64;
    assert!(inside > 0 && seam > 0, "the contact must cross the seam: {nodes} of {points} points");
    let excess = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 * links / points;
    assert_eq!((number(load, "contact_nodes"), number(load, "boundary_links")), (nodes, links));
    approx::assert_relative_eq!(number(load, "area_fraction"), nodes / points, max_relative = 1e-14);
    approx::assert_relative_eq!(number(load, "area_fraction_corrected"), nodes / points - excess, max_relative = 1e-12);
    let sum = |path: &str| file.values::<f64>(path).unwrap().iter().sum::<f64>();
    approx::assert_relative_eq!(sum("/patches/area"), nodes / points, max_relative = 1e-12);
    approx::assert_relative_eq!(sum("/patches/perimeter"), links / shape[1] as f64, max_relative = 1e-12);
    let middles = file.values::<f64>("/distributions/pressure_at").unwrap();
    let area = sum("/distributions/pressure") * 2.0 * middles[0];
    approx::assert_relative_eq!(area, nodes / points, max_relative = 1e-9);
    (nodes, links)
}

#[test]
fn with_free_boundaries_no_link_and_no_perimeter_crosses_the_seam() {
    let folder = tempfile::tempdir().unwrap();
    for boundary in ["free", "periodic"] {
        let words = "contact --n 48 --seed 4 --p-star 0.3 --statistics --json --out c.h5 --boundary".split(' ');
        let report = json(folder.path(), &words.chain([boundary]).collect::<Vec<_>>());
        recounted(folder.path(), "c.h5", &report["loads"][0], "/fields/pressure", boundary == "periodic");
        assert!(gfmd(folder.path(), &["check", "c.h5"]).status.success());
        std::fs::remove_file(folder.path().join("c.h5")).unwrap();
    }
}

#[test]
fn under_a_law_with_a_wall_patches_and_distributions_are_of_the_points_repelled() {
    let folder = tempfile::tempdir().unwrap();
    for (law, has_wall) in [("exponential", true), ("dugdale", true), ("morse", false)] {
        let words = "contact --n 48 --seed 4 --p-star 0.2 --statistics --json --out c.h5 --param gamma=2e-4 --param \
                     range=2e-3 --law";
        let report = json(folder.path(), &words.split(' ').chain([law]).filter(|w| !w.is_empty()).collect::<Vec<_>>());
        let load = &report["loads"][0];
        let (nodes, _) = recounted(folder.path(), "c.h5", load, "/fields/repulsion", true);
        let file = Reader::open(folder.path().join("c.h5")).unwrap();
        let net = file.values::<f64>("/fields/pressure").unwrap().iter().filter(|p| **p > 0.0).count() as f64;
        assert_eq!(has_wall, net < 0.9 * nodes, "{law}: {net} of {nodes}");
        let check = gfmd(folder.path(), &["check", "c.h5"]);
        assert!(check.status.success(), "{law}: {}", String::from_utf8_lossy(&check.stdout));
        std::fs::remove_file(folder.path().join("c.h5")).unwrap();
    }
}

#[test]
fn a_flow_between_surfaces_that_overlap_has_no_conductivity_and_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    for law in ["npb", "npc"] {
        let words = "contact --n 32 --p-star 3 --flow --json --out c.h5 --param phi_n=1e-4 --param phi_t=1e-4 --param \
                     delta_n=1e-2 --param delta_t=1e-2 --law";
        let report = json(folder.path(), &words.split(' ').chain([law]).filter(|w| !w.is_empty()).collect::<Vec<_>>());
        let load = &report["loads"][0];
        assert!(number(load, "mean_gap") < 0.0, "{load}");
        assert!(load["flow"]["conductivity"][0][0].is_null());
        assert!(reason_for(load, "flow_xx").is_some_and(|reason| reason.contains("overlap")), "{load}");
        assert!(load["flow"]["percolates"][0].is_boolean());
        let file = Reader::open(folder.path().join("c.h5")).unwrap();
        assert!(file.values::<f64>("/loads/flow_xx").unwrap()[0].is_nan());
        assert!(file.text("/loads/flow_xx", "undefined").unwrap().contains("overlap"));
        assert!(gfmd(folder.path(), &["check", "c.h5"]).status.success());
        std::fs::remove_file(folder.path().join("c.h5")).unwrap();
    }
}

#[test]
fn the_error_of_the_grid_of_a_flow_contains_the_flow_on_a_grid_eight_times_finer() {
    let folder = tempfile::tempdir().unwrap();
    let flow = |n: &str, seed: &str, hurst: &str| {
        let words = ["contact", "--n", n, "--seed", seed, "--hurst", hurst, "--eps-f-inv", "4", "--eps-t-inv", "2"];
        let report = json(folder.path(), &[&words[..], &["--p-star", "0.02,0.05", "--flow", "--json"]].concat());
        report["loads"].as_array().unwrap().iter().map(|load| load["flow"].clone()).collect::<Vec<_>>()
    };
    let (mut covered, mut all, mut largest) = (0, 0, 0.0_f64);
    for (seed, hurst) in [("101", "0.8"), ("102", "0.3"), ("103", "0"), ("104", "0.8"), ("105", "0.5")] {
        // 4 and 32 points on the shortest wave.
        for (coarse, fine) in flow("32", seed, hurst).iter().zip(flow("256", seed, hurst)) {
            for axis in [0, 1] {
                let of = |flow: &Value, name: &str| flow[name][axis][axis].as_f64();
                let truth = of(&fine, "conductivity").unwrap();
                let Some(limit) = of(coarse, "conductivity_limit") else { continue };
                let (found, error) =
                    (of(coarse, "conductivity").unwrap(), of(coarse, "conductivity_limit_error").unwrap());
                let bound = of(coarse, "conductivity_grid_error").unwrap();
                approx::assert_relative_eq!(bound, (found - limit).abs() + error, max_relative = 1e-12);
                assert!(coarse["conductivity"][axis][1 - axis].is_number() && (found - truth).abs() <= bound);
                largest = largest.max((found / truth - 1.0).abs());
                covered += u32::from((truth - limit).abs() <= error);
                all += 1;
            }
        }
    }
    assert!(all >= 16 && f64::from(covered) >= 0.85 * f64::from(all), "{covered} of {all}");
    assert!(largest > 0.03, "the grid matters: {largest}");
}

#[test]
fn a_path_with_a_hardness_goes_beyond_the_mean_clearance_as_a_contact_does() {
    let folder = tempfile::tempdir().unwrap();
    let surface = "--n 32 --rms-height 0.02 --json --approach";
    let words = |command: &'static str, approach: &'static str, more: &'static str| {
        let words = [command].into_iter().chain(surface.split(' ')).chain([approach]);
        words.chain(more.split_whitespace()).collect::<Vec<_>>()
    };
    // Without a hardness it is beyond full contact.
    let refused = gfmd(folder.path(), &words("path", "0.1", ""));
    let reported = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && reported.contains("less than the mean clearance"), "{reported}");
    let contact = &json(folder.path(), &words("contact", "0.1", "--hardness 0.05"))["loads"][0];
    let path = json(folder.path(), &words("path", "0.06,0.1", "--hardness 0.05 --steps 1 --out p.h5"));
    let steps = path["steps"].as_array().unwrap();
    // Nearly all of the surface carries the hardness; the previous step began the plastic depth.
    let [mean, first, last] = [contact, &steps[0], &steps[1]].map(|state| number(state, "mean_pressure"));
    assert!(mean > 0.95 * 0.05 && first < 0.8 * mean);
    approx::assert_relative_eq!(last, mean, max_relative = 1e-3);
    assert!(number(&steps[1], "dissipated") > 0.5 * 0.04 * mean);
    assert_eq!(json(folder.path(), &["check", "p.h5", "--rerun", "--json"])["differing"], 0);
    // After this pressing, both surfaces match: they part when the approach is reduced, and touch again at their
    // plastic depth.
    let path = json(folder.path(), &words("path", "0.1,0.05,0.02,0.1", "--hardness 0.05 --steps 1 --out apart.h5"));
    let steps = path["steps"].as_array().unwrap();
    for (step, approach) in [(&steps[1], 0.05), (&steps[2], 0.02)] {
        assert!(step["converged"] == true && number(step, "mean_pressure") == 0.0, "{step}");
        assert_eq!((number(step, "approach"), number(step, "dissipated")), (approach, 0.0));
    }
    // Apart, the surface is not displaced: the gap opens by the reduction of the approach.
    let opened = number(&steps[2], "mean_gap") - number(&steps[1], "mean_gap");
    approx::assert_relative_eq!(opened, 0.03, max_relative = 1e-9);
    let [first, last] = [0, 3].map(|step| number(&steps[step], "mean_pressure"));
    approx::assert_relative_eq!(first, last, max_relative = 1e-3);
    assert_eq!(json(folder.path(), &["check", "apart.h5", "--rerun", "--json"])["differing"], 0);
}
