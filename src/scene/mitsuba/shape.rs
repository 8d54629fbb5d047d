//! Shapes: as our own where they are the same, as meshes elsewhere.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2};

use super::document::{Node, resolve};
use super::emitter::medium;
use super::properties::{Properties, unknown};
use super::reader::Reader;
use super::{bsdf, serialized};
use crate::error::{Result, require};
use crate::lobe::anisotropy::ANISOTROPY;
use crate::scene::file::{self, OnProgress};
use crate::scene::imported::surface::Medium;
use crate::scene::imported::transform::moved;
use crate::scene::imported::{Body, mesh, surface};
use crate::scene::types::*;
use crate::shape::Aabb;
use crate::shape::mesh::Mesh;

const KNOWN: &str = "obj, ply, serialized, sphere, rectangle, cube, disk, cylinder, shapegroup, instance";

/// What is inside a shape and on it.
struct Surface {
    material: Option<String>,
    /// Whether it has textures, and how they lie.
    is_textured: bool,
    to_uv: DAffine3,
    inside: Option<Medium>,
    has_image: bool,
    is_glass: bool,
    emits: bool,
}

/// The objects of a shape. `world` is applied after its own transform.
pub fn shape<'a>(
    node: &'a Node,
    world: &DAffine3,
    progress: &mut OnProgress,
    reader: &mut Reader<'a, '_>,
) -> Result<Vec<Object>> {
    let own = Properties::of(node);
    let kind = own.kind()?;
    let id = node.attribute("id");
    let named = |object: Object| match id {
        Some(id) => Object::Named { name: id.to_owned(), object: Box::new(object) },
        None => object,
    };
    if kind == "shapegroup" {
        return Ok(Vec::new());
    }
    let to_world = *world * own.transform("to_world")?;
    let has_size = to_world.matrix3.determinant() != 0.0 && to_world.is_finite();
    require(has_size, || node.error("expected a to_world that leaves the shape a size"))?;
    if kind == "instance" {
        return Ok(vec![named(instance(&own, &to_world, progress, reader)?)]);
    }
    let surface = surface(&own, reader)?;
    let flips = own.flag_or("flip_normals", false)?;
    let material = surface.material.clone();
    let to_world = to_world * placed(&own, kind)?;
    let mut around = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
    let object = match kind {
        "sphere" => sphere(node, &to_world, flips, &surface, reader),
        "rectangle" => {
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = to_world.matrix3;
            let ours = Object::Quad { corner: to_world.translation - x - y, u: 2.0 * x, v: 2.0 * y, material };
            let is_ours = !surface.is_textured && !flips && x.cross(y).dot(z) >= 0.0;
            let ours = Some(ours).filter(|_| is_ours);
            ours.unwrap_or_else(|| made(node, mesh::rectangle(), &to_world, flips, &surface, reader))
        }
        "cube" => {
            let sides = to_world.matrix3.to_cols_array_2d().map(|column| DVec3::from_array(column).length());
            let half = DVec3::from_array(sides);
            let placed = to_world * DAffine3::from_scale(half.recip());
            let ours = moved(&placed, Object::Box { min: -half, max: half, material });
            let ours = ours.filter(|_| !surface.is_textured && !flips);
            ours.unwrap_or_else(|| made(node, mesh::cube(), &to_world, flips, &surface, reader))
        }
        "disk" => {
            let ours = surface::disk(&to_world, DVec3::ZERO, 1.0, flips, &material);
            let ours = ours.filter(|_| !surface.is_textured);
            ours.unwrap_or_else(|| made(node, disk(), &to_world, flips, &surface, reader))
        }
        "cylinder" => {
            around.min.z = 0.0;
            made(node, mesh::cylinder(1.0), &to_world, flips, &surface, reader)
        }
        "obj" | "ply" | "serialized" => {
            let (object, bounds) = file_mesh(&own, kind, &to_world, flips, &surface, progress, reader)?;
            around = bounds;
            object
        }
        _ => return Err(unknown(node, KNOWN)),
    };
    own.ignore(&["silhouette_sampling_weight"]);
    own.end(reader);
    if surface.is_glass && ["rectangle", "disk", "cylinder"].contains(&kind) {
        reader
            .lose(node, "its glass has no inside: Mitsuba scales the radiance that passes by the square of the index");
    }
    if kind == "sphere" && surface.has_image && !matches!(object, Object::Mesh { .. }) {
        reader.lose(node, "its image ends at the poles here: Mitsuba blends its first row with its last");
    }
    let around = Aabb::around(around.corners().map(|p| to_world.transform_point3(p)));
    let Surface { is_glass, emits, .. } = surface;
    let (at, title, has_medium) = (node.at.clone(), node.title(), surface.inside.is_some());
    reader.made.bodies.push(Body { at, title, around, is_glass, emits, has_medium });
    let mut objects = Vec::new();
    if let Some(medium) = &surface.inside {
        objects.push(named(medium.inside(surface::without_material(object.clone()))));
    }
    if surface.material.is_some() {
        objects.push(named(object));
    } else if surface.inside.is_none() {
        reader.lose(node, "it has neither a surface nor a medium, and is left out");
    }
    Ok(objects)
}

