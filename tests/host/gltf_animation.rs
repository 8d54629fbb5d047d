//! Frames of animated glTF files: the poses of nodes, skins and morph targets, and what is refused. The interpolation itself is tested in
//! `src/scene/gltf/interpolate.rs`.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use gpu_rt::error::Error;
use gpu_rt::scene::{AnimationFrame, Assets, GltfOptions, Mesh, Object, Scene, Transform};
use serde_json::{Value, json};

use crate::common::gltf::{self, changed, glb, moving, place, posed};

/// A frame, of which a second has 24.
fn at_frame(number: f64) -> GltfOptions {
    GltfOptions { frame: Some(AnimationFrame { number, fps: 24.0 }), ..GltfOptions::default() }
}

/// The scene of a file at a frame, of which a second has 24, or in its rest pose.
fn load(json: &Value, frame: Option<f64>) -> Result<Scene, Error> {
    gltf::load("a.glb", (json, &moving().1), &frame.map_or(GltfOptions::default(), at_frame))
}

fn loaded(json: &Value, frame: Option<f64>) -> Scene {
    load(json, frame).unwrap_or_else(|error| panic!("{error}"))
}

/// The mesh of a node; `part` is what its name has behind the node's number.
fn mesh<'a>(scene: &'a Scene, node: usize, part: &str) -> &'a Mesh {
    let name = format!("a.glb#nodes/{node}{part}");
    scene.meshes.get(&name).unwrap_or_else(|| panic!("no {name} in {:?}", scene.meshes.keys()))
}

/// The largest distance between points in two lists.
fn distance(found: &[DVec3], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).map(|(a, b)| a.distance(DVec3::from_array(*b))).fold(0.0, f64::max)
}

fn distance_of_normals(found: &[Vec3], expected: &[[f64; 3]]) -> f64 {
    distance(&found.iter().map(|normal| normal.as_dvec3()).collect::<Vec<_>>(), expected)
}

/// The keys of the file are rounded to f32, by at most 6e-8 of 1, and the strip reaches to 2: the positions are off by at most twice that.
const ROUNDING: f64 = 1.2e-7;

/// The strip at its rest, and at 1 s: its upper joint is turned by a quarter about z at (0, 1, 0). The middle is the mean of both joints.
const AT_REST: [[f64; 3]; 6] =
    [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [-0.5, 1.0, 0.0], [0.5, 1.0, 0.0], [-0.5, 2.0, 0.0], [0.5, 2.0, 0.0]];
const BENT: [[f64; 3]; 6] =
    [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [-0.25, 0.75, 0.0], [0.25, 1.25, 0.0], [-1.0, 0.5, 0.0], [-1.0, 1.5, 0.0]];

