//! The luminance of a texture over small areas of flat surfaces.

use glam::{DVec2, DVec3, IVec3};

use crate::bitmap::{Bitmap, Bitmaps};
use crate::data::luminance;
use crate::texture::{Colour, Texture, Wrap};

/// The most columns and rows of [`SummedArea`]: 8 MiB.
const MOST_BINS: usize = 1024;
/// The least luminance of an area of a texture that is evaluated in points, such as a checker, as a share of the texture's mean.
const LEAST_OF_POINTS: f64 = 1.0 / 16.0;

/// The rounding error of a sum over part of an image, as a share of that over all: a few for each bin along an edge.
const ROUNDING: f64 = (4 * MOST_BINS) as f64 * f64::EPSILON;

/// A texture whose luminance varies.
pub enum Luminance<'a> {
    Image(SummedArea),
    /// A function of the point in the object's own space, and its mean.
    Solid(&'a Texture, f64),
}

/// An area that is looked at: its bounds in texture coordinates, and its middle in the object's own space.
pub struct Area {
    pub low: DVec2,
    pub high: DVec2,
    pub middle: DVec3,
}

impl<'a> Luminance<'a> {
    /// None of a plain colour, and of an image that is not there.
    pub fn new(texture: &'a Texture, bitmaps: &Bitmaps, wraps: bool) -> Option<Luminance<'a>> {
        match texture {
            Texture::Rgb(..) => None,
            // Sums over copies of an image are those of one that repeats.
            Texture::Image { wrap: Wrap::Clamp | Wrap::Mirror, .. } if wraps => None,
            Texture::Image { tint, .. } => {
                Some(Luminance::Image(SummedArea::new(texture.bitmap(bitmaps)?, *tint, wraps)?))
            }
            Texture::Checker { .. } | Texture::Noise { .. } | Texture::Marble { .. } => {
                Some(Luminance::Solid(texture, texture.mean_luminance(bitmaps)))
            }
        }
    }

    /// The mean over an area. It is 0 only where the area emits nothing, or nearly nothing of what the texture does.
    pub fn mean(&self, area: &Area) -> f64 {
        match self {
            Luminance::Image(sums) => sums.mean(area.low, area.high),
            Luminance::Solid(texture, mean) => {
                let uv = 0.5 * (area.low + area.high);
                let at = if texture.needs_uv() { uv.rem_euclid(DVec2::ONE).extend(0.0) } else { area.middle };
                at_point(texture, at).max(LEAST_OF_POINTS * mean)
            }
        }
    }
}

/// A solid texture at a point, as under shaders/texture.
fn at_point(texture: &Texture, p: DVec3) -> f64 {
    match *texture {
        Texture::Checker { scale, even, odd, .. } => {
            let cell = (p / scale).floor();
            let is_even = (cell.x + cell.y + cell.z).rem_euclid(2.0) == 0.0;
            luminance(if is_even { even } else { odd }.to_array())
        }
        Texture::Noise { scale } => (0.5 * (1.0 + perlin(scale * p))).clamp(0.0, 1.0),
        Texture::Marble { scale } => {
            let turbulence: f64 = (0..7).map(|octave| 2f64.powi(octave)).map(|f| perlin(f * p) / f).sum();
            0.5 * (1.0 + (scale * p.z + 10.0 * turbulence.abs()).sin())
        }
        Texture::Rgb(..) | Texture::Image { .. } => 0.0,
    }
}

/// Gradient noise, as in shaders/lib/perlin.
fn perlin(point: DVec3) -> f64 {
    let base = point.floor();
    let f = point - base;
    let cell = (base - 256.0 * (base / 256.0).floor()).as_ivec3();
    let fade = f * f * (3.0 - 2.0 * f);
    let corner = |number: i32| {
        let step = IVec3::new(number & 1, number >> 1 & 1, number >> 2);
        let [x, y, z] = (cell + step).to_array().map(|coordinate| coordinate as u32 & 255);
        let [x, y, z, _] = pcg4d([x, y, z, 0x9e37_79b9]);
        let in_cube = [x, y, z].map(|bits| f64::from(bits >> 8) / f64::from(1 << 23) + (0.5f64.powi(24) - 1.0));
        let step = step.as_dvec3();
        let weight = step * fade + (1.0 - step) * (1.0 - fade);
        weight.element_product() * DVec3::from_array(in_cube).normalize().dot(f - step)
    };
    (0..8).map(corner).sum()
}

/// A hash of four words (Jarzynski and Olano, JCGT 9(3), 2020), as in shaders/lib/rng.
fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let mix = |v: &mut [u32; 4]| {
        for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
            v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
        }
    };
    mix(&mut v);
    v = v.map(|word| word ^ word >> 16);
    mix(&mut v);
    v
}

/// The luminance of an image, summed over all bins to the left of an edge and below it (Crow, "Summed-Area Tables for Texture Mapping",
/// SIGGRAPH 1984). A bin is a texel, or some texels of a large image.
pub struct SummedArea {
    columns: usize,
    rows: usize,
    /// One more column and one more row than there are bins.
    sums: Vec<f64>,
    /// Whether the image is repeated beyond its edges.
    wraps: bool,
}

