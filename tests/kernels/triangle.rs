//! geometry/sheared_triangle: closed meshes without holes or double walls, distances and weights. The rays that leave are in tests/extremes.

use glam::DVec3;

use crate::common::instances;
use crate::common::kernel::{Kernel, Plant, Setup};
use crate::common::stats::Random;
use crate::common::trace::NO_HIT;
use crate::common::triangles::{Corners, In, Out, stout, trace, tracer};
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// A closed mesh around the origin, counter-clockwise as seen from outside.
struct Mesh {
    points: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
    /// No line from inside meets it twice.
    convex: bool,
}

impl Mesh {
    /// Each triangle cut in four at the middles of its edges.
    fn subdivided(self) -> Mesh {
        let (points, faces) = instances::cut((self.points, self.faces), |middle| middle);
        Mesh { points, faces, ..self }
    }

    fn moved(mut self, by: impl FnMut(DVec3) -> DVec3) -> Mesh {
        self.points = self.points.into_iter().map(by).collect();
        self
    }

    fn corners(&self, scale: f64, offset: DVec3) -> Vec<Corners> {
        self.faces.iter().map(|face| Corners::new(face.map(|i| scale * (self.points[i] + offset)))).collect()
    }

    /// A vertex, or a point of an edge at an eighth of it.
    fn target(&self, random: &mut Random) -> DVec3 {
        let face = self.faces[random.below(self.faces.len())];
        let (a, b) = (self.points[face[0]], self.points[face[1 + random.below(2)]]);
        a + [0.0, 0.125, 0.5, 0.75][random.below(4)] * (b - a)
    }
}

/// Multiples of 2^-12, so that differences, and positions 1024 sizes off, are exact in f32.
fn on_grid(p: DVec3) -> DVec3 {
    (p * 4096.0).round() / 4096.0
}

fn octahedron() -> Mesh {
    let (points, faces) = instances::ball(0);
    Mesh { points, faces, convex: true }
}

/// A ball of 8 x 4^`levels` triangles with its vertices moved about.
fn ball(random: &mut Random, levels: u32) -> Mesh {
    let edge = 1.0 / f64::from(1u32 << levels);
    let fine = (0..levels).fold(octahedron(), |mesh, _| mesh.subdivided());
    let mesh = fine.moved(|p| on_grid((p.normalize() + 0.2 * edge * unit(random)).normalize()));
    Mesh { convex: false, ..mesh }
}

/// A cube whose faces are grids with edges along the axes and diagonals.
fn cube(levels: u32) -> Mesh {
    let mut points = Vec::new();
    for i in 0..8 {
        points.push(DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0 - 1.0);
    }
    let mut faces = Vec::new();
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        faces.extend([[a, b, c], [a, c, d]]);
    }
    (0..levels).fold(Mesh { points, faces, convex: true }, |mesh, _| mesh.subdivided())
}

/// A prism of needles: every second side is about 1e-6 wide, and so are the triangles of its ends.
fn needles() -> Mesh {
    let sides = 96;
    let mut points = vec![DVec3::Z, DVec3::NEG_Z];
    for i in 0..sides {
        let angle = std::f64::consts::TAU * f64::from(i / 2) / f64::from(sides / 2) + 1e-6 * f64::from(i % 2);
        let at = DVec3::new(angle.cos(), angle.sin(), 1.0);
        points.extend([at, at * DVec3::new(1.0, 1.0, -1.0)]);
    }
    let mut faces = Vec::new();
    for i in 0..sides as usize {
        let (top, bottom) = (2 + 2 * i, 3 + 2 * i);
        let (next_top, next_bottom) = (2 + 2 * ((i + 1) % sides as usize), 3 + 2 * ((i + 1) % sides as usize));
        faces.extend([[0, top, next_top], [1, next_bottom, bottom]]);
        faces.extend([[top, bottom, next_bottom], [top, next_bottom, next_top]]);
    }
    Mesh { points: points.into_iter().map(|p| exact(rounded(p))).collect(), faces, convex: false }
}

