//! The verdict of a comparison, on images made of random numbers: how often it calls noise a difference, and which differences it finds.
//!
//! Renders are what it is made for, and docs/comparing.md has how it fares with thousands of them; here the noise is of known kinds.

use crate::common::stats;
use crate::common::stats::Random;
use gpu_rt::metrics::difference::{Difference, ErrorSource, Images, LEVEL, difference};
use gpu_rt::metrics::estimate::CONFIDENCE;
use gpu_rt::metrics::verdict::verdict;

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
    /// Even, but for this many pixels. The noise of each is normal, and 30 times that of the whole mean of the others.
    Ruled(usize),
    /// Even, but for this many pixels. In a half of each a small lamp is met by chance, this many times in the mean.
    Lamps(usize, f64),
    /// Even, but for this many pixels side by side. Half of the halves of each meet a small lamp: no more and no less than once, as Sobol
    /// points do. Where the two halves agree, which is as often as not, the pixel has no variance.
    Bulbs(usize),
}

const KINDS: [Kind; 2] = [Kind::Even, Kind::Rare];

/// Brighter to the right, with two halves of samples a pixel, whose difference tells the variance.
fn noisy(random: &mut Random, size: (usize, usize), kind: Kind) -> Noisy {
    rendered(random, size, kind, 1)
}

