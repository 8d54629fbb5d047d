//! `gpu-rt develop`: a picture of an EXR.

use std::path::PathBuf;

use clap::Args;

use super::console::{tell, tell_colours};
use super::mix::{Factors, mixed, write};
use super::outputs::{EXR_OR_PNG, PNG, check_name, check_outputs};
use crate::cli::ViewArgs;
use crate::error::Result;
use crate::output::exr::read_exr;
use crate::output::format::{Format, format_of};
use crate::output::png::write_png;
use crate::printable::percent;

#[derive(Debug, Args)]
pub struct DevelopArgs {
    /// The EXR: red, green and blue, or a luminance alone.
    #[arg(value_name = "IN.exr")]
    pub image: PathBuf,
    /// The PNG to write, - for standard output. With --lights, it may be an .exr.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// Mix the groups of lights that `render --aov lights` has written apart: factors of their light, with commas between, such as
    /// key=1.5,background=0.8:0.9:1. Others keep theirs. `rest` is the light without a group.
    #[arg(long, value_name = "NAME=FACTOR,…", value_parser = Factors::parse)]
    pub lights: Option<Factors>,
    #[command(flatten)]
    pub view: ViewArgs,
}

/// Writes the picture, and says which pixels have no value to show.
pub fn run(args: &DevelopArgs) -> Result<()> {
    check_name(&args.image, "an EXR: it is not read as a stream")?;
    let picture = ("-o", Some(args.output.as_path()), if args.lights.is_some() { EXR_OR_PNG } else { PNG });
    check_outputs(&[picture], std::slice::from_ref(&args.image), None, "nothing has been developed")?;
    if let Some(factors) = &args.lights {
        return mix(args, factors);
    }
    let image = read_exr(&args.image)?;
    tell_colours(&args.image, image.colours.as_deref());
    let count = |is: fn(&f32) -> bool| image.rgb.iter().filter(|rgb| rgb.iter().any(is)).count();
    for (count, words) in [
        (count(|v| v.is_nan()), "NaN, and shown as black"),
        (count(|v| *v == f32::INFINITY), "infinite, and shown as white"),
        (count(|v| *v < 0.0), "negative, and shown as black"),
    ] {
        if count > 0 {
            let (name, all) = (args.image.display(), image.rgb.len());
            tell(&format!("warning: {name}: channels of {count} of {all} pixels are {words}"));
        }
    }
    write_png(&args.output, (image.width, image.height), &|index| image.rgb[index], &args.view.transform())
}

/// Writes the picture, or the image, of a mix of lights.
fn mix(args: &DevelopArgs, factors: &Factors) -> Result<()> {
    let mix = mixed(&args.image, factors)?;
    if let Some(error) = mix.error {
        tell(&format!("{}: relative error {}", args.output.display(), percent(error)));
    }
    let picture = &mix.picture;
    match format_of(&args.output, EXR_OR_PNG) {
        Ok(Format::Exr) => write(&args.output, &mix, &args.image, factors),
        _ => {
            let size = (picture.width, picture.height);
            write_png(&args.output, size, &|index| picture.rgb[index], &args.view.transform())
        }
    }
}
