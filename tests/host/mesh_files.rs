//! Meshes by every format: what is read, and what is refused. (Damaged ones: tests/long/fuzz.rs.)

use crate::common::gltf::{glb, square};
use crate::common::meshes::{Quads, cube, cubes};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use base64::Engine;
use glam::{DVec3, Vec3};
use gpu_rt::error::Error;
use gpu_rt::scene::{Assets, GltfOptions, Mesh, OpenEdges, Scene};
use serde_json::json;

/// A scene with one object.
fn scene(folder: &Path, object: &str) -> Result<Scene, Error> {
    let map = match object.contains("map") {
        true => ", \"map\": Lambertian(albedo: Image(path: \"map.png\"))",
        false => "",
    };
    let text = format!(
        "(
    image: (width: 4, height: 3),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)),
    materials: {{ \"grey\": Metal(albedo: Rgb(0.5, 0.5, 0.5)){map} }},
    objects: [
        {object},
    ],
)
"
    );
    Scene::parse(&text, &folder.join("scene.ron"))
}

fn object(file: &str) -> String {
    format!("Mesh(path: {file:?}, material: \"grey\")")
}

/// The scene of a mesh whose file has these bytes.
fn scene_of(file: &str, bytes: &[u8]) -> Result<Scene, Error> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), bytes).unwrap();
    scene(folder.path(), &object(file))
}

fn mesh(file: &str, bytes: &[u8]) -> Mesh {
    let mut scene = scene_of(file, bytes).unwrap_or_else(|error| panic!("{error}"));
    scene.meshes.remove(file).and_then(Arc::into_inner).unwrap()
}

/// The error's text after its location, which is the object's path.
fn refused(file: &str, bytes: &[u8]) -> String {
    let error = scene_of(file, bytes).err().unwrap_or_else(|| panic!("{file} was accepted"));
    assert_eq!(error.exit_status(), 2);
    let Error::Scene { location, field, message } = error else { panic!("{error}") };
    assert_eq!((location.line, location.column, field.as_str()), (7, 20, "objects[0].Mesh.path"), "{message}");
    assert!(message.contains(file), "{message}");
    message
}

#[test]
fn every_format_gives_the_same_mesh() {
    let expected = cube().expected();
    for (file, bytes) in cubes() {
        let mut found = mesh(file, &bytes);
        if file.ends_with("gltf") || file.ends_with("glb") {
            // Its quads had to be cut before.
            assert_eq!(found.faces, (0..12).collect::<Vec<u32>>());
            found.faces.clone_from(&expected.faces);
        }
        if file.ends_with("obj") {
            let words = "its materials, in \"missing.mtl\" (mtllib), are not read: the mesh has the one that the scene gives it";
            assert_eq!(std::mem::take(&mut found.warnings), [words]);
        }
        assert_eq!(found, expected, "{file}");
        assert_eq!(found.open_edges(), None, "{file}");
        assert!(found.volume_is_positive(), "{file}");
        assert_eq!((found.bounds().min, found.bounds().max), (DVec3::NEG_ONE, DVec3::ONE));
    }
}

