//! `gpu-rt submit`: shares one render among many processes.

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use clap::{Args, Subcommand};

use super::console::print_line;
use super::outputs::{check_name, make_folder};
use super::scene::{load, size_of};
use crate::cli::{CHECKPOINT, GltfArgs, ImageArgs, PathArgs, SceneArgs, duration, relative_error};
use crate::cluster::scripts::{line, text_of};
use crate::cluster::slurm::{Ids, Slurm, forget_tries};
use crate::cluster::{ClusterRequest, FORMAT, Folder, MERGE, RENDER, split};
use crate::error::{Error, Result};
use crate::job::MOST_SAMPLES;
use crate::options::RenderOptions;
use crate::output::exr::{Attribute, attribute, read_attributes, read_state};
use crate::printable::counted;
use crate::render::LAST_CHECK;
use crate::scene::{Scene, Sky, Thin};

/// Who runs the processes.
#[derive(Debug, Subcommand)]
pub enum Scheduler {
    /// Share it through Slurm: write a folder with the scene and scripts, submit an array of tasks that render, and a job that joins their images.
    Slurm(SlurmArgs),
}

#[derive(Debug, Args)]
pub struct SlurmArgs {
    /// The scene file. It is copied, and so are the files that it names by relative paths.
    #[arg(required_unless_present_any = ["missing", "next"])]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub gltf: GltfArgs,
    #[command(flatten)]
    pub image: ImageArgs,
    /// Render until the relative error is below this with 95 % confidence, in rounds that double the samples, limited by --spp if
    /// given.
    #[arg(long, value_name = "E", value_parser = relative_error)]
    pub noise: Option<f64>,
    /// The parts that the samples are split into: at most one for 8 samples.
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=1_000_000), required_unless_present_any = ["missing", "next"])]
    pub parts: Option<u32>,
    /// The folder, which all machines must see; created if missing [default: SCENE-job].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Submit the parts of this folder whose images lack samples, and the join after them.
    #[arg(long, value_name = "DIR", conflicts_with_all = of_a_new_folder().chain(["next"]))]
    pub missing: Option<PathBuf>,
    /// Submit the next round of this folder, unless the error is reached. The job that joins does it.
    #[arg(long, value_name = "DIR", conflicts_with_all = of_a_new_folder())]
    pub next: Option<PathBuf>,
    /// Write the folder and print what would be submitted.
    #[arg(long)]
    pub dry_run: bool,
    #[command(flatten)]
    pub paths: PathArgs,
    /// Write the images of parts so far at this interval [30s, 5m, …].
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = CHECKPOINT)]
    pub checkpoint: Duration,
    /// Allow several devices or drivers, whose rounding may differ.
    #[arg(long)]
    pub mixed_drivers: bool,
    #[command(flatten)]
    pub options: RenderOptions,
    /// Options of sbatch.
    #[arg(last = true, value_name = "SBATCH OPTION")]
    pub sbatch: Vec<String>,
}

/// The arguments of `submit` that a folder has already.
fn of_a_new_folder() -> impl Iterator<Item = &'static str> {
    let own = [
        "scene",
        "camera",
        "sky",
        "sun",
        "watts",
        "thin",
        "frame",
        "fps",
        "spp",
        "noise",
        "parts",
        "output",
        "size",
        "checkpoint",
        "mixed_drivers",
    ];
    own.into_iter().chain(["max_depth", "seed", "device"]).chain(RenderOptions::names())
}

/// Bytes of a pixel in an EXR with its state: 14 of a sample, 60 to 73 of 256 and 84 of 16,384 samples were measured, on several scenes.
const PIXEL_BYTES: f64 = 80.0;

