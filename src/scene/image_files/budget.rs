//! The memory that the images of a scene may take. It is checked against what a file declares, before anything is decoded.

use std::collections::BTreeSet;

use crate::bitmap::{Bitmap, Decoding, largest, size_that_fits};

/// The largest width or height of an image.
const LARGEST_SIDE: usize = 16384;
/// The most bytes that a device can bind: wgpu grants at most 2^31 - 1 on Vulkan and on DirectX 12. The texels of all images
/// are one binding.
const LARGEST_BINDING: u64 = i32::MAX as u64;
/// What decoding may take beyond.
const BEYOND: u64 = 1 << 30;

/// The images that are decoded so far: path, size and bytes.
#[derive(Default)]
pub struct Budget(Vec<(String, (u32, u32), u64)>);

impl Budget {
    /// Checks that an image of this size fits together with those before it. `bytes_of` is the number of bytes of so many texels, and `decoder`
    /// that of its file and its decoder besides the texels.
    pub fn check(
        &self,
        (width, height): (usize, usize),
        bytes_of: impl FnOnce(usize) -> u64,
        decoder: u64,
    ) -> Result<(), String> {
        let sides = 1..=LARGEST_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(format!("expected a width and height from 1 to {LARGEST_SIDE}, found {width} by {height}"));
        }
        let (own, beside) = (bytes_of(width * height), self.0.iter().map(|(_, _, bytes)| bytes).sum::<u64>());
        let bytes = own + beside;
        if bytes > LARGEST_BINDING {
            let others = largest(self.0.iter().map(|(path, size, bytes)| (path.as_str(), *size, *bytes)));
            let others = if others.is_empty() { others } else { format!(", beside {others}") };
            let fits = size_that_fits((width as u32, height as u32), own, LARGEST_BINDING.saturating_sub(beside));
            let fits = fits.map_or(String::new(), |fits| format!("; of this one, {fits}"));
            return Err(format!(
                "expected at most {LARGEST_BINDING} bytes of texels in all images of the scene, which is the most that a device can bind; \
                 with its {width} by {height} there are {bytes}{others}: scale images down{fits}"
            ));
        }
        let bytes = bytes.saturating_add(decoder);
        match bytes > LARGEST_BINDING + BEYOND {
            true => Err(format!(
                "it takes {} MiB of memory to decode {width} by {height} texels beside the other images, and at most {} MiB \
                 are used: expected a smaller image, or one with fewer bits per texel",
                bytes >> 20,
                (LARGEST_BINDING + BEYOND) >> 20
            )),
            false => Ok(()),
        }
    }

    pub fn add(&mut self, path: &str, bitmap: &Bitmap) {
        self.0.push((path.to_owned(), (bitmap.width, bitmap.height), bitmap.bytes()));
    }
}

/// What is wanted of a file: how it is to be decoded, and within which memory.
pub struct Wanted<'a> {
    pub decodings: &'a BTreeSet<Decoding>,
    pub budget: &'a Budget,
}

impl Wanted<'_> {
    /// Checks that the images fit together with those before them. `of_bytes`: the file has integers of 8 bits. `decoder` is the number
    /// of bytes that the file and its decoder take in addition to the texels.
    pub fn check(&self, size: (usize, usize), of_bytes: bool, decoder: u64) -> Result<(), String> {
        let bytes = |texels| {
            let words = self.decodings.iter().map(|decoding| decoding.format(of_bytes).words(texels));
            size_of::<u32>() as u64 * words.sum::<usize>() as u64
        };
        self.budget.check(size, bytes, decoder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF_FLOATS: fn(usize) -> u64 = |texels| 12 * texels as u64;
    const OF_BYTES: fn(usize) -> u64 = |texels| 4 * texels as u64;

    #[test]
    fn all_images_together_fit_one_binding() {
        let mut budget = Budget::default();
        let rows = (LARGEST_BINDING / 12) as usize / LARGEST_SIDE;
        assert_eq!(budget.check((LARGEST_SIDE, rows), OF_FLOATS, 0), Ok(()));
        let refused = budget.check((LARGEST_SIDE, rows + 1), OF_FLOATS, 0).unwrap_err();
        assert!(refused.contains("expected at most 2147483647 bytes of texels"), "{refused}");
        let fits = "; of this one, 16383 by 10922 fits";
        assert!(refused.ends_with(fits) && budget.check((16383, 10922), OF_FLOATS, 0).is_ok(), "{refused}");
        // As bytes, the image takes a third.
        assert_eq!(budget.check((LARGEST_SIDE, rows + 1), OF_BYTES, 0), Ok(()));
        budget.0.push(("big.png".to_owned(), (9, 8), LARGEST_BINDING - 144));
        assert_eq!(budget.check((4, 3), OF_FLOATS, BEYOND), Ok(()));
        let refused = budget.check((13, 1), OF_FLOATS, 0).unwrap_err();
        assert!(refused.contains("beside big.png (9 by 8, 2147483503 bytes): scale images down"), "{refused}");
        assert!(budget.check((4, 3), OF_FLOATS, BEYOND + 8).unwrap_err().contains("3071 MiB"));
    }

    #[test]
    fn the_largest_maps_of_8_bits_and_of_floats_are_decoded() {
        let (size, texels) = ((LARGEST_SIDE, LARGEST_SIDE / 2), (LARGEST_SIDE * LARGEST_SIDE / 2) as u64);
        // A progressive JPEG; and floats with a file of 64 MiB.
        assert_eq!(Budget::default().check(size, OF_BYTES, 9 * texels), Ok(()));
        assert_eq!(Budget::default().check(size, OF_FLOATS, 8 * texels), Ok(()));
    }
}
