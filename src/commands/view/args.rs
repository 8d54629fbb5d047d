//! The arguments of `gpu-rt view`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::{PathArgs, SceneArgs, ViewArgs, samples};
use crate::job::Size;
use crate::options::{RenderOptions, SIZE, SPP};

#[derive(Clone, Debug, Default, Args)]
pub struct WindowArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The image that S saves, beside a PNG of its name [default: the scene's name with .exr]. A file that exists stays: the name gets a number.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[arg(long, value_name = "WxH|W|N%", help = SIZE.about, long_help = SIZE.help(), help_heading = SIZE.class.heading())]
    pub size: Option<Size>,
    #[arg(long, value_name = "N", value_parser = samples(), help = SPP.about, long_help = SPP.help(),
          help_heading = SPP.class.heading())]
    pub spp: Option<u32>,
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
