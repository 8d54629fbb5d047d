//! Rays against one primitive, on the device: tests/shaders/trace.wgsl.

use bytemuck::Pod;
use glam::DVec3;
use gpu_rt::data::Node;
use gpu_rt::flatten::DeviceScene;

use super::kernel::{Fault, Kernel, Plant, Setup, array};
use super::rows::rows;
use super::stats::Random;
use super::vectors::rounded;

pub const NO_HIT: f32 = gpu_rt::data::NO_HIT;

rows! {
    /// A ray at a primitive by its index. `leaving` is the second ray's direction in a basis around the normal; zero to go on as the first does.
    pub struct In {
        origin: [f32; 3], primitive: u32,
        direction: [f32; 3], padding0: u32,
        leaving: [f32; 3], padding1: u32,
    }

    /// The hit, the second ray, and the distance of its hit on the same primitive.
    pub struct Out {
        point: [f32; 3], t: f32,
        normal: [f32; 3], error: f32,
        local: [f32; 3], again: f32,
        start: [f32; 3], u: f32,
        leaving: [f32; 3], v: f32,
    }
}

impl In {
    pub fn new(primitive: usize, origin: DVec3, direction: DVec3) -> In {
        In { origin: rounded(origin), primitive: primitive as u32, direction: rounded(direction), ..In::default() }
    }
}

/// The direction of a second ray at this cosine with the normal, in a basis around it: at any azimuth, on the given side.
pub fn leaving(random: &mut Random, cosine: f64, outwards: bool) -> [f32; 3] {
    let (sin, phi) = ((1.0 - cosine * cosine).sqrt(), random.uniform() * std::f64::consts::TAU);
    rounded(DVec3::new(sin * phi.cos(), sin * phi.sin(), if outwards { cosine } else { -cosine }))
}

/// The ray starts where the surface says the point is.
pub const WITHOUT_OFFSET: Plant =
    ("geometry/offset", "select(-normal, normal, dot(direction, normal) >= 0.0)", "0.0 * normal");

/// The discriminant as b^2 - a c, which cancels where the sphere is far away, and both roots as sums, so that the one near zero cancels.
pub const SPHERE_BY_THE_BOOK: [Plant; 2] = [
    (
        "geometry/sphere_chord",
        "(sphere.radius + l) * (sphere.radius - l) * inverse",
        "k * k - (dot(f, f) - sphere.radius * sphere.radius) * inverse",
    ),
    (
        "geometry/sphere_chord",
        "vec2<f32>(min(far_from_zero, near_to_zero), max(far_from_zero, near_to_zero))",
        "vec2<f32>(foot.k - h, foot.k + h)",
    ),
];

/// The kernel for a kind of primitive, with some production modules changed.
pub fn tracer(primitive: &str, replaced: &[Fault<'_>]) -> Kernel {
    kernel(primitive, &Setup { replaced, ..Setup::default() })
}

/// The kernel with a planted error.
pub fn planted_tracer(primitive: &str, plant: Plant) -> Kernel {
    kernel(primitive, &Setup { plants: &[plant], ..Setup::default() }).planted(0)
}

fn kernel(primitive: &str, setup: &Setup<'_>) -> Kernel {
    let kind = match primitive {
        "sphere" => "Sphere",
        "large_sphere" => "LargeSphere",
        "quad" | "disk" => "Quad",
        _ => "Cuboid",
    };
    let values = [("primitive", primitive), ("type", kind)];
    let Setup { replaced, plants, .. } = *setup;
    Kernel::with("test/trace", &Setup { replaced, plants, values: &values, ..Setup::default() })
}

/// Traces rays against primitives.
pub fn trace<P: Pod>(kernel: &Kernel, primitives: &[P], rays: &[In]) -> Vec<Out> {
    kernel.run_with(rays, rays.len(), &[array("primitives", primitives)])
}

rows! {
    /// A ray through the hierarchy: tests/shaders/walk.wgsl.
    pub struct ThroughTree {
        origin: [f32; 3], root: u32,
        direction: [f32; 3], padding: u32,
    }
}

/// The hits, as code, t as bits, and steps, that the walk finds and that asking every primitive of a scene finds.
pub fn walk(kernel: &Kernel, scene: &DeviceScene, nodes: &[Node], rays: &[ThroughTree]) -> Vec<[[u32; 4]; 2]> {
    let tables = [
        array("nodes", nodes),
        array("spheres", &scene.shapes.spheres),
        array("quads", &scene.shapes.quads),
        array("cuboids", &scene.shapes.cuboids),
    ];
    kernel.run_with(rays, rays.len(), &tables)
}
