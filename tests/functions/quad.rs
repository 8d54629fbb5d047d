//! geometry/quad: which rays hit, how far away, shared edges, and the rays that leave.

use glam::{DVec3, Vec3};
use gpu_rt::data::Quad;

use crate::kernel::Kernel;
use crate::scenes::{flat, triple};
use crate::stats::Random;
use crate::trace::{In, NO_HIT, trace, tracer};
use crate::vectors::{U, decades, exact, rounded, unit};

fn quad_text(corner: DVec3, u: DVec3, v: DVec3) -> String {
    format!("Quad(corner: {}, u: {}, v: {}, material: \"m\")", triple(corner), triple(u), triple(v))
}

/// Parallelograms with a longer side of 1e-4 to 1e5, up to 1e6 times the shorter, their angles from 30 to 150 degrees,
/// and their corners up to 1000 longer sides from the origin.
fn assorted(random: &mut Random, count: usize) -> Vec<Quad> {
    let texts: Vec<String> = (0..count)
        .map(|i| {
            let longer = decades(random, -4.0, 5.0);
            let shorter = longer / if i % 2 == 0 { 1.0 } else { decades(random, 0.0, 6.0) };
            let u = unit(random);
            let sideways = u.cross(unit(random)).normalize();
            let skew = (2.0 * random.uniform() - 1.0) * 0.866;
            let v = skew * u + (1.0 - skew * skew).sqrt() * sideways;
            let corner = longer * decades(random, -2.0, 3.0) * unit(random);
            match i % 3 {
                0 => quad_text(corner, longer * u, shorter * v),
                _ => quad_text(corner, shorter * u, longer * v),
            }
        })
        .collect();
    flat(&texts).quads
}

/// Where a ray's line meets the plane of corner, u and v in f64, and how far f32 may be off.
struct Plane {
    t: f64,
    a: f64,
    b: f64,
    t_error: f64,
    a_error: f64,
    b_error: f64,
}

/// The errors of f32: the offset from the corner, its product with the normal, and the normal itself over the distance
/// from the corner, each some u times the lengths that take part (`reach`; 8 is twice the sum of the roundings). Divided by
/// the cosine, for that is how a plane's offset moves the point where a ray meets it. The quad may besides reach out by
/// its own stated error, so that neighbours leave no gap.
fn plane(ray: &In, quad: &Quad) -> Plane {
    let (o, d) = (exact(ray.origin), exact(ray.direction));
    let (corner, u, v) = (exact(quad.corner), exact(quad.u), exact(quad.v));
    let n = u.cross(v);
    let t = (corner - o).dot(n) / d.dot(n);
    let on_plane = o + t * d - corner;
    let a = on_plane.cross(v).dot(n) / n.length_squared();
    let b = u.cross(on_plane).dot(n) / n.length_squared();
    let cos = d.dot(n).abs() / n.length();
    let reach = (corner - o).length() + t.abs() + on_plane.length();
    let t_error = 8.0 * U * reach / cos;
    let off = t_error + 8.0 * U * reach + f64::from(quad.error) / cos;
    let in_axis = |axis: [f32; 3]| off * exact(axis).length();
    Plane { t, a, b, t_error, a_error: in_axis(quad.a_axis), b_error: in_axis(quad.b_axis) }
}

