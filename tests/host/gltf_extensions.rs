//! glTF files with KHR_materials_unlit, EXT_mesh_gpu_instancing and EXT_texture_webp: what they become, and what is refused with its path in the JSON.

use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::{DQuat, DVec3};
use gpu_rt::error::Error;
use gpu_rt::scene::{Background, GltfOptions, Object, Scene, Transform};
use serde_json::{Value, json};

use crate::common::gltf::{self, Parts, glb, png, room, square, webp, written};

fn load(json: &Value, binary: &[u8]) -> Result<Scene, Error> {
    gltf::load("a.glb", (json, binary), &GltfOptions::default())
}

fn good(json: &Value, binary: &[u8]) -> Scene {
    load(json, binary).unwrap_or_else(|error| panic!("{error}"))
}

/// Checks that a file is refused with this path in its JSON.
fn refused(json: &Value, binary: &[u8], at: &str, reason: &str) {
    gltf::is_refused(load(json, binary), at, reason);
}

/// The material of a square with these properties beside KHR_materials_unlit, and the notes on it. `colours` are those of its corners.
fn unlit(more: Value, colours: &[f32]) -> (Scene, Vec<String>) {
    let mut material = json!({"name": "sign", "extensions": {"KHR_materials_unlit": {}}});
    material.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    let attributes: &[(&str, usize, &[f32])] = if colours.is_empty() { &[] } else { &[("COLOR_0", 4, colours)] };
    let (mut json, mut binary) = square(attributes, &material, &[]);
    let image = png();
    json["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": image.len()}));
    binary.extend(&image);
    json["buffers"][0]["byteLength"] = binary.len().into();
    json["images"] =
        json!([{"bufferView": json["bufferViews"].as_array().unwrap().len() - 1, "mimeType": "image/png"}]);
    json["textures"] = json!([{"source": 0}]);
    json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    json["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    let scene = good(&json, &binary);
    let notes = scene.warnings().iter().filter(|note| note.contains("sign")).map(|note| note.to_string()).collect();
    (scene, notes)
}

#[test]
fn an_unlit_material_emits_its_base_colour() {
    let of = |more: Value, colours: &[f32]| {
        let (scene, notes) = unlit(more, colours);
        assert_eq!(notes, Vec::<String>::new());
        scene.materials[0].1.clone()
    };
    let base = |more: Value| json!({"pbrMetallicRoughness": more});
    let plain = base(json!({"baseColorFactor": [0.5, 0.25, 1, 1]}));
    assert_eq!(of(plain, &[]), written("DiffuseLight(emit: Rgb(0.5, 0.25, 1))"));
    assert_eq!(of(json!({}), &[]), written("DiffuseLight(emit: Rgb(1, 1, 1))"));
    // Nothing else of a material counts.
    let image = "Image(path: \"a.glb#images/0\", tint: (0.5, 1, 1))";
    let all = json!({
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 0.5], "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}, "normalTexture": {"index": 0}, "occlusionTexture": {"index": 0},
        "extensions": {"KHR_materials_unlit": {}, "KHR_materials_transmission": {"transmissionFactor": 0.75}, "KHR_materials_ior": {"ior": 0.5},
            "KHR_materials_clearcoat": {"clearcoatFactor": 1}},
    });
    assert_eq!(of(all.clone(), &[]), written(&format!("DiffuseLight(emit: {image})")));
    // With its alpha, and with colours and alphas of vertices.
    let mut cut_out = all;
    cut_out["alphaMode"] = json!("MASK");
    let alpha = "alpha: Image(path: \"a.glb#images/0\", tint: (0.5, 0.5, 0.5), channel: A), alpha_cutoff: 0.5";
    let expected = format!("Lambertian(albedo: Rgb(0, 0, 0), emission: {image}, {alpha}");
    assert_eq!(of(cut_out.clone(), &[]), written(&format!("{expected})")));
    let colours = [0.5, 1.0, 1.0, 0.25].repeat(4);
    let of_vertices = format!("{expected}, vertex_alpha: true, vertex_emission: true)");
    assert_eq!(of(cut_out, &colours), written(&of_vertices));
    let grey = "Lambertian(albedo: Rgb(0, 0, 0), emission: Rgb(1, 1, 1), vertex_emission: true)";
    assert_eq!(of(json!({}), &colours), written(grey));
    // It is light, unless it is black.
    let background = |factor: Value| unlit(base(json!({"baseColorFactor": factor})), &[]).0.background;
    assert_eq!(background(json!([0.5, 0, 0, 1])), Background::Solid(DVec3::ZERO));
    assert!(matches!(background(json!([0, 0, 0, 1])), Background::Gradient { .. }));
    assert_eq!(of(base(json!({"baseColorFactor": [0, 0, 0, 1]})), &[]), written("Lambertian(albedo: Rgb(0, 0, 0))"));
    // What the file says too much of is cut, and said.
    let (scene, notes) = unlit(base(json!({"baseColorFactor": [2, 0, 0, 1]})), &[]);
    assert_eq!(scene.materials[0].1, written("DiffuseLight(emit: Rgb(1, 0, 0))"));
    assert!(notes.len() == 1 && notes[0].contains("baseColorFactor is clamped to 0 .. 1"), "{notes:?}");
}

