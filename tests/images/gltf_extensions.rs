//! Images of glTF files with KHR_materials_unlit, EXT_mesh_gpu_instancing and EXT_texture_webp.

use std::path::Path;

use gpu_rt::film::Picture;
use gpu_rt::options::{LightPaths, Scatter};
use gpu_rt::scene::Scene;
use serde_json::{Value, json};

use crate::common::gltf::{Parts, converted, glb, square, webp};
use crate::common::kernel::Overlay;
use crate::common::render::{Request, render, render_planted, same_expectation, scene_in};

const SIDE: u32 = 16;

/// A square from (-1, -1, 0) to (1, 1, 0) that fills the image, with another light than its own.
fn lit(folder: &Path, light: &str) -> Scene {
    let text = format!(
        "Scene(image: (width: {SIDE}, height: {SIDE}), camera: (look_from: (0, 0, 20), look_at: (0, 0, 0), vertical_fov: {}),
        background: Solid((0, 0, 0)), materials: {{\"lamp\": DiffuseLight(emit: Rgb(9, 9, 9)), \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
        objects: [Gltf(path: \"square.glb\"), {light}], render: (samples: 16, max_depth: 4))",
        2.0 * (1.0f64 / 20.0).atan().to_degrees()
    );
    scene_in(folder, &text)
}

const SUN: &str = "DirectionalLight(direction: (-0.3, -0.2, -1), irradiance: (3, 3, 3))";
const LAMP: &str = "Quad(corner: (2, -1, -1), u: (0, 2, 0), v: (0, 0, 2), material: \"lamp\")";

/// Writes the square with these attributes and this material; without a mirrored copy of it.
fn write_square(folder: &Path, attributes: &[(&str, usize, &[f32])], material: &Value, images: &[&str]) -> Value {
    let (mut json, binary) = square(attributes, material, images);
    json["scenes"][0]["nodes"] = json!([0]);
    std::fs::write(folder.join("square.glb"), glb(&json, &binary)).expect("it is written");
    json
}

/// The largest difference of a pixel from what is expected at its middle, which is at (x, y) of the square, each from 0 at the lower left.
fn off(picture: &Picture, expected: impl Fn(f64, f64) -> [f64; 3]) -> f64 {
    let middle = |index: usize| (index as f64 + 0.5) / f64::from(SIDE);
    let of = |(pixel, rgb): (usize, &[f32; 3])| {
        let side = SIDE as usize;
        let expected = expected(middle(pixel % side), 1.0 - middle(pixel / side));
        (0..3).map(|c| (f64::from(rgb[c]) - expected[c]).abs()).fold(0.0, f64::max)
    };
    picture.rgb.iter().enumerate().map(of).fold(0.0, f64::max)
}

/// What is unlit shows its base colour in any light, from both sides, by every way to link the stages.
#[test]
fn unlit_surfaces_show_their_base_colour_in_any_light() {
    let folder = tempfile::tempdir().expect("a folder");
    let material = |unlit: bool| {
        let base = json!({"baseColorFactor": [0.25, 0.5, 0.75, 1], "metallicFactor": 0});
        let extensions = if unlit { json!({"KHR_materials_unlit": {}}) } else { json!({}) };
        json!({"pbrMetallicRoughness": base, "emissiveFactor": [1, 1, 1], "extensions": extensions})
    };
    let expected = |_: f64, _: f64| [0.25, 0.5, 0.75];
    for light in [SUN, LAMP, ""] {
        write_square(folder.path(), &[], &material(true), &[]);
        let scene = lit(folder.path(), light);
        for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
            let found = off(&render(&scene, &Request::spp(4).mis().sobol().scatter(scatter)).picture, expected);
            // The mean of 4 equal f32 is exact.
            assert!(found == 0.0, "{light}: {found}");
        }
        // The control: the same square, lit.
        write_square(folder.path(), &[], &material(false), &[]);
        let found = off(&render(&lit(folder.path(), light), &Request::spp(4).mis()).picture, expected);
        assert!(found > 0.1, "{light}: it is not found: {found}");
    }
}

/// Colours of the corners that are red from the left to the right, and green from below: the colour at (x, y) is (x, y, 1).
fn corner_colours() -> [f32; 12] {
    [0., 0., 1., 1., 0., 1., 1., 1., 1., 0., 1., 1.]
}

fn by_vertices() -> Value {
    json!({"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1]}, "extensions": {"KHR_materials_unlit": {}}})
}

#[test]
fn unlit_surfaces_have_the_colours_of_their_vertices() {
    let folder = tempfile::tempdir().expect("a folder");
    write_square(folder.path(), &[("COLOR_0", 3, &corner_colours())], &by_vertices(), &[]);
    let scene = lit(folder.path(), LAMP);
    let expected = |x: f64, y: f64| [x, 0.5 * y, 0.25];
    const SAMPLES: u32 = 256;
    // Where in a pixel a ray falls: six standard errors of the mean, of 512 means; and the steps of 1/65535 of the colours.
    let most = 6.0 / f64::from(SIDE) / (12.0 * f64::from(SAMPLES)).sqrt() + 1e-5;
    for request in [Request::spp(SAMPLES), Request::spp(SAMPLES).mis()] {
        let found = off(&render(&scene, &request).picture, expected);
        assert!(found < most, "{found}, {most}");
        let planted = Overlay::new(&[])
            .rewritten("scene/vertices", |own| own.replace("colour_of_vertex(face.y)", "colour_of_vertex(face.x)"));
        assert!(off(&render_planted(&scene, &request, &planted).picture, expected) > 10.0 * most);
    }
    // The control: without the colours.
    write_square(folder.path(), &[], &by_vertices(), &[]);
    assert!(off(&render(&lit(folder.path(), LAMP), &Request::spp(4)).picture, expected) > 10.0 * most);
}

/// A floor in the light of an unlit square with colours of its vertices: the same by scattered rays alone, by light sampling, and by light paths.
#[test]
fn unlit_surfaces_light_others_as_they_look() {
    let folder = tempfile::tempdir().expect("a folder");
    write_square(folder.path(), &[("COLOR_0", 3, &corner_colours())], &by_vertices(), &[]);
    let text = format!(
        "Scene(image: (width: {SIDE}, height: {SIDE}), camera: (look_from: (0, 1.5, 5), look_at: (0, -0.5, 0.5), vertical_fov: 30),
        background: Solid((0, 0, 0)), materials: {{\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
            \"mirror\": Metal(albedo: Rgb(0.9, 0.9, 0.9))}},
        objects: [Gltf(path: \"square.glb\"), Quad(corner: (-2, -1, 3), u: (4, 0, 0), v: (0, 0, -4), material: \"grey\"),
            Quad(corner: (2, -1, 3), u: (0, 0, -4), v: (0, 1, 0), material: \"mirror\")],
        render: (samples: 16, max_depth: 4))"
    );
    let scene = scene_in(folder.path(), &text);
    let by_bsdf = render(&scene, &Request::spp(4096));
    let sampled = [
        Request::spp(2048).mis().seed(2),
        Request::spp(2048).mis().sobol().seed(3).scatter(Scatter::Queues),
        Request::spp(2048).mis().seed(4).with(|options| options.light_paths = LightPaths::Count(1)),
    ];
    for request in &sampled {
        same_expectation(&by_bsdf, &render(&scene, request), 1e-6, 1e-6)
            .unwrap_or_else(|difference| panic!("{difference}"));
    }
    // Shadow rays that do not see the colours of the vertices.
    let planted = Overlay::new(&[]).rewritten("scene/emitted_by_extension", |own| {
        own.replace(
            "times_vertex_emission(colour_of_light(row, hit, framed), hit, surface)",
            "colour_of_light(row, hit, framed)",
        )
    });
    let found = same_expectation(&by_bsdf, &render_planted(&scene, &sampled[0], &planted), 1e-6, 1e-6);
    assert!(found.is_err(), "it is not found");
}

/// The bits of the image of a file.
fn bits(folder: &Path, json: &Value, binary: &[u8]) -> Vec<u32> {
    let path = folder.join("many.glb");
    std::fs::write(&path, glb(json, binary)).expect("it is written");
    bits_of(&path)
}

fn bits_of(path: &Path) -> Vec<u32> {
    let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
    render(&scene, &Request::spp(4).mis().sobol().size(24, 16)).bits()
}

/// A node with instances renders to the bytes of one that has a child for each. Powers of two and quarter turns, so that products of transforms are exact;
/// one of them mirrors, and one scales unevenly.
#[test]
fn instances_render_to_the_bytes_of_nodes() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut parts = Parts::default();
    let corners = parts.floats(3, &[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]);
    let faces = parts.bytes(1, &[0, 1, 2, 0, 2, 3]);
    let translations: [[f32; 3]; 4] = [[0., 0., 0.], [2.5, 0.5, -1.], [-2.5, 0.25, 0.5], [0.5, 2., -2.]];
    let rotations: [[f32; 4]; 4] = [[0., 0., 0., 1.], [0., 0., 1., 0.], [0., 1., 0., 0.], [0., 0., 0., 1.]];
    let scales: [[f32; 3]; 4] = [[1., 1., 1.], [0.5, 0.5, 0.5], [-0.5, 0.5, 0.5], [2., 0.5, 1.]];
    let translation = parts.floats(3, translations.as_flattened());
    let rotation = parts.floats(4, rotations.as_flattened());
    let scale = parts.floats(3, scales.as_flattened());
    let mut json = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0.5, 0, 0], "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
            {"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale}}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": corners}, "indices": faces, "material": 0}]}],
        "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.7, 0.9, 1]}}],
        "extensionsUsed": ["EXT_mesh_gpu_instancing"]
    });
    parts.complete(&mut json);
    let found = bits(folder.path(), &json, &parts.binary);
    // With the last one shifted along x: if all were, the camera of a file without one would follow.
    let by_nodes = |shift: f32| {
        let child = |index: usize| {
            let [x, y, z] = translations[index];
            let x = if index == 3 { x + shift } else { x };
            json!({"mesh": 0, "translation": [x, y, z], "rotation": rotations[index], "scale": scales[index]})
        };
        let mut json = json.clone();
        json["nodes"] =
            json!([{"translation": [0.5, 0, 0], "children": [1, 2, 3, 4]}, child(0), child(1), child(2), child(3)]);
        bits(folder.path(), &json, &parts.binary)
    };
    assert!(found == by_nodes(0.0), "instances are not what their nodes are");
    assert!(found != by_nodes(0.01), "another place is not found");
    // And so does what `convert` writes of it.
    bits(folder.path(), &json, &parts.binary);
    let [from, to] = ["many.glb", "many.ron"].map(|name| folder.path().join(name));
    converted(&from, &to);
    assert!(found == bits_of(&to), "the converted scene is another");
}

/// The four quarters of a WebP on an unlit square, beside a PNG for other programs.
#[test]
fn the_texels_of_webp_are_those_that_are_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let colours = [[255, 0, 51], [0, 255, 102], [51, 102, 255], [204, 204, 0]];
    let quarter = |x: u32, y: u32| colours[2 * (y / 16) as usize + (x / 16) as usize];
    std::fs::write(folder.path().join("a.webp"), webp(32, 32, quarter)).expect("it is written");
    let grey = image::RgbImage::from_pixel(2, 2, image::Rgb([128; 3]));
    grey.save(folder.path().join("a.png")).expect("it is written");
    let material =
        json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}});
    let uvs = [0., 1., 1., 1., 1., 0., 0., 0.];
    let (mut json, binary) = square(&[("TEXCOORD_0", 2, &uvs)], &material, &["a.png", "a.webp"]);
    json["scenes"][0]["nodes"] = json!([0]);
    let plain = json.clone();
    json["textures"][0]["extensions"] = json!({"EXT_texture_webp": {"source": 1}});
    let shown = |json: &Value| {
        std::fs::write(folder.path().join("square.glb"), glb(json, &binary)).expect("it is written");
        render(&lit(folder.path(), SUN), &Request::spp(4).mis()).picture
    };
    let linear = |code: u8| {
        let x = f64::from(code) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    // Pixels whose rays are nowhere near the edge of a quarter, where texels are blended.
    let expected = |x: f64, y: f64| {
        let quarter = 2 * usize::from(y < 0.5) + usize::from(x > 0.5);
        let is_inside = |x: f64| (0.1..0.4).contains(&x) || (0.6..0.9).contains(&x);
        (is_inside(x) && is_inside(y)).then(|| colours[quarter].map(linear))
    };
    let worst = |picture: &Picture| {
        let mut seen = 0;
        let middle = |index: usize| (index as f64 + 0.5) / f64::from(SIDE);
        let mut worst = 0.0f64;
        for (pixel, rgb) in picture.rgb.iter().enumerate() {
            let (x, y) = (middle(pixel % SIDE as usize), 1.0 - middle(pixel / SIDE as usize));
            let Some(expected) = expected(x, y) else { continue };
            seen += 1;
            worst = (0..3).map(|c| (f64::from(rgb[c]) - expected[c]).abs()).fold(worst, f64::max);
        }
        assert!(seen > 60, "{seen}");
        worst
    };
    let found = worst(&shown(&json));
    // Linear texels are f32, and so are the sums of four of them.
    assert!(found < 1e-6, "{found}");
    assert!(worst(&shown(&plain)) > 0.1, "the image for other programs is not found");
}
