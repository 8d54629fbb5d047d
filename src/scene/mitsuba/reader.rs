//! What the elements of a scene have become so far, and what was said about them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::document::{Node, resolve};
use crate::error::{Location, Result};
use crate::scene::assets::Assets;
use crate::scene::findings::Findings;
use crate::scene::types::{Material, Object};
use crate::scene::write::named;
use crate::shape::Aabb;
use crate::shape::mesh::Mesh;

/// A shape, and a box around it.
pub struct Body<'a> {
    pub node: &'a Node,
    pub around: Aabb,
    pub is_glass: bool,
    pub emits: bool,
    pub has_medium: bool,
}

/// What has been made of the elements so far.
pub struct Reader<'a> {
    pub ids: HashMap<&'a str, &'a Node>,
    pub folders: Vec<PathBuf>,
    /// The scene file that is written, to whose folder paths are relative.
    pub to: PathBuf,
    /// Whether the scene is read from where it stays.
    pub is_in_place: bool,
    pub lossless: bool,
    /// Whether the integrator knows media.
    pub has_media: bool,
    pub materials: Vec<(String, Material)>,
    /// The materials of BSDFs by their index, and how their textures lie, by the element, or null, and the emission.
    pub known: HashMap<(*const Node, String), Option<(usize, DAffine3)>>,
    /// The indices of the parts of mixes by their names.
    pub parts: HashMap<String, usize>,
    /// The indices of materials by what they are.
    pub same: HashMap<String, usize>,
    /// How the textures lie that have been read for a surface.
    pub to_uv: Option<DAffine3>,
    /// The objects of shapes of groups, by the element and its transform: instances have the same.
    pub grouped: HashMap<(*const Node, [u64; 12]), Vec<Object>>,
    /// The shapes that may be inside of others, or around them.
    pub bodies: Vec<Body<'a>>,
    /// A sensor that names no medium, and where it is.
    pub outside: Option<(&'a Node, DVec3)>,
    /// How many materials have each name so far.
    pub names: HashMap<String, usize>,
    pub meshes: BTreeMap<String, Arc<Mesh>>,
    /// The meshes of files as they are.
    pub of_files: HashMap<PathBuf, Arc<Mesh>>,
    pub told: HashSet<(*const Node, String)>,
    pub notes: Vec<String>,
    pub files: Vec<PathBuf>,
    pub places: HashMap<String, Location>,
    pub findings: Findings,
    /// How many BSDFs are being read, each inside the one before.
    pub depth: usize,
    pub assets: &'a mut Assets,
}

impl<'a> Reader<'a> {
    /// Tells what is not as the file says; with `--lossless` it is an error.
    pub fn lose(&mut self, node: &Node, message: &str) {
        if !self.told.insert((std::ptr::from_ref(node), message.to_owned())) {
            return;
        }
        match self.lossless {
            true => self.findings.refuse(node.error(format!("{message} (--lossless)"))),
            false => self.notes.push(node.error(message).to_string()),
        }
    }

    /// The index of a material of an element, under a name of its own. Many shapes may have a BSDF each that is the same.
    pub fn add_material(&mut self, material: Material, node: &Node) -> usize {
        let next = self.materials.len();
        let index = *self.same.entry(format!("{material:?}")).or_insert(next);
        if node.attribute("id").is_none() && index < next {
            return index;
        }
        let base = node.attribute("id").or(node.attribute("type")).unwrap_or("default");
        let name = free_name(&mut self.names, base);
        self.places.insert(format!("materials[{name:?}]"), node.at.location());
        self.materials.push((name, material));
        next
    }

    /// The element, or the one that it refers to.
    pub fn target(&self, node: &'a Node) -> Result<&'a Node> {
        if node.tag != "ref" {
            return Ok(node);
        }
        let id = node.required("id")?;
        let missing = || node.error_at("id", format!("there is no element of the id {}", crate::printable::quote(id)));
        self.ids.get(id).copied().ok_or_else(missing)
    }

    /// The same, which must be of this tag.
    pub fn follow(&self, node: &'a Node, tag: &str) -> Result<&'a Node> {
        let found = self.target(node)?;
        match found.tag == tag {
            true => Ok(found),
            false => Err(node.error(format!("expected a {tag}, found {}", found.title()))),
        }
    }

    /// The path of a file as the scene names it.
    pub fn path(&self, name: &str, node: &Node) -> String {
        self.named(&resolve(name, node, &self.folders))
    }

    pub fn named(&self, file: &Path) -> String {
        named(file, &self.to, self.is_in_place)
    }
}

/// A name that no other has, which is `base` if that is free. `names` counts those with each base.
pub fn free_name(names: &mut HashMap<String, usize>, base: &str) -> String {
    let mut name = base.to_owned();
    while let Some(known) = names.get_mut(&name) {
        *known += 1;
        name = format!("{base} {known}");
    }
    names.insert(name.clone(), 1);
    name
}
