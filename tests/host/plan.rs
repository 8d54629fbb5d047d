//! The plan: what scenes require, the reason for it, and that there is nothing else. Snapshots of four of the scenes that ship stand in
//! tests/plans; `GPU_RT_RENEW=1` writes them anew.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::common::files::{files, stem};
use crate::common::program::Ran;
use crate::common::scenes::SPHERE;
use gpu_rt::bvh::Quality;
use gpu_rt::flatten::{DeviceScene, flatten};
use gpu_rt::gpu::buffers::too_large;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::link::{Choices, Entry, Heads, Library, Reason, link};
use gpu_rt::gpu::spirv;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{FeatureSet, Integrator, RenderOptions, Scatter};
use gpu_rt::plan::{Kernels, Plan, Report, Tuning, UniformTables};
use gpu_rt::scene::Scene;

/// A kind of device, so that plans do not depend on the machine.
struct Class {
    name: &'static str,
    device: DeviceClass,
    limits: wgpu::Limits,
    tuning: Tuning,
}

fn classes() -> [Class; 2] {
    let class = |name, software, (slots, records_per_slot), scatter, limits: wgpu::Limits| Class {
        name,
        device: DeviceClass {
            software,
            integrated: false,
            halvings: 0,
            max_binding_bytes: limits.max_storage_buffer_binding_size,
            max_uniform_bytes: limits.max_uniform_buffer_binding_size,
            max_uniforms: limits.max_uniform_buffers_per_shader_stage,
        },
        limits,
        tuning: Tuning {
            slots,
            workgroup: 64,
            scatter,
            is_short: false,
            bounces: None,
            records_per_slot,
            tile: 230_400,
        },
    };
    let software = wgpu::Limits { max_storage_buffers_per_shader_stage: 1000, ..wgpu::Limits::default() };
    let gpu = wgpu::Limits {
        max_storage_buffers_per_shader_stage: 32,
        max_storage_buffer_binding_size: 1 << 31,
        max_buffer_size: 1 << 31,
        ..wgpu::Limits::default()
    };
    [
        class("a software driver", true, (8192, 16), Scatter::Fused, software),
        class("a GPU", false, (1 << 20, 16), Scatter::Linked, gpu),
    ]
}

/// The options of `render` by default, or with everything on.
fn options(features: FeatureSet) -> RenderOptions {
    RenderOptions { features, ..RenderOptions::default() }
}

/// As `render` flattens by default.
fn flat(scene: &Scene, features: FeatureSet) -> DeviceScene {
    let size = (scene.image.width, scene.image.height);
    flatten(scene, size, &options(features)).unwrap_or_else(|error| panic!("{error}"))
}

fn planned<'a>(flat: &'a DeviceScene, class: &Class, scatter: Scatter) -> (Plan<'a>, Report) {
    planned_with(flat, class, scatter, options(FeatureSet::Scene))
}

fn planned_with<'a>(
    flat: &'a DeviceScene,
    class: &Class,
    scatter: Scatter,
    options: RenderOptions,
) -> (Plan<'a>, Report) {
    let tables = UniformTables::new(flat, class.device);
    let kernels = Kernels::link(&flat.features.with_options(&options), &options, scatter, &tables);
    let kernels = kernels.unwrap_or_else(|error| panic!("{error}"));
    let plan = Plan { scene: flat, options, kernels, tuning: Tuning { scatter, ..class.tuning } };
    let report = Report::new(&plan, &class.limits);
    (plan, report)
}

/// The lines of a report that are about what is there: a new material changes no snapshot of a scene without it.
fn present(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("  not linked: "));
    let shown = |line: &str| match line.strip_prefix("  chosen: ") {
        Some(items) => {
            items.split(", ").filter(|item| !item.ends_with(" no")).map(|item| format!("  chosen {item}\n")).collect()
        }
        None => format!("{line}\n"),
    };
    lines.map(shown).collect()
}

/// What a snapshot holds of a scene: nothing that changes with every line of a shader.
fn snapshot(name: &str, scene: &Scene) -> String {
    let flat = flat(scene, FeatureSet::Scene);
    let mut out = format!("{name}\n");
    for class in classes() {
        let (_, report) = planned(&flat, &class, class.tuning.scatter);
        out += &format!("\n# {}\n{}\nmodules\n{}", class.name, present(&report.text()), modules_of(&report));
    }
    out
}

/// Each module with the kernels that have it and its reason, each binding with the kernels that have it.
fn modules_of(report: &Report) -> String {
    let mut modules: BTreeMap<&str, (Vec<&str>, &str)> = BTreeMap::new();
    let mut bindings: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for kernel in &report.kernels {
        for module in &kernel.modules {
            let reason = module.reason.as_deref().unwrap_or("");
            modules.entry(&module.name).or_insert((Vec::new(), reason)).0.push(&kernel.name);
        }
        kernel.bindings.iter().for_each(|(name, _)| bindings.entry(name).or_default().push(&kernel.name));
    }
    let module = |(name, (kernels, reason)): (&&str, &(Vec<&str>, &str))| {
        format!("  {name}  [{}]  {reason}", kernels.join(" ")).trim_end().to_string() + "\n"
    };
    let binding = |(name, kernels): (&&str, &Vec<&str>)| format!("  {name}  [{}]\n", kernels.join(" "));
    modules.iter().map(module).collect::<String>() + "\nbindings\n" + &bindings.iter().map(binding).collect::<String>()
}

/// The files of a folder below the repository with this ending, without it.
fn names(folder: &str, ending: &str) -> BTreeSet<String> {
    files(folder, ending, false).iter().map(|path| stem(path)).collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scene that ships, named as a user in the repository would name it.
fn shipped(name: &str) -> Scene {
    let path = format!("scenes/{name}.ron");
    Scene::load(Path::new(&path)).unwrap_or_else(|error| panic!("{error}"))
}

/// The first line in which two texts differ, with its number.
fn first_difference(expected: &str, found: &str) -> Option<String> {
    let (mut expected, mut found) = (expected.lines(), found.lines());
    (1..).find_map(|number| match (expected.next(), found.next()) {
        (None, None) => Some(None),
        (a, b) if a == b => None,
        (a, b) => {
            let line = |line: Option<&str>| line.unwrap_or("(the end)").to_string();
            Some(Some(format!("line {number}\n  snapshot: {}\n  now:      {}", line(a), line(b))))
        }
    })?
}

/// Together they hold nearly every module that the scenes that ship need.
const SNAPSHOTS: [&str; 4] = ["cornell-smoke", "glass", "instances", "materials"];

#[test]
fn plans_are_as_their_snapshots_say() {
    let renew = "If that is meant, `GPU_RT_RENEW=1 cargo test --test host plan` writes the snapshots anew";
    assert_eq!(names("tests/plans", ".txt"), SNAPSHOTS.map(String::from).into(), "tests/plans");
    for name in SNAPSHOTS {
        let text = snapshot(&format!("scenes/{name}.ron"), &shipped(name));
        let path = root().join(format!("tests/plans/{name}.txt"));
        if crate::common::renew() {
            std::fs::write(&path, &text).expect("a snapshot can be written");
        }
        let expected = std::fs::read_to_string(&path).expect("the snapshot can be read");
        if let Some(difference) = first_difference(&expected.replace('\r', ""), &text) {
            panic!("the plan of scenes/{name}.ron differs from tests/plans/{name}.txt in {difference}\n{renew}");
        }
    }
}

#[test]
fn a_difference_is_shown_by_its_first_line() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
    let difference = first_difference("a\nb\nc\n", "a\nx\nc\n").expect("they differ");
    assert!(difference.starts_with("line 2\n") && difference.contains(": b") && difference.contains(" x"));
    assert!(first_difference("a\n", "a\nb\n").expect("they differ").contains("(the end)"));
}

