//! What a render says at its end.

use super::record::{Finish, overrun};
use super::request::Request;
use crate::commands::console::tell;
use crate::data::{MATTE_SLOTS, RUN_LENGTH};
use crate::film::{Totals, Verdict};
use crate::printable::{counted, known_bound, percent};
use crate::render::{Noise, Outcome};

/// The share of `--time` that a render may leave unused without a word.
const LEAST_OF_TIME: f64 = 0.9;

/// The share of paths that max_depth may cut off, and of the image's light that these may have found, without a word.
const LEAST_CUT: f64 = 1e-3;

/// The last line, and before it what the user should know. `total` is the seconds of all of the render.
pub fn summarise(request: &Request<'_>, outcome: &Outcome, finish: &Finish, total: f64) {
    let Request { args, job, .. } = request;
    if finish.totals.rejected.total() > 0 {
        tell(&format!("warning: {}", rejected_words(&finish.totals)));
    }
    let Totals { paths, too_deep: cut, .. } = finish.totals;
    let share = cut as f64 / paths.max(1) as f64;
    if cut > 0 && (args.messages.verbose || share.min(finish.verdict.cut) > LEAST_CUT) {
        let most = known_bound(finish.verdict.cut).map_or(String::new(), |cut| format!(" by up to {}", percent(cut)));
        let (share, depth) = (percent(share), job.max_depth);
        tell(&format!("{share} of the paths were cut off at max_depth {depth}: the image may be too dark{most}"));
    }
    if let Some((time, over)) = args.goal.time.zip(overrun(args.goal.time, total)) {
        let over = if over < 1.0 { format!("{:.1} ms", 1e3 * over) } else { format!("{over:.1} s") };
        tell(&format!("warning: the render took {over} longer than --time {} s", time.as_secs_f64()));
    }
    let ended_by_time = args.goal.time.filter(|_| {
        let all = args.goal.image.spp.is_some_and(|spp| finish.samples.count() >= u64::from(spp));
        !all && !outcome.interrupted && !finish.noise.is_some_and(|noise| noise.reached)
    });
    if let Some(time) = ended_by_time.filter(|time| total < LEAST_OF_TIME * time.as_secs_f64()) {
        tell(&format!(
            "note: the render took {total:.1} s of --time {} s: more samples of each pixel might have taken longer",
            time.as_secs_f64()
        ));
    }
    if ended_by_time.is_some() && request.exr().is_some() && request.ends_within_run(&finish.samples) {
        tell(&format!(
            "note: the samples end within a run of {RUN_LENGTH}: a render that --resume continues may differ from an uninterrupted one in the last bits"
        ));
    }
    if args.profile {
        if outcome.stages.is_empty() {
            tell("stages: this device has no timestamps");
        }
        let stages = outcome.stages.iter();
        stages.for_each(|(name, s)| tell(&format!("stage {name}: {s:.3} s on the device")));
        if let Some(idle) = outcome.idle {
            tell(&format!("the device is idle for {} of the time", percent(idle)));
        }
    }
    matte_warning(finish).into_iter().chain(reliability_warnings(finish)).for_each(|warning| tell(&warning));
    if let (Some(wanted), Some(noise)) = (args.goal.noise, finish.noise) {
        tell(&noise_words(wanted, &noise, &finish.verdict));
    }
    if args.messages.verbose && finish.verdict.error.is_some() {
        tell(&format!("the relative error covers noise; it excludes {}", request.excluded()));
    }
    if request.exr().is_none() {
        tell("a PNG is the picture alone: no EXR is written");
    }
    let samples = finish.samples.count();
    if let Some(more) = finish.more {
        tell(&format!(
            "warning: {} stays as it was: it holds {more} samples per pixel of this render, more than the {samples} here. --force \
             overwrites it",
            request.image.display()
        ));
    }
    let resumed = request.held.map_or(String::new(), |from| format!(" ({from} of them resumed)"));
    let error = error_words(finish);
    let samples = counted(samples, "sample");
    tell(&format!("{}: {samples}{resumed}, {error}, {total:.1} s", request.image.display()));
}

/// The error with its bound.
pub fn error_words(finish: &Finish) -> String {
    let sure = |bound: f64| format!(" (95 % sure: below {})", two_decimals(bound));
    match finish.verdict.error {
        Some(error) => {
            let bound = known_bound(error.bound).map_or(String::new(), sure);
            format!("relative error {}{bound}", two_decimals(error.value))
        }
        None if finish.samples.count() <= u64::from(RUN_LENGTH) => {
            format!("error unknown (it needs {} samples per pixel)", RUN_LENGTH + 1)
        }
        None => "error unknown (no sample has met light)".to_string(),
    }
}

/// The warning that mattes lack samples.
pub fn matte_warning(finish: &Finish) -> Option<String> {
    let lost = finish.matte_pixels_lost.filter(|lost| *lost > 0)?;
    Some(format!(
        "warning: the camera sees more than {MATTE_SLOTS} names in {}: mattes lack samples there, which crypto_lost counts, and may depend on how \
         the work is split. More pixels (--size) or fewer names avoid that",
        counted(lost, "pixel")
    ))
}

/// Warnings that say why the error is unreliable.
pub fn reliability_warnings(finish: &Finish) -> impl Iterator<Item = String> {
    finish
        .verdict
        .reasons_unreliable()
        .into_iter()
        .map(|reason| format!("warning: the relative error is unreliable: {reason}"))
}

/// What came of a render until an error.
pub fn noise_words(wanted: f64, noise: &Noise, verdict: &Verdict) -> String {
    let words = if noise.reached { "was reached" } else { "was not reached" };
    let said = match verdict.error.and_then(|error| known_bound(error.bound)) {
        Some(bound) if !noise.reached && bound < wanted => format!(
            "the noise is at most {}, with 95 % confidence, but light is missing that paths have not found",
            two_decimals(bound)
        ),
        Some(bound) => format!("the relative error is at most {}, with 95 % confidence", two_decimals(bound)),
        None => "too few paths find light to bound the error; give --spp or --time".to_string(),
    };
    format!("--noise {wanted} {words}: {said}")
}

/// A share in percent, with two decimals as in the line of the error.
fn two_decimals(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

pub fn rejected_words(totals: &Totals) -> String {
    let rejected = totals.rejected;
    format!(
        "{} of {} samples were rejected: {} were not a number, {} infinite, {} cut short, {} not delivered \
         whole",
        rejected.total(),
        totals.paths,
        rejected.nan,
        rejected.infinite,
        rejected.cut,
        rejected.refused
    )
}
