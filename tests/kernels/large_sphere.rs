//! geometry/large_sphere and light/large_sphere: spheres given by their point nearest to the camera, against f64, for radii of up to 1e12 times
//! the distance.

use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::data::{LargeSphere, Sphere};

use crate::common::light_kernel::{self, DRAWS, LARGE_SPHERE, at_ends};
use crate::common::stats::{Random, sidak, uniform_in_cells};
use crate::common::trace::{In, NO_HIT, Out, WITHOUT_OFFSET, leaving, trace, tracer};
use crate::common::vectors::{U, decades, exact, rounded, unit};

/// A large sphere in f64, as the device has it.
struct Exact {
    nearest: DVec3,
    inward: DVec3,
    curvature: f64,
}

/// A ray's line as an exact large sphere has it: the roots t of c d² t² + 2 slope t + power = 0 are its crossings.
struct Line {
    a: f64,
    slope: f64,
    power: f64,
}

impl Line {
    /// The nearest crossing in front of the origin.
    fn first(&self) -> Option<f64> {
        let discriminant = self.slope * self.slope - self.a * self.power;
        if discriminant < 0.0 {
            return None;
        }
        let q = -self.slope - discriminant.sqrt().copysign(self.slope);
        let (one, other) = (q / self.a, self.power / q);
        [one.min(other), one.max(other)].into_iter().find(|t| *t > 0.0)
    }
}

impl Exact {
    fn new(large_sphere: &LargeSphere) -> Exact {
        Exact {
            nearest: exact(large_sphere.nearest),
            inward: exact(large_sphere.inward),
            curvature: f64::from(large_sphere.curvature),
        }
    }

    fn radius(&self) -> f64 {
        1.0 / self.curvature
    }

    fn power(&self, x: DVec3) -> f64 {
        self.curvature * x.length_squared() - 2.0 * self.inward.dot(x)
    }

    fn upward(&self, x: DVec3) -> DVec3 {
        self.curvature * x - self.inward
    }

    fn line(&self, origin: DVec3, d: DVec3) -> Line {
        let x = origin - self.nearest;
        Line { a: self.curvature * d.length_squared(), slope: self.upward(x).dot(d), power: self.power(x) }
    }

    /// How far f32 may misplace the surface along its normal, as a ray from a point sees it.
    fn blur(&self, x: DVec3) -> f64 {
        U * (self.nearest.length() + 12.0 * x.length() + 4.0 * self.curvature * x.length_squared())
    }

    /// Says what is wrong with the answer to a ray, by the large sphere moved by the blur, and the slope off by some roundings.
    fn fault(&self, origin: [f32; 3], direction: [f32; 3], t: f32) -> Option<String> {
        let (origin, d) = (exact(origin), exact(direction));
        let x = origin - self.nearest;
        let line = self.line(origin, d);
        let (blur, tilt) = (self.blur(x), 6.0 * U * (1.0 + self.curvature * x.length()));
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 0.0)];
        let corners = corners.map(|(by_slope, by_power)| {
            Line { slope: line.slope + by_slope * tilt, power: line.power + by_power * 2.0 * blur, ..line }.first()
        });
        if t == NO_HIT {
            return corners.iter().all(Option::is_some).then(|| format!("missed, and hits at {:?}", corners[4]));
        }
        let t = f64::from(t);
        // The side of the surface on which the ray starts is not known there.
        let first = if line.power.abs() < 2.0 * blur { 0.0 } else { f64::INFINITY };
        let low = corners.iter().flatten().copied().fold(first, f64::min);
        // Where the ray may miss, it may touch, too: at -slope / a, by the slope as f32 has it.
        let touch = if corners.iter().any(Option::is_none) { (tilt - line.slope) / line.a } else { 0.0 };
        let high = corners.iter().flatten().copied().fold(touch, f64::max);
        let slack = 8.0 * U * t;
        (t < low - slack || t > high + slack).then(|| format!("t {t} is not in {low}..{high}"))
    }
}

