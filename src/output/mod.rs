pub mod atomic;
pub mod csv;
pub mod exr;
mod magma;
pub mod plot;
pub mod png;
pub mod progress;
