//! Materials, a shape and a channel that are not in the program, added by the steps of docs/dev/architecture.md as far as test code can: the shader files, what the
//! host lays out for them, their names in the lists that the linker goes through, and nothing else on the device. A file of src/material
//! cannot be added here, nor its lines in the list: a Lambertian of the scene file stands in for the new material.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::render::{Change, Request, Shot, plain, render, render_changed, scene};
use gpu_rt::aov::Aov;
use gpu_rt::data::{KIND_DELTA_LIGHT, MAX_PRIMITIVES, primitive_code};
use gpu_rt::flatten::{DeviceScene, Features, MATERIALS, PRIMITIVES, flatten};
use gpu_rt::gpu::link::{Choices, Embedded, Entry, Library, Reason, link};
use gpu_rt::options::{FeatureSet, Integrator, LightPaths, RenderOptions, Scatter};
use gpu_rt::plan::{Kernel, Kernels, UniformTables, choices_of};

/// Step 1: the shader file. The first of two materials answers to no light but what goes back the way it came: a retroreflector sends all light back to where it came from.
const RETROREFLECTOR: &str = "// A retroreflector: light goes back the way it came, less what its colour takes.
fn retroreflector_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    return scatter_towards(-hit.incoming, hit.colour * material.numbers.x, LOBE_SPECULAR);
}
";
const NAME: &str = "retroreflector";
/// The second scatters to all directions alike, and answers to lights: it has an evaluation beside it.
const VELVET: &str = "fn velvet_scatter(material: Material, hit: Interaction, u: vec4<f32>) -> Scatter {
    let point = sample_sphere(u.xy);
    let direction = from_basis(basis_around(hit.normal), vec3<f32>(point.xy, abs(point.z)));
    return scatter_towards(normalize(direction), hit.colour * material.numbers.x, LOBE_WIDE);
}
";
const VELVET_EVAL: &str = "fn velvet_is_non_specular(material: Material) -> bool {
    return true;
}

fn velvet_eval(material: Material, hit: Interaction, direction: vec3<f32>) -> Response {
    let pdf = select(0.0, 1.0 / (2.0 * PI), dot(direction, hit.normal) > 0.0);
    return Response(hit.colour * (material.numbers.x * pdf), pdf, 0.0);
}
";
/// The share of the light that is not lost.
const GAIN: f32 = 0.75;

/// The production shaders and the new file.
struct With(BTreeMap<String, String>);

impl Library for With {
    fn module(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str).or_else(|| Embedded.module(name))
    }
}

/// Its name and number in the lists of materials and of those that answer to lights, which the linker goes through wherever materials are
/// distinguished, in queues too: there it has the queue of the Lambertian that stands in for it.
fn listed(choices: &mut Choices, name: &str) {
    for list in ["material", "non_specular"] {
        let entries = choices.lists.get_mut(list).expect("the plan has the list");
        for entry in entries.iter_mut().filter(|entry| entry.name == "lambertian") {
            *entry = Entry { name: name.to_string(), number: MATERIALS.len() as u32, ..entry.clone() };
        }
    }
}

/// The row of its file of src/material in the scene's table, here instead of the material that the scene file names.
fn loaded(flat: &mut DeviceScene) {
    let material = &mut flat.materials[0];
    (material.kind, material.numbers[0]) = (MATERIALS.len() as u32, GAIN);
}

/// A ball that fills the image, before a sky from `bottom` to `top`.
fn ball(bottom: &str, top: &str, objects: &str) -> gpu_rt::scene::Scene {
    scene(&format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 10),
        background: Gradient(bottom: {bottom}, top: {top}),
        materials: {{ \"toy\": Lambertian(albedo: Rgb(0.5, 0.25, 1)), \"glass\": Dielectric(ior: 1.5) }},
        objects: [{objects}], render: (samples: 16, max_depth: 50))"
    ))
}

const BALL: &str = "Sphere(center: (0, 0, 0), radius: 1, material: \"toy\"),";

fn shot(objects: &str, scatter: Scatter, shader: &str) -> Shot {
    let library = With(BTreeMap::from([(format!("material/{NAME}"), shader.to_string())]));
    let list = |choices: &mut Choices| listed(choices, NAME);
    let change = Change { flat: Some(&loaded), choices: Some(&list), library: Some(&library) };
    render_changed(&ball("(1, 0.5, 0.2)", "(0, 0.5, 2)", objects), &Request::default().scatter(scatter), &change)
}

