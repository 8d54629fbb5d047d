//! Frames of animated glTF files, one by one and as a sequence.

use std::fs;

use crate::common::device::index as software;
use crate::common::gltf::{glb, moving, posed};
use crate::common::oidn;
use crate::common::program::Ran;
use crate::resume::Held;
use crate::sandbox::{SPHERE, Sandbox};

/// A sandbox with moving.glb among its scenes, which moves for a second, and posed.glb, which is its frame 6.
fn with_moving() -> Sandbox {
    let sandbox = Sandbox::new();
    for (name, (json, binary)) in [("moving", moving()), ("posed", posed(0.25))] {
        fs::write(sandbox.folder.path().join(format!("scenes/{name}.glb")), glb(&json, &binary)).unwrap();
    }
    sandbox
}

fn render(sandbox: &Sandbox, scene: &str, more: &str) -> Ran {
    sandbox.says(&format!("render ../scenes/{scene} --size 16x10 --device {} {more}", software()))
}

/// The film of a file, but for what its header says of the scene.
fn film(sandbox: &Sandbox, name: &str) -> Held {
    Held::read(&sandbox.at(name))
}

/// A frame has the bytes of a file in which its pose is written, and another frame has others. A render goes on with the same frame alone.
#[test]
fn a_frame_has_the_bytes_of_a_file_with_its_pose() {
    let sandbox = with_moving();
    render(&sandbox, "moving.glb", "--spp 8 --frame 6 -o frame.exr").exits(0);
    render(&sandbox, "moving.glb", "--spp 8 --frame 7.5 --fps 30 -o rate.exr").exits(0);
    render(&sandbox, "posed.glb", "--spp 8 -o posed.exr").exits(0);
    render(&sandbox, "moving.glb", "--spp 8 --frame 7 -o next.exr").exits(0);
    let expected = film(&sandbox, "posed.exr");
    for name in ["frame.exr", "rate.exr"] {
        let found = film(&sandbox, name);
        assert!(found.has_pixels_of(&expected), "{name}");
    }
    assert!(!film(&sandbox, "next.exr").has_pixels_of(&expected));

    // The pose as a scene file.
    sandbox.says("convert ../scenes/moving.glb --frame 6 -o moving.ron").exits(0);
    sandbox.says(&format!("render moving.ron --size 16x10 --device {} --spp 8 -o ron.exr", software())).exits(0);
    assert!(film(&sandbox, "ron.exr").has_pixels_of(&expected));

    let refused = render(&sandbox, "moving.glb", "--spp 16 --frame 7 -o frame.exr --resume").exits(2);
    assert!(refused.last_line().contains("--frame is 7 in this render and 6 in frame.exr"), "{}", refused.stderr);
    render(&sandbox, "moving.glb", "--spp 16 --frame 6 -o frame.exr --resume").exits(0);
}

