//! `--material` stands for the modulus and Poisson's ratio of a named source, which results record.

use gfmd_files::Reader;

use super::common::{gfmd, json};

const ALUMINIUM: &str = "aluminium (EN 1999-1-1:2007, 3.2.5 (all structural alloys))";

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn refused(folder: &std::path::Path, line: &str) -> String {
    let output = gfmd(folder, &words(line));
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{line}: {text}");
    text
}

#[test]
fn a_material_is_its_modulus_and_ratio_and_results_name_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let lines = [
        "contact --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa -q --json",
        "path --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa --steps 1 -q --json",
        "slide --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa --prony 1us:0.5 --velocity 1m/s -q --json",
        "estimate --n 64 --size 100um --pressure 10MPa -q --json",
    ];
    for line in lines {
        let of = |body: &str| json(folder.path(), &words(&format!("{line} {body}")));
        let (named, plain) = (of("--material aluminium"), of("--young 70GPa --poisson 0.3"));
        assert_eq!(named["material"], ALUMINIUM, "{line}");
        assert_eq!((&named["e_star"], plain["material"].is_null()), (&plain["e_star"], true));
        for key in ["loads", "steps", "states"] {
            let first = |report: &serde_json::Value| report[key][0]["area_fraction"].clone();
            assert_eq!(first(&named), first(&plain), "{line}");
        }
        let text = gfmd(folder.path(), &words(&format!("{} --material aluminium", line.replace(" --json", ""))));
        assert!(String::from_utf8(text.stdout).unwrap().contains(&format!("material: {ALUMINIUM}")), "{line}");
    }
}

#[test]
fn a_rubber_slides_with_the_series_that_is_listed_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let table = String::from_utf8(gfmd(folder.path(), &["materials"]).stdout).unwrap();
    let series = table.split_once("  --prony ").unwrap().1.lines().take(2).collect::<Vec<_>>().join(" ");
    let line = "slide --n 32 --eps-f-inv 4 --size 100um --pressure 1kPa --velocity 10um/s --material nbr -q --json";
    let found = json(folder.path(), &words(&format!("{line} --prony {series}")));
    let ratio = found["young_instantaneous"].as_f64().unwrap() / found["young_long_term"].as_f64().unwrap();
    // Shear moduli of the source, at once and in the long term; Young's moduli of a rubber have nearly this ratio.
    assert!((ratio / (1176.6 / 400.0) - 1.0).abs() < 2e-3, "{found}");
    assert!(found["states"][0]["converged"].as_bool().unwrap());
}

#[test]
fn files_record_a_material_and_are_checked_resumed_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let line = "contact --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa --material aluminium --out c.h5 -q";
    for _ in 0..2 {
        assert!(gfmd(folder.path(), &words(&format!("{line} --resume"))).status.success());
    }
    let config = Reader::open(folder.path().join("c.h5")).unwrap().text("/", "config").unwrap();
    assert!(config.contains(ALUMINIUM) && config.contains("poisson = 0.3"), "{config}");
    for command in
        ["check c.h5", "report c.h5 --out c.html", "body --surface c.h5:/fields/displacement_z --depths 0.1um -q"]
    {
        let output = gfmd(folder.path(), &words(command));
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let page = std::fs::read_to_string(folder.path().join("c.html")).unwrap();
    assert!(page.contains("EN 1999-1-1:2007"));
}