/// Pixels that are off what the retroreflector must show: the sky behind the camera, where a ray that goes back by direction -d finds what
/// one by direction d finds in a sky that stands on its head. Two renders of the same samples, so that there is no noise; the radiance is a
/// product of two more roundings here, and the direction came back with one in each component: 2^-21 of the value holds them all.
fn wrong(shot: &Shot) -> usize {
    let upside_down = render(&ball("(0, 0.5, 2)", "(1, 0.5, 0.2)", ""), &Request::default());
    let albedo = [0.5, 0.25, 1.0];
    let pixels = shot.picture.rgb.iter().zip(&upside_down.picture.rgb);
    let off = pixels.filter(|(shown, sky)| {
        (0..3).any(|c| {
            let expected = f64::from(sky[c]) * albedo[c] * f64::from(GAIN);
            (f64::from(shown[c]) - expected).abs() > 2f64.powi(-21) * expected
        })
    });
    off.count()
}

#[test]
fn a_material_is_added_by_the_recipe() {
    for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
        assert_eq!(wrong(&shot(BALL, scatter, RETROREFLECTOR)), 0, "{scatter:?}");
        // Beside another material, which the camera does not see.
        let both = format!("{BALL} Sphere(center: (0, 9, 0), radius: 1, material: \"glass\"),");
        assert_eq!(wrong(&shot(&both, scatter, RETROREFLECTOR)), 0, "{scatter:?}, two materials");
        // One percent more light, and a ray that goes straight on, are found.
        let brighter = RETROREFLECTOR.replace("material.numbers.x", "material.numbers.x * 1.01");
        assert_eq!(wrong(&shot(BALL, scatter, &brighter)), 256, "{scatter:?}, brighter");
        let onward = RETROREFLECTOR.replace("-hit.incoming", "reflect(hit.incoming, hit.normal)");
        assert!(wrong(&shot(BALL, scatter, &onward)) > 200, "{scatter:?}, a mirror");
    }
}

