//! `gpu-rt converge`: the error of a render against a reference at 1, 2, 4 … samples, with the seconds of each.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};

use super::console::{path_text, print_json, print_line, tell, tell_measured};
use super::outputs::{check_name, make_folder};
use super::scene::{load, name_of, stem_of, tell_biases};
use super::signals::Signals;
use super::target::{open_device, tell_driver};
use crate::cli::{PathArgs, SceneArgs, duration, samples};
use crate::error::{Error, Result};
use crate::film::{Film, Verdict};
use crate::identity::Identity;
use crate::job::{Frame, Goal, Job};
use crate::metrics::error as metrics;
use crate::options::{RenderOptions, SPP, Word};
use crate::output::atomic;
use crate::output::csv::csv;
use crate::output::exr::{ExrImage, read_exr, read_state};
use crate::output::plot::{Curve, Plot, Width, svg};
use crate::render::{NOISE_LEVEL, stopping};
use crate::session::Session;

#[derive(Debug, Args)]
pub struct ConvergeArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The reference image, from any renderer. The render has its size.
    #[arg(long, value_name = "R.exr")]
    pub reference: PathBuf,
    /// The folder for SCENE-converge.csv and SCENE-converge.svg; created if missing.
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    #[arg(long, value_name = "N", value_parser = samples(), help = SPP.about, long_help = SPP.help(),
          help_heading = SPP.class.heading())]
    pub spp: Option<u32>,
    /// Stop before a doubling of the samples would exceed this time [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub time: Option<Duration>,
    #[command(flatten)]
    pub paths: PathArgs,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Print errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// The render after a number of samples.
#[derive(Clone, Copy, Debug, Serialize)]
struct Measurement {
    samples: u32,
    /// The time of all passes so far, without compiling and measuring.
    seconds: f64,
    mse: f64,
    rmse: f64,
    /// The mean square error relative to the reference, which the unit of light does not change.
    relative_mse: f64,
    relmse: f64,
    /// The mean over pixels and channels of the image minus the reference, relative to the mean of the reference; none
    /// if that is black.
    mean_difference: Option<f64>,
    /// The render's own estimate of its noise; none if there are few samples.
    relative_error: Option<f64>,
    /// Its upper bound, with 95 % confidence. JSON has no infinity: it becomes null.
    relative_error_bound: Option<f64>,
    /// Whether the estimate is reliable, as `render` would say.
    reliable: Option<bool>,
    #[serde(skip)]
    verdict: Verdict,
}