/// Rays at points of the quads' planes on the quads and a little outside, at angles with the plane down to 1e-4 rad.
fn rays_at(random: &mut Random, quads: &[Quad], count: usize) -> Vec<In> {
    (0..count)
        .map(|i| {
            let quad = &quads[i % quads.len()];
            let (corner, u, v) = (exact(quad.corner), exact(quad.u), exact(quad.v));
            let (a, b) = (1.1 * random.uniform() - 0.05, 1.1 * random.uniform() - 0.05);
            let target = corner + a * u + b * v;
            let normal = u.cross(v).normalize();
            let cos = decades(random, -4.0, 0.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
            let along = normal.cross(unit(random)).normalize();
            let away = cos * normal + (1.0 - cos * cos).sqrt() * along;
            let origin = target + u.length().max(v.length()) * decades(random, -1.0, 3.0) * away;
            In::new(i % quads.len(), origin, -away)
        })
        .collect()
}

/// What was found about a tracer's answers; the worst are in units of their bounds.
#[derive(Debug, Default)]
struct Verdict {
    hits: u32,
    worst_decision: f64,
    worst_distance: f64,
    worst_point: f64,
    worst_local: f64,
}

fn judge(kernel: &Kernel, quads: &[Quad], rays: &[In]) -> Verdict {
    let mut found = Verdict::default();
    for (ray, out) in rays.iter().zip(&trace(kernel, quads, rays)) {
        let quad = &quads[ray.primitive as usize];
        let p = plane(ray, quad);
        let hit = out.t != NO_HIT;
        // How far the point lies inside: the least over the four edges, in units of their bounds.
        let inside = [p.a / p.a_error, (1.0 - p.a) / p.a_error, p.b / p.b_error, (1.0 - p.b) / p.b_error];
        let inside = inside.into_iter().fold(p.t / p.t_error, f64::min);
        if hit != (inside > 0.0) {
            found.worst_decision = found.worst_decision.max(inside.abs());
        }
        if hit {
            found.hits += 1;
            found.worst_distance = found.worst_distance.max((f64::from(out.t) - p.t).abs() / p.t_error);
            let (corner, u, v) = (exact(quad.corner), exact(quad.u), exact(quad.v));
            let on_quad = corner + f64::from(out.local[0]) * u + f64::from(out.local[1]) * v;
            let off = (exact(out.point) - on_quad).length();
            found.worst_point = found.worst_point.max(off / f64::from(out.error));
            let off = ((f64::from(out.u) - p.a).abs() / p.a_error).max((f64::from(out.v) - p.b).abs() / p.b_error);
            found.worst_local = found.worst_local.max(off);
            assert!(out.u >= 0.0 && out.u <= 1.0 && out.v >= 0.0 && out.v <= 1.0, "{out:?}");
            assert_eq!((out.u, out.v), (out.local[0], out.local[1]));
            assert_eq!((out.normal, out.error), (quad.normal, quad.error));
        }
    }
    found
}

impl Verdict {
    fn passes(&self) -> bool {
        [self.worst_decision, self.worst_distance, self.worst_point, self.worst_local].iter().all(|worst| *worst <= 1.0)
    }
}

#[test]
fn quad_hits_are_decided_and_placed_to_the_last_digits() {
    let mut random = Random(11);
    let quads = assorted(&mut random, 3000);
    let rays = rays_at(&mut random, &quads, 60_000);
    let kernel = tracer("quad", &[]);
    let found = judge(&kernel, &quads, &rays);
    // (1/1.1)^2 = 83 % of the targets lie on their quads; needles lose some to their larger bounds.
    assert!(found.hits > 40_000, "{found:?}");
    assert!(found.passes(), "{found:?}");

    // What the host computes in f64, computed in f32 instead: normal and axes of needles have no digits left.
    let in_f32: Vec<Quad> = quads
        .iter()
        .map(|quad| {
            let (u, v) = (Vec3::from(quad.u), Vec3::from(quad.v));
            let n = u.cross(v);
            let w = n / n.length_squared();
            let [a_axis, b_axis] = [v.cross(w), w.cross(u)].map(|axis| axis.to_array());
            Quad { normal: n.normalize().to_array(), a_axis, b_axis, ..*quad }
        })
        .collect();
    // An edge that is off by 1e-4 of the quad's width.
    let stretched: Vec<Quad> =
        quads.iter().map(|quad| Quad { a_axis: quad.a_axis.map(|x| x * 0.9999), ..*quad }).collect();
    for (what, wrong) in [("axes in f32", in_f32), ("stretched", stretched)] {
        let found = judge(&kernel, &wrong, &rays);
        assert!(!found.passes(), "{what}: {found:?}");
    }
}

#[test]
fn quads_behind_the_ray_and_along_it_are_missed() {
    let mut random = Random(12);
    let quads = assorted(&mut random, 500);
    let mut rays = rays_at(&mut random, &quads, 5000);
    rays.iter_mut().for_each(|ray| ray.direction = ray.direction.map(|x| -x));
    let kernel = tracer("quad", &[]);
    assert!(trace(&kernel, &quads, &rays).iter().all(|out| out.t == NO_HIT));

    // Parallel to the plane: beside it the quotient is an infinity, within it 0/0.
    let square = Quad {
        normal: [0.0, 0.0, 1.0],
        u: [1.0, 0.0, 0.0],
        a_axis: [1.0, 0.0, 0.0],
        v: [0.0, 1.0, 0.0],
        b_axis: [0.0, 1.0, 0.0],
        ..Quad::default()
    };
    let mut parallel = Vec::new();
    for height in [0.0, -0.0, 1e-40, 1e-20, 0.5] {
        for z in [0.0, -0.0] {
            for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-0.6, 0.8)] {
                let origin = [0.5, 0.5, height];
                parallel.push(In { origin, direction: [x, y, z], ..In::default() });
            }
        }
    }
    assert!(trace(&kernel, &[square], &parallel).iter().all(|out| out.t == NO_HIT));
}

