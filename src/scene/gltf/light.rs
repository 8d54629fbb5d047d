//! The lights of KHR_lights_punctual.

use glam::DVec3;
use gltf::json::Extras;
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::generator::LightUnits;
use super::material::{colour, radiance};
use super::nodes::SceneNode;
use super::{File, GltfError, Result, decimal};
use crate::scene::types::{Falloff, Object};

/// A light of the file.
pub struct Light {
    pub object: Object,
    /// Whether it has a range, which is no property of light.
    pub has_range: bool,
}

/// The group of the light of a material or of a light, by its extras: `{"light_group": "key"}`.
pub fn light_group(extras: &Extras) -> Option<String> {
    #[derive(Deserialize)]
    struct Grouped {
        light_group: String,
    }
    let grouped = serde_json::from_str::<Grouped>(extras.as_ref()?.get());
    grouped.ok().map(|grouped| grouped.light_group)
}

impl File {
    /// The light of a node, in the radiance's units.
    pub fn light(&self, scene_node: &SceneNode, units: LightUnits) -> Result<Option<Light>> {
        let of_node = scene_node.node.extensions.as_ref().and_then(|found| found.khr_lights_punctual.as_ref());
        let Some(index) = of_node.map(|found| found.light.value()) else { return Ok(None) };
        let node = format!("nodes[{}]", scene_node.index);
        let all = self.root().extensions.as_ref().and_then(|found| found.khr_lights_punctual.as_ref());
        let Some(light) = all.and_then(|all| all.lights.get(index)) else {
            let at = format!("{node}.extensions.KHR_lights_punctual.light");
            return Err(GltfError::new(at, format!("there is no light {index}")));
        };
        let wrong = |field: &str, reason: String| {
            GltfError::new(format!("extensions.KHR_lights_punctual.lights[{index}].{field}"), reason)
        };
        let strength = decimal(light.intensity);
        if strength < 0.0 || light.color.iter().any(|channel| *channel < 0.0) {
            return Err(wrong("intensity", "expected no negative light".to_owned()));
        }
        let Checked::Valid(kind) = light.type_ else {
            return Err(wrong("type", "expected point, spot or directional".to_owned()));
        };
        let strength = radiance(strength / units.divisor(kind) * colour(light.color));
        let at = scene_node.to_scene.translation;
        let direction = -scene_node.to_scene.matrix3.z_axis.normalize_or_zero();
        if direction == DVec3::ZERO && kind != Type::Point {
            return Err(GltfError::new(node, "its light has no direction"));
        }
        let light_group = light_group(&light.extras);
        let object = match kind {
            Type::Point => Object::PointLight { at, intensity: strength, light_group },
            Type::Directional => Object::DirectionalLight { direction, irradiance: strength, light_group },
            Type::Spot => {
                let spot =
                    light.spot.as_ref().ok_or_else(|| wrong("spot", "expected the angles of the spot".to_owned()))?;
                let outer = decimal(spot.outer_cone_angle);
                if !(outer > 0.0 && outer <= std::f64::consts::PI) {
                    let reason = format!("expected an angle above 0 and at most pi / 2, found {outer}");
                    return Err(wrong("spot.outerConeAngle", reason));
                }
                let inner = decimal(spot.inner_cone_angle).clamp(0.0, outer);
                Object::SpotLight {
                    at,
                    towards: at + direction * at.length().max(1.0),
                    intensity: strength,
                    inner: inner.to_degrees(),
                    outer: outer.to_degrees(),
                    falloff: Falloff::Gltf,
                    light_group,
                }
            }
        };
        Ok(Some(Light { object, has_range: light.range.is_some() }))
    }
}

/// A sun at this elevation above the horizon, and this azimuth from north (-z) to east (+x), in degrees. A white surface that faces it is
/// as bright as a white sky.
pub fn sun((elevation, azimuth): (f64, f64)) -> Object {
    let (sin, cos) = elevation.to_radians().sin_cos();
    let (east, north) = azimuth.to_radians().sin_cos();
    let direction = -DVec3::new(cos * east, sin, -cos * north);
    Object::DirectionalLight { direction, irradiance: DVec3::splat(std::f64::consts::PI), light_group: None }
}
