//! Decoded images. Texels stay as their file has them; kernels and the host read them through the same formats.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use serde::{Deserialize, Serialize};

/// The meaning of the codes of an image file. A file can be decoded in several ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Decoding {
    /// Colours in linear Rec. 709. Integers are sRGB codes, and floats are linear.
    Colour,
    /// Three numbers, as in a normal map: a code over the largest code.
    Numbers,
    /// The numbers of one channel.
    Number(Channel),
}

/// The channel of an image file that has a number. Alpha is 1 where the file has none, and all other channels of a grey image are its grey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub enum Channel {
    #[default]
    R,
    G,
    B,
    A,
    /// Three numbers: those of a normal map.
    Rgb,
}

impl Channel {
    pub fn decoding(self) -> Decoding {
        if self == Channel::Rgb { Decoding::Numbers } else { Decoding::Number(self) }
    }
}

/// How texels lie in words of 32 bits. Each format has a file under shaders/texel, and kernels switch on its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// Three floats.
    Float,
    /// Three sRGB codes of 8 bits in a word, red in the lowest byte.
    Srgb,
    /// Three linear codes of 8 bits in a word.
    Linear,
    /// One linear code of 8 bits, four texels in a word. The three channels of such a texel are equal.
    Number,
}

/// The shader files of the formats, by their numbers.
pub const FORMATS: &[&str] = &["float", "srgb", "linear", "number"];

/// The linear value of each sRGB code, as kernels have it in a table.
pub static SRGB: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| from_srgb(code as f64 / f64::from(u8::MAX))));

/// The value of a step of a linear code. Multiplied by a code in f32, it is the same on all devices, as a quotient is not.
pub const CODE: f32 = 1.0 / 255.0;

/// The linear value of an sRGB code in 0..=1 (IEC 61966-2-1).
pub fn from_srgb(code: f64) -> f32 {
    light_of_srgb(code) as f32
}

/// The same, not rounded.
pub fn light_of_srgb(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

impl Decoding {
    /// The format of an image decoded so. `of_bytes`: its file has integers of 8 bits.
    pub fn format(self, of_bytes: bool) -> Format {
        match self {
            _ if !of_bytes => Format::Float,
            Decoding::Colour => Format::Srgb,
            Decoding::Numbers => Format::Linear,
            Decoding::Number(_) => Format::Number,
        }
    }
}

impl Format {
    pub fn number(self) -> usize {
        self as usize
    }

    /// The words that so many texels take.
    pub fn words(self, texels: usize) -> usize {
        match self {
            Format::Float => 3 * texels,
            Format::Srgb | Format::Linear => texels,
            Format::Number => texels.div_ceil(4),
        }
    }
}

/// A decoded image file of the scene, with row 0 at the top. A copy shares the texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    pub width: u32,
    pub height: u32,
    pub format: Format,
    /// The texels row by row, in the words of the format.
    pub words: Arc<Vec<u32>>,
    /// The warning about what [`Bitmap::clean`] has changed.
    pub warning: Option<String>,
}

impl Bitmap {
    pub fn new(width: u32, height: u32, format: Format, words: Vec<u32>) -> Bitmap {
        Bitmap { width, height, format, words: Arc::new(words), warning: None }
    }

    /// An image of floats.
    pub fn of_floats(width: u32, height: u32, texels: impl IntoIterator<Item = [f32; 3]>) -> Bitmap {
        Bitmap::new(width, height, Format::Float, texels.into_iter().flatten().map(f32::to_bits).collect())
    }

    /// An image of codes of 8 bits, in a word each.
    pub fn of_codes(width: u32, height: u32, format: Format, texels: impl Iterator<Item = [u8; 3]>) -> Bitmap {
        Bitmap::new(width, height, format, texels.map(|[r, g, b]| u32::from_le_bytes([r, g, b, 0])).collect())
    }

    /// An image of one channel of 8 bits.
    pub fn of_numbers(width: u32, height: u32, mut texels: impl Iterator<Item = u8>) -> Bitmap {
        let count = Format::Number.words(width as usize * height as usize);
        let mut next = || texels.next().unwrap_or_default();
        let words = (0..count).map(|_| u32::from_le_bytes([next(), next(), next(), next()])).collect();
        Bitmap::new(width, height, Format::Number, words)
    }

