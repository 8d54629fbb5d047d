//! What it gains to link just what a scene requires: each scene with its own kernels and with everything on, in turn in one run.
//!
//! `cargo bench --bench specialised [-- ROUNDS SCENE.ron …]`, all scenes under scenes/ by default, on the device that GPU_RT_BENCH_DEVICE names
//! or the default one. Prints a line of a Markdown table for each scene: medians, and the least and the largest ratio of a round. Mesa's cache of
//! compiled shaders is off, so that `compile` is what the first render of a scene takes.

use std::path::PathBuf;
use std::process::Command;

use gpu_rt::output::exr::read_exr;
use gpu_rt::tradeoff::pace::median;
use serde_json::Value;

/// Of each image. Enough that what a render takes beside its paths does not show.
const SIZE: &str = "240x135";
const SAMPLES: &str = "16";

struct Run {
    paths_per_second: f64,
    compile: f64,
    /// From the start of the program to the end of the first pass, but for the scene's loading.
    start_up: f64,
    bytes: f64,
    pixels: Vec<[f32; 3]>,
}

fn run(scene: &PathBuf, features: &str, folder: &tempfile::TempDir) -> Run {
    let image = folder.path().join("out.exr");
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.args(["render", "--size", SIZE, "--spp", SAMPLES, "--json", "--quiet", "--features", features]);
    command.arg(scene).arg("-o").arg(&image).env("MESA_SHADER_CACHE_DISABLE", "true");
    if let Ok(device) = std::env::var("GPU_RT_BENCH_DEVICE") {
        command.args(["--device", &device]);
    }
    let output = command.output().expect("gpu-rt starts");
    assert!(output.status.success(), "{}: {}", scene.display(), String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let seconds = |part: &str| json["seconds"][part].as_f64().expect("seconds");
    Run {
        paths_per_second: json["paths_per_second"].as_f64().expect("paths a second"),
        compile: seconds("compile"),
        start_up: seconds("device") + seconds("compile") + seconds("first_pass"),
        bytes: json["gpu_bytes"].as_f64().expect("bytes"),
        pixels: read_exr(&image).expect("the image was written").rgb,
    }
}

fn main() {
    // Cargo passes `--bench`; the rest is ours.
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    let rounds: usize = args.first().map_or(3, |rounds| rounds.parse().expect("ROUNDS"));
    let mut scenes: Vec<PathBuf> = args.iter().skip(1).map(PathBuf::from).collect();
    if scenes.is_empty() {
        let files = std::fs::read_dir("scenes").expect("there is a folder scenes");
        scenes = files.filter_map(|file| Some(file.ok()?.path())).collect();
        scenes.retain(|path| path.extension().is_some_and(|ending| ending == "ron"));
        scenes.sort();
    }
    println!(
        "| scene | million paths/s | all on | ratio | compile, s | all on | ratio | start-up, s | all on | MB | all on |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for scene in &scenes {
        let both: Vec<[Run; 2]> = (0..rounds).map(|_| ["scene", "all"].map(|on| run(scene, on, &folder))).collect();
        for [own, all] in &both {
            assert!(own.pixels == all.pixels, "{}: the same work", scene.display());
        }
        let of = |which: usize, what: fn(&Run) -> f64| {
            median(&both.iter().map(|runs| what(&runs[which])).collect::<Vec<_>>())
        };
        let ratio = |what: fn([&Run; 2]) -> f64| {
            let ratios: Vec<f64> = both.iter().map(|[own, all]| what([own, all])).collect();
            let (low, high) = ratios.iter().fold((f64::MAX, 0.0f64), |(low, high), r| (low.min(*r), high.max(*r)));
            format!("{:.1} ({low:.1} to {high:.1})", median(&ratios))
        };
        let name = scene.file_stem().unwrap_or_default().to_string_lossy();
        println!(
            "| {name} | {:.3} | {:.3} | {} | {:.2} | {:.2} | {} | {:.2} | {:.2} | {:.1} | {:.1} |",
            of(0, |run| run.paths_per_second / 1e6),
            of(1, |run| run.paths_per_second / 1e6),
            ratio(|[own, all]| own.paths_per_second / all.paths_per_second),
            of(0, |run| run.compile),
            of(1, |run| run.compile),
            ratio(|[own, all]| all.compile / own.compile),
            of(0, |run| run.start_up),
            of(1, |run| run.start_up),
            of(0, |run| run.bytes / 1e6),
            of(1, |run| run.bytes / 1e6),
        );
    }
}
