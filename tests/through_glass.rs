//! Light that only chance can meet, because a clear solid is between: counted, and told where it is missing.

#[path = "common/device.rs"]
mod device;
#[path = "common/render.rs"]
mod render;
#[path = "common/stats.rs"]
mod stats;

use std::process::Command;

use gpu_rt::render::ThroughGlass;
use render::{Ask, render as render_scene, scene};
use serde_json::Value;

/// A floor under a grey sky, a clear ball of radius `ball` about `place`, and a lamp of radius `lamp` above.
fn text(place: &str, ball: f64, lamp: f64) -> String {
    let emit = 4.0 / (lamp * lamp);
    format!(
        "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 2, 4), look_at: (0, 0.3, 0), vertical_fov: 40),
    background: Solid((0.2, 0.2, 0.2)),
    materials: {{
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
        \"lamp\": DiffuseLight(emit: Rgb({emit}, {emit}, {emit})),
        \"glass\": Dielectric(ior: 1.5),
    }},
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"white\"),
        Sphere(center: {place}, radius: {ball}, material: \"glass\"),
        Sphere(center: (0, 3, 0), radius: {lamp}, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 10),
)"
    )
}

const ON_THE_FLOOR: &str = "(0, 0.6, 0)";
const AROUND_THE_LAMP: &str = "(0, 3, 0)";

/// Per sample.
fn counted(text: &str, samples: u32) -> ThroughGlass {
    let shot = render_scene(&scene(text), &Ask::spp(samples).mis().depth(50));
    let ThroughGlass { stopped, met } = shot.outcome.through_glass;
    let paths = f64::from(32 * 32 * samples);
    ThroughGlass { stopped: stopped / paths, met: met / paths }
}

/// Where a lamp is large enough for chance to meet it, that meets about as much as glass stops: a clear ball sends on what it takes in, if
/// elsewhere. Of a lamp in its middle it shows a picture that is wider by the index, 1.5, and as bright: 2.25 times the light. (Of a lamp so
/// large that rays to it share it with paths that meet it, glass stops the rays' share alone.) 1024 samples tell each sum to a few percent.
#[test]
fn glass_sends_on_what_it_stops() {
    for (place, ball, expected) in [(ON_THE_FLOOR, 0.5, 1.0), (AROUND_THE_LAMP, 1.2, 2.25)] {
        let found = counted(&text(place, ball, 0.3), 1024);
        assert!(found.stopped > 0.0, "{found:?}");
        let share = found.met / found.stopped;
        assert!((0.7..1.3).contains(&(share / expected)), "{place}: {share}");
        assert!(found.missing() == 0.0);
    }
    // The planted errors: a lamp too small to be met, and no glass.
    let small = counted(&text(ON_THE_FLOOR, 0.5, 0.002), 16);
    assert!(small.met == 0.0 && small.missing() == 0.5 * small.stopped && small.stopped > 0.0, "{small:?}");
    let none = counted(&text(ON_THE_FLOOR, 0.5, 0.8).replace("material: \"glass\"", "material: \"white\""), 16);
    assert!(none == ThroughGlass::default(), "{none:?}");
}

/// What is smaller than 2^-24 of the brightest is rounded by chance and not away: of 50,000 rays that are stopped some 800 count, with a deviation of
/// 4 %.
#[test]
fn faint_light_is_counted() {
    let (usual, faint) =
        (counted(&text(ON_THE_FLOOR, 0.5, 0.02), 512), counted(&text(ON_THE_FLOOR, 0.5, 0.02 / 128.0), 512));
    // The device's unit follows the lamp's radiance by powers of two, and what the floor receives is as its square radius.
    let share = faint.stopped / usual.stopped * 128.0 * 128.0;
    assert!((share - 1.0).abs() < 0.2, "{share}");
}

fn report(text: &str, samples: &str) -> (Value, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scene.ron");
    std::fs::write(&file, text).expect("the scene is written");
    let output = Command::new(env!("CARGO_BIN_EXE_gpu-rt"))
        .args(["render", "--json", "--device", &device::software().name.name, "--spp", samples, "-o"])
        .arg(folder.path().join("a.exr"))
        .arg(&file)
        .output()
        .expect("it runs");
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    (serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {words}")), words)
}

/// A bulb within glass: two thirds of the light are missing from an image that looks free of noise.
#[test]
fn images_that_lack_light_are_unreliable() {
    let (bulb, words) = report(&text(AROUND_THE_LAMP, 0.3, 0.002), "64");
    assert!(bulb["relative_error_bound"].as_f64().unwrap() < 0.05, "by its noise alone: {bulb}");
    assert!(bulb["reliable"] == false && bulb["light_stopped_by_glass"].as_f64().unwrap() > 0.3, "{bulb}");
    assert!(words.contains("unreliable: clear solids keep light"), "{words}");
    let (lamp, words) = report(&text(ON_THE_FLOOR, 0.5, 0.8), "256");
    assert!(lamp["reliable"] == true && !words.contains("unreliable"), "{lamp}\n{words}");
}
