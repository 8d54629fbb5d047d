//! Lengths that f32 cannot hold: features lost in the rounding of their place, surfaces rounded by more than a pixel, scenes of too
//! many sizes, and media thicker than their places are resolved.

use glam::DVec3;

use super::{At, Body, Danger, Found, Kind, U, Worst, power_of_two, short};
use crate::flatten::place::{Shape, reach};
use crate::scene::Mesh;

/// A feature is to be larger than so many roundings of its place: at eight, its shape is off by an eighth at most.
const ROUNDINGS: f64 = 8.0;
/// The least share of the extent that a feature may be.
const SMALLEST_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
/// The largest share of a medium's mean free path by which places in it may be rounded.
const PATH_SHARE: f64 = 0.1;
/// So many surfaces that may be too near are looked at more closely, and so many meshes, which takes longer.
const MOST_LOOKS: usize = 256;
const MOST_MESH_LOOKS: usize = 4;
/// Rays along a side of the image that look for the place where a surface is nearest.
const LOOKS: u32 = 17;

/// The name of a size, as a message calls it, with the field that holds it.
type Name = (&'static str, &'static str);

#[derive(Clone, Copy)]
struct Small {
    at: At,
    name: Name,
    size: f64,
    distance: f64,
    /// The largest coordinate whose rounding shows.
    coordinate: f64,
}

struct Near {
    at: At,
    what: &'static str,
    name: Name,
    size: f64,
    distance: f64,
    pixel: f64,
    error: f64,
}

/// What is found of sizes.
pub struct Sizes<'a> {
    found: &'a Found<'a>,
    /// A feature may be no smaller.
    smallest: f64,
    lost: Worst<Small>,
    near: Worst<Near>,
    tiny: Worst<(At, Name, f64)>,
    looks: usize,
    mesh_looks: usize,
}

impl<'a> Sizes<'a> {
    pub fn new(found: &'a Found<'a>) -> Sizes<'a> {
        Sizes {
            found,
            smallest: SMALLEST_SHARE * found.extent,
            lost: Worst::default(),
            near: Worst::default(),
            tiny: Worst::default(),
            looks: 0,
            mesh_looks: 0,
        }
    }

    pub fn see(&mut self, number: usize, body: &Body, kind: Kind) {
        let at = At::Primitive(number);
        self.measure(at, body, kind.glass);
        let error = rounding(self.found, body);
        if error > self.found.view.pixel * least_distance(self.found, body) {
            self.look(at, body, error);
        }
    }

    /// `deep` says whether rays pass through.
    fn measure(&mut self, at: At, body: &Body, deep: bool) {
        let (size, name) = smallest_of(self.found, body);
        if size < ROUNDINGS * U * body.place.length()
            && let Some(small) = lost_in_rounding(self.found, at, body, deep)
        {
            self.lost.note(small.coordinate / small.size, small);
        }
        if size < self.smallest {
            self.tiny.note(self.smallest / size, (at, name, size));
        }
    }

    /// Compares the rounding of a surface with a pixel where it is seen nearest.
    fn look(&mut self, at: At, body: &Body, error: f64) {
        let (looks, most) = match body.shape {
            Shape::Mesh(_) => (&mut self.mesh_looks, MOST_MESH_LOOKS),
            _ => (&mut self.looks, MOST_LOOKS),
        };
        *looks += 1;
        if *looks > most {
            return;
        }
        let Some(distance) = nearest_seen(self.found, body) else { return };
        let pixel = self.found.view.pixel * distance;
        if error > pixel {
            let (size, name) = largest_of(self.found, body);
            let what = super::name(body.shape);
            self.near.note(error / pixel, Near { at, what, name, size, distance, pixel, error });
        }
    }

    pub fn dangers(mut self) -> Vec<Danger> {
        let found = self.found;
        let mut dense = Worst::default();
        for (number, medium) in found.media.iter().enumerate() {
            let at = At::Medium(number);
            self.measure(at, &Body::new(found, &medium.boundary, &medium.to_world), true);
            let far = reach(&medium.boundary, &medium.to_world, found.view.eye, found.boxes);
            let share = medium.density * U * far;
            if share > PATH_SHARE {
                dense.note(share, (at, medium.density, far));
            }
        }
        let tiny = self.tiny.danger(|of| tell_tiny(of, found.extent));
        let all = [self.lost.danger(tell_lost), self.near.danger(tell_near), tiny, dense.danger(tell_dense)];
        all.into_iter().flatten().collect()
    }
}

/// The smallest length of a shape that is meant to be seen. A mesh may be flat: what counts is the longest side of the box around it.
fn smallest_of(found: &Found, body: &Body) -> (f64, Name) {
    let scale = body.to_world.scale;
    match *body.shape {
        Shape::Sphere { radius, .. } => (scale * radius, RADIUS),
        Shape::Quad { u, v, .. } => {
            let (u, v) = (u.length(), v.length());
            if u <= v { (scale * u, U_EDGE) } else { (scale * v, V_EDGE) }
        }
        Shape::Cuboid { min, max } => (scale * (max - min).min_element(), SIDE),
        Shape::Mesh(mesh) => (scale * (found.boxes[mesh].max - found.boxes[mesh].min).max_element(), SIZE),
    }
}

