//! The window of `gpu-rt view`: what its widgets do, and a real one on a display.

#[path = "../common/mod.rs"]
mod common;

mod build;
mod display;
mod panel;
