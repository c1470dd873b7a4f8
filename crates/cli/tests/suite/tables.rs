//! Printed tables fit in 80 characters; `--wide` prints all their columns.

use std::collections::BTreeSet;

use super::common::{STUDY, gfmd};

/// Largest number of characters in a line of a table.
const WIDTH: usize = 80;

/// Numbers with units.
const UNITS: &str = "--n 32 --eps-f-inv 4 --unit um --size 100um --young 70GPa --poisson 0.33 -q";

/// Command lines, each with one of its columns that a narrow table leaves out.
const LINES: [(&str, &str); 12] = [
    ("contact --n 32 --p-star 0.05,0.1 -q", "residual"),
    (
        "contact UNITS --pressure 1MPa,100MPa --statistics --flow --conductivity 10W/(m*K),20W/(m*K) --gas air \
      --viscosity 1mPa*s --pressure-drop 1bar",
        "flow xy",
    ),
    ("contact --n 32 --eps-f-inv 4 --law exponential --param gamma=1e-5,range=1e-3 --p-star 0.02,0.01 -q", "pairs"),
    ("contact --n 64 --shape sphere:R=10mm --size 0.4mm --young 70GPa --boundary free --force 1N -q", "steps"),
    ("contact --n 32 --eps-f-inv 4 --height 0.3 --lower-seed 2 --p-star 0.05 -q", "residual"),
    ("path UNITS --pressure 1MPa,10MPa --steps 2 --friction 0.3 --lateral 0.1um,0um", "dissipated"),
    (
        "path --n 32 --eps-f-inv 4 --law exponential --param gamma=1e-4,range=3e-3 --approach=-0.003,0.01 --steps 6 -q",
        "elastic",
    ),
    ("wear UNITS --pressure 10MPa --coefficient 1e-4/MPa --distance 0um,1um,10um --steps 1 --flow", "deepest"),
    ("slide UNITS --prony 1us:0.5 --pressure 10MPa --velocity 1m/s,10m/s", "pairs"),
    ("estimate --n 64 --unit um --size 100um --young 70GPa --poisson 0.33 --pressure 1MPa:100MPa:3 -q", "rms pressure"),
    ("theory --n 64 --unit um --size 100um --young 70GPa --pressure 1MPa,10MPa -q", "counted"),
    ("study study.toml -q", "kappa"),
];

/// Returns the tables of a printed report, line by line: reports begin no other lines with a blank.
fn tables(text: &str) -> Vec<Vec<String>> {
    let blocks = text.lines().map(str::to_owned).collect::<Vec<_>>();
    let blocks = blocks.chunk_by(|a, b| a.starts_with(' ') == b.starts_with(' '));
    blocks.filter(|block| block[0].starts_with(' ')).map(<[String]>::to_vec).collect()
}

/// Returns the columns that each table leaves out, from lines of at most 80 characters.
fn footnotes(text: &str) -> Vec<String> {
    let block = |after: &str| after.split_once("all)").unwrap().0.to_owned();
    let blocks: Vec<String> = text.split("left out: ").skip(1).map(block).collect();
    assert!(blocks.iter().flat_map(|block| block.lines()).all(|line| line.chars().count() <= WIDTH), "{text}");
    let columns = |block: String| block.replace('\n', " ").split_once(" (--wide shows ").unwrap().0.to_owned();
    blocks.into_iter().map(columns).collect()
}

