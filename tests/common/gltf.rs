//! A small scene as a glTF file, which tests change.

use std::f64::consts::FRAC_PI_4;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use gpu_rt::error::Error;
use gpu_rt::scene::{Assets, GltfOptions, Material, Scene};
use serde_json::{Value, json};

/// The scene of a file of this name.
pub fn load(name: &str, (json, binary): (&Value, &[u8]), options: &GltfOptions) -> Result<Scene, Error> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, glb(json, binary)).expect("it is written");
    Scene::load_as(&path, options, &mut |_, _, _| {}, &mut Assets::default())
}

/// The scene file that `convert` makes of a file, which is written.
pub fn converted(from: &Path, to: &Path) -> String {
    let scene = Scene::of_model(from, to, &GltfOptions::default(), &mut Assets::default());
    let text = scene.unwrap_or_else(|error| panic!("{error}")).text();
    std::fs::write(to, &text).expect("it is written");
    text
}

/// Checks that a file is refused with this path in its JSON.
pub fn is_refused(found: Result<Scene, Error>, at: &str, reason: &str) {
    let error = found.err().unwrap_or_else(|| panic!("{at} was accepted"));
    assert_eq!(error.exit_status(), 2);
    // Where several parts share what is broken, each is listed.
    let Error::Scene { location, field, message } = &error.each()[0] else { panic!("{error}") };
    assert_eq!((location.line, field.as_str()), (0, at), "{error}");
    assert!(message.contains(reason) && error.to_string().contains(&format!(": {at}: ")), "{reason}: {error}");
    assert!(!message.contains("gave up"), "a library has panicked: {error}");
}

/// A material as a scene file writes it.
pub fn written(material: &str) -> Material {
    let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(material).unwrap_or_else(|error| panic!("{material}: {error}"))
}

/// A PNG of 2 by 2 pixels.
pub fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([255 * x as u8, 255 * y as u8, 100]));
    pixels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    bytes
}

/// A lossless WebP of these colours.
pub fn webp(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels = image::RgbImage::from_fn(width, height, |x, y| image::Rgb(pixel(x, y)));
    pixels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::WebP).unwrap();
    bytes
}

/// The corners of a square from (-1, -1, 0) to (1, 1, 0), and its two faces.
const SQUARE: [f32; 12] = [-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];
const FACES: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A square from (-1, -1, 0) to (1, 1, 0), four times: with an image, mirrored, as a lamp above, and turned and scaled. Two cameras.
/// The binary chunk holds positions, normals, two sets of texture coordinates, indices and the image.
pub fn room() -> (Value, Vec<u8>) {
    let mut parts = Parts::default();
    parts.floats(3, &SQUARE);
    parts.floats(3, &[0., 0., 1.].repeat(4));
    parts.floats(2, &[0., 1., 1., 1., 1., 0., 0., 0.]);
    parts.floats(2, &[0., 0.5, 0.5, 0.5, 0.5, 0., 0., 0.]);
    parts.shorts(&FACES);
    let image = parts.view(&png());
    let square = |material: usize| {
        json!({"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "TEXCOORD_1": 3}, "indices": 4, "material": material}]})
    };
    let mut json = json!({
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
        "images": [{"bufferView": image, "mimeType": "image/png"}]
    });
    parts.complete(&mut json);
    (json, parts.binary)
}

/// JSON with another value at a pointer.
pub fn changed(mut json: Value, pointer: &str, value: Value) -> Value {
    let (parent, last) = pointer.rsplit_once('/').unwrap();
    match json.pointer_mut(parent).unwrap_or_else(|| panic!("there is no {parent}")) {
        Value::Array(list) => list[last.parse::<usize>().unwrap()] = value,
        parent => parent[last] = value,
    }
    json
}

/// The place of a pointer as errors write it: `/nodes/0/mesh` is nodes[0].mesh.
pub fn place(pointer: &str) -> String {
    let part = |part: &str| if part.parse::<u32>().is_ok() { format!("[{part}]") } else { format!(".{part}") };
    pointer.split('/').skip(1).map(part).collect::<String>().trim_start_matches('.').to_owned()
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
    let mut parts = Parts::default();
    let mut names = json!({});
    for &(name, width, numbers) in [("POSITION", 3, &SQUARE[..])].iter().chain(attributes) {
        names[name] = parts.floats(width, numbers).into();
    }
    let indices = parts.shorts(&FACES);
    let sources: Vec<Value> = (0..images.len()).map(|image| json!({"source": image})).collect();
    let uris: Vec<Value> = images.iter().map(|name| json!({"uri": name})).collect();
    let mut json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1], "translation": [0, 0, -9]}],
        "meshes": [{"primitives": [{"attributes": names, "indices": indices, "material": 0}]}],
        "materials": [material], "textures": sources, "images": uris
    });
    parts.complete(&mut json);
    (json, parts.binary)
}

