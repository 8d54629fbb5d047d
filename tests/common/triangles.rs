//! Rays against triangles, on the device: tests/shaders/triangle.wgsl.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::kernel::{Kernel, Setup, array};
use super::stats::Random;
use super::vectors::{exact, rounded, unit};

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct In {
    pub origin: [f32; 3],
    pub first: u32,
    pub direction: [f32; 3],
    pub count: u32,
    pub leaving: [f32; 3],
    pub padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Out {
    pub back: u32,
    pub front: u32,
    pub nearest: u32,
    pub t: f32,
    pub barycentric: [f32; 3],
    pub again: f32,
    pub error: f32,
    pub padding: [f32; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Corners(pub [[f32; 4]; 3]);

impl Corners {
    pub fn new(corners: [DVec3; 3]) -> Corners {
        Corners(corners.map(|p| {
            let [x, y, z] = rounded(p);
            [x, y, z, 0.0]
        }))
    }

    pub fn exact(&self) -> [DVec3; 3] {
        self.0.map(|[x, y, z, _]| exact([x, y, z]))
    }
}

pub fn tracer(replaced: &[(&str, &str)]) -> Kernel {
    Kernel::with("test/triangle", &Setup { replaced, ..Setup::default() })
}

pub fn trace(kernel: &Kernel, triangles: &[Corners], rays: &[In]) -> Vec<Out> {
    kernel.run_with(rays, rays.len(), &[array("triangles", triangles)])
}

/// A triangle with no angle below some 20 degrees and a longest edge near `size`.
pub fn stout(random: &mut Random, size: f64) -> [DVec3; 3] {
    let (x, axis) = (unit(random), unit(random));
    let y = x.cross(axis).normalize();
    [0.0, 1.0, 2.0].map(|i: f64| {
        let angle = (i + 0.3 * random.uniform()) * std::f64::consts::TAU / 3.0;
        0.55 * size * (0.8 + 0.4 * random.uniform()) * (angle.cos() * x + angle.sin() * y)
    })
}
