//! Scenes that are glTF files: what is read, what is named as not read, and what is refused with its path in the JSON. (Damaged ones: tests/long/fuzz.rs.)

use std::fs;
use std::path::Path;

use base64::Engine;
use glam::DVec3;
use gpu_rt::error::Error;
use gpu_rt::scene::{
    Assets, Background, Camera, Conductor, Dielectric, GltfOptions, Lambertian, Material, Object, Pbr, Projection,
    RoughDielectric, Scene, Sky, Texture, Transform,
};
use serde_json::{Value, json};

use crate::common::gltf::{self, glb, png, room, square, written};

/// The scene of a file with this JSON, and the buffer of the room.
fn load(json: &Value) -> Result<Scene, Error> {
    load_as(json, &GltfOptions::default())
}

fn load_as(json: &Value, options: &GltfOptions) -> Result<Scene, Error> {
    gltf::load("room.glb", (json, &room().1), options)
}

fn changed(pointer: &str, value: Value) -> Value {
    gltf::changed(room().0, pointer, value)
}

/// The warnings, without the name of the file.
fn notes(json: &Value) -> Vec<String> {
    notes_as(json, &GltfOptions::default())
}

fn notes_as(json: &Value, options: &GltfOptions) -> Vec<String> {
    let scene = load_as(json, options).unwrap_or_else(|error| panic!("{error}"));
    let name = scene.inputs()[0].display().to_string();
    scene.warnings().iter().map(|note| note.replace(&format!("{name}: "), "")).collect()
}

fn camera(look_from: DVec3, vertical_fov: f64) -> impl Fn(&Camera) -> bool {
    move |camera| {
        camera.look_from == look_from && camera.vertical_fov.is_some_and(|fov| (fov - vertical_fov).abs() < 1e-5)
    }
}

/// The material of the third square.
fn metal(roughness: f64) -> Material {
    written(&format!("Conductor(albedo: Rgb(0.8, 0.7, 0.6), roughness: {roughness})"))
}

#[test]
fn a_file_becomes_objects_materials_and_a_camera() {
    let scene = load(&room().0).unwrap();
    let names: Vec<&str> = scene.materials.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Wood", "Lamp", "Steel"]);
    let wood = "Pbr(base_color: Image(path: \"room.glb#images/0\", tint: (0.5, 0.6, 0.7)), metallic: 0)";
    assert_eq!(scene.materials[0].1, written(wood));
    assert_eq!(scene.materials[1].1, written("DiffuseLight(emit: Rgb(10, 9, 8))"));
    assert_eq!(scene.materials[2].1, metal(0.0));
    assert_eq!(scene.bitmaps.colours("room.glb#images/0").unwrap().texel(3), [1.0, 1.0, 0.127_437_68]);

    let mesh = |path: &str| {
        let material = if path.starts_with("meshes/1") {
            "Lamp"
        } else if path.starts_with("meshes/2") {
            "Steel"
        } else {
            "Wood"
        };
        Object::Mesh { path: format!("room.glb#{path}"), material: Some(material.to_owned()) }
    };
    assert_eq!(scene.objects.len(), 4);
    assert_eq!(scene.objects[0], mesh("meshes/0/primitives/0"));
    // What mirrors is written into the vertices, and its outside is turned with them.
    let object = Box::new(mesh("nodes/1/primitives/0"));
    assert_eq!(scene.objects[1], Object::Named { name: "mirrored".to_owned(), object });
    let mirrored = &scene.meshes["room.glb#nodes/1/primitives/0"];
    assert_eq!(mirrored.positions[0], DVec3::new(3.5, -1.0, 0.0));
    let [a, b, c] = mirrored.triangles[0].map(|corner| mirrored.positions[corner as usize]);
    assert!((b - a).cross(c - a).z > 0.0);
    let Object::Transformed { by, object } = &scene.objects[3] else { panic!("{:?}", scene.objects[3]) };
    assert_eq!(**object, mesh("meshes/2/primitives/0"));
    let [Transform::Scale(scale), Transform::Rotate { axis, degrees }, Transform::Translate(shift)] = by[..] else {
        panic!("{by:?}")
    };
    assert!((scale - 2.0).abs() < 1e-12 && axis == DVec3::Y && (degrees - 90.0).abs() < 1e-5);
    assert_eq!(shift, DVec3::new(-3.0, 0.0, 0.0));

    assert!(camera(DVec3::new(0.0, 1.0, 8.0), 45.0)(&scene.camera), "{:?}", scene.camera);
    assert_eq!((scene.image.width, scene.image.height), (1280, 800));
    assert_eq!(scene.background, Background::Solid(DVec3::ZERO), "the lamp lights it");
}

/// The room with these properties of a material.
fn with_material(number: usize, more: Value) -> Value {
    let mut json = room().0;
    json["materials"][number].as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json
}

/// The third material, with these properties.
fn steel(more: Value) -> Material {
    load(&with_material(2, more)).unwrap_or_else(|error| panic!("{error}")).materials.swap_remove(2).1
}

#[test]
fn materials_are_those_of_the_standard_as_far_as_ours_go() {
    let pbr = |metallic: f64, more: Value| {
        let extensions = json!({ "KHR_materials_ior": {"ior": 1.4}, "KHR_materials_specular": more });
        let base = json!({"baseColorFactor": [0.8, 0.7, 0.6, 1], "metallicFactor": metallic, "roughnessFactor": 0.3});
        steel(json!({"pbrMetallicRoughness": base, "extensions": extensions}))
    };
    assert_eq!(pbr(1.0, json!({})), metal(0.3));
    let expected = "Pbr(base_color: Rgb(0.8, 0.7, 0.6), metallic: 0.25, roughness: 0.3, ior: 1.4)";
    assert_eq!(pbr(0.25, json!({})), written(expected));
    assert_eq!(pbr(0.0, json!({"specularFactor": 0})), written("Lambertian(albedo: Rgb(0.8, 0.7, 0.6))"));
    let expected = "Pbr(base_color: Rgb(0.8, 0.7, 0.6), metallic: 0, roughness: 0.3, ior: 1.4, specular: 0.25, specular_color: Rgb(1, 0.5, 0))";
    assert_eq!(pbr(0.0, json!({"specularFactor": 0.25, "specularColorFactor": [1, 0.5, 0]})), written(expected));
    // A colour above 1 is a larger index of refraction.
    let bright = pbr(0.0, json!({"specularColorFactor": [2, 1, 0]}));
    let Material::Pbr(Pbr { ior, specular, specular_color, .. }) = bright else { panic!("{bright:?}") };
    let reflectance = |ior: f64| ((ior - 1.0) / (ior + 1.0)).powi(2);
    assert!((reflectance(ior) - 2.0 * reflectance(1.4)).abs() < 1e-12);
    assert_eq!((specular, specular_color), (Texture::grey(1.0), Texture::Rgb(1.0, 0.5, 0.0)));
    let glass = |roughness: f64| {
        let extensions =
            json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.4}});
        steel(json!({"pbrMetallicRoughness": {"roughnessFactor": roughness}, "extensions": extensions}))
    };
    assert_eq!(glass(0.0), written("ThinDielectric(ior: 1.4)"));
    assert_eq!(glass(0.5), written("ThinDielectric(ior: 1.4, roughness: 0.5)"));
    let emissive = steel(json!({"emissiveFactor": [0.5, 0, 1], "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}}));
    let expected = "Pbr(base_color: Rgb(0.8, 0.7, 0.6), roughness: 0, emission: Image(path: \"room.glb#images/0\", tint: (2, 0, 4)))";
    assert_eq!(emissive, written(expected));
    // The image has half of its codes at 0 and half at 255 in green, and 100 in blue.
    let textured =
        steel(json!({"pbrMetallicRoughness": {"metallicFactor": 0.5, "metallicRoughnessTexture": {"index": 0}}}));
    let number = |factor: f64, channel: char| {
        format!("Image(path: \"room.glb#images/0\", tint: ({factor}, {factor}, {factor}), channel: {channel})")
    };
    let expected = format!("Pbr(metallic: {}, roughness: {})", number(0.5, 'B'), number(1.0, 'G'));
    assert_eq!(textured, written(&expected));
    // Glass has the roughness alone, and a factor of 0 leaves nothing.
    let glass = |factor: f64| {
        let extensions = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
        let numbers = json!({"roughnessFactor": factor, "metallicRoughnessTexture": {"index": 0}});
        steel(json!({"pbrMetallicRoughness": numbers, "extensions": extensions}))
    };
    assert_eq!(glass(0.0), written("ThinDielectric()"));
    assert_eq!(glass(0.25), written(&format!("ThinDielectric(roughness: {})", number(0.25, 'G'))));
    let solid = |more: Value| {
        let mut volume = json!({"thicknessFactor": 1});
        volume.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let extensions =
            json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume});
        let base = json!({"baseColorFactor": [0.5, 1, 1, 1], "roughnessFactor": 0});
        steel(json!({"pbrMetallicRoughness": base, "extensions": extensions}))
    };
    assert_eq!(solid(json!({})), written("Dielectric(ior: 1.5, transmittance: Rgb(0.5, 1, 1))"));
    let Material::Dielectric(Dielectric { absorption: Some(absorption), .. }) =
        solid(json!({"attenuationDistance": 2, "attenuationColor": [0.5, 1, 0]}))
    else {
        panic!("it absorbs")
    };
    assert!((absorption - DVec3::new(0.5 * 2f64.ln(), 0.0, 1e9)).length() < 1e-12, "{absorption}");
    let bumpy = steel(json!({"normalTexture": {"index": 0, "scale": 0.5}}));
    let expected =
        "Conductor(albedo: Rgb(0.8, 0.7, 0.6), normal: Image(path: \"room.glb#images/0\"), normal_scale: 0.5)";
    assert_eq!(bumpy, written(expected));
}