/// Each file of a sequence is that of its frame alone. --resume leaves out what is complete, goes on with what is not, and begins what is not
/// there.
#[test]
fn a_sequence_writes_a_file_for_each_frame_and_goes_on() {
    let sandbox = with_moving();
    let sequence = "--spp 16 --frames 6..9 -o out.##.exr --png out.##.png --json";
    let ran = render(&sandbox, "moving.glb", sequence).exits(0);
    let names = |kind: &str| ["06", "07", "08"].map(|number| format!("out.{number}.{kind}"));
    let mut expected = [names("exr"), names("png")].concat();
    expected.sort();
    assert_eq!(sandbox.files(), expected);
    let json = ran.json();
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|frame| frame["frame"].as_f64().unwrap()).collect::<Vec<_>>(), [6.0, 7.0, 8.0]);
    assert!(frames.iter().all(|frame| frame["fps"] == 24.0 && frame["samples_per_pixel"] == 16), "{json}");
    // What is said of the file is said once, and each frame has its line.
    assert_eq!(ran.stderr.matches("an albedo of 1 absorbs nothing").count(), 1, "{}", ran.stderr);
    assert_eq!(ran.stderr.matches(": 16 samples, ").count(), 3, "{}", ran.stderr);
    let whole = film(&sandbox, "out.07.exr");
    render(&sandbox, "moving.glb", "--spp 16 --frame 7 -o alone.exr").exits(0);
    assert!(film(&sandbox, "alone.exr").has_pixels_of(&whole) && !film(&sandbox, "out.08.exr").has_pixels_of(&whole));

    // One is complete, one has half of its samples, and one is not there.
    render(&sandbox, "moving.glb", "--spp 8 --frame 7 -o out.07.exr --force").exits(0);
    fs::remove_file(sandbox.at("out.08.exr")).unwrap();
    let stamp = |name: &str| fs::metadata(sandbox.at(name)).unwrap().modified().unwrap();
    let before = stamp("out.06.exr");
    let ran = render(&sandbox, "moving.glb", &format!("{sequence} --resume")).exits(0);
    let json = ran.json();
    let skipped = |frame: usize| json["frames"][frame]["skipped"] == true;
    assert!(skipped(0) && !skipped(1) && !skipped(2), "{json}");
    assert_eq!((&json["frames"][1]["resumed_from"], before), (&8.into(), stamp("out.06.exr")));
    assert!(film(&sandbox, "out.07.exr").has_pixels_of(&whole));
    let json = render(&sandbox, "moving.glb", &format!("{sequence} --resume")).exits(0).json();
    assert_eq!(json["frames"].as_array().unwrap().iter().filter(|frame| frame["skipped"] == true).count(), 3, "{json}");
    crate::common::tables::compare("### `render --frames --json`", &[json]);
}

/// The pictures of complete frames are made again: for another exposure, and where a kill has left them older than their image. What is denoised
/// is denoised again only if it is older.
#[test]
fn pictures_of_complete_frames_are_made_again() {
    let sandbox = with_moving();
    let oidn = oidn::folder();
    let with = format!("--oidn {}", oidn.display());
    let sequence = format!("--frames 6..8 -o out.#.exr --png out.#.png --denoise {with} --resume");
    render(&sandbox, "moving.glb", &format!("{sequence} --spp 8")).exits(0);
    let read = |name: &str| fs::read(sandbox.at(name)).unwrap();
    let before = ["out.6.exr", "out.6.denoised.exr"].map(read);
    fs::remove_file(sandbox.at("out.6.png")).unwrap();
    // As a kill leaves it between the image of 16 samples and what is made of it.
    let more = "--frame 7 --spp 16 -o out.7.exr --resume --aov albedo,normal";
    render(&sandbox, "moving.glb", more).exits(0);
    for exposure in ["0", "2"] {
        let ran = render(&sandbox, "moving.glb", &format!("{sequence} --spp 8 --exposure {exposure} --json")).exits(0);
        assert!([0, 1].iter().all(|&frame: &usize| ran.json()["frames"][frame]["skipped"] == true), "{}", ran.stdout);
        for frame in ["6", "7"] {
            sandbox
                .says(&format!(
                    "denoise out.{frame}.exr -o denoised.exr --png denoised.png {with} --exposure {exposure}"
                ))
                .exits(0);
            assert_eq!(read(&format!("out.{frame}.denoised.png")), read("denoised.png"), "{frame} {exposure}");
            sandbox.says(&format!("develop out.{frame}.exr -o a.png --exposure {exposure}")).exits(0);
            assert_eq!(read(&format!("out.{frame}.png")), read("a.png"), "{frame} {exposure}");
        }
    }
    assert_eq!(["out.6.exr", "out.6.denoised.exr"].map(read), before);
    assert_ne!(read("out.6.png"), read("out.6.denoised.png"));
}

