//! Textures of one material by different texture coordinates of a mesh: closed forms, and what `convert` writes.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DMat2, DVec2, DVec3};
use gpu_rt::scene::{Lambertian, Material, Scene};
use image::{Rgb, RgbImage};
use serde_json::{Value, json};

use crate::common::gltf::{converted, glb, square};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, scene_in};

const SIDE: u32 = 16;
/// The codes of the four quarters of each image, in the order of glTF: from the left to the right, then from the top down.
const RED: [u8; 4] = [40, 90, 160, 230];
const EMISSION: [u8; 4] = [230, 60, 130, 20];
const ROUGHNESS: [u8; 4] = [70, 120, 180, 240];
const NORMALS: [[u8; 3]; 4] = [[128, 128, 255], [180, 128, 240], [128, 60, 230], [90, 170, 235]];
/// The corners of the square in the second set: turned, and larger than the image.
const SECOND: [[f64; 2]; 4] = [[0.2, 1.1], [-0.1, 0.1], [0.9, -0.2], [1.2, 0.8]];

/// How a texture is placed: its set, and KHR_texture_transform.
#[derive(Clone, Copy)]
struct Placing {
    set: usize,
    offset: [f64; 2],
    scale: [f64; 2],
    rotation: f64,
}

const PLAIN: Placing = Placing { set: 0, offset: [0.0; 2], scale: [1.0; 2], rotation: 0.0 };
const OF_EMISSION: Placing = Placing { set: 1, offset: [0.3, -0.2], scale: [1.5, 0.75], rotation: 0.4 };
const OF_NORMAL: Placing = Placing { offset: [0.1, 0.0], rotation: -1.1, ..PLAIN };
/// One point of the image: its upper right quarter.
const OF_ROUGHNESS: Placing = Placing { set: 1, offset: [0.75, 0.25], scale: [0.0; 2], rotation: 0.0 };

impl Placing {
    fn info(&self, texture: usize) -> Value {
        let Placing { set, offset, scale, rotation } = self;
        // The extension's set stands for the one beside it.
        let transform = json!({"offset": offset, "scale": scale, "rotation": rotation, "texCoord": set});
        json!({"index": texture, "texCoord": 1 - set, "extensions": {"KHR_texture_transform": transform}})
    }

    /// The texture coordinates, with v down, at a point from (-1, -1) to (1, 1), and how they change with it. The second set is bilinear
    /// between its corners, which are those of a parallelogram.
    fn at(&self, point: DVec2) -> (DVec2, DMat2) {
        let (s, t) = (0.5 * (point.x + 1.0), 0.5 * (point.y + 1.0));
        let [a, b, _, d] = match self.set {
            0 => [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            _ => SECOND,
        }
        .map(DVec2::from_array);
        let own = a + s * (b - a) + t * (d - a);
        // The matrices of the extension's text.
        let (sin, cos) = self.rotation.sin_cos();
        let rotation = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
        let matrix = rotation * DMat2::from_diagonal(DVec2::from_array(self.scale));
        let change = matrix * DMat2::from_cols(0.5 * (b - a), 0.5 * (d - a));
        (matrix * own + DVec2::from_array(self.offset), change)
    }

    /// The quarter of the image that a point of the square shows, if it is far from the edges of quarters.
    fn quarter(&self, point: DVec2) -> Option<usize> {
        let at = self.at(point).0.map(|x| 2.0 * x.rem_euclid(1.0));
        let is_transmissive = |x: f64| (x - x.round()).abs() > 2.0 * 0.12;
        (is_transmissive(at.x) && is_transmissive(at.y)).then_some(2 * (at.y as usize) + at.x as usize)
    }
}

/// A folder with the square, its images and a scene of its own with a light.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let save = |name: &str, texel: &dyn Fn(usize) -> [u8; 3]| {
        let image = image::RgbImage::from_fn(32, 32, |x, y| image::Rgb(texel(2 * (y as usize / 16) + x as usize / 16)));
        image.save(folder.path().join(name)).expect("it is written");
    };
    save("base.png", &|quarter| [RED[quarter], 0, 255]);
    save("glow.png", &|quarter| [0, EMISSION[quarter], 0]);
    save("rough.png", &|quarter| [0, ROUGHNESS[quarter], 0]);
    save("normal.png", &|quarter| NORMALS[quarter]);
    let floats = |uvs: [[f64; 2]; 4]| uvs.as_flattened().iter().map(|x| *x as f32).collect::<Vec<_>>();
    let first = floats([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let material = json!({
        "name": "one", "doubleSided": true, "emissiveFactor": [1, 1, 1], "emissiveTexture": OF_EMISSION.info(1),
        "normalTexture": OF_NORMAL.info(3),
        "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": OF_ROUGHNESS.info(2)},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
    });
    let attributes = [("TEXCOORD_0", 2, first.as_slice()), ("TEXCOORD_1", 2, &floats(SECOND))];
    let (json, binary) = square(&attributes, &material, &["base.png", "glow.png", "rough.png", "normal.png"]);
    std::fs::write(folder.path().join("square.glb"), glb(&json, &binary)).expect("it is written");
    folder
}

