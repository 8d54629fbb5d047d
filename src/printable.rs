//! Text without characters that control a terminal. Names, paths and excerpts may hold them: an escape sequence in the name of a
//! file could clear the screen, or show another name than the file has.

use std::borrow::Cow;
use std::fmt::Write;

/// A number of things: "1 part", "2 parts".
pub fn counted(number: u64, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// The end of a text that stands for so many more like it.
pub fn and_more(number: usize) -> String {
    if number > 0 { format!(" (and {number} more like it)") } else { String::new() }
}

/// A share in percent, with two significant digits but at most two decimals: "0.38 %", "2.4 %", "35 %".
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value > 0.0 && value < 0.01 {
        return "less than 0.01 %".to_owned();
    }
    two_digits(value, 2.0) + " %"
}

/// A number with two significant digits, but at most so many decimals.
pub fn two_digits(value: f64, most: f64) -> String {
    let decimals = if value > 0.0 { (1.0 - value.log10().floor()).clamp(0.0, most) } else { 0.0 };
    format!("{value:.*}", decimals as usize)
}

/// An upper bound of a share of light, or of an error relative to light; `None` if it says nothing, because it is all of the light or more.
pub fn known_bound(bound: f64) -> Option<f64> {
    Some(bound).filter(|bound| *bound < 1.0)
}

/// A word in quotes, shortened if it is long.
pub fn quote(word: impl AsRef<[u8]>) -> String {
    const LONGEST: usize = 40;
    let word = word.as_ref();
    let text = String::from_utf8_lossy(word.get(..LONGEST).unwrap_or(word));
    format!("{text:?}")
}

/// The text, with every character that controls a terminal written as `\u001b`. Newlines stay. This is JSON's own notation, so
/// that JSON stays the same JSON.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_control(c))
}

/// A text of one line: line ends are escaped too.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_control)
}

fn escaped(text: &str, is_wrong: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_wrong) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match is_wrong(c) {
            // A String takes everything.
            true => drop(write!(escaped, "\\u{:04x}", u32::from(c))),
            false => escaped.push(c),
        }
    }
    Cow::Owned(escaped)
}

/// Whether a character is a control of C0 or C1, a separator of lines, or turns the direction of the text around it (Unicode
/// Standard Annex 9, 2.1 to 2.6).
fn is_control(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::{one_line, printable};

    #[test]
    fn controls_are_escaped_and_text_is_not() {
        let plain = "été \u{1f600} \"a\\b\" 日本";
        assert_eq!((printable(plain), one_line(plain)), (plain.into(), plain.into()));
        assert_eq!(
            printable("a\u{1b}[2J\n\r\t\u{7f}\u{9b}\u{202e}b"),
            "a\\u001b[2J\n\\u000d\\u0009\\u007f\\u009b\\u202eb"
        );
        assert_eq!(one_line("a\nb"), "a\\u000ab");
        let value = serde_json::json!({"a\u{9b}": "\u{1b}\n\u{2066}"});
        let read: serde_json::Value = serde_json::from_str(&printable(&format!("{value:#}"))).unwrap();
        assert_eq!(read, value);
    }
}
