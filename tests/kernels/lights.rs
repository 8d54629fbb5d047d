//! light/*: directions towards a light against their density, and the density against closed forms in f64.

use std::f64::consts::PI;

use bytemuck::Pod;
use glam::DVec3;
use gpu_rt::bitmap::Bitmap;
use gpu_rt::data::{Cuboid, Quad, Sphere};
use gpu_rt::light_distribution as host;

use crate::common::kernel::{Fault, Kernel, Setup, array};
use crate::common::light_kernel::{
    CELLS, CUBOID, DRAWS, In, Kind, Out, QUAD, QUAD_PART, SHARES, SPHERE, TRIANGLE, TRIANGLE_PART, Triangle, at_ends,
    cone, draws, spheres,
};
use crate::common::rows::rows;
use crate::common::stats::{Random, chi_square, one_sample_t, sidak, uniform_in_cells};
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// False-alarm rate of each test here.
const ALPHA: f64 = 1e-6;

/// The distribution of cells around the axis, by height and azimuth: p-values of each configuration.
fn sphere_cells(rows: &[In], shapes: &[Sphere], found: &[Out], by: fn(f64) -> f64) -> Vec<f64> {
    let one = |(row, found): (&In, &[Out])| {
        let sphere = &shapes[row.shape as usize];
        let (axis, sine, height) = cone(row, sphere);
        // The cone is drawn narrower by 12 u (light/sphere).
        let narrower = if sine < 1.0 { (1.0 - 12.0 * U / sine).powi(2) } else { 1.0 };
        let (x, y) = axis.any_orthonormal_pair();
        let points = found.iter().map(|out| {
            let direction = exact(out.direction).normalize();
            // 1 - cos, with its digits.
            let rise = (direction - axis).length_squared() / 2.0 / narrower;
            (by(rise / height), direction.dot(y).atan2(direction.dot(x)) / (2.0 * PI) + 0.5)
        });
        uniform_in_cells((31, 17), points)
    };
    rows.iter().zip(found.chunks(DRAWS)).map(one).collect()
}

#[test]
fn a_spheres_directions_are_uniform_in_its_cone() {
    // Below, the directions' own rounding of some 2 u moves more than what chi-square finds.
    let shares: Vec<f64> = SHARES.into_iter().filter(|s| (1e-4..0.9999999).contains(s)).chain([1.5, 20.0]).collect();
    let (rows, shapes) = spheres(&shares, 620);
    let found = draws(SPHERE, &rows, &shapes, &[]);
    for (share, p) in shares.iter().zip(sphere_cells(&rows, &shapes, &found, |x| x)) {
        assert!(p > sidak(ALPHA, shares.len()), "r/D {share}: p = {p:e}");
    }
    // As if the cosine's distribution were a little off.
    for (share, p) in shares.iter().zip(sphere_cells(&rows, &shapes, &found, |x| x.powf(0.9))) {
        assert!(p < ALPHA, "r/D {share}: p = {p:e}");
    }
}

/// A flat light of three or four corners in f64, as the device has it: a + x (b - a) + y (c - b), with y <= x for a
/// triangle, and c - b for d - a for a parallelogram.
#[derive(Clone, Copy, Debug)]
struct Flat {
    a: DVec3,
    along: DVec3,
    across: DVec3,
    triangle: bool,
}

/// The solid angle of a triangle (Van Oosterom and Strackee 1983, equation 8).
fn solid_angle(from: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (p, q, r) = (a - from, b - from, c - from);
    // Of differences, that it keeps its digits far away.
    let volume = p.dot((b - a).cross(c - b)).abs();
    let (x, y, z) = (p.length(), q.length(), r.length());
    2.0 * volume.atan2(x * y * z + p.dot(q) * z + q.dot(r) * x + r.dot(p) * y)
}

impl Flat {
    fn corners(&self) -> Vec<DVec3> {
        let (b, c) = (self.a + self.along, self.a + self.along + self.across);
        if self.triangle { vec![self.a, b, c] } else { vec![self.a, b, c, self.a + self.across] }
    }

    fn solid_angle(&self, from: DVec3) -> f64 {
        let corners = self.corners();
        corners[1..].windows(2).map(|two| solid_angle(from, [self.a, two[0], two[1]])).sum()
    }

    fn normal(&self) -> DVec3 {
        self.along.cross(self.across).normalize()
    }

    /// Irradiance of unit radiance on a surface with this normal above which all of the light lies: half the sum of the
    /// edges' angles times the cosines of their planes' normals (Lambert 1760; Arvo 1994, section 2).
    fn irradiance(&self, from: DVec3, normal: DVec3) -> f64 {
        let corners = self.corners();
        let edges = (0..corners.len()).map(|i| {
            let (p, q) = (corners[i] - from, corners[(i + 1) % corners.len()] - from);
            // p x q by their difference.
            let plane = p.cross(corners[(i + 1) % corners.len()] - corners[i]);
            plane.length().atan2(p.dot(q)) * plane.normalize_or_zero().dot(normal)
        });
        (edges.sum::<f64>() / 2.0).abs()
    }

    /// Where a direction meets the light's plane: x, and y or, of a triangle, y / x.
    fn coordinates(&self, from: DVec3, direction: DVec3) -> (f64, f64) {
        let n = self.along.cross(self.across);
        let t = (self.a - from).dot(n) / direction.dot(n);
        let on = t * direction - (self.a - from);
        let n2 = n.length_squared();
        let (x, y) = (on.cross(self.across).dot(n) / n2, self.along.cross(on).dot(n) / n2);
        (x, if self.triangle { y / x } else { y })
    }

    /// The part between these points, by its corners.
    fn part(&self, x: [f64; 2], y: [f64; 2]) -> [DVec3; 4] {
        let at = |x: f64, y: f64| self.a + x * self.along + if self.triangle { x * y } else { y } * self.across;
        [at(x[0], y[0]), at(x[1], y[0]), at(x[1], y[1]), at(x[0], y[1])]
    }
}

