//! Layers, bases and second bodies from end to end: flags in, numbers out, recorded and read back.

use std::path::Path;

use crate::common::{SWEEP, gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::{Value, json as value};

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &words(flags))
}

fn near(found: &Value, wanted: f64, tolerance: f64) {
    let found = found.as_f64().unwrap();
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found} {wanted}");
}

const COATED: &str = "--young 2 --poisson 0.3 --height 0.05 --layer 1,0.4,0.1 --layer 0.5,0.5,0.02 --base half-space \
                      --base-young 10 --base-poisson 0.2 --second-body 3,0.3,0.4";

#[test]
fn a_contact_on_layers_is_recorded_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let report = run(folder, &format!("contact --n 32 --eps-f-inv 4 --p-star 0.02,0.1 {COATED} --out c.h5 --json"));
    near(&report["e_star"], 1.0 / (0.91 / 2.0 + 0.91 / 3.0), 1e-14);
    assert_eq!(report["base"], "half-space");
    assert_eq!(report["layer"], value!([[1.0, 0.4, 0.1], [0.5, 0.5, 0.02]]));
    assert_eq!(report["second_body"], value!([3.0, 0.3, 0.4]));
    let config = Reader::open(folder.join("c.h5")).unwrap().text("/", "config").unwrap();
    let config: toml::Table = config.parse().unwrap();
    assert_eq!((config["base"].as_str(), config["base_young"].as_float()), (Some("half-space"), Some(10.0)));
    assert_eq!(config["layer"].as_array().unwrap().len(), 2);
    let checked = run(folder, "check c.h5 --rerun --json");
    assert_eq!(checked["differing"], 0);
    // The first lines of a contact describe its body.
    let text = String::from_utf8(
        gfmd(folder, &words("contact --n 32 --eps-f-inv 4 --p-star 0.02 --height 1 --base free")).stdout,
    );
    assert!(text.unwrap().contains("elastic body: slab of height 1 (E = 1, nu = 0), free below"));
    gfmd(folder, &words("report c.h5 --out page.html"));
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(
        page.contains("on a layer of height 0.1 (E = 1, nu = 0.4)") && page.contains("against a slab of height 0.4")
    );
}

/// At an interface the tractions are continuous, and the lateral stress jumps with the moduli.
#[test]
fn stresses_jump_at_interfaces_and_the_pressure_is_met_at_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &format!("contact --n 32 --eps-f-inv 4 --p-star 0.1 {COATED} --out c.h5 --json"));
    let report = run(folder, "body --surface c.h5 --levels 5 --deepest 0.2 --out b.h5 --json");
    let levels = report["levels"].as_array().unwrap();
    let sides: Vec<&Value> = levels.iter().map(|level| &level["side"]).collect();
    assert_eq!(levels.len(), 9, "{levels:?}");
    assert_eq!((sides[1], sides[2], sides[0]), (&"above".into(), &"below".into(), &Value::Null));
    let file = Reader::open(folder.join("b.h5")).unwrap();
    assert_eq!(file.values::<f64>("/fields/side").unwrap()[..4], [0.0, 1.0, -1.0, 0.0]);
    let [nx, ny] = [32, 32];
    let stress: Vec<f64> = file.values("/fields/stress").unwrap();
    let at = |level: usize, point: usize, component: usize| stress[(level * nx * ny + point) * 6 + component];
    let pressure: Vec<f64> = Reader::open(folder.join("c.h5")).unwrap().slab("/fields/pressure", 0).unwrap();
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    let mut jump: f64 = 0.0;
    for (point, p) in pressure.iter().enumerate() {
        // Without lateral coupling along Nyquist directions, see theory.md.
        assert!((at(0, point, 2) + p).abs() < 0.02 * peak, "{point}");
        for component in 2..5 {
            assert!((at(1, point, component) - at(2, point, component)).abs() < 1e-9 * peak, "{point} {component}");
        }
        jump = jump.max((at(1, point, 0) - at(2, point, 0)).abs());
    }
    assert!(jump > 0.05 * peak, "{jump} {peak}");
    let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
    for level in 0..levels.len() {
        let found = (0..nx * ny).map(|point| at(level, point, 2)).sum::<f64>() / pressure.len() as f64;
        assert!((found + mean).abs() < 1e-12 * peak, "{level}: {found} {mean}");
    }
    assert_eq!(run(folder, "check b.h5 --json")["differing"], 0);
    // One level on each side of the requested interface, although its depth differs by rounding.
    let one = run(folder, "body --surface c.h5 --depths 0.15,0.16 --json");
    assert_eq!(one["levels"].as_array().unwrap().len(), 3);
    // Flags override the values recorded in the file.
    let thicker = run(folder, "body --surface c.h5 --layer 1,0.4,0.3 --depths 0.34 --json");
    assert_eq!(thicker["levels"].as_array().unwrap().len(), 1);
}

