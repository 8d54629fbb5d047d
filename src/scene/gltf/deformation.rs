//! How the vertices of a node's mesh get into the scene: morph targets, and then the node's transform or its skin.

use std::iter::repeat;

use glam::{DAffine3, DMat3, DMat4, DVec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{MorphTarget, Primitive, Semantic};
use gltf::json::skin::Skin;
use gltf::json::validation::Checked;

use super::accessors::{ALL, Elements, Extent};
use super::error::in_primitive;
use super::nodes::{Pose, SceneNode};
use super::{File, GltfError, Result};

/// The joints of a vertex, each with its weight: two sets of four.
type Influences = [(f64, f64); 8];

/// What happens to the vertices of a mesh: first they are morphed, and then they are moved.
pub struct Deformation {
    /// The weights of morph targets; those that it does not have are 0.
    weights: Vec<f64>,
    transform: Transform,
}

enum Transform {
    /// One for all vertices.
    Rigid(DAffine3),
    /// Of the joints of a skin, from the space of the mesh to that of the scene.
    Skinned { skin: usize, joints: Vec<DAffine3> },
}

impl Deformation {
    /// One transform for all vertices.
    pub fn rigid(transform: DAffine3) -> Deformation {
        Deformation { weights: Vec::new(), transform: Transform::Rigid(transform) }
    }

    /// The deformation without its transform.
    pub fn in_mesh(self) -> Deformation {
        Deformation { transform: Transform::Rigid(DAffine3::IDENTITY), ..self }
    }

    /// A normal under one of its transforms. Where the blend of joints is singular, none is right, and the vertex keeps its own.
    pub fn normal(&self, to_scene: &DAffine3, normal: DVec3) -> DVec3 {
        let turned = of_normals(&to_scene.matrix3) * normal;
        match self.transform {
            Transform::Skinned { .. } if turned == DVec3::ZERO => normal.normalize(),
            _ => turned.normalize(),
        }
    }

    /// Whether its transform mirrors, if it is one for all vertices.
    pub fn mirrors(&self) -> Option<bool> {
        match &self.transform {
            Transform::Rigid(transform) => Some(transform.matrix3.determinant().signum() < 0.0),
            Transform::Skinned { .. } => None,
        }
    }
}

/// How normals transform: the transposed inverse of the matrix, times a number that is not negative. It exists for singular matrices too.
fn of_normals(m: &DMat3) -> DMat3 {
    let sign = m.determinant().signum();
    DMat3::from_cols(m.y_axis.cross(m.z_axis) * sign, m.z_axis.cross(m.x_axis) * sign, m.x_axis.cross(m.y_axis) * sign)
}

/// The accessor of a morph target that is added to an attribute.
type Delta = fn(&MorphTarget) -> Option<Index<Accessor>>;

/// The attributes that morph targets change, by their names.
pub const POSITION: (&str, Delta) = ("POSITION", |target| target.positions);
pub const NORMAL: (&str, Delta) = ("NORMAL", |target| target.normals);
pub const TANGENT: (&str, Delta) = ("TANGENT", |target| target.tangents);

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Whether the skin of a node moves a primitive's vertices.
fn has_joints(primitive: &Primitive) -> bool {
    attribute(primitive, Semantic::Joints(0)).is_some()
}

/// Whether a primitive has joints that are not read.
pub fn has_more_joints(primitive: &Primitive) -> bool {
    attribute(primitive, Semantic::Joints(2)).is_some()
}

/// The weights of the morph targets of a node's mesh: those of the animations, of the node, or of the mesh.
fn weights(file: &File, pose: &Pose, scene_node: &SceneNode) -> Vec<f64> {
    let mesh = scene_node.node.mesh.and_then(|mesh| file.root().meshes.get(mesh.value()));
    let of_mesh = mesh.and_then(|mesh| mesh.weights.as_deref());
    let found = pose.weights(scene_node.index).or(scene_node.node.weights.as_deref()).or(of_mesh);
    found.unwrap_or_default().iter().map(|weight| f64::from(*weight)).collect()
}

impl File {
    /// What happens to the vertices of a primitive of a node's mesh.
    pub fn deformation(&self, pose: &Pose, scene_node: &SceneNode, primitive: &Primitive) -> Result<Deformation> {
        let transform = match self.skin(scene_node)? {
            Some((skin, given)) if has_joints(primitive) => {
                Transform::Skinned { skin, joints: self.joints(pose, skin, given)? }
            }
            _ => Transform::Rigid(scene_node.to_scene),
        };
        Ok(Deformation { weights: weights(self, pose, scene_node), transform })
    }

    /// Whether morph targets change a primitive of a node's mesh.
    pub fn is_morphed(&self, pose: &Pose, scene_node: &SceneNode, primitive: &Primitive) -> bool {
        let targets = primitive.targets.as_ref().map_or(0, Vec::len);
        weights(self, pose, scene_node).iter().take(targets).any(|weight| *weight != 0.0)
    }

    /// Whether animations move any joint of a node's skin.
    pub fn has_moved_joints(&self, pose: &Pose, scene_node: &SceneNode) -> Result<bool> {
        let joints = self.skin(scene_node)?.map_or(&[][..], |(_, skin)| &skin.joints);
        Ok(joints.iter().any(|joint| pose.node(self.root(), joint.value()).is_some_and(|node| node.is_moved)))
    }

    /// The skin of a node, and its number.
    fn skin(&self, scene_node: &SceneNode) -> Result<Option<(usize, &Skin)>> {
        let Some(number) = scene_node.node.skin.map(|skin| skin.value()) else { return Ok(None) };
        let at = || format!("nodes[{}].skin", scene_node.index);
        let found = self.root().skins.get(number);
        found.map(|skin| Some((number, skin))).ok_or_else(|| GltfError::new(at(), format!("there is no skin {number}")))
    }

    /// The transforms of the joints of a skin, each behind its inverse bind matrix.
    fn joints(&self, pose: &Pose, number: usize, skin: &Skin) -> Result<Vec<DAffine3>> {
        let count = skin.joints.len();
        let wrong = |reason: String| GltfError::new(format!("skins[{number}].inverseBindMatrices"), reason);
        let inverse: Vec<DAffine3> = match skin.inverse_bind_matrices {
            None => vec![DAffine3::IDENTITY; count],
            Some(index) => {
                let matrices = self.matrices(index).map_err(wrong)?.take(count);
                matrices.map(|columns| DAffine3::from_mat4(DMat4::from_cols_array_2d(&columns))).collect()
            }
        };
        if inverse.len() < count {
            return Err(wrong(format!("expected a matrix for each of {count} joints, found {}", inverse.len())));
        }
        if let Some(joint) = inverse.iter().position(|matrix| !matrix.is_finite()) {
            return Err(wrong(format!("expected finite numbers, found others in matrix {joint}")));
        }
        let of_joint = |(position, (joint, inverse)): (usize, (&Index<_>, &DAffine3))| {
            let node = pose.node(self.root(), joint.value()).ok_or_else(|| {
                let at = format!("skins[{number}].joints[{position}]");
                GltfError::new(at, format!("expected a node of the default scene, found {}", joint.value()))
            })?;
            Ok(node.to_scene * *inverse)
        };
        skin.joints.iter().zip(&inverse).enumerate().map(of_joint).collect()
    }

    /// The transforms of a primitive's vertices, of which there are so many.
    pub fn transforms<'a>(
        &'a self,
        (mesh, number): (usize, usize),
        deformation: &'a Deformation,
    ) -> Result<Elements<'a, DAffine3>> {
        let (skin, joints) = match &deformation.transform {
            Transform::Rigid(transform) => return Ok(Box::new(repeat(*transform))),
            Transform::Skinned { skin, joints } => (*skin, joints),
        };
        let influences = || self.influences((mesh, number));
        // Checked first, so that the transforms are no results.
        let bad = influences()?.enumerate().find_map(|(vertex, of_vertex)| {
            let weight = of_vertex.iter().find(|(_, weight)| !weight.is_finite() || *weight < 0.0);
            let joint = of_vertex.iter().find(|(joint, weight)| *weight > 0.0 && joint_of(joints, *joint).is_none());
            match (weight, joint) {
                (Some((_, weight)), _) => {
                    Some(("WEIGHTS", format!("expected weights from 0 to 1, found {weight} at vertex {vertex}")))
                }
                (None, Some((joint, _))) => Some((
                    "JOINTS",
                    format!("vertex {vertex}: there is no joint {joint}; skins[{skin}] has {}", joints.len()),
                )),
                (None, None) => None,
            }
        });
        if let Some((attribute, reason)) = bad {
            return Err(in_primitive((mesh, number), &format!(".attributes.{attribute}_0"), reason));
        }
        Ok(Box::new(influences()?.map(move |of_vertex| blended(&of_vertex, joints))))
    }

    /// The joints of a primitive's vertices, each with its weight.
    fn influences(&self, (mesh, number): (usize, usize)) -> Result<Elements<'_, Influences>> {
        let primitive = self.primitive(mesh, number)?;
        let vertices = self.vertex_count(primitive);
        let of = |name: &str, semantic: fn(u32) -> Semantic, set: u32| {
            let wrong = |reason| in_primitive((mesh, number), &format!(".attributes.{name}_{set}"), reason);
            let index = attribute(primitive, semantic(set))
                .ok_or_else(|| wrong("it is missing: each vertex of a skin has joints and weights".to_owned()))?;
            let found = self.accessor(index).map_or(vertices, |accessor| accessor.count.0);
            if found != vertices {
                return Err(wrong(format!("expected an element for each of {vertices} vertices, found {found}")));
            }
            self.elements::<4>(index, ALL).map_err(wrong)
        };
        let both = |set: u32| -> Result<_> {
            Ok(of("JOINTS", Semantic::Joints, set)?.zip(of("WEIGHTS", Semantic::Weights, set)?))
        };
        let first = both(0)?;
        let mut second = if attribute(primitive, Semantic::Joints(1)).is_some() { Some(both(1)?) } else { None };
        Ok(Box::new(first.map(move |([a, b, c, d], [e, f, g, h])| {
            let none = ([0.0; 4], [0.0; 4]);
            let ([i, j, k, l], [m, n, o, p]) = second.as_mut().and_then(Iterator::next).unwrap_or(none);
            [(a, e), (b, f), (c, g), (d, h), (i, m), (j, n), (k, o), (l, p)]
        })))
    }

    /// The number of a primitive's vertices.
    pub fn vertex_count(&self, primitive: &Primitive) -> u64 {
        let positions = attribute(primitive, Semantic::Positions).and_then(|index| self.accessor(index));
        positions.map_or(0, |accessor| accessor.count.0)
    }

    /// A function that morphs an attribute of one vertex after the other.
    pub fn morph(
        &self,
        (mesh, number): (usize, usize),
        deformation: &Deformation,
        (name, delta): (&str, Delta),
    ) -> Result<impl FnMut(DVec3) -> DVec3 + use<'_>> {
        let primitive = self.primitive(mesh, number)?;
        let vertices = self.vertex_count(primitive);
        let mut all: Vec<(f64, Elements<'_, [f64; 3]>)> = Vec::new();
        let targets = primitive.targets.iter().flatten().zip(&deformation.weights).enumerate();
        for (target, (given, &weight)) in targets.filter(|(_, (_, weight))| **weight != 0.0) {
            let Some(index) = delta(given) else { continue };
            let wrong = |reason| in_primitive((mesh, number), &format!(".targets[{target}].{name}"), reason);
            let accessor = self.accessor(index);
            // All of its elements are zero.
            if accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none()) {
                continue;
            }
            let found = accessor.map_or(vertices, |accessor| accessor.count.0);
            if found != vertices {
                return Err(wrong(format!("expected an element for each of {vertices} vertices, found {found}")));
            }
            let elements = self.elements::<3>(index, Extent { zeros: vertices, ..ALL });
            all.push((weight, elements.map_err(wrong)?));
        }
        Ok(move |value| {
            all.iter_mut().fold(value, |value, (weight, elements)| {
                value + *weight * elements.next().map_or(DVec3::ZERO, DVec3::from_array)
            })
        })
    }
}

fn joint_of(joints: &[DAffine3], joint: f64) -> Option<&DAffine3> {
    // Accessors of JOINTS are whole numbers; those of a broken file may not be.
    (joint >= 0.0 && joint.fract() == 0.0).then(|| joints.get(joint as usize)).flatten()
}

/// The mean of joints by their weights. A vertex without weights follows its first joint.
fn blended(of_vertex: &Influences, joints: &[DAffine3]) -> DAffine3 {
    let sum: f64 = of_vertex.iter().map(|(_, weight)| weight).sum();
    if sum == 0.0 {
        let [(first, _), ..] = *of_vertex;
        return joint_of(joints, first).copied().unwrap_or(DAffine3::IDENTITY);
    }
    let zero = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
    of_vertex.iter().fold(zero, |blend, &(joint, weight)| {
        let joint = if weight > 0.0 { joint_of(joints, joint) } else { None };
        joint.map_or(blend, |joint| DAffine3 {
            matrix3: blend.matrix3 + joint.matrix3 * (weight / sum),
            translation: blend.translation + joint.translation * (weight / sum),
        })
    })
}
