//! How the mouse moves a camera: around its target, across the view, towards the target.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, DVec3};

use crate::flatten::axes_of;
use crate::scene::{Camera, Projection};

/// The least angle between the view and the vertical, in radians.
const LEAST_ANGLE: f64 = 0.01;
/// An axis is level whose cosine to the right is less: files have coordinates in f32.
const LEVEL: f64 = 1e-5;
/// The height of the film by which a lens has an f-number, in scene units: 24 mm, as one of 35 mm film, where these are metres.
const FILM_HEIGHT: f64 = 0.024;

/// Turns the camera around its target, by angles in radians: to the right, and downwards.
pub fn orbit(camera: &mut Camera, right: f64, down: f64) {
    let axes = axes_of(camera);
    let vertical = vertical(camera, axes.x_axis);
    camera.up = vertical;
    let angle = axes.z_axis.angle_between(vertical);
    let within = (angle + down).clamp(LEAST_ANGLE, std::f64::consts::PI - LEAST_ANGLE) - angle;
    let turn = DQuat::from_axis_angle(vertical, right) * DQuat::from_axis_angle(axes.x_axis, within);
    camera.look_from = camera.look_at + turn * (camera.look_from - camera.look_at);
}

/// The vertical of the scene: the axis of the world that is level in the image, if there is one. Files of other programs have a camera's own direction
/// upwards.
fn vertical(camera: &Camera, right: DVec3) -> DVec3 {
    let up = camera.up.normalize_or(DVec3::Y);
    let is_level = |axis: &DVec3, least: f64| right.dot(*axis).abs() < LEVEL && up.dot(*axis) > least;
    // For y less is enough: it is up in scene files and in glTF, also where a camera looks down on them.
    let y = Some(DVec3::Y).filter(|axis| is_level(axis, 0.3));
    let others = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::NEG_Y];
    y.or(others.into_iter().find(|axis| is_level(axis, FRAC_1_SQRT_2))).unwrap_or(up)
}

/// Has the camera turn around what is at this distance along its axis. The image stays as it is.
pub fn turn_around(camera: &mut Camera, distance: f64) {
    let axis = camera.look_at - camera.look_from;
    camera.focus_distance = camera.focus_distance.or(Some(axis.length()));
    camera.look_at = camera.look_from + axis.normalize_or(DVec3::NEG_Z) * distance;
}

/// Moves the camera and its target across the view, in heights of the view at the target.
pub fn pan(camera: &mut Camera, right: f64, up: f64) {
    let (axes, height) = (axes_of(camera), height_at_target(camera));
    let shift = (right * axes.x_axis + up * axes.y_axis) * height;
    camera.look_from += shift;
    camera.look_at += shift;
}

/// Moves the camera to this share of the distance to its target. The plane that is sharp stays at its share of the way. Parallel rays see the same
/// size from everywhere, so that their image becomes smaller.
pub fn dolly(camera: &mut Camera, share: f64) {
    let way = (camera.look_from - camera.look_at) * share;
    let nearest = camera.look_at.abs().max_element() * 1e-9;
    if !(nearest.max(1e-30)..1e30).contains(&way.length()) {
        return;
    }
    camera.look_from = camera.look_at + way;
    camera.focus_distance = camera.focus_distance.map(|focus| focus * share);
    if let Some(Projection::Orthographic { height }) = &mut camera.projection {
        *height *= share;
    }
}

/// The angle between the upper and the lower edge, in degrees, of a flat film.
pub fn field_of_view(camera: &Camera) -> Option<f64> {
    match camera.projection() {
        Projection::Perspective { vertical_fov } => Some(vertical_fov),
        _ => None,
    }
}

/// The distance from the lens to the film, in scene units. Over the lens's diameter it is the f-number.
pub fn focal_length(field_of_view: f64) -> f64 {
    FILM_HEIGHT / 2.0 / (field_of_view.to_radians() / 2.0).tan()
}

