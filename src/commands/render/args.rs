//! The arguments of `gpu-rt render`.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::{
    CHECKPOINT, ImageArgs, OIDN, PathArgs, SceneArgs, ViewArgs, duration, frame_range, relative_error, sample_range,
};
use crate::commands::scene::stem_of;
use crate::job::Crop;
use crate::options::{Class, DENOISE, RenderOptions};

#[derive(Clone, Debug, Default, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub files: FileArgs,
    #[command(flatten)]
    pub goal: GoalArgs,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub view: ViewArgs,
    #[command(flatten)]
    pub denoising: DenoisingArgs,
    #[command(flatten)]
    pub viewers: ViewerArgs,
    #[command(flatten)]
    pub keep: KeepArgs,
    #[command(flatten)]
    pub messages: MessageArgs,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Measure the seconds of each stage on the device; each dispatch then needs a pass of its own.
    #[arg(long, help_heading = Class::Exact.heading())]
    pub profile: bool,
}

/// The files to write.
#[derive(Clone, Debug, Default, Args)]
pub struct FileArgs {
    /// The image to write, .exr or .png [default: the scene's name with .exr].
    ///
    /// A linear .exr, or a .png, which is the picture alone and cannot be resumed. - is a PNG on standard output. By default it is in the
    /// current folder.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also write a tone-mapped picture, - for standard output.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
}

/// What to render, and until when.
#[derive(Clone, Debug, Default, Args)]
pub struct GoalArgs {
    /// Render the frames A to B - 1, each as --frame does: the #### in the names of -o and --png are its number, with as many
    /// digits or more [default of -o: the scene's name with .####.exr]. --resume leaves out what is complete.
    #[arg(long, value_name = "A..B", value_parser = frame_range, conflicts_with_all = ["frame", "watch"])]
    pub frames: Option<Range<u32>>,
    #[command(flatten)]
    pub image: ImageArgs,
    /// Sample indices A to B - 1 of each pixel, to split a render over machines.
    #[arg(long, value_name = "A..B", value_parser = sample_range, conflicts_with_all = ["spp", "time"])]
    pub samples: Option<Range<u32>>,
    /// Render for this time [30s, 5m, …].
    ///
    /// It counts from the start of the program. The render has a multiple of 8 samples per pixel, or any number where 8 of them take longer
    /// than 2 s; at least one, at most --spp if given.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    /// Render until the relative error is below this, such as 0.01 for 1 %.
    ///
    /// With 95 % confidence, by 16, 32, 64 … samples, limited by --spp and --time if given.
    #[arg(long, value_name = "E", value_parser = relative_error, conflicts_with = "samples")]
    pub noise: Option<f64>,
    /// Render only a part of the image: WIDTH x HEIGHT pixels, from column X and row Y on, with the bytes of the whole image.
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub crop: Option<Crop>,
}

#[derive(Clone, Debug, Default, Args)]
pub struct DenoisingArgs {
    #[arg(long, help = DENOISE.about, long_help = DENOISE.help(), help_heading = DENOISE.class.heading())]
    pub denoise: bool,
    #[arg(long, value_name = "FOLDER", requires = "denoise", help = OIDN, help_heading = DENOISE.class.heading())]
    pub oidn: Option<PathBuf>,
}

/// Who sees the image while it renders.
#[derive(Clone, Debug, Default, Args)]
pub struct ViewerArgs {
    /// Draw the image in the terminal, about once a second.
    ///
    /// The image so far, and the image at the end, as --exposure and --tonemap have it.
    #[arg(long)]
    pub preview: bool,
    /// Send the image so far, about once a second, and the image at the end to a viewer: tev, which listens on 127.0.0.1:14158.
    #[arg(long, value_name = "HOST:PORT", value_parser = host_and_port)]
    pub display_server: Option<String>,
}

/// What is kept of renders: of this one while it goes on, and of earlier ones.
#[derive(Clone, Debug, Default, Args)]
pub struct KeepArgs {
    /// Write the image so far at this interval, and the PNG too [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = CHECKPOINT)]
    pub checkpoint: Duration,
    /// Go on with the render in the output; --resume=auto starts if there is none.
    ///
    /// The image is that of one render. --resume alone fails if there is none.
    #[arg(long, value_name = "auto", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = parse_resume)]
    pub resume: Option<Resume>,
    /// Render again whenever the scene or one of its files is saved, until Ctrl-C.
    ///
    /// First a quarter of the size, then a half, then all of it.
    #[arg(long, conflicts_with_all = ["samples", "resume", "json", "denoise"])]
    pub watch: bool,
    /// Render with several devices or drivers, or go on with another one, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    /// Leave out of the EXR what --resume and `merge` need.
    #[arg(long)]
    pub no_state: bool,
    /// Overwrite an image of this render that has more samples.
    #[arg(long)]
    pub force: bool,
}

/// What is said, and what is an error.
#[derive(Clone, Debug, Default, Args)]
pub struct MessageArgs {
    /// Fail if a sample was not finite and therefore rejected.
    #[arg(long)]
    pub strict: bool,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Also say what the stated error excludes.
    #[arg(long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Print one JSON object on stdout at the end.
    #[arg(long)]
    pub json: bool,
}

impl RenderArgs {
    /// The image to write.
    pub fn image(&self) -> PathBuf {
        self.files.output.clone().unwrap_or_else(|| self.default_image())
    }

    /// The scene's name with .exr, in the current folder.
    pub fn default_image(&self) -> PathBuf {
        PathBuf::from(stem_of(&self.scene.path)).with_added_extension("exr")
    }
}

/// What `--resume` does where there is nothing to resume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// It fails.
    Yes,
    /// The render starts afresh.
    Auto,
}

fn parse_resume(text: &str) -> Result<Resume, String> {
    match text {
        "yes" => Ok(Resume::Yes),
        "auto" => Ok(Resume::Auto),
        _ => Err("expected --resume or --resume=auto".to_string()),
    }
}

pub fn host_and_port(text: &str) -> Result<String, String> {
    match text.rsplit_once(':') {
        Some((host, port)) if !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0) => Ok(text.to_owned()),
        _ => Err("expected HOST:PORT, such as 127.0.0.1:14158".to_string()),
    }
}
