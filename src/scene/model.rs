//! A scene, with the location of every value in its file.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

use super::animation_frame::AnimationFrame;
use super::types::*;
use super::visit;
use crate::bitmap::{Channel, Decoding};
use crate::error::{Error, Location};
use crate::shape::mesh::Mesh;
use crate::source::{Source, Step, ValuePath};
use crate::volume::grid::Grid;

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
    /// The grids of media, by the paths that the scene file writes and their names in the files.
    pub grids: BTreeMap<(String, String), Arc<Grid>>,
    /// The frame of the animations of a glTF scene, if one was requested.
    pub frame: Option<AnimationFrame>,
    /// The frames before and after that, if motions are asked for.
    pub neighbours: Option<Box<[Scene; 2]>>,
    /// The assets of a glTF file: the name of the topmost node above each object.
    pub assets: Vec<String>,
    /// Warnings about what glTF files have and the scene does not.
    pub(super) notes: Vec<String>,
    /// The files of materials of an OBJ file.
    pub(super) libraries: Vec<PathBuf>,
    /// The paths of the meshes and images that no file has.
    pub(super) made: HashSet<String>,
    pub(super) source: Source,
}

impl Scene {
    /// The scene in a frame, whose shutter opens and closes so much later.
    pub fn in_frame(self, frame: Option<AnimationFrame>) -> Scene {
        let camera = self.camera.later(frame.map_or(0.0, |frame| frame.seconds()));
        Scene { camera, frame, ..self }
    }

    /// The meshes that no file has, with the paths of the files that the scene names in their place.
    pub fn made_meshes(&self) -> impl Iterator<Item = (&str, &Mesh)> {
        self.made.iter().filter_map(|path| Some((path.as_str(), &**self.meshes.get(path)?)))
    }

    /// A grid by its path and its name.
    pub fn grid_of(&self, key: Option<(&str, &str)>) -> Option<&Arc<Grid>> {
        key.and_then(|(path, name)| self.grids.get(&(path.to_owned(), name.to_owned())))
    }

    /// The images that no file has, likewise.
    pub fn made_images(&self) -> impl Iterator<Item = (&str, &Bitmap)> {
        let of = |path| {
            let decodings = [Decoding::Colour, Decoding::Number(Channel::R)];
            decodings.into_iter().find_map(|decoding| self.bitmaps.get(path, decoding))
        };
        self.made.iter().filter_map(move |path| Some((path.as_str(), of(path)?)))
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

    /// The location of an object in the scene file, also of one inside other objects.
    pub fn location_of(&self, object: &Object) -> Location {
        self.with_steps_to(object, |steps| self.location(steps))
    }

    /// An [`Error::Scene`] about an object, also about one inside other objects.
    pub fn error_of(&self, object: &Object, message: &str) -> Error {
        self.with_steps_to(object, |steps| self.error(steps, message))
    }

    /// Calls `tell` with the steps to an object.
    fn with_steps_to<T>(&self, object: &Object, tell: impl Fn(&[Step<'_>]) -> T) -> T {
        let mut found = None;
        self.visit_objects(&mut |at, inner| {
            if std::ptr::eq(inner, object) {
                // The visited path is that of the variant; the object is one step above.
                let mut steps = at.steps();
                steps.pop();
                found = Some(tell(&steps));
            }
        });
        found.unwrap_or_else(|| tell(&[Step::Field("objects")]))
    }

    /// The location of the definition of the material of this name.
    pub fn material_location(&self, name: &str) -> Location {
        self.location(&[Step::Field("materials"), Step::Key(name)])
    }

    /// Calls `visitor` with every object, also those inside others, in the file's order. The path is that of the variant, as in
    /// `objects[3].Group[0].Sphere`.
    pub fn visit_objects<'a>(&'a self, visitor: &mut dyn FnMut(&ValuePath, &'a Object)) {
        let top = self.top();
        let objects = top.field("objects");
        for (index, object) in self.objects.iter().enumerate() {
            visit::visit(&objects.index(index), object, visitor);
        }
    }

    /// The top of the scene file, where the checks start.
    pub(crate) fn top(&self) -> ValuePath<'_> {
        ValuePath::top(&self.source)
    }
}
