//! The layers that the window shows, and their colours.

use std::f64::consts::TAU;

use crate::aov::Aov;
use crate::data::Rgb;
use crate::film::{Film, Picture};
use crate::metrics::error::{floor_of, relative_variance};
use crate::output::magma::magma;
use crate::output::view_transform::ViewTransform;

/// A layer of the film, to be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureLayer {
    #[default]
    Radiance,
    /// The standard error of each pixel, relative to its radiance.
    Error,
    /// Channels of `--aov`. Groups of lights have several layers, which `number` counts.
    Of { aov: Aov, number: usize },
}

/// The channels that the window offers.
pub const AOVS: [Aov; 8] =
    [Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Position, Aov::Object, Aov::Material, Aov::Direct, Aov::Indirect];

/// A film as the window shows it.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// Radiance and its variance.
    pub picture: Picture,
    /// The layer that `values` is of. The picture has those of the radiance and its error.
    pub layer: PictureLayer,
    pub values: Vec<Rgb<f32>>,
    /// The layers of groups of lights.
    pub lights: Vec<String>,
    /// The revision of the orders that it is of.
    pub revision: u64,
    /// Whether it is a small one, for the time until the next.
    pub is_small: bool,
    /// The least squared radiance that an error is relative to.
    pub floor: f64,
    pub samples: u64,
    /// Samples of all pixels per second.
    pub pace: f64,
    /// The stated error in words, and why it is not reliable.
    pub error: String,
    pub reasons: Vec<String>,
}

impl Shown {
    /// A layer of a film. Pixels without samples have those of the picture `before`.
    pub fn new(film: &Film, layer: PictureLayer, before: Option<&Shown>) -> Shown {
        let mut picture = film.develop();
        if let Some(before) = before {
            for index in (0..picture.samples.len()).filter(|index| picture.samples[*index] == 0).collect::<Vec<_>>() {
                let (width, height) = (picture.width, picture.height);
                let there = before.index((index as u32 % width, index as u32 / width), (width, height));
                (picture.rgb[index], picture.variance[index]) =
                    (before.picture.rgb[there], before.picture.variance[there]);
            }
        }
        let lights = film.aovs().channels().into_iter().filter(|channel| channel.aov == Aov::Lights);
        let lights = lights.step_by(3).map(|channel| channel.name.trim_end_matches(".R").to_owned()).collect();
        let values = match layer {
            PictureLayer::Of { aov, number } => values(film, aov, number),
            _ => Vec::new(),
        };
        let floor = floor_of(&picture.rgb).max(f64::MIN_POSITIVE);
        Shown { picture, layer, values, lights, floor, ..Shown::default() }
    }

    /// The index of the pixel that is at the position of another one, in an image of another size.
    pub fn index(&self, (x, y): (u32, u32), size: (u32, u32)) -> usize {
        let along = |at: u32, all: u32, own: u32| (u64::from(at) * u64::from(own) / u64::from(all)) as usize;
        let Picture { width, height, .. } = self.picture;
        along(y, size.1, height) * width as usize + along(x, size.0, width)
    }

    /// The standard error of a pixel relative to its radiance; huge where it is not known.
    pub fn error_at(&self, index: usize) -> f64 {
        let (rgb, variance) = (self.picture.rgb[index], self.picture.variance[index]);
        relative_variance(&[variance], &[rgb], self.floor).unwrap_or_default().sqrt()
    }

    /// The colours of all pixels for a screen.
    pub fn colours(&self, view: &ViewTransform) -> Vec<[u8; 3]> {
        let width = self.picture.width as usize;
        let developed = |rgb: &[Rgb<f32>]| {
            rgb.iter().enumerate().map(|(index, rgb)| view.bytes(*rgb, (index % width, index / width))).collect()
        };
        match self.layer {
            PictureLayer::Radiance => developed(&self.picture.rgb),
            // By the logarithm: black for 0.1 %, and white for 100 %.
            PictureLayer::Error => {
                (0..self.picture.rgb.len()).map(|index| magma(1.0 + self.error_at(index).log10() / 3.0)).collect()
            }
            // They are not there before the film has the channel.
            PictureLayer::Of { .. } if self.values.is_empty() => developed(&self.picture.rgb),
            PictureLayer::Of { aov: Aov::Albedo | Aov::Direct | Aov::Indirect | Aov::Lights, .. } => {
                developed(&self.values)
            }
            PictureLayer::Of { aov, .. } => colours_of(aov, &self.values),
        }
    }
}

/// The values of a layer; one value stands in all three channels.
fn values(film: &Film, aov: Aov, number: usize) -> Vec<Rgb<f32>> {
    let channels = film.aovs().channels().into_iter().filter(|channel| channel.aov == aov);
    let channels: Vec<_> = channels.skip(3 * number).take(3).collect();
    let Some(first) = channels.first() else { return Vec::new() };
    let pixels = film.width() as usize * film.height() as usize;
    let value = |index, component: usize| film.channel(index, channels.get(component).unwrap_or(first));
    (0..pixels).map(|index| [0, 1, 2].map(|component| value(index, component))).collect()
}

/// Colours of channels that are no light, from their least value to the largest.
fn colours_of(aov: Aov, values: &[Rgb<f32>]) -> Vec<[u8; 3]> {
    let known = values.iter().flatten().filter(|value| value.abs() < f32::MAX);
    let start = (f32::INFINITY, f32::NEG_INFINITY);
    let (least, most) = known.fold(start, |(least, most), value| (least.min(*value), most.max(*value)));
    // `as` makes 0 of a range without a length.
    let code = |value: f32| (255.0 * ((value - least) / (most - least)).clamp(0.0, 1.0)) as u8;
    let colour = |value: &Rgb<f32>| match aov {
        Aov::Object | Aov::Material => of_number(value[0] as u32),
        // Near is bright, and what is beyond everything is black.
        Aov::Depth => value.map(|depth| 255 - code(depth)),
        _ => value.map(code),
    };
    values.iter().map(colour).collect()
}

/// A colour for a number, unlike those of its neighbours; black for 0. Steps of the golden ratio are spread evenly.
fn of_number(number: u32) -> [u8; 3] {
    let hue = |offset: f64| TAU * (f64::from(number) * 0.618_033_988_749_895 + offset);
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|offset| if number == 0 { 0 } else { (150.0 + 105.0 * hue(offset).cos()) as u8 })
}