#[test]
fn a_gltf_buffer_may_lie_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sub dir")).unwrap();
    fs::write(folder.path().join("sub dir/b.bin"), cube().buffer()).unwrap();
    fs::write(folder.path().join("cube.gltf"), cube().gltf(r#""uri": "sub%20dir/b.bin","#, "")).unwrap();
    let loaded = scene(folder.path(), &object("cube.gltf")).unwrap();
    assert_eq!(loaded.meshes["cube.gltf"].positions, cube().expected().positions);
    fs::write(folder.path().join("sub dir/b.bin"), &cube().buffer()[..100]).unwrap();
    let error = scene(folder.path(), &object("cube.gltf")).unwrap_err().to_string();
    assert!(error.contains("buffers[0]: expected 840 bytes, found 100"), "{error}");
    fs::remove_file(folder.path().join("sub dir/b.bin")).unwrap();
    let error = scene(folder.path(), &object("cube.gltf")).unwrap_err().to_string();
    assert!(error.contains("b.bin: cannot read the buffer"), "{error}");
}

#[test]
fn node_transforms_are_applied_and_mirrors_turn_the_winding() {
    let straight = r#", "scale": [2, 1, 1], "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476], "translation": [10, 0, 0]"#;
    let mirrored = r#", "matrix": [-2,0,0,0, 0,1,0,0, 0,0,1,0, 10,0,0,1]"#;
    for (node, low) in [(straight, DVec3::new(9.0, -1.0, -2.0)), (mirrored, DVec3::new(8.0, -1.0, -1.0))] {
        let mesh = mesh("cube.gltf", cube().gltf_with_base64(node).as_bytes());
        assert!(mesh.bounds().min.abs_diff_eq(low, 1e-6), "{:?}", mesh.bounds());
        assert_eq!(mesh.open_edges(), None);
        assert!(mesh.volume_is_positive());
        for &[a, b, c] in &mesh.triangles {
            let [p, q, r] = [a, b, c].map(|corner| mesh.positions[corner as usize]);
            let outside = (q - p).cross(r - p).normalize();
            assert!(outside.dot(p + q + r - 3.0 * DVec3::new(10.0, 0.0, 0.0)) > 0.0);
            assert!((mesh.normals[a as usize].as_dvec3() - outside).length() < 1e-6);
        }
    }
}

#[test]
fn gltf_strips_fans_and_lists_without_indices_are_triangles() {
    // A square, its corners in the order of a strip, of a fan and of a list.
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for (mode, corners) in [(5, vec![a, b, d, c]), (6, vec![a, b, c, d]), (4, vec![a, b, c, a, c, d])] {
        let count = corners.len();
        let bytes: Vec<u8> = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0f32]).flat_map(f32::to_le_bytes).collect();
        let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
  "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "mode": 1}}, {{"attributes": {{"POSITION": 0}}, "mode": {mode}}}]}}],
  "accessors": [{{"bufferView": 0, "componentType": 5126, "count": {count}, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}],
  "bufferViews": [{{"buffer": 0, "byteLength": {0}}}],
  "buffers": [{{"uri": "data:application/gltf-buffer;base64,{data}", "byteLength": {0}}}]}}"#,
            bytes.len()
        );
        let mesh = mesh("square.gltf", text.as_bytes());
        let area = |&[a, b, c]: &[u32; 3]| {
            let [p, q, r] = [a, b, c].map(|corner| mesh.positions[corner as usize]);
            0.5 * (q - p).cross(r - p)
        };
        let areas: Vec<DVec3> = mesh.triangles.iter().map(area).collect();
        assert_eq!(areas, [DVec3::new(0.0, 0.0, 0.5); 2], "mode {mode}");
        assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
    }
}

