//! Images that no file has: made of others, texel by texel.

use std::path::Path;

use super::Imported;
use crate::bitmap::Decoding;
use crate::scene::image_files;
use crate::scene::types::{Bitmap, Colour, Wrap};

/// An image times a colour, or that colour everywhere.
pub type Part = (Option<Bitmap>, Colour);

impl Imported<'_> {
    /// An image by its path in the scene, of a file or of none.
    pub fn image(&mut self, path: &str, decoding: Decoding) -> Result<Bitmap, String> {
        if let Some(own) = self.images.colours(path) {
            return Ok(own.clone());
        }
        let file = self.to.parent().unwrap_or(Path::new("")).join(path);
        self.add_file(&file);
        image_files::load(&file, decoding, self.assets)
    }

    /// Adds an image whose values are `of` those of its parts, as a mesh is added, and tells its path. It has the size of the largest one, at whose texels
    /// the others are interpolated. Equal images are one.
    pub fn add_image<const N: usize>(
        &mut self,
        parts: &[Part; N],
        wrap: Wrap,
        of: impl Fn([Colour; N]) -> Colour,
    ) -> Result<String, String> {
        let images = parts.iter().filter_map(|(image, _)| image.as_ref());
        let Some(largest) = images.max_by_key(|image| image.len()) else { return Err("expected an image".to_owned()) };
        let texel = |index: usize| {
            let value = |(image, tint): &Part| match image {
                Some(image) => *tint * resampled(image, index, largest, wrap),
                None => *tint,
            };
            of(parts.each_ref().map(value)).max(Colour::ZERO).as_vec3().to_array()
        };
        // Codes stay as they are.
        let is_same = (0..largest.len()).all(|index| texel(index) == largest.texel(index));
        let made = match is_same {
            true => largest.clone(),
            false => {
                self.take_room(size_of::<[f32; 3]>() * largest.len())?;
                Bitmap::of_floats(largest.width, largest.height, (0..largest.len()).map(texel))
            }
        };
        let known = self.images.paths().find(|path| self.images.colours(path) == Some(&made));
        let new = || self.path_of_made("images", self.images.paths().count(), "exr");
        let path = known.cloned().unwrap_or_else(new);
        self.images.insert(&path, Decoding::Colour, made);
        Ok(path)
    }
}

/// An image at a texel of another one, by bilinear interpolation.
fn resampled(image: &Bitmap, index: usize, other: &Bitmap, wrap: Wrap) -> Colour {
    let texel = |x: usize, y: usize| Colour::from_array(image.texel(y * image.width as usize + x).map(f64::from));
    if (image.width, image.height) == (other.width, other.height) {
        return Colour::from_array(image.texel(index).map(f64::from));
    }
    let (x, y) = (index as u32 % other.width, index as u32 / other.width);
    let axis = |at: u32, size: u32, own: u32| {
        let exact = (f64::from(at) + 0.5) * f64::from(own) / f64::from(size) - 0.5;
        let place = |cell: f64| match wrap {
            Wrap::Repeat => cell.rem_euclid(f64::from(own)) as usize,
            _ => cell.clamp(0.0, f64::from(own) - 1.0) as usize,
        };
        ([exact.floor(), exact.floor() + 1.0].map(place), exact - exact.floor())
    };
    let (columns, right) = axis(x, other.width, image.width);
    let (rows, down) = axis(y, other.height, image.height);
    let [above, below] = rows.map(|y| texel(columns[0], y).lerp(texel(columns[1], y), right));
    above.lerp(below, down)
}
