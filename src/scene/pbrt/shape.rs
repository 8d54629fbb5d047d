//! Shapes: as our own where they are the same, as meshes elsewhere.

use std::collections::{BTreeMap, HashSet};
use std::f64::consts::PI;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Vec2};

use super::params::Params;
use super::reader::{AS_THEY_ARE, Area, Mapping, On, Reader, State};
use super::texture::number_or;
use crate::error::{Result, require};
use crate::printable::quote;
use crate::scene::draft::{Draft, MOST_BYTES};
use crate::scene::imported::surface::Medium;
use crate::scene::imported::transform::moved;
use crate::scene::imported::{Body, Place, mesh, surface as surfaces};
use crate::scene::types::*;
use crate::shape::Aabb;
use crate::shape::mesh::Mesh;

const KNOWN: &str = "sphere, disk, cylinder, trianglemesh, bilinearmesh, plymesh";

/// The faces of a mesh that are one light, unless all are.
type Faces = Option<HashSet<u32>>;

/// The most faces of a mesh whose lights differ.
const MOST_LAMPS: usize = 4096;

pub fn shape(kind: &str, params: &Params, reader: &mut Reader) -> Result<()> {
    if ["curve", "loopsubdiv"].contains(&kind) {
        reader.lose(params, "", "it is left out: this shape is not read");
        return Ok(());
    }
    if let Some(definition) = &mut reader.definition {
        if reader.state.area.take().is_some() {
            let note = params.at.error(&params.title, "it emits nothing: pbrt has no area lights in objects");
            reader.made.notes.push(note.to_string());
        }
        definition.shapes.push((kind.to_owned(), params.clone(), reader.state.clone()));
    }
    let by = reader.state.ctm;
    let has_size = by.matrix3.determinant() != 0.0 && by.is_finite();
    require(has_size, || params.error("expected a transform that leaves the shape a size"))?;
    let inside = match reader.state.inside.as_str() {
        "" => None,
        name => {
            let missing = || params.error(format!("there is no medium {}", quote(name)));
            Some(reader.media.get(name).cloned().ok_or_else(missing)?)
        }
    };
    let mut objects = Vec::new();
    for (power, faces) in lamps(kind, params, reader)? {
        let look = surface(params, inside.as_ref().map(|(medium, _)| medium), power, reader)?;
        let is_seen = look.0.is_some();
        objects.push((object(kind, params, faces, look, reader)?, is_seen));
    }
    reader.end(params);
    let material = reader.looks.get(reader.state.look).and_then(|look| look.material.as_ref());
    let is_glass = matches!(material, Some(Material::Dielectric(_) | Material::RoughDielectric(_)));
    // Glass has the absorption of a medium that scatters nothing.
    let inside = inside.filter(|(medium, _)| !(medium.albedo == Colour::ZERO && is_glass));
    let (emits, has_medium) = (reader.state.area.is_some(), inside.is_some());
    if (is_glass || emits || has_medium) && reader.definition.is_none() {
        let around = match mesh_of(kind, params, false, reader)? {
            Some(mesh) => mesh.bounds(),
            None => Quadric::read(kind, params)?.bounds(),
        };
        let around = Aabb::around(around.corners().map(|p| by.transform_point3(p)));
        let (at, title) = (params.at.clone(), params.title.clone());
        reader.made.bodies.push(Body { at, title, around, is_glass, emits, has_medium });
    }
    if let Some((medium, at)) = inside {
        if medium.extinction != Colour::splat(medium.extinction.x) {
            let found = medium.extinction.to_array();
            let message =
                format!("expected one number for the extinction of all channels of its medium, found {found:?}");
            return Err(at.error("MakeNamedMedium", message));
        }
        let [(boundary, _)] = &objects[..] else {
            return Err(params.error(
                "expected no power for the faces of different areas around a medium: give the light its scale",
            ));
        };
        reader.add_object(medium.inside(surfaces::without_material(boundary.clone())), &params.at);
    }
    for (object, _) in objects.into_iter().filter(|(_, is_seen)| *is_seen) {
        reader.add_object(object, &params.at);
    }
    Ok(())
}

