//! A mesh file as a scene: its mesh, or of an OBJ file one mesh for each material.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3};

use super::{mtl, ply};
use crate::error::Result;
use crate::scene::assets::Assets;
use crate::scene::file::OnProgress;
use crate::scene::gltf::{Contents, default_material};
use crate::scene::gltf_path::{Part, has_ending};
use crate::scene::types::{Material, Object, Transform};
use crate::source::error_in_file;

/// The contents of a mesh file, and the files of materials that they were read from. `seen` gives a file's path as the scene names it.
pub fn contents(
    path: &Path,
    seen: &dyn Fn(&Path) -> String,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<(Contents, Vec<PathBuf>)> {
    let (mut contents, name) = (Contents::default(), seen(path));
    if !has_ending(path, &["obj"]) {
        let has_colours = has_ending(path, &["ply"]) && ply::has_colours(path);
        contents.materials.push(("default".to_owned(), Material::Pbr(default_material(true, has_colours))));
        let mesh = Object::Mesh { path: name.clone(), material: Some("default".to_owned()) };
        // STL is of CAD and of printers, whose z is up.
        let turn = -90.0;
        let is_stl = has_ending(path, &["stl"]);
        contents.objects.push(match is_stl {
            true => Object::Transformed { by: vec![Transform::RotateX(turn)], object: Box::new(mesh) },
            false => mesh,
        });
        let turned = if is_stl { DMat3::from_rotation_x(turn.to_radians()) } else { DMat3::IDENTITY };
        contents.meshes.push((name, DAffine3::from_mat3(turned)));
        return Ok((contents, Vec::new()));
    }
    let parts = assets.obj.open(path, progress).map_err(|reason| error_in_file(path, "OBJ", &reason))?;
    let (mut given, mut read) = (HashMap::new(), Vec::new());
    for (library, line) in mtl::libraries(path, &parts.libraries) {
        assets.stamp_files(&library);
        if !library.is_file() {
            let reason = "its materials are grey plastic";
            contents.notes.push(format!(
                "{}:{line}: mtllib: there is no file {}: {reason}",
                path.display(),
                library.display()
            ));
            continue;
        }
        let of_library = mtl::read(&library).map_err(|reason| error_in_file(&library, "MTL", &reason))?;
        for (name, material) in of_library {
            given.entry(name).or_insert(material);
        }
        read.push(library);
    }
    let mut taken = HashSet::new();
    for (number, ((mesh, _), own)) in parts.meshes.iter().zip(&parts.materials).enumerate() {
        let Some(mesh) = mesh else { continue };
        let own_name = own.as_ref().map_or("default", |(name, _)| name.as_str());
        let material = match own.as_ref().map(|(name, line)| (given.get(name), line)) {
            Some((Some(material), _)) => material.material(own_name, !mesh.uvs.is_empty(), seen, &mut contents.notes),
            Some((None, line)) => {
                let note =
                    format!("{}:{line}: usemtl: there is no material {own_name:?}: it is grey plastic", path.display());
                contents.notes.extend((!read.is_empty()).then_some(note));
                Material::Pbr(default_material(true, false))
            }
            None => Material::Pbr(default_material(true, false)),
        };
        let mut unique = own_name.to_owned();
        while !taken.insert(unique.clone()) {
            unique += " (default)";
        }
        contents.materials.push((unique.clone(), material));
        let part = format!("{name}#{}", Part::OfMaterial(number));
        contents.objects.push(Object::Mesh { path: part.clone(), material: Some(unique) });
        contents.meshes.push((part, DAffine3::IDENTITY));
    }
    Ok((contents, read))
}
