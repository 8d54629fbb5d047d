//! The nodes of the default scene in a pose, and their transforms in f64.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

use super::error::{GltfError, Result};
use crate::scene::types::Transform;
use crate::source::{LARGEST, SMALLEST};

/// A node of the default scene.
#[derive(Clone, Copy)]
pub struct SceneNode<'a> {
    pub index: usize,
    /// The node of the scene that it is, or is below.
    pub topmost: usize,
    pub node: &'a Node,
    pub to_scene: DAffine3,
    /// Whether animations move it, or a node above it.
    pub is_moved: bool,
}

/// What animations give a node, rounded to f32 as a file would have it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animated {
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    /// The weights of its morph targets.
    pub weights: Option<Vec<f32>>,
}

impl Animated {
    fn is_moved(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.scale.is_some()
    }
}

/// The nodes of the default scene at a time.
#[derive(Debug, Default)]
pub struct Pose {
    /// `None` for the rest pose: what the nodes themselves say.
    pub seconds: Option<f64>,
    /// Each before its children.
    nodes: Vec<PosedNode>,
    /// Their positions in that list, by number.
    positions: HashMap<usize, usize>,
    /// What animations give nodes, by the nodes' numbers.
    animated: HashMap<usize, Animated>,
    /// Notes about animations that are not used.
    pub notes: Vec<String>,
}

#[derive(Debug)]
struct PosedNode {
    index: usize,
    topmost: usize,
    to_scene: DAffine3,
    is_moved: bool,
}

impl Pose {
    /// The rest pose.
    pub fn rest(root: &Root) -> Result<Pose> {
        Pose::at(root, None, HashMap::new())
    }

    /// The pose in which animations give nodes these values.
    pub fn at(root: &Root, seconds: Option<f64>, animated: HashMap<usize, Animated>) -> Result<Pose> {
        let nodes = nodes(root, &animated)?;
        let positions = nodes.iter().enumerate().map(|(position, node)| (node.index, position)).collect();
        Ok(Pose { seconds, nodes, positions, animated, notes: Vec::new() })
    }

    /// The nodes: each before its children.
    pub fn nodes<'a>(&'a self, root: &'a Root) -> impl Iterator<Item = SceneNode<'a>> {
        self.nodes.iter().filter_map(|node| scene_node(node, root))
    }

    /// The node of this number, if the default scene has it.
    pub fn node<'a>(&'a self, root: &'a Root, index: usize) -> Option<SceneNode<'a>> {
        scene_node(self.nodes.get(*self.positions.get(&index)?)?, root)
    }

    /// The weights that animations give a node's morph targets.
    pub fn weights(&self, index: usize) -> Option<&[f32]> {
        self.animated.get(&index)?.weights.as_deref()
    }
}

fn scene_node<'a>(node: &PosedNode, root: &'a Root) -> Option<SceneNode<'a>> {
    let &PosedNode { index, topmost, to_scene, is_moved } = node;
    Some(SceneNode { index, topmost, node: root.nodes.get(index)?, to_scene, is_moved })
}

/// The nodes of the default scene, or of the first scene if there is no default.
fn nodes(root: &Root, animated: &HashMap<usize, Animated>) -> Result<Vec<PosedNode>> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    let at = if root.scene.is_some() { "scene" } else { "scenes" };
    let top = root.scenes.get(scene).ok_or_else(|| GltfError::new(at, format!("expected a scene {scene} in it")))?;
    // Visits every node once: in a malicious file, nodes can be each other's children.
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    // A stack: the first node is on top.
    // With the topmost node and the one above.
    let mut nodes: Vec<(usize, [Option<usize>; 2], DAffine3, bool)> =
        top.nodes.iter().rev().map(|node| (node.value(), [None; 2], DAffine3::IDENTITY, false)).collect();
    while let Some((index, [topmost, above], parent, is_parent_moved)) = nodes.pop() {
        let topmost = topmost.unwrap_or(index);
        let wrong = |reason: &str| GltfError::new(format!("nodes[{index}]"), reason);
        if !seen.insert(index) {
            return Err(wrong("it occurs twice: expected a tree of nodes"));
        }
        let Some(node) = root.nodes.get(index) else {
            let at = above.map_or(format!("scenes[{scene}].nodes"), |above| format!("nodes[{above}].children"));
            return Err(GltfError::new(at, format!("there is no node {index}")));
        };
        let animated = animated.get(&index).filter(|animated| animated.is_moved());
        if animated.is_some() && node.matrix.is_some() {
            let reason =
                "it has a matrix, and an animation moves it: expected a translation, a rotation and a scale instead";
            return Err(GltfError::new(format!("nodes[{index}].matrix"), reason));
        }
        let is_moved = is_parent_moved || animated.is_some();
        let to_scene = parent * to_parent(node, animated);
        if !to_scene.is_finite() {
            return Err(wrong("expected transforms of finite numbers, and a rotation that is not 0"));
        }
        found.push(PosedNode { index, topmost, to_scene, is_moved });
        let children = node.children.iter().flatten().rev();
        nodes.extend(children.map(|child| (child.value(), [Some(topmost), Some(index)], to_scene, is_moved)));
    }
    Ok(found)
}

