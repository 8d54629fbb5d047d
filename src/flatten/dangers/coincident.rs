//! Surfaces that coincide within rounding and have different materials: which of them is seen is left to rounding.
//!
//! Looked for among concentric spheres, and among quads and sides of boxes in one plane. What no ray from the camera can meet
//! first is left out: a box may rest on a floor. So are media, whose boundaries are no surfaces. In crowded planes the search ends after a
//! number of comparisons in proportion to what lies there.

use std::collections::HashSet;

use glam::{DVec2, DVec3, Vec3};

use super::{At, Body, Danger, Found, Kind, OTHER, U, Worst, name, normal, short};
use crate::flatten::place::Shape;

/// Comparisons a surface in a plane, and for all of a plane.
const TESTS_EACH: usize = 16;
const TESTS_MORE: usize = 1000;
/// So many surfaces are looked at, and one more for each 16 objects: those in the planes nearest to the camera.
const MOST_SIDES: usize = 1 << 14;
/// So many surfaces in a plane are compared one by one.
const FEW: usize = 24;
/// Cells of the grid over a plane that a surface is filed in at most; larger ones are compared with all others.
const MOST_CELLS: usize = 64;
/// Components of normals are compared in so many steps.
const NORMAL_STEPS: f64 = 1e6;
/// The share of their width by which surfaces overlap at least, lest neighbours count.
const LEAST_OVERLAP: f64 = 1e-5;
/// The number of a quad's only side; those of a box are 0 to 5.
const QUAD: u32 = 6;
const SIDES: u32 = 8;

/// Two objects that coincide, the first in the file first.
struct Pair {
    first: usize,
    second: usize,
    gap: f64,
    rounding: f64,
}

/// Spheres about one centre.
pub struct Spheres<'a> {
    found: &'a Found<'a>,
    /// A number made of each centre, and the sphere.
    centers: Vec<(u32, u32)>,
}

impl<'a> Spheres<'a> {
    pub fn new(found: &'a Found<'a>) -> Spheres<'a> {
        Spheres { found, centers: Vec::new() }
    }

    pub fn see(&mut self, number: usize, body: &Body) {
        if let Shape::Sphere { .. } = body.shape {
            let center = ((body.place / self.found.extent).as_vec3() + Vec3::ZERO).to_array().map(f32::to_bits);
            self.centers.push((hash(center), number as u32));
        }
    }

    /// Those whose radii differ by less than rounding.
    pub fn danger(mut self) -> Option<Danger> {
        let found = self.found;
        let again = Repeated::new(self.centers.iter().map(|(hash, _)| *hash));
        self.centers.retain(|(hash, _)| again.holds(*hash));
        self.centers.sort_unstable();
        let mut worst = Worst::default();
        for group in self.centers.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            let mut shells: Vec<(f64, usize, DVec3)> = Vec::with_capacity(group.len());
            for &(_, number) in group {
                let placed = &found.placed[number as usize];
                let body = Body::new(found, &placed.shape, &placed.to_world);
                shells.push((body.ball(found).1, number as usize, body.place));
            }
            shells.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for pair in shells.windows(2) {
                let &[(r, a, c), (s, b, other)] = pair else { continue };
                let rounding = 4.0 * U * (c.abs().max_element() + r);
                let same = found.placed[a].material == found.placed[b].material;
                if s - r <= rounding && !same && c.distance(other) <= rounding {
                    let (first, second) = (a.min(b), a.max(b));
                    worst.note(-(second as f64), Pair { first, second, gap: s - r, rounding });
                }
            }
        }
        worst.danger(|pair| tell_spheres(&pair))
    }
}

