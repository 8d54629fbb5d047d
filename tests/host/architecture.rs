//! Who may import whom on the host, and that there are no circles: the rules of docs/dev/architecture.md, checked against the sources.

use std::collections::BTreeSet;
use std::path::Path;

use crate::common::files::files as files_of;

/// Parts of the program, and the parts that each never imports.
const NEVER: &str = "
gpu: texture material shape scene flatten plan render bvh film output tradeoff cli
metrics: gpu scene flatten plan render tradeoff commands cli
bvh: gpu scene shape flatten plan render film output tradeoff commands cli
aov: gpu shape scene flatten plan render film output tradeoff commands cli
film: gpu scene flatten plan render bvh tradeoff commands cli
denoise: gpu scene flatten plan render bvh film output tradeoff commands cli
scene: gpu flatten plan render bvh film output tradeoff commands cli
flatten: gpu plan render film output tradeoff commands cli
plan: scene render output tradeoff commands cli
render: scene output tradeoff commands cli
output: gpu scene flatten plan render tradeoff commands cli
data: gpu shape scene flatten plan render film output tradeoff commands cli
error: gpu shape scene flatten plan render film output tradeoff commands cli
options: gpu scene flatten plan render film output tradeoff commands cli
job: gpu scene flatten plan render film output tradeoff commands cli
cluster: gpu scene flatten plan tradeoff cli
material: gpu scene flatten plan render bvh film output tradeoff cli
bitmap: gpu texture material scene flatten plan render film output tradeoff cli
texture: gpu material scene flatten plan render film output tradeoff cli
shape: gpu material scene flatten plan render bvh film output tradeoff cli
delta_light: gpu material scene flatten plan render bvh film output tradeoff commands cli
source: gpu texture material shape scene flatten plan render output tradeoff cli
tradeoff: commands cli
cli: commands
";

fn never() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    NEVER.lines().filter_map(|line| line.split_once(": ")).map(|(part, never)| (part, never.split(' ').collect()))
}

/// All source files with the paths of their modules: `["gpu", "link"]`; of main.rs and lib.rs their own names.
fn sources() -> Vec<(Vec<String>, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    files_of(&root, ".rs", true)
        .into_iter()
        .map(|file| {
            let inner = file.strip_prefix(&root).expect("it is below").with_extension("");
            let mut module: Vec<String> = inner.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            if module.last().is_some_and(|last| last == "mod") {
                module.pop();
            }
            (module, std::fs::read_to_string(&file).expect("a source can be read"))
        })
        .collect()
}

/// The parts of the program that a source names, in `use` lines and in paths.
fn imports(module: &[String], text: &str) -> BTreeSet<String> {
    let file = File { module: module.to_vec(), code: without_comments(text) };
    file.paths().filter_map(|(_, path)| path.into_iter().next()).collect()
}

fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The imports of a source that the rules forbid.
fn violations(module: &[String], text: &str) -> Vec<String> {
    let part = module[0].as_str();
    let imports = imports(module, text);
    let never = never().filter(|(name, _)| *name == part).flat_map(|(_, never)| never);
    let mut found: Vec<String> =
        never.filter(|name| imports.contains(*name)).map(|name| format!("{part} imports {name}")).collect();
    // The commands are the top: only what starts the program knows them.
    if imports.contains("commands") && !["main", "lib", "commands"].contains(&part) && found.is_empty() {
        found.push(format!("{part} imports commands"));
    }
    found
}

#[test]
fn parts_import_what_they_may() {
    let sources = sources();
    let mut seen = 0;
    for (module, text) in &sources {
        seen += imports(module, text).len();
        assert_eq!(violations(module, text), Vec::<String>::new(), "in {}", module.join("/"));
    }
    assert!(sources.len() > 30 && seen > 50, "{} sources, {seen} imports", sources.len());
    // The rules speak of parts that are there.
    let parts: BTreeSet<&str> = sources.iter().map(|(module, _)| module[0].as_str()).collect();
    assert_eq!(never().count(), 24);
    for (part, never) in never() {
        for name in never.into_iter().chain([part]) {
            assert!(parts.contains(name), "there is no part {name}");
        }
    }
}

