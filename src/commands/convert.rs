//! `gpu-rt convert`: a scene of glTF or of Mitsuba in the form of a scene file.

use std::path::{Path, PathBuf};

use clap::Args;

use super::console::tell;
use super::outputs::check_name;
use super::scene::convert;
use crate::cli::GltfArgs;
use crate::error::{Error, Result};
use crate::output::destination::{Destination, same_file};
use crate::output::{atomic, writable};
use crate::scene::{Assets, write_exr, write_ply};

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The .glb or .gltf file, whose meshes and images stay in it, the .xml of Mitsuba, or the .pbrt.
    pub scene: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
    /// The scene file to write.
    #[arg(short, long, value_name = "SCENE.ron")]
    pub output: PathBuf,
    /// Overwrite a scene file that is there.
    #[arg(long)]
    pub force: bool,
}

/// Writes the scene file, and says what is not as the glTF file has it.
pub fn run(args: &ConvertArgs) -> Result<()> {
    let (from, to) = (&args.scene, &args.output);
    check_name(from, "a .glb or .gltf file")?;
    check_name(to, "a scene file")?;
    let refused = |reason: String| Error::Usage(format!("{}: {reason}; nothing has been written", to.display()));
    let check_inputs = |to: &Path, inputs: Vec<&PathBuf>| match inputs.iter().find(|input| same_file(to, input)) {
        Some(input) => {
            Err(refused(format!("it would overwrite the input {}: give another name with -o", input.display())))
        }
        None => Ok(()),
    };
    if to.extension().is_none_or(|ending| ending != "ron") {
        return Err(refused("expected a name that ends in .ron, with -o".to_owned()));
    }
    let not_writable = |reason| refused(format!("cannot write: {reason}. Give another name with -o"));
    let destination = writable::check(to).map_err(not_writable)?;
    check_inputs(to, args.gltf.sky.iter().chain([from]).collect())?;
    // A pipe or a device is not overwritten.
    let may = || match &destination {
        Destination::File(target) if target.exists() && !args.force => {
            Err("it is there already: --force overwrites it".to_owned())
        }
        _ => Ok(()),
    };
    may().map_err(refused)?;
    let mut assets = Assets::default();
    let scene = convert(from, &args.gltf, to, &mut assets)?;
    // Also the files that the scene names: their names may end in .ron.
    check_inputs(to, assets.files.keys().collect())?;
    scene.warnings().iter().for_each(|warning| tell(&format!("warning: {warning}")));
    let (meshes, images): (Vec<_>, Vec<_>) = (scene.made_meshes().collect(), scene.made_images().collect());
    for name in meshes.iter().map(|(name, _)| name).chain(images.iter().map(|(name, _)| name)) {
        let path = to.with_file_name(name);
        check_inputs(&path, assets.files.keys().collect())?;
        if path.exists() && !args.force {
            return Err(refused(format!("{} is there already: --force overwrites it", path.display())));
        }
    }
    for (name, mesh) in meshes {
        atomic::replace_if(&to.with_file_name(name), |file| write_ply(mesh, file), || Ok(()))?;
    }
    for (name, image) in images {
        atomic::replace_if(&to.with_file_name(name), |file| write_exr(image, file), || Ok(()))?;
    }
    atomic::replace_if(to, |file| std::io::Write::write_all(file, scene.text().as_bytes()), may)
}
