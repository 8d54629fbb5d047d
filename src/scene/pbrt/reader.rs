//! The state of a run through the directives: what they have made so far, and what was said about them.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::{DAffine3, DVec2, DVec3};

use super::params::{Param, Params};
use crate::scene::file::OnProgress;
use crate::scene::imported::files::Includes;
use crate::scene::imported::surface::Medium;
use crate::scene::imported::{Imported, Place};
use crate::scene::types::*;

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
    /// Whether that is the power of a shape, on its sides together.
    pub is_power: bool,
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
#[derive(Clone, Default)]
pub struct State {
    pub ctm: DAffine3,
    /// The index of the material.
    pub look: usize,
    /// The index of the area light.
    pub area: Option<usize>,
    pub is_reversed: bool,
    /// Whether an instance mirrors the shape.
    pub is_in_mirror: bool,
    /// Whether transforms are of the end of motion alone, which is not read.
    pub is_at_end: bool,
    /// The name of the medium inside of shapes, and whether that outside has one.
    pub inside: String,
    pub has_outside: bool,
    /// The parameters of all shapes, lights and so on.
    pub defaults: HashMap<&'static str, Vec<Param>>,
}

/// The shapes of an object that instances show.
#[derive(Default)]
pub struct Definition {
    pub name: String,
    pub objects: Vec<Object>,
    /// The directives of its shapes, for instances that are not even.
    pub shapes: Vec<(String, Params, State)>,
}

pub struct Reader<'a, 'p> {
    pub made: Imported<'a>,
    pub progress: &'p mut OnProgress<'p>,
    /// The folder of the scene's first file.
    pub folder: PathBuf,
    pub state: State,
    pub in_world: bool,
    pub systems: HashMap<String, DAffine3>,
    pub looks: Vec<Look>,
    pub named_looks: HashMap<String, usize>,
    pub areas: Vec<Area>,
    /// The textures of numbers and of colours, by whether they are colours and their names.
    pub textures: HashMap<(bool, String), (Texture, Mapping)>,
    /// The mapping of the textures that a surface has so far.
    pub mapping: Option<Mapping>,
    /// The camera, which needs the film.
    pub camera: Option<(String, Params, DAffine3)>,
    /// The states that are kept, and where.
    pub states: Vec<(State, Place)>,
    pub includes: Includes,
    pub media: HashMap<String, (Medium, Place)>,
    pub definitions: HashMap<String, Rc<Definition>>,
    /// The object that is being defined.
    pub definition: Option<Definition>,
    pub film: Film,
}

impl<'a, 'p> Reader<'a, 'p> {
    pub fn new(path: &Path, mut made: Imported<'a>, progress: &'p mut OnProgress<'p>) -> Reader<'a, 'p> {
        made.parts.objects = Some(Vec::new());
        made.parts.render = RenderDefaults { samples: 16, max_depth: 5 };
        made.parts.image = Some(ImageSize { width: 1280, height: 720 });
        made.parts.camera = Some(Camera::pinhole(DVec3::ZERO, DVec3::Z, DVec3::Y, 90.0));
        let at = Place { file: path.into(), line: 1, column: 1 };
        let matt = Lambertian { albedo: Texture::grey(0.5), ..Lambertian::default() };
        let first = Look { material: Some(Material::Lambertian(matt)), mapping: None, name: "default".to_owned(), at };
        Reader {
            made,
            progress,
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            state: State::default(),
            in_world: false,
            systems: HashMap::new(),
            looks: vec![first],
            named_looks: HashMap::new(),
            areas: Vec::new(),
            textures: HashMap::new(),
            mapping: None,
            camera: None,
            states: Vec::new(),
            includes: Includes::new(path),
            media: HashMap::new(),
            definitions: HashMap::new(),
            definition: None,
            film: Film { width: 1280.0, height: 720.0, crop: [0.0, 1280.0, 0.0, 720.0], scale: 1.0 },
        }
    }

    /// Tells what is not as a parameter says, or the directive if it has none of this name.
    pub fn lose(&mut self, params: &Params, name: &str, message: &str) {
        self.made.lose(params.place_of(name), &params.title, message);
    }

    /// Refuses the parameters that nobody has asked for.
    pub fn end(&mut self, params: &Params) {
        self.made.findings.record_all(params.unused());
    }

    /// Adds a shape or a light of the scene, or of the object that is being defined.
    pub fn add_object(&mut self, object: Object, at: &Place) {
        match &mut self.definition {
            Some(definition) => definition.objects.push(object),
            None => self.made.add_object(object, at),
        }
    }

    /// The name of a material, which is that of its directive if it is free.
    pub fn add_material(&mut self, material: Material, base: &str, at: &Place) -> String {
        let index = self.made.add_material(material, base, at);
        self.made.parts.materials[index].0.clone()
    }

    /// A file that a directive names: beside the scene's first file, as pbrt has it, or else beside the file of the directive.
    pub fn resolve(&self, name: &str, at: &Place) -> PathBuf {
        let beside_first = self.folder.join(name);
        let beside = at.folder().join(name);
        if !beside_first.exists() && beside.exists() { beside } else { beside_first }
    }

    /// Notes the mapping of a texture. The result says whether it is that of the other textures of the surface.
    pub fn has_mapping(&mut self, mapping: Mapping) -> bool {
        self.mapping.replace(mapping).is_none_or(|other| other == mapping)
    }
}
