//! Refuses what parses and means nothing: every error at the value's own place.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;

use super::nearest::nearest;
use super::types::*;
use super::{Mesh, Scene};
use crate::error::Result;
use crate::source::{LARGEST, Place, SMALLEST, length, number, vector};

/// Directions whose angle has a sine below this count as parallel.
const SMALLEST_SINE: f64 = 1e-9;
const LARGEST_SIDE: u32 = 1 << 16;
const LARGEST_AREA: u64 = 1 << 30;
const MOST_SAMPLES: u32 = 1 << 31;
const DEEPEST: u32 = 1_000_000;

/// Checks the whole scene but for what is in its files, in the order of the format's description.
pub fn validate(scene: &Scene) -> Result<()> {
    let top = scene.top();
    image(&top.field("image"), &scene.image)?;
    camera(&top.field("camera"), &scene.camera)?;
    background(&top.field("background"), &scene.background)?;
    for (name, value) in &scene.materials {
        value.check(&top.field("materials").key(name))?;
    }
    objects(scene)?;
    render(&top.field("render"), &scene.render)
}

/// Checks the objects again, now that the meshes are known.
pub fn with_meshes(scene: &Scene) -> Result<()> {
    objects(scene)
}

fn objects(scene: &Scene) -> Result<()> {
    let known = Known {
        all: &scene.materials,
        materials: scene.materials.iter().map(|(name, material)| (name.as_str(), material)).collect(),
        meshes: &scene.meshes,
        closed: RefCell::default(),
    };
    let top = scene.top();
    for (index, value) in scene.objects.iter().enumerate() {
        object(&known, &top.field("objects").index(index), value, Reach::IDENTITY)?;
    }
    Ok(())
}

fn image(at: &Place, image: &ImageSize) -> Result<()> {
    for (name, side) in [("width", image.width), ("height", image.height)] {
        if !(1..=LARGEST_SIDE).contains(&side) {
            return Err(at.field(name).unexpected(format!("a {name} from 1 to {LARGEST_SIDE}")));
        }
    }
    let area = u64::from(image.width) * u64::from(image.height);
    if area > LARGEST_AREA {
        let most = format!("width times height of at most {LARGEST_AREA} pixels");
        return Err(at.error(format!("expected {most}, found {area}")));
    }
    Ok(())
}

fn camera(at: &Place, camera: &Camera) -> Result<()> {
    vector(&at.field("look_from"), camera.look_from)?;
    vector(&at.field("look_at"), camera.look_at)?;
    vector(&at.field("up"), camera.up)?;
    let view = camera.look_at - camera.look_from;
    if view == DVec3::ZERO {
        return Err(at.field("look_at").error("look_at and look_from are the same point"));
    }
    if view.length() < SMALLEST {
        let message = format!("look_at is nearer than {SMALLEST:e} to look_from");
        return Err(at.field("look_at").error(message));
    }
    if camera.up.length() < SMALLEST {
        return Err(at.field("up").error("up has no length: expected a direction such as (0, 1, 0)"));
    }
    if parallel(view, camera.up) {
        let DVec3 { x, y, z } = camera.up;
        let message = format!(
            "up ({x}, {y}, {z}) is parallel to the view: expected another direction, such as {}",
            if x == 0.0 && z == 0.0 { "up: (0, 0, 1)" } else { "up: (0, 1, 0)" }
        );
        return Err(at.field("up").error(message));
    }
    let fov = camera.vertical_fov;
    if !(fov > 0.0 && fov < 180.0) {
        return Err(at.field("vertical_fov").unexpected("a vertical_fov between 0 and 180 degrees"));
    }
    if camera.aperture != 0.0 {
        length(&at.field("aperture"), "an aperture of 0 or", camera.aperture)?;
    }
    match camera.focus_distance {
        Some(distance) => length(&at.field("focus_distance"), "a focus_distance", distance),
        None => Ok(()),
    }
}

fn background(at: &Place, background: &Background) -> Result<()> {
    match background {
        Background::Solid(c) => Use::Radiance.check(&at.variant("Solid"), *c),
        Background::Gradient { bottom, top } => {
            let at = at.variant("Gradient");
            Use::Radiance.check(&at.field("bottom"), *bottom)?;
            Use::Radiance.check(&at.field("top"), *top)
        }
        Background::Image { .. } => Ok(()),
    }
}

/// How far the transforms around an object can move and stretch it: x becomes at most `scale` x + `shift`.
#[derive(Clone, Copy)]
struct Reach {
    scale: f64,
    shift: f64,
}

impl Reach {
    const IDENTITY: Reach = Reach { scale: 1.0, shift: 0.0 };

    /// The reach with one more transform inside all others.
    fn after(self, inner: &Transform) -> Reach {
        match inner {
            Transform::Translate(by) => Reach { shift: self.shift + self.scale * by.length(), ..self },
            Transform::Scale(factor) => Reach { scale: self.scale * factor, ..self },
            _ => self,
        }
    }

