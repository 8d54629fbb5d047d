//! The verdict of a comparison, on images made of random numbers: how often it calls noise a difference, and which differences it finds.
//!
//! Renders are what it is made for, and docs/comparing.md has how it fares with thousands of them; here the noise is of known kinds.

use crate::common::stats;
use crate::common::stats::Random;
use gpu_rt::data::SampleVariance;
use gpu_rt::metrics::difference::{Difference, ErrorSource, difference};
use gpu_rt::metrics::estimate::{CONFIDENCE, LEVEL};
use gpu_rt::metrics::images::{Images, SampleVariances};
use gpu_rt::metrics::pixels::Pixels;
use gpu_rt::metrics::verdict::verdict;

/// An image and the variances of its pixels, as a render delivers them.
struct Noisy {
    rgb: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Equal everywhere, 5 % of the pixel.
    Even,
    /// A hundredth of the samples bring a hundred times the mean: few pixels hold nearly all of the noise.
    Rare,
    /// Even, but for this many pixels. The noise of each is normal, and 30 times that of the mean of all others.
    Ruled(usize),
    /// Even, but for this many pixels. In a half of each a small lamp is met by chance, this many times in the mean.
    Lamps(usize, f64),
    /// Even, but for this many pixels side by side. Half of the halves of each meet a small lamp: no more and no less than once, as Sobol
    /// points do. Where the two halves agree, which is as often as not, the pixel has no variance.
    Bulbs(usize),
}

const KINDS: [Kind; 2] = [Kind::Even, Kind::Rare];

/// Brighter to the right, with two halves of samples a pixel, whose difference gives the variance.
fn noisy(random: &mut Random, size: (usize, usize), kind: Kind) -> Noisy {
    rendered(random, size, kind, 1)
}

/// A noisy image of this many times the samples.
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
    difference(&Images { width, height, a: &a.rgb, b: &b.rgb, variances, sample_variances: None })
        .expect("all is finite")
}

