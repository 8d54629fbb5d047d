//! Triangle meshes from files.
//!
//! One module per format: `obj` with the crate `tobj`, `ply` with `serde-ply`, `gltf` with `gltf`. The parsers run under `guard`,
//! because some panic on damaged files. They fill a `Draft`, which limits the memory. Its `finish` checks it, drops faces without
//! area and unused vertices, and makes a `Mesh` of it.

mod draft;
mod gltf;
mod input;
mod obj;
mod ply;

use std::collections::BTreeMap;
use std::path::Path;

use super::Scene;
use super::file;
use super::types::Object;
use super::visit::visit_all;
use crate::error::Result;
use draft::{Draft, MOST_BYTES};
use input::Input;

pub use crate::shape::mesh::{Mesh, OpenEdges};
pub(super) use gltf::unescape;

/// A callback for the progress of reading a file, with its path, the bytes read so far, and all its bytes.
pub type OnProgress<'a> = dyn FnMut(&Path, u64, u64) + 'a;

/// Reads every mesh of the scene once. The keys are the paths as the scene file writes them. Errors point at the `path` field.
pub fn load_all(scene: &Scene, progress: &mut OnProgress) -> Result<BTreeMap<String, Mesh>> {
    let mut meshes = BTreeMap::new();
    let mut room = MOST_BYTES;
    visit_all(&scene.top().field("objects"), &scene.objects, &mut |at, object| {
        let Object::Mesh { path, .. } = object else { return Ok(()) };
        if !meshes.contains_key(path) {
            let file = scene.source.resolve(path);
            let wrong = |reason: String| at.field("path").error(format!("{}: {reason}", file.display()));
            let (mesh, left) = load(&file, room, progress).map_err(wrong)?;
            room = left;
            meshes.insert(path.clone(), mesh);
        }
        Ok(())
    })?;
    Ok(meshes)
}

type Parser = fn(&Path, &mut Input, &mut Draft) -> std::result::Result<(), String>;

/// The mesh of a file, which may take `room` bytes, and the bytes that are left.
fn load(path: &Path, room: usize, progress: &mut OnProgress) -> std::result::Result<(Mesh, usize), String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let (parse, format): (Parser, _) = match ending.as_str() {
        "obj" => (obj::parse, "an OBJ file"),
        "ply" => (ply::parse, "a PLY file"),
        "gltf" | "glb" => (gltf::parse, "a glTF file"),
        _ => return Err("expected the path of a mesh that ends in .obj, .ply, .gltf or .glb".to_owned()),
    };
    let bytes = file::read(path, "mesh", file::LONGEST)?;
    if bytes.is_empty() {
        return Err(format!("the file is empty: expected {format}"));
    }
    let whole = bytes.len();
    let mut tell = |done: usize| progress(path, done as u64, whole as u64);
    tell(0);
    let mut draft = Draft::new(room);
    parse(path, &mut Input::new(&bytes, &mut tell), &mut draft)?;
    let left = draft.room();
    Ok((draft.finish()?, left))
}
