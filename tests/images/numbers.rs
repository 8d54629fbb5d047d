//! Numbers of materials that vary over a surface: where a texture is constant, the image of the plain number, to the bit.

use std::path::Path;

use gpu_rt::bitmap::CODE;
use gpu_rt::options::Scatter;
use gpu_rt::scene::Scene;

use crate::common::gltf::{converted, glb, room};
use crate::common::render::{Request, Shot, render, scene_in};

fn bits(shot: &Shot, columns: std::ops::Range<usize>) -> Vec<[u32; 3]> {
    let rows = shot.picture.rgb.chunks(shot.picture.width as usize);
    rows.flat_map(|row| row[columns.clone()].iter().map(|pixel| pixel.map(f32::to_bits))).collect()
}

/// A square that fills the view, under a lamp and a sky. A path meets it at most once before the sky or the lamp.
fn square(material: &str) -> String {
    format!(
        "Scene(image: (width: 32, height: 8), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 15),
        background: Gradient(bottom: (0.2, 0.3, 0.4), top: (1, 0.9, 0.8)),
        materials: {{\"square\": {material}, \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7))}},
        objects: [Quad(corner: (-2.2, -0.55, 0), u: (4.4, 0, 0), v: (0, 1.1, 0), material: \"square\"),
            Sphere(center: (1, 2, 3), radius: 0.5, material: \"lamp\")], render: (samples: 16, max_depth: 1))"
    )
}

/// The number that a code stands for.
fn number(code: u8) -> f64 {
    f64::from(CODE * f32::from(code))
}

fn write_image(folder: &Path, name: &str, codes: [[u8; 4]; 4]) {
    let image = image::RgbaImage::from_fn(4, 1, |x, _| image::Rgba(codes[x as usize]));
    image.save(folder.join(name)).expect("it is written");
}

/// The codes of a colour are sRGB, or linear where its channel is Rgb.
#[test]
fn codes_of_a_colour_may_be_linear() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let code = [10, 128, 70, 255];
    write_image(path, "code.png", [code; 4]);
    let shot = |albedo: &str| {
        let matt = square(&format!("Lambertian(albedo: {albedo})"));
        bits(&render(&scene_in(path, &matt), &Request::spp(16)), 0..32)
    };
    let linear = shot("Image(path: \"code.png\", channel: Rgb)");
    let [r, g, b] = [10, 128, 70].map(number);
    // The bits of a positive float follow its size. A lookup rounds twice more.
    let off = |other: Vec<[u32; 3]>| {
        linear.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or_default()
    };
    assert!(off(shot(&format!("Rgb({r:?}, {g:?}, {b:?})"))) <= 2);
    assert!(off(shot("Image(path: \"code.png\")")) > 1_000_000);
}

#[test]
fn where_a_texture_is_constant_the_image_is_that_of_the_plain_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    // Two halves; the channels differ.
    let (left, right) = ([10, 0, 70, 200], [20, 128, 255, 90]);
    write_image(path, "halves.png", [left, left, right, right]);
    type Material = fn(&str) -> String;
    let conductor: Material = |number| {
        format!(
            "Conductor(albedo: Checker(scale: 0.1, even: (1, 0.5, 0.2), odd: (0.9, 0.9, 0.9)), roughness: {number})"
        )
    };
    let glass: Material = |number| format!("RoughDielectric(ior: 1.5, roughness: {number})");
    let pane: Material = |number| format!("ThinDielectric(ior: 1.5, roughness: {number})");
    let rough: Material = |number| format!("Pbr(base_color: Rgb(0.8, 0.2, 0.1), metallic: 0.25, roughness: {number})");
    let metallic: Material = |number| {
        format!(
            "Pbr(base_color: Image(path: \"halves.png\"), metallic: {number}, roughness: 0.5, emission: Rgb(0.1, 0, 0))"
        )
    };
    // Pixels of one texel on all four corners of a lookup.
    let (in_left, in_right) = (1..11, 21..31);
    for (material, channel, codes) in [
        (conductor, "G", [0, 128]),
        (glass, "G", [0, 128]),
        (pane, "G", [0, 128]),
        (rough, "A", [200, 90]),
        (rough, "R", [10, 20]),
        (metallic, "B", [70, 255]),
    ] {
        // Each material by light sampling, and one of them in other ways too.
        let mis = Request::default().mis();
        let others = [mis.clone().scatter(Scatter::Queues), Request::default()];
        let others = if channel == "B" { &others[..] } else { &[] };
        for request in std::iter::once(&mis).chain(others) {
            let of = |number: &str| render(&scene_in(path, &square(&material(number))), request);
            let varying = of(&format!("Image(path: \"halves.png\", channel: {channel})"));
            for (columns, code) in [(in_left.clone(), codes[0]), (in_right.clone(), codes[1])] {
                let same = |other: &str| bits(&varying, columns.clone()) == bits(&of(other), columns.clone());
                assert!(same(&number(code).to_string()), "{} of {code}", material(channel));
            }
            // The next code is another image.
            let next = bits(&of(&number(codes[0] + 1).to_string()), in_left.clone());
            assert!(next != bits(&varying, in_left.clone()), "{}: nothing depends on it", material(channel));
        }
    }
    // A factor, and the red channel where none is said.
    let of = |number: &str| {
        bits(&render(&scene_in(path, &square(&rough(number))), &Request::default().mis()), in_left.clone())
    };
    assert!(of("Image(path: \"halves.png\")") == of(&number(10).to_string()));
    let half = of("Image(path: \"halves.png\", channel: A, tint: (0.5, 1, 1))");
    assert!(half == of(&(0.5 * number(200)).to_string()));
}

/// An image whose channels are the numbers of several materials.
pub fn marks(folder: &Path) {
    write_image(folder, "marks.png", [[40, 0, 0, 0], [60, 0, 255, 0], [255, 128, 128, 0], [128, 250, 0, 0]]);
}

/// A glTF file's texture of metallic and roughness has the image of the scene that is written by hand.
#[test]
fn a_texture_of_gltf_is_that_of_the_scene_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut json, binary) = room();
    json["materials"][2]["pbrMetallicRoughness"] = serde_json::json!({"baseColorFactor": [0.8, 0.7, 0.6, 1], "roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 0}});
    let file = folder.path().join("room.glb");
    std::fs::write(&file, glb(&json, &binary)).expect("it is written");
    let own = folder.path().join("room.ron");
    let text = converted(&file, &own);
    let texture = |factor: &str, channel: &str| {
        format!("Image(path: \"room.glb#images/0\", tint: ({factor}, {factor}, {factor}), channel: {channel})")
    };
    let (metallic, roughness) = (texture("1.0", "B"), texture("0.5", "G"));
    let written =
        format!("Pbr(base_color: Rgb(0.8, 0.7, 0.6), metallic: {metallic}, roughness: {roughness}, ior: 1.5)");
    assert!(text.contains(&written), "{written} is not in {text}");
    let request = Request::spp(8).size(24, 16).mis();
    let all = |scene: &Scene| bits(&render(scene, &request), 0..24);
    let of_gltf = all(&Scene::load(&file).expect("it is read"));
    assert!(of_gltf == all(&scene_in(folder.path(), &text)));
    let swapped = text.replace("channel: B", "channel: R");
    assert!(of_gltf != all(&scene_in(folder.path(), &swapped)), "another channel is not found");
}
