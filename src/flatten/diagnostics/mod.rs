//! Warnings about a placed scene: numbers that are allowed, but too small, too large or too close together for f32.
//!
//! The search runs while a scene is flattened, in O(n log n). It prints one warning of each kind: the worst case, and the number of
//! the others. Lengths are in the world's units. Positions are relative to the camera, along the axes of render space.

mod coincident;
mod emitters;
mod leaving;
mod near_lights;
mod patterns;
mod same_place;
mod sizes;
mod within;

use std::collections::BTreeMap;

use glam::DVec3;

use super::place::{Placed, PlacedMedium};
use super::view::View;
use crate::delta_light::PlacedLight;
use crate::scene::{Bitmaps, Material, Object, Scene};
use crate::shape::similarity::Similarity;
use crate::shape::{Hull, Placement, RenderSpace, Shape};
use coincident::Planes;
use emitters::Walls;
use same_place::SamePlace;
use sizes::Sizes;

/// A scene after its objects have been placed.
pub struct Found<'a> {
    pub scene: &'a Scene,
    pub placed: &'a [Placed<'a>],
    pub media: &'a [PlacedMedium<'a>],
    pub lights: &'a [(&'a Object, PlacedLight)],
    pub view: &'a View<'a>,
    /// The largest distance from the camera, along an axis, that any object reaches.
    pub extent: f64,
    /// The largest component of the radiance that each material that an object has emits, the background, and what is lit by lights
    /// without size.
    pub emissions: &'a [(At, f64)],
}

/// The warnings about a placed scene.
pub fn warnings(found: &Found) -> Vec<String> {
    let kinds: Vec<Role> =
        found.scene.materials.iter().map(|(_, material)| Role::of(material, &found.scene.bitmaps)).collect();
    let mut sizes = Sizes::new(found);
    let mut same_place = SamePlace::new(found, &kinds);
    let mut planes = Planes::new(found, &kinds);
    let mut walls = Walls::new(found, &kinds);
    // One loop over all objects for all searches: most of the time is spent on reading memory.
    for (number, placed) in found.placed.iter().enumerate() {
        let body = Body::new(found, &placed.shape, &placed.to_world);
        let kind = kinds[placed.material as usize];
        sizes.see(number, &body, kind);
        same_place.see(number, &body);
        planes.see(number, &body);
        walls.see(number, &body, kind);
    }
    let mut diagnostics = sizes.diagnostics();
    diagnostics.extend(same_place.diagnostics());
    diagnostics.extend(planes.diagnostics());
    diagnostics.extend(emitters::turned_away(found, &kinds));
    diagnostics.extend(walls.diagnostics());
    diagnostics.extend(emitters::too_faint(found));
    diagnostics.extend(near_lights::diagnostics(found, &kinds));
    diagnostics.extend(patterns::diagnostics(found));
    if diagnostics.is_empty() {
        return Vec::new();
    }
    let wanted = diagnostics
        .iter()
        .flat_map(|diagnostic| [Some((diagnostic.at, diagnostic.field)), diagnostic.other.map(|at| (at, ""))]);
    let places = places(found.scene, wanted.flatten());
    let place = |at: At, field| places.get(&(at, field)).cloned().unwrap_or_default();
    let told = diagnostics.iter().map(|diagnostic| {
        let Spot { location, path } = place(diagnostic.at, diagnostic.field);
        let other = diagnostic.other.map_or(String::new(), |at| place(at, "").location);
        let more = match diagnostic.more {
            0 => String::new(),
            1 => " (and 1 more like it)".to_string(),
            n => format!(" (and {n} more like it)"),
        };
        format!("{location}: {path}: {}{more}", diagnostic.message.replace(OTHER, &other))
    });
    told.collect()
}

/// A placeholder in messages for the location of the other object.
const OTHER: &str = "{other}";

/// Half a unit in the last place of 1 in f32: the largest relative error of a rounding.
const U: f64 = 1.0 / (1u64 << 24) as f64;

/// The subject of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum At {
    /// By its index among the placed objects.
    Primitive(usize),
    Medium(usize),
    /// The emission of the material of this number.
    Emit(usize),
    Background,
    /// A light without size, by its number.
    Light(usize),
}

/// A warning whose locations in the file are not yet filled in.
struct Diagnostic {
    at: At,
    /// A field of the object, or "" for the object itself.
    field: &'static str,
    message: String,
    /// The object whose location replaces `OTHER` in the message.
    other: Option<At>,
    /// The number of further cases of the same kind.
    more: usize,
}

impl Diagnostic {
    fn of(at: At, field: &'static str, message: String) -> Diagnostic {
        Diagnostic { at, field, message, other: None, more: 0 }
    }

    /// A warning about an object; the location of the other one replaces `OTHER` in the message.
    fn of_two(number: usize, other: usize, message: String) -> Diagnostic {
        Diagnostic { other: Some(At::Primitive(other)), ..Diagnostic::of(At::Primitive(number), "", message) }
    }
}

/// Two objects that coincide, in the order of the file.
struct Pair {
    first: usize,
    second: usize,
    gap: f64,
    /// A larger gap causes no warning.
    bound: f64,
}

