//! What the host does, without a device: films and statistics, files that are read, plans; and what documents and sources say.

#[path = "../common/mod.rs"]
mod common;

mod architecture;
mod bad_input;
mod compare;
mod docs;
mod drivers;
mod film;
mod gltf;
mod gltf_animation;
mod gltf_extensions;
mod gltf_glass;
mod gltf_packed;
mod image_files;
mod mesh_files;
mod mesh_scenes;
mod mitsuba;
mod named_files;
mod page;
mod pbrt;
mod pbrt_textures;
mod plan;
mod scene_file;
mod statistics;
mod web_page;
