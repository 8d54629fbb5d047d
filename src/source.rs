//! The text of the scene file, the locations of its values, and errors and checks that point at them. Nothing here knows the scene.

pub(crate) mod declare;
pub mod form;
mod numbers;
mod spans;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Location};
use crate::printable::one_line;
use spans::Spans;

pub use numbers::{DEGREES, LARGEST, NO_UNIT, Range, SCENE_UNITS, SMALLEST, parallel};
pub use spans::{Id, MOST_VALUES, Mismatch, Span, Step, skip_space, slice};

/// A scene file's text with the locations of its values.
#[derive(Clone, Debug)]
pub struct Source {
    pub path: PathBuf,
    text: String,
    /// The offset of the first byte of every line, in 32 bits as in spans.
    lines: Vec<u32>,
    pub spans: Spans,
    /// Whether the file is a text, so that values have lines and columns.
    is_text: bool,
    /// Where values stand that were read from another text, by their paths such as `objects[3]`.
    places: HashMap<String, Location>,
}

impl Source {
    pub fn new(text: String, path: &Path) -> Source {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Source {
            path: path.to_owned(),
            lines: std::iter::once(0).chain(ends.map(|(at, _)| at as u32 + 1)).collect(),
            spans: Spans::scan(&text),
            text,
            is_text: true,
            places: HashMap::new(),
        }
    }

    /// A file whose values have no locations in a text.
    pub fn without_text(path: &Path) -> Source {
        Source { is_text: false, ..Source::new(String::new(), path) }
    }

