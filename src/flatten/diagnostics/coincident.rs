//! Finds flat surfaces that coincide. If two opaque surfaces of different materials coincide, rounding decides which of them is
//! visible. If one of two coincident surfaces is clear, rays that leave one start behind the other and miss it.
//!
//! The search compares quads and sides of boxes that lie in one plane. It skips opaque sides that face away from the
//! camera, because no camera ray can hit them first: a box may rest on a floor. It skips media, because their
//! boundaries are not surfaces.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::{BY_ROUNDING, Body, Diagnostic, Found, OTHER, Pair, Role, U, Worst, apart, leaving, short};
use crate::shape::{Hull, normal};

/// Each surface in a plane is compared with this number of others, those next to it along an edge.
const TESTS_EACH: usize = 64;
/// The resolution at which components of normals are compared: steps per unit.
const NORMAL_STEPS: f64 = 1e6;
/// The least overlap, as a share of the narrower surface's width. Neighbours that share an edge overlap by less.
const LEAST_OVERLAP: f64 = 1e-5;

/// The plane of a surface.
struct Plane {
    /// Its normal, in steps.
    key: [i32; 3],
    /// From the camera, along the normal.
    distance: f64,
    /// Two planes can matter to each other if their distance is at most the sum of their reaches.
    reach: f64,
    /// The object.
    owner: u32,
    /// The number of the side.
    which: u32,
}

/// A bound of how far rounding moves a surface along its normal. Each coordinate of the position is rounded, and so is
/// the half side of a box.
fn rounding(normal: DVec3, place: DVec3, half: f64) -> f64 {
    2.0 * U * (normal.abs().dot(place.abs()) + half)
}

/// Splits planes that are sorted by normal and distance into runs of one normal: the reach of each plane in a run overlaps
/// that of an earlier one.
fn runs(planes: &[Plane]) -> impl Iterator<Item = &[Plane]> {
    let mut reach = f64::NEG_INFINITY;
    planes.chunk_by(move |one, next| {
        reach = reach.max(one.distance + one.reach);
        let near = one.key == next.key && next.distance - next.reach <= reach;
        if !near {
            reach = f64::NEG_INFINITY;
        }
        near
    })
}

/// A surface in its plane.
struct Side {
    owner: usize,
    /// The normal, with the sign that makes its first non-zero component positive.
    normal: DVec3,
    /// Whether the sign was changed.
    turned: bool,
    key: [i32; 3],
    /// From the camera, along the normal.
    distance: f64,
    rounding: f64,
    /// The offset of rays that leave it.
    leaving: f64,
    /// Whether no camera ray can hit it first: it is a side of a box and faces away from the camera.
    hidden: bool,
    corners: [DVec3; 4],
}

/// A surface in the coordinates of its plane.
struct Patch<'a> {
    side: &'a Side,
    corners: [DVec2; 4],
    low: DVec2,
    high: DVec2,
}

impl Patch<'_> {
    fn new(side: &Side, a: DVec3, b: DVec3) -> Patch<'_> {
        let corners = side.corners.map(|p| DVec2::new(p.dot(a), p.dot(b)));
        let low = corners.iter().fold(corners[0], |low, p| low.min(*p));
        let high = corners.iter().fold(corners[0], |high, p| high.max(*p));
        Patch { side, corners, low, high }
    }
}

/// The kinds of warning about two surfaces in one plane.
#[derive(Clone, Copy)]
enum Touch {
    Overlapping,
    AtGlass,
    ClearOnClear,
    BackToBack,
}

/// The search among flat surfaces, and its findings.
pub struct Planes<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Role],
    /// Whether any object is clear. If so, hidden sides count too, and so does the offset of rays.
    clear: bool,
    planes: Vec<Plane>,
    told: HashSet<(usize, usize)>,
    /// The worst case of each `Touch`.
    worst: [Worst<Pair>; 4],
}

