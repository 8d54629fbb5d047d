//! Renders on a device, stage by stage ([`device`]). Each stage is a kernel of shaders/stage:
//!
//! 1. `generate`: every slot gets a run of samples, and the ray of its first camera path.
//! 2. Bounces, each of these stages, or all of them and several bounces in one kernel, `bounce`:
//!    1. `intersect`: the nearest hit of each ray.
//!    2. `medium`: media scatter paths before their hits. `dispatch`: the sizes of the material queues.
//!    3. `scatter`: paths are scattered by material. `shadow`: the light along shadow rays.
//!    4. `refill`: ended paths join their runs, and their slots get new ones.
//! 3. `truth`, if it is asked for: what sample 0 of each pixel sees is stored. `accumulate`: finished runs are added to the film.
//!
//! Three things decide what is rendered next: [`goals`] how many samples, one [`sample_range`] after another; the sample range which device
//! gets which blocks of samples; and the [`tiles`] how many blocks a device takes at a time, and for which pixels.

mod accumulation;
mod device;
mod goals;
mod noise;
mod observer;
mod outcome;
mod renderer;
mod sample_range;
mod tiles;

pub use noise::{FIRST_CHECK, LAST_CHECK, NOISE_LEVEL, Noise, check_error, level_after, samples_at_check};
pub use observer::{Next, Observer, Snapshot, following, stopping};
pub use outcome::Outcome;
pub use renderer::{Renderer, empty_film};
