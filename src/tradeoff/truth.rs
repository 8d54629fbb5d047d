//! The reference image of the measurement, with its noise: a file, or the mean of the sweep's own images.

use super::replicates::{Pixels, Weights, difference, distance, signed_bias, squared_mean, sums_of_folds};
use super::sweep::{Subject, Sweep};
use crate::data::luminance;
use crate::metrics::error::{mean_luminance, relative_variance};
use crate::metrics::estimate::{Estimate, degrees_of_sum};
use crate::output::exr::ExrImage;

/// An image and its own noise.
#[derive(Clone, Debug)]
pub struct Truth {
    pub image: Pixels,
    /// The variance of each value, if known.
    pub variance: Option<Pixels>,
    /// Whether its error is reliable, if its file says so.
    pub reliable: Option<bool>,
}

/// The distance of images from a truth, corrected for the noise of both.
#[derive(Clone, Copy, Debug)]
pub struct Distance {
    /// The signed relative difference of the means. Its error includes the noise of both.
    pub signed: Estimate,
    /// The relative MSE minus the expected contribution of the truth's own noise.
    pub squared: Estimate,
    /// The standard error of that contribution.
    pub noise_error: f64,
}

impl Truth {
    /// The image of a file, reduced to a size that divides its own. With the box filter, it equals the image rendered at that size.
    pub fn of_file(file: &ExrImage, size: (u32, u32)) -> Truth {
        let by = file.width / size.0;
        // The variance of a mean of n pixels is an n-th of their mean variance.
        let share = 1.0 / (by as f32 * by as f32);
        let of_mean = |v: &[[f32; 3]]| shrunk(v, file.width, by).iter().map(|p| p.map(|v| v * share)).collect();
        Truth {
            image: shrunk(&file.rgb, file.width, by),
            variance: file.known_variance().map(of_mean),
            reliable: file.reliable(),
        }
    }

    /// The mean of all images of unbiased settings, weighted by their samples. The images of the subject `without` are
    /// left out, because no image should be judged by itself.
    pub fn pooled(sweep: &Sweep<'_>, without: Option<usize>) -> Option<Truth> {
        Truth::joined(sweep, 0, |i, subject| Some(i) != without && subject.setting.declared_unbiased())
    }

    /// The mean of all images of unbiased settings after the first round. It shares no random numbers with the images of that round.
    pub fn after_first_round(sweep: &Sweep<'_>) -> Option<Truth> {
        Truth::joined(sweep, 1, |_, subject| subject.setting.declared_unbiased())
    }

    /// The mean of all images of one subject.
    pub fn of_subject(sweep: &Sweep<'_>, own: usize) -> Option<Truth> {
        Truth::joined(sweep, 0, |i, _| i == own)
    }

    /// Leaves out the first `skipped` images of each number of samples.
    fn joined(sweep: &Sweep<'_>, skipped: usize, takes: impl Fn(usize, &Subject) -> bool) -> Option<Truth> {
        // Two halves: the even and the odd rounds. Images of one round share their random numbers, but the two halves
        // share none, so that their difference measures the noise for any number of settings.
        let taken = sweep.subjects.iter().enumerate().filter(|(i, subject)| takes(*i, subject));
        let blocks = taken.flat_map(|(_, subject)| &subject.blocks).flat_map(|(&samples, blocks)| {
            let images = blocks.iter().enumerate().skip(skipped);
            images.map(move |(round, block)| (round, samples, &block.image))
        });
        let [(mut even, a), (mut odd, b)] = sums_of_folds(blocks);
        let count = even.len().max(odd.len());
        [&mut even, &mut odd].into_iter().for_each(|sums| sums.resize(count, [0.0; 3]));
        let total = a + b;
        let mean = |(x, y): (&[f64; 3], &[f64; 3])| std::array::from_fn(|c| ((x[c] + y[c]) / total) as f32);
        // Var X = σ²/a and Var Y = σ²/b. The variance of their mean is σ²/(a + b) = ab/(a + b)² E (X - Y)².
        let variance = |(x, y): (&[f64; 3], &[f64; 3])| {
            std::array::from_fn(|c| ((x[c] / a - y[c] / b).powi(2) * a * b / (total * total)) as f32)
        };
        let pixels = || even.iter().zip(&odd);
        (total > 0.0).then(|| Truth {
            image: pixels().map(mean).collect(),
            variance: (a > 0.0 && b > 0.0).then(|| pixels().map(variance).collect()),
            reliable: None,
        })
    }

