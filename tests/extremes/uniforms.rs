//! Random numbers at the ends of their range, 0 and 1 - 2^-24, in every dimension: nothing that is drawn from them
//! leaves its range.

use gpu_rt::data::{RUN_LENGTH, Sampler, Sphere};

use crate::common::kernel::{Fault, Kernel, Overlay};
use crate::common::light_kernel::{self, SHARES, SPHERE, spheres};
use crate::common::render::{Change, Request, render_with, scene};
use crate::common::rows::{WORDS, Words, rows};
use crate::common::vectors::{U, exact};
use crate::table::Cell;

const LAST: f32 = 1.0 - U as f32;

/// The ends, and some between.
const ENDS: [f32; 4] = [0.0, U as f32, 0.5, LAST];
/// What would come out if all 32 bits were rounded to a float.
const WITH_ONE: [f32; 4] = [0.0, U as f32, 0.5, 1.0];
const ONE: &str = "uniforms that reach 1";

/// The table's cells of uniforms.
pub fn cells() -> Vec<Cell> {
    let mut all = vec![words()];
    all.extend(forced());
    all.push(spheres_as_lights());
    all.push(picks());
    all
}

fn cell(range: impl Into<String>, figure: &'static str) -> Cell {
    Cell::new(range, figure, 0.0, "none.")
}

const ANSWERS: &str =
    "Results that are not finite or out of range, with 0, 2^-24, 1/2 and 1 - 2^-24 in every dimension";

fn words() -> Cell {
    // Every word within 1024 of the ends of the range and of each power of two.
    let mut words: Vec<u32> = (0..1024).flat_map(|i| [i, u32::MAX - i]).collect();
    for power in 10..32 {
        words.extend((0..1024).flat_map(|i| [(1u32 << power).wrapping_add(i), (1u32 << power).wrapping_sub(i + 1)]));
    }
    let keys: Vec<[u32; 4]> = words.iter().map(|&word| [word; 4]).collect();
    let out_of_range = |replaced: &[Fault<'_>]| {
        let found = Kernel::of(WORDS, replaced).run::<_, Words>(&keys);
        found.iter().flat_map(|out| out.direct).filter(|u| !(0.0..1.0).contains(u)).count() as f64
    };
    let rounded = ("lib/rng", "(bits >> vec4<u32>(8u)) * 0x1p-24f", "(bits) * 0x1p-32f");
    cell("words of 32 bits", "Numbers outside [0, 1), from words within 1024 of each power of two")
        .achieved(out_of_range(&[]))
        .planted("all 32 bits rounded to a float", out_of_range(&[rounded]))
}

/// The blocks of shaders/data/dimension.wgsl by what their four numbers are for.
const BLOCKS: [&str; 5] = [
    "camera: x, y in the pixel; lens, lens",
    "scatter: direction",
    "light: which, where, where, which",
    "medium: free flight",
    "roulette",
];
/// One of four numbers, or all; each at either end.
const CODES: u32 = 10;

/// The shaders, with a sampler some of whose numbers the sample's run decides: run n forces the code n.
fn forced_sampler(module: &str) -> Overlay {
    Overlay::new(&[]).rewritten(module, |own| {
        let free = own.replace("fn random_words(", "fn free_words(");
        format!(
            "{free}
fn random_words(pixel: u32, sample: u32, dimension: u32, seed: u32) -> vec4<u32> {{
    let code = sample / {RUN_LENGTH}u;
    let block = select((dimension - 1u) % 4u + 1u, 0u, dimension == 0u);
    let which = (code % {CODES}u) / 2u;
    let word = select(0u, 0xffffffffu, code % 2u == 1u);
    let here = vec4<bool>(block == code / {CODES}u);
    let forced = here & ((vec4<u32>(0u, 1u, 2u, 3u) == vec4<u32>(which)) | vec4<bool>(which == 4u));
    return select(free_words(pixel, sample, dimension, seed), vec4<u32>(word), forced);
}}
"
        )
    })
}