    /// Sets what no colour has to 0: numbers that are negative, infinite or NaN. Resampling, lossy compression and changes of primaries
    /// leave such ones.
    pub fn clean(&mut self) {
        let is_light = |word: &u32| f32::from_bits(*word) >= 0.0 && f32::from_bits(*word).is_finite();
        if self.format != Format::Float || self.words.iter().all(is_light) {
            return;
        }
        let (mut count, mut largest) = (0, f32::NAN);
        for texel in Arc::make_mut(&mut self.words).as_chunks_mut::<3>().0 {
            count += usize::from(!texel.iter().all(is_light));
            for word in texel.iter_mut().filter(|word| !is_light(word)) {
                let number = f32::from_bits(std::mem::take(word));
                if largest.is_nan() || number.abs() > largest.abs() {
                    largest = number;
                }
            }
        }
        self.warning = Some(format!(
            "{count} of {} texels have a number that is negative, infinite or NaN, the largest of them {largest:?}: they count as 0",
            self.len()
        ));
    }

    /// The number of texels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bytes that it takes.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.words.as_slice()) as u64
    }

    /// The red, green and blue of a texel, row by row; 0 beyond the last one.
    pub fn texel(&self, index: usize) -> [f32; 3] {
        let word = |at: usize| self.words.get(at).copied().unwrap_or_default();
        let code = |word: u32, byte: usize| word.to_le_bytes()[byte];
        match self.format {
            Format::Float => [0, 1, 2].map(|channel| f32::from_bits(word(3 * index + channel))),
            Format::Srgb => [0, 1, 2].map(|channel| SRGB[usize::from(code(word(index), channel))]),
            Format::Linear => [0, 1, 2].map(|channel| CODE * f32::from(code(word(index), channel))),
            Format::Number => [CODE * f32::from(code(word(index / 4), index % 4)); 3],
        }
    }

    /// All texels, row by row.
    pub fn texels(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + '_ {
        (0..self.len()).map(|index| self.texel(index))
    }
}

/// The decoded images, by the paths that the scene file writes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bitmaps(BTreeMap<(String, Decoding), Bitmap>);

impl Bitmaps {
    pub fn get(&self, path: &str, decoding: Decoding) -> Option<&Bitmap> {
        self.0.get(&(path.to_owned(), decoding))
    }

    pub fn insert(&mut self, path: &str, decoding: Decoding, bitmap: Bitmap) {
        self.0.insert((path.to_owned(), decoding), bitmap);
    }

    /// An image as colours.
    pub fn colours(&self, path: &str) -> Option<&Bitmap> {
        self.get(path, Decoding::Colour)
    }

    /// The paths of all images; more than once where a file is decoded in several ways.
    pub fn paths(&self) -> impl Iterator<Item = &String> {
        self.0.keys().map(|(path, _)| path)
    }

    /// All decoded images.
    pub fn values(&self) -> impl Iterator<Item = &Bitmap> {
        self.0.values()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The largest of some images in words, for errors about their memory: at most three, each with its size and bytes.
pub fn largest<'a>(images: impl Iterator<Item = (&'a str, (u32, u32), u64)>) -> String {
    const MOST: usize = 3;
    let mut images: Vec<_> = images.collect();
    images.sort_by_key(|(_, _, bytes)| std::cmp::Reverse(*bytes));
    let each = images.iter().take(MOST).map(|(path, (width, height), bytes)| {
        let path = crate::printable::one_line(path);
        format!("{path} ({width} by {height}, {bytes} bytes)")
    });
    let mut words: Vec<String> = each.collect();
    if images.len() > MOST {
        words.push(format!("{} more", images.len() - MOST));
    }
    words.join(", ")
}

