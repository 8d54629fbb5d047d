//! The request of a render, checked before a device begins: the flattened scene, the job, and the files to write.

use std::borrow::Borrow;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::args::RenderArgs;
use crate::commands::console::command_to_resume;
use crate::commands::denoise::{Denoising, denoised_image, denoised_picture};
use crate::commands::outputs::{EXR, EXR_OR_PNG, PNG, check_outputs};
use crate::commands::scene::{biases, size_of};
use crate::data::RUN_LENGTH;
use crate::denoise::Denoiser;
use crate::error::{Error, Result};
use crate::film::Film;
use crate::flatten::DeviceScene;
use crate::identity::Identity;
use crate::job::{Crop, Frame, Goal, Job, MOST_SAMPLES, light_paths_of};
use crate::options::{Filter, LightPaths, RenderOptions};
use crate::output::destination::{can_be_replaced, is_standard};
use crate::output::exr::{Attribute, State, read_state, write_render};
use crate::output::format::{Format, format_of};
use crate::output::png::write_png;
use crate::samples::Samples;
use crate::scene::Scene;

/// What the stated error of any render excludes, in words.
const EXCLUDED: &str =
    "what max_depth cut off (cut_paths), rejected samples, light that no sample has met, and rounding (about 1e-6)";

/// The request of a render.
pub struct Request<'a> {
    pub args: &'a RenderArgs,
    pub scene: &'a Scene,
    pub frame: Frame,
    pub job: Job,
    /// What `-o` names: an EXR, or a PNG, which has no state, so that nothing can go on from it.
    pub image: PathBuf,
    pub format: Format,
    /// Warnings about the scene, all of which every checkpoint has in its header.
    pub warnings: Vec<String>,
    /// The names of the materials, in the order of their numbers.
    pub materials: Vec<String>,
    /// With `--aov object`: the names of the objects, in the order of their numbers.
    pub objects: Vec<String>,
    /// With mattes: the names of each kind.
    pub matte_names: Vec<Vec<String>>,
    /// Samples of each pixel that the output has already, if the render goes on with them.
    pub held: Option<u64>,
    /// Known when it is first needed: hashing a large scene takes as long as reading it.
    identity: OnceLock<Identity>,
}