/// A ball of a material within a lamp.
fn ball_within_a_lamp(material: &str, emit: &str) -> gpu_rt::scene::Scene {
    scene(&format!(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 10),
        background: Solid((0, 0, 0)), materials: {{ \"toy\": {material}, \"lamp\": DiffuseLight(emit: Rgb({emit})) }},
        objects: [{BALL} Sphere(center: (0, 0, 0), radius: 20, material: \"lamp\")], render: (samples: 256, max_depth: 50))"
    ))
}

/// What a ball of velvet shows within a lamp around it, in standard errors off what it must: its albedo of the lamp's light, in whatever
/// way the directions are shared between the ball's own and those to the lamp.
fn velvet_is_off(scatter: Scatter, evaluation: &str) -> f64 {
    let library = With(BTreeMap::from([
        ("material/velvet".to_string(), VELVET.to_string()),
        ("material/velvet_eval".to_string(), evaluation.to_string()),
    ]));
    let list = |choices: &mut Choices| listed(choices, "velvet");
    let change = Change { flat: Some(&loaded), choices: Some(&list), library: Some(&library) };
    let scene = ball_within_a_lamp("Lambertian(albedo: Rgb(0.5, 0.25, 1))", "1, 4, 2");
    let shown = render_changed(&scene, &Request::default().mis().scatter(scatter), &change).mean_of_all();
    let off = |c: usize| (shown.value[c] - [0.5, 1.0, 2.0][c] * f64::from(GAIN)) / shown.variance[c].sqrt();
    (0..3).map(off).fold(0.0, |most, off| if off.abs() > f64::abs(most) { off } else { most })
}

/// Three channels of the same 65,536 samples; 5.1 standard errors are met by chance once in 1e6 times three.
#[test]
fn a_material_that_answers_to_lights_is_added_by_the_recipe() {
    for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
        let off = velvet_is_off(scatter, VELVET_EVAL);
        assert!(off.abs() < 5.1, "{scatter:?}: {off} standard errors");
        // An evaluation that answers with a fifth more is found: rays to the lamp bring a part of the light.
        let brighter = VELVET_EVAL.replace("material.numbers.x * pdf", "material.numbers.x * pdf * 1.2");
        let off = velvet_is_off(scatter, &brighter);
        assert!(off > 8.0, "{scatter:?}: {off} standard errors");
    }
}

/// A shape that lets rays through its middle, and its directions as a light. A test cannot add a table to `Tables`, nor a form to the scene file:
/// the ring has those of the disk, and with them the disk's name. The number of its kind is its own.
const RING: &str = "//@ use geometry/quad_plane
fn disk_distance(ray: Ray, square: Quad) -> f32 {
    let t = quad_plane_distance(ray, square);
    let radii = length(2.0 * quad_coordinates(ray, t, square) - 1.0);
    return select(NO_HIT, t, t > 0.0 && radii >= 0.5 && radii <= 1.0);
}

fn disk_surface(ray: Ray, t: f32, square: Quad) -> Surface {
    return quad_surface_at(quad_coordinates(ray, t, square), square);
}

fn disk_uv(square: Quad, point: vec3<f32>, local: vec3<f32>) -> SurfaceUv {
    return SurfaceUv(local.xy, vec2<bool>(false));
}
";
const RING_LIGHT: &str = "//@ use light/sample
//@ use geometry/quad_plane
fn disk_coordinates(u: vec2<f32>) -> vec2<f32> {
    return 0.5 + 0.5 * sqrt(0.25 + 0.75 * u.x) * sample_circle(u.y);
}

fn disk_light_sample(from_point: vec3<f32>, square: Quad, u: vec2<f32>) -> DirectionSample {
    let at = disk_coordinates(u);
    let direction = normalize((square.corner - from_point) + (at.x * square.u + at.y * square.v));
    return DirectionSample(direction, disk_light_pdf(from_point, direction, square));
}

fn disk_light_pdf(from_point: vec3<f32>, direction: vec3<f32>, square: Quad) -> f32 {
    let diameters = quad_plane_distance(Ray(from_point, direction), square) / length(square.u);
    return 4.0 / (0.75 * PI) * diameters * diameters / abs(dot(direction, square.normal));
}

fn disk_light_front(ray: Ray, normal: vec3<f32>, square: Quad) -> bool {
    return dot(ray.direction, normal) < 0.0;
}

fn disk_light_distance(ray: Ray, square: Quad) -> f32 {
    return quad_plane_distance(ray, square);
}

fn disk_light_point(square: Quad, u: vec2<f32>) -> LightPoint {
    let at = disk_coordinates(u);
    return LightPoint(square.corner + (at.x * square.u + at.y * square.v), vec3<f32>(0.0));
}

fn disk_light_leaves(normal: vec3<f32>, direction: vec3<f32>) -> bool {
    return true;
}
";
const RING_TANGENT: &str = "fn disk_tangents(surface: Surface, square: Quad, frame: Frame) -> Tangents {
    return Tangents(square.u, square.v);
}
";
const RING_MOTION: &str = "//@ implements moved_disk when moves.disk
//@ use motion/square
fn moved_disk(square: Quad, pose: Pose) -> Quad {
    return moved_square(square, pose);
}
${REST}//@ without
fn moved_disk(square: Quad, pose: Pose) -> Quad {
    return square;
}
${REST}";
/// What a ring at rest has too.
const RING_REST: &str = "
fn disk_at_rest(surface: Surface, square: Quad) -> Surface {
    return surface;
}

fn disk_unturned(surface: Surface) -> Surface {
    return surface;
}

fn disk_tangents_with(tangents: Tangents, pose: Pose) -> Tangents {
    return tangents;
}

";
/// The ring's files, by their modules.
const RING_FILES: [(&str, &str); 4] =
    [("geometry/disk", RING), ("light/disk", RING_LIGHT), ("tangent/disk", RING_TANGENT), ("motion/disk", RING_MOTION)];
/// The highest number that a kind of shape can have.
const LAST_KIND: u32 = KIND_DELTA_LIGHT - 1;

/// The codes of disks in the tables, as those of the ring.
fn renumbered(flat: &mut DeviceScene) {
    let number = PRIMITIVES.iter().position(|name| *name == "disk").expect("there are disks");
    let disk = primitive_code(number as u32, 0);
    let children = flat.nodes.iter_mut().flat_map(|node| &mut node.children);
    for code in children.chain(flat.lights.iter_mut().map(|light| &mut light.code)) {
        if *code >= disk && *code - disk < MAX_PRIMITIVES as u32 {
            *code += primitive_code(LAST_KIND, 0) - disk;
        }
    }
}

/// The disks of the lists, with the number of the ring.
fn renumber_disks(choices: &mut Choices) {
    let disks = choices.lists.values_mut().flatten().filter(|entry| entry.name == "disk");
    disks.for_each(|entry| entry.number = LAST_KIND);
}

/// How a scene with a ring is rendered.
#[derive(Clone, Copy, Debug)]
struct Way {
    scatter: Scatter,
    /// Whether more objects stand there than a ray tests one by one, so that codes are in a hierarchy.
    is_crowded: bool,
    /// Whether the ring turns about its axis, by which it looks as at rest.
    turns: bool,
}

/// The ring from a camera, with objects beside it. `plant` is a text of one of its files, and another in its place.
fn ring_shot(camera: &str, objects: &str, way: Way, plant: (&str, &str)) -> Shot {
    assert!(plant.0.is_empty() || RING_FILES.iter().any(|(_, text)| text.contains(plant.0)));
    let planted = |text: &str| {
        let text = text.replace("${REST}", RING_REST);
        if plant.0.is_empty() { text } else { text.replace(plant.0, plant.1) }
    };
    let library = With(RING_FILES.map(|(name, text)| (name.to_string(), planted(text))).into());
    let change = Change { flat: Some(&renumbered), choices: Some(&renumber_disks), library: Some(&library) };
    let ring = "Disk(center: (0, 0, 0), normal: (0, 0, 1), radius: 1, material: \"lamp\")";
    let turning = format!("Moving(keys: [(0, [RotateZ(0)]), (1, [RotateZ(250)])], object: {ring})");
    let crowd = (0..if way.is_crowded { 40 } else { 0 })
        .map(|i| format!("Sphere(center: ({i}, 0, 30), radius: 0.4, material: \"grey\"),"));
    let scene = scene(&format!(
        "Scene(image: (width: 16, height: 16), camera: ({camera}, shutter: (0, {})), background: Solid((0, 0, 0)),
        materials: {{ \"lamp\": DiffuseLight(emit: Rgb(1, 2, 4)), \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) }},
        objects: [{}, {objects} {}], render: (samples: 256))",
        u32::from(way.turns),
        if way.turns { &turning } else { ring },
        crowd.collect::<String>(),
    ));
    render_changed(&scene, &Request::default().mis().scatter(way.scatter), &change)
}

/// Pixels that do not show the ring and its hole, seen from four units before it.
fn wrong_pixels(shot: &Shot) -> usize {
    let edge = |at: u32| (f64::from(at) / 8.0 - 1.0) * 4.0 * 20f64.to_radians().tan();
    let off = |x: u32, y: u32| {
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| edge(x).hypot(edge(y)));
        let (least, most) = corners.iter().fold((f64::MAX, 0.0), |(least, most), r| (r.min(least), r.max(most)));
        let shown = shot.pixel(x, y)[0];
        match () {
            () if most < 0.5 || least > 1.1 => shown != 0.0,
            () if least > 0.55 && most < 1.0 => (shown - 1.0).abs() > 1e-6,
            () => false,
        }
    };
    (0..256).filter(|i| off(i % 16, i / 16)).count()
}

/// The largest error of the light on the floor above the ring's middle, in standard errors. It is lit by 1/2 - 1/5: the form factor
/// R² / (h² + R²) of a disk less that of its hole.
fn light_is_off(way: Way, plant: (&str, &str)) -> f64 {
    let floor = "Quad(corner: (-4, -4, 1), u: (8, 0, 0), v: (0, 8, 0), material: \"grey\"),";
    let camera = "look_from: (3, 0, 0.5), look_at: (0, 0, 1), vertical_fov: 0.2";
    let shown = ring_shot(camera, floor, way, plant).mean_of_all();
    let off = |c: usize| (shown.value[c] - 0.5 * 0.3 * [1.0, 2.0, 4.0][c]) / shown.variance[c].sqrt();
    (0..3).map(off).fold(0.0, |most, off| if off.abs() > f64::abs(most) { off } else { most })
}

const BEFORE_RING: &str = "look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 40";
const FUSED: Way = Way { scatter: Scatter::Fused, is_crowded: false, turns: false };
const PLAIN: (&str, &str) = ("", "");

/// Three channels of the same 65,536 samples; 5.1 standard errors are met by chance once in 1e6 times three.
#[test]
fn a_shape_is_added_by_the_recipe() {
    let others = [Way { scatter: Scatter::Linked, ..FUSED }, Way { scatter: Scatter::Queues, ..FUSED }];
    for way in [FUSED, others[0], others[1], Way { is_crowded: true, ..FUSED }] {
        assert_eq!(wrong_pixels(&ring_shot(BEFORE_RING, "", way, PLAIN)), 0, "{way:?}");
        assert!(light_is_off(way, PLAIN).abs() < 5.1, "{way:?}: {} standard errors", light_is_off(way, PLAIN));
        // Without its hole, and with a pdf that is too small by a tenth.
        let full = ring_shot(BEFORE_RING, "", way, ("radii >= 0.5 && ", ""));
        assert!(wrong_pixels(&full) > 10, "{way:?}, a disk");
        let brighter = light_is_off(way, ("4.0 / (0.75", "3.6 / (0.75"));
        assert!(brighter > 8.0, "{way:?}: {brighter} standard errors");
    }
}

#[test]
fn a_shape_that_moves_is_added_by_the_recipe() {
    let turning = Way { turns: true, ..FUSED };
    assert_eq!(wrong_pixels(&ring_shot(BEFORE_RING, "", turning, PLAIN)), 0);
    assert!(light_is_off(turning, PLAIN).abs() < 5.1, "{} standard errors", light_is_off(turning, PLAIN));
    // Its corner turns about the middle, its edges do not.
    let torn =
        ("return moved_square(square, pose);", "var moved = square;\n moved.corner += pose.shift;\n return moved;");
    assert!(wrong_pixels(&ring_shot(BEFORE_RING, "", turning, torn)) > 10, "only its corner turns");
}

/// What is wrong with the kernels of light paths, motion and every feature, where the entries of their lists are changed.
fn faults_with_every_feature(options: RenderOptions, library: &With, list: &dyn Fn(&mut Choices)) -> Vec<String> {
    let options = RenderOptions {
        integrator: Integrator::Mis,
        light_paths: LightPaths::Count(1),
        features: FeatureSet::All,
        ..options
    };
    let mut features = Features::default().with_options(&options);
    features.require("light_paths", || "a test".to_string());
    features.quantities.aims = 1;
    let kernels = Kernels::link(&features, &options, Scatter::Fused, &UniformTables::default()).expect("all links");
    let large = kernels.all().into_iter().filter(|kernel| ["bounce", "light_path"].contains(&kernel.stage));
    let fault = |kernel: &Arc<Kernel>| {
        let mut choices = kernel.choices.clone();
        list(&mut choices);
        let linked = link(library, &format!("stage/{}", kernel.stage), &choices).expect("it links");
        linked.validate().err().map(|error| error.to_string())
    };
    large.filter_map(fault).collect()
}

/// Asserts that these files have all functions that any kernel calls, and that the error names each that is missing with its file.
fn have_all_functions(options: &RenderOptions, files: &[(&str, &str)], list: &dyn Fn(&mut Choices)) {
    let faults = |missing: &str| {
        let full = |text: &str| text.replace("${REST}", RING_REST).replace(missing, "fn other(");
        let changed = |(name, text): &(&str, &str)| (name.to_string(), full(text));
        faults_with_every_feature(options.clone(), &With(files.iter().map(changed).collect()), list)
    };
    assert_eq!(faults("no function"), Vec::<String>::new());
    for (file, text) in files {
        let text = text.replace("${REST}", RING_REST);
        let linked = text.split("//@ without").next().unwrap_or_default();
        let names = linked.lines().filter_map(|line| Some(line.strip_prefix("fn ")?.split_once('(')?.0));
        // The parts of disks call `disk_coordinates`, which is no function of every shape.
        for name in names.filter(|name| *name != "disk_coordinates") {
            let words = format!("shaders/{file}.wgsl must have the function {name}: ");
            let found = faults(&format!("fn {name}("));
            assert!(!found.is_empty() && found.iter().all(|fault| fault.contains(&words)), "{name}: {found:?}");
        }
    }
}

/// A layer of glTF's material that takes a tenth of all light on its way out.
const DUST: &str = "fn dust_spreads(material: Material, lobes: Lobes, under: bool) -> bool {
    return under;
}

