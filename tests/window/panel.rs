//! The widgets, the mouse and the keys, without a display.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use clap::Parser;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use gpu_rt::commands::view::{Link, Rendering, ViewState, Window, WindowArgs};
use gpu_rt::output::exr::{read_exr, read_state};
use gpu_rt::scene::Scene;

use crate::common::device::index;
use crate::common::program::{command, ran, words};

/// How long a driver may compile.
const LIMIT: Duration = Duration::from_secs(240);

/// Two spheres and a floor, of three materials. The camera looks along -z at the first.
const SCENE: &str = r#"Scene(
    image: (width: 96, height: 64),
    camera: (look_from: (0, 1, 6), look_at: (0, 1, 0), vertical_fov: 40),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)),
    materials: {
        "red": Lambertian(albedo: Rgb(0.8, 0.2, 0.1)),
        "mirror": Metal(albedo: Rgb(0.8, 0.8, 0.8), fuzz: 0.1),
        "grey": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)),
    },
    objects: [
        Named(name: "ball", object: Sphere(center: (0, 1, 0), radius: 1, material: "red")),
        Sphere(center: (2.2, 1, 0), radius: 1, material: "mirror"),
        Quad(corner: (-50, 0, -50), u: (100, 0, 0), v: (0, 0, 100), material: "grey"),
    ],
    render: (samples: 64, max_depth: 8),
)
"#;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: WindowArgs,
}

/// A window that nobody sees.
struct Viewer {
    harness: Harness<'static, Window>,
    link: Arc<Link>,
    renderer: Option<JoinHandle<()>>,
    folder: tempfile::TempDir,
}

impl Viewer {
    /// Opens the scene with more options.
    fn open(options: &str) -> Viewer {
        Viewer::with("scene.ron", SCENE, |_| (), options)
    }

    /// Opens a scene of this name beside more files.
    fn with(name: &str, scene: &str, write: impl FnOnce(&Path), options: &str) -> Viewer {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join(name), scene).expect("the scene is written");
        write(folder.path());
        let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        let line = format!("view {} -o {} --device {} {options}", at(name), at("a.exr"), index());
        let args = Line::try_parse_from(words(&line)).expect("it is a command line").args;
        let link = Arc::<Link>::default();
        let rendering = Rendering::open(&args, Arc::clone(&link)).expect("the scene is valid");
        let window = Window::new(Arc::clone(&link), args.view.transform());
        let renderer = Some(spawn(move || rendering.run()));
        let harness = Harness::builder().with_size([900.0, 600.0]).build_ui_state(|ui, window| window.draw(ui), window);
        Viewer { harness, link, renderer, folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Draws the window until the thread has found something.
    #[track_caller]
    fn until(&mut self, what: &str, is_so: impl Fn(&ViewState) -> bool) -> ViewState {
        let begin = Instant::now();
        loop {
            self.harness.step();
            let state = self.link.state();
            if is_so(&state) {
                self.harness.step();
                return state;
            }
            assert!(begin.elapsed() < LIMIT, "never: {what}: {:?}", ViewState { shown: None, ..state });
            sleep(Duration::from_millis(5));
        }
    }

    /// Waits for the image from where the camera is now, with so many samples.
    #[track_caller]
    fn until_samples(&mut self, samples: u64) -> ViewState {
        self.harness.step();
        let revision = self.link.orders().revision;
        self.until("the image", |state| {
            state.shown.as_ref().is_some_and(|shown| {
                !shown.is_small && shown.revision == revision && shown.samples >= samples && !state.is_compiling
            })
        })
    }

    #[track_caller]
    fn press(&mut self, label: &str) {
        self.harness.step();
        self.harness.get_by_label(label).click();
        self.harness.step();
        self.harness.step();
    }

    /// Chooses one of a list.
    #[track_caller]
    fn choose(&mut self, list: &str, name: &str) {
        self.harness.step();
        self.harness.get_by_role_and_label(eframe::egui::Role::ComboBox, list).click();
        self.harness.step();
        self.press(name);
    }

    /// Sets a number.
    fn set(&mut self, name: &str, value: f64) {
        self.harness.step();
        self.harness.get_by_role_and_label(eframe::egui::Role::SpinButton, name).set_value_accesskit(value);
        (0..2).for_each(|_| self.harness.step());
    }

    #[track_caller]
    fn has(&mut self, text: &str) -> bool {
        self.harness.step();
        self.harness.query_by_label_contains(text).is_some()
    }

    /// Drags over the image, in points.
    fn drag(&mut self, x: f32, y: f32) {
        let from = self.harness.get_by_label("Image").rect().center();
        self.harness.hover_at(from);
        self.harness.step();
        self.harness.drag_at(from);
        self.harness.step();
        for step in 1..=4 {
            self.harness.hover_at(from + way(x, y, step));
            self.harness.step();
        }
        self.harness.drop_at(from + way(x, y, 4));
        self.harness.step();
    }

    /// Clicks on a pixel of the image.
    fn click(&mut self, pixel: (u32, u32)) {
        let rect = self.harness.get_by_label("Image").rect();
        let (width, height) = self.link.state().size;
        let scale = (rect.width() / width as f32).min(rect.height() / height as f32);
        let offset = [pixel.0 as f32 + 0.5 - width as f32 / 2.0, pixel.1 as f32 + 0.5 - height as f32 / 2.0];
        let at = rect.center() + eframe::egui::vec2(offset[0], offset[1]) * scale;
        self.harness.hover_at(at);
        self.harness.step();
        self.harness.drag_at(at);
        self.harness.step();
        self.harness.drop_at(at);
        self.harness.step();
    }
}

/// The way of a drag after some of its four steps.
fn way(x: f32, y: f32, step: u8) -> eframe::egui::Vec2 {
    eframe::egui::vec2(x, y) * f32::from(step) / 4.0
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.link.order(|orders| orders.ends = true);
        self.renderer.take().map(JoinHandle::join);
    }
}

