//! `--aov`: each channel against what is known of it in a closed form, and against the radiance.

use std::path::Path;

use gpu_rt::aov::{Aovs, SeenSurface};
use gpu_rt::film::Film;
use gpu_rt::options::{Filter, Scatter};
use gpu_rt::scene::Scene;

use crate::common::kernel::Overlay;
use crate::common::render::{Request, Shot, render, render_planted, scene};

const ALL: &str = "albedo,normal,depth,position,object,material,direct,indirect";

fn with_channels(request: Request, list: &str) -> Request {
    let list = Aovs::parse(list).expect("they are names");
    request.with(|options| options.aov.set(list))
}

/// A channel of a film by its name, for each pixel.
fn channel(film: &Film, name: &str) -> Vec<f64> {
    let channels = film.aovs().channels();
    let channel = channels.iter().find(|channel| channel.name == name).expect("the film has it");
    (0..film.width() as usize * film.height() as usize).map(|pixel| f64::from(film.channel(pixel, channel))).collect()
}

fn vectors(film: &Film, names: [&str; 3]) -> Vec<[f64; 3]> {
    let [x, y, z] = names.map(|name| channel(film, name));
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

fn scene_file(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.ron"));
    Scene::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// What is behind the camera does not matter; before it is a wall, 7 units away along its axis, beyond a mirror and a ball.
fn wall(camera: &str, more: &str, background: &str) -> String {
    format!(
        "Scene(
            image: (width: 16, height: 12),
            camera: (look_from: (100, 20, 7), look_at: (100, 20, 0), vertical_fov: 60{camera}),
            background: Solid({background}),
            materials: {{
                \"wall\": Lambertian(albedo: Rgb(0.8, 0.4, 0.2)),
                \"mirror\": Metal(albedo: Rgb(0.5, 0.5, 0.25), fuzz: 0),
                \"glass\": Dielectric(ior: 1.5),
                \"lamp\": DiffuseLight(emit: Rgb(3, 2, 1)),
            }},
            objects: [{more}
                Quad(corner: (50, -30, 0), u: (100, 0, 0), v: (0, 100, 0), material: \"wall\"),
            ],
            render: (samples: 32, max_depth: 8),
        )"
    )
}

/// The depth of a wall across the axis is its distance in every pixel, at the image's corners too, through any lens; its position lies in its plane,
/// on average where the pixel's middle sees it; its normal faces the camera.
#[test]
fn a_wall_has_its_depth_its_position_and_its_normal() {
    for camera in ["", ", aperture: 0.5, focus_distance: 3"] {
        for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
            let request = with_channels(Request::spp(32).scatter(scatter), ALL);
            let film = render(&scene(&wall(camera, "", "(1, 1, 1)")), &request).film;
            // Rays, distances and sums are rounded by a few 2^-24 each.
            assert!(channel(&film, "Z").iter().all(|z| near(*z, 7.0, 7.0 * 1e-6)), "{:?}", channel(&film, "Z"));
            assert!(vectors(&film, ["N.X", "N.Y", "N.Z"]).iter().all(|n| *n == [0.0, 0.0, 1.0]));
            assert!(vectors(&film, ["albedo.R", "albedo.G", "albedo.B"]).iter().all(|albedo| {
                albedo.iter().zip([0.8, 0.4, 0.2]).all(|(found, expected)| near(*found, expected, 1e-7))
            }));
            assert!(channel(&film, "object.Y").iter().all(|object| *object == 1.0));
            let pixel = 2.0 * 7.0 * 30f64.to_radians().tan() / 12.0;
            for (number, [x, y, z]) in vectors(&film, ["P.X", "P.Y", "P.Z"]).into_iter().enumerate() {
                let (column, row) = ((number % 16) as f64 + 0.5, (number / 16) as f64 + 0.5);
                // The mean of 32 points uniform in a pixel is known to its width / sqrt(12 * 32), and the lens moves a point by a third of its
                // radius times 4/3 more; six times that.
                let off = 6.0 * (pixel / 384f64.sqrt() + if camera.is_empty() { 0.0 } else { 0.34 * 0.25 / 2.0 });
                assert!(near(x, 100.0 + (column - 8.0) * pixel, off) && near(y, 20.0 - (row - 6.0) * pixel, off));
                assert!(near(z, 0.0, 7.0 * 1e-6), "{z}");
            }
        }
    }
}

/// Denoisers expect an albedo of at most 1. A white base returns more at 80 degrees by glTF's formula, under a film too; a darker one does not.
#[test]
fn an_albedo_is_at_most_1() {
    let albedo = |base: &str| {
        let text = wall("", "", "(1, 1, 1)")
            .replace("look_from: (100, 20, 7)", "look_from: (60.6, 20, 7)")
            .replace("Lambertian(albedo: Rgb(0.8, 0.4, 0.2))", &format!("Pbr({base}, metallic: 0, roughness: 0.5)"));
        let film = render(&scene(&text), &with_channels(Request::spp(64), "albedo,normal")).film;
        // The light that comes back from a white sky is the albedo, and is not limited.
        let light = film.develop().rgb.iter().map(|rgb| f64::from(rgb[0])).collect::<Vec<_>>();
        (channel(&film, "albedo.R"), light)
    };
    for more in ["", ", iridescence: 1", ", coat: 0.1"] {
        let (white, light) = albedo(&format!("base_color: Rgb(1, 1, 1){more}"));
        assert!(white.iter().all(|albedo| *albedo <= 1.0) && white.contains(&1.0), "{more}: {white:?}");
        // The control: nearly all of it is there, and more would be.
        assert!(light.iter().any(|light| *light > 1.02), "{more}: {light:?}");
        let (grey, _) = albedo(&format!("base_color: Rgb(0.5, 0.5, 0.5){more}"));
        assert!(grey.iter().all(|albedo| *albedo < 1.0), "{more}: {grey:?}");
    }
}

/// The normal of a ball in a pixel, by a quadrature in f64 over the pixel: the mean over rays that hit, times their share.
fn normal_of_ball(column: usize, row: usize) -> [f64; 3] {
    const STEPS: usize = 64;
    let pixel = 2.0 * 30f64.to_radians().tan() / 12.0;
    let mut sum = [0.0; 3];
    for i in 0..STEPS * STEPS {
        let part = |i: usize| (i as f64 + 0.5) / STEPS as f64;
        let x = (column as f64 + part(i % STEPS) - 8.0) * pixel;
        let y = (6.0 - row as f64 - part(i / STEPS)) * pixel;
        // The ball of radius 1 is 3 units away, on the axis.
        let length = (x * x + y * y + 1.0).sqrt();
        let d = [x / length, y / length, -1.0 / length];
        let along = -3.0 * d[2];
        let root = along * along - 8.0;
        if root > 0.0 {
            let t = along - root.sqrt();
            let hit = [t * d[0], t * d[1], 3.0 + t * d[2]];
            sum.iter_mut().zip(hit).for_each(|(sum, n)| *sum += n / (STEPS * STEPS) as f64);
        }
    }
    sum
}

fn ball(film: &Film) -> Result<(), String> {
    for (number, found) in vectors(film, ["N.X", "N.Y", "N.Z"]).into_iter().enumerate() {
        let expected = normal_of_ball(number % 16, number / 16);
        for (found, expected) in found.into_iter().zip(expected) {
            // A component is within ±1, so that its mean over 1024 samples has a standard error of 1/32 at most; six of them at the outline.
            // Within the ball a pixel turns the normal by less than 1/5 either way.
            let inside =
                expected.abs() < 1.0 && (number / 16 == 5 || number / 16 == 6) && (7..9).contains(&(number % 16));
            let tolerance = if inside { 6.0 * 0.2 / 32.0 } else { 6.0 / 32.0 };
            if !near(found, expected, tolerance) {
                return Err(format!("pixel {number}: {found} for {expected}"));
            }
        }
    }
    Ok(())
}

#[test]
fn a_ball_has_its_normals_in_the_axes_of_the_world() {
    let text = |from: &str, at: &str, up: &str| {
        format!(
            "Scene(
                image: (width: 16, height: 12),
                camera: (look_from: {from}, look_at: {at}, up: {up}, vertical_fov: 60),
                background: Solid((1, 1, 1)),
                materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
                objects: [Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")],
                render: (samples: 1024, max_depth: 1),
            )"
        )
    };
    let request = with_channels(Request::spp(1024), "normal");
    let upright = scene(&text("(0, 0, 3)", "(0, 0, 0)", "(0, 1, 0)"));
    ball(&render(&upright, &request).film).unwrap();
    // A kernel that forgets to turn the normal to the ray's side, or another normal, is found.
    let planted = Overlay::new(&[])
        .rewritten("aov/surface", |text| text.replace("* share, normal)", "* share, -(*path).ray.direction)"));
    assert!(ball(&render_planted(&upright, &request, &planted).film).is_err());
    // From the side, what was x is -z.
    let aside = render(&scene(&text("(3, 0, 0)", "(0, 0, 0)", "(0, 1, 0)")), &request).film;
    for (number, [x, _, z]) in vectors(&aside, ["N.X", "N.Y", "N.Z"]).into_iter().enumerate() {
        let [across, _, towards] = normal_of_ball(number % 16, number / 16);
        assert!(near(z, -across, 6.0 / 32.0) && near(x, towards, 6.0 / 32.0), "pixel {number}");
    }
    // A view so narrow that render space has the camera's axes: all of it sees the ball's pole.
    let narrow = scene(&text("(3e6, 0, 0)", "(0, 0, 0)", "(0, 1, 0)").replace("fov: 60", "fov: 0.000001"));
    let film = render(&narrow, &with_channels(Request::spp(8), "normal,position,depth")).film;
    for [x, y, z] in vectors(&film, ["N.X", "N.Y", "N.Z"]) {
        assert!(near(x, 1.0, 1e-3) && y.abs() < 0.05 && z.abs() < 0.05, "{x} {y} {z}");
    }
    for [x, y, z] in vectors(&film, ["P.X", "P.Y", "P.Z"]) {
        // The device knows the distance to 3e6 2^-23.
        assert!(near(x, 1.0, 1.0) && y.abs() < 0.05 && z.abs() < 0.05, "{x} {y} {z}");
    }
}

/// Through a mirror and through glass, the albedo is that of what is seen there, times the mirror's, unless the first surface is requested.
#[test]
fn the_albedo_is_that_of_the_first_rough_surface() {
    let mirror = "Quad(corner: (98, 18, 3), u: (4, 0, 0), v: (0, 4, 0), material: \"mirror\"),
        Quad(corner: (50, -30, 30), u: (100, 0, 0), v: (0, 100, 0), material: \"wall\"),";
    let glass = "Sphere(center: (100, 20, 3), radius: 1, material: \"glass\"),
        Box(min: (0, -80, -1), max: (200, 120, 100), material: \"wall\"),";
    let middle = |text: &str, surface, names: [&str; 3]| {
        let request = with_channels(Request::spp(64).depth(64), "albedo,normal,object,depth")
            .with(|options| options.aov.surface = surface);
        let film = render(&scene(text), &request).film;
        vectors(&film, names)[5 * 16 + 7]
    };
    let albedo = ["albedo.R", "albedo.G", "albedo.B"];
    let (mirror, glass) = (wall("", mirror, "(0, 0, 0)"), wall("", glass, "(0, 0, 0)"));
    let same = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| near(*a, b, 1e-6)), "{found:?} for {expected:?}");
    };
    same(middle(&mirror, SeenSurface::Rough, albedo), [0.4, 0.2, 0.05]);
    same(middle(&mirror, SeenSurface::First, albedo), [0.5, 0.5, 0.25]);
    // The wall behind the camera faces it as the mirror does not.
    same(middle(&mirror, SeenSurface::Rough, ["N.X", "N.Y", "N.Z"]), [0.0, 0.0, -1.0]);
    same(middle(&mirror, SeenSurface::First, ["N.X", "N.Y", "N.Z"]), [0.0, 0.0, 1.0]);
    // All ways through the ball end at walls of one albedo.
    same(middle(&glass, SeenSurface::Rough, albedo), [0.8, 0.4, 0.2]);
    same(middle(&glass, SeenSurface::First, albedo), [1.0, 1.0, 1.0]);
    // Depth and object are those of the first surface.
    same(middle(&mirror, SeenSurface::Rough, ["Z", "Z", "object.Y"]), [4.0, 4.0, 1.0]);
}

