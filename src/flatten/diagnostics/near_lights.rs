//! Finds lights without size, and emitters as small as such, that are so near to a surface that f32 rounds their height over it.
//!
//! What such a light brings to a point of the surface is proportional to its height: cos θ / d² is h / d³ at the distance d. So a height
//! that is off by a share of itself makes the surface too bright or too dark by that share, everywhere but right below the light.

use glam::DVec3;

use super::within::nearest_triangle;
use super::{At, Body, Diagnostic, Found, OTHER, Role, U, Worst, short};
use crate::shape::{Hull, normal, reach_of};

/// The largest error of a height, as a share of it.
const LARGEST_SHARE: f64 = 1e-3;
/// A height below this share of its error is none: the light lies in the surface, and lights what is before it and what is behind it.
const IN_SURFACE: f64 = 1e-3;
/// The number of lights that the search looks at.
const MOST_LIGHTS: usize = 4096;
/// The limit on comparisons of a light with an object, and on triangles that are looked at.
const MOST_TESTS: usize = 1 << 20;
const MOST_TRIANGLES: usize = 1 << 19;
/// No surface's error is more than this many units of the distance and the size of its object together.
const MOST_UNITS: f64 = 64.0;

/// A light, as a ball.
struct Lamp {
    at: At,
    center: DVec3,
    radius: f64,
    /// Of all surfaces the one whose height is off by the largest share.
    worst: Option<Near>,
}

#[derive(Clone, Copy)]
struct Near {
    surface: usize,
    height: f64,
    error: f64,
}

/// The warning about the worst of them.
pub fn diagnostics(found: &Found, kinds: &[Role]) -> Option<Diagnostic> {
    let body = |number: usize| Body::new(found, &found.placed[number].shape, &found.placed[number].to_world);
    let kind = |number: usize| kinds[found.placed[number].material as usize];
    let without_size = found.lights.iter().enumerate().filter_map(|(number, (_, light))| {
        let center = light.place? - found.view.eye;
        Some(Lamp { at: At::Light(number), center, radius: 0.0, worst: None })
    });
    let mut lamps: Vec<Lamp> = without_size.take(MOST_LIGHTS).collect();
    if kinds.iter().any(|kind| kind.light) {
        let emitters = (0..found.placed.len()).filter(|number| kind(*number).light).take(MOST_LIGHTS);
        lamps.extend(emitters.filter_map(|number| {
            let (center, radius) = body(number).hull.ball();
            let is_small = radius * LARGEST_SHARE < 2.0 * MOST_UNITS * U * center.length();
            is_small.then_some(Lamp { at: At::Primitive(number), center, radius, worst: None })
        }));
    }
    if lamps.is_empty() {
        return None;
    }
    lamps.sort_unstable_by(|a, b| a.center.x.total_cmp(&b.center.x));
    let (mut tests, mut triangles) = (MOST_TESTS, MOST_TRIANGLES);
    for number in (0..found.placed.len()).filter(|number| !kind(*number).light && !kind(*number).glass) {
        let body = body(number);
        let (center, radius) = body.hull.ball();
        let far = radius + MOST_UNITS * U / LARGEST_SHARE * (center.length() + radius);
        let first = lamps.partition_point(|lamp| lamp.center.x < center.x - far);
        for lamp in lamps[first..].iter_mut().take_while(|lamp| lamp.center.x <= center.x + far) {
            let Some(left) = tests.checked_sub(1) else { break };
            tests = left;
            if lamp.center.distance_squared(center) > far * far {
                continue;
            }
            let Some((height, error)) = height(&body, lamp.center, &mut triangles) else { continue };
            let is_worse = lamp.worst.is_none_or(|worst| error * worst.height > worst.error * height);
            if error > LARGEST_SHARE * height && height > (IN_SURFACE * error).max(lamp.radius) && is_worse {
                lamp.worst = Some(Near { surface: number, height, error });
            }
        }
    }
    let mut worst = Worst::default();
    for (at, near) in lamps.iter().filter_map(|lamp| Some((lamp.at, lamp.worst?))) {
        worst.note(near.error / near.height, (at, near));
    }
    worst.diagnostic(|(at, near)| tell(found, at, near))
}

