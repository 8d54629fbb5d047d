//! A scene's kernels have just what the scene requires: with everything linked the image has the same bytes, without any one of the
//! linked modules there is no kernel, and nothing that is linked is out of an entry point's reach.

use std::collections::{BTreeSet, HashSet};
use std::sync::LazyLock;

use crate::common::constants::tables_read_at_constants;
use crate::common::everything::same;
use crate::common::lattice::Lattice;
use crate::common::paired::is_as_promised;
use crate::common::render::{Request, render};
use gpu_rt::aov::Aovs;
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::link::Linked;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{FeatureSet, LightPaths, RenderOptions, Scatter};
use gpu_rt::plan::{Kernels, PathField, Plan, UniformTables, most_path_bytes};
use gpu_rt::scene::Scene;
use naga::compact::{KeepUnused, compact};

const SCATTERS: [Scatter; 3] = [Scatter::Fused, Scatter::Linked, Scatter::Queues];

/// As the program renders by default.
fn usual(scatter: Scatter) -> Request {
    Request::spp(16).sobol().mis().roulette().scatter(scatter)
}

/// The kernels of all scenes of the lattice, linked in every way.
fn plans() -> &'static [(&'static str, Scatter, Kernels)] {
    static PLANS: LazyLock<Vec<(&str, Scatter, Kernels)>> = LazyLock::new(|| {
        let lattice = Lattice::new();
        let plan = |(name, scene): (&'static str, Scene)| {
            let flat = flatten(&scene, (12, 9), &RenderOptions::default()).expect("the scene flattens");
            SCATTERS.map(|scatter| {
                let linked =
                    Kernels::link(&flat.features, &RenderOptions::default(), scatter, &UniformTables::default());
                (name, scatter, linked.expect("the kernels link"))
            })
        };
        lattice.scenes().into_iter().flat_map(plan).collect()
    });
    &PLANS
}

/// Kernels with everything on take ten seconds to compile, each scene its own: here are the least. The scene with everything in it has them with
/// queues and all channels (`trade_offs::exact_values_and_undeclared_options_change_no_byte`). What the kernels of the others are linked of
/// is in `features_all_links_every_module_that_a_scene_can_need` and `nothing_that_is_linked_is_out_of_reach`.
#[test]
fn everything_on_changes_no_byte() {
    let lattice = Lattice::new();
    let scenes = lattice.scenes();
    let (name, scene) = &scenes[0];
    assert_eq!(*name, "spheres");
    changes_no_byte(name, scene, Scatter::Linked);
    // The test can fail: the scenes' images differ.
    let [own, other] = [0, 1].map(|number| render(&scenes[number].1, &usual(Scatter::Linked)));
    assert!(!same(&own, &other));
}

#[test]
#[ignore = "minutes: make test-long"]
fn everything_on_changes_no_byte_of_any_scene() {
    let lattice = Lattice::new();
    let scenes = lattice.scenes();
    assert!(scenes.len() >= 24, "{} scenes", scenes.len());
    for ((name, scene), scatter) in scenes.iter().flat_map(|found| SCATTERS.map(|scatter| (found, scatter))) {
        changes_no_byte(name, scene, scatter);
    }
}

fn changes_no_byte(name: &str, scene: &Scene, scatter: Scatter) {
    let own = render(scene, &usual(scatter));
    let all = render(scene, &usual(scatter).with(|options| options.features = FeatureSet::All));
    let (a, b) = (&own.picture, &all.picture);
    assert!(is_as_promised(same(&own, &all), &a.rgb, &a.variance, &b.rgb), "{name}, {scatter:?}");
}

/// The number of slots is bounded by the largest state that any scene's paths have; a GPU that allows no more than WebGPU promises has room
/// for what is chosen for it.
#[test]
fn the_state_of_all_slots_has_room() {
    let lattice = Lattice::new();
    let options = RenderOptions { light_paths: LightPaths::Off, ..RenderOptions::default() };
    let every = RenderOptions { features: FeatureSet::All, ..options.clone() };
    let mut aovs = every.clone();
    aovs.aov.set(Aovs::parse("albedo,normal,depth,position,object,material,direct,indirect").expect("they are names"));
    let (mut most, mut most_with_aovs) = (0, 0);
    let scenes = lattice.scenes();
    for (number, (name, scene)) in scenes.iter().enumerate() {
        let own = [(&options, Scatter::Linked)];
        // With everything on, paths of the least have what those of the largest have.
        let all = [(&every, Scatter::Linked), (&every, Scatter::Queues), (&aovs, Scatter::Linked)];
        let is_end = number == 0 || number + 1 == scenes.len();
        for (options, scatter) in own.into_iter().chain(all.into_iter().filter(|_| is_end)) {
            let options = RenderOptions { scatter: Some(scatter), ..options.clone() };
            let flat = flatten(scene, (3840, 2160), &options).expect("the scene flattens");
            let goal = Goal::Samples(1 << 16);
            let job = Job { size: (3840, 2160), max_depth: 50, seed: 0, first_sample: 0, goal };
            let class = DeviceClass::default();
            let plan = Plan::new(&flat, &options, class, &job).expect("the kernels link");
            // 128 MiB of paths of 168 bytes, or of 248.
            let least = if options.aov.is_empty() { 795_000 } else { 540_000 };
            assert!(plan.tuning.slots > least, "{name}: {} slots", plan.tuning.slots);
            for buffer in plan.buffers() {
                assert!(buffer.allocated() <= class.max_binding_bytes, "{name}: {} has {}", buffer.name, buffer.bytes);
            }
            let of = if options.aov.is_empty() { &mut most } else { &mut most_with_aovs };
            *of = (*of).max(plan.kernels.path_bytes());
        }
    }
    assert_eq!(most, most_path_bytes(&every.aov, false));
    assert_eq!(most_with_aovs, most_path_bytes(&aovs.aov, false));
}