/// Layers of one material are one slab, and two half-spaces are one with the composite modulus, in every command.
#[test]
fn what_is_the_same_body_has_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let both = |command: &str, whole: &str, parts: &str, keys: &[&str]| {
        let (whole, parts) =
            (run(folder, &format!("{command} {whole} --json")), run(folder, &format!("{command} {parts} --json")));
        for key in keys {
            near(parts.pointer(key).unwrap(), whole.pointer(key).unwrap().as_f64().unwrap(), 1e-7);
        }
    };
    for base in ["bonded", "sliding", "free"] {
        let whole = format!("--poisson 0.3 --height 0.3 --base {base}");
        let parts = format!("--poisson 0.3 --height 0.1 --layer 1,0.3,0.2 --base {base}");
        both(
            "contact --n 32 --eps-f-inv 4 --p-star 0.1",
            &whole,
            &parts,
            &["/loads/0/approach", "/loads/0/elastic_energy"],
        );
        let keys = ["/mean_pressure", "/elastic_energy"];
        both("punch --n 24 --size 1 --young 1 --nodes inclusive", &whole, &parts, &keys);
        let path = "path --n 16 --eps-f-inv 4 --p-star 0.1 --friction 0.3 --lateral 0,0.002 --steps 2";
        both(path, &whole, &parts, &["/steps/2/mean_shear/0", "/steps/2/approach"]);
    }
    let pair = "--young 1 --poisson 0.5 --second-body 4,0.5";
    let keys = ["/e_star", "/loads/0/approach", "/loads/0/area_fraction", "/loads/0/max_pressure"];
    both("contact --n 32 --eps-f-inv 4 --p-star 0.1", "--young 0.8 --poisson 0.5", pair, &keys);
    both("contact --n 32 --eps-f-inv 4 --p-star 0.1 --boundary free", "--young 0.8 --poisson 0.5", pair, &keys);
    let law = "contact --n 32 --eps-f-inv 4 --p-star 0.02 --law exponential --param gamma=1e-4,range=3e-3";
    both(law, "--young 0.8 --poisson 0.5", pair, &keys);
}

