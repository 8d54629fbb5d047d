//! The arguments that several commands have, and the parsers of their values.

use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::job::{MOST_SAMPLES, Size};
use crate::options::{MAX_DEPTH, SIZE, SPP};
use crate::output::view_transform::{Tonemap, ViewTransform};
use crate::scene::Thin;

/// The interval of checkpoints where none is given.
pub const CHECKPOINT: &str = "60s";

/// The help of `--oidn`.
pub const OIDN: &str = "The folder of the library of Open Image Denoise [default: the environment's OIDN_DIR, or where the system finds it].";

/// The scene, from a file or standard input.
#[derive(Clone, Debug, Default, Args)]
pub struct SceneArgs {
    /// The scene: a .ron, .glb, .gltf, .obj, .ply or .stl file, a .xml of Mitsuba, or a .pbrt.
    ///
    /// - is a .ron on standard input.
    #[arg(id = "scene", value_name = "SCENE")]
    pub path: PathBuf,
    #[command(flatten)]
    pub gltf: GltfArgs,
}

/// The size of the image and its samples, in place of those of the scene file.
#[derive(Clone, Debug, Default, Args)]
pub struct ImageArgs {
    #[arg(long, value_name = "N", value_parser = samples(), help = SPP.about, long_help = SPP.help(),
          help_heading = SPP.class.heading())]
    pub spp: Option<u32>,
    #[arg(long, value_name = "WxH|W|N%", help = SIZE.about, long_help = SIZE.help(), help_heading = SIZE.class.heading())]
    pub size: Option<Size>,
}

/// What a glTF file leaves open.
#[derive(Clone, Debug, Default, Args)]
pub struct GltfArgs {
    /// For a .glb or .gltf: the camera, by its name or that of its node [default: the first one].
    #[arg(long, value_name = "NAME", help_heading = GLTF)]
    pub camera: Option<String>,
    /// For a .glb, .gltf or mesh: the sky, an image as `background: Image` takes it; `default`, a gradient from white to blue; or `none`
    /// [default: that gradient, unless lamps or emitters light the file].
    #[arg(long, value_name = "default|none|FILE", help_heading = GLTF)]
    pub sky: Option<PathBuf>,
    /// For a .glb, .gltf or mesh: add a sun at this elevation and azimuth (from -z to +x), in degrees.
    #[arg(long, value_name = "ELEVATION,AZIMUTH", num_args = 0..=1, require_equals = true, default_missing_value = "45,60",
          value_parser = sun, allow_hyphen_values = true, help_heading = GLTF)]
    pub sun: Option<(f64, f64)>,
    /// For a .glb or .gltf: whether its lights are in Blender's watts, which are divided by 683 lm/W [default: on for files by Blender].
    #[arg(long, value_name = "on|off", num_args = 0..=1, require_equals = true, default_missing_value = "on",
          value_parser = on_or_off, help_heading = GLTF)]
    pub watts: Option<bool>,
    /// For a .glb or .gltf: which glass is a thin pane. `auto`: in files by Blender, glass whose mesh is open, as Blender renders it; in others,
    /// as `pane`. `pane`: glass to which the file gives no thickness, as glTF says.
    #[arg(long, value_name = "WORD", value_enum, default_value_t, help_heading = GLTF)]
    pub thin: Thin,
    /// The frame, at N / --fps seconds: of the animations of a .glb or .gltf [default: its rest pose], or of a scene's motions, to which its
    /// shutter moves [default: 0].
    #[arg(long, value_name = "N", value_parser = frame_number, allow_negative_numbers = true, help_heading = GLTF)]
    pub frame: Option<f64>,
    /// Frames per second, for --frame, --frames and --aov motion [default: 24].
    #[arg(long, value_name = "N", value_parser = frames_per_second, help_heading = GLTF)]
    pub fps: Option<f64>,
    /// For a .xml of Mitsuba: the value of $NAME in it, in place of its `default`.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define, help_heading = MITSUBA)]
    pub define: Vec<(String, String)>,
    /// For a .xml of Mitsuba or a .pbrt: what cannot be as the file says is an error, not a warning.
    #[arg(long, help_heading = MITSUBA)]
    pub lossless: bool,
}

fn define(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(name, _)| !name.is_empty());
    pair.map(|(name, value)| (name.to_owned(), value.to_owned())).ok_or_else(|| "expected NAME=VALUE".to_owned())
}

