//! `gpu-rt tradeoff`: what the settings of `render` trade on a scene, measured within a budget of time.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use clap::Parser;

use super::{open_device, path_text, print_json, print_line, stop_on_interrupt, tell, tell_software, wish_of};
use crate::cli::{Cli, Command, RenderArgs, Size, TradeoffArgs};
use crate::error::{Error, Result};
use crate::film::UNKNOWN_VARIANCE;
use crate::gpu::device::Device;
use crate::knobs::{KNOBS, Knob, MAX_DEPTH, SIZE, SPP};
use crate::metrics::error::{relative_variance, relmse};
use crate::metrics::flip::error_map;
use crate::output::atomic;
use crate::output::exr::{ExrImage, read_exr};
use crate::output::png;
use crate::output::progress::Loading;
use crate::scene::Scene;
use crate::tradeoff::judge::{Measured, judge, median, pooled};
use crate::tradeoff::page::{Shown, html};
use crate::tradeoff::replicates::{Pixels, noise, signed_bias};
use crate::tradeoff::report::Report;
use crate::tradeoff::sweep::{Block, LEVEL, LEVELS, SAMPLES_OF_ROUND, Setting, Subject, Sweep};

/// The most pixels of the images that are measured: more tell the same about the settings.
const MOST_PIXELS: f64 = 65_536.0;
/// The fewest, below which an image is no picture of its scene.
const FEWEST_PIXELS: f64 = 1_024.0;
/// The rounds that the size is chosen for, and the most that are done.
const ROUNDS: f64 = 12.0;
const MOST_ROUNDS: usize = 32;
/// The shares of the budget after which the pilot ends, compiling at the size that is measured, measuring, and the calibration by the
/// whole size. The rest is for pictures and the report.
const PILOT: f64 = 0.3;
const COMPILING: f64 = 0.5;
const MEASURING: f64 = 0.8;
const CALIBRATING: f64 = 0.9;
/// Pixels of the pilot that finds what each setting costs.
const PILOT_PIXELS: f64 = 4_096.0;

/// Measures and reports.
pub fn run(args: &TradeoffArgs, start: Instant) -> Result<()> {
    let scene = Scene::load(&args.scene)?;
    let knobs = knobs_of(args)?;
    let reference = args.reference.as_deref().map(read_exr).transpose()?;
    let whole = match &reference {
        Some(image) => (image.width, image.height),
        None => (scene.image.width, scene.image.height),
    };
    let folder = folder_of(args)?;
    let device = open_device(args.device.as_deref())?;
    if !args.quiet {
        tell_software(&device);
    }
    let stopped = stop_on_interrupt();
    let stop = || stopped.load(Ordering::Relaxed);
    let at = |share: f64| start + Duration::from_secs_f64(share * args.budget.as_secs_f64());

    let mut loading = Loading::new(args.quiet);
    let mut progress = |words: &str| {
        let share = start.elapsed().as_secs_f64() / args.budget.as_secs_f64();
        loading.show(words, share.min(1.0));
    };
    // First small, which tells what each setting costs; then at the size that the rest of the budget is enough for.
    let exact = reference.is_some();
    let begin = Instant::now();
    let small = size_of(whole, PILOT_PIXELS, exact);
    let mut pilot = Sweep::new(&device, &scene, small, args.seed);
    compile(&mut pilot, settings_of(&scene, &knobs)?, at(PILOT), &stop, &mut progress)?;
    pilot.measure(at(PILOT), 1, &stop, &mut |_, name| progress(&format!("pilot: {name}")))?;
    let left = at(MEASURING).saturating_duration_since(Instant::now()).saturating_sub(begin.elapsed() / 2);
    let size = size_of(whole, pixels_for(&pilot, left.as_secs_f64()), exact);
    let mut sweep = match size == small {
        true => pilot,
        false => {
            let mut sweep = Sweep::new(&device, &scene, size, args.seed);
            sweep.unmeasured = pilot.unmeasured;
            let settings = pilot.subjects.into_iter().map(|subject| subject.setting).collect();
            compile(&mut sweep, settings, at(COMPILING), &stop, &mut progress)?;
            sweep
        }
    };
    sweep.measure(at(MEASURING), MOST_ROUNDS, &stop, &mut |round, name| {
        progress(&format!("round {}: {name}", round + 1))
    })?;
    let whole_over_small = match size == whole {
        true => None,
        false => calibrate(&mut sweep, &scene, &device, whole, at(CALIBRATING), &stop)?,
    };
    drop(loading);

    let smaller = reference.as_ref().map(|image| shrunk(image, size));
    let truth = smaller.clone().or_else(|| pooled(&sweep, None)).ok_or_else(|| too_short(args))?;
    let measured = judge(&mut sweep, &truth, whole_over_small.unwrap_or((1.0, 1.0)));
    if measured.is_empty() {
        return Err(too_short(args));
    }
    let shown = pictures(&mut sweep, &measured, smaller.as_ref(), at(1.0), &stop)?;
    let report = Report {
        scene: args.scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        device: device.name.name.clone(),
        driver: device.name.driver.clone(),
        size,
        whole_size: whole,
        calibration: whole_over_small,
        seed: args.seed,
        budget: args.budget.as_secs_f64(),
        seconds: start.elapsed().as_secs_f64(),
        reference: args.reference.as_deref().map(path_text),
        error_of_reference: reference.as_ref().and_then(|image| error_of(image, size)),
        against_reference: smaller.as_ref().and_then(|truth| against(&sweep, truth)),
        interrupted: stop(),
        measured,
        unmeasured: sweep.unmeasured.clone(),
    };
    write(&folder, &report, &shown)?;
    if args.json {
        print_json(&report.json());
    } else {
        print_line(&report.table());
        report.advice().iter().for_each(|words| print_line(words));
    }
    if !args.quiet {
        report.basis().iter().for_each(|words| tell(words));
        tell(&format!("{}: {:.0} s", folder.join("index.html").display(), start.elapsed().as_secs_f64()));
    }
    match report.interrupted {
        true => Err(Error::Interrupted(format!("interrupted; {} holds what was measured", folder.display()))),
        false => Ok(()),
    }
}