impl Noisy {
    /// Scaled where `contains` holds.
    fn scaled(mut self, width: usize, factor: f32, contains: impl Fn(usize, usize) -> bool) -> Noisy {
        for (pixel, (rgb, variance)) in self.rgb.iter_mut().zip(&mut self.variance).enumerate() {
            if contains(pixel % width, pixel / width) {
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

/// The full image judged by its variances alone: the rule without its guard.
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
            // Most tiles lack the rare light. All of these are darker than the truth, and nothing shows that this is by chance.
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
fn a_difference_of_the_means_is_found() {
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
fn a_difference_next_to_a_pixel_that_rules_the_noise_is_found() {
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

/// A light region and a dark one whose means cancel, in colours that do and in luminance.
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
        let found = difference(&Images { width, height, a: &a, b: &b, variances: None, sample_variances: None })
            .expect("all is finite");
        alarms += usize::from(found.p < LEVEL);
    }
    println!("{alarms} alarms of 100");
    assert!(alarms <= 7, "{alarms} of 100");
}

/// Discs of random sizes and brightness, seen from this many pixels to the right and below, without noise.
fn discs(random: &mut Random, (width, height): (usize, usize), count: usize) -> impl Fn(f64, f64) -> Vec<f64> {
    let disc = |random: &mut Random| {
        let at = [random.uniform() * width as f64, random.uniform() * height as f64];
        (at, 2.0 + 8.0 * random.uniform(), 0.1 + random.uniform())
    };
    let discs: Vec<_> = (0..count).map(|_| disc(random)).collect();
    move |right: f64, down: f64| {
        let value = |pixel: usize| {
            let (x, y) = ((pixel % width) as f64 + right, (pixel / width) as f64 + down);
            let inside = |(at, radius, bright): &([f64; 2], f64, f64)| {
                bright * (radius - (x - at[0]).hypot(y - at[1]) + 0.5).clamp(0.0, 1.0)
            };
            0.3 + discs.iter().map(inside).sum::<f64>()
        };
        (0..width * height).map(value).collect()
    }
}

/// Without variances of samples, an image that is shifted is found by its edges, and noise is not called a shift: noise of single pixels, rare
/// bright noise, and noise that neighbours share; of like images, and of one against the truth.
#[test]
fn a_shift_is_found_and_noise_is_no_shift() {
    let size = SIZE;
    let mut random = Random(21);
    // The noise of a pixel, relative to its value, of mean 0.
    type Noise = fn(&mut Random, usize, usize) -> Vec<f64>;
    let even: Noise = |random, width, height| (0..width * height).map(|_| 0.1 * random.normal()).collect();
    let rare: Noise =
        |random, width, height| (0..width * height).map(|_| 0.1 * (poisson(random, 0.1) / 0.1 - 1.0)).collect();
    let shared: Noise = |random, width, height| {
        let own: Vec<f64> = (0..width * height).map(|_| 0.1 * random.normal()).collect();
        let near = |pixel: usize, i: usize| {
            own[(pixel / width + i / 3) % height * width + (pixel % width + i % 3) % width] / 3.0
        };
        (0..width * height).map(|pixel| (0..9).map(|i| near(pixel, i)).sum()).collect()
    };
    for (name, noise) in [("even", even), ("rare", rare), ("shared", shared)] {
        let mut picture = |values: &[f64], is_noisy: bool| -> Vec<[f32; 3]> {
            let noise = noise(&mut random, size.0, size.1);
            let value = |(value, noise): (&f64, f64)| [(value * if is_noisy { 1.0 + noise } else { 1.0 }) as f32; 3];
            values.iter().zip(noise).map(value).collect()
        };
        let judge = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            let images = Images { width: size.0, height: size.1, a, b, variances: None, sample_variances: None };
            difference(&images).expect("all is finite")
        };
        let mut of_discs = Random(22);
        let (mut alarms, mut found) = (0, [0; 4]);
        const PAIRS: usize = 100;
        for pair in 0..PAIRS {
            let image = discs(&mut of_discs, size, 30);
            let a = picture(&image(0.0, 0.0), true);
            let b = picture(&image(0.0, 0.0), pair % 2 == 0);
            alarms += usize::from(judge(&a, &b).pixels.p() < LEVEL);
            for ((right, down), found) in [(1.0, 0.0), (0.0, -1.0), (0.7, 0.7), (0.5, 0.0)].into_iter().zip(&mut found)
            {
                let shifted = judge(&picture(&image(right, down), true), &b);
                let words = verdict(&shifted);
                assert!(
                    words.contains("noise only") || words.contains("brighter") || words.contains("darker"),
                    "{words}"
                );
                *found += usize::from(shifted.pixels.p() < LEVEL && !words.contains("noise only"));
            }
        }
        println!("{name}: {alarms} alarms, {found:?} shifts found of {PAIRS}");
        // A twelfth of the level.
        assert!(alarms <= allowed(PAIRS, LEVEL / 12.0), "{name}: {alarms} of {PAIRS}");
        assert!(found[..3].iter().all(|found| *found >= PAIRS * 19 / 20), "{name}: {found:?} of {PAIRS}");
    }
}

/// No size and no values make it fail; what cannot be known is not claimed.
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
    assert!(
        difference(&Images { width: 2, height: 2, a: &nan, b: &one, variances: None, sample_variances: None })
            .is_none()
    );
    // Without noise, what differs differs, but for rounding.
    let constant = |value: f32| vec![[value; 3]; 64];
    let of = |a: f32| {
        let (a, b) = (constant(a), constant(0.5));
        verdict(
            &difference(&Images { width: 8, height: 8, a: &a, b: &b, variances: None, sample_variances: None })
                .expect("all is finite"),
        )
    };
    assert!(
        of(0.5005).contains("brighter by 0.1") && of(0.25).contains("darker by 50.0"),
        "{} {}",
        of(0.5005),
        of(0.25)
    );
    assert!(of(0.500_000_06).contains("noise only"), "{}", of(0.500_000_06));
}

/// How the samples of a pixel are distributed.
#[derive(Clone, Copy, Debug)]
enum Samples {
    /// Normal, with a standard deviation of 30 % of the mean.
    Normal,
    /// A twentieth of them is a hundred times as bright as the others, as beside a small lamp.
    Rare,
    /// Half of them is black.
    Half,
    /// Their variance is infinite: P(x > t) = t^-1.5.
    Heavy,
    /// This share of them brings all light.
    Seldom(f64),
}

const SAMPLES: [Samples; 4] = [Samples::Normal, Samples::Rare, Samples::Half, Samples::Heavy];

impl Samples {
    fn draw(self, random: &mut Random) -> f64 {
        match self {
            Samples::Normal => 1.0 + 0.3 * random.normal(),
            Samples::Rare => 1.0 + if random.uniform() < 0.05 { 99.0 } else { 0.0 },
            Samples::Half => 2.0 * random.uniform().round(),
            Samples::Heavy => (1.0 - random.uniform()).powf(-1.0 / 1.5),
            Samples::Seldom(share) => {
                if random.uniform() < share {
                    1.0 / share
                } else {
                    0.0
                }
            }
        }
    }
}

/// An image of so many samples a pixel, with all that a film knows of them.
struct Sampled {
    noisy: Noisy,
    sample_variances: Vec<SampleVariance>,
}

impl Sampled {
    fn new(random: &mut Random, (width, height): (usize, usize), kind: Samples, count: u32) -> Sampled {
        let mut image =
            Sampled { noisy: Noisy { rgb: Vec::new(), variance: Vec::new() }, sample_variances: Vec::new() };
        for pixel in 0..width * height {
            let brightness = 0.2 + (pixel % width) as f64 / width as f64;
            let samples: Vec<f64> = (0..count).map(|_| brightness * kind.draw(random)).collect();
            let mean = |samples: &[f64]| samples.iter().sum::<f64>() / samples.len() as f64;
            let squares: f64 =
                samples.chunks(8).map(|run| run.iter().map(|s| (s - mean(run)).powi(2)).sum::<f64>()).sum();
            let half = samples.len() / 2;
            let (centre, apart) = (mean(&samples), 0.5 * (mean(&samples[..half]) - mean(&samples[half..])));
            let degrees = count - count.div_ceil(8);
            let colour = [1.0, 0.8, 0.5];
            image.noisy.rgb.push(colour.map(|c| (c * centre) as f32));
            image.noisy.variance.push(colour.map(|c: f64| (c * c * apart * apart) as f32));
            let variance = colour.map(|c: f64| (c * c * squares / f64::from(degrees)) as f32);
            image.sample_variances.push(SampleVariance { variance, degrees, samples: count });
        }
        image
    }

    fn against(&self, other: &Sampled, (width, height): (usize, usize), alike: bool) -> Difference {
        let (a, b) = (&self.noisy, &other.noisy);
        let variances = Some([a.variance.as_slice(), b.variance.as_slice()]);
        let sample_variances =
            Some(SampleVariances { images: [&self.sample_variances, &other.sample_variances], alike });
        difference(&Images { width, height, a: &a.rgb, b: &b.rgb, variances, sample_variances }).expect("all is finite")
    }

    /// Whether a pixel differs by the variance of its two halves, with one degree of freedom: the rule that such a variance suggests.
    fn differs_by_halves(&self, other: &Sampled) -> bool {
        let pixels =
            self.noisy.rgb.iter().zip(&self.noisy.variance).zip(other.noisy.rgb.iter().zip(&other.noisy.variance));
        let level = stats::sidak(LEVEL, self.noisy.rgb.len());
        let mut ps = pixels.map(|((a, v), (b, w))| {
            let z = f64::from(a[0] - b[0]) / (f64::from(v[0]) + f64::from(w[0])).sqrt();
            if a[0] == b[0] { 1.0 } else { stats::student_two_sided(z, 1.0) }
        });
        ps.any(|p| p < level)
    }
}

/// No noise of samples makes a pixel differ, be they few or many in either image. The control is the rule that takes the variance of a pixel
/// from its halves.
#[test]
fn noise_of_single_pixels_is_called_noise() {
    let size = (32, 24);
    let mut by_halves = 0;
    for (seed, kind) in (20..).zip(SAMPLES) {
        for counts in [(16, 16), (64, 64), (16, 512), (512, 16)] {
            let mut random = Random(seed);
            let (mut alarms, pairs) = (0, 25);
            for _ in 0..pairs {
                let [a, b] = [counts.0, counts.1].map(|count| Sampled::new(&mut random, size, kind, count));
                let found = a.against(&b, size, true).pixels;
                assert!(matches!(found, Pixels::Tested { .. }), "{found:?}");
                alarms += usize::from(found.p() < LEVEL);
                by_halves += usize::from(a.differs_by_halves(&b));
            }
            println!("{kind:?}, {counts:?} samples: {alarms} alarms of {pairs}");
            assert!(alarms <= allowed(pairs, LEVEL / 12.0), "{kind:?} {counts:?}: {alarms} of {pairs}");
        }
    }
    println!("by halves {by_halves} of 400");
    assert!(by_halves > 40, "{by_halves} of 400");
}

/// By other settings, the light of each pixel comes from few samples of one image, and from all samples of the other. Where no sample has
/// contributed, the pixels around it show what it would have contributed. The control takes the settings for the same.
#[test]
fn samples_that_find_light_more_seldom_make_no_difference() {
    let size = (32, 24);
    let mut alarms = [0, 0];
    for hits in [0.03, 0.06, 0.12] {
        let mut random = Random(50);
        for _ in 0..25 {
            let seldom = Sampled::new(&mut random, size, Samples::Seldom(hits), 64);
            let often = Sampled::new(&mut random, size, Samples::Normal, 64);
            for (alarms, alike) in alarms.iter_mut().zip([false, true]) {
                *alarms += usize::from(seldom.against(&often, size, alike).pixels.p() < LEVEL);
            }
        }
    }
    println!("{alarms:?} alarms of 75");
    assert!(alarms[0] <= allowed(75, LEVEL / 12.0) && alarms[1] > 20, "{alarms:?} of 75");
}

/// One pixel, in all channels or in one, between images with noise of their own.
#[test]
fn a_pixel_beyond_its_noise_is_found() {
    let size = (32, 24);
    for (count, factors) in [(16, &[100.0, 10.0][..]), (64, &[100.0, 2.0, 0.0]), (256, &[100.0, 1.5, 0.5, 0.0])] {
        for &factor in factors {
            for channels in [0..3, 1..2] {
                let mut random = Random(31);
                let found = (0..20).filter(|_| {
                    let [mut a, b] = [(); 2].map(|()| Sampled::new(&mut random, size, Samples::Normal, count));
                    let pixel = random.below(size.0 * size.1);
                    a.noisy.rgb[pixel][channels.clone()].iter_mut().for_each(|v| *v *= factor);
                    let words = verdict(&a.against(&b, size, true));
                    let direction = if factor > 1.0 { "A is brighter by " } else { "A is darker by " };
                    words.starts_with(direction)
                        && words.contains(&format!(" in pixel ({}, {}), p = ", pixel % size.0, pixel / size.0))
                });
                let found = found.count();
                println!("{count} samples, times {factor}, channels {channels:?}: found in {found} of 20");
                assert!(found >= 19, "{count} {factor}: {found} of 20");
            }
        }
    }
}

/// Where nearly all noisy pixels are equal to the bit, the others differ by more than noise: in luminance and in one colour, with variances
/// and without, in floats of 32 bits and of 16.
#[test]
fn differing_pixels_beside_equal_ones_are_found() {
    let mut random = Random(40);
    let (width, height) = SIZE;
    let (b, spiky) = (noisy(&mut random, SIZE, Kind::Even), noisy(&mut random, SIZE, Kind::Lamps(300, 0.5)));
    let half = |v: f32| f32::from_bits(v.to_bits() & !0x1fff);
    let halves = Noisy { rgb: b.rgb.iter().map(|rgb| rgb.map(half)).collect(), variance: b.variance.clone() };
    let one = |x: usize, y: usize| (x, y) == (24, 39);
    let block = |x: usize, y: usize| (24..26).contains(&x) && (38..40).contains(&y);
    let edge = |_: usize, y: usize| y == height - 1;
    type Region<'a> = (&'a str, usize, &'a dyn Fn(usize, usize) -> bool);
    let regions: [Region<'_>; 3] = [("(24, 39)", 1, &one), ("(2", 4, &block), ("(", width, &edge)];
    for (b, layers) in [(&b, true), (&b, false), (&spiky, true), (&spiky, false), (&halves, false)] {
        for (at, count, contains) in regions {
            for channels in [0..3, 0..1, 2..3] {
                for factor in [100.0, 2.0, 1.01, 0.5, 0.0] {
                    let mut a = Noisy { rgb: b.rgb.clone(), variance: b.variance.clone() };
                    for (pixel, rgb) in a.rgb.iter_mut().enumerate() {
                        if contains(pixel % width, pixel / width) {
                            rgb[channels.clone()].iter_mut().for_each(|v| *v *= factor);
                        }
                    }
                    let found = compare(SIZE, &a, b, layers);
                    let words = verdict(&found);
                    let direction = if factor > 1.0 { "A is brighter by " } else { "A is darker by " };
                    assert!(words.starts_with(direction) && words.contains(at), "{count} times {factor}: {words}");
                    match found.pixels {
                        Pixels::Shared { differing, .. } => assert_eq!(differing, count, "{words}"),
                        other => panic!("{other:?}: {words}"),
                    }
                }
            }
        }
    }
    // The last digit of floats is no difference, nor are equal black pixels a proof: a lamp before a black sky has noise at its edge alone.
    let mut rounded = Noisy { rgb: b.rgb.clone(), variance: b.variance.clone() };
    rounded.rgb[77] = rounded.rgb[77].map(f32::next_up);
    assert!(verdict(&compare(SIZE, &rounded, &b, true)).contains("noise only"));
    let mut alarms = 0;
    for _ in 0..200 {
        let mut lamp = || {
            let mut image = Noisy { rgb: vec![[0.0; 3]; width * height], variance: vec![[0.0; 3]; width * height] };
            for pixel in (1000..1010).chain(2000..2010) {
                let halves = [random.uniform().round(), random.uniform().round()];
                image.rgb[pixel] = [(halves[0] + halves[1]) as f32; 3];
                image.variance[pixel] = [(halves[0] - halves[1]).abs() as f32; 3];
            }
            image
        };
        let [a, b] = [lamp(), lamp()];
        for layers in [true, false] {
            alarms += usize::from(matches!(compare(SIZE, &a, &b, layers).pixels, Pixels::Shared { .. }));
        }
    }
    assert_eq!(alarms, 0);
}