/// A glTF file that is put together accessor by accessor.
#[derive(Default)]
pub struct Parts {
    pub binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    /// An accessor of floats; the result is its number. `width` is that of an element: 1 to 4, or 16.
    pub fn floats(&mut self, width: usize, numbers: &[f32]) -> usize {
        let bytes = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(bytes, 5126, (width, numbers.len() / width))
    }

    /// An accessor of bytes.
    pub fn bytes(&mut self, width: usize, numbers: &[u8]) -> usize {
        self.accessor(numbers.to_vec(), 5121, (width, numbers.len() / width))
    }

    /// An accessor of numbers of 16 bits.
    pub fn shorts(&mut self, numbers: &[u16]) -> usize {
        self.accessor(numbers.iter().flat_map(|x| x.to_le_bytes()).collect(), 5123, (1, numbers.len()))
    }

    /// An accessor of numbers of 32 bits.
    pub fn words(&mut self, numbers: &[u32]) -> usize {
        self.accessor(numbers.iter().flat_map(|x| x.to_le_bytes()).collect(), 5125, (1, numbers.len()))
    }

    /// A part of the buffer; the result is its number.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()}));
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: Vec<u8>, component: usize, (width, count): (usize, usize)) -> usize {
        let kind = match width {
            1 => "SCALAR".to_owned(),
            16 => "MAT4".to_owned(),
            width => format!("VEC{width}"),
        };
        let view = self.view(&bytes);
        self.accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    /// Gives a file its accessors.
    pub fn complete(&self, json: &mut Value) {
        json["accessors"] = self.accessors.clone().into();
        json["bufferViews"] = self.views.clone().into();
        json["buffers"] = json!([{"byteLength": self.binary.len()}]);
    }
}

