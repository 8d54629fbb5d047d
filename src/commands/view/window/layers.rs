//! The layers that the window shows, and their colours.

use crate::aov::Aov;
use crate::data::{Rgb, luminance, srgb};
use crate::film::{Film, Picture, UNKNOWN_VARIANCE};
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

/// The relative error that the map shows as white.
const WHITE_ERROR: f64 = 1.0;
/// The error that it shows as black.
const BLACK_ERROR: f64 = 1e-3;

/// A film as the window shows it.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    pub size: (u32, u32),
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
    /// The least squared radiance that an error is relative to, as in [`Film::relative_error`].
    floor: f64,
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
        let size = (picture.width, picture.height);
        if let Some(before) = before {
            for index in (0..picture.samples.len()).filter(|index| picture.samples[*index] == 0).collect::<Vec<_>>() {
                let (x, y) = (index as u32 % size.0, index as u32 / size.0);
                let there = before.index((x, y), size);
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
        let luminances = picture.rgb.iter().map(|rgb| luminance(rgb.map(f64::from)));
        let mean = luminances.sum::<f64>() / picture.rgb.len() as f64;
        Shown { size, picture, layer, values, lights, floor: 0.01 * mean * mean, ..Shown::default() }
    }

    /// The index of the pixel that is at the position of another one, in an image of another size.
    pub fn index(&self, (x, y): (u32, u32), size: (u32, u32)) -> usize {
        let along = |at: u32, all: u32, own: u32| (u64::from(at) * u64::from(own) / u64::from(all)) as usize;
        along(y, size.1, self.size.1) * self.size.0 as usize + along(x, size.0, self.size.0)
    }

    /// The standard error of a pixel relative to its radiance; infinite where it is not known.
    pub fn error_at(&self, index: usize) -> f64 {
        let (rgb, variance) = (self.picture.rgb[index], self.picture.variance[index]);
        let of_channel = |c: usize| match variance[c] {
            UNKNOWN_VARIANCE => f64::INFINITY,
            variance => f64::from(variance) / (f64::from(rgb[c]).powi(2) + self.floor).max(f64::MIN_POSITIVE),
        };
        ([0, 1, 2].map(of_channel).iter().sum::<f64>() / 3.0).sqrt()
    }

    /// The colours of all pixels for a screen.
    pub fn colours(&self, view: &ViewTransform) -> Vec<[u8; 3]> {
        let width = self.size.0 as usize;
        let developed = |rgb: &[Rgb<f32>]| {
            rgb.iter().enumerate().map(|(index, rgb)| view.bytes(*rgb, (index % width, index / width))).collect()
        };
        match self.layer {
            PictureLayer::Radiance => developed(&self.picture.rgb),
            PictureLayer::Error => (0..self.picture.rgb.len()).map(|index| of_error(self.error_at(index))).collect(),
            // They are not there before the film has the channel.
            PictureLayer::Of { .. } if self.values.is_empty() => developed(&self.picture.rgb),
            PictureLayer::Of { aov: Aov::Direct | Aov::Indirect | Aov::Lights, .. } => developed(&self.values),
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

/// From black for 0.1 % to white for 100 %, by the logarithm.
fn of_error(error: f64) -> [u8; 3] {
    magma((error / BLACK_ERROR).log10() / (WHITE_ERROR / BLACK_ERROR).log10())
}

fn colours_of(aov: Aov, values: &[Rgb<f32>]) -> Vec<[u8; 3]> {
    let code = |share: f64| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let is_known = |value: &f32| value.is_finite() && value.abs() < f32::MAX;
    let range = |component: usize| {
        let known = values.iter().map(|value| value[component]).filter(is_known);
        known.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)))
    };
    let ranges = [0, 1, 2].map(range);
    let share = |value: Rgb<f32>, c: usize| {
        let (least, most) = ranges[c];
        (f64::from(value[c]) - f64::from(least)) / (f64::from(most) - f64::from(least)).max(f64::MIN_POSITIVE)
    };
    let colour = |value: &Rgb<f32>| match aov {
        Aov::Albedo => value.map(|value| code(srgb(f64::from(value)))),
        Aov::Normal | Aov::Normal0 => value.map(|value| code(0.5 + 0.5 * f64::from(value))),
        Aov::Object | Aov::Material | Aov::Face0 => of_number(value[0] as u32),
        // Near is bright, and what is beyond everything is black.
        Aov::Depth | Aov::Depth0 | Aov::Distance0 if !is_known(&value[0]) => [0; 3],
        Aov::Depth | Aov::Depth0 | Aov::Distance0 => magma(1.0 - share(*value, 0)),
        _ => [0, 1, 2].map(|c| code(share(*value, c))),
    };
    values.iter().map(colour).collect()
}

/// A colour for a number, unlike those of its neighbours; black for 0. Steps of the golden ratio are spread evenly.
fn of_number(number: u32) -> [u8; 3] {
    if number == 0 {
        return [0; 3];
    }
    let hue = (f64::from(number) * 0.618_033_988_749_895).fract();
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|offset| {
        let along = (hue + offset).fract();
        (255.0 * (0.25 + 0.75 * (6.0 * (along - 0.5).abs() - 1.0).clamp(0.0, 1.0))) as u8
    })
}
