//! Whole images against references by an independent renderer, Mitsuba 3.9.1 (tests/references: scene, image, and how it was made).
//!
//! One test decides everything here: over an area, the mean of our image and that of the reference may differ by noise alone. The
//! areas are the whole image and blocks of it. A sample's radiance is bounded, by the brightest thing in the scene, so that Bernstein's
//! inequality holds however skewed the samples are (a small lamp is met rarely, and is then very bright): single pixels of some
//! dozens of samples cannot be told from noise at a false-alarm rate of 1e-6 whatever the test, blocks can.
//!
//! So it is for scattered rays alone, which find a third or a half of one block, 0.3 to 0.5 % of the light. The program's defaults are tested by
//! several seeds (`every_reference_by_the_default_settings`), and find 3 % of a block and half a percent of the image.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::render::{Ask, Shot, render};
use crate::common::stats::{mean_and_variance, sidak, student_two_sided};
use gpu_rt::output::exr::read_exr;
use gpu_rt::scene::{Material, Object, Scene, Texture, Transform};

/// False-alarm rate of each test function here, shared by its areas and channels.
const ALPHA: f64 = 1e-6;

struct Reference {
    scene: Scene,
    rgb: Vec<[f32; 3]>,
    /// Of the reference itself.
    relmse: f64,
    /// The most that a sample can bring, in any channel.
    brightest: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references")
}

