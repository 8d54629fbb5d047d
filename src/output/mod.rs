pub mod atomic;
pub mod exr;
pub mod png;
pub mod progress;
