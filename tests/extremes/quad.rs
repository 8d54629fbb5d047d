//! geometry/quad: rays that graze quads, and rays that leave them.

use glam::Vec3;
use gpu_rt::data::Quad;

use crate::common::kernel::Kernel;
use crate::common::quads::{assorted, quad_text, rays_at};
use crate::common::scenes::flat;
use crate::common::stats::Random;
use crate::common::trace::{In, NO_HIT, WITHOUT_OFFSET, leaving, trace, tracer};
use crate::common::vectors::{U, decades, exact};
use crate::table::{Cell, NO_OFFSET, decade};

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
            let off = exact(out.point) - on_quad;
            let across = off.dot(exact(quad.normal)).abs();
            // A floor at a height of 0 is at a height of 0.
            let across = if across == 0.0 { 0.0 } else { across / f64::from(quad.error_across) };
            found.worst_point = found.worst_point.max(across).max(off.length() / f64::from(quad.error));
            let off = ((f64::from(out.u) - p.a).abs() / p.a_error).max((f64::from(out.v) - p.b).abs() / p.b_error);
            found.worst_local = found.worst_local.max(off);
            assert!(out.u >= 0.0 && out.u <= 1.0 && out.v >= 0.0 && out.v <= 1.0, "{out:?}");
            assert_eq!((out.u, out.v), (out.local[0], out.local[1]));
            assert_eq!((out.normal, out.error), (quad.normal, quad.error_across));
        }
    }
    found
}

impl Verdict {
    fn worst(&self) -> f64 {
        [self.worst_decision, self.worst_distance, self.worst_point, self.worst_local].into_iter().fold(0.0, f64::max)
    }
}

/// Rays at quads in general position.
pub fn grazed() -> Vec<Cell> {
    let kernel = &tracer("quad", &[]);
    // From 1e-6 on the error of a hit, some 16 u of the lengths over the cosine, is the quad's own size: fewer are sure to be hits.
    (0..7)
        .map(|exponent| {
            let mut random = Random(11);
            let quads = assorted(&mut random, 3000, 6.0, (-2.0, 3.0));
            let (range, cosines) = decade(exponent);
            let rays = rays_at(&mut random, &quads, 20_000, cosines, (-1.0, 3.0));
            let found = judge(kernel, &quads, &rays);
            // (1/1.1)^2 = 83 % of the targets lie on their quads; needles lose some to their larger bounds.
            assert!(found.hits > if exponent < 5 { 10_000 } else { 1000 }, "{found:?}");
            let cell = Cell::new(
                range,
                "Quads by the sine of the angle with the plane: largest error of the decision, the distance, the point and its \
                 coordinates over its bound",
                1.0,
                "the offset, the product and the normal are off by 8 u of the lengths involved; the error of the plane, divided by \
                 the sine, is that of the point.",
            );
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
            let cell = cell.achieved(found.worst());
            if exponent > 5 {
                return cell;
            }
            let cell = cell.planted("axes computed in f32", judge(kernel, &in_f32, &rays).worst());
            if exponent > 1 {
                return cell;
            }
            // An edge that is off by 1e-4 of the quad's width.
            let stretched: Vec<Quad> =
                quads.iter().map(|quad| Quad { a_axis: quad.a_axis.map(|x| x * 0.9999), ..*quad }).collect();
            cell.planted("edge 1e-4 too far out", judge(kernel, &stretched, &rays).worst())
        })
        .collect()
}

/// Rays at floors: planes whose normal is an axis, so that products with it are exact. Distances keep all their digits
/// at every angle.
pub fn floors_grazed() -> Vec<Cell> {
    let kernel = &tracer("quad", &[]);
    let texts: Vec<String> = {
        let mut random = Random(15);
        let mut floor = || {
            let (height, width) = (decades(&mut random, -4.0, 1.0), decades(&mut random, -1.0, 0.0));
            let corner = glam::DVec3::new(-0.3 * width, -height, -0.7 * width);
            quad_text(corner, glam::DVec3::Z * width, glam::DVec3::X * width)
        };
        (0..1000).map(|_| floor()).collect()
    };
    let quads = flat(&texts).shapes.quads;
    (0..7)
        .map(|exponent| {
            let (range, cosines) = decade(exponent);
            let rays = rays_at(&mut Random(16), &quads, 20_000, cosines, (-1.0, 0.0));
            let (mut worst, mut hits) = (0.0f64, 0);
            for (ray, out) in rays.iter().zip(&trace(kernel, &quads, &rays)) {
                let quad = &quads[ray.primitive as usize];
                let t = (f64::from(quad.corner[1]) - f64::from(ray.origin[1])) / f64::from(ray.direction[1]);
                if out.t != NO_HIT {
                    hits += 1;
                    worst = worst.max((f64::from(out.t) / t - 1.0).abs());
                }
            }
            assert!(hits > 10_000, "{hits} hits");
            Cell::new(
                range,
                "Floors by the sine of the angle with the plane: largest relative error of the distance",
                4.0 * U,
                "a difference, and a quotient of at worst 2.5 ulps.",
            )
            .achieved(worst)
            .planted("normal that is off by 1e-6", worst_of_tilted(kernel, &quads, &rays))
        })
        .collect()
}

