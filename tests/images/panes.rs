//! Smooth panes, which light passes straight on: closed forms, and what lies behind.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DVec3};
use gpu_rt::aov::Aovs;
use gpu_rt::options::Scatter;

use crate::common::everything::same;
use crate::common::kernel::Overlay;
use crate::common::oracles::fresnel;
use crate::common::render::{Request, render, render_planted, scene, scene_in};

/// Of a coloured pane, beside those that let all colours pass.
const COLOUR: [f64; 3] = [0.5, 0.9, 1.0];

/// What a surface of glass, of index 1.5, reflects at this cosine.
fn reflectance(cosine: f64) -> f64 {
    fresnel(cosine, 1.5).0
}

/// A point of a floor of albedo 1, seen from below the panes. Its only event is the last.
fn floor(light: &str, panes: &[String], background: &str) -> String {
    format!(
        "Scene(image: (width: 4, height: 4), camera: (look_from: (0, 0.5, 0.3), look_at: (0, 0, 0), vertical_fov: 0.01),
        background: {background}, materials: {{\"floor\": Lambertian(albedo: Rgb(1, 1, 1)), \"clear\": ThinDielectric(),
            \"coloured\": ThinDielectric(transmittance: Rgb(0.5, 0.9, 1)), \"lamp\": DiffuseLight(emit: Rgb(400, 400, 400))}},
        objects: [Quad(corner: (-1, 0, 1), u: (2, 0, 0), v: (0, 0, -2), material: \"floor\"), {} {light}],
        render: (samples: 64, max_depth: 1))",
        panes.concat()
    )
}

/// Panes above each other, turned by this angle. The first is coloured.
fn turned(count: usize, degrees: f64) -> Vec<String> {
    let pane = |k: usize| {
        let (y, material) = (4.0 + 2.5 * k as f64, if k == 0 { "coloured" } else { "clear" });
        format!(
            "Transformed(by: [RotateX({degrees}), Translate((0, {y}, 0))],
                object: Quad(corner: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"{material}\")),"
        )
    };
    (0..count).map(pane).collect()
}

/// The share of each colour that panes let pass at this cosine, the first of them coloured.
fn passed(count: usize, cosine: f64) -> [f64; 3] {
    COLOUR.map(|colour| if count == 0 { 1.0 } else { colour * (1.0 - reflectance(cosine)).powi(count as i32) })
}

/// Without noise for lights without size: the tolerance is that of f32. At 89.9 degrees the cosine is the difference of products of up to 1,
/// and the share that passes is proportional to it.
#[test]
fn suns_and_lamps_shine_through_panes_by_their_transmittance() {
    for count in [0, 1, 2, 10] {
        for degrees in [0.0, 30.0, 60.0, 85.0, 89.9f64] {
            let cosine = degrees.to_radians().cos();
            let close = 1e-5 + count as f64 * 4.0 * f64::from(f32::EPSILON) / cosine;
            for (light, brightness) in [
                ("DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3))", 3.0 / PI),
                ("PointLight(at: (0, 40, 0), intensity: (5000, 5000, 5000))", 5000.0 / 1600.0 / PI),
            ] {
                let expected = passed(count, cosine).map(|share| brightness * share);
                let text = floor(light, &turned(count, degrees), "Solid((0, 0, 0))");
                let scatters =
                    if degrees == 60.0 { [Scatter::Fused, Scatter::Queues].as_slice() } else { &[Scatter::Fused] };
                for &scatter in scatters {
                    let found = render(&scene(&text), &Request::spp(16).mis().scatter(scatter)).mean_of_all().value;
                    let off = (0..3).map(|c| (found[c] / expected[c] - 1.0).abs()).fold(0.0, f64::max);
                    assert!(
                        off < close,
                        "{count} at {degrees}: {found:?}, expected {expected:?}: {off:e} of {close:e}"
                    );
                }
            }
        }
    }
}

/// A lamp, and a sky, which paths meet too.
#[test]
fn lamps_and_skies_shine_through_panes_by_either_technique() {
    let folder = tempfile::tempdir().expect("a folder");
    let sky = image::Rgb32FImage::from_pixel(8, 4, image::Rgb([1.0, 1.0, 1.0]));
    image::DynamicImage::ImageRgb32F(sky).save(folder.path().join("sky.hdr")).expect("the sky is written");
    let level = |count: usize| {
        let material = |k: usize| if k == 0 { "coloured" } else { "clear" };
        let pane = |k: usize| {
            let y = 1.0 + 0.01 * k as f64;
            format!("Quad(corner: (-5e4, {y}, 5e4), u: (1e5, 0, 0), v: (0, 0, -1e5), material: \"{}\"),", material(k))
        };
        (0..count).map(pane).collect::<Vec<_>>()
    };
    const STEPS: usize = 4000;
    for count in [1, 2, 10] {
        // A lamp of 2 by 2 at the height 3: the integral over its points.
        let mut of_lamp = [0.0; 3];
        for i in 0..64 {
            for j in 0..64 {
                let [x, z] = [i, j].map(|k| (k as f64 + 0.5) / 32.0 - 1.0);
                let square = x * x + z * z + 9.0;
                let part = 400.0 / PI * (9.0 / square) / square * 4.0 / 4096.0;
                let share = passed(count, 3.0 / square.sqrt());
                (0..3).for_each(|c| of_lamp[c] += part * share[c]);
            }
        }
        let mut of_sky = [0.0; 3];
        for i in 0..STEPS {
            let angle = (i as f64 + 0.5) / STEPS as f64 * FRAC_PI_2;
            let share = passed(count, angle.cos());
            let part = 2.0 * angle.sin() * angle.cos() * FRAC_PI_2 / STEPS as f64;
            (0..3).for_each(|c| of_sky[c] += part * share[c]);
        }
        let lamp = "Quad(corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2), material: \"lamp\")";
        for (light, background, expected) in
            [(lamp, "Solid((0, 0, 0))", of_lamp), ("", "Image(path: \"sky.hdr\")", of_sky)]
        {
            let room = scene_in(folder.path(), &floor(light, &level(count), background));
            let (samples, few) = (Request::spp(8192).seed(5), Request::spp(1024).seed(5).mis());
            for request in [samples.clone(), few.clone(), few.clone().sobol()] {
                let mean = render(&room, &request).mean_of_all();
                mean.is_near(expected, 0.06).unwrap_or_else(|error| panic!("{count} {light}: {error}"));
            }
            // Shadow rays that lose nothing, and paths that lose nothing. One pane takes as much as there is room for noise, and ten take more
            // than two, which are found.
            for (module, line, by) in [
                ("step/panes", "(1.0 - pane.reflectance) * pane.colour", "pane.colour"),
                ("step/panes", "|| is_reflected(path, hit, pane.reflectance)", ""),
            ] {
                if count != 2 {
                    continue;
                }
                let planted = Overlay::new(&[]).rewritten(module, |own| own.replace(line, by));
                let request = if by.is_empty() { &samples } else { &few };
                let planted = render_planted(&room, request, &planted).mean_of_all();
                assert!(planted.is_near(expected, 0.06).is_err(), "{count} {light}: without {line} all is the same");
            }
        }
    }
}

/// A body of panes before a gradient: every ray is followed in f64, with all reflections inside. The camera looks past the middle.
#[test]
fn a_body_passes_both_of_its_sides_and_reflects_inside() {
    let turn = DMat3::from_rotation_y(0.5);
    let text = |body: &str| {
        format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0.3, 0.55, 5), look_at: (0.3, 0.5, 0), vertical_fov: 0.001),
            background: Gradient(bottom: (0, 1, 3), top: (4, 2, 0)), materials: {{\"coloured\": ThinDielectric(transmittance: Rgb(0.5, 0.9, 1))}},
            objects: [{body}], render: (samples: 256, max_depth: 50))"
        )
    };
    // The first crossing of a ray that leaves a point on or outside a body: the distance and the outward normal.
    type Crossing = Option<(f64, DVec3)>;
    type Body = dyn Fn(DVec3, DVec3) -> Crossing;
    let of_ball = |at: DVec3, along: DVec3| -> Crossing {
        let (half, rest) = (at.dot(along), at.length_squared() - 1.0);
        let root = (half * half - rest).sqrt();
        let t = [-half - root, -half + root].into_iter().find(|t| *t > 1e-9)?;
        Some((t, at + t * along))
    };
    let of_box = move |at: DVec3, along: DVec3| -> Crossing {
        let (at, along) = (turn.transpose() * at, turn.transpose() * along);
        let mut found: Crossing = None;
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let t = (side - at[axis]) / along[axis];
                let point = at + t * along;
                let within = (0..3).all(|other| other == axis || point[other].abs() <= 1.0);
                if t > 1e-9 && within && found.is_none_or(|(nearest, _)| t < nearest) {
                    let mut normal = DVec3::ZERO;
                    normal[axis] = side;
                    found = Some((t, turn * normal));
                }
            }
        }
        found
    };
    fn followed(at: DVec3, along: DVec3, share: [f64; 3], body: &Body) -> [f64; 3] {
        if share[2] < 1e-9 {
            return [0.0; 3];
        }
        let Some((t, normal)) = body(at, along) else {
            let up = 0.5 * (along.y + 1.0);
            return [0, 1, 2].map(|c| share[c] * ((1.0 - up) * [0.0, 1.0, 3.0][c] + up * [4.0, 2.0, 0.0][c]));
        };
        let (point, cosine) = (at + t * along, along.dot(normal));
        let back = reflectance(cosine.abs());
        let reflected = followed(point, along - 2.0 * cosine * normal, share.map(|s| s * back), body);
        let through = [0, 1, 2].map(|c| share[c] * (1.0 - back) * COLOUR[c]);
        let passed = followed(point, along, through, body);
        [0, 1, 2].map(|c| reflected[c] + passed[c])
    }
    let (from, to) = (DVec3::new(0.3, 0.55, 5.0), DVec3::new(0.3, 0.5, 0.0));
    let ball = "Sphere(center: (0, 0, 0), radius: 1, material: \"coloured\")";
    let cuboid = format!(
        "Transformed(by: [RotateY({})], object: Box(min: (-1, -1, -1), max: (1, 1, 1), material: \"coloured\"))",
        0.5f64.to_degrees()
    );
    let bodies: [(&str, &Body); 2] = [(ball, &of_ball), (&cuboid, &of_box)];
    for (body, crossing) in bodies {
        let expected = followed(from, (to - from).normalize(), [1.0; 3], crossing);
        let room = scene(&text(body));
        for scatter in [Scatter::Fused, Scatter::Linked] {
            let mean = render(&room, &Request::default().sobol().scatter(scatter)).mean_of_all();
            mean.is_near(expected, 0.02).unwrap_or_else(|error| panic!("{body}: {error}"));
        }
        // The far side is taken for the near one. (Those of a box reflect alike.)
        if body == ball {
            let planted = Overlay::new(&[]).rewritten("scene/crossings", |own| own.replace("is_far)", "false)"));
            let planted = render_planted(&room, &Request::default().sobol(), &planted).mean_of_all();
            assert!(planted.is_near(expected, 0.02).is_err(), "{body}: a far side like the near one is not found");
        }
    }
    // A shadow through both sides of a ball, beside its middle.
    let light = "DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3))";
    for (offset, radius) in [(0.6f64, 1.0f64), (0.6, 1e5)] {
        let (across, up) = (offset * radius, 3.0 + 2.0 * radius);
        let ball = format!("Sphere(center: ({across}, {up}, 0), radius: {radius}, material: \"coloured\"),");
        let share = 1.0 - reflectance((1.0 - offset * offset).sqrt());
        let found = render(&scene(&floor(light, &[ball], "Solid((0, 0, 0))")), &Request::spp(16).mis()).mean_of_all();
        for (c, colour) in COLOUR.into_iter().enumerate() {
            let expected = 3.0 / PI * (colour * share).powi(2);
            assert!((found.value[c] / expected - 1.0).abs() < 1e-4, "{radius}: {:?}, expected {expected}", found.value);
        }
    }
}

