//! Lights whose radiance varies, which are cut into parts; and bodies with an alpha that emit on both sides: one expectation with and without light
//! sampling, and with light paths.

use std::path::Path;

use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::scene::Scene;
use image::{DynamicImage, Rgb, Rgb32FImage, RgbImage, Rgba, RgbaImage};
use serde_json::json;

use crate::common::faults::{agree, changed, differ};
use crate::common::gltf::{glb, square};
use crate::common::render::{Request, Shot, render, render_planted, scene_in};

const ROUNDING: f64 = 1e-5;

/// A folder with images of 8 x 8 texels, half of them black or dim; a sheet whose texture coordinates go beyond the image; and a glTF file with a
/// texture transform.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let texel = |x: u32, y: u32| match (3 * x + 5 * y) % 8 {
        0 => [6.0, 5.0, 4.0],
        1 | 2 => [0.5, 1.5, 3.0],
        3..6 => [0.05, 0.05, 0.1],
        _ => [0.0; 3],
    };
    let blobs = Rgb32FImage::from_fn(8, 8, |x, y| Rgb(texel(x, y)));
    DynamicImage::from(blobs).save(folder.path().join("blobs.hdr")).expect("it is written");
    let codes = RgbImage::from_fn(8, 8, |x, y| Rgb(texel(x, y).map(|value: f32| (42.0 * value) as u8)));
    codes.save(folder.path().join("codes.png")).expect("it is written");
    let holes = RgbaImage::from_fn(8, 8, |x, y| Rgba([200, 200, 200, if (x + y) % 3 == 0 { 30 } else { 200 }]));
    holes.save(folder.path().join("holes.png")).expect("it is written");
    let sheet = "v -1 0 -1\nv 1 0.3 -1\nv 1.2 0.2 1\nv -0.9 -0.2 1.1\n\
                 vt -0.3 0.1\nvt 1.6 0.2\nvt 1.5 1.7\nvt -0.2 1.3\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    std::fs::write(folder.path().join("sheet.obj"), sheet).expect("it is written");
    let transform = json!({"offset": [0.3, -0.2], "scale": [1.5, 0.75], "rotation": 0.4});
    let material = json!({"name": "one", "doubleSided": true, "emissiveFactor": [1, 1, 1],
        "emissiveTexture": {"index": 0, "extensions": {"KHR_texture_transform": transform}},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}});
    let uvs = ("TEXCOORD_0", 2, [0.0f32, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0].as_slice());
    let (json, binary) = square(&[uvs], &material, &["codes.png"]);
    std::fs::write(folder.path().join("square.glb"), glb(&json, &binary)).expect("it is written");
    folder
}

