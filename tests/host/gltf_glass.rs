//! Glass of glTF files: what is solid and what is a pane. Blender's exporter gives no thickness, and Blender renders closed meshes as solids.

use std::fs;
use std::path::Path;

use gpu_rt::scene::{Dielectric, GltfOptions, Material, Object, Pbr, Scene, Texture, Thin, ThinDielectric};
use serde_json::{Value, json};

use crate::common::gltf::{self, Parts, glb};

const BLENDER: &str = "Khronos glTF Blender I/O v5.0.21";
/// What a note says of glass that is solid by its shape, and of a pane.
const SOLID: &str = "read as solid glass, because its mesh is closed";
const PANE: &str = "read as a thin pane, because its mesh has holes";

/// The corners of a cube around the origin.
fn corners() -> Vec<[f32; 3]> {
    (0..8).map(|at| [at & 1, at >> 1 & 1, at >> 2 & 1].map(|bit| bit as f32 - 0.5)).collect()
}

/// Its twelve faces, counter-clockwise seen from outside.
#[rustfmt::skip]
const FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// A primitive: the positions of its vertices, its indices, its mode and its material.
#[derive(Clone)]
struct Part {
    positions: Vec<[f32; 3]>,
    indices: Option<Vec<u32>>,
    mode: u32,
    material: usize,
}

impl Part {
    fn new(positions: Vec<[f32; 3]>, faces: &[[u32; 3]]) -> Part {
        Part { positions, indices: Some(faces.as_flattened().to_vec()), mode: 4, material: 0 }
    }

    fn of_material(self, material: usize) -> Part {
        Part { material, ..self }
    }

    /// With vertices of its own for each face, as exporters split them where normals differ.
    fn split(self) -> Part {
        let indices = self.indices.unwrap_or_default();
        let positions = indices.iter().map(|at| self.positions[*at as usize]).collect();
        Part { positions, indices: None, ..self }
    }
}

fn cube() -> Part {
    Part::new(corners(), &FACES)
}