/// Writes or reads the folder, and submits what it lacks.
pub fn run(args: &SlurmArgs) -> Result<()> {
    args.scene.iter().try_for_each(|path| check_name(path, "a scene file, which is copied"))?;
    let folders = [&args.output, &args.missing, &args.next];
    folders.into_iter().flatten().try_for_each(|path| check_name(path, "a folder"))?;
    let slurm = Slurm::find(args.dry_run)?;
    let folder = match (&args.scene, &args.missing, &args.next) {
        (Some(scene), ..) => new_folder(args, scene)?,
        (None, Some(path), _) => read(path, args)?,
        (None, None, Some(path)) => match next_round(read(path, args)?)? {
            Some(folder) => folder,
            None => return Ok(()),
        },
        (None, None, None) => return Err(Error::Usage("a scene is missing".to_string())),
    };
    let lost = |error| Error::file("gpu-rt", "run")(format!("the program does not know where it is: {error}"));
    let program = std::env::current_exe().map_err(lost)?;
    // A part is of the task that is its number modulo the number of tasks.
    let all = folder.request.parts.len() as u32;
    let tasks = all.min(slurm.most_tasks);
    let missing = folder.missing()?;
    let mut needed: Vec<u32> = missing.iter().map(|part| part % tasks).collect();
    needed.sort_unstable();
    needed.dedup();
    folder.write_scripts(&program, tasks)?;
    folder.write()?;
    forget_tries(&folder.path, &needed);

    print_line(&format!("folder: {}", folder.path.display()))?;
    let samples = missing.iter().filter_map(|part| folder.parts().nth(*part as usize)).map(|part| part.len() as u64);
    print_line(&format!(
        "parts: {} of {all}, {}, in {}",
        missing.len(),
        counted(samples.sum(), "sample"),
        counted(needed.len() as u64, "task")
    ))?;
    let pixels = f64::from(folder.request.width) * f64::from(folder.request.height);
    print_line(&format!("disk: {} for all parts and the image", bytes(pixels * PIXEL_BYTES * f64::from(all + 1))))?;
    match slurm.submit(&folder, &needed, &mut print_line)? {
        Some(Ids { array, merge }) => {
            array.map_or(Ok(()), |id| print_line(&format!("array: {id}")))?;
            print_line(&format!("merge: {merge}"))
        }
        None => {
            let indices: Vec<String> = needed.iter().map(u32::to_string).collect();
            let indices = match needed.len() as u32 == tasks {
                true => format!("seq 0 {}", tasks - 1),
                false => format!("printf '%s\\n' {}", indices.join(" ")),
            };
            let rendering = match needed.is_empty() {
                true => String::new(),
                false => format!("{indices} | parallel -j 1 ./{RENDER} && "),
            };
            let at = line(&[text_of(&folder.path)?.to_string()]);
            print_line(&format!("here: cd {at} && {rendering}./{MERGE}"))
        }
    }
}

/// The folder, with its absolute path and the new options of sbatch.
fn read(path: &Path, args: &SlurmArgs) -> Result<Folder> {
    let mut folder = Folder::read(&absolute(path)?)?;
    if !args.sbatch.is_empty() {
        folder.request.sbatch = args.sbatch.clone();
    }
    Ok(folder)
}

/// A path from the root, without `.` and `..`.
fn absolute(path: &Path) -> Result<PathBuf> {
    let mut absolute = PathBuf::new();
    for component in std::path::absolute(path).map_err(Error::file(path, "read"))?.components() {
        match component {
            Component::ParentDir => _ = absolute.pop(),
            Component::CurDir => {}
            other => absolute.push(other),
        }
    }
    Ok(absolute)
}