/// Panes of an index of 1 reflect nothing: what is behind them is seen in their colours, and those behind it do not count, in whatever order
/// the file has them, with a hierarchy and without.
#[test]
fn only_the_panes_before_the_nearest_surface_colour_it() {
    let sheet = |z: f64, material: &str| {
        format!("Quad(corner: (-4, -4, {z}), u: (8, 0, 0), v: (0, 8, 0), material: \"{material}\"),")
    };
    let more = (0..40)
        .map(|k| format!("Sphere(center: ({}, 30, -9), radius: 0.2, material: \"wall\"),", k - 20))
        .collect::<String>();
    for more in ["", &more] {
        for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 4, 0, 3, 1]] {
            let sheets =
                [sheet(1.0, "red"), sheet(0.5, "green"), sheet(0.0, "wall"), sheet(-0.5, "red"), sheet(-1.0, "green")];
            let objects: String = order.iter().map(|i| sheets[*i].as_str()).collect();
            let text = format!(
                "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
                background: Solid((1, 1, 1)), materials: {{\"wall\": DiffuseLight(emit: Rgb(1, 1, 1)),
                    \"red\": ThinDielectric(ior: 1, transmittance: Rgb(0.5, 0.25, 1)),
                    \"green\": ThinDielectric(ior: 1, transmittance: Rgb(0.25, 0.5, 0.5))}},
                objects: [{objects} {more}], render: (samples: 16, max_depth: 0))"
            );
            for request in [Request::default(), Request::default().mis().scatter(Scatter::Queues)] {
                let shot = render(&scene(&text), &request);
                assert_eq!(shot.mean_of_all().value, [0.125, 0.125, 0.5], "{order:?}");
            }
        }
    }
}