fn too_short(args: &TradeoffArgs) -> Error {
    let budget = args.budget.as_secs_f64();
    Error::Usage(format!(
        "--budget {budget} s: the defaults alone took longer than that three times over; give it more"
    ))
}

/// The knobs asked for, all by default. Samples are what every setting is measured over.
fn knobs_of(args: &TradeoffArgs) -> Result<Vec<&'static Knob>> {
    let all = || KNOBS.iter().copied().filter(|knob| knob.name != SPP.name);
    if args.knobs.is_empty() {
        return Ok(all().collect());
    }
    args.knobs
        .iter()
        .map(|name| {
            all().find(|knob| knob.name == name).ok_or_else(|| {
                let names: Vec<&str> = all().map(|knob| knob.name).collect();
                Error::Usage(format!("--knobs {name}: expected names from {}", names.join(", ")))
            })
        })
        .collect()
}

/// The folder for the report, made where there is none.
fn folder_of(args: &TradeoffArgs) -> Result<PathBuf> {
    let folder = args.output.clone().unwrap_or_else(|| {
        let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from(format!("{stem}-tradeoff"))
    });
    let failed = |error: std::io::Error| Error::File {
        path: folder.clone(),
        action: "write",
        reason: format!("{error}; nothing has been measured"),
    };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    Ok(folder)
}

/// The options of `render` with one of them given, as its own parser reads it.
fn options(more: &[String]) -> Result<RenderArgs> {
    let words = ["gpu-rt", "render", "scene.ron"].into_iter().map(str::to_string).chain(more.iter().cloned());
    match Cli::try_parse_from(words) {
        Ok(Cli { command: Command::Render(args) }) => Ok(args),
        Ok(_) => Err(Error::Usage("this is no render".to_string())),
        Err(error) => Err(Error::Usage(error.to_string())),
    }
}

/// The defaults, and each value of each knob that is not the default.
fn settings_of(scene: &Scene, knobs: &[&'static Knob]) -> Result<Vec<Setting>> {
    let setting = |knob: Option<&'static Knob>, value: &str| -> Result<Setting> {
        let given = knob.map_or(Vec::new(), |knob| vec![format!("--{}", knob.name), value.to_string()]);
        let args = options(&given)?;
        let scale = match args.size {
            Some(Size::Share(share)) => share,
            _ => 1.0,
        };
        let max_depth = args.max_depth.unwrap_or(scene.render.max_depth);
        Ok(Setting { knob, value: value.to_string(), wish: wish_of(&args.trade), max_depth, scale })
    };
    let mut settings = vec![setting(None, "")?];
    for knob in knobs {
        for value in knob.values {
            let is_default = Some(*value) == knob.default || (knob.name == SIZE.name && *value == "100%");
            let cuts_nothing =
                knob.name == MAX_DEPTH.name && value.parse().is_ok_and(|depth: u32| depth >= scene.render.max_depth);
            if !is_default && !cuts_nothing {
                settings.push(setting(Some(knob), value)?);
            }
        }
    }
    Ok(settings)
}