/// The transform of a kind of shape that has another place than its own space: of the unit sphere, and of the cylinder of radius 1 from z = 0 to 1.
fn placed(own: &Properties, kind: &str) -> Result<DAffine3> {
    if kind != "sphere" && kind != "cylinder" {
        return Ok(DAffine3::IDENTITY);
    }
    let radius = own.number_or("radius", 1.0)?;
    require(radius > 0.0, || own.node.error(format!("expected a radius above 0, found {radius}")))?;
    if kind == "sphere" {
        let center = own.vector("center")?.unwrap_or(DVec3::ZERO);
        return Ok(DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(radius)));
    }
    let (p0, p1) = (own.vector("p0")?.unwrap_or(DVec3::ZERO), own.vector("p1")?.unwrap_or(DVec3::Z));
    let along = p1 - p0;
    let axis = along.try_normalize().ok_or_else(|| own.node.error("expected p0 and p1 to differ"))?;
    let turn = DQuat::from_rotation_arc(DVec3::Z, axis);
    Ok(DAffine3::from_scale_rotation_translation(DVec3::new(radius, radius, along.length()), turn, p0))
}

/// The shapes of a group, placed.
fn instance<'a>(
    own: &Properties<'a>,
    to_world: &DAffine3,
    progress: &mut OnProgress,
    reader: &mut Reader<'a, '_>,
) -> Result<Object> {
    let group = own.take(|child| child.tag == "ref" || child.tag == "shape");
    let [group] = group[..] else { return Err(own.node.error("expected one shapegroup in it")) };
    let group = reader.follow(group, "shape")?;
    let is_group = group.attribute("type") == Some("shapegroup");
    require(is_group, || own.node.error(format!("expected a shapegroup, found {}", group.title())))?;
    own.end(reader);
    let is_even = moved(to_world, Object::Group(Vec::new())).is_some();
    let inner = if is_even { DAffine3::IDENTITY } else { *to_world };
    let (mut objects, bodies) = (Vec::new(), reader.made.bodies.len());
    for child in &group.children {
        require(child.tag == "shape", || child.error("expected shapes in a shapegroup, and nothing else"))?;
        let is_nested = ["instance", "shapegroup"].contains(&child.required("type")?);
        require(!is_nested, || child.error("expected no instance inside a shapegroup"))?;
        let key = (std::ptr::from_ref(child), inner.to_cols_array().map(f64::to_bits));
        let known = match reader.grouped.get(&key) {
            Some(known) => known.clone(),
            None => shape(child, &inner, progress, reader)?,
        };
        objects.extend(known.iter().cloned());
        reader.grouped.insert(key, known);
    }
    // Where these are is not where instances are.
    reader.made.bodies.truncate(bodies);
    let group = Object::Group(objects);
    Ok(if is_even { moved(to_world, group.clone()).unwrap_or(group) } else { group })
}

/// A disk, whose u is the radius, and whose v is the share of a turn, downwards.
fn disk() -> Mesh {
    let mut mesh = mesh::disk(0.0, 1.0);
    mesh.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(1.0 - uv.y, 1.0 - uv.x));
    mesh
}

