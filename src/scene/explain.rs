//! Translates ron's errors into the terms of the scene format.
//!
//! ron reports the position of its cursor and what a Rust type expected. The tree of spans maps the
//! cursor to a value and its path, and the path determines what the scene format expects there.

use ron::error::{Error as Ron, SpannedError};

use super::format::{SCENE, groups};
use super::nearest::{nearest, other_name};
use super::types::{Object, Transform};
use super::validate::boundaries;
use crate::error::Error;
use crate::material::a_material;
use crate::source::form::{Form, NUMBER, POINT, Takes, any_of};
use crate::source::{Id, Mismatch, Source, Span, Step, skip_space, slice};
use crate::texture::number::NEITHER;

/// One of ron's errors in the terms of the scene format.
pub struct Explained {
    pub error: Error,
    /// The byte that it points at.
    pub offset: usize,
    /// Whether it is about a value, so that the text around the value may be read on.
    pub about_value: bool,
    /// Whether a field is missing.
    pub is_missing: bool,
}

/// The error of the parser, with the position of the value, its path, and what is expected there.
pub fn explain(source: &Source, error: SpannedError) -> Explained {
    let cursor = source.offset(error.span.end.line, error.span.end.col);
    let explain = Explain { source, cursor };
    let is_missing = matches!(error.code, Ron::MissingStructField { .. });
    let (error, about_value) = match explain.hash() {
        Some(error) => (error, false),
        None => explain.of_code(error.code),
    };
    let offset = match &error {
        Error::Scene { location, .. } => source.offset(location.line, location.column),
        _ => cursor,
    };
    Explained { error, offset, about_value, is_missing }
}

const HASH: &str = "comments begin with //, found #";

/// The error that the scene begins with a # that begins no attribute.
pub fn hash_at_start(source: &Source) -> Option<Error> {
    let at = skip_space(source.text(), 0).ok()?;
    let rest = source.text().get(at..)?.strip_prefix('#')?;
    (!rest.starts_with('!')).then(|| source.error_at(at, &[], HASH))
}

/// The error that a section of the scene is missing.
pub fn missing_section(source: &Source, name: &str) -> Error {
    let end = source.spans.root.map_or(0, |root| source.spans.value(root).end);
    Explain { source, cursor: end.saturating_sub(1) as usize }.missing(name)
}

struct Explain<'a> {
    source: &'a Source,
    /// The byte at which ron reported the error.
    cursor: usize,
}

impl<'a> Explain<'a> {
    /// The error, and whether it is about a value. All others are about the notation, and nothing behind them is known.
    fn of_code(&self, code: Ron) -> (Error, bool) {
        let cursor = self.cursor;
        let is_open = cursor >= self.source.text().len() && self.source.spans.unclosed_bracket.is_some();
        if let Some(error) = self.mismatched_bracket() {
            return (error, false);
        }
        let of_notation = match code {
            Ron::UnclosedBlockComment => self.unclosed_comment(),
            Ron::ExpectedStringEnd => self.unclosed_string(),
            _ if is_open => self.unclosed_bracket(),
            Ron::ExpectedComma => return self.comma(),
            Ron::ExpectedMapColon => self.token("a colon after the name"),
            Ron::UnexpectedChar(found) if self.is_after(&format!("/{found}")) => {
                let message = format!("expected // or /* as the start of a comment, found /{found}");
                self.here(cursor.saturating_sub(1 + found.len_utf8()), message)
            }
            Ron::NoSuchExtension(name) => {
                let message = format!("RON has no extension {name}: a scene needs none");
                self.here(cursor.saturating_sub(name.len()), message)
            }
            Ron::TrailingCharacters => self.here(cursor, "expected the end of the file after the scene's last bracket"),
            Ron::ExceededRecursionLimit => self.too_deep(),
            Ron::InvalidEscape(reason) => {
                self.here(cursor, format!("{}: a backslash is written \\\\ in a string", lower(reason)))
            }
            code => return self.of_value(code),
        };
        (of_notation, false)
    }

