//! Devices that fail: a Vulkan layer (tests/layer/fault.rs) returns errors instead of the driver.
//!
//! A fault stays once it has begun, so that a second attempt meets it too.

use std::fs;
use std::path::Path;
use std::process::Command;

use gpu_rt::gpu::spirv::uncontracted;
use gpu_rt::output::exr::{ExrImage, read_exr};
use tempfile::TempDir;

use crate::common::device::index as software;
use crate::common::fault::{Fault, put_layer_under, without_threads};
use crate::common::program::{Ran, command, ran};
use crate::sandbox::SPHERE;

#[path = "../layer/rough.rs"]
mod rough;

/// A render that a fault must end, in submissions of one bounce, with a checkpoint after each.
const ENDLESS: [&str; 6] = ["--spp", "1000000000", "--bounces", "1", "--checkpoint", "1ns"];

/// Calls at which a render fails, and whether they count from the first checkpoint on.
const CALLS: [(u32, bool); 3] = [(1, false), (1, true), (50, true)];

fn sandbox() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("sphere.ron"), SPHERE).expect("the scene is written");
    folder
}

fn render(folder: &Path, more: &[&str]) -> Command {
    command(folder, &[&["render", "sphere.ron", "--device", software()], more].concat())
}

fn image(folder: &Path) -> ExrImage {
    read_exr(&folder.join("sphere.exr")).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs the program to its end, with a fault in its way.
fn meets(mut command: Command, fault: &Fault) -> Ran {
    fault.put_under(&mut command);
    ran(&mut command)
}

/// Asserts that the fault has ended the program with one error, which names the device and says what to do.
#[track_caller]
fn the_error(ran: Ran, fault: &Fault) -> String {
    assert!(fault.has_happened(), "{fault:?} never happened: {ran:?}");
    let ran = ran.exits(1);
    let errors: Vec<_> = ran.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors, [ran.last_line()], "{fault:?}: {}", ran.stderr);
    let error = ran.last_line().to_string();
    assert!(error.contains(device_name()) && error.contains("gpu-rt devices"), "{fault:?}: {error}");
    error
}

/// The name of the device of the tests.
fn device_name() -> &'static str {
    static NAME: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    NAME.get_or_init(|| {
        let devices = ran(&mut command(Path::new("."), &["devices", "--json"])).exits(0).json();
        let device = &devices["devices"][software().parse::<usize>().expect("an index")];
        device["name"].as_str().expect("a name").to_string()
    })
}

/// Asserts that the fault ends a render without end, and that the image of the last checkpoint stays. `error` is a part of the message.
#[track_caller]
fn ends_a_render(functions: &[&str], result: &str, error: &str, variables: &[(&str, &str)]) {
    for function in functions {
        for (call, after) in CALLS {
            let folder = sandbox();
            let fault = Fault::new(folder.path(), function, call, result);
            let mut command = render(folder.path(), &ENDLESS);
            command.envs(variables.iter().copied());
            if after {
                command.env("GPU_RT_FAULT_AFTER", "sphere.exr");
            }
            let said = the_error(meets(command, &fault), &fault);
            assert!(said.contains(error), "{function}, call {call}: {said}");
            if after {
                let image = image(folder.path());
                assert_eq!((image.width, image.height), (20, 12));
                let samples = image.samples.expect("a layer of samples");
                assert!(samples.iter().any(|&samples| samples > 0), "{function}, call {call}: {samples:?}");
                let holds = format!("; sphere.exr holds {} samples per pixel. `gpu-rt render sphere.ron ", samples[0]);
                assert!(said.contains(&holds) && said.ends_with(" -o sphere.exr --resume` goes on"), "{said}");
            }
        }
    }
}

#[test]
fn a_lost_device_is_an_error_and_the_last_checkpoint_stays() {
    ends_a_render(&["vkWaitSemaphores", "vkGetSemaphoreCounterValue", "vkQueueSubmit"], "lost", "lost", &[]);
}

#[test]
fn a_device_without_memory_is_an_error_and_the_last_checkpoint_stays() {
    let functions = ["vkWaitSemaphores", "vkQueueSubmit", "vkBeginCommandBuffer", "vkEndCommandBuffer"];
    ends_a_render(&functions, "memory", "emory", &[]);
}

