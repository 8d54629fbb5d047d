//! `gpu-rt page`: a scene as a page that renders itself.

use std::path::PathBuf;

use clap::Args;

use super::console::tell;
use super::outputs::{check_name, make_folder};
use super::scene::{flatten_for, load, stem_of, tell_biases};
use crate::cli::SceneArgs;
use crate::error::{Error, Result};
use crate::gpu::device::DeviceClass;
use crate::job::{Frame, Goal, Job, MOST_SAMPLES, Size};
use crate::options::{RenderOptions, SIZE, Scatter};
use crate::output::{png, writable};
use crate::page::{Page, STORAGE_BUFFERS, most_pixels, needs, plan_and_data, with_camera, write_folder, write_single};
use crate::plan::Plan;
use crate::printable::{counted, percent};
use crate::render::{NOISE_LEVEL, empty_film};
use crate::scene::Scene;
use crate::session::Session;

/// A page renders until it is closed.
const SAMPLES: u32 = 1 << 20;

#[derive(Debug, Args)]
pub struct PageArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The folder to write the page into; with --single, the .html file.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write one .html file, which opens from a disk.
    #[arg(long)]
    pub single: bool,
    /// Samples per pixel of the picture that is shown where a browser has no WebGPU. 0 for none, which needs no device.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=MOST_SAMPLES), default_value_t = 64)]
    pub spp: u32,
    #[arg(long, value_name = "WxH|W|N%", help = SIZE.about, long_help = SIZE.help(), help_heading = SIZE.class.heading())]
    pub size: Option<Size>,
    /// The device that renders the picture.
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,
    #[command(flatten)]
    pub options: RenderOptions,
}

/// Writes the page, and says what not every browser has that it needs.
pub fn run(args: &PageArgs) -> Result<()> {
    check_name(&args.output, if args.single { "an .html file" } else { "a folder" })?;
    if !args.options.aov.is_empty() {
        return Err(Error::Usage("--aov: a page shows the image alone".to_string()));
    }
    if args.options.scatter.is_some_and(|scatter| scatter != Scatter::Linked) {
        return Err(Error::Usage("--scatter: the kernels of a page are linked".to_string()));
    }
    let undone = "no page has been written";
    if args.single {
        let refused = |reason| Error::Usage(format!("{}: cannot write: {reason}; {undone}", args.output.display()));
        writable::check(&args.output).map_err(refused)?;
    }
    let scene = load(&args.scene)?;
    // A page has a kernel for each stage: one for all of them takes a browser's compiler long.
    let options = RenderOptions { scatter: Some(Scatter::Linked), ..args.options.clone() };
    let (size, flat) = flatten_for(&scene, args.size, &options)?;
    let max_depth = scene.render.max_depth;
    let job = |samples| Job { size, max_depth, seed: 0, first_sample: 0, goal: Goal::Samples(samples) };
    scene.warnings().iter().chain(&flat.warnings).for_each(|warning| tell(&format!("warning: {warning}")));
    tell_biases(&args.options, None, &scene, false);
    let flat = with_camera(flat);
    let plan = Plan::within(&flat, &options, DeviceClass::default(), &job(SAMPLES), STORAGE_BUFFERS)?;
    for need in needs(&plan) {
        tell(&format!("warning: not every browser renders this page: {need}"));
    }
    let is_fixed = args.size.is_some() || !flat.placement.scales;
    let (pixels, most) = (u64::from(size.0) * u64::from(size.1), most_pixels(&plan));
    if is_fixed && pixels > most {
        return Err(Error::Usage(format!(
            "an image of {} x {} pixels: a page of this scene holds {most} pixels at most; give a smaller --size, and {undone}",
            size.0, size.1
        )));
    }
    if !args.single {
        make_folder(&args.output, undone)?;
    }
    let film = empty_film(&flat, size, &plan.options)?;
    let (sections, data) = plan_and_data(&plan, &job(SAMPLES), &film, is_fixed)?;
    let picture = (args.spp > 0).then(|| picture(args, &scene, &options, &job(args.spp))).transpose()?;
    let title = stem_of(&args.scene.path).to_string_lossy().into_owned();
    let page = Page { title, plan: sections, data, picture };
    if args.single { write_single(&page, &args.output) } else { write_folder(&page, &args.output) }
}

/// A picture of the scene as a PNG, and its words.
fn picture(args: &PageArgs, scene: &Scene, options: &RenderOptions, job: &Job) -> Result<(Vec<u8>, String)> {
    let mut session = Session::opening(args.device.as_deref());
    session.view(scene, &Frame::full(job.size), options)?;
    let mut film = session.film(job.size)?;
    session.render(job, &mut film, &mut ())?;
    let bytes = png::picture(job.size, &film.film.develop().rgb);
    let bytes = bytes.map_err(Error::file(&args.output, "write"))?;
    let error = film.film.verdict(NOISE_LEVEL).error.map_or("not known".to_owned(), |error| percent(error.value));
    Ok((bytes, format!("{} per pixel, relative error {error}", counted(u64::from(args.spp), "sample"))))
}
