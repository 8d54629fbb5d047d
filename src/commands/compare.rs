//! `gpu-rt compare`: the error of an image against a reference.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::console::{path_text, print_json, print_line, tell, tell_measured};
use super::outputs::{PNG, check_name, check_outputs};
use crate::data::SampleVariance;
use crate::error::{Error, Result};
use crate::metrics::difference::{Difference, ErrorSource, MeanDifference, difference};
use crate::metrics::error::{mse, psnr, relmse, relmse_trimmed};
use crate::metrics::estimate::{CONFIDENCE, Estimate, LEVEL};
use crate::metrics::flip::error_map;
use crate::metrics::images::{Images, QUANTITIES, SampleVariances};
use crate::metrics::pixels::Pixels as SinglePixels;
use crate::metrics::verdict::verdict;
use crate::output::exr::{ExrImage, StateFile, read_exr, read_layer, read_state};
use crate::output::png::write_heatmap;

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The EXR to judge.
    #[arg(value_name = "A.exr")]
    pub image: PathBuf,
    /// The reference: an EXR of the same size, from any renderer.
    #[arg(value_name = "B.exr")]
    pub reference: PathBuf,
    /// Compare this layer of both files instead of the picture: albedo, N, Z, direct, … as `render --aov` names them, or those of other programs.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Also write a heat map of FLIP's error: black is none, pale yellow is the most.
    #[arg(long, value_name = "FILE.png")]
    pub heatmap: Option<PathBuf>,
    /// Exit with status 1 if this metric is above the value, such as relmse=0.01. Metrics: mse, rmse, relmse,
    /// relmse_trimmed, flip and mean_difference (its magnitude). Can be given several times. A pixel that is not finite
    /// fails too.
    #[arg(long, value_name = "METRIC=VALUE", value_parser = limit)]
    pub fail_above: Vec<Limit>,
    /// Print one JSON object on stdout.
    #[arg(long)]
    pub json: bool,
}

/// A metric for which 0 is best, by its name.
type Metric = (&'static str, fn(&Errors) -> f64);

const METRICS: [Metric; 6] = [
    ("mse", |errors| errors.mse),
    ("rmse", |errors| errors.mse.sqrt()),
    ("relmse", |errors| errors.relmse),
    ("relmse_trimmed", |errors| errors.relmse_trimmed),
    ("flip", |errors| errors.flip),
    ("mean_difference", |errors| errors.mean_difference.abs()),
];

/// A limit of `--fail-above`.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    metric: Metric,
    value: f64,
}

fn limit(text: &str) -> std::result::Result<Limit, String> {
    let names = || METRICS.map(|(name, _)| name).join(", ");
    let (name, value) =
        text.split_once('=').ok_or_else(|| format!("expected METRIC=VALUE, with a METRIC of {}", names()))?;
    if name == "psnr" {
        return Err(
            "a higher psnr is better, so it cannot have an upper limit; use mse, or flip for the perceived difference"
                .to_string(),
        );
    }
    let metric = METRICS.into_iter().find(|(known, _)| *known == name);
    let metric = metric.ok_or_else(|| format!("expected one of {}, found {name}", names()))?;
    match value.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(Limit { metric, value }),
        _ => Err(format!("expected a number of at least 0 as the limit of {name}, such as {name}=0.01")),
    }
}