/// What `convert` writes has the same materials.
#[test]
fn converted_files_keep_unlit_materials() {
    let (scene, _) = unlit(json!({"alphaMode": "BLEND"}), &[0.5, 1.0, 1.0, 0.25].repeat(4));
    let text = scene.text();
    assert!(text.contains("vertex_alpha: true, vertex_emission: true"), "{text}");
}

/// A triangle with the corners (0, 0, 0), (1, 0, 0) and (0, 1, 0), which a node that is moved by 10 along x has so many times.
struct Instanced {
    json: Value,
    parts: Parts,
}

/// The extension's place in the JSON.
const AT: &str = "nodes[0].extensions.EXT_mesh_gpu_instancing";

impl Instanced {
    fn new() -> Instanced {
        let mut parts = Parts::default();
        let corners = parts.floats(3, &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        let json = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [10, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": corners}}]}],
            "extensionsUsed": ["EXT_mesh_gpu_instancing"], "extensionsRequired": ["EXT_mesh_gpu_instancing"]
        });
        Instanced { json, parts }
    }

    /// With floats as an attribute.
    fn with(mut self, name: &str, width: usize, numbers: &[f32]) -> Instanced {
        let accessor = self.parts.floats(width, numbers);
        self.attribute(name, accessor.into());
        self
    }

    fn attribute(&mut self, name: &str, accessor: Value) {
        self.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"][name] = accessor;
    }

    /// With the bytes of a rotation of this type.
    fn rotated(mut self, component: u32, normalized: bool, bytes: &[u8]) -> Instanced {
        let accessor = self.parts.bytes(1, bytes);
        self.attribute("ROTATION", accessor.into());
        let mut file = self.complete();
        let size = if component == 5122 { 8 } else { 4 };
        file.json["accessors"][accessor] = json!({"bufferView": accessor, "componentType": component, "normalized": normalized,
            "count": bytes.len() / size, "type": "VEC4"});
        file
    }

    fn complete(mut self) -> Instanced {
        self.parts.complete(&mut self.json);
        self
    }

    fn scene(&self) -> Scene {
        good(&self.json, &self.parts.binary)
    }

    fn refused(&self, at: &str, reason: &str) {
        refused(&self.json, &self.parts.binary, at, reason);
    }

