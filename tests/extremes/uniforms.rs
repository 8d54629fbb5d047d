//! Random numbers at the ends of their range, 0 and 1 - 2^-24, in every dimension: nothing that is drawn from them
//! leaves its range.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use gpu_rt::data::{Cuboid, Material, Quad, RUN_LENGTH, Sampler, Sphere};
use gpu_rt::flatten::flatten;

use crate::common::kernel::{Kernel, Overlay, Setup};
use crate::common::light_kernel::{self, CUBOID, Kind, QUAD, SHARES, SPHERE, TRIANGLE, Triangle, spheres};
use crate::common::render::{Ask, render_linked, scene};
use crate::common::rows::{Answer, CameraRay, Maps, Met, OnFilm, Words, glass};
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};
use crate::media::{ASYMMETRIES, Scattered, Scattering, phase};
use crate::table::{Cell, Row};

const LAST: f32 = 1.0 - U as f32;

/// The ends, and some between.
const ENDS: [f32; 4] = [0.0, U as f32, 0.5, LAST];
/// What would come out if all 32 bits were rounded to a float.
const WITH_ONE: [f32; 4] = [0.0, U as f32, 0.5, 1.0];
const ONE: &str = "uniforms that reach 1";

/// As shaders/data/material.wgsl has them.
const SCATTERED: u32 = 0;
const ABSORBED: u32 = 1;

/// The table's cells of uniforms.
pub fn cells() -> Vec<Cell> {
    let mut all = vec![words()];
    all.extend(forced());
    all.extend(materials());
    all.extend(lights());
    all.push(picks());
    all.push(phases());
    all.push(flights());
    all.extend(maps());
    all.push(camera());
    all
}

/// All that four numbers from a list can be.
fn fours(ends: [f32; 4]) -> impl Iterator<Item = [f32; 4]> {
    (0..256).map(move |i| [i & 3, i >> 2 & 3, i >> 4 & 3, i >> 6].map(|at| ends[at]))
}

