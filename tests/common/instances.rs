//! Rays against instances of a ball of triangles, on the device: tests/shaders/meshes.wgsl.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::{Integrator, RenderOptions};
use gpu_rt::scene::Scene;

use super::kernel::{Fault, Kernel, Setup, array, plan_of};
use super::rows::rows;
use super::scenes::triple;

rows! {
    pub struct In {
        origin: [f32; 3], root: u32,
        direction: [f32; 3], request: u32,
        leaving: [f32; 3], padding: u32,
    }

    /// Hits by code, instance, t as bits, and steps.
    pub struct Out {
        walked: [u32; 4],
        brute_force: [u32; 4],
        point: [f32; 3], again: f32,
        normal: [f32; 3], again_code: u32,
        start: [f32; 3], again_instance: u32,
    }
}

pub const NOTHING: u32 = u32::MAX;

/// Corners, and faces by their numbers.
pub type Faces = (Vec<DVec3>, Vec<[usize; 3]>);

/// Each face cut into four at the middles of its edges, which are moved.
pub fn cut((mut corners, faces): Faces, moved: impl Fn(DVec3) -> DVec3) -> Faces {
    let mut middles = HashMap::new();
    let mut middle = |a: usize, b: usize| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            corners.push(moved(0.5 * (corners[a] + corners[b])));
            corners.len() - 1
        })
    };
    let in_four = |&[a, b, c]: &[usize; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let faces = faces.iter().flat_map(in_four).collect();
    (corners, faces)
}

/// An octahedron, cut so many times; on the unit sphere.
pub fn ball(cuts: u32) -> Faces {
    let corners = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let faces = vec![[4, 0, 2], [0, 5, 2], [5, 1, 2], [1, 4, 2], [0, 4, 3], [5, 0, 3], [1, 5, 3], [4, 1, 3]];
    (0..cuts).fold((corners, faces), |faces, _| cut(faces, DVec3::normalize))
}

/// The ball as an OBJ file, stretched along its axes.
pub fn ball_file(cuts: u32, stretch: DVec3) -> String {
    let (corners, faces) = ball(cuts);
    obj_file(&(corners.into_iter().map(|p| stretch * p).collect(), faces))
}

/// Faces as an OBJ file.
pub fn obj_file((corners, faces): &Faces) -> String {
    let mut text = String::new();
    for p in corners {
        writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).expect("a string takes text");
    }
    for [a, b, c] in faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string takes text");
    }
    text
}

/// The ball as an OBJ file whose vertices are their own normals.
pub fn smooth_ball_file(cuts: u32) -> String {
    let (corners, faces) = ball(cuts);
    let vertices = corners.iter().map(|p| format!("v {0:?} {1:?} {2:?}\nvn {0:?} {1:?} {2:?}\n", p.x, p.y, p.z));
    let faces = faces.iter().map(|face| {
        let [a, b, c] = face.map(|corner| corner + 1);
        format!("f {a}//{a} {b}//{b} {c}//{c}\n")
    });
    vertices.chain(faces).collect()
}

/// Objects of the material "m" around a camera at `eye`, with "ball.obj" beside the scene.
pub fn flat_around(eye: DVec3, mesh: &str, objects: &[String]) -> DeviceScene {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ball.obj"), mesh).expect("the mesh is written");
    let at = eye + DVec3::X * eye.abs().max_element().max(1.0);
    let text = format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: {}, look_at: {}, vertical_fov: 40),\n\
         background: Solid((1, 1, 1)), materials: {{\"m\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}}, objects: [{}])",
        triple(eye),
        triple(at),
        objects.join(",\n")
    );
    let scene = Scene::parse(&text, &folder.path().join("test.ron")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.location(&[]).file, folder.path().join(Path::new("test.ron")));
    flatten(&scene, (16, 16), &RenderOptions { integrator: Integrator::Bsdf, ..RenderOptions::default() })
        .expect("the test's scene is small")
}

pub fn kernel(flat: &DeviceScene, faces: usize, replaced: &[Fault<'_>]) -> Kernel {
    let plan = plan_of(&flat.features);
    let (instances, faces) = (flat.shapes.instances.len().to_string(), faces.to_string());
    let values = [("instances", &*instances), ("faces", &*faces)];
    Kernel::with("test/meshes", &Setup { plan, values: &values, replaced, ..Setup::default() })
}

pub fn run(kernel: &Kernel, flat: &DeviceScene, rays: &[In]) -> Vec<Out> {
    let tables = [
        array("nodes", &flat.nodes),
        array("spheres", &flat.shapes.spheres),
        array("instances", &flat.shapes.instances),
        array("meshes", &flat.meshes),
        array("face_pairs", &flat.face_pairs),
    ];
    kernel.run_with(rays, rays.len(), &tables)
}