#[test]
fn a_sweep_has_bodies_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let body = "[body]\nheight = 0.2\nlayers = [[3.0, 0.3, 0.1]]\nbase = \"sliding\"\nsecond_body = [2.0, 0.4]\n";
    std::fs::write(folder.join("s.toml"), format!("{SWEEP}{body}")).unwrap();
    let report = run(folder, "kappa-sweep --config s.toml --out s.h5 --json --quiet");
    let kappa = report["points"][0]["kappa"].as_f64().unwrap();
    std::fs::write(folder.join("h.toml"), format!("{SWEEP}[body]\nheight = \"inf\"\n")).unwrap();
    let other = run(folder, "kappa-sweep --config h.toml --json --quiet")["points"][0]["kappa"].as_f64().unwrap();
    assert!((kappa / other - 1.0).abs() > 1e-3, "{kappa} {other}");
    let config = Reader::open(folder.join("s.h5")).unwrap().text("/", "config").unwrap();
    let config: toml::Table = config.parse().unwrap();
    assert_eq!(config["body"]["layers"][0][1].as_float(), Some(0.3));
    assert_eq!(run(folder, "check s.h5 --rerun --sample 2 --json")["differing"], 0);
    for (line, named) in [
        ("base = \"loose\"", "body.base"),
        ("base = \"half-space\"", "body.base_young is missing"),
        ("base_young = 3.0", "body.base_young is 3"),
        ("second_body = [1.0]", "body.second_body is [1.0]"),
        ("layers = [[1.0, 0.7, 0.1]]", "body.layers: Poisson's ratio is 0.7"),
        ("layers = [[1.0, 0.3, 1e-20]]", "body.layers is"),
    ] {
        std::fs::write(folder.join("w.toml"), format!("[body]\nheight = 0.2\n{line}\n")).unwrap();
        let output = gfmd(folder, &words("kappa-sweep --config w.toml --dry-run"));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && text.contains(named), "{line}: {text}");
    }
    // Moduli may have a unit, since only their ratios matter; nothing else has one.
    for (with, without) in [("\"3GPa\"", "3e9"), ("\"2 GPa\"", "2e9")] {
        let body = |modulus: &str| format!("[body]\nyoung = 1e9\nheight = 0.2\nlayers = [[{modulus}, 0.3, 0.1]]\n");
        let shown = [with, without].map(|modulus| {
            std::fs::write(folder.join("u.toml"), body(modulus)).unwrap();
            String::from_utf8(gfmd(folder, &words("kappa-sweep --config u.toml --show-config")).stdout).unwrap()
        });
        assert!(shown[0] == shown[1] && shown[0].contains("young = 1000000000.0"), "{shown:?}");
    }
    for (line, named) in [
        ("height = \"20um\"", "body.height is \"20um\": a sweep has no unit of length"),
        ("young = \"3mm\"", "body.young: \"3mm\": it is a length"),
        ("young = \"3GPaa\"", "body.young: \"3GPaa\": \"GPaa\" is no unit"),
        ("layers = [[\"3GPa\", 0.3, \"1um\"]]", "body.layers is \"1um\": a sweep has no unit of length"),
        ("young = \"3GPa\"\npoisson = true", "poisson"),
    ] {
        std::fs::write(folder.join("w.toml"), format!("[body]\n{line}\n")).unwrap();
        let output = gfmd(folder, &words("kappa-sweep --config w.toml --dry-run"));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && text.contains(named), "{line}: {text}");
    }
    std::fs::write(folder.join("w.toml"), "[body]\nbase = \"free\"\n").unwrap();
    let output = gfmd(folder, &words("kappa-sweep --config w.toml --dry-run"));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("body.base is free; it must be bonded with body.height inf")
    );
}

#[test]
fn what_does_not_go_together_is_refused_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "contact --n 16 --eps-f-inv 4 --p-star 0.1",
        "path --n 16 --eps-f-inv 4 --p-star 0.1 --law morse --param gamma=1e-3,range=1e-3",
    ] {
        for (flags, message) in [
            ("--layer 1,0.3,1", "--layer is 1,0.3,1; it must be left out with --height inf: nothing lies below"),
            ("--base sliding", "--base is sliding; it must be bonded with --height inf: a half-space has no base"),
            (
                "--height 1 --base half-space --base-young 2",
                "--base-poisson is missing; it is needed with --base half-space",
            ),
            (
                "--height 1 --base free --base-young 2",
                "--base-young is 2; it must be left out without --base half-space",
            ),
            ("--height 1 --layer 1,0.3,-1", "--layer: the height of the slab is -1; it must be positive and finite"),
            ("--height 1 --layer 1,0.3,1e13", "the height of --layer is 1e13; it must be between 1e-12 and 1e12 times"),
            ("--height 1 --layer -1,0.3,1", "--layer: Young's modulus is -1; it must be positive and finite"),
            ("--second-body 1,0.3,1,4", "it must be E,NU or E,NU,H"),
            ("--second-body nan,0.3", "--second-body: Young's modulus is NaN; it must be positive and finite"),
        ] {
            let output = gfmd(folder.path(), &words(&format!("{command} {flags}")));
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.code() == Some(2) && text.contains(message), "{flags}: {text}");
        }
    }
    let free = "contact --n 16 --eps-f-inv 4 --p-star 0.1 --boundary free --height 1 --base free";
    let text = String::from_utf8(gfmd(folder.path(), &words(free)).stderr).unwrap();
    assert!(text.contains("nothing holds the plate"), "{text}");
}

