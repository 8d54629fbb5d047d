//! The verdict of a comparison, on images made of random numbers: how often it calls noise a difference, and which differences it finds.
//!
//! Renders are what it is made for, and docs/comparing.md has how it fares with thousands of them; here the noise is of known kinds.

#[path = "common/stats.rs"]
mod stats;

use gpu_rt::metrics::difference::{CONFIDENCE, Difference, Images, LEVEL, Source, difference};
use gpu_rt::metrics::verdict::verdict;
use stats::Random;

/// An image and the variances of its pixels, as a render delivers them.
struct Noisy {
    rgb: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The same everywhere, of 5 % of the pixel.
    Even,
    /// A hundredth of the samples bring a hundred times the mean: few pixels hold nearly all of the noise.
    Rare,
}

const KINDS: [Kind; 2] = [Kind::Even, Kind::Rare];

/// Brighter to the right, with two halves of samples a pixel, whose difference tells the variance.
fn noisy(random: &mut Random, (width, height): (usize, usize), kind: Kind) -> Noisy {
    let mut image = Noisy { rgb: Vec::new(), variance: Vec::new() };
    for pixel in 0..width * height {
        let mean = 0.2 + (pixel % width) as f64 / width as f64;
        let mut half = || match kind {
            Kind::Even => 1.0 + 0.07 * random.normal(),
            Kind::Rare => 0.9 + if random.uniform() < 0.001 { 100.0 } else { 0.0 },
        };
        let halves = [half(), half()];
        // Red, green and blue come together, as paths bring them.
        let value = mean * 0.5 * (halves[0] + halves[1]);
        let variance = (mean * 0.5 * (halves[0] - halves[1])).powi(2);
        image.rgb.push([1.0, 0.8, 0.5].map(|c| (c * value) as f32));
        image.variance.push([1.0, 0.8, 0.5].map(|c: f64| (c * c * variance) as f32));
    }
    image
}

fn compare((width, height): (usize, usize), a: &Noisy, b: &Noisy, layers: bool) -> Difference {
    let variances = layers.then_some([a.variance.as_slice(), b.variance.as_slice()]);
    difference(&Images { width, height, a: &a.rgb, b: &b.rgb, variances }).expect("all is finite")
}

impl Noisy {
    /// Scaled where `place` holds.
    fn scaled(mut self, width: usize, factor: f32, place: impl Fn(usize, usize) -> bool) -> Noisy {
        for (pixel, (rgb, variance)) in self.rgb.iter_mut().zip(&mut self.variance).enumerate() {
            if place(pixel % width, pixel / width) {
                *rgb = rgb.map(|v| v * factor);
                *variance = variance.map(|v| v * factor * factor);
            }
        }
        self
    }
}

const SIZE: (usize, usize) = (64, 48);
const PAIRS: usize = 400;

/// What noise alone is called more than noise in: below its level, but for a chance of about 1e-6.
#[test]
fn noise_is_called_noise() {
    for (seed, kind) in (1..).zip(KINDS) {
        for layers in [true, false] {
            let mut random = Random(seed);
            let (mut alarms, mut outside) = (0, 0);
            for _ in 0..PAIRS {
                let (a, b) = (noisy(&mut random, SIZE, kind), noisy(&mut random, SIZE, kind));
                let found = compare(SIZE, &a, &b, layers);
                assert_eq!(found.source, if layers { Source::Variances } else { Source::Pairs });
                assert_eq!(found.p < LEVEL, !verdict(&found).contains("noise only"), "{}", verdict(&found));
                alarms += usize::from(found.p < LEVEL);
                let mean = found.means[0].0;
                outside += usize::from(mean.mean.abs() > mean.half_width());
            }
            println!("{kind:?}, layers {layers}: {alarms} alarms, {outside} intervals without 0, of {PAIRS}");
            // Binomial: 4 are expected of 400 at 1 %, 20 at 5 %.
            assert!(alarms <= 16, "{kind:?} {layers}: {alarms} of {PAIRS}");
            assert!(outside <= 46, "{kind:?} {layers}: {outside} of {PAIRS}");
            assert!(outside > 0 || matches!(kind, Kind::Rare), "intervals hold 0 with {CONFIDENCE}, not always");
        }
    }
}

/// Half a percent, where the standard error of the mean is 0.13 %: 3.9 of these, at a level that takes 2.8.
#[test]
fn a_difference_on_the_whole_is_found() {
    for (factor, word) in [(0.995, "darker"), (1.005, "brighter")] {
        for layers in [true, false] {
            let mut random = Random(77);
            let found = (0..100).filter(|_| {
                let (a, b) = (noisy(&mut random, SIZE, Kind::Even), noisy(&mut random, SIZE, Kind::Even));
                let words = verdict(&compare(SIZE, &a.scaled(SIZE.0, factor, |_, _| true), &b, layers));
                assert!(words.contains("noise only") || words.contains(word), "{words}");
                words.contains(word)
            });
            let found = found.count();
            println!("{factor}, layers {layers}: found in {found} of 100");
            assert!(found >= 70, "{factor} {layers}: {found} of 100");
        }
    }
}