/// Clear glass, with these properties beside.
fn glass(name: &str, more: Value) -> Value {
    let mut material = json!({"name": name, "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.4}}});
    merge(&mut material, more);
    material
}

fn merge(into: &mut Value, more: Value) {
    match (into, more) {
        (Value::Object(into), Value::Object(more)) => {
            for (name, value) in more {
                merge(into.entry(name).or_insert(Value::Null), value);
            }
        }
        (into, more) => *into = more,
    }
}

/// A file by Blender with a node for each of these meshes, each of several primitives.
fn file(meshes: &[&[Part]], materials: &[Value]) -> (Value, Vec<u8>) {
    let (mut buffers, mut all) = (Parts::default(), Vec::new());
    for mesh in meshes {
        let mut primitives = Vec::new();
        for part in *mesh {
            let positions = buffers.floats(3, part.positions.as_flattened());
            let mut primitive =
                json!({"attributes": {"POSITION": positions}, "mode": part.mode, "material": part.material});
            if let Some(indices) = &part.indices {
                primitive["indices"] = buffers.words(indices).into();
            }
            primitives.push(primitive);
        }
        all.push(json!({"primitives": primitives}));
    }
    let nodes: Vec<Value> = (0..all.len()).map(|mesh| json!({"mesh": mesh})).collect();
    let scene: Vec<usize> = (0..all.len()).collect();
    let mut json = json!({
        "asset": {"version": "2.0", "generator": BLENDER}, "scenes": [{"nodes": scene}], "nodes": nodes, "meshes": all,
        "materials": materials
    });
    buffers.complete(&mut json);
    (json, buffers.binary)
}

fn load_as((json, binary): &(Value, Vec<u8>), thin: Thin) -> Scene {
    let found = gltf::load("glass.glb", (json, binary), &GltfOptions { thin, ..GltfOptions::default() });
    found.unwrap_or_else(|error| panic!("{error}"))
}

/// The names and kinds of the materials, and the notes about them.
fn read_as(file: &(Value, Vec<u8>), thin: Thin) -> (Vec<(String, &'static str)>, Vec<String>) {
    let scene = load_as(file, thin);
    let kinds = scene.materials.iter().map(|(name, material)| (name.clone(), material.name())).collect();
    let reported = scene.warnings().into_iter().filter(|note| note.contains(SOLID) || note.contains(PANE)).collect();
    (kinds, reported)
}

/// Whether one mesh of clear glass is solid, which is reported.
fn is_solid(parts: &[Part], what: &str) -> bool {
    let materials = [glass("Glass", json!({})), json!({"name": "Paint"})];
    of_file(&file(&[parts], &materials), what)
}

fn of_file(file: &(Value, Vec<u8>), what: &str) -> bool {
    let (kinds, reported) = read_as(file, Thin::Auto);
    let (_, kind) = kinds.iter().find(|(name, _)| name == "Glass").unwrap_or_else(|| panic!("{what}: {kinds:?}"));
    let says = |expected: &str| {
        assert!(
            reported.len() == 1 && reported[0].contains(expected) && reported[0].contains("(\"Glass\")"),
            "{what}: {reported:?}"
        );
    };
    match *kind {
        "Dielectric" => says(SOLID),
        "ThinDielectric" => says(PANE),
        other => panic!("{what}: {other}"),
    }
    kind == &"Dielectric"
}

#[test]
fn closed_meshes_of_files_by_blender_are_solid_glass() {
    let paint = |part: Part| part.of_material(1);
    let [upper, lower] = [&FACES[..5], &FACES[5..]].map(|faces| Part::new(corners(), faces));
    assert!(is_solid(&[cube()], "a cube"));
    assert!(is_solid(&[cube().split()], "split vertices"));
    assert!(is_solid(&[upper.clone(), lower.clone()], "two primitives"));
    assert!(is_solid(&[upper.clone().split(), paint(lower.clone())], "a painted part"));
    assert!(!is_solid(std::slice::from_ref(&upper), "a part"));
    assert!(!is_solid(&[Part::new(corners(), &FACES[..11])], "a face is missing"));

    // An edge with both zeros.
    let shifted = |[x, y, z]: [f32; 3]| [x + 0.5, y, z];
    let mut zeros = Part::new(corners().into_iter().map(shifted).collect(), &FACES).split();
    for (at, position) in zeros.positions.iter_mut().enumerate().filter(|(_, position)| position[0] == 0.0) {
        position[0] = if at % 2 == 0 { -0.0 } else { 0.0 };
    }
    assert!(is_solid(&[zeros], "negative zeros"));
    let mut apart = cube().split();
    apart.positions[7][1] = f32::from_bits(apart.positions[7][1].to_bits() + 1);
    assert!(!is_solid(&[apart], "a corner is one bit off"));

    let mut turned = FACES;
    turned[3].swap(0, 1);
    assert!(!is_solid(&[Part::new(corners(), &turned)], "a face is turned"));
    turned = FACES;
    turned.iter_mut().for_each(|face| face.swap(0, 1));
    assert!(is_solid(&[Part::new(corners(), &turned)], "inside out"));
    let with_flat = [FACES.as_slice(), &[[0, 0, 1], [3, 7, 3]]].concat();
    assert!(is_solid(&[Part::new(corners(), &with_flat)], "faces without area"));
    // A bubble in the glass, and a body beside it.
    let inner = |scale: f32, by: f32| corners().into_iter().map(|corner| corner.map(|x| scale * x + by)).collect();
    assert!(is_solid(&[cube(), Part::new(inner(0.5, 0.0), &turned)], "a bubble"));
    assert!(is_solid(&[cube(), Part::new(inner(1.0, 3.0), &FACES)], "two bodies"));

    // Two coincident sheets have no volume; a thin body has one.
    let sheet = |x: f32| corners().into_iter().map(|[_, y, z]| [x, y, z]).collect::<Vec<_>>();
    let sheets = [[0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
    assert!(!is_solid(&[Part::new(sheet(0.3), &sheets)], "two sheets"));
    let flat: Vec<_> = corners().into_iter().map(|[x, y, z]| [1e-6 * x, y, z]).collect();
    assert!(is_solid(&[Part::new(flat, &FACES)], "a thin body"));
}

#[test]
fn all_forms_of_meshes_are_examined() {
    // A tetrahedron as a strip, and a pyramid of a fan and a square.
    let tetrahedron = vec![[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.]];
    let strip = Part { positions: tetrahedron, indices: Some(vec![0, 1, 2, 3, 0, 1]), mode: 5, material: 0 };
    assert!(is_solid(std::slice::from_ref(&strip), "a strip"));
    assert!(!is_solid(&[Part { indices: Some(vec![0, 1, 2, 3, 0]), ..strip }], "a part of a strip"));
    let square = [[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]];
    let positions = [&[[0., 0., 1.]], square.as_slice(), &square[..1]].concat();
    let fan = Part { positions, indices: None, mode: 6, material: 0 };
    let base = Part::new(square.to_vec(), &[[0, 2, 1], [0, 3, 2]]);
    assert!(is_solid(&[fan.clone(), base.clone()], "a fan and its base"));
    assert!(!is_solid(&[fan], "a fan"));
    // Edges without faces are no part of it.
    let lines = Part { positions: corners(), indices: Some(vec![0, 7]), mode: 1, material: 0 };
    assert!(is_solid(&[cube(), lines], "lines"));

    let materials = [glass("Glass", json!({}))];
    let (json, mut binary) = file(&[&[cube()]], &materials);
    let view = |bytes: Vec<u8>, json: &mut Value, binary: &mut Vec<u8>| {
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len()}));
        binary.extend(bytes);
        json["buffers"][0]["byteLength"] = binary.len().into();
        json["bufferViews"].as_array().unwrap().len() - 1
    };
    // A sparse accessor puts a corner at its position.
    let mut apart = cube().split();
    let right = std::mem::replace(&mut apart.positions[7], [9.0; 3]);
    let (mut sparse, mut own) = file(&[&[apart]], &materials);
    let indices = view(vec![7, 0, 0, 0], &mut sparse, &mut own);
    let values = view(right.iter().flat_map(|x| x.to_le_bytes()).collect(), &mut sparse, &mut own);
    assert!(!of_file(&(sparse.clone(), own.clone()), "a corner elsewhere"));
    sparse["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}});
    assert!(of_file(&(sparse, own), "a sparse accessor"));
    // Positions of 16 bits, and indices of 8.
    let mut quantised = json;
    let codes = corners().as_flattened().iter().flat_map(|x| ((x * 65534.0) as i16).to_le_bytes()).collect();
    let positions = view(codes, &mut quantised, &mut binary);
    let indices = view(FACES.as_flattened().iter().map(|at| *at as u8).collect(), &mut quantised, &mut binary);
    quantised["accessors"] = json!([
        {"bufferView": positions, "componentType": 5122, "normalized": true, "count": 8, "type": "VEC3"},
        {"bufferView": indices, "componentType": 5121, "count": 36, "type": "SCALAR"}]);
    quantised["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    assert!(of_file(&(quantised, binary), "quantised positions"));

    // Defects are reported where the mesh is read, as with other materials.
    let mut broken = cube();
    broken.positions[3][1] = f32::NAN;
    let (json, binary) = file(&[&[broken]], &materials);
    let error = gltf::load("broken.glb", (&json, &binary), &GltfOptions::default()).unwrap_err().to_string();
    assert!(error.contains("expected finite coordinates"), "{error}");
}

#[test]
fn glass_of_a_file_is_what_it_says_and_else_what_its_shape_says() {
    let volume = |thickness: f64| json!({"extensions": {"KHR_materials_volume": {"thicknessFactor": thickness}}});
    let [closed, open] = [FACES.as_slice(), &FACES[..11]].map(|faces| [Part::new(corners(), faces)]);
    let read = |parts: &[Part], more: Value, generator: &str, thin| {
        let mut file = file(&[parts], &[glass("Glass", more)]);
        file.0["asset"]["generator"] = generator.into();
        let (kinds, reported) = read_as(&file, thin);
        (kinds[0].1, reported.len())
    };
    const SOLID: &str = "Dielectric";
    const PANE: &str = "ThinDielectric";
    for (parts, more, generator, thin, expected) in [
        (&closed, json!({}), BLENDER, Thin::Auto, (SOLID, 1)),
        (&open, json!({}), BLENDER, Thin::Auto, (PANE, 1)),
        // By the letter.
        (&closed, json!({}), BLENDER, Thin::Pane, (PANE, 0)),
        (&closed, volume(0.5), BLENDER, Thin::Pane, (SOLID, 0)),
        (&closed, json!({}), "another program", Thin::Auto, (PANE, 0)),
        (&open, volume(0.5), "another program", Thin::Auto, (SOLID, 0)),
        // The file gives a thickness, which may be that of a pane.
        (&closed, volume(0.5), BLENDER, Thin::Auto, (SOLID, 0)),
        (&open, volume(0.5), BLENDER, Thin::Auto, (SOLID, 0)),
        (&closed, volume(0.0), BLENDER, Thin::Auto, (PANE, 0)),
        // Backface Culling says nothing of glass.
        (&closed, json!({"doubleSided": true}), BLENDER, Thin::Auto, (SOLID, 1)),
        (
            &closed,
            json!({"pbrMetallicRoughness": {"roughnessFactor": 0.3}}),
            BLENDER,
            Thin::Auto,
            ("RoughDielectric", 1),
        ),
    ] {
        assert_eq!(read(parts, more.clone(), generator, thin), expected, "{more} {generator} {thin:?}");
    }
}

/// A share of a body is of the body: its base colour counts at both surfaces, which is said.
#[test]
fn a_share_of_transmission_is_mixed() {
    for (share, kind) in [(1.0, "Dielectric"), (0.5, "Pbr"), (0.1, "Pbr"), (0.0, "Pbr")] {
        let transmission = json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": share}},
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1]}});
        let scene = load_as(&file(&[&[cube()]], &[glass("Glass", transmission)]), Thin::Auto);
        let material = &scene.materials[0].1;
        assert_eq!(material.name(), kind, "{share}");
        if let Material::Pbr(Pbr { transmission, solid, .. }) = material {
            assert_eq!((transmission, *solid), (&Texture::grey(share), share > 0.0));
        }
        let notes = scene.warnings().join("\n");
        let is_said = notes.contains("the base colour tints light at both surfaces");
        assert_eq!(is_said, share > 0.0 && share < 1.0, "{notes}");
    }
}

