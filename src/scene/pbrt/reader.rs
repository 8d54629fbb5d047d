//! The state of a run through the directives: what they have made so far, and what was said about them.

use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec2};

use super::params::{Param, Params};
use super::tokens::Place;
use crate::error::{Location, Result};
use crate::printable::quote;
use crate::scene::assets::Assets;
use crate::scene::findings::Findings;
use crate::scene::mitsuba::mesh;
use crate::scene::mitsuba::reader::free_name;
use crate::scene::mitsuba::transform::moved;
use crate::scene::types::*;
use crate::scene::write::named;
use crate::shape::mesh::Mesh;

/// A material as a directive gives it; nothing where surfaces only bound media.
pub struct Look {
    pub material: Option<Material>,
    /// Nothing if the texture coordinates of the surface do not count.
    pub mapping: Option<Mapping>,
    pub name: String,
    pub at: Place,
}

/// An area light of the shapes that come next.
pub struct Area {
    pub radiance: Colour,
    pub is_two_sided: bool,
    pub at: Place,
}

/// The film, whose image may be a part of it.
pub struct Film {
    pub width: f64,
    pub height: f64,
    /// Left, right, top and bottom.
    pub crop: [f64; 4],
    /// The factor of radiance.
    pub scale: f64,
}

/// The texture coordinates of a surface: the scale of u and v, and what is added then.
pub type Mapping = [DVec2; 2];

/// The name of a material, and the mapping of its textures.
pub type On = (Option<String>, Option<Mapping>);

/// The mapping that changes nothing.
pub const AS_THEY_ARE: Mapping = [DVec2::ONE, DVec2::ZERO];

/// The state for the shapes and lights that come next.
#[derive(Clone)]
pub struct State {
    pub ctm: DAffine3,
    /// The index of the material.
    pub look: usize,
    /// The index of the area light.
    pub area: Option<usize>,
    pub is_reversed: bool,
    /// The name of the medium inside of shapes.
    pub inside: String,
    /// The parameters of all shapes, lights and so on.
    pub defaults: HashMap<&'static str, Vec<Param>>,
}

/// The shapes of an object that instances show.
pub struct Definition {
    pub name: String,
    pub objects: Vec<Object>,
}

pub struct Reader<'a> {
    /// The scene file that is written, to whose folder paths are relative.
    pub to: PathBuf,
    /// The folder of the scene's first file.
    pub folder: PathBuf,
    /// Whether the scene is read from where it stays.
    pub is_in_place: bool,
    pub lossless: bool,
    pub state: State,
    pub in_world: bool,
    pub systems: HashMap<String, DAffine3>,
    pub looks: Vec<Look>,
    pub named_looks: HashMap<String, usize>,
    pub areas: Vec<Area>,
    /// The textures of numbers and of colours, by whether they are colours and their names.
    pub textures: HashMap<(bool, String), (Texture, Mapping)>,
    /// The mapping of the textures that a surface has so far.
    pub mapping: Cell<Option<Mapping>>,
    pub media: HashMap<String, Medium>,
    pub definitions: HashMap<String, Vec<Object>>,
    /// The object that is being defined.
    pub definition: Option<Definition>,
    pub objects: Vec<Object>,
    pub materials: Vec<(String, Material)>,
    /// The names of materials by what they are, and those of shapes by their material, area light and alpha.
    same: HashMap<String, String>,
    pub known: HashMap<(usize, Option<usize>, String), On>,
    names: HashMap<String, usize>,
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    told: HashSet<(String, String)>,
    pub notes: Vec<String>,
    pub files: Vec<PathBuf>,
    pub places: HashMap<String, Location>,
    pub findings: Findings,
    pub camera: Option<Camera>,
    pub image: ImageSize,
    pub film: Film,
    pub samples: u32,
    pub max_depth: u32,
    pub background: Option<Background>,
    pub assets: &'a mut Assets,
}

/// A homogeneous medium.
#[derive(Clone)]
pub struct Medium {
    pub extinction: Colour,
    pub albedo: Colour,
    pub anisotropy: f64,
    pub at: Place,
}