#[test]
fn a_planted_import_is_found() {
    let module = |path: &str| path.split('/').map(str::to_string).collect::<Vec<_>>();
    for (path, text) in [
        ("gpu/link", "use crate::scene::Scene;\n"),
        ("gpu/link", "use crate::{error::Result, plan::{Plan, Kernel}};\n"),
        ("gpu/link", "use crate::{\n    error::Error,\n    render,\n};\n"),
        ("gpu/link", "fn f() -> crate::flatten::DeviceScene {}\n"),
        ("gpu/link", "use super::super::scene;\n"),
        ("gpu", "use super::scene;\n"),
        ("metrics", "use crate::gpu::device::Device;\n"),
        ("material/metal", "use crate::scene::Scene;\n"),
        ("metrics", "    use gpu_rt::scene::Scene;\n"),
        ("bvh/wide", "use crate::gpu;\n"),
        ("film", "use crate::scene;\n"),
        ("render", "use crate::commands::render;\n"),
        ("timing", "use crate::commands;\n"),
    ] {
        assert_eq!(violations(&module(path), text).len(), 1, "{path}: {text}");
    }
    for (path, text) in [
        ("gpu/link", "// use crate::scene::Scene;\nuse crate::error::Result;\n"),
        ("gpu/link", "use super::render::Other;\n"),
        ("gpu/link", "use other_crate::scene::Scene;\n"),
        ("main", "use gpu_rt::commands;\n"),
        ("commands/render", "use crate::{gpu, scene, commands::plan};\n"),
    ] {
        assert_eq!(violations(&module(path), text), Vec::<String>::new(), "{path}: {text}");
    }
}

/// A file of the sources as the graph of imports sees it.
struct File {
    /// Its module: `["gpu", "link"]`, nothing for lib.rs.
    module: Vec<String>,
    /// Its text without comments, and without its tests, which may import what stands above it.
    code: String,
}

/// The files of modules; main.rs stands above them all.
fn files(sources: impl IntoIterator<Item = (Vec<String>, String)>) -> Vec<File> {
    let file = |(module, text): (Vec<String>, String)| {
        let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        File { module: if module == ["lib"] { Vec::new() } else { module }, code: without_comments(text) }
    };
    sources.into_iter().map(file).filter(|file| file.module != ["main"]).collect()
}

/// The name that a text begins with; `*` counts as one.
fn leading_name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    if text.starts_with('*') { "*" } else { &text[..end] }
}

/// Adds the paths that a text begins with: of `a::{b, c::d}` a::b and a::c::d. Returns the rest of the text.
fn expand<'a>(text: &'a str, above: &[String], found: &mut Vec<Vec<String>>) -> &'a str {
    let mut path = above.to_vec();
    let mut rest = text.trim_start();
    loop {
        if let Some(mut group) = rest.strip_prefix('{') {
            while !group.trim_start().starts_with('}') && !group.trim_start().is_empty() {
                let after = expand(group, &path, found).trim_start();
                group = after.strip_prefix(',').unwrap_or(after);
            }
            return group.trim_start().strip_prefix('}').unwrap_or_default();
        }
        let name = leading_name(rest);
        rest = &rest[name.len()..];
        path.extend((!["", "self"].contains(&name)).then(|| name.to_string()));
        match rest.strip_prefix("::") {
            Some(more) if !name.is_empty() => rest = more,
            _ => break,
        }
    }
    let renamed = rest.trim_start().strip_prefix("as ").map(|name| &name[leading_name(name).len()..]);
    found.push(path);
    let rest = renamed.unwrap_or(rest);
    // Not to stand still at what is no path.
    if rest.len() == text.len() { rest.get(1..).unwrap_or_default() } else { rest }
}

/// The graph of imports between files.
struct Imports<'a> {
    files: &'a [File],
    /// Of each file, the names that it hands on by `pub use`, with their paths from the top.
    handed_on: Vec<Vec<Vec<String>>>,
}