#[test]
fn a_material_of_closed_and_open_meshes_becomes_two() {
    let names = |scene: &Scene| {
        let all = scene.materials.iter().map(|(name, material)| format!("{name}: {}", material.name()));
        let mut of_objects = Vec::new();
        scene.visit_objects(&mut |_, object| of_objects.extend(object.material().map(str::to_owned)));
        (all.collect::<Vec<_>>(), of_objects)
    };
    let open = Part::new(corners(), &FACES[..11]);
    let [closed, open] = [[cube()], [open]];
    let parts: [&[Part]; 4] = [&closed, &open, &closed, &open];
    let both = file(&parts, &[glass("Glass", json!({"occlusionTexture": {"index": 0}}))]);
    let scene = load_as(&both, Thin::Auto);
    let (all, of_objects) = names(&scene);
    assert_eq!(all, ["Glass: Dielectric", "Glass (pane): ThinDielectric"]);
    assert_eq!(of_objects, ["Glass", "Glass (pane)", "Glass", "Glass (pane)"]);
    let notes = scene.warnings().join("\n");
    assert!(notes.contains(SOLID) && notes.contains(PANE), "{notes}");
    assert_eq!(notes.matches("not read: occlusionTexture").count(), 1, "{notes}");
    let reversed = file(&[parts[1], parts[0]], &[glass("Glass", json!({}))]);
    assert_eq!(names(&load_as(&reversed, Thin::Auto)).0, ["Glass: ThinDielectric", "Glass (solid): Dielectric"]);
    // By the letter it is one.
    assert_eq!(names(&load_as(&both, Thin::Pane)).0, ["Glass: ThinDielectric"]);

    // Nodes that mirror have meshes of their own, and the same glass.
    let mut mirrored = file(&parts[..1], &[glass("Glass", json!({}))]);
    mirrored.0["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 2], "translation": [3, 0, 0]}]);
    mirrored.0["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = load_as(&mirrored, Thin::Auto);
    assert_eq!(names(&scene).1, ["Glass", "Glass"]);
    assert!(scene.meshes["glass.glb#nodes/1/primitives/0"].open_edges().is_none());
    assert!(scene.meshes["glass.glb#nodes/1/primitives/0"].volume_is_positive());
}

/// Light through a body passes two surfaces, and in Blender's glass both together have the base colour.
#[test]
fn both_surfaces_of_blenders_glass_have_its_colour_together() {
    let coloured = json!({"pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.64, 1, 1]}});
    let transmittance = |more: Value, generator: &str, thin| {
        let mut own = coloured.clone();
        merge(&mut own, more);
        let mut file = file(&[&[cube()]], &[glass("Glass", own)]);
        file.0["asset"]["generator"] = generator.into();
        match &load_as(&file, thin).materials[0].1 {
            Material::Dielectric(Dielectric { transmittance, .. })
            | Material::ThinDielectric(ThinDielectric { transmittance, .. }) => {
                transmittance.as_ref().and_then(|texture| texture.plain()).map(|colour| colour.to_array())
            }
            other => panic!("{other:?}"),
        }
    };
    let thick = || json!({"extensions": {"KHR_materials_volume": {"thicknessFactor": 1}}});
    let (root, full) = (Some([0.5, 0.8, 1.0]), Some([0.25, 0.64, 1.0]));
    assert_eq!(transmittance(json!({}), BLENDER, Thin::Auto), root);
    assert_eq!(transmittance(thick(), BLENDER, Thin::Auto), root);
    assert_eq!(transmittance(json!({}), BLENDER, Thin::Pane), full);
    assert_eq!(transmittance(thick(), BLENDER, Thin::Pane), full);
    assert_eq!(transmittance(thick(), "another program", Thin::Auto), full);
}

#[test]
fn a_gltf_object_has_a_field_for_thin_glass() {
    let folder = tempfile::tempdir().unwrap();
    let (json, binary) = file(&[&[cube()]], &[glass("Glass", json!({}))]);
    fs::write(folder.path().join("glass.glb"), glb(&json, &binary)).unwrap();
    let scene_of = |object: &str| {
        let text = format!(
            "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
        background: Solid((1, 1, 1)), objects: [{object}])"
        );
        Scene::parse(&text, &folder.path().join("scene.ron"))
    };
    let scene = scene_of("Gltf(path: \"glass.glb\")").unwrap();
    assert_eq!(scene.materials[0].1.name(), "Dielectric");
    assert!(scene.warnings().join("\n").contains("thin: Pane"), "{:?}", scene.warnings());
    let scene = scene_of("Gltf(path: \"glass.glb\", thin: Pane)").unwrap();
    assert_eq!(scene.materials[0].1.name(), "ThinDielectric");
    assert!(scene.text().contains("Gltf(path: \"glass.glb\", thin: Pane)"), "{}", scene.text());
    let error = scene_of("Gltf(path: \"glass.glb\", thin: Solid)").unwrap_err().to_string();
    assert!(error.contains("objects[0].Gltf.thin: ") && error.contains("Auto or Pane"), "{error}");
    assert!(matches!(scene.objects[0], Object::Gltf { thin: Thin::Pane, .. }));
    let options = GltfOptions { thin: Thin::Pane, ..GltfOptions::default() };
    let error = options.refuse(Path::new("scene.ron"), false).unwrap_err().to_string();
    assert!(error.starts_with("--thin is for scenes that are .glb or .gltf: "), "{error}");
}