#[test]
fn skins_follow_their_joints_and_not_their_node() {
    let (json, _) = moving();
    // The node is shifted by 7, which does not count.
    let rest = loaded(&json, None);
    assert!(distance(&mesh(&rest, 0, "/primitives/0").positions, &AT_REST) < ROUNDING);
    let at_one = |json: &Value| loaded(json, Some(24.0));
    let bent = at_one(&json);
    let found = &mesh(&bent, 0, "/primitives/0/seconds/1").positions;
    assert!(distance(found, &BENT) < ROUNDING, "{found:?}");
    // Without the inverse bind matrices the upper end is elsewhere.
    let mut wrong = json.clone();
    wrong["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert!(distance(&mesh(&at_one(&wrong), 0, "/primitives/0/seconds/1").positions, &BENT) > 0.5);
    // A joint of weight 0.5 is as good as two of 0.25, also in the second set, and weights count by their sum.
    let mut both = json.clone();
    let attributes = &mut both["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) =
        (attributes["JOINTS_0"].clone(), attributes["WEIGHTS_0"].clone());
    assert!(distance(&mesh(&at_one(&both), 0, "/primitives/0/seconds/1").positions, &BENT) < ROUNDING);
    // The second set counts: where it has the upper joint alone, the lower end moves too.
    let mut other = both.clone();
    other["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = json!(joints_from_the_second(&mut other));
    let found = at_one(&other);
    assert!(distance(&mesh(&found, 0, "/primitives/0/seconds/1").positions, &BENT) > 0.1);
}

/// The number of a new accessor that gives each vertex of the strip the joints 1, 0, 0, 0: those of the file are 0, 1, 0, 0, and it begins one byte
/// later.
fn joints_from_the_second(json: &mut Value) -> usize {
    let joints = json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].as_u64().unwrap() as usize;
    let accessors = json["accessors"].as_array_mut().unwrap();
    let mut shifted = accessors[joints].clone();
    shifted["byteOffset"] = json!(1);
    accessors.push(shifted);
    let view = accessors[joints]["bufferView"].as_u64().unwrap() as usize;
    let (number, length) = (accessors.len() - 1, &mut json["bufferViews"][view]["byteLength"]);
    *length = json!(length.as_u64().unwrap() + 1);
    number
}

/// The upper joint turned by a quarter about x instead: the middle's matrix is the mean of the identity and the turn, which is a turn by 45
/// degrees times 1/√2, so that its normals turn by 45 degrees.
#[test]
fn normals_of_skins_are_those_of_the_blended_surface() {
    let (mut json, _) = moving();
    json.as_object_mut().unwrap().remove("animations");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    json["nodes"][2]["rotation"] = json!([half, 0.0, 0.0, half]);
    let scene = loaded(&json, None);
    let strip = mesh(&scene, 0, "/primitives/0");
    let expected = [[0.0, 0.0, 1.0], [0.0, -half, half], [0.0, -1.0, 0.0]].map(|normal| [normal; 2]);
    assert!(distance_of_normals(&strip.normals, expected.as_flattened()) < ROUNDING, "{:?}", strip.normals);
    // The mean of the identity and a half turn about z has the matrix diag(0, 0, 1), whose normals have no direction: they stay.
    json["nodes"][2]["rotation"] = json!([0.0, 0.0, 1.0, 0.0]);
    let scene = loaded(&json, None);
    let strip = mesh(&scene, 0, "/primitives/0");
    assert!(!strip.warnings.iter().any(|warning| warning.contains("normals")), "{:?}", strip.warnings);
    assert!(strip.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-6));
}

#[test]
fn morph_targets_move_positions_and_normals_by_their_weights() {
    let (json, _) = moving();
    let square = |z: f64| [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    let of = |json: &Value, frame: Option<f64>, part: &str| {
        let scene = loaded(json, frame);
        let mesh = mesh(&scene, 4, part);
        (mesh.positions.clone(), mesh.normals.clone())
    };
    let (positions, normals) = of(&json, Some(18.0), "/mesh/primitives/0/seconds/0.75");
    // All numbers are exact in f64; normals are rounded to f32, and (0, 0.75, 0.25) has the length √10 / 4.
    assert_eq!(distance(&positions, &square(0.75)), 0.0);
    let root = 10.0_f64.sqrt();
    assert!(distance_of_normals(&normals, &[[0.0, 3.0 / root, 1.0 / root]; 4]) < ROUNDING, "{normals:?}");
    assert!(distance(&positions, &square(0.76)) > 0.009);
    // Without weights it is the mesh itself, which others may share.
    for frame in [None, Some(0.0), Some(-9.0)] {
        let scene = loaded(&json, frame);
        assert!(scene.meshes.contains_key("a.glb#meshes/2/primitives/0"), "{:?}", scene.meshes.keys());
    }
    // Weights of the mesh, and before these those of the node.
    let mut still = json.clone();
    still.as_object_mut().unwrap().remove("animations");
    still["meshes"][2]["weights"] = json!([0.25]);
    assert_eq!(distance(&of(&still, None, "/mesh/primitives/0").0, &square(0.25)), 0.0);
    still["nodes"][4]["weights"] = json!([0.5]);
    assert_eq!(distance(&of(&still, None, "/mesh/primitives/0").0, &square(0.5)), 0.0);
    // Where the node scales unevenly, the vertices are in the scene: z is doubled, and y is shifted by -2.
    still["nodes"][4]["scale"] = json!([1.0, 1.0, 2.0]);
    let lowered = square(1.0).map(|[x, y, z]| [x, y - 2.0, z]);
    assert_eq!(distance(&of(&still, None, "/primitives/0").0, &lowered), 0.0);
    // Exporters write targets as sparse accessors without a bufferView: here the second vertex alone is lifted.
    let mut sparse = still.clone();
    let target = sparse["meshes"][2]["primitives"][0]["targets"][0]["POSITION"].as_u64().unwrap() as usize;
    let lifts = sparse["accessors"][target]["bufferView"].take();
    let index = sparse["accessors"]
        [sparse["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].as_u64().unwrap() as usize]["bufferView"]
        .clone();
    let accessor = sparse["accessors"][target].as_object_mut().unwrap();
    accessor.remove("bufferView");
    let indices = json!({"bufferView": index, "byteOffset": 1, "componentType": 5121});
    accessor.insert("sparse".to_owned(), json!({"count": 1, "indices": indices, "values": {"bufferView": lifts}}));
    let z: Vec<f64> = of(&sparse, None, "/primitives/0").0.iter().map(|position| position.z).collect();
    assert_eq!(z, [0.0, 1.0, 0.0, 0.0]);
}

/// A frame is the file with its pose: objects, meshes, the camera and the light.
#[test]
fn a_frame_is_the_file_with_its_pose() {
    let untimed = |text: &str| {
        let mut parts = text.split("/seconds/");
        let first = parts.next().unwrap().to_owned();
        parts.fold(first, |all, part| all + part.trim_start_matches(|c| c != '"'))
    };
    let is_alike = |a: &Scene, b: &Scene| {
        let objects = |scene: &Scene| untimed(&format!("{:?}", scene.objects));
        let meshes = |scene: &Scene| -> Vec<_> {
            scene.meshes.iter().map(|(name, mesh)| (untimed(&format!("{name}\"")), Mesh::clone(mesh))).collect()
        };
        a.camera == b.camera && objects(a) == objects(b) && meshes(a) == meshes(b)
    };
    let frame = loaded(&moving().0, Some(12.0));
    assert!(is_alike(&frame, &loaded(&posed(0.5).0, None)));
    assert!(!is_alike(&frame, &loaded(&posed(0.5 + 1e-6).0, None)));
    assert!(!is_alike(&frame, &loaded(&moving().0, None)));
    // The node that turns and scales evenly keeps its mesh.
    let by = frame.objects.iter().find_map(|object| match object {
        Object::Transformed { by, object } if matches!(&**object, Object::Mesh { path, .. } if path == "a.glb#meshes/1/primitives/0") => Some(by),
        _ => None,
    });
    let Some([Transform::Scale(scale), Transform::Rotate { degrees, .. }, Transform::Translate(shift)]) =
        by.map(Vec::as_slice)
    else {
        panic!("{:?}", frame.objects)
    };
    assert!((scale - 1.5).abs() < ROUNDING && (degrees - 45.0).abs() < 1e-5 && *shift == DVec3::X, "{by:?}");
    // After the last key everything rests.
    assert!(is_alike(&loaded(&moving().0, Some(24.0)), &loaded(&moving().0, Some(1e9))));
    assert!(is_alike(&loaded(&moving().0, Some(24.0)), &loaded(&posed(1.0).0, None)));
}

/// The largest distance from a point of one list to the other list.
fn farthest(from: &[DVec3], to: &[DVec3]) -> f64 {
    let nearest = |point: &DVec3| to.iter().map(|other| point.distance(*other)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max)
}

/// Blender's own meshes after its modifiers, at frames of a file by its exporter: three bones below an empty that moves and scales unevenly, and two
/// shape keys, in sparse accessors, on an object that mirrors (tests/blender/moving.py). Blender computes in f32, where positions of up to 5 in a chain of six
/// transforms are off by some 20 times 3e-7, and the list is rounded to 1e-6.
#[test]
fn frames_of_a_file_by_blender_have_the_vertices_of_blender() {
    const BLENDER: f64 = 1e-5;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/blender");
    let positions: Value = serde_json::from_slice(&fs::read(folder.join("moving.json")).unwrap()).unwrap();
    let at = |number: f64| {
        Scene::load_as(&folder.join("moving.glb"), &at_frame(number), &mut |_, _, _| {}, &mut Assets::default())
            .unwrap_or_else(|error| panic!("{error}"))
    };
    for (frame, objects) in positions.as_object().unwrap() {
        let number: f64 = frame.parse().unwrap();
        let (scene, later) = (at(number), at(if number < 24.0 { number + 0.1 } else { number - 0.1 }));
        for (node, name) in [(3, "tube"), (6, "ball")] {
            let expected: Vec<[f64; 3]> = serde_json::from_value(objects[name].clone()).unwrap();
            let expected: Vec<DVec3> = expected.into_iter().map(DVec3::from_array).collect();
            let of = |scene: &Scene| {
                let part = format!("moving.glb#nodes/{node}/");
                let (_, mesh) = scene.meshes.iter().find(|(path, _)| path.starts_with(&part)).unwrap();
                farthest(&mesh.positions, &expected).max(farthest(&expected, &mesh.positions))
            };
            let found = of(&scene);
            println!("frame {frame}, {name}: {found:.1e}");
            assert!(found < BLENDER, "frame {frame}, {name}: {found}");
            // A tenth of a frame shows.
            assert!(of(&later) > 100.0 * BLENDER, "frame {frame}, {name}: {}", of(&later));
        }
    }
}

/// Meshes that stand still are read once for all frames.
#[test]
fn what_stands_still_stays_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let (json, binary) = moving();
    fs::write(&path, glb(&json, &binary)).unwrap();
    let mut assets = Assets::of_frames();
    let mut reads = |number: f64| {
        let before = assets.read;
        Scene::load_as(&path, &at_frame(number), &mut |_, _, _| {}, &mut assets)
            .unwrap_or_else(|error| panic!("{error}"));
        assets.read - before
    };
    // The strip, the square and the morphed square; then only those whose vertices move.
    assert_eq!((reads(1.0), reads(2.0), reads(2.0)), (3, 2, 0));
}

#[test]
fn notes_say_what_of_animations_is_not_read() {
    let notes = |json: &Value, frame: Option<f64>| loaded(json, frame).warnings().join("\n");
    let (json, _) = moving();
    assert!(notes(&json, None).contains("animations are not read without a frame: --frame N poses them"));
    assert_eq!(notes(&json, Some(3.0)).matches("animation").count(), 0);
    let mut more = json.clone();
    let all = more["animations"][0].clone();
    more["animations"].as_array_mut().unwrap().push(json!({
        "samplers": all["samplers"],
        "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}},
            {"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/x"}}}}]
    }));
    let found = notes(&more, Some(3.0));
    let says =
        "animations[1]: it moves nodes[2], which animations[0] (\"all\") moves too: only the first in the file counts";
    assert!(found.contains(says), "{found}");
    assert!(
        found
            .contains("animations: KHR_animation_pointer is not read, so that what it animates stays still: 1 channel"),
        "{found}"
    );
    let mut still = json;
    still.as_object_mut().unwrap().remove("animations");
    assert!(notes(&still, Some(3.0)).contains("it has no animations: all frames are the same"));
}

