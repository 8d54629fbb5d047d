//! `gpu-rt render`: from a scene file to an image file.

mod accumulation;
mod args;
mod changes;
mod compiling;
mod denoising;
mod last_write;
mod observers;
mod record;
mod rendering;
mod request;
mod sequence;
mod session;
mod summary;
mod viewers;
mod watch;

use std::time::Instant;

use serde_json::json;

use super::console::print_json;
use super::scene::tell_biases;
use super::signals::Signals;
use crate::error::{Error, Result};
use crate::render::Outcome;
use crate::scene::Scene;
use crate::threads::join;
use accumulation::Accumulation;
pub use args::RenderArgs;
use observers::Observers;
use record::FileSamples;
pub use record::{Finish, attributes_of};
use rendering::{Clock, Rendering};
pub use request::excluded;
use request::{Request, checked_image};
use session::Session;
pub use summary::{error_words, noise_words, reliability_warnings};
use summary::{rejected_words, summarise};
use viewers::Viewers;

/// Renders the scene once, or whenever it changes.
pub fn run(args: &RenderArgs, start: Instant) -> Result<()> {
    Viewers::check(args)?;
    if args.watch {
        return watch::watch(args, start, render);
    }
    let mut args = args.clone();
    if args.denoise() {
        args.options.aov.include(&denoising::WANTED);
    }
    if let Some(frames) = args.frames.clone() {
        return sequence::render_frames(&args, frames, start, render);
    }
    let mut session = Session { quiet: args.quiet, ..Session::default() };
    let scene = session.load(&args)?;
    render(&args, &scene, &mut session, start)
}

/// Renders a scene that has been loaded since `start`. The image is written now and then and at the end.
fn render(args: &RenderArgs, scene: &Scene, session: &mut Session, start: Instant) -> Result<()> {
    let mut clock = Clock::new(start);
    // As `check` has them; --quiet leaves them to the report and the image's header.
    let warnings = scene.warnings();
    session.tell_warnings(&warnings, args.quiet);
    let are_reported = session.begins_later_frame();
    tell_biases(&args.options, args.paths.max_depth.0, scene, args.quiet || are_reported);
    let image = checked_image(args, scene)?;
    let denoising = denoising::open(args, &image.0)?;
    clock.seconds.load = clock.lap();

    let (opened, flat) = session.flatten(args, scene, &mut clock);
    let mut request = Request::new(args, scene, flat?, image, start)?;
    let earlier = request.earlier()?;
    session.tell_warnings(&request.flat.warnings, args.quiet);
    // Every checkpoint has all of them in its header.
    request.flat.warnings.splice(0..0, warnings);
    session.add_devices(opened?, args.quiet);
    clock.seconds.device = clock.lap();

    let Session { devices, signals, changes, compile, quiet, sequence, .. } = session;
    let film = Accumulation::begin(&request, earlier.as_ref(), devices)?;
    let held = FileSamples { before: earlier.as_ref().map(|state| state.samples.count()), at_end: None };
    let signals = signals.get_or_insert_with(|| {
        Signals::listen(&match &earlier {
            Some(state) => request.what_is_in(&request.image, &state.samples),
            None => "nothing has been written".to_owned(),
        })
    });
    let observers = Observers::new(&request, signals, changes.as_ref(), held.before.unwrap_or(0));
    let outcome = Outcome::default();
    let mut rendering = Rendering { request: &request, devices, film, held, observers, outcome, clock, loaded: None };
    // The hashes are needed when something is written.
    let ((), rendered) = join(|| _ = request.identity(), || rendering.run(*quiet));
    rendering.observers.progress.finish();
    *compile = rendering.clock.seconds.compile;

    let finish = rendering.finish(rendered.is_ok());
    let record = rendering.record(&finish);
    if let Err(error) = rendered {
        // A device that has failed may not even tell its numerics.
        return Err(rendering.keep(error, &record.unwrap_or_default()));
    }
    let mut record = record?;
    let is_interrupted = rendering.outcome.interrupted;
    if let Err(error) = rendering.write(&finish, &record) {
        return Err(if signals.are_pending() { signals.interrupted(&error.to_string()) } else { error });
    }
    rendering.clock.seconds.write = rendering.clock.lap();
    let denoised = match (denoising, request.exr()) {
        (Some(denoising), Some(exr)) if finish.complete => Some(denoising::write(&denoising, exr, args.quiet)?),
        _ => None,
    };

    let Rendering { film, held, observers, outcome, clock, .. } = &mut rendering;
    // The report has the passes alone, from the first to the last.
    (clock.seconds.render, clock.seconds.pace.first_pass) = (outcome.seconds, outcome.first_pass);
    clock.seconds.total = start.elapsed().as_secs_f64();
    observers.viewers.end(&film.film, &observers.progress);
    if !args.quiet {
        summarise(&request, outcome, &finish, held, clock.seconds.total);
    }
    if args.json {
        record.insert("seconds".to_string(), json!(clock.seconds));
        let report = rendering.report(record, denoised.as_ref());
        match sequence {
            Some(sequence) => sequence.reports.push(report),
            None => print_json(&report)?,
        }
    }
    let (paths, rejected) = (finish.totals.paths, finish.totals.rejected.total());
    let words = rejected_words(&finish.totals);
    match rejected {
        1.. if rejected >= paths => {
            Err(Error::Strict(format!("the image is black: {words}. `gpu-rt check` may say why")))
        }
        1.. if args.strict => Err(Error::Strict(format!("--strict: {words}"))),
        _ if is_interrupted => Err(signals.interrupted(&request.what_is_in(&request.image, &finish.samples))),
        _ => Ok(()),
    }
}
