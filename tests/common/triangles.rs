//! Rays against triangles, on the device: tests/shaders/triangle.wgsl.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::kernel::{Fault, Kernel, array};
use super::rows::rows;
use super::stats::Random;
use super::vectors::{exact, rounded, unit};

rows! {
    pub struct In {
        origin: [f32; 3], first: u32,
        direction: [f32; 3], count: u32,
        leaving: [f32; 3], padding: u32,
    }

    pub struct Out {
        back: u32, front: u32, nearest: u32, t: f32,
        barycentric: [f32; 3], again: f32,
        error: f32, padding: [f32; 3],
    }
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

pub fn tracer(replaced: &[Fault<'_>]) -> Kernel {
    Kernel::replacing("test/triangle", replaced)
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