fn dust_albedo(material: Material, hit: Interaction, under: f32) -> f32 {
    return 0.9 * under;
}

fn draw_dust(draw: LobeDraw, material: Material, hit: Interaction, u: vec2<f32>, under: f32) -> LobeDraw {
    return draw;
}

fn below_dust(scatter: Scatter, hit: Interaction) -> Scatter {
    var scaled = scatter;
    scaled.weight *= 0.9;
    return scaled;
}

fn with_dust(under: Response, material: Material, hit: Interaction, direction: vec3<f32>, albedo: f32) -> Response {
    return Response(0.9 * under.value, under.pdf, under.narrow);
}
";

/// The dust in the lists of layers, around all others.
fn dusted(choices: &mut Choices) {
    let entry = || Entry { name: "dust".to_string(), number: 99, closes: false, why: Reason::EveryRender };
    choices.lists.get_mut("layer").expect("the plan has the list").insert(0, entry());
    choices.lists.get_mut("inner_layer").expect("the plan has the list").push(entry());
}

/// What a ball of glTF's material within a lamp of radiance 1 shows with the dust of this text, over what it shows without.
fn share_under_dust(dust: Option<&str>) -> f64 {
    let library = With(dust.map(|text| ("lobe/dust".to_string(), text.to_string())).into_iter().collect());
    let list = |choices: &mut Choices| {
        if dust.is_some() {
            dusted(choices)
        }
    };
    let coated = "Pbr(base_color: Rgb(0.5, 0.5, 0.5), metallic: 0, roughness: 0.5, coat: 0.5)";
    let scene = ball_within_a_lamp(coated, "1, 1, 1");
    let change = Change { choices: Some(&list), library: Some(&library), ..Change::default() };
    render_changed(&scene, &Request::spp(64).mis(), &change).mean_of_all().value[0]
}