/// A light place and a dark one whose means cancel, in colours that do and in luminance.
#[test]
fn differences_that_cancel_are_found() {
    let mut random = Random(5);
    for layers in [true, false] {
        for _ in 0..20 {
            let (a, b) = (noisy(&mut random, SIZE, Kind::Even), noisy(&mut random, SIZE, Kind::Even));
            let a = a.scaled(SIZE.0, 1.15, |x, y| (20..36).contains(&x) && (4..20).contains(&y));
            let a = a.scaled(SIZE.0, 0.85, |x, y| (20..36).contains(&x) && (24..40).contains(&y));
            let found = compare(SIZE, &a, &b, layers);
            let words = verdict(&found);
            assert!(found.local.is_some_and(|local| local.p < LEVEL), "{words}");
            assert!(words.contains("around pixel (") && !words.contains("noise only"), "{words}");
        }
        // More red and less green, of one luminance.
        let (mut a, b) = (noisy(&mut random, SIZE, Kind::Even), noisy(&mut random, SIZE, Kind::Even));
        for rgb in &mut a.rgb {
            *rgb = [rgb[0] + 0.05 * 0.7152, rgb[1] - 0.05 * 0.2126, rgb[2]];
        }
        let words = verdict(&compare(SIZE, &a, &b, layers));
        assert!(words.contains("brighter by") && words.contains(" in red, darker by"), "{words}");
    }
}

/// Renders of one seed have the same noise: what little they differ by shows, whatever their variances are.
#[test]
fn shared_noise_does_not_hide_a_difference() {
    let mut random = Random(6);
    let b = noisy(&mut random, SIZE, Kind::Even);
    let a = Noisy { rgb: b.rgb.clone(), variance: b.variance.clone() };
    let same = compare(SIZE, &a, &b, true);
    assert!(same.identical && verdict(&same).contains("noise only") && same.p == 1.0);
    let found = compare(SIZE, &a.scaled(SIZE.0, 0.999, |_, _| true), &b, true);
    assert_eq!(found.source, Source::SharedNoise);
    assert!(verdict(&found).starts_with("A is darker by 0.1"), "{}", verdict(&found));
}

/// A filter wider than a pixel: neighbours go together, and the image looks less noisy than its mean is.
#[test]
fn noise_that_neighbours_share_is_called_noise() {
    let mut random = Random(8);
    let (width, height) = (96, 96);
    let mut alarms = 0;
    for _ in 0..100 {
        let mut image = || {
            let noise: Vec<f64> = (0..width * height).map(|_| random.normal()).collect();
            let blurred = |pixel: usize| {
                let (x, y) = (pixel % width, pixel / width);
                let near = (0..9).map(|i| noise[(y + i / 3) % height * width + (x + i % 3) % width]);
                [(1.0 + 0.1 * near.sum::<f64>()) as f32; 3]
            };
            (0..width * height).map(blurred).collect::<Vec<_>>()
        };
        let (a, b) = (image(), image());
        let found = difference(&Images { width, height, a: &a, b: &b, variances: None }).expect("all is finite");
        alarms += usize::from(found.p < LEVEL);
    }
    println!("{alarms} alarms of 100");
    assert!(alarms <= 7, "{alarms} of 100");
}

/// No size and no values make it fail; what cannot be told is not claimed.
#[test]
fn any_images_have_a_verdict() {
    let mut random = Random(9);
    for size in [(1, 1), (1, 2), (2, 1), (3, 3), (1, 100), (17, 5), (33, 4)] {
        let pixels = size.0 * size.1;
        for kind in KINDS {
            let (mut a, b) = (noisy(&mut random, size, kind), noisy(&mut random, size, kind));
            for layers in [true, false] {
                for strange in [1.0, 0.0, -3.0, f32::MAX, f32::MIN_POSITIVE] {
                    a.rgb[pixels / 2] = [strange; 3];
                    let words = verdict(&compare(size, &a, &b, layers));
                    let said = ["noise only", "brighter", "darker"].iter().filter(|word| words.contains(*word)).count();
                    assert!(said >= 1 && !words.contains("NaN") && words.len() < 200, "{size:?}: {words}");
                }
            }
        }
    }
    let (nan, one) = ([[f32::NAN; 3]; 4], [[1.0; 3]; 4]);
    assert!(difference(&Images { width: 2, height: 2, a: &nan, b: &one, variances: None }).is_none());
    // Without noise, what differs differs, but for rounding.
    let constant = |value: f32| vec![[value; 3]; 64];
    let of = |a: f32| {
        let (a, b) = (constant(a), constant(0.5));
        verdict(&difference(&Images { width: 8, height: 8, a: &a, b: &b, variances: None }).expect("all is finite"))
    };
    assert!(
        of(0.5005).contains("brighter by 0.1") && of(0.25).contains("darker by 50.0"),
        "{} {}",
        of(0.5005),
        of(0.25)
    );
    assert!(of(0.500_000_06).contains("noise only"), "{}", of(0.500_000_06));
}
