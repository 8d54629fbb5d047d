//! The host's side of shaders/data, which build.rs writes from the WGSL, and the little that all of the host shares.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The most primitives of one kind.
pub const MAX_PRIMITIVES: usize = 1 << PRIMITIVE_KIND_SHIFT;
/// Samples of a run at most; runs are cut at multiples of it.
pub const RUN_LENGTH: u32 = 8;
/// Sums of radiance and of its squares that the film has of each pixel: of even runs, of odd ones, and the squared deviations.
pub const FILM_SUMS: usize = 3 * CHANNELS.len();
/// Sums of splats that a film with light paths has of each pixel: of even runs, of odd ones, and the squares.
pub const SPLAT_SUMS: usize = 3 * CHANNELS.len();

/// The colour channels of records, film and images, by the names that an EXR has for them.
pub const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// A value for each of them.
pub type Rgb<T> = [T; CHANNELS.len()];

/// The variance of the samples of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleVariance {
    /// The variance of a sample, radiance squared; infinite if it is not known.
    pub variance: Rgb<f32>,
    /// The degrees of freedom of this estimate.
    pub degrees: u32,
    pub samples: u32,
}

/// A pixel that lamps cover in part, as the camera would see them if nothing hid them. Radiance is in device units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "LampPixelNumbers", into = "LampPixelNumbers")]
pub struct LampPixel {
    /// The pixel's index.
    pub pixel: u32,
    /// How many pixels it stands for.
    pub count: f32,
    /// The lamp that adds most.
    pub lamp: u32,
    /// The share of its samples that see a lamp.
    pub share: f32,
    /// The mean of the radiance that its samples see of lamps, and of the square.
    pub mean: Rgb<f32>,
    pub square: Rgb<f32>,
}

/// Its members in their order, without names: files may have a thousand of them.
type LampPixelNumbers = (u32, f32, u32, f32, Rgb<f32>, Rgb<f32>);

impl From<LampPixel> for LampPixelNumbers {
    fn from(LampPixel { pixel, count, lamp, share, mean, square }: LampPixel) -> LampPixelNumbers {
        (pixel, count, lamp, share, mean, square)
    }
}

impl From<LampPixelNumbers> for LampPixel {
    fn from((pixel, count, lamp, share, mean, square): LampPixelNumbers) -> LampPixel {
        LampPixel { pixel, count, lamp, share, mean, square }
    }
}

/// The code of the primitive at this index among its kind.
pub fn primitive_code(kind: u32, index: u32) -> u32 {
    PRIMITIVE_BIT | kind << PRIMITIVE_KIND_SHIFT | index
}

/// Luminance of a linear Rec. 709 colour (ITU-R BT.709-6, item 3.2).
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

pub fn f32s(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// A matrix, by its rows, times a vector.
pub fn product(rows: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Clamped to 0..1; 0 of a NaN.
pub fn unit(value: f64) -> f64 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The sRGB transfer function (IEC 61966-2-1:1999), linear 0..1 to encoded 0..1.
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// How the samples of a pixel are chosen: a file of shaders/sampler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Sampler {
    /// Owen-scrambled Sobol points, in two halves: even and odd runs.
    Sobol,
    /// Each by itself.
    #[default]
    Independent,
}

impl Sampler {
    /// Whether a pixel's samples are independent: their deviations give the variance of their mean, which falls as 1/N. Otherwise the two
    /// halves of the runs give it, and it may fall faster.
    pub fn is_independent(self) -> bool {
        self == Sampler::Independent
    }
}

/// The name, offset and bytes of each field of a struct.
pub type Fields = &'static [(&'static str, usize, usize)];

/// Declares a struct as kernels have it.
macro_rules! device_struct {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
        pub struct $name { $($(#[$doc])* pub $field: $ty,)* }

        impl $name {
            pub const FIELDS: Fields = &[$((stringify!($field), std::mem::offset_of!($name, $field), size_of::<$ty>()),)*];
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/data.rs"));

/// The elements of all shapes.
#[derive(Clone, Debug, Default)]
pub struct Tables {
    pub spheres: Vec<Sphere>,
    pub quads: Vec<Quad>,
    pub cuboids: Vec<Cuboid>,
    pub instances: Vec<Instance>,
    pub large_spheres: Vec<LargeSphere>,
    pub disks: Vec<Quad>,
}
