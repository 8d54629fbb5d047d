//! The files that a scene was read from.

use std::path::{Path, PathBuf};

use super::Scene;
use super::mesh::unescape;

/// The scene file, the images and meshes that it names, and the files that those name.
pub fn inputs(scene: &Scene) -> Vec<PathBuf> {
    let mut inputs = vec![scene.source.path().to_owned()];
    for path in scene.bitmaps.keys().chain(scene.meshes.keys()) {
        let file = scene.source.resolve(path);
        inputs.extend(buffers(&file));
        inputs.push(file);
    }
    inputs
}

/// The files with the buffers of a .gltf, which is JSON. Other meshes are one file.
fn buffers(path: &Path) -> Vec<PathBuf> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gltf")) {
        return Vec::new();
    }
    let json = std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
    let buffers = json.as_ref().and_then(|json| json.get("buffers")?.as_array()).into_iter().flatten();
    let uris = buffers.filter_map(|buffer| buffer.get("uri")?.as_str()).filter(|uri| !uri.contains(':'));
    uris.map(|uri| path.parent().unwrap_or(Path::new("")).join(unescape(uri))).collect()
}
