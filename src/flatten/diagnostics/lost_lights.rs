//! Finds light that cannot reach the camera: a one-sided light with nothing on its emitting side; a spot light that aims at nothing; a closed light around the camera
//! that emits outwards; a closed opaque object around either a light or the camera, with the other one outside; and a closed room around
//! the camera that only the background and directional lights light.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::search::{Diagnostic, OTHER, Role, Search, U, Worst};
use super::within::{Within, is_outside_in_front};
use crate::flatten::finder::MovingLight;
use crate::scene::Object;
use crate::shape::{Aabb, BoundingShape, normal};

/// The most lights that the search tests.
const MOST_LIGHTS: usize = 4096;
/// The limit on comparisons of a light with an object.
const MOST_TESTS: usize = 1 << 22;

pub fn search<'a>(search: &Search<'a>) -> Vec<Worst<'a>> {
    let mut found = vec![turned_away(search), astray(search)];
    found.extend(enclosed(search));
    found
}

/// One-sided quads and disks with all of the scene and the camera behind them.
fn turned_away<'a>(search: &Search<'a>) -> Worst<'a> {
    let mut worst = Worst::default();
    let is_one_sided = |role: &Role| role.light && role.one_sided;
    if !search.roles.iter().any(is_one_sided) {
        return worst;
    }
    let lens = DVec3::splat(search.view.lens_radius());
    let (mut all, mut rounded) = (Aabb { min: -lens, max: lens }, lens);
    for body in search.bodies().chain(search.boundaries()) {
        let own = body.bounds.bounds();
        all = all.union(own);
        // Of a large sphere, the rounding near the camera counts, not that of its far side.
        if body.shape.large_sphere().is_none() {
            rounded = rounded.max(own.min.abs().max(own.max.abs()));
        }
    }
    for body in search.bodies().filter(|body| is_one_sided(&body.role) && body.shape.fills_bounding_shape()) {
        let BoundingShape::Parallelogram { corner, u, v } = body.bounds else { continue };
        let n = normal(u, v);
        let farthest = DVec3::select(n.cmpge(DVec3::ZERO), all.max, all.min);
        if n.dot(farthest - corner) <= 8.0 * U * n.abs().dot(rounded) {
            let message = "this light emits to one side, and the whole scene is on its other side: turn it round (exchange a quad's u and v, \
                           reverse a disk's normal), or make it two_sided";
            worst.add(0.0, || Diagnostic::of(body.object, message));
        }
    }
    worst
}

/// Spot lights with nothing in their cone. An object that moves counts as in it.
fn astray<'a>(search: &Search<'a>) -> Worst<'a> {
    let mut worst = Worst::default();
    let (primitives, eye) = (&search.finder.primitives, search.view.eye);
    if primitives.iter().any(|primitive| !primitive.motion.is_empty()) {
        return worst;
    }
    // As many lights as all bodies leave time for.
    let most = MOST_TESTS / primitives.len().max(1);
    for MovingLight { object, light, motion } in search.finder.lights.iter().take(most) {
        let (Some(at), (axis, Some(angle))) = (light.position, light.cone()) else { continue };
        // Without a cone or an intensity it has other warnings.
        if light.is_dark() || !motion.is_empty() {
            continue;
        }
        let mut bodies = search.bodies().chain(search.boundaries());
        if !bodies.any(|body| may_light(at - eye, axis, angle, &body.bounds)) {
            let message = "no object is in the cone of this light, so that it lights nothing: aim it with towards, or widen its outer \
                           angle";
            worst.add(0.0, || Diagnostic::of(object, message));
        }
    }
    worst
}

/// Whether a cone may reach a body: false if a plane that touches the cone has the body on its other side.
fn may_light(apex: DVec3, axis: DVec3, angle: f64, bounds: &BoundingShape) -> bool {
    let (center, radius) = bounds.ball();
    let to_body = center - apex;
    if let BoundingShape::Ball { .. } = bounds {
        let distance = to_body.length();
        return distance <= radius || to_body.angle_between(axis) - (radius / distance).asin() <= angle;
    }
    if angle >= FRAC_PI_2 {
        return true;
    }
    let (x, y) = axis.any_orthonormal_pair();
    const AROUND: usize = 64;
    let sides = (0..AROUND).map(|i| {
        let (sine, cosine) = (TAU * i as f64 / AROUND as f64).sin_cos();
        angle.cos() * (cosine * x + sine * y) - angle.sin() * axis
    });
    let corners = bounds.corners();
    !sides.chain([-axis]).any(|outward| corners.iter().all(|p| outward.dot(*p - apex) > 0.0))
}

/// A light, as a ball.
struct Light<'a> {
    object: &'a Object,
    center: DVec3,
    radius: f64,
}

/// Closed lights around the camera, lights that a closed object separates from the camera, and dark rooms.
fn enclosed<'a>(search: &Search<'a>) -> [Worst<'a>; 3] {
    let [mut outwards, mut hidden, mut rooms] = [(); 3].map(|()| Worst::default());
    let surfaces = search.bodies().filter(|body| body.role.light).map(|body| {
        let (center, radius) = body.bounds.ball();
        Light { object: body.object, center, radius }
    });
    let without_size = search.finder.lights.iter().filter_map(|MovingLight { object, light, .. }| {
        Some(Light { object, center: light.position? - search.view.eye, radius: 0.0 })
    });
    let lights: Vec<Light> = surfaces.take(MOST_LIGHTS).chain(without_size.take(MOST_LIGHTS)).collect();
    if !search.is_lit {
        return [outwards, hidden, rooms];
    }
    let lens = search.view.lens_radius();
    let (mut within, mut tests) = (Within::default(), MOST_TESTS);
    for wall in search.bodies().filter(|body| body.role.opaque) {
        let Some(depth) = within.depth(&wall, DVec3::ZERO) else { continue };
        let (camera_is_inside, camera_is_outside) = (depth > lens, depth < -lens);
        let word = wall.word();
        if camera_is_inside && wall.role.light && wall.role.one_sided && is_outside_in_front(&wall) {
            let message = format!(
                "the camera is inside this {word}, which emits outwards only: its inside is black. Make it two_sided"
            );
            outwards.add(0.0, || Diagnostic::of(wall.object, message));
        }
        if camera_is_inside && lights.is_empty() {
            let message = format!(
                "the camera is inside this opaque {word}, and no light is: the image is black. Move the camera out of it, open it, or put \
                 a light inside"
            );
            rooms.add(0.0, || Diagnostic::of(wall.object, message));
        }
        if !camera_is_inside && !camera_is_outside {
            continue;
        }
        let (center, radius) = wall.bounds.ball();
        for light in lights.iter().filter(|light| !std::ptr::eq(light.object, wall.object)) {
            let Some(left) = tests.checked_sub(1) else { return [outwards, hidden, rooms] };
            tests = left;
            if camera_is_outside && light.center.distance_squared(center) >= radius * radius {
                continue;
            }
            let depth = within.depth(&wall, light.center);
            let is_apart = depth.is_some_and(|depth| if camera_is_inside { -depth } else { depth } > light.radius);
            if is_apart {
                let (inner, outer) = if camera_is_inside { ("the camera", "light") } else { ("it", "camera") };
                hidden.add(0.0, || {
                    let message = format!(
                        "no path reaches this light: the opaque {word} at {OTHER} encloses {inner}, and the {outer} is outside: remove \
                         the light, or open the {word}"
                    );
                    Diagnostic { other: Some(wall.object), ..Diagnostic::of(light.object, message) }
                });
            }
        }
    }
    [outwards, hidden, rooms]
}
