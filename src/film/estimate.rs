//! The value of a pixel and its variance, from its exact sums.

use super::channels::Splats;
use super::floats::exp2;
use super::pixel::{LEAST_SQUARES, Pixel};
use crate::data::{Rgb, SQUARE_FRACTION, SUM_FRACTION, Sampler};

/// The halves of a pixel: the even runs and the odd ones.
type Halves = [Rgb<f64>; 2];

/// A pixel's sums, from which its value and its variance follow.
///
/// The value is Σ c / N + Σ s / m: camera samples c over their number N in this pixel, and splats s over the light paths m per pixel of the
/// image. Any light path may reach any pixel, so that m is the same for all pixels, whatever their camera samples (Veach, Robust Monte Carlo
/// Methods for Light Transport Simulation, 1997, chapter 10).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Estimate {
    pub pixel: Pixel,
    pub splats: Splats,
    /// The light paths of even and of odd runs per pixel of the full image.
    pub light_paths: [f64; 2],
}

impl Estimate {
    /// The pixel's mean in device units; 0 without samples.
    pub fn mean(&self, channel: usize) -> f64 {
        let [even, odd] = self.splats.halves;
        mean(self.pixel.sum[channel], self.pixel.samples() as f64)
            + mean(even[channel].saturating_add(odd[channel]), self.all_light_paths())
    }

    pub fn means(&self) -> Rgb<f64> {
        [0, 1, 2].map(|channel| self.mean(channel))
    }

    /// The means of the even and of the odd runs.
    pub fn half_means(&self) -> Halves {
        let Pixel { sum, odd_sum, even, odd, .. } = self.pixel;
        let camera = |half: usize, c: usize| match half {
            0 => mean(sum[c].saturating_sub(odd_sum[c]), f64::from(even)),
            _ => mean(odd_sum[c], f64::from(odd)),
        };
        [0, 1].map(|half| [0, 1, 2].map(|c| camera(half, c) + self.splat_mean(half, c)))
    }

    /// The radiance that the light paths of a half bring.
    fn splat_mean(&self, half: usize, channel: usize) -> f64 {
        mean(self.splats.halves[half][channel], self.light_paths[half])
    }

    fn all_light_paths(&self) -> f64 {
        self.light_paths[0] + self.light_paths[1]
    }

    /// The variance of the pixel's mean, in device units squared. `None` if a half has no samples, or a total has saturated.
    pub fn variance(&self, channel: usize, sampler: Sampler) -> Option<f64> {
        let Estimate { pixel, splats: Splats { halves, squares }, .. } = self;
        let sums = [pixel.sum, pixel.squared_deviations, halves[0], halves[1], *squares];
        let saturated = sums.iter().any(|sum| sum[channel] == i128::MAX);
        if saturated || !pixel.has_halves() {
            return None;
        }
        let of_samples = sampler.is_independent().then(|| self.variance_of_samples(channel)).flatten();
        Some(of_samples.unwrap_or_else(|| self.variance_of_halves(channel)))
    }

    /// The variances of all channels.
    pub fn variances(&self, sampler: Sampler) -> Option<Rgb<f64>> {
        Some([self.variance(0, sampler)?, self.variance(1, sampler)?, self.variance(2, sampler)?])
    }

    /// Degrees of freedom of the variance.
    pub fn degrees(&self, sampler: Sampler) -> f64 {
        let known = || (0..3).all(|channel| self.variance_of_samples(channel).is_some());
        match sampler.is_independent() && known() {
            true => (self.pixel.samples() - u64::from(self.pixel.runs)) as f64,
            false => 1.0,
        }
    }