impl<'a> Planes<'a> {
    pub fn new(found: &'a Found<'a>, kinds: &'a [Role]) -> Planes<'a> {
        let clear = found.placed.iter().any(|placed| kinds[placed.material as usize].glass);
        Planes { found, kinds, clear, planes: Vec::new(), told: HashSet::new(), worst: Default::default() }
    }

    pub fn see(&mut self, number: usize, body: &Body) {
        for (which, side) in self.sides(number, body) {
            if self.clear || !side.hidden {
                let reach = if self.clear { side.rounding + side.leaving } else { side.rounding };
                let (key, distance, owner) = (side.key, side.distance, number as u32);
                self.planes.push(Plane { key, distance, reach, owner, which });
            }
        }
    }

    pub fn diagnostics(mut self) -> Vec<Diagnostic> {
        self.search();
        let found = self.found;
        let touches = [Touch::Overlapping, Touch::AtGlass, Touch::ClearOnClear, Touch::BackToBack];
        let told = touches.into_iter().zip(self.worst);
        told.filter_map(|(touch, worst)| worst.diagnostic(|pair| tell(found, touch, &pair))).collect()
    }

    fn search(&mut self) {
        let mut planes = std::mem::take(&mut self.planes);
        planes.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.distance.total_cmp(&b.distance)));
        for run in runs(&planes) {
            if self.may_differ(run) {
                let sides: Vec<Side> = run.iter().filter_map(|plane| self.side(plane)).collect();
                self.compare(&sides);
            }
        }
    }

    /// Whether the surfaces may include two whose coincidence is visible. Only the materials are compared.
    fn may_differ(&self, run: &[Plane]) -> bool {
        let material = |plane: &Plane| self.found.placed[plane.owner as usize].material;
        let [first, rest @ ..] = run else { return false };
        let kind = self.kinds[material(first) as usize];
        !rest.is_empty()
            && (kind.one_sided || kind.glass || rest.iter().any(|other| material(other) != material(first)))
    }

    fn side(&self, plane: &Plane) -> Option<Side> {
        let owner = plane.owner as usize;
        let placed = &self.found.placed[owner];
        let body = Body::new(self.found, &placed.shape, &placed.to_world);
        self.sides(owner, &body).find(|(which, _)| *which == plane.which).map(|(_, side)| side)
    }

    /// The flat surfaces of a shape, with their numbers.
    fn sides(&self, owner: usize, body: &Body) -> impl Iterator<Item = (u32, Side)> + use<> {
        let light = self.kinds[self.found.placed[owner].material as usize].light;
        let (hull, place) = (body.hull, body.place);
        let count = match hull {
            Hull::Parallelogram { .. } if body.shape.is_hull() => 1,
            Hull::Cuboid { .. } if body.shape.is_hull() => 6,
            _ => 0,
        };
        (0..count).filter_map(move |which: u32| {
            let (normal, corners, hidden, rounding, leaving) = match hull {
                Hull::Ball { .. } => return None,
                Hull::Parallelogram { u, v, .. } => {
                    let n = normal(u, v);
                    let corners = [place, place + u, place + u + v, place + v];
                    (n, corners, false, rounding(n, place, 0.0), leaving::from_quad(n, place, u, v))
                }
                Hull::Cuboid { half, axes, .. } => {
                    let axis = (which / 2) as usize;
                    let sign = if which.is_multiple_of(2) { 1.0 } else { -1.0 };
                    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                    let normal = sign * axes.col(axis);
                    let middle = place + half[axis] * normal;
                    let (b, c) = (half[b] * axes.col(b), half[c] * axes.col(c));
                    let inside = ((axes.transpose() * place).abs() - half).max_element() < 0.0;
                    let hidden = !inside && normal.dot(middle) >= 0.0;
                    let corners = [middle - b - c, middle + b - c, middle + b + c, middle - b + c];
                    let leaving = leaving::from_cuboid(normal, place, half, &axes);
                    (normal, corners, hidden, rounding(normal, place, half[axis]), leaving)
                }
            };
            let key = steps(normal);
            let turned = key.into_iter().find(|step| *step != 0)? < 0;
            let (normal, key) = if turned { (-normal, steps(-normal)) } else { (normal, key) };
            let distance = normal.dot(corners[0]);
            // No ray starts at a light.
            let leaving = if light { 0.0 } else { leaving };
            Some((which, Side { owner, normal, turned, key, distance, rounding, leaving, hidden, corners }))
        })
    }

    /// Compares surfaces in parallel planes whose distances are within the rounding.
    fn compare(&mut self, sides: &[Side]) {
        let normal = sides[0].normal;
        let a = (sides[0].corners[1] - sides[0].corners[0]).normalize_or_zero();
        let b = normal.cross(a);
        let mut patches: Vec<Patch> = sides.iter().map(|side| Patch::new(side, a, b)).collect();
        patches.sort_unstable_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.low.y.total_cmp(&b.low.y)));
        for (at, one) in patches.iter().enumerate() {
            let beside = patches[at + 1..].iter().take_while(|other| other.low.x < one.high.x);
            for other in beside.take(TESTS_EACH) {
                self.test(one, other);
            }
        }
    }

    fn test(&mut self, one: &Patch, other: &Patch) {
        if one.low.max(other.low).cmpge(one.high.min(other.high)).any() {
            return;
        }
        let (first, second) = if one.side.owner < other.side.owner { (one, other) } else { (other, one) };
        let (a, b) = (first.side, second.side);
        let [material_a, material_b] = [a, b].map(|side| self.found.placed[side.owner].material);
        let [glass_a, glass_b] = [material_a, material_b].map(|material| self.kinds[material as usize].glass);
        let clear = glass_a || glass_b;
        let same = material_a == material_b;
        let opposed = same && a.turned != b.turned && self.kinds[material_a as usize].one_sided;
        let gap = (a.distance - b.distance).abs();
        // With a clear surface, rays that leave either one can start behind the other.
        let bound = a.rounding + b.rounding + if clear { a.leaving.max(b.leaving) } else { 0.0 };
        let shows = clear || (!same || opposed) && !a.hidden && !b.hidden;
        if a.owner == b.owner || gap > bound || !shows || !overlap(first, second) {
            return;
        }
        let touch = match (glass_a, glass_b, opposed) {
            (true, true, _) => Touch::ClearOnClear,
            (true, ..) | (_, true, _) => Touch::AtGlass,
            (.., true) => Touch::BackToBack,
            (.., false) => Touch::Overlapping,
        };
        let kind = &mut self.worst[touch as usize];
        if self.told.insert((a.owner, b.owner)) {
            return kind.note(-(b.owner as f64), Pair { first: a.owner, second: b.owner, gap, bound });
        }
        // If several sides of two boxes coincide, the warning names the largest bound: it separates all of them.
        if let Some((_, pair)) = &mut kind.worst
            && (pair.first, pair.second) == (a.owner, b.owner)
        {
            pair.bound = pair.bound.max(bound);
        }
    }
}