impl<'a> Request<'a> {
    /// What the arguments ask of a scene. `start` is when the time of `--time` begins.
    ///
    /// # Errors
    /// `Error::Usage` if a file cannot be written as it is asked for, or if `--crop` is not within the image.
    pub fn new(args: &'a RenderArgs, scene: &'a Scene, start: Instant) -> Result<Request<'a>> {
        check_mattes(&args.options)?;
        let (image, format) = checked_image(args, scene)?;
        let (frame, job) = frame_and_job(args, scene, start)?;
        let (warnings, materials, objects) = (scene.warnings(), Vec::new(), Vec::new());
        let identity = OnceLock::new();
        let (matte_names, held) = (Vec::new(), None);
        Ok(Request {
            args,
            scene,
            frame,
            job,
            image,
            format,
            warnings,
            materials,
            objects,
            matte_names,
            held,
            identity,
        })
    }

    /// Takes what the flattened scene says. As `check` has them, its warnings follow those of the scene.
    ///
    /// # Errors
    /// `Error::Usage` if no light path belongs to the samples.
    pub fn take(&mut self, view: &DeviceScene) -> Result<()> {
        check_light_paths(&self.job, &self.frame, view.light_paths(&self.args.options))?;
        self.warnings.extend_from_slice(&view.warnings);
        self.materials.clone_from(&view.material_names);
        self.objects.clone_from(&view.object_names);
        self.matte_names.clone_from(&view.matte_names);
        Ok(())
    }

    pub fn identity(&self) -> &Identity {
        self.identity.get_or_init(|| Identity::new(self.scene, &self.frame, &self.job, &self.args.options))
    }

    /// The options that bias the result or are less exact, as they were given.
    pub fn biases(&self) -> Vec<String> {
        let biases = biases(&self.args.options, self.args.paths.max_depth, self.scene);
        biases.iter().map(|(setting, value)| setting.option(value)).collect()
    }

    /// What the stated error excludes, in words.
    pub fn excluded(&self) -> String {
        excluded(&self.biases().join(", "))
    }

    /// The path of the EXR, which may have a state.
    pub fn exr(&self) -> Option<&Path> {
        (self.format == Format::Exr).then_some(&*self.image)
    }

    /// How many samples of this render the EXR holds, if these are more than `count` and --force does not give them up.
    pub fn more_than(&self, count: u64) -> Option<u64> {
        let exr = self.exr().filter(|_| !self.args.keep.force)?;
        more_there(exr, || self.identity(), count)
    }

    /// Writes the image that `-o` names. It is an error if that is an EXR with more samples of this render, which another process may have
    /// put there meanwhile. Nothing can go on from an image without a state.
    pub fn write(&self, film: &Film, state: Option<&State>, attributes: &[(String, Attribute)]) -> Result<()> {
        let Some(exr) = self.exr() else { return self.write_picture(&self.image, film) };
        let mine = state.map(|state| state.samples.count());
        let may = || match mine.and_then(|mine| Some((mine, self.more_than(mine)?))) {
            None => Ok(()),
            Some((mine, more)) => Err(format!(
                "it holds {more} samples per pixel of this render, more than the {mine} here: it stays. --force overwrites it"
            )),
        };
        write_render(exr, film, &self.with_mattes(attributes), state.filter(|_| !self.args.keep.no_state), may)
    }

    /// Writes the image into a file that has been made for it.
    pub fn write_to(
        &self,
        exr: &Path,
        film: &Film,
        state: Option<&State>,
        attributes: &[(String, Attribute)],
    ) -> Result<()> {
        write_render(exr, film, &self.with_mattes(attributes), state.filter(|_| !self.args.keep.no_state), || Ok(()))
    }

    /// These attributes with those that name the ids of mattes.
    fn with_mattes(&self, attributes: &[(String, Attribute)]) -> Vec<(String, Attribute)> {
        let of_mattes = self.args.options.aov.matte_attributes(&self.matte_names);
        attributes
            .iter()
            .cloned()
            .chain(of_mattes.into_iter().map(|(name, text)| (name, Attribute::Text(text))))
            .collect()
    }

    /// Writes the picture with the EXR, if requested.
    pub fn write_png(&self, film: &Film) -> Result<()> {
        self.args.files.png.as_ref().map_or(Ok(()), |png| self.write_picture(png, film))
    }

    /// Writes that picture at a checkpoint. A pipe gets one picture, at the end.
    pub fn write_png_so_far(&self, film: &Film) -> Result<()> {
        match self.args.files.png.as_ref().is_some_and(|png| can_be_replaced(png)) {
            true => self.write_png(film),
            false => Ok(()),
        }
    }

    fn write_picture(&self, png: &Path, film: &Film) -> Result<()> {
        write_png(png, self.job.size, &|index| film.developed(index).rgb, &self.args.view.transform())
    }

    /// What a file holds that has so many samples of this render, and the command that goes on with it.
    pub fn what_is_in(&self, file: &Path, samples: &Samples) -> String {
        let (name, count) = (file.display(), samples.count());
        let is_picture = self.exr().is_none() && file == self.image;
        if is_picture || self.args.keep.no_state || count == 0 || !can_be_replaced(file) {
            return format!("{name} holds the image so far, {count} samples per pixel");
        }
        let may_differ = match self.ends_within_run(samples) {
            true => {
                ". A resumed render may differ from an uninterrupted one in the last bits, as the samples end within a run of 8"
            }
            false => "",
        };
        let moved = match self.args.goal.frames.is_some() && file != self.image {
            true => format!("Move it to {}, and ", self.image.display()),
            false => String::new(),
        };
        let command = command_to_resume(file);
        format!("{name} holds {count} samples per pixel. {moved}`{command}` goes on{may_differ}")
    }

    /// Whether the samples end within a run that the full render would have completed.
    pub fn ends_within_run(&self, samples: &Samples) -> bool {
        let end = samples.range().end;
        !end.is_multiple_of(RUN_LENGTH) && end < self.job.goal.end()
    }
}

/// Refuses mattes with a filter that they cannot be counted by. The camera samples of the others are drawn in proportion to the filter.
fn check_mattes(options: &RenderOptions) -> Result<()> {
    match !options.aov.mattes().is_empty() && options.filter == Filter::Mitchell {
        true => Err(Error::Usage(
            "--filter mitchell: --aov cryptomatte counts samples, and this filter has negative weights, which no count has: use --filter \
             gauss, tent or box; nothing has been rendered"
                .to_string(),
        )),
        false => Ok(()),
    }
}

/// Refuses samples that no light path belongs to, which would lack light.
fn check_light_paths(job: &Job, frame: &Frame, light_paths: LightPaths) -> Result<()> {
    let Goal::Samples(end) = job.goal else { return Ok(()) };
    let (first, (width, height)) = (job.first_sample, frame.full);
    let of_run = u64::from(width) * u64::from(height) * u64::from(light_paths.count());
    match of_run == 0 || first >= end || light_paths_of(&(first..end), of_run) > 0 {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "--samples {first}..{end} has no light path: an image of {width} x {height} pixels has {of_run} for each {RUN_LENGTH} samples. \
             Take more of them, or use --light-paths off"
        ))),
    }
}

/// What the stated error excludes where these options bias the result, in words.
pub fn excluded(biases: &str) -> String {
    match biases {
        "" => EXCLUDED.to_string(),
        biases => format!("{EXCLUDED}, and what {biases} did"),
    }
}