fn parse(text: &str) -> Scene {
    Scene::parse(text, Path::new("sphere.ron")).unwrap_or_else(|error| panic!("{error}"))
}

const MATT: &str = "Lambertian(albedo: Rgb(0.5, 0.4, 0.3))";

/// A sphere of such a material, beside another one of a second material, and more.
fn two_spheres(material: &str, (name, other): (&str, &str), more: &str) -> String {
    let objects = format!("\"grey\"), Sphere(center: (2, 0, 0), radius: 1, material: \"{name}\"), {more}]");
    SPHERE.replace(MATT, &format!("{material}, \"{name}\": {other}")).replace("\"grey\")]", &objects)
}

fn glass_sphere() -> String {
    two_spheres(MATT, ("glass", "Dielectric(ior: 1.5)"), "")
}

const LAMP: (&str, &str) = ("lamp", "DiffuseLight(emit: Rgb(4, 3, 2))");

const EVERY_WAY: [Scatter; 3] = [Scatter::Fused, Scatter::Linked, Scatter::Queues];

/// What a sphere of one colour before a gradient does without.
const LUXURIES: &str = "queue triangle quad cuboid mesh instance transform texture frame light medium lens";

/// Members of structs that all scenes share with the host, which lays them out once for all: words of memory that are not read.
const SHARED_MEMBERS: &[(&str, &str)] = &[("Sphere", "frame"), ("Sphere", "light"), ("Material", "texture")];

/// The words of an identifier, in lower case and singular.
fn words(identifier: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    for c in identifier.chars() {
        let after_lower = words.last().and_then(|word| word.chars().last()).is_some_and(|last| !last.is_uppercase());
        match words.last_mut() {
            Some(word) if c.is_alphanumeric() && !(c.is_uppercase() && after_lower) => word.push(c),
            _ => words.push(if c.is_alphanumeric() { c.to_string() } else { String::new() }),
        }
    }
    words.retain(|word| !word.is_empty());
    let singular = |word: String| match word.to_lowercase().as_str() {
        "media" => "medium".to_string(),
        "meshes" => "mesh".to_string(),
        "lens" => "lens".to_string(),
        other => other.strip_suffix('s').unwrap_or(other).to_string(),
    };
    words.into_iter().map(singular).collect()
}

/// The luxuries among the words of a text, without these members of these structs.
fn luxuries(text: &str, allowed: &[(&str, &str)]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut of_struct = "";
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("struct ") {
            of_struct = rest.split([' ', '{']).next().unwrap_or_default();
        } else if line.starts_with('}') {
            of_struct = "";
        }
        let member = line.trim().split(':').next().unwrap_or_default();
        if allowed.contains(&(of_struct, member)) {
            continue;
        }
        let identifiers = line.split(|c: char| !c.is_alphanumeric() && c != '_' && c != '.');
        for identifier in identifiers {
            // Members as they are read: what is read is declared somewhere.
            let read = |(_, member): &(&str, &str)| identifier.strip_suffix(&format!(".{member}"));
            let identifier = allowed.iter().find_map(read).unwrap_or(identifier);
            found.extend(words(identifier).into_iter().filter(|word| LUXURIES.split(' ').any(|luxury| luxury == word)));
        }
    }
    found
}

/// All names of a plan, a line each: its kernels, modules, bindings with the members of their structs, path fields and constants. The code of a
/// kernel has other names: those of the steps that its null modules leave out.
fn names_in(plan: &Plan, report: &Report) -> String {
    let mut names: Vec<String> = report.buffers.iter().map(|buffer| buffer.name.to_string()).collect();
    names.extend(report.path_fields.iter().map(|field| field.label().replace(' ', "_")));
    names.extend(report.constants.iter().map(|constant| constant.name.clone()));
    for (kernel, linked) in report.kernels.iter().zip(plan.kernels()) {
        names.push(kernel.name.clone());
        names.extend(kernel.modules.iter().map(|module| module.name.clone()));
        names.extend(kernel.bindings.iter().map(|(name, _)| name.clone()));
        names.extend(structs_in_memory(&linked.module));
    }
    names.join("\n")
}

/// The structs of a kernel's bindings, as it declares them.
fn structs_in_memory(module: &naga::Module) -> Vec<String> {
    let mut waiting: Vec<_> = module.global_variables.iter().map(|(_, global)| global.ty).collect();
    let mut found = BTreeSet::new();
    while let Some(handle) = waiting.pop() {
        let ty = &module.types[handle];
        match &ty.inner {
            naga::TypeInner::Array { base, .. } => waiting.push(*base),
            naga::TypeInner::Struct { members, .. } => {
                waiting.extend(members.iter().map(|member| member.ty));
                let members = members.iter().filter_map(|member| Some(format!("    {}: _,\n", member.name.as_ref()?)));
                let name = ty.name.clone().unwrap_or_default();
                found.insert(format!("struct {name} {{\n{}}}", members.collect::<String>()));
            }
            _ => {}
        }
    }
    found.into_iter().collect()
}

#[test]
fn a_sphere_before_a_gradient_has_nothing_else() {
    let sphere = flat(&parse(SPHERE), FeatureSet::Scene);
    let everything = flat(&parse(SPHERE), FeatureSet::All);
    for class in classes() {
        for scatter in EVERY_WAY {
            let (plan, report) = planned(&sphere, &class, scatter);
            let names = names_in(&plan, &report);
            assert_eq!(luxuries(&names, SHARED_MEMBERS), BTreeSet::new(), "{} {scatter:?}", class.name);
            // None is allowed that is not there.
            for shared in SHARED_MEMBERS {
                let fewer: Vec<_> = SHARED_MEMBERS.iter().filter(|other| *other != shared).copied().collect();
                assert_eq!(luxuries(&names, &fewer).len(), 1, "{shared:?} is not needed");
            }
            assert_eq!(
                report.features.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
                ["sphere", "lambertian", "gradient background"]
            );
            assert!(report.left_out.len() > 20, "{:?}", report.left_out);
            // The words would be found: everything on has them all.
            let (plan, report) = planned_with(&everything, &class, scatter, options(FeatureSet::All));
            let mut found = luxuries(&names_in(&plan, &report), SHARED_MEMBERS);
            // Matrices are the host's: no scene has any word of them.
            assert!(!found.contains("transform"));
            found.insert("transform".to_string());
            if scatter != Scatter::Queues || report.kernels.len() < 4 {
                assert!(!found.contains("queue"), "{scatter:?}");
                found.insert("queue".to_string());
            }
            assert_eq!(found.len(), LUXURIES.split(' ').count(), "{} {scatter:?}: {found:?}", class.name);
            // A scene has one camera. Varying media are crossed in another way, and emission is stored.
            let cameras = ["orthographic", "equirectangular", "fisheye", "calibrated", "calibrated_fisheye"];
            let media = ["height density", "grid density", "medium emission", "blackbody"].map(str::to_owned);
            let others: Vec<String> = media.into_iter().chain(cameras.map(|kind| format!("{kind} camera"))).collect();
            assert_eq!(report.left_out, others);
        }
    }
}

