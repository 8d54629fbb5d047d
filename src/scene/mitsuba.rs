//! Mitsuba's XML: what a file has becomes the camera, the materials and the objects of the scene file.
//!
//! `document` reads the elements of all files, `values` their properties; each other module makes one kind of element. What cannot be as Mitsuba
//! has it is an error at its place, or a loss, which is told.

mod bodies;
mod bsdf;
mod document;
mod emitter;
pub(super) mod mesh;
mod properties;
pub(super) mod reader;
mod sensor;
mod serialized;
pub(super) mod shape;
pub(super) mod spectrum;
pub(super) mod tables;
pub(super) mod transform;
mod values;
mod write_ply;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine3;

use super::assets::Assets;
use super::file::OnProgress;
use super::findings::Findings;
use super::gltf_options::GltfOptions;
use super::gltf_path::has_ending;
use super::recover::Parts;
use super::types::*;
use crate::error::{Error, Location, Result};
use crate::shape::mesh::Mesh;
use document::{Loader, Node};
use emitter::Emitter;
use reader::Reader;
pub use write_ply::write_ply;

/// Whether the ending of a path says Mitsuba.
pub fn is_mitsuba(path: &Path) -> bool {
    has_ending(path, &["xml"])
}

/// What a file has.
pub struct Contents {
    pub parts: Parts,
    /// The meshes that are in no file, by their paths.
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    pub notes: Vec<String>,
    /// The files that were read, without the first.
    pub files: Vec<PathBuf>,
    /// Where values of the scene stand, by their paths such as `objects[3]`.
    pub places: HashMap<String, Location>,
    pub findings: Findings,
}

/// Reads a scene, as the scene file `to` would have it.
pub fn contents(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<Contents> {
    let mut loader = Loader::new(&options.defines, assets);
    loader.folders.push(path.parent().unwrap_or(Path::new("")).to_owned());
    let root = loader.load(path, 0, false)?;
    if let Some(name) = loader.unused(&options.defines) {
        return Err(Error::Usage(format!("-D {name}: {} has no ${name}", path.display())));
    }
    let Loader { folders, files, notes, .. } = loader;
    let of_media =
        |node: &Node| node.tag == "integrator" && node.attribute("type").is_some_and(|kind| kind.starts_with("vol"));
    let has_media = root.children.iter().any(|node| of_media(node) || node.children.iter().any(of_media));
    let mut reader = Reader {
        ids: HashMap::new(),
        folders,
        to: to.to_owned(),
        is_in_place: path == to,
        lossless: options.lossless,
        has_media,
        materials: Vec::new(),
        known: HashMap::new(),
        parts: HashMap::new(),
        same: HashMap::new(),
        to_uv: None,
        grouped: HashMap::new(),
        bodies: Vec::new(),
        outside: None,
        names: HashMap::new(),
        meshes: BTreeMap::new(),
        of_files: HashMap::new(),
        told: HashSet::new(),
        notes,
        files,
        places: HashMap::new(),
        findings: Findings::default(),
        depth: 0,
        assets,
    };
    let mut all = vec![&root];
    while let Some(node) = all.pop() {
        if node.tag == "alias" {
            let found = node.required("id").and_then(|id| {
                let known = reader.ids.get(id).copied();
                let known = known.ok_or_else(|| node.error_at("id", "there is no element of this id above"))?;
                Ok((node.required("as")?, known))
            });
            if let Some((name, known)) = reader.findings.record(found) {
                reader.ids.insert(name, known);
            }
        } else if let Some(id) = node.attribute("id").filter(|_| node.tag != "ref")
            && reader.ids.insert(id, node).is_some()
        {
            reader.findings.refuse(node.error_at("id", "another element has this id"));
        }
        let file = node.attribute("value").filter(|_| node.attribute("name") == Some("filename"));
        reader.notes.extend(file.and_then(|file| document::outside(file, node)));
        all.extend(node.children.iter().rev());
    }
    let parts = parts(&root, path, progress, &mut reader);
    bodies::tell(&mut reader);
    let Reader { meshes, notes, files, places, findings, .. } = reader;
    Ok(Contents { parts, meshes, notes, files, places, findings })
}

fn parts<'a>(root: &'a Node, path: &Path, progress: &mut OnProgress, reader: &mut Reader<'a>) -> Parts {
    let (mut view, mut max_depth, mut background) = (None, 1_000_000, None);
    let mut objects = Vec::new();
    for node in &root.children {
        if reader.findings.is_full() {
            break;
        }
        let done: Result<()> = (|| {
            match node.tag.as_str() {
                "integrator" => max_depth = sensor::integrator(node, reader)?,
                "sensor" if view.is_some() => reader.lose(node, "only the first sensor is used"),
                "sensor" => {
                    for field in ["camera", "image", "render"] {
                        reader.places.insert(field.to_owned(), node.at.location());
                    }
                    view = Some(sensor::sensor(node, reader)?);
                }
                "emitter" if node.attribute("type") == Some("area") => {}
                "emitter" => match emitter::emitter(node, reader)? {
                    Emitter::Object(object) => {
                        reader.places.insert(format!("objects[{}]", objects.len()), node.at.location());
                        objects.push(object);
                    }
                    Emitter::Background(_) if background.is_some() => {
                        return Err(node.error("expected one emitter around the scene, found another"));
                    }
                    Emitter::Background(found) => {
                        reader.places.insert("background".to_owned(), node.at.location());
                        background = Some(found);
                    }
                },
                "shape" => {
                    let found = shape::shape(node, &DAffine3::IDENTITY, progress, reader)?;
                    for object in found {
                        reader.places.insert(format!("objects[{}]", objects.len()), node.at.location());
                        objects.push(object);
                    }
                }
                // These are read where they are used.
                "bsdf" | "texture" | "medium" | "spectrum" | "rgb" | "phase" | "sampler" | "film" | "rfilter"
                | "alias" | "boolean" | "integer" | "float" | "string" => {}
                _ => return Err(node.error("this element is not read here")),
            }
            Ok(())
        })();
        reader.findings.record(done);
    }
    if view.is_none() && reader.findings.is_empty() {
        let location = Location { file: path.to_owned(), line: 1, column: 1 };
        let message = "expected a <sensor> in the scene".to_owned();
        reader.findings.refuse(Error::Scene { location, field: "scene".to_owned(), message });
    }
    let (camera, image, samples) = match view {
        Some((camera, image, samples)) => (Some(camera), Some(image), samples),
        None => (None, None, 4),
    };
    Parts {
        image,
        camera,
        background,
        materials: std::mem::take(&mut reader.materials),
        objects: Some(objects),
        render: RenderDefaults { samples, max_depth },
    }
}
