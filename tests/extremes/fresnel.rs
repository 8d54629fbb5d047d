//! lib/fresnel: reflectance and refraction as the index nears 1, at total reflection's edge and at grazing angles.

use glam::DVec3;

use crate::common::kernel::Kernel;
use crate::common::oracles::{INCIDENT_SCHLICK, fresnel, fresnel_of};
use crate::common::rows::rows;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};
use crate::table::{Cell, SCHLICK};

/// Reflectance and refracted ray by the formulas as they stand in books.
const TEXTBOOK: &str = "textbook's Fresnel";

rows! {
    struct In {
        incoming: [f32; 3], eta: f32,
        normal: [f32; 3], contrast: f32,
    }
}

impl In {
    /// A ray towards a boundary across z.
    fn new(incoming: DVec3, eta: f64) -> In {
        let contrast = ((eta - 1.0) * (eta + 1.0)) as f32;
        In { incoming: rounded(incoming), eta: eta as f32, normal: [0.0, 0.0, 1.0], contrast }
    }
}

rows! {
    struct Out {
        refracted: [f32; 3], cos_incident: f32,
        reflectance: f32, cos_transmitted: f32, padding: [u32; 2],
    }
}

/// How far the results may be off: what a change of eta^2 - 1 by 2 u and of the squared cosine by 4 u does to them, and
/// relatively some thirty roundings, with the 2.5 ulps of WGSL's quotients and roots in the formulas' squares.
fn allowed(c: f64, eta: f64) -> (f64, f64) {
    let m = (eta - 1.0) * (eta + 1.0);
    let (reflectance, transmitted) = fresnel(c, eta);
    let (mut of_r, mut of_t) = (0.0f64, 0.0f64);
    for sign in [1.0, -1.0] {
        let (r, t) = fresnel_of(c, eta, m + c * c + sign * (2.0 * U * m.abs() + 4.0 * U * c * c));
        of_r = of_r.max((r - reflectance).abs());
        of_t = of_t.max((t - transmitted).abs());
    }
    (of_r + 32.0 * U * reflectance, of_t + 8.0 * U * transmitted)
}

/// The cosine below which all is reflected; 0 where nothing is.
fn critical(eta: f64) -> f64 {
    ((1.0 - eta) * (1.0 + eta)).max(0.0).sqrt()
}

/// Rays in random planes at cosines from 1e-4 to 1, and on both sides of total reflection.
fn rows(random: &mut Random, etas: &[f64]) -> Vec<(f64, In)> {
    let mut all = Vec::new();
    for &eta in etas {
        for i in 0..500 {
            let cos = match i % 3 {
                0 => decades(random, -4.0, 0.0),
                1 => random.uniform(),
                _ => {
                    let side = 1.0 - 2.0 * (i % 2) as f64;
                    (critical(eta) * (1.0 + decades(random, -6.0, -1.0) * side)).clamp(1e-4, 1.0)
                }
            };
            let sin = (1.0 - cos * cos).sqrt();
            let phi = std::f64::consts::TAU * random.uniform();
            all.push((eta, In::new(DVec3::new(sin * phi.cos(), sin * phi.sin(), -cos), eta)));
        }
    }
    all
}

/// What was found, each in units of what is allowed.
#[derive(Debug, Default)]
struct Verdict {
    reflectance: f64,
    cos: f64,
    sum: f64,
    snell: f64,
    direction: f64,
    /// Largest relative error of the reflectance as it is.
    relative: f64,
}