/// A room with something of everything, whose brightest light is 1.
const EVERYTHING: &str = "Scene(
    image: (width: 8, height: 8),
    camera: (look_from: (0, 0, 3.4), look_at: (0, 0, 0), vertical_fov: 40, aperture: 0.1, focus_distance: 3),
    background: Gradient(bottom: (0.1, 0.1, 0.1), top: (0.5, 0.5, 0.5)),
    materials: {
        \"red\": Lambertian(albedo: Rgb(0.6, 0.1, 0.1)),
        \"noise\": Lambertian(albedo: Noise(scale: 3)),
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
        \"metal\": Metal(albedo: Rgb(0.8, 0.8, 0.9), fuzz: 0.3),
        \"blurred\": Metal(albedo: Rgb(0.8, 0.8, 0.9), fuzz: 1),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)),
        \"shade\": DiffuseLight(emit: Rgb(1, 0.5, 0.1), two_sided: false),
    },
    objects: [
        Quad(corner: (-1, -1, -1), u: (0, 0, 2), v: (0, 2, 0), material: \"red\"),
        Quad(corner: (1, -1, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"noise\"),
        Quad(corner: (-1, -1, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"white\"),
        Quad(corner: (-1, -1, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"white\"),
        Quad(corner: (-1, 1, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"shade\"),
        Sphere(center: (-0.6, 0.6, 0), radius: 0.2, material: \"lamp\"),
        Box(min: (0.4, 0.4, -0.5), max: (0.6, 0.7, 0), material: \"lamp\"),
        Transformed(by: [Scale(0.3), Translate((0.2, -0.9, 0.5))], object: Mesh(path: \"slotted.ply\", material: \"lamp\")),
        Sphere(center: (-0.4, -0.5, 0), radius: 0.5, material: \"glass\"),
        Sphere(center: (0.5, -0.6, 0.2), radius: 0.4, material: \"metal\"),
        Sphere(center: (0.1, 0.1, -0.7), radius: 0.3, material: \"blurred\"),
        Medium(boundary: Box(min: (-0.8, -1, -0.8), max: (0.8, 0.4, 0.6)), density: 1.5, albedo: Rgb(0.9, 0.8, 0.6), anisotropy: 0.5),
        Medium(boundary: Sphere(center: (0, 0, 0), radius: 0.6), density: 2, albedo: Rgb(0.5, 0.8, 0.9), anisotropy: -0.999),
    ],
    render: (max_depth: 10),
)";

/// Whole renders with one number of one block at an end, or all of it, wherever that block is drawn.
fn forced() -> Vec<Cell> {
    let scene = scene(EVERYTHING);
    let mut all = Vec::new();
    for (sampler, name, module) in
        [(Sampler::Independent, "independent", "sampler/independent"), (Sampler::Sobol, "sobol", "sampler/sobol")]
    {
        let request = Request::default().mis().roulette().with(|options| options.sampler = sampler);
        let runs = |block: u32| block * CODES * RUN_LENGTH..(block + 1) * CODES * RUN_LENGTH;
        let ranges: Vec<_> = (0..5).map(runs).collect();
        // By codes, so that a pixel's value is the mean of one code's samples.
        let codes =
            ranges.iter().flat_map(|range| range.clone().step_by(8)).map(|first| (0, first..first + RUN_LENGTH));
        let (library, mut shots) = (forced_sampler(module), Vec::new());
        let change = Change { library: Some(&library), ..Change::default() };
        render_with(&scene, &request, codes, &change, |shot| shots.push(shot));
        for (block, shots) in BLOCKS.iter().zip(shots.chunks(CODES as usize)) {
            let rejected: u64 = shots.iter().map(|shot| shot.film.totals.rejected.total()).sum();
            let paths: u64 = shots.iter().map(|shot| shot.film.totals.paths).sum();
            assert_eq!(paths, 8 * 8 * u64::from(CODES * RUN_LENGTH));
            all.push(
                cell(
                    format!("{name}, {block}"),
                    "Of 5120 samples of a room with every feature, those that are rejected, with each random number of the block at \
                     0 and 1 - 2^-24, and with all of them",
                )
                .achieved(rejected as f64),
            );
            let values = shots.iter().flat_map(|shot| shot.picture.rgb.iter().flatten());
            let brightest = values.fold(0.0f64, |most, &v| most.max(f64::from(v)));
            // A sampled light counts w f cos / p_l = p_l p_k / (p_l² + p_k²) at most, a half, at each of 10 events.
            all.push(
                Cell::new(
                    format!("{name}, {block}"),
                    "Brightest pixel of those renders, relative to the brightest light",
                    6.0,
                    "the light that a path hits, plus at most half of a light for each of 10 events because of the MIS weights.",
                )
                .achieved(brightest),
            );
        }
    }
    all
}

fn is_unit(direction: [f32; 3]) -> bool {
    (exact(direction).length() - 1.0).abs() < 8.0 * U
}

/// Answers of a sphere as a light that are no unit direction, or whose density or its square is no number, or not the same when told
/// again.
fn spheres_as_lights() -> Cell {
    let mut shares = SHARES.to_vec();
    shares.extend([1.0, 1.0 + 1e-7, 1.5, 1e3, 1e8, 1e-9, 1e-12, 1e-20]);
    let (mut rows, mut shapes) = spheres(&shares, 660);
    let row = |from, shape| light_kernel::In { from, shape, ..light_kernel::In::default() };
    // At the centre itself, and seen along each axis.
    rows.push(row(shapes[3].center, 3));
    for i in 0..6 {
        let mut from = [0.0; 3];
        from[i % 3] = if i < 3 { 2.0 } else { -2.0 };
        rows.push(row(from, shapes.len() as u32));
    }
    shapes.push(Sphere { radius: 1.0, ..Sphere::default() });
    let wrong = |out: &light_kernel::Out| {
        let finite = out.pdf.is_finite() && out.pdf >= 0.0 && (out.pdf * out.pdf).is_finite();
        !(is_unit(out.direction) && finite && out.pdf == out.again)
    };
    let wrong = light_kernel::at_ends(SPHERE, &rows, &shapes).iter().filter(|(_, out)| wrong(out)).count();
    cell("sphere light, r/D from 1e-20 to 1e8", ANSWERS).achieved(wrong as f64)
}

rows! {
    struct Pick { u: f32, count: u32 }

    struct Picked { index: u32, rest: f32 }
}

fn picks() -> Cell {
    let picked = "alias_pick(bitcast<f32>(given.x), given.y)";
    let both = format!("vec2<u32>({picked}.index, bitcast<u32>({picked}.rest))");
    let kernel = Kernel::of(["light/alias", "vec2<u32>", "vec2<u32>", &both], &[]);
    let wrong = |ends: [f32; 4]| {
        let counts = [1, 2, 3, 7, 4096, 100_003, (1 << 24) - 1, 1 << 24];
        let rows: Vec<Pick> = counts.iter().flat_map(|&count| ends.map(|u| Pick { u, count })).collect();
        let found = kernel.run::<_, Picked>(&rows);
        let bad = |(row, out): &(&Pick, &Picked)| out.index >= row.count || !(0.0..1.0).contains(&out.rest);
        rows.iter().zip(&found).filter(bad).count() as f64
    };
    cell("choice of a light, tables of 1 to 2^24", ANSWERS).achieved(wrong(ENDS)).planted(ONE, wrong(WITH_ONE))
}