    /// Whether something of this size, no part of it farther than `distance` from the origin, keeps in range.
    fn holds(self, size: f64, distance: f64) -> bool {
        let distance = self.scale * distance + self.shift;
        self.scale * size >= SMALLEST && distance <= LARGEST
    }
}

const OUT_OF_REACH: &str = "the transforms around this place take it out of the range of numbers, \
                            1e-100 to 1e100";

fn object(known: &Known, at: &Place, object: &Object, reach: Reach) -> Result<()> {
    let at = &at.variant(object.name());
    match object {
        Object::Sphere { .. } | Object::Quad { .. } | Object::Box { .. } | Object::Mesh { .. } => {
            shape(known, at, object, reach)?;
            known.check_material(at, object)
        }
        Object::Transformed { by, object: inner } => {
            let reach = transforms(&at.field("by"), by, reach)?;
            self::object(known, &at.field("object"), inner, reach)
        }
        Object::Group(objects) => objects
            .iter()
            .enumerate()
            .try_for_each(|(index, inner)| self::object(known, &at.index(index), inner, reach)),
        Object::Medium { boundary, density, albedo, anisotropy } => {
            self::boundary(known, &at.field("boundary"), boundary, reach)?;
            if *density != 0.0 {
                length(&at.field("density"), "a density of 0 or", *density)?;
            }
            if albedo.image().is_some() {
                let message = "there are no texture coordinates inside a medium: expected Rgb(..), Checker(..), \
                               Noise(..) or Marble(..)";
                return Err(at.field("albedo").error(message));
            }
            albedo.check(&at.field("albedo"), Use::Albedo)?;
            if !(*anisotropy > -1.0 && *anisotropy < 1.0) {
                return Err(at.field("anisotropy").unexpected("an anisotropy between -1 and 1, without these"));
            }
            Ok(())
        }
    }
}

/// Checks the numbers of an object that is a shape, but not its material. Of a mesh, once it is read.
fn shape(known: &Known, at: &Place, object: &Object, reach: Reach) -> Result<()> {
    let (size, distance) = match object {
        Object::Sphere { center, radius, .. } => {
            vector(&at.field("center"), *center)?;
            length(&at.field("radius"), "a radius", *radius)?;
            (*radius, center.length() + radius)
        }
        Object::Quad { corner, u, v, .. } => {
            vector(&at.field("corner"), *corner)?;
            edges(at, *u, *v)?;
            (u.length().min(v.length()), corner.length() + u.length() + v.length())
        }
        Object::Box { min, max, .. } => {
            sides(at, *min, *max)?;
            ((max - min).min_element(), min.length().max(max.length()))
        }
        Object::Mesh { path, .. } => {
            let Some(mesh) = known.meshes.get(path) else { return Ok(()) };
            let (low, high) = mesh.bounds();
            ((high - low).max_element(), low.abs().max(high.abs()).length())
        }
        Object::Transformed { .. } | Object::Group(_) | Object::Medium { .. } => return Ok(()),
    };
    if !reach.holds(size, distance) {
        return Err(at.error(OUT_OF_REACH));
    }
    Ok(())
}

/// Checks what a medium fills.
fn boundary(known: &Known, at: &Place, object: &Object, reach: Reach) -> Result<()> {
    let inside = &at.variant(object.name());
    match object {
        Object::Sphere { .. } | Object::Box { .. } | Object::Mesh { .. } => shape(known, inside, object, reach)?,
        Object::Transformed { by, object } => {
            let reach = transforms(&inside.field("by"), by, reach)?;
            return boundary(known, &inside.field("object"), object, reach);
        }
        Object::Quad { .. } | Object::Group(_) | Object::Medium { .. } => {
            let boundary = "a boundary: a Sphere, a Box or a closed Mesh, Transformed or not, without a material";
            return Err(at.unexpected(boundary));
        }
    }
    if object.material().is_some() {
        let message = "a medium's boundary has no surface, and so no material: remove it, or list the object beside the \
                       medium too";
        return Err(inside.field("material").error(message));
    }
    match object {
        Object::Mesh { path, .. } => known.check_closed(&inside.field("path"), path),
        _ => Ok(()),
    }
}

fn edges(at: &Place, u: DVec3, v: DVec3) -> Result<()> {
    for (name, edge) in [("u", u), ("v", v)] {
        vector(&at.field(name), edge)?;
        if edge.length() < SMALLEST {
            return Err(at.field(name).error(format!("the quad has no extent along {name}")));
        }
    }
    if parallel(u, v) {
        return Err(at.error("the quad has no area: u and v are parallel"));
    }
    Ok(())
}

