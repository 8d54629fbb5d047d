//! medium/*: how far light flies, from one event in 1e8 crossings to 1e8 in one, and where it goes from there.

use std::f64::consts::PI;

use glam::DVec3;

use crate::common::kernel::{Expression, Fault, Kernel, Overlay};
use crate::common::render::{Request, diagnostics, render, render_planted, scene};
use crate::common::rows::rows;
use crate::common::stats::{Random, mean_and_variance, sidak, uniform_in_cells};
use crate::common::vectors::{U, decades, exact, rounded, unit};
use crate::table::{Cell, LOG_OF_ONE_MINUS};

/// Standard errors that a mean is off by once in 1e6.
const NOISE: f64 = 4.9;

/// Depths from pairs of random words.
fn depths(replaced: &[Fault<'_>], words: &[[u32; 2]]) -> Vec<f32> {
    Kernel::of(["medium/free_flight", "vec2<u32>", "f32", "optical_depth(given)"], replaced).run(words)
}

/// By the logarithm of 1 - u, of the one word that u has: its 24 digits know no depths below 6e-8 nor beyond 16.6.
const ONE_WORD: &[Fault<'_>] = &[(
    "medium/free_flight",
    "select(-log(complement), series, u < 0.01)",
    "-log(f32(0x1000000u - word.x) * 0x1p-24f)",
)];

/// Two words whose upper 24 bits are w0 and w1; their lower 8 must not matter.
fn words(random: &mut Random, w0: u32, w1: u32) -> [u32; 2] {
    [w0 << 8 | random.bits() as u32 & 255, w1 << 8 | random.bits() as u32 & 255]
}

pub fn depths_of_words() -> Vec<Cell> {
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
    let edges = [0.0, 1e-8, 1e-6, 1e-4, 1e-2, 0.5, 2.0, 10.0, 34.0];
    let worst = |replaced| {
        let mut worst = [0.0f64; 8];
        for (row, tau) in rows.iter().zip(depths(replaced, &rows)) {
            let share = f64::from(row[0] >> 8) / 2f64.powi(24) + f64::from(row[1] >> 8) / 2f64.powi(48);
            let (expected, rest) = (-(-share).ln_1p(), 1.0 - share);
            let series = 4.0 * U * expected;
            let log = U + if rest >= 0.5 { 8.0 * U } else { 6.0 * U * expected };
            // By rounding either may be taken within an ulp of 0.01.
            let bound = if share < 0.01 * (1.0 - 4.0 * U) { series } else { log };
            let at = edges[1..].iter().position(|edge| expected < *edge).expect("below 34");
            let off = (f64::from(tau) - expected).abs() / bound.max(f64::MIN_POSITIVE);
            worst[at] = if off.is_nan() { f64::MAX } else { worst[at].max(off) };
        }
        worst
    };
    let (own, one_word) = (worst(&[]), worst(ONE_WORD));
    (0..8)
        .map(|i| {
            let cell = Cell::new(
                format!("τ = {:e}..{:e}", edges[i], edges[i + 1]),
                "Largest error of a sampled optical depth, over its bound",
                1.0,
                "below 0.01, 4 u of the depth for the series; above, WGSL's bound for the logarithm: 2^-21 up to 0.7, and 6 u of it \
                 beyond; and the rounding of 1 - U.",
            )
            .achieved(own[i]);
            // Around 1 it has as many digits.
            if edges[i] == 0.5 { cell } else { cell.planted(LOG_OF_ONE_MINUS, one_word[i]) }
        })
        .collect()
}

