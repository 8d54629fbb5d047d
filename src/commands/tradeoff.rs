//! `gpu-rt tradeoff`: measures how the settings of `render` trade time, noise and bias on a scene, within a budget of time.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, Parser};
use glam::DVec2;

use super::console::{path_text, print_json, print_line, tell, tell_measured};
use super::outputs::{check_name, make_folder};
use super::render::RenderArgs;
use super::scene::{load, name_of, stem_of};
use super::signals::Signals;
use super::target::{open_device, tell_driver};
use crate::aov::Aov;
use crate::cli::{OIDN, SceneArgs, duration};
use crate::denoise::Denoiser;
use crate::error::{Error, Result};
use crate::job::Size;
use crate::metrics::error::relmse;
use crate::metrics::flip::{self, error_map};
use crate::options::{Class, DENOISE, MAX_DEPTH, OptionSpec, SIZE, SPP, TRADE_OFFS};
use crate::output::atomic;
use crate::output::exr::{ExrImage, read_exr};
use crate::output::plot::Width;
use crate::output::png;
use crate::output::progress::Loading;
use crate::scene::Scene;
use crate::tradeoff::extent::{FEWEST_PIXELS, FullSize, calibrate, middle_of, pixels_for, pixels_ratio, size_of};
use crate::tradeoff::judge::{Judged, Measured, judge};
use crate::tradeoff::pace::swing;
use crate::tradeoff::page::{html, plot};
use crate::tradeoff::replicates::{FEWEST_ROUNDS, Pixels, signed_bias};
use crate::tradeoff::report::{Example, Findings};
use crate::tradeoff::sweep::{LEVEL, MOST_ROUNDS, SAMPLES_OF_FEWEST, Setting, Stop, Subject, Sweep};
use crate::tradeoff::truth::Truth;

#[derive(Debug, Args)]
pub struct TradeoffArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The time limit, compiling included.
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "120s")]
    pub budget: Duration,
    /// The reference image, from any renderer [default: the mean image of the unbiased settings].
    #[arg(long, value_name = "R.exr")]
    pub reference: Option<PathBuf>,
    /// The settings to sweep, by their options' names [default: all].
    #[arg(long, value_name = "A,B,…", value_delimiter = ',')]
    pub knobs: Vec<String>,
    #[arg(long, value_name = "FOLDER", help = OIDN)]
    pub oidn: Option<PathBuf>,
    /// The folder for index.html, plot.svg, tradeoff.csv and tradeoff.json; created if missing [default: SCENE-tradeoff].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// The device, by its index or a part of its name as `gpu-rt devices` lists them.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
    /// Print results and errors only.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// The shares of the budget after which compiling and measuring end, and after which the calibration at full size
/// ends. The rest is for pictures and the report.
const MEASURING: f64 = 0.8;
const CALIBRATING: f64 = 0.9;
/// The largest share of the measuring time that the choice of the image size leaves to compiling.
const COMPILING: f64 = 0.5;
/// One more setting is compiled only if there is time left for so many times the fewest rounds. The number is small, because one more setting
/// tells more than one more round of the others. The margin allows for a machine that becomes slower.
const ROUNDS_LEFT: f64 = 1.3;
const MARGIN: f64 = 1.3;

/// The reasons why a setting is not measured.
const UNREACHED: &str = "the budget was too short";
const INTERRUPTED: &str = "interrupted before it was measured";