/// Makes the folder with the copy of the scene.
fn new_folder(args: &SlurmArgs, scene_path: &Path) -> Result<Folder> {
    let scene = load(&SceneArgs { path: scene_path.to_owned(), gltf: args.gltf.clone() })?;
    let stem = text_of(Path::new(scene_path.file_stem().unwrap_or_default()))?;
    let (width, height) = size_of(&scene, args.image.size);
    let spp = args.image.spp.unwrap_or(scene.render.samples);
    let most = args.noise.map(|_| args.image.spp.unwrap_or(MOST_SAMPLES as u32));
    let all = 0..most.unwrap_or(spp);
    let count = args.parts.unwrap_or(1);
    if count > split::runs(&all) {
        let runs = split::runs(&all);
        return Err(Error::Usage(format!(
            "--parts {count}: {} samples are {runs} runs of 8, and a part has one at least. Give --parts {runs} at most",
            all.end
        )));
    }
    let parts = match most {
        Some(most) => split::round(0, most, count),
        None => split::even(&all, count),
    };
    let path = match &args.output {
        Some(path) => path.clone(),
        None => PathBuf::from(format!("{stem}-job")),
    };
    let path = absolute(&path)?;
    text_of(&path)?;
    let (copied, fixed) = files_of(&scene)?;
    if fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(Error::Usage(format!(
            "{}: it is not empty. Give another folder with -o, or go on with `gpu-rt submit slurm --missing`",
            path.display()
        )));
    }
    let undone = "nothing has been submitted";
    make_folder(&path, undone)?;
    let copy = |from: &Path, to: &Path| -> Result<()> {
        make_folder(to.parent().unwrap_or(&path), undone)?;
        let failed = |error| Error::file(from, "copy")(format!("{error}; {undone}"));
        fs::copy(from, to).map(|_| ()).map_err(failed)
    };
    for (from, to) in &copied {
        copy(from, &path.join(to))?;
    }
    for fixed in &fixed {
        print_line(&format!("not copied, because the scene names it by its absolute path: {}", fixed.display()))?;
    }
    let request = ClusterRequest {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene: copied.first().map(|(_, to)| to.clone()).unwrap_or_default(),
        output: format!("{stem}.exr").into(),
        samples: [0, parts.last().map_or(0, |part| part.end)],
        noise: args.noise,
        most,
        parts: parts.iter().map(|part| [part.start, part.end]).collect(),
        round: most.map(|_| count),
        width,
        height,
        options: words_of(args, (width, height))?,
        sbatch: args.sbatch.clone(),
    };
    Ok(Folder { path, request })
}

/// The options of each part, as words of the command line.
fn words_of(args: &SlurmArgs, (width, height): (u32, u32)) -> Result<Vec<String>> {
    let mut words = Vec::new();
    let absolute_unless_word =
        |path: &PathBuf| if Sky::of_word(path).is_some() { Ok(path.clone()) } else { absolute(path) };
    let sky = args.gltf.sky.as_ref().map(absolute_unless_word).transpose()?;
    let sky = sky.map(|path| text_of(&path).map(str::to_string)).transpose()?;
    let mut add =
        |name: &str, value: Option<String>| words.extend(value.into_iter().flat_map(|value| [name.to_string(), value]));
    add("--camera", args.gltf.camera.clone());
    add("--sky", sky);
    add("--size", args.image.size.map(|_| format!("{width}x{height}")));
    add("--max-depth", args.paths.max_depth.map(|depth| depth.to_string()));
    add("--seed", (args.paths.seed != 0).then(|| args.paths.seed.to_string()));
    add("--device", args.paths.device.clone());
    let is_default = duration(CHECKPOINT) == Ok(args.checkpoint);
    add("--checkpoint", (!is_default).then(|| args.checkpoint.as_secs_f64().to_string()));
    words.extend(args.gltf.sun.map(|(elevation, azimuth)| format!("--sun={elevation},{azimuth}")));
    words.extend(args.gltf.watts.map(|watts| format!("--watts={}", if watts { "on" } else { "off" })));
    words.extend((args.gltf.thin == Thin::Pane).then(|| "--thin=pane".to_string()));
    words.extend(args.gltf.frame.map(|frame| format!("--frame={frame}")));
    words.extend(args.gltf.fps.map(|fps| format!("--fps={fps}")));
    words.extend(args.gltf.define.iter().map(|(name, value)| format!("-D{name}={value}")));
    words.extend(args.gltf.lossless.then(|| "--lossless".to_string()));
    words.extend(args.options.words());
    words.extend(args.mixed_drivers.then(|| "--mixed-drivers".to_string()));
    Ok(words)
}

