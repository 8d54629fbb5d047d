//! medium/*: the part of a ray within a medium. How far light flies in it and where it goes from there: tests/extremes/media.rs.

use bytemuck::Pod;
use glam::{DMat3, DVec3};
use gpu_rt::data::{Cuboid, Sphere};

use crate::common::kernel::{Fault, Kernel, Setup, array};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::trace::{NO_HIT, SPHERE_BY_THE_BOOK};
use crate::common::vectors::{U, decades, exact, rounded, unit};

rows! {
    struct Ray {
        origin: [f32; 3], primitive: u32,
        direction: [f32; 3], padding: u32,
    }

    /// `distance` is what the shape says as a surface.
    struct Within { interval: [f32; 2], distance: f32, padding: f32 }
}

/// `NO_INTERVAL` of shaders/medium/interval.wgsl.
const NO_INTERVAL: [f32; 2] = [1.0, 0.0];

/// What lies behind the origin counts.
const BARE: Fault<'_> = ("medium/interval", "max(crossings.x, 0.0)", "crossings.x");

fn within<P: Pod>(primitive: &str, kind: &str, replaced: &[Fault<'_>], shapes: &[P], rays: &[Ray]) -> Vec<Within> {
    let values = [("primitive", primitive), ("type", kind)];
    let kernel = Kernel::with("test/interval", &Setup { replaced, values: &values, ..Setup::default() });
    kernel.run_with(rays, rays.len(), &[array("primitives", shapes)])
}

/// Whether the interval begins and ends at the very distances of the surface. `touch` allows an interval of no length where
/// the surface is met.
fn agrees_with_surface(out: &Within, touch: bool) -> bool {
    let [enter, leave] = out.interval;
    if out.interval == NO_INTERVAL {
        return touch || out.distance == NO_HIT;
    }
    let first = if enter > 0.0 { enter } else { leave };
    enter >= 0.0 && enter < leave && first.to_bits() == out.distance.to_bits()
}

/// A ray from `distance` times `size` away that passes the middle at `impact` times `size`, or flies away from there.
fn aimed(random: &mut Random, index: usize, center: DVec3, size: f64, distance: f64, impact: f64) -> Ray {
    let towards = unit(random);
    let sideways = towards.cross(unit(random)).normalize();
    let sin = (impact / distance).min(1.0);
    let direction = (1.0 - sin * sin).sqrt() * towards + sin * sideways;
    let direction = if index % 4 == 3 { -direction } else { direction };
    Ray {
        origin: rounded(center - distance * size * towards),
        primitive: index as u32,
        direction: rounded(direction.normalize()),
        padding: 0,
    }
}

/// Distances from inside, from the surface, from outside and from far away.
fn far_or_near(random: &mut Random, index: usize) -> f64 {
    match index % 5 {
        0 => random.uniform().max(1e-3),
        1 => 1.0 + decades(random, -7.0, -1.0),
        2 => 1.0 - decades(random, -7.0, -1.0),
        _ => decades(random, 0.0, 4.0),
    }
}

#[test]
fn a_sphere_holds_the_part_of_a_ray_between_its_surfaces() {
    const RAYS: usize = 100_000;
    let mut random = Random(81);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let radius = decades(&mut random, -5.0, 5.0);
            let center = rounded(radius * decades(&mut random, -2.0, 2.0) * unit(&mut random));
            let sphere = Sphere { center, radius: radius as f32, ..Sphere::default() };
            let (distance, impact) = (far_or_near(&mut random, i), 1.05 * random.uniform());
            (sphere, aimed(&mut random, i, exact(center), radius, distance, impact))
        })
        .unzip();
    let check = |found: &[Within]| {
        let (mut some, mut wrong) = (0, 0);
        for ((out, sphere), ray) in found.iter().zip(&spheres).zip(&rays) {
            let (d, r) = (exact(ray.direction), f64::from(sphere.radius));
            let f = exact(ray.origin) - exact(sphere.center);
            let k = -f.dot(d) / d.length_squared();
            let l = (f + k * d).length();
            let h = ((r + l) * (r - l)).max(0.0).sqrt() / d.length();
            // The bounds of extremes/sphere.rs, of the perpendicular l and of the roots, in radii, with WGSL's 5 u for a quotient and 9 u for a length.
            // The near root has the errors of two lengths, two quotients and the far root, which has those of a quotient and a root: 42 u.
            let away = (f.length() / r).max(1.0);
            let of_l = 2.0 * U * away + 32.0 * (U * away).powi(2) + 12.0 * U;
            let touches = h <= r * of_l.sqrt();
            let bound = r * (42.0 * U * away + of_l / (h / r).max(of_l.sqrt()));
            let expected = [(k - h).max(0.0), k + h];
            let right = if out.interval == NO_INTERVAL {
                l > r * (1.0 - of_l) || expected[1] <= bound
            } else {
                some += 1;
                l <= r * (1.0 + of_l) && (0..2).all(|i| (f64::from(out.interval[i]) - expected[i]).abs() <= bound)
            };
            wrong += u32::from(!right || !agrees_with_surface(out, touches));
        }
        assert!(some > RAYS / 2, "{some} rays within");
        wrong
    };
    assert_eq!(check(&within("sphere", "Sphere", &[], &spheres, &rays)), 0);
    assert!(check(&within("sphere", "Sphere", &SPHERE_BY_THE_BOOK, &spheres, &rays)) > 1000, "roots that cancel");
    assert!(check(&within("sphere", "Sphere", &[BARE], &spheres, &rays)) > 1000, "what lies behind");
}

