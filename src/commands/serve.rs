//! `gpu-rt serve`: renders one scene again and again, as requests on standard input say. The device with its kernels, textures, and meshes
//! with their hierarchies stay from one to the next. An answer is a JSON object in a line of standard output.

use std::io::stdin;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};

use super::console::{path_text, write_stdout};
use super::render::args::{GoalArgs, KeepArgs, MessageArgs, host_and_port};
use super::render::{RenderArgs, Reported, Series, render};
use super::requests::{Request, Requests};
use super::scene::{frame_of, load_from, size_of};
use super::signals::Signals;
use crate::aov::{Aov, Aovs};
use crate::cli::{ImageArgs, PathArgs, SceneArgs};
use crate::error::{Error, Location, Result};
use crate::job::MOST_SAMPLES;
use crate::options::RenderOptions;
use crate::output::destination::is_standard;
use crate::scene::{Assets, Camera, Change, Scene, is_gltf};

#[derive(Clone, Debug, Args)]
pub struct ServeArgs {
    /// - is a .ron whose text is a JSON string in the first line of standard input.
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    image: ImageArgs,
    #[command(flatten)]
    paths: PathArgs,
    #[command(flatten)]
    options: RenderOptions,
    /// Leave out of the EXR what --resume and `merge` need.
    #[arg(long)]
    no_state: bool,
    /// Print errors only.
    #[arg(long)]
    quiet: bool,
    /// A folder of images to remove if the parent process ends before the requests do.
    #[arg(long, value_name = "FOLDER", hide = true)]
    temporary: Option<PathBuf>,
}

/// Answers requests up to the last one, until a signal comes or the device is lost.
pub fn run(args: &ServeArgs) -> Result<()> {
    let text = is_standard(&args.scene.path).then(text).transpose()?.unwrap_or_default();
    let signals = Signals::listen("nothing has been written");
    let requests = Requests::listen(&signals, args.temporary.clone())?;
    let mut server = Server::open(args.clone(), &text, signals.clone())?;
    let scene = &server.scene;
    let materials: Vec<&String> = scene.materials.iter().map(|(name, _)| name).collect();
    let (image, size) = ((scene.image.width, scene.image.height), size_of(scene, server.args.goal.image.size));
    let Camera { look_from, look_at, aperture, focus_distance, .. } = scene.camera;
    let focus = (aperture > 0.0).then(|| focus_distance.unwrap_or((look_at - look_from).length()));
    let names = scene.object_names();
    let opened = json!({"objects": names, "materials": materials, "image": image, "size": size, "focus": focus});
    write_stdout(&format!("{opened}\n"))?;
    while let Some(request) = requests.next() {
        let rendered = request.and_then(|request| server.render(&request));
        let lost = server.series.session.devices.iter().find_map(|device| device.check().err());
        write_stdout(&format!("{}\n", server.answer(rendered, lost.is_some())))?;
        if let Some(error) = lost.filter(|_| !signals.have_come()) {
            return Err(error);
        }
    }
    match signals.have_come() {
        true => Err(signals.interrupted("the session ends")),
        false => Ok(()),
    }
}

struct Server {
    args: RenderArgs,
    scene: Scene,
    /// The frame that a glTF file was read for, and whether those around it were. In a scene file, frames move the shutter.
    read: (Option<f64>, bool),
    series: Series,
}

impl Server {
    fn open(args: ServeArgs, text: &str, signals: Signals) -> Result<Server> {
        let quiet = args.quiet;
        let args = args.into_render();
        let mut series = Series::new(&args);
        (series.session, series.assets) = (series.session.keeping_hierarchies(), Assets::of_frames());
        (series.frames, series.quiet, series.signals) = (Some(Reported::default()), quiet, Some(signals));
        let read = read_for(&args);
        let scene = load(&args, read, text, &mut series.assets)?;
        Ok(Server { args, scene, read, series })
    }

