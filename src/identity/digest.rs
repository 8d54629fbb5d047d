//! Hashes of what a scene says, of the files that it names, and of the shaders.

use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::OnceLock;

use serde::Serialize;
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::bitmap::{Bitmap, Decoding};
use crate::gpu::link::{Embedded, Library};
use crate::scene::{Background, Camera, Mesh, Object, Scene};
use crate::texture::Texture;
use crate::volume::grid::Grid;

/// A hash of all shaders.
pub fn of_shaders() -> String {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(hash_of_shaders).clone()
}

fn hash_of_shaders() -> String {
    let mut hasher = Sha256::new();
    for name in Embedded::names() {
        let text = Embedded.module(&name).unwrap_or_default();
        // Neither a name nor a text has a zero.
        [name.as_bytes(), &[0], text.as_bytes(), &[0]].into_iter().for_each(|bytes| hasher.update(bytes));
    }
    hexadecimal(hasher)
}

/// A hash of what the scene file says, but for the image's size, the defaults of the render, the paths of files, and comments.
pub fn of_scene(scene: &Scene) -> String {
    #[derive(Serialize)]
    struct Says<'a>(&'a Camera, Value, Vec<Value>, &'a [Object]);
    let materials = scene.materials.iter().map(without_paths).collect();
    let says = Says(&scene.camera, without_paths(&scene.background), materials, &scene.objects);
    let mut hasher = Sha256::new();
    // Neither serialising these types nor a hasher can fail.
    let _ = serde_json::to_writer(io::BufWriter::with_capacity(1 << 16, &mut hasher), &says);
    hexadecimal(hasher)
}

/// A value as JSON, without the paths of files in it.
fn without_paths(value: &impl Serialize) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                fields.retain(|name, _| name != "path");
                fields.values_mut().for_each(strip);
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value = serde_json::to_value(value).unwrap_or_default();
    strip(&mut value);
    value
}

/// The images and meshes that the scene names, once for each value that names them, in the file's order: the path, and a hash of what was
/// read.
pub fn of_assets(scene: &Scene) -> Vec<(String, String)> {
    let background = match &scene.background {
        Background::Image { path, .. } => Some((path, Decoding::Colour)),
        _ => None,
    };
    let textures = scene.materials.iter().flat_map(|(_, material)| material.textures()).filter_map(Texture::decoded);
    let mut names: Vec<_> =
        background.into_iter().chain(textures).map(|(path, decoding)| (path.clone(), Some(decoding))).collect();
    scene.visit_objects(&mut |_, object| {
        if let Object::Mesh { path, .. } = object {
            names.push((path.clone(), None));
        }
    });
    let of_grids = scene.grids.iter().map(|((path, name), grid)| (format!("{path}[{name}]"), of_grid(grid)));
    let mut known: HashMap<(String, Option<Decoding>), String> = HashMap::new();
    let hash = |name: (String, Option<Decoding>)| {
        let (path, decoding) = &name;
        let hash = known.entry(name.clone()).or_insert_with(|| {
            let hash = match decoding {
                Some(decoding) => scene.bitmaps.get(path, *decoding).map(of_bitmap),
                None => scene.meshes.get(path).map(|mesh| of_mesh(mesh)),
            };
            hash.unwrap_or_default()
        });
        (path.clone(), hash.clone())
    };
    names.into_iter().map(hash).chain(of_grids).collect()
}

fn of_grid(grid: &Grid) -> String {
    let mut hasher = Sha256::new();
    let Grid { background, to_own, active, tiles, leaves, .. } = grid;
    let _ = write!(hasher, "grid {background:?} {to_own:?} {active:?} ");
    for tile in tiles {
        let _ = write!(hasher, "{} {} {:?} ", tile.lower, tile.size, tile.value);
    }
    for leaf in leaves {
        let _ = write!(hasher, "{} ", leaf.lower);
        hasher.update(bytemuck::cast_slice(leaf.values.as_slice()));
    }
    hexadecimal(hasher)
}

fn of_bitmap(bitmap: &Bitmap) -> String {
    let mut hasher = Sha256::new();
    let _ = write!(hasher, "image {} {} {:?} ", bitmap.width, bitmap.height, bitmap.format);
    hasher.update(bytemuck::cast_slice(&bitmap.words));
    hexadecimal(hasher)
}

fn of_mesh(mesh: &Mesh) -> String {
    let mut hasher = Sha256::new();
    let Mesh { positions, triangles, normals, uvs, further_uvs, tangents, colours, alphas, .. } = mesh;
    let _ = write!(hasher, "mesh {} {} {} {} ", positions.len(), triangles.len(), normals.len(), uvs.len());
    hasher.update(bytemuck::cast_slice(positions));
    hasher.update(bytemuck::cast_slice(triangles));
    hasher.update(bytemuck::cast_slice(normals));
    hasher.update(bytemuck::cast_slice(uvs));
    hasher.update(bytemuck::cast_slice(colours));
    if !further_uvs.is_empty() || !tangents.is_empty() {
        let _ = write!(hasher, "{} {} ", further_uvs.len(), tangents.len());
        further_uvs.iter().for_each(|uvs| hasher.update(bytemuck::cast_slice(uvs)));
        hasher.update(bytemuck::cast_slice(tangents));
    }
    if !alphas.is_empty() {
        let _ = write!(hasher, "alphas ");
        hasher.update(bytemuck::cast_slice(alphas));
    }
    hexadecimal(hasher)
}

/// A hash of hashes.
pub fn of_texts<'a>(texts: impl Iterator<Item = &'a String>) -> String {
    let mut hasher = Sha256::new();
    // No hash has a line end.
    texts.for_each(|text| [text.as_bytes(), b"\n"].into_iter().for_each(|bytes| hasher.update(bytes)));
    hexadecimal(hasher)
}

/// The first 128 bits of the hash.
fn hexadecimal(hasher: Sha256) -> String {
    hasher.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}
