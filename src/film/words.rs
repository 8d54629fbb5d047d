//! The exact totals of pixels as words of 16 bits, for files. Sums are in two's complement.

use super::{Film, Pixel};
use crate::data::CHANNELS;

/// Words of a pixel: nine sums of 128 bits, and four counts of 32 bits.
pub const WORDS: usize = 9 * 8 + 4 * 2;

/// A pixel's totals, the lowest word of each first.
pub type Words = [u16; WORDS];

/// The names of the words: `sum.R.0` is the lowest of the sum of red.
pub fn word_names() -> Vec<String> {
    let sums = ["sum", "odd_sum", "squares"].into_iter();
    let sums = sums.flat_map(|name| CHANNELS.map(|channel| (format!("{name}.{channel}"), 8)));
    let counts = ["even", "odd", "runs", "rejected"].map(|name| (name.to_string(), 2));
    sums.chain(counts).flat_map(|(name, words)| (0..words).map(move |word| format!("{name}.{word}"))).collect()
}

impl Pixel {
    fn words(&self) -> Words {
        let mut words = [0; WORDS];
        let (sums, counts) = words.split_at_mut(9 * 8);
        let values = self.sum.iter().chain(&self.odd_sum).chain(&self.spread);
        for (words, value) in sums.as_chunks_mut::<8>().0.iter_mut().zip(values) {
            *words = std::array::from_fn(|word| (value >> (16 * word)) as u16);
        }
        let values = [self.even, self.odd, self.runs, self.rejected];
        for (words, value) in counts.as_chunks_mut::<2>().0.iter_mut().zip(values) {
            *words = [value as u16, (value >> 16) as u16];
        }
        words
    }

    fn of_words(words: &Words) -> Pixel {
        let (sums, counts) = words.split_at(9 * 8);
        let sums = sums.as_chunks::<8>().0;
        let sum = |index: usize| sums[index].iter().rev().fold(0, |value, word| value << 16 | i128::from(*word));
        let rgb = |first: usize| [sum(first), sum(first + 1), sum(first + 2)];
        let count = |index: usize| u32::from(counts[2 * index]) | u32::from(counts[2 * index + 1]) << 16;
        Pixel {
            sum: rgb(0),
            odd_sum: rgb(3),
            spread: rgb(6),
            even: count(0),
            odd: count(1),
            runs: count(2),
            rejected: count(3),
        }
    }
}

impl Film {
    /// The exact totals of a pixel; zeros where it is not in the image.
    pub fn words(&self, index: usize) -> Words {
        self.pixels.get(index).copied().unwrap_or_default().words()
    }

    /// Adds the exact totals that a pixel of another film of this image has.
    pub fn add_words(&mut self, index: usize, words: &Words) {
        if let Some(pixel) = self.pixels.get_mut(index) {
            pixel.add(&Pixel::of_words(words));
        }
    }

    /// Adds what another film of this image has counted.
    pub fn add_totals(&mut self, totals: super::Totals) {
        self.totals += totals;
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
            spread: rgb(&mut next),
            even: next() as u32,
            odd: next() as u32,
            runs: next() as u32,
            rejected: next() as u32,
        };
        assert_eq!(Pixel::of_words(&pixel.words()), pixel);
        assert_ne!(Pixel::of_words(&pixel.words()), Pixel::default());
        let names = word_names();
        assert_eq!((names.len(), names[8].as_str(), names[79].as_str()), (WORDS, "sum.G.0", "rejected.1"));
        // Each name is that of its word.
        let at = |name: &str| names.iter().position(|other| other == name).expect("it is a name");
        let one = Pixel { odd_sum: [0, 1 << 40, 0], runs: 1 << 20, ..Pixel::default() };
        let words = one.words();
        assert_eq!((words[at("odd_sum.G.2")], words[at("runs.1")]), (1 << 8, 1 << 4));
        assert_eq!(words.iter().filter(|word| **word != 0).count(), 2);
    }
}
