//! Refuses values that parse but are invalid. Every error points at the value's own location.

use std::collections::{BTreeMap, HashMap};
use std::iter;

use glam::DVec3;

use super::declared::{LARGEST_AREA, rotate, scale};
use super::findings::Findings;
use super::light_groups;
use super::model::Scene;
use super::nearest::{meant, one_of};
use super::types::*;
use crate::error::{Result, first};
use crate::shape::mesh::{self, MeshShape};
use crate::shape::{ShapeKind, kinds_in_files};
use crate::source::form::any;
use crate::source::{LARGEST, Range, SMALLEST, Step, ValuePath, parallel};

/// Checks all of the scene, in the order of the format's description, except for the files that it names.
pub fn validate(scene: &Scene, findings: &mut Findings) {
    let top = scene.top();
    image(&top.field("image"), &scene.image, findings);
    camera(&top.field("camera"), &scene.camera, findings);
    findings.record(background(&top.field("background"), &scene.background));
    for (name, value) in &scene.materials {
        findings.record(value.check(&top.field("materials").key(name)));
    }
    objects(scene, findings);
    light_groups::check(scene, findings);
    findings.record_all(scene.render.check_fields(&top.field("render")));
}

/// Checks the objects, and their meshes if these are known.
pub fn objects(scene: &Scene, findings: &mut Findings) {
    let meshes = mesh::shapes(&scene.meshes);
    let known = KnownNames {
        scene,
        materials: scene.materials.iter().map(|(name, material)| (name.as_str(), material)).collect(),
        meshes: &meshes,
        all_are_lost: scene.materials.is_empty() && !findings.is_empty(),
    };
    let top = scene.top();
    for (name, material) in &scene.materials {
        let at = top.field("materials");
        let at = at.key(name);
        findings.record(known.check_parts(&at.variant(material.name()), material));
    }
    for (index, value) in scene.objects.iter().enumerate() {
        object(&known, &top.field("objects").index(index), value, TransformBound::IDENTITY, findings);
    }
}

fn image(at: &ValuePath, image: &ImageSize, findings: &mut Findings) {
    let sides = image.check_fields(at);
    let area = u64::from(image.width) * u64::from(image.height);
    if sides.is_empty() && area > LARGEST_AREA {
        let most = format!("width times height of at most {LARGEST_AREA} pixels");
        findings.refuse(at.error(format!("expected {most}, found {area}")));
    }
    findings.record_all(sides);
}

/// Checks a camera.
pub fn camera(at: &ValuePath, camera: &Camera, findings: &mut Findings) {
    if [camera.look_from, camera.look_at, camera.up].into_iter().all(|v| Range::ANY.check_each(at, "", v).is_ok()) {
        findings.record(directions(at, camera.look_at - camera.look_from, camera.up));
    }
    findings.record_all(camera.check_fields(at));
    findings.record(match (&camera.projection, camera.vertical_fov) {
        (None, None) => Err(at
            .field("vertical_fov")
            .error("vertical_fov is missing: expected an angle in degrees, or another projection in its place")),
        (Some(_), Some(_)) => {
            Err(at.field("vertical_fov").error("vertical_fov is short for a projection: remove one of the two"))
        }
        _ => Ok(()),
    });
    if let Some(projection) = &camera.projection {
        findings.record_all(projection.errors(&at.field("projection")));
        let has_lens = matches!(projection, Projection::Perspective { .. } | Projection::Calibrated { .. });
        if camera.aperture > 0.0 && !has_lens {
            let message =
                format!("a camera with the projection {} has no lens: remove the aperture", projection.name());
            findings.refuse(at.field("aperture").error(message));
        }
    }
    findings.record(shutter(&at.field("shutter"), camera.shutter));
    camera_keys(&at.field("moving"), camera, findings);
}

fn shutter(at: &ValuePath, (open, close): (f64, f64)) -> Result<()> {
    for (index, time) in [open, close].into_iter().enumerate() {
        SECONDS.check(&at.index(index), "time", "seconds", time)?;
    }
    match close < open {
        true => {
            Err(at.error(format!("the shutter closes at {close}, before it opens at {open}: expected (open, close)")))
        }
        false => Ok(()),
    }
}