/// The share of depths below each of some limits. To see 1e-8, draws come from a part of all numbers that reaches some way
/// beyond the limit and is small: the lowest for small limits, the highest for large ones.
pub fn shares() -> Vec<Cell> {
    const DRAWS: usize = 1 << 16;
    let share = |replaced: &[Fault<'_>], limit: f64| {
        let mut random = Random(84);
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
        (counted as f64 / (p * DRAWS as f64) - 1.0, ((1.0 - p) / (p * DRAWS as f64)).sqrt())
    };
    let mut all: Vec<Cell> = [
        1e-10, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 0.009_99, 0.0101, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0,
        16.0, 20.0, 25.0,
    ]
    .into_iter()
    .map(|limit| {
        let (error, noise) = share(&[], limit);
        let what = if limit < 0.7 { "below" } else { "above" };
        let cell = Cell::new(
            format!("{what} τ = {limit:e}"),
            "Relative error of the share of light that scatters before τ (below), or not before τ (above)",
            NOISE * noise,
            "4.9 standard errors of 2^16 samples. They come from a part of all 2^48 numbers in which at least a quarter counts.",
        )
        .achieved(error.abs());
        // One word puts all of the 6e-8 that lie below its first step at 0, and knows nothing beyond 16.6.
        let coarse = [1e-9, 1e-8, 3e-8, 20.0, 25.0].contains(&limit);
        if coarse { cell.planted(LOG_OF_ONE_MINUS, share(ONE_WORD, limit).0.abs()) } else { cell }
    })
    .collect();
    // No number lies beyond the last; all the light that should get farther is scattered.
    let farthest = |replaced: &[Fault<'_>]| (-f64::from(depths(replaced, &[[u32::MAX; 2]])[0])).exp();
    all.push(
        Cell::new(
            "τ = 33.3..1e8",
            "Error of the transmittance beyond the largest depth that can be sampled",
            1.01 * 2f64.powi(-48),
            "the last of 2^48 numbers, and WGSL's logarithm.",
        )
        .achieved(farthest(&[]))
        .planted(LOG_OF_ONE_MINUS, farthest(ONE_WORD)),
    );
    all
}

pub fn free_paths() -> Vec<Cell> {
    const DRAWS: usize = 1 << 20;
    let mut random = Random(85);
    let rows: Vec<[u32; 2]> = (0..DRAWS).map(|_| [random.bits() as u32, random.bits() as u32]).collect();
    let tau: Vec<f64> = depths(&[], &rows).into_iter().map(f64::from).collect();
    // Moments of the exponential distribution: 1 and 2, with deviations of 1 and sqrt(20).
    [("mean free path", 1, 1.0, 1.0), ("mean square of the free path", 2, 2.0, 5f64.sqrt())]
        .map(|(what, power, expected, deviation)| {
            let mean = tau.iter().map(|x| x.powi(power)).sum::<f64>() / DRAWS as f64;
            Cell::new(
                what,
                "Relative error of a moment of 2^20 sampled depths",
                NOISE * deviation / (DRAWS as f64).sqrt(),
                "4.9 standard errors; the deviations of τ and τ² are 1 and sqrt(5) times their means.",
            )
            .achieved((mean / expected - 1.0).abs())
        })
        .into()
}

/// A slab of this optical depth straight before the camera, under a sky of radiance 1.
fn slab(depth: f64, albedo: f64, distance: f64, thickness: f64) -> String {
    format!(
        "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0.3, 0.2, {distance:?}), look_at: (0.3, 0.2, 0), vertical_fov: 0.5),
    background: Solid((1, 1, 1)),
    materials: {{}},
    objects: [Medium(boundary: Box(min: (-1, -1, {:?}), max: (1, 1, 0)), density: {:?}, albedo: Rgb({albedo:?}, {albedo:?}, {albedo:?}))],
    render: (max_depth: 1000),
)",
        -thickness,
        depth / thickness
    )
}