#[test]
fn sequences_and_frames_that_cannot_be_are_refused() {
    let sandbox = with_moving();
    for (words, says) in [
        (
            "moving.glb --frames 0..3 -o out.exr",
            "out.exr: --frames writes a file for each frame: expected #### for its number with -o",
        ),
        ("moving.glb --frames 0..3 -o -", "-: --frames writes a file for each frame"),
        (
            "moving.glb --frames 0..3 --png a.png",
            "a.png: --frames writes a file for each frame: expected #### for its number with --png",
        ),
        ("moving.glb --frames 0..3 -o a#b#.exr", "a#b#.exr: expected one run of # for the number of the frame with -o"),
        ("moving.glb --frames 0..3 -o gone/#.exr", "gone/0.exr: cannot write"),
        ("moving.glb --frames 0..3 -o #.exr --png #.exr", "0.exr: --png names the same file as -o 0.exr"),
        ("face.obj --frame 3", "--frame is for scenes that are .glb or .gltf: ../scenes/face.obj has no animations"),
        ("moving.glb --fps 30", "--fps 30: expected --frame N beside it"),
    ] {
        render(&sandbox, words, "").exits(2).says_last(&format!("error: {says}"));
    }
    for words in
        "--frames 3..3|--frames 3|--frames -1..3|--frames 0..3 --frame 1|--frames 0..3 --watch|--frame x".split('|')
    {
        render(&sandbox, "moving.glb", words).exits(2);
    }
    assert_eq!(sandbox.files(), Vec::<String>::new());
    for command in ["check", "plan"] {
        sandbox.says(&format!("{command} ../scenes/moving.glb --frame -3 --fps 25")).exits(0);
    }
}

/// In a frame, the shutter of a scene file opens and closes later: as if the file said so.
#[test]
fn frames_of_a_scene_file_move_its_shutter() {
    let sandbox = Sandbox::new();
    let text = |shutter: &str| {
        let moving = "Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((1, 0, 0))])], object: Sphere";
        SPHERE
            .replace("Sphere", moving)
            .replace("material: \"grey\")", "material: \"grey\"))")
            .replace("camera: (", &format!("camera: (shutter: {shutter}, "))
    };
    sandbox.scene("moves.ron", &text("(0, 0.05)"));
    sandbox.scene("later.ron", &text("(0.25, 0.3)"));
    render(&sandbox, "moves.ron", "--spp 8 --frames 0..3 --fps 8 -o #.exr").exits(0);
    render(&sandbox, "later.ron", "--spp 8 -o later.exr").exits(0);
    render(&sandbox, "moves.ron", "--spp 8 -o first.exr").exits(0);
    render(&sandbox, "moves.ron", "--spp 8 --fps 30 -o rate.exr").exits(0);
    let later = film(&sandbox, "later.exr");
    assert!(film(&sandbox, "2.exr").has_pixels_of(&later) && !film(&sandbox, "1.exr").has_pixels_of(&later));
    let first = film(&sandbox, "first.exr");
    assert!(film(&sandbox, "0.exr").has_pixels_of(&first) && film(&sandbox, "rate.exr").has_pixels_of(&first));
    let refused = render(&sandbox, "moves.ron", "--spp 16 --frame 1 --fps 8 -o 2.exr --resume").exits(2);
    assert!(refused.last_line().contains("--frame is 1 in this render and 2 in 2.exr"), "{}", refused.stderr);
}

/// A signal ends the whole sequence: the frame that is under way keeps its samples, and later ones do not begin.
#[test]
#[cfg(unix)]
fn a_signal_ends_a_sequence() {
    use crate::common::program::{finish, meanwhile, send};
    use crate::sandbox::ENDLESS;
    let sandbox = with_moving();
    let line = format!(
        "render ../scenes/moving.glb --size 16x10 --device {} --spp {ENDLESS} --frames 0..3 --checkpoint 50ms -o out.#.exr",
        software()
    );
    let mut child = sandbox.command(&line.split(' ').collect::<Vec<_>>()).spawn().unwrap();
    meanwhile(&mut child, || sandbox.at("out.0.exr").exists());
    send(&child, libc::SIGINT);
    let ran = finish(child).exits(130);
    assert_eq!(sandbox.files(), ["out.0.exr"]);
    let says = "--frames 0..3 --checkpoint 50ms -o 'out.#.exr' --resume` goes on";
    assert!(ran.last_line().contains(says), "{}", ran.stderr);
}
