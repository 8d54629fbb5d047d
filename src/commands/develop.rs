//! `gpu-rt develop`: a picture of an EXR.

use std::path::PathBuf;

use clap::Args;

use super::console::{tell, tell_colours};
use super::outputs::{PNG, check_name, check_outputs};
use crate::cli::ViewArgs;
use crate::error::Result;
use crate::output::exr::read_exr;
use crate::output::png::write_png;

#[derive(Debug, Args)]
pub struct DevelopArgs {
    /// The EXR: red, green and blue, or a luminance alone.
    #[arg(value_name = "IN.exr")]
    pub image: PathBuf,
    /// The PNG to write, - for standard output.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    #[command(flatten)]
    pub view: ViewArgs,
}

/// Writes the picture, and says which pixels have no value to show.
pub fn run(args: &DevelopArgs) -> Result<()> {
    check_name(&args.image, "an EXR: it is not read as a stream")?;
    let picture = ("-o", Some(args.output.as_path()), PNG);
    check_outputs(&[picture], std::slice::from_ref(&args.image), None, "nothing has been developed")?;
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
