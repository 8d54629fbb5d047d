//! Whole images against references by an independent renderer, Mitsuba 3.9.1 (tests/references: scene, image, and how it was made).
//!
//! One test decides everything here: over an area, the mean of our image and that of the reference may differ by noise alone. The
//! areas are the full image and blocks of it; several seeds give the noise. Images are rendered by the defaults. That scattered rays
//! alone expect the same is tested in tests/images/estimators.rs.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::render::{Request, Shot, render};
use crate::common::stats::{mean_and_variance, sidak, student_two_sided};
use gpu_rt::metrics::flip;
use gpu_rt::output::exr::read_exr;
use gpu_rt::scene::{Density, Lambertian, Material, Object, Projection, Scene, Texture, Transform};

/// False-alarm rate of each test function here, shared by its areas and channels.
const ALPHA: f64 = 1e-6;

struct Reference {
    scene: Scene,
    rgb: Vec<[f32; 3]>,
    /// Of the reference itself.
    relmse: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references")
}

impl Reference {
    fn load(name: &str) -> Reference {
        let file = |extension: &str| folder().join(name).with_extension(extension);
        let path = ["xml", "pbrt", "ron"].map(file).into_iter().find(|path| path.exists()).expect("it is there");
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let exr = read_exr(&file("exr")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((exr.width, exr.height), (scene.image.width, scene.image.height));
        let json = fs::read_to_string(file("json")).expect("the reference says how it was made");
        let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
        let relmse = json["relmse_of_reference"].as_f64().expect("it says its error");
        Reference { scene, rgb: exr.rgb, relmse }
    }

    /// The variance of a pixel of the reference. Its file has none, but its relMSE, the mean over pixels of variance / (value² + 0.01):
    /// where each pixel has this mean, the variance is this. At our sample counts it is a fiftieth of our own or less, so
    /// that it does not matter how it is spread over the pixels.
    fn variance(&self, value: f64) -> f64 {
        self.relmse * (value * value + 0.01)
    }
}

/// The worst area of a comparison.
#[derive(Clone, Copy, Debug)]
#[expect(dead_code, reason = "shown where a test fails")]
struct Difference {
    corner: (u32, u32),
    channel: usize,
    difference: f64,
    expected: f64,
    z: f64,
    p: f64,
    threshold: f64,
}

/// The image by the defaults: lights sampled, Sobol points, roulette; by several seeds.
fn by_defaults(scene: &Scene, seeds: std::ops::Range<u32>) -> Vec<Shot> {
    let request = Request::spp(16).mis().sobol().roulette();
    seeds.map(|seed| render(scene, &request.clone().seed(seed))).collect()
}

/// Where the mean of several seeds differs from the reference by the most, with a factor for each pixel: over the full image and over blocks of
/// `side` pixels. Each pixel's variance is that between the seeds, of k = seeds less one degrees of freedom, and pixels are independent: the
/// degrees of an area are Satterthwaite's (tests/common/render.rs, `Shot::mean_over`).
fn worst_by_seeds(reference: &Reference, shots: &[Shot], side: u32, factor: impl Fn(u32, u32) -> f64) -> Difference {
    let (width, height) = (shots[0].picture.width, shots[0].picture.height);
    let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
    let mut areas = vec![BySeeds::default(); (1 + columns * rows) as usize];
    let seeds = shots.len() as f64;
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let pixel = (y * width + x) as usize;
        for c in 0..3 {
            let values: Vec<f64> =
                shots.iter().map(|shot| factor(x, y) * f64::from(shot.picture.rgb[pixel][c])).collect();
            let (mean, spread) = mean_and_variance(&values);
            let expected = f64::from(reference.rgb[pixel][c]);
            for area in [0, 1 + (y / side * columns + x / side) as usize] {
                let area = &mut areas[area];
                area.pixels += 1.0 / 3.0;
                area.found[c] += mean;
                area.expected[c] += expected;
                area.variance[c] += spread / seeds;
                area.squares[c] += (spread / seeds).powi(2) / (seeds + 1.0);
                area.of_reference[c] += reference.variance(expected);
            }
        }
    }
    let threshold = sidak(ALPHA, 3 * areas.len());
    let differences = (0..).zip(&areas).flat_map(|(index, area)| {
        (0..3).map(move |channel| {
            let variance = area.variance[channel] + area.of_reference[channel];
            let difference = area.found[channel] - area.expected[channel];
            // Pixels of the lamp alone have no error at all, here or there, but for the rounding of sums.
            let excess = (difference.abs() - 1e-6 * area.found[channel]).max(0.0);
            let z = if excess == 0.0 { 0.0 } else { excess / variance.sqrt() };
            let degrees = match area.squares[channel] > 0.0 {
                true => variance * variance / area.squares[channel],
                false => f64::INFINITY,
            };
            let p = student_two_sided(z, degrees);
            let corner = match index {
                0 => (0, 0),
                _ => ((index - 1) % columns * side, (index - 1) / columns * side),
            };
            let expected = area.expected[channel] / area.pixels;
            Difference { corner, channel, difference: difference / area.pixels, expected, z, p, threshold }
        })
    });
    differences.min_by(|a, b| a.p.total_cmp(&b.p)).expect("something is compared")
}

