//! What is wrong with a glTF file.

/// What is wrong with a file, and where in its JSON: `materials[2].pbrMetallicRoughness.baseColorTexture.index`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}{}{reason}", if at.is_empty() { "" } else { ": " })]
pub struct GltfError {
    /// Empty if all of the file is wrong.
    pub at: String,
    pub reason: String,
}

pub type Result<T> = std::result::Result<T, GltfError>;

impl GltfError {
    pub fn new(at: impl Into<String>, reason: impl Into<String>) -> GltfError {
        GltfError { at: at.into(), reason: reason.into() }
    }
}

/// What is wrong with a part of a primitive.
pub fn in_primitive((mesh, number): (usize, usize), part: &str, reason: impl Into<String>) -> GltfError {
    GltfError::new(format!("meshes[{mesh}].primitives[{number}]{part}"), reason)
}

impl From<String> for GltfError {
    fn from(reason: String) -> GltfError {
        GltfError { at: String::new(), reason }
    }
}
