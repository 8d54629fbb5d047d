//! What follows from a file's generator: Blender's exporter multiplies the watts of its lights, and knows no thickness of glass.

use gltf::json::Root;
use gltf::json::extensions::scene::khr_lights_punctual::Type;

use super::File;

/// Lumens of a watt of green light: what Blender multiplies the watts of its lights by.
const LUMENS: f64 = 683.0;
/// The first version of Blender's exporter that does so (io_scene_gltf2/blender/exp/lights.py). Those before it wrote plain watts.
const FIRST_WITH_LUMENS: (u32, u32) = (3, 4);

/// The units of a file's lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightUnits {
    /// As glTF says: candela of points and spots, and lux of suns.
    Photometric,
    /// Blender's watts times 683 lm/W: those of a point over 4π, and those of a sun per square metre.
    WattsTimesLumens,
    /// Blender's watts: all of a point's, and those of a sun per square metre.
    Watts,
}

impl LightUnits {
    /// What the intensity of a light is divided by, so that it fits the radiance of surfaces that emit.
    pub fn divisor(self, kind: Type) -> f64 {
        match (self, kind) {
            (LightUnits::Photometric, _) | (LightUnits::Watts, Type::Directional) => 1.0,
            (LightUnits::WattsTimesLumens, _) => LUMENS,
            (LightUnits::Watts, Type::Point | Type::Spot) => 4.0 * std::f64::consts::PI,
        }
    }
}

/// The version of Blender's exporter that wrote a file. Nothing if another program did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blender {
    /// Major and minor; nothing if the name says none.
    version: Option<(u32, u32)>,
}

impl Blender {
    /// "Khronos glTF Blender I/O v4.2.57", and before 2019 "Khronos Blender glTF 2.0 exporter".
    fn parse(generator: &str) -> Option<Blender> {
        let is_it = ["Khronos", "Blender"].iter().all(|word| generator.contains(word));
        let version = || {
            let mut numbers = generator.rsplit_once(" v")?.1.split('.').map(str::parse);
            Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
        };
        is_it.then(|| Blender { version: version() })
    }

    /// The units of its lights, unless it was asked for others.
    pub fn light_units(self) -> LightUnits {
        match self.version {
            Some(version) if version < FIRST_WITH_LUMENS => LightUnits::Watts,
            _ => LightUnits::WattsTimesLumens,
        }
    }
}

impl File {
    /// The version of Blender's exporter that wrote it.
    pub fn blender(&self) -> Option<Blender> {
        let Root { asset, .. } = self.root();
        Blender::parse(asset.generator.as_deref()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generators_are_known_by_their_names_and_versions() {
        let of = |version| Some(Blender { version });
        for (generator, expected) in [
            ("Khronos glTF Blender I/O v5.0.21", of(Some((5, 0)))),
            ("Khronos glTF Blender I/O v3.10.2", of(Some((3, 10)))),
            ("Khronos glTF Blender I/O v3.3.36", of(Some((3, 3)))),
            ("Khronos glTF Blender I/O", of(None)),
            ("Khronos glTF Blender I/O vX", of(None)),
            ("Khronos Blender glTF 2.0 exporter", of(None)),
            ("glTF-Transform v3.4", None),
            ("babylon.js glTF exporter for Blender", None),
            ("", None),
        ] {
            assert_eq!(Blender::parse(generator), expected, "{generator}");
        }
        let units = |version| Blender { version }.light_units();
        assert_eq!(units(Some((3, 3))), LightUnits::Watts);
        for version in [Some((3, 4)), Some((10, 0)), None] {
            assert_eq!(units(version), LightUnits::WattsTimesLumens, "{version:?}");
        }
    }
}
