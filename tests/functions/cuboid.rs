//! geometry/cuboid: which rays hit, how far away, edges and corners, faces and their coordinates, and the rays that leave.

use glam::{DMat3, DVec3};
use gpu_rt::data::Cuboid;

use crate::kernel::Kernel;
use crate::scenes::{flat, triple};
use crate::stats::Random;
use crate::trace::{In, NO_HIT, Out, trace, tracer};
use crate::vectors::{U, decades, exact, rounded, unit};

/// Boxes turned any way, with a longest edge of 1e-4 to 1e5 and the others down to 1e-3 of it, their centres up to 1000
/// such edges from the origin of space. Every fourth is not turned.
fn assorted(random: &mut Random, count: usize) -> Vec<Cuboid> {
    let texts: Vec<String> = (0..count)
        .map(|i| {
            let size = decades(random, -4.0, 5.0);
            let mut edge = |from: f64| size * decades(random, from, 0.0);
            let from = if i % 2 == 0 { 0.0 } else { -3.0 };
            let edges = DVec3::new(edge(from), edge(from), edge(from));
            let low = size * decades(random, -2.0, 3.0) * unit(random);
            let cuboid = format!("Box(min: {}, max: {}, material: \"m\")", triple(low), triple(low + edges));
            if i % 4 == 0 {
                return cuboid;
            }
            // About the box's own middle, to keep it where it is.
            let (middle, axis, degrees) = (low + 0.5 * edges, unit(random), 360.0 * random.uniform());
            format!(
                "Transformed(by: [Translate({}), Rotate(axis: {}, degrees: {degrees:?}), Translate({})], object: {cuboid})",
                triple(-middle),
                triple(axis),
                triple(middle)
            )
        })
        .collect();
    flat(&texts).cuboids
}

/// A cuboid in f64: its axes as columns, the centre and half its edges.
struct Exact {
    axes: DMat3,
    center: DVec3,
    half: DVec3,
}

impl Exact {
    fn new(cuboid: &Cuboid) -> Exact {
        let (x, y) = (exact(cuboid.x_axis), exact(cuboid.y_axis));
        let axes = DMat3::from_cols(x, y, x.cross(y));
        Exact { axes, center: exact(cuboid.center), half: exact(cuboid.half_extent) }
    }

    /// Along the axes from the centre.
    fn local(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.center)
    }

    /// Where a line is within the box with its faces moved out by `grown`: the distances of entry and exit, or nothing.
    fn span(&self, origin: DVec3, direction: DVec3, grown: f64) -> Option<(f64, f64)> {
        let (o, d) = (self.local(origin), self.axes.transpose() * direction);
        let half = self.half + grown;
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..3 {
            if d[i] == 0.0 {
                if o[i].abs() > half[i] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-half[i] - o[i]) / d[i], (half[i] - o[i]) / d[i]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some((enter, leave))
    }

    /// How far f32 may misplace the faces along a ray: the rounding of the origin and of t times the direction in the
    /// box's axes. Each is a difference, a cross product and a dot product, 6 u of its length, and a division.
    fn blur(&self, origin: DVec3) -> f64 {
        8.0 * U * (2.0 * (origin - self.center).length() + 2.0 * self.half.length())
    }
}

/// Says what is wrong with the answer to a ray, by the box with its faces moved out and in by the blur of f32.
fn fault(cuboid: &Cuboid, origin: DVec3, direction: DVec3, t: f32) -> Option<String> {
    let exact = Exact::new(cuboid);
    let blur = exact.blur(origin);
    let grown = exact.span(origin, direction, blur).filter(|span| span.1 > 0.0);
    let shrunk = exact.span(origin, direction, -blur).filter(|span| span.1 > 0.0);
    let (hit, t) = (t != NO_HIT, f64::from(t));
    match (hit, grown, shrunk) {
        (true, None, _) => Some(format!("hit at {t}, and passes {blur:e} beside")),
        (false, _, Some(span)) => Some(format!("missed, and is inside from {} to {}", span.0, span.1)),
        (false, ..) => None,
        (true, Some(outer), inner) => {
            // From outside t is the entry, from inside the exit; where the origin is in the blur of a face, either.
            let (mut low, mut high) = (outer.0, outer.1);
            if let Some(inner) = inner {
                match (outer.0 > 0.0, inner.0 < 0.0) {
                    (true, _) => high = inner.0,
                    (false, true) => low = inner.1,
                    (false, false) => {}
                }
            }
            let slack = 8.0 * U * t;
            (t < low - slack || t > high + slack).then(|| format!("t {t} is not in {low}..{high}"))
        }
    }
}