/// Light has an albedo of 1. Where there is nothing, the depth is the largest number and all else is 0. Fog has an albedo and no normal, and does
/// not matter to the depth.
#[test]
fn light_fog_and_nothing_have_stated_values() {
    let lamp = "Quad(corner: (90, 10, 6), u: (20, 0, 0), v: (0, 20, 0), material: \"lamp\"),";
    let pixel = |text: &str| {
        let film = render(&scene(text), &with_channels(Request::spp(64), ALL)).film;
        let names = film.aovs().channels();
        names.into_iter().map(|channel| (channel.name.clone(), film.channel(5 * 16 + 7, &channel))).collect::<Vec<_>>()
    };
    let at =
        |values: &[(String, f32)], name: &str| values.iter().find(|(known, _)| known == name).expect("it is there").1;
    let light = pixel(&wall("", lamp, "(0, 0, 0)"));
    assert_eq!(
        ["albedo.R", "N.Z", "material.Y", "direct.R", "indirect.R"].map(|name| at(&light, name)),
        [1.0, 1.0, 2.0, 3.0, 0.0]
    );
    let nothing = pixel(&wall("", "", "(0.5, 0.5, 0.5)").replace("look_at: (100, 20, 0)", "look_at: (100, 20, 9)"));
    for (name, value) in &nothing {
        let expected = match name.as_str() {
            "Z" => f32::MAX,
            name if name.starts_with("direct") => 0.5,
            _ => 0.0,
        };
        assert_eq!(*value, expected, "{name}");
    }
    let fog =
        "Medium(boundary: Box(min: (0, -80, 1), max: (200, 120, 6)), density: 100, albedo: Rgb(0.25, 0.5, 0.75)),";
    let fog = pixel(&wall("", fog, "(1, 1, 1)"));
    assert_eq!(
        ["albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z"].map(|name| at(&fog, name)),
        [0.25, 0.5, 0.75, 0.0, 0.0, 0.0]
    );
    assert!(near(f64::from(at(&fog, "Z")), 7.0, 7e-6));
}

