//! `render --frames`: an image for each frame of a glTF file's animations. The device with its kernels, textures, and meshes that stand still
//! stay from frame to frame.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use super::args::RenderArgs;
use super::request::{denoising_of, frame_and_job};
use super::series::{Render, Reported, Series};
use crate::commands::console::{path_text, print_json, tell};
use crate::commands::denoise::{denoised_image, denoised_picture};
use crate::commands::scene::stem_of;
use crate::error::{Error, Result};
use crate::identity::Identity;
use crate::job::Goal;
use crate::output::exr::{Attribute, read_attributes, read_exr, read_state};
use crate::output::png::write_png;
use crate::printable::counted;
use crate::scene::{Assets, Scene};

/// Renders the frames one after the other, until one fails or a signal comes.
pub fn render_frames(args: &RenderArgs, frames: Range<u32>, start: Instant, render: Render) -> Result<()> {
    let default = PathBuf::from(stem_of(&args.scene.path)).with_added_extension("####.exr");
    let image = numbered("-o", args.files.output.as_deref().unwrap_or(&default))?;
    let png = args.files.png.as_deref().map(|path| numbered("--png", path)).transpose()?;
    let mut series = Series { assets: Assets::of_frames(), frames: Some(Reported::default()), ..Series::new(args) };
    series.session = series.session.keeping_hierarchies();
    // The time of a frame counts from its own begin.
    let begins = std::iter::once(start).chain(std::iter::repeat_with(Instant::now));
    let rendered = frames.zip(begins).try_for_each(|(number, begin)| {
        let mut args = args.clone();
        (args.files.output, args.files.png) = (Some(image(number)), png.as_ref().map(|name| name(number)));
        args.scene.gltf.frame = Some(f64::from(number));
        if let Some(signals) = series.signals.as_ref().filter(|signals| signals.are_pending()) {
            return Err(signals.interrupted(&format!("frame {number} and later ones are not rendered")));
        }
        render_frame(args, number, &mut series, begin, render)
    });
    let reports = series.frames.map(|reported| reported.reports).unwrap_or_default();
    let printed = if args.messages.json { print_json(&json!({"frames": reports})) } else { Ok(()) };
    rendered.and(printed)
}

/// Renders a frame, unless --resume finds it complete. One that is not there yet begins.
fn render_frame(mut args: RenderArgs, number: u32, series: &mut Series, begin: Instant, render: Render) -> Result<()> {
    let scene = series.load(&args)?;
    let image = args.image();
    if args.keep.resume.is_some()
        && let Some(samples) = samples_of_complete(&args, &scene, begin)?
    {
        develop_again(&args, &image)?;
        if !args.messages.quiet {
            tell(&format!("{}: {}, complete", image.display(), counted(samples, "sample")));
        }
        let report = json!({
            "output": path_text(&image), "samples_per_pixel": samples, "frame": f64::from(number), "skipped": true,
        });
        series.frames.iter_mut().for_each(|reported| reported.reports.push(report.clone()));
        return Ok(());
    }
    if !image.exists() {
        args.keep.resume = None;
    }
    render(&args, &scene, series, begin)
}

/// Makes the pictures of a complete frame: they may be older than it, after a kill, or of another exposure.
fn develop_again(args: &RenderArgs, image: &Path) -> Result<()> {
    let develop = |exr: &Path, png: Option<&Path>| {
        let Some(png) = png else { return Ok(()) };
        let exr = read_exr(exr)?;
        write_png(png, (exr.width, exr.height), &|index| exr.rgb[index], &args.view.transform())
    };
    develop(image, args.files.png.as_deref())?;
    if !args.denoising.denoise {
        return Ok(());
    }
    let time = |path: &Path| fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
    let denoised = denoised_image(image);
    match time(&denoised) < time(image) {
        true => {
            let denoising = denoising_of(args, image)?;
            denoising.map_or(Ok(()), |denoising| denoising.of_render(image, args.messages.quiet).map(|_| ()))
        }
        false => develop(&denoised, args.files.png.as_deref().and_then(denoised_picture).as_deref()),
    }
}

/// How many samples the image of a frame has, if it is complete.
fn samples_of_complete(args: &RenderArgs, scene: &Scene, begin: Instant) -> Result<Option<u64>> {
    let image = args.image();
    // What is wrong with it is said where it is resumed.
    let Some(state) = read_state(&image).ok().flatten() else { return Ok(None) };
    let (frame, job) = frame_and_job(args, scene, begin)?;
    let is_complete = match job.goal {
        Goal::Samples(end) => state.samples.missing(job.first_sample..end).is_empty(),
        _ => {
            let found = read_attributes(&image).unwrap_or_default();
            found.iter().any(|(name, value)| name == "gpu-rt:complete" && *value == Attribute::Int(1))
        }
    };
    let is_same = || Identity::new(scene, &frame, &job, &args.options).difference("", &state.identity, "").is_none();
    Ok((is_complete && is_same()).then(|| state.samples.count()))
}

/// The names of a sequence's files, by the numbers of frames: in a name, a run of # stands for the number.
///
/// # Errors
/// `Error::Usage` for a name without such a run.
fn numbered(option: &str, path: &Path) -> Result<impl Fn(u32) -> PathBuf> {
    let wrong = |reason: &str| {
        Err(Error::Usage(format!(
            "{}: {reason} with {option}, such as out.####.exr; nothing has been rendered",
            path.display()
        )))
    };
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some((before, rest)) = name.split_once('#') else {
        return wrong("--frames writes a file for each frame: expected #### for its number");
    };
    let after = rest.trim_start_matches('#');
    if after.contains('#') {
        return wrong("expected one run of # for the number of the frame");
    }
    let digits = 1 + rest.len() - after.len();
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok(move |number| folder.join(format!("{before}{number:0digits$}{after}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_numbers_of_frames() {
        let name = |path: &str, number| numbered("-o", Path::new(path)).map(|name| name(number));
        for (path, number, expected) in [
            ("out.####.exr", 7, "out.0007.exr"),
            ("a/out#.png", 12345, "a/out12345.png"),
            ("a#b/##", 7, "a#b/07"),
            ("####", 0, "0000"),
        ] {
            assert_eq!(name(path, number).unwrap(), Path::new(expected));
        }
        for path in ["out.exr", "-", "a#b/out.exr", "", "#a#.exr"] {
            assert!(matches!(name(path, 0), Err(Error::Usage(_))), "{path}");
        }
    }
}
