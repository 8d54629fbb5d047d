//! The commands of the program, one file each.

mod changes;
mod check;
mod compare;
mod compiling;
mod completions;
mod console;
mod converge;
mod convert;
mod denoise;
mod develop;
mod devices;
mod hints;
mod man;
mod merge;
mod mix;
mod outputs;
mod page;
mod plan;
mod render;
mod requests;
mod scene;
mod serve;
mod signals;
mod status;
mod submit;
mod target;
mod tradeoff;
pub mod view;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

pub use console::{print_help, tell, tell_error};
pub use signals::catch_limits;

use crate::cli::GLTF;
use crate::error::Result;

/// A path tracer for GPUs, and for machines without one.
#[derive(Debug, Parser)]
#[command(name = "gpu-rt", version, about, max_term_width = 80)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to a linear EXR.
    Render(render::RenderArgs),
    /// Render a scene again and again: from other places, with other numbers, as requests on standard input say (JSON lines).
    Serve(serve::ServeArgs),
    /// Join renders of disjoint samples of one scene, in any order: the image is that of one render.
    Merge(merge::MergeArgs),
    /// Make a PNG of an EXR, whichever program wrote it.
    Develop(develop::DevelopArgs),
    /// Remove the noise of an EXR by Intel's Open Image Denoise, which biases the result. The EXR stays as it is.
    Denoise(denoise::DenoiseArgs),
    /// Report the progress of a render that `gpu-rt submit` shares: samples, parts, time left. It changes no file.
    Status(status::StatusArgs),
    /// Share one render among many processes or machines.
    #[command(subcommand)]
    Submit(submit::Scheduler),
    /// Measure the error of an image against a reference, and separate it from noise.
    Compare(compare::CompareArgs),
    /// Measure the trade of render's settings on a scene: seconds against noise and bias.
    Tradeoff(tradeoff::TradeoffArgs),
    /// Measure how the error falls with samples and seconds, against a reference: CSV and plot.
    Converge(converge::ConvergeArgs),
    /// Show what a scene requires: kernels, buffers and bytes, and which object asked for each.
    Plan(plan::PlanArgs),
    /// Look around in a scene in a window.
    View(view::WindowArgs),
    /// Write a scene as a page that renders itself in a browser, by WebGPU.
    Page(page::PageArgs),
    /// Validate a scene without a GPU.
    Check(check::CheckArgs),
    /// Write a glTF scene as a scene file of our own form, which renders to the same image.
    Convert(convert::ConvertArgs),
    /// List the devices, their drivers and limits.
    Devices(devices::DevicesArgs),
    /// Print what a shell needs to complete command lines.
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write the pages of all commands into a folder.
    Man(man::ManArgs),
}

/// The options of `render` that `-h` lists.
const FIRST_OPTIONS: [&str; 14] = [
    "scene", "output", "png", "spp", "noise", "time", "size", "exposure", "denoise", "preview", "watch", "resume",
    "device", "help",
];

/// The program as clap has it. `-h` lists what fits a page: the first options of `render`, and of other commands those that are not for glTF
/// alone.
fn program() -> clap::Command {
    let program = Cli::command().mut_subcommand("render", |render| {
        render
            .after_help("These are the options that matter most: `gpu-rt render --help` lists all of them.")
            .after_long_help("`gpu-rt render -h` lists the options that matter most.")
    });
    program.mut_subcommands(|command| {
        let is_render = command.get_name() == "render";
        command.mut_args(|arg| {
            let is_short = match is_render {
                true => FIRST_OPTIONS.contains(&arg.get_id().as_str()),
                false => arg.get_help_heading() != Some(GLTF),
            };
            if is_short { arg } else { arg.hide_short_help(true) }
        })
    })
}

impl Cli {
    /// Reads the command line.
    ///
    /// # Errors
    /// What is wrong with it, with a hint; or the help that it asks for.
    pub fn read() -> std::result::Result<Cli, clap::Error> {
        let matches = program().try_get_matches().map_err(hints::with_hint)?;
        Cli::from_arg_matches(&matches)
    }
}

/// Runs the command.
pub fn run(cli: &Cli, start: std::time::Instant) -> Result<()> {
    match &cli.command {
        Command::Render(args) => render::run(args, start),
        Command::Serve(args) => serve::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Develop(args) => develop::run(args),
        Command::Denoise(args) => denoise::run(args),
        Command::Status(args) => status::run(args),
        Command::Submit(submit::Scheduler::Slurm(args)) => submit::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Converge(args) => converge::run(args),
        Command::Plan(args) => plan::run(args),
        Command::View(args) => view::run(args),
        Command::Page(args) => page::run(args),
        Command::Check(args) => check::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Tradeoff(args) => tradeoff::run(args, start),
        Command::Devices(args) => devices::run(args),
        Command::Completions(args) => completions::run(args, program()),
        Command::Man(args) => man::run(args, program()),
    }
}
