//! geometry/cuboid: which rays hit, how far away, edges, corners, faces and their coordinates. The rays that leave are in
//! tests/extremes.

use glam::DVec3;
use gpu_rt::data::Cuboid;

use crate::common::cuboids::{Exact, assorted, error_of, rays_at};
use crate::common::kernel::Kernel;
use crate::common::stats::Random;
use crate::common::trace::{In, NO_HIT, Out, trace, tracer};
use crate::common::vectors::{U, decades, exact, rounded, unit};

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

#[test]
fn cuboid_hits_are_decided_and_placed_to_the_last_digits() {
    let mut random = Random(21);
    let cuboids = assorted(&mut random, 3000, 3.0, (-2.0, 3.0));
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
            let mut within = DVec3::from_array([0; 3].map(|_| if random.below(2) == 0 { 1.0 } else { -1.0 }));
            if i % 4 != 0 {
                within[random.below(3)] = 2.0 * random.uniform() - 1.0;
            }
            let target = at.center + at.axes * (within * at.half);
            let origin = target + at.half.length() * decades(random, 0.4, 3.0) * unit(random);
            In::new(i % cuboids.len(), origin, (target - origin).normalize())
        })
        .collect()
}

#[test]
fn no_ray_slips_through_the_edges_and_corners_of_a_cuboid() {
    let mut random = Random(22);
    let cuboids = assorted(&mut random, 3000, 3.0, (-2.0, 3.0));
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
                        let coordinate =
                            |step: usize| [-2.0, -1.0001, -1.0, -0.9999, 0.0, 0.9999, 1.0, 1.0001, 2.0][step];
                        let mut origin = cuboid.center;
                        let mut direction = [small; 3];
                        let (one, other) = ((along + 1) % 3, (along + 2) % 3);
                        origin[one] += coordinate(a) * cuboid.half_extent[one];
                        origin[other] += coordinate(b) * cuboid.half_extent[other];
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
    // Strictly inside two slabs at 3 x 3 of the 9 x 9 points, and on a face at 16 more, where either answer will do.
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