    /// A scene whose only object is this mesh of the file.
    fn as_a_mesh(&self, path: &str) -> Result<Scene, Error> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.glb"), glb(&self.json, &self.parts.binary)).unwrap();
        let text = format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((1, 1, 1)), materials: {{\"a\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
            objects: [Mesh(path: {path:?}, material: \"a\")])"
        );
        Scene::parse(&text, &folder.path().join("a.ron"))
    }
}

/// The corners of each object's triangle in the scene, to 1e-6, and the names of the meshes.
fn corners(scene: &Scene) -> (Vec<[[f64; 3]; 3]>, Vec<String>) {
    let of = |object: &Object| {
        let (by, object) = match object {
            Object::Transformed { by, object } => (by.clone(), object.as_ref()),
            other => (Vec::new(), other),
        };
        let Object::Mesh { path, .. } = object else { panic!("{object:?}") };
        let moved = |p: &DVec3| {
            by.iter().fold(*p, |p, transform| match transform {
                Transform::Scale(by) => *by * p,
                Transform::Rotate { axis, degrees } => DQuat::from_axis_angle(*axis, degrees.to_radians()) * p,
                Transform::Translate(by) => *by + p,
                other => panic!("{other:?}"),
            })
        };
        let mesh = &scene.meshes[path];
        let corners = mesh.triangles[0].map(|corner| moved(&mesh.positions[corner as usize]));
        let rounded = corners.map(|p| p.to_array().map(|x| (1e6 * x).round() / 1e6 + 0.0));
        (rounded, path.clone())
    };
    scene.objects.iter().map(of).unzip()
}

#[test]
fn instances_are_placed_by_the_node_and_their_own_transforms() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let file = Instanced::new()
        .with("TRANSLATION", 3, &[0., 0., 0., 0., 5., 0.])
        .with("ROTATION", 4, &[0., 0., 0., 1., 0., 0., half, half])
        .with("SCALE", 3, &[1., 1., 1., 2., 2., 2.])
        .complete();
    let scene = file.scene();
    let (found, names) = corners(&scene);
    // The second is turned by a quarter about z, which takes x to y and y to -x.
    let expected = [[[10., 0., 0.], [11., 0., 0.], [10., 1., 0.]], [[10., 5., 0.], [10., 7., 0.], [8., 5., 0.]]];
    assert_eq!(found, expected);
    // They share the mesh.
    assert_eq!(names, ["a.glb#meshes/0/primitives/0"; 2]);
    assert!(!scene.warnings().join("\n").contains("EXT_mesh"), "{:?}", scene.warnings());

    // One attribute is enough.
    let moved = Instanced::new().with("TRANSLATION", 3, &[1., 2., 3., 4., 5., 6., 7., 8., 9.]).complete();
    let first: Vec<_> = corners(&moved.scene()).0.iter().map(|corners| corners[0]).collect();
    assert_eq!(first, [[11., 2., 3.], [14., 5., 6.], [17., 8., 9.]]);

    // Those that mirror or scale unevenly have meshes of their own.
    let uneven = Instanced::new().with("SCALE", 3, &[1., 3., 1., 2., 2., 2., -1., 1., 1.]).complete();
    let scene = uneven.scene();
    let (found, names) = corners(&scene);
    assert_eq!(found[0], [[10., 0., 0.], [11., 0., 0.], [10., 3., 0.]]);
    assert_eq!(found[1], [[10., 0., 0.], [12., 0., 0.], [10., 2., 0.]]);
    // The mirrored one is wound the other way, so that its outside is that of the others.
    let mut mirrored = found[2];
    mirrored.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(mirrored, [[9., 0., 0.], [10., 0., 0.], [10., 1., 0.]]);
    let own = |instance: usize| format!("a.glb#nodes/0/instances/{instance}/primitives/0");
    assert_eq!(names, [own(0), "a.glb#meshes/0/primitives/0".to_owned(), own(2)]);
    let notes = scene.warnings().join("\n");
    assert!(notes.contains("1 node or instance cannot share a mesh with others"), "{notes}");
    // What `convert` writes names them.
    assert!(scene.text().contains("a.glb#nodes/0/instances/2/primitives/0"), "{}", scene.text());

    // All triangles of the file as one mesh.
    let scene = uneven.as_a_mesh("a.glb").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.meshes["a.glb"].triangles.len(), 3);
}

