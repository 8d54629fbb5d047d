//! Colours of a mesh's vertices: they multiply the colour of the material, and their alpha its alpha.

use std::path::Path;

use gpu_rt::scene::Scene;
use serde_json::{Value, json};

use crate::common::everything::same;
use crate::common::gltf::{converted, gltf};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, render, render_planted, same_expectation, scene_in};

const WIDTH: u32 = 16;

/// A square from (-1, -1, 0) to (1, 1, 0) with these colours at its corners, counter-clockwise from the lower left, as codes of 8 bits. The
/// material reflects the light of all directions alike.
fn square(folder: &Path, colours: [[u8; 4]; 4]) {
    square_with(folder, colours, json!({}));
}

/// The square with these properties of its material beside.
fn square_with(folder: &Path, colours: [[u8; 4]; 4], more: Value) {
    let corners: [f32; 12] = [-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];
    let mut binary: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    binary.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    binary.extend(colours.as_flattened());
    let mut json = json!({
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
    for (name, value) in more.as_object().expect("properties") {
        json["materials"][0][name] = value.clone();
    }
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
    for request in [Request::spp(16), Request::spp(16).mis().sobol()] {
        let [coloured, plain] = [&coloured, &plain].map(|scene| render(scene, &request).picture.rgb);
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
    let found = off(&render(&scene, &Request::spp(256)).picture);
    assert!(found < most, "{found}, {most}");
    let planted = Overlay::new(&[])
        .rewritten("scene/vertices", |own| own.replace("colour_of_vertex(face.y)", "colour_of_vertex(face.x)"));
    assert!(off(&render_planted(&scene, &Request::spp(256), &planted).picture) > 10.0 * most);
}

/// The share of the white sky that passes each column of the image, with its standard error. The square itself is black.
fn passed(scene: &Scene, request: &Request, planted: Option<&Overlay>) -> [f64; WIDTH as usize] {
    let shot = planted.map_or_else(|| render(scene, request), |planted| render_planted(scene, request, planted));
    let rgb = shot.picture.rgb;
    let column = |x: usize| rgb.iter().skip(x).step_by(WIDTH as usize).map(|rgb| f64::from(rgb[1])).sum::<f64>();
    std::array::from_fn(|x| column(x) / f64::from(WIDTH))
}

/// A black square, whose alpha is multiplied by that of its vertices.
fn black(mode: &str, factor: f64) -> Value {
    json!({"alphaMode": mode, "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0, 0, 0, factor]}})
}

const SAMPLES: u32 = 256;
/// Six standard errors of the mean of a column, of rays that pass or are stopped: one of 300 columns is off by that once in 2e6 runs.
const NOISE: f64 = 6.0 * 0.5 / 64.0;
const _: () = assert!(WIDTH * SAMPLES == 64 * 64);

/// The largest difference of columns from what is expected of them.
fn difference(found: [f64; WIDTH as usize], expected: impl Fn(f64) -> f64) -> f64 {
    let middle = |x: usize| (x as f64 + 0.5) / f64::from(WIDTH);
    let off = found.into_iter().enumerate().map(|(x, share)| (share - expected(middle(x))).abs());
    off.fold(0.0, f64::max)
}

#[test]
fn the_alpha_of_vertices_multiplies_that_of_the_material() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let object = "Gltf(path: \"square.gltf\")";
    let of = |[left, right]: [u8; 2], material: Value| {
        let [left, right] = [left, right].map(|alpha| [255, 255, 255, alpha]);
        square_with(folder.path(), [left, right, right, left], material);
        scene_of(folder.path(), object)
    };
    let asks = [Request::spp(SAMPLES), Request::spp(SAMPLES).mis().sobol()];
    let near = |scene: &Scene, expected: &dyn Fn(f64) -> f64, what: &str| {
        for request in &asks {
            let off = difference(passed(scene, request, None), expected);
            assert!(off < NOISE, "{what}: {off}");
        }
    };
    near(&of([102, 102], black("BLEND", 1.0)), &|_| 0.6, "one alpha");
    near(&of([102, 102], black("BLEND", 0.5)), &|_| 0.8, "times a factor");
    near(&of([0, 255], black("BLEND", 1.0)), &|x| 1.0 - x, "interpolated");
    near(&of([0, 255], black("BLEND", 0.25)), &|x| 1.0 - 0.25 * x, "interpolated, times a factor");
    // The cutoff is compared with the product. It is reached in the middle of the image, and at a quarter.
    let half = |edge: f64| move |x: f64| if x < edge { 1.0 } else { 0.0 };
    near(&of([0, 255], black("MASK", 1.0)), &half(0.5), "cut out");
    let mut quarter = black("MASK", 0.5);
    quarter["alphaCutoff"] = json!(0.125);
    near(&of([0, 255], quarter), &half(0.25), "cut out of a product");
    near(&of([0, 255], black("OPAQUE", 0.5)), &|_| 0.0, "opaque");
    near(&of([255, 255], black("BLEND", 0.5)), &|_| 0.5, "an alpha of 1");

    // A material of the scene file itself.
    square_with(folder.path(), [[255, 255, 255, 0], [255; 4], [255; 4], [255, 255, 255, 0]], black("BLEND", 1.0));
    let own = |more: &str| {
        let part = "Mesh(path: \"square.gltf#meshes/0/primitives/0\", material: \"plain\")";
        let mut scene = scene_of(folder.path(), part);
        let text = format!("Lambertian(albedo: Rgb(0, 0, 0){more})");
        scene.materials[0].1 = ron::from_str(&text).expect("a material");
        scene
    };
    near(
        &own(", vertex_colors: true, vertex_alpha: true, alpha: Rgb(0.5, 0.5, 0.5)"),
        &|x| 1.0 - 0.5 * x,
        "its own material",
    );
    near(
        &own(", vertex_colors: true, alpha: Rgb(0.5, 0.5, 0.5)"),
        &|_| 0.5,
        "its own material, without that of vertices",
    );

    // The alphas of two corners exchanged.
    let scene = of([0, 255], black("BLEND", 1.0));
    let planted = Overlay::new(&[])
        .rewritten("scene/vertices", |own| own.replace("alpha_of_vertex(face.y)", "alpha_of_vertex(face.x)"));
    assert!(difference(passed(&scene, &asks[0], Some(&planted)), |x| 1.0 - x) > 3.0 * NOISE, "it is not found");
}

/// With colours, texture coordinates and light of its own, in a scene file that `convert` writes too.
#[test]
fn the_alpha_of_vertices_changes_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let colours = [[200, 20, 10, 20], [40, 200, 90, 255], [250, 240, 20, 128], [0, 0, 255, 200]];
    let emissive = json!({"alphaMode": "BLEND", "emissiveFactor": [0.5, 0.25, 1]});
    square_with(folder.path(), colours, emissive);
    let file = folder.path().join("square.gltf");
    let to = folder.path().join("converted.ron");
    let text = converted(&file, &to);
    assert!(text.contains("vertex_colors: true, vertex_alpha: true"), "{text}");
    let [glb, ron] = [&file, &to].map(|path| Scene::load(path).expect("it is read"));
    let [glb, ron] = [glb, ron].map(|scene| render(&scene, &Request::spp(8).mis().sobol().roulette().size(16, 12)));
    assert!(same(&glb, &ron));
    // Light is sampled on it where its alpha is.
    let scene = scene_of(
        folder.path(),
        "Gltf(path: \"square.gltf\"), Quad(corner: (-2, -2, -1), u: (4, 0, 0), v: (0, 4, 0), material: \"plain\")",
    );
    let shot = |request: Request| render(&scene, &request);
    let by_bsdf = shot(Request::spp(1024));
    for sampled in [shot(Request::spp(1024).mis().seed(2)), shot(Request::spp(1024).mis().sobol().seed(3))] {
        same_expectation(&by_bsdf, &sampled, 1e-6, 1e-6).unwrap_or_else(|difference| panic!("{difference}"));
    }
}
