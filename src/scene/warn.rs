//! Warnings about values that are allowed but likely to disappoint.

use std::collections::HashSet;

use super::Scene;
use super::types::*;
use super::visit::visit_all;

/// The warnings about a scene, in the file's order.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let top = scene.top();
    let used: HashSet<&str> = materials_of(&scene.objects).collect();
    let mut warnings = Vec::new();
    for (name, material) in &scene.materials {
        let materials = top.field("materials");
        let at = materials.key(name);
        if !used.contains(name.as_str()) {
            warnings.push(at.warning("no object uses this material: use it or remove it"));
        }
        warnings.extend(material.warnings(&at, &scene.bitmaps));
    }
    if scene.objects.is_empty() {
        let message = "there are 0 objects, so that the image shows only the background: add objects";
        warnings.push(top.field("objects").warning(message));
    }
    let mut told = HashSet::new();
    let walked = visit_all(&top.field("objects"), &scene.objects, &mut |at, object| {
        match object {
            Object::Medium { density: 0.0, .. } => {
                let message = "a density of 0 means that the medium has no effect: remove it or raise its density";
                warnings.push(at.field("density").warning(message));
            }
            Object::Mesh { path, .. } if told.insert(path.clone()) => {
                let about = scene.meshes.get(path).map_or(&[][..], |mesh| &mesh.warnings);
                warnings.extend(about.iter().map(|text| at.field("path").warning(&format!("{path}: {text}"))));
            }
            _ => {}
        }
        Ok(())
    });
    debug_assert!(walked.is_ok(), "nothing in it fails");
    warnings
}

/// The names of the materials that objects use, also inside groups.
fn materials_of(objects: &[Object]) -> impl Iterator<Item = &str> {
    let mut rest: Vec<&Object> = objects.iter().rev().collect();
    std::iter::from_fn(move || {
        while let Some(object) = rest.pop() {
            match object {
                Object::Transformed { object, .. } => rest.push(object),
                Object::Group(objects) => rest.extend(objects.iter().rev()),
                Object::Medium { boundary, .. } => rest.push(boundary),
                _ => {}
            }
            if let Some(name) = object.material() {
                return Some(name);
            }
        }
        None
    })
}