    fn of_value(&self, code: Ron) -> (Error, bool) {
        let of_value = match code {
            Ron::NoSuchStructField { expected, found, .. } => {
                let message = format!("expected one of {}{}", expected.join(", "), meant(&found, expected));
                self.name(format!("unknown field {found}: {message}"), &found)
            }
            Ron::DuplicateStructField { field, .. } => self.name(format!("{field} is given twice"), field),
            // Of a number that may vary.
            Ron::Message(message) if message == NEITHER => {
                let id = self.before_cursor();
                self.expected(id, &self.path(id, false), "")
            }
            // This program's own error about a material's name that occurs twice.
            Ron::Message(message) => self.name(message, ""),
            Ron::MissingStructField { field, .. } => self.missing(field),
            Ron::NoSuchEnumVariant { expected, found, .. } => self.variant(&found, expected),
            Ron::ExpectedDifferentLength { .. } => self.value_around(),
            Ron::ExpectedStructLike => self.bracket(),
            Ron::ExpectedStructLikeEnd | Ron::ExpectedOptionEnd => self.too_many(),
            Ron::ExpectedArray
            | Ron::ExpectedBoolean
            | Ron::ExpectedFloat
            | Ron::FloatUnderscore
            | Ron::ExpectedInteger
            | Ron::ExpectedByteLiteral
            | Ron::ExpectedOption
            | Ron::ExpectedMap
            | Ron::ExpectedDifferentStructName { .. }
            | Ron::ExpectedNamedStructLike(_)
            | Ron::ExpectedString
            | Ron::ExpectedIdentifier
            | Ron::SuggestRawIdentifier(_)
            | Ron::IntegerOutOfBounds
            | Ron::InvalidIntegerDigit { .. }
            | Ron::UnderscoreAtBeginning
            | Ron::InvalidValueForType { .. }
            | Ron::UnexpectedChar(_) => self.value(),
            other => return (self.here(self.cursor, lower(&other.to_string())), false),
        };
        (of_value, true)
    }

    /// For a # instead of a comment, with the cursor at it or before it.
    fn hash(&self) -> Option<Error> {
        let text = self.source.text();
        let at = skip_space(text, self.cursor).ok().filter(|&at| text.as_bytes().get(at) == Some(&b'#'))?;
        Some(self.here(at, HASH))
    }

    /// An error at a byte, with the path of the innermost value around it.
    fn here(&self, offset: usize, message: impl Into<String>) -> Error {
        self.source.error_at(offset, &self.path(self.around(offset), true), message)
    }

    /// For errors about a field's name or a map's key, with the cursor just after it.
    fn name(&self, message: String, name: &str) -> Error {
        let Some(id) = self.before_cursor() else {
            return self.here(self.cursor, message);
        };
        let mut path = self.path(Some(id), false);
        if self.source.spans.key(id).is_empty() {
            // Without a colon after the name, the tree holds it as a value.
            path.pop();
            path.push(Step::Field(name));
        }
        let start = self.source.spans.entry_start(id) as usize;
        self.source.error_at(start, &path, message)
    }

    /// For a missing field, with the cursor at the struct's closing bracket.
    fn missing(&self, name: &str) -> Error {
        let id = self.at(self.cursor);
        let mut path = self.path(id, true);
        path.push(Step::Field(name));
        let start = id.map_or(self.cursor, |id| self.source.spans.value(id).start as usize);
        let message = format!("{name} is missing: expected {name}: {}", expected(&path));
        self.source.error_at(start, &path, message)
    }

    /// For an unknown variant, with the cursor just after its name.
    fn variant(&self, found: &str, variants: &[&str]) -> Error {
        let path = self.path(self.before_cursor(), false);
        self.expected(self.before_cursor(), &path, &meant(found, variants))
    }

