//! The table of trade-offs (src/options.rs): every option of `render` that changes the image is in it, and every value does to the image what
//! its class says. All of it by the program, since a value is a text that the option takes.

use crate::common::{device, program, render};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use crate::common::everything::{Everything, World};
use crate::common::paired::is_as_promised;
use crate::common::render::{Mean, mean_over};
use crate::common::rooms::{THINGS, room_text};
use crate::common::stats::{same_expectation_paired, sidak};
use clap::CommandFactory;
use gpu_rt::commands::Cli;
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::link::{Embedded, Library};
use gpu_rt::options::{Class, Fresnel, OptionSpec, Precision, RenderOptions, TRADE_OFFS};
use gpu_rt::output::exr::{ExrImage, read_exr};
use gpu_rt::plan::{UniformTables, choices_of};
use serde_json::Value;
use tempfile::TempDir;

/// False alarms of a comparison of images.
const ALPHA: f64 = 1e-6;

/// Options of `render` that leave every byte of the image as it is, with a value for those that take one. The device and its driver are
/// what bytes are promised for.
const SAME_IMAGE: &str = "scene; output; png picture.png; device; exposure 2; tonemap filmic; preview; display-server 127.0.0.1:9; \
    checkpoint 1s; aov albedo,normal,depth,position,object,material,direct,indirect,lights; aov-surface first; \
    aov-names blender; watch; denoise; oidn; mixed-drivers; no-state; force; strict; quiet; verbose; json; \
    slots 33; workgroup 8; bounces 3; scatter queues; features all; profile";

fn same_image() -> impl Iterator<Item = (&'static str, Option<&'static str>)> {
    SAME_IMAGE
        .split("; ")
        .map(|option| option.split_once(' ').map_or((option, None), |(name, value)| (name, Some(value))))
}

/// The options that are in every command line here, need a terminal ([`terminal`](../program/terminal.rs) has one) or a library
/// ([`denoise`](../program/denoise.rs)), or do not end ([`watch`](../program/watch.rs) compares their images).
const ELSEWHERE: &[&str] = &["scene", "output", "device", "preview", "watch", "denoise", "oidn"];

/// Options that say which samples there are, and when they are enough. How many there are is the option `spp`.
const WHICH_SAMPLES: &[&str] = &["seed", "samples", "crop", "time", "noise", "resume"];

/// Options that say what a glTF file does not: they are parts of the scene, as the program's tests of [`gltf`](../program/gltf.rs) have it.
const WHICH_SCENE: &[&str] = &["camera", "sky", "sun", "thin", "watts", "frame", "fps", "frames", "define", "lossless"];

// The table and the command line

/// Options of a command that are neither in the table nor known to leave the image as it is.
fn unknown(command: &clap::Command) -> Vec<String> {
    let known = |name: &str| {
        TRADE_OFFS.iter().any(|spec| spec.name == name)
            || same_image().any(|(known, _)| known == name)
            || WHICH_SAMPLES.contains(&name)
            || WHICH_SCENE.contains(&name)
    };
    let names = command.get_arguments().map(|argument| argument.get_long().unwrap_or(argument.get_id().as_str()));
    names.filter(|name| !known(name)).map(str::to_string).collect()
}

fn render_command() -> clap::Command {
    let command = Cli::command();
    command.find_subcommand("render").expect("there is a command render").clone()
}

#[test]
fn every_option_of_render_that_changes_the_image_is_declared() {
    let command = render_command();
    assert_eq!(unknown(&command), Vec::<String>::new());
    // The lists name what is there.
    let there = |name: &str| {
        command.get_arguments().any(|argument| argument.get_long().unwrap_or(argument.get_id().as_str()) == name)
    };
    for name in same_image().map(|(name, _)| name).chain([WHICH_SAMPLES, WHICH_SCENE].concat()) {
        assert!(there(name), "{name} is no option of render");
    }
    // An option that is not in the table is found.
    let planted = command.clone().arg(clap::Arg::new("sharpen").long("sharpen"));
    assert_eq!(unknown(&planted), ["sharpen"]);
}