/// Rotations of 8 and 16 bits. Those whose accessor is not normalized are meant as if it were: a rotation has no length.
#[test]
fn rotations_of_instances_may_be_integers() {
    let shorts = [0i16, 0, 0, 32767, 0, 0, 23170, 23170].map(i16::to_le_bytes);
    let bytes = [0i8, 0, 0, 127, 0, 0, 90, 90].map(|x| x as u8);
    for (component, normalized, rotations) in
        [(5122, true, shorts.as_flattened()), (5122, false, shorts.as_flattened()), (5120, true, &bytes[..])]
    {
        let file = Instanced::new().rotated(component, normalized, rotations);
        let expected = [[[10., 0., 0.], [11., 0., 0.], [10., 1., 0.]], [[10., 0., 0.], [10., 1., 0.], [9., 0., 0.]]];
        let (found, _) = corners(&file.scene());
        let pairs = found.as_flattened().as_flattened().iter().zip(expected.as_flattened().as_flattened());
        // Both numbers of the quarter turn are the same code, so that it is exact whatever their rounding.
        let off = pairs.map(|(a, b): (&f64, &f64)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{component}: {found:?}");
    }
}

#[test]
fn broken_instances_are_refused_with_their_path_in_the_json() {
    let two = || Instanced::new().with("TRANSLATION", 3, &[0., 0., 0., 1., 0., 0.]);
    let at = |attribute: &str| format!("{AT}.attributes{attribute}");
    let turned = two().with("ROTATION", 4, &[0., 0., 0., 1.]).complete();
    turned.refused(&at(".ROTATION"), "expected 2 elements, as TRANSLATION has, found 1");
    let scaled = two().with("SCALE", 2, &[1., 1., 1., 1.]).complete();
    scaled.refused(&at(".SCALE"), "expected an accessor of type VEC3, found VEC2");
    two().with("ROTATION", 4, &[0., 0., 0., 1., 0., 0., 0., 0.]).complete().refused(&at(""), "instance 1: expected");
    two().with("SCALE", 3, &[1., f32::NAN, 1., 1., 1., 1.]).complete().refused(&at(""), "instance 0: expected");
    for (value, reason) in [
        (json!("x"), "expected the number of an accessor"),
        (json!(-1), "expected the number of an accessor"),
        (json!(1.5), "expected the number of an accessor"),
        (json!(u64::MAX), "expected the number of an accessor"),
        (json!(77), "there is no accessor 77"),
    ] {
        let mut file = two().complete();
        file.attribute("SCALE", value);
        file.refused(&at(".SCALE"), reason);
    }
    for extension in [json!(null), json!(7), json!({}), json!({"attributes": [0]}), json!({"attributes": 0})] {
        let mut file = two().complete();
        file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = extension;
        file.refused(&at(""), "expected an object");
    }
    let mut others = two().complete();
    others.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = json!({"attributes": {"_ID": 1}});
    others.refused(&at(""), "expected a TRANSLATION, a ROTATION or a SCALE");
    let mut far = two().complete();
    far.json["accessors"][1]["count"] = json!(3);
    far.refused(&at(".TRANSLATION"), "reaches past the end");
    far.json["accessors"][1]["count"] = json!(u64::MAX);
    far.refused(&at(""), "expected at most 1048576 instances");
    // A part that the file does not have.
    for (part, expected) in [("nodes/0/instances/2", "there is no instance 2"), ("nodes/0/instances/1", "")] {
        let found = two().complete().as_a_mesh(&format!("a.glb#{part}/primitives/0"));
        let error = found.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(expected) && error.is_empty() == expected.is_empty(), "{part}: {error}");
    }
}

/// Nodes may share the accessors of their instances, so that few bytes have many of them.
#[test]
fn a_file_has_a_bounded_number_of_instances() {
    let count = 1 << 12;
    let of = |nodes: usize| {
        let mut file = Instanced::new().with("TRANSLATION", 3, &vec![0.5; 3 * count]).complete();
        let node = file.json["nodes"][0].clone();
        file.json["nodes"] = vec![node; nodes].into();
        file.json["scenes"][0]["nodes"] = (0..nodes).collect::<Vec<_>>().into();
        file
    };
    let reason = "expected at most 1048576 instances of primitives, found more";
    of(257).refused("nodes[256].extensions.EXT_mesh_gpu_instancing", reason);
    assert_eq!(of(2).scene().objects.len(), 2 * count);
}