/// With everything on, a scene of nothing much has every kernel, and each of the modules that some scene has.
#[test]
fn features_all_links_every_module_that_a_scene_can_need() {
    let lattice = Lattice::new();
    let scenes = lattice.scenes();
    let every = RenderOptions { features: FeatureSet::All, ..RenderOptions::default() };
    let (_, spheres) = &scenes[0];
    for scatter in SCATTERS {
        let modules = |plan: &Kernels| -> BTreeSet<String> {
            plan.all().iter().flat_map(|kernel| kernel.linked.modules.clone()).collect()
        };
        let all = flatten(spheres, (12, 9), &every).expect("the scene flattens");
        let all = modules(
            &Kernels::link(&all.features.with_options(&every), &every, scatter, &UniformTables::default())
                .expect("the kernels link"),
        );
        // What stands for the absence of another thing, or is chosen by the numbers of primitives and lights.
        let instead = "camera/pinhole camera/resting slots/own_slot scene/plain_material scene/emitted \
                       lobe/plain_layer lobe/isotropic_facets lobe/plain_boundary lobe/opaque_body scene/flat_stops \
                       scene/tint step/specular_event scene/plain_colour scene/plain_light scene/plain_medium \
                       scene/flat_shading scene/world_axes scene/nothing scene/brute_force step/no_panes \
                       scene/plain_pane scene/light_tree bind/light_nodes \
                       scene/media scene/media_transmittance";
        // Media whose density varies, or that emit, have kernels of their own.
        let of_media = "bind/bricks bind/fields data/scalar_field medium/grid medium/height scene/field scene/heat scene/varying_media \
                        scene/varying_transmittance scene/walker step/medium_emission";
        for (name, _, plan) in plans().iter().filter(|(_, own, _)| *own == scatter) {
            for module in modules(plan) {
                let known =
                    all.contains(&module) || instead.split(' ').chain(of_media.split(' ')).any(|known| known == module);
                assert!(known, "{name}, {scatter:?}: {module} is not on");
            }
        }
    }
}

/// Fields of the paths' state that some kernel may store and none loads.
fn never_loaded(plan: &Kernels, fields: &[PathField]) -> Vec<String> {
    let kernels = plan.all();
    // The functions that load, each up to the line that closes it.
    let loads: Vec<&str> = kernels
        .iter()
        .flat_map(|kernel| kernel.linked.text.split("\nfn ").filter(|text| text.starts_with("load_")))
        .map(|text| text.split_once("\n}").map_or(text, |(function, _)| function))
        .collect();
    let is_loaded = |field: &&PathField| match (field.words, field.w_of) {
        (1, None) => loads.iter().any(|load| load.starts_with(&format!("load_{}(", field.name))),
        (_, behind) => {
            let plane = format!("PLANE_OF_{},", behind.unwrap_or(&field.name));
            loads.iter().any(|load| load.contains(&plane) && (behind.is_none() || load.contains(".w")))
        }
    };
    fields.iter().filter(|field| !is_loaded(field)).map(|field| field.name.clone()).collect()
}

#[test]
fn every_field_of_the_paths_is_loaded_by_some_kernel() {
    let mut tried = 0;
    for (name, scatter, plan) in plans() {
        assert_eq!(never_loaded(plan, &plan.path_fields), [""; 0], "{name}, {scatter:?}");
        tried += plan.path_fields.len();
        // One too many is found: a word, a vector, and a word that shares the vec4 of a vector.
        let of = |(field, words, w_of): (&str, u32, Option<&'static str>)| PathField {
            name: field.to_string(),
            words,
            w_of,
            ..plan.path_fields[0].clone()
        };
        let more = [("spare", 1, None), ("SPARE", 3, None), ("spare_too", 1, Some("SPARE"))].map(of);
        assert_eq!(never_loaded(plan, &more), ["spare", "SPARE", "spare_too"], "{name}, {scatter:?}");
    }
    assert!(tried > 500, "{tried}");
}

