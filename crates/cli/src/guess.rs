//! Repairs command lines as first typed: brings words into the form that the parser reads, and suggests replacements
//! for unknown options.

use std::path::Path;

use crate::kinds::kinds;
use clap::{Arg, Command};
use gfmd_input::failure::Failure;
use gfmd_input::units::Word;
use gfmd_unit::Quantity;

/// Flag of the surface.
const SURFACE: &str = "--surface";

/// Other names for options, and the existing flags.
const OTHER_NAMES: &[(&[&str], &str)] = &[
    (&["nu", "poisson-ratio", "poissons-ratio"], "poisson"),
    (&["e", "modulus", "young-modulus", "youngs-modulus", "elastic-modulus"], "young"),
    (&["estar", "contact-modulus", "reduced-modulus"], "e-star"),
    (&["normal-force", "load", "weight"], "force"),
    (&["mean-pressure", "stress", "nominal-pressure"], "pressure"),
    (&["reduced-pressure", "pstar"], "p-star"),
    (&["indentation", "penetration", "disp", "depth"], "approach"),
    (&["cell", "lx", "physical-size"], "size"),
    (&["input", "file", "topography", "heights", "scan"], "surface"),
    (&["output", "o", "save"], "out"),
    (&["rms-slope", "slope", "hrms-prime"], "rms-gradient"),
    (&["rms", "hrms", "sq", "rms-roughness"], "rms-height"),
    (&["h", "hurst-exponent"], "hurst"),
    (&["points", "grid", "resolution", "nx", "size-of-grid"], "n"),
    (&["rtol"], "tolerance"),
    (&["iterations", "maxiter"], "max-iterations"),
    (&["speed"], "velocity"),
    (&["units", "length-unit"], "unit"),
    (&["bc", "boundaries", "boundary-conditions"], "boundary"),
    (&["cores", "jobs", "num-threads"], "threads"),
    (&["thickness"], "height"),
    (&["mu", "friction-coefficient"], "friction"),
    (&["adhesion", "potential", "interaction"], "law"),
];

/// Options unknown to a command, the commands (all if empty), and the replacement to suggest.
const INSTEAD: &[(&[&str], &[&str], &str)] = &[
    (
        &["prony", "time", "relaxes"],
        &["contact"],
        "a body that relaxes is followed in time: gfmd path --prony 1s:0.5 --pressure 1MPa --time 0,10s",
    ),
    (
        &["gamma", "work-of-adhesion", "surface-energy"],
        &["contact", "path", "slide"],
        "write a law and its parameters: --law exponential --param gamma=0.05J/m^2,range=5nm",
    ),
    (&["gap-conductance", "gas-conductance", "air"], &["contact", "path"], "write --gas air --unit um"),
    (&["leak", "leakage", "leak-rate"], &["contact", "path"], "write --flow --viscosity 1mPa*s --pressure-drop 1bar"),
];

/// Returns true if an option has this long name, or had it once.
fn has_long(option: &Arg, name: &str) -> bool {
    option.get_long() == Some(name) || option.get_all_aliases().is_some_and(|names| names.contains(&name))
}

/// Returns the option with this long name, or with this former name.
fn find<'a>(commands: &[&'a Command], name: &str) -> Option<&'a Arg> {
    commands.iter().flat_map(|command| command.get_arguments()).find(|arg| has_long(arg, name))
}

/// Returns the largest number of values of an option.
fn most_values(arg: &Arg) -> usize {
    match (arg.get_action().takes_values(), arg.get_num_args()) {
        (true, Some(range)) => range.max_values(),
        (takes, _) => usize::from(takes),
    }
}

/// Returns true if the last number of a value has no unit and `word` is a unit, as in `1 MPa`.
fn is_unit_of(value: &str, word: &str) -> bool {
    let [last, first] = [value.rsplit([',', ':', '=']).next(), word.split([',', ':']).next()];
    let (last, first) = (last.unwrap_or_default(), first.unwrap_or_default());
    last.trim().parse::<f64>().is_ok()
        && first.starts_with(|c: char| !c.is_ascii_digit())
        && matches!(Quantity::parse(&format!("{last} {first}")), Ok(Some(_)))
}