impl SummedArea {
    pub fn new(bitmap: &Bitmap, tint: Colour, wraps: bool) -> Option<SummedArea> {
        let (width, height) = (bitmap.width as usize, bitmap.height as usize);
        if bitmap.is_empty() {
            return None;
        }
        let (columns, rows) = (width.min(MOST_BINS), height.min(MOST_BINS));
        let mut bins = vec![(0.0, 0u32); columns * rows];
        for (index, texel) in bitmap.texels().enumerate() {
            let (x, y) = (index % width, height - 1 - index / width);
            let (sum, count) = &mut bins[y * rows / height * columns + x * columns / width];
            *sum += luminance((tint * DVec3::from_array(texel.map(f64::from))).to_array());
            *count += 1;
        }
        let stride = columns + 1;
        let mut sums = vec![0.0; stride * (rows + 1)];
        for row in 0..rows {
            let mut along = 0.0;
            for column in 0..columns {
                let (sum, count) = bins[row * columns + column];
                along += sum / f64::from(count.max(1));
                sums[(row + 1) * stride + column + 1] = sums[row * stride + column + 1] + along;
            }
        }
        Some(SummedArea { columns, rows, sums, wraps })
    }

    /// The sum up to a point in bins, within the image.
    fn within(&self, x: f64, y: f64) -> f64 {
        let (column, row) = ((x as usize).min(self.columns - 1), (y as usize).min(self.rows - 1));
        let (s, t) = (x - column as f64, y - row as f64);
        let at = |column: usize, row: usize| self.sums[row * (self.columns + 1) + column];
        let along = |row: usize| (1.0 - s) * at(column, row) + s * at(column + 1, row);
        (1.0 - t) * along(row) + t * along(row + 1)
    }

    /// The sum up to any point, over copies of the image.
    fn up_to(&self, x: f64, y: f64) -> f64 {
        let (width, height) = (self.columns as f64, self.rows as f64);
        let (i, j) = ((x / width).floor(), (y / height).floor());
        let (x, y) = ((x - i * width).clamp(0.0, width), (y - j * height).clamp(0.0, height));
        self.within(x, y) + i * self.within(width, y) + j * self.within(x, height) + i * j * self.within(width, height)
    }

    /// The mean over a box of texture coordinates, and half a texel around it: interpolation carries a texel's light so far.
    fn mean(&self, low: DVec2, high: DVec2) -> f64 {
        let size = DVec2::new(self.columns as f64, self.rows as f64);
        let (mut low, mut high) = (low * size - 0.5, high * size + 0.5);
        if !self.wraps {
            (low, high) = (low.max(DVec2::ZERO), high.min(size));
        }
        let corners = [(high.x, high.y), (low.x, low.y), (low.x, high.y), (high.x, low.y)];
        let [full, before, left, below] = corners.map(|(x, y)| self.up_to(x, y));
        let sum = full + before - left - below;
        // Sums that cancel each other leave rounding, which is no light.
        let rounding = ROUNDING * full.abs().max(before.abs()).max(left.abs()).max(below.abs());
        if sum > rounding { sum / (high - low).element_product() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(wraps: bool) -> SummedArea {
        // One hot texel at column 3 from the left and row 1 from the top.
        let texels = (0..4 * 8).map(|i| [if i == 8 + 3 { 32.0 } else { 0.0 }; 3]);
        SummedArea::new(&Bitmap::of_floats(8, 4, texels), Colour::ONE, wraps).expect("it has texels")
    }

    #[test]
    fn means_are_those_of_the_interpolated_image() {
        let sums = image(false);
        assert!((sums.mean(DVec2::ZERO, DVec2::ONE) - 1.0).abs() < 1e-12);
        // In points, the tent of the texel, whose middle is at u = 3.5 / 8 and v = 2.5 / 4.
        for (u, v, expected) in [(3.5, 2.5, 32.0), (4.0, 2.5, 16.0), (4.0, 2.0, 8.0), (4.5, 2.5, 0.0), (3.5, 1.5, 0.0)]
        {
            let at = DVec2::new(u / 8.0, v / 4.0);
            assert!((sums.mean(at, at) - expected).abs() < 1e-9, "{u} {v}");
        }
        // A box is widened by half a texel, so that it holds all of a tent that reaches into it.
        let found = sums.mean(DVec2::new(4.0 / 8.0, 0.0), DVec2::ONE);
        assert!((found - 32.0 * 0.5 / (4.5 * 4.0)).abs() < 1e-9, "{found}");
        assert_eq!(sums.mean(DVec2::new(4.6 / 8.0, 0.0), DVec2::ONE), 0.0);
    }

    #[test]
    fn repeated_images_are_summed_over_all_copies() {
        let sums = image(true);
        for (low, high) in [((-2.0, -1.0), (3.0, 4.0)), ((0.4, -7.3), (20.4, 2.7)), ((-5.25, 0.5), (-1.25, 1.5))] {
            let found = sums.mean(DVec2::from(low), DVec2::from(high));
            // Off by what half a texel on each side may hold.
            assert!((found - 1.0).abs() < 0.35, "{low:?} {high:?}: {found}");
        }
        let at = DVec2::new(3.5 / 8.0 - 3.0, 2.5 / 4.0 + 2.0);
        assert!((sums.mean(at, at) - 32.0).abs() < 1e-9);
    }
}
