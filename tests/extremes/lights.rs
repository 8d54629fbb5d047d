//! light/sphere: lights that are tiny from where they are seen, and lights that are touched; and radiance over forty decades.

use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::data::Sphere;

use crate::common::kernel::{Fault, Overlay, array};
use crate::common::light_kernel::{DRAWS, In, Out, SHARES, SPHERE, cone, draws, kernel, spheres};
use crate::common::render::{Request, Shot, render, render_planted, scene};
use crate::common::scenes::triple;
use crate::common::stats::mean_and_variance;
use crate::common::vectors::{U, exact};
use crate::table::{Cell, ONE_MINUS_COS};

/// Standard errors that a mean is off by once in 1e6.
const NOISE: f64 = 4.9;

/// The cone by 1 - cos, which has no digits for spheres far away.
const TEXTBOOK: Fault<'_> = ("light/sphere", "sine * sine / (1.0 + cosine)", "1.0 - sqrt(1.0 - sine * sine)");

/// How far a density may be off. The sine is off by 4 u; d(height) / height is (1 + cos) / cos of that where the cosine is not
/// small, and at most the root of twice what 1 - sine is off by. 8 u more for the quotients.
fn density_bound(height: f64) -> f64 {
    8.0 * U + (8.0 * U / (1.0 - height).max(1e-300)).min((8.0 * U).sqrt())
}

fn range(share: f64) -> String {
    match 1.0 - share {
        gap if gap > 0.0 && gap < 0.01 => format!("r/D = 1 - {gap:.0e}"),
        _ => format!("r/D = {share:e}"),
    }
}

pub fn densities() -> Vec<Cell> {
    const SEEDS: u64 = 50;
    let worst = |share: f64, replaced: &[Fault<'_>]| {
        let (mut rows, mut shapes): (Vec<In>, Vec<Sphere>) = Default::default();
        for seed in 0..SEEDS {
            let (more, spheres) = spheres(&[share], 600 + seed);
            rows.extend(more.iter().map(|row| In { shape: shapes.len() as u32, ..*row }));
            shapes.extend(spheres);
        }
        let found = kernel(SPHERE, replaced).run_with::<_, Out>(&rows, rows.len(), &[array("shapes", &shapes)]);
        rows.iter().zip(&found).fold(0.0f64, |worst, (row, out)| {
            let (_, sine, height) = cone(row, &shapes[row.shape as usize]);
            let pdf = f64::from(out.pdf);
            // Within 8 u of the surface the point may count as inside, where the density is that of all directions.
            let inside = sine > 1.0 - 8.0 * U && (pdf * 4.0 * PI - 1.0).abs() < 4.0 * U;
            let error = if inside { 0.0 } else { (pdf * 2.0 * PI * height - 1.0).abs() / density_bound(height) };
            assert_eq!(out.pdf, out.again);
            worst.max(error)
        })
    };
    SHARES
        .into_iter()
        .map(|share| {
            let cell = Cell::new(
                range(share),
                "Spheres: largest relative error of the density over its bound",
                1.0,
                "8 u, plus 8 u divided by the cosine of the cone's half angle, or the square root of 8 u near contact (`density_bound`).",
            )
            .achieved(worst(share, &[]));
            if share < 0.05 { cell.planted(ONE_MINUS_COS, worst(share, &[TEXTBOOK])) } else { cell }
        })
        .collect()
}