const RADIUS: Name = ("a radius", "radius");
const U_EDGE: Name = ("an edge", "u");
const V_EDGE: Name = ("an edge", "v");
const SIDE: Name = ("a side", "");
const SIZE: Name = ("a size", "");

/// The largest length of a shape.
fn largest_of(found: &Found, body: &Body) -> (f64, Name) {
    let scale = body.to_world.scale;
    match *body.shape {
        Shape::Sphere { radius, .. } => (scale * radius, RADIUS),
        Shape::Quad { u, v, .. } => {
            let (u, v) = (u.length(), v.length());
            if u > v { (scale * u, U_EDGE) } else { (scale * v, V_EDGE) }
        }
        Shape::Cuboid { min, max } => (scale * (max - min).max_element(), SIDE),
        Shape::Mesh(mesh) => (scale * (found.boxes[mesh].max - found.boxes[mesh].min).max_element(), SIZE),
    }
}

/// The coordinates of a place whose rounding shows. Where render space has the camera's axes, opaque things lose nothing
/// by the rounding of their depth: what is seen of them lies across the view. (Rays that pass through cross them in depth.)
fn shown(found: &Found, place: DVec3, deep: bool) -> DVec3 {
    let across = DVec3::new(1.0, 1.0, if found.view.turned && !deep { 0.0 } else { 1.0 });
    place.abs() * across
}

/// Whether a feature is smaller than the rounding of its place allows, each along its own direction: a coordinate x is rounded by u |x|.
/// `deep` says whether rays pass through.
fn lost_in_rounding(found: &Found, at: At, body: &Body, deep: bool) -> Option<Small> {
    let place = shown(found, body.place, deep);
    let distance = body.place.length();
    let along =
        |size: f64, axis: DVec3, name: Name| Small { at, name, size, distance, coordinate: place.dot(axis.abs()) };
    let axes = body.to_world.rotation;
    let features = match *body.shape {
        Shape::Sphere { .. } | Shape::Mesh(_) => {
            let (size, name) = smallest_of(found, body);
            vec![Small { at, name, size, distance, coordinate: place.max_element() }]
        }
        Shape::Quad { u, v, .. } => {
            let (u, v) = body.edges(u, v);
            vec![along(u.length(), u.normalize_or_zero(), U_EDGE), along(v.length(), v.normalize_or_zero(), V_EDGE)]
        }
        Shape::Cuboid { min, max } => {
            let sides = body.to_world.scale * (max - min);
            vec![
                along(sides.x, axes.x_axis, SIDE),
                along(sides.y, axes.y_axis, SIDE),
                along(sides.z, axes.z_axis, SIDE),
            ]
        }
    };
    let lost = features.into_iter().filter(|small| small.size < ROUNDINGS * U * small.coordinate);
    lost.max_by(|a, b| (a.coordinate / a.size).total_cmp(&(b.coordinate / b.size)))
}

/// The bound of the rounding of a point on a shape and of the start of a ray that leaves it, as the kernels have it.
fn rounding(found: &Found, body: &Body) -> f64 {
    let place = shown(found, body.place, false).max_element();
    let scale = body.to_world.scale;
    match *body.shape {
        Shape::Sphere { radius, .. } => 4.0 * U * (place + scale * radius),
        Shape::Quad { u, v, .. } => {
            let (u, v) = body.edges(u, v);
            8.0 * U * (place + u.abs().max_element() + v.abs().max_element())
        }
        Shape::Cuboid { min, max } => 8.0 * U * (place + 0.5 * scale * (max - min).element_sum()),
        Shape::Mesh(mesh) => {
            let sides = found.boxes[mesh].max - found.boxes[mesh].min;
            8.0 * U * (place + 1.5 * scale * sides.max_element())
        }
    }
}

/// A distance that a shape is certainly not nearer than. Of a mesh, that of the box around it.
fn least_distance(found: &Found, body: &Body) -> f64 {
    match *body.shape {
        Shape::Sphere { radius, .. } => (body.place.length() - body.to_world.scale * radius).abs(),
        Shape::Quad { u, v, .. } => {
            let (u, v) = body.edges(u, v);
            let by_size = body.place.length() - u.length() - v.length();
            let normal = u.cross(v).normalize_or_zero();
            by_size.max(normal.dot(body.place).abs())
        }
        Shape::Cuboid { .. } | Shape::Mesh(_) => {
            let half = body.half_sides(found).unwrap_or_default();
            let outside = (body.to_world.rotation.transpose() * body.place).abs() - half;
            let nearest = outside.max_element();
            match body.shape {
                Shape::Mesh(_) => nearest.max(0.0),
                _ => nearest.abs(),
            }
        }
    }
}