fn height_at_target(camera: &Camera) -> f64 {
    let distance = (camera.look_from - camera.look_at).length();
    match camera.projection() {
        Projection::Perspective { vertical_fov } => 2.0 * distance * (vertical_fov.to_radians() / 2.0).tan(),
        Projection::Orthographic { height } => height,
        _ => distance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let mut camera = Camera::pinhole(DVec3::new(3.0, 4.0, 12.0), DVec3::ZERO, DVec3::Y, 40.0);
        camera.focus_distance = Some(6.5);
        camera
    }

    fn near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-12 * (1.0 + b.length())
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_stays_off_the_poles() {
        let mut moved = camera();
        orbit(&mut moved, 1.0, 0.2);
        assert!((moved.look_from.length() - 13.0).abs() < 1e-12 && moved.look_at == DVec3::ZERO);
        orbit(&mut moved, -1.0, -0.2);
        assert!(near(moved.look_from, camera().look_from), "{moved:?}");
        orbit(&mut moved, 0.0, 100.0);
        assert!((axes_of(&moved).z_axis.angle_between(DVec3::NEG_Y) - LEAST_ANGLE).abs() < 1e-9);
        orbit(&mut moved, 0.0, -100.0);
        assert!((axes_of(&moved).z_axis.angle_between(DVec3::Y) - LEAST_ANGLE).abs() < 1e-9);
    }

    /// A quarter of a turn to the right brings what was on +z to +x.
    #[test]
    fn an_orbit_to_the_right_turns_around_the_vertical() {
        let mut moved = Camera::pinhole(DVec3::Z, DVec3::ZERO, DVec3::Y, 40.0);
        orbit(&mut moved, std::f64::consts::FRAC_PI_2, 0.0);
        assert!(near(moved.look_from, DVec3::X), "{moved:?}");
    }

    /// A camera that looks down with a direction upwards of its own turns around y; one of a scene whose z axis is up around that; a rolled one around
    /// its own.
    #[test]
    fn an_orbit_turns_around_the_vertical_of_the_scene() {
        let down = DVec3::new(0.0, 1.0, -1.0).normalize();
        let mut moved = Camera::pinhole(DVec3::new(0.0, 5.0, 5.0), DVec3::ZERO, down, 40.0);
        orbit(&mut moved, 1.0, 0.0);
        assert!(moved.up == DVec3::Y && (moved.look_from.y - 5.0).abs() < 1e-12, "{moved:?}");
        let mut moved = Camera::pinhole(DVec3::new(3.0, 3.0, 1.0), DVec3::ZERO, DVec3::Z, 40.0);
        orbit(&mut moved, 1.0, 0.0);
        assert!(moved.up == DVec3::Z && (moved.look_from.z - 1.0).abs() < 1e-12, "{moved:?}");
        let rolled = DVec3::new(0.3, 1.0, 0.0).normalize();
        let mut moved = Camera::pinhole(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, rolled, 40.0);
        orbit(&mut moved, 1.0, 0.0);
        assert!(near(moved.up, rolled), "{moved:?}");
    }

    #[test]
    fn another_target_shows_the_same_image() {
        let mut moved = Camera { focus_distance: None, ..camera() };
        turn_around(&mut moved, 26.0);
        assert!(near(moved.look_at, -camera().look_from) && moved.focus_distance == Some(13.0), "{moved:?}");
    }

    /// A shift by one height brings the upper edge of the view to the lower one.
    #[test]
    fn a_pan_is_in_heights_of_the_view() {
        let mut moved = Camera::pinhole(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, DVec3::Y, 90.0);
        pan(&mut moved, 0.5, 1.0);
        assert!(near(moved.look_at, DVec3::new(2.0, 4.0, 0.0)) && near(moved.look_from, DVec3::new(2.0, 4.0, 2.0)));
        let orthographic = Some(Projection::Orthographic { height: 3.0 });
        let mut moved = Camera { vertical_fov: None, projection: orthographic, ..moved };
        pan(&mut moved, 0.0, -1.0);
        assert!(near(moved.look_at, DVec3::new(2.0, 1.0, 0.0)));
        dolly(&mut moved, 0.5);
        assert!(moved.projection == Some(Projection::Orthographic { height: 1.5 }));
    }

    #[test]
    fn a_dolly_keeps_the_direction_and_the_share_of_the_focus() {
        let mut moved = camera();
        dolly(&mut moved, 0.5);
        assert!(near(moved.look_from, camera().look_from / 2.0) && moved.focus_distance == Some(3.25));
        // It never reaches the target, nor infinity.
        (0..10_000).for_each(|_| dolly(&mut moved, 0.5));
        assert!(moved.look_from != moved.look_at && moved.look_from.is_finite());
        (0..10_000).for_each(|_| dolly(&mut moved, 2.0));
        assert!(moved.look_from.is_finite());
    }

    #[test]
    fn a_film_of_24_mm_at_40_degrees_has_a_lens_of_33_mm() {
        assert_eq!(field_of_view(&camera()), Some(40.0));
        assert!((focal_length(40.0) - 0.032_969_7).abs() < 1e-7, "{}", focal_length(40.0));
    }
}
