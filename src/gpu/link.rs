//! Joins WGSL modules into one text.
//!
//! A module is a file under shaders/, named by its path without the ending. Its directives are comments that start
//! with `//@`:
//! - `//@ use geometry/quad` joins that module once, before this one. `choice/x` is the module whose head says that it implements x
//!   ([`super::modules`]). Modules under shaders/data and shaders/lib are joined where their names are ([`super::vocabulary`]).
//! - `//@ if light` … `//@ end` keeps the lines between, which are members of a struct, if that condition holds ([`super::when`]).
//! - `//@ each material` … `//@ end` repeats the lines between for every entry of that list. In these lines, `${name}` is the
//!   entry's name, `${number}` its number, `${rank}` its index in the list, and `${case}` its case of a switch: `case 2u`, or `default` for
//!   the entry that closes the switch.
//! - `${value}` elsewhere is a value of the plan.
//! - `//@ relies on loops` says that the module is right only on drivers with that property ([`PROPERTIES`]).
//!
//! Blocks cannot be nested, and each closes the braces that it opens. Other lines that start with `//@` are errors.
//!
//! The linker removes comments and the declarations that the entry point does not reach ([`super::reach`]). A module
//! without remaining lines does not count as linked. For each linked module the result has its user and the reason why
//! it is there. It also has the choices and values of the plan that were used.
//!
//! A line table maps each line of the result to its file and line, so that naga's errors can name them.

use std::collections::{BTreeMap, BTreeSet};

use super::kinds;
pub use super::modules::{Chosen, Embedded, Heads, Library};
use super::modules::{WITHOUT, head_of};
use super::numerics::PROPERTIES;
use super::reach;
use super::vocabulary::Vocabulary;
pub use super::when::{Facts, Reason, When, reason_of};
use crate::error::{Error, Result};

/// One entry of a list: a feature that the scene uses, and its number in the scene's data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    pub name: String,
    pub number: u32,
    /// Whether it is the last case of a switch over its list.
    pub closes: bool,
    pub why: Reason,
}

/// The plan's decisions about a kernel, by the names that shaders use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choices {
    pub facts: Facts,
    pub lists: BTreeMap<&'static str, Vec<Entry>>,
    pub values: BTreeMap<String, String>,
    /// Modules that the plan has written, by name.
    pub generated: BTreeMap<&'static str, String>,
}

/// A linked shader: its text, the origin of each line, and its modules.
#[derive(Clone, Debug, Default)]
pub struct Linked {
    pub root: String,
    pub text: String,
    pub lines: Vec<(String, usize)>,
    /// Without those of which only the part after `//@ without` is linked.
    pub modules: Vec<String>,
    /// The properties of the driver that its modules rely on: the property's name, and the module.
    pub relies: Vec<(String, String)>,
    /// For each module except the root, the module that uses it. These links form the best path to the root: the one
    /// with the fewest uses that have a reason of their own, and among those the shortest.
    pub used_by: BTreeMap<String, String>,
    /// The reason for each module, from the conditions, list entries and choices on its path from the root.
    pub why: BTreeMap<String, Reason>,
    /// The choices that it uses, with the chosen modules.
    pub choices: BTreeMap<String, String>,
    /// The plan's values that were filled in, each with a module that uses it.
    pub values: BTreeMap<String, (String, String)>,
}

/// Links `root` with everything it uses.
///
/// # Errors
/// `Error::Shader` with the file and line of an invalid directive, or of one that names a missing module, condition, list or value.
pub fn link(library: &dyn Library, root: &str, choices: &Choices) -> Result<Linked> {
    let mut linker = Linker {
        library,
        choices,
        generated: &Vocabulary::of(choices.generated.iter().map(|(module, text)| (*module, text.as_str()))),
        done: BTreeSet::new(),
        linked: Linked { root: root.to_string(), ..Linked::default() },
        joined: Vec::new(),
        uses: Vec::new(),
        filled: Vec::new(),
    };
    linker.join(root, "(the plan)", 0, &Reason::EveryRender)?;
    Ok(linker.finish())
}

/// The treatment of the lines before `//@ end`.
enum Repetition<'a> {
    /// Kept for this reason, or dropped.
    If(Option<Reason>),
    Each(&'a [Entry]),
}

/// A block that is open: the directive that began it, the treatment of its lines, and the lines so far with their numbers.
struct OpenBlock<'a> {
    begun: &'a str,
    repetition: Repetition<'a>,
    lines: Vec<(usize, &'a str)>,
}