fn judge(kernel: &Kernel, rows: &[(f64, In)]) -> Verdict {
    let given: Vec<In> = rows.iter().map(|(_, row)| *row).collect();
    let mut found = Verdict::default();
    for ((eta, row), out) in rows.iter().zip(kernel.run::<_, Out>(&given)) {
        let c = f64::from(out.cos_incident);
        let (reflectance, transmitted) = fresnel(c, *eta);
        let (of_r, of_t) = allowed(c, *eta);
        let (r, t) = (f64::from(out.reflectance), f64::from(out.cos_transmitted));
        let error = (r - reflectance).abs();
        found.reflectance = found.reflectance.max(error / of_r);
        found.relative = found.relative.max(error / reflectance);
        if t == 0.0 || of_t == 0.0 {
            // All is reflected, or said to be: `edge` says whether that is right.
            continue;
        }
        found.cos = found.cos.max((t - transmitted).abs() / of_t);
        // What goes through, from the transmitted cosine that the shader gives: the amplitudes' squares times the ratio
        // of the beams' widths and indices.
        let through = eta * t / c * 0.5 * ((2.0 * c / (c + eta * t)).powi(2) + (2.0 * c / (eta * c + t)).powi(2));
        let of_through = of_r + through * of_t / t;
        found.sum = found.sum.max((r + through - 1.0).abs() / of_through);
        // The refracted ray: its tangent over the incoming one's is 1 / eta, to the roundings of a sum of three products
        // and of normalize, and the incoming vector's own length.
        let (incoming, refracted, n) = (exact(row.incoming), exact(out.refracted), exact(row.normal));
        let across = |v: DVec3| v - v.dot(n) * n;
        let residual = (across(refracted) * *eta - across(incoming)).length();
        found.snell = found.snell.max(residual / (eta.max(1.0) * (of_t + 8.0 * U)));
        let expected = across(incoming) / eta - transmitted * n;
        found.direction = found.direction.max((refracted - expected).length() / (of_t + 8.0 * U));
        assert!((refracted.length() - 1.0).abs() <= 4.0 * U, "{row:?} {out:?}");
    }
    found
}

/// Indices by how far they are from 1, with what the range is called: entering what is denser.
fn entering() -> Vec<(String, Vec<f64>)> {
    let mut all: Vec<_> = (-7..=-1)
        .map(|exponent| {
            let etas = [1.0, 2.0, 5.0, 9.0].map(|digit| 1.0 + digit * 10f64.powi(exponent)).to_vec();
            (format!("1 + 1e{exponent}..9e{exponent}"), etas)
        })
        .collect();
    all.push(("2..4".to_string(), vec![2.0, 2.4, 3.0, 4.0]));
    all
}

/// How far from the edge of total reflection, as a share of the squared cosine there, a ray is that was decided wrongly.
fn edge(kernel: &Kernel, etas: &[f64]) -> f64 {
    let mut rows = Vec::new();
    for &eta in etas {
        let at = (critical(eta) as f32).to_bits();
        // All cosines next to the edge, and more farther away.
        for step in (0..64).chain((6..20).map(|power| 1u32 << power)) {
            for bits in [at + step, at - step] {
                let cos = f64::from(f32::from_bits(bits));
                rows.push((eta, In::new(DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, -cos), eta)));
            }
        }
    }
    let given: Vec<In> = rows.iter().map(|(_, row)| *row).collect();
    let found = kernel.run::<_, Out>(&given);
    rows.iter().zip(found).fold(0.0, |worst, ((eta, _), out)| {
        let beyond = f64::from(out.cos_incident).powi(2) / critical(*eta).powi(2) - 1.0;
        // A cosine of 0 is the edge itself.
        let all_reflected = out.reflectance == 1.0 && out.cos_transmitted == 0.0;
        if (beyond < 0.0) == all_reflected { worst } else { worst.max(beyond.abs()) }
    })
}

/// Reflectance and bent rays at an index of exactly 1.
fn at_one(kernel: &Kernel) -> f64 {
    let mut random = Random(54);
    let rows: Vec<In> = (0..1000)
        .map(|i| {
            // The last along the boundary, where every other index reflects all.
            let direction = if i == 999 { DVec3::X } else { unit(&mut random) };
            In::new(-direction.abs(), 1.0)
        })
        .collect();
    kernel.run::<_, Out>(&rows).iter().fold(0.0, |worst, out| {
        let bent = (f64::from(out.cos_transmitted) - f64::from(out.cos_incident)).abs();
        worst.max(f64::from(out.reflectance)).max(bent)
    })
}