/// Checks the keys of a moving camera, and that it has a direction all the way between them.
fn camera_keys(at: &ValuePath, camera: &Camera, findings: &mut Findings) {
    findings.record(times(at, &camera.moving));
    let mut last: Option<&CameraKey> = None;
    for (index, (_, key)) in camera.moving.iter().enumerate() {
        let of_key = at.index(index);
        let at = of_key.index(1);
        let errors = key.check_fields(&at);
        let is_valid = errors.is_empty();
        findings.record_all(errors);
        if is_valid && Range::ANY.check_each(&at, "", camera.up).is_ok() {
            findings.record(directions(&at, key.look_at - key.look_from, camera.up).and_then(|()| match last {
                Some(last) => keeps_direction(&at, last, key, camera.up),
                None => Ok(()),
            }));
            last = Some(key);
        }
    }
}

/// Refuses a camera whose view vanishes or becomes parallel to up on the way from one key to the next. The view goes straight.
fn keeps_direction(at: &ValuePath, from: &CameraKey, to: &CameraKey, up: DVec3) -> Result<()> {
    let (start, end) = (from.look_at - from.look_from, to.look_at - to.look_from);
    // Across up, the view must not pass through 0.
    let across = |view: DVec3| view - up * (view.dot(up) / up.length_squared());
    let (start, end) = (across(start), across(end));
    let way = end - start;
    let nearest = if way == DVec3::ZERO { 0.0 } else { (-start.dot(way) / way.length_squared()).clamp(0.0, 1.0) };
    match start.lerp(end, nearest).length() < 1e-6 * start.length().max(end.length()) {
        true => Err(at.error(
            "between this key and the one before, the view becomes parallel to up: add a key, or choose another direction for up",
        )),
        false => Ok(()),
    }
}

/// The range of times.
const SECONDS: Range = Range::from_to(-1e9, 1e9);

/// Checks that the times of keys are numbers that do not decrease.
fn times<T>(at: &ValuePath, keys: &[(f64, T)]) -> Result<()> {
    let mut last = f64::NEG_INFINITY;
    for (index, (time, _)) in keys.iter().enumerate() {
        let of_key = at.index(index);
        let at = of_key.index(0);
        SECONDS.check(&at, "time", "seconds", *time)?;
        if *time < last {
            return Err(at.error(format!("expected keys in the order of their times, found {time} after {last}")));
        }
        last = *time;
    }
    Ok(())
}

fn directions(at: &ValuePath, view: DVec3, up: DVec3) -> Result<()> {
    if view == DVec3::ZERO {
        return Err(at.field("look_at").error("look_at and look_from are the same point"));
    }
    if view.length() < SMALLEST {
        let message = format!("look_at is nearer than {SMALLEST:e} to look_from");
        return Err(at.field("look_at").error(message));
    }
    if up.length() < SMALLEST {
        return Err(at.field("up").error("up has no length: expected a direction such as (0, 1, 0)"));
    }
    if parallel(view, up) {
        let DVec3 { x, y, z } = up;
        let message = format!(
            "up ({x}, {y}, {z}) is parallel to the view: expected another direction, such as {}",
            if x == 0.0 && z == 0.0 { "up: (0, 0, 1)" } else { "up: (0, 1, 0)" }
        );
        return Err(at.field("up").error(message));
    }
    Ok(())
}

fn background(at: &ValuePath, background: &Background) -> Result<()> {
    match background {
        Background::Solid(c) => Use::Radiance.check(&at.variant("Solid"), *c),
        Background::Gradient { bottom, top } => {
            let at = at.variant("Gradient");
            Use::Radiance.check(&at.field("bottom"), *bottom)?;
            Use::Radiance.check(&at.field("top"), *top)
        }
        Background::Image { tint, by, .. } => {
            let at = at.variant("Image");
            Use::Radiance.check(&at.field("tint"), *tint)?;
            let at = at.field("by");
            for (index, turn) in by.iter().enumerate() {
                let at = at.index(index);
                if let Transform::Scale(_) | Transform::Translate(_) = turn {
                    return Err(at.error("a sky has no size and no place: expected a rotation such as RotateY(90)"));
                }
                transform(&at, turn)?;
            }
            Ok(())
        }
    }
}

