//! Meshes of long thin faces, whose boxes `--build best` cuts: the same image.

use glam::DVec3;
use gpu_rt::bvh::Quality;
use gpu_rt::flatten::flatten;
use gpu_rt::scene::Scene;

use crate::common::instances::{Faces, obj_file};
use crate::common::render::{Request, render, scene_with};
use crate::common::stats::Random;

/// Closed spikes of four faces each, long along random directions, as an OBJ file.
fn spikes(count: usize) -> String {
    let mut random = Random(3);
    let mut vector = |size: f64| size * DVec3::from_array([(); 3].map(|()| 2.0 * random.uniform() - 1.0));
    let (mut corners, mut faces) = Faces::default();
    for spike in 0..count {
        let (at, along, u, v) = (vector(1.0), vector(0.8), vector(0.03), vector(0.03));
        // The faces run counter-clockwise seen from outside.
        let v = if along.dot(u.cross(v)) > 0.0 { v } else { -v };
        corners.extend([at - along, at - along + u, at - along + v, at + along]);
        faces.extend([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|face| face.map(|corner| 4 * spike + corner)));
    }
    obj_file(&(corners, faces))
}

fn scene_of(objects: &str) -> Scene {
    let text = format!(
        "Scene(image: (width: 48, height: 40), camera: (look_from: (0.5, 1, 4), look_at: (0, 0, 0), vertical_fov: 40),
            background: Gradient(bottom: (0.2, 0.2, 0.3), top: (1, 0.9, 0.8)),
            materials: {{ \"matt\": Lambertian(albedo: Rgb(0.8, 0.4, 0.2)), \"glass\": Dielectric(ior: 1.5),
                \"veil\": Lambertian(albedo: Rgb(0.2, 0.4, 0.8), alpha: 0.4) }},
            objects: [{objects}])"
    );
    scene_with(&[("spikes.obj", spikes(200))], &text)
}

/// The scene's image, and the number of its nodes, by the quality of its hierarchies.
fn built(scene: &Scene, quality: Quality) -> (Vec<u32>, usize) {
    let request = Request::spp(16).seed(5).mis().sobol().with(|options| options.build = quality);
    let flat = flatten(scene, (48, 40), &request.options).expect("the scene flattens");
    (render(scene, &request).bits(), flat.nodes.len())
}

#[test]
fn faces_in_several_leaves_change_no_bit() {
    let (empty, _) = built(&scene_of(""), Quality::Medium);
    for material in ["matt", "glass", "veil"] {
        let scene = scene_of(&format!("Mesh(path: \"spikes.obj\", material: \"{material}\")"));
        let (usual, nodes) = built(&scene, Quality::Medium);
        let (cut, more_nodes) = built(&scene, Quality::Best);
        assert!(more_nodes > 2 * nodes, "{material}: {nodes} and {more_nodes} nodes");
        assert!(usual == cut, "{material}");
        // Most of the image is not the sky.
        let changed = usual.iter().zip(&empty).filter(|(a, b)| a != b).count();
        assert!(changed > usual.len() / 2, "{material}: {changed} of {}", usual.len());
    }
}

/// A walk that looks for the ends of a medium counts faces. It would count twice what is in two leaves.
#[test]
fn the_boxes_of_what_bounds_a_medium_are_not_cut() {
    let medium = "Medium(boundary: Mesh(path: \"spikes.obj\"), density: 8, albedo: Rgb(0.9, 0.6, 0.3), anisotropy: 0),";
    let surface = "Mesh(path: \"spikes.obj\", material: \"glass\")";
    for objects in [medium.to_string(), format!("{medium} {surface}")] {
        let scene = scene_of(&objects);
        let (usual, nodes) = built(&scene, Quality::Medium);
        let (best, as_many) = built(&scene, Quality::Best);
        assert_eq!(nodes, as_many);
        assert!(usual == best, "{objects}");
    }
}