/// The direct radiance is that of a render whose paths scatter once at the most, and with the indirect one it is all of it.
#[test]
fn direct_and_indirect_radiance_add_up_to_the_radiance() {
    let direct = ["direct.R", "direct.G", "direct.B"];
    for name in ["cornell-smoke", "glass", "weekend", "lights"] {
        let scene = scene_file(name);
        for scatter in [Scatter::Fused, Scatter::Linked] {
            let request =
                with_channels(Request::spp(8).mis().roulette().size(24, 24).scatter(scatter), "direct,indirect");
            let full = render(&scene, &request);
            let once = render(&scene, &request.clone().depth(1));
            let indirect = vectors(&full.film, ["indirect.R", "indirect.G", "indirect.B"]);
            let found = vectors(&full.film, direct);
            for (pixel, direct) in found.iter().enumerate() {
                for c in 0..3 {
                    let (all, once) = (f64::from(full.picture.rgb[pixel][c]), f64::from(once.picture.rgb[pixel][c]));
                    // Eight samples of a few contributions, each rounded by 2^-24.
                    let rounding = 1e-6 * all.max(once);
                    assert!(
                        near(direct[c], once, rounding),
                        "{name}, {scatter:?}: pixel {pixel}: {} for {once}",
                        direct[c]
                    );
                    assert!(near(direct[c] + indirect[pixel][c], all, rounding), "{name}, {scatter:?}: pixel {pixel}");
                    assert!(indirect[pixel][c] >= 0.0);
                }
            }
            assert!(indirect.iter().flatten().sum::<f64>() > 0.01 * found.iter().flatten().sum::<f64>(), "{name}");
        }
    }
}

