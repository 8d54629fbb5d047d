//! `gpu-rt tradeoff` by the clock: what is recommended does what was promised, within the budget. What is said of biases is tested in
//! tests/images/sweeps.rs.

use crate::alone;
use crate::common::device;
use crate::common::oidn;
use crate::common::program::{self, Ran};
use crate::common::sweeps::{ROOM, SKY, judged, lamp, measure, scene, unbiased};
use crate::common::tables::compare;
use std::path::Path;
use std::time::{Duration, Instant};

use gpu_rt::aov::Aov;
use gpu_rt::denoise::Denoiser;
use gpu_rt::metrics::error::relative_mse;
use gpu_rt::options::{DENOISE, MAX_DEPTH, RenderOptions};
use gpu_rt::output::exr::read_exr;
use gpu_rt::tradeoff::extent::FullSize;
use gpu_rt::tradeoff::judge::{Measured, judge, recommended};
use gpu_rt::tradeoff::replicates::Pixels;
use gpu_rt::tradeoff::sweep::{Setting, Sweep};
use gpu_rt::tradeoff::truth::Truth;
use serde_json::Value;

/// The unit of light decides nothing. With lights 2^-20 and 2^20 times as bright the images are the same but for that factor, so as many samples reach
/// a target, to the rounding of means in f32, and the same setting is advised. The seconds of a sample are equal within the sum of their
/// intervals and those of the defaults, which are the clock: each has half a width of two standard errors, and the four enter the ratio,
/// which leaves four standard errors. The scenes are measured round by round, so that other load slows them alike.
#[test]
fn the_unit_of_light_does_not_matter() {
    let _machine = alone();
    let lit = |power: i32| {
        let emit = [9.0, 8.0, 7.0].map(|emit: f64| (emit * 2f64.powi(power)).to_string()).join(", ");
        scene(&ROOM.replace("Rgb(9, 8, 7)", &format!("Rgb({emit})")))
    };
    let scenes = [0, -20, 20].map(lit);
    let mut sweeps = scenes.each_ref().map(|scene| {
        let mut sweep = Sweep::new(device::software(), scene, (24, 24), 0);
        let defaults = unbiased(scene).remove(0);
        let short = Setting { option: Some(&MAX_DEPTH), value: "2".into(), max_depth: 2, ..defaults.clone() };
        [defaults, short].into_iter().for_each(|setting| sweep.add(setting).expect("it compiles"));
        sweep
    });
    for (round, sweep) in (1..=12).flat_map(|round| [0, 1, 2].map(|sweep| (round, sweep))) {
        let until = Instant::now() + Duration::from_secs(3600);
        sweeps[sweep].measure(until, round, &|| false, &mut |_, _| {}).expect("the device renders");
    }
    let [usual, dark, bright] = sweeps.each_mut().map(|sweep| judged(sweep, None).measured);
    let advised = |found: &[Measured]| recommended(found).map(|best| best.map(|best| best.setting.name()));
    let samples = |of: &Measured| of.times.map(|time| time.map_or(0.0, |seconds| seconds / of.model.seconds));
    // A sample's seconds in those of the defaults, as a logarithm, and half the width of its interval.
    let pace = |found: &[Measured], setting: usize| {
        let half_width = |of: &Measured| of.seconds_half_width / of.model.seconds;
        let (of, defaults) = (&found[setting], &found[0]);
        ((of.model.seconds / defaults.model.seconds).ln(), half_width(of) + half_width(defaults))
    };
    assert!(advised(&usual).iter().all(Option::is_some) && usual[1].times[2].is_none(), "{usual:?}");
    for other in [&dark, &bright] {
        assert_eq!(advised(other), advised(&usual));
        for setting in [0, 1] {
            let (own, theirs) = (samples(&usual[setting]), samples(&other[setting]));
            let same = own.iter().zip(theirs).all(|(own, theirs)| (own - theirs).abs() <= 1e-4 * own);
            assert!(same, "{own:?} and {theirs:?} samples");
        }
        let ((own, half), (theirs, half_of_theirs)) = (pace(&usual, 1), pace(other, 1));
        println!("{own} ± {half} and {theirs} ± {half_of_theirs}");
        assert!((own - theirs).abs() <= half + half_of_theirs, "{own} ± {half} and {theirs} ± {half_of_theirs}");
        // The control: relMSE, whose 0.01 is a radiance, does not stay.
        assert!((other[0].relmse_ratio / usual[0].relmse_ratio - 1.0).abs() > 0.5);
    }
}

