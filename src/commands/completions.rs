//! `gpu-rt completions`: what a shell needs to complete command lines.

use clap::CommandFactory;
use clap_complete::generate;

use super::print_text;
use crate::cli::{Cli, CompletionsArgs};
use crate::error::Result;

pub fn run(args: &CompletionsArgs) -> Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "gpu-rt", &mut script);
    print_text(&String::from_utf8_lossy(&script))
}
