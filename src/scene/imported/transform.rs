//! Transforms as ours.

use glam::{DAffine3, DMat3, DVec3};

use crate::scene::gltf;
use crate::scene::types::{Object, Transform};

/// The transform from a camera to the world: x is the viewer's left, y up and z forward.
pub fn look_at(from: DVec3, to: DVec3, up: DVec3) -> std::result::Result<DAffine3, &'static str> {
    let forward = (to - from).try_normalize().ok_or("expected a target that is not the origin")?;
    let left = up.cross(forward).try_normalize().ok_or("expected an up that is not parallel to the view")?;
    Ok(DAffine3 { matrix3: DMat3::from_cols(left, forward.cross(left), forward), translation: from })
}

/// An object that is moved; nothing if the transform mirrors or scales unevenly.
pub fn moved(by: &DAffine3, object: Object) -> Option<Object> {
    let by = gltf::similarity(by)?;
    Some(if by.is_empty() { object } else { Object::Transformed { by, object: Box::new(object) } })
}

/// The rotations of a transform of a sky, which a shift does not move; nothing if it mirrors or scales.
pub fn turns(by: &DAffine3) -> Option<Vec<Transform>> {
    let found = gltf::similarity(&DAffine3::from_mat3(by.matrix3))?;
    let is_turn = (by.matrix3.determinant() - 1.0).abs() < 1e-6;
    is_turn.then(|| found.into_iter().filter(|turn| matches!(turn, Transform::Rotate { .. })).collect())
}
