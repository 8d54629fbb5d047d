//! `gpu-rt serve`: its images are those of the command line, whatever was rendered before; and what ends a session, and what does not.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use exr::prelude::{FlatSamples, MetaData, read_all_flat_layers_from_file};
use gpu_rt::output::exr::read_attributes;
use serde_json::{Value, json};

use crate::common::device::index as software;
use crate::common::fault::Fault;
use crate::common::program::{finish, send, until};
use crate::display::{assert_shown, viewer};
use crate::sandbox::{ENDLESS, Sandbox};

/// A glass cup on a table, fog, lamps of both kinds. The fields of the camera, the place of the cup, and the fields of the lamps are left open.
fn scene(camera: &str, place: &str, lamp: &str, bulb: &str) -> String {
    format!(
        "Scene(image: (width: 24, height: 16), camera: ({camera}), background: Solid((0.1, 0.1, 0.2)),
         materials: {{\"table\": Lambertian(albedo: Checker(scale: 0.3, even: (0.2, 0.3, 0.1), odd: (0.9, 0.9, 0.9))),
             \"glass\": Dielectric(ior: 1.5), \"lamp\": DiffuseLight({lamp})}},
         objects: [
             Quad(corner: (-4, -1, -4), u: (0, 0, 8), v: (8, 0, 0), material: \"table\"),
             Named(name: \"cup\", object: Transformed(by: [{place}], object: Group([
                 Transformed(by: [Scale(0.7)], object: Sphere(center: (0, 0, 0), radius: 1, material: \"glass\")),
                 Box(min: (0.8, -0.2, -0.2), max: (1.1, 0.2, 0.2), material: \"table\"),
             ]))),
             Named(name: \"bulb\", object: Transformed(by: [Translate((0, 3, 0))], object: PointLight({bulb}))),
             Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\"),
             Medium(boundary: Sphere(center: (-1.5, 0, 0), radius: 0.8), density: 2, albedo: Rgb(0.9, 0.9, 0.9)),
         ], render: (samples: 16, max_depth: 9))"
    )
}

const CAMERA: &str = "look_from: (0, 1, 5), look_at: (0, 0, 0), vertical_fov: 50";
const LAMP: &str = "emit: Rgb(5, 5, 5)";
const BULB: &str = "at: (0, 0, 0), intensity: (1, 2, 3)";

/// A session, which the program serves.
struct Served {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Served {
    fn start(command: &mut Command) -> Served {
        let mut child = command.stdin(Stdio::piped()).spawn().expect("the program starts");
        let (requests, answers) = (child.stdin.take(), BufReader::new(child.stdout.take().expect("a pipe")));
        Served { child, requests, answers }
    }

    /// A session of the scene in a sandbox, which has begun.
    fn open(sandbox: &Sandbox, more: &[&str]) -> Served {
        sandbox.scene("sphere.ron", &scene(CAMERA, "", LAMP, BULB));
        let arguments = [&["serve", "../scenes/sphere.ron", "--device", software()], more].concat();
        let mut served = Served::start(&mut sandbox.command(&arguments));
        let expected = json!({"objects": ["cup", "bulb"], "materials": ["table", "glass", "lamp"], "image": [24, 16], "size": [24, 16], "focus": null});
        assert_eq!(served.answer(), expected);
        served
    }

    fn send(&mut self, line: &str) {
        let requests = self.requests.as_mut().expect("it is open");
        requests.write_all(format!("{line}\n").as_bytes()).expect("it reads");
    }

    fn answer(&mut self) -> Value {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("it writes");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"))
    }

    #[track_caller]
    fn renders(&mut self, output: &str, mut request: Value) -> Value {
        request["output"] = json!(output);
        self.send(&request.to_string());
        let answer = self.answer();
        assert_eq!(answer["error"], Value::Null, "{request}");
        answer["report"].clone()
    }

    /// The message of a request that is refused.
    #[track_caller]
    fn refuses(&mut self, line: &str) -> Value {
        self.send(line);
        let answer = self.answer();
        assert_eq!(
            (&answer["report"], &answer["error"]["interrupted"], &answer["error"]["lost"]),
            (&Value::Null, &json!(false), &json!(false))
        );
        answer["error"].clone()
    }

    /// Ends the session by the end of its standard input.
    fn ends(mut self, status: i32) {
        self.requests = None;
        finish(self.child).exits(status);
    }
}

/// All bits of an EXR: of the picture and of the state. And the header, but for the times and the command.
type Contents = (BTreeMap<String, Vec<u32>>, BTreeMap<String, String>, Vec<String>);

fn contents(path: &Path) -> Contents {
    let image = read_all_flat_layers_from_file(path).expect("an EXR");
    let mut bits = BTreeMap::new();
    for (part, layer) in image.layer_data.iter().enumerate() {
        for channel in &layer.channel_data.list {
            let words = match &channel.sample_data {
                FlatSamples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
                FlatSamples::U32(values) => values.clone(),
                FlatSamples::F16(values) => values.iter().map(|value| u32::from(value.to_bits())).collect(),
            };
            bits.insert(format!("{part}.{}", channel.name), words);
        }
    }
    let differs = |name: &str| name.contains("seconds_") || name == "gpu-rt:command";
    let attributes = read_attributes(path).expect("a header").into_iter().filter(|(name, _)| !differs(name));
    let headers = MetaData::read_from_file(path, true).expect("an EXR").headers;
    let states = headers.iter().skip(1).filter_map(|header| header.own_attributes.other.get(&b"gpu-rt:state"[..]));
    let states = states.map(|state| format!("{state:?}")).collect();
    (bits, attributes.map(|(name, value)| (name, format!("{value:?}"))).collect(), states)
}

/// Each request begins with the scene as it was opened: after any other it gives the file that a fresh process renders of a scene file that
/// says the same. Of numbers, materials, objects, lights, cameras and channels.
#[test]
fn images_are_those_of_the_command_line() {
    let sandbox = Sandbox::new();
    let mut served = Served::open(&sandbox, &["--seed", "3"]);
    let far = "look_from: (100000001, 1.5, 4), look_at: (100000000, 0, 0), up: (0, 1, 0.1), vertical_fov: 1e-3";
    let round = "look_from: (0, 0.5, 2), look_at: (0, 0, 0), projection: Equirectangular()";
    let matrix = json!({"cup": [[0, 0, 2, 0.5], [0, 2, 0, 0], [-2, 0, 0, -1], [0, 0, 0, 1]]});
    let cases = [
        (json!({}), scene(CAMERA, "", LAMP, BULB), "--seed 3"),
        (
            json!({"seed": 7, "spp": 24, "aov": "depth,normal,object"}),
            scene(CAMERA, "", LAMP, BULB),
            "--seed 7 --spp 24 --aov depth,normal,object",
        ),
        (json!({"camera": format!("({far})")}), scene(far, "", LAMP, BULB), "--seed 3"),
        (
            json!({"camera": "(look_from: (0, 0.5, 2), projection: Equirectangular())"}),
            scene(round, "", LAMP, BULB),
            "--seed 3",
        ),
        (json!({"camera": "(aperture: 0.5)"}), scene(&format!("{CAMERA}, aperture: 0.5"), "", LAMP, BULB), "--seed 3"),
        (
            json!({"objects": matrix}),
            scene(CAMERA, "Scale(2), RotateY(90), Translate((0.5, 0, -1))", LAMP, BULB),
            "--seed 3",
        ),
        (
            json!({"materials": {"lamp": "(emit: (1, 9, 2), two_sided: false)"}}),
            scene(CAMERA, "", "emit: Rgb(1, 9, 2), two_sided: false", BULB),
            "--seed 3",
        ),
        (json!({"size": "30x10"}), scene(CAMERA, "", LAMP, BULB), "--seed 3 --size 30x10"),
        (
            json!({"materials": {"bulb": "(intensity: (9, 0, 0))"}}),
            scene(CAMERA, "", LAMP, "at: (0, 0, 0), intensity: (9, 0, 0)"),
            "--seed 3",
        ),
    ];
    let mut all: Vec<Contents> = Vec::new();
    for round in 0..2 {
        for (number, (request, text, options)) in cases.iter().enumerate() {
            let file = format!("served{round}{number}.exr");
            served.renders(&file, request.clone());
            let found = contents(&sandbox.at(&file));
            if round == 0 {
                // The session has read its scene.
                sandbox.scene("sphere.ron", text);
                let line =
                    format!("render ../scenes/sphere.ron --device {} {options} -o fresh{number}.exr", software());
                sandbox.says(&line).exits(0);
                // The places in warnings and the hash of the objects are those of another text where something is placed.
                let is_moved = request.get("objects").is_some();
                let fresh = contents(&sandbox.at(format!("fresh{number}.exr")));
                assert!(is_moved || found.2 == fresh.2, "{request}: {:?} {:?}", found.2, fresh.2);
                assert!(is_moved || found.1 == fresh.1, "{request}: {:?} {:?}", found.1, fresh.1);
                assert!(
                    found.0 == fresh.0,
                    "{request}: {:?}",
                    found.0.iter().find(|(name, words)| fresh.0.get(*name) != Some(*words))
                );
                assert!(all.iter().all(|other| other.0 != found.0), "{request} changes nothing");
                all.push(found);
            } else {
                assert!(all[number] == found, "{request}: it depends on what was before");
            }
        }
    }
    served.ends(0);
}

/// Textures, a sky, meshes with their hierarchies, and what moves stay on the device or are made anew, as they must.
#[test]
fn scenes_with_files_are_those_of_the_command_line() {
    let sandbox = Sandbox::new();
    for name in ["window", "sky", "instances", "motion", "mesh"] {
        let scene = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        let settings = ["--size", "24x16", "--spp", "2", "--device", software()];
        sandbox.run(&[&["render", &scene, "-o", "fresh.exr", "--force"], &settings[..]].concat()).exits(0);
        let mut served = Served::start(&mut sandbox.command(&[&["serve", &scene], &settings[..]].concat()));
        served.answer();
        let elsewhere = json!({"camera": "(look_from: (0.5, 2, 3), look_at: (0, 1, 0))", "seed": 1});
        for request in [json!({}), elsewhere.clone(), json!({"seed": 1}), elsewhere, json!({})] {
            served.renders("served.exr", request.clone());
            let is_same = contents(&sandbox.at("served.exr")) == contents(&sandbox.at("fresh.exr"));
            assert_eq!(is_same, request.get("seed").is_none(), "{name}: {request}");
        }
        served.ends(0);
    }
}

#[test]
fn a_bad_request_leaves_the_session_usable() {
    let sandbox = Sandbox::new();
    let mut served = Served::open(&sandbox, &[]);
    served.renders("first.exr", json!({}));
    let first = contents(&sandbox.at("first.exr"));
    let of_scene = |change: &str| format!("{{\"output\": \"bad.exr\", {change}}}");
    let matrix =
        |last: &str| format!(r#""objects": {{"cup": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, {last}, 0], [0, 0, 0, 1]]}}"#);
    for (line, words) in [
        ("no JSON".to_owned(), "the request: expected"),
        (r#"{"sed": 3}"#.to_owned(), "unknown field `sed`, expected one of `output`, `seed`"),
        (of_scene(r#""spp": 0"#), "expected a number of samples from 1 to"),
        (of_scene(r#""aov": "fog""#), "aov: expected some of albedo"),
        (of_scene(r#""size": "0x16""#), "size: expected WIDTHxHEIGHT from 1x1"),
        (of_scene(r#""size": 16"#), "the request: invalid type: integer `16`, expected a string"),
        (of_scene(r#""display": "14158""#), "display: expected HOST:PORT"),
        (of_scene(r#""camera": "(look_fron: (1, 2, 3))""#), "did you mean look_from?"),
        (of_scene(r#""camera": "(look_from: (0, 0, 0))""#), "look_at and look_from are the same point"),
        (of_scene(r#""camera": "(look_from: (1, 2, 3)""#), "expected fields in brackets"),
        (of_scene(r#""camera": "3""#), "expected fields in brackets"),
        (of_scene(r#""camera": "(aperture: 1, projection: Orthographic(height: 3))""#), "has no lens"),
        (
            of_scene(r#""objects": {"cop": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}"#),
            r#"expected one of "cup", "bulb"; did you mean "cup"?"#,
        ),
        (of_scene(&matrix("2")), "one positive scale"),
        (of_scene(&matrix("-1")), "one positive scale"),
        (
            of_scene(r#""objects": {"cup": [[1e300, 0, 0, 0], [0, 1e300, 0, 0], [0, 0, 1e300, 0], [0, 0, 0, 1]]}"#),
            "one positive scale",
        ),
        (
            of_scene(r#""objects": {"cup": [[1e99, 0, 0, 9.9e99], [0, 1e99, 0, 0], [0, 0, 1e99, 0], [0, 0, 0, 1]]}"#),
            "out of the range of numbers",
        ),
        (of_scene(r#""materials": {"glas": "(ior: 2)"}"#), r#"did you mean "glass"?"#),
        (of_scene(r#""materials": {"glass": "(ior: -2)"}"#), "ior"),
        (of_scene(r#""materials": {"glass": "(fuzz: 1)"}"#), "unknown field fuzz"),
        (of_scene(r#""materials": {"lamp": "(emit: Image(path: \"a.png\"))"}"#), "has not read the image"),
        (of_scene(r#""materials": {"bulb": "(intensity: (-1, 0, 0))"}"#), "intensity"),
        (r#"{"output": "none/bad.exr"}"#.to_owned(), "none"),
        (r#"{"output": "bad.txt"}"#.to_owned(), "bad.txt"),
    ] {
        let error = served.refuses(&line);
        let message = error["message"].as_str().expect("a text");
        assert!(message.contains(words), "{line}: {message}");
    }
    let faults = served.refuses(&of_scene(r#""camera": "(vertical_fov: 200, aperture: -1)""#))["faults"].clone();
    let fields: Vec<&str> =
        faults.as_array().expect("a list").iter().filter_map(|fault| fault["field"].as_str()).collect();
    assert_eq!(fields, ["camera.vertical_fov", "camera.aperture"]);
    assert!(!sandbox.at("bad.exr").exists());
    served.renders("last.exr", json!({}));
    assert!(contents(&sandbox.at("last.exr")) == first);
    served.ends(0);
}

/// Each request may have a viewer and a size of its own.
#[test]
fn a_viewer_gets_the_images_of_a_request() {
    let sandbox = Sandbox::new();
    let mut served = Served::open(&sandbox, &[]);
    for (width, height) in [(20, 10), (5, 2)] {
        let (address, bytes, viewer) = viewer();
        served.renders("sphere.exr", json!({"size": format!("{width}x{height}"), "display": address}));
        viewer.join().expect("the viewer has all");
        assert!(assert_shown(&sandbox, &bytes.lock().unwrap(), (width, height)) >= 1);
        served.renders("other.exr", json!({}));
    }
    // One that is not there stops nothing.
    served.renders("other.exr", json!({"display": "127.0.0.1:1"}));
    served.ends(0);
}

/// An interrupt ends the renders that were requested before it, also one that has not begun, and none behind it.
#[test]
fn an_interrupt_ends_a_render_and_not_the_session() {
    let sandbox = Sandbox::new();
    let mut served = Served::open(&sandbox, &[]);
    let endless = json!({"output": "endless.exr", "spp": ENDLESS.parse::<u32>().expect("a number")}).to_string();
    for pause in [0, 1, 300] {
        served.send(&endless);
        std::thread::sleep(Duration::from_millis(pause));
        served.send(r#"{"interrupt": true}"#);
        let answer = served.answer();
        assert_eq!(answer["error"]["interrupted"], true, "{answer}");
        if pause == 300 {
            assert!(
                answer["report"]["interrupted"] == true && answer["report"]["samples_per_pixel"].as_u64() > Some(0),
                "{answer}"
            );
            assert!(sandbox.at("endless.exr").exists());
        }
        // One that finds nothing under way has no effect.
        served.send(r#"{"interrupt": true}"#);
        served.renders("a.exr", json!({}));
    }
    // Two at once.
    served.send(&endless);
    served.send(&endless);
    served.send(r#"{"interrupt": true}"#);
    assert!((0..2).all(|_| served.answer()["error"]["interrupted"] == true));
    served.renders("a.exr", json!({}));
    served.ends(0);
}

#[test]
fn the_end_of_its_input_and_signals_end_it() {
    let sandbox = Sandbox::new();
    // What has been requested is rendered.
    let mut served = Served::open(&sandbox, &[]);
    served.send(r#"{"output": "a.exr"}"#);
    served.requests = None;
    assert_eq!(served.answer()["report"]["samples_per_pixel"], 16);
    served.ends(0);

    let mut served = Served::open(&sandbox, &[]);
    let endless = format!(r#"{{"output": "endless.exr", "spp": {ENDLESS}}}"#);
    // While kernels compile, a signal ends the program without an answer: here they are ready before.
    let mut is_compiled = false;
    while !is_compiled {
        served.send(&endless);
        std::thread::sleep(Duration::from_millis(100));
        served.send(r#"{"interrupt": true}"#);
        is_compiled = !served.answer()["report"].is_null();
    }
    served.send(&endless);
    std::thread::sleep(Duration::from_millis(300));
    send(&served.child, libc::SIGTERM);
    assert_eq!(served.answer()["error"]["interrupted"], true);
    served.ends(128 + libc::SIGTERM);

    // While it waits for a request, too.
    let mut served = Served::open(&sandbox, &[]);
    served.renders("a.exr", json!({}));
    send(&served.child, libc::SIGTERM);
    assert_eq!(served.child.wait().expect("it ends").code(), Some(128 + libc::SIGTERM));

    // Its parent's end, while it renders: the images are gone with it.
    fs::create_dir(sandbox.at("images")).expect("a folder is made");
    let program = env!("CARGO_BIN_EXE_gpu-rt");
    let line = format!("{program} serve ../scenes/sphere.ron --device {} --temporary images <&3 & wait", software());
    let mut shell = Command::new("sh");
    let mut served = Served::start(
        shell.args(["-c", &format!("exec 3<&0; {line}")]).current_dir(sandbox.work()).stdout(Stdio::piped()),
    );
    served.answer();
    served.send(&format!(r#"{{"output": "images/a.exr", "spp": {ENDLESS}, "seed": 1}}"#));
    send(&served.child, libc::SIGKILL);
    served.requests = None;
    let mut rest = Vec::new();
    // Its output ends when it does.
    std::io::Read::read_to_end(&mut served.answers, &mut rest).expect("it can be read");
    until(&mut served.child, |_| !sandbox.at("images").exists());
    served.child.wait().expect("the shell has ended");
}

/// A device that is lost is opened once more; one that stays lost ends the session, and the answer says so.
#[test]
fn a_lost_device_ends_the_session_if_it_stays_lost() {
    let sandbox = Sandbox::new();
    let folder = sandbox.work();
    sandbox.scene("sphere.ron", &scene(CAMERA, "", LAMP, BULB));
    let serve = || sandbox.command(&["serve", "../scenes/sphere.ron", "--device", software()]);
    let mut command = serve();
    let once = Fault::once(&folder, "vkQueueSubmit", 60, "lost");
    once.put_under(&mut command);
    let mut served = Served::start(&mut command);
    served.answer();
    for seed in 0..9 {
        served.renders(&format!("{seed}.exr"), json!({"seed": seed}));
    }
    assert!(once.has_happened());
    for seed in [0, 4, 8] {
        let line = format!("render ../scenes/sphere.ron --device {} --seed {seed} -o fresh.exr --force", software());
        sandbox.says(&line).exits(0);
        assert!(contents(&sandbox.at("fresh.exr")).0 == contents(&sandbox.at(format!("{seed}.exr"))).0, "{seed}");
    }
    served.ends(0);

    let mut command = serve();
    Fault::new(&folder, "vkQueueSubmit", 60, "lost").put_under(&mut command);
    let mut served = Served::start(&mut command);
    served.answer();
    let lost = (0..99).find_map(|seed| {
        served.send(&json!({"output": "a.exr", "seed": seed}).to_string());
        Some(served.answer()["error"].clone()).filter(|error| !error.is_null())
    });
    let error = lost.expect("the device is lost");
    assert_eq!((&error["lost"], &error["interrupted"]), (&json!(true), &json!(false)));
    assert!(error["message"].as_str().is_some_and(|message| message.contains("gpu-rt devices")), "{error}");
    served.ends(1);
}
