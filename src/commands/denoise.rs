//! `gpu-rt denoise`: an EXR without its noise.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};

use super::console::{command_of_image, object, path_text, print_json, tell, tell_colours};
use super::outputs::{EXR, PNG, check_name, check_outputs};
use crate::cli::{OIDN, ViewArgs};
use crate::data::Rgb;
use crate::denoise::{Denoiser, Noisy};
use crate::error::{Error, Result};
use crate::output::destination::can_be_replaced;
use crate::output::exr::{read_noisy, write_denoised};
use crate::output::png::write_png;
use crate::output::view_transform::ViewTransform;

#[derive(Debug, Args)]
pub struct DenoiseArgs {
    /// The EXR: red, green and blue, and to keep more detail albedo and normal, as `render --aov albedo,normal` writes them.
    #[arg(value_name = "IN.exr")]
    pub image: PathBuf,
    /// The denoised EXR to write. It has no estimate of its error, and cannot be resumed or joined.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Also write a tone-mapped picture of it, - for standard output.
    #[arg(long, value_name = "FILE.png")]
    pub png: Option<PathBuf>,
    #[arg(long, value_name = "FOLDER", help = OIDN)]
    pub oidn: Option<PathBuf>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// What denoises, and where the result goes.
pub struct Denoising {
    pub denoiser: Denoiser,
    pub exr: PathBuf,
    /// Its PNG.
    pub png: Option<PathBuf>,
    pub view: ViewTransform,
}

/// What has come of it, for JSON.
#[derive(Debug, Serialize)]
pub struct Denoised {
    pub output: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    png: Option<String>,
    /// The name and version of the library.
    denoiser: String,
    /// The layers that it used as well as the image.
    layers: Vec<&'static str>,
    biases: [&'static str; 1],
    /// Of denoising, without reading and writing.
    seconds: f64,
}

/// Denoises, and says what that changes.
pub fn run(args: &DenoiseArgs) -> Result<()> {
    check_name(&args.image, "an EXR: it is not read as a stream")?;
    let images = [("-o", Some(args.output.as_path()), EXR), ("--png", args.png.as_deref(), PNG)];
    let inputs = std::slice::from_ref(&args.image);
    let stdout = args.json.then_some("the report of --json");
    check_outputs(&images, inputs, stdout, "nothing has been denoised")?;
    let denoiser = Denoiser::open(args.oidn.as_deref())?;
    let view = args.view.transform();
    let denoising = Denoising { denoiser, exr: args.output.clone(), png: args.png.clone(), view };
    let (denoised, size) = denoise(&denoising, &args.image, args.quiet)?;
    if args.json {
        let mut report = object(json!({ "input": path_text(&args.image), "width": size.0, "height": size.1 }));
        report.extend(object(json!(denoised)));
        print_json(&Value::Object(report))?;
    }
    Ok(())
}

impl Denoising {
    /// Denoises the image of a render, which its file holds.
    pub fn of_render(&self, exr: &Path, quiet: bool) -> Result<Denoised> {
        let again = command_of_image("denoise", exr, "NAME.exr");
        let held = format!("{} holds the image with its noise. `{again}` denoises it", exr.display());
        denoise(self, exr, quiet).map(|(denoised, _)| denoised).map_err(|error| error.and(&held))
    }
}

/// Writes the denoised image of a file, which stays as it is. The result has the size of the image too.
///
/// # Errors
/// `Error::Usage` where the image is denoised already.
fn denoise(denoising: &Denoising, image: &Path, quiet: bool) -> Result<(Denoised, (u32, u32))> {
    let Denoising { denoiser, exr, png, view } = denoising;
    let noisy = read_noisy(image)?;
    let name = image.display();
    if let Some(before) = noisy.denoiser() {
        return Err(Error::Usage(format!("{name}: it is denoised already, by {before}: give the image of the render")));
    }
    if !quiet {
        tell_colours(image, noisy.colours.as_deref());
        warnings(&noisy.image).into_iter().for_each(|words| tell(&format!("warning: {name}: {words}")));
    }
    let begin = Instant::now();
    let guides = denoiser.guides(&noisy.image)?;
    let lights =
        noisy.lights.iter().map(|(_, light)| denoiser.denoise_by(light, &guides)).collect::<Result<Vec<_>>>()?;
    // Light that is apart adds up to the image: a mix of denoised lights is a denoised mix.
    let rgb = if lights.is_empty() { denoiser.denoise_by(&noisy.image.rgb, &guides)? } else { sum(&lights) };
    let seconds = begin.elapsed().as_secs_f64();
    let (size, layers) = (noisy.image.size, layers(&noisy.image));
    let words = match layers.as_slice() {
        [] => denoiser.name(),
        layers => format!("{}, with {}", denoiser.name(), layers.join(" and ")),
    };
    write_denoised(exr, &noisy, &rgb, &lights, &words)?;
    if let Some(png) = png {
        write_png(png, size, &|index| rgb[index], view)?;
    }
    if !quiet {
        tell("warning: denoising biases the result: the error of the denoised image is not known");
        tell(&format!("{}: denoised by {words}, {seconds:.1} s", exr.display()));
    }
    let denoised = Denoised {
        output: path_text(exr),
        png: png.as_deref().map(path_text),
        denoiser: denoiser.name(),
        layers,
        biases: ["denoise"],
        seconds,
    };
    Ok((denoised, size))
}

/// The image that lights add up to.
fn sum(lights: &[Vec<Rgb<f32>>]) -> Vec<Rgb<f32>> {
    let pixel = |index: usize| {
        let of = |c: usize| lights.iter().map(|light| f64::from(light[index][c])).sum::<f64>();
        [0, 1, 2].map(|c| (of(c) as f32).min(f32::MAX))
    };
    (0..lights.first().map_or(0, Vec::len)).map(pixel).collect()
}

/// The name of the denoised image: NAME.denoised.exr of NAME.exr.
pub fn denoised_image(image: &Path) -> PathBuf {
    let ending = image.extension().map(|ending| ending.to_string_lossy().into_owned()).unwrap_or_default();
    image.with_extension(format!("denoised.{ending}"))
}

/// The name of the denoised picture. A pipe gets one picture, that of the render.
pub fn denoised_picture(png: &Path) -> Option<PathBuf> {
    can_be_replaced(png).then(|| denoised_image(png))
}

/// The layers that the denoiser uses. It takes a normal only with an albedo.
fn layers(noisy: &Noisy) -> Vec<&'static str> {
    let all = [("albedo", &noisy.albedo), ("normal", &noisy.normal)];
    all.into_iter().map_while(|(name, layer)| layer.as_ref().map(|_| name)).collect()
}

/// What makes the result worse than it could be.
fn warnings(noisy: &Noisy) -> Vec<String> {
    let mut found = Vec::new();
    if layers(noisy).len() < 2 {
        let missing = match (&noisy.albedo, &noisy.normal) {
            (None, None) => "albedo and no normal",
            (None, Some(_)) => "albedo, without which the normal is no help",
            _ => "normal",
        };
        found.push(format!(
            "it has no {missing}: the image loses more detail. `gpu-rt render --aov albedo,normal` adds both"
        ));
    }
    let count = |is: fn(&f32) -> bool| noisy.rgb.iter().filter(|rgb| rgb.iter().any(is)).count();
    for (count, words) in
        [(count(|v| !v.is_finite()), "NaN or infinite"), (count(|v| v.is_finite() && *v < 0.0), "negative")]
    {
        if count > 0 {
            found.push(format!("channels of {count} of {} pixels are {words}, and count as 0", noisy.rgb.len()));
        }
    }
    found
}
