//! What several tests share.

// Each test program compiles its own copy and uses a part of it.
#![allow(dead_code)]

/// Whether files that tests write are to be written anew, instead of compared: `GPU_RT_RENEW=1`.
pub fn renew() -> bool {
    std::env::var_os("GPU_RT_RENEW").is_some()
}

pub mod constants;
pub mod corpus;
pub mod cuboids;
pub mod device;
pub mod everything;
pub mod expect;
pub mod exr_header;
#[cfg(target_os = "linux")]
pub mod fault;
pub mod faults;
pub mod files;
pub mod film;
pub mod gltf;
pub mod held;
pub mod instances;
pub mod kernel;
#[cfg(target_os = "linux")]
pub mod kills;
pub mod lattice;
pub mod light_kernel;
pub mod marked;
pub mod meshes;
pub mod microfacets;
pub mod mutate;
pub mod oidn;
pub mod oracles;
pub mod paired;
pub mod program;
pub mod quads;
pub mod referee;
pub mod render;
pub mod rooms;
pub mod rows;
pub mod scenes;
#[cfg(target_os = "linux")]
pub mod screen;
pub mod stats;
pub mod sweeps;
pub mod tables;
pub mod trace;
pub mod triangles;
pub mod vdb;
pub mod vectors;
