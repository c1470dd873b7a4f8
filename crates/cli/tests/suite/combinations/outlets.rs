//! JSON, HDF5 and table of a result have the same numbers; further commands read the file.

use std::collections::BTreeMap;
use std::path::Path;

use gfmd_files::Reader;
use gfmd_record::{COLUMNS, Column, Form, State, Table, heads};
use serde_json::Value;

use super::draw::{Case, Control};
use super::elastic::{Base, Top};
use super::found::Found;
use super::numbers::{largest, mean};
use crate::common::gfmd;

/// Collects the numbers of a load or a step under their names in the file. Nulls are NaN.
pub(crate) fn flat(record: &Value, at: &str, all: &mut BTreeMap<String, f64>) {
    match record {
        Value::Object(entries) => {
            for (key, value) in entries.iter().filter(|(key, _)| *key != "undefined") {
                if let ("flow", Some(kind)) = (at, key.strip_prefix("conductivity_")) {
                    // The flow along a gradient has it, not the flow across.
                    for (axis, name) in ["xx", "yy"].into_iter().enumerate() {
                        all.insert(format!("flow_{name}_{kind}"), value[axis][axis].as_f64().unwrap_or(f64::NAN));
                    }
                    continue;
                }
                let place = match (at, key.as_str()) {
                    ("patches", key) if key.starts_with("count") => key.replacen("count", "patches", 1),
                    ("patches", key) if key.starts_with("largest") => key.replacen("largest", "largest_patch", 1),
                    ("patches", "percolates") => "percolates".into(),
                    ("", key) => key.into(),
                    ("flow", "conductivity") => "flow".into(),
                    (at, key) => format!("{at}_{key}"),
                };
                flat(value, &place, all);
            }
        }
        Value::Array(entries) => {
            for (name, value) in ["x", "y"].iter().zip(entries) {
                let place = match at {
                    "flow_x" | "flow_y" => format!("{at}{name}"),
                    at if at.starts_with("mean_shear_") => at.replacen("shear", &format!("shear_{name}"), 1),
                    at => format!("{at}_{name}"),
                };
                flat(value, &place, all);
            }
        }
        Value::Bool(flag) => drop(all.insert(at.into(), f64::from(u8::from(*flag)))),
        Value::Null => drop(all.insert(at.into(), f64::NAN)),
        value => drop(all.insert(at.into(), value.as_f64().unwrap_or(f64::NAN))),
    }
}

/// Checks that JSON and file have the same numbers, with the same bits.
pub(crate) fn file(found: &mut Found, records: &[Value], file: &Reader, group: &str) {
    for (k, record) in records.iter().enumerate() {
        let mut all = BTreeMap::new();
        flat(record, "", &mut all);
        if group == "/path" {
            // The file has the largest residual only.
            let worst = all.iter().filter(|(name, _)| name.starts_with("residual")).map(|(_, value)| *value);
            let worst = worst.fold(0.0, f64::max);
            all.retain(|name, _| !name.starts_with("residual"));
            all.insert("residual".into(), worst);
        }
        for name in file.names(group) {
            let Ok(stored) = file.values::<f64>(&format!("{group}/{name}")) else { continue };
            let stored = stored[k];
            match all.remove(&name) {
                Some(reported) => {
                    let same = reported.to_bits() == stored.to_bits() || (reported.is_nan() && !stored.is_finite());
                    found.must(same, || format!("{group}/{name}[{k}] is {stored:e} in the file, {reported:e} in JSON"));
                }
                None => found.must(stored.is_nan() || name == "load" || name == "step", || {
                    format!("{group}/{name}[{k}] = {stored:e} is not in JSON")
                }),
            }
        }
        for (name, reported) in all {
            found.must(reported.is_nan() || name == "seconds", || {
                format!("{name} = {reported:e} of JSON is not in {group}")
            });
        }
    }
}

/// Number of a printed table: value, unit of its last digit, and error in brackets.
struct Shown {
    value: f64,
    unit: f64,
    error: Option<f64>,
}

