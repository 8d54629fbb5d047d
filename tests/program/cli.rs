//! The program as its users meet it: command line, streams, files and exit statuses.
//!
//! Nothing here depends on how fast the machine is. Where a program that hangs must be found, it is given two minutes, which is no
//! measure of anything.

use crate::common::device::index as software;
use crate::common::files::{files, stem};
use crate::common::marked::{self, unmarked};
use crate::common::program::{Ran, finish, ran, words};
use crate::common::{render, stats};
use crate::sandbox::{SPHERE, Sandbox, attribute};
use std::fs;
use std::path::Path;

use gpu_rt::output::exr::ExrImage;
use gpu_rt::scene::Scene;
use serde_json::Value;

/// A number of an image's header.
fn number(image: &ExrImage, name: &str) -> f64 {
    attribute(image, &format!("gpu-rt:{name}")).parse().unwrap_or_else(|error| panic!("{name}: {error}"))
}

// render: what it writes

#[test]
fn render_writes_the_scenes_name_into_the_current_folder() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&[]).exits(0);
    assert_eq!(sandbox.files(), ["sphere.exr"]);
    assert_eq!(ran.stdout, "");
    let image = sandbox.exr("sphere.exr");
    assert_eq!((image.width, image.height), (20, 12));
    assert_eq!(image.samples, Some(vec![16; 240]));
    assert_eq!(image.rejected, Some(vec![0; 240]));
    // Lens or not, what the library renders is what the program writes.
    let scene = Scene::parse(SPHERE, Path::new("sphere.ron")).expect("the scene is good");
    let shot = render::render(&scene, &render::Request::spp(16).sobol());
    assert!(image.rgb == shot.picture.rgb && image.variance == Some(shot.picture.variance));
}

#[test]
fn render_ends_with_path_samples_error_and_time() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["-o", "picture one.exr"]).exits(0);
    let line = ran.last_line();
    let (path, rest) = line.split_once(": ").expect("the path comes first");
    assert_eq!(path, "picture one.exr");
    assert!(rest.contains("16 samples"), "{line}");
    let number_before = |unit: &str| {
        let words: Vec<&str> = rest.split_whitespace().collect();
        let at = words.iter().position(|word| word.trim_end_matches(',') == unit);
        let number = at.and_then(|at| words.get(at.checked_sub(1)?)?.parse::<f64>().ok());
        number.unwrap_or_else(|| panic!("no number before {unit} in {line}"))
    };
    let percent = number(&sandbox.exr("picture one.exr"), "relative_error");
    assert!((number_before("%") - 100.0 * percent).abs() <= 0.0051, "{line}, {percent}");
    // With its bound.
    let bound = number(&sandbox.exr("picture one.exr"), "relative_error_bound");
    assert!(line.contains(&format!("below {:.2} %)", 100.0 * bound)) && bound > percent, "{line}, {bound}");
    // What it excludes is stated on request.
    let excludes = |ran: &Ran| ran.stderr.contains("it excludes what max_depth cut off");
    assert!(!excludes(&ran) && excludes(&sandbox.render(&["--verbose"]).exits(0)), "{}", ran.stderr);
    assert!(number_before("s") >= 0.0);
    // A software driver is warned about.
    let devices = sandbox.says("devices --json").exits(0).json();
    let index = software().parse::<usize>();
    if index.is_ok_and(|index| devices["devices"][index]["software"] == true) {
        assert!(ran.stderr.contains("warning") && ran.stderr.contains("software"), "{}", ran.stderr);
    }
}

#[test]
fn render_writes_the_named_file_and_a_png() {
    let sandbox = Sandbox::new();
    fs::create_dir(sandbox.at("sub")).unwrap();
    sandbox.render(&["-o", "sub/image.exr", "--png", "sub/image.png"]).exits(0);
    assert_eq!(sandbox.files(), ["sub"]);
    let png = |name: &str| image::open(sandbox.at(name)).expect("a PNG").into_rgb8();
    let usual = png("sub/image.png");
    assert_eq!(usual.dimensions(), (20, 12));
    // Brighter by two stops, and the linear file does not care.
    sandbox.render(&["-o", "bright.exr", "--png", "bright.png", "--exposure", "-2"]).exits(0);
    let sum = |image: &image::RgbImage| image.as_raw().iter().map(|&v| u64::from(v)).sum::<u64>();
    assert!(sum(&png("bright.png")) < sum(&usual));
    assert!(sandbox.exr("bright.exr").rgb == sandbox.exr("sub/image.exr").rgb);
}

#[test]
fn quiet_says_nothing() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["--quiet"]).exits(0);
    assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
    assert_eq!(sandbox.files(), ["sphere.exr"]);
    // Errors are said, quiet or not.
    let ran = sandbox.says("render missing.ron --quiet").exits(2);
    assert_ne!(ran.stderr, "");
}

#[test]
fn json_is_one_object_with_every_key() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["--json", "--quiet", "--seed", "5", "--max-depth", "3"]).exits(0);
    assert_eq!(ran.stderr, "");
    let json = ran.json();
    for (key, value) in [("width", 20), ("height", 12), ("samples_per_pixel", 16), ("max_depth", 3), ("seed", 5)] {
        assert_eq!(json[key], value, "{key}");
    }
    assert_eq!(json["paths"], 20 * 12 * 16);
    assert_eq!(json["rejected_samples"], 0);
    for key in ["device", "driver"] {
        assert!(json[key].as_str().is_some_and(|text| !text.is_empty()), "{key}");
    }
    let number = |value: &Value, key: &str| {
        let number = value[key].as_f64().unwrap_or_else(|| panic!("{key} is no number in {value}"));
        assert!(number >= 0.0, "{key}");
        number
    };
    // The parts follow one another, also where the work of one is done beside another: their sum is no more than the total.
    let parts = ["load", "build", "device", "compile", "render", "write", "total"];
    let seconds = parts.map(|key| number(&json["seconds"], key));
    assert!(seconds[..6].iter().sum::<f64>() <= seconds[6] * 1.001, "{seconds:?}");
    let first_pass = number(&json["seconds"], "first_pass");
    assert!(first_pass > 0.0 && first_pass <= seconds[4], "{first_pass} of {seconds:?}");
    // Every path has a ray at least, and a scattering event on it adds one at most.
    let (paths, rays) = (number(&json, "paths"), number(&json, "rays"));
    assert!(paths < rays && rays <= 4.0 * paths, "{rays} rays");
    for (key, count) in [("paths_per_second", paths), ("rays_per_second", rays)] {
        assert!((number(&json, key) * seconds[4] / count - 1.0).abs() < 1e-6, "{key}");
    }
    let host = number(&json, "host_seconds");
    assert!(host > 0.0 && host <= seconds[4], "{host} s of {seconds:?}");
    let profiled = sandbox.render(&["--quiet", "--json", "--profile"]).exits(0).json();
    assert!((0.0..1.0).contains(&number(&profiled, "device_idle")) && json.get("device_idle").is_none(), "{profiled}");
    assert!(number(&json, "relative_error") > 0.0);
    assert!(number(&json, "relative_error_bound") > number(&json, "relative_error"));
    assert!(json["reliable"].is_boolean() && json["sampler"] == "sobol");
    assert!(number(&json, "gpu_bytes") > 0.0);
    let kernels = json["kernels"].as_array().expect("a list of kernels");
    assert!(kernels.len() >= 2 && kernels.iter().all(Value::is_string), "{kernels:?}");
    // Where a person watches as well, stdout is the same.
    sandbox.render(&["--json"]).exits(0).json();
}

