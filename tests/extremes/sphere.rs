//! geometry/sphere: which rays hit, how far away, and what happens to the rays that leave.

use std::f64::consts::TAU;

use glam::DVec3;
use gpu_rt::data::Sphere;

use crate::common::kernel::Kernel;
use crate::common::stats::Random;
use crate::common::trace::{In, NO_HIT, SPHERE_BY_THE_BOOK, WITHOUT_OFFSET, leaving, trace, tracer};
use crate::common::vectors::{U, decades, exact, quantile, rounded, unit};
use crate::table::{BY_BITS, Cell, FIXED_OFFSET, FIXED_T_MIN, NO_OFFSET, OFFSET_BY_BITS, TEXTBOOK_SPHERE, decade};

/// Both roots of |o + t d - c| = r in f64, or the miss, by the perpendicular from the centre: good to 1e-16 (D/r)^2.
struct Roots {
    /// Distance of the ray's line from the centre over the radius.
    impact: f64,
    near: f64,
    far: f64,
}

fn roots(ray: &In, sphere: &Sphere) -> Roots {
    let (d, r) = (exact(ray.direction), f64::from(sphere.radius));
    let f = exact(ray.origin) - exact(sphere.center);
    let k = -f.dot(d) / d.length_squared();
    let perpendicular = (f + k * d).length();
    let h = ((r + perpendicular) * (r - perpendicular)).max(0.0).sqrt() / d.length();
    Roots { impact: perpendicular / r, near: k - h, far: k + h }
}

/// A sphere with its centre `offset` radii from the origin of space, and a ray from `distance` radii away that passes its
/// centre at `impact` radii.
fn aimed(random: &mut Random, index: usize, offset: f64, distance: f64, impact: f64) -> (Sphere, In) {
    let radius = decades(random, -3.0, 3.0);
    let center = radius * offset * unit(random);
    let towards = unit(random);
    let sideways = towards.cross(unit(random)).normalize();
    let sphere = Sphere { center: rounded(center), radius: radius as f32, ..Sphere::default() };
    let (center, radius) = (exact(sphere.center), f64::from(sphere.radius));
    let origin = center - distance * radius * towards;
    let sin = (impact / distance).min(1.0);
    let direction = (1.0 - sin * sin).sqrt() * towards + sin * sideways;
    (sphere, In::new(index, origin, direction.normalize()))
}

/// What a tracer makes of rays from some distance, with impact parameters up to 1.05 radii.
struct Verdict {
    /// Share of rays that were said to hit and miss, or the reverse.
    wrong: f64,
    /// Largest distance, in radii, of a wrongly decided ray's line from the sphere's edge.
    worst_decision: f64,
    /// Median error of the distance, in radii.
    median: f64,
    /// Largest error of the distance over its bound (`distance_is_right_within`).
    worst_distance: f64,
    /// Largest error of the normal over its bound.
    worst_normal: f64,
}

/// The error of the line's distance from the centre, in radii, for a sphere `distance` radii away. The rounding of o -
/// c and that of k d are at most u D each; what of the direction the first perpendicular keeps, at most 8 u D, the
/// second step takes out; the length, its root and r + l round by 4 u at most.
fn impact_error(distance: f64) -> f64 {
    2.0 * U * distance + 4.0 * U
}

fn judge(kernel: &Kernel, distance: f64) -> Verdict {
    const RAYS: usize = 20_000;
    let mut random = Random(1);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let impact = 1.05 * random.uniform();
            aimed(&mut random, i, distance, distance, impact)
        })
        .unzip();
    compare(kernel, distance, impact_error(distance), &spheres, &rays)
}

