//! Scenes that are glTF files, as users give them.

use std::fs;

use crate::common::device::index as software;
use crate::common::gltf::{glb, png, room};
use crate::sandbox::{Sandbox, attribute};

/// A sandbox with room.glb among its scenes.
fn with_room() -> Sandbox {
    let sandbox = Sandbox::new();
    let (json, binary) = room();
    fs::write(sandbox.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    sandbox
}

const SMALL: [&str; 4] = ["--size", "16x10", "--spp", "8"];

#[test]
fn a_converted_scene_renders_to_the_same_image() {
    let sandbox = with_room();
    let render = |scene: &str, more: &[&str], to: &str| {
        sandbox.run(&[&["render", scene, "--device", software(), "-o", to], &SMALL[..], more].concat()).exits(0)
    };
    for (camera, name) in [(&[][..], "first"), (&["--camera", "Left"], "left")] {
        let (ron, of_glb, of_ron) = (format!("{name}.ron"), format!("{name}-glb.exr"), format!("{name}-ron.exr"));
        sandbox.run(&[&["convert", "../scenes/room.glb", "-o", &ron], camera].concat()).exits(0);
        render("../scenes/room.glb", camera, &of_glb);
        render(&ron, &[], &of_ron);
        let (expected, found) = (sandbox.exr(&of_glb), sandbox.exr(&of_ron));
        assert_eq!(expected.rgb, found.rgb, "{name}");
        assert!(expected.rgb.iter().any(|rgb| rgb[0] > 0.0));
    }
    // Both have the names of the nodes.
    for scene in ["../scenes/room.glb", "first.ron"] {
        render(scene, &["--aov", "object", "--force"], "names.exr");
        let names = "objects[0]\nmirrored\nobjects[2]\nobjects[3]";
        assert_eq!(attribute(&sandbox.exr("names.exr"), "gpu-rt:objects"), names, "{scene}");
    }
    assert_ne!(sandbox.exr("first-glb.exr").rgb, sandbox.exr("left-glb.exr").rgb);
    let text = fs::read_to_string(sandbox.at("first.ron")).unwrap();
    assert!(text.contains(r#"Mesh(path: "../scenes/room.glb#meshes/0/primitives/0", material: "Wood")"#), "{text}");
    assert!(text.contains("look_from: (0.0, 1.0, 8.0)"), "{text}");
}

#[test]
fn convert_and_gltf_options_refuse_other_files() {
    let sandbox = with_room();
    for (words, says) in [
        (
            "convert ../scenes/room.glb -o a.txt",
            "a.txt: expected a name that ends in .ron, with -o; nothing has been written",
        ),
        ("convert ../scenes/room.glb -o -", "-: expected the name of a scene file"),
        (
            "convert ../scenes/sphere.ron -o a.ron",
            "../scenes/sphere.ron: expected a file that ends in .glb, .gltf, .xml, .pbrt, .obj, .ply or .stl",
        ),
        ("convert ../scenes/gone.glb -o a.ron", "../scenes/gone.glb: glTF: cannot read the glTF file"),
        (
            "convert ../scenes/room.glb --camera Up -o a.ron",
            "--camera: there is no camera \"Up\": expected one of \"Front\"",
        ),
        ("convert ../scenes/room.glb -o gone/a.ron", "gone/a.ron: cannot write"),
        ("check ../scenes/sphere.ron --sun", "--sun is for scenes that are .glb or .gltf"),
        ("check ../scenes/sphere.ron --sky a.exr", "--sky is for scenes that are .glb or .gltf"),
    ] {
        sandbox.says(words).exits(2).says_last(&format!("error: {says}"));
    }
    assert_eq!(sandbox.files(), Vec::<String>::new());
}

/// A scene file that somebody has gone on with by hand stays, unless `--force` is given. What the scene is read from stays even then.
#[test]
fn convert_overwrites_only_when_asked() {
    let sandbox = with_room();
    let read = |name: &str| fs::read_to_string(sandbox.at(name)).unwrap();
    let refused = |line: &str, name: &str, says: &str| {
        let ran = sandbox.says(&format!("convert {line}")).exits(2);
        assert_eq!(ran.stderr, format!("error: {name}: {says}; nothing has been written\n"));
    };
    let there = "it is there already: --force overwrites it";
    sandbox.says("convert ../scenes/room.glb -o a.ron").exits(0);
    let converted = read("a.ron");
    fs::write(sandbox.at("a.ron"), "mine").unwrap();
    refused("../scenes/room.glb -o a.ron", "a.ron", there);
    assert_eq!(read("a.ron"), "mine");
    sandbox.says("convert ../scenes/room.glb -o a.ron --force").exits(0);
    assert_eq!(read("a.ron"), converted);

    // A buffer and an image may have any name, and so has a sky.
    let (mut json, binary) = room();
    json["buffers"][0]["uri"] = "buffer.ron".into();
    json["images"][0] = serde_json::json!({"uri": "image.ron"});
    fs::write(sandbox.at("room.gltf"), json.to_string()).unwrap();
    fs::write(sandbox.at("buffer.ron"), &binary).unwrap();
    fs::write(sandbox.at("image.ron"), png()).unwrap();
    for input in ["buffer.ron", "image.ron"] {
        refused(&format!("room.gltf -o {input}"), input, there);
        for name in [input.to_owned(), format!("./{input}"), format!("../work/{input}")] {
            let says = format!("it would overwrite the input {name}: give another name with -o");
            refused(&format!("room.gltf -o {name} --force"), &name, &says);
        }
    }
    sandbox.says("convert room.gltf -o b.ron").exits(0);
    assert!(
        fs::read(sandbox.at("buffer.ron")).unwrap() == binary && fs::read(sandbox.at("image.ron")).unwrap() == png()
    );

    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("a.ron", sandbox.at("link.ron")).unwrap();
        symlink("new", sandbox.at("dangling.ron")).unwrap();
        symlink("../scenes/room.glb", sandbox.at("glb.ron")).unwrap();
        symlink("/dev/null", sandbox.at("null.ron")).unwrap();
        refused("../scenes/room.glb -o link.ron", "link.ron", there);
        let says = "it would overwrite the input ../scenes/room.glb: give another name with -o";
        refused("../scenes/room.glb -o glb.ron --force", "glb.ron", says);
        // What a link leads to is not there, or is no file.
        sandbox.says("convert ../scenes/room.glb -o dangling.ron").exits(0);
        sandbox.says("convert ../scenes/room.glb -o null.ron").exits(0);
        assert!(sandbox.at("dangling.ron").is_symlink() && sandbox.at("null.ron").is_symlink());
        assert_eq!(read("new"), converted);
    }
}

#[test]
fn errors_and_warnings_name_the_file_and_the_json() {
    let sandbox = with_room();
    let (mut json, binary) = room();
    json["materials"][0]["occlusionTexture"] = serde_json::json!({"index": 0});
    fs::write(sandbox.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    let ran = sandbox.says("check ../scenes/room.glb").exits(0);
    let words = "warning: ../scenes/room.glb: materials[0] (\"Wood\") is approximated: not read: occlusionTexture";
    assert!(ran.stdout.contains(words), "{}", ran.stdout);
    json["textures"][0]["source"] = 3.into();
    fs::write(sandbox.folder.path().join("scenes/room.glb"), glb(&json, &binary)).unwrap();
    let ran = sandbox.says("check ../scenes/room.glb --json").exits(2);
    assert_eq!(ran.last_line(), "error: ../scenes/room.glb: textures[0].source: there is no image 3");
    let error = &ran.json()["error"];
    assert_eq!(error["field"], "textures[0].source");
    assert!(error["line"].is_null() && error["column"].is_null(), "{error}");
}

/// A shared render takes the files with it that the scene names: the buffer and the image.
#[test]
#[cfg(unix)]
fn a_shared_render_has_the_files_and_the_camera() {
    let sandbox = Sandbox::new();
    let (mut json, binary) = room();
    json["buffers"][0]["uri"] = "room.bin".into();
    json["images"][0] = serde_json::json!({"uri": "wood.png"});
    let scenes = sandbox.folder.path().join("scenes");
    fs::write(scenes.join("room.gltf"), json.to_string()).unwrap();
    fs::write(scenes.join("room.bin"), binary).unwrap();
    fs::write(scenes.join("wood.png"), png()).unwrap();
    sandbox.says("submit slurm ../scenes/room.gltf --camera Left --parts 2 --spp 16 -o job --dry-run").exits(0);
    let mut names: Vec<_> = fs::read_dir(sandbox.at("job/scene")).unwrap().map(|it| it.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["room.bin", "room.gltf", "wood.png"]);
    let job = fs::read_to_string(sandbox.at("job/job.json")).unwrap();
    assert!(job.contains("--camera") && job.contains("Left"), "{job}");
}

/// A sandbox with lamps.glb among its scenes: squares of the room, lit by a point as Blender's exporter writes it.
fn with_lamps() -> Sandbox {
    let sandbox = Sandbox::new();
    let (mut json, binary) = room();
    json["asset"]["generator"] = "Khronos glTF Blender I/O v5.0.21".into();
    json["scenes"][0]["nodes"] = serde_json::json!([0, 2, 4]);
    json["nodes"][2] =
        serde_json::json!({"translation": [0, 1, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    json["extensions"] =
        serde_json::json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 683, "name": "Lamp"}]}});
    fs::write(sandbox.folder.path().join("scenes/lamps.glb"), glb(&json, &binary)).unwrap();
    sandbox
}

/// Blender's exporter multiplies watts by 683 lm/W. Every command divides by that, and `--watts=off` keeps the file's numbers.
#[test]
fn lamps_of_blender_are_in_watts_in_every_command() {
    let sandbox = with_lamps();
    let run = |line: &str| sandbox.says(&line.replace("LAMPS", "../scenes/lamps.glb")).exits(0);
    let render = |scene: &str, options: &str, to: &str| {
        run(&format!("render {scene} --device {} --size 16x10 --spp 8 -o {to} {options}", software()))
    };
    let mean = |name: &str| {
        let rgb = sandbox.exr(name).rgb;
        rgb.as_flattened().iter().map(|x| f64::from(*x)).sum::<f64>() / (3.0 * rgb.len() as f64)
    };
    let stderr = render("LAMPS", "", "watts.exr").stderr;
    assert_eq!(stderr.matches("--watts=off").count(), 1, "{stderr}");
    let stderr = render("LAMPS", "--watts=off", "candela.exr").stderr;
    assert!(!stderr.contains("--watts"), "{stderr}");
    render("LAMPS", "--watts", "asked.exr");
    assert_eq!(sandbox.exr("watts.exr").rgb, sandbox.exr("asked.exr").rgb);
    // Radiance is rounded to f32, in units of a power of two.
    let ratio = mean("candela.exr") / mean("watts.exr");
    assert!((ratio / 683.0 - 1.0).abs() < 1e-5, "{ratio}");

    for (options, name) in [("", "watts"), ("--watts=off", "candela")] {
        let ran = run(&format!("convert LAMPS -o {name}.ron {options}"));
        assert_eq!(ran.stderr.matches("--watts=off").count(), usize::from(options.is_empty()), "{}", ran.stderr);
        render(&format!("{name}.ron"), "", "converted.exr");
        assert_eq!(sandbox.exr(&format!("{name}.exr")).rgb, sandbox.exr("converted.exr").rgb, "{name}");
        fs::remove_file(sandbox.at("converted.exr")).unwrap();
    }
    for command in ["check", "plan"] {
        let ran = run(&format!("{command} LAMPS"));
        let both = format!("{}{}", ran.stdout, ran.stderr);
        assert_eq!(both.matches("--watts=off").count(), usize::from(command == "check"), "{both}");
        run(&format!("{command} LAMPS --watts=off"));
    }

    // A render goes on with the same lights alone.
    let on = format!("render ../scenes/lamps.glb --device {} --size 16x10 --spp 16 -o watts.exr --resume", software());
    sandbox.says(&format!("{on} --watts=off")).exits(2).on_stderr(&["the scene differs"]);
    sandbox.says(&on).exits(0);
    sandbox.says("merge watts.exr candela.exr -o both.exr").exits(2).on_stderr(&["the scene differs"]);
    sandbox.says("check ../scenes/lamps.glb --watts=no").exits(2).on_stderr(&["expected on or off"]);
}

/// The scripts of a shared render have the requested options. By default each part finds the file's generator in the copy.
#[test]
#[cfg(unix)]
fn a_shared_render_has_the_gltf_options_that_were_given() {
    let sandbox = with_lamps();
    let words = |options: &str, folder: &str| {
        let line = format!("submit slurm ../scenes/lamps.glb --parts 2 --spp 16 -o {folder} --dry-run {options}");
        sandbox.says(&line).exits(0);
        fs::read_to_string(sandbox.at(folder).join("job.json")).unwrap()
    };
    assert!(!words("", "default").contains("watts"));
    assert!(words("--watts=off", "off").contains("\"--watts=off\""));
    assert!(words("--watts", "on").contains("\"--watts=on\""));
    let posed = words("--frame 7 --fps 30", "posed");
    assert!(posed.contains("\"--frame=7\"") && posed.contains("\"--fps=30\""), "{posed}");
    assert!(words("--thin pane", "pane").contains("\"--thin=pane\"") && !words("--thin auto", "auto").contains("thin"));
}
