//! Surfaces too large for the distance that they are seen from: rounded by more than a pixel, and spheres whose own distance from the camera
//! is lost beside their radius.

use glam::DVec3;

use super::sizes::{Name, shown, size_of};
use super::{At, Body, Danger, Found, U, Worst, short};
use crate::scene::Mesh;
use crate::shape::{Hull, normal};

/// The largest share of a sphere's distance from the camera by which that may be rounded.
const LARGEST_ERROR: f64 = 0.01;
/// So many surfaces that may be too near are looked at more closely, and so many meshes, which takes longer.
const MOST_LOOKS: usize = 256;
const MOST_MESH_LOOKS: usize = 4;
/// Rays along a side of the image that look for the place where a surface is nearest.
const LOOKS: u32 = 17;

struct Near {
    number: usize,
    what: &'static str,
    name: Name,
    size: f64,
    distance: f64,
    pixel: f64,
    error: f64,
}

/// A sphere with the camera near its surface.
struct Close {
    number: usize,
    radius: f64,
    height: f64,
    error: f64,
}

/// What is found of surfaces near the camera.
pub struct Surfaces<'a> {
    found: &'a Found<'a>,
    near: Worst<Near>,
    close: Worst<Close>,
    looks: usize,
    mesh_looks: usize,
}

impl<'a> Surfaces<'a> {
    pub fn new(found: &'a Found<'a>) -> Surfaces<'a> {
        Surfaces { found, near: Worst::default(), close: Worst::default(), looks: 0, mesh_looks: 0 }
    }

    pub fn see(&mut self, number: usize, body: &Body) {
        let distance = least_distance(body);
        if let Some(close) = close(number, body, distance) {
            return self.close.note(close.error / close.height, close);
        }
        let error = rounding(self.found, body);
        if error > self.found.view.pixel * distance {
            self.look(number, body, error);
        }
    }

    /// Compares the rounding of a surface with a pixel where it is seen nearest.
    fn look(&mut self, number: usize, body: &Body, error: f64) {
        let (looks, most) = match body.shape.mesh() {
            Some(_) => (&mut self.mesh_looks, MOST_MESH_LOOKS),
            None => (&mut self.looks, MOST_LOOKS),
        };
        *looks += 1;
        if *looks > most {
            return;
        }
        let Some(distance) = nearest_seen(self.found, body) else { return };
        let pixel = self.found.view.pixel * distance;
        if error > pixel {
            let (size, name) = size_of(body, f64::max);
            let what = body.word();
            self.near.note(error / pixel, Near { number, what, name, size, distance, pixel, error });
        }
    }

    pub fn dangers(self) -> Vec<Danger> {
        [self.close.danger(tell_close), self.near.danger(tell_near)].into_iter().flatten().collect()
    }
}

/// Whether the distance of a sphere from the camera is rounded by too large a share of it. The centre and the radius are rounded, and the length
/// between camera and centre by 2 u: 4 u (r + h) of the height h.
fn close(number: usize, body: &Body, height: f64) -> Option<Close> {
    let Hull::Ball { radius, .. } = body.hull else { return None };
    let error = 4.0 * U * (radius + height);
    (body.shape.is_hull() && error > LARGEST_ERROR * height).then_some(Close { number, radius, height, error })
}

/// The bound of the rounding of a point on a shape and of the start of a ray that leaves it, as the kernels have it.
fn rounding(found: &Found, body: &Body) -> f64 {
    let place = shown(found, body.place, false).max_element();
    match body.hull {
        Hull::Ball { radius, .. } => 4.0 * U * (place + radius),
        Hull::Parallelogram { u, v, .. } => 8.0 * U * (place + u.abs().max_element() + v.abs().max_element()),
        Hull::Cuboid { half, .. } if body.shape.is_hull() => 8.0 * U * (place + half.element_sum()),
        Hull::Cuboid { half, .. } => 8.0 * U * (place + 3.0 * half.max_element()),
    }
}

/// A distance that a shape is certainly not nearer than. Of a mesh, that of the box around it.
fn least_distance(body: &Body) -> f64 {
    let distance = match body.hull {
        Hull::Ball { center, radius } => center.length() - radius,
        Hull::Parallelogram { corner, u, v } => {
            let by_size = corner.length() - u.length() - v.length();
            by_size.max(normal(u, v).dot(corner).abs())
        }
        Hull::Cuboid { center, half, axes } => ((axes.transpose() * center).abs() - half).max_element(),
    };
    if body.shape.is_hull() { distance.abs() } else { distance.max(0.0) }
}

/// The least depth at which a shape is in view: of a grid of rays that meet it, or of the vertices of a mesh.
fn nearest_seen(found: &Found, body: &Body) -> Option<f64> {
    if let Some(shape) = body.shape.mesh() {
        return nearest_vertex(found, body, shape.mesh);
    }
    let (width, height) = found.view.size;
    let place = |i: u32, side: u32| (f64::from(i) / f64::from(LOOKS - 1) - 0.5) * f64::from(side) * found.view.pixel;
    let rays = (0..LOOKS * LOOKS).map(|i| (place(i % LOOKS, width), place(i / LOOKS, height)));
    let met = rays.filter_map(|(x, y)| crossing(body, found.view.axes * DVec3::new(x, y, -1.0)));
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
fn crossing(body: &Body, d: DVec3) -> Option<f64> {
    let met = match body.hull {
        Hull::Ball { center: c, radius: r } => {
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
        Hull::Parallelogram { corner, u, v } => {
            let n = normal(u, v);
            let t = n.dot(corner) / n.dot(d);
            let p = t * d - corner;
            let area = u.cross(v).dot(n);
            let (a, b) = (p.cross(v).dot(n) / area, u.cross(p).dot(n) / area);
            if (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b) { t } else { f64::NAN }
        }
        Hull::Cuboid { center, half, axes } => {
            let (c, inverse) = (axes.transpose() * center, (axes.transpose() * d).recip());
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

fn tell_close(Close { number, radius, height, error }: Close) -> Danger {
    let consequence = match error < height {
        true => format!("{} % of that", short(100.0 * error / height)),
        false => "so that the picture may be wrong: f32 does not tell on which side of it the camera is".to_string(),
    };
    let message = format!(
        "a sphere with a radius of {}, and the camera is {} from its surface: f32 rounds distances to it by up to {}, {consequence}: move \
         the camera farther from it than {}, or write a quad where it looks flat",
        short(radius),
        short(height),
        short(error),
        short(4.0 * U / LARGEST_ERROR * radius)
    );
    Danger { at: At::Primitive(number), field: "radius", message, other: None, more: 0 }
}

fn tell_near(Near { number, what, name: (name, field), size, distance, pixel, error }: Near) -> Danger {
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
    Danger { at: At::Primitive(number), field, message, other: None, more: 0 }
}