/// Slabs that only absorb: what gets through straight. A depth of 1e-8 scatters one path of 1e8: the medium's random
/// numbers are then the lowest 2^-k of all, of which 2^k as many scatter.
pub fn black_slabs() -> Vec<Cell> {
    const SAMPLES: f64 = 1024.0 * 64.0;
    [1e-8, 1e-7, 1e-6, 1e-4, 1e-2, 1.0, 10.0, 1e2, 1e4, 1e6, 1e8]
        .map(|depth: f64| {
            let k = (0.4 / depth).log2().clamp(0.0, 24.0).floor() as i32;
            let lowest = format!("medium == 0u) >> vec4<u32>({k}u, 0u, 0u, 0u)");
            let lowest = Overlay::new(&[("step/flight", "medium == 0u)", &lowest)]);
            let through = |text: &str| render_planted(&scene(text), &Request::spp(64), &lowest).mean_of_all().value[0];
            let expected = 1.0 + 2f64.powi(k) * (-depth).exp_m1();
            Cell::new(
                format!("τ = {depth:e}, k = {k}"),
                "Error of the transmittance of a slab that absorbs, rendered with the lowest 2^-k of all random numbers",
                NOISE * (expected * (1.0 - expected) / SAMPLES).sqrt() + 2f64.powi(k) * (8.0 * U * depth * (-depth).exp() + 2f64.powi(-48)),
                "the transmittance is 1 - 2^k (1 - exp(-τ)); 4.9 standard errors of 65 536 paths, 8 u for the depth, and the last \
                 of 2^48 numbers.",
            )
            .achieved((through(&slab(depth, 0.0, 1.0, 1.0)) - expected).abs())
            .planted("no medium", (through(&slab(depth, 0.0, 1.0, 1.0).replace("min: (-1, -1, -1.0), max: (1, 1, 0)", "min: (5, 5, \
                      -1.0), max: (6, 6, 0)")) - expected).abs())
        })
        .into()
}

/// H(1) of Chandrasekhar's function for isotropic scattering, by its equation 1/H(m) = sqrt(1 - a) + a/2 ∫ x H(x) / (m + x) dx
/// ("Radiative Transfer", 1950, section 38).
fn h_of_one(albedo: f64) -> f64 {
    const STEPS: usize = 2000;
    let x = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    let mut h = vec![1.0; STEPS];
    let at = |h: &[f64], m: f64| {
        let integral: f64 = h.iter().enumerate().map(|(i, h)| x(i) * h / (m + x(i))).sum::<f64>() / STEPS as f64;
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral)
    };
    for _ in 0..40 {
        h = (0..STEPS).map(|i| at(&h, x(i))).collect();
    }
    at(&h, 1.0)
}

/// Thick slabs that scatter to all sides, under a sky that shines from all: 1 - sqrt(1 - a) H(1) straight out of them (the same
/// book, section 38, by what is absorbed), however thick. An event's position has the digits of f32 at the farthest distance R of the
/// slab from the camera: what counts is how many mean free paths the last digit is, s = σ R 2^-24.
pub fn bright_slabs() -> Vec<Cell> {
    const ALBEDO: f64 = 0.8;
    let expected = 1.0 - (1.0 - ALBEDO).sqrt() * h_of_one(ALBEDO);
    // Dark paths are ended, or each would go on for a thousand events.
    let shot = |depth, distance, thickness| {
        render(&scene(&slab(depth, ALBEDO, distance, thickness)), &Request::spp(64).roulette()).mean_of_all()
    };
    let mut all = Vec::new();
    for (distance, thickness) in [(1.0, 1.0), (30.0, 1.0), (1.0, 0.01)] {
        for s in [1e-5, 1e-3, 1e-2, 1e-1] {
            let depth = s / (U * (distance + thickness)) * thickness;
            if depth < 40.0 {
                // Light would get through.
                continue;
            }
            let mean = shot(depth, distance, thickness);
            let said = diagnostics(&scene(&slab(depth, ALBEDO, distance, thickness)));
            assert!(s > 0.05 || said.is_empty(), "{said:?}");
            all.push(
                Cell::new(
                    format!("τ = {depth:.1e} in {thickness} seen from {distance}: s = {s:e}"),
                    "Relative error of the radiance of a thick slab that scatters, rendered",
                    NOISE * mean.variance[0].sqrt() / expected + 3.0 * s,
                    "4.9 standard errors as estimated by the film. The distance, its product and the sum are rounded by u R each: a \
                     position is off by 3 s mean free paths, and the transmitted share changes by as much.",
                )
                .achieved((mean.value[0] / expected - 1.0).abs()),
            );
        }
        // Wrong as the picture is then, a fifth too bright at s = 1.
        let warnings = diagnostics(&scene(&slab(1e8, ALBEDO, distance, thickness)));
        let mean = shot(1e8, distance, thickness);
        all.push(
            Cell::new(format!(
                    "τ = 1e8 in {thickness} seen from {distance}: s = {:.1}",
                    1e8 * U * (distance + thickness) / thickness
                ),
                "Relative error of such a slab if the last digit of a position is many mean free paths; `check` may warn instead",
                NOISE * mean.variance[0].sqrt() / expected + 0.01,
                "4.9 standard errors, and a hundredth, as with a position that f32 resolves.",
            )
            .achieved((mean.value[0] / expected - 1.0).abs())
            .warns(warnings),
        );
    }
    all
}