/// A moving base: read from a file, kept in the result, checked, run again, and used for the fields inside.
#[test]
fn a_base_that_moves_is_kept_and_met_inside() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let wave = |amplitude: f64| {
        Array2::from_shape_fn((27, 27), |(i, j)| amplitude * (std::f64::consts::TAU * (i + 2 * j) as f64 / 27.0).cos())
    };
    ndarray_npy::write_npy(folder.join("base.npy"), &wave(0.01)).unwrap();
    let flags = "contact --n 27 --eps-f-inv 4 --p-star 0.05 --height 0.3 --poisson 0.3";
    run(folder, &format!("{flags} --base-displacement base.npy --out c.h5 --json"));
    let reader = Reader::open(folder.join("c.h5")).unwrap();
    assert_eq!(reader.shape("/base/displacement").unwrap(), [27, 27, 3]);
    std::fs::remove_file(folder.join("base.npy")).unwrap();
    let checked = run(folder, "check c.h5 --rerun --json");
    assert_eq!(checked["differing"], 0, "{checked:#}");
    // The base has its displacement, and the surface the pressure of the contact.
    run(folder, "body --surface c.h5 --depths 0,0.3 --out b.h5 --json");
    let inside = Reader::open(folder.join("b.h5")).unwrap();
    let displacement: Vec<f64> = inside.values("/fields/displacement").unwrap();
    let below = &displacement[3 * 27 * 27..];
    for (found, wanted) in below.chunks_exact(3).zip(&wave(0.01)) {
        assert!(found[0].abs() + found[1].abs() + (found[2] - wanted).abs() < 1e-12, "{found:?} {wanted}");
    }
    let stress: Vec<f64> = inside.values("/fields/stress").unwrap();
    let pressure: Vec<f64> = reader.slab("/fields/pressure", 0).unwrap();
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    for (stress, pressure) in stress.chunks_exact(6).zip(&pressure) {
        assert!((stress[2] + pressure).abs() < 1e-7 * peak, "{stress:?} {pressure}");
    }
    // A field of another quantity is refused because of its unit.
    for (flags, words) in [
        ("contact --n 27 --p-star 0.1 --height 0.3 --base-displacement c.h5:/fields/pressure", "--base-displacement: "),
        ("contact --n 27 --p-star 0.1 --height 0.3 --base free --base-traction c.h5:/base/lift", "--base-traction: "),
        ("contact --n 27 --p-star 0.1 --hardness c.h5:/surface/height", "--hardness: "),
        ("punch --mask c.h5:/surface/height", "--mask: "),
        ("punch --n 27 --traction c.h5:/base/displacement", "--traction: "),
    ] {
        let output = gfmd(folder, &self::words(flags));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(words), "{text}");
        assert!(text.contains("the unit is ") && text.contains("; it must be "), "{text}");
    }
    // A moving base that does not suit the body is refused with the name of the flag.
    ndarray_npy::write_npy(folder.join("base.npy"), &wave(0.01)).unwrap();
    for (flags, words) in [
        ("--height inf --base-displacement base.npy", "--base-displacement: the displacement of the base is given"),
        ("--height 0.3 --base-traction base.npy", "--base-traction: the traction of the base is given"),
        (
            "--height 0.3 --n 9 --base-displacement base.npy",
            "the shape is [27, 27]; it must be [nx, ny] or [nx, ny, 3]",
        ),
        ("--height 0.3 --base-displacement none.npy", "--base-displacement: none.npy"),
    ] {
        let output = gfmd(folder, &self::words(&format!("contact --eps-f-inv 2 --p-star 0.05 {}", with_points(flags))));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(words), "{text}");
    }
}

fn with_points(flags: &str) -> String {
    if flags.contains("--n ") { flags.to_owned() } else { format!("--n 27 {flags}") }
}

/// Writes a table of the compliance of a body, with a header, at wavenumbers from below the cell to beyond the spacing
/// of 64 points.
fn write_compliance(folder: &std::path::Path, name: &str, head: &str, compliance: impl Fn(f64) -> f64) {
    let rows = (0..400).map(|k| 5.0 * 60.0_f64.powf(f64::from(k) / 399.0));
    let rows: String = rows.map(|q| format!("{q:e},{:e}\n", compliance(q))).collect();
    std::fs::write(folder.join(name), format!("{head}\n{rows}")).unwrap();
}

