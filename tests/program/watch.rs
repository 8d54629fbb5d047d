//! `--watch`: renders again after each save, keeps what has not changed, and ends by a signal.

use std::fs;
use std::path::PathBuf;
use std::process::Child;

use gpu_rt::output::exr::{ExrImage, read_exr};

use crate::common::device::index as software;
use crate::common::gltf::{glb, room};
use crate::common::program::{finish, meanwhile, send};
use crate::sandbox::{ENDLESS, SPHERE, Sandbox, attribute};

/// A program that watches a scene called `sphere`.
struct Watch {
    sandbox: Sandbox,
    scene: &'static str,
    child: Child,
    said: PathBuf,
    /// The number of changes that it must have reported before it is done.
    changes: usize,
}

/// Saves that replace the file, as many editors do, or that write into it.
#[derive(Clone, Copy)]
enum Save {
    InPlace,
    ByName,
}

impl Watch {
    fn new(sandbox: Sandbox, more: &[&str]) -> Watch {
        Watch::start("../scenes/sphere.ron", sandbox, more)
    }

    fn start(scene: &'static str, sandbox: Sandbox, more: &[&str]) -> Watch {
        let said = sandbox.folder.path().join("said");
        let arguments = [&["render", scene, "--device", software(), "--watch", "--verbose"], more].concat();
        let mut command = sandbox.command(&arguments);
        let child = command.stderr(fs::File::create(&said).unwrap()).spawn().expect("the program starts");
        Watch { sandbox, scene, child, said, changes: 0 }
    }

    fn said(&self) -> String {
        fs::read_to_string(&self.said).unwrap()
    }

    /// Waits until it has said this so often.
    fn until_said(&mut self, words: &str, times: usize) {
        let said = self.said.clone();
        meanwhile(&mut self.child, || fs::read_to_string(&said).unwrap().matches(words).count() >= times);
    }

    /// Waits until it has handled the last change, and has printed this. Returns all that it has printed about it. A file that is
    /// written in place may be half there for a moment, which is an error, and then another change.
    fn until(&mut self, words: &str) -> String {
        let (said, least) = (self.said.clone(), self.changes);
        let last = || {
            let said = fs::read_to_string(&said).unwrap();
            let changes = said.matches(" changed\n").count();
            let last = said.rsplit(" changed\n").next().unwrap_or_default().to_owned();
            (changes >= least && last.contains(words) && last.contains(WAITING)).then_some((last, changes))
        };
        meanwhile(&mut self.child, || last().is_some());
        let (last, changes) = last().expect("nobody has changed anything");
        self.changes = changes + 1;
        last
    }

    /// Waits for a render that comes to its end.
    fn until_rendered(&mut self) -> String {
        self.until("sphere.exr: ")
    }

    /// Waits for a render that says this of the last change, and whose image is that of the scene.
    #[track_caller]
    fn shows_the_scene(&mut self, words: &str) -> String {
        let said = self.until_rendered();
        assert!(said.contains(words), "{said}");
        self.is_of_the_scene_with(&[]);
        said
    }

    fn save(&self, text: &(impl AsRef<[u8]> + ?Sized), how: Save) {
        let scene = self.sandbox.at(self.scene);
        match how {
            Save::InPlace => fs::write(&scene, text).unwrap(),
            Save::ByName => {
                let temporary = scene.with_extension("new~");
                fs::write(&temporary, text).unwrap();
                fs::rename(&temporary, &scene).unwrap();
            }
        }
    }

    /// Asserts that the image is that of a plain render of the scene as it is now.
    #[track_caller]
    fn is_of_the_scene_with(&self, more: &[&str]) {
        let plain = ["render", self.scene, "--device", software(), "-o", "plain.exr"];
        self.sandbox.run(&[&plain, more].concat()).exits(0);
        assert!(bits(&self.sandbox.exr("sphere.exr")) == bits(&self.sandbox.exr("plain.exr")), "{}", self.said());
    }

    /// Ends it, and returns the last line that it says.
    fn end(self) -> String {
        send(&self.child, libc::SIGINT);
        finish(self.child).exits(130);
        let said = fs::read_to_string(&self.said).unwrap();
        assert!(!said.contains("panicked"), "{said}");
        said.lines().last().unwrap_or_default().to_owned()
    }
}

