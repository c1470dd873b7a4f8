//! The line under "To repeat it" of a page, pasted into a shell, makes the result again.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use crate::common::{SWEEP, gfmd, numbers};

fn run(folder: &Path, words: &str) {
    let output = gfmd(folder, &words.split_whitespace().collect::<Vec<_>>());
    assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the text of a page between two marks, as a browser copies it.
fn copied(page: &str, from: &str, to: &str) -> String {
    let (_, rest) = page.split_once(from).unwrap_or_else(|| panic!("{from} is on no page"));
    let (found, _) = rest.split_once(to).unwrap();
    let bare: String = found.split('<').map(|part| part.split_once('>').map_or(part, |(_, text)| text)).collect();
    bare.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
}

/// Runs the line of the page about a result, which writes `again.h5`, and compares all numbers of both. Returns the
/// difference, if any.
fn paste(folder: &Path, name: &str) -> Option<String> {
    run(folder, &format!("report {name}.h5 -q"));
    let page = std::fs::read_to_string(folder.join(format!("{name}.html"))).unwrap();
    if page.contains("as <code>sweep.toml</code>") {
        let config = copied(page.split_once("<h3>Configuration</h3>").unwrap().1, "<code>", "</code>");
        std::fs::write(folder.join("sweep.toml"), config).unwrap();
    }
    let repeat = page.split_once("id=\"repeat-h\"").unwrap().1;
    let line = copied(repeat, "<pre tabindex=\"0\"><code>", "</code>");
    let program = line.strip_prefix("gfmd ").unwrap_or_else(|| panic!("{name}: {line}"));
    let program = format!("'{}' {program} -q", env!("CARGO_BIN_EXE_gfmd"));
    let output = Command::new("sh").args(["-c", &program]).current_dir(folder).output().unwrap();
    if !output.status.success() {
        return Some(format!("{name}: {line}\n{}", String::from_utf8_lossy(&output.stderr)));
    }
    let (first, second) = (numbers(&folder.join(format!("{name}.h5"))), numbers(&folder.join("again.h5")));
    let all = first.keys().chain(second.keys()).collect::<BTreeSet<_>>();
    let differing = all.into_iter().filter(|path| first.get(*path) != second.get(*path)).collect::<Vec<_>>();
    std::fs::remove_file(folder.join("again.h5")).unwrap();
    (!differing.is_empty()).then(|| format!("{name}: {line}\n{differing:?}"))
}

/// Writes heights of 16 x 16 points, of some 10 nm in m.
pub(crate) fn write_scan(path: &Path) {
    let height = |i: usize, j: usize| {
        let wave = |m: usize, n: usize, phase: f64| {
            let (m, n) = ((m * i) as f64 / 16.0, (n * j) as f64 / 16.0);
            (std::f64::consts::TAU * (m + n) + phase).cos()
        };
        1e-8 * (wave(1, 2, 0.3) + wave(3, 1, 1.0) / 4.0 + wave(2, 4, 2.0) / 8.0)
    };
    let rows = (0..16).map(|i| (0..16).map(|j| format!("{:e}", height(i, j))).collect::<Vec<_>>().join(" "));
    std::fs::write(path, rows.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
fn the_line_of_every_page_makes_the_result_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scan(&folder.join("scan.txt"));
    std::fs::copy(folder.join("scan.txt"), folder.join("a scan's.txt")).unwrap();
    ndarray_npy::write_npy(folder.join("h.npy"), &ndarray::Array2::from_elem((16, 16), 0.2)).unwrap();
    let mask = ndarray::Array2::from_shape_fn((16, 16), |(i, j)| f64::from(i < 5 && j < 7));
    ndarray_npy::write_npy(folder.join("mask.npy"), &mask).unwrap();
    std::fs::write(folder.join("green.txt"), "1 2.0\n10 0.2\n100 0.02\n1000 0.002\n").unwrap();
    std::fs::write(folder.join("law.txt"), "gap traction\n0 0.01\n1e-3 0.005\n2e-3 0.001\n3e-3 0\n").unwrap();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    let scan = "--surface scan.txt --unit m --size 1um";
    let young = "--young 10MPa --poisson 0.4";
    let mut wrong = Vec::new();
    for (name, words) in [
        ("contact", "contact --n 16 --eps-f-inv 4 --p-star 0.05,0.1 --statistics --flow"),
        ("height", "contact --n 16 --eps-f-inv 4 --rms-height 0.01 --p-star 0.05"),
        ("cells", "contact --eps-c-inv 4 --eps-f-inv 4 --p-star 0.05"),
        ("oblong", "contact --n 16,32 --size 1,2 --eps-f-inv 4 --approach 0.001:0.01:3 --e-star 2"),
        ("off", "contact --n 16 --eps-t-inv 4 --eps-f-inv 2 --roll-off 0.2 --roll-off-shape smooth --p-star 0.05"),
        ("subdivided", "contact --n 17 --method rmd --p-star 0.05"),
        ("strip", "contact --n 64 --dim 2 --eps-f-inv 4 --p-star 0.05 --components all"),
        ("scan", &format!("contact {scan} {young} --pressure 10kPa,20kPa --detrend plane --flip")),
        ("stress", &format!("contact {scan} {young} --stress-unit MPa --pressure 20kPa")),
        ("free", &format!("contact {scan} --e-star 10MPa --pressure 10kPa --boundary free")),
        ("refined", &format!("contact {scan} {young} --pressure 10kPa --refine 2 --periodise mirror")),
        ("two", &format!("contact {scan} {young} --second-surface scan.txt --shift=1nm,-2nm --pressure 10kPa")),
        ("hard", "contact --n 16 --eps-f-inv 4 --hardness 0.2 --p-star 0.05,0.5"),
        ("harder", "contact --n 16 --eps-f-inv 4 --hardness h.npy --p-star 0.05,0.5"),
        ("steep", "contact --n 16 --eps-f-inv 2 --finite-slope --p-star 0.05"),
        ("law", "contact --n 16 --eps-f-inv 4 --law exponential --param gamma=1e-5,range=1e-2 --p-star 0.05,-0.0001"),
        ("table", "contact --n 16 --eps-f-inv 4 --law table --law-table law.txt --p-star 0.05"),
        ("slabs", "contact --n 16 --eps-f-inv 4 --height 0.2 --layer 3,0.25,0.1 --layer 2,0,0.3 --p-star 0.05"),
        ("bodies", "contact --n 16 --eps-f-inv 4 --young 2 --second-body 1,0.3 --p-star 0.05"),
        ("squeezed", "contact --n 16 --eps-f-inv 4 --height 0.2 --lower-seed 2 --p-star 0.05"),
        (
            "green",
            "contact --n 16 --eps-f-inv 4 --compliance green.txt --uniform-compliance 0.5 --e-star 1 --p-star 0.05",
        ),
        ("accurate", "contact --n 24 --eps-f-inv 4 --eps-t-inv 1.5 --p-star 0.3 --accuracy 0.3"),
        ("dynamic", "contact --n 16 --eps-f-inv 4 --height 1 --solver verlet-critical --history --p-star 0.05"),
        ("path", "path --n 16 --eps-f-inv 4 --p-star 0.05,0.02 --steps 2"),
        ("friction", "path --n 16 --eps-f-inv 4 --p-star 0.05 --friction 0.3 --lateral 0,0.001 --steps 2"),
        ("shear", "path --n 16 --eps-f-inv 4 --p-star 0.05 --shear-strength 0.02 --lateral 0,-0.001 --steps 2"),
        ("plastic", "path --n 16 --eps-f-inv 4 --p-star 0.05,0.5,0.05 --hardness 0.2 --steps 2"),
        ("prony", "path --n 16 --eps-f-inv 4 --prony 0.1:0.3,10:0.4 --pressure 0.01 --time 0,1 --steps 2"),
        (
            "prony-2",
            "path --n 16 --eps-f-inv 4 --prony 0.1:0.3 --moduli instantaneous --p-star 0.01 --time 1 --steps 2",
        ),
        ("loop", "path --n 16 --eps-f-inv 4 --law morse --param gamma=1e-4,range=1e-2 --approach=-0.01,0.01 --steps 3"),
        ("slide", "slide --n 16 --eps-f-inv 4 --prony 0.1:0.5 --p-star 0.05 --velocity 1,10 --direction 30"),
        ("warm", "slide --n 16 --eps-f-inv 4 --heat 1,0.1,0.3,0.2 --friction 0.3 --p-star 0.05 --velocity 0.1,1"),
        ("rubber", &format!("slide {scan} {young} --prony 1ms:0.5 --pressure 10kPa --velocity 1mm/s")),
        ("wear", "wear --n 16 --eps-f-inv 4 --p-star 0.05 --coefficient 1 --distance 0,0.1 --steps 2"),
        ("worn", &format!("wear {scan} {young} --pressure 10kPa --coefficient 1e-12/Pa --distance 0,1um --steps 2")),
        ("punch", "punch --n 16"),
        ("strip-punch", "punch --n 16 --dim 2 --height inf --nodes inclusive --shift 0.001 --contact sticking"),
        ("refined-punch", "punch --n 16 --refine 2 --contact frictionless"),
        ("masked", "punch --mask mask.npy --height 1 --layer 3,0.3,1"),
        ("body", "body --surface contact.h5 --load 0 --levels 3 --deepest 0.1"),
        ("slice", "body --surface punch.h5 --depths 0,0.1 --slice y=0.5 --quantities stress,von-mises"),
        (
            "wave",
            "body --wave 1,1,z,0.005 --wave=-1,1,z,-0.005 --n 16 --young 1 --poisson 0.33 --height 1 --slice z=0.5",
        ),
        ("kappa", "kappa-sweep --config sweep.toml"),
    ] {
        run(folder, &format!("{words} --out {name}.h5 -q"));
        wrong.extend(paste(folder, name));
    }
    // A name that a shell would split.
    let output = gfmd(
        folder,
        &["contact", "--surface", "a scan's.txt", "--p-star", "0.05", "--size", "1e-6", "--out", "quoted.h5", "-q"],
    );
    assert!(output.status.success());
    wrong.extend(paste(folder, "quoted"));
    assert!(wrong.is_empty(), "{} lines fail:\n{}", wrong.len(), wrong.join("\n"));
}
