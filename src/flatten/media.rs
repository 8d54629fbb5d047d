//! Participating media as the kernels read them, in render space.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::builder::Builder;
use super::finder::WorldMedium;
use crate::data::{self, NO_FIELD, f32s};
use crate::error::Result;
use crate::scene::{Emission, Heat, Varying};
use crate::shape::{Element, ObjectTransform, RenderSpace};
use crate::texture::Use;
use crate::volume::grid::{Bricks, Grid};
use crate::volume::heat;

/// Numbers of the files that say how a density varies, counted from 1 ([`FIELDS`](super::FIELDS)).
const HEIGHT: u32 = 1;
const GRID: u32 = 2;

impl Builder<'_> {
    /// `order` is the place of its boundary behind the primitives. Returns the medium's own point.
    pub fn add_medium(&mut self, medium: &WorldMedium<'_>, order: u32) -> DVec3 {
        let WorldMedium { boundary, to_world, own, albedo, anisotropy, .. } = medium;
        // The boundary is not a surface: it has no material, and is not a primitive.
        let (index, _) = self.add_shape(boundary, to_world, Element { order, ..Element::default() });
        self.choose_own_point(boundary, index, to_world, &medium.motion);
        let world = RenderSpace { eye: DVec3::ZERO, scale: 1.0 };
        let center = match boundary.large_sphere() {
            Some(large_sphere) => large_sphere.nearest(to_world, self.space.eye),
            None => boundary.bounding_shape(&ObjectTransform { to_world, space: world }).position(),
        };
        let to_own = self.to_own(medium, center);
        let texture = self.add_texture(albedo, 1.0);
        let place = (to_own.translation, to_own.matrix3);
        let frame = albedo.frame(Use::Albedo, place, (DVec3::ZERO, &own.to_world.rotation));
        let number = if frame.is_some() { self.flat.frames.len() as u32 } else { 0 };
        self.flat.frames.extend(frame);
        self.flat.media.push(data::Medium {
            center: f32s(self.space.point(center)),
            // Kernels divide by the density, so it is at least the smallest normal number.
            density: ((medium.density / self.space.scale) as f32).max(f32::MIN_POSITIVE),
            colour: f32s(albedo.plain().unwrap_or(DVec3::ONE)),
            texture,
            boundary: boundary.code(index),
            frame: number,
            anisotropy: *anisotropy as f32,
            one_minus_anisotropy: (1.0 - anisotropy.abs()) as f32,
        });
        center
    }

    /// Adds how the densities of all media vary, then the temperatures of those that have one.
    ///
    /// # Errors
    /// `Error::Scene` if a grid is too large.
    pub fn add_fields(&mut self, media: &[WorldMedium<'_>], centers: &[DVec3], radiance_scale: f64) -> Result<()> {
        if media.iter().all(|medium| medium.varying.is_none() && medium.emission.is_none()) {
            return Ok(());
        }
        let mut temperatures = Vec::new();
        for (medium, center) in media.iter().zip(centers) {
            let to_own = self.to_own(medium, *center);
            let mut field = self.field_of_density(medium, &to_own)?;
            if let Some(emission) = medium.emission {
                let radiance = match emission {
                    Emission::Colour(colour) => *colour,
                    Emission::Heat(Heat::Blackbody { at, luminance, .. }) => {
                        DVec3::splat(luminance * (-heat::log_luminance(*at)).exp())
                    }
                };
                field.emission = f32s(radiance * radiance_scale);
            }
            if let (Some(grid), Some(Emission::Heat(Heat::Blackbody { scale, .. }))) =
                (medium.temperature, medium.emission)
            {
                field.temperature = (media.len() + temperatures.len()) as u32;
                field.heat = self.table_of_heat();
                temperatures.push(self.field_of_grid(medium, grid, &to_own, *scale)?);
            }
            self.flat.fields.push(field);
        }
        self.flat.fields.extend(temperatures);
        Ok(())
    }

    /// The map from the offset from the medium's own point, in render space, to the medium's own space.
    fn to_own(&self, medium: &WorldMedium<'_>, center: DVec3) -> DAffine3 {
        let own = &medium.own.to_world;
        let turn = own.rotation.transpose();
        let matrix = turn * (1.0 / (own.scale * self.space.scale));
        DAffine3 { matrix3: matrix, translation: turn * (center - own.translation) / own.scale }
    }

    fn field_of_density(&mut self, medium: &WorldMedium<'_>, to_own: &DAffine3) -> Result<data::ScalarField> {
        let constant = data::ScalarField { temperature: NO_FIELD, ..Default::default() };
        Ok(match (medium.varying, medium.grid) {
            (Some(Varying::Height { scale_height, at, .. }), _) => {
                // The logarithm of the density: log(density) - (y - at) / scale_height.
                let up = to_own.matrix3.row(1) / -scale_height;
                let log_density = (medium.density / self.space.scale).ln();
                let here = log_density - (to_own.translation.y - at) / scale_height;
                data::ScalarField { kind: HEIGHT, x: row(up, here), ..constant }
            }
            (Some(Varying::Grid { scale, .. }), Some(grid)) => {
                let field = self.field_of_grid(medium, grid, to_own, scale / self.space.scale)?;
                let outside = if medium.is_bare { 0.0 } else { field.outside };
                data::ScalarField { outside, ..field }
            }
            _ => constant,
        })
    }

    /// The field of a grid whose values count `scale` times.
    fn field_of_grid(
        &mut self,
        medium: &WorldMedium<'_>,
        grid: &Arc<Grid>,
        to_own: &DAffine3,
        scale: f64,
    ) -> Result<data::ScalarField> {
        let error = |reason: String| self.scene.error_of(medium.object, &reason);
        let bricks = grid.bricks().map_err(error)?.unwrap_or_default();
        let first = self.first_word_of(grid, &bricks).map_err(error)?;
        let to_index = grid.to_own.inverse() * *to_own;
        let corner = bricks.lower.as_dvec3();
        let (low, high) = grid.around().unwrap_or_default();
        let matrix = to_index.matrix3;
        let offset = to_index.translation - corner;
        Ok(data::ScalarField {
            x: row(matrix.row(0), offset.x),
            y: row(matrix.row(1), offset.y),
            z: row(matrix.row(2), offset.z),
            kind: GRID,
            low: f32s(low - corner),
            high: f32s(high - corner),
            first,
            outside: grid.background.max(0.0),
            tiles: bricks.tiles.as_uvec3().to_array(),
            temperature: NO_FIELD,
            scale: scale as f32,
            ..Default::default()
        })
    }

    /// The index of the first word of a grid. Media share the words.
    fn first_word_of(&mut self, grid: &Arc<Grid>, bricks: &Bricks) -> std::result::Result<u32, String> {
        if let Some((_, first)) = self.grids.iter().find(|(known, _)| Arc::ptr_eq(known, grid)) {
            return Ok(*first);
        }
        let words = &mut self.flat.bricks;
        // Kernels number words by 32 bits.
        let first = u32::try_from(words.len() + bricks.words.len()).map(|_| words.len() as u32);
        let first = first.map_err(|_| "expected grids of less than 16 GiB in all".to_owned())?;
        words.extend_from_slice(&bricks.words);
        self.grids.push((Arc::clone(grid), first));
        Ok(first)
    }

    /// The index of the first word of the table of black bodies.
    fn table_of_heat(&mut self) -> u32 {
        *self.heat.get_or_insert_with(|| {
            let first = self.flat.bricks.len() as u32;
            self.flat.bricks.extend(heat::TABLE.iter().flatten().map(|x| x.to_bits()));
            first
        })
    }
}

/// A row of an affine map.
fn row(v: DVec3, offset: f64) -> [f32; 4] {
    let [x, y, z] = f32s(v);
    [x, y, z, offset as f32]
}
