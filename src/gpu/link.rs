//! Joins WGSL modules into one text.
//!
//! A module is a file under shaders/, named by its path without the ending. Its directives are comments that start
//! with `//@`:
//! - `//@ use lib/rng` joins that module once, before this one. `choice/x` is whatever module the plan chose for x.
//! - `//@ each material` … `//@ end` repeats the lines between for every entry of that list. Within, `${name}` is the
//!   entry's name, `${number}` its number, `${rank}` its place in the list, and `${case}` the selector of a switch: `case 2u`, or `default` for
//!   an entry that closes it. A list of one entry or none makes its lines conditional.
//! - `${value}` elsewhere is a value of the plan.
//! - `//@ relies on loops` says that the module is right only on drivers with that property ([`super::probe::PROPERTIES`]).
//!
//! Other lines that start with `//@` are errors.
//!
//! Of what is joined, declarations that the entry point does not reach are left out, and comments ([`super::reach`]); a module of which
//! nothing is left has not been linked. Of what is left the result says who uses it, and which of the plan's choices and values it has.
//!
//! A line table tells which file and line each line of the result came from, so that naga's errors can name them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::LazyLock;

use super::probe::PROPERTIES;
use super::reach;
use crate::error::{Error, Result};

/// One entry of a list: a feature that the scene uses, and the number by which the scene's data names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    pub name: String,
    pub number: u32,
    /// Whether it is the last case of a switch over its list.
    pub closes: bool,
}

/// What the plan decided about a kernel: the modules behind `choice/…`, the lists, and the values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choices {
    pub modules: BTreeMap<&'static str, &'static str>,
    pub lists: BTreeMap<&'static str, Vec<Entry>>,
    pub values: BTreeMap<&'static str, String>,
}

/// A linked shader: its text, the place each of its lines came from, and the modules in it.
#[derive(Clone, Debug)]
pub struct Linked {
    pub root: String,
    pub text: String,
    pub lines: Vec<(String, usize)>,
    pub modules: Vec<String>,
    /// What of the driver its modules rely on: a property's name, and the module.
    pub relies: Vec<(String, String)>,
    /// For each module but the root the one that uses it, nearest to the root: going on from there leads to the root.
    pub used_by: BTreeMap<String, String>,
    /// The choices that it has, with the modules chosen.
    pub choices: BTreeMap<&'static str, String>,
    /// The plan's values that were filled into its lines.
    pub values: BTreeMap<&'static str, String>,
}

/// Where module texts come from: the shaders compiled into the program, and in tests more beside them.
pub trait Library {
    fn module(&self, name: &str) -> Option<&str>;
}

/// The shaders under shaders/: compiled into the program, but read from disk where debug assertions are on, so that an edit of a shader
/// compiles nothing.
pub struct Embedded;

#[cfg(not(debug_assertions))]
static TEXTS: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    use include_dir::{Dir, include_dir};
    static SHADERS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/shaders");
    fn walk(dir: &'static Dir<'static>, texts: &mut BTreeMap<String, String>) {
        texts.extend(dir.files().filter_map(|file| {
            let name = file.path().to_str()?.strip_suffix(".wgsl")?;
            Some((name.replace('\\', "/"), file.contents_utf8()?.to_string()))
        }));
        dir.dirs().for_each(|dir| walk(dir, texts));
    }
    let mut texts = BTreeMap::new();
    walk(&SHADERS, &mut texts);
    texts
});

#[cfg(debug_assertions)]
static TEXTS: LazyLock<BTreeMap<String, String>> = LazyLock::new(|| {
    use std::path::Path;
    fn walk(root: &Path, dir: &Path, texts: &mut BTreeMap<String, String>) {
        for path in std::fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                walk(root, &path, texts);
            } else if let Some(name) = path.strip_prefix(root).ok().and_then(|p| p.to_str()?.strip_suffix(".wgsl"))
                && let Ok(text) = std::fs::read_to_string(&path)
            {
                texts.insert(name.replace('\\', "/"), text);
            }
        }
    }
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders"));
    let mut texts = BTreeMap::new();
    walk(root, root, &mut texts);
    texts
});

impl Library for Embedded {
    fn module(&self, name: &str) -> Option<&str> {
        TEXTS.get(name).map(String::as_str)
    }
}

impl Embedded {
    /// The names of all modules, sorted.
    pub fn names() -> Vec<String> {
        TEXTS.keys().cloned().collect()
    }
}