/// Returns true if a value begins with the minus sign of a number.
fn is_negative(word: &str) -> bool {
    word.strip_prefix('-').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
}

/// Returns true if a word names a file and is not a number.
fn is_file(word: &str) -> bool {
    word.parse::<f64>().is_err() && Path::new(word).exists()
}

/// Returns true if a word begins like a number.
fn begins_as_number(word: &str) -> bool {
    is_negative(word) || word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+'))
}

/// Returns the words of a command line, starting with the program, in the form that the parser reads: a file alone is
/// the surface, a number and its unit are one value, a value that begins with minus belongs to its flag, and a flag has
/// its present name.
///
/// # Errors
/// Returns an error for an unknown option with a known replacement, or for values separated by spaces.
pub(crate) fn understood(command: &Command, words: &[String]) -> Result<Vec<Word>, Failure> {
    let plain = |word: &String| Word::plain(word.as_str());
    let place = words.iter().position(|word| command.find_subcommand(word).is_some());
    let Some((place, sub)) = place.and_then(|place| Some((place, command.find_subcommand(&words[place])?))) else {
        return Ok(words.iter().map(plain).collect());
    };
    let mut out: Vec<Word> = words[..=place].iter().map(plain).collect();
    let mut rest = words.iter().skip(place + 1).cloned();
    // Flag waiting for values, and their number; option of the last word if that is a value.
    let mut open: Option<(&Arg, usize)> = None;
    let mut last: Option<&Arg> = None;
    for word in rest.by_ref() {
        if word == "--" {
            out.push(Word::plain(word));
            break;
        }
        if let Some(name) = word.strip_prefix("--").filter(|name| !name.is_empty()) {
            let (name, value) = name.split_once('=').map_or((name, None), |(name, value)| (name, Some(value)));
            let Some(arg) = find(&[sub, command], name) else {
                if let Some(hint) = hint(command, sub, name) {
                    return Err(Failure::refused(format!("unexpected argument '--{name}' found; {hint}")));
                }
                // The parser reports it.
                out.push(Word::plain(word));
                break;
            };
            (open, last) = match value {
                Some(_) => (None, Some(arg)),
                None => (Some((arg, most_values(arg))).filter(|(_, most)| *most > 0), None),
            };
            // A former name becomes the present one, which messages and files have.
            let long = arg.get_long().unwrap_or(name);
            out.push(match value {
                Some(value) => Word::value(arg.get_id().as_str(), &format!("--{long}="), value),
                None => Word::plain(format!("--{long}")),
            });
            continue;
        }
        let quantity = last.filter(|arg| kinds().contains_key(arg.get_id().as_str()));
        // Further values of a numeric option must be numbers.
        if quantity.is_some() && (!begins_as_number(&word) || is_file(&word)) {
            open = None;
        }
        if let (Some(arg), Some(value)) = (quantity, out.last_mut())
            && is_unit_of(value.text(), &word)
        {
            one_unit(arg, value.text(), &word)?;
            value.append(&format!(" {word}"));
        } else if let Some((arg, most)) = open.take() {
            if word.starts_with('-') && word.len() > 1 && !is_negative(&word) {
                // Short flag.
                out.push(Word::plain(word));
                last = None;
                continue;
            }
            let is_joined = is_negative(&word) && last.is_none() && (most == 1 || word.contains(','));
            let flag = out.pop_if(|_| is_joined).map_or_else(String::new, |flag| format!("{}=", flag.text()));
            out.push(Word::value(arg.get_id().as_str(), &flag, &word));
            (last, open) = (Some(arg), (most > 1).then_some((arg, most - 1)));
        } else if word.starts_with('-') || sub.get_positionals().next().is_some() {
            out.push(Word::plain(word));
            last = None;
        } else {
            alone(sub, last, &out, &word)?;
            out.extend([Word::plain(SURFACE), Word::value("surface", "", &word)]);
            last = None;
        }
    }
    out.extend(rest.map(Word::plain));
    Ok(out)
}

