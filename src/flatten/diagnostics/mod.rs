//! Where the numbers of a placed scene are dangerous: allowed, and yet too small, too large or too close for f32.
//!
//! It is found while a scene is flattened, in time n log n at most, and told one of a kind: the worst in full, and how many
//! more there are. Lengths are in the world's units, places are seen from the camera and have the axes of render space.

mod coincident;
mod emitters;
mod leaving;
mod same_place;
mod sizes;
mod surfaces;
mod within;

use std::collections::BTreeMap;

use glam::DVec3;

use super::place::{Placed, PlacedMedium};
use super::view::View;
use crate::scene::{Bitmaps, Material, Object, Scene};
use crate::shape::similarity::Similarity;
use crate::shape::{Hull, Placement, RenderSpace, Shape};
use coincident::Planes;
use emitters::Walls;
use same_place::SamePlace;
use sizes::Sizes;
use surfaces::Surfaces;

/// What is known of a scene when its objects have been placed.
pub struct Found<'a> {
    pub scene: &'a Scene,
    pub placed: &'a [Placed<'a>],
    pub media: &'a [PlacedMedium<'a>],
    pub view: &'a View<'a>,
    /// The farthest that anything reaches from the camera along an axis.
    pub extent: f64,
    /// The largest component of what materials emit that something is made of, by their numbers, and of the background.
    pub emissions: &'a [(Option<usize>, f64)],
}

/// The warnings about a placed scene.
pub fn warnings(found: &Found) -> Vec<String> {
    let kinds: Vec<Role> =
        found.scene.materials.iter().map(|(_, material)| Role::of(material, &found.scene.bitmaps)).collect();
    let mut sizes = Sizes::new(found);
    let mut surfaces = Surfaces::default();
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

impl Diagnostic {
    fn of(at: At, field: &'static str, message: String) -> Diagnostic {
        Diagnostic { at, field, message, other: None, more: 0 }
    }

    /// Of an object and another one, whose place stands for `OTHER`.
    fn of_two(number: usize, other: usize, message: String) -> Diagnostic {
        Diagnostic { other: Some(At::Primitive(other)), ..Diagnostic::of(At::Primitive(number), "", message) }
    }
}

/// Two objects that coincide, the first in the file first.
struct Pair {
    first: usize,
    second: usize,
    gap: f64,
    /// From this gap on all is well.
    bound: f64,
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
    shape: &'a Shape<'a>,
    to_world: &'a Similarity,
    hull: Hull,
    /// The middle of a sphere, box or mesh; the corner of a quad.
    place: DVec3,
}

impl<'a> Body<'a> {
    fn new(found: &Found, shape: &'a Shape<'a>, to_world: &'a Similarity) -> Body<'a> {
        let hull = shape.hull(&Placement { to_world, space: RenderSpace { eye: found.view.eye, scale: 1.0 } });
        Body { shape, to_world, hull, place: hull.place() }
    }

    /// Half the sides of a box or of the box around a mesh, along its own axes; nothing for others.
    fn half_sides(&self) -> Option<DVec3> {
        match self.hull {
            Hull::Cuboid { half, .. } => Some(half),
            Hull::Ball { .. } | Hull::Parallelogram { .. } => None,
        }
    }
}

/// What of a material matters here.
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
