//! The errors that are found in a scene.

use crate::error::{Error, Result};

/// How many are listed.
pub const MOST: usize = 20;

/// How many are kept to be sorted. A scene may have millions of objects that are wrong.
const MOST_KEPT: usize = 1000;

#[derive(Default)]
pub struct Findings {
    errors: Vec<Error>,
}

impl Findings {
    /// Takes the error, if there is one; the result is the value, if there is one.
    pub fn record<T>(&mut self, result: Result<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.refuse(error);
                None
            }
        }
    }

    pub fn refuse(&mut self, error: Error) {
        if !self.is_full() {
            self.errors.push(error);
        }
    }

    pub fn record_all(&mut self, errors: Vec<Error>) {
        errors.into_iter().for_each(|error| self.refuse(error));
    }

    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Whether it is time to stop.
    pub fn is_full(&self) -> bool {
        self.errors.len() >= MOST_KEPT
    }

    /// All of them as one error, in the file's order.
    pub fn end(mut self) -> Result<()> {
        self.errors.sort_by_key(|error| match error {
            Error::Scene { location, .. } => (location.line, location.column),
            _ => (0, 0),
        });
        self.errors.dedup_by_key(|error| error.to_string());
        let more = self.errors.len().saturating_sub(MOST);
        self.errors.truncate(MOST);
        match self.errors.len() {
            0 => Ok(()),
            1 => self.errors.pop().map_or(Ok(()), Err),
            _ => Err(Error::Several { errors: self.errors, more }),
        }
    }
}
