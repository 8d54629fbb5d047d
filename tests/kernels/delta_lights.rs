//! light/delta: what lights without size send to points at any distance and angle, against f64.

use glam::DVec3;
use gpu_rt::data::DeltaLight;
use gpu_rt::flatten::flatten;
use gpu_rt::options::RenderOptions;
use gpu_rt::scene::Falloff;

use crate::common::kernel::{Fault, Kernel, Setup, array};
use crate::common::render::scene;
use crate::common::rows::rows;
use crate::common::scenes::triple;
use crate::common::stats::Random;
use crate::common::vectors::{U, decades, exact, rounded, unit};

rows! {
    struct In { from: [f32; 3], light: u32 }

    struct Out {
        direction: [f32; 3], distance2: f32,
        intensity: [f32; 3], end: f32,
    }
}

/// A spot light of the scene file, with its axis and angles in degrees.
struct Spot {
    at: DVec3,
    axis: DVec3,
    inner: f64,
    outer: f64,
    falloff: Falloff,
}

impl Spot {
    /// The share of its light at this angle, and how far it may be off: both unit vectors by 6 u, and the angles, or 1 - cos, by roundings.
    fn share(&self, angle: f64) -> (f64, f64) {
        let height = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
        let [inner, outer] = [self.inner, self.outer].map(f64::to_radians);
        let linear = ((outer - angle) / (outer - inner)).clamp(0.0, 1.0);
        let way = height(outer) - height(inner);
        let share = ((height(outer) - height(angle)) / way).clamp(0.0, 1.0);
        let off = (12.0 * U * (2.0 * height(angle)).sqrt() + 4.0 * U * (height(angle) + height(outer))) / way;
        match self.falloff {
            Falloff::Gltf => (share * share, 2.0 * share * off + 8.0 * U),
            Falloff::Linear => (linear, (12.0 * U + 12.0 * U * angle + 2.0 * U * outer) / (outer - inner) + 8.0 * U),
            Falloff::Smooth => {
                (share * share * (3.0 - 2.0 * share), (6.0 * share * (1.0 - share) + off) * off + 8.0 * U)
            }
        }
    }
}

fn spots(random: &mut Random, falloff: Falloff) -> Vec<Spot> {
    let wide = [(0.0, 45.0), (20.0, 30.0), (1.0, 89.0), (90.0, 90.5), (0.0, 180.0), (170.0, 180.0)];
    let angles = [(0.0, 0.5), (0.09, 0.1), (0.0, 0.01), (0.009, 0.01)].into_iter().chain(wide);
    let spot = |(inner, outer)| Spot { at: unit(random), axis: unit(random), inner, outer, falloff };
    angles.map(spot).collect()
}

