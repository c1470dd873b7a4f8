//! Lines that repeat a run: of a shell, and of Python.

use std::fmt::Write as _;

use gfmd_report::quoted;
use serde_json::Value;

use super::form::Answers;

/// Returns a command line for a shell.
pub(super) fn command_line(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Keys of the measurements, which Python makes on demand from the same contact.
const MEASURED: [&str; 3] = ["statistics", "flow", "conductance"];

/// Keys of the body whose values are numbers.
const NUMBERS: [&str; 5] = ["poisson", "base_poisson", "tolerance", "stiffness_tolerance", "max_iterations"];

/// Keys of the body.
const BODY: [&str; 10] = [
    "material",
    "young",
    "poisson",
    "e_star",
    "height",
    "base",
    "base_young",
    "base_poisson",
    "second_body",
    "second_material",
];

/// Keys of `gfmd.contact` with the names that they have on the command line.
const CONTACT: [&str; 11] = [
    "boundary",
    "components",
    "hardness",
    "finite_slope",
    "grid_error",
    "accuracy",
    "solver",
    "tolerance",
    "stiffness_tolerance",
    "max_iterations",
    "stress_unit",
];

/// Keys of the loads.
const LOADS: [&str; 4] = ["pressure", "p_star", "force", "approach"];

/// Returns a text as Python writes it.
fn text(value: &str) -> String {
    format!("\"{}\"", value.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Returns a text, or a number if it is one.
fn bare(value: &str) -> String {
    let value = value.trim();
    if value.parse::<f64>().is_ok_and(f64::is_finite) { value.into() } else { text(value) }
}

/// Returns several values as a tuple, and one as itself.
fn tuple(value: &str) -> String {
    match value.split(',').map(bare).collect::<Vec<_>>() {
        one if one.len() == 1 => one.concat(),
        several => format!("({})", several.join(", ")),
    }
}

/// Returns the arguments of a step from its value: the first ones by place, the others by name.
fn arguments(value: &str, names: &[&str]) -> String {
    let parts = value.split(',').enumerate();
    let named = parts.map(|(k, part)| match names.get(k) {
        Some(name) if !name.is_empty() => format!("{name}={}", bare(part)),
        _ => bare(part),
    });
    named.collect::<Vec<_>>().join(", ")
}

/// Returns the step that crops, `.crop(x=("10um", None))`.
fn crop(value: &str) -> String {
    let end = |end: &str| if end.is_empty() { "None".into() } else { bare(end) };
    let side = |(name, range): (&str, &str)| {
        let (from, to) = range.split_once(':').unwrap_or((range, ""));
        format!("{name}=({}, {})", end(from), end(to))
    };
    let sides = ["x", "y"].into_iter().zip(value.split(',')).map(side);
    format!(".crop({})", sides.collect::<Vec<_>>().join(", "))
}

/// Returns the step that filters, `.filter(s="2.5um", kind="robust")`.
fn filter(value: &str) -> String {
    let part = |part: &str| {
        let (name, value) = part.split_once([':', '=']).unwrap_or((part, ""));
        format!("{}={}", name.trim(), bare(value))
    };
    format!(".filter({})", value.split(',').map(part).collect::<Vec<_>>().join(", "))
}

/// Function from the value of an option to the step of the preparation.
type Step = fn(&str) -> String;

/// Returns the steps of the preparation in their order.
fn preparation(answers: &Answers) -> String {
    let steps: [(&str, Step); 10] = [
        ("crop", crop),
        ("despike", |value| format!(".despike({})", arguments(value, &["", "window"]))),
        ("descar", |value| format!(".descar({})", arguments(value, &["", "", "length", "width"]))),
        ("level", |value| {
            let (lines, how) = value.split_once(':').unwrap_or((value, "median"));
            format!(".level({}, {})", text(lines), text(how))
        }),
        ("detrend", |value| if value == "none" { String::new() } else { format!(".detrend({})", text(value)) }),
        ("fill", |value| format!(".fill({})", text(value))),
        ("resample", |value| format!(".resample({})", tuple(value))),
        ("resample_spacing", |value| format!(".resample(spacing={})", bare(value))),
        ("filter", filter),
        ("periodise", |value| if value == "as-is" { String::new() } else { format!(".periodise({})", text(value)) }),
    ];
    let flip = if answers.contains_key("flip") { ".flip()" } else { "" };
    steps.iter().fold(flip.to_owned(), |lines, (key, step)| match answers.get(*key) {
        Some(Value::Bool(true)) => lines + &format!(".{key}()"),
        Some(Value::String(value)) => lines + &step(value),
        // A step that may be repeated.
        Some(Value::Array(values)) => {
            values.iter().filter_map(Value::as_str).fold(lines, |lines, one| lines + &step(one))
        }
        _ => lines,
    })
}

/// Returns the answers of some keys as arguments.
fn keywords(keys: &[&str], answers: &Answers) -> Vec<String> {
    let argument = |key: &&str| match answers.get(*key)? {
        Value::Bool(true) => Some(format!("{key}=True")),
        Value::String(value) if *key == "second_body" => Some(format!("{key}={}", tuple(value))),
        Value::String(value) if NUMBERS.contains(key) => Some(format!("{key}={}", value.trim())),
        Value::String(value) => Some(format!("{key}={}", bare(value))),
        _ => None,
    };
    keys.iter().filter_map(argument).collect()
}

/// Returns the lines of Python that repeat a contact.
///
/// # Errors
/// Returns the reason why there are none.
pub(super) fn python(scan: &str, result: &str, answers: &Answers) -> Result<String, String> {
    let read = ["channel", "unit", "size", "flip", "layer"];
    let steps = [
        "crop",
        "despike",
        "descar",
        "level",
        "detrend",
        "fill",
        "resample",
        "resample_spacing",
        "filter",
        "periodise",
    ];
    let known = |key: &str| {
        [&read[..], &steps, &BODY, &CONTACT, &LOADS].iter().any(|keys| keys.contains(&key)) || MEASURED.contains(&key)
    };
    if let Some(key) = answers.keys().find(|key| !known(key)) {
        return Err(format!("no lines of Python for --{}; the command line repeats the run", key.replace('_', "-")));
    }
    let word = |key: &str| answers.get(key).and_then(Value::as_str);
    let load = LOADS.iter().find_map(|key| Some((key, word(key)?))).ok_or("a run without a load has no lines")?;
    let values: Vec<&str> = load.1.split(',').map(str::trim).collect();
    if values.iter().any(|value| value.contains(':')) {
        return Err("no lines of Python for loads A:B:N; the command line repeats the run".into());
    }
    let mut reading = vec![text(scan)];
    reading.extend(word("channel").map(|value| format!("channel={}", text(value))));
    reading.extend(word("size").map(|value| format!("size={}", tuple(value))));
    reading.extend(word("unit").map(|value| format!("unit={}", text(value))));
    let mut body = keywords(&BODY, answers);
    if let Some(Value::Array(layers)) = answers.get("layer") {
        let layers: Vec<String> = layers.iter().filter_map(Value::as_str).map(tuple).collect();
        body.push(format!("layers=[{}]", layers.join(", ")));
    }
    let loads: Vec<String> = values.into_iter().map(bare).collect();
    let loads = if loads.len() == 1 { loads.concat() } else { format!("[{}]", loads.join(", ")) };
    let mut contact = vec!["s".to_owned(), format!("gfmd.Body({})", body.join(", ")), format!("{}={loads}", load.0)];
    contact.extend(keywords(&CONTACT, answers));
    let mut lines = String::from("import gfmd\n\n");
    let _ = writeln!(lines, "s = gfmd.read({}){}", reading.join(", "), preparation(answers));
    let _ = writeln!(lines, "c = gfmd.contact({})", contact.join(", "));
    let _ = writeln!(lines, "c.save({})", text(&result.replace(".h5", "-python.h5")));
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(pairs: &[(&str, Value)]) -> Answers {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
    }

    #[test]
    fn lines_of_python_follow_the_order_of_the_preparation() {
        let given = answers(&[
            ("size", "100um,50um".into()),
            ("unit", "m".into()),
            ("crop", "10um:,:0.5mm".into()),
            ("despike", true.into()),
            ("level", "rows:median".into()),
            ("detrend", "plane".into()),
            ("fill", "harmonic".into()),
            ("filter", "s:2.5um,kind=robust".into()),
            ("young", "70GPa".into()),
            ("poisson", "0.33".into()),
            ("layer", serde_json::json!(["1GPa,0.3,10um"])),
            ("pressure", "1MPa, 10MPa".into()),
            ("boundary", "free".into()),
        ]);
        let lines = python("a \"b\".txt", "r.h5", &given).unwrap();
        let expected = "import gfmd\n\n\
            s = gfmd.read(\"a \\\"b\\\".txt\", size=(\"100um\", \"50um\"), unit=\"m\")\
            .crop(x=(\"10um\", None), y=(None, \"0.5mm\")).despike().level(\"rows\", \"median\").detrend(\"plane\")\
            .fill(\"harmonic\").filter(s=\"2.5um\", kind=\"robust\")\n\
            c = gfmd.contact(s, gfmd.Body(young=\"70GPa\", poisson=0.33, layers=[(\"1GPa\", 0.3, \"10um\")]), \
            pressure=[\"1MPa\", \"10MPa\"], boundary=\"free\")\n\
            c.save(\"r-python.h5\")\n";
        assert_eq!(lines, expected);
    }

    #[test]
    fn options_without_lines_of_python_are_named() {
        let with = |key: &str, value: &str| answers(&[("p_star", "0.1".into()), (key, value.into())]);
        assert!(python("a", "r.h5", &with("law", "exponential")).unwrap_err().contains("--law"));
        assert!(python("a", "r.h5", &answers(&[("p_star", "0.1:0.2:3".into())])).unwrap_err().contains("A:B:N"));
        assert!(python("a", "r.h5", &with("young", "1")).is_ok());
        let mut named = with("material", "ptfe");
        named.insert("second_material".into(), "steel-s355".into());
        let lines = python("a", "r.h5", &named).unwrap();
        assert!(lines.contains("gfmd.Body(material=\"ptfe\", second_material=\"steel-s355\")"), "{lines}");
    }
}