/// The reason for a feature of the plan.
fn asker(report: &Report, feature: &str) -> String {
    let found = report.features.iter().find(|(name, _)| name == feature);
    found.unwrap_or_else(|| panic!("no {feature} in {:?}", report.features)).1.clone()
}

/// Everything that decides the image: the kernels' texts, and the tables that they read.
fn inputs(text: &str, folder: &Path) -> (String, String) {
    let scene = Scene::parse(text, &folder.join("neutral.ron")).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let flat = flat(&scene, FeatureSet::Scene);
    let plans = classes().map(|class| {
        let (plan, report) = planned(&flat, &class, class.tuning.scatter);
        let texts: Vec<_> = plan.kernels().into_iter().map(|kernel| kernel.linked.text.as_str()).collect();
        format!("{}\n{}", report.text(), texts.join("\n"))
    });
    let DeviceScene { features, settings, shapes, materials, extensions, textures, frames, motions, lights, .. } =
        &flat;
    let tables =
        format!("{features:#?}{settings:#?}{materials:#?}{extensions:#?}{textures:#?}{frames:#?}{motions:?}{lights:?}");
    let shapes = format!("{:?}{:?}{:?}{:?}", shapes.spheres, shapes.quads, shapes.instances, shapes.cuboids);
    (plans.join("\n"), format!("{tables}{shapes}{}", flat.radiance_exponent))
}

/// Where the plans of two differ, and where their tables do.
fn differences([(plan, tables), (other_plan, other_tables)]: [(String, String); 2]) -> [Option<String>; 2] {
    [first_difference(&plan, &other_plan), first_difference(&tables, &other_tables)]
}

/// A value that changes nothing links nothing: neither the plan nor a table of the scene differs from that of the scene without it, so that the
/// image has the same bytes.
#[test]
fn neutral_values_need_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    image::RgbImage::from_pixel(4, 4, image::Rgb([99, 128, 255])).save(folder.path().join("n.png")).expect("an image");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    std::fs::write(folder.path().join("flat.obj"), mesh).expect("a mesh is written");
    let scene = |material: &str, objects: &str, camera: &str| {
        let all = format!(
            "Quad(corner: (0, 3, 0), u: (1, 0, 0), v: (0, 0, 1), material: \"lamp\"), Mesh(path: \"flat.obj\", material: \"grey\"),
            Sphere(center: (0, 0, 0), radius: 1, material: \"grey\"), Box(min: (2, 0, 0), max: (3, 1, 1), material: \"other\"){objects}"
        );
        let materials = format!(
            "{material},
            \"other\": Pbr(base_color: Rgb(0.2, 0.3, 0.4)), \"lamp\": DiffuseLight(emit: Rgb(9, 9, 9))"
        );
        SPHERE
            .replace("Lambertian(albedo: Rgb(0.5, 0.4, 0.3))", &materials)
            .replace("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")", &all)
            .replace("vertical_fov: 50", &format!("vertical_fov: 50{camera}"))
    };
    let all_glass = "base_color: Rgb(0.9, 0.8, 0.7), metallic: 0, roughness: 0.3, transmission: 1, solid: true";
    let matt = "Lambertian(albedo: Rgb(0.5, 0.4, 0.3)";
    let metal = "Conductor(albedo: Rgb(0.5, 0.4, 0.3), roughness: 0.3";
    let pbr = "Pbr(roughness: 0.3, metallic: 0.4";
    let all_metal = "Pbr(roughness: 0.3, metallic: 1";
    // A material with fields that change nothing, and the same without.
    let materials = [
        (matt, "", ", emission: Rgb(0, 0, 0)"),
        (matt, "", ", alpha: 1"),
        (matt, "", ", alpha: 0.7, alpha_cutoff: 0.6"),
        (matt, "", ", alpha: IMAGE, alpha_cutoff: 0, vertex_alpha: true"),
        (matt, "", ", vertex_colors: true, vertex_alpha: true"),
        (matt, ", emission: Rgb(1, 1, 1)", ", emission: Rgb(1, 1, 1), vertex_emission: true"),
        (matt, "", ", vertex_emission: true"),
        (matt, "", ", normal: IMAGE, normal_scale: 0"),
        ("Metal(albedo: Rgb(0.5, 0.4, 0.3)", "", ", fuzz: 0"),
        ("Dielectric(ior: 1.5", "", ", transmittance: Rgb(1, 1, 1)"),
        ("Dielectric(ior: 1.5", "", ", absorption: (0, 0, 0)"),
        ("Dielectric(ior: 1.5", "", ", dispersion: 0"),
        ("Dielectric(ior: 1", "", ", dispersion: 3"),
        ("Conductor(albedo: Rgb(0.5, 0.4, 0.3)", "", ", roughness: 0, multiscatter: true"),
        (metal, "", ", anisotropy: 0, anisotropy_rotation: 30"),
        (metal, "", ", anisotropy_texture: IMAGE, one_sided: false, distribution: Ggx"),
        ("Conductor(albedo: Rgb(0.5, 0.4, 0.3), roughness: 9e-4", "", ", distribution: Beckmann"),
        ("Plastic(diffuse: Rgb(0.5, 0.4, 0.3)", "", ", roughness: 0, alpha: 1, nonlinear: false"),
        (
            "Plastic(diffuse: Rgb(0.5, 0.4, 0.3)",
            "",
            ", emission: Rgb(0, 0, 0), one_sided: false, distribution: Beckmann",
        ),
        ("ThinDielectric(ior: 1.5", "", ", transmittance: Rgb(1, 1, 1), roughness: 0"),
        (
            "RoughDielectric(ior: 1.5, roughness: 0.3",
            "",
            ", transmittance: Rgb(1, 1, 1), absorption: (0, 0, 0), dispersion: 0",
        ),
        (pbr, "", ", emission: Rgb(0, 0, 0), alpha: 1, multiscatter: false"),
        ("Pbr(roughness: 0, metallic: 0.4", "", ", multiscatter: true"),
        (pbr, "", ", specular: 1, specular_color: Rgb(1, 1, 1), transmission: 0, solid: true"),
        (pbr, "", ", coat: 0, coat_roughness: IMAGE, coat_normal: IMAGE"),
        ("Pbr(roughness: 0.3, metallic: 0.4, coat: 1", "", ", coat_normal: IMAGE, coat_normal_scale: 0"),
        (pbr, "", ", sheen: Rgb(0, 0, 0), sheen_roughness: IMAGE"),
        (pbr, "", ", iridescence: 0, iridescence_thickness: 300"),
        (pbr, "", ", iridescence: 1, iridescence_thickness: 0"),
        (
            pbr,
            "",
            ", iridescence: 1, iridescence_thickness: 0, iridescence_thickness_min: 0, iridescence_thickness_texture: IMAGE",
        ),
        (pbr, "", ", iridescence: 1, iridescence_ior: 1"),
        (pbr, "", ", diffuse_transmission: 0, diffuse_transmission_color: IMAGE"),
        (pbr, "", ", anisotropy: 0, vertex_colors: true, vertex_alpha: true"),
        (all_metal, "", ", transmission: 0.5, solid: true, dispersion: 3"),
        (all_metal, "", ", diffuse_transmission: 0.5"),
    ];
    for (material, without, with) in materials {
        let pair = [without, with].map(|more| {
            let text = format!("{material}{more})").replace("IMAGE", "Image(path: \"n.png\")");
            inputs(&scene(&text, "", ""), folder.path())
        });
        assert_eq!(differences(pair), [None, None], "{material}{with})");
    }
    let rough = |kind: &str, more: &str| inputs(&scene(&format!("{kind}(ior: 1.5{more})"), "", ""), folder.path());
    let glass = ", transmittance: Rgb(0.9, 0.8, 0.7), absorption: (1, 2, 3), dispersion: 4";
    for (more, neutral) in
        [("", ", roughness: 0"), ("", ", roughness: 9e-4, anisotropy: 0, anisotropy_rotation: 9"), (glass, "")]
    {
        let pair = [rough("Dielectric", more), rough("RoughDielectric", &format!("{neutral}{more}"))];
        assert_eq!(differences(pair), [None, None], "{neutral}{more}");
    }
    let of_objects = |objects: &str, camera: &str| inputs(&scene(MATT, objects, camera), folder.path());
    for (objects, camera) in [
        (
            ", Medium(boundary: Sphere(center: (0, 0, 0), radius: 9), density: 0, albedo: Rgb(1, 1, 1), anisotropy: 0.99)",
            "",
        ),
        (", PointLight(at: (0, 5, 0), intensity: (0, 0, 0))", ""),
        (", SpotLight(at: (0, 5, 0), towards: (0, 0, 0), intensity: (0, 0, 0), outer: 20)", ""),
        (", DirectionalLight(direction: (0, -1, 0), irradiance: (0, 0, 0))", ""),
        (", Group([])", ""),
        ("", ", aperture: 0"),
        ("", ", shutter: (0.5, 0.5)"),
        ("", ", shutter: (0, 1)"),
        (
            "",
            ", shutter: (0, 1), moving: [(0, (look_from: (0, 0, 3), look_at: (0, 0, 0))), (1, (look_from: (0, 0, 3), look_at: (0, 0, 0)))]",
        ),
    ] {
        let pair = [of_objects("", ""), of_objects(objects, camera)];
        assert_eq!(differences(pair), [None, None], "{objects}{camera}");
    }
    // The control: fields that change something differ in both.
    for (material, with) in [
        (matt, ", emission: Rgb(0, 0, 1e-30)"),
        (matt, ", alpha: 0.999"),
        ("Dielectric(ior: 1.5", ", transmittance: Rgb(1, 1, 0.999)"),
        ("Dielectric(ior: 1.5", ", absorption: (0, 0, 1e-9)"),
        ("RoughDielectric(ior: 1.5", ", roughness: 0.001"),
        (metal, ", multiscatter: true"),
        (metal, ", distribution: Beckmann"),
        ("ThinDielectric(ior: 1.5", ", inner_reflections: true"),
        ("Plastic(diffuse: Rgb(0.5, 0.4, 0.3)", ", roughness: 0.001"),
        (pbr, ", iridescence: 1, iridescence_thickness: 0.001"),
        ("Pbr(roughness: 0.3, metallic: 0.999", ", transmission: 0.5"),
        (&format!("Pbr({all_glass}"), ", dispersion: 0.01"),
    ] {
        let pair = ["", with].map(|more| inputs(&scene(&format!("{material}{more})"), "", ""), folder.path()));
        assert!(differences(pair).iter().all(Option::is_some), "{material}{with}");
    }
}

