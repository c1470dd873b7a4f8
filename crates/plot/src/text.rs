//! Text with italics, subscripts and superscripts: parsed, measured with the bundled font, written as SVG.

use std::fmt::Write;
use std::sync::LazyLock;

use ttf_parser::Face;

pub(super) const REGULAR: &[u8] = include_bytes!("../fonts/Arimo-Regular.ttf");
pub(super) const ITALIC: &[u8] = include_bytes!("../fonts/Arimo-Italic.ttf");

/// Bundled font, followed by fonts of equal width.
pub(super) const FAMILY: &str = "Arimo, Liberation Sans, Arial, Helvetica, sans-serif";

/// Size and vertical offsets of sub- and superscripts, as fractions of the font size.
const SCRIPT_SIZE: f64 = 0.72;
const RAISE: f64 = 0.36;
const LOWER: f64 = 0.2;

static FACES: LazyLock<Option<[Face<'static>; 2]>> =
    LazyLock::new(|| Some([Face::parse(REGULAR, 0).ok()?, Face::parse(ITALIC, 0).ok()?]));

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Base,
    Sub,
    Super,
}

/// Characters of one style.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    text: String,
    italic: bool,
    level: Level,
}

/// Point of a text that is placed at the given position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Parsed text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Text {
    runs: Vec<Run>,
    size: f64,
}

