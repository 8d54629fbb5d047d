//! The program as its users meet it.

#[path = "../common/mod.rs"]
mod common;

mod bad_files;
mod cli;
#[cfg(unix)]
mod files;
mod place;
mod resume;
#[cfg(unix)]
mod signals;
mod terminal;