/// The reason is the object itself, however deep in others, and of meshes the one that is smooth.
#[test]
fn objects_ask_for_what_they_are() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    std::fs::write(folder.path().join("flat.obj"), format!("{triangle}f 1 2 3\n")).expect("a mesh is written");
    let smooth = format!("{triangle}vn 0 0 1\nf 1//1 2//1 3//1\n");
    std::fs::write(folder.path().join("smooth.obj"), smooth).expect("a mesh is written");
    let objects = "Group([
        Mesh(path: \"flat.obj\", material: \"grey\"),
        Transformed(by: [Scale(2)], object: Group([
            Quad(corner: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0), material: \"grey\"),
            Box(min: (0, 0, 0), max: (1, 1, 1), material: \"grey\"),
        ])),
        Mesh(path: \"smooth.obj\", material: \"grey\"),
        Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1)),
    ])";
    let text = SPHERE.replace("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")", objects);
    let path = folder.path().join("deep.ron");
    let scene = Scene::parse(&text, &path).unwrap_or_else(|error| panic!("{error}"));
    let (_, report) = planned(&flat(&scene, FeatureSet::Scene), &classes()[0], Scatter::Fused);
    // The first object stands in line 6.
    for (feature, line, column) in
        [("triangle", 7, 9), ("quad", 9, 13), ("cuboid", 10, 13), ("smooth shading", 12, 9), ("sphere medium", 13, 9)]
    {
        assert_eq!(asker(&report, feature), format!("{}:{line}:{column}", path.display()), "{feature}");
    }
}

/// Buffers hold what is on objects: neither materials nor images beside, and each image once.
#[test]
fn buffers_hold_what_is_used_and_each_image_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, size) in [("a.png", 4), ("b.png", 8), ("c.png", 16)] {
        image::RgbImage::new(size, size).save(folder.path().join(name)).expect("an image is written");
    }
    let materials = "
        \"unused\": Lambertian(albedo: Image(path: \"c.png\")),
        \"grey\": Lambertian(albedo: Image(path: \"a.png\")),
        \"other\": Metal(albedo: Image(path: \"a.png\"), fuzz: 0.5),
        \"third\": Lambertian(albedo: Image(path: \"b.png\"))";
    let sphere = |at: i32, name: &str| format!("Sphere(center: ({at}, 0, 0), radius: 1, material: \"{name}\")");
    let of = |names: &[&str], background: &str| {
        let objects: Vec<String> = (0..).zip(names).map(|(at, name)| sphere(at, name)).collect();
        let text = SPHERE
            .replace("\"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3))", materials)
            .replace(&sphere(0, "grey"), &objects.join(", "))
            .replace("Gradient(bottom: (1, 1, 1), top: (0.5, 0.7, 1))", background);
        let scene = Scene::parse(&text, &folder.path().join("images.ron")).unwrap_or_else(|error| panic!("{error}"));
        let flat = flat(&scene, FeatureSet::Scene);
        let of_spheres: Vec<u32> = flat.shapes.spheres.iter().map(|sphere| sphere.material).collect();
        (
            flat.images.iter().map(|(_, image)| image.len()).sum::<usize>(),
            flat.materials.len(),
            flat.textures.len(),
            of_spheres,
        )
    };
    let solid = "Solid((1, 1, 1))";
    assert_eq!(of(&["grey"], solid), (16, 1, 1, vec![0]));
    assert_eq!(of(&["other", "grey"], solid), (16, 2, 2, vec![1, 0]));
    assert_eq!(of(&["third", "grey", "other"], solid), (16 + 64, 3, 3, vec![2, 0, 1]));
    assert_eq!(of(&["grey"], "Image(path: \"a.png\")"), (16, 1, 1, vec![0]));
    assert_eq!(of(&[], "Image(path: \"b.png\")"), (64, 0, 0, vec![]));
    // All that is there is used by one that is.
    assert_eq!(of(&["unused"], solid), (256, 1, 1, vec![0]));
}