/// The same samples in both, so that the dust's factor is all that differs: samples that meet the specular lobe of the coat have it by
/// `below_dust`, and the others by `with_dust`. Sums of 16,384 samples are off by no more than 1e-4 of the value.
#[test]
fn a_lobe_is_added_by_the_recipe() {
    let plain = share_under_dust(None);
    let off = |dust: &str| (share_under_dust(Some(dust)) / plain - 0.9).abs();
    assert!(off(DUST) < 1e-4, "{}", off(DUST));
    for factor in ["weight *= 0.9", "0.9 * under.value"] {
        let brighter = off(&DUST.replace(factor, &factor.replace("0.9", "1.0")));
        assert!(brighter > 1e-3, "{factor}: {brighter}");
    }
}

/// A channel of the first hit: how far it is from the camera. A test cannot add a variant to src/aov.rs, so that the depth stands in for it.
const DISTANCE: &str = "fn distance_of_hit(path: ptr<function, Path>) -> f32 {
    return (*path).t;
}
";

/// The lists of channels, with the distance for the depth.
fn list_distance(choices: &mut Choices) {
    for (list, name) in [("hit_channel", "distance_of_hit"), ("hit_sum", "distance_of_hit(path)")] {
        let entries = choices.lists.get_mut(list).expect("the plan has the list");
        let depths = entries.iter_mut().filter(|entry| entry.name.starts_with("depth"));
        depths.for_each(|entry| entry.name = name.to_string());
    }
}