/// The metal's base colour has an alpha of 0.25.
#[test]
fn alpha_is_read_where_its_mode_says_so() {
    let of = |more: Value| {
        let base = json!({"baseColorFactor": [0.8, 0.7, 0.6, 0.25], "roughnessFactor": 0.3});
        let mut json = json!({"pbrMetallicRoughness": base});
        json.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        steel(json)
    };
    let covered = |alpha: &str| written(&format!("Pbr(base_color: Rgb(0.8, 0.7, 0.6), roughness: 0.3, {alpha})"));
    assert_eq!(of(json!({})), metal(0.3));
    assert_eq!(of(json!({"alphaMode": "OPAQUE"})), metal(0.3));
    assert_eq!(of(json!({"alphaMode": "BLEND"})), covered("alpha: 0.25"));
    assert_eq!(of(json!({"alphaMode": "MASK"})), covered("alpha: 0.25, alpha_cutoff: 0.5"));
    assert_eq!(of(json!({"alphaMode": "MASK", "alphaCutoff": 0.125})), covered("alpha: 0.25, alpha_cutoff: 0.125"));
    // Its texture has an alpha, too.
    let wood = |more: Value| load(&with_material(0, more)).unwrap().materials[0].1.clone();
    let textured = |more: &str| {
        let colour = "base_color: Image(path: \"room.glb#images/0\", tint: (0.5, 0.6, 0.7)), metallic: 0";
        written(&format!("Pbr({colour}{more})"))
    };
    let alpha = ", alpha: Image(path: \"room.glb#images/0\", channel: A)";
    let cut_out = textured(&format!("{alpha}, alpha_cutoff: 0.25"));
    assert_eq!(wood(json!({"alphaMode": "MASK", "alphaCutoff": 0.25})), cut_out);
    assert_eq!(wood(json!({"alphaMode": "BLEND"})), textured(alpha));
    assert_eq!(wood(json!({})), textured(""));
    // What emits and has an alpha is no DiffuseLight.
    for (two_sided, more) in [(false, ", one_sided_emission: true"), (true, "")] {
        let lamp = of(json!({"alphaMode": "BLEND", "emissiveFactor": [1, 0.5, 0], "doubleSided": two_sided,
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.5]}}));
        let expected = format!("Lambertian(albedo: Rgb(0, 0, 0), emission: Rgb(1, 0.5, 0), alpha: 0.5{more})");
        assert_eq!(lamp, written(&expected));
    }
}

/// COLOR_0 multiplies the colours of materials whose primitives have it. The normals (0, 0, 1) are taken for colours.
#[test]
fn vertex_colours_are_read() {
    let mut json = room().0;
    json["meshes"][2]["primitives"][0]["attributes"]["COLOR_0"] = json!(1);
    let scene = load(&json).unwrap();
    let expected = "Pbr(base_color: Rgb(0.8, 0.7, 0.6), roughness: 0, vertex_colors: true)";
    assert_eq!(scene.materials[2].1, written(expected));
    let colours = |path: &str| scene.meshes[path].colours.clone();
    assert_eq!(colours("room.glb#meshes/2/primitives/0"), [[0, 0, u16::MAX]; 4]);
    assert!(colours("room.glb#meshes/0/primitives/0").is_empty());
}

/// Of a material that is cut out or transparent, COLOR_0 has an alpha if it has four numbers, of 8 or 16 bits or floats.
#[test]
fn the_alpha_of_vertex_colours_is_read_where_the_material_has_one() {
    let of = |component: u32, width: usize, bytes: &[u8], mode: &str, more: Value| {
        let (mut json, mut binary) = square(&[], &json!({"alphaMode": mode}), &[]);
        json["materials"][0].as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json["bufferViews"].as_array_mut().unwrap().push(
            json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len(), "byteStride": bytes.len() / 4}),
        );
        let [view, accessor] = ["bufferViews", "accessors"].map(|list| json[list].as_array().unwrap().len());
        json["accessors"].as_array_mut().unwrap().push(json!({"bufferView": view - 1, "componentType": component,
            "normalized": component != 5126, "count": 4, "type": format!("VEC{width}")}));
        json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = accessor.into();
        binary.extend(bytes);
        json["buffers"][0]["byteLength"] = binary.len().into();
        let scene = gltf::load("square.glb", (&json, &binary), &GltfOptions::default());
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        let flags = match scene.materials[0].1 {
            Material::Pbr(Pbr { vertex_colors, vertex_alpha, .. })
            | Material::Lambertian(Lambertian { vertex_colors, vertex_alpha, .. }) => (vertex_colors, vertex_alpha),
            _ => (false, false),
        };
        // The mirrored node has vertices of its own.
        let [own, mirrored] =
            ["meshes/0", "nodes/1"].map(|part| &scene.meshes[&format!("square.glb#{part}/primitives/0")]);
        assert_eq!(own.alphas, mirrored.alphas);
        (own.alphas.clone(), own.colours.len(), flags)
    };
    let floats = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let words = |all: &[u16]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let [red, white] = [0.5f32, 1.0].map(|red| {
        let corner = |alpha: f32| [red, 1.0, 1.0, alpha];
        floats([0.0, 0.25, 1.0, 7.0].map(corner).as_flattened())
    });
    let read = vec![0, 16384, 65535, 65535];
    let none = (Vec::new(), 4, (true, false));
    for mode in ["BLEND", "MASK"] {
        assert_eq!(of(5126, 4, &red, mode, json!({})), (read.clone(), 4, (true, true)), "{mode}");
        assert_eq!(of(5126, 4, &white, mode, json!({})), (read.clone(), 0, (false, true)), "{mode}");
    }
    assert_eq!(of(5126, 4, &red, "OPAQUE", json!({})), none);
    assert_eq!(of(5126, 4, &white, "OPAQUE", json!({})), (Vec::new(), 0, (false, false)));
    // A metal that is opaque otherwise, and what emits.
    let steel = json!({"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}});
    assert_eq!(of(5126, 4, &white, "BLEND", steel).2, (false, true));
    let lamp = json!({"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}});
    assert_eq!(of(5126, 4, &red, "BLEND", lamp).2, (true, true));
    let bytes = [[9, 0, 0, 0], [9, 0, 0, 51], [9, 0, 0, 128], [9, 0, 0, 255]];
    assert_eq!(of(5121, 4, bytes.as_flattened(), "BLEND", json!({})).0, [0, 51 * 257, 128 * 257, 65535]);
    let codes = [[9, 0, 0, 0], [9, 0, 0, 7], [9, 0, 0, 40000], [9, 0, 0, 65535]];
    assert_eq!(of(5123, 4, &words(codes.as_flattened()), "MASK", json!({})).0, [0, 7, 40000, 65535]);
    // Three numbers have none, and an alpha of 1 is none.
    assert_eq!(of(5126, 3, &floats(&[0.5; 12]), "BLEND", json!({})), none);
    assert_eq!(of(5126, 4, &floats(&[0.5, 0.5, 0.5, 1.0].repeat(4)), "BLEND", json!({})), none);
}

#[test]
fn a_camera_is_chosen_by_its_name_or_that_of_its_node() {
    let of = |name: &str| load_as(&room().0, &GltfOptions { camera: Some(name.to_owned()), ..GltfOptions::default() });
    assert!(camera(DVec3::new(-8.0, 1.0, 0.0), 68.754_935_4)(&of("Left").unwrap().camera));
    assert_eq!(of("Left").unwrap().camera.look_at.x.round(), 0.0, "it looks along +x");
    assert_eq!(of("Wide").unwrap().camera, of("Front").unwrap().camera);
    let error = of("left").unwrap_err();
    assert_eq!(error.exit_status(), 2);
    let words =
        "--camera: there is no camera \"left\": expected one of \"Front\", \"Wide\", \"Left\"; did you mean \"Left\"?";
    assert_eq!(error.to_string(), words);
    let orthographic = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1}});
    let json = changed("/cameras/0", orthographic);
    let scene = load(&json).unwrap();
    assert_eq!(scene.camera.projection(), Projection::Orthographic { height: 2.0 });
    assert_eq!((scene.image.width, scene.image.height), (1280, 1280), "the image has the shape of xmag and ymag");
}