/// Files, each with the path of its copy.
type Copies = Vec<(PathBuf, PathBuf)>;

/// The files of a scene that are copied, and those that stay where they are. The first have their paths in the folder: the tree is that below the
/// folder which they have in common. The scene file is the first.
fn files_of(scene: &Scene) -> Result<(Copies, Vec<PathBuf>)> {
    let (fixed, moved): (Vec<_>, Vec<_>) = scene.input_files().into_iter().partition(|input| input.fixed);
    let mut absolute_paths = Vec::new();
    for input in &moved {
        text_of(&input.path)?;
        if !input.path.is_file() {
            return Err(Error::Usage(format!("{}: expected a file, which can be copied", input.path.display())));
        }
        absolute_paths.push(absolute(&input.path)?);
    }
    let mut common = absolute_paths.first().and_then(|path| path.parent()).unwrap_or(Path::new("")).to_owned();
    while !absolute_paths.iter().all(|path| path.starts_with(&common)) && common.pop() {}
    let to = |path: &PathBuf| Path::new("scene").join(path.strip_prefix(&common).unwrap_or(path));
    let copied = moved.into_iter().map(|input| input.path).zip(absolute_paths.iter().map(to)).collect();
    Ok((copied, fixed.into_iter().map(|input| input.path).collect()))
}

/// The folder with the parts of its next round; nothing where nothing is left to do, which is said.
fn next_round(mut folder: Folder) -> Result<Option<Folder>> {
    let (Some(noise), Some(most)) = (folder.request.noise, folder.request.most) else {
        return Err(Error::Usage(format!(
            "{}: it has no rounds, because it was submitted without --noise",
            folder.path.display()
        )));
    };
    let output = folder.output();
    let name = output.display();
    let state = if output.exists() { read_state(&output)? } else { None };
    let Some(state) = state else {
        return Err(Error::Usage(format!("{name} is not there: {MERGE} joins the parts before the next round")));
    };
    let attributes = read_attributes(&output)?;
    let reached = attribute(&attributes, "gpu-rt:noise_reached") == Some(&Attribute::Int(1));
    let unbounded = attribute(&attributes, "gpu-rt:relative_error_bound").is_none();
    let (done, requested) = (state.samples.range().end, folder.request.samples[1]);
    let samples = state.samples.count();
    if reached {
        print_line(&format!("{name}: --noise {noise} is reached with {samples} samples"))?;
    } else if unbounded && samples >= u64::from(LAST_CHECK) {
        print_line(&format!("{name}: nothing bounds the error after {samples} samples, so that it cannot be reached"))?;
    } else if done < requested {
        return Err(Error::Usage(format!(
            "{name} has {done} of {requested} samples that have been submitted: {MERGE} joins the parts before the next round"
        )));
    } else if requested >= most {
        print_line(&format!(
            "{name}: --noise {noise} is not reached with {samples} samples, the most that were asked for"
        ))?;
    } else {
        let parts = split::round(requested, most, folder.request.round.unwrap_or(1).max(1));
        folder.request.samples[1] = parts.last().map_or(requested, |part| part.end);
        folder.request.parts.extend(parts.iter().map(|part| [part.start, part.end]));
        return Ok(Some(folder));
    }
    Ok(None)
}

/// A number of bytes, in words.
fn bytes(count: f64) -> String {
    let units = ["bytes", "kB", "MB", "GB", "TB"];
    let power = (0..units.len() - 1).take_while(|power| count >= 1000f64.powi(*power as i32 + 1)).count();
    format!("{:.*} {}", usize::from(power > 0), count / 1000f64.powi(power as i32), units[power])
}
