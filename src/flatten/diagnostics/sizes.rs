//! Finds lengths that f32 does not resolve: sizes of objects, mean free paths of media, and sizes of lights for the distance that they light.

use glam::DVec3;

use super::search::{Body, Diagnostic, Search, U, Worst, short};
use crate::flatten::finder::extent_of;
use crate::scene::Object;
use crate::shape::BoundingShape;

/// The least length, as a share of its distance: eight roundings of its position. At this size a shape is off by an eighth.
const LEAST_SHARE: f64 = 8.0 * U;
/// The least radius of a sphere, as a share of its distance. At this size its outline is off by 2 u / 1e-5, an eightieth of the radius.
const LEAST_RADIUS: f64 = 1e-5;
/// The least size, as a share of the scene's extent.
const LEAST_OF_EXTENT: f64 = 1.0 / (1u64 << 40) as f64;
/// The smallest size of a light, as a share of the distance that it lights: the squared density of the directions to a smaller one overflows
/// f32 (shaders/light). A factor of two is for surfaces that see it at an angle.
const LEAST_LIGHT: f64 = 1.0 / (1u64 << 30) as f64;

pub fn search<'a>(search: &Search<'a>) -> Vec<Worst<'a>> {
    let (mut lost, mut dense, mut dim) = (Worst::default(), Worst::default(), Worst::default());
    for body in search.bodies().chain(search.boundaries()) {
        let sizes = sizes(&body);
        let limits = sizes.iter().map(|(_, direction)| least_size(search, &body, *direction));
        let shares = limits.zip(&sizes).enumerate().map(|(which, (limit, (size, _)))| (limit / size, which, limit));
        if let Some((share, which, limit)) = shares.max_by(|a, b| a.0.total_cmp(&b.0))
            && share > 1.0
        {
            lost.add(share, || unresolved(&body, which, sizes[which].0, limit));
        }
        let size = sizes.iter().fold(0.0, |most: f64, (size, _)| most.max(*size));
        // From one corner of the scene to the light.
        let far = 3f64.sqrt() * search.extent + body.position.length();
        if body.role.light && size < LEAST_LIGHT * far {
            dim.add(far / size, || {
                let message = format!(
                    "this light has a size of {}, and the scene extends up to {} from it: surfaces farther away than {} get none of its \
                     light, because its solid angle underflows in f32: make the light larger and dimmer, or leave out what is so far away",
                    short(size),
                    short(far),
                    short(size / LEAST_LIGHT)
                );
                Diagnostic::of(body.object, message)
            });
        }
    }
    for medium in &search.finder.media {
        let far = extent_of(&medium.boundary, &medium.to_world, search.view.eye);
        let (path, limit) = (1.0 / medium.density, LEAST_SHARE * far);
        if path < limit {
            dense.add(limit / path, || {
                let message = format!(
                    "the mean free path is {}, and at {} from the camera, where the medium ends, f32 resolves no length below {}: write a \
                     density below {}, or replace the medium by a surface",
                    short(path),
                    short(far),
                    short(limit),
                    short(1.0 / limit)
                );
                Diagnostic { field: "density", ..Diagnostic::of(medium.object, message) }
            });
        }
    }
    vec![lost, dense, dim]
}

/// The sizes of a shape, each with its direction if it has one. Of a mesh only the longest side of its box counts, because a mesh may be flat.
fn sizes(body: &Body) -> Vec<(f64, Option<DVec3>)> {
    match body.bounds {
        BoundingShape::Ball { radius, .. } => vec![(radius, None)],
        BoundingShape::Parallelogram { u, v, .. } => {
            [u, v].map(|edge| (edge.length(), Some(edge.normalize_or_zero()))).into()
        }
        BoundingShape::Cuboid { half, axes, .. } if body.shape.fills_bounding_shape() => {
            (0..3).map(|axis| (2.0 * half[axis], Some(axes.col(axis)))).collect()
        }
        BoundingShape::Cuboid { half, .. } => vec![(2.0 * half.max_element(), None)],
    }
}

/// The least size that f32 resolves along a direction, or in any direction: a coordinate x is rounded by u |x|.
fn least_size(search: &Search, body: &Body, direction: Option<DVec3>) -> f64 {
    // If render space has the camera's axes, the depth of an opaque object is not visible. In transmissive ones rays travel in depth too.
    let depth = if search.view.has_camera_axes && !body.role.transmissive { 0.0 } else { 1.0 };
    let position = body.position.abs() * DVec3::new(1.0, 1.0, depth);
    let coordinate = direction.map_or(position.length(), |direction| position.dot(direction.abs()));
    let share = if matches!(body.bounds, BoundingShape::Ball { .. }) { LEAST_RADIUS } else { LEAST_SHARE };
    (share * coordinate).max(LEAST_OF_EXTENT * search.extent)
}

fn unresolved<'a>(body: &Body<'a>, which: usize, size: f64, limit: f64) -> Diagnostic<'a> {
    let names = body.shape.kind().sizes;
    let (name, field) = names.get(which).or(names.last()).copied().unwrap_or_default();
    let message = format!(
        "{name} of {} at a distance of {} from the camera, where f32 resolves no size below {}: make it larger, bring it nearer, or leave it out",
        short(size),
        short(body.position.length()),
        short(limit)
    );
    // The size of a medium is in its boundary.
    let field = if matches!(body.object, Object::Medium { .. }) { "boundary" } else { field };
    Diagnostic { field, ..Diagnostic::of(body.object, message) }
}
