//! Finds flat surfaces that coincide: quads, disks, and sides of boxes, in one plane. Rounding decides which of two opaque ones is
//! visible. If one of the two is transmissive, rays that leave one start behind the other and miss it.
//!
//! Opaque sides that face away from the camera do not count, because no camera ray hits them first: a box may rest on a
//! floor. Nor do media, because their boundaries are not surfaces.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::search::{Body, Search, U, Worst, coincidence};
use crate::shape::{BoundingShape, half_extent_of, normal};

/// Each surface in a plane is compared with this number of others, those next to it along an edge.
const TESTS_EACH: usize = 64;
/// The resolution at which components of normals are compared: steps per unit.
const NORMAL_STEPS: f64 = 1e6;
/// The least overlap, as a share of the narrower surface's width. Neighbours that share an edge overlap by less.
const LEAST_OVERLAP: f64 = 1e-5;

/// A flat surface.
struct Side {
    /// The index of the object.
    owner: usize,
    /// The normal, in steps, with the sign that makes its first component that is not 0 positive.
    key: [i32; 3],
    /// From the camera, along the normal.
    distance: f64,
    /// A bound of how far rounding moves it along its normal.
    rounding: f64,
    /// The offset along the normal of rays that leave it.
    leaving: f64,
    /// Whether no camera ray can hit it first: it is a side of a box and faces away from the camera.
    hidden: bool,
    corners: [DVec3; 4],
}

impl Side {
    /// A side of a body. `half` is how far the rounding of its size moves it, and `size_part` the part of the kernels' bound by its size
    /// (shaders/geometry/quad, cuboid). The other part is 2 u of the position. The step to the next float is at most 2 u of each
    /// coordinate (shaders/geometry/offset).
    fn new(owner: usize, body: &Body, normal: DVec3, corners: [DVec3; 4], half: f64, size_part: DVec3) -> Option<Side> {
        let steps = normal.to_array().map(|x| (x * NORMAL_STEPS).round() as i32);
        let sign = steps.into_iter().find(|step| *step != 0)?.signum();
        let bound = normal.abs().dot(4.0 * body.position.abs() + size_part);
        Some(Side {
            owner,
            key: steps.map(|step| sign * step),
            distance: f64::from(sign) * normal.dot(corners[0]),
            rounding: 2.0 * U * (normal.abs().dot(body.position.abs()) + half),
            // No ray starts at a light.
            leaving: if body.role.light { 0.0 } else { U * bound },
            hidden: false,
            corners,
        })
    }

    /// The largest distance at which another surface can coincide with it.
    fn range(&self) -> f64 {
        self.rounding + self.leaving
    }
}

/// The flat surfaces of a shape.
fn sides(owner: usize, body: &Body) -> Vec<Side> {
    if !body.shape.fills_bounding_shape() {
        return Vec::new();
    }
    match body.bounds {
        BoundingShape::Ball { .. } => Vec::new(),
        BoundingShape::Parallelogram { corner, u, v } => {
            let margin = 0.5 * (1.0 - body.shape.kind().covered);
            let [low, high] = [margin, 1.0 - margin];
            let at = |a: f64, b: f64| corner + a * u + b * v;
            let corners = [at(low, low), at(high, low), at(high, high), at(low, high)];
            Side::new(owner, body, normal(u, v), corners, 0.0, 12.0 * (u.abs() + v.abs())).into_iter().collect()
        }
        BoundingShape::Cuboid { center, half, axes } => {
            let is_inside = ((axes.transpose() * center).abs() - half).max_element() < 0.0;
            let side = |axis: usize, sign: f64| {
                let normal = sign * axes.col(axis);
                let middle = center + half[axis] * normal;
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                let (b, c) = (half[b] * axes.col(b), half[c] * axes.col(c));
                let corners = [middle - b - c, middle + b - c, middle + b + c, middle - b + c];
                let side = Side::new(owner, body, normal, corners, half[axis], 14.0 * half_extent_of(half, &axes))?;
                Some(Side { hidden: !is_inside && normal.dot(middle) >= 0.0, ..side })
            };
            (0..3).flat_map(|axis| [side(axis, 1.0), side(axis, -1.0)]).flatten().collect()
        }
    }
}