/// Measures and reports.
pub fn run(args: &TradeoffArgs, start: Instant) -> Result<()> {
    // From here on a signal ends the measurement, not the program.
    let signals = Signals::listen("no report is written");
    let stop = || signals.are_pending();
    args.reference.iter().try_for_each(|path| check_name(path, "an EXR"))?;
    args.output.iter().try_for_each(|path| check_name(path, "a folder"))?;
    let mut scene = load(&args.scene)?;
    let specs = swept_options(args)?;
    let reference = args.reference.as_deref().map(reference_of).transpose()?;
    if let Some((path, image)) = args.reference.as_deref().zip(reference.as_ref()).filter(|_| !args.quiet) {
        tell_measured(path, image);
    }
    let given = reference.as_ref().map(|image| (image.width, image.height));
    let reference = reference.map(|image| middle(image, &mut scene));
    let full = match &reference {
        Some(image) => (image.width, image.height),
        None => (scene.image.width, scene.image.height),
    };
    let seed = distinct_seed(args.seed, reference.as_ref());
    let folder = folder_of(args)?;
    let device = Arc::new(open_device(args.device.as_deref())?);
    tell_driver(&device, args.quiet);
    let at = |share: f64| start + Duration::from_secs_f64(share * args.budget.as_secs_f64());

    let mut loading = Loading::new(args.quiet);
    let share = || (start.elapsed().as_secs_f64() / args.budget.as_secs_f64()).min(1.0);
    let mut progress = |words: &str| loading.show(words, share());
    // A pace probe renders the defaults at a small size to learn the cost of a sample. Then everything is rendered at the size that the
    // budget allows.
    let exact = reference.is_some();
    let settings = settings_of(&scene, &specs)?;
    let mut probe = Sweep::new(&device, &scene, size_of(full, FEWEST_PIXELS, exact), seed);
    progress("compiling defaults");
    probe.add(settings[0].clone())?;
    let cost = cost_of_sample(&mut probe, at(MEASURING), &stop, &mut |_, _| progress("measuring the pace"))?;
    let left = at(MEASURING).saturating_duration_since(Instant::now());
    let cost = cost.filter(|cost| cost * SAMPLES_OF_FEWEST <= left.as_secs_f64());
    if cost.is_none() && !stop() {
        return Err(too_short(args));
    }
    let of_pixel = cost.unwrap_or(0.0) / pixels_ratio(probe.size, (1, 1));
    let compiling = Duration::from_secs_f64(probe.subjects[0].seconds_compile).saturating_mul(settings.len() as u32);
    let for_rounds = left.saturating_sub(compiling.min(left.mul_f64(COMPILING)));
    let size = size_of(full, pixels_for(of_pixel, settings.len(), for_rounds), exact);
    let denoiser = denoiser_of(args, &specs)?;
    let mut sweep = match stop() || size == probe.size {
        true => {
            // The probe's round is repeated together with the other settings.
            probe.begin_again(seed);
            probe
        }
        false => Sweep::new(&device, &scene, size, seed),
    };
    sweep.denoiser = denoiser.as_ref();
    let size = sweep.size;
    compile(&mut sweep, settings, of_pixel * pixels_ratio(size, (1, 1)), at(MEASURING), &stop, &mut progress)?;
    let mut enough = false;
    sweep.measure(at(MEASURING), MOST_ROUNDS, &stop, &mut |round, name| {
        if round >= FEWEST_ROUNDS && !enough {
            enough = true;
            loading.message(&format!(
                "{round} rounds are measured, which suffice for a report; more make it more accurate. Ctrl-C ends the measurement and \
                 writes the report"
            ));
        }
        loading.show(&format!("round {}: {name}", round + 1), share());
    })?;
    let calibrated = match size == full {
        true => None,
        false => calibrate(&mut sweep, full, at(CALIBRATING), &stop)?,
    };
    drop(loading);

    let reference = reference.map(|file| Truth::of_file(&file, size));
    let unreached = if stop() { INTERRUPTED } else { UNREACHED };
    let calibration = calibrated.as_ref().map(|found| (found.slower, found.noisier));
    let mut at_full_size = calibrated.unwrap_or_else(|| FullSize::assumed(&sweep, full));
    at_full_size.seconds_to_denoise = sweep.seconds_to_denoise(full, at(CALIBRATING))?.unwrap_or(0.0);
    let judged = judge(&mut sweep, reference.as_ref(), &at_full_size, unreached);
    if judged.measured.is_empty() && !stop() {
        return Err(too_short(args));
    }
    let examples = pictures(&mut sweep, &judged, reference.as_ref(), at(1.0), &stop)?;
    let truth = reference.clone().or_else(|| Truth::pooled(&sweep, None));
    let against_defaults = |truth: &Truth| match judged.against_reference {
        Some((distance, _)) => Some(distance.signed),
        // The noise of the reference is unknown.
        None => {
            let images = sweep.subjects.first()?.images(LEVEL);
            signed_bias(&images, &vec![truth.image.clone(); images.len()], &truth.image)
        }
    };
    let report = Findings {
        scene: name_of(&args.scene.path),
        device: device.name.name.clone(),
        driver: device.name.driver.clone(),
        size,
        full_size: full,
        calibration,
        seed,
        budget: args.budget.as_secs_f64(),
        seconds: start.elapsed().as_secs_f64(),
        reference: args.reference.as_deref().map(path_text),
        reference_reliable: reference.as_ref().and_then(|reference| reference.reliable),
        swing: swing(&sweep.clock),
        error_of_truth: truth.as_ref().zip(judged.weights.as_ref()).and_then(|(truth, weights)| truth.error(weights)),
        against_reference: reference.as_ref().and_then(against_defaults),
        distance: judged.against_reference,
        interrupted: stop(),
        measured: judged.measured,
        unmeasured: sweep.unmeasured.clone(),
        middle_of: given.filter(|size| *size != full),
        examples,
    };
    write(&folder, &report)?;
    print(&report, args)?;
    if !args.quiet {
        tell(&format!("{}: {:.0} s", folder.join("index.html").display(), start.elapsed().as_secs_f64()));
    }
    match report.interrupted {
        true if report.measured.is_empty() => Err(signals.interrupted("nothing was measured before")),
        true => Err(signals.interrupted(&format!("{} holds what was measured", folder.display()))),
        false => Ok(()),
    }
}

