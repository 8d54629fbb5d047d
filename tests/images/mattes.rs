//! `--aov cryptomatte`: shares of pixels against closed forms and against the light of lamps, and counts that depend on no order.

use gpu_rt::aov::{Aovs, id_of};
use gpu_rt::film::Film;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{Filter, Scatter};

use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_job, render_onto, render_planted, scene};

fn with_mattes(request: Request) -> Request {
    request.with(|options| options.aov.set(Aovs::parse("cryptomatte").expect("it is a name")))
}

/// The share of a name in each pixel of a film, by the channels of its file.
fn shares(film: &Film, layer: &str, name: &str) -> Vec<f64> {
    let channels = film.aovs().channels();
    let value = |pixel: usize, rank: usize, of_share: usize| {
        let (number, letter) = (rank / 2, ["R", "G", "B", "A"][rank % 2 * 2 + of_share]);
        let name = format!("{layer}{number:02}.{letter}");
        let channel = channels.iter().find(|channel| channel.name == name).expect("the film has it");
        film.channel(pixel, channel)
    };
    let share = |pixel: usize| {
        let ranks = (0..6).filter(|rank| value(pixel, *rank, 0).to_bits() == id_of(name));
        ranks.map(|rank| f64::from(value(pixel, rank, 1))).sum()
    };
    (0..film.width() as usize * film.height() as usize).map(share).collect()
}

fn lost(film: &Film) -> Vec<f32> {
    let channels = film.aovs().channels();
    let channel = channels.iter().find(|channel| channel.name == "crypto_lost.Y").expect("the film has it");
    (0..film.width() as usize * film.height() as usize).map(|pixel| film.channel(pixel, channel)).collect()
}

fn words(shot: &Shot) -> Vec<Vec<u16>> {
    (0..shot.picture.rgb.len()).map(|pixel| shot.film.words(pixel)).collect()
}

/// Whether shares of so many samples are those that are expected: each within six standard errors.
fn agree(found: &[f64], expected: &[f64], samples: f64) -> bool {
    let bound = |p: f64| 6.0 * (p * (1.0 - p) / samples).max(0.0).sqrt() + 1e-6;
    found.iter().zip(expected).all(|(found, p)| (found - p).abs() <= bound(p.clamp(1e-3, 1.0 - 1e-3)))
}

/// Two quads that meet at the slanted line x = `SLANT` y + `EDGE`, in pixels from the middle of 12 by 8.
const SLANT: f64 = 0.3;
const EDGE: f64 = 0.37;

fn two_quads() -> String {
    let quad = |name: &str, x: f64, material: &str| {
        format!(
            "Named(name: \"{name}\", object: Quad(corner: ({}, -100, 0), u: (200, 0, 0), v: ({}, 200, 0), material: \"{material}\"))",
            x + EDGE - 100.0 * SLANT,
            200.0 * SLANT
        )
    };
    format!(
        "Scene(
            image: (width: 12, height: 8),
            camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), projection: Orthographic(height: 8)),
            background: Solid((1, 1, 1)),
            materials: {{ \"paper\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"ink\": Lambertian(albedo: Rgb(0, 0, 0)) }},
            objects: [{}, {}],
            render: (samples: 8, max_depth: 2),
        )",
        quad("left", -200.0, "paper"),
        quad("right", 0.0, "ink")
    )
}

/// The share of the left quad in each pixel under a filter, by a quadrature.
fn share_of_left(filter: Filter, edge: f64) -> Vec<f64> {
    const STEPS: usize = 400;
    let (radius, value): (f64, fn(f64, f64) -> f64) = match filter {
        Filter::Tent => (1.0, |x, y| (1.0 - x.abs()) * (1.0 - y.abs())),
        Filter::Gauss => (1.5, |x, y| if x * x + y * y < 2.25 { (-2.0 * (x * x + y * y)).exp() } else { 0.0 }),
        _ => (0.5, |_, _| 1.0),
    };
    let point = |i: usize| radius * (2.0 * (i as f64 + 0.5) / STEPS as f64 - 1.0);
    let share = |(column, row): (usize, usize)| {
        let (x, y) = (column as f64 + 0.5 - 6.0, 4.0 - row as f64 - 0.5);
        let (mut seen, mut all) = (0.0, 0.0);
        for (dx, dy) in (0..STEPS * STEPS).map(|i| (point(i % STEPS), point(i / STEPS))) {
            let weight = value(dx, dy);
            all += weight;
            seen += if x + dx < SLANT * (y + dy) + edge { weight } else { 0.0 };
        }
        seen / all
    };
    (0..8).flat_map(|row| (0..12).map(move |column| (column, row))).map(share).collect()
}

