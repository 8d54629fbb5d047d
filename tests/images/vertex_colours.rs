//! Colours of a mesh's vertices: they multiply the colour of the material.

use std::path::Path;

use gpu_rt::scene::Scene;
use serde_json::json;

use crate::common::gltf::gltf;
use crate::common::kernel::Overlay;
use crate::common::render::{Ask, render, render_planted, scene_in};

const WIDTH: u32 = 16;

/// A square from (-1, -1, 0) to (1, 1, 0) with these colours at its corners, counter-clockwise from the lower left, as codes of 8 bits. The
/// material reflects the light of all directions alike.
fn square(folder: &Path, colours: [[u8; 4]; 4]) {
    let corners: [f32; 12] = [-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];
    let mut binary: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    binary.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    binary.extend(colours.as_flattened());
    let json = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 1, 1, 1]},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": true}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
            {"buffer": 0, "byteOffset": 60, "byteLength": 16}],
        "buffers": [{"byteLength": binary.len()}]
    });
    std::fs::write(folder.join("square.gltf"), gltf(&json, &binary)).expect("the file is written");
}

/// It fills the image.
fn scene_of(folder: &Path, object: &str) -> Scene {
    let text = format!(
        "Scene(image: (width: {WIDTH}, height: {WIDTH}), camera: (look_from: (0, 0, 20), look_at: (0, 0, 0), vertical_fov: {}),
        background: Solid((1, 1, 1)), materials: {{\"plain\": Lambertian(albedo: Rgb(0.1, 0.4, 1))}},
        objects: [{object}], render: (samples: 256, max_depth: 1))",
        2.0 * (1.0f64 / 20.0).atan().to_degrees()
    );
    scene_in(folder, &text)
}

#[test]
fn one_colour_at_all_vertices_is_that_of_a_material() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    square(folder.path(), [[51, 102, 255, 255]; 4]);
    let coloured = scene_of(folder.path(), "Gltf(path: \"square.gltf\")");
    let plain = scene_of(folder.path(), "Mesh(path: \"square.gltf#meshes/0/primitives/0\", material: \"plain\")");
    for ask in [Ask::spp(16), Ask::spp(16).mis().sobol()] {
        let [coloured, plain] = [&coloured, &plain].map(|scene| render(scene, &ask).picture.rgb);
        let pairs = coloured.as_flattened().iter().zip(plain.as_flattened());
        let off = pairs.map(|(a, b)| (a - b).abs() / b).fold(0.0, f32::max);
        assert!(off < 1e-6, "{off}");
    }
}

#[test]
fn colours_are_interpolated() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (black, white) = ([0, 0, 0, 255], [255; 4]);
    square(folder.path(), [black, white, white, black]);
    let scene = scene_of(folder.path(), "Gltf(path: \"square.gltf\")");
    // Where in a pixel a ray falls: five standard errors of the mean of 256.
    let most = 5.0 / f64::from(WIDTH) / (12.0f64 * 256.0).sqrt() + 1e-6;
    let off = |shot: &gpu_rt::film::Picture| {
        let at = |(pixel, rgb): (usize, &[f32; 3])| {
            let expected = (pixel as f64 % f64::from(WIDTH) + 0.5) / f64::from(WIDTH);
            let [red, others @ ..] = rgb.map(f64::from);
            others
                .map(|x| (x - expected).abs())
                .into_iter()
                .chain([2.0 * (red - 0.5 * expected).abs()])
                .fold(0.0, f64::max)
        };
        shot.rgb.iter().enumerate().map(at).fold(0.0, f64::max)
    };
    let found = off(&render(&scene, &Ask::spp(256)).picture);
    assert!(found < most, "{found}, {most}");
    let planted = Overlay::new(&[])
        .rewritten("scene/meshes", |own| own.replace("colour_of_vertex(face.y)", "colour_of_vertex(face.x)"));
    assert!(off(&render_planted(&scene, &Ask::spp(256), &planted).picture) > 10.0 * most);
}
