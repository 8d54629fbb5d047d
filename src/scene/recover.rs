//! Parses a scene file, and finds the errors behind the first one of a text that does not parse.
//!
//! ron stops at the first error. Where it is about one value, as a wrong type or an unknown field, the entry around the value is
//! replaced by spaces, and the text is parsed again: the next error is another one. What is left in the end is checked like any scene,
//! without the objects, materials and sections that had errors.

use std::collections::{BTreeMap, HashSet};

use serde::{Deserialize, Deserializer};

use super::explain::{Explained, explain, missing_section};
use super::findings::{Findings, MOST};
use super::syntax::{in_file_order, options};
use super::types::*;
use crate::source::{Id, Source, Span, slice};

/// The contents of a scene file, any of which may be absent.
#[derive(Default, Deserialize)]
#[serde(rename = "Scene", deny_unknown_fields)]
pub struct Parts {
    #[serde(default, deserialize_with = "given")]
    pub image: Option<ImageSize>,
    #[serde(default, deserialize_with = "given")]
    pub camera: Option<Camera>,
    #[serde(default, deserialize_with = "given")]
    pub background: Option<Background>,
    #[serde(default, deserialize_with = "in_file_order")]
    pub materials: Vec<(String, Material)>,
    #[serde(default, deserialize_with = "given")]
    pub objects: Option<Vec<Object>>,
    #[serde(default)]
    pub render: RenderDefaults,
}

/// A value that is there; `Option` would also read `None`.
fn given<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// The bytes that are parsed again, all in all: a large file has its first errors listed.
const MOST_BYTES: usize = 1 << 26;

/// The parts of a scene file that have no errors. Those of the others are collected.
///
/// # Errors
/// `Error::Scene` where nothing behind the first error is known.
pub fn parts_of(source: &Source, findings: &mut Findings) -> crate::error::Result<Parts> {
    match options().from_str::<Parts>(source.text()) {
        Ok(parts) => {
            let absent = needed(&parts).into_iter().filter(|(_, is_absent)| *is_absent);
            absent.for_each(|(name, _)| findings.refuse(missing_section(source, name)));
            Ok(parts)
        }
        Err(error) => {
            let parts = recover(source, findings);
            if findings.is_empty() { Err(explain(source, error).error) } else { Ok(parts) }
        }
    }
}

/// Collects the errors of a text that does not parse, and returns the parts of it that have none.
fn recover(source: &Source, findings: &mut Findings) -> Parts {
    let spans = &source.spans;
    // If brackets do not match, the nesting is unknown.
    if spans.mismatch.is_some() || spans.unclosed_bracket.is_some() || spans.unclosed_comment.is_some() {
        return Parts::default();
    }
    let mut blanks = Blanks::default();
    let mut object_blanks = Blanks::default();
    let mut tries = (MOST_BYTES / source.text().len().max(1)).clamp(1, 4 * MOST);
    let mut listed = 0;
    loop {
        let parsed = options().from_str::<Parts>(&blanks.applied(source, false));
        let Err(error) = parsed else { break };
        let Explained { error, offset, about_value, is_missing } = explain(source, error);
        let id = source.spans.at(offset as u32).filter(|_| about_value);
        // Where an entry has been taken out, nothing is missing.
        if !(is_missing && id.is_some_and(|id| blanks.parents.contains(&id))) {
            findings.refuse(error);
            listed += 1;
        }
        tries -= 1;
        let entry = id.and_then(|id| entry_of(source, id)).filter(|_| tries > 0 && listed < MOST);
        let Some(entry) = entry.filter(|&entry| blanks.add(source, entry)) else { return Parts::default() };
        blanks.parents.extend(source.spans.parent(entry));
        object_blanks.add(source, unit_of(source, entry));
    }
    // The text without the objects around the entries. If it does not parse, nothing in it is checked.
    let Ok(parts) = options().from_str::<Parts>(&object_blanks.applied(source, true)) else { return Parts::default() };
    // One with errors is there, and an unknown field may be any of them.
    let names = needed(&parts).map(|(name, _)| name);
    let has_unknown =
        blanks.sections.iter().any(|name| !["materials", "render"].contains(name) && !names.contains(name));
    for (name, is_absent) in needed(&parts) {
        // A section that was taken out for the sake of its errors is there.
        if is_absent && !has_unknown && !object_blanks.sections.contains(name) {
            findings.refuse(missing_section(source, name));
        }
    }
    parts
}

