//! Rooms from which light finds out after a thousand events, or after none.

use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, scene};
use crate::common::vectors::U;
use crate::table::Cell;

/// Standard errors that a mean is off by once in 1e6.
const NOISE: f64 = 4.9;

/// A lamp of radiance 1 and a radius r in the middle of a hollow sphere of radius 1 whose wall has this albedo.
fn room(albedo: f64, r: f64) -> String {
    format!(
        "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0.75, 0), look_at: (0.3, 1, 0), up: (0, 0, 1), vertical_fov: 60),
    background: Solid((0, 0, 0)),
    materials: {{
        \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)),
        \"wall\": Lambertian(albedo: Rgb({albedo:?}, {albedo:?}, {albedo:?})),
    }},
    objects: [
        Sphere(center: (0, 0, 0), radius: 1, material: \"wall\"),
        Sphere(center: (0, 0, 0), radius: {r:?}, material: \"lamp\"),
    ],
    render: (max_depth: 1000),
)"
    )
}

/// What its wall shows after so many events: a ray from the wall, cosine-distributed, meets the lamp with the probability f = r²,
/// else the wall again. L = a f (1 + a (1 - f) + …).
fn wall(albedo: f64, r: f64, depth: i32) -> f64 {
    let (f, ratio) = (r * r, albedo * (1.0 - r * r));
    albedo * f * (1.0 - ratio.powi(depth)) / (1.0 - ratio)
}

fn error(shot: &Shot, expected: f64) -> (f64, f64) {
    let mean = shot.mean_of_all();
    ((mean.value[0] / expected - 1.0).abs(), NOISE * mean.variance[0].sqrt() / expected)
}

/// The table's cells of albedos.
pub fn cells() -> Vec<Cell> {
    let mut all = vec![
        Cell::new(
            "albedo 0",
            "Radiance of a black wall in a lit room",
            0.0,
            "a surface that reflects nothing is black.",
        )
        .achieved(render(&scene(&room(0.0, 0.5)), &Request::spp(16).mis()).mean_of_all().value[0]),
    ];
    all.extend(by_scattering());
    all.extend(shallow());
    all.extend(deep());
    all.extend(roulette());
    all.extend(media());
    all
}

/// Every path meets the lamp, and brings a^k of it after k events: nothing is left to chance but the k.
fn by_scattering() -> Vec<Cell> {
    let r = 0.5;
    let dimmed = render(&scene(&room(0.999, r)), &Request::spp(64)).mean_of_all().value[0];
    [1.0, 1.0 - U, 1.0 - 1e-6]
        .map(|albedo| {
            let (error, _) = error(&render(&scene(&room(albedo, r)), &Request::spp(64)), wall(albedo, r, 1000));
            // 1 / f = 4 events on average, the deviation as much; the albedo as f32, a rounding an event, the sum of a run.
            let events = 1.0 / (r * r);
            let noise = NOISE * (1.0 - albedo) * events / (64.0f64 * 256.0).sqrt();
            let name = if albedo == 1.0 - U { "1 - 2^-24".to_string() } else { format!("{albedo}") };
            Cell::new(
                format!("albedo {name}, lamp of r/R = {r}, depth 1000"),
                "Relative error of the mean radiance in a closed room, without light sampling",
                noise + (2.0 * events + 8.0) * U,
                "a path with k events contributes a^k of the lamp's radiance, and the mean of k is 4: the rounding of the albedo \
                 and of a product for each event, 8 roundings of a run's sum, and 4.9 standard errors of (1 - a) k.",
            )
            .achieved(error)
            // As if an albedo stopped at 0.999, that paths end.
            .planted("albedo of at most 0.999", (dimmed / wall(albedo, r, 1000) - 1.0).abs())
        })
        .into()
}