rows! {
    struct Scattering {
        incoming: [f32; 3], g: f32,
        u: [f32; 2], one_minus_g: f32, padding: f32,
    }

    /// With 1 - cos and 1 + cos.
    struct Scattered {
        direction: [f32; 3], padding: f32,
        from_one: [f32; 2], padding2: [f32; 2],
    }
}

impl Scattering {
    fn new(incoming: DVec3, g: f64, u: [f32; 2]) -> Scattering {
        let one_minus_g = (1.0 - g.abs()) as f32;
        Scattering { incoming: rounded(incoming), g: g as f32, u, one_minus_g, padding: 0.0 }
    }
}

fn phase(replaced: &[Fault<'_>]) -> Kernel {
    Kernel::replacing("test/phase", replaced)
}

const ASYMMETRIES: [f64; 7] = [0.0, 1e-8, 1e-3, 0.5, 0.9, 0.999, 1.0 - 1e-6];

fn asymmetries() -> impl Iterator<Item = f64> {
    ASYMMETRIES.into_iter().flat_map(|g| if g == 0.0 { vec![0.0] } else { vec![g, -g] })
}

fn range(g: f64) -> String {
    match 1.0 - g.abs() {
        less if less < 1e-4 => format!("g = {}(1 - {less:.0e})", if g < 0.0 { "-" } else { "" }),
        _ => format!("g = {g:e}"),
    }
}

const TEXTBOOK: &str = "textbook's inverse";
/// The cosine as in textbooks, which cancels for small g, and where light goes nearly straight on.
const TEXTBOOK_PHASE: Fault<'_> = (
    "medium/phase",
    "select(vec2<f32>(one_minus_cos, one_plus_cos), vec2<f32>(one_plus_cos, one_minus_cos), g < 0.0)",
    "1.0 + sign(g) * vec2<f32>(-1.0, 1.0) * (1.0 + h * h - (1.0 - h * h) * (1.0 - h * h) / (d * d)) / (2.0 * h)",
);

/// 1 - cos and 1 + cos by Henyey and Greenstein, for g >= 0, by the same factors in f64. That they are the inverse of the
/// distribution function is what the chi-square test says.
fn from_one(g: f64, u: f64) -> [f64; 2] {
    let (less, d) = (1.0 - g, 1.0 - g + 2.0 * g * u);
    let back = 2.0 * (less / d).powi(2) * (1.0 - u) * (1.0 + g * u);
    [back, 2.0 * ((1.0 + g) / d).powi(2) * u * (less + g * u)]
}

