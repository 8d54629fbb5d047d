//! geometry/disk and light/disk: which rays hit, the surface there, and directions towards a disk, against f64.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gpu_rt::data::Quad;

use crate::common::light_kernel::{self, CELLS, DISK, DISK_PART, DRAWS, Out as Drawn, PartCell, at_ends, draws};
use crate::common::scenes::{flat, triple};
use crate::common::stats::{Random, one_sample_t, sidak, uniform_in_cells};
use crate::common::trace::{In, NO_HIT, WITHOUT_OFFSET, leaving, trace, tracer};
use crate::common::vectors::{U, decades, exact, rounded, unit};

const ALPHA: f64 = 1e-6;

/// Disks of all sizes in general position, up to 100 radii from the origin, and the squares around them.
fn disks(random: &mut Random, count: usize) -> Vec<Quad> {
    let texts: Vec<String> = (0..count)
        .map(|_| {
            let radius = decades(random, -4.0, 5.0);
            let center = radius * decades(random, -1.0, 2.0) * unit(random);
            let normal = decades(random, -3.0, 3.0) * unit(random);
            format!("Disk(center: {}, normal: {}, radius: {radius:?}, material: \"m\")", triple(center), triple(normal))
        })
        .collect();
    flat(&texts).shapes.disks
}

/// The middle, the unit normal and the radius, as the device has them.
fn circle(square: &Quad) -> (DVec3, DVec3, f64) {
    let (u, v) = (exact(square.u), exact(square.v));
    (exact(square.corner) + 0.5 * (u + v), u.cross(v).normalize(), 0.5 * u.length())
}

#[test]
fn the_square_around_a_disk_has_its_axes() {
    let text =
        |normal: DVec3| format!("Disk(center: (1, 2, 3), normal: {}, radius: 0.5, material: \"m\")", triple(normal));
    let mut random = Random(30);
    let mut normals = vec![DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::Z, DVec3::NEG_Z];
    normals.extend((0..200).map(|_| decades(&mut random, -3.0, 3.0) * unit(&mut random)));
    let squares = flat(&normals.iter().map(|normal| text(*normal)).collect::<Vec<_>>()).shapes.disks;
    for (normal, square) in normals.iter().zip(&squares) {
        let (u, v, n) = (exact(square.u), exact(square.v), normal.normalize());
        let size = u.length();
        assert!((v.length() / size - 1.0).abs() < 4.0 * U && u.dot(v).abs() < 4.0 * U * size * size, "{square:?}");
        assert!((exact(square.normal) - n).length() < 4.0 * U, "{square:?}");
        // v is as near to +y as it can be, and -z where there is no nearest.
        let nearest = if n.x.hypot(n.z) < 1e-9 { DVec3::NEG_Z } else { (DVec3::Y - n.y * n).normalize() };
        assert!((v / size - nearest).length() < 4.0 * U, "{normal}: {v}");
        assert!((u / size - nearest.cross(n)).length() < 4.0 * U, "{normal}: {u}");
    }
    // Their sizes and positions are those of the scene, but for the power of two by which render space is scaled.
    let (center, _, radius) = circle(&squares[0]);
    assert!((center / radius - DVec3::new(2.0, 4.0, 6.0)).length() < 1e-6, "{center} {radius}");
}

/// Hits and misses that differ from those of f64 by more than rounding, and hits whose point or coordinates do.
fn wrong(disks: &[Quad], rays: &[In]) -> [usize; 2] {
    let mut wrong = [0; 2];
    for (ray, out) in rays.iter().zip(trace(&tracer("disk", &[]), disks, rays)) {
        let square = &disks[ray.primitive as usize];
        let (center, normal, radius) = circle(square);
        let (o, d) = (exact(ray.origin), exact(ray.direction));
        let t = (center - o).dot(normal) / d.dot(normal);
        let offset = o + t * d - center;
        // As for a quad (tests/extremes): the offset, its products and the normal are off by 8 u of the lengths that take part, over the
        // cosine. The disk itself reaches out by its own stated error.
        let corner = exact(square.corner);
        let lengths = (corner - o).length() + t.abs() + offset.length() + 2.0 * radius;
        let off = (16.0 * U * lengths + f64::from(square.error)) / d.dot(normal).abs();
        let hit = out.t != NO_HIT;
        let inside = t > 0.0 && offset.length() < radius;
        wrong[0] += usize::from(hit != inside && (offset.length() - radius).abs() > off && t.abs() > off);
        if hit {
            let (u, v) = (exact(square.u), exact(square.v));
            let expected = [offset.dot(u) / u.length_squared() + 0.5, offset.dot(v) / v.length_squared() + 0.5];
            let at = [f64::from(out.local[0]), f64::from(out.local[1])];
            let coordinates = (0..2).all(|i| (at[i] - expected[i]).abs() < off / radius);
            let on_disk = corner + at[0] * u + at[1] * v;
            let point = (exact(out.point) - on_disk).length() <= f64::from(square.error);
            // The quotient by the length: 5 u each of WGSL's 2.5 ULP for a quotient and for a root, and the roundings of the products.
            let within = (2.0 * DVec3::new(at[0], at[1], 0.5) - 1.0).length() < 1.0 + 14.0 * U;
            let same = [out.u, out.v] == [out.local[0], out.local[1]] && out.normal == square.normal;
            wrong[1] += usize::from(!(coordinates && point && within && same));
        }
    }
    wrong
}