/// The changes of a file that break it, each with the place in the JSON and the words.
#[test]
fn broken_animations_are_refused_with_their_path_in_the_json() {
    let (good, _) = moving();
    let attribute =
        |mesh: usize, name: &str| good["meshes"][mesh]["primitives"][0]["attributes"][name].as_u64().unwrap();
    let [joints, weights] = ["JOINTS_0", "WEIGHTS_0"].map(|name| attribute(0, name));
    let input = good["animations"][0]["samplers"][0]["input"].as_u64().unwrap();
    let output = good["animations"][0]["samplers"][0]["output"].as_u64().unwrap();
    let [of_input, of_joints, of_weights] =
        [input, joints, weights].map(|accessor| format!("/accessors/{accessor}/count"));
    let matrix = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let [of_attributes, sampler] = ["meshes[0].primitives[0].attributes", "animations[0].samplers"];
    // Where the place is not that of the change, it is given.
    for (pointer, value, at, reason) in [
        ("/animations/0/channels/0/sampler", json!(70), "", "there is no sampler 70"),
        ("/animations/0/channels/1/target/node", json!(70), "", "there is no node 70"),
        ("/animations/0/samplers/1/input", json!(u64::MAX), "", "there is no accessor"),
        ("/animations/0/samplers/1/output", json!(70), "", "there is no accessor 70"),
        ("/animations/0/samplers/1/input", json!(output), "", "expected an accessor of type SCALAR"),
        (
            "/animations/0/samplers/1/interpolation",
            json!("CUBICSPLINE"),
            &format!("{sampler}[1].output"),
            "expected 6 elements for 2 keys, found 2",
        ),
        ("/animations/0/samplers/1/interpolation", json!("ROUND"), "", "unknown variant `ROUND`"),
        (&of_input, json!(1u64 << 40), &format!("{sampler}[0].input"), "past the end of its buffer"),
        // The view of the rotations begins with 0, 0, 0, 1, 0.
        (&of_input, json!(0), &format!("{sampler}[0].input"), "no elements"),
        ("/skins/0/joints/1", json!(70), "", "expected a node of the default scene, found 70"),
        ("/nodes/0/skin", json!(7), "", "there is no skin 7"),
        (
            "/skins/0/joints",
            json!([1, 2, 1]),
            "skins[0].inverseBindMatrices",
            "expected a matrix for each of 3 joints, found 2",
        ),
        ("/skins/0/joints", json!([1]), &format!("{of_attributes}.JOINTS_0"), "there is no joint 1; skins[0] has 1"),
        (&of_joints, json!(5), &format!("{of_attributes}.JOINTS_0"), "each of 6 vertices, found 5"),
        (&of_weights, json!(5), &format!("{of_attributes}.WEIGHTS_0"), "each of 6 vertices, found 5"),
        ("/meshes/2/primitives/0/targets/0/POSITION", json!(0), "", "each of 4 vertices, found 6"),
        ("/nodes/3/matrix", matrix, "", "an animation moves it"),
    ] {
        let json = changed(good.clone(), pointer, value);
        let at = if at.is_empty() { place(pointer) } else { at.to_owned() };
        gltf::is_refused(load(&json, Some(12.0)), &at, reason);
    }
}