#[test]
fn the_command_line_says_what_the_table_says() {
    let command = render_command();
    for spec in TRADE_OFFS {
        let argument = command.get_arguments().find(|argument| argument.get_long() == Some(spec.name));
        let argument = argument.unwrap_or_else(|| panic!("--{} is no option of render", spec.name));
        assert_eq!(argument.get_long_help().map(ToString::to_string), Some(spec.help()), "--{}", spec.name);
        assert_eq!(argument.get_help_heading(), Some(spec.class.heading()), "--{}", spec.name);
        let defaults = argument.get_default_values();
        assert_eq!(defaults.first().and_then(|value| value.to_str()), spec.default, "--{}", spec.name);
        // Sentences, and what biases says so.
        for sentence in [spec.about, spec.trade_off] {
            assert!(sentence.ends_with('.') && sentence.len() > 10, "--{}: {sentence}", spec.name);
        }
        assert_eq!(spec.help().contains("biases the result"), spec.class == Class::Bias, "--{}", spec.name);
        assert!(spec.default.is_none_or(|default| spec.values.contains(&default)), "--{}", spec.name);
        for value in spec.values.iter().copied().chain(["what?"]) {
            let line = ["gpu-rt", "render", "a.ron", &format!("--{}", spec.name), value];
            let parsed = Cli::command().try_get_matches_from(line);
            assert_eq!(parsed.is_ok(), value != "what?", "{}", spec.option(value));
        }
    }
    let mut names: Vec<&str> = TRADE_OFFS.iter().map(|spec| spec.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), TRADE_OFFS.len(), "an option is declared twice");
}

/// A requested approximation is linked if the scene has what it applies to, and not otherwise.
#[test]
fn settings_ask_for_nothing_that_the_scene_lacks() {
    let text = |objects: &str| {
        format!(
            "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 50),
                background: Solid((1, 1, 1)),
                materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"glass\": Dielectric(ior: 1.5) }},
                objects: [{objects}], render: (samples: 1))"
        )
    };
    let approximate = RenderOptions {
        fresnel: Fresnel::Schlick,
        clamp: Some(1.0),
        precision: Precision::Fast,
        ..RenderOptions::default()
    };
    let linked = |objects: &str, options: &RenderOptions| {
        let flat = flatten(&render::scene(&text(objects)), (4, 4), options).expect("it flattens");
        let facts = choices_of(&flat.features, options, &UniformTables::default()).facts;
        let linked = [
            ("fresnel", "lib/fresnel_schlick"),
            ("clamp", "step/clamp"),
            ("sphere_chord", "geometry/sphere_chord_fast"),
        ];
        linked.map(|(choice, module)| {
            Embedded.heads().choose(choice, &facts).is_ok_and(|chosen| chosen.module == module && !chosen.is_without)
        })
    };
    let box_of = |material: &str| format!("Box(min: (0, 0, 0), max: (1, 1, 1), material: \"{material}\")");
    let sphere = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")";
    let smoke = "Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1))";
    for (objects, expected) in [
        ("", [false, false, false]),
        (box_of("grey").as_str(), [false, true, false]),
        (box_of("glass").as_str(), [true, true, false]),
        (sphere, [false, true, true]),
        (smoke, [false, true, true]),
    ] {
        assert_eq!(linked(objects, &approximate), expected, "{objects}");
        assert_eq!(linked(objects, &RenderOptions::default()), [false; 3], "{objects}");
    }
}

// The program

struct Sandbox(TempDir);

/// What a render of the program wrote.
struct Rendered {
    image: ExrImage,
    json: Value,
    stderr: String,
}

impl Sandbox {
    fn new() -> Sandbox {
        Sandbox(tempfile::tempdir().expect("a temporary folder"))
    }

    fn scene(&self, text: &str) -> PathBuf {
        let path = self.0.path().join("scene.ron");
        std::fs::write(&path, text).expect("the scene is written");
        path
    }

