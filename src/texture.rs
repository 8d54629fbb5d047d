//! Textures: colours that vary over a surface or in space. This file has everything that the host knows about them.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Deserializer, Serialize};

use crate::bitmap::{Bitmap, Bitmaps, Channel, Decoding, Format};
use crate::data::{self, f32s, luminance};
use crate::error::{Error, Result};
use crate::source::declare::declare;
use crate::source::form::{Checked, Field, Form, PATH, Takes, colour, flag, integer, number, other};
use crate::source::{NO_UNIT, Range, SCENE_UNITS, ValuePath};

/// A linear Rec. 709 colour: red, green, blue.
pub type Colour = DVec3;

/// Each texture of a glTF material may have a set of its own, and these are few.
const MOST_UV_SETS: u32 = 16;

/// The range of a channel depends on the material's slot, which has it.
const CHANNEL: Field = number(Range::ANY, NO_UNIT);
const COLOUR: Field = colour(Range::ANY);
const FREQUENCY: Field = number(Range::POSITIVE, "per scene unit");

/// How an image on a mesh goes on outside of 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Wrap {
    #[default]
    Repeat,
    /// By the texels at its edges.
    Clamp,
    Mirror,
}

impl Checked for Wrap {}

declare! {
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub enum Texture {
        /// One colour everywhere, linear Rec. 709.
        Rgb: rgb, "Rgb(0.7, 0.3, 0.2)" (
            /// Red.
            r: f64 = CHANNEL;
            /// Green.
            g: f64 = CHANNEL;
            /// Blue.
            b: f64 = CHANNEL;
        )
        /// Cubes of two colours that take turns along each axis.
        Checker: checker, "Checker(scale: 0.5, even: (0.2, 0.3, 0.1), odd: (0.9, 0.9, 0.9))" {
            /// The side of a cube.
            scale: f64 = number(Range::POSITIVE, SCENE_UNITS);
            /// Where the sum of floor(p / scale) over the coordinates is even.
            even: Colour = COLOUR;
            /// Where it is odd.
            odd: Colour = COLOUR;
            /// Squares in texture coordinates, in place of cubes in space. A side of 1 is that of an image.
            @default uv: bool = flag().or("false");
        }
        /// An image on the surface: u to the right, v up. A mesh needs texture coordinates for it; a medium has none.
        Image: image, "Image(path: \"textures/planet.png\")" {
            /// A PNG, JPEG, BMP, TGA, TIFF, WebP or KTX2 (Basis Universal) in sRGB, or a linear HDR or EXR; or an image of a glTF file, such as
            /// `room.glb#images/0`.
            path: String = other(PATH);
            /// What its colours are multiplied by.
            #[serde(default = "white")]
            tint: Colour = COLOUR.or("(1, 1, 1)");
            /// Of a number, such as a roughness: its channel. Its codes are linear, and the red of `tint` is its factor. Of a colour: Rgb if its
            /// codes are linear.
            @default channel: Option<Channel> = other("R, G, B, A or Rgb").or("for a number R");
            /// On a mesh: its set of texture coordinates. A part of a glTF file has one for each pair of TEXCOORD and KHR_texture_transform
            /// among its material's textures; other meshes have one.
            #[serde(default, skip_serializing_if = "is_first")]
            uv_set: u32 = integer(0, MOST_UV_SETS - 1).or("0, the first");
            /// On a mesh: how it goes on outside of 0 to 1.
            @default wrap: Wrap = other("Repeat, Clamp or Mirror").or("Repeat");
        }
        /// Perlin noise as a grey: 0.5 (1 + perlin(scale · p)).
        Noise: noise, "Noise(scale: 4)" {
            /// Detail: a larger number makes finer patterns.
            scale: f64 = FREQUENCY;
        }
        /// Marble as a grey: 0.5 (1 + sin(scale · z + 10 turbulence(p))), with seven octaves of Perlin noise.
        Marble: marble, "Marble(scale: 4)" {
            scale: f64 = noise::FIELDS.scale;
        }
    }
}

impl Checked for Channel {}

impl Checked for Texture {
    /// Checks a number that may vary where it does not.
    fn check_as(&self, field: &Field, above: &ValuePath) -> Result<()> {
        match (field.takes, self.plain()) {
            (Takes::Varying(_), Some(grey)) => field.check(above, grey.x),
            _ => Ok(()),
        }
    }
}