fn cell(range: impl Into<String>, figure: &'static str) -> Cell {
    Cell::new(Row::Uniforms, range, figure, 0.0, "none.")
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
    let out_of_range = |replaced: &[(&str, &str)]| {
        let found = Kernel::with("test/rng", &Setup { replaced, ..Setup::default() }).run::<_, Words>(&keys);
        found.iter().flat_map(|out| out.direct).filter(|u| !(0.0..1.0).contains(u)).count() as f64
    };
    cell("words of 32 bits", "Numbers outside [0, 1), from words within 1024 of each power of two")
        .achieved(out_of_range(&[]))
        .planted("all 32 bits rounded to a float", out_of_range(&[("lib/rng", "test/control/rng_weak")]))
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
        let ask = Ask::default().mis().roulette().with(|options| options.sampler = sampler);
        let runs = |block: u32| block * CODES * RUN_LENGTH..(block + 1) * CODES * RUN_LENGTH;
        let ranges: Vec<_> = (0..5).map(runs).collect();
        // By codes, so that a pixel's value is the mean of one code's samples.
        let codes: Vec<_> =
            ranges.iter().flat_map(|range| range.clone().step_by(8)).map(|first| first..first + RUN_LENGTH).collect();
        let shots = render_linked(&scene, &ask, &codes, &forced_sampler(module));
        for (block, shots) in BLOCKS.iter().zip(shots.chunks(CODES as usize)) {
            let rejected: u64 = shots.iter().map(|shot| shot.film.totals().rejected.total()).sum();
            let paths: u64 = shots.iter().map(|shot| shot.film.totals().paths).sum();
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
                    Row::Uniforms,
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

fn materials() -> Vec<Cell> {
    let metal = |fuzz: f32| Material { parameter: fuzz, ..Material::default() };
    let kinds: [(&'static str, Vec<Material>); 3] = [
        ("lambertian", vec![Material::default()]),
        ("metal", [0.0, 1e-7, 0.5, 1.0].map(metal).to_vec()),
        ("dielectric", [1.0, 1.5, 1.0 / 1.5, 1.0 + 1e-6, 1.0 - 1e-6, 4.0].map(glass).to_vec()),
    ];
    kinds
        .map(|(name, materials)| {
            let values = [("material", name), ("times", "1"), ("keyed", "false")];
            let kernel = Kernel::with("test/scatter", &Setup { values: &values, ..Setup::default() });
            let wrong = |ends| {
                let mut random = Random(72);
                let mut rows = Vec::new();
                for i in 0..12 * materials.len() {
                    let normal = if i % 2 == 0 { unit(&mut random) } else { -DVec3::Z + 1e-3 * unit(&mut random) };
                    let normal = normal.normalize();
                    let across = normal.cross(unit(&mut random)).normalize();
                    let cos = if i % 3 == 0 { 1.0 } else { decades(&mut random, -4.0, 0.0) };
                    let incoming = ((1.0 - cos * cos).sqrt() * across - cos * normal).normalize();
                    rows.extend(fours(ends).map(|u| Met {
                        incoming: rounded(incoming),
                        normal: rounded(normal),
                        front: (i as u32 / 2) & 1,
                        colour: [1.0; 3],
                        u,
                        material: materials[i % materials.len()],
                        ..Met::default()
                    }));
                }
                let found = kernel.run::<_, Answer>(&rows);
                rows.iter().zip(found).filter(|(row, out)| !is_right(name, row, out)).count() as f64
            };
            let cell = cell(name, ANSWERS).achieved(wrong(ENDS));
            if name == "metal" { cell } else { cell.planted(ONE, wrong(WITH_ONE)) }
        })
        .into()
}

/// Whether a material's answer is a direction on the side on which it may be, or none.
fn is_right(name: &str, row: &Met, out: &Answer) -> bool {
    let (incoming, normal, direction) = (exact(row.incoming), exact(row.normal), exact(out.direction));
    let height = direction.dot(normal);
    match (name, out.event) {
        ("metal", ABSORBED) => out.weight == [0.0; 3],
        (_, event) if event != SCATTERED || out.weight != [1.0; 3] || !is_unit(out.direction) => false,
        // z is 2^-12 at least before it is turned, by a basis that is off by 3 u.
        ("lambertian", _) => height > 2e-4,
        ("metal", _) => height > -2.0 * U,
        _ => {
            let (contrast, cos) = match row.front {
                0 => (row.material.contrast_inside, -incoming.dot(normal)),
                _ => (row.material.contrast_outside, -incoming.dot(normal)),
            };
            // Under total reflection the ray stays on its side, up to the numbers' last digits.
            f64::from(contrast) + cos * cos > -8.0 * U * f64::from(contrast).abs() || height > 0.0
        }
    }
}

/// Answers of a light that are no unit direction, or whose density or its square is no number, or not the same when told again.
fn wrong_lights<S: Pod>(kind: Kind, rows: &[light_kernel::In], shapes: &[S]) -> f64 {
    let wrong = |out: &light_kernel::Out| {
        let finite = out.pdf.is_finite() && out.pdf >= 0.0 && (out.pdf * out.pdf).is_finite();
        !(is_unit(out.direction) && finite && out.pdf == out.again)
    };
    light_kernel::at_ends(kind, rows, shapes).iter().filter(|(_, out)| wrong(out)).count() as f64
}

fn lights() -> Vec<Cell> {
    let mut random = Random(660);
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

    // Points before and beside a light of size 1 whose plane is z = 0, on it, touching and far away.
    let mut around = Vec::new();
    for height in [0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0, 10.0, 1e4, 1e8, 1e12] {
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (1.0, 1.0), (0.3, 0.2), (-2.0, 0.5), (0.5, 7.0)] {
            for side in [-1.0, 1.0] {
                around.push(row(rounded(DVec3::new(x, y, side * height)), 0));
            }
        }
        around.push(row(rounded(height * unit(&mut random)), 0));
    }
    let quad = Quad {
        normal: [0.0, 0.0, 1.0],
        a_axis: [1.0, 0.0, 0.0],
        b_axis: [0.0, 1.0, 0.0],
        u: [1.0, 0.0, 0.0],
        v: [0.0, 1.0, 0.0],
        ..Quad::default()
    };
    let triangle = Triangle { b: [1.0, 0.0, 0.0], c: [1.0, 1.0, 0.0], ..Triangle::default() };
    let cuboid = Cuboid {
        center: [0.5, 0.5, -0.25],
        half_extent: [0.5, 0.5, 0.25],
        x_axis: [1.0, 0.0, 0.0],
        y_axis: [0.0, 1.0, 0.0],
        ..Cuboid::default()
    };
    [
        ("sphere light, r/D from 1e-20 to 1e8", wrong_lights(SPHERE, &rows, &shapes)),
        ("quad light, from touching to 1e12 sizes away", wrong_lights(QUAD, &around, &[quad])),
        ("triangle light, from touching to 1e12 sizes away", wrong_lights(TRIANGLE, &around, &[triangle])),
        ("box light, from touching to 1e12 sizes away", wrong_lights(CUBOID, &around, &[cuboid])),
    ]
    .map(|(range, wrong)| cell(range, ANSWERS).achieved(wrong))
    .into()
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Pick {
    u: f32,
    count: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Picked {
    index: u32,
    rest: f32,
}

fn picks() -> Cell {
    let kernel = Kernel::new("test/alias_pick");
    let wrong = |ends: [f32; 4]| {
        let counts = [1, 2, 3, 7, 4096, 100_003, (1 << 24) - 1, 1 << 24];
        let rows: Vec<Pick> = counts.iter().flat_map(|&count| ends.map(|u| Pick { u, count })).collect();
        let found = kernel.run::<_, Picked>(&rows);
        let bad = |(row, out): &(&Pick, &Picked)| out.index >= row.count || !(0.0..1.0).contains(&out.rest);
        rows.iter().zip(&found).filter(bad).count() as f64
    };
    cell("choice of a light, tables of 1 to 2^24", ANSWERS).achieved(wrong(ENDS)).planted(ONE, wrong(WITH_ONE))
}

fn phases() -> Cell {
    let mut random = Random(89);
    let mut rows = Vec::new();
    for g in ASYMMETRIES.into_iter().flat_map(|g| [g, -g]) {
        for _ in 0..20 {
            let incoming = unit(&mut random);
            rows.extend(fours(ENDS).take(16).map(|u| Scattering::new(incoming, g, [u[0], u[1]])));
        }
    }
    let found = phase("false", &[]).run::<_, Scattered>(&rows);
    let wrong =
        |out: &&Scattered| !(is_unit(out.direction) && out.from_one.iter().all(|x| (0.0..2.000_001).contains(x)));
    cell("phase function, g up to ±(1 - 1e-6)", ANSWERS).achieved(found.iter().filter(wrong).count() as f64)
}

fn flights() -> Cell {
    let ends = [0, 255, 256, 0x7fff_ffff, 0x8000_0000, 0xffff_fe00, 0xffff_ff00, u32::MAX];
    let rows: Vec<[u32; 2]> = ends.iter().flat_map(|&x| ends.map(|y| [x, y])).collect();
    let wrong = |replaced: &[(&str, &str)]| {
        let found: Vec<f32> = Kernel::with("test/free_flight", &Setup { replaced, ..Setup::default() }).run(&rows);
        // 48 bits: 0 once, 33.28 at most.
        found.iter().filter(|tau| !(0.0..33.28).contains(*tau)).count() as f64
    };
    cell("free flight, words at both ends", ANSWERS).achieved(wrong(&[])).planted(
        "logarithm of 1 - u with u up to 1",
        wrong(&[("medium/free_flight", "test/control/free_flight_32_bits")]),
    )
}

/// The maps of lib/sampling, which lens, directions and lobes are drawn by.
fn maps() -> Vec<Cell> {
    let values = [("keyed", "false")];
    let kernel = Kernel::with("test/sampling", &Setup { values: &values, ..Setup::default() });
    // A root, a point on the circle (4 u) and a product, squared.
    const OFF: f64 = 16.0 * U;
    type Judge = fn(&Maps) -> bool;
    let judges: [(&str, Judge); 5] = [
        ("disk (lens)", |out| f64::from(out.disk[0]).hypot(f64::from(out.disk[1])) < 1.0 + OFF),
        ("circle", |out| (f64::from(out.circle[0]).hypot(f64::from(out.circle[1])) - 1.0).abs() < OFF),
        ("hemisphere", |out| (exact(out.hemisphere).length() - 1.0).abs() < OFF && out.hemisphere[2] > 2e-4),
        ("sphere", |out| (exact(out.sphere).length() - 1.0).abs() < OFF),
        ("ball, cube root", |out| exact(out.ball).length() < 1.0 + 1e-5 && (0.0..1.0 + 1e-5).contains(&out.root)),
    ];
    let found = |ends| kernel.run::<_, Maps>(&fours(ends).collect::<Vec<_>>());
    let (own, with_one) = (found(ENDS), found(WITH_ONE));
    judges
        .map(|(range, judge)| {
            let wrong = |found: &[Maps]| found.iter().filter(|out| !judge(out)).count() as f64;
            let cell = cell(range, ANSWERS).achieved(wrong(&own));
            if range == "hemisphere" { cell.planted(ONE, wrong(&with_one)) } else { cell }
        })
        .into()
}

/// Rays through the corners of pixels from the edge of the lens: within the image's own corners.
fn camera() -> Cell {
    let mut wrong = 0;
    let lenses: BTreeMap<&str, [f64; 2]> = BTreeMap::from([("pinhole", [0.0, 1.0]), ("thin_lens", [0.2, 3.0])]);
    for (camera, [aperture, focus]) in lenses {
        for fov in [1e-3, 40.0, 179.0] {
            let scene = scene(&format!(
                "Scene(image: (width: 8, height: 8), background: Solid((1, 1, 1)), materials: {{}}, objects: [],
                 camera: (look_from: (1, 2, 3), look_at: (0, 0, 0), vertical_fov: {fov:?}, aperture: {aperture:?}, focus_distance: {focus:?}))"
            ));
            let settings = flatten(&scene, (8, 8), &crate::common::render::plain()).expect("it is a scene").settings;
            let kernel = Kernel::with("test/camera", &Setup { values: &[("camera", camera)], ..Setup::default() });
            let rows: Vec<OnFilm> = [0, 7]
                .iter()
                .flat_map(|&column| {
                    fours(ENDS).map(move |u| OnFilm { column, row: 7 - column, u, ..OnFilm::default() })
                })
                .collect();
            let lens = exact(settings.lens_x).length();
            for out in kernel.run_with::<_, CameraRay>(&rows, rows.len(), &[kernel.settings(&settings)]) {
                let within = exact(out.origin).length() <= lens * (1.0 + 1e-3);
                wrong += u32::from(!(is_unit(out.direction) && within));
            }
        }
    }
    cell("camera: pixel and lens, vertical_fov from 1e-3 to 179", ANSWERS).achieved(f64::from(wrong))
}
