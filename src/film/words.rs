//! The exact totals of pixels as words of 16 bits, for files. Sums are in two's complement.

use super::Film;
use super::channels::{self, Splats};
use super::floats::exp2;
use super::mattes;
use super::pixel::{LEAST_SQUARES, Pixel};
use crate::aov::Aovs;
use crate::data::{CHANNELS, SQUARE_FRACTION, SampleVariance};

/// Words of a sum of 128 bits.
const OF_SUM: usize = 8;
/// Words of a pixel without further channels: nine sums, and four counts of 32 bits.
const OF_PIXEL: usize = 9 * OF_SUM + 4 * 2;

fn put_sums<'a>(values: impl Iterator<Item = &'a i128>, words: &mut [u16]) {
    for (words, value) in words.as_chunks_mut::<OF_SUM>().0.iter_mut().zip(values) {
        *words = std::array::from_fn(|word| (value >> (16 * word)) as u16);
    }
}

fn sums_of(words: &[u16]) -> impl Iterator<Item = i128> {
    let sum = |words: &[u16; OF_SUM]| words.iter().rev().fold(0, |value, word| value << 16 | i128::from(*word));
    words.as_chunks::<OF_SUM>().0.iter().map(sum)
}

fn put_counts(values: &[u32], words: &mut [u16]) {
    for (words, value) in words.as_chunks_mut::<2>().0.iter_mut().zip(values) {
        *words = [*value as u16, (value >> 16) as u16];
    }
}

fn counts_of(words: &[u16]) -> impl Iterator<Item = u32> {
    words.as_chunks::<2>().0.iter().map(|[low, high]| u32::from(*low) | u32::from(*high) << 16)
}

impl Pixel {
    fn put(&self, words: &mut [u16]) {
        let (sums, counts) = words.split_at_mut(9 * OF_SUM);
        put_sums(self.sum.iter().chain(&self.odd_sum).chain(&self.squared_deviations), sums);
        put_counts(&[self.even, self.odd, self.runs, self.rejected], counts);
    }

    fn of_words(words: &[u16]) -> Pixel {
        let (sums, counts) = words.split_at(9 * OF_SUM);
        let sums: Vec<i128> = sums_of(sums).collect();
        let rgb = |first: usize| [sums[first], sums[first + 1], sums[first + 2]];
        let counts: Vec<u32> = counts_of(counts).collect();
        Pixel {
            sum: rgb(0),
            odd_sum: rgb(3),
            squared_deviations: rgb(6),
            even: counts[0],
            odd: counts[1],
            runs: counts[2],
            rejected: counts[3],
        }
    }

    /// The variance of the samples in scene units. Squares below the smallest known value count as that value, which bounds them.
    ///
    /// The mean's variance has the part Σ s² / m² of splats ([`super::estimate`]). So N times this part counts as variance of the N camera
    /// samples: it then has its share in the mean's variance, and does not depend on N if the light paths are in proportion to the samples.
    fn sample_variance(&self, splats: &Splats, exponent: i32, light_paths: f64) -> SampleVariance {
        let samples = u32::try_from(self.samples()).unwrap_or(u32::MAX);
        let degrees = samples.saturating_sub(self.runs);
        let of_splats = |squares: i128| match light_paths {
            0.0 => 0.0,
            light_paths => squares as f64 * f64::from(samples) / (light_paths * light_paths),
        };
        let variance = |channel: usize| match (self.squared_deviations[channel], splats.squares[channel], degrees) {
            (i128::MAX, ..) | (_, i128::MAX, _) | (.., 0) => f32::INFINITY,
            (squares, of_light, _) => {
                let squares = squares.max(LEAST_SQUARES * i128::from(self.runs));
                let squares = squares as f64 / f64::from(degrees) + of_splats(of_light);
                let scale = exp2(exponent);
                (squares * exp2(-(SQUARE_FRACTION as i32)) * scale * scale) as f32
            }
        };
        SampleVariance { variance: [0, 1, 2].map(variance), degrees, samples }
    }
}

/// The variance of a pixel's samples, by its words in a film of this exponent. `light_paths` are those of even and of odd runs per pixel of
/// the full image, if the film has light paths.
pub fn sample_variance_of(words: &[u16], exponent: i32, light_paths: Option<[f64; 2]>) -> SampleVariance {
    let (of_pixel, rest) = words.split_at(OF_PIXEL);
    let splats = match light_paths {
        Some(_) => Splats::of_sums(&sums_of(&rest[rest.len() % OF_SUM..]).collect::<Vec<_>>()),
        None => Splats::default(),
    };
    let [even, odd] = light_paths.unwrap_or_default();
    Pixel::of_words(of_pixel).sample_variance(&splats, exponent, even + odd)
}