fn load(path: &Path) -> Scene {
    Scene::load(path).unwrap_or_else(|error| panic!("{error}"))
}

/// The square of the file fills the image, under a sun in red and blue.
fn scene(folder: &Path, objects: &str, more: &str) -> Scene {
    let text = format!(
        "Scene(image: (width: {SIDE}, height: {SIDE}), camera: (look_from: (0, 0, 50), look_at: (0, 0, 0),
        vertical_fov: {}), background: Solid((0, 0, 0)), materials: {{{more}}},
        objects: [{objects}, DirectionalLight(direction: (-0.3, -0.2, -1), irradiance: ({PI}, 0, {PI}))],
        render: (samples: 16, max_depth: 1))",
        2.0 * (1.0_f64 / 50.0).atan().to_degrees()
    );
    let path = folder.join("own.ron");
    std::fs::write(&path, text).expect("it is written");
    load(&path)
}

fn linear(code: u8) -> f64 {
    let x = f64::from(code) / 255.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// The normal that the map has in a quarter, by the directions in which u and v grow.
fn normal(quarter: usize) -> DVec3 {
    let change = OF_NORMAL.at(DVec2::ZERO).1.inverse();
    let u = change.x_axis.normalize();
    // v grows upwards here and downwards there.
    let across = DVec2::new(-u.y, u.x);
    let v = across * (across.dot(-change.y_axis)).signum();
    let mapped = DVec3::from_array(NORMALS[quarter].map(|code| 2.0 * f64::from(code) / 255.0 - 1.0));
    (mapped.x * u.extend(0.0) + mapped.y * v.extend(0.0) + mapped.z * DVec3::Z).normalize()
}

/// A scene in which nothing but the square emits, and one in which it does not: each has one light, so that no choice makes noise.
fn parts(scene: &Scene) -> [Scene; 2] {
    let (mut emissive, mut lit) = (scene.clone(), scene.clone());
    emissive.objects.pop();
    for (_, material) in &mut lit.materials {
        if let Material::Lambertian(Lambertian { emission, .. }) = material {
            *emission = None;
        }
    }
    [emissive, lit]
}

/// Compares images of the parts of a scene with what is known of them, wherever a pixel shows one quarter of each texture.
fn check(scene: &Scene, shot: impl Fn(&Scene) -> Shot) -> Result<(), String> {
    let [emissive, lit] = parts(scene).map(|part| shot(&part));
    let to_light = DVec3::new(0.3, 0.2, 1.0).normalize();
    let mut seen = [[0; 4]; 3];
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        let point = DVec2::new(f64::from(2 * x + 1), f64::from(2 * (SIDE - 1 - y) + 1)) / f64::from(SIDE) - 1.0;
        let [base, emitted, bumps] = [PLAIN, OF_EMISSION, OF_NORMAL].map(|placing| placing.quarter(point));
        for (counts, quarter) in seen.iter_mut().zip([base, emitted, bumps]) {
            quarter.into_iter().for_each(|quarter| counts[quarter] += 1);
        }
        let cosine = bumps.map(|quarter| normal(quarter).dot(to_light));
        let red = base.zip(cosine).map(|(quarter, cosine)| linear(RED[quarter]) * cosine);
        let expected = [red, emitted.map(|quarter| linear(EMISSION[quarter])), cosine];
        let ([red, _, blue], [_, green, _]) = (lit.pixel(x, y), emissive.pixel(x, y));
        for (found, expected) in [red, green, blue].into_iter().zip(expected) {
            if expected.is_some_and(|expected| (found - expected).abs() > 1e-3) {
                return Err(format!("({x}, {y}): {found}, expected {expected:?}"));
            }
        }
    }
    assert!(seen.iter().all(|counts| counts.iter().filter(|count| **count > 0).count() >= 3), "{seen:?}");
    Ok(())
}