/// Says what is wrong with a hit record.
fn surface_fault(cuboid: &Cuboid, ray: &In, out: &Out) -> Option<String> {
    let exact_box = Exact::new(cuboid);
    let error = error_of(cuboid);
    let at = exact_box.local(exact(out.point));
    let normal = exact_box.axes.transpose() * exact(out.normal);
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
    let side = normal[axis].signum();
    let face = side * exact_box.half[axis];
    // Axes of unit length and their cross product, rounded.
    if (normal - side * DVec3::AXES[axis]).length() > 8.0 * U {
        return Some(format!("normal {normal}"));
    }
    if (at[axis] - face).abs() > error || (0..3).any(|i| at[i].abs() > exact_box.half[i] + error) {
        return Some(format!("the point is at {at}, the box is half {}", exact_box.half));
    }
    let free = exact_box.local(exact(ray.origin) + f64::from(out.t) * exact(ray.direction));
    let blur = exact_box.blur(exact(ray.origin));
    if (free[axis] - face).abs() > blur {
        return Some(format!("the ray is at {free} where it meets axis {axis}, {blur:e}"));
    }
    let local = exact(out.local);
    if local[axis] != 0.5 + 0.5 * side || local.min_element() < 0.0 || local.max_element() > 1.0 {
        return Some(format!("local {local}"));
    }
    let expected = 0.5 + 0.5 * (free / exact_box.half);
    (0..3)
        .filter(|&i| i != axis)
        .find(|&i| (local[i] - expected[i].clamp(0.0, 1.0)).abs() > 0.5 * blur / exact_box.half[i] + 4.0 * U)
        .map(|i| format!("local {local}, expected {expected} at {i}"))
}

/// Rays at points in and a little outside boxes, from outside and inside.
fn rays_at(random: &mut Random, cuboids: &[Cuboid], count: usize) -> Vec<In> {
    let mut cube = |reach: f64| (2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0) * reach;
    let places: Vec<(DVec3, DVec3)> = (0..count).map(|_| (cube(1.05), cube(0.95))).collect();
    places
        .into_iter()
        .enumerate()
        .map(|(i, (target, inside))| {
            let at = Exact::new(&cuboids[i % cuboids.len()]);
            let target = at.center + at.axes * (target * at.half);
            let origin = match i % 3 {
                0 => at.center + at.axes * (inside * at.half),
                _ => target + at.half.length() * decades(random, -1.0, 3.0) * unit(random),
            };
            In::new(i % cuboids.len(), origin, (target - origin).normalize())
        })
        .collect()
}

fn faults(kernel: &Kernel, cuboids: &[Cuboid], rays: &[In]) -> (usize, Vec<String>) {
    let mut hits = 0;
    let mut found = Vec::new();
    for (ray, out) in rays.iter().zip(&trace(kernel, cuboids, rays)) {
        let cuboid = &cuboids[ray.primitive as usize];
        found.extend(fault(cuboid, exact(ray.origin), exact(ray.direction), out.t));
        if out.t != NO_HIT {
            hits += 1;
            found.extend(surface_fault(cuboid, ray, out));
        }
    }
    (hits, found)
}

/// The bound of the error of its points, as the shader has it.
fn error_of(cuboid: &Cuboid) -> f64 {
    8.0 * U * (exact(cuboid.center).abs().max_element() + exact(cuboid.half_extent).element_sum())
}

#[test]
fn cuboid_hits_are_decided_and_placed_to_the_last_digits() {
    let mut random = Random(21);
    let cuboids = assorted(&mut random, 3000);
    let rays = rays_at(&mut random, &cuboids, 60_000);
    let kernel = tracer("cuboid", &[]);
    let (hits, found) = faults(&kernel, &cuboids, &rays);
    assert!(hits > 50_000, "{hits} hits");
    assert!(found.is_empty(), "{} faults, the first: {}", found.len(), found[0]);

    // Edges 1e-4 too long, and axes turned by 1e-4.
    let longer = |cuboid: &Cuboid| Cuboid { half_extent: cuboid.half_extent.map(|x| 1.0001 * x), ..*cuboid };
    let turned = |cuboid: &Cuboid| {
        let (x, y) = (exact(cuboid.x_axis), exact(cuboid.y_axis));
        Cuboid { x_axis: rounded(x + 1e-4 * y), y_axis: rounded(y - 1e-4 * x), ..*cuboid }
    };
    for (what, wrong) in
        [("longer", cuboids.iter().map(longer).collect::<Vec<_>>()), ("turned", cuboids.iter().map(turned).collect())]
    {
        let answers = trace(&kernel, &wrong, &rays);
        let found = rays.iter().zip(&answers).filter_map(|(ray, out)| {
            fault(&cuboids[ray.primitive as usize], exact(ray.origin), exact(ray.direction), out.t)
        });
        let found = found.count();
        assert!(found > 1000, "{what}: {found}");
    }
}

