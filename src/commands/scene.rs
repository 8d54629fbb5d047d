//! The scene that a command names: a file, or `-` for standard input.

use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::console::tell;
use crate::cli::{GltfArgs, SceneArgs};
use crate::error::{Error, Result};
use crate::flatten::{DeviceScene, flatten};
use crate::job::Size;
use crate::options::{MAX_DEPTH, OptionSpec, RenderOptions};
use crate::output::destination::is_standard;
use crate::scene::{AnimationFrame, Assets, FPS, GltfOptions, OnProgress, Scene, Sky, is_gltf};

/// Reads the scene. Of one on standard input, paths are relative to the current folder, and errors name `<stdin>`.
pub fn load_with(scene: &SceneArgs, progress: &mut OnProgress, assets: &mut Assets) -> Result<Scene> {
    load_from(scene, false, std::io::stdin().lock(), progress, assets)
}

/// Reads the scene. `input` is read in place of standard input. With `motion`, the frames before and after that of a glTF file are read too.
pub fn load_from(
    scene: &SceneArgs,
    motion: bool,
    input: impl Read,
    progress: &mut OnProgress,
    assets: &mut Assets,
) -> Result<Scene> {
    let options = options(&scene.gltf, &scene.path)?;
    match is_standard(&scene.path) {
        true => {
            options.refuse(&scene.path, false)?;
            Scene::read(input, Path::new("<stdin>"), progress).map(|scene| scene.in_frame(options.frame))
        }
        false => {
            let mut at = |frame: Option<AnimationFrame>| {
                Scene::load_as(&scene.path, &GltfOptions { frame, ..options.clone() }, progress, assets)
            };
            let around = |frame: AnimationFrame| -> Result<_> {
                let mut later = |frames| at(Some(AnimationFrame { number: frame.number + frames, ..frame }));
                Ok(Box::new([later(-1.0)?, later(1.0)?]))
            };
            let neighbours = options.frame.filter(|_| motion && is_gltf(&scene.path)).map(around).transpose()?;
            let mut found = at(options.frame)?;
            found.neighbours = neighbours;
            Ok(found)
        }
    }
}

/// Reads the scene without showing progress.
pub fn load(scene: &SceneArgs) -> Result<Scene> {
    load_with(scene, &mut |_, _, _| {}, &mut Assets::default())
}

/// The scene of a glTF file, whose paths are relative to the scene file that it is written as.
pub fn convert(from: &Path, gltf: &GltfArgs, to: &Path, assets: &mut Assets) -> Result<Scene> {
    Scene::of_model(from, to, &options(gltf, from)?, assets)
}

/// The frame that is asked for.
///
/// # Errors
/// `Error::Usage` if frames of a glTF file have a rate and no number.
pub fn frame_of(args: &GltfArgs, path: &Path) -> Result<Option<AnimationFrame>> {
    // A scene file without a number is in frame 0, and a glTF file in its rest pose.
    let number = args.frame.or(args.fps.filter(|_| !is_gltf(path)).map(|_| 0.0));
    if let (None, Some(fps)) = (number, args.fps) {
        return Err(Error::Usage(format!("--fps {fps}: expected --frame N beside it, whose time it says")));
    }
    Ok(number.map(|number| AnimationFrame { number, fps: args.fps.unwrap_or(FPS) }))
}

/// The glTF options. Their paths are relative to the current folder, and those of scenes to their own.
fn options(args: &GltfArgs, path: &Path) -> Result<GltfOptions> {
    let frame = frame_of(args, path)?;
    let image = |path: &PathBuf| std::path::absolute(path).unwrap_or(path.clone()).to_string_lossy().into_owned();
    let sky = args.sky.as_ref().map(|path| Sky::of_word(path).unwrap_or_else(|| Sky::Image(image(path))));
    let camera = args.camera.clone();
    let (defines, lossless) = (args.define.clone(), args.lossless);
    Ok(GltfOptions { camera, sky, sun: args.sun, watts: args.watts, thin: args.thin, frame, defines, lossless })
}

/// The scene's name, which names of outputs begin with: that of its file without the ending, or `stdin`.
pub fn stem_of(path: &Path) -> &OsStr {
    match is_standard(path) {
        true => OsStr::new("stdin"),
        false => path.file_stem().unwrap_or_default(),
    }
}

/// The name that reports give the scene: that of its file, or `stdin`.
pub fn name_of(path: &Path) -> String {
    match is_standard(path) {
        true => "stdin".to_string(),
        false => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

/// The size of the image, and the scene flattened for it.
pub fn flatten_for(scene: &Scene, size: Option<Size>, options: &RenderOptions) -> Result<((u32, u32), DeviceScene)> {
    let size = size_of(scene, size);
    Ok((size, flatten(scene, size, options)?))
}

/// The size of the image: the requested one, or the scene's.
pub fn size_of(scene: &Scene, requested: Option<Size>) -> (u32, u32) {
    let of_scene = (scene.image.width, scene.image.height);
    requested.map_or(of_scene, |size| size.in_pixels(of_scene))
}

/// The options that bias the result or are less exact, with their values.
pub fn biases(options: &RenderOptions, max_depth: Option<u32>, scene: &Scene) -> Vec<(&'static OptionSpec, String)> {
    let cut = max_depth.filter(|depth| *depth < scene.render.max_depth);
    cut.map(|depth| (&MAX_DEPTH, depth.to_string())).into_iter().chain(options.biases()).collect()
}

/// Prints warnings about the settings that bias the result or are less exact, unless `quiet`. Returns these options as the user gave them.
pub fn tell_biases(options: &RenderOptions, max_depth: Option<u32>, scene: &Scene, quiet: bool) -> Vec<String> {
    let biases = biases(options, max_depth, scene);
    if !quiet {
        biases.iter().for_each(|(spec, value)| tell(&format!("warning: {}", spec.warning(value))));
    }
    biases.iter().map(|(spec, value)| spec.option(value)).collect()
}
