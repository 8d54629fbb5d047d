//! `gpu-rt completions`: what a shell needs to complete command lines.

use clap::{Args, CommandFactory};
use clap_complete::generate;

use super::{Cli, print_text};
use crate::error::Result;

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: clap_complete::Shell,
}

pub fn run(args: &CompletionsArgs) -> Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "gpu-rt", &mut script);
    print_text(&String::from_utf8_lossy(&script))
}
