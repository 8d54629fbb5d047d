//! The files that a scene was read from.

use std::path::{Path, PathBuf};

use super::Scene;
use super::mesh::unescape;

/// A file that a scene was read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    pub path: PathBuf,
    /// Whether the scene names it by an absolute path, so that it stays where it is when the scene is moved.
    pub fixed: bool,
}

/// The scene file, the images and meshes that it names, and the files that those name.
pub fn inputs(scene: &Scene) -> Vec<Input> {
    let mut inputs = vec![Input { path: scene.source.path().to_owned(), fixed: false }];
    for name in scene.bitmaps.keys().chain(scene.meshes.keys()) {
        let file = Input { path: scene.source.resolve(name), fixed: Path::new(name).is_absolute() };
        inputs.extend(buffers(&file));
        inputs.push(file);
    }
    inputs
}

/// The files with the buffers of a .gltf, which is JSON. Other meshes are one file.
pub(super) fn buffers(file: &Input) -> Vec<Input> {
    let path = &file.path;
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gltf")) {
        return Vec::new();
    }
    let json = std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    let buffers = json.as_ref().and_then(|json| json.get("buffers")?.as_array()).into_iter().flatten();
    let uris = buffers.filter_map(|buffer| buffer.get("uri")?.as_str()).filter(|uri| !uri.contains(':'));
    let buffer = |uri: String| Input {
        path: path.parent().unwrap_or(Path::new("")).join(&uri),
        fixed: file.fixed || Path::new(&uri).is_absolute(),
    };
    uris.map(|uri| buffer(unescape(uri))).collect()
}
