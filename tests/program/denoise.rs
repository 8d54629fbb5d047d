//! `gpu-rt denoise`, with the real library: that it removes noise and keeps detail, what its files say, and what it refuses.

use crate::common::oidn;
use crate::common::program::{Ran, ran, words};
use crate::common::stats::Random;
use crate::sandbox::{Sandbox, attribute};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use exr::image::write::WritableImage;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes,
    MetaData, Vec2,
};
use gpu_rt::output::exr::{ExrImage, read_exr};

const WIDTH: usize = 80;
const HEIGHT: usize = 48;

/// A wall of small tiles whose light falls off, without noise: radiance and albedo.
fn wall() -> Vec<([f32; 3], [f32; 3])> {
    let pixel = |i: usize| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let albedo = if (x / 2 + y / 2).is_multiple_of(2) { [0.9, 0.5, 0.2] } else { [0.2, 0.3, 0.4] };
        let light = 0.3 + 5.0 * x as f32 / WIDTH as f32;
        (albedo.map(|a| a * light), albedo)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

type Channels = Vec<(String, Vec<f32>)>;

/// The channels of an image, by the names of their components.
fn channels(names: [&str; 3], image: &[[f32; 3]]) -> Channels {
    (0..3).map(|c| (names[c].to_string(), image.iter().map(|pixel| pixel[c]).collect())).collect()
}

const RGB: [&str; 3] = ["R", "G", "B"];
const ALBEDO: [&str; 3] = ["albedo.R", "albedo.G", "albedo.B"];
const NORMAL: [&str; 3] = ["N.X", "N.Y", "N.Z"];

fn write_at(path: &Path, size: (usize, usize), corner: (i32, i32), display: IntegerBounds, all: Vec<Channels>) {
    let channel = |(name, values): (String, Vec<f32>)| AnyChannel::new(name.as_str(), FlatSamples::F32(values));
    let own = LayerAttributes { layer_position: corner.into(), ..LayerAttributes::default() };
    let list = all.into_iter().flatten().map(channel).collect();
    let layer = Layer::new(size, own, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
    let image = Image { attributes: ImageAttributes::new(display), layer_data: layer };
    image.write().to_file(path).expect("it is written");
}

fn write(path: &Path, size: (usize, usize), all: Vec<Channels>) {
    write_at(path, size, (0, 0), IntegerBounds::from_dimensions(size), all);
}

/// The image with noise of half its values, its albedo and its normal with a little of it.
fn noisy() -> [Vec<[f32; 3]>; 3] {
    let mut random = Random(7);
    let mut around = |value: f32, share: f64| value * (1.0 + share * random.normal()) as f32;
    let wall = wall();
    let rgb = wall.iter().map(|(rgb, _)| rgb.map(|v| around(v, 0.5).max(0.0))).collect();
    let albedo = wall.iter().map(|(_, albedo)| albedo.map(|v| around(v, 0.05))).collect();
    let normal = wall.iter().map(|_| [around(0.1, 1.0), around(0.1, 1.0), around(1.0, 0.05)]).collect();
    [rgb, albedo, normal]
}

/// Mean square error of an image of the wall.
fn error(rgb: &[[f32; 3]]) -> f64 {
    let square =
        |(a, (b, _)): (&[f32; 3], &([f32; 3], [f32; 3]))| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
    rgb.iter().zip(&wall()).map(square).sum::<f64>() / (3 * rgb.len()) as f64
}

/// `gpu-rt denoise` with the real library.
fn denoise(sandbox: &Sandbox, line: &str) -> Ran {
    ran(sandbox.command(&words(&format!("denoise {line}"))).env("OIDN_DIR", oidn::folder()))
}

#[test]
fn noise_goes_and_with_albedo_and_normal_the_detail_stays() {
    let sandbox = Sandbox::new();
    let [rgb, albedo, normal] = noisy();
    let of_rgb = || channels(RGB, &rgb);
    let by_names =
        |albedo_names, normal_names| vec![of_rgb(), channels(albedo_names, &albedo), channels(normal_names, &normal)];
    let blender = ["Denoising Albedo.R", "Denoising Albedo.G", "Denoising Albedo.B"];
    let of_blender = ["Denoising Normal.X", "Denoising Normal.Y", "Denoising Normal.Z"];
    let mut errors = BTreeMap::new();
    for (name, layers, said) in [
        ("plain", vec![of_rgb()], Some("it has no albedo and no normal")),
        ("albedo", vec![of_rgb(), channels(ALBEDO, &albedo)], Some("it has no normal")),
        ("normal", vec![of_rgb(), channels(NORMAL, &normal)], Some("without which the normal is no help")),
        ("both", by_names(ALBEDO, NORMAL), None),
        ("blender", by_names(blender, of_blender), None),
    ] {
        let exr = format!("{name}.exr");
        write(&sandbox.at(&exr), (WIDTH, HEIGHT), layers);
        let before = fs::read(sandbox.at(&exr)).unwrap();
        let ran = denoise(&sandbox, &format!("{exr} -o out.exr --json")).exits(0);
        assert!(fs::read(sandbox.at(&exr)).unwrap() == before, "the raw image has changed");
        let ran = ran.on_stderr(&["warning: denoising biases the result", said.unwrap_or_default()]);
        assert_eq!(ran.stderr.contains("loses more detail"), said.is_some(), "{}", ran.stderr);
        let json = ran.json();
        let layers = match name {
            "both" | "blender" => serde_json::json!(["albedo", "normal"]),
            "albedo" => serde_json::json!(["albedo"]),
            _ => serde_json::json!([]),
        };
        assert_eq!((&json["biases"], &json["layers"]), (&serde_json::json!(["denoise"]), &layers), "{name}");
        let image = sandbox.exr("out.exr");
        assert_eq!(attribute(&image, "gpu-rt:biases"), "denoise");
        let denoiser = json["denoiser"].as_str().expect("a name");
        assert!(denoiser.starts_with("Open Image Denoise 2."), "{denoiser}");
        assert!(attribute(&image, "gpu-rt:denoiser").starts_with(denoiser), "{:?}", image.attributes);
        errors.insert(name, error(&image.rgb));
    }
    let raw = error(&rgb);
    // Tiles of two pixels look like noise of half their values, and the albedo distinguishes them from it.
    assert!(errors["plain"] < raw, "{raw} {errors:?}");
    assert!(errors["albedo"] < 0.3 * errors["plain"] && errors["both"] < 0.8 * errors["albedo"], "{errors:?}");
    assert!(errors["normal"] == errors["plain"] && errors["blender"] == errors["both"], "{errors:?}");
}

/// The headers of a part.
fn header(path: &Path) -> exr::meta::header::Header {
    MetaData::read_from_file(path, true).expect("an EXR").headers[0].clone()
}

#[test]
fn a_denoised_render_keeps_what_is_still_true_of_it_and_is_no_render() {
    let sandbox = Sandbox::new();
    sandbox.render(&["--spp", "16", "--crop", "3,2,11,9", "--clamp", "10", "--noise", "0.9"]).exits(0);
    let raw = sandbox.exr("sphere.exr");
    denoise(&sandbox, "sphere.exr -o out.exr --png out.png").exits(0);
    let out = sandbox.exr("out.exr");
    let meta = MetaData::read_from_file(sandbox.at("out.exr"), true).expect("an EXR");
    assert_eq!(meta.headers.len(), 1);
    let names: Vec<String> = meta.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R"]);
    let [before, after] = ["sphere.exr", "out.exr"].map(|name| header(&sandbox.at(name)));
    assert_eq!(after.data_window(), before.data_window());
    assert_eq!((after.own_attributes.layer_position, after.layer_size), (Vec2(3, 2), Vec2(11, 9)));
    assert_eq!(after.shared_attributes, before.shared_attributes);

    // The settings stay, the error goes.
    let mut expected: BTreeMap<_, _> = raw.attributes.iter().cloned().collect();
    for gone in ["", "_bound", "_confidence", "_excludes"] {
        assert!(expected.remove(&format!("gpu-rt:relative_error{gone}")).is_some(), "{gone}");
    }
    for gone in ["reliable", "noise", "noise_reached"] {
        assert!(expected.remove(&format!("gpu-rt:{gone}")).is_some(), "{gone}");
    }
    assert_eq!(expected.insert("gpu-rt:biases".into(), "--clamp 10, denoise".into()).as_deref(), Some("--clamp 10"));
    let denoiser = attribute(&out, "gpu-rt:denoiser").to_string();
    expected.insert("gpu-rt:denoiser".into(), denoiser);
    assert_eq!(out.attributes.iter().cloned().collect::<BTreeMap<_, _>>(), expected);

    // An image gives one header, byte for byte, and the picture is that of `develop`.
    let bytes = |name: &str| fs::read(sandbox.at(name)).expect("it is read");
    sandbox.says("develop out.exr -o again.png").exits(0);
    assert!(bytes("out.png") == bytes("again.png"));

    // It is not taken for a render.
    let no_state = "it has no state. Images of other programs, of --no-state and of denoise";
    sandbox.says("merge out.exr -o merged.exr").exits(2).on_stderr(&[no_state]);
    let resume = ["--resume", "--spp", "32", "-o", "out.exr"];
    sandbox.render(&resume).exits(2).on_stderr(&["nothing to resume: out.exr has no state"]);
    denoise(&sandbox, "out.exr -o twice.exr").exits(2).on_stderr(&["it is denoised already, by Open Image Denoise 2."]);
    assert!(!sandbox.at("twice.exr").exists());
    for line in ["compare out.exr sphere.exr", "compare sphere.exr out.exr"] {
        sandbox.says(line).exits(0).on_stderr(&["warning: out.exr is denoised (Open Image Denoise 2."]);
    }
    assert!(!sandbox.says("compare sphere.exr sphere.exr").exits(0).stderr.contains("denoised"));
}

/// The image is that of a plain render with the two channels, to the byte but for its command line and its times.
#[test]
fn a_render_denoises_what_it_has_written() {
    let sandbox = Sandbox::new();
    let oidn = oidn::folder();
    let oidn = oidn.to_str().expect("UTF-8");
    let before = sandbox.render(&["-o", "plain.exr", "--aov", "albedo,normal", "--png", "plain.png"]).exits(0);
    assert!(!before.stderr.contains("denois"), "{}", before.stderr);
    let ran = sandbox.render(&["--denoise", "--oidn", oidn, "--png", "a.png", "--json"]).exits(0);
    assert_eq!(
        sandbox.files(),
        ["a.denoised.png", "a.png", "plain.exr", "plain.png", "sphere.denoised.exr", "sphere.exr"]
    );
    let [raw, plain] = ["sphere.exr", "plain.exr"].map(|name| sandbox.exr(name));
    assert_eq!((&raw.rgb, &raw.variance), (&plain.rgb, &plain.variance));
    let [raw, plain] = ["a.png", "plain.png"].map(|name| fs::read(sandbox.at(name)).unwrap());
    assert!(raw == plain, "the picture of the render is not denoised");
    let json = ran.json();
    let denoised = &json["denoised"];
    assert_eq!((&denoised["output"], &denoised["png"]), (&"sphere.denoised.exr".into(), &"a.denoised.png".into()));
    assert_eq!(denoised["layers"], serde_json::json!(["albedo", "normal"]));
    assert_eq!((&denoised["biases"], &json["biases"]), (&serde_json::json!(["denoise"]), &serde_json::json!([])));
    assert!(ran.stderr.contains("warning: denoising biases the result"), "{}", ran.stderr);
    assert!(ran.last_line().starts_with("sphere.exr: 16 samples"), "{}", ran.stderr);
    // What `denoise` makes of the file is the same.
    denoise(&sandbox, "sphere.exr -o again.exr --png again.png").exits(0);
    assert_eq!(sandbox.exr("again.exr"), sandbox.exr("sphere.denoised.exr"));
    assert!(fs::read(sandbox.at("again.png")).unwrap() == fs::read(sandbox.at("a.denoised.png")).unwrap());
    let blender = ["--denoise", "--oidn", oidn, "--aov-names", "blender", "--no-state", "-o", "blender.exr", "--json"];
    let json = sandbox.render(&blender).exits(0).json();
    assert_eq!(json["denoised"]["layers"], serde_json::json!(["albedo", "normal"]));
    assert_eq!(sandbox.exr("blender.denoised.exr").rgb, sandbox.exr("again.exr").rgb);

    // It can be resumed, and only what has come to its end is denoised.
    sandbox.render(&["--denoise", "--oidn", oidn, "--resume", "--spp", "32"]).exits(0);
    assert_eq!(attribute(&sandbox.exr("sphere.exr"), "gpu-rt:samples"), "0..32");
    assert_eq!(attribute(&sandbox.exr("sphere.denoised.exr"), "gpu-rt:samples"), "0..32");

    // What cannot be is refused before rendering.
    let endless = format!("{} --spp {}", sandbox.render_sphere().join(" "), crate::sandbox::ENDLESS);
    let files = sandbox.files();
    for (line, expected, code) in [
        ("--denoise --oidn missing", "missing: neither it", 1),
        ("--denoise -o b.png", "--denoise reads the EXR that the render writes", 2),
        ("--denoise -o -", "--denoise reads the EXR that the render writes", 2),
        ("--denoise -o c.exr --png c.denoised.png --oidn .", "neither it nor its folder", 1),
        ("--denoise --watch", "cannot be used with", 2),
        ("--oidn .", "--denoise", 2),
    ] {
        sandbox.says(&format!("{endless} {line}")).exits(code).on_stderr(&[expected]);
        assert_eq!(sandbox.files(), files, "{line}");
    }
    // The name of the denoised image is taken, by a folder.
    fs::create_dir(sandbox.at("d.denoised.exr")).unwrap();
    let taken = sandbox.says(&format!("{endless} --denoise -o d.exr")).exits(2);
    taken.on_stderr(&["d.denoised.exr: cannot write: it is a folder"]);
}

#[test]
fn denoising_keeps_the_data_and_display_windows() {
    let sandbox = Sandbox::new();
    let image = vec![[0.5, 0.25, 0.125]; 12];
    let display = IntegerBounds { position: Vec2(-2, 30), size: Vec2(50, 20) };
    write_at(&sandbox.at("a.exr"), (4, 3), (-3, 40), display, vec![channels(RGB, &image)]);
    denoise(&sandbox, "a.exr -o b.exr").exits(0);
    let found = header(&sandbox.at("b.exr"));
    assert_eq!(found.data_window(), IntegerBounds { position: Vec2(-3, 40), size: Vec2(4, 3) });
    assert_eq!(found.shared_attributes.display_window, display);
}

fn is_plain(image: &ExrImage) -> bool {
    image.rgb.as_flattened().iter().all(|v| v.is_finite() && *v >= 0.0)
}

#[test]
fn any_values_give_finite_ones_and_the_unit_of_radiance_does_not_matter() {
    let sandbox = Sandbox::new();
    let run = |name: &str, size: (usize, usize), image: &[[f32; 3]], guides: [&[[f32; 3]]; 2]| {
        let all = vec![channels(RGB, image), channels(ALBEDO, guides[0]), channels(NORMAL, guides[1])];
        write(&sandbox.at(name), size, all);
        let ran = denoise(&sandbox, &format!("{name} -o out.exr")).exits(0);
        let out = read_exr(&sandbox.at("out.exr")).expect("it is read");
        assert!(is_plain(&out), "{name}: {:?}", out.rgb);
        (out.rgb, ran.stderr)
    };
    let [rgb, albedo, normal] = noisy();
    let size = (WIDTH, HEIGHT);
    let guides = [albedo.as_slice(), &normal];
    let (usual, said) = run("usual.exr", size, &rgb, guides);
    assert!(!said.contains("NaN") && !said.contains("negative"), "{said}");
    for exponent in [-80, -20, 60] {
        let scale = 2f32.powi(exponent);
        let scaled: Vec<_> = rgb.iter().map(|rgb| rgb.map(|v| v * scale)).collect();
        let (found, _) = run("scaled.exr", size, &scaled, guides);
        let off = |(a, b): (&f32, &f32)| (a / scale - b).abs() > 1e-5 * b.abs().max(1e-3);
        let wrong = found.as_flattened().iter().zip(usual.as_flattened()).filter(|pair| off(*pair)).count();
        assert_eq!(wrong, 0, "2^{exponent}");
    }

    // Values that are none count as black, and are said.
    let mut strange = rgb.clone();
    (strange[70], strange[170]) = ([f32::NAN; 3], [f32::INFINITY, f32::NEG_INFINITY, 0.0]);
    strange[900] = [-1e30, 0.5, 0.5];
    let nothing = vec![[f32::NAN, f32::INFINITY, -f32::MAX]; WIDTH * HEIGHT];
    let (_, said) = run("strange.exr", size, &strange, [&nothing, &nothing]);
    assert!(said.contains("channels of 2 of 3840 pixels are NaN or infinite, and count as 0"), "{said}");
    assert!(said.contains("channels of 1 of 3840 pixels are negative, and count as 0"), "{said}");
    let mut bright = rgb.clone();
    bright[70] = [f32::MAX; 3];
    run("bright.exr", size, &bright, guides);
    run("largest.exr", size, &vec![[f32::MAX; 3]; WIDTH * HEIGHT], guides);
    run("tiny.exr", (1, 1), &[[0.5; 3]], [&[[0.5; 3]], &[[0.0, 0.0, 1.0]]]);
    run("strip.exr", (300, 1), &vec![[0.5; 3]; 300], [&vec![[0.5; 3]; 300], &vec![[0.0, 0.0, 1.0]; 300]]);
    let black = vec![[0.0; 3]; WIDTH * HEIGHT];
    let (found, _) = run("black.exr", size, &black, guides);
    assert!(found.as_flattened().iter().all(|v| *v < 1e-3), "black is not black");
}

#[test]
fn destinations_and_files_that_do_not_fit_are_refused() {
    let sandbox = Sandbox::new();
    write(&sandbox.at("a.exr"), (4, 3), vec![channels(RGB, &[[0.5; 3]; 12])]);
    fs::write(sandbox.at("text.exr"), "no EXR").unwrap();
    fs::hard_link(sandbox.at("a.exr"), sandbox.at("hard.exr")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.exr", sandbox.at("link.exr")).unwrap();
    let files = sandbox.files();
    let mut lines = vec![
        ("a.exr -o a.exr", "it would overwrite the input a.exr"),
        ("a.exr -o ../work/./a.exr", "it would overwrite the input a.exr"),
        ("a.exr -o hard.exr", "it would overwrite the input a.exr"),
        ("a.exr -o b.exr --png hard.exr", "it would overwrite the input a.exr"),
        ("a.exr -o b.png", "this is an EXR: give b.exr"),
        ("a.exr -o -", "standard output gets a PNG"),
        ("a.exr -o b.exr --png - --json", "standard output has the report of --json"),
        ("a.exr -o missing/b.exr", "the folder missing does not exist"),
        ("- -o b.exr", "expected the name of an EXR"),
        ("a.exr", "--output"),
        ("missing.exr -o b.exr", "missing.exr: cannot read"),
        ("text.exr -o b.exr", "text.exr: cannot read"),
    ];
    if cfg!(unix) {
        lines.push(("a.exr -o link.exr", "it would overwrite the input a.exr"));
        lines.push(("link.exr -o a.exr", "it would overwrite the input link.exr"));
    }
    for (line, words) in lines {
        denoise(&sandbox, line).exits(2).on_stderr(&[words]);
    }
    assert_eq!(sandbox.files(), files);
    let png = denoise(&sandbox, "a.exr -o b.exr --png b.png --quiet").exits(0);
    assert_eq!((png.stdout.as_str(), png.stderr.as_str()), ("", ""));
}

/// Without the library it says how to get it; with another one, or a broken one, what is wrong.
#[test]
#[cfg(target_os = "linux")]
fn a_library_that_is_missing_or_fails_is_an_error() {
    let sandbox = Sandbox::new();
    write(&sandbox.at("a.exr"), (4, 3), vec![channels(RGB, &[[0.5; 3]; 12])]);
    for folder in ["empty", "text", "other", "failing/lib"] {
        fs::create_dir_all(sandbox.at(folder)).unwrap();
    }
    let name = "libOpenImageDenoise.so.2";
    fs::write(sandbox.at("text").join(name), "no library\n".repeat(100)).unwrap();
    fs::copy(oidn::folder().join("libtbb.so.12"), sandbox.at("other").join(name)).unwrap();
    oidn::failing(&sandbox.at("failing/lib"));
    let run = |line: &str, folder: &str, fault: &str| {
        let mut command = sandbox.command(&words(&format!("denoise {line}")));
        ran(command.env("OIDN_DIR", folder).env("GPU_RT_DENOISER", fault))
    };
    let files = sandbox.files();
    let how = ["pip install --target oidn pyoidn", "OIDN_DIR", "--oidn oidn/pyoidn/oidn/lib"];
    for (folder, fault, words, says_how) in [
        // As without a variable: the system's own folders, which have none here.
        ("", "", "libOpenImageDenoise.so.2: it cannot be loaded: ", true),
        ("empty", "", "empty: neither it nor its folder lib or bin has libOpenImageDenoise.so.2", true),
        ("missing", "", "missing: neither it", true),
        ("text", "", "text/libOpenImageDenoise.so.2: it cannot be loaded: ", true),
        ("other", "", "it cannot be used as Open Image Denoise 2: it has no function oidnNewDevice", true),
        ("failing", "old", "it has version 1.0.0, expected 2", true),
        ("failing", "new", "it has version 3.0.0, expected 2", true),
        ("failing", "no_device", "it cannot be used as Open Image Denoise 2: unsupported hardware", true),
        ("failing", "memory", "Open Image Denoise 2.0.0 has failed: out of memory", false),
        ("failing", "silent", "Open Image Denoise 2.0.0 has failed: error 1", false),
        ("failing", "nan", "Open Image Denoise 2.0.0 has failed: a pixel of its result is NaN", false),
    ] {
        let option = if folder.is_empty() { String::new() } else { format!("--oidn {folder}") };
        for (line, variable) in [(option.as_str(), "elsewhere"), ("", folder)] {
            if folder.is_empty() && variable == "elsewhere" {
                continue;
            }
            let ran = run(&format!("a.exr -o b.exr {line}"), variable, fault).exits(1);
            let last = ran.last_line();
            assert!(last.starts_with("error: ") && last.contains(words), "{folder} {fault}: {}", ran.stderr);
            assert_eq!(how.iter().all(|words| last.contains(words)), says_how, "{folder} {fault}: {}", ran.stderr);
        }
    }
    assert_eq!(sandbox.files(), files);
    // What fails so is otherwise used.
    run("a.exr -o b.exr", "failing", "").exits(0);
    assert_eq!(sandbox.exr("b.exr").rgb, [[0.5; 3]; 12], "the scale of the radiance is that of the image");
}