/// What `check` warns of outlives the run, also a quiet one.
#[test]
fn the_report_and_the_exr_hold_what_check_warns_of() {
    let sandbox = Sandbox::new();
    let text = SPHERE
        .replace("{ \"grey\":", "{ \"glass\": Dielectric(ior: 1.0000001), \"grey\":")
        .replace("objects: [", "objects: [Sphere(center: (1, 0, 0), radius: 1e-9, material: \"grey\"), ");
    let dangerous = sandbox.scene("dangerous.ron", &text);
    let check = sandbox.run(&["check", &dangerous, "--json"]).exits(0).json();
    let warnings: Vec<&str> = check["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(warnings.len() == 3 && warnings.iter().any(|warning| warning.contains("a radius of 1e-9")), "{warnings:?}");
    let render = |more: &[&str]| {
        let ran = sandbox.run(&[&["render", &dangerous, "--device", software(), "--json"], more].concat()).exits(0);
        assert_eq!(ran.json()["warnings"], check["warnings"]);
        assert_eq!(attribute(&sandbox.exr("dangerous.exr"), "gpu-rt:warnings"), warnings.join("\n"));
        ran.stderr
    };
    assert_eq!(render(&["--quiet"]), "");
    let reported = render(&[]);
    assert!(warnings.iter().all(|warning| reported.contains(&format!("warning: {warning}\n"))), "{reported}");
    // A scene without is said to have none.
    let ran = sandbox.render(&["--quiet", "--json"]).exits(0);
    assert_eq!(ran.json()["warnings"], serde_json::json!([]));
    let names = sandbox.exr("sphere.exr").attributes;
    assert!(!names.iter().any(|(name, _)| name == "gpu-rt:warnings"), "{names:?}");
}

/// Whatever the file holds beside, and by whatever name the scene goes.
#[test]
fn the_header_tells_scenes_apart() {
    let sandbox = Sandbox::new();
    let hash_of = |name: &str, text: &str, more: &[&str]| {
        let scene = sandbox.scene(&format!("{name}.ron"), text);
        sandbox.run(&[&["render", &scene, "--device", software(), "--quiet"], more].concat()).exits(0);
        let image = sandbox.exr(&format!("{name}.exr"));
        let command_words = attribute(&image, "gpu-rt:command").to_string();
        (attribute(&image, "gpu-rt:scene_hash").to_string(), command_words)
    };
    let (hash, _) = hash_of("a", SPHERE, &[]);
    assert!(hash.len() == 32 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()), "{hash}");
    let (same, command_words) = hash_of("it's b", &format!("// The same.\n{SPHERE}"), &["--no-state", "--seed", "3"]);
    assert_eq!(same, hash);
    let as_the_shell_reads_it = r"gpu-rt render '../scenes/it'\''s b.ron' ";
    assert!(command_words.starts_with(as_the_shell_reads_it), "{command_words}");
    let (other, _) = hash_of("c", &SPHERE.replace("Lambertian", "Metal"), &[]);
    assert_ne!(other, hash);
}

#[test]
fn the_exr_holds_linear_floats_and_says_how_it_was_made() {
    let sandbox = Sandbox::new();
    let json = sandbox.render(&["--json", "--seed", "77", "--samples", "8..32", "--max-depth", "4"]).exits(0).json();
    let image = sandbox.exr("sphere.exr");
    for (name, value) in [
        ("seed", "77"),
        ("max_depth", "4"),
        ("first_sample", "8"),
        ("end_sample", "32"),
        ("rejected_samples", "0"),
        ("scene", "../scenes/sphere.ron"),
        ("version", env!("CARGO_PKG_VERSION")),
        ("device", json["device"].as_str().unwrap()),
        ("driver", json["driver"].as_str().unwrap()),
    ] {
        assert_eq!(attribute(&image, &format!("gpu-rt:{name}")), value, "{name}");
    }
    let command_words = attribute(&image, "gpu-rt:command");
    assert!(command_words.starts_with("gpu-rt render ../scenes/sphere.ron"), "{command_words}");
    assert!(command_words.contains(" --json --seed 77 --samples 8..32 --max-depth 4"), "{command_words}");
    let camera: Value = serde_json::from_str(attribute(&image, "gpu-rt:camera")).expect("JSON");
    assert_eq!((&camera["up"], &camera["aperture"]), (&serde_json::json!([0.0, 1.0, 0.0]), &serde_json::json!(0.0)));
    assert!(camera["look_from"].is_array() && camera["vertical_fov"].is_number(), "{camera}");
    assert_eq!(json["camera"], camera);
    for name in ["seconds_load", "seconds_compile", "seconds_render"] {
        assert!(number(&image, name) >= 0.0, "{name}");
    }
    // The file is written before these are known.
    for name in ["seconds_write", "seconds_total", "seconds_first_pass"] {
        assert!(image.attributes.iter().all(|(known, _)| *known != format!("gpu-rt:{name}")), "{name}");
    }
    // The error with its bound, how sure that is, what it is not about, and how much of that is known.
    for name in ["relative_error", "relative_error_bound", "relative_error_confidence", "cut_paths", "cut_throughput"] {
        let (in_file, in_json) = (number(&image, name), &json[name]);
        let is_same = in_json.as_f64().is_some_and(|value| (in_file - value).abs() <= 1e-9 * value);
        assert!(is_same, "{name}: {in_file}, {in_json}");
    }
    assert_eq!(attribute(&image, "gpu-rt:relative_error_excludes"), json["relative_error_excludes"]);
    assert_eq!(json["relative_error_confidence"], 0.95);
    assert_eq!(attribute(&image, "gpu-rt:reliable") == "1", json["reliable"] == true);
    let cut = |depth: &str| {
        sandbox.render(&["-o", "cut.exr", "--max-depth", depth]).exits(0);
        number(&sandbox.exr("cut.exr"), "cut_paths")
    };
    assert!(cut("0") > 0.0 && cut("50") < cut("0"), "{} and {}", cut("0"), cut("50"));
    // The first part has R, G and B as 32-bit floats; what else there is has names of its own.
    let meta = exr::meta::MetaData::read_from_file(sandbox.at("sphere.exr"), false).expect("an EXR");
    let channels = &meta.headers[0].channels.list;
    for name in ["R", "G", "B"] {
        let channel = channels.iter().find(|channel| channel.name.to_string() == name).expect(name);
        assert_eq!(channel.sample_type, exr::meta::attribute::SampleType::F32);
    }
    let others = channels.iter().filter(|channel| !["R", "G", "B"].contains(&channel.name.to_string().as_str()));
    assert!(others.clone().count() >= 3 && others.into_iter().all(|channel| channel.name.to_string().contains('.')));
    // Row 0 is on top: the sky is bluer there.
    let red = |y: usize| image.rgb[y * 20][0];
    assert!(red(0) < red(11), "{} {}", red(0), red(11));
}

#[test]
fn noise_ends_where_the_error_is_reached_and_says_so() {
    let sandbox = Sandbox::new();
    let ran = sandbox.render(&["--noise", "0.02", "--json", "-o", "a.exr"]).exits(0);
    let (json, image) = (ran.json(), sandbox.exr("a.exr"));
    let samples = json["samples_per_pixel"].as_u64().expect("a number");
    // It checks at each quarter of a doubling, at ends of runs.
    assert!(samples.is_multiple_of((samples.next_power_of_two() / 8).max(16)), "{samples}");
    assert_eq!((json["noise_reached"].as_bool(), attribute(&image, "gpu-rt:noise_reached")), (Some(true), "1"));
    assert!(json["relative_error_bound"].as_f64().expect("a number") < 0.02);
    for name in ["relative_error", "relative_error_bound"] {
        assert!((number(&image, name) / json[name].as_f64().expect("a number") - 1.0).abs() < 1e-6, "{name}");
    }
    assert_eq!(attribute(&image, "gpu-rt:reliable") == "1", json["reliable"] == true);
    assert!(ran.stderr.contains("--noise 0.02 was reached"), "{}", ran.stderr);
    // It is the image of so many samples.
    sandbox.render(&["--spp", &samples.to_string(), "-o", "b.exr"]).exits(0);
    assert!(sandbox.exr("b.exr").rgb == image.rgb && sandbox.exr("b.exr").variance == image.variance);
    // --spp and --time end it before.
    let ran = sandbox.render(&["--noise", "0.0001", "--spp", "24", "-o", "c.exr"]).exits(0);
    ran.on_stderr(&["was not reached", "c.exr: 24 samples"]);
    sandbox.render(&["--noise", "0.000001", "--time", "0.5s", "-o", "d.exr"]).exits(0).on_stderr(&["was not reached"]);
    for nonsense in ["0", "-0.01", "nan", "inf", "2", "1e-9", "1%", ""] {
        let ran = sandbox.render(&[&format!("--noise={nonsense}"), "-o", "e.exr"]).exits(2);
        assert!(ran.stderr.contains("noise"), "{nonsense}: {}", ran.stderr);
    }
    sandbox.render(&["--noise", "0.1", "--samples", "0..16", "-o", "e.exr"]).exits(2);
    assert!(!sandbox.at("e.exr").exists());
}

