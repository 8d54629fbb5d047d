//! `gpu-rt convert`: a glTF scene in the form of a scene file.

use std::path::PathBuf;

use clap::Args;

use super::console::tell;
use super::outputs::check_name;
use super::scene::convert;
use crate::cli::GltfArgs;
use crate::error::{Error, Result};
use crate::output::{atomic, destination::same_file, writable};

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The .glb or .gltf file. Its meshes and images stay in it.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The scene file to write.
    #[arg(short, long, value_name = "SCENE.ron")]
    pub output: PathBuf,
}

/// Writes the scene file, and says what is not as the glTF file has it.
pub fn run(args: &ConvertArgs) -> Result<()> {
    let (from, to) = (&args.scene, &args.output);
    check_name(from, "a .glb or .gltf file")?;
    check_name(to, "a scene file")?;
    let refuse = |reason: String| Err(Error::Usage(format!("{}: {reason}; nothing has been written", to.display())));
    if to.extension().is_none_or(|ending| ending != "ron") {
        return refuse("expected a name that ends in .ron, with -o".to_owned());
    }
    if let Err(reason) = writable::check(to) {
        return refuse(format!("cannot write: {reason}. Give another name with -o"));
    }
    if let Some(input) = args.gltf.sky.iter().chain([from]).find(|input| same_file(to, input)) {
        return refuse(format!("it would overwrite the input {}: give another name with -o", input.display()));
    }
    let scene = convert(from, &args.gltf, to)?;
    scene.warnings().iter().for_each(|warning| tell(&format!("warning: {warning}")));
    atomic::write(to, scene.text().as_bytes())
}
