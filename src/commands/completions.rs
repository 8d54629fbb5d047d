//! `gpu-rt completions`: what a shell needs to complete command lines.

use clap::{Args, Command};
use clap_complete::generate;

use super::console::print_text;
use crate::error::Result;

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: clap_complete::Shell,
}

/// Prints the script for a shell.
pub fn run(args: &CompletionsArgs, mut program: Command) -> Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut program, "gpu-rt", &mut script);
    print_text(&String::from_utf8_lossy(&script))
}
