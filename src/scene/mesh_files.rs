//! Triangle meshes from files.
//!
//! One module per format: `obj` with its materials in `mtl`, `stl`, and `ply` with the crate `serde-ply`; `scene/gltf` reads those of glTF
//! files. The parsers of crates run under `guard`, because some panic on damaged files. All fill a `Draft`, which limits the memory. Its
//! `finish` checks it, drops faces without area and unused vertices, and makes a `Mesh` of it. `contents` makes a scene of a file.

mod contents;
mod input;
mod mtl;
mod obj;
mod parts;
mod ply;
mod stl;

use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::assets::Assets;
use super::draft::{self, Draft, MOST_BYTES};
use super::file::{self, OnProgress, Reading};
use super::findings::Findings;
use super::gltf::{self, GltfError};
use super::gltf_path::{Part, has_ending, is_gltf, split};
use super::model::Scene;
use super::types::Object;
use crate::guard::guarded;
use input::Input;

use crate::shape::mesh::Mesh;
pub(super) use contents::contents;
pub(super) use parts::ObjFiles;

/// Reads every mesh of the scene once. The keys are the paths as the scene file writes them. Errors point at the `path` field.
pub fn load_all(
    scene: &Scene,
    reading: Reading,
    findings: &mut Findings,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> BTreeMap<String, Arc<Mesh>> {
    // Those that no file has are there.
    let mut meshes = scene.meshes.clone();
    let mut found: HashSet<String> = meshes.keys().cloned().collect();
    let mut room = MOST_BYTES;
    scene.visit_objects(&mut |at, object| {
        let Object::Mesh { path, .. } = object else { return };
        if findings.is_full() || !found.insert(path.clone()) {
            return;
        }
        let file = scene.source.resolve(path);
        let files = assets.stamp_files(&file);
        let loaded = match reading {
            Reading::Complete => match assets.mesh(&file, &files).filter(|(_, taken)| *taken <= room) {
                Some((mesh, taken)) => Ok(Some((mesh, room - taken))),
                None => load(&file, room, progress, assets).map(|loaded| {
                    let (mesh, left) = loaded?;
                    assets.keep_mesh(&file, files, (Arc::clone(&mesh), room - left));
                    Some((mesh, left))
                }),
            },
            Reading::IfThere => find(&file).map(|()| None).map_err(GltfError::from),
        };
        let loaded =
            loaded.map_err(|GltfError { at: part, reason }| at.field("path").error_in(&split(&file).0, &part, &reason));
        if let Some((mesh, left)) = findings.record(loaded).flatten() {
            room = left;
            meshes.insert(path.clone(), mesh);
        }
    });
    meshes
}

type Parser = fn(&Path, &mut Input, &mut Draft) -> std::result::Result<(), String>;

/// What reads a file, by its ending, and what it is.
fn parser(path: &Path) -> std::result::Result<(Parser, &'static str), String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match ending.as_str() {
        "obj" => Ok((obj::parse, "an OBJ file")),
        "ply" => Ok((ply::parse, "a PLY file")),
        "stl" => Ok((stl::parse, "an STL file")),
        _ => Err("expected the path of a mesh that ends in .obj, .ply, .stl, .gltf or .glb".to_owned()),
    }
}

/// Whether the ending of a path says a mesh of no glTF file.
pub fn is_mesh(path: &Path) -> bool {
    has_ending(path, &["obj", "ply", "stl"])
}

/// Checks that a file is there, and that its ending is that of a mesh.
fn find(path: &Path) -> std::result::Result<(), String> {
    let path = split(path).0;
    if !is_gltf(&path) {
        parser(&path)?;
    }
    file::find(&path, "mesh", file::LONGEST).map(|_| ())
}

/// A mesh, and the bytes that are left.
type Loaded = (Arc<Mesh>, usize);

/// The mesh of a file, or of a part of a glTF file. It may take `room` bytes. A part without area, as a node of scale 0 has it, is none.
fn load(path: &Path, room: usize, progress: &mut OnProgress, assets: &mut Assets) -> gltf::Result<Option<Loaded>> {
    let (name, part) = split(path);
    if let Some(Part::OfMaterial(number)) = part {
        let parts = assets.obj.open(&name, progress)?;
        let missing = || format!("there is no part {number} of a material: the file has {}", parts.meshes.len());
        let (mesh, taken) = parts.meshes.get(number).ok_or_else(missing)?;
        let left = room.checked_sub(*taken).ok_or_else(draft::too_large)?;
        return Ok(mesh.clone().map(|mesh| (mesh, left)));
    }
    if !is_gltf(&name) {
        return Ok(Some(load_file(path, room, progress)?));
    }
    let file = assets.gltf.open(&name, progress)?;
    let mut draft = Draft::new(room);
    guarded(|| match part {
        Some(part) => file.add_part(part, &mut draft),
        None => file.add_scene(&mut draft),
    })??;
    if part.is_some() && !draft.has_area() {
        return Ok(None);
    }
    let left = draft.room;
    Ok(Some((Arc::new(draft.finish()?), left)))
}

/// The mesh of a file that is no glTF file.
pub fn load_file(path: &Path, room: usize, progress: &mut OnProgress) -> std::result::Result<Loaded, String> {
    let (parse, format) = parser(path)?;
    let bytes = file::read(path, "mesh", file::LONGEST)?;
    if bytes.is_empty() {
        return Err(format!("the file is empty: expected {format}"));
    }
    let total = bytes.len();
    let mut tell = |done: usize| progress(path, done as u64, total as u64);
    tell(0);
    let mut draft = Draft::new(room);
    parse(path, &mut Input::new(&bytes, &mut tell), &mut draft)?;
    let left = draft.room;
    Ok((Arc::new(draft.finish()?), left))
}