#[test]
fn a_file_without_camera_and_light_gets_both_and_a_note() {
    let mut json = changed("/scenes/0/nodes", json!([0, 1]));
    json["nodes"][0]["translation"] = json!([1000.0, 0.0, 0.0]);
    let scene = load(&json).unwrap();
    let Camera { look_from, look_at, .. } = scene.camera;
    // The squares span from 1.5 to 1001.
    assert!((look_at - DVec3::new(501.25, 0.0, 0.0)).length() < 1e-9 && look_from.z > 1000.0, "{:?}", scene.camera);
    assert!(matches!(scene.background, Background::Gradient { .. }));
    let notes = notes(&json).join("\n");
    assert!(notes.contains("nothing in it emits light") && notes.contains("it has no camera"), "{notes}");
    let sky = GltfOptions { sky: Some(Sky::Image("gone.exr".to_owned())), ..GltfOptions::default() };
    assert!(load_as(&json, &sky).unwrap_err().to_string().contains("gone.exr: cannot read the image"));
}

/// Each with its factors, its textures, and sets of texture coordinates of their own.
#[test]
fn the_lobes_of_the_extensions_are_read() {
    let image = |channel: &str, factor: f64| {
        format!("Image(path: \"room.glb#images/0\", tint: ({factor}, {factor}, {factor}), channel: {channel})")
    };
    let lobes =
        |extensions: Value| steel(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}));
    let pbr = |more: &str| {
        let material = written(&format!("Pbr(metallic: 0, {more})"));
        // `convert` writes what is read.
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let text = options.to_string(&material).unwrap();
        assert_eq!(written(&text), material, "{text}");
        material
    };
    let texture = json!({"index": 0});
    assert_eq!(lobes(json!({"KHR_materials_transmission": {"transmissionFactor": 0.25}})), pbr("transmission: 0.25"));
    // A share that varies is no plain glass, not even with the factor 1.
    assert_eq!(
        lobes(json!({"KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": texture}})),
        pbr(&format!("transmission: {}", image("R", 1.0)))
    );
    let volume = json!({"thicknessFactor": 1, "attenuationColor": [0.5, 1, 1], "attenuationDistance": 1});
    let Material::Pbr(Pbr { solid: true, absorption: Some(absorption), transmission, .. }) =
        lobes(json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}, "KHR_materials_volume": volume}))
    else {
        panic!("it is no body");
    };
    assert_eq!(transmission, Texture::grey(0.5));
    assert!((absorption - DVec3::new(2f64.ln(), 0.0, 0.0)).length() < 1e-7, "{absorption}");
    assert_eq!(
        lobes(json!({"KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": texture, "specularColorTexture": texture}})),
        pbr(&format!("specular: {}, specular_color: Image(path: \"room.glb#images/0\")", image("A", 0.5)))
    );
    let coat = json!({"clearcoatFactor": 0.75, "clearcoatTexture": texture, "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": texture, "clearcoatNormalTexture": {"index": 0, "scale": 0.5}});
    let expected = format!(
        "coat: {}, coat_roughness: {}, coat_normal: Image(path: \"room.glb#images/0\", channel: Rgb), coat_normal_scale: 0.5",
        image("R", 0.75),
        image("G", 0.5)
    );
    assert_eq!(lobes(json!({"KHR_materials_clearcoat": coat})), pbr(&expected));
    let sheen =
        json!({"sheenColorFactor": [0.5, 0.25, 1], "sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": texture});
    let expected = format!("sheen: Rgb(0.5, 0.25, 1), sheen_roughness: {}", image("A", 0.5));
    assert_eq!(lobes(json!({"KHR_materials_sheen": sheen})), pbr(&expected));
    let film = json!({"iridescenceFactor": 0.5, "iridescenceTexture": texture, "iridescenceIor": 1.8,
        "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 800, "iridescenceThicknessTexture": texture});
    let expected = format!(
        "iridescence: {}, iridescence_ior: 1.8, iridescence_thickness: 800, iridescence_thickness_min: 200, \
         iridescence_thickness_texture: {}",
        image("R", 0.5),
        image("G", 1.0)
    );
    assert_eq!(lobes(json!({"KHR_materials_iridescence": film})), pbr(&expected));
    let plain = json!({"KHR_materials_iridescence": {"iridescenceFactor": 1}});
    assert_eq!(lobes(plain), pbr("iridescence: 1"));
    let leaf = json!({"diffuseTransmissionFactor": 0.75, "diffuseTransmissionTexture": texture,
        "diffuseTransmissionColorFactor": [1, 0.5, 0.25], "diffuseTransmissionColorTexture": texture});
    let expected = format!(
        "diffuse_transmission: {}, diffuse_transmission_color: Image(path: \"room.glb#images/0\", tint: (1, 0.5, 0.25))",
        image("A", 0.75)
    );
    assert_eq!(lobes(json!({"KHR_materials_diffuse_transmission": leaf})), pbr(&expected));
    assert_eq!(lobes(json!({"GPU_RT_materials_multiscatter": {}})), pbr("multiscatter: true"));
    // Dispersion is of bodies alone: of plain glass, and of a share.
    let dispersion = json!({"dispersion": 0.5});
    for (factor, thickness, expected) in [(0.5, 1, 0.5), (0.5, 0, 0.0)] {
        let Material::Pbr(Pbr { dispersion, .. }) = lobes(json!({"KHR_materials_dispersion": dispersion,
            "KHR_materials_transmission": {"transmissionFactor": factor}, "KHR_materials_volume": {"thicknessFactor": thickness}}))
        else {
            panic!("it is no share of glass");
        };
        assert_eq!(dispersion, expected, "thickness {thickness}");
    }
    let clear =
        lobes(json!({"KHR_materials_dispersion": dispersion, "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1}}));
    let (Material::Dielectric(Dielectric { dispersion, .. })
    | Material::RoughDielectric(RoughDielectric { dispersion, .. })) = clear
    else {
        panic!("it is no glass");
    };
    assert_eq!(dispersion, 0.5);
    // A quarter turn, of a metal that stays one.
    let brushed = json!({"anisotropyStrength": 0.5, "anisotropyRotation": 1.5, "anisotropyTexture": texture});
    let Material::Conductor(Conductor { anisotropy, anisotropy_rotation, anisotropy_texture, .. }) =
        steel(json!({"extensions": {"KHR_materials_anisotropy": brushed}}))
    else {
        panic!("it is no metal");
    };
    assert_eq!((anisotropy, anisotropy_rotation), (0.5, 1.5f64.to_degrees()));
    assert_eq!(
        anisotropy_texture.as_ref().and_then(Texture::decoded).map(|(path, _)| path.as_str()),
        Some("room.glb#images/0")
    );
    // A factor of 0 leaves nothing of any.
    let none = json!({"KHR_materials_clearcoat": {"clearcoatTexture": texture}, "KHR_materials_sheen": {"sheenColorTexture": texture},
        "KHR_materials_anisotropy": {"anisotropyTexture": texture}, "KHR_materials_transmission": {"transmissionTexture": texture},
        "KHR_materials_iridescence": {"iridescenceTexture": texture, "iridescenceThicknessTexture": texture, "iridescenceIor": 2},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionColorTexture": texture}});
    assert_eq!(lobes(none), pbr(""));
    // Metals and matt surfaces with a lobe are no plain ones.
    let coated = steel(json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}}));
    assert!(matches!(coated, Material::Pbr(_)), "{coated:?}");
    // Each placing of a texture is a set of texture coordinates.
    let moved = json!({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}});
    let set_of = |texture: &Texture| match texture {
        Texture::Image { uv_set, .. } => Some(*uv_set),
        _ => None,
    };
    let Material::Pbr(Pbr { coat, sheen, .. }) = lobes(json!({
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": texture},
        "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenColorTexture": moved}}))
    else {
        panic!("it has lobes");
    };
    assert_eq!((set_of(&coat), set_of(&sheen)), (Some(0), Some(1)));
}

/// What is of a wrong type is an error with its place.
#[test]
fn broken_lobes_are_refused_with_their_path() {
    for (extension, field, value, expected) in [
        ("KHR_materials_clearcoat", "clearcoatFactor", json!("x"), "expected a number"),
        ("KHR_materials_clearcoat", "clearcoatTexture", json!({"texCoord": 0}), "expected a texture"),
        ("KHR_materials_sheen", "sheenColorFactor", json!([1, 2]), "expected three numbers"),
        ("KHR_materials_anisotropy", "anisotropyRotation", json!([]), "expected a number"),
        ("KHR_materials_iridescence", "iridescenceIor", json!("x"), "expected a number"),
        ("KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor", json!(1), "expected three numbers"),
        ("KHR_materials_dispersion", "dispersion", json!(true), "expected a number"),
    ] {
        let json = changed("/materials/0/extensions", json!({extension: {field: value}}));
        gltf::is_refused(load(&json), &format!("materials[0].extensions.{extension}.{field}"), expected);
    }
    let gone = json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 7}}});
    let at = "materials[0].extensions.KHR_materials_clearcoat.clearcoatTexture.index";
    gltf::is_refused(load(&changed("/materials/0/extensions", gone)), at, "there is no texture 7");
}

