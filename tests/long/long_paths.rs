//! What takes minutes: `make test-long`. No sample of any scene that ships is rejected, over 1e9 paths.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use gpu_rt::gpu::device::Adapters;
use gpu_rt::scene::Scene;
use serde_json::Value;

/// Over all scenes together, in equal shares. That a rejected sample is seen is tested in tests/program/cli.rs.
const PATHS: u64 = 1_000_000_000;

/// The scenes under scenes/ and scenes/test.
fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let folders = [root.clone(), root.join("test")];
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("scenes can be listed"));
    let paths = entries.map(|entry| entry.expect("scenes can be listed").path());
    let mut found: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|ending| ending == "ron")).collect();
    found.sort();
    found
}

/// The program on the tests' device, with its default settings and --strict.
fn render(scene: &Path, samples: u64, folder: &Path) -> Output {
    let device = std::env::var("GPU_RT_TEST_DEVICE").unwrap_or_else(|_| {
        let names = Adapters::find().names();
        let index = names.iter().position(|(name, _)| name.software);
        index.expect("the tests need a software Vulkan driver").to_string()
    });
    let mut command = Command::new(env!("CARGO_BIN_EXE_gpu-rt"));
    command.arg("render").arg(scene).args(["--strict", "--json", "--device", &device, "-o", "image.exr"]);
    command.args(["--spp", &samples.to_string()]).current_dir(folder);
    command.output().expect("the program starts")
}

/// Paths and rejected samples of a render.
fn counts(output: &Output) -> [u64; 2] {
    let json: Value = serde_json::from_slice(&output.stdout).expect("a report");
    ["paths", "rejected_samples"].map(|name| json[name].as_u64().expect("a number"))
}

#[test]
#[ignore = "takes minutes"]
fn no_scene_has_a_rejected_sample() {
    let scenes = scenes();
    assert!(scenes.len() > 40, "{scenes:?}");
    let share = PATHS.div_ceil(scenes.len() as u64);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut all = 0;
    let mut broken = Vec::new();
    for path in &scenes {
        let image = Scene::load(path).expect("the scene loads").image;
        let samples = share.div_ceil(u64::from(image.width) * u64::from(image.height));
        let start = std::time::Instant::now();
        let output = render(path, samples, folder.path());
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(0) || words.contains("--strict"), "{}: {words}", path.display());
        let [paths, rejected] = counts(&output);
        println!("{}: {paths} paths in {:.1} s, {rejected} rejected", path.display(), start.elapsed().as_secs_f64());
        if rejected > 0 || output.status.code() != Some(0) {
            broken.push(format!("{}: {}", path.display(), words.lines().last().unwrap_or_default()));
        }
        all += paths;
    }
    assert!(all >= PATHS, "{all} paths");
    assert!(broken.is_empty(), "{broken:#?}");
}