/// The sections that a scene needs, and whether they are absent.
fn needed(parts: &Parts) -> [(&'static str, bool); 4] {
    [
        ("image", parts.image.is_none()),
        ("camera", parts.camera.is_none()),
        ("background", parts.background.is_none()),
        ("objects", parts.objects.is_none()),
    ]
}

/// Entries that are replaced by spaces.
#[derive(Default)]
struct Blanks<'a> {
    /// The ends of the ranges by their starts. They lie apart.
    ranges: BTreeMap<u32, u32>,
    /// The values that they are entries of.
    parents: HashSet<Id>,
    /// The names of those that are sections of the scene.
    sections: HashSet<&'a str>,
}

impl<'a> Blanks<'a> {
    /// Adds an entry with the comma behind it. False if it is gone already, or has no end.
    fn add(&mut self, source: &'a Source, id: Id) -> bool {
        let spans = &source.spans;
        let Some(parent) = spans.parent(id) else { return false };
        if spans.parent(parent).is_none() {
            self.sections.insert(slice(source.text(), spans.key(id)));
        }
        let siblings = spans.children(parent);
        let next = siblings.iter().position(|&sibling| sibling == id).and_then(|at| siblings.get(at + 1));
        let start = spans.entry_start(id);
        let end = match next {
            Some(&next) => spans.entry_start(next),
            None => spans.value(parent).end.saturating_sub(1),
        };
        let before = self.ranges.range(..=start).next_back();
        if end <= start || before.is_some_and(|(_, before)| *before > start) {
            return false;
        }
        let inside: Vec<u32> = self.ranges.range(start..end).map(|(at, _)| *at).collect();
        inside.iter().for_each(|at| _ = self.ranges.remove(at));
        self.ranges.insert(start, end);
        true
    }

    /// The text with spaces in the ranges. Every character behind them keeps its line and column. With `numbered`, an object is replaced by
    /// one without effect where there is room for it, so that the objects behind it keep their numbers.
    fn applied(&self, source: &Source, numbered: bool) -> String {
        let text = source.text();
        let mut applied = String::with_capacity(text.len());
        let mut at = 0;
        for (&start, &end) in &self.ranges {
            applied.push_str(slice(text, Span { start: at, end: start }));
            let blank = slice(text, Span { start, end });
            let id = source.spans.at(start).filter(|&id| numbered && is_object(source, id));
            let nothing = if id.is_some() { NOTHING } else { "" };
            let fits =
                !blank.chars().take(nothing.len()).any(|c| matches!(c, '\n' | '\r')) && blank.len() >= nothing.len();
            // Where it does not fit, the text is none of a scene.
            applied.push_str(if fits { nothing } else { "!" });
            let rest = blank.chars().skip(if fits { nothing.len() } else { 1 });
            applied.extend(rest.map(|c| if matches!(c, '\n' | '\r') { c } else { ' ' }));
            at = end;
        }
        applied.push_str(slice(text, Span { start: at, end: text.len() as u32 }));
        applied
    }
}

/// The innermost value around this one that can be left out: a field, an entry of a map, or an element of a list.
fn entry_of(source: &Source, id: Id) -> Option<Id> {
    let spans = &source.spans;
    let mut id = id;
    loop {
        let parent = spans.parent(id)?;
        if !spans.key(id).is_empty() || slice(source.text(), spans.value(parent)).starts_with('[') {
            return Some(id);
        }
        id = parent;
    }
}

/// An object without effect, and a comma.
const NOTHING: &str = "Group([]),";

/// Whether a value is an object of a list of objects.
fn is_object(source: &Source, id: Id) -> bool {
    let (spans, text) = (&source.spans, source.text());
    let Some(list) = spans.parent(id) else { return false };
    let of_objects = slice(text, spans.key(list)) == "objects";
    let of_group = || spans.parent(list).is_some_and(|group| spans.name(text, group) == "Group");
    slice(text, spans.value(list)).starts_with('[') && (of_objects || of_group())
}

/// The part of the scene around an entry that is not checked: an object of a list, a material, or a section.
fn unit_of(source: &Source, entry: Id) -> Id {
    let spans = &source.spans;
    let mut id = entry;
    while let Some(parent) = spans.parent(id) {
        let is_material = slice(source.text(), spans.key(parent)) == "materials";
        if is_object(source, id) || is_material || spans.parent(parent).is_none() {
            return id;
        }
        id = parent;
    }
    id
}