pub fn white() -> Colour {
    Colour::ONE
}

fn is_first(uv_set: &u32) -> bool {
    *uv_set == 0
}

/// A texture of numbers: a material's number that may vary over a surface. It is written as a number where it is the same everywhere.
pub mod number {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Texture;
    use crate::bitmap::Channel;

    /// The error about what is neither; its words are never seen (src/scene/explain.rs).
    pub const NEITHER: &str = "neither a number nor a texture";

    #[derive(Deserialize)]
    #[serde(untagged, expecting = "neither a number nor a texture")]
    enum Written {
        Number(f64),
        Texture(Texture),
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Texture, D::Error> {
        Ok(match Written::deserialize(from)? {
            Written::Number(x) => Texture::grey(x),
            Written::Texture(texture) => texture.or_channel(Channel::default()),
        })
    }

    pub fn serialize<S: Serializer>(texture: &Texture, to: S) -> Result<S::Ok, S::Error> {
        match texture.plain() {
            Some(grey) => grey.x.serialize(to),
            None => texture.serialize(to),
        }
    }
}

/// Reads a normal map: an image, of which all channels are numbers.
pub fn normal_map<'a, D: Deserializer<'a>>(from: D) -> std::result::Result<Option<Texture>, D::Error> {
    Ok(Option::<Texture>::deserialize(from)?.map(|texture| texture.or_channel(Channel::Rgb)))
}

/// The shader files of the textures that are no plain colour, under shaders/texture. Kernels switch on the indices.
pub const TEXTURES: &[&str] = &["checker", "image", "noise", "marble", "uv_checker"];

/// The meaning of a texture's values, which determines their range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// The share of light that is not absorbed: 0 to 1.
    Albedo,
    /// The same where white traps no path, since other parts of the material absorb light, or light leaves a body.
    Tint,
    /// Emitted light: 0, or 1e-30 to 1e30.
    Radiance,
    /// A number from 0 to 1: the red of the texture.
    Share,
    /// A normal map: an image alone, each channel 0 to 1.
    Normal,
    /// A direction in red and green, and a share in blue: an image, or the same everywhere.
    Direction,
}

/// The largest radiance, and the smallest other than zero. Both are normal numbers in f32.
pub const LARGEST_RADIANCE: f64 = 1e30;
pub const SMALLEST_RADIANCE: f64 = 1e-30;

impl Use {
    /// The range of a channel.
    pub const fn range(self) -> Range {
        match self {
            Use::Albedo | Use::Tint | Use::Share | Use::Normal | Use::Direction => Range::SHARE,
            Use::Radiance => Range::from_to(SMALLEST_RADIANCE, LARGEST_RADIANCE).or_zero(),
        }
    }

    /// Refuses a colour with a channel out of range.
    pub fn check(self, at: &ValuePath, colour: Colour) -> Result<()> {
        let name = match self {
            Use::Albedo | Use::Tint => "albedo",
            Use::Radiance => "radiance",
            Use::Share => "share",
            Use::Normal => "normal",
            Use::Direction => "direction",
        };
        self.range().check_each(at, name, colour)
    }

    /// Refuses an image with a texel out of range, and names the first one; also one that `tint` makes too bright.
    pub fn check_texels(self, bitmap: &Bitmap, tint: Colour) -> std::result::Result<(), String> {
        let (expected, range): (_, RangeInclusive<f32>) = match self {
            Use::Albedo | Use::Tint => ("an albedo from 0 to 1", 0.0..=1.0),
            Use::Share => ("numbers from 0 to 1", 0.0..=1.0),
            Use::Normal | Use::Direction => ("codes from 0 to 1", 0.0..=1.0),
            Use::Radiance => ("a radiance from 0 to 1e30", 0.0..=LARGEST_RADIANCE as f32),
        };
        let fits = |texel: &[f32; 3]| texel.iter().all(|c| range.contains(c));
        // Codes stand for numbers from 0 to 1.
        let outside = match bitmap.format {
            Format::Float => bitmap.texels().position(|texel| !fits(&texel)),
            Format::Srgb | Format::Linear | Format::Number => None,
        };
        let Some(index) = outside else {
            let brightest = if tint.max_element() > 1.0 { bitmap.brightest(tint) } else { 0.0 };
            return match brightest > f64::from(*range.end()) {
                true => Err(format!("expected {expected}, found {brightest:?} with its tint")),
                false => Ok(()),
            };
        };
        let [r, g, b] = bitmap.texel(index);
        let (x, y) = (index % bitmap.width as usize, index / bitmap.width as usize);
        Err(format!("expected {expected}, found ({r:?}, {g:?}, {b:?}) at texel ({x}, {y}) from the top left"))
    }
}