impl Shown {
    /// Parses a cell such as `1.2000e-1`, `0.1014(12)`, `1230(30)`, `2.512(4)e-9` or `0.10~`; `None` for a cell without
    /// a number.
    fn of(cell: &str) -> Option<Self> {
        let cell = cell.strip_suffix('~').unwrap_or(cell);
        let (mantissa, power) = cell.split_once('e').unwrap_or((cell, "0"));
        let (mantissa, error) = match mantissa.split_once('(') {
            Some((mantissa, error)) => (mantissa, Some(error.strip_suffix(')')?)),
            None => (mantissa, None),
        };
        let scale = 10_f64.powi(power.parse().ok()?);
        let last = scale * 10_f64.powi(-(mantissa.split_once('.').map_or(0, |(_, digits)| digits.len()) as i32));
        // Errors have one digit, or two that begin with 1; trailing zeros only pad whole numbers.
        let zeros = error.map_or(0, |error| error.len() - error.len().min(1 + usize::from(error.starts_with('1'))));
        let value = scale * mantissa.parse::<f64>().ok().filter(|value| value.is_finite())?;
        let error = error.map(|error| Some(last * error.parse::<f64>().ok()?));
        Some(Self { value, unit: last * 10_f64.powi(zeros as i32), error: error.flatten() })
    }
}

/// Checks the limits of numbers on fine grids: each bounds the error of its number, or both lack a value.
pub(crate) fn limits(found: &mut Found, record: &Value) {
    let named = |name: &str| COLUMNS.iter().find(|column| column.name == name).map(|column| column.json);
    for number in COLUMNS.iter().filter_map(Column::limit_of) {
        let names = ["", "_limit", "_limit_error", "_grid_error"].map(|end| format!("{number}{end}"));
        let [number, limit, error, bound] = names.each_ref().map(|name| named(name).unwrap_or_default());
        if record.pointer(&format!("/{}", limit.replace('.', "/"))).is_none() {
            continue;
        }
        let of = |key: &str| super::found::number(record, key);
        if of(limit).is_nan() {
            names[1..].iter().for_each(|name| found.null(record, name));
        } else {
            let expected = (of(number) - of(limit)).abs() + of(error);
            found.near(bound, of(bound), expected, 1e-14 * of(number).abs());
            found.must(of(error) >= 0.0, || format!("{error} is {:e}", of(error)));
        }
    }
}

/// Checks the rows of the printed table, cell by cell below the heads. Rows of a path begin with their number.
pub(crate) fn table(found: &mut Found, text: &str, records: &[Value], is_path: bool) {
    let tables: &[Table] = if is_path { &[Table::State, Table::Energy] } else { &[Table::State] };
    let all: Vec<_> = tables.iter().flat_map(|table| heads::<State>(*table)).collect();
    let joined = |word: &str| word.replace(' ', "-");
    let join =
        |line: &str| all.iter().fold(line.to_owned(), |line, (_, head)| line.replace(head.word, &joined(head.word)));
    let lines: Vec<String> = text.lines().map(join).collect();
    let is_head = |line: &String| ["pressure", "steps", "residual"].iter().all(|name| line.contains(name));
    let Some(head) = lines.iter().position(is_head) else { return found.complain("no table".into()) };
    let shown: Vec<&str> = lines[head].split_whitespace().collect();
    for (k, record) in records.iter().enumerate() {
        limits(found, record);
        let row: Vec<&str> = lines.get(head + 1 + k).map_or("", String::as_str).split_whitespace().collect();
        for (column, head) in &all {
            let (at, name, key) = (column, joined(head.word), column.json);
            let reported = super::found::number(record, key);
            let Some(column) = shown.iter().position(|head| *head == name) else {
                let nothing = reported.is_nan() || (head.form == Form::SizeUnlessZero && reported == 0.0);
                found.must(nothing, || format!("the table has no {name}, {reported:e} in JSON of row {k}"));
                continue;
            };
            let cell = row.get(column + usize::from(is_path)).copied().unwrap_or_default();
            match Shown::of(cell) {
                Some(Shown { value, unit, error }) => {
                    // An error belongs to the limit on fine grids, which replaces the number.
                    let [limit, of_limit] = ["_limit", "_limit_error"].map(|end| {
                        let limit = COLUMNS.iter().find(|other| other.name == format!("{}{end}", at.name));
                        limit.map_or(f64::NAN, |limit| super::found::number(record, limit.json))
                    });
                    let reported = if error.is_some() { limit } else { reported };
                    found.near(&format!("{name} in row {k} of the table"), value, reported, 0.5001 * unit);
                    if let Some(error) = error {
                        found.near(&format!("error of {name} in row {k} of the table"), error, of_limit, 0.5001 * unit);
                    }
                }
                None => found.must(reported.is_nan(), || {
                    format!("{name} in row {k} of the table is '{cell}', {reported:e} in JSON")
                }),
            }
        }
    }
}

