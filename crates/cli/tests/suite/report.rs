//! `report`: pages of results, of hostile strings, of files without fields, of damaged files.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::{SWEEP, gfmd, json};
use crate::repeat::write_scan;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable};
use gfmd_record::{reason_for, with_limit};

fn make(folder: &Path, words: &str) -> Option<i32> {
    gfmd(folder, &words.split_whitespace().collect::<Vec<_>>()).status.code()
}

fn page(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Returns the values of an attribute, in the order of the page.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    page.split(&start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// Panics unless the tags are balanced, the ids differ, no script is there and nothing is fetched.
fn check_page(page: &str) {
    assert!(page.starts_with("<!DOCTYPE html><html lang=\"en\">") && page.ends_with("</html>"));
    let lower = page.to_lowercase();
    assert!(!lower.contains("<script"));
    assert!(!lower.contains("javascript:"));
    assert!(!lower.contains("@import"));
    for source in values(page, "src").into_iter().chain(values(page, "href")) {
        assert!(source.starts_with('#') || source.starts_with("data:image/png;base64,"), "{source}");
    }
    let addresses = lower.matches("http").count();
    let allowed = lower.matches("http://www.w3.org/2000/svg").count() + lower.matches("http-equiv").count();
    assert_eq!(addresses, allowed, "no address is named but that of the format SVG");
    let ids = values(page, "id");
    assert_eq!(ids.len(), ids.iter().collect::<BTreeSet<_>>().len(), "{ids:?}");
    for link in values(page, "href").iter().filter_map(|link| link.strip_prefix('#')) {
        assert!(ids.contains(&link), "{link}");
    }
    let (_, body) = page.split_once("<body>").unwrap();
    let mut open = vec!["html", "body"];
    for tag in body.split('<').skip(1) {
        let tag = tag.split('>').next().unwrap();
        let name = tag.split([' ', '\n']).next().unwrap();
        match name.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop(), Some(closed), "{tag}"),
            None if name == "br" || tag.ends_with('/') => {}
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// Returns the sections and the number of figures and tables: the outline that readers and programs may rely on.
fn outline(page: &str) -> (Vec<&str>, usize, usize) {
    let sections = page.split("<section id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    (sections, page.matches("<figure>").count(), page.matches("<table>").count())
}

#[test]
fn pages_of_all_kinds_have_their_outline_and_the_numbers_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("sweep.toml"), SWEEP).unwrap();
    let all = ["answer", "asked", "figures", "numbers", "certificates", "cost", "repeat", "cite"];

    let contact = json(
        folder,
        &["contact", "--n", "48", "--eps-f-inv", "4", "--p-star", "0.05,0.1", "--out", "c.h5", "--json", "-q"],
    );
    let report = json(folder, &["report", "c.h5", "--json", "-q"]);
    assert_eq!((report["kind"].as_str(), report["figures"].as_u64()), (Some("contact"), Some(5)));
    let made = page(folder, "c.html");
    check_page(&made);
    assert_eq!(outline(&made), (all.to_vec(), 5, 3));
    // It leads with the area on an infinitely fine grid and states the area on this grid.
    let area = |end: &str| 100.0 * contact["loads"][1][format!("area_fraction{end}")].as_f64().unwrap();
    let led = with_limit(area(""), area("_limit"), area("_limit_error"));
    assert!(led.contains('(') && made.contains(&format!("<p class=\"headline\">{led} %")), "{led}");
    assert!(made.contains(&format!("On this grid {:.3} % of the points", area(""))), "{}", area(""));
    assert!(made.contains("Every residual is within its bound") && made.contains("gfmd check c.h5 --rerun"));
    assert!(made.contains("--p-star=0.05,0.1") && made.contains("The checksum of the content holds"));

    let words = "path --n 24 --eps-f-inv 6 --p-star 0.05 --friction 0.3 --lateral 0,0.001 --steps 3 --out p.h5 -q";
    assert_eq!(make(folder, words), Some(0));
    assert_eq!(make(folder, "report p.h5 --out path.html -q"), Some(0));
    let made = page(folder, "path.html");
    check_page(&made);
    assert_eq!(outline(&made), (all.to_vec(), 6, 3));
    assert!(made.contains("Section along"));

    let sweep = json(folder, &["kappa-sweep", "--config", "sweep.toml", "--out", "s.h5", "--json", "-q"]);
    assert_eq!(make(folder, "report s.h5 -q"), Some(0));
    let made = page(folder, "s.html");
    check_page(&made);
    let (sections, figures, tables) = outline(&made);
    assert_eq!((figures, tables), (6, 3));
    assert!(all.iter().all(|section| sections.contains(section)), "{sections:?}");
    let kappa = sweep["fit"]["kappa_tfc"].as_f64().unwrap();
    assert!(made.contains(&format!("<sub>TFC</sub> = {kappa:.4}")), "{kappa}");
    // The page depends on the file only.
    assert_eq!(make(folder, "report s.h5 --out again.html -q --threads 1"), Some(0));
    assert_eq!(page(folder, "again.html"), made);
}

/// Writes a file with one load and no fields, with `text` in its texts.
fn write_bare(path: &Path, text: &str) {
    let output = Output::claim(path).unwrap();
    let provenance = Provenance {
        program: text.into(),
        version: text.into(),
        git_commit: text.into(),
        command: text.into(),
        created: text.into(),
        config: format!("law = {text:?}\nsolver = {text:?}\ntol = 1e-8\n"),
        machine: text.into(),
        ..Provenance::default()
    };
    let mut archive = Archive::create(&output, &provenance).unwrap();
    let load = Dimension::index("load", 1, "load");
    for name in ["mean_pressure", "p_star", "area_fraction", "residual_load"] {
        let variable = Variable { dimensions: &[&load], units: text, long_name: text };
        archive.write(&format!("/loads/{name}"), &variable, &[1e-9]).unwrap();
    }
    archive.attribute("/not_converged", "why", text).unwrap();
    archive.attribute("/not_converged", "criteria", text).unwrap();
    archive.attribute("/not_converged", "advice", text).unwrap();
    archive.finish().unwrap();
}

#[test]
fn texts_of_a_file_are_shown_and_never_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (index, text) in [
        "</style></code></pre><script>alert(1)</script>",
        "<img src=x onerror=alert(1)>",
        "\"><svg/onload=alert(1)>",
        "&lt;b&gt; ' \" -->",
        "\u{202e}gnp.exe\u{1b}[31m",
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("f{index}.h5");
        write_bare(&folder.join(&name), text);
        assert_eq!(make(folder, &format!("report {name} -q")), Some(0), "{text}");
        let made = page(folder, &format!("f{index}.html"));
        check_page(&made);
        assert_eq!(
            outline(&made).0,
            ["answer", "asked", "numbers", "certificates", "remarks", "cost", "repeat", "cite"]
        );
        assert!(!made.contains(text), "{text}");
        assert!(!made.contains('\u{202e}') && !made.contains('\u{1b}'));
    }
    let made = page(folder, "f0.html");
    assert!(made.contains("&lt;script&gt;alert(1)&lt;/script&gt;"), "it is shown as it is");
}

/// The modulus of the map follows from another load.
#[test]
fn a_load_of_zero_has_its_map() {
    let folder = tempfile::tempdir().unwrap();
    let words =
        "contact --n 24 --eps-f-inv 6 --law exponential --param gamma=1e-4,range=5e-3 --p-star 0.05,0 --out c.h5 -q";
    assert_eq!(make(folder.path(), words), Some(0));
    let report = json(folder.path(), &["report", "c.h5", "--json", "-q"]);
    assert_eq!(
        (report["figures"].as_u64(), report["remarks"].as_array().map(Vec::len)),
        (Some(5), Some(0)),
        "{report}"
    );
}

#[test]
fn a_search_that_failed_is_said_first() {
    let folder = tempfile::tempdir().unwrap();
    let words = "contact --n 32 --eps-f-inv 8 --p-star 0.05 --max-iterations 2 --out c.h5 -q";
    assert_eq!(make(folder.path(), words), Some(1));
    assert_eq!(make(folder.path(), "report c.h5 -q"), Some(0));
    let made = page(folder.path(), "c.html");
    check_page(&made);
    assert!(made.contains("role=\"alert\"><h2>Not converged</h2>"));
    assert!(made.contains("No load converged: there is no result"));
    assert!(made.contains("Not every residual is within its bound") && made.contains("does not hold"));
}

#[test]
fn files_that_are_damaged_or_no_result_make_no_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(make(folder, "contact --n 24 --eps-f-inv 6 --p-star 0.1 --out c.h5 -q"), Some(0));
    let whole = std::fs::read(folder.join("c.h5")).unwrap();
    for part in [0, 7, 100, whole.len() / 3, whole.len() / 2, whole.len() - 1] {
        std::fs::write(folder.join("cut.h5"), &whole[..part]).unwrap();
        let output = gfmd(folder, &["report", "cut.h5"]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!([Some(1), Some(2)].contains(&output.status.code()), "{part}: {message}");
        assert!(message.contains("cut.h5") && !message.contains("panicked"), "{part}: {message}");
        assert!(!folder.join("cut.html").exists());
    }
    let mut changed = whole.clone();
    let numbers = changed.windows(8).rposition(|bytes| bytes == 0.1_f64.to_le_bytes());
    if let Some(place) = numbers {
        changed[place] ^= 1;
        std::fs::write(folder.join("changed.h5"), &changed).unwrap();
        assert!([Some(1), Some(2)].contains(&make(folder, "report changed.h5 -q")));
        assert!(!folder.join("changed.html").exists());
    }
    assert_eq!(make(folder, "surface --n 24 --out rough.h5 -q"), Some(0));
    for words in ["report rough.h5", "report absent.h5", "report c.h5 --out c.h5", "report c.h5 --out absent/c.html"] {
        let output = gfmd(folder, &words.split(' ').collect::<Vec<_>>());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words}: {message}");
        assert_eq!(message.lines().count(), 1, "{words}: {message}");
    }
    assert_eq!(std::fs::read(folder.join("c.h5")).unwrap(), whole);
    assert!(!folder.join("rough.html").exists());
}

