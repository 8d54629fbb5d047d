//! Measuring what a render's settings trade: seconds against noise and bias, setting by setting, beside each other.
//!
//! [`sweep`] renders images of a size that [`extent`] finds; [`replicates`] says what they tell of each other, [`truth`] what they are measured
//! against, [`pace`] how long they took, [`model`] what follows for the time to an error. [`judge`] joins these for all settings, and
//! [`report`] and [`page`] say it.

pub mod extent;
pub mod judge;
pub mod model;
pub mod pace;
pub mod page;
pub mod replicates;
pub mod report;
pub mod sweep;
pub mod truth;
