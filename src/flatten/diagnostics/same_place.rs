//! Finds spheres that coincide, and meshes that are placed twice at one position: rounding decides which of the two
//! surfaces a ray hits.
//!
//! Candidates are neighbours in the order of one number for each object, made of position and radius. The position counts
//! by its component in an oblique direction, because no row of objects has equal components there.

use std::collections::HashSet;

use glam::DVec3;

use super::{BY_ROUNDING, Body, Diagnostic, Found, OTHER, Pair, Role, U, Worst, apart, leaving, short};
use crate::shape::Hull;

/// Each object is compared with this number of others, those next in the order.
const TESTS_EACH: usize = 16;
/// The numbers of coincident objects differ by less than this, relative to the sum of the largest coordinate and the
/// radius. The largest of the bounds below is 10 u.
const SLACK: f64 = 16.0 * U;
/// The direction, of length 1, and the weight of the radius.
const DIRECTION: DVec3 = DVec3::new(0.791_328, 0.507_219, 0.341_477);
const RADIUS: f64 = 0.618_034;

/// The search among spheres and meshes.
pub struct SamePlace<'a> {
    found: &'a Found<'a>,
    kinds: &'a [Role],
    /// The number made of position and radius, the slack of it, and the index of the object.
    filed: Vec<(f64, f64, usize)>,
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
        if let Some((place, radius)) = ball(body) {
            let along = DIRECTION.dot(place) + RADIUS * radius;
            self.filed.push((along, SLACK * (place.abs().max_element() + radius), number));
        }
    }

    pub fn diagnostics(mut self) -> Vec<Diagnostic> {
        self.filed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let found = self.found;
        let body = |number: usize| Body::new(found, &found.placed[number].shape, &found.placed[number].to_world);
        let mut told = HashSet::new();
        let (mut spheres, mut meshes) = (Worst::default(), Worst::default());
        for (at, &(along, reach, one)) in self.filed.iter().enumerate() {
            let near = self.filed[at + 1..].iter().take_while(|other| other.0 - along <= reach);
            for &(.., other) in near.take(TESTS_EACH) {
                let (first, second) = (one.min(other), one.max(other));
                if told.contains(&second) {
                    continue;
                }
                let (a, b) = (body(first), body(second));
                if let Some(pair) = self.compare(first, second, &a, &b) {
                    told.insert(second);
                    let kind = if a.shape.mesh().is_some() { &mut meshes } else { &mut spheres };
                    kind.note(-(second as f64), pair);
                }
            }
        }
        let spheres = spheres.diagnostic(|pair| self.tell(&pair, false));
        [spheres, meshes.diagnostic(|pair| self.tell(&pair, true))].into_iter().flatten().collect()
    }

    /// The pair, if the two coincide and this is visible.
    fn compare(&self, first: usize, second: usize, a: &Body, b: &Body) -> Option<Pair> {
        let materials = [first, second].map(|number| self.found.placed[number].material);
        let kinds = materials.map(|material| self.kinds[material as usize]);
        let clear = kinds.iter().any(|kind| kind.glass);
        if materials[0] == materials[1] && !clear {
            return None;
        }
        let ((place, r), (other, s)) = (a.hull.ball(), b.hull.ball());
        let rounding = match a.shape.large_sphere().zip(b.shape.large_sphere()) {
            Some((one, same)) => leaving::from_large_sphere(one.distance(a.to_world).max(same.distance(b.to_world))),
            None => 4.0 * U * (place.abs().max_element() + r),
        };
        // Meshes count only if they are within the rounding. The distance that the warning advises includes the ray offset.
        let (gap, most, bound) = match (a.shape.mesh(), b.shape.mesh()) {
            (None, None) if a.shape.large_sphere().and(b.shape.large_sphere()).is_some() => {
                let bound = if clear { 2.0 * rounding } else { rounding };
                ((r - s).abs() + place.distance(other), bound, bound)
            }
            (None, None) => {
                // The offset of rays that leave either one, and the rounding of the radius and of the next distance.
                let leaving = [(place, r), (other, s)].into_iter().zip(kinds).filter(|(_, kind)| !kind.light);
                let start = leaving.map(|((c, r), _)| leaving::from_sphere(c, r)).fold(0.0, f64::max);
                let bound = if clear { start + 4.0 * U * r.max(s) } else { rounding };
                ((r - s).abs() + place.distance(other), bound, bound)
            }
            (Some(one), Some(same)) if one.number == same.number => {
                let corners = a.hull.corners().into_iter().zip(b.hull.corners());
                let gap = corners.map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
                let start = leaving::from_mesh(place, a.half_sides()?);
                (gap, rounding, if clear { rounding + start } else { rounding })
            }
            _ => return None,
        };
        (gap <= most).then_some(Pair { first, second, gap, bound })
    }

    fn tell(&self, &Pair { first, second, gap, bound }: &Pair, mesh: bool) -> Diagnostic {
        let [one, other] = [first, second].map(|number| self.kinds[self.found.placed[number].material as usize].glass);
        let what = match (mesh, one && other) {
            (true, true) => "the same mesh, also clear,",
            (true, false) => "the same mesh with another material",
            (false, true) => "another clear sphere",
            (false, false) => "a sphere of another material",
        };
        let clear = one || other;
        let consequence = if clear { "rays that leave one start behind the other and miss it" } else { BY_ROUNDING };
        let (away, limit) = (apart(gap, bound, clear), short(bound));
        let message =
            format!("{what} at {OTHER} {away}: {consequence}: remove one, or set them more than {limit} apart");
        Diagnostic::of_two(second, first, message)
    }
}
