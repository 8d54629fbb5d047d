//! Verdicts of images that may lack light: lamps of all kinds behind all kinds of narrow lobes, seen from near and far. An image that is called reliable
//! has the error that it states.

use gpu_rt::film::Film;
use gpu_rt::options::LightPaths;
use gpu_rt::render::NOISE_LEVEL;
use image::{DynamicImage, Rgb, Rgb32FImage};

use crate::common::render::{Request, render, render_all, scene_in};
use crate::common::stats::Random;

/// The samples at which an image is judged.
const SAMPLES: [u32; 5] = [16, 32, 64, 128, 256];
/// The error at whose bound `--noise` would end.
const NOISE: f64 = 0.1;

/// The shares of reliable images that may err by more than 1.5 bounds, and by more than five.
const MOST_BEYOND: [(f64, f64); 2] = [(1.5, 0.01), (5.0, 0.001)];

fn pick<'a, T>(random: &mut Random, of: &'a [T]) -> &'a T {
    &of[random.below(of.len())]
}

/// Five walls of a room; a window of 2 x 2 is in the one behind.
const OPEN: &str = "Quad(corner: (-5, 7, -5), u: (10, 0, 0), v: (0, 0, 10), material: \"wall\"), Quad(corner: (-5, 0, 5), u: (10, 0, 0), v: (0, 7, 0), material: \"wall\"),
    Quad(corner: (-5, 0, -5), u: (0, 0, 10), v: (0, 7, 0), material: \"wall\"), Quad(corner: (5, 0, -5), u: (0, 0, 10), v: (0, 7, 0), material: \"wall\"),
    Quad(corner: (-5, 0, -5), u: (10, 0, 0), v: (0, 2, 0), material: \"wall\"), Quad(corner: (-5, 4, -5), u: (10, 0, 0), v: (0, 3, 0), material: \"wall\"),
    Quad(corner: (-5, 2, -5), u: (4, 0, 0), v: (0, 2, 0), material: \"wall\"), Quad(corner: (1, 2, -5), u: (4, 0, 0), v: (0, 2, 0), material: \"wall\"),";

/// A lamp at (0, 3, 0) with the intensity 1, and what is around it or between it and the floor; a receiver on the floor; and a view of it.
fn scene_text(random: &mut Random) -> String {
    let ball = |radius: f64| {
        let emit = 1.0 / (std::f64::consts::PI * radius * radius);
        format!("Sphere(center: (0, 3, 0), radius: {radius}, material: \"lamp\"),@{emit}")
    };
    let point = "PointLight(at: (0, 3, 0), intensity: (1, 1, 1)),@1".to_string();
    let alpha = ball(0.1).replace("lamp", "veil");
    let hot = "Quad(corner: (-0.3, 3, -0.3), u: (0.6, 0, 0), v: (0, 0, 0.6), material: \"hot\"),@3".to_string();
    let sun = "DirectionalLight(direction: (0.1, -1, 0.05), irradiance: (0.3, 0.3, 0.3)),@1".to_string();
    let moving = format!(
        "Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0.3, 0, 0))])], object: {}",
        ball(0.01).replace(",@", "),@")
    );
    // The far wall of a dark room is open.
    let window = "Box(min: (-4.9, 0, -5.5), max: (4.9, 1, -5.4), material: \"wall\"),@window".to_string();
    let lamps = [point, ball(0.0003), ball(0.003), ball(0.03), ball(0.1), sun, moving, alpha, hot, window];
    let widths = [0.03, 0.09, 0.11, 0.2, 0.24, 0.3, 0.4];
    let width = *pick(random, &widths);
    let glass = pick(
        random,
        &[
            "Dielectric(ior: 1.5)",
            "RoughDielectric(ior: 1.5, roughness: WIDTH)",
            "RoughDielectric(ior: 1.5, roughness: 0.3)",
        ],
    );
    let metal = pick(
        random,
        &[
            "Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0)",
            "Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: WIDTH)",
            "Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: WIDTH)",
        ],
    );
    let pane = pick(random, &["ThinDielectric()", "ThinDielectric(roughness: WIDTH)"]);
    let between = pick(
        random,
        &[
            "",
            "Sphere(center: (0, 3, 0), radius: 0.4, material: \"glass\"), Sphere(center: (0, 3, 0), radius: 0.36, material: \"air\"),",
            "Sphere(center: (0, 0.8, 0), radius: 0.5, material: \"glass\"),",
            "Quad(corner: (-4, 2, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"pane\"),",
            "Box(min: (-3, 0.3, -3), max: (3, 0.8, 3), material: \"glass\"),",
            "Quad(corner: (-1, 2.2, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"black\"), Quad(corner: (-3, 4, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"metal\"),",
            "Quad(corner: (-2, 0.1, -1.5), u: (4, 0, 0), v: (0, 3, -0.5), material: \"metal\"),",
            "Sphere(center: (0.5, 0.5, -0.6), radius: 0.45, material: \"metal\"),",
            "Box(min: (-0.2, 0.1, -0.3), max: (0.4, 0.5, 0.3), material: \"wall\"), Box(min: (-0.25, 0.05, -0.35), max: (0.45, 0.55, 0.35), material: \"glass\"),",
        ],
    );
    let receiver = pick(
        random,
        &[
            "Lambertian(albedo: Rgb(0.7, 0.7, 0.7))",
            "Lambertian(albedo: Rgb(0.7, 0.7, 0.7))",
            "Conductor(albedo: Rgb(0.8, 0.8, 0.8), roughness: WIDTH)",
            "Metal(albedo: Rgb(0.8, 0.8, 0.8), fuzz: WIDTH)",
            "Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, roughness: WIDTH)",
            "Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 1, roughness: 0.4)",
            "Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, roughness: 0.6, coat: 1, coat_roughness: WIDTH)",
        ],
    );
    // The half height of what is seen of the floor.
    let (half, from) = *pick(
        random,
        &[
            (1.5, "(0, 2, 4)"),
            (1.5, "(0, 2, 4)"),
            (0.045, "(0.3, 0.25, 0.2)"),
            (0.015, "(0.25, 0.2, 0.2)"),
            (1.5, "(0.1, 6, 0.2)"),
            (1.5, "(3, 1, -3)"),
        ],
    );
    let at = if half < 1.0 { "(0.2, 0, 0.1)" } else { "(0, 0.2, 0)" };
    let numbers = |text: &str| -> Vec<f64> {
        text.trim_matches(['(', ')']).split(',').map(|x| x.trim().parse().unwrap()).collect()
    };
    let distance: f64 = numbers(from).iter().zip(numbers(at)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let fov = 2.0 * (half / distance).atan().to_degrees();
    let (lamp, emit) =
        pick(random, &lamps).split_once('@').map(|(lamp, emit)| (lamp.to_string(), emit.to_string())).unwrap();
    let closed = "Box(min: (-5, 0, -5), max: (5, 7, 5), material: \"wall\"),";
    let (sky, room) = match emit.as_str() {
        "window" => (1.0, OPEN),
        _ => (*pick(random, &[0.0, 0.002, 0.02]), *pick(random, &["", closed])),
    };
    let emit = if emit == "window" { "1".to_string() } else { emit };
    format!(
        "Scene(image: (width: 24, height: 16), camera: (look_from: {from}, look_at: {at}, vertical_fov: {fov}, shutter: (0, 1)), background: Solid(({sky}, {sky}, {sky})),
        materials: {{\"receiver\": {receiver}, \"wall\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"black\": Lambertian(albedo: Rgb(0, 0, 0)), \"glass\": {glass},
            \"air\": {air}, \"pane\": {pane}, \"metal\": {metal}, \"lamp\": DiffuseLight(emit: Rgb({emit}, {emit}, {emit})),
            \"veil\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5), emission: Rgb({emit}, {emit}, {emit}), alpha: 0.3), \"hot\": DiffuseLight(emit: Image(path: \"hot.hdr\"))}},
        objects: [Quad(corner: (-3, 0.001, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"receiver\"), {between} {lamp} {room}], render: (samples: 64, max_depth: 12))",
        air = glass.replace("1.5", "0.6666667"),
    )
    .replace("WIDTH", &width.to_string())
}

/// The relative error of an image against a reference, over pixels and channels.
fn error(image: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let luminance =
        |pixel: &[f32; 3]| 0.2126 * f64::from(pixel[0]) + 0.7152 * f64::from(pixel[1]) + 0.0722 * f64::from(pixel[2]);
    let mean = reference.iter().map(luminance).sum::<f64>() / reference.len() as f64;
    let floor = 0.01 * mean * mean;
    let pairs = image.iter().flatten().zip(reference.iter().flatten());
    let sum: f64 =
        pairs.map(|(a, b)| (f64::from(*a), f64::from(*b))).map(|(a, b)| (a - b) * (a - b) / (b * b + floor)).sum();
    (sum / (3 * image.len()) as f64).sqrt()
}

#[test]
#[ignore = "takes minutes"]
fn verdicts_hold_where_light_is_hidden() {
    let number =
        |name: &str, default: u32| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let (first, count, seeds) = (number("GPU_RT_FIRST", 0), number("GPU_RT_COUNT", 250), number("GPU_RT_SEEDS", 4));
    let (mut images, mut reliable, mut beyond, mut unknown) = (0, 0, [0; 2], 0);
    let folder = tempfile::tempdir().expect("a folder");
    let texels = Rgb32FImage::from_fn(8, 8, |x, y| Rgb([if (x, y) == (5, 2) { 150.0 } else { 0.05 }; 3]));
    DynamicImage::from(texels).save(folder.path().join("hot.hdr")).expect("it is written");
    for number in first..first + count {
        let text = scene_text(&mut Random(u64::from(number) * 7919 + 1));
        let room = scene_in(folder.path(), &text);
        let usual = Request::default().mis().sobol().roulette();
        let many = usual.clone().with(|options| options.light_paths = LightPaths::Count(8)).seed(900);
        let reference = render(&room, &Request { samples: Some(0..4096), ..many });
        let verdict = reference.film.verdict(NOISE_LEVEL);
        let Some(own) = verdict.error.filter(|own| verdict.reliable() == Some(true) || own.value < 0.1) else {
            unknown += 1;
            continue;
        };
        let auto = usual.with(|options| options.light_paths = LightPaths::Auto);
        let ranges = std::iter::once(0).chain(SAMPLES).zip(SAMPLES).map(|(from, to)| from..to);
        let wanted: Vec<_> = (0..seeds).flat_map(|seed| ranges.clone().map(move |range| (seed, range))).collect();
        let (mut film, mut ended): (Option<Film>, bool) = (None, false);
        let mut said = Vec::new();
        render_all(&room, &auto, wanted.into_iter(), |shot| {
            let samples = shot.outcome.samples.range().end;
            let begun = film.take().filter(|_| samples > SAMPLES[0]);
            ended &= begun.is_some();
            let mut joined = begun.unwrap_or_else(|| shot.film.clone());
            if samples > SAMPLES[0] {
                joined.merge(&shot.film).expect("films of one image");
            }
            let verdict = joined.verdict(NOISE_LEVEL);
            let picture = joined.develop();
            film = Some(joined);
            images += 1;
            let Some(stated) = verdict.error.filter(|_| verdict.reliable() == Some(true)) else {
                return;
            };
            // `--noise` chooses the image by its bound. It is counted as one more image.
            let ends = stated.bound < NOISE && !ended;
            ended |= ends;
            let bound = stated.bound;
            let found = error(&picture.rgb, &reference.picture.rgb);
            let times = if ends { 2 } else { 1 };
            reliable += times;
            for (i, (most, _)) in MOST_BEYOND.iter().enumerate() {
                if found > most * bound + 3.0 * own.value {
                    beyond[i] += times;
                    if i == 0 {
                        said.push(format!("{samples} samples: error {found:.4}, bound {bound:.4}"));
                    }
                }
            }
        });
        if !said.is_empty() {
            println!("scene {number} (reference {:.4}): {said:?}\n{text}", own.value);
        }
    }
    println!(
        "{images} images, {reliable} reliable, {beyond:?} beyond 1.5 and 5 bounds; {unknown} scenes without a reference"
    );
    for ((_, most), beyond) in MOST_BEYOND.iter().zip(beyond) {
        assert!(f64::from(beyond) <= most * f64::from(reliable), "{beyond} of {reliable}");
    }
}