/// Compares what a tracer makes of rays from so many radii away with f64; `of_l` is the error of a line's distance from the centre.
fn compare(kernel: &Kernel, distance: f64, of_l: f64, spheres: &[Sphere], rays: &[In]) -> Verdict {
    let mut wrong = 0;
    let mut errors = Vec::new();
    let (mut worst_decision, mut worst_distance, mut worst_normal) = (0.0f64, 0.0f64, 0.0f64);
    for ((out, sphere), ray) in trace(kernel, spheres, rays).iter().zip(spheres).zip(rays) {
        let roots = roots(ray, sphere);
        let hit = out.t != NO_HIT;
        if hit != (roots.impact <= 1.0) {
            wrong += 1;
            worst_decision = worst_decision.max((roots.impact - 1.0).abs());
        } else if hit {
            let radius = f64::from(sphere.radius);
            let expected = if roots.near > 0.0 { roots.near } else { roots.far };
            let error = (f64::from(out.t) - expected).abs() / radius;
            // k is off by 8 u D; h = sqrt(1 - l^2) by l / h times the error of l, or its root where h is smaller still.
            let h = (roots.far - roots.near) / (2.0 * radius);
            let of_h = of_l / h.max(of_l.sqrt());
            worst_distance = worst_distance.max(error / (8.0 * U * distance.max(1.0) + of_h));
            errors.push(error);
            let at = exact(ray.origin) + expected * exact(ray.direction) - exact(sphere.center);
            let off = (exact(out.normal) - at.normalize()).length();
            worst_normal = worst_normal.max(off / (of_l + of_h + 8.0 * U));
        }
    }
    let median = quantile(&mut errors, 0.5);
    Verdict { wrong: f64::from(wrong) / rays.len() as f64, worst_decision, median, worst_distance, worst_normal }
}

pub fn distances() -> Vec<Cell> {
    let own = tracer("sphere", &[]);
    // The textbook's discriminant has an error of u D^2: 3 % of the decisions are wrong at 1e3 radii, a third beyond.
    let textbook = tracer("sphere", &SPHERE_BY_THE_BOOK);
    let mut all = Vec::new();
    // At 1e7 the rounding of the centre alone is 0.6 radii: nothing can be promised there, but in the camera's own axes.
    for distance in [0.0, 0.5, 0.99, 1.000_01, 1.001, 1.5, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6] {
        let range = format!("D/r = {distance}");
        let found = judge(&own, distance);
        let wrong = (1e1..=1e6).contains(&distance).then(|| judge(&textbook, distance));
        let cell = |figure, limit, because, get: &dyn Fn(&Verdict) -> f64, finds: bool| {
            let cell = Cell::new(&range, figure, limit, because).achieved(get(&found));
            match &wrong {
                Some(wrong) if finds => cell.planted(TEXTBOOK_SPHERE, get(wrong)),
                _ => cell,
            }
        };
        let limit = impact_error(distance);
        all.push(cell(
            "Spheres: largest distance from the edge, in radii, at which a ray was decided wrongly",
            limit,
            "the rounding of o - c and of k d, and the roots: 2 u D + 4 u.",
            &|v| v.worst_decision,
            distance >= 1e3,
        ));
        all.push(cell(
            "Spheres: share of wrongly decided rays, for impact parameters of 0 to 1.05 radii",
            // Of impact parameters uniform in 0..1.05, a share below the error over 1.05 can lie on the wrong side.
            limit,
            "the share of impact parameters that lie within that error of the edge.",
            &|v| v.wrong,
            distance >= 1e3,
        ));
        all.push(cell(
            "Spheres: median error of the distance, in radii",
            4.0 * U * distance.max(1.0),
            "k = (o - c) · d / d² is a sum of three rounded products: typically 4 u D.",
            &|v| v.median,
            distance >= 1e1,
        ));
        all.push(cell(
            "Spheres: largest error of the distance over its bound",
            1.0,
            "the bound is 8 u D for k, plus for the root the error of the line's position divided by half the chord (`impact_error`).",
            &|v| v.worst_distance,
            distance >= 1e1,
        ));
        all.push(cell(
            "Spheres: largest error of the normal over its bound",
            1.0,
            "the bound is that of the line's position, plus the same divided by half the chord (`compare`).",
            &|v| v.worst_normal,
            false,
        ));
    }
    all
}