/// The largest size, of the same proportions, at which an image of this size and so many bytes takes no more than `room`, in words.
pub fn size_that_fits((width, height): (u32, u32), bytes: u64, room: u64) -> Option<String> {
    let scale = (room as f64 / bytes as f64).sqrt();
    let [width, height] = [width, height].map(|side| (f64::from(side) * scale) as u32);
    (width.min(height) > 0).then(|| format!("{width} by {height} fits"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_srgb_become_linear() {
        assert_eq!(from_srgb(0.0), 0.0);
        assert_eq!(from_srgb(1.0), 1.0);
        // Values of the standard, and the code at which its two parts join.
        assert!((f64::from(from_srgb(188.0 / 255.0)) - 0.502_886_5).abs() < 1e-6);
        assert!((f64::from(from_srgb(0.04045)) - 0.003_130_804_95).abs() < 1e-9);
    }

    #[test]
    fn texels_come_back_from_each_format() {
        let floats = [[0.25, 1e-40, 3e38], [-1.0, f32::INFINITY, 0.0]];
        assert!(Bitmap::of_floats(2, 1, floats).texels().eq(floats));
        let codes = [[1, 2, 3], [255, 0, 188]];
        let srgb = Bitmap::of_codes(1, 2, Format::Srgb, codes.into_iter());
        assert!(srgb.texels().eq(codes.map(|texel| texel.map(|code| from_srgb(f64::from(code) / 255.0)))));
        let linear = Bitmap::of_codes(1, 2, Format::Linear, codes.into_iter());
        for (texel, codes) in linear.texels().zip(codes) {
            let off = (0..3).map(|c| (f64::from(texel[c]) - f64::from(codes[c]) / 255.0).abs()).fold(0.0, f64::max);
            assert!(off < 6e-8, "{texel:?}");
        }
        let numbers: Vec<u8> = (0..=255).collect();
        for count in [1, 3, 4, 5, 256] {
            let bitmap = Bitmap::of_numbers(count, 1, numbers.iter().copied());
            assert_eq!(bitmap.words.len(), count.div_ceil(4) as usize);
            assert!(bitmap.texels().eq(numbers.iter().take(count as usize).map(|code| [CODE * f32::from(*code); 3])));
        }
        // The ends of the range are exact.
        assert_eq!((CODE * 255.0, CODE * 0.0), (1.0, 0.0));
    }

    #[test]
    fn what_is_no_light_is_set_to_0_and_counted() {
        let mut bitmap = Bitmap::of_floats(2, 1, [[0.25, 1e-40, 3e38], [-0.0, 1.0, 0.0]]);
        let before = bitmap.clone();
        bitmap.clean();
        assert_eq!(bitmap, before);
        for (texels, most, words) in [
            (
                [[-1e-6, 0.5, -2e-6], [0.0; 3], [f32::NAN, 1.0, 1.0]],
                [0.0, 0.5, 0.0],
                "2 of 3 texels have a number that is negative, infinite or NaN, the largest of them -2e-6",
            ),
            (
                [[f32::INFINITY, 0.5, -2e-6], [0.0; 3], [1.0; 3]],
                [0.0, 0.5, 0.0],
                "1 of 3 texels have a number that is negative, infinite or NaN, the largest of them inf",
            ),
            ([[f32::NAN, 0.5, 1.0], [0.0; 3], [1.0; 3]], [0.0, 0.5, 1.0], "the largest of them NaN"),
        ] {
            let mut bitmap = Bitmap::of_floats(3, 1, texels);
            let shared = bitmap.clone();
            bitmap.clean();
            assert_eq!((bitmap.texel(0), bitmap.texel(1)), (most, [0.0; 3]));
            assert!(bitmap.warning.is_some_and(|warning| warning.contains(words)));
            assert!(shared.warning.is_none() && shared.words != bitmap.words, "a copy keeps its own");
        }
    }

    #[test]
    fn the_largest_images_are_named_first() {
        let images = [("a", (1, 1), 4), ("b", (9, 9), 324), ("c", (2, 2), 16), ("d", (1, 2), 8)];
        assert_eq!(
            largest(images.into_iter()),
            "b (9 by 9, 324 bytes), c (2 by 2, 16 bytes), d (1 by 2, 8 bytes), 1 more"
        );
    }
}