/// The components of a normal, rounded to steps. Those of -n are the negatives of those of n.
fn steps(normal: DVec3) -> [i32; 3] {
    normal.to_array().map(|x| ((x.abs() * NORMAL_STEPS + 0.5) as i32) * if x < 0.0 { -1 } else { 1 })
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

fn tell(found: &Found, touch: Touch, pair: &Pair) -> Diagnostic {
    let Pair { first, second, gap, bound } = *pair;
    let is_transmissive =
        |number: usize| found.scene.materials[found.placed[number].material as usize].1.kind().is_transmissive;
    // The warning points at the clear object, if only one of them is clear.
    let (at, other) =
        if is_transmissive(first) && !is_transmissive(second) { (first, second) } else { (second, first) };
    let word = found.placed[other].shape.kind().word;
    let (away, limit) = (apart(gap, bound, is_transmissive(at)), short(bound));
    let message = match touch {
        Touch::Overlapping => format!(
            "its surface overlaps with the {word} at {OTHER}, which has another material and {away}: {BY_ROUNDING}: set them more than \
             {limit} apart, or cut a hole in one"
        ),
        Touch::AtGlass => format!(
            "this glass touches the {word} at {OTHER}, which {away}: rays that leave one of the two there start behind the other and \
             miss it: let one reach into the other, or set them more than {limit} apart"
        ),
        Touch::ClearOnClear => format!(
            "this glass touches the {word} at {OTHER}, which is also clear and {away}: rays miss one of the two surfaces: set them \
             more than {limit} apart, or make them one solid if they have one material"
        ),
        Touch::BackToBack => format!(
            "this light emits to one side and lies back to back with the light at {OTHER}, which {away}: rays that hit the back of \
             the other light get no light: set them more than {limit} apart, or replace them by one light that is two_sided"
        ),
    };
    Diagnostic::of_two(at, other, message)
}