#[test]
fn options_override_the_scene() {
    let sandbox = Sandbox::new();
    let rgb = |more: &[&str]| {
        sandbox.render(&[more, &["-o", "a.exr"]].concat()).exits(0);
        sandbox.exr("a.exr")
    };
    let usual = rgb(&[]);
    assert!(rgb(&["--spp", "16", "--seed", "0", "--size", "20x12", "--max-depth", "7"]).rgb == usual.rgb);
    assert!(rgb(&["--samples", "0..16"]).rgb == usual.rgb);
    assert!(rgb(&["--integrator", "bsdf", "--sampler", "sobol"]).rgb == usual.rgb);
    assert!(rgb(&["--slots", "33", "--workgroup", "8", "--bounces", "3", "--scatter", "queues"]).rgb == usual.rgb);
    assert!(rgb(&["--sampler", "independent"]).rgb != usual.rgb);
    assert!(rgb(&["--seed", "1"]).rgb != usual.rgb);
    assert!(rgb(&["--samples", "16..32"]).rgb != usual.rgb);
    assert!(rgb(&["--max-depth", "0"]).rgb != usual.rgb);
    let small = rgb(&["--size", "7x3", "--spp", "9"]);
    assert_eq!((small.width, small.height, small.samples), (7, 3, Some(vec![9; 21])));
    let half = rgb(&["--size", "50%", "--spp", "9"]);
    assert_eq!((half.width, half.height), (10, 6));
    let least = rgb(&["--size", "0.1%", "--spp", "9"]);
    assert_eq!((least.width, least.height), (1, 1));
    assert!(rgb(&["--size", "100%"]).rgb == usual.rgb);
    assert_eq!(rgb(&["--samples", "3..30"]).samples, Some(vec![27; 240]));
}

#[test]
fn a_time_limit_gives_every_pixel_the_same_samples_and_one_at_least() {
    let sandbox = Sandbox::new();
    for time in ["1s", "1ms", "0.3"] {
        let json = sandbox.render(&["--time", time, "--json", "--force", "-o", "a.exr"]).exits(0).json();
        let samples = sandbox.exr("a.exr").samples.expect("a layer of samples");
        assert!(samples[0] >= 1 && samples.iter().all(|&n| n == samples[0]), "{time}: {samples:?}");
        assert_eq!(json["samples_per_pixel"], samples[0], "{time}");
    }
    // Less than a start takes: that it took longer is said, and by how much. An hour is not overrun.
    let ran = sandbox.render(&["--time", "1ms", "--json", "--force", "-o", "a.exr"]).exits(0);
    let (json, over) = (ran.json(), &ran.json()["time_overrun_seconds"]);
    let (total, over) = (json["seconds"]["total"].as_f64().expect("a time"), over.as_f64().expect("an overrun"));
    assert!((total - 0.001 - over).abs() < 1e-9, "{total}, {over}");
    assert!(ran.stderr.contains("longer than --time 0.001 s"), "{}", ran.stderr);
    // Kept where there is time, and nothing is said then: in one of five, as the other tests take what they take of the processor, and what
    // they begin after the pilot has seen how fast it goes makes it late.
    let is_kept = |_| {
        let json = sandbox.render(&["--time", "2s", "--json", "--force", "-o", "a.exr"]).exits(0).json();
        let total = json["seconds"]["total"].as_f64().expect("a time");
        assert_eq!(json["time_overrun_seconds"].is_null(), total <= 2.0, "{json}");
        total <= 2.0
    };
    assert!((0..5).any(is_kept));
    // Up to --spp, with however much time.
    let json = sandbox.render(&["--time", "1h", "--spp", "24", "--json"]).exits(0).json();
    assert_eq!(json["samples_per_pixel"], 24);
}

/// More coincident faces than a walk may take steps, on any driver: every sample whose ray gets there is cut short, and no other.
#[test]
fn rejected_samples_are_reported_and_strict_fails() {
    const TOGETHER: usize = 600;
    let sandbox = Sandbox::new();
    let face = "3 0 1 2\n".repeat(TOGETHER);
    let mesh = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face {TOGETHER}\n\
         property list uchar int vertex_indices\nend_header\n-1 -1 0\n9 -1 0\n-1 9 0\n{face}"
    );
    sandbox.scene("faces.ply", &mesh);
    let objects = "Mesh(path: \"faces.ply\", material: \"grey\"),".repeat(TOGETHER);
    let scene = sandbox.scene(
        "many.ron",
        &format!(
            "Scene(image: (width: 4, height: 2),
             camera: (look_from: (-1, 0, 3), look_at: (-1, 0, 0), vertical_fov: 20),
             background: Solid((0.5, 0.5, 0.5)),
             materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3)) }}, objects: [{objects}],
             render: (samples: 8, max_depth: 2))"
        ),
    );
    let render = ["render", &scene, "--device", software(), "-o", "a.exr"];
    sandbox.render(&["--strict"]).exits(0);
    // Half of the 8 pixels, with 8 samples each.
    let words = "32 of 64 samples were rejected: 0 were not a number, 0 infinite, 32 cut short";
    let ran = sandbox.run(&[&render[..], &["--json"]].concat()).exits(0);
    assert!(ran.stderr.contains(words), "{}", ran.stderr);
    assert_eq!(ran.json()["rejected_samples"], 32);
    let ran = sandbox.run(&[&render[..], &["--strict", "--json", "--quiet"]].concat()).exits(1);
    assert_eq!(ran.json()["rejected_samples"], 32, "the report comes all the same");
    assert!(ran.last_line().contains("--strict") && ran.last_line().contains(words), "{}", ran.stderr);
    // Where nothing is left, that is a failure.
    let all = std::fs::read_to_string(sandbox.at(&scene)).expect("it is there").replace("(-1, 0,", "(0.5, 0,");
    let all = sandbox.scene("all.ron", &all);
    let ran = sandbox.run(&["render", &all, "--device", software(), "-o", "all.exr"]).exits(1);
    ran.on_stderr(&["64 of 64 samples were rejected"]);
    // And so does the image, with the rejected samples of each pixel.
    let image = sandbox.exr("a.exr");
    assert_eq!(image.rejected, Some([0, 0, 8, 8].repeat(2)));
    assert_eq!(image.samples, Some([8, 8, 0, 0].repeat(2)));
    assert_eq!(attribute(&image, "gpu-rt:rejected_cut"), "32");
    assert_eq!([image.rgb[0], image.rgb[3]], [[0.5; 3], [0.0; 3]]);
}

/// Any sizes that the command line takes make the same image, or are refused before anything is rendered.
#[test]
fn many_slots_and_small_workgroups_render_or_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.render(&["-o", "usual.exr"]).exits(0);
    // More workgroups than the 65 535 that a dispatch may have along one axis (WebGPU's maxComputeWorkgroupsPerDimension).
    let ran = sandbox.render(&["-o", "a.exr", "--slots", "70000", "--workgroup", "1"]);
    match ran.code() {
        2 => assert_eq!(sandbox.files(), ["usual.exr"]),
        _ => {
            ran.exits(0);
            assert!(sandbox.exr("a.exr").rgb == sandbox.exr("usual.exr").rgb);
        }
    }
}

// Bad input

/// Scenes with one error each, at the mark, and a word of the message.
fn bad_scenes() -> Vec<(String, &'static str)> {
    let bad = |good: &str, bad: &str, word| (SPHERE.replacen(good, bad, 1), word);
    vec![
        ("§".to_owned(), "empty"),
        bad("width: 20", "width: §0", "width"),
        bad("vertical_fov: 50", "vertical_fov: §180", "vertical_fov"),
        bad("radius: 1", "radius: §-1", "radius"),
        bad("material: \"grey\"", "material: §\"gray\"", "grey"),
        bad("max_depth: 7", "§max_dept: 7", "max_depth"),
    ]
}

#[test]
fn bad_scenes_are_refused_with_file_line_and_column() {
    let sandbox = Sandbox::new();
    fs::write(sandbox.at("old.exr"), "old").unwrap();
    for (text, word) in bad_scenes() {
        let scene = sandbox.scene("bad.ron", &unmarked(&text));
        let (line, column) = marked::line_and_column(&text);
        let at = format!("{scene}:{line}:{column}: ");
        let commands: [&[&str]; 3] = [
            &["render", &scene, "-o", "old.exr", "--png", "old.png"],
            &["check", &scene],
            &["plan", &scene, "--wgsl", "shaders"],
        ];
        for command in commands {
            let ran = sandbox.run(command).exits(2);
            assert_eq!(ran.stdout, "");
            assert!(ran.stderr.starts_with(&format!("error: {at}")), "{command:?}: {}, expected {at}", ran.stderr);
            assert!(ran.stderr.contains(word), "{command:?}: {}, expected {word}", ran.stderr);
            // Nothing is written, and what was there stays.
            assert_eq!(sandbox.files(), ["old.exr"]);
            assert_eq!(fs::read_to_string(sandbox.at("old.exr")).unwrap(), "old");
        }
    }
    sandbox.says("render missing.ron").exits(2).says_last("error: missing.ron: Scene: cannot read");
    let lost = SPHERE.replace("Rgb(0.5, 0.4, 0.3)", "Image(path: \"lost.png\")");
    let scene = sandbox.scene("bad.ron", &lost);
    sandbox.run(&["render", &scene]).exits(2).on_stderr(&[&format!("{scene}:5:"), "lost.png"]);
    assert_eq!(sandbox.files(), ["old.exr"]);
}

