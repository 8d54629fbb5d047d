//! What takes minutes: `make test-long`. No sample of any scene that ships is rejected, over 1e9 paths.

use std::path::Path;

use crate::common::device;
use crate::common::files::files;
use crate::common::program::{self, Ran};
use gpu_rt::scene::Scene;

/// Over all scenes together, in equal shares. That a rejected sample is seen is tested in tests/program/cli.rs.
const PATHS: u64 = 1_000_000_000;

/// The program on the tests' device, with its default settings and --strict.
fn render(scene: &Path, samples: u64, folder: &Path) -> Ran {
    let scene = scene.to_str().expect("UTF-8");
    let options = ["--strict", "--json", "--device", device::index(), "-o", "image.exr", "--spp", &samples.to_string()];
    program::run(folder, &[&["render", scene], &options[..]].concat())
}

#[test]
#[ignore = "takes minutes"]
fn no_scene_has_a_rejected_sample() {
    let scenes: Vec<_> =
        ["scenes", "scenes/test"].into_iter().flat_map(|folder| files(folder, ".ron", false)).collect();
    assert!(scenes.len() > 40, "{scenes:?}");
    let share = PATHS.div_ceil(scenes.len() as u64);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut all = 0;
    let mut broken = Vec::new();
    for path in &scenes {
        let image = Scene::load(path).expect("the scene loads").image;
        let samples = share.div_ceil(u64::from(image.width) * u64::from(image.height));
        let start = std::time::Instant::now();
        let ran = render(path, samples, folder.path());
        assert!(ran.code() == 0 || ran.stderr.contains("--strict"), "{}: {}", path.display(), ran.stderr);
        let report = ran.json();
        let [paths, rejected] = ["paths", "rejected_samples"].map(|name| report[name].as_u64().expect("a number"));
        println!("{}: {paths} paths in {:.1} s, {rejected} rejected", path.display(), start.elapsed().as_secs_f64());
        if rejected > 0 || ran.code() != 0 {
            broken.push(format!("{}: {}", path.display(), ran.last_line()));
        }
        all += paths;
    }
    assert!(all >= PATHS, "{all} paths");
    assert!(broken.is_empty(), "{broken:#?}");
}