/// Asserts that two EXR have the same film and the same values, and that their PNGs have the same bytes.
#[track_caller]
fn assert_same(a: &Path, b: &Path) {
    let state = |path| read_state(path).expect("an EXR").expect("it has a state");
    assert_eq!(state(a).film().expect("a film").film, state(b).film().expect("a film").film);
    assert_eq!(state(a).difference("", &state(b), ""), None);
    let (one, other) = (read_exr(a).expect("an EXR"), read_exr(b).expect("an EXR"));
    assert_eq!((one.rgb, one.variance), (other.rgb, other.variance));
    let bytes = |path: &Path| fs::read(path.with_extension("png")).expect("a PNG");
    assert_eq!(bytes(a), bytes(b));
}

/// The saved image is that of `render` with the shown options: a part of the samples, an exposure, a curve, and a layer, which is a channel.
#[test]
fn a_saved_image_is_that_of_render() {
    let mut viewer = Viewer::open("--exposure 1 --tonemap filmic --seed 7");
    viewer.until_samples(8);
    viewer.choose("Layer", "albedo");
    viewer.until_samples(8);
    viewer.set("Exposure, stops", 1.5);
    viewer.choose("Curve", "neutral");
    viewer.press("Pause");
    viewer.press("Save EXR and PNG");
    let saved = viewer.until("saved", |state| state.message.starts_with("saved"));
    assert!(saved.message.contains("a.exr") && saved.message.contains("a.png"), "{}", saved.message);
    let count = read_state(&viewer.path("a.exr")).unwrap().unwrap().samples.count();
    assert!(count >= 8, "{count}");
    let line = format!(
        "render scene.ron -o b.exr --png b.png --spp {count} --exposure 1.5 --tonemap neutral --seed 7 --aov albedo --device {}",
        index()
    );
    ran(&mut command(viewer.folder.path(), &words(&line))).exits(0);
    assert_same(&viewer.path("a.exr"), &viewer.path("b.exr"));
    // A second one takes no name that there is.
    viewer.press("Save EXR and PNG");
    viewer.until("saved again", |state| state.message.contains("a.2.exr"));
    assert!(viewer.path("a.2.png").exists());
}