#[test]
fn rays_hit_disks_where_f64_says() {
    let mut random = Random(31);
    let disks = disks(&mut random, 2000);
    let rays: Vec<In> = (0..100_000)
        .map(|i| {
            let (center, normal, radius) = circle(&disks[i % disks.len()]);
            let (u, v) = normal.any_orthonormal_pair();
            let (sin, cos) = (TAU * random.uniform()).sin_cos();
            let target = center + 1.2 * random.uniform() * radius * (cos * u + sin * v);
            let (cosine, side) = (decades(&mut random, -3.0, 0.0), if i % 2 == 0 { 1.0 } else { -1.0 });
            let along = normal.cross(unit(&mut random)).normalize();
            let away = side * cosine * normal + (1.0 - cosine * cosine).sqrt() * along;
            let origin = target + radius * decades(&mut random, -1.0, 3.0) * away;
            let mut ray = In::new(i % disks.len(), origin, -away);
            let cosine = decades(&mut random, -4.0, 0.0);
            ray.leaving = leaving(&mut random, cosine, i % 4 < 2);
            ray
        })
        .collect();
    assert_eq!(wrong(&disks, &rays), [0; 2]);
    // Whatever leaves a disk does not meet it again.
    let found = trace(&tracer("disk", &[]), &disks, &rays);
    assert!(found.iter().filter(|out| out.t != NO_HIT).count() > 80_000);
    assert!(found.iter().all(|out| out.again == NO_HIT));
    let without = tracer("disk", &[WITHOUT_OFFSET]);
    assert!(trace(&without, &disks, &rays).iter().filter(|out| out.t != NO_HIT && out.again != NO_HIT).count() > 1000);
    // A radius that is off by 1 %, and a square instead of the disk.
    let larger: Vec<Quad> = disks.iter().map(|d| Quad { a_axis: d.a_axis.map(|x| 0.98 * x), ..*d }).collect();
    assert!(wrong(&larger, &rays).iter().sum::<usize>() > 500);
}

/// Points from which disks are seen: heights of 0.01 to 1e5 radii above all parts of the plane.
fn views(random: &mut Random, disks: &[Quad]) -> Vec<light_kernel::In> {
    let mut rows = Vec::new();
    for (shape, square) in (0..).zip(disks) {
        let (center, normal, radius) = circle(square);
        let along = normal.any_orthonormal_vector();
        for height in [0.01, 0.1, 0.5, 1.0, 3.0, 30.0, 1e3, 1e5] {
            for beside in [0.0, 0.7, 1.0, 2.0, 10.0] {
                let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
                let from = center + radius * (side * height * normal + beside * along);
                rows.push(light_kernel::In { from: rounded(from), shape, ..Default::default() });
            }
        }
    }
    rows
}