/// A number in a range; `expected` says what that is.
fn number(text: &str, range: RangeInclusive<f64>, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|number| range.contains(number)).ok_or_else(|| format!("expected {expected}"))
}

fn frame_number(text: &str) -> Result<f64, String> {
    number(text, -1e9..=1e9, "the number of a frame, such as 12")
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    number(text, 1e-3..=1e6, "a positive number of frames, such as 24")
}

fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("expected on or off".to_owned()),
    }
}

/// The direction of a sun: two angles in degrees.
fn sun(text: &str) -> Result<(f64, f64), String> {
    let angles =
        text.split_once(',').and_then(|(a, b)| Some((a.trim().parse::<f64>().ok()?, b.trim().parse::<f64>().ok()?)));
    let fits = |(elevation, azimuth): &(f64, f64)| elevation.abs() <= 90.0 && azimuth.abs() <= 360.0;
    angles.filter(fits).ok_or_else(|| "expected an elevation of at most 90 and an azimuth, such as 45,60".to_owned())
}

/// The heading of the options of files of Mitsuba in helps.
pub const MITSUBA: &str = "Scenes that are Mitsuba's";

/// The heading of the options of glTF files in helps.
pub const GLTF: &str = "Scenes that are glTF";

/// Which paths are traced, and where.
#[derive(Clone, Debug, Default, Args)]
pub struct PathArgs {
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000),
          help = MAX_DEPTH.about, long_help = MAX_DEPTH.help(), help_heading = MAX_DEPTH.class.heading())]
    pub max_depth: Option<u32>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// The device, by its index or a part of its name: `gpu-rt devices` lists them.
    ///
    /// `render` also takes a list A,B,…, or `all` for all GPUs.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
}

/// How a PNG shows radiance.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct ViewArgs {
    /// Exposure of the PNG, in stops.
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub exposure: f64,
    /// Curve of the PNG: `srgb` clips what is brighter than white; `soft` is the same with a shoulder, on which lamps keep their
    /// hue; `neutral` is Khronos PBR Neutral; `filmic` is a film curve with darker shadows (ACES).
    #[arg(long, value_name = "CURVE", value_enum, default_value_t)]
    pub tonemap: Tonemap,
}

impl ViewArgs {
    pub fn transform(&self) -> ViewTransform {
        ViewTransform { exposure: self.exposure, tonemap: self.tonemap }
    }
}

/// Parses the number of samples of `--spp`.
pub fn samples() -> impl clap::builder::TypedValueParser<Value = u32> {
    clap::value_parser!(u32).range(1..=MOST_SAMPLES)
}

/// A range of whole numbers, A..B with A < B.
fn range(text: &str) -> Option<Range<u32>> {
    let (from, to) = text.split_once("..")?;
    Some(from.trim().parse().ok()?..to.trim().parse().ok()?).filter(|range| !range.is_empty())
}

/// Parses a range of samples such as 0..64.
pub fn sample_range(text: &str) -> Result<Range<u32>, String> {
    let known = range(text).filter(|range| i64::from(range.end) <= MOST_SAMPLES);
    known.ok_or_else(|| format!("expected A..B with A < B <= {MOST_SAMPLES}, such as 0..64"))
}

/// Parses a range of frames such as 1..49.
pub fn frame_range(text: &str) -> Result<Range<u32>, String> {
    range(text).ok_or_else(|| "expected A..B with A < B, such as 1..49 for the frames 1 to 48".to_owned())
}

/// Parses a time such as 30s.
pub fn duration(text: &str) -> Result<Duration, String> {
    // A bare number is seconds.
    let duration = match text.parse::<f64>() {
        Ok(seconds) => Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string()),
        Err(_) => humantime::parse_duration(text).map_err(|error| error.to_string()),
    };
    match duration {
        Ok(duration) if duration.is_zero() => Err("expected a time above zero, such as 30s".to_string()),
        Ok(duration) if duration.as_secs() > 10 * 365 * 86_400 => Err("expected a time below ten years".to_string()),
        Ok(duration) => Ok(duration),
        Err(error) => Err(format!("expected a time such as 30s or 5m: {error}")),
    }
}

/// Parses the error of `--noise`.
pub fn relative_error(text: &str) -> Result<f64, String> {
    number(text, 1e-6..=1.0, "a relative error from 0.000001 to 1, such as 0.01 for 1 %")
}

fn exposure(text: &str) -> Result<f64, String> {
    number(text, -100.0..=100.0, "a number of stops from -100 to 100")
}