/// A bound of the transforms around an object, at all times: they take a distance x from the origin to at most `scale` x + `shift`, and
/// a size to at least `least_scale` times it.
#[derive(Clone, Copy)]
struct TransformBound {
    scale: f64,
    least_scale: f64,
    shift: f64,
}

impl TransformBound {
    const IDENTITY: TransformBound = TransformBound { scale: 1.0, least_scale: 1.0, shift: 0.0 };

    /// The bound with one more transform, inside all others.
    fn after(self, inner: &Transform) -> TransformBound {
        match inner {
            Transform::Translate(by) => TransformBound { shift: self.shift + self.scale * by.length(), ..self },
            Transform::Scale(factor) => {
                TransformBound { scale: self.scale * factor, least_scale: self.least_scale * factor, ..self }
            }
            _ => self,
        }
    }

    /// Whether a shape of this size, with no part farther than `distance` from the origin, stays in the range of numbers.
    fn holds(self, size: f64, distance: f64) -> bool {
        let distance = self.scale * distance + self.shift;
        self.least_scale * size >= SMALLEST && distance <= LARGEST
    }

    /// The bound of this one and of another.
    fn union(self, other: TransformBound) -> TransformBound {
        TransformBound {
            scale: self.scale.max(other.scale),
            least_scale: self.least_scale.min(other.least_scale),
            shift: self.shift.max(other.shift),
        }
    }
}

const OUT_OF_RANGE: &str = "the transforms around this place take it out of the range of numbers, \
                            1e-100 to 1e100";

fn object(known: &KnownNames, at: &ValuePath, object: &Object, bound: TransformBound, findings: &mut Findings) {
    if findings.is_full() {
        return;
    }
    let at = &at.variant(object.name());
    if let Some((inner, bound)) = inside(at, object, bound, findings) {
        return self::object(known, &at.field("object"), inner, bound, findings);
    }
    match object {
        Object::Group(objects) | Object::Gltf { objects, .. } => {
            findings.record_all(object.check_fields(at));
            for (index, inner) in objects.iter().enumerate() {
                self::object(known, &at.index(index), inner, bound, findings);
            }
        }
        Object::Medium { boundary, density, albedo, .. } => {
            match boundary {
                Some(boundary) => self::boundary(known, &at.field("boundary"), boundary, bound, findings),
                None if density.grid().is_some() => {}
                None => {
                    let message = "boundary is missing: only a density that is a Grid(..) has a box of its own";
                    findings.refuse(at.field("boundary").error(message));
                }
            }
            findings.record(match albedo.needs_uv() {
                true => {
                    let message = "there are no texture coordinates inside a medium: expected Rgb(..), Checker(..), \
                                   Noise(..) or Marble(..)";
                    Err(at.field("albedo").error(message))
                }
                false => albedo.check(&at.field("albedo"), Use::Albedo),
            });
            findings.record_all(object.check_fields(at));
        }
        _ => match object.delta_light() {
            Some(light) => {
                let is_in_range = bound.holds(1.0, light.distance());
                let in_range = || if is_in_range { Ok(()) } else { Err(at.error(OUT_OF_RANGE)) };
                let checked = first(object.check_fields(at)).and_then(|()| light.check(at));
                findings.record(checked.and_then(|()| in_range()));
            }
            None => {
                findings.record(shape(known, at, object, bound));
                findings.record(known.check_material(at, object));
            }
        },
    }
}