#[test]
fn ignored_properties_are_named_once_with_their_material() {
    assert_eq!(
        notes(&room().0),
        [
            "nodes[1]: transforms that mirror or scale unevenly are applied to the vertices: 1 node cannot \
             share a mesh with others, which takes memory",
            "its emitters alone light it: --sky default adds a white and blue sky",
        ]
    );
    let wood = |more: Value| notes(&with_material(0, more))[0].clone();
    for (more, expected) in [
        (json!({"occlusionTexture": {"index": 0}}), "not read: occlusionTexture"),
        (json!({"extensions": {"KHR_materials_subsurface": {}}}), "not read: \"KHR_materials_subsurface\""),
        (
            json!({"extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_anisotropy": {"anisotropyStrength": 1}}}),
            "not read: KHR_materials_anisotropy on a pane",
        ),
        (
            json!({"pbrMetallicRoughness": {"baseColorFactor": [2, 0.5, 0.5, 1]}}),
            "baseColorFactor is clamped to 0 .. 1",
        ),
    ] {
        let note = wood(more);
        assert!(note.starts_with("materials[0] (\"Wood\") is approximated: ") && note.contains(expected), "{note}");
    }
    for (pointer, value, expected) in [
        ("/meshes/0/primitives/0/mode", json!(1), "meshes: 2 primitives of points or lines are left out"),
        (
            "/nodes/2/scale",
            json!([0, 0, 0]),
            "room.glb#nodes/2/primitives/0: none of its faces has an area: it is left out",
        ),
        (
            "/animations",
            json!([{"channels": [], "samplers": []}]),
            "animations are not read without a frame: --frame N",
        ),
        (
            "/extensionsUsed",
            json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_xmp_json_ld", "KHR_materials_ior"]),
            "extensionsUsed: not read: \"KHR_xmp_json_ld\"",
        ),
    ] {
        let notes = notes(&changed(pointer, value)).join("\n");
        assert!(notes.contains(expected), "{notes}");
    }
}

/// Blender writes scenes without nodes, and animations of other things than nodes.
#[test]
fn properties_that_the_standard_leaves_open_are_no_errors() {
    let plain = load(&room().0).unwrap();
    for (pointer, value) in [
        ("/scenes/0/extras", json!(7)),
        ("/materials/0/extras", json!([1, {"extras": "x"}])),
        ("/scenes", json!([{"nodes": [0, 1, 2, 3, 4, 5]}, {"name": "empty"}])),
        (
            "/animations",
            json!([{"samplers": [{"input": 0, "output": 0}], "channels": [{"sampler": 0, "target": {"path": "pointer"}}]}]),
        ),
    ] {
        let scene = load(&changed(pointer, value)).unwrap_or_else(|error| panic!("{pointer}: {error}"));
        assert_eq!(scene.materials, plain.materials, "{pointer}");
        assert_eq!(scene.objects.len(), plain.objects.len(), "{pointer}");
    }
    let mut old = changed("/asset/version", json!("1.0"));
    old["meshes"] = json!({});
    gltf::is_refused(load(&old), "asset.version", "expected glTF of version 2.0, found \"1.0\"");
    let mut broken = changed("/scenes/0/extras", json!(7));
    broken["nodes"][0]["mesh"] = json!("x");
    assert!(load(&broken).is_err());
}

