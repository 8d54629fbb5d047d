//! `gpu-rt view`: a scene in a window, to look around in.

#[cfg(feature = "window")]
mod layers;
#[cfg(feature = "window")]
mod link;
#[cfg(feature = "window")]
mod navigation;
#[cfg(feature = "window")]
mod rendering;
#[cfg(feature = "window")]
mod window;

use std::path::PathBuf;

use clap::Args;

#[cfg(feature = "window")]
pub use link::{Findings, Link};
#[cfg(feature = "window")]
pub use {rendering::Rendering, window::Window};

use crate::cli::{PathArgs, SceneArgs, ViewArgs, samples};
use crate::error::Result;
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

/// Opens the window, until it is closed or a signal comes.
///
/// # Errors
/// `Error::Usage` if this program has no window, or there is no display. Else those of `render`.
#[cfg(feature = "window")]
pub fn run(args: &WindowArgs) -> Result<()> {
    window::run(args)
}

#[cfg(not(feature = "window"))]
pub fn run(_: &WindowArgs) -> Result<()> {
    Err(crate::error::Error::Usage(
        "this program is built without a window: `cargo build --release --features window` builds one with it, and releases have it. `gpu-rt \
         render --preview` draws in the terminal"
            .to_owned(),
    ))
}
