//! Normal maps: the normal on each kind of shape, and light that stays on its side.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use exr::prelude::write_rgb_file;
use glam::{DMat3, DVec3};
use gpu_rt::scene::Scene;
use serde_json::json;

use crate::common::gltf::{glb, square};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, scene_in};

/// The mapped normal in the frame of the texture, of length 1.
const MAPPED: DVec3 = DVec3::new(0.36, 0.48, 0.8);

/// A normal map that has one normal everywhere, and the vertices of a square whose texture coordinates are mirrored.
pub fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let code = (0.5 * (MAPPED + 1.0)).as_vec3();
    write_rgb_file(folder.path().join("tilted.exr"), 3, 2, |_, _| (code.x, code.y, code.z)).expect("it is written");
    let half = (0.5 * (MAPPED * DVec3::new(0.5, 0.5, 1.0) + 1.0)).as_vec3();
    write_rgb_file(folder.path().join("half.exr"), 3, 2, |_, _| (half.x, half.y, half.z)).expect("it is written");
    let bumps = |at: usize, of: usize| 0.5 + 0.4 * ((7 * at * at + of) as f32).sin();
    write_rgb_file(folder.path().join("bumps.exr"), 8, 8, |x, y| (bumps(x, y), bumps(y, x + 3), 0.9))
        .expect("it is written");
    let square = |uvs: &str, normals: &str| {
        format!("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n{uvs}{normals}f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
    };
    let mirrored = "vt 3 0\nvt 0 0\nvt 0 3\nvt 3 3\n";
    std::fs::write(folder.path().join("mirrored.obj"), square(mirrored, "")).expect("it is written");
    // Turned by a right angle: u grows along y, v along -x.
    let turned = "vt 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n";
    std::fs::write(folder.path().join("turned.obj"), square(turned, "")).expect("it is written");
    // Smooth meshes, which have tangents at their vertices.
    let normals = "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n";
    for (name, uvs) in [("smooth-mirrored.obj", mirrored), ("smooth-turned.obj", turned)] {
        let text = square(uvs, normals).replace("1/1", "1/1/1").replace("2/2", "2/2/2");
        let text = text.replace("3/3", "3/3/3").replace("4/4", "4/4/4");
        std::fs::write(folder.path().join(name), text).expect("it is written");
    }
    std::fs::write(folder.path().join("ball.obj"), ball()).expect("it is written");
    folder
}