/// A drag turns the camera. Small pictures come at once, and at rest the image is that of the scene with the copied camera.
#[test]
fn the_image_after_a_drag_is_that_of_the_copied_camera() {
    let mut viewer = Viewer::open("--spp 16");
    viewer.until_samples(16);
    let before = viewer.harness.state().camera.clone();
    viewer.drag(60.0, 30.0);
    let revision = viewer.link.orders().revision;
    assert!(revision > 0);
    viewer.until("a small picture", |state| {
        state.shown.as_ref().is_some_and(|shown| {
            shown.is_small && shown.revision == revision && (shown.picture.width, shown.picture.height) == (24, 16)
        })
    });
    viewer.until_samples(16);
    let after = viewer.harness.state().camera.clone();
    assert!((after.look_from - after.look_at).length() - (before.look_from - before.look_at).length() < 1e-9);
    // A drag to the right turns the scene to the right, and downwards shows it from above.
    assert!(after.look_from.x < -0.1 && after.look_from.y > before.look_from.y + 0.1, "{after:?}");
    viewer.harness.get_by_label("Copy").click();
    viewer.harness.step();
    let text = viewer.harness.output().platform_output.commands.iter().find_map(|command| match command {
        eframe::egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let text = text.expect("text is copied");
    let (head, rest) = SCENE.split_once("camera: ").expect("it has a camera");
    let (_, tail) = rest.split_once(",\n").expect("a line of its own");
    let moved = format!("{head}{text},\n{tail}");
    fs::write(viewer.path("moved.ron"), &moved).unwrap();
    assert_eq!(Scene::parse(&moved, Path::new("moved.ron")).expect("it is valid").camera, after);
    viewer.press("Save EXR and PNG");
    viewer.until("saved", |state| state.message.starts_with("saved"));
    let line = format!("render moved.ron -o b.exr --png b.png --spp 16 --device {}", index());
    ran(&mut command(viewer.folder.path(), &words(&line))).exits(0);
    assert_same(&viewer.path("a.exr"), &viewer.path("b.exr"));
    viewer.press("Reset");
    assert_eq!(viewer.harness.state().camera, before);
    viewer.until_samples(16);
}

/// The other moves: shifts, the wheel, arrows, and numbers that are typed.
#[test]
fn keys_and_the_wheel_move_the_camera() {
    use eframe::egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, TouchPhase, vec2};
    let mut viewer = Viewer::open("--spp 8");
    viewer.until_samples(8);
    let camera = |viewer: &Viewer| viewer.harness.state().camera.clone();
    let start = camera(&viewer);
    let distance = |viewer: &Viewer| (camera(viewer).look_from - camera(viewer).look_at).length();
    viewer.harness.key_press(Key::Plus);
    viewer.harness.step();
    viewer.harness.step();
    assert!((distance(&viewer) - 5.4).abs() < 1e-9, "{}", distance(&viewer));
    viewer.harness.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    (0..3).for_each(|_| viewer.harness.step());
    assert!(camera(&viewer).look_at.x > 0.1, "{:?}", camera(&viewer));
    let centre = viewer.harness.get_by_label("Image").rect().center();
    viewer.harness.hover_at(centre);
    viewer.harness.step();
    let (unit, phase, source) = (MouseWheelUnit::Point, TouchPhase::Move, MouseWheelSource::Unknown);
    viewer.harness.event(Event::MouseWheel {
        unit,
        delta: vec2(0.0, 100.0),
        modifiers: Modifiers::NONE,
        phase,
        source,
    });
    (0..60).for_each(|_| viewer.harness.step());
    assert!(distance(&viewer) < 5.0, "{}", distance(&viewer));
    viewer.set("Field of view, degrees", 30.0);
    viewer.set("f-number", 4.0);
    viewer.set("Focus distance", 2.5);
    // A lens of 44.8 mm on 24 mm of film.
    let lens = camera(&viewer);
    assert!(lens.vertical_fov == Some(30.0) && (lens.aperture - 0.011_196_2).abs() < 1e-6, "{lens:?}");
    assert_eq!(lens.focus_distance, Some(2.5));
    viewer.set("f-number", 1e4);
    assert_eq!(camera(&viewer).aperture, 0.0, "a pinhole");
    viewer.harness.key_press(Key::Num0);
    (0..3).for_each(|_| viewer.harness.step());
    assert_eq!(camera(&viewer), start);
    viewer.until_samples(8);
}

/// A click finds the object, its material and the distance; with the switch it makes that sharp.
#[test]
fn a_click_finds_the_surface_and_focuses() {
    let mut viewer = Viewer::open("--spp 8");
    viewer.until_samples(8);
    viewer.click((48, 32));
    let found = viewer.until("the surface", |state| state.surface.is_some()).surface.unwrap();
    // The front of the ball is 5 away. Within the pixel in the middle, 0.07 wide, it curves by 0.003.
    let distance = found.words.strip_prefix("48, 32: ball\nmaterial red\ndistance ").expect("the words");
    let distances = [distance.parse().unwrap(), found.depth.unwrap()];
    assert!(distances.iter().all(|found: &f64| (found - 5.0).abs() < 0.01), "{found:?}");
    assert!(viewer.has("material red") && viewer.has("variance"));
    viewer.click((2, 2));
    viewer.until("the sky", |state| {
        state.surface.as_ref().is_some_and(|found| found.pixel == (2, 2) && found.depth.is_none())
    });
    assert!(viewer.has("no surface"));
    viewer.press("Focus by a click");
    viewer.click((48, 62));
    viewer.until("the floor", |state| state.surface.as_ref().is_some_and(|found| found.pixel == (48, 62)));
    viewer.until_samples(8);
    let camera = &viewer.harness.state().camera;
    let floor = viewer.link.state().surface.unwrap();
    assert_eq!(camera.focus_distance, floor.depth);
    let depth = floor.depth.unwrap();
    // The ray falls by tan(20°) · 61/64 a unit of depth, and the floor is 1 below.
    let expected = 1.0 / (20f64.to_radians().tan() * 61.0 / 64.0);
    assert!((depth / expected - 1.0).abs() < 0.03, "{depth} {expected}");
}

/// Each layer has colours of its own, the map of the error too.
#[test]
fn layers_are_shown() {
    let mut viewer = Viewer::open("--spp 16");
    viewer.until_samples(16);
    let view = gpu_rt::output::view_transform::ViewTransform::default();
    let mut seen = Vec::new();
    for name in ["error, 0.1 % to 100 %", "albedo", "normal", "depth", "object", "indirect"] {
        viewer.choose("Layer", name);
        let layer = viewer.link.orders().layer;
        let found = viewer.until("the layer", |state| {
            state.shown.as_ref().is_some_and(|shown| shown.layer == layer && !shown.is_small && shown.samples >= 16)
        });
        let colours = found.shown.unwrap().colours(&view);
        let first = colours[0];
        assert!(colours.iter().any(|colour| *colour != first), "{name} is of one colour");
        assert!(!seen.contains(&colours), "{name} looks like another layer");
        seen.push(colours);
    }
}

#[test]
fn a_pause_stops_the_samples() {
    let mut viewer = Viewer::open("--spp 100000");
    viewer.until_samples(8);
    viewer.press("Pause");
    sleep(Duration::from_millis(300));
    viewer.until("quiet", |state| !state.is_compiling);
    let paused = viewer.until_samples(8).shown.unwrap().samples;
    sleep(Duration::from_millis(500));
    assert_eq!(viewer.until_samples(8).shown.unwrap().samples, paused);
    assert!(viewer.has(&format!("{paused} of 100000 samples")) && viewer.has("relative error"));
    viewer.press("Go on");
    viewer.until_samples(paused + 8);
}

/// With `--watch`, a save shows the new scene from where the camera is. An error is shown with its place, and the next save mends it.
#[test]
fn a_save_of_the_scene_keeps_the_camera() {
    let mut viewer = Viewer::open("--spp 8 --watch");
    let before = viewer.until_samples(8).shown.unwrap().picture.rgb.clone();
    viewer.drag(40.0, 0.0);
    viewer.until_samples(8);
    let camera = viewer.harness.state().camera.clone();
    fs::write(viewer.path("scene.ron"), SCENE.replace("radius: 1, material: \"red\"", "radius: -1, material: \"red\""))
        .unwrap();
    let found = viewer.until("the error", |state| !state.errors.is_empty());
    assert!(found.errors[0].contains("scene.ron:11:") && found.errors[0].contains("radius"), "{:?}", found.errors);
    assert!(viewer.has("scene.ron:11:"));
    fs::write(viewer.path("scene.ron"), SCENE.replace("Rgb(0.8, 0.2, 0.1)", "Rgb(0.1, 0.2, 0.8)")).unwrap();
    viewer.until("the mended scene", |state| state.errors.is_empty());
    viewer.until_samples(8);
    assert_eq!(viewer.harness.state().camera, camera);
    let found = viewer.until("no error", |state| state.errors.is_empty());
    let blue = |rgb: &[[f32; 3]]| rgb[96 * 40 + 40][2] > rgb[96 * 40 + 40][0];
    assert!(blue(&found.shown.unwrap().picture.rgb) && !blue(&before));
}

/// Files that the scene names are read again, too.
#[test]
fn a_save_of_a_mesh_shows_it() {
    let quad = |x: f32| format!("v {x} 0 2\nv {} 0 2\nv {} 2 2\nv {x} 2 2\nf 1 2 3 4\n", x + 2.0, x + 2.0);
    let mut viewer = Viewer::with(
        "scene.ron",
        &SCENE.replace("objects: [", "objects: [Mesh(path: \"quad.obj\", material: \"grey\"),"),
        |folder| {
            fs::write(folder.join("quad.obj"), quad(-1.0)).expect("the mesh is written");
        },
        "--spp 8 --watch",
    );
    let red = |state: ViewState| {
        let [red, _, blue] = state.shown.expect("a picture").picture.rgb[96 * 32 + 48];
        red > 2.0 * blue
    };
    // The mesh hides the red ball until it is elsewhere.
    assert!(!red(viewer.until_samples(8)));
    fs::write(viewer.path("quad.obj"), quad(20.0)).unwrap();
    viewer.until("the save", |state| state.shown.as_ref().is_some_and(|shown| shown.revision == 1));
    assert!(red(viewer.until_samples(8)));
}

/// The camera of a file without a target turns around what the middle of the image shows, after each reading; one that was moved stays.
#[test]
fn a_file_without_a_target_gets_one() {
    let scene = |radius: f64| {
        format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\"><transform name=\"to_world\">
                <lookat origin=\"0, 0, 6\" target=\"0, 0, 5\" up=\"0, 1, 0\"/></transform>
                <film type=\"hdrfilm\"><integer name=\"width\" value=\"96\"/><integer name=\"height\" value=\"64\"/></film></sensor>
            <emitter type=\"constant\"/><shape type=\"sphere\"><float name=\"radius\" value=\"{radius}\"/></shape></scene>"
        )
    };
    let mut viewer = Viewer::with("scene.xml", &scene(1.0), |_| (), "--spp 8 --watch");
    for (radius, revision) in [(1.0, 0), (2.0, 1)] {
        if revision > 0 {
            fs::write(viewer.path("scene.xml"), scene(radius)).unwrap();
        }
        // The middle of the image is a corner of the pixel.
        viewer.until("the target", |state| (state.camera.look_at.z - radius).abs() < 0.01);
        viewer.until_samples(8);
        assert_eq!(viewer.harness.state().camera.look_at, viewer.link.state().camera.look_at);
        assert_eq!(viewer.link.orders().revision, revision, "a target is no other image");
    }
    viewer.drag(40.0, 0.0);
    viewer.until_samples(8);
    let (camera, before) = (viewer.harness.state().camera.clone(), viewer.link.orders().revision);
    fs::write(viewer.path("scene.xml"), scene(1.0)).unwrap();
    viewer.until("the save", |state| state.shown.as_ref().is_some_and(|shown| shown.revision > before));
    viewer.until_samples(8);
    assert!(viewer.harness.state().camera == camera && (camera.look_at.z - 2.0).abs() < 0.01, "{camera:?}");
}

#[test]
fn what_cannot_be_read_opens_no_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    fs::write(&path, SCENE.replace("radius: 1,", "radius: 0,")).unwrap();
    let args = Line::try_parse_from(["view", &path.to_string_lossy(), "--device", index()]).unwrap().args;
    let error = Rendering::open(&args, Arc::default()).err().expect("it fails");
    assert_eq!(error.exit_status(), 2);
}
