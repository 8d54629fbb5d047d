//! What the documentation says holds: its links lead somewhere, and its scenes load.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use gpu_rt::scene::Scene;

use crate::common::files::files;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn documents() -> Vec<PathBuf> {
    let mut all = vec![root().join("README.md")];
    all.extend(files("docs", ".md", true));
    all
}

/// The lines of a Markdown text outside its code blocks, without what stands between backticks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let mut out = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            // A lone backtick opens nothing.
            let parts = line.split('`').collect::<Vec<_>>();
            let step = if parts.len() % 2 == 1 { 2 } else { 1 };
            parts.into_iter().step_by(step).for_each(|part| out.push_str(part));
            out.push('\n');
        }
    }
    out
}

/// The targets of `[words](target)` and `![words](target)`.
fn targets(text: &str) -> Vec<String> {
    let prose = prose(text);
    let after = prose.split("](").skip(1);
    after.filter_map(|rest| Some(rest.split_once(')')?.0.to_string())).collect()
}

/// The anchor that a Markdown heading gets: lower case, hyphens for spaces, nothing but letters, digits, hyphens and
/// underscores.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    text.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
}

fn anchors(text: &str) -> BTreeSet<String> {
    prose(text).lines().filter(|line| line.starts_with('#')).map(anchor).collect()
}

/// What is wrong with the relative links of a text that lies in a folder.
fn broken_links(text: &str, folder: &Path) -> Vec<String> {
    let mut broken = Vec::new();
    for target in targets(text) {
        if target.starts_with("https://") || target.starts_with("http://") {
            continue;
        }
        let (file, heading) = target.split_once('#').unwrap_or((&target, ""));
        let path = folder.join(file);
        if Path::new(file).is_absolute() || !path.exists() {
            broken.push(format!("{target}: there is no such file"));
        } else if !heading.is_empty() {
            let there = if file.is_empty() { text.to_string() } else { read(&path) };
            if !anchors(&there).contains(heading) {
                broken.push(format!("{target}: there is no such heading"));
            }
        }
    }
    broken
}