/// The seconds of one sample of every pixel. All of the time of a round counts, with the work between the passes. None if no round ended in time.
fn cost_of_sample(
    probe: &mut Sweep<'_>,
    end: Instant,
    stop: Stop<'_>,
    progress: &mut dyn FnMut(usize, &str),
) -> Result<Option<f64>> {
    // The first round also warms the machine up.
    let mut cost = None;
    for round in 1..=2 {
        let (begin, before) = (Instant::now(), probe.samples(0));
        probe.measure(end, round, stop, progress)?;
        // A round that the time cuts off is dropped, and may have taken an earlier one's block with it.
        let samples = probe.samples(0).saturating_sub(before);
        if samples > 0 {
            cost = Some(begin.elapsed().as_secs_f64() / f64::from(samples));
        }
    }
    Ok(cost)
}

/// Prints the report, on stderr what it holds for.
fn print(report: &Findings, args: &TradeoffArgs) -> Result<()> {
    if args.json {
        print_json(&report.json())?;
    } else {
        // The first line of the basis says what the rest holds for.
        report.basis().iter().take(1).try_for_each(|words| print_line(words))?;
        print_line("each setting's time to a relative MSE of 1e-1, 1e-2 and 1e-3, and its bias:")?;
        print_line(&report.table())?;
        report.advice().iter().try_for_each(|words| print_line(words))?;
    }
    if !args.quiet {
        report.basis().iter().skip(usize::from(!args.json)).for_each(|words| tell(words));
    }
    Ok(())
}

/// An image to measure against.
fn reference_of(path: &Path) -> Result<ExrImage> {
    let image = read_exr(path)?;
    match image.rgb.as_flattened().iter().all(|v| v.is_finite()) {
        true => Ok(image),
        false => Err(Error::Usage(format!(
            "{}: expected a reference of finite numbers, found NaN or infinite pixels",
            path.display()
        ))),
    }
}

/// Crops the reference to a size with enough divisors, and narrows the camera to the same view.
fn middle(image: ExrImage, scene: &mut Scene) -> ExrImage {
    let size = middle_of((image.width, image.height));
    if size == (image.width, image.height) {
        return image;
    }
    let share = |part: u32, all: u32| f64::from(part) / f64::from(all);
    scene.camera.middle = Some(DVec2::new(share(size.0, image.width), share(size.1, image.height)));
    let (left, top) = ((image.width - size.0) as usize / 2, (image.height - size.1) as usize / 2);
    let cut = |pixels: &[[f32; 3]]| -> Pixels {
        let rows = pixels.chunks(image.width as usize).skip(top).take(size.1 as usize);
        rows.flat_map(|row| row.iter().skip(left).take(size.0 as usize)).copied().collect()
    };
    let (rgb, variance) = (cut(&image.rgb), image.variance.as_deref().map(cut));
    ExrImage { width: size.0, height: size.1, rgb, variance, samples: None, rejected: None, ..image }
}

