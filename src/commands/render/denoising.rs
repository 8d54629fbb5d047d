//! `--denoise`: writes the denoised image as well.

use std::path::{Path, PathBuf};

use super::args::RenderArgs;
use crate::aov::Aov;
use crate::commands::console::command_of_image;
use crate::commands::denoise::{Denoised, Denoising, denoise};
use crate::denoise::Denoiser;
use crate::error::{Error, Result};
use crate::output::destination::can_be_replaced;

/// The channels that a denoiser uses.
pub const WANTED: [Aov; 2] = [Aov::Albedo, Aov::Normal];

/// Loads the library before anything costs time; `None` without `--denoise`.
pub fn open(args: &RenderArgs, image: &Path) -> Result<Option<Denoising>> {
    if !args.denoise() {
        return Ok(None);
    }
    let undone = |error: Error| Error::Denoiser(format!("{error}. Nothing has been rendered"));
    let denoiser = Denoiser::open(args.oidn.as_deref()).map_err(undone)?;
    let (exr, png) = (denoised_image(image), args.png.as_deref().and_then(denoised_picture));
    Ok(Some(Denoising { denoiser, exr, png, view: args.view.transform() }))
}

/// Denoises the image of the render, which its file holds.
pub fn write(denoising: &Denoising, exr: &Path, quiet: bool) -> Result<Denoised> {
    let again = command_of_image("denoise", exr, "NAME.exr");
    let held = format!("{} holds the image with its noise. `{again}` denoises it", exr.display());
    denoise(denoising, exr, quiet).map(|(denoised, _)| denoised).map_err(|error| error.and(&held))
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