impl Bitmap {
    /// The largest channel of all texels, each multiplied by `tint`.
    pub fn brightest(&self, tint: Colour) -> f64 {
        (tint * self.largest_channels()).max_element()
    }

    /// The largest red, green and blue of all texels.
    fn largest_channels(&self) -> Colour {
        self.texels().map(|texel| DVec3::from_array(texel.map(f64::from))).fold(DVec3::ZERO, DVec3::max)
    }
}

impl From<Colour> for Texture {
    fn from(Colour { x, y, z }: Colour) -> Texture {
        Texture::Rgb(x, y, z)
    }
}

impl Texture {
    /// Refuses numbers that are invalid, or out of range for the use of the texture.
    pub fn check(&self, at: &ValuePath, usage: Use) -> Result<()> {
        let at = at.variant(self.name());
        image::FIELDS.uv_set.check_integer(&at, self.uv_set())?;
        match self {
            Texture::Image { tint: Colour::ONE, channel: Some(Channel::Rgb), .. }
                if matches!(usage, Use::Normal | Use::Direction) =>
            {
                Ok(())
            }
            Texture::Rgb(..) if usage == Use::Direction => Ok(()),
            _ if usage == Use::Direction => {
                Err(at.unexpected("an image of directions: Image(path: ..), without a tint"))
            }
            _ if usage == Use::Normal => Err(at.unexpected("a normal map: Image(path: ..), without a tint")),
            Texture::Image { channel: Some(Channel::Rgb), .. } if usage == Use::Share => {
                Err(at.field(image::FIELDS.channel.name).error("a number has one channel: R, G, B or A"))
            }
            Texture::Rgb(r, g, b) => usage.check(&at, DVec3::new(*r, *g, *b)),
            Texture::Checker { scale, even, odd, .. } => {
                checker::FIELDS.scale.check(&at, *scale)?;
                usage.check(&at.field("even"), *even)?;
                usage.check(&at.field("odd"), *odd)
            }
            Texture::Image { channel: Some(Channel::R | Channel::G | Channel::B | Channel::A), .. }
                if usage != Use::Share =>
            {
                Err(at
                    .field(image::FIELDS.channel.name)
                    .error("a colour has all channels: expected none, or Rgb if its codes are linear"))
            }
            Texture::Image { tint, .. } => usage.check(&at.field(image::FIELDS.tint.name), *tint),
            Texture::Noise { scale } | Texture::Marble { scale } => noise::FIELDS.scale.check(&at, *scale),
        }
    }

    /// The colour, if it is the same everywhere.
    pub fn plain(&self) -> Option<Colour> {
        match self {
            Texture::Rgb(r, g, b) => Some(DVec3::new(*r, *g, *b)),
            Texture::Checker { .. } | Texture::Image { .. } | Texture::Noise { .. } | Texture::Marble { .. } => None,
        }
    }

    /// Whether it needs texture coordinates.
    pub fn needs_uv(&self) -> bool {
        matches!(self, Texture::Image { .. } | Texture::Checker { uv: true, .. })
    }

    /// The set of a mesh's texture coordinates that its image has.
    pub fn uv_set(&self) -> u32 {
        match self {
            Texture::Image { uv_set, .. } => *uv_set,
            Texture::Rgb(..) | Texture::Checker { .. } | Texture::Noise { .. } | Texture::Marble { .. } => 0,
        }
    }

    /// How it goes on outside of 0 to 1.
    pub fn wrap(&self) -> Wrap {
        if let Texture::Image { wrap, .. } = self { *wrap } else { Wrap::Repeat }
    }

