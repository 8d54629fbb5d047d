//! Texts of scenes with a mark where something is to be said of them.

use std::fmt::Display;
use std::path::Path;

/// Taken out before parsing.
pub const MARK: char = '§';

/// The text without its mark.
pub fn unmarked(text: &str) -> String {
    text.replace(MARK, "")
}

/// The line and the column of the mark, from 1 on.
pub fn line_and_column(text: &str) -> (usize, usize) {
    let (before, _) = text.split_once(MARK).unwrap_or_else(|| panic!("no mark in {text}"));
    (before.split('\n').count(), before.chars().rev().take_while(|c| *c != '\n').count() + 1)
}

/// Why what was said of a marked text, which stands in this file, does not stand at the mark, name this field and have these words.
pub fn fault(said: impl Display, file: &Path, text: &str, field: &str, words: &[&str]) -> Result<(), String> {
    let said = said.to_string();
    let (line, column) = line_and_column(text);
    let start = format!("{}:{line}:{column}: {field}: ", file.display());
    let Some(message) = said.strip_prefix(&start) else { return Err(format!("expected {start}..: {said}")) };
    match words.iter().find(|word| !message.contains(*word)) {
        Some(word) => Err(format!("expected the words {word:?}: {said}")),
        None => Ok(()),
    }
}