/// Checks the numbers of a shape, but not its material. A mesh is checked once its file has been read.
fn shape(known: &KnownNames, at: &ValuePath, object: &Object, bound: TransformBound) -> Result<()> {
    first(object.check_fields(at))?;
    let Some(shape) = object.shape(known.meshes) else { return Ok(()) };
    shape.check(at)?;
    let (size, distance) = shape.span();
    if !bound.holds(size, distance) {
        return Err(at.error(OUT_OF_RANGE));
    }
    Ok(())
}

/// What is inside of an object that is transformed or moves, with the transforms around it, which it checks.
fn inside<'a>(
    at: &ValuePath,
    object: &'a Object,
    bound: TransformBound,
    findings: &mut Findings,
) -> Option<(&'a Object, TransformBound)> {
    match object {
        Object::Transformed { by, object } => Some((object, transforms(&at.field("by"), by, bound, findings))),
        Object::Moving { keys, object } => Some((object, moving(&at.field("keys"), keys, bound, findings))),
        Object::Named { name, object } => {
            let is_bad = name.is_empty() || name.contains(char::is_control);
            let expected = "a name of one line";
            findings.record(if is_bad { Err(at.field("name").unexpected(expected)) } else { Ok(()) });
            Some((object, bound))
        }
        _ => None,
    }
}

/// Checks the boundary of a medium.
fn boundary(known: &KnownNames, at: &ValuePath, object: &Object, bound: TransformBound, findings: &mut Findings) {
    let own = &at.variant(object.name());
    if let Some((inner, bound)) = inside(own, object, bound, findings) {
        return boundary(known, &own.field("object"), inner, bound, findings);
    }
    if object.kind().is_none_or(|kind| kind.boundary.is_none()) {
        findings.refuse(at.unexpected(boundaries("", ", Transformed, Moving or not")));
        return;
    }
    findings.record(shape(known, own, object, bound));
    if object.material().is_some() {
        let message = "a medium's boundary has no surface, and so no material: remove the material, or list the object \
                       outside the medium, too";
        findings.refuse(own.field("material").error(message));
    }
    if let Some(mesh) = object.shape(known.meshes).and_then(|shape| shape.mesh()) {
        findings.record(mesh.check_closed(own));
    }
}

/// "a boundary: a Sphere, a Box or a closed Mesh, Transformed, Moving or not, without a material"
pub fn boundaries(after_each: &str, transformed: &str) -> String {
    let boundary =
        |(name, kind): (_, &ShapeKind)| Some(format!("{} {name}{after_each}", kind.boundary.as_ref()?.words));
    format!("a boundary: {}{transformed}, without a material", any(kinds_in_files().filter_map(boundary)))
}

/// Checks a list of transforms and adds them to those around them. The last in the list is the outermost.
fn transforms(at: &ValuePath, by: &[Transform], mut bound: TransformBound, findings: &mut Findings) -> TransformBound {
    for (index, transform) in by.iter().enumerate().rev() {
        let at = at.index(index);
        if findings.record(self::transform(&at, transform)).is_none() {
            continue;
        }
        let wider = bound.after(transform);
        match wider.least_scale >= SMALLEST && wider.scale <= LARGEST && wider.shift <= LARGEST {
            true => bound = wider,
            false => findings.refuse(at.error(OUT_OF_RANGE)),
        }
    }
    bound
}

/// Checks the keys of what moves and adds them to the transforms around them. Between keys, shifts and factors lie between those of the keys.
fn moving(
    at: &ValuePath,
    keys: &[(f64, Vec<Transform>)],
    bound: TransformBound,
    findings: &mut Findings,
) -> TransformBound {
    findings.record(times(at, keys));
    let Some((_, first)) = keys.first() else {
        findings.refuse(at.error(
            "there is no key: expected a list such as [(0, [Translate((0, 0, 0))]), (1, [Translate((8, 0, 0))])]",
        ));
        return bound;
    };
    let mut all: Option<TransformBound> = None;
    for (index, (_, by)) in keys.iter().enumerate() {
        let of_key = at.index(index);
        let at = of_key.index(1);
        let kinds = |by: &[Transform]| by.iter().map(Transform::name).collect::<Vec<_>>();
        if kinds(by) != kinds(first) {
            findings.refuse(at.error(format!(
                "expected the transforms of the first key, [{}], found [{}]",
                kinds(first).join(", "),
                kinds(by).join(", ")
            )));
        }
        let own = transforms(&at, by, bound, findings);
        all = Some(all.map_or(own, |all| all.union(own)));
    }
    all.unwrap_or(bound)
}