    fn render(&mut self, request: &Request) -> Result<()> {
        let (start, mut args) = (Instant::now(), self.args.clone());
        args.files.output = Some(request.output.clone());
        args.paths.seed = request.seed.unwrap_or(args.paths.seed);
        args.goal.image.spp = request.spp.or(args.goal.image.spp);
        if !args.goal.image.spp.is_none_or(|spp| (1..=MOST_SAMPLES).contains(&i64::from(spp))) {
            return Err(Error::Usage(format!("spp: expected a number of samples from 1 to {MOST_SAMPLES}")));
        }
        let wrong = |field: &'static str| move |reason: String| Error::Usage(format!("{field}: {reason}"));
        if let Some(words) = &request.aov {
            args.options.aov.set(Aovs::parse(words).map_err(wrong("aov"))?);
        }
        if let Some(size) = &request.size {
            args.goal.image.size = Some(size.parse().map_err(wrong("size"))?);
        }
        if let Some(address) = &request.display {
            args.viewers.display_server = Some(host_and_port(address).map_err(wrong("display"))?);
        }
        args.options.aov.complete(is_gltf(&args.scene.path));
        args.scene.gltf.frame = request.frame.or(args.scene.gltf.frame);
        let read = read_for(&args);
        if read != self.read {
            (self.scene, self.read) = (load(&args, read, "", &mut self.series.assets)?, read);
        }
        let (objects, materials) = (request.objects.as_ref(), request.materials.as_ref());
        let mut scene = self.scene.changed(&Change { camera: request.camera.as_deref(), objects, materials })?;
        if !is_gltf(&args.scene.path) {
            scene = scene.in_frame(frame_of(&args.scene.gltf, &args.scene.path)?);
        }
        render(&args, &scene, &mut self.series, start)
    }

    /// The answer to a request. A device that is lost ends the session.
    fn answer(&mut self, rendered: Result<()>, lost: bool) -> Value {
        let report = self.series.frames.as_mut().and_then(|reported| reported.reports.pop());
        let error = rendered.err().map(|error| {
            let faults: Vec<Value> = error.each().iter().filter_map(fault).collect();
            let interrupted = matches!(error, Error::Interrupted { .. });
            json!({"message": error.messages().join("\n"), "faults": faults, "interrupted": interrupted, "lost": lost})
        });
        json!({"report": report, "error": error})
    }
}

fn read_for(args: &RenderArgs) -> (Option<f64>, bool) {
    match is_gltf(&args.scene.path) {
        true => (args.scene.gltf.frame, args.options.aov.has(Aov::Motion)),
        false => (None, false),
    }
}

fn load(args: &RenderArgs, (frame, motion): (Option<f64>, bool), text: &str, assets: &mut Assets) -> Result<Scene> {
    let mut scene = args.scene.clone();
    scene.gltf.frame = frame;
    load_from(&scene, motion, text.as_bytes(), &mut |_, _, _| {}, assets)
}

fn fault(error: &Error) -> Option<Value> {
    let Error::Scene { location: Location { file, line, column }, field, message } = error else { return None };
    Some(json!({"file": path_text(file), "line": line, "column": column, "field": field, "message": message}))
}

impl ServeArgs {
    /// The arguments of a render without its output.
    fn into_render(self) -> RenderArgs {
        let ServeArgs { scene, image, paths, options, no_state, .. } = self;
        RenderArgs {
            goal: GoalArgs { image, ..GoalArgs::default() },
            keep: KeepArgs { checkpoint: Duration::from_secs(60), no_state, force: true, ..KeepArgs::default() },
            messages: MessageArgs { quiet: true, json: true, ..MessageArgs::default() },
            ..RenderArgs { scene, paths, options, ..RenderArgs::default() }
        }
    }
}

/// The scene's text in the first line.
fn text() -> Result<String> {
    let mut line = String::new();
    stdin().read_line(&mut line).map_err(Error::file("stdin", "read"))?;
    let expected = |error| Error::Usage(format!("the first line: expected the scene's text as a JSON string: {error}"));
    serde_json::from_str(&line).map_err(expected)
}
