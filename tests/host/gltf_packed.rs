//! glTF files whose data are packed: Draco (two methods), meshopt (two extensions), and Basis Universal (two codecs, one with Zstandard). Other
//! programs made them of one file, a sphere of 80 triangles with an image.

use std::fs;

use base64::Engine;
use gpu_rt::error::Error;
use gpu_rt::scene::{GltfOptions, Mesh, Scene};
use serde_json::{Value, json};

use crate::common::corpus;
use crate::common::gltf as gltf_file;

/// The JSON and the buffer of a file.
fn parts(name: &str) -> (Value, Vec<u8>) {
    let (_, bytes) = corpus::packed().into_iter().find(|(file, _)| file == name).expect("it is there");
    let file = gltf::binary::Glb::from_slice(&bytes).unwrap();
    (serde_json::from_slice(&file.json).unwrap(), file.bin.unwrap().into_owned())
}

fn load((json, buffer): &(Value, Vec<u8>)) -> Result<Scene, Error> {
    gltf_file::load("a.glb", (json, buffer), &GltfOptions::default())
}

/// The bytes of an image of tests/corpus.
fn image(name: &str) -> Vec<u8> {
    corpus::images().into_iter().find(|(file, _)| file == name).expect("it is there").1
}

/// The file before it was packed, with this image instead of its own.
fn with_image(bytes: &[u8]) -> (Value, Vec<u8>) {
    let (mut json, buffer) = parts("plain.glb");
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    json["images"][0] = json!({"uri": format!("data:image/ktx2;base64,{data}")});
    json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    (json, buffer)
}

fn mesh(scene: &Scene) -> &Mesh {
    scene.meshes.values().next().expect("it has a mesh")
}

/// How far the corners of a mesh are from those of another one, of which each triangle must be near one: positions, normals, texture
/// coordinates.
fn distances(mesh: &Mesh, other: &Mesh) -> [f32; 3] {
    let corner = |mesh: &Mesh, at: u32| {
        (mesh.positions[at as usize].as_vec3(), mesh.normals[at as usize].normalize(), mesh.uvs[at as usize])
    };
    let between = |of: &[u32; 3], to: &[u32; 3], turn: usize| {
        let pairs = (0..3).map(|at| (corner(mesh, of[at]), corner(other, to[(at + turn) % 3])));
        pairs.fold([0.0f32; 3], |far, (a, b)| {
            let [p, n, uv] = [(a.0 - b.0).abs().max_element(), (a.1 - b.1).length(), (a.2 - b.2).abs().max_element()];
            [far[0].max(p), far[1].max(n), far[2].max(uv)]
        })
    };
    let nearest = |of: &[u32; 3]| {
        let all = other.triangles.iter().flat_map(|to| (0..3).map(move |turn| (to, turn)));
        all.map(|(to, turn)| between(of, to, turn)).min_by(|a, b| a[0].total_cmp(&b[0])).expect("it has triangles")
    };
    assert_eq!(mesh.triangles.len(), other.triangles.len());
    mesh.triangles.iter().map(nearest).fold([0.0; 3], |a, b| std::array::from_fn(|at| a[at].max(b[at])))
}