    /// A file whose values stand in these places.
    pub fn with_places(path: &Path, places: HashMap<String, Location>) -> Source {
        Source { places, ..Source::without_text(path) }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The path of a file that the scene names. Relative paths start at the scene file's folder.
    pub fn resolve(&self, path: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(path)
    }

    /// The line and column of a byte.
    pub fn location(&self, offset: usize) -> Location {
        if !self.is_text {
            return Location { file: self.path.clone(), line: 0, column: 0 };
        }
        let line = self.lines.partition_point(|&start| start as usize <= offset);
        let start = line.checked_sub(1).and_then(|before| self.lines.get(before));
        let before = start.and_then(|&start| self.text.get(start as usize..offset));
        Location { file: self.path.clone(), line: line.max(1), column: before.unwrap_or("").chars().count() + 1 }
    }

    /// The offset of the byte at a line and column, both counted from 1; the end of the text if there is none.
    pub fn offset(&self, line: usize, column: usize) -> usize {
        let start = line.checked_sub(1).and_then(|before| self.lines.get(before));
        let rest = start.and_then(|&start| self.text.get(start as usize..)).unwrap_or("");
        let mut characters = rest.char_indices().map(|(at, _)| at);
        let within = column.checked_sub(1).and_then(|before| characters.nth(before));
        within.map_or(self.text.len(), |within| self.text.len() - rest.len() + within)
    }

    /// The location of the value at the end of the path. If the text lacks it, that of the innermost value on the path.
    pub fn location_of(&self, steps: &[Step<'_>]) -> Location {
        if !self.places.is_empty() {
            let known = |length: usize| self.places.get(&field(steps.get(..length)?)).cloned();
            return (0..=steps.len()).rev().find_map(known).unwrap_or_else(|| self.location(0));
        }
        let id = self.spans.find(&self.text, steps);
        self.location(id.map_or(0, |id| self.spans.value(id).start as usize))
    }

    /// Whether the text has a value at the end of the path.
    pub fn has(&self, steps: &[Step<'_>]) -> bool {
        self.spans.follow(&self.text, steps).is_some_and(|(_, rest)| rest.is_empty())
    }

    /// An error at the value at the end of the path.
    pub fn error(&self, steps: &[Step<'_>], message: impl Into<String>) -> Error {
        Error::Scene { location: self.location_of(steps), field: field(steps), message: message.into() }
    }

    /// An error at a byte of the text.
    pub fn error_at(&self, offset: usize, steps: &[Step<'_>], message: impl Into<String>) -> Error {
        Error::Scene { location: self.location(offset), field: field(steps), message: message.into() }
    }

    /// The text of a value on one line, shortened for a message.
    pub fn excerpt(&self, id: Id) -> String {
        self.excerpt_of(self.spans.value(id))
    }

    pub fn excerpt_of(&self, span: Span) -> String {
        const LONGEST: usize = 40;
        // Takes only a few more characters than it shows, so that a long value is not copied completely.
        let characters = spans::slice(&self.text, span).chars().take(4 * LONGEST);
        let text: String = characters.collect();
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        match text.char_indices().nth(LONGEST) {
            Some((cut, _)) => format!("{} ...", text.get(..cut).unwrap_or("")),
            None => text,
        }
    }
}

/// A path as messages show it: `objects[3].Sphere.radius`.
fn field(steps: &[Step<'_>]) -> String {
    let mut field = String::new();
    for step in steps {
        match step {
            Step::Field(name) | Step::Variant(name) => {
                if !field.is_empty() {
                    field.push('.');
                }
                field.push_str(name);
            }
            Step::Index(index) => field.push_str(&format!("[{index}]")),
            Step::Key(name) => field.push_str(&format!("[{name:?}]")),
        }
    }
    if field.is_empty() {
        field.push_str("Scene");
    }
    field
}

/// The path of a value in the scene file, such as `objects[3].Sphere.radius`. Checks pass it down through the scene and make errors from it.
///
/// It is a chain of borrowed paths up to the top, so that checks that find nothing allocate nothing.
#[derive(Clone, Copy)]
pub struct ValuePath<'a> {
    source: &'a Source,
    above: Option<(&'a ValuePath<'a>, Step<'a>)>,
}

impl<'a> ValuePath<'a> {
    pub fn top(source: &'a Source) -> ValuePath<'a> {
        ValuePath { source, above: None }
    }

    pub fn field(&'a self, name: &'a str) -> ValuePath<'a> {
        self.step(Step::Field(name))
    }

    pub fn variant(&'a self, name: &'a str) -> ValuePath<'a> {
        self.step(Step::Variant(name))
    }

    pub fn key(&'a self, name: &'a str) -> ValuePath<'a> {
        self.step(Step::Key(name))
    }

    pub fn index(&'a self, index: usize) -> ValuePath<'a> {
        self.step(Step::Index(index))
    }

    fn step(&'a self, step: Step<'a>) -> ValuePath<'a> {
        ValuePath { source: self.source, above: Some((self, step)) }
    }

    pub fn steps(&self) -> Vec<Step<'a>> {
        let mut steps = Vec::new();
        let mut above = self.above;
        while let Some((path, step)) = above {
            steps.push(step);
            above = path.above;
        }
        steps.reverse();
        steps
    }

    /// An error at this value.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.source.error(&self.steps(), message)
    }

    /// An error about a file that this value names. `part` is the part of that file, if it is known. Where the scene itself is no text,
    /// this value is none that anybody wrote.
    pub fn error_in(&self, file: &Path, part: &str, reason: &str) -> Error {
        if !self.source.is_text && reason.starts_with(LINE) {
            return error_in_file(file, if part.is_empty() { "Mesh" } else { part }, reason);
        }
        if self.source.is_text || part.is_empty() {
            let part = if part.is_empty() { String::new() } else { format!("{part}: ") };
            return self.error(format!("{}: {part}{reason}", file.display()));
        }
        let location = Location { file: file.to_owned(), line: 0, column: 0 };
        Error::Scene { location, field: part.to_owned(), message: reason.to_owned() }
    }

    /// "expected ..., found ..." at this value, which is quoted as the file writes it.
    pub fn unexpected(&self, expected: impl std::fmt::Display) -> Error {
        let id = self.source.spans.find(self.source.text(), &self.steps());
        let found = id.map_or(String::new(), |id| format!(", found {}", self.source.excerpt(id)));
        self.error(format!("expected {expected}{found}"))
    }

    /// The value as the file writes it.
    pub fn text(&self) -> &'a str {
        let id = self.source.spans.find(self.source.text(), &self.steps());
        id.map_or("", |id| slice(self.source.text(), self.source.spans.value(id)))
    }

    /// The text of a warning about this value, in the form of an error's.
    pub fn warning(&self, message: &str) -> String {
        let steps = self.steps();
        format!("{}: {}: {}", self.source.location_of(&steps), one_line(&field(&steps)), one_line(message))
    }
}

/// The beginning of a reason that names the line of its file.
const LINE: &str = "line ";

/// An error about a file that no scene's text names. A reason such as "line 7: .." gives its line.
pub fn error_in_file(file: &Path, field: &str, reason: &str) -> Error {
    let with_line = reason.strip_prefix(LINE).and_then(|rest| rest.split_once(": "));
    let with_line = with_line.and_then(|(line, rest)| Some((line.parse().ok()?, rest)));
    let (line, message) = with_line.unwrap_or((0, reason));
    let location = Location { file: file.to_owned(), line, column: 1 };
    Error::Scene { location, field: field.to_owned(), message: message.to_owned() }
}
