//! Finds flat surfaces that coincide. If two opaque surfaces of different materials coincide, rounding decides which of them is
//! visible. If one of two coincident surfaces is clear, rays that leave one start behind the other and miss it.
//!
//! The search compares quads and sides of boxes that lie in one plane. It skips opaque sides that face away from the
//! camera, because no camera ray can hit them first: a box may rest on a floor. It skips media, because their
//! boundaries are not surfaces. In crowded planes the number of comparisons is limited, in proportion to the number of
//! surfaces.

use std::collections::HashSet;

use glam::{DVec2, DVec3};

use super::repeated::{Repeated, hash};
use super::{At, BY_ROUNDING, Body, Diagnostic, Found, OTHER, Role, U, Worst, apart, leaving, short};
use crate::shape::{Hull, normal};

/// The limit on comparisons in a plane: the first number for each surface, and the second for the whole plane.
const TESTS_EACH: usize = 16;
const TESTS_MORE: usize = 1000;
/// The search looks at this many surfaces, and one more for each 16 objects. It takes the planes nearest to the camera first.
const MOST_SIDES: usize = 1 << 14;
/// Up to this number of surfaces in a plane, all pairs are compared.
const FEW: usize = 24;
/// The most cells of the grid over a plane that one surface is entered in. Larger surfaces are compared with all others.
const MOST_CELLS: usize = 64;
/// The resolution at which components of normals are compared: steps per unit.
const NORMAL_STEPS: f64 = 1e6;
/// The least overlap, as a share of the narrower surface's width. Neighbours that share an edge overlap by less.
const LEAST_OVERLAP: f64 = 1e-5;
/// More than the sides of any shape. Sides are numbered below it.
const SIDES: u32 = 8;

/// Two objects that coincide, in the order of the file.
struct PlanePair {
    first: usize,
    second: usize,
    gap: f64,
    /// The largest gap that causes a warning.
    bound: f64,
}

/// The plane of a surface.
#[derive(Clone, Copy)]
struct Plane {
    /// The bits of its distance from the camera, in units of the scene's extent, as f32. Bits of positive floats sort
    /// like the floats.
    bits: u32,
    /// Two planes can matter to each other if their distance is at most the sum of their reaches. In units of the scene's extent.
    reach: f32,
    /// A hash of its normal.
    normal: u32,
    /// The number of the object times `SIDES`, plus the number of the side.
    side: u32,
}

impl Plane {
    /// `distance` is along the normal from the camera. It and `reach` are in units of the scene's extent.
    fn new(distance: f64, normal: u32, reach: f64, side: u32) -> Plane {
        // Half an ulp more: the distance is rounded to f32.
        let reach = reach + U * distance.abs();
        Plane { bits: (distance.abs() as f32).to_bits(), reach: reach as f32 * (1.0 + f32::EPSILON), normal, side }
    }

    fn distance(&self) -> f32 {
        f32::from_bits(self.bits)
    }
}

/// A hash of a normal, equal for n and -n.
fn hash_of(normal: DVec3) -> u32 {
    hash(steps(normal.abs()).map(|step| step as u32))
}

/// A bound of how far rounding moves a surface along its normal. Each coordinate of the position is rounded, and so is
/// the half side of a box.
fn rounding(normal: DVec3, place: DVec3, half: f64) -> f64 {
    2.0 * U * (normal.abs().dot(place.abs()) + half)
}

