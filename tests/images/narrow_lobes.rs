//! Light that narrow lobes hide from light sampling: mirrors, glass, polished metal, forward scattering. It is counted, and told where it is
//! missing.

use crate::common::device;
use crate::common::program::{self, ran};
use std::ops::Range;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::render::{Request, render as render_scene, render_all, scene};
use gpu_rt::film::HiddenLight;
use gpu_rt::options::{LightPaths, Scatter};
use gpu_rt::output::exr::read_exr;
use serde_json::Value;

/// A floor under a grey sky, a clear ball of radius `ball` about `position`, and a lamp of radius `lamp` above.
fn text(position: &str, ball: f64, lamp: f64) -> String {
    with_ball(CLEAR, position, ball, lamp)
}

const CLEAR: &str = "Dielectric(ior: 1.5)";

/// The scene with a ball of any material.
fn with_ball(glass: &str, position: &str, ball: f64, lamp: f64) -> String {
    let emit = 4.0 / (lamp * lamp);
    format!(
        "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 2, 4), look_at: (0, 0.3, 0), vertical_fov: 40),
    background: Solid((0.2, 0.2, 0.2)),
    materials: {{
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
        \"lamp\": DiffuseLight(emit: Rgb({emit}, {emit}, {emit})),
        \"glass\": {glass},
    }},
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"white\"),
        Sphere(center: {position}, radius: {ball}, material: \"glass\"),
        Sphere(center: (0, 3, 0), radius: {lamp}, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 10),
)"
    )
}

const ON_THE_FLOOR: &str = "(0, 0.6, 0)";
const AROUND_THE_LAMP: &str = "(0, 3, 0)";

/// A floor under a sky, what is above it, and at `position` a lamp of radius `lamp`, of which all rays to it miss the floor.
fn other(background: &str, above: &str, position: &str, lamp: f64) -> String {
    let emit = 1.0 / (lamp * lamp);
    format!(
        "Scene(
    image: (width: 32, height: 32),
    camera: (look_from: (0, 1.4, 4), look_at: (0, 0.1, 0), vertical_fov: 30),
    background: {background},
    materials: {{
        \"white\": Lambertian(albedo: Rgb(0.7, 0.7, 0.7)),
        \"black\": Lambertian(albedo: Rgb(0, 0, 0)),
        \"lamp\": DiffuseLight(emit: Rgb({emit}, {emit}, {emit})),
        \"mirror\": Metal(albedo: Rgb(0.9, 0.9, 0.9)),
        \"glass\": Dielectric(ior: 1.5),
    }},
    objects: [
        Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"white\"),
        {above}
        Sphere(center: {position}, radius: {lamp}, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 10),
)"
    )
}

/// A plane mirror above a lamp with a shade under it.
fn under_a_mirror(lamp: f64) -> String {
    under_a(MIRROR, lamp)
}

const MIRROR: &str = "Metal(albedo: Rgb(0.9, 0.9, 0.9))";

