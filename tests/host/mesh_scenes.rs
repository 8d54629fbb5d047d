//! Mesh files as scenes: the materials of .obj, the two forms of .stl, and what is missing or wrong, with its file and line.

use std::fs;
use std::path::Path;

use glam::DVec3;
use gpu_rt::error::Error;
use gpu_rt::scene::{Background, Dielectric, Lambertian, Material, Object, Pbr, Scene, Texture, Transform};
use tempfile::TempDir;

use crate::common::gltf::png;

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn load(folder: &TempDir, name: &str) -> Result<Scene, Error> {
    Scene::load(&folder.path().join(name))
}

fn scene(folder: &TempDir, name: &str) -> Scene {
    load(folder, name).unwrap_or_else(|error| panic!("{error}"))
}

/// The material of a name.
fn material<'a>(scene: &'a Scene, name: &str) -> &'a Material {
    let found = scene.materials.iter().find(|(own, _)| own == name);
    &found.unwrap_or_else(|| panic!("{name} is missing")).1
}

/// A pyramid on a square, each with a material; only the square has texture coordinates.
const MODEL: &str = "mtllib the materials.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                     usemtl the floor\nf 1/1 4/4 3/3 2/2\nusemtl red paint\nf -1 -2 -3\nf 5 1 4\nusemtl the floor\nf 5/1 2/2 1/3\n\
                     usemtl red paint\nf 5 3 2\n";

fn files(model: &str, materials: &str, image: &[u8]) -> TempDir {
    folder(&[
        ("a model.obj", model.as_bytes()),
        ("the materials.mtl", materials.as_bytes()),
        ("maps/check er.png", image),
    ])
}