pub fn cosines() -> Vec<Cell> {
    let last = 1.0 - U as f32;
    let mut random = Random(86);
    let mut all = Vec::new();
    for g in asymmetries() {
        let ends = [0.0, U as f32, 0.25, 0.5, 0.75, last];
        let mut draws: Vec<[f32; 2]> = ends.into_iter().flat_map(|u| ends.map(|across| [u, across])).collect();
        draws.extend((0..2000).map(|i| {
            let small = decades(&mut random, -7.0, 0.0);
            let u = ((if i % 2 == 0 { small } else { 1.0 - small }) / U).floor() as f32 * U as f32;
            [u, (random.bits() >> 40) as f32 * U as f32]
        }));
        let rows: Vec<Scattering> = draws.into_iter().map(|u| Scattering::new(unit(&mut random), g, u)).collect();
        // The largest relative error of 1 - cos and 1 + cos, and that of the direction's cosine and length over its bound.
        let worst = |replaced: &[Fault<'_>]| {
            let mut worst = [0.0f64; 2];
            for (row, out) in rows.iter().zip(phase(replaced).run::<_, Scattered>(&rows)) {
                let mut expected = from_one(g.abs(), f64::from(row.u[0]));
                if g < 0.0 {
                    expected.reverse();
                }
                for (found, expected) in out.from_one.iter().zip(expected) {
                    let error = (f64::from(*found) - expected).abs();
                    let relative = if error == 0.0 { 0.0 } else { error / expected };
                    worst[0] = if relative.is_nan() { f64::MAX } else { worst[0].max(relative) };
                }
                let direction = exact(out.direction);
                let along = direction.dot(exact(row.incoming));
                let cos = if expected[0] < 1.0 { 1.0 - expected[0] } else { expected[1] - 1.0 };
                let sin2 = expected[0] * expected[1];
                let bound = 16.0 * U + 26.0 * U + 8.0 * U * sin2;
                let off = ((direction.length() - 1.0).abs() / (8.0 * U)).max((along - cos).abs() / bound);
                worst[1] = if off.is_nan() { f64::MAX } else { worst[1].max(off) };
            }
            worst
        };
        let (own, textbook) = (worst(&[]), worst(&[TEXTBOOK_PHASE]));
        let cell = Cell::new(
            range(g),
            "Largest relative error of 1 - cos and 1 + cos",
            26.0 * U,
            "|g| and 1 - |g| are rounded; D and 1 - h + h u are off by 3 u each, and 1 + h by 2 u; squares double these errors, and \
             quotients add 5 u each, products 4 u.",
        )
        .achieved(own[0]);
        all.push(if g == 0.0 { cell } else { cell.planted(TEXTBOOK, textbook[0]) });
        let cell = Cell::new(
            range(g),
            "Largest error of the new direction's cosine and length, over its bound",
            1.0,
            "26 u for the cosine, 16 u for the basis, the sum and normalize, 8 u for the point on the circle; 8 u for the length.",
        )
        .achieved(own[1]);
        all.push(if g.abs() == 1e-8 { cell.planted(TEXTBOOK, textbook[1]) } else { cell });
    }
    all
}

pub fn directions() -> Vec<Cell> {
    const DRAWS: usize = 1 << 18;
    let kernel = phase(&[]);
    let mut random = Random(87);
    let tests = 2 * asymmetries().count();
    let mut all = Vec::new();
    for g in asymmetries().filter(|g| g.abs() < 0.9999) {
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
            let points = draws.iter().map(|&(less, angle)| {
                let root = ((1.0 - h).powi(2) + 2.0 * h * less).sqrt();
                let share = (1.0 - h) * (2.0 - less) / (root * (1.0 + h + root));
                (share, 0.5 + angle / std::f64::consts::TAU)
            });
            uniform_in_cells((61, 7), points)
        };
        // Off by 0.02, or by 5 % of 1 - |g|.
        let other = if g.abs() < 0.6 { g + 0.02 } else { 0.95 * g + 0.05 * g.signum() };
        let digits = |p: f64| -p.max(1e-300).log10();
        all.push(
            Cell::new(
                range(g),
                "Digits of the p-value of 2^18 directions, by a chi-square test of 61 x 7 cells",
                digits(sidak(1e-6, tests)),
                "a false alarm in 1e6 over all cells.",
            )
            .achieved(digits(p_for(g)))
            .planted("g off by 0.02, or by 5 % of 1 - |g|", digits(p_for(other))),
        );
        let cosines: Vec<f64> = draws.iter().map(|draw| 1.0 - draw.0).collect();
        let (mean, _) = mean_and_variance(&cosines);
        all.push(
            Cell::new(
                range(g),
                "Error of the mean cosine of 2^18 directions",
                NOISE * ((1.0 - g * g) / 3.0 / DRAWS as f64).sqrt() + 16.0 * U,
                "the mean cosine is g: 4.9 standard errors of cosines with the variance (1 - g²)/3.",
            )
            .achieved((mean - g).abs()),
        );
    }
    all
}

