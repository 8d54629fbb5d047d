//! Reads scenes.
//!
//! `model` is the scene: the checked contents of a scene file, with the location of every value in the file. `load` reads the file, `explain` translates ron's errors into the terms of the scene format, `validate` refuses invalid
//! numbers, `bitmap` decodes the images, `mesh` reads the meshes. Every error names file:line:column and the field. `recover` reads on
//! behind an error, so that all are listed.

mod animation_frame;
mod assets;
mod change;
mod declared;
mod draft;
mod explain;
mod file;
mod findings;
pub mod format;
mod gltf;
mod gltf_options;
mod gltf_path;
#[cfg_attr(not(test), expect(dead_code, reason = "the media that have grids come next"))]
mod grid_files;
mod image_files;
mod imported;
mod inputs;
pub mod light_groups;
mod load;
mod mesh_files;
mod mitsuba;
mod model;
mod nearest;
mod pbrt;
mod projection;
mod recover;
mod sky;
mod syntax;
pub mod types;
mod validate;
mod visit;
mod warn;
mod write;

pub use crate::shape::mesh::{Mesh, OpenEdges};
pub use crate::source::{Step, ValuePath};
pub use animation_frame::{AnimationFrame, FPS};
pub use assets::{Assets, Stamp, stamp};
pub use change::{Change, Rows};
pub use file::OnProgress;
pub use gltf_options::{GltfOptions, Sky};
pub use gltf_path::is_gltf;
pub use imported::{write_exr, write_ply};
pub use inputs::Input;
pub use mitsuba::is_mitsuba;
pub use model::Scene;
pub use pbrt::is_pbrt;
pub use types::*;
