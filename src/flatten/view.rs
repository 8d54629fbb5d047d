//! The camera, and the axes of render space.

use glam::{DMat3, DVec3};
use serde::Serialize;

use super::projection::Film;
use crate::data::{self, f32s};
use crate::scene::{Camera, ImageSize};
use crate::shape::RenderSpace;
use crate::shape::similarity::Similarity;

/// The width of a pixel, relative to its distance, below which render space gets the camera's axes. In the world's
/// axes, the components of a direction that are near 1 are rounded by 2^-25 or more: for pixels below 2^-17, this moves
/// a ray by more than 1/256 of a pixel. In the camera's axes, the components across the view are small, and keep all of
/// their digits however narrow the view is.
const NARROW_PIXEL: f64 = 1.0 / (1u64 << 17) as f64;

/// The camera, in the space of the flattened scene.
pub struct View<'a> {
    camera: &'a Camera,
    pub size: (u32, u32),
    /// The camera's axes: right, up and backwards.
    pub axes: DMat3,
    pub film: Film,
    /// The rotation from the world to render space.
    pub to_space: Similarity,
    /// Whether that space has the camera's axes.
    pub has_camera_axes: bool,
    pub eye: DVec3,
}

/// A camera in render space.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Placement {
    pub right: [f64; 3],
    pub up: [f64; 3],
    pub backward: [f64; 3],
    /// The unit vector that its user calls up.
    pub vertical: [f64; 3],
    /// The distance of the point at which it looks.
    pub distance: f64,
    /// The length of the settings' vectors for a pixel.
    pub pixel: f64,
    pub lens_radius: f64,
    pub focus: f64,
    pub mirror: bool,
    /// Whether its rays are parallel.
    pub parallel: bool,
    /// Whether an image of half the height has pixels of twice the size.
    pub scales: bool,
}

/// The axes of a camera: right, up and backwards.
pub fn axes_of(camera: &Camera) -> DMat3 {
    let unit = |v: DVec3| (v / v.abs().max_element()).normalize();
    let backward = unit(camera.look_from - camera.look_at);
    let right = unit(unit(camera.up).cross(backward));
    DMat3::from_cols(right, backward.cross(right), backward)
}

impl View<'_> {
    /// The view of an image of `size` pixels. `image` is the size that the scene counts in.
    pub fn new(camera: &Camera, size: (u32, u32), image: ImageSize) -> View<'_> {
        let axes = axes_of(camera);
        let film = Film::new(camera, size, image);
        let has_camera_axes = film.least_angle().is_some_and(|pixel| pixel < NARROW_PIXEL);
        let to_space = match has_camera_axes {
            true => Similarity { rotation: axes.transpose(), ..Similarity::IDENTITY },
            false => Similarity::IDENTITY,
        };
        let axes = to_space.rotation * axes;
        View { camera, size, axes, film, eye: to_space.point(camera.look_from), to_space, has_camera_axes }
    }

    pub fn lens_radius(&self) -> f64 {
        0.5 * self.camera.aperture
    }

    /// The numbers that the settings follow from, for programs that place the camera elsewhere.
    pub fn placement(&self, space: &RenderSpace) -> Placement {
        let View { camera, film, to_space, .. } = self;
        let axes = if self.has_camera_axes { DMat3::IDENTITY } else { self.axes };
        let distance = (camera.look_at - camera.look_from).length() * space.scale;
        Placement {
            right: axes.x_axis.into(),
            up: axes.y_axis.into(),
            backward: axes.z_axis.into(),
            vertical: (to_space.rotation * camera.up).normalize_or(axes.y_axis).into(),
            distance,
            pixel: film.pixel(space.scale),
            lens_radius: self.lens_radius() * space.scale,
            focus: camera.focus_distance.map_or(distance, |focus| focus * space.scale),
            mirror: camera.mirror,
            parallel: matches!(film, Film::Parallel { .. }),
            scales: matches!(film, Film::Plane { .. } | Film::Parallel { .. }),
        }
    }

    /// The settings that kernels read.
    pub fn settings(&self, space: &RenderSpace) -> data::Settings {
        let View { camera, film, to_space, .. } = self;
        // If the space has the camera's axes, these are exactly the unit vectors.
        let axes = if self.has_camera_axes { DMat3::IDENTITY } else { self.axes };
        let focus = camera.focus_distance.unwrap_or((camera.look_at - camera.look_from).length());
        let lens_radius = self.lens_radius() * space.scale;
        let pixel = film.pixel(space.scale);
        let mut settings = data::Settings {
            forward: f32s(-axes.z_axis),
            image_width: self.size.0,
            pixel_x: f32s(if camera.mirror { -pixel } else { pixel } * axes.x_axis),
            image_height: self.size.1,
            pixel_y: f32s(-pixel * axes.y_axis),
            lens_x: f32s(lens_radius * axes.x_axis),
            lens_y: f32s(lens_radius * axes.y_axis),
            inverse_focus: (1.0 / (focus * space.scale)) as f32,
            world_x: f32s(to_space.rotation.x_axis),
            world_y: f32s(to_space.rotation.y_axis),
            world_z: f32s(to_space.rotation.z_axis),
            ..data::Settings::default()
        };
        film.write(&mut settings);
        settings
    }
}