/// Functions, global variables and structs by name.
fn named(module: &naga::Module) -> BTreeSet<String> {
    let functions = module.functions.iter().filter_map(|(_, f)| f.name.clone());
    let globals = module.global_variables.iter().filter_map(|(_, v)| v.name.clone());
    let structs = module.types.iter().filter_map(|(_, t)| t.name.clone());
    functions.chain(globals).chain(structs).collect()
}

/// The parts of a shader that no entry point reaches, once the values of its overrides are known. Of constants naga keeps the names and folds the
/// values into expressions: they are out of reach where the rest of the text does not name them.
fn unreached(text: &str) -> Vec<String> {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .expect("it is valid");
    let values = naga::back::PipelineConstants::default();
    let resolved = naga::back::pipeline_constants::process_overrides(&module, &info, None, &values);
    let (resolved, _) = resolved.expect("the overrides have values");
    let mut reached = resolved.into_owned();
    compact(&mut reached, KeepUnused::No);
    let reached = named(&reached);
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let constants = module.constants.iter().filter_map(|(_, constant)| constant.name.clone());
    let overrides = module.overrides.iter().filter_map(|(_, constant)| constant.name.clone());
    let unnamed = |name: &String| words.iter().filter(|word| *word == name).count() == 1;
    let unreached = named(&module).into_iter().filter(|name| !reached.contains(name));
    constants.chain(overrides).filter(unnamed).chain(unreached).collect()
}

/// A kernel of the lattice.
struct Found {
    /// Of a scene that has it, and its own.
    name: String,
    linked: Linked,
}

/// All that differ.
fn kernels() -> Vec<Found> {
    let mut seen = HashSet::new();
    let all = plans()
        .iter()
        .flat_map(|(name, scatter, plan)| plan.all().into_iter().map(move |kernel| (name, scatter, kernel)));
    all.filter(|(_, _, kernel)| seen.insert(&kernel.linked.text))
        .map(|(name, scatter, kernel)| Found {
            name: format!("{name}, {scatter:?}, {}", kernel.name),
            linked: kernel.linked.clone(),
        })
        .collect()
}

#[test]
fn nothing_that_is_linked_is_out_of_reach() {
    let kernels = kernels();
    assert!(kernels.len() > 100, "{} kernels", kernels.len());
    let mut wrong = Vec::new();
    for Found { name, linked } in &kernels {
        wrong.extend(unreached(&linked.text).into_iter().map(|what| format!("{name}: {what}")));
        // Each module has a line, which is within reach: without it there would be no kernel.
        let of_lines: BTreeSet<_> = linked.lines.iter().map(|(module, _)| module).collect();
        assert!(linked.modules.iter().all(|module| of_lines.contains(module)), "{name}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // What is added and not used is found: a function, a constant, a binding and a struct.
    let text = &kernels[0].linked.text;
    let more = "fn unused_function() {}\nconst UNUSED: u32 = 1u;\n@group(0) @binding(99) var<uniform> unused: vec4<f32>;\nstruct Unused { x: f32 }\n";
    assert_eq!(unreached(&format!("{text}{more}")), ["UNUSED", "Unused", "unused", "unused_function"]);
}

/// The tables that may be uniforms, without the first, for which there is room in any case (shaders/scene/at_run_time.wgsl).
const TABLES: &str = "spheres quads cuboids materials textures frames instances media lights delta_lights light_nodes";

/// Codes of primitives: those that are constant say that there is none, and that is tested before a table is read.
const EXEMPT: [(&str, &str); 2] = [("Hit", "code"), ("Path", "light")];

#[test]
fn no_table_is_read_at_an_index_that_a_compiler_knows() {
    let mut bitten = BTreeSet::new();
    for Found { name, mut linked } in kernels() {
        let read = |linked: &Linked| {
            let (module, info) = linked.validate().expect("it is valid");
            tables_read_at_constants(&module, &info, &TABLES.split(' ').collect::<Vec<_>>(), &EXEMPT)
        };
        assert!(read(&linked).is_empty(), "{name}: {:?}", read(&linked));
        // Without what hides them they are found.
        linked.text = linked.text.replace("return index + settings.zero;", "return index;");
        bitten.extend(read(&linked));
    }
    let tables: BTreeSet<&str> = bitten.iter().filter_map(|read: &String| read.split(' ').next()).collect();
    let hidden = ["cuboids", "delta_lights", "instances", "light_nodes", "lights", "media", "quads", "spheres"];
    assert_eq!(Vec::from_iter(tables), hidden, "{bitten:?}");
}