/// The sphere that the unit sphere becomes.
fn sphere(node: &Node, by: &DAffine3, flips: bool, surface: &Surface, reader: &mut Reader) -> Object {
    let is_flipped = flips != (by.matrix3.determinant() < 0.0);
    let textures = surface.is_textured.then_some(surface.to_uv == DAffine3::IDENTITY);
    if let Some(sphere) = surface::sphere(by, &surface.material, textures).filter(|_| !is_flipped) {
        return sphere;
    }
    if surface::sphere(by, &None, None).is_none() {
        reader.lose(node, "it becomes an uneven mesh: Mitsuba shows a round sphere");
    }
    made(node, mesh::sphere(0.0, 1.0, 1.0), by, is_flipped, surface, reader)
}

/// A mesh of a shape of Mitsuba.
fn made(node: &Node, mut mesh: Mesh, by: &DAffine3, flips: bool, surface: &Surface, reader: &mut Reader) -> Object {
    if mesh.positions.len() > 24 {
        let edges = mesh::AROUND;
        reader.lose(node, &format!("it becomes a mesh with {edges} edges around"));
    }
    mesh::transformed(&mut mesh, by);
    mesh::to_uv(&mut mesh, &surface.to_uv);
    if flips {
        mesh::flip(&mut mesh);
    }
    reader.made.add_mesh(mesh, surface.material.clone(), &node.at)
}

fn file_mesh(
    own: &Properties,
    kind: &str,
    to_world: &DAffine3,
    flips: bool,
    surface: &Surface,
    progress: &mut OnProgress,
    reader: &mut Reader,
) -> Result<(Object, Aabb)> {
    let node = own.node;
    let name = own.word("filename")?.ok_or_else(|| node.error("expected its filename"))?;
    let path = resolve(name, node, &reader.folders);
    let broken = |reason: String| {
        own.find("filename").unwrap_or(node).error_at("value", format!("{}: {reason}", path.display()))
    };
    reader.made.assets.stamp_files(&path);
    require(path.exists(), || broken("there is no such file".to_owned()))?;
    let faceted = own.flag_or("face_normals", false)?;
    let flipped_uvs = own.flag_or("flip_tex_coords", kind == "obj")?;
    let number = own.integer_or("shape_index", 0)?;
    let number = usize::try_from(number).map_err(|_| node.error("expected a shape_index of 0 or more"))?;
    let read = if kind == "serialized" {
        let bytes = file::read(&path, "mesh", file::LONGEST).map_err(broken)?;
        Arc::new(serialized::read(&bytes, number).map_err(broken)?)
    } else {
        reader.made.mesh(&path, progress).map_err(broken)?
    };
    // The file's v is upwards as ours, unless Mitsuba takes it as it is.
    let turned = DAffine3::from_translation(DVec3::Y) * DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let to_uv = surface.to_uv * if flipped_uvs { DAffine3::IDENTITY } else { turned };
    let changes_uvs = to_uv != DAffine3::IDENTITY && !read.uvs.is_empty();
    let changes_normals = faceted != read.normals.is_empty();
    let bounds = read.bounds();
    if kind != "serialized" && !changes_uvs && !changes_normals && !flips {
        let mesh = Object::Mesh { path: reader.made.named(&path), material: surface.material.clone() };
        if let Some(object) = moved(to_world, mesh) {
            return Ok((object, bounds));
        }
    }
    reader.made.files.push(path);
    let mut mesh = (*read).clone();
    if faceted {
        mesh.normals = Vec::new();
    }
    mesh::to_uv(&mut mesh, &to_uv);
    mesh::transformed(&mut mesh, to_world);
    if !faceted && mesh.normals.is_empty() {
        mesh::smooth(&mut mesh);
    }
    if flips {
        mesh::flip(&mut mesh);
    }
    Ok((reader.made.add_mesh(mesh, surface.material.clone(), &node.at), bounds))
}

