//! Rows that test kernels take and give, where several tests run them.

use bytemuck::{Pod, Zeroable};
use gpu_rt::data::Material;

/// The input of tests/shaders/scatter.wgsl: a ray that hits a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct SurfaceHit {
    pub incoming: [f32; 3],
    pub front: u32,
    pub normal: [f32; 3],
    pub padding0: u32,
    pub colour: [f32; 3],
    pub padding1: u32,
    pub u: [f32; 4],
    pub material: Material,
}

/// Its output.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Answer {
    pub direction: [f32; 3],
    pub event: u32,
    pub weight: [f32; 3],
    pub padding: u32,
}

/// Glass with the host's constants, rounded from f64.
pub fn glass(ior: f64) -> Material {
    let inside = 1.0 / ior;
    Material {
        numbers: [ior as f32, ((ior - 1.0) * (ior + 1.0)) as f32, ((inside - 1.0) * (inside + 1.0)) as f32],
        ..Material::default()
    }
}

/// What tests/shaders/sampling.wgsl gives.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Maps {
    pub disk: [f32; 2],
    pub circle: [f32; 2],
    pub hemisphere: [f32; 3],
    pub root: f32,
    pub sphere: [f32; 3],
    pub padding0: u32,
    pub ball: [f32; 3],
    pub padding1: u32,
}

/// What tests/shaders/rng.wgsl gives.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Words {
    pub bits: [u32; 4],
    pub u: [f32; 4],
    pub direct: [f32; 4],
}

/// What tests/shaders/colour.wgsl takes: a ray, and what it meets.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Aimed {
    pub origin: [f32; 3],
    pub code: u32,
    pub direction: [f32; 3],
    pub padding: u32,
}

/// The input of tests/shaders/camera.wgsl: a pixel, and the points in it and on the lens.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct OnFilm {
    pub column: u32,
    pub row: u32,
    pub padding: [u32; 2],
    pub u: [f32; 4],
}

/// Its output.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct CameraRay {
    pub origin: [f32; 3],
    pub padding0: u32,
    pub direction: [f32; 3],
    pub padding1: u32,
}

/// What `test/filter` gives: a point of a pixel, and its weight.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct FilterPoint {
    pub point: [f32; 2],
    pub weight: f32,
    pub padding: u32,
}