    /// The variance of the pixel's mean by its halves: v = a b (A - B)² / N², with the mean A of a samples in even runs, the mean B of b
    /// samples in odd ones, and N = a + b. The halves have separate scrambles, so they are independent, however the points of one half
    /// are correlated. With the variances V and W of A and B, E[(A - B)²] = V + W, and the pixel's mean a A/N + b B/N has the variance
    /// (a² V + b² W) / N². With a = b, that is the expectation of v. If one half has a run less, v is right for V / W = b / a, as with
    /// independent samples. If the larger half is better than that, v is too large by a factor of at most a/b (own derivation: V a = W b
    /// gives v; V = 0 gives v = a b W / N² instead of b² W / N²).
    ///
    /// A and B include what the light paths of their half bring. Each run has as many light paths, so that they are a : b too, but for
    /// rejected samples and a last run that is shorter.
    fn variance_of_halves(&self, channel: usize) -> f64 {
        // Means are rounded towards 0 by at most 2^-88, so only equal digits cancel.
        let Pixel { sum, odd_sum, even, odd, .. } = self.pixel;
        let mean_odd = odd_sum[channel] / i128::from(odd);
        let mean_even = sum[channel].saturating_sub(odd_sum[channel]) / i128::from(even);
        let sign = if mean_odd < mean_even { -1.0 } else { 1.0 };
        let of_camera = sign * mean_odd.abs_diff(mean_even) as f64 * exp2(-(SUM_FRACTION as i32));
        let difference = of_camera + (self.splat_mean(1, channel) - self.splat_mean(0, channel));
        let all = self.pixel.samples() as f64;
        let weights = (f64::from(even) / all) * (f64::from(odd) / all);
        weights * difference * difference
    }

    /// The variance of the mean of as many independent samples: W / ((N − K) N), with W the squared deviations from the means of K runs, and N
    /// samples in all, because a run of n samples has n − 1 degrees of freedom. The mean of Sobol points has a smaller variance, unless
    /// single samples make most of it. `None` if no run has two samples, or all deviations are too small for the squares' fixed point.
    ///
    /// Splats s add Σ s² / m². A pixel's splats are a few of very many independent light paths, so the number of those of each value is nearly
    /// a Poisson variable, whose variance is its mean. The variance of Σ s is then the expectation of Σ s² (Campbell's theorem: Kingman,
    /// Poisson Processes, 1993, section 3.2). A light path that reaches one pixel by two of its vertices counts as two paths, which is rare.
    fn variance_of_samples(&self, channel: usize) -> Option<f64> {
        let Pixel { squared_deviations, runs, .. } = self.pixel;
        let samples = self.pixel.samples();
        let degrees = samples.checked_sub(u64::from(runs)).filter(|degrees| *degrees > 0)?;
        let divisor = degrees as f64 * samples as f64;
        let of_splats = match self.all_light_paths() {
            0.0 => 0.0,
            light_paths => self.splats.squares[channel] as f64 * divisor / (light_paths * light_paths),
        };
        let squares = squared_deviations[channel] as f64 + of_splats;
        let known = squares >= (LEAST_SQUARES * i128::from(runs)) as f64;
        known.then(|| squares * exp2(-(SQUARE_FRACTION as i32)) / divisor)
    }

    /// The variances of the mean of as many independent samples, or 0 where they are not known.
    pub fn variances_of_samples(&self) -> Rgb<f64> {
        [0, 1, 2].map(|channel| self.variance_of_samples(channel).unwrap_or(0.0))
    }
}