/// Each pixel at the edge has its share of both, as the filter weighs it. An edge that is off by a tenth of a pixel is found.
#[test]
fn two_objects_that_meet_in_a_pixel_add_up_to_1() {
    let scene = scene(&two_quads());
    for (filter, scatter) in
        [(Filter::Box, Scatter::Fused), (Filter::Tent, Scatter::Linked), (Filter::Gauss, Scatter::Queues)]
    {
        let request = with_mattes(Request::spp(4096)).scatter(scatter).with(|options| options.filter = filter);
        let film = render(&scene, &request).film;
        let (left, right) = (shares(&film, "CryptoObject", "left"), shares(&film, "CryptoObject", "right"));
        assert!(left.iter().zip(&right).all(|(left, right)| (left + right - 1.0).abs() < 1e-6));
        assert_eq!(shares(&film, "CryptoMaterial", "paper"), left);
        assert!(left.iter().any(|share| (0.2..0.8).contains(share)));
        assert!(agree(&left, &share_of_left(filter, EDGE), 4096.0), "{filter:?}: {left:?}");
        assert!(!agree(&left, &share_of_left(filter, EDGE + 0.1), 4096.0), "{filter:?}");
        assert_eq!(film.matte_pixels_lost(), Some(0));
    }
}

/// Samples that are not finite have their share of the mattes: seven of ten are not here.
#[test]
fn samples_that_the_film_rejects_count() {
    let infinite = "hit.colour + vec3<f32>(bitcast<f32>(select(0u, 0x7f800000u, u.x < 0.7)))";
    let planted = Overlay::new(&[("material/lambertian", "hit.colour", infinite)]);
    let film = render_planted(&scene(&two_quads()), &with_mattes(Request::spp(1024)), &planted).film;
    let rejected = film.totals.rejected.total() as f64 / film.totals.paths as f64;
    assert!((0.65..0.75).contains(&rejected), "{rejected}");
    let (left, right) = (shares(&film, "CryptoObject", "left"), shares(&film, "CryptoObject", "right"));
    assert!(left.iter().zip(&right).all(|(left, right)| (left + right - 1.0).abs() < 1e-6));
    assert!(agree(&left, &share_of_left(Filter::Box, EDGE), 1024.0), "{left:?}");
}

/// Lamps of radiance 1 before a black background: a pixel's light is the share of its samples that see one, through any lens and in motion, and
/// where holes let the camera see past a surface.
#[test]
fn mattes_are_what_the_camera_sees_in_motion_out_of_focus_and_through_holes() {
    let text = |camera: &str, objects: &str| {
        format!(
            "Scene(
                image: (width: 16, height: 12),
                camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), vertical_fov: 40{camera}),
                background: Solid((0, 0, 0)),
                materials: {{
                    \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)),
                    \"holes\": Lambertian(albedo: Rgb(0, 0, 0), alpha: 0.3),
                }},
                objects: [{objects}],
                render: (samples: 64, max_depth: 1),
            )"
        )
    };
    let ball = "Named(name: \"ball\", object: Sphere(center: (0.3, 0.2, 0), radius: 1, material: \"lamp\"))";
    let flies = "Named(name: \"ball\", object: Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((1.5, 0.4, 0))])], \
                 object: Sphere(center: (-0.5, 0, 0), radius: 1, material: \"lamp\")))";
    let veil =
        "Named(name: \"veil\", object: Quad(corner: (-9, -9, 2), u: (18, 0, 0), v: (0, 18, 0), material: \"holes\"))";
    for (camera, objects) in [
        (", aperture: 1.5, focus_distance: 3", ball.to_string()),
        (", shutter: (0, 1)", flies.to_string()),
        ("", format!("{ball}, {veil}")),
    ] {
        let shot = render(&scene(&text(camera, &objects)), &with_mattes(Request::spp(64)));
        let (found, light) = (shares(&shot.film, "CryptoObject", "ball"), shot.picture.rgb);
        let is_light = |(share, rgb): (&f64, &[f32; 3])| (share - f64::from(rgb[0])).abs() < 1e-6;
        assert!(found.iter().zip(&light).all(is_light), "{camera}: {found:?} {light:?}");
        assert!(found.iter().filter(|share| (0.05..0.95).contains(*share)).count() > 20, "{camera}: {found:?}");
        // The control: the share of another name is not.
        assert!(!shares(&shot.film, "CryptoObject", "veil").iter().zip(&light).all(is_light));
    }
}

