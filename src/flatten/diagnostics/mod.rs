//! Where the numbers of a placed scene are dangerous: allowed, and yet too small, too large or too close for f32.
//!
//! It is found while a scene is flattened, in time n log n at most, and told one of a kind: the worst in full, and how many
//! more there are. Lengths are in the world's units, places are seen from the camera and have the axes of render space.

mod coincident;
mod emitters;
mod leaving;
mod repeated;
mod same_place;
mod sizes;
mod surfaces;
mod within;

use std::collections::BTreeMap;

use glam::DVec3;

use super::place::{Aabb, Placed, PlacedMedium, Shape};
use super::similarity::Similarity;
use super::view::View;
use crate::scene::{Bitmaps, Material, Object, Scene};
use coincident::Planes;
use emitters::Walls;
use same_place::SamePlace;
use sizes::Sizes;
use surfaces::Surfaces;

/// What is known of a scene when its objects have been placed.
pub struct Found<'a> {
    pub scene: &'a Scene,
    pub placed: &'a [Placed],
    pub media: &'a [PlacedMedium<'a>],
    pub boxes: &'a [Aabb],
    pub view: &'a View<'a>,
    /// The farthest that anything reaches from the camera along an axis.
    pub extent: f64,
    /// The largest component of what materials emit that something is made of, by their numbers, and of the background.
    pub emissions: &'a [(Option<usize>, f64)],
}

/// The warnings about a placed scene.
pub fn warnings(found: &Found) -> Vec<String> {
    let kinds: Vec<Kind> =
        found.scene.materials.iter().map(|(_, material)| Kind::of(material, &found.scene.bitmaps)).collect();
    let mut sizes = Sizes::new(found);
    let mut surfaces = Surfaces::new(found);
    let mut same_place = SamePlace::new(found, &kinds);
    let mut planes = Planes::new(found, &kinds);
    let mut walls = Walls::new(found, &kinds);
    // All in one go: what it takes is mostly the way through memory.
    for (number, placed) in found.placed.iter().enumerate() {
        let body = Body::new(found, &placed.shape, &placed.to_world);
        let kind = kinds[placed.material as usize];
        sizes.see(number, &body, kind);
        surfaces.see(number, &body);
        same_place.see(number, &body);
        planes.see(number, &body);
        walls.see(number, &body, kind);
    }
    let mut diagnostics = sizes.diagnostics();
    diagnostics.extend(surfaces.diagnostics());
    diagnostics.extend(same_place.diagnostics());
    diagnostics.extend(planes.diagnostics());
    diagnostics.extend(emitters::turned_away(found, &kinds));
    diagnostics.extend(walls.diagnostics());
    diagnostics.extend(emitters::too_faint(found));
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

/// Stands in a message where the place of the other object is to be filled in.
const OTHER: &str = "{other}";

/// Half a unit in the last place of 1 in f32: the largest relative error of a rounding.
const U: f64 = 1.0 / (1u64 << 24) as f64;

/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum At {
    /// By its place among what is placed.
    Primitive(usize),
    Medium(usize),
    /// The value that the material of this number emits.
    Emit(usize),
    Background,
}

/// A warning before its places in the file are known.
struct Diagnostic {
    at: At,
    /// Of the object, or "" for the object itself.
    field: &'static str,
    message: String,
    /// The object whose place stands for `OTHER` in the message.
    other: Option<At>,
    /// How many more there are of its kind.
    more: usize,
}

/// How often something was found, and the worst of it; of equals, the first.
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

    /// The warning about the worst, which `tell` words.
    fn diagnostic(self, tell: impl FnOnce(T) -> Diagnostic) -> Option<Diagnostic> {
        let more = self.count.saturating_sub(1);
        self.worst.map(|(_, of)| Diagnostic { more, ..tell(of) })
    }
}

/// Where something stands in the scene file, and its path there.
#[derive(Clone, Debug, Default)]
struct Spot {
    location: String,
    path: String,
}