/// A sum in units of 2^-[`SUM_FRACTION`] divided by a count; 0 if the count is 0.
pub(super) fn mean(sum: i128, count: f64) -> f64 {
    if count == 0.0 { 0.0 } else { sum as f64 * exp2(-(SUM_FRACTION as i32)) / count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aov::{Aov, Aovs, SceneSpace};
    use crate::data::{PixelTotals, SampleVariance};
    use crate::film::{Film, Totals, UNKNOWN_VARIANCE, device_bytes, sample_variance_of};
    use crate::job::{Crop, Frame};

    const FULL: (u32, u32) = (2, 2);

    fn fixed(value: f64, fraction: u32) -> i128 {
        (value * exp2(fraction as i32)) as i128
    }

    fn words(sum: i128) -> [u32; 4] {
        [0, 32, 64, 96].map(|shift| (sum >> shift) as u32)
    }

    /// Two pixels of an image of four.
    fn film(sampler: Sampler, aovs: &Aovs, light_paths: bool) -> Film {
        let film = Film::with_sampler(2, 1, 0, sampler).expect("it is small");
        let film = film.of_part(Frame { part: Crop { left: 0, top: 1, width: 2, height: 1 }, full: FULL });
        film.with_channels(aovs, SceneSpace::default(), light_paths).expect("they fit")
    }

    /// A pixel as the device has it: eight samples in two runs, the sums of even runs, of odd ones, the squares, and further sums.
    fn pixel([even, odd, squares]: [Rgb<f64>; 3], more: &[i128], saturated: u32) -> Vec<u8> {
        let mut totals = PixelTotals { samples: [4, 4], runs: 2, saturated, ..PixelTotals::default() };
        let sums = [(even, SUM_FRACTION), (odd, SUM_FRACTION), (squares, SQUARE_FRACTION)];
        let sums = sums.into_iter().flat_map(|(sums, fraction)| sums.map(|sum| fixed(sum, fraction)));
        totals.sums.iter_mut().zip(sums).for_each(|(words_of_sum, sum)| *words_of_sum = words(sum));
        let more = more.iter().flat_map(|sum| words(*sum)).flat_map(u32::to_le_bytes);
        bytemuck::bytes_of(&totals).iter().copied().chain(more).collect()
    }

    /// Splats of even and of odd runs, and their squares.
    fn splats([even, odd, squares]: [Rgb<f64>; 3]) -> Vec<i128> {
        let of = |sums: Rgb<f64>, fraction: u32| sums.map(|sum| fixed(sum, fraction));
        [of(even, SUM_FRACTION), of(odd, SUM_FRACTION), of(squares, SQUARE_FRACTION)].concat()
    }

    const CAMERA: [Rgb<f64>; 3] = [[8.0, 8.0, 8.0], [12.0, 8.0, 12.0], [12.0, 12.0, 0.0]];
    /// Red, a sum of either sign as by a filter with negative lobes, and nothing.
    const SPLATS: [Rgb<f64>; 3] = [[3.0, -3.0, 0.0], [4.5, 1.5, 0.0], [4.5, 2.25, 0.0]];
    /// Two light paths per pixel in even runs, and one in odd ones.
    const TRACED: [u64; 2] = [8, 4];

    fn traced(light_paths: [u64; 2]) -> Totals {
        Totals { light_paths, ..Totals::default() }
    }

    fn lit(sampler: Sampler) -> Film {
        let mut film = film(sampler, &Aovs::default(), true);
        let black = pixel([[0.0; 3]; 3], &splats([[0.0; 3]; 3]), 0);
        film.add_from_device([0, 1], &[pixel(CAMERA, &splats(SPLATS), 0), black].concat(), None);
        film.add([], traced(TRACED));
        film
    }

    #[test]
    fn splats_are_divided_by_the_light_paths_per_pixel_of_the_full_image() {
        let film = lit(Sampler::Sobol);
        let picture = film.develop();
        // 20/8 + 7.5/3, 16/8 - 1.5/3, 20/8.
        assert_eq!(picture.rgb, [[5.0, 1.5, 2.5], [0.0; 3]]);
        assert_eq!(film.estimate(0).half_means(), [[3.5, 0.5, 2.0], [7.5, 3.5, 3.0]]);
        // A quarter of the squared difference of the halves.
        assert_eq!(picture.variance, [[4.0, 2.25, 0.25], [0.0; 3]]);
        assert_eq!(film.mean_radiance(), 2.5);
        // The camera's 12 / (6 · 8), and the splats' squares over 3².
        let independent = lit(Sampler::Independent).develop();
        assert_eq!(independent.rgb, picture.rgb);
        assert_eq!(independent.variance, [[0.75, 0.5, 0.25], [0.0; 3]]);
        assert_eq!(film.estimate(0).variances_of_samples(), [0.75, 0.5, 0.0]);
        // Nothing is divided by no light paths. A half without light paths has what its camera saw.
        let mut none = film.clone();
        none.clear();
        assert!(none.has_light_paths() && none.develop().rgb == [[0.0; 3]; 2]);
        none.add_from_device([0], &pixel(CAMERA, &splats(SPLATS), 0), None);
        assert_eq!(none.developed(0).rgb, [2.5, 2.0, 2.5]);
        none.add([], traced([8, 0]));
        assert_eq!(none.developed(0).rgb, [2.5 + 3.75, 2.0 - 0.75, 2.5]);
        assert_eq!(none.estimate(0).half_means(), [[3.5, 0.5, 2.0], [3.0, 2.0, 3.0]]);
    }

    /// A pixel that only splats light has their variance, with the degrees of freedom of its samples.
    #[test]
    fn splats_alone_make_a_variance() {
        let mut film = film(Sampler::Independent, &Aovs::default(), true);
        film.add_from_device([0], &pixel([[0.0; 3]; 3], &splats([[3.0; 3], [6.0; 3], [4.5; 3]]), 0), None);
        film.add([], traced(TRACED));
        assert_eq!((film.developed(0).rgb, film.developed(0).variance), ([3.0; 3], [0.5; 3]));
        assert_eq!(film.estimate(0).degrees(Sampler::Independent), 6.0);
        // Squares that the fixed point cannot hold: the halves know more.
        let mut film = lit(Sampler::Independent);
        film.clear();
        film.add_from_device([0], &pixel([[0.0; 3]; 3], &splats([[3.0; 3], [4.5; 3], [0.0; 3]]), 0), None);
        film.add([], traced(TRACED));
        assert_eq!(film.developed(0).variance, [2.25; 3]);
    }

    #[test]
    fn variances_of_samples_have_the_part_of_splats() {
        let film = lit(Sampler::Sobol);
        let found = sample_variance_of(&film.words(0), 0, Some([2.0, 1.0]));
        // 12/6 + 8 · 4.5/9: eight times the variance of the mean. Blue has the least square that is known.
        let least = (2.0 * LEAST_SQUARES as f64 * exp2(-96) / 6.0) as f32;
        assert_eq!(found, SampleVariance { variance: [6.0, 4.0, least], degrees: 6, samples: 8 });
        // In scene units.
        assert_eq!(sample_variance_of(&film.words(0), 1, Some([2.0, 1.0])).variance[0], 24.0);
        let camera = sample_variance_of(&film.words(0)[..80], 0, None);
        assert_eq!(camera.variance, [2.0, 2.0, least]);
        assert_eq!(sample_variance_of(&film.words(0), 0, Some([0.0; 2])).variance, camera.variance);
    }

    /// A film without splats has the bits of one without light paths.
    #[test]
    fn films_are_alike_where_no_light_path_has_reached_them() {
        for sampler in [Sampler::Sobol, Sampler::Independent] {
            let aovs = Aovs::default();
            let mut plain = film(sampler, &aovs, false);
            let odd = [[0.1, 0.7, 1e-9], [0.3, 0.2, 5.0], [0.01, 1e-20, 3.0]];
            let pixels = [pixel(CAMERA, &[], 0), pixel(odd, &[], 0)];
            plain.add_from_device([0, 1], &pixels.concat(), None);
            for light_paths in [[0, 0], TRACED] {
                let mut with = film(sampler, &aovs, true);
                let none = splats([[0.0; 3]; 3]).iter().flat_map(|sum| sum.to_le_bytes()).collect::<Vec<u8>>();
                with.add_from_device(
                    [0, 1],
                    &pixels.clone().map(|bytes| [bytes, none.clone()].concat()).concat(),
                    None,
                );
                with.add([], traced(light_paths));
                assert_eq!(with.develop(), plain.develop());
                assert_eq!(with.error_estimate(0.01), plain.error_estimate(0.01));
                assert!(with.error_estimate(0.01).is_some());
                assert_eq!(with.mean_radiance(), plain.mean_radiance());
                let (mine, theirs) = (with.words(1), plain.words(1));
                assert!(mine[..theirs.len()] == theirs && mine[theirs.len()..].iter().all(|word| *word == 0));
                // They cannot be joined all the same.
                assert!(with.merge(&plain).is_err() && plain.merge(&with).is_err());
            }
        }
        assert_eq!(device_bytes(&Aovs::default(), true) - device_bytes(&Aovs::default(), false), 144);
    }

    #[test]
    fn films_are_joined_in_any_order() {
        let part = |number: i32| {
            let mut film = film(Sampler::Sobol, &Aovs::default(), true);
            let times = |sums: [Rgb<f64>; 3]| sums.map(|sums| sums.map(|sum| sum * exp2(-number)));
            film.add_from_device([number as usize % 2], &pixel(times(CAMERA), &splats(times(SPLATS)), 0), None);
            film.add([], Totals { paths: 8, ..traced([5 + number as u64, 3]) });
            film
        };
        let joined = |order: [i32; 3]| {
            let mut film = film(Sampler::Sobol, &Aovs::default(), true);
            order.into_iter().for_each(|number| film.merge(&part(number)).expect("they are of one image"));
            film
        };
        let all = joined([0, 1, 2]);
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            assert_eq!(joined(order), all);
        }
        assert_eq!(all.totals.light_paths, [18, 9]);
        // (3 + 4.5) · (1 + 1/4) splats in (18 + 9) / 4 light paths, and 20 · (1 + 1/4) in 16 samples.
        assert_eq!(all.developed(0).rgb[0], (25.0 / 16.0 + 9.375 / 6.75) as f32);
        assert_ne!(joined([0, 1, 1]), all);
        // Light paths of another full image are not those of this one.
        let other = part(0).of_part(Frame::full((2, 1)));
        let message = part(0).merge(&other).expect_err("they differ").to_string();
        assert!(message.contains("with light paths"), "{message}");
        // Words add up as films do.
        let mut read = film(Sampler::Sobol, &Aovs::default(), true);
        (0..2).for_each(|index| read.add_words(index, &all.words(index)));
        read.add([], all.totals);
        assert_eq!(read, all);
        let mut most = traced(TRACED);
        most += traced([u64::MAX, 1]);
        assert_eq!(most.light_paths, [u64::MAX, 5]);
    }

    #[test]
    fn splats_stand_behind_the_channels_of_aovs() {
        let mut aovs = Aovs::default();
        aovs.set(vec![Aov::Direct, Aov::Indirect]);
        let mut film = film(Sampler::Sobol, &aovs, true);
        let direct = [8.0, 4.0, 20.0].map(|sum| fixed(sum, SUM_FRACTION));
        film.add_from_device([1], &pixel(CAMERA, &[direct.to_vec(), splats(SPLATS)].concat(), 0), None);
        film.add([], traced(TRACED));
        assert_eq!(film.developed(1).rgb, [5.0, 1.5, 2.5]);
        let channels = aovs.channels();
        let values: Vec<f32> = channels.iter().map(|channel| film.channel(1, channel)).collect();
        // Indirect light is the rest, splats included.
        assert_eq!(values, [1.0, 0.5, 2.5, 4.0, 1.0, 0.0]);
        // Each name is that of its word.
        let (names, words) = (film.word_names(), film.words(1));
        assert_eq!((names.len(), words.len()), (80 + 8 * 12, 80 + 8 * 12));
        let value = |name: &str| {
            let word = |number: u32| {
                let name = format!("{name}.{number}");
                i128::from(words[names.iter().position(|other| *other == name).expect("it is a name")])
            };
            (0..8).fold(0, |sum, number| sum | word(number) << (16 * number))
        };
        assert_eq!(value("direct.B"), fixed(20.0, SUM_FRACTION));
        assert_eq!(value("light_even.R"), fixed(3.0, SUM_FRACTION));
        assert_eq!(value("light_even.G"), fixed(-3.0, SUM_FRACTION));
        assert_eq!(value("light_odd.G"), fixed(1.5, SUM_FRACTION));
        assert_eq!(value("light_squares.G"), fixed(2.25, SQUARE_FRACTION));
        assert_eq!(value("light_squares.B"), 0);
    }

    /// The last bit belongs to all sums from it on.
    #[test]
    fn sums_beyond_the_bits_saturate_together() {
        let known = |film: &Film| film.developed(0).variance.map(|variance| variance < UNKNOWN_VARIANCE);
        let saturated = |aovs: &Aovs, bit: u32| {
            let mut film = film(Sampler::Sobol, aovs, true);
            film.add_from_device(
                [0],
                &pixel(CAMERA, &[vec![0; aovs.count()], splats(SPLATS)].concat(), 1 << bit),
                None,
            );
            film.add([], traced(TRACED));
            film
        };
        let none = Aovs::default();
        // Without other channels, each of the sums from 9 on has its bit.
        for sum in 0..9 {
            assert_eq!(known(&saturated(&none, 9 + sum)), [0, 1, 2].map(|channel| channel != sum % 3));
        }
        assert_eq!(saturated(&none, 9).estimate(0).splats.halves[0], [i128::MAX, fixed(-3.0, SUM_FRACTION), 0]);
        let mut all = Aovs::default();
        all.set(Aovs::parse("albedo,normal,depth,position,object,material,direct").expect("they are names"));
        assert_eq!(all.count(), 16);
        for sum in 0..6 {
            assert_eq!(known(&saturated(&all, 25 + sum)), [0, 1, 2].map(|channel| channel != sum % 3));
        }
        let film = saturated(&all, 31);
        assert_eq!(known(&film), [false; 3]);
        assert_eq!((film.estimate(0).splats.squares, film.developed(0).rgb), ([i128::MAX; 3], [5.0, 1.5, 2.5]));
        assert_eq!(film.error_estimate(0.5), None);
        assert_eq!(sample_variance_of(&film.words(0), 0, Some([2.0, 1.0])).variance, [f32::INFINITY; 3]);
    }
}
