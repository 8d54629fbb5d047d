//! Triangle meshes from files.
//!
//! One module per format: `obj` with the crate `tobj`, `ply` with `serde-ply`, `gltf` with `gltf`. The parsers run under `guard`,
//! because some panic on damaged files. They fill a `Draft`. Its `finish` checks it, drops faces without area and unused vertices,
//! and makes a `Mesh` of it.

mod draft;
mod gltf;
mod guard;
mod input;
mod obj;
mod ply;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use super::Scene;
use super::types::Object;
use super::visit::visit_all;
use crate::error::Result;
use draft::Draft;
use input::Input;

pub use crate::shape::mesh::{Mesh, OpenEdges};

/// A callback for the progress of reading a file, with its path, the bytes read so far, and all its bytes.
pub type OnProgress<'a> = dyn FnMut(&Path, u64, u64) + 'a;

/// Reads every mesh of the scene once. The keys are the paths as the scene file writes them. Errors point at the `path` field.
pub fn load_all(scene: &Scene, progress: &mut OnProgress) -> Result<BTreeMap<String, Mesh>> {
    let mut meshes = BTreeMap::new();
    visit_all(&scene.top().field("objects"), &scene.objects, &mut |at, object| {
        let Object::Mesh { path, .. } = object else { return Ok(()) };
        if !meshes.contains_key(path) {
            let file = scene.source.resolve(path);
            let wrong = |reason: String| at.field("path").error(format!("{}: {reason}", file.display()));
            meshes.insert(path.clone(), load(&file, progress).map_err(wrong)?);
        }
        Ok(())
    })?;
    Ok(meshes)
}

type Parser = fn(&Path, &mut Input) -> std::result::Result<Draft, String>;

fn load(path: &Path, progress: &mut OnProgress) -> std::result::Result<Mesh, String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let (parse, format): (Parser, _) = match ending.as_str() {
        "obj" => (obj::parse, "an OBJ file"),
        "ply" => (ply::parse, "a PLY file"),
        "gltf" | "glb" => (gltf::parse, "a glTF file"),
        _ => return Err("expected the path of a mesh that ends in .obj, .ply, .gltf or .glb".to_owned()),
    };
    let bytes = read(path)?;
    if bytes.is_empty() {
        return Err(format!("the file is empty: expected {format}"));
    }
    let whole = bytes.len();
    let mut tell = |done: usize| progress(path, done as u64, whole as u64);
    tell(0);
    parse(path, &mut Input::new(&bytes, &mut tell))?.finish()
}

/// The bytes of a file.
fn read(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let cannot = |reason: std::io::Error| format!("cannot read the mesh: {reason}");
    let meta = std::fs::metadata(path).map_err(cannot)?;
    if !meta.is_file() {
        return Err("cannot read the mesh: it is not a file".to_owned());
    }
    let mut bytes = Vec::new();
    let size = usize::try_from(meta.len()).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(size).map_err(|_| format!("there is no memory for its {size} bytes"))?;
    std::fs::File::open(path).and_then(|mut file| file.read_to_end(&mut bytes)).map_err(cannot)?;
    Ok(bytes)
}
