//! The names of objects and of mattes, and the ids by which kernels count them.

use std::collections::BTreeSet;

use super::device_scene::DeviceScene;
use super::finder::{Name, Primitive};
use crate::aov::{Aov, Aovs, MatteKind, id_of};
use crate::scene::Scene;

/// The name of an object: its own, or its place in the scene file.
fn name_of(name: &Name<'_>) -> String {
    name.own.map_or_else(|| format!("objects[{}]", name.place), str::to_owned)
}

/// Adds the names of objects; the ids of mattes of all objects, and the names of each kind of matte, also of what no camera sees.
pub fn add(flat: &mut DeviceScene, scene: &Scene, aovs: &Aovs, primitives: &[Primitive<'_>]) {
    if aovs.has(Aov::Object) {
        flat.object_names = primitives.iter().map(|primitive| name_of(&primitive.name)).collect();
    }
    let name = |kind: MatteKind, primitive: &Primitive<'_>| match kind {
        MatteKind::Object => name_of(&primitive.name),
        MatteKind::Material => {
            scene.materials.get(primitive.material as usize).map(|(name, _)| name.clone()).unwrap_or_default()
        }
        MatteKind::Asset => {
            let asset = scene.assets.get(primitive.name.place).map(String::as_str).or(primitive.name.outermost);
            asset.map_or_else(|| name_of(&primitive.name), str::to_owned)
        }
    };
    let names: Vec<Vec<String>> =
        aovs.mattes().iter().map(|kind| primitives.iter().map(|primitive| name(*kind, primitive)).collect()).collect();
    let ids = (0..primitives.len()).flat_map(|object| names.iter().map(move |names| id_of(&names[object])));
    flat.matte_ids = ids.collect();
    let more = |kind| scene.materials.iter().map(|(name, _)| name.clone()).filter(move |_| kind == MatteKind::Material);
    let unique = |(kind, names): (&MatteKind, Vec<String>)| {
        names.into_iter().chain(more(*kind)).collect::<BTreeSet<_>>().into_iter().collect()
    };
    flat.matte_names = aovs.mattes().iter().zip(names).map(unique).collect();
}
