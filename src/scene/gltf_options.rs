//! What the command line says of a scene that a glTF file describes.

use std::path::Path;

use super::animation_frame::AnimationFrame;
use super::types::Thin;
use crate::error::{Error, Result};

/// The glTF options of the command line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfOptions {
    /// The name of a camera; the first one if it is not given.
    pub camera: Option<String>,
    /// The image of the sky.
    pub sky: Option<String>,
    /// The elevation and the azimuth of a sun.
    pub sun: Option<(f64, f64)>,
    /// Whether its lights are in Blender's watts; if it is not given, the file's generator decides.
    pub watts: Option<bool>,
    pub thin: Thin,
    /// The frame of its animations; its rest pose if it is not given.
    pub frame: Option<AnimationFrame>,
}

impl GltfOptions {
    /// Refuses what a scene of our own form says itself.
    pub fn refuse(&self, path: &Path) -> Result<()> {
        let given = [
            ("--camera", self.camera.is_some(), "has its own camera"),
            ("--sky", self.sky.is_some(), "has its own background"),
            ("--sun", self.sun.is_some(), "has its own lights"),
            ("--watts", self.watts.is_some(), "has `watts` in its Gltf(..)"),
            ("--thin", self.thin != Thin::Auto, "has `thin` in its Gltf(..)"),
            ("--frame", self.frame.is_some(), "has `frame` in its Gltf(..)"),
        ];
        match given.into_iter().find(|(_, is_given, _)| *is_given) {
            Some((option, _, instead)) => Err(Error::Usage(format!(
                "{option} is for scenes that are .glb or .gltf: {} {instead}",
                path.display()
            ))),
            None => Ok(()),
        }
    }
}