/// How many samples a file holds, if it is of the render with this identity and has more than so many.
pub fn more_there<I: Borrow<Identity>>(exr: &Path, identity: impl FnOnce() -> I, than: u64) -> Option<u64> {
    if !exr.is_file() {
        return None;
    }
    let state = read_state(exr).ok().flatten().filter(|state| state.samples.count() > than)?;
    identity().borrow().difference("", &state.identity, "").is_none().then(|| state.samples.count())
}

/// The image to write and its format, checked before anything costs time, together with the other files of the render.
fn checked_image(args: &RenderArgs, scene: &Scene) -> Result<(PathBuf, Format)> {
    let image = args.image();
    let png = args.files.png.as_deref();
    // A name that says no format is refused below.
    let format = format_of(&image, EXR_OR_PNG).unwrap_or(Format::Exr);
    let denoised = args.denoising.denoise.then(|| denoised_image(&image));
    let denoised_png = png.filter(|_| args.denoising.denoise).and_then(denoised_picture);
    if args.denoising.denoise && (format == Format::Png || !can_be_replaced(&image)) {
        return Err(Error::Usage(format!(
            "{}: --denoise reads the EXR that the render writes: give -o {}; nothing has been rendered",
            image.display(),
            args.default_image().display()
        )));
    }
    let images = [
        ("-o", Some(&*image), EXR_OR_PNG),
        ("--png", png, PNG),
        ("-o", denoised.as_deref(), EXR),
        ("--png", denoised_png.as_deref(), PNG),
    ];
    let stdout = args.messages.json.then_some("the report of --json");
    check_outputs(&images, &scene.inputs(), stdout, "nothing has been rendered")?;
    let why = match format {
        Format::Exr => None,
        Format::Png if !args.options.aov.is_empty() => Some("a PNG has no room for the channels of --aov"),
        Format::Png if args.keep.resume.is_some() => Some("a PNG cannot be resumed, and --resume goes on from an EXR"),
        Format::Png if png.is_some() => Some("-o and --png are both a PNG"),
        Format::Png => None,
    };
    let Some(why) = why else { return Ok((image, format)) };
    let exr = if is_standard(&image) { args.default_image() } else { image.with_extension("exr") };
    let (name, exr) = (image.display(), exr.display());
    Err(Error::Usage(format!("{name}: {why}: give -o {exr} --png {name}; nothing has been rendered")))
}

/// Loads the library that denoises, before anything costs time; `None` without `--denoise`.
pub fn denoising_of(args: &RenderArgs, image: &Path) -> Result<Option<Denoising>> {
    if !args.denoising.denoise {
        return Ok(None);
    }
    let undone = |error: Error| Error::Denoiser(format!("{error}. Nothing has been rendered"));
    let denoiser = Denoiser::open(args.denoising.oidn.as_deref()).map_err(undone)?;
    let (exr, png) = (denoised_image(image), args.files.png.as_deref().and_then(denoised_picture));
    Ok(Some(Denoising { denoiser, exr, png, view: args.view.transform() }))
}

/// The requested part of the image, and the goal of its render.
pub fn frame_and_job(args: &RenderArgs, scene: &Scene, start: Instant) -> Result<(Frame, Job)> {
    let full = size_of(scene, args.goal.image.size);
    let part = args.goal.crop.unwrap_or(Crop::full(full));
    if !part.is_in(full) {
        let (width, height) = full;
        return Err(Error::Usage(format!(
            "--crop {part}: expected a part of the image, which has {width} x {height} pixels"
        )));
    }
    let size = part.size();
    let samples = args.goal.samples.clone().unwrap_or(0..args.goal.image.spp.unwrap_or(scene.render.samples));
    let deadline = args.goal.time.map(|time| start + time.saturating_sub(write_time(size, args)));
    let end = args.goal.image.spp.unwrap_or(MOST_SAMPLES as u32);
    let goal = match (args.goal.noise, deadline) {
        (None, None) => Goal::Samples(samples.end),
        (None, Some(deadline)) => Goal::Until { deadline, end },
        (Some(error), deadline) => Goal::Noise { error, deadline, end, begun: samples.start, checks: 0 },
    };
    let max_depth = args.paths.max_depth.unwrap_or(scene.render.max_depth);
    let job = Job { size, max_depth, seed: args.paths.seed, first_sample: samples.start, goal };
    Ok((Frame { part, full }, job))
}

/// What developing and writing the image is allowed for under `--time`: measured as 0.15 to 0.5 µs a pixel on two cores, and 0.5 to 0.6 µs more
/// with the state; denoising takes 5 µs.
fn write_time((width, height): (u32, u32), args: &RenderArgs) -> Duration {
    let state = if args.keep.no_state { 0 } else { 600 };
    let denoise = if args.denoising.denoise { 5000 } else { 0 };
    let pixels = u64::from(width) * u64::from(height);
    Duration::from_nanos(pixels * (500 + state + denoise)) + Duration::from_millis(20)
}
