//! Numbers of a text file, in the notation of programs, Fortran and typography.

use crate::bytes::clip;

/// Words for a point without a height, in lower case.
const MISSING: [&str; 41] = [
    "nan",
    "na",
    "n/a",
    "#n/a",
    "<na>",
    "n.a.",
    "#nv",
    "#num!",
    "#value!",
    "#div/0!",
    "#ref!",
    "#name?",
    "#null!",
    "bad",
    "null",
    "(null)",
    "<null>",
    "nil",
    "none",
    "nodata",
    "no_data",
    "missing",
    "<missing>",
    "invalid",
    "undefined",
    "undef",
    "void",
    "masked",
    "over",
    "under",
    "overflow",
    "underflow",
    "n.d.",
    "nd",
    "n.v.",
    "''",
    "no data",
    "no value",
    "bad pixel",
    "out of range",
    "#n/a n/a",
];

/// Longest number, in bytes, that is rewritten before parsing.
const LONGEST: usize = 64;

/// Parses a number; not finite for a point without a height.
pub(super) fn number(word: &str, line: usize, column: usize) -> Result<f64, String> {
    if let Ok(number) = word.parse() {
        return in_range(number, word, line, column);
    }
    if is_missing(word) {
        return Ok(f64::NAN);
    }
    let rewritten = if word.len() <= LONGEST { plain(word).parse().ok() } else { None };
    let number =
        rewritten.ok_or_else(|| format!("line {line}, column {column} is {:?}; it must be a number", clip(word)))?;
    in_range(number, word, line, column)
}

/// Returns a number as it is, but refuses digits that stand for a number too large for a double.
fn in_range(number: f64, word: &str, line: usize, column: usize) -> Result<f64, String> {
    match number.is_infinite() && word.bytes().any(|byte| byte.is_ascii_digit()) {
        true => Err(format!(
            "line {line}, column {column} is {:?}, which is out of range; it must be at most {:.1e}",
            clip(word),
            f64::MAX
        )),
        false => Ok(number),
    }
}

/// Returns true for a word that denotes a point without a height, or an empty word between two separators: a word of
/// several programs, dashes, stars, question marks, or the output of C on Windows (`1.#QNAN`, `-1.#IND`, `1.#INF`).
pub(super) fn is_missing(word: &str) -> bool {
    let drawn = |mark: char| word.chars().all(|c| c == mark);
    let dashes = |c: char| matches!(c, '-' | '.' | '\u{2014}') || is_minus(c);
    word.is_empty()
        || word.chars().all(dashes) && !drawn('.')
        || drawn('*')
        || drawn('?')
        || word.trim_start_matches(['-', '+']).starts_with("1.#")
        || word.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("nan(")) && word.ends_with(')')
        || word.len() <= LONGEST && MISSING.contains(&word.trim_start_matches('-').to_ascii_lowercase().as_str())
}

/// Returns true for digits with a comma that may be decimal or group thousands: `1,234`.
pub(super) fn is_ambiguous(word: &str) -> bool {
    let mut groups = word.trim_start_matches(['-', '+']).split(',');
    let digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    groups.next().is_some_and(|first| (1..=3).contains(&first.len()) && digits(first))
        && groups.clone().next().is_some()
        && groups.all(|group| group.len() == 3 && digits(group))
}

/// Returns the unit of the last digit of a number as written: 0.01 for `1.50`, 0.1 for `2.50e1`.
pub(super) fn last_digit(word: &str) -> f64 {
    let word = word.as_bytes();
    let at = |bytes: &[u8], found: fn(u8) -> bool| bytes.iter().position(|&byte| found(byte));
    let end = at(word, |byte| matches!(byte, b'e' | b'E' | b'd' | b'D')).unwrap_or(word.len());
    let (mantissa, exponent) = word.split_at(end);
    let decimals = at(mantissa, |byte| matches!(byte, b'.' | b',')).map_or(0, |point| mantissa.len() - point - 1);
    let exponent = exponent.get(1..).and_then(|text| std::str::from_utf8(text).ok()?.parse().ok()).unwrap_or(0_i32);
    let decimals = i32::try_from(decimals).unwrap_or(i32::MAX);
    10_f64.powi(exponent.saturating_sub(decimals))
}

/// Rewrites a number in the notation of Rust and C: a decimal point for a decimal comma, the sign `-` for a typographic
/// minus, and the exponent `e` for `d` in Fortran double precision, which omits the letter before three digits.
fn plain(word: &str) -> String {
    let mut text: String = word.chars().map(|c| if is_minus(c) { '-' } else { c }).collect();
    if !text.contains('.') {
        text = text.replacen(',', ".", 1);
    }
    let is_digit = |c: char| c.is_ascii_digit();
    if let Some((mantissa, exponent)) = text.split_once(['d', 'D']) {
        return format!("{mantissa}e{exponent}");
    }
    // Sign of a three-digit exponent after a mantissa with a point: 1.0-105.
    let sign = text.char_indices().skip(1).find(|(_, c)| matches!(c, '+' | '-')).map(|(at, _)| at);
    if let Some((mantissa, exponent)) = sign.map(|at| text.split_at(at))
        && mantissa.contains('.')
        && mantissa.ends_with(|c| is_digit(c) || c == '.')
        && exponent.len() == 4
        && exponent[1..].chars().all(is_digit)
    {
        return format!("{mantissa}e{exponent}");
    }
    text
}

fn is_minus(c: char) -> bool {
    // MINUS SIGN, HYPHEN, NON-BREAKING HYPHEN, EN DASH, FULLWIDTH HYPHEN-MINUS
    matches!(c, '\u{2212}' | '\u{2010}' | '\u{2011}' | '\u{2013}' | '\u{ff0d}')
}

/// Returns true if a word is a number, denotes a missing one, or resembles a number in unsupported notation: digits of
/// any script with signs, one decimal separator or groups of three, and an exponent. Dates and times are not numbers.
pub(super) fn looks_like(word: &str) -> bool {
    if word.parse::<f64>().is_ok() || is_missing(word) {
        return true;
    }
    let is_sign = |c: char| c == '+' || c == '-' || is_minus(c);
    let word = word.trim_start_matches(is_sign);
    let letter = |c: char| matches!(c, 'e' | 'E' | 'd' | 'D' | 'q' | 'Q' | '^');
    let end = word.find(|c| letter(c) || is_sign(c)).unwrap_or(word.len());
    let (mantissa, exponent) = word.split_at(end);
    let exponent = exponent.trim_start_matches(letter).trim_start_matches(is_sign);
    let is_separator = |c: char| matches!(c, '.' | ',' | '_' | '\'' | '\u{2019}' | '\u{66b}' | '\u{66c}');
    let digits = |text: &str| text.chars().all(char::is_numeric);
    let groups: Vec<&str> = mantissa.split(is_separator).collect();
    // Groups between the first and the last have three digits.
    let between = if groups.len() > 2 { &groups[1..groups.len() - 1] } else { &[] };
    mantissa.chars().any(char::is_numeric)
        && groups.iter().all(|group| digits(group))
        && between.iter().all(|group| group.chars().count() == 3)
        && exponent.len() <= 9
        && digits(exponent)
}
