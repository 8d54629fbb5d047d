//! Meshes that are placed many times: stored once, and the same image as if they had been copied.

use std::f64::consts::TAU;

use crate::common::instances::{Faces, obj_file};
use crate::common::render::{Request, render, same_expectation, scene_with};
use glam::{DMat3, DVec3};
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::buffers::{BufferSpec, too_large};
use gpu_rt::options::Scatter;
use gpu_rt::plan::{Kernels, Plan, Tuning, UniformTables};
use gpu_rt::scene::Scene;

/// A torus of radii 1 and 0.4 about the y axis, as corners and faces.
fn torus(around: usize, across: usize) -> Faces {
    let corner = |i: usize, j: usize| {
        let (u, v) = (TAU * i as f64 / around as f64, TAU * j as f64 / across as f64);
        let r = 1.0 + 0.4 * v.cos();
        DVec3::new(r * u.cos(), 0.4 * v.sin(), -r * u.sin())
    };
    let corners = (0..around).flat_map(|i| (0..across).map(move |j| corner(i, j))).collect();
    let at = |i: usize, j: usize| i % around * across + j % across;
    let faces = (0..around).flat_map(|i| {
        (0..across).flat_map(move |j| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
    });
    (corners, faces.collect())
}

/// Meshes in one OBJ file, each moved by a map of its own.
fn obj(mesh: &Faces, maps: &[&dyn Fn(DVec3) -> DVec3]) -> String {
    let corners = maps.iter().flat_map(|map| mesh.0.iter().map(|p| map(*p))).collect();
    let firsts = (0..maps.len()).map(|copy| copy * mesh.0.len());
    let faces = firsts.flat_map(|first| mesh.1.iter().map(move |face| face.map(|corner| first + corner))).collect();
    obj_file(&(corners, faces))
}

/// Objects on a checkered floor, with files beside the scene.
fn scene_of(files: &[(&str, String)], objects: &str) -> Scene {
    let text = format!(
        "Scene(image: (width: 48, height: 32), camera: (look_from: (0.5, 4, 7), look_at: (0, 0.5, 0), vertical_fov: 40),
            background: Gradient(bottom: (0.2, 0.2, 0.3), top: (1, 0.9, 0.8)),
            materials: {{ \"body\": Lambertian(albedo: Rgb(0.8, 0.4, 0.2)),
                \"floor\": Lambertian(albedo: Checker(scale: 1, even: (0.2, 0.2, 0.2), odd: (0.9, 0.9, 0.9))) }},
            objects: [Quad(corner: (-9, -0.6, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"floor\"), {objects}])"
    );
    scene_with(files, &text)
}

#[test]
fn a_mesh_of_copies_and_instances_of_one_look_the_same() {
    let mesh = torus(24, 12);
    let turn = |axis: DVec3, degrees: f64| DMat3::from_axis_angle(axis, degrees.to_radians());
    let (tilted, upright) = (turn(DVec3::X, 35.0), turn(DVec3::Z, 90.0));
    let maps: [&dyn Fn(DVec3) -> DVec3; 3] = [&|p| p, &|p| tilted * (0.7 * p) + DVec3::new(-2.2, 0.5, 0.3), &|p| {
        upright * (1.3 * p) + DVec3::new(2.0, 1.2, -1.0)
    }];
    let copies = scene_of(&[("copies.obj", obj(&mesh, &maps))], "Mesh(path: \"copies.obj\", material: \"body\")");
    let instances = |x: f64| {
        scene_of(
            &[("one.obj", obj(&mesh, &maps[..1]))],
            &format!(
                "Mesh(path: \"one.obj\", material: \"body\"),
                 Transformed(by: [Scale(0.7), RotateX(35), Translate(({x}, 0.5, 0.3))], object: Mesh(path: \"one.obj\", material: \"body\")),
                 Transformed(by: [Translate((2, 1.2, -1))], object: Group([
                     Transformed(by: [RotateZ(90), Scale(1.3)], object: Mesh(path: \"one.obj\", material: \"body\"))])),"
            ),
        )
    };
    let copies = render(&copies, &Request::spp(256).seed(1));
    // Two seeds and two tests: the same noise would hide in the same numbers.
    let same = render(&instances(-2.2), &Request::spp(256).seed(2));
    same_expectation(&copies, &same, 1e-6, 1e-6).expect("copies and instances look the same");
    let moved = render(&instances(-1.8), &Request::spp(256).seed(2));
    assert!(same_expectation(&copies, &moved, 1e-6, 1e-6).is_err(), "an instance is moved by 0.4, some three pixels");
}

/// Device bytes of a scene, and of its meshes and hierarchy.
fn bytes(scene: &Scene) -> (u64, u64) {
    let flat = flatten(scene, (48, 32), &crate::common::render::plain()).expect("the scene flattens");
    let kernels =
        Kernels::link(&flat.features, &crate::common::render::plain(), Scatter::Linked, &UniformTables::default())
            .expect("the kernels link");
    let tuning = Tuning {
        slots: 1024,
        workgroup: 64,
        scatter: Scatter::Linked,
        bounces: None,
        records_per_slot: 2,
        tile: 1,
        is_short: false,
    };
    let plan = Plan { scene: &flat, options: crate::common::render::plain(), kernels, tuning };
    let buffers = plan.buffers();
    let of =
        |names: &[&str]| buffers.iter().filter(|b| names.contains(&b.name)).map(BufferSpec::allocated).sum::<u64>();
    (buffers.iter().map(BufferSpec::allocated).sum(), of(&["meshes", "nodes"]))
}

#[test]
fn ten_thousand_instances_take_the_memory_of_one() {
    let mesh = torus(350, 100);
    assert_eq!(mesh.1.len(), 70_000);
    let file = || [("one.obj", obj(&mesh, &[&|p| p]))];
    let placed = |i: usize| {
        let (x, z, degrees) = (i % 100, i / 100, i * 37 % 360);
        format!(
            "Transformed(by: [Scale(0.02), RotateX({degrees}), Translate(({x}, 0, {z}))], object: Mesh(path: \"one.obj\", \
             material: \"body\")),"
        )
    };
    let many: String = (0..10_000).map(placed).collect();
    let (one_all, one_mesh) = bytes(&scene_of(&file(), &placed(0)));
    let (many_all, _) = bytes(&scene_of(&file(), &many));
    // A mesh takes 80 bytes a triangle at most, its hierarchy included: 16 for the face, 8 for its share of the vertices, and nodes.
    assert!(one_mesh <= 80 * 70_000, "{one_mesh} bytes");
    assert!(one_mesh > 24 * 70_000, "{one_mesh} bytes do not hold the mesh");
    // An instance is 64 bytes and its share of a node of 64 bytes with two children at least.
    let each = (many_all - one_all) / 9_999;
    assert!(each <= 64 + 64, "{each} bytes an instance");
}

#[test]
fn buffers_that_do_not_fit_are_reported_in_bytes() {
    let limits = wgpu::Limits::default();
    assert_eq!(limits.max_storage_buffer_binding_size, 128 << 20);
    let fits = BufferSpec::working("fits", 128 << 20, "a test");
    let large = BufferSpec::working("large", (128 << 20) + 4, "a test");
    let uniform = BufferSpec::uniform("uniform", 1 << 20, "a test");
    let said = too_large(&[fits, large, uniform], &limits);
    assert_eq!(said.len(), 2, "{said:?}");
    for (said, words) in said.iter().zip([["`large`", "134217732", "134217728"], ["`uniform`", "1048576", "65536"]]) {
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
}
