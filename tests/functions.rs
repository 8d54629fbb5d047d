//! The shader functions, on the device, against oracles in f64: thousands of inputs over many decades, each comparison
//! with a planted wrong form that must fail it.
//!
//! u = 2^-24 is the relative error of one correctly rounded operation in f32. Inputs are made in f64, rounded to f32, and
//! the oracle starts from the rounded ones, so that a difference is the function's own error.

#[path = "common/device.rs"]
mod device;
#[path = "common/kernel.rs"]
mod kernel;
#[path = "common/light_kernel.rs"]
mod light_kernel;
#[path = "common/oracles.rs"]
mod oracles;
#[path = "common/stats.rs"]
mod stats;

#[path = "common/vectors.rs"]
mod vectors;

#[path = "common/trace.rs"]
mod trace;

#[path = "common/scenes.rs"]
mod scenes;

#[path = "common/cuboids.rs"]
mod cuboids;
#[path = "common/instances.rs"]
mod instances;
#[path = "common/quads.rs"]
mod quads;
#[path = "common/triangles.rs"]
mod triangles;

#[path = "functions/angle.rs"]
mod angle;
#[path = "functions/bounds.rs"]
mod bounds;
#[path = "functions/camera.rs"]
mod camera;
#[path = "functions/cuboid.rs"]
mod cuboid;
#[path = "functions/float.rs"]
mod float;
#[path = "functions/frames.rs"]
mod frames;
#[path = "functions/light_tree.rs"]
mod light_tree;
#[path = "functions/lights.rs"]
mod lights;
#[path = "functions/materials.rs"]
mod materials;
#[path = "functions/medium.rs"]
mod medium;
#[path = "functions/meshes.rs"]
mod meshes;
#[path = "functions/perlin.rs"]
mod perlin;
#[path = "functions/quad.rs"]
mod quad;
#[path = "functions/rng.rs"]
mod rng;
#[path = "functions/sampler.rs"]
mod sampler;
#[path = "functions/sampling.rs"]
mod sampling;
#[path = "functions/textures.rs"]
mod textures;
#[path = "functions/triangle.rs"]
mod triangle;
#[path = "functions/walk.rs"]
mod walk;