#[test]
fn an_obj_has_a_mesh_for_each_of_its_materials() {
    let materials = "newmtl the floor # wood\nKd 0 0 0\nmap_Kd -s 1 1 1 maps\\check er.png\n\nnewmtl red paint\nKd 0.8 0.1 0.1\n\
                     Ks 0.5 0.5 0.5\nNs 200\nKe 0 0 0\n";
    let materials = materials.replace(" # wood", "");
    let image = png();
    let folder = files(MODEL, &materials, &image);
    let scene = scene(&folder, "a model.obj");
    let paths = ["a model.obj#materials/0", "a model.obj#materials/1"];
    let objects: Vec<Object> = paths
        .into_iter()
        .zip(["the floor", "red paint"])
        .map(|(path, name)| Object::Mesh { path: path.to_owned(), material: Some(name.to_owned()) })
        .collect();
    assert_eq!(scene.objects, objects);
    let [floor, paint] = paths.map(|path| &scene.meshes[path]);
    assert_eq!((floor.triangles.len(), floor.uvs.len()), (3, 6));
    assert_eq!((paint.triangles.len(), paint.uvs.len()), (3, 0));
    assert_eq!(paint.positions[0], DVec3::new(0.0, 1.5, 0.0), "negative numbers count backwards");
    let image = folder.path().join("maps/check er.png");
    match material(&scene, "the floor") {
        Material::Lambertian(Lambertian { albedo: Texture::Image { path, tint, .. }, emission: None, .. }) => {
            assert_eq!((scene_path(&folder, path), *tint), (image, DVec3::ONE));
        }
        other => panic!("{other:?}"),
    }
    match material(&scene, "red paint") {
        Material::Pbr(Pbr { base_color, roughness, metallic, ior, .. }) => {
            assert_eq!(*base_color, Texture::Rgb(0.8, 0.1, 0.1));
            assert_eq!(
                (roughness.clone(), metallic.clone(), *ior),
                (Texture::grey((2f64 / 202.0).powf(0.25)), Texture::grey(0.0), 1.5)
            );
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(scene.background, Background::Gradient { .. }));
    let notes = scene.warnings().join("\n");
    assert!(notes.contains("the materials.mtl:1: \"the floor\": not read: -s of map_Kd"), "{notes}");
    assert!(!notes.contains("grey plastic"), "{notes}");
    // The scene is read from all of its files.
    let inputs = scene.inputs();
    for name in ["a model.obj", "the materials.mtl", "maps/check er.png"] {
        assert!(inputs.contains(&folder.path().join(name)), "{name}: {inputs:?}");
    }
}

fn scene_path(folder: &TempDir, path: &str) -> std::path::PathBuf {
    folder.path().join(Path::new(path))
}

#[test]
fn statements_of_physically_based_materials_are_read() {
    let model = MODEL.replace("the floor", "a").replace("red paint", "b");
    let read = |statements: &str| {
        let folder = files(&model, &format!("newmtl a\nnewmtl b\n{statements}"), &png());
        material(&scene(&folder, "a model.obj"), "b").clone()
    };
    match read("Kd 0.5 0.4 0.3\nPr 0.25\nPm 0.75\nNi 1.33\nKe 3 2 1\nTr 0.25\n") {
        Material::Pbr(Pbr { roughness, metallic, ior, emission, alpha, .. }) => {
            assert_eq!((roughness, metallic, ior), (Texture::grey(0.25), Texture::grey(0.75), 1.33));
            assert_eq!((emission, alpha), (Some(Texture::Rgb(3.0, 2.0, 1.0)), Texture::grey(0.75)));
        }
        other => panic!("{other:?}"),
    }
    let glass = Material::Dielectric(Dielectric {
        ior: 1.4,
        transmittance: Some(Texture::Rgb(1.0, 0.5, 0.5)),
        absorption: None,
        dispersion: 0.0,
    });
    assert_eq!(read("illum 7\nNi 1.4\nTf 1 0.5 0.5\n"), glass);
    assert!(matches!(
        read("Ks 0 0 0\nKd 0.5\n"),
        Material::Lambertian(Lambertian { albedo: Texture::Rgb(0.5, 0.5, 0.5), .. })
    ));
    // An emitter lights the file, and a dim one does not.
    for (light, has_sky) in [("Ke 20 20 20", false), ("Ke 0.001 0 0", true), ("", true)] {
        let folder = files(&model, &format!("newmtl a\nnewmtl b\n{light}\n"), &png());
        assert_eq!(matches!(scene(&folder, "a model.obj").background, Background::Gradient { .. }), has_sky, "{light}");
    }
}

/// The name of an image begins behind its options and their values, also a name of spaces that begins with a number.
#[test]
fn images_are_found_behind_their_options() {
    let model = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    for (line, file) in [
        ("map_Kd -s 2 2 1 -o .5 0.25 -clamp on my wood.png", "my wood.png"),
        ("map_Kd -s 2 2 1 3 woods.png", "3 woods.png"),
        ("norm -bm 0.5 2 nails.png", "2 nails.png"),
        ("map_Pr -imfchan r -mm 0 1 maps\\rough one.png", "maps/rough one.png"),
        ("map_d -cc off C:\\me\\my alpha.png", "my alpha.png"),
        ("map_Ke e.png", "e.png"),
    ] {
        let materials = format!("newmtl m\nKs 1 1 1\n{line}\n");
        let folder = folder(&[("a.obj", model.as_bytes()), ("m.mtl", materials.as_bytes()), (file, &png())]);
        let scene = scene(&folder, "a.obj");
        let named = scene.inputs().iter().filter(|path| path.ends_with(file)).count();
        let options = line.split(' ').filter(|word| word.starts_with('-') && word.len() > 1);
        let notes = scene.warnings().join("\n");
        let told = options.clone().all(|option| notes.contains(&format!("{option} of ")));
        assert!(named == 1 && told && notes.contains("not read") == options.count().gt(&0), "{line}: {notes}");
    }
}

/// Colours of vertices: of 8 and 16 bits and floats, in text and binary, they are those of sRGB; those of an .obj are named.
#[test]
fn a_ply_shows_the_colours_of_its_vertices() {
    let header = |kind: &str, colour: &str| {
        let colours: String = ["red", "green", "blue"].map(|name| format!("property {colour} {name}\n")).concat();
        let position = "property float x\nproperty float y\nproperty float z\n";
        format!(
            "ply\nformat {kind} 1.0\nelement vertex 3\n{position}{colours}element face 1\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let corners = ["0 0 0", "1 0 0", "0 1 0"];
    let text = |kind: &str, colours: [&str; 3]| {
        let rows: String = corners.iter().zip(colours).map(|(at, colour)| format!("{at} {colour}\n")).collect();
        format!("{}{rows}3 0 1 2\n", header("ascii", kind)).into_bytes()
    };
    let bytes = [[0u8, 0, 0], [255, 128, 0], [0, 0, 255]];
    let places = [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let mut binary = header("binary_little_endian", "uchar").into_bytes();
    for (at, colour) in places.iter().zip(bytes) {
        binary.extend(at.iter().flat_map(|x| x.to_le_bytes()).chain(colour));
    }
    binary.extend([3].into_iter().chain([0i32, 1, 2].into_iter().flat_map(i32::to_le_bytes)));
    // By IEC 61966-2-1: ((128/255 + 0.055) / 1.055)^2.4 = 0.215 860 5, of 65535 steps 14 146.
    let expected = [[0, 0, 0], [65535, 14146, 0], [0, 0, 65535]];
    for file in [
        binary,
        text("uchar", ["0 0 0", "255 128 0", "0 0 255"]),
        text("ushort", ["0 0 0", "65535 32896 0", "0 0 65535"]),
        text("float", ["0 0 -1", "1 0.50196078 0", "0 0 7"]),
    ] {
        let scene = scene(&folder(&[("a.ply", &file)]), "a.ply");
        assert!(matches!(material(&scene, "default"), Material::Pbr(Pbr { vertex_colors: true, .. })));
        assert_eq!(scene.meshes["a.ply"].colours, expected);
    }
    let plain = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                  property list uchar int vertex_indices\nproperty uchar red\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9\n";
    let scene = scene(&folder(&[("a.ply", plain)]), "a.ply");
    assert!(matches!(material(&scene, "default"), Material::Pbr(Pbr { vertex_colors: false, .. })));
    let obj = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1 # blue\nusemtl x\nf 1 2 3\n";
    let said = |obj: &str| self::scene(&folder(&[("a.obj", obj.as_bytes())]), "a.obj").warnings().join("\n");
    let words = "the colours of its vertices are not read: save it as .ply or .glb";
    assert!(said(obj).contains(words));
    // A weight, and words behind a #.
    let plain = "v 0 0 0 1\nv 1 0 0 # 1 2 3\nv 0 1 0\nusemtl x\nf 1 2 3\n";
    assert!(!said(plain).contains(words));
}

#[test]
fn what_an_obj_lacks_is_said_with_its_line() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let said = |files: &[(&str, &str)], expected: &[&str]| {
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
        let scene = scene(&folder(&files), "a.obj");
        let notes = scene.warnings().join("\n");
        for words in expected {
            assert!(notes.contains(words), "{words}: {notes}");
        }
        scene
    };
    let grey = |scene: &Scene, name: &str| {
        assert!(matches!(material(scene, name), Material::Pbr(Pbr { base_color: Texture::Rgb(0.8, 0.8, 0.8), .. })));
    };
    grey(&said(&[("a.obj", triangle)], &["nothing in it emits light"]), "default");
    let named = format!("\nmtllib gone.mtl\nusemtl x\n{triangle}");
    grey(&said(&[("a.obj", &named)], &["a.obj:2: mtllib: there is no file", "gone.mtl"]), "x");
    let other = [("a.obj", named.as_str()), ("gone.mtl", "newmtl y\n")];
    grey(&said(&other, &["a.obj:3: usemtl: there is no material \"x\": it is grey plastic"]), "x");
    let image =
        [("a.obj", named.as_str()), ("gone.mtl", "newmtl x\nKd 0.5 0.25 0.5\nmap_Kd C:\\me\\wood.png\nbump b.png\n")];
    let scene = said(&image, &["gone.mtl:3: map_Kd: there is no file", "gone.mtl:1: \"x\": not read: bump"]);
    assert!(matches!(
        material(&scene, "x"),
        Material::Lambertian(Lambertian { albedo: Texture::Rgb(0.5, 0.25, 0.5), .. })
    ));
    // An image that is there, on faces without texture coordinates.
    let beside = folder(&[
        ("a.obj", named.as_bytes()),
        ("gone.mtl", b"newmtl x\nmap_Kd C:\\me\\wood.png\n"),
        ("wood.png", &png()),
    ]);
    let notes = self::scene(&beside, "a.obj").warnings().join("\n");
    assert!(
        notes.contains("gone.mtl:2: map_Kd: some of its faces have no texture coordinates: it is left out"),
        "{notes}"
    );
}

/// A tetrahedron.
fn triangles() -> [[[f32; 3]; 3]; 4] {
    let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    [[o, y, x], [o, z, y], [o, x, z], [x, y, z]]
}

fn binary(header: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for triangle in triangles() {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text() -> String {
    let corner = |[x, y, z]: [f32; 3]| format!("    vertex {x} {y} {z}\n");
    let facet = |corners: [[f32; 3]; 3]| {
        format!("  facet normal 0 0 0\n   outer loop\n{}   endloop\n  endfacet\n", corners.map(corner).concat())
    };
    format!("solid a tetrahedron\n{}endsolid\n", triangles().map(facet).concat())
}

#[test]
fn both_forms_of_stl_are_one_closed_mesh_with_z_up() {
    for bytes in [text().into_bytes(), binary(b"by a program", 4), binary(b"solid by a program", 4)] {
        let scene = scene(&folder(&[("a.stl", &bytes)]), "a.stl");
        let mesh = &scene.meshes["a.stl"];
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.open_edges()), (4, 4, None));
        assert!(mesh.volume_is_positive() && mesh.warnings.is_empty());
        let [Object::Transformed { by, object }] = scene.objects.as_slice() else { panic!("{:?}", scene.objects) };
        assert_eq!(*by, [Transform::RotateX(-90.0)]);
        assert_eq!(**object, Object::Mesh { path: "a.stl".to_owned(), material: Some("default".to_owned()) });
        assert!(matches!(scene.background, Background::Gradient { .. }));
        // The camera sees all of it: its middle, with z up.
        assert!((scene.camera.look_at - DVec3::new(0.5, 0.5, -0.5)).length() < 1e-12, "{:?}", scene.camera);
    }
    let more = scene(&folder(&[("a.stl", &binary(b"", 3))]), "a.stl");
    assert_eq!(more.meshes["a.stl"].triangles.len(), 3);
    assert!(more.warnings().join("\n").contains("50 bytes after its triangles are not read"));
}

#[test]
fn broken_mesh_scenes_are_refused_with_file_and_line() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases: Vec<(&str, Vec<u8>, &[&str])> = vec![
        ("a.obj", format!("{triangle}f 1 2 9\n").into(), &["a.obj:4:1: ", "there is no position 9", "has 3"]),
        ("a.obj", format!("{triangle}f 1 2 -9\n").into(), &["a.obj:4:1: ", "expected a corner", "\"-9\""]),
        ("a.obj", "v 0 x 0\n".into(), &["a.obj:1:1: ", "expected a number, found \"x\""]),
        ("a.obj", triangle.into(), &["a.obj: ", "it has no faces"]),
        ("a.obj", format!("mtllib a.mtl\n{triangle}f 1 2 3\n").into(), &["a.mtl:3:1: ", "Kd", "found \"red\""]),
        (
            "a.stl",
            text().replacen("vertex 0 1 0", "vertex 0 one 0", 1).into(),
            &["a.stl:5:1: ", "three numbers", "one"],
        ),
        ("a.stl", text().replacen("outer", "inner", 1).into(), &["a.stl:3:1: ", "found \"inner\""]),
        ("a.stl", text().as_bytes()[..72].to_vec(), &["a.stl", "ends within a facet"]),
        ("a.stl", binary(b"", 4000), &["a.stl", "4000 triangles, which take 200084 bytes, and it has 284"]),
        ("a.stl", b"nothing".into(), &["a.stl", "expected solid"]),
        ("a.stl", Vec::new(), &["a.stl", "the file is empty: expected an STL file"]),
        ("a.stl", b"solid\nendsolid\n".into(), &["a.stl", "no faces"]),
    ];
    for (name, bytes, expected) in cases {
        let folder = folder(&[(name, &bytes), ("a.mtl", b"# a comment\nnewmtl x\nKd red\n")]);
        let error = load(&folder, name).expect_err(name);
        assert_eq!(error.exit_status(), 2);
        for words in expected {
            assert!(error.to_string().contains(words), "{words}: {error}");
        }
    }
}
