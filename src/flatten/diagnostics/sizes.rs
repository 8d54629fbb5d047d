//! Finds lengths that f32 cannot resolve: shapes that are lost in the rounding of their position, scenes with too large a range of
//! sizes, and media whose mean free path is below the rounding. Also finds media that are so thick that paths end in them.

use std::f64::consts::PI;

use glam::DVec3;

use super::{At, Body, Diagnostic, Found, OTHER, Role, U, Worst, leaving, power_of_two, short};
use crate::flatten::place::{PlacedMedium, reach};
use crate::shape::Hull;

/// The least size of a feature, as a share of its distance: eight roundings of its position. At this size its shape is
/// off by an eighth.
const LEAST_SHARE: f64 = 8.0 * U;
/// The same for a sphere's radius. At this size its outline is off by 2 u / 1e-5, an eightieth of the radius.
const LEAST_SPHERE: f64 = 1e-5;
/// The least size of a feature, as a share of the scene's extent.
const SMALLEST_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
/// The least size of a light, as a share of the distance that its light goes: the density of the directions to a smaller one has no square in
/// f32 (shaders/light), with a factor of two for surfaces that see it at an angle.
const LEAST_LIGHT: f64 = 1.0 / (1u64 << 30) as f64;
/// The largest rounding of positions in a medium, as a share of its mean free path.
const PATH_SHARE: f64 = 0.1;
/// The largest share of the light in a medium that `max_depth` may cut off.
const CUT_SHARE: f64 = 0.01;
/// The extrapolation distance of diffusion theory: the fluence in a medium extrapolates to 0 this far outside its
/// boundary, in transport mean free paths (Milne's problem: Chandrasekhar, Radiative Transfer, section 27).
const EXTRAPOLATION: f64 = 0.7104;

/// The name of a size in messages, and the field that holds it.
type Name = (&'static str, &'static str);

#[derive(Clone, Copy)]
struct Small {
    at: At,
    name: Name,
    size: f64,
    distance: f64,
    /// The coordinate whose rounding is visible; for a sphere, the distance.
    coordinate: f64,
    /// The least allowed size, as a share of the coordinate.
    share: f64,
}

/// The search for critical sizes, and its findings.
pub struct Sizes<'a> {
    found: &'a Found<'a>,
    /// The least allowed size of a feature.
    smallest: f64,
    lost: Worst<Small>,
    /// Clear boxes with a side below the offset of rays: the number, the side and the offset.
    thin: Worst<(usize, f64, f64)>,
    tiny: Worst<(At, Name, f64)>,
    /// Lights that are too small for where they shine: the number, the size and the distance.
    dim: Worst<(usize, f64, f64)>,
}

impl<'a> Sizes<'a> {
    pub fn new(found: &'a Found<'a>) -> Sizes<'a> {
        Sizes {
            found,
            smallest: SMALLEST_SHARE * found.extent,
            lost: Worst::default(),
            thin: Worst::default(),
            tiny: Worst::default(),
            dim: Worst::default(),
        }
    }

    pub fn see(&mut self, number: usize, body: &Body, kind: Role) {
        if kind.light {
            let size = sizes(body).fold(0.0, |most: f64, (size, _)| most.max(size));
            // From one corner of what the scene holds to the light.
            let far = 3f64.sqrt() * self.found.extent + body.place.length();
            if size < LEAST_LIGHT * far {
                self.dim.note(far / size, (number, size, far));
            }
        }
        let thinnest = if kind.glass { thinnest(body) } else { None };
        if let Some((side, start)) = thinnest.filter(|(side, start)| side <= start) {
            return self.thin.note(start / side, (number, side, start));
        }
        self.measure(At::Primitive(number), body, kind.glass);
    }

    /// `deep`: rays pass through the object.
    fn measure(&mut self, at: At, body: &Body, deep: bool) {
        let (size, name) = least_size(body);
        if size < least_share(body) * body.place.length()
            && let Some(small) = lost_in_rounding(self.found, at, body, deep)
        {
            self.lost.note(small.coordinate / small.size, small);
        }
        if size < self.smallest {
            self.tiny.note(self.smallest / size, (at, name, size));
        }
    }

    pub fn diagnostics(mut self) -> Vec<Diagnostic> {
        let found = self.found;
        let (mut dense, mut white) = (Worst::default(), Worst::default());
        for (number, medium) in found.media.iter().enumerate() {
            let at = At::Medium(number);
            self.measure(at, &Body::new(found, &medium.boundary, &medium.to_world), true);
            let far = reach(&medium.boundary, &medium.to_world, found.view.eye);
            let share = medium.density * U * far;
            if share > PATH_SHARE {
                dense.note(share, (at, medium.density, far));
            }
            if medium.albedo.is_white(&found.scene.bitmaps) {
                let cut = cut_share(found, medium);
                if cut > CUT_SHARE {
                    white.note(cut, (at, cut));
                }
            }
        }
        let tiny = self.tiny.diagnostic(|of| tell_tiny(of, found));
        let thin = self.thin.diagnostic(tell_thin);
        let white = white.diagnostic(|of| tell_white(of, found.scene.render.max_depth));
        let dim = self.dim.diagnostic(tell_dim);
        let all = [self.lost.diagnostic(tell_lost), thin, tiny, dim, dense.diagnostic(tell_dense), white];
        all.into_iter().flatten().collect()
    }
}

