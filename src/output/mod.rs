pub mod atomic;
pub mod exr;
pub mod plot;
pub mod png;
pub mod progress;