/// Asserts that a device which is lost once is opened again, and that the render goes on from its last checkpoint: the image is that of a render
/// without a fault. Each fault has a function, a call of it, and the interval of checkpoints.
fn is_opened_again(devices: &str, faults: &[(&str, u32, &str)]) {
    let full = sandbox();
    ran(&mut render(full.path(), &["--spp", "2048", "--quiet"])).exits(0);
    let full = image(full.path());
    let arguments = ["render", "sphere.ron", "--device", devices, "--spp", "2048", "--bounces", "1", "--checkpoint"];
    for (function, call, checkpoint) in faults {
        let folder = sandbox();
        let fault = Fault::once(folder.path(), function, *call, "lost");
        let mut command = command(folder.path(), &[&arguments[..], &[*checkpoint]].concat());
        if *checkpoint == "1ns" {
            command.env("GPU_RT_FAULT_AFTER", "sphere.exr");
        }
        let ran = meets(command, &fault);
        assert!(fault.has_happened(), "{fault:?} never happened: {ran:?}");
        ran.exits(0).on_stderr(&["the device is opened once more"]);
        let image = image(folder.path());
        assert_eq!(
            (&image.rgb, &image.variance, &image.samples),
            (&full.rgb, &full.variance, &full.samples),
            "{fault:?}"
        );
    }
}

#[test]
fn a_device_that_is_lost_once_is_opened_again() {
    // Before the first checkpoint, and after it.
    is_opened_again(
        software(),
        &[("vkQueueSubmit", 9, "1h"), ("vkWaitSemaphores", 1, "1ns"), ("vkQueueSubmit", 3, "1ns")],
    );
}

/// One of two devices is lost: both are opened again, and the image is that of one device.
#[test]
fn one_of_several_devices_that_is_lost_is_opened_again() {
    let twice = [software(), software()].join(",");
    is_opened_again(&twice, &[("vkQueueSubmit", 12, "1h"), ("vkQueueSubmit", 5, "1ns")]);
    // If it stays lost, the program does not wait for it.
    let folder = sandbox();
    let fault = Fault::new(folder.path(), "vkQueueSubmit", 1, "lost");
    let mut command = command(folder.path(), &[&["render", "sphere.ron", "--device", &twice], &ENDLESS[..]].concat());
    command.env("GPU_RT_FAULT_AFTER", "sphere.exr");
    the_error(meets(command, &fault), &fault);
    assert!(image(folder.path()).samples.is_some());
}

/// Older drivers have fences alone.
#[test]
fn a_device_that_is_lost_at_a_fence_is_an_error_and_the_last_checkpoint_stays() {
    let fences = [("GPU_RT_FENCES", "1")];
    ends_a_render(&["vkWaitForFences", "vkGetFenceStatus"], "lost", "lost", &fences);
}

/// The layer's waits return at once that their time is over; the program would wait for ten minutes.
#[test]
fn a_device_that_hangs_is_an_error_and_the_last_checkpoint_stays() {
    ends_a_render(&["vkWaitSemaphores"], "hang", "it has executed nothing for 600 seconds", &[]);
}

/// Every call of what is done before a render.
#[test]
fn a_device_that_cannot_be_set_up_is_an_error() {
    let functions = [
        ("vkCreateDevice", "lost"),
        ("vkAllocateMemory", "memory"),
        ("vkMapMemory", "memory"),
        ("vkCreateBuffer", "memory"),
        ("vkCreateComputePipelines", "memory"),
        ("vkAllocateCommandBuffers", "memory"),
    ];
    let mut errors = Vec::new();
    for (function, result) in functions {
        for call in 1.. {
            let folder = sandbox();
            let fault = Fault::new(folder.path(), function, call, result);
            let ran = meets(render(folder.path(), &[]), &fault);
            if call > 1 && !fault.has_happened() {
                ran.exits(0);
                break;
            }
            errors.push(the_error(ran, &fault));
        }
    }
    assert!(
        errors.iter().any(|error| error.contains("bytes of device memory, and the device has less")),
        "{errors:#?}"
    );
}