/// A smooth ball of 8 by 16 faces, with texture coordinates.
fn ball() -> String {
    let (rows, columns) = (8, 16);
    let mut text = String::new();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
        let ((sin, cos), (east, north)) = ((PI * v).sin_cos(), (TAU * u).sin_cos());
        let [x, y, z] = [sin * north, -cos, -sin * east];
        text += &format!("v {x} {y} {z}\nvn {x} {y} {z}\nvt {u} {v}\n");
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = 1 + row * (columns + 1) + column;
        let [a, b, c, d] = [at, at + 1, at + columns + 2, at + columns + 1].map(|i| format!("{i}/{i}/{i}"));
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

/// The normal that a surface shows in the middle of the image, from `eye`, by its brightness under a light along each axis in turn. The
/// lights are on the sides of `towards`.
fn normal_shown(folder: &Path, object: &str, map: &str, eye: DVec3, towards: DVec3) -> DVec3 {
    let lights = [0, 1, 2].map(|axis| {
        // A little above the surface, which is not lit from behind.
        let mut to_light = 0.01 * eye.normalize();
        to_light[axis] += towards[axis].signum();
        to_light.normalize()
    });
    let shown = lights.map(|to_light| {
        let [(a, b, c), (d, e, f)] = [eye, -to_light].map(<(f64, f64, f64)>::from);
        let text = format!(
            "Scene(image: (width: 1, height: 1), camera: (look_from: ({a}, {b}, {c}), look_at: (0, 0, 0), up: (1, 2, 3), vertical_fov: 0.001),
            background: Solid((0, 0, 0)), materials: {{\"one\": Lambertian(albedo: Rgb(1, 1, 1), normal: Image(path: \"{map}\"))}},
            objects: [{object}, DirectionalLight(direction: ({d}, {e}, {f}), irradiance: (3.14159265358979, 0, 0))],
            render: (samples: 4, max_depth: 1))"
        );
        render(&scene_in(folder, &text), &Request::default().mis()).pixel(0, 0)[0]
    });
    // Each brightness is that of the cosine with its light: three equations.
    DMat3::from_cols(lights[0], lights[1], lights[2]).transpose().inverse() * DVec3::from_array(shown)
}

#[test]
fn every_shape_has_the_axes_of_its_texture_coordinates() {
    let folder = folder();
    let unit = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
    // Shape, eye, and the directions of u, v and the normal there.
    let quad = "Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0.5, 2, 0), material: \"one\")";
    let disk = "Disk(center: (0, 0, 0), normal: (1, 0, 0), radius: 1, material: \"one\")";
    let cuboid = "Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"one\")";
    let sphere = "Sphere(center: (0, 0, 0), radius: 1, material: \"one\")";
    let turned = "Transformed(by: [RotateY(90)], object: Sphere(center: (0, 0, 0), radius: 1, material: \"one\"))";
    let mesh = |name: &str| format!("Mesh(path: \"{name}.obj\", material: \"one\")");
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let cases = [
        (quad.to_owned(), 5.0 * z, x, y, z),
        (disk.to_owned(), 5.0 * x, -z, y, x),
        (cuboid.to_owned(), 5.0 * z, x, y, z),
        (cuboid.to_owned(), -5.0 * z, -x, y, -z),
        (cuboid.to_owned(), 5.0 * x, -z, y, x),
        (cuboid.to_owned(), -5.0 * x, z, y, -x),
        (cuboid.to_owned(), 5.0 * y, x, -z, y),
        (cuboid.to_owned(), -5.0 * y, x, z, -y),
        (sphere.to_owned(), 5.0 * z, x, y, z),
        (sphere.to_owned(), 5.0 * x, -z, y, x),
        (sphere.to_owned(), 5.0 * unit(0.0, 1.0, 1.0), x, unit(0.0, 1.0, -1.0), unit(0.0, 1.0, 1.0)),
        (turned.to_owned(), 5.0 * unit(0.0, 1.0, 1.0), x, unit(0.0, 1.0, -1.0), unit(0.0, 1.0, 1.0)),
        (mesh("mirrored"), 5.0 * z, -x, y, z),
        (mesh("turned"), 5.0 * z, y, -x, z),
        (mesh("smooth-mirrored"), 5.0 * z, -x, y, z),
        (mesh("smooth-turned"), 5.0 * z, y, -x, z),
        (format!("Transformed(by: [RotateZ(90)], object: {})", mesh("smooth-turned")), 5.0 * z, -x, -y, z),
        // A vertex of the ball.
        (mesh("ball"), 5.0 * z, x, y, z),
    ];
    for (object, eye, u, v, normal) in cases {
        for (map, mapped) in [("tilted.exr", MAPPED), ("half.exr", MAPPED * DVec3::new(0.5, 0.5, 1.0))] {
            let expected = (mapped.x * u + mapped.y * v + mapped.z * normal).normalize();
            let shown = normal_shown(folder.path(), &object, map, eye, expected);
            let off = (shown - expected).length();
            assert!(off < 1e-3, "{object} from {eye}: {shown}, expected {expected}");
        }
    }
}

/// The normals of an image of the ball, whose pixels are a hundredth of its radius apart. Its lights are red, green and blue, each from a
/// direction of its own.
fn normals_of_ball(folder: &Path, shot: impl Fn(&Scene) -> Shot) -> Vec<DVec3> {
    let lights =
        [DVec3::new(0.6, 0.0, 1.0), DVec3::new(-0.3, 0.5, 1.0), DVec3::new(-0.3, -0.5, 1.0)].map(DVec3::normalize);
    let colours = ["(3.14159265358979, 0, 0)", "(0, 3.14159265358979, 0)", "(0, 0, 3.14159265358979)"];
    let side = SIDE;
    // Each light alone, because one of several is chosen by chance.
    let images = [0, 1, 2].map(|light| {
        let (x, y, z) = (-lights[light]).into();
        let colour = colours[light];
        let text = format!(
            "Scene(image: (width: {side}, height: {side}), camera: (look_from: (0.2, 0.3, 50), look_at: (0.2, 0.3, 0),
            vertical_fov: {}), background: Solid((0, 0, 0)),
            materials: {{\"one\": Lambertian(albedo: Rgb(1, 1, 1), normal: Image(path: \"tilted.exr\"))}},
            objects: [Mesh(path: \"ball.obj\", material: \"one\"), DirectionalLight(direction: ({x}, {y}, {z}), irradiance: {colour})],
            render: (samples: 1, max_depth: 1))",
            2.0 * (0.005 * f64::from(side) / 49.0).atan().to_degrees()
        );
        let shot = shot(&scene_in(folder, &text));
        (0..side * side).map(|at| shot.pixel(at % side, at / side)[light]).collect::<Vec<_>>()
    });
    let to_normal = DMat3::from_cols(lights[0], lights[1], lights[2]).transpose().inverse();
    (0..(side * side) as usize)
        .map(|at| to_normal * DVec3::from_array([0, 1, 2].map(|light| images[light][at])))
        .collect()
}

const SIDE: u32 = 48;

/// The largest difference between the normals of two pixels side by side.
fn largest_jump(normals: &[DVec3]) -> f64 {
    let side = SIDE as usize;
    let pairs = (0..side * side).filter(|at| at % side > 0).map(|at| (at, at - 1));
    let pairs = pairs.chain((side..side * side).map(|at| (at, at - side)));
    pairs.map(|(a, b)| (normals[a] - normals[b]).length()).fold(0.0, f64::max)
}

/// Over the ball's edges, whose faces have tangents of their own.
#[test]
fn a_mapped_normal_does_not_jump_where_faces_meet() {
    let folder = folder();
    let request = Request::default().mis();
    let jump = largest_jump(&normals_of_ball(folder.path(), |scene| render(scene, &request)));
    let faces = Overlay::new(&[]).rewritten("scene/vertex_tangents", |own| {
        own.replace("meshes[meshes[index].x].w != NO_NORMAL", "index == 0xffffffffu")
    });
    let by_faces = largest_jump(&normals_of_ball(folder.path(), |scene| render_planted(scene, &request, &faces)));
    println!("{jump}, by the tangents of faces {by_faces}");
    // Pixels of one sample are two hundredths of the radius apart at most. At this height a normal turns by that, and its tangents by as
    // much again; interpolation makes it a third more where faces are flattest.
    assert!(jump < 0.05, "{jump}");
    assert!(by_faces > 0.05, "the tangents of faces are not found: {by_faces}");
}

/// Tangents of a glTF file, which are not those of its texture coordinates; of nodes as they are, and mirrored.
#[test]
fn tangents_of_a_file_are_used() {
    let folder = folder();
    let normals = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];
    let uvs = [0., 1., 1., 1., 1., 0., 0., 0.];
    let material = json!({"normalTexture": {"index": 0}});
    let turned = DVec3::new(0.6, 0.8, 0.0);
    for sign in [1.0, -1.0] {
        let tangents = [turned.x as f32, turned.y as f32, 0.0, sign as f32].repeat(4);
        let attributes = [("NORMAL", 3, normals.as_slice()), ("TEXCOORD_0", 2, &uvs), ("TANGENT", 4, &tangents)];
        let (json, binary) = square(&attributes, &material, &["tilted.exr"]);
        std::fs::write(folder.path().join("square.glb"), glb(&json, &binary)).expect("it is written");
        let v = sign * DVec3::Z.cross(turned);
        let expected = MAPPED.x * turned + MAPPED.y * v + MAPPED.z * DVec3::Z;
        let mirror = DVec3::new(-1.0, 1.0, 1.0);
        for (part, expected) in [("meshes/0", expected), ("nodes/0", expected), ("nodes/1", mirror * expected)] {
            let by = if part == "nodes/1" { "Translate((0, 0, 9))" } else { "Scale(1)" };
            let mesh = format!("Mesh(path: \"square.glb#{part}/primitives/0\", material: \"one\")");
            let object = format!("Transformed(by: [{by}], object: {mesh})");
            let shown = normal_shown(folder.path(), &object, "tilted.exr", 5.0 * DVec3::Z, expected);
            assert!((shown - expected).length() < 1e-3, "{part}, {sign}: {shown}, expected {expected}");
            let of_uvs = MAPPED * if part == "nodes/1" { mirror } else { DVec3::ONE };
            assert!((shown - of_uvs).length() > 0.1, "{part}: the tangents of the texture coordinates are not found");
        }
    }
}

/// Without a TANGENT, a mirrored node has the mirrored normals.
#[test]
fn a_mirrored_node_has_a_mirrored_relief() {
    let folder = folder();
    let normals = [0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.];
    let uvs = [0., 1., 1., 1., 1., 0., 0., 0.];
    let attributes = [("NORMAL", 3, normals.as_slice()), ("TEXCOORD_0", 2, &uvs)];
    let (json, binary) = square(&attributes, &json!({"normalTexture": {"index": 0}}), &["tilted.exr"]);
    std::fs::write(folder.path().join("square.glb"), glb(&json, &binary)).expect("it is written");
    let mesh = "Mesh(path: \"square.glb#nodes/1/primitives/0\", material: \"one\")";
    let object = format!("Transformed(by: [Translate((0, 0, 9))], object: {mesh})");
    let expected = MAPPED * DVec3::new(-1.0, 1.0, 1.0);
    let shown = normal_shown(folder.path(), &object, "tilted.exr", 5.0 * DVec3::Z, expected);
    assert!((shown - expected).length() < 1e-3, "{shown}, expected {expected}");
}

#[test]
fn no_light_passes_a_closed_surface() {
    let folder = folder();
    let text = |scale: f64| {
        format!(
            "Scene(image: (width: 12, height: 8), camera: (look_from: (0, 0, 0), look_at: (0.3, 0.2, 1), vertical_fov: 120),
            background: Solid((1, 1, 1)), materials: {{\"one\": Pbr(metallic: 0.5, roughness: 0.3,
                normal: Image(path: \"bumps.exr\"), normal_scale: {scale})}},
            objects: [Transformed(by: [Scale(2)], object: Mesh(path: \"ball.obj\", material: \"one\")),
                Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"one\")],
            render: (samples: 64, max_depth: 8))"
        )
    };
    for scale in [1.0, 10.0] {
        let scene = scene_in(folder.path(), &text(scale));
        for request in [Request::default(), Request::default().mis()] {
            let shot = render(&scene, &request);
            assert!(shot.picture.rgb.iter().all(|pixel| *pixel == [0.0; 3]), "{scale}: {:?}", shot.mean_of_all());
        }
        let open = Overlay::new(&[]).rewritten("scene/normal_map", |own| {
            own.replace("!keeps_its_side(bsdf.direction, mapped, shading)", "false")
        });
        let leaks = render_planted(&scene, &Request::default(), &open);
        assert!(leaks.picture.rgb.iter().any(|pixel| pixel[0] > 0.0), "light that passes is not found");
    }
}

#[test]
fn a_normal_map_is_an_image_on_something_with_texture_coordinates() {
    let folder = folder();
    let found = |normal: &str, object: &str| {
        let text = format!(
            "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((1, 1, 1)), materials: {{\"one\": Lambertian(albedo: Rgb(1, 1, 1), {normal})}}, objects: [{object}])"
        );
        let file = folder.path().join("scene.ron");
        std::fs::write(&file, text).expect("it is written");
        Scene::load(&file).expect_err("it is refused").to_string()
    };
    let ball = "Sphere(center: (0, 0, 0), radius: 1, material: \"one\")";
    let expected = "expected a normal map: Image(path: ..), without a tint";
    assert!(found("normal: Rgb(0.5, 0.5, 1)", ball).contains(expected));
    assert!(found("normal: Image(path: \"bumps.exr\", tint: (1, 1, 0.5))", ball).contains(expected));
    assert!(found("normal: Image(path: \"bumps.exr\"), normal_scale: 1e4", ball).contains("from -1000 to 1000"));
    let bare = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(folder.path().join("bare.obj"), bare).expect("it is written");
    let bare = "Mesh(path: \"bare.obj\", material: \"one\")";
    assert!(found("normal: Image(path: \"bumps.exr\")", bare).contains("has no texture coordinates"));
}