/// A smooth pane has the share that it mirrors, 4 % at this angle; what is behind it has the rest.
#[test]
fn a_pane_has_the_share_that_it_mirrors() {
    let scene = scene(
        "Scene(
            image: (width: 4, height: 4),
            camera: (look_from: (0, 0, 50), look_at: (0, 0, 0), vertical_fov: 1),
            background: Solid((0, 0, 0)),
            materials: { \"lamp\": DiffuseLight(emit: Rgb(1, 1, 1)), \"pane\": ThinDielectric(ior: 1.5) },
            objects: [
                Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0), material: \"lamp\"),
                Quad(corner: (-9, -9, 2), u: (18, 0, 0), v: (0, 18, 0), material: \"pane\"),
            ],
            render: (samples: 64, max_depth: 2),
        )",
    );
    let film = render(&scene, &with_mattes(Request::spp(1 << 14))).film;
    let (lamp, pane) = (shares(&film, "CryptoObject", "objects[0]"), shares(&film, "CryptoMaterial", "pane"));
    assert!(lamp.iter().zip(&pane).all(|(lamp, pane)| (lamp + pane - 1.0).abs() < 1e-6));
    let expected = |share: f64| agree(&pane, &vec![share; pane.len()], f64::from(1 << 14));
    assert!(expected(0.04) && !expected(0.05), "{pane:?}");
}

/// A pixel with this number of tiny balls, of so many names.
fn crowd(balls: usize, names: usize) -> String {
    let ball = |number: usize| {
        let (x, y) = (number % 7, number / 7);
        format!(
            "Named(name: \"ball {}\", object: Sphere(center: ({x}.5, {y}.5, 0), radius: 0.45, material: \"grey\")),",
            number % names
        )
    };
    let balls: String = (0..balls).map(ball).collect();
    format!(
        "Scene(
            image: (width: 9, height: 1),
            camera: (look_from: (3.5, 3.5, 9), look_at: (3.5, 3.5, 0), projection: Orthographic(height: 9)),
            background: Solid((1, 1, 1)),
            materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
            objects: [{balls}],
            render: (samples: 8, max_depth: 2),
        )"
    )
}

/// Sixteen names of a pixel are exact; of more, the samples of some names are counted as lost, and none is counted twice or not at all.
#[test]
fn names_beyond_sixteen_are_counted_as_lost() {
    const SAMPLES: u32 = 1024;
    let film = |balls, names| render(&scene(&crowd(balls, names)), &with_mattes(Request::spp(SAMPLES))).film;
    let kept = film(40, 16);
    assert_eq!((kept.matte_pixels_lost(), lost(&kept)[4]), (Some(0), 0.0));
    let found = film(40, 40);
    assert_eq!(found.matte_pixels_lost(), Some(1));
    assert!(lost(&found)[4] > 0.0 && lost(&found).iter().filter(|lost| **lost > 0.0).count() == 1);
    // One material for all: its matte counts the samples that hit any ball.
    let hits = shares(&found, "CryptoMaterial", "grey")[4] * f64::from(SAMPLES);
    assert!(hits > 250.0, "{hits}");
    let state = found.words(4);
    let names = found.word_names();
    let counted = |what: &str| {
        let is_low = |name: &String| name.starts_with(what) && name.ends_with(".0");
        let value = |low: usize| u64::from(state[low]) | u64::from(state[low + 1]) << 16;
        names.iter().enumerate().filter(|(_, name)| is_low(name)).map(|(low, _)| value(low)).sum::<u64>()
    };
    let (known, lost) = (counted("matte0.samples"), counted("matte0.lost"));
    assert_eq!((known + lost) as f64, hits.round());
    assert!(known > 0 && lost > 0 && counted("matte1.lost") == 0);
}

/// The same words with any slots, tiles and split into parts, however the stages are linked.
#[test]
fn mattes_depend_on_no_order() {
    let text = crowd(40, 16).replace("width: 9, height: 1", "width: 21, height: 21");
    let scene = scene(&text);
    let request = with_mattes(Request::spp(24)).sobol();
    let full = render(&scene, &request);
    let expected = words(&full);
    assert_eq!(full.film.matte_pixels_lost(), Some(0));
    for scatter in [Scatter::Linked, Scatter::Queues] {
        assert!(words(&render(&scene, &request.clone().scatter(scatter))) == expected, "{scatter:?}");
    }
    let few = request.clone().with(|options| options.slots = Some(100));
    assert!(words(&render(&scene, &few)) == expected);
    let part = |samples| render(&scene, &Request { samples: Some(samples), ..request.clone() });
    for order in [[0..8, 8..24], [8..24, 0..8]] {
        let [mut first, second] = order.map(part);
        assert!(words(&first) != expected);
        first.film.merge(&second.film).expect("they fit");
        assert!(words(&first) == expected);
    }
    // In tiles, each of which is read and added for itself.
    let job = Job { size: (21, 21), max_depth: 2, seed: 0, first_sample: 0, goal: Goal::Samples(24) };
    let mut film = full.film.clone();
    film.clear();
    render_onto(&scene, &request.options, &job, &mut film, |plan| plan.tuning.tile = 50, &mut ());
    assert!((0..21 * 21).map(|pixel| film.words(pixel)).eq(expected));
    // A film without mattes is none that they can be added to.
    let plain = render_job(&scene, &Request::spp(8).options, &job, full.sampler, |_| (), &mut ());
    assert!(plain.0.clone().merge(&full.film).is_err());
}