/// The warnings about opaque surfaces and about transmissive ones.
pub fn search<'a>(search: &Search<'a>) -> [Worst<'a>; 2] {
    // Hidden sides are seen through transmissive objects alone.
    let sees_all =
        search.finder.primitives.iter().any(|primitive| search.roles[primitive.material as usize].transmissive);
    let all = search.bodies().enumerate().flat_map(|(number, body)| sides(number, &body));
    let mut all: Vec<Side> = all.filter(|side| sees_all || !side.hidden).collect();
    all.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.distance.total_cmp(&b.distance)));
    // Runs of one normal in which each surface is near to an earlier one.
    let mut far = f64::NEG_INFINITY;
    let runs = all.chunk_by(|one, next| {
        far = far.max(one.distance + one.range());
        let is_near = one.key == next.key && next.distance - next.range() <= far;
        if !is_near {
            far = f64::NEG_INFINITY;
        }
        is_near
    });
    let mut pairs = Pairs { search, known: HashSet::new(), worst: Default::default() };
    runs.filter(|run| run.len() > 1).for_each(|run| pairs.compare(run));
    pairs.worst
}

/// A surface in the coordinates of its plane.
struct Patch<'a> {
    side: &'a Side,
    corners: [DVec2; 4],
    low: DVec2,
    high: DVec2,
}

/// The pairs of coincident surfaces.
struct Pairs<'s, 'a> {
    search: &'s Search<'a>,
    /// The pairs of objects that are counted.
    known: HashSet<(usize, usize)>,
    /// The worst pair of opaque surfaces, and the worst with a transmissive one.
    worst: [Worst<'a>; 2],
}

impl Pairs<'_, '_> {
    /// Compares surfaces in parallel planes whose distances are within the rounding.
    fn compare(&mut self, sides: &[Side]) {
        let [p, q, _, s] = sides[0].corners;
        let x = (q - p).normalize_or_zero();
        let y = normal(q - p, s - p).cross(x);
        let patches = sides.iter().map(|side| {
            let corners = side.corners.map(|p| DVec2::new(p.dot(x), p.dot(y)));
            let low = corners.iter().fold(corners[0], |low, p| low.min(*p));
            let high = corners.iter().fold(corners[0], |high, p| high.max(*p));
            Patch { side, corners, low, high }
        });
        let mut patches: Vec<Patch> = patches.collect();
        patches.sort_unstable_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.low.y.total_cmp(&b.low.y)));
        for (at, one) in patches.iter().enumerate() {
            let next = patches[at + 1..].iter().take_while(|other| other.low.x < one.high.x);
            next.take(TESTS_EACH).for_each(|other| self.test(one, other));
        }
    }

    fn test(&mut self, one: &Patch, other: &Patch) {
        if one.low.max(other.low).cmpge(one.high.min(other.high)).any() {
            return;
        }
        let (a, b) = if one.side.owner < other.side.owner { (one.side, other.side) } else { (other.side, one.side) };
        let primitives = &self.search.finder.primitives;
        let materials = [a, b].map(|side| primitives[side.owner].material);
        let is_transmissive = materials.iter().any(|material| self.search.roles[*material as usize].transmissive);
        let gap = (a.distance - b.distance).abs();
        // With a transmissive surface, rays that leave either one can start behind the other.
        let bound = a.rounding + b.rounding + if is_transmissive { a.leaving.max(b.leaving) } else { 0.0 };
        let shows = is_transmissive || materials[0] != materials[1] && !a.hidden && !b.hidden;
        if a.owner == b.owner || gap > bound || !shows || !overlap(one, other) {
            return;
        }
        let worst = &mut self.worst[usize::from(is_transmissive)];
        worst.count += usize::from(self.known.insert((a.owner, b.owner)));
        let bodies = [a, b].map(|side| self.search.body(side.owner));
        worst.offer(bound, || coincidence(&bodies[0], &bodies[1], gap, bound));
    }
}

/// Whether two parallelograms in a plane overlap in an area: no line parallel to an edge separates them (separating axis theorem).
fn overlap(one: &Patch, other: &Patch) -> bool {
    let edges = [one, other].map(|patch| {
        let [p, q, _, s] = patch.corners;
        [q - p, s - p]
    });
    edges.as_flattened().iter().all(|edge| {
        let across = edge.perp().normalize_or_zero();
        let extent = |patch: &Patch| {
            let along = patch.corners.map(|p| p.dot(across));
            (along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((low, high), (other_low, other_high)) = (extent(one), extent(other));
        let shared = high.min(other_high) - low.max(other_low);
        let width = (high - low).min(other_high - other_low);
        let largest = low.abs().max(high.abs()).max(other_low.abs()).max(other_high.abs());
        shared > LEAST_OVERLAP * width + 8.0 * U * largest
    })
}
