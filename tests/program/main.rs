//! The program as its users meet it.

#[path = "../common/mod.rs"]
mod common;

mod aov;
mod bad_files;
mod cli;
mod crop;
mod denoise;
mod develop;
#[cfg(target_os = "linux")]
mod device;
#[cfg(unix)]
mod display;
#[cfg(unix)]
mod files;
mod frames;
mod gltf;
mod mattes;
#[cfg(unix)]
mod names;
#[cfg(target_os = "linux")]
mod preview;
mod resume;
mod sandbox;
#[cfg(unix)]
mod serve;
mod shells;
#[cfg(unix)]
mod signals;
mod status;
#[cfg(unix)]
mod submit;
mod tables;
mod terminal;
mod tutorial;
#[cfg(unix)]
mod watch;
mod web_page;
