//! Primitives as the host makes them for the device, from a scene's text.

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::{Integrator, RenderOptions};
use gpu_rt::scene::Scene;

/// One Lambertian sphere before a gradient: nothing more than that is required.
pub const SPHERE: &str = "Scene(
    image: (width: 20, height: 12),
    camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), up: (0, 1, 0), vertical_fov: 50),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)),
    materials: { \"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3)) },
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")],
    render: (samples: 16, max_depth: 7),
)
";

/// `(x, y, z)`, to the last bit.
pub fn triple(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

/// Flattens a scene with these objects, of the material "m", seen from the origin. The result is in render space: scaled
/// by a power of two.
pub fn flat(objects: &[String]) -> DeviceScene {
    flat_with("(look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40)", (16, 16), objects)
}

/// Flattens a scene with these objects and this camera, for an image of this size.
pub fn flat_with(camera: &str, size: (u32, u32), objects: &[String]) -> DeviceScene {
    let mut text = format!(
        "Scene(image: (width: {}, height: {}), camera: {camera}, background: Solid((1, 1, 1)),\n\
         materials: {{\"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}}, objects: [\n",
        size.0, size.1
    );
    for object in objects {
        writeln!(text, "{object},").expect("a string takes text");
    }
    text.push_str("])");
    let scene = Scene::parse(&text, Path::new("test.ron")).expect("the test's scene is valid");
    flatten(&scene, size, &RenderOptions { integrator: Integrator::Bsdf, ..RenderOptions::default() })
        .expect("the test's scene is small")
}