    /// For a value that ron could not read, with the cursor at it or just after it.
    fn value(&self) -> Error {
        let id = self.value_at_cursor();
        if let Some(id) = id
            && (self.cursor as u32) < self.source.spans.key(id).end
        {
            return self.key(id);
        }
        // If the cursor is past the opening bracket, the error is about the content, as in `Group()`.
        let inside = id.is_some_and(|id| self.cursor as u32 > self.source.spans.name_end(id));
        self.expected(id, &self.path(id, inside), "")
    }

    /// For a variant without a bracket, or with the wrong one, with the cursor after its name.
    fn bracket(&self) -> Error {
        let id = self.value_at_cursor();
        let mut path = self.path(id, false);
        let name = id.map_or("", |id| match self.source.spans.name(self.source.text(), id) {
            "" => slice(self.source.text(), self.source.spans.value(id)),
            name => name,
        });
        path.push(Step::Variant(name));
        self.expected(id, &path, "")
    }

    /// For a field's key that is not a name, or a map's key that is not a string, with the cursor at the key.
    fn key(&self, id: Id) -> Error {
        let path = self.path(self.source.spans.parent(id), true);
        let key = self.source.spans.key(id);
        let expected = match path.last() {
            Some(Step::Field("materials")) => "a material's name in quotes",
            _ => "a field's name, without quotes",
        };
        let found = self.source.excerpt_of(key);
        let message = format!("expected {expected}, found {found}");
        self.source.error_at(key.start as usize, &path, message)
    }

    /// For a value with a wrong number of elements, with the cursor inside it.
    fn value_around(&self) -> Error {
        let id = self.at(self.cursor);
        self.expected(id, &self.path(id, true), "")
    }

    /// For an element too many, or a token instead of a bracket, with the cursor at it.
    fn too_many(&self) -> Error {
        let id = self.around(self.cursor);
        self.expected(id, &self.path(id, true), "")
    }

    /// For a missing comma or closing bracket, with the cursor where it should be.
    fn comma(&self) -> (Error, bool) {
        match self.at(self.cursor) {
            // The cursor is in the middle of a word: `640.5` instead of an integer, or `5px`.
            Some(id) if self.is_word(id) && (self.source.spans.value(id).start as usize) < self.cursor => {
                (self.expected(Some(id), &self.path(Some(id), false), ""), true)
            }
            _ => (self.token("a comma or a closing bracket"), false),
        }
    }

    /// "expected ..., found ..." about the word or sign at the cursor.
    fn token(&self, expected: &str) -> Error {
        let cursor = self.cursor as u32;
        let id = self.at(self.cursor);
        let starts = |span: &Span| span.start == cursor && !span.is_empty();
        let token = id
            .into_iter()
            .flat_map(|id| [self.source.spans.key(id), self.source.spans.value(id)])
            .find(starts)
            .unwrap_or(Span { start: cursor, end: cursor + 1 });
        let found = self.source.excerpt_of(token);
        self.here(self.cursor, format!("expected {expected}, found {found}"))
    }

    fn unclosed_comment(&self) -> Error {
        let start = self.source.spans.unclosed_comment;
        let start = start.map_or(self.cursor, |start| start as usize);
        self.here(start, "this comment is not closed: */ is missing")
    }

    fn too_deep(&self) -> Error {
        let mut path = self.path(self.at(self.cursor), false);
        // The complete path would fill a page of the terminal.
        path.truncate(2);
        let message = "nested too deeply (objects may hold objects some 60 deep): flatten the groups and transforms";
        self.source.error_at(self.cursor, &path, message)
    }

    fn unclosed_string(&self) -> Error {
        let id = self.before_cursor();
        let start = id.map_or(self.cursor, |id| self.source.spans.value(id).start as usize);
        let path = self.path(id, false);
        self.source.error_at(start, &path, "this string is not closed: the quote at its end is missing")
    }

