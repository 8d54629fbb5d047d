//! Refuses what parses and means nothing: every error at the value's own place.

use std::collections::HashSet;

use glam::DVec3;

use super::Scene;
use super::nearest::nearest;
use super::source::Place;
use super::types::*;
use crate::error::Result;

/// Largest magnitude of a number: its square is still finite in f64, with room for sums.
const LARGEST: f64 = 1e100;
/// Smallest length other than zero: its square is still a normal number.
const SMALLEST: f64 = 1e-100;
/// Largest radiance, and smallest other than zero: both are normal numbers in f32 too.
const LARGEST_RADIANCE: f64 = 1e30;
const SMALLEST_RADIANCE: f64 = 1e-30;
/// Directions whose angle has a sine below this count as parallel.
const SMALLEST_SINE: f64 = 1e-9;
const LARGEST_SIDE: u32 = 1 << 16;
const LARGEST_AREA: u64 = 1 << 30;
const MOST_SAMPLES: u32 = 1 << 31;
const DEEPEST: u32 = 1_000_000;

/// Checks the whole scene but for its images, in the order of the format's description.
pub fn validate(scene: &Scene) -> Result<()> {
    let top = scene.top();
    let materials =
        Materials { all: &scene.materials, names: scene.materials.iter().map(|(name, _)| name.as_str()).collect() };
    image(&top.field("image"), &scene.image)?;
    camera(&top.field("camera"), &scene.camera)?;
    background(&top.field("background"), &scene.background)?;
    for (name, value) in &scene.materials {
        material(&top.field("materials").key(name), value)?;
    }
    for (index, value) in scene.objects.iter().enumerate() {
        object(&materials, &top.field("objects").index(index), value, Reach::IDENTITY)?;
    }
    render(&top.field("render"), &scene.render)
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
        Background::Solid(c) => colour(&at.variant("Solid"), *c, Use::Radiance),
        Background::Gradient { bottom, top } => {
            let at = at.variant("Gradient");
            colour(&at.field("bottom"), *bottom, Use::Radiance)?;
            colour(&at.field("top"), *top, Use::Radiance)
        }
        Background::Image { .. } => Ok(()),
    }
}

fn material(at: &Place, material: &Material) -> Result<()> {
    let at = at.variant(material.name());
    if let Some(slot) = material.texture() {
        texture(&at.field(slot.field), slot.texture, slot.usage)?;
    }
    match material {
        Material::Metal { fuzz, .. } if !(0.0..=1.0).contains(fuzz) => {
            Err(at.field("fuzz").unexpected("a fuzz from 0 to 1"))
        }
        Material::Dielectric { ior } => length(&at.field("ior"), "an ior", *ior),
        _ => Ok(()),
    }
}

fn texture(at: &Place, texture: &Texture, usage: Use) -> Result<()> {
    match texture {
        Texture::Rgb(r, g, b) => colour(&at.variant("Rgb"), DVec3::new(*r, *g, *b), usage),
        Texture::Checker { scale, even, odd } => {
            let at = at.variant("Checker");
            length(&at.field("scale"), "a scale", *scale)?;
            colour(&at.field("even"), *even, usage)?;
            colour(&at.field("odd"), *odd, usage)
        }
        Texture::Image { .. } => Ok(()),
        Texture::Noise { scale } => length(&at.variant("Noise").field("scale"), "a scale", *scale),
        Texture::Marble { scale } => length(&at.variant("Marble").field("scale"), "a scale", *scale),
    }
}

fn colour(at: &Place, colour: Colour, usage: Use) -> Result<()> {
    for (index, channel) in colour.to_array().into_iter().enumerate() {
        let expected = match usage {
            Use::Albedo if !(0.0..=1.0).contains(&channel) => "an albedo from 0 to 1".to_owned(),
            Use::Radiance if channel != 0.0 && !(SMALLEST_RADIANCE..=LARGEST_RADIANCE).contains(&channel) => {
                format!("a radiance of 0 or from {SMALLEST_RADIANCE:e} to {LARGEST_RADIANCE:e}")
            }
            _ => continue,
        };
        return Err(at.index(index).unexpected(expected));
    }
    Ok(())
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

fn object(materials: &Materials, at: &Place, object: &Object, reach: Reach) -> Result<()> {
    let at = &at.variant(object.name());
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
        Object::Transformed { by, object: inner } => {
            let reach = transforms(&at.field("by"), by, reach)?;
            return self::object(materials, &at.field("object"), inner, reach);
        }
        Object::Group(objects) => {
            for (index, inner) in objects.iter().enumerate() {
                self::object(materials, &at.index(index), inner, reach)?;
            }
            return Ok(());
        }
        Object::Mesh { .. } | Object::Medium { .. } => return Err(not_built(at, object)),
    };
    if !reach.holds(size, distance) {
        return Err(at.error(OUT_OF_REACH));
    }
    materials.check(at, object)
}

/// The one place that refuses the objects of the format that gpu-rt cannot render yet.
fn not_built(at: &Place, object: &Object) -> crate::error::Error {
    at.error(format!("{} is not built yet", object.name()))
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

/// The materials that objects may name.
struct Materials<'a> {
    all: &'a [(String, Material)],
    /// The same names, found in constant time.
    names: HashSet<&'a str>,
}

impl Materials<'_> {
    /// Checks that the object has a material and that it exists.
    fn check(&self, at: &Place, object: &Object) -> Result<()> {
        let names = || self.all.iter().map(|(name, _)| name.as_str());
        let message = match object.material() {
            Some(name) if self.names.contains(name) => return Ok(()),
            Some(name) => {
                let meant = nearest(name, names());
                let meant = meant.map_or(String::new(), |meant| format!("; did you mean {meant:?}?"));
                format!("there is no material {name:?}: {}{meant}", known(names()))
            }
            None => format!("material is missing: {}", known(names())),
        };
        Err(at.field("material").error(message))
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

/// Any finite number that may be squared.
fn number(at: &Place, x: f64) -> Result<()> {
    if x.abs() <= LARGEST {
        return Ok(());
    }
    Err(at.unexpected(format!("a finite number of at most {LARGEST:e} in magnitude")))
}

fn vector(at: &Place, v: DVec3) -> Result<()> {
    v.to_array().into_iter().enumerate().try_for_each(|(index, x)| number(&at.index(index), x))
}

/// A positive number that may be squared.
fn length(at: &Place, what: &str, x: f64) -> Result<()> {
    if (SMALLEST..=LARGEST).contains(&x) {
        return Ok(());
    }
    let range = if x > 0.0 { format!("from {SMALLEST:e} to {LARGEST:e}") } else { "greater than 0".to_owned() };
    Err(at.unexpected(format!("{what} {range}")))
}

/// Whether two directions are parallel, whatever their lengths.
fn parallel(a: DVec3, b: DVec3) -> bool {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    unit(a).cross(unit(b)).length() < SMALLEST_SINE
}
