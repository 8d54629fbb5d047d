//! The job of a render: the image size, the range of samples, and when it ends.

use std::ops::Range;
use std::str::FromStr;
use std::time::Instant;

use crate::data::RUN_LENGTH;

/// A part of an image, in pixels from its left upper corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

impl std::fmt::Display for Crop {
    /// As `--crop` takes it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{},{},{}", self.left, self.top, self.width, self.height)
    }
}

/// The part of an image that is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    pub part: Crop,
    /// Width and height of the full image.
    pub full: (u32, u32),
}

impl Frame {
    /// All of an image.
    pub fn full(size: (u32, u32)) -> Frame {
        Frame { part: Crop::full(size), full: size }
    }

    /// The part, if it is not all of the image.
    pub fn crop(&self) -> Option<Crop> {
        (self.part != Crop::full(self.full)).then_some(self.part)
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Crop, String> {
        let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[left, top, width, height]) if width > 0 && height > 0 => Ok(Crop { left, top, width, height }),
            _ => Err("expected X,Y,WIDTH,HEIGHT in pixels, such as 100,50,320,180".to_string()),
        }
    }
}

impl Crop {
    /// The part of an image of this size that is all of it.
    pub fn full((width, height): (u32, u32)) -> Crop {
        Crop { left: 0, top: 0, width, height }
    }

    /// Width and height.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Whether an image of this size has it.
    pub fn is_in(&self, (width, height): (u32, u32)) -> bool {
        let within = |first: u32, count: u32, all: u32| u64::from(first) + u64::from(count) <= u64::from(all);
        within(self.left, self.width, width) && within(self.top, self.height, height)
    }
}

/// The longest side of an image, in pixels.
pub const MOST_SIDE: u32 = 65_536;

/// The size of an image: in pixels, or relative to the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    Pixels(u32, u32),
    /// The width. The height follows from the scene's aspect.
    Width(u32),
    Share(f64),
}

impl Size {
    /// The size in pixels, at least one in each direction.
    pub fn in_pixels(self, (width, height): (u32, u32)) -> (u32, u32) {
        match self {
            Size::Pixels(width, height) => (width, height),
            Size::Width(own) => {
                let part = (f64::from(height) * f64::from(own) / f64::from(width)).round();
                (own, (part as u32).clamp(1, MOST_SIDE))
            }
            Size::Share(share) => {
                let part = |n: u32| ((f64::from(n) * share).round() as u32).max(1);
                (part(width), part(height))
            }
        }
    }
}

impl FromStr for Size {
    type Err = String;

    /// The limits are those of a scene's `image`; a share is at most 100 % of the scene's size.
    fn from_str(text: &str) -> Result<Size, String> {
        let expected = || {
            "expected WIDTHxHEIGHT from 1x1 to 65536x65536, 2^30 pixels at most, such as 640x360, a width such as 640, or a share of the \
             scene's size up to 100%"
                .to_string()
        };
        if let Some(percent) = text.strip_suffix('%') {
            let share = percent.parse::<f64>().ok().filter(|percent| *percent > 0.0 && *percent <= 100.0);
            return share.map(|percent| Size::Share(percent / 100.0)).ok_or_else(expected);
        }
        let number = |text: &str| text.parse::<u32>().ok().filter(|n| (1..=MOST_SIDE).contains(n)).ok_or_else(expected);
        let Some((width, height)) = text.split_once(['x', 'X']) else {
            // A square of this width has few enough pixels.
            return number(text).map(Size::Width);
        };
        let (width, height) = (number(width)?, number(height)?);
        match u64::from(width) * u64::from(height) <= 1 << 30 {
            true => Ok(Size::Pixels(width, height)),
            false => Err(expected()),
        }
    }
}

/// The most samples of a pixel. Sample indices are 32-bit words, and must leave room to round up to a block.
pub const MOST_SAMPLES: i64 = 1 << 31;

/// The job of a render.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Width and height in pixels: of the image, or of the part of it that is rendered.
    pub size: (u32, u32),
    /// The most scattering events of a path.
    pub max_depth: u32,
    pub seed: u32,
    /// The first sample of each pixel.
    pub first_sample: u32,
    pub goal: Goal,
}

/// The condition that ends a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// One past the index of the last sample of each pixel.
    Samples(u32),
    /// As many samples as fit before the deadline: at least one, and at most those below `end`.
    Until { deadline: Instant, end: u32 },
    /// Until the relative error is below `error`, the deadline is reached, or `end` is reached. A render that goes on with another says with
    /// which sample that one began, and how often the error has been checked.
    Noise { error: f64, deadline: Option<Instant>, end: u32, begun: u32, checks: u32 },
}

impl Goal {
    /// One past the index of the last sample that a pixel may get.
    pub fn end(&self) -> u32 {
        match *self {
            Goal::Samples(end) | Goal::Until { end, .. } | Goal::Noise { end, .. } => end,
        }
    }

    /// The time of `--time` at which the render ends, if there is one.
    pub fn deadline(&self) -> Option<Instant> {
        match *self {
            Goal::Until { deadline, .. } => Some(deadline),
            Goal::Noise { deadline, .. } => deadline,
            Goal::Samples(_) => None,
        }
    }
}

impl Job {
    /// The number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }

    /// The number of paths, if it is known in advance.
    pub fn paths(&self) -> Option<u64> {
        Some(self.pixels() * self.samples()?.len() as u64)
    }

    /// The number of runs, if it is known in advance.
    pub fn runs(&self) -> Option<u64> {
        Some(self.pixels() * blocks(self.samples()?).len() as u64)
    }

    fn samples(&self) -> Option<Range<u32>> {
        match self.goal {
            Goal::Samples(end) => Some(self.first_sample..end),
            Goal::Until { .. } | Goal::Noise { .. } => None,
        }
    }
}

/// The blocks of RUN_LENGTH samples that a range of samples overlaps.
pub fn blocks(samples: Range<u32>) -> Range<u32> {
    samples.start / RUN_LENGTH..samples.end.div_ceil(RUN_LENGTH)
}

/// The light paths that belong to a range of samples, where a block of samples has so many. Each sample has an equal share of those of its
/// block, but for the last ones, which may have fewer or none (shaders/light_path/light_sample.wgsl).
pub fn light_paths_of(samples: &Range<u32>, of_block: u64) -> u64 {
    let of_sample = of_block.div_ceil(u64::from(RUN_LENGTH));
    let before = |sample: u32| {
        let (block, within) = (u64::from(sample / RUN_LENGTH), u64::from(sample % RUN_LENGTH));
        block * of_block + (within * of_sample).min(of_block)
    };
    before(samples.end).saturating_sub(before(samples.start))
}

/// The samples of a range that are in these blocks.
pub fn samples_of(blocks: &Range<u32>, samples: &Range<u32>) -> Range<u32> {
    let end_of = |block: u32| block.saturating_mul(RUN_LENGTH);
    end_of(blocks.start).max(samples.start)..end_of(blocks.end).min(samples.end)
}