#[test]
fn a_body_from_a_table_is_the_body_that_the_table_is_of() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().chain(["--json", "-q"]).collect::<Vec<_>>());
    let head = "wavenumber,compliance";
    write_compliance(folder.path(), "half.csv", head, |q| 2.0 / q);
    let slab = gfmd_green::Body::slab(gfmd_green::Material::from_contact_modulus(1.0, 0.0).unwrap(), 0.2).unwrap();
    write_compliance(folder.path(), "slab.csv", head, |q| slab.normal_compliance(q));
    let uniform = slab.normal_compliance(0.0);
    let slab_table = format!("--e-star 1 --compliance slab.csv --uniform-compliance {uniform}");
    for (loads, further) in [
        ("contact --pressure 0.001,0.01 --statistics --flow", ""),
        ("contact --approach 0.004", ""),
        ("contact --p-star 0.05 --hardness 0.1", ""),
        ("contact --pressure 0.005 --law exponential --param gamma=2e-5,range=3e-3", ""),
        ("path --pressure 0.005,0.001 --steps 2", ""),
        ("contact --p-star 0.05 --dim 2", ""),
    ] {
        for (table, body) in
            [("--e-star 1 --compliance half.csv", "--e-star 1"), (&slab_table, "--e-star 1 --height 0.2")]
        {
            let all = |body: &str, out: &str| run(&format!("{loads} --n 32 --eps-f-inv 4 {body} {further} {out}"));
            let (found, wanted) = (all(table, "--out t.h5"), all(body, ""));
            let of = if loads.starts_with("path") { "steps" } else { "loads" };
            for (found, wanted) in found[of].as_array().unwrap().iter().zip(wanted[of].as_array().unwrap()) {
                for name in ["approach", "mean_gap", "elastic_energy", "area_fraction", "stiffness", "conductance"] {
                    let [Some(found), Some(wanted)] = [found, wanted].map(|load| load[name].as_f64()) else { continue };
                    let off = (found - wanted).abs() / wanted.abs();
                    assert!(off < 1e-4, "{loads}, {body}, {name}: {found} {wanted}");
                }
                assert!(found["area_fraction_limit"].is_null());
            }
            assert_eq!(run("check t.h5 --rerun")["differing"], 0, "{loads} {table}");
            assert!(gfmd(folder.path(), &["report", "t.h5", "-q"]).status.success());
        }
    }
}

/// A stiffness (1/2) |A q| with diagonal A equals a half-space on a cell with sides divided by the entries of A.
#[test]
fn a_table_by_direction_is_a_half_space_on_a_stretched_cell() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().chain(["--json", "-q"]).collect::<Vec<_>>());
    let angle = |j: i32| std::f64::consts::PI * f64::from(j) / 40.0;
    let waves = (0..6).flat_map(|k| (0..40).map(move |j| (5.0 * 3_f64.powi(k), angle(j))));
    let rows = waves.map(|(q, angle)| [q * angle.cos(), q * angle.sin()]);
    let rows: String = rows.map(|[x, y]| format!("{x:e},{y:e},{:e}\n", 2.0 / (2.0 * x).hypot(y))).collect();
    std::fs::write(folder.path().join("g.csv"), format!("qx [um^-1],qy [um^-1],compliance [um/MPa]\n{rows}")).unwrap();
    let surface = "surface --n 32 --eps-f-inv 8 --out h.npy";
    run(surface);
    for (loads, of) in [
        ("contact --pressure 2kPa,20kPa --statistics", "loads"),
        ("contact --approach 5nm", "loads"),
        ("contact --pressure 5kPa --law exponential --param gamma=2e-5J/m^2,range=3nm --grid-error none", "loads"),
        ("contact --pressure 50kPa --hardness 100kPa", "loads"),
        ("path --pressure 5kPa,1kPa --steps 2", "steps"),
        ("wear --pressure 5kPa --coefficient 1e-9/Pa --distance 0,10um --steps 2", "steps"),
    ] {
        let all = |body: &str| run(&format!("{loads} --surface h.npy --unit um {body}"));
        let found = all("--size 1um --e-star 1MPa --compliance g.csv --out t.h5");
        let wanted = all("--size 0.5um,1um --e-star 1MPa");
        for (found, wanted) in found[of].as_array().unwrap().iter().zip(wanted[of].as_array().unwrap()) {
            for name in ["approach", "mean_gap", "elastic_energy", "area_fraction", "stiffness", "mean_pressure"] {
                let [Some(found), Some(wanted)] = [found, wanted].map(|load| load[name].as_f64()) else { continue };
                assert!((found - wanted).abs() < 1e-6 * wanted.abs(), "{loads}, {name}: {found} {wanted}");
            }
        }
        for command in ["check t.h5", "check t.h5 --rerun"] {
            assert_eq!(run(command)["differing"], 0, "{loads}");
        }
        assert!(gfmd(folder.path(), &["report", "t.h5", "-q"]).status.success());
    }
    let mixed = "contact --n 16 --p-star 0.1 --young 1 --compliance 1:1,1:0:1";
    let reported = gfmd(folder.path(), &mixed.split_whitespace().collect::<Vec<_>>());
    assert!(String::from_utf8_lossy(&reported.stderr).contains("some rows have two numbers and some three"));
}

