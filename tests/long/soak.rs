//! Random valid scenes over the full grammar, rendered small: none crashes, no pixel is not finite, rays to lights change no
//! expectation, and memory does not grow. Each scene has a seed, which is printed before it renders.

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::everything::Everything;
use crate::common::render::{Mean, Request, render, scene_in};
use crate::common::stats::{Random, sidak, student_two_sided};
use gpu_rt::scene::Scene;

const ALPHA: f64 = 1e-6;
const SAMPLES: u32 = 64;
/// How many times the samples an alarm is confirmed with. A rare bright path looks like a difference among few samples.
const CONFIRMED_BY: u32 = 16;
/// The memory that a thousand scenes may add once the driver is warm, in MiB.
const GROWTH: f64 = 64.0;

/// Writes a scene.
struct Writer {
    random: Random,
    text: String,
}

impl Writer {
    fn among<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.random.below(choices.len())]
    }

    fn chance(&mut self, one_in: usize) -> bool {
        self.random.below(one_in) == 0
    }

    fn range(&mut self, low: f64, high: f64) -> String {
        format!("{:.4}", low + (high - low) * self.random.uniform())
    }

    fn triple(&mut self, low: f64, high: f64) -> String {
        format!("({}, {}, {})", self.range(low, high), self.range(low, high), self.range(low, high))
    }

    fn rgb(&mut self, low: f64, high: f64) -> String {
        format!("Rgb{}", self.triple(low, high))
    }

    /// A texture with values of at most `high`.
    fn texture(&mut self, high: f64) -> String {
        match self.random.below(8) {
            0 => format!(
                "Checker(scale: {}, even: {}, odd: {})",
                self.range(0.2, 2.0),
                self.triple(0.0, high),
                self.triple(0.0, high)
            ),
            1 => "Image(path: \"image.png\")".to_owned(),
            2 => format!("Noise(scale: {})", self.range(0.5, 8.0)),
            3 => format!("Marble(scale: {})", self.range(0.5, 8.0)),
            _ => self.rgb(0.05 * high, 0.9 * high),
        }
    }

    fn material(&mut self) -> String {
        match self.random.below(6) {
            5 => {
                let roughness =
                    self.among(&["", ", roughness: 0", ", roughness: 0.01", ", roughness: 0.3", ", roughness: 1"]);
                match self.random.below(4) {
                    3 => format!(
                        "Pbr(base_color: {}, metallic: {}{roughness})",
                        self.texture(1.0),
                        self.among(&["0", "0.5", "1"])
                    ),
                    2 => format!("RoughDielectric(ior: {}{roughness})", self.among(&["0.7", "1", "1.1", "1.5", "2.4"])),
                    0 => format!("Conductor(albedo: {}{roughness})", self.texture(1.0)),
                    _ => format!("Conductor(eta: {}, k: {}{roughness})", self.triple(0.1, 3.0), self.triple(0.0, 5.0)),
                }
            }
            0 | 1 => format!("Lambertian(albedo: {})", self.texture(1.0)),
            2 => {
                let fuzz = self.among(&["", ", fuzz: 0", ", fuzz: 0.1", ", fuzz: 0.5", ", fuzz: 1"]);
                format!("Metal(albedo: {}{fuzz})", self.texture(1.0))
            }
            3 => format!("Dielectric(ior: {})", self.among(&["0.7", "1", "1.1", "1.5", "2.4"])),
            _ => {
                let sides = self.among(&["", ", two_sided: true", ", two_sided: false"]);
                format!("DiffuseLight(emit: {}{sides})", self.texture(3.0))
            }
        }
    }

    fn transforms(&mut self) -> String {
        let mut list = Vec::new();
        for _ in 0..self.random.below(4) {
            list.push(match self.random.below(6) {
                0 => format!("Translate({})", self.triple(-1.0, 1.0)),
                1 => format!("Scale({})", self.range(0.5, 1.5)),
                2 => format!("RotateX({})", self.range(-180.0, 180.0)),
                3 => format!("RotateY({})", self.range(-180.0, 180.0)),
                4 => format!("RotateZ({})", self.range(-180.0, 180.0)),
                _ => format!("Rotate(axis: {}, degrees: {})", self.triple(0.1, 1.0), self.range(-180.0, 180.0)),
            });
        }
        format!("[{}]", list.join(", "))
    }

    /// A shape; of a material if it is given, and closed if it is not.
    fn shape(&mut self, material: Option<usize>) -> String {
        let with = material.map_or(String::new(), |number| format!(", material: \"m{number}\""));
        match self.random.below(if material.is_some() { 5 } else { 3 }) {
            0 => format!("Sphere(center: {}, radius: {}{with})", self.triple(-1.5, 1.5), self.range(0.3, 1.0)),
            1 => format!("Box(min: {}, max: {}{with})", self.triple(-1.5, -0.2), self.triple(0.2, 1.2)),
            // With texture coordinates.
            2 => format!("Mesh(path: \"octahedron.obj\"{with})"),
            3 => format!(
                "Disk(center: {}, normal: {}, radius: {}{with})",
                self.triple(-1.5, 1.5),
                self.triple(0.1, 1.0),
                self.range(0.3, 1.0)
            ),
            _ => {
                let [x, y, z] = [self.range(0.5, 2.0), self.range(-0.4, 0.4), self.range(0.5, 2.0)];
                format!("Quad(corner: {}, u: ({x}, {y}, 0), v: (0, {y}, {z}){with})", self.triple(-1.5, 0.5))
            }
        }
    }

    fn object(&mut self, materials: usize, depth: usize) -> String {
        match self.random.below(if depth < 3 { 8 } else { 4 }) {
            4 | 5 => format!("Transformed(by: {}, object: {})", self.transforms(), self.object(materials, depth + 1)),
            6 => {
                let inner: Vec<String> = (0..self.random.below(4)).map(|_| self.object(materials, depth + 1)).collect();
                format!("Group([{}])", inner.join(", "))
            }
            7 => {
                let boundary = self.shape(None);
                let boundary = match self.chance(2) {
                    true => boundary,
                    false => format!("Transformed(by: {}, object: {boundary})", self.transforms()),
                };
                let albedo = if self.chance(4) { self.texture(1.0) } else { self.rgb(0.2, 0.95) };
                // Media have no surface for an image.
                let albedo = if albedo.starts_with("Image") { self.rgb(0.2, 0.95) } else { albedo };
                let anisotropy = self.among(&["", ", anisotropy: 0", ", anisotropy: 0.6", ", anisotropy: -0.4"]);
                format!("Medium(boundary: {boundary}, density: {}, albedo: {albedo}{anisotropy})", self.range(0.1, 4.0))
            }
            _ => {
                let material = self.random.below(materials);
                self.shape(Some(material))
            }
        }
    }

    fn scene(&mut self) {
        let background = match self.random.below(4) {
            0 => format!("Solid({})", self.triple(0.0, 1.0)),
            1 => "Solid((0, 0, 0))".to_owned(),
            2 => format!("Gradient(bottom: {}, top: {})", self.triple(0.0, 1.0), self.triple(0.0, 1.0)),
            _ => "Image(path: \"image.png\")".to_owned(),
        };
        let count = 1 + self.random.below(6);
        let materials: Vec<String> = (0..count).map(|number| format!("\"m{number}\": {}", self.material())).collect();
        let objects: Vec<String> = (0..self.random.below(9)).map(|_| self.object(count, 0)).collect();
        let lens = match self.chance(3) {
            true => format!(", aperture: {}, focus_distance: {}", self.range(0.0, 0.5), self.range(2.0, 8.0)),
            false => String::new(),
        };
        let (from, at) = (self.triple(2.0, 5.0), self.triple(-0.5, 0.5));
        let (fov, depth) = (self.range(20.0, 90.0), self.among(&["0", "1", "4", "12", "50"]));
        write!(
            self.text,
            "(
    image: (width: 16, height: 16),
    camera: (look_from: {from}, look_at: {at}, vertical_fov: {fov}{lens}),
    background: {background},
    materials: {{{}}},
    objects: [{}],
    render: (samples: {SAMPLES}, max_depth: {depth}),
)",
            materials.join(", "),
            objects.join(",\n        ")
        )
        .expect("a string takes text");
    }
}

