//! Who may import whom on the host: the rules of docs/architecture.md, checked against the sources.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A part of the program and the parts that it never imports.
const NEVER: &[(&str, &[&str])] = &[
    (
        "gpu",
        &[
            "texture", "material", "shape", "scene", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff",
            "cli",
        ],
    ),
    ("metrics", &["gpu", "scene", "flatten", "plan", "render", "tradeoff", "commands", "cli"]),
    ("bvh", &["gpu", "scene", "shape", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("aov", &["gpu", "shape", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("film", &["gpu", "scene", "flatten", "plan", "render", "bvh", "tradeoff", "commands", "cli"]),
    ("denoise", &["gpu", "scene", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff", "commands", "cli"]),
    ("scene", &["gpu", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff", "commands", "cli"]),
    ("flatten", &["gpu", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("plan", &["scene", "render", "output", "tradeoff", "commands", "cli"]),
    ("render", &["scene", "output", "tradeoff", "commands", "cli"]),
    ("output", &["gpu", "scene", "flatten", "plan", "render", "tradeoff", "commands", "cli"]),
    ("data", &["gpu", "shape", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("error", &["gpu", "shape", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("options", &["gpu", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("job", &["gpu", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "commands", "cli"]),
    ("jobs", &["gpu", "scene", "flatten", "plan", "tradeoff", "cli"]),
    ("material", &["gpu", "scene", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff", "cli"]),
    (
        "bitmap",
        &["gpu", "texture", "material", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "cli"],
    ),
    ("texture", &["gpu", "material", "scene", "flatten", "plan", "render", "film", "output", "tradeoff", "cli"]),
    ("shape", &["gpu", "material", "scene", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff", "cli"]),
    (
        "delta_light",
        &[
            "gpu", "material", "scene", "flatten", "plan", "render", "bvh", "film", "output", "tradeoff", "commands",
            "cli",
        ],
    ),
    (
        "source",
        &["gpu", "texture", "material", "shape", "scene", "flatten", "plan", "render", "output", "tradeoff", "cli"],
    ),
    ("tradeoff", &["commands", "cli"]),
    ("cli", &["commands"]),
];

/// All source files with the paths of their modules: `["gpu", "link"]`; of main.rs and lib.rs their own names.
fn sources() -> Vec<(Vec<String>, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("src can be listed") {
            let path = entry.expect("src can be listed").path();
            match path.is_dir() {
                true => walk(&path, found),
                false if path.extension().is_some_and(|ending| ending == "rs") => found.push(path),
                false => {}
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    walk(&root, &mut files);
    files.sort();
    files
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

/// The first names behind a path's beginning: of `crate::a::b` a, of `crate::{a, b::{c, d}}` a and b.
fn first_names(rest: &str) -> Vec<String> {
    let name =
        |text: &str| text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let Some(group) = rest.strip_prefix('{') else { return vec![name(rest)] };
    let mut names = vec![name(group)];
    let mut depth = 1;
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => names.push(name(&group[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// The parts of the program that a source names, in `use` lines and in paths: by `crate::`, by the crate's name, or by as
/// many `super::` as lead to the top.
fn imports(module: &[String], text: &str) -> BTreeSet<String> {
    let code: String = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .fold(String::new(), |all, line| all + line + "\n");
    let to_top = "super::".repeat(module.len());
    let mut found = BTreeSet::new();
    for beginning in ["crate::", "gpu_rt::", &to_top] {
        for (at, _) in code.match_indices(beginning) {
            let before = code[..at].chars().next_back();
            // Within a longer name or a longer row of supers it is something else.
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            found.extend(first_names(&code[at + beginning.len()..]));
        }
    }
    found
}

/// The imports of a source that the rules forbid.
fn violations(module: &[String], text: &str) -> Vec<String> {
    let part = module[0].as_str();
    let imports = imports(module, text);
    let never = NEVER.iter().find(|(name, _)| *name == part).map_or(&[][..], |(_, never)| never);
    let mut found: Vec<String> =
        never.iter().filter(|name| imports.contains(**name)).map(|name| format!("{part} imports {name}")).collect();
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
    for (part, never) in NEVER {
        for name in never.iter().chain([part]) {
            assert!(parts.contains(name), "there is no part {name}");
        }
    }
}

#[test]
fn a_planted_import_is_found() {
    let module = |path: &str| path.split('/').map(str::to_string).collect::<Vec<_>>();
    for (place, text) in [
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
        assert_eq!(violations(&module(place), text).len(), 1, "{place}: {text}");
    }
    for (place, text) in [
        ("gpu/link", "// use crate::scene::Scene;\nuse crate::error::Result;\n"),
        ("gpu/link", "use super::render::Other;\n"),
        ("gpu/link", "use other_crate::scene::Scene;\n"),
        ("main", "use gpu_rt::commands;\n"),
        ("commands/render", "use crate::{gpu, scene, commands::plan};\n"),
    ] {
        assert_eq!(violations(&module(place), text), Vec::<String>::new(), "{place}: {text}");
    }
}
