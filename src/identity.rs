//! The identity of an image: all that it depends on, except its samples and the driver. Only renders of equal identity can be joined.

mod digest;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::aov::Aovs;
use crate::job::{Frame, Job};
use crate::options::{Integrator, RenderOptions};
use crate::scene::Scene;

/// What an image is a function of.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Of this program.
    pub version: String,
    /// A hash of all shaders.
    pub kernels: String,
    /// A hash of what the scene file says.
    pub scene: String,
    /// Paths and hashes of images and meshes. The paths are for messages alone.
    pub assets: Vec<(String, String)>,
    /// The settings that change the image, by their options' names.
    pub settings: BTreeMap<String, String>,
}

impl Identity {
    pub fn new(scene: &Scene, frame: &Frame, job: &Job, options: &RenderOptions) -> Identity {
        let of_job = [
            ("size", format!("{}x{}", frame.full.0, frame.full.1)),
            ("max-depth", job.max_depth.to_string()),
            ("seed", job.seed.to_string()),
        ];
        // Also where nothing moves between two frames, an image is of one of them.
        let of_animation =
            scene.frame.map(|frame| [("frame", frame.number.to_string()), ("fps", frame.fps.to_string())]);
        let of_crop = frame.crop().map(|crop| ("crop", crop.to_string()));
        Identity {
            version: env!("CARGO_PKG_VERSION").to_string(),
            kernels: digest::of_shaders(),
            scene: digest::of_scene(scene),
            assets: digest::of_assets(scene),
            settings: of_job
                .into_iter()
                .chain(of_crop)
                .chain(of_animation.into_iter().flatten())
                .chain(options.of_image())
                .map(|(name, value)| (name.to_string(), value))
                .collect(),
        }
    }

    /// The part of the image that a film of this size is of; nothing where the settings do not say so.
    pub fn frame(&self, size: (u32, u32)) -> Option<Frame> {
        let Some(crop) = self.settings.get("crop") else { return Some(Frame::full(size)) };
        let (width, height) = self.settings.get("size")?.split_once('x')?;
        let frame = Frame { part: crop.parse().ok()?, full: (width.parse().ok()?, height.parse().ok()?) };
        (frame.part.is_in(frame.full) && frame.part.size() == size).then_some(frame)
    }

    /// The channels of `--aov`.
    pub fn aovs(&self) -> Aovs {
        RenderOptions::of_settings(&self.settings).aov
    }

    /// Whether its paths sample lights.
    pub fn samples_lights(&self) -> bool {
        RenderOptions::of_settings(&self.settings).integrator == Integrator::Mis
    }

    /// Whether both are of one scene, with the same images and meshes.
    pub fn is_of_scene(&self, other: &Identity) -> bool {
        self.scene == other.scene && self.hashes().eq(other.hashes())
    }

    /// Whether both are of one scene by the same settings, but for the seed.
    pub fn differs_by_seed(&self, other: &Identity) -> bool {
        let settings = |identity: &Identity| {
            let mut settings = identity.settings.clone();
            settings.remove("seed");
            settings
        };
        self.is_of_scene(other) && settings(self) == settings(other)
    }

    /// One hash of the scene with its images and meshes: equal where [`Identity::is_of_scene`].
    pub fn hash_of_scene(&self) -> String {
        digest::of_texts(std::iter::once(&self.scene).chain(self.hashes()))
    }

    /// The hashes of images and meshes.
    fn hashes(&self) -> impl Iterator<Item = &String> {
        self.assets.iter().map(|(_, hash)| hash)
    }

    /// What differs in another one, in words; nothing where both are of one image. `mine` and `theirs` name the two.
    pub fn difference(&self, mine: &str, other: &Identity, theirs: &str) -> Option<String> {
        let mut words = Vec::new();
        let none = || "none".to_string();
        let names = self.settings.keys().chain(other.settings.keys().filter(|name| !self.settings.contains_key(*name)));
        for name in names {
            let [a, b] = [self, other].map(|identity| identity.settings.get(name).cloned().unwrap_or_else(none));
            if a != b {
                words.push(format!("--{name} is {a} in {mine} and {b} in {theirs}"));
            }
        }
        match self.assets.len() == other.assets.len() {
            true => words.extend(self.assets.iter().zip(&other.assets).filter(|(a, b)| a.1 != b.1).map(
                |((mine, _), (theirs, _))| match mine == theirs {
                    true => format!("the file {mine} has changed"),
                    false => format!("the files {mine} and {theirs} differ"),
                },
            )),
            false => words.push("the scene names other images and meshes".to_string()),
        }
        if self.scene != other.scene {
            words.push("the scene differs".to_string());
        }
        if self.version != other.version {
            words.push(format!("gpu-rt is {} in {mine} and {} in {theirs}", self.version, other.version));
        } else if self.kernels != other.kernels {
            words.push("the kernels differ: the builds of gpu-rt do".to_string());
        }
        words.dedup();
        (!words.is_empty()).then(|| words.join("; "))
    }
}
