//! Where textured things stand in their textures.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use crate::data::{self, f32s};
use crate::scene::Texture;

/// The frame of a texture: the point p(local) = base + columns · local in the object's own space, in the texture's units,
/// its base reduced by the texture's period in f64. For an image the object's rotation alone is undone, for the normals of spheres. A
/// plain colour needs none.
pub fn frame(texture: &Texture, (base, columns): (DVec3, DMat3), rotation: &DMat3) -> Option<data::Frame> {
    let (base, columns, phase) = match *texture {
        Texture::Rgb(..) => return None,
        Texture::Checker { scale, .. } => (reduce(base / scale, 2.0), columns * (1.0 / scale), 0.0),
        Texture::Noise { scale } => (reduce(base * scale, 256.0), columns * scale, 0.0),
        Texture::Marble { scale } => (reduce(base, 256.0), columns, reduce(DVec3::splat(base.z * scale), TAU).z),
        Texture::Image { .. } => (DVec3::ZERO, rotation.transpose(), 0.0),
    };
    Some(data::Frame {
        x: f32s(columns.x_axis),
        phase: phase as f32,
        y: f32s(columns.y_axis),
        z: f32s(columns.z_axis),
        origin: f32s(base),
        ..data::Frame::default()
    })
}

/// Each coordinate less whole periods, within half a period of zero.
fn reduce(v: DVec3, period: f64) -> DVec3 {
    v - period * (v / period).round()
}