impl<'a> Imports<'a> {
    fn new(files: &'a [File]) -> Imports<'a> {
        let handed_on = files
            .iter()
            .map(|file| file.paths().filter(|(is_handed_on, _)| *is_handed_on))
            .map(|paths| paths.map(|(_, path)| path).collect());
        Imports { files, handed_on: handed_on.collect() }
    }

    /// The files that declare the name at a path from the top. What a file hands on belongs to the file that declares it.
    fn declared_in(&self, path: &[String], depth: usize) -> Vec<usize> {
        let holds = |(_, file): &(usize, &File)| path.starts_with(&file.module);
        let Some((at, file)) = self.files.iter().enumerate().filter(holds).max_by_key(|(_, file)| file.module.len())
        else {
            return Vec::new();
        };
        let Some(name) = path.get(file.module.len()).filter(|_| depth < 8) else { return vec![at] };
        let rest = &path[file.module.len() + 1..];
        let by_name = self.handed_on[at].iter().find(|from| from.last() == Some(name));
        let all = self.handed_on[at].iter().filter(|from| from.last().is_some_and(|last| last == "*"));
        match by_name {
            Some(from) => self.declared_in(&[from, rest].concat(), depth + 1),
            None => all.flat_map(|from| self.declared_in(&from[..from.len() - 1], depth + 1)).chain([at]).collect(),
        }
    }

    /// The files that a file imports.
    fn imports_of(&self, at: usize) -> BTreeSet<usize> {
        let file = &self.files[at];
        // What a file hands on is an import where it uses the name itself.
        let counts =
            |is_handed_on: bool, path: &[String]| !is_handed_on || path.last().is_some_and(|name| file.uses(name));
        let paths = file.paths().filter(|(is_handed_on, path)| counts(*is_handed_on, path));
        paths.flat_map(|(_, path)| self.declared_in(&path, 0)).filter(|other| *other != at).collect()
    }

    /// The circles: the largest sets of files each of which imports, directly or over others, all others of its set.
    fn circles(&self) -> Vec<BTreeSet<String>> {
        let direct: Vec<BTreeSet<usize>> = (0..self.files.len()).map(|at| self.imports_of(at)).collect();
        let reached_from = |at: usize| {
            let (mut reached, mut rest) = (BTreeSet::new(), Vec::from_iter(&direct[at]));
            while let Some(next) = rest.pop() {
                if reached.insert(*next) {
                    rest.extend(&direct[*next]);
                }
            }
            reached
        };
        let reached: Vec<BTreeSet<usize>> = (0..self.files.len()).map(reached_from).collect();
        let circle =
            |at: usize| reached[at].iter().filter(|other| reached[**other].contains(&at)).collect::<BTreeSet<_>>();
        let circles: BTreeSet<_> = (0..self.files.len()).map(circle).filter(|circle| circle.len() > 1).collect();
        let name = |at: &usize| self.files[*at].module.join("/");
        circles.into_iter().map(|circle| circle.into_iter().map(name).collect()).collect()
    }
}

impl File {
    /// The paths within the program that the file names, from the top, and whether it hands them on (`pub use`).
    fn paths(&self) -> impl Iterator<Item = (bool, Vec<String>)> {
        let children = self.code.match_indices("mod ").filter_map(|(at, word)| {
            let name = leading_name(&self.code[at + word.len()..]);
            self.code[at + word.len() + name.len()..].starts_with(';').then_some(name)
        });
        let children: BTreeSet<&str> = children.collect();
        let mut found = Vec::new();
        for (at, _) in self.code.match_indices("::") {
            let before = &self.code[..at];
            let start = before.rfind(|c: char| !c.is_alphanumeric() && c != '_').map_or(0, |end| end + 1);
            // A path begins where no `::` stands before.
            if before[..start].ends_with("::") {
                continue;
            }
            let first = &before[start..];
            let mut paths = Vec::new();
            expand(&self.code[start..], &[], &mut paths);
            let words = before[..start].trim_end();
            let is_handed_on = words.strip_suffix("use").map(str::trim_end).is_some_and(|words| {
                words.ends_with("pub")
                    || words.ends_with(')') && words.rsplit("pub(").next().is_some_and(|scope| scope.len() < 16)
            });
            let from_top = |path: &[String]| {
                let ups = path.iter().take_while(|name| *name == "super").count();
                match first {
                    "crate" | "gpu_rt" => Some(path[1..].to_vec()),
                    "self" => Some([&self.module, path].concat()),
                    "super" => Some([&self.module[..self.module.len().checked_sub(ups)?], &path[ups..]].concat()),
                    first if children.contains(first) => Some([&self.module, path].concat()),
                    _ => None,
                }
            };
            found.extend(paths.iter().filter_map(|path| Some((is_handed_on, from_top(path)?))));
        }
        found.into_iter()
    }