/// Irradiance on a plane that faces the centre: it sees all of the sphere, pi (r/D)².
pub fn irradiances() -> Vec<Cell> {
    let mut all = Vec::new();
    let (rows, shapes) = spheres(&SHARES, 640);
    let [own, textbook] = [&[][..], &[TEXTBOOK]].map(|replaced| draws(SPHERE, &rows, &shapes, replaced));
    for (i, (row, share)) in rows.iter().zip(SHARES).enumerate() {
        let (axis, sine, height) = cone(row, &shapes[row.shape as usize]);
        // A hit is one by the shape's own test; further than 1e-6 a ray of f32 does not tell.
        let sees = |out: &Out| share < 2e-6 || out.distance != -1.0;
        let of = |found: &[Out]| {
            let found = &found[i * DRAWS..(i + 1) * DRAWS];
            let value = |out: &Out| exact(out.direction).dot(axis).max(0.0) / f64::from(out.pdf) / (PI * sine * sine);
            let values: Vec<f64> = found.iter().map(|out| if sees(out) { value(out) } else { 0.0 }).collect();
            let (mean, variance) = mean_and_variance(&values);
            let missed = found.iter().filter(|out| !sees(out)).count();
            ((mean - 1.0).abs(), NOISE * (variance / DRAWS as f64).sqrt(), missed as f64)
        };
        let (error, noise, missed) = of(&own);
        // What is added up is the mean over a cone narrower by 12 u.
        let cell = Cell::new(
            range(share),
            "Spheres: relative error of the irradiance from 2^16 sampled directions and densities",
            noise + density_bound(height) + 32.0 * U,
            "4.9 standard errors, the density's bound, and 32 u for the narrower cone and the directions.",
        )
        .achieved(error);
        all.push(if share < 5e-3 { cell.planted(ONE_MINUS_COS, of(&textbook).0) } else { cell });
        if (2e-6..=1.0 - 8.0 * U).contains(&share) {
            // Near contact the limb's directions change little of the distance by which they pass it.
            let (limit, because) = match share > 0.9999 {
                true => (
                    DRAWS as f64 / 1000.0,
                    "none, or 1 in 1000 within 1e-4 of contact, where directions near the limb miss the sphere by very little.",
                ),
                false => (
                    0.0,
                    "none, or 1 in 1000 within 1e-4 of contact, where directions near the limb miss the sphere by very little.",
                ),
            };
            let figure = "Spheres: of 2^16 sampled directions, those that miss the light";
            all.push(Cell::new(range(share), figure, limit, because).achieved(missed));
        }
    }
    all
}

fn mean_and_noise(shot: &Shot) -> (f64, f64) {
    let mean = shot.mean_of_all();
    (mean.value[0], NOISE * mean.variance[0].sqrt())
}

/// A floor straight below a sphere: what light sampling makes of it in a render.
pub fn floors() -> Vec<Cell> {
    let mut all = Vec::new();
    let from_outside = "length(ray.origin - sphere.center) > sphere.radius";
    let by_normal = Overlay::new(&[("light/sphere", from_outside, "dot(ray.direction, normal) < 0.0")]);
    let request = Request::spp(64).mis();
    // Turned, so that no coordinate is exact by chance.
    let (up, across) = (DVec3::new(0.48, 0.64, 0.6), DVec3::new(0.8, -0.6, 0.0));
    let (middle, other) = (DVec3::new(0.3, -0.2, 0.1), up.cross(across));
    for share in [1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2, 0.9] {
        for two_sided in [true, false] {
            if two_sided && share > 1e-7 {
                // The sides are told apart by digits that a sphere has from there.
                continue;
            }
            let scene = scene(&format!(
                "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: {}, look_at: {}, vertical_fov: 0.01),
    background: Solid((0, 0, 0)),
    materials: {{
        \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1), two_sided: {two_sided}),
        \"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
    }},
    objects: [
        Sphere(center: {}, radius: {share:?}, material: \"lamp\"),
        Quad(corner: {}, u: {}, v: {}, material: \"floor\"),
    ],
)",
                triple(middle + 0.5 * up + 2.0 * other),
                triple(middle),
                triple(middle + up),
                triple(middle - 9.0 * across - 9.0 * other),
                triple(18.0 * across),
                triple(18.0 * other),
            ));
            let shot = render(&scene, &request);
            let expected = 0.5 * share * share;
            let (mean, noise) = mean_and_noise(&shot);
            let noise = if share < 1e-3 { 0.0 } else { noise / expected };
            let error = |mean: f64| (mean / expected - 1.0).abs();
            let sides = if two_sided { "two sides" } else { "one side" };
            // The view's 1e-4 are 2e-4 of the distance at most, squared.
            let cell =
                Cell::new(
                    format!("r/D = {share:e}, {sides}"),
                    "Relative error of a floor below a sphere, rendered with light sampling",
                    noise + 64.0 * U + 1e-7,
                    "4.9 standard errors as estimated by the film, except for lights so far away that all directions have the same \
                     cosine; the square of 8 u for the point and the centre; and the width of the view.",
                )
                .achieved(error(mean));
            // A ray that arrives by its direction's last digit meets any side.
            all.push(if two_sided || share > 1e-8 {
                cell
            } else {
                let planted = render_planted(&scene, &request, &by_normal);
                cell.planted("side of a light by the normal where it is met", error(planted.mean_of_all().value[0]))
            });
        }
    }
    all
}