/// The least depth at which a shape is in view: of a grid of rays that meet it, or of the vertices of a mesh.
fn nearest_seen(found: &Found, body: &Body) -> Option<f64> {
    if let Shape::Mesh(mesh) = *body.shape {
        return nearest_vertex(found, body, found.scene.meshes.values().nth(mesh)?);
    }
    let (width, height) = found.view.size;
    let place = |i: u32, side: u32| (f64::from(i) / f64::from(LOOKS - 1) - 0.5) * f64::from(side) * found.view.pixel;
    let rays = (0..LOOKS * LOOKS).map(|i| (place(i % LOOKS, width), place(i / LOOKS, height)));
    let met = rays.filter_map(|(x, y)| crossing(found, body, found.view.axes * DVec3::new(x, y, -1.0)));
    met.min_by(f64::total_cmp)
}

fn nearest_vertex(found: &Found, body: &Body, mesh: &Mesh) -> Option<f64> {
    let (width, height) = found.view.size;
    let half = 0.5 * found.view.pixel * DVec3::new(f64::from(width), f64::from(height), 0.0);
    let to_camera = found.view.axes.transpose();
    let depths = mesh.positions.iter().filter_map(|p| {
        let p = to_camera * (body.to_world.point(*p) - found.view.eye);
        let depth = -p.z;
        (depth > 0.0 && p.x.abs() <= half.x * depth && p.y.abs() <= half.y * depth).then_some(depth)
    });
    depths.min_by(f64::total_cmp)
}

/// Where a ray from the camera first meets a shape, in lengths of its direction.
fn crossing(found: &Found, body: &Body, d: DVec3) -> Option<f64> {
    let met = match *body.shape {
        Shape::Sphere { radius, .. } => {
            let (c, r) = (body.place, body.to_world.scale * radius);
            let dd = d.length_squared();
            let k = d.dot(c) / dd;
            let l = (c - k * d).length();
            let h = ((r - l) * (r + l) / dd).sqrt();
            // The root that would cancel, from the product of both; of a miss all is NaN.
            let far = k + h.copysign(k);
            let near = (c.length() - r) * (c.length() + r) / dd / far;
            let (first, second) = (far.min(near), far.max(near));
            if first > 0.0 { first } else { second }
        }
        Shape::Quad { u, v, .. } => {
            let (u, v) = body.edges(u, v);
            let n = u.cross(v);
            let t = n.dot(body.place) / n.dot(d);
            let p = t * d - body.place;
            let nn = n.length_squared();
            let (a, b) = (p.cross(v).dot(n) / nn, u.cross(p).dot(n) / nn);
            if (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b) { t } else { f64::NAN }
        }
        Shape::Cuboid { .. } | Shape::Mesh(_) => {
            let half = body.half_sides(found).unwrap_or_default();
            let to_own = body.to_world.rotation.transpose();
            let (c, inverse) = (to_own * body.place, (to_own * d).recip());
            let (low, high) = ((c - half) * inverse, (c + half) * inverse);
            let (enter, leave) = (low.min(high).max_element(), low.max(high).min_element());
            match enter <= leave {
                true if enter > 0.0 => enter,
                true => leave,
                false => f64::NAN,
            }
        }
    };
    (met > 0.0 && met.is_finite()).then_some(met)
}

fn tell_lost(Small { at, name: (name, field), size, distance, coordinate }: Small) -> Danger {
    let message = format!(
        "{name} of {} at a distance of {} from the camera: f32 rounds its place by up to {}, so that its shape is lost: make \
         it larger than {}, bring it nearer or leave it out",
        short(size),
        short(distance),
        short(U * coordinate),
        short(ROUNDINGS * U * coordinate)
    );
    Danger { at, field: field_of(at, field), message, other: None, more: 0 }
}

fn tell_near(Near { at, what, name: (name, field), size, distance, pixel, error }: Near) -> Danger {
    let pixels = error / pixel;
    let message = format!(
        "a {what} with {name} of {} is seen from a distance of {}, where a pixel is {} wide: its points and the rays that leave \
         them are off by up to {}, {} pixels: make it smaller than {}, or build it of parts",
        short(size),
        short(distance),
        short(pixel),
        short(error),
        short(pixels),
        short(size / pixels)
    );
    Danger { at, field, message, other: None, more: 0 }
}

fn tell_tiny((at, (name, field), size): (At, Name, f64), extent: f64) -> Danger {
    let message = format!(
        "{name} of {} is {} of the scene's extent of {}, expected {} at least: leave out what is so small, or what is \
         so far",
        short(size),
        power_of_two(size / extent),
        short(extent),
        power_of_two(SMALLEST_SHARE)
    );
    Danger { at, field: field_of(at, field), message, other: None, more: 0 }
}

fn tell_dense((at, density, far): (At, f64, f64)) -> Danger {
    let message = format!(
        "a density of {} is a mean free path of {}, and f32 rounds places up to {} from the camera by {}: light that enters or \
         leaves it is scattered wrongly: write a density below {}, or a surface in its place",
        short(density),
        short(1.0 / density),
        short(far),
        short(U * far),
        short(PATH_SHARE / (U * far))
    );
    Danger { at, field: "density", message, other: None, more: 0 }
}

/// A medium's size is its boundary's.
fn field_of(at: At, field: &'static str) -> &'static str {
    match at {
        At::Medium(_) => "boundary",
        _ => field,
    }
}