/// Rays from outside at points of the boxes' edges and corners.
fn rays_at_edges(random: &mut Random, cuboids: &[Cuboid], count: usize) -> Vec<In> {
    (0..count)
        .map(|i| {
            let at = Exact::new(&cuboids[i % cuboids.len()]);
            let mut place = DVec3::from_array([0; 3].map(|_| if random.below(2) == 0 { 1.0 } else { -1.0 }));
            if i % 4 != 0 {
                place[random.below(3)] = 2.0 * random.uniform() - 1.0;
            }
            let target = at.center + at.axes * (place * at.half);
            let origin = target + at.half.length() * decades(random, 0.4, 3.0) * unit(random);
            In::new(i % cuboids.len(), origin, (target - origin).normalize())
        })
        .collect()
}

#[test]
fn no_ray_slips_through_the_edges_and_corners_of_a_cuboid() {
    let mut random = Random(22);
    let cuboids = assorted(&mut random, 3000);
    let rays = rays_at_edges(&mut random, &cuboids, 100_000);
    let (mut hits, mut lost) = (0, 0);
    for (ray, out) in rays.iter().zip(&trace(&tracer("cuboid", &[]), &cuboids, &rays)) {
        let cuboid = &cuboids[ray.primitive as usize];
        if let Some(fault) = fault(cuboid, exact(ray.origin), exact(ray.direction), out.t) {
            panic!("{fault}: {ray:?} {cuboid:?}");
        }
        if out.t != NO_HIT {
            hits += 1;
            // It goes straight on, from inside.
            if let Some(fault) = fault(cuboid, exact(out.start), exact(out.leaving), out.again) {
                panic!("{fault}: {ray:?} {out:?} {cuboid:?}");
            }
            lost += usize::from(out.again == NO_HIT);
            if let Some(fault) = surface_fault(cuboid, ray, out) {
                panic!("{fault}: {ray:?} {out:?} {cuboid:?}");
            }
        }
    }
    // Rays that only touch an edge may enter and find no way out: they are outside by less than the blur. About half of
    // the edges are at the box's outline, where a touch is a matter of rounding.
    assert!(hits > 50_000 && lost * 4 < hits, "{hits} hits, {lost} without an exit");
}

/// Rays that met a box and leave it at cosines from 0.05 to 1 with the face's normal, out and in: how many, how many of
/// those outwards met it again, and how many chords of those inwards were lost or off by 10 %.
fn leave(kernel: &Kernel) -> (usize, usize, usize) {
    let mut random = Random(23);
    let cuboids = assorted(&mut random, 3000);
    let mut rays = rays_at(&mut random, &cuboids, 60_000);
    for ray in &mut rays {
        let cos = 0.05 + 0.95 * random.uniform();
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let (sin, phi) = ((1.0 - cos * cos).sqrt(), random.uniform() * std::f64::consts::TAU);
        ray.leaving = rounded(DVec3::new(sin * phi.cos(), sin * phi.sin(), side * cos));
    }
    let (mut hits, mut again, mut chords) = (0, 0, 0);
    for (ray, out) in rays.iter().zip(&trace(kernel, &cuboids, &rays)) {
        let cuboid = &cuboids[ray.primitive as usize];
        if out.t == NO_HIT {
            continue;
        }
        hits += 1;
        if ray.leaving[2] > 0.0 {
            again += usize::from(out.again != NO_HIT);
        } else {
            let at = Exact::new(cuboid);
            let chord = at.span(exact(out.point), exact(out.leaving), error_of(cuboid)).map_or(0.0, |span| span.1);
            // Shorter chords, at the edges, are within the errors of their ends.
            if chord > 100.0 * error_of(cuboid) / 0.05 {
                chords += usize::from(out.again == NO_HIT || (f64::from(out.again) / chord - 1.0).abs() > 0.1);
            }
        }
    }
    (hits, again, chords)
}