/// A page of an earlier run is replaced, by default and by name; a user's file of that name is kept.
#[test]
fn only_pages_of_this_command_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(make(folder, "contact --n 24 --eps-f-inv 6 --p-star 0.1 --out c.h5 -q"), Some(0));
    assert_eq!(make(folder, "report c.h5 -q"), Some(0));
    let made = page(folder, "c.html");
    std::fs::write(folder.join("c.html"), made.replace("Result", "Old")).unwrap();
    for words in ["report c.h5 -q", "report c.h5 --out c.html -q"] {
        assert_eq!(make(folder, words), Some(0));
        assert_eq!(page(folder, "c.html"), made);
    }
    // An empty file has no user content; programs that make temporary names leave such files.
    std::fs::write(folder.join("c.html"), "").unwrap();
    assert_eq!(make(folder, "report c.h5 -q"), Some(0));
    let own = "<!DOCTYPE html><html><head><title>My notes</title></head><body>by gfmd report</body></html>";
    for content in [own.as_bytes(), &[0xff_u8, 0, 1][..], b"{}"] {
        std::fs::write(folder.join("c.html"), content).unwrap();
        for words in ["report c.h5", "report c.h5 --out c.html"] {
            let output = gfmd(folder, &words.split(' ').collect::<Vec<_>>());
            let message = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert!(message.starts_with("error: --out: ") && message.contains("c.html: the file exists"), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
            assert_eq!(std::fs::read(folder.join("c.html")).unwrap(), content);
        }
        assert_eq!(make(folder, "report c.h5 --out other.html -q"), Some(0));
        assert_eq!(page(folder, "other.html"), made);
    }
}

