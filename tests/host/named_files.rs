//! Every module, scene and source that a test names is there: a test that forbids a module which does not exist cannot fail.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use gpu_rt::gpu::link::Embedded;

use crate::common::files::files;

/// Folders of the checkout. A path of one of them that ends as these do is the name of a file.
const FOLDERS: [&str; 8] = ["benches", "blender", "docs", "python", "scenes", "shaders", "src", "tests"];
const ENDINGS: [&str; 8] = ["exr", "glb", "gltf", "md", "py", "ron", "rs", "wgsl"];

/// Names that are not of the checkout: of files that a test makes itself, of examples, and of files that are to be missing.
const NOT_OF_THE_CHECKOUT: [&str; 37] = [
    "aov/distance_of_hit",
    "data/thing",
    "docs/gpu-NAME.md",
    "docs/walks-NAME.md",
    "lib/nothing",
    "lobe/dust",
    "material/retroreflector",
    "material/velvet",
    "material/velvet_eval",
    "scene/images",
    "scenes/bad.ron",
    "scenes/corner.ron",
    "scenes/dark.ron",
    "scenes/gone.glb",
    "scenes/lamp.ron",
    "scenes/lamps.glb",
    "scenes/large.ron",
    "scenes/moving.glb",
    "scenes/none.ron",
    "scenes/other.ron",
    "scenes/room.glb",
    "scenes/room.gltf",
    "scenes/sphere.glb",
    "scenes/sphere.gltf",
    "scenes/sphere.ron",
    "scenes/test.ron",
    "scenes/white.ron",
    "test/inner",
    "test/known",
    "test/rain",
    "test/root",
    "test/snow",
    "tests/blender/blurred.ron",
    "tests/cli.rs",
    "tests/no.rs",
    "tests/shaders/x.wgsl",
    "tests/walk/main.rs",
];

/// The modules and the paths of files that a source names, with their lines. A module is a whole string, such as `"scene/uv"`; a path may be a part of one,
/// or of a comment. A path of a shader is its module.
fn named(text: &str) -> Vec<(usize, String)> {
    let folders: BTreeSet<String> =
        Embedded::names().iter().filter_map(|name| Some(name.split_once('/')?.0.to_string())).collect();
    let is_of_a_name = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let mut end = 0;
        for word in line.split(|c| !is_of_a_name(c)) {
            let (start, is_first) = (end, end == 0);
            end = start + word.len() + line[start + word.len()..].chars().next().map_or(0, char::len_utf8);
            let is_string = !is_first && line[..start].ends_with('"') && line[start + word.len()..].starts_with('"');
            let word = word.trim_start_matches("../");
            let Some((folder, rest)) = word.split_once('/').filter(|_| !word.ends_with('/')) else { continue };
            let is_module = is_string && (folder == "test" || folders.contains(folder)) && !rest.contains('.');
            let ending = rest.rsplit_once('.').map_or("", |(_, ending)| ending);
            if is_module || FOLDERS.contains(&folder) && ENDINGS.contains(&ending) {
                let module = word.strip_prefix("shaders/").and_then(|path| path.strip_suffix(".wgsl"));
                found.push((number, module.unwrap_or(word).to_string()));
            }
        }
    }
    found
}

/// Whether there is a file or a module of this name. Modules of tests are under tests/shaders.
fn exists(name: &str) -> bool {
    let module = name.strip_prefix("test/").map_or(format!("shaders/{name}"), |own| format!("tests/shaders/{own}"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join(name).is_file() || root.join(module + ".wgsl").is_file()
}

/// The names of a source that do not exist, as `line: name`.
fn missing(text: &str) -> Vec<String> {
    let is_missing = |(_, name): &(usize, String)| !exists(name) && !NOT_OF_THE_CHECKOUT.contains(&name.as_str());
    named(text).into_iter().filter(is_missing).map(|(line, name)| format!("{line}: {name}")).collect()
}

#[test]
fn every_module_scene_and_source_that_a_test_names_exists() {
    let (mut names, mut wrong) = (BTreeSet::new(), Vec::new());
    // This one names what it does not find.
    let others = |path: &PathBuf| !path.ends_with(file!());
    for path in ["tests", "benches"].into_iter().flat_map(|folder| files(folder, ".rs", true)).filter(others) {
        let text = fs::read_to_string(&path).expect("a source is read");
        names.extend(named(&text).into_iter().map(|(_, name)| name));
        wrong.extend(missing(&text).into_iter().map(|name| format!("{}:{name}", path.display())));
    }
    assert!(wrong.is_empty(), "no such module or file:\n{}", wrong.join("\n"));
    assert!(names.len() > 250, "only {} names were found", names.len());
    for name in NOT_OF_THE_CHECKOUT {
        assert!(names.contains(name) && !exists(name), "{name} needs no exception");
    }
}

#[test]
fn a_name_of_nothing_is_found() {
    let text = "let modules = [\"scene/uv\", \"scene/light_alias\", \"test/none\"];\n\
                // scenes/void.ron, scenes/weekend.ron, scenes/{name}.ron and docs/none.md\n\
                mod common \"../../src/none.rs\"; \"shaders/scene/uvw.wgsl:3:\"; \"scene/a b\"; scene/x; \"scene/\"\n";
    let expected = [
        "1: scene/light_alias",
        "1: test/none",
        "2: scenes/void.ron",
        "2: docs/none.md",
        "3: src/none.rs",
        "3: scene/uvw",
    ];
    assert_eq!(missing(text), expected);
    assert_eq!(missing("\"material/velvet\""), Vec::<String>::new());
}