/// A shape, or those of its faces that are part of it.
fn object(kind: &str, params: &Params, faces: Faces, look: On, reader: &mut Reader) -> Result<Object> {
    let by = reader.state.ctm;
    // A mirror image of a quadric is inside out in pbrt, that of a mesh or an instance is not.
    let mirrors = (by.matrix3.determinant() < 0.0) != reader.state.is_in_mirror;
    let flips = reader.state.is_reversed != mirrors;
    match kind {
        "sphere" => sphere(params, &by, flips, look, reader),
        "disk" => disk(params, &by, flips, look, reader),
        "cylinder" => {
            let Quadric { radius, turn, low, high, .. } = Quadric::read(kind, params)?;
            let scale = DAffine3::from_scale(DVec3::new(radius, radius, high - low));
            let placed = by * DAffine3::from_translation(DVec3::new(0.0, 0.0, low)) * scale;
            Ok(made(params, mesh::cylinder(turn), &placed, flips, look, reader))
        }
        "plymesh" if faces.is_none() => file_mesh(params, &by, look, reader),
        _ if let Some(mut mesh) = mesh_of(kind, params, look.1.is_some(), reader)? => {
            if let Some(faces) = faces {
                let part = mesh::part(&mesh, |face| faces.contains(&(face / split(kind))));
                mesh = Arc::new(part.map_err(|reason| params.error(reason))?);
            }
            Ok(made(params, Arc::unwrap_or_clone(mesh), &by, reader.state.is_reversed, look, reader))
        }
        _ => Err(params.error(format!("this shape is not read: expected one of {KNOWN}"))),
    }
}

/// The shapes of an object, placed.
pub fn instance(name: &str, at: &Place, reader: &mut Reader) -> Result<()> {
    let what = "ObjectInstance";
    let is_outside = reader.definition.is_none();
    require(is_outside, || at.error(what, "expected no instance inside of an object, as pbrt has it"))?;
    let missing = || at.error(what, format!("there is no object {}", quote(name)));
    let definition = Rc::clone(reader.definitions.get(name).ok_or_else(missing)?);
    let by = reader.state.ctm;
    if let Some(group) = moved(&by, Object::Group(definition.objects.clone())) {
        reader.add_object(group, at);
        return Ok(());
    }
    // Each shape is made again, with the transform of the instance in its own.
    let is_in_mirror = by.matrix3.determinant() < 0.0;
    for (kind, params, state) in &definition.shapes {
        let placed = State { ctm: by * state.ctm, is_in_mirror, ..state.clone() };
        let before = std::mem::replace(&mut reader.state, placed);
        let done = shape(kind, params, reader);
        reader.state = before;
        done?;
        if reader.made.findings.is_full() {
            break;
        }
    }
    Ok(())
}

/// The name of the material of a shape, which may emit and have an alpha, or nothing for an interface; and the mapping of its textures.
fn surface(params: &Params, inside: Option<&Medium>, power: f64, reader: &mut Reader) -> Result<On> {
    reader.mapping = reader.looks[reader.state.look].mapping;
    let alpha = number_or(params, "alpha", 1.0, reader)?;
    let absorption = inside.filter(|medium| medium.albedo == Colour::ZERO).map(|medium| medium.extinction);
    let look = &reader.looks[reader.state.look];
    let (mut found, name, at) = (look.material.clone(), look.name.clone(), look.at.clone());
    if let Some(slot) = found.as_mut().and_then(surfaces::absorption_of) {
        *slot = absorption;
    }
    let area = reader.state.area.and_then(|area| reader.areas.get(area));
    if area.is_some() {
        found.get_or_insert_with(|| surfaces::lambertian(Texture::grey(0.0), false));
    }
    if alpha != Texture::grey(1.0) {
        let wrong = || params.error_at("alpha", "expected 1 for this material: others have no alpha here");
        *found.as_mut().and_then(surfaces::alpha_of).ok_or_else(wrong)? = alpha.clone();
    }
    if let Some(Area { radiance, is_two_sided, at, .. }) = area {
        let wrong = || at.error("AreaLightSource", "only diffuse and coateddiffuse shapes can emit here");
        let emission = Texture::from(*radiance / power);
        found = Some(found.and_then(|own| surfaces::emitting(own, emission, *is_two_sided)).ok_or_else(wrong)?);
        if alpha == Texture::grey(0.0) {
            reader.made.lose(at, "AreaLightSource", "a lamp that nobody sees is left out");
        }
    }
    Ok((found.map(|material| reader.add_material(material, &name, &at)), reader.mapping.take()))
}

/// A part of a sphere, or of a cylinder or a disk around z.
struct Quadric {
    radius: f64,
    /// The share of a turn.
    turn: f64,
    /// The ends along z.
    low: f64,
    high: f64,
    /// The radius of the hole in a disk.
    hole: f64,
}

impl Quadric {
    fn read(kind: &str, params: &Params) -> Result<Quadric> {
        let number = |name: &str, usual: f64| params.number_or(name, usual);
        let (radius, degrees) = (number("radius", 1.0)?, number("phimax", 360.0)?);
        let wrong = || params.error(format!("expected a radius and a phimax above 0, found {radius} and {degrees}"));
        require(radius > 0.0 && degrees > 0.0, wrong)?;
        let [low, high, hole] = match kind {
            "sphere" => [number("zmin", -radius)?.max(-radius), number("zmax", radius)?.min(radius), 0.0],
            "cylinder" => [number("zmin", -1.0)?, number("zmax", 1.0)?, 0.0],
            _ => [number("height", 0.0)?, number("height", 0.0)?, number("innerradius", 0.0)?],
        };
        Ok(Quadric { radius, turn: (degrees / 360.0).min(1.0), low, high, hole })
    }