/// All that an image holds of its pixels.
fn bits(image: &ExrImage) -> impl PartialEq + use<> {
    let layer = |layer: &[[f32; 3]]| layer.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
    let variance = image.variance.as_ref().map(|variance| layer(variance));
    (image.width, image.height, layer(&image.rgb), variance, image.samples.clone(), image.rejected.clone())
}

const WAITING: &str = "waiting for the next save";

#[test]
fn each_save_is_rendered_with_the_kernels_that_are_there() {
    let mut watch = Watch::new(Sandbox::new(), &["--png", "sphere.png"]);
    let said = watch.shows_the_scene("");
    let sizes = |said: &str| {
        let before =
            |line: &str| line.strip_prefix("preview of ")?.split_once(" after").map(|(size, _)| size.to_owned());
        said.lines().filter_map(before).collect::<Vec<_>>()
    };
    // A quarter, a half, and then all of it.
    assert_eq!(sizes(&said), ["5 x 3 pixels", "10 x 6 pixels"], "{said}");
    let redder = SPHERE.replace("Rgb(0.5", "Rgb(0.75");
    let none = ": 0 kernels compiled, 0 of 0 images and meshes read";
    for (text, how) in [(redder.as_str(), Save::InPlace), (SPHERE, Save::ByName), (&redder, Save::ByName)] {
        watch.save(text, how);
        let said = watch.shows_the_scene("");
        assert_eq!((sizes(&said).len(), said.matches(none).count()), (2, 2), "{said}");
        assert_eq!(image::image_dimensions(watch.sandbox.at("sphere.png")).unwrap(), (20, 12));
    }
    // Another material needs other kernels, and the compile time is reported.
    watch.save(&SPHERE.replace("Lambertian(albedo: Rgb(0.5, 0.4, 0.3))", "Dielectric(ior: 1.5)"), Save::InPlace);
    let said = watch.shows_the_scene("");
    assert!(said.contains("compiled for the change: ") && said.matches(none).count() == 1, "{said}");
    // The earlier messages are still there.
    watch.save(SPHERE, Save::InPlace);
    let said = watch.shows_the_scene("");
    assert_eq!(said.matches(none).count(), 2, "{said}");
    assert_eq!(watch.sandbox.files(), ["plain.exr", "sphere.exr", "sphere.png"]);
    assert_eq!(watch.end(), "error: interrupted by SIGINT; sphere.exr holds the last picture");
}

#[test]
fn an_error_is_shown_as_check_shows_it_and_the_picture_stays() {
    let mut watch = Watch::new(Sandbox::new(), &[]);
    watch.until_rendered();
    let before = fs::read(watch.sandbox.at("sphere.exr")).unwrap();
    for wrong in [SPHERE.replace("radius: 1", "radius: -1, colour: 2"), SPHERE.replace(")],", "")] {
        watch.save(&wrong, Save::ByName);
        let said = watch.until("error: ");
        let checked = watch.sandbox.says("check ../scenes/sphere.ron").exits(2);
        assert!(said.starts_with(&checked.stderr), "{said}\n{}", checked.stderr);
        assert!(fs::read(watch.sandbox.at("sphere.exr")).unwrap() == before, "the picture changed");
    }
    // A file that is away is an error too, and is waited for.
    let scene = watch.sandbox.at("../scenes/sphere.ron");
    fs::remove_file(&scene).unwrap();
    watch.until("cannot read the scene file");
    watch.save(&SPHERE.replace("Rgb(0.5", "Rgb(0.75"), Save::InPlace);
    watch.shows_the_scene("");
    watch.end();
}

/// A scene that is wrong from the start is waited for as well; one that is not there is not.
#[test]
fn the_first_scene_may_be_wrong_but_not_missing() {
    let sandbox = Sandbox::new();
    sandbox.scene("sphere.ron", "Scene(");
    let mut watch = Watch::new(sandbox, &[]);
    watch.until("error: ");
    watch.save(SPHERE, Save::InPlace);
    watch.shows_the_scene("");
    watch.end();
    Sandbox::new().says("render missing.ron --watch").exits(2).on_stderr(&["cannot read the scene file"]);
}

