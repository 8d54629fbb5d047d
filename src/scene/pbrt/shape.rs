//! Shapes: as our own where they are the same, as meshes elsewhere.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2};

use super::material::{lambertian, number_or};
use super::params::Params;
use super::reader::{AS_THEY_ARE, Mapping, Medium, On, Reader};
use crate::error::Result;
use crate::printable::quote;
use crate::scene::draft::{Draft, MOST_BYTES};
use crate::scene::file::OnProgress;
use crate::scene::mesh_files::load_file;
use crate::scene::mitsuba::mesh;
use crate::scene::mitsuba::shape::{POLES, without_material};
use crate::scene::mitsuba::transform::moved;
use crate::scene::types::*;
use crate::shape::mesh::Mesh;

const KNOWN: &str = "sphere, disk, cylinder, trianglemesh, bilinearmesh, plymesh";

pub fn shape(kind: &str, params: &Params, progress: &mut OnProgress, reader: &mut Reader) -> Result<()> {
    if ["curve", "loopsubdiv"].contains(&kind) {
        reader.lose(&params.at, &params.title, "it is left out: this shape is not read");
        return Ok(());
    }
    let by = reader.state.ctm;
    if by.matrix3.determinant() == 0.0 || !by.is_finite() {
        return Err(params.error("expected a transform that leaves the shape a size"));
    }
    let inside = match reader.state.inside.as_str() {
        "" => None,
        name => {
            let missing = || params.error(format!("there is no medium {}", quote(name)));
            Some(reader.media.get(name).cloned().ok_or_else(missing)?)
        }
    };
    let look = surface(params, inside.as_ref(), reader)?;
    let is_seen = look.0.is_some();
    let object = match kind {
        "sphere" => sphere(params, &by, look, reader)?,
        "disk" => disk(params, &by, look, reader)?,
        "cylinder" => {
            let radius = whole(params)?;
            let (low, high) = (params.number_or("zmin", -1.0)?, params.number_or("zmax", 1.0)?);
            let scale = DAffine3::from_scale(DVec3::new(radius, radius, high - low));
            let placed = by * DAffine3::from_translation(DVec3::new(0.0, 0.0, low)) * scale;
            made(params, mesh::cylinder(), &placed, look, reader)
        }
        "trianglemesh" => {
            let mesh = triangles(params)?;
            made(params, mesh, &by, look, reader)
        }
        "bilinearmesh" => {
            let mesh = patches(params)?;
            made(params, mesh, &by, look, reader)
        }
        "plymesh" => file_mesh(params, &by, look, progress, reader)?,
        _ => return Err(params.error(format!("this shape is not read: expected one of {KNOWN}"))),
    };
    reader.end(params);
    // Glass has the absorption of a medium that scatters nothing.
    let inside = inside.filter(|medium| !(medium.albedo == Colour::ZERO && is_glass(reader)));
    if let Some(medium) = inside {
        let boundary = without_material(object.clone());
        let Medium { extinction, albedo: Colour { x, y, z }, anisotropy, at } = medium;
        if extinction != Colour::splat(extinction.x) {
            let channels = extinction.to_array();
            let message =
                format!("expected one number for the extinction of all channels of its medium, found {channels:?}");
            return Err(at.error("MakeNamedMedium", message));
        }
        let albedo = Texture::Rgb(x, y, z);
        let boundary = Box::new(boundary);
        let object = Object::Medium { boundary, density: extinction.x, albedo, anisotropy };
        reader.add_object(object, &params.at);
    }
    if is_seen {
        reader.add_object(object, &params.at);
    }
    Ok(())
}