    fn area(&self) -> f64 {
        // A disk has both ends in one place.
        let flat = self.radius * self.radius - self.hole * self.hole;
        PI * self.turn * if self.low == self.high { flat } else { 2.0 * self.radius * (self.high - self.low) }
    }

    fn bounds(&self) -> Aabb {
        let side = DVec2::splat(self.radius);
        Aabb { min: (-side).extend(self.low), max: side.extend(self.high) }
    }
}

/// The lights that a shape is by pbrt, with their faces. The power of each with a radiance of 1 is π times its area: of a quadric that before the
/// transform, of a mesh that of each face, which is a light of its own. Faces of one area are together.
fn lamps(kind: &str, params: &Params, reader: &mut Reader) -> Result<Vec<(f64, Faces)>> {
    let area = reader.state.area.and_then(|area| reader.areas.get(area));
    if !area.is_some_and(|area| area.is_power) {
        return Ok(vec![(1.0, None)]);
    }
    let Some(mesh) = mesh_of(kind, params, false, reader)? else {
        return Ok(vec![(PI * Quadric::read(kind, params)?.area(), None)]);
    };
    let areas = areas_of_faces(&mesh, split(kind), &reader.state.ctm);
    let mut lamps: Vec<(f64, Faces)> = Vec::new();
    for (area, face) in &areas {
        match lamps.last_mut() {
            Some((power, Some(faces))) if PI * area >= (1.0 - 1e-3) * *power => _ = faces.insert(*face),
            _ => lamps.push((PI * area, Some(HashSet::from([*face])))),
        }
    }
    match &mut lamps[..] {
        [] => return Err(params.error("expected faces with an area, each of which has the power of its light")),
        [(_, faces)] => *faces = None,
        _ => require(areas.len() <= MOST_LAMPS, || {
            let found = areas.len();
            params.error(format!(
                "expected at most {MOST_LAMPS} faces of different areas, each of which has the power of its light, found {found}: give the light its scale"
            ))
        })?,
    }
    Ok(lamps)
}

/// The areas of faces with their numbers, the largest first. `split`: how many faces of the mesh are one of pbrt's.
fn areas_of_faces(mesh: &Mesh, split: u32, by: &DAffine3) -> Vec<(f64, u32)> {
    let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
    let corner = |corner: u32| by.transform_point3(mesh.positions.get(corner as usize).copied().unwrap_or_default());
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(corner);
        *areas.entry(mesh.face(number) / split).or_default() += 0.5 * (b - a).cross(c - a).length();
    }
    let areas = areas.into_iter().filter(|(_, area)| *area > 0.0);
    let mut all: Vec<(f64, u32)> = areas.map(|(face, area)| (area, face)).collect();
    all.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    all
}

/// How many faces of a mesh are one of pbrt's.
fn split(kind: &str) -> u32 {
    if kind == "bilinearmesh" { 2 } else { 1 }
}

/// The mesh of a directive that has one.
fn mesh_of(kind: &str, params: &Params, is_textured: bool, reader: &mut Reader) -> Result<Option<Arc<Mesh>>> {
    let [o, x, y, both] = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    Ok(Some(match kind {
        "trianglemesh" => Arc::new(faces(params, [o, x, both], &[[0, 1, 2]], is_textured)?),
        "bilinearmesh" => Arc::new(faces(params, [o, x, y, both], &[[0, 1, 3], [0, 3, 2]], is_textured)?),
        "plymesh" => read_file(params, reader)?,
        _ => return Ok(None),
    }))
}

fn sphere(params: &Params, by: &DAffine3, flips: bool, look: On, reader: &mut Reader) -> Result<Object> {
    let Quadric { radius, turn, low, high, .. } = Quadric::read("sphere", params)?;
    require(low < high, || params.error_at("zmin", "expected a zmin below the zmax"))?;
    let [bottom, top] = [low, high].map(|z| (z / radius).acos() / PI);
    let placed = *by * DAffine3::from_scale(DVec3::splat(radius));
    let as_they_are = look.1.map(|mapping| mapping == AS_THEY_ARE);
    let is_whole = (top, bottom, turn) == (0.0, 1.0, 1.0) && !flips;
    let ours = surfaces::sphere(&placed, &look.0, as_they_are).filter(|_| is_whole);
    Ok(ours.unwrap_or_else(|| made(params, mesh::sphere(top, bottom, turn), &placed, flips, look, reader)))
}

