//! material/metal, material/metal_eval: mirrors blurred by no more than the last digits, and by as much as there is.

use std::f64::consts::PI;

use glam::DVec3;
use gpu_rt::data::SCATTERED;

use crate::common::kernel::{Fault, Kernel};
use crate::common::microfacets;
use crate::common::oracles::metal_density;
use crate::common::render::{Request, render, scene};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact};
use crate::table::Cell;

const FUZZES: [f64; 9] = [0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0];
const DRAWS: usize = 1 << 17;

/// Standard errors that a mean is off by once in 1e6.
const NOISE: f64 = 4.9;

const OF_THE_SPHERE: Fault<'_> = ("material/metal", "sample_ball(u.xyz)", "sample_sphere(u.xy)");
const SPHERE: &str = "point of the sphere instead of the ball";
const CUBES: &str = "density by d₊³ - d₋³, sin² by 1 - cos²";

rows! {
    struct In {
        incoming: [f32; 3], fuzz: f32,
        normal: [f32; 3], padding: u32,
        u: [f32; 4],
    }

    struct Out {
        direction: [f32; 3], event: u32,
        pdf: f32, value: f32, padding: [u32; 2],
    }
}

fn kernel(replaced: &[Fault<'_>]) -> Kernel {
    Kernel::replacing("test/fuzz", replaced)
}

/// A ray that meets a surface at an angle with its normal.
fn arriving(random: &mut Random, cos: f64, fuzz: f64) -> In {
    let at = microfacets::arriving(random, cos);
    In { incoming: at.incoming, normal: at.normal, fuzz: fuzz as f32, ..In::default() }
}

/// The mirrored ray of the very numbers that the device has.
fn mirrored(row: &In) -> DVec3 {
    let (incoming, normal) = (exact(row.incoming), exact(row.normal));
    (incoming - 2.0 * incoming.dot(normal) * normal).normalize()
}

/// Directions one by one, against the same numbers in f64: the largest error, times the length of what was normalised.
fn direction_error(fuzz: f64, replaced: &[Fault<'_>]) -> f64 {
    direction_error_of(fuzz, fuzz, replaced)
}

/// The error of directions if the device gets another fuzz.
fn direction_error_of(fuzz: f64, given: f64, replaced: &[Fault<'_>]) -> f64 {
    let mut random = Random(74);
    let rows: Vec<In> = (0..5000)
        .map(|i| {
            let cos = decades(&mut random, -4.0, 0.0);
            let row = arriving(&mut random, cos, given);
            // Some numbers at the ends of their range.
            let u = |at: u32| match i >> (2 * at) & 3 {
                0 => 0.0,
                1 => 1.0 - U as f32,
                _ => (random.bits() >> 40) as f32 * U as f32,
            };
            In { u: [0, 1, 2, 3].map(u), ..row }
        })
        .collect();
    let found = kernel(replaced).run::<_, Out>(&rows);
    rows.iter().zip(found).fold(0.0f64, |worst, (row, out)| {
        let u = row.u.map(f64::from);
        let (z, phi) = (1.0 - 2.0 * u[0], (2.0 * u[1] - 1.0) * PI);
        let across = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
        let ball = u[2].cbrt() * DVec3::new(across * phi.cos(), across * phi.sin(), z);
        let blurred = mirrored(row) + f64::from(fuzz as f32) * ball;
        let height = blurred.dot(exact(row.normal));
        if out.event != SCATTERED || height < 0.0 {
            // What is absorbed lies below the surface, but for what decides it.
            return if (out.event == SCATTERED) == (height > 0.0) { worst } else { worst.max(height.abs()) };
        }
        let off = (exact(out.direction) - blurred.normalize()).length() * blurred.length();
        if off.is_nan() { f64::MAX } else { worst.max(off) }
    })
}

/// Mean of |ω - m|² over the lobe.
fn mean_square(fuzz: f64) -> f64 {
    const STEPS: usize = 200_000;
    let reach = fuzz.min(1.0).asin();
    let mut sums = [0.0; 2];
    for step in 0..STEPS {
        let theta = (step as f64 + 0.5) / STEPS as f64 * reach;
        let ring = metal_density(theta, fuzz) * theta.sin();
        sums[0] += ring;
        sums[1] += ring * 4.0 * (0.5 * theta).sin().powi(2);
    }
    sums[1] / sums[0]
}

/// Relative error of that mean.
fn lobe_error(found: &[Out], row: &In) -> f64 {
    let m = mirrored(row);
    let squares = found.iter().map(|out| (exact(out.direction) - m).length_squared());
    squares.sum::<f64>() / found.len() as f64 / mean_square(f64::from(row.fuzz)) - 1.0
}

/// Largest error of the density of a direction, over its peak, where the sine is within 0.9 of the fuzz: at the lobe's edge
/// the density has no slope that would be finite.
fn density_error(found: &[Out], row: &In) -> f64 {
    let (m, fuzz) = (mirrored(row), f64::from(row.fuzz));
    let peak = metal_density(0.0, fuzz);
    found.iter().fold(0.0, |worst, out| {
        let direction = exact(out.direction);
        let theta = direction.cross(m).length().atan2(direction.dot(m));
        if theta.sin() > 0.9 * fuzz || theta > 1.5 || direction.dot(exact(row.normal)) < 4.0 * U {
            return worst;
        }
        assert_eq!(out.pdf, out.value);
        worst.max((f64::from(out.pdf) - metal_density(theta, fuzz)).abs() / peak)
    })
}

/// The mean of a mirror in a room that shines on all sides, with light sampling: what it reflects is the room.
fn in_a_furnace(fuzz: f64) -> f64 {
    let scene = scene(&format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vertical_fov: 10),
    background: Solid((0, 0, 0)),
    materials: {{\"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)), \"mirror\": Metal(albedo: Rgb(1, 1, 1), fuzz: {fuzz:?})}},
    objects: [
        Sphere(center: (0, 0, 0), radius: 9, material: \"lamp\"),
        Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"mirror\"),
    ],
)"
    ));
    render(&scene, &Request::spp(64).mis()).mean_of_all().value[0]
}

/// The table's cells of fuzz.
pub fn cells() -> Vec<Cell> {
    let mut all = Vec::new();
    let of_sphere = kernel(&[OF_THE_SPHERE]);
    let of_cubes = kernel(&[
        ("material/metal_eval", "dot(across, across)", "(1.0 - c * c)"),
        (
            "material/metal_eval",
            "2.0 * h * (3.0 * c * c + h2)",
            "(c + h) * (c + h) * (c + h) - (c - h) * (c - h) * (c - h)",
        ),
    ]);
    let own = kernel(&[]);
    for fuzz in FUZZES {
        let range = format!("fuzz = {fuzz:e}");
        let cell = |figure, limit, because| Cell::new(&range, figure, limit, because);
        let found = cell(
            "Largest error of a direction, times |m + fuzz b|, with cosines from 1e-4 to 1",
            16.0 * U + (8.0 * U + 2f64.powi(-18)) * fuzz,
            "16 u for two dot products, two of their multiples and a normalize; 8 u for the point b, and 2^-18 of it for exp2 and log2.",
        )
        .achieved(direction_error(fuzz, &[]));
        all.push(match fuzz {
            0.0 => found.planted("fuzz of 1e-5", direction_error_of(0.0, 1e-5, &[])),
            f if f > 1e-6 => found.planted(SPHERE, direction_error(fuzz, &[OF_THE_SPHERE])),
            _ => found,
        });
        let achieved = (in_a_furnace(fuzz) - 1.0).abs();
        // A lobe of 1 reaches the horizon, and loses what its edge does beyond.
        let noise = NOISE * 0.5 * fuzz / (64.0f64 * 256.0).sqrt();
        if fuzz < 1.0 {
            all.push(
                cell(
                    "Relative error of a mirror's radiance in a room that emits everywhere, with light sampling",
                    noise + 16.0 * U,
                    "4.9 standard errors of 16 384 samples with a deviation of at most fuzz/2: a shadow ray hits the lobe with a \
                     probability of fuzz²/4 and contributes at most half; and the roundings of sums and weights.",
                )
                .achieved(achieved),
            );
        }
        if fuzz < 1e-5 {
            // Below, the lobe is not much wider than the steps of f32.
            continue;
        }
        let mut random = Random(75);
        let row = arriving(&mut random, if fuzz < 1.0 { 0.9 } else { 1.0 }, fuzz);
        let [drawn, sphere, cubes] = [&own, &of_sphere, &of_cubes].map(|kernel| kernel.run_with(&[row], DRAWS, &[]));
        // The squares' deviation is less than their mean's 0.8: (ρ² of the ball has a mean of 2/5 and a mean square of 8/35).
        let noise = NOISE * 0.8 / (DRAWS as f64).sqrt();
        all.push(
            cell(
                "Relative error of the lobe's mean square angle, 2^17 draws",
                noise + (8.0 * U / fuzz).powi(2) * 2.5,
                "4.9 standard errors, and the squared rounding of directions of 8 u, relative to the lobe's 2/5 fuzz².",
            )
            .achieved(lobe_error(&drawn, &row).abs())
            .planted(SPHERE, lobe_error(&sphere, &row).abs()),
        );
        let cell = cell(
            "Largest error of the density over its peak, within 0.9 of the lobe",
            34.0 * U / fuzz + 32.0 * U,
            "the sine of the angle to the mirrored ray is off by 16 u, which moves sqrt(fuzz² - sin²) by at most 2.1 times that; \
             and 32 u for the formula.",
        )
        .achieved(density_error(&drawn, &row));
        let known = fuzz < 1e-2;
        all.push(if known { cell.planted(CUBES, density_error(&cubes, &row)) } else { cell });

        // Half of the ball's radius above the surface.
        let row = arriving(&mut random, 0.5 * fuzz, fuzz);
        let below = |kernel: &Kernel| {
            let height = -exact(row.incoming).dot(exact(row.normal)) / f64::from(row.fuzz);
            let share = (2.0 + height) * (1.0 - height).powi(2) / 4.0;
            let found: Vec<Out> = kernel.run_with(&[row], DRAWS, &[]);
            let absorbed = found.iter().filter(|out| out.event != SCATTERED).count();
            (absorbed as f64 / DRAWS as f64 - share).abs()
        };
        all.push(
            Cell::new(
                &range,
                "Error of the absorbed share, at a cosine of half the fuzz, 2^17 draws",
                NOISE * 0.37 / (DRAWS as f64).sqrt() + 0.57 * 8.0 * U / fuzz,
                "4.9 standard errors of a share of 0.16, and the height's rounding of 8 u times the slope of (2 + h)(1 - h)²/4.",
            )
            .achieved(below(&own))
            .planted(SPHERE, below(&of_sphere)),
        );
    }
    all
}