/// A depth of 1 shows the wall by the lamp's light alone, one of 0 nothing of it.
fn shallow() -> Vec<Cell> {
    let (albedo, r) = (0.8, 0.5);
    let scene = scene(&room(albedo, r));
    let at = |depth: u32| render(&scene, &Request::spp(64).depth(depth));
    [1, 2, 3]
        .map(|depth| {
            let expected = wall(albedo, r, depth);
            let (achieved, noise) = error(&at(depth as u32), expected);
            Cell::new(
                format!("depth {depth}"),
                "Relative error of the mean radiance in a closed room at a small depth",
                noise + 8.0 * U,
                "4.9 standard errors as estimated by the film, and a rounding for each event.",
            )
            .achieved(achieved)
            .planted("one event more", error(&at(depth as u32 + 1), expected).0)
            .planted("one event less", error(&at(depth as u32 - 1), expected).0)
        })
        .into()
}

/// A lamp so small that a third of the paths is cut at depth 1000.
fn deep() -> Vec<Cell> {
    let r = 0.001f64.sqrt();
    let shallow = render(&scene(&room(1.0, r)), &Request::spp(16).depth(500)).mean_of_all().value[0];
    [1.0, 0.999]
        .map(|albedo| {
            let expected = wall(albedo, r, 1000);
            let (achieved, noise) = error(&render(&scene(&room(albedo, r)), &Request::spp(32)), expected);
            Cell::new(
                format!("albedo {albedo}, lamp of (r/R)² = 0.001, depth 1000"),
                "Relative error of the mean radiance in a closed room where `max_depth` ends paths",
                noise + 1000.0 * U,
                "4.9 standard errors as estimated by the film, and a rounding for each event.",
            )
            .achieved(achieved)
            .planted("depth of 500", (shallow / expected - 1.0).abs())
        })
        .into()
}

/// Albedos with roulette: the expectation stays.
fn roulette() -> Vec<Cell> {
    let r = 0.1;
    let unweighted = Overlay::new(&[("step/roulette", "throughput / q", "throughput")]);
    [0.1, 0.5, 0.9, 0.99]
        .map(|albedo| {
            let request = Request::spp(256).mis().roulette();
            let scene = scene(&room(albedo, r));
            let expected = wall(albedo, r, 1000);
            let (achieved, noise) = error(&render(&scene, &request), expected);
            let planted = &render_planted(&scene, &request, &unweighted);
            Cell::new(
                format!("albedo {albedo}, lamp of r/R = {r}, depth 1000"),
                "Relative error of the mean radiance in a closed room, with light sampling and roulette",
                noise + 1000.0 * U,
                "4.9 standard errors as estimated by the film, and a rounding for each event.",
            )
            .achieved(achieved)
            .planted("survivors that are worth no more", error(planted, expected).0)
        })
        .into()
}

/// Smoke that absorbs nothing, under a sky of radiance 1: not to be seen.
fn media() -> Vec<Cell> {
    let smoke = |albedo: f64, depth: f64| {
        let scene = scene(&format!(
            "Scene(
    image: (width: 16, height: 16),
    camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 25),
    background: Solid((1, 1, 1)),
    materials: {{}},
    objects: [Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: {:?}, albedo: Rgb({albedo:?}, {albedo:?}, {albedo:?}))],
    render: (max_depth: 1000),
)",
            0.5 * depth
        ));
        let shot = render(&scene, &Request::spp(16));
        shot.picture.rgb.iter().flatten().fold(0.0f64, |worst, &v| worst.max((f64::from(v) - 1.0).abs()))
    };
    [0.1, 1.0, 10.0]
        .map(|depth| {
            Cell::new(
                format!("albedo 1, optical depth {depth} across"),
                "Largest error of a pixel of smoke that absorbs nothing, under a sky of radiance 1",
                8.0 * U,
                "the roundings of a run's sum, because all paths end at the sky and contribute 1.",
            )
            .achieved(smoke(1.0, depth))
            .planted("albedo of 0.999", smoke(0.999, depth))
        })
        .into()
}
