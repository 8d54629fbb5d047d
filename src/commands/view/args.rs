//! The arguments of `gpu-rt view`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::{ImageArgs, PathArgs, SceneArgs, ViewArgs};
use crate::options::RenderOptions;

#[derive(Clone, Debug, Default, Args)]
pub struct WindowArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The image that S saves, beside a PNG of its name [default: the scene's name with .exr]. A file that exists stays: the name gets a number.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub image: ImageArgs,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Read the scene again whenever it or one of its files is saved. The camera stays where it was moved to.
    #[arg(long)]
    pub watch: bool,
    #[command(flatten)]
    pub options: RenderOptions,
}
