//! Spheres about one centre, and meshes placed where they stand already: which of two surfaces is met is left to rounding.
//!
//! Candidates share a cell of a grid over places and sizes, with a width in proportion to both. Where one is nearer to the cell's edge than two that
//! coincide can be apart, it is filed in the next cell as well, so that none are missed.

use std::collections::HashSet;

use glam::DVec3;

use super::repeated::{Repeated, hash};
use super::{At, Body, Diagnostic, Found, OTHER, Role, U, Worst, apart, leaving, short};
use crate::shape::{Hull, binary_exponent, exp2};

/// So many in a cell, next to each other by their sizes, are compared with each.
const TESTS_EACH: usize = 16;
/// What coincides differs by less than this, in units of its largest coordinate and its radius: the largest of the bounds below is 10 u.
const SLACK: f64 = 16.0 * U;
/// A cell is so many binary digits smaller than that: 32 times as wide as the slack.
const CELL_DIGITS: i32 = 15;
/// Of a cell's width: 0 is not to lie on an edge, since many places are there.
const GRID_OFFSET: f64 = 0.37;

/// Two objects in one place, the first in the file first.
struct BodyPair {
    first: usize,
    second: usize,
    gap: f64,
    /// From this gap on all is well.
    bound: f64,
    clear: bool,
    both_clear: bool,
    mesh: bool,
}

/// The search among spheres and meshes.
pub struct SamePlace<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Role],
    /// A number made of a cell, and the object.
    filed: Vec<(u32, u32)>,
}

/// The place and the radius of a sphere, or of a ball around a mesh; nothing of others.
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

    /// Whether two are in one place, and that shows.
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
        // Of meshes no more than what rounding alone may come to is looked for.
        let (gap, most, bound, mesh) = match (a.shape.mesh(), b.shape.mesh()) {
            (None, None) => {
                // Rays that leave either, and what the radius and the next distance are rounded by.
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
        (true, true) => "the same mesh is placed a second time, clear as well, where it stands",
        (true, false) => "the same mesh is placed a second time, of another material, where it stands",
        (false, true) => "there is a clear sphere already",
        (false, false) => "there is a sphere of another material",
    };
    let consequence = match pair.clear {
        true => "rays that leave one start beyond the other",
        false => super::BY_ROUNDING,
    };
    let bound = short(pair.bound);
    let message = format!(
        "{what} at {OTHER}{}: {consequence}: remove one, or set them more than {bound} apart",
        apart(pair.gap, pair.bound, pair.clear),
    );
    Diagnostic { at: At::Primitive(pair.second), field: "", message, other: Some(At::Primitive(pair.first)), more: 0 }
}
