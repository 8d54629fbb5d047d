//! The film: exact sums of the samples of each pixel, which do not depend on the order.
//!
//! The device adds sums over short runs of samples as integers of a fixed scale (shaders/step/film.wgsl): a sum of integers is the same in
//! any order and split. It also adds the sums of squares that the error estimate needs. The host joins the device's totals here.

mod accumulation;
mod bound;
mod channels;
mod error;
mod estimate;
mod floats;
mod lamps;
mod lights;
mod mattes;
mod pixel;
mod totals;
mod values;
mod verdict;
mod words;

use crate::aov::{Aovs, SceneSpace};
use crate::data::{PixelTotals, Rgb, Sampler};
use crate::error::{Error, Result};
use crate::job::Frame;
use crate::memory;
use crate::options::Word;
pub use accumulation::{Accumulation, add_devices};
pub use bound::Bound;
pub use channels::{MotionOf, device_bytes, record_bytes};
pub use error::{ErrorEstimate, relative_error};
pub use totals::{HiddenLight, Rejected, Totals};
pub use verdict::Verdict;
pub use words::{sample_variance_of, word_names};

use channels::Channels;
use estimate::Estimate;
use floats::{exp2, to_f32};
use mattes::Mattes;
use pixel::Pixel;

/// The value of [`Picture::variance`] if the variance is not known: the largest finite f32. An image file must hold finite values, 0
/// would mean an exact pixel, and a program that takes this one for a variance ignores the pixel, which is right.
pub const UNKNOWN_VARIANCE: f32 = f32::MAX;

/// The most bytes of a pixel on the host: its totals, and seven bytes while a PNG is written. An EXR is written row by row.
const BYTES_OF_A_PIXEL: u64 = size_of::<Pixel>() as u64 + 7;
/// The largest power of two, up or down, between device units and scene units: its square is far inside f64.
const MAX_EXPONENT: i32 = 300;

/// The exact totals of an image.
///
/// Range, in device units (scene radiance / 2^exponent). A pixel's sum holds 2^-88 to 2^39, of either sign: every f32 from 2^-65 on is added
/// without rounding, smaller ones are rounded to 2^-88, and 2^30 samples of mean 500 fit. Its squared deviations hold 2^-96 to 2^31: 2^29
/// samples that deviate by 2 fit. Deviations below about 2^-43 are not known; the variance then comes from the two halves, which are exact
/// to 2^-88. Sums of splats and of their squares have the same ranges. Beyond the range, a total saturates (a saturating sum of numbers of
/// one sign is still the same in any order), and the variance is unknown. So the device's unit should be about the radiance of the brightest
/// thing that is often seen.
///
/// Memory: 160 bytes a pixel, 16 more for each sum of further channels and of splats (144 in all with light paths), and 132 for each kind of
/// matte.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Scene radiance is the film's radiance times 2 to this exponent.
    pub exponent: i32,
    pub sampler: Sampler,
    pub bound: Bound,
    /// The part of the image that the pixels are of.
    pub frame: Frame,
    pixels: Vec<Pixel>,
    /// The channels of `--aov`, and the splats of light paths.
    channels: Channels,
    mattes: Mattes,
    pub totals: Totals,
}

impl Film {
    /// An empty film of independent samples.
    ///
    /// # Errors
    /// As of [`Film::with_sampler`].
    pub fn new(width: u32, height: u32, exponent: i32) -> Result<Film> {
        Film::with_sampler(width, height, exponent, Sampler::Independent)
    }

    /// An empty film. The error is estimated from all samples, or with Sobol points from two halves. Device radiance times 2^exponent is scene
    /// radiance; the exponent is within ±300. A render takes a film with the `radiance_exponent` of its scene, and refuses others.
    ///
    /// # Errors
    /// `Error::Usage` if the image has no pixels, more than 2^32, or more than memory holds.
    pub fn with_sampler(width: u32, height: u32, exponent: i32, sampler: Sampler) -> Result<Film> {
        let count = u64::from(width) * u64::from(height);
        // The device names pixels by u32.
        if count == 0 || count > 1 << 32 {
            return Err(Error::Usage(format!(
                "an image of {width} x {height} pixels: expected 1 to 2^32 pixels in all"
            )));
        }
        if !(-MAX_EXPONENT..=MAX_EXPONENT).contains(&exponent) {
            return Err(Error::Usage(format!(
                "the scene's radiance has the scale 2^{exponent}: expected 2^-300 to 2^300"
            )));
        }
        let needs = |memory: String| {
            Error::Usage(format!("an image of {width} x {height} pixels needs {memory}; use a smaller --size"))
        };
        memory::check(count * BYTES_OF_A_PIXEL).map_err(needs)?;
        let cannot = |_| needs("more memory than can be had".to_string());
        let count = usize::try_from(count).map_err(|_| cannot(()))?;
        // Zeroed pages of the system: writing zeros would take longer than anything else before the first pass of a large film.
        let pixels = bytemuck::allocation::try_zeroed_vec::<Pixel>(count).map_err(cannot)?;
        let frame = Frame::full((width, height));
        let (bound, channels, totals) = (Bound::default(), Channels::default(), Totals::default());
        Ok(Film { exponent, sampler, bound, frame, pixels, channels, mattes: Mattes::default(), totals })
    }

