//! Finds lights behind a floor or a wall: each straight way from them, and from all that is on their side, to the camera and to all else goes
//! through one flat opaque surface, which shows the camera its other side. So no path joins them, however often it scatters.

use glam::DVec3;

use super::search::{Body, Diagnostic, OTHER, Search, Worst};
use crate::flatten::finder::MovingLight;
use crate::scene::Object;
use crate::shape::{Aabb, BoundingShape, normal};

/// The limit on comparisons of a light with a surface, and of surfaces with all bodies.
const MOST_TESTS: usize = 1 << 20;
/// A body that reaches less far behind a surface than this share of the scene's extent stands on it.
const STANDS: f64 = 1e-9;

/// A flat side of an opaque body. Heights above it are positive on the camera's side.
struct Face {
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
}

impl Face {
    /// The sides of a body of which the camera is in front.
    fn before(body: &Body<'_>) -> Vec<Face> {
        let face = |corner: DVec3, u: DVec3, v: DVec3| {
            let normal = normal(u, v);
            Face { corner, u, v, normal: if normal.dot(corner) > 0.0 { -normal } else { normal } }
        };
        match body.bounds {
            BoundingShape::Parallelogram { corner, u, v } if body.shape.fills_bounding_shape() => {
                let share = body.shape.kind().covered;
                vec![face(corner + 0.5 * (1.0 - share) * (u + v), share * u, share * v)]
            }
            BoundingShape::Cuboid { center, half, axes } if body.shape.fills_bounding_shape() => {
                let axis = |i: usize| half[i] * axes.col(i);
                let side = |i: usize, sign: f64| {
                    let (u, v) = (axis((i + 1) % 3), axis((i + 2) % 3));
                    (axes.col(i) * sign, face(center + sign * axis(i) - u - v, 2.0 * u, 2.0 * v))
                };
                let sides = (0..3).flat_map(|i| [side(i, 1.0), side(i, -1.0)]);
                sides.filter(|(outward, face)| outward.dot(face.normal) > 0.0).map(|(_, face)| face).collect()
            }
            _ => Vec::new(),
        }
    }

    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.corner)
    }

    /// Whether the way from a point before it to one behind it goes through it; that to a direction if `w` is 0.
    fn is_between(&self, before: DVec3, behind: DVec3, w: f64) -> bool {
        let (above, below) = (self.height(before).max(0.0), self.normal.dot(w * self.corner - behind));
        let at = (below * before + above * behind) / (below + w * above) - self.corner;
        let n = self.u.cross(self.v);
        let (s, t) = (at.cross(self.v).dot(n), self.u.cross(at).dot(n));
        below > 0.0 && (0.0..=n.length_squared()).contains(&s) && (0.0..=n.length_squared()).contains(&t)
    }
}

/// A light: the corners of the box around it, or the direction to it.
struct Source<'a> {
    object: &'a Object,
    corners: Vec<DVec3>,
    w: f64,
}

pub fn search<'a>(search: &Search<'a>) -> Worst<'a> {
    let mut worst = Worst::default();
    let finder = search.finder;
    let motions = finder.bodies().map(|(_, _, motion)| motion);
    let mut motions = motions.chain(finder.lights.iter().map(|light| &light.motion));
    // The ways of moving objects are not known.
    if !search.is_lit || !search.scene.camera.moving.is_empty() || motions.any(|motion| !motion.is_empty()) {
        return worst;
    }
    let surfaces = search.bodies().filter(|body| body.role.light);
    let surfaces =
        surfaces.map(|body| Source { object: body.object, corners: body.bounds.bounds().corners().into(), w: 1.0 });
    let without_size = finder.lights.iter().map(|MovingLight { object, light, .. }| match light.position {
        Some(at) => Source { object, corners: vec![at - search.view.eye], w: 1.0 },
        None => Source { object, corners: vec![-light.cone().0], w: 0.0 },
    });
    let sources: Vec<Source<'a>> = surfaces.chain(without_size).collect();
    let mut tests = MOST_TESTS;
    for wall in search.bodies().filter(|body| body.role.opaque) {
        for face in Face::before(&wall) {
            let Some(left) = tests.checked_sub(sources.len()) else { return worst };
            tests = left;
            let is_own = |object: &Object| std::ptr::eq(object, wall.object);
            // Lights within a box have another warning.
            let bottom = wall.bounds.corners().into_iter().map(|p| face.height(p)).fold(0.0, f64::min);
            let is_hidden = |source: &Source<'_>, p: DVec3| {
                face.is_between(DVec3::ZERO, p, source.w) && (source.w == 0.0 || face.height(p) < bottom)
            };
            let is_behind =
                |source: &&Source<'_>| !is_own(source.object) && source.corners.iter().all(|p| is_hidden(source, *p));
            let hidden: Vec<&Source<'a>> = sources.iter().filter(is_behind).collect();
            if hidden.is_empty() {
                continue;
            }
            let Some(left) = tests.checked_sub(finder.primitives.len() + finder.media.len()) else { return worst };
            tests = left;
            // The boxes around what is before the face and what is behind it, where a light at infinity has no place.
            let lens = DVec3::splat(search.view.lens_radius());
            let (mut before, mut behind) = (vec![Aabb { min: -lens, max: lens }], Vec::new());
            for body in search.bodies().chain(search.boundaries()).filter(|body| !is_own(body.object)) {
                let around = body.bounds.bounds();
                let is_behind = around.corners().into_iter().all(|p| face.height(p) < 0.0);
                if is_behind { &mut behind } else { &mut before }.push(around);
            }
            // The other sides of a box are behind the one.
            let sides = wall.bounds.corners().into_iter().filter(|p| face.height(*p) < -STANDS * search.extent);
            behind.extend(sides.map(|p| Aabb { min: p, max: p }));
            let before = Aabb::around_all(before).corners();
            let stands = before.iter().all(|p| face.height(*p) >= -STANDS * search.extent);
            let is_cut_off = |p: DVec3, w: f64| before.iter().all(|before| face.is_between(*before, p, w));
            let cuts_off =
                behind.is_empty() || Aabb::around_all(behind).corners().into_iter().all(|p| is_cut_off(p, 1.0));
            if !stands || !cuts_off {
                continue;
            }
            for source in hidden.into_iter().filter(|source| source.corners.iter().all(|p| is_cut_off(*p, source.w))) {
                let message = format!(
                    "this light is not seen: it is behind the opaque {} at {OTHER}, and the camera and all other objects are in front of \
                     that: move the light to the front, or remove it",
                    wall.word()
                );
                worst.add(0.0, || Diagnostic { other: Some(wall.object), ..Diagnostic::of(source.object, message) });
            }
            if worst.count > 0 {
                return worst;
            }
        }
    }
    worst
}