/// The largest relative error of the channel over a wall four units before the camera, seen from its middle. A pixel is the mean over its width,
/// 1/16 of 2 tan(20 degrees) there: the distance 4 sqrt(1 + x² + y²) bends by less than 2^-12 of itself within.
fn distance_is_off(shader: &str, scatter: Scatter) -> f64 {
    let library = With(BTreeMap::from([("aov/distance_of_hit".to_string(), shader.to_string())]));
    let change = Change { choices: Some(&list_distance), library: Some(&library), ..Change::default() };
    let wall = scene(
        "Scene(image: (width: 16, height: 16), camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vertical_fov: 40),
        background: Solid((1, 1, 1)), materials: { \"grey\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)) },
        objects: [Quad(corner: (-9, -9, 0), u: (18, 0, 0), v: (0, 18, 0), material: \"grey\")], render: (samples: 256))",
    );
    let request = Request::default().scatter(scatter).with(|options| options.aov.set(vec![Aov::Depth]));
    let film = render_changed(&wall, &request, &change).film;
    let channels = film.aovs().channels();
    let off = |index: usize| {
        let [x, y] = [index % 16, index / 16].map(|at| ((at as f64 + 0.5) / 8.0 - 1.0) * 20f64.to_radians().tan());
        f64::from(film.channel(index, &channels[0])) / (4.0 * (1.0 + x * x + y * y).sqrt()) - 1.0
    };
    (0..256).map(|index| off(index).abs()).fold(0.0, f64::max)
}

#[test]
fn a_channel_is_added_by_the_recipe() {
    for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
        let off = distance_is_off(DISTANCE, scatter);
        // 256 points of a pixel: their mean is off its middle by less than a sixteenth of its width.
        assert!(off < 1e-3, "{scatter:?}: {off}");
        // The depth itself, which is 4 everywhere, is found.
        let depth = DISTANCE.replace("(*path).t", "4.0");
        assert!(distance_is_off(&depth, scatter) > 0.05, "{scatter:?}");
    }
}

#[test]
fn what_the_recipe_adds_links_with_light_paths_motion_and_every_feature() {
    let mut options = RenderOptions::default();
    have_all_functions(&options, &RING_FILES, &renumber_disks);
    let velvet = [("material/velvet", VELVET), ("material/velvet_eval", VELVET_EVAL)];
    have_all_functions(&options, &velvet, &|choices| listed(choices, "velvet"));
    have_all_functions(&options, &[("lobe/dust", DUST)], &dusted);
    options.aov.set(vec![Aov::Depth]);
    have_all_functions(&options, &[("aov/distance_of_hit", DISTANCE)], &list_distance);
}

/// An error in the new file names it, with its line.
#[test]
fn errors_name_the_new_file() {
    let library = With(BTreeMap::from([(format!("material/{NAME}"), RETROREFLECTOR.replace("hit.colour", "hit.hue"))]));
    let flat = flatten(&ball("(1, 1, 1)", "(1, 1, 1)", BALL), (16, 16), &plain()).expect("the scene flattens");
    let mut choices = choices_of(&flat.features, &plain(), &UniformTables::default());
    listed(&mut choices, NAME);
    let linked = link(&library, "stage/bounce", &choices).expect("it links");
    let error = linked.validate().map(|_| ()).expect_err("it has no such member").to_string();
    assert!(error.starts_with("shaders/material/retroreflector.wgsl:3:"), "{error}");
}

/// A function that the new material lacks is named, with the file where it belongs and what it does. Only light paths ask a material that transmits
/// light for its index of refraction.
#[test]
fn a_missing_function_is_named_with_its_file() {
    let glass = RETROREFLECTOR.replace(
        "// A retro",
        "fn retroreflector_index(material: Material, hit: Interaction) -> f32 {\n    return 1.5;\n}\n// A retro",
    );
    let flat = flatten(&ball("(1, 1, 1)", "(1, 1, 1)", BALL), (16, 16), &plain());
    let mut features = flat.expect("the scene flattens").features;
    for fact in ["specular_lobe.dielectric", "area_light.sphere", "light_paths"] {
        features.require(fact, || "a test".to_string());
    }
    (features.quantities.lights, features.quantities.aims) = (1, 1);
    let options = RenderOptions { light_paths: LightPaths::Count(1), ..plain() };
    let mut choices = choices_of(&features, &options, &UniformTables::default());
    listed(&mut choices, NAME);
    let transmissive =
        Entry { name: NAME.to_string(), number: MATERIALS.len() as u32, ..choices.lists["material"][0].clone() };
    choices.lists.insert("transmissive", vec![transmissive]);
    let evaluation = VELVET_EVAL.replace("velvet", NAME);
    let error = |text: &str, evaluation: &str| {
        let modules = [(format!("material/{NAME}"), text), (format!("material/{NAME}_eval"), evaluation)];
        let library = With(modules.map(|(name, text)| (name, text.to_string())).into());
        let linked = link(&library, "stage/bounce", &choices).expect("it links");
        linked.validate().err().map_or(String::new(), |error| error.to_string())
    };
    assert_eq!(error(&glass, &evaluation), "");
    for (function, file) in [
        ("_index: it returns the index", ""),
        ("_scatter: it draws", ""),
        ("_is_non_specular: it says", "_eval"),
        ("_eval: it returns", "_eval"),
    ] {
        let ending = function.split(':').next().expect("a word");
        let without = |text: &str| text.replace(&format!("fn {NAME}{ending}("), "fn other(");
        let error = error(&without(&glass), &without(&evaluation));
        assert!(
            error.contains(&format!("shaders/material/{NAME}{file}.wgsl must have the function {NAME}{function}")),
            "{error}"
        );
    }
}