#[test]
fn bad_arguments_are_refused() {
    let sandbox = Sandbox::new();
    let values: &[(&str, &[&str])] = &[
        ("--spp", &["0", "-1", "many"]),
        ("--samples", &["5..5", "8..4", "8", "0..9999999999"]),
        ("--time", &["0", "-3", "soon"]),
        ("--size", &["0x5", "5x", "0", "99999x2", "65536x65536", "0%", "101%", "nan%"]),
        ("--clamp", &["0", "nan", "inf"]),
        ("--clamp=-1", &[""]),
        ("--fresnel", &["cubic"]),
        ("--max-depth", &["-1"]),
        ("--seed", &["4294967296"]),
        ("--exposure", &["nan"]),
        ("--checkpoint", &["0s"]),
        ("--device", &["999", "nonexistent"]),
        ("--slots", &["0"]),
        ("--workgroup", &["0"]),
        ("--bounces", &["0"]),
        ("--scatter", &["wildly"]),
        ("--unknown", &[""]),
        ("-o", &[""]),
    ];
    let of_render = |(option, values): &(&str, &[&str])| -> Vec<String> {
        values.iter().map(|value| format!("render SCENE {option} {value}")).collect()
    };
    // What the contract lists and is not built yet is refused, never ignored: the last two.
    let others = "|paint|render|render SCENE SCENE|plan|plan SCENE --device 999|plan SCENE --size 0x0|check|check SCENE --spp 4|devices 2|compare|\
                  compare a.exr|compare a.exr b.exr c.exr|compare a.exr b.exr|render SCENE --resume|merge a.exr b.exr -o c.exr";
    let lines = values.iter().flat_map(of_render).chain(others.split('|').map(str::to_string));
    for line in lines {
        let ran = sandbox.says(&line.replace("SCENE", "../scenes/sphere.ron")).exits(2);
        assert!(!ran.stderr.is_empty() && ran.stdout.is_empty(), "{line}: {ran:?}");
        assert!(sandbox.files().is_empty(), "{line}: {:?}", sandbox.files());
    }
}

#[test]
fn converge_measures_the_images_that_render_writes() {
    let sandbox = Sandbox::new();
    sandbox.render(&["--spp", "512", "--seed", "7", "-o", "reference.exr"]).exits(0);
    sandbox.render(&["--spp", "24", "-o", "last.exr"]).exits(0);
    let sphere = sandbox.render_sphere();
    let converge = [&["converge"], &sphere[1..], &["--reference", "reference.exr"]].concat();
    let ran = sandbox.run(&[&converge[..], &["--spp", "24", "-o", "plots"]].concat()).exits(0);
    let csv = fs::read_to_string(sandbox.at("plots/sphere-converge.csv")).expect("the table is there");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let columns = "samples,seconds,mse,rmse,relative_mse,relmse,mean_difference,relative_error,relative_error_bound,reliable,reference_reliable";
    assert_eq!(csv.lines().next(), Some(columns));
    let samples: Vec<&str> = rows[1..].iter().map(|row| row[0]).collect();
    assert_eq!(samples, ["1", "2", "4", "8", "16", "24"]);
    // A line on the terminal for each, below their names.
    assert_eq!(ran.stdout.lines().count(), rows.len(), "{}", ran.stdout);
    assert!(fs::read_to_string(sandbox.at("plots/sphere-converge.svg")).unwrap().contains("<svg"));

    // The error falls, time passes, and the last image is, but for where its sums were cut, that of `render`.
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().expect("a number");
    assert!(rows[1..].windows(2).all(|two| number(&two[0], 1) < number(&two[1], 1)), "{csv}");
    assert!(number(&rows[6], 4) < 0.2 * number(&rows[1], 4), "{csv}");
    let (last, reference) = (sandbox.exr("last.exr"), sandbox.exr("reference.exr"));
    use gpu_rt::metrics::error::{relative_mse, relmse};
    let relative = relative_mse(&last.rgb, &reference.rgb).expect("of one size");
    for (column, error) in [(4, relative), (5, relmse(&last.rgb, &reference.rgb).expect("of one size"))] {
        assert!((number(&rows[6], column) / error - 1.0).abs() < 1e-5, "{csv}: {error}");
    }
    let json = sandbox.run(&[&converge[..], &["--spp", "24", "--json"]].concat()).exits(0).json();
    assert_eq!(json["steps"].as_array().map(Vec::len), Some(6));
    assert!(json["relative_mse_of_reference"].as_f64().is_some_and(|own| own > 0.0 && own < relative), "{json}");
    // Its own noise would not be found.
    assert!(!ran.stderr.contains("give another --seed"), "{}", ran.stderr);
    let ran = sandbox.run(&[&converge[..], &["--spp", "1", "--seed", "7"]].concat()).exits(0);
    ran.on_stderr(&["reference.exr was also rendered with seed 7"]);
    // Other light is found: the same at half the albedo.
    let darker = sandbox.scene("darker.ron", &SPHERE.replace("0.5, 0.4, 0.3", "0.25, 0.2, 0.15"));
    let found = sandbox.run(&["converge", &darker, "--device", software(), "--reference", "reference.exr", "--json"]);
    let found = found.exits(0).json();
    assert!(found["steps"][4]["mean_difference"].as_f64().is_some_and(|off| off < -0.05), "{found}");

    for (reference, words) in [("none.exr", "none.exr: cannot read"), ("../scenes/sphere.ron", "cannot read")] {
        sandbox.run(&[&["converge"], &sphere[1..], &["--reference", reference]].concat()).exits(2).on_stderr(&[words]);
    }
}

// compare

/// Renders a.exr and b.exr of two seeds, and brighter.exr and local.exr, which are b with 2 % more light, or 30 % more in a corner.
fn rendered_pair(sandbox: &Sandbox) {
    for (name, seed) in [("a.exr", "1"), ("b.exr", "2")] {
        sandbox.render(&["--size", "48x32", "--seed", seed, "-o", name, "--quiet"]).exits(0);
    }
    let write = |name: &str, change: &dyn Fn(usize) -> f32| {
        let image = sandbox.exr("b.exr");
        let scaled = |(i, rgb): (usize, &[f32; 3])| rgb.map(|v| v * change(i));
        let picture = gpu_rt::film::Picture {
            width: image.width,
            height: image.height,
            rgb: image.rgb.iter().enumerate().map(scaled).collect(),
            variance: image.variance.expect("variances"),
            samples: image.samples.expect("samples"),
            rejected: image.rejected.expect("rejected samples"),
        };
        gpu_rt::output::exr::write_exr(&sandbox.at(name), &picture, &[]).expect("it is written");
    };
    write("brighter.exr", &|_| 1.02);
    write("local.exr", &|i| if i % 48 < 6 && i / 48 < 5 { 1.3 } else { 1.0 });
    write("pixel.exr", &|i| if i == 9 * 48 + 7 { 100.0 } else { 1.0 });
}

/// A lamp that no path meets makes no noise: with BSDF sampling alone the stated error does not know of it, and says so.
#[test]
fn a_lamp_that_no_path_meets_makes_the_error_unreliable() {
    let sandbox = Sandbox::new();
    sandbox.scene("bright.ron", &under_a_small_lamp("1e6, 1e6, 1e6"));
    sandbox.scene("faint.ron", &under_a_small_lamp("1, 1, 1"));
    for (scene, integrator, reliable) in
        [("bright", "bsdf", false), ("bright", "mis", true), ("faint", "bsdf", true), ("faint", "mis", true)]
    {
        let line =
            format!("render ../scenes/{scene}.ron --integrator {integrator} --device {} -o {scene}.exr", software());
        for more in ["", "--spp 128 --resume"] {
            let ran = sandbox.says(&format!("{line} --json {more}")).exits(0);
            assert_eq!(ran.json()["reliable"], reliable, "{scene}, {integrator}: {}", ran.stderr);
            assert_eq!(ran.stderr.contains("BSDF sampling alone finds some of the light"), !reliable, "{}", ran.stderr);
        }
        // A joined image has the same verdict.
        let joined = sandbox.says(&format!("merge {scene}.exr -o joined.exr --json")).exits(0).json();
        assert_eq!(joined["reliable"], reliable, "{joined}");
    }
}

fn under_a_small_lamp(emit: &str) -> String {
    format!(
        "(image: (width: 64, height: 48), render: (samples: 64, max_depth: 8),
          camera: (look_from: (0, 2, 5), look_at: (0, 0, 0), vertical_fov: 40), background: Solid((0.2, 0.2, 0.2)),
          materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"lamp\": DiffuseLight(emit: Rgb({emit})) }},
          objects: [
              Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"grey\"),
              Sphere(center: (0, 3, 0), radius: 0.001, material: \"lamp\"),
          ])"
    )
}

