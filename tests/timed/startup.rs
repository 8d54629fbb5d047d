//! What a start costs, by what is compiled: kernels that run, each once, and no others. Seconds depend on the machine, and are in
//! docs/dev/performance.md.

use crate::alone;
use crate::common::{device, render};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::common::everything::{Everything, World};
use gpu_rt::aov::Aov;
use gpu_rt::gpu::buffers::Buffers;
use gpu_rt::gpu::device::Device;
use gpu_rt::gpu::kernel_cache::KEPT_KERNELS;
use gpu_rt::gpu::pipeline::{Pipeline, PipelineSpec};
use gpu_rt::job::{Frame, Goal, Job};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::render::{Next, following};
use gpu_rt::scene::Scene;
use gpu_rt::session::Session;

const SIZE: (u32, u32) = (16, 9);

/// Makes a scene's kernels ready and, if it is to be rendered, renders a sample; the result is the kernels that were dispatched.
fn start(device: &Arc<Device>, scene: &Scene, scatter: Scatter, aov: &[Aov], to_be_rendered: bool) -> Vec<String> {
    let mut options = RenderOptions { scatter: Some(scatter), ..RenderOptions::default() };
    options.aov.include(aov);
    let job = Job { size: SIZE, max_depth: 8, seed: 0, first_sample: 0, goal: Goal::Samples(1) };
    let mut session = Session::on(vec![Arc::clone(device)]);
    // The seconds of each kernel on the device name all that were dispatched.
    session.profile = true;
    session.view(scene, &Frame::full(SIZE), &options).expect("the scene flattens");
    if !to_be_rendered {
        session.prepare(&job, &mut ()).expect("the kernels compile");
        return Vec::new();
    }
    let mut film = session.film(SIZE).expect("the film fits");
    session.render(&job, &mut film, &mut ()).expect("the device renders");
    assert_eq!(film.film.totals.paths, u64::from(SIZE.0 * SIZE.1));
    session.outcome.stages.into_iter().map(|(name, _)| name).collect()
}

/// The kernels that were compiled in vain: for nothing, or once more.
fn in_vain(device: &Device, ran: &[String]) -> Vec<String> {
    let mut compiled = device.kernels.compiled_names();
    for name in ran.iter().map(String::as_str).chain(["probe"]) {
        let at = compiled.iter().position(|known| known == name).unwrap_or_else(|| panic!("{name} was never compiled"));
        compiled.swap_remove(at);
    }
    compiled
}

/// One sphere before a sky, with one material: little is required.
const SPHERE: &str = "Sphere(center: (0, 0, 0), radius: 1, material: \"grey\")";