/// The sizes of a shape, with their names. Of a mesh only the longest side of its box counts, because a mesh may be flat.
fn sizes(body: &Body) -> impl Iterator<Item = (f64, Name)> {
    let mut sizes = body.hull.sizes();
    if !body.shape.is_hull() {
        sizes = vec![sizes.into_iter().fold(0.0, f64::max)];
    }
    let names = body.shape.kind().sizes;
    sizes.into_iter().zip(names.iter().chain(names.last().into_iter().cycle()).copied())
}

fn least_size(body: &Body) -> (f64, Name) {
    sizes(body).reduce(|a, b| if b.0 < a.0 { b } else { a }).unwrap_or((0.0, ("a size", "")))
}

/// The least size of a shape, as a share of its distance.
fn least_share(body: &Body) -> f64 {
    match body.hull {
        Hull::Ball { .. } => LEAST_SPHERE,
        _ => LEAST_SHARE,
    }
}

/// The coordinates of a position whose rounding is visible. If render space has the camera's axes, the rounding of the
/// depth of an opaque object is not visible: the image shows only its extent across the view. In clear objects and
/// media, rays travel in depth too.
fn shown(found: &Found, place: DVec3, deep: bool) -> DVec3 {
    let across = DVec3::new(1.0, 1.0, if found.view.turned && !deep { 0.0 } else { 1.0 });
    place.abs() * across
}

/// The feature that is worst lost in the rounding of its position, if any is. Along a direction, a coordinate x is
/// rounded by u |x|. A sphere's outline is off by the rounding of its distance, in any direction. `deep`: rays pass
/// through the object.
fn lost_in_rounding(found: &Found, at: At, body: &Body, deep: bool) -> Option<Small> {
    let place = shown(found, body.place, deep);
    let distance = body.place.length();
    let share = least_share(body);
    let along = |direction: DVec3| place.dot(direction.abs());
    let coordinate = |which: usize| match body.hull {
        Hull::Ball { .. } => place.length(),
        _ if !body.shape.is_hull() => place.max_element(),
        Hull::Parallelogram { u, v, .. } => along([u, v][which].normalize_or_zero()),
        Hull::Cuboid { axes, .. } => along(axes.col(which)),
    };
    let feature = |(which, (size, name))| Small { at, name, size, distance, coordinate: coordinate(which), share };
    let features = sizes(body).enumerate().map(feature);
    let lost = features.filter(|small| small.size < small.share * small.coordinate);
    lost.max_by(|a, b| (a.coordinate / a.size).total_cmp(&(b.coordinate / b.size)))
}

/// The side of a box that is thinnest relative to the offset of rays that enter through it, and that offset.
fn thinnest(body: &Body) -> Option<(f64, f64)> {
    let Hull::Cuboid { half, axes, .. } = body.hull else { return None };
    if !body.shape.is_hull() {
        return None;
    }
    let sides = (0..3).map(|axis| (2.0 * half[axis], leaving::from_cuboid(axes.col(axis), body.place, half, &axes)));
    sides.min_by(|(a, start_a), (b, start_b)| (a / start_a).total_cmp(&(b / start_b)))
}

/// The share of the light in a medium of albedo 1 that is still inside after `max_depth` events. Own derivation from
/// diffusion theory (Chandrasekhar, as above). σ is the density, l = 1 / (σ (1 - g)) the transport mean free path, and
/// z is `EXTRAPOLATION`. The slowest mode decays by the share l B² / (3 σ) in each event, where B² is the sum of (π /
/// (L + 2 z l))² over the sides L of a box, or (π / (R + z l))² for a sphere of radius R. For a side with τ = σ L this
/// share is 1 / N with N = 3 / π² τ (τ (1 - g) + 4 z). The term (2 z)² / (1 - g) is left out, so that N is also right
/// for g near 1, where light goes almost straight. A mesh counts as the box around it.
fn cut_share(found: &Found, medium: &PlacedMedium) -> f64 {
    let body = Body::new(found, &medium.boundary, &medium.to_world);
    let transport = 1.0 - medium.anisotropy;
    let leave = |length: f64, ends: f64| {
        let depth = medium.density * length;
        PI * PI / (3.0 * depth * (depth * transport + 2.0 * ends * EXTRAPOLATION))
    };
    let each = match body.half_sides() {
        Some(half) => leave(2.0 * half.x, 2.0) + leave(2.0 * half.y, 2.0) + leave(2.0 * half.z, 2.0),
        None => leave(body.hull.ball().1, 1.0),
    };
    (-f64::from(found.scene.render.max_depth) * each).exp()
}