/// The text of the scene of a seed.
fn text(seed: u64) -> String {
    let mut writer = Writer { random: Random(seed), text: String::new() };
    writer.scene();
    writer.text
}

/// The smallest probability of the difference between the means of two images, of three channels, by Welch's test.
fn p(a: &Mean, b: &Mean) -> f64 {
    let of_channel = |c: usize| {
        let variance = a.variance[c] + b.variance[c];
        // The mean of some ten thousand values near each other is rounded.
        let difference = ((a.value[c] - b.value[c]).abs() - 1e-5 * a.value[c].max(b.value[c])).max(0.0);
        let part = |of: &Mean| if of.variance[c] > 0.0 { of.variance[c].powi(2) / of.degrees[c] } else { 0.0 };
        let parts = part(a) + part(b);
        let degrees = if parts > 0.0 { variance * variance / parts } else { f64::INFINITY };
        if difference == 0.0 { 1.0 } else { student_two_sided(difference / variance.sqrt(), degrees) }
    };
    (0..3).map(of_channel).fold(1.0, f64::min)
}

/// Renders by both integrators; the probability of their difference. Every value is finite and no sample is rejected.
fn compared(scene: &Scene, samples: u32, seed: u32, brighter: f64) -> f64 {
    let request = || Request::spp(samples).roulette();
    let [bsdf, mut mis] =
        [request().seed(seed), request().mis().seed(seed + 1)].map(|request| render(scene, &request).mean_of_all());
    mis.value = mis.value.map(|value| value * brighter);
    p(&bsdf, &mis)
}

