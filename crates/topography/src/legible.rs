//! Sanitising of texts from files, instruments and systems for a terminal or a page.

/// Returns true for a character that controls the display: control characters, changes of writing direction, and
/// invisible characters.
fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Returns the text on one line: line breaks and tabs become blanks, other characters that control the display U+FFFD.
pub fn line(text: &str) -> String {
    let shown = |c: char| match c {
        '\n' | '\r' | '\t' | '\u{b}' | '\u{c}' | '\u{85}' | '\u{2028}' | '\u{2029}' => ' ',
        c if steers(c) => char::REPLACEMENT_CHARACTER,
        c => c,
    };
    text.chars().map(shown).collect()
}

/// Returns the text with its line breaks and tabs; other characters that control the display become U+FFFD.
pub fn lines(text: &str) -> String {
    let shown = |c: char| if steers(c) && c != '\n' && c != '\t' { char::REPLACEMENT_CHARACTER } else { c };
    text.chars().map(shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_display_is_not_shown() {
        let hostile = "a\u{1b}[31mb\u{9b}2Jc\u{7}\nd\r\te\u{202e}f\u{200b}g\u{2028}h\u{feff}\u{e0041}µ²";
        assert_eq!(line(hostile), "a\u{fffd}[31mb\u{fffd}2Jc\u{fffd} d  e\u{fffd}f\u{fffd}g h\u{fffd}\u{fffd}µ²");
        assert_eq!(lines(hostile).lines().count(), 2);
        assert!(!lines(hostile).contains(['\u{1b}', '\u{9b}', '\r', '\u{202e}', '\u{200b}', '\u{2028}']));
        assert_eq!(
            line("heights converted from nm to µm, κ = 2.3 ± 0.1 — 東"),
            "heights converted from nm to µm, κ = 2.3 ± 0.1 — 東"
        );
    }
}