/// What `render` calls unreliable, a sweep calls so, in its words: much of the light comes by a narrow lobe, and no path finds the lamp there.
#[test]
fn light_that_a_narrow_lobe_hides_makes_a_setting_unreliable() {
    let _machine = alone();
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    let text = |shade: &str, mirror: &str| {
        format!(
            "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 1.4, 4), look_at: (0, 0.1, 0), vertical_fov: 30),
    background: Solid((0.02, 0.02, 0.02)),
    materials: {{
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)), \"black\": Lambertian(albedo: Rgb(0, 0, 0)),
        \"lamp\": DiffuseLight(emit: Rgb(250000, 250000, 250000)), \"mirror\": {mirror},
    }},
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"white\"), {shade}
        Quad(corner: (-3, 4, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"mirror\"),
        Sphere(center: (0, 2.2, 0), radius: 0.002, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 10),
)"
        )
    };
    const SHADE: &str = "Quad(corner: (-1, 1.7, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"black\"),";
    let sweep = |scene: &str| {
        std::fs::write(sandbox.path().join("mirror.ron"), scene).expect("it is written");
        let options = ["tradeoff", "mirror.ron", "--budget", "8s", "--knobs", "roulette", "--json"];
        run(sandbox.path(), &options).exits(0).json()
    };
    // A narrow layer over a matt body, to which no light paths are traced.
    let layer =
        |roughness: f64| format!("Pbr(base_color: Rgb(0.3, 0.3, 0.3), metallic: 0, ior: 5, roughness: {roughness})");
    for mirror in [0.001, 0.01].map(layer) {
        let mirror = mirror.as_str();
        let json = sweep(&text(SHADE, mirror));
        let settings = json["settings"].as_array().expect("settings");
        assert!(settings.iter().all(|setting| setting["reliable"] == false), "{mirror}: {json:#}");
        assert!(json["recommendations"].as_array().expect("three").iter().all(|best| best["setting"].is_null()));
        let render = ["render", "mirror.ron", "-o", "a.exr", "--spp", "256", "--force"];
        let said = run(sandbox.path(), &render).exits(0).stderr;
        let words = "mirrors, glass and other narrow lobes hide";
        let page =
            std::fs::read_to_string(sandbox.path().join("mirror-tradeoff/index.html")).expect("the page is there");
        assert!(said.contains(words) && page.contains(words), "{mirror}: {said}");
    }
    // The control: a matt ceiling hides nothing.
    let json = sweep(&text("", "Lambertian(albedo: Rgb(0.9, 0.9, 0.9))"));
    assert!(json["settings"][0]["reliable"] == true && json["recommendations"][1]["setting"].is_string(), "{json:#}");
}

/// On the tests' device.
fn run(folder: &Path, arguments: &[&str]) -> Ran {
    program::run(folder, &[arguments, &["--device", device::index()]].concat())
}

#[test]
fn the_program_reports_and_its_advice_is_kept() {
    let _machine = alone();
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    // Small, so that it is measured at its own size within the budget. From smaller images, what is advised is a fifth off.
    let small = ROOM.replace("width: 48, height: 48", "width: 24, height: 24");
    std::fs::write(sandbox.path().join("room.ron"), small).expect("it is written");
    let sweep = ["tradeoff", "room.ron", "--budget", "12s", "--knobs", "roulette,max-depth,sampler", "--json"];
    let json = run(sandbox.path(), &sweep).exits(0).json();
    compare("### `tradeoff --json`", std::slice::from_ref(&json));
    assert_eq!(json["width"], 24, "the budget is too short for the image's own size");
    let folder = sandbox.path().join("room-tradeoff");
    let page = std::fs::read_to_string(folder.join("index.html")).expect("the page is there");
    assert!(
        page.contains("<svg")
            && page.contains("data:image/png;base64,")
            && !page.replace("http://www.w3.org/2000/svg", "").contains("http"),
        "no network"
    );
    let csv = std::fs::read_to_string(folder.join("tradeoff.csv")).expect("the table is there");
    let settings = json["settings"].as_array().expect("settings");
    assert_eq!(csv.lines().count(), 1 + settings.len());
    let columns = csv.lines().next().map(|line| line.split(',').count());
    assert_eq!(columns, Some(29));
    // Every value of every requested option is there, measured or not.
    let named: Vec<&str> = settings.iter().filter_map(|setting| setting["setting"].as_str()).collect();
    for name in ["defaults", "--roulette off", "--max-depth 1", "--max-depth 16", "--sampler independent"] {
        assert!(named.contains(&name), "{name} in {named:?}");
    }
    let of = |name: &str| settings.iter().find(|setting| setting["setting"] == name).expect("it is there");
    assert_eq!(of("--max-depth 1")["biased"], true, "{json:#}");
    assert!(of("--max-depth 1")["bias"].as_f64().is_some_and(|bias| bias < -0.05));
    assert_eq!(
        of("--max-depth 1")["seconds_to"][2]["seconds"],
        Value::Null,
        "a bias above the target is not recommended"
    );

    // An independent render with what is advised for 1e-2 comes to that error.
    let advice = &json["recommendations"][1];
    let errors = kept(sandbox.path(), "room.ron", advice);
    assert!((errors[2] / 1e-2 - 1.0).abs() < 0.2, "{advice}: {errors:?}");

    for (knobs, why) in [("colour", "expected names from"), ("spp", "every setting is measured over its samples")] {
        let ran = run(sandbox.path(), &["tradeoff", "room.ron", "--knobs", knobs]).exits(2);
        assert!(ran.stderr.contains(&format!("--knobs {knobs}: {why}")), "{}", ran.stderr);
    }
}

