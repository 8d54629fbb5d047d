//! Lengths that f32 cannot hold: features lost in the rounding of their place, scenes of too many sizes, and media thicker than their
//! places are resolved. And media that are so thick that paths end in them.

use std::f64::consts::PI;

use glam::DVec3;

use super::{At, Body, Diagnostic, Found, Role, U, Worst, leaving, power_of_two, short};
use crate::flatten::place::{PlacedMedium, reach};
use crate::shape::Hull;

/// The least share of its distance that a feature may be, eight roundings of its place: there its shape is off by an eighth.
const LEAST_SHARE: f64 = 8.0 * U;
/// The same of a sphere's radius: there its outline is off by 2 u over this, an eightieth of the radius.
const LEAST_SPHERE: f64 = 1e-5;
/// The least share of the extent that a feature may be.
const SMALLEST_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
/// The largest share of a medium's mean free path by which places in it may be rounded.
const PATH_SHARE: f64 = 0.1;
/// The largest share of what is scattered about in a medium that `max_depth` may cut off.
const CUT_SHARE: f64 = 0.01;
/// How far outside of its boundary the density of light in a medium comes to nothing, in transport mean free paths (Milne's problem:
/// Chandrasekhar, Radiative Transfer, section 27).
const EXTRAPOLATION: f64 = 0.7104;

/// The name of a size, as a message calls it, with the field that holds it.
type Name = (&'static str, &'static str);

#[derive(Clone, Copy)]
struct Small {
    at: At,
    name: Name,
    size: f64,
    distance: f64,
    /// The coordinate whose rounding shows, or the distance.
    coordinate: f64,
    /// The least share of that that it may be.
    share: f64,
}

/// What is found of sizes.
pub struct Sizes<'a> {
    found: &'a Found<'a>,
    /// A feature may be no smaller.
    smallest: f64,
    lost: Worst<Small>,
    /// Clear boxes that rays start beyond, with where they start.
    thin: Worst<(usize, f64, f64)>,
    tiny: Worst<(At, Name, f64)>,
}

impl<'a> Sizes<'a> {
    pub fn new(found: &'a Found<'a>) -> Sizes<'a> {
        Sizes {
            found,
            smallest: SMALLEST_SHARE * found.extent,
            lost: Worst::default(),
            thin: Worst::default(),
            tiny: Worst::default(),
        }
    }

    pub fn see(&mut self, number: usize, body: &Body, kind: Role) {
        let thinnest = if kind.glass { thinnest(body) } else { None };
        if let Some((side, start)) = thinnest.filter(|(side, start)| side <= start) {
            return self.thin.note(start / side, (number, side, start));
        }
        self.measure(At::Primitive(number), body, kind.glass);
    }

    /// `deep` says whether rays pass through.
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
        let tiny = self.tiny.diagnostic(|of| tell_tiny(of, found.extent));
        let thin = self.thin.diagnostic(tell_thin);
        let white = white.diagnostic(|of| tell_white(of, found.scene.render.max_depth));
        let all = [self.lost.diagnostic(tell_lost), thin, tiny, dense.diagnostic(tell_dense), white];
        all.into_iter().flatten().collect()
    }
}

/// The sizes of a shape that are meant to be seen, with their names. A mesh may be flat: what counts is the longest side of the box around it.
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

/// The least share of its distance that a shape's sizes may be.
fn least_share(body: &Body) -> f64 {
    match body.hull {
        Hull::Ball { .. } => LEAST_SPHERE,
        _ => LEAST_SHARE,
    }
}

/// The coordinates of a place whose rounding shows. Where render space has the camera's axes, opaque things lose nothing
/// by the rounding of their depth: what is seen of them lies across the view. (Rays that pass through cross them in depth.)
fn shown(found: &Found, place: DVec3, deep: bool) -> DVec3 {
    let across = DVec3::new(1.0, 1.0, if found.view.turned && !deep { 0.0 } else { 1.0 });
    place.abs() * across
}

/// Whether a feature is smaller than the rounding of its place allows. Along a direction a coordinate x is rounded by u |x|; a sphere's outline
/// is off by what rounds its distance, whatever the direction. `deep` says whether rays pass through.
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

/// The side of a box that is thinnest against how far from it rays start that enter there, and that.
fn thinnest(body: &Body) -> Option<(f64, f64)> {
    let Hull::Cuboid { half, axes, .. } = body.hull else { return None };
    if !body.shape.is_hull() {
        return None;
    }
    let sides = (0..3).map(|axis| (2.0 * half[axis], leaving::from_cuboid(axes.col(axis), body.place, half, &axes)));
    sides.min_by(|(a, start_a), (b, start_b)| (a / start_a).total_cmp(&(b / start_b)))
}

/// The share of the light within a medium of albedo 1 that is still there after `max_depth` events, once it has spread. Own derivation from
/// diffusion theory (Chandrasekhar, as above), with σ the density, l = 1 / (σ (1 - g)) the transport mean free path, z `EXTRAPOLATION`: what stays
/// longest falls by l B² / (3 σ) an event, B² the sum of (π / (L + 2 z l))² over the sides of a box, or (π / (R + z l))² of a sphere. For a
/// side that is 1 in 3 / π² τ (τ (1 - g) + 4 z) events, τ = σ L, where (2 z)² / (1 - g) is left out: thus it is also as many as a straight way
/// has where g is near 1. A mesh counts as the box around it.
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
        "a clear box with a side of {}, and rays that enter it may start up to {} from where they enter, beyond its other side: its far \
         surface is lost in rounding: make it thicker than {}, or smaller in its other sides",
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
            format!("f32 rounds its outline by up to {}, {} % of that", short(outline), short(100.0 * outline / size))
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

fn tell_tiny((at, (name, field), size): (At, Name, f64), extent: f64) -> Diagnostic {
    let message = format!(
        "{name} of {} is {} of the scene's extent of {}, expected {} at least: leave out what is so small, or what is \
         so far",
        short(size),
        power_of_two(size / extent),
        short(extent),
        power_of_two(SMALLEST_SHARE)
    );
    Diagnostic { at, field: field_of(at, field), message, other: None, more: 0 }
}

fn tell_dense((at, density, far): (At, f64, f64)) -> Diagnostic {
    let message = format!(
        "a density of {} is a mean free path of {}, and f32 rounds places up to {} from the camera by {}: light that enters or \
         leaves it is scattered wrongly: write a density below {}, or a surface in its place",
        short(density),
        short(1.0 / density),
        short(far),
        short(U * far),
        short(PATH_SHARE / (U * far))
    );
    Diagnostic::of(at, "density", message)
}

/// A medium's size is its boundary's.
fn field_of(at: At, field: &'static str) -> &'static str {
    match at {
        At::Medium(_) => "boundary",
        _ => field,
    }
}
