//! The vocabulary of the shaders: the structs, constants and functions of the modules under shaders/data and shaders/lib, but for those that stand
//! behind a choice, and of those that the plan generates. A module that has one of these names gets the module that declares it, without a `//@ use`.
//! A module says what it takes beyond that, such as buffers and choices.

use std::collections::{BTreeMap, HashMap};

use super::reach;

/// The names, with the modules that declare them.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary(HashMap<String, String>);

impl Vocabulary {
    /// Of modules by their names and texts.
    pub fn of<'a>(modules: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vocabulary {
        let names = |(module, text): (&str, &'a str)| {
            let lines: Vec<&str> = text.lines().collect();
            let names = reach::names(&lines).into_iter().map(|name| (name.to_string(), module.to_string()));
            names.collect::<Vec<_>>()
        };
        Vocabulary(modules.into_iter().flat_map(names).collect())
    }

    /// The modules whose names these lines have, each with the index of the first line that does. `own` are the names that the lines declare
    /// themselves. Types and constants begin with a capital, and a function is called.
    pub fn used(&self, lines: &[&str], own: &[&str]) -> BTreeMap<&str, usize> {
        let mut used = BTreeMap::new();
        for (index, code) in lines.iter().map(|line| reach::code(line)).enumerate() {
            for (start, word) in reach::words(code) {
                let is_call = code[start + word.len()..].starts_with('(');
                let is_name = is_call || word.starts_with(|c: char| c.is_ascii_uppercase());
                if is_name && let Some(module) = self.0.get(word).filter(|_| !own.contains(&word)) {
                    used.entry(module.as_str()).or_insert(index);
                }
            }
        }
        used
    }
}
