//! What the feature changes of the program.

use std::process::Command;

/// The crates below the renderer, each with its version and its features, as cargo resolves them.
fn below_renderer(features: &[&str]) -> Vec<String> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["tree", "--offline", "--edges", "normal", "--prefix", "none"]);
    cargo.args(["--format", "{p} {f}", "--no-dedupe"]).args(features);
    let output = cargo.output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = ["wgpu", "wgpu-core", "wgpu-hal", "wgpu-types", "naga", "ash"];
    let text = String::from_utf8(output.stdout).expect("cargo prints text");
    let lines = text.lines().filter(|line| names.contains(&line.split(' ').next().unwrap_or_default()));
    let mut lines: Vec<String> = lines.map(str::to_owned).collect();
    lines.sort();
    lines.dedup();
    assert!(lines.len() >= names.len(), "{lines:?}");
    lines
}

/// `gpu-rt devices` lists what these crates find. The window adds no backend to them and no other copy, so that the list is the same.
#[test]
fn the_renderer_is_built_alike_with_and_without_a_window() {
    let without = below_renderer(&[]);
    assert_eq!(below_renderer(&["--features", "window"]), without);
    // The control: the window does add crates.
    assert!(without.iter().all(|line| !line.starts_with("eframe")));
}
