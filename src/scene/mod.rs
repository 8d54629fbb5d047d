//! The scene: what its file says, checked, with the place in the file of every value.
//!
//! `load` reads the file, `explain` puts ron's complaints into the words of the scene format, `validate` refuses numbers
//! that mean nothing, `bitmap` decodes the images, `mesh` reads the meshes. Whatever is wrong, the error names file:line:column and the field.

mod bitmap;
mod explain;
mod load;
mod mesh;
mod nearest;
pub mod types;
mod validate;
mod visit;
mod warn;

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{Error, Location, Result};
use crate::source::Source;

pub use crate::source::{Place, Step};
pub use mesh::{Mesh, OnProgress, OpenEdges};
pub use types::*;

/// A scene that has been read and validated, with its images decoded and its meshes read.
#[derive(Clone, Debug)]
pub struct Scene {
    pub image: ImageSize,
    pub camera: Camera,
    pub background: Background,
    /// By name, in the file's order; no name occurs twice.
    pub materials: Vec<(String, Material)>,
    pub objects: Vec<Object>,
    pub render: RenderDefaults,
    /// The decoded images, by their path as the scene file writes it.
    pub bitmaps: Bitmaps,
    /// The meshes, by their path as the scene file writes it.
    pub meshes: BTreeMap<String, Mesh>,
    source: Source,
}

impl Scene {
    /// Reads, parses and validates a scene file and decodes the images and meshes it names.
    ///
    /// Every error is an [`Error::Scene`]; one that concerns the file as a whole (missing, a folder) points at 1:1.
    pub fn load(path: &Path) -> Result<Scene> {
        Scene::load_with(path, &mut |_, _, _| {})
    }

    /// The same, with word of how far the reading of large files is, every MiB or so.
    pub fn load_with(path: &Path, progress: &mut OnProgress) -> Result<Scene> {
        load::parse(load::read(path)?, path, progress)
    }

    /// The same for a text in memory. `path` is its name in errors, and its folder is where relative paths start.
    pub fn parse(text: &str, path: &Path) -> Result<Scene> {
        load::parse(text.to_owned(), path, &mut |_, _, _| {})
    }

    /// Where the value at the end of `steps` stands in the scene file.
    ///
    /// A value that the file leaves to its default has the position of the innermost value around it that is there.
    pub fn location(&self, steps: &[Step<'_>]) -> Location {
        self.source.location_of(steps)
    }

    /// An [`Error::Scene`] about the value at the end of `steps`, for the stages after loading.
    pub fn error(&self, steps: &[Step<'_>], message: impl Into<String>) -> Error {
        self.source.error(steps, message)
    }

    /// Where `objects[index]` stands in the scene file.
    pub fn object_location(&self, index: usize) -> Location {
        self.location(&[Step::Field("objects"), Step::Index(index)])
    }

    /// Where one of the scene's objects stands in the scene file, however deep in others.
    pub fn location_of(&self, object: &Object) -> Location {
        let top = self.top();
        let objects = top.field("objects");
        let mut found = None;
        for (index, outer) in self.objects.iter().enumerate() {
            let walked = visit::visit(&objects.index(index), outer, &mut |at, inner| {
                if std::ptr::eq(inner, object) {
                    // The object is above its variant.
                    let mut steps = at.steps();
                    steps.pop();
                    found = Some(self.location(&steps));
                }
                Ok(())
            });
            debug_assert!(walked.is_ok(), "nothing in it fails");
            if found.is_some() {
                break;
            }
        }
        found.unwrap_or_else(|| self.location(&objects.steps()))
    }

    /// Where the material of this name is defined in the scene file.
    pub fn material_location(&self, name: &str) -> Location {
        self.location(&[Step::Field("materials"), Step::Key(name)])
    }

    /// Calls `visitor` with every object, those in others too, in the file's order, and its place: that of the variant, as
    /// in `objects[3].Group[0].Sphere`.
    pub fn visit_objects(&self, visitor: &mut dyn FnMut(&Place, &Object)) {
        let walked = visit::visit_all(&self.top().field("objects"), &self.objects, &mut |at, object| {
            visitor(at, object);
            Ok(())
        });
        debug_assert!(walked.is_ok(), "nothing in it fails");
    }

    /// Where what the material emits stands in the scene file, or the material if it emits nothing, and the path there.
    pub fn spot_of_emission(&self, name: &str, material: &Material) -> (Location, String) {
        let top = self.top();
        let materials = top.field("materials");
        let at = materials.key(name);
        let at = at.variant(material.name());
        match material.model().emission() {
            Some(emission) => at.field(emission.slot.field).spot(),
            None => at.spot(),
        }
    }

    /// The same of the background.
    pub fn spot_of_background(&self) -> (Location, String) {
        self.top().field("background").spot()
    }

    /// What is allowed and yet likely to disappoint: each with file:line:column, the number and what to do. What only
    /// shows when objects are in their places is told by flattening.
    pub fn warnings(&self) -> Vec<String> {
        warn::warnings(self)
    }

    /// The top of the scene file, from which the checks walk down.
    fn top(&self) -> Place<'_> {
        Place::top(&self.source)
    }
}
