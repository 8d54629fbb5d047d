//! The cameras of a glTF file, and one for a file that has none.

use glam::{DAffine3, DVec3};
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::nodes::SceneNode;
use super::{File, GltfError, Result, decimal};
use crate::scene::types::{Camera, ImageSize, Projection};
use crate::shape::Aabb;

/// A camera of the file.
pub struct View {
    /// The names of its node and of the camera itself.
    pub names: Vec<String>,
    pub camera: Camera,
    pub image: ImageSize,
}

/// The longer side of an image, of which a glTF file says no more than the shape.
const LONGER_SIDE: u32 = 1280;
/// The shape where it says nothing.
const ASPECT: f64 = 16.0 / 9.0;

/// An image of this shape.
fn image(aspect: f64) -> ImageSize {
    let shorter = |by: f64| (f64::from(LONGER_SIDE) * by).round().max(1.0) as u32;
    match aspect >= 1.0 {
        true => ImageSize { width: LONGER_SIDE, height: shorter(1.0 / aspect) },
        false => ImageSize { width: shorter(aspect), height: LONGER_SIDE },
    }
}

impl File {
    /// The camera of a node, if it has one.
    pub fn view(&self, scene_node: &SceneNode) -> Result<Option<View>> {
        let Some(index) = scene_node.node.camera.map(|camera| camera.value()) else { return Ok(None) };
        let at = format!("cameras[{index}]");
        let camera = self.root().cameras.get(index);
        let camera = camera.ok_or_else(|| {
            GltfError::new(format!("nodes[{}].camera", scene_node.index), format!("there is no camera {index}"))
        })?;
        let positive = |name: &str, x: f64| match x > 0.0 && x.is_finite() {
            true => Ok(x),
            false => Err(GltfError::new(format!("{at}.{name}"), format!("expected a positive number, found {x}"))),
        };
        let (vertical_fov, projection, aspect) = match (camera.type_, &camera.perspective, &camera.orthographic) {
            (Checked::Valid(Type::Perspective), Some(perspective), _) => {
                let yfov = decimal(perspective.yfov);
                if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
                    let reason = format!("expected an angle between 0 and pi, found {yfov}");
                    return Err(GltfError::new(format!("{at}.perspective.yfov"), reason));
                }
                let aspect = positive("perspective.aspectRatio", perspective.aspect_ratio.map_or(ASPECT, decimal))?;
                (Some(yfov.to_degrees()), None, aspect)
            }
            // glTF's numbers are half the extent of the image.
            (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
                let half_width = positive("orthographic.xmag", decimal(orthographic.xmag))?;
                let half_height = positive("orthographic.ymag", decimal(orthographic.ymag))?;
                (None, Some(Projection::Orthographic { height: 2.0 * half_height }), half_width / half_height)
            }
            (Checked::Valid(Type::Perspective), None, _) => {
                return Err(GltfError::new(at, "expected the properties perspective"));
            }
            (Checked::Valid(Type::Orthographic), _, None) => {
                return Err(GltfError::new(at, "expected the properties orthographic"));
            }
            (Checked::Invalid, ..) => {
                return Err(GltfError::new(format!("{at}.type"), "expected perspective or orthographic"));
            }
        };
        let DAffine3 { matrix3, translation } = scene_node.to_scene;
        let (forward, up) = (-matrix3.z_axis.normalize(), matrix3.y_axis.normalize());
        let sine = forward.cross(up).length();
        if sine.is_nan() || sine < 1e-6 {
            return Err(GltfError::new(format!("nodes[{}]", scene_node.index), "its camera has no direction"));
        }
        let names = [scene_node.node.name.clone(), camera.name.clone()].into_iter().flatten().collect();
        let look_at = translation + forward * translation.length().max(1.0);
        let camera = Camera { vertical_fov, projection, ..Camera::pinhole(translation, look_at, up, 45.0) };
        Ok(Some(View { names, camera, image: image(aspect) }))
    }
}

/// A camera that sees all of a box, from the front, the right and above.
pub fn framing(Aabb { min: low, max: high }: Aabb) -> (Camera, ImageSize) {
    const FOV: f64 = 40.0;
    let (middle, radius) = match low.cmple(high).all() {
        true => (0.5 * (low + high), 0.5 * (high - low).length()),
        false => (DVec3::ZERO, 1.0),
    };
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let distance = radius / (0.5 * FOV).to_radians().sin();
    let look_from = middle + distance * DVec3::new(0.5, 0.35, 1.0).normalize();
    (Camera::pinhole(look_from, middle, DVec3::Y, FOV), image(ASPECT))
}