/// Pages of surfaces: a generated one, the file written from it, a scan with a hole, a profile.
#[test]
fn surfaces_have_pages_and_functions() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let words = |text: &str| -> Vec<String> { text.split_whitespace().map(str::to_owned).collect() };
    let run = |text: &str| {
        let words = words(text);
        json(folder, &words.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let made =
        run("surface --n 48,32 --size 3,2 --eps-f-inv 4 --statistics --out h.h5 --report h.html --plots h --json -q");
    assert_eq!(made["boundary"], "periodic");
    // Map, profile, spectrum, hills, autocorrelation and its map, three distributions, slopes, curvatures, bearing
    // curve.
    let text = page(folder, "h.html");
    check_page(&text);
    let sections = ["answer", "asked", "figures", "numbers", "repeat", "cite"];
    assert_eq!(outline(&text), (sections.to_vec(), 12, 1));
    assert!(text.contains("<span class=\"word\">3,2</span>") && text.contains("<code>sal</code>"));
    assert_eq!(made["plots"].as_array().unwrap().len(), 20);
    for name in ["hills", "autocorrelation", "correlation-map", "distributions", "slopes", "curvatures", "bearing"] {
        assert!(folder.join(format!("h-{name}.svg")).exists(), "{name}");
    }
    // JSON, the file and identities between them.
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    let file = gfmd_files::Reader::open(folder.join("h.h5")).unwrap();
    for (key, part) in [
        ("autocorrelation", "radial"),
        ("autocorrelation", "y"),
        ("distributions", "slope_y"),
        ("scale_dependence", "curvature_x"),
    ] {
        let stored = made[key][part].as_object().unwrap().iter().filter(|(_, value)| value.is_array());
        for (name, value) in stored {
            let values: Vec<f64> = file.values(&format!("/{key}/{part}/{name}")).unwrap();
            assert_eq!(values, numbers(value), "{key} {part} {name}");
        }
    }
    let bearing = numbers(&made["bearing_curve"]["height"]);
    assert_eq!((bearing.len(), bearing[0]), (201, made["sp"].as_f64().unwrap()));
    for key in ["sk", "vmc", "sal", "std", "spd", "s10z"] {
        let stored = file.values::<f64>(&format!("/statistics/{key}")).unwrap()[0];
        let number = made[key].as_f64().unwrap_or(f64::NAN);
        assert!(stored == number || (key == "std" && stored.is_nan() && number.is_nan()), "{key}: {stored} {number}");
    }
    assert_eq!((&made["wolf"], &made["motif_edges"]), (&0.05.into(), &"periodic".into()));
    assert_eq!(file.text("/statistics", "motif_edges").unwrap(), "periodic");
    let difference = numbers(&made["autocorrelation"]["x"]["difference"])[1];
    let slope = numbers(&made["scale_dependence"]["slope_x"]["slope"])[0];
    assert!((slope * 3.0 / 48.0 - (2.0 * difference).sqrt()).abs() < 1e-12);
    assert!(
        made["std"].is_null() == made["lay"].is_null()
            && made["undefined"].as_object().is_none_or(|all| all.len() == 1)
    );

    // The file is read again; it does not state that its surface is periodic.
    let read = run("surface --surface h.h5 --report again.html --json -q");
    assert_eq!((&read["boundary"], read.get("psd")), (&"free".into(), None));
    assert_eq!(read["report"], "again.html");
    check_page(&page(folder, "again.html"));
    let same = run("surface --surface h.h5 --statistics --boundary periodic --json -q");
    assert_eq!(same["autocorrelation"], made["autocorrelation"]);

    std::fs::write(folder.join("scan.txt"), "1 2 nan 3\n2 4 3 1\n0 1 2 2\n3 1 2 5\n").unwrap();
    run("surface --surface scan.txt --fill nearest --report scan.html --json -q");
    let text = page(folder, "scan.html");
    check_page(&text);
    assert!(text.contains("1 of 16 (6.25 %), filled: nearest") && text.contains("SHA-256"), "{text}");

    let line = run("surface --n 64 --dim 2 --statistics --report line.html --json -q");
    assert!(line["autocorrelation"].get("y").is_none() && line["distributions"].get("slope_y").is_none());
    check_page(&page(folder, "line.html"));
    let flat = "0 0 0 0\n0 0 0 0\n0 0 0 0\n";
    std::fs::write(folder.join("flat.txt"), flat).unwrap();
    let flat = run("surface --surface flat.txt --statistics --report flat.html --json -q");
    for key in ["sal", "sk", "vmp", "std", "ssw", "hills", "s10z"] {
        assert_eq!((reason_for(&flat, key), flat[key].is_null()), (Some("the surface is flat"), true), "{key}");
    }

    // A page of another program is kept; a page in a missing folder is refused before the heights are made.
    std::fs::write(folder.join("mine.html"), "<p>mine</p>").unwrap();
    assert_eq!(make(folder, "surface --n 16 --report mine.html -q"), Some(2));
    assert_eq!(page(folder, "mine.html"), "<p>mine</p>");
    assert_eq!(make(folder, "surface --n 16 --report none/page.html -q"), Some(2));
}

/// Returns the text, without tags, of the parts of a page between `start` and the next `end`.
fn said<'a>(page: &'a str, start: &str, end: &str) -> Vec<String> {
    let bare = |part: &'a str| -> String {
        part.split('<').map(|piece| piece.split_once('>').map_or(piece, |(_, text)| text)).collect()
    };
    page.split(start).skip(1).filter_map(|rest| rest.split(end).next()).map(bare).collect()
}