fn tell_thin((number, side, start): (usize, f64, f64)) -> Diagnostic {
    let message = format!(
        "a clear box with a side of {}, but the ray offset is up to {}: rays that enter the box start behind its far side and miss it: \
         make it thicker than {}, or make its other sides smaller",
        short(side),
        short(start),
        short(start)
    );
    Diagnostic::of(At::Primitive(number), "", message)
}

fn tell_white((at, cut): (At, f64), max_depth: u32) -> Diagnostic {
    let message = format!(
        "an albedo of 1 absorbs nothing, and the medium is so thick that {} % of the light in it is scattered more than {max_depth} times: paths \
         end there at max_depth: write 0.99 or less, a lower density, or a higher max_depth",
        short((1000.0 * cut).round() / 10.0)
    );
    Diagnostic::of(at, "albedo", message)
}

fn tell_lost(Small { at, name: (name, field), size, distance, coordinate, share }: Small) -> Diagnostic {
    let outline = 2.0 * U * coordinate;
    let consequence = match size < LEAST_SHARE * coordinate {
        true => format!("f32 rounds its place by up to {}, so that its shape is lost", short(U * coordinate)),
        false => {
            format!(
                "f32 rounds its outline by up to {}, {} % of the radius",
                short(outline),
                short(100.0 * outline / size)
            )
        }
    };
    let message = format!(
        "{name} of {} at a distance of {} from the camera: {consequence}: make it larger than {}, bring it nearer or leave it out",
        short(size),
        short(distance),
        short(share * coordinate)
    );
    Diagnostic { at, field: field_of(at, field), message, other: None, more: 0 }
}

/// The object that reaches farthest from the camera.
fn farthest(found: &Found) -> Option<At> {
    let eye = found.view.eye;
    let primitives = found.placed.iter().map(|of| reach(&of.shape, &of.to_world, eye)).enumerate();
    let media = found.media.iter().map(|of| reach(&of.boundary, &of.to_world, eye)).enumerate();
    let all = primitives.map(|(i, far)| (At::Primitive(i), far)).chain(media.map(|(i, far)| (At::Medium(i), far)));
    all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
}

fn tell_tiny((at, (name, field), size): (At, Name, f64), found: &Found) -> Diagnostic {
    let (extent, farthest) = (found.extent, farthest(found));
    let by = if farthest.is_some() { format!(", which the object at {OTHER} sets") } else { String::new() };
    let message = format!(
        "{name} of {} is {} of the scene's extent of {}{by}, expected {} at least: leave out the small object, or objects \
         that are so large or far away",
        short(size),
        power_of_two(size / extent),
        short(extent),
        power_of_two(SMALLEST_SHARE)
    );
    Diagnostic { at, field: field_of(at, field), message, other: farthest, more: 0 }
}

fn tell_dim((number, size, far): (usize, f64, f64)) -> Diagnostic {
    let message = format!(
        "a light of size {}, in a scene where light goes up to {}: from farther than {} it gives nothing, because f32 does not hold its \
         solid angle: make it larger and as much fainter, or leave out what is so far away",
        short(size),
        short(far),
        short(size / LEAST_LIGHT)
    );
    Diagnostic::of(At::Primitive(number), "", message)
}

fn tell_dense((at, density, far): (At, f64, f64)) -> Diagnostic {
    let message = format!(
        "a density of {} is a mean free path of {}, and f32 rounds positions up to {} from the camera by {}: light that enters or \
         leaves the medium is scattered wrongly: write a density below {}, or replace the medium by a surface",
        short(density),
        short(1.0 / density),
        short(far),
        short(U * far),
        short(PATH_SHARE / (U * far))
    );
    Diagnostic::of(at, "density", message)
}

/// The size of a medium is in its field `boundary`.
fn field_of(at: At, field: &'static str) -> &'static str {
    match at {
        At::Medium(_) => "boundary",
        _ => field,
    }
}