#[test]
fn packed_meshes_are_those_that_were_packed() {
    // Half a step h of 14 bits over the box of side 2, and of 12 bits over the image, and roundings. Of a normal, x and y on the octahedron
    // |x| + |y| + |z| = 1 are off by h and z by 2h, together √6 h; and the octahedron is 1/√3 or more from the centre.
    let draco = [1.01 / f32::from(1u16 << 14), 18f32.sqrt() * 0.5 / 511.0, 0.51 / 4095.0];
    // Here the numbers of 14 and 12 bits are rounded to integers of 16 first: by 2 and 8 of their steps, and half a one.
    let meshopt = [2.51 / 32767.0, 18f32.sqrt() * 0.5 / 127.0, 8.51 / 65535.0];
    let exact = [1e-6; 3];
    let plain = load(&parts("plain.glb")).unwrap();
    for (name, allowed) in
        [("draco.glb", draco), ("sequential.glb", draco), ("meshopt.glb", meshopt), ("khr.glb", exact)]
    {
        let scene = load(&parts(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let is_near = |mesh: &Mesh| {
            let found = distances(mesh, self::mesh(&plain));
            println!("{name}: {found:?} of {allowed:?}");
            found.iter().zip(allowed).all(|(found, allowed)| *found <= allowed)
        };
        let mut mesh = mesh(&scene).clone();
        assert!(is_near(&mesh), "{name}");
        // A control each: one vertex is off by twice as much, or two corners are exchanged.
        mesh.positions[7].y += f64::from(2.0 * allowed[0]);
        assert!(!is_near(&mesh), "{name}");
        mesh.positions[7].y -= f64::from(2.0 * allowed[0]);
        mesh.uvs[7].y += 2.0 * allowed[2];
        assert!(!is_near(&mesh), "{name}");
        mesh.uvs[7].y -= 2.0 * allowed[2];
        mesh.triangles[7].swap(0, 1);
        assert!(!is_near(&mesh), "{name}");
    }
}

#[test]
fn packed_images_are_those_that_were_packed() {
    let files = [parts("plain.glb"), with_image(&image("etc1s.ktx2")), with_image(&image("uastc.ktx2"))];
    let [plain, etc1s, uastc] = files.map(|file| {
        let scene = load(&file).unwrap_or_else(|error| panic!("{error}"));
        let image = scene.bitmaps.colours("a.glb#images/0").expect("it has an image");
        assert_eq!((image.width, image.height), (16, 16));
        image.texels().collect::<Vec<_>>()
    });
    let mean = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
        differences.sum::<f32>() / (3 * a.len()) as f32
    };
    // The means are those of Basis Universal's own decoder. The control: an image that is a texel off.
    for (texels, expected) in [(etc1s, 0.040_846_48), (uastc, 0.002_499_383)] {
        let moved = [&texels[1..], &texels[..1]].concat();
        let is_it = |texels: &[[f32; 3]]| (mean(texels, &plain) - expected).abs() < 1e-6;
        assert!(is_it(&texels) && !is_it(&moved), "{}", mean(&texels, &plain));
    }
}

/// Streams that end early, claim more than they have, or are of another kind: an error with the place in the JSON.
#[test]
fn what_cannot_be_unpacked_is_refused_with_its_place() {
    let draco = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    let view = "bufferViews[1].extensions.EXT_meshopt_compression";
    let packed = |field: &str| format!("/bufferViews/1/extensions/EXT_meshopt_compression/{field}");
    let of_primitive = |field: &str| format!("/meshes/0/primitives/0{field}");
    for (name, pointer, value, at, reason) in [
        ("draco.glb", "/bufferViews/1/byteLength".to_owned(), json!(500), draco, ""),
        ("draco.glb", "/bufferViews/1/byteLength".to_owned(), json!(5000), draco, "bufferView 1 reaches past the end"),
        ("draco.glb", of_primitive("/indices"), json!(99), draco, "an accessor is not there"),
        ("draco.glb", of_primitive("/indices"), Value::Null, draco, "expected indices"),
        ("draco.glb", of_primitive("/extensions/KHR_draco_mesh_compression"), json!({}), draco, "bufferView"),
        ("meshopt.glb", packed("byteLength"), json!(90), view, ""),
        ("meshopt.glb", packed("byteOffset"), json!(u64::MAX), view, "reaches past the end of its buffer"),
        ("meshopt.glb", packed("count"), json!(1u64 << 40), view, "103 bytes cannot become 2199023255552"),
        ("meshopt.glb", packed("count"), json!(u64::MAX), view, "103 bytes cannot become"),
        ("meshopt.glb", packed("byteStride"), json!(0), view, ""),
        ("meshopt.glb", packed("mode"), json!("LINES"), view, "LINES"),
        ("meshopt.glb", packed("filter"), json!("COLOUR"), view, "COLOUR"),
    ] {
        let (json, buffer) = parts(name);
        gltf_file::is_refused(load(&(gltf_file::changed(json, &pointer, value), buffer)), at, reason);
    }
    for (at, reason) in
        [(96, "expected at most 256 bytes of blocks"), (20, "expected a width and height from 1 to 16384")]
    {
        let mut damaged = image("uastc.ktx2");
        damaged[at..at + 4].fill(0x7f);
        gltf_file::is_refused(load(&with_image(&damaged)), "images[0]", reason);
    }
}

/// Programs that do not unpack use other data: buffers that are not read here, and another image of a texture.
#[test]
fn what_is_for_other_programs_is_not_read() {
    let (mut json, buffer) = parts("khr.glb");
    assert_eq!(json["buffers"][1]["extensions"]["KHR_meshopt_compression"]["fallback"], true);
    json["buffers"][1]["uri"] = json!("there is none.bin");
    assert!(load(&(json.clone(), buffer.clone())).is_ok());
    // As a .gltf, it names the files that it is read from.
    let folder = tempfile::tempdir().unwrap();
    let mut named = json.clone();
    named["buffers"][0]["uri"] = json!("own.bin");
    fs::write(folder.path().join("own.bin"), &buffer).unwrap();
    fs::write(folder.path().join("a.gltf"), named.to_string()).unwrap();
    let inputs = Scene::load(&folder.path().join("a.gltf")).unwrap().inputs();
    let names: Vec<_> = inputs.iter().map(|path| path.file_name().unwrap().to_string_lossy()).collect();
    assert!(names.contains(&"own.bin".into()) && !names.contains(&"there is none.bin".into()), "{names:?}");
    json["buffers"][1]["extensions"] = json!({});
    assert!(load(&(json, buffer)).is_err_and(|error| error.to_string().contains("there is none.bin")));
    let (mut json, buffer) = with_image(&image("etc1s.ktx2"));
    json["textures"][0]["source"] = json!(1);
    json["images"].as_array_mut().unwrap().push(json!({"uri": "there is none.png"}));
    assert!(load(&(json, buffer)).is_ok());
}
