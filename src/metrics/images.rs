//! Two images that are compared, and the quantities of their pixels.

use crate::data::{SampleVariance, luminance};

/// A pixel rules the noise if it holds more than this share of it in each image. (With uniform noise in 256 pixels,
/// this happens in 4 of 1e6 images.)
const RULING: f64 = 0.125;
/// At most this many pixels can rule the noise, and at most one of this many pixels.
const FEW: usize = 16;

/// A quantity of pixels to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Luminance,
    Red,
    Green,
    Blue,
}

pub const QUANTITIES: [Quantity; 4] = [Quantity::Luminance, Quantity::Red, Quantity::Green, Quantity::Blue];

impl Quantity {
    pub(super) fn value(self, rgb: [f64; 3]) -> f64 {
        match self {
            Quantity::Luminance => luminance(rgb),
            Quantity::Red => rgb[0],
            Quantity::Green => rgb[1],
            Quantity::Blue => rgb[2],
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Quantity::Luminance => "luminance",
            Quantity::Red => "red",
            Quantity::Green => "green",
            Quantity::Blue => "blue",
        }
    }
}

/// Two images of one size, in linear radiance, with row 0 at the top.
#[derive(Clone, Copy, Debug)]
pub struct Images<'a> {
    pub width: usize,
    pub height: usize,
    pub a: &'a [[f32; 3]],
    /// The reference.
    pub b: &'a [[f32; 3]],
    /// The variances of the pixels' values in a and in b, if both are known.
    pub variances: Option<[&'a [[f32; 3]]; 2]>,
    /// The variances of the samples of each pixel in a and in b, if both are known.
    pub sample_variances: Option<SampleVariances<'a>>,
}

/// The variances of the samples of each pixel of two images.
#[derive(Clone, Copy, Debug)]
pub struct SampleVariances<'a> {
    pub images: [&'a [SampleVariance]; 2],
    /// Whether both are renders of one scene by the same settings, so that their samples have one distribution unless something is wrong.
    pub alike: bool,
}

impl Images<'_> {
    /// The pixels that count.
    pub(super) fn counted(&self) -> impl Iterator<Item = usize> {
        (0..self.width * self.height).filter(|&pixel| self.counts(pixel))
    }

    /// A quantity of a pixel in a and in b.
    pub(super) fn values(&self, quantity: Quantity, pixel: usize) -> [f64; 2] {
        [self.a, self.b].map(|image| quantity.value(image[pixel].map(f64::from)))
    }

    /// Whether the pixel is finite in both images, and therefore counts.
    pub fn counts(&self, pixel: usize) -> bool {
        self.a[pixel].iter().chain(&self.b[pixel]).all(|v| v.is_finite())
    }

    /// The variances of a quantity at a pixel of a and of b. The correlation of a pixel's channels is unknown. They are
    /// assumed to be fully correlated, which is the upper bound (Cauchy-Schwarz: Var Σ w c ≤ (Σ w σ)²), and nearly true
    /// because paths carry all three.
    fn variances(&self, quantity: Quantity, pixel: usize) -> Option<[f64; 2]> {
        let of = |variance: &[[f32; 3]]| quantity.value(variance[pixel].map(|v| f64::from(v).sqrt())).powi(2);
        self.variances.map(|images| images.map(of))
    }

    /// The variance of a quantity's difference at a pixel.
    pub(super) fn variance(&self, quantity: Quantity, pixel: usize) -> Option<f64> {
        self.variances(quantity, pixel).map(|[a, b]| a + b)
    }

    /// The few pixels that rule the noise of both images. Their chance values dominate the mean, and hide the other
    /// pixels. A pixel that is noisy in only one image may have a rare path there; leaving it out would darken that
    /// image. Empty without variances, or if the noise is spread over many pixels.
    pub(super) fn ruling(&self) -> Vec<usize> {
        let known = self.counted().filter_map(|pixel| Some((pixel, self.variances(Quantity::Luminance, pixel)?)));
        let mut left: Vec<(usize, [f64; 2])> = known.collect();
        let few = FEW.min(left.len() / FEW);
        let mut ruling = Vec::new();
        loop {
            let least = [0, 1].map(|image| RULING * left.iter().map(|(_, noise)| noise[image]).sum::<f64>());
            let (rule, rest): (Vec<_>, Vec<_>) =
                left.iter().partition(|(_, noise)| noise[0] > least[0] && noise[1] > least[1]);
            if rule.is_empty() {
                return ruling;
            }
            ruling.extend(rule.iter().map(|(pixel, _)| pixel));
            if ruling.len() > few {
                return Vec::new();
            }
            left = rest;
        }
    }
}