    fn unclosed_bracket(&self) -> Error {
        let text = self.source.text();
        let bracket = self.source.spans.unclosed_bracket.unwrap_or_default() as usize;
        let opened = self.source.location(bracket);
        let found = self.bracket_at(bracket);
        let message =
            format!("the file ends, but the {found} of line {}, column {} is not closed", opened.line, opened.column);
        let path = self.path(self.at(bracket), true);
        self.source.error_at(text.len(), &path, message)
    }

    fn bracket_at(&self, offset: usize) -> char {
        self.source.text().get(offset..).and_then(|rest| rest.chars().next()).unwrap_or('(')
    }

    /// For a bracket that is closed by one of another kind, if that is where the parser has stopped.
    fn mismatched_bracket(&self) -> Option<Error> {
        let text = self.source.text();
        let Mismatch { opened, closed } = self.source.spans.mismatch?;
        let (opened, closed) = (opened? as usize, closed as usize);
        if skip_space(text, self.cursor).unwrap_or(self.cursor) < closed {
            return None;
        }
        let (opener, at) = (self.bracket_at(opened), self.source.location(opened));
        let closer = match opener {
            '[' => ']',
            '{' => '}',
            _ => ')',
        };
        let message = format!(
            "expected {closer}, found {}: the {opener} of line {}, column {} is not closed",
            self.bracket_at(closed),
            at.line,
            at.column
        );
        let path = self.path(self.at(opened), true);
        Some(self.source.error_at(closed, &path, message))
    }