/// Spheres of radius 1 near the axis of view, where space is turned with the camera: what a telescope sees. The rays
/// start at the origin.
fn on_axis(kernel: &Kernel, distance: f64) -> Verdict {
    const RAYS: usize = 20_000;
    let mut random = Random(5);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let (at, aim, phi) = (3.0 * unit(&mut random), 1.05 * random.uniform(), TAU * random.uniform());
            let sphere =
                Sphere { center: rounded(DVec3::new(at.x, at.y, -distance)), radius: 1.0, ..Sphere::default() };
            let target = exact(sphere.center) + aim * DVec3::new(phi.cos(), phi.sin(), 0.0);
            (sphere, In::new(i, DVec3::ZERO, target.normalize()))
        })
        .unzip();
    compare(kernel, distance, AXIS_ERROR, &spheres, &rays)
}

/// The error of a line's distance from the centre where both lie within a few radii of the axis: across it nothing is
/// larger than those few radii, 4 here, and a difference, two products and two sums round in it; along it the error of
/// the foot is taken out again.
const AXIS_ERROR: f64 = 4.0 * 6.0 * U;

pub fn on_the_axis() -> Vec<Cell> {
    let own = tracer("sphere", &[]);
    let textbook = tracer("sphere", &SPHERE_BY_THE_BOOK);
    // Off by the rounding of a distance of many radii.
    let by_t = "normalize(ray.origin + t * ray.direction - sphere.center)";
    let by_distance = tracer("sphere", &[("geometry/sphere", "sphere_normal(ray, t, sphere)", by_t)]);
    let mut all = Vec::new();
    for exponent in 1..=8 {
        let distance = 10f64.powi(exponent);
        let range = format!("D/r = 1e{exponent}");
        let (found, wrong, by_distance) =
            (on_axis(&own, distance), on_axis(&textbook, distance), on_axis(&by_distance, distance));
        let cell = Cell::new(
            &range,
            "Spheres near the axis of view: largest distance from the edge, in radii, at which a ray was decided wrongly",
            AXIS_ERROR,
            "across the axis no number exceeds 4 radii, and there are six roundings: 24 u.",
        );
        let cell = cell.achieved(found.worst_decision);
        all.push(if exponent >= 3 { cell.planted(TEXTBOOK_SPHERE, wrong.worst_decision) } else { cell });
        let cell = Cell::new(
            &range,
            "Spheres near the axis of view: largest error of the normal, over its bound",
            1.0,
            "that error, and that error divided by half the chord.",
        );
        let cell = cell.achieved(found.worst_normal);
        all.push(match exponent >= 4 {
            true => cell.planted("normal from the distance along the ray", by_distance.worst_normal),
            false => cell,
        });
    }
    all
}

#[test]
fn spheres_behind_the_ray_and_rays_without_a_way_out_are_missed() {
    let mut random = Random(3);
    let (mut spheres, mut rays) = (Vec::new(), Vec::new());
    for i in 0..10_000 {
        // Nearer than 1.001 radii the errors of the distance could decide.
        let (distance, impact) = (1.0 + decades(&mut random, -3.0, 5.0), random.uniform());
        let (sphere, mut ray) = aimed(&mut random, i, distance, distance, impact);
        ray.direction = ray.direction.map(|x| -x);
        spheres.push(sphere);
        rays.push(ray);
    }
    // A tangent that starts where it touches: both roots are 0, and their quotient is no number.
    for direction in [DVec3::Y, DVec3::NEG_Z, DVec3::new(0.0, 0.6, 0.8)] {
        rays.push(In::new(spheres.len(), DVec3::X, direction));
        spheres.push(Sphere { radius: 1.0, ..Sphere::default() });
    }
    let found = trace(&tracer("sphere", &[]), &spheres, &rays);
    let hits: Vec<_> = found.iter().zip(&rays).filter(|(out, _)| out.t != NO_HIT).collect();
    assert!(hits.is_empty(), "{} of {} hit, the first: {:?}", hits.len(), rays.len(), hits[0]);
}

