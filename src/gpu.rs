//! The host's code for the device: adapters, linked shaders, pipelines and buffers. Nothing here knows scenes.

pub mod buffers;
pub mod compile_beside;
pub mod compile_progress;
pub mod device;
pub mod kernel_cache;
mod kinds;
pub mod layout;
pub mod link;
pub mod modules;
pub mod numerics;
pub mod pipeline;
pub mod probe;
mod reach;
pub mod spirv;
pub mod timing;
pub mod unseen;
pub mod vocabulary;
pub mod when;