/// Returns the words of a line of heads, without units.
fn heads(line: &str) -> BTreeSet<String> {
    let words = line.split("  ").map(str::trim).filter(|word| !word.is_empty());
    words.map(|word| word.split(" / ").next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn tables_fit_in_80_characters_and_wide_ones_have_the_columns_left_out() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    for (line, left_out) in LINES {
        let line = line.replace("UNITS", UNITS);
        let words: Vec<&str> = line.split_whitespace().collect();
        let printed = |more: &[&str]| {
            let output = gfmd(folder.path(), &[&words, more].concat());
            assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8(output.stdout).unwrap()
        };
        let again: &[&str] = if line.starts_with("study") { &["--resume", "--wide"] } else { &["--wide"] };
        let (usual, wide) = (printed(&[]), printed(again));
        for row in usual.lines() {
            assert!(row.chars().count() <= WIDTH, "{line}: {row}");
        }
        let footnotes = footnotes(&usual);
        assert!(footnotes.iter().any(|columns| columns.contains(left_out)), "{usual}");
        assert!(!wide.contains("(--wide shows all)"), "{wide}");
        assert!(tables(&wide).concat().iter().any(|row| row.chars().count() > WIDTH), "{line}: {wide}");
        let mut footnotes = footnotes.iter();
        let (narrow, wide) = (tables(&usual), tables(&wide));
        assert_eq!(narrow.len(), wide.len(), "{usual}");
        for (narrow, wide) in narrow.iter().zip(&wide) {
            assert_eq!(narrow.len(), wide.len());
            let (mut found, all) = (heads(&narrow[0]), heads(&wide[0]));
            if found != all {
                found.extend(footnotes.next().unwrap().split(", ").map(str::to_owned));
            }
            assert_eq!(found, all, "{line}");
        }
    }
}

#[test]
fn notes_below_a_table_fit_in_80_characters() {
    let folder = tempfile::tempdir().unwrap();
    let measured = LINES[1].0.replace("UNITS", UNITS);
    let lines = [
        (&*measured, "gas conductance: per area"),
        ("contact --n 32 --eps-f-inv 4 --p-star 0.05,5 --statistics -q", "no "),
        ("slide UNITS --prony 1us:0.5 --pressure 10MPa --velocity 1m/s,10m/s", "two digits and ~:"),
        ("estimate --n 64 --p-star 0.01,2 -q", "±: 95 %"),
        ("theory --n 64 --p-star 0.01,5 -q", "formula: area fraction fitted"),
    ];
    for (line, start) in lines {
        let line = line.replace("UNITS", UNITS);
        let printed = |more: &[&str]| {
            let words: Vec<&str> = line.split_whitespace().chain(more.iter().copied()).collect();
            String::from_utf8(gfmd(folder.path(), &words).stdout).unwrap()
        };
        let (usual, wide) = (printed(&[]), printed(&["--wide"]));
        let note = wide.lines().find(|line| line.starts_with(start) && line.chars().count() > WIDTH);
        let note = note.unwrap_or_else(|| panic!("{line}: {wide}"));
        let lines: Vec<&str> = usual.lines().collect();
        let pieces = (0..lines.len()).find_map(|first| {
            (first + 2..=lines.len()).map(|end| &lines[first..end]).find(|pieces| pieces.join(" ") == note)
        });
        let pieces = pieces.unwrap_or_else(|| panic!("{line}: {usual}"));
        assert!(pieces.iter().all(|piece| piece.chars().count() <= WIDTH), "{usual}");
    }
}

#[test]
fn the_numbers_of_a_surface_fit_in_80_characters() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["surface --n 32 -q", "surface --n 32 --unit um --size 100um -q"] {
        let text = |more: &[&str]| {
            let words: Vec<&str> = line.split_whitespace().chain(more.iter().copied()).collect();
            String::from_utf8(gfmd(folder.path(), &words).stdout).unwrap()
        };
        let (usual, wide) = (text(&[]), text(&["--wide"]));
        assert!(usual.lines().all(|line| line.chars().count() <= WIDTH), "{usual}");
        assert!(wide.lines().any(|line| line.chars().count() > WIDTH));
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&usual), words(&wide));
    }
}

#[test]
fn a_table_explains_digits_in_brackets_once() {
    let folder = tempfile::tempdir().unwrap();
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let printed = |line: &str| {
        let words = words(line);
        let output = gfmd(folder.path(), &words.iter().map(String::as_str).collect::<Vec<_>>());
        String::from_utf8(output.stdout).unwrap()
    };
    for line in ["contact --n 64 --p-star 0.05,0.1 --statistics -q", "path --n 64 --p-star 0.05,0.1 --steps 1 -q"] {
        let text = printed(line);
        let tables = tables(&text).concat().concat();
        for (sign, legend) in [("(", "digits in brackets:"), ("~", "two digits and ~:")] {
            let expected = usize::from(tables.contains(sign));
            assert_eq!(text.matches(legend).count(), expected, "{text}");
        }
        assert!(tables.contains('('), "{text}");
    }
}