/// Sums over an area, by channel.
#[derive(Clone, Copy, Debug, Default)]
struct BySeeds {
    pixels: f64,
    found: [f64; 3],
    expected: [f64; 3],
    variance: [f64; 3],
    /// Of the variances, over their degrees of freedom and two.
    squares: [f64; 3],
    of_reference: [f64; 3],
}

/// The defaults of `gpu-rt render` against all references: the mean of the image and of blocks of 20 x 20 pixels, by
/// Student's test.
///
/// Power: the mean of an image is known to 0.02 to 0.07 % from 4 x 16 samples, so that half a percent is found in any of them; a block of
/// 20 x 20 to 0.4 % or better, so that 3 % are found in the one where they are planted, 0.05 % of the light or less.
#[test]
fn the_default_settings_agree_with_every_reference() {
    const SIDE: u32 = 20;
    for (name, block) in [
        ("cornell", (100, 100)),
        ("cornell_2s", (100, 60)),
        ("cornell_smoke", (100, 100)),
        ("knot", (140, 60)),
        ("rtiow_final_smooth", (160, 80)),
        ("cameras/orthographic", (60, 0)),
    ] {
        let reference = Reference::load(name);
        let shots = by_defaults(&reference.scene, 100..104);
        for side in [SIDE, 4] {
            let found = worst_by_seeds(&reference, &shots, side, |_, _| 1.0);
            println!("{name}: {found:?}");
            assert!(found.p >= found.threshold, "{name}: {found:?}");
        }
        for factor in [0.995, 1.005] {
            let planted = worst_by_seeds(&reference, &shots, u32::MAX / 2, |_, _| factor);
            println!("{name} times {factor}: {planted:?}");
            assert!(planted.p < planted.threshold, "{name}: all of it times {factor} is not found");
        }
        for factor in [0.97, 1.03] {
            let inside = |x: u32, y: u32| (x / SIDE, y / SIDE) == (block.0 / SIDE, block.1 / SIDE);
            let planted = worst_by_seeds(&reference, &shots, SIDE, |x, y| if inside(x, y) { factor } else { 1.0 });
            println!("{name}, a block times {factor}: {planted:?}");
            assert!(
                planted.p < planted.threshold && planted.corner == block,
                "{name}: a block times {factor} is not found"
            );
        }
    }
}

/// Scenes of Mitsuba as this program reads them, against Mitsuba's own images of the same text: its means and blocks of 12 x 12 pixels.
#[test]
fn scenes_of_mitsuba_are_as_mitsuba_renders_them() {
    for name in "shapes glass metals lights fog lens turned_sky images checks bent instances old dusk ball_matt ball_both ball_image ball_glass \
                 ball_tinted ball_pane ball_frosted ball_mirror ball_gold ball_steel ball_dim ball_veil ball_worn ball_brushed ball_hazy ball_plastic \
                 ball_deep ball_rubber ball_satin ball_blend ball_dusty wine alike"
        .split_whitespace()
    {
        is_as_the_other_program_has_it(&format!("mitsuba/{name}"), 400);
    }
}

/// The same of scenes of pbrt, against images by a port of it. They are grey: colours of surfaces are spectra there, whose products are others.
#[test]
fn scenes_of_pbrt_are_as_pbrt_renders_them() {
    for name in ["sky", "lights", "shapes", "materials", "textures"] {
        is_as_the_other_program_has_it(&format!("pbrt/{name}"), 430);
    }
}

/// A factor of 1.03 on the whole image is found in each: from 4 x 64 samples of 1,728 pixels the mean is known to 0.5 % or better.
fn is_as_the_other_program_has_it(name: &str, seed: u32) {
    let reference = Reference::load(name);
    let request = Request::spp(64).mis().sobol().roulette();
    let shots = |scene: &Scene, seeds: std::ops::Range<u32>| {
        seeds.map(|seed| render(scene, &request.clone().seed(seed))).collect::<Vec<Shot>>()
    };
    let own = shots(&reference.scene, seed..seed + 4);
    let found = worst_by_seeds(&reference, &own, 12, |_, _| 1.0);
    println!("{name}: {found:?}");
    assert!(found.p >= found.threshold, "{name}: {found:?}");
    let planted = worst_by_seeds(&reference, &own, 12, |_, _| 1.03);
    assert!(planted.p < planted.threshold, "{name}: all of it times 1.03 is not found");
    // A mirrored image, which a camera that looks along the wrong axis would have.
    let mut mirrored = reference.scene.clone();
    mirrored.camera.mirror = !mirrored.camera.mirror;
    let planted = worst_by_seeds(&reference, &shots(&mirrored, seed + 10..seed + 12), 12, |_, _| 1.0);
    assert!(planted.p < planted.threshold, "{name}: its mirror image is not found");
}