#[test]
fn of_the_files_of_a_scene_only_those_that_changed_are_read() {
    let sandbox = Sandbox::new();
    let scenes = sandbox.folder.path().join("scenes");
    let texture = |name: &str, red: u8| {
        image::RgbImage::from_pixel(4, 4, image::Rgb([red, 90, 60])).save(scenes.join(name)).unwrap();
    };
    texture("red.png", 100);
    fs::write(scenes.join("face.obj"), "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n").unwrap();
    let textured = SPHERE
        .replace("Rgb(0.5, 0.4, 0.3)", "Image(path: \"red.png\")")
        .replace("materials: {", "materials: { \"plain\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3)),")
        .replace("objects: [", "objects: [Mesh(path: \"face.obj\", material: \"plain\"), ");
    sandbox.scene("sphere.ron", &textured);
    let mut watch = Watch::new(sandbox, &[]);
    watch.shows_the_scene(", 2 of 2 images and meshes read");
    // The image, then the mesh, then neither.
    texture("new.png", 200);
    fs::rename(scenes.join("new.png"), scenes.join("red.png")).unwrap();
    watch.shows_the_scene(": 0 kernels compiled, 1 of 2 images and meshes read");
    assert!(watch.said().contains("red.png changed"), "{}", watch.said());
    fs::write(scenes.join("face.obj"), "v 0 0 1\nv 1 0 1\nv 0 1.5 1\nf 1 2 3\n").unwrap();
    watch.shows_the_scene(", 1 of 2 images and meshes read");
    watch.save(&textured.replace("radius: 1,", "radius: 0.9,"), Save::InPlace);
    watch.shows_the_scene(", 0 of 2 images and meshes read");
    // An image that is missing is waited for, though the scene has not been read.
    fs::remove_file(scenes.join("red.png")).unwrap();
    watch.until("red.png: cannot read the image");
    texture("red.png", 50);
    watch.shows_the_scene("");
    watch.end();
}