/// Images take the bytes of their files' formats. Where a device cannot bind them all, the largest are named.
#[test]
fn images_take_the_bytes_of_their_formats_and_the_largest_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    image::RgbImage::new(32, 16).save(folder.path().join("large.png")).expect("an image is written");
    image::GrayImage::new(8, 8).save(folder.path().join("small.png")).expect("an image is written");
    type Rgb16 = image::ImageBuffer<image::Rgb<u16>, Vec<u16>>;
    Rgb16::new(4, 4).save(folder.path().join("fine.png")).expect("an image is written");
    let lambertian = |name: &str| format!("\"{name}\": Lambertian(albedo: Image(path: \"{name}.png\"))");
    let sphere = |name: &str| format!("Sphere(center: (0, 0, 0), radius: 1, material: \"{name}\")");
    let names = ["fine", "small", "large"];
    let text = SPHERE
        .replace("\"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3))", &names.map(lambertian).join(", "))
        .replace(&sphere("grey"), &names.map(sphere).join(", "));
    let scene = Scene::parse(&text, &folder.path().join("images.ron")).unwrap_or_else(|error| panic!("{error}"));
    let flat = flat(&scene, FeatureSet::Scene);
    let (plan, report) = planned(&flat, &classes()[0], Scatter::Fused);
    let texels = report.buffers.iter().find(|buffer| buffer.name == "texels").expect("images");
    assert_eq!(texels.bytes, 1024 + 4 * (8 * 8 + 32 * 16) + 12 * 4 * 4);
    assert_eq!(texels.size, "1 float image, 192 bytes; 2 srgb images, 2304 bytes");
    // The kernels read just these formats.
    let linked =
        |module: &str| plan.kernels().iter().any(|kernel| kernel.linked.modules.iter().any(|name| name == module));
    assert!(linked("texel/float") && linked("texel/srgb") && !linked("texel/number") && !linked("texel/linear"));
    let buffers: Vec<_> = plan.buffers().into_iter().filter(|buffer| buffer.name == "texels").collect();
    let limits = |bytes| wgpu::Limits { max_storage_buffer_binding_size: bytes, ..wgpu::Limits::default() };
    assert_eq!(too_large(&buffers, &limits(3520)), Vec::<String>::new());
    let said = too_large(&buffers, &limits(3519));
    let expected = "the buffer `texels` (images) needs 3520 bytes, and the device allows 3519 to a storage binding: scale images down, the \
                    largest first: large.png (32 by 16, 2048 bytes), small.png (8 by 8, 256 bytes), fine.png (4 by 4, 192 bytes); of the first, 31 by 15 fits";
    assert_eq!(said, [expected]);
}

/// The image of a sky needs its texels, whether or not it is sampled.
#[test]
fn the_background_asks_for_its_texels() {
    let scene = shipped("sky");
    for integrator in [Integrator::Bsdf, Integrator::Mis] {
        let size = (scene.image.width, scene.image.height);
        let flat =
            flatten(&scene, size, &RenderOptions { integrator, ..RenderOptions::default() }).expect("it flattens");
        let (_, report) = planned(&flat, &classes()[0], Scatter::Fused);
        let texels = report.buffers.iter().find(|buffer| buffer.name == "texels").expect("an image");
        let background = asker(&report, "image background");
        assert!(background.starts_with("background at"), "{background}");
        assert_eq!(texels.reason, background, "{integrator:?}");
    }
}

/// How many steps a walk may take is the scene's own affair, and no more is cut with everything on.
#[test]
fn everything_on_cuts_no_walk_shorter() {
    for (material, beside, steps) in
        [(MATT, ("matt", MATT), "48000"), (MATT, LAMP, "19000"), ("Dielectric(ior: 1.5)", LAMP, "48000")]
    {
        let text = two_spheres(material, beside, "");
        for every in [FeatureSet::Scene, FeatureSet::All] {
            let flat = flat(&parse(&text), every);
            let (plan, _) = planned_with(&flat, &classes()[0], Scatter::Fused, options(every));
            let own: Vec<_> = plan.kernels().iter().map(|kernel| kernel.choices.values["most_steps"].clone()).collect();
            assert_eq!(own, [steps; 4], "{material} {beside:?} {every:?}");
        }
    }
}

/// A GPU that shares the processor's memory gets a quarter of the paths in flight, and one that failed gets half as many each time.
#[test]
fn small_devices_get_less_at_a_time() {
    let [_, gpu] = classes();
    let job = Job { size: (1920, 1080), max_depth: 50, seed: 0, first_sample: 0, goal: Goal::Samples(1000) };
    let slots = |device: DeviceClass| Tuning::new(device, &job, &RenderOptions::default()).slots;
    let most = slots(gpu.device);
    let integrated = DeviceClass { integrated: true, ..gpu.device };
    assert_eq!((most, slots(integrated)), (1 << 20, 1 << 18));
    for halvings in [1, 2, 8] {
        assert_eq!(slots(DeviceClass { halvings, ..integrated }), (1 << 18) >> halvings);
    }
    let given = RenderOptions { slots: Some(7), ..RenderOptions::default() };
    assert_eq!(Tuning::new(DeviceClass { halvings: 3, ..gpu.device }, &job, &given).slots, 7);
}

/// The limit of a walk is that of the device which the plan is for.
#[test]
fn steps_are_those_of_the_device() {
    let devices = run(&["devices", "--json"]).json();
    let devices = devices["devices"].as_array().expect("devices");
    let default = devices.iter().find(|device| device["default"] == true).expect("one is the default");
    let loops = default["numerics"]["loop_iterations"].as_u64().expect("iterations");
    let most = if loops >= u64::from(gpu_rt::gpu::numerics::LOOPS) { 262_144 } else { 48_000 };
    let plan = run(&["plan", "scenes/weekend.ron", "--json"]).json();
    let constants = plan["constants"].as_array().expect("constants");
    let steps = constants.iter().find(|constant| constant["name"] == "MOST_STEPS_OF_WALK").expect("it walks");
    assert_eq!(steps["value"], most);
}

/// A lamp beside a sphere of such a material, with an object more.
fn lamp_beside(material: &str, object: &str) -> DeviceScene {
    flat(&parse(&two_spheres(material, LAMP, object)), FeatureSet::Scene)
}

/// Rays are sent to lights where something answers to them: a material that scatters to more than one direction, or a medium. Elsewhere
/// a lamp is what it is to paths that are not sent anywhere.
#[test]
fn lights_are_sampled_where_something_answers() {
    let fog = "Medium(boundary: Sphere(center: (4, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1)),";
    let cases = [
        ("Dielectric(ior: 1.5)", "", false),
        ("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0)", "", false),
        ("Dielectric(ior: 1.5)", fog, true),
        ("Metal(albedo: Rgb(0.9, 0.9, 0.9), fuzz: 0.1)", "", true),
        ("Lambertian(albedo: Rgb(0.9, 0.9, 0.9))", "", true),
    ];
    for class in classes() {
        for scatter in EVERY_WAY {
            for (material, object, sampled) in cases {
                let flat = lamp_beside(material, object);
                let (plan, report) = planned(&flat, &class, scatter);
                let names = names_in(&plan, &report);
                let has = |word: &str| names.contains(word);
                let of_lights = ["shadow", "light_weight", "step/light", "bind/lights"];
                let found: Vec<_> = of_lights.iter().filter(|word| has(word)).collect();
                assert_eq!(found.is_empty(), !sampled, "{material} {object} {scatter:?}: {found:?}");
                assert_eq!(report.buffers.iter().any(|buffer| buffer.name == "lights"), sampled, "{material} {object}");
                // Without light to sample 96 bytes of the fused kernel, and the distance beside them.
                if !sampled {
                    assert_eq!(report.path_bytes(), if scatter == Scatter::Fused { 96 } else { 100 }, "{scatter:?}");
                }
            }
        }
    }
}

