//! Participating media as the kernels read them, in render space.

use glam::DVec3;

use super::builder::Builder;
use super::finder::WorldMedium;
use crate::data::{self, f32s};
use crate::shape::{Element, ObjectTransform, RenderSpace};
use crate::texture::Use;

impl Builder<'_> {
    /// `order` is the place of its boundary behind the primitives.
    pub fn add_medium(&mut self, medium: &WorldMedium<'_>, order: u32) {
        let WorldMedium { boundary, to_world, own, density, albedo, anisotropy, .. } = medium;
        let own = &own.to_world;
        // The boundary is not a surface: it has no material, and is not a primitive.
        let (index, _) = self.add_shape(boundary, to_world, Element { order, ..Element::default() });
        self.choose_own_point(boundary, index, to_world, &medium.motion);
        let world = RenderSpace { eye: DVec3::ZERO, scale: 1.0 };
        let center = match boundary.large_sphere() {
            Some(large_sphere) => large_sphere.nearest(to_world, self.space.eye),
            None => boundary.bounding_shape(&ObjectTransform { to_world, space: world }).position(),
        };
        // From render space, relative to this point, to the medium's own space.
        let to_own = own.rotation.transpose() * (1.0 / (own.scale * self.space.scale));
        let base = own.rotation.transpose() * (center - own.translation) / own.scale;
        let texture = self.add_texture(albedo, 1.0);
        let frame = albedo.frame(Use::Albedo, (base, to_own), (DVec3::ZERO, &own.rotation));
        let number = if frame.is_some() { self.flat.frames.len() as u32 } else { 0 };
        self.flat.frames.extend(frame);
        self.flat.media.push(data::Medium {
            center: f32s(self.space.point(center)),
            // Kernels divide by the density, so it is at least the smallest normal number.
            density: ((density / self.space.scale) as f32).max(f32::MIN_POSITIVE),
            colour: f32s(albedo.plain().unwrap_or(DVec3::ONE)),
            texture,
            boundary: boundary.code(index),
            frame: number,
            anisotropy: *anisotropy as f32,
            one_minus_anisotropy: (1.0 - anisotropy.abs()) as f32,
        });
    }
}
