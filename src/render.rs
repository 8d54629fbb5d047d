//! The render loop of a device: generate → { { intersect → scatter → refill } … → accumulate } …
//!
//! Three things decide what is rendered next: [`goals`] how many samples, one [`sample_range`] after another; the sample range which device
//! gets which blocks of samples; and the [`tiles`] how many blocks a device takes at a time, and for which pixels.

mod device;
mod goals;
mod outcome;
mod renderer;
mod sample_range;
mod tiles;
mod watch;

pub use goals::{FIRST_LOOK, LAST_LOOK, look_after, look_at};
pub use outcome::{NOISE_LEVEL, Noise, Outcome, level_after};
pub use renderer::{Renderer, empty_film};
pub use watch::{Next, Snapshot, Watch};