#[test]
fn a_cuboid_holds_the_part_of_a_ray_between_its_faces() {
    const RAYS: usize = 100_000;
    let mut random = Random(82);
    let (cuboids, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let size = decades(&mut random, -5.0, 5.0);
            let mut half = || size * decades(&mut random, -2.0, 0.0);
            let half = DVec3::new(half(), half(), half());
            let center = rounded(size * decades(&mut random, -2.0, 2.0) * unit(&mut random));
            let x = if i % 3 == 0 { DVec3::X } else { unit(&mut random) };
            let y = if i % 3 == 0 { DVec3::Y } else { x.cross(unit(&mut random)).normalize() };
            let half_extent = rounded(half);
            let cuboid = Cuboid { center, half_extent, x_axis: rounded(x), y_axis: rounded(y), ..Cuboid::default() };
            let (distance, impact) = (far_or_near(&mut random, i), random.uniform());
            let reach = if i % 2 == 0 { half.length() } else { half.min_element() };
            let mut ray = aimed(&mut random, i, exact(center), reach, distance, impact);
            if i % 12 == 0 {
                // Along an axis, where two slabs have no crossings.
                ray.direction = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]][i / 12 % 3];
            }
            (cuboid, ray)
        })
        .unzip();
    let check = |found: &[Within]| {
        let (mut some, mut wrong) = (0, 0);
        for ((out, cuboid), ray) in found.iter().zip(&cuboids).zip(&rays) {
            let (x, y) = (exact(cuboid.x_axis), exact(cuboid.y_axis));
            let to_box = DMat3::from_cols(x, y, x.cross(y)).transpose();
            let away = exact(ray.origin) - exact(cuboid.center);
            let (o, d, half) = (to_box * away, to_box * exact(ray.direction), exact(cuboid.half_extent));
            // The line's crossings of the box with its faces moved out.
            let span = |grown: f64| {
                let (mut enter, mut leave) = (0.0f64, f64::MAX);
                for i in 0..3 {
                    let (high, along) = (half[i] + grown, d[i]);
                    if along.abs() < 1e-15 {
                        leave = if o[i].abs() <= high { leave } else { -1.0 };
                        continue;
                    }
                    let (a, b) = ((-high - o[i]) / along, (high - o[i]) / along);
                    enter = enter.max(a.min(b));
                    leave = leave.min(a.max(b));
                }
                (enter, leave)
            };
            // How far f32 misplaces faces along the ray, as in cuboid.rs.
            let blur = 16.0 * U * (away.length() + half.length());
            let (outer, inner) = (span(blur), span(-blur));
            let slack = 8.0 * U * outer.1;
            let right = if out.interval == NO_INTERVAL {
                inner.0 >= inner.1
            } else {
                some += 1;
                let [enter, leave] = out.interval.map(f64::from);
                let inside = outer.0 <= outer.1 && enter >= outer.0 - slack && leave <= outer.1 + slack;
                let filled = inner.0 > inner.1 || (enter <= inner.0 + slack && leave >= inner.1 - slack);
                inside && filled
            };
            wrong += u32::from(!right || !agrees_with_surface(out, inner.0 >= inner.1));
        }
        assert!(some > RAYS / 3, "{some} rays within");
        wrong
    };
    assert_eq!(check(&within("cuboid", "Cuboid", &[], &cuboids, &rays)), 0);
    let larger: Vec<Cuboid> =
        cuboids.iter().map(|c| Cuboid { half_extent: c.half_extent.map(|x| 1.001 * x), ..*c }).collect();
    assert!(check(&within("cuboid", "Cuboid", &[], &larger, &rays)) > 1000, "a larger box");
    assert!(check(&within("cuboid", "Cuboid", &[BARE], &cuboids, &rays)) > 1000, "what lies behind");
}
