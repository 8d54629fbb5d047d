//! The types of what a scene consists of.

pub use super::declared::{
    Background, Camera, CameraKey, ImageSize, Object, RenderDefaults, SkyLayout, Thin, Transform, keys_around,
    keys_up_to,
};
pub use super::projection::{Distortion, FisheyeModel, Projection};
pub use crate::bitmap::{Bitmap, Bitmaps};
pub use crate::delta_light::Falloff;
pub use crate::material::{
    Conductor, Dielectric, DiffuseLight, Distribution, Lambertian, Material, Metal, Mix, Pbr, Plastic, RoughDielectric,
    ThinDielectric,
};
pub use crate::texture::{Colour, Texture, Use, Wrap};
pub use crate::volume::{Density, Emission, Heat, Varying};