/// The material and the medium of a shape.
fn surface<'a>(own: &Properties<'a>, reader: &mut Reader<'a, '_>) -> Result<Surface> {
    let node = own.node;
    let of_bsdf = match own.elements("bsdf", reader)?[..] {
        [] => None,
        [one] => Some(one),
        [_, other, ..] => return Err(other.error("expected one bsdf in a shape, found another")),
    };
    let emitters = own.elements("emitter", reader)?;
    let mut inside = None;
    for child in own.take(|child| reader.follow(child, "medium").is_ok()) {
        let is_inside = child.attribute("name") == Some("interior");
        require(is_inside, || child.error("expected the name interior: other media are not read"))?;
        if !reader.has_media {
            reader.lose(child, "Mitsuba leaves media out unless the integrator is volpath or volpathmis");
        }
        inside = Some(medium(reader.follow(child, "medium")?, reader)?);
    }
    // A medium that scatters nothing absorbs, by channels too.
    let absorption = inside.as_ref().map(|medium| medium.extinction).filter(|found| *found != Colour::splat(found.x));
    reader.to_uv = None;
    let emission = match emitters[..] {
        [] => None,
        [emitter] => {
            let of_emitter = Properties::of(emitter);
            of_emitter.kind_among(&["area"])?;
            of_emitter.ignore(&["sampling_weight"]);
            let found = bsdf::texture_or(&of_emitter, "radiance", 1.0, reader)?;
            of_emitter.end(reader);
            Some((emitter, found))
        }
        _ => return Err(node.error("expected one emitter in it")),
    };
    let key = (
        of_bsdf.map_or(std::ptr::null(), std::ptr::from_ref),
        format!("{:?} {absorption:?}", emission.as_ref().map(|(_, found)| found)),
    );
    let emits = emission.is_some();
    let made = match reader.known.get(&key) {
        Some(made) => *made,
        None => {
            let mut found = match of_bsdf {
                Some(found) => bsdf::material(found, false, reader)?,
                None => Some(surface::lambertian(Texture::grey(if emission.is_some() { 0.0 } else { 0.5 }), true)),
            };
            if absorption.is_some() {
                let slot = found.as_mut().and_then(surface::absorption_of);
                let missing = || node.error("expected one number for the sigma_t of its medium: it is not in glass");
                *slot.ok_or_else(missing)? = absorption;
            }
            if let Some((emitter, emission)) = emission {
                let missing = || node.error("an area emitter without a surface is not read");
                let wrong = || emitter.error("only diffuse and plastic surfaces can emit here");
                let lamp = surface::emitting(found.ok_or_else(missing)?, emission, false);
                found = Some(lamp.ok_or_else(wrong)?);
            }
            let to_uv = reader.to_uv.unwrap_or(DAffine3::IDENTITY);
            let made = found.map(|material| (reader.add_material(material, of_bsdf.unwrap_or(node)), to_uv));
            reader.known.insert(key, made);
            made
        }
    };
    let of_name = made.and_then(|(index, _)| reader.made.parts.materials.get(index));
    let material = of_name.map(|(name, _)| name.clone());
    let (of_name, to_uv) = (of_name.map(|(_, own)| own), made.map_or(DAffine3::IDENTITY, |(_, to_uv)| to_uv));
    let parts = of_name.into_iter().flat_map(Material::parts);
    let parts = parts.filter_map(|(_, name)| reader.made.parts.materials.get(*reader.parts.get(name)?));
    let all: Vec<&Material> = of_name.into_iter().chain(parts.map(|(_, part)| part)).collect();
    let textures: Vec<&Texture> = all.iter().flat_map(|material| material.textures()).collect();
    let is_brushed = all.iter().any(|material| material.has_row(ANISOTROPY));
    let is_textured = is_brushed || textures.iter().any(|texture| texture.needs_uv());
    let has_image = textures.iter().any(|texture| texture.decoded().is_some());
    let is_glass = all.iter().any(|own| matches!(own, Material::Dielectric(_) | Material::RoughDielectric(_)));
    let inside = inside.filter(|_| absorption.is_none());
    Ok(Surface { material, is_textured, to_uv, inside, has_image, is_glass, emits })
}