/// Large spheres at a distance of about 1 from the origin, whose radii are so many times that distance.
fn large_spheres(random: &mut Random, count: usize, radii: (f64, f64)) -> Vec<LargeSphere> {
    (0..count)
        .map(|i| {
            let height = decades(random, -1.0, 1.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
            // Every fourth ground is level.
            let inward = if i % 4 == 0 { DVec3::NEG_Y } else { unit(random) };
            let radius = height.abs() * decades(random, radii.0, radii.1);
            LargeSphere {
                nearest: rounded(height * inward),
                curvature: (1.0 / radius) as f32,
                inward: rounded(inward),
                ..LargeSphere::default()
            }
        })
        .collect()
}

/// Rays from points whose distances from the nearest point of their large sphere are within decades of the distance of the camera, towards
/// points of the large sphere at such distances, and in any direction.
fn rays_at(random: &mut Random, large_spheres: &[LargeSphere], count: usize, reach: f64) -> Vec<In> {
    (0..count)
        .map(|i| {
            let large_sphere = Exact::new(&large_spheres[i % large_spheres.len()]);
            let height = large_sphere.nearest.length();
            let limit = reach.min((large_sphere.radius() / height).log10() - 0.5);
            let mut about = |low: f64| height * decades(random, low, limit) * unit(random);
            let (from, to) = (about(-2.0), about(-2.0));
            let onto = |x: DVec3| {
                let normal = large_sphere.upward(x).normalize();
                x - large_sphere.power(x) / (1.0 + large_sphere.upward(x).length()) * normal
            };
            let target = large_sphere.nearest + onto(to);
            let origin = match i % 3 {
                0 => DVec3::ZERO,
                1 => large_sphere.nearest + from,
                // Close to the surface.
                _ => large_sphere.nearest + onto(from) + height * decades(random, -6.0, 0.0) * unit(random),
            };
            let direction = if i % 5 == 0 { unit(random) } else { (target - origin).normalize_or(DVec3::X) };
            let mut ray = In::new(i % large_spheres.len(), origin, direction);
            let cosine = decades(random, -3.0, 0.0);
            ray.leaving = leaving(random, cosine, i % 2 == 0);
            ray
        })
        .collect()
}

/// The numbers of wrong distances, wrong hit records, and wrong second rays.
fn faults(large_spheres: &[LargeSphere], rays: &[In], found: &[Out]) -> [usize; 3] {
    let (mut wrong, mut hits) = ([0; 3], 0);
    for (ray, out) in rays.iter().zip(found) {
        let large_sphere = Exact::new(&large_spheres[ray.primitive as usize]);
        wrong[0] += usize::from(large_sphere.fault(ray.origin, ray.direction, out.t).is_some());
        if out.t == NO_HIT {
            continue;
        }
        hits += 1;
        let x = exact(out.point) - large_sphere.nearest;
        let upward = large_sphere.upward(x);
        let height = large_sphere.power(x) / (1.0 + upward.length());
        let error = f64::from(out.error);
        let from = (exact(ray.origin) - large_sphere.nearest).length();
        let bound = 40.0 * U * (large_sphere.nearest.length() + x.length()) + 400.0 * U * U * (from + f64::from(out.t));
        let is_right = height.abs() <= error
            && error <= bound
            && (exact(out.normal) - upward.normalize()).length() <= 8.0 * U
            && (exact(out.local) - large_sphere.curvature * x).length()
                <= 4.0 * U * large_sphere.curvature * (x.length() + large_sphere.nearest.length());
        wrong[1] += usize::from(!is_right);
        let outwards = (exact(out.start) - exact(out.point)).dot(exact(out.normal)) >= 0.0;
        let lost = match outwards {
            true => out.again != NO_HIT,
            false => out.again == NO_HIT || large_sphere.fault(out.start, out.leaving, out.again).is_some(),
        };
        wrong[2] += usize::from(lost);
    }
    assert!(hits > rays.len() / 2, "{hits} hits of {}", rays.len());
    wrong
}

#[test]
fn a_large_sphere_of_any_radius_is_hit_where_it_is() {
    const RAYS: usize = 60_000;
    let mut random = Random(2201);
    let large_spheres = large_spheres(&mut random, 3000, (0.0, 12.0));
    let rays = rays_at(&mut random, &large_spheres, RAYS, 3.0);
    let found = trace(&tracer("large_sphere", &[]), &large_spheres, &rays);
    for (ray, out) in rays.iter().zip(&found) {
        let large_sphere = Exact::new(&large_spheres[ray.primitive as usize]);
        if let Some(fault) = large_sphere.fault(ray.origin, ray.direction, out.t) {
            panic!("{fault}: {:?} {ray:?} {out:?}", large_spheres[ray.primitive as usize]);
        }
    }
    assert_eq!(faults(&large_spheres, &rays, &found), [0, 0, 0]);
    let without = tracer("large_sphere", &[WITHOUT_OFFSET]);
    let found = trace(&without, &large_spheres, &rays);
    assert!(faults(&large_spheres, &rays, &found)[2] > RAYS / 10, "rays without an offset");
    // By centres and radii in f32.
    let spheres: Vec<Sphere> = large_spheres
        .iter()
        .map(|large_sphere| {
            let exact = Exact::new(large_sphere);
            let center = rounded(exact.nearest + exact.radius() * exact.inward);
            Sphere { center, radius: exact.radius() as f32, ..Sphere::default() }
        })
        .collect();
    let found = trace(&tracer("sphere", &[]), &spheres, &rays);
    let wrong = |(ray, out): (&In, &Out)| {
        Exact::new(&large_spheres[ray.primitive as usize]).fault(ray.origin, ray.direction, out.t)
    };
    let wrong = rays.iter().zip(&found).filter_map(wrong).count();
    assert!(wrong > RAYS / 2, "spheres by their centres: {wrong}");
}

/// A large sphere seen from `away` radii, by other objects than the camera: only its outline is off, by the rounding of the distance.
#[test]
fn a_large_sphere_is_a_sphere_from_far_away() {
    let mut random = Random(2202);
    for away in [1.0, 1.9, 2.1, 10.0, 1e3, 1e5] {
        let large_spheres = large_spheres(&mut random, 100, (3.0, 6.0));
        let rays: Vec<In> = (0..20_000)
            .map(|i| {
                let large_sphere = Exact::new(&large_spheres[i % large_spheres.len()]);
                let center = large_sphere.nearest + large_sphere.radius() * large_sphere.inward;
                let origin = center + (1.0 + away) * large_sphere.radius() * unit(&mut random);
                let towards = (center - origin).normalize();
                let sideways = towards.cross(unit(&mut random)).normalize();
                let sine = 1.05 * random.uniform() / (1.0 + away);
                let mut ray =
                    In::new(i % large_spheres.len(), origin, (1.0 - sine * sine).sqrt() * towards + sine * sideways);
                let cosine = decades(&mut random, -3.0, 0.0);
                ray.leaving = leaving(&mut random, cosine, i % 2 == 0);
                ray
            })
            .collect();
        let of_l = U * (4.0 * away + 16.0);
        let (mut wrong, mut textbook) = (0, 0);
        for (ray, out) in rays.iter().zip(&trace(&tracer("large_sphere", &[]), &large_spheres, &rays)) {
            let large_sphere = Exact::new(&large_spheres[ray.primitive as usize]);
            let (d, g) =
                (exact(ray.direction).normalize(), large_sphere.upward(exact(ray.origin) - large_sphere.nearest));
            let length = large_sphere.inward.length();
            let l = (g - g.dot(d) * d).length() / length;
            let h = ((1.0 + l) * (1.0 - l)).max(0.0).sqrt();
            let t = (-g.dot(d) - h) * large_sphere.radius();
            let bound = large_sphere.radius() * (16.0 * U * (1.0 + away) + of_l / h.max(of_l.sqrt()));
            let hit = out.t != NO_HIT;
            let is_off = |hit: bool| if hit { l > 1.0 + of_l } else { l < 1.0 - of_l };
            wrong += usize::from(is_off(hit) || hit && (f64::from(out.t) - t).abs() > bound);
            let outwards = (exact(out.start) - exact(out.point)).dot(exact(out.normal)) >= 0.0;
            wrong += usize::from(hit && outwards == (out.again != NO_HIT));
            // As if computed by the square of the slope, in f32.
            let (slope, power) = (g.dot(d) as f32, large_sphere.power(exact(ray.origin) - large_sphere.nearest) as f32);
            textbook += usize::from(is_off(slope * slope - large_sphere.curvature as f32 * power >= 0.0));
        }
        assert_eq!(wrong, 0, "from {away} radii");
        assert!(away < 100.0 || textbook > 100, "from {away} radii: {textbook}");
    }
}

#[test]
fn directions_to_a_large_sphere_are_uniform_in_its_cone() {
    let mut random = Random(2203);
    let (mut rows, mut shapes) = (Vec::new(), Vec::new());
    for (i, height) in [1e-4, 0.01, 0.3, 1.0, 3.0, 1e2, 1e3, -1.0, -0.1, -30.0].into_iter().enumerate() {
        for radius in [1e3, 1e6, 1e9, 1e12] {
            let inward = unit(&mut random);
            let large_sphere = LargeSphere {
                nearest: rounded(inward),
                curvature: (1.0 / radius) as f32,
                inward: rounded(inward),
                ..LargeSphere::default()
            };
            let sideways = inward.cross(unit(&mut random)).normalize();
            // Not above the nearest point.
            let along = 0.3 * i as f64 * sideways;
            let up = -(inward - Exact::new(&large_sphere).curvature * along).normalize();
            let foot = along - Exact::new(&large_sphere).power(along) / 2.0 * up;
            let from = rounded(exact(large_sphere.nearest) + foot + height * up);
            rows.push(light_kernel::In { from, shape: shapes.len() as u32, ..light_kernel::In::default() });
            shapes.push(large_sphere);
        }
    }
    // At the edge of the cone, too.
    for (row, out) in at_ends(LARGE_SPHERE, &rows, &shapes) {
        assert!(out.distance != NO_HIT, "{row:?} {out:?} misses");
    }
    let found = light_kernel::draws(LARGE_SPHERE, &rows, &shapes, &[]);
    for (row, found) in rows.iter().zip(found.chunks(DRAWS)) {
        let large_sphere = Exact::new(&shapes[row.shape as usize]);
        let x = exact(row.from) - large_sphere.nearest;
        let (power, axis) = (large_sphere.power(x), -large_sphere.upward(x).normalize());
        // 1 - cos of the cone's half angle, of the large sphere by its numbers as they are.
        let height = match power > 0.0 {
            true => 1.0 - (large_sphere.curvature * power / (1.0 + large_sphere.curvature * power)).sqrt(),
            false => 2.0,
        };
        // Close to the ground, how high the point is has few digits.
        let of_height = (large_sphere.curvature * (power.abs() + 60.0 * U * (1.0 + x.length()))).sqrt()
            - (large_sphere.curvature * power.abs()).sqrt();
        let pdf = 1.0 / (2.0 * PI * height);
        for out in found {
            assert_eq!(out.pdf, out.again);
            assert!((f64::from(out.pdf) / pdf - 1.0).abs() < 16.0 * U + of_height, "{} for {pdf}", out.pdf);
            assert!(out.distance != NO_HIT, "{row:?} {out:?} misses");
        }
        let (a, b) = axis.any_orthonormal_pair();
        let cells = |by: fn(f64) -> f64| {
            let points = found.iter().map(|out| {
                let direction = exact(out.direction).normalize();
                let rise = (direction - axis).length_squared() / 2.0;
                (by((rise / height).min(1.0 - 1e-9)), direction.dot(b).atan2(direction.dot(a)) / (2.0 * PI) + 0.5)
            });
            uniform_in_cells((31, 17), points)
        };
        let p = cells(|x| x);
        assert!(p > sidak(1e-6, rows.len()), "{row:?}: p = {p:e}");
        assert!(cells(|x| x.powf(0.9)) < 1e-6, "a distribution that is a little off");
    }
}