#[test]
fn every_link_leads_somewhere() {
    let mut links = 0;
    let mut broken = Vec::new();
    for document in documents() {
        let text = read(&document);
        links += targets(&text).len();
        let folder = document.parent().expect("a file lies in a folder");
        broken.extend(broken_links(&text, folder).iter().map(|link| format!("{}: {link}", document.display())));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(links > 50, "only {links} links were found: the reader of links is broken");
}

#[test]
fn a_broken_link_is_found() {
    let text = "# Here\n[a](Cargo.toml) [b](no/such.md) ![c](no.png) [d](#here) [e](#gone) [f](README.md#no-such)\n\
                ```\n[g](in/code.md)\n```\n`[h](quoted.md)` [i](https://example.com/x) [j](/etc/hosts)\n";
    let broken = broken_links(text, root());
    let names: Vec<_> = broken.iter().map(|link| link.split(':').next().unwrap_or_default()).collect();
    assert_eq!(names, ["no/such.md", "no.png", "#gone", "README.md#no-such", "/etc/hosts"]);
}

/// The bullets of a section of a Markdown text, each joined to one line.
fn bullets(text: &str, heading: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for line in text.lines().skip_while(|line| *line != heading).skip(1).take_while(|line| !line.starts_with('#')) {
        match (line.strip_prefix("- "), line.strip_prefix("  "), found.last_mut()) {
            (Some(start), ..) => found.push(start.to_string()),
            (None, Some(more), Some(last)) => *last += &format!(" {more}"),
            _ => {}
        }
    }
    found
}

/// The tests that a bullet names, as "[`words`](FILE.rs): `test`, `test`", with their files.
fn named_tests(bullet: &str) -> Vec<(String, String)> {
    let mut named = Vec::new();
    for rest in bullet.split("](").skip(1) {
        let Some((file, names)) = rest.split_once("): `") else { continue };
        if !file.ends_with(".rs") {
            continue;
        }
        for name in format!("`{names}").split(", ") {
            let Some((name, after)) = name.strip_prefix('`').and_then(|name| name.split_once('`')) else { break };
            named.push((file.to_string(), name.to_string()));
            if !after.is_empty() {
                break;
            }
        }
    }
    named
}

/// What is wrong with the tests that promises name: none is named, or one that its file does not have.
fn unkept(promises: &[String]) -> Vec<String> {
    let mut wrong = Vec::new();
    for promise in promises {
        let named = named_tests(promise);
        if named.is_empty() {
            wrong.push(format!("no test: {promise}"));
        }
        for (file, name) in named {
            let text = fs::read_to_string(root().join("docs").join(&file)).unwrap_or_default();
            let is = |line: &str| line.trim_start().starts_with(&format!("fn {name}("));
            let lines: Vec<&str> = text.lines().collect();
            let test = |at: usize| lines[..at].iter().rev().take(4).any(|line| line.trim() == "#[test]");
            if !lines.iter().enumerate().any(|(at, line)| is(line) && test(at)) {
                wrong.push(format!("{file} has no test {name}"));
            }
        }
    }
    wrong
}

/// A newcomer reads it to its end.
#[test]
fn the_readme_is_short_and_begins_with_what_it_is_and_the_two_commands() {
    let readme = read(&root().join("README.md"));
    let lines: Vec<&str> = readme.lines().collect();
    assert!(lines.len() <= 150, "{} lines", lines.len());
    let first = &lines[..25];
    assert!(first.iter().any(|line| line.contains("![")));
    for command in ["make render ", "make test "] {
        assert!(first.iter().any(|line| line.starts_with(command)), "{command}");
    }
}

/// What grows by a sentence here and there is read by nobody. Figures by the hundred belong into files beside the documents.
#[test]
fn the_documents_have_at_most_60000_words() {
    let words: usize = documents().iter().map(|path| read(path).split_whitespace().count()).sum();
    assert!(words <= 60_000, "{words} words: say each thing once, and link to it");
}

#[test]
fn every_promise_names_tests_that_exist() {
    let promises = bullets(&read(&root().join("docs/promises.md")), "# What it promises");
    assert!(promises.len() >= 8, "{promises:?}");
    assert_eq!(unkept(&promises), Vec::<String>::new());
    let named: usize = promises.iter().map(|promise| named_tests(promise).len()).sum();
    assert!(named >= 20, "only {named} tests were found: the reader of names is broken");
}

#[test]
fn a_promise_that_no_test_keeps_is_found() {
    let text = "## A\n- **Kept.** So it is ([`d`](../tests/host/docs.rs):\n  `a_broken_link_is_found`, `every_link_leads_somewhere`; [`d`](../tests/host/docs.rs): `gone`).\n\
                - **Not.** See [there](docs/dev/conventions.md): `x`.\n- **No test.** ([`d`](../tests/host/docs.rs): `root`) [`e`](../tests/no.rs): `f`\n## B\n- no promise\n";
    let promises = bullets(text, "## A");
    assert_eq!(named_tests(&promises[0]).len(), 3);
    let wrong = unkept(&promises);
    let starts = [
        "../tests/host/docs.rs has no test gone",
        "no test: **Not.**",
        "../tests/host/docs.rs has no test root",
        "../tests/no.rs has no test f",
    ];
    assert_eq!(wrong.len(), starts.len(), "{wrong:?}");
    assert!(wrong.iter().zip(starts).all(|(wrong, start)| wrong.starts_with(start)), "{wrong:?}");
}

#[test]
fn every_scene_loads_without_a_warning() {
    let scenes = files("scenes", ".ron", false);
    assert!(scenes.len() >= 10, "{scenes:?}");
    for path in scenes {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.warnings(), Vec::<String>::new());
        assert!(!scene.objects.is_empty(), "{}", path.display());
    }
}

#[test]
fn the_example_of_the_readme_is_a_scene_that_needs_no_files() {
    let readme = read(&root().join("README.md"));
    let examples: Vec<_> = readme.split("```ron\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(examples.len(), 1);
    let empty = tempfile::tempdir().expect("a temporary folder");
    let scene = Scene::parse(examples[0], &empty.path().join("scene.ron")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.warnings(), Vec::<String>::new());
    let flat = gpu_rt::flatten::flatten(&scene, (640, 360), &gpu_rt::options::RenderOptions::default())
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(flat.warnings, Vec::<String>::new());
    // A quote of the example that lacks its end does not pass.
    assert!(Scene::parse(&examples[0][..examples[0].len() / 2], &root().join("README.md")).is_err());
}

/// The cover scene is what its head comment says.
#[test]
fn the_cover_scene_has_485_spheres_that_keep_clear_of_the_large_ones() {
    use gpu_rt::scene::Object;
    let scene = Scene::load(&root().join("scenes/weekend.ron")).unwrap_or_else(|error| panic!("{error}"));
    let spheres: Vec<_> = scene
        .objects
        .iter()
        .map(|object| match object {
            Object::Sphere { center, radius, .. } => (*center, *radius),
            other => panic!("{} is no sphere", other.name()),
        })
        .collect();
    assert_eq!(spheres.len(), 485);
    let large: Vec<_> = spheres.iter().filter(|(_, radius)| *radius == 1.0).collect();
    let small: Vec<_> = spheres.iter().filter(|(_, radius)| *radius == 0.2).collect();
    assert_eq!((large.len(), small.len()), (3, 481));
    for (center, radius) in &small {
        assert!(
            large.iter().all(|(other, r)| center.distance(*other) >= radius + r),
            "{center} is inside a large sphere"
        );
    }
}
