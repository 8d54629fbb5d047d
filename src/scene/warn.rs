//! What is allowed and yet likely to disappoint.

use std::collections::HashSet;

use super::Scene;
use super::types::*;
use super::visit::visit_all;
use crate::source::Place;

/// A refractive index within this of 1, and not 1, shows nowhere but at grazing incidence: rays are bent by |n - 1| tan θ.
const NEAR_ONE: f64 = 1e-6;

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
        warnings.extend(about_material(scene, &at.variant(material.name()), material));
    }
    if scene.objects.is_empty() {
        let message = "there are 0 objects, so that the image shows the background alone: add objects";
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

fn about_material(scene: &Scene, at: &Place, material: &Material) -> Option<String> {
    if let Material::Dielectric { ior } = material {
        // The nearest f64 to a decimal near 1, and with it the difference, is off by half a unit at 1.
        let near = *ior != 1.0 && (ior - 1.0).abs() <= NEAR_ONE + f64::EPSILON;
        // Up to about sqrt(2 |n - 1|) from grazing incidence, where total reflection begins.
        let grazing = (2.0 * NEAR_ONE).sqrt().to_degrees();
        let message = format!(
            "an ior of {ior} is within {NEAR_ONE:e} of 1: but for rays within {grazing:.2} degrees of its surface it reflects nothing and bends \
             nothing that an image would show: write 1 or a larger difference"
        );
        return near.then(|| at.field("ior").warning(&message));
    }
    let slot = material.texture()?;
    if slot.usage == Use::Radiance {
        let is_black = match slot.texture {
            Texture::Rgb(r, g, b) => r.max(*g).max(*b) == 0.0,
            Texture::Checker { even, odd, .. } => even.max(*odd).max_element() == 0.0,
            Texture::Image { path } => {
                scene.bitmaps.get(path).is_some_and(|image| image.texels.iter().flatten().all(|c| *c == 0.0))
            }
            Texture::Noise { .. } | Texture::Marble { .. } => false,
        };
        let message =
            "an emission of 0 is no light: raise it, or write Lambertian(albedo: Rgb(0, 0, 0)) for a black surface";
        return is_black.then(|| at.field(slot.field).warning(message));
    }
    let message = "an albedo of 1 absorbs nothing, so that paths in a closed scene end only at max_depth: write \
                   0.99 or less unless that is meant";
    is_white(scene, slot.texture).then(|| at.field(slot.field).warning(message))
}

/// Whether a channel of an albedo is 1: of a colour, or of all texels of an image.
pub fn is_white(scene: &Scene, albedo: &Texture) -> bool {
    match albedo {
        Texture::Rgb(r, g, b) => [*r, *g, *b].contains(&1.0),
        Texture::Checker { even, odd, .. } => even.max(*odd).max_element() == 1.0,
        // A white place here and there is nothing to warn of.
        Texture::Image { path } => scene
            .bitmaps
            .get(path)
            .is_some_and(|image| (0..3).any(|channel| image.texels.iter().all(|texel| texel[channel] >= 1.0))),
        Texture::Noise { .. } | Texture::Marble { .. } => false,
    }
}

/// The names of the materials that objects use, groups and all.
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