/// A small image with light paths.
const GLASS: &str = "Scene(image: (width: 20, height: 12), camera: (look_from: (0, 2, 5), look_at: (0, 0.5, 0), vertical_fov: 40),
    background: Solid((0, 0, 0)), materials: {\"floor\": Lambertian(albedo: Rgb(0.5, 0.5, 0.5)), \"glass\": Dielectric(ior: 1.5)},
    objects: [Quad(corner: (-3, 0, 3), u: (6, 0, 0), v: (0, 0, -6), material: \"floor\"), PointLight(at: (1, 4, 0), intensity: (9, 9, 9)),
        Sphere(center: (0, 1, 0), radius: 1, material: \"glass\")], render: (samples: 16, max_depth: 8))";

/// A driver that says that work is done which the device has not done, once: a submission, its half, or a dispatch. The render begins again, or
/// ends with an error. A warm-up that is left out does no harm.
#[test]
fn work_that_is_only_reported_as_done_is_found() {
    for (scene, function, result) in [
        (SPHERE, "vkQueueSubmit", "skip"),
        (SPHERE, "vkQueueSubmit", "half"),
        (SPHERE, "vkCmdDispatch", "skip"),
        (GLASS, "vkCmdDispatch", "skip"),
    ] {
        let folder = sandbox();
        fs::write(folder.path().join("sphere.ron"), scene).expect("the scene is written");
        ran(&mut render(folder.path(), &["-o", "full.exr", "--quiet"])).exits(0);
        let full = read_exr(&folder.path().join("full.exr")).expect("it is read");
        let mut again = 0;
        for call in 1.. {
            let fault = Fault::once(folder.path(), function, call, result);
            let ran = meets(render(folder.path(), &["--force", "--scatter", "fused", "--bounces", "64"]), &fault);
            if !fault.has_happened() {
                break;
            }
            if ran.code() != 0 {
                let said = the_error(ran, &fault);
                let words = "the driver reported work as done that the device has not done";
                assert!(said.contains(words), "{fault:?}: {said}");
                continue;
            }
            again += usize::from(ran.stderr.contains("the device is opened once more"));
            let image = image(folder.path());
            assert_eq!((&image.rgb, &image.variance), (&full.rgb, &full.variance), "{fault:?}: {}", ran.stderr);
        }
        assert!(again > 0, "{function}, {result}: no render begins again");
    }
}

/// With all sums and products rounded, as a device gets kernels whose driver fuses them, the way of linking does not show either. Mesa's software
/// driver fuses none, but it takes `(x + y) - x` for `y`, and then no longer does.
#[test]
fn without_contraction_the_way_of_linking_does_not_show() {
    let folder = sandbox();
    let exact = |arguments: &[&str]| ran(command(folder.path(), arguments).env("GPU_RT_NO_CONTRACTION", "1")).exits(0);
    let devices = exact(&["devices", "--json"]).json();
    let numerics = &devices["devices"][software().parse::<usize>().expect("an index")]["numerics"];
    assert_eq!((&numerics["two_sum"], &numerics["contraction"]), (&true.into(), &false.into()), "{numerics:#}");
    fs::write(folder.path().join("glass.ron"), GLASS).expect("the scene is written");
    let render = |scatter: &str| {
        let arguments = ["render", "glass.ron", "--device", software(), "--quiet", "--force", "--scatter", scatter];
        exact(&[&arguments[..], &["-o", "sphere.exr"]].concat());
        image(folder.path()).rgb
    };
    let fused = render("fused");
    assert!(fused == render("linked") && fused == render("queues"));
}

/// A device that lacks memory once gets buffers of fewer slots.
#[test]
fn a_render_that_does_not_fit_has_fewer_slots() {
    let full = sandbox();
    let usual = ran(&mut render(full.path(), &["--json", "--quiet"])).exits(0).json();
    let full = image(full.path());
    let mut fitted = 0;
    for call in 1.. {
        let folder = sandbox();
        let fault = Fault::once(folder.path(), "vkCreateBuffer", call, "memory");
        let ran = meets(render(folder.path(), &["--json", "--quiet"]), &fault);
        if !fault.has_happened() {
            break;
        }
        if ran.code() != 0 {
            the_error(ran, &fault);
            continue;
        }
        let report = ran.json();
        fitted += usize::from(report["gpu_bytes"].as_u64() < usual["gpu_bytes"].as_u64());
        assert_eq!((&image(folder.path()).rgb, &report["seed"]), (&full.rgb, &usual["seed"]), "{fault:?}");
    }
    assert!(fitted > 0, "no render goes on with fewer slots");
}

/// The last waits may find that all is done.
#[test]
fn a_device_that_hangs_at_any_wait_lets_the_program_end() {
    let mut errors = 0;
    for call in 1.. {
        let folder = sandbox();
        let fault = Fault::new(folder.path(), "vkWaitSemaphores", call, "hang");
        let ran = meets(render(folder.path(), &[]), &fault);
        match ran.code() {
            0 => assert_eq!(image(folder.path()).samples, Some(vec![16; 240])),
            _ => {
                the_error(ran, &fault);
                errors += 1;
            }
        }
        if !fault.has_happened() {
            break;
        }
    }
    assert!(errors > 0, "the render waits for nothing");
}

/// wgpu waits when it drops a queue; the image is written by then.
#[test]
fn a_device_that_fails_after_the_render_does_no_harm() {
    for result in ["lost", "memory"] {
        let folder = sandbox();
        let fault = Fault::new(folder.path(), "vkQueueWaitIdle", 1, result);
        meets(render(folder.path(), &[]), &fault).exits(0);
        assert!(fault.has_happened());
        assert_eq!(image(folder.path()).samples, Some(vec![16; 240]));
    }
}

/// Quotients and roots that are as inexact as those of GPUs, for `make test-drivers`.
#[test]
fn rough_quotients_change_the_image() {
    let folder = sandbox();
    let image_with = |rough: &str| {
        let mut command = render(folder.path(), &["--spp", "1", "--force"]);
        put_layer_under(&mut command);
        ran(command.env("GPU_RT_ROUGH", rough)).exits(0);
        image(folder.path()).rgb
    };
    let [exact, up, down] = ["", "up", "down"].map(image_with);
    assert!(exact != up && exact != down && up != down);
}

#[test]
fn rough_quotients_and_roots_have_a_factor_and_a_mix_is_a_sum() {
    let text = "@group(0) @binding(0) var<storage, read_write> a: array<vec4<f32>>;
        @compute @workgroup_size(1) fn main() {
            a[0] = a[1] / a[2] + vec4(sqrt(a[3].x)) + mix(a[4], a[5], a[6]);
        }";
    let module = naga::front::wgsl::parse_str(text).expect("it parses");
    let plain = uncontracted(&module, "main", &[], vec![0]).expect("it is written");
    let rough = rough::with_rough_quotients(&plain, 1f32.next_up());
    let count = |words: &[u32], opcode| rough::instructions(words).filter(|(own, _)| *own == opcode).count();
    // Two factors and a product for a quotient and a root; the difference, product and sum of the mix; and these five are not contracted.
    let [constant, composite, extended, decorate, add, subtract, multiply] = [43, 44, 12, 71, 129, 131, 133];
    let added = |opcode| count(&rough, opcode) - count(&plain, opcode);
    assert_eq!([constant, composite, decorate, add, subtract, multiply].map(added), [1, 1, 5, 1, 1, 3]);
    assert_eq!((count(&plain, extended), count(&rough, extended)), (2, 1));
    // Each identifier is less than the bound, and none has two meanings.
    assert_eq!(rough[3], plain[3] + 6);
}

/// Two devices that only their numbers distinguish: the layer has each device twice.
#[test]
fn a_name_that_two_devices_have_chooses_neither() {
    let folder = sandbox();
    let twins = |arguments: &[&str]| {
        let mut command = command(folder.path(), arguments);
        put_layer_under(&mut command);
        ran(command.env("GPU_RT_TWINS", "1"))
    };
    let devices = twins(&["devices", "--json"]).exits(0).json();
    let devices = devices["devices"].as_array().expect("a list");
    let same: Vec<_> = (0..devices.len()).filter(|&index| devices[index]["name"] == device_name()).collect();
    assert_eq!(same.len(), 2, "{devices:#?}");
    let mut refused = twins(&["render", "sphere.ron", "--device", device_name()]).exits(2);
    for index in same {
        refused = refused.on_stderr(&["several devices have this name", &format!("\n  {index}: {}", device_name())]);
        twins(&["render", "sphere.ron", "--device", &index.to_string()]).exits(0);
    }
}

#[test]
fn without_a_thread_the_program_does_the_same() {
    let folder = sandbox();
    ran(&mut render(folder.path(), &["--size", "20x120", "-o", "with.exr"])).exits(0);
    let commands: [&[&str]; 4] = [
        &["render", "sphere.ron", "--size", "20x120", "--device", software()],
        &["check", "sphere.ron"],
        &["plan", "sphere.ron"],
        &["compare", "sphere.exr", "with.exr"],
    ];
    for arguments in commands {
        let mut command = command(folder.path(), arguments);
        let mark = without_threads(&mut command, folder.path());
        ran(&mut command).exits(0);
        assert!(mark.exists(), "{arguments:?} asks for no thread");
    }
    let with = read_exr(&folder.path().join("with.exr")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(image(folder.path()).rgb, with.rgb);
}