/// The words of an alarm about a scene, if it is confirmed.
fn alarm(folder: &Path, seed: u64, brighter: f64) -> Option<String> {
    let text = text(seed);
    let scene = scene_in(folder, &text);
    let alpha = sidak(ALPHA, 3);
    let first = compared(&scene, SAMPLES, 1, brighter);
    if first >= alpha {
        return None;
    }
    let second = compared(&scene, CONFIRMED_BY * SAMPLES, 3, brighter);
    println!("soak {seed}: p = {first:.1e}, and with {CONFIRMED_BY} times the samples {second:.1e}");
    (second < alpha).then(|| format!("seed {seed}: mis and bsdf differ, p = {second:.1e}\n{text}"))
}

/// The memory of this process, in MiB, where the system says it.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok().map(|kib: f64| kib / 1024.0)
}

/// Runs the scenes of some seeds: the first `WARM`, and then others until the time is up.
fn soak(seeds: impl Iterator<Item = u64>, limit: Duration) {
    // By then a device keeps as many kernels as it may, and a driver has compiled large ones.
    const WARM: usize = 100;
    let everything = Everything::new();
    let (mut count, mut warm, mut alarms) = (0, None, Vec::new());
    for seed in seeds {
        if warm.is_some_and(|(since, _): (Instant, _)| since.elapsed() > limit) {
            break;
        }
        println!("soak {seed}: {:?} MiB", memory().map(f64::round));
        alarms.extend(alarm(everything.folder(), seed, 1.0));
        count += 1;
        if count == WARM {
            warm = Some((Instant::now(), memory()));
        }
    }
    println!("soak: {count} scenes, {} confirmed alarms", alarms.len());
    assert!(alarms.is_empty(), "{}", alarms.join("\n"));
    if let (Some((_, Some(warm))), Some(now)) = (warm, memory()) {
        let most = warm + GROWTH * (1.0 + (count - WARM) as f64 / 1000.0);
        println!("soak: {warm:.0} MiB after {WARM} scenes, {now:.0} MiB now");
        assert!(now < most, "the memory has grown from {warm} MiB to {now} MiB");
    }
}

fn number_of(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().unwrap_or_else(|_| panic!("{name}={value}: a number")))
}

#[test]
fn some_random_scenes_render_without_a_fault() {
    soak(1..9, Duration::MAX);
}

/// Whether 5 % of a scene's light stand out of its noise: some scenes are black, and some are noisy. 5 % are 12 standard errors of the
/// difference of two images, so that an alarm at 7 of them is missed once in 10^6 scenes.
fn shows_a_difference(scene: &Scene) -> bool {
    let mean = render(scene, &Request::spp(SAMPLES).roulette().seed(1)).mean_of_all();
    (0..3).any(|c| 0.05 * mean.value[c] > 12.0 * (2.0 * mean.variance[c]).sqrt())
}

#[test]
fn the_soak_finds_a_difference() {
    let everything = Everything::new();
    let shown = |seed: &u64| shows_a_difference(&scene_in(everything.folder(), &text(*seed)));
    let shown: Vec<u64> = (1..9).filter(shown).collect();
    // 5 % of the light.
    let missed = |seed: &u64| alarm(everything.folder(), *seed, 1.05).is_none();
    let missed: Vec<u64> = shown.iter().copied().filter(missed).collect();
    println!("soak: 5 % show in {shown:?}, and are missed in {missed:?}");
    assert!(shown.len() >= 4 && missed.is_empty());
}

/// `make soak`.
#[test]
#[ignore = "takes half an hour"]
fn many_random_scenes_render_without_a_fault() {
    let (first, seconds) = (number_of("GPU_RT_SOAK_SEED", 1000), number_of("GPU_RT_SOAK_SECONDS", 60));
    soak(first.., Duration::from_secs(seconds));
}