/// The names of a pixel's words, in their order: `sum.R.0` is the lowest of the sum of red.
pub fn word_names(aovs: &Aovs, light_paths: bool) -> Vec<String> {
    let sums = ["sum", "odd_sum", "squares"].into_iter();
    let sums = sums.flat_map(|name| CHANNELS.map(|channel| (format!("{name}.{channel}"), OF_SUM)));
    let counts = ["even", "odd", "runs", "rejected"].map(|name| (name.to_string(), 2));
    let channels = channels::names(aovs, light_paths).map(|name| (name, OF_SUM));
    let stored = aovs.words_on_film().into_iter().chain(mattes::names(aovs)).map(|name| (name, 2));
    let named = sums.chain(counts).chain(stored).chain(channels);
    named.flat_map(|(name, words)| (0..words).map(move |word| format!("{name}.{word}"))).collect()
}

impl Film {
    /// The names of a pixel's words.
    pub fn word_names(&self) -> Vec<String> {
        word_names(&self.channels.aovs, self.channels.light_paths)
    }

    /// Writes the exact totals of a pixel in the order of [`Film::word_names`]; zeros outside the image.
    pub fn put_words(&self, index: usize, words: &mut [u16]) {
        let (of_pixel, rest) = words.split_at_mut(OF_PIXEL);
        self.pixels.get(index).copied().unwrap_or_default().put(of_pixel);
        let (stored, of_channels) = rest.split_at_mut(rest.len() - OF_SUM * self.channels.count);
        let (stored, of_mattes) = stored.split_at_mut(2 * self.channels.words);
        put_counts(self.channels.words_of_pixel(index), stored);
        put_counts(self.mattes.of_pixel(index), of_mattes);
        put_sums(self.channels.sums_of_pixel(index).iter(), of_channels);
    }

    /// Returns the words of a pixel.
    pub fn words(&self, index: usize) -> Vec<u16> {
        let of_counts = self.channels.words + self.channels.aovs.matte_words();
        let mut words = vec![0; OF_PIXEL + 2 * of_counts + OF_SUM * self.channels.count];
        self.put_words(index, &mut words);
        words
    }

    /// Adds the words of a pixel of another film of this image.
    pub fn add_words(&mut self, index: usize, words: &[u16]) {
        let (of_pixel, rest) = words.split_at(OF_PIXEL);
        let (stored, of_channels) = rest.split_at(rest.len() - OF_SUM * self.channels.count);
        if let Some(pixel) = self.pixels.get_mut(index) {
            pixel.add(&Pixel::of_words(of_pixel));
        }
        if let Some(sums) = self.channels.of_mut(index) {
            sums.iter_mut().zip(sums_of(of_channels)).for_each(|(mine, sum)| *mine = mine.saturating_add(sum));
        }
        let (stored, of_mattes) = stored.split_at(2 * self.channels.words);
        self.channels.keep_words(index, &counts_of(stored).collect::<Vec<_>>());
        self.mattes.add(index, &counts_of(of_mattes).collect::<Vec<_>>());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_hold_every_bit() {
        let mut bits = 1i128;
        let mut next = || {
            bits = bits.wrapping_mul(0x0123_4567_89ab_cdef_0fed_cba9_8765_4321).wrapping_add(7);
            bits
        };
        let rgb = |next: &mut dyn FnMut() -> i128| [next(), next(), next()];
        let pixel = Pixel {
            sum: rgb(&mut next),
            odd_sum: rgb(&mut next),
            squared_deviations: rgb(&mut next),
            even: next() as u32,
            odd: next() as u32,
            runs: next() as u32,
            rejected: next() as u32,
        };
        let words = |pixel: &Pixel| {
            let mut words = [0; OF_PIXEL];
            pixel.put(&mut words);
            words
        };
        assert_eq!(Pixel::of_words(&words(&pixel)), pixel);
        assert_ne!(Pixel::of_words(&words(&pixel)), Pixel::default());
        let names = Film::new(1, 1, 0).expect("it is small").word_names();
        assert_eq!((names.len(), names[8].as_str(), names[79].as_str()), (OF_PIXEL, "sum.G.0", "rejected.1"));
        // Each name is that of its word.
        let at = |name: &str| names.iter().position(|other| other == name).expect("it is a name");
        let one = Pixel { odd_sum: [0, 1 << 40, 0], runs: 1 << 20, ..Pixel::default() };
        let words = words(&one);
        assert_eq!((words[at("odd_sum.G.2")], words[at("runs.1")]), (1 << 8, 1 << 4));
        assert_eq!(words.iter().filter(|word| **word != 0).count(), 2);
    }
}
