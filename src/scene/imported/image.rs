//! Images that no file has: made of other textures, texel by texel.

use std::path::Path;

use glam::DVec2;

use super::Imported;
use crate::bitmap::Decoding;
use crate::scene::image_files;
use crate::scene::types::{Bitmap, Colour, Texture, Wrap};

/// The least number of texels along a square, so that its edges, which are a texel wide, are a small part of it.
const ALONG_SQUARE: f64 = 16.0;

/// A texture that an image is made of.
pub struct Pattern {
    pub texture: Texture,
    pub bitmap: Option<Bitmap>,
    /// The scale and the shift that make its own texture coordinates of those of the image. The scale is an integer.
    pub mapping: [DVec2; 2],
}

impl Pattern {
    /// The texels of its bitmap along the sides of the image.
    pub fn texels(&self) -> Option<DVec2> {
        let size = self.bitmap.as_ref().map(|bitmap| DVec2::new(bitmap.width.into(), bitmap.height.into()));
        size.map(|size| self.mapping[0].abs() * size)
    }

    /// The squares along the sides of the image.
    fn squares(&self) -> Option<DVec2> {
        matches!(self.texture, Texture::Checker { .. }).then_some(2.0 * self.mapping[0].abs())
    }

    /// The colour at a texel of an image of this size.
    fn at(&self, texel: [u32; 2], size: [u32; 2]) -> Colour {
        let ends = || [0, 1].map(|axis| self.ends(axis, texel[axis], size[axis]));
        let is_as_it_is = self.mapping == [DVec2::ONE, DVec2::ZERO];
        match (&self.texture, &self.bitmap) {
            (Texture::Image { tint, .. }, Some(own)) if is_as_it_is && [own.width, own.height] == size => {
                *tint * colour(own, texel[0] as usize, texel[1] as usize)
            }
            (Texture::Image { tint, wrap, .. }, Some(bitmap)) => {
                let [u, v] = ends().map(|[begin, end]| 0.5 * (begin + end));
                *tint * interpolated(bitmap, *wrap, u, 1.0 - v)
            }
            (Texture::Checker { even, odd, .. }, _) => {
                let [across, along] = ends().map(mean_sign);
                let share_of_odd = 0.5 - 0.5 * across * along;
                *even * (1.0 - share_of_odd) + *odd * share_of_odd
            }
            (other, _) => other.plain().unwrap_or_default(),
        }
    }

    /// The texture coordinate of its own at both ends of a texel, along an axis. Rows are counted from the top, and v from below.
    fn ends(&self, axis: usize, texel: u32, size: u32) -> [f64; 2] {
        let [scale, shift] = self.mapping.map(|part| part[axis]);
        let texel = if axis == 1 { size - 1 - texel } else { texel };
        [texel, texel + 1].map(|end| scale * f64::from(end) / f64::from(size) + shift)
    }
}

/// The mean of 1 in the first half of each unit and -1 in the second.
fn mean_sign([begin, end]: [f64; 2]) -> f64 {
    let integral = |x: f64| 0.5 - (x.rem_euclid(1.0) - 0.5).abs();
    ((integral(end) - integral(begin)) / (end - begin)).clamp(-1.0, 1.0)
}

fn colour(image: &Bitmap, x: usize, y: usize) -> Colour {
    Colour::from_array(image.texel(y * image.width as usize + x).map(f64::from))
}

/// The colour of an image, by bilinear interpolation. v is downwards.
fn interpolated(image: &Bitmap, wrap: Wrap, u: f64, v: f64) -> Colour {
    let axis = |at: f64, size: u32| {
        let size = f64::from(size);
        // Without the rounding errors of texel centres.
        let exact = (65536.0 * (at * size - 0.5)).round() / 65536.0;
        let place = |cell: f64| match wrap {
            Wrap::Repeat => cell.rem_euclid(size) as usize,
            _ => cell.clamp(0.0, size - 1.0) as usize,
        };
        ([exact.floor(), exact.floor() + 1.0].map(place), exact - exact.floor())
    };
    let ((columns, right), (rows, down)) = (axis(u, image.width), axis(v, image.height));
    let [above, below] = rows.map(|y| colour(image, columns[0], y).lerp(colour(image, columns[1], y), right));
    above.lerp(below, down)
}

/// The width and the height of an image of these parts: of the largest bitmaps, or an odd multiple of these where squares need more texels. In an odd
/// multiple the texels of a bitmap are among those of the image, so that it is the same between them.
fn size_of_made(parts: &[Pattern]) -> [u32; 2] {
    let most = |of: fn(&Pattern) -> Option<DVec2>| parts.iter().filter_map(of).reduce(DVec2::max);
    let squares = most(Pattern::squares).unwrap_or(DVec2::ZERO);
    let texels = most(Pattern::texels).unwrap_or(squares);
    let least = (ALONG_SQUARE * squares / texels).ceil().max(DVec2::ONE);
    (texels * (least + (least + 1.0) % 2.0)).to_array().map(|texels| texels as u32)
}

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

    /// Adds an image whose values are `of` those of its parts, as a mesh is added, and tells its path. Equal images are one.
    pub fn add_image<const N: usize>(
        &mut self,
        parts: &[Pattern; N],
        of: impl Fn([Colour; N]) -> Colour,
    ) -> Result<String, String> {
        let size = size_of_made(parts);
        let [width, height] = size;
        let length = width as usize * height as usize;
        let texel = |index: usize| {
            let place = [index as u32 % width, index as u32 / width];
            of(parts.each_ref().map(|part| part.at(place, size))).max(Colour::ZERO).as_vec3().to_array()
        };
        let bitmaps = parts.iter().filter_map(|part| part.bitmap.as_ref());
        // Codes stay as they are.
        let is_same = |known: &&Bitmap| {
            [known.width, known.height] == size && (0..length).all(|index| texel(index) == known.texel(index))
        };
        let made = match bitmaps.clone().find(is_same) {
            Some(known) => known.clone(),
            None => {
                self.take_room(size_of::<[f32; 3]>().saturating_mul(length))?;
                Bitmap::of_floats(width, height, (0..length).map(texel))
            }
        };
        let known = self.images.paths().find(|path| self.images.colours(path) == Some(&made));
        let new = || self.path_of_made("images", self.images.paths().count(), "exr");
        let path = known.cloned().unwrap_or_else(new);
        self.images.insert(&path, Decoding::Colour, made);
        Ok(path)
    }
}
