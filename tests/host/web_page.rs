//! Pages that render themselves: all shipped scenes keep within what every browser with WebGPU allows.

use std::path::Path;

use crate::common::files::files;
use gpu_rt::flatten::flatten;
use gpu_rt::gpu::device::DeviceClass;
use gpu_rt::gpu::layout::BindingKind;
use gpu_rt::job::{Goal, Job};
use gpu_rt::options::{RenderOptions, Scatter};
use gpu_rt::page::{BINDING_BYTES, STORAGE_BUFFERS, needs, plan_and_data, with_camera};
use gpu_rt::plan::Plan;
use gpu_rt::render::empty_film;
use gpu_rt::scene::Scene;

/// What WebGPU guarantees beside these (W3C, "WebGPU", section 3.6.2).
const UNIFORM_BUFFERS: usize = 12;
const UNIFORM_BYTES: u64 = 65_536;
const INVOCATIONS: u32 = 256;

const SIZE: (u32, u32) = (640, 360);

fn options() -> RenderOptions {
    RenderOptions { scatter: Some(Scatter::Linked), ..RenderOptions::default() }
}

fn job() -> Job {
    Job { size: SIZE, max_depth: 50, seed: 0, first_sample: 0, goal: Goal::Samples(1 << 20) }
}

#[test]
fn shipped_scenes_keep_within_the_limits_of_every_browser() {
    let all = [".ron", ".glb", ".xml", ".pbrt"].map(|ending| files(Path::new("scenes"), ending, false));
    let all: Vec<_> = all.into_iter().flatten().collect();
    assert!(all.len() >= 20, "{all:?}");
    let mut beyond = 0;
    for path in &all {
        let name = path.display();
        let scene = Scene::load(path).unwrap_or_else(|error| panic!("{name}: {error}"));
        let flat = with_camera(flatten(&scene, SIZE, &options()).expect("it flattens"));
        let plan = Plan::within(&flat, &options(), DeviceClass::default(), &job(), STORAGE_BUFFERS).expect("it links");
        assert_eq!(needs(&plan), Vec::<String>::new(), "{name}");
        for kernel in plan.kernels() {
            let count = |is: fn(BindingKind) -> bool| kernel.bindings.values().filter(|own| is(own.kind)).count();
            let (uniform, storage) =
                (count(|kind| kind == BindingKind::Uniform), count(|kind| kind != BindingKind::Uniform));
            assert!(storage <= STORAGE_BUFFERS && uniform <= UNIFORM_BUFFERS, "{name}: {} {storage}", kernel.name);
            let shared = |(_, variable): (_, &naga::GlobalVariable)| variable.space == naga::AddressSpace::WorkGroup;
            assert!(!kernel.module.global_variables.iter().any(shared), "{name}: {} has workgroup memory", kernel.name);
        }
        assert!(plan.tuning.workgroup <= INVOCATIONS);
        for buffer in plan.buffers() {
            let most = if buffer.binding() == "uniform" { UNIFORM_BYTES } else { BINDING_BYTES };
            assert!(buffer.bytes <= most, "{name}: {} has {} bytes", buffer.name, buffer.bytes);
        }
        // As a render of its own would bind them, some scenes need more, and that is said.
        let usual = Plan::new(&flat, &options(), DeviceClass::default(), &job()).expect("it links");
        beyond += usize::from(needs(&usual).iter().any(|need| need.contains("storage buffers")));
    }
    assert!(beyond >= 5, "{beyond}");
}

/// The player finds all that it asks the plan for, at offsets of the kernels.
#[test]
fn the_plan_of_a_page_is_complete() {
    let scene = Scene::load(Path::new("scenes/window.ron")).expect("it is there");
    let flat = with_camera(flatten(&scene, SIZE, &options()).expect("it flattens"));
    let plan = Plan::within(&flat, &options(), DeviceClass::default(), &job(), STORAGE_BUFFERS).expect("it links");
    let film = empty_film(&flat, SIZE, &plan.options).expect("it fits");
    let (json, data) = plan_and_data(&plan, &job(), &film, true).expect("it links");
    let names = |list: &str| -> Vec<String> {
        let all = json[list].as_array().expect("it is a list");
        all.iter().map(|one| one["name"].as_str().expect("it has a name").to_owned()).collect()
    };
    let (kernels, buffers) = (names("kernels"), names("buffers"));
    for stage in ["generate", "light_path", "accumulate", "receipt"] {
        assert!(kernels.iter().any(|kernel| json["stages"][stage] == **kernel), "{stage}");
    }
    let bounce = json["stages"]["bounce"].as_array().expect("it is a list");
    assert!(bounce.iter().all(|stage| kernels.iter().any(|kernel| stage == kernel)), "{bounce:?}");
    for kernel in json["kernels"].as_array().expect("it is a list") {
        for binding in kernel["bindings"].as_array().expect("it is a list") {
            assert!(buffers.iter().any(|buffer| binding[2] == **buffer), "{binding}");
        }
    }
    // The contents of buffers follow each other without a gap.
    let mut end = 0;
    for buffer in json["buffers"].as_array().expect("it is a list") {
        if let Some([first, length]) = buffer["contents"].as_array().map(|both| [0, 1].map(|i| both[i].as_u64())) {
            assert_eq!(first, Some(end), "{buffer}");
            end += length.expect("it is a number");
        }
    }
    assert_eq!(end, data.len() as u64);
    for (group, members) in [
        ("settings", "camera_place forward pixel_x pixel_y image_width film_width end_sample slots"),
        ("window", "first_block end bounces first_pixel pixels begins receipt first_slot end_slot"),
        ("counters", "next records idle nan infinite cut refused receipt counts light"),
        ("film", "samples runs rejected saturated sums"),
    ] {
        for member in members.split(' ') {
            assert!(json[group]["members"][member][0].is_u64(), "{group}.{member}");
        }
    }
    assert_eq!(json["probe"]["expected"].as_array().map(Vec::len), Some(5));
}