/// Images that lack the light of a lamp, as `--integrator bsdf` makes them, and images of light sampling, which have it. The latter are the
/// control: of them no command says that they are unreliable.
#[test]
fn commands_that_read_an_image_say_that_its_error_is_unreliable() {
    let sandbox = Sandbox::new();
    sandbox.scene("lamp.ron", &under_a_small_lamp("1e6, 1e6, 1e6"));
    for (name, integrator, seed) in [("dark", "bsdf", 1), ("dark2", "bsdf", 2), ("lit", "mis", 1), ("lit2", "mis", 2)] {
        let line = format!("render ../scenes/lamp.ron --integrator {integrator} --seed {seed} -o {name}.exr --device");
        sandbox.says(&format!("{line} {}", software())).exits(0);
    }
    for (a, b, words) in [
        ("dark", "dark2", "Both headers call their errors unreliable"),
        ("dark", "lit", "A's header calls its error unreliable"),
        ("lit", "dark", "B's header calls its error unreliable"),
        ("lit", "lit2", ""),
    ] {
        let ran = sandbox.says(&format!("compare {a}.exr {b}.exr")).exits(0);
        let verdict = ran.stdout.lines().last().expect("it has a verdict");
        assert!(["noise only", "brighter", "darker"].iter().any(|known| verdict.contains(known)), "{verdict}");
        assert!(verdict.contains(words) && verdict.contains("unreliable") != words.is_empty(), "{verdict}");
        let json = sandbox.says(&format!("compare {a}.exr {b}.exr --json")).exits(0).json();
        assert_eq!(json["verdict"], verdict);
        let reliable = [a, b].map(|name| name.starts_with("lit"));
        assert_eq!((&json["image_reliable"], &json["reference_reliable"]), (&reliable[0].into(), &reliable[1].into()));
    }
    // The stated error is not that of another layer.
    let layer = sandbox.says("compare dark.exr dark2.exr --layer variance --json").exits(0).json();
    assert!(layer["image_reliable"].is_null() && !layer["verdict"].as_str().unwrap().contains("unreliable"), "{layer}");

    for (integrator, reference, reliable) in [("bsdf", "lit", [false, true]), ("mis", "dark", [true, false])] {
        let line =
            format!("converge ../scenes/lamp.ron --integrator {integrator} --reference {reference}.exr --seed 9");
        let line = format!("{line} --spp 64 --device {}", software());
        let ran = sandbox.says(&format!("{line} --json")).exits(0);
        let json = ran.json();
        assert_eq!(json["reference_reliable"], reliable[1], "{json}");
        // Up to eight samples the error is not known.
        let steps: Vec<_> = json["steps"].as_array().unwrap().iter().map(|step| &step["reliable"]).collect();
        assert!(steps[..4].iter().all(|known| known.is_null()), "{json}");
        assert!(steps.len() == 7 && steps[4..].iter().all(|known| **known == reliable[0]), "{json}");
        let csv = fs::read_to_string(sandbox.at("lamp-converge.csv")).expect("the table is there");
        let cells = format!(",{},{}", reliable[0], reliable[1]);
        assert!(csv.lines().skip(5).all(|row| row.ends_with(&cells)), "{csv}");
        let says = |words: &str| ran.stderr.contains(words);
        let own = "warning: the relative error at 16, 32, 64 samples is unreliable: BSDF sampling alone finds some of the light";
        assert_eq!(says(own), !reliable[0], "{}", ran.stderr);
        assert_eq!(says("warning: the header of dark.exr calls its error unreliable"), !reliable[1], "{}", ran.stderr);
        let table = sandbox.says(&line).exits(0).stdout;
        assert_eq!(table.lines().filter(|line| line.ends_with(" unreliable")).count(), if reliable[0] { 0 } else { 3 });
    }

    #[cfg(unix)]
    for (integrator, reliable) in [("bsdf", false), ("mis", true)] {
        let options = format!("--integrator {integrator} --device {}", software());
        let submit = "submit slurm ../scenes/lamp.ron --spp 16 --parts 1 --dry-run -o";
        sandbox.says(&format!("{submit} {integrator} {options}")).exits(0);
        let part = format!("-o {integrator}/parts/00-16.exr");
        sandbox.says(&format!("render ../scenes/lamp.ron --samples 0..16 {part} {options}")).exits(0);
        let status = sandbox.says(&format!("status {integrator} --error --json")).exits(0);
        assert_eq!(status.json()["reliable"], reliable, "{status:?}");
        assert_eq!(status.stderr.contains("warning: the relative error is unreliable"), !reliable, "{status:?}");
    }
}

/// Images of other scenes are compared, with a warning from their headers.
#[test]
fn images_of_different_scenes_are_warned_of() {
    let sandbox = Sandbox::new();
    let other = sandbox.scene("other.ron", &SPHERE.replace("0.5, 0.4, 0.3", "0.5, 0.4, 0.31"));
    sandbox.render(&["--seed", "1", "-o", "a.exr"]).exits(0);
    sandbox.render(&["--seed", "2", "-o", "b.exr", "--spp", "24"]).exits(0);
    sandbox.run(&["render", &other, "--device", software(), "-o", "c.exr"]).exits(0);
    let said = |line: &str| sandbox.says(line).exits(0).stderr;
    assert_eq!(said("compare a.exr b.exr"), "");
    assert!(said("compare a.exr c.exr").contains("of different scenes"));
    let converge = |reference| {
        format!("converge ../scenes/other.ron --device {} --reference {reference} --spp 2 --seed 9", software())
    };
    assert!(said(&converge("a.exr")).contains("a.exr is of another scene"));
    assert!(!said(&converge("c.exr")).contains("another scene"));
}

#[test]
fn compare_tells_noise_from_differences() {
    let sandbox = Sandbox::new();
    rendered_pair(&sandbox);
    for (image, words) in [
        ("a.exr", "A differs by noise only, p = "),
        ("b.exr", "noise only"),
        ("brighter.exr", "A is brighter by "),
        ("local.exr", "A is brighter by "),
        ("pixel.exr", "A is brighter by 9900 % in pixel (7, 9), and all others are equal"),
    ] {
        let ran = sandbox.says(&format!("compare {image} b.exr")).exits(0);
        let last = ran.stdout.lines().last().expect("a verdict");
        assert!(last.contains(words), "{image}: {}", ran.stdout);
        assert_eq!(ran.stderr, "");
        for name in ["MSE", "RMSE", "relMSE", "PSNR", "FLIP", "mean difference"] {
            assert!(ran.stdout.lines().any(|line| line.starts_with(name)), "{name}: {}", ran.stdout);
        }
        let json = sandbox.says(&format!("compare {image} b.exr --json")).exits(0).json();
        assert_eq!(json["verdict"], last);
        for key in ["mse", "rmse", "relmse", "relmse_trimmed", "flip", "mean_difference", "p"] {
            assert!(json[key].is_number(), "{key}: {json}");
        }
        assert_eq!(json["psnr"].is_number(), image != "b.exr", "{json}");
        assert!(json.get("without_ruling_pixels").is_some_and(Value::is_null), "its noise is even: {json}");
        let [low, high] = [0, 1].map(|end| json["interval"][end].as_f64().expect("a number"));
        let mean = json["mean_difference"].as_f64().expect("a number");
        assert!(low <= mean && mean <= high, "{json}");
    }
    // Said of A, and B is the reference.
    let last = |ran: Ran| ran.stdout.lines().last().unwrap_or_default().to_string();
    let darker = last(sandbox.says("compare b.exr brighter.exr").exits(0));
    assert!(darker.contains("A is darker by ") && !darker.contains("brighter"), "{darker}");
    // Single pixels are tested by the spread of their samples, which the states hold. Noise that hides one is said.
    let noise = |line: &str| sandbox.says(line).exits(0);
    let seen = last(noise("compare a.exr b.exr"));
    let of_one = ["a single wrong pixel is noticed from ", "no single wrong pixel is noticed"];
    assert!(of_one.iter().any(|words| seen.contains(words)), "{seen}");
    let unseen = last(noise("compare pixel.exr a.exr"));
    assert!(unseen.contains("single pixels are not tested") && unseen.ends_with(" % in (7, 9)"), "{unseen}");
    let json = noise("compare a.exr b.exr --json").json();
    assert!(json["single_pixel"]["p"].is_number(), "{json}");
    let json = noise("compare pixel.exr b.exr --json").json();
    let position_of_it = ["x", "y", "pixels_that_differ"].map(|key| json["single_pixel"][key].as_u64());
    assert_eq!(position_of_it, [Some(7), Some(9), Some(1)], "{json}");
    // The location, if there is one.
    let local = last(sandbox.says("compare local.exr b.exr").exits(0));
    assert!(local.contains("around pixel ("), "{local}");
}