/// Rays from inside, some from the middle: at vertices and points of edges, up to the rounding of the direction and without;
/// along the axes; and anywhere.
fn rays_from_inside(random: &mut Random, mesh: &Mesh, scale: f64, offset: DVec3, count: usize) -> Vec<In> {
    (0..count)
        .map(|i| {
            let target = mesh.target(random);
            let inside = if i % 2 == 0 { DVec3::ZERO } else { (0.3 * unit(random) * 64.0).round() / 64.0 };
            let (origin, direction) = match i % 5 {
                0 | 1 => (inside, target - inside),
                // A power of two along the largest axis: slopes and sheared vertices are exact, and the ray meets the
                // vertex or the edge itself.
                2 => {
                    let mut origin = inside;
                    let axis = target.abs().max_position();
                    origin[axis] = target[axis] - 0.5 * target[axis].signum();
                    (origin, target - origin)
                }
                // Along the axis.
                3 => {
                    let axis = target.abs().max_position();
                    let mut origin = target;
                    origin[axis] = 0.0;
                    if origin.length() > 0.95 {
                        // That would not start inside the cube or the prism.
                        origin = DVec3::ZERO;
                    }
                    origin[axis] = target[axis];
                    origin[axis] -= 0.5 * target[axis].signum();
                    (origin, target - origin)
                }
                _ => (inside, unit(random)),
            };
            In {
                origin: rounded(scale * (origin + offset)),
                direction: rounded(direction),
                first: 0,
                count: mesh.faces.len() as u32,
                ..In::default()
            }
        })
        .collect()
}

/// How many rays from inside the mesh leave it too often and too rarely.
fn leaks(kernel: &Kernel, mesh: &Mesh, scale: f64, offset: DVec3, count: usize) -> (usize, usize) {
    let mut random = Random(71);
    let rays = rays_from_inside(&mut random, mesh, scale, offset, count);
    let (mut many, mut few) = (0, 0);
    for out in &trace(kernel, &mesh.corners(scale, offset), &rays) {
        // Where a sheet folds, a line goes out, in, and out again.
        let out_and_in = if mesh.convex { (out.back, out.front) } else { (out.back.saturating_sub(out.front), 0) };
        many += usize::from(out_and_in > (1, 0));
        few += usize::from(out_and_in < (1, 0));
    }
    (many, few)
}

#[test]
fn every_ray_from_inside_a_closed_mesh_leaves_it_once() {
    let kernel = tracer(&[]);
    // Signs as rounded: a ray on an edge meets both its triangles, or neither.
    const SIGNS: &str = "all(signs > vec3<f32>(0.0)) || all(signs < vec3<f32>(0.0))";
    const PLANTED: [Plant; 2] = [
        ("geometry/sheared_triangle", SIGNS, "all(areas >= vec3<f32>(0.0)) || all(areas <= vec3<f32>(0.0))"),
        ("geometry/sheared_triangle", SIGNS, "all(areas > vec3<f32>(0.0)) || all(areas < vec3<f32>(0.0))"),
    ];
    let planted = Kernel::with("test/triangle", &Setup { plants: &PLANTED, ..Setup::default() });
    let [closed, open] = [0, 1].map(|number| planted.planted(number));
    let mut random = Random(70);
    let far = DVec3::new(1024.0, -512.0, 768.0);
    let small = 0.5f64.powi(20);
    let meshes = [
        ("octahedron", octahedron(), 20_000),
        ("ball", ball(&mut random, 3), 100_000),
        ("fine ball", ball(&mut random, 4), 20_000),
        ("cube", cube(3), 50_000),
        ("needles", needles(), 50_000),
    ];
    for (name, mesh, rays) in &meshes {
        // The needles' own vertices are no multiples of 2^-12: moved far off, they are other shapes, and closed all the same.
        for (scale, offset) in [(1.0, DVec3::ZERO), (1.0, far), (small, DVec3::ZERO), (1.0 / small, far)] {
            let found = leaks(&kernel, mesh, scale, offset, *rays / 2);
            assert_eq!(
                found,
                (0, 0),
                "{name}, {scale:e} {offset}: rays that leave too often and too rarely of {}",
                rays / 2
            );
        }
        let (many, _) = leaks(&closed, mesh, 1.0, DVec3::ZERO, 2000);
        let (_, few) = leaks(&open, mesh, 1.0, DVec3::ZERO, 2000);
        assert!(many > 50 && few > 50, "{name}: {many} too many, {few} too few");
    }
}

