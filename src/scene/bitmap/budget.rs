//! The memory that the images of a scene may take. It is checked against what a file declares, before anything is decoded.

/// The largest width or height of an image.
const LARGEST_SIDE: usize = 16384;
/// The most bytes that a device can bind: wgpu grants at most 2^31 - 1 on Vulkan and on DirectX 12. The texels of all images
/// are one binding.
const LARGEST_BINDING: u64 = i32::MAX as u64;
/// What decoding may take beyond.
const BEYOND: u64 = 1 << 30;
const TEXEL: u64 = size_of::<[f32; 3]>() as u64;

/// The texels that are decoded so far.
#[derive(Default)]
pub struct Budget {
    texels: u64,
}

impl Budget {
    /// Checks that an image of this size fits beside those before it. `decoder` is the number of bytes that its file and its
    /// decoder take besides the texels.
    pub fn check(&self, (width, height): (usize, usize), decoder: u64) -> Result<(), String> {
        let sides = 1..=LARGEST_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(format!("expected a width and height from 1 to {LARGEST_SIDE}, found {width} by {height}"));
        }
        let texels = self.texels + (width * height) as u64;
        let most = LARGEST_BINDING / TEXEL;
        if texels > most {
            return Err(format!(
                "expected at most {most} texels in all images of the scene, which is the most that a device can bind; \
                 with its {width} by {height} there are {texels}"
            ));
        }
        let bytes = (TEXEL * texels).saturating_add(decoder);
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

    pub fn add(&mut self, texels: usize) {
        self.texels += texels as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_images_together_fit_one_binding() {
        let mut budget = Budget::default();
        let most = (LARGEST_BINDING / TEXEL) as usize;
        let rows = most / LARGEST_SIDE;
        assert_eq!(budget.check((LARGEST_SIDE, rows), 0), Ok(()));
        assert!(budget.check((LARGEST_SIDE, rows + 1), 0).unwrap_err().contains("expected at most 178956970 texels"));
        budget.add(most - 12);
        assert_eq!(budget.check((4, 3), BEYOND), Ok(()));
        assert!(budget.check((13, 1), 0).is_err());
        assert!(budget.check((4, 3), BEYOND + 8).unwrap_err().contains("3071 MiB"));
    }

    #[test]
    fn the_largest_maps_of_8_bits_and_of_floats_are_decoded() {
        let (size, texels) = ((LARGEST_SIDE, LARGEST_SIDE / 2), (LARGEST_SIDE * LARGEST_SIDE / 2) as u64);
        // A progressive JPEG; and floats with a file of 64 MiB.
        for decoder in [9 * texels, 8 * texels] {
            assert_eq!(Budget::default().check(size, decoder), Ok(()));
        }
    }
}