/// Reads both images, prints their differences, and fails if an error is above its limit.
pub fn run(args: &CompareArgs) -> Result<()> {
    let images = [args.image.clone(), args.reference.clone()];
    images.iter().try_for_each(|path| check_name(path, "an EXR: images are read more than once"))?;
    if let Some(path) = &args.heatmap {
        let heatmap = ("--heatmap", Some(path.as_path()), PNG);
        check_outputs(&[heatmap], &images, Some("the report"), "nothing has been compared")?;
    }
    let read = |path| match &args.layer {
        Some(layer) => read_layer(path, layer),
        None => read_exr(path),
    };
    let (mut a, mut b) = (read(&args.image)?, read(&args.reference)?);
    images.iter().zip([&a, &b]).for_each(|(path, image)| tell_measured(path, image));
    let identity = |path| read_state(path).ok().flatten().map(|state| state.identity);
    let identities = identity(&args.image).zip(identity(&args.reference));
    if identities.as_ref().is_some_and(|(a, b)| !a.is_of_scene(b)) {
        tell(&format!(
            "warning: {} and {} are of different scenes, as their headers say",
            args.image.display(),
            args.reference.display()
        ));
    }
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Error::Usage(format!(
            "{} has {} x {} pixels and {} has {} x {}: expected images of one size",
            args.image.display(),
            a.width,
            a.height,
            args.reference.display(),
            b.width,
            b.height
        )));
    }
    let pixels = Pixels::new(&a, &b);
    let variances = a.known_variance().zip(b.known_variance()).map(|(a, b)| [a, b]);
    let (width, height) = (a.width as usize, a.height as usize);
    let of_samples = [&args.image, &args.reference].map(|path| sample_variances(path).filter(|_| args.layer.is_none()));
    let sample_variances = match &of_samples {
        [Some(a), Some(b)] if [a, b].iter().all(|sample_variances| sample_variances.len() == width * height) => {
            Some(SampleVariances { images: [a, b], alike: identities.is_some_and(|(a, b)| a.differs_by_seed(&b)) })
        }
        _ => None,
    };
    let images = Images { width, height, a: &a.rgb, b: &b.rgb, variances, sample_variances };
    let difference = difference(&images).ok_or_else(|| {
        Error::Usage(format!(
            "{} and {}: no pixel is finite in both images, so there is nothing to compare",
            args.image.display(),
            args.reference.display()
        ))
    })?;
    let broken: Vec<usize> = (0..width * height).filter(|&pixel| !images.counts(pixel)).collect();

    // Means are over the finite pixels. FLIP needs the full image: all other pixels are black in both.
    for &pixel in &broken {
        (a.rgb[pixel], b.rgb[pixel]) = ([0.0; 3], [0.0; 3]);
    }
    let mut map = error_map(width, &a.rgb, &b.rgb);
    for &pixel in &broken {
        map[pixel] = 0.0;
    }
    let counted = (map.len() - broken.len()) as f64;
    let flip = map.iter().copied().map(f64::from).sum::<f64>() / counted;
    if let Some(heatmap) = &args.heatmap {
        for &pixel in &broken {
            map[pixel] = 1.0;
        }
        write_heatmap(heatmap, (a.width, a.height), &map)?;
    }
    drop(map);
    for image in [&mut a.rgb, &mut b.rgb] {
        let mut pixels = 0..;
        image.retain(|_| pixels.next().is_some_and(|pixel| broken.binary_search(&pixel).is_err()));
    }
    let unequal = || Error::Usage("an image holds fewer pixels than its header says".to_string());
    let errors = Errors {
        mse: mse(&a.rgb, &b.rgb).ok_or_else(unequal)?,
        relmse: relmse(&a.rgb, &b.rgb).ok_or_else(unequal)?,
        relmse_trimmed: relmse_trimmed(&a.rgb, &b.rgb).ok_or_else(unequal)?,
        psnr: psnr(&a.rgb, &b.rgb).ok_or_else(unequal)?,
        flip,
        mean_difference: difference.means[0].0.difference.value,
    };
    let mut words = verdict(&difference);
    if !broken.is_empty() {
        words += &format!(" (without {})", pixels.broken_words());
        tell(&format!("warning: {}: left out", pixels.broken_words()));
    }
    // The stated error is that of the picture, and says nothing of other layers.
    let reliable = [&a, &b].map(|image| image.reliable().filter(|_| args.layer.is_none()));
    words += &unreliable_words(reliable);
    match args.json {
        true => print_json(&report(args, &errors, &difference, &pixels, reliable, &words))?,
        false => print_table(&errors, &difference, &pixels, &words)?,
    }
    check(&args.fail_above, &errors, &pixels)
}

/// The sentence that follows the verdict if a file calls its own error unreliable.
fn unreliable_words(reliable: [Option<bool>; 2]) -> String {
    let of_one = |name| {
        format!(
            ". {name}'s header calls its error unreliable: {name} may lack light, and then has more error than its noise shows"
        )
    };
    match reliable.map(|reliable| reliable == Some(false)) {
        [false, false] => String::new(),
        [true, false] => of_one("A"),
        [false, true] => of_one("B"),
        [true, true] => ". Both headers call their errors unreliable: A and B may lack light, and then have more error than their noise shows"
            .to_string(),
    }
}

