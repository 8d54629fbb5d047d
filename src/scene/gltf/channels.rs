//! The animations of a glTF file, as its JSON has them. The crate's structs refuse all of an animation whose target is not a node.

use serde::Deserialize;

use super::error::{GltfError, Result};

/// An animation: channels that each move one property of a node.
#[derive(Debug, Deserialize)]
pub struct Animation {
    pub name: Option<String>,
    #[serde(default)]
    pub channels: Vec<Channel>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
}

#[derive(Debug, Deserialize)]
pub struct Channel {
    pub sampler: usize,
    pub target: Target,
}

#[derive(Debug, Deserialize)]
pub struct Target {
    /// A channel without a node is ignored, as glTF says, unless an extension says otherwise.
    pub node: Option<usize>,
    pub path: Property,
}

/// The property of a node that a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
    /// Any, by KHR_animation_pointer.
    Pointer,
    #[serde(other)]
    Other,
}

/// Keys: their times, and the values at these.
#[derive(Debug, Deserialize)]
pub struct Sampler {
    /// The accessor of the times, in seconds.
    pub input: usize,
    #[serde(default)]
    pub interpolation: Interpolation,
    /// The accessor of the values.
    pub output: usize,
}

/// What a value is between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Interpolation {
    #[serde(rename = "STEP")]
    Step,
    #[default]
    #[serde(rename = "LINEAR")]
    Linear,
    #[serde(rename = "CUBICSPLINE")]
    CubicSpline,
}

/// The animations in a file's JSON.
pub fn animations(json: &[u8]) -> Result<Vec<Animation>> {
    /// The rest takes no memory.
    #[derive(Deserialize)]
    struct Root {
        #[serde(default)]
        animations: Vec<Animation>,
    }
    let root: Root =
        serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(json)).map_err(|error| {
            GltfError::new(error.path().to_string(), format!("expected an animation: {}", error.inner()))
        })?;
    Ok(root.animations)
}
