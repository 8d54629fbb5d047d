//! The files that a scene was read from.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use super::file;
use super::gltf::MESHOPT;
use super::gltf_path::{split, unescape};
use super::model::Scene;
use super::types::Object;

/// A file that a scene was read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    pub path: PathBuf,
    /// Whether the scene names it by an absolute path, so that it stays where it is when the scene is moved.
    pub fixed: bool,
}

impl Scene {
    /// The paths of all files that the scene was read from, the scene file first.
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.input_files().into_iter().map(|input| input.path).collect()
    }

    /// The scene file, the images and meshes that it names, and the files that those name.
    pub fn input_files(&self) -> Vec<Input> {
        let scene_file = Input { path: self.source.path.clone(), fixed: false };
        let mut inputs = vec![scene_file.clone()];
        inputs.extend(buffers(&scene_file));
        inputs.extend(self.libraries.iter().map(|path| Input { path: path.clone(), fixed: false }));
        // Of the parts of a glTF file, each names it. An empty one has no part.
        let mut names = Vec::new();
        self.visit_objects(&mut |_, object| {
            if let Object::Gltf { path, .. } = object {
                names.push(path);
            }
        });
        names.extend(self.grids.keys().map(|(path, _)| path));
        names.extend(self.bitmaps.paths().chain(self.meshes.keys()).filter(|path| !self.made.contains(*path)));
        let mut known = HashSet::from([scene_file.path]);
        for name in names {
            let path = split(&self.source.resolve(name)).0.into_owned();
            if !known.insert(path.clone()) {
                continue;
            }
            let file = Input { path, fixed: Path::new(name).is_absolute() };
            inputs.extend(buffers(&file));
            inputs.push(file);
        }
        inputs
    }
}

/// The files with the buffers of a .gltf, which is JSON. Other meshes are one file.
pub(super) fn buffers(file: &Input) -> Vec<Input> {
    let path = &file.path;
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gltf")) {
        return Vec::new();
    }
    /// The rest takes no memory.
    #[derive(Deserialize)]
    struct Root {
        #[serde(default)]
        buffers: Vec<Buffer>,
    }
    #[derive(Deserialize)]
    struct Buffer {
        uri: Option<String>,
        #[serde(default)]
        extensions: Value,
    }
    let json = file::read(path, "glTF file", file::LONGEST).ok();
    let root = json.and_then(|bytes| serde_json::from_slice::<Root>(&bytes).ok());
    let is_read = |of: &Buffer| !MESHOPT.iter().any(|name| of.extensions[*name]["fallback"] == true);
    let uris = root.into_iter().flat_map(|root| root.buffers).filter(is_read).filter_map(|buffer| buffer.uri);
    let uris = uris.filter(|uri| !uri.contains(':'));
    let buffer = |uri: String| Input {
        path: path.parent().unwrap_or(Path::new("")).join(&uri),
        fixed: file.fixed || Path::new(&uri).is_absolute(),
    };
    uris.map(|uri| buffer(unescape(&uri))).collect()
}