    /// Adds to an empty film the channels of `--aov`, and the sums of the splats of light paths if it is to have them. `space` maps the kernels'
    /// space to the scene's.
    ///
    /// # Errors
    /// `Error::Usage` if memory does not hold them.
    pub fn with_channels(self, aovs: &Aovs, space: SceneSpace, light_paths: bool) -> Result<Film> {
        let count = self.pixels.len();
        let mattes = Mattes::new(count, aovs)?;
        Ok(Film { channels: Channels::new(count, aovs, space, light_paths)?, mattes, ..self })
    }

    /// Whether it has sums of the splats of light paths.
    pub fn has_light_paths(&self) -> bool {
        self.channels.light_paths
    }

    /// The channels of `--aov` that it has.
    pub fn aovs(&self) -> &Aovs {
        &self.channels.aovs
    }

    /// The space of the kernels, if the film has channels of `--aov`.
    pub fn space(&self) -> Option<SceneSpace> {
        (!self.channels.aovs.is_empty()).then_some(self.channels.space)
    }

    /// Returns it as the film of a part of an image. The part has the film's size.
    pub fn of_part(self, frame: Frame) -> Film {
        Film { frame, ..self }
    }

    /// Removes all samples.
    pub fn clear(&mut self) {
        self.pixels.fill(Pixel::default());
        self.channels.clear();
        self.mattes.clear();
        self.totals = Totals::default();
    }

    pub fn width(&self) -> u32 {
        self.frame.part.width
    }

    pub fn height(&self) -> u32 {
        self.frame.part.height
    }