#[test]
fn a_body_from_a_table_has_units_and_names_what_it_does_not_have() {
    let folder = tempfile::tempdir().unwrap();
    write_compliance(folder.path(), "half.csv", "wavenumber,compliance", |q| 2.0 / q);
    write_compliance(folder.path(), "units.csv", "wavenumber [um^-1],compliance [um/MPa]", |q| 2.0 / q);
    let report = json(
        folder.path(),
        &"contact --n 32 --eps-f-inv 4 --unit um --size 1um --e-star 1MPa --compliance units.csv --pressure 5kPa \
          --json -q --out u.h5"
            .split_whitespace()
            .collect::<Vec<_>>(),
    );
    let plain = json(
        folder.path(),
        &"contact --n 32 --eps-f-inv 4 --e-star 1 --pressure 0.005 --json -q".split_whitespace().collect::<Vec<_>>(),
    );
    let [found, wanted] = [&report, &plain].map(|report| report["loads"][0]["approach"].as_f64().unwrap());
    assert!((found / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
    let table = "--n 32 --eps-f-inv 4 --p-star 0.05 --compliance half.csv";
    for (flags, words) in [
        (format!("contact {table}"), &["--young or --e-star is missing"][..]),
        (format!("contact {table} --young 1 --poisson 0.3"), &["--poisson", "left out"]),
        (format!("contact {table} --young 1 --height 0.3"), &["--height", "left out"]),
        (format!("contact {table} --young 1 --second-body 1,0"), &["--second-body", "left out"]),
        (format!("contact {table} --young 1 --boundary free"), &["--boundary", "--compliance"]),
        (format!("contact {table} --young 1 --components held"), &["--components", "--compliance"]),
        (format!("contact {table} --young 1 --finite-slope"), &["--finite-slope", "--compliance"]),
        (format!("path {table} --young 1 --friction 0.3"), &["--friction", "--compliance"]),
        (format!("path {table} --young 1 --lateral 0.01"), &["--lateral", "--compliance"]),
        (format!("path {table} --young 1 --prony 1:0.5 --time 1"), &["--prony", "--compliance"]),
        (format!("contact {table} --young 1 --uniform-compliance=-1"), &["--uniform-compliance", "-1"]),
        ("contact --n 16 --p-star 0.1 --uniform-compliance 1".into(), &["--compliance"]),
        ("contact --n 256 --p-star 0.1 --young 1 --compliance half.csv".into(), &["wavenumbers", "of the grid"]),
        ("contact --n 16 --p-star 0.1 --young 1 --compliance 1:1,2:0.5,3:-1,4:1".into(), &["--compliance", "row 3"]),
        ("contact --n 16 --p-star 0.1 --young 1 --compliance none.csv".into(), &["--compliance", "none.csv"]),
        ("body --surface u.h5 --depths 0.1".into(), &["table of compliances"]),
    ] {
        let output = gfmd(folder.path(), &flags.split_whitespace().chain(["-q"]).collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
        for word in words {
            assert!(text.contains(word), "{flags}: no {word:?} in {text}");
        }
    }
}