/// The number of cases found, and the worst of them; the first of equally bad ones.
struct Worst<T> {
    count: usize,
    worst: Option<(f64, T)>,
}

impl<T> Default for Worst<T> {
    fn default() -> Self {
        Worst { count: 0, worst: None }
    }
}

impl<T> Worst<T> {
    fn note(&mut self, badness: f64, of: T) {
        self.count += 1;
        if self.worst.as_ref().is_none_or(|(worst, _)| badness > *worst) {
            self.worst = Some((badness, of));
        }
    }

    /// The warning about the worst case, in the words of `tell`.
    fn diagnostic(self, tell: impl FnOnce(T) -> Diagnostic) -> Option<Diagnostic> {
        let more = self.count.saturating_sub(1);
        self.worst.map(|(_, of)| Diagnostic { more, ..tell(of) })
    }
}

/// A location in the scene file, and the path of the value there.
#[derive(Clone, Debug, Default)]
struct Spot {
    location: String,
    path: String,
}

/// Finds the locations of the wanted values in one more walk over the scene.
fn places(scene: &Scene, wanted: impl Iterator<Item = (At, &'static str)>) -> BTreeMap<(At, &'static str), Spot> {
    let mut places: BTreeMap<(At, &'static str), Spot> = wanted.map(|key| (key, Spot::default())).collect();
    let spot = |(location, path): (crate::error::Location, String)| Spot { location: location.to_string(), path };
    for ((at, _), found) in &mut places {
        match *at {
            At::Emit(number) => {
                if let Some((name, material)) = scene.materials.get(number) {
                    *found = spot(scene.spot_of_emission(name, material));
                }
            }
            At::Background => *found = spot(scene.spot_of_background()),
            At::Primitive(_) | At::Medium(_) | At::Light(_) => {}
        }
    }
    // Objects are numbered in the order of this walk, as `Finder` does.
    let (mut primitives, mut media, mut lights) = (0, 0, 0);
    scene.visit_objects(&mut |place, object| {
        let at = match object {
            Object::Medium { density, .. } if *density > 0.0 => {
                media += 1;
                At::Medium(media - 1)
            }
            _ if object.delta_light().is_some() => {
                lights += 1;
                At::Light(lights - 1)
            }
            _ if object.material().is_some() => {
                primitives += 1;
                At::Primitive(primitives - 1)
            }
            _ => return,
        };
        for (&(_, field), found) in places.range_mut((at, "")..=(at, "~")) {
            *found = spot(if field.is_empty() { place.spot() } else { place.field(field).spot() });
        }
    });
    places
}

/// A placed object, relative to the camera.
#[derive(Clone, Copy)]
struct Body<'a> {
    shape: &'a Shape<'a>,
    to_world: &'a Similarity,
    hull: Hull,
    /// The centre of a sphere, box or mesh; the corner of a quad.
    place: DVec3,
}

impl<'a> Body<'a> {
    fn new(found: &Found, shape: &'a Shape<'a>, to_world: &'a Similarity) -> Body<'a> {
        let hull = shape.hull(&Placement { to_world, space: RenderSpace { eye: found.view.eye, scale: 1.0 } });
        Body { shape, to_world, hull, place: hull.place() }
    }

    /// The half sides of a box, or of the box around a mesh, along its own axes; none for other shapes.
    fn half_sides(&self) -> Option<DVec3> {
        match self.hull {
            Hull::Cuboid { half, .. } => Some(half),
            Hull::Ball { .. } | Hull::Parallelogram { .. } => None,
        }
    }
}

/// The properties of a material that matter here.
#[derive(Clone, Copy, Default)]
struct Role {
    glass: bool,
    light: bool,
    one_sided: bool,
}

impl Role {
    fn of(material: &Material, bitmaps: &Bitmaps) -> Role {
        let emission = material.model().emission();
        Role {
            glass: material.kind().is_transmissive,
            light: emission.is_some_and(|emission| emission.slot.texture.brightest(bitmaps) > 0.0),
            one_sided: emission.is_some_and(|emission| !emission.two_sided),
        }
    }
}

const BY_ROUNDING: &str =
    "rounding decides which of the two is visible, or their order in the file if the distances are equal";

/// The distance to another surface, in words: a gap below a bound of the rounding, or of the ray offset if one surface is clear.
fn apart(gap: f64, bound: f64, clear: bool) -> String {
    // Smaller gaps come from the rounding of transforms in f64.
    if gap <= 1e-3 * bound {
        return "coincides with it".to_string();
    }
    let what = if clear { "ray offset" } else { "rounding of f32" };
    format!("is {} away, less than the {what} there ({})", short(gap), short(bound))
}

/// A number rounded to four digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_string(),
        1e-3..1e6 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// The nearest power of two.
fn power_of_two(x: f64) -> String {
    format!("2^{}", x.log2().round())
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let cases = [(0.0, "0"), (1e-7, "1e-7"), (0.125, "0.125"), (123456.0, "123500"), (2e7, "2e7"), (-0.5, "-0.5")];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}