rows! {
    struct Pair {
        incoming: [f32; 3], g: f32,
        direction: [f32; 3], one_minus_g: f32,
    }
}

const PHASE_PDF: Expression<'_> =
    ["medium/phase_pdf", "array<vec4<f32>, 2>", "f32", "phase_pdf(given[0].xyz, given[1].xyz, given[0].w, given[1].w)"];

/// The density that light sampling weighs with: against f64, and its integral over the sphere.
pub fn densities() -> Vec<Cell> {
    const STEPS: usize = 4096;
    const PLANTED: Fault<'_> = (
        "medium/phase_pdf",
        "one_minus_g * one_minus_g + h * dot(apart, apart)",
        "1.0 + g * g - 2.0 * g * dot(incoming, direction)",
    );
    let mut random = Random(88);
    let mut all = Vec::new();
    let density = |g: f64, less: f64| {
        let h = g.abs();
        let d = (1.0 - h).powi(2) + 2.0 * h * less;
        (1.0 - h * h) / (4.0 * PI * d * d.sqrt())
    };
    for g in asymmetries() {
        // Directions that have the same share of the density each; where it is exact, and as f32 has them.
        let rows: Vec<(Pair, f64)> = (0..STEPS)
            .map(|i| {
                let from_one = from_one(g.abs(), (i as f64 + 0.5) / STEPS as f64);
                let less = from_one[0];
                let sin = (from_one[0] * from_one[1]).sqrt();
                let axis = unit(&mut random);
                let across = axis.cross(unit(&mut random)).normalize();
                let incoming = rounded(axis);
                let direction = rounded(g.signum() * ((1.0 - less) * axis + sin * across));
                (Pair { incoming, g: g as f32, direction, one_minus_g: (1.0 - g.abs()) as f32 }, density(g, less))
            })
            .collect();
        let given: Vec<Pair> = rows.iter().map(|row| row.0).collect();
        // The largest relative error for the very directions given, and that of the integral.
        let judge = |replaced: &[Fault<'_>]| {
            let found: Vec<f32> = Kernel::of(PHASE_PDF, replaced).run(&given);
            let (mut worst, mut sum) = (0.0f64, 0.0);
            for ((row, exactly), pdf) in rows.iter().zip(&found) {
                let (a, b) = (exact(row.incoming).normalize(), exact(row.direction).normalize());
                let expected = density(g, 0.5 * (b - g.signum() * a).length_squared());
                let error = (f64::from(*pdf) / expected - 1.0).abs();
                worst = if error.is_nan() { f64::MAX } else { worst.max(error) };
                sum += f64::from(*pdf) / exactly;
            }
            [worst, (sum / STEPS as f64 - 1.0).abs()]
        };
        let (own, textbook) = (judge(&[]), judge(&[PLANTED]));
        let less = 1.0 - g.abs();
        let planted = |cell: Cell, i: usize| match less < 0.01 {
            true => cell.planted("denominator by the cosine", textbook[i]),
            false => cell,
        };
        all.push(planted(
            Cell::new(
                range(g),
                "Largest relative error of the density of a direction",
                32.0 * U + 1.5 * (4.0 * U / less).powi(2),
                "32 u for the denominator (off by 8 u, to the power of 3/2) and the quotient. The lengths of the vectors are off by \
                 2 u each, which counts squared and divided by (1 - |g|)².",
            )
            .achieved(own[0]),
            0,
        ));
        if less > 1e-4 {
            all.push(planted(
                Cell::new(
                    range(g),
                    "Error of the density's integral over the sphere",
                    32.0 * U + 3.0 * 4.0 * U / less,
                    "as above, and the rounding of directions by 4 u, divided by 1 - |g| where the density is steepest.",
                )
                .achieved(own[1]),
                1,
            ));
        }
    }
    all
}
