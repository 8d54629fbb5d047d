//! The scene: the checked contents of a scene file, with the place of every value in the file.
//!
//! `load` reads the file, `explain` translates ron's errors into the terms of the scene format, `validate` refuses invalid
//! numbers, `bitmap` decodes the images, `mesh` reads the meshes. Every error names file:line:column and the field. `recover` reads on
//! behind an error, so that all are listed.

mod assets;
mod bitmap;
mod explain;
mod file;
mod findings;
pub mod forms;
mod gltf;
mod inputs;
mod load;
mod mesh;
mod nearest;
mod recover;
pub mod types;
mod validate;
mod visit;
mod warn;
mod write;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Error, Location, Result};
use crate::source::Source;

pub use crate::source::{Place, Step};
pub use assets::{Assets, Stamp, stamp};
pub use inputs::Input;
pub use mesh::{Mesh, OnProgress, OpenEdges};
pub use types::*;

/// A scene that has been read and validated, with its images decoded and its meshes read.
#[derive(Clone, Debug)]
pub struct Scene {
    pub image: ImageSize,
    pub camera: Camera,
    pub background: Background,
    /// Names and materials, in the file's order. No name occurs twice.
    pub materials: Vec<(String, Material)>,
    pub objects: Vec<Object>,
    pub render: RenderDefaults,
    /// The decoded images, by the paths that the scene file writes.
    pub bitmaps: Bitmaps,
    /// The meshes, by the paths that the scene file writes.
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    /// Warnings about what glTF files have and the scene does not.
    notes: Vec<String>,
    source: Source,
}

/// The glTF options: what the command line says of a scene that a glTF file describes.
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

impl Scene {
    /// Reads and validates a scene file, and loads the images and meshes that it names.
    ///
    /// Every error is an [`Error::Scene`], or several of them. Errors about the file as a whole (it is missing, it is a folder) point at 1:1.
    pub fn load(path: &Path) -> Result<Scene> {
        Scene::load_with(path, &mut |_, _, _| {})
    }

    /// The same, with a report of the progress of large files about every MiB.
    pub fn load_with(path: &Path, progress: &mut OnProgress) -> Result<Scene> {
        Scene::load_again(path, progress, &mut Assets::default())
    }

    /// The same, of a scene that may have been read before: images and meshes are taken from `assets` where their files have not changed.
    pub fn load_again(path: &Path, progress: &mut OnProgress, assets: &mut Assets) -> Result<Scene> {
        Scene::load_as(path, &GltfOptions::default(), progress, assets)
    }

    /// Reads and validates a scene that may have been read before, with the glTF options of the command line.
    pub fn load_as(
        path: &Path,
        options: &GltfOptions,
        progress: &mut OnProgress,
        assets: &mut Assets,
    ) -> Result<Scene> {
        assets.begin(path);
        if gltf::is_gltf(path) {
            return load::of_gltf(path, path, options, progress, assets);
        }
        options.refuse(path)?;
        load::parse(load::read(path)?, path, progress, assets)
    }

    /// The scene of a glTF file, as the scene file `to` would have it.
    pub fn of_gltf(path: &Path, to: &Path, options: &GltfOptions) -> Result<Scene> {
        if !gltf::is_gltf(path) {
            return Err(Error::Usage(format!("{}: expected a file that ends in .glb or .gltf", path.display())));
        }
        load::of_gltf(path, to, options, &mut |_, _, _| {}, &mut Assets::default())
    }

    /// The text of a scene file of this scene.
    pub fn text(&self) -> String {
        write::text(self).unwrap_or_default()
    }

    /// The same for the text that a reader gives, such as standard input. `path` is its name in errors, as for [`Scene::parse`].
    pub fn read(reader: impl Read, path: &Path, progress: &mut OnProgress) -> Result<Scene> {
        load::parse(load::text_of(reader, path)?, path, progress, &mut Assets::default())
    }

    /// The same for a text in memory. `path` is its name in errors; relative paths start at the folder of `path`.
    pub fn parse(text: &str, path: &Path) -> Result<Scene> {
        load::parse(text.to_owned(), path, &mut |_, _, _| {}, &mut Assets::default())
    }

    /// The paths of all files that the scene was read from, the scene file first.
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.input_files().into_iter().map(|input| input.path).collect()
    }

    /// The same, with how the scene names them.
    pub fn input_files(&self) -> Vec<Input> {
        inputs::inputs(self)
    }

    /// The location in the scene file of the value at the end of `steps`.
    ///
    /// For a value that the file does not give, it is the location of the innermost value around it.
    pub fn location(&self, steps: &[Step<'_>]) -> Location {
        self.source.location_of(steps)
    }

    /// An [`Error::Scene`] about the value at the end of `steps`, for the stages after loading.
    pub fn error(&self, steps: &[Step<'_>], message: impl Into<String>) -> Error {
        self.source.error(steps, message)
    }

    /// The location of `objects[index]` in the scene file.
    pub fn object_location(&self, index: usize) -> Location {
        self.location(&[Step::Field("objects"), Step::Index(index)])
    }

    /// The location of an object in the scene file, also of one inside other objects.
    pub fn location_of(&self, object: &Object) -> Location {
        self.place_of(object, |steps| self.location(steps))
    }

    /// An [`Error::Scene`] about an object, also about one inside other objects.
    pub fn error_of(&self, object: &Object, message: &str) -> Error {
        self.place_of(object, |steps| self.error(steps, message))
    }

    /// What `tell` says of the steps to an object.
    fn place_of<T>(&self, object: &Object, tell: impl Fn(&[Step<'_>]) -> T) -> T {
        let top = self.top();
        let objects = top.field("objects");
        let mut found = None;
        for (index, outer) in self.objects.iter().enumerate() {
            let walked = visit::visit(&objects.index(index), outer, &mut |at, inner| {
                if std::ptr::eq(inner, object) {
                    // The visited place is that of the variant; the object is one step above.
                    let mut steps = at.steps();
                    steps.pop();
                    found = Some(tell(&steps));
                }
                Ok(())
            });
            debug_assert!(walked.is_ok(), "nothing in it fails");
            if found.is_some() {
                break;
            }
        }
        found.unwrap_or_else(|| tell(&objects.steps()))
    }

    /// The location of the definition of the material of this name.
    pub fn material_location(&self, name: &str) -> Location {
        self.location(&[Step::Field("materials"), Step::Key(name)])
    }

    /// Calls `visitor` with every object, also those inside others, in the file's order. The place is that of the variant, as in
    /// `objects[3].Group[0].Sphere`.
    pub fn visit_objects(&self, visitor: &mut dyn FnMut(&Place, &Object)) {
        let walked = visit::visit_all(&self.top().field("objects"), &self.objects, &mut |at, object| {
            visitor(at, object);
            Ok(())
        });
        debug_assert!(walked.is_ok(), "nothing in it fails");
    }

    /// Warnings about values that are allowed but likely to disappoint. Each names file:line:column, the number and a
    /// remedy. Warnings that depend on the positions of placed objects come from flattening.
    pub fn warnings(&self) -> Vec<String> {
        warn::warnings(self)
    }

    /// The top of the scene file, where the checks start.
    fn top(&self) -> Place<'_> {
        Place::top(&self.source)
    }
}
