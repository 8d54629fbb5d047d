//! What the command line says of a scene that a glTF file describes.

use std::path::Path;

use super::animation_frame::AnimationFrame;
use super::types::Thin;
use crate::error::{Error, Result};

/// The sky of a file that has none.
#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    Default,
    None,
    /// The path of an image.
    Image(String),
}

impl Sky {
    /// The sky of a word; none of a path. An image whose name is a word is ./none.
    pub fn of_word(text: &Path) -> Option<Sky> {
        match text.to_str()? {
            "default" => Some(Sky::Default),
            "none" => Some(Sky::None),
            _ => None,
        }
    }
}

/// The glTF options of the command line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfOptions {
    /// The name of a camera; the first one if it is not given.
    pub camera: Option<String>,
    /// The sky; if it is not given, the default one where the file's own lights are not enough.
    pub sky: Option<Sky>,
    /// The elevation and the azimuth of a sun.
    pub sun: Option<(f64, f64)>,
    /// Whether its lights are in Blender's watts; if it is not given, the file's generator decides.
    pub watts: Option<bool>,
    pub thin: Thin,
    /// The frame of its animations; its rest pose if it is not given.
    pub frame: Option<AnimationFrame>,
    /// Of a scene of Mitsuba: the values of names.
    pub defines: Vec<(String, String)>,
    /// Of a scene of Mitsuba: whether what is not as the file says is an error.
    pub lossless: bool,
}

impl GltfOptions {
    /// Refuses what only scenes of Mitsuba have.
    pub fn refuse_mitsuba(&self, path: &Path) -> Result<()> {
        let of_both = "scenes of Mitsuba and pbrt, which are .xml and .pbrt";
        let given = [
            ("-D", "scenes of Mitsuba, which are .xml", !self.defines.is_empty()),
            ("--lossless", of_both, self.lossless),
        ];
        match given.into_iter().find(|(.., is_given)| *is_given) {
            Some((option, what, _)) => Err(Error::Usage(format!("{option} is for {what}: {}", path.display()))),
            None => Ok(()),
        }
    }

    /// Refuses what a scene of our own form says itself, or what a mesh file does not have.
    pub fn refuse(&self, path: &Path, is_mesh: bool) -> Result<()> {
        self.refuse_mitsuba(path)?;
        let given = [
            ("--camera", self.camera.is_some(), "has its own camera", "has no camera"),
            ("--sky", self.sky.is_some() && !is_mesh, "has its own background", ""),
            ("--sun", self.sun.is_some() && !is_mesh, "has its own lights", ""),
            ("--watts", self.watts.is_some(), "has `watts` in its Gltf(..)", "has no lights"),
            ("--thin", self.thin != Thin::Auto, "has `thin` in its Gltf(..)", "has no panes of glass"),
            ("--frame", self.frame.is_some() && is_mesh, "", "has no animations"),
        ];
        let Some((option, _, of_scene, of_mesh)) = given.into_iter().find(|(_, is_given, ..)| *is_given) else {
            return Ok(());
        };
        let meshes = if ["--sky", "--sun"].contains(&option) { ", or meshes" } else { "" };
        let instead = if is_mesh { of_mesh } else { of_scene };
        Err(Error::Usage(format!(
            "{option} is for scenes that are .glb or .gltf{meshes}: {} {instead}",
            path.display()
        )))
    }
}