/// Grey rooms, open to the front, with these lamps: two beside each other, and two on top of these, each of 16 x 16 pixels.
fn rooms(folder: &Path, camera: &str, lamps: &[&str], more: &str) -> Scene {
    let of = |(number, lamps): (usize, &&str)| {
        let (x, y) = (2.1 * (number % 2) as f64, 2.1 * (number / 2) as f64);
        format!(
            "Transformed(by: [Translate(({x}, {y}, 0))], object: Group([
                Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"wall\"),
                Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
                Quad(corner: (-1, 0, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"wall\"), {lamps} {more}])),"
        )
    };
    let all: String = lamps.iter().enumerate().map(of).collect();
    let (size, from, at) = if lamps.len() > 1 {
        (32, "(1.05, 2.05, 6.2)", "(1.05, 2.05, 0)")
    } else {
        (16, "(0, 1, 3.6)", "(0, 0.95, 0)")
    };
    let (image, mirrored) = ("Image(path: \"blobs.hdr\")", "Image(path: \"blobs.hdr\", wrap: Mirror)");
    scene_in(
        folder,
        &format!(
            "Scene(image: (width: {size}, height: {size}), camera: (look_from: {from}, look_at: {at}, vertical_fov: 38{camera}),
            background: Solid((0, 0, 0)),
            materials: {{
                \"wall\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)),
                \"lamp\": DiffuseLight(emit: {image}, two_sided: false),
                \"both\": DiffuseLight(emit: {image}),
                \"matt\": Lambertian(albedo: Rgb(0.5, 0.6, 0.7), emission: {image}),
                \"pbr\": Pbr(base_color: Rgb(0.5, 0.6, 0.7), metallic: 0, roughness: 0.6, emission: {mirrored}),
                \"checker\": DiffuseLight(emit: Checker(scale: 0.3, even: (0, 0, 0), odd: (3, 2, 1))),
                \"marble\": DiffuseLight(emit: Marble(scale: 9)), \"noise\": DiffuseLight(emit: Noise(scale: 5)),
                \"veil\": Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, emission: {image}, alpha: Image(path: \"holes.png\", channel: A)),
                \"glass\": Dielectric(ior: 1.5), \"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0),
            }},
            objects: [{all}], render: (samples: 512, max_depth: 4))"
        ),
    )
}

/// Lamps that are cut into parts: quads, faces, those of solid textures, and disks.
const LAMPS: [&str; 4] = [
    "Quad(corner: (-0.6, 1.9, -0.6), u: (1.2, 0, 0.2), v: (0.3, 0, 1.2), material: \"lamp\"),
         Quad(corner: (-0.9, 0.3, -0.8), u: (0.7, 0, 0), v: (0.1, 0.6, 0.2), material: \"pbr\"),
         Transformed(by: [Scale(0.5), RotateY(40), Translate((0.6, 0.8, 0))],
             object: Quad(corner: (-1, 0, 0), u: (1.5, 0, 0), v: (0, 0.8, 0), material: \"both\")),
         Quad(corner: (0.3, 0.1, 0.3), u: (0.4, 0, 0), v: (0, 0.3, 0.1), material: \"matt\"),",
    "Transformed(by: [Scale(0.6), RotateX(10), Translate((0, 1.8, 0))], object: Mesh(path: \"sheet.obj\", material: \"lamp\")),
         Transformed(by: [Scale(0.3), RotateZ(60), Translate((-0.6, 0.5, 0))], object: Mesh(path: \"sheet.obj\", material: \"both\")),
         Transformed(by: [Scale(0.3), RotateZ(-50), Translate((0.6, 0.5, 0))], object: Mesh(path: \"sheet.obj\", material: \"pbr\")),
         Transformed(by: [Scale(0.3), RotateX(-30), Translate((0, 0.4, 0.2))], object: Gltf(path: \"square.glb\")),",
    "Quad(corner: (-0.6, 1.9, -0.6), u: (1.2, 0, 0.2), v: (0.3, 0, 1.2), material: \"checker\"),
         Disk(center: (-0.6, 0.6, -0.2), normal: (1, 0.4, 0.3), radius: 0.35, material: \"marble\"),
         Transformed(by: [Scale(0.3), RotateZ(-50), Translate((0.6, 0.5, 0))], object: Mesh(path: \"sheet.obj\", material: \"checker\")),
         Quad(corner: (0.3, 0.1, 0.3), u: (0.4, 0, 0), v: (0, 0.3, 0.1), material: \"noise\"),",
    "Disk(center: (0, 1.9, 0), normal: (0.1, -1, 0.2), radius: 0.7, material: \"lamp\"),
         Disk(center: (-0.6, 0.6, -0.2), normal: (1, 0.4, 0.3), radius: 0.35, material: \"both\"),
         Transformed(by: [Scale(0.4), RotateX(30), Translate((0.6, 0.5, 0))],
             object: Disk(center: (0, 0, 0), normal: (-1, 0, 1), radius: 1, material: \"pbr\")),
         Disk(center: (0.2, 0.9, -0.7), normal: (0, 0, 1), radius: 0.2, material: \"veil\"),",
];

const MOVING: &str = "Moving(keys: [(0, [RotateX(0), Translate((0, 0, 0))]), (1, [RotateX(20), Translate((0.2, -0.2, 0))])],
             object: Quad(corner: (-0.6, 1.9, -0.6), u: (1.2, 0, 0.2), v: (0.3, 0, 1.2), material: \"lamp\")),
         Moving(keys: [(0, [Scale(1), Translate((0, 0, 0))]), (1, [Scale(0.6), Translate((0.4, 0.2, 0))])],
             object: Disk(center: (-0.6, 0.6, -0.2), normal: (1, 0.4, 0.3), radius: 0.35, material: \"both\")),
         Moving(keys: [(0, [Scale(0.3), RotateZ(-50), Translate((0.6, 0.5, 0))]), (1, [Scale(0.3), RotateZ(80), Translate((0.5, 0.7, 0.1))])],
             object: Mesh(path: \"sheet.obj\", material: \"pbr\")),";

fn flat(scene: &Scene) -> DeviceScene {
    flatten(scene, (16, 16), &RenderOptions::default()).expect("it flattens")
}

/// The still lamps, without disks in one picture, and those that move.
fn pictures(folder: &Path, more: &str) -> [(&'static str, usize, Scene); 3] {
    let (flat, disks) = LAMPS.split_at(3);
    [
        ("lamps", 3, rooms(folder, "", flat, more)),
        ("disks", 1, rooms(folder, "", disks, more)),
        ("lamps that move", 1, rooms(folder, ", shutter: (0, 1)", &[MOVING], more)),
    ]
}

/// Planted: what the ray hit is the part beside it; light that is sampled where a lamp was when the shutter opened; and 3 % more light.
#[test]
fn parts_of_lights_change_no_expectation() {
    let folder = folder();
    for (name, rooms, scene) in pictures(folder.path(), "") {
        let lights = flat(&scene).features.quantities.lights;
        assert!(lights > 60 * rooms as u32, "{name}: {lights} lights");
        let bsdf = render(&scene, &Request::spp(8192).seed(1).sobol());
        let mis = Request::spp(2048).seed(2).mis();
        agree(name, &bsdf, &render(&scene, &mis), ROUNDING);
        let sobol = render(&scene, &mis.clone().seed(3).sobol().scatter(Scatter::Linked));
        agree(name, &bsdf, &sobol, ROUNDING);
        let fault = match name {
            "lamps that move" => (
                "scene/lights",
                "moved_${name}(${name}_at(index, light.instance), pose), light.part",
                "${name}_at(index, light.instance), light.part",
            ),
            _ => (
                "scene/light_parts",
                "    return part;\n",
                "    return select(part + 1u, lights[index].trail, part == last);\n",
            ),
        };
        let planted = render_planted(&scene, &mis, &changed(&[fault]));
        // In each of the rooms, the first of which are below.
        for (column, row) in [(0, 1), (1, 1), (0, 0)].into_iter().take(rooms) {
            let row = if rooms == 1 { 0 } else { row };
            let only = |shot: &Shot, factor: f32| {
                shot.changed(|x, y, rgb| rgb.map(|v| if (x / 16, y / 16) == (column, row) { factor * v } else { 0.0 }))
            };
            differ("3 % more light", &only(&bsdf, 1.0), &only(&sobol, 1.03), ROUNDING);
            differ(fault.2, &only(&bsdf, 1.0), &only(&planted, 1.0), ROUNDING);
        }
    }
}

/// Light paths start at parts, beside glass and a mirror.
#[test]
fn light_paths_from_parts_change_no_expectation() {
    let folder = folder();
    let glass = "Sphere(center: (-0.1, 0.9, 0.2), radius: 0.3, material: \"glass\"),
        Quad(corner: (0.95, 0, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"mirror\"),";
    for (name, _, scene) in pictures(folder.path(), glass) {
        let alone = render(&scene, &Request::spp(1024).seed(1).mis());
        let shot = render(&scene, &Request::spp(512).seed(2).mis().light_paths(8));
        assert!(shot.film.totals.light_paths[0] > 0, "{name}: no light path was traced");
        agree(name, &alone, &shot, ROUNDING);
    }
}

/// One texel of 64 x 64 has most of the light: its parts are found by light sampling, and the variance falls.
#[test]
fn a_hot_texel_is_sampled() {
    let folder = folder();
    let hot =
        Rgb32FImage::from_fn(64, 64, |x, y| Rgb(if (x, y) == (41, 20) { [900.0, 700.0, 500.0] } else { [0.02; 3] }));
    DynamicImage::from(hot).save(folder.path().join("blobs.hdr")).expect("it is written");
    for (name, lamp) in [
        ("quad", "Quad(corner: (-0.6, 2.2, -0.6), u: (1.2, 0, 0.2), v: (0.3, 0, 1.2), material: \"lamp\"),"),
        ("disk", "Disk(center: (0, 2.2, 0), normal: (0.1, -1, 0.2), radius: 0.7, material: \"lamp\"),"),
        (
            "faces",
            "Transformed(by: [Scale(0.6), RotateX(10), Translate((0, 2.2, 0))], object: Mesh(path: \"sheet.obj\", material: \"lamp\")),",
        ),
    ] {
        let scene = rooms(folder.path(), "", &[lamp], "");
        assert!(flat(&scene).features.quantities.lights > 16, "{name} is not cut");
        let request = Request::spp(1024).seed(1).mis().depth(1);
        let parts = render(&scene, &request).mean_of_all();
        // A point that is uniform in the area of the lamp has a radiance with this relative variance alone: the texel is a tent of four texels,
        // whose square is 4/9 of its peak's.
        let (hot, texels, rest) = (700.0, 64.0 * 64.0, 0.02);
        let uniform = hot * hot / texels * (4.0 / 9.0) / f64::powi(hot / texels + rest, 2);
        let samples = 1024.0 * 256.0;
        let found = parts.variance[1] / parts.value[1].powi(2) * samples;
        println!("{name}: relative variance {found:.3} of a sample, {uniform:.0} without parts");
        assert!(found < 0.02 * uniform, "{name}: {found}");
    }
}