fn disk(params: &Params, by: &DAffine3, flips: bool, look: On, reader: &mut Reader) -> Result<Object> {
    let Quadric { radius, turn, low, hole, .. } = Quadric::read("disk", params)?;
    let is_ours = look.1.is_none() && hole == 0.0 && turn == 1.0;
    let height = DVec3::new(0.0, 0.0, low);
    let ours = surfaces::disk(by, height, radius, flips, &look.0).filter(|_| is_ours);
    let placed = *by * DAffine3::from_translation(height) * DAffine3::from_scale(DVec3::splat(radius));
    let ring = || mesh::disk((hole / radius).clamp(0.0, 1.0), turn);
    Ok(ours.unwrap_or_else(|| made(params, ring(), &placed, flips, look, reader)))
}

/// A mesh that no file has, with its transform in its vertices.
fn made(params: &Params, mut mesh: Mesh, by: &DAffine3, flips: bool, look: On, reader: &mut Reader) -> Object {
    if ["sphere", "cylinder", "disk"].iter().any(|kind| params.title.ends_with(kind)) {
        let message = format!("it becomes a mesh with {} edges around", mesh::AROUND);
        reader.lose(params, "", &message);
    }
    placed(&mut mesh, by, flips, look.1);
    reader.made.add_mesh(mesh, look.0, &params.at)
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

/// A mesh of faces with K corners, each split into triangles. `usual`: the texture coordinates of corners that the file gives none.
fn faces<const K: usize>(params: &Params, usual: [Vec2; K], split: &[[usize; 3]], is_textured: bool) -> Result<Mesh> {
    params.ignore(&["S", "faceIndices"]);
    let mut positions = params.points("P")?;
    require(!positions.is_empty(), || params.error("expected the points P of its vertices"))?;
    let mut faces = params.indices::<K>("indices", positions.len())?;
    if faces.is_empty() && positions.len() == K && !params.has("indices") {
        faces = vec![std::array::from_fn(|corner| corner as u32)];
    }
    let mut normals = params.points("N")?;
    let name = if params.has("st") { "st" } else { "uv" };
    let mut uvs: Vec<Vec2> = params.points2(name)?.into_iter().map(|uv| uv.as_vec2()).collect();
    for (name, count) in [("N", normals.len()), (name, uvs.len())] {
        if count != 0 && count != positions.len() {
            let message = format!("expected one for each of {} points, found {count}", positions.len());
            return Err(params.error_at(name, message));
        }
    }
    require(!faces.is_empty(), || params.error("expected the indices of its faces"))?;
    if is_textured && uvs.is_empty() {
        let of_corners = |all: &[DVec3]| {
            faces.iter().flatten().filter_map(|corner| all.get(*corner as usize).copied()).collect::<Vec<_>>()
        };
        (positions, normals) = (of_corners(&positions), of_corners(&normals));
        uvs = faces.iter().flat_map(|_| usual).collect();
        for (number, face) in faces.iter_mut().enumerate() {
            *face = std::array::from_fn(|corner| (K * number + corner) as u32);
        }
    }
    let draft = || -> std::result::Result<Mesh, String> {
        let mut draft = Draft::new(MOST_BYTES);
        positions.iter().try_for_each(|position| draft.vertex(*position).map(drop))?;
        (draft.normals, draft.uvs) = (normals.iter().map(|normal| normal.as_vec3()).collect(), uvs);
        for face in &faces {
            split.iter().try_for_each(|corners| draft.face(&corners.map(|corner| face[corner])))?;
        }
        draft.finish()
    };
    draft().map_err(|reason| params.error(reason))
}

fn file_mesh(params: &Params, by: &DAffine3, look: On, reader: &mut Reader) -> Result<Object> {
    let path = ply_path(params, reader)?;
    require(!params.has("displacement"), || params.error_at("displacement", "a displacement is not read"))?;
    let object = Object::Mesh { path: reader.made.named(&path), material: look.0.clone() };
    let is_as_it_is = !reader.state.is_reversed && look.1.is_none_or(|mapping| mapping == AS_THEY_ARE);
    if let Some(object) = moved(by, object).filter(|_| is_as_it_is) {
        return Ok(object);
    }
    let mut mesh = Arc::unwrap_or_clone(read_file(params, reader)?);
    placed(&mut mesh, by, reader.state.is_reversed, look.1);
    Ok(reader.made.add_mesh(mesh, look.0, &params.at))
}

fn ply_path(params: &Params, reader: &Reader) -> Result<PathBuf> {
    let name = params.word("filename")?.ok_or_else(|| params.error("expected its filename"))?;
    Ok(reader.resolve(name, params.place_of("filename")))
}

fn read_file(params: &Params, reader: &mut Reader) -> Result<Arc<Mesh>> {
    let path = ply_path(params, reader)?;
    let broken = |reason: String| params.error_at("filename", format!("{}: {reason}", path.display()));
    reader.made.add_file(&path);
    reader.made.mesh(&path, reader.progress).map_err(broken)
}