    /// `gpu-rt render SCENE OPTIONS --json` on the software device.
    fn render(&self, scene: &Path, options: &[&str]) -> Rendered {
        let scene = scene.to_str().expect("UTF-8");
        let usual = ["render", scene, "-o", "out.exr", "--device", device::index()];
        let json: &[&str] = if options.contains(&"--json") { &[] } else { &["--json"] };
        // An image of the same render that has more samples is not overwritten.
        let _ = std::fs::remove_file(self.0.path().join("out.exr"));
        let ran = program::run(self.0.path(), &[&usual, options, json].concat()).exits(0);
        let image = read_exr(&self.0.path().join("out.exr")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(image.rejected.as_ref().map(|rejected| rejected.iter().sum::<u32>()), Some(0), "{options:?}");
        Rendered { image, json: ran.json(), stderr: ran.stderr }
    }
}

fn bits(image: &ExrImage) -> Vec<u32> {
    image.rgb.as_flattened().iter().map(|value| value.to_bits()).collect()
}

/// The means of all of an image, and of `across` by `across` tiles.
fn means(image: &ExrImage, across: u32, degrees_of_pixel: f64) -> Vec<Mean> {
    let variances = image.variance.as_ref().expect("the program writes variances");
    let (width, height) = (image.width, image.height);
    assert!(width.is_multiple_of(across) && height.is_multiple_of(across));
    let tile = (width / across, height / across);
    let mut parts = vec![(0, 0, width, height)];
    parts.extend((0..across * across).map(|i| (i % across * tile.0, i / across * tile.1, tile.0, tile.1)));
    let mean = |(left, top, w, h): (u32, u32, u32, u32)| {
        let pixels = (top..top + h).flat_map(|y| (left..left + w).map(move |x| (y * width + x) as usize));
        mean_over(&image.rgb, variances, pixels, degrees_of_pixel)
    };
    parts.into_iter().map(mean).collect()
}

/// Whether two independent images have one expectation in all their parts; else the worst part. Noise aside they may differ by `rounding` of
/// themselves.
fn same_expectation(a: &[Mean], b: &[Mean], rounding: f64) -> Result<(), String> {
    assert_eq!(a.len(), b.len());
    let threshold = sidak(ALPHA, 3 * a.len());
    let differs = |(a, b): (&Mean, &Mean)| (0..3).any(|channel| a.difference(b, channel, rounding).0 < threshold);
    let part = a.iter().zip(b).position(differs);
    part.map_or(Ok(()), |part| Err(format!("part {part}: {:?}, {:?}", a[part], b[part])))
}

/// Tests whose renders differ by a setting alone.
fn values(class: Class) -> impl Iterator<Item = (&'static OptionSpec, &'static str)> {
    let of_class = TRADE_OFFS.iter().filter(move |spec| spec.class == class);
    of_class
        .flat_map(|spec| spec.values.iter().filter(|value| Some(**value) != spec.default).map(|value| (*spec, *value)))
}

/// The scene with everything in it, its lamp dimmed, for little noise (tests/extremes/positions.rs).
fn dim_everything() -> (Everything, PathBuf) {
    let files = Everything::new();
    let path = files.file(World { lamp: 0.1, ..World::default() });
    (files, path)
}

/// Matt walls, glass, metal and smoke: all that these settings are about, whose kernels compile sooner.
fn smoky_room() -> String {
    room_text(&format!("{} {}", THINGS[1].1, THINGS[2].1))
}

#[test]
fn exact_values_and_undeclared_options_change_no_byte() {
    let sandbox = Sandbox::new();
    let (_files, scene) = dim_everything();
    let usual = sandbox.render(&scene, &[]).image;
    let keeps = |image: &ExrImage, all: bool| {
        let (same, variance) = (bits(image) == bits(&usual), usual.variance.as_ref().expect("variances"));
        same || all && is_as_promised(same, &usual.rgb, variance, &image.rgb)
    };
    for (spec, value) in values(Class::Exact) {
        let found = sandbox.render(&scene, &[&format!("--{}", spec.name), value]).image;
        assert!(keeps(&found, value == "all"), "{}", spec.option(value));
    }
    // All at once, since most of such a render is its start; but for one of two that exclude each other.
    let named = same_image().filter(|(name, _)| !ELSEWHERE.contains(name) && *name != "quiet");
    let options = named.flat_map(|(name, value)| std::iter::once(format!("--{name}")).chain(value.map(String::from)));
    let options: Vec<String> = options.collect();
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    for options in [options.as_slice(), &["--quiet"]] {
        let ran = sandbox.render(&scene, options);
        assert!(keeps(&ran.image, options.len() > 1), "{options:?}");
        assert_eq!(ran.json["features"], if options.len() > 1 { "all" } else { "scene" });
    }
    assert!(!keeps(&sandbox.render(&scene, &["--seed", "1"]).image, true), "another seed");
}

/// What more light is found of the values that change noise and detail, as a share of it.
const FOUND: f64 = 0.026;

/// 1024 pixels of 96 samples, or as many samples of fewer pixels; the other sampler takes more. Of that the mean of the image is known to 0.38 % at
/// worst (printed; for a quarter of the size), and that of the usual image to 0.19 %: 5.6 standard errors of the difference are 2.4 % of
/// the light, and 2.6 % are planted and found. (tests/images/estimators.rs finds 1 % of what the integrator and the roulette do, and 2 % of the
/// sampler.) Fewer samples are tested as precisely as they allow: 64 of a pixel to 2 %, 16 to 4 %, and a single run to the usual image's deviation.
#[test]
fn values_of_noise_change_no_expectation() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(&smoky_room());
    let base = ["--spp", "96", "--size", "32x32"];
    let with = |changed: &[&str], seed: &str| {
        // What is changed replaces what the base says.
        let kept = base.chunks(2).filter(|pair| !changed.contains(&pair[0])).flatten().copied();
        let options: Vec<&str> = kept.chain(changed.iter().copied()).chain(["--seed", seed]).collect();
        sandbox.render(&scene, &options).image
    };
    let usual = means(&with(&["--spp", "192"], "1"), 4, 1.0);
    // All of the size is the usual image, which another seed is compared with in the row of 256 samples.
    let others = values(Class::Noise).chain(values(Class::Detail)).filter(|(_, value)| *value != "100%");
    for (spec, value) in others {
        let option = format!("--{}", spec.name);
        let image = match spec.name {
            // In percent of a scene of this size, with as many samples in all.
            "size" => {
                let share = f64::from(value.trim_end_matches('%').parse::<u32>().expect("percent")) / 100.0;
                let side = (32.0 * share) as u32;
                let samples = (96.0 / (share * share)) as u32;
                with(&[&option, &format!("{side}x{side}"), "--spp", &samples.to_string()], "2")
            }
            "sampler" => with(&[&option, value, "--spp", "192"], "2"),
            _ => with(&[&option, value], "2"),
        };
        let samples = image.samples.as_ref().and_then(|samples| samples.first()).copied().expect("a number");
        let found = match samples <= 8 {
            // One run, or part of one, has no variance of its own: it is that of the usual image, whose points deviate as independent ones do, and
            // only for the full image.
            true => {
                let mut found = means(&image, 4, 1.0);
                for (mean, usual) in found.iter_mut().zip(&usual) {
                    mean.variance = usual.variance.map(|v| v * 192.0 / f64::from(samples));
                    mean.degrees = usual.degrees;
                }
                found.truncate(1);
                found
            }
            false => means(&image, 4, if value == "independent" { 23.0 } else { 1.0 }),
        };
        let usual = &usual[..found.len()];
        println!(
            "{}: the mean is known to {:.5}, the usual one's to {:.5}",
            spec.option(value),
            found[0].variance[0].sqrt() / found[0].value[0],
            usual[0].variance[0].sqrt() / usual[0].value[0]
        );
        same_expectation(usual, &found, 1e-5).unwrap_or_else(|error| panic!("{}: {error}", spec.option(value)));
        if samples >= 96 {
            let brighter = |mean: &Mean| Mean { value: mean.value.map(|v| (1.0 + FOUND) * v), ..*mean };
            let planted: Vec<Mean> = found.iter().map(brighter).collect();
            let found = same_expectation(usual, &planted, 1e-5).is_err();
            assert!(found, "{}: 2.6 % more light is not found", spec.option(value));
        }
    }
}

