//! Finds spheres that coincide, and meshes that are placed twice at one position: rounding decides which of the two
//! surfaces a ray hits.
//!
//! Candidates share a cell of a grid over positions and sizes. The width of a cell is in proportion to both. An object
//! that is closer to the edge of its cell than coincident objects can be apart is also entered in the next cell, so
//! that no pair is missed.

use std::collections::HashSet;

use glam::DVec3;

use super::repeated::{Repeated, hash};
use super::{At, Body, Diagnostic, Found, OTHER, Role, U, Worst, apart, leaving, short};
use crate::shape::{Hull, binary_exponent, exp2};

/// Each object in a cell is compared with this number of others, those nearest in size.
const TESTS_EACH: usize = 16;
/// Coincident objects differ by less than this, relative to the sum of the largest coordinate and the radius. The
/// largest of the bounds below is 10 u.
const SLACK: f64 = 16.0 * U;
/// A cell is 2^15 times smaller than that sum, and thus 32 times as wide as the slack.
const CELL_DIGITS: i32 = 15;
/// A shift of the grid, in cells. It keeps 0, where many objects are, off the edge of a cell.
const GRID_OFFSET: f64 = 0.37;

/// Two objects at one position, in the order of the file.
struct BodyPair {
    first: usize,
    second: usize,
    gap: f64,
    /// The least gap that causes no warning.
    bound: f64,
    clear: bool,
    both_clear: bool,
    mesh: bool,
}

/// The search among spheres and meshes.
pub struct SamePlace<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Role],
    /// The hash of a cell, and the object.
    filed: Vec<(u32, u32)>,
}

/// The centre and radius of a sphere, or of a ball around a mesh; none for other shapes.
fn ball(body: &Body) -> Option<(DVec3, f64)> {
    let is_sphere = body.shape.is_hull() && matches!(body.hull, Hull::Ball { .. });
    (is_sphere || body.shape.mesh().is_some()).then(|| body.hull.ball())
}

impl<'a> SamePlace<'a> {
    pub fn new(found: &'a Found<'a>, kinds: &'a [Role]) -> SamePlace<'a> {
        SamePlace { found, kinds, filed: Vec::new() }
    }

    pub fn see(&mut self, number: usize, body: &Body) {
        let Some((place, radius)) = ball(body) else { return };
        let what = body.shape.mesh().map_or(0, |mesh| mesh.number as u32 + 1);
        let size = place.abs().max_element() + radius;
        if size <= 0.0 {
            return;
        }
        let slack = SLACK * size;
        let (level, upper) = (binary_exponent(size - slack), binary_exponent(size + slack));
        for level in level..=upper {
            let inverse = exp2(CELL_DIGITS - level);
            let cell = |x: f64| (x * inverse + GRID_OFFSET).floor() as i32 as u32;
            let numbers = [place.x, place.y, place.z, radius];
            let (low, high) = (numbers.map(|x| cell(x - slack)), numbers.map(|x| cell(x + slack)));
            for which in 0..16 {
                let next = |axis: usize| which >> axis & 1 == 1;
                if (0..4).all(|axis| !next(axis) || low[axis] != high[axis]) {
                    let [x, y, z, r] = std::array::from_fn(|axis| if next(axis) { high[axis] } else { low[axis] });
                    self.filed.push((hash([what, level as u32, x, y, z, r]), number as u32));
                }
            }
        }
    }

    pub fn diagnostics(mut self) -> Vec<Diagnostic> {
        let again = Repeated::new(self.filed.iter().map(|(hash, _)| *hash));
        self.filed.retain(|(hash, _)| again.holds(*hash));
        self.filed.sort_unstable();
        let found = self.found;
        let body = |number: usize| Body::new(found, &found.placed[number].shape, &found.placed[number].to_world);
        let radius = |number: usize| body(number).hull.ball().1;
        let mut told = HashSet::new();
        let (mut spheres, mut meshes) = (Worst::default(), Worst::default());
        for group in self.filed.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
            let mut members: Vec<(f64, usize)> =
                group.iter().map(|(_, number)| (radius(*number as usize), *number as usize)).collect();
            members.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (at, &(_, one)) in members.iter().enumerate() {
                for &(_, other) in members[at + 1..].iter().take(TESTS_EACH) {
                    let (first, second) = (one.min(other), one.max(other));
                    if first == second || told.contains(&second) {
                        continue;
                    }
                    if let Some(pair) = self.compare(first, second, &body(first), &body(second)) {
                        told.insert(second);
                        let kind = if pair.mesh { &mut meshes } else { &mut spheres };
                        kind.note(-(second as f64), pair);
                    }
                }
            }
        }
        [spheres, meshes].into_iter().filter_map(|kind| kind.diagnostic(|pair| tell(&pair))).collect()
    }

    /// The pair, if the two coincide and this is visible.
    fn compare(&self, first: usize, second: usize, a: &Body, b: &Body) -> Option<BodyPair> {
        let materials = [first, second].map(|number| self.found.placed[number].material);
        let kinds = materials.map(|material| self.kinds[material as usize]);
        let clear = kinds.iter().any(|kind| kind.glass);
        let both_clear = kinds.iter().all(|kind| kind.glass);
        if materials[0] == materials[1] && !clear {
            return None;
        }
        let ((place, r), (other, s)) = (a.hull.ball(), b.hull.ball());
        let rounding = 4.0 * U * (place.abs().max_element() + r);
        // Meshes count only if they are within the rounding. The distance that the warning advises includes the ray offset.
        let (gap, most, bound, mesh) = match (a.shape.mesh(), b.shape.mesh()) {
            (None, None) => {
                // The offset of rays that leave either one, and the rounding of the radius and of the next distance.
                let leaving = [(place, r), (other, s)].into_iter().zip(kinds).filter(|(_, kind)| !kind.light);
                let start = leaving.map(|((c, r), _)| leaving::from_sphere(c, r)).fold(0.0, f64::max);
                let bound = if clear { start + 4.0 * U * r.max(s) } else { rounding };
                ((r - s).abs() + place.distance(other), bound, bound, false)
            }
            (Some(one), Some(same)) if one.number == same.number => {
                let corners = a.hull.corners().into_iter().zip(b.hull.corners());
                let gap = corners.map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
                let start = leaving::from_mesh(place, a.half_sides()?);
                (gap, rounding, if clear { rounding + start } else { rounding }, true)
            }
            _ => return None,
        };
        (gap <= most).then_some(BodyPair { first, second, gap, bound, clear, both_clear, mesh })
    }
}

fn tell(pair: &BodyPair) -> Diagnostic {
    let what = match (pair.mesh, pair.both_clear) {
        (true, true) => "the same mesh, also clear,",
        (true, false) => "the same mesh with another material",
        (false, true) => "another clear sphere",
        (false, false) => "a sphere of another material",
    };
    let consequence = match pair.clear {
        true => "rays that leave one start behind the other and miss it",
        false => super::BY_ROUNDING,
    };
    let bound = short(pair.bound);
    let message = format!(
        "{what} at {OTHER} {}: {consequence}: remove one, or set them more than {bound} apart",
        apart(pair.gap, pair.bound, pair.clear),
    );
    Diagnostic { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}