impl<'a> Reader<'a> {
    pub fn new(path: &Path, to: &Path, lossless: bool, assets: &'a mut Assets) -> Reader<'a> {
        let at = Place { file: path.into(), line: 1, column: 1 };
        let matt = Lambertian { albedo: Texture::grey(0.5), ..Lambertian::default() };
        let first = Look { material: Some(Material::Lambertian(matt)), mapping: None, name: "default".to_owned(), at };
        Reader {
            to: to.to_owned(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            is_in_place: path == to,
            lossless,
            state: State {
                ctm: DAffine3::IDENTITY,
                look: 0,
                area: None,
                is_reversed: false,
                inside: String::new(),
                defaults: HashMap::new(),
            },
            in_world: false,
            systems: HashMap::new(),
            looks: vec![first],
            named_looks: HashMap::new(),
            areas: Vec::new(),
            textures: HashMap::new(),
            mapping: Cell::new(None),
            media: HashMap::new(),
            definitions: HashMap::new(),
            definition: None,
            objects: Vec::new(),
            materials: Vec::new(),
            same: HashMap::new(),
            known: HashMap::new(),
            names: HashMap::new(),
            meshes: BTreeMap::new(),
            told: HashSet::new(),
            notes: Vec::new(),
            files: Vec::new(),
            places: HashMap::new(),
            findings: Findings::default(),
            camera: None,
            image: ImageSize { width: 1280, height: 720 },
            film: Film { width: 1280.0, height: 720.0, crop: [0.0, 1280.0, 0.0, 720.0], scale: 1.0 },
            samples: 16,
            max_depth: 5,
            background: None,
            assets,
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

    /// Refuses the parameters that nobody has asked for.
    pub fn end(&mut self, params: &Params) {
        self.findings.record_all(params.unused());
    }

    /// Adds a shape or a light of the scene, or of the object that is being defined.
    pub fn add_object(&mut self, object: Object, at: &Place) {
        match &mut self.definition {
            Some(definition) => definition.objects.push(object),
            None => {
                self.places.insert(format!("objects[{}]", self.objects.len()), at.location());
                self.objects.push(object);
            }
        }
    }

    /// The name of a material, which is that of its directive if it is free. Equal materials have one.
    pub fn add_material(&mut self, material: Material, base: &str, at: &Place) -> String {
        let key = format!("{base} {material:?}");
        if let Some(known) = self.same.get(&key) {
            return known.clone();
        }
        let name = free_name(&mut self.names, base);
        self.places.insert(format!("materials[{name:?}]"), at.location());
        self.materials.push((name.clone(), material));
        self.same.insert(key, name.clone());
        name
    }

    /// Adds a mesh that no file has.
    pub fn add_mesh(&mut self, mesh: Mesh, material: Option<String>) -> Object {
        let path = mesh::path_of(&self.to, self.is_in_place, self.meshes.len());
        self.meshes.insert(path.clone(), Arc::new(mesh));
        Object::Mesh { path, material }
    }

    /// A file that a directive names: beside the scene's first file, as pbrt has it, or else beside the file of the directive.
    pub fn resolve(&self, name: &str, at: &Place) -> PathBuf {
        let beside_first = self.folder.join(name);
        let beside = at.file.parent().unwrap_or(Path::new("")).join(name);
        if !beside_first.exists() && beside.exists() { beside } else { beside_first }
    }

    /// The path of a file as the scene names it.
    pub fn named(&self, file: &Path) -> String {
        named(file, &self.to, self.is_in_place)
    }

    /// Notes the mapping of a texture. The result says whether it is that of the other textures of the surface.
    pub fn has_mapping(&self, mapping: Mapping) -> bool {
        self.mapping.replace(Some(mapping)).is_none_or(|other| other == mapping)
    }

    /// The shapes of an object, placed.
    pub fn instance(&mut self, name: &str, at: &Place) -> Result<()> {
        let what = "ObjectInstance";
        if self.definition.is_some() {
            return Err(at.error(what, "expected no instance inside of an object, as pbrt has it"));
        }
        let Some(objects) = self.definitions.get(name) else {
            return Err(at.error(what, format!("there is no object {}", quote(name))));
        };
        let group = Object::Group(objects.clone());
        let uneven = "expected a transform of turns, shifts and one positive scale: others of instances are not read";
        let placed = moved(&self.state.ctm, group).ok_or_else(|| at.error(what, uneven))?;
        self.add_object(placed, at);
        Ok(())
    }
}