impl Reference {
    fn load(name: &str, brightest: f64) -> Reference {
        let file = |extension: &str| folder().join(name).with_extension(extension);
        let scene = Scene::load(&file("ron")).unwrap_or_else(|error| panic!("{error}"));
        let exr = read_exr(&file("exr")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((exr.width, exr.height), (scene.image.width, scene.image.height));
        let json = fs::read_to_string(file("json")).expect("the reference says how it was made");
        let json: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
        let relmse = json["relmse_of_reference"].as_f64().expect("it says its error");
        Reference { scene, rgb: exr.rgb, relmse, brightest }
    }

    /// The variance of a pixel of the reference. Its file has none, but its relMSE, the mean over pixels of variance / (value² + 0.01):
    /// where each pixel has this mean, the variance is this. At our sample counts it is a fiftieth of our own or less, so
    /// that it does not matter how it is spread over the pixels.
    fn variance(&self, value: f64) -> f64 {
        self.relmse * (value * value + 0.01)
    }

    /// Whether the pixels that show nothing but the lamp do so here: each of some two hundred, but for the rounding of sums of 8 equal values.
    fn lamp_agrees(&self, shot: &Shot, lamp: f32) -> bool {
        let pairs = self.rgb.iter().zip(&shot.picture.rgb);
        let of_lamp: Vec<_> = pairs.filter(|(reference, _)| **reference == [lamp; 3]).collect();
        assert!(of_lamp.len() > 100, "the reference shows the lamp");
        of_lamp.iter().all(|(_, found)| found.iter().all(|v| (v / lamp - 1.0).abs() < 1e-6))
    }

    /// Compares the image over blocks of `side` pixels (smaller at the right and lower edges), or as a whole. Only pixels whose
    /// reference is below `below` count.
    fn compare(&self, shot: &Shot, side: Option<u32>, below: f32) -> Result<(), Difference> {
        let (width, height) = (shot.picture.width, shot.picture.height);
        let side = side.unwrap_or(width.max(height));
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let mut areas = vec![Area::default(); (columns * rows) as usize];
        for y in 0..height {
            for x in 0..width {
                let pixel = (y * width + x) as usize;
                if self.rgb[pixel].iter().any(|&v| v >= below) {
                    continue;
                }
                let area = &mut areas[(y / side * columns + x / side) as usize];
                area.pixels += 1.0;
                area.samples += f64::from(shot.picture.samples[pixel]);
                for c in 0..3 {
                    let at = |values: &[[f32; 3]]| f64::from(values[pixel][c]);
                    area.found[c] += at(&shot.picture.rgb);
                    area.expected[c] += at(&self.rgb);
                    area.variance[c] += at(&shot.picture.variance) + self.variance(at(&self.rgb));
                }
            }
        }
        let threshold = sidak(ALPHA, 3 * areas.len());
        let mut worst: Option<Difference> = None;
        for (index, area) in (0..).zip(&areas).filter(|(_, area)| area.pixels > 0.0) {
            for c in 0..3 {
                let difference = (area.found[c] - area.expected[c]) / area.pixels;
                let variance = area.variance[c] / (area.pixels * area.pixels);
                let p = bernstein(difference, variance, self.brightest / area.samples);
                let corner = (index % columns * side, index / columns * side);
                if p.is_nan() || worst.is_none_or(|worst| p < worst.p) {
                    let z = difference / variance.sqrt();
                    let expected = area.expected[c] / area.pixels;
                    worst = Some(Difference { corner, channel: c, difference, expected, z, p, threshold });
                }
            }
        }
        let worst = worst.expect("something is compared");
        println!("{worst:?}");
        match worst.p >= worst.threshold {
            true => Ok(()),
            false => Err(worst),
        }
    }
}

/// P(|mean - expectation| >= |difference|) at most, for a mean of this variance over independent samples none of which can move it by more
/// than `reach`: 2 exp(-d²/(2 (variance + reach d/3))) (Bernstein; Boucheron, Lugosi, Massart, "Concentration Inequalities", 2013,
/// theorem 2.10). The variance is an estimate, from hundreds of runs: it is right to some percent, and the inequality has more
/// slack than that.
fn bernstein(difference: f64, variance: f64, reach: f64) -> f64 {
    match difference == 0.0 {
        true => 1.0,
        false => 2.0 * (-difference * difference / (2.0 * (variance + reach * difference.abs() / 3.0))).exp(),
    }
}

/// Sums over an area.
#[derive(Clone, Copy, Debug, Default)]
struct Area {
    pixels: f64,
    samples: f64,
    found: [f64; 3],
    expected: [f64; 3],
    variance: [f64; 3],
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

fn times(shot: &Shot, factor: f32) -> Shot {
    shot.changed(|_, _, rgb| rgb.map(|v| v * factor))
}

fn in_block(shot: &Shot, corner: (u32, u32), side: u32, factor: f32) -> Shot {
    let inside = |x: u32, y: u32| x / side == corner.0 / side && y / side == corner.1 / side;
    shot.changed(|x, y, rgb| if inside(x, y) { rgb.map(|v| v * factor) } else { rgb })
}

const EVERYTHING: f32 = f32::INFINITY;

/// 486 spheres, diffuse, mirrors and glass, a lens, a gradient. No sample is brighter than the sky, 1.
///
/// Power, from the errors seen: the mean of the image is known to 0.02 % of it, so that 0.15 % are found and 1 % is 50 standard
/// errors; a block of 4 x 4 pixels (768 samples, deviating by half of their mean) to 2 %, so that 20 % are found in any one of the
/// 3600 blocks.
#[test]
fn the_cover_of_the_book() {
    let reference = Reference::load("rtiow_final_smooth", 1.0);
    let shot = render(&reference.scene, &Ask::spp(48).seed(1));
    reference.compare(&shot, None, EVERYTHING).expect("the mean agrees");
    reference.compare(&shot, Some(20), EVERYTHING).expect("blocks of 20 x 20 agree");
    reference.compare(&shot, Some(4), EVERYTHING).expect("blocks of 4 x 4 agree");

    for factor in [0.99, 1.01] {
        assert!(reference.compare(&times(&shot, factor), None, EVERYTHING).is_err(), "all of it times {factor}");
    }
    for factor in [0.7, 1.3] {
        let planted = in_block(&shot, (160, 88), 4, factor);
        let found = reference.compare(&planted, Some(4), EVERYTHING).expect_err("a block is found");
        assert_eq!(found.corner, (160, 88));
    }

    // The large diffuse sphere darker by a tenth: 4 % of the image.
    let mut scene = reference.scene.clone();
    let brown = scene.materials.iter_mut().find(|(name, _)| name == "brown").expect("the sphere's material");
    let Material::Lambertian { albedo: Texture::Rgb(r, g, b) } = &mut brown.1 else {
        panic!("the sphere is Lambertian and plain");
    };
    (*r, *g, *b) = (0.9 * *r, 0.9 * *g, 0.9 * *b);
    let planted = render(&scene, &Ask::spp(16).seed(2));
    assert!(reference.compare(&planted, Some(20), EVERYTHING).is_err(), "one material is darker by a tenth");
}

/// Rectangles, turned boxes, light bounced about, and a lamp that shines both ways. No sample is brighter than the lamp, 15.
///
/// Power, from the errors seen. The lamp itself makes half of the sum of the image and has no noise: 1 % of the whole image is found
/// by it. All else gets its light by paths that happen to meet the lamp: the mean without the lamp's pixels is known to 0.34 %, so
/// that 3 % are found; a block of 20 x 20 in the light to 2 %, so that half of it is found there. Light sampling will make
/// far more of the same samples (`every_reference_by_the_default_settings`).
#[test]
fn the_cornell_box() {
    const LAMP: f32 = 15.0;
    const BELOW_LAMP: f32 = 5.0;
    let reference = Reference::load("cornell_2s", f64::from(LAMP));
    let shot = render(&reference.scene, &Ask::spp(192).seed(1));
    reference.compare(&shot, None, EVERYTHING).expect("the mean agrees");
    reference.compare(&shot, None, BELOW_LAMP).expect("the mean without the lamp agrees");
    reference.compare(&shot, Some(20), BELOW_LAMP).expect("blocks of 20 x 20 without the lamp agree");
    reference.compare(&shot, Some(4), EVERYTHING).expect("blocks of 4 x 4 agree");
    assert!(reference.lamp_agrees(&shot, LAMP), "the lamp's own pixels agree");

    for factor in [0.99, 1.01] {
        assert!(!reference.lamp_agrees(&times(&shot, factor), LAMP), "all of it times {factor}");
    }
    for factor in [0.97, 1.03] {
        assert!(reference.compare(&times(&shot, factor), None, BELOW_LAMP).is_err(), "the room times {factor}");
    }
    for factor in [0.5, 1.5] {
        let planted = in_block(&shot, (100, 60), 20, factor);
        let found = reference.compare(&planted, Some(20), BELOW_LAMP).expect_err("a block is found");
        assert_eq!(found.corner, (100, 60));
    }
}

/// Rectangles and two smokes in turned boxes, one black, one white. No sample is brighter than the lamp, 7.
///
/// Power, from the errors seen: the mean without the lamp's pixels is known to 0.3 %, so that 3 % are found; a block of
/// 20 x 20 in the light to 2 %, so that half of it is found there.
#[test]
fn the_smoke_boxes() {
    const LAMP: f32 = 7.0;
    const BELOW_LAMP: f32 = 5.0;
    let reference = Reference::load("cornell_smoke", f64::from(LAMP));
    let shot = render(&reference.scene, &Ask::spp(192).seed(1));
    reference.compare(&shot, None, EVERYTHING).expect("the mean agrees");
    reference.compare(&shot, None, BELOW_LAMP).expect("the mean without the lamp agrees");
    reference.compare(&shot, Some(20), BELOW_LAMP).expect("blocks of 20 x 20 without the lamp agree");
    reference.compare(&shot, Some(4), EVERYTHING).expect("blocks of 4 x 4 agree");

    for factor in [0.97, 1.03] {
        assert!(reference.compare(&times(&shot, factor), None, BELOW_LAMP).is_err(), "the room times {factor}");
    }
    for factor in [0.5, 1.5] {
        let planted = in_block(&shot, (100, 100), 20, factor);
        let found = reference.compare(&planted, Some(20), BELOW_LAMP).expect_err("a block is found");
        assert_eq!(found.corner, (100, 100));
    }

    // The black smoke with half of its density.
    let mut scene = reference.scene.clone();
    let density = scene.objects.iter_mut().find_map(|object| match object {
        Object::Medium { density, .. } => Some(density),
        _ => None,
    });
    *density.expect("there is smoke") *= 0.5;
    let planted = render(&scene, &Ask::spp(64).seed(2));
    assert!(reference.compare(&planted, Some(20), BELOW_LAMP).is_err(), "one smoke is thinner");
}

/// A mesh of 38,400 flat-shaded triangles under a lamp and a constant sky. No sample is brighter than the lamp, 12.
///
/// Power, from the errors seen: the mean is known to 0.15 %, so that 1.5 % are found; a block of 20 x 20 on the knot to
/// 1.5 %, so that 30 % are found in any one.
#[test]
fn the_knot() {
    let reference = Reference::load("knot", 12.0);
    let shot = render(&reference.scene, &Ask::spp(48).seed(1));
    reference.compare(&shot, None, EVERYTHING).expect("the mean agrees");
    reference.compare(&shot, Some(20), EVERYTHING).expect("blocks of 20 x 20 agree");
    reference.compare(&shot, Some(4), EVERYTHING).expect("blocks of 4 x 4 agree");

    for factor in [0.985, 1.015] {
        assert!(reference.compare(&times(&shot, factor), None, EVERYTHING).is_err(), "all of it times {factor}");
    }
    for factor in [0.7, 1.3] {
        let planted = in_block(&shot, (140, 60), 20, factor);
        let found = reference.compare(&planted, Some(20), EVERYTHING).expect_err("a block is found");
        assert_eq!(found.corner, (140, 60));
    }

    // The mesh larger by 6 %: its outline moves by a pixel or two.
    let mut scene = reference.scene.clone();
    let larger = scene.objects.iter_mut().find_map(|object| match object {
        Object::Transformed { by, .. } => by.first_mut(),
        _ => None,
    });
    *larger.expect("the knot is scaled") = Transform::Scale(0.28 * 1.06);
    let planted = render(&scene, &Ask::spp(48).seed(2));
    assert!(reference.compare(&planted, Some(20), EVERYTHING).is_err(), "the knot is larger by 6 %");
}

/// The image as it is rendered without being asked otherwise: lights sampled, Sobol points, roulette; by several seeds.
fn by_defaults(scene: &Scene, seeds: std::ops::Range<u32>) -> Vec<Shot> {
    let ask = Ask::spp(16).mis().sobol().roulette();
    seeds.map(|seed| render(scene, &ask.clone().seed(seed))).collect()
}

/// Where the mean of several seeds differs from the reference by the most, with a factor for each pixel: over the whole image and over blocks of
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

/// What `gpu-rt render` does without being asked otherwise, against all references: the mean of the image and of blocks of 20 x 20 pixels, by
/// Student's test.
///
/// Power: the mean of an image is known to 0.01 to 0.05 % from 8 x 16 samples, so that half a percent is found in any of them; a block of
/// 20 x 20 to 0.3 % or better, so that 3 % are found in the one where they are planted, 0.05 % of the light or less.
#[test]
fn every_reference_by_the_default_settings() {
    const SIDE: u32 = 20;
    for (name, block) in [
        ("cornell", (100, 100)),
        ("cornell_2s", (100, 60)),
        ("cornell_smoke", (100, 100)),
        ("knot", (140, 60)),
        ("rtiow_final_smooth", (160, 80)),
    ] {
        let reference = Reference::load(name, 15.0);
        let shots = by_defaults(&reference.scene, 100..108);
        let found = worst_by_seeds(&reference, &shots, SIDE, |_, _| 1.0);
        println!("{name}: {found:?}");
        assert!(found.p >= found.threshold, "{name}: {found:?}");
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

/// The large diffuse sphere of the book's cover darker by a fortieth: 1 % of the image.
#[test]
fn one_material_darker_by_a_fortieth_is_found() {
    let reference = Reference::load("rtiow_final_smooth", 1.0);
    let mut scene = reference.scene.clone();
    let brown = scene.materials.iter_mut().find(|(name, _)| name == "brown").expect("the sphere's material");
    let Material::Lambertian { albedo: Texture::Rgb(r, g, b) } = &mut brown.1 else {
        panic!("the sphere is Lambertian and plain");
    };
    (*r, *g, *b) = (0.975 * *r, 0.975 * *g, 0.975 * *b);
    let found = worst_by_seeds(&reference, &by_defaults(&scene, 200..208), 20, |_, _| 1.0);
    println!("{found:?}");
    assert!(found.p < found.threshold);
}