/// A seed with which no image of the sweep shares its random numbers with a reference of this program: shared noise
/// would look like no error.
fn distinct_seed(seed: u32, reference: Option<&ExrImage>) -> u32 {
    match reference.and_then(ExrImage::seed) {
        Some(taken) if Sweep::uses(seed, taken) => taken.wrapping_add(Sweep::SEEDS_BEFORE + 1),
        _ => seed,
    }
}

fn too_short(args: &TradeoffArgs) -> Error {
    let budget = args.budget.as_secs_f64();
    Error::Usage(format!(
        "--budget {budget} s: it is too short to measure the defaults and one setting {FEWEST_ROUNDS} times each; give it more time, or fewer --knobs"
    ))
}

/// The options of `--knobs`, each once; all by default. The number of samples is not among them, because
/// every setting is measured at several numbers. What is a matter of taste has no error.
fn swept_options(args: &TradeoffArgs) -> Result<Vec<&'static OptionSpec>> {
    let of_image = || TRADE_OFFS.iter().copied().filter(|spec| spec.name != SPP.name && spec.class != Class::Look);
    let all = || of_image().chain([&DENOISE]);
    for name in &args.knobs {
        if name == SPP.name {
            let why = "every setting is measured over its samples; the report has the number that each target takes";
            return Err(Error::Usage(format!("--knobs {name}: {why}")));
        }
        if !all().any(|spec| spec.name == name) {
            let names: Vec<&str> = all().map(|spec| spec.name).collect();
            return Err(Error::Usage(format!("--knobs {name}: expected names from {}", names.join(", "))));
        }
    }
    Ok(all().filter(|spec| args.knobs.is_empty() || args.knobs.iter().any(|name| name == spec.name)).collect())
}

/// The denoiser; none if nothing is denoised. If the user names the setting, a missing library is an error. Otherwise the setting is not
/// measured.
fn denoiser_of(args: &TradeoffArgs, specs: &[&OptionSpec]) -> Result<Option<Denoiser>> {
    if !specs.iter().any(|spec| spec.name == DENOISE.name) {
        return Ok(None);
    }
    match Denoiser::open(args.oidn.as_deref()) {
        Err(error) if args.oidn.is_some() || args.knobs.iter().any(|name| name == DENOISE.name) => Err(error),
        opened => Ok(opened.ok()),
    }
}

/// The folder for the report. Creates it unless it exists.
fn folder_of(args: &TradeoffArgs) -> Result<PathBuf> {
    let folder = args.output.clone().unwrap_or_else(|| {
        let stem = stem_of(&args.scene.path).to_string_lossy();
        PathBuf::from(format!("{stem}-tradeoff"))
    });
    make_folder(&folder, "nothing has been measured")?;
    Ok(folder)
}

/// The command line of a render.
#[derive(Parser)]
struct RenderLine {
    #[command(flatten)]
    args: RenderArgs,
}

/// Parses options with `render`'s own parser.
fn options(more: &[String]) -> Result<RenderArgs> {
    let words = ["render", "scene.ron"].into_iter().map(str::to_string).chain(more.iter().cloned());
    RenderLine::try_parse_from(words).map(|line| line.args).map_err(|error| Error::Usage(error.to_string()))
}

/// The defaults, and each value of each option that is not the default.
fn settings_of(scene: &Scene, specs: &[&'static OptionSpec]) -> Result<Vec<Setting>> {
    let setting = |spec: Option<&'static OptionSpec>, value: &str| -> Result<Setting> {
        let given = spec.map_or(Vec::new(), |spec| vec![format!("--{}", spec.name), value.to_string()]);
        // A flag has no value.
        let given: Vec<String> = given.into_iter().filter(|word| !word.is_empty()).collect();
        let mut args = options(&given)?;
        let denoise = args.denoising.denoise;
        if denoise {
            args.options.aov.include(&[Aov::Albedo, Aov::Normal]);
        }
        let scale = match args.goal.image.size {
            Some(Size::Share(share)) => share,
            _ => 1.0,
        };
        let max_depth = args.paths.max_depth.unwrap_or(scene.render.max_depth);
        Ok(Setting { option: spec, value: value.to_string(), options: args.options, max_depth, scale, denoise })
    };
    let mut settings = vec![setting(None, "")?];
    for spec in specs {
        for value in spec.values {
            let is_default = Some(*value) == spec.default || (spec.name == SIZE.name && *value == "100%");
            let cuts_nothing =
                spec.name == MAX_DEPTH.name && value.parse().is_ok_and(|depth: u32| depth >= scene.render.max_depth);
            if !is_default && !cuts_nothing {
                settings.push(setting(Some(spec), value)?);
            }
        }
    }
    Ok(settings)
}

