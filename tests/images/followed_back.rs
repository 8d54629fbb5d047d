//! Light paths are followed back from the lens as camera paths: each with the weights of both, which sum to 1, and the same light.

use gpu_rt::gpu::link::Choices;
use gpu_rt::options::Scatter;

use crate::common::faults::{Fault, by_seed};
use crate::common::render::{Change, Request, render_with, scene};

/// Glass that is tinted and absorbs, with a lamp and a matt ball inside, a mirror, a near mirror, and further materials and objects.
fn room(materials: &str, objects: &str) -> String {
    format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 2.5, 5), look_at: (0, 1, 0), vertical_fov: 60, shutter: (0, 1)),
        background: Solid((0, 0, 0)),
        materials: {{
            \"floor\": Lambertian(albedo: Rgb(0.7, 0.6, 0.5)),
            \"green\": Dielectric(ior: 1.6, transmittance: Rgb(0.7, 0.9, 0.8), absorption: (0.3, 0.1, 0.2)),
            \"mirror\": Metal(albedo: Rgb(0.9, 0.8, 0.7), fuzz: 0), \"satin\": Metal(albedo: Rgb(0.8, 0.7, 0.6), fuzz: 0.08),
            \"lamp\": DiffuseLight(emit: Rgb(9, 8, 7)), {materials}
        }},
        objects: [
            Box(min: (-3, 0, -3), max: (3, 5, 6), material: \"floor\"), Sphere(center: (0, 1.3, 0), radius: 1.2, material: \"green\"),
            Box(min: (0.2, 1.3, -0.2), max: (0.6, 1.7, 0.2), material: \"lamp\"),
            Sphere(center: (-0.4, 0.9, 0.2), radius: 0.35, material: \"floor\"),
            Quad(corner: (-0.5, 4, 0.5), u: (1.5, 0, 0), v: (0, 0, -1), material: \"lamp\"),
            Quad(corner: (-2, 0.1, -2), u: (4, 0, 0), v: (0, 3, 0.5), material: \"mirror\"),
            Sphere(center: (-1.8, 0.5, 1), radius: 0.45, material: \"satin\"), {objects}
        ],
        render: (samples: 16, max_depth: 8))"
    )
}

const MORE_MATERIALS: &str = "\"layer\": Pbr(base_color: Rgb(0.5, 0.4, 0.3), metallic: 0, roughness: 0),
    \"pbr\": Pbr(base_color: Rgb(0.5, 0.4, 0.3), metallic: 0.5, roughness: 0.5), \"frosted\": RoughDielectric(ior: 1.4, roughness: 0.6),
    \"fine\": Conductor(albedo: Rgb(0.9, 0.8, 0.6), roughness: 0.2), \"rough\": Metal(albedo: Rgb(0.8, 0.7, 0.6), fuzz: 0.5)";
const MORE_OBJECTS: &str = "Sphere(center: (1.7, 0.5, 1.4), radius: 0.45, material: \"fine\"),
    Sphere(center: (-0.4, 0.45, 1.9), radius: 0.4, material: \"frosted\"), Sphere(center: (1.6, 0.5, 2.4), radius: 0.4, material: \"pbr\"),
    Box(min: (-1.7, 0.1, 1.8), max: (-1, 0.8, 2.5), material: \"green\"), Sphere(center: (0.5, 0.4, 2.4), radius: 0.3, material: \"rough\"),
    Quad(corner: (-3, 0.02, 5), u: (6, 0, 0), v: (0, 0.3, -2), material: \"layer\")";

/// Lamps that are mirrors too, what moves, fog, and lights without size.
const GLOWING: &str =
    "\"glow\": Pbr(base_color: Rgb(0.5, 0.4, 0.3), metallic: 0, roughness: 0, emission: Rgb(3, 2, 1)),
    \"ember\": Pbr(base_color: Rgb(0.9, 0.8, 0.7), metallic: 1, roughness: 0.1, emission: Rgb(2, 3, 1)),
    \"varnish\": Pbr(base_color: Rgb(0.2, 0.3, 0.4), metallic: 0, roughness: 0.15)";
const OF_ALL_KINDS: &str = "Quad(corner: (1.2, 1, 0), u: (0, 0, 0.8), v: (0, 0.8, 0.3), material: \"glow\"), Box(min: (-1.5, 2, 0.5), max: (-1, 2.4, 1), material: \"ember\"),
    Quad(corner: (-3, 0.02, 5), u: (6, 0, 0), v: (0, 0.3, -2), material: \"varnish\"),
    Moving(keys: [(0, [Translate((0, 0, 0))]), (1, [Translate((0.5, 0.3, 0))])], object: Quad(corner: (-2, 3.2, 1), u: (0.7, 0, 0), v: (0, 0, -0.7), material: \"lamp\")),
    Moving(keys: [(0, [RotateY(0)]), (1, [RotateY(20)])], object: Box(min: (1.4, 0.2, 2), max: (2, 0.9, 2.5), material: \"green\")),
    Medium(boundary: Box(min: (-2, 0.01, -2), max: (2.5, 4.5, 4)), density: 0.1, albedo: Rgb(0.9, 0.8, 0.7), anisotropy: 0.5),
    PointLight(at: (-1, 3.5, 1.5), intensity: (9, 8, 7)), DirectionalLight(direction: (0.3, -1, -0.2), irradiance: (2, 2, 2)),
    SpotLight(at: (1, 4, 2), towards: (-2, 0.5, 1), intensity: (30, 30, 30), inner: 10, outer: 40, falloff: Linear)";

/// The light paths that could be followed back, and those of them whose light or weights differ by more than [`TOLERANCE`].
#[derive(Debug)]
struct Followed {
    all: f64,
    wrong: f64,
}

/// Of the light and of the sum of weights. Positions are rounded, and near grazing angles that shows.
const TOLERANCE: f64 = 1e-3;
/// The share of paths that rounding takes beyond that: 0.24 % measured, with lights of flat faces. (A ball's emission at a grazing angle is less exact.)
const ROUNDED: f64 = 0.01;

/// Follows the light paths of a scene back: with this error, if there is one, and with each of these.
fn follow(text: &str, planted: Option<Fault<'_>>, faults: &[Fault<'_>]) -> (Followed, Vec<Followed>) {
    let room = scene(text);
    // What the test needs beside the renderer.
    let changes = [
        // Without other camera paths, there is less to compile.
        ("stage/bounce", "scatter_path(&path);", "path.status = PATH_ENDED;"),
        ("stage/light_path", "//@ use light_path/scatter", "//@ use light_path/scatter\n//@ use test/followed_back"),
        (
            "stage/light_path",
            "scatter_light_path(&path);",
            "scatter_light_path(&path);\n            follow_back(&path);",
        ),
        ("light_path/scatter", "//@ use step/light_depth", "//@ use step/light_depth\n//@ use test/recorded_events"),
        ("light_path/scatter", "    // The next ray.", "    record_event_of_light(path, drawn);"),
        (
            "light_path/lens_connection",
            "//@ use light_path/light_sample",
            "//@ use light_path/light_sample\n//@ use test/recorded_events",
        ),
        (
            "light_path/lens_connection",
            "    (*path).shadow = Ray(origin, view.direction);",
            "    log_ratio_at_lens = log_ratio;\n    (*path).shadow = Ray(origin, view.direction);",
        ),
        ("step/scatter", "//@ use scene/interaction", "//@ use scene/interaction\n//@ use test/recorded_events"),
        (
            "step/scatter",
            "scatter_by_material(evaluated.material, interaction, u);",
            "follow_recorded(scatter_by_material(evaluated.material, interaction, u), evaluated.material, interaction, (*path).depth == 0u);",
        ),
        ("light_path/emission", "//@ use scene/lights", "//@ use scene/lights\n//@ use test/recorded_events"),
        (
            "light_path/emission",
            "    let light = lights[choice.index];",
            "    let light = lights[choice.index];\n    recorded_light = light.code;",
        ),
        // The counters are the test's own.
        ("light_path/counted_splat", "    add_light(", "    let not_counted = value; //"),
        // At the last event the camera path samples the same light.
        (
            "step/light",
            "//@ use scene/lights",
            "//@ use scene/lights\n//@ use light_path/light_sample\n//@ use test/recorded_events",
        ),
        (
            "step/light",
            "    let choice = choose_light",
            "    if is_following {
                let index = start_of_light_path(path);
                let to_light = -recorded[0].incoming;
                return LightSample(index, to_light, density_of_sampling(index, from_point, to_light), u.y);
            }
            let choice = choose_light",
        ),
        ("step/media", "//@ use step/flight", "//@ use step/flight\n//@ use test/recorded_events"),
        (
            "step/media",
            "        follow_ratio_in_medium",
            "        record_event_in_medium(path, point, medium_albedo(medium, point));\n        follow_ratio_in_medium",
        ),
    ];
    let changes: Vec<Fault> = planted.into_iter().chain(changes).collect();
    let (overlay, seeds) = by_seed(&changes, faults);
    let choose = |choices: &mut Choices| {
        choices.values.insert("tolerance".to_string(), format!("{TOLERANCE:e}"));
    };
    let request = Request::default().mis().light_paths(8).scatter(Scatter::Fused);
    let request = request.with(|options| options.bounces = Some(64));
    let change = Change { library: Some(&overlay), choices: Some(&choose), flat: None };
    let mut found = Vec::new();
    let seeds = [7].into_iter().chain(seeds).map(|seed| (seed, 0..room.render.samples));
    render_with(&room, &request, seeds, &change, |shot| {
        let counted = shot.outcome.totals.hidden_light().times(2f64.powi(24));
        found.push(Followed { all: counted.probed(), wrong: counted.found() });
    });
    (found.remove(0), found)
}

/// For each light path that reaches the lens, the camera path of the same events in reverse order has the same light, and the weights of both
/// sum to 1. Errors of 1 % are found in the densities of emission and of aims, of 2 % in those of light sampling and of a sun, in the factor of an event in either order, at the lens, and in the weights.
/// (The factor of a specular event is in light and ratio alike: tests/images/light_paths.rs.)
#[test]
fn light_paths_and_camera_paths_agree_path_by_path() {
    // Without a ceiling, so that the sun shines in.
    let box_around = "Box(min: (-3, 0, -3), max: (3, 5, 6), material: \"floor\")";
    let wall = |corner, u, v| format!("Quad(corner: {corner}, u: {u}, v: {v}, material: \"floor\")");
    let walls = [
        wall("(-3, 0, -3)", "(6, 0, 0)", "(0, 0, 9)"),
        wall("(-3, 0, -3)", "(0, 0, 9)", "(0, 5, 0)"),
        wall("(3, 0, -3)", "(0, 0, 9)", "(0, 5, 0)"),
        wall("(-3, 0, -3)", "(6, 0, 0)", "(0, 5, 0)"),
        wall("(-3, 0, 6)", "(6, 0, 0)", "(0, 5, 0)"),
    ];
    let open = room(GLOWING, OF_ALL_KINDS).replace(box_around, &walls.join(", "));
    let right = |(found, with_faults): (Followed, Vec<Followed>)| {
        assert!(found.all > 1000.0 && found.wrong < ROUNDED * found.all, "{found:?}");
        (found, with_faults)
    };
    right(follow(&room(MORE_MATERIALS, MORE_OBJECTS), None, &[]));
    let factor = "select(1.0, 1.01, FAULT)";
    let power =
        ("light_path/lens_connection", "(1.0 + exp2(-log_ratio))", format!("pow(1.0 + exp2(-log_ratio), {factor})"));
    let of_glass = [
        ("light_path/emission", "choice.density * aim.pdf / cosine"),
        ("light_path/aims", "weight_on_ray(ray, light, 0.0) / sum"),
        ("light_path/scatter", "cos_camera / (cos_light * pdf)"),
        ("light_path/scatter", "orders.of_sample.response.pdf)"),
        ("light_path/density_ratio", "reversed.of_sample.response.pdf) - "),
        ("light_path/density_ratio", "light_paths) - density"),
        ("camera/lens_view", "density / (distance * distance)"),
    ];
    let of_glass = of_glass.map(|(module, part)| (module, part, format!("{factor} * {part}")));
    let of_glass: Vec<_> = of_glass.into_iter().chain([power]).collect();
    let of_glass: Vec<Fault> = of_glass.iter().map(|(module, part, by)| (*module, *part, by.as_str())).collect();
    for (fault, found) in of_glass.iter().zip(right(follow(&room("", ""), None, &of_glass)).1) {
        assert!(found.wrong > 3.0 * ROUNDED * found.all, "{fault:?}: {found:?}");
    }
    let (of_all_kinds, _) = right(follow(&open, None, &[]));
    for (module, part) in [
        ("step/light", "light_pdf + select(pdf"),
        ("light_path/scatter", "sampled);"),
        ("light_path/delta_emission", "probability * density_of_parallel_aim"),
    ] {
        let (found, _) = follow(&open, Some((module, part, &format!("1.02 * {part}"))), &[]);
        assert!(found.wrong > 3.0 * of_all_kinds.wrong, "{part}: {found:?}, without it {of_all_kinds:?}");
    }
}