/// A node's own transform, with what animations give it.
fn to_parent(node: &Node, animated: Option<&Animated>) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let vector = |value: Option<[f32; 3]>, default| value.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    let rotation = animated.and_then(|animated| animated.rotation).unwrap_or(node.rotation.unwrap_or_default().0);
    DAffine3::from_scale_rotation_translation(
        vector(animated.and_then(|animated| animated.scale).or(node.scale), DVec3::ONE),
        DQuat::from_array(rotation.map(f64::from)).normalize(),
        vector(animated.and_then(|animated| animated.translation).or(node.translation), DVec3::ZERO),
    )
}

/// How far the columns of a matrix may be from orthogonal and equally long. Products of matrices and rotations in f32 are off by some
/// units of 6e-8, and a part of an object moves by no more than this share of the object's size.
const ROUNDING: f64 = 1e-6;

/// A transform as the scene file writes it; nothing if it mirrors, or scales unevenly.
pub fn similarity(transform: &DAffine3) -> Option<Vec<Transform>> {
    let DAffine3 { matrix3, translation } = *transform;
    let scale = matrix3.determinant().cbrt();
    if !(SMALLEST..=LARGEST).contains(&scale) || translation.length() > LARGEST {
        return None;
    }
    let rotation = matrix3 * (1.0 / scale);
    let rest = rotation.transpose() * rotation - DMat3::IDENTITY;
    if rest.to_cols_array().iter().any(|x| x.is_nan() || x.abs() > ROUNDING) {
        return None;
    }
    let (axis, angle) = DQuat::from_mat3(&rotation).normalize().to_axis_angle();
    let scaled = (scale - 1.0).abs() > 1e-15;
    let scale = scaled.then_some(Transform::Scale(scale));
    let rotate = (angle != 0.0).then(|| Transform::Rotate { axis, degrees: angle.to_degrees() });
    let shift = (translation != DVec3::ZERO).then_some(Transform::Translate(translation));
    Some(scale.into_iter().chain(rotate).chain(shift).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similarity_is_written_as_transforms() {
        let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 1.25);
        let transform =
            DAffine3::from_scale_rotation_translation(DVec3::splat(3.0), rotation, DVec3::new(1.0, -2.0, 5.0));
        let found = similarity(&transform).unwrap();
        let [Transform::Scale(scale), Transform::Rotate { axis, degrees }, Transform::Translate(by)] = found[..] else {
            panic!("{found:?}")
        };
        assert!((scale - 3.0).abs() < 1e-14 && (degrees - 1.25_f64.to_degrees()).abs() < 1e-12);
        assert!((axis - DVec3::new(1.0, 2.0, -2.0) / 3.0).length() < 1e-14 && by == DVec3::new(1.0, -2.0, 5.0));
        assert_eq!(similarity(&DAffine3::IDENTITY), Some(Vec::new()));
        for scale in [DVec3::new(1.0, 1.0, 1.00001), DVec3::new(-1.0, 1.0, 1.0), DVec3::ZERO, DVec3::splat(-1.0)] {
            assert_eq!(similarity(&DAffine3::from_scale(scale)), None, "{scale}");
        }
    }
}