/// Fog before a coloured pane keeps its colour, wherever it scatters: with a black sky behind the pane, its colour changes no byte.
#[test]
fn panes_behind_an_event_in_a_medium_do_not_colour_it() {
    let text = |colour: &str| {
        scene(&format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((0, 0, 0)), materials: {{\"pane\": ThinDielectric(ior: 1, transmittance: Rgb({colour}))}},
            objects: [Quad(corner: (-4, -4, -1), u: (8, 0, 0), v: (0, 8, 0), material: \"pane\"),
                Medium(boundary: Box(min: (-3, -3, -0.5), max: (3, 3, 0.5)), density: 0.7, albedo: Rgb(1, 1, 1)),
                DirectionalLight(direction: (0, -1, -0.2), irradiance: (3, 3, 3))], render: (samples: 16, max_depth: 1))"
        ))
    };
    let (clear, red) = (text("1, 1, 1"), text("0.9, 0.1, 0.1"));
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let request = Request::default().mis().scatter(scatter);
        assert!(same(&render(&clear, &request), &render(&red, &request)), "a pane colours what is before it");
        let planted = Overlay::new(&[]).rewritten("step/panes", |own| own.replace("hit.t < end", "true"));
        let planted = render_planted(&red, &request, &planted);
        assert!(!same(&render(&clear, &request), &planted), "a pane that colours what is before it is not found");
    }
}