/// The relative MSE of independent renders with what a report advises for one of its targets, in order: by five seeds, against one of 4096 samples.
/// What is advised here takes at most a hundred, so that the noise of that one adds a fortieth to the error.
fn kept(sandbox: &Path, scene: &str, advice: &Value) -> Vec<f64> {
    let render = |more: &[&str], out: &str| {
        run(sandbox, &[&["render", scene, "-o", out], more].concat()).exits(0);
        read_exr(&sandbox.join(out)).expect("it is read").rgb
    };
    let truth = render(&["--spp", "4096", "--seed", "77"], "truth.exr");
    let samples = advice["samples"].as_f64().unwrap_or_else(|| panic!("it is not reached: {advice:#}"));
    assert!(samples <= 100.0, "{advice:#}");
    // The integer number of samples that reaches it: of 5.5 it is 6, and with 5 the error is a quarter larger.
    let samples = samples.ceil().to_string();
    let option = advice["setting"].as_str().filter(|name| *name != "defaults").unwrap_or("");
    let options: Vec<&str> = option.split_whitespace().chain(["--spp", &samples]).collect();
    let error =
        |seed: u32| relative_mse(&render(&[&options[..], &["--seed", &seed.to_string()]].concat(), "own.exr"), &truth);
    let mut errors: Vec<f64> = (1..=5).map(|seed| error(seed).expect("of one size")).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Denoised images are nearer to the truth, with a bias that is in their error, and cost time of their own.
#[test]
fn denoising_is_measured_as_a_setting() {
    let _machine = alone();
    let scene = scene(ROOM);
    let denoiser = Denoiser::open(Some(&oidn::folder())).unwrap_or_else(|error| panic!("{error}"));
    let defaults = unbiased(&scene).remove(0);
    let mut options = RenderOptions::default();
    options.aov.include(&[Aov::Albedo, Aov::Normal]);
    let denoise = Setting { option: Some(&DENOISE), options, denoise: true, ..defaults.clone() };
    let mut sweep = Sweep::new(device::software(), &scene, (48, 48), 0);
    sweep.denoiser = Some(&denoiser);
    sweep.add(defaults.clone()).expect("it compiles");
    sweep.add(denoise.clone()).expect("it compiles");
    measure(&mut sweep, 1, 9);
    let mut full_size = FullSize::assumed(&sweep, sweep.size);
    full_size.seconds_to_denoise = 3.0;
    let found = judge(&mut sweep, None, &full_size, "").measured;
    let [raw, denoised] = &found[..] else { panic!("{found:?}") };
    assert_eq!((denoised.setting.name().as_str(), denoised.biased, raw.biased), ("--denoise", true, false));
    // In an image of 48 x 48 pixels detail is as small as noise, so that denoising gains little.
    let (before, after) = (raw.flips[0], denoised.flips[0]);
    assert!(before.0 == 4 && after.0 == 4 && after.1 < 0.95 * before.1, "{before:?} {after:?}");
    // What falls is all of its error.
    for (samples, error) in &denoised.noises {
        let images = |subject: usize| -> Vec<Pixels> {
            sweep.subjects[subject].blocks[samples].iter().map(|block| block.image.clone()).collect()
        };
        let truth = Truth::of_subject(&sweep, 0).expect("images").image;
        let all: f64 = images(1).iter().map(|image| relative_mse(image, &truth).expect("of one size")).sum();
        let mean = all / images(1).len() as f64;
        assert!((error / mean - 1.0).abs() < 0.35, "{samples}: {error} is stated, {mean} is so");
    }
    assert!(denoised.bias_squared() > 1e-4 && denoised.model.squared_bias == 0.0, "{denoised:?}");
    assert_eq!((raw.model.fixed_seconds, denoised.model.fixed_seconds), (0.0, 3.0));
    assert!(denoised.times.iter().flatten().all(|seconds| *seconds > 3.0));
    let timed = sweep.seconds_to_denoise((96, 96), Instant::now()).expect("it denoises");
    assert!(timed.is_some_and(|seconds| seconds > 0.0));

    // Without the library it is not measured, and an error if it is requested.
    let mut other = Sweep::new(device::software(), &scene, (48, 48), 0);
    [defaults, denoise].into_iter().for_each(|setting| other.add(setting).expect("the defaults compile"));
    assert!(other.subjects.len() == 1 && other.unmeasured[0].why.contains("it needs Open Image Denoise"));
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(sandbox.path().join("room.ron"), ROOM).expect("it is written");
    let ran = run(sandbox.path(), &["tradeoff", "room.ron", "--knobs", "denoise", "--oidn", "."]).exits(1);
    assert!(ran.stderr.contains("neither it nor its folder lib or bin has"), "{}", ran.stderr);
}

/// A setting that is much noisier beside the defaults does not change what is promised of these.
#[test]
fn advice_is_kept_beside_settings_of_rare_bright_paths() {
    let _machine = alone();
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(sandbox.path().join("lamp.ron"), lamp(0.02, 48)).expect("it is written");
    // An option given twice counts once. All rounds are done in a few seconds on an idle machine; then it ends.
    let sweep = ["tradeoff", "lamp.ron", "--budget", "30s", "--knobs", "integrator,integrator", "--json"];
    let json = run(sandbox.path(), &sweep).exits(0).json();
    assert_eq!(json["settings"].as_array().map(Vec::len), Some(2), "{json:#}");
    let advice = &json["recommendations"][2];
    assert_eq!(advice["setting"], "defaults", "{json:#}");
    let errors = kept(sandbox.path(), "lamp.ron", advice);
    assert!((errors[2] / 1e-3 - 1.0).abs() < 0.2, "{advice}: {errors:?}");
}

/// A sweep, and the seconds that it took of so many. A machine that is busy or stands still for a while does not do so three times.
fn sweep_within(sandbox: &Path, seconds: f64) -> (Ran, f64) {
    let attempt = || {
        let begin = Instant::now();
        let (budget, knobs) = (format!("{seconds:.2}s"), "sampler,roulette,clamp,max-depth");
        let ran = run(sandbox, &["tradeoff", "sky.ron", "--budget", &budget, "--knobs", knobs, "--quiet"]);
        (ran, begin.elapsed().as_secs_f64())
    };
    let is_usual =
        |(ran, took): &(Ran, f64)| *took < MORE_THAN_BUDGET * seconds && !ran.stdout.contains("the machine was busy");
    (0..2).map(|_| attempt()).find(is_usual).unwrap_or_else(attempt)
}

/// The budget is the time that all of a sweep may take; a quarter of it more is for the last picture on a slow machine.
const MORE_THAN_BUDGET: f64 = 1.25;
const BUDGET: f64 = 12.0;

/// Independent samples take more of them than Sobol points where pixels are smooth. A budget that is enough for all rounds shows nothing of the
/// clock: so a fourth of the time that they took is requested as well, which a sweep without a clock would exceed four times.
#[test]
fn a_sweep_keeps_its_budget_and_tells_what_is_dominated() {
    let _machine = alone();
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(sandbox.path().join("sky.ron"), SKY).expect("it is written");
    let (ran, took) = sweep_within(sandbox.path(), BUDGET);
    let stdout = ran.exits(0).stdout;
    assert!(took < MORE_THAN_BUDGET * BUDGET, "{took} s of {BUDGET}");
    let short = (0.25 * took).max(2.0);
    let (ran, took_of_short) = sweep_within(sandbox.path(), short);
    println!("{took} s of {BUDGET}, {took_of_short} s of {short}");
    assert!(ran.code() == 0 || ran.stderr.contains("give it more"), "{}", ran.stderr);
    assert!(took_of_short < MORE_THAN_BUDGET * short, "{took_of_short} s of {short}");
    let line =
        |name: &str| stdout.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name} in {stdout}"));
    assert!(line("--sampler independent").contains("dominated"), "{stdout}");
    // The table fits a terminal.
    let table = stdout.lines().skip_while(|line| !line.starts_with("setting ")).take_while(|line| !line.contains(": "));
    assert!(table.clone().count() > 10 && table.clone().all(|line| line.chars().count() <= 80), "{stdout}");
    // What is advised is on the front; which of several that are as soon as each other that is, timings decide.
    for advice in stdout.lines().filter_map(|line| line.strip_prefix("To reach a relative MSE of ")) {
        let name = advice.split_once(" use ").and_then(|(_, rest)| rest.split_once(':')).map_or("", |(name, _)| name);
        let name = name.trim_matches('`').trim_start_matches("the ");
        assert!(line(name).contains("front"), "{name}: {stdout}");
    }
    // Which device it holds for.
    assert!(stdout.lines().any(|line| line.contains(" settings measured at ") && line.contains(" on ")), "{stdout}");
}