#[test]
fn sphere_surface_is_on_the_sphere_and_its_normal_is_unit() {
    let mut random = Random(4);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..10_000)
        .map(|i| {
            let (distance, impact) = (decades(&mut random, -1.0, 4.0), random.uniform());
            aimed(&mut random, i, 1.0, distance, 0.999 * impact)
        })
        .unzip();
    let check = |kernel: &Kernel| {
        let (mut off, mut hits) = (0, 0);
        for (out, sphere) in trace(kernel, &spheres, &rays).iter().zip(&spheres) {
            if out.t == NO_HIT {
                continue;
            }
            hits += 1;
            assert_eq!(out.local, out.normal);
            // Square, sum, root and quotient of normalize, with 2.5 ulps to each of the last two.
            assert!((exact(out.normal).length() - 1.0).abs() <= 8.0 * U, "{out:?}");
            let height = (exact(out.point) - exact(sphere.center)).length() - f64::from(sphere.radius);
            off += u32::from(height.abs() > f64::from(out.error));
        }
        assert!(hits > 9_900, "{hits} hits of 10 000");
        off
    };
    assert_eq!(check(&tracer("sphere", &[])), 0, "points farther off than the error that the surface states");
    // Left where t puts it, the point is off by the error of t.
    assert!(check(&unprojected()) > 1000);
}

/// The sphere whose points are not put back onto it.
fn unprojected() -> Kernel {
    tracer("sphere", &[("geometry/sphere", "sphere.center + sphere.radius * normal", "ray.origin + t * ray.direction")])
}

/// How many of the rays that left spheres went wrong.
#[derive(Default)]
struct Leaving {
    rays: u32,
    /// Rays outwards that met their own sphere.
    again: u32,
    /// Rays inwards whose chord was lost or off by more than 10 %.
    chords: u32,
}

/// Rays that meet a sphere of this radius, with its centre at `ratio` radii from the origin of space, and leave it at
/// cosines from 0.05 to 1 with its normal, out and in.
fn leave(kernel: &Kernel, radius: f64, ratio: f64) -> Leaving {
    const RAYS: usize = 1000;
    let mut random = Random(2);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let center = rounded(radius * ratio * unit(&mut random));
            let sphere = Sphere { center, radius: radius as f32, ..Sphere::default() };
            let target = exact(center) + 0.999 * radius * unit(&mut random);
            let origin = exact(center) + radius * decades(&mut random, 0.3, 3.0) * unit(&mut random);
            let mut ray = In::new(i, origin, (target - origin).normalize());
            let cos = 0.05 + 0.95 * random.uniform();
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let (sin, phi) = ((1.0 - cos * cos).sqrt(), random.uniform() * std::f64::consts::TAU);
            ray.leaving = rounded(DVec3::new(sin * phi.cos(), sin * phi.sin(), side * cos));
            (sphere, ray)
        })
        .unzip();
    let mut found = Leaving::default();
    for ((out, sphere), ray) in trace(kernel, &spheres, &rays).iter().zip(&spheres).zip(&rays) {
        if out.t == NO_HIT {
            continue;
        }
        found.rays += 1;
        if ray.leaving[2] > 0.0 {
            found.again += u32::from(out.again != NO_HIT);
        } else {
            // The chord of a ray that starts on the sphere itself.
            let chord = 2.0 * f64::from(sphere.radius) * f64::from(-ray.leaving[2]);
            let right = out.again != NO_HIT && (f64::from(out.again) / chord - 1.0).abs() < 0.1;
            found.chords += u32::from(!right);
        }
    }
    found
}

/// Rays that leave spheres of radii from 1e-6 to 1e6, each with its centre up to 1000 radii away from the origin of space.
pub fn leavings() -> Vec<Cell> {
    const FIGURE: &str = "Spheres: of 1000 rays, those that hit their own sphere again or had a wrong chord inside, with cosines \
                          from 0.05 to 1";
    const BECAUSE: &str =
        "none, because the offset exceeds the bound of the point's error, and is below a tenth of the shortest chord.";
    let wrong = |found: Leaving| f64::from(found.again + found.chords);
    let own = tracer("sphere", &[]);
    let fixed = tracer("sphere", &FIXED_OFFSET);
    let by_bits = tracer("sphere", &[BY_BITS]);
    let unprojected = unprojected();
    let mut all = Vec::new();
    for exponent in -6..=6 {
        for ratio in [0.0, 1.0, 10.0, 100.0, 1000.0] {
            let radius = 10f64.powi(exponent);
            let found = leave(&own, radius, ratio);
            assert!(found.rays > 950, "{} rays of 1000 met the sphere", found.rays);
            let range = format!("r = 1e{exponent}, {ratio} radii from the origin");
            let mut cell = Cell::new(range, FIGURE, 0.0, BECAUSE).achieved(wrong(found));
            // A fixed distance re-hits large spheres and loses the inside of small ones.
            if [(5, 10.0), (-3, 0.0)].contains(&(exponent, ratio)) {
                cell = cell.planted(FIXED_T_MIN, wrong(leave(&fixed, radius, ratio)));
            }
            // 256 ulps never re-hit, and lose the inside of small spheres and of far ones.
            if [(-2, 0.0), (-4, 0.0), (0, 1000.0)].contains(&(exponent, ratio)) {
                cell = cell.planted(OFFSET_BY_BITS, wrong(leave(&by_bits, radius, ratio)));
            }
            // Without putting the point back onto the sphere, a third re-hit or lose their chord.
            if (exponent, ratio) == (0, 1.0) {
                cell = cell
                    .planted("point that is not put back onto the sphere", wrong(leave(&unprojected, radius, ratio)));
            }
            all.push(cell);
        }
    }
    all
}

