//! Scenes of other programs: what their readers make, and the shapes, spectra and transforms that they share.

pub mod bodies;
pub mod files;
mod image;
pub mod mesh;
pub mod spectrum;
pub mod surface;
pub mod tables;
pub mod transform;
mod write;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::assets::Assets;
use super::draft::{MOST_BYTES, too_large};
use super::file::OnProgress;
use super::findings::Findings;
use super::gltf_options::GltfOptions;
use super::mesh_files::load_file;
use super::recover::Parts;
use super::types::*;
use super::write::named;
use crate::error::{Error, Location, Result};
use crate::shape::Aabb;
use crate::shape::mesh::Mesh;
pub use image::Pattern;
pub use write::{write_exr, write_ply};

/// A place in a file.
#[derive(Clone, Debug)]
pub struct Place {
    pub file: Arc<Path>,
    pub line: u32,
    pub column: u32,
}

impl Place {
    pub fn location(&self) -> Location {
        Location { file: self.file.to_path_buf(), line: self.line as usize, column: self.column as usize }
    }

    pub fn error(&self, what: &str, message: impl Into<String>) -> Error {
        Error::Scene { location: self.location(), field: what.to_owned(), message: message.into() }
    }

    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }
}

/// A shape, and a box around it.
pub struct Body {
    pub at: Place,
    /// The name in messages.
    pub title: String,
    pub around: Aabb,
    pub is_glass: bool,
    pub emits: bool,
    pub has_medium: bool,
}

/// The scene that a reader has made so far, and what it has told.
pub struct Imported<'a> {
    /// The scene file that is written, to whose folder paths are relative.
    to: PathBuf,
    /// Whether the scene is read from where it stays.
    is_in_place: bool,
    lossless: bool,
    pub parts: Parts,
    /// The meshes and images that are in no file, by their paths. The images have any format, as colours.
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    pub images: Bitmaps,
    /// The bytes that are left for them.
    room: usize,
    pub notes: Vec<String>,
    /// The files that were read, without the first.
    pub files: Vec<PathBuf>,
    /// The shapes that may be inside of others, or around them.
    pub bodies: Vec<Body>,
    /// A camera that names no medium around it, and where it is.
    pub outside: Option<(Place, String, DVec3)>,
    /// Where values of the scene stand, by their paths such as `objects[3]`.
    pub places: HashMap<String, Location>,
    pub findings: Findings,
    pub assets: &'a mut Assets,
    /// The indices of materials by their names and what they are.
    same: HashMap<String, usize>,
    /// How many materials have each name so far.
    names: HashMap<String, usize>,
    told: HashSet<(String, String)>,
}

impl<'a> Imported<'a> {
    pub fn new(path: &Path, to: &Path, options: &GltfOptions, assets: &'a mut Assets) -> Imported<'a> {
        Imported {
            to: to.to_owned(),
            is_in_place: path == to,
            lossless: options.lossless,
            parts: Parts::default(),
            meshes: BTreeMap::new(),
            images: Bitmaps::default(),
            room: MOST_BYTES,
            notes: Vec::new(),
            files: Vec::new(),
            bodies: Vec::new(),
            outside: None,
            places: HashMap::new(),
            findings: Findings::default(),
            assets,
            same: HashMap::new(),
            names: HashMap::new(),
            told: HashSet::new(),
        }
    }

    /// Tells what is not as the file says; with `--lossless` it is an error.
    pub fn lose(&mut self, at: &Place, what: &str, message: &str) {
        if !self.told.insert((at.location().to_string(), message.to_owned())) {
            return;
        }
        match self.lossless {
            true => self.findings.refuse(at.error(what, format!("{message} (--lossless)"))),
            false => self.notes.push(at.error(what, message).to_string()),
        }
    }

    /// Notes where sections of the scene come from.
    pub fn place(&mut self, sections: &[&str], at: &Place) {
        self.places.extend(sections.iter().map(|section| ((*section).to_owned(), at.location())));
    }

    pub fn add_object(&mut self, object: Object, at: &Place) {
        let objects = self.parts.objects.get_or_insert_default();
        self.places.insert(format!("objects[{}]", objects.len()), at.location());
        objects.push(object);
    }

    /// Sets the light around the scene.
    pub fn set_background(&mut self, background: Background, what: &str, at: &Place) -> Result<()> {
        self.place(&["background"], at);
        match self.parts.background.replace(background) {
            None => Ok(()),
            Some(_) => Err(at.error(what, "expected one light around the scene, found another")),
        }
    }

    /// The index of a material, whose name is `base` if that is free. Equal materials of one base are one.
    pub fn add_material(&mut self, material: Material, base: &str, at: &Place) -> usize {
        let next = self.parts.materials.len();
        let index = *self.same.entry(format!("{base} {material:?}")).or_insert(next);
        if index == next {
            let mut name = base.to_owned();
            while let Some(known) = self.names.get_mut(&name) {
                *known += 1;
                name = format!("{base} {known}");
            }
            self.names.insert(name.clone(), 1);
            self.places.insert(format!("materials[{name:?}]"), at.location());
            self.parts.materials.push((name, material));
        }
        index
    }

    /// The mesh of a file.
    pub fn mesh(&mut self, path: &Path, progress: &mut OnProgress) -> std::result::Result<Arc<Mesh>, String> {
        let files = self.assets.stamp_files(path);
        if let Some((known, _)) = self.assets.mesh(path, &files) {
            return Ok(known);
        }
        let (read, left) = load_file(path, MOST_BYTES, progress)?;
        self.assets.keep_mesh(path, files, (Arc::clone(&read), MOST_BYTES - left));
        Ok(read)
    }

    /// Adds a mesh that no file has: the scene's own file has it, or one that `convert` writes.
    pub fn add_mesh(&mut self, mesh: Mesh, material: Option<String>, at: &Place) -> Object {
        let bytes = size_of_val(&mesh.positions[..]) + size_of_val(&mesh.triangles[..]);
        if let Err(reason) = self.take_room(bytes) {
            self.findings.refuse(at.error("meshes", reason));
            return Object::Group(Vec::new());
        }
        let path = self.path_of_made("meshes", self.meshes.len(), "ply");
        self.meshes.insert(path.clone(), Arc::new(mesh));
        Object::Mesh { path, material }
    }

    /// Adds a file that was read.
    pub fn add_file(&mut self, file: &Path) {
        if !self.files.iter().any(|known| known == file) {
            self.files.push(file.to_owned());
        }
    }

    /// Takes bytes for what no file has.
    fn take_room(&mut self, bytes: usize) -> std::result::Result<(), String> {
        self.room = self.room.checked_sub(bytes).ok_or_else(too_large)?;
        Ok(())
    }

    fn path_of_made(&self, kind: &str, number: usize, ending: &str) -> String {
        match self.is_in_place {
            true => format!("{}#{kind}/{number}", self.to.file_name().unwrap_or_default().to_string_lossy()),
            false => format!("{}-{number}.{ending}", self.to.file_stem().unwrap_or_default().to_string_lossy()),
        }
    }

    /// The path of a file as the scene names it.
    pub fn named(&self, file: &Path) -> String {
        named(file, &self.to, self.is_in_place)
    }
}