/// Compiles the settings in turn, as far as the time goes.
fn compile(
    sweep: &mut Sweep<'_>,
    settings: Vec<Setting>,
    until: Instant,
    stop: &dyn Fn() -> bool,
    progress: &mut dyn FnMut(&str),
) -> Result<()> {
    // One more may take as long as the last did.
    let mut last = Duration::ZERO;
    for (i, setting) in settings.into_iter().enumerate() {
        progress(&format!("compiling {}", setting.name()));
        if i > 0 && (stop() || Instant::now() + last > until) {
            sweep.leave_out(setting, "the budget did not reach it");
            continue;
        }
        let begin = Instant::now();
        sweep.add(setting)?;
        last = begin.elapsed();
    }
    Ok(())
}

/// The pixels that so many seconds are enough for, by what a round of the pilot took.
fn pixels_for(pilot: &Sweep<'_>, seconds: f64) -> f64 {
    let of_sample = |subject: &Subject<'_>| {
        let (samples, blocks) = subject.blocks.iter().next_back()?;
        Some(blocks.last()?.seconds / f64::from(*samples))
    };
    let known: Vec<f64> = pilot.subjects.iter().filter_map(of_sample).collect();
    // What the pilot did not reach is taken to cost what the others do.
    let of_all = known.iter().sum::<f64>() * pilot.subjects.len() as f64 / known.len().max(1) as f64;
    let of_pixel = of_all / (f64::from(pilot.size.0) * f64::from(pilot.size.1));
    (seconds / (of_pixel * SAMPLES_OF_ROUND * ROUNDS)).clamp(FEWEST_PIXELS, MOST_PIXELS)
}

/// What the defaults take and how noisy they are at the whole size, over the same at the sweep's: seconds of a sample, and relMSE by
/// noise. All settings are taken to change alike. Nothing where the time is not enough.
fn calibrate(
    sweep: &mut Sweep<'_>,
    scene: &Scene,
    device: &Device,
    whole: (u32, u32),
    until: Instant,
    stop: &dyn Fn() -> bool,
) -> Result<Option<(f64, f64)>> {
    const SAMPLES: u32 = LEVELS[0];
    const IMAGES: u32 = 3;
    let Some(defaults) = sweep.subjects.first() else { return Ok(None) };
    let Some(blocks) = defaults.blocks.get(&SAMPLES).filter(|blocks| blocks.len() >= 3) else { return Ok(None) };
    let area = |size: (u32, u32)| f64::from(size.0) * f64::from(size.1);
    let small_seconds = median(&blocks.iter().map(|block| block.seconds).collect::<Vec<_>>());
    let expected = Duration::from_secs_f64(small_seconds * area(whole) / area(sweep.size) * f64::from(IMAGES));
    if stop() || Instant::now() + expected + Duration::from_secs_f64(defaults.seconds_compile) > until {
        return Ok(None);
    }
    let (mut large, setting) = (Sweep::new(device, scene, whole, 0), defaults.setting.clone());
    large.add(setting)?;
    let mut found = Vec::new();
    for seed in 0..IMAGES {
        match large.image(0, SAMPLES, sweep.seed.wrapping_sub(2 + seed), stop)? {
            Some(block) => found.push(block),
            None => return Ok(None),
        }
    }
    let seconds = median(&found.iter().map(|block| block.seconds).collect::<Vec<_>>()) / small_seconds;
    let noise_of = |blocks: &[Block]| {
        let images: Vec<Pixels> = blocks.iter().map(|block| block.image.clone()).collect();
        Some(noise(&images, &mean_of(&images))?.value)
    };
    let ratio = noise_of(&found).zip(noise_of(&blocks[..IMAGES as usize])).map(|(large, small)| large / small);
    Ok(Some((seconds, ratio.filter(|ratio| ratio.is_finite() && *ratio > 0.0).unwrap_or(1.0))))
}

fn mean_of(images: &[Pixels]) -> Pixels {
    let mut sum = vec![[0.0f64; 3]; images.first().map_or(0, Vec::len)];
    for image in images {
        sum.iter_mut().zip(image).for_each(|(sum, p)| (0..3).for_each(|c| sum[c] += f64::from(p[c])));
    }
    sum.iter().map(|p| p.map(|v| (v / images.len() as f64) as f32)).collect()
}