#[test]
fn a_second_body_and_a_fluid_have_names_that_results_record() {
    let folder = tempfile::tempdir().unwrap();
    let contact = "contact --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa --young 70GPa --flow -q --json";
    let path = "path --n 32 --eps-f-inv 4 --size 100um --pressure 10MPa --young 70GPa --steps 1 --flow -q --json";
    let drop = "--pressure-drop 1bar";
    for (line, rows) in [(contact, "loads"), (path, "steps")] {
        let of = |more: &str| json(folder.path(), &words(&format!("{line} {drop} {more}")));
        let named = of("--second-material steel-s355 --fluid water --out named.h5");
        let plain = of("--second-body 210GPa,0.3 --viscosity 1.0016mPa*s --out plain.h5");
        let source = |text: &serde_json::Value| text.as_str().unwrap().to_owned();
        assert!(source(&named["second_material"]).starts_with("steel-s355 (EN 1993"), "{named}");
        assert!(source(&named["fluid"]).starts_with("water (IAPWS 2008"), "{named}");
        assert!(plain["second_material"].is_null() && plain["fluid"].is_null(), "{plain}");
        for key in ["e_star", "second_body"] {
            assert_eq!(named[key], plain[key], "{line}");
        }
        let leak = |report: &serde_json::Value| report[rows][0]["leak"].clone();
        assert!(leak(&named)[0].as_f64().unwrap() > 0.0, "{named}");
        assert_eq!(leak(&named), leak(&plain), "{line}");
        let text = |file: &str| Reader::open(folder.path().join(file)).unwrap().text("/", "config").unwrap();
        assert!(text("named.h5").contains("IAPWS 2008") && text("named.h5").contains("steel-s355 (EN 1993"));
        for command in ["check named.h5", "report named.h5 --out named.html"] {
            let output = gfmd(folder.path(), &words(command));
            assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        }
        let page = std::fs::read_to_string(folder.path().join("named.html")).unwrap();
        assert!(page.contains("IAPWS 2008"), "{line}");
        let printed = gfmd(folder.path(), &words(&format!("{} {drop} --fluid water", line.replace(" --json", ""))));
        assert!(String::from_utf8(printed.stdout).unwrap().contains("\nfluid: water (IAPWS 2008"));
        for name in ["named.h5", "plain.h5"] {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
    }
    let below = "body --surface c.h5:/fields/displacement_z --depths 0.1um -q --second-material aluminium";
    let line = "contact --n 16 --eps-f-inv 4 --size 100um --pressure 10MPa --young 70GPa --second-body 1GPa,0.3 -q";
    assert!(gfmd(folder.path(), &words(&format!("{line} --out c.h5"))).status.success());
    let output = gfmd(folder.path(), &words(below));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn names_beside_numbers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let base = "contact --n 16 --eps-f-inv 4 --size 100um --pressure 1MPa --young 70GPa";
    for (more, wanted) in [
        ("--second-material mithril", "--second-material is mithril; it must be one of aluminium"),
        ("--second-material peek --second-body 1GPa,0.3", "it must be given without --second-body: it has a modulus"),
        ("--fluid honey --flow --pressure-drop 1bar", "--fluid is honey; it must be one of air, oil-cylinder"),
        ("--fluid water --viscosity 1mPa*s --flow --pressure-drop 1bar", "without --viscosity: it has a viscosity"),
        ("--fluid water --flow", "--pressure-drop is missing; it is needed with --fluid"),
        ("--fluid water --pressure-drop 1bar", "--fluid is given; it must be left out without --flow"),
    ] {
        let text = refused(folder.path(), &format!("{base} {more}"));
        assert!(text.contains(wanted), "{more}: {text}");
    }
}

#[test]
fn a_study_takes_materials_as_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let bodies = "{ name = 'al', material = 'aluminium' }, { name = 'plain', young = '70GPa', poisson = 0.3 }";
    let study = "command = 'contact'\n[contact]\nn = 16\neps_f_inv = 4\nsize = '100um'\npressure = ['10MPa']\n[study]\n\
                 body = [";
    let study = format!("{study}{bodies}]\n");
    std::fs::write(folder.path().join("s.toml"), study).unwrap();
    let found = json(folder.path(), &["study", "s.toml", "-q", "--json"]);
    let areas = found["numbers"]["area_fraction"]["values"].to_string();
    let parts: Vec<&str> =
        areas.trim_matches(['[', ']']).split(',').map(|part| part.trim_matches(['[', ']'])).collect();
    assert_eq!(parts.len(), 2, "{areas}");
    assert_eq!(parts[0], parts[1]);
}

#[test]
fn materials_are_listed_and_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let listed = json(folder.path(), &["materials", "--json"]);
    assert_eq!(listed["materials"]["aluminium"]["young"], "70GPa");
    assert_eq!(listed["materials"]["ptfe"]["conductivity"], "0.263W/(m*K)");
    assert_eq!(listed["materials"]["nbr"]["prony"][1], serde_json::json!(["10s", 0.06476]));
    assert!(listed["materials"]["aluminium"]["prony"].is_null());
    let table = String::from_utf8(gfmd(folder.path(), &["materials"]).stdout).unwrap();
    assert!(table.contains("\n  conductivity 0.263W/(m*K)\n"), "{table}");
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    assert_eq!(listed["fluids"]["water"]["viscosity"], "1.0016mPa*s");
    assert!(table.contains("\nwater "), "{table}");
    let base = "contact --n 16 --eps-f-inv 4 --size 100um --pressure 1MPa --material";
    assert!(refused(folder.path(), &format!("{base} mithril")).contains("--material is mithril; it must be one of"));
    for other in ["young 70GPa", "poisson 0.3", "e-star 70GPa"] {
        let text = refused(folder.path(), &format!("{base} aluminium --{other}"));
        let flag = other.split(' ').next().unwrap();
        assert!(text.contains(&format!("--material is aluminium; it must be given without --{flag}")), "{text}");
    }
    let text = refused(folder.path(), &format!("{base} aluminium --compliance 1:1,100:0.01"));
    assert!(text.contains("--material is aluminium; it must be left out with --compliance"), "{text}");
    let text = refused(folder.path(), "contact --n 16 --eps-f-inv 4 --p-star 0.1 --material aluminium");
    assert!(text.contains("it has a unit, and the lengths have none"), "{text}");
}
