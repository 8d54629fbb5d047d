//! Measures what kernels cost before the first pass, with an empty cache: processor seconds and seconds of the clock of
//! `gpu-rt render SCENE --size 64x36 --spp 1`, as it is and with each way of linking. It prints a table for docs/dev/performance.md.
//!
//! `cargo bench --bench compile [-- --program PATH]`: the program to measure, if it is not the one that cargo builds. Another driver: set
//! `VK_DRIVER_FILES`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

#[path = "../tests/common/took.rs"]
mod took;

use took::{Took, median, of_children};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SCENES: [&str; 6] = ["weekend.ron", "cornell.ron", "mesh.ron", "instances.ron", "workshop.ron", "still-life.glb"];
const WAYS: [&[&str]; 3] = [&[], &["--scatter", "fused"], &["--scatter", "linked"]];
/// Every time is the median of so many.
const TIMES: usize = 3;

/// Renders a sample with an empty cache of kernels. Returns what that took, and the driver.
fn render(program: &Path, scene: &Path, way: &[&str]) -> Result<(Took, String)> {
    let folder = tempfile::tempdir()?;
    let mut command = Command::new(program);
    command.arg("render").arg(scene).args(["--size", "64x36", "--spp", "1", "--quiet", "--json", "-o"]);
    command.arg(folder.path().join("a.exr")).args(way).stderr(Stdio::inherit());
    command.env("MESA_SHADER_CACHE_DIR", folder.path().join("cache"));
    let (start, before) = (Instant::now(), of_children());
    let output = command.output()?;
    let took = Took { wall: start.elapsed().as_secs_f64(), processor: of_children() - before };
    if !output.status.success() {
        return Err(format!("{}: {}", scene.display(), output.status).into());
    }
    let report: Value = serde_json::from_slice(&output.stdout)?;
    Ok((took, report["driver"].as_str().unwrap_or_default().to_string()))
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let program = match arguments.as_slice() {
        [] => PathBuf::from(env!("CARGO_BIN_EXE_gpu-rt")),
        [option, path] if option == "--program" => PathBuf::from(path),
        _ => return Err("expected nothing, or --program PATH".into()),
    };
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for (number, scene) in SCENES.iter().enumerate() {
        let mut cells = Vec::new();
        for way in WAYS {
            let all = (0..TIMES).map(|_| render(&program, &scenes.join(scene), way)).collect::<Result<Vec<_>>>()?;
            if number == 0 && cells.is_empty() {
                println!("{}, processor seconds / seconds:\n", all[0].1);
                println!("| scene | by default | fused | linked |\n|---|---|---|---|");
            }
            let of = |part: fn(&Took) -> f64| median(all.iter().map(|(took, _)| part(took)).collect());
            cells.push(format!("{:.1} / {:.1}", of(|took| took.processor), of(|took| took.wall)));
        }
        println!("| {scene} | {} |", cells.join(" | "));
    }
    Ok(())
}