#[test]
fn each_texture_has_its_own_texture_coordinates() {
    let folder = folder();
    let request = Request::default().mis();
    let of_file = scene(folder.path(), "Gltf(path: \"square.glb\")", "");
    check(&of_file, |scene| render(scene, &request)).unwrap_or_else(|error| panic!("{error}"));
    // By a material of the scene file.
    let own = "\"own\": Lambertian(albedo: Image(path: \"base.png\"), emission: Image(path: \"glow.png\", uv_set: 1),
        normal: Image(path: \"normal.png\", uv_set: 3))";
    let mesh = "Mesh(path: \"square.glb#meshes/0/primitives/0\", material: \"own\")";
    let own = scene(folder.path(), mesh, own);
    check(&own, |scene| render(scene, &request)).unwrap_or_else(|error| panic!("{error}"));

    let first = Overlay::new(&[]).rewritten("scene/with_table", |own| own.replace("u32(number) + 1u", "1u"));
    let found = check(&of_file, |scene| render_planted(scene, &request, &first));
    assert!(found.is_err(), "that all have the first set is not found");
    for (name, other) in [("emission", "uv_set: 1"), ("normal", "uv_set: 3")] {
        let text = own.text().replace(other, "uv_set: 2");
        let planted = scene_in(folder.path(), &text);
        assert!(check(&planted, |scene| render(scene, &request)).is_err(), "{name}: another set is not found");
    }
}

/// A roughness by a set of texture coordinates that is one point is the number of that point.
#[test]
fn a_number_has_its_own_texture_coordinates() {
    let folder = folder();
    let mesh = "Mesh(path: \"square.glb#meshes/0/primitives/0\", material: \"own\")";
    let image = |roughness: &str| {
        let own = format!("\"own\": Conductor(albedo: Image(path: \"base.png\"), roughness: {roughness})");
        render(&scene(folder.path(), mesh, &own), &Request::default().mis()).picture.rgb
    };
    let number = |quarter: usize| image(&format!("{}", f64::from(ROUGHNESS[quarter]) / 255.0));
    let off = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
    };
    let found = image("Image(path: \"rough.png\", channel: G, uv_set: 2)");
    let expected = number(1);
    let brightest = expected.as_flattened().iter().copied().fold(0.0, f32::max);
    assert!(off(&found, &expected) <= 1e-5 * f64::from(brightest), "{}", off(&found, &expected));
    for other in [image("Image(path: \"rough.png\", channel: G)"), number(0), number(2)] {
        assert!(off(&found, &other) > 1e-2 * f64::from(brightest), "another set is not found");
    }
}

#[test]
fn a_converted_scene_renders_to_the_same_bytes() {
    let folder = folder();
    let [from, to] = ["square.glb", "converted.ron"].map(|name| folder.path().join(name));
    let text = converted(&from, &to);
    let bits = |scene: &Scene| render(scene, &Request::spp(4).mis().size(16, 12)).bits();
    let expected = bits(&load(&from));
    assert_eq!(expected, bits(&load(&to)));
    assert!(text.contains("uv_set: 1") && text.contains("uv_set: 3"), "{text}");
    std::fs::write(&to, text.replace("uv_set: 1", "uv_set: 0")).expect("it is written");
    assert_ne!(expected, bits(&load(&to)), "another set is not found");
}

#[test]
fn sets_that_are_not_there_are_refused() {
    let folder = folder();
    let found = |own: &str, object: &str| {
        let text = format!(
            "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((1, 1, 1)), materials: {{\"one\": Lambertian(albedo: {own})}}, objects: [{object}])"
        );
        let file = folder.path().join("scene.ron");
        std::fs::write(&file, text).expect("it is written");
        Scene::load(&file).expect_err("it is refused").to_string()
    };
    let mesh = "Mesh(path: \"square.glb#meshes/0/primitives/0\", material: \"one\")";
    let error = found("Image(path: \"base.png\", uv_set: 4)", mesh);
    assert!(error.contains("has no such set of texture coordinates: expected a set from 0 to 3"), "{error}");
    let error =
        found("Image(path: \"base.png\", uv_set: 1)", "Sphere(center: (0, 0, 0), radius: 1, material: \"one\")");
    assert!(error.contains("has an image with uv_set: 1, which meshes alone have"), "{error}");
    let error = found("Image(path: \"base.png\", uv_set: 16)", mesh);
    assert!(error.contains("a whole number from 0 to 15"), "{error}");
}