/// A number in which all bits of others are mixed.
fn hash<const N: usize>(words: [u32; N]) -> u32 {
    let mix = |hash: u64, word: u32| (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    (words.into_iter().fold(0, mix) >> 32) as u32
}

/// Which hashes occur more than once, and a few that do not.
struct Repeated {
    twice: Vec<u64>,
    shift: u32,
}

impl Repeated {
    fn new(hashes: impl ExactSizeIterator<Item = u32>) -> Repeated {
        let bits = (hashes.len() * 16).next_power_of_two().clamp(1 << 6, 1 << 26);
        let shift = u32::BITS - bits.trailing_zeros();
        let mut once = vec![0u64; bits / 64];
        let mut twice = vec![0u64; bits / 64];
        for hash in hashes {
            let (word, bit) = Repeated::place(hash, shift);
            twice[word] |= once[word] & bit;
            once[word] |= bit;
        }
        Repeated { twice, shift }
    }

    fn place(hash: u32, shift: u32) -> (usize, u64) {
        let place = hash >> shift;
        ((place / 64) as usize, 1 << (place % 64))
    }

    fn holds(&self, hash: u32) -> bool {
        let (word, bit) = Repeated::place(hash, self.shift);
        self.twice[word] & bit != 0
    }
}

/// A plane that a surface lies in.
#[derive(Clone, Copy)]
struct Plane {
    /// Of its distance from the camera in extents of the scene, as f32; they have its order.
    bits: u32,
    /// How far rounding may move it, in extents.
    rounding: f32,
    /// A number made of its normal.
    normal: u32,
    /// Number of the object times `SIDES`, and the side.
    side: u32,
}

/// What parallel sides have in common.
struct Tilt {
    rounding: f32,
    normal: u32,
}

impl Tilt {
    /// Each coordinate of the place is rounded, and half of a box; both in extents of the scene.
    fn new(normal: DVec3, place: DVec3, half: f64) -> Tilt {
        let rounding = 2.0 * U * (normal.abs().dot(place.abs()) + half);
        Tilt { rounding: rounding as f32, normal: hash(steps(normal.abs()).map(|step| step as u32)) }
    }
}

impl Plane {
    fn new(distance: f64, tilt: &Tilt, side: u32) -> Plane {
        let bits = (distance.abs() as f32).to_bits();
        Plane { bits, rounding: tilt.rounding, normal: tilt.normal, side }
    }

    fn distance(&self) -> f32 {
        f32::from_bits(self.bits)
    }

    /// Whether both are as far from the camera, within rounding: theirs, and that of the distances here.
    fn is_near(&self, other: &Plane) -> bool {
        let here = 2.0 * f32::EPSILON * other.distance();
        other.distance() - self.distance() <= self.rounding + other.rounding + here
    }
}

/// A surface in its plane.
struct Side {
    owner: usize,
    /// The normal, turned so that its first component that is not zero is positive.
    normal: DVec3,
    /// Whether it was turned.
    turned: bool,
    key: [i32; 3],
    /// Along the normal.
    distance: f64,
    rounding: f64,
    /// Whether only rays within the glass that it bounds can meet it.
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

/// The search among what is flat, and what it finds.
pub struct Planes<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Kind],
    planes: Vec<Plane>,
    told: HashSet<(usize, usize)>,
    overlapping: Worst<Pair>,
    under_glass: Worst<Pair>,
    back_to_back: Worst<Pair>,
}