/// A scene file says the frame of each of its glTF files, and `convert` writes the names of posed meshes.
#[test]
fn scene_files_have_frames_too() {
    let folder = tempfile::tempdir().unwrap();
    let (json, binary) = moving();
    fs::write(folder.path().join("a.glb"), glb(&json, &binary)).unwrap();
    let parse = |objects: &str| {
        let text = format!(
            "(image: (width: 4, height: 3), camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((1, 1, 1)), objects: [{objects}])"
        );
        Scene::parse(&text, &folder.path().join("scene.ron"))
    };
    let scene = parse(r#"Gltf(path: "a.glb", frame: 15, fps: 30)"#).unwrap_or_else(|error| panic!("{error}"));
    let options = at_frame(12.0);
    let expected =
        Scene::load_as(&folder.path().join("a.glb"), &options, &mut |_, _, _| {}, &mut Assets::default()).unwrap();
    assert_eq!(scene.meshes, expected.meshes);
    assert!(scene.text().contains(r#"Gltf(path: "a.glb", frame: 15.0, fps: 30.0)"#), "{}", scene.text());
    let rest = parse(r#"Gltf(path: "a.glb")"#).unwrap();
    assert!(rest.warnings().iter().any(|note| note.ends_with("frame: N poses them")), "{:?}", rest.warnings());
    let error = parse(r#"Gltf(path: "a.glb", frame: 15, fps: 0)"#).unwrap_err().to_string();
    assert!(error.contains("objects[0].Gltf.fps"), "{error}");

    let to = folder.path().join("b.ron");
    let converted =
        Scene::of_model(Path::new(&folder.path().join("a.glb")), &to, &options, &mut Assets::default()).unwrap();
    fs::write(&to, converted.text()).unwrap();
    let again = Scene::load(&to).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((again.objects, again.meshes), (converted.objects, converted.meshes));
}

/// A file has the pose of one time, also while the shutter is open.
#[test]
fn poses_are_said_to_be_still_while_the_shutter_is_open() {
    let warnings = |shutter: &str, frame: &str| {
        let text = format!(
            "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vertical_fov: 40, {shutter}),
            background: Solid((1, 1, 1)), objects: [Gltf(path: \"moving.glb\", {frame})])"
        );
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/blender/blurred.ron");
        let scene = Scene::parse(&text, &file).unwrap_or_else(|error| panic!("{error}"));
        scene.warnings().iter().filter(|text| text.contains("nothing in it moves while the shutter is open")).count()
    };
    assert_eq!(warnings("shutter: (0, 0.02)", "frame: 3"), 1);
    assert_eq!(warnings("", "frame: 3"), 0);
    assert_eq!(warnings("shutter: (0, 0.02)", ""), 0);
}
