//! Tables of two columns, in text files that options name.

use std::fs::File;
use std::io::Read as _;

use crate::failure::Failure;

/// The largest size of a file, in bytes.
const LARGEST: u64 = 1 << 20;

/// The rows of the table in `file`, as the text of an option has them: `A:B,...`, with the units of the heads if `in_units`.
///
/// Rows are two numbers with commas, semicolons or blanks between; lines that begin with # are comments. The first line may have
/// the heads `columns`, each with a unit if there is one: `gap [nm],traction [MPa]`, `gap_nm traction_MPa`.
///
/// # Errors
/// A file that cannot be read, or is too large; a line that is no row; heads of other columns.
pub(crate) fn rows(flag: &str, file: &str, columns: [&str; 2], in_units: bool) -> Result<String, Failure> {
    let refuse = |reason: String| Failure::input(flag, format!("{file}: {reason}"));
    let mut text = String::new();
    let read = File::open(file).and_then(|opened| opened.take(LARGEST + 1).read_to_string(&mut text));
    read.map_err(|error| refuse(error.to_string()))?;
    if text.len() as u64 > LARGEST {
        return Err(refuse(format!("it has more than {LARGEST} bytes; it must have at most that many")));
    }
    let (mut units, mut rows) = ([String::new(), String::new()], Vec::new());
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let (line, is_comment) = match line.trim().strip_prefix('#') {
            Some(comment) => (comment.trim(), true),
            None => (line.trim(), false),
        };
        if line.is_empty() {
            continue;
        }
        let heads = if rows.is_empty() { heads(line, columns) } else { None };
        match (heads, is_comment) {
            (Some(found), _) => units = found,
            (None, true) => {}
            (None, false) => {
                let words = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|word| !word.is_empty());
                let words: Vec<&str> = words.collect();
                let is_row = words.len() == 2 && words.iter().all(|word| word.parse().is_ok_and(f64::is_finite));
                if !is_row {
                    let [first, second] = columns;
                    let allowed = format!("two finite numbers, {first} and {second}, or before them these heads");
                    return Err(refuse(format!("line {number} is {line:?}; it must be {allowed}")));
                }
                rows.push([words[0], words[1]].map(str::to_owned));
            }
        }
    }
    if rows.is_empty() {
        return Err(refuse("it has no row; it must have rows of two numbers".into()));
    }
    let units = if in_units { units } else { Default::default() };
    let rows: Vec<String> =
        rows.iter().map(|[first, second]| format!("{first}{}:{second}{}", units[0], units[1])).collect();
    Ok(rows.join(","))
}

/// The units in a line of heads; `None` of a line without these columns.
fn heads(line: &str, [first, second]: [&str; 2]) -> Option<[String; 2]> {
    let lower = line.to_ascii_lowercase();
    let (begin, next) = (lower.find(first)?, lower.find(second)?);
    let around = |c: char| c.is_whitespace() || ",;[](){}_:\"'".contains(c);
    let unit = |text: &str| text.trim_matches(around).trim_start_matches("/ ").to_owned();
    (begin < next).then(|| [unit(&line[begin + first.len()..next]), unit(&line[next + second.len()..])])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, in_units: bool) -> Result<String, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("law.csv");
        std::fs::write(&file, text).unwrap();
        rows("--law-table", file.to_str().unwrap(), ["gap", "traction"], in_units).map_err(|error| error.to_string())
    }

    #[test]
    fn rows_have_the_units_of_their_heads() {
        for (text, found) in [
            ("0,1\n1,0.5\n", "0:1,1:0.5"),
            ("# a law\n0 1\n\n1\t-5e-1\n", "0:1,1:-5e-1"),
            ("gap,traction\n0;1\n", "0:1"),
            ("gap [nm],traction [MPa]\n0,1\n", "0nm:1MPa"),
            ("\u{feff}Gap (nm); Traction (MPa)\r\n0; 1\r\n", "0nm:1MPa"),
            ("# gap_nm traction_N/mm^2\n0 1\n", "0nm:1N/mm^2"),
            ("\"gap / nm\",\"traction / MPa\"\n0,1\n", "0nm:1MPa"),
        ] {
            assert_eq!(of(text, true), Ok(found.into()), "{text:?}");
        }
        assert_eq!(of("gap [nm],traction [MPa]\n0,1\n", false), Ok("0:1".into()));
    }

    #[test]
    fn files_that_are_no_table_are_refused_by_their_line() {
        for (text, words) in [
            ("", "it has no row"),
            ("gap,traction\n", "it has no row"),
            ("x,y\n0,1\n", "line 1 is \"x,y\"; it must be two finite numbers, gap and traction"),
            ("0,1\n1,2,3\n", "line 2 is \"1,2,3\""),
            ("0,1\n1,nan\n", "line 2 is \"1,nan\""),
            ("0,1\ngap,traction\n", "line 2"),
            ("traction,gap\n0,1\n", "line 1"),
        ] {
            let error = of(text, true).unwrap_err();
            assert!(error.starts_with("--law-table: ") && error.contains(words), "{error}");
        }
        let large = "0,1\n".repeat(300_000);
        assert!(of(&large, true).unwrap_err().contains("it has more than 1048576 bytes"));
        assert!(
            rows("--law-table", "none.csv", ["gap", "traction"], true).unwrap_err().to_string().contains("none.csv")
        );
    }
}
