//! Measures the trade-offs of a render's settings: seconds against noise and bias.
//!
//! Each module imports only modules of the lines above its own:
//!
//! 1. [`replicates`]: noise and bias from images with different seeds; [`pace`]: the time of a sample; [`model`]: the time to an error.
//! 2. [`sweep`]: renders all settings in rounds.
//! 3. [`truth`]: the image that the others are measured against; [`extent`]: the size of the images, and what follows for the full size.
//! 4. [`judge`]: joins these for every setting.
//! 5. [`report`]: tables, CSV, JSON and advice.
//! 6. [`page`]: the HTML page.

pub mod extent;
pub mod judge;
pub mod model;
pub mod pace;
pub mod page;
pub mod replicates;
pub mod report;
pub mod sweep;
pub mod truth;