/// The table's cells of indices.
pub fn cells() -> Vec<Cell> {
    // The cosine with the normal, as the shader computes it, the boundary there, and the refracted ray.
    let cosine = "clamp(-dot(given[0].xyz, given[1].xyz), 0.0, 1.0)";
    let boundary = format!("fresnel({cosine}, given[0].w, given[1].w)");
    let ray = format!("refract_by(given[0].xyz, given[1].xyz, {cosine}, given[0].w, {boundary}.cos_transmitted)");
    let answer = format!(
        "array(vec4({ray}, {cosine}), vec4({boundary}.reflectance, {boundary}.cos_transmitted, vec2<f32>(0.0)))"
    );
    let control =
        |replaced: &[_]| Kernel::of(["lib/fresnel", "array<vec4<f32>, 2>", "array<vec4<f32>, 2>", &answer], replaced);
    let own = control(&[]);
    let textbook = control(&[
        ("lib/fresnel", "contrast + c * c;", "eta * eta * (1.0 - (1.0 - c * c) / (eta * eta));"),
        ("lib/fresnel", "contrast / ((c + g) * (c + g))", "(c - g) / (c + g)"),
        (
            "lib/refraction",
            "return normalize(incoming / eta + (cos_incident / eta - cos_transmitted) * normal);",
            "let across = (incoming + cos_incident * normal) / eta;
            return across - sqrt(abs(1.0 - dot(across, across))) * normal;",
        ),
    ]);
    let schlick = control(&INCIDENT_SCHLICK);
    let mut all = vec![
        Cell::new(
            "η = 1",
            "Reflectance, and change of the cosine, at an index of 1",
            0.0,
            "a body with the index of its surroundings is invisible.",
        )
        .achieved(at_one(&own))
        .planted(SCHLICK, at_one(&schlick)),
    ];
    for leaving in [false, true] {
        for (range, etas) in entering() {
            let etas: Vec<f64> = etas.iter().map(|eta| if leaving { 1.0 / eta } else { *eta }).collect();
            let range = if leaving { format!("η = 1/({range})") } else { format!("η = {range}") };
            let near = etas.iter().all(|eta| (eta - 1.0).abs() < 1e-3);
            let rows = rows(&mut Random(53), &etas);
            let [found, of_textbook, of_schlick] = [&own, &textbook, &schlick].map(|kernel| judge(kernel, &rows));
            let cell = |figure, limit, because, get: &dyn Fn(&Verdict) -> f64| {
                Cell::new(&range, figure, limit, because).achieved(get(&found))
            };
            // The function by the textbook, without digits near 1.
            let by_textbook = |cell: Cell, get: &dyn Fn(&Verdict) -> f64| match near {
                true => cell.planted(TEXTBOOK, get(&of_textbook)),
                false => cell,
            };
            let cell_of_bound = cell(
                "Largest error of the reflectance over its bound, cosines from 1e-4 and on both sides of total reflection",
                1.0,
                "the bound is the effect of an error of 2 u in η² - 1 and of 4 u in the squared cosine, plus 32 u of the \
                 reflectance (`allowed`).",
                &|v| v.reflectance,
            );
            all.push(by_textbook(cell_of_bound.planted(SCHLICK, of_schlick.reflectance), &|v| v.reflectance));
            if !leaving {
                let cell = cell(
                    "Largest relative error of the reflectance, entering",
                    82.0 * U,
                    "(c + g)⁴ is off by 28 u, the squared quotient by 10 u, 1 + q² by 40 u, and there are four more roundings.",
                    &|v| v.relative,
                );
                all.push(by_textbook(cell.planted(SCHLICK, of_schlick.relative), &|v| v.relative));
            }
            all.push(
                cell(
                    "Largest |R + T - 1| over its bound",
                    1.0,
                    "T is computed from the shader's own transmitted cosine; the bound is that of R plus the effect of the cosine's \
                     bound on T.",
                    &|v| v.sum,
                )
                .planted(SCHLICK, of_schlick.sum),
            );
            let cell = cell(
                "Largest residual of Snell's law, η sin θ' - sin θ as vectors, or error of the refracted ray or its cosine, over \
                 its bound",
                1.0,
                "the bound of the transmitted cosine is the effect of an error of 2 u in η² - 1 and 4 u in c², plus 8 u of the \
                 cosine; and 8 u for a sum of three products and `normalize`.",
                &|v| v.snell.max(v.direction).max(v.cos),
            );
            all.push(by_textbook(cell, &|v| v.snell.max(v.direction).max(v.cos)));
            if leaving {
                let cell = Cell::new(
                    &range,
                    "Distance from the edge of total reflection, as a share of the squared cosine there, at which a ray was decided \
                     wrongly",
                    3.0 * U,
                    "η² - 1 and c² are off by u each, and their sum has the sign of the exact sum.",
                )
                .achieved(edge(&own, &etas));
                // From 2 on nothing cancels in it.
                let far = etas.iter().all(|eta| *eta <= 0.5);
                all.push(if far { cell } else { cell.planted(TEXTBOOK, edge(&textbook, &etas)) });
            }
        }
    }
    all
}
