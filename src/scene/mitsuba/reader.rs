//! What the elements of a scene have become so far, and what was said about them.

use std::collections::HashMap;
use std::path::PathBuf;

use glam::DAffine3;

use super::document::{Node, resolve};
use crate::error::{Result, require};
use crate::scene::imported::Imported;
use crate::scene::types::{Material, Object};

/// What has been made of the elements so far.
pub struct Reader<'a, 'm> {
    pub ids: HashMap<&'a str, &'a Node>,
    pub folders: Vec<PathBuf>,
    pub made: Imported<'m>,
    /// Whether the integrator knows media.
    pub has_media: bool,
    /// The materials of BSDFs by their index, and how their textures lie, by the element, or null, and the emission.
    pub known: HashMap<(*const Node, String), Option<(usize, DAffine3)>>,
    /// The indices of the parts of mixes by their names.
    pub parts: HashMap<String, usize>,
    /// How the textures lie that have been read for a surface.
    pub to_uv: Option<DAffine3>,
    /// The objects of shapes of groups, by the element and its transform: instances have the same.
    pub grouped: HashMap<(*const Node, [u64; 12]), Vec<Object>>,
    /// How many BSDFs are being read, each inside the one before.
    pub depth: usize,
}

impl<'a> Reader<'a, '_> {
    /// Tells what is not as the file says; with `--lossless` it is an error.
    pub fn lose(&mut self, node: &Node, message: &str) {
        self.made.lose(&node.at, &node.title(), message);
    }

    /// The index of a material of an element. Many shapes may have a BSDF each that is the same.
    pub fn add_material(&mut self, material: Material, node: &Node) -> usize {
        let base = node.attribute("id").or(node.attribute("type")).unwrap_or("default");
        self.made.add_material(material, base, &node.at)
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
        require(found.tag == tag, || node.error(format!("expected a {tag}, found {}", found.title())))?;
        Ok(found)
    }

    /// The path of a file as the scene names it.
    pub fn path(&self, name: &str, node: &Node) -> String {
        self.made.named(&resolve(name, node, &self.folders))
    }
}