#[test]
fn broken_gltf_is_refused_with_its_path_in_the_json() {
    // Where the place is not that of the change, it is given.
    for (pointer, value, at, reason) in [
        ("/asset", json!({}), "", "missing field `version`"),
        ("/nodes/0/mesh", json!("x"), "", "invalid type: string \"x\""),
        ("/nodes/0/mesh", json!(7), "", "there is no mesh 7"),
        ("/nodes/0/camera", json!(7), "", "there is no camera 7"),
        ("/nodes/3/rotation", json!([0, 0, 0, 0]), "nodes[3]", "a rotation that is not 0"),
        ("/nodes/0/children", json!([1]), "nodes[1]", "it occurs twice"),
        ("/nodes/0/children", json!([77]), "", "there is no node 77"),
        ("/scene", json!(3), "", "expected a scene 3"),
        ("/cameras/0/perspective/yfov", json!(0), "", "between 0 and pi, found 0"),
        ("/cameras/0/type", json!("round"), "", "perspective or orthographic"),
        ("/meshes/0/primitives/0/material", json!(7), "", "there is no material 7"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(7), "", "there is no texture 7"),
        ("/textures/0/source", json!(7), "", "there is no image 7"),
        ("/images/0", json!({"uri": "http://a/b.png"}), "images[0].uri", "the path of a file"),
        ("/images/0", json!({"bufferView": 77}), "", "there is no bufferView 77"),
        ("/images/0", json!({"bufferView": 0}), "", "cannot decode the image"),
        ("/images/0", json!({}), "", "expected a uri or a bufferView"),
        ("/bufferViews/5/byteLength", json!(u64::MAX), "images[0]", "bufferView 5 reaches past the end"),
        ("/accessors/0/count", json!(5), "meshes[0].primitives[0].attributes.POSITION", "reaches past the end"),
        ("/accessors/4/componentType", json!(5122), "meshes[0].primitives[0].indices", "5121, 5123 or 5125"),
        ("/meshes/0/primitives/0/attributes", json!({}), "", "expected an attribute POSITION"),
        ("/buffers/0/byteLength", json!(1 << 20), "buffers[0]", "it is not complete"),
        ("/extensionsRequired", json!(["ACME_gizmo"]), "extensionsRequired[0]", "which is not supported"),
    ] {
        let at = if at.is_empty() { gltf::place(pointer) } else { at.to_owned() };
        gltf::is_refused(load(&changed(pointer, value)), &at, reason);
    }
}

/// The pixel of the image that the point (x, y) of the first square shows is found by its texture coordinates.
#[test]
fn texture_coordinates_are_those_that_the_material_wants() {
    let uvs = |info: Value| {
        let json = changed("/materials/0/pbrMetallicRoughness/baseColorTexture", info);
        let scene = load(&json).unwrap_or_else(|error| panic!("{error}"));
        let uvs = scene.meshes["room.glb#meshes/0/primitives/0"].uvs.clone();
        // As glTF counts v.
        uvs.iter().map(|uv| [f64::from(uv.x), f64::from(1.0 - uv.y)]).collect::<Vec<_>>()
    };
    assert_eq!(uvs(json!({"index": 0})), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(uvs(json!({"index": 0, "texCoord": 1})), [[0.0, 0.5], [0.5, 0.5], [0.5, 0.0], [0.0, 0.0]]);
    let moved = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 3]}}});
    assert_eq!(uvs(moved), [[0.25, 3.5], [2.25, 3.5], [2.25, 0.5], [0.25, 0.5]]);
    // A set that is not there: the colour of the image's corner everywhere.
    assert_eq!(uvs(json!({"index": 0, "texCoord": 5})), [[0.0, 0.0]; 4]);
}

/// Each placing of the textures of a material is a set of its meshes.
#[test]
fn textures_have_sets_of_texture_coordinates_of_their_own() {
    let mut json = room().0;
    json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    json["materials"][0]["emissiveTexture"] = json!({"index": 0, "texCoord": 1});
    let moved = json!({"texCoord": 5, "offset": [0.25, 0.5]});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": moved}});
    json["materials"][0]["normalTexture"] = info.clone();
    json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = info;
    let scene = load(&json).unwrap_or_else(|error| panic!("{error}"));
    let mesh = &scene.meshes["room.glb#meshes/0/primitives/0"];
    assert_eq!(mesh.further_uvs.len(), 2);
    let ends = |uvs: &[glam::Vec2]| [uvs[1], uvs[3]].map(|uv| [uv.x, 1.0 - uv.y]);
    assert_eq!(ends(&mesh.uvs), [[1.0, 1.0], [0.0, 0.0]]);
    assert_eq!(ends(&mesh.further_uvs[0]), [[0.5, 0.5], [0.0, 0.0]]);
    // There is no such set: the colour of one point.
    assert_eq!(ends(&mesh.further_uvs[1]), [[0.25, 0.5]; 2]);
    let text = scene.text();
    assert_eq!(text.matches("uv_set: 1").count(), 1, "{text}");
    assert_eq!(text.matches("uv_set: 2").count(), 2, "{text}");
    assert!(!notes(&json).iter().any(|note| note.contains("approximated")), "{:?}", notes(&json));
}

/// The square under a normal map, with these tangents of its corners.
fn with_tangents(tangents: &[f32]) -> Result<Scene, Error> {
    let normals = [0.0, 0.0, 1.0].repeat(4);
    let uvs = [0., 1., 1., 1., 1., 0., 0., 0.];
    let attributes = [("NORMAL", 3, normals.as_slice()), ("TEXCOORD_0", 2, &uvs), ("TANGENT", 4, tangents)];
    let (json, binary) = square(&attributes, &json!({"normalTexture": {"index": 0}}), &["map.png"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.glb");
    fs::write(folder.path().join("map.png"), png()).unwrap();
    fs::write(&path, glb(&json, &binary)).unwrap();
    Scene::load_as(&path, &GltfOptions::default(), &mut |_, _, _| {}, &mut Assets::default())
}

#[test]
fn tangents_of_a_file_are_checked() {
    let good = [0.0, 2.0, 0.0, -1.0].repeat(4);
    let scene = with_tangents(&good).unwrap_or_else(|error| panic!("{error}"));
    let mesh = &scene.meshes["square.glb#meshes/0/primitives/0"];
    assert_eq!(mesh.tangents, [glam::Vec4::new(0.0, 1.0, 0.0, -1.0); 4]);
    // The node that is mirrored has a mesh of its own.
    let mirrored = &scene.meshes["square.glb#nodes/1/primitives/0"];
    assert_eq!(mirrored.tangents, [glam::Vec4::new(0.0, 1.0, 0.0, 1.0); 4]);
    assert!(!scene.warnings().iter().any(|note| note.contains("TANGENT")));
    for (at, number) in [(1, f32::NAN), (1, 0.0), (7, 0.0), (12, f32::INFINITY)] {
        let mut bad = good.clone();
        bad[at] = number;
        let scene = with_tangents(&bad).unwrap_or_else(|error| panic!("{error}"));
        assert!(scene.meshes["square.glb#meshes/0/primitives/0"].tangents.is_empty());
        let notes = scene.warnings().join("\n");
        let expected = "square.glb#meshes/0/primitives/0: some corners have a TANGENT without a length or a sign";
        assert!(notes.contains(expected), "{notes}");
    }
    let at = "meshes[0].primitives[0].attributes.TANGENT";
    gltf::is_refused(with_tangents(&good[..12]), at, "expected a tangent for each of 4 vertices, found 3");
}

/// The room with a point, a spot and a directional light instead of the lamp.
fn with_lights() -> Value {
    let mut json = changed("/scenes/0/nodes", json!([0, 2, 3]));
    json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 68.3, "color": [1, 0.5, 0], "range": 9},
        {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}},
        {"type": "directional", "intensity": 3}]}});
    for (node, light) in [(0, 0), (2, 1), (3, 2)] {
        json["nodes"][node].as_object_mut().unwrap().remove("mesh");
        json["nodes"][node]["extensions"] = json!({"KHR_lights_punctual": {"light": light}});
    }
    json
}

/// `extras` name the group of a material's light and of a light. What is no text there is none.
#[test]
fn extras_name_groups_of_lights() {
    let mut json = with_lights();
    let lights = &mut json["extensions"]["KHR_lights_punctual"]["lights"];
    lights[0]["extras"] = json!({"light_group": "key", "other": [1, {}]});
    lights[1]["extras"] = json!({"light_group": 7});
    lights[2]["extras"] = json!("light_group");
    let scene = load(&json).unwrap_or_else(|error| panic!("{error}"));
    let groups: Vec<_> = scene.objects.iter().map(gpu_rt::scene::Object::light_group).collect();
    assert_eq!(groups[..3], [Some("key"), None, None]);
    let mut json = changed("/materials/0/extras", json!({"light_group": "glow"}));
    json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    let scene = load(&json).unwrap_or_else(|error| panic!("{error}"));
    let grouped = scene.materials.iter().filter(|(_, material)| material.light_group() == Some("glow"));
    assert_eq!(grouped.count(), 1, "{:?}", scene.materials);
}