/// Cuts of 0..1: some evenly, some around a point at distances that double.
fn cuts(around: f64, width: f64) -> Vec<f64> {
    let mut cuts: Vec<f64> = (0..=7).map(|i| f64::from(i) / 7.0).collect();
    for i in -1..4 {
        cuts.extend([-1.0, 1.0].map(|side| around + side * width * 2f64.powi(i)));
    }
    cuts.retain(|x| (0.0..=1.0).contains(x));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|x, y| (*x - *y).abs() < 1e-9);
    cuts
}

/// Points from which flat lights are looked at. Heights in sizes of the light above its middle, and at angles with it.
fn views(random: &mut Random, size: f64, normal: DVec3, middle: DVec3, along: DVec3) -> Vec<(f64, DVec3)> {
    let mut found = Vec::new();
    for height in [1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        found.push((height, middle + side * height * size * normal));
        let tilted = (side * normal + 1.5 * random.uniform() * unit(random)).normalize();
        found.push((height, middle + height * size * tilted));
    }
    // Edge-on, from beside the light, and close above an edge.
    for height in [0.3, 1e-2, 1e-3, 1e-4] {
        found.push((2.0, middle + 2.0 * size * along + height * size * normal));
        found.push((20.0, middle - 20.0 * size * (along + height * normal)));
        found.push((height, middle + 0.5 * size * along + height * size * normal));
    }
    found
}

struct Case {
    row: In,
    /// The light's sides that are seen.
    flats: Vec<Flat>,
    /// Distance from the middle or height, in sizes.
    far: f64,
    /// Roundings on the way to a corner, in those of an offset from the point.
    steps: f64,
}

/// Lights of all sizes, some of them ten times as long as wide, some oblique, and what looks at them.
fn flats(triangle: bool, seed: u64) -> (Vec<Case>, Vec<Triangle>, Vec<Quad>) {
    let mut random = Random(seed);
    let (mut cases, mut triangles, mut quads) = (Vec::new(), Vec::new(), Vec::new());
    for shape in 0..4 {
        let size = decades(&mut random, -3.0, 1.0);
        let along = size * unit(&mut random);
        let width = [1.0, 0.8, 0.1, 0.7][shape];
        let mut across = width * size * along.cross(unit(&mut random)).normalize();
        if shape >= 1 {
            across += [0.0, 0.4, 0.3, -0.6][shape] * along;
        }
        let (along, across) = (rounded(along), rounded(across));
        let middle = [2.0 / 3.0, 1.0 / 3.0].map(|x| if triangle { x } else { 0.45 });
        let corner = rounded(-middle[0] * exact(along) - middle[1] * exact(across));
        let of_shape = shape as u32;
        let flat = if triangle {
            let b = rounded(exact(corner) + exact(along));
            let c = rounded(exact(b) + exact(across));
            triangles.push(Triangle { a: corner, b, c, ..Triangle::default() });
            Flat { a: exact(corner), along: exact(b) - exact(corner), across: exact(c) - exact(b), triangle }
        } else {
            let (u, v) = (exact(along), exact(across));
            let n = u.cross(v);
            let w = n / n.length_squared();
            quads.push(Quad {
                corner,
                normal: rounded(n.normalize()),
                a_axis: rounded(v.cross(w)),
                b_axis: rounded(w.cross(u)),
                u: along,
                v: across,
                error: (8.0 * U * 3.0 * size) as f32,
                ..Quad::default()
            });
            Flat { a: exact(corner), along: u, across: v, triangle }
        };
        for (far, from) in views(&mut random, size, flat.normal(), DVec3::ZERO, flat.along.normalize()) {
            cases.push(Case {
                row: In { from: rounded(from), shape: of_shape, ..In::default() },
                flats: vec![flat],
                far,
                steps: 1.0,
            });
        }
    }
    (cases, triangles, quads)
}

/// Bound of the relative error of a solid angle 2 atan2(V, B) in f32, with V and B over the product of the lengths, for a
/// triangle whose corners are off by 2 u of the `reach` of the sums that they come from. Each direction is then off by
/// d = 2 u reach / its length + 3 u, and V by the corner's offset and 8 u of its product with the edges' cross product and
/// 6 u of V, B by twice the sum of the d and 8 u; angle_of by 10 u.
fn area_error(from: DVec3, [a, b, c]: [DVec3; 3], reach: f64) -> f64 {
    let (p, q, r) = ((a - from).length(), (b - from).length(), (c - from).length());
    let n = (b - a).cross(c - b).length();
    let directions: f64 = [p, q, r].iter().map(|length| 2.0 * U * reach / length + 3.0 * U).sum();
    let volume = (a - from).dot((b - a).cross(c - b)).abs() / (p * q * r);
    let off_volume = 10.0 * U * (b - a).length() * (c - b).length().max((a - c).length()) / (q * r)
        + (2.0 * U * reach / p) * n / (q * r)
        + (directions + 6.0 * U) * volume;
    let off_beside = 2.0 * directions + 8.0 * U;
    let beside = 1.0
        + ((a - from).dot(b - from) / (p * q))
        + ((b - from).dot(c - from) / (q * r))
        + ((c - from).dot(a - from) / (r * p));
    let squared = volume * volume + beside * beside;
    2.0 * (beside.abs() * off_volume + volume * off_beside) / squared + 10.0 * U * solid_angle(from, [a, b, c])
}

impl Case {
    fn from(&self) -> DVec3 {
        exact(self.row.from)
    }

    /// The solid angle, and a bound of the relative error of the density.
    fn solid_angle(&self) -> (f64, f64) {
        let from = self.from();
        let (mut full, mut off) = (0.0, 0.0);
        for flat in &self.flats {
            let corners = flat.corners();
            let reach = self.steps * ((flat.a - from).length() + flat.along.length() + flat.across.length());
            full += flat.solid_angle(from);
            off += corners[1..].windows(2).map(|two| area_error(from, [flat.a, two[0], two[1]], reach)).sum::<f64>();
        }
        (full, off / full + 4.0 * U)
    }
}