/// Links `root` with everything it uses.
///
/// # Errors
/// `Error::Shader` naming the file and line of a directive that is none, or names a module, list or value which does not exist.
pub fn link(library: &dyn Library, root: &str, choices: &Choices) -> Result<Linked> {
    let mut linker = Linker {
        library,
        choices,
        done: BTreeSet::new(),
        linked: Linked {
            root: root.to_string(),
            text: String::new(),
            lines: Vec::new(),
            modules: Vec::new(),
            relies: Vec::new(),
            used_by: BTreeMap::new(),
            choices: BTreeMap::new(),
            values: BTreeMap::new(),
        },
        joined: Vec::new(),
        uses: Vec::new(),
        filled: Vec::new(),
    };
    linker.join(root, "(the plan)", 0)?;
    Ok(linker.finish())
}

/// The entries that a block of `each` is repeated for, and its lines with their numbers.
type Block<'a> = (&'a [Entry], Vec<(usize, &'a str)>);

/// A line of a module, its number, and the names of the values filled in.
struct Line {
    number: usize,
    text: String,
    values: Vec<&'static str>,
}

struct Linker<'a> {
    library: &'a dyn Library,
    choices: &'a Choices,
    done: BTreeSet<String>,
    linked: Linked,
    /// All lines, reached or not.
    joined: Vec<String>,
    /// Which module uses which, in the order in which they were joined.
    uses: Vec<(String, String)>,
    /// Which line of `joined` has which value.
    filled: Vec<(usize, &'static str)>,
}

impl Linker<'_> {
    fn join(&mut self, name: &str, user: &str, user_line: usize) -> Result<()> {
        let module = match name.strip_prefix("choice/") {
            Some(choice) => {
                let chosen = self.choices.modules.get_key_value(choice);
                let (choice, module) =
                    chosen.ok_or_else(|| fault(user, user_line, &format!("the plan chose no module for `{name}`")))?;
                self.linked.choices.insert(choice, (*module).to_string());
                module
            }
            None => name,
        };
        self.uses.push((user.to_string(), module.to_string()));
        if !self.done.insert(module.to_string()) {
            return Ok(());
        }
        let text = self
            .library
            .module(module)
            .ok_or_else(|| fault(user, user_line, &format!("there is no module `{module}`")))?;
        let lines = self.expand(module, text)?;
        for Line { number, text, .. } in &lines {
            if let Some(used) = text.trim().strip_prefix("//@ use ") {
                self.join(used.trim(), module, *number)?;
            }
            if let Some(property) = text.trim().strip_prefix("//@ relies on ") {
                if !PROPERTIES.iter().any(|known| known.name == property) {
                    return Err(fault(module, *number, &format!("the probe knows no property `{property}`")));
                }
                self.linked.relies.push((property.to_string(), module.to_string()));
            }
        }
        for Line { number, text, values } in lines {
            if !text.trim_start().starts_with("//@") {
                self.filled.extend(values.into_iter().map(|value| (self.joined.len(), value)));
                self.joined.push(text);
                self.linked.lines.push((module.to_string(), number));
            }
        }
        self.linked.modules.push(module.to_string());
        Ok(())
    }

    /// Leaves out what the entry point does not reach.
    fn finish(self) -> Linked {
        let Linker { mut linked, joined, uses, filled, choices, .. } = self;
        let reached = reach::reached(&joined);
        let values = filled.into_iter().filter(|(line, _)| reached[*line]);
        linked.values = values.filter_map(|(_, name)| Some((name, choices.values.get(name)?.clone()))).collect();
        let mut places = Vec::with_capacity(joined.len());
        let mut kept = BTreeSet::new();
        for ((line, place), _) in joined.iter().zip(linked.lines).zip(reached).filter(|(_, reached)| *reached) {
            linked.text.push_str(reach::code(line));
            linked.text.push('\n');
            if !kept.contains(&place.0) {
                kept.insert(place.0.clone());
            }
            places.push(place);
        }
        linked.lines = places;
        linked.modules.retain(|module| kept.contains(module));
        linked.relies.retain(|(_, module)| kept.contains(module));
        linked.choices.retain(|_, module| kept.contains(module));
        linked.used_by = nearest_users(&linked.root, &uses, &kept);
        linked
    }

    /// Repeats the blocks of `each` and fills in the values; every line keeps the number it had in its file.
    fn expand(&self, module: &str, text: &str) -> Result<Vec<Line>> {
        let mut out = Vec::new();
        let mut block: Option<Block<'_>> = None;
        for (number, line) in (1..).zip(text.lines()) {
            let directive = line.trim().strip_prefix("//@ ");
            if let Some(list) = directive.and_then(|d| d.strip_prefix("each ")) {
                let entries = self
                    .choices
                    .lists
                    .get(list.trim())
                    .ok_or_else(|| fault(module, number, &format!("the plan has no list `{}`", list.trim())))?;
                if block.is_some() {
                    return Err(fault(module, number, "`//@ each` within `//@ each`"));
                }
                block = Some((entries, Vec::new()));
            } else if directive == Some("end") {
                let (entries, body) =
                    block.take().ok_or_else(|| fault(module, number, "`//@ end` without `//@ each`"))?;
                for (rank, entry) in entries.iter().enumerate() {
                    let case = match entry.closes {
                        true => "default".to_string(),
                        false => format!("case {}u", entry.number),
                    };
                    for (number, line) in &body {
                        let text = line
                            .replace("${name}", &entry.name)
                            .replace("${number}", &entry.number.to_string())
                            .replace("${rank}", &rank.to_string())
                            .replace("${case}", &case);
                        out.push(Line { number: *number, text, values: Vec::new() });
                    }
                }
            } else if line.trim().starts_with("//@")
                && !directive.is_some_and(|d| JOINED.iter().any(|start| d.starts_with(start)))
            {
                return Err(fault(module, number, &format!("`{}` is no directive of the linker", line.trim())));
            } else if let Some((_, body)) = &mut block {
                body.push((number, line));
            } else {
                out.push(self.fill(module, number, line)?);
            }
        }
        match block {
            Some(_) => Err(fault(module, text.lines().count(), "`//@ each` without `//@ end`")),
            None => Ok(out),
        }
    }

    fn fill(&self, module: &str, number: usize, line: &str) -> Result<Line> {
        let mut rest = line;
        let mut out = String::with_capacity(line.len());
        let mut values = Vec::new();
        while let Some((before, after)) = rest.split_once("${") {
            let (name, tail) = after.split_once('}').ok_or_else(|| fault(module, number, "`${` without `}`"))?;
            let known = self.choices.values.get_key_value(name);
            let (name, value) =
                known.ok_or_else(|| fault(module, number, &format!("the plan has no value `{name}`")))?;
            out.push_str(before);
            out.push_str(value);
            values.push(*name);
            rest = tail;
        }
        out.push_str(rest);
        Ok(Line { number, text: out, values })
    }
}

