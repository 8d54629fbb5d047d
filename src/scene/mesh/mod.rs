//! Triangle meshes as their files say them.
//!
//! A file a format: `obj` by the crate `tobj`, `ply` by `serde-ply`, `gltf` by `gltf`. The parsers are called under `guard`,
//! for some panic on what a file may say. What they read is a `Draft`, whose `finish` checks it, drops what has no area or is
//! not used, and makes a `Mesh` of it.

mod closed;
mod draft;
mod gltf;
mod guard;
mod input;
mod obj;
mod ply;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::Scene;
use super::types::Object;
use super::visit::visit_all;
use crate::error::Result;
use draft::Draft;
use input::Input;

pub use closed::OpenEdges;

/// Told how far the reading of a file is: its path, the bytes that are done, and the bytes in all.
pub type OnProgress<'a> = dyn FnMut(&Path, u64, u64) + 'a;

/// A triangle mesh in its own space, in the file's units. Every vertex belongs to a triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Each coordinate is finite, at most 1e100 in magnitude.
    pub positions: Vec<DVec3>,
    /// Indices of vertices, counter-clockwise seen from outside; in the file's order. The three positions differ.
    pub triangles: Vec<[u32; 3]>,
    /// A unit vector for each vertex; empty where the file has none, and then the mesh is flat-shaded.
    pub normals: Vec<Vec3>,
    /// Texture coordinates for each vertex, u to the right and v up, all finite; empty where the file has none.
    pub uvs: Vec<Vec2>,
    /// The face of the file, counted from 0, that each triangle is part of.
    pub faces: Vec<u32>,
    /// What of the file is not used, in words.
    pub warnings: Vec<String>,
}

impl Mesh {
    /// The number in its file of the face that a triangle is part of, counted from 0.
    pub fn face(&self, triangle: usize) -> u32 {
        self.faces.get(triangle).copied().unwrap_or(triangle as u32)
    }

    /// The corners of the smallest box around it. An empty mesh has none, and gives infinities.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.positions.iter().fold(nothing, |(low, high), &p| (low.min(p), high.max(p)))
    }
}

/// Reads every mesh of the scene once, by its path as written. An error stands at the `path` field.
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

/// The bytes of a file, of which no more are asked for than it has.
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
