//! `gpu-rt render`: from a scene file to an image file.

pub(super) mod args;
mod checkpoints;
mod frames;
mod last_write;
mod observers;
mod record;
mod request;
mod resume;
mod series;
mod summary;
mod viewers;
mod watch;

use std::sync::Arc;
use std::time::Instant;

use super::console::print_json;
use super::scene::tell_biases;
use super::signals::Signals;
use crate::aov::Aov;
use crate::error::{Error, Result};
use crate::scene::{Scene, is_gltf};
use crate::threads::join;
pub use args::RenderArgs;
use last_write::LastWrite;
use observers::Observers;
use record::{Clock, per_sample, record, report};
pub use record::{Finish, attributes_of};
pub use request::excluded;
use request::{Request, denoising_of};
use resume::starting_film;
pub use series::{Reported, Series};
pub use summary::{error_words, matte_warning, noise_words, reliability_warnings};
use summary::{rejected_words, summarise};
use viewers::Viewers;
#[cfg(feature = "window")]
pub use {record::save, request::frame_and_job};

/// Renders the scene once, or whenever it changes, or for each frame of it.
pub fn run(args: &RenderArgs, start: Instant) -> Result<()> {
    Viewers::check(args)?;
    let mut args = args.clone();
    args.options.aov.complete(is_gltf(&args.scene.path));
    if args.keep.watch {
        return watch::watch(&args, start, render);
    }
    if args.denoising.denoise {
        args.options.aov.include(&[Aov::Albedo, Aov::Normal]);
    }
    if let Some(frames) = args.goal.frames.clone() {
        return frames::render_frames(&args, frames, start, render);
    }
    let mut series = Series::new(&args);
    let scene = series.load(&args)?;
    render(&args, &scene, &mut series, start)
}

/// Renders a scene that has been loaded since `start`. The image is written now and then and at the end.
pub fn render(args: &RenderArgs, scene: &Scene, series: &mut Series, start: Instant) -> Result<()> {
    let mut clock = Clock::new(start);
    let quiet = args.messages.quiet;
    let mut request = Request::new(args, scene, start)?;
    // --quiet leaves them to the report and the image's header.
    let hides_warnings = series.hides_warnings(quiet);
    series.tell_warnings(&request.warnings, hides_warnings);
    tell_biases(&args.options, args.paths.max_depth, scene, hides_warnings || series.is_at_later_frame());
    series.begin();
    let denoising = denoising_of(args, &request.image)?;
    clock.seconds.load = clock.lap();

    let build = series.session.view(scene, &request.frame, &args.options)?;
    let view = Arc::clone(&series.session.scene);
    request.take(&view)?;
    let earlier = request.earlier()?;
    series.tell_warnings(&view.warnings, hides_warnings);
    series.tell_devices(hides_warnings);
    clock.seconds.build = build.as_secs_f64();
    clock.seconds.device = (clock.lap() - clock.seconds.build).max(0.0);

    let mut film = starting_film(&request, earlier.as_ref(), &view, &series.session.devices)?;
    let Series { session, signals, changes, compile, quiet: hides_compiling, frames, .. } = series;
    session.profile = args.profile;
    let signals = signals.get_or_insert_with(|| {
        Signals::listen(&match &earlier {
            Some(state) => request.what_is_in(&request.image, &state.samples),
            None => "nothing has been written".to_owned(),
        })
    });
    let mut observers = Observers::new(&request, signals, changes.as_ref(), clock, *hides_compiling);
    // The hashes are needed when something is written.
    let rendering = || session.render(&request.job, &mut film, &mut observers);
    let ((), rendered) = join(|| _ = request.identity(), rendering);
    observers.progress.finish();

    let Observers { clock, viewers, progress, .. } = &mut observers;
    let (outcome, has_rendered) = (&session.outcome, session.is_ready());
    *compile = clock.seconds.compile;
    clock.seconds.render = clock.lap();
    let count = film.samples.count();
    clock.seconds.per_sample = per_sample(outcome.seconds, count.saturating_sub(request.held.unwrap_or(0)));
    let complete = rendered.is_ok() && !outcome.interrupted;
    let mut finish = Finish::new(&film, outcome.noise, complete);
    let facts = session.numerics().map(|numerics| record(&request, numerics, &finish, &clock.seconds));
    if let Err(error) = rendered {
        // A device that has failed may not even tell its numerics.
        let write = LastWrite::new(&request, signals, &film, &facts.unwrap_or_default());
        return Err(write.keep(error, observers.kept().ok().flatten()));
    }
    let facts = facts?;
    let written = LastWrite::new(&request, signals, &film, &facts).write(has_rendered, complete);
    finish.more = written.map_err(|error| match signals.are_pending() {
        true => signals.interrupted(&error.to_string()),
        false => error,
    })?;
    clock.seconds.write = clock.lap();
    let denoised = match (denoising, request.exr()) {
        (Some(denoising), Some(exr)) if complete => Some(denoising.of_render(exr, quiet)?),
        _ => None,
    };

    // The report has the passes alone, from the first to the last.
    (clock.seconds.render, clock.seconds.first_pass) = (outcome.seconds, outcome.first_pass);
    clock.seconds.total = start.elapsed().as_secs_f64();
    viewers.end(&film.film, progress);
    if !quiet {
        summarise(&request, outcome, &finish, clock.seconds.total);
    }
    if args.messages.json {
        let report = report(&request, session, &finish, (facts, &clock.seconds), denoised.as_ref());
        match frames {
            Some(reported) => reported.reports.push(report),
            None => print_json(&report)?,
        }
    }
    let (paths, rejected) = (finish.totals.paths, finish.totals.rejected.total());
    let words = rejected_words(&finish.totals);
    match rejected {
        1.. if rejected >= paths => {
            Err(Error::Strict(format!("the image is black: {words}. `gpu-rt check` may say why")))
        }
        1.. if args.messages.strict => Err(Error::Strict(format!("--strict: {words}"))),
        _ if outcome.interrupted => Err(signals.interrupted(&request.what_is_in(&request.image, &finish.samples))),
        _ => Ok(()),
    }
}