/// The user of each module that is kept, on a shortest way to the root; modules of which nothing is kept are passed over.
fn nearest_users(root: &str, uses: &[(String, String)], kept: &BTreeSet<String>) -> BTreeMap<String, String> {
    let mut users = BTreeMap::new();
    let mut seen = BTreeSet::from([root]);
    // A module, and the nearest kept one on the way to it.
    let mut waiting = VecDeque::from([(root, root)]);
    while let Some((module, nearest)) = waiting.pop_front() {
        for (_, used) in uses.iter().filter(|(user, _)| user == module) {
            if !seen.insert(used) {
                continue;
            }
            let is_kept = kept.contains(used);
            if is_kept {
                users.insert(used.clone(), nearest.to_string());
            }
            waiting.push_back((used, if is_kept { used } else { nearest }));
        }
    }
    users
}

/// How the directives begin that stay until modules are joined.
const JOINED: [&str; 2] = ["use ", "relies on "];

fn fault(module: &str, line: usize, message: &str) -> Error {
    Error::Shader(format!("shaders/{module}.wgsl:{line}: {message}"))
}

impl Linked {
    /// Parses and validates the text; an error names the file and line that it came from.
    pub fn validate(&self) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
        let module = naga::front::wgsl::parse_str(&self.text)
            .map_err(|error| self.fault_at(error.location(&self.text), error.message()))?;
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
        let place = location
            .and_then(|location| {
                let (module, line) = self.lines.get(location.line_number as usize - 1)?;
                Some((module.as_str(), *line, location.line_position))
            })
            .unwrap_or((&self.root, 0, 0));
        Error::Shader(format!("shaders/{}.wgsl:{}:{}: {message}", place.0, place.1, place.2))
    }
}