#[test]
fn sparse_accessors_replace_elements() {
    let (cube, text) = (cube(), cube().gltf_with_base64(""));
    let corner = [3.0f32, 4.0, 5.0];
    let bytes: Vec<u8> = [23, 0, 0, 0].into_iter().chain(corner.into_iter().flat_map(f32::to_le_bytes)).collect();
    let sparse = |bytes: &[u8]| {
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        let count = bytes.len();
        let replace = r#""sparse": {"count": 1, "indices": {"bufferView": 4, "componentType": 5121}, "values": {"bufferView": 5}}"#;
        let views = r#", {"buffer": 1, "byteLength": 1}, {"buffer": 1, "byteOffset": 4, "byteLength": 12}"#;
        let (before, buffers) = text.split_once("],\n  \"buffers\"").unwrap();
        let text = format!("{before}{views}],\n  \"buffers\"{buffers}");
        let text = text.replacen(r#""type": "VEC3""#, &format!(r#""type": "VEC3", {replace}"#), 1);
        let text = text.strip_suffix("]}").unwrap();
        format!(r#"{text}, {{"uri": "data:;base64,{data}", "byteLength": {count}}}]}}"#)
    };
    let mut expected = cube.expected().positions;
    expected[23] = DVec3::from(corner.map(f64::from));
    assert_eq!(mesh("sparse.gltf", sparse(&bytes).as_bytes()).positions, expected);
    assert!(refused("sparse.gltf", sparse(&bytes[..15]).as_bytes()).contains("reaches past the end of its buffer"));
}

#[test]
fn obj_files_are_read_as_they_are_written() {
    // Latin-1 in a comment, Windows' line ends, joined lines, numbers backwards, colours, lines and free curves.
    let text = b"# caf\xe9\r\nv 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0 1.0\r\nv 0 1e0 \\\r\n  0\r\nl 1 2\r\ncurv 0 1\r\n\
                 f -4 -3 -2 -1 # all\r\nvn 0 0 2\r\nf 1//1 3//1 2//1\r\nf 1 2\r\nf 5 6 7\nv 0 0 1\nv 1 0 1\nv 0 1 1";
    let mesh = mesh("odd.obj", text);
    assert_eq!(mesh.triangles.len(), 4);
    assert_eq!(mesh.faces, [0, 0, 1, 3]);
    assert!(mesh.normals.is_empty(), "some corners have none");
    assert_eq!(mesh.warnings.len(), 3, "{:?}", mesh.warnings);
    assert!(mesh.warnings[0].starts_with("the colours of its vertices are not read"), "{:?}", mesh.warnings);
    assert!(mesh.warnings[1].starts_with("1 of 4 faces has no area and was left out, the first is face 2"));
    assert!(mesh.warnings[2].contains("flat-shaded"), "{:?}", mesh.warnings);
}

const PLAIN: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 2 0 0\n";

#[test]
fn faces_without_area_are_left_out_and_reported() {
    // Two corners at one position; three on a line, which stays; a polygon of which a part stays.
    let text = format!("{PLAIN}f 1 2 3\nf 1 4 2\nf 1 2 5\nf 1 4 2 3\nf 3 3 3\n");
    let scene = scene_of("flat.obj", text.as_bytes()).unwrap();
    assert_eq!(scene.meshes["flat.obj"].faces, [0, 2, 3]);
    let warnings = scene.warnings().join("\n");
    let words = "objects[0].Mesh.path: flat.obj: 2 of 5 faces have no area and were left out, the first is face 1 (counted from 0)";
    assert!(warnings.contains(words), "{warnings}");
    let message = refused("flat.obj", format!("{PLAIN}f 1 4 2\nf 3 3 3\n").as_bytes());
    assert!(message.contains("none of its 2 faces has an area"), "{message}");
}

#[test]
fn vertices_that_no_face_uses_may_be_anything() {
    let mesh = mesh("spare.obj", b"v NaN 0 0\nv 0 0 0\nv 1e200 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 2 4 5\n");
    assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert!(mesh.warnings.is_empty());
}

#[test]
fn broken_normals_are_dropped_and_reported() {
    let with = |normal: &str| {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1e-30\nvn {normal}\nf 1//1 2//1 3//2\n");
        mesh("normals.obj", text.as_bytes())
    };
    assert_eq!(with("3e38 3e38 0").normals[0], Vec3::Z);
    assert!((with("3e38 3e38 0").normals[2].length() - 1.0).abs() < 1e-6);
    for (broken, words) in [
        ("0 0 0", "some corners have no normal, or one of length 0"),
        ("NaN 0 0", "line 5: expected finite numbers of at most 3.4e38 in magnitude, found \"NaN\""),
        ("1e39 0 0", "line 5: expected finite numbers"),
    ] {
        assert!(with(broken).normals.is_empty(), "{broken}");
        let warning = &with(broken).warnings[0];
        assert!(warning.starts_with(words) && warning.contains("flat-shaded"), "{broken}: {warning}");
    }
}

/// Numbers that are not finite are named with their location, in every list of every format, and not reported as missing.
#[test]
fn numbers_that_are_not_finite_are_named_with_their_location() {
    for (written, found) in [("nan", "NaN"), ("NaN", "NaN"), ("inf", "inf"), ("-inf", "-inf"), ("1e999", "inf")] {
        let obj = |v: &str, vt: &str, vn: &str| {
            let text = format!(
                "# a triangle\nv 0 0 0\nv 1 0 0\nv 0 {v} 0 0.5\nv inf nan 0\nvt 0 0\nvt nan nan\nvt 1 {vt}\n\
                 vn 0 0 1\nvn 0 {vn} 1\nf 1/1/1 2/1/1 3/3/2\n"
            );
            scene_of("a.obj", text.as_bytes()).map(|scene| scene.meshes["a.obj"].clone())
        };
        // Entries that no face uses may be anything.
        let full = obj("1", "1", "0").unwrap_or_else(|reason| panic!("{reason}"));
        assert!(full.warnings.is_empty() && full.uvs.len() == 3 && full.normals.len() == 3, "{:?}", full.warnings);
        let error = obj(written, "1", "0").expect_err("a vertex is not finite").to_string();
        let expected = format!("line 4: expected finite numbers of at most 1e100 in magnitude, found {written:?}");
        assert!(error.contains(&expected), "{error}");
        let [uv, normal] =
            [obj("1", written, "0"), obj("1", "1", written)].map(|mesh| mesh.expect("it is read").warnings.clone());
        // The entry that no face uses comes first.
        assert!(
            uv[0].starts_with("line 7: expected finite numbers")
                && uv[0].ends_with("all texture coordinates are ignored"),
            "{uv:?}"
        );
        assert!(
            normal[0].starts_with("line 10: expected finite numbers")
                && normal[0].contains(&format!("found {written:?}")),
            "{normal:?}"
        );

        let ply = |x: &str, u: &str, nz: &str| {
            let properties =
                ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(|name| format!("property double {name}\n")).concat();
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\n{properties}element face 1\nproperty list uchar int vertex_indices\n\
                 end_header\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n{x} 1 0 0 0 {nz} {u} 1\n3 0 1 2\n"
            );
            scene_of("a.ply", text.as_bytes()).map(|scene| scene.meshes["a.ply"].clone())
        };
        let error = ply(written, "0", "1").expect_err("a vertex is not finite").to_string();
        assert!(
            error.contains("face 0 (counted from 0): expected finite coordinates")
                && error.contains(&format!("({found}, 1, 0) at vertex 2")),
            "{error}"
        );
        let [uv, normal] =
            [ply("0", written, "1"), ply("0", "0", written)].map(|mesh| mesh.expect("it is read").warnings.clone());
        let expected = format!("vertex 2 (counted from 0): expected finite texture coordinates, found ({found}, 1)");
        assert!(uv[0].starts_with(&expected), "{uv:?}");
        let expected = format!("vertex 2 (counted from 0): expected a finite normal, found (0, 0, {found})");
        assert!(normal[0].starts_with(&expected), "{normal:?}");
    }
    for bad in [f32::NAN, f32::INFINITY] {
        let (uvs, normals, colours) =
            ([0., 0., 1., 0., 1., bad, 0., 1.], [0., bad, 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.], [0.5; 12]);
        let read = |attributes: &[(&str, usize, &[f32])]| {
            let (json, binary) = square(attributes, &json!({}), &[]);
            scene_of("a.glb", &glb(&json, &binary)).map(|scene| scene.meshes["a.glb"].warnings.clone())
        };
        let warnings =
            read(&[("TEXCOORD_0", 2, &uvs), ("NORMAL", 3, &normals), ("COLOR_0", 3, &colours)]).expect("it is read");
        for (attribute, vertex) in [("NORMAL", 0), ("TEXCOORD_0", 2)] {
            let at = format!("meshes[0].primitives[0].attributes.{attribute}: expected finite numbers, found ");
            let is_reported =
                |words: &String| words.starts_with(&at) && words.contains(&format!(" at vertex {vertex}: all "));
            assert!(warnings.iter().any(is_reported), "{warnings:#?}");
        }
        let mut colours = colours;
        colours[4] = bad;
        let error = read(&[("COLOR_0", 3, &colours)]).expect_err("a colour is not finite").to_string();
        assert!(error.contains("attributes.COLOR_0: expected finite numbers, found others at vertex 1"), "{error}");
        let mut moved = square(&[], &json!({}), &[]);
        moved.1[..4].copy_from_slice(&bad.to_le_bytes());
        let error = scene_of("a.glb", &glb(&moved.0, &moved.1)).expect_err("a position is not finite").to_string();
        assert!(error.contains("expected finite coordinates"), "{error}");
    }
    // A material with an image needs the texture coordinates: why there are none is said.
    let folder = tempfile::tempdir().unwrap();
    image::RgbImage::new(2, 2).save(folder.path().join("map.png")).unwrap();
    fs::write(folder.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt nan 1\nf 1/1 2/1 3/2\n").unwrap();
    let error = scene(folder.path(), "Mesh(path: \"a.obj\", material: \"map\")").unwrap_err().to_string();
    assert!(
        error.contains("(line 5: expected finite numbers of at most") && error.contains("found \"nan\""),
        "{error}"
    );
}

#[test]
fn unreadable_meshes_are_refused_with_the_reason() {
    const CORNER: &str = "expected a corner such as 5";
    let ply = |header: &str, rows: &str| format!("ply\nformat ascii 1.0\n{header}end_header\n{rows}");
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let face = format!("{vertices}element face 1\nproperty list uchar int vertex_indices\n");
    let rows = "0 0 0\n1 0 0\n0 1 0\n";
    let gltf = cube().gltf_with_base64("");
    let cases: Vec<(&str, String, &[&str])> = vec![
        ("a.obj", String::new(), &["empty", "an OBJ file"]),
        ("a.ply", String::new(), &["empty", "a PLY file"]),
        ("a.glb", String::new(), &["empty", "a glTF file"]),
        ("a.obj", "# nothing\n".into(), &["no faces", "three corners"]),
        ("a.obj", format!("{PLAIN}f 1 2\n"), &["none of its 1 faces has an area"]),
        ("a.obj", format!("{PLAIN}f 1 2 3\nf 1 2 6\n"), &["face 1 (counted from 0)", "no position 6", "has 5"]),
        ("a.obj", format!("{PLAIN}f 1/2 2/2 3/2\nvt 0 0\n"), &["face 0", "no pair of texture coordinates 2"]),
        ("a.obj", format!("{PLAIN}f 1//1 2//1 3//1\n"), &["face 0", "no normal 1", "has 0"]),
        ("a.obj", format!("{PLAIN}f 1 2 3\nf 0 1 2\n"), &["line 7", "face 1 (counted from 0)", CORNER, "found \"0\""]),
        ("a.obj", format!("{PLAIN}f 1 2 -6\n"), &["line 6", CORNER, "\"-6\""]),
        ("a.obj", format!("{PLAIN}f 1 2 3/4/5/6\n"), &[CORNER]),
        ("a.obj", format!("{PLAIN}f 1 2 x\n"), &[CORNER, "\"x\""]),
        ("a.obj", format!("{PLAIN}f 1//6148914691236517206 2 3\n"), &[CORNER]),
        ("a.obj", "v 1 2\n".into(), &["line 1", "expected 3 numbers, found 2"]),
        ("a.obj", "v 1 2 z\n".into(), &["line 1", "expected a number, found \"z\""]),
        ("a.obj", format!("{PLAIN}v NaN 0 0\nf 1 2 6\n"), &["line 6", "finite", "found \"NaN\""]),
        ("a.obj", format!("{PLAIN}v 0 2e100 0\nf 1 2 3\nf 1 2 6\n"), &["line 6", "1e100", "found \"2e100\""]),
        ("a.ply", "solid\n".into(), &["line 1", "expected ply"]),
        ("a.ply", "ply\nformat ascii 1.0\n".into(), &["ends in its header"]),
        ("a.ply", "ply\nformat middle_endian 1.0\n".into(), &["line 2", "binary_big_endian"]),
        ("a.ply", "ply\nproperty float x\n".into(), &["line 2", "an element before"]),
        ("a.ply", "ply\nelement vertex x\n".into(), &["line 2", "element NAME COUNT"]),
        ("a.ply", "ply\nelement vertex 1\nproperty half x\n".into(), &["line 3", "property TYPE NAME"]),
        ("a.ply", "ply\nwhat is this\n".into(), &["line 2", "found \"what\""]),
        ("a.ply", "ply\nelement vertex 0\nelement face 0\nend_header\n".into(), &["format ascii 1.0"]),
        ("a.ply", ply(vertices, rows), &["expected an element face"]),
        ("a.ply", ply(&face.replace("float z", "float w"), rows), &["properties x, y and z"]),
        ("a.ply", ply(&face.replace("vertex_indices", "corners"), rows), &["property list vertex_indices"]),
        ("a.ply", ply(&face, rows), &["ends in face 0 (counted from 0) of 1"]),
        ("a.ply", ply(&face, "0 0 0\n1 0"), &["ends in vertex 1 (counted from 0) of 3"]),
        ("a.ply", ply(&face, "0 0 0\n1 0 o\n"), &["vertex 1", "expected a number, found \"o\""]),
        ("a.ply", ply(&face, &format!("{rows}3 0 1 3")), &["face 0 (counted from 0)", "no vertex 3", "has 3"]),
        ("a.ply", ply(&face, &format!("{rows}3 0 1 -1")), &["face 0", "the number of a vertex", "found -1"]),
        ("a.ply", ply(&face, &format!("{rows}3 0 1 0.5")), &["face 0", "found 0.5"]),
        ("a.ply", ply(&face, &format!("{rows}-3 0 1 2")), &["face 0", "a number of corners", "found -3"]),
        ("a.ply", ply(&face.replace("face 1", "face 0"), rows), &["no faces"]),
        ("a.ply", ply(&face.replace("vertex 3", "vertex 4000000000"), rows), &["ends in vertex 3", "4000000000"]),
        ("a.ply", ply(&face.replace("vertex 3", "vertex 18446744073709551615"), rows), &["at most 4294967295"]),
        ("a.ply", ply(&face.replace("face 1", "face 18446744073709551615"), rows), &["ends in face 0"]),
        ("a.gltf", "{}".into(), &["expected the JSON of a glTF 2.0 file", "asset"]),
        ("a.gltf", gltf.replace("\"2.0\"", "\"1.0\""), &["version 2.0", "found \"1.0\""]),
        (
            "a.gltf",
            gltf.replacen('{', "{\"extensionsRequired\": [\"ACME_gizmo\"], ", 1),
            &["ACME_gizmo", "export it without"],
        ),
        (
            "a.gltf",
            gltf.replace("\"componentType\": 5123", "\"componentType\": 5122"),
            &["indices", "5121, 5123 or 5125"],
        ),
        (
            "a.gltf",
            gltf.replace("\"componentType\": 5126", "\"componentType\": 5127"),
            &["accessor 0", "a componentType from 5120 to 5126"],
        ),
        ("a.gltf", gltf.replace("\"type\": \"VEC2\"", "\"type\": \"VEC4\""), &["type VEC2", "VEC4"]),
        ("a.gltf", gltf.replace("\"bufferView\": 0", "\"byteOffset\": 0"), &["no bufferView"]),
        ("a.gltf", gltf.replace("\"NORMAL\": 1", "\"NORMAL\": 9"), &["meshes[0].primitives[0]", "no accessor 9"]),
        (
            "a.gltf",
            gltf.replace("\"count\": 24", "\"count\": 25"),
            &["meshes[0].primitives[0]", "past the end of its buffer"],
        ),
        ("a.gltf", gltf.replace("\"count\": 24", "\"count\": 18446744073709551615"), &["past the end of its buffer"]),
        ("a.gltf", gltf.replace("\"children\": [0]", "\"children\": [0, 1]"), &["nodes[1]: it occurs twice", "a tree"]),
        ("a.gltf", gltf.replace("\"scene\": 1", "\"scene\": 0"), &["no faces"]),
        ("a.gltf", gltf.replace("data:application", "http://x"), &["buffers[0]", "the path of a file"]),
        ("a.gltf", gltf.replace(";base64,", ";base64,%"), &["buffers[0]", "base64"]),
    ];
    for (file, text, words) in cases {
        let message = refused(file, text.as_bytes());
        for word in words {
            assert!(message.contains(word), "{message}\nexpected {word:?} of\n{text}");
        }
    }
    let glb = cube().glb();
    assert!(refused("a.glb", &glb[..glb.len() - 1]).contains("expected a GLB file of version 2"));
    for (file, bytes) in cubes() {
        refused(file, &bytes[..bytes.len() / 2]);
    }
}

#[test]
fn a_medium_fills_a_closed_mesh_only() {
    let folder = tempfile::tempdir().unwrap();
    let medium = |quads: &Quads| {
        fs::write(folder.path().join("body.obj"), quads.obj()).unwrap();
        let boundary = "Transformed(by: [RotateX(30)], object: Mesh(path: \"body.obj\"))";
        scene(folder.path(), &format!("Medium(boundary: {boundary}, density: 1, albedo: Rgb(1, 1, 1))"))
    };
    assert!(medium(&cube()).is_ok());
    let mut inside_out = cube();
    inside_out.faces.iter_mut().for_each(|face| face.reverse());
    let scene = medium(&inside_out).unwrap();
    assert!(!scene.meshes["body.obj"].volume_is_positive());
    let mut hole = cube();
    hole.faces.remove(3);
    let mut flipped = cube();
    flipped.faces[2].reverse();
    let mut doubled = cube();
    doubled.faces.push(doubled.faces[5].clone());
    for (quads, face) in [(hole, 0), (flipped, 0), (doubled, 0)] {
        let count = 4;
        let Err(Error::Scene { location, field, message }) = medium(&quads) else { panic!("it is not closed") };
        assert_eq!(field, "objects[0].Medium.boundary.Transformed.object.Mesh.path");
        assert_eq!((location.line, location.column), (7, 76));
        assert!(message.contains("body.obj: expected a closed mesh"), "{message}");
        assert!(message.contains(&format!("{count} such edges")), "{message}");
        let open = mesh("body.obj", quads.obj().as_bytes()).open_edges().unwrap();
        assert!(message.contains(&format!("face {face} ")), "{message}");
        assert_eq!(open, OpenEdges { face, count });
    }
}

#[test]
fn an_image_needs_texture_coordinates_and_transforms_keep_a_mesh_in_range() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbImage::new(2, 2).save(folder.path().join("map.png")).unwrap();
    fs::write(folder.path().join("cube.obj"), cube().obj()).unwrap();
    fs::write(folder.path().join("plain.obj"), format!("{PLAIN}f 1 2 3\n")).unwrap();
    let mapped = |file: &str| scene(folder.path(), &format!("Mesh(path: {file:?}, material: \"map\")"));
    assert!(mapped("cube.obj").is_ok());
    let error = mapped("plain.obj").unwrap_err().to_string();
    assert!(error.contains("scene.ron:7:43: objects[0].Mesh.material: the material \"map\" has an image"), "{error}");
    assert!(error.contains("no texture coordinates"), "{error}");
    for (by, words) in [("Scale(1e-101)", "greater"), ("Scale(1e-100), Scale(0.1)", "1e-100 to 1e100")] {
        let error = scene(folder.path(), &format!("Transformed(by: [{by}], object: {})", object("cube.obj")));
        assert!(error.is_err(), "{by}: {words}");
    }
    let far = "Transformed(by: [Translate((0, 1e100, 0))], object: Mesh(path: \"cube.obj\", material: \"grey\"))";
    // A size of 2 is lost beside 1e100, and in range.
    assert!(scene(folder.path(), far).is_ok());
    let large = "Transformed(by: [Scale(1e100)], object: Mesh(path: \"cube.obj\", material: \"grey\"))";
    let error = scene(folder.path(), large).unwrap_err().to_string();
    assert!(error.contains("objects[0].Transformed.object.Mesh: the transforms around this place"), "{error}");
}

#[test]
fn a_file_named_often_is_read_once_and_tells_how_far_it_is() {
    let folder = tempfile::tempdir().unwrap();
    // A megabyte and a half of text around one face.
    let text = format!("{}{}f 1 2 3\n", "# padding padding\n".repeat(90_000), PLAIN);
    fs::write(folder.path().join("big.obj"), &text).unwrap();
    let again = object("big.obj");
    let object = format!("Group([{again}, Transformed(by: [], object: {again})]), {again}");
    let path = folder.path().join("scene.ron");
    let header = "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
                  background: Solid((1, 1, 1)), materials: {\"grey\": Dielectric(ior: 1)}, objects: [";
    fs::write(&path, format!("{header}{object}])")).unwrap();
    let mut reported = Vec::new();
    let mut progress = |file: &Path, done, full| {
        assert_eq!((file, full), (folder.path().join("big.obj").as_path(), text.len() as u64));
        reported.push(done);
    };
    let scene = Scene::load_as(&path, &GltfOptions::default(), &mut progress, &mut Assets::default());
    assert_eq!(scene.unwrap().meshes.len(), 1);
    assert_eq!(reported.len(), 2, "at the start and after a MiB: {reported:?}");
    assert!(reported[0] == 0 && reported[1] > 1 << 20);
}