/// Headlines have the digits and the units of the tables, facts have their units, captions the rows of the tables.
#[test]
fn numbers_have_the_digits_of_their_tables_and_units() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scan(&folder.join("scan.txt"));
    let scan = "--surface scan.txt --unit m --size 1um --young 10MPa --poisson 0.4";
    let waves = "--n 16 --eps-f-inv 4";
    for (name, words, facts) in [
        ("c", format!("contact {scan} --pressure 10kPa,20kPa --hardness 2GPa"), &["E = 10 MPa, ν = 0.4", "2 GPa"][..]),
        ("e", format!("contact {waves} --p-star 0.05"), &["E = 1, ν = 0"]),
        (
            "b",
            format!("contact {scan} --pressure 10kPa --second-body 3GPa,0.3 --layer 1GPa,0.2,2um --height 1um"),
            &[
                "slab of height 1 µm, E = 10 MPa, ν = 0.4; on a layer of height 2 µm (E = 1 GPa, nu = 0.2)",
                "against a half-space (E = 3 GPa, nu = 0.3) above",
            ],
        ),
        (
            "p",
            format!("path {scan} --law morse --param gamma=1mJ/m^2,range=1nm --approach=-10nm,20nm --steps 3"),
            &["−10, 20 nm"],
        ),
        (
            "f",
            format!("path {scan} --pressure 10kPa --friction 0.3 --lateral 0,-1nm --steps 2"),
            &["10 kPa", "0, −1 nm"],
        ),
        (
            "r",
            format!("path {scan} --pressure 10kPa --prony 1ms:0.5 --time 1ms --steps 2"),
            &["0.001 s : 0.5", "10 kPa"],
        ),
        ("s", format!("slide {scan} --prony 1ms:0.5 --pressure 10kPa --velocity 1mm/s:10mm/s:2"), &["1, 10 mm/s"]),
        (
            "w",
            format!("wear {scan} --pressure 10kPa --coefficient 2e-12/Pa --distance 0,1um --steps 2"),
            &["2 1/TPa", "0, 1 µm", "10 kPa"],
        ),
        ("d", "body --surface c.h5 --depths 0,50nm".into(), &["E = 10 MPa", "0, 50 nm"]),
    ] {
        assert_eq!(make(folder, &format!("{words} --out {name}.h5 --threads 1 -q")), Some(0), "{words}");
        assert_eq!(make(folder, &format!("report {name}.h5 -q")), Some(0), "{words}");
        let page = page(folder, &format!("{name}.html"));
        let asked = said(&page, "<section id=\"asked\"", "</section>").concat();
        for fact in facts {
            assert!(asked.contains(fact), "{name}: {fact}: {asked}");
        }
        assert!(page.contains(", 1 thread<") && !page.contains("1 threads"), "{name}");
        // Maps are in the unit stated in their captions.
        let captions = said(&page, "<figcaption>", "</figcaption>");
        let is_divided = captions.iter().any(|caption| caption.contains("divided by the modulus E*"));
        assert_eq!(is_divided, name == "e", "{captions:?}");
        // The state of a figure is a row of the table.
        let rows: Vec<String> = said(&page, "<tr><td>", "</td>");
        for caption in captions.iter().filter(|caption| caption.starts_with("Figure") && caption.contains("ressure, "))
        {
            let (word, state) = caption.trim_end_matches('.').rsplit_once(' ').unwrap();
            assert!(["load", "step", "state"].iter().any(|row| word.ends_with(row)), "{caption}");
            assert!(rows.iter().any(|row| row == state), "{name}: {caption}: {rows:?}");
        }
        if ["c", "b", "w", "p"].contains(&name) {
            // Two digits and ~ of the table appear in the headline, with an explanation below.
            let cells = said(&page, "<td>", "</td>");
            let answer = said(&page, "<section id=\"answer\"", "</section>").concat();
            assert!(cells.iter().any(|cell| cell.ends_with('~')) && answer.contains("~ "), "{name}: {answer}");
            assert!(page.contains("two digits and ~: the grid error of the number is not known"), "{name}");
        }
        let pairs = said(&page, "<dt>transform pairs</dt><dd>", "</dd>");
        assert!(pairs.iter().all(|count| !count.ends_with(".000") && !count.contains(".0")), "{pairs:?}");
    }
    let headline = |name: &str| said(&page(folder, &format!("{name}.html")), "<p class=\"headline\">", "</p>").concat();
    assert!(
        headline("c").starts_with("7.8~ %") && page(folder, "c.html").contains("<td>0.078~</td>"),
        "{}",
        headline("c")
    );
    assert!(headline("s").contains("at the velocity 1 mm/s"), "{}", headline("s"));
    assert!(headline("w").contains("lost on average over the distance 1.0000 µm"), "{}", headline("w"));
    assert!(headline("p").contains("J/m²") && !headline("p").contains("Pa"), "{}", headline("p"));
    assert!(headline("d").contains("kPa at the depth"), "{}", headline("d"));
    let text = gfmd(folder, &format!("contact {scan} --pressure 10kPa").split(' ').collect::<Vec<_>>());
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("\ntwo digits and ~: the grid error of the number is not known\n"), "{text}");
}