/// The lights as the device has them, by the scene file: spots, then a point light, then a directional one.
fn on_device(spots: &[Spot], direction: DVec3) -> Vec<DeltaLight> {
    let text = |spot: &Spot| {
        let (at, towards) = (triple(spot.at), triple(spot.at + spot.axis));
        let Spot { inner, outer, falloff, .. } = spot;
        let angles = format!("inner: {inner:?}, outer: {outer:?}, falloff: {falloff:?}");
        format!("SpotLight(at: {at}, towards: {towards}, intensity: (1, 2, 4), {angles}),")
    };
    let lights: String = spots.iter().map(text).collect();
    let scene = scene(&format!(
        "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vertical_fov: 40),
        background: Solid((0, 0, 0)), materials: {{\"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5))}},
        objects: [Quad(corner: (-0.75, -0.75, -0.75), u: (1, 0, 0), v: (0, 1, 0), material: \"grey\"), {lights}
            PointLight(at: (0.1, 0.2, 0.3), intensity: (1, 2, 4)),
            DirectionalLight(direction: {}, irradiance: (1, 2, 4)),
        ])",
        triple(direction)
    ));
    let flat = flatten(&scene, (8, 8), &RenderOptions::default()).expect("it flattens");
    assert_eq!(flat.delta_lights.len(), spots.len() + 2);
    flat.delta_lights
}

/// The most that an answer is off by, over its bound: the direction, the squared distance, and the intensity. `linked` says whether the kernel knows
/// other falloffs than that of glTF.
fn worst(falloff: Falloff, linked: bool, replaced: &[Fault<'_>]) -> [f64; 3] {
    let mut random = Random(911);
    let spots = spots(&mut random, falloff);
    let sun = DVec3::new(1.0, -2.0, 0.5).normalize();
    let lights = on_device(&spots, sun);
    let (of_point, of_sun) = (spots.len(), spots.len() + 1);
    let full = exact(lights[of_sun].colour);
    let mut rows = Vec::new();
    for (light, at) in spots.iter().map(|spot| spot.at).chain([DVec3::new(0.1, 0.2, 0.3), DVec3::ZERO]).enumerate() {
        for _ in 0..2000 {
            let away = decades(&mut random, -4.0, 6.0);
            // Half of them where the beam falls.
            let aside = spots.get(light).filter(|_| random.below(2) == 0).map(|spot| {
                let angle = (spot.inner + random.uniform() * (spot.outer - spot.inner)).to_radians();
                let (x, _) = spot.axis.any_orthonormal_pair();
                angle.cos() * spot.axis + angle.sin() * x
            });
            let way = aside.unwrap_or_else(|| unit(&mut random));
            rows.push(In { from: rounded(at + away * way), light: light as u32 });
        }
    }
    let setup = Setup { replaced, facts: &[("falloff", linked)], ..Setup::default() };
    let kernel = Kernel::with("test/delta_light", &setup);
    let found = kernel.run_with::<_, Out>(&rows, rows.len(), &[array("shapes", &lights)]);
    let mut worst = [0.0f64; 3];
    let mut note = |which: usize, off: f64, bound: f64| worst[which] = worst[which].max(off / bound);
    for (row, out) in rows.iter().zip(&found) {
        let light = &lights[row.light as usize];
        let number = row.light as usize;
        let way = if number == of_sun { -sun } else { exact(light.position) - exact(row.from) };
        // A rounding of each difference, and four for the square root and the products.
        note(0, (exact(out.direction) - way.normalize()).length(), 6.0 * U);
        note(1, (f64::from(out.distance2) / way.length_squared() - 1.0).abs(), 8.0 * U);
        let full = if number == of_sun { full } else { exact(light.colour) };
        let (share, off) = match spots.get(number) {
            Some(spot) => {
                let way = way.normalize();
                spot.share(2.0 * (way + spot.axis).length().atan2((way - spot.axis).length()))
            }
            None => (1.0, 8.0 * U),
        };
        note(2, (exact(out.intensity) / full - share).abs().max_element(), off);
        let end = f64::from(out.end) / way.length();
        assert!(number == of_sun || (0.499..=1.0).contains(&end), "{row:?} {out:?}");
        assert!(number == of_point || out.distance2 > 0.0, "{row:?} {out:?}");
    }
    worst
}

#[test]
fn lights_without_size_send_what_their_definition_says() {
    use Falloff::{Gltf, Linear, Smooth};
    for (falloff, linked) in [(Gltf, false), (Gltf, true), (Linear, true), (Smooth, true)] {
        let found = worst(falloff, linked, &[]);
        assert!(found.iter().all(|worst| *worst < 1.0), "{falloff:?}, {linked}: {found:?}");
    }
    for (falloff, linked, right, wrong) in [
        (Gltf, true, "(share * share)", "share"),
        (Linear, false, "(share * share)", "share"),
        // In narrow beams, the angle of a cosine has no digits.
        (
            Linear,
            true,
            "2.0 * angle_of(length(apart), length(direction - light.axis))",
            "acos(clamp(-dot(direction, light.axis), -1.0, 1.0))",
        ),
        (Smooth, true, "3.0 - 2.0 * share", "1.0"),
    ] {
        let planted = worst(falloff, linked, &[("light/falloff", right, wrong)]);
        assert!(planted[2] > 50.0, "{wrong} is not found: {planted:?}");
    }
    let planted = worst(
        Gltf,
        false,
        &[
            ("light/delta", "inverseSqrt(distance2), distance2)", "inverseSqrt(distance2), sqrt(distance2))"),
            ("light/falloff", "(share * share)", "share"),
        ],
    );
    assert!(planted[2] > 1e3, "a falloff without its square is not found: {planted:?}");
    assert!(planted[1] > 1e3, "a distance without its square is not found: {planted:?}");
}

/// At the light, an ulp beside it, and beyond what f32 can square: numbers, and no light nearer than is said.
#[test]
fn points_at_a_light_get_numbers() {
    for (falloff, linked) in [(Falloff::Gltf, false), (Falloff::Linear, true), (Falloff::Smooth, true)] {
        points_get_numbers(falloff, linked);
    }
}

fn points_get_numbers(falloff: Falloff, linked: bool) {
    let lights = on_device(&spots(&mut Random(912), falloff), DVec3::NEG_Y);
    let facts = &[("falloff", linked)];
    let kernel = Kernel::with("test/delta_light", &Setup { facts, ..Setup::default() });
    let mut rows = Vec::new();
    for (number, light) in lights.iter().enumerate() {
        for away in [0.0, 1e-30, 1e-20, 2e-13, 2e-12, 1e-7, 1e-6, 1.0, 1e6, 1e15] {
            for axis in [DVec3::X, DVec3::NEG_Y, DVec3::ONE] {
                rows.push(In { from: rounded(exact(light.position) + away * axis), light: number as u32 });
            }
        }
    }
    let found = kernel.run_with::<_, Out>(&rows, rows.len(), &[array("shapes", &lights)]);
    for (row, out) in rows.iter().zip(&found) {
        let numbers = out.direction.iter().chain(&out.intensity).chain([&out.distance2, &out.end]);
        assert!(numbers.clone().all(|x| x.is_finite()), "{row:?} {out:?}");
        assert!((exact(out.direction).length() - 1.0).abs() < 1e-6, "{row:?} {out:?}");
        let light = &lights[row.light as usize];
        let away = (exact(light.position) - exact(row.from)).length();
        if light.has_position > 0.0 {
            assert_eq!(out.distance2 > 0.0, away > 2f64.powi(-40), "{row:?} {out:?}");
        }
    }
}