    /// The relative MSE of the truth's own noise, with weights from this image or a less noisy one.
    pub fn error(&self, weights: &Weights) -> Option<f64> {
        relative_variance(self.variance.as_ref()?, &weights.image, weights.floor)
    }

    /// The relative MSE of an image against the truth, minus the expected contribution of the truth's own noise.
    pub fn error_of(&self, image: &Pixels, weights: &Weights) -> f64 {
        distance(image, &self.image, weights) - self.error(weights).unwrap_or(0.0)
    }

    /// The distance of the images' expectation from the truth, with weights from another image. None if the truth's own
    /// noise is unknown, or for fewer than three images.
    pub fn distance(&self, images: &[Pixels], weights: &Weights) -> Option<Distance> {
        let variance = self.variance.as_ref()?;
        let count = (3 * self.image.len()) as f64;
        let mean = mean_luminance(&self.image);
        let of_images = |at: usize, c: usize| images.iter().map(|i| f64::from(i[at][c])).sum::<f64>();
        // Sums and sums of squares of each pixel's contributions: its standard deviations to the mean of the image, and
        // its relative variances to the relative MSE. Its channels are assumed to be fully correlated, which gives the largest
        // variance.
        let (mut of_mean, mut of_mean2, mut own, mut own2, mut with_bias) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (at, (pixel, variance)) in self.image.iter().zip(variance).enumerate() {
            let deviation = luminance(variance.map(|v| f64::from(v).sqrt()));
            let (mut relative, mut product) = (0.0, 0.0);
            for c in 0..3 {
                let weight = 1.0 / (f64::from(weights.image[at][c]).powi(2) + weights.floor);
                let v = f64::from(variance[c]);
                let off = of_images(at, c) / images.len() as f64 - f64::from(pixel[c]);
                relative += weight * v;
                product += weight * off.abs() * v.sqrt();
            }
            of_mean += deviation * deviation;
            of_mean2 += deviation.powi(4);
            own += relative;
            own2 += relative * relative;
            with_bias += product * product;
        }
        let same = vec![self.image.clone(); images.len()];
        let signed = signed_bias(images, &same, &self.image)?;
        let differences: Vec<Pixels> = images.iter().map(|image| difference(image, &self.image)).collect();
        let squared = squared_mean(&differences, weights, 1)?;
        // The variance of (b + e)² minus an estimate of E e² has three parts. e² contributes 2 σ⁴. An estimate with one
        // degree of freedom contributes 2 σ⁴, and the expectation of its square is 3 σ⁴. With more degrees the estimate
        // contributes less, and its square is about σ⁴. Twice the square is enough in both cases. The product 2 b e
        // contributes 4 b² σ².
        let squared_noise = (2.0 * own2 + 4.0 * with_bias) / (count * count);
        Some(Distance {
            signed: joined(
                signed,
                of_mean / (self.image.len() as f64 * mean).powi(2),
                degrees_of_sum(of_mean, of_mean2),
            ),
            squared: joined(
                Estimate { value: squared.value - own / count, ..squared },
                squared_noise,
                degrees_of_sum(own, own2),
            ),
            // The variance of an estimate with one degree of freedom is 2 σ⁴, two thirds of the expectation of its square.
            noise_error: (2.0 / 3.0 * own2).sqrt() / count,
        })
    }
}

/// An estimate with additional noise. `degrees` are the degrees of freedom of its variance (Welch, Biometrika 34, 1947).
fn joined(own: Estimate, variance: f64, degrees: f64) -> Estimate {
    let (a, b) = (own.error * own.error, variance);
    if b <= 0.0 {
        return own;
    }
    Estimate { error: (a + b).sqrt(), degrees: (a + b).powi(2) / (a * a / own.degrees + b * b / degrees), ..own }
}