/// Channels show what is behind a pane that reflects nothing, and no byte changes.
#[test]
fn channels_show_what_is_behind_a_pane() {
    let pane = "Quad(corner: (-2, -2, 0), u: (4, 0, 0), v: (0, 4, 0), material: \"pane\"), Sphere(center: (0, 0, 1), radius: 0.5, \
                material: \"pane\"),";
    let text = |panes: &str| {
        format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 40),
            background: Solid((1, 2, 3)),
            materials: {{\"wall\": Lambertian(albedo: Rgb(0.8, 0.5, 0.2)), \"pane\": ThinDielectric(ior: 1)}},
            objects: [Quad(corner: (-5, -5, -1), u: (10, 0, 0), v: (0, 10, 0), material: \"wall\"), {panes}
                PointLight(at: (0, 1, 5), intensity: (9, 9, 9))], render: (samples: 16, max_depth: 4))"
        )
    };
    for scatter in [Scatter::Fused, Scatter::Linked] {
        let request = Request::default().mis().scatter(scatter).with(|options| {
            options
                .aov
                .set(Aovs::parse("albedo,normal,depth,position,object,direct,indirect").expect("they are names"));
        });
        let [with, without] = [pane, ""].map(|panes| render(&scene(&text(panes)), &request));
        for channel in with.film.aovs().channels() {
            let values = |pixel| [&with, &without].map(|shot| shot.film.channel(pixel, &channel).to_bits());
            assert!((0..64).all(|pixel| values(pixel)[0] == values(pixel)[1]), "{}", channel.name);
        }
        assert!(with.film.develop().rgb == without.film.develop().rgb);
    }
}