    /// "expected ..., found ..." at the start of a value.
    fn expected(&self, id: Option<Id>, path: &[Step<'_>], hint: &str) -> Error {
        let found = id.map_or("nothing".to_owned(), |id| self.source.excerpt(id));
        let bare = id.filter(|_| hint.is_empty()).and_then(|id| self.bare_colour(id, path));
        let hint = bare.as_deref().unwrap_or(hint);
        let start = id.map_or(self.cursor, |id| self.source.spans.value(id).start as usize);
        let message = format!("expected {}, found {found}{hint}", expected(path));
        self.source.error_at(start, path, message)
    }

    /// The hint for three numbers in brackets where a texture or a background is expected.
    fn bare_colour(&self, id: Id, path: &[Step<'_>]) -> Option<String> {
        let spans = &self.source.spans;
        let is_bare = spans.name(self.source.text(), id).is_empty() && spans.children(id).len() == 3;
        let found = slice(self.source.text(), spans.value(id));
        let is_number = |child: &Id| slice(self.source.text(), spans.value(*child)).parse::<f64>().is_ok();
        if !is_bare || !found.starts_with('(') || !spans.children(id).iter().all(is_number) {
            return None;
        }
        match path {
            [.., Step::Field("background")] => Some(format!("; did you mean Solid({found})?")),
            [.., Step::Field(name)] if field_of(path, name).is_some_and(Takes::is_texture) => {
                Some(format!("; did you mean Rgb{found}?"))
            }
            _ => None,
        }
    }

    fn path(&self, id: Option<Id>, into_variant: bool) -> Vec<Step<'a>> {
        id.map_or(Vec::new(), |id| self.source.spans.path(self.source.text(), id, into_variant))
    }

    fn at(&self, offset: usize) -> Option<Id> {
        self.source.spans.at(offset as u32)
    }

    /// The innermost incomplete value at a byte: if one starts there, the one around it.
    fn around(&self, offset: usize) -> Option<Id> {
        let (id, spans) = (self.at(offset)?, &self.source.spans);
        if spans.entry_start(id) as usize == offset { spans.parent(id) } else { Some(id) }
    }

    fn before_cursor(&self) -> Option<Id> {
        self.at(self.cursor.saturating_sub(1))
    }

    fn is_after(&self, text: &str) -> bool {
        self.source.text().get(..self.cursor).is_some_and(|before| before.ends_with(text))
    }

    fn is_word(&self, id: Id) -> bool {
        self.source.spans.children(id).is_empty() && self.source.spans.name(self.source.text(), id).is_empty()
    }

    /// The value that starts at the cursor, or else the one that ends just before it.
    fn value_at_cursor(&self) -> Option<Id> {
        let around = self.at(self.cursor)?;
        if self.source.spans.entry_start(around) as usize == self.cursor {
            return Some(around);
        }
        let ended = self.source.spans.children(around).iter().copied().find(|&child| {
            let end = self.source.spans.value(child).end as usize;
            let next = skip_space(self.source.text(), end).unwrap_or(end);
            (end..=next).contains(&self.cursor)
        });
        ended.or(Some(around))
    }
}

/// "; did you mean ...?", if one of the names is near.
fn meant(found: &str, names: &[&str]) -> String {
    let meant = other_name(found, names).or_else(|| nearest(found, names.iter().copied()));
    meant.map_or(String::new(), |meant| format!("; did you mean {meant}?"))
}

/// One of ron's sentences with a small initial letter.
fn lower(message: &str) -> String {
    let mut characters = message.chars();
    let first = characters.next().map(|c| c.to_ascii_lowercase());
    first.into_iter().chain(characters).collect()
}

const BY_NAME: &str = "fields by name: (name: value, ..)";

/// The words for what the scene format expects at the end of a path.
fn expected(path: &[Step<'_>]) -> String {
    let field = |name: &str| field_of(path, name);
    match path {
        [] => SCENE.in_full(),
        [.., Step::Key(_)] => a_material(),
        [.., Step::Field("object")] | [.., Step::Field("objects") | Step::Variant("Group"), Step::Index(_)] => {
            format!("an object: {}", any_of(Object::FORMS.iter()))
        }
        [.., Step::Field("boundary")] => boundaries("(..)", ", Transformed(..), Moving(..) or not"),
        [.., Step::Field("by"), Step::Index(_)] | [.., Step::Field("keys"), _, Step::Index(1), Step::Index(_)] => {
            format!("a transform: {}", any_of(Transform::FORMS.iter()))
        }
        [.., Step::Field("moving"), _, Step::Index(1), Step::Field(_)] => POINT.to_owned(),
        [.., Step::Field("moving"), _, Step::Index(1)] => "(look_from: .., look_at: ..)".to_owned(),
        [.., Step::Field("keys"), Step::Index(_)] => "a key: (seconds, [..])".to_owned(),
        [.., Step::Field("moving"), Step::Index(_)] => "a key: (seconds, (look_from: .., look_at: ..))".to_owned(),
        [.., Step::Field("shutter"), _] => "two numbers of seconds: (open, close)".to_owned(),
        [.., Step::Field(name)] => field(name).map_or(NUMBER.to_owned(), Takes::words),
        [.., Step::Variant(name)] => form(name).map_or(BY_NAME.to_owned(), Form::content),
        [.., Step::Variant("Solid"), Step::Index(_)] => "a colour in brackets: Solid((r, g, b))".to_owned(),
        [.., Step::Variant("Translate"), Step::Index(_)] => "a vector in brackets: Translate((x, y, z))".to_owned(),
        [.., Step::Variant("Rgb"), Step::Index(_)] => NUMBER.to_owned(),
        [.., Step::Field(name), Step::Index(_)] if field(name).is_some_and(Takes::is_numbers) => NUMBER.to_owned(),
        [.., Step::Index(_)] => BY_NAME.to_owned(),
    }
}

/// What a field takes that the innermost form of a path has.
fn field_of(path: &[Step<'_>], name: &str) -> Option<&'static Takes> {
    let outer = match path.iter().rev().skip_while(|step| !matches!(step, Step::Field(_))).nth(1) {
        Some(Step::Variant(outer) | Step::Field(outer)) => form(outer),
        _ => Some(&SCENE),
    };
    outer.and_then(|outer| outer.field(name)).map(|field| &field.takes)
}

/// The form of this name.
fn form(name: &str) -> Option<&'static Form> {
    groups().into_iter().flat_map(|(_, forms)| forms).find(|form| form.name == name)
}
