//! Mitsuba's XML: what a file has becomes the camera, the materials and the objects of the scene file.
//!
//! `document` reads the elements of all files, `values` their properties; each other module makes one kind of element. What cannot be as Mitsuba
//! has it is an error at its place, or a loss, which is told.

mod bsdf;
mod document;
mod emitter;
mod properties;
mod reader;
mod sensor;
mod serialized;
mod shape;
mod transform;
mod values;

use std::collections::HashMap;
use std::path::Path;

use glam::DAffine3;

use super::assets::Assets;
use super::file::OnProgress;
use super::gltf_options::GltfOptions;
use super::gltf_path::has_ending;
use super::imported::{Imported, Place, bodies};
use super::types::*;
use crate::error::{Error, Result};
use document::{Loader, Node};
use reader::Reader;

/// Whether the ending of a path says Mitsuba.
pub fn is_mitsuba(path: &Path) -> bool {
    has_ending(path, &["xml"])
}

/// Reads a scene, as the scene file `to` would have it.
pub fn contents<'a>(
    path: &Path,
    to: &Path,
    options: &GltfOptions,
    progress: &mut OnProgress,
    assets: &'a mut Assets,
) -> Result<Imported<'a>> {
    let mut made = Imported::new(path, to, options, assets);
    let mut loader = Loader::new(path, &options.defines, &mut made);
    let root = loader.load(path, 0, false)?;
    if let Some(name) = loader.unused(&options.defines) {
        return Err(Error::Usage(format!("-D {name}: {} has no ${name}", path.display())));
    }
    let folders = loader.folders;
    let of_media =
        |node: &Node| node.tag == "integrator" && node.attribute("type").is_some_and(|kind| kind.starts_with("vol"));
    let has_media = root.children.iter().any(|node| of_media(node) || node.children.iter().any(of_media));
    let mut reader = Reader {
        ids: HashMap::new(),
        folders,
        made,
        has_media,
        known: HashMap::new(),
        parts: HashMap::new(),
        to_uv: None,
        grouped: HashMap::new(),
        depth: 0,
    };
    let mut all = vec![&root];
    while let Some(node) = all.pop() {
        if node.tag == "alias" {
            let found = node.required("id").and_then(|id| {
                let known = reader.ids.get(id).copied();
                let known = known.ok_or_else(|| node.error_at("id", "there is no element of this id above"))?;
                Ok((node.required("as")?, known))
            });
            if let Some((name, known)) = reader.made.findings.record(found) {
                reader.ids.insert(name, known);
            }
        } else if let Some(id) = node.attribute("id").filter(|_| node.tag != "ref")
            && reader.ids.insert(id, node).is_some()
        {
            reader.made.findings.refuse(node.error_at("id", "another element has this id"));
        }
        all.extend(node.children.iter().rev());
    }
    parts(&root, path, progress, &mut reader);
    bodies::tell("Mitsuba", &mut reader.made);
    Ok(reader.made)
}

fn parts<'a>(root: &'a Node, path: &Path, progress: &mut OnProgress, reader: &mut Reader<'a, '_>) {
    let (mut view, mut max_depth) = (None, 1_000_000);
    reader.made.parts.objects = Some(Vec::new());
    for node in &root.children {
        if reader.made.findings.is_full() {
            break;
        }
        let done: Result<()> = (|| {
            match node.tag.as_str() {
                "integrator" => max_depth = sensor::integrator(node, reader)?,
                "sensor" if view.is_some() => reader.lose(node, "only the first sensor is used"),
                "sensor" => {
                    reader.made.place(&["camera", "image", "render"], &node.at);
                    view = Some(sensor::sensor(node, reader)?);
                }
                "emitter" if node.attribute("type") == Some("area") => {}
                "emitter" => emitter::emitter(node, reader)?,
                "shape" => {
                    let found = shape::shape(node, &DAffine3::IDENTITY, progress, reader)?;
                    found.into_iter().for_each(|object| reader.made.add_object(object, &node.at));
                }
                // These are read where they are used.
                "bsdf" | "texture" | "medium" | "spectrum" | "rgb" | "phase" | "sampler" | "film" | "rfilter"
                | "alias" | "boolean" | "integer" | "float" | "string" => {}
                _ => return Err(node.error("this element is not read here")),
            }
            Ok(())
        })();
        reader.made.findings.record(done);
    }
    if view.is_none() && reader.made.findings.is_empty() {
        let at = Place { file: path.into(), line: 1, column: 1 };
        reader.made.findings.refuse(at.error("scene", "expected a <sensor> in the scene"));
    }
    let parts = &mut reader.made.parts;
    parts.render = RenderDefaults { samples: 4, max_depth };
    if let Some((camera, image, samples)) = view {
        (parts.camera, parts.image, parts.render.samples) = (Some(camera), Some(image), samples);
    }
}
