//! Scenes that are glTF files, as users give them.

use std::fs;

use crate::common::device::index as software;
use crate::common::gltf::{glb, png, room};
use crate::place::Place;

/// A place with room.glb among its scenes.
fn with_room() -> Place {
    let place = Place::new();
    let (json, binary) = room();
    fs::write(place.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    place
}

const SMALL: [&str; 4] = ["--size", "16x10", "--spp", "8"];

#[test]
fn what_convert_writes_renders_to_the_same_image() {
    let place = with_room();
    let render = |scene: &str, more: &[&str], to: &str| {
        place.run(&[&["render", scene, "--device", software(), "-o", to], &SMALL[..], more].concat()).exits(0)
    };
    for (camera, name) in [(&[][..], "first"), (&["--camera", "Left"], "left")] {
        let (ron, of_glb, of_ron) = (format!("{name}.ron"), format!("{name}-glb.exr"), format!("{name}-ron.exr"));
        place.run(&[&["convert", "../scenes/room.glb", "-o", &ron], camera].concat()).exits(0);
        render("../scenes/room.glb", camera, &of_glb);
        render(&ron, &[], &of_ron);
        let (expected, found) = (place.exr(&of_glb), place.exr(&of_ron));
        assert_eq!(expected.rgb, found.rgb, "{name}");
        assert!(expected.rgb.iter().any(|rgb| rgb[0] > 0.0));
    }
    assert_ne!(place.exr("first-glb.exr").rgb, place.exr("left-glb.exr").rgb);
    let text = fs::read_to_string(place.work().join("first.ron")).unwrap();
    assert!(text.contains(r#"Mesh(path: "../scenes/room.glb#meshes/0/primitives/0", material: "Wood")"#), "{text}");
    assert!(text.contains("look_from: (0.0, 1.0, 8.0)"), "{text}");
}

#[test]
fn what_convert_cannot_do_is_refused() {
    let place = with_room();
    for (words, says) in [
        (
            "convert ../scenes/room.glb -o a.txt",
            "a.txt: expected a name that ends in .ron, with -o; nothing has been written",
        ),
        ("convert ../scenes/room.glb -o -", "-: expected the name of a scene file"),
        ("convert ../scenes/sphere.ron -o a.ron", "../scenes/sphere.ron: expected a file that ends in .glb or .gltf"),
        ("convert ../scenes/gone.glb -o a.ron", "../scenes/gone.glb: glTF: cannot read the glTF file"),
        (
            "convert ../scenes/room.glb --camera Up -o a.ron",
            "--camera: there is no camera \"Up\": expected one of \"Front\"",
        ),
        ("convert ../scenes/room.glb -o gone/a.ron", "gone/a.ron: cannot write"),
        ("check ../scenes/sphere.ron --sun", "--sun is for scenes that are .glb or .gltf"),
        ("check ../scenes/sphere.ron --sky a.exr", "--sky is for scenes that are .glb or .gltf"),
    ] {
        let ran = place.says(words).exits(2);
        assert!(ran.last_line().starts_with(&format!("error: {says}")), "{}", ran.stderr);
    }
    assert_eq!(place.files(), Vec::<String>::new());
}

#[test]
fn errors_and_warnings_name_the_file_and_the_json() {
    let place = with_room();
    let (mut json, binary) = room();
    json["materials"][0]["occlusionTexture"] = serde_json::json!({"index": 0});
    fs::write(place.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    let ran = place.says("check ../scenes/room.glb").exits(0);
    let words = "warning: ../scenes/room.glb: materials[0] (\"Wood\") is approximated: not read: occlusionTexture";
    assert!(ran.stdout.contains(words), "{}", ran.stdout);
    json["textures"][0]["source"] = 3.into();
    fs::write(place.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    let ran = place.says("check ../scenes/room.glb --json").exits(2);
    assert_eq!(ran.last_line(), "error: ../scenes/room.glb: textures[0].source: there is no image 3");
    let error = &ran.json()["error"];
    assert_eq!(error["field"], "textures[0].source");
    assert!(error["line"].is_null() && error["column"].is_null(), "{error}");
}

/// A shared render takes the files with it that the scene names: the buffer and the image.
#[test]
#[cfg(unix)]
fn a_shared_render_has_the_files_and_the_camera() {
    let place = Place::new();
    let (mut json, binary) = room();
    json["buffers"][0]["uri"] = "room.bin".into();
    json["images"][0] = serde_json::json!({"uri": "wood.png"});
    let scenes = place.folder.path().join("scenes");
    fs::write(scenes.join("room.gltf"), json.to_string()).unwrap();
    fs::write(scenes.join("room.bin"), binary).unwrap();
    fs::write(scenes.join("wood.png"), png()).unwrap();
    place.says("submit slurm ../scenes/room.gltf --camera Left --parts 2 --spp 16 -o job --dry-run").exits(0);
    let mut names: Vec<_> =
        fs::read_dir(place.work().join("job/scene")).unwrap().map(|it| it.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["room.bin", "room.gltf", "wood.png"]);
    let asked = fs::read_to_string(place.work().join("job/job.json")).unwrap();
    assert!(asked.contains("--camera") && asked.contains("Left"), "{asked}");
}
