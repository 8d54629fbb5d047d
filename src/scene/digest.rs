//! Hashes of what a scene says and of the files that it names, by which renders of one scene are known.

use std::io::{self, Write};

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::{Background, Mesh, Object, Scene};
use crate::texture::Bitmap;

impl Scene {
    /// A hash of what the scene file says, but for the image's size, the defaults of the render, the paths of files, and comments.
    pub fn digest(&self) -> String {
        #[derive(Serialize)]
        struct Says<'a>(&'a super::Camera, &'a Background, &'a [(String, super::Material)], &'a [Object]);
        let says = Says(&self.camera, &self.background, &self.materials, &self.objects);
        let mut hasher = Sha256::new();
        // Neither serialising these types nor a hasher can fail.
        let _ = serde_json::to_writer(io::BufWriter::with_capacity(1 << 16, &mut hasher), &says);
        hexadecimal(hasher)
    }

    /// The images and meshes that the scene names, once for each place that names them, in the file's order: the path, and a hash of what was
    /// read.
    pub fn asset_digests(&self) -> Vec<(String, String)> {
        let background = match &self.background {
            Background::Image { path } => Some(path.as_str()),
            _ => None,
        };
        let textures =
            self.materials.iter().filter_map(|(_, material)| material.texture()?.image().map(String::as_str));
        let mut paths: Vec<String> = background.into_iter().chain(textures).map(str::to_string).collect();
        self.visit_objects(&mut |_, object| {
            if let Object::Mesh { path, .. } = object {
                paths.push(path.clone());
            }
        });
        let mut known = std::collections::HashMap::new();
        let mut digest = |path: &str| -> String {
            let of_file = || match (self.bitmaps.get(path), self.meshes.get(path)) {
                (Some(bitmap), _) => of_bitmap(bitmap),
                (_, Some(mesh)) => of_mesh(mesh),
                _ => String::new(),
            };
            known.entry(path.to_string()).or_insert_with(of_file).clone()
        };
        paths.into_iter().map(|path| (digest(&path), path)).map(|(digest, path)| (path, digest)).collect()
    }
}

fn of_bitmap(bitmap: &Bitmap) -> String {
    let mut hasher = Sha256::new();
    let _ = write!(hasher, "image {} {} ", bitmap.width, bitmap.height);
    hasher.update(bytemuck::cast_slice(&bitmap.texels));
    hexadecimal(hasher)
}

fn of_mesh(mesh: &Mesh) -> String {
    let mut hasher = Sha256::new();
    let Mesh { positions, triangles, normals, uvs, .. } = mesh;
    let _ = write!(hasher, "mesh {} {} {} {} ", positions.len(), triangles.len(), normals.len(), uvs.len());
    hasher.update(bytemuck::cast_slice(positions));
    hasher.update(bytemuck::cast_slice(triangles));
    hasher.update(bytemuck::cast_slice(normals));
    hasher.update(bytemuck::cast_slice(uvs));
    hexadecimal(hasher)
}

/// The first 128 bits of the hash.
fn hexadecimal(hasher: Sha256) -> String {
    hasher.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}
