//! Text for terminals: without characters that control them, and broken at words where it is wider than they are.

use std::io::{self, IsTerminal, Write};

use textwrap::{Options, WordSeparator, WordSplitter};

use crate::printable::printable;

/// The width where a terminal does not say its own.
const USUAL: usize = 80;

/// The columns of the terminal that stdout is; nothing where it is none, so that lines are not broken for programs that read them.
pub fn columns_of_stdout() -> Option<usize> {
    let stdout = io::stdout();
    stdout.is_terminal().then(|| columns(terminal_size::terminal_size_of(stdout)))
}

/// The columns of the terminal that stderr goes to; `None` if it goes elsewhere.
pub fn columns_of_stderr() -> Option<usize> {
    let stderr = io::stderr();
    stderr.is_terminal().then(|| columns(terminal_size::terminal_size_of(stderr)))
}

/// The columns and rows of the terminal that stderr is, or usual ones.
pub fn size_of_stderr() -> (usize, usize) {
    let size = terminal_size::terminal_size_of(io::stderr());
    size.map_or((USUAL, 24), |(width, height)| (usize::from(width.0), usize::from(height.0)))
}

fn columns(size: Option<(terminal_size::Width, terminal_size::Height)>) -> usize {
    size.map_or(USUAL, |(width, _)| usize::from(width.0)).max(1)
}

/// The text as a terminal of so many columns is to show it. Lines that are too long are broken between words; what follows is indented. A
/// word is not broken, so that a path can be copied.
pub fn fit_to_terminal(text: &str, columns: Option<usize>) -> String {
    let text = printable(text);
    let Some(columns) = columns else { return text.into_owned() };
    let lines = text.split('\n').map(|line| {
        let own = line.len() - line.trim_start_matches(' ').len();
        // A deep indent would leave no room.
        let indent = " ".repeat(if own + 2 <= columns / 2 { own + 2 } else { 2 });
        let options = Options::new(columns)
            .break_words(false)
            .word_separator(WordSeparator::AsciiSpace)
            .word_splitter(WordSplitter::NoHyphenation)
            .wrap_algorithm(textwrap::WrapAlgorithm::FirstFit)
            .subsequent_indent(&indent);
        textwrap::wrap(line, options).join("\n")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Prints a line on stderr as a terminal shows it. A closed stderr is not an error; `eprintln` would panic.
pub fn tell(text: &str) {
    let _ = writeln!(io::stderr(), "{}", fit_to_terminal(text, columns_of_stderr()));
}

#[cfg(test)]
mod tests {
    use super::fit_to_terminal;

    #[test]
    fn long_lines_are_broken_at_words_and_paths_are_not() {
        let text = "warning: one two three\n  four five six seven\nshort\n";
        assert_eq!(fit_to_terminal(text, None), text);
        assert_eq!(fit_to_terminal(text, Some(16)), "warning: one two\n  three\n  four five six\n    seven\nshort\n");
        let path = "a/long/path/of/folders.exr: 16 samples";
        assert_eq!(fit_to_terminal(path, Some(12)), "a/long/path/of/folders.exr:\n  16 samples");
        assert_eq!(fit_to_terminal("é é é", Some(5)), "é é é");
        assert_eq!(fit_to_terminal("\u{1b}[2J a", Some(80)), "\\u001b[2J a");
    }

    /// The columns of a table stay where they are.
    #[test]
    fn spaces_within_a_line_stay() {
        assert_eq!(fit_to_terminal("name      1.0   words behind", Some(18)), "name      1.0\n  words behind");
        assert_eq!(fit_to_terminal("a  b", Some(80)), "a  b");
    }
}