/// The errors are those of the formulas, computed here in another way.
#[test]
fn compare_measures_what_it_says() {
    let sandbox = Sandbox::new();
    rendered_pair(&sandbox);
    let json = sandbox.says("compare a.exr b.exr --json").exits(0).json();
    let (a, b) = (sandbox.exr("a.exr"), sandbox.exr("b.exr"));
    let pairs = || a.rgb.as_flattened().iter().zip(b.rgb.as_flattened()).map(|(&a, &b)| (f64::from(a), f64::from(b)));
    let mean =
        |error: &dyn Fn(f64, f64) -> f64| pairs().map(|(a, b)| error(a, b)).sum::<f64>() / pairs().count() as f64;
    let encoded = |v: f64| match v.clamp(0.0, 1.0) {
        v if v <= 0.003_130_8 => 12.92 * v,
        v => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    let luminance = |image: &ExrImage| {
        let of = |rgb: &[f32; 3]| 0.2126 * f64::from(rgb[0]) + 0.7152 * f64::from(rgb[1]) + 0.0722 * f64::from(rgb[2]);
        image.rgb.iter().map(of).sum::<f64>() / image.rgb.len() as f64
    };
    let mse = mean(&|a, b| (a - b).powi(2));
    for (key, expected) in [
        ("mse", mse),
        ("rmse", mse.sqrt()),
        ("relmse", mean(&|a, b| (a - b).powi(2) / (b * b + 0.01))),
        ("psnr", -10.0 * mean(&|a, b| (encoded(a) - encoded(b)).powi(2)).log10()),
        ("mean_difference", luminance(&a) - luminance(&b)),
        ("reference_mean", luminance(&b)),
    ] {
        let found = json[key].as_f64().expect("a number");
        assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-3), "{key}: {found}, expected {expected}");
    }
}

#[test]
fn compare_fails_above_limits_and_draws_a_heatmap() {
    let sandbox = Sandbox::new();
    rendered_pair(&sandbox);
    let compare = |more: &[&str]| sandbox.run(&[&["compare", "a.exr", "b.exr"], more].concat());
    let names = ["mse", "rmse", "relmse", "relmse_trimmed", "flip", "mean_difference"];
    let all: Vec<String> = names.iter().flat_map(|name| ["--fail-above".to_string(), format!("{name}=1e3")]).collect();
    compare(&all.iter().map(String::as_str).collect::<Vec<_>>()).exits(0);
    for name in names {
        let ran = compare(&["--fail-above", "mse=1000", "--fail-above", &format!("{name}=0")]).exits(1);
        // The report comes all the same.
        ran.on_stderr(&[&format!("{name} is "), "above 0"]).on_stdout(&["noise only"]);
    }
    compare(&["--fail-above", "flip=0", "--json"]).exits(1).json();
    for bad in ["psnr=3", "ssim=1", "mse", "mse=", "mse=-1", "mse=nan", "mse=inf", "=1"] {
        compare(&["--fail-above", bad]).exits(2).on_stderr(&["mse"]);
    }
    compare(&["--heatmap", "map.png"]).exits(0);
    let map = image::open(sandbox.at("map.png")).expect("a PNG").into_rgb8();
    assert_eq!(map.dimensions(), (48, 32));
    sandbox.says("compare b.exr b.exr --heatmap black.png").exits(0);
    let black = image::open(sandbox.at("black.png")).expect("a PNG").into_rgb8();
    assert!(black.pixels().all(|pixel| pixel.0 == [0, 0, 0]) || black.pixels().all(|p| p.0[0] < 6 && p.0[2] < 9));
    assert!(map.pixels().any(|pixel| pixel.0 != black.get_pixel(0, 0).0));
    // An image is not overwritten, and what cannot be written is said before the work.
    for map_object in ["a.exr", "./b.exr", "missing/map.png", "."] {
        compare(&["--heatmap", map_object]).exits(2);
    }
    assert_eq!(sandbox.files(), ["a.exr", "b.exr", "black.png", "brighter.exr", "local.exr", "map.png", "pixel.exr"]);
}