    /// The path of its image, and how it is decoded.
    pub fn decoded(&self) -> Option<(&String, Decoding)> {
        match self {
            Texture::Image { path, channel, .. } => Some((path, channel.map_or(Decoding::Colour, Channel::decoding))),
            _ => None,
        }
    }

    /// Its decoded image.
    pub fn bitmap<'a>(&self, bitmaps: &'a Bitmaps) -> Option<&'a Bitmap> {
        let (path, decoding) = self.decoded()?;
        bitmaps.get(path, decoding)
    }

    /// The texture with this channel, if it is an image without one.
    fn or_channel(mut self, given: Channel) -> Texture {
        if let Texture::Image { channel, .. } = &mut self {
            channel.get_or_insert(given);
        }
        self
    }

    /// The texture with its colours changed; that of an image is its tint.
    pub fn map(self, change: impl Fn(Colour) -> Colour) -> Texture {
        match self {
            Texture::Rgb(r, g, b) => change(Colour::new(r, g, b)).into(),
            Texture::Checker { scale, even, odd, uv } => {
                Texture::Checker { scale, even: change(even), odd: change(odd), uv }
            }
            Texture::Image { path, tint, channel, uv_set, wrap } => {
                Texture::Image { path, tint: change(tint), channel, uv_set, wrap }
            }
            other => other,
        }
    }

    /// A texture with the same number everywhere.
    pub const fn grey(x: f64) -> Texture {
        Texture::Rgb(x, x, x)
    }

    /// The least of its numbers.
    pub fn least(&self, bitmaps: &Bitmaps) -> f64 {
        match self {
            Texture::Rgb(x, ..) => *x,
            Texture::Checker { even, odd, .. } => even.x.min(odd.x),
            Texture::Image { tint, .. } => {
                let least = |bitmap: &Bitmap| bitmap.texels().map(|texel| texel[0]).fold(f32::INFINITY, f32::min);
                self.bitmap(bitmaps).map_or(0.0, |bitmap| tint.x * f64::from(least(bitmap)))
            }
            Texture::Noise { .. } | Texture::Marble { .. } => 0.0,
        }
    }

    /// Its index in `TEXTURES`; none for a plain colour.
    pub fn shader_number(&self) -> Option<usize> {
        match self {
            Texture::Rgb(..) => None,
            Texture::Checker { uv: false, .. } => Some(0),
            Texture::Checker { uv: true, .. } => Some(4),
            Texture::Image { .. } => Some(1),
            Texture::Noise { .. } => Some(2),
            Texture::Marble { .. } => Some(3),
        }
    }

    /// The largest channel of all its colours.
    pub fn brightest(&self, bitmaps: &Bitmaps) -> f64 {
        self.largest_channels(bitmaps).max_element()
    }

    /// The largest red, green and blue of all its colours.
    pub fn largest_channels(&self, bitmaps: &Bitmaps) -> Colour {
        match self {
            Texture::Rgb(r, g, b) => DVec3::new(*r, *g, *b),
            Texture::Checker { even, odd, .. } => even.max(*odd),
            Texture::Image { tint, .. } => {
                self.bitmap(bitmaps).map_or(DVec3::ZERO, |bitmap| *tint * bitmap.largest_channels())
            }
            Texture::Noise { .. } | Texture::Marble { .. } => DVec3::ONE,
        }
    }

    /// The luminance of its mean colour.
    pub fn mean_luminance(&self, bitmaps: &Bitmaps) -> f64 {
        match self {
            Texture::Rgb(r, g, b) => luminance([*r, *g, *b]),
            Texture::Checker { even, odd, .. } => luminance((0.5 * (*even + *odd)).to_array()),
            Texture::Image { tint, .. } => self.bitmap(bitmaps).map_or(0.0, |bitmap| {
                let sum: DVec3 = bitmap.texels().map(|t| DVec3::from_array(t.map(f64::from))).sum();
                luminance((*tint * sum / bitmap.len().max(1) as f64).to_array())
            }),
            Texture::Noise { .. } | Texture::Marble { .. } => 0.5,
        }
    }

    /// Whether a channel is 1: of one of its colours, or of all texels of its image.
    pub fn is_white(&self, bitmaps: &Bitmaps) -> bool {
        match self {
            Texture::Rgb(r, g, b) => [*r, *g, *b].contains(&1.0),
            Texture::Checker { even, odd, .. } => even.max(*odd).max_element() == 1.0,
            // Single white texels deserve no warning.
            Texture::Image { tint, .. } => self.bitmap(bitmaps).is_some_and(|image| {
                (0..3).any(|channel| tint[channel] == 1.0 && image.texels().all(|texel| texel[channel] >= 1.0))
            }),
            Texture::Noise { .. } | Texture::Marble { .. } => false,
        }
    }

    /// Whether it is an image of numbers, in one of its channels.
    pub fn is_number(&self) -> bool {
        matches!(self, Texture::Image { channel: Some(channel), .. } if *channel != Channel::Rgb)
    }

    /// The struct that kernels read, with values multiplied by `brightness`; none for a plain colour. `add_image`
    /// returns the index of an image's first word.
    pub fn upload(
        &self,
        brightness: f64,
        bitmaps: &Bitmaps,
        mut add_image: impl FnMut(&str, Decoding, &Bitmap) -> u32,
    ) -> Option<data::Texture> {
        let kind = self.shader_number()? as u32;
        let mut texture = data::Texture { first: f32s(DVec3::splat(brightness)), kind, ..data::Texture::default() };
        match self {
            Texture::Checker { scale, even, odd, .. } => {
                texture.first = f32s(brightness * *even);
                texture.second = f32s(brightness * *odd);
                texture.parameter = (1.0 / scale) as f32;
            }
            Texture::Marble { scale } => texture.parameter = *scale as f32,
            Texture::Image { tint, .. } => {
                texture.first = f32s(brightness * *tint);
                texture.parameter = f32::from(u8::from(self.is_number()));
                if let (Some((path, decoding)), Some(bitmap)) = (self.decoded(), self.bitmap(bitmaps)) {
                    texture.format = bitmap.format.number() as u32;
                    texture.texel = add_image(path, decoding, bitmap);
                    texture.width = bitmap.width;
                    texture.height = bitmap.height;
                }
            }
            Texture::Rgb(..) | Texture::Noise { .. } => {}
        }
        Some(texture)
    }

    /// The frame of the texture: it maps local coordinates to the point base + columns · local in the object's own
    /// space, in the texture's units. The base is reduced by the texture's period, in f64. For an image it maps them to
    /// the normal of a sphere, as pole + the rotation undone · local, and so for directions without one. Any other plain colour needs no frame.
    pub fn frame(
        &self,
        usage: Use,
        (base, columns): (DVec3, DMat3),
        (pole, rotation): (DVec3, &DMat3),
    ) -> Option<data::Frame> {
        let (base, columns, phase) = match *self {
            Texture::Checker { uv: true, .. } => return Some(Texture::frame_of_coordinates(pole, rotation)),
            Texture::Rgb(..) if usage != Use::Direction => return None,
            Texture::Checker { scale, .. } => (reduce(base / scale, 2.0), columns * (1.0 / scale), 0.0),
            Texture::Noise { scale } => (reduce(base * scale, 256.0), columns * scale, 0.0),
            Texture::Marble { scale } => (reduce(base, 256.0), columns, reduce(DVec3::splat(base.z * scale), TAU).z),
            Texture::Image { .. } | Texture::Rgb(..) => return Some(Texture::frame_of_coordinates(pole, rotation)),
        };
        Some(frame_of(base, columns, phase))
    }

    /// The frame of texture coordinates, which spheres have by the directions of their points.
    pub fn frame_of_coordinates(pole: DVec3, rotation: &DMat3) -> data::Frame {
        frame_of(pole, rotation.transpose(), 0.0)
    }
}

fn frame_of(base: DVec3, columns: DMat3, phase: f64) -> data::Frame {
    data::Frame {
        x: f32s(columns.x_axis),
        phase: phase as f32,
        y: f32s(columns.y_axis),
        z: f32s(columns.z_axis),
        origin: f32s(base),
        ..data::Frame::default()
    }
}

/// Each coordinate minus an integer number of periods, within half a period of zero.
fn reduce(v: DVec3, period: f64) -> DVec3 {
    v - period * (v / period).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::form::{TEXTURE, any_of};

    #[test]
    fn the_words_for_a_texture_name_all_kinds() {
        assert_eq!(TEXTURE, format!("a texture: {}", any_of(Texture::FORMS.iter())));
    }
}
