//! `gpu-rt tradeoff`: planted biases are found, noise is not called a bias, and what is recommended does what was promised.

#[path = "common/device.rs"]
mod device;
#[path = "common/render.rs"]
mod render;
#[path = "common/stats.rs"]
mod stats;

use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use gpu_rt::data::Sampler;
use gpu_rt::flatten::Wish;
use gpu_rt::gpu::device::Adapters;
use gpu_rt::knobs::{CLAMP, INTEGRATOR, ROULETTE, SAMPLER};
use gpu_rt::metrics::error::relmse;
use gpu_rt::output::exr::read_exr;
use gpu_rt::scene::Scene;
use gpu_rt::tradeoff::judge::{Judged, judge};
use gpu_rt::tradeoff::sweep::{Setting, Sweep};
use gpu_rt::tradeoff::truth::Truth;
use serde_json::Value;

/// A room with a lamp in it and something of each kind of surface.
const ROOM: &str = "Scene(
    image: (width: 48, height: 48),
    camera: (look_from: (0, 0, 3.4), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)),
    materials: {
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)), \"glass\": Dielectric(ior: 1.5),
        \"steel\": Metal(albedo: Rgb(0.8, 0.8, 0.7), fuzz: 0.2), \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7)),
    },
    objects: [
        Box(min: (-1, -1, -1.2), max: (1, -0.98, 1), material: \"white\"), Box(min: (-1, -1, -1.2), max: (-0.98, 1, 1), material: \"white\"),
        Box(min: (0.98, -1, -1.2), max: (1, 1, 1), material: \"white\"), Box(min: (-1, -1, -1.2), max: (1, 1, -1.18), material: \"white\"),
        Sphere(center: (-0.4, -0.6, 0), radius: 0.35, material: \"glass\"), Sphere(center: (0.5, -0.65, -0.3), radius: 0.3, material: \"steel\"),
        Quad(corner: (-0.5, 0.9, -0.5), u: (1, 0, 0), v: (0, 0, 1), material: \"lamp\"),
    ],
    render: (samples: 16, max_depth: 20),
)";

const SKY: &str = "Scene(
    image: (width: 48, height: 48),
    camera: (look_from: (0, 1, 5), look_at: (0, 0.6, 0), vertical_fov: 40),
    background: Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1)),
    materials: { \"ground\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"glass\": Dielectric(ior: 1.5) },
    objects: [
        Sphere(center: (0, -1000, 0), radius: 1000, material: \"ground\"), Sphere(center: (-1, 0.7, 0), radius: 0.7, material: \"glass\"),
        Sphere(center: (0.8, 0.7, 0), radius: 0.7, material: \"ground\"),
    ],
    render: (samples: 16, max_depth: 20),
)";

const SMOKE: &str = "Scene(
    image: (width: 48, height: 48),
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vertical_fov: 40),
    background: Solid((0.3, 0.4, 0.5)),
    materials: { \"lamp\": DiffuseLight(emit: Rgb(5, 5, 5)) },
    objects: [
        Medium(boundary: Sphere(center: (0, 0, 0), radius: 1.2), density: 1.5, albedo: Rgb(0.9, 0.8, 0.7)),
        Sphere(center: (2, 1.5, 0), radius: 0.4, material: \"lamp\"),
    ],
    render: (samples: 16, max_depth: 20),
)";

fn scene(text: &str) -> Scene {
    render::scene(text)
}

fn wish() -> Wish {
    Wish { sample_lights: true, roulette: true, sampler: Sampler::Sobol, ..Wish::default() }
}

/// The defaults, and three settings that are declared to change the noise alone.
fn unbiased(scene: &Scene) -> Vec<Setting> {
    let setting = |knob, value: &str, wish| Setting {
        knob,
        value: value.to_string(),
        wish,
        max_depth: scene.render.max_depth,
        scale: 1.0,
    };
    vec![
        setting(None, "", wish()),
        setting(Some(&INTEGRATOR), "bsdf", Wish { sample_lights: false, ..wish() }),
        setting(Some(&ROULETTE), "off", Wish { roulette: false, ..wish() }),
        setting(Some(&SAMPLER), "independent", Wish { sampler: Sampler::Independent, ..wish() }),
    ]
}

/// Rounds of measurement of all settings with a seed, of which the last's images are then made brighter by a factor.
fn measure(sweep: &mut Sweep<'_>, seed: u32, rounds: usize, planted: f32) {
    sweep.begin_again(seed);
    let forever = Instant::now() + Duration::from_secs(3600);
    sweep.measure(forever, rounds, &|| false, &mut |_, _| {}).expect("the device renders");
    if let Some(last) = sweep.subjects.last_mut() {
        for block in last.blocks.values_mut().flatten() {
            block.image.as_flattened_mut().iter_mut().for_each(|v| *v *= planted);
        }
    }
}

fn judged(sweep: &mut Sweep<'_>, reference: Option<&Truth>) -> Judged {
    judge(sweep, reference, (1.0, 1.0), "")
}

/// Seconds are measured within a budget: each test has the machine for itself, as far as this program goes.
fn alone() -> MutexGuard<'static, ()> {
    static MACHINE: Mutex<()> = Mutex::new(());
    MACHINE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn a_planted_bias_is_found_with_its_sign_and_size() {
    let _machine = alone();
    for (name, text) in [("room", ROOM), ("sky", SKY), ("smoke", SMOKE)] {
        let scene = scene(text);
        let mut sweep = Sweep::new(device::software(), &scene, (48, 48), 0);
        let defaults = unbiased(&scene).remove(0);
        sweep.add(defaults.clone()).expect("it compiles");
        // A knob that does next to nothing here, in whose images the bias is planted: 0.5 % darker, then brighter.
        let clamp =
            Setting { knob: Some(&CLAMP), value: "1e6".into(), wish: Wish { clamp: Some(1e6), ..wish() }, ..defaults };
        sweep.add(clamp).expect("it compiles");
        for (seed, bias) in [(1000, -0.005f32), (2000, 0.005)] {
            measure(&mut sweep, seed, 8, 1.0 + bias);
            let found = judged(&mut sweep, None).measured;
            let [_, clamp] = &found[..] else { panic!("{name}: {found:?}") };
            let (value, half) = (clamp.signed.value, clamp.signed.half_width());
            // Relative to a reference that is itself off by half of it.
            assert!(clamp.biased && (value - f64::from(bias)).abs() <= half + 2e-5, "{name}, {bias}: {value} ± {half}");
            assert!(value * f64::from(bias) > 0.0 && clamp.verdict().contains("biased"), "{}", clamp.verdict());
        }
        // Without it there is none.
        measure(&mut sweep, 2000, 8, 1.0);
        assert!(judged(&mut sweep, None).measured.iter().all(|measured| !measured.biased), "{name}");
    }
}

/// Of 100 sweeps at most 11 may have a false alarm: with a probability of 5 % each, more do once in 170 times. So too against a reference
/// that is as noisy as what it judges.
#[test]
fn settings_that_only_add_noise_are_not_called_biased() {
    let _machine = alone();
    const SWEEPS: u32 = 100;
    let scene = scene(ROOM);
    let all = unbiased(&scene);
    let mut sweep = Sweep::new(device::software(), &scene, (12, 12), 0);
    let mut other = Sweep::new(device::software(), &scene, (12, 12), 0);
    other.add(all[0].clone()).expect("it compiles");
    all.into_iter().for_each(|setting| sweep.add(setting).expect("it compiles"));
    let (mut alarms, mut with_reference, mut found_darker) = (0, 0, 0);
    for number in 0..SWEEPS {
        measure(&mut sweep, 1 + 1000 * number, 6, 1.0);
        let found = judged(&mut sweep, None).measured;
        assert_eq!(found.len(), 4);
        alarms += u32::from(found.iter().any(|measured| measured.biased));

        measure(&mut other, 501 + 1000 * number, 2, 1.0);
        let mut reference = Truth::pooled(&other, None).expect("there are images");
        let own = reference.error(&reference.image).expect("of two halves");
        let noise = found[0].model.error(16.0);
        assert!((0.05..2.0).contains(&(own / noise)), "the reference's noise is {own:e}, an image's {noise:e}");
        let found = judged(&mut sweep, Some(&reference));
        let (_, differs) = found.against_reference.expect("its noise is known");
        with_reference += u32::from(differs || found.measured.iter().any(|measured| measured.biased));
        // The control: one that shows another scene.
        reference.image.as_flattened_mut().iter_mut().for_each(|v| *v *= 1.1);
        let found = judged(&mut sweep, Some(&reference));
        let (distance, differs) = found.against_reference.expect("its noise is known");
        found_darker += u32::from(differs && distance.signed.value < 0.0);
    }
    assert!(alarms <= 11 && with_reference <= 11, "{alarms}, and against references {with_reference}, of {SWEEPS}");
    assert!(found_darker >= 95, "{found_darker} of {SWEEPS}");
}

fn run(folder: &std::path::Path, arguments: &[&str]) -> (i32, String, String) {
    let device = std::env::var("GPU_RT_TEST_DEVICE").unwrap_or_else(|_| {
        let names = Adapters::find().names();
        let index = names.iter().position(|(name, _)| name.software);
        index.expect("the tests need a software Vulkan driver").to_string()
    });
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    let output = command.args(arguments).args(["--device", &device]).current_dir(folder).output();
    let output = output.expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("it is text");
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

#[test]
fn the_program_reports_and_its_advice_is_kept() {
    let _machine = alone();
    let place = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(place.path().join("room.ron"), ROOM).expect("it is written");
    let sweep = ["tradeoff", "room.ron", "--budget", "20s", "--knobs", "roulette,clamp,max-depth,sampler", "--json"];
    let (status, stdout, stderr) = run(place.path(), &sweep);
    assert_eq!(status, 0, "{stderr}");
    let json: Value = serde_json::from_str(&stdout).expect("one object");
    let folder = place.path().join("room-tradeoff");
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
    assert_eq!(columns, Some(23));
    // Every value of every knob asked for is there, measured or not.
    let named: Vec<&str> = settings.iter().filter_map(|setting| setting["setting"].as_str()).collect();
    for name in [
        "defaults",
        "--roulette off",
        "--clamp 1",
        "--clamp 100",
        "--max-depth 1",
        "--max-depth 16",
        "--sampler independent",
    ] {
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
    let render = |more: &[&str], out: &str| {
        let (status, _, stderr) = run(place.path(), &[&["render", "room.ron", "-o", out], more].concat());
        assert_eq!(status, 0, "{stderr}");
        read_exr(&place.path().join(out)).expect("it is read").rgb
    };
    let truth = render(&["--spp", "16384", "--seed", "77"], "truth.exr");
    let advice = &json["recommendations"][1];
    let samples = advice["samples"].as_f64().unwrap_or_else(|| panic!("it is not reached: {json:#}"));
    let samples = samples.round().max(1.0).to_string();
    let option = advice["setting"].as_str().filter(|name| *name != "defaults").unwrap_or("");
    let options: Vec<&str> = option.split_whitespace().chain(["--spp", &samples]).collect();
    let mut errors: Vec<f64> = (1..=5)
        .map(|seed| {
            relmse(&render(&[&options[..], &["--seed", &seed.to_string()]].concat(), "own.exr"), &truth)
                .expect("of one size")
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    assert!((errors[2] / 1e-2 - 1.0).abs() < 0.2, "{advice}: {errors:?}");

    let (status, _, stderr) = run(place.path(), &["tradeoff", "room.ron", "--knobs", "colour"]);
    assert!(status == 2 && stderr.contains("--knobs colour: expected names from"), "{status}: {stderr}");
}

#[test]
fn the_noise_of_a_reference_is_stated_and_subtracted() {
    let _machine = alone();
    let place = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(place.path().join("room.ron"), ROOM).expect("it is written");
    let render = |spp: &str, seed: &str, out: &str| {
        let options = ["render", "room.ron", "--size", "24x24", "-o", out, "--spp", spp, "--seed", seed];
        let (status, _, stderr) = run(place.path(), &options);
        assert_eq!(status, 0, "{stderr}");
        read_exr(&place.path().join(out)).expect("it is read").rgb
    };
    let truth = render("4096", "1000", "truth.exr");
    // As noisy as the blocks that are measured, and of a seed that is the sweep's too.
    let noisy = render("16", "3", "noisy.exr");
    let sweep = ["tradeoff", "room.ron", "--budget", "8s", "--knobs", "roulette,sampler,max-depth", "--json"];
    let (status, stdout, stderr) = run(place.path(), &[&sweep[..], &["--reference", "noisy.exr"]].concat());
    assert_eq!(status, 0, "{stderr}");
    let json: Value = serde_json::from_str(&stdout).expect("one object");
    assert!(json["seed"].as_u64().is_some_and(|seed| seed > 3), "{}", json["seed"]);
    // Stated: of 1728 values with one degree of freedom, and with rare bright ones among them.
    assert_eq!((&json["width"], &json["height"]), (&Value::from(24), &Value::from(24)));
    let own = json["relmse_of_reference"].as_f64().expect("two halves tell it");
    let is = relmse(&noisy, &truth).expect("of one size");
    assert!((own / is - 1.0).abs() < 0.3, "{own:e} is stated, {is:e} is so");
    // Subtracted: the picture of 16 samples is as noisy, and would be off by twice as much.
    let shown = json["equal_time"].as_array().and_then(|all| all.iter().find(|shown| shown["setting"] == "defaults"));
    let shown = shown.expect("the defaults have a picture");
    assert_eq!(shown["samples"], 16);
    let error = shown["relmse"].as_f64().expect("a number");
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
    // Few samples are one replicate, and tell nothing.
    render("8", "3", "noisy.exr");
    let (status, _, stderr) = run(place.path(), &[&sweep[..6], &["--reference", "noisy.exr"]].concat());
    assert!(status == 0 && stderr.contains("noisy.exr, which does not tell its own noise"), "{stderr}");
}