#[test]
fn lights_are_those_of_the_file() {
    let json = with_lights();
    let scene = load(&json).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        scene.objects[0],
        Object::PointLight { at: DVec3::ZERO, intensity: DVec3::new(68.3, 34.15, 0.0), light_group: None }
    );
    // The quarter turn takes -z to +y.
    let Object::SpotLight { at, towards, intensity, inner, outer, .. } = scene.objects[1] else { panic!() };
    assert!((at, intensity) == (DVec3::new(0.0, 4.0, 0.0), DVec3::splat(2.0)));
    assert!(((towards - at).normalize() - DVec3::Y).length() < 1e-9, "{towards}");
    assert!((inner - 0.1_f64.to_degrees()).abs() < 1e-9 && (outer - 0.5_f64.to_degrees()).abs() < 1e-9);
    let Object::DirectionalLight { direction, irradiance, .. } = scene.objects[2] else { panic!() };
    assert!((direction + DVec3::X).length() < 1e-9 && irradiance == DVec3::splat(3.0), "{direction}");
    assert_eq!(scene.background, Background::Solid(DVec3::ZERO));
    let range = "extensions.KHR_lights_punctual: the range of lights is not read: their light has no limit";
    assert!(notes(&json).contains(&range.to_owned()), "{:?}", notes(&json));

    for (pointer, value, at) in [
        ("/lights/0/type", json!("round"), "lights[0].type"),
        ("/lights/0/intensity", json!(-1), "lights[0].intensity"),
        ("/lights/1/spot", json!(null), "lights[1].spot"),
        ("/lights/1/spot/outerConeAngle", json!(0), "lights[1].spot.outerConeAngle"),
    ] {
        let mut broken = json.clone();
        *broken["extensions"]["KHR_lights_punctual"].pointer_mut(pointer).unwrap() = value;
        gltf::is_refused(load(&broken), &format!("extensions.KHR_lights_punctual.{at}"), "");
    }
    let mut broken = json;
    broken["nodes"][3]["extensions"]["KHR_lights_punctual"]["light"] = json!(9);
    gltf::is_refused(load(&broken), "nodes[3].extensions.KHR_lights_punctual.light", "there is no light 9");
}