/// Rays that leave spheres with their centres at `ratio` radii from the origin of space, at cosines within these
/// decades: how many met the sphere again that went out, and of those that went in how many left to the wrong side, or
/// lost their chord, or found its end elsewhere than rounding allows.
fn graze(kernel: &Kernel, ratio: f64, cosines: (f64, f64)) -> f64 {
    const RAYS: usize = 10_000;
    let mut random = Random(6);
    let (spheres, rays): (Vec<_>, Vec<_>) = (0..RAYS)
        .map(|i| {
            let (sphere, mut ray) = aimed(&mut random, i, ratio, 3.0, 0.0);
            ray.direction = rounded((exact(ray.direction) + 0.3 * random.uniform() * unit(&mut random)).normalize());
            let cosine = decades(&mut random, cosines.0, cosines.1);
            ray.leaving = leaving(&mut random, cosine, i % 2 == 0);
            (sphere, ray)
        })
        .unzip();
    let (mut hits, mut wrong) = (0, 0);
    for ((out, sphere), ray) in trace(kernel, &spheres, &rays).iter().zip(&spheres).zip(&rays) {
        if out.t == NO_HIT {
            continue;
        }
        hits += 1;
        let outwards = (exact(out.start) - exact(out.point)).dot(exact(out.normal)) >= 0.0;
        let cosine = exact(out.leaving).dot(exact(out.normal));
        let wrong_side = cosine.abs() > 8.0 * U && outwards != (cosine > 0.0);
        let second = In { origin: out.start, direction: out.leaving, ..*ray };
        let (roots, radius) = (roots(&second, sphere), f64::from(sphere.radius));
        let (of_l, h) = (impact_error(1.0), (roots.far - roots.near) / (2.0 * radius));
        let bound = radius * (8.0 * U + of_l / h.max(of_l.sqrt()));
        let off = (f64::from(out.again) - roots.far).abs();
        let lost = out.again == NO_HIT || off > bound;
        wrong += usize::from(wrong_side || if outwards { out.again != NO_HIT } else { lost });
    }
    assert!(hits > RAYS * 9 / 10, "{hits} hits");
    wrong as f64
}

pub fn grazing() -> Vec<Cell> {
    let own = tracer("sphere", &[]);
    let without = tracer("sphere", &[WITHOUT_OFFSET]);
    let mut all = Vec::new();
    for ratio in [0.0, 1.0, 100.0] {
        for exponent in 0..7 {
            let (range, cosines) = decade(exponent);
            let range = format!("{range}, {ratio} radii from the origin");
            let figure = "Spheres by the cosine of the leaving ray: of 10 000 rays, those that hit their own sphere again or had a \
                          wrong chord inside";
            let because = "none, because the offset ε exceeds the bound of the error, and the chord from there is at least sqrt(8 ε \
                           r) long and has an error of 6 u divided by half of it.";
            all.push(
                Cell::new(range, figure, 0.0, because)
                    .achieved(graze(&own, ratio, cosines))
                    .planted(NO_OFFSET, graze(&without, ratio, cosines)),
            );
        }
    }
    all
}