/// How the cases of a light differ from what they must be: densities that are wrong, configurations whose directions are
/// not uniform, and whose irradiance is not Lambert's.
fn compare<S: Pod>(kind: Kind, cases: &[Case], shapes: &[S], replaced: &[Fault<'_>]) -> [u32; 3] {
    differences(cases, &drawn_of(kind, cases, shapes, replaced))
}

fn drawn_of<S: Pod>(kind: Kind, cases: &[Case], shapes: &[S], replaced: &[Fault<'_>]) -> Vec<Out> {
    draws(kind, &cases.iter().map(|case| case.row).collect::<Vec<_>>(), shapes, replaced)
}

impl Case {
    /// Whether a density is wrong. Of a light so nearly edge-on that its solid angle has no digits, none is.
    fn is_wrong(&self, found: &[Out]) -> bool {
        let (full, error) = self.solid_angle();
        let is_right = |out: &Out| out.pdf == out.again && (f64::from(out.pdf) * full - 1.0).abs() < error;
        error <= 0.1 && !found.iter().all(is_right)
    }
}

fn differences(cases: &[Case], found: &[Out]) -> [u32; 3] {
    let threshold = sidak(ALPHA, cases.len());
    let mut wrong = [0; 3];
    for (case, found) in cases.iter().zip(found.chunks(DRAWS)) {
        let from = case.from();
        let (full, error) = case.solid_angle();
        if error > 0.1 {
            continue;
        }
        wrong[0] += u32::from(case.is_wrong(found));
        let (p, is_testable) = uniformity(case, found, full);
        // Cells tell shares that are off by some percent, and parts of the solid angle may be off by as much as the whole.
        wrong[1] += u32::from(is_testable && error < 1e-2 && p < threshold);

        // On a surface that sees all of the light: that faces its plane or, of several sides, its middle.
        let middle = case.flats.iter().map(|flat| flat.a + 0.5 * (flat.along + flat.across) - from).sum::<DVec3>();
        let first = &case.flats[0];
        let normal = match case.flats.len() {
            1 => first.normal() * (first.a - from).dot(first.normal()).signum(),
            _ => middle.normalize(),
        };
        if !case.flats.iter().all(|flat| flat.corners().iter().all(|corner| (*corner - from).dot(normal) > 0.0)) {
            continue;
        }
        let lambert: f64 = case.flats.iter().map(|flat| flat.irradiance(from, normal)).sum();
        let values: Vec<f64> =
            found.iter().map(|out| exact(out.direction).dot(normal).max(0.0) / f64::from(out.pdf) / lambert).collect();
        let test = one_sample_t(&values, 1.0);
        // Beside the noise, the density's error, and the direction's of 3 u by the cosine.
        let off = error + 4.0 * U * full / lambert;
        wrong[2] += u32::from(!(test.p > threshold || test.difference.abs() < off));
    }
    wrong
}

/// The p-value of the directions' being uniform, by cells of the light's sides, and whether it can be tested.
fn uniformity(case: &Case, found: &[Out], full: f64) -> (f64, bool) {
    let from = case.from();
    let mut expected = Vec::new();
    let mut grids = Vec::new();
    let mut is_testable = case.far <= 1e4;
    for flat in &case.flats {
        let foot = flat.coordinates(from, flat.normal());
        let height = (flat.a - from).dot(flat.normal()).abs();
        let (xs, ys) = (cuts(foot.0, height / flat.along.length()), cuts(foot.1, height / flat.across.length()));
        grids.push((expected.len(), xs.clone(), ys.clone()));
        for x in xs.windows(2) {
            for y in ys.windows(2) {
                let [a, b, c, d] = flat.part([x[0], x[1]], [y[0], y[1]]);
                let share = (solid_angle(from, [a, b, c]) + solid_angle(from, [a, c, d])) / full;
                expected.push(share * found.len() as f64);
            }
        }
        // Further away, and at flatter angles, the roundings of the directions carry too many over the cells' edges.
        let size = flat.along.length().min(flat.across.length());
        let distance = flat.corners().iter().map(|corner| (*corner - from).length()).fold(0.0, f64::max);
        is_testable &= case.far < 1.0 || U * distance * distance / (size * height) < 2e-4;
    }
    let mut cells = vec![0u64; expected.len()];
    let cell = |cuts: &[f64], at: f64| cuts.partition_point(|cut| *cut <= at).clamp(1, cuts.len() - 1) - 1;
    for out in found {
        // The side that the direction meets, or passes by least.
        let points = case.flats.iter().zip(&grids).map(|(flat, grid)| {
            let (x, y) = flat.coordinates(from, exact(out.direction));
            let outside = (-x).max(x - 1.0).max(-y).max(y - 1.0);
            (if outside.is_nan() { f64::MAX } else { outside.max(0.0) }, x, y, grid)
        });
        let (_, x, y, (first, xs, ys)) = points.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a light has a side");
        cells[first + cell(xs, x) * (ys.len() - 1) + cell(ys, y)] += 1;
    }
    (chi_square(&cells, &expected, 1), is_testable)
}

/// Unit directions and finite densities, the same from both functions, whatever the uniforms.
fn ends_are_numbers<S: Pod>(kind: Kind, rows: &[In], shapes: &[S]) {
    for (row, out) in at_ends(kind, rows, shapes) {
        let length = exact(out.direction).length();
        assert!((length - 1.0).abs() < 1e-6 && out.pdf.is_finite() && out.pdf >= 0.0, "{row:?} {out:?}");
        assert_eq!(out.pdf, out.again, "{row:?} {out:?}");
        assert!((out.pdf * out.pdf).is_finite(), "{row:?} {out:?}");
    }
}

/// Points in the light's plane, on its edges and corners, an ulp beside them, and up to 1e12 sizes away on either side.
fn awkward(flats: &[Flat], random: &mut Random) -> Vec<In> {
    let mut rows = Vec::new();
    for (shape, flat) in (0..).zip(flats) {
        let size = flat.along.length();
        let x = [0.0, 1.0, 1.0, 0.5, 0.5, 1.0, 0.6, 3.0, -2.0];
        let y = [0.0, 0.0, 1.0, 0.0, 0.5, 0.5, 0.3, 0.0, 1.0];
        for (x, y) in x.into_iter().zip(y) {
            let on = flat.a + x * flat.along + y * flat.across;
            for height in [0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3, 0.1, 1.0, 1e4, 1e8, 1e12] {
                for height in [height, -height] {
                    rows.push(In { from: rounded(on + height * size * flat.normal()), shape, ..In::default() });
                }
            }
            rows.push(In { from: rounded(on + 1e-7 * size * unit(random)), shape, ..In::default() });
        }
        rows.push(In { from: rounded(1e6 * size * unit(random)), shape, ..In::default() });
        rows.push(In { from: rounded(1e12 * size * unit(random)), shape, ..In::default() });
        rows.push(In { from: rounded(1e6 * flat.along), shape, ..In::default() });
    }
    rows
}

/// The light of each shape.
fn own_flats(cases: &[Case]) -> Vec<Flat> {
    let mut found: Vec<(u32, Flat)> = cases.iter().map(|case| (case.row.shape, case.flats[0])).collect();
    found.dedup_by_key(|(shape, _)| *shape);
    found.into_iter().map(|(_, flat)| flat).collect()
}

/// Directions to points uniform over the area, with the density in the total solid angle, and that from the sum of the angles less pi, which has no
/// digits where it is small (Girard).
const PLANAR: [Fault<'_>; 2] = [
    (
        "light/spherical",
        "let area = 2.0 * angle_of(shape, denominator);",
        "let pa = normalize(cross(p.direction, a.direction));
        let ac = normalize(cross(a.direction, c.direction));
        let cp = normalize(cross(c.direction, p.direction));
        let area = acos(-dot(pa, ac)) + acos(-dot(ac, cp)) + acos(-dot(cp, pa)) - 3.14159265;",
    ),
    (
        "light/spherical",
        "return normalize((1.0 - height) * p.direction + sqrt(height * (2.0 - height)) * tangent);",
        "let area = spherical_area(p, a, c, abs(determinant));
        return normalize(p.distance * p.direction + sqrt(v) * (to_a + min(part / area, 1.0) * to_c));",
    ),
];

/// Compares the cases of a light, and finds planar sampling in at least so many of them.
fn judge<S: Pod>(kind: Kind, cases: &[Case], shapes: &[S], awkward: &[In], least: [u32; 3]) {
    assert_eq!(compare(kind, cases, shapes, &[]), [0; 3]);
    let planted = compare(kind, cases, shapes, &PLANAR);
    assert!(planted.iter().zip(least).all(|(planted, least)| *planted > least), "{planted:?}");
    ends_are_numbers(kind, awkward, shapes);
}

#[test]
fn a_triangles_directions_are_uniform_and_light_as_lambert_says() {
    let (cases, shapes, _) = flats(true, 680);
    judge(TRIANGLE, &cases, &shapes, &awkward(&own_flats(&cases), &mut Random(681)), [20, 20, 10]);
}

#[test]
fn a_quads_directions_are_uniform_and_light_as_lambert_says() {
    let (cases, _, shapes) = flats(false, 690);
    judge(QUAD, &cases, &shapes, &awkward(&own_flats(&cases), &mut Random(691)), [20, 20, 10]);
}

/// The part of a light, and its row in the table of shapes changed so that it has this part.
fn in_parts<S>(cases: &mut [Case], shapes: &mut [S], set: fn(&mut S, u32)) {
    shapes.iter_mut().zip(CELLS).for_each(|(shape, cell)| set(shape, cell.code()));
    for case in cases {
        let cell = CELLS[case.row.shape as usize];
        let (low, [x, y]) = (cell.low(), cell.size());
        let Flat { a, along, across, triangle } = case.flats[0];
        // The second coordinate of a triangle is the weight of its third corner.
        let second = if triangle { along + across } else { across };
        let is_above = triangle && cell.is_above;
        let first = if is_above { [low[0] + x, low[1] + y] } else { low };
        let side = if is_above { -1.0 } else { 1.0 };
        let (along, second) = (side * x * along, side * y * second);
        let across = if triangle { second - along } else { second };
        let a = a
            + first[0] * case.flats[0].along
            + first[1] * (if triangle { case.flats[0].along } else { DVec3::ZERO } + case.flats[0].across);
        case.flats = vec![Flat { a, along, across, triangle }];
        // A part is at least a quarter of its shape along each edge, and the shape's edges are rounded.
        case.steps = 12.0;
    }
}

/// Directions to a part are uniform in its own solid angle. Planted: a part that is larger by 1 % along an edge, and the cell beside it.
#[test]
fn directions_to_parts_are_uniform_and_light_as_lambert_says() {
    let (mut cases, mut triangles, _) = flats(true, 720);
    in_parts(&mut cases, &mut triangles, |shape, part| shape.padding0 = f32::from_bits(part));
    let (mut of_quads, _, mut quads) = flats(false, 730);
    in_parts(&mut of_quads, &mut quads, |shape, part| shape.light = part);
    let found = [drawn_of(TRIANGLE_PART, &cases, &triangles, &[]), drawn_of(QUAD_PART, &of_quads, &quads, &[])];
    for (cases, found) in [&cases, &of_quads].into_iter().zip(&found) {
        assert_eq!(differences(cases, found), [0; 3]);
        for (moved, factor) in [(0.0, 1.01), (0.5, 1.0)] {
            let is_found = |(case, found): &(&Case, &[Out])| {
                let flat = case.flats[0];
                let other = Flat { a: flat.a + moved * flat.along, along: factor * flat.along, ..flat };
                Case { flats: vec![other], ..**case }.is_wrong(found)
            };
            let planted = cases.iter().zip(found.chunks(DRAWS)).filter(is_found).count();
            assert!(planted > 50, "moved by {moved}, {factor} times as long: {planted}");
        }
    }
}

/// Boxes of all sizes, some flat and some long, turned any way, and what looks at them from outside.
fn cuboids(seed: u64) -> (Vec<Case>, Vec<Cuboid>) {
    let mut random = Random(seed);
    let (mut cases, mut shapes) = (Vec::new(), Vec::new());
    for shape in 0..3 {
        let size = decades(&mut random, -3.0, 1.0);
        let half = [[0.5, 0.5, 0.5], [0.5, 0.3, 0.05], [0.5, 0.1, 0.2]][shape].map(|x| (x * size) as f32);
        let x = unit(&mut random);
        let y = x.cross(unit(&mut random)).normalize();
        let cuboid = Cuboid { half_extent: half, x_axis: rounded(x), y_axis: rounded(y), ..Cuboid::default() };
        let axes = [exact(cuboid.x_axis), exact(cuboid.y_axis), exact(cuboid.x_axis).cross(exact(cuboid.y_axis))];
        let reach = [0, 1, 2].map(|i| f64::from(half[i]) * axes[i]);
        let mut from_points = views(&mut random, size, axes[0], reach[0], axes[1]);
        for far in [0.6, 1.0, 3.0, 100.0, 1e4, 1e6] {
            from_points.extend([0; 3].map(|_| (far, (0.9 + far) * size * unit(&mut random))));
        }
        for (far, from) in from_points {
            let from = rounded(from);
            let local = axes.map(|axis| axis.dot(exact(from)));
            let mut flats = Vec::new();
            for i in 0..3 {
                // On which side of the face the point lies must be beyond its rounding.
                if local[i].abs() > f64::from(half[i]) {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let a = local[i].signum() * reach[i] - reach[j] - reach[k];
                    flats.push(Flat { a, along: 2.0 * reach[j], across: 2.0 * reach[k], triangle: false });
                }
            }
            if flats.is_empty() {
                continue;
            }
            // The turn into the box's axes takes three roundings of each product, and the axes are off by one.
            cases.push(Case { row: In { from, shape: shape as u32, ..In::default() }, flats, far, steps: 4.0 });
        }
        shapes.push(cuboid);
    }
    (cases, shapes)
}

#[test]
fn a_cuboids_directions_are_uniform_and_light_as_lambert_says() {
    let (cases, shapes) = cuboids(700);
    assert!(cases.iter().filter(|case| case.flats.len() == 3).count() > 20);
    // Inside, on faces, edges and corners, and beside them.
    let mut random = Random(701);
    let mut rows = Vec::new();
    for (index, shape) in (0..).zip(&shapes) {
        let axes = [exact(shape.x_axis), exact(shape.y_axis), exact(shape.x_axis).cross(exact(shape.y_axis))];
        for i in 0..125 {
            let at = [i % 5, i / 5 % 5, i / 25].map(|x| [-1.0, -0.4, 0.0, 1.0, 5.0][x]);
            let from: DVec3 = (0..3).map(|i| at[i] * f64::from(shape.half_extent[i]) * axes[i]).sum();
            for off in [0.0, 1e-7, 1e-5] {
                let off = off * f64::from(shape.half_extent[0]) * unit(&mut random);
                rows.push(In { from: rounded(from + off), shape: index, ..In::default() });
            }
        }
    }
    judge(CUBOID, &cases, &shapes, &rows, [10, 20, 10]);
    let inside = In { from: rounded(0.3 * f64::from(shapes[0].half_extent[0]) * unit(&mut random)), ..In::default() };
    for (_, out) in at_ends(CUBOID, &[inside], &shapes) {
        assert!((f64::from(out.pdf) * 4.0 * PI - 1.0).abs() < 4.0 * U && out.distance > 0.0, "{out:?}");
    }
}

const UNIFORMS: usize = 1 << 24;

/// How often each entry is drawn by all 2^24 uniforms.
fn drawn(entries: &[host::Draw], replaced: &[Fault<'_>]) -> Vec<u64> {
    // The buffer may be longer than the table.
    let count = entries.len().to_string();
    let values = [("count", &*count)];
    let kernel = Kernel::with("test/light_alias", &Setup { replaced, values: &values, ..Setup::default() });
    let mut counts = vec![0; entries.len()];
    let input: Vec<[u32; 2]> = entries.iter().map(|entry| [entry.threshold.to_bits(), entry.alias]).collect();
    for found in kernel.run_with::<_, [u32; 8]>(&input, UNIFORMS / 8, &[]) {
        for index in found {
            counts[index as usize] += 1;
        }
    }
    counts
}

/// Weights over many decades, and even ones; counts that divide 2^24, and those that do not.
fn weights() -> Vec<Vec<f64>> {
    let mut random = Random(710);
    let mut some = |count: usize, low: f64| (0..count).map(|_| decades(&mut random, low, 0.0)).collect::<Vec<_>>();
    let sparse = some(1000, -3.0).into_iter().enumerate().map(|(i, w)| if i % 3 == 1 { w } else { 0.0 }).collect();
    let mut one = vec![1e-12; 4097];
    one[4000] = 1e20;
    let huge = some(7, -2.0).iter().map(|w| w * 1e308).collect();
    let (few, many, wide) = (some(3, -1.0), some(100_003, -2.0), some(65_536, -9.0));
    vec![vec![1.0], vec![0.0, 2.5], vec![1.0; 24], few, many, wide, sparse, one, huge, vec![1e-310; 5]]
        .into_iter()
        // Weights that are the mean, beside ones of 0: their entries need all numbers that find them.
        .chain([vec![2.0, 0.0, 1.0, 1.0, 0.0, 2.0], vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 3.0, 3.0, 3.0]])
        .collect()
}

/// All uniforms there are, so nothing of it is left to chance.
#[test]
fn tables_are_drawn_with_exactly_the_probabilities_that_they_state() {
    for weights in weights() {
        let table = host::alias_table(&weights).expect("some weight is positive");
        let counts = drawn(&table, &[]);
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let sum: f64 = weights.iter().map(|w| w / largest).sum();
        let positive = weights.iter().filter(|w| **w > 0.0).count() as f64;
        for ((entry, count), weight) in table.iter().zip(&counts).zip(&weights) {
            assert_eq!(f64::from(entry.probability) * UNIFORMS as f64, *count as f64);
            assert_eq!(entry.alias_probability, table[entry.alias as usize].probability);
            assert_eq!(*count > 0, *weight > 0.0);
            // One of each goes to those that would have none: what is left is smaller by their share at most.
            let wanted = weight / largest / sum * UNIFORMS as f64;
            assert!((*count as f64 - wanted).abs() <= 2.0 + wanted * positive / UNIFORMS as f64, "{count} of {wanted}");
        }
        assert_eq!(counts.iter().sum::<u64>(), UNIFORMS as u64);
    }
    // The product rounded to f32, as it is usually done.
    let table = host::alias_table(&weights()[4]).expect("some weight is positive");
    let rounded = "AliasPick(min(u32(u * f32(count)), count - 1u), fract(u * f32(count)))";
    let counts = drawn(&table, &[("light/alias", "AliasPick(high, f32(low & 0xffffffu) * 0x1p-24f)", rounded)]);
    let off = |(entry, count): &(&host::Draw, &u64)| f64::from(entry.probability) * UNIFORMS as f64 != **count as f64;
    assert!(table.iter().zip(&counts).filter(off).count() > 1000);
}

#[test]
fn tables_of_nothing_are_none() {
    let none: [&[f64]; 5] = [&[], &[0.0, 0.0], &[1.0, -1.0], &[1.0, f64::NAN], &[1.0, f64::INFINITY]];
    for weights in none.into_iter().chain([&*vec![1.0; host::MAX_ENTRIES + 1]]) {
        assert_eq!(host::alias_table(weights), None);
    }
    assert_eq!(host::SkyDistribution::new(&Bitmap::of_floats(2, 1, [[0.0; 3]; 2]), 0.0), None);
    assert_eq!(host::SkyDistribution::new(&Bitmap::of_floats(0, 0, []), 0.0), None);
}

rows! {
    struct SkyIn { u: [f32; 2], columns: u32, rows: u32 }

    /// A point from the left and from the top, and its density again by the direction.
    struct SkyOut {
        direction: [f32; 3], pdf: f32,
        point: [f32; 2], again: f32, padding: u32,
    }
}

/// How the kernel gets its points, and from which row.
const BY_INDEX: [&str; 2] = ["sky_point(random4(index, 0u, 0u, 1u).xy, given.columns, given.rows)", "0u"];
const BY_UNIFORMS: [&str; 2] = ["sky_point(given.u, given.columns, given.rows)", "index"];
const GIVEN: [&str; 2] = ["given.u", "index"];

fn sky_samples(sky: &host::SkyDistribution, [point, row]: [&str; 2], given: &[[f32; 2]], count: usize) -> Vec<SkyOut> {
    let kernel =
        Kernel::with("test/light_sky", &Setup { values: &[("point", point), ("row", row)], ..Setup::default() });
    let rows: Vec<SkyIn> = given.iter().map(|u| SkyIn { u: *u, columns: sky.columns, rows: sky.rows }).collect();
    kernel.run_with(&rows, count, &[array("sky", &sky.sums)])
}

/// An image of texels over three decades, a third of them black, with a sun of a texel.
fn sky(width: usize, height: usize, random: &mut Random) -> Vec<[f32; 3]> {
    let mut texels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| [0; 3].map(|_| if i % 3 == 0 { 0.0 } else { decades(random, -2.0, 1.0) as f32 }))
        .collect();
    // Beside the brightest, all others have one part each.
    let sun = if width > 4000 { 1e12 } else { 3e3 };
    texels[width * (height / 4) + width / 3] = [sun, sun, 0.7 * sun];
    texels
}

fn distribution(width: usize, height: usize, texels: &[[f32; 3]]) -> host::SkyDistribution {
    let image = Bitmap::of_floats(width as u32, height as u32, texels.iter().copied());
    host::SkyDistribution::new(&image, 0.0).expect("it is not black")
}

/// The parts of a row and of a texel in it.
fn parts(sky: &host::SkyDistribution, column: usize, row: usize) -> [u32; 2] {
    let texel = sky.rows as usize + 1 + row * (sky.columns as usize + 1) + column;
    [row, texel].map(|at| sky.sums[at + 1] - sky.sums[at])
}

/// The probability of a texel. The columns go on beyond the edges, and the rows end there.
fn probability(sky: &host::SkyDistribution, column: i64, row: i64) -> f64 {
    let (column, row) = (column.rem_euclid(i64::from(sky.columns)), row.clamp(0, i64::from(sky.rows) - 1));
    let [row, texel] = parts(sky, column as usize, row as usize).map(|n| f64::from(n) / UNIFORMS as f64);
    row * texel
}

/// The last two are larger than the most columns and rows.
const SKIES: [(usize, usize); 9] =
    [(1, 1), (2, 1), (8, 4), (64, 32), (63, 31), (1000, 7), (1024, 512), (4097, 3), (3, 5000)];

#[test]
fn the_skys_table_has_its_texels_and_none_of_the_light_has_no_part() {
    let mut random = Random(720);
    for (width, height) in SKIES {
        let texels = if width == 1 { vec![[0.5, 0.0, 0.0]] } else { sky(width, height, &mut random) };
        let image = Bitmap::of_floats(width as u32, height as u32, texels.iter().copied());
        // Of 0.106, the luminance of the one texel, and of texels over three decades.
        const BASE: f64 = 0.1;
        let sky = host::SkyDistribution::new(&image, BASE).expect("it is brighter");
        let (columns, rows) = (sky.columns as usize, sky.rows as usize);
        let is_whole = width <= host::MOST_COLUMNS && height <= host::MOST_ROWS;
        assert!(columns <= host::MOST_COLUMNS && rows <= host::MOST_ROWS);
        assert_eq!(is_whole, (columns, rows) == (width, height));
        assert_eq!(sky.sums.len(), rows + 1 + rows * (columns + 1));
        // Each list goes from 0 to all parts; that of a black row is 0.
        let (of_rows, of_texels) = sky.sums.split_at(rows + 1);
        for (i, list) in std::iter::once(of_rows).chain(of_texels.chunks(columns + 1)).enumerate() {
            let full = if i > 0 && of_rows[i] == of_rows[i - 1] { 0 } else { UNIFORMS as u32 };
            let ends = (list[0], list[list.len() - 1]);
            assert!(list.is_sorted() && ends == (0, full), "{width} x {height}, list {i}: {ends:?}");
        }
        let luminance = |x: usize, y: usize| {
            let texel = texels[y * width + x];
            0.2126 * f64::from(texel[0]) + 0.7152 * f64::from(texel[1]) + 0.0722 * f64::from(texel[2])
        };
        // Of each texel of the table, the texels of the image that it has a share in, and their luminance by its share.
        let share = |i: usize, count: usize, of: usize, side: usize| {
            let (start, end) = (of as f64 * side as f64 / count as f64, (of + 1) as f64 * side as f64 / count as f64);
            (end.min((i + 1) as f64) - start.max(i as f64)).max(0.0)
        };
        let mut weights = vec![0.0; columns * rows];
        for y in 0..height {
            for x in 0..width {
                for row in (y * rows / height).saturating_sub(1)..rows.min(y * rows / height + 2) {
                    for column in (x * columns / width).saturating_sub(1)..columns.min(x * columns / width + 2) {
                        let of = share(x, columns, column, width) * share(y, rows, row, height);
                        weights[row * columns + column] +=
                            of * luminance(x, y) * ((row as f64 + 0.5) * PI / rows as f64).sin();
                    }
                }
            }
        }
        let plain = weights.clone();
        for (i, weight) in weights.iter_mut().enumerate() {
            let size = ((i / columns) as f64 + 0.5) * PI / rows as f64;
            let area = (width * height) as f64 / (columns * rows) as f64;
            *weight = (*weight - BASE * area * size.sin()).max(0.0);
        }
        let sum: f64 = weights.iter().sum();
        // A part for the rounding, and a part of each entry for those that would have none.
        let is_near = |parts: u32, weight: f64, of: f64, count: usize| {
            let off = 2.0 + (weight / of) * (count as f64 + 1e-3);
            (f64::from(parts) - weight / of * UNIFORMS as f64).abs() < off
        };
        let (mut told, mut told_of_base) = (0, 0);
        for row in 0..rows {
            let [texels, plain] = [&weights, &plain].map(|weights| &weights[row * columns..][..columns]);
            let [of_row, of_plain] = [texels, plain].map(|weights| weights.iter().sum::<f64>());
            for (column, weight) in texels.iter().enumerate() {
                let [in_rows, in_row] = parts(&sky, column, row);
                assert_eq!(in_rows > 0 && in_row > 0, *weight > 0.0, "{width} x {height}, texel {column}, {row}");
                if *weight > 0.0 {
                    assert!(is_near(in_rows, of_row, sum, rows), "{width} x {height}, row {row}");
                    assert!(is_near(in_row, *weight, of_row, columns), "{width} x {height}, texel {column}, {row}");
                    // With its neighbour's radiance it would be another.
                    told += usize::from(!is_near(in_row, texels[(column + 1) % columns], of_row, columns));
                    told_of_base += usize::from(!is_near(in_row, plain[column], of_plain, columns));
                }
            }
        }
        assert!(!is_whole || width < 8 || told_of_base > columns * rows / 4, "{width} x {height}: {told_of_base}");
        assert!(!is_whole || width < 8 || told > columns * rows / 4, "{width} x {height}: {told}");
    }
}

/// All uniforms there are, so nothing of it is left to chance.
#[test]
fn a_uniform_draws_each_entry_as_often_as_it_has_parts_and_neighbours_stay_neighbours() {
    let mut random = Random(725);
    for (width, is_wrong) in [(7, false), (4096, false), (7, true)] {
        let texels = sky(width, 1, &mut random);
        let sky = distribution(width, 1, &texels);
        let count = width.to_string();
        // The first sum that is no less, instead of the first that is greater: each entry gives a part to the one before it.
        let late = ("scene/sky", "sky[first + middle] > k", "sky[first + middle] >= k");
        let replaced = if is_wrong { &[late][..] } else { &[] };
        let kernel =
            Kernel::with("test/sky_draws", &Setup { replaced, values: &[("count", &count)], ..Setup::default() });
        // The list of the columns begins after the two sums of the row.
        let found: Vec<[[u32; 8]; 2]> = kernel.run_with(&[2u32], UNIFORMS / 8, &[array("sky", &sky.sums)]);
        let mut counts = vec![0; width];
        let (mut before, mut backward) = (-1.0, 0);
        for (index, rest) in found.iter().flat_map(|[index, rest]| index.iter().zip(rest)) {
            counts[*index as usize] += 1;
            let rest = f32::from_bits(*rest);
            let at = f64::from(*index) + f64::from(rest);
            backward += usize::from(!(0.0..=1.0).contains(&rest) || at < before);
            before = at;
        }
        let wrong = (0..width).filter(|column| parts(&sky, *column, 0)[1] != counts[*column]).count();
        match is_wrong {
            true => assert!(wrong > 1 && backward > 1, "{wrong} {backward}"),
            false => assert_eq!((wrong, backward), (0, 0), "{width}"),
        }
    }
}

/// The shares of the parts of a texel, `PER_TEXEL` a side, in the tents around the texel before it, itself, and the one after.
const PER_TEXEL: usize = 4;

fn tents(part: usize) -> [f64; 3] {
    let until = |t: f64| match t.clamp(-1.0, 1.0) {
        t if t < 0.0 => 0.5 * (t + 1.0) * (t + 1.0),
        t => 1.0 - 0.5 * (1.0 - t) * (1.0 - t),
    };
    let edge = |part: usize, centre: f64| part as f64 / PER_TEXEL as f64 - centre;
    [-0.5, 0.5, 1.5].map(|centre| until(edge(part + 1, centre)) - until(edge(part, centre)))
}

/// Within a texel everywhere the same.
fn uniform(_: usize) -> [f64; 3] {
    [0.0, 1.0 / PER_TEXEL as f64, 0.0]
}

/// The probabilities of the parts of all texels.
fn of_parts(sky: &host::SkyDistribution, shares: fn(usize) -> [f64; 3]) -> Vec<f64> {
    let (columns, rows) = (sky.columns as usize * PER_TEXEL, sky.rows as usize * PER_TEXEL);
    let one = |i: usize| {
        let (x, y) = (i % columns, i / columns);
        let (across, down) = (shares(x % PER_TEXEL), shares(y % PER_TEXEL));
        let of = |i: usize, j: usize| {
            let (column, row) = ((x / PER_TEXEL + i) as i64 - 1, (y / PER_TEXEL + j) as i64 - 1);
            across[i] * down[j] * probability(sky, column, row)
        };
        (0..9).map(|k| of(k % 3, k / 3)).sum()
    };
    (0..columns * rows).map(one).collect()
}

#[test]
fn sky_directions_are_drawn_by_the_interpolated_radiance() {
    const DRAWS: usize = 1 << 19;
    let mut random = Random(730);
    for (width, height) in [(64usize, 32usize), (63, 31), (100, 7), (2, 1)] {
        let sky = distribution(width, height, &sky(width, height, &mut random));
        let found = sky_samples(&sky, BY_INDEX, &[[0.0; 2]], DRAWS);
        let mut counts = vec![0u64; width * height * PER_TEXEL * PER_TEXEL];
        for out in &found {
            let [x, y] = out.point.map(f64::from);
            let part = |at: f64, count: usize| ((at * (count * PER_TEXEL) as f64) as usize).min(count * PER_TEXEL - 1);
            counts[part(y, height) * width * PER_TEXEL + part(x, width)] += 1;
            // The direction is that of the point.
            let (around, down) = (2.0 * PI * (x - 0.5), PI * y);
            let wanted = DVec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos());
            assert!((exact(out.direction) - wanted).length() < 16.0 * U, "{width} x {height}: {out:?}");
            // The density there, by the texels around it.
            let (x, y) = (x * width as f64 - 0.5, y * height as f64 - 0.5);
            let at = |i: usize| {
                probability(&sky, x.floor() as i64 + (i % 4) as i64 - 1, y.floor() as i64 + (i / 4) as i64 - 1)
            };
            let (s, t) = (x - x.floor(), y - y.floor());
            let between = (1.0 - t) * ((1.0 - s) * at(5) + s * at(6)) + t * ((1.0 - s) * at(9) + s * at(10));
            let sine = down.sin();
            let scale = (width * height) as f64 / (2.0 * PI * PI * sine);
            // The coordinates in texels are rounded twice, by which the texels beside count, and the rest has 32 roundings. A sine near the
            // poles has the error of the direction.
            let most = (0..16).map(at).fold(0.0, f64::max);
            let near = |pdf: f32, off: f64| {
                (f64::from(pdf) - scale * between).abs()
                    <= scale * (32.0 * U * between + off * most) + 16.0 * U / sine * scale * most
            };
            assert!(
                near(out.pdf, 4.0 * U * (width + height) as f64),
                "{width} x {height}: {out:?} {}",
                scale * between
            );
            // The direction is off by 4 u, and its angles by 8 u; around the poles over the sine.
            assert!(near(out.again, 16.0 * U * (width as f64 / sine + height as f64)), "{width} x {height}: {out:?}");
        }
        let expected = |shares| of_parts(&sky, shares).into_iter().map(|p| p * DRAWS as f64).collect::<Vec<_>>();
        let p = chi_square(&counts, &expected(tents), 1);
        assert!(p > sidak(ALPHA, 4), "{width} x {height}: p = {p:e}");
        // As if places in texels were uniform; and the neighbours' counts.
        let p = chi_square(&counts, &expected(uniform), 1);
        assert!(p < ALPHA, "{width} x {height}, uniform: p = {p:e}");
        counts.rotate_left(PER_TEXEL);
        assert!(chi_square(&counts, &expected(tents), 1) < ALPHA);
        // The integral of the density over all directions, at four points a side of each texel: it is linear in each half of a texel.
        let points: Vec<[f32; 2]> = (0..counts.len())
            .map(|i| [i % (width * PER_TEXEL), i / (width * PER_TEXEL)])
            .map(|[x, y]| [x as f64 / width as f64, y as f64 / height as f64])
            .map(|at| at.map(|at| (at / PER_TEXEL as f64) as f32))
            .map(|[x, y]| [x + 0.5 / (width * PER_TEXEL) as f32, y + 0.5 / (height * PER_TEXEL) as f32])
            .collect();
        let size = 2.0 * PI * PI / points.len() as f64;
        let of = |out: &SkyOut| f64::from(out.pdf) * (PI * f64::from(out.point[1])).sin() * size;
        let integral: f64 = sky_samples(&sky, GIVEN, &points, points.len()).iter().map(of).sum();
        // The points are rounded, and each moves its density by the slope there; the sum moves by less than the largest.
        let off = 32.0 * U + 4.0 * U * (width + height) as f64;
        assert!((integral - 1.0).abs() < off, "{width} x {height}: {integral}");
    }
}

#[test]
fn sky_samples_are_numbers_at_the_ends() {
    let last = 1.0 - U as f32;
    let ends = [0.0, U as f32, 0.25, 0.5, 0.75, last];
    let mut random = Random(740);
    let given: Vec<[f32; 2]> =
        ends.iter().flat_map(|x| ends.map(|y| [*x, y])).chain([[1.0, 1.0], [0.0, 1.0]]).collect();
    for (width, height) in SKIES {
        let sky = distribution(width, height, &sky(width, height, &mut random));
        for (by, given) in [(BY_UNIFORMS, &given[..given.len() - 2]), (GIVEN, &given[..])] {
            for out in sky_samples(&sky, by, given, given.len()) {
                let length = exact(out.direction).length();
                assert!((length - 1.0).abs() < 4.0 * U && out.pdf.is_finite() && out.again.is_finite(), "{out:?}");
                assert!(out.point.iter().all(|at| (0.0..=1.0).contains(at)), "{out:?}");
                assert!(out.pdf > 0.0 || by == GIVEN, "{width} x {height}: {out:?}");
            }
        }
    }
}
