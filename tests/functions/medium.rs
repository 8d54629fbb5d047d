//! medium/*: the part of a ray within a medium, how far light flies in it, and where it goes from there.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use gpu_rt::data::{Cuboid, Sphere};

use crate::kernel::{Kernel, Setup, array};
use crate::stats::{Random, chi_square, normal_two_sided, one_sample_t, sidak};
use crate::trace::NO_HIT;
use crate::vectors::{U, decades, exact, rounded, unit};

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Ray {
    origin: [f32; 3],
    primitive: u32,
    direction: [f32; 3],
    padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Within {
    interval: [f32; 2],
    /// What the shape says as a surface.
    distance: f32,
    padding: f32,
}

/// `NO_INTERVAL` of shaders/medium/interval.wgsl.
const NO_INTERVAL: [f32; 2] = [1.0, 0.0];

fn within<P: Pod>(primitive: &str, kind: &str, replaced: &[(&str, &str)], shapes: &[P], rays: &[Ray]) -> Vec<Within> {
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
            // The bounds of functions/sphere.rs: of the perpendicular l and of the roots, in radii.
            let away = (f.length() / r).max(1.0);
            let of_l = 2.0 * U * away + 32.0 * (U * away).powi(2) + 4.0 * U;
            let touches = h <= r * of_l.sqrt();
            let bound = r * (8.0 * U * away + of_l / (h / r).max(of_l.sqrt()));
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
    let planted = [("geometry/sphere", "test/control/sphere_far_root")];
    assert!(check(&within("sphere", "Sphere", &planted, &spheres, &rays)) > 1000, "roots that cancel");
    let planted = [("medium/interval", "test/control/interval_bare")];
    assert!(check(&within("sphere", "Sphere", &planted, &spheres, &rays)) > 1000, "what lies behind");
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
            // How far f32 misplaces faces along the ray, as in functions/cuboid.rs.
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
    let planted = [("medium/interval", "test/control/interval_bare")];
    assert!(check(&within("cuboid", "Cuboid", &planted, &cuboids, &rays)) > 1000, "what lies behind");
}

/// Depths from pairs of random words.
fn depths(replaced: &[(&str, &str)], words: &[[u32; 2]]) -> Vec<f32> {
    Kernel::with("test/free_flight", &Setup { replaced, ..Setup::default() }).run(words)
}

const ONE_WORD: &[(&str, &str)] = &[("medium/free_flight", "test/control/free_flight_24_bits")];

/// Two words whose upper 24 bits are w0 and w1; their lower 8 must not matter.
fn words(random: &mut Random, w0: u32, w1: u32) -> [u32; 2] {
    [w0 << 8 | random.bits() as u32 & 255, w1 << 8 | random.bits() as u32 & 255]
}

#[test]
fn optical_depths_are_right_to_the_promise_of_the_logarithm() {
    const LAST: u32 = (1 << 24) - 1;
    let mut random = Random(83);
    let ends = [0, 1, 2, 3, 0x7f_ffff, 0x80_0000, LAST - 1, LAST];
    let mut rows = Vec::new();
    for w0 in ends.into_iter().chain(167_700..167_850) {
        rows.extend(ends.map(|w1| words(&mut random, w0, w1)));
    }
    for i in 0..200_000 {
        // Near 0, near 1, and anywhere.
        let small = decades(&mut random, -14.0, 0.0);
        let number = ((if i % 2 == 0 { small } else { 1.0 - small }) * 2f64.powi(48)) as u64;
        rows.push(words(&mut random, (number >> 24) as u32, number as u32 & LAST));
    }
    let wrong = |replaced| {
        let mut wrong = 0;
        for (row, tau) in rows.iter().zip(depths(replaced, &rows)) {
            let share = f64::from(row[0] >> 8) / 2f64.powi(24) + f64::from(row[1] >> 8) / 2f64.powi(48);
            let (expected, rest) = (-(-share).ln_1p(), 1.0 - share);
            // u, the sum and the product round by u each, the nested terms count by less than 0.01; or the rounding of
            // 1 - U, and the logarithm's promise: 2^-21 for 1 - U in 0.5..2, else 3 ulps of at most 2 u.
            let series = 4.0 * U * expected;
            let log = U + if rest >= 0.5 { 8.0 * U } else { 6.0 * U * expected };
            // By rounding either may be taken within an ulp of 0.01.
            let bound = if share < 0.01 * (1.0 - 4.0 * U) { series } else { log };
            wrong += u32::from((f64::from(tau) - expected).abs() > bound);
        }
        wrong
    };
    assert_eq!(wrong(&[]), 0);
    assert!(wrong(ONE_WORD) > 1000);
}

/// p-values of the share of depths below each of some limits. To see 1e-8, draws come from a part of all numbers that
/// reaches some way beyond the limit and is small: the lowest for small limits, the highest for large ones.
fn shares(replaced: &[(&str, &str)]) -> Vec<(f64, f64)> {
    const DRAWS: usize = 1 << 16;
    let mut random = Random(84);
    let mut found = Vec::new();
    for limit in [
        1e-10, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.009_99, 0.0101, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0,
        16.0, 20.0, 25.0,
    ] {
        let limit: f64 = limit;
        // The probability of what is counted: of depths below the limit, or of those above.
        let below = limit < 0.7;
        let share = if below { -(-limit).exp_m1() } else { (-limit).exp() };
        // A power of two of numbers, at most all of them, and at least twice what is counted.
        let part = (2f64.powi(48) * share * 2.0).log2().ceil().clamp(8.0, 48.0) as u32;
        let rows: Vec<[u32; 2]> = (0..DRAWS)
            .map(|_| {
                let low = random.bits() >> (64 - part);
                let number = if below { low } else { (1u64 << 48) - 1 - low };
                words(&mut random, (number >> 24) as u32, number as u32 & 0xff_ffff)
            })
            .collect();
        let counted = depths(replaced, &rows).iter().filter(|&&tau| (f64::from(tau) < limit) == below).count();
        let p = share * 2f64.powi(48 - part as i32);
        let z = (counted as f64 - p * DRAWS as f64) / (p * (1.0 - p) * DRAWS as f64).sqrt();
        found.push((limit, normal_two_sided(z)));
    }
    found
}

#[test]
fn light_flies_as_far_as_beer_and_lambert_say() {
    // Binomial shares of 2^16 draws with p in 0.25..0.5: an error of 3 % of the share is found.
    let found = shares(&[]);
    let threshold = sidak(1e-6, found.len());
    for (limit, p) in &found {
        assert!(*p > threshold, "depth {limit:e}: p = {p:e}");
    }
    // One word puts all of the 6e-8 that lie below its first step at 0, and knows nothing beyond 16.6.
    let wrong: Vec<f64> =
        shares(ONE_WORD).into_iter().filter(|(_, p)| *p < threshold).map(|(limit, _)| limit).collect();
    for limit in [1e-9, 1e-8, 3e-8, 20.0, 25.0] {
        assert!(wrong.contains(&limit), "{limit:e} is not in {wrong:?}");
    }

    let mut random = Random(85);
    let rows: Vec<[u32; 2]> = (0..1 << 20).map(|_| [random.bits() as u32, random.bits() as u32]).collect();
    let tau: Vec<f64> = depths(&[], &rows).into_iter().map(f64::from).collect();
    let squares: Vec<f64> = tau.iter().map(|x| x * x).collect();
    let threshold = sidak(1e-6, 2);
    let (first, second) = (one_sample_t(&tau, 1.0), one_sample_t(&squares, 2.0));
    assert!(first.p > threshold && second.p > threshold, "{first:?} {second:?}");
    // 1 % off.
    assert!(one_sample_t(&tau, 1.01).p < threshold && one_sample_t(&squares, 2.04).p < threshold);
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Scattering {
    incoming: [f32; 3],
    g: f32,
    u: [f32; 2],
    one_minus_g: f32,
    padding: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Scattered {
    direction: [f32; 3],
    padding: f32,
    /// 1 - cos and 1 + cos.
    from_one: [f32; 2],
    padding2: [f32; 2],
}

impl Scattering {
    fn new(incoming: DVec3, g: f64, u: [f32; 2]) -> Scattering {
        let one_minus_g = (1.0 - g.abs()) as f32;
        Scattering { incoming: rounded(incoming), g: g as f32, u, one_minus_g, padding: 0.0 }
    }
}

fn phase(keyed: &str, replaced: &[(&str, &str)]) -> Kernel {
    Kernel::with("test/phase", &Setup { replaced, values: &[("keyed", keyed)], ..Setup::default() })
}

const ASYMMETRIES: [f64; 7] = [0.0, 1e-8, 1e-3, 0.5, 0.9, 0.999, 1.0 - 1e-6];

/// 1 - cos and 1 + cos by Henyey and Greenstein, for g >= 0, by the same factors in f64. That they are the inverse of the
/// distribution function is what the chi-square test says.
fn from_one(g: f64, u: f64) -> [f64; 2] {
    let (less, d) = (1.0 - g, 1.0 - g + 2.0 * g * u);
    let back = 2.0 * (less / d).powi(2) * (1.0 - u) * (1.0 + g * u);
    [back, 2.0 * ((1.0 + g) / d).powi(2) * u * (less + g * u)]
}

#[test]
fn cosines_of_scattering_keep_their_digits() {
    let last = 1.0 - U as f32;
    let mut random = Random(86);
    let mut rows = Vec::new();
    for g in ASYMMETRIES.into_iter().flat_map(|g| [g, -g]) {
        let ends = [0.0, U as f32, 0.25, 0.5, 0.75, last];
        let random_ones: Vec<f32> = (0..2000)
            .map(|i| {
                let small = decades(&mut random, -7.0, 0.0);
                ((if i % 2 == 0 { small } else { 1.0 - small }) / U).floor() as f32 * U as f32
            })
            .collect();
        for u in ends.into_iter().chain(random_ones) {
            let across = (random.bits() >> 40) as f32 * U as f32;
            rows.push((g, Scattering::new(unit(&mut random), g, [u, across])));
        }
    }
    let given: Vec<Scattering> = rows.iter().map(|row| row.1).collect();
    // By the asymmetry: how often 1 - cos or 1 + cos was off, and the direction.
    let check = |replaced: &[(&str, &str)]| {
        let mut wrong = [[0u32; 2]; ASYMMETRIES.len()];
        for ((g, row), out) in rows.iter().zip(phase("false", replaced).run::<_, Scattered>(&given)) {
            let at = ASYMMETRIES.iter().position(|x| *x == g.abs()).expect("it is one of them");
            let mut expected = from_one(g.abs(), f64::from(row.u[0]));
            if *g < 0.0 {
                expected.reverse();
            }
            // |g| and 1 - |g| are rounded; D is off by 3 u, as is 1 - h + h u, and 1 + h by 2 u; squares double it, the
            // quotients add 5 u each, the products 4: below 26 u in all.
            let off = (0..2).any(|i| {
                let error = (f64::from(out.from_one[i]) - expected[i]).abs();
                error.is_nan() || error > 26.0 * U * expected[i]
            });
            let direction = exact(out.direction);
            let along = direction.dot(exact(row.incoming));
            let cos = if expected[0] < 1.0 { 1.0 - expected[0] } else { expected[1] - 1.0 };
            let sin2 = expected[0] * expected[1];
            // Normalizing takes 8 u; basis and sum 8 u; the circle's points may be off by 2^-11 in both coordinates, which
            // changes the length by 2^-10.5 of sin^2, and that the cosine.
            let bound = 16.0 * U + 26.0 * U + 2f64.powf(-10.5) * sin2;
            let lost = (direction.length() - 1.0).abs() > 8.0 * U || (along - cos).abs() > bound;
            wrong[at][0] += u32::from(off);
            wrong[at][1] += u32::from(lost || along.is_nan());
        }
        wrong
    };
    assert_eq!(check(&[]), [[0; 2]; ASYMMETRIES.len()]);
    let textbook = check(&[("medium/phase", "test/control/phase_textbook")]);
    for (g, wrong) in ASYMMETRIES.iter().zip(textbook) {
        assert!(*g == 0.0 || wrong[0] > 500, "{g}: {wrong:?}");
        assert!(*g != 1e-8 || wrong[1] > 500, "{g}: {wrong:?}");
    }
}

#[test]
fn light_scatters_by_henyey_and_greenstein() {
    const DRAWS: usize = 1 << 18;
    const RINGS: usize = 61;
    const SECTORS: usize = 7;
    let kernel = phase("true", &[]);
    let mut random = Random(87);
    let asymmetries: Vec<f64> = ASYMMETRIES.into_iter().filter(|g| *g < 0.9999).flat_map(|g| [g, -g]).collect();
    let threshold = sidak(1e-6, 2 * asymmetries.len());
    for g in asymmetries {
        let incoming = unit(&mut random);
        let given = Scattering::new(incoming, g, [0.0; 2]);
        let before = exact(given.incoming);
        let across = before.cross(DVec3::X).normalize();
        let draws: Vec<(f64, f64)> = kernel
            .run_with::<_, Scattered>(&[given], DRAWS, &[])
            .iter()
            .map(|out| {
                // 1 - cos from the difference of the directions, which keeps its digits.
                let after = exact(out.direction).normalize();
                let less = 0.5 * (after - before.normalize()).length_squared();
                (less, after.dot(before.cross(across)).atan2(after.dot(across)))
            })
            .collect();
        // Uniform, if the distribution function is that of h: (1 - h) (1 + cos) / (S (1 + h + S)), S^2 = 1 + h^2 - 2 h cos.
        let p_for = |h: f64| {
            let mut cells = vec![0u64; RINGS * SECTORS];
            for &(less, angle) in &draws {
                let root = ((1.0 - h).powi(2) + 2.0 * h * less).sqrt();
                let share = (1.0 - h) * (2.0 - less) / (root * (1.0 + h + root));
                let bin = |x: f64, bins: usize| ((x * bins as f64).max(0.0) as usize).min(bins - 1);
                let angle = 0.5 + angle / std::f64::consts::TAU;
                cells[bin(share, RINGS) * SECTORS + bin(angle, SECTORS)] += 1;
            }
            chi_square(&cells, &vec![DRAWS as f64 / cells.len() as f64; cells.len()], 1)
        };
        let p = p_for(g);
        assert!(p > threshold, "g {g}: p = {p:e}");
        let cosines: Vec<f64> = draws.iter().map(|draw| 1.0 - draw.0).collect();
        let mean = one_sample_t(&cosines, g);
        assert!(mean.p > threshold, "g {g}: {mean:?}");
        // Off by 0.02, or by 5 % of 1 - |g|.
        let other = if g.abs() < 0.6 { g + 0.02 } else { 0.95 * g + 0.05 * g.signum() };
        assert!(p_for(other) < threshold, "g {g} as {other}: p = {:e}", p_for(other));
        assert!(one_sample_t(&cosines, other).p < threshold || g.abs() > 0.99, "g {g} as {other}");
    }
}