/// The means over blocks of `by` times `by` pixels.
fn shrunk(image: &[[f32; 3]], width: u32, by: u32) -> Pixels {
    let (width, by) = (width as usize, by as usize);
    let block = |x: usize, y: usize| {
        let rows = (y * by..(y + 1) * by).map(|row| row * width);
        let pixels = rows.flat_map(|row| &image[row + x * by..row + (x + 1) * by]);
        let sum = pixels.fold([0.0f64; 3], |sum, p| std::array::from_fn(|c| sum[c] + f64::from(p[c])));
        sum.map(|v| (v / (by * by) as f64) as f32)
    };
    let blocks = (0..image.len() / width / by).flat_map(|y| (0..width / by).map(move |x| (x, y)));
    blocks.map(|(x, y)| block(x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::UNKNOWN_VARIANCE;
    use crate::metrics::error::floor_of;
    use crate::tradeoff::replicates::tests::Random;

    const MEAN: f64 = 0.5;

    fn weights() -> Weights {
        Weights::of_image(vec![[MEAN as f32; 3]; 400], floor_of)
    }

    /// An image and its variance, from two noisy halves.
    fn truth(random: &mut Random, deviation: f64) -> Truth {
        let halves = random.images(2, MEAN, deviation * 2f64.sqrt());
        let joined = |of: fn(f32, f32) -> f32| {
            let pairs = halves[0].iter().zip(&halves[1]);
            pairs.map(|(a, b)| std::array::from_fn(|c| of(a[c], b[c]))).collect()
        };
        Truth {
            image: joined(|a, b| 0.5 * (a + b)),
            variance: Some(joined(|a, b| 0.25 * (a - b) * (a - b))),
            reliable: None,
        }
    }

    #[test]
    fn a_truth_tells_its_own_error() {
        let error = truth(&mut Random(1), 0.1).error(&weights()).unwrap();
        // The standard error from 1200 values with one degree of freedom is 4 %.
        let expected = 0.01 / (MEAN * MEAN * 1.01);
        assert!((error / expected - 1.0).abs() < 0.2, "{error} {expected}");
        assert_eq!(Truth { variance: None, ..truth(&mut Random(1), 0.1) }.error(&weights()), None);
        // The error of an equally noisy image has twice that, and half of it is subtracted.
        let of_image = truth(&mut Random(1), 0.1).error_of(&Random(2).images(1, MEAN, 0.1)[0], &weights());
        assert!((of_image / expected - 1.0).abs() < 0.2, "{of_image} {expected}");
    }

    /// Images with little noise, so that nearly all noise is that of the truth.
    #[test]
    fn the_noise_of_a_truth_is_subtracted_and_is_in_the_intervals() {
        for (bias, deviation) in [(0.0, 0.1), (0.02, 0.1), (0.02, 0.02)] {
            let mut random = Random(23);
            let expected = bias * bias / (MEAN * MEAN * 1.01);
            let [mut signed, mut squared, mut not_subtracted] = [0; 3];
            for _ in 0..400 {
                let truth = truth(&mut random, deviation);
                let found = truth.distance(&random.images(6, MEAN + bias, 0.01), &weights()).unwrap();
                let within = |value: f64, estimate: Estimate| (value - estimate.value).abs() <= estimate.half_width();
                signed += u32::from(within(bias / MEAN, found.signed));
                squared += u32::from(within(expected, found.squared));
                let own = truth.error(&weights()).unwrap();
                not_subtracted += u32::from(within(expected - own, found.squared));
            }
            // 5 % of the intervals miss the value, and 2.5 % more do so once in 50 times. Uncorrelated channels make
            // the intervals wider than necessary.
            assert!(signed >= 370 && squared >= 370, "{bias} {deviation}: {signed} {squared}");
            assert!(not_subtracted < 40, "{bias} {deviation}: {not_subtracted}");
        }
    }

    #[test]
    fn a_file_is_made_smaller_with_its_variance() {
        let image = |f: fn(usize) -> f32| (0..24).map(|i| [f(i); 3]).collect::<Vec<_>>();
        let mut file = ExrImage {
            width: 6,
            height: 4,
            rgb: image(|i| i as f32),
            variance: Some(image(|i| (i % 2) as f32)),
            ..ExrImage::default()
        };
        let found = Truth::of_file(&file, (3, 2));
        assert_eq!(found.image, [3.5, 5.5, 7.5, 15.5, 17.5, 19.5].map(|v| [v; 3]));
        assert_eq!(found.variance, Some(vec![[0.125; 3]; 6]));
        assert_eq!(Truth::of_file(&file, (6, 4)).image, file.rgb);
        // One pixel of unknown variance is enough.
        file.variance.as_mut().unwrap()[7] = [UNKNOWN_VARIANCE; 3];
        assert_eq!(Truth::of_file(&file, (3, 2)).variance, None);
    }
}
