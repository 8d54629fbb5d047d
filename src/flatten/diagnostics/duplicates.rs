//! Finds spheres that coincide, and meshes that are instanced twice at one position.
//!
//! Candidates are neighbours in the order of one number for each object, made of position and radius. The position counts
//! by its component in an oblique direction, because no row of objects has equal components there.

use glam::DVec3;

use super::search::{Body, Search, U, Worst, coincidence};
use crate::shape::BoundingShape;

/// Each object is compared with this number of others, those next in the order.
const TESTS_EACH: usize = 16;
/// The numbers of coincident objects differ by less than this, relative to the sum of the largest coordinate and the
/// radius. The largest of the bounds below is 12 u.
const SLACK: f64 = 16.0 * U;
/// The direction, of length 1, and the weight of the radius.
const DIRECTION: DVec3 = DVec3::new(0.791_328, 0.507_219, 0.341_477);
const RADIUS: f64 = 0.618_034;

pub fn search<'a>(search: &Search<'a>) -> Worst<'a> {
    // The number made of position and radius, and the index of the object.
    let mut order: Vec<(f64, usize)> = Vec::new();
    for (index, body) in search.bodies().enumerate() {
        let is_sphere = body.shape.fills_bounding_shape() && matches!(body.bounds, BoundingShape::Ball { .. });
        if is_sphere || body.shape.mesh().is_some() {
            let (center, radius) = body.bounds.ball();
            order.push((DIRECTION.dot(center) + RADIUS * radius, index));
        }
    }
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut worst = Worst::default();
    for (at, &(along, index)) in order.iter().enumerate() {
        let body = search.body(index);
        let (center, radius) = body.bounds.ball();
        let limit = SLACK * (center.abs().max_element() + radius);
        let near = order[at + 1..].iter().take_while(|(other, _)| other - along <= limit).take(TESTS_EACH);
        let mut near = near.map(|(_, other)| (*other, search.body(*other)));
        let found = near.find_map(|(other, twin)| distance(&body, &twin).map(|distance| (other, twin, distance)));
        if let Some((other, twin, (gap, bound))) = found {
            let (first, second) = if index < other { (&body, &twin) } else { (&twin, &body) };
            worst.add(-(index.max(other) as f64), || coincidence(first, second, gap, bound));
        }
    }
    worst
}

/// The distance of two surfaces and its bound, if the two coincide and this is visible. The bound of a sphere's leaving rays is
/// 4 u (max |c_i| + r), and one step to the next float, 2 u Σ |n_i p_i|, which on the sphere is at most 2 u (|c| + r) (Cauchy-Schwarz;
/// shaders/geometry/sphere, shaders/geometry/offset); the rounding of the radius and of the next distance is 4 u r. At points of a large
/// sphere as far from the nearest one as the camera is, the bound is 14 u of the distance (shaders/geometry/large_sphere).
fn distance(a: &Body, b: &Body) -> Option<(f64, f64)> {
    if a.material == b.material && !a.role.transmissive {
        return None;
    }
    let ((center, r), (other, s)) = (a.bounds.ball(), b.bounds.ball());
    let apart = (r - s).abs() + center.distance(other);
    let of_ball = U * (4.0 * (center.abs().max_element() + r) + 2.0 * (center.length() + r) + 4.0 * r);
    let (gap, bound) = match (a.shape.mesh(), b.shape.mesh()) {
        (None, None) => match a.shape.large_sphere().zip(b.shape.large_sphere()) {
            Some((one, twin)) => (apart, 28.0 * U * one.distance(a.to_world).max(twin.distance(b.to_world))),
            None => (apart, of_ball),
        },
        (Some(one), Some(twin)) if one.number == twin.number => {
            let corners = a.bounds.corners().into_iter().zip(b.bounds.corners());
            (corners.map(|(p, q)| p.distance(q)).fold(0.0, f64::max), of_ball)
        }
        _ => return None,
    };
    (gap <= bound).then_some((gap, bound))
}