/// The name of the material of a shape, which may emit and have an alpha, or nothing for an interface; and the mapping of its textures.
fn surface(params: &Params, inside: Option<&Medium>, reader: &mut Reader) -> Result<On> {
    reader.mapping.set(reader.looks[reader.state.look].mapping);
    let alpha = number_or(params, "alpha", 1.0, reader)?;
    let absorption = inside.filter(|medium| medium.albedo == Colour::ZERO).map(|medium| medium.extinction);
    let key = (reader.state.look, reader.state.area, format!("{alpha:?} {absorption:?}"));
    if let Some(known) = reader.known.get(&key) {
        return Ok(known.clone());
    }
    let look = &reader.looks[key.0];
    let (found, name, at) = (look.material.clone(), look.name.clone(), look.at.clone());
    let area = key.1.and_then(|area| reader.areas.get(area));
    let light = area.map(|area| (area.radiance, area.is_two_sided, area.at.clone()));
    let found = match (found, absorption) {
        (Some(Material::Dielectric(own)), Some(_)) => Some(Material::Dielectric(Dielectric { absorption, ..own })),
        (Some(Material::RoughDielectric(own)), Some(_)) => {
            Some(Material::RoughDielectric(RoughDielectric { absorption, ..own }))
        }
        (found, _) => found,
    };
    let found = match light {
        None => found,
        Some((Colour { x, y, z }, two_sided, place)) => {
            let emit = Texture::Rgb(x, y, z);
            let found = found.unwrap_or_else(|| lambertian(Texture::grey(0.0)));
            let is_black = matches!(&found, Material::Lambertian(own) if own.albedo == Texture::grey(0.0));
            if !is_black && !two_sided {
                reader.lose(&place, "AreaLightSource", "the backs of its shapes are black here");
            }
            match found {
                _ if is_black => Some(Material::DiffuseLight(DiffuseLight { emit, two_sided })),
                Material::Lambertian(own) => {
                    Some(Material::Lambertian(Lambertian { emission: Some(emit), one_sided: !two_sided, ..own }))
                }
                Material::Plastic(own) => {
                    Some(Material::Plastic(Plastic { emission: Some(emit), one_sided: !two_sided, ..own }))
                }
                _ => return Err(place.error("AreaLightSource", "only diffuse and coateddiffuse shapes can emit here")),
            }
        }
    };
    let found = match (found, alpha) {
        (found, alpha) if alpha == Texture::grey(1.0) => found,
        (Some(Material::Lambertian(own)), alpha) => Some(Material::Lambertian(Lambertian { alpha, ..own })),
        (Some(Material::Plastic(own)), alpha) => Some(Material::Plastic(Plastic { alpha, ..own })),
        (Some(Material::Pbr(own)), alpha) => Some(Material::Pbr(Pbr { alpha, ..own })),
        (Some(Material::Mix(own)), alpha) => Some(Material::Mix(Mix { alpha, ..own })),
        _ => return Err(params.error_at("alpha", "expected 1 for this material: others have no alpha here")),
    };
    let made = (found.map(|material| reader.add_material(material, &name, &at)), reader.mapping.take());
    reader.known.insert(key, made.clone());
    Ok(made)
}

fn is_glass(reader: &Reader) -> bool {
    let material = reader.looks.get(reader.state.look).and_then(|look| look.material.as_ref());
    matches!(material, Some(Material::Dielectric(_) | Material::RoughDielectric(_)))
}

/// The radius of a quadric that is whole.
fn whole(params: &Params) -> Result<f64> {
    if params.number_or("phimax", 360.0)? < 360.0 {
        return Err(params.error_at("phimax", "expected 360: parts of shapes are not read"));
    }
    let radius = params.number_or("radius", 1.0)?;
    match radius > 0.0 {
        true => Ok(radius),
        false => Err(params.error_at("radius", format!("expected a radius above 0, found {radius}"))),
    }
}

fn sphere(params: &Params, by: &DAffine3, look: On, reader: &mut Reader) -> Result<Object> {
    let radius = whole(params)?;
    for (name, sign) in [("zmin", -1.0), ("zmax", 1.0)] {
        if sign * params.number_or(name, sign * radius)? < radius {
            return Err(params.error_at(name, "expected the whole sphere: parts of shapes are not read"));
        }
    }
    let placed = *by * DAffine3::from_scale(DVec3::splat(radius));
    // A mirror image of a sphere is a sphere.
    let mirrors = placed.matrix3.determinant() < 0.0;
    let round = if mirrors { placed * DAffine3::from_scale(DVec3::NEG_ONE) } else { placed };
    let is_plain = moved(&round, Object::Group(Vec::new())).is_some() && !reader.state.is_reversed;
    if is_plain && look.1.is_none() {
        let radius = placed.matrix3.determinant().abs().cbrt();
        return Ok(Object::Sphere { center: placed.translation, radius, material: look.0 });
    }
    let sphere = Object::Sphere { center: DVec3::ZERO, radius: 1.0, material: look.0.clone() };
    let turned = moved(&(placed * DAffine3::from_mat3(POLES)), sphere);
    Ok(match turned.filter(|_| is_plain && look.1 == Some(AS_THEY_ARE)) {
        Some(object) => object,
        None => made(params, mesh::sphere(), &placed, look, reader),
    })
}

fn disk(params: &Params, by: &DAffine3, (material, mapping): On, reader: &mut Reader) -> Result<Object> {
    let radius = whole(params)?;
    if mapping.is_some() {
        return Err(params.error("texture coordinates of a disk are not read"));
    }
    if params.number_or("innerradius", 0.0)? != 0.0 {
        return Err(params.error_at("innerradius", "expected 0: a disk with a hole is not read"));
    }
    let center = by.transform_point3(DVec3::new(0.0, 0.0, params.number_or("height", 0.0)?));
    let normal = by.matrix3.inverse().transpose().z_axis.normalize_or(DVec3::Z);
    let (x, y) = (by.matrix3.x_axis, by.matrix3.y_axis);
    if (x.length() - y.length()).abs() > 1e-6 * x.length() || x.dot(y).abs() > 1e-6 * x.length_squared() {
        return Err(params.error("expected a transform that leaves the disk round"));
    }
    let normal = if reader.state.is_reversed { -normal } else { normal };
    Ok(Object::Disk { center, normal, radius: radius * x.length(), material })
}

