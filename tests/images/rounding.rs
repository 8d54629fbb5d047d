//! Drivers that round a quotient otherwise where other code surrounds it, as NVIDIA's does. There `--features all` changes last digits, and with
//! them the way of some paths. Here a layer gives all quotients and roots another last digit (tests/layer/rough.rs).

use std::path::Path;

use crate::common::paired::{PARTED, share_of_noise};
use crate::common::stats::same_expectation_paired;
use crate::common::{device, fault, program};
use gpu_rt::output::exr::{ExrImage, read_exr};

/// False alarms of a comparison of images.
const ALPHA: f64 = 1e-6;

/// What a path that goes the same way may differ by, of itself: some 80 quotients and roots, each off by 2^-23.
const ROUNDING: f32 = 1e-5;

fn render(scene: &str, options: &[&str], rounds_up: bool) -> ExrImage {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let usual = ["render", scene.to_str().expect("UTF-8"), "-o", "out.exr", "--device", device::index()];
    let size = ["--size", "64x64", "--spp", "64"];
    let mut command = program::command(folder.path(), &[&usual as &[&str], &size, options].concat());
    if rounds_up {
        fault::put_layer_under(&mut command);
        command.env("GPU_RT_ROUGH", "up").env("GPU_RT_NO_CONTRACTION", "1");
    }
    program::ran(&mut command).exits(0);
    read_exr(&folder.path().join("out.exr")).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn renders_differ_by_less_than_a_fifth_of_the_noise_where_quotients_round_otherwise() {
    for scene in ["weekend.ron", "mesh.ron"] {
        let usual = render(scene, &[], false);
        let share =
            |other: &ExrImage| share_of_noise(&usual.rgb, usual.variance.as_ref().expect("variances"), &other.rgb);
        let settled = |a: f32, b: f32| if (a - b).abs() <= ROUNDING * a.abs() { a } else { b };
        let paired = |rgb: &[[f32; 3]]| {
            let pairs = usual.rgb.iter().zip(rgb);
            let settled: Vec<_> = pairs.map(|(a, b)| [0, 1, 2].map(|c| settled(a[c], b[c]))).collect();
            same_expectation_paired(&usual.rgb, &settled, ALPHA)
        };
        let rough = render(scene, &[], true);
        println!("{scene}: {}", share(&rough));
        // The layer is at work.
        assert!(share(&rough) > 0.0 && share(&rough) < PARTED, "{scene}: {}", share(&rough));
        paired(&rough.rgb).unwrap_or_else(|error| panic!("{scene}: {error}"));
        // What is no rounding is found: other paths, and a hundredth more light.
        let other = render(scene, &["--seed", "1"], false);
        assert!((share(&other) - 1.0).abs() < 0.25, "{scene}: {}", share(&other));
        let brighter: Vec<_> = rough.rgb.iter().map(|rgb| rgb.map(|v| 1.01 * v)).collect();
        assert!(paired(&brighter).is_err(), "{scene}: a hundredth more light is not found");
    }
}