/// Of kernels that serve a material each, those of materials that respond to lights sample them, and glass probes them. All keep the path's
/// history.
#[test]
fn queues_sample_lights_where_their_material_answers() {
    let class = &classes()[1];
    let modules = modules_by_kernel(&flat(&shipped("glass"), FeatureSet::Scene), class, Scatter::Queues);
    for (kernel, samples, probes, meets) in [
        ("scatter_lambertian", true, false, false),
        ("scatter_dielectric", false, true, false),
        ("scatter_diffuse_light", false, false, true),
    ] {
        let has = |module: &str| modules[kernel].contains(module);
        assert_eq!(has("scene/responses"), samples || probes, "{kernel}");
        assert_eq!(has("step/light"), samples || probes || meets, "{kernel}");
        assert_eq!(has("bind/lights"), samples || probes || meets, "{kernel}");
        assert!(has("step/narrow_lobe"), "{kernel}");
    }
}

/// Without surfaces the bounce is one kernel if that was requested.
#[test]
fn scenes_without_surfaces_are_fused_too() {
    let fog = "Medium(boundary: Sphere(center: (0, 0, 0), radius: 1), density: 1, albedo: Rgb(1, 1, 1))";
    let class = &classes()[0];
    for objects in ["", fog] {
        let text = SPHERE.replace("Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")", objects);
        let flat = flat(&parse(&text), FeatureSet::Scene);
        let (plan, report) = planned(&flat, class, Scatter::Fused);
        let names: Vec<_> = plan.kernels().iter().map(|kernel| kernel.name.clone()).collect();
        assert_eq!(names, ["generate", "bounce", "accumulate", "receipt"]);
        assert!(report.scatter.starts_with("fused"), "{}", report.scatter);
        assert!(!names_in(&plan, &report).contains("step/scatter"), "{objects}");
    }
}

#[test]
fn words_of_identifiers_are_distinguished() {
    let split = |text: &str| words(text);
    assert_eq!(split("WORD_OF_LIGHT"), ["word", "of", "light"]);
    assert_eq!(split("LightNode"), ["light", "node"]);
    assert_eq!(split("textures"), ["texture"]);
    assert_eq!(split("highlight"), ["highlight"]);
    let found = |text: &str| luxuries(text, SHARED_MEMBERS).len();
    assert_eq!(found("struct Sphere {\n    light: u32,\n}\nlet x = sphere.light;\n"), 0);
    assert_eq!(found("struct Quad {\n    light: u32,\n}\n"), 2);
    assert_eq!(found("fn light() -> u32 {\n"), 1);
}

/// The modules of each kernel, and the kernels of the plan.
fn modules_by_kernel(flat: &DeviceScene, class: &Class, scatter: Scatter) -> BTreeMap<String, BTreeSet<String>> {
    let (_, report) = planned(flat, class, scatter);
    let modules =
        |kernel: &gpu_rt::plan::KernelReport| kernel.modules.iter().map(|module| module.name.clone()).collect();
    report.kernels.iter().map(|kernel| (kernel.name.clone(), modules(kernel))).collect()
}

#[test]
fn a_glass_sphere_adds_its_material_and_nothing_else() {
    let glass = ["lib/fresnel", "lib/refraction", "lobe/plain_boundary", "material/dielectric"].map(str::to_string);
    let queues = ["bind/queues", "data/queue", "slots/sort_by_material"].map(str::to_string);
    let (before, after) = (flat(&parse(SPHERE), FeatureSet::Scene), flat(&parse(&glass_sphere()), FeatureSet::Scene));
    for class in classes() {
        for (scatter, kernel) in [(Scatter::Fused, "bounce"), (Scatter::Linked, "scatter")] {
            let listed = |flat: &DeviceScene| {
                let (_, report) = planned(flat, &class, scatter);
                let buffers: Vec<_> = report.buffers.iter().map(|buffer| buffer.name).collect();
                let fields: Vec<_> = report.path_fields.iter().map(|field| field.label()).collect();
                (buffers, fields, report.constants.into_iter().map(|constant| constant.name).collect::<Vec<_>>())
            };
            assert_eq!(listed(&before), listed(&after), "{} {scatter:?}", class.name);
            let (before, after) =
                (modules_by_kernel(&before, &class, scatter), modules_by_kernel(&after, &class, scatter));
            assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>());
            for (name, modules) in &after {
                let added: Vec<_> = modules.difference(&before[name]).cloned().collect();
                assert_eq!(added, if name == kernel { glass.as_slice() } else { &[] }, "{} {name}", class.name);
                assert!(before[name].is_subset(modules));
            }
        }
        // With queues: a kernel for each material, and what sorts slots.
        let (before, after) =
            (modules_by_kernel(&before, &class, Scatter::Queues), modules_by_kernel(&after, &class, Scatter::Queues));
        let new: Vec<&str> = after.keys().map(String::as_str).filter(|name| !before.contains_key(*name)).collect();
        assert_eq!(new, ["dispatch", "scatter_dielectric", "scatter_lambertian"]);
        let all: BTreeSet<&String> = before.values().flatten().collect();
        let all_after: BTreeSet<&String> = after.values().flatten().collect();
        let added: Vec<&str> = all_after.difference(&all).map(|name| name.as_str()).collect();
        let expected = "bind/queue_args bind/queue_lengths bind/queues data/queue lib/fresnel lib/refraction lobe/plain_boundary \
                        material/dielectric slots/queued_slot slots/sort_by_material stage/dispatch";
        assert_eq!(added.join(" "), expected);
        for name in ["generate", "intersect", "refill"] {
            let added: Vec<_> = after[name].difference(&before[name]).cloned().collect();
            let sorts = added.iter().filter(|module| queues.contains(module)).count();
            // Sorting needs the material of the hit.
            let of_surfaces = added.iter().filter(|module| !queues.contains(module)).collect::<Vec<_>>();
            assert_eq!(sorts, if name == "intersect" { queues.len() } else { 0 }, "{name}: {added:?}");
            assert!(of_surfaces.is_empty() || name == "intersect", "{name}: {added:?}");
            assert!(added.iter().all(|module| !glass.contains(module)), "{name}: {added:?}");
        }
    }
}

