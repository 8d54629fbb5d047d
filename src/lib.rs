//! gpu-rt: a path tracer with WGSL kernels. It runs through wgpu on Vulkan, Metal or DirectX 12, and on software Vulkan without a GPU.
//!
//! It is a program first: `gpu-rt render scene.ron`. As a library it renders a scene in memory:
//!
//! ```
//! use std::path::Path;
//!
//! use gpu_rt::{RenderSettings, Scene, render_scene};
//!
//! let text = r#"Scene(
//!     image: (width: 32, height: 18),
//!     camera: (look_from: (0, 1, 8), look_at: (0, 1, 0), vertical_fov: 30),
//!     background: Solid((0.5, 0.7, 1)),
//!     materials: { "lamp": DiffuseLight(emit: Rgb(4, 2, 1)) },
//!     objects: [ Sphere(center: (0, 1, 0), radius: 1, material: "lamp") ],
//! )"#;
//! // The path stands for the file that the text is from: relative paths in the scene start at its folder, and errors name it.
//! let scene = Scene::parse(text, Path::new("lamp.ron"))?;
//! let settings = RenderSettings { samples: Some(16), ..RenderSettings::default() };
//! # let names = gpu_rt::gpu::device::Adapters::find().names();
//! # let software = names.iter().position(|(name, _)| name.software).map(|index| index.to_string());
//! # let settings = RenderSettings { device: std::env::var("GPU_RT_TEST_DEVICE").ok().or(software), ..settings };
//! let picture = render_scene(&scene, &settings)?;
//!
//! // Linear radiance, row 0 on top. The middle of the image shows the lamp, its corner the background.
//! assert_eq!(picture.rgb.len(), 32 * 18);
//! assert_eq!(picture.rgb[9 * 32 + 16], [4.0, 2.0, 1.0]);
//! assert_eq!(picture.rgb[0], [0.5, 0.7, 1.0]);
//! # let folder = tempfile::tempdir().expect("a temporary folder");
//! # let path = folder.path().join("lamp.exr");
//! gpu_rt::write_exr(&path, &picture, &[])?;
//! # Ok::<(), gpu_rt::Error>(())
//! ```
//!
//! The scene file is described in docs/scene.md. The modules are not part of the interface: they are public for the program, the tests
//! and the benchmarks, and may change at any time.

#[doc(hidden)]
pub mod aov;
#[doc(hidden)]
pub mod bitmap;
#[doc(hidden)]
pub mod bvh;
#[doc(hidden)]
pub mod chromaticities;
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod cluster;
#[doc(hidden)]
pub mod commands;
#[doc(hidden)]
pub mod data;
mod delta_light;
#[doc(hidden)]
pub mod denoise;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod film;
#[doc(hidden)]
pub mod flatten;
#[doc(hidden)]
pub mod gpu;
mod guard;
#[doc(hidden)]
pub mod identity;
mod in_memory;
#[doc(hidden)]
pub mod job;
#[doc(hidden)]
pub mod light_distribution;
#[doc(hidden)]
pub mod lobe;
mod luminance;
pub mod material;
mod memory;
#[doc(hidden)]
pub mod metrics;
#[doc(hidden)]
pub mod options;
#[doc(hidden)]
pub mod output;
#[doc(hidden)]
pub mod page;
pub mod plan;
mod printable;
#[doc(hidden)]
pub mod render;
#[doc(hidden)]
pub mod samples;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod session;
mod shape;
#[doc(hidden)]
pub mod source;
mod terminal;
mod texture;
mod threads;
#[doc(hidden)]
pub mod tradeoff;
#[cfg_attr(not(test), expect(dead_code, reason = "the media that have grids come next"))]
mod volume;

pub use error::{Error, Location, Result};
pub use film::Picture;
pub use in_memory::{RenderSettings, render_scene};
pub use output::exr::{Attribute, write_exr};
pub use scene::Scene;