/// The same scene by pbrt's directives, and in our own form.
#[test]
fn a_scene_of_pbrt_is_as_mitsuba_renders_the_same() {
    let reference = Reference::load("mitsuba/alike");
    let request = Request::spp(64).mis().sobol().roulette();
    for (name, seeds) in [("pbrt/alike.pbrt", 420..424), ("pbrt/alike.ron", 424..428)] {
        let scene = Scene::load(&folder().join(name)).unwrap_or_else(|error| panic!("{error}"));
        let shots: Vec<Shot> = seeds.map(|seed| render(&scene, &request.clone().seed(seed))).collect();
        let found = worst_by_seeds(&reference, &shots, 12, |_, _| 1.0);
        println!("{name}: {found:?}");
        assert!(found.p >= found.threshold, "{name}: {found:?}");
        let planted = worst_by_seeds(&reference, &shots, 12, |_, _| 1.03);
        assert!(planted.p < planted.threshold, "{name}: all of it times 1.03 is not found");
    }
}

/// A scene with one thing else in it.
type Planted = fn(&mut Scene);

const FURTHER_APART: Planted = |scene| scene.camera.projection = Some(Projection::Orthographic { height: 336.6 });
const MIRRORED: Planted = |scene| scene.camera.mirror = true;

/// The large diffuse sphere of the book's cover darker by a fortieth, 1 % of the image; the black smoke with half of its density; the knot larger
/// by 6 %, which moves its outline by a pixel or two; parallel rays a fiftieth further apart, which moves outlines by a pixel at most; the image of
/// parallel rays mirrored. What is off by dozens of standard errors takes half of the seeds.
#[test]
fn a_scene_with_one_thing_else_is_found() {
    let darker: Planted = |scene| {
        let brown = scene.materials.iter_mut().find(|(name, _)| name == "brown").expect("the sphere's material");
        let Material::Lambertian(Lambertian { albedo: Texture::Rgb(r, g, b), .. }) = &mut brown.1 else {
            panic!("the sphere is Lambertian and plain");
        };
        (*r, *g, *b) = (0.975 * *r, 0.975 * *g, 0.975 * *b);
    };
    let thinner: Planted = |scene| {
        let density = scene.objects.iter_mut().find_map(|object| match object {
            Object::Medium { density, .. } => Some(density),
            _ => None,
        });
        let density = density.expect("there is smoke");
        *density = Density::Constant(0.5 * density.scale());
    };
    let larger: Planted = |scene| {
        let larger = scene.objects.iter_mut().find_map(|object| match object {
            Object::Transformed { by, .. } => by.first_mut(),
            _ => None,
        });
        *larger.expect("the knot is scaled") = Transform::Scale(0.28 * 1.06);
    };
    for (name, plant, seeds) in [
        ("rtiow_final_smooth", darker, 200..204),
        ("cornell_smoke", thinner, 200..202),
        ("knot", larger, 200..202),
        ("cameras/orthographic", FURTHER_APART, 200..204),
        ("cameras/orthographic", MIRRORED, 200..202),
    ] {
        let reference = Reference::load(name);
        let mut scene = reference.scene.clone();
        plant(&mut scene);
        let found = worst_by_seeds(&reference, &by_defaults(&scene, seeds), 20, |_, _| 1.0);
        println!("{name}: {found:?}");
        assert!(found.p < found.threshold, "{name}");
    }
}

/// Parallel rays by FLIP, which sees outlines. Two of our images, each with noise s, differ by s sqrt(2); ours and the reference, whose samples are
/// 64 times as many, by 1.01 s. FLIP grows as a power of 0.5 to 0.7 of small differences, so that it is 0.79 to 0.85 of that between ours.
#[test]
fn parallel_rays_differ_from_the_reference_by_the_flip_of_noise() {
    let reference = Reference::load("cameras/orthographic");
    let width = reference.scene.image.width as usize;
    let image = |plant: Option<Planted>, seed: u32| {
        let mut scene = reference.scene.clone();
        plant.into_iter().for_each(|plant| plant(&mut scene));
        render(&scene, &Request::spp(256).mis().sobol().roulette().seed(seed)).picture.rgb
    };
    let flip = |a: &[[f32; 3]], b: &[[f32; 3]]| flip::mean(&flip::error_map(width, a, b));
    let ours = image(None, 301);
    let noise = flip(&ours, &image(None, 302));
    let found = flip(&ours, &reference.rgb);
    println!("{found}, of noise {noise}");
    assert!(found < noise, "{found}, of noise {noise}");
    for plant in [FURTHER_APART, MIRRORED] {
        let planted = flip(&image(Some(plant), 301), &reference.rgb);
        println!("planted: {planted}");
        assert!(planted > 1.2 * noise, "planted: {planted}, of noise {noise}");
    }
}