/// The scene with any material instead of the mirror. The sky is dark, so that much of the light is the mirror's.
fn under_a(material: &str, lamp: f64) -> String {
    let above = "Quad(corner: (-1, 1.7, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"black\"),
        Quad(corner: (-3, 4, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"mirror\"),";
    other("Solid((0.02, 0.02, 0.02))", above, "(0, 2.2, 0)", lamp).replace(MIRROR, material)
}

/// A pane or a fog between the floor and a lamp. A floor without it would see the lamp.
fn behind(between: &str, material: &str, lamp: f64) -> String {
    other("Solid((0.02, 0.02, 0.02))", between, "(0, 3, 0)", lamp).replace(MIRROR, material)
}

const PANE: &str = "Quad(corner: (-9, 2, 9), u: (18, 0, 0), v: (0, 0, -18), material: \"mirror\"),";

/// Fog that scatters forwards, three mean free paths deep.
fn in_a_fog(anisotropy: f64, lamp: f64) -> String {
    let fog = format!(
        "Medium(boundary: Box(min: (-9, 1, -9), max: (9, 2, 9)), density: 3, albedo: Rgb(1, 1, 1), anisotropy: {anisotropy}),"
    );
    behind(&fog, MIRROR, lamp)
}

/// Narrow lobes of each kind, with a lamp of some radius behind them.
fn narrow(lamp: f64) -> Vec<(String, String)> {
    let metals = [
        "Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: ",
        "Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: ",
        "Pbr(base_color: Rgb(0.9, 0.9, 0.9), metallic: 1, roughness: ",
        // A layer over a matt body, which reflects as much.
        "Pbr(base_color: Rgb(0.3, 0.3, 0.3), metallic: 0, ior: 5, roughness: ",
        "Pbr(base_color: Rgb(0.9, 0.9, 0.9), metallic: 0.5, roughness: ",
    ];
    let by = |text: &str, width: f64| format!("{text}{width})");
    let metals = metals.iter().flat_map(|metal| [0.0, 1e-3, 0.01].map(|width| by(metal, width)));
    let mirrors = metals.map(|metal| (metal.clone(), under_a(&metal, lamp)));
    let glass = [0.002, 0.02].map(|roughness| by("RoughDielectric(ior: 1.5, roughness: ", roughness));
    let balls = glass.into_iter().map(|glass| (glass.clone(), with_ball(&glass, AROUND_THE_LAMP, 1.2, lamp)));
    let panes = [0.002, 0.02].map(|roughness| by("ThinDielectric(roughness: ", roughness));
    let panes = panes.into_iter().map(|pane| (pane.clone(), behind(PANE, &pane, lamp)));
    let fogs = [0.999, -0.999].map(|g| (format!("fog of {g}"), in_a_fog(g, lamp)));
    mirrors.chain(balls).chain(panes).chain(fogs.into_iter().take(1)).collect()
}

/// A lamp in a clear ball, and another ball, which sends on much of an image's light.
fn under_a_sky(lamp: f64) -> String {
    let sky = format!("Image(path: \"{SKY}\")");
    let above = "Sphere(center: (0, 0.6, 0), radius: 0.5, material: \"glass\"),
        Sphere(center: (0, 3, 0), radius: 0.6, material: \"glass\"),";
    other(&sky, above, "(0, 3, 0)", lamp)
}

const SKY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/textures/sky.hdr");

/// By default, small lights have light paths. What they bring of the light that narrow lobes hide is what probes find: both are known to 10 %. The narrow
/// layer of a matt body and fog have no light paths.
#[test]
fn light_paths_find_what_narrow_lobes_hide() {
    let is_found = |name: &str| !name.contains("ior: 5") && !name.contains("metallic: 0.5") && !name.contains("fog");
    for (name, text) in narrow(0.002).into_iter().filter(|(name, _)| is_found(name)) {
        let request = Request::spp(64).mis().sobol().roulette().with(|options| options.light_paths = LightPaths::Auto);
        let shot = render_scene(&scene(&text), &request);
        let hidden = shot.outcome.totals.hidden_light();
        assert!((0.7..1.4).contains(&(hidden.found() / hidden.probed())), "{name}: {hidden:?}");
        assert!(!shot.film.verdict(0.05).lacks_light(), "{name}: {hidden:?}");
    }
}

/// Light per sample: what probes find, what paths find, and what is missing.
#[derive(Debug, PartialEq)]
struct Counted {
    probed: f64,
    found: f64,
    missing: f64,
}

fn counted_by(text: &str, samples: u32, request: Request) -> HiddenLight {
    let request = Request { samples: Some(0..samples), ..request };
    render_scene(&scene(text), &request).outcome.totals.hidden_light().times(1.0 / f64::from(32 * 32 * samples))
}

fn counted(text: &str, samples: u32) -> Counted {
    let light = counted_by(text, samples, Request::default().mis().depth(50));
    Counted { probed: light.probed(), found: light.found(), missing: light.missing() }
}

/// Where a lamp is large enough for paths to find it, they find about as much as probes: what a mirror or a clear solid takes in it sends on, if
/// elsewhere, and probes look for light within 25 degrees of where the path goes. That smooths what they find, and loses what
/// the cone has below a surface: over eleven scenes at 1024 samples or more paths find 0.95 to 1.16 times as much, and 1.6 times by a mirror that stands
/// on edge to lamp and floor. 1024 samples give each sum to 3 %. Light that counted twice, or by half, would be found.
#[test]
fn paths_find_as_much_light_as_probes_do() {
    let ball = |position, radius| text(position, radius, 0.3);
    // Half a sky: no probe reaches light that is darker than the mean, which BSDF sampling alone finds.
    let folder = tempfile::tempdir().expect("a folder");
    let half = folder.path().join("half.hdr");
    let image = image::Rgb32FImage::from_fn(16, 8, |_, y| image::Rgb([f32::from(y < 4); 3]));
    image::DynamicImage::from(image).save(&half).expect("the sky is written");
    let sky = under_a_sky(0.4).replace(SKY, half.to_str().expect("it is UTF-8"));
    for text in [ball(ON_THE_FLOOR, 0.5), ball(AROUND_THE_LAMP, 1.2), under_a_mirror(0.4), sky] {
        let light = counted(&text, 1024);
        assert!(light.probed > 0.0, "{light:?}\n{text}");
        assert!((0.8..1.3).contains(&(light.found / light.probed)), "{light:?}\n{text}");
    }
    // The planted errors: a lamp too small to be found, and neither mirror nor glass.
    let small = counted(&text(ON_THE_FLOOR, 0.5, 0.002), 64);
    assert!(small.found == 0.0 && small.missing == 0.75 * small.probed && small.probed > 0.0, "{small:?}");
    let none = counted(&with_ball("Lambertian(albedo: Rgb(0.7, 0.7, 0.7))", ON_THE_FLOOR, 0.5, 0.8), 16);
    assert_eq!(none, Counted { probed: 0.0, found: 0.0, missing: 0.0 });
}

/// The lobes up to the limit are found by scattered rays and by light sampling, which count with their weights; so are the narrow parts of
/// materials that have others too. The sums are known to 5 %.
#[test]
fn paths_find_as_much_light_as_probes_do_in_lobes_up_to_the_limit() {
    let metal = |text: &str| under_a(text, 0.4);
    for text in [
        metal("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0.099)"),
        metal("Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: 0.22)"),
        metal("Pbr(base_color: Rgb(0.3, 0.3, 0.3), metallic: 0, ior: 5, roughness: 0)"),
        metal("Pbr(base_color: Rgb(0.3, 0.3, 0.3), metallic: 0, ior: 5, roughness: 0.22)"),
        with_ball("RoughDielectric(ior: 1.5, roughness: 0.2)", AROUND_THE_LAMP, 1.2, 0.3),
        behind(PANE, "ThinDielectric(roughness: 0.2)", 0.4),
        in_a_fog(0.96, 0.4),
    ] {
        let light = counted(&text, 1024);
        assert!((0.8..1.3).contains(&(light.found / light.probed)), "{light:?}\n{text}");
    }
    // Beyond the limit nothing is counted.
    for text in [metal("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0.101)"), in_a_fog(0.94, 0.4)] {
        assert_eq!(counted(&text, 4), Counted { probed: 0.0, found: 0.0, missing: 0.0 }, "{text}");
    }
}

/// One light that is met, a sky, does not stand in for another that is not.
#[test]
fn a_light_that_is_met_hides_no_other() {
    let light = counted(&under_a_sky(0.001), 256);
    assert!(light.found > 0.3 * light.probed && light.missing > 0.3 * light.probed, "{light:?}");
    // Of a lamp that is met as well, what is missing is noise in bins of few meetings.
    let light = counted(&under_a_sky(0.4), 256);
    assert!(light.missing < 0.02 * light.probed, "{light:?}");
}

/// What is smaller than 2^-24 of the brightest is rounded by chance and not away. Some 600 rays find the lamp, and of the faint one a third of them
/// count: 5 % and 8 % are the deviations.
#[test]
fn faint_light_is_counted() {
    let (usual, faint) =
        (counted(&text(ON_THE_FLOOR, 0.5, 0.02), 512), counted(&text(ON_THE_FLOOR, 0.5, 0.02 / 128.0), 512));
    // The device's unit follows the lamp's radiance by powers of two, and what the floor receives is as its square radius.
    let share = faint.probed / usual.probed * 128.0 * 128.0;
    assert!((share - 1.0).abs() < 0.5, "{share}");
}

/// After the last event light is met and none is looked for: what is found beyond would be missing for ever.
#[test]
fn max_depth_ends_both() {
    // The floor, and the ball's two sides: light behind it takes three events.
    let at = |max_depth| counted_by(&text(AROUND_THE_LAMP, 1.2, 0.3), 64, Request::default().mis().depth(max_depth));
    assert_eq!(at(1), HiddenLight::default());
    let two = at(2);
    assert!(two.found() > 0.0 && two.probed() > 0.0 && (0.7..1.4).contains(&(two.found() / two.probed())), "{two:?}");
}

/// Renders a scene into `a.exr` of this folder.
fn command(folder: &Path, text: &str, more: &[&str]) -> Command {
    std::fs::write(folder.join("scene.ron"), text).expect("the scene is written");
    let device = &device::software().name.name;
    let usual = ["render", "scene.ron", "--json", "--device", device, "--light-paths", "off", "-o", "a.exr"];
    program::command(folder, &[&usual, more].concat())
}

/// The report, and what was said.
fn report(text: &str, more: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = ran(&mut command(folder.path(), text, more));
    (ran.json(), ran.stderr)
}

/// Light that is missing from images that look free of noise; and the same scenes with lamps that are met, where nothing is missing.
#[test]
fn images_that_lack_light_are_unreliable() {
    for (small, large, samples) in [
        (text(AROUND_THE_LAMP, 0.3, 0.002), text(ON_THE_FLOOR, 0.5, 0.8), "256"),
        (under_a_mirror(0.001), under_a_mirror(0.4), "256"),
        (under_a_sky(0.001), under_a_sky(0.4), "256"),
    ] {
        let (bulb, words) = report(&small, &["--spp", samples]);
        assert!(bulb["relative_error_bound"].as_f64().unwrap() < 0.05, "by its noise alone: {bulb}");
        assert_eq!(bulb["reliable"], false, "{small}\n{bulb}");
        assert!(words.contains("unreliable: mirrors, glass and other narrow lobes hide"), "{words}");
        let (lamp, words) = report(&large, &["--spp", samples]);
        assert!(lamp["reliable"] == true && !words.contains("unreliable"), "{large}\n{lamp}\n{words}");
    }
    // Where lights are left to chance everywhere, nothing is claimed.
    let (chance, _) = report(&under_a_mirror(0.001), &["--spp", "64", "--integrator", "bsdf"]);
    assert!(chance["light_stopped_by_glass"] == 0.0 && chance["light_met_through_glass"] == 0.0, "{chance}");
}

/// A lamp behind a narrow lobe of any kind, so small that next to no path finds it: the image looks free of noise, lacks much of its light, and is
/// called unreliable, at any number of samples and for each seed. The program of before called most of these images reliable.
#[test]
fn no_narrow_lobe_hides_a_lamp_in_silence() {
    let are_reliable = |text: &str, wanted: &[(u32, Range<u32>)]| {
        let mut found = Vec::new();
        let request = Request::default().mis().sobol().roulette();
        render_all(&scene(text), &request, wanted.iter().cloned(), |shot| {
            found.push(shot.film.verdict(0.05).reliable().expect("there is light"));
        });
        found
    };
    for (name, text) in narrow(0.002) {
        assert_eq!(are_reliable(&text, &[(0, 0..16), (1, 0..16), (2, 0..64), (3, 0..256)]), [false; 4], "{name}");
    }
    // Lobes that are wide need no such guard, and what is found is not called missing.
    for text in [under_a("Conductor(albedo: Rgb(0.9, 0.9, 0.9), roughness: 0.4)", 0.4), under_a(MIRROR, 0.8)] {
        assert_eq!(are_reliable(&text, &[(0, 0..1024)]), [true], "{text}");
    }
}

/// A light without size behind a mirror: the image that has not found it is unreliable. What a perfect mirror takes of it is found by light paths alone.
#[test]
fn lights_without_size_are_probed_where_paths_can_find_them() {
    let with_bulb = |mirror: &str| {
        let lamp = "Sphere(center: (0, 2.2, 0), radius: 0.4, material: \"lamp\"),";
        under_a(mirror, 0.4).replace(lamp, "PointLight(at: (0, 2.2, 0), intensity: (10, 10, 10)),")
    };
    let rough = counted(&with_bulb("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0.01)"), 64);
    assert!(rough.probed > 0.0 && rough.missing > 0.1 * rough.probed, "{rough:?}");
    let wider = counted(&with_bulb("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0.099)"), 1024);
    assert!((0.7..1.4).contains(&(wider.found / wider.probed)), "{wider:?}");
    let smooth = counted(&with_bulb(MIRROR), 64);
    assert!(smooth.probed > 0.0 && smooth.found == 0.0 && smooth.missing == 0.75 * smooth.probed, "{smooth:?}");
}

/// The counters bin by bin. (What reports say of them is in tests/unchanged.rs, of the scenes that ship and every way of linking.)
#[test]
fn counters_do_not_depend_on_how_stages_are_linked() {
    let by = |scatter, seed| counted_by(&under_a_sky(0.4), 16, Request::default().mis().scatter(scatter).seed(seed));
    let fused = by(Scatter::Fused, 0);
    assert!(fused == by(Scatter::Linked, 0) && fused == by(Scatter::Queues, 0) && fused != HiddenLight::default());
    assert!(fused != by(Scatter::Fused, 1), "another seed");
}

/// What a checkpoint says of its error is what the same image says at the end.
#[test]
fn checkpoints_hold_the_verdict() {
    for (text, reliable) in [(under_a_mirror(0.001), "0"), (under_a_mirror(0.8), "1")] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = command(folder.path(), &text, &["--spp", "10000000", "--checkpoint", "50ms", "--quiet"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        let begin = Instant::now();
        let found = loop {
            let image = read_exr(&folder.path().join("a.exr")).ok();
            let said = |name: &str| {
                let attributes = &image.as_ref()?.attributes;
                attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone())
            };
            // The first hundred samples may not know yet.
            let samples = said("gpu-rt:end_sample").and_then(|n| n.parse::<u32>().ok());
            if samples.is_some_and(|n| n > 256) || begin.elapsed() > Duration::from_secs(60) {
                break (said("gpu-rt:reliable"), said("gpu-rt:complete"));
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        assert_eq!(found, (Some(reliable.to_string()), Some("0".to_string())), "{text}");
    }
}