/// Compiles the settings in turn, as long as there is time to measure the compiled ones. A sample of each is assumed to
/// take as many seconds as one of the defaults. The defaults may be compiled already.
fn compile(
    sweep: &mut Sweep<'_>,
    settings: Vec<Setting>,
    cost: f64,
    until: Instant,
    stop: Stop<'_>,
    progress: &mut dyn FnMut(&str),
) -> Result<()> {
    // Assumes that the next compilation takes as long as the last one.
    let mut last = Duration::ZERO;
    for (i, setting) in settings.into_iter().enumerate().skip(sweep.subjects.len()) {
        progress(&format!("compiling {}", setting.name()));
        let rounds = cost * ROUNDS_LEFT * SAMPLES_OF_FEWEST * (sweep.subjects.len() + 1) as f64;
        let needed = last + Duration::from_secs_f64(MARGIN * rounds);
        if i > 0 && (stop() || Instant::now() + needed > until) {
            sweep.leave_out(setting, if stop() { INTERRUPTED } else { UNREACHED });
            continue;
        }
        let begin = Instant::now();
        sweep.add(setting)?;
        last = begin.elapsed();
    }
    Ok(())
}

/// Each setting's picture with the time that the defaults take for a block, until the budget is spent.
fn pictures(
    sweep: &mut Sweep<'_>,
    judged: &Judged,
    reference: Option<&Truth>,
    until: Instant,
    stop: Stop<'_>,
) -> Result<Vec<Example>> {
    let pace = |found: &Measured| found.seconds_here;
    let same_time = judged.measured.first().map_or(0.0, pace) * f64::from(LEVEL);
    let mut examples = Vec::new();
    let Some(weights) = &judged.weights else { return Ok(examples) };
    for found in &judged.measured {
        let of = |subject: &Subject| subject.setting.name() == found.setting.name();
        let Some(subject) = sweep.subjects.iter().position(of) else { continue };
        let samples = ((same_time / pace(found)).round() as u32).max(1);
        let takes = Duration::from_secs_f64(pace(found) * f64::from(samples));
        if stop() || Instant::now() + takes > until {
            break;
        }
        let Some(block) = sweep.image(subject, samples, Sweep::seed_before(sweep.seed, 0), stop)? else { break };
        let own = match reference {
            Some(truth) => Some(truth.clone()),
            None => Truth::pooled(sweep, Some(subject)),
        };
        let Some(truth) = own else { break };
        let map = error_map(sweep.size.0 as usize, &block.image, &truth.image);
        examples.push(Example {
            setting: found.setting.name(),
            samples,
            seconds: block.timed.seconds,
            error: truth.error_of(&block.image, weights),
            relmse: relmse(&block.image, &truth.image).unwrap_or(f64::NAN),
            flip: flip::mean(&map),
            picture: png::picture(sweep.size, &block.image).unwrap_or_default(),
            flip_map: png::heatmap(sweep.size, &map).unwrap_or_default(),
        });
    }
    Ok(examples)
}

fn write(folder: &Path, report: &Findings) -> Result<()> {
    let file = |name: &str, text: &str| atomic::write(&folder.join(name), text.as_bytes());
    file("tradeoff.csv", &report.csv())?;
    file("tradeoff.json", &format!("{:#}\n", report.json()))?;
    if let Some(plot) = plot(report, Width::Wide)? {
        file("plot.svg", &plot)?;
    }
    file("index.html", &html(report)?)
}
