//! A small scene as a glTF file, which tests change.

use std::f64::consts::FRAC_PI_4;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde_json::{Value, json};

/// A PNG of 2 by 2 pixels.
pub fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([255 * x as u8, 255 * y as u8, 100]));
    pixels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    bytes
}

/// A square from (-1, -1, 0) to (1, 1, 0), four times: with an image, mirrored, as a lamp above, and turned and scaled. Two cameras.
/// The binary chunk holds positions, normals, two sets of texture coordinates, indices and the image.
pub fn room() -> (Value, Vec<u8>) {
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let parts = [
        floats(&[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.]),
        floats(&[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.]),
        floats(&[0., 1., 1., 1., 1., 0., 0., 0.]),
        floats(&[0., 0.5, 0.5, 0.5, 0.5, 0., 0., 0.]),
        [0u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()).collect(),
        png(),
    ];
    let (mut binary, mut views) = (Vec::new(), Vec::new());
    for part in parts {
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": part.len()}));
        binary.extend(part);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let square = |material: usize| {
        json!({"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3}, "indices": 4, "material": material}]})
    };
    let accessor = |view: usize, kind: &str, count: usize, of: usize| json!({"bufferView": view, "componentType": of, "count": count, "type": kind});
    let json = json!({
        "asset": {"version": "2.0", "generator": "a test"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3, 4, 5]}],
        "nodes": [
            {"mesh": 0},
            {"mesh": 0, "name": "mirrored", "scale": [-1.0, 1.0, 1.0], "translation": [2.5, 0.0, 0.0]},
            {"mesh": 1, "rotation": [1.0, 0.0, 0.0, 1.0], "translation": [0.0, 4.0, 0.0]},
            {"mesh": 2, "rotation": [0.0, 1.0, 0.0, 1.0], "translation": [-3.0, 0.0, 0.0], "scale": [2.0, 2.0, 2.0]},
            {"camera": 0, "name": "Front", "translation": [0.0, 1.0, 8.0]},
            {"camera": 1, "name": "Left", "translation": [-8.0, 1.0, 0.0], "rotation": [0.0, -1.0, 0.0, 1.0]}
        ],
        "cameras": [
            {"type": "perspective", "name": "Wide", "perspective": {"yfov": FRAC_PI_4, "aspectRatio": 1.6, "znear": 0.1}},
            {"type": "perspective", "perspective": {"yfov": 1.2, "znear": 0.1}}
        ],
        "meshes": [square(0), square(1), square(2)],
        "materials": [
            {"name": "Wood", "doubleSided": true, "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.6, 0.7, 1.0], "metallicFactor": 0.0, "baseColorTexture": {"index": 0}}},
            {"name": "Lamp", "emissiveFactor": [1.0, 0.9, 0.8], "doubleSided": true,
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10.0}},
                "pbrMetallicRoughness": {"baseColorFactor": [0.0, 0.0, 0.0, 1.0]}},
            {"name": "Steel", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.7, 0.6, 1.0], "roughnessFactor": 0.0}}
        ],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 5, "mimeType": "image/png"}],
        "accessors": [accessor(0, "VEC3", 4, 5126), accessor(1, "VEC3", 4, 5126), accessor(2, "VEC2", 4, 5126),
            accessor(3, "VEC2", 4, 5126), accessor(4, "SCALAR", 6, 5123)],
        "bufferViews": views,
        "buffers": [{"byteLength": binary.len()}]
    });
    (json, binary)
}

/// The file as GLB.
pub fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let words = |numbers: &[usize]| numbers.iter().flat_map(|&n| (n as u32).to_le_bytes()).collect::<Vec<_>>();
    bytes.extend(words(&[2, 28 + json.len() + binary.len(), json.len()]));
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend(words(&[binary.len()]));
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

/// The file as JSON with its buffer in base64.
pub fn gltf(json: &Value, binary: &[u8]) -> String {
    let mut json = json.clone();
    json["buffers"][0]["uri"] = format!("data:;base64,{}", BASE64.encode(binary)).into();
    json.to_string()
}

/// A square from (-1, -1, 0) to (1, 1, 0) with these attributes of its four corners, of so many floats each, and one material. Its images are
/// files beside it.
pub fn square(attributes: &[(&str, usize, &[f32])], material: &Value, images: &[&str]) -> (Value, Vec<u8>) {
    let corners: &[f32] = &[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];
    let (mut binary, mut views, mut accessors, mut names) = (Vec::new(), Vec::new(), Vec::new(), json!({}));
    for &(name, width, numbers) in [("POSITION", 3, corners)].iter().chain(attributes) {
        names[name] = accessors.len().into();
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": 4 * numbers.len()}));
        let view = views.len() - 1;
        accessors.push(json!({"bufferView": view, "componentType": 5126, "count": numbers.len() / width, "type": format!("VEC{width}")}));
        binary.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    }
    let indices = [0u16, 1, 2, 0, 2, 3];
    views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": 12}));
    accessors.push(json!({"bufferView": views.len() - 1, "componentType": 5123, "count": 6, "type": "SCALAR"}));
    binary.extend(indices.iter().flat_map(|x| x.to_le_bytes()));
    let sources: Vec<Value> = (0..images.len()).map(|image| json!({"source": image})).collect();
    let uris: Vec<Value> = images.iter().map(|name| json!({"uri": name})).collect();
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1], "translation": [0, 0, -9]}],
        "meshes": [{"primitives": [{"attributes": names, "indices": accessors.len() - 1, "material": 0}]}],
        "materials": [material], "textures": sources, "images": uris,
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": binary.len()}]
    });
    (json, binary)
}