/// Configurations whose pdf is not 1 over the area in solid angle, whose points are not uniform in the area, and under which a surface
/// parallel to the disk is not lit as the closed form says, for a disk of another area. Uniformity is tested where the error of a density and that
/// of a point over the radius are at most so large that the rounding of directions moves fewer points over edges than chi-square finds.
fn off(
    rows: &[light_kernel::In],
    disks: &[Quad],
    found: &[Drawn],
    part: impl Fn(u32) -> PartCell,
    by: fn(f64) -> f64,
    (area, most): (f64, [f64; 2]),
) -> [usize; 3] {
    let mut wrong = [0; 3];
    for (row, found) in rows.iter().zip(found.chunks(DRAWS)) {
        let (square, cell) = (&disks[row.shape as usize], part(row.shape));
        let (center, normal, radius) = circle(square);
        let (low, [x, y]) = (cell.low(), cell.size());
        let from = exact(row.from);
        let (right, up) = (exact(square.u).normalize(), exact(square.v).normalize());
        let height = (center - from).dot(normal);
        let (mut points, mut pdf_is_right) = (Vec::new(), true);
        let (mut values, mut worst, mut edge) = (Vec::new(), 0.0f64, 0.0f64);
        for out in found {
            let direction = exact(out.direction).normalize();
            let cosine = direction.dot(normal);
            let distance = height / cosine;
            let pdf = distance * distance / (cosine.abs() * area * PI * radius * radius * x * y);
            // The height over the plane is off by 4 u of the corner's distance, and the cosine by 4 u; the pdf has the square of the one over
            // the cube of the other.
            let error = 8.0 * U * (distance.abs() + 3.0 * radius) / height.abs() + 12.0 * U / cosine.abs() + 16.0 * U;
            (worst, edge) = (worst.max(error), edge.max(4.0 * U * distance.abs() / radius));
            pdf_is_right &= (f64::from(out.pdf) / pdf - 1.0).abs() < error && out.pdf == out.again;
            let offset = from + distance * direction - center;
            let turns = offset.dot(up).atan2(offset.dot(right)) / TAU + 0.5;
            let share = |value: f64| (value / area).clamp(0.0, 1.0 - U);
            let radial = (offset.length_squared() / radius.powi(2) - low[0]) / x;
            points.push((by(share(radial)), share((turns - low[1]) / y)));
            values.push(cosine.abs() / f64::from(out.pdf));
        }
        wrong[0] += usize::from(!pdf_is_right);
        if worst < most[0] && edge < most[1] {
            wrong[1] += usize::from(uniform_in_cells((31, 17), points.into_iter()) < sidak(ALPHA, rows.len()));
        }
        // The form factor from a point to a disk in a parallel plane (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors",
        // configuration B-13): pi times it is the integral of the cosine over the solid angle.
        let beside = ((center - from) - height * normal).length();
        let (h2, a2, r2) = (height * height, beside * beside, area * radius * radius);
        let sum = h2 + a2 + r2;
        // sum² - 4 a² r², and (the root - h² - a² + r²), without cancellation far away.
        let root = (sum * sum - 4.0 * a2 * r2).sqrt();
        let lit = 0.5 * PI * 4.0 * r2 * h2 / (root * (root + h2 + a2 - r2));
        let test = one_sample_t(&values, lit);
        wrong[2] += usize::from(!(test.p > sidak(ALPHA, rows.len()) || (test.difference / lit).abs() < worst));
    }
    wrong
}

#[test]
fn directions_towards_a_disk_are_uniform_in_its_area() {
    let mut random = Random(32);
    let disks = disks(&mut random, 3);
    let rows = views(&mut random, &disks);
    let found = draws(DISK, &rows, &disks, &[]);
    let off = |by, area| off(&rows, &disks, &found, |_| CELLS[0], by, (area, [1e-3, f64::INFINITY]));
    assert_eq!(off(|x| x, 1.0), [0; 3]);
    // Points that are a little denser in the middle, and a disk whose radius is larger by 0.5 %.
    assert!(off(|x| x.powf(0.9), 1.0)[1] > 20);
    let larger = off(|x| x, 1.005 * 1.005);
    assert!(larger[0] > 50 && larger[2] > 20, "{larger:?}");

    // In the plane, on the edge, in the middle, and as far away as f32 goes: numbers, and the pdf has a square.
    let mut awkward = Vec::new();
    for (shape, square) in (0..).zip(&disks) {
        let (center, normal, radius) = circle(square);
        for beside in [0.0, 0.5, 1.0, 3.0, 1e6] {
            for height in [0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3, 0.1, 1.0, 1e4, 1e8, 1e12] {
                let from = center + radius * (beside * normal.any_orthonormal_vector() + height * normal);
                awkward.push(light_kernel::In { from: rounded(from), shape, ..Default::default() });
            }
        }
    }
    for (row, out) in at_ends(DISK, &awkward, &disks) {
        assert!(out.pdf.is_finite() && out.pdf >= 0.0 && (out.pdf * out.pdf).is_finite(), "{row:?} {out:?}");
        let length = exact(out.direction).length();
        assert!(out.pdf == out.again && (out.pdf == 0.0 || (length - 1.0).abs() < 1e-6), "{row:?} {out:?}");
    }
}

/// Points of a part are uniform in its own area, and the pdf is 1 over that. Planted: the part is larger by 1 %.
#[test]
fn directions_towards_parts_of_a_disk_are_uniform_in_their_area() {
    let mut random = Random(33);
    let mut disks = disks(&mut random, CELLS.len());
    disks.iter_mut().zip(CELLS).for_each(|(disk, cell)| disk.light = cell.code());
    let rows = views(&mut random, &disks);
    let found = draws(DISK_PART, &rows, &disks, &[]);
    // Directions that are rounded over the part's edge would fill the cells there.
    let wrong = |area| off(&rows, &disks, &found, |shape| CELLS[shape as usize], |x| x, (area, [2e-5; 2]));
    let [pdf, points, _] = wrong(1.0);
    assert_eq!([pdf, points], [0; 2]);
    let planted = wrong(1.01);
    assert!(planted[0] > 50 && planted[1] > 10, "{planted:?}");
}