/// Refuses a list with a unit on its last number only, in a separate word, as in `1,2 MPa`.
fn one_unit(arg: &Arg, value: &str, word: &str) -> Result<(), Failure> {
    let entries = value.rsplit('=').next().unwrap_or_default();
    let bare = |entry: &str| entry.trim().parse::<f64>().is_ok_and(|number| number != 0.0);
    let unit = word.split([',', ':']).next().unwrap_or_default();
    match entries.split([',', ':']).rev().skip(1).any(bare) {
        false => Ok(()),
        true => Err(Failure::value(
            format!("--{}", arg.get_long().unwrap_or_default()),
            format!("{entries} {word}"),
            format!("numbers with a unit each, as in 1{unit},2{unit}"),
        )),
    }
}

/// Refuses a word that is not an option, a value or a surface. `last` is the option of the last word `before` it, if
/// that is a value.
fn alone(sub: &Command, last: Option<&Arg>, before: &[Word], word: &str) -> Result<(), Failure> {
    let name = sub.get_name();
    let surface = before.iter().filter_map(Word::given).find(|(key, _)| *key == "surface").map(|(_, file)| file);
    let value = before.last().and_then(Word::given).map(|(_, value)| value);
    let is_number = begins_as_number(word);
    let is_like_file = is_file(word) || word.contains(['.', '/', '\\']);
    let reason = match (last, value) {
        (Some(arg), Some(value)) if is_number && !is_file(word) => {
            let flag = arg.get_long().unwrap_or_default();
            format!("unexpected argument '{word}' found; separate values by commas: --{flag} {value},{word}")
        }
        (Some(arg), Some(value)) if !is_like_file && kinds().contains_key(arg.get_id().as_str()) => {
            let flag = arg.get_long().unwrap_or_default();
            let error = Quantity::parse(&format!("1 {word}")).err();
            let reason = error.map_or_else(|| "a value has one unit".to_owned(), |error| error.to_string());
            format!("--{flag}: \"{value} {word}\": {reason}")
        }
        _ => match (find(&[sub], "surface"), surface) {
            (Some(_), None) => return Ok(()),
            (Some(_), Some(surface)) => {
                let second = match find(&[sub], "lower-surface") {
                    Some(_) => "; a second rough surface is --lower-surface or --second-surface FILE",
                    None => "",
                };
                format!("unexpected argument '{word}' found; the surface is {surface}{second}")
            }
            (None, _) if find(&[sub], "config").is_some() => {
                format!("unexpected argument '{word}' found; write --config {word}")
            }
            (None, _) => format!(
                "unexpected argument '{word}' found; gfmd {name} reads no surface, gfmd contact and gfmd surface do"
            ),
        },
    };
    Err(Failure::refused(reason))
}

/// Returns the replacement for the option `name`, which the command `sub` lacks.
fn hint(command: &Command, sub: &Command, name: &str) -> Option<String> {
    let name = name.to_lowercase().replace('_', "-");
    let has = |flag: &str| find(&[sub, command], flag).is_some();
    if has(&name) {
        return Some(format!("write --{name}"));
    }
    let instead = INSTEAD.iter().find(|(names, commands, _)| {
        names.contains(&&*name) && (commands.is_empty() || commands.contains(&sub.get_name()))
    });
    if let Some((.., instead)) = instead {
        return Some((*instead).into());
    }
    let other = OTHER_NAMES.iter().find(|(names, flag)| names.contains(&&*name) && has(flag));
    if let Some((_, flag)) = other {
        return Some(format!("write --{flag}"));
    }
    let others: Vec<_> =
        command.get_subcommands().filter(|other| find(&[other], &name).is_some()).map(Command::get_name).collect();
    (!others.is_empty()).then(|| format!("it is an option of gfmd {}", others.join(", ")))
}