/// The sums do not depend on how the stages are linked, on tiles or on parts, and the radiance's are the same without the channels.
#[test]
fn channels_are_exact_and_leave_the_radiance_as_it_is() {
    let scene = scene_file("materials");
    let words = |shot: &Shot| (0..20 * 20).map(|pixel| shot.film.words(pixel)).collect::<Vec<_>>();
    for filter in [Filter::Box, Filter::Mitchell] {
        let plain = Request::spp(32).mis().roulette().sobol().size(20, 20).with(|options| options.filter = filter);
        let request = with_channels(plain.clone(), ALL);
        let full = render(&scene, &request);
        let expected = words(&full);
        for scatter in [Scatter::Linked, Scatter::Queues] {
            assert!(words(&render(&scene, &request.clone().scatter(scatter))) == expected, "{scatter:?}");
        }
        let mut joined = render(&scene, &Request { samples: Some(0..8), ..request.clone() });
        joined
            .film
            .merge(&render(&scene, &Request { samples: Some(8..32), ..request.clone() }).film)
            .expect("they fit");
        assert!(words(&joined) == expected);
        let without = render(&scene, &plain);
        let of_radiance = words(&without)[0].len();
        assert!(words(&without).iter().zip(&expected).all(|(a, b)| *a == b[..of_radiance]));
        assert!(without.film.clone().merge(&full.film).is_err());
    }
}
