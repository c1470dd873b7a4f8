//! Tables of two or three columns in text files that options name.

use gfmd_files::input;
use gfmd_problem::key;

use crate::failure::Failure;

/// Reads the rows of the table in `file`, as the text of an option: `A:B,...`, with the units of the heads if
/// `in_units`.
///
/// Rows are numbers separated by commas, semicolons or blanks; lines that begin with # are comments. The first line may
/// have heads, one of the lists in `columns`, each with an optional unit: `gap [nm],traction [MPa]` or
/// `gap_nm traction_MPa`. Without heads, a row has as many numbers as one of the lists.
///
/// # Errors
/// Returns an error if the file is unreadable, not regular or too large, a line is not a row, or heads are unknown.
pub(crate) fn rows(option: &str, file: &str, columns: &[&[&str]], in_units: bool) -> Result<String, Failure> {
    let refuse = |reason: String| Failure::input(key(option), format!("{file}: {reason}"));
    let text = input::text(file).map_err(|error| refuse(error.to_string()))?;
    // Columns, once they are known, and their units.
    let (mut known, mut units, mut rows) = (None, Vec::new(), Vec::new());
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let (line, is_comment) = match line.trim().strip_prefix('#') {
            Some(comment) => (comment.trim(), true),
            None => (line.trim(), false),
        };
        if line.is_empty() {
            continue;
        }
        let found =
            columns.iter().filter(|_| rows.is_empty()).find_map(|names| Some((names.len(), heads(line, names)?)));
        match (found, is_comment) {
            (Some((count, found)), _) => (known, units) = (Some(count), found),
            (None, true) => {}
            (None, false) => {
                let words = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|word| !word.is_empty());
                let words: Vec<&str> = words.collect();
                let may_have = |names: &&&[&str]| names.len() == known.unwrap_or(words.len());
                let fits = columns.iter().find(may_have).is_some_and(|names| names.len() == words.len());
                if !fits || !words.iter().all(|word| word.parse().is_ok_and(f64::is_finite)) {
                    return Err(refuse(format!("line {number} is {line:?}; it must be {}", allowed(columns, known))));
                }
                known = Some(words.len());
                rows.push(words.into_iter().map(str::to_owned).collect::<Vec<_>>());
            }
        }
    }
    if rows.is_empty() {
        return Err(refuse("it has no row; it must have rows of numbers".into()));
    }
    let unit = |column: usize| units.get(column).filter(|_| in_units).map_or("", String::as_str);
    // A blank keeps the 1 of `1/m` apart from the digits of the number.
    let blank = |unit: &str| if unit.starts_with('1') { " " } else { "" };
    let entry = |(column, number): (usize, &String)| format!("{number}{}{}", blank(unit(column)), unit(column));
    let row = |row: &Vec<String>| row.iter().enumerate().map(entry).collect::<Vec<_>>().join(":");
    Ok(rows.iter().map(row).collect::<Vec<_>>().join(","))
}

/// Describes the rows that a table may have.
fn allowed(columns: &[&[&str]], known: Option<usize>) -> String {
    let of = |names: &&&[&str]| known.is_none_or(|count| names.len() == count);
    let lists = columns.iter().filter(of).map(|names| match names {
        [first, second] => format!("two finite numbers, {first} and {second}"),
        names => format!("{} finite numbers, {}", names.len(), names.join(", ")),
    });
    format!("{}, or before them these heads", lists.collect::<Vec<_>>().join(", or "))
}

/// Returns the units in a line of heads; `None` if it does not have these columns in this order.
fn heads(line: &str, names: &[&str]) -> Option<Vec<String>> {
    let lower = line.to_ascii_lowercase();
    let around = |c: char| c.is_whitespace() || ",;[](){}_:\"'".contains(c);
    let unit = |text: &str| text.trim_matches(around).trim_start_matches("/ ").to_owned();
    let (mut ends, mut starts) = (Vec::new(), Vec::new());
    for name in names {
        let from = ends.last().copied().unwrap_or(0);
        let begin = from + lower[from..].find(name)?;
        starts.push(begin);
        ends.push(begin + name.len());
    }
    starts.push(line.len());
    Some(ends.iter().zip(&starts[1..]).map(|(end, next)| unit(&line[*end..*next])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, in_units: bool) -> Result<String, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("law.csv");
        std::fs::write(&file, text).unwrap();
        rows("law_table", file.to_str().unwrap(), &[&["gap", "traction"]], in_units).map_err(|error| error.to_string())
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
    fn a_table_may_have_one_of_several_lists_of_columns() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("g.csv");
        let columns: &[&[&str]] = &[&["wavenumber", "compliance"], &["qx", "qy", "compliance"]];
        let of = |text: &str| {
            std::fs::write(&file, text).unwrap();
            rows("compliance", file.to_str().unwrap(), columns, true).map_err(|error| error.to_string())
        };
        assert_eq!(of("1,2\n2 1\n"), Ok("1:2,2:1".into()));
        assert_eq!(of("1,-2,3\n"), Ok("1:-2:3".into()));
        let heads = "qx [1/um],qy [1/um],compliance [um/GPa]\n1,0,3\n";
        assert_eq!(of(heads), Ok("1 1/um:0 1/um:3um/GPa".into()));
        for (text, words) in [
            (
                "1,2\n1,2,3\n",
                "line 2 is \"1,2,3\"; it must be two finite numbers, wavenumber and compliance, or before",
            ),
            (
                "qx,qy,compliance\n1,2\n",
                "line 2 is \"1,2\"; it must be 3 finite numbers, qx, qy, compliance, or before",
            ),
            ("1\n", "two finite numbers, wavenumber and compliance, or 3 finite numbers, qx, qy, compliance"),
        ] {
            let error = of(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
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
        assert!(of(&large, true).unwrap_err().contains("it has 1200000 bytes; it must have at most 1048576"));
        assert!(
            rows("law_table", "none.csv", &[&["gap", "traction"]], true).unwrap_err().to_string().contains("none.csv")
        );
    }
}
