//! `gpu-rt man`: the manual pages.

use std::io;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::console::print_text;
use super::outputs::make_folder;
use crate::error::{Error, Result};
use crate::output::atomic;

#[derive(Debug, Args)]
pub struct ManArgs {
    /// The folder for a page of each command; created if missing.
    pub folder: Option<PathBuf>,
}

/// Prints the page of the program, or writes the pages of all its commands.
pub fn run(args: &ManArgs, program: Command) -> Result<()> {
    let mut program = program.disable_help_subcommand(true);
    // The commands take the program's name before their own.
    program.build();
    let failed = |error: io::Error| Error::Usage(format!("the manual page cannot be made: {error}"));
    let Some(folder) = &args.folder else {
        return print_text(&String::from_utf8_lossy(&page(program).map_err(failed)?.1));
    };
    make_folder(folder, "no page has been written")?;
    for command in with_commands(program) {
        let (name, text) = page(command).map_err(failed)?;
        atomic::write(&folder.join(name), &text)?;
    }
    Ok(())
}

/// The command, and those below it that help lists.
fn with_commands(command: Command) -> Vec<Command> {
    let below: Vec<Command> = command.get_subcommands().filter(|below| !below.is_hide_set()).cloned().collect();
    std::iter::once(command).chain(below.into_iter().flat_map(with_commands)).collect()
}

/// The name and the text of a page.
fn page(command: Command) -> io::Result<(String, Vec<u8>)> {
    let page = Man::new(command);
    let mut text = Vec::new();
    page.render(&mut text)?;
    Ok((page.get_filename(), text))
}