impl Text {
    pub(super) fn new(markup: &str, size: f64) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        let mut push = |c: char, italic: bool, level: Level| match runs.last_mut() {
            Some(run) if run.italic == italic && run.level == level => run.text.push(c),
            _ => runs.push(Run { text: c.to_string(), italic, level }),
        };
        let (mut italic, mut level, mut braced) = (false, Level::Base, false);
        let mut characters = markup.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '*' => italic = !italic,
                '_' | '^' if level == Level::Base => {
                    level = if c == '_' { Level::Sub } else { Level::Super };
                    braced = characters.next_if_eq(&'{').is_some();
                    continue;
                }
                '}' if braced => (level, braced) = (Level::Base, false),
                _ => {
                    let c = if c == '\\' { characters.next().unwrap_or(c) } else { c };
                    push(c, italic, level);
                    if !braced {
                        level = Level::Base;
                    }
                }
            }
        }
        Self { runs, size }
    }

    /// Returns the width of each run.
    fn widths(&self) -> Vec<f64> {
        let width = |run: &Run| {
            let size = if run.level == Level::Base { self.size } else { SCRIPT_SIZE * self.size };
            run.text.chars().map(|c| advance(c, run.italic)).sum::<f64>() * size
        };
        self.runs.iter().map(width).collect()
    }

    /// Returns the start of each run and the end of the text. A superscript after a subscript stands above it.
    fn starts(&self) -> (Vec<f64>, f64) {
        let (mut x, mut end) = (0.0, 0.0_f64);
        let mut starts = Vec::with_capacity(self.runs.len());
        for (i, (run, width)) in self.runs.iter().zip(self.widths()).enumerate() {
            let stacked = i > 0 && run.level == Level::Super && self.runs[i - 1].level == Level::Sub;
            let start = if stacked { starts[i - 1] } else { x };
            starts.push(start);
            end = end.max(start + width);
            x = end;
        }
        (starts, end)
    }

    pub(super) fn width(&self) -> f64 {
        self.starts().1
    }

    /// Returns the text without markup.
    #[cfg(test)]
    pub(super) fn plain(&self) -> String {
        self.runs.iter().map(|run| run.text.as_str()).collect()
    }

    /// Writes a `<text>` element with its baseline through (x, y), rotated by `angle` degrees about that point.
    ///
    /// Runs have relative positions, given only where a script ends: in a viewer with another font, text becomes wider
    /// or narrower, but runs do not overlap.
    pub(super) fn write(&self, svg: &mut String, x: f64, y: f64, anchor: Anchor, angle: f64, fill: &str) {
        let _ =
            write!(svg, r#"<text x="{}" y="{}" font-size="{}" fill="{fill}""#, number(x), number(y), number(self.size));
        match anchor {
            Anchor::Start => {}
            Anchor::Middle => svg.push_str(r#" text-anchor="middle""#),
            Anchor::End => svg.push_str(r#" text-anchor="end""#),
        }
        if angle != 0.0 {
            let _ = write!(svg, r#" transform="rotate({} {} {})""#, number(angle), number(x), number(y));
        }
        svg.push('>');
        let (starts, _) = self.starts();
        let (mut at, mut raised) = (0.0, 0.0);
        for ((run, start), width) in self.runs.iter().zip(starts).zip(self.widths()) {
            let (rise, size) = match run.level {
                Level::Base => (0.0, None),
                Level::Sub => (-LOWER * self.size, Some(SCRIPT_SIZE * self.size)),
                Level::Super => (RAISE * self.size, Some(SCRIPT_SIZE * self.size)),
            };
            let mut style = String::new();
            for (name, value) in [("dx", start - at), ("dy", raised - rise)] {
                if value.abs() > 1e-9 {
                    let _ = write!(style, r#" {name}="{}""#, number(value));
                }
            }
            if let Some(size) = size {
                let _ = write!(style, r#" font-size="{}""#, number(size));
            }
            if run.italic {
                style.push_str(r#" font-style="italic""#);
            }
            if style.is_empty() {
                svg.push_str(&escape(&run.text));
            } else {
                let _ = write!(svg, "<tspan{style}>{}</tspan>", escape(&run.text));
            }
            (at, raised) = (start + width, rise);
        }
        svg.push_str("</text>\n");
    }
}

/// Returns the advance width of a character as a fraction of the font size.
fn advance(c: char, italic: bool) -> f64 {
    let Some(faces) = FACES.as_ref() else { return 0.55 };
    let face = &faces[usize::from(italic)];
    let advance = face.glyph_index(c).and_then(|glyph| face.glyph_hor_advance(glyph));
    advance.map_or(0.55, |advance| f64::from(advance) / f64::from(face.units_per_em()))
}

/// Formats a coordinate, rounded to 0.01 points, without trailing zeros.
pub(super) fn number(value: f64) -> String {
    let mut text = format!("{value:.2}");
    while text.ends_with('0') {
        text.pop();
    }
    if text.ends_with('.') {
        text.pop();
    }
    if text == "-0" { "0".into() } else { text }
}

/// Escapes text as XML character data; characters that XML forbids are dropped.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            c if c < ' ' || ('\u{fffe}'..='\u{ffff}').contains(&c) => {}
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_becomes_runs() {
        let text = Text::new("*ε*_c^{−1.5} a\\_b <5 %>", 8.0);
        let styles: Vec<_> = text.runs.iter().map(|r| (r.text.as_str(), r.italic, r.level)).collect();
        let expected = [
            ("ε", true, Level::Base),
            ("c", false, Level::Sub),
            ("−1.5", false, Level::Super),
            (" a_b <5 %>", false, Level::Base),
        ];
        assert_eq!(styles, expected);
        assert_eq!(text.plain(), "εc−1.5 a_b <5 %>");
        let (starts, _) = text.starts();
        assert_eq!(starts[1], starts[2], "stacked");
        assert!(starts[3] > starts[2]);
    }

    #[test]
    fn widths_are_those_of_the_font() {
        // Arimo has the advances of Arial: digits 0.556, space and full stop 0.278 of the font size.
        approx::assert_relative_eq!(Text::new("0.1", 10.0).width(), 2.0 * 5.56 + 2.78, max_relative = 1e-3);
        approx::assert_relative_eq!(Text::new("10^{2}", 10.0).width(), 5.56 * 2.72, max_relative = 1e-3);
        assert_eq!(Text::new("", 10.0).width(), 0.0);
    }

    #[test]
    fn the_font_has_every_sign_the_figures_use() {
        let faces = FACES.as_ref().unwrap();
        for c in "0123456789−–×·√∞≤≥≈↑↓ABCxyzκεαλσγνπτδḡ²³°µ%()[]/|=<>*".chars() {
            assert!(faces.iter().all(|face| face.glyph_index(c).is_some()), "{c}");
        }
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!([0.0, -0.001, 1.5, 12.345, -3.0].map(number), ["0", "0", "1.5", "12.35", "-3"].map(str::to_owned));
        assert_eq!(escape("a<b>&\"c\u{1}\""), "a&lt;b&gt;&amp;&quot;c&quot;");
    }
}