/// The same with this many times the samples.
fn rendered(random: &mut Random, (width, height): (usize, usize), kind: Kind, samples: u32) -> Noisy {
    let mut image = Noisy { rgb: Vec::new(), variance: Vec::new() };
    let (pixels, samples) = (width * height, f64::from(samples));
    for pixel in 0..pixels {
        let mean = 0.2 + (pixel % width) as f64 / width as f64;
        // Far from each other, as the golden ratio spreads them.
        let among = |count: usize| (0..count).any(|i| (pixels / 3 + i * 2_654_435_761) % pixels == pixel);
        let even = 0.07 / samples.sqrt();
        let mut half = || match kind {
            Kind::Even => 1.0 + even * random.normal(),
            Kind::Rare => 0.9 + 100.0 * poisson(random, 0.001 * samples) / samples,
            Kind::Ruled(count) if among(count) => 1.0 + 30.0 * (pixels as f64).sqrt() * even * random.normal(),
            Kind::Lamps(count, hits) if among(count) => 1.0 + 20.0 * poisson(random, hits * samples) / (hits * samples),
            Kind::Bulbs(count) if (pixels / 3..pixels / 3 + count).contains(&pixel) => {
                1.0 + 40.0 * if samples > 1.0 { 0.5 } else { random.uniform().round() }
            }
            Kind::Ruled(_) | Kind::Lamps(..) | Kind::Bulbs(_) => 1.0 + even * random.normal(),
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

/// A Poisson number: how many uniform numbers have a product above e^-mean (Knuth); of large means, a normal one.
fn poisson(random: &mut Random, mean: f64) -> f64 {
    if mean > 100.0 {
        return mean + mean.sqrt() * random.normal();
    }
    let mut product = random.uniform();
    let mut count = 0.0;
    while product > (-mean).exp() {
        product *= random.uniform();
        count += 1.0;
    }
    count
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

/// What noise alone is called more than noise in, and the intervals that do not hold 0.
#[derive(Default)]
struct Count {
    alarms: usize,
    outside: usize,
}

impl Count {
    fn add(&mut self, found: &Difference) {
        assert_eq!(found.p < LEVEL, !verdict(found).contains("noise only"), "{}", verdict(found));
        self.alarms += usize::from(found.p < LEVEL);
        let stated = found.rest.iter().map(|(_, means)| means).chain([&found.means]);
        self.outside += usize::from(
            stated.into_iter().any(|means| means[0].0.difference.value.abs() > means[0].0.difference.half_width()),
        );
    }
}

/// The most that a number with this probability in each of `of` trials is, but for a chance of 1e-3. The seeds are pinned: what passes once
/// passes until the noise is drawn anew.
fn allowed(of: usize, probability: f64) -> usize {
    // P(X = k), and with it the tail, by recursion.
    let (mut one, mut tail, mut k) = ((1.0 - probability).powf(of as f64), 1.0, 0);
    while tail - one > 1e-3 {
        tail -= one;
        one *= (of - k) as f64 / (k + 1) as f64 * probability / (1.0 - probability);
        k += 1;
    }
    k
}

/// The whole image judged by its variances alone: the rule that lacks its guard.
fn unguarded(a: &Noisy, b: &Noisy) -> bool {
    let luminance =
        |rgb: [f32; 3]| 0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2]);
    let sum = |image: &Noisy| image.rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>();
    let of = |variance: &[f32; 3]| luminance(variance.map(f32::sqrt)).powi(2);
    let variances: Vec<f64> = a.variance.iter().zip(&b.variance).map(|(a, b)| of(a) + of(b)).collect();
    let (total, squares) = (variances.iter().sum::<f64>(), variances.iter().map(|v| v * v).sum::<f64>());
    let degrees = (3.0 * total * total / squares - 2.0).max(1.0);
    stats::student_two_sided((sum(a) - sum(b)) / total.sqrt(), degrees) < LEVEL / 2.0
}

/// Noise that is called more than noise, and intervals without 0, are as rare as said: binomial numbers. Pairs of like images, and images
/// against one that is nearly the truth, of which a skewed noise is skewed still.
#[test]
fn noise_is_called_noise() {
    assert_eq!([(400, 0.01), (1000, 0.01), (400, 0.05)].map(|(of, share)| allowed(of, share)), [11, 21, 35]);
    let ruled =
        [Kind::Ruled(1), Kind::Ruled(10), Kind::Lamps(1, 1.0), Kind::Lamps(3, 3.0), Kind::Bulbs(1), Kind::Bulbs(3)];
    let large = KINDS.map(|kind| (kind, SIZE, 400));
    let small = ruled.map(|kind| (kind, (16, 16), 400));
    for (seed, (kind, size, pairs)) in (1..).zip(large.into_iter().chain(small)) {
        for samples in [1, 2048] {
            // Most tiles have not met the rare light. Beside the truth all of these are darker, and nothing tells that it is by chance.
            if samples > 1 && matches!(kind, Kind::Rare) {
                continue;
            }
            let mut random = Random(seed);
            let (mut counts, mut without_guard) = ([Count::default(), Count::default()], 0);
            for _ in 0..pairs {
                let (a, b) = (noisy(&mut random, size, kind), rendered(&mut random, size, kind, samples));
                for (layers, count) in [true, false].into_iter().zip(&mut counts) {
                    let found = compare(size, &a, &b, layers);
                    assert_eq!(found.source, if layers { ErrorSource::Variances } else { ErrorSource::Pairs });
                    count.add(&found);
                }
                without_guard += usize::from(unguarded(&a, &b));
            }
            for (layers, Count { alarms, outside }) in [true, false].into_iter().zip(counts) {
                println!(
                    "{kind:?} against {samples}, layers {layers}: {alarms} alarms, {outside} intervals without 0, of {pairs}; unguarded {without_guard}"
                );
                assert!(alarms <= allowed(pairs, LEVEL), "{kind:?} {layers}: {alarms} of {pairs}");
                assert!(outside <= allowed(pairs, 1.0 - CONFIDENCE), "{kind:?} {layers}: {outside} of {pairs}");
                assert!(outside > 0 || !matches!(kind, Kind::Even), "intervals hold 0 with {CONFIDENCE}, not always");
            }
            // What the guard is for: half of the images have the bulb's pixel without variance.
            if samples > 1 && matches!(kind, Kind::Bulbs(1)) {
                assert!(without_guard > pairs / 3, "{without_guard} of {pairs}");
            }
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

/// One pixel hides what the mean of the others shows, and so it is left out, and that is said. Where its two halves agree by chance, in
/// one of 30, nothing is found.
#[test]
fn a_difference_beside_a_pixel_that_rules_the_noise_is_found() {
    let mut random = Random(78);
    let size = (16, 16);
    let mut found = 0;
    for _ in 0..100 {
        let (a, b) = (noisy(&mut random, size, Kind::Ruled(1)), noisy(&mut random, size, Kind::Ruled(1)));
        let difference = compare(size, &a.scaled(size.0, 0.98, |_, _| true), &b, true);
        let words = verdict(&difference);
        found += usize::from(
            words.contains("darker by") && words.contains(" without the pixel that holds most of the noise"),
        );
        assert!(difference.means[0].1 >= LEVEL, "the mean of all tells nothing");
    }
    println!("found in {found} of 100");
    assert!(found >= 70, "{found} of 100");
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
    assert_eq!(found.source, ErrorSource::SharedNoise);
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