#[test]
fn the_noise_of_a_reference_is_stated_and_subtracted() {
    let _machine = alone();
    let sandbox = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(sandbox.path().join("room.ron"), ROOM).expect("it is written");
    let render = |spp: &str, seed: &str, out: &str| {
        let options = ["render", "room.ron", "--size", "24x24", "-o", out, "--spp", spp, "--seed", seed, "--force"];
        run(sandbox.path(), &options).exits(0);
        read_exr(&sandbox.path().join(out)).expect("it is read").rgb
    };
    let truth = render("4096", "1000", "truth.exr");
    // As noisy as the blocks that are measured, and of a seed that is the sweep's too.
    let noisy = render("16", "3", "noisy.exr");
    let sweep = ["tradeoff", "room.ron", "--budget", "8s", "--knobs", "roulette,sampler,max-depth", "--json"];
    let json = run(sandbox.path(), &[&sweep[..], &["--reference", "noisy.exr"]].concat()).exits(0).json();
    assert!(json["seed"].as_u64().is_some_and(|seed| seed > 3), "{}", json["seed"]);
    // Stated: of 1728 values with one degree of freedom, and with rare bright ones among them.
    assert_eq!((&json["width"], &json["height"]), (&Value::from(24), &Value::from(24)));
    let own = json["relative_mse_of_reference"].as_f64().expect("two halves tell it");
    let is = relative_mse(&noisy, &truth).expect("of one size");
    assert!((own / is - 1.0).abs() < 0.3, "{own:e} is stated, {is:e} is so");
    // Subtracted: the picture of 16 samples is as noisy, and would be off by twice as much.
    let shown = json["equal_time"].as_array().and_then(|all| all.iter().find(|shown| shown["setting"] == "defaults"));
    let shown = shown.expect("the defaults have a picture");
    assert_eq!(shown["samples"], 16);
    let error = shown["relative_mse"].as_f64().expect("a number");
    assert!((0.4..1.6).contains(&(error / is)), "{error:e} of an image of {is:e}");
    let against = &json["defaults_against_reference"];
    assert!(against["differs"] == false && against["squared_bias"].as_f64().is_some_and(|b| b < 0.5 * is), "{against}");
    for setting in json["settings"].as_array().expect("settings") {
        if setting["class"] == "noise" {
            assert_eq!(setting["biased"], false, "{setting}");
        }
        if setting["setting"] == "--max-depth 1" {
            assert!(
                setting["biased"] == true && setting["bias"].as_f64().is_some_and(|bias| bias < -0.05),
                "{setting}"
            );
        }
    }
    // One whose sides share no divisor is measured in its middle, by images that are as small as others, and shows the same.
    let options = ["--size", "211x199", "--spp", "16", "--seed", "500", "--quiet", "-o", "odd.exr"];
    run(sandbox.path(), &[&["render", "room.ron"], &options[..]].concat()).exits(0);
    let odd = ["tradeoff", "room.ron", "--budget", "5s", "--knobs", "roulette", "--json", "--reference", "odd.exr"];
    let json = run(sandbox.path(), &odd).exits(0).json();
    assert_eq!((&json["whole_width"], &json["whole_height"]), (&Value::from(195), &Value::from(195)));
    assert!(json["width"].as_u64().is_some_and(|width| width <= 65), "{}", json["width"]);
    assert_eq!(json["defaults_against_reference"]["differs"], false, "{json:#}");
    // Few samples are one replicate, and show nothing.
    render("8", "3", "noisy.exr");
    let short = ["tradeoff", "room.ron", "--budget", "3s", "--knobs", "roulette", "--reference", "noisy.exr"];
    run(sandbox.path(), &short).exits(0).on_stderr(&["noisy.exr; it has no variance"]);
}