/// Finds the places of what is wanted by one more walk over the scene.
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
            At::Primitive(_) | At::Medium(_) => {}
        }
    }
    // Counted as `Finder` does.
    let (mut primitives, mut media) = (0, 0);
    scene.visit_objects(&mut |place, object| {
        let at = match object {
            Object::Medium { density, .. } if *density > 0.0 => {
                media += 1;
                At::Medium(media - 1)
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

/// Something placed, as seen from the camera.
#[derive(Clone, Copy)]
struct Body<'a> {
    shape: &'a Shape,
    to_world: &'a Similarity,
    /// The middle of a sphere, box or mesh; the corner of a quad.
    place: DVec3,
}

impl<'a> Body<'a> {
    fn new(found: &Found, shape: &'a Shape, to_world: &'a Similarity) -> Body<'a> {
        let point = match *shape {
            Shape::Sphere { center, .. } => center,
            Shape::Quad { corner, .. } => corner,
            Shape::Cuboid { min, max } => 0.5 * (min + max),
            Shape::Mesh(mesh) => found.boxes[mesh].center(),
        };
        Body { shape, to_world, place: to_world.point(point) - found.view.eye }
    }

    /// The edges of a quad.
    fn edges(&self, u: DVec3, v: DVec3) -> (DVec3, DVec3) {
        (self.to_world.vector(u), self.to_world.vector(v))
    }

    /// Half the sides of a box or of the box around a mesh, along its own axes; nothing for others.
    fn half_sides(&self, found: &Found) -> Option<DVec3> {
        let (min, max) = match *self.shape {
            Shape::Cuboid { min, max } => (min, max),
            Shape::Mesh(mesh) => (found.boxes[mesh].min, found.boxes[mesh].max),
            Shape::Sphere { .. } | Shape::Quad { .. } => return None,
        };
        Some(0.5 * self.to_world.scale * (max - min))
    }

    /// The middle of a ball around it, and the ball's radius.
    fn ball(&self, found: &Found) -> (DVec3, f64) {
        match *self.shape {
            Shape::Sphere { radius, .. } => (self.place, self.to_world.scale * radius),
            Shape::Quad { u, v, .. } => {
                let (u, v) = self.edges(u, v);
                (self.place + 0.5 * (u + v), 0.5 * (u + v).length().max((u - v).length()))
            }
            _ => (self.place, self.half_sides(found).map_or(0.0, |half| half.length())),
        }
    }

    /// The lowest and the highest coordinates that it reaches.
    fn bounds(&self, found: &Found) -> (DVec3, DVec3) {
        let (center, reach) = match *self.shape {
            Shape::Sphere { radius, .. } => (self.place, DVec3::splat(self.to_world.scale * radius)),
            Shape::Quad { u, v, .. } => {
                let (u, v) = self.edges(u, v);
                (self.place + 0.5 * (u + v), 0.5 * (u.abs() + v.abs()))
            }
            _ => {
                let half = self.half_sides(found).unwrap_or_default();
                let axes = self.to_world.rotation;
                (self.place, half.x * axes.x_axis.abs() + half.y * axes.y_axis.abs() + half.z * axes.z_axis.abs())
            }
        };
        (center - reach, center + reach)
    }

    /// Corners of what holds it: of the parallelogram, or of the box; nothing for a sphere.
    fn corners(&self, found: &Found) -> Vec<DVec3> {
        match *self.shape {
            Shape::Sphere { .. } => Vec::new(),
            Shape::Quad { u, v, .. } => {
                let (u, v) = self.edges(u, v);
                vec![self.place, self.place + u, self.place + u + v, self.place + v]
            }
            _ => {
                let half = self.half_sides(found).unwrap_or_default();
                let sign = |i: usize, axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
                let corner =
                    |i| self.place + self.to_world.rotation * (half * DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2)));
                (0..8).map(corner).collect()
            }
        }
    }
}

/// The unit normal of a parallelogram, however large or small its edges are.
fn normal(u: DVec3, v: DVec3) -> DVec3 {
    u.normalize_or_zero().cross(v.normalize_or_zero()).normalize_or_zero()
}

/// The kind of a shape in words.
fn name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Quad { .. } => "quad",
        Shape::Cuboid { .. } => "box",
        Shape::Mesh(_) => "mesh",
    }
}

/// What of a material matters here.
#[derive(Clone, Copy, Default)]
struct Kind {
    glass: bool,
    light: bool,
    one_sided: bool,
}

impl Kind {
    fn of(material: &Material, bitmaps: &Bitmaps) -> Kind {
        let emission = material.model().emission();
        Kind {
            glass: material.kind().is_clear,
            light: emission.is_some_and(|emission| emission.slot.texture.brightest(bitmaps) > 0.0),
            one_sided: emission.is_some_and(|emission| !emission.two_sided),
        }
    }
}

const BY_ROUNDING: &str = "which is seen is left to rounding, and to their order in the file where that ties";

/// After the place of another surface: how far from it one is, by a gap that is less than a bound of rounding, or of where rays start.
fn apart(gap: f64, bound: f64, clear: bool) -> String {
    // Less is what f64 left of transforms.
    if gap <= 1e-3 * bound {
        return " and coincides with it".to_string();
    }
    let what = if clear { "where rays start that leave it" } else { "what f32 rounds by there" };
    format!(" and is {} off, less than {what}, {}", short(gap), short(bound))
}

/// A number to four digits, as one would write it.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    match rounded.abs() {
        0.0 => "0".to_string(),
        1e-3..1e6 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// As a power of two, rounded.
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