/// The height of a point over a surface, and how far off f32 may make it: by the rounding of both places, and by the error of points on the
/// surface along its normal, as kernels bound it (docs/light-transport.md, "Leaving a surface"). None if it is not above the surface, or
/// where the limit on triangles is reached.
fn height(body: &Body, p: DVec3, triangles: &mut usize) -> Option<(f64, f64)> {
    let rounded = |n: DVec3, surface: DVec3| U * n.abs().dot(p.abs() + surface);
    if let Some(large_sphere) = body.shape.large_sphere() {
        let far = large_sphere.distance(body.to_world).max(p.length());
        return Some((body.hull.distance(p), U * 11.0 * far));
    }
    match body.hull {
        Hull::Ball { center, radius } if body.shape.is_hull() => {
            let n = (p - center).normalize_or_zero();
            let own = 4.0 * U * (center.abs().max_element() + radius);
            Some((body.hull.distance(p), rounded(n, DVec3::ZERO) + own))
        }
        Hull::Parallelogram { corner, u, v } if body.shape.is_hull() => {
            let n = normal(u, v);
            let foot = p - n.dot(p - corner) * n - corner;
            let within = |edge: DVec3, other: DVec3| {
                let across = n.cross(other);
                (0.0..=1.0).contains(&(foot.dot(across) / edge.dot(across)))
            };
            let own = 2.0 * corner.abs() + 10.0 * (u.abs() + v.abs());
            (within(u, v) && within(v, u)).then(|| (n.dot(p - corner).abs(), rounded(n, own)))
        }
        Hull::Cuboid { center, half, axes } if body.shape.is_hull() => {
            let beyond = (axes.transpose() * (p - center)).abs() - half;
            let axis = if beyond.x > beyond.y && beyond.x > beyond.z {
                0
            } else if beyond.y > beyond.z {
                1
            } else {
                2
            };
            let beside = (0..3).any(|other| other != axis && beyond[other] > 0.0);
            let own = 2.0 * center.abs() + 12.0 * reach_of(half, &axes);
            (!beside).then(|| (beyond[axis].abs(), rounded(axes.col(axis), own)))
        }
        Hull::Cuboid { center, half, axes } => {
            let mesh = body.shape.mesh()?;
            *triangles = triangles.checked_sub(mesh.mesh.triangles.len())?;
            let to_own = body.to_world.rotation.transpose();
            let own_p = mesh.around.center() + to_own * (p - center) / body.to_world.scale;
            let (height, n) = nearest_triangle(mesh.mesh, own_p)?;
            let own = 2.0 * center.abs() + 12.0 * reach_of(half, &axes);
            Some((body.to_world.scale * height, rounded(body.to_world.rotation * n, own)))
        }
        Hull::Ball { .. } | Hull::Parallelogram { .. } => None,
    }
}

fn tell(found: &Found, at: At, Near { surface, height, error }: Near) -> Diagnostic {
    let word = found.placed[surface].shape.kind().word;
    let consequence = match error < height {
        true => format!("there its light is off by up to {} %", short(100.0 * error / height)),
        false => "it may be on the other side".to_string(),
    };
    let message = format!(
        "this light is {} from the {word} at {OTHER}, and f32 rounds that by up to {}: {consequence}: set it more than {} away, or the camera \
         nearer",
        short(height),
        short(error),
        short(error / LARGEST_SHARE)
    );
    let field = if matches!(at, At::Light(_)) { "at" } else { "" };
    Diagnostic { other: Some(At::Primitive(surface)), ..Diagnostic::of(at, field, message) }
}