#[test]
fn rays_leave_cuboids_of_all_sizes() {
    let (hits, again, chords) = leave(&tracer("cuboid", &[]));
    assert!(hits > 50_000);
    assert_eq!((again, chords), (0, 0), "re-hits and lost chords of {hits}");
    let (_, again, chords) = leave(&tracer("cuboid", &[("geometry/offset", "test/control/offset_none")]));
    assert!(again > 1000 && chords > 100, "{again} {chords}");
    let (_, _, chords) = leave(&tracer("cuboid", &[("geometry/offset", "test/control/offset_by_bits")]));
    assert!(chords > 1000, "{chords}");
}

#[test]
fn rays_along_the_axes_and_in_the_faces_are_decided() {
    // Half an edge that is not a short binary fraction, so that faces lie between floats once the centre is added.
    let mut cuboids = Vec::new();
    for center in [[0.0f32; 3], [0.3, -0.7, 0.1], [100.1, -3.3, 0.02]] {
        cuboids.push(Cuboid {
            center,
            half_extent: [0.1, 0.25, 0.7],
            x_axis: [1.0, 0.0, 0.0],
            y_axis: [0.0, 1.0, 0.0],
            ..Cuboid::default()
        });
    }
    let mut rays = Vec::new();
    for (index, cuboid) in cuboids.iter().enumerate() {
        for along in 0..3 {
            for sign in [1.0f32, -1.0] {
                for small in [0.0f32, -0.0, 1e-40, -1e-40, 1e-20, -1e-20, 1e-10] {
                    // On each face, in the middle, beside it by some ulps, and far beside, along the other two axes.
                    for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
                        let place = |step: usize| [-2.0, -1.0001, -1.0, -0.9999, 0.0, 0.9999, 1.0, 1.0001, 2.0][step];
                        let mut origin = cuboid.center;
                        let mut direction = [small; 3];
                        let (one, other) = ((along + 1) % 3, (along + 2) % 3);
                        origin[one] += place(a) * cuboid.half_extent[one];
                        origin[other] += place(b) * cuboid.half_extent[other];
                        origin[along] -= 3.0 * sign;
                        direction[along] = sign;
                        rays.push(In { origin, direction, primitive: index as u32, ..In::default() });
                    }
                }
            }
        }
    }
    let (hits, found) = faults(&tracer("cuboid", &[]), &cuboids, &rays);
    assert!(found.is_empty(), "{} faults, the first: {}", found.len(), found[0]);
    // Strictly inside two slabs at 3 x 3 of the 9 x 9 places, and on a face at 16 more, where either answer will do.
    assert!(hits * 81 > rays.len() * 9 && hits * 81 < rays.len() * 25, "{hits} of {}", rays.len());
}

#[test]
fn each_face_of_a_cuboid_has_its_own_coordinates() {
    let cuboid =
        Cuboid { half_extent: [1.0, 2.0, 3.0], x_axis: [1.0, 0.0, 0.0], y_axis: [0.0, 1.0, 0.0], ..Cuboid::default() };
    let half = exact(cuboid.half_extent);
    let mut random = Random(24);
    let mut rays = Vec::new();
    let mut expected = Vec::new();
    for i in 0..600 {
        let (axis, side) = (i % 3, if i % 2 == 0 { 1.0 } else { -1.0 });
        let normal = side * DVec3::AXES[axis];
        // Seen from outside u runs to the right and v up, so that u x v is the normal; on top and bottom u runs along x.
        let (u_axis, v_axis) = match axis {
            1 => (DVec3::X, normal.cross(DVec3::X)),
            _ => (DVec3::Y.cross(normal), DVec3::Y),
        };
        let (u, v) = (random.uniform(), random.uniform());
        let target = half * (normal + (2.0 * u - 1.0) * u_axis + (2.0 * v - 1.0) * v_axis);
        // Half of the rays start inside.
        let inwards = if i % 4 < 2 { -normal } else { normal };
        let origin = target - inwards * half[axis] * 0.75;
        rays.push(In::new(0, origin, inwards));
        expected.push((normal, u, v));
    }
    for (out, (normal, u, v)) in trace(&tracer("cuboid", &[]), &[cuboid], &rays).iter().zip(&expected) {
        assert_eq!(exact(out.normal), *normal);
        // A difference, a quotient and a sum of numbers up to 1.
        let off = (f64::from(out.u) - u).abs().max((f64::from(out.v) - v).abs());
        assert!(off < 8.0 * U, "{normal}: {} {} is not {u} {v}", out.u, out.v);
    }
}
