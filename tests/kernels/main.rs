//! The shader functions, on the device, against oracles in f64: thousands of inputs over many decades, each comparison
//! with a planted wrong form that must fail it.
//!
//! u = 2^-24 is the relative error of one correctly rounded operation in f32. Inputs are made in f64, rounded to f32, and
//! the oracle starts from the rounded ones, so that a difference is the function's own error.

#[path = "../common/mod.rs"]
mod common;

mod aims;
mod angle;
mod anisotropy;
mod backends;
mod bounds;
mod bsdf;
mod camera;
mod cuboid;
mod delta_lights;
mod disk;
mod film;
mod filter;
mod float;
mod frames;
mod large_sphere;
mod layout;
mod light_tree;
mod lights;
mod lobes;
mod materials;
mod medium;
mod meshes;
mod pbr;
mod pbr_lobes;
mod perlin;
mod probe;
mod quad;
mod rng;
mod rough;
mod same_kernels;
mod sampler;
mod sampling;
mod shaders_link;
mod textures;
mod thin_film;
mod triangle;
mod walk;