/// Reads the arrays of a VTK file with 64-bit numbers by name, as `[x, y]` with x the slower index, component after
/// component.
fn arrays(bytes: &[u8], n: [usize; 2]) -> BTreeMap<String, Vec<Vec<f64>>> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = bytes.windows(mark.len()).position(|part| part == mark).unwrap();
    let header = String::from_utf8_lossy(&bytes[..start]);
    let data = &bytes[start + mark.len()..];
    let word = |at: usize| <[u8; 8]>::try_from(&data[at..at + 8]).unwrap();
    let mut found = BTreeMap::new();
    for element in header.split("<DataArray ").skip(1).filter(|element| element.starts_with("type=\"Float64\"")) {
        let of = |key: &str| element.split(&format!("{key}=\"")).nth(1).and_then(|rest| rest.split('"').next());
        let (name, at) = (of("Name").unwrap_or("points"), of("offset").unwrap().parse::<usize>().unwrap());
        let components: usize = of("NumberOfComponents").unwrap_or("1").parse().unwrap();
        assert_eq!(u64::from_le_bytes(word(at)) as usize, 8 * components * n[0] * n[1], "{name}");
        let value = |index: usize| f64::from_le_bytes(word(at + 8 + 8 * index));
        let component = |c: usize| {
            let points = (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| j * n[0] + i));
            points.map(|point| value(point * components + c)).collect()
        };
        found.insert(name.to_owned(), (0..components).map(component).collect());
    }
    found
}

/// Checks that the numbers of a VTK file equal the last load in HDF5, to the last bit.
pub(crate) fn vtk(found: &mut Found, case: &Case, bytes: &[u8], file: &Reader) {
    let (plane, last) = (case.plane, case.loads.len() - 1);
    let all = arrays(bytes, plane.n);
    let fields = file.names("/fields").into_iter().filter(|name| !file.is_coordinate(&format!("/fields/{name}")));
    let mut wanted: BTreeMap<String, Vec<f64>> =
        fields.map(|name| (name.clone(), file.slab(&format!("/fields/{name}"), last).unwrap())).collect();
    wanted.insert("height".into(), file.values("/surface/height").unwrap());
    for (name, values) in &wanted {
        let same = all.get(name).is_some_and(|reported| reported.len() == 1 && reported[0] == *values);
        found.must(same, || format!("the {name} of VTK is not that of the file"));
    }
    let repulsion = wanted.get("repulsion").or(wanted.get("pressure")).cloned().unwrap_or_default();
    let contact: Vec<f64> = repulsion.iter().map(|p| f64::from(u8::from(*p > 0.0))).collect();
    found.must(all.get("contact").is_some_and(|reported| reported[0] == contact), || "the contact of VTK".into());
    // Polygons lie on the displaced points.
    if let Some(points) = all.iter().find(|(_, components)| components.len() == 3).map(|(_, components)| components) {
        for (axis, name) in ["x", "y"].into_iter().enumerate() {
            let moved = wanted.get(&format!("displacement_{name}"));
            for (place, reported) in points[axis].iter().enumerate() {
                let index = [place / plane.n[1], place % plane.n[1]][axis] as f64;
                let at = index * plane.spacing()[axis] + moved.map_or(0.0, |moved| moved[place]);
                found.near(&format!("{name} of a point of VTK"), *reported, at, 1e-12 * plane.length[axis]);
            }
        }
    }
    let names: Vec<&String> = all
        .iter()
        .filter(|(name, reported)| reported.len() == 1 && !wanted.contains_key(*name))
        .map(|(name, _)| name)
        .collect();
    found.must(names == ["contact"], || format!("VTK has {names:?} beside the fields"));
}