// Values that bias

/// A ball of glass under a small bright lamp, which is out of view, throws a caustic on the floor of a room that is open to the front.
const CAUSTIC: &str = "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 1.4, 4.5), look_at: (0, 0.4, 0), vertical_fov: 20),
    background: Solid((0.01, 0.01, 0.01)),
    materials: {
        \"wall\": Lambertian(albedo: Rgb(0.9, 0.8, 0.85)),
        \"glass\": Dielectric(ior: 1.5),
        \"lamp\": DiffuseLight(emit: Rgb(1000, 800, 600)),
    },
    objects: [
        Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"wall\"),
        Quad(corner: (-1, 0, -1), u: (2, 0, 0), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (-1, 0, 1), u: (0, 0, -2), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (1, 0, -1), u: (0, 0, 2), v: (0, 2, 0), material: \"wall\"),
        Quad(corner: (-1, 2, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"wall\"),
        Sphere(center: (0, 0.5, 0), radius: 0.4, material: \"glass\"),
        Sphere(center: (0, 1.7, 0), radius: 0.2, material: \"lamp\"),
    ],
    render: (samples: 256, max_depth: 50),
)";

/// Inside a bright sphere with a lamp in it: what comes after k events falls as 0.95^k.
const WHITE: &str = "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 0.9), look_at: (0, 0.5, 0), vertical_fov: 60),
    background: Solid((0, 0, 0)),
    materials: { \"wall\": Lambertian(albedo: Rgb(0.95, 0.95, 0.95)), \"lamp\": DiffuseLight(emit: Rgb(4, 4, 4)) },
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"wall\"), Sphere(center: (0, 0, 0), radius: 0.2, material: \"lamp\")],
    render: (samples: 256, max_depth: 50),
)";

#[test]
fn each_value_that_biases_takes_light_away_where_it_should() {
    let sandbox = Sandbox::new();
    for (name, text, harmless, spp) in
        [("clamp", CAUSTIC, ["--clamp", "1e30"], 256), ("max-depth", WHITE, ["--max-depth", "50"], 64)]
    {
        let scene = sandbox.scene(text);
        let shot = |options: &[&str], seed: &str| {
            let samples = spp.to_string();
            let options = [options, &["--sampler", "independent", "--spp", &samples, "--seed", seed]].concat();
            means(&sandbox.render(&scene, &options).image, 4, f64::from(spp / 8 - 1))
        };
        let usual = shot(&[], "1");
        for (spec, value) in values(Class::Bias).filter(|(spec, _)| spec.name == name) {
            let found = shot(&[&format!("--{name}"), value], "2");
            let darker = same_expectation(&usual, &found, 1e-5).is_err() && found[0].value[0] < usual[0].value[0];
            assert!(darker, "{}: {:?}, {:?}", spec.option(value), found[0], usual[0]);
        }
        // Another seed alone biases nothing, nor does a limit that no path reaches.
        for options in [[].as_slice(), &harmless] {
            same_expectation(&usual, &shot(options, "3"), 1e-5).unwrap_or_else(|error| panic!("{options:?}: {error}"));
        }
    }
    // The others have tests of their own: Fresnel's below.
    let names: std::collections::BTreeSet<&str> = values(Class::Bias).map(|(spec, _)| spec.name).collect();
    assert_eq!(names.into_iter().collect::<Vec<_>>(), ["clamp", "fresnel", "max-depth"]);
}

/// A ball of index 1 bends nothing, and takes two events to pass: the wall of light behind it is indirect light, as much of it as the limit
/// allows, with its hue. Around the ball, and by one event alone, light is direct.
#[test]
fn the_clamp_limits_light_from_the_second_event_on_and_keeps_its_hue() {
    let sandbox = Sandbox::new();
    for (brightness, integrator) in [(1.0, "mis"), (3e20, "mis"), (1e-20, "bsdf")] {
        let [r, g, b] = [8.0, 4.0, 2.0].map(|v: f64| v * brightness);
        let scene = sandbox.scene(&format!(
            "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)),
    materials: {{ \"nothing\": Dielectric(ior: 1), \"wall\": DiffuseLight(emit: Rgb({r:e}, {g:e}, {b:e})) }},
    objects: [
        Sphere(center: (0, 0, 0), radius: 0.8, material: \"nothing\"),
        Quad(corner: (-9, -9, -2), u: (18, 0, 0), v: (0, 18, 0), material: \"wall\"),
    ],
    render: (samples: 16, max_depth: 50),
)"
        ));
        let limit = format!("{:e}", brightness);
        let shot = |options: &[&str]| sandbox.render(&scene, &[options, &["--integrator", integrator]].concat()).image;
        let (usual, clamped) = (shot(&[]), shot(&["--clamp", &limit]));
        let at = |image: &ExrImage, x: u32, y: u32| image.rgb[(y * 32 + x) as usize].map(|v| f64::from(v) / brightness);
        let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-6 * b[i]);
        for (x, y) in [(16, 16), (12, 14), (18, 20)] {
            assert!(near(at(&usual, x, y), [8.0, 4.0, 2.0]), "{:?}", at(&usual, x, y));
            assert!(near(at(&clamped, x, y), [1.0, 0.5, 0.25]), "{:?}", at(&clamped, x, y));
        }
        for (x, y) in [(0, 0), (31, 5), (2, 30)] {
            assert!(near(at(&clamped, x, y), [8.0, 4.0, 2.0]), "direct light: {:?}", at(&clamped, x, y));
        }
        // As large as any contribution is no limit.
        assert!(bits(&shot(&["--clamp", &format!("{:e}", 8.0 * brightness)])) == bits(&usual));
    }
    // All light that comes by one event is direct, sampled or met; that by two is not.
    let scene = sandbox.scene(CAUSTIC);
    for integrator in ["mis", "bsdf"] {
        let shot = |clamp: &str, depth: &str| {
            let options = ["--clamp", clamp, "--max-depth", depth, "--spp", "16", "--integrator", integrator];
            bits(&sandbox.render(&scene, &options).image)
        };
        assert!(shot("1e-3", "1") == shot("off", "1"), "{integrator:?}");
        assert!(shot("1e-3", "2") != shot("off", "2"), "{integrator:?}");
    }
}

/// A sheet of glass before a wall of light, seen at an angle from either of its sides: the camera gets 1 - R of the light.
#[test]
fn reflectances_are_fresnels_or_schlicks() {
    let sandbox = Sandbox::new();
    let exact = |c: f64, eta: f64| {
        let t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
        let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
        0.5 * (s * s + p * p)
    };
    // The cosine is that outside of the denser solid, from whichever side the ray comes.
    let schlick = |c: f64, eta: f64| {
        let t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
        let r0 = ((1.0 - eta) / (1.0 + eta)).powi(2);
        let outer: f64 = if eta >= 1.0 { c } else { t };
        r0 + (1.0 - r0) * (1.0 - outer).powi(5)
    };
    // Angles, indices and sides; the view is narrow, so that the angle is one.
    for (degrees, ior, inside) in
        [(60.0f64, 1.5, false), (35.0, 1.5, true), (75.0, 1.1, false), (50.0, 2.4, false), (20.0, 2.4, true)]
    {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (x, y) = if inside { ("(0, 2, 0)", "(4, 0, 0)") } else { ("(4, 0, 0)", "(0, 2, 0)") };
        // The wall of light takes what is refracted, and what is reflected meets nothing.
        let scene = sandbox.scene(&format!(
            "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: ({}, 0, {}), look_at: (0, 0, 0), vertical_fov: 0.1),
    background: Solid((0, 0, 0)),
    materials: {{ \"glass\": Dielectric(ior: {ior}), \"wall\": DiffuseLight(emit: Rgb(1, 1, 1)) }},
    objects: [
        Quad(corner: (-2, -1, 0), u: {x}, v: {y}, material: \"glass\"),
        Quad(corner: (-500, -500, -1), u: (1000, 0, 0), v: (0, 1000, 0), material: \"wall\"),
    ],
    render: (samples: 256, max_depth: 1),
)",
            10.0 * sin,
            10.0 * cos
        ));
        let eta = if inside { 1.0 / ior } else { ior };
        let through = |setting: &str| {
            let image = sandbox.render(&scene, &["--fresnel", setting, "--sampler", "independent"]).image;
            means(&image, 1, 31.0)[0]
        };
        let (of_exact, of_schlick) = (1.0 - exact(cos, eta), 1.0 - schlick(cos, eta));
        let off = |found: Mean, expected: f64| (found.value[0] - expected).abs() / found.variance[0].sqrt();
        // Over 0.1 degrees R changes linearly but for some 1e-5. 5.5 standard errors happen once in 3e7.
        let (exact, schlick) = (through("exact"), through("schlick"));
        for (found, expected) in [(exact, of_exact), (schlick, of_schlick)] {
            assert!(off(found, expected) < 5.5, "{degrees} degrees, {eta}: {found:?}, expected {expected}");
        }
        // Either would not pass for the other.
        assert!(off(exact, of_schlick) > 8.0 && off(schlick, of_exact) > 8.0, "{degrees} degrees, {eta}");
    }
}

// Values of less precision

/// With the seed of the usual image, so that what both have alike cancels, and a test of the pixels' differences: their mean has a standard error
/// of 0.01 % of the image's. Planted, and found, is a thousandth of the light.
#[test]
fn less_precision_is_right_in_an_ordinary_scene() {
    let sandbox = Sandbox::new();
    let (_files, scene) = dim_everything();
    let shot = |options: &[&str]| {
        let options = [options, &["--spp", "128", "--size", "32x32", "--seed", "1"]].concat();
        sandbox.render(&scene, &options).image
    };
    let usual = shot(&[]);
    for (spec, value) in values(Class::Numerics) {
        let other = shot(&[&format!("--{}", spec.name), value]);
        assert!(bits(&other) != bits(&usual), "{} changes nothing", spec.option(value));
        let paired = |other: &[[f32; 3]]| same_expectation_paired(&usual.rgb, other, ALPHA);
        paired(&other.rgb).unwrap_or_else(|error| panic!("{}: {error}", spec.option(value)));
        let brighter: Vec<_> = other.rgb.iter().map(|rgb| rgb.map(|v| 1.001 * v)).collect();
        assert!(paired(&brighter).is_err(), "{}: a thousandth more light is not found", spec.option(value));
    }
}

/// A glowing sphere of radius 1 at a distance D covers pi / 2.4² of a view that is 2.4 high there.
#[test]
fn the_textbooks_spheres_fail_far_away() {
    let sandbox = Sandbox::new();
    let covered = |distance: f64, options: &[&str]| {
        let fov = 2.0 * (1.2 / distance).atan().to_degrees();
        let scene = sandbox.scene(&format!(
            "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 0, {distance:e}), look_at: (0, 0, 0), vertical_fov: {fov:e}),
    background: Solid((0, 0, 0)),
    materials: {{ \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)) }},
    objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"lamp\")],
    render: (samples: 64, max_depth: 1),
)"
        ));
        means(&sandbox.render(&scene, options).image, 1, 1.0)[0].value[0]
    };
    let expected = PI / (2.4 * 2.4);
    // Sobol points give the area to far below 1e-3; the sphere covers a little more than its disk, by r²/D².
    let right = |found: f64| (found / expected - 1.0).abs() < 2e-3;
    for distance in [100.0, 1e5, 1e7] {
        let found = covered(distance, &[]);
        assert!(right(found), "D/r = {distance}: {found}, expected {expected}");
    }
    let near = covered(100.0, &["--precision", "fast"]);
    assert!(right(near), "D/r = 100: {near}, expected {expected}");
    for distance in [1e5, 1e7] {
        let far = covered(distance, &["--precision", "fast"]);
        assert!(!right(far), "D/r = {distance}: {far}");
    }
}

// What a render says of its settings

/// With all of them, too, the image does not depend on how the kernels are linked and the work is cut.
#[test]
fn approximations_give_the_same_bytes_however_they_are_linked() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(&smoky_room());
    let all = ["--fresnel", "schlick", "--clamp", "0.3", "--precision", "fast", "--spp", "16"];
    let shot = |more: &[&str]| bits(&sandbox.render(&scene, &[all.as_slice(), more].concat()).image);
    let usual = shot(&["--scatter", "fused"]);
    for scatter in ["linked", "queues"] {
        assert!(shot(&["--scatter", scatter, "--slots", "97", "--bounces", "7"]) == usual, "{scatter}");
    }
    // Each of them shows; that precision does is in `less_precision_is_right_in_an_ordinary_scene`. What is linked compiles the soonest.
    for (option, default) in [("--fresnel", "exact"), ("--clamp", "off")] {
        let options = all.chunks(2).flat_map(|pair| [pair[0], if pair[0] == option { default } else { pair[1] }]);
        let options: Vec<&str> = options.chain(["--scatter", "linked"]).collect();
        assert!(bits(&sandbox.render(&scene, &options).image) != usual, "{option}");
    }
}

#[test]
fn a_render_with_a_setting_that_biases_says_so() {
    let sandbox = Sandbox::new();
    // What is said does not depend on the size of the image.
    let small = CAUSTIC.replace("width: 32, height: 32", "width: 8, height: 8");
    let scene = sandbox.scene(&small.replace("max_depth: 50", "max_depth: 8"));
    // Of a setting that does not bias, two values say the same as all.
    let said = |spec: &OptionSpec| if matches!(spec.class, Class::Bias | Class::Numerics) { usize::MAX } else { 2 };
    let all = TRADE_OFFS.iter().flat_map(|spec| spec.values.iter().take(said(spec)).map(move |value| (*spec, *value)));
    for (spec, value) in all {
        let option = spec.option(value);
        let options: Vec<&str> = match spec.name {
            "spp" => vec!["--spp", value],
            _ => option.split(' ').chain(["--spp", "9"]).collect(),
        };
        let ran = sandbox.render(&scene, &options);
        let default = Some(value) == spec.default;
        // A depth of the scene's own, or deeper, removes nothing.
        let cuts = spec.name != "max-depth" || value.parse::<u32>().expect("a depth") < 8;
        let warns = matches!(spec.class, Class::Bias | Class::Numerics) && !default && cuts;
        let attribute =
            ran.image.attributes.iter().find(|(name, _)| name == "gpu-rt:biases").map(|(_, text)| text.as_str());
        assert_eq!(
            ran.json["biases"],
            if warns { serde_json::json!([option]) } else { serde_json::json!([]) },
            "{option}"
        );
        assert_eq!(attribute, warns.then_some(option.as_str()), "{option}");
        assert_eq!(ran.stderr.contains(&spec.warning(value)), warns, "{option}: {}", ran.stderr);
        let excludes = ran.json["relative_error_excludes"].as_str().unwrap_or_default();
        assert_eq!(excludes.contains(&option), warns && spec.name != "size", "{option}: {excludes}");
    }
    // Several at once, and none with --quiet.
    let ran = sandbox.render(&scene, &["--clamp", "2.5", "--precision", "fast", "--max-depth", "3", "--quiet"]);
    assert_eq!(ran.json["biases"], serde_json::json!(["--max-depth 3", "--clamp 2.5", "--precision fast"]));
    assert_eq!(ran.stderr, "");
}
