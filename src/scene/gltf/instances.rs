//! The instances of a node's mesh: EXT_mesh_gpu_instancing.

use std::iter::once;

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::scene::Node;
use serde_json::Value;

use super::accessors::{ALL, Elements, Extent};
use super::nodes::SceneNode;
use super::{File, GltfError, Result};

pub const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// The most instances of primitives in a file. Nodes may share their accessors, so that a small file could have any number of them.
pub const MOST_INSTANCES: u64 = 1 << 20;

/// The number of the accessor of an attribute; `None` if it is not there.
fn attribute(node: usize, attributes: &Value, name: &str) -> Result<Option<Index<Accessor>>> {
    let Some(given) = attributes.get(name) else { return Ok(None) };
    let index = given.as_u64().and_then(|index| u32::try_from(index).ok());
    let index = index.ok_or_else(|| wrong(node, name, "expected the number of an accessor".to_owned()))?;
    Ok(Some(Index::new(index)))
}

fn wrong(node: usize, attribute: &str, reason: String) -> GltfError {
    GltfError::new(format!("nodes[{node}].extensions.{EXTENSION}.attributes.{attribute}"), reason)
}

/// What the extension has in a node.
fn of_node(node: &Node) -> Option<&Value> {
    node.extensions.as_ref()?.others.get(EXTENSION)
}

/// Whether a node has instances of its mesh. Skins do not go with them: a skin ignores the transform of its node.
pub fn has_instances(node: &Node) -> bool {
    node.skin.is_none() && of_node(node).is_some()
}

/// Whether a node has instances that are not read.
pub fn has_unread_instances(node: &Node) -> bool {
    node.skin.is_some() && of_node(node).is_some()
}

/// The values of an attribute, which may be integers that stand for -1 to 1.
type Values<'a, const N: usize> = Option<Elements<'a, [f64; N]>>;

impl File {
    /// The transforms of a node's instances from one of them on, each from the space of its mesh to that of the scene; that of the node alone if it has
    /// no instances. An error if their accessors cannot be read, differ in their lengths or hold what is no transform.
    pub fn instances<'a>(
        &'a self,
        scene_node: &SceneNode<'a>,
        from: usize,
    ) -> Result<Box<dyn Iterator<Item = Result<DAffine3>> + 'a>> {
        let SceneNode { index: node, to_scene, .. } = *scene_node;
        let Some(given) = of_node(scene_node.node).filter(|_| has_instances(scene_node.node)) else {
            return Ok(Box::new(once(Ok(to_scene)).skip(from)));
        };
        let at = move || format!("nodes[{node}].extensions.{EXTENSION}.attributes");
        let attributes = given.get("attributes").filter(|attributes| attributes.is_object());
        let attributes = attributes.ok_or_else(|| GltfError::new(at(), "expected an object"))?;
        // How many there are, and the attribute that says so.
        let mut known: Option<(u64, &str)> = None;
        for name in ["TRANSLATION", "ROTATION", "SCALE"] {
            let Some(index) = attribute(node, attributes, name)? else { continue };
            let found = self.accessor(index).map(|accessor| accessor.count.0);
            let found = found.ok_or_else(|| wrong(node, name, format!("there is no accessor {}", index.value())))?;
            let (expected, first) = *known.get_or_insert((found, name));
            if found != expected {
                let reason = format!("expected {expected} elements, as {first} has, found {found}");
                return Err(wrong(node, name, reason));
            }
        }
        let Some((count, _)) = known else {
            return Err(GltfError::new(at(), "expected a TRANSLATION, a ROTATION or a SCALE"));
        };
        if count > MOST_INSTANCES {
            return Err(GltfError::new(at(), format!("expected at most {MOST_INSTANCES} instances, found {count}")));
        }
        let extent = Extent { from, ..ALL };
        let three = |name| -> Result<Values<3>> {
            let elements = attribute(node, attributes, name)?.map(|index| self.elements(index, extent)).transpose();
            elements.map_err(|reason| wrong(node, name, reason))
        };
        let (mut translations, mut scales) = (three("TRANSLATION")?, three("SCALE")?);
        let rotations =
            attribute(node, attributes, "ROTATION")?.map(|index| self.elements::<4>(index, extent)).transpose();
        let mut rotations = rotations.map_err(|reason| wrong(node, "ROTATION", reason))?;
        Ok(Box::new((from as u64..count).map(move |instance| {
            let placed = DAffine3::from_scale_rotation_translation(
                next(&mut scales).map_or(DVec3::ONE, DVec3::from_array),
                next(&mut rotations).map_or(DQuat::IDENTITY, DQuat::from_array).normalize(),
                next(&mut translations).map_or(DVec3::ZERO, DVec3::from_array),
            );
            let placed = to_scene * placed;
            let reason = "expected transforms of finite numbers, and a rotation that is not 0";
            let is_good = placed.is_finite();
            is_good.then_some(placed).ok_or_else(|| GltfError::new(at(), format!("instance {instance}: {reason}")))
        })))
    }

    /// The transform of one instance of a node; that of the node itself for `None`.
    pub fn instance(&self, scene_node: &SceneNode, instance: Option<usize>) -> Result<DAffine3> {
        let Some(instance) = instance else { return Ok(scene_node.to_scene) };
        let found = if has_instances(scene_node.node) { self.instances(scene_node, instance)?.next() } else { None };
        found.unwrap_or_else(|| {
            Err(GltfError::new(format!("nodes[{}]", scene_node.index), format!("there is no instance {instance}")))
        })
    }
}

fn next<const N: usize>(values: &mut Values<N>) -> Option<[f64; N]> {
    values.as_mut()?.next()
}