/// Where a line meets a triangle's plane in f64, and the weights there.
fn crossing(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> (f64, [f64; 3]) {
    let normal = (b - a).cross(c - a);
    let t = normal.dot(a - origin) / normal.dot(direction);
    let point = origin + t * direction;
    let share = |p: DVec3, q: DVec3| normal.dot((p - point).cross(q - point)) / normal.length_squared();
    (t, [share(b, c), share(c, a), share(a, b)])
}

#[test]
fn distances_and_weights_are_right_to_the_last_digits() {
    const RAYS: usize = 100_000;
    let mut random = Random(72);
    let (mut triangles, mut rays) = (Vec::new(), Vec::new());
    for i in 0..RAYS {
        let size = decades(&mut random, -6.0, 6.0);
        let offset = size * decades(&mut random, -1.0, 3.0) * unit(&mut random);
        let corners = Corners::new(stout(&mut random, size).map(|p| p + offset));
        let [a, b, c] = corners.exact();
        // Within the triangle and a little around it.
        let (v, w) = (1.2 * random.uniform() - 0.1, 1.2 * random.uniform() - 0.1);
        let target = a + v * (b - a) + w * (c - a);
        let origin = rounded(target + size * decades(&mut random, -2.0, 3.0) * unit(&mut random));
        // Of any length, and some away from it.
        let length = decades(&mut random, -2.0, 2.0) * if i % 16 == 0 { -1.0 } else { 1.0 };
        let direction = rounded(length * (target - exact(origin)).normalize());
        triangles.push(corners);
        rays.push(In { origin, direction, first: i as u32, count: 1, ..In::default() });
    }
    let check = |found: &[Out]| {
        let (mut hits, mut wrong) = (0, 0);
        for ((out, corners), ray) in found.iter().zip(&triangles).zip(&rays) {
            let [a, b, c] = corners.exact();
            let (origin, direction) = (exact(ray.origin), exact(ray.direction));
            let (t, weights) = crossing(origin, direction, [a, b, c]);
            let normal = (b - a).cross(c - a);
            let cos = normal.dot(direction) / (normal.length() * direction.length());
            // The sheared vertices are off by 9 u of their distance, the slopes by 6 u of it, the point in the triangle by 17 u of
            // its size times l s / n, at most 2 for these; all across the ray, so over the cosine in the plane.
            let reach = [a, b, c].map(|p| (p - origin).length()).into_iter().fold(0.0, f64::max);
            let size = (b - a).length().max((c - b).length()).max((a - c).length());
            let bound = U * (15.0 * reach + 34.0 * size) / cos.abs();
            let altitude = normal.length() / size;
            let margin = weights.iter().copied().fold(f64::MAX, f64::min) * altitude;
            let ahead = t * direction.length();
            if out.t == NO_HIT {
                wrong += u32::from(margin > bound && ahead > bound);
                continue;
            }
            hits += 1;
            let [u, v, w] = out.barycentric.map(f64::from);
            // From a, so that the rounding of the weights' sum does not count as often as the triangle is far away.
            let point = a + v * (b - a) + w * (c - a);
            let right = margin > -bound
                && (f64::from(out.t) - t).abs() * direction.length() <= bound
                && (point - (origin + t * direction)).length() <= bound
                && u.min(v).min(w) >= 0.0
                && (u + v + w - 1.0).abs() <= 4.0 * U
                && (out.front == 1) == (cos < 0.0)
                && out.front + out.back == 1;
            wrong += u32::from(!right);
        }
        assert!(hits > RAYS / 4, "{hits} hits");
        wrong
    };
    let found = trace(&tracer(&[]), &triangles, &rays);
    assert_eq!(check(&found), 0, "rays wrong by more than the bound");
    // t and weights off by 2^-12, and the sides exchanged.
    let off = found.iter().map(|out| Out { t: if out.t == NO_HIT { NO_HIT } else { out.t * 1.00025 }, ..*out });
    assert!(check(&off.collect::<Vec<_>>()) > 10_000);
    let off = found.iter().map(|out| {
        let [u, v, w] = out.barycentric;
        Out { barycentric: [u * 0.99975, v + u * 0.00025, w], ..*out }
    });
    assert!(check(&off.collect::<Vec<_>>()) > 10_000);
    let swapped = found.iter().map(|out| Out { front: out.back, back: out.front, ..*out });
    assert!(check(&swapped.collect::<Vec<_>>()) > 10_000);
}
