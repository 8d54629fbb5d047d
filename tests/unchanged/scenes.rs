//! The scenes whose images and kernels are compared with tables.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Files that are compared beside the folders of scenes: what is cut out, solid glass, and a sun. Their lights have no size.
const BLENDER: [&str; 3] = ["leaves", "glass-ball", "sun"];

/// The scenes by name.
pub fn scenes() -> BTreeMap<String, PathBuf> {
    let folders = ["scenes", "tests/references", "tests/unchanged"].map(|folder| Path::new(ROOT).join(folder));
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder of scenes"));
    let paths = files.map(|file| file.expect("a file").path());
    let blender = BLENDER.map(|name| Path::new(ROOT).join(format!("tests/blender/{name}.glb")));
    let scenes: BTreeMap<_, _> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "ron" || ending == "glb"))
        .chain(blender)
        .map(|path| (path.strip_prefix(ROOT).expect("within").with_extension("").display().to_string(), path))
        .collect();
    assert_eq!(scenes.len(), 19 + 5 + 1 + BLENDER.len());
    scenes
}