/// Doubles the number of samples on one film again and again, and measures the image each time.
pub fn run(args: &ConvergeArgs) -> Result<()> {
    check_name(&args.reference, "an EXR")?;
    check_name(&args.output, "a folder")?;
    let reference = read_exr(&args.reference)?;
    if !args.quiet {
        tell_measured(&args.reference, &reference);
        if reference.reliable() == Some(false) {
            tell(&format!(
                "warning: the header of {} calls its error unreliable: it may lack light, and then has more error than its noise shows",
                args.reference.display()
            ));
        }
    }
    // By its own noise, if its file holds the variance.
    let variance = reference.known_variance();
    let own_error =
        variance.and_then(|v| metrics::relative_variance(v, &reference.rgb, metrics::floor_of(&reference.rgb)));
    let scene = load(&args.scene)?;
    let biases = tell_biases(&args.options, args.paths.max_depth, &scene, args.quiet);
    if reference.seed() == Some(args.paths.seed) && !args.quiet {
        tell(&format!(
            "warning: {} was also rendered with seed {}. The two images share noise, which hides error; give another --seed",
            args.reference.display(),
            args.paths.seed
        ));
    }
    let state = read_state(&args.reference).ok().flatten();
    make_folder(&args.output, "nothing has been rendered")?;
    let stem = stem_of(&args.scene.path).to_string_lossy();
    let [table, plot] = ["csv", "svg"].map(|ending| args.output.join(format!("{stem}-converge.{ending}")));
    let size = (reference.width, reference.height);
    let device = Arc::new(open_device(args.paths.device.as_deref())?);
    tell_driver(&device, args.quiet);

    let end = args.spp.unwrap_or(scene.render.samples);
    let max_depth = args.paths.max_depth.unwrap_or(scene.render.max_depth);
    let job = Job { size, max_depth, seed: args.paths.seed, first_sample: 0, goal: Goal::Samples(end) };
    if !args.quiet
        && state.is_some_and(|state| {
            !Identity::new(&scene, &Frame::full(size), &job, &args.options).is_of_scene(&state.identity)
        })
    {
        tell(&format!("warning: {} is of another scene, as its header says", args.reference.display()));
    }
    let mut session = Session::on(vec![Arc::clone(&device)]);
    session.view(&scene, &Frame::full(size), &args.options)?;
    session.prepare(&job, &mut ())?;
    let mut film = session.film(size)?;

    let signals = Signals::listen("no table and no plot are written");
    let mut steps: Vec<Measurement> = Vec::new();
    let (mut done, mut seconds) = (0, 0.0);
    while done < end {
        let next = if done == 0 { 1 } else { done.saturating_mul(2).min(end) };
        if let Some(time) = args.time
            && done > 0
            && seconds * f64::from(next) / f64::from(done) > time.as_secs_f64()
        {
            break;
        }
        let job = Job { goal: Goal::Samples(next), ..job };
        session.render(&job, &mut film, &mut stopping(|| signals.are_pending()))?;
        if session.outcome.interrupted {
            break;
        }
        (done, seconds) = (next, seconds + session.outcome.seconds);
        let step = measure(&film.film, &reference, done, seconds)?;
        if !args.quiet && !args.json {
            if steps.is_empty() {
                print_line(&format!(
                    "{:>8} {:>10} {:>10} {:>13} {:>10} {:>12}",
                    "samples", "seconds", "RMSE", "relative MSE", "relMSE", "mean, % off"
                ))?;
            }
            print_line(&line(&step))?;
        }
        steps.push(step);
    }
    if steps.is_empty() {
        return Err(signals.interrupted("there is no sample yet, and nothing has been written"));
    }
    let rows: Vec<Value> = steps.iter().map(|step| json!(step)).collect();
    let mut rows_of_table = rows.clone();
    rows_of_table.iter_mut().for_each(|row| row["reference_reliable"] = json!(reference.reliable()));
    atomic::write(&table, csv(COLUMNS, &rows_of_table).as_bytes())?;
    let name = name_of(&args.scene.path);
    let title = format!("{name} on {}", device.name.driver);
    atomic::write(&plot, svg(&drawing(&title, &steps, own_error))?.as_bytes())?;
    let of_reference = (own_error, reference.reliable());
    report(args, &biases, &device.name.to_string(), (&steps, rows), of_reference, (&table, &plot))?;
    match signals.are_pending() {
        true => Err(signals.interrupted(&format!("{} holds the samples so far", table.display()))),
        false => Ok(()),
    }
}

fn measure(film: &Film, reference: &ExrImage, samples: u32, seconds: f64) -> Result<Measurement> {
    let picture = film.develop();
    let found = |value: Option<f64>| value.filter(|value| value.is_finite());
    let not_numbers = || Error::Usage("expected a reference of finite numbers, found NaN or infinite pixels".into());
    let verdict = film.verdict(NOISE_LEVEL);
    let mse = found(metrics::mse(&picture.rgb, &reference.rgb)).ok_or_else(not_numbers)?;
    Ok(Measurement {
        samples,
        seconds,
        mse,
        rmse: mse.sqrt(),
        relative_mse: found(metrics::relative_mse(&picture.rgb, &reference.rgb)).ok_or_else(not_numbers)?,
        relmse: found(metrics::relmse(&picture.rgb, &reference.rgb)).ok_or_else(not_numbers)?,
        mean_difference: found(metrics::mean_difference(&picture.rgb, &reference.rgb)),
        relative_error: verdict.error.map(|error| error.value),
        relative_error_bound: verdict.error.map(|error| error.bound),
        reliable: verdict.reliable(),
        verdict,
    })
}