#[test]
fn a_gltf_file_is_watched_as_a_scene_file_is() {
    const SMALL: [&str; 4] = ["--size", "16x10", "--spp", "8"];
    let sandbox = Sandbox::new();
    let (json, binary) = room();
    fs::write(sandbox.folder.path().join("scenes/sphere.glb"), glb(&json, &binary)).unwrap();
    let mut watch = Watch::start("../scenes/sphere.glb", sandbox, &SMALL);
    watch.until_rendered();
    watch.is_of_the_scene_with(&SMALL);
    let first = fs::read(watch.sandbox.at("sphere.exr")).unwrap();
    let mut redder = json.clone();
    redder["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = serde_json::json!([0.9, 0.1, 0.1, 1.0]);
    watch.save(&glb(&redder, &binary), Save::ByName);
    watch.until_rendered();
    watch.is_of_the_scene_with(&SMALL);
    let second = fs::read(watch.sandbox.at("sphere.exr")).unwrap();
    assert!(first != second, "it shows the first picture");
    // Half of a file, and a complete one that is wrong.
    let full = glb(&json, &binary);
    redder["nodes"][0]["mesh"] = 9.into();
    for (wrong, words) in [
        (full[..full.len() / 2].to_vec(), "error: ../scenes/sphere.glb: "),
        (glb(&redder, &binary), "nodes[0].mesh: there is no mesh 9"),
    ] {
        watch.save(&wrong, Save::ByName);
        watch.until(words);
        assert!(fs::read(watch.sandbox.at("sphere.exr")).unwrap() == second, "the picture changed");
    }
    watch.save(&full, Save::InPlace);
    watch.until_rendered();
    watch.is_of_the_scene_with(&SMALL);
    watch.end();
}

/// The file that holds its numbers is one of the scene's.
#[test]
fn the_buffer_of_a_gltf_file_is_watched() {
    const SMALL: [&str; 4] = ["--size", "16x10", "--spp", "8"];
    let sandbox = Sandbox::new();
    let (mut json, mut binary) = room();
    json["buffers"][0]["uri"] = "room.bin".into();
    let buffer = sandbox.folder.path().join("scenes/room.bin");
    fs::write(sandbox.folder.path().join("scenes/sphere.gltf"), json.to_string()).unwrap();
    fs::write(&buffer, &binary).unwrap();
    let mut watch = Watch::start("../scenes/sphere.gltf", sandbox, &SMALL);
    watch.until_rendered();
    let first = fs::read(watch.sandbox.at("sphere.exr")).unwrap();
    // The first corner's y.
    binary[4..8].copy_from_slice(&0.5f32.to_le_bytes());
    fs::write(&buffer, &binary).unwrap();
    let said = watch.until_rendered();
    watch.is_of_the_scene_with(&SMALL);
    assert!(first != fs::read(watch.sandbox.at("sphere.exr")).unwrap(), "it shows the first picture: {said}");
    watch.end();
}

/// The render under way is given up at once, though it would never end by itself; nothing of it is written.
#[test]
fn a_save_ends_the_render_under_way() {
    let sandbox = Sandbox::new();
    let of_samples = |text: &str, samples: &str| text.replace("samples: 16", &format!("samples: {samples}"));
    sandbox.scene("sphere.ron", &of_samples(SPHERE, ENDLESS));
    let mut watch = Watch::new(sandbox, &[]);
    watch.until_said("preview of 10 x 6", 1);
    watch.save(&of_samples(&SPHERE.replace("Rgb(0.5", "Rgb(0.75"), ENDLESS), Save::ByName);
    watch.until_said("preview of 10 x 6", 2);
    watch.save(SPHERE, Save::ByName);
    watch.shows_the_scene("");
    // Renders that were dropped are not reported.
    assert_eq!(watch.said().matches("relative error").count(), 2, "{}", watch.said());
    watch.end();
}

#[test]
fn a_signal_ends_it_with_the_image_so_far() {
    let watch = Watch::new(Sandbox::new(), &["--spp", ENDLESS, "--checkpoint", "50ms"]);
    let Watch { sandbox, mut child, said, .. } = watch;
    // Behind the previews.
    let path = sandbox.at("sphere.exr");
    meanwhile(&mut child, || read_exr(&path).is_ok_and(|image| image.width == 20));
    send(&child, libc::SIGINT);
    finish(child).exits(130);
    let said = fs::read_to_string(said).unwrap();
    let last = said.lines().last().unwrap_or_default();
    let image = sandbox.exr("sphere.exr");
    assert_eq!((image.width, attribute(&image, "gpu-rt:complete")), (20, "0"), "{said}");
    assert!(last.starts_with("error: interrupted by SIGINT; sphere.exr holds "), "{last}");
}

/// Samples of this very image are worth more than previews.
#[test]
fn samples_of_the_same_image_are_not_overwritten_by_previews_or_fewer() {
    let sandbox = Sandbox::new();
    sandbox.render(&["--spp", "32"]).exits(0);
    let before = fs::read(sandbox.at("sphere.exr")).unwrap();
    sandbox.render(&["--watch"]).exits(2).on_stderr(&["sphere.exr holds 32 samples per pixel of this render"]);
    assert!(fs::read(sandbox.at("sphere.exr")).unwrap() == before);
    let mut watch = Watch::new(sandbox, &["--spp", "40"]);
    let said = watch.until_rendered();
    assert!(!said.contains("preview of"), "{said}");
    assert_eq!(attribute(&watch.sandbox.exr("sphere.exr"), "gpu-rt:end_sample"), "40");
    watch.end();
    let sandbox = Sandbox::new();
    sandbox.render(&["--spp", "32"]).exits(0);
    let mut watch = Watch::new(sandbox, &["--force"]);
    let said = watch.shows_the_scene("");
    assert_eq!(said.matches("preview of").count(), 2, "{said}");
    watch.end();
}

#[test]
fn a_part_of_the_image_has_previews_of_that_part() {
    let mut watch = Watch::new(Sandbox::new(), &["--crop", "3,2,10,7"]);
    watch.until_rendered();
    watch.is_of_the_scene_with(&["--crop", "3,2,10,7"]);
    watch.end();
}

#[test]
fn watch_refuses_streams_and_options_of_one_render() {
    let sandbox = Sandbox::new();
    for (more, words) in [
        ("--samples 0..8", "'--samples <A..B>'"),
        ("--resume", "'--resume[=<auto>]'"),
        ("--json", "'--json'"),
        ("-o -", "-o -: --watch replaces it again and again: give the name of a file"),
        ("--png -", "--png -: --watch replaces it again and again: give the name of a file"),
        ("--png /dev/null", "--png /dev/null: --watch replaces it"),
    ] {
        sandbox.says(&format!("render ../scenes/sphere.ron --watch {more}")).exits(2).on_stderr(&["--watch", words]);
    }
    sandbox.says("render - --watch").exits(2).on_stderr(&["standard input does not change"]);
    assert!(sandbox.files().is_empty());
}
