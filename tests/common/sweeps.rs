//! Sweeps over settings, as `gpu-rt tradeoff` makes them, and scenes for them.

use super::render;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use gpu_rt::data::Sampler;
use gpu_rt::options::{INTEGRATOR, Integrator, ROULETTE, RenderOptions, SAMPLER, Switch};
use gpu_rt::scene::Scene;
use gpu_rt::tradeoff::extent::FullSize;
use gpu_rt::tradeoff::judge::{Judged, judge};
use gpu_rt::tradeoff::sweep::{Block, Setting, Sweep};
use gpu_rt::tradeoff::truth::Truth;

/// A room with a lamp in it and something of each kind of surface.
pub const ROOM: &str = "Scene(
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

pub const SKY: &str = "Scene(
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

/// A lamp that scattered rays seldom meet, and as much light whatever its radius is.
pub fn lamp(radius: f64, side: u32) -> String {
    let emit = 3.2 / (radius * radius);
    format!(
        "Scene(
    image: (width: {side}, height: {side}),
    camera: (look_from: (0, 2, 5), look_at: (0, 0.5, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)),
    materials: {{ \"grey\": Lambertian(albedo: Rgb(0.6, 0.6, 0.6)), \"lamp\": DiffuseLight(emit: Rgb({emit}, {emit}, {emit})) }},
    objects: [
        Quad(corner: (-4, 0, 4), u: (8, 0, 0), v: (0, 0, -8), material: \"grey\"),
        Sphere(center: (0, 0.5, 0), radius: 0.5, material: \"grey\"),
        Sphere(center: (1, 3, 1), radius: {radius}, material: \"lamp\"),
    ],
    render: (samples: 64, max_depth: 8),
)"
    )
}

pub fn scene(text: &str) -> Scene {
    render::scene(text)
}

/// The defaults, and three settings that are declared to change the noise alone.
pub fn unbiased(scene: &Scene) -> Vec<Setting> {
    let setting = |option, value: &str, options| Setting {
        option,
        value: value.to_string(),
        options,
        max_depth: scene.render.max_depth,
        scale: 1.0,
        denoise: false,
    };
    vec![
        setting(None, "", RenderOptions::default()),
        setting(Some(&INTEGRATOR), "bsdf", RenderOptions { integrator: Integrator::Bsdf, ..RenderOptions::default() }),
        setting(Some(&ROULETTE), "off", RenderOptions { roulette: Switch::Off, ..RenderOptions::default() }),
        setting(
            Some(&SAMPLER),
            "independent",
            RenderOptions { sampler: Sampler::Independent, ..RenderOptions::default() },
        ),
    ]
}

/// Rounds of measurement of all settings with a seed, however long they take.
pub fn measure(sweep: &mut Sweep<'_>, seed: u32, rounds: usize) {
    sweep.begin_again(seed);
    let until = Instant::now() + Duration::from_secs(3600);
    sweep.measure(until, rounds, &|| false, &mut |_, _| {}).expect("the device renders");
}

/// Makes the images of one of them brighter by a factor. The result is what they were.
pub fn plant(sweep: &mut Sweep<'_>, subject: usize, factor: f32) -> BTreeMap<u32, Vec<Block>> {
    let blocks = &mut sweep.subjects[subject].blocks;
    let before = blocks.clone();
    for block in blocks.values_mut().flatten() {
        block.image.as_flattened_mut().iter_mut().for_each(|v| *v *= factor);
    }
    before
}

pub fn judged(sweep: &mut Sweep<'_>, reference: Option<&Truth>) -> Judged {
    let full_size = FullSize::assumed(sweep, sweep.size);
    judge(sweep, reference, &full_size, "")
}