impl OpenBlock<'_> {
    /// The line of the block that closes a brace which the block did not open, or the last one if it leaves one open.
    fn half_a_brace(&self) -> Option<usize> {
        let mut depth = 0i64;
        for (number, line) in &self.lines {
            for c in reach::code(line).chars() {
                depth += i64::from(c == '{') - i64::from(c == '}');
                if depth < 0 {
                    return Some(*number);
                }
            }
        }
        self.lines.last().filter(|_| depth != 0).map(|(number, _)| *number)
    }
}

/// A line of a module: its number, the names of the values in it, and the reason for it.
struct Line {
    number: usize,
    text: String,
    values: Vec<String>,
    why: Reason,
}

/// The use of a module by another one.
struct ModuleUse {
    user: String,
    used: String,
    why: Reason,
}

struct Linker<'a> {
    library: &'a dyn Library,
    choices: &'a Choices,
    /// The names of the plan's generated modules.
    generated: &'a Vocabulary,
    done: BTreeSet<String>,
    linked: Linked,
    /// All lines, including those that the entry point does not reach.
    joined: Vec<String>,
    /// The uses of modules, in the order of joining.
    uses: Vec<ModuleUse>,
    /// The lines of `joined` that have a value, with its name.
    filled: Vec<(usize, String)>,
}

impl<'a> Linker<'a> {
    /// Joins the module of this name, after the modules that it uses. `why` is the reason of the line that uses it.
    fn join(&mut self, name: &str, user: &str, user_line: usize, why: &Reason) -> Result<()> {
        let chosen = match name.strip_prefix("choice/") {
            Some(choice) => {
                let chosen = self.library.heads().choose(choice, &self.choices.facts);
                let chosen = chosen.map_err(|error| fault(user, user_line, &error))?;
                if !chosen.is_without {
                    self.linked.choices.insert(choice.to_string(), chosen.module.clone());
                }
                chosen
            }
            None => Chosen { module: name.to_string(), is_without: false, why: Reason::EveryRender },
        };
        let module = &*chosen.module;
        let part = if chosen.is_without { format!("{module}{OTHER_PART}") } else { module.to_string() };
        self.uses.push(ModuleUse { user: user.to_string(), used: part.clone(), why: chosen.why.or(why) });
        if !self.done.insert(part.clone()) {
            return Ok(());
        }
        let generated = self.choices.generated.get(module).map(String::as_str);
        let text = generated
            .or_else(|| self.library.module(module))
            .ok_or_else(|| fault(user, user_line, &format!("there is no module `{module}`")))?;
        let lines = self.expand(module, text, chosen.is_without)?;
        for Line { number, text, why, .. } in &lines {
            if let Some(used) = text.trim().strip_prefix("//@ use ") {
                self.join(used.trim(), &part, *number, why)?;
            }
            if let Some(property) = text.trim().strip_prefix("//@ relies on ") {
                if !PROPERTIES.iter().any(|known| known.name == property) {
                    return Err(fault(module, *number, &format!("the probe knows no property `{property}`")));
                }
                self.linked.relies.push((property.to_string(), part.clone()));
            }
        }
        let texts: Vec<&str> = lines.iter().map(|line| line.text.as_str()).collect();
        let own = reach::names(&texts);
        for vocabulary in [self.generated, self.library.vocabulary()] {
            for (used, line) in vocabulary.used(&texts, &own) {
                self.join(used, &part, lines[line].number, &lines[line].why)?;
            }
        }
        for Line { number, text, values, .. } in lines {
            if !text.trim_start().starts_with("//@") {
                self.filled.extend(values.into_iter().map(|value| (self.joined.len(), value)));
                self.joined.push(text);
                self.linked.lines.push((part.clone(), number));
            }
        }
        self.linked.modules.push(part);
        Ok(())
    }