/// The variances of the samples of each pixel, as the state in the file says; none without a state that can be read.
fn sample_variances(path: &Path) -> Option<Vec<SampleVariance>> {
    let state = StateFile::open(path).ok().flatten()?;
    match state.sample_variances() {
        Ok(sample_variances) => Some(sample_variances),
        Err(error) => {
            tell(&format!("warning: {error}: single pixels are not tested"));
            None
        }
    }
}

/// The number of pixels, and the numbers of those that are not finite or negative.
struct Pixels {
    count: usize,
    /// NaN or infinite pixels in the image, in the reference, and in either of them.
    not_finite: [usize; 3],
    negative: [usize; 2],
}

impl Pixels {
    fn new(a: &ExrImage, b: &ExrImage) -> Pixels {
        let broken = |rgb: &[f32; 3]| rgb.iter().any(|v| !v.is_finite());
        let [of_a, of_b] = [a, b].map(|image| image.rgb.iter().filter(|rgb| broken(rgb)).count());
        let either = a.rgb.iter().zip(&b.rgb).filter(|(a, b)| broken(a) || broken(b)).count();
        let is_negative = |rgb: &&[f32; 3]| rgb.iter().any(|v| *v < 0.0);
        let negative = [a, b].map(|image| image.rgb.iter().filter(is_negative).count());
        Pixels { count: a.rgb.len(), not_finite: [of_a, of_b, either], negative }
    }

    fn broken_words(&self) -> String {
        let [a, b, either] = self.not_finite;
        format!("{either} of {} pixels that are NaN or infinite: {a} of A, {b} of B", self.count)
    }
}

/// The errors of A against B.
struct Errors {
    mse: f64,
    relmse: f64,
    relmse_trimmed: f64,
    /// In dB; infinite where the images look alike.
    psnr: f64,
    flip: f64,
    /// Of the luminance.
    mean_difference: f64,
}

/// Fails if a metric is above its limit, or if pixels were left out, because these have no error to compare with a limit.
fn check(limits: &[Limit], errors: &Errors, pixels: &Pixels) -> Result<()> {
    let found = limits.iter().map(|Limit { metric: (name, error), value }| (name, error(errors), value));
    let mut words: Vec<String> = found
        .filter(|(_, error, value)| error > value)
        .map(|(name, error, value)| format!("{name} is {error:.4e}, above {value}"))
        .collect();
    if !limits.is_empty() && pixels.not_finite[2] > 0 {
        words.push(pixels.broken_words());
    }
    match words.is_empty() {
        true => Ok(()),
        false => Err(Error::Limit(format!("--fail-above: {}", words.join("; ")))),
    }
}

/// The confidence interval of the true difference; none if too few pixels determine the error.
fn interval(estimate: &Estimate) -> Option<[f64; 2]> {
    let half = estimate.half_width();
    half.is_finite().then_some([estimate.value - half, estimate.value + half])
}

fn source_words(source: ErrorSource) -> &'static str {
    match source {
        ErrorSource::Variances => "variance layers",
        ErrorSource::Pairs => "paired differences",
        ErrorSource::SharedNoise => "paired differences (the images share their noise)",
    }
}

/// A mean difference with its interval and p-value.
fn mean_json(mean: &MeanDifference, p: f64) -> Value {
    json!({
        "mean_difference": mean.difference.value,
        "interval": interval(&mean.difference),
        "reference_mean": mean.reference,
        "p": p,
    })
}