fn transform(at: &ValuePath, transform: &Transform) -> Result<()> {
    let at = at.variant(transform.name());
    match transform {
        Transform::Translate(by) => Range::ANY.check_each(&at, "", *by),
        Transform::Scale(factor) => scale::FIELDS.scale.check_at(&at, *factor),
        Transform::RotateX(angle) | Transform::RotateY(angle) | Transform::RotateZ(angle) => {
            rotate::FIELDS.degrees.check_at(&at, *angle)
        }
        Transform::Rotate { axis, .. } => {
            first(transform.check_fields(&at))?;
            match axis.length() < SMALLEST {
                true => Err(at.field("axis").error("the axis has no length")),
                false => Ok(()),
            }
        }
    }
}

/// The names that objects may refer to.
struct KnownNames<'a> {
    scene: &'a Scene,
    /// Its materials, for lookups in constant time.
    materials: HashMap<&'a str, &'a Material>,
    /// The meshes that have been read. It is empty in the first check, before any file is read.
    meshes: &'a BTreeMap<&'a str, MeshShape<'a>>,
    /// Whether errors have left no material, so that none can be looked for.
    all_are_lost: bool,
}

impl KnownNames<'_> {
    fn names(&self) -> impl Iterator<Item = &str> {
        self.scene.materials.iter().map(|(name, _)| name.as_str())
    }

    fn known(&self) -> String {
        one_of(self.names(), "the scene defines no materials")
    }

    /// The material of a name that stands at a place of the file; nothing if it has errors of its own.
    fn find(&self, at: &ValuePath, name: &str) -> Result<Option<&Material>> {
        let found = self.materials.get(name).copied();
        // A material that has errors is there all the same.
        if found.is_none() && !self.all_are_lost && !self.scene.source.has(&[Step::Field("materials"), Step::Key(name)])
        {
            let meant = meant(name, self.names());
            return Err(at.error(format!("there is no material {name:?}: {}{meant}", self.known())));
        }
        Ok(found)
    }

    /// Checks that the parts of a mix are there, and can be parts.
    fn check_parts(&self, at: &ValuePath, mix: &Material) -> Result<()> {
        for (field, name) in mix.parts() {
            let at = at.field(field);
            if let Some(what) = self.find(&at, name)?.and_then(Material::not_mixed) {
                return Err(at.error(format!("{name:?} cannot be mixed, because it {what}")));
            }
        }
        Ok(())
    }

    /// Checks that the object names a material, that the material exists, and that it fits the object.
    fn check_material(&self, above: &ValuePath, object: &Object) -> Result<()> {
        let at = above.field("material");
        let Some(name) = object.material() else {
            return Err(at.error(format!("material is missing: {}", self.known())));
        };
        let Some(material) = self.find(&at, name)? else { return Ok(()) };
        let parts = material.parts().filter_map(|(_, part)| self.materials.get(part).copied());
        let images = iter::once(material).chain(parts).flat_map(Material::textures);
        let images = images.filter(|texture| texture.needs_uv());
        let Some(uv_set) = images.map(Texture::uv_set).max() else { return Ok(()) };
        if uv_set > 0 && object.kind().is_some_and(|kind| kind.shader != mesh::KIND.shader) {
            return Err(at.error(format!(
                "the material {name:?} has an image with uv_set: {uv_set}, which meshes alone have: expected a Mesh, or an image without it"
            )));
        }
        match object.shape(self.meshes).and_then(|shape| shape.mesh()) {
            Some(mesh) => mesh.check_image(above, name, uv_set),
            None => Ok(()),
        }
    }
}