/// Splits planes that are sorted by distance into runs: the reach of each plane in a run overlaps that of an earlier one.
fn runs(planes: &[Plane]) -> impl Iterator<Item = &[Plane]> {
    let mut rest = planes;
    std::iter::from_fn(move || {
        let first = rest.first()?;
        let mut reach = first.distance() + first.reach;
        let more = rest[1..].iter().take_while(|plane| {
            let near = plane.distance() - plane.reach <= reach;
            reach = reach.max(plane.distance() + plane.reach);
            near
        });
        let (run, after) = rest.split_at(1 + more.count());
        rest = after;
        Some(run)
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

/// The search among flat surfaces, and its findings.
pub struct Planes<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Role],
    /// Whether any object is clear. If so, hidden sides count too, and so does the offset of rays.
    clear: bool,
    planes: Vec<Plane>,
    told: HashSet<(usize, usize)>,
    overlapping: Worst<PlanePair>,
    at_glass: Worst<PlanePair>,
    clear_on_clear: Worst<PlanePair>,
    back_to_back: Worst<PlanePair>,
}

impl<'a> Planes<'a> {
    pub fn new(found: &'a Found<'a>, kinds: &'a [Role]) -> Planes<'a> {
        Planes {
            found,
            kinds,
            clear: found.placed.iter().any(|placed| kinds[placed.material as usize].glass),
            planes: Vec::new(),
            told: HashSet::new(),
            overlapping: Worst::default(),
            at_glass: Worst::default(),
            clear_on_clear: Worst::default(),
            back_to_back: Worst::default(),
        }
    }

    pub fn see(&mut self, number: usize, body: &Body) {
        let share = 1.0 / self.found.extent;
        for (which, side) in self.sides(number, body) {
            if self.clear || !side.hidden {
                let reach = share * if self.clear { side.rounding + side.leaving } else { side.rounding };
                let normal = hash_of(side.normal);
                self.planes.push(Plane::new(share * side.distance, normal, reach, number as u32 * SIDES + which));
            }
        }
    }

    pub fn diagnostics(mut self) -> Vec<Diagnostic> {
        self.search();
        let found = self.found;
        let flat = self.overlapping.diagnostic(|pair| tell_overlapping(found, &pair));
        let glass = self.at_glass.diagnostic(|pair| tell_at_glass(found, &pair));
        let clear = self.clear_on_clear.diagnostic(|pair| tell_clear_on_clear(found, &pair));
        let lost = self.back_to_back.diagnostic(|pair| tell_back_to_back(&pair));
        [flat, glass, clear, lost].into_iter().flatten().collect()
    }

    fn search(&mut self) {
        let mut planes = std::mem::take(&mut self.planes);
        let again = Repeated::new(planes.iter().map(|plane| plane.normal));
        planes.retain(|plane| again.holds(plane.normal));
        planes.sort_unstable_by_key(|plane| plane.bits);
        let mut left = MOST_SIDES + self.found.placed.len() / 16;
        let mut sides: Vec<Side> = Vec::new();
        for run in runs(&planes) {
            if !self.may_differ(run) {
                continue;
            }
            let Some(after) = left.checked_sub(run.len()) else { break };
            left = after;
            sides.clear();
            sides.extend(run.iter().filter_map(|plane| self.side(plane)));
            sides.sort_unstable_by_key(|side| side.key);
            for parallel in sides.chunk_by(|a, b| a.key == b.key).filter(|parallel| parallel.len() > 1) {
                self.compare(parallel);
            }
        }
    }

    /// Whether the surfaces may include two parallel ones whose coincidence is visible. Exact for two surfaces; for
    /// more, only the materials are compared.
    fn may_differ(&self, run: &[Plane]) -> bool {
        let differ = |a: &Plane, b: &Plane| {
            let [of_a, of_b] = [a, b].map(|plane| self.found.placed[(plane.side / SIDES) as usize].material);
            of_a != of_b || self.kinds[of_a as usize].one_sided || self.kinds[of_a as usize].glass
        };
        match run {
            [] | [_] => false,
            [a, b] => a.normal == b.normal && differ(a, b),
            [first, rest @ ..] => rest.iter().any(|other| differ(first, other)),
        }
    }

    fn side(&self, plane: &Plane) -> Option<Side> {
        let owner = (plane.side / SIDES) as usize;
        let placed = &self.found.placed[owner];
        let body = Body::new(self.found, &placed.shape, &placed.to_world);
        self.sides(owner, &body).find(|(which, _)| *which == plane.side % SIDES).map(|(_, side)| side)
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
        let patches: Vec<Patch> = sides.iter().map(|side| Patch::new(side, a, b)).collect();
        let mut tests = TESTS_EACH * patches.len() + TESTS_MORE;
        if patches.len() <= FEW {
            return self.compare_all(patches.iter(), &mut tests);
        }
        let low = patches.iter().fold(patches[0].low, |low, patch| low.min(patch.low));
        let high = patches.iter().fold(patches[0].high, |high, patch| high.max(patch.high));
        let cells = (patches.len() as f64).sqrt().ceil();
        let cell = ((high - low) / cells).max(DVec2::splat(f64::MIN_POSITIVE));
        let cell_of = |p: DVec2| ((p - low) / cell).floor().clamp(DVec2::ZERO, DVec2::splat(cells - 1.0)).as_uvec2();
        let mut filed: Vec<(u64, u32)> = Vec::new();
        let mut large = Vec::new();
        for (number, patch) in (0..).zip(&patches) {
            // Neighbours that only share an edge need not share a cell.
            let inset = LEAST_OVERLAP * (patch.high - patch.low);
            let (from, to) = (cell_of(patch.low + inset), cell_of(patch.high - inset));
            if (to.x - from.x + 1) as usize * (to.y - from.y + 1) as usize > MOST_CELLS {
                large.push(patch);
                continue;
            }
            for y in from.y..=to.y {
                filed.extend((from.x..=to.x).map(|x| (u64::from(y) << 32 | u64::from(x), number)));
            }
        }
        for one in large {
            for other in patches.iter().take(tests) {
                self.test(one, other);
            }
            tests = tests.saturating_sub(patches.len());
        }
        filed.sort_unstable();
        for together in filed.chunk_by(|a, b| a.0 == b.0) {
            self.compare_all(together.iter().map(|(_, number)| &patches[*number as usize]), &mut tests);
        }
    }

    fn compare_all<'p>(&mut self, patches: impl Iterator<Item = &'p Patch<'p>> + Clone, tests: &mut usize) {
        let mut rest = patches;
        while let Some(one) = rest.next() {
            for other in rest.clone() {
                if *tests == 0 {
                    return;
                }
                *tests -= 1;
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
        let kind = match (glass_a, glass_b, opposed) {
            (true, true, _) => &mut self.clear_on_clear,
            (true, ..) | (_, true, _) => &mut self.at_glass,
            (.., true) => &mut self.back_to_back,
            (.., false) => &mut self.overlapping,
        };
        if self.told.insert((a.owner, b.owner)) {
            return kind.note(-(b.owner as f64), PlanePair { first: a.owner, second: b.owner, gap, bound });
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

fn tell_overlapping(found: &Found, pair: &PlanePair) -> Diagnostic {
    let message = format!(
        "its surface overlaps with the {} at {OTHER}, which has another material and {}: {BY_ROUNDING}: set them more than {} apart, or \
         cut a hole in one",
        found.placed[pair.first].shape.kind().word,
        apart(pair.gap, pair.bound, false),
        short(pair.bound)
    );
    Diagnostic { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}

/// The warning points at the clear object.
fn tell_at_glass(found: &Found, pair: &PlanePair) -> Diagnostic {
    let is_clear = |number: usize| found.scene.materials[found.placed[number].material as usize].1.kind().is_clear;
    let (clear, other) = match is_clear(pair.first) {
        true => (pair.first, pair.second),
        false => (pair.second, pair.first),
    };
    let message = format!(
        "this glass touches the {} at {OTHER}, which {}: rays that leave one of the two there start behind the other and miss it: let \
         one reach into the other, or set them more than {} apart",
        found.placed[other].shape.kind().word,
        apart(pair.gap, pair.bound, true),
        short(pair.bound)
    );
    Diagnostic { at: At::Primitive(clear), field: "", message, other: Some(At::Primitive(other)), more: 0 }
}

fn tell_clear_on_clear(found: &Found, pair: &PlanePair) -> Diagnostic {
    let message = format!(
        "this glass touches the {} at {OTHER}, which is also clear and {}: rays miss one of the two surfaces: set them more than {} apart, \
         or make them one solid if they have one material",
        found.placed[pair.first].shape.kind().word,
        apart(pair.gap, pair.bound, true),
        short(pair.bound)
    );
    Diagnostic { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}

fn tell_back_to_back(pair: &PlanePair) -> Diagnostic {
    let message = format!(
        "this light emits to one side and lies back to back with the light at {OTHER}, which {}: rays that hit the back of the other \
         light get no light: set them more than {} apart, or replace them by one light that is two_sided",
        apart(pair.gap, pair.bound, false),
        short(pair.bound)
    );
    Diagnostic { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}