fn report(
    args: &CompareArgs,
    errors: &Errors,
    difference: &Difference,
    pixels: &Pixels,
    reliable: [Option<bool>; 2],
    words: &str,
) -> Value {
    let [(mean, _), colours @ ..] = &difference.means;
    let relative = |value: f64| (mean.reference > 0.0).then(|| value / mean.reference);
    let colours = colours.iter().zip(&QUANTITIES[1..]);
    let local = difference.local.map(|local| {
        let mut object = mean_json(&local.estimate, local.p);
        for (key, value) in ["left", "top", "width", "height"].into_iter().zip(local.tile) {
            object[key] = json!(value);
        }
        object["quantity"] = json!(local.quantity.name());
        object
    });
    let (most, visible, differing) = match &difference.pixels {
        SinglePixels::Shared { differing, most } => (Some(most), None, Some(*differing)),
        SinglePixels::Tested { most, visible } => (Some(most), Some(*visible).filter(|v| v.is_finite()), None),
        SinglePixels::Untested(most) => (most.as_ref(), None, None),
    };
    let single = most.map(|most| {
        json!({
            "x": most.at[0],
            "y": most.at[1],
            "quantity": most.quantity.name(),
            "difference": most.difference,
            "reference": most.reference,
            "p": (!matches!(difference.pixels, SinglePixels::Untested(_))).then_some(most.p),
            "visible_from": visible,
            "pixels_that_differ": differing,
        })
    });
    let rest = difference.rest.map(|(pixels, [(mean, p), ..])| {
        let mut object = mean_json(&mean, p);
        object["pixels"] = json!(pixels);
        object
    });
    json!({
        "image": path_text(&args.image),
        "reference": path_text(&args.reference),
        "mse": errors.mse,
        "rmse": errors.mse.sqrt(),
        "relmse": errors.relmse,
        "relmse_trimmed": errors.relmse_trimmed,
        // JSON has no infinity: it becomes null.
        "psnr": errors.psnr,
        "flip": errors.flip,
        "mean_difference": mean.difference.value,
        "interval": interval(&mean.difference),
        "confidence": CONFIDENCE,
        "reference_mean": mean.reference,
        "relative_mean_difference": relative(mean.difference.value),
        "relative_interval": interval(&mean.difference).and_then(|[low, high]| Some([relative(low)?, relative(high)?])),
        "interval_from": source_words(difference.source),
        "without_ruling_pixels": rest,
        "colours": colours.map(|((mean, p), colour)| (colour.name(), mean_json(mean, *p))).collect::<BTreeMap<_, _>>(),
        "largest_local_difference": local,
        "single_pixel": single,
        "identical": difference.identical,
        "p": difference.p,
        "level": LEVEL,
        "image_reliable": reliable[0],
        "reference_reliable": reliable[1],
        "pixels": {
            "compared": pixels.count - pixels.not_finite[2],
            "not_finite": {"image": pixels.not_finite[0], "reference": pixels.not_finite[1]},
            "negative": {"image": pixels.negative[0], "reference": pixels.negative[1]},
        },
        "verdict": words,
    })
}

fn print_table(errors: &Errors, difference: &Difference, pixels: &Pixels, words: &str) -> Result<()> {
    let line = |name: &str, text: String| print_line(&format!("{name:<16} {text}"));
    line("MSE", format!("{:.4e}", errors.mse))?;
    line("RMSE", format!("{:.4e}", errors.mse.sqrt()))?;
    line("relMSE", format!("{:.4e}", errors.relmse))?;
    line("relMSE, trimmed", format!("{:.4e}   without the worst 0.1 % of the pixels", errors.relmse_trimmed))?;
    let infinite = errors.psnr.is_infinite();
    line("PSNR", if infinite { "infinite".to_string() } else { format!("{:.2} dB", errors.psnr) })?;
    line("FLIP", format!("{:.5}", errors.flip))?;
    let bounds = |mean: &MeanDifference| {
        let words = match interval(&mean.difference) {
            Some([low, high]) => {
                format!("95 % interval {low:+.3e} to {high:+.3e}, by {}", source_words(difference.source))
            }
            None => "its error is unknown".to_string(),
        };
        format!("{:+.4e}   {words}", mean.difference.value)
    };
    line("mean difference", bounds(&difference.means[0].0))?;
    if let Some((pixels, [(mean, _), ..])) = &difference.rest {
        line("of the others", format!("{}; without the {pixels} pixels that hold most of the noise", bounds(mean)))?;
    }
    let [a, b] = pixels.negative;
    if a + b > 0 {
        line("negative pixels", format!("{a} of A, {b} of B"))?;
    }
    print_line(words)
}
