//! `--watch`: a render whenever the scene is saved.

use std::time::{Duration, Instant};

use super::args::RenderArgs;
use super::request::{frame_and_job, more_there};
use super::series::{Render, Series};
use crate::commands::changes::{Changes, check_watched};
use crate::commands::console::{tell, tell_error};
use crate::commands::scene::name_of;
use crate::commands::signals::Signals;
use crate::error::{Error, Result};
use crate::identity::Identity;
use crate::job::{Crop, Frame, Size};
use crate::output::destination::can_be_replaced;
use crate::printable::counted;

/// The time that a submission should take, since the one that is under way is waited for.
const SOON: Duration = Duration::from_millis(30);

/// The pictures that come before an image: shares of its width and height, and the samples of each pixel. The first one takes a sixteenth of
/// the time of one sample of the full image, and the second one about all of it.
const PREVIEWS: [(f64, u32); 2] = [(0.25, 1), (0.5, 4)];

/// Renders the scene, and again whenever it is saved, until a signal comes.
pub fn watch(args: &RenderArgs, start: Instant, render: Render) -> Result<()> {
    refuse(args)?;
    let signals = Signals::listen("nothing has been written");
    let mut series = Series { signals: Some(signals.clone()), changes: Some(Changes::new()), ..Series::new(args) };
    series.session = series.session.keeping_hierarchies();
    series.session.submission = Some(SOON);
    let (mut start, mut began) = (start, false);
    loop {
        match pass(&mut series, args, start, render) {
            Err(Error::Dropped) => began = true,
            Err(error) if is_end(&series, args, &error, began) => return Err(error),
            passed => {
                began |= passed.is_ok();
                if let Err(error) = passed {
                    tell_error(&error);
                }
                if !args.messages.quiet {
                    tell("waiting for the next save; Ctrl-C ends");
                }
            }
        }
        let changed = series.changes.as_ref().and_then(|changes| changes.wait(|| signals.are_pending()));
        let Some((files, noted)) = changed else {
            let image = args.image();
            return Err(signals.interrupted(&match began {
                true => format!("{} holds the last picture", image.display()),
                false => "nothing has been written".to_owned(),
            }));
        };
        if !args.messages.quiet {
            let names: Vec<String> = files.into_iter().map(name_of).collect();
            tell(&format!("{} changed", names.join(", ")));
        }
        start = noted;
    }
}

/// Refuses what cannot be watched.
fn refuse(args: &RenderArgs) -> Result<()> {
    check_watched(&args.scene.path)?;
    let image = args.image();
    for (option, path) in [("-o", Some(&image)), ("--png", args.files.png.as_ref())] {
        if let Some(path) = path.filter(|path| !can_be_replaced(path)) {
            let path = path.display();
            return Err(Error::Usage(format!(
                "{option} {path}: --watch replaces it again and again: give the name of a file"
            )));
        }
    }
    Ok(())
}

/// Loads the scene and renders it: previews first, but not over samples of this very image.
fn pass(series: &mut Series, args: &RenderArgs, start: Instant, render: Render) -> Result<()> {
    let (is_first, mut compiled, mut read) = (series.session.devices.is_empty(), series.compiled(), series.assets.read);
    let scene = series.load(args);
    if let Some(changes) = &mut series.changes {
        changes.follow(&series.assets.files);
    }
    let scene = scene?;
    let (frame, job) = frame_and_job(args, &scene, start)?;
    let identity = || Identity::new(&scene, &frame, &job, &args.options);
    let is_held = !args.keep.force && more_there(&args.image(), identity, 0).is_some();
    let most = args.goal.image.spp.unwrap_or(scene.render.samples);
    let mut begun = start;
    for (share, samples) in PREVIEWS.into_iter().filter(|_| !is_held) {
        let (width, height) = Size::Share(share).in_pixels(frame.full);
        render(&of_preview(args, &frame, (width, height), samples.min(most)), &scene, series, begun)?;
        begun = Instant::now();
        let new = series.compiled() - std::mem::replace(&mut compiled, series.compiled());
        if new > 0 && !is_first && !args.messages.quiet {
            let kernels = counted(new as u64, "kernel");
            tell(&format!("{kernels} compiled for the change: {:.2} s", series.compile));
        }
        if args.messages.verbose {
            let (seconds, all) = (start.elapsed().as_secs_f64(), series.assets.count());
            let files = series.assets.read - std::mem::replace(&mut read, series.assets.read);
            tell(&format!(
                "preview of {width} x {height} pixels after {seconds:.2} s: {new} kernels compiled, {files} of {all} images and \
                 meshes read"
            ));
        }
    }
    render(args, &scene, series, begun)
}

/// Whether no save can mend an error. Before anything was rendered, the arguments are to blame, and not the scene.
fn is_end(series: &Series, args: &RenderArgs, error: &Error, began: bool) -> bool {
    match error {
        Error::Interrupted { .. } => true,
        Error::Scene { .. } | Error::Several { .. } => !began && !args.scene.path.is_file(),
        _ => !began || series.session.devices.iter().any(|device| device.check().is_err()),
    }
}

/// The arguments of a preview.
fn of_preview(args: &RenderArgs, frame: &Frame, size: (u32, u32), samples: u32) -> RenderArgs {
    let mut args = args.clone();
    args.goal.image.size = Some(Size::Pixels(size.0, size.1));
    args.goal.crop = frame.crop().map(|crop| scaled(&crop, frame.full, size));
    args.goal.image.spp = Some(samples);
    (args.goal.time, args.goal.noise) = (None, None);
    args.keep.no_state = true;
    (args.messages.strict, args.messages.quiet) = (false, true);
    args
}

/// A part of an image, in an image of another size: all pixels that it touches.
fn scaled(crop: &Crop, (width, height): (u32, u32), (to_width, to_height): (u32, u32)) -> Crop {
    let along = |first: u32, count: u32, all: u32, to: u32| {
        let at = |pixel: u64| pixel * u64::from(to);
        let begin = at(u64::from(first)) / u64::from(all);
        let end = at(u64::from(first) + u64::from(count)).div_ceil(u64::from(all));
        (begin as u32, (end - begin) as u32)
    };
    let (left, part_width) = along(crop.left, crop.width, width, to_width);
    let (top, part_height) = along(crop.top, crop.height, height, to_height);
    Crop { left, top, width: part_width, height: part_height }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part keeps its position in a preview, is never empty, and never leaves the image.
    #[test]
    fn a_part_is_scaled_to_the_pixels_around_it() {
        let scaled = |crop: &str| scaled(&crop.parse().unwrap(), (1200, 675), (300, 169)).to_string();
        assert_eq!(scaled("400,200,320,180"), "100,50,80,46");
        assert_eq!(scaled("1199,674,1,1"), "299,168,1,1");
        assert_eq!(scaled("0,0,1200,675"), "0,0,300,169");
    }
}