/// The worst error of floors that are tilted by a little: the other components of their normals are not exactly 0.
fn worst_of_tilted(kernel: &Kernel, quads: &[Quad], rays: &[In]) -> f64 {
    let tilted: Vec<Quad> = quads.iter().map(|quad| Quad { normal: [6e-7, quad.normal[1], -8e-7], ..*quad }).collect();
    let answers = trace(kernel, &tilted, rays);
    let hits = rays.iter().zip(&answers).filter(|(_, out)| out.t != NO_HIT);
    hits.fold(0.0, |worst: f64, (ray, out)| {
        let quad = &quads[ray.primitive as usize];
        let t = (f64::from(quad.corner[1]) - f64::from(ray.origin[1])) / f64::from(ray.direction[1]);
        worst.max((f64::from(out.t) / t - 1.0).abs())
    })
}

const BECAUSE: &str = "none, because the offset exceeds the bound of the errors of the point and of the next distance.";

/// The kernel, and one without the offset.
fn tracers() -> [Kernel; 2] {
    [&[][..], &[WITHOUT_OFFSET]].map(|replaced| tracer("quad", replaced))
}

/// Rays that met quads of which the corner is at a distance from the origin of space within these decades of the longer
/// side, and leave them on either side at cosines within these decades: the share that met them again.
fn again(kernel: &Kernel, aspect: f64, distance: (f64, f64), cosines: (f64, f64)) -> f64 {
    let mut random = Random(14);
    let quads = assorted(&mut random, 3000, aspect, distance);
    let mut rays = rays_at(&mut random, &quads, 10_000, (-2.0, 0.0), (-1.0, 1.0));
    for ray in &mut rays {
        let cosine = decades(&mut random, cosines.0, cosines.1);
        let outwards = random.below(2) == 0;
        ray.leaving = leaving(&mut random, cosine, outwards);
    }
    let found = trace(kernel, &quads, &rays);
    let hits = found.iter().filter(|out| out.t != NO_HIT);
    let count = hits.clone().count();
    assert!(count > 4000, "{count} hits");
    hits.filter(|out| out.again != NO_HIT).count() as f64
}

pub fn leavings() -> Vec<Cell> {
    let [own, without] = tracers();
    let mut all = Vec::new();
    for aspect in [0, 3, 6] {
        for (name, distance) in [("up to 1", (-2.0, 0.0)), ("1e3", (2.9, 3.1)), ("1e6", (5.9, 6.1))] {
            let range = format!("1e{aspect} times as long as wide, {name} lengths from the origin");
            let figure = "Quads: of 10 000 rays, those that hit their own quad again, with cosines from 0.01 to 1";
            let (aspect, cosines) = (f64::from(aspect), (-2.0, 0.0));
            all.push(
                Cell::new(range, figure, 0.0, BECAUSE)
                    .achieved(again(&own, aspect, distance, cosines))
                    .planted(NO_OFFSET, again(&without, aspect, distance, cosines)),
            );
        }
    }
    all
}

pub fn leaving_and_grazing() -> Vec<Cell> {
    let [own, without] = tracers();
    let cell = |exponent| {
        let (range, cosines) = decade(exponent);
        let figure = "Quads by the cosine of the leaving ray: of 10 000 rays, those that hit their own quad again";
        Cell::new(range, figure, 0.0, BECAUSE)
            .achieved(again(&own, 3.0, (-2.0, 1.0), cosines))
            .planted(NO_OFFSET, again(&without, 3.0, (-2.0, 1.0), cosines))
    };
    (1..7).map(cell).collect()
}