impl<'a> Planes<'a> {
    pub fn new(found: &'a Found<'a>, kinds: &'a [Kind]) -> Planes<'a> {
        Planes {
            found,
            kinds,
            planes: Vec::new(),
            told: HashSet::new(),
            overlapping: Worst::default(),
            under_glass: Worst::default(),
            back_to_back: Worst::default(),
        }
    }

    pub fn see(&mut self, number: usize, body: &Body, kind: Kind) {
        let place = body.place;
        let share = 1.0 / self.found.extent;
        match *body.shape {
            Shape::Quad { u, v, .. } => {
                let (u, v) = body.edges(u, v);
                let n = normal(u, v);
                let tilt = Tilt::new(n, share * place, 0.0);
                self.planes.push(Plane::new(share * n.dot(place), &tilt, number as u32 * SIDES + QUAD));
            }
            Shape::Cuboid { .. } => {
                if self.planes.is_empty() {
                    // Three sides are seen of most.
                    self.planes.reserve(3 * self.found.placed.len());
                }
                let half = body.half_sides(self.found).unwrap_or_default();
                let axes = body.to_world.rotation;
                let middle = axes.transpose() * place;
                let inside = (middle.abs() - half).max_element() < 0.0;
                for axis in 0..3 {
                    let tilt = Tilt::new(axes.col(axis), share * place, share * half[axis]);
                    for (low, outward) in [(0, middle[axis] + half[axis]), (1, half[axis] - middle[axis])] {
                        if kind.glass || inside || outward < 0.0 {
                            let side = number as u32 * SIDES + 2 * axis as u32 + low;
                            self.planes.push(Plane::new(share * outward, &tilt, side));
                        }
                    }
                }
            }
            Shape::Sphere { .. } | Shape::Mesh(_) => {}
        }
    }

    pub fn dangers(mut self) -> Vec<Danger> {
        self.search();
        let found = self.found;
        let flat = self.overlapping.danger(|pair| tell_overlapping(found, &pair));
        let glass = self.under_glass.danger(|pair| tell_under_glass(found, &pair));
        let lost = self.back_to_back.danger(|pair| tell_back_to_back(&pair));
        [flat, glass, lost].into_iter().flatten().collect()
    }

    fn search(&mut self) {
        let mut planes = std::mem::take(&mut self.planes);
        let again = Repeated::new(planes.iter().map(|plane| plane.normal));
        planes.retain(|plane| again.holds(plane.normal));
        planes.sort_unstable_by_key(|plane| plane.bits);
        let mut left = MOST_SIDES + self.found.placed.len() / 16;
        let mut sides: Vec<Side> = Vec::new();
        for run in planes.chunk_by(Plane::is_near) {
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

    /// Whether among surfaces there are parallel ones of different materials; of many, it may be so.
    fn may_differ(&self, run: &[Plane]) -> bool {
        let differ = |a: &Plane, b: &Plane| {
            let [of_a, of_b] = [a, b].map(|plane| self.found.placed[(plane.side / SIDES) as usize].material);
            of_a != of_b || self.kinds[of_a as usize].one_sided
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
        let (normal, corners, hidden) = match placed.shape {
            Shape::Quad { u, v, .. } => {
                let (u, v) = body.edges(u, v);
                let p = body.place;
                (normal(u, v), [p, p + u, p + u + v, p + v], false)
            }
            _ => {
                let half = body.half_sides(self.found)?;
                let axes = body.to_world.rotation;
                let number = plane.side % SIDES;
                let axis = (number / 2) as usize;
                let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                let normal = sign * axes.col(axis);
                let middle = body.place + half[axis] * normal;
                let (b, c) = (half[b] * axes.col(b), half[c] * axes.col(c));
                let inside = ((axes.transpose() * body.place).abs() - half).max_element() < 0.0;
                let hidden = !inside && normal.dot(middle) >= 0.0;
                (normal, [middle - b - c, middle + b - c, middle + b + c, middle - b + c], hidden)
            }
        };
        let key = steps(normal);
        let turned = key.into_iter().find(|step| *step != 0)? < 0;
        let (normal, key) = if turned { (-normal, steps(-normal)) } else { (normal, key) };
        let (distance, rounding) = (normal.dot(corners[0]), f64::from(plane.rounding) * self.found.extent);
        Some(Side { owner, normal, turned, key, distance, rounding, hidden, corners })
    }

    /// Compares surfaces in parallel planes that are as near to each other as rounding.
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
            // Neighbours that only touch need not meet in a cell.
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
        let same = material_a == material_b;
        let opposed = same && a.turned != b.turned && self.kinds[material_a as usize].one_sided;
        let gap = (a.distance - b.distance).abs();
        let rounding = a.rounding + b.rounding;
        // What lies against glass from outside is met through it, if it stands first.
        let met = !b.hidden && (!a.hidden || !self.kinds[material_b as usize].glass);
        if a.owner == b.owner || same && !opposed || gap > rounding || !met || !overlap(first, second) {
            return;
        }
        if !self.told.insert((a.owner, b.owner)) {
            return;
        }
        let pair = Pair { first: a.owner, second: b.owner, gap, rounding };
        let kind = match (a.hidden, opposed) {
            (true, _) => &mut self.under_glass,
            (false, true) => &mut self.back_to_back,
            (false, false) => &mut self.overlapping,
        };
        kind.note(-(b.owner as f64), pair);
    }
}

/// The components of a normal in steps, the same ones for -n as for n but for the sign.
fn steps(normal: DVec3) -> [i32; 3] {
    normal.to_array().map(|x| ((x.abs() * NORMAL_STEPS + 0.5) as i32) * if x < 0.0 { -1 } else { 1 })
}

/// Whether two parallelograms in a plane share an area: no line along an edge of either parts them (the separating axis theorem).
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

/// "coincides with" or how far apart.
fn apart(pair: &Pair) -> String {
    let Pair { gap, rounding, .. } = pair;
    // Less is what f64 left of transforms.
    if *gap <= 1e-3 * rounding {
        return "coincides with it".to_string();
    }
    format!("is {} off, less than what f32 rounds by there, {},", short(*gap), short(*rounding))
}

const BY_ROUNDING: &str = "which is seen is left to rounding, and to their order in the file where that ties";

fn tell_spheres(pair: &Pair) -> Danger {
    let message = format!(
        "there is a sphere of another material at {OTHER} that {}: {BY_ROUNDING}: remove one, or set them more than {} apart",
        apart(pair),
        short(pair.rounding)
    );
    Danger { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}

fn tell_overlapping(found: &Found, pair: &Pair) -> Danger {
    let message = format!(
        "its surface overlaps with that of the {} at {OTHER}, of another material, and {}: {BY_ROUNDING}: set them more than \
         {} apart, or cut one out",
        name(&found.placed[pair.first].shape),
        apart(pair),
        short(pair.rounding)
    );
    Danger { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}

fn tell_under_glass(found: &Found, pair: &Pair) -> Danger {
    let message = format!(
        "this glass touches the {} at {OTHER}, whose surface {}, and stands first in the file: rays that leave the glass there do \
         not meet what it touches: list the glass after it, or set them more than {} apart",
        name(&found.placed[pair.second].shape),
        apart(pair),
        short(pair.rounding)
    );
    Danger { at: At::Primitive(pair.first), field: "", message, other: Some(At::Primitive(pair.second)), more: 0 }
}

fn tell_back_to_back(pair: &Pair) -> Danger {
    let message = format!(
        "this light shines to one side, and lies back to back with the one at {OTHER}, which {}: where a ray meets the back of the \
         other, its light is lost: set them more than {} apart, or write one that is two_sided",
        apart(pair),
        short(pair.rounding)
    );
    Danger { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}