/// Such objects before a sky.
fn scene_of(objects: &str) -> Scene {
    render::scene(&format!(
        "Scene(
            image: (width: 16, height: 9),
            camera: (look_from: (0, 0, 3), look_at: (0, 0, 0), up: (0, 1, 0), vertical_fov: 50),
            background: Solid((1, 1, 1)),
            materials: {{ \"grey\": Lambertian(albedo: Rgb(0.5, 0.4, 0.3)) }},
            objects: [{objects}],
        )"
    ))
}

/// The seconds of a submission of a render that goes on until some have been made: the median after the first. Of the cover scene: bounces of a lone
/// sphere are over in less than 100 ms where there is room for no more runs.
fn submission(device: &Arc<Device>, bounces: Option<u32>) -> f64 {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.ron");
    let scene = Scene::load(&file).expect("it ships");
    let size = (256, 256);
    let options = RenderOptions { bounces, ..crate::common::render::plain() };
    let job = Job { size, max_depth: 8, seed: 0, first_sample: 0, goal: Goal::Samples(1 << 20) };
    let mut session = Session::on(vec![Arc::clone(device)]);
    session.view(&scene, &Frame::full(size), &options).expect("the scene flattens");
    let mut film = session.film(size).expect("the film fits");
    let mut ends = Vec::new();
    let mut observer = following(|_, _| {
        ends.push(Instant::now());
        if ends.len() < 24 { Next::GoOn } else { Next::Stop }
    });
    session.render(&job, &mut film, &mut observer).expect("the device renders");
    let mut seconds: Vec<f64> =
        ends.windows(2).skip(8).take(15).map(|pair| (pair[1] - pair[0]).as_secs_f64()).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// A submission is to take 100 ms, however fast the device is. Of the median of 15 the half and the double are allowed: a machine that is busy
/// with other things slows some. A fast device has all that there is room for done sooner.
#[test]
fn submissions_are_short() {
    let _machine = alone();
    let device = Arc::new(device::open());
    let adapted = submission(&device, None);
    let least = if device.class().software { 0.05 } else { 0.0 };
    assert!((least..0.2).contains(&adapted), "{adapted} s");
    // What is not adapted is not near it.
    let one = submission(&device, Some(1));
    assert!(one < 0.05, "{one} s a bounce");
}

#[test]
fn every_compiled_kernel_runs() {
    let _machine = alone();
    let files = Everything::new();
    // With the channels of --denoise too.
    let scenes = [
        ("nothing", scene_of(""), &[][..]),
        ("sphere", scene_of(SPHERE), &[Aov::Albedo, Aov::Normal]),
        ("everything", files.scene(World::default()), &[]),
    ];
    for (name, scene, aov) in &scenes {
        for scatter in [Scatter::Fused, Scatter::Linked, Scatter::Queues] {
            let device = Arc::new(device::open());
            assert!(device.timestamps, "this test needs a device that tells which kernels it ran");
            let ran = start(&device, scene, scatter, aov, true);
            assert!(ran.len() >= 2, "{name}, {scatter:?}: {ran:?}");
            assert_eq!(in_vain(&device, &ran), Vec::<String>::new(), "{name}, {scatter:?}");
        }
    }
}

/// Kernels that are compiled and not run are found, and so is one that is compiled twice: `generate`, which differs in the two. `accumulate` is
/// the same in both, and the device has kept it.
#[test]
fn a_kernel_that_is_compiled_in_vain_is_found() {
    let _machine = alone();
    let device = Arc::new(device::open());
    let scene = scene_of(SPHERE);
    let _ = start(&device, &scene, Scatter::Linked, &[], false);
    let ran = start(&device, &scene, Scatter::Fused, &[], true);
    let mut found = in_vain(&device, &ran);
    found.sort();
    assert_eq!(found, ["generate", "intersect", "refill", "scatter"]);
}

/// Makes a kernel ready that does nothing, in a text of its own.
fn make_ready(device: &Device, buffers: &Buffers, number: usize) {
    let text = format!(
        "override WORKGROUP_SIZE: u32 = 1; @compute @workgroup_size(WORKGROUP_SIZE) fn main() {{ let number = {number}; }}"
    );
    let module = naga::front::wgsl::parse_str(&text).expect("the kernel is valid");
    let spec = PipelineSpec {
        name: &number.to_string(),
        entry_point: "main",
        module: &module,
        text: &text,
        bindings: &BTreeMap::new(),
        workgroup: 1,
        constants: &[],
    };
    Pipeline::new(device, &spec, buffers).expect("the kernel compiles");
}

/// A device that kept every kernel would take 9 MiB more with each new scene of a process.
#[test]
fn a_device_keeps_the_kernels_used_last() {
    let _machine = alone();
    let device = Arc::new(device::open());
    let buffers = Buffers::create(&device, &[]).expect("no buffer is asked for");
    let compilations =
        |number: usize| device.kernels.compiled_names().iter().filter(|name| **name == number.to_string()).count();
    // One kernel more than a device keeps. The first is used again before, so that the second is dropped.
    for number in (0..KEPT_KERNELS).chain([0, KEPT_KERNELS]) {
        make_ready(&device, &buffers, number);
    }
    assert_eq!([0, 1, 2, KEPT_KERNELS].map(compilations), [1; 4]);
    for number in [2, KEPT_KERNELS, 0, 1] {
        make_ready(&device, &buffers, number);
    }
    assert_eq!([0, 1, 2, KEPT_KERNELS].map(compilations), [1, 2, 1, 1]);
}