/// Folds of two quads along a shared edge, 1 to 10 times as long as they are wide and up to 100 lengths from the origin,
/// and rays at that edge from up to 100 lengths away.
fn folds(random: &mut Random, general: bool) -> (Vec<Quad>, Vec<In>) {
    let mut texts = Vec::new();
    for i in 0..2000 {
        let (along, u, v) = if general {
            let along = unit(random);
            let u = along.cross(unit(random)).normalize();
            let v = if i % 2 == 0 { along.cross(unit(random)).normalize() } else { -u };
            (along, u, v)
        } else {
            (DVec3::Y, DVec3::X, if i % 2 == 0 { DVec3::NEG_X } else { DVec3::NEG_Z })
        };
        let size = decades(random, -4.0, 5.0);
        let corner = decades(random, -1.0, 2.0) * size * unit(random);
        let (along, u, v) =
            (along * size, u * size * decades(random, -1.0, 0.0), v * size * decades(random, -1.0, 0.0));
        // Each names the edge by another corner, or in the other sense.
        texts.push(quad_text(corner, along, u));
        texts.push(match i % 4 {
            0 => quad_text(corner, v, along),
            1 => quad_text(corner + along, -along, v),
            2 => quad_text(corner + v, -v, along),
            _ => quad_text(corner + v + along, -along, -v),
        });
    }
    let quads = flat(&texts).quads;
    let mut rays = Vec::new();
    for i in 0..100_000 {
        let left = 2 * (i % 2000);
        let quad = &quads[left];
        let edge = exact(quad.u);
        let target = exact(quad.corner) + random.uniform() * edge;
        let origin = target + decades(random, -1.0, 2.0) * edge.length() * unit(random);
        let direction = (target - origin).normalize();
        // The quads lie on both sides of the edge as the ray sees it, else it may pass the fold by; and neither is seen at
        // less than 1e-4 rad.
        let side = direction.cross(edge);
        let across = [quad, &quads[left + 1]].map(|quad| {
            let middle = exact(quad.corner) + 0.5 * (exact(quad.u) + exact(quad.v));
            (middle - target).dot(side)
        });
        let facing = [quad, &quads[left + 1]].map(|quad| exact(quad.normal).dot(direction).abs());
        if across[0] * across[1] < 0.0 && facing[0].min(facing[1]) > 1e-4 {
            rays.push(In::new(left, origin, direction));
            rays.push(In::new(left + 1, origin, direction));
        }
    }
    (quads, rays)
}

/// Folds of which a ray at their edge missed both quads.
fn gaps(kernel: &Kernel, quads: &[Quad], rays: &[In]) -> usize {
    let hits = trace(kernel, quads, rays);
    hits.chunks_exact(2).filter(|pair| pair[0].t == NO_HIT && pair[1].t == NO_HIT).count()
}

#[test]
fn no_ray_passes_between_quads_that_share_an_edge() {
    for general in [true, false] {
        let (quads, rays) = folds(&mut Random(13), general);
        assert!(rays.len() > 100_000);
        let missed = gaps(&tracer("quad", &[]), &quads, &rays);
        assert_eq!(missed, 0, "of {}", rays.len() / 2);
        // Edges tested as they are, without an allowance for rounding.
        let sharp = tracer("quad", &[("geometry/quad", "test/control/quad_sharp")]);
        assert!(gaps(&sharp, &quads, &rays) > 1000);
    }
}

/// Rays that met a quad and leave it, on either side, at cosines from 0.05 to 1 with its normal: those that meet it again.
fn again(kernel: &Kernel) -> (usize, usize) {
    let mut random = Random(14);
    let quads = assorted(&mut random, 3000);
    let mut rays = rays_at(&mut random, &quads, 60_000);
    for ray in &mut rays {
        let cos = 0.05 + 0.95 * random.uniform();
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let (sin, phi) = ((1.0 - cos * cos).sqrt(), random.uniform() * std::f64::consts::TAU);
        ray.leaving = rounded(DVec3::new(sin * phi.cos(), sin * phi.sin(), side * cos));
    }
    let found = trace(kernel, &quads, &rays);
    let hits = found.iter().filter(|out| out.t != NO_HIT);
    (hits.clone().count(), hits.filter(|out| out.again != NO_HIT).count())
}

#[test]
fn rays_leave_quads_of_all_sizes() {
    let (hits, wrong) = again(&tracer("quad", &[]));
    assert!(hits > 40_000);
    assert_eq!(wrong, 0, "re-hits of {hits}");
    let (_, wrong) = again(&tracer("quad", &[("geometry/offset", "test/control/offset_none")]));
    assert!(wrong > 1000, "{wrong}");
}