#[test]
fn everything_in_a_plan_has_a_reason() {
    for (number, name) in names("scenes", ".ron").into_iter().enumerate() {
        let scene = shipped(&name);
        for features in [FeatureSet::Scene, FeatureSet::All] {
            let flat = flat(&scene, features);
            for (of_class, class) in classes().into_iter().enumerate() {
                for (of_way, scatter) in EVERY_WAY.into_iter().enumerate() {
                    // With everything on, kernels hardly differ from scene to scene: each has one way, and all of them have each.
                    if features == FeatureSet::All && (number + of_class) % EVERY_WAY.len() != of_way {
                        continue;
                    }
                    let (plan, report) = planned_with(&flat, &class, scatter, options(features));
                    let at = format!("{name} {features:?} {} {scatter:?}", class.name);
                    for constant in &report.constants {
                        assert!(!constant.what.is_empty() && !constant.reason.is_empty(), "{at}: {constant:?}");
                        assert!(constant.value.parse::<u64>().is_ok(), "{at}: {constant:?}");
                    }
                    // A reason is the scene, an option, or every render.
                    let known = |reason: &str| {
                        let stage = reason.strip_prefix("a kernel a stage").unwrap_or(reason);
                        stage.is_empty()
                            || stage == "every render"
                            || stage.contains("--")
                            || stage.contains(&format!("scenes/{name}.ron:"))
                    };
                    for field in &report.path_fields {
                        assert!(!field.what.is_empty() && known(&field.why), "{at}: {field:?}");
                        // Nothing is kept that no kernel reads or writes.
                        let users = report.kernels.iter().filter(|kernel| kernel.path_fields.contains(field));
                        assert!(users.count() > 0, "{at}: nobody uses {field:?}");
                    }
                    for buffer in &report.buffers {
                        assert!(!buffer.size.is_empty() && known(&buffer.reason), "{at}: {buffer:?}");
                        assert!(report.kernels.iter().any(|kernel| kernel.bindings.iter().any(|b| b.0 == buffer.name)));
                    }
                    for (kernel, planned) in report.kernels.iter().zip(plan.kernels()) {
                        let listed: BTreeSet<&String> = kernel.modules.iter().map(|module| &module.name).collect();
                        assert_eq!(listed, planned.linked.modules.iter().collect(), "{at}: {}", kernel.name);
                        for module in &kernel.modules {
                            assert!(module.reason.as_deref().is_none_or(known), "{at}: {module:?}");
                            // The chain of users ends at the entry point.
                            let user = |name: &String| {
                                let user = kernel.modules.iter().find(|module| module.name == *name);
                                user.expect("users are linked").used_by.clone()
                            };
                            let chain = std::iter::successors(Some(module.name.clone()), user);
                            let root = kernel.modules[0].name.clone();
                            assert_eq!(chain.take(100).last(), Some(root), "{at}: {module:?}");
                        }
                        assert!(report.why(&kernel.name).is_some());
                    }
                }
            }
        }
    }
}

#[test]
fn buffers_over_the_limit_are_said_to_be() {
    let flat = flat(&shipped("cornell-smoke"), FeatureSet::Scene);
    let [class, _] = classes();
    let (plan, report) = planned(&flat, &class, Scatter::Fused);
    assert!(!report.text().contains("OVER THE LIMIT"), "{}", report.text());
    assert!(report.buffers.iter().all(gpu_rt::plan::Buffer::fits));
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: 600_000,
        max_storage_buffers_per_shader_stage: 2,
        ..class.limits
    };
    let report = Report::new(&plan, &limits);
    let over: Vec<&str> = report.buffers.iter().filter(|buffer| !buffer.fits()).map(|buffer| buffer.name).collect();
    assert_eq!(over, ["records", "film", "paths"]);
    // The kernel adds nothing to the film.
    for (text, buffers) in [(report.text(), 3), (report.why("bounce").expect("it is a kernel"), 2)] {
        assert_eq!(text.matches("OVER THE LIMIT: the device allows 600000 bytes").count(), buffers, "{text}");
        assert_eq!(text.matches("OVER THE LIMIT: bounce binds 3 storage buffers, and the device allows 2").count(), 1);
    }
}

/// Where nodes do not fit, the setting that makes more of them is named.
#[test]
fn nodes_that_do_not_fit_name_their_setting() {
    let flat = flat(&shipped("next-week"), FeatureSet::Scene);
    for (build, remedy) in [(Quality::Medium, ""), (Quality::Best, ": `--build medium` makes fewer")] {
        let options = RenderOptions { build, ..options(FeatureSet::Scene) };
        let (plan, _) = planned_with(&flat, &classes()[0], Scatter::Fused, options);
        let (max_storage_buffer_binding_size, max_uniform_buffer_binding_size) = (1000, 1000);
        let limits = wgpu::Limits {
            max_storage_buffer_binding_size,
            max_uniform_buffer_binding_size,
            ..wgpu::Limits::default()
        };
        let said = too_large(&plan.buffers(), &limits);
        let nodes = said.iter().find(|said| said.contains("`nodes`")).expect("nodes do not fit");
        assert!(nodes.ends_with(&format!(" binding{remedy}")), "{nodes}");
    }
}

/// Device memory follows the number of runs, up to a most that neither more pixels nor more samples raise.
#[test]
fn device_memory_has_a_most() {
    let flat = flat(&shipped("weekend"), FeatureSet::Scene);
    for class in classes() {
        let bytes = |side: u32, samples: u32| -> u64 {
            let goal = Goal::Samples(samples);
            let job = Job { size: (side, side), max_depth: 8, seed: 0, first_sample: 0, goal };
            let plan = Plan::new(&flat, &options(FeatureSet::Scene), class.device, &job).expect("it links");
            plan.buffers().iter().map(gpu_rt::gpu::buffers::BufferSpec::allocated).sum()
        };
        let most = bytes(4096, 1 << 20);
        for (side, samples) in [(4096, 8), (4096, 64), (2896, 16), (1 << 15, 1)] {
            assert_eq!(bytes(side, samples), most, "{}: {side} x {side}, {samples} samples", class.name);
        }
        // What would grow with the pixels is seen: few of them take less.
        assert!(bytes(64, 1) < most && bytes(64, 8) == bytes(64, 1), "{}: {} of {most}", class.name, bytes(64, 1));
    }
}

#[test]
fn sizes_are_those_of_the_kernels() {
    let [software, _] = classes();
    let measured = |scene: &str, features: FeatureSet| {
        let flat = flat(&parse(scene), features);
        let (plan, mut report) = planned_with(&flat, &software, Scatter::Fused, options(features));
        report.measure(&plan).unwrap_or_else(|error| panic!("{error}"));
        report.kernels.iter().map(|kernel| kernel.size.expect("it is measured")).collect::<Vec<_>>()
    };
    let (sphere, glass) = (measured(SPHERE, FeatureSet::Scene), measured(&glass_sphere(), FeatureSet::Scene));
    let everything = measured(SPHERE, FeatureSet::All);
    // `generate` has no material; `bounce` gets one more.
    assert_eq!(sphere[0], glass[0]);
    assert!(sphere[1].instructions < glass[1].instructions, "{sphere:?} {glass:?}");
    assert!(2 * sphere[1].instructions < everything[1].instructions, "{sphere:?} {everything:?}");
    for size in sphere.iter().chain(&glass).chain(&everything) {
        // A word an instruction at least, and five of header; four words at most on average.
        assert!(size.bytes >= 20 + 4 * size.instructions && size.bytes < 20 + 24 * size.instructions, "{size:?}");
    }
    // Overrides are resolved, and those that a kernel lacks passed over.
    let text = "override N: u32 = 32u;\n@group(0) @binding(0) var<storage, read_write> x: array<u32>;\n\
                @compute @workgroup_size(N) fn f() {\n    x[0] = N;\n}\n";
    let module = naga::front::wgsl::parse_str(text).expect("it is WGSL");
    let size = |overrides: &[(&str, f64)]| spirv::size(&module, "f", overrides);
    let usual = size(&[]).expect("it has a value");
    assert_eq!(size(&[("N", 32.0), ("UNKNOWN", 1.0)]).expect("it is written"), usual);
    assert!(size(&[("N", 0.0)]).is_err());
}