/// The whole size divided so that about so many pixels are left; by a common divisor of both sides where pixels must be whole ones.
fn size_of((width, height): (u32, u32), pixels: f64, exact: bool) -> (u32, u32) {
    let times = (f64::from(width) * f64::from(height) / pixels).sqrt().max(1.0);
    if exact {
        let divides = |by: &u32| width % by == 0 && height % by == 0;
        let by = (1..=width.min(height)).filter(divides).find(|by| f64::from(*by) >= times);
        // None does: as small as it goes.
        let by = by.or_else(|| (1..=width.min(height)).rfind(divides)).unwrap_or(1);
        return (width / by, height / by);
    }
    let side = |side: u32| ((f64::from(side) / times).round() as u32).max(1);
    (side(width), side(height))
}

/// The mean over blocks of pixels: with the box filter that is the very image of that size.
fn shrunk(image: &ExrImage, size: (u32, u32)) -> Pixels {
    let by = (image.width / size.0) as usize;
    let sum = |x: usize, y: usize| {
        let rows = (y * by..(y + 1) * by).map(|row| row * image.width as usize);
        let pixels = rows.flat_map(|row| &image.rgb[row + x * by..row + (x + 1) * by]);
        let sum = pixels.fold([0.0f64; 3], |sum, p| std::array::from_fn(|c| sum[c] + f64::from(p[c])));
        sum.map(|v| (v / (by * by) as f64) as f32)
    };
    (0..size.1 as usize).flat_map(|y| (0..size.0 as usize).map(move |x| (x, y))).map(|(x, y)| sum(x, y)).collect()
}

/// The relMSE of a reference by its own noise at a size, where its file tells the variances.
fn error_of(image: &ExrImage, size: (u32, u32)) -> Option<f64> {
    let variance = image.variance.as_ref().filter(|v| !v.as_flattened().contains(&UNKNOWN_VARIANCE))?;
    let by = f64::from(image.width / size.0);
    let of_means = ExrImage { rgb: variance.clone(), width: image.width, height: image.height, ..ExrImage::default() };
    // A mean of n pixels has an n-th of their mean variance.
    relative_variance(&shrunk(&of_means, size), &shrunk(image, size)).map(|error| error / (by * by))
}

/// The defaults' mean against the reference's.
fn against(sweep: &Sweep<'_>, truth: &Pixels) -> Option<(f64, f64)> {
    let blocks = sweep.subjects.first()?.blocks.get(&LEVEL)?;
    let images: Vec<Pixels> = blocks.iter().map(|block| block.image.clone()).collect();
    let same = vec![truth.clone(); images.len()];
    let found = signed_bias(&images, &same, truth)?;
    Some((found.value, found.half_width()))
}

/// Every setting's picture after the time that the defaults take for a block, as far as the budget goes.
fn pictures(
    sweep: &mut Sweep<'_>,
    measured: &[Measured],
    reference: Option<&Pixels>,
    until: Instant,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Shown>> {
    let pace = |found: &Measured| found.seconds_here;
    let same_time = pace(&measured[0]) * f64::from(LEVEL);
    let mut shown = Vec::new();
    for found in measured {
        let of = |subject: &Subject<'_>| subject.setting.name() == found.setting.name();
        let Some(subject) = sweep.subjects.iter().position(of) else { continue };
        let samples = ((same_time / pace(found)).round() as u32).max(1);
        let takes = Duration::from_secs_f64(pace(found) * f64::from(samples));
        if stop() || Instant::now() + takes > until {
            break;
        }
        let Some(block) = sweep.image(subject, samples, u32::MAX, stop)? else { break };
        let own = match reference {
            Some(truth) => Some(truth.clone()),
            None => pooled(sweep, Some(subject)),
        };
        let Some(truth) = own else { break };
        let map = error_map(sweep.size.0 as usize, &block.image, &truth);
        let flip = map.iter().map(|&e| f64::from(e)).sum::<f64>() / map.len().max(1) as f64;
        shown.push(Shown {
            setting: found.setting.name(),
            samples,
            seconds: block.seconds,
            relmse: relmse(&block.image, &truth).unwrap_or(f64::NAN),
            flip,
            picture: png::picture(sweep.size, &block.image).unwrap_or_default(),
            flip_map: png::heatmap(sweep.size, &map).unwrap_or_default(),
        });
    }
    Ok(shown)
}

fn write(folder: &Path, report: &Report, shown: &[Shown]) -> Result<()> {
    let file = |name: &str, text: &str| atomic::replace(&folder.join(name), |file| file.write_all(text.as_bytes()));
    file("tradeoff.csv", &report.csv())?;
    file("tradeoff.json", &format!("{:#}\n", report.json()))?;
    file("index.html", &html(report, shown)?)
}