/// Pages of punches, of fields below them, and of sliding, with the numbers of their files.
#[test]
fn punches_bodies_and_slides_have_pages() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let certified = ["answer", "asked", "figures", "numbers", "certificates", "cost", "repeat", "cite"];
    let plain = ["answer", "asked", "figures", "numbers", "cost", "repeat", "cite"];
    let line = "punch --dim 2 --n 64 --contact frictionless --out l.h5";
    for (words, file, sections, figures, tables) in [
        // Pressure, three displacements, two cuts.
        ("punch --n 24 --out p.h5", "p", &certified[..], 6, 2),
        (line, "l", &certified, 2, 2),
        // Two curves against the depth; von Mises stress, displacement, stress and energy density on a section, or a
        // plane.
        ("body --surface p.h5 --levels 5 --slice y=0.5 --out b.h5", "b", &plain, 13, 1),
        ("body --surface p.h5 --slice z=1 --out z.h5", "z", &plain, 11, 1),
        ("body --surface l.h5 --levels 5 --out s.h5", "s", &plain, 10, 1),
        // Uneven depths have no section.
        ("body --surface l.h5 --depths 0,0.1,0.5 --out u.h5", "u", &plain, 2, 1),
        // Friction, area; pressure, gap, section, heights.
        (
            "slide --n 32 --eps-f-inv 4 --prony 0.1:0.5 --p-star 0.05,0.1 --velocity 0.1,1,10 --out v.h5",
            "v",
            &certified,
            6,
            2,
        ),
        ("slide --n 32 --eps-f-inv 4 --prony 0.1:0.5 --p-star 0.05 --velocity 1 --out w.h5", "w", &certified, 4, 2),
        // Wear, area, largest pressure; profile, depth; pressure, gap, section, heights.
        (
            "wear --n 32 --eps-f-inv 4 --p-star 0.05 --coefficient 1 --distance 0,0.1 --steps 4 --out a.h5",
            "a",
            &certified,
            9,
            3,
        ),
        // Temperature against velocity, and its map; pressure, gap, section, heights. A table of the heat.
        (
            "slide --n 32 --eps-f-inv 4 --heat 1,0.1,0.3,0.2 --friction 0.3 --p-star 0.05 --velocity 0.1,1,10 \
             --out h.h5",
            "h",
            &certified,
            6,
            3,
        ),
    ] {
        assert_eq!(make(folder, &format!("{words} -q")), Some(0), "{words}");
        assert_eq!(make(folder, &format!("report {file}.h5 -q")), Some(0), "{words}");
        let text = page(folder, &format!("{file}.html"));
        check_page(&text);
        let cited = text.contains("id=\"cite\"");
        let wanted: Vec<&str> = sections.iter().copied().filter(|section| *section != "cite" || cited).collect();
        assert_eq!(outline(&text), (wanted, figures, tables), "{words}");
        assert!(
            text.contains(&format!("gfmd check {file}.h5 --rerun")) && !text.contains("Not every residual"),
            "{words}"
        );
    }
    let reader = gfmd_files::Reader::open(folder.join("p.h5")).unwrap();
    let mean = reader.values::<f64>("/punch/mean_pressure").unwrap()[0];
    assert!(page(folder, "p.html").contains(&format!("Mean pressure {mean:.6}")), "{mean}");
    let reader = gfmd_files::Reader::open(folder.join("v.h5")).unwrap();
    let friction = reader.values::<f64>("/states/friction").unwrap().into_iter().fold(0.0, f64::max);
    let digits = 1 - friction.log10().floor() as i32;
    let shown = format!("Coefficient of friction {friction:.*}~", digits.max(0) as usize);
    assert!(page(folder, "v.html").contains(&shown), "{shown}");
    let reader = gfmd_files::Reader::open(folder.join("a.h5")).unwrap();
    let deepest = reader.values::<f64>("/path/max_wear").unwrap().into_iter().fold(0.0, f64::max);
    assert!(page(folder, "a.html").contains(&format!("{deepest:.7} at most")), "{deepest}");
    let reader = gfmd_files::Reader::open(folder.join("s.h5")).unwrap();
    let stress = reader.values::<f64>("/fields/von_mises").unwrap().into_iter().fold(0.0, f64::max);
    assert!(page(folder, "s.html").contains(&format!("von Mises {stress:.5}")), "{stress}");
}

