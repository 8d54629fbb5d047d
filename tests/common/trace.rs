//! Rays against one primitive, on the device: tests/shaders/trace.wgsl.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::kernel::{Kernel, Setup, array};
use super::stats::Random;
use super::vectors::rounded;

pub const NO_HIT: f32 = gpu_rt::data::NO_HIT;

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct In {
    pub origin: [f32; 3],
    /// Index of the primitive.
    pub primitive: u32,
    pub direction: [f32; 3],
    pub padding0: u32,
    /// The second ray's direction in a basis around the normal; zero to go on as the first ray does.
    pub leaving: [f32; 3],
    pub padding1: u32,
}

impl In {
    pub fn new(primitive: usize, origin: DVec3, direction: DVec3) -> In {
        In { origin: rounded(origin), primitive: primitive as u32, direction: rounded(direction), ..In::default() }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Out {
    pub point: [f32; 3],
    pub t: f32,
    pub normal: [f32; 3],
    pub error: f32,
    pub local: [f32; 3],
    /// Distance of the second ray's hit on the same primitive.
    pub again: f32,
    /// The second ray.
    pub start: [f32; 3],
    pub u: f32,
    pub leaving: [f32; 3],
    pub v: f32,
}

/// The direction of a second ray at this cosine with the normal, in a basis around it: at any azimuth, on the given side.
pub fn leaving(random: &mut Random, cosine: f64, outwards: bool) -> [f32; 3] {
    let (sin, phi) = ((1.0 - cosine * cosine).sqrt(), random.uniform() * std::f64::consts::TAU);
    rounded(DVec3::new(sin * phi.cos(), sin * phi.sin(), if outwards { cosine } else { -cosine }))
}

/// The kernel for a kind of primitive, with some production modules replaced.
pub fn tracer(primitive: &str, replaced: &[(&str, &str)]) -> Kernel {
    let module = format!("geometry/{primitive}");
    tracer_with_surface(primitive, &format!("{primitive}_surface"), &module, replaced)
}

/// The kernel with another function for the hit record.
pub fn tracer_with_surface(primitive: &str, surface: &str, surface_module: &str, replaced: &[(&str, &str)]) -> Kernel {
    let kind = match primitive {
        "sphere" => "Sphere",
        "large_sphere" => "LargeSphere",
        "quad" | "disk" => "Quad",
        _ => "Cuboid",
    };
    let values = [("primitive", primitive), ("type", kind), ("surface", surface), ("surface_module", surface_module)];
    Kernel::with("test/trace", &Setup { replaced, values: &values, ..Setup::default() })
}

/// Traces rays against primitives.
pub fn trace<P: Pod>(kernel: &Kernel, primitives: &[P], rays: &[In]) -> Vec<Out> {
    kernel.run_with(rays, rays.len(), &[array("primitives", primitives)])
}