/// A mesh that no file has, with its transform in its vertices.
fn made(params: &Params, mut mesh: Mesh, by: &DAffine3, look: On, reader: &mut Reader) -> Object {
    if ["sphere", "cylinder"].iter().any(|kind| params.title.ends_with(kind)) {
        let message = format!("it becomes a mesh with {} edges around", mesh::AROUND);
        reader.lose(&params.at, &params.title, &message);
    }
    placed(&mut mesh, by, reader.state.is_reversed, look.1);
    reader.add_mesh(mesh, look.0)
}

/// Puts a transform into the vertices. The front stays the front, unless the orientation is reversed.
fn placed(mesh: &mut Mesh, by: &DAffine3, is_reversed: bool, mapping: Option<Mapping>) {
    let mirrors = by.matrix3.determinant() < 0.0;
    mesh::transformed(mesh, by);
    if mirrors && mesh.normals.is_empty() {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    if is_reversed {
        mesh::flip(mesh);
    }
    let [scale, shift] = mapping.unwrap_or(AS_THEY_ARE);
    mesh.uvs.iter_mut().for_each(|uv| *uv = (scale * uv.as_dvec2() + shift).as_vec2());
}

fn triangles(params: &Params) -> Result<Mesh> {
    params.ignore(&["S"]);
    let positions = params.points("P")?;
    if positions.is_empty() {
        return Err(params.error("expected the points P of its vertices"));
    }
    let mut triangles = params.indices::<3>("indices", positions.len())?;
    if triangles.is_empty() && positions.len() == 3 && !params.has("indices") {
        triangles = vec![[0, 1, 2]];
    }
    mesh_of(params, positions, triangles)
}

/// Each patch becomes two triangles.
fn patches(params: &Params) -> Result<Mesh> {
    let positions = params.points("P")?;
    let mut patches = params.indices::<4>("indices", positions.len())?;
    if patches.is_empty() && positions.len() == 4 && !params.has("indices") {
        patches = vec![[0, 1, 2, 3]];
    }
    let triangles = patches.into_iter().flat_map(|[a, b, c, d]| [[a, b, d], [a, d, c]]).collect();
    mesh_of(params, positions, triangles)
}

fn mesh_of(params: &Params, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Mesh> {
    let normals: Vec<_> = params.points("N")?.into_iter().map(|normal| normal.as_vec3()).collect();
    let name = if params.has("st") { "st" } else { "uv" };
    let uvs: Vec<Vec2> = params.points2(name)?.into_iter().map(|uv| uv.as_vec2()).collect();
    for (name, count) in [("N", normals.len()), (name, uvs.len())] {
        if count != 0 && count != positions.len() {
            return Err(
                params.error_at(name, format!("expected one for each of {} points, found {count}", positions.len()))
            );
        }
    }
    if triangles.is_empty() {
        return Err(params.error("expected the indices of its triangles"));
    }
    let draft = || -> std::result::Result<Mesh, String> {
        let mut draft = Draft::new(MOST_BYTES);
        positions.iter().try_for_each(|position| draft.vertex(*position).map(drop))?;
        (draft.normals, draft.uvs) = (normals, uvs);
        triangles.iter().try_for_each(|corners| draft.face(corners))?;
        draft.finish()
    };
    draft().map_err(|reason| params.error(reason))
}

fn file_mesh(
    params: &Params,
    by: &DAffine3,
    look: On,
    progress: &mut OnProgress,
    reader: &mut Reader,
) -> Result<Object> {
    let name = params.word("filename")?.ok_or_else(|| params.error("expected its filename"))?;
    let path = reader.resolve(name, params.place_of("filename"));
    if params.has("displacement") {
        return Err(params.error_at("displacement", "a displacement is not read"));
    }
    let object = Object::Mesh { path: reader.named(&path), material: look.0.clone() };
    let is_as_it_is = !reader.state.is_reversed && look.1.is_none_or(|mapping| mapping == AS_THEY_ARE);
    if let Some(object) = moved(by, object).filter(|_| is_as_it_is) {
        return Ok(object);
    }
    let broken = |reason: String| params.error_at("filename", format!("{}: {reason}", path.display()));
    reader.assets.stamp_files(&path);
    let (read, ..) = load_file(&path, MOST_BYTES, progress).map_err(broken)?;
    let mut mesh = Arc::unwrap_or_clone(read);
    placed(&mut mesh, by, reader.state.is_reversed, look.1);
    reader.files.push(path);
    Ok(reader.add_mesh(mesh, look.0))
}