/// The exponent p of an error that falls as N^-p, from 8 samples on, by a least-squares fit of logarithms.
fn slope(steps: &[Measurement], own_error: f64) -> Option<f64> {
    let known = steps.iter().filter(|step| step.samples >= 8 && step.relative_mse > own_error);
    let points: Vec<(f64, f64)> =
        known.map(|step| (f64::from(step.samples).ln(), (step.relative_mse - own_error).ln())).collect();
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let along: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let both: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (points.len() >= 3).then(|| -both / along)
}

fn drawing<'a>(title: &'a str, steps: &[Measurement], own_error: Option<f64>) -> Plot<'a> {
    let curve = |name: &str, of: &dyn Fn(&Measurement) -> f64| Curve {
        name: name.into(),
        points: steps.iter().map(|step| (step.seconds, of(step))).collect(),
        marks: Vec::new(),
    };
    let measured = curve("relative MSE against the reference", &|step| step.relative_mse);
    let mut curves = vec![Curve { marks: measured.points.clone(), ..measured }];
    if let Some(own) = own_error {
        curves.push(curve("relative MSE of the reference by its noise", &|_| own));
        curves.push(curve("relative MSE less the reference's own", &|step| step.relative_mse - own));
    }
    let y = "relative MSE; the dotted line falls as 1/N";
    Plot { title, x: "seconds of rendering", y, curves, guide: true, width: Width::Wide }
}

const COLUMNS: &str = "samples,seconds,mse,rmse,relative_mse,relmse,mean_difference,relative_error,relative_error_bound,reliable,\
                       reference_reliable";

fn line(step: &Measurement) -> String {
    format!(
        "{:>8} {:>10.3} {:>10.3e} {:>13.3e} {:>10.3e} {:>12}{}",
        step.samples,
        step.seconds,
        step.rmse,
        step.relative_mse,
        step.relmse,
        step.mean_difference.map_or("-".into(), |off| format!("{:+.3}", 100.0 * off)),
        if step.reliable == Some(false) { " unreliable" } else { "" }
    )
}

/// Warnings that name the steps whose own error is unreliable, with the reasons of the last of them.
fn reliability_warnings(steps: &[Measurement]) -> Vec<String> {
    let unreliable: Vec<&Measurement> = steps.iter().filter(|step| step.reliable == Some(false)).collect();
    let at = unreliable.iter().map(|step| step.samples.to_string()).collect::<Vec<_>>().join(", ");
    let reasons = unreliable.last().map_or_else(Vec::new, |step| step.verdict.reasons_unreliable());
    let warning = |reason| format!("warning: the relative error at {at} samples is unreliable: {reason}");
    reasons.into_iter().map(warning).collect()
}

fn report(
    args: &ConvergeArgs,
    biases: &[String],
    device: &str,
    (steps, rows): (&[Measurement], Vec<Value>),
    (own_error, reference_reliable): (Option<f64>, Option<bool>),
    (table, plot): (&Path, &Path),
) -> Result<()> {
    let slope = slope(steps, own_error.unwrap_or(0.0));
    if args.json {
        print_json(&json!({
            "scene": path_text(&args.scene.path),
            "reference": path_text(&args.reference),
            "device": device,
            "integrator": args.options.integrator.word(),
            "sampler": args.options.sampler.word(),
            "seed": args.paths.seed,
            "biases": biases,
            "steps": rows,
            "relative_mse_of_reference": own_error,
            "reference_reliable": reference_reliable,
            "relative_mse_falls_as": slope.map(|p| -p),
            "csv": path_text(table),
            "plot": path_text(plot),
        }))?;
    }
    if args.quiet {
        return Ok(());
    }
    reliability_warnings(steps).iter().for_each(|warning| tell(warning));
    if let Some(own) = own_error {
        tell(&format!(
            "the reference's own noise is a relative MSE of {own:.2e}; errors near that say little about the render"
        ));
    }
    if let Some(p) = slope {
        tell(&format!("the relative MSE falls as N^-{p:.2} from 8 samples on"));
    }
    tell(&format!("{} and {}", table.display(), plot.display()));
    Ok(())
}