/// A mesh shows an image by its wrap, in the middle of texels and between them, beyond its edges too: against its definition in f64.
#[test]
fn images_of_meshes_go_on_by_their_wraps() {
    const SIZE: [i64; 2] = [4, 3];
    let code = |column: i64, row: i64| {
        [(90 * column + 170 * row) % 256, (200 * column + 60 * row) % 256, 40 * column].map(|x| x as u8)
    };
    let folder = tempfile::tempdir().expect("a folder");
    let image = RgbImage::from_fn(4, 3, |x, y| Rgb(code(i64::from(x), i64::from(y))));
    image.save(folder.path().join("few.png")).expect("it is written");
    let square = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt -1.5 -1.3\nvt 2.5 -1.3\nvt 2.5 2.7\nvt -1.5 2.7\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    std::fs::write(folder.path().join("square.obj"), square).expect("it is written");
    // The index of a texel within the image.
    let within = |wrap: &str, index: i64, count: i64| match wrap {
        "Clamp" => index.clamp(0, count - 1),
        "Mirror" if index.div_euclid(count) % 2 != 0 => count - 1 - index.rem_euclid(count),
        _ => index.rem_euclid(count),
    };
    let colour = |wrap: &str, uv: DVec2| {
        let at = DVec2::new(uv.x * SIZE[0] as f64, (1.0 - uv.y) * SIZE[1] as f64) - 0.5;
        let (first, share) = (at.floor(), at - at.floor());
        let texel = |right: i64, down: i64| {
            let column = within(wrap, first.x as i64 + right, SIZE[0]);
            let row = within(wrap, first.y as i64 + down, SIZE[1]);
            DVec3::from_array(code(column, row).map(linear))
        };
        texel(0, 0).lerp(texel(1, 0), share.x).lerp(texel(0, 1).lerp(texel(1, 1), share.x), share.y)
    };
    // A pixel is a tenth of the image across.
    const PIXELS: u32 = 40;
    let off = |wrap: &str, shot: &Shot| {
        let pixels = (0..PIXELS).flat_map(|y| (0..PIXELS).map(move |x| (x, y)));
        pixels.fold(0.0f64, |most, (x, y)| {
            let points = (0..64).map(|i| {
                DVec2::new(f64::from(x), f64::from(y))
                    + DVec2::new(f64::from(i % 8), f64::from(i / 8)) / 8.0
                    + 1.0 / 16.0
            });
            let mean =
                points.map(|at| colour(wrap, DVec2::new(0.1 * at.x - 1.5, 2.7 - 0.1 * at.y))).sum::<DVec3>() / 64.0;
            most.max((DVec3::from_array(shot.pixel(x, y)) - mean).abs().max_element())
        })
    };
    let scene = |wrap: &str| {
        let text = format!(
            "Scene(image: (width: {PIXELS}, height: {PIXELS}), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), projection: Orthographic(height: 2)),
            background: Solid((0, 0, 0)), materials: {{\"lamp\": DiffuseLight(emit: Image(path: \"few.png\", wrap: {wrap}))}},
            objects: [Mesh(path: \"square.obj\", material: \"lamp\")], render: (samples: 64, max_depth: 1))"
        );
        let path = folder.path().join("own.ron");
        std::fs::write(&path, text).expect("it is written");
        load(&path)
    };
    let request = Request::spp(64).sobol();
    for wrap in ["Repeat", "Clamp", "Mirror"] {
        let shot = render(&scene(wrap), &request);
        assert!(off(wrap, &shot) < 0.01, "{wrap}: {}", off(wrap, &shot));
        let others = ["Repeat", "Clamp", "Mirror"].into_iter().filter(|other| *other != wrap);
        others.for_each(|other| assert!(off(other, &shot) > 0.3, "{wrap} and {other}: {}", off(other, &shot)));
    }
    // Edges that blend into the other ones, and odd copies of the image that begin half of it later.
    for (wrap, right, wrong) in [
        ("Clamp", "vec2<bool>(false)", "vec2<bool>(true)"),
        ("Mirror", "2.0 * round(0.5 * uv)", "2.0 * floor(0.5 * uv)"),
    ] {
        let planted = render_planted(&scene(wrap), &request, &Overlay::new(&[("scene/image_wrap", right, wrong)]));
        assert!(off(wrap, &planted) > 0.1, "{wrap}: {wrong} is not found");
    }
}