    /// Adds the device's totals of pixels, each with its index (row 0 on top, `y * width + x`), and the totals `counted` of the film. Any order
    /// and any split into calls gives the same film. A pixel outside the image is ignored.
    pub fn add<'a>(&mut self, pixels: impl IntoIterator<Item = (usize, &'a PixelTotals)>, counted: Totals) {
        for (index, totals) in pixels {
            if let Some(pixel) = self.pixels.get_mut(index) {
                pixel.add(&Pixel::from(totals));
            }
        }
        self.totals += counted;
    }

    /// Adds the totals of pixels in the layout of the device's film. The indices are those of [`Film::add`].
    /// `motion` finds what channels have of a motion.
    pub fn add_from_device(
        &mut self,
        pixels: impl IntoIterator<Item = usize>,
        bytes: &[u8],
        motion: Option<MotionOf<'_>>,
    ) {
        let each = device_bytes(&self.channels.aovs, self.channels.light_paths) as usize;
        if let (true, Ok(totals)) =
            (each == size_of::<PixelTotals>(), bytemuck::try_cast_slice::<u8, PixelTotals>(bytes))
        {
            return self.add(pixels.into_iter().zip(totals), Totals::default());
        }
        for (index, bytes) in pixels.into_iter().zip(bytes.chunks_exact(each)) {
            let (totals, rest) = bytes.split_at(size_of::<PixelTotals>());
            let (sums, mattes) = rest.split_at(rest.len() - self.channels.aovs.matte_words() * size_of::<u32>());
            let mattes: Vec<u32> = mattes.chunks_exact(size_of::<u32>()).map(bytemuck::pod_read_unaligned).collect();
            self.mattes.add(index, &mattes);
            let totals: PixelTotals = bytemuck::pod_read_unaligned(totals);
            self.channels.add_from_device(index, &totals, sums, motion);
            self.add([(index, &totals)], Totals::default());
        }
    }

    /// Adds another film of the same image. The result is the film of all samples of both.
    pub fn merge(&mut self, other: &Film) -> Result<()> {
        // Splats are divided by the light paths per pixel of the full image.
        let of_light_paths = |film: &Film| film.channels.light_paths.then_some(film.frame.full);
        let aovs = |film: &Film| film.channels.aovs.clone();
        let shape =
            |film: &Film| (film.frame.part.size(), film.exponent, film.sampler, aovs(film), of_light_paths(film));
        if shape(self) != shape(other) {
            let words = |film: &Film, pixels: &str| {
                let light_paths = if film.channels.light_paths { ", with light paths" } else { "" };
                let (width, height) = film.frame.part.size();
                format!("{width} x {height} {pixels}2^{} ({}{light_paths})", film.exponent, film.sampler.word())
            };
            return Err(Error::Usage(format!(
                "films of different images cannot be joined: {} and {}",
                words(self, "pixels of scale "),
                words(other, "of ")
            )));
        }
        self.pixels.iter_mut().zip(&other.pixels).for_each(|(mine, theirs)| mine.add(theirs));
        self.channels.add(&other.channels);
        self.mattes.merge(&other.mattes);
        self.totals += other.totals;
        self.bound.merge(&other.bound);
        Ok(())
    }

    /// The mean over the pixels of the largest component of their radiance, in device units.
    pub fn mean_radiance(&self) -> f64 {
        let largest = |estimate: Estimate| estimate.means().into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.estimates().map(largest).sum::<f64>() / self.pixels.len() as f64
    }

    /// The sums of a pixel that its value and its variance follow from; zeros outside the image.
    fn estimate(&self, index: usize) -> Estimate {
        Estimate {
            pixel: self.pixels.get(index).copied().unwrap_or_default(),
            splats: self.channels.splats(index),
            light_paths: self.light_paths_of_a_pixel(),
        }
    }

    /// The estimates of all pixels.
    fn estimates(&self) -> impl Iterator<Item = Estimate> {
        (0..self.pixels.len()).map(|index| self.estimate(index))
    }

    /// The light paths of even and of odd runs per pixel of the full image; 0 if it has no sums of splats.
    fn light_paths_of_a_pixel(&self) -> [f64; 2] {
        match self.channels.light_paths {
            true => self.totals.light_paths_of_a_pixel(self.frame.full),
            false => [0.0; 2],
        }
    }

    /// Returns the image in scene units.
    pub fn develop(&self) -> Picture {
        let mut picture = Picture { width: self.width(), height: self.height(), ..Picture::default() };
        for pixel in (0..self.pixels.len()).map(|index| self.developed(index)) {
            picture.rgb.push(pixel.rgb);
            picture.variance.push(pixel.variance);
            picture.samples.push(pixel.samples);
            picture.rejected.push(pixel.rejected);
        }
        picture
    }

    /// Returns a pixel in scene units; black outside the image.
    pub fn developed(&self, index: usize) -> PicturePixel {
        let scale = exp2(self.exponent);
        let estimate = self.estimate(index);
        PicturePixel {
            rgb: estimate.means().map(|mean| to_f32(mean * scale)),
            variance: [0, 1, 2].map(|c| variance_to_f32(estimate.variance(c, self.sampler), scale * scale)),
            samples: u32::try_from(estimate.pixel.samples()).unwrap_or(u32::MAX),
            rejected: estimate.pixel.rejected,
        }
    }
}

/// A developed image: linear scene radiance, row 0 on top. Every value is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Mean radiance, linear Rec. 709. Values beyond f32 are f32::MAX.
    pub rgb: Vec<Rgb<f32>>,
    /// Variance of that mean, radiance squared; [`UNKNOWN_VARIANCE`] if it is not known. Above zero it is at least the smallest normal
    /// f32: a smaller variance is overstated, not lost.
    pub variance: Vec<Rgb<f32>>,
    /// Accepted samples.
    pub samples: Vec<u32>,
    /// Rejected samples.
    pub rejected: Vec<u32>,
}

/// A pixel of a [`Picture`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PicturePixel {
    pub rgb: Rgb<f32>,
    pub variance: Rgb<f32>,
    pub samples: u32,
    pub rejected: u32,
}

impl Picture {
    /// One of its pixels.
    pub fn pixel(&self, index: usize) -> PicturePixel {
        PicturePixel {
            rgb: self.rgb[index],
            variance: self.variance[index],
            samples: self.samples[index],
            rejected: self.rejected[index],
        }
    }
}

fn variance_to_f32(variance: Option<f64>, scale: f64) -> f32 {
    match variance {
        None => UNKNOWN_VARIANCE,
        Some(0.0) => 0.0,
        Some(variance) => to_f32(variance * scale).max(f32::MIN_POSITIVE),
    }
}