/// Files whose headers name other primaries than Rec. 709: the same picture, not another one, and that is said.
#[test]
fn pictures_of_other_primaries_are_converted_and_reported() {
    use exr::image::write::WritableImage;
    use exr::math::Vec2;
    let sandbox = Sandbox::new();
    let mut random = stats::Random(3);
    let noise: Vec<f32> = (0..2 * 32 * 32).map(|_| (1.0 + 0.1 * random.normal()) as f32).collect();
    let write = |name: &str, first: usize, [r, g, b]: [f32; 3], aces: bool| {
        let pixel = |Vec2(x, y): Vec2<usize>| {
            let light = noise[first + 32 * y + x];
            (r * light, g * light, b * light)
        };
        let mut image = exr::image::Image::from_channels((32, 32), exr::image::SpecificChannels::rgb(pixel));
        image.attributes.chromaticities = aces.then_some(exr::meta::attribute::Chromaticities {
            red: Vec2(0.713, 0.293),
            green: Vec2(0.165, 0.83),
            blue: Vec2(0.128, 0.044),
            white: Vec2(0.32168, 0.33767),
        });
        image.write().to_file(sandbox.at(name)).expect("it is written");
    };
    // (0.5, 0.4, 0.3) of Rec. 709 in ACEScg, by the matrix of OpenColorIO's ACES config.
    write("aces.exr", 0, [0.456_57, 0.405_68, 0.315_08], true);
    write("rec709.exr", 32 * 32, [0.5, 0.4, 0.3], false);
    write("unnamed.exr", 0, [0.456_57, 0.405_68, 0.315_08], false);
    let says = "aces.exr: its colours are converted to Rec. 709, from red (0.713, 0.293)";
    sandbox.says("compare aces.exr rec709.exr").exits(0).on_stdout(&["noise only"]).on_stderr(&[says]);
    let unnamed = sandbox.says("compare unnamed.exr rec709.exr").exits(0);
    assert!(!unnamed.stdout.contains("noise only") && unnamed.stderr.is_empty(), "{unnamed:?}");
    sandbox.says("develop aces.exr -o aces.png").exits(0).on_stderr(&["converted to Rec. 709"]);
    write("same.exr", 0, [0.5, 0.4, 0.3], false);
    sandbox.says("develop same.exr -o same.png").exits(0);
    let [aces, same] = ["aces.png", "same.png"].map(|name| image::open(sandbox.at(name)).expect("a PNG").into_rgb8());
    let apart = aces.as_raw().iter().zip(same.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(apart.is_some_and(|apart| apart <= 1), "{apart:?}");
}

/// Files of other renderers, without variances; sizes that differ; files that are none.
#[test]
fn compare_takes_any_exr_and_refuses_the_rest() {
    let sandbox = Sandbox::new();
    let write = |name: &str, width: usize, height: usize, value: &(dyn Fn(usize, usize) -> f32 + Sync)| {
        let rgb = |x, y| (value(x, y), value(x, y), value(x, y));
        exr::prelude::write_rgb_file(sandbox.at(name), width, height, rgb).expect("it is written");
    };
    let mut random = stats::Random(7);
    let noise: Vec<f32> = (0..2 * 64 * 64).map(|_| (1.0 + 0.2 * random.normal()) as f32).collect();
    write("a.exr", 64, 64, &|x, y| noise[y * 64 + x]);
    write("b.exr", 64, 64, &|x, y| noise[(64 + y) * 64 + x]);
    write("dark.exr", 64, 64, &|x, y| 0.95 * noise[y * 64 + x]);
    write("nan.exr", 64, 64, &|x, y| if (x, y) == (5, 6) { f32::NAN } else { noise[y * 64 + x] });
    write("negative.exr", 64, 64, &|x, y| if x == 3 { -0.01 } else { noise[y * 64 + x] });
    write("small.exr", 63, 64, &|_, _| 1.0);
    write("broken.exr", 64, 64, &|_, _| f32::INFINITY);
    let verdict = |a: &str| sandbox.run(&["compare", a, "b.exr"]).exits(0);
    assert!(verdict("a.exr").stdout.contains("noise only") && verdict("a.exr").stdout.contains("paired differences"));
    assert!(verdict("dark.exr").stdout.contains("A is darker by "));
    assert!(verdict("negative.exr").stdout.contains("64 of A, 0 of B"));
    // Pixels that are not finite are left out, and said; no limit lets them pass.
    let words = "1 of 4096 pixels that are NaN or infinite: 1 of A, 0 of B";
    verdict("nan.exr").on_stdout(&[words]).on_stderr(&[words]);
    let json = sandbox.says("compare nan.exr b.exr --json").exits(0).json();
    assert_eq!((&json["pixels"]["compared"], &json["pixels"]["not_finite"]["image"]), (&4095.into(), &1.into()));
    assert!(json["mse"].as_f64().is_some_and(f64::is_finite) && json["flip"].as_f64().is_some_and(f64::is_finite));
    sandbox.says("compare nan.exr b.exr --fail-above mse=9").exits(1).on_stderr(&[words]);
    // What cannot be compared.
    fs::write(sandbox.at("text.exr"), "no EXR").unwrap();
    for (a, b, words) in [
        ("small.exr", "b.exr", "63 x 64"),
        ("broken.exr", "b.exr", "no pixel is finite"),
        ("text.exr", "b.exr", "text.exr"),
        ("a.exr", "missing.exr", "missing.exr"),
        (".", "b.exr", "cannot read"),
    ] {
        sandbox.run(&["compare", a, b]).exits(2).on_stderr(&[words]);
    }
    // Of any size.
    for (width, height) in [(1, 1), (1, 9), (3, 2), (200, 1)] {
        write("one.exr", width, height, &|x, y| noise[y * width + x]);
        write("two.exr", width, height, &|x, y| 1.5 * noise[y * width + x]);
        for other in ["one.exr", "two.exr"] {
            let ran = sandbox.run(&["compare", "one.exr", other, "--heatmap", "map.png"]).exits(0);
            let last = ran.stdout.lines().last().unwrap_or_default();
            assert!(["noise only", "brighter", "darker"].iter().any(|words| last.contains(words)), "{last}");
        }
    }
}

/// (That it changes no image: tests/images/features.rs and trade_offs.rs.)
#[test]
fn all_features_change_the_plan() {
    let sandbox = Sandbox::new();
    let scene = "../scenes/sphere.ron";
    let kernels = |features: &str| sandbox.run(&["plan", scene, "--features", features]).exits(0).stdout;
    assert!(!kernels("scene").contains("--features all"));
    assert!(kernels("all").contains("--features all"));
    assert!(sandbox.run(&["render", scene, "--features", "none"]).exits(2).stderr.contains("scene, all"));
}

// Streams that are closed

#[test]
fn a_closed_stdout_is_no_failure() {
    let sandbox = Sandbox::new();
    // The last one renders.
    for line in
        "plan SCENE|plan SCENE --json|check SCENE|devices|render --help|render SCENE --json --device DEVICE".split('|')
    {
        let line = line.replace("SCENE", "../scenes/sphere.ron").replace("DEVICE", software());
        let mut child = sandbox.command(&words(&line)).spawn().expect("the program starts");
        drop(child.stdout.take());
        finish(child).exits(0);
    }
    assert_eq!(sandbox.files(), ["sphere.exr"]);
}

/// The image is worth more than the messages: `gpu-rt render scene.ron 2>&1 | head -1` renders on.
#[test]
fn a_closed_stderr_is_no_failure() {
    let sandbox = Sandbox::new();
    let mut child = sandbox.command(&sandbox.render_sphere()).spawn().expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(finish(child).code(), 0);
    assert_eq!(sandbox.files(), ["sphere.exr"]);
    // An error that cannot be printed is still an exit status.
    let mut child = sandbox.command(&["render", "missing.ron"]).spawn().expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(finish(child).code(), 2);
}

// check, plan, devices

#[test]
fn check_finds_errors_and_dangers() {
    let sandbox = Sandbox::new();
    let ran = sandbox.says("check ../scenes/sphere.ron").exits(0);
    assert!(ran.stdout.contains("valid") && !ran.stdout.contains("warning:"), "{}", ran.stdout);
    let json = sandbox.says("check ../scenes/sphere.ron --json").exits(0).json();
    assert_eq!(json["valid"], true);
    assert_eq!(json["warnings"].as_array().map(Vec::len), Some(0));
    // An albedo of 1 is dangerous, and said to be, at its location.
    let scene = sandbox.scene("white.ron", &SPHERE.replace("Rgb(0.5, 0.4, 0.3)", "Rgb(1, 1, 1)"));
    sandbox.run(&["check", &scene]).exits(0).on_stdout(&[&format!("warning: {scene}:5:")]);
    let json = sandbox.run(&["check", &scene, "--json"]).exits(0).json();
    assert!(json["warnings"][0].as_str().is_some_and(|warning| warning.starts_with(&format!("{scene}:5:"))), "{json}");
    // All errors are listed, one in a line and in the file's order.
    let scene = sandbox.scene("bad.ron", &SPHERE.replace("width: 20", "width: 0").replace("radius: 1", "radius: 0"));
    let ran = sandbox.run(&["check", &scene]).exits(2);
    let starts: Vec<&str> = ran.stderr.lines().filter_map(|line| line.split(": ").nth(1)).collect();
    assert_eq!(starts, [format!("{scene}:2:20"), format!("{scene}:6:49")], "{}", ran.stderr);
    assert!(ran.stderr.lines().all(|line| line.starts_with("error: ")), "{}", ran.stderr);
    let json = sandbox.run(&["check", &scene, "--json"]).exits(2).json();
    let lines: Vec<_> = json["errors"].as_array().expect("a list").iter().map(|error| error["line"].as_u64()).collect();
    assert_eq!((lines, &json["error"]), (vec![Some(2), Some(6)], &json["errors"][0]));
    // An error is one object too.
    for (text, word) in bad_scenes() {
        let scene = sandbox.scene("bad.ron", &unmarked(&text));
        let (line, column) = marked::line_and_column(&text);
        let json = sandbox.run(&["check", &scene, "--json"]).exits(2).json();
        let error = &json["error"];
        assert_eq!(json["valid"], false);
        assert_eq!((&error["line"], &error["column"]), (&line.into(), &column.into()), "{json}");
        assert!(error["message"].to_string().contains(word) || error["field"].to_string().contains(word), "{json}");
    }
}

/// All that a scene may require, and the same with all features.
const RICH: &str = "Scene(
    image: (width: 20, height: 12),
    camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 50, aperture: 0.1),
    background: Solid((1, 1, 1)),
    materials: {
        \"check\": Lambertian(albedo: Checker(scale: 0.3, even: (0.1, 0.1, 0.1), odd: (0.9, 0.9, 0.9))),
        \"noise\": Metal(albedo: Noise(scale: 2)),
        \"glass\": Dielectric(ior: 1.5),
    },
    objects: [
        Sphere(center: (0, 0, 0), radius: 1, material: \"check\"),
        Quad(corner: (0, 0, -2), u: (1, 0, 0), v: (0, 1, 0), material: \"noise\"),
        Box(min: (-2, -2, -2), max: (-1, -1, -1), material: \"glass\"),
    ],
)
";

#[test]
fn plan_lists_what_the_scene_requires_as_render_does() {
    let sandbox = Sandbox::new();
    let sphere = "../scenes/sphere.ron";
    let device = ["--device", software()];
    let text = sandbox.run(&[["plan", sphere], device].concat()).exits(0).stdout;
    let json = sandbox.run(&["plan", sphere, device[0], device[1], "--json"]).exits(0).json();
    let kernels = json["kernels"].as_array().expect("kernels");
    let names: Vec<&str> = kernels.iter().map(|kernel| kernel["name"].as_str().expect("a name")).collect();
    assert!(names.len() >= 2, "{names:?}");
    let buffers = json["buffers"].as_array().expect("buffers");
    let bytes: u64 = buffers.iter().map(|buffer| buffer["bytes"].as_u64().expect("bytes")).sum();
    assert_eq!(json["gpu_bytes"], bytes);
    for name in names.iter().chain(&["spheres", "film"]) {
        assert!(text.contains(name), "{name} in {text}");
    }
    // The object that requires it.
    assert!(text.contains(&format!("{sphere}:6:15")) && text.contains(&format!("{sphere}:5:")), "{text}");
    // Render agrees.
    let rendered = sandbox.run(&["render", sphere, device[0], device[1], "--json"]).exits(0).json();
    let rendered: Vec<&str> = rendered["kernels"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(rendered, names);
}

/// Where stdout is closed, what goes there is lost, which is found before anything is rendered. /dev/null is no closed stdout, however it is opened.
#[test]
#[cfg(target_os = "linux")]
fn a_closed_descriptor_is_a_failure() {
    let sandbox = Sandbox::new();
    let run = |words: &str, redirection: &str| {
        let line = format!("exec \"$0\" {words} {redirection}");
        let mut shell = std::process::Command::new("sh");
        let program = sandbox.command(&[]).get_program().to_owned();
        shell.current_dir(sandbox.work()).args(["-c", &line]).arg(program).stderr(std::process::Stdio::piped());
        finish(shell.spawn().unwrap())
    };
    let render = sandbox.render_sphere().join(" ");
    for (words, undone) in [
        (format!("{render} --json"), "; nothing has been rendered"),
        (format!("{render} -o -"), "; nothing has been rendered"),
        ("check ../scenes/sphere.ron".to_owned(), ""),
        ("--version".to_owned(), ""),
    ] {
        let ran = run(&words, ">&-").exits(1);
        assert_eq!(ran.last_line(), format!("error: stdout: cannot write: it is closed{undone}"), "{words}");
        assert_eq!(sandbox.files(), Vec::<String>::new(), "{words}");
        for open in [">/dev/null", "1<>/dev/null"] {
            run(&words, open).exits(0);
        }
        let _ = fs::remove_file(sandbox.at("sphere.exr"));
    }
    // What prints nothing loses nothing.
    run(&render, ">&-").exits(0);
}

#[test]
fn plan_writes_shaders_that_naga_takes() {
    let sandbox = Sandbox::new();
    let rich = sandbox.scene("rich.ron", RICH);
    for (scene, scatter) in [("../scenes/sphere.ron", "fused"), (&rich, "fused"), (&rich, "linked"), (&rich, "queues")]
    {
        let folder = tempfile::tempdir().unwrap();
        let into = folder.path().join("new/folder");
        sandbox.run(&["plan", scene, "--scatter", scatter, "--wgsl", into.to_str().unwrap()]).exits(0);
        let kernels = sandbox.run(&["plan", scene, "--scatter", scatter, "--json"]).exits(0).json();
        let kernels = kernels["kernels"].as_array().unwrap().iter();
        let mut names: Vec<&str> = kernels.map(|kernel| kernel["name"].as_str().unwrap()).collect();
        names.sort();
        let shaders = files(&into, "", false);
        assert_eq!(shaders.iter().map(|path| stem(path)).collect::<Vec<_>>(), names);
        for (name, path) in names.into_iter().zip(shaders) {
            let text = fs::read_to_string(path).unwrap();
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(module.entry_points.len(), 1, "{name}");
            let flags = naga::valid::ValidationFlags::all();
            let valid = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty()).validate(&module);
            valid.unwrap_or_else(|error| panic!("{name}: {error:?}"));
        }
    }
}

#[test]
fn paths_that_max_depth_cuts_off_are_said_where_they_are_many() {
    let sandbox = Sandbox::new();
    let corner = "Sphere(center: (0, -101, 0), radius: 100, material: \"grey\"), Sphere(";
    sandbox.scene("corner.ron", &SPHERE.replacen("Sphere(", corner, 1));
    for (depth, is_said) in [("1", true), ("50", false)] {
        let line =
            format!("render ../scenes/corner.ron --max-depth {depth} -o cut.exr --force --device {}", software());
        let ran = sandbox.says(&line).exits(0);
        let words = "% of the paths were cut off at max_depth 1: the image may be too dark";
        assert_eq!(ran.stderr.contains(words), is_said, "{}", ran.stderr);
        assert_eq!(ran.stderr.contains("cut off"), is_said, "{}", ran.stderr);
    }
}

/// What users write first, and the tip that they get.
#[test]
fn command_lines_of_other_programs_get_a_tip() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene("sphere.ron", SPHERE);
    for (words, tip) in [
        (&["render", &scene, "--width", "320"][..], "'--size'"),
        (&["render", &scene, "-s", "100"], "'--spp'"),
        (&["render", &scene, "--gpu", "0"], "'--device'"),
        (&["sphere.ron"], "'gpu-rt render sphere.ron'"),
        (&["sphere.exr"], "'gpu-rt develop sphere.exr -o FILE.png'"),
    ] {
        let ran = sandbox.run(words).exits(2).on_stderr(&[tip]);
        assert!(!ran.stderr.contains("--watch"), "{words:?}: {}", ran.stderr);
    }
    for (file, word) in [("picture.exr", "gpu-rt develop"), ("room.blend", "glTF")] {
        sandbox.run(&["render", file]).exits(2).says_last(&format!("error: {file}: ")).on_stderr(&[word]);
    }
}

#[test]
fn a_width_alone_keeps_the_aspect() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene("sphere.ron", SPHERE);
    let size = |words: &str| {
        let json = sandbox.run(&["render", &scene, "--spp", "1", "--force", "--json", "--size", words]).exits(0).json();
        (json["width"].as_u64(), json["height"].as_u64())
    };
    assert_eq!((size("30"), size("1")), ((Some(30), Some(18)), (Some(1), Some(1))));
    sandbox.run(&["render", &scene, "--size", "0"]).exits(2);
}