/// Without a light without size the units do not matter, and nothing is reported about them.
#[test]
fn lights_of_files_by_blender_are_in_watts_unless_they_are_said_not_to_be() {
    let of = |generator: &str| {
        let mut json = with_lights();
        json["asset"]["generator"] = generator.into();
        json
    };
    let watts = |watts| GltfOptions { watts, ..GltfOptions::default() };
    // The intensity of the point, that of the spot, and the irradiance of the sun, in red.
    let strengths = |json: &Value, given| {
        let scene = load_as(json, &watts(given)).unwrap_or_else(|error| panic!("{error}"));
        [0, 1, 2].map(|light| match scene.objects[light] {
            Object::PointLight { intensity, .. } | Object::SpotLight { intensity, .. } => intensity.x,
            Object::DirectionalLight { irradiance, .. } => irradiance.x,
            ref other => panic!("{other:?}"),
        })
    };
    let [standard, lumens, plain] =
        [[1.0; 3], [683.0; 3], [4.0 * std::f64::consts::PI, 4.0 * std::f64::consts::PI, 1.0]];
    let reported = |json: &Value, given| {
        let notes = notes_as(json, &watts(given));
        notes.into_iter().filter(|note| note.contains("--watts=off")).collect::<Vec<_>>()
    };
    let [new, old] = ["Khronos glTF Blender I/O v4.2.57", "Khronos glTF Blender I/O v3.3.27"].map(of);
    let other = of("a test");
    for (json, given, expected) in [
        (&other, None, standard),
        (&other, Some(true), lumens),
        (&other, Some(false), standard),
        (&new, None, lumens),
        (&new, Some(true), lumens),
        (&new, Some(false), standard),
        (&old, None, plain),
        (&old, Some(true), plain),
        (&old, Some(false), standard),
    ] {
        let found = strengths(json, given);
        let off = [68.3, 2.0, 3.0].into_iter().zip(expected).map(|(intensity, divisor)| intensity / divisor);
        let off =
            off.zip(found).map(|(expected, found): (f64, f64)| (found / expected - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{given:?}: {found:?}");
        // It is reported without a request.
        let is_reported = given.is_none() && expected != standard;
        assert_eq!(reported(json, given).len(), usize::from(is_reported), "{given:?}: {:?}", reported(json, given));
    }
    let unitless = reported(&new, None);
    assert!(unitless[0].starts_with("asset.generator: ") && unitless[0].contains("\"Unitless\""), "{unitless:?}");
    let mut without = room().0;
    without["asset"]["generator"] = json!("Khronos glTF Blender I/O v4.2.57");
    assert_eq!(reported(&without, None), Vec::<String>::new());

    // An object in a scene file has a field for it, and the warning names that.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("new.glb"), glb(&new, &room().1)).unwrap();
    let intensity = |object: &str| {
        let scene = scene_with(folder.path(), object).unwrap_or_else(|error| panic!("{error}"));
        let mut found = Vec::new();
        scene.visit_objects(&mut |_, object| {
            if let Object::PointLight { intensity, .. } = object {
                found.push(intensity.x);
            }
        });
        (found, scene.warnings().join("\n").matches("watts: false").count())
    };
    assert_eq!(intensity(r#"Gltf(path: "new.glb")"#), (vec![68.3 / 683.0], 1));
    assert_eq!(intensity(r#"Gltf(path: "new.glb", watts: true)"#), (vec![68.3 / 683.0], 0));
    assert_eq!(intensity(r#"Gltf(path: "new.glb", watts: false)"#), (vec![68.3], 0));
    let twice = r#"Gltf(path: "new.glb", watts: false), Group([Gltf(path: "new.glb")])"#;
    let error = scene_with(folder.path(), twice).unwrap_err().to_string();
    assert!(error.contains("objects[1].Group[0].Gltf.path: ") && error.contains("in another way"), "{error}");
    let error = scene_with(folder.path(), r#"Gltf(path: "new.glb", watts: 1)"#).unwrap_err().to_string();
    assert!(error.contains("objects[0].Gltf.watts: ") && error.contains("true or false"), "{error}");
}

/// The room, whose lamp alone has this material. What emits is a texture, a number, beside what scatters, or nothing.
fn lit_by(material: Value) -> Value {
    let mut json = changed("/materials/1", material);
    json["scenes"][0]["nodes"] = json!([0, 2, 4]);
    json
}

/// What lights a file without a sky of its own, by the note on it.
const DARK: &str = "nothing in it emits light, so a white";
const DIM: &str = "a white and blue sky lights it too";
const LIT: &str = "its emitters alone light it";

/// Checks that a file has this note, and a sky that goes with it.
fn lit_as(json: &Value, expected: &str) {
    let scene = load(json).unwrap_or_else(|error| panic!("{error}"));
    let notes = notes(json).join("\n");
    for note in [DARK, DIM, LIT] {
        assert_eq!(notes.contains(note), note == expected, "{json}: {notes}");
    }
    let has_sky = matches!(scene.background, Background::Gradient { .. });
    assert_eq!(has_sky, [DARK, DIM].contains(&expected), "{json}");
    assert!(has_sky || scene.background == Background::Solid(DVec3::ZERO));
}

#[test]
fn a_sky_is_added_unless_lamps_or_emitters_light_the_file() {
    let base = |colour: Value| json!({"baseColorFactor": colour, "metallicFactor": 0});
    let emissive = json!([1, 0.5, 0]);
    let strength = |strength: f64| json!({"KHR_materials_emissive_strength": {"emissiveStrength": strength}});
    let [grey, black] = [json!([0.5, 0.5, 0.5, 1]), json!([0, 0, 0, 1])].map(base);
    let invisible = base(json!([0.5, 0.5, 0.5, 0]));
    let solid = json!({"KHR_materials_transmission": {"transmissionFactor": 1}});
    for (material, expected) in [
        (json!({"emissiveFactor": emissive, "extensions": strength(10.0), "pbrMetallicRoughness": grey}), LIT),
        (json!({"emissiveFactor": emissive, "extensions": strength(10.0), "pbrMetallicRoughness": black}), LIT),
        (json!({"emissiveFactor": emissive, "pbrMetallicRoughness": grey}), DIM),
        (json!({"emissiveFactor": emissive, "pbrMetallicRoughness": black}), DIM),
        (json!({"emissiveFactor": emissive, "pbrMetallicRoughness": black, "alphaMode": "BLEND"}), DIM),
        (json!({"emissiveFactor": emissive}), DIM),
        (json!({"emissiveFactor": [0.001, 0, 0], "extensions": strength(1e-3)}), DIM),
        (json!({"emissiveFactor": emissive, "emissiveTexture": {"index": 0}, "pbrMetallicRoughness": grey}), DIM),
        (
            json!({"emissiveFactor": emissive, "alphaMode": "MASK", "alphaCutoff": 0, "pbrMetallicRoughness": invisible}),
            DIM,
        ),
        // None of it is left.
        (json!({"emissiveFactor": [0, 0, 0], "pbrMetallicRoughness": grey}), DARK),
        (json!({"emissiveFactor": emissive, "extensions": strength(0.0), "pbrMetallicRoughness": grey}), DARK),
        (json!({"emissiveTexture": {"index": 0}, "pbrMetallicRoughness": grey}), DARK),
        (json!({"emissiveFactor": emissive, "alphaMode": "BLEND", "pbrMetallicRoughness": invisible}), DARK),
        (json!({"emissiveFactor": emissive, "alphaMode": "MASK", "pbrMetallicRoughness": invisible}), DARK),
        // Glass does not emit, and it is said.
        (json!({"emissiveFactor": emissive, "extensions": solid, "pbrMetallicRoughness": grey}), DARK),
    ] {
        lit_as(&lit_by(material), expected);
    }
    // All texels of its image are black.
    let mut pixels = Vec::new();
    let black = image::RgbImage::new(2, 2);
    black.write_to(&mut std::io::Cursor::new(&mut pixels), image::ImageFormat::Png).unwrap();
    let mut json =
        lit_by(json!({"emissiveFactor": emissive, "emissiveTexture": {"index": 1}, "pbrMetallicRoughness": grey}));
    let encoded = base64::engine::general_purpose::STANDARD.encode(&pixels);
    json["images"] = json!([{"bufferView": 5}, {"uri": format!("data:image/png;base64,{encoded}")}]);
    json["textures"] = json!([{"source": 0}, {"source": 1}]);
    lit_as(&json, DARK);
    // A material that no object has, a lamp of another scene, and a light that no node has.
    let mut json = changed("/scenes/0/nodes", json!([0, 4]));
    lit_as(&json, DARK);
    json["scenes"] = json!([{"nodes": [0, 4]}, {"nodes": [2]}]);
    lit_as(&json, DARK);
    json["scene"] = json!(1);
    lit_as(&json, LIT);
    json["scene"] = json!(0);
    json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 2}]}});
    lit_as(&json, DARK);
    // A node with a light and without a mesh, which is no more to say; a light that is off.
    json["nodes"][4]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    lit_as(&json, "");
    json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(0);
    lit_as(&json, DARK);
    // A lamp without area.
    let mut json = room().0;
    json["nodes"][2]["scale"] = json!([0, 0, 0]);
    lit_as(&json, DARK);
}

/// The light that reaches the other surfaces counts, by the way that surfaces face: a panel below a ceiling, the same outside, and a lamp
/// as large as the room is dark.
#[test]
fn emitters_light_a_file_if_their_light_reaches_its_surfaces() {
    // Squares of 2 by 2 units, moved, turned about x by quarters, and scaled: a floor, and a panel above it that faces it or not.
    let panel = |quarters: i32, height: f64, size: f64, strength: f64| {
        let turn = |quarters: i32| {
            let half = f64::from(quarters) * std::f64::consts::FRAC_PI_4;
            json!([half.sin(), 0, 0, half.cos()])
        };
        let mut json = changed("/scenes/0/nodes", json!([0, 2]));
        json["nodes"][0] = json!({"mesh": 0, "rotation": turn(-1), "scale": [5, 5, 5]});
        json["nodes"][2] =
            json!({"mesh": 1, "rotation": turn(quarters), "translation": [0, height, 0], "scale": [size, size, size]});
        json["materials"][1]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = json!(strength);
        json
    };
    // The panel has 4 units of 104, and 0.78 of its light reaches the floor: 0.04 · 0.9 strength · 0.78 / 0.84.
    lit_as(&panel(1, 3.0, 1.0, 10.0), LIT);
    lit_as(&panel(1, 3.0, 1.0, 1.5), LIT);
    lit_as(&panel(1, 3.0, 1.0, 0.5), DIM);
    // A sheet has two sides. One that stands beside the floor sends it less.
    lit_as(&panel(-1, 3.0, 1.0, 1.5), LIT);
    lit_as(&panel(0, 30.0, 1.0, 10.0), DIM);
    // An LED of a hundredth of that.
    lit_as(&panel(1, 3.0, 0.1, 10.0), DIM);
    // What glows alone needs no sky.
    lit_as(&changed("/scenes/0/nodes", json!([2])), LIT);
    for (sky, background) in [
        (Sky::None, Background::Solid(DVec3::ZERO)),
        (Sky::Default, Background::Gradient { bottom: DVec3::ONE, top: DVec3::new(0.5, 0.7, 1.0) }),
    ] {
        for strength in [0.5, 10.0] {
            let options = GltfOptions { sky: Some(sky.clone()), ..GltfOptions::default() };
            let json = panel(1, 3.0, 1.0, strength);
            assert_eq!(load_as(&json, &options).unwrap().background, background);
            assert!(!notes_as(&json, &options).join("\n").contains("sky"), "{sky:?}");
        }
    }
}

/// By the standard a rough white metal; Blender renders a Principled BSDF as new.
#[test]
fn a_mesh_without_a_material_is_that_of_its_program() {
    let mut json = room().0;
    json["meshes"][2]["primitives"][0].as_object_mut().unwrap().remove("material");
    let default =
        |json: &Value| load(json).unwrap().materials.into_iter().find(|(name, _)| name == "default").unwrap().1;
    let reported = |json: &Value| notes(json).join("\n").matches("without a material are grey plastic").count();
    assert_eq!((default(&json), reported(&json)), (written("Pbr()"), 0));
    json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5.0.21");
    let grey = written("Pbr(base_color: Rgb(0.8, 0.8, 0.8), metallic: 0, roughness: 0.5)");
    assert_eq!((default(&json), reported(&json)), (grey, 1));
    assert_eq!(reported(&room().0), 0);
}

#[test]
fn a_file_by_blender_without_lamps_or_cameras_says_what_to_tick() {
    let of_blender = |mut json: Value| {
        json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5.0.21");
        json
    };
    let ticked = |json: &Value, what: &str| notes(json).join("\n").matches(what).count();
    let [lamps, cameras] = ["Punctual Lights is ticked", "Cameras is ticked"];
    let dark = of_blender(changed("/scenes/0/nodes", json!([0, 1])));
    assert_eq!((ticked(&dark, lamps), ticked(&dark, cameras)), (1, 1), "{:?}", notes(&dark));
    assert_eq!(ticked(&dark, "area lamps and the world"), 1);
    // Surfaces that emit are no lamps.
    assert_eq!((ticked(&of_blender(room().0), lamps), ticked(&of_blender(room().0), cameras)), (1, 0));
    assert_eq!(ticked(&of_blender(with_lights()), lamps), 0);
    // Another program's file, and one that is an object of a scene with lights of its own.
    let other = changed("/scenes/0/nodes", json!([0, 1]));
    assert_eq!((ticked(&other, lamps), ticked(&other, cameras)), (0, 0));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("dark.glb"), glb(&dark, &room().1)).unwrap();
    let scene = scene_with(folder.path(), r#"Gltf(path: "dark.glb")"#).unwrap();
    assert!(!scene.warnings().join("\n").contains("ticked"), "{:?}", scene.warnings());
}

#[test]
fn a_sun_is_added_on_request() {
    let sun = GltfOptions { sun: Some((30.0, 90.0)), ..GltfOptions::default() };
    let scene = load_as(&changed("/scenes/0/nodes", json!([0, 4])), &sun).unwrap();
    let Some(&Object::DirectionalLight { direction, irradiance, .. }) = scene.objects.last() else { panic!() };
    // From the east, 30 degrees high.
    assert!((direction - DVec3::new(-(0.75_f64.sqrt()), -0.5, 0.0)).length() < 1e-12, "{direction}");
    assert_eq!(irradiance, DVec3::splat(std::f64::consts::PI));
    assert!(matches!(scene.background, Background::Gradient { .. }));
}

fn scene_with(folder: &Path, objects: &str) -> Result<Scene, Error> {
    let text = format!(
        "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)), objects: [{objects}])"
    );
    Scene::parse(&text, &folder.join("scene.ron"))
}

#[test]
fn a_gltf_file_is_an_object_with_materials_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("models")).unwrap();
    let (mut json, binary) = room();
    json["images"][0] = json!({"uri": "wood%20a.png"});
    fs::write(folder.path().join("models/room.gltf"), gltf::gltf(&json, &binary)).unwrap();
    fs::write(folder.path().join("models/wood a.png"), png()).unwrap();
    let room = r#"Gltf(path: "models/room.gltf")"#;
    let objects = format!(
        r#"{room}, Transformed(by: [Scale(2)], object: Group([{room}])),
        Sphere(center: (0, 0, 0), radius: 1, material: "models/room.gltf#Steel")"#
    );
    let scene = scene_with(folder.path(), &objects).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.materials.len(), 3);
    let mut meshes = 0;
    scene.visit_objects(&mut |_, object| meshes += usize::from(matches!(object, Object::Mesh { .. })));
    assert_eq!((meshes, scene.meshes.len()), (8, 4));
    assert!(scene.bitmaps.colours("models/wood a.png").is_some(), "{:?}", scene.bitmaps);
    let files: Vec<_> =
        scene.inputs().iter().map(|path| path.strip_prefix(folder.path()).unwrap().to_owned()).collect();
    assert_eq!(files, ["scene.ron", "models/room.gltf", "models/wood a.png"].map(std::path::PathBuf::from));

    json["nodes"][0]["mesh"] = json!(9);
    fs::write(folder.path().join("models/room.gltf"), gltf::gltf(&json, &binary)).unwrap();
    let error = scene_with(folder.path(), room).unwrap_err().to_string();
    let location = error.split_once("scene.ron:").unwrap().1;
    assert!(location.starts_with("2:56: objects[0].Gltf.path: "), "{error}");
    assert!(location.ends_with("models/room.gltf: nodes[0].mesh: there is no mesh 9"), "{error}");
    for (path, reason) in [("a.obj", "ends in .gltf or .glb"), ("gone.glb", "cannot read the glTF file")] {
        let error = scene_with(folder.path(), &format!("Gltf(path: {path:?})")).unwrap_err().to_string();
        assert!(error.contains("objects[0].Gltf.path") && error.contains(reason), "{error}");
    }
    for (part, reason) in [
        ("meshes/0/primitives/7", "meshes[0].primitives: there is no primitive 7"),
        ("meshes/9/primitives/0", "meshes: there is no mesh 9"),
        ("nodes/4/primitives/0", "nodes[4]: expected a node with a mesh"),
        ("nodes/99/primitives/0", "nodes[99]: expected a node of the default scene"),
        ("images/0", "expected a mesh, such as #meshes/0/primitives/0"),
    ] {
        let object = format!("Mesh(path: \"models/room.gltf#{part}\", material: \"x\")");
        let error = scene_with(folder.path(), &object).unwrap_err().to_string();
        assert!(error.contains("there is no material"), "{error}");
        let object = object.replace("material: \"x\"", "material: \"models/room.gltf#Steel\"");
        fs::write(folder.path().join("models/good.gltf"), gltf::gltf(&crate::common::gltf::room().0, &binary)).unwrap();
        let all = format!("{object}, Gltf(path: \"models/good.gltf\")").replace("room.gltf", "good.gltf");
        let error = scene_with(folder.path(), &all).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
}

#[test]
fn gltf_options_are_refused_for_scene_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    fs::write(&path, "").unwrap();
    let options = GltfOptions { camera: Some("A".to_owned()), ..GltfOptions::default() };
    let error = Scene::load_as(&path, &options, &mut |_, _, _| {}, &mut Assets::default()).unwrap_err();
    assert!(matches!(error, Error::Usage(_)), "{error}");
    assert!(error.to_string().starts_with("--camera is for scenes that are .glb or .gltf: "), "{error}");
}

/// Nodes whose transforms are written into the vertices, and materials: each of 64,000 takes about as long as each of 1,000. Searched for one
/// by one, 32,000 took 30 times as long as 4,000, so that each of 64,000 would take 9 times as long as each of 1,000. Caches that do not hold a
/// large file make its nodes up to 2.2 times slower, on a machine with other work. The limit is the geometric mean of the two.
#[test]
fn time_grows_with_nodes_and_materials_and_not_with_their_square() {
    const LIMIT: f64 = 4.5;
    const FEW: usize = 1_000;
    const MANY: usize = 64_000;
    let folder = tempfile::tempdir().unwrap();
    let seconds = |json: &Value| {
        let path = folder.path().join("many.glb");
        fs::write(&path, glb(json, &room().1)).unwrap();
        let time = || {
            let clock = cpu_time::ThreadTime::now();
            let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
            (clock.elapsed().as_secs_f64(), scene.meshes.len())
        };
        let [first, second, third] = [time(), time(), time()];
        (first.0.min(second.0).min(third.0), first.1)
    };
    let nodes = |count: usize| {
        let (mut json, _) = room();
        // One of them scales unevenly, and the next one mirrors.
        let scale = |i: usize| if i.is_multiple_of(2) { [1, 2, 1] } else { [-1, 1, 1] };
        let node = |i: usize| json!({"mesh": 0, "scale": scale(i), "translation": [4 * (i % 200), 4 * (i / 200), 0]});
        json["nodes"] = (0..count).map(node).collect();
        json["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
        let (seconds, meshes) = seconds(&json);
        assert_eq!(meshes, count);
        seconds
    };
    let materials = |count: usize| {
        let (mut json, _) = room();
        let mesh = |i: usize| json!({"primitives": [{"attributes": {"POSITION": 0}, "material": i}]});
        // With a note on each.
        let material = |i: usize| json!({"name": format!("m{i}"), "occlusionTexture": {"index": 0}});
        json["meshes"] = (0..count).map(mesh).collect();
        json["materials"] = (0..count).map(material).collect();
        json["nodes"] =
            (0..count).map(|i| json!({"mesh": i, "translation": [4 * (i % 200), 4 * (i / 200), 0]})).collect();
        json["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
        seconds(&json).0
    };
    for (name, ratio) in [("nodes", nodes(MANY) / nodes(FEW)), ("materials", materials(MANY) / materials(FEW))] {
        let ratio = ratio * FEW as f64 / MANY as f64;
        println!("{name}: each of {MANY} takes {ratio:.1} times as long as each of {FEW}");
        assert!(ratio < LIMIT, "{name}: each of {MANY} takes {ratio:.1} times as long as each of {FEW}");
    }
}