/// Modules by their names.
struct Texts(&'static [(&'static str, &'static str)], Heads);

impl Library for Texts {
    fn module(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    fn heads(&self) -> &Heads {
        &self.1
    }
}

#[test]
fn the_linker_notes_users_reasons_choices_and_values() {
    let texts = &[
        (
            "root",
            "//@ use empty\n//@ use long\n//@ use choice/x\n//@ each list\n//@ use ${name}\n//@ end\n//@ if asked\n//@ use leaf\n\
             //@ use deep\n//@ end\n//@ if absent\n//@ use nothing\n//@ end\n@compute @workgroup_size(1)\nfn f() {\n    g();\n    \
             h();\n    entry();\n}\n",
        ),
        // Nothing of it is reached: it leads to `deep` all the same.
        ("empty", "//@ use deep\nfn unreached() -> u32 {\n    return ${lost}u;\n}\n"),
        ("long", "//@ use chosen\n//@ use deep\nfn g() {\n    deepest();\n}\n"),
        (
            "chosen",
            "//@ implements x when requested\n//@ use choice/y\nconst N: u32 = ${kept}u;\nfn h() {\n    var n = N;\n}\n",
        ),
        ("other", "//@ implements y when always\nfn unreached_too() {\n}\n"),
        ("deep", "fn deepest() {\n}\n"),
        ("entry", "//@ use leaf\n//@ use choice/z\nfn entry() {\n    leaf();\n    last();\n}\n"),
        ("leaf", "fn leaf() {\n}\n"),
        ("last", "//@ implements z when always\nfn last() {\n}\n"),
    ];
    let library = Texts(texts, Heads::of(texts.iter().copied()));
    let requested = |by: &str| Reason::Requested(by.to_string());
    let entry = Entry { name: "entry".to_string(), number: 0, closes: true, why: requested("an object") };
    let pairs = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
        pairs.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect()
    };
    let choices = Choices {
        facts: [
            ("asked", Some(requested("an option"))),
            ("absent", None),
            ("requested", Some(requested("a choice"))),
            ("always", Some(Reason::EveryRender)),
        ]
        .map(|(fact, reason)| (fact.to_string(), reason))
        .into(),
        lists: BTreeMap::from([("list", vec![entry])]),
        values: pairs(&[("lost", "1"), ("kept", "2"), ("absent", "3")]),
        generated: BTreeMap::new(),
    };
    let linked = link(&library, "root", &choices).unwrap_or_else(|error| panic!("{error}"));
    // `long` uses `chosen` in every render, `root` does where it was chosen; `root` uses `leaf` in fewer steps than `entry` does.
    let users = [
        ("deep", "root"),
        ("long", "root"),
        ("chosen", "long"),
        ("entry", "root"),
        ("leaf", "root"),
        ("last", "entry"),
    ];
    assert_eq!(linked.used_by, pairs(&users));
    let reasons = linked.why.iter().map(|(module, why)| (module.clone(), why.to_string())).collect();
    let every = |module| (module, "every render");
    // `last` was chosen for the module that uses it: it has the reason of `entry`.
    let others = [("entry", "an object"), ("leaf", "an option"), ("last", "an object")];
    assert_eq!(pairs(&[["root", "deep", "long", "chosen"].map(every).as_slice(), &others].concat()), reasons);
    assert_eq!(linked.choices, pairs(&[("x", "chosen"), ("z", "last")]));
    assert_eq!(linked.values, BTreeMap::from([("kept".to_string(), ("2".to_string(), "chosen".to_string()))]));
}

fn run(arguments: &[&str]) -> Ran {
    crate::common::program::run(root(), arguments)
}

#[test]
fn why_is_answered_for_kernels_and_refused_for_others() {
    let scene = "scenes/cornell-smoke.ron";
    let plan = |more: &[&str]| run(&[&["plan", scene, "--scatter", "linked"], more].concat());
    let medium = plan(&["--why", "medium"]).exits(0).stdout;
    for part in
        ["stage/medium", "medium/free_flight", "shadow origin", "media ", "scenes/cornell-smoke.ron:20:9", "SPIR-V"]
    {
        assert!(medium.contains(part), "{part} in {medium}");
    }
    // Each module is one level below its user.
    let indent = |module: &str| {
        let line = medium.lines().find(|line| line.split_whitespace().next() == Some(module)).expect("it is there");
        line.len() - line.trim_start().len()
    };
    assert_eq!((indent("stage/medium"), indent("step/flight"), indent("medium/free_flight")), (2, 6, 10));
    assert!(!medium.contains("refill"), "{medium}");

    let object = |more: &[&str]| plan(more).exits(0).json();
    let (one, all) = (object(&["--why", "medium", "--json"]), object(&["--json"]));
    assert_eq!(one["kernels"].as_array().map(Vec::len), Some(1));
    assert!(all["kernels"].as_array().is_some_and(|kernels| kernels.contains(&one["kernels"][0])));
    let modules = one["kernels"][0]["modules"].as_array().expect("modules");
    let find = |name: &str| modules.iter().find(|module| module["name"] == name).expect("it is linked");
    assert_eq!(find("medium/free_flight")["used_by"], "scene/media");
    assert_eq!(find("medium/free_flight")["asked_by"], "scenes/cornell-smoke.ron:20:9");
    assert_eq!(find("stage/medium")["used_by"], serde_json::Value::Null);
    assert_eq!(all["path_fields"][0]["name"], "origin");
    let of_fields: u64 =
        all["path_fields"].as_array().expect("fields").iter().filter_map(|f| f["bytes"].as_u64()).sum();
    assert_eq!(all["path_bytes_per_slot"], of_fields);
    assert!(all["kernels"][0]["spirv_instructions"].as_u64().is_some_and(|n| n > 100), "{}", all["kernels"][0]);

    let folder = tempfile::tempdir().expect("a temporary folder");
    let into = folder.path().join("shaders");
    // What an earlier plan left in a folder is said to be none of this one's; other files do not matter.
    let shaders = folder.path().join("old");
    std::fs::create_dir(&shaders).expect("a folder is made");
    std::fs::write(shaders.join("shading.txt"), "").expect("a file is written");
    let write = || plan(&["--wgsl", shaders.to_str().expect("UTF-8")]).stderr;
    assert!(!write().contains("also holds"));
    std::fs::write(shaders.join("scatter_metal.wgsl"), "").expect("a file is written");
    assert!(write().contains("also holds scatter_metal.wgsl; this plan"));

    let unknown = plan(&["--why", "bounce", "--wgsl", into.to_str().expect("UTF-8")]).exits(2);
    assert!(unknown.stdout.is_empty() && !into.exists());
    let error = unknown.stderr;
    assert!(
        error.contains("--why bounce") && error.contains("generate, intersect, medium, scatter, shadow, refill"),
        "{error}"
    );
}
