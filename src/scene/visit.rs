//! A walk over all objects with their paths.

use super::types::Object;
use crate::source::ValuePath;

/// Calls the visitor with an object and all objects inside it, in the file's order. The path is that of the variant, as in
/// `objects[3].Group[0].Sphere`.
pub fn visit<'a>(at: &ValuePath, object: &'a Object, visitor: &mut dyn FnMut(&ValuePath, &'a Object)) {
    let at = &at.variant(object.name());
    visitor(at, object);
    match object {
        Object::Transformed { object, .. } | Object::Moving { object, .. } | Object::Named { object, .. } => {
            visit(&at.field("object"), object, visitor)
        }
        Object::Medium { boundary: Some(boundary), .. } => visit(&at.field("boundary"), boundary, visitor),
        Object::Group(objects) | Object::Gltf { objects, .. } => {
            objects.iter().enumerate().for_each(|(index, object)| visit(&at.index(index), object, visitor));
        }
        // A shape contains no other objects.
        _ => {}
    }
}
