//! The words of a file, with their places.

use std::path::Path;
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::printable::quote;
use crate::scene::imported::Place;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Token<'t> {
    /// A name or a number.
    Word(&'t str),
    /// A text in quotes.
    Text(&'t str),
    Open,
    Close,
}

impl Token<'_> {
    pub fn words(&self) -> String {
        match self {
            Token::Word(word) => quote(word),
            Token::Text(text) => format!("the text {}", quote(text)),
            Token::Open => "[".to_owned(),
            Token::Close => "]".to_owned(),
        }
    }
}

pub struct Tokens<'t> {
    file: Arc<Path>,
    text: &'t str,
    at: usize,
    line: u32,
    line_start: usize,
    /// The begin of the latest token: its line, where that begins, and its own byte.
    begin: (u32, usize, usize),
    /// Whether the notation was wrong, so that the file cannot be read on.
    pub is_broken: bool,
}

impl<'t> Tokens<'t> {
    pub fn new(file: &Path, text: &'t str) -> Tokens<'t> {
        Tokens { file: file.into(), text, at: 0, line: 1, line_start: 0, begin: (1, 0, 0), is_broken: false }
    }

    /// The place of the latest token.
    pub fn place(&self) -> Place {
        let (line, line_start, at) = self.begin;
        let before = self.text.get(line_start..at).unwrap_or_default();
        Place { file: Arc::clone(&self.file), line, column: before.chars().count() as u32 + 1 }
    }

    /// An error of the notation, at the latest token.
    pub fn broken(&mut self, what: &str, message: impl Into<String>) -> Error {
        self.is_broken = true;
        self.place().error(what, message)
    }

    fn skip_space(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(byte) = bytes.get(self.at) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    self.line_start = self.at + 1;
                }
                b'#' => {
                    let rest = bytes.get(self.at..).unwrap_or_default();
                    self.at += rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
                    continue;
                }
                b' ' | b'\t' | b'\r' => {}
                _ => break,
            }
            self.at += 1;
        }
    }

    /// The next token, which stays the next one.
    pub fn peek(&mut self) -> Result<Option<Token<'t>>> {
        let (at, line, line_start) = (self.at, self.line, self.line_start);
        let found = self.next();
        (self.at, self.line, self.line_start) = (at, line, line_start);
        found
    }

    /// The next token; nothing at the end.
    pub fn next(&mut self) -> Result<Option<Token<'t>>> {
        self.skip_space();
        self.begin = (self.line, self.line_start, self.at);
        let rest = self.text.get(self.at..).unwrap_or_default();
        let Some(first) = rest.bytes().next() else { return Ok(None) };
        let (token, length) = match first {
            b'[' => (Token::Open, 1),
            b']' => (Token::Close, 1),
            b'"' => {
                let inner = rest.get(1..).unwrap_or_default();
                let end = inner.find(['"', '\n', '\\']).filter(|end| inner.as_bytes().get(*end) == Some(&b'"'));
                let Some(end) = end else {
                    return Err(self.broken("text", "expected a \" at its end in the same line, and no \\ before that"));
                };
                (Token::Text(inner.get(..end).unwrap_or_default()), end + 2)
            }
            _ => {
                let end = rest.find([' ', '\t', '\r', '\n', '[', ']', '"', '#']).unwrap_or(rest.len());
                (Token::Word(rest.get(..end).unwrap_or_default()), end)
            }
        };
        self.at += length;
        Ok(Some(token))
    }

    /// The next token, which must be there.
    pub fn expect(&mut self, what: &str, expected: &str) -> Result<Token<'t>> {
        match self.next()? {
            Some(token) => Ok(token),
            None => Err(self.broken(what, format!("expected {expected}, found the end of the file"))),
        }
    }

    pub fn text(&mut self, what: &str, expected: &str) -> Result<&'t str> {
        match self.expect(what, expected)? {
            Token::Text(text) => Ok(text),
            other => Err(self.broken(what, format!("expected {expected}, found {}", other.words()))),
        }
    }

    /// So many numbers, which may be in brackets.
    pub fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let is_bracketed = self.peek()? == Some(Token::Open);
        if is_bracketed {
            self.next()?;
        }
        let mut all = [0.0; N];
        for number in &mut all {
            let expected = format!("{N} numbers");
            let token = self.expect(what, &expected)?;
            *number = match number_of(token) {
                Some(found) => found,
                None => return Err(self.broken(what, format!("expected {expected}, found {}", token.words()))),
            };
        }
        if is_bracketed && self.expect(what, "]")? != Token::Close {
            return Err(self.broken(what, format!("expected ] behind {N} numbers")));
        }
        Ok(all)
    }
}

pub fn number_of(token: Token<'_>) -> Option<f64> {
    let Token::Word(word) = token else { return None };
    word.parse::<f64>().ok().filter(|number| number.is_finite())
}