/// `-h` is a page of what matters most, and `--help` has all options.
#[test]
fn the_short_help_of_render_is_a_page() {
    let sandbox = Sandbox::new();
    let lists = |text: &str, option: &str| {
        text.lines().any(|line| line.contains(&format!("--{option} ")) || line.contains(&format!("--{option}[")))
    };
    let (short, long) = (sandbox.says("render -h").exits(0).stdout, sandbox.says("render --help").exits(0).stdout);
    assert!(short.lines().count() <= 45, "{}", short.lines().count());
    for option in ["output", "png", "spp", "noise", "time", "size", "device"] {
        assert!(lists(&short, option) && lists(&long, option), "{option}");
    }
    for option in ["light-paths", "checkpoint", "aov"] {
        assert!(!lists(&short, option) && lists(&long, option), "{option}");
    }
    assert!(short.contains("render --help"));
}

#[test]
fn devices_are_listed_with_drivers_limits_and_numerics() {
    let sandbox = Sandbox::new();
    assert!(!sandbox.says("devices").exits(0).stdout.contains("two-sum"), "the findings are for --verbose");
    let text = sandbox.says("devices --verbose").exits(0).stdout;
    let json = sandbox.says("devices --json").exits(0).json();
    let devices = json["devices"].as_array().expect("a list");
    assert!(!devices.is_empty());
    for (index, device) in (0..).zip(devices) {
        let device: &Value = device;
        assert_eq!(device["index"], index);
        for key in ["name", "driver"] {
            let value = device[key].as_str().expect(key);
            assert!(!value.is_empty() && text.contains(value), "{key}: {value} in {text}");
        }
        let limits = device["limits"].as_object().expect("limits");
        assert!(limits.values().all(|limit| limit.as_u64().is_some_and(|limit| limit > 0)));
        assert!(text.contains(&format!("{index}: ")), "{text}");
        let numerics = &device["numerics"];
        assert!(numerics.is_object(), "{device}");
        let found = "two_sum two_sum_barrier two_product_barrier fma_fused contraction nan_compares nan_fails_comparisons nan_by_bits \
                     subnormals words_reach_one uniforms_exact edge_signs";
        for name in found.split(' ') {
            assert!(numerics[name].is_boolean(), "{name}: {numerics}");
        }
        for name in ["loop_iterations", "log_error", "log_relative_error", "sin_error", "sin_error_far"] {
            assert!(numerics[name].is_number(), "{name}: {numerics}");
        }
        assert!(numerics["conversion"].is_string(), "{numerics}");
    }
    assert_eq!(devices.iter().filter(|device| device["default"] == true).count(), 1);
    for words in ["two-sum", "fma", "x != x", "subnormals", "loops", "log", "sin", "u32 to f32", "signs of edges"] {
        let lines = text.lines().filter(|line| line.trim_start().starts_with("numerics: ") && line.contains(words));
        assert_eq!(lines.count(), devices.len(), "{words}: {text}");
    }
}

/// What a render found of its device goes with its image, and is what `devices` says of it.
#[test]
fn a_render_says_what_the_numerics_probe_found() {
    let sandbox = Sandbox::new();
    let report = sandbox.render(&["--json"]).exits(0).json();
    let header: Value = serde_json::from_str(attribute(&sandbox.exr("sphere.exr"), "gpu-rt:numerics")).expect("JSON");
    assert_eq!(report["numerics"], header);
    let listed = sandbox.says("devices --json").exits(0).json();
    let same = |device: &Value| device["driver"] == report["driver"] && device["numerics"] == header;
    assert!(listed["devices"].as_array().expect("a list").iter().any(same), "{listed}\n{header}");
}

/// Without any driver: check and plan work, render and devices say what to install, and nothing panics.
#[cfg(target_os = "linux")]
#[test]
fn without_a_driver_only_rendering_fails() {
    let sandbox = Sandbox::new();
    let run = |arguments: &[&str]| {
        let mut command = sandbox.command(arguments);
        ran(command.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json"))
    };
    run(&["check", "../scenes/sphere.ron"]).exits(0);
    run(&["plan", "../scenes/sphere.ron"]).exits(0);
    for arguments in [["render", "../scenes/sphere.ron"].as_slice(), &["devices"]] {
        run(arguments).exits(1).on_stderr(&["install"]);
    }
    assert!(sandbox.files().is_empty());
}