/// Checks that the gap is open at the lower of the two loads of a threshold, and closed at the other.
pub(crate) fn threshold(found: &mut Found, case: &Case, folder: &Path, report: &Value) {
    let key = if case.control == Control::Approach { "approach" } else { "mean_pressure" };
    for axis in [0, 1] {
        let reported = &report["flow_threshold"][axis][key];
        if reported.is_null() {
            continue;
        }
        let mut words: Vec<String> =
            case.words.iter().filter(|word| *word != "--flow-threshold" && *word != "--flow").cloned().collect();
        let flags = ["--pressure", "--p-star", "--approach"];
        let at = words.iter().position(|word| flags.contains(&word.as_str())).unwrap();
        words.splice(
            at..at + 2,
            [
                if key == "approach" { "--approach" } else { "--pressure" }.to_owned(),
                format!("{},{}", reported[0], reported[1]),
            ],
        );
        words.extend(["--flow", "--json", "-q", "--threads", "1"].map(str::to_owned));
        let output = gfmd(folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
        let Ok(again) = serde_json::from_slice::<Value>(&output.stdout) else {
            found.complain(format!("the loads of a threshold: {}", String::from_utf8_lossy(&output.stderr)));
            continue;
        };
        let through = [0, 1].map(|load| again["loads"][load]["flow"]["percolates"][axis] == true);
        found.must(through == [true, false], || {
            format!("the gap is open along {axis} at the loads of its threshold: {through:?}")
        });
    }
}

/// Runs one further command on the file of the result, which the words `first` made.
pub(crate) fn further(found: &mut Found, case: &Case, folder: &Path, (out, first): (&str, &[String]), report: &Value) {
    let mut words: Vec<String> = case.further.split_whitespace().map(str::to_owned).collect();
    let Some(command) = words.first().cloned() else { return };
    let depths = ["0", "0.05", "0.2"];
    match command.as_str() {
        "resume" => {
            words = first.to_vec();
            words.extend(["--resume", "--json", "-q", "--out", out].map(str::to_owned));
        }
        "check" => words.extend([out, "--json", "-q"].map(str::to_owned)),
        "report" => words.extend([out, "--json", "-q", "--out", &format!("{out}.html")].map(str::to_owned)),
        _ => {
            let list = depths.join(",");
            let all = ["--surface", out, "--depths", &list, "--json", "-q", "--out", &format!("{out}.body.h5")]
                .map(str::to_owned);
            words.extend(all);
            words.extend(["--quantities", "displacement,strain,stress,von-mises,energy-density"].map(str::to_owned));
        }
    }
    words.extend(["--threads", "1"].map(str::to_owned));
    let output = gfmd(folder, &words.iter().map(String::as_str).collect::<Vec<_>>());
    let reported = String::from_utf8_lossy(&output.stderr);
    let text = String::from_utf8_lossy(&output.stdout);
    let status = output.status.code();
    match command.as_str() {
        "resume" => {
            found.must(status == Some(0), || format!("--resume of a complete file: status {status:?}: {reported}"));
            let Ok(again) = serde_json::from_str::<Value>(&text) else {
                return found.complain("--resume: no JSON".into());
            };
            let key = if case.is_path { "steps" } else { "loads" };
            let without = |report: &Value| {
                let mut records = report[key].clone();
                for record in records.as_array_mut().unwrap() {
                    record.as_object_mut().unwrap().remove("seconds");
                }
                records
            };
            found.must(without(&again) == without(report), || "--resume has other numbers".into());
        }
        "check" => {
            let parsed = serde_json::from_str::<Value>(&text).unwrap_or_default();
            found.must(status == Some(0) && parsed["differing"] == 0, || {
                format!("{}: status {status:?}, {}{}", words.join(" "), parsed["differences"], reported.trim_end())
            });
        }
        "report" => found.must(status == Some(0), || format!("report: status {status:?}: {reported}")),
        _ if case.is_free || case.has_lower || matches!(&case.moved, Some((_, true))) => {
            let one = status == Some(2) && reported.trim_end().lines().count() == 1;
            found.must(one, || format!("body: status {status:?}: {reported}"));
        }
        _ => match status {
            Some(0) => {
                let file = Reader::open(folder.join(format!("{out}.body.h5"))).unwrap();
                let result = Reader::open(folder.join(out)).unwrap();
                body(found, case, &result, &file, &serde_json::from_str(&text).unwrap());
            }
            // A second body, layers and moved bases have their own limits, reported on one line.
            Some(2) => {
                found.must(reported.trim_end().lines().count() == 1, || format!("body: {reported}"));
                let refused =
                    case.moved.is_some() || case.body.first.height() < 0.2 && case.body.first.base != half_space(case);
                found.must(refused, || format!("body is refused: {reported}"));
            }
            _ => found.complain(format!("body: status {status:?}: {reported}")),
        },
    }
}

fn half_space(case: &Case) -> Base {
    match case.body.first.base {
        Base::HalfSpace(..) => case.body.first.base,
        _ => Base::HalfSpace(f64::NAN, f64::NAN),
    }
}

/// Checks the stress below the surface: in balance at every depth, and the sum of the waves of the pressure.
pub(crate) fn body(found: &mut Found, case: &Case, result: &Reader, file: &Reader, report: &Value) {
    let plane = case.plane;
    let last = result.shape("/fields/pressure").unwrap()[0] - 1;
    let pressure = result.slab::<f64>("/fields/pressure", last).unwrap();
    let is_pushed = result.contains("/fields/shear_x");
    let stress = file.values::<f64>("/fields/stress").unwrap();
    let tensor = if case.is_line { 4 } else { 6 };
    let levels = report["levels"].as_array().unwrap();
    let size = plane.len() * tensor;
    found.must(stress.len() == levels.len() * size, || format!("{} stresses", stress.len()));
    let (most, mean_pressure) = (largest(&pressure), mean(&pressure));
    // Even numbers of points have shortest waves without a sine; their lateral tractions are left out differently in
    // program and test.
    let is_exact = plane.n.iter().all(|n| n % 2 == 1) && case.moved.is_none() && !case.is_steep;
    let parts = plane.transform(&pressure);
    for (level, reported) in levels.iter().enumerate() {
        let depth = reported["depth"].as_f64().unwrap();
        let lower = reported["side"] == "below";
        let of = |place: usize, c: usize| stress[level * size + place * tensor + c];
        let zz = 2;
        let field = |c: usize| (0..plane.len()).map(|place| of(place, c)).collect::<Vec<f64>>();
        let [zz_field, xz_field] = [field(zz), field(if case.is_line { 3 } else { 4 })];
        if case.components != super::draw::Components::Held {
            found.near(&format!("mean of sigma_zz at the depth {depth}"), mean(&zz_field), -mean_pressure, 1e-7 * most);
        }
        let is_sheared = is_pushed || case.is_steep || case.components == super::draw::Components::Held;
        if !is_sheared {
            found.near(&format!("mean of sigma_xz at the depth {depth}"), mean(&xz_field), 0.0, 1e-7 * most);
        }
        if depth == 0.0 && !case.is_steep && is_exact {
            let apart = zz_field.iter().zip(&pressure).map(|(s, p)| (s + p).abs()).fold(0.0, f64::max);
            found.near("sigma_zz less the pressure at the surface", apart, 0.0, 1e-6 * most);
            if !is_sheared {
                found.near("shear of the surface", largest(&xz_field), 0.0, 1e-6 * most);
            }
        }
        if !is_exact || is_sheared {
            continue;
        }
        // Wave by wave.
        let mut modes = vec![vec![[0.0; 2]; plane.len()]; 6];
        for place in 0..plane.len() {
            let [x, y] = plane.wave(place);
            let q = x.hypot(y);
            let p = parts[place];
            if q == 0.0 {
                let nu = layer_at(case, depth, lower).poisson;
                let sideways = -p[0] * nu / (1.0 - nu);
                modes[0][place][0] = sideways;
                modes[1][place][0] = sideways;
                modes[2][place][0] = -p[0];
                continue;
            }
            let solved = case.body.first.solve(q, Top::Pressed);
            let wave = solved.at(depth, lower);
            let nu = layer_at(case, depth, lower).poisson;
            let across = nu * (wave.sxx + wave.szz);
            let n = [x / q, y / q];
            let even = [
                n[0] * n[0] * wave.sxx + n[1] * n[1] * across,
                n[1] * n[1] * wave.sxx + n[0] * n[0] * across,
                wave.szz,
            ];
            for (c, value) in even.into_iter().enumerate() {
                modes[c][place] = [value * p[0], value * p[1]];
            }
            // A sine is -i: yz, xz.
            for (c, n) in [(3, n[1]), (4, n[0])] {
                modes[c][place] = [n * wave.sxz * p[1], -n * wave.sxz * p[0]];
            }
            let xy = n[0] * n[1] * (wave.sxx - across);
            modes[5][place] = [xy * p[0], xy * p[1]];
        }
        let expected: Vec<Vec<f64>> = modes.iter().map(|modes| plane.inverse(modes)).collect();
        let columns: Vec<usize> = if case.is_line { vec![0, 1, 2, 4] } else { (0..6).collect() };
        let columns = if case.is_line { vec![0, 1, 2, 4] } else { columns };
        let names = ["xx", "yy", "zz", "yz", "xz", "xy"];
        // Components of a line: xx, yy, zz, xz.
        for (c, component) in columns.into_iter().enumerate() {
            let apart = field(c).iter().zip(&expected[component]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            found.near(&format!("sigma_{} at the depth {depth}", names[component]), apart, 0.0, 1e-6 * most);
        }
        let mises: Vec<f64> = (0..plane.len())
            .map(|at| {
                let [xx, yy, zz, yz, xz, xy] = [0, 1, 2, 3, 4, 5].map(|c| expected[c][at]);
                let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
                (0.5 * normal + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
            })
            .collect();
        found.near(
            &format!("max_von_mises at the depth {depth}"),
            super::found::number(reported, "max_von_mises"),
            largest(&mises),
            1e-6 * most,
        );
        let layer = layer_at(case, depth, lower);
        // An incompressible body stores no energy under uniform pressure, except for rounding of the squares.
        let (density, squares): (Vec<f64>, Vec<f64>) = (0..plane.len())
            .map(|at| {
                let [xx, yy, zz, yz, xz, xy] = [0, 1, 2, 3, 4, 5].map(|c| expected[c][at]);
                let (nu, trace) = (layer.poisson, xx + yy + zz);
                let square = xx * xx + yy * yy + zz * zz + 2.0 * (yz * yz + xz * xz + xy * xy);
                (((1.0 + nu) * square - nu * trace * trace) / (2.0 * layer.young), square / layer.young)
            })
            .unzip();
        let scale = largest(&density).max(1e-9 * largest(&squares));
        // The energy of a relaxing body depends on all earlier loads.
        if reported["mean_energy_density"].is_null() && !file.contains("/fields/energy_density") {
            continue;
        }
        let reported = super::found::number(reported, "mean_energy_density");
        found.near(&format!("mean_energy_density at the depth {depth}"), reported, mean(&density), 1e-6 * scale);
    }
}

fn layer_at(case: &Case, depth: f64, lower: bool) -> super::elastic::Layer {
    let mut top = 0.0;
    for layer in &case.body.first.layers {
        let bottom = top + layer.height;
        if depth < bottom - 1e-12 || (!lower && depth <= bottom + 1e-12) {
            return *layer;
        }
        top = bottom;
    }
    match (case.body.first.base, case.body.first.layers.last()) {
        (Base::HalfSpace(young, poisson), _) => super::elastic::Layer { young, poisson, height: f64::INFINITY },
        (_, Some(last)) => *last,
        _ => case.body.top(),
    }
}