/// A file in which things move from 0 s to 1 s: node 0 is a strip of two quads along y whose upper end follows node 2, which turns by a
/// quarter about z; node 3 is a square that moves by 2 along x, turns by a quarter about z and doubles its size; node 4 is a square whose
/// morph target lifts it by 1 along z, from the weight 0 to 1; node 5 is a camera that moves by 1 along y, and node 6 a lamp that moves
/// by 4 along x.
pub fn moving() -> (Value, Vec<u8>) {
    let mut parts = Parts::default();
    let strip = parts.floats(3, &[-0.5, 0., 0., 0.5, 0., 0., -0.5, 1., 0., 0.5, 1., 0., -0.5, 2., 0., 0.5, 2., 0.]);
    let strip_normals = parts.floats(3, &[0., 0., 1.].repeat(6));
    let joints = parts.bytes(4, &[0, 1, 0, 0].repeat(6));
    let weights = [[1., 0., 0., 0.].repeat(2), [0.5, 0.5, 0., 0.].repeat(2), [0., 1., 0., 0.].repeat(2)].concat();
    let weights = parts.floats(4, &weights);
    let strip_faces = parts.bytes(1, &[0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4]);
    let matrix = |y: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., y, 0., 1.];
    let inverse = parts.floats(16, &[matrix(0.), matrix(-1.)].concat());
    let square = parts.floats(3, &SQUARE);
    let normals = parts.floats(3, &[0., 0., 1.].repeat(4));
    let faces = parts.bytes(1, &[0, 1, 2, 0, 2, 3]);
    let lifts = parts.floats(3, &[0., 0., 1.].repeat(4));
    let tilts = parts.floats(3, &[0., 1., -1.].repeat(4));
    let times = parts.floats(1, &[0., 1.]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let quarter = parts.floats(4, &[0., 0., 0., 1., 0., 0., half, half]);
    let to_right = parts.floats(3, &[0., 0., 0., 2., 0., 0.]);
    let doubled = parts.floats(3, &[1., 1., 1., 2., 2., 2.]);
    let lifted = parts.floats(1, &[0., 1.]);
    let raised = parts.floats(3, &[0., 1., 8., 0., 2., 8.]);
    let shifted = parts.floats(3, &[-2., 4., 2., 2., 4., 2.]);
    let outputs = [
        (2, "rotation", quarter),
        (3, "translation", to_right),
        (3, "rotation", quarter),
        (3, "scale", doubled),
        (4, "weights", lifted),
        (5, "translation", raised),
        (6, "translation", shifted),
    ];
    let channel = |(sampler, (node, path, _)): (usize, &(usize, &str, usize))| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    let sampler = |(_, _, output): &(usize, &str, usize)| json!({"input": times, "output": output});
    let mut json = json!({
        "asset": {"version": "2.0", "generator": "a test"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 3, 4, 5, 6]}],
        "nodes": [
            {"mesh": 0, "skin": 0, "translation": [7.0, 0.0, 0.0]},
            {"children": [2], "name": "lower"},
            {"translation": [0.0, 1.0, 0.0], "name": "upper"},
            {"mesh": 1},
            {"mesh": 2, "translation": [0.0, -2.0, 0.0]},
            {"camera": 0, "translation": [0.0, 1.0, 8.0]},
            {"translation": [-2.0, 4.0, 2.0], "extensions": {"KHR_lights_punctual": {"light": 0}}}
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": FRAC_PI_4, "aspectRatio": 1.6, "znear": 0.1}}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": inverse}],
        "meshes": [
            {"primitives": [{
                "attributes": {"POSITION": strip, "NORMAL": strip_normals, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": strip_faces}]},
            {"primitives": [{"attributes": {"POSITION": square, "NORMAL": normals}, "indices": faces}]},
            {"primitives": [{
                "attributes": {"POSITION": square, "NORMAL": normals}, "indices": faces,
                "targets": [{"POSITION": lifts, "NORMAL": tilts}]}]}
        ],
        "animations": [{
            "name": "all",
            "channels": outputs.iter().enumerate().map(channel).collect::<Vec<_>>(),
            "samplers": outputs.iter().map(sampler).collect::<Vec<_>>()
        }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 300}]}}
    });
    parts.complete(&mut json);
    (json, parts.binary)
}

/// The file of [`moving`] at a share of its second, as somebody would write its pose by hand: without animations.
pub fn posed(share: f64) -> (Value, Vec<u8>) {
    let (mut json, binary) = moving();
    json.as_object_mut().unwrap().remove("animations");
    let f = |x: f64| x as f32;
    let (sin, cos) = (share * FRAC_PI_4).sin_cos();
    let turn = json!([0.0, 0.0, f(sin), f(cos)]);
    json["nodes"][2]["rotation"] = turn.clone();
    json["nodes"][3]["translation"] = json!([f(2.0 * share), 0.0, 0.0]);
    json["nodes"][3]["rotation"] = turn;
    json["nodes"][3]["scale"] = json!(vec![f(1.0 + share); 3]);
    json["nodes"][4]["weights"] = json!([f(share)]);
    json["nodes"][5]["translation"] = json!([0.0, f(1.0 + share), 8.0]);
    json["nodes"][6]["translation"] = json!([f(-2.0 + 4.0 * share), 4.0, 2.0]);
    (json, binary)
}