/// A skin ignores the transform of its node, and what instances of it would be, the extension does not say.
#[test]
fn instances_beside_a_skin_are_named_and_not_read() {
    let mut file = Instanced::new().with("TRANSLATION", 3, &[0., 0., 0., 1., 0., 0.]).complete();
    file.json["nodes"][0]["skin"] = json!(0);
    file.json["nodes"].as_array_mut().unwrap().push(json!({}));
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    file.json["skins"] = json!([{"joints": [1]}]);
    let scene = file.scene();
    assert_eq!(scene.objects.len(), 1);
    let notes = scene.warnings().join("\n");
    assert!(notes.contains("nodes[0]: EXT_mesh_gpu_instancing is not read beside a skin"), "{notes}");
}

/// The room, whose image is a PNG with a WebP beside it, as this source of the extension and this image.
fn with_webp(source: Value, image: Value) -> Value {
    let mut json = room().0;
    json["textures"] = json!([{"source": 0, "extensions": {"EXT_texture_webp": {"source": source}}}]);
    json["images"].as_array_mut().unwrap().push(image);
    json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    json
}

const RED: [u8; 3] = [255, 51, 0];

#[test]
fn webp_images_replace_those_of_programs_that_do_not_read_them() {
    let (mut json, mut binary) = room();
    let picture = webp(2, 2, |_, _| RED);
    let data = json!({"uri": format!("data:image/webp;base64,{}", BASE64.encode(&picture))});
    let red_of = |json: &Value, binary: &[u8], path: &str| {
        let scene = good(json, binary);
        assert!(!scene.warnings().join("\n").contains("webp"), "{:?}", scene.warnings());
        scene.bitmaps.colours(path).unwrap_or_else(|| panic!("{path} is not read")).texel(0)
    };
    let expected = red_of(&with_webp(json!(1), data.clone()), &binary, "a.glb#images/1");
    assert!(expected[0] == 1.0 && (expected[1] - 0.033_105).abs() < 1e-6 && expected[2] == 0.0, "{expected:?}");
    // In a view of the buffer, and without an image for other programs.
    let view = json["bufferViews"].as_array().unwrap().len();
    let in_view = json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": picture.len()});
    json = with_webp(json!(1), json!({"bufferView": view, "mimeType": "image/webp"}));
    json["bufferViews"].as_array_mut().unwrap().push(in_view);
    json["textures"][0].as_object_mut().unwrap().remove("source");
    binary.extend(&picture);
    json["buffers"][0]["byteLength"] = binary.len().into();
    assert_eq!(red_of(&json, &binary, "a.glb#images/1"), expected);
    // An extension without a source leaves the texture's own.
    let mut empty = with_webp(json!(1), data);
    empty["textures"][0]["extensions"]["EXT_texture_webp"] = json!({});
    assert_ne!(red_of(&empty, &binary, "a.glb#images/0"), expected);
}

#[test]
fn broken_webp_is_refused_with_its_path_in_the_json() {
    let binary = room().1;
    let picture = webp(2, 2, |_, _| RED);
    let data = |bytes: &[u8]| json!({"uri": format!("data:image/webp;base64,{}", BASE64.encode(bytes))});
    let at = "textures[0].extensions.EXT_texture_webp.source";
    for source in [json!("1"), json!(-1), json!(0.5), json!(null), json!({})] {
        refused(&with_webp(source, data(&picture)), &binary, at, "expected the number of an image");
    }
    refused(&with_webp(json!(2), data(&picture)), &binary, at, "there is no image 2");
    refused(&with_webp(json!(u64::MAX), data(&picture)), &binary, at, "there is no image");
    let cut = &picture[..picture.len() - 3];
    refused(&with_webp(json!(1), data(cut)), &binary, "images[1]", "it is not complete");
    let mut wrong = picture.clone();
    wrong[16..].fill(0xff);
    refused(&with_webp(json!(1), data(&wrong)), &binary, "images[1]", "cannot decode the image");
    refused(&with_webp(json!(1), json!({"uri": "data:image/webp,x"})), &binary, "images[1]", "expected ;base64,");
}