    /// Removes what the entry point does not reach.
    fn finish(self) -> Linked {
        let Linker { mut linked, joined, uses, filled, choices, .. } = self;
        let reached = reach::reached(&joined.iter().map(String::as_str).collect::<Vec<_>>());
        let values = filled.into_iter().filter(|(line, _)| reached[*line]);
        let value = |(line, name): (usize, String)| {
            let filled = choices.values.get(&name)?.clone();
            Some((name, (filled, file_of(&linked.lines.get(line)?.0).to_string())))
        };
        linked.values = values.filter_map(value).collect();
        let mut lines = Vec::with_capacity(joined.len());
        let mut kept = BTreeSet::new();
        let all = joined.iter().zip(linked.lines).zip(reached).filter(|(_, reached)| *reached);
        for ((line, (part, number)), _) in all {
            linked.text.push_str(reach::code(line));
            linked.text.push('\n');
            lines.push((file_of(&part).to_string(), number));
            if !kept.contains(&part) && !part.ends_with(OTHER_PART) {
                kept.insert(part);
            }
        }
        linked.lines = lines;
        linked.modules.retain(|module| kept.contains(module));
        linked.relies.retain(|(_, module)| kept.contains(module));
        linked.choices.retain(|_, module| kept.contains(module));
        (linked.used_by, linked.why) = users(&linked.root, &uses, &kept);
        linked
    }

    /// Keeps, drops or repeats the lines of blocks, and fills in values. Every line keeps its number in the file.
    fn expand(&self, module: &str, text: &str, is_without: bool) -> Result<Vec<Line>> {
        let mut out = Vec::new();
        let mut block: Option<OpenBlock<'_>> = None;
        for (number, line) in lines_of_part(text, is_without) {
            let trimmed = line.trim();
            // Most lines are no directives.
            let words: Vec<&str> =
                if trimmed.starts_with("//@") { trimmed.split_whitespace().collect() } else { Vec::new() };
            let begins = match words[..] {
                ["//@", "if", _, ..] => {
                    let condition = When::parse(trimmed.trim_start_matches("//@ if "));
                    let reason = condition.and_then(|when| when.reason(&self.choices.facts));
                    Some(Repetition::If(reason.map_err(|error| fault(module, number, &error))?))
                }
                ["//@", "each", name] => {
                    let list = self.choices.lists.get(name);
                    let list = list.ok_or_else(|| fault(module, number, &format!("the plan has no list `{name}`")))?;
                    Some(Repetition::Each(list))
                }
                _ => None,
            };
            if let Some(repetition) = begins {
                if let Some(OpenBlock { begun, .. }) = block {
                    return Err(fault(module, number, &format!("`{trimmed}` within `{begun}`")));
                }
                block = Some(OpenBlock { begun: trimmed, repetition, lines: Vec::new() });
            } else if words == ["//@", "end"] {
                let ended =
                    block.take().ok_or_else(|| fault(module, number, "`//@ end` without `//@ if` or `//@ each`"))?;
                self.close(module, ended, &mut out)?;
            } else if trimmed.starts_with("//@") && !matches!(words[..], ["//@", "use", _] | ["//@", "relies", "on", _])
            {
                return Err(fault(module, number, &format!("`{trimmed}` is no directive of the linker")));
            } else if let Some(block) = &mut block {
                block.lines.push((number, line));
            } else {
                out.push(self.fill(module, number, line, &Reason::EveryRender)?);
            }
        }
        match block {
            Some(OpenBlock { begun, .. }) => {
                Err(fault(module, text.lines().count(), &format!("`{begun}` without `//@ end`")))
            }
            None => Ok(out),
        }
    }

    /// Adds the lines of a block that has ended.
    fn close(&self, module: &str, block: OpenBlock<'_>, out: &mut Vec<Line>) -> Result<()> {
        if let Some(number) = block.half_a_brace() {
            return Err(fault(module, number, &format!("half a brace within `{}`", block.begun)));
        }
        match block.repetition {
            Repetition::If(None) => {}
            Repetition::If(Some(why)) => {
                for (number, line) in block.lines {
                    out.push(self.fill(module, number, line, &why)?);
                }
            }
            Repetition::Each(entries) => {
                out.extend((0..).zip(entries).flat_map(|entry| repeated(entry, &block.lines)));
            }
        }
        Ok(())
    }

    fn fill(&self, module: &str, number: usize, line: &str, why: &Reason) -> Result<Line> {
        let mut rest = line;
        let mut out = String::with_capacity(line.len());
        let mut values = Vec::new();
        while let Some((before, after)) = rest.split_once("${") {
            let (name, tail) = after.split_once('}').ok_or_else(|| fault(module, number, "`${` without `}`"))?;
            let known = self.choices.values.get(name);
            let value = known.ok_or_else(|| fault(module, number, &format!("the plan has no value `{name}`")))?;
            out.push_str(before);
            out.push_str(value);
            values.push(name.to_string());
            rest = tail;
        }
        out.push_str(rest);
        Ok(Line { number, text: out, values, why: why.clone() })
    }
}

