//! gpu-rt: a path tracer with WGSL kernels. It runs on any GPU that wgpu supports, and on software Vulkan.

pub mod bvh;
pub mod cli;
pub mod commands;
pub mod data;
pub mod error;
pub mod film;
pub mod flatten;
pub mod gpu;
mod guard;
pub mod identity;
pub mod job;
pub mod lights;
pub mod material;
pub mod memory;
pub mod metrics;
pub mod options;
pub mod output;
pub mod plan;
pub mod printable;
pub mod render;
pub mod samples;
pub mod scene;
pub mod shape;
pub mod source;
pub mod texture;
pub mod threads;
pub mod tradeoff;