/// Hundreds of panes on a ray end no walk.
#[test]
fn any_number_of_panes_lets_light_pass() {
    let pane = |k: usize| {
        let y = 4.0 + 0.01 * k as f64;
        format!("Quad(corner: (-1, {y}, -1), u: (0, 0, 2), v: (2, 0, 0), material: \"thin\"),")
    };
    let panes: Vec<String> = (0..400).map(pane).collect();
    let light = "DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3))";
    let text = floor(light, &panes, "Solid((0, 0, 0))");
    let text = text
        .replace("\"clear\"", "\"thin\": ThinDielectric(ior: 1.01, transmittance: Rgb(0.995, 0.998, 1)), \"clear\"");
    let found = render(&scene(&text), &Request::spp(16).mis()).mean_of_all().value;
    let share = 1.0 - (0.01f64 / 2.01).powi(2);
    for (c, colour) in [0.995, 0.998, 1.0f64].into_iter().enumerate() {
        let expected = 3.0 / PI * (colour * share).powi(400);
        // Each of 400 products is rounded by u, and so are its two factors.
        assert!((found[c] / expected - 1.0).abs() < 1e-4, "{found:?}, expected {expected} of {c}");
    }
}

/// What reaches the floor through a slab: 1 - 2R / (1 + R). A pane without inner reflections beside it
/// keeps its own, and a kernel without them is found.
#[test]
fn inner_reflections_are_those_of_a_slab() {
    let light = "DirectionalLight(direction: (0, -1, 0), irradiance: (3, 3, 3))";
    let without = Overlay::new(&[("material/inner_reflections", "inner > 0.0", "inner < 0.0")]);
    for degrees in [0.0, 30.0, 60.0, 85.0f64] {
        let r = reflectance(degrees.to_radians().cos());
        let slab = 1.0 - 2.0 * r / (1.0 + r);
        for (count, expected) in [(1, slab), (2, slab * (1.0 - r))] {
            let text = floor(light, &turned(count, degrees), "Solid((0, 0, 0))")
                .replace("transmittance: Rgb(0.5, 0.9, 1)", "inner_reflections: true");
            // As of panes without them; the share of r and its derivative are at most twice as large.
            let close = 1e-5 + count as f64 * 8.0 * f64::from(f32::EPSILON) / degrees.to_radians().cos();
            let off = |value: f64| (value / (3.0 / PI * expected) - 1.0).abs();
            let scene = scene(&text);
            for scatter in [Scatter::Fused, Scatter::Queues] {
                let request = Request::spp(16).mis().scatter(scatter);
                let found = off(render(&scene, &request).mean_of_all().value[1]);
                assert!(found < close, "{count} panes at {degrees} degrees, {scatter:?}: off by {found}");
                let planted = off(render_planted(&scene, &request, &without).mean_of_all().value[1]);
                assert!(
                    planted > 10.0 * close,
                    "{count} panes at {degrees} degrees: the fault is not found, {planted}"
                );
            }
        }
    }
    // Straight on a white sky, all light comes back or passes: a furnace.
    for roughness in [0.0, 0.1] {
        let furnace = format!(
            "Scene(image: (width: 8, height: 8), camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), vertical_fov: 5),
            background: Solid((1, 1, 1)), materials: {{\"slab\": ThinDielectric(roughness: {roughness}, inner_reflections: true)}},
            objects: [Quad(corner: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: \"slab\")])"
        );
        let found = render(&scene(&furnace), &Request::spp(64).mis()).mean_of_all().value[1];
        // Single scattering at alpha 0.01 loses less than 1e-3 straight on.
        assert!((found - 1.0).abs() < 1e-3, "{roughness}: {found}");
    }
}