/// The lines of a block of `each` for one entry, with its index in the list.
fn repeated((rank, entry): (u32, &Entry), lines: &[(usize, &str)]) -> Vec<Line> {
    let case = if entry.closes { "default".to_string() } else { format!("case {}u", entry.number) };
    let line = |(number, line): &(usize, &str)| {
        let text = line
            .replace("${name}", &entry.name)
            .replace("${number}", &entry.number.to_string())
            .replace("${rank}", &rank.to_string())
            .replace("${case}", &case);
        Line { number: *number, text, values: Vec::new(), why: entry.why.clone() }
    };
    lines.iter().map(line).collect()
}

/// The user of each kept module, and the reason for the module. Both come from the path from the root with the fewest
/// uses that have a reason of their own, and among those the shortest. Modules without kept lines are skipped.
fn users(
    root: &str,
    uses: &[ModuleUse],
    kept: &BTreeSet<String>,
) -> (BTreeMap<String, String>, BTreeMap<String, Reason>) {
    // The best paths so far: the number of uses with a reason, the number of all uses, the nearest kept module before,
    // and the reason.
    let mut ways = BTreeMap::from([(root, ((0, 0), root, &Reason::EveryRender))]);
    let mut better = true;
    while std::mem::take(&mut better) {
        for ModuleUse { user, used, why } in uses {
            let Some(&((reasons, all), nearest, inherited)) = ways.get(user.as_str()) else { continue };
            let user = if kept.contains(user) { user } else { nearest };
            let (reasons, why) = if *why == Reason::EveryRender { (reasons, inherited) } else { (reasons + 1, why) };
            let cost = (reasons, all + 1);
            if ways.get(used.as_str()).is_none_or(|(known, ..)| cost < *known) {
                ways.insert(used, (cost, user, why));
                better = true;
            }
        }
    }
    ways.retain(|module, _| kept.contains(*module));
    let users = ways.iter().filter(|(module, _)| **module != root);
    let users = users.map(|(module, (_, user, _))| (module.to_string(), user.to_string())).collect();
    (users, ways.into_iter().map(|(module, (.., why))| (module.to_string(), why.clone())).collect())
}

/// What follows the name of a module for its part after `//@ without`.
const OTHER_PART: &str = " without";

fn file_of(part: &str) -> &str {
    part.strip_suffix(OTHER_PART).unwrap_or(part)
}

/// The lines of a part of a module, with their numbers in the file: those before `//@ without` but for the head, or those after it.
fn lines_of_part(text: &str, is_without: bool) -> impl Iterator<Item = (usize, &str)> {
    let head = text.lines().take_while(|line| head_of(line).is_some()).count();
    let all = text.lines().count();
    let other = text.lines().position(|line| line == WITHOUT).unwrap_or(all);
    let (start, end) = if is_without { (other + 1, all) } else { (head, other) };
    (1..).zip(text.lines()).take(end).skip(start)
}

fn fault(part: &str, line: usize, message: &str) -> Error {
    Error::Shader(format!("shaders/{}.wgsl:{line}: {message}", file_of(part)))
}

impl Linked {
    /// Parses and validates the text. Errors name the file and line of the origin.
    pub fn validate(&self) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
        let module = naga::front::wgsl::parse_str(&self.text).map_err(|error| {
            let unknown = error.message().strip_prefix("no definition in scope for identifier: `");
            let name = unknown.and_then(|rest| rest.strip_suffix('`'));
            let missing =
                name.and_then(|name| kinds::missing(name, |kind| self.modules.iter().any(|known| known == kind)));
            self.fault_at(error.location(&self.text), missing.as_deref().unwrap_or(error.message()))
        })?;
        let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .map_err(|error| {
                let cause =
                    std::error::Error::source(error.as_inner()).map_or(String::new(), |source| format!(": {source}"));
                self.fault_at(error.location(&self.text), &format!("{}{cause}", error.as_inner()))
            })?;
        Ok((module, info))
    }

    fn fault_at(&self, location: Option<naga::SourceLocation>, message: &str) -> Error {
        let origin = location
            .and_then(|location| {
                let (module, line) = self.lines.get(location.line_number as usize - 1)?;
                Some((module.as_str(), *line, location.line_position))
            })
            .unwrap_or((&self.root, 0, 0));
        Error::Shader(format!("shaders/{}.wgsl:{}:{}: {message}", origin.0, origin.1, origin.2))
    }
}