/// The page of a path names all its parts and draws them; it has nothing of a part that is absent.
#[test]
fn pages_of_paths_show_their_parts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let law = "--law exponential --param gamma=2e-4,range=0.01";
    let (shear, in_time) = ("--friction 0.3 --lateral 0,1e-3,-1e-3", "--prony 1:0.4 --time 0,1,1");
    let lost = "Energy lost so far per area, by cause and in all, against";
    let cases = [
        (
            format!("{law} {shear}"),
            "exponential, friction",
            vec!["Shear against the lateral displacement (leg by leg; ", "Lost by friction", "energy lost by cause"],
            vec!["wear", "hardness", "against time", "Approach"],
        ),
        (
            format!("--hardness 0.05 {shear}"),
            "hard wall, friction, hardness",
            vec!["Sticking area against the lateral displacement (leg by leg; ", "plastic flow", lost],
            vec!["wear", "against time", "jumps"],
        ),
        (
            format!("{in_time} {shear}"),
            "hard wall, friction",
            vec!["Shear against time", "Shear against the lateral displacement (leg by leg).", lost, "relaxation"],
            vec!["wear", "hardness", "jumps"],
        ),
        (
            format!("--coefficient 2 --wear-by slip {shear}"),
            "hard wall, friction, wear by slip",
            vec!["Mean depth lost against the length of the lateral path", lost, "Depth that both surfaces have lost"],
            vec!["sliding distance", "against time", "hardness"],
        ),
        (
            format!("--boundary free {law} --hardness 0.2 --coefficient 1 --distance 0,0.1,0.1 {in_time} {shear}"),
            "exponential, friction, hardness, wear by distance",
            vec!["Mean depth lost against the sliding distance", "Shear against time", lost, "wear coefficient"],
            vec!["lateral path"],
        ),
    ];
    for (words, interface, there, absent) in cases {
        let given = "path --n 16 --eps-f-inv 4 --eps-t-inv 1 --p-star 0.05 --steps 2 --tolerance 1e-6 --out p.h5 -q";
        assert_eq!(make(folder, &format!("{given} {words}")), Some(0), "{words}");
        assert_eq!(make(folder, "report p.h5 -q"), Some(0), "{words}");
        let made = page(folder, "p.html");
        check_page(&made);
        let (shown, _) = made.split_once("<section id=\"repeat\"").unwrap();
        assert!(shown.contains(&format!("<dt>interface</dt><dd>{interface}</dd>")), "{words}");
        // Definitions of the columns stand in the titles of the table.
        let (figures, _) = shown.split_once("<section id=\"numbers\"").unwrap();
        for text in there {
            assert!(figures.contains(text), "{words}: {text}");
        }
        for text in absent {
            assert!(!figures.contains(text), "{words}: {text}");
        }
    }
}
