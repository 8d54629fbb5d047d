//! The kernels of scenes are what they were: the referee of changes that only move code. Where kernels are meant to change, `GPU_RT_RENEW=1` writes
//! the tables anew.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use gpu_rt::aov::{Aovs, SeenSurface};
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::layout;
use gpu_rt::gpu::link::{Embedded, Library, link};
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{Filter, Fresnel, Integrator, RenderOptions, Scatter};
use gpu_rt::plan::{Bounce, Kernels, Plan, UniformTables};
use gpu_rt::scene::Scene;

use crate::common::kernel::Overlay;
use crate::common::lattice::Lattice;
use crate::common::referee::{differences, hash_of_buffers, hash_of_kernel, hashes, renamed};

#[path = "../unchanged/scenes.rs"]
mod of_unchanged;

const SCATTERS: [Scatter; 3] = [Scatter::Fused, Scatter::Linked, Scatter::Queues];
const CHANNELS: &str = "albedo,normal,depth,position,object,material,direct,indirect";

/// The sets of options of tests/unchanged. `bsdf` refuses lights without size.
fn sets(has_delta_lights: bool) -> [(&'static str, RenderOptions); 3] {
    let aov = |surface| {
        let mut aovs = Aovs::default();
        aovs.surface = surface;
        aovs.set(Aovs::parse(CHANNELS).expect("channels"));
        aovs
    };
    let usual = RenderOptions::default;
    let rough = RenderOptions { aov: aov(SeenSurface::Rough), filter: Filter::Mitchell, clamp: Some(1.0), ..usual() };
    let integrator = if has_delta_lights { Integrator::Mis } else { Integrator::Bsdf };
    let first = RenderOptions { aov: aov(SeenSurface::First), fresnel: Fresnel::Schlick, integrator, ..usual() };
    [("default", usual()), ("rough", rough), ("first", first)]
}

fn rows(name: &str, scene: &Scene, sets: &[(&'static str, RenderOptions)], rows: &mut BTreeMap<String, Vec<String>>) {
    let size = (64, 36);
    for (set, options) in sets {
        let flat = flatten(scene, size, options).unwrap_or_else(|error| panic!("{name}: {error}"));
        for scatter in SCATTERS {
            let options = RenderOptions { scatter: Some(scatter), ..options.clone() };
            let job = Job { size, max_depth: 20, seed: 0, first_sample: 0, goal: Goal::Samples(16) };
            let plan = Plan::new(&flat, &options, DeviceClass::default(), &job)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            let found = hashes(&plan.kernels).into_iter().chain([hash_of_buffers(&plan.buffers())]).collect();
            rows.insert(format!("{name}, {set}, {scatter:?}"), found);
        }
    }
}

#[test]
fn kernels_of_scenes_are_what_they_were() {
    let lattice = Lattice::new();
    let mut found = BTreeMap::new();
    for (name, path) in of_unchanged::scenes() {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let refuses =
            flatten(&scene, (64, 36), &RenderOptions { integrator: Integrator::Bsdf, ..RenderOptions::default() })
                .is_err();
        rows(&name, &scene, &sets(refuses), &mut found);
    }
    for (name, scene) in lattice.scenes() {
        rows(name, &scene, &sets(false)[..1], &mut found);
    }
    assert!(found.len() > 300, "{} rows", found.len());
    let changed = differences("kernels-of-scenes", &found);
    assert!(changed.is_empty(), "{} rows changed: {changed:#?}", changed.len());
}

/// A comment changes nothing; a number and a binding do.
#[test]
fn a_change_of_a_kernel_is_found() {
    let scene =
        Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.ron")).expect("the scene is read");
    let flat = flatten(&scene, (64, 36), &RenderOptions::default()).expect("it flattens");
    let linked = |library: &dyn Library| {
        let options = RenderOptions { scatter: Some(Scatter::Fused), ..RenderOptions::default() };
        let mut kernels =
            Kernels::link(&flat.features, &options, Scatter::Fused, &UniformTables::default()).expect("they link");
        let Bounce::Fused(kernel) = &mut kernels.bounce else { panic!("it is fused") };
        let kernel = Arc::make_mut(kernel);
        kernel.linked = link(library, "stage/bounce", &kernel.choices).expect("it links");
        kernel.module = kernel.linked.validate().expect("it is valid").0;
        kernel.bindings = layout::bindings(&kernel.module).expect("it has bindings");
        hash_of_kernel(kernel)
    };
    let own = linked(&Embedded);
    let planted = |module: &str, from: &str, to: &str| {
        linked(&Overlay::new(&[]).rewritten(module, |text| text.replacen(from, to, 1)))
    };
    assert_eq!(planted("lib/rng", "fn pcg4d", "// A word.\nfn pcg4d"), own);
    assert_ne!(planted("lib/rng", "1664525u", "1664526u"), own);
    assert_ne!(planted("bind/lights", "@binding(", "@binding(1"), own);
}

#[test]
fn words_are_renamed_and_parts_of_words_are_not() {
    assert_eq!(renamed("a(b, ab, b_c) b", "b", "old"), "a(old, ab, b_c) old");
}