fn sides(at: &Place, min: DVec3, max: DVec3) -> Result<()> {
    vector(&at.field("min"), min)?;
    vector(&at.field("max"), max)?;
    for (axis, (low, high)) in ["x", "y", "z"].into_iter().zip(min.to_array().into_iter().zip(max.to_array())) {
        if high - low < SMALLEST {
            let message =
                format!("the box has no extent along {axis}: expected min below max, found {low:?} and {high:?}");
            return Err(at.error(message));
        }
    }
    Ok(())
}

/// Checks a list of transforms and adds them to what is around them: the last listed is the outermost.
fn transforms(at: &Place, by: &[Transform], mut reach: Reach) -> Result<Reach> {
    for (index, transform) in by.iter().enumerate().rev() {
        let at = at.index(index);
        match transform {
            Transform::Translate(by) => vector(&at.variant("Translate"), *by)?,
            Transform::Scale(s) => length(&at.variant("Scale"), "a scale", *s)?,
            Transform::RotateX(angle) => number(&at.variant("RotateX"), *angle)?,
            Transform::RotateY(angle) => number(&at.variant("RotateY"), *angle)?,
            Transform::RotateZ(angle) => number(&at.variant("RotateZ"), *angle)?,
            Transform::Rotate { axis, degrees } => {
                let at = at.variant("Rotate");
                vector(&at.field("axis"), *axis)?;
                if axis.length() < SMALLEST {
                    return Err(at.field("axis").error("the axis has no length"));
                }
                number(&at.field("degrees"), *degrees)?;
            }
        }
        reach = reach.after(transform);
        if !(SMALLEST..=LARGEST).contains(&reach.scale) || reach.shift > LARGEST {
            return Err(at.error(OUT_OF_REACH));
        }
    }
    Ok(reach)
}

/// What objects may name.
struct Known<'a> {
    all: &'a [(String, Material)],
    /// The same materials, found in constant time.
    materials: HashMap<&'a str, &'a Material>,
    /// The meshes that have been read: none before all else is checked.
    meshes: &'a BTreeMap<String, Mesh>,
    /// The paths of those that are known to be closed.
    closed: RefCell<HashSet<&'a str>>,
}

impl<'a> Known<'a> {
    /// Checks that the object has a material, that it exists, and that it can be put on the object.
    fn check_material(&self, at: &Place, object: &Object) -> Result<()> {
        let names = || self.all.iter().map(|(name, _)| name.as_str());
        let at = at.field("material");
        let Some(name) = object.material() else {
            return Err(at.error(format!("material is missing: {}", known(names()))));
        };
        let Some(material) = self.materials.get(name) else {
            let meant = nearest(name, names());
            let meant = meant.map_or(String::new(), |meant| format!("; did you mean {meant:?}?"));
            return Err(at.error(format!("there is no material {name:?}: {}{meant}", known(names()))));
        };
        if let Object::Mesh { path, .. } = object
            && self.meshes.get(path).is_some_and(|mesh| mesh.uvs.is_empty())
            && material.textures().iter().any(|texture| texture.image().is_some())
        {
            let message = format!(
                "the material {name:?} has an image, and the mesh {path:?} has no texture coordinates to place it by: \
                 expected a mesh that has them at every corner, or another texture"
            );
            return Err(at.error(message));
        }
        Ok(())
    }

    /// Checks that a mesh, once it is read, bounds a body.
    fn check_closed(&self, at: &Place, path: &str) -> Result<()> {
        let Some((path, mesh)) = self.meshes.get_key_value(path) else { return Ok(()) };
        if self.closed.borrow().contains(path.as_str()) {
            return Ok(());
        }
        if let Some(open) = mesh.open_edges() {
            let edges = if open.count == 1 { "edge" } else { "edges" };
            return Err(at.error(format!(
                "{path}: expected a closed mesh, wound one way, as a medium's boundary: face {} (counted from 0) has an \
                 edge that no neighbour runs along the other way; there are {} such {edges}",
                open.face, open.count
            )));
        }
        self.closed.borrow_mut().insert(path);
        Ok(())
    }
}

/// The names to choose from, but not a page of them.
fn known<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 10;
    let mut names: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    if names.is_empty() {
        return "the scene defines no materials".to_owned();
    }
    if names.len() > MOST {
        let more = format!("{} more", names.len() - MOST);
        names.truncate(MOST);
        names.push(more);
    }
    format!("expected one of {}", names.join(", "))
}

fn render(at: &Place, render: &RenderDefaults) -> Result<()> {
    if !(1..=MOST_SAMPLES).contains(&render.samples) {
        return Err(at.field("samples").unexpected(format!("from 1 to {MOST_SAMPLES} samples")));
    }
    if render.max_depth > DEEPEST {
        return Err(at.field("max_depth").unexpected(format!("a max_depth from 0 to {DEEPEST}")));
    }
    Ok(())
}

/// Whether two directions are parallel, whatever their lengths.
fn parallel(a: DVec3, b: DVec3) -> bool {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    unit(a).cross(unit(b)).length() < SMALLEST_SINE
}