/// A room whose walls absorb nothing: whatever is emitted in it is seen everywhere.
fn closed_room(emit: f64, elsewhere: &str, lamps: &str) -> String {
    format!(
        "Scene(
    image: (width: 8, height: 8),
    camera: (look_from: (0, 0.75, 0), look_at: (0.3, 1, 0), up: (0, 0, 1), vertical_fov: 60),
    background: Solid((0, 0, 0)),
    materials: {{
        \"lamp\": DiffuseLight(emit: Rgb({emit:e}, {emit:e}, {emit:e})),
        {lamps}
        \"wall\": Lambertian(albedo: Rgb(1, 1, 1)),
    }},
    objects: [
        Sphere(center: (0, 0, 0), radius: 1, material: \"wall\"),
        Sphere(center: (0, 0, 0), radius: 0.5, material: \"lamp\"),
        {elsewhere}
    ],
    render: (max_depth: 1000),
)"
    )
}

/// What all pixels of such a room differ by from its lamp, relatively, at most.
fn off(shot: &Shot, emit: f64) -> f64 {
    shot.picture.rgb.iter().flatten().fold(0.0, |worst, &v| worst.max((f64::from(v) / emit - 1.0).abs()))
}

const EMISSIONS: [i32; 5] = [-20, -10, 0, 10, 20];

pub fn radiances() -> Vec<Cell> {
    let mut all = Vec::new();
    for exponent in EMISSIONS {
        let emit = 10f64.powi(exponent);
        let shot = render(&scene(&closed_room(emit, "", "")), &Request::spp(64));
        all.push(
            Cell::new(
                format!("emission 1e{exponent}"),
                "Largest relative error of a pixel in a closed room that absorbs nothing, without light sampling",
                12.0 * U,
                "every path contributes the lamp's radiance: its rounding, the 8 sums of a run, and the rounding of the image.",
            )
            .achieved(off(&shot, emit)),
        );
        let shot = render(&scene(&closed_room(emit, "", "")), &Request::spp(64).mis());
        let (mean, noise) = mean_and_noise(&shot);
        // Where the variance is too small or large for f32 the film overstates it: the deviation is below the radiance.
        let noise = noise.min(NOISE * emit / 64.0);
        all.push(
            Cell::new(
                format!("emission 1e{exponent}"),
                "Relative error of the mean radiance in a closed room that absorbs nothing, with light sampling",
                noise / emit + 16.0 * U,
                "4.9 standard errors of 4096 samples with a deviation below the radiance.",
            )
            .achieved((mean / emit - 1.0).abs()),
        );
    }
    all
}

/// Two closed rooms in one scene, the other one with a lamp of 1e20: what is left of this one's.
pub fn rooms() -> Vec<Cell> {
    const OTHER: &str = "Sphere(center: (5, 0, 0), radius: 1, material: \"wall\"),
        Sphere(center: (5, 0, 0), radius: 0.5, material: \"bright\"),";
    const BRIGHT: &str = "\"bright\": DiffuseLight(emit: Rgb(1e20, 1e20, 1e20)),";
    let mut all = Vec::new();
    for exponent in [20, 0, -2, -4, -6, -7, -8, -20] {
        let emit = 10f64.powi(exponent);
        let shot = render(&scene(&closed_room(emit, OTHER, BRIGHT)), &Request::spp(64));
        // Half of the film's step of 2^-88 of the brightest thing, 2^67, over the sum of a run of eight.
        let rounding = 0.5 * 2f64.powi(-88) * 2f64.powi(67) / (8.0 * emit);
        let range = format!("1e{exponent} beside 1e20");
        if rounding < 0.5 {
            all.push(
                Cell::new(
                    range,
                    "Largest relative error of a pixel in a room beside a light of radiance 1e20",
                    12.0 * U + rounding,
                    "as in the room alone, plus half of the film's unit of 2^-88 of the brightest light for each sum of 8.",
                )
                .achieved(off(&shot, emit)),
            );
        } else {
            let brightest = shot.picture.rgb.iter().flatten().fold(0.0f64, |most, &v| most.max(f64::from(v)));
            all.push(
                Cell::new(
                    range,
                    "Radiance in a room beside a light more than 2^92 times as bright",
                    0.0,
                    "the sum of 8 is below half of the film's unit of 2^-88, and rounds to 0: the room is black.",
                )
                .achieved(brightest),
            );
        }
    }
    all
}