    /// Whether the code has a name outside paths and outside `pub use`.
    fn uses(&self, name: &str) -> bool {
        let statements =
            self.code.split(';').filter(|statement| !statement.contains("pub use ") && !statement.contains(") use "));
        let stands = |statement: &str| {
            statement.match_indices(name).any(|(at, _)| {
                let is_part = |c: char| c.is_alphanumeric() || c == '_';
                let (before, after) = (&statement[..at], &statement[at + name.len()..]);
                !before.ends_with(|c| is_part(c) || c == ':') && !after.starts_with(is_part)
            })
        };
        { statements }.any(stands)
    }
}

#[test]
fn no_module_imports_itself_through_others() {
    let files = files(sources());
    let imports = Imports::new(&files);
    let count: usize = (0..files.len()).map(|at| imports.imports_of(at).len()).sum();
    assert!(count > 500, "{count} imports");
    let circles = imports.circles();
    let listed: Vec<String> = circles.iter().map(|circle| Vec::from_iter(circle.clone()).join(", ")).collect();
    assert!(circles.is_empty(), "{} circles of imports:\n{}", circles.len(), listed.join("\n"));
}

#[test]
fn planted_circles_are_found() {
    let circles_of = |sources: &[(&str, &str)]| {
        let source = |(path, text): &(&str, &str)| (path.split('/').map(str::to_string).collect(), text.to_string());
        let files = files(sources.iter().map(source));
        Imports::new(&files).circles()
    };
    let sources: [&[(&str, &str)]; _] = [
        // Two files.
        &[("a", "use crate::b::B;\n"), ("b", "fn f() -> crate::a::A {}\n")],
        // Three files, by groups and by names of their own.
        &[
            ("a", "use crate::{\n    c::D,\n    b::{self as other, X},\n};\n"),
            ("b", "use super::c;\n"),
            ("c", "use gpu_rt::a::*;\n"),
        ],
        // A parent that uses its child, by `use`, by a path, or by what it hands on.
        &[("a", "mod b;\nuse b::B;\n"), ("a/b", "use super::A;\n")],
        &[("a", "mod b;\nfn f() {\n    b::f();\n}\n"), ("a/b", "use crate::a::A;\n")],
        &[("a", "mod b;\npub use b::{B, C};\nfn f(c: &C) {}\n"), ("a/b", "use super::A;\n")],
        // Over what a folder hands on, by its name and all of it.
        &[("a", "mod b;\nmod c;\npub use b::B;\n"), ("a/b", "use super::c::C;\n"), ("a/c", "use crate::a::B;\n")],
        &[("a", "mod b;\nmod c;\npub(super) use b::*;\n"), ("a/b", "use super::c::C;\n"), ("a/c", "use super::B;\n")],
    ];
    for sources in sources {
        let circles = circles_of(sources);
        assert_eq!(circles.len(), 1, "{sources:?}");
        let expected = if sources.len() == 3 && sources[1].0 == "b" { 3 } else { 2 };
        assert_eq!(circles[0].len(), expected, "{sources:?}");
    }
    // A folder that hands on what is in it, tests, comments, and other crates.
    let none: [&[(&str, &str)]; _] = [
        &[("a", "mod b;\npub use b::B;\npub use b::*;\n"), ("a/b", "use super::A;\n")],
        &[
            ("a", "use crate::b::B;\n"),
            ("b", "// use crate::a::A;\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\n"),
        ],
        &[("a", "use crate::b::B;\n"), ("b", "use other::a::A;\nuse a::A;\n")],
        &[("a", "mod b;\nmod c;\npub use b::B;\n"), ("a/b", "fn f() {}\n"), ("a/c", "use super::B;\n")],
    ];
    for sources in none {
        assert_eq!(circles_of(sources), Vec::<BTreeSet<String>>::new(), "{sources:?}");
    }
}
