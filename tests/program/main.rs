//! The program as its users meet it.

#[path = "../common/mod.rs"]
mod common;

mod bad_files;
mod cli;
mod resume;
mod terminal;
